"""Roughness parameters of primary profiles and height maps: height, slope, texture and feature parameters."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np

from stiction._checks import Floats, check_choice
from stiction.surfaces.features import feature_parameters
from stiction.surfaces.material_ratio import (
    EXTREME_PEAK_MATERIAL_RATIOS,
    PEAK_MATERIAL_RATIO,
    VALLEY_MATERIAL_RATIO,
    core_parameters,
    heights_at_material_ratios,
    material_volumes,
)
from stiction.surfaces.parameters import (
    NOT_LEVELLED_VALUE,
    PROFILE_PARAMETERS,
    SURFACE_PARAMETERS,
    RoughnessParameterSet,
)
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectrum import surface_spectrum
from stiction.surfaces.surface import BodyLike, Surface, as_body, reject_flat_body

DerivativeFormula = Literal["seven-point", "neighbours"]
SEVEN_POINT_WEIGHTS = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0])
# Sal and Str are computed at the decay of the autocorrelation to this number, the default of ISO 25178-3.
DECAY_AUTOCORRELATION = 0.2
_NUM_DIRECTIONS = 720
_NUM_ANGULAR_SECTORS = 90


def describe_levelling(history: tuple[str, ...]) -> str:
    """Return how a body was last levelled, such as "by a plane", according to its history."""
    forms = [step.removeprefix("levelled ") for step in history if step.startswith("levelled ")]
    return forms[-1] if forms else NOT_LEVELLED_VALUE


class RoughnessParameters(RoughnessParameterSet):
    """Roughness parameters of a primary profile about the mean height, named as in ISO 21920-2.

    The reference page on roughness parameters lists the names, formulas and units.

    Examples
    --------
    >>> from stiction import Profile, roughness_parameters
    >>> roughness_parameters(Profile([0.0, 0.01, 0.0, -0.01, 0.0, 0.01, 0.0, -0.01], spacing=2.0))
    RoughnessParameters
      Pa        5 nm
      Pq        7.071 nm
      Pt        20 nm
      Psk       0
      Pku       2
      Pdq       0.005185
      levelled  no
    """


def roughness_parameters(
    profile: BodyLike, *, derivative: DerivativeFormula = "seven-point", spacing: Any = None, unit: str = "um"
) -> RoughnessParameters:
    """Compute the roughness parameters of a primary profile about the mean height (P-parameters of ISO 21920-2).

    Parameters
    ----------
    profile : Profile or array_like
        Heights; not flat, and at least 7 points. Level and filter the profile first.
    derivative : {"seven-point", "neighbours"}
        Slope formula for Pdq. "seven-point" is the formula of ISO 4287 and of instruments. It is evaluated at points
        with three neighbours on each side, and attenuates wavelengths near twice the spacing. "neighbours" is the
        difference of two adjacent heights divided by the spacing, which is the usual formula of contact models.
    spacing : float (µm) or str
        Distance between the points of an array, such as 0.5 or "39 nm"; required for arrays.
    unit : str
        Unit of the heights of an array.

    Returns
    -------
    parameters : RoughnessParameters
        Heights Pa, Pq and Pt (µm), and Psk, Pku and Pdq (dimensionless).

    Raises
    ------
    ValueError
        If the profile is flat or has fewer than 7 points, or an array has no spacing.

    See Also
    --------
    section_parameters : R- and W-parameters, after the filters that drawings specify.
    surface_parameters : Parameters of a map.

    Notes
    -----
    Seven points: :math:`z'_i = (z_{i+3} - 9z_{i+2} + 45z_{i+1} - 45z_{i-1} + 9z_{i-2} - z_{i-3}) / 60Δx`. For a
    sinusoid of wavelength λ the slope is too small by a factor 1 - (2πΔx/λ)^6/140; the difference of neighbours is
    too small by 1 - (2πΔx/λ)²/24. The slope of a self-affine profile depends on the shortest wavelength, and therefore
    on the formula.

    Examples
    --------
    >>> from stiction import Profile, roughness_parameters
    >>> roughness_parameters(Profile([0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0, -1.0], spacing=2.0)).Pa
    0.5
    """
    profile = as_body("profile", profile, Profile, spacing=spacing, unit=unit)
    check_choice("derivative", derivative, DerivativeFormula)
    reject_flat_body(profile)
    z = profile.heights
    if z.size < SEVEN_POINT_WEIGHTS.size:
        raise ValueError(f"profile must have at least {SEVEN_POINT_WEIGHTS.size} points, got {z.size}")
    parameter_values = height_and_slope_parameters(z - z.mean(), profile.spacing, derivative)
    values = {parameter.name: parameter_values[parameter.name[1:]] for parameter in PROFILE_PARAMETERS["P"]}
    return RoughnessParameters(values, describe_levelling(profile.history))


def height_and_slope_parameters(z: Floats, spacing: float, derivative: DerivativeFormula) -> dict[str, float]:
    """Compute height and slope parameters of a profile, keyed by name without P, R or W: "q" for Pq, Rq or Wq."""
    scale = float(np.abs(z).max()) or 1.0
    # The heights are scaled, because their fourth power could overflow or underflow.
    scaled_heights = z / scale
    rms = float(np.sqrt(np.mean(scaled_heights**2)))
    differences = (
        np.correlate(scaled_heights, SEVEN_POINT_WEIGHTS, mode="valid") / 60
        if derivative == "seven-point"
        else np.diff(scaled_heights)
    )
    return {
        "a": scale * float(np.mean(np.abs(scaled_heights))), "q": scale * rms, "t": float(np.ptp(z)),
        "sk": float(np.mean((scaled_heights / rms) ** 3)) if rms else math.nan,
        "ku": float(np.mean((scaled_heights / rms) ** 4)) if rms else math.nan,
        "dq": scale * float(np.sqrt(np.mean(differences**2))) / spacing,
    }  # fmt: skip


class SurfaceParameters(RoughnessParameterSet):
    """Roughness parameters of a height map about the mean height, named as in ISO 25178-2.

    The reference page on roughness parameters lists the names, formulas and units.

    Examples
    --------
    >>> from stiction import self_affine_surface, surface_parameters
    >>> surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1)
    >>> round(surface_parameters(surface).Sq, 6)
    0.02
    """


def surface_parameters(
    surface: BodyLike, *, derivative: DerivativeFormula = "seven-point", spacing: Any = None, unit: str = "um"
) -> SurfaceParameters:
    r"""Compute the roughness parameters of a height map about the mean height (ISO 25178-2).

    Parameters
    ----------
    surface : Surface or array_like
        Heights; not flat, and at least 7 by 7 points. Level and filter the surface first.
    derivative : {"seven-point", "neighbours"}
        Slope formula for Sdq, as for `roughness_parameters`. Slopes are computed along rows and columns, and their
        mean squares are added.
    spacing : float (µm) or str, or a pair (y, x) of either
        Distance between the points of an array, such as 0.5 or "39 nm"; required for arrays.
    unit : str
        Unit of the heights of an array.

    Returns
    -------
    parameters : SurfaceParameters
        Parameters with the names of ISO 25178-2, in µm and its powers, angles in degrees. Sal is NaN if the
        autocorrelation does not decrease to 0.2 within half of the surface. Str is NaN if this happens in any
        direction; its value is then below the ratio of Sal to half of the shorter side. S5p, S5v and S10z are NaN if
        there are fewer than five peaks or pits.

    Raises
    ------
    ValueError
        If the surface is flat or has fewer than 7 by 7 points, or an array has no spacing.

    See Also
    --------
    roughness_parameters : Parameters of a profile.

    Notes
    -----
    Sdr is the mean over both ways to divide a grid cell into two triangles.

    The autocorrelation follows ISO 25178-2: the mean product over the overlap of the surface and its shifted copy,
    divided by the mean square. Along each of 720 directions, Sal and Str use the first shift at which it decreases to
    0.2. Shifts extend to half the length along each axis, with bilinear interpolation between grid points.

    Std is computed after a Hann window. The power is summed over sectors of two degrees, from the third harmonic of the
    longer side to the smaller Nyquist wave number, up to which all directions are available. The lay is perpendicular
    to Std. Std is meaningless if Str is near 1. Ssw is the wavelength of the largest Fourier coefficient without a
    window.

    The core is the 40 % of the points over which a secant of the material ratio curve is least steep. A straight line
    is fitted to the core by least squares; Sk is its drop from 0 to 100 %. Spk and Svk are heights of triangles with
    the areas of the peaks above and the valleys below the core, on the bases Smr1 and 1 - Smr2. For the volumes, peaks,
    core and valleys are separated at material ratios of 10 % and 80 %.

    Peaks and pits belong to hills and dales with eight neighbours, merged by Wolf pruning below 5 % of Sz. Spd, S5p and
    S5v include features that are cut by the border. Spc is the mean curvature of the peaks that are not on the border,
    from second differences.

    ISO 25178-2:2021.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Surface, surface_parameters
    >>> grooves = np.sin(2 * np.pi * np.arange(100) / 20) + np.zeros((50, 1))  # that run along y
    >>> found = surface_parameters(Surface(grooves, spacing=0.5))
    >>> round(found.Sq, 6), found.Std, round(found.Sku, 6)
    (0.707107, 0.0, 1.5)
    """
    surface = as_body("surface", surface, Surface, spacing=spacing, unit=unit)
    check_choice("derivative", derivative, DerivativeFormula)
    reject_flat_or_small_surface(surface)
    z = surface.heights
    deviation = z - z.mean()
    scale = float(np.abs(deviation).max())
    deviation /= scale
    values = {
        **_compute_height_parameters(deviation, scale),
        **_compute_material_ratio_parameters(deviation, scale),
        **_compute_texture_parameters(surface, deviation),
        **_compute_feature_parameters(deviation, scale, surface.spacing),
        "Sz": float(np.ptp(z)),
        "Sdq": rms_gradient(surface, derivative),
        "Sdr": _compute_developed_area_ratio(z, surface.spacing),
    }
    return SurfaceParameters(
        {parameter.name: values[parameter.name] for parameter in SURFACE_PARAMETERS},
        describe_levelling(surface.history),
    )


def reject_flat_or_small_surface(surface: Surface) -> None:
    """Raise a `ValueError` for a height map that is flat, or has too few points for roughness parameters."""
    reject_flat_body(surface)
    min_points, shape = SEVEN_POINT_WEIGHTS.size, surface.heights.shape
    if min(shape) < min_points:
        raise ValueError(f"surface must have at least {min_points} rows and {min_points} columns, got {shape}")


def _compute_height_parameters(deviation: Floats, scale: float) -> dict[str, float]:
    rms = float(np.sqrt(np.mean(deviation**2)))
    return {
        "Sq": scale * rms, "Sa": scale * float(np.mean(np.abs(deviation))), "Sp": scale * float(deviation.max()),
        "Sv": -scale * float(deviation.min()), "Ssk": float(np.mean((deviation / rms) ** 3)),
        "Sku": float(np.mean((deviation / rms) ** 4)),
    }  # fmt: skip


def _compute_material_ratio_parameters(deviation: Floats, scale: float) -> dict[str, float]:
    core, volumes = core_parameters(deviation), material_volumes(deviation)
    extreme_peak, extreme_peak_end, core_top, core_bottom = heights_at_material_ratios(
        deviation, [*EXTREME_PEAK_MATERIAL_RATIOS, PEAK_MATERIAL_RATIO, VALLEY_MATERIAL_RATIO]
    ).tolist()
    return {
        "Smr": float(np.mean(deviation > 0)), "Sdc": scale * (core_top - core_bottom),
        "Sxp": scale * (extreme_peak - extreme_peak_end),
        "Sk": scale * core.core_height, "Spk": scale * core.reduced_peak_height, "Svk": scale * core.reduced_pit_depth,
        "Smr1": core.upper_core_ratio, "Smr2": core.lower_core_ratio, "Vmp": scale * volumes.peak_material,
        "Vmc": scale * volumes.core_material, "Vvc": scale * volumes.core_void, "Vvv": scale * volumes.valley_void,
    }  # fmt: skip


def _compute_texture_parameters(surface: Surface, deviation: Floats) -> dict[str, float]:
    shortest_decay, longest_decay = _find_decay_lengths(deviation, surface.spacing)
    q, angle, density = surface_spectrum(surface).waves()
    is_resolved = q > 2.5 * 2 * math.pi / max(surface.extent)
    sector_index = np.rint(angle[is_resolved] * _NUM_ANGULAR_SECTORS / 180).astype(np.intp) % _NUM_ANGULAR_SECTORS
    strongest_sector = int(np.argmax(np.bincount(sector_index, density[is_resolved], minlength=_NUM_ANGULAR_SECTORS)))
    return {
        "Sal": shortest_decay, "Str": shortest_decay / longest_decay,
        "Std": float(strongest_sector * 180 / _NUM_ANGULAR_SECTORS),
        "Ssw": _find_dominant_wavelength(deviation, surface.spacing),
    }  # fmt: skip


def _find_dominant_wavelength(deviation: Floats, spacing: tuple[float, float]) -> float:
    """Return the wavelength (µm) of the largest Fourier coefficient of a height map."""
    from scipy.fft import fftfreq, rfft2, rfftfreq

    transform = rfft2(deviation)
    power = transform.real**2 + transform.imag**2
    power[0, 0] = 0.0
    peak_row, peak_column = np.unravel_index(int(np.argmax(power)), power.shape)
    rows, columns = deviation.shape
    peak_frequency = fftfreq(rows, spacing[0])[peak_row], rfftfreq(columns, spacing[1])[peak_column]
    return 1 / math.hypot(*map(float, peak_frequency))


def _compute_feature_parameters(deviation: Floats, scale: float, spacing: tuple[float, float]) -> dict[str, float]:
    features = feature_parameters(deviation, spacing)
    peak_height, pit_depth = scale * features.peak_height, scale * features.pit_depth
    return {
        "Spd": features.density,
        "Spc": scale * features.curvature,
        "S5p": peak_height,
        "S5v": pit_depth,
        "S10z": peak_height + pit_depth,
    }


def rms_gradient(surface: Surface, derivative: DerivativeFormula) -> float:
    """Compute the root-mean-square gradient Sdq of a height map."""
    z = surface.heights - surface.heights.mean()
    mean_squares = (
        float(np.mean(_compute_slopes_along_axis(z, axis, derivative) ** 2)) / surface.spacing[axis] ** 2
        for axis in (0, 1)
    )
    return math.sqrt(sum(mean_squares))


def _compute_slopes_along_axis(heights: Floats, axis: int, derivative: DerivativeFormula) -> Floats:
    """Compute the slopes of heights along an axis (height per grid point) with the formula `derivative`."""
    if derivative == "neighbours":
        return np.diff(heights, axis=axis)
    lines = heights if axis == 1 else heights.T
    points = lines.shape[1] - SEVEN_POINT_WEIGHTS.size + 1
    weighted_sum = np.zeros((lines.shape[0], points))
    for index, weight in enumerate(SEVEN_POINT_WEIGHTS):
        weighted_sum += weight / 60 * lines[:, index : index + points]
    return weighted_sum


def _compute_developed_area_ratio(heights: Floats, spacing: tuple[float, float]) -> float:
    """Return the developed area of a height map divided by its projected area, minus 1."""
    area_sum = 0.0
    corner_heights = heights[:-1, :-1], heights[:-1, 1:], heights[1:, :-1], heights[1:, 1:]
    # Any three of the four points of a grid cell form a right triangle. Its sides along x and y give its slope.
    for height_change_x in (corner_heights[1] - corner_heights[0], corner_heights[3] - corner_heights[2]):
        for height_change_y in (corner_heights[2] - corner_heights[0], corner_heights[3] - corner_heights[1]):
            squared_gradient = np.square(height_change_x / spacing[1]) + np.square(height_change_y / spacing[0])
            # sqrt(1 + s²) - 1 is computed as s² / (1 + sqrt(1 + s²)), which avoids cancellation.
            area_sum += float(np.mean(squared_gradient / (1 + np.sqrt(1 + squared_gradient)))) / 4
    return area_sum


def _find_decay_lengths(deviation: Floats, spacing: tuple[float, float]) -> tuple[float, float]:
    """Return the shortest and the longest distance, over all directions, at which the autocorrelation falls to 0.2.

    The shortest distance is NaN if the autocorrelation falls to 0.2 in no direction, and the longest is NaN unless it
    falls to 0.2 in all directions.
    """
    correlation = autocorrelation(deviation)
    max_shift = [points // 2 for points in deviation.shape]
    # The directions cover half a circle, because the autocorrelation is equal in opposite directions.
    angle = math.pi * np.arange(_NUM_DIRECTIONS) / _NUM_DIRECTIONS
    points_per_length = np.abs(np.stack([np.sin(angle) / spacing[0], np.cos(angle) / spacing[1]]))
    with np.errstate(divide="ignore"):
        max_distance = np.min(np.array(max_shift)[:, np.newaxis] / points_per_length, axis=0)
    step = min(spacing) / 2
    decay_distance = np.full(_NUM_DIRECTIONS, np.nan)
    previous_correlation = np.ones(_NUM_DIRECTIONS)
    for index in range(1, int(max_distance.max() / step) + 1):
        undecayed_indices = np.flatnonzero(np.isnan(decay_distance) & (index * step <= max_distance))
        if not undecayed_indices.size:
            break
        distance = index * step
        y = distance * np.sin(angle[undecayed_indices]) / spacing[0]
        x = distance * np.cos(angle[undecayed_indices]) / spacing[1]
        current_correlation = _interpolate_bilinear(correlation, y, x)
        has_decayed = current_correlation < DECAY_AUTOCORRELATION
        last_correlation = previous_correlation[undecayed_indices]
        decay_distance[undecayed_indices[has_decayed]] = (
            distance
            - step
            + step
            * (last_correlation[has_decayed] - DECAY_AUTOCORRELATION)
            / (last_correlation[has_decayed] - current_correlation[has_decayed])
        )
        previous_correlation[undecayed_indices] = current_correlation
    if np.isnan(decay_distance).all():
        return math.nan, math.nan
    return float(np.nanmin(decay_distance)), math.nan if np.isnan(decay_distance).any() else float(decay_distance.max())


def autocorrelation(deviation: Floats) -> Floats:
    """Compute the autocorrelation of heights for shifts by at most half the points along each axis.

    Element (j, l) belongs to a shift of j rows and l - columns//2 columns.
    """
    from scipy.fft import irfft2, next_fast_len, rfft2

    rows, columns = deviation.shape
    shape = next_fast_len(rows + rows // 2 + 1, real=True), next_fast_len(columns + columns // 2 + 1, real=True)
    transform = rfft2(deviation, shape)
    products = irfft2(transform.real**2 + transform.imag**2, shape)
    shift_x = np.arange(-(columns // 2), columns // 2 + 1)
    shift_y = np.arange(rows // 2 + 1)
    overlap_count = (rows - shift_y)[:, np.newaxis] * (columns - np.abs(shift_x))
    return np.asarray(products[shift_y[:, np.newaxis], shift_x] / overlap_count / np.mean(deviation**2))


def _interpolate_bilinear(correlation: Floats, y: Floats, x: Floats) -> Floats:
    x = x + correlation.shape[1] // 2
    row = np.minimum(y.astype(np.intp), correlation.shape[0] - 2)
    column = np.clip(x.astype(np.intp), 0, correlation.shape[1] - 2)
    y, x = y - row, x - column
    return np.asarray(
        (1 - y) * ((1 - x) * correlation[row, column] + x * correlation[row, column + 1])
        + y * ((1 - x) * correlation[row + 1, column] + x * correlation[row + 1, column + 1])
    )
