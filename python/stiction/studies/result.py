"""What a result looks like: an xarray dataset with units, names and the study it is of.

A result holds sums over contacts of every member of its study, at every step, sliding rule and direction. Its
dimensions are the cells of the study (fractal dimension and amplitude of generated bodies, the cut-off of measured
ones), the members (`repetition`), the motions of which there is a list, and the step (approach or load).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._core import __version__
from stiction.mechanics.friction import STATUSES
from stiction.mechanics.quantities import DIRECTED, DISTRIBUTIONS, GAP, UNLOADED, attributes_of
from stiction.studies.contact_statistics import QUANTILES, STATISTICS
from stiction.studies.generated_surfaces import Generated, Profiles, SelfAffineSurfaces, WeierstrassMandelbrotSurfaces
from stiction.studies.study import Study
from stiction.studies.surface_tables import Measured

if TYPE_CHECKING:
    import xarray

TITLE = "stiction study"  # of every result
MOST_IN_PIECE = 2**26  # bytes of a result that are in memory at a time, where it is read piece by piece

OF_MEMBERS: dict[str, np.dtype[Any]] = {
    "x": np.dtype(np.float64), "y": np.dtype(np.float64), "line": np.dtype(np.int64), "surrogate": np.dtype(np.bool_),
}  # fmt: skip
"""Coordinates along `repetition` that say what a member of measured bodies is, with their kind."""

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Array:
    """An array of a result before there is any: its dimensions and their sizes, its kind, units and names."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    attributes: dict[str, Any]

    @property
    def size(self) -> int:
        """Bytes."""
        return self.dtype.itemsize * math.prod(self.shape)


@dataclass(frozen=True)
class About:
    """What measured bodies say of a result besides its study: nothing, of generated ones."""

    nominal_area: float | None = None  # µm²
    attributes: dict[str, Any] = field(default_factory=dict)


def generated(study: Study) -> Generated:
    """The surfaces of a study of which it is known that they are generated."""
    assert isinstance(study.surfaces, Generated)
    return study.surfaces


def profiles(study: Study) -> Profiles:
    """The surfaces of a study of which it is known that they are generated profiles."""
    assert isinstance(study.surfaces, Profiles)
    return study.surfaces


def areas(study: Study) -> WeierstrassMandelbrotSurfaces | SelfAffineSurfaces:
    """The surfaces of a study of which it is known that they are generated areas."""
    assert isinstance(study.surfaces, (WeierstrassMandelbrotSurfaces, SelfAffineSurfaces))
    return study.surfaces


def measured(study: Study) -> Measured:
    """The surfaces of a study of which it is known that they are measured."""
    assert isinstance(study.surfaces, Measured)
    return study.surfaces


def coordinates_of(
    study: Study, repetitions: Sequence[int] | NDArray[np.intp] | None = None
) -> dict[str, tuple[Array, NDArray[Any]]]:
    """The coordinates of a result, or of some of its repetitions, with their values, in the order of its dimensions."""
    values: dict[str, NDArray[Any]] = {
        **study.surfaces.cells(),
        "repetition": np.arange(study.ensemble.repetitions) if repetitions is None else np.array(repetitions, np.int64),
        **{name: np.array(each) for name, each in study.motions().items()},
        study.step: study.contact.steps(),
    }
    if study.is_measured:
        values["fraction_below"] = np.array(QUANTILES)
    more: dict[str, dict[str, str]] = {"load": {"long_name": "normal load of the elastic contact, without friction"}}
    if not study.is_measured:
        more["fractal_dimension"] = {"convention": generated(study).convention}
        more["amplitude"] = {"measure": generated(study).amplitude_measure}
    return {
        name: (Array((name,), each.shape, each.dtype, attributes_of(name) | more.get(name, {})), each)
        for name, each in values.items()
    }


def variables_of(study: Study, repetitions: Sequence[int] | NDArray[np.intp] | None = None) -> dict[str, Array]:
    """The variables of a result, or of some of its repetitions."""
    sizes = {name: each.size for name, (_, each) in coordinates_of(study, repetitions).items()}
    found = {}
    for name in names_of(study):
        dims = _dims(study, name)
        dtype = np.dtype(np.int64 if name.endswith("_count") or name == "status" else np.float64)
        attributes: dict[str, Any] = dict(attributes_of(name))
        if name == "status":
            attributes |= {"flag_values": np.arange(len(STATUSES)), "flag_meanings": " ".join(STATUSES)}
        found[name] = Array(dims, tuple(sizes[dim] for dim in dims), dtype, attributes)
    return found


def bytes_of_member(study: Study) -> int:
    """Bytes of the numbers of one member."""
    return sum(each.size for each in variables_of(study, [0]).values())


def piece_of(size: int) -> int:
    """How many members of so many bytes are in memory at a time, a power of two."""
    return 1 << max(0, (MOST_IN_PIECE // max(1, size)).bit_length() - 1)


def names_of(study: Study) -> tuple[str, ...]:
    """Names of the variables of a result: the study's sums, and of measured bodies the statistics of contacts."""
    if not study.is_measured:
        return study.sums()
    return tuple(dict.fromkeys((*study.sums(), *STATISTICS, *DISTRIBUTIONS, *GAP, "status")))


def _dims(study: Study, name: str) -> tuple[str, ...]:
    members = (*study.surfaces.cells(), "repetition")
    if name in ("rms_gradient", "pull_off"):
        return members
    if name in UNLOADED:
        return (*members, *study.motions())
    if name == "rms_slope":
        return (*members, *(motion for motion in study.motions() if motion == "direction"))
    if name in DISTRIBUTIONS:
        return (*members, study.step, "fraction_below")
    return (*members, *(study.motions() if name in DIRECTED else ()), study.step)


def stacked(study: Study, members: Sequence[Arrays]) -> Arrays:
    """Arrays of several members as those of a result: one more axis, behind the cells."""
    axis = len(study.surfaces.cells())
    return {
        name: np.stack([each[name] for each in members], axis=0 if name in OF_MEMBERS else axis) for name in members[0]
    }


def dataset_of(
    study: Study, repetitions: Sequence[int] | NDArray[np.intp], arrays: Mapping[str, NDArray[Any]],
    about: About | None = None,
) -> xarray.Dataset:  # fmt: skip
    """The dataset of some repetitions, from arrays as `stacked` makes them, of the shapes that the study says."""
    import xarray

    variables = variables_of(study, repetitions)
    for name, each in variables.items():
        if name not in arrays or arrays[name].shape != each.shape:
            raise ValueError(f"{name} of the result is not what its study says: {each.shape} wanted")
    coordinates: dict[str, Any] = {
        name: xarray.Variable(each.dims, values, each.attributes)
        for name, (each, values) in coordinates_of(study, repetitions).items()
    }
    about = about or About()
    if study.is_measured:
        coordinates |= {
            name: xarray.Variable(("repetition",), np.asarray(arrays[name], dtype), attributes_of(name))
            for name, dtype in OF_MEMBERS.items()
        }
        modulus = float(study.contact.effective_modulus)
        for name, value in (("nominal_area", about.nominal_area), ("effective_modulus", modulus)):
            coordinates[name] = xarray.Variable((), value, attributes_of(name))
    return xarray.Dataset(
        {name: xarray.Variable(each.dims, arrays[name], each.attributes) for name, each in variables.items()},
        coordinates,
        {"title": TITLE, "study": study.to_toml(), "stiction_version": __version__} | about.attributes,
    )
