"""Profile elements of ISO 21920. An element is a hill above the mean line and a neighbouring dale below it."""

from __future__ import annotations

import math

import numpy as np

from stiction._checks import Floats

# A hill is counted if its height exceeds this fraction of Rp, and a dale if its depth exceeds this fraction of Rv.
HEIGHT_DISCRIMINATION_FRACTION = 0.1


def profile_elements(heights: Floats, peak: float, pit: float) -> tuple[Floats, Floats]:
    """Return the spacing (in points) and the height of each profile element: a hill with an adjacent dale.

    A hill is counted if it rises above a tenth of the peak height, and a dale if it falls below a tenth of the pit
    depth; both limits must be above 0. An element is a hill and the following dale, or a dale and the following hill.
    Both features of an element end at crossings of the mean line, interpolated between points. If the profile crosses
    the line several times between a counted hill and a counted dale, the end is the mean of the first and the last of
    these crossings.
    """
    sign = np.zeros(heights.size, np.int8)
    sign[heights > HEIGHT_DISCRIMINATION_FRACTION * peak] = 1
    sign[heights < -HEIGHT_DISCRIMINATION_FRACTION * pit] = -1
    counted_points = np.flatnonzero(sign)
    sign_changes = np.flatnonzero(np.diff(sign[counted_points]))
    last_points, next_points = counted_points[sign_changes], counted_points[sign_changes + 1]
    is_above = heights > 0
    crossings = np.flatnonzero(is_above[:-1] != is_above[1:])
    if last_points.size < 3:
        return np.empty(0), np.empty(0)
    crossing_positions = crossings + heights[crossings] / (heights[crossings] - heights[crossings + 1])
    first_crossing = crossing_positions[np.searchsorted(crossings, last_points)]
    last_crossing = crossing_positions[np.searchsorted(crossings, next_points) - 1]
    feature_ends = (first_crossing + last_crossing) / 2
    starts = np.ceil(feature_ends).astype(np.intp)
    highest_points = np.maximum.reduceat(heights, starts)[:-1]
    lowest_points = np.minimum.reduceat(heights, starts)[:-1]
    tops, bottoms = (
        np.maximum(highest_points[:-1], highest_points[1:]),
        np.minimum(lowest_points[:-1], lowest_points[1:]),
    )
    return feature_ends[2:] - feature_ends[:-2], tops - bottoms


def mean_profile_element(heights: Floats, peak: float, pit: float) -> tuple[float, float]:
    """Return the mean spacing (in points) and the mean height of profile elements.

    Returns NaN if there are no elements.
    """
    spacings, element_heights = profile_elements(heights, peak, pit)
    if not spacings.size:
        return math.nan, math.nan
    return float(spacings.mean()), float(element_heights.mean())
