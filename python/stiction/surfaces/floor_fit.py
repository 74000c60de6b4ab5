"""Maximum-likelihood fit of power laws and white noise to spectra that are averaged in bins."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stiction._checks import Floats

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

# A noise floor is significant if adding it to the power laws raises the log-likelihood of the fit by more than 2.
MIN_FLOOR_LIKELIHOOD_GAIN = 2.0
# initial noise level of the fit, as a fraction of the lowest spectral density
_INITIAL_FLOOR_FRACTION = 0.3
# tolerance of the fit of a noise floor, for which the noise level typically has a relative error below 3e-6
_FIT_TOLERANCE = 1e-12
# maximum number of evaluations of the likelihood of a noise floor; nearly all fits need fewer than 100
_MAX_FIT_EVALUATIONS = 2000


class BinnedSpectrum(NamedTuple):
    """Line spectrum averaged in bins of wave number."""

    log_q: Floats  # logarithm of the wave number
    density: Floats
    weight: Floats  # shape parameter of the gamma distribution of the spectral density in each bin
    # spectral density of a noise floor whose fitted level is 1
    floor: float = 1.0


class NoiseFloorFit(NamedTuple):
    """Fit of power laws plus common white noise to spectra, with the densities A q^-s + level * floor."""

    level: float
    gain: float  # increase of the log-likelihood due to the noise floor
    exponents: tuple[float, ...]  # exponent s of the power law fitted to each spectrum
    # fitted noise density divided by the power law, at the largest wave number of each spectrum
    ratios: tuple[float, ...]

    @property
    def is_significant(self) -> bool:
        """True if the spectra contain white noise: it improves the fit significantly."""
        return self.gain > MIN_FLOOR_LIKELIHOOD_GAIN


def fit_noise_floor(spectra: Sequence[BinnedSpectrum], *, exponents: tuple[float, float]) -> NoiseFloorFit:
    """Fit a power law to each spectrum, plus a common noise level. The exponents stay within a given range."""
    from scipy.optimize import minimize

    max_floor_level = min(float(spectrum.density.min()) / spectrum.floor for spectrum in spectra)
    scaled_spectra = [
        (log_q - log_q.max(), density / (max_floor_level * floor), weight / weight.sum(), float(weight.sum()))
        for log_q, density, weight, floor in spectra
    ]

    def loss(parameters: Floats) -> tuple[float, Floats]:
        """Return the negative log-likelihood, without a constant term, and its gradient."""
        total, gradient = 0.0, np.zeros(parameters.size)
        level = parameters[-1]
        for index, (log_q, density, fraction, weight) in enumerate(scaled_spectra):
            law = np.exp(parameters[2 * index] - parameters[2 * index + 1] * log_q)
            model = law + level
            total += weight * float(fraction @ (np.log(model) + density / model))
            model_derivative = weight * fraction * (1 - density / model) / model
            gradient[2 * index : 2 * index + 2] = model_derivative @ law, -(model_derivative * law) @ log_q
            gradient[-1] += model_derivative.sum()
        return total, gradient

    initial_parameters: list[float] = []
    bounds: list[tuple[float | None, float | None]] = []
    for log_q, density, fraction, _ in scaled_spectra:
        exponent = float(np.clip(-np.polyfit(log_q, np.log(density), 1, w=np.sqrt(fraction))[0], *exponents))
        initial_parameters += [float(fraction @ (np.log(density) + exponent * log_q)), exponent]
        bounds += [(None, None), exponents]

    def minimize_loss(parameters: Sequence[float], level_bounds: tuple[float, float | None]) -> OptimizeResult:
        # Use TNC, because L-BFGS-B of SciPy 1.17 starts threads that occupy the processor for 0.1 s after each fit.
        return minimize(
            loss, parameters, jac=True, bounds=[*bounds, level_bounds], method="TNC", tol=_FIT_TOLERANCE,
            options={"maxfun": _MAX_FIT_EVALUATIONS},
        )  # fmt: skip

    fit_without_floor = minimize_loss([*initial_parameters, 0.0], (0.0, 0.0))
    fit_with_floor = minimize_loss([*fit_without_floor.x[:-1], _INITIAL_FLOOR_FRACTION], (0.0, None))
    best_fit = fit_with_floor if fit_with_floor.fun < fit_without_floor.fun else fit_without_floor
    *law_parameters, level = best_fit.x.tolist()
    ratios = tuple(level * math.exp(-value) for value in law_parameters[::2])
    return NoiseFloorFit(
        max_floor_level * level, float(fit_without_floor.fun - best_fit.fun), tuple(law_parameters[1::2]), ratios
    )
