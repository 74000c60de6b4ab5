"""Results as one file, for other programs."""

from __future__ import annotations

from pathlib import Path

import xarray

from stiction._files import new_file


class ExportError(ValueError):
    """A file that cannot be written."""


def export(dataset: xarray.Dataset, path: str | Path) -> None:
    """Write a result to a netCDF file, with every variable, coordinate and attribute; its numbers keep every bit.

    Parameters
    ----------
    dataset : xarray.Dataset
        What `run` returns.
    path : path
        Must not exist yet. It appears when it is whole.

    Raises
    ------
    ExportError
        If it exists or cannot be written.
    """
    with new_file(Path(path), ExportError) as partial:
        # Nothing is missing, so no number means that.
        encoding = {name: {"_FillValue": None} for name in dataset.variables}
        # Whole in memory first: HDF5 itself crashes where a disk is full.
        partial.write_bytes(dataset.to_netcdf(None, engine="h5netcdf", encoding=encoding))
