"""Heights in text: columns of numbers below any other text."""

from __future__ import annotations

import re
from array import array
from collections import Counter
from dataclasses import dataclass

import numpy as np

from stiction.surfaces.measured.raw import FormatError, Raw, Stated, length_unit

_NUMBER = r"([+-]?)([0-9]{{0,40}})(?:{point}([0-9]{{0,40}}))?(?:[eE]([+-]?[0-9]{{1,3}}))?"
_MISSING = re.compile(r"|nan|\*{1,20}|-{2,20}", re.IGNORECASE)
_COMMENT = ("#", "%", "//", "!")
_OTHER_UNITS = frozenset(
    {"V", "mV", "s", "ms", "deg", "°", "rad", "K", "N", "nN", "Pa", "in", "inch", "mil", "pt", "px", "pixel", "pixels"}
)
_BRACKETS = re.compile(r"[(\[{<]\s*([^()\[\]{}<>]{1,20}?)\s*[)\]}>]")
_VALUE = re.compile(r"(?:^|[\s,;:=])[+-]?[0-9][0-9.,]*(?:[eE][+-]?[0-9]+)?[^\W\d_]{0,3}(?=$|[\s,;:/])")
_STATED = re.compile(
    r"\W*(?:(?:x|lateral|horizontal|sampl\w*|point|data)[\s_-]*)?"
    r"(spacing|step(?: size)?|increment|interval|resolution|pixel size|dx)\s*[:=,;\t ]\s*"
    r"([0-9]{1,20}(?:[.,][0-9]{1,20})?(?:[eE][+-]?[0-9]{1,2})?)\s*([^\W\d_]{1,12})\s*(/|per\b)?",
    re.IGNORECASE,
)
_SAMPLE = 200


@dataclass(frozen=True)
class Dialect:
    """What separates the cells of a line, None for white space, and what stands before the decimals."""

    separator: str | None
    point: str

    def cells(self, line: str) -> list[str]:
        """Cells without the empty ones at the end, which some programs put there."""
        cells = line.split() if self.separator is None else [cell.strip() for cell in line.split(self.separator)]
        while cells and not cells[-1]:
            cells.pop()
        return cells

    @property
    def number(self) -> re.Pattern[str]:
        """Of which the groups are sign, whole digits, decimals and exponent."""
        return re.compile(_NUMBER.format(point=re.escape(self.point)), re.ASCII)


_DIALECTS = [
    Dialect("\t", "."), Dialect("\t", ","), Dialect(";", "."), Dialect(";", ","), Dialect(",", "."),
    Dialect(None, "."), Dialect(None, ","),
]  # fmt: skip


def read_text(data: bytes) -> Raw:
    """Take a text apart: one column of heights, two of positions and heights, or a matrix of heights."""
    lines = _decoded(data).split("\n")
    dialect = _dialect(lines)
    if dialect.point == ",":
        _refuse_thousands(lines, dialect)
    table = _table(lines, dialect)
    return _interpreted(table, lines, dialect)


def _decoded(data: bytes) -> str:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = data.decode("utf-16", "replace")
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("latin-1")
    text = text.rstrip("\x1a")  # with which DOS ends a text
    control = sum(text.count(chr(code)) for code in (*range(9), *range(14, 32)))
    if control:
        raise FormatError(f"is binary, not text ({control} control characters)")
    if not text.strip():
        raise FormatError("holds nothing but blanks")
    return text if "\n" in text else text.replace("\r", "\n")


# ---- Which lines are data -------------------------------------------------------------------------------------------


def _values(cells: list[str], number: re.Pattern[str]) -> list[re.Match[str] | None] | None:
    """A match for each number and None for each missing one; None if the line is no data."""
    values: list[re.Match[str] | None] = []
    any_number = False
    for cell in cells:
        match = number.fullmatch(cell)
        if match is not None and (match[2] or match[3]):
            any_number = True
            values.append(match)
        elif _MISSING.fullmatch(cell):
            values.append(None)
        else:
            return None
    return values if any_number else None


def _dialect(lines: list[str]) -> Dialect:
    """The one in which most of the last lines are data."""
    sample = [text for line in lines[-2 * _SAMPLE :] if (text := line.strip(" \r"))][-_SAMPLE:]
    counts = []
    for dialect in _DIALECTS:
        number = dialect.number
        counts.append(sum(_values(dialect.cells(line), number) is not None for line in sample))
    best = int(np.argmax(counts))
    if counts[best] == 0:
        raise FormatError("no numbers were found at its end; it should end with one or two columns of numbers")
    dialect, commas = _DIALECTS[best], Dialect(",", ".")
    data = [line for line in sample if _values(dialect.cells(line), dialect.number) is not None]
    # "1,5" is a number or two.
    pair = re.compile(r"[+-]?[0-9]+(,[0-9]+)?")
    if any("," in line for line in data) and all(pair.fullmatch(line) for line in data):
        if _header_has_cells(lines, commas):
            return commas
        raise FormatError(
            f"its lines, such as {data[0][:40]!r}, may be two columns or one with decimal commas; "
            'write decimal points, or a header such as "x (um),z (um)"'
        )
    return dialect


def _refuse_thousands(lines: list[str], dialect: Dialect) -> None:
    """Commas that all stand where they could part thousands may be decimal or not: "1,250" is 1.25 or 1250."""
    doubtful = re.compile(r"[+-]?[1-9][0-9]{0,2},[0-9]{3}")
    example = ""
    for line in lines:
        cells = dialect.cells(line.strip(" \r"))
        if _values(cells, dialect.number) is None:
            continue
        for cell in cells:
            if "," in cell:
                if doubtful.fullmatch(cell) is None:
                    return
                example = cell
    if example:
        raise FormatError(f"its commas, as in {example!r}, may be decimal or part thousands; write decimal points")


def _header_has_cells(lines: list[str], dialect: Dialect) -> bool:
    above = ""
    for line in lines:
        text = line.strip(" \r")
        if text and _values(dialect.cells(text), dialect.number) is not None:
            return len(dialect.cells(above)) == 2
        above = text or above
    return False


@dataclass(frozen=True)
class _Table:
    values: array[float]
    counts: array[int]
    first_line: int
    decimals: array[int]
    """Of the first number of each line."""
    digits: int
    """Most significant digits of any first number."""


def _table(lines: list[str], dialect: Dialect) -> _Table:
    number = dialect.number
    values, counts, decimals = array("d"), array("q"), array("q")
    digits, first_line, text_since = 0, 0, 0
    for at, line in enumerate(lines, start=1):
        stripped = line.strip(" \r")
        if not stripped or stripped == "\t" * len(stripped):
            continue
        row = None if stripped.startswith(_COMMENT) else _values(dialect.cells(stripped), number)
        if row is None:
            text_since = at
            continue
        if not counts:
            first_line = at
        elif text_since > first_line:
            interruption = lines[text_since - 1].strip()
            raise FormatError(
                f"line {text_since} ({interruption[:40]!r}) stands between numbers, those from line {first_line} and "
                f"those from line {at}; leave only the columns that are meant"
            )
        counts.append(len(row))
        values.extend(
            float(f"{match[1]}{match[2]}.{match[3] or ''}e{match[4] or 0}") if match else np.nan for match in row
        )
        if (first := row[0]) is not None:
            decimals.append(len(first[3] or "") - int(first[4] or 0))
            digits = max(digits, len((first[2] + (first[3] or "")).lstrip("0")))
        else:
            decimals.append(0)
    if text_since > first_line:
        raise FormatError(f"line {text_since} ({lines[text_since - 1].strip()[:40]!r}), after the data, is none")
    return _Table(values, counts, first_line, decimals, digits)


# ---- What they mean -------------------------------------------------------------------------------------------------


def _interpreted(table: _Table, lines: list[str], dialect: Dialect) -> Raw:
    counts = np.frombuffer(table.counts, dtype=np.int64)
    values = np.array(table.values)
    columns = Counter(table.counts).most_common(1)[0][0]
    if columns == 1 and counts.max() == 2 and (counts == 2).sum() > 1:
        columns = 2  # most heights are missing
    header = [text for line in lines[: table.first_line - 1] if (text := line.strip(" \r\t"))]
    stated = next((found for line in header if (found := _stated(line))), None)
    short = columns == 2 and counts.max() == 2  # an x without a height: the height is missing
    if not (counts == columns).all() and not short:
        row = int(np.flatnonzero(counts != columns)[0])
        raise FormatError(
            f"the {row + 1}. line of data has {counts[row]} column(s) and most have {columns}; all need the same"
        )
    units = _units(header, columns, dialect)
    if columns == 1:
        return Raw(values, unit=units[0], stated=stated)
    if columns > 2:
        if columns == 3 or len(set(units)) > 1 or _names(header, columns, dialect):
            raise FormatError(
                f"has {columns} columns of numbers that may be positions and several heights; a profile has one column "
                "of heights or two of positions and heights, a surface a matrix of four or more without names"
            )
        matrix = values.reshape(-1, columns)
        return Raw(matrix, unit=units[0] if len(set(units)) == 1 else None, stated=stated)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    positions = values[starts]
    heights = np.full(positions.shape, np.nan)
    heights[counts == 2] = values[starts[counts == 2] + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.floor(np.log10(np.abs(positions)))
    by_digits = np.where(np.isfinite(size), size, -400) + 1 - table.digits
    by_decimals = -max(table.decimals)
    digit = 10.0 ** np.clip(np.maximum(by_decimals, by_digits), -300, 300)
    return Raw(heights, unit=units[1], positions=positions, digit=digit, position_unit=units[0], stated=stated)


def _stated(line: str) -> Stated | None:
    match = _STATED.match(line)
    if match is None:
        return None
    label, digits, unit, per = match.groups()
    if length_unit(unit) is None or (label.casefold() == "resolution" and not per):
        return None
    mantissa, _, exponent = digits.replace(",", ".").lower().partition("e")
    digit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return Stated(float(f"{mantissa}e{exponent or 0}"), digit, str(length_unit(unit)))


def _names(header: list[str], columns: int, dialect: Dialect) -> bool:
    """Whether each column has a name of its own."""
    return bool(header) and columns > 2 and len(dialect.cells(header[-1].lstrip("#%!/ "))) == columns


def _units(header: list[str], columns: int, dialect: Dialect) -> list[str | None]:
    """The unit of each column from the line of names above the data."""
    named = [line.lstrip("#%!/ ") for line in header if any(character.isalpha() for character in line)]
    # A line with a number is not one of names: "Length (um): 1500" says nothing of the heights below it.
    if not named or _VALUE.search(_BRACKETS.sub(" ", named[-1])):
        return [None] * columns
    cells = dialect.cells(named[-1])
    if len(cells) == columns and any(_unit(cell) for cell in cells):
        return [_unit(cell) for cell in cells]
    units = [unit for word in _BRACKETS.findall(named[-1]) if (unit := _known(word))]
    if not units:
        units = [unit for word in re.split(r"[\s,;]+", named[-1]) if (unit := _known(word))]
    if len(units) == columns:
        return list(units)
    return [units[0] if columns > 2 and len(units) == 1 else None] * columns


def _unit(cell: str) -> str | None:
    """The unit that the name of a column ends with: "z (nm)", "z [nm]", "z/nm", "height in nm", "z nm"."""
    bracketed = _BRACKETS.findall(cell)
    named = bracketed[-1] if bracketed else cell.strip(" \"'")
    if named in _OTHER_UNITS:
        raise FormatError(
            f"a column has the unit {named!r}, which is no length that is known here (m, mm, um, nm, ...)"
        )
    return _known(named if bracketed else re.split(r"[\s/_]+", named)[-1])


def _known(word: str) -> str | None:
    return length_unit(word.strip(" \"'.:"))
