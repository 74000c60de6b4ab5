"""Numbers with 95 % intervals. The width of an interval determines how many digits of a number are printed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats
from stiction._number_format import (
    MAX_NUMBER_WITHOUT_EXPONENT,
    MIN_NUMBER_WITHOUT_EXPONENT,
    choose_prefixed_unit,
    format_significant,
)

MAX_SIGNIFICANT_DIGITS = 4
INFINITE_LIMIT_TEXT = "\N{INFINITY}"
MAX_LIMIT_TO_VALUE_RATIO_AT_FULL_PRECISION = 100.0
DECIMALS_CODE_OF_NO_INTERVAL = -128
DECIMALS_CODE_OF_EXPONENT = -127
MAX_DECIMALS = 100

EstimateKind = Literal["", "mean", "combined", "prediction", "conditional", "fit", "range"]
"""Kind of the interval of an estimate; "" if there is no interval.

*mean*: interval of the mean over members, with exact inputs. *combined*: includes all uncertain inputs. *prediction*:
interval for one further test. *conditional*: all uncertain inputs except one, which is exact. *fit*: interval of a
fitted parameter. *range*: range of typical numbers.
"""


class Interval(NamedTuple):
    """Lower and upper limit of an interval.

    ``str(interval)`` rounds both limits to the first significant digit of the half-width, as in "0.04 to 0.19". The
    larger limit has at least two digits. `upper` may be infinite. An interval with NaN limits cannot be printed.
    """

    lower: float
    upper: float

    def extended_to(self, *others: tuple[float, float]) -> Interval:
        """Return the smallest interval that includes this interval and all given intervals."""
        return Interval(*extend_intervals(self, *others).tolist()) if others else self

    def __str__(self) -> str:
        if math.isinf(self.upper):
            return f"{format_significant(self.lower)} to {INFINITE_LIMIT_TEXT}"
        larger_end = max(abs(self.lower), abs(self.upper))
        decimals = int(
            _count_interval_decimals(np.asarray(larger_end), np.asarray(self.lower), np.asarray(self.upper), 1)
        )
        end_texts = [_format_decimals(end, decimals) for end in self]
        return end_texts[0] if end_texts[0] == end_texts[1] else " to ".join(end_texts)


@dataclass(frozen=True)
class Estimate:
    """Estimated quantity: value, limits of the 95 % interval, name, unit, and kind of the interval.

    ``str(estimate)`` is ``estimate.text(1)``, as in "0.16 [0.10, 0.22]".

    Attributes
    ----------
    value : float
        Value, or NaN if it is missing.
    lower, upper : float
        Limits of the 95 % interval, or NaN if there is no interval. `upper` may be infinite.
    name : str
        Name of the quantity, such as "contact_area".
    unit : str
        Unit of the value and of the limits; "1" for a number without a unit.
    kind : EstimateKind
        Kind of the interval; empty without an interval.
    status : str
        "ok", or the reason why there is no value.
    """

    value: float
    lower: float = math.nan
    upper: float = math.nan
    _: KW_ONLY
    name: str = ""
    unit: str = "1"
    kind: EstimateKind = ""
    status: str = "ok"

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Self:
        """Create an estimate from the JSON object that `to_record` returned."""
        value, lower, upper = (math.nan if record[key] is None else record[key] for key in ("value", "lower", "upper"))
        if math.isnan(upper) and not math.isnan(lower):
            upper = math.inf
        return cls(value, lower, upper, **{key: record[key] for key in ("name", "unit", "kind", "status")})

    @property
    def interval(self) -> Interval:
        """Limits of the 95 % interval of the estimate."""
        return Interval(self.lower, self.upper)

    @property
    def has_interval(self) -> bool:
        """True if both limits of the interval are known.

        The upper limit may be infinite.
        """
        return not (math.isnan(self.lower) or math.isnan(self.upper))

    def __str__(self) -> str:
        return self.text(1)

    @property
    def table_text(self) -> str:
        """Text of the estimate in a table: `text()`, followed by "no interval" if the interval is unknown."""
        is_missing_interval = not (math.isnan(self.value) or self.has_interval)
        return f"{self.text()}{' no interval' * is_missing_interval}"

    def in_unit(self, unit: str, factor: float) -> Self:
        """Return the estimate in another unit.

        Value and limits are multiplied by `factor`, which must be positive.
        """
        return replace(self, value=self.value / factor, lower=self.lower / factor, upper=self.upper / factor, unit=unit)

    def in_prefixed_unit(self, unit: str | None = None) -> Self:
        """Return the estimate with a prefixed unit, such as nm or mm, that suits the size of its value.

        Parameters
        ----------
        unit : str, optional
            Core unit, such as "um", or "%" for a fraction; by default the unit of the estimate.
        """
        factor, name = choose_prefixed_unit(self.value, self.unit if unit is None else unit)
        return self.in_unit(name, factor)

    def to_record(self, at: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Return the estimate as a JSON object, with the given coordinates, such as the load, in the field "at"."""
        return {
            "name": self.name, "value": float(self.value), "unit": to_file_unit(self.unit),
            "lower": float(self.lower), "upper": float(self.upper), "kind": self.kind, "at": dict(at or {}),
            "status": self.status,
        }  # fmt: skip

    def extended_to(self, other: Estimate) -> Self:
        """Return the estimate with a wider interval, which also includes the interval of another estimate.

        A missing interval stays missing, because the uncertainty of this estimate is then unknown.
        """
        lower, upper = self.interval.extended_to(other.interval)
        return replace(self, lower=lower, upper=upper)

    def text(self, digits: int = 2) -> str:
        """Return value and interval as text, rounded so that half the interval width has `digits` significant digits.

        The number has up to four significant digits; without an interval, it has two digits if `digits` is 1, and
        otherwise up to three. The interval is omitted if both limits are equal after rounding. The text is "none" if
        the value is NaN.

        Parameters
        ----------
        digits : {1, 2}
            1 for a text such as "0.16 [0.10, 0.22]", 2 for "0.157 [0.102, 0.216]".
        """
        if math.isnan(self.value):
            return "none"
        numbers = (np.asarray(number, float) for number in (self.value, self.lower, self.upper))
        decimals, upper_limit_decimals = map(int, count_estimate_decimals(*numbers, digits=digits))
        value_text = _format_decimals(self.value, decimals)
        if upper_limit_decimals == DECIMALS_CODE_OF_NO_INTERVAL:
            return value_text
        if math.isinf(self.upper):
            upper_text = f"{INFINITE_LIMIT_TEXT})"
        elif upper_limit_decimals == DECIMALS_CODE_OF_EXPONENT:
            upper_text = f"{self.upper:.0e}]"
        else:
            upper_text = f"{_format_decimals(self.upper, upper_limit_decimals)}]"
        return f"{value_text} [{_format_decimals(self.lower, decimals)}, {upper_text}"


def to_file_unit(unit: str) -> str:
    """Return the spelling of a unit in JSON and CSV files, such as "um2" for "um^2".

    Returns "1" for no unit.
    """
    return unit.replace("um^2", "um2") or "1"


def estimate_column_titles(title: str, unit: str = "1") -> dict[str, str]:
    """Return the column titles of an estimate in a CSV file: value, lower limit, and upper limit."""
    title = title if unit in ("", "1") else f"{title} ({unit})"
    return {"value": title, "lower": f"{title}: lower", "upper": f"{title}: upper"}


def extend_intervals(own: ArrayLike, *others: ArrayLike) -> Floats:
    """Widen each interval in an array so that it includes the corresponding intervals in other arrays.

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
    extended_limits = limits[0].copy()
    extended_limits[..., 0], extended_limits[..., 1] = np.fmin.reduce(limits[..., 0]), np.fmax.reduce(limits[..., 1])
    return np.asarray(np.where(np.isnan(limits[0]).any(axis=-1, keepdims=True), limits[0], extended_limits))


def count_estimate_decimals(
    value: Floats, lower: Floats, upper: Floats, *, digits: int
) -> tuple[NDArray[np.int8], NDArray[np.int8]]:
    """Return how many decimals to print: one array for values and lower limits, and one array for upper limits.

    The number of decimals is negative for numbers that are rounded to tens or more. The second array contains
    `DECIMALS_CODE_OF_NO_INTERVAL` if the text contains no interval, and `DECIMALS_CODE_OF_EXPONENT` for a very large
    limit. `digits` is explained at `Estimate.text`.
    """
    has_interval = ~(np.isnan(lower) | np.isnan(upper))
    with np.errstate(invalid="ignore", over="ignore"):
        decimals = _count_interval_decimals(value, lower, np.where(np.isinf(upper), 2 * value - lower, upper), digits)
        scale = 10.0 ** np.clip(decimals, -MAX_DECIMALS, MAX_DECIMALS)
        are_ends_equal = np.isfinite(upper) & (np.abs(np.round(lower * scale) - np.round(upper * scale)) < 1)
        is_huge = (
            np.isfinite(upper) & (upper > MAX_LIMIT_TO_VALUE_RATIO_AT_FULL_PRECISION * np.abs(value)) & (value != 0)
        )
    has_exponent = is_huge & ~((upper >= MIN_NUMBER_WITHOUT_EXPONENT) & (upper < MAX_NUMBER_WITHOUT_EXPONENT))
    upper_limit_decimals = np.where(is_huge, _count_significant_decimals(upper, 1), decimals)
    value_decimals = -_find_decimal_exponents(value) + 1 if digits == 1 else _count_significant_decimals(value, 3)
    decimals = np.where(are_ends_equal, _count_significant_decimals(value, MAX_SIGNIFICANT_DIGITS), decimals)
    decimals = np.where(has_interval, decimals, value_decimals)
    decimals, upper_limit_decimals = (
        np.nan_to_num(np.clip(array, -MAX_DECIMALS, MAX_DECIMALS)) for array in (decimals, upper_limit_decimals)
    )
    upper_limit_decimals = np.where(has_exponent, DECIMALS_CODE_OF_EXPONENT, upper_limit_decimals)
    upper_limit_decimals = np.where(has_interval & ~are_ends_equal, upper_limit_decimals, DECIMALS_CODE_OF_NO_INTERVAL)
    return decimals.astype(np.int8), upper_limit_decimals.astype(np.int8)


def _count_interval_decimals(value: Floats, lower: Floats, upper: Floats, digits: int) -> Floats:
    """Return how many decimals to print so that half of an interval's width has `digits` significant digits.

    Unless the value is 0, the number of decimals is limited so that the value has 2 to 4 significant digits. For an
    interval without width, the value has 4 significant digits.
    """
    first_decimals = -_find_decimal_exponents(value)
    max_decimals = first_decimals + MAX_SIGNIFICANT_DIGITS - 1
    interval_decimals = digits - 1 - _find_decimal_exponents((upper - lower) / 2)
    decimals = np.where(value == 0, interval_decimals, np.clip(interval_decimals, first_decimals + 1, max_decimals))
    return np.asarray(np.where(upper > lower, decimals, max_decimals))


def _count_significant_decimals(value: Floats, digits: int) -> Floats:
    """Round a number to `digits` significant digits, drop trailing zeros, and return the number of decimals left."""
    exponents = _find_decimal_exponents(value)
    with np.errstate(invalid="ignore", over="ignore"):
        # Each number is scaled to an integer with `digits` digits: with four digits, 0.01234 becomes 1234.
        digit_values = np.round(np.abs(value) / 10.0 ** (exponents - digits + 1))
        quotients = [digit_values / 10**count for count in range(1, digits + 1)]
        # Trailing zeros are found from the quotients by 10, 100, ..., because remainders would take ten times as long.
        trailing_zeros = sum((quotient - np.floor(quotient) == 0).astype(float) for quotient in quotients)
    return np.asarray(np.where(value == 0, 0.0, digits - 1 - exponents - trailing_zeros))


def _find_decimal_exponents(value: Floats) -> Floats:
    """Return the exponent of each number in scientific notation, such as 2 for 123. The exponent of 0 is taken as 0."""
    size = np.abs(value)
    with np.errstate(divide="ignore"):
        exponents = np.where(size == 0, 0.0, np.floor(np.log10(size)))
    # Round-off in the logarithm may make the exponent of a power of ten, such as 1000, too small by 1.
    return np.asarray(np.where(size >= 10.0 ** (exponents + 1), exponents + 1, exponents))


def _format_decimals(value: float, digits: int) -> str:
    text = f"{round(value, digits):.{max(digits, 0)}f}"
    return text.removeprefix("-") if float(text) == 0 else text
