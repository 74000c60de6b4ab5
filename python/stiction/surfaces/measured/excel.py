"""Heights in workbooks of Excel (.xlsx), by openpyxl: each sheet with numbers is taken as a text of its cells."""

from __future__ import annotations

import io
import math
import re
import warnings
import zipfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from stiction.surfaces.measured.decode import decode
from stiction.surfaces.measured.raw import MOST_TEXT_BYTES, Channels, FormatError, Table, chunks
from stiction.surfaces.measured.text import table_of

MOST_TAGS = 10_000_000  # largest number of XML tags in a workbook, four for a cell with a number: 2.5 million heights
MOST_TAGS_IN_A_ROW = 8 * 16_384  # eight for each column that a sheet of Excel can have; a row is held in memory
_ROW = re.compile(rb"<(?:[\w.-]{1,40}:)?row[\s/>]")


def read_excel(data: bytes, words: tuple[str, ...] = ()) -> Channels:
    """Return the sheets of a workbook as channels; words are further marks of missing points."""
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
            sheets = {sheet.title: _rows(sheet) for sheet in workbook.worksheets}
            workbook.close()
    except (FormatError, MemoryError):
        raise
    except Exception as error:  # a package of many ways to fail
        said = " ".join(str(error).split())[:80]
        raise FormatError(f"is a damaged workbook ({type(error).__name__}: {said})") from None
    from stiction.surfaces.measured.layouts import WORKBOOKS

    layout = next((layout for layout in WORKBOOKS if layout.recognise(sheets)), None)
    if layout is not None:
        content = layout.read(sheets)
        assert isinstance(content, Table)
        return Channels(("DATA",), lambda _: _with_layout(content, layout.name), 0)
    filled = [name for name, rows in sheets.items() if _columns_of(rows)]
    if not filled:
        raise FormatError("is a workbook without a column of numbers")
    return Channels(
        tuple(filled), lambda at: table_of_sheet(sheets[filled[at]], words), 0 if len(filled) == 1 else None
    )


def _with_layout(table: Table, layout: str) -> Table:
    return replace(table, source=replace(table.source, layout=layout))


def table_of_sheet(rows: Sequence[Sequence[Any]], words: tuple[str, ...] = ()) -> Table:
    """Return the columns of numbers of a sheet, with the words above them, as a table."""
    columns = _columns_of(rows)
    lines = [_line(row, columns) for row in rows]
    content = table_of(decode(("\n".join(lines) + "\n").encode(), words))
    if not isinstance(content, Table):
        raise FormatError("has a sheet with several tables, one below the other; leave one of them")
    places = columns[: content.values.shape[1]]
    return replace(content, places=tuple(places), source=replace(content.source, encoding="", separator=""))


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


def _rows(sheet: Any) -> list[tuple[Any, ...]]:
    """Return the cells of a sheet up to its last filled row."""
    sheet.reset_dimensions()  # which a program may have written wrongly
    rows = [tuple(row) for row in sheet.iter_rows(values_only=True)]
    while rows and all(cell is None for cell in rows[-1]):
        rows.pop()
    return rows


def _is_number(cell: Any) -> bool:
    return isinstance(cell, (int, float)) and not isinstance(cell, bool)


def _columns_of(rows: Sequence[Sequence[Any]]) -> list[int]:
    """Return the columns of numbers: those with at least half as many as that with most, and more than one."""
    numbers: Counter[int] = Counter(at for row in rows for at, cell in enumerate(row) if _is_number(cell))
    most = max(numbers.values(), default=0)
    return sorted(at for at, count in numbers.items() if count > 1 and 4 * count >= most)


def _line(row: Sequence[Any], columns: list[int]) -> str:
    """Return a row as a line: the cells of the columns of numbers parted by tabs, or all of them as words."""
    chosen = [row[at] if at < len(row) else None for at in columns]
    if any(map(_is_number, chosen)) or (chosen and all(isinstance(cell, str) for cell in chosen)):
        return "\t".join("" if cell is None else " ".join(str(cell).split()) for cell in chosen)
    return "\t".join(" ".join(str(cell).split()) for cell in row if cell is not None)
