"""Roughness of a measured height map along its rows or columns, as a stylus instrument measures it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from stiction._checks import Floats, check_choice, make_read_only
from stiction._repr import TextReprMixin
from stiction.surfaces.hurst import HurstEstimate, estimate_hurst_exponent
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import LineOrientation, Profile
from stiction.surfaces.roughness import roughness_parameters
from stiction.surfaces.spectrum import PowerSpectrum, RadialSpectrum, is_within_wavelength_band, power_spectrum
from stiction.surfaces.surface import Surface, as_body, reject_flat_body

# Maximum number of fitted lines of a map: more lines add little information, because neighbouring lines are correlated.
MAX_FITTED_LINES = 64
_LINE_ORIENTATIONS: tuple[LineOrientation, LineOrientation] = ("x", "y")
# A power law is accepted if the spectral density deviates from it by at most this factor (logarithmic rms).
MAX_POWER_LAW_MISFIT = 1.5
_MAX_RATIO_OF_EQUAL_BAND_LIMITS = 1.5
_POWER_LAW_MODEL_VARIANCE = 0.04
_MIN_LINE_POINTS = 7


@dataclass(frozen=True, eq=False, repr=False)
class LineRoughness(TextReprMixin):
    """Roughness of a height map along its rows or columns; each row or column is levelled by a least-squares line.

    Attributes
    ----------
    lines : int
        Number of lines.
    Pq : float, µm
        Root-mean-square height over all lines.
    Pdq, Pdq_neighbours : float
        Root-mean-square slope over all lines, from the seven-point formula and from differences of neighbouring points.
    spectrum : PowerSpectrum
        Mean spectrum of the lines, after a Hann window.
    band : (float, float), µm, or None
        Shortest and longest wavelength for the fit of the Hurst exponents: the given band, or the median band of the
        lines. None if fewer than half of the lines have a self-affine band.
    fitted : int
        Number of lines, evenly spaced, that were searched for a band and fitted.
    with_band : int
        Number of fitted lines with a band; all of them if the band was given.
    hurst_exponents : (k,) ndarray of float
        Exponents of the fitted lines in the common band; empty without a band. Flat lines have no exponent.
    misfit : float
        Rms factor between the mean spectrum, in ten bins per decade, and the power law with the mean exponent: 1 for an
        exact power law; NaN if there are no exponents.

    Examples
    --------
    >>> from stiction import line_roughness, self_affine_surface
    >>> surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1)
    >>> round(1000 * line_roughness(surface, "x").Pq, 2)  # nm
    11.28
    """

    lines: int
    Pq: float = field(metadata={"unit": "µm"})
    Pdq: float
    Pdq_neighbours: float
    spectrum: PowerSpectrum
    band: tuple[float, float] | None = field(metadata={"unit": "µm"})
    fitted: int
    with_band: int
    hurst_exponents: Floats
    misfit: float = math.nan

    @property
    def is_straight(self) -> bool:
        """True if the lines' mean spectrum is almost a power law, so that it is straight on logarithmic axes."""
        return self.misfit <= MAX_POWER_LAW_MISFIT


def line_roughness(
    surface: Surface, along: LineOrientation, *, band: tuple[float, float] | None = None
) -> LineRoughness:
    """Compute the roughness of a height map along its rows or along its columns.

    Parameters
    ----------
    surface : Surface
        Surface, not flat. Levelling has no effect, because every line is levelled separately.
    along : {"x", "y"}
        Direction of the lines: "x" for the rows, "y" for the columns.
    band : (float, float), µm, optional
        Shortest and longest wavelength for the fit of the Hurst exponents; by default the median band of the lines.

    Returns
    -------
    roughness : LineRoughness
        Rms height (µm) and slope over all lines, their mean spectrum, and their Hurst exponents.

    Raises
    ------
    ValueError
        If the surface is flat, if its lines have fewer than 7 points, or if a given band has too few harmonics.

    See Also
    --------
    lines_along_both : Lines along x and along y in a common band.

    Notes
    -----
    The self-affine band of a single line of a few hundred points is uncertain, and exponents from different bands must
    not be averaged. Therefore all lines are fitted in the median band.

    Examples
    --------
    >>> from stiction import line_roughness, random_phases, weierstrass_mandelbrot_surface
    >>> surface = weierstrass_mandelbrot_surface(random_phases(1), 1.3, shape=(60, 80), extent=8.0)
    >>> along_x = line_roughness(surface, "x", band=(0.3, 2.0))
    >>> along_x.lines, along_x.hurst_exponents.size
    (60, 60)
    """
    check_choice("along", along, LineOrientation)
    reject_flat_body(surface)
    line_count, points = surface.heights.shape if along == "x" else surface.heights.shape[::-1]
    if points < _MIN_LINE_POINTS:
        raise ValueError(f"lines along {along} must have at least {_MIN_LINE_POINTS} points, got {points}")
    mean_squares, density = np.zeros(3), np.zeros(points // 2)
    fitted_indices = set(np.linspace(0, line_count - 1, min(line_count, MAX_FITTED_LINES)).round().astype(int).tolist())
    fitted_lines = []
    for line_index in range(line_count):
        unlevelled_line = surface.row(line_index) if along == "x" else surface.column(line_index)
        line = levelled(unlevelled_line, "line")
        spectrum = power_spectrum(line)
        density += spectrum.density / line_count
        if not line.is_flat:
            parameters = roughness_parameters(line)
            pdq_neighbours = roughness_parameters(line, derivative="neighbours").Pdq
            mean_squares += np.square([parameters.Pq, parameters.Pdq, pdq_neighbours]) / line_count
        if line_index in fitted_indices:
            fitted_lines.append(unlevelled_line)
    free_fits = [fit for line in fitted_lines if (fit := _estimate_line_hurst_exponent(line, band)) is not None]
    if band is not None and not free_fits and (rough_lines := [line for line in fitted_lines if not line.is_flat]):
        # If the fits of all lines failed, one fit is repeated to raise the error with the reason.
        estimate_hurst_exponent(rough_lines[0], band=band)
    band_fits = free_fits
    if band is None and 2 * len(free_fits) >= len(fitted_lines):
        band_ends = np.median([(fit.shortest_wavelength, fit.longest_wavelength) for fit in free_fits], axis=0)
        band = float(band_ends[0]), float(band_ends[1])
        band_fits = [fit for line in fitted_lines if (fit := _estimate_line_hurst_exponent(line, band)) is not None]
    pq, pdq, pdq_neighbours = np.sqrt(mean_squares).tolist()
    spectrum = replace(spectrum, density=make_read_only(density))
    exponents = np.array([fit.value for fit in band_fits if band is not None])
    misfit = math.nan
    if band is not None and exponents.size:
        misfit = power_law_misfit(spectrum.in_bins(), band, float(exponents.mean()))
    return LineRoughness(
        line_count, pq, pdq, pdq_neighbours, spectrum, band, len(fitted_lines), len(free_fits),
        make_read_only(exponents), misfit
    )  # fmt: skip


def lines_along_both(
    surface: Surface, *, band: tuple[float, float] | None = None
) -> tuple[LineRoughness, LineRoughness]:
    """Compute the roughness of a map's lines along x and along y, with Hurst exponents from one band if possible.

    Parameters
    ----------
    surface : Surface
        Surface, not flat.
    band : (float, float), µm, optional
        Shortest and longest wavelength for the fit of the Hurst exponents. By default, the bands of both directions are
        combined if they agree within a factor of 1.5 at both ends and at least one mean spectrum follows its power law
        there within a factor of 1.5. Otherwise the band is taken from `estimate_hurst_exponent` of the surface. If no
        band is found, or the band is too narrow for single lines, each direction keeps its own band.

    Returns
    -------
    along_x, along_y : LineRoughness
        Roughness of the rows and of the columns.

    Raises
    ------
    ValueError
        As for `line_roughness`.

    See Also
    --------
    line_roughness : Lines along one axis.

    Examples
    --------
    >>> from stiction import lines_along_both, self_affine_surface
    >>> surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(24, 32), spacing=0.1)
    >>> along_x, along_y = lines_along_both(surface)
    >>> along_x.lines, along_y.lines
    (24, 32)
    """
    surface = as_body("surface", surface, Surface)
    along_x, along_y = line_roughness(surface, "x", band=band), line_roughness(surface, "y", band=band)
    if band is not None:
        return along_x, along_y
    if along_x.band is not None and along_y.band is not None:
        band_ends = np.array([along_x.band, along_y.band])
        if (band_ends.max(axis=0) < _MAX_RATIO_OF_EQUAL_BAND_LIMITS * band_ends.min(axis=0)).all():
            if along_x.band != along_y.band:
                shortest_wavelength, longest_wavelength = np.sqrt(band_ends.prod(axis=0)).tolist()
                along_x, along_y = (
                    line_roughness(surface, along, band=(shortest_wavelength, longest_wavelength))
                    for along in _LINE_ORIENTATIONS
                )
            if not min(along_x.misfit, along_y.misfit) > MAX_POWER_LAW_MISFIT:
                return along_x, along_y
    try:
        areal_estimate = estimate_hurst_exponent(surface)
        common_band = areal_estimate.shortest_wavelength, areal_estimate.longest_wavelength
        return line_roughness(surface, "x", band=common_band), line_roughness(surface, "y", band=common_band)
    except ValueError:
        return along_x, along_y


def power_law_misfit(
    bins: PowerSpectrum | RadialSpectrum, band: tuple[float, float], exponent: float, *, dimensions: int = 1,
    chance: float = 0.0,
) -> float:  # fmt: skip
    """Return the rms factor by which a spectrum deviates from a power law in a wavelength band, beyond random scatter.

    `chance` is the variance of ln(density) that scatter causes in a single harmonic. The factor is 1 for a power law.
    """
    is_in_band = is_within_wavelength_band(bins.wave_number, *band) & (bins.density > 0)
    if not is_in_band.any():
        return math.nan
    log_ratio = np.log(bins.density[is_in_band] * bins.wave_number[is_in_band] ** (dimensions + 2 * exponent))
    chance_variance = chance / bins.count[is_in_band]
    weight = 1 / (chance_variance + _POWER_LAW_MODEL_VARIANCE)
    squared_deviation = np.square(log_ratio - np.average(log_ratio, weights=weight)) - chance_variance
    return math.exp(math.sqrt(max(0.0, float(np.average(squared_deviation, weights=weight)))))


def _estimate_line_hurst_exponent(line: Profile, band: tuple[float, float] | None) -> HurstEstimate | None:
    """Estimate the Hurst exponent of one line of a map; return None if the line is flat or has no self-affine band."""
    try:
        return estimate_hurst_exponent(line, band=band)
    except ValueError:
        return None
