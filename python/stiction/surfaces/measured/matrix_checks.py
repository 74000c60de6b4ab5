"""Checks that a table without column names contains a map of heights, not points, statistics or a single profile.

A matrix of heights has columns of one kind, in rows that follow each other. Tables of another kind are recognised by
their numbers alone, because nothing else in the file distinguishes them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from stiction._checks import Floats
from stiction.surfaces.measured.raw import FileCaveat, FormatError

MIN_GRID_POINTS = 9
MAX_GRID_NODES_PER_LISTED_POINT = 2
# Maximum number of columns in a list of points: coordinates and, for example, colours, intensity and normal vectors.
MAX_POINT_COLUMNS = 12
MIN_POINT_ROWS = 12
MAX_STATISTIC_LINES = 6
# Tolerance for recognizing a line of statistics in a matrix, as a fraction of the standard deviation of the heights.
MAX_STATISTIC_DEVIATION = 2e-3
MAX_WRAPPED_COLUMNS = 32
MIN_WRAPPED_LINES = 3
# Unless a map is more than this many times as likely as a wrapped profile, a matrix gets a caveat about wrapping.
MAX_MAP_TO_PROFILE_LIKELIHOOD_RATIO = 100.0
# The search for wrapped profiles ignores heights at more than this many median deviations from the median height.
MAX_HEIGHT_DEVIATION_IN_MEDIAN_DEVIATIONS = 8.0
# In a wrapped profile, neighbours in a column have a larger mean square difference than neighbours in a line.
MIN_COLUMN_TO_LINE_DIFFERENCE_RATIO = 2.0

_SUMMARY_STATISTICS: tuple[tuple[str, Callable[..., Any]], ...] = (
    ("means", np.mean), ("standard deviations", np.std),
    ("sample standard deviations", lambda x, axis: np.std(x, axis, ddof=1)),
    ("sums", np.sum), ("medians", np.median), ("maxima", np.max), ("minima", np.min), ("ranges", np.ptp),
    ("mean square roots", lambda x, axis: np.sqrt(np.mean(x**2, axis))),
    ("mean deviations", lambda x, axis: np.mean(np.abs(x - np.mean(x, axis, keepdims=True)), axis)),
)  # fmt: skip


def reject_points_and_statistics(values: Floats, column_numbers: Sequence[int]) -> None:
    """Raise `FormatError` if a table lists the coordinates of points or contains statistics, and not only heights."""
    if min(values.shape) < 3 and values.shape[1] != 3:
        return
    count = values.shape[1]
    if values.shape[0] <= MAX_POINT_COLUMNS and (rows := find_grid_columns(values.T)) is not None:
        raise FormatError(
            f"has {values.shape[0]} rows, of which rows {rows[0]} and {rows[1]}, counted from 0, are the coordinates "
            "of a grid; write x, y and z in columns, one point per line"
        )
    if (grid_columns := find_grid_columns(values)) is not None:
        x, y = grid_columns
        other_columns = [column for column in range(count) if column not in grid_columns]
        z = column_numbers[next((column for column in other_columns if column > x), other_columns[0])]
        raise FormatError(
            f"has {count} columns without names, and columns {column_numbers[x]} and {column_numbers[y]} are the "
            f"coordinates of a grid; choose x, y and z (--columns {column_numbers[x]},{column_numbers[y]},{z})"
        )
    if (description := _describe_unlike_columns(values, column_numbers)) is not None:
        raise FormatError(
            f"has {count} columns without names, and {description}, unlike the heights of a map; choose the columns "
            "of x, y and z (--columns 0,1,2), or of positions and heights"
        )
    if (description := _find_statistics(values)) is not None:
        raise FormatError(f"has {description}; leave only heights in the file")


def reject_coordinates_listed_before_heights(column: Floats) -> None:
    """Raise `FormatError` if a column lists all x coordinates of grid points, then all y, and then all heights."""
    if column.size % 3 or column.size < 3 * MIN_GRID_POINTS:
        return
    points = column.reshape(3, -1).T
    # In a list of grid points, x or y changes in equal steps while the other coordinate is constant.
    first_steps, second_steps = np.diff(points[:3, :2], axis=0)
    if np.allclose(first_steps, second_steps, rtol=0.01, atol=0.0) and find_grid_columns(points) == (0, 1):
        raise FormatError("lists all x, then all y and all z; write x, y and z in columns, one point per line")


def reject_separate_blocks(lengths: Sequence[int], first_lines: Sequence[int]) -> None:
    """Raise `FormatError` if empty lines divide the rows of a table into blocks.

    Empty lines after every row are accepted.
    """
    if len(lengths) < 2 or max(lengths) == 1:
        return
    shown_blocks = [f"{length} from line {line}" for length, line in zip(lengths, first_lines, strict=True)][:4]
    others_text = " and others" if len(lengths) > len(shown_blocks) else ""
    raise FormatError(
        f"has {len(lengths)} blocks of rows with empty lines between them ({', '.join(shown_blocks)}{others_text}), "
        "which may be other scans, statistics or missing points; keep one block, without empty lines"
    )


def find_grid_columns(values: Floats) -> tuple[int, int] | None:
    """Return the two columns of a table that contain the x and y coordinates of points on a grid.

    Returns None if there are no such columns.

    No point may occur twice, and the points must fill at least half of the grid. Points that do not fill the whole grid
    must be listed line by line. Other columns, such as point numbers or colours, may stand before, between or behind
    the coordinates.
    """
    rows, count = values.shape
    if count < 3 or rows < MIN_GRID_POINTS:
        return None
    positions: dict[int, tuple[int, Any]] = {}
    for column in range(min(count, MAX_POINT_COLUMNS) if count <= MAX_POINT_COLUMNS else 2):
        if np.isfinite(values[:, column]).all():
            distinct, index = np.unique(values[:, column], return_inverse=True)
            if 2 <= distinct.size < rows:
                positions[column] = distinct.size, index
    for first_column, second_column in itertools.combinations(positions, 2):
        (x_count, x_index), (y_count, y_index) = positions[first_column], positions[second_column]
        node_count = x_count * y_count
        if node_count > MAX_GRID_NODES_PER_LISTED_POINT * rows or np.unique(x_index * y_count + y_index).size < rows:
            continue
        steps = (np.diff(values[:, column]) for column in (first_column, second_column))
        if any((step >= 0).all() or (step <= 0).all() for step in steps) or (
            node_count == rows and ((first_column, second_column) == (0, 1) or min(x_count, y_count) > 3)
        ):
            return first_column, second_column
    return None


def _describe_unlike_columns(values: Floats, column_numbers: Sequence[int]) -> str | None:
    """Describe the first column that cannot contain heights, for example because it contains only whole numbers.

    Returns None if all columns may contain heights.
    """
    rows, count = values.shape
    if count > MAX_POINT_COLUMNS or rows < max(MIN_POINT_ROWS, 3 * count) or np.isnan(values).any():
        return None
    is_whole = values == np.round(values)
    whole_columns = np.flatnonzero(is_whole.all(axis=0) & (values != 0).any(axis=0))
    if whole_columns.size and (is_whole.mean(axis=0) < 0.5).any():
        return f"column {column_numbers[int(whole_columns[0])]} has only whole numbers"
    is_constant = np.ptp(values, axis=0) == 0
    inner_constants = np.flatnonzero(
        is_constant & (values[0] != values.min()) & (values[0] != values.max()) & (values[0] != 0)
    )
    if inner_constants.size and not is_constant.all():
        return f"column {column_numbers[int(inner_constants[0])]} has only equal numbers"
    for first_column in range(count - 2):
        if np.allclose((values[:, first_column : first_column + 3] ** 2).sum(axis=1), 1.0, atol=0.02):
            return f"columns {column_numbers[first_column]} to {column_numbers[first_column + 2]} are unit vectors"
    return None


def _find_statistics(values: Floats) -> str | None:
    """Describe statistics, such as means, in the outer rows or columns of a matrix; return None if there are none."""
    for axis, line_kind in ((0, "row"), (1, "column")):
        lines = values if axis == 0 else values.T
        for side, ordered_lines in (("last", lines), ("first", lines[::-1])):
            # Few matrices contain lines of statistics, so all columns are checked only if a few columns contain one.
            sample = np.linspace(0, lines.shape[1] - 1, min(8, lines.shape[1])).astype(int)
            for count in range(1, min(MAX_STATISTIC_LINES, lines.shape[0] - 4) + 1):
                name = _find_statistic_name(ordered_lines[:, sample], count)
                if name is not None and _find_statistic_name(ordered_lines, count) == name:
                    return f"{name} in its {side} {line_kind}s" if count > 1 else f"{name} in its {side} {line_kind}"
    return None


def _find_statistic_name(lines: Floats, count: int) -> str | None:
    """Return the name of a statistic, such as the mean, that a table's last line contains, or None if there is none.

    The statistic is computed from all lines except the last `count` lines.
    """
    heights, last_line = lines[:-count], lines[-1]
    if not np.isfinite(lines).all():
        return None
    tolerance = MAX_STATISTIC_DEVIATION * float(heights.std())
    # Equal heights always equal their mean, so a line of such heights does not count as a line of statistics.
    if min(float(np.median(np.ptp(heights, axis=0))), float(np.ptp(last_line))) <= 50 * tolerance:
        return None
    for name, statistic in _SUMMARY_STATISTICS:
        if np.abs(statistic(heights, axis=0) - last_line).max() <= tolerance:
            return name
    return None


def find_wrapped_profile_caveat(values: Floats) -> tuple[FileCaveat, ...]:
    """Return a caveat if a matrix may be a single long profile that is wrapped into rows.

    The end of a row is usually far from the start of the next row in a matrix, but close to it in a wrapped profile.
    """
    lines, count = values.shape
    if count > MAX_WRAPPED_COLUMNS or lines < MIN_WRAPPED_LINES or count < 3:
        return ()
    finite_values = values[np.isfinite(values)]
    if finite_values.size < values.size / 2:
        return ()
    # Outliers and codes for missing points would dominate the mean square differences.
    deviations = np.abs(values - np.median(finite_values))
    max_deviation = MAX_HEIGHT_DEVIATION_IN_MEDIAN_DEVIATIONS * np.median(deviations[np.isfinite(values)])
    heights = np.where(deviations <= max_deviation, values, np.nan)
    steps_at_wrap = heights[1:, 0] - heights[:-1, -1]
    difference_along, difference_across, difference_at_wrap = (
        float(np.nanmean(steps**2)) if np.isfinite(steps).any() else np.nan
        for steps in (np.diff(heights, axis=1), np.diff(heights, axis=0), steps_at_wrap)
    )
    if not (difference_along > 0 and MIN_COLUMN_TO_LINE_DIFFERENCE_RATIO * difference_along <= difference_across):
        return ()
    difference_ratio = difference_across / difference_along
    num_wraps = np.count_nonzero(np.isfinite(steps_at_wrap))
    # Logarithm of (likelihood of a map) / (likelihood of a wrapped profile) for normally distributed differences.
    log_likelihood_ratio = (
        num_wraps / 2 * (difference_at_wrap / difference_along * (1 - 1 / difference_ratio) - np.log(difference_ratio))
    )
    if not log_likelihood_ratio <= np.log(MAX_MAP_TO_PROFILE_LIKELIHOOD_RATIO):
        return ()
    return (
        FileCaveat(
            "wrapped",
            f"heights may continue from the end of each line to the next, like a profile in lines of {count}",
            "if it is a profile, write one height per line; otherwise accept it",
        ),
    )  # fmt: skip
