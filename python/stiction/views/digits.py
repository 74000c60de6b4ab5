"""Numbers as text: by as many digits as their interval carries, and in the unit in which they have the fewest zeros."""

from __future__ import annotations

import math

MOST_DIGITS = 4
"""Of any number: nothing here is known better, however narrow its interval."""

HUGE = 100.0
"""Times a value above which the end of its interval is known by its size alone."""

_PREFIXES = {
    "mN": ((1e6, 1e6, "kN"), (1e3, 1e3, "N"), (0.01, 1.0, "mN"), (1e-5, 1e-3, "µN"), (0.0, 1e-6, "nN")),
    "GPa": ((1.0, 1.0, "GPa"), (1e-3, 1e-3, "MPa"), (0.0, 1e-6, "kPa")),
    "um": ((1e3, 1e3, "mm"), (1.0, 1.0, "µm"), (0.0, 1e-3, "nm")),
}
"""Of each unit the least value that is written in it, its factor to core units, and its name."""


def with_interval(mean: float, lower: float, upper: float) -> str:
    """Two digits of half the width of the interval in all three numbers, as in "0.157 [0.102, 0.216]".

    A value that is missing is "none", one without an interval says so, and of one that is exact there is no interval.

    Examples
    --------
    >>> with_interval(0.1552, 0.07024, 0.3431)
    '0.16 [0.07, 0.34]'
    """
    if math.isnan(mean):
        return "none"
    if math.isnan(lower) or math.isnan(upper):
        return f"{mean:.3g} no interval"
    if lower == upper:
        return f"{mean:.{MOST_DIGITS}g}"
    digits = 1 - math.floor(math.log10((upper - lower) / 2))
    if mean != 0:
        digits = min(digits, MOST_DIGITS - 1 - math.floor(math.log10(abs(mean))))
    return _in_brackets(mean, lower, upper, digits)


def two_digits(mean: float, lower: float = math.nan, upper: float = math.nan) -> str:
    """A number to quote: two digits, and its interval with the same; a third where the ends would be one number.

    Examples
    --------
    >>> two_digits(0.2093, 0.1911, 0.2302), two_digits(0.1147, 0.1141, 0.1149)
    ('0.21 [0.19, 0.23]', '0.115 [0.114, 0.115]')
    """
    if math.isnan(mean):
        return "none"
    digits = 1 - math.floor(math.log10(abs(mean))) if mean != 0 else 2
    if math.isnan(lower) or math.isnan(upper):
        return _in_decimals(mean, digits)
    if _in_decimals(lower, digits) == _in_decimals(upper, digits):
        digits += 1
    return _in_brackets(mean, lower, upper, digits)


def from_to(value: float, low: float, high: float) -> str:
    """Between which numbers others lie, by the digits with which a value is quoted.

    Examples
    --------
    >>> from_to(0.2093, 0.0413, 0.188)
    '0.04 to 0.19'
    """
    digits = 1 - math.floor(math.log10(abs(value))) if value else 2
    return f"{_in_decimals(low, digits)} to {_in_decimals(high, digits)}"


def with_unit(value: float, unit: str) -> str:
    """A length (um), pressure (GPa) or force (mN) by three digits, in the unit in which it has the fewest zeros.

    Examples
    --------
    >>> with_unit(0.0005336, "mN"), with_unit(0.05, "GPa"), with_unit(0.039, "um")
    ('0.534 µN', '50 MPa', '39 nm')
    """
    prefixes = _PREFIXES[unit]
    if value == 0:
        return f"0 {unit.replace('um', 'µm')}"
    # As it is shown, by three digits: 0.99996 mN is 1 mN.
    shown_value = float(f"{abs(value):.3g}")
    factor, name = next((factor, name) for least, factor, name in prefixes if shown_value >= least)
    shown = f"{value / factor:.3g}"
    return f"{float(shown):g} {name}" if "e" in shown else f"{shown} {name}"


def percent(fraction: float) -> str:
    """A fraction as percent, by two digits where it is small: "0.42 %", "37 %"."""
    if math.isnan(fraction):
        return "none"
    value = 100 * fraction
    return f"{value:.2g} %" if abs(value) < 1 else f"{value:.3g} %" if abs(value) < 10 else f"{value:.0f} %"


def _in_brackets(mean: float, lower: float, upper: float, digits: int) -> str:
    shown = [_in_decimals(value, digits) for value in (mean, lower, upper)]
    if upper > HUGE * abs(mean) > 0:
        shown[2] = f"{upper:.1g}"
    return f"{shown[0]} [{shown[1]}, {shown[2]}]"


def _in_decimals(value: float, digits: int) -> str:
    text = f"{round(value, digits):.{max(digits, 0)}f}"
    return text.removeprefix("-") if float(text) == 0 else text


def finite(value: float) -> float | None:
    """A number of JSON, which has none that are not finite."""
    return float(value) if math.isfinite(value) else None
