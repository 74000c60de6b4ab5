"""Layouts of texts and workbooks of instruments, one in each module of this package.

A module has `LAYOUT`, a `Layout`, or `WORKBOOK`, a `WorkbookLayout`, and an example of the layout in its docstring.
"""

from __future__ import annotations

import pkgutil
from importlib import import_module

from stiction.surfaces.measured.layout import Layout, WorkbookLayout

_MODULES = [import_module(f"{__name__}.{each.name}") for each in pkgutil.iter_modules(__path__)]

LAYOUTS: tuple[Layout, ...] = tuple(module.LAYOUT for module in _MODULES if hasattr(module, "LAYOUT"))
WORKBOOKS: tuple[WorkbookLayout, ...] = tuple(module.WORKBOOK for module in _MODULES if hasattr(module, "WORKBOOK"))
