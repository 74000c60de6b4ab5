"""Harmonics of one period in a spectrum: the marks that feeds of turning and milling leave."""

from __future__ import annotations

import math

import numpy as np

from stiction._checks import Floats

MIN_HARMONIC_DISTANCE = 10  # bins between harmonics above which the spectrum between them can be judged
_MIN_PERIODS = 2.5  # first harmonic, in bins: a Hann window spreads each over two bins to both sides
_MAX_HARMONICS = 8  # harmonics that are compared with the spectrum between them
_MIN_HARMONICS = 2  # harmonics above the first that a period must have, and a third of those that are compared
_MAX_CANDIDATES = 6  # peaks that are tried as the first harmonic
_TOOTH = 10.0  # density of a harmonic over that between harmonics: by chance about one in a thousand bins has it
_LOBE = 2.5  # bins to each side of a harmonic that the window spreads it to
_STEPS = 16  # steps to a bin in which the first harmonic is refined
_QUANTILE = 0.3  # quantile of a spectrum within a period that harmonics, folded ones as well, do not reach


def find_period(density: Floats) -> tuple[float, float]:
    """Find the first harmonic of a periodic texture and the distance of its harmonics, both in bins; NaN without one.

    A symmetric texture has odd harmonics only, so that their distance is twice the first.

    Parameters
    ----------
    density : (n,) ndarray of float
        Spectrum after a Hann window at bins 1 to n, the last one at the Nyquist wave number.
    """
    size = density.size
    padded = np.concatenate([[0.0], density])
    rising, falling = density[1:] > density[:-1], density[:-1] >= density[1:]
    peaks = 1 + np.flatnonzero(np.r_[True, rising] & np.r_[falling, True])
    peaks = peaks[(peaks > _MIN_PERIODS) & (peaks * (1 + _MIN_HARMONICS) <= size)]
    # Most of the slope of a texture is in its first harmonics.
    order = np.argsort(-padded[peaks] * np.square(peaks))[:_MAX_CANDIDATES]
    best, found = 0.0, (math.nan, math.nan)
    for peak in peaks[order].tolist():
        first = peak + np.arange(-_STEPS, _STEPS + 1) / _STEPS
        for step in (1, 2):
            orders = np.arange(1, min(step * _MAX_HARMONICS, int(size / (peak + 1))) + 1, step)
            level = _between(padded, peak * orders, step * peak)
            at = np.rint(first[:, np.newaxis] * orders).astype(np.intp)
            ratio = padded[np.minimum(at, size)] / level
            scores = np.log(np.maximum(ratio, 1.0)).sum(axis=1)
            teeth = ratio[int(np.argmax(scores))] > _TOOTH
            needed = max(_MIN_HARMONICS, teeth.size // 3 + 1)
            if teeth[0] and teeth[1:].sum() >= needed and scores.max() > best:
                best = float(scores.max())
                period = float(first[scores == scores.max()].mean())
                found = period, step * period
    return found


def between_harmonics(density: Floats, count: Floats, distance: float) -> Floats:
    """Return the density between the harmonics of a texture, from a low quantile over their distance (bins).

    Parameters
    ----------
    density : (n,) ndarray of float
    count : (n,) ndarray of float
        Number of independent values in each, of which the quantile is a known part of the mean.
    distance : float
    """
    from scipy.ndimage import percentile_filter
    from scipy.special import gammaincinv

    low = percentile_filter(density, 100 * _QUANTILE, size=2 * math.ceil(distance / 2) + 1, mode="nearest")
    shape = np.maximum(count, 1.0)
    return np.asarray(low * shape / gammaincinv(shape, _QUANTILE))


def _between(padded: Floats, harmonics: Floats, distance: float) -> Floats:
    """Median density on both sides of each harmonic, halfway to the next ones."""
    bins = np.arange(padded.size)
    levels = []
    for place in harmonics.tolist():
        off = np.abs(bins - place)
        apart = padded[(off > min(_LOBE, distance / 2 - 0.5)) & (off <= distance / 2) & (bins > 0)]
        levels.append(float(np.median(apart)) if apart.size else math.inf)
    return np.asarray(np.maximum(np.array(levels), np.finfo(float).tiny))
