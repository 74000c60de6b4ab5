"""Most likely mu0 and range of tau0 where contacts grow under shear, so that tests are not linear in both."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stiction._checks import Floats

NUM_POINTS, NUM_SCANS = 13, 3  # of tau0 in a scan, and scans that narrow the range
NUM_STEPS = 3  # Gauss-Newton steps for the best mu0 at a tau0
STEP = 1e-4  # step of mu0 for its derivative, over 0.1 + mu0

Residuals = Callable[[Floats, Floats], Floats]
"""Residuals (points, tests, ...) over their errors at mu0 and tau0 (GPa), (points, ...); infinite at seizure."""


def best_coefficients(residuals: Residuals, start: Floats, tau0: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the mu0 of at least 0 that fits best at each tau0, by the Gauss-Newton method.

    Parameters
    ----------
    residuals : callable
    start, tau0 : (points, n) array of float, tau0 in GPa

    Returns
    -------
    best : (points, n) array of float
    slope : (points, n) array of float
        Norm of the derivatives of the residuals by mu0; NaN where interfaces seize.
    squares : (points, n) array of float
        Sum of squares of the residuals; infinite where interfaces seize.
    """
    mu0 = start
    for step in range(NUM_STEPS + 1):
        size = STEP * (0.1 + mu0)
        both = residuals(np.stack([mu0, mu0 + size], axis=-1), np.stack([tau0, tau0], axis=-1))
        with np.errstate(invalid="ignore", divide="ignore"):
            derivative = (both[..., 1] - both[..., 0]) / size[:, np.newaxis]
            curvature = (derivative**2).sum(axis=1)
            moved = mu0 - (derivative * both[..., 0]).sum(axis=1) / curvature
        if step < NUM_STEPS:
            mu0 = np.where(np.isfinite(moved), np.maximum(moved, 0.0), mu0 / 2)
    return mu0, np.sqrt(curvature), (both[..., 0] ** 2).sum(axis=1)


def range_of_strength(squares: Callable[[Floats], Floats], highest: Floats, depth: float) -> tuple[Floats, Floats]:
    """Return ends (points,) of tau0 (GPa) between which sums of squares are within a depth of their least value.

    Parameters
    ----------
    squares : callable
        Sums of squares at the best mu0 of tau0, (points, n) each.
    highest : (points,) array of float, GPa
        Upper bound of tau0.
    depth : float
    """
    low, high = np.zeros(highest.shape), highest
    part = np.linspace(0.0, 1.0, NUM_POINTS)
    rows = np.arange(highest.size)
    for _ in range(NUM_SCANS):
        tau0 = low[:, np.newaxis] + np.multiply.outer(high - low, part)
        found = squares(tau0)
        within = found <= found.min(axis=1, keepdims=True) + depth
        first, last = within.argmax(axis=1), NUM_POINTS - 1 - within[:, ::-1].argmax(axis=1)
        low, high = tau0[rows, np.maximum(first - 1, 0)], tau0[rows, np.minimum(last + 1, NUM_POINTS - 1)]
    return low, high
