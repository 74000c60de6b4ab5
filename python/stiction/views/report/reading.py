"""HTML table of how a scan file was read: layout, points, columns, units, spacing, missing points, and caveats."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from stiction.views.report.page import escape_html

if TYPE_CHECKING:
    from stiction.surfaces.measured.reading import FileReading

LISTED_READING_OPTIONS = (
    "unit",
    "spacing",
    "columns",
    "channel",
    "missing_value",
    "missing",
    "outliers",
    "crop",
    "accept",
)
"""Names of the reading options that `file_reading_table` lists."""


def file_reading_table(reading: FileReading[Any], options: Mapping[str, Any]) -> str:
    """Return an HTML table of how a file was read, including the reading options."""
    rows = "".join(
        f'<tr><th scope="row">{escape_html(name)}</th><td>{escape_html(value)}</td></tr>'
        for name, value in file_reading_rows(reading, options)
    )
    return f'<table class="texts"><caption>How {escape_html(reading.file)} was read</caption>{rows}</table>'


def file_reading_rows(reading: FileReading[Any], options: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return pairs of texts (label, content) on how a file was read, such as layout, points and reading options."""
    source, body = reading.source, reading.body
    spacing_texts = [f"{spacing:.6g} µm along {axis}" for axis, spacing in zip("xy", body.spacings[::-1], strict=False)]
    given_options = {name: options.get(name) for name in LISTED_READING_OPTIONS}
    given_options = {name: value for name, value in given_options.items() if value and value not in ("error", "keep")}
    rows = [
        ("layout", source.layout or "not named"),
        ("points", " × ".join(map(str, body.heights.shape))),
        ("spacing", ", ".join(spacing_texts)),
        ("column or channel of heights", source.column or "the only one"),
        ("unit of heights in the file", reading.unit),
        ("missing points", f"{reading.missing} of {reading.points}"),
    ]
    if source.lines is not None:
        format_words = [
            source.encoding,
            source.separator,
            f"decimal {'comma' if source.decimal_mark == ',' else 'point'}",
        ]
        skipped_lines_text = f"{source.lines_above} above and {source.lines_below} below skipped"
        rows += [
            ("text", ", ".join(word for word in format_words if word)),
            ("lines", f"{source.lines[0]} to {source.lines[1]}; {skipped_lines_text}"),
        ]
    rows.append(
        ("given, not read from the file", ", ".join(_option_text(*item) for item in given_options.items()) or "nothing")
    )
    rows += [("caveat", f"{caveat.text}; {caveat.remedy}") for caveat in reading.caveats]
    return rows


def _option_text(name: str, value: Any) -> str:
    option_values = value if isinstance(value, (list, tuple)) else [value]
    return f"{name.replace('_', ' ')} = {', '.join(str(getattr(item, 'text', item)) for item in option_values)}"
