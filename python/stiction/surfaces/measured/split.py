"""Conversion of text lines to a matrix of numbers, with detection of separators, decimal marks and quotes."""

from __future__ import annotations

import csv
import io
import re
import shlex
from collections import Counter
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

import stiction._core
from stiction._checks import Floats
from stiction._text import printable_text
from stiction._threads import num_usable_cores
from stiction.surfaces.measured.decode import (
    BLANK_LINE_CODE,
    MAX_CELLS_PER_LINE,
    NUMBER_LINE_CODE,
    NUMERIC_CHARACTERS,
    DecodedText,
)
from stiction.surfaces.measured.raw import FormatError

_MAX_SAMPLE_LINES = 60
_MAX_SAMPLE_CHARACTERS = 10_000
_MIN_CHARACTERS_PER_SAMPLED_LINE = 200
MAX_SAMPLED_ROWS = 20_000
MAX_CELLS_IN_COUNT_LINE = 2
_QUOTED_SEPARATOR = "\x1f"
_EXPONENT_PATTERN = r"(?:[eE]([+-]?[0-9]{1,3}))?"

LineNumbers = NDArray[np.int64]


def split_cells(line: str, separator: str | None) -> list[str]:
    """Split a line into cells at a separator.

    Empty cells at the end of the line are kept.
    """
    if separator is None:
        return line.replace('"', " ").split()
    if '"' in line:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    else:
        cells = line.split(separator)
    return [cell.strip() for cell in cells]


@dataclass(frozen=True)
class Dialect:
    """Number format of a table: cell separator (None for white space), decimal mark and thousands separator."""

    separator: str | None
    point: str
    thousands: str = ""
    # True if commas separate cells and also mark decimals, so that two cells form one number.
    pairs: bool = False

    def __str__(self) -> str:
        names = {"\t": "tab", None: "space", ";": "semicolon", ",": "comma", "|": "bar"}
        return names[self.separator]

    def split_line(self, line: str) -> list[str]:
        """Split a line into cells.

        Empty cells at the end of the line, which some programs append, are omitted.
        """
        cells = split_cells(line, self.separator)
        if self.pairs and len(cells) % 2 == 0:
            cells = [
                f"{integer_digits}.{decimals}" for integer_digits, decimals in zip(cells[::2], cells[1::2], strict=True)
            ]
        while cells and not cells[-1]:
            cells.pop()
        return cells

    @cached_property
    def number_pattern(self) -> re.Pattern[str]:
        """Regular expression for a number, with groups for sign, integer digits, decimals and exponent."""
        point = "." if self.pairs else self.point
        integer_digits = "[0-9]{0,400}"
        if self.thousands:
            integer_digits = rf"[0-9]{{1,3}}(?:{re.escape(self.thousands)}[0-9]{{3}}){{1,9}}|{integer_digits}"
        return re.compile(
            rf"([+-]?)({integer_digits})(?:{re.escape(point)}([0-9]{{0,400}}))?{_EXPONENT_PATTERN}", re.ASCII
        )


_DIALECTS_WITHOUT_THOUSANDS_SEPARATOR = [
    Dialect("\t", "."), Dialect("\t", ","), Dialect(";", "."), Dialect(";", ","), Dialect("|", "."), Dialect("|", ","),
    Dialect(",", "."), Dialect(None, "."), Dialect(None, ","),
]  # fmt: skip
# A comma can be both the separator of cells and the decimal mark only if the cells are quoted.
_QUOTED_DIALECTS = [Dialect(",", ",")]
_THOUSANDS_DIALECTS = [
    Dialect(separator, point, thousands)
    for separator in ("\t", ";", "|", None)
    for point, thousands in ((".", ","), (",", "."), (".", "'"), (",", "'"), (".", " "), (",", " "))
    if not (separator is None and thousands == " ")
]
_QUOTED_THOUSANDS_DIALECTS = [Dialect(",", ".", ","), Dialect(",", ",", ".")]


@dataclass(frozen=True)
class NumberBlock:
    """Matrix of numbers in a text file, with the line number of each row."""

    text: DecodedText
    lines: LineNumbers  # counted from 0
    dialect: Dialect
    values: Floats
    first_short_line: int | None = None
    skipped_lines: tuple[int, ...] = ()

    def row_cells(self, line: int) -> list[str]:
        """Return the cells of a table row as text."""
        return self.dialect.split_line(self.text.line(int(self.lines[line])))

    def column_last_digit_values(self, column: int) -> Floats:
        """Return the place value of the last printed digit of each number in a column.

        The digits are counted in at most `MAX_SAMPLED_ROWS` rows.
        """
        num_decimals = num_digits = 0
        max_decimals = -1000
        count = self.lines.size
        sampled_lines = np.arange(count)
        if count > MAX_SAMPLED_ROWS:
            half = MAX_SAMPLED_ROWS // 2
            sampled_lines = np.concatenate([sampled_lines[:half], np.linspace(half, count - 1, half).astype(np.int64)])
        for line in sampled_lines.tolist():
            row = self.row_cells(line)
            match = self.dialect.number_pattern.fullmatch(row[column]) if column < len(row) else None
            if match is not None and (match[2] or match[3]):
                num_decimals = len(match[3] or "") - int(match[4] or 0)
                num_digits = max(num_digits, len((match[2] + (match[3] or "")).lstrip("0")))
            else:
                num_decimals = 0
            max_decimals = max(max_decimals, num_decimals)
        return last_digit_value(self.values[:, column], max_decimals, num_digits)

    def row_last_digit_values(self, line: int) -> Floats:
        """Return the place value of the last printed digit of each number in a row."""
        matches = [
            match
            for cell in self.row_cells(line)
            if (match := self.dialect.number_pattern.fullmatch(cell)) and match[0]
        ]
        num_decimals = max((len(match[3] or "") - int(match[4] or 0) for match in matches), default=0)
        num_digits = max((len((match[2] + (match[3] or "")).lstrip("0")) for match in matches), default=0)
        return last_digit_value(self.values[line], num_decimals, num_digits)


def last_digit_value(values: Floats, decimals: int, digits: int) -> Floats:
    """Return the place value of the last printed digit of each number, for example 0.01 for 1.25.

    The place value is the larger of two: one follows from `decimals` decimals, the other from `digits` significant
    digits.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        decimal_exponents = np.floor(np.log10(np.abs(values)))
    last_digit_exponents = np.where(np.isfinite(decimal_exponents), decimal_exponents, -400) + 1 - digits
    return np.asarray(10.0 ** np.clip(np.maximum(-decimals, last_digit_exponents), -300, 300))


def find_numeric_line_runs(text: DecodedText) -> list[tuple[int, int]]:
    """Return the indices of the first and the last line of each run of consecutive lines of numbers.

    Blank lines do not end a run.
    """
    kinds = text.line_kinds
    nonblank_lines = np.flatnonzero(kinds != BLANK_LINE_CODE)
    is_number_line = kinds[nonblank_lines] == NUMBER_LINE_CODE
    edges = np.flatnonzero(np.diff(np.concatenate([[False], is_number_line, [False]]).astype(np.int8)))
    return [(int(nonblank_lines[a]), int(nonblank_lines[b - 1])) for a, b in edges.reshape(-1, 2).tolist()]


def detect_dialect(text: DecodedText, first: int, last: int) -> Dialect:
    """Detect the cell separator and the decimal mark with which most lines of a table can be parsed as numbers.

    Raises `FormatError` if no number format fits the lines, or if two formats fit.
    """
    sample_lines = np.unique(
        np.concatenate([np.arange(max(first, last + 1 - _MAX_SAMPLE_LINES), last + 1), np.arange(first, first + 40)])
    )
    sample_lines = sample_lines[sample_lines <= last]
    max_sample_length = max(_MIN_CHARACTERS_PER_SAMPLED_LINE, _MAX_SAMPLE_CHARACTERS // sample_lines.size)
    sample = [_truncate_line(text.line(item), max_sample_length) for item in sample_lines.tolist()]
    sample = [line for line in sample if line.strip("\t")]
    has_quotes = any('"' in line for line in sample)
    candidates = [*_DIALECTS_WITHOUT_THOUSANDS_SEPARATOR, *(_QUOTED_DIALECTS if has_quotes else ())]
    counts = [sum(is_numeric_row(line, dialect, text) for line in sample) for dialect in candidates]
    if max(counts) < len(sample):
        candidates += [*_THOUSANDS_DIALECTS, *(_QUOTED_THOUSANDS_DIALECTS if has_quotes else ())]
        counts += [sum(is_numeric_row(line, dialect, text) for line in sample) for dialect in candidates[len(counts) :]]
    if not counts or max(counts) == 0:
        raise FormatError(
            f"{text.describe_line(first)} has numbers in an unknown format; separate cells by tabs, semicolons or "
            "commas, and write decimal points"
        )
    dialect: Dialect = candidates[int(np.argmax(counts))]
    if any("," in line for line in sample) and all(re.fullmatch(r"[+-]?[0-9]+(,[0-9]+)?", line) for line in sample):
        if len(Dialect(",", ".").split_line(_find_line_above_table(text, first))) == 2:
            return Dialect(",", ".")
        raise FormatError(
            f"{text.describe_line(first)} and all other lines may be two columns, or one column with decimal "
            'commas; write decimal points, or a header such as "x (um),z (um)"'
        )
    if dialect.separator == ",":
        dialect = _interpret_commas(text, first, sample, dialect)
    if dialect.point == "," or dialect.thousands == ",":
        _reject_ambiguous_commas(text, first, last, dialect)
    return dialect


def is_numeric_row(line: str, dialect: Dialect, text: DecodedText) -> bool:
    """Return whether all cells of a line are numbers or marks of missing points, and at least one cell is a number."""
    has_number = False
    for cell in dialect.split_line(line):
        if (kind := cell_kind(cell, dialect, text)) is None:
            return False
        has_number |= kind != "mark"
    return has_number


def cell_kind(cell: str, dialect: Dialect, text: DecodedText) -> str | None:
    """Return the kind of a cell: "number", "word" (such as NaN) or "mark" (empty, dashes or stars).

    Returns None for any other text.
    """
    match = dialect.number_pattern.fullmatch(cell)
    if match is not None and (match[2] or match[3]):
        return "number"
    if not cell or re.fullmatch(r"\*{1,40}|-{2,40}", cell):
        return "mark"
    return "word" if text.missing_word_pattern.fullmatch(cell.encode()) else None


_DATE_PATTERN = re.compile(
    r"[0-9]{1,4}([-./])[0-9]{1,2}\1(?:[0-9]{2,4})?(?:[ T][0-9:.]{4,15})?|"
    r"[0-9]{1,2}/[0-9]{1,2}|[0-9]{1,2}:[0-9]{2}(?::[0-9.]+)?|"
    r"[0-9]{1,2}[-. ]{1,2}[^\W\d_]{3,5}\.?(?:[-. ]{1,2}[0-9]{2,4})?|[^\W\d_]{3,5}\.?[-. ]{1,2}[0-9]{2,4}"
)
"""Regular expression for a date or a time, to which spreadsheet programs convert numbers such as 3.10."""


def describe_remedy_of_word(word: str) -> str:
    """Return advice for an error message: how to correct a cell that contains a date, brackets or a word."""
    if _DATE_PATTERN.fullmatch(word):
        return "a spreadsheet program has converted numbers to dates; export the file again with a decimal point"
    if re.search(r"[\[\]{}]", word):
        return "write the numbers without brackets, one row per line"
    if re.fullmatch(r"\([0-9.,]+\)|[0-9.,]+-", word):
        return "write negative numbers with a minus sign in front of them"
    return f"--missing-value {shlex.quote(printable_text(word))} treats it as a missing point"


def _truncate_line(line: str, width: int) -> str:
    """Truncate a line to at most `width` characters, without cutting a cell."""
    return line if len(line) <= width else re.sub(r"[^\t;|, ]*$", "", line[:width]).rstrip("\t;|, ")


def _interpret_commas(text: DecodedText, first: int, sample: list[str], dialect: Dialect) -> Dialect:
    """Decide whether commas separate cells, mark decimals, or do both; return the number format that follows."""
    rows = [dialect.split_line(line) for line in sample]
    width = len(rows[0])
    possible_decimals = [cell for row in rows for cell in row[1::2]]
    if width % 2 or not possible_decimals or not all(re.fullmatch(r"[0-9]+", cell) for cell in possible_decimals):
        return dialect
    if not all(re.fullmatch(r"[+-]?[0-9]+", cell) for row in rows for cell in row):
        return dialect
    decimals_by_column = zip(*(row[1::2] for row in rows if len(row) == width), strict=True)
    if not all(len({len(cell) for cell in column}) == 1 for column in decimals_by_column):
        return dialect
    if len(Dialect(",", ".").split_line(_find_line_above_table(text, first).lstrip("#%!/ "))) == width // 2:
        return Dialect(",", ",", pairs=True)
    if any(len(cell) > 1 and cell.startswith("0") for cell in possible_decimals):
        raise FormatError(
            f"{text.describe_line(first)} has commas that separate cells and probably also decimal commas; "
            "export it with semicolons or tabs, or with decimal points"
        )
    return dialect


def _find_line_above_table(text: DecodedText, first: int) -> str:
    """Return the last nonempty line above the line with index `first`, or "" if all lines above are empty."""
    return next((line for index in range(first - 1, -1, -1) if (line := text.line(index)).strip("\t")), "")


def _reject_ambiguous_commas(text: DecodedText, first: int, last: int, dialect: Dialect) -> None:
    """Raise `FormatError` if commas may be decimal marks or thousands separators, so that "1,250" may be 1.25 or 1250.

    A single comma that cannot be a thousands separator makes all commas decimal marks.
    """
    ambiguous_pattern = re.compile(r"[+-]?[1-9][0-9]{0,2},[0-9]{3}")
    example_line, example_cell = -1, ""
    for line in range(first, last + 1):
        if b"," not in text.raw_line(line):
            continue
        for cell in dialect.split_line(text.line(line)):
            if "," in cell:
                if ambiguous_pattern.fullmatch(cell) is None:
                    return
                example_line, example_cell = line, cell
    if example_line >= 0:
        raise FormatError(
            f"{text.describe_line(example_line)} has commas that may be decimal marks or thousands separators, "
            f"as in {example_cell!r}; write decimal points"
        )


# ---- Numbers --------------------------------------------------------------------------------------------------------


def parse_number_block(
    text: DecodedText, first: int, last: int, dialect: Dialect, *, ragged: bool = False
) -> NumberBlock:
    """Parse the lines of numbers from `first` to `last` as a matrix with one row per line.

    Lines of at most `MAX_CELLS_IN_COUNT_LINE` cells at the beginning are sizes and counts, and are skipped. Other lines
    with an unusual number of cells are rejected. Missing cells are filled with NaN in two cases: if only the height at
    a position is missing, and, with `ragged`, at the end of a table.
    """
    lines = _find_row_lines(text, first, last, dialect)
    if not lines.size:
        raise FormatError("has no lines of numbers where its heights should be")
    blob, cell_separator = _to_plain_rows(text, lines, dialect)
    starts, row_widths = stiction._core.find_rows(blob, cell_separator.decode())
    usual_width = Counter(row_widths.tolist()).most_common(1)[0][0]
    if usual_width == 1 and row_widths.max() == 2 and (row_widths == 2).sum() > 1:
        # If most rows of a table with two columns have a single cell, these rows lack a height.
        usual_width = 2
    if usual_width > MAX_CELLS_PER_LINE:
        raise FormatError(
            f"has lines of {usual_width} cells; at most {MAX_CELLS_PER_LINE} can be read; write one number per line, "
            "or save the heights as .npy"
        )
    num_skipped = int(np.argmax(row_widths == usual_width))
    if (row_widths[:num_skipped] > min(usual_width, MAX_CELLS_IN_COUNT_LINE)).any() or (
        usual_width == 2 and _rows_begin_with_positions(blob, cell_separator, num_skipped)
    ):
        num_skipped = 0
    skipped_lines = tuple(lines[:num_skipped].tolist())
    lines, row_widths, blob = (
        lines[num_skipped:],
        row_widths[num_skipped:],
        blob[starts[num_skipped] :] if num_skipped else blob,
    )
    # Separators at the end of a row would count as additional cells, so they are removed.
    if (row_widths > usual_width).any():
        rows = [
            row.rstrip(cell_separator) if n > usual_width else row
            for n, row in zip(row_widths, blob.splitlines(), strict=True)
        ]
        blob = b"".join(
            row + cell_separator * max(0, usual_width - 1 - row.count(cell_separator)) + b"\n" for row in rows
        )
        _, row_widths = stiction._core.find_rows(blob, cell_separator.decode())
    if (has_wrong_width := row_widths != usual_width).any():
        is_short_tail = ragged and bool(has_wrong_width[np.argmax(has_wrong_width) :].all())
        is_rejected = (row_widths > usual_width) | (
            (row_widths < usual_width) & (usual_width != 2) & (not is_short_tail)
        )
        if is_rejected.any():
            row_index = int(np.argmax(is_rejected))
            raise FormatError(
                f"{text.describe_line(int(lines[row_index]))} has {row_widths[row_index]} cells, but most lines have "
                f"{usual_width}; all lines of a table must have the same number of cells"
            )
        blob = b"".join(
            row + cell_separator * (usual_width - 1 - row.count(cell_separator)) + b"\n" for row in blob.splitlines()
        )
    values = _parse_cells(text, lines, usual_width, blob, cell_separator).reshape(-1, usual_width)
    end_widths = {len(dialect.split_line(text.line(int(row_index)))) for row_index in (*lines[:3], *lines[-3:])}
    while values.shape[1] > max(end_widths | {1}) and np.isnan(values[:, -1]).all():
        # A separator at the end of every line causes an empty cell.
        values = values[:, :-1]
    first_short_line = int(lines[np.argmax(has_wrong_width)]) if usual_width != 2 and has_wrong_width.any() else None
    return NumberBlock(text, lines, dialect, values, first_short_line, skipped_lines)


def _rows_begin_with_positions(blob: bytes, cell_separator: bytes, count: int) -> bool:
    """Return whether the first `count` + 3 rows begin with equally spaced numbers, which may be positions."""
    first_cells = [row.split(cell_separator)[0] for row in blob.split(b"\n", count + 3)[:-1]]
    if not count or not all(map(_is_number, first_cells)):
        return False
    steps = np.diff([float(token or b"nan") for token in first_cells])
    return bool(np.isclose(steps, steps[-1], rtol=0.1, atol=0.0).all())


def parse_numbers_in_lines(text: DecodedText, first: int, last: int) -> Floats:
    """Parse all numbers, separated by blanks or line breaks, in the lines from `first` to `last`."""
    blob = text.data[text.line_starts[first] : text.line_starts[last + 1]]
    if blob.translate(None, NUMERIC_CHARACTERS):
        blob = text.missing_word_pattern.sub(b"nan", blob)
    tokens = blob.split()
    if not tokens:
        return np.empty(0)
    return _parse_cells(text, np.full(len(tokens), first), 1, b"\n".join([*tokens, b""]), b"\n")


def _find_row_lines(text: DecodedText, first: int, last: int, dialect: Dialect) -> LineNumbers:
    """Return the line numbers of the table rows in a range of lines, including rows in which all cells are empty."""
    kinds = text.line_kinds[first : last + 1]
    is_nonblank = kinds != BLANK_LINE_CODE
    if dialect.separator is not None and not is_nonblank.all():
        for line in np.flatnonzero(~is_nonblank).tolist():
            is_nonblank[line] = dialect.separator.encode() in text.raw_line(first + line)
    return np.flatnonzero(is_nonblank) + first


def _to_plain_rows(text: DecodedText, lines: LineNumbers, dialect: Dialect) -> tuple[bytes, bytes]:
    """Rewrite table rows with decimal points instead of commas, and remove quotes and spaces around cells.

    Returns the rows and the cell separator. Each row ends with a line feed. A text that already has this form is
    returned without a copy.
    """
    first, last = int(lines[0]), int(lines[-1])
    if lines.size == last - first + 1:
        blob = text.data[text.line_starts[first] : text.line_starts[last + 1]]
    else:
        blob = b"".join(text.raw_line(int(line)) + b"\n" for line in lines)
    if text.has_words(lines):
        blob = text.missing_word_pattern.sub(b"nan", blob)
    if b"*" in blob or _has_adjacent_dashes(blob):
        blob = _MISSING_MARK_PATTERN.sub(b"nan", blob)
    separator = dialect.separator
    if b'"' in blob and separator is not None:
        reader = csv.reader(io.StringIO(blob.decode()), delimiter=separator, skipinitialspace=True)
        blob = "".join(_QUOTED_SEPARATOR.join(map(str.strip, row)) + "\n" for row in reader).encode()
        separator = _QUOTED_SEPARATOR
    if dialect.pairs:
        blob = re.sub(rb"([0-9]+),([0-9]+)", rb"\1.\2", blob)
    elif dialect.thousands:
        blob = blob.replace(dialect.thousands.encode(), b"")
    if dialect.point == "," and not dialect.pairs:
        if b"." in blob:
            _reject_decimal_points(text, lines, dialect)
        blob = blob.replace(b",", b".")
    if separator is None:
        blob = blob.replace(b'"', b" ").replace(b"\t", b" ")
        while b"  " in blob:
            blob = blob.replace(b"  ", b" ")
        return blob.replace(b" \n", b"\n").replace(b"\n ", b"\n").strip(b" "), b" "
    if b" " in blob:
        if _BLANK_IN_NUMBER_PATTERN.search(blob):
            _reject_blanks_in_numbers(text, lines)
        blob = blob.translate(None, b" ")
    return blob, separator.encode()


_MISSING_MARK_PATTERN = re.compile(rb"(?<![^\s;,|\"])(?:\*{1,40}|-{2,40})(?![^\s;,|\"])")
# The word "--" as an integer of two bytes, which is the same in both byte orders.
_TWO_DASHES_AS_INTEGER = int.from_bytes(b"--", "little")
_BLANK_IN_NUMBER_PATTERN = re.compile(rb"[0-9.] +[-+0-9.]")


def _has_adjacent_dashes(blob: bytes) -> bool:
    """Return whether a text contains two adjacent dashes.

    Comparing pairs of bytes is faster than a text search.
    """
    byte_pairs = (np.frombuffer(blob, np.uint16, (len(blob) - first_byte) // 2, first_byte) for first_byte in (0, 1))
    return len(blob) >= 2 and any((pairs_at_offset == _TWO_DASHES_AS_INTEGER).any() for pairs_at_offset in byte_pairs)


def _reject_decimal_points(text: DecodedText, lines: LineNumbers, dialect: Dialect) -> None:
    """Raise `FormatError` if a table with decimal commas contains a number with a decimal point."""
    for line in lines.tolist():
        for cell in dialect.split_line(text.line(line)):
            if re.fullmatch(rf"[+-]?[0-9]*\.[0-9]*{_EXPONENT_PATTERN}", cell):
                raise FormatError(
                    f"{text.describe_line(line)} has {cell!r}, with a point, but other numbers have decimal commas; "
                    "a spreadsheet program may have converted a number to a date; export the file again with decimal "
                    "points"
                )


def _reject_blanks_in_numbers(text: DecodedText, lines: LineNumbers) -> None:
    for line in lines.tolist():
        if _BLANK_IN_NUMBER_PATTERN.search(text.raw_line(line)):
            raise FormatError(
                f"{text.describe_line(line)} has blanks within a cell, which may separate thousands or two numbers; "
                "write numbers without blanks, and separate all cells in the same way"
            )


def _parse_cells(text: DecodedText, lines: LineNumbers, width: int, rows: bytes, cell_separator: bytes) -> Floats:
    """Parse the rows of a table to correctly rounded numbers, with NaN for empty cells."""
    values = np.empty(rows.count(b"\n") * width)
    failed_cell_indices = stiction._core.convert_cells(
        rows, cell_separator.decode(), values, threads=num_usable_cores()
    )
    if failed_cell_indices:
        cells = rows.replace(cell_separator, b"\n").split(b"\n")
    for index in failed_cell_indices:
        if not _is_number(cells[index]):
            word = cells[index].decode("utf-8", "replace")[:40]
            raise FormatError(
                f"{text.describe_line(int(lines[index // width]))} has {word!r} in cell {index % width + 1}, which is "
                f"not a number; {describe_remedy_of_word(word)}"
            )
        # A number outside the floating-point range becomes infinite or 0.
        values[index] = float(cells[index])
    return values


def _is_number(token: bytes) -> bool:
    try:
        float(token or b"nan")
    except ValueError:
        return False
    return b"_" not in token
