"""True area of a measured pair over a range of hardness: a few of its members pressed at a few other hardnesses."""

from __future__ import annotations

from concurrent.futures import Executor
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from stiction._checks import Floats
from stiction.mechanics.half_space import half_space, solved
from stiction.studies.contact_tables import HalfSpace
from stiction.studies.known import creep_of, inputs_of
from stiction.studies.members import bodies_of
from stiction.studies.store import read_beside
from stiction.studies.study import Study

if TYPE_CHECKING:
    import xarray

    from stiction.studies.store import Stored

FILE = "hardness.nc"
"""In the folder of a result: true area of its first members at the nodes."""

MEMBERS = 4
"""Members that are pressed at other hardnesses: what the area changes by is nearly the same at all positions."""

NODES = 4
"""Hardnesses that are solved, beside that of the study and elastic bodies: they hold mu_s between them to 0.5 %."""


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
    return np.unique([*np.geomspace(ends[0], ends[1], NODES), float(own), np.inf])


def areas_over_hardness(study: Study, executor: Executor) -> xarray.Dataset | None:
    """True area (µm²) of the first members of a study, over hardness (GPa) and its loads; None where none is wanted."""
    import xarray

    hardnesses = hardnesses_wanted(study)
    if not hardnesses.size:
        return None
    loads = np.array([float(load) for load in study.friction.load])
    members = min(MEMBERS, study.ensemble.repetitions)
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
