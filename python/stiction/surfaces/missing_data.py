"""Missing points and outliers of scans: interpolation, largest gap, and detection of outliers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._repr import format_with_unit
from stiction.surfaces.height_step import find_height_step

if TYPE_CHECKING:
    from stiction.surfaces.surface import AnyBody

MIN_OUTLIER_SIGMAS = 6.0
"""Smallest deviation of an outlier from its neighbours, as a multiple of the robust standard deviation.

The robust standard deviation is 1.4826 times the median absolute deviation.
"""
# The standard deviation of normally distributed heights is 1.4826 median absolute deviations.
_MIN_OUTLIER_TO_MEDIAN_DEVIATION_RATIO = MIN_OUTLIER_SIGMAS * 1.4826
# Maximum number of adjacent points that count as outliers: a larger group is a feature of the surface.
MAX_OUTLIER_GROUP_SIZE = 4

# Median deviation of rounded heights from the mean of their neighbours, in rounding steps.
# The median deviation of rounded heights from a line through two neighbours is 0.21 to 0.33 rounding steps.
_MEDIAN_ROUNDING_DEVIATION = 0.25
_FORM_ROUND_OFF_FRACTION = 1e-10
_MAX_FRACTION_OF_SMOOTH_POINTS = 0.25
_MIN_FRACTION_OF_ROUGH_POINTS = 0.02

_WINDOW_WIDTHS = {1: 31, 2: 7}  # points, of profiles and maps
# Minimum number of means over neighbours: the median of three means is robust against an outlier in one of them.
_MIN_NEIGHBOUR_ESTIMATES = 3
# At most this many lines through two neighbours may pass near an outlier that has five or more such lines.
_MAX_LINES_NEAR_OUTLIER = 2
_MAX_OUTLIER_PASSES = 8
# Index offsets from a point to its neighbours, keyed by the number of dimensions: 1 for profiles, 2 for maps.
_NEIGHBOUR_STEPS: dict[int, list[tuple[int, ...]]] = {1: [(1,), (2,), (3,), (4,)], 2: [(0, 1), (1, 0), (1, 1), (1, -1)]}
_MAX_STRIP_POINTS = 16_384
_MAX_WINDOWS_PER_BATCH = 100_000
_MIN_EDGE_POINTS = 20


def interpolate_missing_points(heights: Floats, *, extrapolate: bool) -> Floats:
    """Interpolate missing heights (NaN) linearly between measured points, first along x and then along y.

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


def compute_scattered_missing_fraction(missing: NDArray[np.bool_]) -> float:
    """Return the fraction of all points that are missing between two measured neighbours along x or along y."""
    is_between = np.zeros(missing.shape, np.bool_)
    for axis in range(missing.ndim):
        missing_lines, between_lines = np.moveaxis(missing, axis, -1), np.moveaxis(is_between, axis, -1)
        between_lines[..., 1:-1] |= missing_lines[..., 1:-1] & ~missing_lines[..., :-2] & ~missing_lines[..., 2:]
    return float(is_between.mean())


def find_largest_gap(missing: NDArray[np.bool_]) -> tuple[int, tuple[slice, ...]]:
    """Return the number of points in the largest connected region of missing points, and the region's bounding box."""
    from scipy.ndimage import find_objects, label

    gap_numbers, _ = label(missing, np.ones((3,) * missing.ndim))
    gap_sizes = np.bincount(gap_numbers.ravel())[1:]
    largest_index = int(np.argmax(gap_sizes))
    return int(gap_sizes[largest_index]), find_objects(gap_numbers)[largest_index]


def with_interpolated_points(body: AnyBody, points: NDArray[np.bool_]) -> AnyBody:
    """Return a copy of a body with given points interpolated, or the body itself if nothing can be interpolated.

    The missing points of the body are interpolated again, because their heights may depend on the given points.
    """
    if not points.any():
        return body
    is_unknown = points if body.missing is None else points | body.missing
    if is_unknown.all():
        return body
    heights = interpolate_missing_points(np.where(is_unknown, np.nan, body.heights), extrapolate=True)
    return replace(body, heights=heights)


def describe_missing_points(missing: NDArray[np.bool_], spacing: tuple[float, ...]) -> str:
    """Return text for the history of a body: the fraction of missing points, and the largest gap with its position."""
    points, bounding_box = find_largest_gap(missing)
    region_ends = [
        f"{axis} {format_with_unit(extent.start * step, 'µm')} to {format_with_unit(extent.stop * step, 'µm')}"
        for axis, extent, step in zip("xy", bounding_box[::-1], spacing[::-1], strict=False)
    ]
    count_text = "1 point" if points == 1 else f"{points} points"
    return f"{100 * missing.mean():.2g} % of all points; the largest gap has {count_text}, at {', '.join(region_ends)}"


def find_outliers(heights: Floats, height_step: float | None = None) -> NDArray[np.bool_]:
    """Find the outliers of a scan: groups of one to four points that deviate from neighbouring points.

    Parameters
    ----------
    heights : (n,) or (rows, columns) ndarray of float
        NaN at missing points.
    height_step : float, optional
        Result of `find_height_step`, if it is known.

    Notes
    -----
    An outlier deviates from the median of the means of opposite neighbours (which is independent of the slope), and
    from the lines through two neighbours on nearly all sides (a cusp or an edge continues along one of these lines).
    Both deviations are compared with the robust standard deviation of the whole scan and of the neighbourhood. The
    robust standard deviation of rounded heights is at least that of rounding errors (`find_height_step`). The largest
    outliers are removed first and the test is repeated, so that outliers do not mask each other.
    """
    is_measured, remaining_heights, is_outlier = np.isfinite(heights), heights.copy(), np.zeros(heights.shape, np.bool_)
    typical_deviations: list[_NeighbourDeviations] = []
    step = find_height_step(heights) if height_step is None else height_step
    for _ in range(_MAX_OUTLIER_PASSES):
        mean_deviations, line_deviations, at_edge = _compute_deviations_from_neighbours(heights, remaining_heights)
        if not typical_deviations:
            typical_deviations = [
                _find_neighbour_deviations(mean_deviations, is_measured, np.zeros_like(is_measured), heights, step),
                _find_neighbour_deviations(line_deviations, is_measured, at_edge, heights, step),
            ]
        deviations = mean_deviations, line_deviations
        ratio = _find_smaller_deviation_ratio(deviations, [typical.scan_medians for typical in typical_deviations])
        # Local medians can only reject outliers, so they are computed only where medians of the whole scan find one.
        can_be_outlier = is_measured & ~is_outlier & np.isfinite(line_deviations)
        candidates = np.nonzero(can_be_outlier & (ratio > _MIN_OUTLIER_TO_MEDIAN_DEVIATION_RATIO))
        ratio = np.zeros(heights.shape)
        ratio[candidates] = _find_smaller_deviation_ratio(
            [values[candidates] for values in deviations],
            [typical.at_points(candidates) for typical in typical_deviations],
        )
        is_deviating = ratio > _MIN_OUTLIER_TO_MEDIAN_DEVIATION_RATIO
        if not is_deviating.any():
            break
        # SciPy, whose import takes 0.1 s, is imported only here, because most scans have no outliers.
        from scipy.ndimage import maximum_filter

        is_local_maximum = is_deviating & (ratio >= maximum_filter(ratio, size=3))
        is_outlier |= is_local_maximum
        remaining_heights[is_local_maximum] = np.nan
    if not is_outlier.any():
        return is_outlier
    from scipy.ndimage import label

    group_numbers, _ = label(is_outlier, np.ones((3,) * heights.ndim))
    return np.asarray(is_outlier & (np.bincount(group_numbers.ravel())[group_numbers] <= MAX_OUTLIER_GROUP_SIZE))


def _find_smaller_deviation_ratio(deviations: Sequence[Floats], typical_values: Sequence[Floats]) -> Floats:
    """Return the smaller of two ratios at each point: each ratio is a height deviation divided by its typical value.

    A ratio that is NaN is ignored.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.fmin(deviations[0] / typical_values[0], deviations[1] / typical_values[1])


@dataclass(frozen=True, eq=False)
class _NeighbourDeviations:
    """Deviations of heights from neighbouring heights: their median in the scan, and each deviation over the median.

    Edge points have a different median than other points.
    """

    scan_medians: Floats
    relative_deviations: Floats

    def at_points(self, points: tuple[NDArray[np.intp], ...]) -> Floats:
        """Return the typical deviation (µm) of heights from neighbouring heights, near each of the given points.

        It is the larger of two medians: over a window around the point, and over the whole scan. A worn surface is
        smoother on plateaus than in valleys, so the median of the scan alone is not sufficient.
        """
        width = _WINDOW_WIDTHS[self.relative_deviations.ndim]
        padded_values = np.pad(self.relative_deviations, width // 2, mode="symmetric")
        windows = sliding_window_view(padded_values, (width,) * self.relative_deviations.ndim)
        window_axes = tuple(range(1, 1 + self.relative_deviations.ndim))
        local_medians = np.empty(points[0].size)
        for start in range(0, local_medians.size, _MAX_WINDOWS_PER_BATCH):
            batch = slice(start, start + _MAX_WINDOWS_PER_BATCH)
            local_medians[batch] = np.median(windows[tuple(index[batch] for index in points)], axis=window_axes)
        return np.asarray(self.scan_medians[points] * np.maximum(local_medians, 1.0))


def _find_neighbour_deviations(
    deviations: Floats, is_measured: NDArray[np.bool_], at_edge: NDArray[np.bool_], heights: Floats, step: float
) -> _NeighbourDeviations:
    """Compute median deviations of heights from neighbouring heights: one for edge points and one for inner points.

    `step` is the rounding step of the heights (µm). Where most deviations are at most one step, they may be due to
    rounding, and the region counts as flat. In scans with flat regions, rough regions and their neighbourhoods have the
    median of the rough regions. If heights are not rounded, flat regions were clipped or filled, and the median of the
    rough regions is used everywhere, provided that the rough regions are large enough.
    """
    is_known, width = is_measured & np.isfinite(deviations), _WINDOW_WIDTHS[deviations.ndim]
    is_rough = near_rough_region = np.zeros(deviations.shape, np.bool_)
    round_off = _FORM_ROUND_OFF_FRACTION * float(np.ptp(heights[is_measured])) if is_measured.any() else 0.0
    # Height deviations above this limit (µm) exceed both one rounding step and the round-off.
    resolution = 1.01 * max(step, round_off)
    if is_known.any() and np.quantile(deviations[is_known], _MAX_FRACTION_OF_SMOOTH_POINTS) <= resolution:
        from scipy.ndimage import maximum_filter, median_filter

        is_rough = is_known & (median_filter(np.where(is_known, deviations, 0.0), size=width) > resolution)
        near_rough_region = maximum_filter(is_rough, size=width)
        if step <= round_off and is_rough.sum() >= _MIN_FRACTION_OF_ROUGH_POINTS * is_known.sum():
            near_rough_region[...] = True
    typical_values = np.zeros(deviations.shape)
    for group_mask in (~at_edge, at_edge):
        group_deviations, rough_deviations = (
            deviations[group_mask & points] for points in (is_known, is_known & is_rough)
        )
        if group_deviations.size >= _MIN_EDGE_POINTS:
            group_mask = group_mask | (typical_values == 0)
            typical_value = max(float(np.median(group_deviations)), _MEDIAN_ROUNDING_DEVIATION * resolution)
            typical_values[group_mask] = typical_value
            if rough_deviations.size >= _MIN_EDGE_POINTS:
                typical_values[group_mask & near_rough_region] = max(float(np.median(rough_deviations)), typical_value)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(is_measured & np.isfinite(deviations) & (typical_values > 0), deviations / typical_values, 1.0)
    return _NeighbourDeviations(typical_values, ratio)


def _compute_deviations_from_neighbours(
    heights: Floats, remaining_heights: Floats
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Return two measures of each height's deviation from its neighbours, and a mask of points at the data's edges.

    The first measure compares a height with means of opposite neighbours, and the second with lines through two
    neighbours on one side. Deviations are NaN at points with too few measured neighbours. Maps are evaluated in strips
    of rows, whose intermediate arrays fit into the cache.
    """
    reach = 2 * max(map(max, _NEIGHBOUR_STEPS[heights.ndim]))
    padded_heights = np.pad(remaining_heights, reach, constant_values=np.nan)
    strip_length = heights.size if heights.ndim == 1 else max(_MAX_STRIP_POINTS // heights.shape[1], 1)
    strips = [
        _compute_deviations_in_strip(
            heights[start : start + strip_length], padded_heights[start : start + strip_length + 2 * reach], reach
        )
        for start in range(0, len(heights), strip_length)
    ]
    mean_deviations, line_deviations, at_edge = (np.concatenate(arrays) for arrays in zip(*strips, strict=True))
    return mean_deviations, line_deviations, at_edge


def _compute_deviations_in_strip(
    heights: Floats, padded_heights: Floats, reach: int
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Return, for heights in a strip, two measures of each deviation from neighbours, and a mask of edge points.

    A strip is a range of map rows, or a whole profile.
    """
    neighbour_steps = _NEIGHBOUR_STEPS[heights.ndim]

    def shifted_heights(step: tuple[int, ...], multiple: int) -> Floats:
        index = zip(step, heights.shape, strict=True)
        return padded_heights[
            tuple(slice(reach + multiple * offset, reach + multiple * offset + size) for offset, size in index)
        ]

    neighbour_means = [(shifted_heights(step, 1) + shifted_heights(step, -1)) / 2 for step in neighbour_steps]
    mean_deviations = np.abs(heights - _compute_finite_median(neighbour_means, _MIN_NEIGHBOUR_ESTIMATES))
    extrapolations = [
        [2 * shifted_heights(step, sign) - shifted_heights(step, 2 * sign) for step in neighbour_steps]
        for sign in (1, -1)
    ]
    extrapolated_heights = (
        [_compute_finite_median(extrapolation[:3], 1) for extrapolation in extrapolations]
        if heights.ndim == 1
        else [*extrapolations[0], *extrapolations[1]]
    )
    line_deviations = [np.abs(heights - estimate) for estimate in extrapolated_heights]
    estimate_count = np.sum([np.isfinite(deviation) for deviation in line_deviations], axis=0)
    at_edge = estimate_count < len(line_deviations)
    smallest_deviations = _find_smallest_at_each_point(
        line_deviations, 1 if heights.ndim == 1 else _MAX_LINES_NEAR_OUTLIER + 1
    )
    if heights.ndim == 1:
        return mean_deviations, np.where(estimate_count > 0, smallest_deviations[0], np.nan), at_edge
    line_deviation = np.where(
        estimate_count > _MAX_LINES_NEAR_OUTLIER + _MIN_NEIGHBOUR_ESTIMATES - 1,
        smallest_deviations[_MAX_LINES_NEAR_OUTLIER],
        smallest_deviations[0],
    )
    return mean_deviations, np.where(estimate_count < _MIN_NEIGHBOUR_ESTIMATES, np.nan, line_deviation), at_edge


def _find_smallest_at_each_point(values: list[Floats], kept_count: int) -> list[Floats]:
    """Return, at each point, the `kept_count` smallest of the numbers in several arrays, in ascending order.

    NaN is replaced by infinity.

    For a few arrays, this is faster than sorting.
    """
    smallest_values = [np.full(values[0].shape, np.inf) for _ in range(kept_count)]
    for array in values:
        larger_values = np.where(np.isnan(array), np.inf, array)
        for position, smaller_values in enumerate(smallest_values):
            smallest_values[position], larger_values = (
                np.minimum(smaller_values, larger_values),
                np.maximum(smaller_values, larger_values),
            )
    return smallest_values


def _compute_finite_median(values: list[Floats], min_count: int) -> Floats:
    """Return, at each point, the median of the finite numbers in several arrays.

    Returns NaN for fewer than `min_count`.
    """
    sorted_values = np.stack(_find_smallest_at_each_point(values, len(values)))
    count = np.isfinite(sorted_values).sum(axis=0)
    lower_index, upper_index = np.maximum(count - 1, 0) // 2, np.minimum(count // 2, len(values) - 1)
    middle_values = (
        np.take_along_axis(sorted_values, index[np.newaxis], axis=0)[0] for index in (lower_index, upper_index)
    )
    return np.asarray(np.where(count >= min_count, sum(middle_values) / 2, np.nan))
