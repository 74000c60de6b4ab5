"""Maximum-likelihood fit of power laws and a white-noise floor to binned spectra."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stiction._checks import Floats

# A noise floor is significant if it raises the log-likelihood of fitted power laws by more than this number.
MIN_FLOOR_LIKELIHOOD_GAIN = 2.0
_INITIAL_FLOOR_TO_LOWEST_DENSITY_RATIO = 0.3
_RELATIVE_LOSS_TOLERANCE = 1e-13
_MAX_FIT_STEPS = 200
_DAMPING_DECREASE, _DAMPING_INCREASE = 0.1, 10.0
_INITIAL_DAMPING_TO_HESSIAN_RATIO = 1e-3


class BinnedSpectrum(NamedTuple):
    """Spectrum averaged in bins of the wave number, with the statistical weight of each bin."""

    log_q: Floats
    density: Floats
    # Shape parameter of the gamma distribution of the spectral density in each bin.
    weight: Floats
    # Spectral density of white noise that has a noise level of 1.
    floor: float = 1.0


class NoiseFloorFit(NamedTuple):
    """Fit of a power law A q^-s plus white noise to several spectra, with the same noise level in all spectra."""

    level: float
    gain: float
    exponents: tuple[float, ...]
    # Ratio of the fitted noise density to the fitted power law at the largest wave number of each spectrum.
    ratios: tuple[float, ...]

    @property
    def is_significant(self) -> bool:
        """True if adding white noise to the power laws improves the fit significantly."""
        return self.gain > MIN_FLOOR_LIKELIHOOD_GAIN


def fit_noise_floor(spectra: Sequence[BinnedSpectrum], *, exponents: tuple[float, float]) -> NoiseFloorFit:
    """Fit a power law to each spectrum, together with a white-noise level that is common to all spectra.

    `exponents` contains the lower and the upper limit of the exponents.
    """
    max_floor_level = min(float(spectrum.density.min()) / spectrum.floor for spectrum in spectra)
    scaled_spectra = [
        BinnedSpectrum(log_q - log_q.max(), density / (max_floor_level * floor), weight)
        for log_q, density, weight, floor in spectra
    ]
    initial_parameters: list[float] = []
    for log_q, density, weight, _ in scaled_spectra:
        exponent = float(np.clip(-np.polyfit(log_q, np.log(density), 1, w=np.sqrt(weight))[0], *exponents))
        initial_parameters += [float(np.average(np.log(density) + exponent * log_q, weights=weight)), exponent]
    lower_bounds, upper_bounds = (
        np.array([*(infinity, exponent) * len(spectra), 0.0])
        for infinity, exponent in zip((-math.inf, math.inf), exponents, strict=True)
    )
    parameters_without_floor, loss_without_floor = _minimize_loss(
        scaled_spectra, [*initial_parameters, 0.0], lower_bounds, upper_bounds
    )
    upper_bounds[-1] = math.inf
    parameters_with_floor, loss_with_floor = _minimize_loss(
        scaled_spectra,
        [*parameters_without_floor[:-1], _INITIAL_FLOOR_TO_LOWEST_DENSITY_RATIO],
        lower_bounds,
        upper_bounds,
    )
    has_floor = loss_with_floor < loss_without_floor
    *power_law_parameters, level = (parameters_with_floor if has_floor else parameters_without_floor).tolist()
    ratios = tuple(level * math.exp(-log_prefactor) for log_prefactor in power_law_parameters[::2])
    return NoiseFloorFit(
        max_floor_level * level,
        max(loss_without_floor - loss_with_floor, 0.0),
        tuple(power_law_parameters[1::2]),
        ratios,
    )


def _minimize_loss(
    spectra: Sequence[BinnedSpectrum], initial_parameters: Sequence[float], lower_bounds: Floats, upper_bounds: Floats
) -> tuple[Floats, float]:
    """Minimise the loss (negative log-likelihood) of the fit within bounds, by damped Newton steps.

    Returns parameters and loss.

    `scipy.optimize` has such methods, but its import takes longer than the fits of all scans of a pair.
    """
    parameters, damping = np.array(initial_parameters), _INITIAL_DAMPING_TO_HESSIAN_RATIO
    loss, gradient, hessian, damping_scale = _compute_loss(spectra, parameters)
    for _ in range(_MAX_FIT_STEPS):
        is_free = (
            ((parameters > lower_bounds) | (gradient < 0))
            & ((parameters < upper_bounds) | (gradient > 0))
            & (lower_bounds < upper_bounds)
        )
        free_indices = np.flatnonzero(is_free)
        if not free_indices.size:
            break
        damped_hessian = hessian[np.ix_(free_indices, free_indices)] + np.diag(damping * damping_scale[free_indices])
        trial_parameters, trial_loss = parameters.copy(), math.inf
        eigenvalues, eigenvectors = np.linalg.eigh(damped_hessian)
        if eigenvalues[0] > 0:
            trial_parameters[free_indices] -= eigenvectors @ (eigenvectors.T @ gradient[free_indices] / eigenvalues)
            trial_parameters = np.clip(trial_parameters, lower_bounds, upper_bounds)
            with np.errstate(over="ignore", invalid="ignore"):
                trial_loss, *derivatives = _compute_loss(spectra, trial_parameters)
        if not trial_loss < loss:
            damping *= _DAMPING_INCREASE
            if damping > 1 / _RELATIVE_LOSS_TOLERANCE:
                break
            continue
        is_converged = loss - trial_loss <= _RELATIVE_LOSS_TOLERANCE * abs(loss)
        parameters, loss, (gradient, hessian, damping_scale) = trial_parameters, trial_loss, derivatives
        damping *= _DAMPING_DECREASE
        if is_converged:
            break
    return parameters, loss


def _compute_loss(spectra: Sequence[BinnedSpectrum], parameters: Floats) -> tuple[float, Floats, Floats, Floats]:
    """Return a fit's negative log-likelihood, its gradient, its Hessian, and the diagonal of the expected Hessian.

    The diagonal of the expected Hessian is positive. The log-likelihood has an arbitrary constant.
    """
    loss, size = 0.0, parameters.size
    gradient, hessian, damping_scale = np.zeros(size), np.zeros((size, size)), np.zeros(size)
    for index, (log_q, density, weight, _) in enumerate(spectra):
        power_law = np.exp(parameters[2 * index] - parameters[2 * index + 1] * log_q)
        model = power_law + parameters[-1]
        loss += float(weight @ (np.log(model) + density / model))
        parameter_indices = [2 * index, 2 * index + 1, size - 1]
        # Derivatives of the model A q^-s + noise level with respect to ln(A), to s and to the noise level.
        derivatives = np.stack([power_law, -power_law * log_q, np.ones(power_law.size)])
        loss_derivative = weight * (1 - density / model) / model
        loss_curvature = weight * (2 * density / model - 1) / np.square(model)
        gradient[parameter_indices] += derivatives @ loss_derivative
        hessian_block = (derivatives * loss_curvature) @ derivatives.T
        hessian_block[:2, :2] += np.array([[1, -1], [-1, 1]]) * np.array(
            [
                [loss_derivative @ power_law, loss_derivative @ (power_law * log_q)],
                [loss_derivative @ (power_law * log_q), loss_derivative @ (power_law * np.square(log_q))],
            ]
        )
        hessian[np.ix_(parameter_indices, parameter_indices)] += hessian_block
        damping_scale[parameter_indices] += np.square(derivatives) @ (weight / np.square(model))
    return loss, gradient, hessian, damping_scale
