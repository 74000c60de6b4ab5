"""What a result looks like: an xarray dataset with units, names and the study it is of."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray

from stiction._core import __version__
from stiction.mechanics.quantities import SUMS, attributes_of
from stiction.studies.study import Study


def empty_dataset(study: Study, repetitions: Sequence[int] | None = None) -> xarray.Dataset:
    """The dataset of a study, or of some of its repetitions: zeros, with units, names and attributes in place."""
    values = {
        "fractal_dimension": study.surfaces.fractal_dimensions(),
        "amplitude": study.surfaces.amplitudes(),
        "repetition": np.array(range(study.ensemble.repetitions) if repetitions is None else repetitions, np.int64),
        "approach": study.contact.approaches(),
    }
    coordinates = {name: xarray.Variable((name,), each, attributes_of(name)) for name, each in values.items()}
    shape = tuple(coordinate.size for coordinate in coordinates.values())
    variables = {
        name: xarray.Variable(
            tuple(coordinates),
            np.zeros(shape, np.int64 if name.endswith("_count") else np.float64),
            attributes_of(name),
        )
        for name in SUMS
    }
    coordinates["fractal_dimension"].attrs["convention"] = study.surfaces.convention
    coordinates["amplitude"].attrs["measure"] = study.surfaces.amplitude_measure
    attributes = {"title": "stiction study", "study": study.to_toml(), "stiction_version": __version__}
    return xarray.Dataset(variables, coordinates, attributes)
