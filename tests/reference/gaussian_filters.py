"""Reference for Gaussian regression filters (ISO 16610): a weighted least-squares fit at each point, in loops."""

import math

import numpy as np

GAUSSIAN_FILTER_ALPHA = math.sqrt(math.log(2) / math.pi)


def gaussian_weight(distance, cutoff):
    return math.exp(-math.pi * (distance / (GAUSSIAN_FILTER_ALPHA * cutoff)) ** 2)


def mean_line(heights, spacing, cutoff, *, degree=1, weights=None):
    """Return the mean line: at each point, the constant term of a polynomial fitted with Gaussian weights."""
    points = len(heights)
    weights = [1.0] * points if weights is None else weights
    smoothed = []
    for i in range(points):
        normal_matrix, right_hand_side = np.zeros((degree + 1, degree + 1)), np.zeros(degree + 1)
        for j in range(points):
            offset = (j - i) * spacing
            weight = weights[j] * gaussian_weight(offset, cutoff)
            powers = [(offset / cutoff) ** k for k in range(degree + 1)]
            for k in range(degree + 1):
                right_hand_side[k] += weight * heights[j] * powers[k]
                for m in range(degree + 1):
                    normal_matrix[k, m] += weight * powers[k] * powers[m]
        smoothed.append(np.linalg.solve(normal_matrix, right_hand_side)[0])
    return np.array(smoothed)


def mean_surface(heights, spacing, cutoff, terms, weights=None):
    """Return the mean surface: at each point, the constant term of a polynomial fitted with Gaussian weights.

    `terms` lists the powers (of y, of x) of the polynomial.
    """
    rows, columns = heights.shape
    weights = np.ones(heights.shape) if weights is None else weights
    y, x = spacing[0] * np.arange(rows)[:, np.newaxis], spacing[1] * np.arange(columns)
    smoothed = np.empty(heights.shape)
    for j in range(rows):
        for i in range(columns):
            v, u = (y - y[j]) / cutoff, (x - x[i]) / cutoff
            weight_roots = np.sqrt(weights * np.exp(-math.pi * (u**2 + v**2) / GAUSSIAN_FILTER_ALPHA**2)).ravel()
            design = np.stack([(v**a * u**b).ravel() for a, b in terms], axis=1)
            smoothed[j, i] = np.linalg.lstsq(
                design * weight_roots[:, np.newaxis], heights.ravel() * weight_roots, rcond=None
            )[0][0]
    return smoothed


def robust_mean_line(heights, spacing, cutoff, iterations=60):
    """Return the robust mean line: second-degree fits, repeated with Tukey's biweights of the residuals."""
    weights = [1.0] * len(heights)
    for _ in range(iterations):
        smoothed = mean_line(heights, spacing, cutoff, degree=2, weights=weights)
        residuals = [abs(z - w) for z, w in zip(heights, smoothed, strict=True)]
        scale = 4.4478 * float(np.median(residuals))
        weights = [(1 - (r / scale) ** 2) ** 2 if r < scale else 0.0 for r in residuals]
    return smoothed
