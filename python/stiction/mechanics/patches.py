"""What pressures on a grid say of friction: connected patches, true areas, slopes, and the sums over them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.fft
import scipy.ndimage
import scipy.sparse
from numpy.typing import ArrayLike, NDArray

import stiction._core as _core
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


def labelled(touching: NDArray[np.bool_], *, periodic: bool) -> tuple[NDArray[np.int32], int]:
    """Patches of connected points, from 1 on, 0 elsewhere, and how many; eight neighbours, over edges if periodic."""
    labels, count = scipy.ndimage.label(touching, np.ones([3] * touching.ndim, int))
    if not periodic or not count:
        return labels, count
    pairs: list[NDArray[np.int32]] = []
    for axis in range(labels.ndim):
        first, last = np.take(labels, 0, axis), np.take(labels, -1, axis)
        moves = (-1, 0, 1) if labels.ndim > 1 else (0,)
        pairs.extend(np.stack([np.atleast_1d(first), np.atleast_1d(np.roll(last, move))]) for move in moves)
    left, right = np.concatenate(pairs, axis=1)
    both = (left > 0) & (right > 0)
    graph = scipy.sparse.coo_array((np.ones(int(both.sum())), (left[both], right[both])), shape=(count + 1, count + 1))
    together, group = scipy.sparse.csgraph.connected_components(graph, directed=False)
    # The group of label 0, which is nobody else's, becomes 0.
    order = np.empty(together, np.int32)
    order[group[0]] = 0
    order[np.delete(np.arange(together), group[0])] = np.arange(1, together)
    return order[group][labels], together - 1


def true_share(touching: NDArray[np.bool_], *, periodic: bool, least: ArrayLike = 0.0) -> Floats:
    """The share of each touching cell that is in contact, less than 1 where it has open sides. The grid's edge is none.

    In the order of `numpy.nonzero`, as `least` is, which no cell has less than: what it bears over the most that it
    could bear if all of it were in contact. So no cell's pressure in contact is above the hardness.
    """
    padded = np.pad(touching, 1, mode="wrap") if periodic else np.pad(touching, 1, mode="edge")
    inner = [slice(1, -1)] * touching.ndim
    closed = np.zeros(touching.shape, np.int8)
    for axis in range(touching.ndim):
        for beside in (slice(None, -2), slice(2, None)):
            closed += padded[(*inner[:axis], beside, *inner[axis + 1 :])]
    sides = 2 * touching.ndim - closed[touching]
    return np.asarray(np.maximum(1 - AREA_BEYOND_EDGE[touching.ndim] * sides, least))


def slopes(heights: Floats, spacing: tuple[float, ...], *, periodic: bool) -> list[Floats]:
    """Slope at every point along each axis: of the waves where periodic, of natural cubic splines elsewhere."""
    if periodic:
        return [_wave_slope(heights, axis, step) for axis, step in enumerate(spacing)]
    rows = np.atleast_2d(heights)
    by_y, by_x = _core.natural_slopes(np.ascontiguousarray(rows), spacing=(spacing[0], spacing[-1]))
    return [by_y, by_x] if heights.ndim == 2 else [by_x[0]]


def _wave_slope(heights: Floats, axis: int, step: float) -> Floats:
    n = heights.shape[axis]
    factor = 2j * np.pi * scipy.fft.rfftfreq(n, step)
    if n % 2 == 0:
        factor[-1] = 0.0  # the shortest wave has no slope at its points
    shape = [1] * heights.ndim
    shape[axis] = factor.size
    waves = scipy.fft.rfft(heights, axis=axis) * factor.reshape(shape)
    return np.asarray(scipy.fft.irfft(waves, n, axis=axis, overwrite_x=True))


@dataclass(frozen=True, eq=False)
class PatchSums:
    """What F_N and F_T need for every mu0 and tau0, of each patch: (patches,), or (directions, patches).

    Attributes
    ----------
    force, area : ndarray, mN and µm²
        Σ F n_z, and the area along the deformed interface.
    leaning : ndarray, mN
        -Σ F s·n.
    upward, forward : ndarray, mN
        Σ F t_z and -Σ F s·t, for friction.
    upward_area, forward_area : ndarray, µm²
        Σ A t_z and -Σ A s·t, for adhesion.
    steepness : float
        Root-mean-square slope in contact, weighted with the force.
    """

    force: Floats
    area: Floats
    leaning: Floats
    upward: Floats
    forward: Floats
    upward_area: Floats
    forward_area: Floats
    steepness: float

    @property
    def opposing(self) -> NDArray[np.bool_]:
        """(directions, patches): whether a patch pushes the upper body back."""
        return np.asarray(self.leaning > LEVEL * self.steepness * self.force)

    def total(self, sliding: Sliding) -> dict[str, Any]:
        """The sums of a `HalfSpaceCurve` by a sliding rule; those that depend on the direction as (directions,)."""
        rubs = True if sliding == "all" else self.opposing
        each = {
            "tangential_elastic": self.leaning,
            "normal_frictional": self.upward,
            "tangential_frictional": self.forward,
            "normal_adhesive": self.upward_area,
            "tangential_adhesive": self.forward_area,
        }
        return {
            "contact_area": float(self.area.sum()),
            "normal_elastic": float(self.force.sum()),
            **{name: values.sum(axis=1, where=rubs) for name, values in each.items()},
        }


def patch_sums(
    force: Floats, area: Floats, slope: list[Floats], patch: NDArray[np.integer[Any]], directions: Floats
) -> PatchSums:
    """Sums over the points of each patch.

    Of each point under pressure: its force on the ground plan (mN), its share of the ground plan (µm²), slopes along y
    and x (or x alone) of the deformed interface, and its patch, from 1 on. Directions are (m, 2) horizontal unit
    vectors.
    """
    along_x = slope[-1]
    along_y = slope[0] if len(slope) == 2 else np.zeros_like(along_x)
    steep = along_x**2 + along_y**2
    stretch = np.sqrt(1 + steep)  # q

    def over_patches(values: Floats) -> Floats:
        return np.asarray(np.bincount(patch, weights=values)[1:], np.float64)

    def along(way: Floats) -> list[Floats]:
        rise = along_x * way[0] + along_y * way[1]  # -q s·n
        across = along_x * way[1] - along_y * way[0]
        # t = -s + (s·n) n over its length, sqrt(1 - (s·n)²), which is level/q: F q t_z is -F rise/level.
        level = np.sqrt(1 + across**2)
        upward = -rise / level
        return [
            over_patches(values)
            for values in (rise * force, upward * force, level * force, upward * area, level * area)
        ]

    leaning, *rubbing = (np.array(columns) for columns in zip(*map(along, directions), strict=True))
    upward, forward, upward_area, forward_area = rubbing
    return PatchSums(
        force=over_patches(force),
        area=over_patches(area * stretch),
        leaning=leaning,
        upward=upward,
        forward=forward,
        upward_area=upward_area,
        forward_area=forward_area,
        steepness=float(np.sqrt((steep * force).sum() / force.sum())),
    )


def sums(
    force: Floats,
    area: Floats,
    slope: list[Floats],
    patch: NDArray[np.integer[Any]],
    directions: Floats,
    sliding: Sliding,
) -> dict[str, Any]:
    """The sums of a `HalfSpaceCurve` by a sliding rule; other arguments as for `patch_sums`."""
    return patch_sums(force, area, slope, patch, directions).total(sliding)
