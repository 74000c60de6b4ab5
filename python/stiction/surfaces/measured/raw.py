"""Content of a scan file before units and missing points are determined."""

from __future__ import annotations

import math
import re
import unicodedata
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats

LENGTH_UNITS = {
    "m": 1e6, "cm": 1e4, "mm": 1e3, "um": 1.0, "µm": 1.0, "μm": 1.0, "nm": 1e-3, "pm": 1e-6,
    "\u00c5": 1e-4, "\u212b": 1e-4,
    "metre": 1e6, "meter": 1e6, "metres": 1e6, "meters": 1e6,
    "millimetre": 1e3, "millimeter": 1e3, "millimetres": 1e3, "millimeters": 1e3,
    "micrometre": 1.0, "micrometer": 1.0, "micrometres": 1.0, "micrometers": 1.0, "micron": 1.0, "microns": 1.0,
    "nanometre": 1e-3, "nanometer": 1e-3, "nanometres": 1e-3, "nanometers": 1e-3,
    "angstrom": 1e-4, "angstroms": 1e-4, "ångström": 1e-4, "mikrometer": 1.0, "mikron": 1.0,
    "micromètre": 1.0, "micromètres": 1.0, "micrómetro": 1.0, "micrómetros": 1.0, "micrometro": 1.0, "micrometri": 1.0,
    "nanomètre": 1e-3, "nanomètres": 1e-3, "nanómetros": 1e-3, "nanometri": 1e-3,
    "millimètre": 1e3, "millimètres": 1e3, "milímetros": 1e3, "millimetri": 1e3,
    "мм": 1e3, "мкм": 1.0, "нм": 1e-3, "毫米": 1e3, "微米": 1.0, "纳米": 1e-3,
}  # fmt: skip
"""Factors that convert lengths to µm, by unit of length.

Both Unicode characters for micro and for ångström are included. Upper and lower case are distinguished in symbols, but
not in words.
"""

MAX_FILE_BYTES = 2_000_000_000
# Parsing a text file needs ten times as much memory as its text.
MAX_TEXT_BYTES = 300_000_000
MAX_POINTS_PER_BYTE = 100
MAX_POINTS_OF_SMALL_MAP = 1_000_000
MIN_DECLARED_LENGTH, MAX_DECLARED_LENGTH = 1e-6, 1e9  # µm
MIN_DECLARED_NUMBER, MAX_DECLARED_NUMBER = 1e-30, 1e30
"""Smallest and largest factor or length that a header can declare, in any unit."""

_LEADING_NUMBER_PATTERN = re.compile(
    r"\s*([+-]?[0-9]{0,40}(?:[.,][0-9]{0,40})?(?:[eE][+-]?[0-9]{1,5})?)(?![0-9.,_xX]|[eE](?![^\W\d_]))"
)
"""Regular expression for a decimal number, which a unit may follow. Hexadecimal and incomplete numbers do not match."""

_ARCHIVE_CHUNK_SIZE = 1 << 16
# Compression methods of ZIP archives that permit decompression in pieces of limited size.
_COMPRESSION_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


class FormatError(ValueError):
    """Error raised if a file is damaged, incomplete or unsupported, or if output would overwrite it.

    Notes
    -----
    `FormatError` is a `ValueError`. The message names the file and the reason in one sentence.

    Examples
    --------
    >>> from stiction import FormatError, read_profile
    >>> try:
    ...     read_profile("absent.csv")
    ... except FormatError as error:
    ...     print(error)
    absent.csv: cannot be read: No such file or directory
    """


class FormatWarning(UserWarning):
    """Warning about a file that contradicts itself, or that contains implausible heights.

    Notes
    -----
    Readers issue this warning. The message contains the name of each caveat, and the option that resolves it. The
    argument `accept` of the readers suppresses the caveats that it lists.

    Examples
    --------
    >>> import warnings
    >>> from stiction import FormatWarning
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("error", FormatWarning)  # reject files with caveats
    """


@dataclass(frozen=True)
class FileCaveat:
    """Caveat about a scan file: its name, its text and a remedy, such as an option or a change to the file."""

    name: str
    text: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.text}; {self.remedy} ({self.name})"


@dataclass(frozen=True)
class DeclaredLength:
    """Length that a scan file declares, and the place value of the last digit with which it is written."""

    length: float
    digit: float
    unit: str
    line: str = ""

    def to_micrometres(self) -> float:
        """Convert the declared length to µm.

        Raises `FormatError` if the length is too small or too large for the spacing or the size of a scan.
        """
        value = self.length * LENGTH_UNITS[self.unit]
        min_length, max_length = MIN_DECLARED_LENGTH, MAX_DECLARED_LENGTH
        if not min_length <= value <= max_length:
            raise FormatError(
                f"has an impossible length in its header line {self.line[:80]!r}; a spacing or size must be between "
                f"{min_length:g} and {max_length:g} µm"
            )
        return value

    @property
    def digit_in_micrometres(self) -> float:
        """Place value (µm) of the last digit with which the length is written in the file."""
        return self.digit * LENGTH_UNITS[self.unit]


@dataclass(frozen=True)
class UnclearSpacing:
    """Header line that may declare a spacing.

    A single length in this line is used as the spacing, with a caveat.
    """

    line: str
    # Lengths (µm) in the header line: one for both axes, or two if the order of the axes is unknown.
    lengths: tuple[float, ...] = ()


@dataclass(frozen=True)
class HeightProvenance:
    """Provenance of the heights in a scan file: layout, column, encoding, separators and line numbers."""

    layout: str = ""
    column: str = ""
    encoding: str = ""
    separator: str = ""
    decimal_mark: str = ""
    lines: tuple[int, int] | None = None  # counted from 1
    lines_above: int = 0
    lines_below: int = 0


LastDigitValueFunction = Callable[[], Floats]


@dataclass(frozen=True)
class RawHeights:
    """Heights of a scan file before conversion to µm, with the unit, positions and spacing that the file contains.

    Missing heights are NaN.
    """

    heights: Floats  # in the unit of the file
    unit: str | None = None
    positions: Floats | None = None
    digits: LastDigitValueFunction | None = None
    position_unit: str | None = None
    spacing: tuple[float, ...] | None = None  # (Δx,) or (Δy, Δx)
    declared_spacing: DeclaredLength | None = None
    declared_spacings: tuple[DeclaredLength, DeclaredLength] | None = None  # rows, columns
    size: tuple[DeclaredLength, DeclaredLength] | None = None  # height, width
    history: tuple[str, ...] = ()
    source: HeightProvenance = HeightProvenance()
    codes: tuple[float, ...] = ()
    factor: float | None = None  # number in the file to `unit`
    bare_spacing: tuple[float, ...] | None = None
    unclear_spacing: UnclearSpacing | None = None
    height_range: DeclaredLength | None = None
    caveats: tuple[FileCaveat, ...] = ()


@dataclass(frozen=True)
class WordColumn:
    """Column of words next to columns of numbers, for example a column of flags such as "OK" and "NG"."""

    place: int
    words: str
    rarest_word: str
    missing: NDArray[np.bool_]
    units: tuple[str, ...] = ()


@dataclass(frozen=True)
class ColumnTable:
    """Table of numbers in a scan file.

    One or two columns form a profile; all columns together may form a map.
    """

    # Numbers of the table, with the shape (rows, columns). Missing numbers are NaN.
    values: Floats
    names: tuple[str, ...] = ()
    units: tuple[str | None, ...] = ()
    digits: Callable[[int], Floats] | None = None
    row_digits: Callable[[int], Floats] | None = None
    declared: HeaderDeclarations = field(default_factory=lambda: HeaderDeclarations())
    history: tuple[str, ...] = ()
    is_array: bool = False
    source: HeightProvenance = HeightProvenance()
    # Column numbers in the file, one for each column of the table; None if the table has all columns of the file.
    places: tuple[int, ...] | None = None
    # Number of rows and first line (counted from 1) of each block, if empty lines divide the text into blocks of rows.
    block_lengths: tuple[int, ...] = ()
    block_lines: tuple[int, ...] = ()
    caveats: tuple[FileCaveat, ...] = ()
    word_columns: tuple[WordColumn, ...] = ()

    def last_digit_value_function(self, column: int) -> LastDigitValueFunction | None:
        """Return a function that computes the place value of the last printed digit of each number in a column.

        Returns None if the printed digits are unknown.
        """
        digits = self.digits
        return None if digits is None else lambda: digits(column)


@dataclass(frozen=True)
class HeaderDeclarations:
    """Declarations in the header of a table: lengths, units, factors and codes for missing points."""

    spacing: DeclaredLength | None = None
    spacings: tuple[DeclaredLength, DeclaredLength] | None = None  # rows, columns
    row_spacing: DeclaredLength | None = None
    size: tuple[DeclaredLength, DeclaredLength] | None = None  # height, width
    height_range: DeclaredLength | None = None
    bare_spacing: tuple[float, ...] | None = None  # (Δx,) or (Δy, Δx)
    unclear_spacing: UnclearSpacing | None = None
    unit: str | None = None
    position_unit: str | None = None
    factor: float | None = None
    codes: tuple[float, ...] = ()
    counts: tuple[float, ...] = ()
    unapplied_factor_line: str = ""
    points: int | None = None
    tip_radius: DeclaredLength | None = None
    unit_line: str = ""
    slope_line: str = ""


@dataclass(frozen=True)
class HeightChannels:
    """Named channels of a scan file, each with its own heights."""

    names: tuple[str, ...]
    read: Callable[[int], RawHeights | ColumnTable]
    # Index of the channel that is read by default; None if the caller must choose a channel.
    default: int | None


ReaderResult = RawHeights | ColumnTable | HeightChannels


_COMPOSITE_UNIT_PATTERN = re.compile(
    r"(?:(1(?:\.0)?e[+-]?[0-9]{1,2}|10\^?[+-][0-9]{1,2}|0\.0*1|10+|1/10+)\s*[*·×]?\s*)?([^\W\d_]{1,3})(?:\s*/\s*(10+))?",
    re.IGNORECASE,
)
"""Regular expression for a unit with a power of ten, such as ``1e-3 mm``, ``10^-6 m`` or ``mm/1000``."""


def parse_length_unit(text: str) -> str | None:
    """Return the symbol of a unit of length, as in `LENGTH_UNITS`.

    Returns None if the text is no unit of length.

    A unit with a power of ten is accepted if it equals a named unit: ``mm/1000`` is µm, but ``0.1 um`` has no name.
    """
    if text in LENGTH_UNITS:
        return text
    match = _COMPOSITE_UNIT_PATTERN.fullmatch(text.strip())
    if match is not None and (match[1] or match[3]) and match[2] in LENGTH_UNITS:
        power = (match[1] or "1").lower().replace("^", "")
        power = re.sub(r"^10(?=[+-])", "1e", power)
        numerator, _, denominator = power.partition("/")
        value = float(numerator) / float(denominator or 1) / float(match[3] or 1) * LENGTH_UNITS[match[2]]
        return next((unit for unit in ("m", "mm", "um", "nm", "pm") if math.isclose(LENGTH_UNITS[unit], value)), None)
    # Normalisation replaces a unit sign such as ㎛ with separate characters.
    plain_text = unicodedata.normalize("NFKC", text)
    if plain_text in LENGTH_UNITS:
        return plain_text
    casefolded_text = plain_text.casefold()
    return casefolded_text if len(casefolded_text) > 3 and casefolded_text in LENGTH_UNITS else None


def check_point_count(points: int, stored_bytes: int) -> None:
    """Raise `FormatError` if a file declares more points than a file of this size can store, even with compression."""
    if points > max(MAX_POINTS_OF_SMALL_MAP, MAX_POINTS_PER_BYTE * stored_bytes):
        raise FormatError(f"declares {points} points, but has only {stored_bytes} bytes")


def parse_number(text: str, place: str) -> float:
    """Parse the finite number at the start of a text.

    Error messages describe the origin of the text by `place`. Raises `FormatError` if there is no such number.
    """
    match = _LEADING_NUMBER_PATTERN.match(text)
    try:
        value = float(match[1].replace(",", ".")) if match else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FormatError(f"has {text[:40]!r} {place}, not a number")
    return value


def parse_positive_number(text: str, place: str) -> float:
    """Parse a positive factor or length at the start of a text.

    Raises `FormatError` if the number is not positive, or is too small or too large for a scan. A negative factor would
    turn the heights upside down, and a factor of 0 would make them equal.
    """
    value = parse_number(text, place)
    if not MIN_DECLARED_NUMBER <= value <= MAX_DECLARED_NUMBER:
        raise FormatError(
            f"has {text[:40]!r} {place}; it must be a number from {MIN_DECLARED_NUMBER:g} to {MAX_DECLARED_NUMBER:g}"
        )
    return value


# ---- Archives -------------------------------------------------------------------------------------------------------


def read_member_chunks(archive: zipfile.ZipFile, name: str, max_bytes: int) -> Iterator[bytes]:
    """Yield the content of a file in a zip archive in pieces, which together have at most `max_bytes` bytes.

    The size that the archive declares is not trusted.
    """
    try:
        member_info = archive.getinfo(name)
    except KeyError:
        raise FormatError(f"lacks the archive member {name[:80]!r}, which should contain its data") from None
    if member_info.compress_type not in _COMPRESSION_METHODS:
        raise FormatError(f"contains the archive member {name[:80]!r}, whose compression method is not deflate")
    if member_info.file_size > max_bytes:
        raise FormatError(
            f"contains the archive member {name[:80]!r} of {member_info.file_size} bytes; "
            f"at most {max_bytes} can be read"
        )
    total_bytes = 0
    with archive.open(member_info) as member:
        while chunk := member.read(_ARCHIVE_CHUNK_SIZE):
            total_bytes += len(chunk)
            if total_bytes > max_bytes:
                raise FormatError(f"contains the archive member {name[:80]!r}, which exceeds {max_bytes} bytes")
            yield chunk
