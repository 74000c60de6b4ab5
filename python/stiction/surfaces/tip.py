"""Reconstruction of a surface from a scan with a spherical tip."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats, number, read_only
from stiction.surfaces.profile import Profile, reject_missing
from stiction.surfaces.surface import Surface, as_body

_TOUCHING = 1e-9  # distance at which the tip touches, over the height of the scan


def tip_reconstructed(scan: Profile | Surface, radius: float) -> tuple[Profile | Surface, NDArray[np.bool_]]:
    r"""Reconstruct the highest surface that a spherical tip would record as this scan, and where it is exact.

    Parameters
    ----------
    scan : Profile or Surface
    radius : float, µm
        Of the stylus or the probe, above 0.

    Returns
    -------
    body : Profile or Surface
        Nowhere above the scan; the step is added to its history.
    certain : ndarray of bool, of the shape of the heights
        Points where the tip touches in a single point and the surface is exact; elsewhere it may be lower.

    Notes
    -----
    A ball that touches records :math:`i(x) = \max_u [s(x + u) - P(u)]` with :math:`P(u) = R - (R^2 - u^2)^{1/2}`; the
    erosion :math:`\min_u [i(x - u) + P(u)]` is the least upper bound of s, and s itself where the ball at its place
    touches that bound in one point (Villarrubia, J. Res. Natl. Inst. Stand. Technol. 102 (1997) 425). Noise is taken
    for surface: take it off first. Of a ball that reaches beyond the edges nothing is certain.

    Examples
    --------
    >>> from stiction import Profile, tip_reconstructed
    >>> seen = Profile([0.0, 0.0, 0.732, 1.0, 0.732, 0.0, 0.0], spacing=1.0)  # a spike under a ball of 2 µm
    >>> body, certain = tip_reconstructed(seen, 2.0)
    >>> body.heights.round(3), certain.tolist()
    (array([0.   , 0.   , 0.268, 1.   , 0.268, 0.   , 0.   ]), [False, False, False, True, False, False, False])
    """
    scan = as_body("scan", scan)
    reject_missing(scan, "tip reconstruction")
    radius = number("radius", radius, unit="µm", above=0, below=1e9)
    seen, spacing = scan.heights, np.array(scan.spacings)
    deepest = float(np.ptp(seen))
    eroded = seen.copy()
    for here, there, depth in _ball(seen.shape, spacing, radius, deepest):
        np.minimum(eroded[here], seen[there] + depth, out=eroded[here])
    touched, alone = np.zeros(seen.shape, np.int32), np.zeros(seen.shape, np.bool_)
    near = _TOUCHING * max(deepest, float(np.abs(seen).max()))
    _, most = _reach(seen.shape, spacing, radius, deepest)
    inside = np.zeros(seen.shape, np.bool_)
    inside[tuple(slice(each, points - each) for each, points in zip(most, seen.shape, strict=True))] = True
    for counting in (True, False):
        for here, there, depth in _ball(seen.shape, spacing, radius, deepest):
            at = eroded[there] - depth >= seen[here] - near
            if counting:
                touched[here] += at
            else:
                alone[there] |= at & (touched[here] == 1) & inside[here]
    step = f"a ball of {radius:g} µm taken back, {100 * float(alone.mean()):.0f} % of the points certain"
    return scan.changed(eroded, step), read_only(alone)


def _ball(
    shape: tuple[int, ...], spacing: Floats, radius: float, deepest: float
) -> Iterator[tuple[tuple[slice, ...], tuple[slice, ...], float]]:
    """Points, those beside them by each step that a ball reaches, and how far it lies above its lowest point there."""
    reach, most = _reach(shape, spacing, radius, deepest)
    for steps in np.ndindex(*(2 * each + 1 for each in most)):
        moved = np.subtract(steps, most)
        square = float(np.square(moved * spacing).sum())
        if square > reach**2 * (1 + 1e-12):
            continue
        sizes = list(zip(moved.tolist(), shape, strict=True))
        here, there = (
            tuple(slice(max(0, sign * each), points + min(0, sign * each)) for each, points in sizes)
            for sign in (-1, 1)
        )
        yield here, there, radius - math.sqrt(max(0.0, radius**2 - square))


def _reach(shape: tuple[int, ...], spacing: Floats, radius: float, deepest: float) -> tuple[float, list[int]]:
    """How far from its lowest point a ball touches where heights span so much, µm, and in points along each axis."""
    reach = math.sqrt(radius**2 - max(0.0, radius - deepest) ** 2)
    return reach, [min(int(reach / step), points - 1) for step, points in zip(spacing.tolist(), shape, strict=True)]
