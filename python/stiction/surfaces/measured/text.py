"""Heights in text: columns of numbers below any other text."""

from __future__ import annotations

import re
from array import array
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from stiction._checks import Floats
from stiction._text import printable
from stiction.surfaces.measured.raw import FormatError, Stated, Table, length_unit

_NUMBER = r"([+-]?)([0-9]{{0,40}})(?:{point}([0-9]{{0,40}}))?(?:[eE]([+-]?[0-9]{{1,3}}))?"
_MISSING = re.compile(r"|nan|\*{1,20}|-{2,20}", re.IGNORECASE)
_COMMENT = ("#", "%", "//", "!")
_OTHER_UNITS = {
    "V", "mV", "s", "ms", "deg", "°", "rad", "K", "kN", "N", "mN", "uN", "µN", "nN", "Pa", "kPa", "MPa", "Hz", "in",
    "inch", "mil", "pt", "px", "pixel", "pixels",
}  # fmt: skip
_BRACKETS = re.compile(r"[(\[{<]\s*([^()\[\]{}<>]{1,20}?)\s*[)\]}>]")
_VALUE = re.compile(r"(?:^|[\s,;:=])[+-]?[0-9][0-9.,]*(?:[eE][+-]?[0-9]+)?[^\W\d_]{0,3}(?=$|[\s,;:/])")
_STATED = re.compile(
    r"\W*(?:(?:x|lateral|horizontal|sampl\w*|point|data)[\s_-]*)?"
    r"(spacing|step(?: size)?|increment|interval|resolution|pixel size|dx)\s*[:=,;\t ]\s*"
    r"([0-9]{1,20}(?:[.,][0-9]{1,20})?(?:[eE][+-]?[0-9]{1,2})?)\s*([^\W\d_]{1,12})\s*(/|per\b)?",
    re.IGNORECASE,
)
_HISTORY = "# history: "
_SPACINGS = tuple(
    re.compile(rf"# spacing along {axis}: ([0-9]{{1,20}}(?:\.[0-9]{{1,20}})?(?:e[+-]?[0-9]{{1,2}})?) (um)")
    for axis in "yx"
)
"""Header lines as `write_surface` writes them above a matrix."""

_SIZES = tuple(
    re.compile(
        rf"\W{{0,4}}{name}\s*[:=]\s*([0-9]{{1,20}}(?:[.,][0-9]{{1,20}})?(?:[eE][+-]?[0-9]{{1,2}})?)\s*([^\W\d_]{{1,12}})\s*",
        re.IGNORECASE,
    )
    for name in ("height", "width")
)
"""Header lines as Gwyddion writes them above a matrix."""

_LONGEST_STEP, _MOST_STEPS = 1000, 1000  # characters of a step of the history above the data, and steps of it

MOST_LINES, MOST_CELLS = 25_000_000, 4_000_000
"""Lines of a text, and cells of one: each is a Python object for a while, so that more of them need gigabytes."""

_SAMPLE = 200
_SAMPLE_WIDTH = 20_000


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
        """Pattern whose groups are sign, whole digits, decimals and exponent."""
        return re.compile(_NUMBER.format(point=re.escape(self.point)), re.ASCII)


_DIALECTS = [
    Dialect("\t", "."), Dialect("\t", ","), Dialect(";", "."), Dialect(";", ","), Dialect("|", "."), Dialect("|", ","),
    Dialect(",", "."), Dialect(None, "."), Dialect(None, ","),
]  # fmt: skip


def read_text(data: bytes) -> Table:
    """Take a text apart into columns of numbers."""
    text = _decoded(data)
    if (count := text.count("\n")) > MOST_LINES:
        raise FormatError(f"has {count} lines; at most {MOST_LINES} can be read as text: save it as .npy")
    lines = text.split("\n")
    longest = max(lines, key=len)
    # Not more than it has in any dialect.
    cells = 1 + max(longest.count(";"), longest.count("|"), sum(longest.count(each) for each in "\t ,"))
    if cells > MOST_CELLS:
        raise FormatError(
            f"has a line of up to {cells} cells; at most {MOST_CELLS} can be read: write one number a line, or .npy"
        )
    return read_lines(lines)


def read_lines(lines: list[str]) -> Table:
    """Take the lines of a text apart into columns of numbers."""
    dialect = _dialect(lines)
    if dialect.point == ",":
        _refuse_thousands(lines, dialect)
    table = _numbers(lines, dialect)
    counts, written = (np.frombuffer(each, dtype=np.int64) for each in (table.counts, table.written))
    columns = Counter(table.counts).most_common(1)[0][0]
    if columns == 1 and counts.max() == 2 and (counts == 2).sum() > 1:
        columns = 2  # most heights are missing
    header = [text for line in lines[: table.first_line - 1] if (text := line.rstrip(" \r\t")).strip(" \t")]
    # The last numbers of a line may be missing, with their separators there, or the height of an x.
    short = (counts < columns) & ((written >= columns) | (columns == 2))
    if not (short | (counts == columns)).all():
        row = int(np.flatnonzero(~short & (counts != columns))[0])
        raise FormatError(
            f"the {row + 1}. line of data has {counts[row]} column(s) and most have {columns}; all need the same"
        )
    values = np.full((counts.size, columns), np.nan)
    values[np.arange(columns) < counts[:, np.newaxis]] = np.array(table.values)
    history = [line.removeprefix(_HISTORY) for line in header if line.startswith(_HISTORY)]
    return Table(
        values,
        names=_names(header, columns, dialect),
        units=tuple(_units(header, columns, dialect)),
        digit=lambda column: _digit(values[:, column], column, lines, dialect),
        stated=next((found for line in header if (found := _stated(line))), None),
        size=_lengths(_SIZES, header),
        spacings=_lengths(_SPACINGS, header),
        history=tuple(printable(step, _LONGEST_STEP) for step in history[:_MOST_STEPS]),
    )


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
            any_number |= cell.lower() == "nan"  # no header says it, and a row may have nothing else
            values.append(None)
        else:
            return None
    return values if any_number else None


def _rows(lines: Iterable[str], dialect: Dialect) -> Iterator[tuple[int, str, list[re.Match[str] | None] | None]]:
    """Number and text of each line with something on it, and its values; None of a line that is no data."""
    number = dialect.number
    for at, line in enumerate(lines, start=1):
        text = line.strip(" \r")
        if text.strip("\t"):
            yield at, text, None if text.startswith(_COMMENT) else _values(dialect.cells(text), number)


def _dialect(lines: list[str]) -> Dialect:
    """The one in which most of the last lines are data."""
    sample = [_beginning(text) for line in lines[-2 * _SAMPLE :] if (text := line.strip(" \r"))][-_SAMPLE:]
    counts = [sum(row is not None for _, _, row in _rows(sample, dialect)) for dialect in _DIALECTS]
    best = int(np.argmax(counts))
    if counts[best] == 0:
        raise FormatError("no numbers were found at its end; it should end with one or two columns of numbers")
    dialect, commas = _DIALECTS[best], Dialect(",", ".")
    data = [line for _, line, row in _rows(sample, dialect) if row is not None]
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


def _beginning(line: str) -> str:
    """A line that can be looked at several times: of a long one the first cells."""
    return line if len(line) <= _SAMPLE_WIDTH else re.sub(r"[^\t;|, ]*$", "", line[:_SAMPLE_WIDTH]).rstrip("\t;|, ")


def _refuse_thousands(lines: list[str], dialect: Dialect) -> None:
    """Commas that all stand where they could part thousands may be decimal or not: "1,250" is 1.25 or 1250."""
    doubtful = re.compile(r"[+-]?[1-9][0-9]{0,2},[0-9]{3}")
    example = ""
    for _, text, row in _rows(lines, dialect):
        for cell in dialect.cells(text) if row is not None else ():
            if "," in cell:
                if doubtful.fullmatch(cell) is None:
                    return
                example = cell
    if example:
        raise FormatError(f"its commas, as in {example!r}, may be decimal or part thousands; write decimal points")


def _header_has_cells(lines: list[str], dialect: Dialect) -> bool:
    above = ""
    for _, text, row in _rows(lines, dialect):
        if row is not None:
            return len(dialect.cells(above)) == 2
        above = text
    return False


@dataclass(frozen=True)
class _Numbers:
    values: array[float]
    counts: array[int]
    written: array[int]  # cells of each line, with the empty ones at its end; of white space as the counts
    first_line: int


def _numbers(lines: list[str], dialect: Dialect) -> _Numbers:
    values, counts, written = array("d"), array("q"), array("q")
    first_line, text_since = 0, 0
    for at, text, row in _rows(lines, dialect):
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
        written.append(len(row) if dialect.separator is None else text.count(dialect.separator) + 1)
    if text_since > first_line:
        raise FormatError(f"line {text_since} ({lines[text_since - 1].strip()[:40]!r}), after the data, is not data")
    return _Numbers(values, counts, written, first_line)


# ---- What they mean -------------------------------------------------------------------------------------------------


def _digit(values: Floats, column: int, lines: list[str], dialect: Dialect) -> Floats:
    """What the last printed digit of each number of a column is worth: by its decimals or by its significant digits."""
    decimals = digits = 0
    most = -1000
    for _, _, row in _rows(lines, dialect):
        if row is None or column >= len(row):
            continue
        match = row[column]
        if match is not None:
            decimals = len(match[3] or "") - int(match[4] or 0)
            digits = max(digits, len((match[2] + (match[3] or "")).lstrip("0")))
        else:
            decimals = 0
        most = max(most, decimals)
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.floor(np.log10(np.abs(values)))
    by_digits = np.where(np.isfinite(size), size, -400) + 1 - digits
    return np.asarray(10.0 ** np.clip(np.maximum(-most, by_digits), -300, 300))


def _stated(line: str) -> Stated | None:
    match = _STATED.match(line)
    if match is None or (match[1].casefold() == "resolution" and not match[4]):
        return None
    return _with_digit(match[2], match[3])


def _lengths(patterns: tuple[re.Pattern[str], ...], header: list[str]) -> tuple[Stated, Stated] | None:
    """Two lengths that lines of a header say, each by the first line of its pattern; None without either."""
    both = [[match for line in header if (match := pattern.fullmatch(line))] for pattern in patterns]
    said = [next((length for match in each if (length := _with_digit(*match.groups()))), None) for each in both]
    return (said[0], said[1]) if said[0] and said[1] else None


def _with_digit(digits: str, unit: str) -> Stated | None:
    if length_unit(unit) is None:
        return None
    mantissa, _, exponent = digits.replace(",", ".").lower().partition("e")
    digit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return Stated(float(f"{mantissa}e{exponent or 0}"), digit, str(length_unit(unit)))


def _names(header: list[str], columns: int, dialect: Dialect) -> tuple[str, ...]:
    """The name of each column, where each has one; the first may be empty."""
    cells = dialect.cells(header[-1].lstrip("#%!/ ")) if header and columns > 1 else []
    return tuple(cell.strip(" \"'") for cell in cells) if len(cells) == columns else ()


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
    if named in _OTHER_UNITS:  # which is refused, if it is this column that is meant
        return named
    return _known(named if bracketed else re.split(r"[\s/_]+", named)[-1])


def _known(word: str) -> str | None:
    return length_unit(word.strip(" \"'.:"))
