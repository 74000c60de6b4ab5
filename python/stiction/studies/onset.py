"""How a measured pair begins to slide: the mean over some of its members, kept as a small file beside the result."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction.mechanics.presliding import fitted_iwan, fitted_lugre
from stiction.studies.at_load import OverMembers
from stiction.studies.members import bodies_of
from stiction.studies.one_load import OneLoad
from stiction.studies.result import measured
from stiction.studies.slip_map import slip_map
from stiction.studies.store import read_beside
from stiction.studies.study import Study
from stiction.studies.tables import MeasuredFriction

if TYPE_CHECKING:
    import xarray

    from stiction.studies.store import Stored

FILE = "onset.nc"
"""Name of the file in the folder of a result."""

TABLE = "onset.csv"
"""The curve as a table: the backbone of a Masing model."""

MEMBERS, FEW = 16, 4
"""Whose onset is computed, unless another number is asked for; of areas by the half-space a few."""

FRACTIONS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)
"""Of the sliding load."""

POISSON_RATIO = 0.3
"""Of both bodies, where nothing is known of them."""

_CURVES = {
    "tangential_load": ("mN", "tangential load"),
    "displacement": ("um", "displacement of the upper body since the tangential load was 0"),
    "slipped_area": ("1", "fraction of the true contact area that slips"),
    "slipped_load": ("1", "fraction of the normal load on what slips"),
    "energy_lost": ("mN um", "energy that a cycle between plus and minus this load takes"),
}

_NUMBERS = {
    "sliding_load": ("mN", "tangential load at which all slips"),
    "displacement_at_sliding": ("um", "creep before sliding"),
    "stiffness": ("mN/um", "tangential stiffness at rest"),
}

_STATISTICS = ["mean", "lower", "upper"]


def onset_of_result(
    study: Study, executor: Executor, *, members: int | None = None, load: float | None = None
) -> xarray.Dataset | None:
    """How the members of a measured pair begin to slide at the first load of its study, or another (mN), mu0 and tau0.

    So many of its members, the first ones, are computed: 16 by default, 4 of areas by the half-space. The dataset has
    over fraction (of the sliding load) and statistic (mean, lower, upper) tangential_load, displacement, slipped_area,
    slipped_load and energy_lost, over statistic sliding_load, displacement_at_sliding and stiffness, and of areas the
    map of what slips first of the first member, see `slip_map`. Its attributes say load, mu0, tau0 and how many members
    there are, and have the parameters of the Iwan and LuGre models of the mean curve. None of generated bodies, where
    nothing holds the bodies, and where no member has an answer.
    """
    if not study.is_measured:
        return None
    assert isinstance(study.friction, MeasuredFriction)
    mu0, tau0 = float(study.friction.mu0[0]), float(study.friction.tau0[0])
    if mu0 == tau0 == 0:
        return None
    load = float(study.friction.load[0]) if load is None else load
    surfaces = measured(study)
    first = surfaces.first_scanned
    first = first if first < study.ensemble.repetitions else 0
    few = surfaces.is_areal and study.by_half_space
    wanted = (FEW if few else MEMBERS) if members is None else members
    indices = range(first, min(first + wanted, study.ensemble.repetitions))
    of_member = partial(onset_of_member, study, load=load, mu0=mu0, tau0=tau0)
    found = [each for each in executor.map(of_member, indices) if each]
    if not found:
        return None
    onset = _over_members(study, found, {"load_mN": load, "mu0": mu0, "tau0_GPa": tau0})
    return onset.assign(found[0]["map"])


def onset_of_member(study: Study, index: int, *, load: float, mu0: float, tau0: float) -> dict[str, Any] | None:
    """The curve of one member as arrays by name, and what the member is; None where it has no answer."""
    member = bodies_of(study).member(index, float(study.surfaces.cells()["cut_off"][0]))
    poisson = study.contact.poisson_ratio or (POISSON_RATIO, POISSON_RATIO)
    try:
        pressed = OneLoad.of(study, member.pair, load)
        if pressed is None:
            return None
        onset = pressed.curve.onset(0, mu0=mu0, tau0=tau0, steps=FRACTIONS, poisson=poisson)
    except (RuntimeError, ValueError):  # no solution, or a law that has no onset
        return None
    found: dict[str, Any] = {
        name: getattr(onset, name) for name in (*_CURVES, *_NUMBERS) if name != "energy_lost"
    }  # fmt: skip
    return found | {
        "energy_lost": onset.energy_lost(onset.tangential_load), "line": member.line, "x": member.x, "y": member.y,
        "map": slip_map(pressed, onset),
    }  # fmt: skip


# ---- Over members ----------------------------------------------------------------------------------------------------


def _over_members(study: Study, found: Sequence[dict[str, Any]], about: dict[str, Any]) -> xarray.Dataset:
    import xarray

    members = OverMembers.of(study, {name: [each[name] for each in found] for name in ("line", "x", "y")})
    variables: dict[str, Any] = {}
    for name, (unit, words) in (_CURVES | _NUMBERS).items():
        dims = ("fraction", "statistic") if name in _CURVES else ("statistic",)
        values = members.mean(np.array([each[name] for each in found]))
        if name.startswith("slipped"):
            values = np.where(np.isnan(values), values, np.clip(values, 0.0, 1.0))
        variables[name] = (dims, values, {"units": unit, "long_name": words})
    coordinates: dict[str, Any] = {
        "fraction": ("fraction", list(FRACTIONS), {"units": "1", "long_name": "tangential over sliding load"}),
        "statistic": _STATISTICS,
    }
    ratios = study.contact.poisson_ratio
    about = about | {
        "members": len(found), "mechanics": study.contact.mechanics,
        "poisson_ratio": np.array(ratios or (POISSON_RATIO, POISSON_RATIO)), "poisson_given": int(ratios is not None),
    }  # fmt: skip
    dataset = xarray.Dataset(variables, coordinates, {"title": "onset of sliding", **about})
    return dataset.assign_attrs(_models(dataset))


def _models(onset: xarray.Dataset) -> dict[str, float]:
    """Parameters of the four-parameter Iwan model and of LuGre's bristles of the mean curve, where it has them."""
    curve = onset.sel(statistic="mean")
    way, load = (np.asarray(curve[name].values) for name in ("displacement", "tangential_load"))
    sliding = float(curve["sliding_load"])
    try:
        iwan = fitted_iwan(way, load, sliding_load=sliding, stiffness=float(curve["stiffness"]))
        lugre = fitted_lugre(way, load, sliding_load=sliding)
    except ValueError:  # a free half-plane has no displacements
        return {}
    return {
        "iwan_sliding_load_mN": sliding,
        "iwan_stiffness_mN_per_um": iwan.stiffness,
        "iwan_chi": round(iwan.chi, 12) + 0.0,  # 0 where it is at its bound
        "iwan_beta": iwan.beta,
        "iwan_largest_residual": float(np.abs(iwan.residual).max() / sliding),
        "lugre_sigma0_mN_per_um": lugre.stiffness,
        "lugre_largest_residual": float(np.abs(lugre.residual).max() / sliding),
    }


# ---- Beside a result -------------------------------------------------------------------------------------------------


def onset_beside(result: Stored) -> xarray.Dataset | None:
    """The onset that lies beside a stored result, if there is one of its first load, mu0 and tau0.

    Raises a `StoreError` if it is damaged.
    """
    friction = result.study.friction
    if not isinstance(friction, MeasuredFriction):
        return None
    onset = read_beside(Path(result.path) / FILE, ("fraction", "statistic", *_NUMBERS, *_CURVES))
    if onset is None or onset["fraction"].values.tolist() != list(FRACTIONS):
        return None
    of = [float(onset.attrs[name]) for name in ("load_mN", "mu0", "tau0_GPa")]
    return onset if of == [float(each[0]) for each in (friction.load, friction.mu0, friction.tau0)] else None


def backbone(onset: xarray.Dataset) -> str:
    """The mean curve from rest on as CSV, each column with its unit: the backbone of a Masing model."""
    import pandas

    columns: dict[str, Any] = {"fraction of the sliding load": [0.0, *onset["fraction"].values]}
    for name, (unit, _) in _CURVES.items():
        title = name.replace("_", " ") + ("" if unit == "1" else f" ({unit})")
        for statistic, more in (("mean", ""), ("lower", ": lower"), ("upper", ": upper")):
            columns[title + more] = [0.0, *onset[name].sel(statistic=statistic).values]
    text: str = pandas.DataFrame(columns).to_csv(index=False, float_format="%.9g")
    return text
