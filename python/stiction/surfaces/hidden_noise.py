"""Estimate of white instrument noise that is too weak to flatten the end of a spectrum."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stiction._checks import Floats
from stiction.surfaces.filters import MIN_CUTOFF_POINTS
from stiction.surfaces.floor_fit import BinnedSpectrum, fit_noise_floor
from stiction.surfaces.harmonics import find_texture_harmonics
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.scale import (
    MAX_NEGLIGIBLE_NOISE_FRACTION,
    LineSpectrum,
    cutoff_for_slope_fraction,
    line_spectra,
    scale_dependent_roughness,
)
from stiction.surfaces.spectrum import HANN_VARIANCE_FACTOR, surface_spectrum
from stiction.surfaces.surface import Surface

MAX_FITTED_WAVELENGTH_POINTS = 16.0
_BINS_PER_OCTAVE = 8
_MIN_FIT_BINS = 8
_RELATIVE_MODEL_ERROR = 0.1
# Limits of the exponent fitted to spectra of scan lines: 1 (Hurst exponent 0) and 5 (Hurst exponent 2).
_LINE_SPECTRUM_EXPONENT_RANGE = (1.0, 5.0)
# The fitted noise must not exceed this multiple of the noise estimated from wavelengths below four points.
_MAX_FITTED_TO_SHORT_WAVELENGTH_NOISE_RATIO = 2.0


@dataclass(frozen=True)
class NoiseHiddenInSpectrum:
    """White noise that a spectrum may hide, and the low-pass cutoff that removes as much slope as this noise adds."""

    slope_fraction: float
    # Cutoff (µm) of the low-pass filter that removes the fraction `slope_fraction` of the mean square slope.
    cut_off: float


def find_hidden_noise(body: Profile | Surface, *, periodic: bool = False) -> NoiseHiddenInSpectrum | None:
    """Estimate the white noise that a scan may contain although its spectrum shows no noise floor.

    The spectra of the lines, at wavelengths of 2 to 16 points, are fitted by power laws with a common floor. Roughness
    that is aliased by a coarse spacing flattens a spectrum in the same way.

    Returns
    -------
    noise : NoiseHiddenInSpectrum or None
        None if power laws alone fit as well, if the noise contributes less than a tenth of the mean square slope, or if
        there is a periodic texture, whose aliased harmonics are no noise. None also if the spectrum of a map is too low
        for the noise at short wavelengths along both axes, as for aliased straight grooves: white noise has the same
        density at all wave vectors.
    """
    spectra = line_spectra(body, periodic)
    if any(find_texture_harmonics(density)[0] > 0 for _, density, *_ in spectra):
        return None
    binned_spectra = [_bin_short_wavelengths(spectrum, periodic) for spectrum in spectra]
    fitted_spectra = [spectrum for spectrum in binned_spectra if spectrum is not None]
    if not fitted_spectra:
        return None
    fit = fit_noise_floor(fitted_spectra, exponents=_LINE_SPECTRUM_EXPONENT_RANGE)
    mean_square_slope = sum(float(np.square(q) @ density) * float(q[0]) for q, density, *_ in spectra)
    noise_mean_square_slope = sum(
        float(np.square(q).sum()) * float(q[0]) * fit.level * spacing for q, _, _, spacing in spectra
    )
    noise_fraction = noise_mean_square_slope / mean_square_slope
    if not fit.is_significant or noise_fraction <= MAX_NEGLIGIBLE_NOISE_FRACTION:
        return None
    if isinstance(
        body, Surface
    ) and fit.level > _MAX_FITTED_TO_SHORT_WAVELENGTH_NOISE_RATIO * _estimate_short_wavelength_noise(body, periodic):
        return None
    roughness = scale_dependent_roughness(body, periodic=periodic)
    longest_wavelength, shortest_wavelength = (
        MAX_FITTED_WAVELENGTH_POINTS * max(body.spacings),
        MIN_CUTOFF_POINTS * min(body.spacings),
    )
    return NoiseHiddenInSpectrum(
        noise_fraction, cutoff_for_slope_fraction(roughness, noise_fraction, longest_wavelength, shortest_wavelength)
    )


def _estimate_short_wavelength_noise(surface: Surface, periodic: bool) -> float:
    """Estimate the variance (µm²) of white noise from the median spectral density of a map at short wavelengths.

    The median is taken over the wavelengths below four points along both axes. The densities of noise are
    exponentially distributed, so their median is ln 2 of their mean.
    """
    spectrum = surface_spectrum(surface if periodic else levelled(surface, "plane"), periodic=periodic)
    q_y, q_x = (np.abs(q_axis) for q_axis in (spectrum.wave_number_y, spectrum.wave_number_x))
    density = spectrum.density[np.ix_(q_y > q_y.max() / 2, q_x > q_x.max() / 2)]
    return float(np.median(density)) / (math.log(2) * math.prod(surface.spacing))


def _bin_short_wavelengths(spectrum: LineSpectrum, periodic: bool) -> BinnedSpectrum | None:
    """Average a spectrum in bins at short wavelengths (up to 16 grid spacings); return None for too few bins."""
    q, density, count, spacing = spectrum
    # The first two harmonics are excluded, because the Hann window adds power from longer wavelengths to them.
    if not periodic:
        q, density, count = q[2:], density[2:], count[2:]
    is_fitted = q * MAX_FITTED_WAVELENGTH_POINTS * spacing * (1 + 1e-9) >= 2 * math.pi
    q, density, count = q[is_fitted], density[is_fitted], count[is_fitted]
    if not q.size or not density.all():
        return None
    _, bin_index = np.unique(np.floor(_BINS_PER_OCTAVE * np.log2(q[-1] / q) + 1e-9), return_inverse=True)
    total_count = np.bincount(bin_index, count)
    if total_count.size < _MIN_FIT_BINS:
        return None
    log_q: Floats = np.bincount(bin_index, count * np.log(q)) / total_count
    log_density_variance = (1.0 if periodic else HANN_VARIANCE_FACTOR) / total_count + _RELATIVE_MODEL_ERROR**2
    return BinnedSpectrum(
        log_q, np.bincount(bin_index, count * density) / total_count, 1 / log_density_variance, spacing
    )
