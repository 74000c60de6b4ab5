"""Formatting of numbers without an interval. The magnitude of a number determines its unit."""

from __future__ import annotations

import json
import math
from typing import Any

_PREFIXED_UNITS = {
    "mN": ((1e6, 1e6, "kN"), (1e3, 1e3, "N"), (0.01, 1.0, "mN"), (1e-5, 1e-3, "µN"), (0.0, 1e-6, "nN")),
    "GPa": ((1.0, 1.0, "GPa"), (1e-3, 1e-3, "MPa"), (1e-6, 1e-6, "kPa"), (0.0, 1e-9, "Pa")),
    "um": ((1e6, 1e6, "m"), (1e3, 1e3, "mm"), (1.0, 1.0, "µm"), (0.0, 1e-3, "nm")),
    "pJ": ((1e3, 1e3, "nJ"), (1.0, 1.0, "pJ"), (0.0, 1e-3, "fJ")),
    "um^2": ((1e5, 1e6, "mm²"), (0.0, 1.0, "µm²")),
    "mN/um": ((1e4, 1e3, "N/µm"), (0.0, 1.0, "mN/µm")),
    "MPa/mm": ((1e7, 1e6, "TPa/mm"), (1e4, 1e3, "GPa/mm"), (0.0, 1.0, "MPa/mm")),
    "GPa/mm": ((1e4, 1e3, "TPa/mm"), (0.0, 1.0, "GPa/mm")),
    "%": ((0.0, 0.01, "%"),),
}
"""Prefixed units of each core unit: smallest value to be printed in the unit, factor to the core unit, and name."""


def format_significant(value: float, digits: int = 2) -> str:
    """Format a number to `digits` significant digits. Exponents are used only below 1e-6 and from 1e6 upwards."""
    if math.isnan(value):
        return "none"
    text = f"{value:.{digits}g}"
    if "e" not in text or not 1e-6 <= abs(value) < 1e6:
        return text
    rounded = float(text)
    return f"{rounded:.0f}" if abs(rounded) >= 1 else f"{rounded:.{digits + 5}f}".rstrip("0")


def format_with_unit(value: float, unit: str) -> str:
    """Format a length (um), pressure (GPa), force (mN) or energy (pJ) to three digits with a suitable prefix."""
    if math.isnan(value):
        return "none"
    factor, name = choose_prefixed_unit(value, unit)
    text = f"{value / factor:.3g}"
    return f"{float(text):g} {name}" if "e" in text else f"{text} {name}"


def list_prefixed_units(unit: str) -> tuple[tuple[float, float, str], ...]:
    """Return the smallest value, the factor and the name of each prefixed unit of a core unit, in descending order."""
    return _PREFIXED_UNITS.get(unit, ((0.0, 1.0, ""),))


def choose_prefixed_unit(value: float, unit: str) -> tuple[float, str]:
    """Choose the prefixed unit in which a value has the fewest zeros. Return the conversion factor and the unit.

    Parameters
    ----------
    value : float
        Value in the core unit. For 0 and NaN, the core unit is returned.
    unit : str
        Core unit, or "%" for a fraction. For a unit without prefixes, such as "1", the returned name is empty.
    """
    units = list_prefixed_units(unit)
    if value == 0 or math.isnan(value):
        return next(((factor, name) for _, factor, name in units if factor == 1), units[0][1:])
    # Round the value to the printed digits first, so that 0.99996 mN is printed as 1 mN.
    rounded = float(f"{abs(value):.3g}")
    return next((factor, name) for minimum, factor, name in units if rounded >= minimum)


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
