"""Formatting of numbers without intervals, in units that suit the size of the number."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeVar

_Item = TypeVar("_Item", bound=tuple[Any, ...])

_PREFIXED_UNITS = {
    "mN": ((1e6, 1e6, "kN"), (1e3, 1e3, "N"), (0.01, 1.0, "mN"), (1e-5, 1e-3, "µN"), (0.0, 1e-6, "nN")),
    "GPa": ((1.0, 1.0, "GPa"), (1e-3, 1e-3, "MPa"), (1e-6, 1e-6, "kPa"), (0.0, 1e-9, "Pa")),
    "um": ((1e6, 1e6, "m"), (1e3, 1e3, "mm"), (1.0, 1.0, "µm"), (0.0, 1e-3, "nm")),
    "pJ": ((1e3, 1e3, "nJ"), (1.0, 1.0, "pJ"), (0.0, 1e-3, "fJ")),
    "um^2": ((1e5, 1e6, "mm²"), (0.0, 1.0, "µm²")),
    "mN/um": ((1e4, 1e3, "N/µm"), (0.0, 1.0, "mN/µm")),
    "MPa/mm": ((1e7, 1e6, "TPa/mm"), (1e4, 1e3, "GPa/mm"), (0.0, 1.0, "MPa/mm")),
    "%": ((0.0, 0.01, "%"),),
}
"""Prefixed units for each core unit: smallest number that is printed in the unit, factor to the core unit, and name."""

_UNPREFIXED_UNITS = ((0.0, 1.0, ""),)


MIN_NUMBER_WITHOUT_EXPONENT, MAX_NUMBER_WITHOUT_EXPONENT = 1e-6, 1e6


def format_significant(value: float, digits: int = 2) -> str:
    """Format a number with `digits` significant digits; use an exponent below 1e-6 and from 1e6 upwards."""
    if math.isnan(value):
        return "none"
    text = f"{value:.{digits}g}"
    if "e" not in text or not MIN_NUMBER_WITHOUT_EXPONENT <= abs(value) < MAX_NUMBER_WITHOUT_EXPONENT:
        return text
    rounded = float(text)
    return f"{rounded:.0f}" if abs(rounded) >= 1 else f"{rounded:.{digits + 5}f}".rstrip("0")


class NumberFormat(NamedTuple):
    """Format for numbers that are at least `minimum` in absolute value: divisor, digits, and text template.

    Attributes
    ----------
    minimum : float
        Smallest absolute value of the numbers.
    factor : float
        Divisor of the number before it is rounded.
    text : str
        Text of the number, in which the digits replace {}.
    digits : int
        Number of significant digits.
    """

    minimum: float
    factor: float
    text: str
    digits: int

    def format(self, value: float) -> str:
        """Divide a number by `factor`, round the quotient, and return `text` with the rounded number inserted."""
        number_text = format_significant(value / self.factor, self.digits)
        return "none" if math.isnan(value) else self.text.replace("{}", number_text)


_PERCENT_FORMATS = (
    NumberFormat(1.0, 0.01, "{} %", 3),
    NumberFormat(0.1, 0.01, "{} %", 2),
    NumberFormat(0.01, 0.01, "{} %", 3),
    NumberFormat(1e-5, 0.01, "{} %", 2),
    NumberFormat(0.0, 0.01, "less than 0.001 %", 2),
)

MIN_NUMBER_ROUNDED_TO_ONE = 0.9995
"""Smallest number that three digits round to 1, so that 0.99996 mN is printed as 1 mN."""


def list_number_formats(kind: str) -> tuple[NumberFormat, ...]:
    """Return the formats for a kind of number, such as "percent", starting with the format for the largest numbers.

    Parameters
    ----------
    kind : str
        "percent" for fractions that are printed in percent, "digits" and "digit" for numbers with two digits and with
        one digit, or a core unit.
    """
    if kind == "percent":
        return _PERCENT_FORMATS
    if kind in ("digits", "digit"):
        return (NumberFormat(0.0, 1.0, "{}", 2 if kind == "digits" else 1),)
    units = _PREFIXED_UNITS.get(kind, _UNPREFIXED_UNITS)
    return tuple(NumberFormat(minimum, factor, f"{{}} {name}".strip(), 3) for minimum, factor, name in units)


def format_number(value: float, kind: str) -> str:
    """Format a number of the given kind, such as "percent", in the format that suits its size."""
    return _choose_item_by_size(value, list_number_formats(kind)).format(value)


def format_with_unit(value: float, unit: str) -> str:
    """Format a length (um), pressure (GPa), force (mN) or energy (pJ) with three digits and a prefixed unit."""
    return format_number(value, unit)


def format_load(load: float, nominal_pressure: float) -> str:
    """Return a load (mN) and its nominal pressure (GPa, or NaN) as text, as in "10 mN (100 MPa)"."""
    pressure_text = "" if math.isnan(nominal_pressure) else f" ({format_with_unit(nominal_pressure, 'GPa')})"
    return f"{format_with_unit(load, 'mN')}{pressure_text}"


def format_percent(fraction: float) -> str:
    """Format a fraction as a percentage, as in "37 %", with two or three significant digits."""
    return format_number(fraction, "percent")


def choose_prefixed_unit(value: float, unit: str) -> tuple[float, str]:
    """Choose a prefixed unit, such as nm or mm, that suits the size of a number. Return factor and unit.

    Parameters
    ----------
    value : float
        Value in the core unit. For 0 and NaN, the core unit is returned.
    unit : str
        Core unit, or "%" for a fraction. For a unit without prefixes, such as "1", the returned name is empty.
    """
    _, factor, name = _choose_item_by_size(value, _PREFIXED_UNITS.get(unit, _UNPREFIXED_UNITS))
    return factor, name


def _choose_item_by_size(value: float, items: Sequence[_Item]) -> _Item:
    """Return the first item whose minimum, `item[0]`, is at most abs(`value`), allowing for rounding to three digits.

    0 and NaN count as 1.
    """
    size = 1.0 if value == 0 or math.isnan(value) else abs(value)
    return next(item for item in items if size >= MIN_NUMBER_ROUNDED_TO_ONE * item[0])


def format_time(seconds: float) -> str:
    """Format a time (s) in the largest unit that gives a number of at least 1, as in "1.5 h"."""
    factor, unit = next((item for item in _TIME_UNITS if seconds >= item[0]), _TIME_UNITS[-1])
    return f"{seconds / factor:.3g} {unit}"


_TIME_UNITS = ((86400.0, "d"), (3600.0, "h"), (60.0, "min"), (1.0, "s"), (1e-3, "ms"))


def to_json(record: Any, **options: Any) -> str:
    """Convert a record to JSON text, in which NaN and infinity become null."""
    return json.dumps(_replace_nonfinite_by_none(record), allow_nan=False, **options)


def _replace_nonfinite_by_none(value: Any) -> Any:
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {name: _replace_nonfinite_by_none(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_replace_nonfinite_by_none(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
