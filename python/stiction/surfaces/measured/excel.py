"""Reader for Excel workbooks (.xlsx), based on openpyxl. Every sheet with numbers is parsed like a text table."""

from __future__ import annotations

import io
import itertools
import math
import re
import warnings
import zipfile
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from stiction.surfaces.measured.layouts import WORKBOOK_LAYOUTS
from stiction.surfaces.measured.raw import MAX_TEXT_BYTES, ColumnTable, FormatError, HeightChannels, read_member_chunks
from stiction.surfaces.measured.sheet_table import _find_numeric_columns, parse_sheet

# Maximum number of XML tags in a workbook: four tags for each of 2.5 million heights.
MAX_WORKBOOK_TAGS = 10_000_000
# Maximum number of XML tags in a row of cells, which limits the memory use: eight for each of 16 384 columns.
MAX_TAGS_PER_ROW = 8 * 16_384
_UNEVALUATED_FORMULA_TEXT = "unevaluated formula"
_UNEVALUATED_FORMULA_PATTERN = re.compile(
    rb"</(?:\w+:)?f>\s*(?:<(?:\w+:)?v\s*(?:/>|>\s*</(?:\w+:)?v>)\s*)?</(?:\w+:)?c>"
)
_Rows = list[tuple[Any, ...]]
_ROW_TAG_PATTERN = re.compile(rb"<(?:[\w.-]{1,40}:)?row[\s/>]")


def read_excel(data: bytes, words: tuple[str, ...] = ()) -> HeightChannels:
    """Read the sheets of an Excel workbook, one channel per sheet.

    `words` are additional words that mark missing points.
    """
    try:
        # Openpyxl warns about the styles of a workbook, but only the values of cells are read.
        with warnings.catch_warnings(action="ignore"):
            from openpyxl import load_workbook
    except ImportError:
        raise FormatError(
            "is an Excel workbook; install openpyxl to read it (pip install openpyxl), or save the sheet as .csv"
        ) from None
    try:
        has_formulas_without_values = _check_archive(data)
        sheets = _read_sheets(load_workbook, data, data_only=True)
        if has_formulas_without_values:
            formulas = _read_sheets(load_workbook, data, data_only=False)
            sheets = {title: _mark_formulas_without_values(rows, formulas[title]) for title, rows in sheets.items()}
    except (FormatError, MemoryError):
        raise
    except Exception as error:
        # Openpyxl raises many classes of errors for a damaged workbook.
        reason = " ".join(str(error).split())[:80]
        raise FormatError(f"is a damaged workbook ({type(error).__name__}: {reason})") from None
    layout = next((layout for layout in WORKBOOK_LAYOUTS if layout.recognises(sheets)), None)
    if layout is not None:
        content = layout.read(sheets)
        assert isinstance(content, ColumnTable)
        return HeightChannels(("DATA",), lambda _: _record_layout(content, layout.name), 0)
    filled_sheets = [name for name, rows in sheets.items() if _find_numeric_columns(rows)]
    if not filled_sheets:
        advice = (
            "; it has formulas without values, so save it in a spreadsheet program"
            if has_formulas_without_values
            else ""
        )
        raise FormatError(f"is a workbook without a column of numbers{advice}")
    return HeightChannels(
        tuple(filled_sheets),
        lambda index: parse_sheet(sheets[filled_sheets[index]], words),
        0 if len(filled_sheets) == 1 else None,
    )


def _record_layout(table: ColumnTable, layout: str) -> ColumnTable:
    return replace(table, source=replace(table.source, layout=layout))


def _read_sheets(
    load_workbook: Callable[..., Any], data: bytes, *, data_only: bool
) -> dict[str, list[tuple[Any, ...]]]:
    """Return the rows of each sheet in an Excel workbook, keyed by sheet name.

    With `data_only`, formulas are replaced by the numbers that the file stores for them.
    """
    with warnings.catch_warnings(action="ignore"):
        workbook = load_workbook(io.BytesIO(data), read_only=True, data_only=data_only)
        sheets = {sheet.title: _read_rows(sheet) for sheet in workbook.worksheets}
        workbook.close()
    return sheets


def _mark_formulas_without_values(rows: _Rows, formulas: _Rows) -> _Rows:
    """Write a marker word into cells that contain a formula without a stored result.

    Without the marker, such cells would be empty, and empty cells mean missing points.
    """
    marked_rows = []
    for row_index, formula_row in enumerate(formulas):
        row = rows[row_index] if row_index < len(rows) else ()
        row = (*row, *(None,) * (len(formula_row) - len(row)))
        marked_rows.append(
            tuple(
                _UNEVALUATED_FORMULA_TEXT
                if cell is None and isinstance(formula, str) and formula.startswith("=")
                else cell
                for cell, formula in itertools.zip_longest(row, formula_row)
            )
        )
    return marked_rows


def _check_archive(data: bytes) -> bool:
    """Reject a workbook whose content is too large, and return whether it has formulas without stored results.

    Raises `FormatError` for too much text or too many XML tags, regardless of the sizes that the archive declares.
    """
    has_formulas_without_values = False
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        remaining_bytes, tag_count = MAX_TEXT_BYTES, 0
        for name in archive.namelist():
            end_of_chunk = b""
            # Tags before the first row of cells are not limited, because some XML files of a workbook have no such row.
            tags_in_row = -math.inf
            for chunk in read_member_chunks(archive, name, remaining_bytes):
                remaining_bytes -= len(chunk)
                tag_count += chunk.count(b"<")
                if tag_count > MAX_WORKBOOK_TAGS:
                    raise FormatError(f"contains more than {MAX_WORKBOOK_TAGS} XML tags; save the sheet as .csv")
                first_part, *rows = (piece.count(b"<") for piece in _ROW_TAG_PATTERN.split(chunk))
                if max(tags_in_row + first_part, *rows, 0) > MAX_TAGS_PER_ROW:
                    raise FormatError("has a sheet with more cells in a row than Excel allows")
                tags_in_row = rows[-1] if rows else tags_in_row + first_part
                has_formulas_without_values |= bool(_UNEVALUATED_FORMULA_PATTERN.search(end_of_chunk + chunk))
                end_of_chunk = chunk[-100:]
    return has_formulas_without_values


def _read_rows(sheet: Any) -> list[tuple[Any, ...]]:
    """Return the rows of a sheet up to the last row that is not empty."""
    # A workbook may declare wrong numbers of rows and columns for a sheet.
    sheet.reset_dimensions()
    rows = [tuple(row) for row in sheet.iter_rows(values_only=True)]
    while rows and all(cell is None for cell in rows[-1]):
        rows.pop()
    return rows
