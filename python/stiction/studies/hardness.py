"""What is not known exactly of a measured pair, and its true area over ranges of hardness and of E*.

A few of its members are pressed at a few other hardnesses and moduli.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.mechanics.half_space import half_space, solved
from stiction.mechanics.hardness import area_per_load
from stiction.mechanics.materials import Material, material, softer_material
from stiction.mechanics.resolution import KAPPA
from stiction.studies.at_load import member_values
from stiction.studies.contact_tables import HalfSpace
from stiction.studies.known import Known, known, read_known
from stiction.studies.members import bodies_of, points_of_member
from stiction.studies.moduli import Moduli, hardness_of_material, moduli_of_material
from stiction.studies.store import Stored, read_beside
from stiction.studies.study import Study
from stiction.surfaces.pairing import SIDES

if TYPE_CHECKING:
    import xarray

    from stiction.studies.maps import Result

FILE = "hardness.nc"
"""In the folder of a result: true area of its first members at the nodes."""

MEMBERS, LARGE, LINES = 4, 2, 16
"""Members that are pressed at other hardnesses: areas, large ones, and lines, whose few contacts make them differ."""

LARGE_POINTS = 2**19
"""Points of a large area: members of 384² points differ by 0.1 % where they yield, and by 2 % where they begin to."""

MIN_MEMBERS = 2  # members from whose scatter the error of the area over hardness is estimated

NODES = {1: (0.0, 0.15, 0.35, 0.65, 0.85, 1.0), 3: (0.0, 0.1, 0.25, 0.4, 0.6, 0.75, 0.9, 1.0)}
"""Parts of the range of ln H that are solved, by the number of moduli, beside the study's own and elastic bodies."""

NARROW = 0.2
"""Half of the range of ln E* below which the growth of the area with the load at the study's own E* will do."""

OUTER = (0.005, 0.995)
"""Quantiles of a range between which solutions are wanted."""
_MODULI = {"young": "Young's modulus", "poisson": "Poisson's ratio"}
ROUNDED = 0.006  # relative difference between a number and itself in three digits, at most


@dataclass(frozen=True)
class Input:
    """An input of a study with its name in words."""

    words: str
    known: Known


def inputs_of(study: Study) -> dict[str, Input]:
    """What is known of the inputs of a study of measured bodies that are no exact numbers, by their names."""
    if not study.is_measured:
        return {}
    table, contact = study.known, study.contact
    bodies = materials_of(study)
    found: dict[str, Input] = {}
    for name, words, kind in (("mu0", "μ0", ""), ("tau0", "τ0", "pressure")):
        if (text := getattr(table, name)) is not None:
            found[name] = Input(words, known(name, text, kind))  # type: ignore[arg-type]
    moduli = moduli_of(study).inputs
    if "effective_modulus" in moduli:
        found["effective_modulus"] = Input("E*", moduli.pop("effective_modulus"))
    if contact.hardness is not None:
        softer = softer_material(*bodies)
        words = f"the hardness of the {softer.name}" if softer else "the hardness"
        if table.hardness is not None:
            found["hardness"] = Input(words, known("hardness", table.hardness, "hardness"))
        elif softer and softer.hardness and abs(float(contact.hardness) / softer.hardness - 1) < ROUNDED:
            found["hardness"] = Input(words, hardness_of_material(softer.hardness))
    for key, value in moduli.items():
        name, _, side = key.partition("_")
        words = f"{_MODULI[name]} of the {bodies[SIDES.index(side)].name if bodies else f'{side} body'}"
        found[key] = Input(words, value)
    return {name: each for name, each in found.items() if not each.known.is_exact}


def creep_of(study: Study) -> Known | None:
    """What is known of the exponent of indentation creep, where the study waits."""
    return known("creep", study.known.creep) if study.friction.wait and study.known.creep else None


def moduli_of(study: Study) -> Moduli:
    """What is known of the moduli of a study."""
    table, materials, middle = study.known, materials_of(study), float(study.contact.effective_modulus)
    if table.effective_modulus is not None:
        return Moduli(middle, known("effective_modulus", table.effective_modulus, "modulus"))
    if table.young is not None and table.poisson is not None:
        given = [(table.young[i % len(table.young)], table.poisson[i % len(table.poisson)]) for i in range(2)]
        bodies = [{"young": known("young", e, "modulus"), "poisson": read_known("poisson", nu)} for e, nu in given]
        return Moduli(middle, bodies=tuple(bodies))
    bodies = [moduli_of_material(each) for each in materials]
    return Moduli(middle, bodies=tuple(bodies), is_one_material=bool(materials) and materials[0] == materials[1])


def materials_of(study: Study) -> tuple[Material, ...]:
    """The materials of both bodies by whose names a study was made; none of names that somebody gave himself."""
    try:
        return tuple(material(name) for name in study.contact.materials or ())
    except ValueError:
        return ()


def relative_modulus(study: Study, drawn: Mapping[str, Floats]) -> Floats | float:
    """E* over that of the study, of draws of its inputs by their names."""
    return moduli_of(study).relative(drawn)


# ---- Areas over hardness ---------------------------------------------------------------------------------------------


def bodies_wanted(study: Study) -> tuple[Floats, Floats]:
    """Hardnesses over relative moduli (GPa), and these (E* over that of the study), at which its ranges ask for areas.

    The last hardness is infinity, elastic bodies. There are none where hardness and E* are numbers or nearly so, and
    the study does not wait.
    """
    inputs, creep, own = inputs_of(study), creep_of(study), study.contact.hardness
    # Each input of E* at its ends, the others in the middle, and what they make of it in quadrature.
    steps = [
        np.ptp(np.log(relative_modulus(study, {name: each.known.quantile(OUTER)}))) / 2
        for name, each in inputs.items()
        if name not in ("mu0", "tau0", "hardness")
    ]
    wide = float(np.hypot.reduce([0.0, *steps]))
    moduli = np.exp([-wide, 0.0, wide]) if wide > NARROW else np.ones(1)
    if own is None:
        return np.array([np.inf] if moduli.size > 1 else []), moduli
    if "hardness" not in inputs and creep is None and moduli.size == 1:
        return np.zeros(0), moduli
    ends = inputs["hardness"].known.quantile(OUTER) if "hardness" in inputs else np.repeat(float(own), 2)
    if creep is not None:
        falls = np.power.outer([1.0, *study.friction.wait], -creep.quantile(OUTER))
        ends = ends * [falls.min(), falls.max()]
    half = np.hypot(np.ptp(np.log(ends)) / 2, np.log(moduli[-1]))
    parts = np.exp(half * (2 * np.array(NODES[moduli.size]) - 1))
    return np.unique([*np.sqrt(ends.prod()) * parts, float(own), np.inf]), moduli


def areas_over_hardness(study: Study, executor: Executor) -> xarray.Dataset | None:
    """True areas (µm²) of the first members of a study over hardness (GPa), E* and its loads; None for no range."""
    import xarray

    hardnesses, moduli = bodies_wanted(study)
    if not hardnesses.size:
        return None
    loads = np.array([float(load) for load in study.friction.load])
    members = _members(study)
    tasks = list(product(range(members), moduli.tolist(), hardnesses.tolist()))
    found = np.array(list(executor.map(partial(_areas_of_member, study, loads), tasks)))
    areas = found.reshape(members, moduli.size, hardnesses.size, loads.size)
    return xarray.Dataset(
        {"contact_area": (("repetition", "relative_modulus", "hardness", "load"), areas, {"units": "um^2"})},
        {
            "hardness": ("hardness", hardnesses, {"units": "GPa", "long_name": "hardness over the relative modulus"}),
            "relative_modulus": ("relative_modulus", moduli, {"units": "1"}),
            "load": ("load", loads, {"units": "mN"}),
        },
        {"title": "true area over hardness and E*"},
    )  # fmt: skip


def count_solutions(study: Study) -> int:
    """Return how many solutions at other hardnesses and moduli `areas_over_hardness` takes, over all loads."""
    hardnesses, moduli = bodies_wanted(study)
    return hardnesses.size * moduli.size * _members(study) * len(study.friction.load) if hardnesses.size else 0


def _members(study: Study) -> int:
    few = LARGE if points_of_member(study) >= LARGE_POINTS else MEMBERS
    return min(few if study.is_areal else LINES, study.ensemble.repetitions)


def _areas_of_member(study: Study, loads: Floats, task: tuple[int, float, float]) -> Floats:
    """True areas (µm²) of a member of a relative E*, and a hardness over it; NaN of a load that it does not bear."""
    index, modulus, ratio = task
    bodies, contact, hardness = bodies_of(study), study.contact, modulus * ratio
    surfaces: Any = study.surfaces
    upper, lower = bodies.member(index, surfaces.quoted_cut_off()).pair
    assert isinstance(contact, HalfSpace), "they are pressed as half-spaces"
    modulus *= float(contact.effective_modulus)
    solid = contact.solid() | {"hardness": hardness if np.isfinite(hardness) else None, "effective_modulus": modulus}
    can = np.flatnonzero(loads < hardness * float(bodies.about().nominal_area or 0.0))
    areas = np.full(loads.size, np.nan)
    for at, curve in solved(partial(half_space, upper, lower, **solid, sliding="all"), loads[can]) if can.size else ():
        areas[can[at]] = curve.contact_area
    return areas


def hardness_beside(result: Stored) -> xarray.Dataset | None:
    """What lies beside a stored result of its ranges of hardness and E* and of its loads, if it does."""
    study = result.study
    hardnesses, moduli = bodies_wanted(study) if study.is_measured else (np.zeros(0), np.ones(1))
    wanted = hardnesses, moduli, np.array([float(load) for load in study.friction.load])
    names = ("hardness", "relative_modulus", "load")
    found = read_beside(result.path / FILE, (*names, "contact_area")) if hardnesses.size else None
    if found is None:
        return None
    there = [found[name].values for name in names]
    same = all(
        one.shape == other.shape and np.allclose(one, other, rtol=1e-9)
        for one, other in zip(there, wanted, strict=True)
    )
    return found if same else None


@dataclass(frozen=True)
class Areas:
    """How the true area at each load goes with hardness and with E*.

    A solution at (F, E*, H) is one at (F/e, E*/e, H/e): that of the study's E* at another load and hardness.
    """

    hardness: float | None  # GPa, of the study
    nodes: Floats  # (n,) H/e, GPa
    at_nodes: Floats  # (loads, m, n) e A/F, 1/GPa
    elastic: Floats  # (loads, m) e A/F of bodies that do not yield
    moduli: Floats  # (m,) e, E* over that of the study
    growth: Floats  # (loads,) d ln(A/F) / d ln F
    errors: Floats  # (loads, n) relative standard error of A at the nodes over that of the study
    kept: dict[Any, Any] = field(default_factory=dict)  # draws that several points share

    @classmethod
    def of(cls, at: xarray.Dataset, study: Study, result: Result) -> Areas:
        """Those of a result at the loads of what `at_load` gives of it."""
        loads, hardness = at["load"].values, study.contact.hardness
        own = None if hardness is None else float(hardness)
        growth = _growth(loads, study, result)
        solved = result.once(hardness_beside) if isinstance(result, Stored) else None
        if solved is not None and set(loads.tolist()) <= set(solved["load"].values.tolist()):
            areas = solved["contact_area"].sel(load=loads).mean("repetition")
            over = (areas * areas["relative_modulus"] / areas["load"]).transpose("load", "relative_modulus", "hardness")
            nodes, moduli = over["hardness"].values, over["relative_modulus"].values
            borne = np.isfinite(over.values).all(axis=(0, 1))
            if borne[-1] and (own is None or borne.sum() > 1):
                finite = borne & np.isfinite(nodes)
                table = nodes[finite], over.values[..., finite], over.values[..., -1]
                growth = growth if moduli.size == 1 else np.zeros(loads.size)
                return cls(own, *table, moduli, growth, _errors_over_hardness(solved, own, loads)[:, finite])
        area = at["contact_area"].sel(statistic="mean")
        ratio = (area.mean([dim for dim in area.dims if dim != "load"]).values / loads)[:, np.newaxis]
        if own is None:
            none = np.zeros((loads.size, 0))
            return cls(None, np.zeros(0), none[:, np.newaxis], ratio, np.ones(1), growth, none)
        # Without solutions at other hardnesses the area follows the one formula through that of the study.
        gradient = float(at["rms_gradient"].sel(statistic="mean").mean())
        elastic = np.full((loads.size, 1), KAPPA / (float(study.contact.effective_modulus) * gradient))
        none = np.zeros((loads.size, 1))
        return cls(own, np.array([own]), ratio[..., np.newaxis], elastic, np.ones(1), growth, none)

    def factor(self, load: int, hardness: Floats | None, modulus: Floats | float) -> Floats:
        """True area over that of the study, for hardnesses (GPa) and E* over that of the study."""
        if hardness is None or self.hardness is None:
            now, own = self.elastic[load][:, np.newaxis], self.elastic[load][:, np.newaxis]
        else:
            known = self.nodes, self.at_nodes[load], self.elastic[load]
            now, own = (area_per_load(np.ravel(each), *known) for each in (hardness / modulus, self.hardness))
        scale = np.power(modulus, -(1.0 + self.growth[load]))
        return np.asarray(scale * _between(now, self.moduli, modulus) / own[self.moduli.size // 2])

    def error(self, load: int, hardness: Floats) -> Floats:
        """Relative standard error of `factor` at hardnesses over the relative modulus (GPa), from the members."""
        return np.asarray(np.interp(np.log(hardness), np.log(self.nodes), self.errors[load]))


def _errors_over_hardness(solved: xarray.Dataset, own: float | None, loads: Floats) -> Floats:
    """(loads, n) relative standard errors over members of the area at the nodes over that at the study's hardness."""
    area = solved["contact_area"].sel(load=loads).sel(relative_modulus=1.0, method="nearest")
    area = area.transpose("load", "hardness", "repetition")
    count = area.sizes["repetition"]
    if own is None or count < MIN_MEMBERS:
        return np.zeros(area.shape[:2])
    relative = np.log((area / area.sel(hardness=own, method="nearest")).values)
    return np.asarray(relative.std(axis=-1, ddof=1) / np.sqrt(count))


def _between(values: Floats, moduli: Floats, wanted: Floats | float) -> Floats:
    """What lies between positive values over moduli e^(-w), 1, e^w: their logarithms on a parabola in ln E*."""
    if moduli.size == 1:
        return np.asarray(values[0])
    softer, own, stiffer = np.log(values)
    part = np.log(wanted) / np.log(moduli[-1])
    return np.asarray(np.exp(own + part * (stiffer - softer) / 2 + part**2 * (stiffer + softer - 2 * own) / 2))


def _growth(loads: Floats, study: Study, result: Result) -> Floats:
    """How A/F grows with the load, d ln(A/F) / d ln F, at loads (mN)."""
    steps = study.contact.steps()
    if steps.size > 1:
        curve = member_values(result, steps, mu0=[0.0], tau0=[0.0])["contact_area"]
        ratio = curve.mean([dim for dim in curve.dims if dim != "load"]).values / steps
        known = np.isfinite(ratio) & (ratio > 0)
        if known.sum() > 1:
            slope = np.gradient(np.log(ratio[known]), np.log(steps[known]))
            return np.asarray(np.interp(np.log(loads), np.log(steps[known]), slope))
    return np.zeros(loads.size)
