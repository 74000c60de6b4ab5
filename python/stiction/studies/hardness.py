"""True area of a measured pair over a range of hardness: a few of its members pressed at a few other hardnesses."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.mechanics.half_space import half_space, solved
from stiction.mechanics.hardness import area_per_load
from stiction.mechanics.spectral_resolution import KAPPA
from stiction.studies.contact_tables import HalfSpace
from stiction.studies.known import creep_of, inputs_of
from stiction.studies.member_values import member_values
from stiction.studies.members import bodies_of
from stiction.studies.store import Stored, read_beside
from stiction.studies.study import Study

if TYPE_CHECKING:
    import xarray

    from stiction.studies.maps import Result

FILE = "hardness.nc"
"""In the folder of a result: true area of its first members at the nodes."""

MEMBERS, LINES = 4, 16
"""Members that are pressed at other hardnesses, areas and lines, of which few contacts make each another."""

NODES = (0.0, 0.15, 0.35, 0.65, 0.85, 1.0)
"""Parts of the range of ln H that are solved, beside the study's hardness, its middle, and elastic bodies."""


def hardnesses_wanted(study: Study) -> Floats:
    """Hardnesses (GPa) at which the range of a study, and its waiting, ask for solutions; infinity is elastic.

    Empty where the hardness is one number, or there is none.
    """
    own, known, creep = study.contact.hardness, inputs_of(study).get("hardness"), creep_of(study)
    if own is None or (known is None and creep is None):
        return np.zeros(0)
    ends = np.repeat(float(own), 2) if known is None else known.known.quantile([0.005, 0.995])
    if creep is not None:
        falls = np.power.outer([1.0, *study.friction.wait], -creep.quantile([0.005, 0.995]))
        ends = ends * [falls.min(), falls.max()]
    return np.unique([*ends[0] * (ends[1] / ends[0]) ** np.array(NODES), float(own), np.inf])


def areas_over_hardness(study: Study, executor: Executor) -> xarray.Dataset | None:
    """True area (µm²) of the first members of a study, over hardness (GPa) and its loads; None where none is wanted."""
    import xarray

    hardnesses = hardnesses_wanted(study)
    if not hardnesses.size:
        return None
    loads = np.array([float(load) for load in study.friction.load])
    members = min(MEMBERS if study.is_areal else LINES, study.ensemble.repetitions)
    tasks = [(index, hardness) for index in range(members) for hardness in hardnesses.tolist()]
    found = np.array(list(executor.map(partial(_areas_of_member, study, loads), tasks)))
    areas = found.reshape(members, -1, loads.size)
    return xarray.Dataset(
        {"contact_area": (("repetition", "hardness", "load"), areas, {"units": "um^2"})},
        {"hardness": ("hardness", hardnesses, {"units": "GPa"}), "load": ("load", loads, {"units": "mN"})},
        {"title": "true area over hardness"},
    )  # fmt: skip


def _areas_of_member(study: Study, loads: Floats, task: tuple[int, float]) -> Floats:
    """True area (µm²) of a member at a hardness (GPa); NaN of a load without a solution, or above the hardness."""
    index, hardness = task
    bodies = bodies_of(study)
    upper, lower = bodies.member(index, float(study.surfaces.cells()["cut_off"][0])).pair
    contact = study.contact
    assert isinstance(contact, HalfSpace), "it has a hardness"
    solid = contact.solid() | {"hardness": hardness if np.isfinite(hardness) else None}
    can = np.flatnonzero(loads < hardness * float(bodies.about().nominal_area or 0.0))
    areas = np.full(loads.size, np.nan)
    for at, curve in solved(partial(half_space, upper, lower, **solid, sliding="all"), loads[can]) if can.size else ():
        areas[can[at]] = curve.contact_area
    return areas


def hardness_beside(result: Stored) -> xarray.Dataset | None:
    """What lies beside a stored result of its range of hardness and its loads, if it does."""
    study = result.study
    wanted = hardnesses_wanted(study) if study.is_measured else np.zeros(0)
    found = read_beside(result.path / FILE, ("hardness", "load", "contact_area")) if wanted.size else None
    if found is None:
        return None
    loads = [float(load) for load in study.friction.load]
    same = found["hardness"].shape == wanted.shape and np.allclose(found["hardness"].values, wanted, rtol=1e-9)
    return found if same and found["load"].values.tolist() == loads else None


@dataclass(frozen=True)
class Areas:
    """How the true area at each load goes with hardness and with E*."""

    hardness: float | None  # GPa, of the study
    nodes: Floats  # (n,) GPa
    at_nodes: Floats  # (loads, n) A/F, 1/GPa
    elastic: Floats  # (loads,) A/F of bodies that do not yield
    growth: Floats  # (loads,) d ln(A/F) / d ln F
    kept: dict[Any, Any] = field(default_factory=dict)  # draws that several points share

    @classmethod
    def of(cls, at: xarray.Dataset, study: Study, result: Result) -> Areas:
        """Those of a result at the loads of what `at_load` gives of it."""
        loads = at["load"].values
        hardness = study.contact.hardness
        area = at["contact_area"].sel(statistic="mean")
        area = area.mean([dim for dim in area.dims if dim != "load"]).values / loads
        steps = study.contact.steps()
        growth = np.zeros(loads.size)
        if steps.size > 1:
            curve = member_values(result, steps, mu0=[0.0], tau0=[0.0])["contact_area"]
            ratio = curve.mean([dim for dim in curve.dims if dim != "load"]).values / steps
            known = np.isfinite(ratio) & (ratio > 0)
            if known.sum() > 1:
                slope = np.gradient(np.log(ratio[known]), np.log(steps[known]))
                growth = np.interp(np.log(loads), np.log(steps[known]), slope)
        if hardness is None:
            return cls(None, np.zeros(0), np.zeros((loads.size, 0)), area, growth)
        solved = result.once(hardness_beside) if isinstance(result, Stored) else None
        if solved is not None and set(loads.tolist()) <= set(solved["load"].values.tolist()):
            table = solved["contact_area"].sel(load=loads).mean("repetition").transpose("load", "hardness").values
            over = table / loads[:, np.newaxis]
            finite = np.isfinite(solved["hardness"].values) & np.isfinite(over).all(axis=0)
            last = over[:, -1]
            if finite.any() and np.isfinite(last).all():
                return cls(float(hardness), solved["hardness"].values[finite], over[:, finite], last, growth)
        # Without solutions at other hardnesses the area follows the one formula through that of the study.
        gradient = float(at["rms_gradient"].sel(statistic="mean").mean())
        elastic = np.full(loads.size, KAPPA / (float(study.contact.effective_modulus) * gradient))
        return cls(float(hardness), np.array([float(hardness)]), area[:, np.newaxis], elastic, growth)

    def factor(self, load: int, hardness: Floats | None, modulus: Floats | float) -> Floats:
        """True area over that of the study, for hardnesses (GPa) and E* over that of the study."""
        scale = np.power(modulus, -(1.0 + self.growth[load]))
        if self.hardness is None or hardness is None:
            return np.asarray(scale)
        values = area_per_load(np.ravel(hardness / modulus), self.nodes, self.at_nodes[load], self.elastic[load])
        own = area_per_load([self.hardness], self.nodes, self.at_nodes[load], self.elastic[load])
        return np.asarray(scale * values / own)
