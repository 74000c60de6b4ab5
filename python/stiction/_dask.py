"""Dask is for many machines alone, but xarray imports it at its first array wherever it is: half a second."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from typing import Any


@contextlib.contextmanager
def without_dask() -> Iterator[None]:
    """Let xarray find no Dask, unless either is there already."""
    modules: dict[str, Any] = sys.modules
    if "dask" not in modules and "xarray" not in modules:
        modules["dask"] = None
    try:
        yield
    finally:
        with_dask()


def with_dask() -> None:
    """Undo `without_dask`."""
    if sys.modules.get("dask", sys) is None:
        del sys.modules["dask"]
