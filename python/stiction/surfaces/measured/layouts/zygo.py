"""Layout of XYZ text files from Zygo instruments.

Fourteen header lines precede one line per point with column number, row number and height in µm.

::

    Zygo XYZ Data File - Format 1
    0 8 0 0 "..."
    0 0 0 0 0 0
    0 0 12 10
    (three lines of comments)
    0 0.5 5.81405e-07 0.08 1 0 5.88029e-06 1770655883
    (five lines)
    #
    0 0 No Data
    2 0 15.994224
    #
"""

from __future__ import annotations

import numpy as np

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.grid import MAX_NODES_PER_POINT, fill_grid
from stiction.surfaces.measured.layout import TextLayout
from stiction.surfaces.measured.raw import (
    MAX_POINTS_OF_SMALL_MAP,
    FormatError,
    RawHeights,
    parse_number,
    parse_positive_number,
)
from stiction.surfaces.measured.shapes import MAX_TABLE_GRID_POINTS
from stiction.surfaces.measured.split import Dialect, parse_number_block
from stiction.surfaces.measured.text_table import make_height_provenance

_MAP_SIZE_LINE_INDEX, _PIXEL_SIZE_LINE_INDEX = 3, 7
_PIXEL_SIZE_LINE_TEXT = f"for the pixel size in line {_PIXEL_SIZE_LINE_INDEX + 1}"


def _read(text: DecodedText) -> RawHeights:
    if not text.line(0).startswith("Zygo XYZ"):
        raise FormatError("is a Zygo phase file; export it as XYZ (.xyz), X3P or .datx")
    mark_lines = [index for index in range(min(len(text), 60)) if text.line(index) == "#"]
    if not mark_lines:
        raise FormatError("lacks the line '#' above its points")
    first = mark_lines[0] + 1
    last = next((index - 1 for index in range(len(text) - 1, first, -1) if text.line(index) == "#"), len(text) - 1)
    try:
        x0, y0, columns, rows = (int(word) for word in text.line(_MAP_SIZE_LINE_INDEX).split()[:4])
        pixel_size_text = text.line(_PIXEL_SIZE_LINE_INDEX).split()[6]
    except (ValueError, IndexError):
        raise FormatError("lacks the map size in line 4, or the pixel size in line 8") from None
    # An instrument without lateral calibration writes a pixel size of 0.
    spacing = None
    if parse_number(pixel_size_text, _PIXEL_SIZE_LINE_TEXT) != 0:
        spacing = (parse_positive_number(pixel_size_text, _PIXEL_SIZE_LINE_TEXT),) * 2
    block = parse_number_block(text, first, last, Dialect(None, "."))
    if block.values.shape[1] != 3:
        raise FormatError(f"{text.describe_line(first)} must contain a column number, a row number and a height")
    column, row, heights = block.values.T
    max_nodes = max(MAX_NODES_PER_POINT * heights.size, MAX_POINTS_OF_SMALL_MAP)
    if not (columns > 0 and rows > 0 and rows * columns <= min(max_nodes, MAX_TABLE_GRID_POINTS)):
        raise FormatError(
            f"declares in line {_MAP_SIZE_LINE_INDEX + 1} a map of {rows} rows of {columns} points; the map of a "
            f"file that lists {heights.size} points must have 1 to {min(max_nodes, MAX_TABLE_GRID_POINTS)} points"
        )
    column, row = column - x0, row - y0
    if not (np.array_equal(column, np.round(column)) and np.array_equal(row, np.round(row))):
        raise FormatError("lists points between the nodes of its grid")
    if min(column.min(), row.min()) < 0 or column.max() >= columns or row.max() >= rows:
        raise FormatError(f"lists points outside its map of {rows} rows of {columns} points")
    matrix, _ = fill_grid(
        (rows, columns), row.astype(np.int64), column.astype(np.int64), heights,
        lambda index: f"column {block.values[index, 0]:g}, row {block.values[index, 1]:g}",
    )  # fmt: skip
    return RawHeights(
        matrix, unit="um", spacing=spacing, position_unit="m" if spacing else None, source=make_height_provenance(block)
    )


LAYOUT = TextLayout(
    "Zygo XYZ", lambda text: text.line(0).startswith(("Zygo XYZ Data File", "Zygo ASCII Data File")), _read
)
