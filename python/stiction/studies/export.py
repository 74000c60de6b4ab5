"""Results as one netCDF file, for other programs."""

from __future__ import annotations

import errno
import io
import itertools
import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

from stiction._files import new_file, replaced_file
from stiction.studies.netcdf import seal, write
from stiction.studies.store import Stored, pieces

if TYPE_CHECKING:
    import xarray

MOST_IN_MEMORY = 2**27  # bytes of a file that is made in memory first, because HDF5 may crash where a disk is full


class ExportError(ValueError):
    """A file that cannot be written."""


def export(result: xarray.Dataset | Stored, path: str | Path, *, replace: bool = False) -> None:
    """Write a result to a netCDF file, with every variable, coordinate and attribute; its numbers keep every bit.

    Parameters
    ----------
    result : xarray.Dataset or Stored
        What `run` returns, or a folder that it was written to, which is read piece by piece.
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
    if isinstance(result, Stored) and result.nbytes <= MOST_IN_MEMORY:
        result = result.dataset()
    with replaced_file(path, b"\x89HDF", ExportError) if replace else new_file(path, ExportError) as partial:
        if result.nbytes <= MOST_IN_MEMORY:
            whole = io.BytesIO()
            _write(result, whole)
            seal(whole)
            partial.write_bytes(whole.getvalue())
        elif result.nbytes <= shutil.disk_usage(partial.parent).free:
            _write(result, partial)
            with partial.open("rb+") as file:
                seal(file)
        else:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _write(result: xarray.Dataset | Stored, file: Path | io.BytesIO) -> None:
    """Write all but the members at once, and then these piece by piece."""
    if not isinstance(result, Stored) and "repetition" not in result.dims:
        write(result, file)
        return
    import h5netcdf

    parts = pieces(result)
    first = next(parts)
    along = [str(name) for name, variable in first.variables.items() if "repetition" in variable.dims]
    chunks = {name: tuple(max(1, size) for size in first[name].sizes.values()) for name in along}
    write(first.isel(repetition=slice(0)), file, growing="repetition", chunks=chunks)
    total = result.finished.size if isinstance(result, Stored) else result.sizes["repetition"]
    with h5netcdf.File(file, "a") as written:
        written.resize_dimension("repetition", total)
        begin = 0
        for piece in itertools.chain([first], parts):
            here = slice(begin, begin + piece.sizes["repetition"])
            for name in along:
                index = tuple(here if dim == "repetition" else slice(None) for dim in piece[name].dims)
                written[name][index] = piece[name].values
            begin = here.stop
