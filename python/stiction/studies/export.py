"""Results as one file, for other programs."""

from __future__ import annotations

from pathlib import Path

import xarray

from stiction._files import new_file, replaced_file


class ExportError(ValueError):
    """A file that cannot be written."""


def export(dataset: xarray.Dataset, path: str | Path, *, replace: bool = False) -> None:
    """Write a result to a netCDF file, with every variable, coordinate and attribute; its numbers keep every bit.

    Parameters
    ----------
    dataset : xarray.Dataset
        What `run` returns.
    path : path
        Must not exist yet. It appears when it is whole.
    replace : bool
        Whether it may exist, and be a netCDF file, which it then takes the place of.

    Raises
    ------
    ExportError
        If it exists or cannot be written.
    """
    path = Path(path)
    with replaced_file(path, b"\x89HDF", ExportError) if replace else new_file(path, ExportError) as partial:
        # Nothing is missing, so no number means that.
        encoding = {name: {"_FillValue": None} for name in dataset.variables}
        # Whole in memory first: HDF5 itself crashes where a disk is full.
        partial.write_bytes(dataset.to_netcdf(None, engine="h5netcdf", encoding=encoding))
