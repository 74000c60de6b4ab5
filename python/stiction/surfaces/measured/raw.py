"""Content of a file of measured heights, before its units and missing points are resolved."""

from __future__ import annotations

import unicodedata
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from stiction._checks import Floats

LENGTH_UNITS = {
    "m": 1e6, "cm": 1e4, "mm": 1e3, "um": 1.0, "µm": 1.0, "μm": 1.0, "nm": 1e-3, "pm": 1e-6,
    "\u00c5": 1e-4, "\u212b": 1e-4,
    "metre": 1e6, "meter": 1e6, "metres": 1e6, "meters": 1e6,
    "millimetre": 1e3, "millimeter": 1e3, "millimetres": 1e3, "millimeters": 1e3,
    "micrometre": 1.0, "micrometer": 1.0, "micrometres": 1.0, "micrometers": 1.0, "micron": 1.0, "microns": 1.0,
    "nanometre": 1e-3, "nanometer": 1e-3, "nanometres": 1e-3, "nanometers": 1e-3,
    "angstrom": 1e-4, "ångström": 1e-4,
}  # fmt: skip
"""Factors to µm; both Unicode spellings of micro and of the ring. Symbols as they are written, words in any case."""

MOST_BYTES = 2_000_000_000
MOST_TEXT_BYTES = 300_000_000  # largest text, which takes some ten times its size in memory while it is parsed
_CHUNK = 1 << 16
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # methods that unpack no more than is asked for at a time


class FormatError(ValueError):
    """A file that cannot be read as a measured surface: damaged, of another kind, or incomplete."""


class FormatWarning(UserWarning):
    """A file that contradicts itself, or heights that are hardly those of a surface."""


@dataclass(frozen=True)
class Caveat:
    """A doubt about a file that was read, named, with the option or the edit that settles it."""

    name: str
    text: str
    cure: str

    def __str__(self) -> str:
        return f"{self.text}; {self.cure} ({self.name})"


@dataclass(frozen=True)
class Stated:
    """A length that stands in words beside the data, with what its last digit is worth."""

    length: float
    digit: float
    unit: str


@dataclass(frozen=True)
class Source:
    """Place of the heights in a file: how the file is laid out, which part was read and which was skipped."""

    layout: str = ""
    column: str = ""  # column, channel or block of the heights
    encoding: str = ""  # of a text
    separator: str = ""
    decimal_mark: str = ""
    lines: tuple[int, int] | None = None  # first and last line of the data, from 1 on
    lines_above: int = 0  # lines with words or numbers that are no data
    lines_below: int = 0


Digits = Callable[[], Floats]


@dataclass(frozen=True)
class Raw:
    """Numbers as they stand in a file, each with its unit if the file has one; missing heights are NaN."""

    heights: Floats  # (n,) or (rows, columns)
    unit: str | None = None
    positions: Floats | None = None  # (n,) of a profile
    digits: Digits | None = None  # returns (n,), what the last printed digit of each position is worth
    position_unit: str | None = None  # unit of the positions, or else of the spacing
    spacing: tuple[float, ...] | None = None  # (Δx,) or (Δy, Δx), where there are no positions
    stated: Stated | None = None  # a spacing in words
    stated_spacings: tuple[Stated, Stated] | None = None  # spacings of an area in words, between rows and columns
    size: tuple[Stated, Stated] | None = None  # height and width of an area in words
    history: tuple[str, ...] = ()  # what was chosen of what the file holds, a short sentence for each
    source: Source = Source()
    codes: tuple[float, ...] = ()  # declared values of missing points
    factor: float | None = None  # declared factor from the numbers of the file to `unit`
    bare_spacing: tuple[float, ...] | None = None  # a spacing in words without a unit
    caveats: tuple[Caveat, ...] = ()


@dataclass(frozen=True)
class Table:
    """Numbers in columns, of which one or two make a profile, or all an area."""

    values: Floats  # (rows, columns), NaN where they are missing
    names: tuple[str, ...] = ()  # names of the columns; empty if they have none
    units: tuple[str | None, ...] = ()
    digits: Callable[[int], Floats] | None = None  # (rows,) worth of the last printed digit of each number of a column
    row_digits: Callable[[int], Floats] | None = None  # the same of a row
    declared: Declared = field(default_factory=lambda: Declared())
    history: tuple[str, ...] = ()  # what was done to the heights before they were written, a sentence for each step
    area: bool = False  # whether two columns may be an area as well: then positions are known by counting evenly
    source: Source = Source()
    places: tuple[int, ...] | None = None  # numbers of the columns as a user counts them, if some are left out
    caveats: tuple[Caveat, ...] = ()

    def column_digits(self, column: int) -> Digits | None:
        """Return the function that computes the worth of the last digits of a column."""
        digits = self.digits
        return None if digits is None else lambda: digits(column)


@dataclass(frozen=True)
class Declared:
    """Facts that the words above the numbers declare."""

    spacing: Stated | None = None  # of a profile, or in one direction of an area
    spacings: tuple[Stated, Stated] | None = None  # between rows and between columns of an area
    size: tuple[Stated, Stated] | None = None  # height and width of an area
    bare_spacing: tuple[float, ...] | None = None  # without a unit: (Δx,) or (Δy, Δx)
    unit: str | None = None  # of heights; it may be no length
    factor: float | None = None  # from the numbers to `unit`
    codes: tuple[float, ...] = ()  # values of missing points
    counts: tuple[float, ...] = ()  # whole numbers that are values of missing points, or count missing points
    scale: str = ""  # line with a factor or a range of heights, without evidence for either
    points: int | None = None  # of a profile
    tip_radius: Stated | None = None  # of the stylus
    line: str = ""  # that declares the unit or the factor


@dataclass(frozen=True)
class Channels:
    """Several sets of heights in one file, each with a name."""

    names: tuple[str, ...]
    read: Callable[[int], Raw | Table]  # what a channel holds, by its place
    default: int | None  # read if none is asked for; without one, one has to be chosen


Content = Raw | Table | Channels  # what a reader may find in a file


def length_unit(text: str) -> str | None:
    """Return the unit of length that a text is, as a key of `LENGTH_UNITS`, or None."""
    if text in LENGTH_UNITS:
        return text
    plain = unicodedata.normalize("NFKC", text)  # among others of single characters such as ㎛
    if plain in LENGTH_UNITS:
        return plain
    folded = plain.casefold()
    return folded if len(folded) > 3 and folded in LENGTH_UNITS else None


# ---- Archives -------------------------------------------------------------------------------------------------------


def chunks(archive: zipfile.ZipFile, name: str, most: int) -> Iterator[bytes]:
    """A member piece by piece, at most so many bytes, whatever the archive's directory says of its size."""
    try:
        info = archive.getinfo(name)
    except KeyError:
        raise FormatError(f"lacks {name[:80]!r}, where its data should be") from None
    if info.compress_type not in _METHODS:
        raise FormatError(f"holds {name[:80]!r} compressed by another method than deflate")
    if info.file_size > most:
        raise FormatError(f"holds {name[:80]!r} of {info.file_size} bytes; at most {most} can be read")
    total = 0
    with archive.open(info) as member:
        while chunk := member.read(_CHUNK):
            total += len(chunk)
            if total > most:
                raise FormatError(f"holds {name[:80]!r} of more than {most} bytes")
            yield chunk
