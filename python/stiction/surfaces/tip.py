"""Reconstruction of a surface from a scan with a spherical tip."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats, read_only, validate_number
from stiction.surfaces.profile import Profile, reject_missing
from stiction.surfaces.surface import Surface, as_body

_TIP_CONTACT_TOLERANCE = 1e-9  # the tip counts as touching at distances up to this fraction of the height of the scan


def tip_reconstructed(scan: Profile | Surface, radius: float) -> tuple[Profile | Surface, NDArray[np.bool_]]:
    r"""Reconstruct the highest surface for which a spherical tip would record the given scan.

    Parameters
    ----------
    scan : Profile or Surface
        Recorded heights, without noise.
    radius : float, µm
        Radius of the stylus or probe tip, above 0.

    Returns
    -------
    body : Profile or Surface
        Reconstructed body, nowhere above the scan; the step is added to its history.
    certain : ndarray of bool, of the shape of the heights
        True where the tip touches the surface in a single point, so that the height is exact. Elsewhere the true
        surface may be lower.

    Raises
    ------
    ValueError
        If the radius is not above 0, or if points are missing.

    Notes
    -----
    The scan of a tip is the dilation :math:`i(x) = \max_u [s(x + u) - P(u)]` with :math:`P(u) = R - (R^2 - u^2)^{1/2}`.
    The erosion :math:`\min_u [i(x - u) + P(u)]` is the least upper bound of the surface s. It equals s where the tip
    touches this bound in one point (Villarrubia, J. Res. Natl. Inst. Stand. Technol. 102 (1997) 425). Noise is treated
    as roughness, so remove it first. Points from which the tip extends beyond the edges are not certain.

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
    radius = validate_number("radius", radius, unit="µm", above=0, below=1e9)
    recorded, spacing = scan.heights, np.array(scan.spacings)
    deepest = float(np.ptp(recorded))
    eroded = recorded.copy()
    for selected, occupied, depth in _tip_heights(recorded.shape, spacing, radius, deepest):
        np.minimum(eroded[selected], recorded[occupied] + depth, out=eroded[selected])
    num_touched, is_certain = np.zeros(recorded.shape, np.int32), np.zeros(recorded.shape, np.bool_)
    tolerance = _TIP_CONTACT_TOLERANCE * max(deepest, float(np.abs(recorded).max()))
    _, limit = _tip_half_width(recorded.shape, spacing, radius, deepest)
    inside = np.zeros(recorded.shape, np.bool_)
    inside[tuple(slice(reach, points - reach) for reach, points in zip(limit, recorded.shape, strict=True))] = True
    for counting in (True, False):
        for selected, occupied, depth in _tip_heights(recorded.shape, spacing, radius, deepest):
            index = eroded[occupied] - depth >= recorded[selected] - tolerance
            if counting:
                num_touched[selected] += index
            else:
                is_certain[occupied] |= index & (num_touched[selected] == 1) & inside[selected]
    step = (
        f"reconstructed for a tip radius of {radius:g} µm, {100 * float(is_certain.mean()):.0f} % of the points certain"
    )
    return scan.changed(eroded, step), read_only(is_certain)


def _tip_heights(
    shape: tuple[int, ...], spacing: Floats, radius: float, deepest: float
) -> Iterator[tuple[tuple[slice, ...], tuple[slice, ...], float]]:
    """Yield, for each offset within reach of the tip: slices of points and of their neighbours, and the tip height."""
    reach, limit = _tip_half_width(shape, spacing, radius, deepest)
    for steps in np.ndindex(*(2 * item + 1 for item in limit)):
        offsets = np.subtract(steps, limit)
        square = float(np.square(offsets * spacing).sum())
        if square > reach**2 * (1 + 1e-12):
            continue
        sizes = list(zip(offsets.tolist(), shape, strict=True))
        selected, occupied = (
            tuple(slice(max(0, sign * offset), points + min(0, sign * offset)) for offset, points in sizes)
            for sign in (-1, 1)
        )
        yield selected, occupied, radius - math.sqrt(max(0.0, radius**2 - square))


def _tip_half_width(shape: tuple[int, ...], spacing: Floats, radius: float, deepest: float) -> tuple[float, list[int]]:
    """Return the half width of a tip at the height `deepest` above its lowest point, in µm and in points per axis."""
    reach = math.sqrt(radius**2 - max(0.0, radius - deepest) ** 2)
    return reach, [min(int(reach / step), points - 1) for step, points in zip(spacing.tolist(), shape, strict=True)]
