"""Registration of two mating faces: the shift and the rotation of the upper face at which the gap is smallest.

Faces fit if their slopes agree at one relative position only. Slopes are compared, because the heights of unrelated
surfaces often agree in their longest wavelengths.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from stiction._checks import Floats
from stiction.surfaces.preparation import inscribed_rectangle, interpolate_rotated, levelled, rotated
from stiction.surfaces.profile import Profile, combine_missing_masks, select_from_mask
from stiction.surfaces.surface import Surface

MAX_ROTATION = 3.0  # degrees
ROTATION_STEP = 0.5  # degrees
# A shift is rounded to whole points if it puts all points within this distance (points) of points of the other grid.
WHOLE_POINT_SHIFT_TOLERANCE = 0.02
MAX_SECOND_CORRELATION_RATIO = 0.7
MIN_OVERLAP_FRACTION = 0.5
_MIN_COARSE_POINTS = {1: 64, 2: 16}
_MAX_COARSE_POINTS = {1: 2048, 2: 128}
_MAX_REFINEMENTS = 20
_GAUSS_NEWTON_STEP_FRACTIONS = (1.0, 0.5, 0.25)
# The registration has converged if a step moves the corners of the upper face by less than this distance (points).
_CONVERGENCE_DISTANCE = 1e-4
_CORRELATION_PEAK_HALF_WIDTH_FRACTION = 0.05


@dataclass(frozen=True)
class Registration:
    """Result of registering two faces: shift and rotation of the upper face, slope correlation, rms gaps.

    Attributes
    ----------
    shift : tuple of float, µm
        Shift of the middle of the upper face along y and x, or along x for profiles.
    rotation : float, degrees
        Rotation of the upper face, from +x towards +y.
    rms_gap_before, rms_gap : float, µm
        Root-mean-square gap, after subtracting a plane or line, of the given and of the registered faces.
    correlation : float
        Correlation of the slopes of both faces: 1 for a perfect fit, about 0 for unrelated faces.
    gap_noise : float, µm
        Noise of the registered gap, if it is independent from point to point.
    """

    shift: tuple[float, ...]
    rotation: float
    rms_gap_before: float
    rms_gap: float
    correlation: float
    gap_noise: float


@dataclass(frozen=True)
class _FacePosition:
    """Position of the upper face relative to the lower face: shift of its middle (µm), and rotation (radians)."""

    shift: tuple[float, ...]
    rotation: float


def register_faces(upper: Any, lower: Any) -> tuple[Any, Any, Registration]:
    """Move the upper of two faces to the position of best fit.

    Returns the overlapping parts of both faces, and the position.

    The spacings of both bodies must be equal. The upper face is rotated (maps only), shifted, and tilted so that the
    gap has no slope on average. The upper face is interpolated by a cubic spline, unless it fits after a shift by whole
    points without a rotation.
    """
    rms_gap_before = _measure_rms_gap(*_cut_overlap(upper, lower, (0,) * lower.heights.ndim))
    factor = _choose_block_size(upper, lower)
    coarse_upper, coarse_lower = _coarsen_face(upper, factor), _coarsen_face(lower, factor)
    position = _refine_position(coarse_upper, coarse_lower, _find_coarse_position(coarse_upper, coarse_lower))
    if factor > 1:
        position = _refine_position(upper, lower, _to_full_grid(position, upper, lower, factor))
    offset = _find_grid_offset(upper, lower, position)
    if offset is None:
        upper_overlap, lower_overlap = _interpolate_overlap(upper, lower, position)
    else:
        upper_overlap, lower_overlap = _cut_overlap(upper, lower, offset)
        position = _FacePosition(_convert_corner_offset_to_centre_shift(offset, upper, lower), 0.0)
    gap = _compute_gap(upper_overlap, lower_overlap)
    upper_overlap = upper_overlap.changed(lower_overlap.heights + gap.heights, "registered")
    registration = Registration(
        position.shift, math.degrees(position.rotation), rms_gap_before, _measure_rms_gap(upper_overlap, lower_overlap),
        correlate_facing_slopes(upper_overlap, lower_overlap), _estimate_noise(gap),
    )  # fmt: skip
    return upper_overlap, lower_overlap, registration


def measure_fit(upper: Any, lower: Any) -> float:
    """Return the correlation between the slopes of two facing bodies, maximised over their relative shift.

    The correlation is 0 for periodic textures, which fit at several shifts, and for faces with few points.
    """
    factor = _choose_block_size(upper, lower)
    coarse_upper, coarse_lower = _coarsen_face(upper, factor), _coarsen_face(lower, factor)
    if min(*coarse_upper.heights.shape, *coarse_lower.heights.shape) < _MIN_COARSE_POINTS[lower.heights.ndim]:
        return 0.0
    correlations = _correlate_slopes(coarse_upper, coarse_lower)
    best_index = np.unravel_index(int(np.nanargmax(correlations)), correlations.shape)
    other_correlations = correlations.copy()
    shape = lower.heights.shape
    distances = [
        np.minimum(difference := np.abs(np.arange(count) - index), count - difference)
        for count, index in zip(correlations.shape, best_index, strict=True)
    ]
    widths = [max(2.0, _CORRELATION_PEAK_HALF_WIDTH_FRACTION * count / factor) for count in shape]
    peak_points = np.ix_(
        *(np.flatnonzero(distance <= width) for distance, width in zip(distances, widths, strict=True))
    )
    other_correlations[peak_points] = np.nan
    best_correlation = float(correlations[best_index])
    return (
        best_correlation
        if np.nanmax(other_correlations, initial=0.0) < MAX_SECOND_CORRELATION_RATIO * best_correlation
        else 0.0
    )


MIN_SLOPE_CORRELATIONS_OF_MATING_FACES = {Profile: 0.9, Surface: 0.5}
"""Minimum slope correlation (see `measure_fit`) at which two profiles or height maps count as mating faces.

The largest correlation of 3600 pairs of unrelated profiles was 0.86, and of 1350 pairs of unrelated maps 0.40.
"""


def do_faces_fit(upper: Any, lower: Any) -> bool:
    """Return whether two facing bodies fit into each other at some shift.

    Bodies of unequal spacing do not fit.
    """
    if upper.is_flat or lower.is_flat or not np.allclose(upper.spacings, lower.spacings):
        return False
    return measure_fit(upper, lower) > MIN_SLOPE_CORRELATIONS_OF_MATING_FACES[type(lower)]


def correlate_facing_slopes(upper: Any, lower: Any) -> float:
    """Return the slope correlation of two facing bodies in their present position.

    Returns NaN if a body is flat.
    """
    if upper.is_flat or lower.is_flat:
        return math.nan
    return float(_correlate_slopes(upper, lower)[(0,) * lower.heights.ndim])


def find_best_fit(upper: Any, lower: Any) -> tuple[float, tuple[int, ...]]:
    """Return the largest slope correlation of two faces, and the offset (points) of the upper face that gives it."""
    correlations = _correlate_slopes(upper, lower)
    best_index = np.unravel_index(int(np.nanargmax(correlations)), correlations.shape)
    offset = tuple(
        _to_signed_offset(int(index), count) for index, count in zip(best_index, correlations.shape, strict=True)
    )
    return float(correlations[best_index]), offset


def _to_signed_offset(index: int, count: int) -> int:
    """Convert an index of a cyclic correlation array to an offset in points; large indices are negative offsets.

    Indices above `count` / 2 correspond to negative offsets.
    """
    return index - count if index > count // 2 else index


def _choose_block_size(upper: Any, lower: Any) -> int:
    """Return the side length, in points, of the blocks whose mean heights form the coarse grid of two faces."""
    longest_side: int = max(*upper.heights.shape, *lower.heights.shape)
    return math.ceil(longest_side / _MAX_COARSE_POINTS[lower.heights.ndim])


def _coarsen_face(body: Any, factor: int) -> Any:
    """Coarsen a body's grid: each new height is the mean of a block with `factor` points per side."""
    if factor == 1:
        return body
    counts = [count // factor for count in body.heights.shape]
    shape = [size for count in counts for size in (count, factor)]
    axes = tuple(range(1, 2 * len(counts), 2))
    index = tuple(slice(count * factor) for count in counts)
    heights = body.heights[index].reshape(shape).mean(axis=axes)
    missing = None if body.missing is None else body.missing[index].reshape(shape).any(axis=axes)
    missing = None if missing is None or missing.all() or not missing.any() else missing
    spacing = tuple(factor * step for step in body.spacings)
    return body.changed(heights, "coarsened", spacing=spacing if len(spacing) == 2 else spacing[0], missing=missing)


def _correlate_slopes(upper: Any, lower: Any) -> Floats:
    """Return a cyclic array of the correlation between two bodies' slopes, with one element per relative offset.

    Negative offsets follow the positive offsets, as in a discrete Fourier transform. Offsets at which the faces overlap
    too little are NaN.
    """
    import scipy.fft

    shapes = upper.heights.shape, lower.heights.shape
    shape = tuple(scipy.fft.next_fast_len(a + b, real=True) for a, b in zip(*shapes, strict=True))

    def transform(values: Floats) -> Any:
        return scipy.fft.rfftn(values, shape)

    def correlate(a: Any, b: Any) -> Floats:
        return np.asarray(scipy.fft.irfftn(np.conj(a) * b, shape))

    masks = [np.ones(body.heights.shape) if body.missing is None else 1.0 - body.missing for body in (upper, lower)]
    mask_transforms = [transform(mask) for mask in masks]
    slope_product, upper_power, lower_power = (np.zeros(shape) for _ in range(3))
    for axis, spacing in enumerate(lower.spacings):
        upper_slope, lower_slope = (
            np.gradient(body.heights, spacing, axis=axis) * mask
            for body, mask in zip((upper, lower), masks, strict=True)
        )
        slope_product += correlate(transform(upper_slope), transform(lower_slope))
        upper_power += correlate(transform(upper_slope**2), mask_transforms[1])
        lower_power += correlate(mask_transforms[0], transform(lower_slope**2))
    power = np.sqrt(np.maximum(upper_power, 0) * np.maximum(lower_power, 0))
    correlations = np.divide(slope_product, power, out=np.zeros(shape), where=power > 1e-12 * power.max(initial=0.0))
    overlaps = [
        np.array(
            [
                max(
                    0, min(b, _to_signed_offset(index, shift_count) + a) - max(0, _to_signed_offset(index, shift_count))
                )
                for index in range(shift_count)
            ]
        )
        for a, b, shift_count in zip(*shapes, shape, strict=True)
    ]
    has_min_overlap = [
        overlap >= MIN_OVERLAP_FRACTION * min(a, b) for overlap, a, b in zip(overlaps, *shapes, strict=True)
    ]
    return np.where(functools.reduce(np.logical_and.outer, has_min_overlap), correlations, np.nan)


def _find_coarse_position(upper: Any, lower: Any) -> _FacePosition:
    """Find the best fit of two coarse bodies: among shifts by whole grid points and, for maps, rotations."""
    if isinstance(upper, Profile):
        return _FacePosition(_convert_corner_offset_to_centre_shift(find_best_fit(upper, lower)[1], upper, lower), 0.0)
    correlated_positions = []
    for angle in np.arange(-MAX_ROTATION, MAX_ROTATION + ROTATION_STEP / 2, ROTATION_STEP).tolist():
        rotated_upper = rotated(upper, angle) if angle else upper
        correlation, offset = find_best_fit(rotated_upper, lower)
        position = _FacePosition(
            _convert_corner_offset_to_centre_shift(offset, rotated_upper, lower), math.radians(angle)
        )
        correlated_positions.append((correlation, position))
    return max(correlated_positions, key=lambda item: item[0])[1]


def _convert_corner_offset_to_centre_shift(offset: tuple[int, ...], upper: Any, lower: Any) -> tuple[float, ...]:
    """Convert the offset (points) of two faces' first points to the shift (µm) of their middles."""
    return tuple(
        (step + (upper_points - lower_points) / 2) * spacing
        for step, upper_points, lower_points, spacing in zip(
            offset, upper.heights.shape, lower.heights.shape, lower.spacings, strict=True
        )
    )


def _convert_centre_shift_to_corner_offset(shift: tuple[float, ...], upper: Any, lower: Any) -> list[float]:
    """Convert the shift (µm) of two faces' middles to the offset (points) of their first points."""
    return [
        distance / spacing - (upper_points - lower_points) / 2
        for distance, upper_points, lower_points, spacing in zip(
            shift, upper.heights.shape, lower.heights.shape, lower.spacings, strict=True
        )
    ]


def _to_full_grid(position: _FacePosition, upper: Any, lower: Any, factor: int) -> _FacePosition:
    """Convert the relative position of two faces on coarse grids to a position on their full grids."""
    shift = tuple(
        distance + (upper_points % factor - lower_points % factor) / 2 * spacing
        for distance, upper_points, lower_points, spacing in zip(
            position.shift, upper.heights.shape, lower.heights.shape, lower.spacings, strict=True
        )
    )
    return _FacePosition(shift, position.rotation)


def _find_grid_offset(upper: Any, lower: Any, position: _FacePosition) -> tuple[int, ...] | None:
    """Return the upper face's offset in whole points if the grids of both faces coincide, and None otherwise.

    Deviations of up to `WHOLE_POINT_SHIFT_TOLERANCE` points from the grid are ignored.
    """
    steps = _convert_centre_shift_to_corner_offset(position.shift, upper, lower)
    move_of_ends = abs(position.rotation) * max(lower.heights.shape) / 2
    is_on_grid = all(abs(step - round(step)) + move_of_ends <= WHOLE_POINT_SHIFT_TOLERANCE for step in steps)
    return tuple(round(step) for step in steps) if is_on_grid else None


def _measure_distances(body: Any) -> list[Floats]:
    """Return the positions (µm) of a body's points relative to the middle of the body, along each axis."""
    return [
        (np.arange(count) - (count - 1) / 2) * spacing
        for count, spacing in zip(body.heights.shape, body.spacings, strict=True)
    ]


def _interpolate_rotated_face(upper: Any, distances: list[Floats], rotation: float) -> tuple[Floats, Any]:
    """Compute heights of the rotated upper face by interpolation, at given distances (µm) from the middle of the face.

    Returns the heights and a mask of missing points.
    """
    if isinstance(upper, Surface):
        return interpolate_rotated(upper, distances[0][:, np.newaxis], distances[1], rotation)
    from scipy.interpolate import CubicSpline

    points = np.clip(distances[0] / upper.spacing + (len(upper) - 1) / 2, 0, len(upper) - 1)
    heights = CubicSpline(np.arange(len(upper)), upper.heights)(points)
    if upper.missing is None:
        return heights, None
    return heights, upper.missing[np.floor(points).astype(np.intp)] | upper.missing[np.ceil(points).astype(np.intp)]


def _interpolate_overlap(upper: Any, lower: Any, position: _FacePosition) -> tuple[Any, Any]:
    """Return the overlapping parts of two faces; the upper part is interpolated at the points of the lower face.

    The overlap of maps is the largest rectangle within the rotated upper face, cut by the sides of the lower face.
    """
    side_lengths = [(count - 1) * spacing for count, spacing in zip(upper.heights.shape, upper.spacings, strict=True)]
    if isinstance(upper, Surface):
        side_lengths = list(inscribed_rectangle(side_lengths[0], side_lengths[1], position.rotation))
    distances = [
        lower_distances - step for lower_distances, step in zip(_measure_distances(lower), position.shift, strict=True)
    ]
    inside_indices = [
        np.flatnonzero(np.abs(axis_distances) <= length / 2 + 1e-9 * spacing)
        for axis_distances, length, spacing in zip(distances, side_lengths, lower.spacings, strict=True)
    ]
    index = tuple(slice(int(points[0]), int(points[-1]) + 1) if points.size else slice(0) for points in inside_indices)
    heights, missing = _interpolate_rotated_face(
        upper,
        [axis_distances[points] for axis_distances, points in zip(distances, index, strict=True)],
        position.rotation,
    )
    lower_overlap = lower.changed(lower.heights[index], "overlap", missing=select_from_mask(lower.missing, index))
    missing = missing if missing is not None and missing.any() else None
    return upper.changed(heights, "overlap", missing=missing), lower_overlap


def _refine_position(upper: Any, lower: Any, position: _FacePosition) -> _FacePosition:
    """Refine the position of the upper face by the Gauss-Newton method, which minimises the rms gap.

    The derivatives of the gap are the slopes of the lower face, so the noise of the upper face does not favour
    positions between its points, at which interpolation smooths this noise.
    """
    spacings, half_length = np.array(lower.spacings), max(lower.heights.shape) / 2
    max_rotation = math.radians(MAX_ROTATION)
    rms_gap, step = _compute_gauss_newton_step(upper, lower, position)
    for _ in range(_MAX_REFINEMENTS):
        for scale in _GAUSS_NEWTON_STEP_FRACTIONS:
            shift = tuple((np.array(position.shift) + scale * step[: spacings.size]).tolist())
            rotation = position.rotation + scale * float(step[spacings.size :].sum())
            trial_position = _FacePosition(shift, min(max(rotation, -max_rotation), max_rotation))
            if not _has_min_overlap(upper, lower, trial_position):
                continue
            trial_rms_gap, trial_step = _compute_gauss_newton_step(upper, lower, trial_position)
            if trial_rms_gap < rms_gap:
                break
        else:
            return position
        moved_points = np.max(np.abs(np.subtract(trial_position.shift, position.shift)) / spacings)
        moved_points += abs(trial_position.rotation - position.rotation) * half_length
        position, rms_gap, step = trial_position, trial_rms_gap, trial_step
        if moved_points < _CONVERGENCE_DISTANCE:
            break
    return position


def _compute_gauss_newton_step(upper: Any, lower: Any, position: _FacePosition) -> tuple[float, Floats]:
    """Return the rms gap (µm) at a position, and the changes of shift and rotation in a Gauss-Newton step."""
    upper_overlap, lower_overlap = _interpolate_overlap(upper, lower, position)
    missing = combine_missing_masks(upper_overlap, lower_overlap)
    measured = np.ones(lower_overlap.heights.shape, bool) if missing is None else ~missing
    slopes = [
        np.gradient(lower_overlap.heights, spacing, axis=axis)[measured] for axis, spacing in enumerate(lower.spacings)
    ]
    distances = np.meshgrid(*_measure_distances(lower_overlap), indexing="ij")
    plane_terms = [np.ones(slopes[0].shape), *(along[measured] for along in distances)]
    gap_derivatives = [-slope for slope in slopes]
    if isinstance(upper, Surface):
        gap_derivatives.append(slopes[1] * plane_terms[1] - slopes[0] * plane_terms[2])
    gap = (upper_overlap.heights - lower_overlap.heights)[measured]
    fit_columns = [*gap_derivatives, *plane_terms]
    norms = [float(np.linalg.norm(column)) or 1.0 for column in fit_columns]
    normal_matrix = np.array([[np.vdot(a, b) for b in fit_columns] for a in fit_columns]) / np.outer(norms, norms)
    right_side = np.array([np.vdot(column, gap) for column in fit_columns]) / norms
    step = -np.linalg.lstsq(normal_matrix, right_side, rcond=None)[0] / norms
    return _measure_rms_gap(upper_overlap, lower_overlap), step[: len(gap_derivatives)]


def _has_min_overlap(upper: Any, lower: Any, position: _FacePosition) -> bool:
    """Return whether, along each axis, two faces overlap by at least `MIN_OVERLAP_FRACTION` of the shorter face.

    The overlap is that of the faces at the relative position `position`.
    """
    return all(
        min(lower_points, step + upper_points) - max(0.0, step)
        >= MIN_OVERLAP_FRACTION * min(upper_points, lower_points)
        for step, upper_points, lower_points in zip(
            _convert_centre_shift_to_corner_offset(position.shift, upper, lower),
            upper.heights.shape,
            lower.heights.shape,
            strict=True,
        )
    )


def _estimate_noise(gap: Any) -> float:
    """Estimate the rms (µm) of white noise in a gap from fourth differences of heights; 0 for too few points.

    The variance of the fourth differences of white noise is 70 times the variance of the noise.
    """
    fourth_differences = np.diff(
        gap.heights if gap.missing is None else np.where(gap.missing, np.nan, gap.heights), 4, axis=-1
    )
    fourth_differences = fourth_differences[np.isfinite(fourth_differences)]
    return float(np.sqrt(np.mean(fourth_differences**2) / 70)) if fourth_differences.size else 0.0


def _cut_overlap(upper: Any, lower: Any, offset: tuple[int, ...]) -> tuple[Any, Any]:
    """Crop two bodies to the area where they overlap, given the offset (in points) of the upper body."""
    upper_index, lower_index = [], []
    for step, upper_points, lower_points in zip(offset, upper.heights.shape, lower.heights.shape, strict=True):
        start = max(0, step)
        length = min(lower_points, step + upper_points) - start
        lower_index.append(slice(start, start + length))
        upper_index.append(slice(start - step, start - step + length))
    parts = [
        body.changed(body.heights[tuple(index)], "overlap", missing=select_from_mask(body.missing, tuple(index)))
        for body, index in ((upper, upper_index), (lower, lower_index))
    ]
    return parts[0], parts[1]


def _compute_gap(upper: Any, lower: Any) -> Any:
    """Compute the gap between two bodies on the same grid, and subtract the least-squares line or plane of the gap."""
    gap = lower.changed(upper.heights - lower.heights, "gap", missing=combine_missing_masks(upper, lower))
    return levelled(gap, "line" if isinstance(gap, Profile) else "plane")


def _measure_rms_gap(upper: Any, lower: Any) -> float:
    gap = _compute_gap(upper, lower)
    return float(np.std(gap.heights if gap.missing is None else gap.heights[~gap.missing]))
