"""Columns of words next to columns of numbers in a text, such as flags "OK" and "NG"."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stiction._text import printable_text
from stiction.surfaces.measured.decode import BLANK_LINE_CODE, NUMBER_LINE_CODE, TEXT_LINE_CODE, DecodedText
from stiction.surfaces.measured.split import Dialect, cell_kind, find_numeric_line_runs, split_cells

# The comma is tried last as a cell separator, because it may also be the decimal mark within cells.
_CELL_SEPARATORS = ("\t", ";", "|", None, ",")
_NUMBER_CELL_PATTERN = re.compile(r"[+-]?(?:[0-9]{1,40}(?:[.,][0-9]{0,40})?|[.,][0-9]{1,40})(?:[eE][+-]?[0-9]{1,3})?")
_WORD_REPLACEMENT = "nan"
_MAX_SEPARATOR_SEARCH_LINES = 400
MIN_TABLE_ROWS = 4
MAX_LISTED_WORDS = 4


@dataclass(frozen=True)
class WordColumnWithMissingLines:
    """Column of words in a table: counts of the words, and indices of lines in which a word marks a missing point."""

    place: int
    counts: Mapping[str, int]
    missing_lines: tuple[int, ...]  # counted from 0


def replace_word_columns(text: DecodedText) -> tuple[DecodedText, tuple[WordColumnWithMissingLines, ...]]:
    """Replace the words in columns without numbers by ``nan``, so that the text can be parsed as numbers.

    Returns the new text and the columns of words.
    """
    runs = find_numeric_line_runs(text)
    if not (text.words or _may_mix_words_and_numbers(text, runs)):
        return text, ()
    lines = np.flatnonzero(text.line_kinds != BLANK_LINE_CODE).tolist()
    largest_run = max((last + 1 - first for first, last in runs), default=0)
    tables_by_separator = {
        separator: _find_word_table(text, lines[:_MAX_SEPARATOR_SEARCH_LINES], separator)
        for separator in _CELL_SEPARATORS
    }
    separator = max(tables_by_separator, key=lambda candidate: len(tables_by_separator[candidate].numeric_columns))
    if not tables_by_separator[separator].word_counts:
        return text, ()
    table = (
        tables_by_separator[separator]
        if len(lines) <= _MAX_SEPARATOR_SEARCH_LINES
        else _find_word_table(text, lines, separator)
    )
    if not table.word_counts or len(table.lines) < max(MIN_TABLE_ROWS, len(lines) / 2, largest_run):
        return text, ()
    replaced_lines = text.data.decode("utf-8", "replace").split("\n")
    for line, cells in zip(table.lines, table.rows, strict=True):
        replaced_lines[line] = (separator or " ").join(
            _WORD_REPLACEMENT
            if index in table.word_counts
            else f'"{cell}"'
            if separator and separator in cell
            else cell
            for index, cell in enumerate(cells)
        )
    columns = (
        WordColumnWithMissingLines(place, counts, tuple(table.missing_lines.get(place, ())))
        for place, counts in sorted(table.word_counts.items())
    )
    return replace(text, data="\n".join(replaced_lines).encode()), tuple(columns)


def describe_words(counts: Mapping[str, int]) -> str:
    """Format the most frequent words of a column with their counts, as in ``'OK' (58) and 'NG' (2)``."""
    words = sorted(counts.items(), key=lambda item: -item[1])
    shown_words = [f"{printable_text(word, 20)!r} ({count})" for word, count in words[:MAX_LISTED_WORDS]]
    if len(words) > MAX_LISTED_WORDS:
        shown_words.append(f"{len(words) - MAX_LISTED_WORDS} others")
    return " and ".join(filter(None, [", ".join(shown_words[:-1]), shown_words[-1]]))


def _may_mix_words_and_numbers(text: DecodedText, runs: Sequence[tuple[int, int]]) -> bool:
    """Return whether a text may contain columns of words next to columns of numbers."""
    if not runs:
        return True
    kinds = text.line_kinds[text.line_kinds != BLANK_LINE_CODE]
    numbers = np.flatnonzero(kinds == NUMBER_LINE_CODE)
    return bool((kinds[numbers[0] :] == TEXT_LINE_CODE).any()) or (
        numbers[0] > 0 and any(map(_NUMBER_CELL_PATTERN.fullmatch, re.split(r"[\t;|, ]+", text.line(runs[0][0] - 1))))
    )


@dataclass
class _TableWithTextColumns:
    """Table with number columns and word columns: rows, word counts, and lines in which a word means missing data."""

    numeric_columns: set[int] = field(default_factory=set)
    lines: list[int] = field(default_factory=list)
    rows: list[list[str]] = field(default_factory=list)
    word_counts: dict[int, Counter[str]] = field(default_factory=dict)  # by column
    missing_lines: dict[int, list[int]] = field(default_factory=dict)  # by column


def _find_word_table(text: DecodedText, lines: Sequence[int], separator: str | None) -> _TableWithTextColumns:
    """Split lines into cells, and find the table that has columns of words next to columns of numbers.

    The rows of the table have the same number of cells, and numbers in the same columns.
    """
    rows = [split_cells(text.line(line), separator) for line in lines]
    is_number = [[_NUMBER_CELL_PATTERN.fullmatch(cell) is not None for cell in row] for row in rows]
    widths = Counter(len(row) for row, numbers in zip(rows, is_number, strict=True) if any(numbers))
    table = _TableWithTextColumns()
    if not widths:
        return table
    width = widths.most_common(1)[0][0]
    dialect, given_words = Dialect(separator, "."), {word.casefold() for word in text.words}
    numeric_columns = table.numeric_columns
    numeric_columns |= {
        index
        for row, numbers in zip(rows, is_number, strict=True)
        for index, number in enumerate(numbers)
        if number and len(row) == width
    }
    kinds: dict[int, Counter[str]] = {}
    for line, row, numbers in zip(lines, rows, is_number, strict=True):
        if len(row) != width or not any(numbers):
            continue
        if any(not numbers[index] and cell_kind(row[index], dialect, text) is None for index in numeric_columns):
            continue
        table.lines.append(line)
        table.rows.append(row)
        for index in set(range(width)) - numeric_columns:
            kinds.setdefault(index, Counter())[row[index]] += 1
            if row[index].casefold() in given_words:
                table.missing_lines.setdefault(index, []).append(line)
    for index, counts in kinds.items():
        words = Counter({cell: count for cell, count in counts.items() if _is_word(cell, dialect, text, given_words)})
        if words and not {cell.casefold() for cell in counts} <= given_words:
            table.word_counts[index] = words
    return table


def _is_word(cell: str, dialect: Dialect, text: DecodedText, given_words: set[str]) -> bool:
    return bool(cell) and (cell.casefold() in given_words or cell_kind(cell, dialect, text) is None)
