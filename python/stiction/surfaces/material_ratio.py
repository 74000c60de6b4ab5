"""Material ratio curve (bearing curve) of a profile or a height map, and the parameters of this curve."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, float_array
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface, as_body

CORE_LINE_MATERIAL_FRACTION = 0.4
# Material ratios that separate peaks from the core, and the core from valleys: the defaults of ISO 25178-3.
PEAK_MATERIAL_RATIO, VALLEY_MATERIAL_RATIO = 0.1, 0.8
# The extreme peak height is the height between these two material ratios: the defaults of ISO 25178-3.
EXTREME_PEAK_MATERIAL_RATIOS = 0.025, 0.5


def bearing_curve(body: Profile | Surface, ratios: ArrayLike) -> Floats:
    """Return the heights (µm) of a body at given material ratios: the Abbott-Firestone curve.

    Parameters
    ----------
    body : Profile or Surface
        Body whose heights are evaluated, with the interpolated heights of missing points.
    ratios : array_like of float
        Material ratios from 0 to 1, of any shape.

    Returns
    -------
    heights : ndarray of float, µm
        Heights with the shape of `ratios`: the highest point at ratio 0, the lowest point at ratio 1.

    Raises
    ------
    ValueError
        If a ratio is outside the range 0 to 1.

    See Also
    --------
    material_ratio : Inverse function.

    Examples
    --------
    >>> from stiction import Surface, bearing_curve
    >>> bearing_curve(Surface([[0.0, 1.0], [2.0, 3.0]], spacing=1.0), [0.0, 0.5, 1.0])
    array([3. , 1.5, 0. ])
    """
    body = as_body("body", body)
    target_ratios = float_array("ratios", ratios)
    if target_ratios.size and not (target_ratios.min() >= 0 and target_ratios.max() <= 1):
        raise ValueError(f"ratios must be between 0 and 1, got {target_ratios.min():g} to {target_ratios.max():g}")
    return heights_at_material_ratios(body.heights, target_ratios)


def material_ratio(body: Profile | Surface, heights: ArrayLike) -> Floats:
    """Return the material ratios of a body at given heights (µm).

    Parameters
    ----------
    body : Profile or Surface
        Body whose heights are evaluated, with the interpolated heights of missing points.
    heights : array_like of float, µm
        Section heights c on the scale of the heights of `body`, of any shape.

    Returns
    -------
    ratios : ndarray of float
        Material ratios from 0 to 1, with the shape of `heights`.

    Raises
    ------
    ValueError
        If a height is not finite.

    See Also
    --------
    bearing_curve : Inverse function.

    Notes
    -----
    The ratios are Rmr(c) of ISO 21920-2 or Smr(c) of ISO 25178-2 if the mean height of the body is 0.

    Examples
    --------
    >>> from stiction import Surface, material_ratio
    >>> material_ratio(Surface([[0.0, 1.0], [2.0, 3.0]], spacing=1.0), [-1.0, 1.5, 3.5])
    array([1. , 0.5, 0. ])
    """
    body = as_body("body", body)
    section_heights = float_array("heights", heights)
    sorted_heights = np.sort(body.heights, axis=None)
    return np.asarray(1 - np.searchsorted(sorted_heights, section_heights, side="right") / sorted_heights.size)


def heights_at_material_ratios(heights: Floats, ratios: ArrayLike) -> Floats:
    """Return the heights above which given fractions of the points lie (material ratios).

    The material ratio of a height is the fraction of higher points.
    """
    return np.asarray(np.quantile(heights, 1 - np.asarray(ratios)))


class VolumeParameters(NamedTuple):
    """Volumes of peak material, core material, core void and valley void of a surface, each divided by the area."""

    peak_material: float
    core_material: float
    core_void: float
    valley_void: float


def material_volumes(heights: Floats) -> VolumeParameters:
    """Compute volumes of material and void per area, for peaks, core (material ratio 10 % to 80 %) and valleys."""
    core_top, core_bottom = heights_at_material_ratios(heights, [PEAK_MATERIAL_RATIO, VALLEY_MATERIAL_RATIO]).tolist()
    peak_volume, volume_above_bottom = (
        float(np.maximum(heights - core_limit, 0).mean()) for core_limit in (core_top, core_bottom)
    )
    void_below_top, valley_volume = (
        float(np.maximum(core_limit - heights, 0).mean()) for core_limit in (core_top, core_bottom)
    )
    return VolumeParameters(
        peak_volume, volume_above_bottom - peak_volume, void_below_top - valley_volume, valley_volume
    )


class CoreParameters(NamedTuple):
    """Core height, reduced peak height, reduced pit depth, and the limits of the core as material ratios."""

    core_height: float
    reduced_peak_height: float
    reduced_pit_depth: float
    upper_core_ratio: float
    lower_core_ratio: float


def core_parameters(heights: Floats) -> CoreParameters:
    """Compute the ISO 25178-2 parameters of core, peaks and pits from the material ratio curve of a surface."""
    core_height, core_top, core_bottom = _fit_core_line(heights)
    heights_above_core, depths_below_core = np.maximum(heights - core_top, 0), np.maximum(core_bottom - heights, 0)
    peak_fraction, valley_fraction = float(np.mean(heights > core_top)), float(np.mean(heights < core_bottom))
    reduced_peaks = 2 * float(heights_above_core.mean()) / peak_fraction if peak_fraction else 0.0
    reduced_valleys = 2 * float(depths_below_core.mean()) / valley_fraction if valley_fraction else 0.0
    return CoreParameters(core_height, reduced_peaks, reduced_valleys, peak_fraction, 1 - valley_fraction)


def _fit_core_line(deviation: Floats) -> tuple[float, float, float]:
    """Fit a straight line to the core of the material ratio curve, where the curve is flattest.

    Returns the line's heights at material ratios of 0 and 100 %, preceded by their difference.
    """
    heights = np.sort(deviation, axis=None)[::-1]
    points = heights.size
    core_points = max(2, round(CORE_LINE_MATERIAL_FRACTION * points))
    height_falls = heights[: points - core_points + 1] - heights[core_points - 1 :]
    start = int(np.argmin(height_falls))
    ratio = (np.arange(start, start + core_points) + 0.5) / points
    centred_ratio = ratio - ratio.mean()
    slope = float(centred_ratio @ heights[start : start + core_points] / (centred_ratio @ centred_ratio))
    line_top = float(heights[start : start + core_points].mean()) - slope * float(ratio.mean())
    return -slope, line_top, line_top + slope
