"""Parsing of header lines that declare the spacing or the size of a scan.

A spacing is used only if its line contains nothing but a number with a unit of length, and perhaps the axis or the
points to which it applies. ``Pixel size: 0.5 µm`` is the spacing of a map, ``Pitch: 0.25 mm`` may be that of a grating,
and ``Spacing 2 mm between tracks`` is another length.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from stiction._patterns import LazyPattern
from stiction.surfaces.measured.raw import (
    LENGTH_UNITS,
    DeclaredLength,
    FormatError,
    UnclearSpacing,
    parse_length_unit,
    parse_number,
    parse_positive_number,
)

_T = TypeVar("_T")

DECIMAL_PATTERN = r"[+-]?[0-9]{1,20}(?:[.,][0-9]{1,20})?(?:[eE][+-]?[0-9]{1,5})?"
DECLARED_NUMBER_PATTERN = rf"(?:[+-]?(?:0x[0-9a-f]{{1,16}}|nan|inf(?:inity)?)(?![^\W_])|{DECIMAL_PATTERN})"
"""Regular expression for a number in a header line, including nan, infinity and hexadecimal numbers, which are rejected
later.
"""

SEPARATOR_PATTERN = r"\s*(?:[:=,;\t]|\s)\s*"
UNIT_PATTERN = r"[^\W\d_]{1,12}"
_LENGTH_UNITS_PATTERN = "|".join(map(re.escape, sorted(LENGTH_UNITS, key=len, reverse=True)))
_SPACE_BEFORE_UNIT_PATTERN = rf"(?:\s*[,;\t]\s*(?=(?:{_LENGTH_UNITS_PATTERN})[\s,;]*$)|\s*)"
"""Regular expression for the text between a number and its unit: blanks or, if the unit is the last cell of the line, a
cell separator.
"""

_BRACKETED_UNIT_PATTERN = r"\s*(?:[\[(]([^\])]{1,12})[\])])?"
_SPACING_WORDS = r"spacing|step(?:[ _-]?size)?|increment|interval|resolution|pixel[ _-]?size|pitch"
_SPACING_PATTERN = LazyPattern(
    r"\W*((?:(?:measurement|measuring|x|lateral|horizontal|sampl\w*|point|data|scan|pixel)[\s_-]*)*)"
    rf"({_SPACING_WORDS}|dx|Schrittweite|Punktabstand|Messpunktabstand|Abstand|Pixelgr(?:ö|oe)(?:ß|ss)e)"
    rf"{_BRACKETED_UNIT_PATTERN}\s*[:=,;\t ]\s*(?={DECLARED_NUMBER_PATTERN})(.*)",
    re.IGNORECASE,
)
_UNQUALIFIED_NAME_PATTERN = LazyPattern(r"(?:scan[\s_-]*)?(?:step|pitch|interval|abstand)", re.IGNORECASE)
"""Regular expression for names that may also denote other lengths, such as the pitch of a grating."""

# If a "sample spacing" exceeds this length (µm), it may be the distance between specimens.
MIN_SPECIMEN_DISTANCE = 100.0

_POINTS_REMARK_PATTERN = LazyPattern(
    r"\W*(?:nominal|mean|average|fast|along|in|lateral|horizontal|sampl\w*|points?|pixels?|px|x|axis|direction|\W)*",
    re.IGNORECASE,
)
"""Regular expression for a remark in brackets that denotes a distance of points along x, as in "spacing (sampling)"."""

_POINT_WORDS = r"px|pix|pixels?|points?|pts?|punkte?|samples?|steps?"
_LENGTH_PATTERN = (
    rf"({DECLARED_NUMBER_PATTERN}){_SPACE_BEFORE_UNIT_PATTERN}"
    rf"[\[(]?((?!(?:[xy]|by|and|und|in|along|per)\b){UNIT_PATTERN})?[\])]?\s*"
    r"(?:(?:/|per\b|pro\b)\s*([^\W\d_]{1,12}))?\s*"
    r"(?:\(?\s*(?:in |along )?\s*([xy])(?:[ -]?(?:axis|direction))?\s*\)?(?![^\W_]))?"
)
_LENGTHS_PATTERN = LazyPattern(
    rf"{_LENGTH_PATTERN}(?:\s*(?:[x×*,;\t/]|by\b|and\b|und\b|\s)\s*{_LENGTH_PATTERN})?"
    r"(?:\s*\((?![^)]*(?:track|line|row|profile|trace|\by\b))[^)]{1,40}\))?[\s,;\t.]*",
    re.IGNORECASE,
)
_ROW_SPACING_NAMES = r"(?:row|line|track|trace|profile)[\s_-]*(?:spacing|step|pitch|interval|distance)|Zeilenabstand|"
_AXIS_SPACING_PATTERNS = {
    axis: LazyPattern(
        rf"\W*(?:{axis}[\s_-]*(?:{_SPACING_WORDS}|scale|direction)|d{axis}|{other_names}"
        rf"(?:spacing|step|pitch|pixel[ _-]?size)[\s_-]*(?:in |along )?{axis})"
        rf"{_BRACKETED_UNIT_PATTERN}{SEPARATOR_PATTERN}({DECLARED_NUMBER_PATTERN}){_SPACE_BEFORE_UNIT_PATTERN}[\"']?"
        rf"({UNIT_PATTERN})?(?:\s*(?:/|per\b)\s*(?:{_POINT_WORDS})\b)?(?!\s*(?:/|per\b))",
        re.IGNORECASE,
    )
    for axis, other_names in (("y", _ROW_SPACING_NAMES), ("x", ""))
}
_NEXT_DECLARATION_PATTERN = LazyPattern(
    rf"[\s,;]+(?=(?:[xy][\s_-]*(?:{_SPACING_WORDS})|d[xy]|(?:spacing|step|pitch)[\s_-]*(?:in |along )?[xy])\s*[:=(\[])",
    re.IGNORECASE,
)
"""Regular expression for the text between two spacings in one line, as in "dx = 0.5 um, dy = 10 um"."""

_SURFACE_WRITER_SPACING_PATTERNS = tuple(
    LazyPattern(rf"# spacing along {axis}: ([0-9]{{1,20}}(?:\.[0-9]{{1,20}})?(?:e[+-]?[0-9]{{1,2}})?) (um)")
    for axis in "yx"
)
"""Regular expressions for the header lines with spacings that `write_surface` writes above a matrix."""

_SIZE_PATTERNS = tuple(
    LazyPattern(
        rf"\W{{0,4}}(?:{name}){_BRACKETED_UNIT_PATTERN}{SEPARATOR_PATTERN}({DECLARED_NUMBER_PATTERN})\s*({UNIT_PATTERN})?\s*",
        re.IGNORECASE,
    )
    for name in (
        "height|h[öo]he|hauteur|altezza|altura|výška|wysokość|высота|高さ|高度|높이|"
        "y[ _-]?(?:length|size|range|amplitude)|length y",
        "width|breite|largeur|larghezza|anchura|ancho|largura|šířka|szerokość|ширина|幅|宽度|너비|폭|"
        "x[ _-]?(?:length|size|range|amplitude)|length x",
    )
)
"""Regular expressions for header lines with the physical height and width of a matrix, as in files of Gwyddion."""


@dataclass(frozen=True)
class SpacingDeclarations:
    """Spacings and size of a scan that the header of a file declares."""

    spacing: DeclaredLength | None = None
    spacings: tuple[DeclaredLength, DeclaredLength] | None = None  # rows, columns
    size: tuple[DeclaredLength, DeclaredLength] | None = None  # height, width
    row_spacing: DeclaredLength | None = None
    bare_spacing: tuple[float, ...] | None = None
    unclear: UnclearSpacing | None = None


def parse_spacing_declarations(lines: Sequence[str]) -> SpacingDeclarations:
    """Parse the spacings and the size of a scan from header lines.

    Of several lines of the same kind, the first one counts.
    """
    lines = [part for line in lines for part in _NEXT_DECLARATION_PATTERN.split(line)]
    spacing: DeclaredLength | None = None
    pixel_sizes: tuple[DeclaredLength, DeclaredLength] | None = None
    bare_spacing: float | None = None
    unclear_spacing: UnclearSpacing | None = None
    for line in lines:
        declaration = _parse_spacing_line(line)
        if isinstance(declaration, UnclearSpacing):
            unclear_spacing = unclear_spacing or declaration
        elif isinstance(declaration, float):
            bare_spacing = declaration if bare_spacing is None else bare_spacing
        elif isinstance(declaration, tuple):
            spacing, pixel_sizes = spacing or declaration[1], pixel_sizes or declaration
        else:
            spacing = spacing or declaration
    axis_spacings = [find_first_match(_AXIS_SPACING_PATTERNS[axis], lines, parse_bracketed_length) for axis in "yx"]
    if axis_spacings[0] and pixel_sizes and not _are_lengths_equal(axis_spacings[0], pixel_sizes[0]):
        unclear_spacing = UnclearSpacing(axis_spacings[0].line.strip())
        spacing = pixel_sizes = None
    surface_writer_spacings = [
        find_first_match(pattern, lines, lambda match: parse_length(*match.groups(), line=match.string))
        for pattern in _SURFACE_WRITER_SPACING_PATTERNS
    ]
    bare_spacings = [find_first_match(_AXIS_SPACING_PATTERNS[axis], lines, _parse_unitless_number) for axis in "yx"]
    sizes = [find_first_match(pattern, lines, parse_bracketed_length) for pattern in _SIZE_PATTERNS]
    unitless_values = tuple(value for value in bare_spacings if value is not None)
    return SpacingDeclarations(
        spacing=spacing,
        spacings=_complete_pair_or_none(surface_writer_spacings)
        or _complete_pair_or_none(axis_spacings)
        or pixel_sizes
        or _complete_pair_or_none((axis_spacings[0], spacing)),
        row_spacing=axis_spacings[0],
        size=_complete_pair_or_none(sizes),
        bare_spacing=unitless_values or (None if bare_spacing is None else (bare_spacing,)),
        unclear=unclear_spacing,
    )


def is_spacing_declaration(line: str) -> bool:
    """Return whether a header line begins with the name of a spacing or size, and contains a number."""
    patterns = (_SPACING_PATTERN, *_AXIS_SPACING_PATTERNS.values(), *_SIZE_PATTERNS)
    return any(pattern.match(line) for pattern in patterns)


def _parse_spacing_line(
    line: str,
) -> DeclaredLength | tuple[DeclaredLength, DeclaredLength] | float | UnclearSpacing | None:
    """Parse a header line that begins with the name of a spacing.

    Returns None for any other line.

    Returns a spacing, a pair (Δy, Δx) if the line is about both axes, a number without unit, an `UnclearSpacing`, or
    None for a line about something else.
    """
    name_match = _SPACING_PATTERN.match(line)
    if name_match is None:
        return None
    qualifier, noun, bracketed_unit, text = name_match.groups()
    is_resolution, is_pixel = noun.casefold() == "resolution", "pixel" in (qualifier + noun).casefold()
    match = _LENGTHS_PATTERN.fullmatch(text.strip())
    if (
        bracketed_unit is not None
        and parse_length_unit(bracketed_unit) is None
        and not _POINTS_REMARK_PATTERN.fullmatch(bracketed_unit)
    ):
        # In a line such as "Scan spacing (slow axis): 0.3 um", the axis of the spacing is unknown.
        return UnclearSpacing(line.strip())
    if match is None:
        has_length = (length_match := re.match(_LENGTH_PATTERN, text, re.IGNORECASE)) and _parse_optional_unit(
            length_match[2] or bracketed_unit
        )
        return UnclearSpacing(line.strip()) if has_length and not is_resolution else None
    declared_numbers = [match.groups()[:4], match.groups()[4:]][: 2 if match[5] else 1]
    if any(
        "," in number_groups[0] and text.count(",") > len(declared_numbers) * 2 - 1
        for number_groups in declared_numbers
    ):
        # A comma in the line may separate two spacings, or may be a decimal mark.
        return UnclearSpacing(line.strip())
    if any(
        number_groups[2] and not re.fullmatch(f"{_POINT_WORDS}|lines?|rows?|columns?", number_groups[2], re.I)
        for number_groups in declared_numbers
    ):
        # The line may declare a height resolution in nm per bit instead of a length.
        return None
    if is_resolution and not any(number_groups[2] for number_groups in declared_numbers):
        # The line declares the resolution of the instrument instead of the spacing of the points.
        return None
    units = [number_groups[1] or declared_numbers[-1][1] or bracketed_unit for number_groups in declared_numbers]
    lengths = [
        parse_length(number_groups[0], unit, line=line)
        for number_groups, unit in zip(declared_numbers, units, strict=True)
    ]
    parsed_lengths = [length for length in lengths if length is not None]
    if len(parsed_lengths) < len(declared_numbers):
        return _parse_bare_number(declared_numbers[0][0]) if len(declared_numbers) == 1 and not any(units) else None
    axes = [
        (number_groups[3] or ("y" if re.match("line|row", number_groups[2] or "", re.I) else "")).casefold()
        for number_groups in declared_numbers
    ]
    if len(declared_numbers) == 2 and sorted(axes) == ["", "y"]:
        axes = [axis or "x" for axis in axes]
    if len(declared_numbers) == 2:
        if (
            parsed_lengths[0].length * LENGTH_UNITS[parsed_lengths[0].unit]
            == parsed_lengths[1].length * LENGTH_UNITS[parsed_lengths[1].unit]
        ):
            return parsed_lengths[1], parsed_lengths[0]
        if sorted(axes) == ["x", "y"]:
            return (parsed_lengths[0], parsed_lengths[1]) if axes[0] == "y" else (parsed_lengths[1], parsed_lengths[0])
        lengths_in_micrometres = tuple(length.length * LENGTH_UNITS[length.unit] for length in parsed_lengths)
        return UnclearSpacing(line.strip(), lengths_in_micrometres)
    if axes[0] == "y":
        return UnclearSpacing(line.strip())
    length_in_micrometres = parsed_lengths[0].length * LENGTH_UNITS[parsed_lengths[0].unit]
    is_of_specimens = re.match("sample(?!d|r)", qualifier, re.I) and length_in_micrometres >= MIN_SPECIMEN_DISTANCE
    if is_of_specimens or _UNQUALIFIED_NAME_PATTERN.fullmatch((qualifier + noun).strip()):
        return UnclearSpacing(line.strip(), (length_in_micrometres,))
    return (parsed_lengths[0], parsed_lengths[0]) if is_pixel and not axes[0] else parsed_lengths[0]


def _parse_optional_unit(unit: str | None) -> str | None:
    return None if unit is None else parse_length_unit(unit)


def find_first_match(
    pattern: LazyPattern, lines: Sequence[str], parse_match: Callable[[re.Match[str]], _T | None]
) -> _T | None:
    """Return the result of the first header line that starts with a pattern and can be parsed by `parse_match`.

    Returns None if no line can be parsed.
    """
    matches = (match for line in lines if (match := pattern.match(line)))
    return next((parsed for match in matches if (parsed := parse_match(match)) is not None), None)


def _are_lengths_equal(first: DeclaredLength, second: DeclaredLength) -> bool:
    return math.isclose(
        first.length * LENGTH_UNITS[first.unit], second.length * LENGTH_UNITS[second.unit], rel_tol=1e-3
    )


def _complete_pair_or_none(pair: Sequence[_T | None]) -> tuple[_T, _T] | None:
    along_y, along_x = pair
    return None if along_y is None or along_x is None else (along_y, along_x)


def parse_bracketed_length(match: re.Match[str]) -> DeclaredLength | None:
    """Parse a length in a header line; the unit follows the number or the name: "dx: 5 um" or "dx (um): 5"."""
    return parse_length(match[2], match[3] or match[1], line=match.string)


def _parse_unitless_number(match: re.Match[str]) -> float | None:
    return None if match[3] or match[1] else _parse_bare_number(match[2])


def _parse_bare_number(number: str) -> float | None:
    """Parse a spacing that a header line gives as a number without a unit.

    Returns None if the number is not a possible spacing.
    """
    try:
        return parse_positive_number(number, "as spacing")
    except FormatError:
        return None


def parse_length(digits: str, unit: str | None, *, line: str) -> DeclaredLength | None:
    """Parse a length with a unit in a header line.

    Returns None if the unit is not a unit of length.
    """
    if unit is None or parse_length_unit(unit) is None:
        return None
    try:
        length = parse_number(digits, f"in its header line {line[:80]!r}")
    except FormatError:
        # An invalid length causes an error only when it is used, because headers often contain unused lengths.
        return DeclaredLength(math.nan, 0.0, str(parse_length_unit(unit)), line)
    mantissa, _, exponent = digits.replace(",", ".").lower().partition("e")
    digit = float(f"1e{int(exponent or 0) - len(mantissa.partition('.')[2])}")
    return DeclaredLength(length, digit, str(parse_length_unit(unit)), line)
