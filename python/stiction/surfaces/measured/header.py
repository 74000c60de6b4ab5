"""Declarations in the header of a table: column names, units, spacings, sizes, factors and missing-point codes."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from stiction.surfaces.measured.raw import (
    LENGTH_UNITS,
    DeclaredLength,
    FormatError,
    HeaderDeclarations,
    parse_length_unit,
    parse_number,
    parse_positive_number,
)
from stiction.surfaces.measured.split import Dialect

_T = TypeVar("_T")
COMMENT_CHARACTERS = "#%!/ "  # characters at the start of comment lines in various programs

_DECIMAL_PATTERN = r"[+-]?[0-9]{1,20}(?:[.,][0-9]{1,20})?(?:[eE][+-]?[0-9]{1,5})?"
_DECLARED_NUMBER_PATTERN = rf"(?:[+-]?(?:0x[0-9a-f]{{1,16}}|nan|inf(?:inity)?)(?![^\W_])|{_DECIMAL_PATTERN})"
"""Pattern of a number, including numbers with which a declaration is rejected."""

_SEPARATOR_PATTERN = r"\s*(?:[:=,;\t]|\s)\s*"
_UNIT_PATTERN = r"[^\W\d_]{1,12}"
_LENGTH_UNITS_PATTERN = "|".join(map(re.escape, sorted(LENGTH_UNITS, key=len, reverse=True)))
_SPACE_BEFORE_UNIT_PATTERN = rf"(?:\s*[,;\t]\s*(?=(?:{_LENGTH_UNITS_PATTERN})[\s,;]*$)|\s*)"
"""Pattern of the space between a number and its unit, or of a separator before a cell with only a unit of length."""

_SPACING_PATTERN = re.compile(
    r"\W*(?:(?:measurement|x|lateral|horizontal|sampl\w*|point|data|scan)[\s_-]*)*"
    r"(spacing|step(?:[ _-]?size)?|increment|interval|resolution|pixel[ _-]?size|pitch|dx|"
    r"Schrittweite|Punktabstand|Messpunktabstand|Abstand)\s*(?:[\[(]([^\])]{1,12})[\])])?\s*[:=,;\t ]\s*"
    rf"({_DECLARED_NUMBER_PATTERN}){_SPACE_BEFORE_UNIT_PATTERN}({_UNIT_PATTERN})?\s*(/|per\b)?",
    re.IGNORECASE,
)
_AXIS_SPACING_PATTERNS = {
    axis: re.compile(
        rf"\W*(?:{axis}[\s_-]*(?:spacing|step(?:[ _-]?size)?|increment|interval|resolution|scale|pixel[ _-]?size|pitch|"
        rf"direction)|d{axis}|(?:spacing|step|pitch|pixel[ _-]?size)[\s_-]*(?:in |along )?{axis})"
        rf"\s*(?:[\[(]([^\])]{{1,12}})[\])])?{_SEPARATOR_PATTERN}({_DECLARED_NUMBER_PATTERN}){_SPACE_BEFORE_UNIT_PATTERN}[\"']?({_UNIT_PATTERN})?",
        re.IGNORECASE,
    )
    for axis in "yx"
}
_STICTION_SPACING_PATTERNS = tuple(
    re.compile(rf"# spacing along {axis}: ([0-9]{{1,20}}(?:\.[0-9]{{1,20}})?(?:e[+-]?[0-9]{{1,2}})?) (um)")
    for axis in "yx"
)
"""Patterns of the header lines with spacings that `write_surface` writes above a matrix."""

_SIZE_PATTERNS = tuple(
    re.compile(
        rf"\W{{0,4}}(?:{name})\s*(?:[\[(]([^\])]{{1,12}})[\])])?{_SEPARATOR_PATTERN}({_DECLARED_NUMBER_PATTERN})\s*({_UNIT_PATTERN})?\s*",
        re.IGNORECASE,
    )
    for name in (
        "height|h[öo]he|hauteur|altezza|altura|výška|wysokość|высота|高さ|高度|높이|"
        "y[ _-]?(?:length|size|range|amplitude)|length y",
        "width|breite|largeur|larghezza|anchura|ancho|largura|šířka|szerokość|ширина|幅|宽度|너비|폭|"
        "x[ _-]?(?:length|size|range|amplitude)|length x",
    )
)
"""Patterns of header lines with the physical height and width of a matrix, as in files of Gwyddion."""

_HEIGHT_UNIT_PATTERN = re.compile(
    r"\W*(?:(?:z|heights?|höhen?|hauteurs?|data|values?)\s+(?:are\s+)?in\s+|"
    r"(?:(?:z|data|height|value|amplitude|vertical|profile)[\s_-]*)?"
    r"(?:units?|einheit(?:en)?|unités?|unidad(?:es)?(?: de valor)?|unità(?: valore)?|jednotk[ay](?: hodnot)?|"
    r"単位|値の単位|单位|값 단위|단위|единицы измерения)"
    r"(?: (?:of )?(?:z|data|heights?|values?))?\s*[:=,;\t]\s*)[\"']?([^\s\"',;:]{1,20})[\"']?\W*",
    re.IGNORECASE,
)
_HEIGHT_FACTOR_PATTERN = re.compile(
    rf"\W*(?:(?:z|height|vertical|data|value)[\s_-]*)+(?:conversion[\s_-]*)?(?:factor|scale|scaling|multiplier)"
    rf"\s*(?:\(\s*-?>?\s*({_UNIT_PATTERN})\s*\)|[\[(]({_UNIT_PATTERN})[^\])]{{0,20}}[\])])?{_SEPARATOR_PATTERN}({_DECLARED_NUMBER_PATTERN})\s*({_UNIT_PATTERN})?\W*.{{0,20}}",
    re.IGNORECASE,
)
_CONVERSION_WORD_PATTERN = re.compile(r"factor|conversion|multiplier|->|\bper\b|/\s*(?:[^\W\d_]|1\b)", re.IGNORECASE)
"""Pattern of words that indicate a scale from numbers to heights. Without them, a scale is often a colour range."""

_MISSING_CODE_PATTERN = re.compile(
    rf"\W*(?:no[\s_-]?data|missing|void|invalid|bad|undefined|fill|null|mask(?:ed)?|fehl)[\s_-]*"
    rf"(?:data|points?|pixels?|height)?[\s_-]*(values?|code|wert)?{_SEPARATOR_PATTERN}({_DECIMAL_PATTERN})\W*",
    re.IGNORECASE,
)
_POINT_COUNT_PATTERN = re.compile(
    r"\W*(?:(?:number|no\.?|anzahl) (?:of |der )?(?:data[ _-]?)?(?:points|punkte)|num[ _-]?points|data[ _-]?size|"
    r"points|datenpunkte|messpunkte)" + _SEPARATOR_PATTERN + r"([0-9]{1,9})\W*",
    re.IGNORECASE,
)
_TIP_RADIUS_PATTERN = re.compile(
    rf"\W*(?:stylus|tip|probe)[\s,;:_-]*radius\s*(?:[\[(]({_UNIT_PATTERN})[\])])?{_SEPARATOR_PATTERN}({_DECIMAL_PATTERN})\s*({_UNIT_PATTERN})?\W*",
    re.IGNORECASE,
)
_HISTORY_PREFIX = "# history: "

NON_LENGTH_UNIT_PATTERN = re.compile(
    r"(?:[afpnuµμmcdhkMGT]|micror?|milli|nano|kilo)?[ -]?"
    r"(?:rad(?:ians?)?|V|A|N|s|Hz|Pa|K|C|W|J|g|F|T|volts?|amp(?:ere)?s?|newtons?|seconds?|sec|min|deg(?:rees?)?|°|°C|"
    r"counts?|cts|lsb|digits?|adu|dB|%|a\.?u\.?|arb\.?(?: ?units?)?|px|pixels?|pts?|points?|inch(?:es)?|in|mil|"
    r"1/0|0/1|bool|waves?|fringes?|lines?|1)(?:/[\w.°µ]+)?"
)
"""Units of quantities other than lengths, and ambiguous units of length."""

NON_HEIGHT_NAME_PATTERN = re.compile(
    r"\b(slopes?|steigung|pente|phase|current|strom|voltage|spannung|intensity|intensität|luminance|brightness|"
    r"deflection|friction|lateral force|force|kraft|time|zeit|curvature|krümmung|gradient|temperature)\b",
    re.IGNORECASE,
)
"""Pattern of the names of quantities that are not heights."""

_HEIGHT_NAME_PATTERN = re.compile(
    r"(?<![^\W_])(?:z|heights?|höhen?|hauteurs?|altezz[ae]|alturas?|topograph\w*|elevations?|amplitudes?)(?![^\W_])",
    re.I,
)
_POSITION_NAME_PATTERN = re.compile(
    r"(?<![^\W_])(?:[xy]+|xyz|positions?|coordinates?|lateral\w*|lengths?|all|spacings?|distances?|weg)(?![^\W_])", re.I
)
_BRACKETED_WORD_PATTERN = re.compile(r"[(\[{<]\s*([^()\[\]{}<>]{1,20}?)\s*[)\]}>]")
_VALUE_PATTERN = re.compile(r"(?:^|[\s,;:=])[+-]?[0-9][0-9.,]*(?:[eE][+-]?[0-9]+)?[^\W\d_]{0,3}(?=$|[\s,;:/])")


@dataclass(frozen=True)
class ColumnHeadings:
    """Column names and units in the header of a table, and the unit of the heights if the header names only heights."""

    names: tuple[str, ...] = ()
    units: tuple[str | None, ...] = ()
    height_unit: str | None = None  # unit of the heights, if a line mentions heights but no other quantity


def normalise_line(line: str) -> str:
    """Replace full-width characters and unit ligatures in a line by plain characters, and remove double quotes."""
    return unicodedata.normalize("NFKC", line).replace('"', "").replace("\u03bc", "µ")


def parse_declarations(header: Sequence[str], *, footer: Sequence[str] = ()) -> HeaderDeclarations:
    """Parse the declarations above and below the numbers. The first match of each kind is used."""
    lines = [normalise_line(line) for line in (*header, *footer)]
    pixel_size = _find_first_match(
        _SPACING_PATTERN,
        lines,
        lambda match: _parse_spacing(match) if match[1].casefold().startswith("pixel") else None,
    )
    spacings: tuple[DeclaredLength, DeclaredLength] | None = (
        _pair_if_complete(
            [
                _find_first_match(pattern, lines, lambda match: parse_length(*match.groups(), line=match.string))
                for pattern in _STICTION_SPACING_PATTERNS
            ]
        )
        or _pair_if_complete(
            [_find_first_match(_AXIS_SPACING_PATTERNS[axis], lines, _parse_bracketed_length) for axis in "yx"]
        )
        or _pair_if_complete([pixel_size, pixel_size])
    )
    bare_spacings: list[float | None] = [
        _find_first_match(_AXIS_SPACING_PATTERNS[axis], lines, _parse_unitless_number) for axis in "yx"
    ]
    plain_bare_spacing = _find_first_match(
        _SPACING_PATTERN, lines, lambda match: _parse_unitless_number(match) if not match[5] else None
    )
    unit_line = next(
        (line for line in lines if (match := _HEIGHT_UNIT_PATTERN.fullmatch(line)) and is_unit(match[1])), ""
    )
    factor_lines = [
        line for line in lines if (match := _HEIGHT_FACTOR_PATTERN.fullmatch(line)) and _parse_factor_unit(match)
    ]
    factor_line = next((line for line in factor_lines if _CONVERSION_WORD_PATTERN.search(line)), "")
    unit, factor = None, None
    if unit_line and (match := _HEIGHT_UNIT_PATTERN.fullmatch(unit_line)):
        unit = parse_length_unit(match[1]) or match[1]
    if factor_line and (match := _HEIGHT_FACTOR_PATTERN.fullmatch(factor_line)):
        unit = _parse_factor_unit(match)
        factor = parse_positive_number(match[3], f"in its header line {factor_line[:80]!r}")
    code_lines = [match for line in lines if (match := _MISSING_CODE_PATTERN.fullmatch(line))]
    codes = [parse_number(match[2], f"in its header line {match[0][:80]!r}") for match in code_lines]
    is_count = [
        match[1] is None and code.is_integer() and code >= 0 for match, code in zip(code_lines, codes, strict=True)
    ]
    point_count = next((int(match[1]) for line in lines if (match := _POINT_COUNT_PATTERN.fullmatch(line))), None)
    unitless_values = tuple(value for value in bare_spacings if value is not None)
    return HeaderDeclarations(
        spacing=_find_first_match(_SPACING_PATTERN, lines, _parse_spacing),
        spacings=spacings,
        size=_pair_if_complete(
            [_find_first_match(pattern, lines, _parse_bracketed_length) for pattern in _SIZE_PATTERNS]
        ),
        bare_spacing=unitless_values
        if unitless_values
        else None
        if plain_bare_spacing is None
        else (plain_bare_spacing,),
        unit=unit,
        factor=factor,
        codes=tuple(code for code, count in zip(codes, is_count, strict=True) if not count),
        counts=tuple(code for code, count in zip(codes, is_count, strict=True) if count),
        scale="" if factor_line else next(iter(factor_lines), "").strip(),
        points=point_count,
        tip_radius=_find_first_match(_TIP_RADIUS_PATTERN, lines, _parse_bracketed_length),
        line=factor_line or unit_line,
    )


def parse_history(header: Sequence[str]) -> list[str]:
    """Return the history entries that `write_profile` and `write_surface` write above the numbers."""
    return [line.removeprefix(_HISTORY_PREFIX) for line in header if line.startswith(_HISTORY_PREFIX)]


def _find_first_match(
    pattern: re.Pattern[str], lines: Sequence[str], parse_match: Callable[[re.Match[str]], _T | None]
) -> _T | None:
    matches = (match for line in lines if (match := pattern.match(line)))
    return next((value for match in matches if (value := parse_match(match)) is not None), None)


def _pair_if_complete(pair: Sequence[_T | None]) -> tuple[_T, _T] | None:
    first, second = pair
    return None if first is None or second is None else (first, second)


def _parse_spacing(match: re.Match[str]) -> DeclaredLength | None:
    """Parse a spacing. A resolution counts as a spacing only if it is a length per sample."""
    if match[1].casefold() == "resolution" and not match[5]:
        return None
    # The comma either separates two cells or is a decimal comma.
    if "," in match[3] and "," in match[0][match.end(3) - match.start() :]:
        return None
    return parse_length(match[3], match[4] or match[2], line=match.string)


def _parse_bracketed_length(match: re.Match[str]) -> DeclaredLength | None:
    """Parse a length whose unit follows the number, or follows the name in brackets."""
    return parse_length(match[2], match[3] or match[1], line=match.string)


def _parse_unitless_number(match: re.Match[str]) -> float | None:
    """Parse a spacing without a unit. Return None if no scan can have this spacing."""
    number, units = (match[3], (match[4], match[2])) if len(match.groups()) == 5 else (match[2], (match[3], match[1]))
    if any(units):
        return None
    try:
        return parse_positive_number(number, "as spacing")
    except FormatError:  # a header often contains unused entries
        return None


def parse_length(digits: str, unit: str | None, *, line: str) -> DeclaredLength | None:
    """Parse a number and its unit in a header line. Return None if the unit is not a unit of length."""
    if unit is None or parse_length_unit(unit) is None:
        return None
    try:
        length = parse_number(digits, f"in its header line {line[:80]!r}")
    except FormatError:  # raised when the length is used, because a header often contains unused entries
        return DeclaredLength(math.nan, 0.0, str(parse_length_unit(unit)), line)
    mantissa, _, exponent = digits.replace(",", ".").lower().partition("e")
    digit = float(f"1e{int(exponent or 0) - len(mantissa.partition('.')[2])}")
    return DeclaredLength(length, digit, str(parse_length_unit(unit)), line)


def _parse_factor_unit(match: re.Match[str]) -> str | None:
    unit = match[1] or match[2] or match[4]
    return parse_length_unit(unit) if unit else None


def _is_declaration(line: str) -> bool:
    """Return whether a header line is a declaration, as opposed to a line of column names."""
    full_patterns = (_HEIGHT_UNIT_PATTERN, _HEIGHT_FACTOR_PATTERN, _MISSING_CODE_PATTERN, _POINT_COUNT_PATTERN)
    prefix_patterns = (_SPACING_PATTERN, *_AXIS_SPACING_PATTERNS.values(), *_SIZE_PATTERNS)
    return any(pattern.fullmatch(line) for pattern in full_patterns) or any(
        pattern.match(line) for pattern in prefix_patterns
    )


def _find_last_line_with_letters(lines: Sequence[str]) -> str | None:
    """Return the last line that contains letters, without comment characters at its start."""
    return next((line.lstrip(COMMENT_CHARACTERS) for line in reversed(lines) if any(map(str.isalpha, line))), None)


def _mentions_only_heights(line: str) -> bool:
    """Return whether a header line names heights with their unit, but neither positions nor other lengths."""
    return bool(
        len(_find_units(line)) == 1
        and not _has_number_outside_brackets(line)
        and _HEIGHT_NAME_PATTERN.search(line)
        and not _POSITION_NAME_PATTERN.search(line)
    )


def _find_units(line: str) -> list[str]:
    """Return the units in a line.

    Units in brackets are returned or, if there are none, units that are separate words.
    """
    bracketed_units = [word for word in _BRACKETED_WORD_PATTERN.findall(line) if is_unit(word)]
    units = [parse_length_unit(word.strip(" \"'.:")) or word for word in bracketed_units]
    return units or [unit for word in re.split(r"[\s,;]+", line) if (unit := parse_length_unit(word.strip(" \"'.:")))]


def _has_number_outside_brackets(line: str) -> bool:
    """Return whether a header line has a number outside brackets, as in "Length (um): 1500".

    Such a line does not name columns.
    """
    return _VALUE_PATTERN.search(_BRACKETED_WORD_PATTERN.sub(" ", line)) is not None


def is_unit(word: str) -> bool:
    """Return whether a word is a unit, either of length or of another quantity."""
    return parse_length_unit(word) is not None or NON_LENGTH_UNIT_PATTERN.fullmatch(word) is not None


# ---- Column names ---------------------------------------------------------------------------------------------------


def parse_column_headings(header: Sequence[str], width: int, dialect: Dialect) -> ColumnHeadings:
    """Parse the names and units of `width` columns from the lines above them."""
    lines = [line for line in map(normalise_line, header) if not _is_declaration(line)]
    if not lines:
        return ColumnHeadings()
    names, units = _parse_column_names(lines, width, dialect), _parse_column_units(lines, width, dialect)
    name_line = _find_last_line_with_letters(lines)
    is_of_heights = width > 2 and not any(units) and name_line is not None and _mentions_only_heights(name_line)
    return ColumnHeadings(names, units, _find_units(name_line)[0] if is_of_heights and name_line is not None else None)


def split_column_names(line: str, width: int, dialect: Dialect) -> list[str] | None:
    """Split a line of column names into `width` cells. Its separator may differ from the separator of the numbers."""
    uncommented_line = line.lstrip(COMMENT_CHARACTERS) if line.lstrip(" ")[:1] in tuple("#%!/") else line
    candidates = [
        dialect.split_line(uncommented_line),
        *(uncommented_line.split(separator) for separator in "\t;,|"),
        re.split(r"\s{2,}", uncommented_line.strip()),
    ]
    for cells in candidates:
        cells = [cell.strip(" \"'") for cell in cells]
        while len(cells) > width and not cells[-1]:
            cells.pop()
        if len(cells) == width:
            return cells
        if len(cells) == width - 1 and line[:1] in "\t;, ":  # the heading of the column of row numbers may be missing
            return ["", *cells]
    return None


def _parse_column_names(lines: Sequence[str], width: int, dialect: Dialect) -> tuple[str, ...]:
    if width == 1:
        return ()
    names = split_column_names(lines[-1], width, dialect)
    if names is None:
        return ()
    if len(lines) > 1 and all(is_unit(cell.strip("[]() ")) or not cell for cell in names):
        previous_names = split_column_names(lines[-2], width, dialect)
        if previous_names is not None:
            return tuple(
                f"{name} [{unit.strip('[]() ')}]" if unit else name
                for name, unit in zip(previous_names, names, strict=True)
            )
    return tuple(names)


def _parse_column_units(lines: Sequence[str], width: int, dialect: Dialect) -> tuple[str | None, ...]:
    """Return the unit of each column from the line of names above the data."""
    name_line = _find_last_line_with_letters(lines)
    if name_line is None or _has_number_outside_brackets(name_line):
        return (None,) * width
    cells = split_column_names(name_line, width, dialect) if width > 1 else None
    if cells is not None and any(unit_in_column_name(cell) for cell in cells):
        return tuple(unit_in_column_name(cell) for cell in cells)
    units = _find_units(name_line)
    if len(units) == width:
        return tuple(units)
    is_for_all = width > 2 and len(units) == 1 and not _mentions_only_heights(name_line)
    return (units[0] if is_for_all else None,) * width


def unit_in_column_name(cell: str) -> str | None:
    """Return the unit at the end of a column name, as in "z (nm)", "z [nm]", "z/nm", "height in nm" and "z nm"."""
    bracketed_texts = _BRACKETED_WORD_PATTERN.findall(cell)
    last = bracketed_texts[-1].strip() if bracketed_texts else cell.strip(" \"'")
    # a column with another unit is rejected later, but only if it is used as heights
    if NON_LENGTH_UNIT_PATTERN.fullmatch(last):
        return last
    return parse_length_unit((last if bracketed_texts else re.split(r"[\s/_]+", last)[-1]).strip(" \"'.:"))
