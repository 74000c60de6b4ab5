"""Layout of Surfer ASCII grids.

The header contains the numbers of points and the limits of x and y. The first heights are at the smallest y.

::

    DSAA
    32 24
    0 15.5
    0 5.75
    -2.316 2.551
    -0.970469 -1.285646 -1.508537
"""

from __future__ import annotations

import numpy as np

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.layout import MAX_DECLARED_COUNT, TextLayout
from stiction.surfaces.measured.raw import FormatError, HeightProvenance, RawHeights, parse_number
from stiction.surfaces.measured.split import parse_numbers_in_lines

_FIRST_LINE = "DSAA"
_MIN_MISSING_POINT_CODE = 1.7e38
_HEADER_LINES = ("the counts of x and y", "the range of x", "the range of y", "the range of heights")


def _read(text: DecodedText) -> RawHeights:
    lines = [index for index in range(1, min(len(text), 40)) if text.line(index)][: len(_HEADER_LINES)]
    header = []
    for index, name in zip(lines, _HEADER_LINES, strict=False):
        words = text.line(index).split()
        header.append([parse_number(word, f"for {name} in line {index + 1}") for word in words[:2]])
    if len(header) < len(_HEADER_LINES) or any(len(pair) < 2 for pair in header):
        raise FormatError("lacks the counts and ranges of a Surfer grid below its first line")
    (columns, rows), (x0, x1), (y0, y1), _ = header
    if not all(count.is_integer() and 2 <= count <= MAX_DECLARED_COUNT for count in (columns, rows)):
        raise FormatError(f"declares {rows:g} rows of {columns:g} heights; both numbers must be whole and above 1")
    if not (x1 > x0 and y1 > y0):
        raise FormatError("declares a range of x or y whose end is not above its start")
    first, last = lines[-1] + 1, len(text) - 1
    heights = parse_numbers_in_lines(text, first, last)
    if heights.size != rows * columns:
        raise FormatError(f"declares {rows:g} rows of {columns:g} heights, but has {heights.size} heights")
    source = HeightProvenance(separator="space", decimal_mark=".", lines=(first + 1, last + 1), lines_above=first)
    return RawHeights(
        np.where(heights >= _MIN_MISSING_POINT_CODE, np.nan, heights).reshape(int(rows), int(columns)),
        spacing=((y1 - y0) / (rows - 1), (x1 - x0) / (columns - 1)), source=source,
    )  # fmt: skip


LAYOUT = TextLayout("Surfer grid", lambda text: text.line(0) == _FIRST_LINE, _read)
