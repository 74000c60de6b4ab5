"""Detection of a large form in a scan: a parabola (in maps), or a straight height step (in maps or profiles)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stiction._checks import Floats
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

MAX_BLOCKS_PER_MAP_SIDE = 64
"""Maximum number of blocks of points along each axis of a map. A form is found from the mean heights of blocks.

A profile is divided into at most ``MAX_BLOCKS_PER_MAP_SIDE ** 2`` blocks.
"""

MIN_BLOCKS_PER_MAP_SIDE = 16
MIN_PARABOLA_TO_HIGHER_TERMS_RATIO = 5.0
"""A fitted parabola dominates a map if its mean square height exceeds that of the fitted cubic and quartic terms by
this factor.

For a rough map without form, the ratio is about 2 if the longest wavelengths dominate, and rarely above 5. If the
parabola is the form of the body, roughness contributes little to the higher terms, and the ratio is larger.
"""

MIN_FRACTION_OF_STEP_AT_ITS_EDGE = 0.8
"""Minimum fraction of a step's height that arises within a few blocks of its edge.

Smooth forms have a smaller fraction.
"""

_NUM_STEP_DIRECTIONS = 72
_MIN_POINT_FRACTION_BESIDE_STEP = 0.02
_COMPARED_DISTANCES_FROM_STEP_IN_BLOCKS = (0.75, 3.75)


class DominantStep(NamedTuple):
    """Straight height step across a scan."""

    height: float
    """Height of the step (µm)."""
    fraction: float
    """Fraction of the mean square height that the step contributes."""


def measure_parabola_fraction(body: Surface) -> float:
    """Return the fraction of a map's mean square height that a parabola explains.

    Returns 0 if no parabola dominates.

    The heights are measured from the least-squares plane.
    """
    blocks = _average_blocks(body)
    if blocks is None:
        return 0.0
    coordinates, heights, mean_square = blocks
    x, y = coordinates
    exponent_pairs = [(i, degree - i) for degree in range(5) for i in range(degree + 1)]
    design_matrix = np.stack([x**i * y**j for i, j in exponent_pairs], axis=1)
    # Columns 0 to 2 of the orthogonal basis describe a plane, 3 to 5 a parabola, all others cubic and quartic terms.
    basis, _ = np.linalg.qr(design_matrix)
    mean_squares = np.square(basis.T @ heights) / heights.size
    parabola, higher_terms = mean_squares[3:6].sum(), mean_squares[6:].sum()
    is_dominant = parabola > MIN_PARABOLA_TO_HIGHER_TERMS_RATIO * higher_terms
    return float(min(parabola / mean_square, 1.0)) if is_dominant else 0.0


def find_dominant_step(body: Profile | Surface) -> DominantStep | None:
    """Find the height step that accounts for most of the mean square height of a scan.

    Returns None if no step is sharp.

    A step and a plane are fitted together, because levelling by a plane tilts the two sides of a step.
    """
    blocks = _average_blocks(body)
    if blocks is None:
        return None
    coordinates, heights, mean_square = blocks
    trend_basis, _ = np.linalg.qr(np.stack([np.ones_like(heights), *coordinates], axis=1))
    count, is_map = heights.size, len(coordinates) == 2
    num_blocks_below, margin = np.arange(1, count + 1), max(1, round(_MIN_POINT_FRACTION_BESIDE_STEP * count))
    candidate_edges = slice(margin - 1, count - margin)
    rows = np.vstack([heights, trend_basis.T])
    best_square_sum, best_height, best_edge, best_distances_across = 0.0, 0.0, 0.0, coordinates[0]
    for angle in np.linspace(0, np.pi, _NUM_STEP_DIRECTIONS, endpoint=False) if is_map else [0.0]:
        distance_across = np.cos(angle) * coordinates[0] + np.sin(angle) * coordinates[-1]
        block_order = np.argsort(distance_across, kind="stable")
        projections, *trend_sums = np.cumsum(np.take(rows, block_order, axis=1), axis=1)[:, candidate_edges]
        square_norms = num_blocks_below[candidate_edges] - np.square(trend_sums).sum(axis=0)
        explained_square_sums = np.square(projections) / square_norms
        best_index = int(np.argmax(explained_square_sums))
        if explained_square_sums[best_index] > best_square_sum:
            best_square_sum, best_height = (
                float(explained_square_sums[best_index]),
                -float(projections[best_index] / square_norms[best_index]),
            )
            best_edge = float(distance_across[block_order][margin - 1 + best_index : margin + 1 + best_index].mean())
            best_distances_across = distance_across
    distances = best_distances_across - best_edge
    nearest_distance, farthest_distance = (
        2 / min(MAX_BLOCKS_PER_MAP_SIDE, count) * distance_in_blocks
        for distance_in_blocks in _COMPARED_DISTANCES_FROM_STEP_IN_BLOCKS
    )
    heights_below, heights_above = (
        heights[(sign * distances > nearest_distance) & (sign * distances < farthest_distance)] for sign in (-1, 1)
    )
    if not (best_square_sum > 0 and heights_below.size and heights_above.size):
        return None
    if (heights_above.mean() - heights_below.mean()) / best_height < MIN_FRACTION_OF_STEP_AT_ITS_EDGE:
        return None
    # Blocks of points that the height step crosses are excluded, because their mean heights mix both levels.
    is_undivided = np.abs(distances) > nearest_distance
    design_matrix = np.stack([np.ones_like(heights), *coordinates, distances > 0], axis=1)[is_undivided]
    *_, height = np.linalg.lstsq(design_matrix, heights[is_undivided], rcond=None)[0]
    return DominantStep(abs(float(height)), min(best_square_sum / count / mean_square, 1.0))


def _average_blocks(body: Profile | Surface) -> tuple[list[Floats], Floats, float] | None:
    """Average the heights of a levelled body over equal blocks of points.

    Returns the coordinates of the blocks (from -1 to 1 along x, and along y for a map), their mean heights above the
    least-squares plane of the blocks, and the mean square height of all points. Returns None for a flat or small body.
    """
    heights = body.heights_with_nan
    max_blocks = MAX_BLOCKS_PER_MAP_SIDE if heights.ndim == 2 else MAX_BLOCKS_PER_MAP_SIDE**2
    block_sizes = [-(-points // max_blocks) for points in heights.shape]
    block_counts = [points // size for points, size in zip(heights.shape, block_sizes, strict=True)]
    if min(block_counts) < MIN_BLOCKS_PER_MAP_SIDE:
        return None
    heights = heights[tuple(slice(count * size) for count, size in zip(block_counts, block_sizes, strict=True))]
    missing = np.isnan(heights)
    has_missing = bool(missing.any())
    split_shape = [
        length for count_and_size in zip(block_counts, block_sizes, strict=True) for length in count_and_size
    ]
    split_axes = tuple(range(1, 2 * heights.ndim, 2))
    measured_counts = np.prod(block_sizes) - missing.reshape(split_shape).sum(axis=split_axes)

    def average_over_blocks(values: Floats) -> Floats:
        kept_values = np.where(missing, 0.0, values) if has_missing else values
        sums = kept_values.reshape(split_shape).sum(axis=split_axes)
        return np.asarray((sums / np.maximum(measured_counts, 1))[measured_counts > 0])

    axes = [np.linspace(1 / points - 1, 1 - 1 / points, points) for points in heights.shape]
    grid = [np.broadcast_to(axis, heights.shape) for axis in np.ix_(*axes)][::-1]
    if has_missing:
        coordinates = [average_over_blocks(axis) for axis in grid]
    else:
        block_axes = [axis.reshape(-1, size).mean(axis=1) for axis, size in zip(axes, block_sizes, strict=True)]
        coordinates = [axis.ravel() for axis in np.meshgrid(*block_axes, indexing="ij")][::-1]
    block_means = average_over_blocks(heights)
    trend, *_ = np.linalg.lstsq(np.stack([np.ones_like(block_means), *coordinates], axis=1), block_means, rcond=None)
    levelled_heights = heights - trend[0]
    for slope, axis in zip(trend[1:], grid, strict=True):
        levelled_heights -= slope * axis
    mean_square = float(np.nanmean(np.square(levelled_heights)))
    return (coordinates, average_over_blocks(levelled_heights), mean_square) if mean_square > 0 else None
