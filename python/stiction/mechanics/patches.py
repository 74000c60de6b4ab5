"""What pressures on a grid say of friction: connected patches, true areas, slopes, and the sums over them."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.fft
import scipy.linalg
import scipy.ndimage
import scipy.sparse
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.mechanics.model import Sliding

LEVEL = 1e-6
"""Of the root-mean-square slope in contact: a patch whose mean slope along the direction is less is level, and does not
oppose. The pressures of a level patch, as of a ball on a flat, lean by 1e-9 of it at a tolerance of 1e-6."""

AREA_BEYOND_EDGE = {1: 0.19, 2: (np.pi - 1 + np.log(2)) / 24}
"""Of a cell, by which the points under pressure reach beyond the contact at each open side, by number of dimensions.

On areas: Yastrebov, Anciaux & Molinari, Tribology International 114 (2017) 161. On lines: half of 0.38 +- 0.03 points
for each contact, measured on Westergaard's sinusoid.
"""


def labelled(touching: NDArray[np.bool_], *, periodic: bool) -> tuple[NDArray[np.int64], int]:
    """Patches of connected points, from 1 on, 0 elsewhere, and how many; eight neighbours, over edges if periodic."""
    labels, count = scipy.ndimage.label(touching, np.ones([3] * touching.ndim, int))
    labels = labels.astype(np.int64)
    if not periodic or not count:
        return labels, count
    pairs: list[NDArray[np.int64]] = []
    for axis in range(labels.ndim):
        first, last = np.take(labels, 0, axis), np.take(labels, -1, axis)
        moves = (-1, 0, 1) if labels.ndim > 1 else (0,)
        pairs.extend(np.stack([np.atleast_1d(first), np.atleast_1d(np.roll(last, move))]) for move in moves)
    left, right = np.concatenate(pairs, axis=1)
    both = (left > 0) & (right > 0)
    graph = scipy.sparse.coo_array((np.ones(int(both.sum())), (left[both], right[both])), shape=(count + 1, count + 1))
    together, group = scipy.sparse.csgraph.connected_components(graph, directed=False)
    # The group of label 0, which is nobody else's, becomes 0.
    order = np.empty(together, np.int64)
    order[group[0]] = 0
    order[np.delete(np.arange(together), group[0])] = np.arange(1, together)
    return order[group][labels], together - 1


def true_share(touching: NDArray[np.bool_], *, periodic: bool) -> Floats:
    """The share of each touching cell that is in contact, less than 1 where it has open sides. The grid's edge is none.

    In the order of `numpy.nonzero`.
    """
    padded = np.pad(touching, 1, mode="wrap") if periodic else np.pad(touching, 1, mode="edge")
    inner = tuple([slice(1, -1)] * touching.ndim)
    sides = np.zeros(touching.shape, np.int8)
    for axis in range(touching.ndim):
        for move in (-1, 1):
            sides += ~np.roll(padded, move, axis)[inner]
    return np.asarray(1 - AREA_BEYOND_EDGE[touching.ndim] * sides[touching])


def slopes(heights: Floats, spacing: tuple[float, ...], *, periodic: bool) -> list[Floats]:
    """Slope at every point along each axis: of the waves where periodic, of natural cubic splines elsewhere."""
    along = _wave_slope if periodic else _spline_slope
    return [along(heights, axis, step) for axis, step in enumerate(spacing)]


def _wave_slope(heights: Floats, axis: int, step: float) -> Floats:
    n = heights.shape[axis]
    factor = 2j * np.pi * scipy.fft.rfftfreq(n, step)
    if n % 2 == 0:
        factor[-1] = 0.0  # the shortest wave has no slope at its points
    shape = [1] * heights.ndim
    shape[axis] = factor.size
    waves = scipy.fft.rfft(heights, axis=axis) * factor.reshape(shape)
    return np.asarray(scipy.fft.irfft(waves, n, axis=axis, overwrite_x=True))


def _spline_slope(heights: Floats, axis: int, step: float) -> Floats:
    values = np.moveaxis(heights, axis, 0).reshape(heights.shape[axis], -1)
    right = np.empty_like(values)
    right[1:-1] = values[2:] - values[:-2]
    right[0], right[-1] = values[1] - values[0], values[-1] - values[-2]
    right *= 3 / step
    bands = np.ones((3, values.shape[0]))
    bands[1] = 4.0
    bands[1, [0, -1]] = 2.0
    slope = scipy.linalg.solve_banded((1, 1), bands, right, overwrite_b=True, check_finite=False)
    return np.moveaxis(slope.reshape(np.moveaxis(heights, axis, 0).shape), 0, axis)


def sums(
    force: Floats,
    area: Floats,
    slope: list[Floats],
    patch: NDArray[np.int64],
    directions: Floats,
    sliding: Sliding,
) -> dict[str, Any]:
    """What F_N and F_T need for every mu0 and tau0; those that depend on the direction as (directions,).

    Of each point under pressure: its force on the ground plan (mN), its share of the ground plan (µm²), slopes along y
    and x (or x alone) of the deformed interface, and its patch, from 1 on. Directions are (m, 2) horizontal unit
    vectors.
    """
    along_x = slope[-1]
    along_y = slope[0] if len(slope) == 2 else np.zeros_like(along_x)
    square = 1 + along_x**2 + along_y**2  # q²
    pushing, rubbing = force * np.sqrt(square), area * np.sqrt(square)

    def along(way: Floats) -> dict[str, float]:
        rise = _rise(slope, way)  # -q s·n
        share = 1.0 if sliding == "all" else opposes(force, slope, patch, way)
        # n·s = -rise/q, and t = -s + (s·n) n over its length, sqrt(1 - (s·n)²).
        forward = np.sqrt(1 - rise**2 / square)
        upward = -rise / (square * forward)
        rubbed, stuck = pushing * share, rubbing * share
        return {
            "tangential_elastic": float((rise * force * share).sum()),
            "normal_frictional": float((rubbed * upward).sum()),
            "tangential_frictional": float((rubbed * forward).sum()),
            "normal_adhesive": float((stuck * upward).sum()),
            "tangential_adhesive": float((stuck * forward).sum()),
        }

    each = [along(way) for way in directions]
    return {
        "contact_area": float(rubbing.sum()),
        "normal_elastic": float(force.sum()),
        **{name: np.array([one[name] for one in each]) for name in each[0]},
    }


def opposes(force: Floats, slope: list[Floats], patch: NDArray[np.int64], way: Floats) -> NDArray[np.bool_]:
    """Whether the patch of each point pushes the upper body back; arguments as for `sums`, the direction (x, y)."""
    pushed = np.bincount(patch, weights=_rise(slope, way) * force)
    steepness = np.sqrt(sum(np.square(along) @ force for along in slope) / force.sum())
    opposing = pushed > LEVEL * steepness * np.bincount(patch, weights=force)
    return np.asarray(opposing[patch])


def _rise(slope: list[Floats], way: Floats) -> Floats:
    """Slope along a direction (x, y)."""
    along_y = slope[0] * way[1] if len(slope) == 2 else 0.0
    return np.asarray(slope[-1] * way[0] + along_y)
