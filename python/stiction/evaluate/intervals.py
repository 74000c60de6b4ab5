"""Intervals (95 %) of means over independent repetitions, or over neighbouring positions.

The script docs/scripts/intervals.py measures the coverage of the intervals, and their width relative to the best
possible interval.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiction._core as _core
from stiction._checks import Floats

CONFIDENCE_LEVEL = 0.95
INTERVAL_STATISTICS = ["mean", "lower", "upper"]
NUM_LOAD_STEPS_PER_SIDE_OF_SLOPE_FIT = 4
MAX_INTERPOLATED_LOAD_RATIO = 10.01
"""Largest ratio of two successive computed loads that allows interpolation between them."""
MAX_VALUES_PER_BATCH = 2**17
MIN_SAMPLE_SIZE = 3
MIN_NEIGHBOURING_POSITIONS = 8
MIN_SIGN_PRESERVING_CHANGE = -1 + 1e-12
"""Relative change of a mean on leaving out one repetition, above which the mean certainly keeps its sign.

The change is -1 if all other repetitions are zero. The distance from -1 exceeds the round-off.
"""
MAX_RELATIVE_ROUND_OFF = 1e-12
"""Largest half width of a symmetric interval that counts as round-off, as a fraction of |mean| + |slope| · load.

Friction up to this fraction of the load or of the pull-off force counts as round-off, too.
"""
_TRIAL_NEIGHBOUR_CORRELATIONS = np.linspace(0.0, 0.95, 20)
_MAX_NEWTON_STEPS = 50
_MAX_SYMMETRIC_SKEWNESS = 1e-9
# Student's t distribution with this number of degrees of freedom is practically normal.
MAX_DEGREES_OF_FREEDOM = 1e6


def student_quantile(freedom: ArrayLike) -> Floats:
    """Return the quantile of Student's t distribution for a two-sided 95 % interval."""
    from scipy.special import stdtrit

    return np.asarray(stdtrit(freedom, 0.5 + CONFIDENCE_LEVEL / 2))


@dataclass(frozen=True)
class LoadCrossings:
    """Points where load curves first reach the requested loads: loading step, and position between two steps.

    A crossing lies between the steps index - 1 and index, at a fraction of the distance between them.
    """

    # Index of the first loading step whose load is at or above each requested load; shape (..., loads).
    index: NDArray[np.intp]
    # Position of each load between two loading steps, from 0 to 1; shape (..., loads).
    fraction: Floats
    reached: NDArray[np.bool_]
    below: NDArray[np.bool_]
    # Loads of the curves, and requested loads; None unless the ratio of a quantity to the load is interpolated.
    scale: tuple[Floats, Floats] | None = None

    @classmethod
    def from_curves(cls, curve: Floats, loads: Floats, *, interpolates_ratio: bool = False) -> LoadCrossings:
        """Find the first crossing of each load curve with each requested load, as a position between two loading steps.

        The curves have the shape (..., k), and the loads have the shape (l,). With `interpolates_ratio`, the ratio of a
        quantity to the load is interpolated over the logarithm of the load. A load between two steps is then reached
        only if the ratio of the loads at these steps is at most `MAX_INTERPOLATED_LOAD_RATIO`.
        """
        if interpolates_ratio:
            with np.errstate(divide="ignore", invalid="ignore"):
                log_crossings = cls.from_curves(np.log(curve), np.log(loads))
                below, above = log_crossings._get_bracketing_values(curve)
                is_close = ~(above > MAX_INTERPOLATED_LOAD_RATIO * below) | (above == loads)
            return cls(
                log_crossings.index,
                log_crossings.fraction,
                log_crossings.reached & is_close,
                log_crossings.below,
                (curve, loads),
            )
        is_at_least_load = curve[..., np.newaxis] >= loads
        starts_at_load = curve[..., :1, np.newaxis] == loads
        is_crossing = np.concatenate(
            [starts_at_load, ~is_at_least_load[..., :-1, :] & is_at_least_load[..., 1:, :]], axis=-2
        )
        reached: NDArray[np.bool_] = np.any(is_crossing, axis=-2)
        index = is_crossing.argmax(axis=-2)
        value_before = np.take_along_axis(curve, np.maximum(index - 1, 0), axis=-1)
        step_difference = np.take_along_axis(curve, index, axis=-1) - value_before
        fraction = np.divide(
            loads - value_before, step_difference, out=np.ones_like(value_before), where=step_difference > 0
        )
        return cls(index, fraction, reached, ~reached & is_at_least_load[..., 0, :])

    def without_crossings_after_nan(self, curve: Floats, loads: Floats) -> LoadCrossings:
        """Return a copy without load crossings right after a NaN in `curve`, except where `curve` equals the load."""
        value_before, value_at_crossing = self._get_bracketing_values(curve)
        return replace(self, reached=self.reached & (np.isfinite(value_before) | (value_at_crossing == loads)))

    def _get_bracketing_values(self, curve: Floats) -> tuple[Floats, Floats]:
        """Return the values of a curve at the two loading steps that enclose each crossing."""
        values_before, values_after = (
            np.take_along_axis(curve, index, axis=-1) for index in (np.maximum(self.index - 1, 0), self.index)
        )
        return values_before, values_after

    def interpolate(self, values: Floats, *, are_sums: bool = True) -> Floats:
        """Interpolate a quantity at the requested loads.

        The quantity is NaN at loads that the curve does not reach.

        The values have the shape (..., more, k), and the result has the shape (..., more, l).
        With `are_sums`, the ratio of value to load is interpolated if the crossings were found with
        `interpolates_ratio`.
        """
        num_dims = self.index.ndim - 1
        broadcast_shape = (*self.index.shape[:-1], *(1,) * (values.ndim - 1 - num_dims), -1)
        index, fraction, reached = (
            array.reshape(broadcast_shape) for array in (self.index, self.fraction, self.reached)
        )
        if are_sums and self.scale is not None:
            with np.errstate(divide="ignore", invalid="ignore"):
                values = values / self.scale[0].reshape(broadcast_shape)
        shape = np.broadcast_shapes(values.shape[:-1], index.shape[:-1])
        index = np.broadcast_to(index, (*shape, index.shape[-1]))
        values = np.broadcast_to(values, (*shape, values.shape[-1]))
        values_after = np.take_along_axis(values, index, axis=-1)
        values_before = np.take_along_axis(values, np.maximum(index - 1, 0), axis=-1)
        # No warning is needed for NaN at the step before a load, nor for the infinite stiffness at complete contact.
        with np.errstate(invalid="ignore"):
            interpolated = np.where(
                fraction == 1, values_after, values_before + fraction * (values_after - values_before)
            )
        if are_sums and self.scale is not None:
            interpolated = interpolated * self.scale[1]
        return np.where(reached, interpolated, np.nan)

    @property
    def loads(self) -> Floats:
        """Requested loads (mN), available only if the crossings were found with `interpolates_ratio`."""
        assert self.scale is not None, "the crossings were found with interpolates_ratio"
        return self.scale[1]

    def interpolate_with_slopes(self, values: Floats, slopes: Floats) -> tuple[Floats, Floats]:
        """Interpolate an increasing quantity and its derivative by ln(load) at the requested loads, using cubics.

        The arrays have the shape (..., k), and the results have the shape (..., l). The crossings must have been found
        with `interpolates_ratio`. Between two loading steps, slopes are limited so that the cubic increases (Fritsch &
        Carlson 1980). If the slope at one of these steps is unknown, the quantity is interpolated with the slope of the
        chord instead, and the derivative is NaN.
        """
        assert self.scale is not None, "the crossings were found with interpolates_ratio"
        curve = self.scale[0]
        below, above = self._get_bracketing_values(curve)
        value_before, value_after = self._get_bracketing_values(values)
        slope_before, slope_after = self._get_bracketing_values(slopes)
        t = self.fraction
        with np.errstate(divide="ignore", invalid="ignore"):
            log_ratio = np.log(above / below)
            chord = (value_after - value_before) / log_ratio
            limited_before, limited_after = (
                np.clip(np.where(np.isfinite(slope), slope, chord), 0.0, 3 * np.maximum(chord, 0.0))
                for slope in (slope_before, slope_after)
            )
            curvature_term = (1 - t) * (limited_before - chord) - t * (limited_after - chord)
            value = value_before + t * (value_after - value_before) + t * (1 - t) * log_ratio * curvature_term
            slope = chord + (1 - t) * (1 - 3 * t) * (limited_before - chord) - t * (2 - 3 * t) * (limited_after - chord)
            slope = np.where(np.isfinite(slope_before) & np.isfinite(slope_after), slope, np.nan)
        is_at_step = t == 1
        return (
            np.where(self.reached, np.where(is_at_step, value_after, value), np.nan),
            np.where(self.reached, np.where(is_at_step, slope_after, slope), np.nan),
        )

    def interpolate_smoothly(self, values: Floats) -> Floats:
        """Interpolate a quantity at the requested loads with monotonic cubics in ln(load).

        The slope at a step is the weighted harmonic mean of the slopes of the adjacent chords (Fritsch & Butland 1984),
        and at the first and last step the slope of the parabola through three steps. The crossings must have been found
        with `interpolates_ratio`.
        """
        assert self.scale is not None, "the crossings were found with interpolates_ratio"
        slopes = np.full(values.shape, np.nan)
        with np.errstate(divide="ignore", invalid="ignore"):
            log_step_lengths = np.diff(np.log(self.scale[0]))
            (length_before, length_after), chords = (
                (log_step_lengths[..., :-1], log_step_lengths[..., 1:]),
                np.diff(values) / log_step_lengths,
            )
            harmonic_mean = (
                3 * (length_before + length_after)
                / (
                    (length_before + 2 * length_after) / chords[..., :-1]
                    + (2 * length_before + length_after) / chords[..., 1:]
                )
            )  # fmt: skip
            has_one_sign = chords[..., :-1] * chords[..., 1:] > 0
            slopes[..., 1:-1] = np.where(has_one_sign, harmonic_mean, np.where(np.isnan(harmonic_mean), np.nan, 0.0))
            for end, near, far in ((0, 0, 1), (-1, -1, -2)) if chords.shape[-1] > 1 else ():
                fraction = log_step_lengths[..., near] / (log_step_lengths[..., near] + log_step_lengths[..., far])
                slopes[..., end] = (1 + fraction) * chords[..., near] - fraction * chords[..., far]
        return self.interpolate_with_slopes(values, slopes)[0]

    def min_at_bracketing_steps(self, values: Floats) -> Floats:
        """Return the smaller of the two values of a quantity at the steps before and after each crossing."""
        return np.minimum(*self._get_bracketing_values(values))

    def slope(self, values: Floats, reference_values: Floats) -> Floats:
        """Return the slope of one quantity against another, between the loading steps around each requested load."""
        index = np.maximum(self.index, 1)
        value_change, reference_change = (
            np.take_along_axis(curves, index, axis=-1) - np.take_along_axis(curves, index - 1, axis=-1)
            for curves in (values, reference_values)
        )
        return np.asarray(value_change / reference_change)


# ---- Means over repetitions ------------------------------------------------------------------------------------------


class MeansAtLoads:
    """Means of quantities over repetitions at given mean normal loads, with jackknife intervals.

    The method is described in docs/explanation/intervals.md. Let v be the quantity and n the normal load of each
    repetition at the crossing, and e the exponent of the mean curve, mean(v) ~ mean(n)^e. If one repetition is omitted,
    the logarithm of the mean at the load changes by the change of ln mean(v) minus e times the change of ln mean(n). If
    the mean is zero, or if its sign changes when a repetition is omitted, the interval is a symmetric first-order
    interval instead. The constructor takes the means of c curves (c, k) of the normal load and of each quantity, and
    `add_repetitions` takes the repetitions.
    """

    def __init__(self, normal: Floats, quantities: Sequence[Floats], repetitions: int, loads: Floats) -> None:
        self.crossing = LoadCrossings.from_curves(normal, loads)
        # Each array below has one element for each pair of a load curve and a requested load that the curve reaches.
        self._curve, load = map(np.ascontiguousarray, np.nonzero(self.crossing.reached))
        self._index, self._fraction = self.crossing.index[self._curve, load], self.crossing.fraction[self._curve, load]
        self._repetitions = repetitions
        self._load = loads[load]
        slopes = _fit_slopes([values[self._curve] for values in quantities], normal[self._curve], self._index)
        self._quantities = [
            _QuantityAtLoads(self._interpolate_at_crossings(values), slope, self._load, normal.shape[0])
            for values, slope in zip(quantities, slopes, strict=True)
        ]
        self._num_carrying = np.zeros(normal.shape[0], np.intp)

    def add_repetitions(self, normal: Floats, quantities: Sequence[Floats]) -> None:
        """Add repetitions, in arrays of the shape (curves, steps, repetitions), to the sums for jackknife intervals."""
        self._num_carrying += np.count_nonzero(normal.any(axis=1), axis=1)
        points = {"curve": self._curve, "step": self._index, "fraction": self._fraction, "load": self._load}
        for quantity, values in zip(self._quantities, quantities, strict=True):
            quantity.add_repetitions(normal, values, points, self._repetitions)

    def mean(self, quantity: int) -> Floats:
        """Return the means of one quantity in an array of the shape (curves, loads)."""
        return self._arrange_over_loads(self._quantities[quantity].mean)

    def interval(self, quantity: int) -> tuple[Floats, Floats]:
        """Return the limits of the interval of one quantity, in arrays of the shape (curves, loads).

        Call this method after all repetitions have been added.
        """
        lower, upper = self._quantities[quantity].interval(self._curve)
        is_undetermined = ~self._quantities[quantity].keeps_load | (self._num_carrying < 2)[self._curve]
        lower, upper = (np.where(is_undetermined, np.nan, limit) for limit in (lower, upper))
        return self._arrange_over_loads(lower), self._arrange_over_loads(upper)

    def _interpolate_at_crossings(self, curves: Floats) -> Floats:
        """Interpolate a quantity linearly at the crossings of load curves with requested loads."""
        values_after, values_before = (
            curves[self._curve, self._index],
            curves[self._curve, np.maximum(self._index - 1, 0)],
        )
        return np.asarray(values_before + self._fraction * (values_after - values_before))

    def _arrange_over_loads(self, values_at_crossings: Floats) -> Floats:
        """Arrange numbers at crossings in an array (curves, loads), with NaN at loads that a curve does not reach."""
        values_at_loads = np.full(self.crossing.reached.shape, np.nan)
        values_at_loads[self.crossing.reached] = values_at_crossings
        return values_at_loads


class _QuantityAtLoads:
    """Mean of a quantity at each requested load, and the sums from which its jackknife interval is computed."""

    def __init__(self, mean: Floats, slope: Floats, load: Floats, num_curves: int) -> None:
        self.mean, self._slope, self._load = mean, slope, load
        self.has_negative_values = np.zeros(num_curves, np.bool_)
        self._logarithms, self._differences = PowerSums(mean.shape), PowerSums(mean.shape)
        self.keeps_sign, self.keeps_load = np.ones((2, mean.size), np.bool_)

    def add_repetitions(
        self, normal: Floats, values: Floats, points: Mapping[str, NDArray[Any]], total_repetitions: int
    ) -> None:
        """Add repetitions, in arrays of the shape (curves, steps, repetitions), to the sums for jackknife intervals."""
        self.has_negative_values |= (values < 0).any(axis=(1, 2))
        power_sums = _core.jackknife_sums(
            normal, values, **points, mean=self.mean, slope=self._slope, total_repetitions=total_repetitions
        )
        self._logarithms.add_sums(values.shape[2], power_sums[:4])
        self._differences.add_sums(values.shape[2], power_sums[4:8])
        self.keeps_sign &= power_sums[8] > MIN_SIGN_PRESERVING_CHANGE
        self.keeps_load &= power_sums[9] > MIN_SIGN_PRESERVING_CHANGE

    def interval(self, curve: NDArray[np.intp]) -> tuple[Floats, Floats]:
        """Return the interval limits of the mean, for each crossing of a load curve with a requested load.

        `curve` contains the index of the curve of each crossing.
        """
        mean = self.mean
        half_width = self._logarithms.half_width()
        with np.errstate(invalid="ignore", over="ignore"):
            lower, upper = np.sort([mean * np.exp(-half_width), mean * np.exp(half_width)], axis=0)
        is_symmetric = ~self.keeps_sign | ~self._logarithms.is_finite()
        if is_symmetric.any():
            half_width = self._differences.half_width()
            # With equal loads and quantities in all repetitions, the interval's half width is 0 apart from round-off.
            round_off = MAX_RELATIVE_ROUND_OFF * (np.abs(mean) + np.abs(self._slope) * self._load)
            half_width = np.where(half_width <= round_off, 0.0, half_width)
            lower_bound = np.where(self.has_negative_values, -np.inf, 0.0)[curve]
            lower = np.where(is_symmetric, np.maximum(mean - half_width, lower_bound), lower)
            upper = np.where(is_symmetric, mean + half_width, upper)
        return lower, upper


class PowerSums:
    """Sums of the first to fourth powers of jackknife values, which determine the half width of an interval."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self._count = 0
        self._sums = np.zeros((4, *shape))

    def add_values(self, values: Floats) -> None:
        """Add the first four powers of further jackknife values to the stored sums."""
        self._count += values.shape[-1]
        squares = values * values
        self._sums[0] += values.sum(axis=-1)
        for index, factors in enumerate(((values, values), (squares, values), (squares, squares)), start=1):
            self._sums[index] += np.einsum("...r,...r", *factors)

    def add_sums(self, count: int, sums: Floats) -> None:
        """Add sums of the first four powers, taken over `count` further jackknife values, to the stored sums."""
        self._count += count
        self._sums += sums

    def is_finite(self) -> NDArray[np.bool_]:
        """Return a mask that is true where all added jackknife values are finite."""
        return np.asarray(np.isfinite(self._sums).all(axis=0))

    def half_width(self) -> Floats:
        """Return the half width of the 95 % interval from all jackknife values that were added."""
        count = self._count
        first, second, third, fourth = self._sums
        mean = first / count
        with np.errstate(invalid="ignore", over="ignore"):
            square_sum = np.maximum(second - count * mean**2, 0)
            fourth_power_sum = fourth - 4 * mean * third + 6 * mean**2 * second - 3 * count * mean**4
            kurtosis = count * np.divide(
                fourth_power_sum, square_sum**2, out=np.full_like(square_sum, 3.0 / count), where=square_sum > 0
            )
            freedom = np.clip(2 * count / np.maximum(kurtosis - 1, 1e-9), 1, max(count - 1, 1))
            standard_error = np.sqrt((count - 1) / count * square_sum)
        return np.asarray(student_quantile(freedom) * standard_error)


def _fit_slopes(quantities: Sequence[Floats], normal: Floats, index: NDArray[np.intp]) -> list[Floats]:
    """Return d(quantity)/d(normal load) at given loading steps, from straight lines fitted to nearby steps.

    Quantities and loads have the shape (p, k), and the indices of the loading steps have the shape (p,).
    """
    first_step = np.maximum(index - 1 - NUM_LOAD_STEPS_PER_SIDE_OF_SLOPE_FIT, 0)[:, np.newaxis]
    last_step = np.minimum(index + NUM_LOAD_STEPS_PER_SIDE_OF_SLOPE_FIT, normal.shape[1] - 1)[:, np.newaxis]
    window_indices = first_step + np.arange(2 * NUM_LOAD_STEPS_PER_SIDE_OF_SLOPE_FIT + 2)
    is_inside = window_indices <= last_step
    window_indices = np.minimum(window_indices, last_step)
    count = is_inside.sum(axis=1, keepdims=True)

    def compute_deviations(curves: Floats) -> Floats:
        """Return each curve minus its mean over the fitted steps. Entries outside the fitted steps are 0."""
        values = np.where(is_inside, np.take_along_axis(curves, window_indices, axis=1), 0.0)
        return np.where(is_inside, values - values.sum(axis=1, keepdims=True) / count, 0.0)

    x = compute_deviations(normal)
    squares = (x * x).sum(axis=1)
    return [
        np.divide((x * compute_deviations(values)).sum(axis=1), squares, out=np.zeros_like(squares), where=squares > 0)
        for values in quantities
    ]


# ---- Means over a sample ---------------------------------------------------------------------------------------------


def average_independent_values(values: Floats) -> tuple[Floats, Floats, Floats]:
    """Average independent values along the first axis, ignoring NaN, and return the mean with its Student's t interval.

    If no number is negative, the interval is symmetric in the logarithm of the mean, so that it is above 0.
    """
    is_known = np.isfinite(values)
    finite_values, count = np.where(is_known, values, 0.0), is_known.sum(axis=0)
    mean = finite_values.sum(axis=0) / np.maximum(count, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        standard_error = np.sqrt(np.square(np.where(is_known, values - mean, 0.0)).sum(axis=0) / (count - 1) / count)
    quantile = student_quantile(np.maximum(count - 1, 1))
    half_width = np.where(count >= MIN_SAMPLE_SIZE, quantile * standard_error, np.nan)
    mean = np.where(count > 0, mean, np.nan)
    return mean, *interval_around_mean(mean, half_width, (finite_values < 0).any(axis=0))


def interval_around_mean(mean: ArrayLike, half_width: ArrayLike, is_signed: ArrayLike) -> tuple[Floats, Floats]:
    """Return the lower and the upper limit of an interval with a given mean and half width.

    The interval is symmetric in the logarithm of the mean, unless `is_signed` is true or the mean is not positive.
    """
    mean, half_width = np.asarray(mean, float), np.asarray(half_width, float)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        factor = np.exp(half_width / mean)
        lower, upper = mean / factor, mean * factor
    by_logarithm = ~np.asarray(is_signed) & (mean > 0)
    return np.where(by_logarithm, lower, mean - half_width), np.where(by_logarithm, upper, mean + half_width)


# ---- Means over neighbouring positions -------------------------------------------------------------------------------


@lru_cache(maxsize=32)
def _compute_mixture_constants(count: int) -> tuple[Floats, Floats, float, float]:
    """Return the constants of the interval of a mean of `count` correlated values, for several trial correlations.

    The trial correlations are those of adjacent values.

    With the correlation matrix R of the values, the constants are 1' R^-1 1, the variance of the mean relative to that
    of a value, and the two-sided 95 % quantile and the peak density of Student's t distribution.
    """
    rho, lags = _TRIAL_NEIGHBOUR_CORRELATIONS, np.arange(1, count)
    weight_sums = (count - (count - 2) * rho) / (1 + rho)
    inflation = (count + 2 * ((count - lags) * rho[:, np.newaxis] ** lags).sum(axis=1)) / count**2
    density = math.exp(math.lgamma(count / 2) - math.lgamma((count - 1) / 2)) / math.sqrt(math.pi * (count - 1))
    return weight_sums, inflation, float(student_quantile(count - 1)), density


def average_correlated_values(values: Floats) -> tuple[Floats, Floats, Floats]:
    """Average values at neighbouring positions (first axis), and return the mean with the limits of its interval.

    The interval allows for correlation between neighbours.

    The values are transformed to remove their skewness. The model is a mixture of autoregressive processes with
    correlations ρ from 0 to 0.95: Student's t intervals are averaged with the posterior probability of ρ as weight,
    for a prior proportional to sqrt(1 - ρ). The interval lies within the range of the values. The interval is NaN if
    there are fewer than `MIN_NEIGHBOURING_POSITIONS` values or if all values are equal.
    """
    count = values.shape[0]
    # Each column of `values` is averaged separately, so the round-off of a mean is independent of other columns.
    rows = np.ascontiguousarray(values.reshape(count, math.prod(values.shape[1:])).T)
    mean = rows.mean(axis=1) if count else np.full(rows.shape[0], np.nan)
    lower, upper = np.full((2, mean.size), np.nan)
    if count >= MIN_NEIGHBOURING_POSITIONS:
        batch_size = max(1, MAX_VALUES_PER_BATCH // (4 * count))
        for batch_start in range(0, mean.size, batch_size):
            batch = slice(batch_start, batch_start + batch_size)
            lower[batch], upper[batch] = _compute_interval_of_correlated_mean(rows[batch], mean[batch])
    return tuple(array.reshape(values.shape[1:]) for array in (mean, lower, upper))  # type: ignore[return-value]


def _compute_interval_of_correlated_mean(values: Floats, mean: Floats) -> tuple[Floats, Floats]:
    """Return the interval limits of the mean of each row, in which neighbouring numbers may be correlated.

    Returns NaN for rows of equal values.

    The values have the shape (c, r).
    """
    from scipy.special import stdtr

    # Deviations from the mean are divided by their standard deviation, because squares of large values would overflow.
    value_count, deviations = values.shape[1], values - mean[:, np.newaxis]
    standard_deviation = np.sqrt(np.square(deviations).sum(axis=1) / (value_count - 1))
    has_spread = (standard_deviation > 0) & (values != values[:, :1]).any(axis=1)
    y, rho = deviations / np.where(has_spread, standard_deviation, 1.0)[:, np.newaxis], _TRIAL_NEIGHBOUR_CORRELATIONS
    y[~has_spread] = np.linspace(-1.0, 1.0, value_count)
    # For an autoregressive matrix R, R^-1 is tridiagonal: yᵀ R^-1 y is a sum of squares and of products of neighbours.
    weight_sums, inflation, quantile, density = _compute_mixture_constants(value_count)
    end_values = y[:, [0, -1]]
    inner_sums, end_squares = y[:, 1:-1].sum(axis=1)[:, np.newaxis], np.square(end_values).sum(axis=1)[:, np.newaxis]
    products = (y[:, 1:] * y[:, :-1]).sum(axis=1)[:, np.newaxis]
    # `centre` has one row per series of values, and one column per trial correlation `rho` of neighbouring values.
    centre = (end_values.sum(axis=1)[:, np.newaxis] + (1 - rho) * inner_sums) / (1 + rho) / weight_sums
    total_squares = (1 + rho**2) * (np.square(y).sum(axis=1)[:, np.newaxis]) - rho**2 * end_squares - 2 * rho * products
    squares = total_squares / (1 - rho**2) - weight_sums * centre**2
    weights = (value_count - 1) * (np.log(1 - rho**2) + np.log(squares)) + np.log(weight_sums) - np.log(1 - rho)
    weights = np.exp(-0.5 * (weights - weights.min(axis=1, keepdims=True)))
    weights /= weights.sum(axis=1, keepdims=True)
    standard_errors = np.sqrt(squares / (value_count - 1) * inflation)

    # Newton steps from below the quantile do not overshoot it, because the distribution function is concave above 0.
    quantile_estimate, moving_rows = quantile * standard_errors.min(axis=1), np.arange(mean.size)
    for _ in range(_MAX_NEWTON_STEPS):
        row_weights, row_errors = weights[moving_rows], standard_errors[moving_rows]
        t = quantile_estimate[moving_rows, np.newaxis] / row_errors
        slope = density * (row_weights * (1 + t * t / (value_count - 1)) ** (-value_count / 2) / row_errors).sum(axis=1)
        step = (0.5 + CONFIDENCE_LEVEL / 2 - (row_weights * stdtr(value_count - 1, t)).sum(axis=1)) / slope
        quantile_estimate[moving_rows] += step
        moving_rows = moving_rows[step > 1e-15 * quantile_estimate[moving_rows]]
        if not moving_rows.size:
            break
    skewness = (y**3).mean(axis=1) / (y**2).mean(axis=1) ** 1.5 / 3
    is_symmetric = np.abs(skewness) <= _MAX_SYMMETRIC_SKEWNESS
    skewness = np.where(is_symmetric, 1.0, skewness)
    lower_width = np.where(is_symmetric, quantile_estimate, -np.expm1(-skewness * quantile_estimate) / skewness)
    upper_width = np.where(is_symmetric, quantile_estimate, np.expm1(skewness * quantile_estimate) / skewness)
    lower = np.maximum(mean - standard_deviation * lower_width, values.min(axis=1))
    upper = np.minimum(mean + standard_deviation * upper_width, values.max(axis=1))
    return np.where(has_spread, lower, np.nan), np.where(has_spread, upper, np.nan)


def average_line_means(values: Floats, lines: NDArray[np.intp]) -> tuple[Floats, Floats, Floats]:
    """Average a quantity over the positions on all lines, and return the mean with its 95 % interval."""
    if not values.shape[0]:
        return tuple(np.full(values.shape[1:], np.nan) for _ in range(3))  # type: ignore[return-value]
    _, first_indices, index = np.unique(lines, return_index=True, return_inverse=True)
    line_means = values
    if first_indices.size > 1:
        position_counts = np.bincount(index).reshape(-1, *(1,) * (values.ndim - 1))
        line_sums = np.zeros((first_indices.size, *values.shape[1:]))
        np.add.at(line_sums, index, values)
        overall_mean = np.ascontiguousarray(np.moveaxis(line_sums, 0, -1)).sum(axis=-1) / position_counts.sum()
        line_means = (overall_mean + (line_sums - position_counts * overall_mean) / position_counts.mean())[
            np.argsort(first_indices)
        ]
    mean, lower, upper = average_correlated_values(line_means)
    return mean, np.maximum(lower, values.min(axis=0)), np.minimum(upper, values.max(axis=0))


# ---- Means over pairs of scans ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ScanPairMean:
    """Mean of a quantity over all pairs of an upper and a lower scan, with its variance components."""

    mean: float
    # Components of the variance that are due to upper scans, lower scans and positions.
    variances: tuple[float, ...]
    # Degrees of freedom of the variance of the mean (Satterthwaite, 1946).
    freedom: float
    test: float
    test_freedom: float

    @property
    def half_width(self) -> float:
        """Half width of the 95 % interval of the mean; infinite if there are too few members."""
        return float(student_quantile(min(self.freedom, MAX_DEGREES_OF_FREEDOM))) * math.sqrt(sum(self.variances))


def average_scan_pairs(values: Floats, upper: NDArray[np.intp], lower: NDArray[np.intp]) -> ScanPairMean | None:
    """Average values over pairs of scans, and return the mean with the variance components of the values.

    Returns None if there are fewer than two pairs.

    The values have the shape (r, ...). The model has two-way random effects (Searle, Casella & McCulloch, Variance
    Components, 1992, chapter 4). Mean squares that do not exceed the residual mean square are pooled with the residual.
    """
    flat_values = values.reshape(values.shape[0], -1)
    pair_means = np.full((int(upper.max()) + 1, int(lower.max()) + 1), np.nan)
    for scan_pair in set(zip(upper.tolist(), lower.tolist(), strict=True)):
        pair_values = flat_values[(upper == scan_pair[0]) & (lower == scan_pair[1])]
        pair_means[scan_pair] = (
            pair_values[np.isfinite(pair_values)].mean() if np.isfinite(pair_values).any() else np.nan
        )
    scan_means = pair_means[np.ix_(np.isfinite(pair_means).any(axis=1), np.isfinite(pair_means).any(axis=0))]
    scan_counts = np.array(scan_means.shape)
    pair_count = int(scan_counts.prod())
    if pair_count < 2:
        return None
    row_means, column_means, mean = (
        np.nanmean(scan_means, axis=1),
        np.nanmean(scan_means, axis=0),
        float(np.nanmean(scan_means)),
    )
    residual_sum = np.nansum((scan_means - row_means[:, np.newaxis] - column_means + mean) ** 2)
    freedoms = np.array([*(scan_counts - 1), (scan_counts - 1).prod()], float)
    sums = np.array(
        [
            scan_counts[1] * np.square(row_means - mean).sum(),
            scan_counts[0] * np.square(column_means - mean).sum(),
            residual_sum,
        ]
    )
    mean_squares = sums / np.maximum(freedoms, 1)
    is_separate = (freedoms > 0) & (mean_squares > mean_squares[2]) & [True, True, False]
    freedom = float(freedoms[~is_separate].sum())
    residual_variance = float(sums[~is_separate].sum()) / max(freedom, 1.0)
    variance_components = np.append(np.where(is_separate, mean_squares - residual_variance, 0.0)[:2], residual_variance)
    # The sum of the variance components is the sum of the n separate mean squares, plus (1 - n) · (residual variance).
    component_weights = np.append(
        np.where(is_separate, mean_squares, 0.0)[:2], (1 - is_separate.sum()) * residual_variance
    )
    component_freedoms = np.maximum([*freedoms[:2], freedom], 1.0)
    deviations_in_pairs = (flat_values - pair_means[upper, lower][:, np.newaxis]).ravel()
    deviations_in_pairs = deviations_in_pairs[np.isfinite(deviations_in_pairs)]
    freedom_in_pairs = max(deviations_in_pairs.size - pair_count, 1)
    scan_mean_variances = variance_components[:2] / scan_counts[::-1]
    new_test_variances = np.append(
        scan_mean_variances * (1 + 1 / scan_counts),
        float(deviations_in_pairs @ deviations_in_pairs) / freedom_in_pairs + residual_variance * (1 + 1 / pair_count),
    )
    return ScanPairMean(
        mean, tuple(variance_components / pair_count),
        _satterthwaite_degrees_of_freedom(variance_components.sum(), component_weights, component_freedoms),
        math.sqrt(new_test_variances.sum()),
        _single_test_degrees_of_freedom(new_test_variances, np.append(component_freedoms[:2], freedom_in_pairs)),
    )  # fmt: skip


def _single_test_degrees_of_freedom(components: Floats, freedoms: Floats) -> float:
    """Return the degrees of freedom of a single test's variance, which is a sum of variance components.

    The degrees of freedom are limited, so that the interval is at least as wide as the interval from each component
    alone. With two scans, the variance between scans has one degree of freedom. If the estimate of this variance is
    small, Satterthwaite's degrees of freedom are close to those of the other components, and the intervals would cover
    only 0.86 to 0.90 of the tests. With the limit, the intervals cover 0.94 to 0.99.
    """
    from scipy.special import stdtridf

    variance = float(components.sum())
    approximate_freedom = min(_satterthwaite_degrees_of_freedom(variance, components, freedoms), MAX_DEGREES_OF_FREEDOM)
    if not variance > 0:
        return approximate_freedom
    max_component_width = float((student_quantile(freedoms) * np.sqrt(components / variance)).max())
    if max_component_width <= student_quantile(approximate_freedom):
        return approximate_freedom
    return float(stdtridf(0.5 + CONFIDENCE_LEVEL / 2, max_component_width))


def _satterthwaite_degrees_of_freedom(variance: float, components: Floats, freedoms: Floats) -> float:
    """Return the degrees of freedom of a variance that is a sum of estimated components (Satterthwaite, 1946)."""
    squares = float((components**2 / freedoms).sum())
    return float(variance**2 / squares) if squares > 0 else math.inf
