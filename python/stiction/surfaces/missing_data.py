"""Missing data and outliers in scans: interpolation of gaps, the largest gap, and outlier detection."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._repr import format_with_unit

MIN_OUTLIER_DEVIATIONS = 6.0
"""Smallest deviation of an outlier from its neighbours, in robust standard deviations.

The robust standard deviation is 1.4826 times the median absolute deviation.
"""
MAX_OUTLIER_GROUP_SIZE = 4  # maximum number of adjacent outliers; a larger group is a feature of the surface

_WINDOW_WIDTHS = {1: 31, 2: 7}  # width of the local window in points, for profiles (1) and for maps (2)
# Minimum number of estimates of a height from neighbouring points.
# Three estimates are enough even if one of them is affected by another outlier.
_MIN_NEIGHBOUR_ESTIMATES = 3
# Maximum number of lines that may pass near an outlier by chance.
# These lines connect neighbouring points, and there are at least five of them.
_MAX_COINCIDENT_LINES = 2
_MAX_OUTLIER_PASSES = 8
# The scatter of edge points is estimated separately only if there are at least this many edge points.
_MIN_EDGE_POINTS = 20


def interpolate_missing_points(heights: Floats, *, extrapolate: bool) -> Floats:
    """Interpolate gaps (NaN) linearly along x, then along y.

    With `extrapolate`, gaps at an edge are filled with the nearest height.
    """
    filled_heights = heights.copy()
    for to_edge in (False, True)[: 1 + extrapolate]:
        for lines in (filled_heights, filled_heights.T) if filled_heights.ndim == 2 else (filled_heights[np.newaxis],):
            for line in lines:
                measured_indices = np.flatnonzero(~np.isnan(line))
                if 0 < measured_indices.size < line.size:
                    target_indices = (
                        np.arange(line.size) if to_edge else np.arange(measured_indices[0], measured_indices[-1] + 1)
                    )
                    line[target_indices] = np.interp(target_indices, measured_indices, line[measured_indices])
    return filled_heights


def find_largest_gap(missing: NDArray[np.bool_]) -> tuple[int, tuple[slice, ...]]:
    """Return the number of points in the largest connected gap, and its bounding box."""
    from scipy.ndimage import find_objects, label

    gap_numbers, _ = label(missing, np.ones((3,) * missing.ndim))
    gap_sizes = np.bincount(gap_numbers.ravel())[1:]
    largest_index = int(np.argmax(gap_sizes))
    return int(gap_sizes[largest_index]), find_objects(gap_numbers)[largest_index]


def describe_missing_points(missing: NDArray[np.bool_], spacing: tuple[float, ...]) -> str:
    """Describe the fraction of missing points and the position of the largest gap."""
    points, bounding_box = find_largest_gap(missing)
    ends = [
        f"{axis} {format_with_unit(extent.start * step, 'µm')} to {format_with_unit(extent.stop * step, 'µm')}"
        for axis, extent, step in zip("xy", bounding_box[::-1], spacing[::-1], strict=False)
    ]
    count_text = "1 point" if points == 1 else f"{points} points"
    return f"{100 * missing.mean():.2g} % of all points; the largest gap has {count_text}, at {', '.join(ends)}"


def find_outliers(heights: Floats) -> NDArray[np.bool_]:
    """Find single points or groups of up to four points that deviate from their neighbours.

    Parameters
    ----------
    heights : (n,) or (rows, columns) ndarray of float
        NaN at missing points.

    Notes
    -----
    An outlier deviates from the median of the means of opposite neighbours (which is independent of the slope), and
    from the lines through two neighbours on nearly all sides (a cusp or an edge continues along one of these lines).
    Both deviations are compared with the robust standard deviation of the whole scan and of the neighbourhood. The
    largest outliers are removed first and the test is repeated, so that outliers do not mask each other.
    """
    from scipy.ndimage import label, maximum_filter

    is_measured, remaining_heights, is_outlier = np.isfinite(heights), heights.copy(), np.zeros(heights.shape, np.bool_)
    typical_deviations: list[Floats] = []
    for _ in range(_MAX_OUTLIER_PASSES):
        mean_deviations, line_deviations, at_edge = _deviations_from_neighbours(heights, remaining_heights)
        is_judged = is_measured & ~is_outlier & np.isfinite(line_deviations)
        if not typical_deviations:
            typical_deviations = [
                np.asarray(_typical_deviations(mean_deviations, is_measured, np.zeros_like(is_measured))),
                np.asarray(_typical_deviations(line_deviations, is_measured, at_edge)),
            ]
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.fmin(mean_deviations / typical_deviations[0], line_deviations / typical_deviations[1])
        ratio = np.where(is_judged & np.isfinite(remaining_heights) & ~np.isnan(ratio), ratio, 0.0)
        is_local_maximum = (ratio > MIN_OUTLIER_DEVIATIONS * 1.4826) & (ratio >= maximum_filter(ratio, size=3))
        if not is_local_maximum.any():
            break
        is_outlier |= is_local_maximum
        remaining_heights[is_local_maximum] = np.nan
    group_numbers, _ = label(is_outlier, np.ones((3,) * heights.ndim))
    return np.asarray(is_outlier & (np.bincount(group_numbers.ravel())[group_numbers] <= MAX_OUTLIER_GROUP_SIZE))


def _typical_deviations(distances: Floats, is_measured: NDArray[np.bool_], at_edge: NDArray[np.bool_]) -> Floats:
    """Return, for each point, the median deviation over all points or over its neighbourhood, whichever is larger.

    Edge points are treated separately.
    """
    from scipy.ndimage import median_filter

    typical_values = np.zeros(distances.shape)
    for group_mask in (~at_edge, at_edge):
        values = distances[group_mask & is_measured & np.isfinite(distances)]
        if values.size >= _MIN_EDGE_POINTS:
            typical_values[group_mask | (typical_values == 0)] = np.median(values)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(is_measured & np.isfinite(distances) & (typical_values > 0), distances / typical_values, 1.0)
    # A worn surface is smoother on plateaus than in valleys.
    # Points are therefore also compared with their neighbourhood.
    return np.asarray(typical_values * np.maximum(median_filter(ratio, size=_WINDOW_WIDTHS[distances.ndim]), 1.0))


def _deviations_from_neighbours(heights: Floats, remaining_heights: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Return deviations from means of neighbours, deviations from lines through neighbours, and a mask of edge points.

    Deviations are NaN at points with too few measured neighbours.
    """
    neighbour_steps: list[tuple[int, ...]] = [(1,), (2,), (3,), (4,)]
    if heights.ndim == 2:
        neighbour_steps = [(0, 1), (1, 0), (1, 1), (1, -1)]
    padding = 2 * max(map(max, neighbour_steps))
    padded_heights = np.pad(remaining_heights, padding, constant_values=np.nan)

    def shifted_heights(step: tuple[int, ...], multiple: int) -> Floats:
        index = zip(step, heights.shape, strict=True)
        return padded_heights[
            tuple(slice(padding + multiple * offset, padding + multiple * offset + size) for offset, size in index)
        ]

    neighbour_means = np.stack([(shifted_heights(step, 1) + shifted_heights(step, -1)) / 2 for step in neighbour_steps])
    mean_deviations = np.abs(heights - _finite_median(neighbour_means, _MIN_NEIGHBOUR_ESTIMATES))
    extrapolations = [
        np.stack([2 * shifted_heights(step, sign) - shifted_heights(step, 2 * sign) for step in neighbour_steps])
        for sign in (1, -1)
    ]
    # Each height is extrapolated from both sides in profiles, and from eight directions in maps.
    extrapolated_heights = (
        np.stack([_finite_median(extrapolation[:3], 1) for extrapolation in extrapolations])
        if heights.ndim == 1
        else np.concatenate(extrapolations)
    )
    line_deviations = np.sort(np.abs(heights - extrapolated_heights), axis=0)  # NaN is sorted last
    count = np.isfinite(line_deviations).sum(axis=0)
    if heights.ndim == 1:
        return mean_deviations, line_deviations[0], count < len(extrapolated_heights)
    at_edge = count < len(extrapolated_heights)
    line_deviation = np.where(
        count > _MAX_COINCIDENT_LINES + _MIN_NEIGHBOUR_ESTIMATES - 1,
        line_deviations[_MAX_COINCIDENT_LINES],
        line_deviations[0],
    )
    return mean_deviations, np.where(count < _MIN_NEIGHBOUR_ESTIMATES, np.nan, line_deviation), at_edge


def _finite_median(values: Floats, min_count: int) -> Floats:
    """Return the median of the finite values along the first axis, or NaN if there are fewer than `min_count`."""
    sorted_values = np.sort(values, axis=0)  # NaN is sorted last
    count = np.isfinite(sorted_values).sum(axis=0)
    lower, upper = np.maximum(count - 1, 0) // 2, np.minimum(count // 2, len(values) - 1)
    middle_values = (np.take_along_axis(sorted_values, index[np.newaxis], axis=0)[0] for index in (lower, upper))
    return np.asarray(np.where(count >= min_count, sum(middle_values) / 2, np.nan))
