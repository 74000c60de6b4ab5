"""Reference for Gaussian regression filters (ISO 16610): a weighted least-squares fit at each point."""

import math

import numpy as np

GAUSSIAN_FILTER_ALPHA = math.sqrt(math.log(2) / math.pi)


def mean_line(heights, spacing, cutoff, *, degree=1, weights=None):
    """Return the mean line: at each point, the constant term of a polynomial fitted with Gaussian weights."""
    heights = np.asarray(heights)
    weights = np.ones(len(heights)) if weights is None else np.asarray(weights)
    x = spacing * np.arange(len(heights))
    smoothed_heights = []
    for position in x:
        offsets = (x - position) / cutoff
        weights_at_point = weights * np.exp(-math.pi * (offsets / GAUSSIAN_FILTER_ALPHA) ** 2)
        powers = np.vander(offsets, degree + 1, increasing=True)
        weighted_powers = powers.T * weights_at_point
        smoothed_heights.append(np.linalg.solve(weighted_powers @ powers, weighted_powers @ heights)[0])
    return np.array(smoothed_heights)


def mean_surface(heights, spacing, cutoff, terms, weights=None):
    """Return the mean surface: at each point, the constant term of a polynomial fitted with Gaussian weights.

    `terms` lists the powers (of y, of x) of the polynomial.
    """
    rows, columns = heights.shape
    weights = np.ones(heights.shape) if weights is None else weights
    y, x = spacing[0] * np.arange(rows)[:, np.newaxis], spacing[1] * np.arange(columns)
    smoothed_heights = np.empty(heights.shape)
    for j in range(rows):
        for i in range(columns):
            v, u = (y - y[j]) / cutoff, (x - x[i]) / cutoff
            weight_roots = np.sqrt(weights * np.exp(-math.pi * (u**2 + v**2) / GAUSSIAN_FILTER_ALPHA**2)).ravel()
            design_matrix = np.stack([(v**a * u**b).ravel() for a, b in terms], axis=1)
            smoothed_heights[j, i] = np.linalg.lstsq(
                design_matrix * weight_roots[:, np.newaxis], heights.ravel() * weight_roots, rcond=None
            )[0][0]
    return smoothed_heights


def robust_mean_line(heights, spacing, cutoff, iterations=60):
    """Return the robust mean line: second-degree fits, repeated with Tukey's biweights of the residuals."""
    weights = [1.0] * len(heights)
    for _ in range(iterations):
        smoothed_heights = mean_line(heights, spacing, cutoff, degree=2, weights=weights)
        residuals = [abs(z - w) for z, w in zip(heights, smoothed_heights, strict=True)]
        scale = 4.4478 * float(np.median(residuals))
        weights = [(1 - (r / scale) ** 2) ** 2 if r < scale else 0.0 for r in residuals]
    return smoothed_heights
