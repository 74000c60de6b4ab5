"""Hills and dales of a surface, and the feature parameters of ISO 25178-2.

Hills and dales are found by watershed segmentation with Wolf pruning, and are described by the feature parameters of
ISO 25178-2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats

# Wolf pruning merges hills and dales whose height, as a fraction of the maximum height, is below this number.
PRUNING_FRACTION = 0.05
NUM_AVERAGED_FEATURES = 5

_IndexArray = NDArray[np.intp]


def find_significant_peaks(heights: Floats, threshold: float) -> _IndexArray:
    """Return the peaks of a map that remain after Wolf pruning, as indices in the flattened map.

    Parameters
    ----------
    heights : (rows, columns) ndarray
        Pass the negative heights to find pits.
    threshold : float
        Two hills are merged if the lower peak is less than this height above their highest common saddle.

    Notes
    -----
    Every point belongs to the peak that is reached by repeatedly moving to the highest of the eight neighbours. Wolf
    pruning merges the lowest hill first. A peak remains if it rises by at least the threshold above the highest saddle
    on any path to a higher peak. The maximum spanning tree of the saddles between neighbouring hills contains these
    saddles.
    """
    height_order = np.argsort(heights, axis=None, kind="stable")
    rank = np.empty(heights.size, np.int64)
    rank[height_order] = np.arange(heights.size)
    hill_of_point = _find_peak_of_each_point(rank.reshape(heights.shape), height_order)
    peaks, hill_of_point = np.unique(hill_of_point, return_inverse=True)
    if peaks.size == 1:
        return peaks
    first_hill, second_hill, saddle_ranks = _find_saddles(
        hill_of_point.reshape(heights.shape), rank.reshape(heights.shape), peaks.size
    )
    saddle_heights = heights.ravel()[height_order[saddle_ranks]].tolist()
    peak_heights = heights.ravel()[peaks].tolist()
    peak_ranks = rank[peaks].tolist()
    parents = list(range(peaks.size))
    is_significant = np.ones(peaks.size, bool)

    def find_tree_root(index: int) -> int:
        while parents[index] != index:
            parents[index] = parents[parents[index]]
            index = parents[index]
        return index

    for hill_a, hill_b, saddle_height in zip(first_hill.tolist(), second_hill.tolist(), saddle_heights, strict=True):
        lower_hill, higher_hill = find_tree_root(hill_a), find_tree_root(hill_b)
        if peak_ranks[lower_hill] > peak_ranks[higher_hill]:
            lower_hill, higher_hill = higher_hill, lower_hill
        parents[lower_hill] = higher_hill
        is_significant[lower_hill] = peak_heights[lower_hill] - saddle_height >= threshold
    return np.asarray(peaks[is_significant])


def _find_peak_of_each_point(rank: NDArray[np.int64], height_order: _IndexArray) -> _IndexArray:
    """Return, for each point of a map, the index of the peak of the hill that contains the point."""
    from scipy.ndimage import maximum_filter

    uphill_point = height_order[maximum_filter(rank, size=3, mode="nearest").ravel()]
    while True:
        next_uphill_point = uphill_point[uphill_point]
        if np.array_equal(next_uphill_point, uphill_point):
            return np.asarray(uphill_point)
        uphill_point = next_uphill_point


def _find_saddles(
    hill: _IndexArray, rank: NDArray[np.int64], hill_count: int
) -> tuple[_IndexArray, _IndexArray, _IndexArray]:
    """Return the highest saddles that connect all hills: two hill indices and a height rank each, highest first."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import minimum_spanning_tree

    pair_keys, saddle_ranks = [], []
    for point, neighbour in (
        (np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:]),
        (np.s_[:-1, :-1], np.s_[1:, 1:]), (np.s_[:-1, 1:], np.s_[1:, :-1]),
    ):  # fmt: skip
        is_between_hills = hill[point] != hill[neighbour]
        a, b = hill[point][is_between_hills], hill[neighbour][is_between_hills]
        pair_keys.append(np.minimum(a, b) * hill_count + np.maximum(a, b))
        saddle_ranks.append(np.minimum(rank[point][is_between_hills], rank[neighbour][is_between_hills]))
    pair_key, saddle_rank = np.concatenate(pair_keys), np.concatenate(saddle_ranks)
    pair_order = np.lexsort((saddle_rank, pair_key))
    pair_key, saddle_rank = pair_key[pair_order], saddle_rank[pair_order]
    is_highest = np.append(pair_key[1:] != pair_key[:-1], True)
    pair_key, saddle_rank = pair_key[is_highest], saddle_rank[is_highest]
    edges = coo_array(
        ((rank.size - saddle_rank).astype(np.float64), (pair_key // hill_count, pair_key % hill_count)),
        shape=(hill_count, hill_count),
    )
    tree = minimum_spanning_tree(edges.tocsr()).tocoo()
    tree_saddle_rank = (rank.size - tree.data).astype(np.intp)
    descending_order = np.argsort(-tree_saddle_rank)
    return tree.row[descending_order], tree.col[descending_order], tree_saddle_rank[descending_order]


class FeatureParameters(NamedTuple):
    """Feature parameters of a surface: peak density, peak curvature, five-point peak height and pit depth."""

    density: float
    curvature: float
    peak_height: float
    pit_depth: float


def feature_parameters(deviation: Floats, spacing: tuple[float, float]) -> FeatureParameters:
    """Compute peak density, mean peak curvature, five-point peak height and five-point pit depth.

    `deviation` is the height relative to the mean. The density is the number of peaks per nominal area (number of
    points times spacing). The curvature is computed from second differences at peaks that are not on the border. Peaks
    and pits on the border contribute to the density and to the heights.
    """
    threshold = PRUNING_FRACTION * float(np.ptp(deviation))
    peaks, pits = (find_significant_peaks(heights, threshold) for heights in (deviation, -deviation))
    rows, columns = deviation.shape
    peak_rows, peak_columns = np.divmod(peaks, columns)
    is_interior = (peak_rows > 0) & (peak_rows < rows - 1) & (peak_columns > 0) & (peak_columns < columns - 1)
    peak_rows, peak_columns = peak_rows[is_interior], peak_columns[is_interior]
    peak_height = deviation[peak_rows, peak_columns]
    second_derivative_y = (
        deviation[peak_rows - 1, peak_columns] - 2 * peak_height + deviation[peak_rows + 1, peak_columns]
    ) / spacing[0] ** 2
    second_derivative_x = (
        deviation[peak_rows, peak_columns - 1] - 2 * peak_height + deviation[peak_rows, peak_columns + 1]
    ) / spacing[1] ** 2
    curvature = -float(np.mean(second_derivative_x + second_derivative_y)) / 2 if peak_rows.size else math.nan
    flat_heights = deviation.ravel()
    return FeatureParameters(
        density=peaks.size / (rows * spacing[0] * columns * spacing[1]), curvature=curvature,
        peak_height=_mean_of_five_largest(flat_heights[peaks]), pit_depth=_mean_of_five_largest(-flat_heights[pits]),
    )  # fmt: skip


def _mean_of_five_largest(heights: Floats) -> float:
    """Return the mean of the five largest peak heights or pit depths, or NaN if there are fewer than five."""
    return math.nan if heights.size < NUM_AVERAGED_FEATURES else float(np.sort(heights)[-NUM_AVERAGED_FEATURES:].mean())
