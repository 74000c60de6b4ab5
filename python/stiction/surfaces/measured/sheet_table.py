"""Parsing of the largest table of numbers in an Excel sheet."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from stiction.surfaces.measured.decode import decode_text
from stiction.surfaces.measured.raw import ColumnTable, FormatError
from stiction.surfaces.measured.text_table import parse_table


def parse_sheet(rows: Sequence[Sequence[Any]], words: tuple[str, ...] = ()) -> ColumnTable:
    """Parse the largest table of numbers in an Excel sheet, with the header above the table."""
    columns = _find_table_columns(rows)
    lines = [_join_row_cells(row, columns) for row in rows]
    content = parse_table(decode_text(("\n".join(lines) + "\n").encode(), words))
    if not isinstance(content, ColumnTable):
        raise FormatError("has a sheet with several tables, one below another; keep only one table")
    column_numbers = columns[: content.values.shape[1]]
    return replace(content, places=tuple(column_numbers), source=replace(content.source, encoding="", separator=""))


def _is_number_cell(cell: Any) -> bool:
    return isinstance(cell, (int, float)) and not isinstance(cell, bool)


def _find_numeric_columns(rows: Sequence[Sequence[Any]]) -> list[int]:
    """Return the indices of the sheet columns that contain numbers.

    Such a column has at least two numbers, and at least a quarter of the numbers in the fullest column.
    """
    number_counts: Counter[int] = Counter(
        index for row in rows for index, cell in enumerate(row) if _is_number_cell(cell)
    )
    max_count = max(number_counts.values(), default=0)
    return sorted(index for index, count in number_counts.items() if count > 1 and 4 * count >= max_count)


def _find_data_rows(rows: Sequence[Sequence[Any]], columns: Sequence[int]) -> range:
    """Return the longest range of sheet rows that have a number in at least one of the given columns."""
    has_number = [any(map(_is_number_cell, _select_cells(row, columns))) for row in rows]
    runs = [list(run) for is_run, run in itertools.groupby(range(len(rows)), has_number.__getitem__) if is_run]
    longest_run = max(runs, key=len)
    return range(longest_run[0], longest_run[-1] + 1)


def _find_table_columns(rows: Sequence[Sequence[Any]]) -> list[int]:
    """Return the indices of a table's columns: all columns of numbers, and non-empty columns next to these.

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
    """Join the cells of a sheet row with tabs to form one line of text.

    In rows of numbers and of column names, only the columns of the table are kept.
    """
    selected_cells = _select_cells(row, columns)
    if any(map(_is_number_cell, selected_cells)) or (
        selected_cells and all(isinstance(cell, str) for cell in selected_cells)
    ):
        return "\t".join("" if cell is None else " ".join(str(cell).split()) for cell in selected_cells)
    return "\t".join(" ".join(str(cell).split()) for cell in row if cell is not None)
