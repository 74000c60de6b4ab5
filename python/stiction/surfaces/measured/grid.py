"""Conversion of a list of points x, y, z on a grid to a matrix of heights."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from stiction._checks import Floats
from stiction.surfaces.measured.raw import MAX_DECLARED_NUMBER, FormatError

# Positions count as exact if their distance from the nodes of a uniform grid is at most this fraction of a grid step.
EXACT_POSITION_TOLERANCE = 1e-3
MAX_OFFSET_FROM_GRID_IN_STEPS = 0.05  # grid steps
MAX_NODES_PER_POINT = 4
MIN_STEP_OF_ROUNDED_POSITIONS = 2.0
# Maximum range of position errors on a grid, in units of the last digit: 1 from rounding, 0.2 from the fitted step.
MAX_POSITION_SCATTER_IN_LAST_DIGITS = 1.2
# The smallest gap between grid points must be at least this many times the largest gap that rounding causes.
MIN_GRID_GAP_TO_ROUNDING_GAP_RATIO = 4.0


def to_grid(
    x: Floats, y: Floats, z: Floats, digits: Sequence[Callable[[], Floats] | None]
) -> tuple[Floats, tuple[float, float], str]:
    """Convert points x, y, z that lie on a grid to a matrix of heights.

    Returns the matrix, the spacings (Δy, Δx), and a history entry. Rows are in ascending order of y, and columns in
    ascending order of x. Raises `FormatError` if the points are not on a grid.
    """
    with np.errstate(all="ignore"):
        (dx, columns), (dy, rows) = (
            _find_step_and_node_indices(name, index, get_digits)
            for name, index, get_digits in zip("xy", (x, y), digits, strict=True)
        )
    shape = (int(rows.max()) + 1, int(columns.max()) + 1)
    node_count = shape[0] * shape[1]
    if node_count > MAX_NODES_PER_POINT * z.size + 10:
        raise FormatError(
            f"lists {z.size} points that are not on a grid, because a grid through all points would have "
            f"{shape[0]} × {shape[1]} nodes; interpolate them onto a grid, or export a matrix"
        )
    heights, num_absent = fill_grid(shape, rows, columns, z, lambda index: f"x {x[index]:g}, y {y[index]:g}")
    history_entry = f"{z.size} points on a grid of {shape[0]} × {shape[1]}" + (
        f", {num_absent} nodes absent" if num_absent else ""
    )
    return heights, (dy, dx), history_entry


def fill_grid(
    shape: tuple[int, int], rows: np.ndarray, columns: np.ndarray, heights: Floats,
    describe_position: Callable[[int], str],
) -> tuple[Floats, int]:  # fmt: skip
    """Write the heights of listed grid nodes to a matrix, and NaN at nodes that are not listed.

    Returns the matrix, and the number of nodes that are not listed. A node may be listed repeatedly with the same
    height. Raises `FormatError` if its heights differ.
    """
    nodes = rows * shape[1] + columns
    matrix = np.full(shape[0] * shape[1], np.nan)
    matrix[nodes] = heights
    num_listed = int(np.unique(nodes).size)
    if num_listed < nodes.size:
        has_different_height = (matrix[nodes] != heights) & ~(np.isnan(matrix[nodes]) & np.isnan(heights))
        if has_different_height.any():
            index = int(np.argmax(has_different_height))
            raise FormatError(
                f"lists more than one point at {describe_position(index)}, with heights {heights[index]:g} and "
                f"{matrix[nodes[index]]:g}"
            )
    return matrix.reshape(shape), matrix.size - num_listed


def _find_step_and_node_indices(
    name: str, positions: Floats, digits: Callable[[], Floats] | None
) -> tuple[float, np.ndarray]:
    """Return the grid step along one axis, and the index of the grid node at which each point lies."""
    if not (np.abs(positions) <= MAX_DECLARED_NUMBER).all():
        raise FormatError(f"lists a point without a usable position along {name}")
    step = _find_step_of_rounded_positions(positions, digits) or estimate_step(positions)
    if step is None:
        raise FormatError(
            f"lists points that all have the same {name}, so they form a profile; choose other columns (--columns)"
        )
    node_indices = np.round((positions - positions.min()) / step)
    if not node_indices.max() <= MAX_NODES_PER_POINT * positions.size + 10:
        raise FormatError(
            f"lists {positions.size} points that are not on a grid, because the steps along {name} differ too much; "
            "interpolate them onto a grid, or export a matrix"
        )
    last_node = int(node_indices.max())
    step = float(positions.max() - positions.min()) / last_node
    deviations = np.abs(positions - positions.min() - node_indices * step)
    # The step is fitted to all positions, because the first and the last position have measurement errors too.
    if deviations.max() > EXACT_POSITION_TOLERANCE * step:
        step, first_position = (float(coefficient) for coefficient in np.polyfit(node_indices, positions, 1))
        deviations = np.abs(positions - first_position - node_indices * step)
    worst_index = int(np.argmax(deviations))
    allowed_deviation = MAX_OFFSET_FROM_GRID_IN_STEPS * step
    if deviations[worst_index] > allowed_deviation and digits is not None:
        allowed_deviation += float(np.max(digits()))
    if deviations[worst_index] > allowed_deviation or (last_node > 1 and deviations[worst_index] > 0.3 * step):
        raise FormatError(
            f"lists points that are not on a grid: point {worst_index}, counted from 0, is at {name} "
            f"{positions[worst_index]:g}, which is {deviations[worst_index] / step:.2g} grid steps from the nearest "
            f"node (grid step {step:g} in the unit of the file); interpolate the points onto a grid, or export a matrix"
        )
    return step, node_indices.astype(np.int64)


def _find_step_of_rounded_positions(positions: Floats, digits: Callable[[], Floats] | None) -> float | None:
    """Estimate the grid step of positions that were rounded for output.

    Each grid node must have a point.

    Returns None if the positions do not fit a grid.
    """
    distinct_positions = np.unique(positions)
    if digits is None or distinct_positions.size < 3:
        return None
    node_indices = np.arange(distinct_positions.size)
    step = float(np.polyfit(node_indices, distinct_positions, 1)[0])
    last_digit_value = float(np.max(digits()))
    is_uniform = (
        step >= MIN_STEP_OF_ROUNDED_POSITIONS * last_digit_value
        and np.ptp(distinct_positions - step * node_indices) <= MAX_POSITION_SCATTER_IN_LAST_DIGITS * last_digit_value
    )
    return step if is_uniform else None


def estimate_step(positions: Floats) -> float | None:
    """Return the median distance between neighbouring positions.

    Positions that differ only by rounding count as one position.
    """
    distinct_positions = np.unique(positions)
    gaps = np.diff(distinct_positions)
    if not gaps.size:
        return None
    # A gap between sorted positions is a rounding error, one grid step or, if nodes are missing, several grid steps.
    ordered_gaps = np.sort(gaps)
    gap_ratios = ordered_gaps[1:] / ordered_gaps[:-1]
    if gap_ratios.size and gap_ratios.max() > MIN_GRID_GAP_TO_ROUNDING_GAP_RATIO:
        gap_indices = np.flatnonzero(gaps > ordered_gaps[int(np.argmax(gap_ratios))]) + 1
        distinct_positions = np.array([float(cluster.mean()) for cluster in np.split(distinct_positions, gap_indices)])
    return float(np.median(np.diff(distinct_positions)))
