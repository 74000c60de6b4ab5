"""Layout of ASCII files from SPIP (Image Metrology) and similar programs.

Sizes without a unit are in nm.

::

    # File Format = ASCII
    # x-pixels = 128
    # y-pixels = 128
    # x-length = 1000
    # y-length = 1000
    # z-unit = nm
    # Start of Data:
    0.1 0.2     0.3
"""

from __future__ import annotations

import re

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.header import normalise_line
from stiction.surfaces.measured.layout import TextLayout, parse_header_integer, parse_header_number
from stiction.surfaces.measured.raw import FormatError, RawHeights, parse_length_unit
from stiction.surfaces.measured.split import detect_dialect, find_numeric_line_runs, parse_number_block
from stiction.surfaces.measured.text_table import make_height_provenance

_HEADER_FIELD_PATTERN = re.compile(r"#?\s*([A-Za-z][\w -]{0,30}?)\s*[=:]\s*(.{0,60}?)\s*")


def _parse_header(text: DecodedText) -> dict[str, str]:
    matches = (_HEADER_FIELD_PATTERN.fullmatch(normalise_line(line)) for line in text.first_lines[:100])
    return {match[1].casefold(): match[2] for match in matches if match}


def _is_spip_text(text: DecodedText) -> bool:
    header = _parse_header(text)
    return {"x-pixels", "y-pixels", "x-length", "y-length"} <= header.keys() and text.line(0).startswith("#")


def _read(text: DecodedText) -> RawHeights:
    header = _parse_header(text)
    runs = find_numeric_line_runs(text)
    if not runs:
        raise FormatError("has no heights below its header")
    first, last = max(runs, key=lambda run: int(text.line_starts[run[1] + 1] - text.line_starts[run[0]]))
    block = parse_number_block(text, first, last, detect_dialect(text, first, last))
    rows, columns = parse_header_integer(header, "y-pixels"), parse_header_integer(header, "x-pixels")
    if block.values.shape != (rows, columns):
        raise FormatError(
            f"declares {rows} rows of {columns} heights, but contains an array of shape {block.values.shape}"
        )
    units = {header.get(f"{axis}-unit", "nm") for axis in "xy"}
    if len(units) > 1:
        raise FormatError("has lengths along x and y in different units")
    unit, factor = header.get("z-unit") or None, None
    if unit is None:
        unit = "nm"
        factor = parse_header_number(header, "bit2nm", positive=True) if "bit2nm" in header else None
    spacing = (
        parse_header_number(header, "y-length", positive=True) / rows,
        parse_header_number(header, "x-length", positive=True) / columns,
    )
    return RawHeights(
        block.values, unit=parse_length_unit(unit) or unit, factor=factor, spacing=spacing, position_unit=units.pop(),
        source=make_height_provenance(block),
    )  # fmt: skip


LAYOUT = TextLayout("SPIP ASCII", _is_spip_text, _read)
