"""Reading of Excel workbooks (.xlsx) with openpyxl. Every sheet that contains numbers is parsed as text."""

from __future__ import annotations

import io
import itertools
import math
import re
import warnings
import zipfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from stiction.surfaces.measured.decode import decode_text
from stiction.surfaces.measured.raw import MAX_TEXT_BYTES, ColumnTable, FormatError, HeightChannels, read_member_chunks
from stiction.surfaces.measured.text import parse_table

# Maximum number of XML tags in a workbook. Each number takes four tags, so a workbook may contain 2.5 million heights.
MAX_WORKBOOK_TAGS = 10_000_000
# Maximum number of XML tags in a row: eight tags for each column of the largest sheet.
# The number of tags is limited because each row is stored in memory.
MAX_TAGS_PER_ROW = 8 * 16_384
_ROW_TAG_PATTERN = re.compile(rb"<(?:[\w.-]{1,40}:)?row[\s/>]")


def read_excel(data: bytes, words: tuple[str, ...] = ()) -> HeightChannels:
    """Return the sheets of a workbook as channels. `words` are additional words that mark missing points."""
    try:
        with warnings.catch_warnings(action="ignore"):  # openpyxl warns about the styles of workbooks
            from openpyxl import load_workbook
    except ImportError:
        raise FormatError(
            "is an Excel workbook; install openpyxl to read it (pip install openpyxl), or save the sheet as .csv"
        ) from None
    try:
        _reject_zip_bombs(data)
        with warnings.catch_warnings(action="ignore"):
            workbook = load_workbook(io.BytesIO(data), read_only=True, data_only=True)
            sheets = {sheet.title: _read_rows(sheet) for sheet in workbook.worksheets}
            workbook.close()
    except (FormatError, MemoryError):
        raise
    except Exception as error:  # openpyxl raises many kinds of errors
        reason = " ".join(str(error).split())[:80]
        raise FormatError(f"is a damaged workbook ({type(error).__name__}: {reason})") from None
    from stiction.surfaces.measured.layouts import WORKBOOK_LAYOUTS

    layout = next((layout for layout in WORKBOOK_LAYOUTS if layout.recognises(sheets)), None)
    if layout is not None:
        content = layout.read(sheets)
        assert isinstance(content, ColumnTable)
        return HeightChannels(("DATA",), lambda _: _record_layout(content, layout.name), 0)
    filled_sheets = [name for name, rows in sheets.items() if _find_numeric_columns(rows)]
    if not filled_sheets:
        raise FormatError("is a workbook without a column of numbers")
    return HeightChannels(
        tuple(filled_sheets),
        lambda index: parse_sheet(sheets[filled_sheets[index]], words),
        0 if len(filled_sheets) == 1 else None,
    )


def _record_layout(table: ColumnTable, layout: str) -> ColumnTable:
    return replace(table, source=replace(table.source, layout=layout))


def parse_sheet(rows: Sequence[Sequence[Any]], words: tuple[str, ...] = ()) -> ColumnTable:
    """Parse the largest table of numbers in a sheet, and the header above it."""
    columns = _find_table_columns(rows)
    lines = [_join_row_cells(row, columns) for row in rows]
    content = parse_table(decode_text(("\n".join(lines) + "\n").encode(), words))
    if not isinstance(content, ColumnTable):
        raise FormatError("has a sheet with several tables, one below another; keep only one table")
    column_numbers = columns[: content.values.shape[1]]
    return replace(content, places=tuple(column_numbers), source=replace(content.source, encoding="", separator=""))


def _reject_zip_bombs(data: bytes) -> None:
    """Reject an archive with too much text or too many XML tags, regardless of the sizes that the archive declares."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        remaining_bytes, tag_count = MAX_TEXT_BYTES, 0
        for name in archive.namelist():
            tags_in_row = -math.inf  # no limit applies before the first row; a file that is not a sheet has no rows
            for chunk in read_member_chunks(archive, name, remaining_bytes):
                remaining_bytes -= len(chunk)
                tag_count += chunk.count(b"<")
                if tag_count > MAX_WORKBOOK_TAGS:
                    raise FormatError(f"contains more than {MAX_WORKBOOK_TAGS} XML tags; save the sheet as .csv")
                first_part, *rows = (piece.count(b"<") for piece in _ROW_TAG_PATTERN.split(chunk))
                if max(tags_in_row + first_part, *rows, 0) > MAX_TAGS_PER_ROW:
                    raise FormatError("has a sheet with more cells in a row than Excel allows")
                tags_in_row = rows[-1] if rows else tags_in_row + first_part


def _read_rows(sheet: Any) -> list[tuple[Any, ...]]:
    """Return the cells of a sheet up to its last filled row."""
    sheet.reset_dimensions()  # the dimensions that the file declares for a sheet may be wrong
    rows = [tuple(row) for row in sheet.iter_rows(values_only=True)]
    while rows and all(cell is None for cell in rows[-1]):
        rows.pop()
    return rows


def _is_number_cell(cell: Any) -> bool:
    return isinstance(cell, (int, float)) and not isinstance(cell, bool)


def _find_numeric_columns(rows: Sequence[Sequence[Any]]) -> list[int]:
    """Return the columns with two or more numbers and at least a quarter as many numbers as the fullest column."""
    number_counts: Counter[int] = Counter(
        index for row in rows for index, cell in enumerate(row) if _is_number_cell(cell)
    )
    max_count = max(number_counts.values(), default=0)
    return sorted(index for index, count in number_counts.items() if count > 1 and 4 * count >= max_count)


def _find_data_rows(rows: Sequence[Sequence[Any]], columns: Sequence[int]) -> range:
    """Return the longest run of rows that have a number in at least one of the columns."""
    has_number = [any(map(_is_number_cell, _select_cells(row, columns))) for row in rows]
    runs = [list(run) for is_run, run in itertools.groupby(range(len(rows)), has_number.__getitem__) if is_run]
    longest_run = max(runs, key=len)
    return range(longest_run[0], longest_run[-1] + 1)


def _find_table_columns(rows: Sequence[Sequence[Any]]) -> list[int]:
    """Return the numeric columns, and all columns that adjoin them in the data rows.

    An adjoining column contains words, or numbers in a few rows only. An empty column separates two tables.
    """
    numeric_columns = _find_numeric_columns(rows)
    data_rows = _find_data_rows(rows, numeric_columns)
    filled_columns = {
        index for row in rows[data_rows.start : data_rows.stop] for index, cell in enumerate(row) if cell is not None
    }
    columns: list[int] = []
    for _, group in itertools.groupby(
        enumerate(sorted(filled_columns | set(numeric_columns))), lambda item: item[1] - item[0]
    ):
        adjoining_columns = [index for _, index in group]
        columns += adjoining_columns if set(adjoining_columns) & set(numeric_columns) else []
    return columns


def _select_cells(row: Sequence[Any], columns: Sequence[int]) -> list[Any]:
    return [row[index] if index < len(row) else None for index in columns]


def _join_row_cells(row: Sequence[Any], columns: Sequence[int]) -> str:
    """Join cells of a row with tabs: the table columns of data rows and heading rows, and all cells of other rows."""
    selected_cells = _select_cells(row, columns)
    if any(map(_is_number_cell, selected_cells)) or (
        selected_cells and all(isinstance(cell, str) for cell in selected_cells)
    ):
        return "\t".join("" if cell is None else " ".join(str(cell).split()) for cell in selected_cells)
    return "\t".join(" ".join(str(cell).split()) for cell in row if cell is not None)
