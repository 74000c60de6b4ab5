"""Dask is for many machines alone, but xarray imports it at its first array wherever it is: half a second."""

from __future__ import annotations

import sys
from typing import Any

_modules: dict[str, Any] = sys.modules


def hide_dask() -> None:
    """Let xarray find no Dask from now on, unless either is there already."""
    if "dask" not in _modules and "xarray" not in _modules:
        _modules["dask"] = None


def show_dask() -> None:
    """Undo `hide_dask`."""
    if _modules.get("dask", sys) is None:
        del _modules["dask"]
