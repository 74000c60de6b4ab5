"""What a result looks like: an xarray dataset with units, names and the study it is of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._core import __version__
from stiction.mechanics.quantities import AREAL_SUMS, DIRECTED, HALF_SPACE_SUMS, SUMS, attributes_of
from stiction.studies.study import Study

if TYPE_CHECKING:
    import xarray

COORDINATES = ("fractal_dimension", "amplitude", "repetition", "sliding", "direction", "approach", "load")
"""All that any result has, in the order of its dimensions; what there is no list of is none of them."""

NAMES = tuple(dict.fromkeys((*SUMS, *AREAL_SUMS, *HALF_SPACE_SUMS, *COORDINATES)))
"""All that is in any result."""


def step_of(dataset: xarray.Dataset) -> str:
    """The dimension along which a pair of a result is pressed together: "approach", or "load" by the half-space."""
    return "load" if "load" in dataset.dims else "approach"


def empty_dataset(study: Study, repetitions: Sequence[int] | None = None) -> xarray.Dataset:
    """The dataset of a study, or of some of its repetitions: zeros, with units, names and attributes in place."""
    import xarray

    motions = study.motions()
    values: dict[str, Any] = {
        "fractal_dimension": study.surfaces.fractal_dimensions(),
        "amplitude": study.surfaces.amplitudes(),
        "repetition": np.array(range(study.ensemble.repetitions) if repetitions is None else repetitions, np.int64),
        **{name: np.array(each) for name, each in motions.items()},
        study.contact.step: study.contact.steps(),
    }
    coordinates = {name: xarray.Variable((name,), each, attributes_of(name)) for name, each in values.items()}
    variables = {}
    for name in study.sums():
        dims = tuple(dim for dim in coordinates if dim not in motions or name in DIRECTED)
        zeros = np.zeros([coordinates[dim].size for dim in dims], np.int64 if name.endswith("_count") else np.float64)
        variables[name] = xarray.Variable(dims, zeros, attributes_of(name))
    coordinates["fractal_dimension"].attrs["convention"] = study.surfaces.convention
    coordinates["amplitude"].attrs["measure"] = study.surfaces.amplitude_measure
    if study.contact.step == "load":
        coordinates["load"].attrs["long_name"] = "normal load of the elastic contact, without friction"
    attributes = {"title": "stiction study", "study": study.to_toml(), "stiction_version": __version__}
    return xarray.Dataset(variables, coordinates, attributes)
