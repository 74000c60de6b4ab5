"""Quantities with units, and conversion of texts such as "200 MPa" to numbers in core units."""

from __future__ import annotations

import re
from decimal import Decimal
from typing import Any

_UNIT_FACTORS = {
    "length": {"m": "1e6", "mm": "1e3", "um": "1", "µm": "1", "μm": "1", "nm": "1e-3", "pm": "1e-6"},
    "pressure": {"TPa": "1e3", "GPa": "1", "MPa": "1e-3", "kPa": "1e-6", "Pa": "1e-9"},
    "force": {"kN": "1e6", "N": "1e3", "mN": "1", "uN": "1e-3", "µN": "1e-3", "μN": "1e-3", "nN": "1e-6"},
    "time": {"s": "1", "ms": "1e-3", "min": "60", "h": "3600", "d": "86400"},
    "work of adhesion": {
        name.replace("/m^2", square): factor
        for square in ("/m^2", "/m²")
        for name, factor in (("mJ/m^2", "1e-6"), ("J/m^2", "1e-3"), ("kJ/m^2", "1"), ("mN/m", "1e-6"), ("N/m", "1e-3"))
    },
}
"""Factors to the core units µm, GPa, mN, s and mN/µm. Both Unicode characters for micro are accepted."""

VALID_QUANTITY_RANGES = {
    "length": (1e-6, 1e6), "pressure": (1e-9, 1e4), "force": (1e-12, 1e12), "time": (1e-3, 1e10),
    "work of adhesion": (1e-9, 1),
}  # fmt: skip
"""Minimum and maximum magnitude of each kind of quantity. Beyond these limits, the unit is usually wrong."""

_QUANTITY_PATTERN = re.compile(
    r"\s*([+-]?(?:[0-9][0-9_]{0,20}\.?[0-9]{0,20}|\.[0-9]{1,20})(?:[eE][+-]?[0-9]{1,2})?)\s*([^\W0-9_]+(?:/m(?:\^2|²)?)?)\s*"
)


_NUMBER_WITH_UNIT_PATTERN = re.compile(
    r"\s*[+-]?(?:[0-9._]+(?:[eE][+-]?[0-9]+)?|inf|nan)\s*([^\W0-9_]+(?:/m(?:\^2|²)?)?)\s*"
)
"""Pattern of a number with a unit, even with more digits or a larger exponent than a valid quantity has."""

_RANGE_OF_NUMBERS_PATTERN = re.compile(r"[0-9]\s*[^\W0-9_]*\s*\.\.\s*[0-9]")
"""Pattern of a range of numbers in a text, such as "1..5 um"."""


def unit_names(kind: str) -> tuple[str, ...]:
    """Return the names of units that are accepted for a kind of quantity, such as "pressure"."""
    return tuple(_UNIT_FACTORS[kind])


class Quantity(float):
    """Number in core units (µm, GPa, mN), stored with the text from which the number was parsed.

    Comparisons ignore the text.
    """

    text: str

    def __new__(cls, value: float, text: str) -> Quantity:
        """Create a quantity from a number in core units and its text, such as "200 MPa"."""
        quantity = super().__new__(cls, value)
        quantity.text = text
        return quantity

    def __getnewargs__(self) -> tuple[float, str]:  # type: ignore[override]
        return float(self), self.text


def quantity(text: object, kind: str) -> Quantity:
    """Parse a number with a unit, such as "200 MPa".

    The unit must belong to the kind of quantity, such as "pressure".

    Raises a `ValueError` if the text is not a number with such a unit.
    """
    if isinstance(text, Quantity):
        return text
    units = _UNIT_FACTORS[kind]
    allowed = ", ".join(unit for unit in units if unit.isascii())
    if not isinstance(text, str):
        raise ValueError(
            f'must be a {kind} with its unit, as in "1 {next(iter(units))}" ({allowed}), got {short_repr(text)}'
        )
    match = _QUANTITY_PATTERN.fullmatch(text)
    lowest, highest = VALID_QUANTITY_RANGES[kind]
    if match is None and _RANGE_OF_NUMBERS_PATTERN.search(text):
        raise ValueError(f"must be one number with a unit of {kind}, not a range, got {short_repr(text)}")
    if (
        match is None
        and (number_match := _NUMBER_WITH_UNIT_PATTERN.fullmatch(text)) is not None
        and number_match[1] in units
    ):
        raise ValueError(f"must be from {lowest:g} to {highest:g} {_find_unit_in_core(kind)}, got {short_repr(text)}")
    if match is None:
        raise ValueError(f"must be a number with a unit of {kind} ({allowed}), got {short_repr(text)}")
    digits, unit = match.groups()
    if unit not in units:
        similar_units = [name for name in units if name.lower() == unit.lower()]
        hint = f"; did you mean {' or '.join(similar_units)}?" if similar_units else ""
        raise ValueError(
            f"has the unit {unit!r}, which is not a unit of {kind} ({allowed}), got {short_repr(text)}{hint}"
        )
    # With decimal arithmetic, "100 nm" and "0.1 um" give exactly the same number in core units.
    value = float(Decimal(digits.replace("_", "")) * Decimal(units[unit]))
    return _check_magnitude(Quantity(value, f"{digits} {unit}"), kind, text)


def quantity_in_core_units(value: float, kind: str) -> Quantity:
    """Convert a number in core units to a `Quantity` of the given kind, such as "pressure".

    Raises a `ValueError` if the number is implausibly small or large.
    """
    text = exact_quantity_text(value, _find_unit_in_core(kind))
    return _check_magnitude(Quantity(value, text), kind, text)


def _find_unit_in_core(kind: str) -> str:
    """Return the core unit of the given kind of quantity, such as "GPa" for "pressure"."""
    return next(name for name, factor in _UNIT_FACTORS[kind].items() if factor == "1")


def _check_magnitude(value: Quantity, kind: str, text: str) -> Quantity:
    lowest, highest = VALID_QUANTITY_RANGES[kind]
    magnitude = abs(float(value))
    if magnitude != 0 and not lowest <= magnitude <= highest:
        raise ValueError(f"must be from {lowest:g} to {highest:g} {_find_unit_in_core(kind)}, got {short_repr(text)}")
    return value


def to_core_units(name: str, value: Any, kind: str) -> Any:
    """Convert texts with units, alone or in lists, to numbers in core units.

    Numbers are returned unchanged.

    Raises a `ValueError` that names the argument if a string is not a number with a unit of this kind.
    """
    if isinstance(value, str):
        try:
            return float(quantity(value, kind))
        except ValueError as error:
            raise ValueError(f"{name} {error}") from None
    if isinstance(value, (list, tuple)) and any(isinstance(item, str) for item in value):
        return [to_core_units(name, item, kind) for item in value]
    return value


def loads_to_core_units(name: str, value: Any, area: float) -> Any:
    """Convert loads to mN: forces such as "10 mN", or pressures such as "10 MPa" on an area of `area` µm².

    Raises a `ValueError` if a string is neither a force nor a pressure.
    """
    if isinstance(value, (list, tuple)):
        return [loads_to_core_units(name, item, area) for item in value]
    if not isinstance(value, str):
        return value
    for kind, factor in (("force", 1.0), ("pressure", area)):
        try:
            # The force is rounded to twelve digits, which removes the round-off of the unit conversion.
            return float(f"{quantity(value, kind) * factor:.12g}")
        except ValueError:
            continue
    raise ValueError(f'{name} must be a force or a pressure with its unit, as in "10 mN" or "10 MPa", got {value!r}')


def is_pressure(value: Any) -> bool:
    """Return whether an argument is a text that contains a number with a unit of pressure."""
    if not isinstance(value, str):
        return False
    try:
        quantity(value, "pressure")
    except ValueError:
        return False
    return True


def exact_quantity_text(value: float, unit: str) -> str:
    """Return a number and its unit as text with all digits, so that `quantity` parses exactly this number."""
    return f"{repr(float(value)).removesuffix('.0')} {unit}"


def exact_quantity(value: float, unit: str) -> Quantity:
    """Convert a number in core units to a `Quantity`, without checking whether the number is plausible."""
    return Quantity(value, exact_quantity_text(value, unit))


def short_repr(value: object) -> str:
    """Return the `repr` of an argument for a message, shortened to a single line."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):
        # `repr` raises an error for integers of thousands of digits and for deeply nested containers.
        text = type(value).__name__
    # The `repr` of an array or of a result has several lines, which would break up the message.
    if "\n" in text:
        text = " ".join(text.split())
    return text if len(text) <= 40 else text[:37] + "..."
