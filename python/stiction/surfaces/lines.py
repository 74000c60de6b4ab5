"""Roughness of a measured surface along its lines, as a stylus would find it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from stiction._checks import Floats, choice, read_only
from stiction._shown import Readable
from stiction.surfaces.hurst import HurstEstimate, estimate_hurst_exponent
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Along, Profile
from stiction.surfaces.roughness import roughness_parameters
from stiction.surfaces.spectrum import PowerSpectrum, RadialSpectrum, in_band, power_spectrum
from stiction.surfaces.surface import Surface, as_body, reject_flat

MAX_FITTED_LINES = 64  # lines that a Hurst exponent is fitted to; neighbours are alike, so more of them say little more
_BOTH: tuple[Along, Along] = ("x", "y")
MAX_MISFIT = 1.5  # factor by which a spectrum is off its power law, at which it is none
_SAME_BAND = 1.5
_OF_CHANCE = 0.04  # variance of a bin's logarithm from which on chance makes the bin count less
_FEWEST_POINTS = 7  # points that a seven-point slope needs


@dataclass(frozen=True, eq=False, repr=False)
class LineRoughness(Readable):
    """Roughness of the parallel lines of a surface, each about its own least-squares line.

    Attributes
    ----------
    lines : int
    Pq : float, µm
        Root-mean-square height over all lines.
    Pdq, Pdq_neighbours : float
        Root-mean-square slope over all lines, by seven points and by differences of neighbours.
    spectrum : PowerSpectrum
        Mean over the lines, after a Hann window.
    band : (float, float), µm, or None
        Wavelengths that the Hurst exponents are fitted to, shortest and longest: those given, or the medians of what is
        found line by line. None if it is found in less than half of the lines.
    fitted : int
        Lines that a band was looked for in and a Hurst exponent fitted to, evenly spread over all.
    with_band : int
        Those of them in which a band was found; all, if it was given.
    hurst_exponents : (k,) ndarray of float
        Of the fitted lines, all in the same band; empty without one. Lines without roughness have none.
    misfit : float
        Factor by which the mean spectrum, in ten bins to a decade of the band, is off the power law of the mean
        exponent, as a root mean square of logarithms: 1 for a straight spectrum. NaN without exponents.

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
        """Whether there are exponents, and the mean spectrum is a power law."""
        return self.misfit <= MAX_MISFIT


def line_roughness(surface: Surface, along: Along, *, band: tuple[float, float] | None = None) -> LineRoughness:
    """Roughness of the lines of a surface along one axis.

    Parameters
    ----------
    surface : Surface
        Not flat; levelling does not matter, because each line is levelled by a line of its own.
    along : {"x", "y"}
        The rows, or the columns.
    band : (float, float), µm, optional
        Shortest and longest wavelength to fit Hurst exponents to.

    Raises
    ------
    ValueError
        If the surface is flat, its lines have fewer than 7 points, or a given band holds too few harmonics.

    Notes
    -----
    A self-affine band is rarely found well in a line of some hundred points, and exponents of different bands must not
    be averaged. So the band is the median one, and all lines are fitted in it.

    Examples
    --------
    >>> from stiction import line_roughness, random_phases, weierstrass_mandelbrot_surface
    >>> surface = weierstrass_mandelbrot_surface(random_phases(1), 1.3, shape=(60, 80), extent=8.0)
    >>> along_x = line_roughness(surface, "x", band=(0.3, 2.0))
    >>> along_x.lines, along_x.hurst_exponents.size
    (60, 60)
    """
    choice("along", along, Along)
    reject_flat(surface)
    count, points = surface.heights.shape if along == "x" else surface.heights.shape[::-1]
    if points < _FEWEST_POINTS:
        raise ValueError(f"lines along {along} must have at least {_FEWEST_POINTS} points, got {points}")
    squares, density = np.zeros(3), np.zeros(points // 2)
    chosen = set(np.linspace(0, count - 1, min(count, MAX_FITTED_LINES)).round().astype(int).tolist())
    fitted = []
    for index in range(count):
        measured = surface.row(index) if along == "x" else surface.column(index)
        line = levelled(measured, "line")
        spectrum = power_spectrum(line)
        density += spectrum.density / count
        if not line.is_flat:
            parameters = roughness_parameters(line)
            neighbours = roughness_parameters(line, derivative="neighbours").Pdq
            squares += np.square([parameters.Pq, parameters.Pdq, neighbours]) / count
        if index in chosen:
            fitted.append(measured)
    found = [fit for line in fitted if (fit := _fit(line, band)) is not None]
    if band is not None and not found and (rough := [line for line in fitted if not line.is_flat]):
        estimate_hurst_exponent(rough[0], band=band)  # which says why
    estimates = found
    if band is None and 2 * len(found) >= len(fitted):
        ends = np.median([(fit.shortest_wavelength, fit.longest_wavelength) for fit in found], axis=0)
        band = float(ends[0]), float(ends[1])
        estimates = [fit for line in fitted if (fit := _fit(line, band)) is not None]
    pq, pdq, neighbours = np.sqrt(squares).tolist()
    spectrum = replace(spectrum, density=read_only(density))
    exponents = np.array([fit.value for fit in estimates if band is not None])
    misfit = math.nan
    if band is not None and exponents.size:
        misfit = power_law_misfit(spectrum.in_bins(), band, float(exponents.mean()))
    return LineRoughness(
        count, pq, pdq, neighbours, spectrum, band, len(fitted), len(found), read_only(exponents), misfit
    )  # fmt: skip


def lines_along_both(
    surface: Surface, *, band: tuple[float, float] | None = None
) -> tuple[LineRoughness, LineRoughness]:
    """Roughness of the lines along x and along y, their exponents fitted in one band.

    Parameters
    ----------
    surface : Surface
    band : (float, float), µm, optional
        By default, the bands of both directions are combined if they agree within a factor of 1.5 at both ends and at
        least one mean spectrum follows its power law there within a factor of 1.5. Otherwise the band is taken from
        `estimate_hurst_exponent` of the surface. If that finds no band, or one too narrow for single lines, each
        direction keeps its own band.

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
        ends = np.array([along_x.band, along_y.band])
        if (ends.max(axis=0) < _SAME_BAND * ends.min(axis=0)).all():
            if along_x.band != along_y.band:
                shortest, longest = np.sqrt(ends.prod(axis=0)).tolist()
                along_x, along_y = (line_roughness(surface, along, band=(shortest, longest)) for along in _BOTH)
            if not min(along_x.misfit, along_y.misfit) > MAX_MISFIT:
                return along_x, along_y
    try:
        found = estimate_hurst_exponent(surface)
        common = found.shortest_wavelength, found.longest_wavelength
        return line_roughness(surface, "x", band=common), line_roughness(surface, "y", band=common)
    except ValueError:
        return along_x, along_y


def power_law_misfit(
    bins: PowerSpectrum | RadialSpectrum, band: tuple[float, float], exponent: float, *, dimensions: int = 1,
    chance: float = 0.0,
) -> float:  # fmt: skip
    """Factor by which a spectrum in bins is off a power law in a band, as rms of logarithms, less its `chance`."""
    inside = in_band(bins.wave_number, *band) & (bins.density > 0)
    if not inside.any():
        return math.nan
    ratio = np.log(bins.density[inside] * bins.wave_number[inside] ** (dimensions + 2 * exponent))
    scatter = chance / bins.count[inside]
    weight = 1 / (scatter + _OF_CHANCE)
    square = np.square(ratio - np.average(ratio, weights=weight)) - scatter
    return math.exp(math.sqrt(max(0.0, float(np.average(square, weights=weight)))))


def _fit(line: Profile, band: tuple[float, float] | None) -> HurstEstimate | None:
    """None if the line is flat, or no band is found in it."""
    try:
        return estimate_hurst_exponent(line, band=band)
    except ValueError:
        return None
