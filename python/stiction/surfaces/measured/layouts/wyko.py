"""Layout of ASCII files from Wyko and Veeco interferometers: a header, and named blocks of numbers.

Each line in the block of heights is a column of the map.

Values in a line run from the bottom of the map to its top. The second number of the first line is 1 if heights are in
nm, and otherwise they are in wavelengths. Pixel sizes are in mm, wavelengths in nm.

::

    Wyko ASCII Data File Format 0       1       1
    X Size      8
    Y Size      10
    Block Name  Type    Length  Value
    Pixel_size  7       4       0.002
    Wavelength  7       4       632.8
    Mult        7       4       2
    RAW_DATA    3       320
    -189.9246   -90.4410        Bad
"""

from __future__ import annotations

import re

import numpy as np

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.layout import TextLayout, parse_header_integer, parse_header_number
from stiction.surfaces.measured.raw import FormatError, RawHeights
from stiction.surfaces.measured.split import Dialect, parse_number_block
from stiction.surfaces.measured.text_table import make_height_provenance

_HEIGHT_BLOCK_NAMES = ("RAW_DATA", "RAW DATA", "OPD", "SAMPLE_DATA")
_FIRST_LINE_START = "Wyko ASCII Data File"


def _find_block_name(text: DecodedText, index: int) -> str | None:
    """Return the name of the block of heights that begins at line `index`.

    Returns None if no such block begins there.
    """
    line = text.line(index)
    return next((name for name in _HEIGHT_BLOCK_NAMES if re.match(rf"{name}(?:\t|\s{{2,}}|$)", line)), None)


def _read(text: DecodedText) -> RawHeights:
    header = {}
    first_line = None
    for index in range(min(len(text), 2000)):
        field_name, *further_cells = (
            text.line(index).split("\t") if "\t" in text.line(index) else re.split(r"\s{2,}", text.line(index))
        )
        if field_name.strip() in _HEIGHT_BLOCK_NAMES:
            first_line = index + 1
            break
        if further_cells:
            header[field_name.strip().casefold()] = further_cells[-1].strip()
    if first_line is None:
        raise FormatError(f"lacks a block of heights ({', '.join(_HEIGHT_BLOCK_NAMES)})")
    columns, rows = parse_header_integer(header, "X Size"), parse_header_integer(header, "Y Size")
    if first_line + columns > len(text):
        raise FormatError(f"declares {columns} lines of heights, but ends earlier")
    decimal_comma = "," in "".join(text.line(first_line + index) for index in range(min(3, columns)))
    if other_blocks := [
        name for index in range(first_line + columns, len(text)) if (name := _find_block_name(text, index))
    ]:
        raise FormatError(
            f"has several blocks of heights, {_find_block_name(text, first_line - 1)} and "
            f"{', '.join(other_blocks)}; keep one block"
        )
    block = parse_number_block(text, first_line, first_line + columns - 1, Dialect(None, "," if decimal_comma else "."))
    if block.values.shape != (columns, rows):
        raise FormatError(
            f"declares {columns} lines of {rows} heights, but has {block.values.shape[0]} lines of "
            f"{block.values.shape[1]} heights"
        )
    format_numbers = re.findall(r"[0-9]+", text.line(0).partition("Format")[2])
    factor = None
    if len(format_numbers) < 2 or format_numbers[1] == "0":
        wavelength = parse_header_number(header, "Wavelength", positive=True)
        factor = wavelength / parse_header_number(header, "Mult", 1.0, positive=True)
    pixel_size = abs(parse_header_number(header, "Pixel_size"))
    spacing = (pixel_size * parse_header_number(header, "Aspect", 1.0, positive=True), pixel_size)
    return RawHeights(
        np.ascontiguousarray(block.values.T), unit="nm", factor=factor, spacing=spacing, position_unit="mm",
        source=make_height_provenance(block),
    )  # fmt: skip


LAYOUT = TextLayout("Wyko ASCII", lambda text: text.line(0).startswith(_FIRST_LINE_START), _read)
