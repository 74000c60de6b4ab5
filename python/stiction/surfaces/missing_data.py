"""Points of a scan without a height: how they are bridged, how large the holes are, and points that stand out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._shown import with_unit

MIN_OUTLIER_DEVIATIONS = 6.0
"""Robust standard deviations (1.4826 median absolute deviations) from neighbours above which points are outliers."""
MAX_OUTLIER_GROUP = 4  # outliers that may touch each other: more are a feature of the surface

_NEAR = {1: 31, 2: 7}  # points along each axis that are near, of lines and of areas
_FEWEST = 3  # pairs of neighbours, or lines, of which one may have an outlier of its own
_MAX_LINES = 2  # lines of five or more that a point may lie on and stand out all the same
_MAX_ROUNDS = 8
_MIN_POINTS = 20  # points at edges below which their distances are judged by those inside


def interpolate_missing(heights: Floats, *, beyond: bool) -> Floats:
    """Heights with straight lines over holes (NaN) along x, or else y; `beyond` takes those at an edge on to it."""
    full = heights.copy()
    for to_edge in (False, True)[: 1 + beyond]:
        for lines in (full, full.T) if full.ndim == 2 else (full[np.newaxis],):
            for line in lines:
                known = np.flatnonzero(~np.isnan(line))
                if 0 < known.size < line.size:
                    inside = np.arange(line.size) if to_edge else np.arange(known[0], known[-1] + 1)
                    line[inside] = np.interp(inside, known, line[known])
    return full


def find_largest_gap(missing: NDArray[np.bool_]) -> tuple[int, tuple[slice, ...]]:
    """Points of the largest connected hole, and the box that it lies in."""
    from scipy.ndimage import find_objects, label

    numbers, _ = label(missing, np.ones((3,) * missing.ndim))
    points = np.bincount(numbers.ravel())[1:]
    largest = int(np.argmax(points))
    return int(points[largest]), find_objects(numbers)[largest]


def describe_missing(missing: NDArray[np.bool_], spacing: tuple[float, ...]) -> str:
    """What part of all points is missing, and where the largest hole is."""
    points, box = find_largest_gap(missing)
    ends = [
        f"{axis} {with_unit(each.start * step, 'µm')} to {with_unit(each.stop * step, 'µm')}"
        for axis, each, step in zip("xy", box[::-1], spacing[::-1], strict=False)
    ]
    return f"{100 * missing.mean():.2g} % of all; the largest hole has {points}, at {', '.join(ends)}"


def find_outliers(heights: Floats) -> NDArray[np.bool_]:
    """Find points that stand out alone or in groups of up to four, at edges as well.

    Parameters
    ----------
    heights : (n,) or (rows, columns) ndarray of float
        NaN where there is no height.

    Notes
    -----
    A point stands out if it is off the median of the means of opposite neighbours, which slopes do not move, and off
    lines through two neighbours on nearly all sides: a cusp or an edge goes on along one of these lines. Both are
    measured in robust deviations of the whole scan and of the points near. The points that stand out most are taken out
    first, and what is left is judged again, so that they do not hide each other.
    """
    from scipy.ndimage import label, maximum_filter

    known, left, found = np.isfinite(heights), heights.copy(), np.zeros(heights.shape, np.bool_)
    usual: list[Floats] = []
    for _ in range(_MAX_ROUNDS):
        off_means, off_lines, at_edge = _off_neighbours(heights, left)
        judged = known & ~found & np.isfinite(off_lines)
        if not usual:
            usual = [
                np.asarray(_usual_distance(off_means, known, np.zeros_like(known))),
                np.asarray(_usual_distance(off_lines, known, at_edge)),
            ]
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.fmin(off_means / usual[0], off_lines / usual[1])
        ratio = np.where(judged & np.isfinite(left) & ~np.isnan(ratio), ratio, 0.0)
        highest = (ratio > MIN_OUTLIER_DEVIATIONS * 1.4826) & (ratio >= maximum_filter(ratio, size=3))
        if not highest.any():
            break
        found |= highest
        left[highest] = np.nan
    numbers, _ = label(found, np.ones((3,) * heights.ndim))
    return np.asarray(found & (np.bincount(numbers.ravel())[numbers] <= MAX_OUTLIER_GROUP))


def _usual_distance(distances: Floats, known: NDArray[np.bool_], at_edge: NDArray[np.bool_]) -> Floats:
    """Median distance of all points, or of those near a point where it is larger; points at edges have their own."""
    from scipy.ndimage import median_filter

    usual = np.zeros(distances.shape)
    for part in (~at_edge, at_edge):
        values = distances[part & known & np.isfinite(distances)]
        if values.size >= _MIN_POINTS:
            usual[part | (usual == 0)] = np.median(values)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(known & np.isfinite(distances) & (usual > 0), distances / usual, 1.0)
    # A worn surface is smoother on its plateaus than in its valleys: a point stands out of those near as well.
    return np.asarray(usual * np.maximum(median_filter(ratio, size=_NEAR[distances.ndim]), 1.0))


def _off_neighbours(heights: Floats, left: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Distances of points from means of opposite neighbours and from lines through two neighbours, and edge points.

    NaN where there are too few neighbours among the points that are left.
    """
    steps: list[tuple[int, ...]] = [(1,), (2,), (3,), (4,)]
    if heights.ndim == 2:
        steps = [(0, 1), (1, 0), (1, 1), (1, -1)]
    reach = 2 * max(map(max, steps))
    padded = np.pad(left, reach, constant_values=np.nan)

    def moved(step: tuple[int, ...], times: int) -> Floats:
        at = zip(step, heights.shape, strict=True)
        return padded[tuple(slice(reach + times * each, reach + times * each + size) for each, size in at)]

    means = np.stack([(moved(step, 1) + moved(step, -1)) / 2 for step in steps])
    off_means = np.abs(heights - _median(means, _FEWEST))
    sides = [np.stack([2 * moved(step, sign) - moved(step, 2 * sign) for step in steps]) for sign in (1, -1)]
    # Of lines one value for each of both sides, of maps one for each of eight.
    lines = np.stack([_median(each[:3], 1) for each in sides]) if heights.ndim == 1 else np.concatenate(sides)
    off_lines = np.sort(np.abs(heights - lines), axis=0)  # NaN last
    count = np.isfinite(off_lines).sum(axis=0)
    if heights.ndim == 1:
        return off_means, off_lines[0], count < len(lines)
    at_edge = count < len(lines)
    nearest = np.where(count > _MAX_LINES + _FEWEST - 1, off_lines[_MAX_LINES], off_lines[0])
    return off_means, np.where(count < _FEWEST, np.nan, nearest), at_edge


def _median(values: Floats, fewest: int) -> Floats:
    """Median along the first axis of the values that are finite; NaN where these are too few."""
    ordered = np.sort(values, axis=0)  # NaN last
    count = np.isfinite(ordered).sum(axis=0)
    lower, upper = np.maximum(count - 1, 0) // 2, np.minimum(count // 2, len(values) - 1)
    middle = (np.take_along_axis(ordered, each[np.newaxis], axis=0)[0] for each in (lower, upper))
    return np.asarray(np.where(count >= fewest, sum(middle) / 2, np.nan))
