"""Numbers as text: by as many digits as their interval carries, and in the unit in which they have the fewest zeros."""

from __future__ import annotations

import math

MOST_DIGITS = 4  # most significant digits of a value: nothing here is known better, however narrow its interval
NO_END = "\N{INFINITY}"  # upper end of an interval that has none
HUGE = 100.0  # ratio of the upper end of an interval to its value, from which on that end is printed by one digit

_PREFIXES = {
    "mN": ((1e6, 1e6, "kN"), (1e3, 1e3, "N"), (0.01, 1.0, "mN"), (1e-5, 1e-3, "µN"), (0.0, 1e-6, "nN")),
    "GPa": ((1.0, 1.0, "GPa"), (1e-3, 1e-3, "MPa"), (1e-6, 1e-6, "kPa"), (0.0, 1e-9, "Pa")),
    "um": ((1e6, 1e6, "m"), (1e3, 1e3, "mm"), (1.0, 1.0, "µm"), (0.0, 1e-3, "nm")),
    "pJ": ((1e3, 1e3, "nJ"), (1.0, 1.0, "pJ"), (0.0, 1e-3, "fJ")),
}
"""Smallest value that is written with a prefix, its factor to core units, and its name, for each unit."""


def with_interval(mean: float, lower: float, upper: float, *, digits: int = 2) -> str:
    """A value and its interval, by so many digits of half the width in all three: "0.157 [0.102, 0.216]".

    A value has at least two digits and at most four. One that is missing is "none", one without an interval says so,
    and there is no interval where its ends are one number in four digits.
    """
    if math.isnan(mean):
        return "none"
    if math.isnan(lower) or math.isnan(upper):
        return f"{significant(mean, 3)} no interval"
    if math.isinf(upper):
        decimals = _decimals(mean, lower, 2 * mean - lower, digits)
        return f"{_in_decimals(mean, decimals)} [{_in_decimals(lower, decimals)}, {NO_END})"
    decimals = _decimals(mean, lower, upper, digits)
    ends = [_in_decimals(end, decimals) for end in (lower, upper)]
    if ends[0] == ends[1]:
        return significant(mean, MOST_DIGITS)
    if upper > HUGE * abs(mean) > 0:
        ends[1] = significant(upper, 1)
    return f"{_in_decimals(mean, decimals)} [{ends[0]}, {ends[1]}]"


def quoted(mean: float, lower: float = math.nan, upper: float = math.nan) -> str:
    """A number to quote, by one digit of half the width of its interval; by two digits where there is none."""
    if math.isnan(mean):
        return "none"
    if math.isnan(lower) or math.isnan(upper):
        return _in_decimals(mean, _decimals(mean, math.nan, math.nan, 2) - MOST_DIGITS + 2)
    return with_interval(mean, lower, upper, digits=1)


def from_to(low: float, high: float) -> str:
    """Two ends by one digit of half of what is between them, and at least two."""
    if math.isinf(high):
        return f"{significant(low)} to {NO_END}"
    decimals = _decimals(max(abs(low), abs(high)), low, high, 1)
    ends = [_in_decimals(end, decimals) for end in (low, high)]
    return ends[0] if ends[0] == ends[1] else " to ".join(ends)


def significant(value: float, digits: int = 2) -> str:
    """A number by so many significant digits, without zeros at its end or an exponent from 1e-6 to a million."""
    if math.isnan(value):
        return "none"
    text = f"{value:.{digits}g}"
    if "e" not in text or not 1e-6 <= abs(value) < 1e6:
        return text
    rounded = float(text)
    return f"{rounded:.0f}" if abs(rounded) >= 1 else f"{rounded:.{digits + 5}f}".rstrip("0")


def _decimals(mean: float, lower: float, upper: float, digits: int) -> int:
    """Decimals that show so many digits of half the width of an interval, and two to four of its value."""
    size = -math.floor(math.log10(abs(mean))) if mean else 0
    if not upper > lower:
        return size + MOST_DIGITS - 1
    width = digits - 1 - math.floor(math.log10((upper - lower) / 2))
    if not mean:
        return width
    least, most = size + 1, size + MOST_DIGITS - 1
    return min(max(width, least), most)


def with_unit(value: float, unit: str) -> str:
    """A length (um), pressure (GPa), force (mN) or energy (pJ) by three digits, by the prefix of the fewest zeros."""
    if math.isnan(value):
        return "none"
    factor, name = prefix(value, unit)
    shown = f"{value / factor:.3g}"
    return f"{float(shown):g} {name}" if "e" in shown else f"{shown} {name}"


def prefix(value: float, unit: str) -> tuple[float, str]:
    """Factor and name of the unit in which a value has the fewest zeros."""
    if value == 0:
        return 1.0, unit.replace("um", "µm")
    # As it is shown, by three digits: 0.99996 mN is 1 mN.
    shown = float(f"{abs(value):.3g}")
    return next((factor, name) for least, factor, name in _PREFIXES[unit] if shown >= least)


SMALLEST_PERCENT = 0.001  # percentage below which no digit is printed


def duration(seconds: float) -> str:
    """A time in the largest unit of which it has one or more, as in "1.5 h"."""
    factor, unit = next((each for each in _TIMES if seconds >= each[0]), _TIMES[-1])
    return f"{seconds / factor:.3g} {unit}"


_TIMES = ((86400.0, "d"), (3600.0, "h"), (60.0, "min"), (1.0, "s"), (1e-3, "ms"))


def percent(fraction: float) -> str:
    """A fraction as percent, by two digits where it is small: "0.42 %", "37 %"."""
    if math.isnan(fraction):
        return "none"
    value = 100 * fraction
    if 0 < abs(value) < SMALLEST_PERCENT:
        return f"less than {SMALLEST_PERCENT:g} %"
    return f"{value:.2g} %" if abs(value) < 1 else f"{value:.3g} %" if abs(value) < 10 else f"{value:.0f} %"


def _in_decimals(value: float, digits: int) -> str:
    text = f"{round(value, digits):.{max(digits, 0)}f}"
    return text.removeprefix("-") if float(text) == 0 else text


def finite(value: float) -> float | None:
    """A number of JSON, which has none that are not finite."""
    return float(value) if math.isfinite(value) else None
