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
# With three estimates, one estimate may contain another outlier.
_MIN_NEIGHBOUR_ESTIMATES = 3
# Maximum number of lines through neighbouring points, out of at least five, that may pass near an outlier by chance.
_MAX_COINCIDENT_LINES = 2
_MAX_OUTLIER_PASSES = 8
# The scatter of edge points is estimated separately only if there are at least this many edge points.
_MIN_EDGE_POINTS = 20


def interpolate_missing(heights: Floats, *, extrapolate: bool) -> Floats:
    """Interpolate gaps (NaN) linearly along x, then along y.

    With `extrapolate`, gaps at an edge are filled with the nearest height.
    """
    filled = heights.copy()
    for to_edge in (False, True)[: 1 + extrapolate]:
        for lines in (filled, filled.T) if filled.ndim == 2 else (filled[np.newaxis],):
            for line in lines:
                is_measured = np.flatnonzero(~np.isnan(line))
                if 0 < is_measured.size < line.size:
                    inside = np.arange(line.size) if to_edge else np.arange(is_measured[0], is_measured[-1] + 1)
                    line[inside] = np.interp(inside, is_measured, line[is_measured])
    return filled


def find_largest_gap(missing: NDArray[np.bool_]) -> tuple[int, tuple[slice, ...]]:
    """Return the number of points in the largest connected gap, and its bounding box."""
    from scipy.ndimage import find_objects, label

    numbers, _ = label(missing, np.ones((3,) * missing.ndim))
    points = np.bincount(numbers.ravel())[1:]
    largest = int(np.argmax(points))
    return int(points[largest]), find_objects(numbers)[largest]


def describe_missing(missing: NDArray[np.bool_], spacing: tuple[float, ...]) -> str:
    """Describe the fraction of missing points and the position of the largest gap."""
    points, box = find_largest_gap(missing)
    ends = [
        f"{axis} {format_with_unit(extent.start * step, 'µm')} to {format_with_unit(extent.stop * step, 'µm')}"
        for axis, extent, step in zip("xy", box[::-1], spacing[::-1], strict=False)
    ]
    count = "1 point" if points == 1 else f"{points} points"
    return f"{100 * missing.mean():.2g} % of all points; the largest gap has {count}, at {', '.join(ends)}"


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

    is_measured, left, result = np.isfinite(heights), heights.copy(), np.zeros(heights.shape, np.bool_)
    usual: list[Floats] = []
    for _ in range(_MAX_OUTLIER_PASSES):
        off_means, off_lines, at_edge = _deviations_from_neighbours(heights, left)
        judged = is_measured & ~result & np.isfinite(off_lines)
        if not usual:
            usual = [
                np.asarray(_typical_deviations(off_means, is_measured, np.zeros_like(is_measured))),
                np.asarray(_typical_deviations(off_lines, is_measured, at_edge)),
            ]
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.fmin(off_means / usual[0], off_lines / usual[1])
        ratio = np.where(judged & np.isfinite(left) & ~np.isnan(ratio), ratio, 0.0)
        highest = (ratio > MIN_OUTLIER_DEVIATIONS * 1.4826) & (ratio >= maximum_filter(ratio, size=3))
        if not highest.any():
            break
        result |= highest
        left[highest] = np.nan
    numbers, _ = label(result, np.ones((3,) * heights.ndim))
    return np.asarray(result & (np.bincount(numbers.ravel())[numbers] <= MAX_OUTLIER_GROUP_SIZE))


def _typical_deviations(distances: Floats, is_measured: NDArray[np.bool_], at_edge: NDArray[np.bool_]) -> Floats:
    """Return, for each point, the median deviation over all points or over its neighbourhood, whichever is larger.

    Edge points are treated separately.
    """
    from scipy.ndimage import median_filter

    usual = np.zeros(distances.shape)
    for part in (~at_edge, at_edge):
        values = distances[part & is_measured & np.isfinite(distances)]
        if values.size >= _MIN_EDGE_POINTS:
            usual[part | (usual == 0)] = np.median(values)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(is_measured & np.isfinite(distances) & (usual > 0), distances / usual, 1.0)
    # A worn surface is smoother on plateaus than in valleys.
    # Points are therefore also compared with their neighbourhood.
    return np.asarray(usual * np.maximum(median_filter(ratio, size=_WINDOW_WIDTHS[distances.ndim]), 1.0))


def _deviations_from_neighbours(heights: Floats, left: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Return deviations from means of neighbours, deviations from lines through neighbours, and a mask of edge points.

    Deviations are NaN at points with too few measured neighbours.
    """
    steps: list[tuple[int, ...]] = [(1,), (2,), (3,), (4,)]
    if heights.ndim == 2:
        steps = [(0, 1), (1, 0), (1, 1), (1, -1)]
    reach = 2 * max(map(max, steps))
    padded = np.pad(left, reach, constant_values=np.nan)

    def shifted_heights(step: tuple[int, ...], times: int) -> Floats:
        index = zip(step, heights.shape, strict=True)
        return padded[tuple(slice(reach + times * offset, reach + times * offset + size) for offset, size in index)]

    means = np.stack([(shifted_heights(step, 1) + shifted_heights(step, -1)) / 2 for step in steps])
    off_means = np.abs(heights - _finite_median(means, _MIN_NEIGHBOUR_ESTIMATES))
    sides = [
        np.stack([2 * shifted_heights(step, sign) - shifted_heights(step, 2 * sign) for step in steps])
        for sign in (1, -1)
    ]
    # Each height is extrapolated from both sides in profiles, and from eight directions in maps.
    lines = np.stack([_finite_median(side[:3], 1) for side in sides]) if heights.ndim == 1 else np.concatenate(sides)
    off_lines = np.sort(np.abs(heights - lines), axis=0)  # sorting puts NaN last
    count = np.isfinite(off_lines).sum(axis=0)
    if heights.ndim == 1:
        return off_means, off_lines[0], count < len(lines)
    at_edge = count < len(lines)
    nearest = np.where(
        count > _MAX_COINCIDENT_LINES + _MIN_NEIGHBOUR_ESTIMATES - 1, off_lines[_MAX_COINCIDENT_LINES], off_lines[0]
    )
    return off_means, np.where(count < _MIN_NEIGHBOUR_ESTIMATES, np.nan, nearest), at_edge


def _finite_median(values: Floats, min_count: int) -> Floats:
    """Return the median of the finite values along the first axis, or NaN if there are fewer than `min_count`."""
    ordered = np.sort(values, axis=0)  # sorting puts NaN last
    count = np.isfinite(ordered).sum(axis=0)
    lower, upper = np.maximum(count - 1, 0) // 2, np.minimum(count // 2, len(values) - 1)
    middle = (np.take_along_axis(ordered, index[np.newaxis], axis=0)[0] for index in (lower, upper))
    return np.asarray(np.where(count >= min_count, sum(middle) / 2, np.nan))
