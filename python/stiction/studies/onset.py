"""How a measured pair begins to slide: the mean over some of its members, kept as a small file beside the result."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.mechanics.half_space import HalfSpaceCurve
from stiction.mechanics.presliding import fit_iwan, fit_lugre
from stiction.mechanics.quantities import QUANTITIES, attributes_of
from stiction.studies.contact_picture import MAX_PICTURE_SIZE
from stiction.studies.evaluation import OverMembers
from stiction.studies.executors import use_idle_threads
from stiction.studies.member_solution import OneLoad
from stiction.studies.members import count_points, load_bodies
from stiction.studies.store import read_companion
from stiction.studies.study import Study
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

    from stiction.mechanics.onset import Onset
    from stiction.studies.store import StoredResult

ONSET_FILE = "onset.nc"  # name of the file in the folder of a result
ONSET_TABLE_FILE = "onset.csv"  # the curve as a table: the backbone of a Masing model
ONSET_TABLE_MARK = b"fraction of the sliding load,"  # beginning of its first line
NUM_ONSET_MEMBERS, NUM_AREAL_ONSET_MEMBERS = 16, 4
"""Default number of members whose onset is computed; the second is for areas with the half-space, which take longer."""


ONSET_LOAD_FRACTIONS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)
"""Fractions of the sliding load at which the curve is."""

TRACTION_TOLERANCE = 1e-5  # of a member's tractions, which moves displacements by 1e-7 of themselves
DEFAULT_POISSON_RATIO = 0.3  # of both bodies, where nothing is known of them
_CURVE_NAMES = ("tangential_load", "displacement", "slipped_area", "slipped_load", "energy_lost")
_NUMBER_NAMES = ("sliding_load", "displacement_at_sliding", "stiffness", "unloading_stiffness")
_STATISTIC_NAMES = ["mean", "lower", "upper"]


def compute_onset(
    study: Study, executor: Executor, *, members: int | None = None, load: float | None = None
) -> xarray.Dataset | None:
    """How the first members of a measured pair begin to slide at a load (mN), by default the first of its study.

    Over fraction (of the sliding load) and statistic, with the map of what slips first of the first member and the
    Iwan and LuGre models of the mean curve. None where nothing holds the bodies, and where no member has an answer.
    """
    if not study.is_measured:
        return None
    mu0, tau0 = float(study.friction.mu0[0]), float(study.friction.tau0[0])
    if mu0 == tau0 == 0:
        return None
    load = float(study.friction.load[0]) if load is None else load
    surfaces: Any = study.surfaces
    first = surfaces.first_scanned
    first = first if first < study.ensemble.repetitions else 0
    few = surfaces.is_areal and study.uses_half_space
    wanted = (NUM_AREAL_ONSET_MEMBERS if few else NUM_ONSET_MEMBERS) if members is None else members
    indices = range(first, min(first + wanted, study.ensemble.repetitions))
    of_member: Any = partial(
        compute_member_onset, study, load=load, mu0=mu0, tau0=tau0, cut_off=surfaces.quoted_cut_off()
    )
    of_member = use_idle_threads(of_member, executor, len(indices), count_points(study))
    found = [each for each in executor.map(of_member, indices) if each]
    if not found:
        return None
    onset = _average_members(study, found, {"load_mN": load, "mu0": mu0, "tau0_GPa": tau0})
    return onset.assign(found[0]["map"])


def compute_member_onset(
    study: Study, index: int, *, load: float, mu0: float, tau0: float, cut_off: float
) -> dict[str, Any] | None:
    """The curve of one member as arrays by name, and what the member is; None where it has no answer."""
    member = load_bodies(study).member(index, cut_off)
    poisson = study.contact.poisson_ratio or (DEFAULT_POISSON_RATIO, DEFAULT_POISSON_RATIO)
    try:
        pressed = OneLoad.of(study, member.pair, load)
        if pressed is None:
            return None
        exactly: dict[str, Any] = {"tolerance": TRACTION_TOLERANCE} if isinstance(pressed.curve, HalfSpaceCurve) else {}
        onset = pressed.curve.onset(0, mu0=mu0, tau0=tau0, steps=ONSET_LOAD_FRACTIONS, poisson=poisson, **exactly)
    except (RuntimeError, ValueError):  # no solution, or a law that has no onset
        return None
    found: dict[str, Any] = {
        name: getattr(onset, name) for name in (*_CURVE_NAMES, *_NUMBER_NAMES[:-1]) if name != "energy_lost"
    }  # fmt: skip
    found["unloading_stiffness"] = float(np.ravel(getattr(pressed.curve, "unloading_stiffness", np.nan))[0])
    return found | {
        "energy_lost": onset.energy_lost(onset.tangential_load), "line": member.line, "x": member.x, "y": member.y,
        "repetition": index, "map": build_slip_map(pressed, onset),
    }  # fmt: skip


# ---- Over members ----------------------------------------------------------------------------------------------------


def _average_members(study: Study, found: Sequence[dict[str, Any]], about: dict[str, Any]) -> xarray.Dataset:
    import xarray

    members = OverMembers.of(study, {name: [each[name] for each in found] for name in ("line", "x", "y", "repetition")})
    variables: dict[str, Any] = {}
    for name in (*_CURVE_NAMES, *_NUMBER_NAMES):
        dims = ("fraction", "statistic") if name in _CURVE_NAMES else ("statistic",)
        values = np.clip(members.mean(np.array([each[name] for each in found])), *QUANTITIES[name].bounds)
        variables[name] = (dims, values, attributes_of(name))
    variables["tangential_load"][2]["long_name"] = "tangential load"  # of the whole way to sliding
    coordinates: dict[str, Any] = {
        "fraction": (
            "fraction",
            list(ONSET_LOAD_FRACTIONS),
            {"units": "1", "long_name": "tangential over sliding load"},
        ),
        "statistic": _STATISTIC_NAMES,
    }
    ratios = study.contact.poisson_ratio
    about = about | {
        "members": len(found), "mechanics": study.contact.mechanics,
        "poisson_ratio": np.array(ratios or (DEFAULT_POISSON_RATIO, DEFAULT_POISSON_RATIO)),
        "poisson_given": int(ratios is not None),
    }  # fmt: skip
    dataset = xarray.Dataset(variables, coordinates, {"title": "onset of sliding", **about})
    return dataset.assign_attrs(_fit_models(dataset))


def _fit_models(onset: xarray.Dataset) -> dict[str, float]:
    """Parameters of the four-parameter Iwan model and of LuGre's bristles of the mean curve, where it has them."""
    curve = onset.sel(statistic="mean")
    way, load = (np.asarray(curve[name].values) for name in ("displacement", "tangential_load"))
    sliding = float(curve["sliding_load"])
    try:
        iwan = fit_iwan(way, load, sliding_load=sliding, stiffness=float(curve["stiffness"]))
        lugre = fit_lugre(way, load, sliding_load=sliding)
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


def load_onset(result: StoredResult) -> xarray.Dataset | None:
    """The onset beside a stored result, of its first load, mu0 and tau0; a `StoreError` if it is damaged."""
    if not result.study.is_measured:
        return None
    friction = result.study.friction
    onset = read_companion(
        Path(result.path) / ONSET_FILE, ("fraction", "statistic", *_NUMBER_NAMES[:-1], *_CURVE_NAMES)
    )
    if (
        onset is None
        or _NUMBER_NAMES[-1] not in onset
        or onset["fraction"].values.tolist() != list(ONSET_LOAD_FRACTIONS)
    ):
        return None
    of = [float(onset.attrs[name]) for name in ("load_mN", "mu0", "tau0_GPa")]
    return onset if of == [float(each[0]) for each in (friction.load, friction.mu0, friction.tau0)] else None


def format_backbone(onset: xarray.Dataset) -> str:
    """The mean curve from rest on as CSV, each column with its unit: the backbone of a Masing model."""
    import pandas

    columns: dict[str, Any] = {"fraction of the sliding load": [0.0, *onset["fraction"].values]}
    for name in _CURVE_NAMES:
        unit = QUANTITIES[name].unit
        title = name.replace("_", " ") + ("" if unit == "1" else f" ({unit})")
        for statistic, more in (("mean", ""), ("lower", ": lower"), ("upper", ": upper")):
            columns[title + more] = [0.0, *onset[name].sel(statistic=statistic).values]
    text: str = pandas.DataFrame(columns).to_csv(index=False, float_format="%.9g")
    return text


# ---- What slips first -----------------------------------------------------------------------------------------------


Variables = dict[str, tuple[Any, ...]]
_LENGTH_ATTRIBUTES = {"units": "um"}


def build_slip_map(pressed: OneLoad, onset: Onset) -> Variables:
    """Which fraction of the sliding load makes each point of a map slip, or each contact, and the heights below.

    Of large maps the first of some neighbours is kept. Nothing of profiles.
    """
    lower = pressed.lower
    if not isinstance(lower, Surface):
        return {}
    (rows, columns), (dy, dx) = lower.heights.shape, lower.spacing
    step = -(-max(rows, columns) // MAX_PICTURE_SIZE)
    found: Variables = {
        "slip_y": ("slip_y", np.arange(0, rows, step) * dy, _LENGTH_ATTRIBUTES),
        "slip_x": ("slip_x", np.arange(0, columns, step) * dx, _LENGTH_ATTRIBUTES),
        "lower_height": (("slip_y", "slip_x"), lower.heights[::step, ::step].astype(np.float32), _LENGTH_ATTRIBUTES),
    }
    fraction = onset.slip_load() / onset.sliding_load
    if isinstance(pressed.curve, HalfSpaceCurve):
        words = {"units": "1", "long_name": "tangential over sliding load at which a point slips"}
        first = _find_block_minima(fraction.reshape(rows, columns), step)
        return found | {"slip": (("slip_y", "slip_x"), first.astype(np.float32), words)}
    table = pressed.table()
    of_contacts = {
        "slip": (fraction, "1", "tangential over sliding load at which a contact slides as a whole"),
        "x": (table.x, "um", "middle of a contact along x"),
        "y": (table.y, "um", "middle of a contact along y"),
        "area": (table.area, "um^2", "area of a contact"),
    }
    return found | {
        f"contact_{name}": ("contact", values, {"units": unit, "long_name": words})
        for name, (values, unit, words) in of_contacts.items()
    }


def _find_block_minima(values: Floats, step: int) -> Floats:
    """The least number of each block of some rows and columns; NaN where there is none."""
    rows, columns = (-(-size // step) * step for size in values.shape)
    whole = np.full((rows, columns), np.inf)
    whole[: values.shape[0], : values.shape[1]] = np.where(np.isnan(values), np.inf, values)
    least = whole.reshape(rows // step, step, columns // step, step).min(axis=(1, 3))
    return np.where(np.isinf(least), np.nan, least)
