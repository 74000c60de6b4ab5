"""Layout of text on a terminal: wrapped paragraphs, and tables split to the terminal's width."""

from __future__ import annotations

import itertools
import re
import shutil
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

MIN_TERMINAL_WIDTH = 40  # characters
MIN_LABEL_WIDTH = 16  # characters

TextRows = Sequence[Sequence[str]]


@dataclass(frozen=True)
class WrappedText:
    """Paragraph that is wrapped to the width of the terminal."""

    text: str
    indent: str = ""
    hanging_indent: str = ""


@dataclass(frozen=True)
class Table:
    """Table with aligned columns.

    The first row of the table contains the headings.

    Columns that do not fit are moved to further tables, which repeat the first `num_labels` columns.
    """

    rows: TextRows
    num_labels: int = 1


@dataclass(frozen=True)
class ShortenedList:
    """List of which only the first lines are printed, followed by the number of omitted lines.

    At most `max_shown` lines within `max_height` rows of the terminal are printed, but at least `min_shown` lines.
    There is no limit if `max_shown` or `max_height` is None.
    """

    lines: Sequence[WrappedText]
    min_shown: int
    max_shown: int | None
    max_height: int | None
    noun: str
    complete_command: str


Paragraph = Sequence[str | WrappedText | Table | ShortenedList]
"""Lines, wrapped texts, tables and lists that are printed without empty lines between them. A `str` is one line."""


def terminal_width() -> int:
    """Return the width of the terminal in characters."""
    return max(MIN_TERMINAL_WIDTH, shutil.get_terminal_size().columns)


def format_paragraphs(paragraphs: Iterable[Paragraph]) -> str:
    """Format paragraphs for the width of the terminal, and join them with empty lines in between."""
    return "\n\n".join(filter(None, map(format_paragraph, paragraphs)))


def format_paragraph(paragraph: Paragraph) -> str:
    """Return the lines and tables of a paragraph as one text that fits the width of the terminal."""
    return "\n".join(filter(None, map(_format_item, paragraph)))


def _format_item(item: str | WrappedText | Table | ShortenedList) -> str:
    match item:
        case str():
            return wrap_text(item)
        case WrappedText():
            return wrap_text(item.text, indent=item.indent, hanging_indent=item.hanging_indent)
        case Table():
            return format_table(item.rows, num_labels=item.num_labels)
        case ShortenedList():
            return _format_shortened_list(item)


def wrap_text(text: str, width: int | None = None, *, indent: str = "", hanging_indent: str = "") -> str:
    """Wrap a text to a width, by default the width of the terminal."""
    unbreakable_text = _NO_BREAK_SPACE_PATTERN.sub("\N{NO-BREAK SPACE}", text)
    return textwrap.fill(
        unbreakable_text, width or terminal_width(), initial_indent=indent, subsequent_indent=indent + hanging_indent,
        break_long_words=False, break_on_hyphens=False,
    ).replace("\N{NO-BREAK SPACE}", " ")  # fmt: skip


_NO_BREAK_SPACE_PATTERN = re.compile(r"(?<=[^\s] =) | (?=[=<>] )|(?<=\d) (?=(?:[kmµn]?[NmgL]|[GMk]Pa|%|°)(?!\w))")
"""Pattern of spaces at which a line must not break: beside an equals sign, and between number and unit."""


def _format_shortened_list(shortened_list: ShortenedList) -> str:
    line_texts = [_format_item(line) for line in shortened_list.lines]
    num_shown = len(line_texts) if shortened_list.max_shown is None else shortened_list.max_shown
    if shortened_list.max_height is not None:
        heights = itertools.accumulate(text.count("\n") + 1 for text in line_texts)
        num_shown = min(num_shown, sum(height <= shortened_list.max_height for height in heights))
    num_shown = max(num_shown, shortened_list.min_shown)
    num_omitted = len(line_texts) - num_shown
    lines = line_texts[:num_shown]
    if num_omitted > 0:
        omitted_noun = shortened_list.noun + "s" * (num_omitted > 1)
        # The line is not wrapped, because the user may copy the command in it.
        lines.append(f"  {num_omitted} more {omitted_noun}: {shortened_list.complete_command} shows all")
    return "\n".join(lines)


def format_table(rows: TextRows, width: int | None = None, *, num_labels: int = 1) -> str:
    """Format rows as a table with aligned columns that fits a width, by default the width of the terminal.

    Rows may have different lengths. Columns that do not fit are moved to further tables, which repeat the first
    `num_labels` columns. Rows that are empty in a table are omitted. A first column that is too wide is wrapped.
    """
    available_width = width or terminal_width()
    columns = max(map(len, rows), default=0)
    other_widths = max((len(cell) for row in rows for cell in row[1:]), default=0)
    rows = [
        line for row in rows for line in _wrap_first_cell(row, max(available_width - other_widths - 2, MIN_LABEL_WIDTH))
    ]
    column_widths = [max(len(row[column]) if column < len(row) else 0 for row in rows) for column in range(columns)]
    blocks, first_column = [], num_labels
    while first_column < max(columns, num_labels + 1):
        last_column = first_column + 1
        while (
            last_column < columns
            and sum(
                2 + column_width
                for column_width in column_widths[:num_labels] + column_widths[first_column : last_column + 1]
            )
            - 2
            <= available_width
        ):
            last_column += 1
        block_widths = column_widths[:num_labels] + column_widths[first_column:last_column]
        lines = (_join_cells([*row[:num_labels], *row[first_column:last_column]], block_widths) for row in rows)
        blocks.append("\n".join(filter(None, lines)))
        first_column = last_column
    return "\n".join(blocks)


def _wrap_first_cell(row: Sequence[str], width: int) -> list[Sequence[str]]:
    """Wrap the first cell of a row to a width.

    Returns the row, and a further row for each further line of the cell.
    """
    lines = textwrap.wrap(row[0], width, subsequent_indent="  ", drop_whitespace=False) if len(row[0]) > width else []
    return [[lines[0].rstrip(), *row[1:]], *([line.rstrip()] for line in lines[1:])] if lines else [row]


def _join_cells(cells: Sequence[str], column_widths: Sequence[int]) -> str:
    return "  ".join(
        cell.ljust(column_width) for cell, column_width in zip(cells, column_widths, strict=False)
    ).rstrip()
