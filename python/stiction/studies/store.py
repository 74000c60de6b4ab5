"""Results: the dataset's layout, and its Zarr store on disk."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import xarray

from stiction._core import __version__
from stiction.studies.study import Study, study_of

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


class StoreError(ValueError):
    """A store that cannot be written or read."""


def empty_dataset(study: Study) -> xarray.Dataset:
    """The dataset of a study, all zeros, with units, names and attributes in place."""
    values = {
        "fractal_dimension": study.surfaces.fractal_dimensions(),
        "amplitude": study.surfaces.amplitudes(),
        "repetition": np.arange(study.ensemble.repetitions),
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


def reserve(path: str | Path) -> None:
    """Make sure, before anything is computed, that a store can be written to a path that does not exist yet."""
    path = Path(path)
    if os.path.lexists(path):
        raise StoreError(f"{path}: exists already and holds something else; remove it, or choose another place")
    try:
        _partial(path).mkdir(parents=True, exist_ok=True)
        _partial(path).rmdir()
    except OSError as error:
        raise StoreError(f"{path}: cannot be written: {error.strerror or error}") from None


def _partial(path: Path) -> Path:
    return path.with_name(f"{path.name}.partial-{os.getpid()}")


def write(dataset: xarray.Dataset, path: str | Path) -> None:
    """Write a result to a Zarr store, which appears at its path only when it is whole."""
    path = Path(path)
    partial = _partial(path)
    try:
        dataset.to_zarr(partial, mode="w-", zarr_format=3, consolidated=False)
    except OSError as error:
        shutil.rmtree(partial, ignore_errors=True)
        raise StoreError(f"{path}: cannot be written: {error.strerror or error}") from None
    try:
        partial.rename(path)
    except OSError as error:
        raise StoreError(f"{path}: cannot be written: {error.strerror or error}; the result is {partial}") from None


def holds(path: str | Path, study: Study) -> bool:
    """Whether a store holds the result of a study, computed by this version."""
    dataset = read(path)
    return dataset.attrs.get("stiction_version") == __version__ and study_of(dataset) == study


def read(path: str | Path) -> xarray.Dataset:
    """Read a result from its Zarr store, into memory.

    Raises
    ------
    StoreError
        If there is none at that path.
    """
    try:
        with xarray.open_zarr(path, consolidated=False) as stored:
            dataset: xarray.Dataset = stored.load()
    except Exception as error:  # whatever a damaged or foreign store makes of zarr and xarray
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise StoreError(f"{path}: is not a result of stiction, or is damaged: {reason}") from None
    try:
        expected = empty_dataset(study_of(dataset))
    except ValueError as error:
        raise StoreError(f"{path}: is not a result of stiction: {error}") from None
    for name, variable in expected.variables.items():
        if name not in dataset.variables:
            raise StoreError(f"{path}: is not a whole result of stiction: {name} is missing")
        stored = dataset[name].variable
        if (stored.dims, stored.shape, stored.dtype) != (variable.dims, variable.shape, variable.dtype):
            raise StoreError(f"{path}: is damaged: {name} is not what its study says")
    return dataset
