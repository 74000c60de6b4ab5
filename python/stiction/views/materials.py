"""Materials as a table for the terminal, with numbered sources, and as JSON."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stiction.views.rows import record
from stiction.views.text import aligned, fitted

if TYPE_CHECKING:
    from stiction.mechanics.materials import Material, MaterialValue

_PROPERTIES = {"young_modulus": "GPa", "poisson_ratio": "1", "hardness": "GPa"}


def materials_text(chosen: Sequence[Material]) -> str:
    """A table of ranges, those of a kind one after the other, and what the numbers in brackets are."""
    sources: dict[str, int] = {}

    def cell(value: MaterialValue | None) -> str:
        if value is None:
            return "does not yield"
        shown = f"{value.low:g}" if value.low == value.high else f"{value.low:g}\N{EN DASH}{value.high:g}"
        return f"{shown} [{sources.setdefault(value.source, len(sources) + 1)}]"

    rows = []
    for kind, group in itertools.groupby(chosen, key=lambda each: each.kind):
        rows.append([f"{kind}", "E (GPa)", "ν", "hardness (GPa)"])
        rows += [[each.name, *(cell(getattr(each, name)) for name in _PROPERTIES)] for each in group]
    others = [f"{each.name}: {', '.join(each.aliases)}" for each in chosen if each.aliases]
    parts = [aligned(rows), *([fitted(f"Also known as: {'; '.join(others)}.")] if others else [])]
    parts.append("\n".join(fitted(f"[{number}] {source}", hang="    ") for source, number in sources.items()))
    return "\n\n".join(parts) + "\n"


def materials_record(chosen: Sequence[Material]) -> str:
    """The same as JSON."""
    entries: list[dict[str, Any]] = []
    for each in chosen:
        entries.append({"name": each.name, "kind": each.kind, "aliases": list(each.aliases)})
        for name, unit in _PROPERTIES.items():
            value = getattr(each, name)
            entries[-1][name] = value and {
                "value": float(value), "low": value.low, "high": value.high, "unit": unit, "source": value.source
            }  # fmt: skip
    return record("materials", [], materials=entries)
