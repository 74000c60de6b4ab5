"""Fit of mu0 and tau0 to friction tests with junction growth (shear enlarges the contacts)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stiction._checks import Floats

# The best tau0 is found on a sequence of ever narrower grids: number of tau0 values per grid, and number of grids.
NUM_TAU0_SEARCH_POINTS, NUM_TAU0_SEARCHES = 13, 3
NUM_NEWTON_STEPS = 3
MU0_DERIVATIVE_STEP = 1e-4  # divided by 0.1 + mu0

ResidualFunction = Callable[[Floats, Floats], Floats]
"""Function of mu0 and tau0 in GPa (points, ...) that returns residuals in units of the errors (points, tests, ...).

Residuals are infinite at seizure.
"""


def find_best_mu0(residuals: ResidualFunction, start: Floats, tau0: Floats) -> tuple[Floats, Floats, Floats]:
    """Find the nonnegative mu0 that best fits the friction tests at each given tau0, by the Gauss-Newton method.

    Parameters
    ----------
    residuals : callable
    start, tau0 : (points, n) array of float, tau0 in GPa

    Returns
    -------
    best : (points, n) array of float
    slope : (points, n) array of float
        Norm of the derivatives of the residuals with respect to mu0; NaN at seizure.
    squares : (points, n) array of float
        Sum of squares of the residuals; infinite at seizure.
    """
    mu0 = start
    for iteration in range(NUM_NEWTON_STEPS + 1):
        mu0_step = MU0_DERIVATIVE_STEP * (0.1 + mu0)
        residual_pairs = residuals(np.stack([mu0, mu0 + mu0_step], axis=-1), np.stack([tau0, tau0], axis=-1))
        with np.errstate(invalid="ignore", divide="ignore"):
            derivative = (residual_pairs[..., 1] - residual_pairs[..., 0]) / mu0_step[:, np.newaxis]
            curvature = (derivative**2).sum(axis=1)
            new_mu0 = mu0 - (derivative * residual_pairs[..., 0]).sum(axis=1) / curvature
        if iteration < NUM_NEWTON_STEPS:
            mu0 = np.where(np.isfinite(new_mu0), np.maximum(new_mu0, 0.0), mu0 / 2)
    return mu0, np.sqrt(curvature), (residual_pairs[..., 0] ** 2).sum(axis=1)


def find_tau0_range(
    sum_of_squares: Callable[[Floats], Floats], max_tau0: Floats, deviance_range: float
) -> tuple[Floats, Floats]:
    """Return the lower and upper tau0 (GPa) where the sum of squared residuals is `deviance_range` above its minimum.

    Parameters
    ----------
    sum_of_squares : callable
        Function from tau0 (points, n) to the sums of squares (points, n) at the best mu0.
    max_tau0 : (points,) array of float, GPa
        Upper bound on tau0.
    deviance_range : float
    """
    lower_limit, upper_limit = np.zeros(max_tau0.shape), max_tau0
    fractions = np.linspace(0.0, 1.0, NUM_TAU0_SEARCH_POINTS)
    row_indices = np.arange(max_tau0.size)
    for _ in range(NUM_TAU0_SEARCHES):
        tau0 = lower_limit[:, np.newaxis] + np.multiply.outer(upper_limit - lower_limit, fractions)
        deviances = sum_of_squares(tau0)
        is_within = deviances <= deviances.min(axis=1, keepdims=True) + deviance_range
        first_inside = is_within.argmax(axis=1)
        last_inside = NUM_TAU0_SEARCH_POINTS - 1 - is_within[:, ::-1].argmax(axis=1)
        lower_limit, upper_limit = (
            tau0[row_indices, np.maximum(first_inside - 1, 0)],
            tau0[row_indices, np.minimum(last_inside + 1, NUM_TAU0_SEARCH_POINTS - 1)],
        )
    return lower_limit, upper_limit
