"""Layout of Mitutoyo SurfTest workbooks.

Sheet DATA has parameters in column A, positions in column E, and heights in column F.

The parameters contain the unit of heights. The cutoff, on the sheet Certificate or in column B, contains the unit of
positions. Material ratio curves may be in columns C and D, and in columns G and H.

::

    Ra     0.018  µm    | CUT 2.5mm |   |   | 0.0005 |  0.3033
    Rq     0.027  µm    | N 4       |   |   | 0.0010 | -0.0275
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from dataclasses import replace

from stiction.surfaces.measured.layout import WorkbookLayout, WorkbookSheets
from stiction.surfaces.measured.raw import ColumnTable, parse_length_unit
from stiction.surfaces.measured.sheet_table import parse_sheet

_PARAMETER_PATTERN = re.compile(r"\s*[A-Z][\w(). ]{0,12}?\s+[+-]?[0-9.,]+\s*([^\W\d_]{1,3})\s*")
_CUT_OFF_PATTERN = re.compile(r"\s*[0-9.,]+\s*([^\W\d_]{1,3})\s*")


def _is_mitutoyo_workbook(sheets: WorkbookSheets) -> bool:
    return {"DATA", "Certificate"} <= sheets.keys() and _find_height_unit(sheets) is not None


def _find_height_unit(sheets: WorkbookSheets) -> str | None:
    cells = (str(row[0]) for row in sheets["DATA"][:40] if row and isinstance(row[0], str))
    return next(
        (
            unit
            for cell in cells
            if (match := _PARAMETER_PATTERN.fullmatch(cell)) and (unit := parse_length_unit(match[1]))
        ),
        None,
    )


_PROFILE_COLUMNS = (4, 5)  # E and F
_CUT_OFF_CONDITION_PATTERN = re.compile(r"\s*CUT\s*([0-9.,]+\s*[^\W\d_]{1,3})\s*", re.IGNORECASE)


def _find_cut_off_texts(sheets: WorkbookSheets) -> Iterator[str]:
    for row in sheets["Certificate"]:
        for name, cell in itertools.pairwise(row):
            if isinstance(name, str) and "cut-off" in name.casefold() and isinstance(cell, str):
                yield cell
    for row in sheets["DATA"][:40]:
        if len(row) > 1 and isinstance(row[1], str) and (match := _CUT_OFF_CONDITION_PATTERN.fullmatch(row[1])):
            yield match[1]


def _read(sheets: WorkbookSheets) -> ColumnTable:
    rows = sheets["DATA"]
    profile = [row[_PROFILE_COLUMNS[0] : _PROFILE_COLUMNS[1] + 1] for row in rows]
    if not any(isinstance(cell, (int, float)) for row in profile for cell in row[1:]):
        return parse_sheet(rows)
    table = parse_sheet(profile)
    cut_offs = (match for cell in _find_cut_off_texts(sheets) if (match := _CUT_OFF_PATTERN.fullmatch(cell)))
    lateral_unit = next((unit for match in cut_offs if (unit := parse_length_unit(match[1]))), None)
    if table.values.shape[1] != 2:
        return parse_sheet(rows)
    return replace(table, units=(lateral_unit, _find_height_unit(sheets)), places=_PROFILE_COLUMNS)


WORKBOOK_LAYOUT = WorkbookLayout("Mitutoyo workbook", _is_mitutoyo_workbook, _read)
