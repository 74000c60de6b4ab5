"""Heights in workbooks of Excel (.xlsx), by openpyxl: each sheet with numbers is taken as a text of its cells."""

from __future__ import annotations

import io
import math
import re
import warnings
import zipfile
from collections import Counter
from typing import Any

from stiction.surfaces.measured.raw import MOST_TEXT_BYTES, Channels, FormatError, Table, chunks
from stiction.surfaces.measured.text import read_lines

MOST_TAGS = 10_000_000  # largest number of XML tags in a workbook, four for a cell with a number: 2.5 million heights
MOST_TAGS_IN_A_ROW = 8 * 16_384  # eight for each column that a sheet of Excel can have; a row is held in memory
_ROW = re.compile(rb"<(?:[\w.-]{1,40}:)?row[\s/>]")


def read_excel(data: bytes) -> Channels:
    """Take a workbook apart; its sheets are channels."""
    try:
        with warnings.catch_warnings(action="ignore"):  # of the style of workbooks
            from openpyxl import load_workbook
    except ImportError:
        raise FormatError(
            "is a workbook of Excel, which the package openpyxl reads: pip install openpyxl; or save the sheet as .csv"
        ) from None
    try:
        _refuse_bombs(data)
        with warnings.catch_warnings(action="ignore"):
            workbook = load_workbook(io.BytesIO(data), read_only=True, data_only=True)
            sheets = {sheet.title: _lines(sheet) for sheet in workbook.worksheets}
            workbook.close()
    except (FormatError, MemoryError):
        raise
    except Exception as error:  # a package of many ways to fail
        said = " ".join(str(error).split())[:80]
        raise FormatError(f"is a damaged workbook ({type(error).__name__}: {said})") from None
    named = {name: lines for name, lines in sheets.items() if lines}
    if not named:
        raise FormatError("is a workbook without a column of numbers")
    names = tuple(named)

    def read(at: int) -> Table:
        return read_lines(named[names[at]])

    return Channels(names, read, 0 if len(names) == 1 else None)


def _refuse_bombs(data: bytes) -> None:
    """Refuse an archive of more text, or more XML tags, than memory holds, whatever its directory says."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        left, tags = MOST_TEXT_BYTES, 0
        for name in archive.namelist():
            tags_in_row = -math.inf  # before the first row, and so in what is no sheet
            for chunk in chunks(archive, name, left):
                left -= len(chunk)
                tags += chunk.count(b"<")
                if tags > MOST_TAGS:
                    raise FormatError(f"holds more than {MOST_TAGS} tags of XML; save the sheet as .csv")
                before, *rows = (part.count(b"<") for part in _ROW.split(chunk))
                if max(tags_in_row + before, *rows, 0) > MOST_TAGS_IN_A_ROW:
                    raise FormatError("has a sheet with more cells in a row than Excel can have")
                tags_in_row = rows[-1] if rows else tags_in_row + before


def _lines(sheet: Any) -> list[str]:
    """The rows of a sheet as lines: the cells of the columns of numbers parted by tabs, any other row as words."""
    sheet.reset_dimensions()  # which a program may have written wrongly
    rows = []
    numbers: Counter[int] = Counter()
    for row in sheet.iter_rows(values_only=True):
        filled = {at: text for at, cell in enumerate(row) if cell is not None and (text := " ".join(str(cell).split()))}
        numbered = {at for at in filled if isinstance(row[at], (int, float)) and not isinstance(row[at], bool)}
        numbers.update(numbered)
        rows.append((filled, numbered))
    columns = sorted(at for at, count in numbers.items() if count > 1)  # or it is one beside other words
    lines = []
    for filled, numbered in rows:
        if filled.keys() <= set(columns) or numbered.issuperset(columns):
            lines.append("\t".join(filled.get(at, "") for at in columns))
        else:
            lines.append(" ".join(filled.values()))
    return lines if columns else []
