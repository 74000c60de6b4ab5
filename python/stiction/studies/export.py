"""Results as one file, for other programs."""

from __future__ import annotations

import errno
import io
import os
import shutil
from collections.abc import Hashable
from pathlib import Path
from typing import Any

import xarray

from stiction._files import new_file, replaced_file
from stiction.studies.streams import pieces, repetitions_of_piece

MOST_IN_MEMORY = 2**27
"""Bytes of a file that is made in memory first: HDF5 itself crashes where a disk is full."""


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
        if dataset.nbytes <= MOST_IN_MEMORY:
            whole = io.BytesIO()
            _write(dataset, whole)
            partial.write_bytes(whole.getvalue())
        elif dataset.nbytes <= shutil.disk_usage(partial.parent).free:
            _write(dataset, partial)
        else:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _write(dataset: xarray.Dataset, file: Path | io.BytesIO) -> None:
    """All but the repetitions at once; then these, by as many as are in memory at a time."""
    import h5netcdf

    # Nothing is missing, so no number means that.
    encoding: dict[Hashable, dict[str, Any]] = {name: {"_FillValue": None} for name in dataset.variables}
    if "repetition" not in dataset.dims:
        dataset.to_netcdf(file, engine="h5netcdf", encoding=encoding)
        return
    streamed = [name for name, variable in dataset.variables.items() if "repetition" in variable.dims]
    in_chunk = min(repetitions_of_piece(dataset), max(1, dataset.sizes["repetition"]))
    for name in streamed:
        sizes = dataset[name].sizes
        encoding[name]["chunksizes"] = tuple(in_chunk if dim == "repetition" else max(1, sizes[dim]) for dim in sizes)
    none = dataset.isel(repetition=slice(0))
    none.to_netcdf(file, engine="h5netcdf", encoding=encoding, unlimited_dims=["repetition"])
    with h5netcdf.File(file, "a") as written:
        written.resize_dimension("repetition", dataset.sizes["repetition"])
        first = 0
        for piece in pieces(dataset, [name for name in dataset.data_vars if name in streamed]):
            here = slice(first, first + piece.sizes["repetition"])
            for name in (*piece.data_vars, "repetition"):
                if name in piece.variables:
                    index = tuple(here if dim == "repetition" else slice(None) for dim in piece[name].dims)
                    written[str(name)][index] = piece[name].values
            first = here.stop
