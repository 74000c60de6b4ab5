"""From a channel of a file and columns of a table to heights: what is meant is asked for, or plain from the numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiction._checks import Floats
from stiction._text import printable
from stiction.surfaces.measured.raw import LENGTH_UNITS, Channels, Content, FormatError, Raw, Table

UNEVEN = 1e-3
"""Spacings by which a point may be off a uniform grid: nothing in the heights shows it, and positions that went through
single precision have it."""

FEW = 8  # columns, or rows, of positions and some heights; a surface has more
FEWEST_COLUMNS = 4  # columns of a text from which on it is a matrix of heights
_SHOWN = 12  # names in a message
Chosen = str | int


def raw_of(content: Content, channel: Chosen | None, columns: Sequence[Chosen] | None) -> Raw:
    """The heights that are meant."""
    if isinstance(content, Channels):
        at = _channel(content, channel)
        raw = raw_of(content.read(at), None, columns)
        if len(content.names) == 1:
            return raw
        step = f"channel {at} ({printable(content.names[at])}) of {_listed(content.names)}"
        return replace(raw, history=(step, *raw.history))
    if channel is not None:
        raise FormatError(f"has no channels to choose one from, but channel says {channel!r}")
    if isinstance(content, Table):
        raw = _chosen_columns(content, columns) if columns is not None else _plain(content)
        return replace(raw, history=(*content.history, *raw.history))
    if columns is not None:
        raise FormatError("has no columns to choose from, but columns are given")
    return content


def _channel(channels: Channels, asked: Chosen | None) -> int:
    if asked is not None:
        return _place(channels.names, asked, len(channels.names), "channel")
    if channels.default is None:
        raise FormatError(f"holds {_listed(channels.names)}; choose one by channel")
    return channels.default


def _place(names: Sequence[str], asked: Chosen, count: int, what: str) -> int:
    """The place that a name or a number from 0 on stands for."""
    text = str(asked).strip()
    for folded in (lambda name: name, lambda name: name.casefold(), _bare):
        same = [at for at, name in enumerate(names) if folded(name.strip()) == folded(text) and text]
        if len(same) > 1:
            raise FormatError(f"has more than one {what} {text!r}; give its number: {_listed(names)}")
        if same:
            return same[0]
    if text.isascii() and text.isdigit() and len(text) < 10:
        if int(text) < count:
            return int(text)
        raise FormatError(f"has no {what} {text}; they are numbered from 0 to {count - 1}")
    raise FormatError(f"has no {what} {text[:40]!r}, but {_listed(names) if names else f'{count} without names'}")


def _bare(name: str) -> str:
    """The name of a column without its unit."""
    return re.sub(r"\s*[(\[{<].{0,40}$|\s*/\s*\S{0,12}$", "", name).casefold()


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(f"{at} ({printable(name)})" for at, name in enumerate(names[:_SHOWN]))
    return f"{shown} and {len(names) - _SHOWN} more" if len(names) > _SHOWN else shown


# ---- Columns --------------------------------------------------------------------------------------------------------


def _chosen_columns(table: Table, asked: Sequence[Chosen]) -> Raw:
    """A profile of the heights in one column, or of the positions in one and the heights in another."""
    places = [_place(table.names, each, table.values.shape[1], "column") for each in asked]
    step = "columns " + ", ".join(f"{at} ({printable(table.names[at])})" if table.names else str(at) for at in places)
    step = step if len(places) == 2 else step.replace("columns", "column")
    return replace(_profile(table, *places[-2:]), history=(step,))


def _profile(table: Table, *places: int) -> Raw:
    units = table.units or (None,) * table.values.shape[1]
    heights, unit = table.values[:, places[-1]], units[places[-1]]
    if len(places) == 1:
        return Raw(heights, unit=unit, stated=table.stated)
    positions = table.values[:, places[0]]
    digit = np.zeros(positions.shape) if table.digit is None else table.digit(places[0])
    return Raw(
        heights, unit=unit, positions=positions, digit=digit, position_unit=units[places[0]], stated=table.stated
    )


def _plain(table: Table) -> Raw:
    """What a table is by default: heights, positions and heights, or an area."""
    table, step = _without_numbering(table)
    rows, columns = table.values.shape
    if columns == 1:
        return replace(_profile(table, 0), history=step)
    if columns == 2 and (not table.area or (rows > 2 and counts_evenly(table.values[:, 0]))):
        return replace(_profile(table, 0, 1), history=step)
    if not table.area and (columns < FEWEST_COLUMNS or len(set(table.units)) > 1 or table.names):
        names = f": {_listed(table.names)}" if table.names else ", numbered from 0 on"
        raise FormatError(
            f"has {columns} columns of numbers that may be positions and several heights{names}; choose by columns, "
            "one of heights or two of positions and heights; a surface is a matrix of four or more without names"
        )
    unit = table.units[0] if len(set(table.units)) == 1 else None
    if table.spacings is not None:
        spacing = tuple(stated.length * LENGTH_UNITS[stated.unit] for stated in table.spacings)
        return Raw(table.values, unit=unit, spacing=spacing, position_unit="um", history=step)
    _refuse_positions(table.values)
    return Raw(table.values, unit=unit, stated=table.stated, size=table.size, history=step)


def _without_numbering(table: Table) -> tuple[Table, tuple[str, ...]]:
    """A table without the column, and the row, in which a program has numbered its rows and columns."""
    (rows, columns), digit = table.values.shape, table.digit
    if columns > 1 and table.names and table.names[0].strip().casefold() in ("", "index", "unnamed: 0"):
        if not np.array_equal(table.values[:, 0], np.arange(rows)):
            return table, ()
        kept = replace(
            table, values=table.values[:, 1:], names=table.names[1:], units=table.units[1:],
            digit=None if digit is None else lambda column: digit(column + 1),
        )  # fmt: skip
        return kept, ("the first column, which numbers the rows, left out",)
    numbered = rows > 2 and columns > 2 and not table.names and np.isnan(table.values[0, 0])
    if (
        numbered
        and np.array_equal(table.values[1:, 0], np.arange(rows - 1))
        and np.array_equal(table.values[0, 1:], np.arange(columns - 1))
    ):
        kept = replace(table, values=table.values[1:, 1:], units=table.units[1:], digit=None)
        return kept, ("the first row and column, which number columns and rows, left out",)
    return table, ()


def _refuse_positions(heights: Floats) -> None:
    """Refuse a matrix some of whose columns or rows are positions; a row or a column alone is heights."""
    if min(heights.shape) == 1:
        return
    rows, columns = heights.shape
    first_column, first_row = counts_evenly(heights[:, 0]), counts_evenly(heights[0])
    plane = counts_evenly(heights[:, -1]) and counts_evenly(heights[-1])
    labelled = first_column and first_row
    if not plane and (labelled or (first_column and columns < FEW) or (first_row and rows < FEW)):
        raise FormatError(
            f"holds {rows} rows of {columns} columns, of which the first "
            f"{'row and column count' if labelled else 'column counts' if first_column else 'row counts'} "
            "evenly, as positions do; leave only heights in the file, or choose one column or two by columns"
        )


def counts_evenly(values: Floats) -> bool:
    """Whether values, apart from the first, which may be a corner, rise or fall in equal steps."""
    steps = np.diff(values[1:])
    return steps.size > 2 and bool(np.ptp(steps) <= UNEVEN * abs(steps.mean()) and steps.mean() != 0)
