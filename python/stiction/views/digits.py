"""Numbers with their intervals, by as many digits as the interval carries."""

from __future__ import annotations

import math

MOST_DIGITS = 4
"""Of any number: nothing here is known better, however narrow its interval."""


def with_interval(mean: float, lower: float, upper: float) -> str:
    """Two digits of half the width of the interval in all three numbers, as in "0.157 [0.102, 0.216]".

    A value that is missing is "none", and one without an interval says so.
    """
    if math.isnan(mean):
        return "none"
    if math.isnan(lower) or math.isnan(upper):
        return f"{mean:.3g} no interval"
    digits = 1 - math.floor(math.log10((upper - lower) / 2)) if upper > lower else 4
    if mean != 0:
        digits = min(digits, MOST_DIGITS - 1 - math.floor(math.log10(abs(mean))))
    shown = [f"{round(value, digits):.{max(digits, 0)}f}" for value in (mean, lower, upper)]
    return f"{shown[0]} [{shown[1]}, {shown[2]}]"
