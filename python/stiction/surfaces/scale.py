"""Rms slope and curvature as functions of the shortest included wavelength, and reliable wavelengths of scans."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, check_bool, float_array, make_read_only, validate_number
from stiction._repr import TableReprMixin, TextReprMixin
from stiction._units import short_repr
from stiction.surfaces.filters import MIN_CUTOFF_POINTS, gaussian_transmission
from stiction.surfaces.harmonics import (
    MIN_HARMONIC_DISTANCE_IN_BINS,
    estimate_density_between_harmonics,
    find_texture_harmonics,
)
from stiction.surfaces.hurst import HurstEstimate
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectrum import HANN_VARIANCE_FACTOR, ROUND_OFF_FACTOR, power_spectrum, surface_spectrum
from stiction.surfaces.surface import BodyLike, Surface, as_body, reject_flat_body

# A tip follows a surface only if (rms curvature of the surface) · (tip radius) is below this number.
MAX_CURVATURE_TIMES_TIP_RADIUS = 0.1
_ROUGHNESS_BINS_PER_DECADE = 48
_NOISE_BINS_PER_OCTAVE = 8
_FIT_WINDOW_WIDTHS_IN_OCTAVES = (1.0, 2.0)
# Noise is found if a spectral exponent is this many standard deviations below the exponent of a surface with H = 0.
_MIN_EXPONENT_DIFFERENCE_IN_STANDARD_DEVIATIONS = 3.0
_MAX_HUMP_WAVELENGTH_POINTS = 24.0
_MIN_DENSITY_TO_NOISE_RATIO = 4.0
# The spectral density of a real surface never rises above this multiple of its minimum at longer wavelengths.
_MIN_DENSITY_RATIO_OF_RISE = 3.0
# Noise is negligible if it contributes at most this fraction of the mean square slope of a scan.
MAX_NEGLIGIBLE_NOISE_FRACTION = 0.1
# A Gaussian filter with a cutoff of this multiple of a wavelength transmits 8 % of the amplitude at the wavelength.
CUTOFF_TO_REMOVED_WAVELENGTH_RATIO = 1.9
_MIN_MEAN_SQUARE_SLOPE_FRACTION = 1e-4
_MIN_ALIASED_SURFACE_EXPONENT = 0.6
# In 1080 generated profiles of turned surfaces, this minimum exponent avoids 14 of 22 false detections of noise.
_MIN_TEXTURED_SURFACE_EXPONENT = 0.8
# Heights count as quantised if rounding explains at least this fraction of their mean square second difference.
_MIN_FRACTION_EXPLAINED_BY_ROUNDING = 0.3
# Maximum absolute exponent of a flat spectrum, and maximum rms deviation of its ln(density) from the mean.
_MAX_EXPONENT_OF_FLAT_SPECTRUM = 0.35
# Maximum exponent of a noise floor: above that of flat spectra, because the surface adds power at long wavelengths.
_MAX_EXPONENT_OF_NOISE_FLOOR = 0.7
_PURE_NOISE_WAVELENGTH_FRACTION = 0.7
INSTRUMENT_REASONS = ("noise floor", "quantisation")
_MAX_DENSITY_RATIO_OF_EQUAL_NOISE = 2.0
# Minimum ratio of a spectrum's density to the density of noise that it hides: below 1, because densities scatter.
_MIN_DENSITY_RATIO_THAT_HIDES_NOISE = 0.8
# With fewer independent lines than this, lines share their noise, and the spectrum across the lines would show it.
_MIN_INDEPENDENT_LINES = 8.0
_MIN_EXTRAPOLATED_WAVELENGTH_RATIO = 1e-6
_NUM_BISECTION_STEPS = 60

LimitOrigin = Literal["instrument", "unknown"]
LineAxis = Literal["", "x", "y"]

LineSpectrum = tuple[Floats, Floats, Floats, float]
"""Spectrum of lines: wave numbers (1/µm), densities, numbers of independent values, and point spacing (µm)."""


@dataclass(frozen=True, eq=False, repr=False)
class ScaleDependentRoughness(TextReprMixin):
    """Rms slope and rms curvature of a body as functions of the shortest included wavelength.

    Attributes
    ----------
    wavelength : (n,) ndarray of float, µm
        Descending, from the longest to the shortest wavelength of the grid.
    gradient : (n,) ndarray of float
        h'_rms of all wavelengths at or above each value: the gradient over all directions for a surface, the slope for
        a profile.
    curvature : (n,) ndarray of float, 1/µm
        h''_rms of the same wavelengths; for a surface, of the mean curvature, which is half of the Laplacian.
    dimensions : int
        1 for a profile, 2 for a surface.

    Examples
    --------
    >>> from stiction import scale_dependent_roughness, self_affine_surface
    >>> surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1)
    >>> scale_dependent_roughness(surface)
    ScaleDependentRoughness
      wavelength  58: 0.1414 to 6.4 µm
      gradient    58: 0.006932 to 0.0703
      curvature   58: 0.003403 to 0.5512 1/µm
      dimensions  2
    """

    wavelength: Floats = field(metadata={"unit": "µm"})
    gradient: Floats
    curvature: Floats = field(metadata={"unit": "1/µm"})
    dimensions: int

    def gradient_at(self, wavelength: ArrayLike) -> Floats:
        """Return, for each given wavelength (µm), the rms slope due to this and all longer wavelengths.

        The result is constant below the shortest wavelength of the body.
        """
        return _interpolate_log_log(self.wavelength, self.gradient, wavelength)

    def curvature_at(self, wavelength: ArrayLike) -> Floats:
        """Return, for each given wavelength (µm), the rms curvature (1/µm) due to this and all longer wavelengths."""
        return _interpolate_log_log(self.wavelength, self.curvature, wavelength)

    def fraction_below(self, wavelength: ArrayLike) -> Floats:
        """Return, for each given wavelength (µm), the fraction of the mean square slope due to shorter wavelengths."""
        return np.asarray(1 - np.square(self.gradient_at(wavelength) / self.gradient[-1]))

    def continued(self, wavelength: ArrayLike, estimate: HurstEstimate) -> Floats:
        r"""Return the rms slope due to each given wavelength (µm) and all longer ones, also beyond the fitted band.

        The power law of `estimate` adds the wavelengths that are too short for the scan.

        Notes
        -----
        Down to the shortest wavelength of the fitted band, the rms slope equals `gradient_at`. At shorter wavelengths,
        the power law gives

        .. math:: h'(λ)^2 = h'(λ_b)^2 + \frac{1}{nπ} \int_{2π/λ_b}^{2π/λ} q^{n+1} C(q)\,dq, \qquad C ∝ q^{-n-2H}

        with n = 1 for profiles and 2 for surfaces.
        """
        wavelengths = float_array("wavelength", wavelength)
        shortest_wavelength = estimate.shortest_wavelength
        measured_gradient = self.gradient_at(np.maximum(wavelengths, shortest_wavelength))
        extrapolated_wavelengths = np.minimum(wavelengths, shortest_wavelength)
        return np.asarray(
            np.sqrt(np.square(measured_gradient) + extrapolated_mean_square_slope(estimate, extrapolated_wavelengths))
        )

    def wavelength_of(self, gradient: float, estimate: HurstEstimate | None = None) -> float:
        """Find the wavelength (µm) at which the rms slope due to this and all longer wavelengths equals `gradient`.

        The power law of `estimate`, if given, extrapolates the spectrum.

        Returns the longest wavelength if this wavelength alone has the gradient. Returns NaN if the gradient is not
        reached; with a power law, the search extends to a millionth of the scan's shortest wavelength.
        """
        target_gradient = validate_number("gradient", gradient, above=0)
        shortest_wavelength = self.wavelength[-1] * (1.0 if estimate is None else _MIN_EXTRAPOLATED_WAVELENGTH_RATIO)
        log_shortest, log_longest = math.log(shortest_wavelength), math.log(self.wavelength[0])

        def gradient_at_log_wavelength(log_wavelength: float) -> float:
            wavelength = math.exp(log_wavelength)
            return float(self.gradient_at(wavelength) if estimate is None else self.continued(wavelength, estimate))

        if gradient_at_log_wavelength(log_shortest) < target_gradient:
            return math.nan
        for _ in range(_NUM_BISECTION_STEPS):
            log_middle = (log_shortest + log_longest) / 2
            log_shortest, log_longest = (
                (log_middle, log_longest)
                if gradient_at_log_wavelength(log_middle) >= target_gradient
                else (log_shortest, log_middle)
            )
        return math.exp((log_shortest + log_longest) / 2)


def fitted_and_limiting_power_laws(estimate: HurstEstimate) -> tuple[HurstEstimate, HurstEstimate, HurstEstimate]:
    """Return the fitted power law, and the power laws at both limits of the 95 % interval of the Hurst exponent.

    All three power laws agree at the centre of the band.
    """
    centre_wave_number = 2 * math.pi / math.sqrt(estimate.shortest_wavelength * estimate.longest_wavelength)
    law_of_smallest_exponent, law_of_largest_exponent = (
        replace(
            estimate,
            value=exponent,
            prefactor=estimate.prefactor * centre_wave_number ** (2 * (exponent - estimate.value)),
        )
        for exponent in (estimate.lower, estimate.upper)
    )
    return estimate, law_of_smallest_exponent, law_of_largest_exponent


def extrapolated_mean_square_slope(estimate: HurstEstimate, wavelength: Floats) -> Floats:
    """Return the mean square slope due to wavelengths from a given one (µm) to the shortest fitted wavelength.

    The power law of the band is extrapolated to these wavelengths.
    """
    exponent = 2 - 2 * estimate.value
    start, end = 2 * math.pi / estimate.shortest_wavelength, 2 * math.pi / np.asarray(wavelength)
    ratio = np.log(end / start)
    # The function `expm1` keeps the result accurate for exponents close to 0.
    integral = start**exponent * (np.expm1(exponent * ratio) / exponent if exponent != 0 else ratio)
    return np.asarray(estimate.prefactor / (estimate.dimensions * math.pi) * integral)


def scale_dependent_roughness(
    body: BodyLike, *, periodic: bool = False, spacing: Any = None, unit: str = "um"
) -> ScaleDependentRoughness:
    r"""Compute the rms slope and the rms curvature of a body as functions of the shortest included wavelength.

    Parameters
    ----------
    body : Profile, Surface or array_like
        Heights. The least-squares line or plane is subtracted unless the body is periodic.
    periodic : bool
        As for `power_spectrum`.
    spacing : float (µm) or str, or a pair (y, x) of either
        Distance between the points of an array, such as 0.5 or "39 nm"; required for arrays.
    unit : str
        Unit of the heights of an array.

    Returns
    -------
    roughness : ScaleDependentRoughness
        Rms slope h' and curvature h'' (1/µm) over the shortest included wavelength (µm).

    Raises
    ------
    ValueError
        If the body is flat, or an array has no spacing.

    See Also
    --------
    spectral_resolution : Contact area and friction from this roughness.

    Notes
    -----
    .. math:: h'(λ)^2 = \frac1{4π^2} \int_{q<2π/λ} q^2 C^{2D} d^2q, \qquad
              h''(λ)^2 = \frac1{16π^2} \int_{q<2π/λ} q^4 C^{2D} d^2q

    for surfaces; :math:`\frac1π \int q^2 C^{1D} dq` and :math:`\frac1π \int q^4 C^{1D} dq` for profiles. Sanner,
    Nöhring, Thimons, Jacobs & Pastewka, Applied Surface Science Advances 7 (2022) 100190, discuss the scale dependence
    of slopes.

    Examples
    --------
    >>> from stiction import scale_dependent_roughness, self_affine_surface
    >>> surface = self_affine_surface(1, hurst_exponent=0.8, rms=0.05, shape=(256, 256), spacing=0.04)
    >>> found = scale_dependent_roughness(surface, periodic=True)
    >>> float(found.fraction_below(0.16).round(2))
    0.26
    """
    check_bool("periodic", periodic)
    body = as_body("body", body, spacing=spacing, unit=unit)
    reject_flat_body(body)
    q, mean_squares = mean_square_height_spectrum(body, periodic=periodic)
    dimensions, curvature_factor = (1, 1.0) if isinstance(body, Profile) else (2, 0.25)
    index = np.floor(_ROUGHNESS_BINS_PER_DECADE * np.log10(q / q.min()) + 1e-9).astype(np.intp)
    wave_count = np.bincount(index)
    is_occupied = wave_count > 0
    max_wave_number = np.zeros(wave_count.size)
    np.maximum.at(max_wave_number, index, q)
    cumulative_sums = [np.bincount(index, q**power * mean_squares)[is_occupied].cumsum() for power in (2, 4)]
    return ScaleDependentRoughness(
        wavelength=make_read_only(2 * math.pi / max_wave_number[is_occupied]),
        gradient=make_read_only(np.sqrt(cumulative_sums[0])),
        curvature=make_read_only(np.sqrt(curvature_factor * cumulative_sums[1])), dimensions=dimensions,
    )  # fmt: skip


def mean_square_height_spectrum(body: Profile | Surface, *, periodic: bool = False) -> tuple[Floats, Floats]:
    """Compute how much each wave number (1/µm) contributes to the mean square height (µm²) of a body.

    Bodies that are not periodic are levelled first.
    """
    if isinstance(body, Profile):
        line_spectrum = power_spectrum(body if periodic else levelled(body, "line"), periodic=periodic)
        return line_spectrum.wave_number, line_spectrum.density * line_spectrum.count * (
            line_spectrum.resolution / math.pi
        )
    spectrum = surface_spectrum(body if periodic else levelled(body, "plane"), periodic=periodic)
    q = np.hypot(spectrum.wave_number_y[:, np.newaxis], spectrum.wave_number_x).ravel()
    wave_vector_area = float(spectrum.wave_number_y[1] - spectrum.wave_number_y[0]) * float(
        spectrum.wave_number_x[1] - spectrum.wave_number_x[0]
    )
    mean_squares = spectrum.density.ravel() * (wave_vector_area / (4 * math.pi**2))
    return q[q > 0], mean_squares[q > 0]


def _interpolate_log_log(wavelength: Floats, values: Floats, target_wavelengths: ArrayLike) -> Floats:
    """Interpolate a function of wavelength on logarithmic axes; return 0 above the longest tabulated wavelength."""
    wavelengths = float_array("wavelength", target_wavelengths)
    if not (wavelengths > 0).all():
        raise ValueError(f"wavelength must be above 0 µm, got {short_repr(target_wavelengths)}")
    with np.errstate(divide="ignore"):
        interpolated_values = np.exp(np.interp(-np.log(wavelengths), -np.log(wavelength), np.log(values)))
    return np.asarray(np.where(wavelengths > wavelength[0] * (1 + 1e-9), 0.0, interpolated_values))


@dataclass(frozen=True, repr=False)
class InstrumentLimit(TableReprMixin):
    """Shortest wavelength at which a scan is reliable, with the cause of this limit: pixels, noise or the tip.

    Attributes
    ----------
    wavelength : float, µm
        The largest of `pixels`, `noise` and `tip`. Shorter wavelengths are unreliable, at least along `axis`.
    reason : str
        Cause of the limit: "pixels" or "tip", or how the noise appears in the spectrum: "noise floor", "quantisation",
        "line", "roll-up" (a rise at the shortest wavelengths) or "hump".
    pixels : float, µm
        Twice the coarser spacing.
    noise : float, µm
        Wavelength below which the spectrum is not attributed to the surface; NaN if there is none. For a surface, the
        shorter of `noise_x` and `noise_y` if the noise is the same along both axes, otherwise the longer.
    tip : float, µm
        Wavelength below which the curvature exceeds what the tip resolves; NaN if there is no such wavelength or no tip
        radius.
    noise_x, noise_y : float, µm
        Values of `noise` for the lines of a surface along x and along y.
    slope_fraction : float
        Fraction of the mean square slope below `wavelength`; 0 if the reason is "pixels". For noise, the fraction that
        the noise contributes: slopes along each axis, at wavelengths below the limit of this axis.
    curvature_fraction : float
        Fraction of the mean square curvature below `wavelength`; 0 if the reason is "pixels".
    cut_off : float, µm
        Cutoff for `cut_off` that removes `slope_fraction` of the mean square slope; two points if the reason is
        "pixels". The filter also attenuates trusted wavelengths, so the cutoff is usually shorter than `wavelength`.
    origin : {"instrument", "unknown"}
        Origin of the wavelengths below `wavelength`: "unknown" for a line, a roll-up or a hump, and for a noise floor
        below the harmonics of a texture.
    period : float, µm
        Period of a texture with harmonics in the spectrum, along x or y for a surface; NaN if there is no texture.
    axis : {"", "x", "y"}
        Axis of a surface along which there is noise below `wavelength`; empty if there is noise along both axes.

    Examples
    --------
    >>> from stiction import instrument_limit, self_affine
    >>> smooth = self_affine(1, hurst_exponent=0.8, rms=0.1, points=4096, spacing=0.01, shortest_wavelength=0.5)
    >>> limit = instrument_limit(smooth)
    >>> limit.wavelength >= limit.pixels
    True
    """

    wavelength: float = field(metadata={"unit": "µm"})
    reason: str
    pixels: float = field(metadata={"unit": "µm"})
    noise: float = field(metadata={"unit": "µm"})
    tip: float = field(metadata={"unit": "µm"})
    noise_x: float = field(default=math.nan, metadata={"unit": "µm"})
    noise_y: float = field(default=math.nan, metadata={"unit": "µm"})
    slope_fraction: float = 0.0
    curvature_fraction: float = 0.0
    cut_off: float = field(default=math.nan, metadata={"unit": "µm"})
    origin: LimitOrigin = "instrument"
    period: float = field(default=math.nan, metadata={"unit": "µm"})
    axis: LineAxis = ""

    @property
    def matters(self) -> bool:
        """True if the unreliable wavelengths contribute more than a tenth of the scan's mean square slope."""
        return self.slope_fraction > MAX_NEGLIGIBLE_NOISE_FRACTION


def instrument_limit(
    body: Profile | Surface, *, tip_radius: float | None = None, periodic: bool = False, texture: bool = False
) -> InstrumentLimit:
    """Find the shortest wavelength at which a scan is reliable, given its pixels, its noise and its tip.

    Parameters
    ----------
    body : Profile or Surface
        Unfiltered scan.
    tip_radius : float, µm, optional
        Radius of the stylus or probe tip.
    periodic : bool
        As for `power_spectrum`.
    texture : bool
        True if lines and humps in the spectrum are known to belong to the surface, for example of a turned or milled
        part. A flat end of the spectrum is always attributed to the instrument.

    Returns
    -------
    limit : InstrumentLimit
        Wavelength (µm) with its reason, and the wavelengths at which pixels, noise and tip become the limit.

    Raises
    ------
    ValueError
        If the body is flat, or the tip radius is not above 0.

    See Also
    --------
    cut_off : Low-pass filter at that wavelength.
    compare_repeated_scans : Noise from two scans of the same area.
    tip_reconstructed : Correction for the shape of the tip.

    Notes
    -----
    The spectrum of a self-affine surface is proportional to q^-(1+2H), with an exponent from -1 to -3, and decreases
    faster where the surface is smooth. Other parts of a spectrum are noise, a spectral line, ringing, quantisation or
    the texture of a machined surface. These parts are detected where the exponent of a decreasing spectrum rises above
    -1 over one or two octaves, by three standard deviations, or where the spectrum rises to three times its minimum. A
    flat end is instrument noise. The limit is the wavelength at which the density is four times its minimum; h' of
    longer wavelengths then has an error below 5 %. Lines, humps and spectra that rise at their end are of unknown
    origin, except for these textures:

    - All harmonics, or the odd harmonics, of one period, such as feed marks. The spectrum is then assessed between the
      harmonics, or not at all if they are less than 10 bins apart. Noise between the harmonics counts only if it also
      flattens the spectrum with the harmonics, because cusps of unequal depth raise the density between them.
    - A hump at more than 24 points, if the spectrum decreases beyond it.
    - A hump in one line. Lines of a map along straight grooves are copies of each other and count as one: the number
      of independent lines is estimated from the spectrum across them.

    A spectral line common to two surfaces does not prove a texture, because one instrument may cause it in both scans.
    Noise with a decreasing spectrum, such as pink noise, cannot be distinguished from a surface in one scan; two scans
    of the same area reveal it (`compare_repeated_scans`). An optical resolution well above the pixel size is not
    detected: the spectrum then decreases faster, and H is above 1.

    A tip of radius R cannot follow curvatures above 1/R, so h''_rms(λ) must be below c/R (Jacobs, Junge & Pastewka,
    Surface Topography: Metrology and Properties 5 (2017) 013001; Sanner et al., Applied Surface Science Advances 7
    (2022) 100190). These authors use c of about 1/2. Here c is 0.1, at which a simulated tip reduces the spectrum by a
    tenth; at 1/2 it leaves a third of it.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, instrument_limit, self_affine
    >>> smooth = self_affine(1, hurst_exponent=0.8, rms=0.1, points=4096, spacing=0.01, shortest_wavelength=0.5)
    >>> noisy = Profile(smooth.heights + 1e-4 * np.random.default_rng(1).normal(size=4096), spacing=0.01)
    >>> instrument_limit(noisy).reason
    'noise floor'
    """
    radius = None if tip_radius is None else validate_number("tip_radius", tip_radius, unit="µm", above=0)
    check_bool("periodic", periodic)
    body = as_body("body", body)
    reject_flat_body(body)
    spacing = max(body.spacings)
    spectra = line_spectra(body, periodic)
    disturbances = [
        _find_noise_and_texture(*disturbance, periodic=periodic, textured=texture) for disturbance in spectra
    ]
    total_mean_square_slope = sum(float(np.square(q) @ density) * float(q[0]) / math.pi for q, density, *_ in spectra)
    # Along an axis without roughness, the spectrum contains only round-off, which is not reported as noise.
    noise_wavelengths = [
        disturbance.wavelength_limit
        if disturbance.mean_square_slope > _MIN_MEAN_SQUARE_SLOPE_FRACTION * total_mean_square_slope
        else math.nan
        for disturbance in disturbances
    ]
    noise_mean_square_slopes = [
        disturbance.mean_square_slope if limit > 0 else 0.0
        for disturbance, limit in zip(disturbances, noise_wavelengths, strict=True)
    ]
    period = next((disturbance.period for disturbance in disturbances if disturbance.period > 0), math.nan)
    noisier_axis, is_common, noise_wavelength, noise_mean_square_slope = (
        0,
        True,
        noise_wavelengths[0],
        noise_mean_square_slopes[0],
    )
    if len(spectra) == 2 and any(limit > 0 for limit in noise_wavelengths):
        is_common, hidden_mean_square_slope = _compare_noise_along_axes(spectra, noise_wavelengths)
        noisier_axis = int(np.nanargmax(noise_wavelengths if is_common else noise_mean_square_slopes))
        is_floor = [disturbance.noise_kind in INSTRUMENT_REASONS for disturbance in disturbances]
        noise_wavelength = float(np.nanmin(noise_wavelengths)) if is_common else noise_wavelengths[noisier_axis]
        noise_mean_square_slope = hidden_mean_square_slope + sum(
            noise_mean_square_slopes[axis] for axis in range(2) if is_common or is_floor[axis] == is_floor[noisier_axis]
        )
    noise_kind = disturbances[noisier_axis].noise_kind
    noise_slope_fraction = min(noise_mean_square_slope / total_mean_square_slope, 1.0)
    if not noise_slope_fraction > _MIN_MEAN_SQUARE_SLOPE_FRACTION:
        noise_wavelength = math.nan
    origin: LimitOrigin = (
        "unknown"
        if noise_kind not in INSTRUMENT_REASONS or (disturbances[noisier_axis].period > 0 and not texture)
        else "instrument"
    )
    if noise_kind == "noise floor" and noise_wavelength > 0 and _is_quantised(body):
        noise_kind = "quantisation"
    noise_wavelength = round_up_wavelength(noise_wavelength) if noise_wavelength > 0 else noise_wavelength
    limits_by_reason = {"pixels": 2 * spacing, noise_kind: noise_wavelength, "tip": math.nan}
    roughness = None
    if radius is not None or noise_wavelength > 0:
        roughness = scale_dependent_roughness(body, periodic=periodic)
        if radius is not None and (is_too_sharp := roughness.curvature > MAX_CURVATURE_TIMES_TIP_RADIUS / radius).any():
            limits_by_reason["tip"] = float(roughness.wavelength[int(np.argmax(is_too_sharp))])
    reason = max(
        (name for name in limits_by_reason if not math.isnan(limits_by_reason[name])),
        key=lambda name: limits_by_reason[name],
    )
    limit, fractions, cut_off_wavelength = limits_by_reason[reason], (0.0, 0.0), 2 * spacing
    if roughness is not None and reason != "pixels":
        curvature_fraction = float(roughness.curvature_at(limit) / roughness.curvature[-1])
        is_noise = reason == noise_kind
        fractions = (
            noise_slope_fraction if is_noise else float(roughness.fraction_below(limit)),
            1 - curvature_fraction**2,
        )
        shortest_wavelength = MIN_CUTOFF_POINTS * min(body.spacings)
        cut_off_wavelength = cutoff_for_slope_fraction(
            roughness, fractions[0], np.nanmax(noise_wavelengths) if is_noise else limit, shortest_wavelength
        )
    along_x, along_y = noise_wavelengths if len(noise_wavelengths) == 2 else (math.nan, math.nan)
    axis: LineAxis = "" if reason != noise_kind or is_common else "x" if noisier_axis == 0 else "y"
    return InstrumentLimit(
        limit, reason, limits_by_reason["pixels"], noise_wavelength, limits_by_reason["tip"], along_x, along_y,
        *fractions, cut_off_wavelength, origin if reason == noise_kind else "instrument", period, axis,
    )  # fmt: skip


def round_up_wavelength(wavelength: float) -> float:
    """Round a wavelength upwards to three significant digits."""
    digit = 10.0 ** (math.floor(math.log10(wavelength)) - 2)
    return round(math.ceil(wavelength / digit - 1e-9) * digit, 12)


def cutoff_for_slope_fraction(roughness: ScaleDependentRoughness, fraction: float, upper: float, lower: float) -> float:
    """Find the low-pass cutoff (µm) at which a filter removes a given fraction of the mean square slope.

    `upper` and `lower` are the limits of the cutoff.
    """
    q, slope_contributions = 2 * math.pi / roughness.wavelength, np.diff(np.square(roughness.gradient), prepend=0.0)
    log_lower, log_upper = math.log(lower), math.log(max(upper, lower))
    for _ in range(_NUM_BISECTION_STEPS):
        log_middle = (log_lower + log_upper) / 2
        transmitted_fraction = float(
            slope_contributions @ np.square(gaussian_transmission(q, math.exp(log_middle)))
        ) / float(slope_contributions.sum())
        log_lower, log_upper = (
            (log_middle, log_upper) if transmitted_fraction > 1 - fraction else (log_lower, log_middle)
        )
    # The cutoff is rounded to two digits, so that repeated scans of a surface usually get the same cutoff.
    return max(lower, float(f"{math.exp(log_upper):.1e}"))


def line_spectra(body: Profile | Surface, periodic: bool) -> list[LineSpectrum]:
    """Compute the spectrum of a profile, or the mean spectra of a map's lines along x and along y.

    Raises a `ValueError` if the surface is flat (after levelling, unless it is periodic).
    """
    if isinstance(body, Profile):
        line_spectrum = power_spectrum(body if periodic else levelled(body, "line"), periodic=periodic)
        return [(line_spectrum.wave_number, line_spectrum.density, line_spectrum.count, body.spacing)]
    surface = body if periodic else levelled(body, "plane")
    reject_flat_body(surface)
    heights, spectra = surface.heights, []
    for axis in (1, 0):
        lines = heights if axis else heights.T
        points, spacing = lines.shape[1], body.spacing[axis]
        window = 1.0 if periodic else (1 - np.cos(2 * math.pi * np.arange(points) / points)) / math.sqrt(1.5)
        transform = np.fft.rfft((lines - lines.mean(axis=1, keepdims=True)) * window)[:, 1:]
        power = np.square(np.abs(transform)).mean(axis=0)
        q = 2 * math.pi * np.arange(1, power.size + 1) / (points * spacing)
        spectra.append((q, power * (spacing / points), _count_independent_lines(transform, periodic=periodic), spacing))
    return spectra


def _count_independent_lines(transform: NDArray[np.complex128], *, periodic: bool) -> Floats:
    """Estimate, for each wave number along the lines, how many lines of a map are statistically independent.

    The mean spectrum over the lines has the relative variance sum(P²)/sum(P)², where P are the powers of the wave
    vectors across the lines. Lines along straight grooves are copies of each other and count as one line. The factor 2
    arises because P is exponentially distributed. A Hann window keeps the ends of lines along oblique grooves from
    leaking to other wave vectors; the window itself spreads a single wave vector so that sum(P)²/sum(P²) is 2.
    """
    lines = transform.shape[0]
    window = np.ones(lines) if periodic else 1 - np.cos(2 * math.pi * np.arange(lines) / lines)
    power = np.square(np.abs(np.fft.fft(transform * window[:, np.newaxis], axis=0)))
    squared_powers = np.square(power).sum(axis=0)
    squared_sum = np.square(power.sum(axis=0))
    ratio = squared_sum / np.where(squared_powers > 0, squared_powers, 1.0)
    return np.asarray(np.maximum(2 * ratio - (1 if periodic else 3), 1.0))


def _compare_noise_along_axes(spectra: list[LineSpectrum], noise_wavelengths: list[float]) -> tuple[bool, float]:
    """Compare the noise along x with the noise along y in a map that has noise along at least one of these axes.

    White noise has the same variance along both axes, so its densities are proportional to the spacings.

    Returns
    -------
    is_common : bool
        True if noise is found along both axes with about the same density.
    hidden : float
        For noise that is found along one axis only: its mean square slope along the other axis, where rougher lines
        hide it. 0 if the spectrum along the other axis is too low to contain this noise, or if neighbouring lines share
        their noise, like rows with offsets.
    """
    axis = int(np.nanargmax(noise_wavelengths))
    (q, density, count, spacing), (other_q, other_density, _, other_spacing) = spectra[axis], spectra[1 - axis]
    expected_noise = np.interp(other_q, q, density * (other_spacing / spacing))
    end = min(float(q[-1]), float(other_q[-1]))
    start = min(2 * math.pi / float(np.nanmin(noise_wavelengths)), end / 2)
    octaves = [(end / 2 ** (n + 1), end / 2**n) for n in range(int(math.log2(end / start) + 1e-9))]
    densities = np.array([
        (other_density[is_in_octave].mean(), expected_noise[is_in_octave].mean())
        for lower_limit, upper_limit in octaves
        if (is_in_octave := (other_q > lower_limit) & (other_q <= upper_limit * ROUND_OFF_FACTOR)).any()
    ]).reshape(-1, 2)  # fmt: skip
    other_mean_density, expected_mean_density = densities.T
    if noise_wavelengths[1 - axis] > 0:
        return bool(
            (
                (other_mean_density < _MAX_DENSITY_RATIO_OF_EQUAL_NOISE * expected_mean_density)
                & (expected_mean_density < _MAX_DENSITY_RATIO_OF_EQUAL_NOISE * other_mean_density)
            ).all()
        ), 0.0
    independent_lines = count[q * noise_wavelengths[axis] > 2 * math.pi].mean()
    if (
        not expected_mean_density.size
        or (other_mean_density < _MIN_DENSITY_RATIO_THAT_HIDES_NOISE * expected_mean_density).any()
        or independent_lines < _MIN_INDEPENDENT_LINES
    ):
        return False, 0.0
    is_noisy = other_q * noise_wavelengths[axis] > 2 * math.pi
    return False, float(np.square(other_q[is_noisy]) @ expected_noise[is_noisy]) * float(other_q[0]) / math.pi


class _NoiseAndTexture(NamedTuple):
    """Longest wavelength dominated by noise, and period of the texture, both found in a spectrum along lines."""

    wavelength_limit: float  # µm, NaN without noise
    noise_kind: str
    mean_square_slope: float
    period: float  # µm, NaN without texture


def _find_noise_and_texture(
    q: Floats, density: Floats, count: Floats, spacing: float, *, periodic: bool, textured: bool
) -> _NoiseAndTexture:
    """Find the period of a texture in a spectrum along lines, and the wavelength below which noise dominates."""
    first_harmonic, harmonic_distance = find_texture_harmonics(density)
    period = 2 * math.pi / (float(q[0]) * first_harmonic)
    if first_harmonic > 0:
        if harmonic_distance < MIN_HARMONIC_DISTANCE_IN_BINS:
            return _NoiseAndTexture(math.nan, "noise floor", 0.0, period)
        # Near the first harmonic, cusps of unequal depth cause a hump, so noise is searched for above this harmonic.
        above_first_harmonic = slice(int(first_harmonic), None)
        density_with_harmonics = density[above_first_harmonic]
        density, q, count = (
            estimate_density_between_harmonics(density, count, harmonic_distance)[above_first_harmonic],
            q[above_first_harmonic],
            count[above_first_harmonic],
        )
    wavelength_limit, kind = _find_noise_wavelength(q, density, count, spacing, periodic=periodic)
    if not wavelength_limit > 0 or (textured and kind not in INSTRUMENT_REASONS):
        return _NoiseAndTexture(math.nan, kind, 0.0, period)
    if first_harmonic > 0 and _falls_as_steeply_as_surface_spectra(q, density_with_harmonics, wavelength_limit):
        return _NoiseAndTexture(math.nan, kind, 0.0, period)
    is_unattributed = q * wavelength_limit > 2 * math.pi
    mean_square_slope = float((np.square(q) * density)[is_unattributed].sum() * (q[1] - q[0]) / math.pi)
    # The noise is assumed to be white: its density at all wave numbers is the mean density at the largest ones.
    if kind in INSTRUMENT_REASONS:
        floor_density = float(density[q * math.sqrt(2) > q[-1]].mean())
        mean_square_slope = min(mean_square_slope, floor_density * float(np.square(q).sum() * (q[1] - q[0])) / math.pi)
    return _NoiseAndTexture(wavelength_limit, kind, mean_square_slope, period)


def _falls_as_steeply_as_surface_spectra(q: Floats, density: Floats, wavelength_limit: float) -> bool:
    """Return whether a textured surface's spectrum falls at short wavelengths as steeply as spectra without noise do.

    Noise that matters exceeds the harmonics at short wavelengths, and flattens their spectrum too. Cusps of unequal
    depth raise only the density between the harmonics.
    """
    end, start = float(q[-1]) * ROUND_OFF_FACTOR, 2 * math.pi / wavelength_limit
    half_octave = math.sqrt(2)
    band_pairs = [((end / 2, end / half_octave), (end / half_octave, end))]
    for step in range(max(math.ceil(2 * math.log2(end / start)), 1)):
        max_wave_number = end / half_octave**step
        band_pairs.append(((max_wave_number / 4, max_wave_number / 2), (max_wave_number / 2, max_wave_number)))
    for longer_band, shorter_band in band_pairs:
        is_in_longer, is_in_shorter = (
            (q > lower_limit) & (q <= upper_limit) for lower_limit, upper_limit in (longer_band, shorter_band)
        )
        if not is_in_longer.any() or not is_in_shorter.any():
            continue
        octaves = math.log2(shorter_band[1] / longer_band[1])
        density_ratio = float(density[is_in_shorter].mean()) / float(density[is_in_longer].mean())
        if density_ratio > 2 ** (-_MIN_TEXTURED_SURFACE_EXPONENT * octaves):
            return False
    return True


def _find_noise_wavelength(
    q: Floats, density: Floats, count: Floats, spacing: float, *, periodic: bool
) -> tuple[float, str]:
    """Return the wavelength (µm) below which noise dominates a spectrum without texture, and the type of this noise.

    The limit is NaN if there is no noise.
    """
    no_noise = math.nan, "noise floor"
    # The Hann window adds power from longer wavelengths to the first two harmonics, so they are excluded.
    if not periodic:
        q, density, count = q[2:], density[2:], count[2:]
    if q.size < _NOISE_BINS_PER_OCTAVE:
        return no_noise
    _, bin_index = np.unique(np.floor(_NOISE_BINS_PER_OCTAVE * np.log2(q / q[0]) + 1e-9), return_inverse=True)
    counts_in_bins = np.bincount(bin_index, count)
    density = np.bincount(bin_index, count * density) / counts_in_bins
    wavelengths = 2 * math.pi * np.exp(-np.bincount(bin_index, count * np.log(q)) / counts_in_bins)
    density = np.maximum(density, 1e-12 * density.max())
    chance_variance = (1.0 if periodic else HANN_VARIANCE_FACTOR) / counts_in_bins
    window_fits = [
        list(_fit_window_exponents(-np.log(wavelengths), np.log(density), chance_variance, width))
        for width in _FIT_WINDOW_WIDTHS_IN_OCTAVES
    ]
    if _fit_line_slope(-np.log(wavelengths), np.log(density), chance_variance)[0] > -_MAX_EXPONENT_OF_FLAT_SPECTRUM:
        return float(wavelengths[0]), "noise floor"
    is_last_octave = wavelengths <= 2.01 * wavelengths[-1]
    last_exponent, exponent_deviation = _fit_line_slope(
        -np.log(wavelengths[is_last_octave]), np.log(density[is_last_octave]), chance_variance[is_last_octave]
    )
    candidate_bins = [
        _find_flattening_bin(window_fit, wavelengths / spacing, density, chance_variance) for window_fit in window_fits
    ]
    candidate_bins.append(_find_bin_before_rise(wavelengths / spacing, density, chance_variance))
    if last_exponent - 2 * exponent_deviation > -_MIN_ALIASED_SURFACE_EXPONENT:
        candidate_bins.append(int(np.argmin(np.where(is_last_octave, density, math.inf))))
    if not any(candidate_bin is not None for candidate_bin in candidate_bins):
        return no_noise
    noisy_bin = min(noisy_bin for noisy_bin in candidate_bins if noisy_bin is not None)
    trusted_bins = np.flatnonzero(density[: noisy_bin + 1] >= _MIN_DENSITY_TO_NOISE_RATIO * density[noisy_bin])
    last_trusted_bin = int(trusted_bins[-1]) if trusted_bins.size else 0
    limit = math.sqrt(wavelengths[last_trusted_bin] * wavelengths[min(last_trusted_bin + 1, noisy_bin)])
    rising_bins = noisy_bin + np.flatnonzero(density[noisy_bin:] > 2 * density[noisy_bin])
    if rising_bins.size:
        limit = max(limit, CUTOFF_TO_REMOVED_WAVELENGTH_RATIO * float(wavelengths[rising_bins[0]]))
    if rising_bins.size and np.sum(density[noisy_bin:] > density[noisy_bin:].max() / 4) <= 2:
        return limit, "line"
    if _is_noise_floor(wavelengths, density, chance_variance, limit):
        return limit, "noise floor"
    if rising_bins.size and wavelengths[rising_bins[0]] < 1.4 * wavelengths[-1]:
        return limit, "roll-up"
    return limit, "hump"


def _fit_line_slope(x: Floats, y: Floats, variance: Floats) -> tuple[float, float]:
    """Fit a straight line to y(x), given the variance of each y; return the slope and its standard deviation."""
    weight = 1 / (variance + 0.01)
    x_deviations = x - np.average(x, weights=weight)
    weighted_square_sum = float(weight @ x_deviations**2)
    return float(weight @ (x_deviations * y)) / weighted_square_sum, 1 / math.sqrt(weighted_square_sum)


def _is_noise_floor(wavelengths: Floats, density: Floats, chance_variance: Floats, limit: float) -> bool:
    """Return whether a spectrum has a nearly flat noise floor at wavelengths below `limit` (µm).

    In the shortest octave, the floor must be flat.
    """
    for max_wavelength, max_exponent in (
        (_PURE_NOISE_WAVELENGTH_FRACTION * limit, _MAX_EXPONENT_OF_NOISE_FLOOR),
        (2.01 * float(wavelengths[-1]), _MAX_EXPONENT_OF_FLAT_SPECTRUM),
    ):
        is_short = wavelengths < max_wavelength
        if is_short.sum() < _NOISE_BINS_PER_OCTAVE // 2:
            return False
        x, y, variance = -np.log(wavelengths[is_short]), np.log(density[is_short]), chance_variance[is_short]
        slope, deviation = _fit_line_slope(x, y, variance)
        weight = 1 / (variance + 0.01)
        scatter = np.square(y - np.average(y, weights=weight)) - variance
        if (
            not abs(slope) < max(max_exponent, 2 * deviation)
            or np.average(scatter, weights=weight) > _MAX_EXPONENT_OF_FLAT_SPECTRUM**2
        ):
            return False
    return True


def _fit_window_exponents(
    x: Floats, y: Floats, chance_variance: Floats, octaves: float
) -> Iterator[tuple[int, int, float, float]]:
    """Fit a power law to each of several overlapping windows of a spectrum; a window is `octaves` octaves wide.

    Yields first bin, exclusive end, exponent and its standard deviation.
    """
    width = octaves * math.log(2)
    for first in range(x.size):
        end = int(np.searchsorted(x, x[first] + width + 1e-6))
        if end - first >= _NOISE_BINS_PER_OCTAVE // 2 and x[end - 1] - x[first] > 0.85 * width:
            yield first, end, *_fit_line_slope(x[first:end], y[first:end], chance_variance[first:end])


def _find_flattening_bin(
    window_fits: list[tuple[int, int, float, float]], points: Floats, density: Floats, chance_variance: Floats
) -> int | None:
    """Return the bin at which an initially falling spectrum becomes flatter than any spectrum of roughness.

    This is the bin of lowest density in the first window that is too flat. Returns None if there is no such window.
    """
    has_fallen = False
    for first_bin, end_bin, exponent, deviation in window_fits:
        if exponent + _MIN_EXPONENT_DIFFERENCE_IN_STANDARD_DEVIATIONS * deviation < -1:
            has_fallen = True
        elif has_fallen and exponent - _MIN_EXPONENT_DIFFERENCE_IN_STANDARD_DEVIATIONS * deviation > -1:
            slope = _fit_line_slope(
                -np.log(points[first_bin:]), np.log(density[first_bin:]), chance_variance[first_bin:]
            )[0]
            if points[first_bin] <= _MAX_HUMP_WAVELENGTH_POINTS or slope > -1:
                return first_bin + int(np.argmin(density[first_bin:end_bin]))
    return None


def _find_bin_before_rise(points: Floats, density: Floats, chance_variance: Floats) -> int | None:
    """Return the bin with the lowest spectral density if the density rises strongly towards shorter wavelengths.

    Returns None without a rise.
    """
    lowest_density, lowest_bin = math.inf, 0
    for bin_index in np.flatnonzero(chance_variance < 1 / 4):
        if (
            points[bin_index] <= _MAX_HUMP_WAVELENGTH_POINTS
            and lowest_bin
            and density[bin_index]
            > max(_MIN_DENSITY_RATIO_OF_RISE, 1 + 5 * math.sqrt(chance_variance[bin_index])) * lowest_density
        ):
            return lowest_bin
        upper_density = float(density[bin_index]) * (1 + 3 * math.sqrt(chance_variance[bin_index]))
        if upper_density < lowest_density:
            lowest_density, lowest_bin = upper_density, int(bin_index)
    return None


def _is_quantised(body: Profile | Surface) -> bool:
    """Return whether the rounding of heights to a step is the cause of a large fraction of a body's noise."""
    mean_square_second_difference = float(np.square(np.diff(body.heights, 2)).mean())
    # Rounding to steps s adds white noise of variance s²/12, whose mean square second difference is s²/2.
    return body.height_step**2 / 2 > _MIN_FRACTION_EXPLAINED_BY_ROUNDING * mean_square_second_difference
