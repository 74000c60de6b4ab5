"""Harmonics of a periodic texture in a spectrum, such as the feed marks of turning and milling."""

from __future__ import annotations

import math

import numpy as np

from stiction._checks import Floats

# Minimum distance (bins) between harmonics: between closer harmonics, too few bins are unaffected by them.
MIN_HARMONIC_DISTANCE_IN_BINS = 10
# Minimum bin of a first harmonic: in lower bins, a peak may be the mean or a tilt, spread by the Hann window.
_MIN_FIRST_HARMONIC_BIN = 2.5
_MAX_COMPARED_HARMONICS = 8
_MIN_SIGNIFICANT_HIGHER_HARMONICS = 2
_MAX_TESTED_PEAKS = 6
# By chance, about one bin in 1000 has ten times the spectral density of its neighbours.
_MIN_PEAK_TO_NEIGHBOUR_DENSITY_RATIO = 10.0
_PEAK_HALF_WIDTH_IN_BINS = 2.5
_SEARCH_POSITIONS_PER_BIN = 16
# The spectral density between two harmonics is estimated by this low quantile, which aliased harmonics hardly raise.
_BACKGROUND_DENSITY_QUANTILE = 0.3


def find_texture_harmonics(density: Floats) -> tuple[float, float]:
    """Find the first harmonic of a periodic texture in a spectrum, and the distance between harmonics, as bin numbers.

    Returns NaN if there is no periodic texture.

    A symmetric texture has only odd harmonics, so the distance between harmonics is twice the first harmonic.

    Parameters
    ----------
    density : (n,) ndarray of float
        Spectrum after a Hann window, at bins 1 to n; bin n is the Nyquist wave number.
    """
    nyquist_bin = density.size
    padded_density = np.concatenate([[0.0], density])
    is_rising, is_falling = density[1:] > density[:-1], density[:-1] >= density[1:]
    peaks = 1 + np.flatnonzero(np.r_[True, is_rising] & np.r_[is_falling, True])
    peaks = peaks[(peaks > _MIN_FIRST_HARMONIC_BIN) & (peaks * (1 + _MIN_SIGNIFICANT_HIGHER_HARMONICS) <= nyquist_bin)]
    # Peaks that contribute most to the slope variance are tested first: the first harmonic usually contributes most.
    peak_order = np.argsort(-padded_density[peaks] * np.square(peaks))[:_MAX_TESTED_PEAKS]
    best_score, best_harmonics = 0.0, (math.nan, math.nan)
    for peak in peaks[peak_order].tolist():
        first_harmonics = (
            peak + np.arange(-_SEARCH_POSITIONS_PER_BIN, _SEARCH_POSITIONS_PER_BIN + 1) / _SEARCH_POSITIONS_PER_BIN
        )
        for order_step in (1, 2):
            harmonic_orders = np.arange(
                1, min(order_step * _MAX_COMPARED_HARMONICS, int(nyquist_bin / (peak + 1))) + 1, order_step
            )
            background = _compute_median_between_harmonics(padded_density, peak * harmonic_orders, order_step * peak)
            harmonic_bins = np.rint(first_harmonics[:, np.newaxis] * harmonic_orders).astype(np.intp)
            density_ratio = padded_density[np.minimum(harmonic_bins, nyquist_bin)] / background
            scores = np.log(np.maximum(density_ratio, 1.0)).sum(axis=1)
            is_significant = density_ratio[int(np.argmax(scores))] > _MIN_PEAK_TO_NEIGHBOUR_DENSITY_RATIO
            min_significant = max(_MIN_SIGNIFICANT_HIGHER_HARMONICS, is_significant.size // 3 + 1)
            if is_significant[0] and is_significant[1:].sum() >= min_significant and scores.max() > best_score:
                best_score = float(scores.max())
                first_harmonic = float(first_harmonics[scores == scores.max()].mean())
                best_harmonics = first_harmonic, order_step * first_harmonic
    return best_harmonics


def estimate_density_between_harmonics(density: Floats, count: Floats, distance: float) -> Floats:
    """Estimate a spectrum's density between the harmonics of a texture, from a low quantile in moving windows.

    Parameters
    ----------
    density : (n,) ndarray of float
    count : (n,) ndarray of float
        Number of independent values in every bin: it determines the ratio of quantile and mean.
    distance : float
        Distance between harmonics, in bins.
    """
    from scipy.ndimage import percentile_filter
    from scipy.special import gammaincinv

    low_quantile = percentile_filter(
        density, 100 * _BACKGROUND_DENSITY_QUANTILE, size=2 * math.ceil(distance / 2) + 1, mode="nearest"
    )
    gamma_shape = np.maximum(count, 1.0)
    return np.asarray(low_quantile * gamma_shape / gammaincinv(gamma_shape, _BACKGROUND_DENSITY_QUANTILE))


def _compute_median_between_harmonics(padded_density: Floats, harmonics: Floats, distance: float) -> Floats:
    """Return the median spectral density near each harmonic: beyond its peak, up to halfway to the next harmonic."""
    bins = np.arange(padded_density.size)
    medians = []
    for harmonic in harmonics.tolist():
        distances = np.abs(bins - harmonic)
        nearby_densities = padded_density[
            (distances > min(_PEAK_HALF_WIDTH_IN_BINS, distance / 2 - 0.5)) & (distances <= distance / 2) & (bins > 0)
        ]
        medians.append(float(np.median(nearby_densities)) if nearby_densities.size else math.inf)
    return np.asarray(np.maximum(np.array(medians), np.finfo(float).tiny))
