"""What a result looks like: an xarray dataset with units, names and the study it is of."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._core import __version__
from stiction.mechanics.quantities import AREAL_SUMS, DIRECTED, HALF_SPACE_SUMS, SUMS, attributes_of
from stiction.studies.study import Study

if TYPE_CHECKING:
    import xarray

COORDINATES = ("fractal_dimension", "amplitude", "repetition", "sliding", "direction", "approach", "load")
"""All that any result has, in the order of its dimensions; what there is no list of is none of them."""

NAMES = tuple(dict.fromkeys((*SUMS, *AREAL_SUMS, *HALF_SPACE_SUMS, *COORDINATES)))
"""All that is in any result."""


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


def coordinates_of(
    study: Study, repetitions: Sequence[int] | NDArray[np.intp] | None = None
) -> dict[str, tuple[Array, NDArray[Any]]]:
    """The coordinates of a result, or of some of its repetitions, with their values, in the order of its dimensions."""
    values: dict[str, NDArray[Any]] = {
        "fractal_dimension": study.surfaces.fractal_dimensions(),
        "amplitude": study.surfaces.amplitudes(),
        "repetition": np.arange(study.ensemble.repetitions) if repetitions is None else np.array(repetitions, np.int64),
        **{name: np.array(each) for name, each in study.motions().items()},
        study.contact.step: study.contact.steps(),
    }
    more: dict[str, dict[str, str]] = {
        "fractal_dimension": {"convention": study.surfaces.convention},
        "amplitude": {"measure": study.surfaces.amplitude_measure},
        "load": {"long_name": "normal load of the elastic contact, without friction"},
    }
    return {
        name: (Array((name,), each.shape, each.dtype, attributes_of(name) | more.get(name, {})), each)
        for name, each in values.items()
    }


def variables_of(study: Study, repetitions: Sequence[int] | NDArray[np.intp] | None = None) -> dict[str, Array]:
    """The variables of a result, or of some of its repetitions."""
    sizes = {name: each.size for name, (_, each) in coordinates_of(study, repetitions).items()}
    motions = study.motions()
    found = {}
    for name in study.sums():
        dims = tuple(dim for dim in sizes if dim not in motions or name in DIRECTED)
        dtype = np.dtype(np.int64 if name.endswith("_count") else np.float64)
        found[name] = Array(dims, tuple(sizes[dim] for dim in dims), dtype, attributes_of(name))
    return found


def attributes_of_result(study: Study) -> dict[str, str]:
    """What a result says of itself."""
    return {"title": "stiction study", "study": study.to_toml(), "stiction_version": __version__}


def empty_dataset(study: Study, repetitions: Sequence[int] | NDArray[np.intp] | None = None) -> xarray.Dataset:
    """The dataset of a study, or of some of its repetitions: zeros, with units, names and attributes in place."""
    import xarray

    return xarray.Dataset(
        {
            name: xarray.Variable(each.dims, np.zeros(each.shape, each.dtype), each.attributes)
            for name, each in variables_of(study, repetitions).items()
        },
        {
            name: xarray.Variable(each.dims, values, each.attributes)
            for name, (each, values) in coordinates_of(study, repetitions).items()
        },
        attributes_of_result(study),
    )
