"""Arguments that people write as numbers or as texts with units."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from stiction._checks import number
from stiction._errors import ArgumentError
from stiction._units import Quantity, exactly, quantity, shortened, units_of

_CORE = {"length": "um", "pressure": "GPa", "force": "mN", "time": "s", "work of adhesion": "kJ/m^2"}
"""Unit of a plain number of each kind."""


def listed(value: Any) -> list[Any]:
    """The values of one or several: parts of a text between commas, elements of a list, or the value alone."""
    if isinstance(value, str):
        return [part.strip() for part in value.split(",")]
    several = isinstance(value, (list, tuple, range, np.ndarray)) and np.ndim(value) == 1
    return [part for each in value for part in listed(each)] if several else [value]


def _several(name: str, value: Any) -> list[Any]:
    values = listed(value)
    if not values:
        raise ArgumentError(f"{{{name}}} must have at least one value, got {{got}}", got=repr(value))
    return values


def quantity_of(name: str, value: Any, kind: str) -> Quantity:
    """A quantity of a kind: a text with its unit, or a number in core units."""
    try:
        return quantity(value if isinstance(value, str) else exactly(number("", value), _CORE[kind]), kind)
    except ValueError as error:
        raise ArgumentError(f"{{{name}}} {{why}}", why=str(error).strip()) from None


def quantities_of(name: str, value: Any, kind: str) -> list[Quantity]:
    """Return one or several quantities of a kind."""
    reject_decimal_commas(name, value)
    return [quantity_of(name, each, kind) for each in _several(name, value)]


_DECIMAL_COMMA = re.compile(r"(?<![\d.])\d+,\d+(?![\d.])")
"""A comma between two whole numbers, which may be a decimal comma: "0,2", but not "0, 2" or "0.2,0.3"."""


def reject_decimal_commas(name: str, value: Any) -> None:
    """Raise an error if a text has a comma that may be a decimal comma."""
    for each in value if isinstance(value, (list, tuple)) else [value]:
        if isinstance(each, str) and (found := _DECIMAL_COMMA.search(each)):
            one, two = found[0].replace(",", "."), found[0].replace(",", ", ")
            raise ArgumentError(
                f'{{{name}}} has a comma between digits: write "{one}" for one number or "{two}" for two, '
                "got {got}", got=repr(each),
            )  # fmt: skip


def numbers_of(name: str, value: Any, *, whole: bool = False) -> list[float]:
    """Return one or several numbers, given as such or as text; a comma in "0,90" separates `whole` numbers."""
    if not whole:
        reject_decimal_commas(name, value)
    try:
        return [float(each) if isinstance(each, str) else number("", each) for each in _several(name, value)]
    except ArgumentError:
        raise
    except ValueError:
        raise ArgumentError(
            f'{{{name}}} must be a number or several, as in "0.3,0.4", got {{got}}', got=repr(value)
        ) from None


MAX_NUMBER = 1e6
"""Largest coefficient, percentage and end of a range that is no slip."""


def coefficients_of(name: str, value: Any) -> list[float]:
    """Return one or several numbers from 0 to `MAX_NUMBER`."""
    numbers = numbers_of(name, value)
    if any(each < 0 for each in numbers):
        raise ArgumentError(f"{{{name}}} must be at least 0, got {{got}}", got=repr(value))
    if not all(0 <= each <= MAX_NUMBER for each in numbers):
        raise ArgumentError(
            f"{{{name}}} must be finite and from 0 to {MAX_NUMBER:g}, got {{got}}", got=shortened(value)
        )
    return numbers


def at_least_0(name: str, values: list[Any], given: Any) -> list[Any]:
    """The values of an argument, none of which may be negative."""
    if not all(value >= 0 for value in values):
        raise ArgumentError(f"{{{name}}} must be at least 0, got {{got}}", got=repr(given))
    return values


def load_of(name: str, value: Any, *, or_zero: bool = False) -> tuple[Quantity, bool]:
    """A load above 0, or 0 as well, in mN or in GPa of the slider's area, and whether it is that; a number is mN."""
    reject_decimal_commas(name, value)
    kinds = ("force", "pressure")
    if isinstance(value, str) and value.strip() == "0":  # needs no unit
        value = 0.0
    if not isinstance(value, str):
        load, kind = quantity_of(name, value, "force"), "force"
    else:
        unit = value.strip().lstrip("+-0123456789._eE ")
        kind = next((kind for kind in kinds if unit in units_of(kind)), "")
        if not kind:
            allowed = "; ".join(", ".join(each for each in units_of(kind) if each.isascii()) for kind in kinds)
            raise ArgumentError(
                f'{{{name}}} must be a force or a pressure with its unit, as in "10 mN" or "10 MPa" ({allowed}), '
                "got {got}", got=repr(value),
            )  # fmt: skip
        load = quantity_of(name, value, kind)
    if not (load > 0 or (or_zero and load >= 0)):
        raise ArgumentError(f"{{{name}}} must be above 0, got {{got}}", got=repr(value))
    return load, kind == "pressure"
