"""What a result looks like: an xarray dataset with units, names and the study it is of."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray

from stiction._core import __version__
from stiction.studies.study import Study

_VARIABLES = {
    "contact_count": ("1", "number of contacts"),
    "contact_area": ("um^2", "true contact area"),
    "normal_elastic": ("mN", "normal load of the elastic forces"),
    "tangential_elastic": ("mN", "tangential load of the elastic forces of opposing contacts"),
    "normal_frictional": ("mN", "normal load per unit mu0"),
    "tangential_frictional": ("mN", "tangential load per unit mu0"),
    "normal_adhesive": ("mN/GPa", "normal load per unit tau0"),
    "tangential_adhesive": ("mN/GPa", "tangential load per unit tau0"),
    "overlap_load": ("mN", "normal load times overlap / radius"),
    "load_beyond_hertz": ("mN", "normal load of contacts with an overlap above a tenth of their radius"),
    "load_below_grid": ("mN", "normal load of contacts with a radius below the grid spacing"),
    "crossed_count": ("1", "number of contacts refused because their sphere centres had crossed"),
}

_COORDINATES = {
    "fractal_dimension": ("1", "fractal dimension"),
    "amplitude": ("um", "amplitude"),
    "repetition": ("1", "repetition"),
    "approach": ("um", "approach since first touch"),
}


def empty_dataset(study: Study, repetitions: Sequence[int] | None = None) -> xarray.Dataset:
    """The dataset of a study, or of some of its repetitions: zeros, with units, names and attributes in place."""
    values = {
        "fractal_dimension": study.surfaces.fractal_dimensions(),
        "amplitude": study.surfaces.amplitudes(),
        "repetition": np.array(range(study.ensemble.repetitions) if repetitions is None else repetitions, np.int64),
        "approach": study.contact.approaches(),
    }
    coordinates = {
        name: xarray.Variable((name,), values[name], {"units": units, "long_name": long_name})
        for name, (units, long_name) in _COORDINATES.items()
    }
    shape = tuple(coordinate.size for coordinate in coordinates.values())
    variables = {
        name: xarray.Variable(
            tuple(coordinates),
            np.zeros(shape, np.int64 if name.endswith("_count") else np.float64),
            {"units": units, "long_name": long_name},
        )
        for name, (units, long_name) in _VARIABLES.items()
    }
    coordinates["fractal_dimension"].attrs["convention"] = study.surfaces.convention
    coordinates["amplitude"].attrs["measure"] = study.surfaces.amplitude_measure
    attributes = {"title": "stiction study", "study": study.to_toml(), "stiction_version": __version__}
    return xarray.Dataset(variables, coordinates, attributes)
