"""The highest narrow peak of a spectrum: waves of one length, as of turning marks."""

from __future__ import annotations

import math

import numpy as np

from stiction.surfaces.spectrum import PowerSpectrum

_PEAK_BINS = 24
"""Bins to a decade in which peaks are looked for."""

_PEAK_REACH = 6
"""Bins to both sides that tell the level at a bin: half a decade together. A straight spectrum is its own median."""


def peak_of(spectrum: PowerSpectrum, *, lines: int = 1) -> tuple[float, float] | None:
    """Wavelength (µm) of a spectrum's highest narrow peak, and the share of m4 in all of them; None without one.

    A peak rises above the median of half a decade about it by more than a factor of three, and by more than chance
    does in the mean of so many lines.
    """
    bins = spectrum.in_bins(_PEAK_BINS)
    density = np.maximum(bins.density, np.finfo(float).tiny)
    size = density.size
    reach = np.minimum(np.minimum(np.arange(size), np.arange(size)[::-1]), _PEAK_REACH)
    level = np.array([np.median(density[at - each : at + each + 1]) for at, each in enumerate(reach)])
    excess = density / level
    chance = 1 + 5 * np.sqrt(2 / (bins.count * lines))
    peaks = (reach >= _PEAK_REACH // 2) & (excess > np.maximum(3.0, chance))
    if not peaks.any():
        return None
    power = bins.wave_number**4 * density * bins.count
    share = float((power - power / excess)[peaks].sum() / power.sum())
    highest = int(np.argmax(np.where(peaks, excess, 0)))
    return 2 * math.pi / float(bins.wave_number[highest]), share
