"""Write the table of materials with the source of every number: docs/generated/materials.md."""

from pathlib import Path

from stiction import MaterialValue, materials

TABLE_FILE = Path(__file__).parent.parent / "generated/materials.md"


def format_range(value: MaterialValue) -> str:
    return f"{value.low:g}" if value.low == value.high else f"{value.low:g} to {value.high:g}"


def format_table() -> str:
    """Return a table with one row per material, and the numbered sources below."""
    sources: list[str] = []

    def format_value_with_source(value: MaterialValue | None) -> str:
        if value is None:
            return "does not yield"
        if value.source not in sources:
            sources.append(value.source)
        return f"{format_range(value)} [{sources.index(value.source) + 1}]"

    lines = ["| material | kind | E (GPa) | ν | hardness (GPa) | also called |", "|---|---|---|---|---|---|"]
    for material in materials():
        values = " | ".join(
            format_value_with_source(value)
            for value in (material.young_modulus, material.poisson_ratio, material.hardness)
        )
        lines.append(f"| {material.name} | {material.kind} | {values} | {', '.join(material.aliases)} |")
    lines += ["", *(f"{number}. {source}" for number, source in enumerate(sources, start=1))]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    TABLE_FILE.write_text(format_table(), encoding="utf-8")
