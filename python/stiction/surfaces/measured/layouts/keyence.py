"""Layout of CSV files from Keyence VK and VR microscopes, in any language.

The header contains calibration, point counts and unit.

::

    "Model","VK-X3000 Series"
    "Data type","ImageDataCsv"
    "XY Calibration","276.500","nm"
    "Output image data","Height"
    "Horizontal","32"
    "Vertical","24"
    "Unit","um"

    "Height"
    "11.844","11.917",""
"""

from __future__ import annotations

import re

import numpy as np

from stiction._text import printable_text
from stiction.surfaces.measured.decode import NUMBER_LINE_CODE, DecodedText
from stiction.surfaces.measured.header import is_unit, normalise_line
from stiction.surfaces.measured.layout import TextLayout
from stiction.surfaces.measured.raw import FileCaveat, FormatError, RawHeights, parse_length_unit, parse_positive_number
from stiction.surfaces.measured.split import detect_dialect, find_numeric_line_runs, parse_number_block
from stiction.surfaces.measured.text_table import make_height_provenance

_UNSIGNED_NUMBER_PATTERN = re.compile(r"[0-9]+(?:[.,][0-9]+)?")


def _split_cells(line: str) -> list[str]:
    return [
        cell.strip()
        for cell in re.split('[;\t]|,(?=")|(?<=[^0-9]),|,(?=[^0-9])', line.replace('"', ""))
        if cell.strip()
    ]


def _split_header_rows(text: DecodedText) -> list[list[str]]:
    """Split the header lines above the heights into cells."""
    rows = []
    for line in text.first_lines[:60]:
        quoted_cells = re.findall(r'"([^"]*)"', line)
        rows.append(
            [normalise_line(cell).strip() for cell in quoted_cells]
            if quoted_cells
            else _split_cells(normalise_line(line))
        )
    return rows


def _find_calibration_row(rows: list[list[str]]) -> int | None:
    """Return the index of the header line that states the calibration: a name, a number and a unit of length."""
    for index, row in enumerate(rows):
        if len(row) == 3 and parse_length_unit(row[1]) is None and parse_length_unit(row[2]) is not None:
            return index
    return None


def _is_keyence_text(text: DecodedText) -> bool:
    if not any("ImageDataCsv" in line for line in text.first_lines[:12]) and "VK-" not in " ".join(
        text.first_lines[:4]
    ):
        return False
    return _find_calibration_row(_split_header_rows(text)) is not None


def _read(text: DecodedText) -> RawHeights:
    rows = _split_header_rows(text)
    index = _find_calibration_row(rows)
    assert index is not None
    name, digits, unit = rows[index]
    spacing = parse_positive_number(digits, f"for {printable_text(name, 40)!r} in its header")
    two_cell_rows = [row for row in rows[index + 1 :] if len(row) == 2]
    counts = [int(row[1]) for row in two_cell_rows if re.fullmatch("[0-9]{1,6}", row[1])][:2]
    height_unit = next(
        (row[1] for row in two_cell_rows if is_unit(row[1]) and not _UNSIGNED_NUMBER_PATTERN.fullmatch(row[1])), None
    )
    runs = find_numeric_line_runs(text)
    first, last = max(runs, key=lambda run: int(text.line_starts[run[1] + 1] - text.line_starts[run[0]]))
    block = parse_number_block(text, first, last, detect_dialect(text, first, last))
    values, caveats = _extract_single_image(text, block.values, last), []
    if len(counts) == 2 and values.shape[::-1] != tuple(counts):
        if values.shape[1] != counts[0] or values.shape[0] > counts[1]:
            raise FormatError(
                f"declares a map of {counts[1]} rows of {counts[0]} heights, but has {values.shape[0]} rows of "
                f"{values.shape[1]} heights; export it again"
            )
        caveats.append(
            FileCaveat(
                "truncated", f"the header declares {counts[1]} rows, but the file has {values.shape[0]}",
                "export it again, or accept the existing rows",
            )
        )  # fmt: skip
    return RawHeights(
        values, unit=height_unit and (parse_length_unit(height_unit) or height_unit), spacing=(spacing, spacing),
        position_unit=parse_length_unit(unit), source=make_height_provenance(block), caveats=tuple(caveats),
    )  # fmt: skip


def _extract_single_image(text: DecodedText, values: np.ndarray, last: int) -> np.ndarray:
    """Return the heights of the only image in a file, or raise `FormatError` if the file contains several images.

    Raises `FormatError` if the file contains another image.
    """
    if (text.line_kinds[last + 1 :] == NUMBER_LINE_CODE).any():
        line_number = last + 1 + int(np.argmax(text.line_kinds[last + 1 :] == NUMBER_LINE_CODE))
        raise FormatError(
            f"{text.describe_line(line_number)} contains numbers of another image; export each image to its own file"
        )
    return values


LAYOUT = TextLayout("Keyence image data", _is_keyence_text, _read)
