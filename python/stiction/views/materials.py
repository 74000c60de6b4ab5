"""Table of materials with numbered sources, as text or JSON."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stiction._estimate import Estimate
from stiction.views.json_record import record_json
from stiction.views.layout import format_table, wrap_text

if TYPE_CHECKING:
    from stiction.mechanics.materials import Material, MaterialValue

_PROPERTY_UNITS = {"young_modulus": "GPa", "poisson_ratio": "1", "hardness": "GPa"}


def materials_text(materials: Sequence[Material]) -> str:
    """Return a table of materials as text: a section per kind of material, with ranges of properties and sources."""
    sources: dict[str, int] = {}

    def value_cell(value: MaterialValue | None) -> str:
        if value is None:
            return "does not yield"
        text = f"{value.low:g}" if value.low == value.high else f"{value.low:g}\N{EN DASH}{value.high:g}"
        return f"{text} [{sources.setdefault(value.source, len(sources) + 1)}]"

    rows = []
    for material_kind, materials_of_kind in itertools.groupby(materials, key=lambda material: material.kind):
        rows.append([f"{material_kind}", "E (GPa)", "ν", "hardness (GPa)"])
        rows += [
            [material.name, *(value_cell(getattr(material, name)) for name in _PROPERTY_UNITS)]
            for material in materials_of_kind
        ]
    alias_lines = [f"{material.name}: {', '.join(material.aliases)}" for material in materials if material.aliases]
    paragraphs = [
        format_table(rows),
        *([wrap_text(f"Also known as: {'; '.join(alias_lines)}.")] if alias_lines else []),
    ]
    paragraphs.append(
        "\n".join(wrap_text(f"[{number}] {source}", hanging_indent="    ") for source, number in sources.items())
    )
    return "\n\n".join(paragraphs) + "\n"


def materials_json(materials: Sequence[Material]) -> str:
    """Return materials with the ranges of their properties as JSON."""
    entries: list[dict[str, Any]] = []
    for material in materials:
        entries.append({"name": material.name, "kind": material.kind, "aliases": list(material.aliases)})
        for name, unit in _PROPERTY_UNITS.items():
            value = getattr(material, name)
            entries[-1][name] = value and {
                "estimate": Estimate(
                    float(value), value.low, value.high, name=name, unit=unit, kind="range"
                ).to_record(),
                "source": value.source,
            }
    return record_json("materials", [], materials=entries)
