"""stiction: the coefficient of static friction of rough surfaces, from their shape.

Lengths are in µm, forces in mN, pressures in GPa (1 GPa = 1 mN/µm²); angles in rad.
"""

import ast as _ast
from importlib import import_module as _import_module
from pathlib import Path as _Path
from typing import Any as _Any

_MODULE_OF = {
    name.name: node.module
    for node in _ast.parse(_Path(__file__).with_suffix(".pyi").read_text("utf-8")).body
    if isinstance(node, _ast.ImportFrom) and node.module is not None
    for name in node.names
}
"""Where each public name is made, as the stub has it; its module is imported when the name is first asked for."""

__all__ = sorted(_MODULE_OF)


def __getattr__(name: str) -> _Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(_import_module(_MODULE_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__.copy()
