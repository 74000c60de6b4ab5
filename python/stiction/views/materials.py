"""Format materials as a table with numbered sources, or as JSON."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stiction.views.rows import record_json
from stiction.views.text import format_table, wrap_text

if TYPE_CHECKING:
    from stiction.mechanics.materials import Material, MaterialValue

_PROPERTIES = {"young_modulus": "GPa", "poisson_ratio": "1", "hardness": "GPa"}


def materials_text(chosen: Sequence[Material]) -> str:
    """Format a table of ranges grouped by kind of material, followed by the numbered sources."""
    sources: dict[str, int] = {}

    def cell(value: MaterialValue | None) -> str:
        if value is None:
            return "does not yield"
        text = f"{value.low:g}" if value.low == value.high else f"{value.low:g}\N{EN DASH}{value.high:g}"
        return f"{text} [{sources.setdefault(value.source, len(sources) + 1)}]"

    rows = []
    for kind, group in itertools.groupby(chosen, key=lambda item: item.kind):
        rows.append([f"{kind}", "E (GPa)", "ν", "hardness (GPa)"])
        rows += [[item.name, *(cell(getattr(item, name)) for name in _PROPERTIES)] for item in group]
    others = [f"{item.name}: {', '.join(item.aliases)}" for item in chosen if item.aliases]
    parts = [format_table(rows), *([wrap_text(f"Also known as: {'; '.join(others)}.")] if others else [])]
    parts.append("\n".join(wrap_text(f"[{number}] {source}", hang="    ") for source, number in sources.items()))
    return "\n\n".join(parts) + "\n"


def materials_record(chosen: Sequence[Material]) -> str:
    """Return materials as a JSON record."""
    entries: list[dict[str, Any]] = []
    for item in chosen:
        entries.append({"name": item.name, "kind": item.kind, "aliases": list(item.aliases)})
        for name, unit in _PROPERTIES.items():
            value = getattr(item, name)
            entries[-1][name] = value and {
                "value": float(value), "low": value.low, "high": value.high, "unit": unit, "source": value.source
            }  # fmt: skip
    return record_json("materials", [], materials=entries)
