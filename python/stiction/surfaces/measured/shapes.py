"""Selection of height columns in a table, by the user's choice or by the table's shape (second reading step)."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._patterns import LazyPattern
from stiction._text import printable_text
from stiction.surfaces.measured.grid import to_grid
from stiction.surfaces.measured.header import (
    NON_HEIGHT_NAME_PATTERN,
    find_other_axis,
    is_computed_height,
    is_length_axis,
    is_unit,
    unit_in_column_name,
)
from stiction.surfaces.measured.matrix_checks import (
    find_wrapped_profile_caveat,
    reject_coordinates_listed_before_heights,
    reject_points_and_statistics,
    reject_separate_blocks,
)
from stiction.surfaces.measured.raw import (
    LENGTH_UNITS,
    ColumnTable,
    DeclaredLength,
    FileCaveat,
    FormatError,
    HeightChannels,
    RawHeights,
    ReaderResult,
    parse_length_unit,
)

MAX_STEP_UNEVENNESS = 1e-3
"""Largest accepted deviation of a point from a uniform grid, as a fraction of the spacing.

Positions stored in single precision have such deviations, which have no visible effect on the heights.
"""

MIN_MATRIX_COLUMNS = 4
MAX_TABLE_GRID_POINTS = 100_000_000
MAX_LISTED_COLUMN_NAMES = 12
MAX_SELECTED_PROFILE_COLUMNS = 3  # x, y and z
MIN_JITTERED_POSITIONS = 8
MAX_RELATIVE_STEP_DEVIATION = 0.5
MIN_TILT_CORRELATION = 0.98
# A column's first number gets a caveat if it has at least two decimals fewer than each of this many next numbers.
MIN_NUMBERS_AFTER_FIRST_NUMBER = 20
# Minimum step of evenly spaced numbers, in units of the last digit. Smaller rounded steps may be equal by chance.
MIN_STEP_IN_LAST_DIGITS = 3.0
NameOrIndex = str | int

_INDEX_COLUMN_NAME_PATTERN = LazyPattern(
    r"|index|idx|unnamed: ?0|(?:lfd\.? ?)?(?:no\.?|nr\.?|number|num|nummer|n[úu]mero|n°)|#|n|i|id|seq|"
    r"(?:data ?)?points?|pt\.?|番号|序号|번호|номер|"
    r"(?:mess)?punkt\w*|"
    r"zeile|line|row|dataline|trace|samples?|frames?|pixels?|px|counter|"
    r"(?:points?|samples?|punkt|pos(?:ition)?)[ _-]?(?:no|nr|number|index)\.?",
    re.IGNORECASE,
)
_VALIDITY_COLUMN_PATTERN = LazyPattern(r"\W*(?:valid\w*|gültig\w*|is[ _]?valid|ok|1/0)\b.*|.*[\[(]1/0[\])]", re.I)
_INVALIDITY_COLUMN_PATTERN = LazyPattern(r"\W*(?:invalid\w*|ungültig\w*|is[ _]?invalid)\b.*", re.I)
# This pattern matches names of flag columns that do not say whether 1 means valid or invalid.
_AMBIGUOUS_FLAG_COLUMN_PATTERN = LazyPattern(r"\W*(?:flags?|status|0/1)\b.*|.*[\[(]0/1[\])]", re.I)
# This pattern matches a multiple of a unit, such as "10 nm" but not "1 nm".
_NUMBERED_UNIT_PATTERN = LazyPattern(r"(?!1(?:[.,]0*)?\s*[^\W\d_]+$)(?=.*[0-9]).+")
_RAW_HEIGHTS_PATTERN = LazyPattern(r"\W*(?:z|heights?|höhe\w*|profile?|topography)(?:[ _-]?a\w+)?[\W_]*raw\W*", re.I)
_X_COLUMN_PATTERN, _Y_COLUMN_PATTERN = (
    LazyPattern(rf"\W*{axis}(?![a-z0-9]).*|.*\b{axis}[\s_-]*(?:pos|coord).*", re.I) for axis in "xy"
)
_HEIGHT_COLUMN_PATTERN = LazyPattern(r"\W*(?:z(?![a-z0-9])|height|höhe|hauteur|altezza|altura|topo).*", re.I)


def select_heights(
    content: ReaderResult, channel: NameOrIndex | None, columns: Sequence[NameOrIndex] | None
) -> RawHeights:
    """Return the heights in the channel or columns that the caller selects.

    Without a selection, the shape of the table determines the columns of heights.
    """
    if isinstance(content, HeightChannels):
        index = _find_channel_index(content, channel)
        raw = select_heights(content.read(index), None, columns)
        if len(content.names) == 1:
            return raw
        name = printable_text(content.names[index])
        history_entry = f"channel {index} ({name}) of {format_name_list(content.names)}"
        column = f"{name}, {raw.source.column}" if raw.source.column not in ("", name) else name
        return replace(raw, history=(history_entry, *raw.history), source=replace(raw.source, column=column))
    if channel is not None:
        raise FormatError(f"has no channels, but channel {channel!r} was selected")
    if isinstance(content, ColumnTable):
        table = _apply_flag_column(_replace_words_by_missing(content, columns), columns)
        raw = _select_heights(table, columns) if columns is not None else _read_by_layout(table)
        return replace(raw, history=(*table.history, *raw.history), caveats=(*table.caveats, *raw.caveats))
    if columns is not None:
        raise FormatError("has no columns, but columns were selected")
    return content


def _find_channel_index(channels: HeightChannels, selected: NameOrIndex | None) -> int:
    if selected is not None:
        return _find_column_or_channel_index(channels.names, selected, range(len(channels.names)), "channel")
    if channels.default is None:
        raise FormatError(
            f"contains the channels {format_name_list(channels.names)}; choose one with the option channel (--channel)"
        )
    return channels.default


def _find_column_or_channel_index(
    names: Sequence[str], selected: NameOrIndex, numbers: Sequence[int], kind: str
) -> int:
    """Return the index of the column or channel that the caller selects by name or number."""
    text = str(selected).strip()
    normalising_functions: list[Callable[[str], str]] = [lambda name: name, lambda name: name.casefold()]
    # Parentheses may contain a remark instead of a unit, as in "Height (trace)".
    if "(" not in text or is_unit(unit_in_column_name(text) or ""):
        normalising_functions.append(_remove_unit_from_name)
    for normaliser in normalising_functions:
        matches = [index for index, name in enumerate(names) if normaliser(name.strip()) == normaliser(text) and text]
        if len(matches) > 1:
            raise FormatError(
                f"has more than one {kind} named {text!r}; choose by number: {format_name_list(names, numbers)}"
            )
        if matches:
            return matches[0]
    if text.isascii() and text.isdigit() and len(text) < 10:
        if int(text) in numbers:
            return numbers.index(int(text))
        allowed_numbers = f"0 to {numbers[-1]}" if len(numbers) > numbers[-1] else ", ".join(map(str, numbers))
        raise FormatError(f"has no {kind} {text}; the {kind} numbers are {allowed_numbers}")
    raise FormatError(
        f"has no {kind} named {text[:40]!r}; the file has "
        f"{format_name_list(names, numbers) if names else f'{len(numbers)}, all without names'}"
    )


def _remove_unit_from_name(name: str) -> str:
    """Remove the unit from a column name."""
    return re.sub(r"\s*[(\[{<].{0,40}$|\s*/\s*\S{0,12}$", "", name).casefold()


def format_name_list(names: Sequence[str], numbers: Sequence[int] | None = None) -> str:
    """Format the first few names of columns or channels, each with its number, for an error message."""
    numbers = range(len(names)) if numbers is None else numbers
    numbered_names = list(zip(numbers, names, strict=True))
    shown_names = ", ".join(
        f"{index} ({printable_text(name)})" for index, name in numbered_names[:MAX_LISTED_COLUMN_NAMES]
    )
    return (
        f"{shown_names} and {len(names) - MAX_LISTED_COLUMN_NAMES} more"
        if len(names) > MAX_LISTED_COLUMN_NAMES
        else shown_names
    )


# ---- Columns --------------------------------------------------------------------------------------------------------


def _list_column_numbers(table: ColumnTable) -> Sequence[int]:
    return range(table.values.shape[1]) if table.places is None else table.places


def _select_heights(table: ColumnTable, selected: Sequence[NameOrIndex]) -> RawHeights:
    """Return the heights in one to three selected columns of a table: (z), (positions, z) or (x, y, z)."""
    numbers = _list_column_numbers(table)
    indices = [_find_column_or_channel_index(table.names, item, numbers, "column") for item in selected]
    description = ", ".join(
        f"{numbers[index]} ({printable_text(table.names[index])})" if table.names else str(numbers[index])
        for index in indices
    )
    history_entry = f"column {description}" if len(indices) == 1 else f"columns {description}"
    raw = (
        _read_xyz_table(table, *indices)
        if len(indices) == 3
        else _read_profile_columns(table, *indices[-2:], is_chosen=True)
    )
    return replace(raw, history=(history_entry, *raw.history))


def _to_raw_heights(table: ColumnTable, heights: Floats, unit: str | None, **attributes: Any) -> RawHeights:
    """Create `RawHeights` from heights, with the units, factors and missing-point codes that the table declares."""
    declared = table.declared
    # A declared integer that exceeds the number of heights is not a count of missing points.
    counts = tuple(count for count in declared.counts if count > heights.size)
    caveats: tuple[FileCaveat, ...] = ()
    if declared.unapplied_factor_line:
        text = (
            f"its header line {printable_text(declared.unapplied_factor_line)!r} is a factor or a range of heights; it "
            "is not applied"
        )
        remedy = "accept it if the heights are in their unit; otherwise multiply them by the factor first"
        caveats = (FileCaveat("scale", text, remedy),)
    caveats += _find_contradicting_unit_caveat(table, unit)
    raw = RawHeights(
        heights, unit=unit, factor=declared.factor, codes=(*declared.codes, *counts), declared_spacing=declared.spacing,
        size=declared.size, bare_spacing=declared.bare_spacing, source=table.source, caveats=caveats,
        declared_spacings=declared.spacings, unclear_spacing=declared.unclear_spacing,
        height_range=declared.height_range,
    )  # fmt: skip
    raw = replace(raw, **attributes)
    if (
        raw.unit is None
        and (declared.height_range is not None)
        and _has_height_range(raw.heights, declared.height_range)
    ):
        raw = replace(raw, unit=declared.height_range.unit)
    if (tip_radius := declared.tip_radius) is None or not tip_radius.length > 0:
        return raw
    return replace(
        raw, history=(*raw.history, f"its header gives a tip radius of {tip_radius.length:g} {tip_radius.unit} (--tip)")
    )


def _find_contradicting_unit_caveat(table: ColumnTable, unit: str | None) -> tuple[FileCaveat, ...]:
    """Return a caveat if header and column name declare different height units, such as "nm" and "0.1 um"."""
    declared = table.declared
    if declared.factor is not None or declared.unit is None or unit not in LENGTH_UNITS:
        return ()
    has_different_units = (
        LENGTH_UNITS[declared.unit] != LENGTH_UNITS[unit]
        if declared.unit in LENGTH_UNITS
        else not declared.unapplied_factor_line and _NUMBERED_UNIT_PATTERN.fullmatch(declared.unit) is not None
    )
    if not has_different_units:
        return ()
    text = f"its header line {printable_text(declared.unit_line)!r} contradicts the unit of its column, {unit}"
    return (FileCaveat("scale", text, "accept it if the column is right"),)


def _has_height_range(heights: Floats, declared: DeclaredLength) -> bool:
    """Return whether the highest minus the lowest height equals the range of heights that the header declares.

    The result is false if the declared range has fewer than three significant digits.
    """
    height_range = float(np.fmax.reduce(heights, axis=None) - np.fmin.reduce(heights, axis=None))
    return abs(height_range - declared.length) <= 0.51 * declared.digit and declared.digit <= 1e-2 * declared.length


def _choose_common_unit(table: ColumnTable, units: Sequence[str | None]) -> str | None:
    """Return the unit of several columns of heights: their common unit, or the unit that the header declares."""
    unit = units[0] if len(set(units)) == 1 else None
    declared = table.declared
    return declared.unit if declared.unit is not None and (unit is None or declared.factor is not None) else unit


def _read_profile_columns(table: ColumnTable, *places: int, is_chosen: bool = False) -> RawHeights:
    """Read a profile from one column of heights, or from a column of positions and a column of heights.

    Rows in which the position or the height is not a number are left out.
    """
    heights, declared = table.values[:, places[-1]], table.declared
    if declared.slope_line and not (table.names and _HEIGHT_COLUMN_PATTERN.match(table.names[places[-1]])):
        raise FormatError(
            f"contains slopes, not heights, according to its line {printable_text(declared.slope_line)!r}; integrate "
            "them to heights first"
        )
    layout = "heights, a column" if len(places) == 1 else "positions and heights"
    raw = _to_raw_heights(
        table, heights, _find_height_unit(table, places[-1]),
        source=replace(table.source, layout=table.source.layout or layout, column=_describe_column(table, places[-1])),
        declared_spacing=declared.spacing or (None if declared.spacings is None else declared.spacings[1]), size=None,
        bare_spacing=None if declared.bare_spacing is None else declared.bare_spacing[-1:],
    )  # fmt: skip
    raw = replace(raw, caveats=(*raw.caveats, *_find_calculated_column_caveat(table, places[-1])))
    if len(places) == 1:
        filled_rows = np.flatnonzero(~np.isnan(heights))
        end = int(filled_rows[-1]) + 1 if filled_rows.size and table.values.shape[1] > 1 else heights.size
        if table.values.shape[1] == 1:
            _reject_positions_above_heights(heights)
        heights, history = _remove_leading_count(heights[:end], table.values.shape[1])
        first_block = int(bool(history) and table.block_lengths[:1] == (1,))
        reject_separate_blocks(table.block_lengths[first_block:], table.block_lines[first_block:])
        caveats = () if history else _find_first_number_caveat(table)
        if table.declared.points not in (None, heights.size):
            text = f"its header declares {table.declared.points} points, but {heights.size} heights are read"
            caveats += (FileCaveat("points", text, "remove what is not a height, or accept it"),)
        return replace(raw, heights=heights, history=history, caveats=(*raw.caveats, *caveats))
    positions = table.values[:, places[0]]
    name = table.names[places[0]] if table.names else ""
    if (quantity := find_other_axis(name, _list_column_units(table)[places[0]])) is not None:
        raise FormatError(
            f"has positions in a column named {printable_text(name)!r}, but {quantity} is not a length; choose "
            f"only the heights (--columns {_list_column_numbers(table)[places[-1]]}) and give their spacing (--spacing)"
        )
    # If two tables stand side by side in a file, the rows below the shorter table are empty.
    is_empty = np.isnan(positions) & np.isnan(heights)
    end = heights.size - int(np.argmin(is_empty[::-1])) if not is_empty.all() else heights.size
    digits = table.last_digit_value_function(places[0])
    return replace(
        raw, heights=heights[:end], positions=positions[:end],
        position_unit=_list_column_units(table)[places[0]] or declared.position_unit,
        digits=None if digits is None else lambda: digits()[:end],
        caveats=(*raw.caveats, *_find_position_caveat(table, positions[:end], places, is_chosen)),
    )  # fmt: skip


def _list_column_units(table: ColumnTable) -> tuple[str | None, ...]:
    return table.units or (None,) * table.values.shape[1]


def _describe_column(table: ColumnTable, place: int) -> str:
    number = _list_column_numbers(table)[place]
    name = f" ({printable_text(table.names[place])})" if table.names and table.names[place] else ""
    return f"column {number}{name}"


def _find_height_unit(table: ColumnTable, place: int) -> str | None:
    """Return the unit of a column of heights.

    Returns None if the unit is unknown.

    Raises `FormatError` if the column name denotes another quantity.
    """
    unit = _list_column_units(table)[place]
    if unit is not None and parse_length_unit(unit) is None:
        return unit
    name = table.names[place] if table.names else ""
    if (match := NON_HEIGHT_NAME_PATTERN.search(name)) is not None:
        raise FormatError(
            f"has a column named {printable_text(name)!r}, but {match[0].lower()} is not a height; "
            "choose another column (--columns)"
        )
    return unit if unit is not None and table.declared.factor is None else table.declared.unit or unit


def _reject_positions_above_heights(column: Floats) -> None:
    """Raise `FormatError` if a column of numbers lists all positions first, and all heights afterwards."""
    reject_coordinates_listed_before_heights(column)
    positions, heights = column[: column.size // 2], column[column.size // 2 :]
    is_divisible = positions.size == heights.size >= MIN_JITTERED_POSITIONS
    if is_divisible and has_equal_steps(positions) and not has_equal_steps(heights):
        raise FormatError("lists all x and then all z; write x and z in columns, one point per line")


def _remove_leading_count(heights: Floats, width: int) -> tuple[Floats, tuple[str, ...]]:
    """Remove the first number of a column if it states how many heights follow.

    Returns the heights and, if a number was removed, a history entry.
    """
    for place in range(min(3, heights.size - 4) if width == 1 else 0):
        # Up to three numbers at the start of a column of heights may be counts or sizes.
        for leading_number_count in range(place + 1, 4):
            if heights[place] != heights.size - leading_number_count:
                continue
            if leading_number_count == 1:
                return heights[1:], (f"first number removed, {heights[0]:.0f}, which is the count of the others",)
            # If all heights are whole numbers, only a number directly above the heights may be their count.
            if leading_number_count == place + 1 or (heights[leading_number_count:] % 1 != 0).any():
                raise FormatError(
                    f"begins with {leading_number_count} numbers that are not heights: {heights[place]:.0f} is the "
                    f"number of heights below; delete the first {leading_number_count} numbers"
                )
    if width == 1 and heights.size > 6 and heights[0] * heights[1] == heights.size - 2 and min(heights[:2]) > 1:
        raise FormatError(
            f"begins with the size of a map, {heights[0]:.0f} and {heights[1]:.0f}, and lists one height per line; "
            "write one row of the map per line"
        )
    return heights, ()


def _find_first_number_caveat(table: ColumnTable) -> tuple[FileCaveat, ...]:
    """Return a caveat if the first number of a column, or one of its last three, is probably not a height.

    The first number may be the spacing or the size of the scan, and one of the last three may be the count of points.
    """
    if (
        table.values.shape != (table.values.size, 1)
        or table.values.size < MIN_NUMBERS_AFTER_FIRST_NUMBER + 1
        or table.row_digits is None
    ):
        return ()
    # A spacing or a size may precede or follow the count of points.
    for num_trailing in (1, 2, 3):
        heights, trailing_numbers = table.values[:-num_trailing, 0], table.values[-num_trailing:, 0]
        if heights.size in trailing_numbers and (heights % 1 != 0).any():
            place_text = "the last number" if num_trailing == 1 else f"one of the last {num_trailing} numbers"
            text = f"{place_text}, {heights.size}, is the count of the others"
            return (FileCaveat("first-number", text, "delete it if it is a count instead of a height, or accept it"),)
    first_digit_value, *following_digit_values = (
        float(table.row_digits(index)[0]) for index in range(MIN_NUMBERS_AFTER_FIRST_NUMBER + 1)
    )
    if len(set(following_digit_values)) > 1 or not first_digit_value > 50 * following_digit_values[0]:
        return ()
    text = f"the first number, {table.values[0, 0]:g}, has fewer decimals than all others"
    return (FileCaveat("first-number", text, "delete it if it is a step or a size instead of a height, or accept it"),)


def _find_calculated_column_caveat(table: ColumnTable, place: int) -> tuple[FileCaveat, ...]:
    """Return a caveat if a column's name suggests a calculation, such as "z x 1000", or the counts of a converter."""
    name = table.names[place] if table.names else ""
    is_raw = _RAW_HEIGHTS_PATTERN.fullmatch(name) is not None and _list_column_units(table)[place] is None
    if is_raw and table.declared.unit is None:
        text = f"its column {printable_text(name)!r} may contain counts of a converter instead of heights"
        return (FileCaveat("scale", text, "accept it if the column contains heights in their unit"),)
    if table.declared.unapplied_factor_line or not is_computed_height(name):
        return ()
    text = f"its column {printable_text(name)!r} may contain multiples or functions of the heights"
    return (FileCaveat("scale", text, "accept it if the column contains heights in their unit"),)


def _find_position_caveat(
    table: ColumnTable, positions: Floats, places: Sequence[int], is_chosen: bool
) -> tuple[FileCaveat, ...]:
    """Return a caveat if a column used as positions may contain point numbers or another quantity."""
    if caveats := _find_numbering_caveat(table, positions, places[0]):
        return caveats
    name = table.names[places[0]] if table.names else ""
    has_unit = _list_column_units(table)[places[0]] is not None or table.declared.position_unit is not None
    if is_chosen or has_unit or not any(table.names) or is_length_axis(name):
        return ()
    numbers = _list_column_numbers(table)
    column = f"column {numbers[places[0]]}" + (f" ({printable_text(name)})" if name else "")
    return (
        FileCaveat(
            "positions",
            f"{column} is used as positions, but its name has no unit and may denote another quantity",
            f"choose it by --columns {numbers[places[0]]},{numbers[places[-1]]} if it contains positions; otherwise "
            f"choose only the heights (--columns {numbers[places[-1]]}) and give --spacing",
        ),
    )


def _find_numbering_caveat(table: ColumnTable, positions: Floats, place: int) -> tuple[FileCaveat, ...]:
    """Return a caveat if a column used as positions may contain point numbers."""
    name = table.names[place] if table.names else ""
    if _list_column_units(table)[place] is not None or (
        name and not _INDEX_COLUMN_NAME_PATTERN.fullmatch(name.strip())
    ):
        return ()
    if positions.size < 4 or not np.isfinite(positions).all():
        return ()
    first_position, second_position, third_position = positions[:3].tolist()
    step = second_position - first_position
    counts_points = step == 1 and first_position in (0, 1)
    counts_by_name = bool(name) and step.is_integer() and first_position.is_integer()
    if not (counts_points or counts_by_name) or not np.array_equal(
        positions, first_position + step * np.arange(positions.size)
    ):
        return ()
    number = _list_column_numbers(table)[place]
    return (
        FileCaveat(
            "numbering",
            f"column {number} counts {first_position:.0f}, {second_position:.0f}, {third_position:.0f}, ... and is "
            "used as positions",
            "if it numbers the points, choose the height column by --columns and give --spacing",
        ),
    )


def _replace_words_by_missing(table: ColumnTable, columns: Sequence[NameOrIndex] | None) -> ColumnTable:
    """Remove columns of words from a table, and set heights to NaN in each row where a word marks a missing point.

    If all words of a column are one unit of length, this is the unit of the column before it. Raises `FormatError` for
    a column that has neither a unit nor one of the caller's words for missing points, unless the caller chose the
    columns.
    """
    word_places, numbers = [column.place for column in table.word_columns], _list_column_numbers(table)
    other_places = [place for place in range(table.values.shape[1]) if place not in word_places]
    for column in table.word_columns:
        name = f" ({printable_text(table.names[column.place])})" if table.names and table.names[column.place] else ""
        text = f"column {numbers[column.place]}{name}"
        units, place_before = list(_list_column_units(table)), column.place - 1
        if len(column.units) > 1:
            raise FormatError(f"has numbers in several units in {text}: {column.words}; convert them to one unit")
        if column.units and place_before in other_places and units[place_before] is None:
            units[place_before] = column.units[0]
            table = replace(table, units=tuple(units))
            history_entry = f"unit of column {numbers[place_before]} from the words in {text}"
        elif column.missing.any():
            history_entry = f"{int(column.missing.sum())} points missing according to the words in {text}"
            table = replace(table, values=_fill_missing_rows_with_nan(table.values, column.missing, other_places))
        elif columns is None:
            chosen_columns = [
                numbers[place]
                for place in other_places
                if not (table.names and _INDEX_COLUMN_NAME_PATTERN.fullmatch(table.names[place]))
            ]
            example = ",".join(map(str, chosen_columns[:MAX_SELECTED_PROFILE_COLUMNS]))
            raise FormatError(
                f"has words in {text}: {column.words}; select columns of numbers with the option columns "
                f"(--columns {example}) to ignore the words, or specify the word for missing points with missing_value "
                f"(--missing-value {shlex.quote(column.rarest_word)})"
            )
        else:
            history_entry = f"the words in {text} are ignored"
        table = replace(table, history=(*table.history, history_entry))
    return replace(_select_table_columns(table, other_places), word_columns=()) if word_places else table


def _fill_missing_rows_with_nan(values: Floats, missing: NDArray[np.bool_], places: Sequence[int]) -> Floats:
    """Return the numbers of a table, with NaN in rows that stand for missing points.

    Columns of positions are not changed.
    """
    masked_values = np.where(missing[:, np.newaxis], np.nan, values)
    for place in places:
        if has_equal_steps(values[:, place]):
            masked_values[:, place] = values[:, place]
    return masked_values


def _apply_flag_column(table: ColumnTable, columns: Sequence[NameOrIndex] | None) -> ColumnTable:
    """Remove a column of flags from a table, and set heights to NaN in rows whose flag marks a missing point.

    Raises `FormatError` if the meaning of the flags is unknown, unless the caller chose the columns.
    """
    for place, name in enumerate(table.names):
        flags = table.values[:, place]
        flag_meanings = [
            pattern.fullmatch(name.strip()) is not None
            for pattern in (_VALIDITY_COLUMN_PATTERN, _INVALIDITY_COLUMN_PATTERN, _AMBIGUOUS_FLAG_COLUMN_PATTERN)
        ]
        if table.values.shape[1] < 2 or not any(flag_meanings) or not np.isin(flags, (0.0, 1.0)).all():
            continue
        is_valid, is_invalid, _ = flag_meanings
        num_zeros, num_ones = int((flags == 0).sum()), int((flags == 1).sum())
        other_columns = [index for index in range(table.values.shape[1]) if index != place]
        if not is_valid and not is_invalid:
            if num_zeros and num_ones and columns is None:
                raise FormatError(
                    f"has flags of unknown meaning in column {place} ({printable_text(name)}), {num_zeros} zeros and "
                    f'{num_ones} ones; name the column "valid" if 1 marks measured points, or "invalid" if 1 marks '
                    "missing points; or choose other columns (--columns) to ignore the flags"
                )
            reason = "removed: all its flags are equal" if not (num_zeros and num_ones) else "is ignored"
            history_entry = f"column {place} ({printable_text(name)}) {reason}"
            return replace(_select_table_columns(table, other_columns), history=(*table.history, history_entry))
        missing = flags == (1 if is_invalid else 0)
        values = _fill_missing_rows_with_nan(table.values, missing, other_columns)
        history_entry = (
            f"{int(missing.sum())} points missing according to the flags in column {place} ({printable_text(name)})"
        )
        return replace(
            _select_table_columns(table, other_columns, values=values), history=(*table.history, history_entry)
        )
    return table


def _select_table_columns(table: ColumnTable, selection: Sequence[int], values: Floats | None = None) -> ColumnTable:
    """Return a table that consists of selected columns of another table."""
    digits, numbers = table.digits, _list_column_numbers(table)
    return replace(
        table, values=(table.values if values is None else values)[:, list(selection)],
        names=tuple(table.names[index] for index in selection) if table.names else (),
        units=tuple(_list_column_units(table)[index] for index in selection),
        places=tuple(numbers[index] for index in selection),
        digits=None if digits is None else lambda column: digits(selection[column]), row_digits=None,
    )  # fmt: skip


# ---- Shapes ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class TableLayout:
    """Layout of a table, such as "positions and heights", with functions that recognise and read such a table."""

    name: str
    recognises: Callable[[ColumnTable], bool]
    read: Callable[[ColumnTable], RawHeights]


def _read_by_layout(table: ColumnTable) -> RawHeights:
    """Read the heights of a table by means of the first `TableLayout` that recognises the table."""
    table, numbering_history = _remove_numbering(table)
    is_empty_column = np.isnan(table.values).all(axis=0)
    if table.places is not None and is_empty_column.any() and not is_empty_column.all():
        table = _select_table_columns(table, np.flatnonzero(~is_empty_column).tolist())
    layout = next(layout for layout in TABLE_LAYOUTS if layout.recognises(table))
    raw = layout.read(table)
    source = replace(raw.source, layout=table.source.layout or layout.name)
    return replace(raw, history=(*numbering_history, *raw.history), source=source)


def _remove_numbering(table: ColumnTable) -> tuple[ColumnTable, tuple[str, ...]]:
    """Remove row and column numbers from a table of heights.

    Returns the table and, if numbers were removed, a history entry.
    """
    rows, columns = table.values.shape
    if columns > 1 and table.names and _INDEX_COLUMN_NAME_PATTERN.fullmatch(table.names[0].strip()):
        first_number = table.values[0, 0]
        if first_number not in (0.0, 1.0) or not np.array_equal(table.values[:, 0], first_number + np.arange(rows)):
            return table, ()
        if table.names[0].strip() and table.names[0].strip().casefold() not in ("index", "unnamed: 0") and columns == 2:
            return table, ()
        return _select_table_columns(table, range(1, columns)), ("the first column, which numbers the rows, removed",)
    is_numbered = rows > 2 and columns > 2 and not table.names and np.isnan(table.values[0, 0])
    first_number = table.values[1, 0] if is_numbered else np.nan
    if (
        first_number in (0.0, 1.0)
        and np.array_equal(table.values[1:, 0], first_number + np.arange(rows - 1))
        and np.array_equal(table.values[0, 1:], first_number + np.arange(columns - 1))
    ):
        stripped_table = replace(
            table,
            values=table.values[1:, 1:],
            units=_list_column_units(table)[1:],
            digits=None,
            row_digits=None,
            places=None,
        )
        return stripped_table, ("the first row and column, which number columns and rows, removed",)
    return table, ()


def _read_matrix(table: ColumnTable) -> RawHeights:
    """Return all numbers of a table as a matrix of heights.

    Raises `FormatError` if the table contains other numbers, such as positions or statistics.
    """
    reject_separate_blocks(table.block_lengths, table.block_lines)
    reject_points_and_statistics(table.values, _list_column_numbers(table))
    is_declared_map = table.is_array or table.declared.size is not None or table.declared.spacings is not None
    caveats = () if is_declared_map else find_wrapped_profile_caveat(table.values)
    table, history = _remove_position_column(table)
    raw = _to_raw_heights(table, table.values, _choose_common_unit(table, _list_column_units(table)), history=history)
    raw = replace(
        raw, declared_spacing=raw.declared_spacing or table.declared.row_spacing, caveats=(*raw.caveats, *caveats)
    )
    if (spacings := table.declared.spacings) is None:
        return raw
    spacing = tuple(declared_spacing.to_micrometres() for declared_spacing in spacings)
    return replace(
        raw,
        spacing=spacing,
        position_unit="um",
        size=None,
        declared_spacing=None,
        bare_spacing=None,
        declared_spacings=None,
    )


def _remove_position_column(table: ColumnTable) -> tuple[ColumnTable, tuple[str, ...]]:
    """Remove the first column of a table if it contains positions with the spacing that the header declares.

    Raises `FormatError` if the first row or column contains other positions. A single row or column contains heights.
    """
    heights = table.values
    if min(heights.shape) == 1:
        return table, ()
    rows, columns = heights.shape
    row_digits = table.row_digits
    has_position_column = _first_line_has_positions(heights.T, table.last_digit_value_function(0))
    has_position_row = _first_line_has_positions(heights, None if row_digits is None else lambda: row_digits(0))
    spacings = table.declared.spacings
    if has_position_column and not has_position_row and spacings is not None:
        step = float(heights[-1, 0] - heights[1, 0]) / (rows - 2)
        if abs(step - spacings[0].length) <= max(0.51 * spacings[0].digit, MAX_STEP_UNEVENNESS * spacings[0].length):
            text = f"the first column removed: positions {step:g} {spacings[0].unit} apart, as its header declares"
            return _select_table_columns(table, range(1, columns)), (text,)
    for line, name in ((heights.T[::-1], "column"), (heights[::-1], "row")):
        if has_equal_steps(line[0]) and _first_line_has_positions(line, None):
            raise FormatError(
                f"contains {rows} rows of {columns} columns, and the last {name} has numbers with equal steps, "
                f"like positions or {'row' if name == 'column' else 'column'} numbers; remove that {name}"
            )
    if has_position_column or has_position_row:
        has_both = has_position_column and has_position_row
        raise FormatError(
            f"contains {rows} rows of {columns} columns, and the first "
            f"{'row and column have' if has_both else 'column has' if has_position_column else 'row has'} "
            "numbers with equal steps, like positions; leave only heights in the file, or choose one or two columns "
            "(--columns)"
        )
    return table, ()


def _first_line_has_positions(lines: Floats, digits: Callable[[], Floats] | None) -> bool:
    """Return whether the first line of a table contains positions, and not heights of a tilted surface."""
    first_line = lines[0]
    other_lines = [lines[index] for index in {1, lines.shape[0] // 2, lines.shape[0] - 1} if index]
    if _has_equal_steps_as_printed(first_line, digits):
        return not all(has_equal_steps(other_line) for other_line in other_lines)
    if first_line.size < MIN_JITTERED_POSITIONS or not np.isfinite(first_line[1:]).all():
        return False
    steps = np.diff(first_line[1:])
    if np.ptp(steps) > MAX_RELATIVE_STEP_DEVIATION * abs(steps.mean()) or not ((steps > 0).all() or (steps < 0).all()):
        return False
    # Positions with jitter change steadily only in the first line; heights of a tilted surface change so in all lines.
    return any(_correlate_with_index(other_line) < MIN_TILT_CORRELATION for other_line in other_lines)


def _correlate_with_index(values: Floats) -> float:
    """Return the absolute correlation coefficient between heights and point index."""
    filled_rows = np.flatnonzero(np.isfinite(values))
    if filled_rows.size < 3 or np.ptp(values[filled_rows]) == 0:
        return 0.0
    return abs(float(np.corrcoef(filled_rows, values[filled_rows])[0, 1]))


def has_equal_steps(values: Floats, slack: float = 0.0) -> bool:
    """Return whether numbers increase or decrease by a constant step, as positions along a line do.

    The first number is ignored, because it may be the corner of a table.
    """
    following = values[1:]
    if following.size < 4 or not np.isfinite(following).all():
        return False
    steps = np.diff(following)
    mean_step = (following[-1] - following[0]) / (following.size - 1)
    if mean_step == 0:
        return False
    if np.ptp(steps) <= MAX_STEP_UNEVENNESS * abs(mean_step):
        return True
    deviations = np.abs(following - following[0] - mean_step * np.arange(following.size))
    return bool(slack > 0 and deviations.max() <= slack and abs(mean_step) > MIN_STEP_IN_LAST_DIGITS * slack)


def _has_equal_steps_as_printed(values: Floats, digits: Callable[[], Floats] | None) -> bool:
    """Return whether printed numbers rise or fall in equal steps, apart from rounding to the last printed digit."""
    if has_equal_steps(values):
        return True
    if digits is None or values.size < 5 or not np.isfinite(values[1:]).all():
        return False
    steps = np.diff(values[1:])
    mean_step = steps.mean()
    if mean_step == 0 or not ((steps > 0).all() or (steps < 0).all()) or np.ptp(steps) > abs(mean_step):
        return False
    return has_equal_steps(values, float(np.max(digits()[1:])) * (1 + 1e-9))


def _is_labelled_matrix(table: ColumnTable) -> bool:
    """Return whether a table's first row and first column contain positions and its upper left cell is empty."""
    values = table.values
    if min(values.shape) < 5 or not np.isnan(values[0, 0]) or table.is_array:
        return False
    row_digits = table.row_digits
    return _has_equal_steps_as_printed(
        values[:, 0], table.last_digit_value_function(0)
    ) and _has_equal_steps_as_printed(values[0], None if row_digits is None else lambda: row_digits(0))


def _read_labelled_matrix(table: ColumnTable) -> RawHeights:
    reject_separate_blocks(table.block_lengths, table.block_lines)
    x, y = table.values[0, 1:], table.values[1:, 0]
    dx, dy = (float(axis_positions[-1] - axis_positions[0]) / (axis_positions.size - 1) for axis_positions in (x, y))
    heights = table.values[1:, 1:][:: 1 if dy > 0 else -1, :: 1 if dx > 0 else -1]
    return _to_raw_heights(
        table, np.ascontiguousarray(heights), _choose_common_unit(table, _list_column_units(table)[1:]),
        spacing=(abs(dy), abs(dx)), position_unit=_list_column_units(table)[0],
        history=("the first row and column are positions along x and y",),
    )  # fmt: skip


def _find_xyz_columns(table: ColumnTable) -> tuple[int, int, int] | None:
    """Return the indices of the x, y and z columns in a list of points.

    Returns None if there are no such columns.

    The columns are found by their names. Without names, a table must have exactly three columns.
    """
    columns = table.values.shape[1]
    if not any(table.names):
        return (0, 1, 2) if columns == 3 else None
    x, y, z = (
        [index for index, name in enumerate(table.names) if axis.fullmatch(name.strip())]
        for axis in (_X_COLUMN_PATTERN, _Y_COLUMN_PATTERN, _HEIGHT_COLUMN_PATTERN)
    )
    if len(x) != 1 or len(y) != 1:
        return None
    z = z if len(z) == 1 else [index for index in range(columns) if index not in (x[0], y[0])]
    return (x[0], y[0], z[0]) if len(z) == 1 else None


def _is_xyz_table(table: ColumnTable) -> bool:
    if table.is_array or table.values.shape[0] < 4 or (places := _find_xyz_columns(table)) is None:
        return False
    x, y = (table.values[:, index] for index in places[:2])
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        return False
    count = x.size
    distinct_counts = [np.unique(coordinates).size for coordinates in (x, y)]
    # In a list of grid points, x and y occur repeatedly; the positions of a profile are unique.
    return (max(distinct_counts) < count and min(distinct_counts) > 1) or (
        bool(table.names) and max(distinct_counts) == count and min(distinct_counts) > 1
    )


def _read_xyz_table(table: ColumnTable, *places: int) -> RawHeights:
    x, y, z = (table.values[:, index] for index in places)
    digits = [table.last_digit_value_function(index) for index in places[:2]]
    heights, spacing, history_entry = to_grid(x, y, z, digits)
    units = _list_column_units(table)
    lateral_units = {units[places[0]], units[places[1]]}
    if len(lateral_units) > 1:
        raise FormatError("has x and y in different units; write both in the same unit")
    source = replace(table.source, layout="points x, y, z on a grid", column=_describe_column(table, places[2]))
    raw = _to_raw_heights(
        table, heights, _find_height_unit(table, places[2]), spacing=spacing,
        position_unit=next(iter(lateral_units)) or table.declared.position_unit,
        history=(history_entry,), source=source,
    )  # fmt: skip
    return replace(raw, caveats=(*raw.caveats, *_find_calculated_column_caveat(table, places[2])))


def _is_line_of_points(table: ColumnTable) -> bool:
    """Return whether rows are points (x, y, z) on a line along x: all y are equal, and all x are different."""
    places = _find_xyz_columns(table)
    if places is None or table.is_array or (table.values.shape[1] != 3):
        return False
    x, y = (table.values[:, index] for index in places[:2])
    return bool(table.names) and np.unique(y).size == 1 and np.unique(x).size == x.size


def _reject_ambiguous_columns(table: ColumnTable) -> RawHeights:
    columns = table.values.shape[1]
    numbers = _list_column_numbers(table)
    names = f": {format_name_list(table.names, numbers)}" if table.names else ", numbered from 0"
    raise FormatError(
        f"has {columns} columns of numbers that may be positions and several heights{names}; choose one column "
        "(heights), two columns (positions and heights) or three columns (x, y and z) with the option columns "
        f"(--columns); a surface is a matrix of at least four columns without names"
        f"{_describe_missing_information(table)}"
    )


def _describe_missing_information(table: ColumnTable) -> str:
    """Return the end of an error message: a request for the length unit, the spacing, or both, if they are missing.

    The text is empty if the table has both.
    """
    declared, requirements = table.declared, []
    if all(unit is None for unit in _list_column_units(table)) and declared.unit is None:
        requirements.append("the unit of lengths is required as well (--unit)")
    if (
        declared.spacing is None
        and declared.spacings is None
        and not any(
            has_equal_steps(table.values[:, index])
            for index in range(min(table.values.shape[1], MAX_LISTED_COLUMN_NAMES))
        )
    ):
        requirements.append("the spacing is required for heights without positions (--spacing)")
    return "".join(f"; {requirement}" for requirement in requirements)


def _has_ambiguous_columns(table: ColumnTable) -> bool:
    columns = table.values.shape[1]
    return not table.is_array and (
        columns < MIN_MATRIX_COLUMNS or len(set(_list_column_units(table))) > 1 or bool(table.names)
    )


TABLE_LAYOUTS: tuple[TableLayout, ...] = (
    TableLayout(
        "heights, a column", lambda table: table.values.shape[1] == 1, lambda table: _read_profile_columns(table, 0)
    ),
    TableLayout(
        "positions and heights",
        lambda table: (
            table.values.shape[1] == 2
            and (not table.is_array or (table.values.shape[0] > 2 and has_equal_steps(table.values[:, 0])))
        ),
        lambda table: _read_profile_columns(table, 0, 1),
    ),
    TableLayout(
        "points x, y, z on a grid",
        _is_xyz_table,
        lambda table: _read_xyz_table(table, *(_find_xyz_columns(table) or ())),
    ),
    TableLayout(
        "points x, y, z on a line",
        _is_line_of_points,
        lambda table: _read_profile_columns(table, *(_find_xyz_columns(table) or ())[::2]),
    ),
    TableLayout("matrix with positions along its sides", _is_labelled_matrix, _read_labelled_matrix),
    TableLayout("columns to choose from", _has_ambiguous_columns, _reject_ambiguous_columns),
    TableLayout("matrix", lambda table: True, _read_matrix),
)
"""Layouts of tables in order of priority. A table is read by the first layout that recognises the table.

- heights, a column: ``0.5`` ``-0.2`` ``1.0``, one number per line
- positions and heights: ``0.0;0.5`` ``0.1;-0.2``
- points on a grid: ``0 0 0.5``, ``1 0 -0.2``, ``0 1 1.0``, in any order; missing nodes are missing points
- points on a line: the same with a single y, and with column names
- matrix with positions along its sides: ``;0.0;0.5;1.0`` above ``0.0;0.3;-0.2;0.1``
- columns to choose from: columns with names, or fewer than four; the caller must choose
- matrix: rows of heights, x along a row, y from row to row
"""
