"""Registration of two faces that fit: the shift and the rotation at which their gap is smallest.

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
from stiction.surfaces.preparation import levelled, rotated
from stiction.surfaces.profile import Profile, combine_missing_masks, select_from_mask
from stiction.surfaces.surface import Surface

MAX_ROTATION = 3.0  # largest rotation (degrees) of the search
ROTATION_STEP = 0.5  # first step (degrees) of the search
MAX_SECOND_FIT_RATIO = 0.7  # maximum ratio of the correlation at any other shift to the one at the best shift
MIN_OVERLAP_FRACTION = 0.5  # minimum overlap along each axis, relative to the shorter face
_MIN_COARSE_POINTS = {1: 64, 2: 16}  # minimum number of points along each axis for a comparison, by dimension
_MAX_COARSE_POINTS = {1: 2048, 2: 128}  # maximum number of points along each axis in the search, by dimension
_PEAK_WIDTH_FRACTION = 0.05  # positions closer to the best one than this fraction of the length belong to its peak


@dataclass(frozen=True)
class Registration:
    """Position of the upper face at which it fits the lower face best.

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
    """

    shift: tuple[float, ...]
    rotation: float
    rms_gap_before: float
    rms_gap: float
    correlation: float


def register_faces(upper: Any, lower: Any) -> tuple[Any, Any, Registration]:
    """Return the overlapping parts of two facing bodies at the position at which they fit best, and this position.

    The spacings of both bodies must be equal. The upper face is rotated (maps only), shifted by whole grid points, and
    tilted so that the gap has no slope on average.
    """
    rms_gap_before = _measure_rms_gap(*_cut_overlap(upper, lower, (0,) * lower.heights.ndim))
    rotation = _find_rotation(upper, lower) if isinstance(upper, Surface) else 0.0
    rotated_upper = rotated(upper, rotation) if rotation else upper
    offset = _find_offset(rotated_upper, lower)
    upper_part, lower_part = _cut_overlap(rotated_upper, lower, offset)
    gap = _compute_gap(upper_part, lower_part)
    upper_part = upper_part.changed(lower_part.heights + gap.heights, "registered")
    correlation = correlate_facing_slopes(upper_part, lower_part)
    middle_distances = [
        (step + (count - other) / 2) * spacing
        for step, count, other, spacing in zip(
            offset, rotated_upper.heights.shape, lower.heights.shape, lower.spacings, strict=True
        )
    ]
    registration = Registration(
        tuple(middle_distances), rotation, rms_gap_before, _measure_rms_gap(upper_part, lower_part), correlation
    )
    return upper_part, lower_part, registration


def measure_fit(upper: Any, lower: Any) -> float:
    """Return the correlation of the slopes of two facing bodies at the shift at which they fit best.

    It is 0 for periodic textures, which fit at several shifts, and for faces with few points.
    """
    factor = _find_coarsening(upper, lower)
    coarse_upper, coarse_lower = _coarsen(upper, factor), _coarsen(lower, factor)
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
    widths = [max(2.0, _PEAK_WIDTH_FRACTION * count / factor) for count in shape]
    peak_points = np.ix_(
        *(np.flatnonzero(distance <= width) for distance, width in zip(distances, widths, strict=True))
    )
    other_correlations[peak_points] = np.nan
    best_correlation = float(correlations[best_index])
    return (
        best_correlation
        if np.nanmax(other_correlations, initial=0.0) < MAX_SECOND_FIT_RATIO * best_correlation
        else 0.0
    )


MIN_FIT_CORRELATIONS = {Profile: 0.9, Surface: 0.5}
"""Correlation of the slopes of two faces (see `measure_fit`) above which the faces fit.

The largest correlation of 3600 pairs of unrelated profiles was 0.86, and of 1350 pairs of unrelated maps 0.40.
"""


def do_faces_fit(upper: Any, lower: Any) -> bool:
    """Return whether two facing bodies fit into each other at one position. Their spacings must be equal."""
    if upper.is_flat or lower.is_flat or not np.allclose(upper.spacings, lower.spacings):
        return False
    return measure_fit(upper, lower) > MIN_FIT_CORRELATIONS[type(lower)]


def correlate_facing_slopes(upper: Any, lower: Any) -> float:
    """Return the correlation of the slopes of two facing bodies without a shift, or NaN if one is flat."""
    if upper.is_flat or lower.is_flat:
        return math.nan
    return float(_correlate_slopes(upper, lower)[(0,) * lower.heights.ndim])


def find_best_fit(upper: Any, lower: Any) -> tuple[float, tuple[int, ...]]:
    """Return the largest correlation of the slopes, and the offset of the upper face (points) at which it occurs."""
    correlations = _correlate_slopes(upper, lower)
    best_index = np.unravel_index(int(np.nanargmax(correlations)), correlations.shape)
    offset = tuple(_to_offset(int(index), count) for index, count in zip(best_index, correlations.shape, strict=True))
    return float(correlations[best_index]), offset


def _to_offset(index: int, count: int) -> int:
    """Convert an index of a discrete Fourier transform to an offset. Indices in the upper half are negative offsets."""
    return index - count if index > count // 2 else index


def _find_coarsening(upper: Any, lower: Any) -> int:
    """Return the side (points) of the blocks over which heights are averaged for a coarse search."""
    longest_side: int = max(*upper.heights.shape, *lower.heights.shape)
    return math.ceil(longest_side / _MAX_COARSE_POINTS[lower.heights.ndim])


def _coarsen(body: Any, factor: int) -> Any:
    """Return a coarser body, whose heights are means over blocks of `factor` points per axis."""
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
    """Return the correlation of the slopes of two bodies for all offsets of the upper body, in the order of an FFT.

    Offsets at which the faces overlap too little are NaN.
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
    product, upper_power, lower_power = (np.zeros(shape) for _ in range(3))
    for axis, spacing in enumerate(lower.spacings):
        upper_slope, lower_slope = (
            np.gradient(body.heights, spacing, axis=axis) * mask
            for body, mask in zip((upper, lower), masks, strict=True)
        )
        product += correlate(transform(upper_slope), transform(lower_slope))
        upper_power += correlate(transform(upper_slope**2), mask_transforms[1])
        lower_power += correlate(mask_transforms[0], transform(lower_slope**2))
    power = np.sqrt(np.maximum(upper_power, 0) * np.maximum(lower_power, 0))
    correlations = np.divide(product, power, out=np.zeros(shape), where=power > 1e-12 * power.max(initial=0.0))
    overlaps = [
        np.array(
            [max(0, min(b, _to_offset(index, count) + a) - max(0, _to_offset(index, count))) for index in range(count)]
        )
        for a, b, count in zip(*shapes, shape, strict=True)
    ]
    allowed = [overlap >= MIN_OVERLAP_FRACTION * min(a, b) for overlap, a, b in zip(overlaps, *shapes, strict=True)]
    return np.where(functools.reduce(np.logical_and.outer, allowed), correlations, np.nan)


def _find_rotation(upper: Surface, lower: Surface) -> float:
    """Return the rotation (degrees) of the upper map at which the gap is smallest.

    The search starts with the slopes of coarse maps. The result is 0 if the rotation moves the ends of the map by less
    than half of a point.
    """
    from scipy.optimize import minimize_scalar

    factor = _find_coarsening(upper, lower)
    coarse_upper, coarse_lower = _coarsen(upper, factor), _coarsen(lower, factor)

    def correlate(angle: float) -> float:
        return find_best_fit(rotated(coarse_upper, angle) if angle else coarse_upper, coarse_lower)[0]

    def measure_gap(angle: float) -> float:
        rotated_upper = rotated(upper, angle)
        return _measure_rms_gap(*_cut_overlap(rotated_upper, lower, _find_offset(rotated_upper, lower)))

    angles = np.arange(-MAX_ROTATION, MAX_ROTATION + ROTATION_STEP / 2, ROTATION_STEP)
    best_angle = float(angles[int(np.argmax([correlate(float(angle)) for angle in angles]))])
    bounds = best_angle - ROTATION_STEP, best_angle + ROTATION_STEP
    optimum = minimize_scalar(lambda angle: measure_gap(float(angle)), bounds=bounds, options={"xatol": 0.01})
    smallest_rotation = math.degrees(1 / max(lower.heights.shape))  # moves the ends of the map by half of a point
    return float(optimum.x) if abs(optimum.x) > smallest_rotation else 0.0


def _find_offset(upper: Any, lower: Any) -> tuple[int, ...]:
    """Return the offset (points) of the upper face with the smallest gap, near the offset at which slopes fit best."""
    factor = _find_coarsening(upper, lower)
    _, offset = find_best_fit(_coarsen(upper, factor), _coarsen(lower, factor))
    return _refine_offset(upper, lower, tuple(factor * step for step in offset), factor)


def _refine_offset(upper: Any, lower: Any, offset: tuple[int, ...], factor: int) -> tuple[int, ...]:
    """Return the offset with the smallest gap near `offset`. The step of the search is halved down to one point."""
    smallest_gap, step = _measure_rms_gap(*_cut_overlap(upper, lower, offset)), max(factor // 2, 1)
    while True:
        moves = np.stack(np.meshgrid(*[(-step, 0, step)] * len(offset)), -1).reshape(-1, len(offset))
        candidates = [tuple(int(a + b) for a, b in zip(offset, move, strict=True)) for move in moves]
        gaps = [
            _measure_rms_gap(*_cut_overlap(upper, lower, candidate))
            if _has_min_overlap(upper, lower, candidate)
            else math.inf
            for candidate in candidates
        ]
        if min(gaps) < smallest_gap:
            smallest_gap, offset = min(gaps), candidates[int(np.argmin(gaps))]
        elif step == 1:
            return offset
        else:
            step //= 2


def _has_min_overlap(upper: Any, lower: Any, offset: tuple[int, ...]) -> bool:
    """Return whether two bodies overlap by `MIN_OVERLAP_FRACTION` along each axis at an offset (points)."""
    return all(
        min(other, step + count) - max(0, step) >= MIN_OVERLAP_FRACTION * min(count, other)
        for step, count, other in zip(offset, upper.heights.shape, lower.heights.shape, strict=True)
    )


def _cut_overlap(upper: Any, lower: Any, offset: tuple[int, ...]) -> tuple[Any, Any]:
    """Return the overlapping parts of two bodies if the upper one is moved by an offset (points)."""
    upper_index, lower_index = [], []
    for step, count, other in zip(offset, upper.heights.shape, lower.heights.shape, strict=True):
        start = max(0, step)
        length = min(other, step + count) - start
        lower_index.append(slice(start, start + length))
        upper_index.append(slice(start - step, start - step + length))
    parts = [
        body.changed(body.heights[tuple(index)], "overlap", missing=select_from_mask(body.missing, tuple(index)))
        for body, index in ((upper, upper_index), (lower, lower_index))
    ]
    return parts[0], parts[1]


def _compute_gap(upper: Any, lower: Any) -> Any:
    """Return the gap of two bodies on the same grid, after subtracting a plane or a line."""
    gap = lower.changed(upper.heights - lower.heights, "gap", missing=combine_missing_masks(upper, lower))
    return levelled(gap, "line" if isinstance(gap, Profile) else "plane")


def _measure_rms_gap(upper: Any, lower: Any) -> float:
    gap = _compute_gap(upper, lower)
    return float(np.std(gap.heights if gap.missing is None else gap.heights[~gap.missing]))
