"""Quantities at the edges: "number unit" wherever people write them, plain numbers in core units inside."""

from __future__ import annotations

import re
from decimal import Decimal
from typing import Any

_UNITS = {
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
"""Factors to µm, GPa, mN, s and mN/µm; both Unicode spellings of micro."""

MAGNITUDES = {
    "length": (1e-6, 1e6), "pressure": (1e-9, 1e4), "force": (1e-12, 1e12), "time": (1e-3, 1e10),
    "work of adhesion": (1e-9, 1),
}  # fmt: skip
"""Magnitudes in µm, GPa, mN, s and mN/µm; what is outside is a slip of the unit."""

_QUANTITY = re.compile(
    r"\s*([+-]?(?:[0-9][0-9_]{0,20}\.?[0-9]{0,20}|\.[0-9]{1,20})(?:[eE][+-]?[0-9]{1,2})?)\s*([^\W0-9_]+(?:/m(?:\^2|²)?)?)\s*"
)


_TOO_LONG = re.compile(r"\s*[+-]?(?:[0-9._]+(?:[eE][+-]?[0-9]+)?|inf|nan)\s*([^\W0-9_]+(?:/m(?:\^2|²)?)?)\s*")
"""A number with a unit whose number has more digits, or a larger exponent, than any quantity."""


def units_of(kind: str) -> tuple[str, ...]:
    """Names of the units of a kind of quantity."""
    return tuple(_UNITS[kind])


class Quantity(float):
    """A number in core units (µm, GPa, mN) that remembers how it was written. Equal if the numbers are."""

    text: str

    def __new__(cls, value: float, text: str) -> Quantity:
        """Value in core units, and the text it stands for."""
        quantity = super().__new__(cls, value)
        quantity.text = text
        return quantity

    def __getnewargs__(self) -> tuple[float, str]:  # type: ignore[override]
        return float(self), self.text


def quantity(text: object, kind: str) -> Quantity:
    """Read "number unit", such as "200 MPa", of a kind: "length", "pressure", "force" or "work of adhesion".

    Raises a `ValueError` if the text is not a number with a unit of that kind.
    """
    if isinstance(text, Quantity):
        return text
    units = _UNITS[kind]
    allowed = ", ".join(unit for unit in units if unit.isascii())
    if not isinstance(text, str):
        raise ValueError(
            f'needs a {kind} with its unit, as in "1 {next(iter(units))}" ({allowed}), got {shortened(text)}'
        )
    match = _QUANTITY.fullmatch(text)
    lowest, highest = MAGNITUDES[kind]
    core = next(name for name, factor in units.items() if factor == "1")
    if match is None and (other := _TOO_LONG.fullmatch(text)) is not None and other[1] in units:
        raise ValueError(f"must be from {lowest:g} to {highest:g} {core}, got {shortened(text)}")
    if match is None:
        raise ValueError(f'must be "number unit" with a unit of {kind} ({allowed}), got {shortened(text)}')
    digits, unit = match.groups()
    if unit not in units:
        near = [each for each in units if each.lower() == unit.lower()]
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        raise ValueError(f"has the unit {unit!r}, which is not one of {kind} ({allowed}), in {shortened(text)}{hint}")
    # In decimal, so that "100 nm" and "0.1 um" are the same number.
    value = float(Decimal(digits.replace("_", "")) * Decimal(units[unit]))
    if value != 0 and not lowest <= abs(value) <= highest:
        raise ValueError(f"must be from {lowest:g} to {highest:g} {core}, got {shortened(text)}")
    return Quantity(value, f"{digits} {unit}")


def in_core_units(name: str, value: Any, kind: str) -> Any:
    """What may be text with a unit as numbers in core units: one text, several in a list, or numbers as they are.

    A text that is not a number with a unit of that kind is a `ValueError` that calls the argument by its name.
    """
    if isinstance(value, str):
        try:
            return float(quantity(value, kind))
        except ValueError as error:
            raise ValueError(f"{name} {error}") from None
    if isinstance(value, (list, tuple)) and any(isinstance(each, str) for each in value):
        return [in_core_units(name, each, kind) for each in value]
    return value


def loads_in_core_units(name: str, value: Any, area: float) -> Any:
    """Loads as text with a unit, of force or of pressure on an area (µm²), in mN; numbers as they are.

    A text that is neither is a `ValueError`.
    """
    if isinstance(value, (list, tuple)):
        return [loads_in_core_units(name, each, area) for each in value]
    if not isinstance(value, str):
        return value
    for kind, factor in (("force", 1.0), ("pressure", area)):
        try:
            return float(f"{quantity(value, kind) * factor:.12g}")  # without digits that nobody asked for
        except ValueError:
            continue
    raise ValueError(f'{name} must be a force or a pressure with its unit, as in "10 mN" or "10 MPa", got {value!r}')


def exactly(value: float, unit: str) -> str:
    """A number and its unit as text from which `quantity` reads the same number to the last bit."""
    return f"{repr(float(value)).removesuffix('.0')} {unit}"


def exact(value: float, unit: str) -> Quantity:
    """A number in core units as a quantity, whatever its magnitude."""
    return Quantity(value, exactly(value, unit))


def shortened(value: object) -> str:
    """Text of a value for a message, of a length that fits a line."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # Python prints no integers of many thousand digits, and no deep tables
        text = type(value).__name__
    return text if len(text) <= 40 else text[:37] + "..."
