"""Results as one netCDF file, for other programs."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

from stiction._files import new_file, replaced_file
from stiction.studies.netcdf import seal, write
from stiction.studies.store import Stored

if TYPE_CHECKING:
    import xarray


class ExportError(ValueError):
    """A file that cannot be written."""


def export(result: xarray.Dataset | Stored, path: str | Path, *, replace: bool = False) -> None:
    """Write a result to a netCDF file, with every variable, coordinate and attribute; its numbers keep every bit.

    Parameters
    ----------
    result : xarray.Dataset or Stored
        What `run` returns, or a folder that it was written to.
    path : path
        Must not exist yet. It appears when it is whole.
    replace : bool
        Whether it may exist, and be a netCDF file, which it then takes the place of.

    Raises
    ------
    ExportError
        If it exists or cannot be written.
    StoreError
        If a stored result takes more than 2 GiB of memory.
    """
    path = Path(path)
    dataset = result.dataset() if isinstance(result, Stored) else result
    with replaced_file(path, b"\x89HDF", ExportError) if replace else new_file(path, ExportError) as partial:
        whole = io.BytesIO()  # because HDF5 may crash where a disk is full
        write(dataset, whole)
        seal(whole)
        partial.write_bytes(whole.getbuffer())
