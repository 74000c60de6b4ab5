"""Results as one file, for other programs."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import xarray


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
    path = Path(path)
    partial = path.with_name(f"{path.name}.partial-{os.getpid()}")
    try:
        if os.path.lexists(path):
            raise FileExistsError
        # Nothing is missing, so no number means that.
        encoding = {name: {"_FillValue": None} for name in dataset.variables}
        dataset.to_netcdf(partial, engine="h5netcdf", encoding=encoding)
        os.link(partial, path)  # unlike a rename, never over another file
    except FileExistsError:
        raise ExportError(f"{path}: exists already; remove it, or choose another name") from None
    except (OSError, RuntimeError) as error:  # RuntimeError: what HDF5 makes of a full disk when it closes a file
        reason = os.strerror(error.errno) if isinstance(error, OSError) and error.errno else error
        raise ExportError(f"{path}: cannot be written: {reason}") from None
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)
