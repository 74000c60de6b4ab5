"""Hills and dales of a surface: watershed segmentation with Wolf pruning, and the feature parameters of ISO 25178-2."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats

PRUNING_FRACTION = 0.05  # fraction of the maximum height below which a hill or a dale is merged with its neighbour
NUM_FEATURES = 5  # number of peaks or pits of the five-point parameters

_Indices = NDArray[np.intp]


def significant_peaks(heights: Floats, threshold: float) -> _Indices:
    """Return the flat indices of the peaks of the hills that remain after Wolf pruning.

    Parameters
    ----------
    heights : (rows, columns) ndarray
        For pits, their negative.
    threshold : float
        Hills whose peak is less than this above their highest saddle are merged across the saddle.

    Notes
    -----
    Every point belongs to the peak that the steepest of its eight neighbours leads to. Merging the lowest hill first,
    as Wolf pruning does, leaves the peaks that the highest saddle on the way to any higher peak lies by at least the
    threshold below; these are read from the maximum spanning tree of saddles between neighbouring hills.
    """
    order = np.argsort(heights, axis=None, kind="stable")
    rank = np.empty(heights.size, np.int64)  # equal heights are ordered by their place
    rank[order] = np.arange(heights.size)
    hill = _hills(rank.reshape(heights.shape), order)
    peaks, hill = np.unique(hill, return_inverse=True)
    if peaks.size == 1:
        return peaks
    first, second, saddle = _saddles(hill.reshape(heights.shape), rank.reshape(heights.shape), peaks.size)
    level = heights.ravel()[order[saddle]].tolist()
    top = heights.ravel()[peaks].tolist()
    above = rank[peaks].tolist()
    root = list(range(peaks.size))
    keep = np.ones(peaks.size, bool)

    def find(index: int) -> int:
        while root[index] != index:
            root[index] = root[root[index]]
            index = root[index]
        return index

    for one, other, height in zip(first.tolist(), second.tolist(), level, strict=True):
        low, high = find(one), find(other)
        if above[low] > above[high]:
            low, high = high, low
        root[low] = high
        keep[low] = top[low] - height >= threshold
    return np.asarray(peaks[keep])


def _hills(rank: NDArray[np.int64], order: _Indices) -> _Indices:
    """Return the flat index of the peak that each point leads to."""
    from scipy.ndimage import maximum_filter

    above = order[maximum_filter(rank, size=3, mode="nearest").ravel()]
    while True:
        further = above[above]
        if np.array_equal(further, above):
            return np.asarray(above)
        above = further


def _saddles(hill: _Indices, rank: NDArray[np.int64], count: int) -> tuple[_Indices, _Indices, _Indices]:
    """Return pairs of hills and the ranks of their saddles, falling, that connect all hills as high as possible."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import minimum_spanning_tree

    keys, levels = [], []
    for one, other in (
        (np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:]),
        (np.s_[:-1, :-1], np.s_[1:, 1:]), (np.s_[:-1, 1:], np.s_[1:, :-1]),
    ):  # fmt: skip
        apart = hill[one] != hill[other]
        a, b = hill[one][apart], hill[other][apart]
        keys.append(np.minimum(a, b) * count + np.maximum(a, b))
        levels.append(np.minimum(rank[one][apart], rank[other][apart]))
    key, level = np.concatenate(keys), np.concatenate(levels)
    order = np.lexsort((level, key))
    key, level = key[order], level[order]
    highest = np.append(key[1:] != key[:-1], True)
    key, level = key[highest], level[highest]
    edges = coo_array(((rank.size - level).astype(np.float64), (key // count, key % count)), shape=(count, count))
    tree = minimum_spanning_tree(edges.tocsr()).tocoo()
    saddle = (rank.size - tree.data).astype(np.intp)
    falling = np.argsort(-saddle)
    return tree.row[falling], tree.col[falling], saddle[falling]


class FeatureParameters(NamedTuple):
    """Feature parameters; NaN where a map has too few peaks or pits."""

    density: float
    curvature: float
    peak_height: float
    pit_depth: float


def feature_parameters(deviation: Floats, spacing: tuple[float, float]) -> FeatureParameters:
    """Compute peak density, mean peak curvature, and five-point peak height and pit depth of heights about their mean.

    The density is per area of points times spacing. The curvature is that of second differences, of peaks inside of
    the map. Peaks and pits at its border count for density and heights.
    """
    threshold = PRUNING_FRACTION * float(np.ptp(deviation))
    peaks, pits = (significant_peaks(heights, threshold) for heights in (deviation, -deviation))
    rows, columns = deviation.shape
    row, column = np.divmod(peaks, columns)
    inside = (row > 0) & (row < rows - 1) & (column > 0) & (column < columns - 1)
    row, column = row[inside], column[inside]
    at = deviation[row, column]
    bend_y = (deviation[row - 1, column] - 2 * at + deviation[row + 1, column]) / spacing[0] ** 2
    bend_x = (deviation[row, column - 1] - 2 * at + deviation[row, column + 1]) / spacing[1] ** 2
    curvature = -float(np.mean(bend_x + bend_y)) / 2 if row.size else math.nan
    flat = deviation.ravel()
    return FeatureParameters(
        density=peaks.size / (rows * spacing[0] * columns * spacing[1]), curvature=curvature,
        peak_height=_mean_of_five(flat[peaks]), pit_depth=_mean_of_five(-flat[pits]),
    )  # fmt: skip


def _mean_of_five(heights: Floats) -> float:
    """Return the mean of the five largest heights; NaN if there are fewer."""
    return math.nan if heights.size < NUM_FEATURES else float(np.sort(heights)[-NUM_FEATURES:].mean())
