"""95 % intervals of means: over independent repetitions at a load, and over the positions of a traverse.

What they cover, and how wide they are beside the best that is possible, is measured by docs/scripts/intervals.py.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.studies.crossing import Crossing

CONFIDENCE = 0.95

# ---- Over repetitions ------------------------------------------------------------------------------------------------

AROUND = 4
"""Steps on both sides of a crossing over which the slope of a mean is taken: those of single steps are noise."""


def of_ratio_at_load(normal: Floats, values: Floats, crossing: Crossing, loads: Floats) -> tuple[Floats, Floats]:
    """Interval (l,), (l,) of the mean of values (r, k), read off where the mean of normal loads (r, k) reaches loads.

    A jackknife over the repetitions. With v and n the values and normal loads of each at the crossing, and e the
    exponent of the mean curve there, mean(v) ~ mean(n)^e, a repetition that is left out moves the logarithm of the mean
    by that of mean(v) less e times that of mean(n): what it does at the load, at a crossing that itself stays.
    The scale is the logarithm, natural for a ratio of positive means, and Student's t has the degrees of freedom
    that the kurtosis of the jackknife values leaves (Satterthwaite). Where the mean or what others leave of it is not
    positive, the same to first order, symmetric, but not below zero if no value is.

    Few repetitions that carry load make an interval too narrow: 5 lognormal ones cover 81 to 94 % of the time, 24 and
    more 89 to 95 %. It is NaN where fewer than two carry any, or all of the load is carried by one. Where mean(F_N)
    falls again behind a crossing, as it does at D >= 1.6, another sample may find another crossing first; the interval
    does not know.
    """
    repetitions = normal.shape[0]
    lower, upper = np.full(loads.shape, np.nan), np.full(loads.shape, np.nan)
    if np.count_nonzero(normal.any(axis=1)) < 2:
        return lower, upper
    reached = crossing.reached[0]
    there = Crossing(*(part[:, reached] for part in vars(crossing).values()))
    own_load, own_value = there.at(normal), there.at(values)  # (r, l)
    load, mean = loads[reached], own_value.mean(axis=0)
    slope = _slopes(values.mean(axis=0), normal.mean(axis=0), there.index[0])

    def without(each: Floats) -> Floats:
        return np.asarray((each.sum(axis=0) - each) / (repetitions - 1))

    others_load = without(own_load) / load
    with np.errstate(divide="ignore", invalid="ignore"):
        logarithms = np.log(without(own_value) / mean) - slope * load / mean * np.log(others_load)
        half_width = half_width_of(logarithms)
        ends = mean * np.exp(-half_width), mean * np.exp(half_width)
    plain = ~np.isfinite(logarithms).all(axis=0)
    half_width = half_width_of(without(own_value - slope * own_load))
    least = -np.inf if (values < 0).any() else 0.0
    alone = (others_load <= 0).any(axis=0)
    lower[reached] = np.where(alone, np.nan, np.where(plain, np.maximum(mean - half_width, least), ends[0]))
    upper[reached] = np.where(alone, np.nan, np.where(plain, mean + half_width, ends[1]))
    return lower, upper


def _slopes(values: Floats, normal: Floats, index: NDArray[np.intp]) -> Floats:
    """(l,): least-squares slope of mean values (k,) against mean normal loads (k,) over the steps around an index."""
    first = np.maximum(index - 1 - AROUND, 0)[:, np.newaxis]
    last = np.minimum(index + AROUND, normal.size - 1)[:, np.newaxis]
    steps = first + np.arange(2 * AROUND + 2)
    inside = steps <= last
    steps = np.minimum(steps, last)
    count = inside.sum(axis=1, keepdims=True)
    x, y = (np.where(inside, each[steps], 0.0) for each in (normal, values))
    x, y = (np.where(inside, each - each.sum(axis=1, keepdims=True) / count, 0.0) for each in (x, y))
    squares = (x * x).sum(axis=1)
    return np.asarray(np.divide((x * y).sum(axis=1), squares, out=np.zeros_like(squares), where=squares > 0))


def half_width_of(left_out: Floats) -> Floats:
    """Half the interval of a mean from its leave-one-out values (r, l)."""
    from scipy.special import stdtrit

    repetitions = left_out.shape[0]
    powers = np.square(left_out - left_out.mean(axis=0))
    squares = powers.sum(axis=0)
    kurtosis = repetitions * np.divide(
        np.square(powers).sum(axis=0), squares**2, out=np.full_like(squares, 3.0 / repetitions), where=squares > 0
    )
    freedom = np.clip(2 * repetitions / np.maximum(kurtosis - 1, 1e-9), 1, max(repetitions - 1, 1))
    error = np.sqrt((repetitions - 1) / repetitions * squares)
    return np.asarray(stdtrit(freedom, 0.5 + CONFIDENCE / 2) * error)


# ---- Over a sample ---------------------------------------------------------------------------------------------------


FEWEST_OF_SAMPLE = 3


def of_sample(values: Floats) -> tuple[Floats, Floats, Floats]:
    """Mean of values (r, ...) over the first axis, without NaN, and its interval by Student's t.

    The interval is NaN for fewer than `FEWEST_OF_SAMPLE` values, and not below 0 where no value is.
    """
    from scipy.special import stdtrit

    known = np.isfinite(values)
    count = known.sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where(known, values, 0.0).sum(axis=0) / count
        squares = np.where(known, np.square(values - mean), 0.0).sum(axis=0)
        error = np.sqrt(squares / (count - 1) / count)
    enough = count >= FEWEST_OF_SAMPLE
    half_width = np.where(enough, stdtrit(np.maximum(count - 1, 1), 0.5 + CONFIDENCE / 2) * error, np.nan)
    least = np.where((np.where(known, values, 0.0) < 0).any(axis=0), -np.inf, 0.0)
    return np.asarray(mean), np.asarray(np.maximum(mean - half_width, least)), np.asarray(mean + half_width)


# ---- Over neighbours -------------------------------------------------------------------------------------------------

FEWEST_NEIGHBOURS = 8
"""Fewer cannot tell their mean from their correlation: even independent ones would have an interval as wide as they."""

_CORRELATIONS = np.linspace(0.0, 0.95, 20)

_BISECTIONS = 50


def of_neighbours(values: Floats) -> tuple[float, float, float]:
    """Mean of values (r,) in the order in which they are neighbours, and its interval.

    Neighbours of correlation ρ are taken for an autoregressive process, of which the mean has a Student's t of r - 1
    degrees of freedom about the sample's. A few values do not tell their ρ, so the interval is that of the mixture over
    all ρ from 0 to 0.95, each weighted by the likelihood that the values give it and by sqrt(1 - ρ), for positions
    are laid apart where one can choose. It is symmetric on the scale u of value = (exp(g u) - 1)/g on which the
    skewness 3 g of the values vanishes to first order, and it does not go beyond the values.

    NaN for fewer than `FEWEST_NEIGHBOURS` values, and where all are equal, because their spread is then not known.
    """
    from scipy.special import stdtr, stdtrit

    count = values.size
    mean = float(values.mean()) if count else math.nan
    if count < FEWEST_NEIGHBOURS or (values == values[0]).all():
        return mean, math.nan, math.nan
    # In units of their spread, so that no scale overflows.
    deviations = values - mean
    spread = float(np.sqrt(deviations @ deviations / (count - 1)))
    if not spread > 0:
        return mean, math.nan, math.nan
    y, rho = deviations / spread, _CORRELATIONS
    # Of the autoregressive process in closed form: 1' R^-1 1, the weighted mean, and the weighted sum of squares.
    ones = (count - (count - 2) * rho) / (1 + rho)
    centre = (y[0] + y[-1] + (1 - rho) * y[1:-1].sum()) / (1 + rho) / ones
    about = y - centre[:, np.newaxis]
    innovations = about[:, 1:] - rho[:, np.newaxis] * about[:, :-1]
    squares = about[:, 0] ** 2 + np.square(innovations).sum(axis=1) / (1 - rho**2)
    weights = (count - 1) * (np.log(1 - rho**2) + np.log(squares)) + np.log(ones) - np.log(1 - rho)
    weights = np.exp(-0.5 * (weights - weights.min()))
    weights /= weights.sum()
    lags = np.arange(1, count)
    inflation = (count + 2 * ((count - lags) * rho[:, np.newaxis] ** lags).sum(axis=1)) / count**2
    errors = np.sqrt(squares / (count - 1) * inflation)

    low, high = 0.0, float(stdtrit(count - 1, 0.5 + CONFIDENCE / 2) * errors.max())
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        enough = float(weights @ stdtr(count - 1, middle / errors)) >= 0.5 + CONFIDENCE / 2
        low, high = (low, middle) if enough else (middle, high)
    bend = float((y**3).mean() / (y**2).mean() ** 1.5) / 3
    below = above = high
    if abs(bend) > _STRAIGHT:
        below, above = -math.expm1(-bend * high) / bend, math.expm1(bend * high) / bend
    return mean, max(mean - spread * below, float(values.min())), min(mean + spread * above, float(values.max()))


_STRAIGHT = 1e-9
"""Skewness below which a scale is straight to round-off."""
