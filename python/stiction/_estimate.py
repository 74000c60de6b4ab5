"""Values with 95 % intervals. The width of the interval determines how many digits are printed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction._number_format import choose_prefixed_unit, format_significant

MAX_SIGNIFICANT_DIGITS = 4  # maximum number of significant digits of a value, even if its interval is very narrow
UNBOUNDED_END_TEXT = "\N{INFINITY}"  # text for the upper end of an unbounded interval
# the upper end of an interval is printed with one digit if it exceeds this multiple of the value
MAX_FULL_PRECISION_END_RATIO = 100.0


class Interval(NamedTuple):
    """Limits of an interval.

    ``str(interval)`` rounds both limits to the first significant digit of the half-width, as in "0.04 to 0.19". The
    larger limit has at least two digits. `upper` may be infinite. An interval with NaN limits cannot be printed.
    """

    lower: float
    upper: float

    def extended_to(self, *others: tuple[float, float]) -> Interval:
        """Return the smallest interval that includes this interval and other intervals, as for `extend_intervals`."""
        return Interval(*extend_intervals(self, *others).tolist()) if others else self

    def __str__(self) -> str:
        if math.isinf(self.upper):
            return f"{format_significant(self.lower)} to {UNBOUNDED_END_TEXT}"
        decimals = _count_decimals(max(abs(self.lower), abs(self.upper)), self.lower, self.upper, 1)
        end_texts = [_format_decimals(end, decimals) for end in self]
        return end_texts[0] if end_texts[0] == end_texts[1] else " to ".join(end_texts)


@dataclass(frozen=True)
class Estimate:
    """Value with the limits of its 95 % interval.

    ``str(estimate)`` rounds the value and both limits to the first significant digit of the half-width, as in
    "0.16 [0.10, 0.22]"; a value without an interval is printed with two digits. ``f"{estimate:.2u}"`` rounds to the
    second significant digit of the half-width, as in "0.157 [0.102, 0.216]"; a value without an interval is printed
    with up to three digits. The format ``.2u`` has the same meaning as in the package ``uncertainties``.

    The value has up to four significant digits. The interval is omitted if both limits are equal after rounding. The
    text is "none" if the value is NaN.

    Attributes
    ----------
    value : float
        Value, or NaN if it is missing.
    lower, upper : float
        Limits of the 95 % interval, or NaN if there is no interval. `upper` may be infinite.
    """

    value: float
    lower: float = math.nan
    upper: float = math.nan

    @property
    def interval(self) -> Interval:
        """Limits of the 95 % interval."""
        return Interval(self.lower, self.upper)

    @property
    def has_interval(self) -> bool:
        """True if both limits are known. The upper limit may be infinite."""
        return not (math.isnan(self.lower) or math.isnan(self.upper))

    def __str__(self) -> str:
        if math.isnan(self.value):
            return "none"
        if not self.has_interval:
            return _format_decimals(self.value, _first_decimal(self.value) + 1)
        return self._format_with_interval(1)

    def __format__(self, format_spec: str) -> str:
        if not format_spec:
            return str(self)
        if format_spec != ".2u":
            raise ValueError(f"format of an estimate must be '' or '.2u', got {format_spec!r}")
        if math.isnan(self.value):
            return "none"
        return self._format_with_interval(2) if self.has_interval else format_significant(self.value, 3)

    @property
    def table_text(self) -> str:
        """Text for a table: the format ``.2u``, followed by "no interval" if there is no interval."""
        is_missing_interval = not (math.isnan(self.value) or self.has_interval)
        return f"{self:.2u}{' no interval' * is_missing_interval}"

    def __truediv__(self, factor: float) -> Estimate:
        """Return the estimate in a unit that is `factor` (positive) times as large."""
        return Estimate(self.value / factor, self.lower / factor, self.upper / factor)

    def in_prefixed_unit(self, unit: str) -> tuple[Estimate, str]:
        """Return the estimate in the prefixed unit in which its value has the fewest zeros, and the name of this unit.

        Parameters
        ----------
        unit : str
            Core unit of the estimate, such as "um".
        """
        factor, name = choose_prefixed_unit(self.value, unit)
        return self / factor, name

    def extended_to(self, other: Estimate) -> Self:
        """Return a copy whose interval is extended to include the interval of another estimate.

        A missing interval stays missing, because the uncertainty of the value is then unknown.
        """
        lower, upper = self.interval.extended_to(other.interval)
        return replace(self, lower=lower, upper=upper)

    def _format_with_interval(self, digits: int) -> str:
        """Return the value and its interval, rounded to `digits` significant digits of the half-width."""
        value, lower, upper = self.value, self.lower, self.upper
        if math.isinf(upper):
            decimals = _count_decimals(value, lower, 2 * value - lower, digits)
            return f"{_format_decimals(value, decimals)} [{_format_decimals(lower, decimals)}, {UNBOUNDED_END_TEXT})"
        decimals = _count_decimals(value, lower, upper, digits)
        end_texts = [_format_decimals(end, decimals) for end in (lower, upper)]
        if end_texts[0] == end_texts[1]:
            return format_significant(value, MAX_SIGNIFICANT_DIGITS)
        if upper > MAX_FULL_PRECISION_END_RATIO * abs(value) > 0:
            end_texts[1] = format_significant(upper, 1)
        return f"{_format_decimals(value, decimals)} [{end_texts[0]}, {end_texts[1]}]"


def extend_intervals(own: ArrayLike, *others: ArrayLike) -> Floats:
    """Extend intervals to include other intervals.

    Parameters
    ----------
    own : (..., 2) array_like of float
        Lower and upper limits. An interval with a NaN limit is unknown and stays unchanged.
    *others : (..., 2) array_like of float
        Limits of the intervals to include; NaN limits are ignored.

    Returns
    -------
    intervals : (..., 2) ndarray of float
        Limits of the extended intervals.
    """
    limits = np.array([own, *others], float)
    extended = limits[0].copy()
    extended[..., 0], extended[..., 1] = np.fmin.reduce(limits[..., 0]), np.fmax.reduce(limits[..., 1])
    return np.asarray(np.where(np.isnan(limits[0]).any(axis=-1, keepdims=True), limits[0], extended))


def _first_decimal(value: float) -> int:
    """Return the position of the first significant digit after the decimal point; it is negative for large values."""
    return -math.floor(math.log10(abs(value))) if value else 0


def _count_decimals(value: float, lower: float, upper: float, digits: int) -> int:
    """Return how many decimals to print for `digits` digits of the half-width, and for 2 to 4 digits of the value."""
    first_decimal = _first_decimal(value)
    if not upper > lower:
        return first_decimal + MAX_SIGNIFICANT_DIGITS - 1
    interval_decimals = digits - 1 - math.floor(math.log10((upper - lower) / 2))
    if not value:
        return interval_decimals
    return min(max(interval_decimals, first_decimal + 1), first_decimal + MAX_SIGNIFICANT_DIGITS - 1)


def _format_decimals(value: float, digits: int) -> str:
    text = f"{round(value, digits):.{max(digits, 0)}f}"
    return text.removeprefix("-") if float(text) == 0 else text
