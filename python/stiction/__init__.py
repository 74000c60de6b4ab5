"""stiction: the coefficient of static friction of rough surfaces, from their shape.

Lengths are in µm, forces in mN, pressures in GPa (1 GPa = 1 mN/µm²); angles in rad.
"""

_MODULE_OF: dict[str, str] = {}
"""Module of each public name, parsed from the stub. A module is imported when one of its names is first used."""


def __getattr__(name: str) -> object:
    import ast  # imported here, because every command imports this module and most need no public name
    from importlib import import_module
    from pathlib import Path

    if not _MODULE_OF:
        for node in ast.parse(Path(__file__).with_suffix(".pyi").read_text("utf-8")).body:
            if isinstance(node, ast.ImportFrom) and node.module is not None:
                _MODULE_OF.update((alias.name, node.module) for alias in node.names)
    if name == "__all__":
        return sorted(_MODULE_OF)
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_MODULE_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __getattr__("__all__")
