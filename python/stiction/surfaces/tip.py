"""Reconstruction of surfaces from scans with a spherical stylus or probe tip."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats, make_read_only, validate_number
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile, reject_missing_points
from stiction.surfaces.surface import Surface, as_body

# A tip touches a point if the gap is at most this fraction of the height range or, if larger, of the maximum |height|.
_TIP_CONTACT_TOLERANCE = 1e-9


def tip_reconstructed(scan: Profile | Surface, radius: float) -> tuple[Profile | Surface, NDArray[np.bool_]]:
    r"""Reconstruct the highest surface from which a spherical tip of given radius would record a given scan.

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
    reject_missing_points(scan, "tip reconstruction")
    radius = validate_number("radius", radius, unit="µm", above=0, below=1e9)
    recorded_heights, spacing = scan.heights, np.array(scan.spacings)
    height_range = float(np.ptp(recorded_heights))
    eroded_heights = _erode_by_tip(recorded_heights, spacing, radius)
    num_touched, is_certain = np.zeros(recorded_heights.shape, np.int32), np.zeros(recorded_heights.shape, np.bool_)
    tolerance = _TIP_CONTACT_TOLERANCE * max(height_range, float(np.abs(recorded_heights).max()))
    _, half_widths = _compute_tip_half_width(recorded_heights.shape, spacing, radius, height_range)
    is_inside = np.zeros(recorded_heights.shape, np.bool_)
    is_inside[
        tuple(
            slice(half_width, points - half_width)
            for half_width, points in zip(half_widths, recorded_heights.shape, strict=True)
        )
    ] = True
    for counts_contacts in (True, False):
        for point_slices, neighbour_slices, tip_height in _iterate_tip_offsets(
            recorded_heights.shape, spacing, radius, height_range
        ):
            is_touching = eroded_heights[neighbour_slices] - tip_height >= recorded_heights[point_slices] - tolerance
            if counts_contacts:
                num_touched[point_slices] += is_touching
            else:
                is_certain[neighbour_slices] |= is_touching & (num_touched[point_slices] == 1) & is_inside[point_slices]
    history_entry = (
        f"reconstructed for a tip radius of {radius:g} µm, {100 * float(is_certain.mean()):.0f} % of the points certain"
    )
    return scan.changed(eroded_heights, history_entry), make_read_only(is_certain)


def sharpened(scan: Profile | Surface, radius: float, factor: float) -> Profile | Surface:
    """Sharpen a scan: subtract from it a multiple of the correction for the tip (scan minus reconstructed surface).

    The factor 1 yields the reconstruction. Larger factors yield estimates of the roughness that the tip did not reach.
    Missing points stay missing, and their interpolated heights are used. The correction is computed for the levelled
    scan, because at the lower edge of a tilted scan, the points that the tip touches are outside the scan.

    Parameters
    ----------
    scan : Profile or Surface
        Recorded heights.
    radius : float, µm
        Radius of the stylus or probe tip, above 0.
    factor : float
        Multiple of the tip correction.
    """
    level_scan = levelled(scan, "line") if isinstance(scan, Profile) else levelled(scan, "plane")
    heights = level_scan.heights
    tip_correction = heights - _erode_by_tip(heights, np.array(scan.spacings), radius)
    history_entry = f"sharpened by {factor:g} times the correction for a tip radius of {radius:g} µm"
    return scan.changed(scan.heights - factor * tip_correction, history_entry)


def _erode_by_tip(heights: Floats, spacing: Floats, radius: float) -> Floats:
    """Return the heights (µm) of the highest surface from which a spherical tip would record the given heights."""
    eroded_heights = heights.copy()
    for point_slices, neighbour_slices, tip_height in _iterate_tip_offsets(
        heights.shape, spacing, radius, float(np.ptp(heights))
    ):
        np.minimum(
            eroded_heights[point_slices], heights[neighbour_slices] + tip_height, out=eroded_heights[point_slices]
        )
    return eroded_heights


def _iterate_tip_offsets(
    shape: tuple[int, ...], spacing: Floats, radius: float, max_tip_height: float
) -> Iterator[tuple[tuple[slice, ...], tuple[slice, ...], float]]:
    """Yield, for each offset from the tip's lowest point, array slices and the height (µm) of the tip at this offset.

    The first slices select the points, the second their neighbours at the offset.
    """
    half_width, half_widths = _compute_tip_half_width(shape, spacing, radius, max_tip_height)
    for steps in np.ndindex(*(2 * max_steps + 1 for max_steps in half_widths)):
        offsets = np.subtract(steps, half_widths)
        squared_distance = float(np.square(offsets * spacing).sum())
        if squared_distance > half_width**2 * (1 + 1e-12):
            continue
        offsets_and_sizes = list(zip(offsets.tolist(), shape, strict=True))
        point_slices, neighbour_slices = (
            tuple(slice(max(0, sign * offset), size + min(0, sign * offset)) for offset, size in offsets_and_sizes)
            for sign in (-1, 1)
        )
        yield point_slices, neighbour_slices, radius - math.sqrt(max(0.0, radius**2 - squared_distance))


def _compute_tip_half_width(
    shape: tuple[int, ...], spacing: Floats, radius: float, tip_height: float
) -> tuple[float, list[int]]:
    """Return half the width of a spherical tip, measured at a given height (µm) above the tip's lowest point.

    The half width is in µm and, for each axis, in points.
    """
    half_width = math.sqrt(radius**2 - max(0.0, radius - tip_height) ** 2)
    return half_width, [
        min(int(half_width / step), points - 1) for step, points in zip(spacing.tolist(), shape, strict=True)
    ]
