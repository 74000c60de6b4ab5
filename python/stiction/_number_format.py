"""Formatting of numbers. The interval determines the number of digits, and the magnitude determines the unit."""

from __future__ import annotations

import json
import math
from typing import Any

MAX_SIGNIFICANT_DIGITS = 4  # maximum number of significant digits of a value, even if its interval is very narrow
UNBOUNDED_END_TEXT = "\N{INFINITY}"  # text for the upper end of an unbounded interval
# the upper end of an interval is printed with one digit if it exceeds this multiple of the value
MAX_FULL_PRECISION_END_RATIO = 100.0

_PREFIXED_UNITS = {
    "mN": ((1e6, 1e6, "kN"), (1e3, 1e3, "N"), (0.01, 1.0, "mN"), (1e-5, 1e-3, "µN"), (0.0, 1e-6, "nN")),
    "GPa": ((1.0, 1.0, "GPa"), (1e-3, 1e-3, "MPa"), (1e-6, 1e-6, "kPa"), (0.0, 1e-9, "Pa")),
    "um": ((1e6, 1e6, "m"), (1e3, 1e3, "mm"), (1.0, 1.0, "µm"), (0.0, 1e-3, "nm")),
    "pJ": ((1e3, 1e3, "nJ"), (1.0, 1.0, "pJ"), (0.0, 1e-3, "fJ")),
}
"""Prefixed units of each core unit: smallest value to be printed in the unit, factor to the core unit, and name."""


def format_with_interval(mean: float, lower: float, upper: float, *, digits: int = 2) -> str:
    """Format a value and its interval, as in "0.157 [0.102, 0.216]". The half-width is printed to `digits` digits.

    The value has two to four significant digits. The text is "none" for a missing value, and ends with "no interval"
    for a missing interval. The interval is omitted if both ends are equal to four digits.
    """
    if math.isnan(mean):
        return "none"
    if math.isnan(lower) or math.isnan(upper):
        return f"{format_significant(mean, 3)} no interval"
    if math.isinf(upper):
        decimals = _num_decimals(mean, lower, 2 * mean - lower, digits)
        return f"{_format_decimals(mean, decimals)} [{_format_decimals(lower, decimals)}, {UNBOUNDED_END_TEXT})"
    decimals = _num_decimals(mean, lower, upper, digits)
    end_texts = [_format_decimals(end, decimals) for end in (lower, upper)]
    if end_texts[0] == end_texts[1]:
        return format_significant(mean, MAX_SIGNIFICANT_DIGITS)
    if upper > MAX_FULL_PRECISION_END_RATIO * abs(mean) > 0:
        end_texts[1] = format_significant(upper, 1)
    return f"{_format_decimals(mean, decimals)} [{end_texts[0]}, {end_texts[1]}]"


def format_estimate(mean: float, lower: float = math.nan, upper: float = math.nan) -> str:
    """Format a number with its interval to one digit of the half-width, or without an interval to two digits."""
    if math.isnan(mean):
        return "none"
    if math.isnan(lower) or math.isnan(upper):
        return _format_decimals(mean, _num_decimals(mean, math.nan, math.nan, 2) - MAX_SIGNIFICANT_DIGITS + 2)
    return format_with_interval(mean, lower, upper, digits=1)


def format_limits(low: float, high: float) -> str:
    """Format the ends of a range, rounded to one digit of the half-width. The larger end has at least two digits."""
    if math.isinf(high):
        return f"{format_significant(low)} to {UNBOUNDED_END_TEXT}"
    decimals = _num_decimals(max(abs(low), abs(high)), low, high, 1)
    end_texts = [_format_decimals(end, decimals) for end in (low, high)]
    return end_texts[0] if end_texts[0] == end_texts[1] else " to ".join(end_texts)


def format_significant(value: float, digits: int = 2) -> str:
    """Format a number to `digits` significant digits. Exponents are used only below 1e-6 and from 1e6 upwards."""
    if math.isnan(value):
        return "none"
    text = f"{value:.{digits}g}"
    if "e" not in text or not 1e-6 <= abs(value) < 1e6:
        return text
    rounded = float(text)
    return f"{rounded:.0f}" if abs(rounded) >= 1 else f"{rounded:.{digits + 5}f}".rstrip("0")


def _num_decimals(mean: float, lower: float, upper: float, digits: int) -> int:
    """Return how many decimals to print for `digits` digits of the half-width, and for 2 to 4 digits of the value."""
    value_decimals = -math.floor(math.log10(abs(mean))) if mean else 0
    if not upper > lower:
        return value_decimals + MAX_SIGNIFICANT_DIGITS - 1
    interval_decimals = digits - 1 - math.floor(math.log10((upper - lower) / 2))
    if not mean:
        return interval_decimals
    return min(max(interval_decimals, value_decimals + 1), value_decimals + MAX_SIGNIFICANT_DIGITS - 1)


def format_with_unit(value: float, unit: str) -> str:
    """Format a length (um), pressure (GPa), force (mN) or energy (pJ) to three digits with a suitable prefix."""
    if math.isnan(value):
        return "none"
    factor, name = choose_prefixed_unit(value, unit)
    text = f"{value / factor:.3g}"
    return f"{float(text):g} {name}" if "e" in text else f"{text} {name}"


def choose_prefixed_unit(value: float, unit: str) -> tuple[float, str]:
    """Choose the prefixed unit in which a value has the fewest zeros. Return the conversion factor and the unit."""
    if value == 0:
        return 1.0, unit.replace("um", "µm")
    # Round the value to the printed digits first, so that 0.99996 mN is printed as 1 mN.
    rounded = float(f"{abs(value):.3g}")
    return next((factor, name) for minimum, factor, name in _PREFIXED_UNITS[unit] if rounded >= minimum)


MIN_PRINTED_PERCENTAGE = (
    0.001  # smallest percentage that is printed; smaller percentages are printed as "less than" this number
)


def format_time(seconds: float) -> str:
    """Format a time in the largest unit in which it is at least 1, as in "1.5 h"."""
    factor, unit = next((item for item in _TIME_UNITS if seconds >= item[0]), _TIME_UNITS[-1])
    return f"{seconds / factor:.3g} {unit}"


_TIME_UNITS = ((86400.0, "d"), (3600.0, "h"), (60.0, "min"), (1.0, "s"), (1e-3, "ms"))


def format_percent(fraction: float) -> str:
    """Format a fraction as a percentage, as in "37 %". Percentages below 1 % have two significant digits."""
    if math.isnan(fraction):
        return "none"
    value = 100 * fraction
    if 0 < abs(value) < MIN_PRINTED_PERCENTAGE:
        return f"less than {MIN_PRINTED_PERCENTAGE:g} %"
    return f"{value:.2g} %" if abs(value) < 1 else f"{value:.3g} %" if abs(value) < 10 else f"{value:.0f} %"


def _format_decimals(value: float, digits: int) -> str:
    text = f"{round(value, digits):.{max(digits, 0)}f}"
    return text.removeprefix("-") if float(text) == 0 else text


def to_json(record: Any, **options: Any) -> str:
    """Convert a number for JSON. NaN, infinity and None become None."""
    return json.dumps(_replace_nonfinite_by_none(record), allow_nan=False, **options)


def _replace_nonfinite_by_none(value: Any) -> Any:
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {name: _replace_nonfinite_by_none(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_replace_nonfinite_by_none(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
