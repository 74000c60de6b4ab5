"""Write the table of materials with the source of every number: docs/generated/materials.md."""

from pathlib import Path

from stiction import MaterialValue, materials

OUT = Path(__file__).parent.parent / "generated/materials.md"


def shown(value: MaterialValue) -> str:
    return f"{value.low:g}" if value.low == value.high else f"{value.low:g} to {value.high:g}"


def table() -> str:
    """Return a table with a row for each material and numbered sources below."""
    sources: list[str] = []

    def marked(value: MaterialValue | None) -> str:
        if value is None:
            return "does not yield"
        if value.source not in sources:
            sources.append(value.source)
        return f"{shown(value)} [{sources.index(value.source) + 1}]"

    lines = ["| material | kind | E (GPa) | ν | hardness (GPa) | also called |", "|---|---|---|---|---|---|"]
    for each in materials():
        values = " | ".join(marked(value) for value in (each.young_modulus, each.poisson_ratio, each.hardness))
        lines.append(f"| {each.name} | {each.kind} | {values} | {', '.join(each.aliases)} |")
    lines += ["", *(f"{number}. {source}" for number, source in enumerate(sources, start=1))]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    OUT.write_text(table(), encoding="utf-8")
