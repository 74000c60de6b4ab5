"""Maximum-likelihood fit of power laws with a common noise floor to binned spectra."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stiction._checks import Floats

MIN_FLOOR_LIKELIHOOD_GAIN = 2.0  # minimum log-likelihood gain of a significant noise floor over power laws alone
# initial level of the fitted floor, as a fraction of the maximum level that the lowest density allows
_INITIAL_FLOOR_FRACTION = 0.3


class BinnedSpectrum(NamedTuple):
    """Spectrum averaged in wave number bins."""

    log_q: Floats  # logarithm of the wave number
    density: Floats
    weight: Floats  # shape parameters of the gamma distributions of the densities
    floor: float = 1.0  # density of a floor of level 1; for white noise of variance 1, this is the spacing


class NoiseFloorFit(NamedTuple):
    """Power laws with a common noise floor, fitted to spectra. The densities are A q^-s + level * floor."""

    level: float
    gain: float  # log-likelihood gain over the best power laws without a floor
    exponents: tuple[float, ...]  # exponent s of each spectrum
    ratios: tuple[float, ...]  # ratio of the floor to the power law at the largest wave number of each spectrum

    @property
    def is_significant(self) -> bool:
        """True if the floor fits the spectra significantly better than power laws alone."""
        return self.gain > MIN_FLOOR_LIKELIHOOD_GAIN


def fit_floor(spectra: Sequence[BinnedSpectrum], *, exponents: tuple[float, float]) -> NoiseFloorFit:
    """Fit spectra by power laws plus a common non-negative noise floor. The exponents stay within a given range."""
    from scipy.optimize import minimize

    unit = min(float(spectrum.density.min()) / spectrum.floor for spectrum in spectra)
    scaled = [
        (log_q - log_q.max(), density / (unit * floor), weight / weight.sum(), float(weight.sum()))
        for log_q, density, weight, floor in spectra
    ]

    def loss(parameters: Floats) -> tuple[float, Floats]:
        """Return the negative log-likelihood, up to a constant, and its gradient."""
        total, gradient = 0.0, np.zeros(parameters.size)
        level = parameters[-1]
        for index, (log_q, density, fraction, weight) in enumerate(scaled):
            law = np.exp(parameters[2 * index] - parameters[2 * index + 1] * log_q)
            model = law + level
            total += weight * float(fraction @ (np.log(model) + density / model))
            slope = weight * fraction * (1 - density / model) / model
            gradient[2 * index : 2 * index + 2] = slope @ law, -(slope * law) @ log_q
            gradient[-1] += slope.sum()
        return total, gradient

    start: list[float] = []
    bounds: list[tuple[float | None, float | None]] = []
    for log_q, density, fraction, _ in scaled:
        exponent = float(np.clip(-np.polyfit(log_q, np.log(density), 1, w=np.sqrt(fraction))[0], *exponents))
        start += [float(fraction @ (np.log(density) + exponent * log_q)), exponent]
        bounds += [(None, None), exponents]
    alone = minimize(loss, [*start, 0.0], jac=True, bounds=[*bounds, (0.0, 0.0)], method="L-BFGS-B")
    first = [*alone.x[:-1], _INITIAL_FLOOR_FRACTION]
    with_floor = minimize(loss, first, jac=True, bounds=[*bounds, (0.0, None)], method="L-BFGS-B")
    best = with_floor if with_floor.fun < alone.fun else alone
    *laws, level = best.x.tolist()
    ratios = tuple(level * math.exp(-value) for value in laws[::2])
    return NoiseFloorFit(unit * level, float(alone.fun - best.fun), tuple(laws[1::2]), ratios)
