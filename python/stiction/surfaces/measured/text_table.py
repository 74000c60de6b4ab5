"""Conversion of a text to a table of numeric columns. If a text has several tables, each becomes a height channel."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from stiction._text import printable_text
from stiction.surfaces.measured.decode import NUMBER_LINE_CODE, TEXT_LINE_CODE, DecodedText
from stiction.surfaces.measured.header import parse_column_headings, parse_declarations, parse_history
from stiction.surfaces.measured.raw import (
    LENGTH_UNITS,
    ColumnTable,
    FileCaveat,
    FormatError,
    HeightChannels,
    HeightProvenance,
    RawHeights,
    WordColumn,
    parse_length_unit,
)
from stiction.surfaces.measured.shapes import has_equal_steps
from stiction.surfaces.measured.split import (
    MAX_CELLS_IN_COUNT_LINE,
    Dialect,
    NumberBlock,
    cell_kind,
    describe_remedy_of_word,
    detect_dialect,
    find_numeric_line_runs,
    is_numeric_row,
    parse_number_block,
)
from stiction.surfaces.measured.word_columns import WordColumnWithMissingLines, describe_words, replace_word_columns

MAX_HISTORY_ENTRY_CHARACTERS = 1000


MAX_HISTORY_STEPS = 1000


# Above a table, and again below it, 2 lines of numbers are allowed, plus this fraction of the table's line count.
MAX_FOOTER_FRACTION = 0.1


# A file's last number counts as cut off if this many numbers above it all have the same, larger number of decimals.
MIN_ROWS_ABOVE_CUT_NUMBER = 50


# Above a table of one or two columns, a block with fewer rows than this is regarded as sizes or counts.
MIN_BLOCK_ROWS = 2


def parse_table(text: DecodedText) -> ColumnTable | HeightChannels:
    """Parse the longest run of consecutive lines of numbers in a text as a table, with the header above this run.

    If other runs have as many columns as the longest, each run is a channel.
    """
    text, word_columns = replace_word_columns(text)
    runs = find_numeric_line_runs(text)
    if not runs:
        raise FormatError(
            f"no numbers were found in {len(text)} lines, of which the first is {text.describe_line(0)}; numbers must "
            "be in columns, separated by tabs, semicolons, commas or blanks"
        )
    first, last = max(runs, key=lambda run: int(text.line_starts[run[1] + 1] - text.line_starts[run[0]]))
    dialect = detect_dialect(text, first, last)
    label_line = _include_label_line(text, first, last, dialect)
    # The first word of the label line is treated as a missing number, so that the line counts as a row of the table.
    if label_line < first:
        first, text = label_line, replace(text, words=(*text.words, dialect.split_line(text.line(label_line))[0]))
    _reject_unreadable_line(text, dialect, len(dialect.split_line(text.line(last))), runs)
    block = parse_number_block(text, first, last, dialect, ragged=True)
    if len(equal_runs := _find_runs_of_equal_width(text, runs, (first, last), dialect)) > 1:
        return _to_channels(text, equal_runs, dialect, word_columns)
    end = int(block.lines[-1]) + 1
    footer_line_count = int((text.line_kinds[end:] == 1).sum())
    if footer_line_count > MAX_FOOTER_FRACTION * block.lines.size + 2:
        line = end + int(np.argmax(text.line_kinds[end:] == 1))
        raise FormatError(
            f"{text.describe_line(line)} does not belong to the same table as lines {first + 1} to {end}; keep only "
            "one table in the file"
        )
    _reject_rows_above_table(text, block)
    _reject_separated_positions(text, runs, block)
    return _to_table(text, block, 0, word_columns)


def _reject_rows_above_table(text: DecodedText, block: NumberBlock) -> None:
    """Raise `FormatError` if many lines of numbers precede a table, because these may be rows of another table.

    Lines of at most `MAX_CELLS_IN_COUNT_LINE` cells are not counted, because they may contain counts or sizes.
    """
    lines = np.flatnonzero(text.line_kinds[: int(block.lines[0])] == NUMBER_LINE_CODE).tolist()
    max_rows = int(MAX_FOOTER_FRACTION * block.lines.size) + 2
    if len(lines) <= max_rows:
        return
    rows = [line for line in lines if len(block.dialect.split_line(text.line(line))) > MAX_CELLS_IN_COUNT_LINE]
    if len(rows) > max_rows:
        raise FormatError(
            f"{text.describe_line(rows[0])} and {len(rows) - 1} more lines of numbers do not belong to the same table "
            f"as lines {block.lines[0] + 1} to {block.lines[-1] + 1}; keep only one table in the file"
        )


def _reject_separated_positions(text: DecodedText, runs: list[tuple[int, int]], block: NumberBlock) -> None:
    """Raise `FormatError` if text stands between the first row of a profile and the remaining rows.

    The separate row has two cells, and its position precedes the first position of the other rows by whole steps.
    """
    start = int(block.lines[0])
    if block.values.shape != (block.lines.size, 2) or block.lines.size < 2:
        return
    positions = block.values[:, 0]
    for line, last in runs:
        if line >= start or last > line or not is_numeric_row(text.line(line), block.dialect, text):
            continue
        separate_row = parse_number_block(text, line, line, block.dialect).values[0]
        steps = (
            (positions[0] - separate_row[0]) / (positions[1] - positions[0]) if positions[1] != positions[0] else np.nan
        )
        if separate_row.size == 2 and 0.9 < steps < start - line + 0.1 and abs(steps - round(steps)) < 0.1:
            raise FormatError(
                f"{text.describe_line(line)} looks like a point of the profile that starts in line {start + 1}, but "
                "there is text between the two lines; remove the text, or this point"
            )


def _to_table(
    text: DecodedText, block: NumberBlock, header_start: int, word_columns: Sequence[WordColumnWithMissingLines] = ()
) -> ColumnTable:
    """Convert a matrix of numbers in a text to a table, and parse the header and the footer of the table.

    The header begins at line `header_start`.
    """
    first, end = int(block.lines[0]), int(block.lines[-1]) + 1
    header, footer = (
        text.nonempty_lines(header_start, first),
        text.nonempty_lines(end, len(text)) if header_start == 0 else [],
    )
    width = block.values.shape[1]
    column_headings = parse_column_headings(header, width, block.dialect)
    declarations = parse_declarations(
        text.nonempty_lines(0, first) if header_start else header,
        footer=footer,
        is_profile=width <= 2,
        has_names=any(column_headings.names),
    )
    if block.first_short_line is not None and not any(column_headings.names):
        raise FormatError(
            f"{text.describe_line(block.first_short_line)} has fewer cells than the lines above it, and the columns "
            "have no names; all lines of a matrix must have the same number of cells, and a profile must have one "
            "height per line"
        )
    block_starts = np.flatnonzero(np.diff(block.lines, prepend=block.lines[0] - 2) > 1)
    return ColumnTable(
        block.values,
        block_lengths=tuple(np.diff(block_starts, append=block.lines.size).tolist()),
        block_lines=tuple((block.lines[block_starts] + 1).tolist()),
        names=column_headings.names,
        units=column_headings.units or (None,) * width,
        digits=block.column_last_digit_values,
        row_digits=block.row_last_digit_values,
        declared=declarations
        if declarations.unit is not None
        else replace(declarations, unit=column_headings.height_unit),
        history=(
            *(printable_text(step, MAX_HISTORY_ENTRY_CHARACTERS) for step in parse_history(header)[:MAX_HISTORY_STEPS]),
            *(
                f"{text.describe_line(line)} skipped as a count or a size"
                for line in block.skipped_lines[:MAX_HISTORY_STEPS]
            ),
        ),
        source=make_height_provenance(block),
        caveats=_find_cut_number(block),
        word_columns=tuple(
            WordColumn(
                column.place,
                describe_words(column.counts),
                printable_text(min(column.counts, key=column.counts.__getitem__), 20),
                np.isin(block.lines, column.missing_lines),
                _find_units(column.counts),
            )
            for column in word_columns
            if column.place < width
        ),
    )


def _find_cut_number(block: NumberBlock) -> tuple[FileCaveat, ...]:
    """Return a caveat if a file's last number seems truncated, because the numbers above it have more decimals."""
    start = int(block.lines.size) - MIN_ROWS_ABOVE_CUT_NUMBER - 1
    if start < 0 or (block.text.line_kinds[int(block.lines[-1]) + 1 :] == TEXT_LINE_CODE).any():
        return ()
    cells = [block.row_cells(row)[-1:] for row in range(start, block.lines.size)]
    matches = [block.dialect.number_pattern.fullmatch(cell) for row in cells for cell in row]
    *counts, last_count = (len(match[3] or "") if match else -1 for match in matches)
    if len(counts) < MIN_ROWS_ABOVE_CUT_NUMBER or len(set(counts)) > 1 or not 0 <= last_count < counts[0]:
        return ()
    text = f"its last number, {printable_text(cells[-1][0], 20)}, has fewer decimals than those above it"
    return (FileCaveat("truncated", text, "export it again, or accept it if the number is complete"),)


def _find_units(words: Iterable[str]) -> tuple[str, ...]:
    """Return the distinct units of length in a column of words, or () if any word is not a unit of length."""
    units = [parse_length_unit(word) for word in words]
    return tuple({LENGTH_UNITS[unit]: unit for unit in units if unit}.values()) if all(units) else ()


def make_height_provenance(block: NumberBlock) -> HeightProvenance:
    """Return the provenance of heights in a text file: lines, encoding, cell separator and decimal mark."""
    text, first_line, end = block.text, int(block.lines[0]), int(block.lines[-1]) + 1
    decimal_mark = "." if block.dialect.pairs else block.dialect.point
    return HeightProvenance(
        encoding=text.encoding, separator=str(block.dialect), decimal_mark=decimal_mark, lines=(first_line + 1, end),
        lines_above=len(text.nonempty_lines(0, first_line)) if first_line < 10_000 else first_line,
        lines_below=int(np.count_nonzero(text.line_kinds[end:])),
    )  # fmt: skip


def _include_label_line(text: DecodedText, first: int, last: int, dialect: Dialect) -> int:
    """Return a table's first line: the line above `first` if that line lists column positions, otherwise `first`."""
    line_above = next((line for line in range(first - 1, -1, -1) if text.line(line).strip("\t")), -1)
    if line_above < 0 or dialect.separator is None:
        return first
    cells, cells_below = dialect.split_line(text.line(line_above)), dialect.split_line(text.line(first))
    is_label_line = (
        len(cells) == len(cells_below)
        and cell_kind(cells[0], dialect, text) is None
        and _are_position_labels(cells, dialect)
    )
    return line_above if is_label_line else first


def _reject_unreadable_line(text: DecodedText, dialect: Dialect, width: int, runs: list[tuple[int, int]]) -> None:
    """Raise `FormatError` if a line next to a table looks like a row, but contains a cell that is not a number.

    Such a line has as many cells as the rows and is not a line of labels. Most of its cells are numbers, or the next
    line away from the table has the same words.
    """
    adjacent_lines = {adjacent_line for first, last in runs for adjacent_line in ((first - 1, -1), (last + 1, 1))}
    for line, step in sorted(adjacent_lines):
        if (
            not 0 <= line < len(text)
            or text.line_kinds[line] != TEXT_LINE_CODE
            or text.line(line).startswith(("#", "%", "!", "/"))
        ):
            continue
        cells = dialect.split_line(text.line(line))
        kinds = [cell_kind(cell, dialect, text) for cell in cells]
        # A line such as "Points 500" above the table does not count as a row of numbers.
        weighted_number_count = 2 * kinds.count("number") - (line < runs[0][0] and kinds[:1] == [None])
        if len(cells) != width or None not in kinds or _are_position_labels(cells, dialect):
            continue
        has_most_numbers = width > 1 and weighted_number_count >= width
        if has_most_numbers or _repeats_words(text, dialect, kinds, cells, line + step):
            _reject_word(text, line, next(cell for cell, kind in zip(cells, kinds, strict=True) if kind is None))


def _repeats_words(
    text: DecodedText, dialect: Dialect, kinds: list[str | None], cells: list[str], other_line: int
) -> bool:
    """Return whether another line repeats a row's pattern: cells of the same kinds (number or text), and equal words.

    Adjacent rows often repeat a word, but the lines of a header rarely do. The result is false if none of several cells
    is a number.
    """
    if not 0 <= other_line < len(text) or (len(cells) > 1 and "number" not in kinds):
        return False
    other_cells = dialect.split_line(text.line(other_line))
    return [cell_kind(cell, dialect, text) for cell in other_cells] == kinds and all(
        cell == other_cell for cell, other_cell, kind in zip(cells, other_cells, kinds, strict=True) if kind is None
    )


def _reject_word(text: DecodedText, line: int, word: str) -> None:
    raise FormatError(
        f"{text.describe_line(line)} is between numbers, but {word[:40]!r} is not a number; "
        f"{describe_remedy_of_word(word[:40])}"
    )


def _are_position_labels(cells: list[str], dialect: Dialect) -> bool:
    """Return whether all cells after the first are equally spaced numbers, which may be positions of columns."""
    matches = [dialect.number_pattern.fullmatch(cell) for cell in cells[1:]]
    if len(cells) < 5 or not all(match and (match[2] or match[3]) for match in matches):
        return False
    labels = np.array([np.nan, *(float(cell.replace(dialect.point, ".")) for cell in cells[1:])])
    return has_equal_steps(labels, 0.1 * abs(labels[2] - labels[1]))


def _find_runs_of_equal_width(
    text: DecodedText, runs: list[tuple[int, int]], main_run: tuple[int, int], dialect: Dialect
) -> list[tuple[int, int]]:
    """Return all runs of consecutive lines of numbers that have as many columns as the run `main_run`.

    Short runs of one or two columns above the first of these runs are left out, because they may be counts or sizes.
    """
    width = len(dialect.split_line(text.line(main_run[0])))
    equal_runs: list[tuple[int, int]] = []
    for first, last in runs:
        is_as_wide = all(len(dialect.split_line(text.line(line))) == width for line in (first, last))
        if (first, last) == main_run or (
            is_as_wide and (equal_runs or width > 2 or last - first + 1 >= MIN_BLOCK_ROWS)
        ):
            equal_runs.append((first, last))
    gaps = [(last + 1, first) for (_, last), (first, _) in itertools.pairwise(equal_runs)]
    if (
        width == 1
        and gaps
        and all(gap_end - gap_start == 1 and len(text.line(gap_start).split()) == 1 for gap_start, gap_end in gaps)
    ):
        _reject_word(text, gaps[0][0], text.line(gaps[0][0]))
    return equal_runs


def _to_channels(
    text: DecodedText,
    runs: list[tuple[int, int]],
    dialect: Dialect,
    word_columns: Sequence[WordColumnWithMissingLines] = (),
) -> HeightChannels:
    """Convert several tables with equal numbers of columns to channels, one channel per table."""
    header_starts = [0, *(last + 1 for _, last in runs)]
    names = []
    for (first, last), header_start in zip(runs, header_starts, strict=False):
        header = text.nonempty_lines(header_start, first)
        name = header[-1].lstrip("#%!/ \t") if header else ""
        names.append(printable_text(" ".join(name.split()) or f"lines {first + 1} to {last + 1}", 40))
    if len(set(names)) < len(names):
        names = [f"{name}, line {first + 1}" for name, (first, _) in zip(names, runs, strict=True)]

    def read(line: int) -> RawHeights | ColumnTable:
        table = _to_table(
            text, parse_number_block(text, *runs[line], dialect, ragged=True), header_starts[line], word_columns
        )
        return replace(table, source=replace(table.source, column=names[line]))

    return HeightChannels(tuple(names), read, None)
