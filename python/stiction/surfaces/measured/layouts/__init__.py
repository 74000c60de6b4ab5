"""Layouts of the text files and workbooks that instruments write, one layout per module.

Each module defines `LAYOUT`, a `TextLayout`, or `WORKBOOK_LAYOUT`, a `WorkbookLayout`. Its docstring contains an
example.
"""

from __future__ import annotations

import pkgutil
from importlib import import_module

from stiction.surfaces.measured.layout import TextLayout, WorkbookLayout

_LAYOUT_MODULES = [import_module(f"{__name__}.{module.name}") for module in pkgutil.iter_modules(__path__)]

TEXT_LAYOUTS: tuple[TextLayout, ...] = tuple(module.LAYOUT for module in _LAYOUT_MODULES if hasattr(module, "LAYOUT"))
WORKBOOK_LAYOUTS: tuple[WorkbookLayout, ...] = tuple(
    module.WORKBOOK_LAYOUT for module in _LAYOUT_MODULES if hasattr(module, "WORKBOOK_LAYOUT")
)
