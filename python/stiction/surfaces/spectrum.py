"""Power spectra and spectral moments of profiles and height maps.

The spectrum of a `periodic` body is computed without a window. Any other body has a jump between its ends, which would
add a spectrum proportional to 1/q². A Hann window, applied along both axes of a surface, suppresses this spectrum.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats, check_bool, make_read_only, validate_number, validate_whole_number
from stiction._drawing import draw_spectrum
from stiction._repr import PlotReprMixin, TableReprMixin, TextReprMixin, axes_or_new_axes
from stiction._units import short_repr
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import BodyLike, Surface, as_body, reject_flat_body

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROUND_OFF_FACTOR = 1 + 1e-9
_PEAK_BINS_PER_DECADE = 24
_PEAK_WINDOW_HALF_WIDTH_IN_BINS = 6

HANN_VARIANCE_FACTOR = 35 / 18
"""Factor by which a Hann window w increases the variance of a sum over harmonics: mean(w⁴) / mean(w²)²."""


@dataclass(frozen=True, eq=False, repr=False)
class PowerSpectrum(PlotReprMixin):
    """Power spectral density C1D of a profile, in the convention of Jacobs, Junge & Pastewka (2017).

    Attributes
    ----------
    wave_number : (n,) ndarray of float, 1/µm
        q = 2π / wavelength in ascending order; for bins, the geometric mean.
    density : (n,) ndarray of float, µm³
        C1D(q), whose integral over q from 0, times 1/π, is the mean square height; for bins, the mean.
    count : (n,) ndarray of float
        Number of harmonics per value: 1, or the number in the bin. The harmonic at the Nyquist wave number counts half,
        because it has no counterpart at the negative wave number.
    resolution : float, 1/µm
        Spacing of the harmonics, 2π / extent.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, power_spectrum
    >>> wave = Profile(0.1 * np.cos(2 * np.pi * 3 * np.arange(64) / 64), spacing=0.5)
    >>> round(power_spectrum(wave, periodic=True).moment(0), 12)  # the mean square height
    0.005
    """

    wave_number: Floats = field(metadata={"unit": "1/µm"})
    density: Floats = field(metadata={"unit": "µm³"})
    count: Floats
    resolution: float = field(metadata={"unit": "1/µm"})

    def moment(self, order: int) -> float:
        """Compute the spectral moment of a given order, ∫ q^order C1D dq / π, in µm^(2 - order).

        For a binned spectrum the result is exact only for order 0.
        """
        order = validate_whole_number("order", order, minimum=0)
        return float((self.wave_number**order * self.density * self.count).sum() * self.resolution / math.pi)

    def in_bins(self, per_decade: int = 10) -> PowerSpectrum:
        """Average the spectrum over bins of equal width in the logarithm of the wave number.

        Empty bins are omitted.

        Examples
        --------
        >>> from stiction import power_spectrum, random_phases, weierstrass_mandelbrot
        >>> spectrum = power_spectrum(weierstrass_mandelbrot(random_phases(1), 1.3, points=2001))
        >>> spectrum.in_bins(2).count
        array([  3.,   6.,  22.,  68., 217., 683.,   1.])
        """
        per_decade = validate_whole_number("per_decade", per_decade, minimum=1)
        return PowerSpectrum(*_average_in_bins(per_decade, self.wave_number, self.density, self.count), self.resolution)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the spectrum on logarithmic axes, with the mean density in each tenth of a decade.

        Draws into the given axes, or into new ones, and returns them.
        """
        bins = self.in_bins()
        return draw_spectrum(axes_or_new_axes(ax), (self.wave_number, self.density), (bins.wave_number, bins.density))


def _average_in_bins(per_decade: int, q: Floats, density: Floats, count: Floats) -> tuple[Floats, Floats, Floats]:
    """Return, for each bin of a spectrum, the mean wave number, the mean density and the number of harmonics."""
    # The margin 1e-9 prevents round-off from moving a harmonic at the lower limit of a bin into the bin below.
    _, index = np.unique(np.floor(per_decade * np.log10(q / q[0]) + 1e-9), return_inverse=True)
    total_count = np.bincount(index, count).astype(np.float64)
    mean_wave_number = np.exp(np.bincount(index, count * np.log(q)) / total_count)
    return (
        make_read_only(mean_wave_number),
        make_read_only(np.bincount(index, count * density) / total_count),
        make_read_only(total_count),
    )


def power_spectrum(
    profile: BodyLike, *, periodic: bool = False, spacing: Any = None, unit: str = "um"
) -> PowerSpectrum:
    r"""Compute the power spectral density C1D of a profile about the mean height.

    Parameters
    ----------
    profile : Profile or array_like
        Heights.
    periodic : bool
        True: no window. The sum of the spectrum equals the mean square height except for round-off. False: a Hann
        window, normalised to a mean square of 1. The mean square of a levelled profile is then preserved on average,
        but the first two harmonics are unreliable.
    spacing : float (µm) or str
        Distance between the points of an array, such as 0.5 or "39 nm"; required for arrays.
    unit : str
        Unit of the heights of an array.

    Returns
    -------
    spectrum : PowerSpectrum
        Density C1D (µm³) of all harmonics from 2π/extent to the Nyquist wave number π/spacing.

    Raises
    ------
    ValueError
        If the argument is not a profile, or an array has no spacing.

    See Also
    --------
    surface_spectrum : Spectrum of a map.
    spectral_moments : Variances of height, slope and curvature from the spectrum.

    Notes
    -----
    .. math:: C(q) = \frac{Δx}{N} \left|\sum_j w_j (z_j - \bar z) e^{-iqx_j}\right|^2, \qquad
              h_{rms}^2 = \frac1π \int_0^\infty C(q)\,dq

    A self-affine profile has C ∝ q^(-1-2H). Jacobs, Junge & Pastewka, Surface Topography: Metrology and Properties 5
    (2017) 013001.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, power_spectrum
    >>> wave = Profile(0.1 * np.cos(2 * np.pi * 3 * np.arange(64) / 64), spacing=0.5)  # a² extent / 4 at one q
    >>> spectrum = power_spectrum(wave, periodic=True)
    >>> round(float(spectrum.density[2]), 12), round(spectrum.moment(0), 12)
    (0.08, 0.005)
    """
    profile = as_body("profile", profile, Profile, spacing=spacing, unit=unit)
    check_bool("periodic", periodic)
    return profile_spectrum(profile.heights - profile.heights.mean(), profile.spacing, windowed=not periodic)


def profile_spectrum(heights: Floats, spacing: float, *, windowed: bool) -> PowerSpectrum:
    """Compute the power spectral density of a profile from heights (µm), with or without a Hann window."""
    points = heights.size
    if windowed:
        heights = heights * (1 - np.cos(2 * math.pi * np.arange(points) / points)) / math.sqrt(1.5)
    transform = np.fft.rfft(heights)[1:]
    density = spacing / points * (transform.real**2 + transform.imag**2)
    resolution = 2 * math.pi / (points * spacing)
    wave_number = resolution * np.arange(1, transform.size + 1, dtype=np.float64)
    count = np.ones(transform.size)
    if points % 2 == 0:
        count[-1] = 0.5
    return PowerSpectrum(
        wave_number=make_read_only(wave_number),
        density=make_read_only(density),
        count=make_read_only(count),
        resolution=resolution,
    )


@dataclass(frozen=True, repr=False)
class ProfileMoments(TableReprMixin):
    """Variances of the height, the slope and the curvature of a profile: the spectral moments m0, m2 and m4.

    Attributes
    ----------
    height : float, µm²
        m0, variance of the heights about their mean.
    slope : float
        m2, mean square slope.
    curvature : float, 1/µm²
        m4, mean square curvature.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, spectral_moments
    >>> moments = spectral_moments(Profile(np.cos(np.arange(64) * np.pi / 8), spacing=np.pi / 8), periodic=True)
    >>> round(moments.height, 12), round(moments.slope, 12), round(moments.curvature, 12)
    (0.5, 0.5, 0.5)
    """

    height: float = field(metadata={"unit": "µm²"})
    slope: float
    curvature: float = field(metadata={"unit": "1/µm²"})

    @property
    def nayak_parameter(self) -> float:
        """Nayak's parameter α = m0 m4 / m2², which is 1 for a sinusoid, and larger for a wider spectrum."""
        return self.height * self.curvature / self.slope**2


def spectral_moments(
    profile: Profile, *, periodic: bool = False, shortest_wavelength: float = 0.0, longest_wavelength: float = math.inf
) -> ProfileMoments:
    r"""Compute the spectral moments m0, m2 and m4 of a profile.

    Parameters
    ----------
    profile : Profile
        Heights, not flat.
    periodic : bool
        As for `power_spectrum`.
    shortest_wavelength, longest_wavelength : float, µm
        Band of wavelengths to include; by default all. The shortest wavelengths dominate m2 and m4 of a rough profile,
        so m2 and m4 are meaningless without a shortest wavelength.

    Returns
    -------
    moments : ProfileMoments
        Variances of height (µm²), slope and curvature (1/µm²).

    Raises
    ------
    ValueError
        If no wavelength remains, or the profile is flat.

    Notes
    -----
    .. math:: m_j = \frac1π \int_0^\infty q^j C(q)\,dq

    m0, m2 and m4 are the variances of height, slope and curvature along the profile. On an isotropic surface they are
    equal along all lines. `ProfileMoments.nayak_parameter` is m0 m4 / m2². Nayak, Journal of Lubrication Technology 93
    (1971) 398.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, spectral_moments
    >>> wave = Profile(np.cos(np.arange(64) * np.pi / 8), spacing=np.pi / 8)
    >>> round(spectral_moments(wave, periodic=True).slope, 12)
    0.5
    """
    profile = as_body("profile", profile, Profile)
    reject_flat_body(profile)
    shortest = validate_number("shortest_wavelength", shortest_wavelength, unit="µm")
    if not longest_wavelength > shortest:
        raise ValueError(
            f"longest_wavelength must be above shortest_wavelength, {shortest:g} µm, "
            f"got {short_repr(longest_wavelength)}"
        )
    spectrum = power_spectrum(profile, periodic=periodic)
    is_in_band = is_within_wavelength_band(spectrum.wave_number, shortest, longest_wavelength)
    if not is_in_band.any():
        raise ValueError(
            "the band from shortest_wavelength to longest_wavelength must contain a wavelength of the profile "
            f"({2 * profile.spacing:g} to {profile.extent:g} µm), got {shortest:g} to {longest_wavelength:g} µm"
        )
    band_spectrum = PowerSpectrum(
        spectrum.wave_number[is_in_band], spectrum.density[is_in_band], spectrum.count[is_in_band], spectrum.resolution
    )
    return ProfileMoments(
        height=band_spectrum.moment(0), slope=band_spectrum.moment(2), curvature=band_spectrum.moment(4)
    )


def is_within_wavelength_band(wave_number: Floats, shortest: float, longest: float) -> NDArray[np.bool_]:
    """Return a mask of the wave numbers whose wavelengths lie in the band from `shortest` to `longest`.

    Wavelengths at the ends of the band are included in spite of round-off.
    """
    return (wave_number * shortest <= 2 * math.pi * ROUND_OFF_FACTOR) & (
        wave_number * longest * ROUND_OFF_FACTOR >= 2 * math.pi
    )


@dataclass(frozen=True, eq=False, repr=False)
class RadialSpectrum(TextReprMixin):
    """Spectrum of a height map as a function of wave number, averaged over all directions.

    Attributes
    ----------
    wave_number : (n,) ndarray of float, 1/µm
        Magnitudes of the wave vectors, 2π / wavelength, in ascending order: the geometric mean of each bin.
    density : (n,) ndarray of float, µm⁴
        C2D: the mean over each bin.
    count : (n,) ndarray of float
        Number of waves in each bin; a wave vector and the opposite wave vector are one wave.

    Examples
    --------
    >>> from stiction import self_affine_surface, surface_spectrum
    >>> surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1)
    >>> surface_spectrum(surface).radial()
    RadialSpectrum
      wave_number  15: 0.9817 to 31.21 1/µm
      density      15: 1.562e-08 to 0.001211 µm⁴
      count        15: 2 to 570
    """

    wave_number: Floats = field(metadata={"unit": "1/µm"})
    density: Floats = field(metadata={"unit": "µm⁴"})
    count: Floats


@dataclass(frozen=True, eq=False, repr=False)
class SurfaceSpectrum(TextReprMixin):
    """Power spectral density C2D of a height map, in the convention of Jacobs, Junge & Pastewka (2017).

    Attributes
    ----------
    wave_number_y : (rows,) ndarray of float, 1/µm
        Wave numbers along y, ascending, with zero in the middle; for an even number of points the first is the Nyquist
        wave number.
    wave_number_x : (columns,) ndarray of float, 1/µm
        Wave numbers along x, in the same order.
    density : (rows, columns) ndarray of float, µm⁴
        C2D(q), whose integral over both wave numbers, times 1/4π², is the mean square height; zero at q = 0.

    Examples
    --------
    >>> from stiction import self_affine_surface, surface_spectrum
    >>> surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1)
    >>> surface_spectrum(surface)
    SurfaceSpectrum
      wave_number_y  64: -31.42 to 30.43 1/µm
      wave_number_x  64: -31.42 to 30.43 1/µm
      density        64 × 64: 0 to 0.002103 µm⁴
    """

    wave_number_y: Floats = field(metadata={"unit": "1/µm"})
    wave_number_x: Floats = field(metadata={"unit": "1/µm"})
    density: Floats = field(metadata={"unit": "µm⁴"})

    def moments(self, direction: float = 0.0) -> ProfileMoments:
        r"""Return the variances of height, slope and curvature of sections along a given direction.

        `direction` is in degrees from +x towards +y.

        Notes
        -----
        .. math:: m_n = \frac{1}{4π^2} \int (q_x \cos φ + q_y \sin φ)^n\, C^{2D}\, d^2q

        `ProfileMoments.nayak_parameter` is that of the profile along the line. Longuet-Higgins, Philosophical
        Transactions A 249 (1957) 321; Nayak, Journal of Lubrication Technology 93 (1971) 398.
        """
        angle = math.radians(validate_number("direction", direction))
        wave_number_along = self.wave_number_x * math.cos(angle) + self.wave_number_y[:, np.newaxis] * math.sin(angle)
        resolutions = [
            float(wave_numbers[1] - wave_numbers[0]) for wave_numbers in (self.wave_number_y, self.wave_number_x)
        ]
        squared_wave_number, height_variances = (
            np.square(wave_number_along),
            self.density * (resolutions[0] * resolutions[1] / (4 * math.pi**2)),
        )
        return ProfileMoments(
            height=float(height_variances.sum()),
            slope=float((squared_wave_number * height_variances).sum()),
            curvature=float((np.square(squared_wave_number) * height_variances).sum()),
        )

    def steepest_direction(self) -> float:
        r"""Return the direction with the largest mean square slope, in degrees from +x towards +y (0 to 180).

        A lay is perpendicular to this direction. In simulations of maps of 128 by 160 points that were stretched in one
        direction by 1.5, 2 and 3, nine tenths of the results were within 5.3, 3.1 and 2.2 degrees. Std of ISO 25178-2,
        the sector with the most power, depends on a few long wavelengths and scatters by tens of degrees.

        Notes
        -----
        .. math:: φ = \frac12 \arctan\frac{2 m_{11}}{m_{20} - m_{02}}

        with the moments of the slope spectrum: the principal axis of the mean square slope.
        """
        along_x, along_diagonal, along_y = (self.moments(angle).slope for angle in (0.0, 45.0, 90.0))
        double_angle = math.atan2(2 * along_diagonal - along_x - along_y, along_x - along_y)
        return math.degrees(double_angle) / 2 % 180

    def waves(self) -> tuple[Floats, Floats, Floats]:
        """Return wave number, direction (degrees from +x towards +y, 0 to 180) and density of each wave vector.

        Wave numbers are limited to the smaller Nyquist wave number, up to which all directions exist, and are in
        ascending order.
        """
        q_y, q_x = self.wave_number_y[:, np.newaxis], self.wave_number_x
        q = np.hypot(q_y, q_x)
        nyquist_wave_number = min(
            float(-wave_numbers[0]) if wave_numbers.size % 2 == 0 else float(wave_numbers[-1])
            for wave_numbers in (q_y[:, 0], q_x)
        )
        # Only one of two opposite wave vectors is used, because both describe the same sine wave.
        is_counted = ((q_y > 0) | ((q_y == 0) & (q_x > 0))) & (q < nyquist_wave_number * (1 - 1e-9))
        ascending_order = np.argsort(q[is_counted], kind="stable")
        directions = np.degrees(
            np.arctan2(np.broadcast_to(q_y, q.shape)[is_counted], np.broadcast_to(q_x, q.shape)[is_counted])
        )[ascending_order]
        return q[is_counted][ascending_order], directions % 180, self.density[is_counted][ascending_order]

    def radial(self, per_decade: int = 10) -> RadialSpectrum:
        """Average the spectrum in rings of the wave-vector plane; all rings have the same width in ln(wave number).

        There are `per_decade` rings per decade; empty rings are omitted.

        Examples
        --------
        >>> import numpy as np
        >>> from stiction import Surface, surface_spectrum
        >>> wave = np.cos(2 * np.pi * 3 * np.arange(64) / 64)
        >>> spectrum = surface_spectrum(Surface(0.1 * wave + np.zeros((64, 1)), spacing=0.5), periodic=True)
        >>> round(spectrum.moments(0).height, 12), round(abs(spectrum.moments(90).slope), 12)
        (0.005, 0.0)
        """
        per_decade = validate_whole_number("per_decade", per_decade, minimum=1)
        q, _, density = self.waves()
        if not q.size:
            rows, columns = self.density.shape
            raise ValueError(f"surface must have more points for a mean over directions, got {rows} × {columns} points")
        return RadialSpectrum(*_average_in_bins(per_decade, q, density, np.ones(q.size)))


def surface_spectrum(
    surface: BodyLike, *, periodic: bool = False, spacing: Any = None, unit: str = "um"
) -> SurfaceSpectrum:
    r"""Compute the power spectral density C2D of a height map about the mean height.

    Parameters
    ----------
    surface : Surface or array_like
        Heights. Level the surface first unless it is periodic: a tilt is a jump between opposite sides.
    periodic : bool
        True: no window. The sum of the spectrum equals the mean square height except for round-off. False: a Hann
        window along both axes, normalised to a mean square of 1.
    spacing : float (µm) or str, or a pair (y, x) of either
        Distance between the points of an array, such as 0.5 or "39 nm"; required for arrays.
    unit : str
        Unit of the heights of an array.

    Returns
    -------
    spectrum : SurfaceSpectrum
        Density C2D (µm⁴) over the wave numbers along y and x (1/µm).

    Raises
    ------
    ValueError
        If the argument is not a surface, or an array has no spacing.

    See Also
    --------
    power_spectrum : Spectrum of a profile.
    joined_spectrum : Spectrum from scans of several instruments.

    Notes
    -----
    .. math:: C(q) = \frac{Δx Δy}{N_x N_y} \left|\sum_{jl} w_j w_l (z_{jl} - \bar z) e^{-i q·r}\right|^2, \qquad
              h_{rms}^2 = \frac{1}{4π^2} \int C(q)\,d^2q

    A self-affine surface has C ∝ q^(-2-2H). Jacobs, Junge & Pastewka, Surface Topography: Metrology and Properties 5
    (2017) 013001.

    Examples
    --------
    >>> from stiction import self_affine_surface, surface_spectrum
    >>> surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1)
    >>> surface_spectrum(surface, periodic=True).density.shape
    (64, 64)
    """
    surface = as_body("surface", surface, Surface, spacing=spacing, unit=unit)
    check_bool("periodic", periodic)
    reject_flat_body(surface)
    return areal_spectrum(surface.heights - surface.heights.mean(), surface.spacing, windowed=not periodic)


def areal_spectrum(heights: Floats, spacing: tuple[float, float], *, windowed: bool) -> SurfaceSpectrum:
    """Compute the power spectral density of a map from heights (µm), with or without a Hann window on both axes."""
    from scipy.fft import fft2, fftshift

    if windowed:
        window_y, window_x = (
            (1 - np.cos(2 * math.pi * np.arange(points) / points)) / math.sqrt(1.5) for points in heights.shape
        )
        heights = heights * window_y[:, np.newaxis] * window_x
    transform = fftshift(fft2(heights))
    density = (transform.real**2 + transform.imag**2) * (spacing[0] * spacing[1] / heights.size)
    q_y, q_x = (
        2 * math.pi * np.fft.fftshift(np.fft.fftfreq(points, step))
        for points, step in zip(heights.shape, spacing, strict=True)
    )
    density[heights.shape[0] // 2, heights.shape[1] // 2] = 0.0
    return SurfaceSpectrum(
        wave_number_y=make_read_only(q_y), wave_number_x=make_read_only(q_x), density=make_read_only(density)
    )


# ---- Peaks ----------------------------------------------------------------------------------------------------------


def find_spectral_peak(spectrum: PowerSpectrum, *, lines: int = 1) -> tuple[float, float] | None:
    """Find a spectrum's highest peak that is narrow and statistically significant; return None without such a peak.

    Returns the wavelength (µm) of the peak and the fraction of m4 in all peaks; None if there is no peak.
    """
    bins = spectrum.in_bins(_PEAK_BINS_PER_DECADE)
    density = np.maximum(bins.density, np.finfo(float).tiny)
    bin_count = density.size
    half_widths = np.minimum(
        np.minimum(np.arange(bin_count), np.arange(bin_count)[::-1]), _PEAK_WINDOW_HALF_WIDTH_IN_BINS
    )
    median_density = np.array(
        [
            np.median(density[index - half_width : index + half_width + 1])
            for index, half_width in enumerate(half_widths)
        ]
    )
    density_ratio = density / median_density
    chance_ratio = 1 + 5 * np.sqrt(2 / (bins.count * lines))
    is_peak = (half_widths >= _PEAK_WINDOW_HALF_WIDTH_IN_BINS // 2) & (density_ratio > np.maximum(3.0, chance_ratio))
    if not is_peak.any():
        return None
    power_contributions = bins.wave_number**4 * density * bins.count
    fraction = float(
        (power_contributions - power_contributions / density_ratio)[is_peak].sum() / power_contributions.sum()
    )
    highest_bin = int(np.argmax(np.where(is_peak, density_ratio, 0)))
    return 2 * math.pi / float(bins.wave_number[highest_bin]), fraction
