"""Simulate values at correlated positions, and measure the coverage of intervals of their mean."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr

DISTRIBUTION_NAMES = ("normal", "half zeros", "bounded", "lognormal 0.5", "lognormal 1")


def simulate_correlated_positions(distribution, num_trials, positions, correlation, random):
    """Return simulated values as an array (trials, positions), in which neighbouring positions are correlated."""
    if distribution == "half zeros":
        # Markov chain of two equally frequent states: no contact (0), and contact (about 0.35).
        is_unchanged = random.random((num_trials, positions)) < (1 + correlation) / 2
        is_unchanged[:, 0] = random.random(num_trials) < 0.5
        in_contact = (~is_unchanged).cumsum(axis=1) % 2 == 1
        return np.where(in_contact, 0.35 * np.exp(0.1 * random.standard_normal((num_trials, positions))), 0.0)
    if distribution.startswith("lognormal"):
        log_deviation = float(distribution.split()[1])
        log_correlation = np.log1p(correlation * np.expm1(log_deviation**2)) / log_deviation**2
        return np.exp(log_deviation * _simulate_normal_positions(num_trials, positions, log_correlation, random))
    values = _simulate_normal_positions(num_trials, positions, correlation, random)
    return ndtr(values) if distribution == "bounded" else 10 + values


def _simulate_normal_positions(num_trials, positions, correlation, random):
    values = random.standard_normal((num_trials, positions))
    for i in range(1, positions):
        values[:, i] = correlation * values[:, i - 1] + np.sqrt(1 - correlation**2) * values[:, i]
    return values


def estimate_true_mean(distribution, positions, correlation, random, num_trials=20000):
    """Return the true mean, and the width of its 95 % interval for a known variance of the mean."""
    means = np.concatenate(
        [
            simulate_correlated_positions(distribution, num_trials // 10, positions, correlation, random).mean(axis=1)
            for _ in range(10)
        ]
    )
    return means.mean(), 2 * 1.96 * means.std()


def coverage_and_width(interval, values, true_mean, best_width):
    """Return the coverage of intervals, their median width divided by `best_width`, and the fraction with an interval.

    `values` has the shape (trials, positions).
    """
    ends = np.array([interval(value)[1:] for value in values])
    ends = ends[np.isfinite(ends).all(axis=1)]
    is_covered = (ends[:, 0] <= true_mean) & (true_mean <= ends[:, 1])
    return is_covered.mean(), np.median(ends[:, 1] - ends[:, 0]) / best_width, len(ends) / len(values)
