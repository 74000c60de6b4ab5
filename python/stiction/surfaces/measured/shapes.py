"""Second step of reading, for tables: the shape that columns of numbers have, by the options or by the numbers."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stiction._checks import Floats
from stiction._text import printable
from stiction.surfaces.measured.grid import gridded
from stiction.surfaces.measured.header import NO_HEIGHT
from stiction.surfaces.measured.raw import LENGTH_UNITS, Caveat, Channels, Content, FormatError, Raw, Table, length_unit

UNEVEN = 1e-3
"""Spacings by which a point may be off a uniform grid: nothing in the heights shows it, and positions that went through
single precision have it."""

MIN_COLUMNS = 4  # of a text that is a matrix of heights
MAX_GRID = 100_000_000  # points of a map
MAX_LISTED = 12  # names in a message
MIN_JITTERED, JITTER = 8, 0.5  # positions, and the range of their steps over the mean, that are measured and so uneven
TILTED = 0.98  # correlation of heights with their places above which the surface is tilted
MIN_WRITTEN = 20  # numbers that are written alike, by which another one stands out
MIN_STEP = 3.0  # printed digits of a step of positions; heights with few digits would count evenly within them
Chosen = str | int

_NUMBERING = re.compile(r"|index|unnamed: ?0|no\.?|nr\.?|#|n|i|points?|pt\.?|punkt|zeile|line|row|dataline|trace", re.I)
_VALID = re.compile(r"\W*(?:valid\w*|gültig\w*|is[ _]?valid|ok|1/0)\b.*|.*[\[(]1/0[\])]", re.I)
_INVALID = re.compile(r"\W*(?:invalid\w*|ungültig\w*|is[ _]?invalid)\b.*", re.I)
_FLAG = re.compile(r"\W*(?:flags?|status|0/1)\b.*|.*[\[(]0/1[\])]", re.I)  # of either sense
_X, _Y = (re.compile(rf"\W*{axis}(?![a-z0-9]).*|.*\b{axis}[\s_-]*(?:pos|coord).*", re.I) for axis in "xy")
_Z = re.compile(r"\W*(?:z(?![a-z0-9])|height|höhe|hauteur|altezza|altura|topo).*", re.I)


def raw_of(content: Content, channel: Chosen | None, columns: Sequence[Chosen] | None) -> Raw:
    """Return the heights that are meant."""
    if isinstance(content, Channels):
        at = _channel(content, channel)
        raw = raw_of(content.read(at), None, columns)
        if len(content.names) == 1:
            return raw
        name = printable(content.names[at])
        step = f"channel {at} ({name}) of {listed(content.names)}"
        column = f"{name}, {raw.source.column}" if raw.source.column not in ("", name) else name
        return replace(raw, history=(step, *raw.history), source=replace(raw.source, column=column))
    if channel is not None:
        raise FormatError(f"has no channels to choose one from, but channel says {channel!r}")
    if isinstance(content, Table):
        table = _with_flags(content)
        raw = _chosen_columns(table, columns) if columns is not None else _by_shape(table)
        return replace(raw, history=(*table.history, *raw.history), caveats=(*table.caveats, *raw.caveats))
    if columns is not None:
        raise FormatError("has no columns to choose from, but columns are given")
    return content


def _channel(channels: Channels, chosen: Chosen | None) -> int:
    if chosen is not None:
        return _place(channels.names, chosen, range(len(channels.names)), "channel")
    if channels.default is None:
        raise FormatError(f"holds {listed(channels.names)}; choose one by channel (--channel)")
    return channels.default


def _place(names: Sequence[str], chosen: Chosen, numbers: Sequence[int], what: str) -> int:
    """Return the place that a name, or a number as users count, stands for."""
    text = str(chosen).strip()
    for folded in (lambda name: name, lambda name: name.casefold(), _bare):
        same = [at for at, name in enumerate(names) if folded(name.strip()) == folded(text) and text]
        if len(same) > 1:
            raise FormatError(f"has more than one {what} {text!r}; give its number: {listed(names, numbers)}")
        if same:
            return same[0]
    if text.isascii() and text.isdigit() and len(text) < 10:
        if int(text) in numbers:
            return numbers.index(int(text))
        allowed = f"numbered from 0 to {numbers[-1]}" if len(numbers) > numbers[-1] else ", ".join(map(str, numbers))
        raise FormatError(f"has no {what} {text}; they are {allowed}")
    raise FormatError(
        f"has no {what} {text[:40]!r}, but {listed(names, numbers) if names else f'{len(numbers)} without names'}"
    )


def _bare(name: str) -> str:
    """Return the name of a column without its unit."""
    return re.sub(r"\s*[(\[{<].{0,40}$|\s*/\s*\S{0,12}$", "", name).casefold()


def listed(names: Sequence[str], numbers: Sequence[int] | None = None) -> str:
    """Return names with their numbers, the first of them."""
    numbers = range(len(names)) if numbers is None else numbers
    pairs = list(zip(numbers, names, strict=True))
    shown = ", ".join(f"{at} ({printable(name)})" for at, name in pairs[:MAX_LISTED])
    return f"{shown} and {len(names) - MAX_LISTED} more" if len(names) > MAX_LISTED else shown


# ---- Columns --------------------------------------------------------------------------------------------------------


def _numbers_of(table: Table) -> Sequence[int]:
    return range(table.values.shape[1]) if table.places is None else table.places


def _chosen_columns(table: Table, chosen: Sequence[Chosen]) -> Raw:
    """Return the heights in one column, over the positions in one before it, or over x and y in two before it."""
    numbers = _numbers_of(table)
    places = [_place(table.names, each, numbers, "column") for each in chosen]
    named = ", ".join(
        f"{numbers[at]} ({printable(table.names[at])})" if table.names else str(numbers[at]) for at in places
    )
    step = f"column {named}" if len(places) == 1 else f"columns {named}"
    raw = _triplets(table, *places) if len(places) == 3 else _profile(table, *places[-2:])
    return replace(raw, history=(step, *raw.history))


def _raw(table: Table, heights: Floats, unit: str | None, **more: Any) -> Raw:
    """Return heights of a table with all facts that the words around them declare."""
    declared = table.declared
    counts = tuple(count for count in declared.counts if count > heights.size)  # too many to be a count
    caveats: tuple[Caveat, ...] = ()
    if declared.scale:
        text = (
            f"its header has the line {printable(declared.scale)!r}, a factor or a range of heights; it is not applied"
        )
        cure = "accept it if the heights are in their unit; otherwise multiply them by the factor first"
        caveats = (Caveat("scale", text, cure),)
    raw = Raw(
        heights, unit=unit, factor=declared.factor, codes=(*declared.codes, *counts), stated=declared.spacing,
        size=declared.size, bare_spacing=declared.bare_spacing, source=table.source, caveats=caveats,
        stated_spacings=declared.spacings,
    )  # fmt: skip
    raw = replace(raw, **more)
    if (tip := declared.tip_radius) is None:
        return raw
    return replace(raw, history=(*raw.history, f"its header gives a tip radius of {tip.length:g} {tip.unit} (--tip)"))


def _common_unit(table: Table, units: Sequence[str | None]) -> str | None:
    """Return the unit of heights in several columns."""
    unit = units[0] if len(set(units)) == 1 else None
    declared = table.declared
    return declared.unit if declared.unit is not None and (unit is None or declared.factor is not None) else unit


def _profile(table: Table, *places: int) -> Raw:
    """Return heights of one column, or positions of one and heights of another, as far as both go."""
    heights, declared = table.values[:, places[-1]], table.declared
    layout = "heights, a column" if len(places) == 1 else "positions and heights"
    raw = _raw(
        table, heights, _height_unit(table, places[-1]),
        source=replace(table.source, layout=table.source.layout or layout, column=_named(table, places[-1])),
        stated=declared.spacing or (None if declared.spacings is None else declared.spacings[1]), size=None,
        bare_spacing=None if declared.bare_spacing is None else declared.bare_spacing[-1:],
    )  # fmt: skip
    if len(places) == 1:
        filled = np.flatnonzero(~np.isnan(heights))
        end = int(filled[-1]) + 1 if filled.size and table.values.shape[1] > 1 else heights.size
        heights, history = _without_count(heights[:end], table.values.shape[1])
        caveats = () if history else _first_number_caveat(table)
        return replace(raw, heights=heights, history=history, caveats=(*raw.caveats, *caveats))
    positions = table.values[:, places[0]]
    both = np.isnan(positions) & np.isnan(heights)  # below the shorter of two tables side by side
    end = heights.size - int(np.argmin(both[::-1])) if not both.all() else heights.size
    digits = table.column_digits(places[0])
    return replace(
        raw, heights=heights[:end], positions=positions[:end], position_unit=_units(table)[places[0]],
        digits=None if digits is None else lambda: digits()[:end],
        caveats=(*raw.caveats, *_numbering_caveat(table, positions[:end], places[0])),
    )  # fmt: skip


def _units(table: Table) -> tuple[str | None, ...]:
    return table.units or (None,) * table.values.shape[1]


def _named(table: Table, place: int) -> str:
    number = _numbers_of(table)[place]
    return f"{number} ({printable(table.names[place])})" if table.names and table.names[place] else str(number)


def _height_unit(table: Table, place: int) -> str | None:
    """Return the unit of a column of heights; a `FormatError` if its name is that of another quantity."""
    unit = _units(table)[place]
    if unit is not None and length_unit(unit) is None:
        return unit
    name = table.names[place] if table.names else ""
    if (match := NO_HEIGHT.search(name)) is not None:
        raise FormatError(
            f"has a column named {printable(name)!r}: {match[0].lower()} is no height; "
            "choose another by columns (--columns)"
        )
    return unit if unit is not None and table.declared.factor is None else table.declared.unit or unit


def _without_count(heights: Floats, width: int) -> tuple[Floats, tuple[str, ...]]:
    """Return a column of heights without the count of those that follow, if the first number is that."""
    for place in range(min(3, heights.size - 4) if width == 1 else 0):
        if heights[place] == heights.size - 1 - place:
            if place:
                raise FormatError(
                    f"begins with {place + 1} numbers of which the last, {heights[place]:.0f}, counts those that "
                    "follow; delete these lines, which are no heights"
                )
            return heights[1:], (f"first number left out, {heights[0]:.0f}, which counts those that follow",)
    if width == 1 and heights.size > 6 and heights[0] * heights[1] == heights.size - 2 and min(heights[:2]) > 1:
        raise FormatError(
            f"begins with the size of a map, {heights[0]:.0f} and {heights[1]:.0f}, and lists its heights one a line; "
            "write a row of the map in each line"
        )
    return heights, ()


def _first_number_caveat(table: Table) -> tuple[Caveat, ...]:
    """Return a doubt about the first number of a column if it is written with fewer decimals than all that follow."""
    if table.values.shape != (table.values.size, 1) or table.values.size < MIN_WRITTEN + 1 or table.row_digits is None:
        return ()
    first, *rest = (float(table.row_digits(at)[0]) for at in range(MIN_WRITTEN + 1))
    if len(set(rest)) > 1 or not first > 50 * rest[0]:
        return ()
    text = f"the first number, {table.values[0, 0]:g}, has fewer decimals than all that follow"
    return (Caveat("first-number", text, "delete it if it is a step or a size and no height, or accept it"),)


def _numbering_caveat(table: Table, positions: Floats, place: int) -> tuple[Caveat, ...]:
    """Return a doubt about positions that may as well be the numbers of the points."""
    name = table.names[place] if table.names else ""
    if _units(table)[place] is not None or (name and not _NUMBERING.fullmatch(name.strip())):
        return ()
    first = positions[0] if positions.size else np.nan
    if (
        positions.size < 4
        or first not in (0.0, 1.0)
        or not np.array_equal(positions, first + np.arange(positions.size))
    ):
        return ()
    number = _numbers_of(table)[place]
    return (
        Caveat(
            "numbering",
            f"column {number} counts {first:.0f}, {first + 1:.0f}, {first + 2:.0f}, ... and is taken for positions",
            "if it numbers the points, choose that of heights by --columns and give --spacing",
        ),
    )


def _with_flags(table: Table) -> Table:
    """Return a table without a column of flags, and without the heights that it flags as invalid."""
    for place, name in enumerate(table.names):
        flags = table.values[:, place]
        senses = [pattern.fullmatch(name.strip()) is not None for pattern in (_VALID, _INVALID, _FLAG)]
        if table.values.shape[1] < 2 or not any(senses) or not np.isin(flags, (0.0, 1.0)).all():
            continue
        is_valid, is_invalid, _ = senses
        zeros, ones = int((flags == 0).sum()), int((flags == 1).sum())
        if not is_valid and not is_invalid and zeros and ones:
            raise FormatError(
                f"has flags in column {place} ({printable(name)}), {zeros} of 0 and {ones} of 1, and does not say "
                'which are missing points: name the column "valid" if 1 marks measured points, or "invalid" if 1 marks '
                "missing points"
            )
        kept = [at for at in range(table.values.shape[1]) if at != place]
        if not is_valid and not is_invalid:
            step = f"column {place} ({printable(name)}) left out: all its flags are alike"
            return replace(_with_columns(table, kept), history=(*table.history, step))
        missing = flags == (1 if is_invalid else 0)
        values = np.where(missing[:, np.newaxis], np.nan, table.values)
        for at in kept:  # positions stay
            if counts_evenly(table.values[:, at]):
                values[:, at] = table.values[:, at]
        step = f"{int(missing.sum())} points missing by the flags in column {place} ({printable(name)})"
        return replace(_with_columns(table, kept, values=values), history=(*table.history, step))
    return table


def _with_columns(table: Table, kept: Sequence[int], values: Floats | None = None) -> Table:
    """Return a table of some of its columns."""
    digits, numbers = table.digits, _numbers_of(table)
    return replace(
        table, values=(table.values if values is None else values)[:, list(kept)],
        names=tuple(table.names[at] for at in kept) if table.names else (),
        units=tuple(_units(table)[at] for at in kept), places=tuple(numbers[at] for at in kept),
        digits=None if digits is None else lambda column: digits(kept[column]), row_digits=None,
    )  # fmt: skip


# ---- Shapes ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Shape:
    """One of the shapes that a table may have: how it is recognised, and how it is read."""

    name: str
    recognise: Callable[[Table], bool]
    read: Callable[[Table], Raw]


def _by_shape(table: Table) -> Raw:
    """Return the heights of a table by the first shape that recognises it."""
    table, step = _without_numbering(table)
    empty = np.isnan(table.values).all(axis=0)
    if table.places is not None and empty.any() and not empty.all():
        table = _with_columns(table, np.flatnonzero(~empty).tolist())
    shape = next(shape for shape in SHAPES if shape.recognise(table))
    raw = shape.read(table)
    source = replace(raw.source, layout=table.source.layout or shape.name)
    return replace(raw, history=(*step, *raw.history), source=source)


def _without_numbering(table: Table) -> tuple[Table, tuple[str, ...]]:
    """Return a table without the column, and the row, in which a program has numbered its rows and columns."""
    rows, columns = table.values.shape
    if columns > 1 and table.names and _NUMBERING.fullmatch(table.names[0].strip()):
        first = table.values[0, 0]
        if first not in (0.0, 1.0) or not np.array_equal(table.values[:, 0], first + np.arange(rows)):
            return table, ()
        if table.names[0].strip() and table.names[0].strip().casefold() not in ("index", "unnamed: 0") and columns == 2:
            return table, ()  # then positions, with a doubt
        return _with_columns(table, range(1, columns)), ("the first column, which numbers the rows, left out",)
    numbered = rows > 2 and columns > 2 and not table.names and np.isnan(table.values[0, 0])
    if (
        numbered
        and np.array_equal(table.values[1:, 0], np.arange(rows - 1))
        and np.array_equal(table.values[0, 1:], np.arange(columns - 1))
    ):
        kept = replace(
            table, values=table.values[1:, 1:], units=_units(table)[1:], digits=None, row_digits=None, places=None
        )
        return kept, ("the first row and column, which number columns and rows, left out",)
    return table, ()


def _read_matrix(table: Table) -> Raw:
    """Return a matrix of heights; a `FormatError` if some of its rows or columns are positions."""
    table, history = _without_positions(table)
    raw = _raw(table, table.values, _common_unit(table, _units(table)), history=history)
    if (spacings := table.declared.spacings) is None:
        return raw
    spacing = tuple(stated.length * LENGTH_UNITS[stated.unit] for stated in spacings)
    return replace(
        raw, spacing=spacing, position_unit="um", size=None, stated=None, bare_spacing=None, stated_spacings=None
    )


def _without_positions(table: Table) -> tuple[Table, tuple[str, ...]]:
    """Return a matrix without a first column of positions that are the declared spacing apart, and the step for it.

    A `FormatError` if its first row or column are other positions; a row or a column alone is heights.
    """
    heights = table.values
    if min(heights.shape) == 1:
        return table, ()
    rows, columns = heights.shape
    row_digits = table.row_digits
    first_column = _are_positions(heights.T, table.column_digits(0))
    first_row = _are_positions(heights, None if row_digits is None else lambda: row_digits(0))
    spacings = table.declared.spacings
    if first_column and not first_row and spacings is not None:
        step = float(heights[-1, 0] - heights[1, 0]) / (rows - 2)
        if abs(step - spacings[0].length) <= max(0.51 * spacings[0].digit, UNEVEN * spacings[0].length):
            text = f"the first column left out: positions {step:g} {spacings[0].unit} apart, as its header says"
            return _with_columns(table, range(1, columns)), (text,)
    if first_column or first_row:
        both = first_column and first_row
        raise FormatError(
            f"holds {rows} rows of {columns} columns, of which the first "
            f"{'row and column count' if both else 'column counts' if first_column else 'row counts'} "
            "evenly, as positions do; leave only heights in the file, or choose one column or two by columns "
            "(--columns 0,1 reads positions and the first profile)"
        )
    return table, ()


def _are_positions(lines: Floats, digits: Callable[[], Floats] | None) -> bool:
    """Return whether the first of several lines are positions, and the others are not such as of a tilted plane."""
    first = lines[0]
    others = [lines[at] for at in {1, lines.shape[0] // 2, lines.shape[0] - 1} if at]
    if _counts_evenly_as_printed(first, digits):
        return not all(counts_evenly(other) for other in others)
    if first.size < MIN_JITTERED or not np.isfinite(first[1:]).all():
        return False
    steps = np.diff(first[1:])
    if np.ptp(steps) > JITTER * abs(steps.mean()) or not ((steps > 0).all() or (steps < 0).all()):
        return False
    # Positions that are measured are a little off; raw heights of a tilted surface rise like them, in all lines.
    return any(_correlation(other) < TILTED for other in others)


def _correlation(values: Floats) -> float:
    """Return the correlation of values with their places, whatever its sign."""
    filled = np.flatnonzero(np.isfinite(values))
    if filled.size < 3 or np.ptp(values[filled]) == 0:
        return 0.0
    return abs(float(np.corrcoef(filled, values[filled])[0, 1]))


def counts_evenly(values: Floats, slack: float = 0.0) -> bool:
    """Return whether values, apart from the first, which may be a corner, rise or fall in equal steps."""
    rest = values[1:]
    if rest.size < 4 or not np.isfinite(rest).all():
        return False
    steps = np.diff(rest)
    mean = (rest[-1] - rest[0]) / (rest.size - 1)
    if mean == 0:
        return False
    if np.ptp(steps) <= UNEVEN * abs(mean):
        return True
    off = np.abs(rest - rest[0] - mean * np.arange(rest.size))
    return bool(slack > 0 and off.max() <= slack and abs(mean) > MIN_STEP * slack)


def _counts_evenly_as_printed(values: Floats, digits: Callable[[], Floats] | None) -> bool:
    """Return whether values rise or fall in equal steps within their printed digits."""
    if counts_evenly(values):
        return True
    if digits is None or values.size < 5 or not np.isfinite(values[1:]).all():
        return False
    steps = np.diff(values[1:])
    mean = steps.mean()
    if mean == 0 or not ((steps > 0).all() or (steps < 0).all()) or np.ptp(steps) > abs(mean):
        return False
    return counts_evenly(values, float(np.max(digits()[1:])) * (1 + 1e-9))


def _is_labelled(table: Table) -> bool:
    """Return whether the first row and column are positions, with nothing in their corner."""
    values = table.values
    if min(values.shape) < 5 or not np.isnan(values[0, 0]) or table.area:
        return False
    row_digits = table.row_digits
    return _counts_evenly_as_printed(values[:, 0], table.column_digits(0)) and _counts_evenly_as_printed(
        values[0], None if row_digits is None else lambda: row_digits(0)
    )


def _read_labelled(table: Table) -> Raw:
    x, y = table.values[0, 1:], table.values[1:, 0]
    dx, dy = (float(each[-1] - each[0]) / (each.size - 1) for each in (x, y))
    heights = table.values[1:, 1:][:: 1 if dy > 0 else -1, :: 1 if dx > 0 else -1]
    return _raw(
        table, np.ascontiguousarray(heights), _common_unit(table, _units(table)[1:]),
        spacing=(abs(dy), abs(dx)), position_unit=_units(table)[0],
        history=("the first row and column are positions along x and y",),
    )  # fmt: skip


def _xyz(table: Table) -> tuple[int, int, int] | None:
    """Return the columns of x, y and z of a list of points, by their names or as the first three."""
    columns = table.values.shape[1]
    if not any(table.names):
        return (0, 1, 2) if columns == 3 else None
    x, y, z = ([at for at, name in enumerate(table.names) if axis.fullmatch(name.strip())] for axis in (_X, _Y, _Z))
    if len(x) != 1 or len(y) != 1:
        return None
    z = z if len(z) == 1 else [at for at in range(columns) if at not in (x[0], y[0])]
    return (x[0], y[0], z[0]) if len(z) == 1 else None


def _are_triplets(table: Table) -> bool:
    if table.area or table.values.shape[0] < 4 or (places := _xyz(table)) is None:
        return False
    x, y = (table.values[:, at] for at in places[:2])
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        return False
    count = x.size
    found = [np.unique(each).size for each in (x, y)]
    # On a grid both take few values, each many times; a profile has another position in each row.
    return (max(found) < count and min(found) > 1) or (bool(table.names) and max(found) == count and min(found) > 1)


def _triplets(table: Table, *places: int) -> Raw:
    x, y, z = (table.values[:, at] for at in places)
    digits = [table.column_digits(at) for at in places[:2]]
    heights, spacing, step = gridded(x, y, z, digits)
    units = _units(table)
    lateral = {units[places[0]], units[places[1]]}
    if len(lateral) > 1:
        raise FormatError("has x and y in different units; write both in one")
    source = replace(table.source, layout="points x, y, z on a grid", column=_named(table, places[2]))
    return _raw(
        table, heights, _height_unit(table, places[2]), spacing=spacing, position_unit=next(iter(lateral)),
        history=(step,), source=source,
    )  # fmt: skip


def _is_line_of_points(table: Table) -> bool:
    """Return whether x, y and z are a profile along x, with one y."""
    places = _xyz(table)
    if places is None or table.area or (table.values.shape[1] != 3):
        return False
    x, y = (table.values[:, at] for at in places[:2])
    return bool(table.names) and np.unique(y).size == 1 and np.unique(x).size == x.size


def _refuse_columns(table: Table) -> Raw:
    columns = table.values.shape[1]
    numbers = _numbers_of(table)
    names = f": {listed(table.names, numbers)}" if table.names else ", numbered from 0 on"
    raise FormatError(
        f"has {columns} columns of numbers that may be positions and several heights{names}; choose by columns "
        "(--columns), one of heights or two of positions and heights, or three of x, y and z; a surface is a matrix of "
        f"four or more without names{_also_missing(table)}"
    )


def _also_missing(table: Table) -> str:
    """Return what a table lacks besides a choice of its columns, as the rest of a sentence."""
    declared, lacking = table.declared, []
    if all(unit is None for unit in _units(table)) and declared.unit is None:
        lacking.append("the unit of lengths is needed as well (--unit)")
    if (
        declared.spacing is None
        and declared.spacings is None
        and not any(counts_evenly(table.values[:, at]) for at in range(min(table.values.shape[1], MAX_LISTED)))
    ):
        lacking.append("the spacing is needed for heights alone (--spacing)")
    return "".join(f"; {each}" for each in lacking)


def _has_columns_of_their_own(table: Table) -> bool:
    columns = table.values.shape[1]
    return not table.area and (columns < MIN_COLUMNS or len(set(_units(table))) > 1 or bool(table.names))


SHAPES: tuple[Shape, ...] = (
    Shape("heights, a column", lambda table: table.values.shape[1] == 1, lambda table: _profile(table, 0)),
    Shape(
        "positions and heights",
        lambda table: (
            table.values.shape[1] == 2
            and (not table.area or (table.values.shape[0] > 2 and counts_evenly(table.values[:, 0])))
        ),
        lambda table: _profile(table, 0, 1),
    ),
    Shape("points x, y, z on a grid", _are_triplets, lambda table: _triplets(table, *(_xyz(table) or ()))),
    Shape("points x, y, z on a line", _is_line_of_points, lambda table: _profile(table, *(_xyz(table) or ())[::2])),
    Shape("matrix with positions along its sides", _is_labelled, _read_labelled),
    Shape("columns to choose from", _has_columns_of_their_own, _refuse_columns),
    Shape("matrix", lambda table: True, _read_matrix),
)
"""Shapes of tables, the first that fits first:

- heights, a column: ``0.5`` ``-0.2`` ``1.0``, a number a line
- positions and heights: ``0.0;0.5`` ``0.1;-0.2``
- points on a grid: ``0 0 0.5``, ``1 0 -0.2``, ``0 1 1.0``, in any order; nodes that are not listed are missing points
- points on a line: the same of one y, with names
- matrix with positions along its sides: ``;0.0;0.5;1.0`` above ``0.0;0.3;-0.2;0.1``
- columns to choose from: names, or fewer than four columns: none is chosen by itself
- matrix: rows of heights, x along a row, y from row to row
"""
