"""Points of a scan without a height: how they are bridged, how large the holes are, and points that stand out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._shown import with_unit

OUTLYING = 6.0
"""Robust standard deviations (1.4826 median absolute deviations) of points from their neighbours, from which on a
single point is an outlier."""

_NEAR = {1: 31, 2: 7}  # points along each axis that are near, of lines and of areas
_FEWEST = 3  # pairs of neighbours, of which one may have an outlier of its own


def bridged(heights: Floats, *, beyond: bool) -> Floats:
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


def largest_hole(missing: NDArray[np.bool_]) -> tuple[int, tuple[slice, ...]]:
    """Points of the largest connected hole, and the box that it lies in."""
    from scipy.ndimage import find_objects, label

    numbers, _ = label(missing, np.ones((3,) * missing.ndim))
    points = np.bincount(numbers.ravel())[1:]
    largest = int(np.argmax(points))
    return int(points[largest]), find_objects(numbers)[largest]


def words_of_holes(missing: NDArray[np.bool_], spacing: tuple[float, ...]) -> str:
    """What part of all points is missing, and where the largest hole is."""
    points, box = largest_hole(missing)
    ends = [
        f"{axis} {with_unit(each.start * step, 'µm')} to {with_unit(each.stop * step, 'µm')}"
        for axis, each, step in zip("xy", box[::-1], spacing[::-1], strict=False)
    ]
    return f"{100 * missing.mean():.2g} % of all; the largest hole has {points}, at {', '.join(ends)}"


def outliers_of(heights: Floats) -> NDArray[np.bool_]:
    """Single points that are off the median of means of opposite neighbours, which slopes do not move."""
    from scipy.ndimage import label, median_filter

    reach, sides = (3, [(1,), (2,), (3,)]) if heights.ndim == 1 else (1, [(0, 1), (1, 0), (1, 1), (1, -1)])
    padded = np.pad(heights, reach, constant_values=np.nan)

    def moved(steps: tuple[int, ...], sign: int) -> Floats:
        at = zip(steps, heights.shape, strict=True)
        return padded[tuple(slice(reach + sign * step, reach + sign * step + size) for step, size in at)]

    means = np.stack([(moved(steps, 1) + moved(steps, -1)) / 2 for steps in sides])
    judged = (np.isfinite(means).sum(axis=0) >= _FEWEST) & np.isfinite(heights)
    if not judged.any():
        return np.asarray(judged)
    off = np.zeros(heights.shape)
    off[judged] = np.abs(heights[judged] - np.nanmedian(means[:, judged], axis=0))
    usual = np.median(off[judged])
    far = off > OUTLYING * 1.4826 * usual
    numbers, _ = label(far, np.ones((3,) * heights.ndim))
    # A worn surface is smoother on its plateaus than in its valleys: a point stands out of those near as well.
    near = median_filter(np.where(judged, off, usual), size=_NEAR[heights.ndim])
    return np.asarray(far & (np.bincount(numbers.ravel())[numbers] == 1) & (off > OUTLYING * 1.4826 * near))
