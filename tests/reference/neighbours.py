"""Synthetic values at correlated positions, and the coverage of intervals for them."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr

DISTRIBUTION_NAMES = ("normal", "half zeros", "bounded", "lognormal 0.5", "lognormal 1")


def traverses(quantity, trials, positions, correlation, random):
    """Return values (trials, positions) of a quantity with correlated neighbours."""
    if quantity == "half zeros":
        # A chain with values of 0 or about 0.35, like the coefficient of one contact, with equally long states.
        stays = random.random((trials, positions)) < (1 + correlation) / 2
        stays[:, 0] = random.random(trials) < 0.5
        touching = (~stays).cumsum(axis=1) % 2 == 1
        return np.where(touching, 0.35 * np.exp(0.1 * random.standard_normal((trials, positions))), 0.0)
    if quantity.startswith("lognormal"):
        spread = float(quantity.split()[1])
        own = np.log1p(correlation * np.expm1(spread**2)) / spread**2  # of the logarithms
        return np.exp(spread * _neighbours(trials, positions, own, random))
    values = _neighbours(trials, positions, correlation, random)
    return ndtr(values) if quantity == "bounded" else 10 + values


def _neighbours(trials, positions, correlation, random):
    values = random.standard_normal((trials, positions))
    for i in range(1, positions):
        values[:, i] = correlation * values[:, i - 1] + np.sqrt(1 - correlation**2) * values[:, i]
    return values


def of_quantity(quantity, positions, correlation, random, trials=20000):
    """Return the true mean, and the width of the interval if the variance of the mean were known."""
    means = np.concatenate(
        [traverses(quantity, trials // 10, positions, correlation, random).mean(axis=1) for _ in range(10)]
    )
    return means.mean(), 2 * 1.96 * means.std()


def judged(interval, values, truth, best):
    """Return coverage, width over the best width, and the fraction of defined intervals (trials, positions)."""
    ends = np.array([interval(value)[1:] for value in values])
    ends = ends[np.isfinite(ends).all(axis=1)]
    covered = (ends[:, 0] <= truth) & (truth <= ends[:, 1])
    return covered.mean(), np.median(ends[:, 1] - ends[:, 0]) / best, len(ends) / len(values)
