"""Layout of ASCII SDF files (ISO 25178-71, EUNA 15178) with profiles or maps.

Scales are in metres, and BAD marks missing points.

::

    aISO-1.0
    ManufacID = ...
    NumPoints = 200
    NumProfiles = 1
    Xscale = 5.0E-7
    Yscale = 0
    Zscale = 1.0E-6
    *
    -2.015187
    BAD
    *
"""

from __future__ import annotations

import re

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.layout import TextLayout, parse_header_integer, parse_header_number
from stiction.surfaces.measured.raw import FormatError, HeightProvenance, RawHeights
from stiction.surfaces.measured.split import parse_numbers_in_lines

_SDF_VERSION_PATTERN = re.compile(r"a(ISO|NPL|BCR|EUNA|GBS)-?\S{0,12}", re.IGNORECASE)
_OTHER_VERSION_PATTERN = re.compile(r"a[A-Z]{1,8}[- ]?V?[0-9.]{1,8}", re.IGNORECASE)  # such as "aBC-1.0"
_DECLARATION_PATTERN = re.compile(r"([A-Za-z]{1,30})\s*=\s*(\S.{0,200})?")


def _read(text: DecodedText) -> RawHeights:
    header, end = {}, None
    for index in range(1, min(len(text), 200)):
        line = text.line(index)
        if line == "*":
            end = index
            break
        if (match := _DECLARATION_PATTERN.fullmatch(line)) is not None:
            header[match[1].casefold()] = (match[2] or "").strip()
    if end is None:
        raise FormatError("lacks the line '*' above its heights")

    columns, rows = parse_header_integer(header, "NumPoints"), parse_header_integer(header, "NumProfiles")
    last = next((index for index in range(end + 1, len(text)) if text.line(index) == "*"), len(text)) - 1
    heights = parse_numbers_in_lines(text, end + 1, last)
    if heights.size != rows * columns:
        raise FormatError(f"declares {rows} profiles of {columns} points, but has {heights.size} heights")
    spacing = [parse_header_number(header, "Xscale", positive=True)]
    if rows > 1:
        heights = heights.reshape(rows, columns)
        spacing = [parse_header_number(header, "Yscale", positive=True), *spacing]
    source = HeightProvenance(separator="space", decimal_mark=".", lines=(end + 2, last + 1), lines_above=end + 1)
    return RawHeights(
        heights, unit="um", factor=parse_header_number(header, "Zscale", positive=True) * 1e6,
        spacing=tuple(step * 1e6 for step in spacing), position_unit="um", source=source,
    )  # fmt: skip


def _is_sdf(text: DecodedText) -> bool:
    """Return whether a text is in SDF format: line 1 names a known version or, if declarations follow, any version."""
    if _SDF_VERSION_PATTERN.fullmatch(text.line(0)) is not None:
        return True
    matches = map(_DECLARATION_PATTERN.fullmatch, text.first_lines[1:30])
    names = {match[1].casefold() for match in matches if match is not None}
    return _OTHER_VERSION_PATTERN.fullmatch(text.line(0)) is not None and {"numpoints", "zscale"} <= names


LAYOUT = TextLayout("SDF", _is_sdf, _read)
