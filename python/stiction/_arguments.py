"""Parsing of function arguments that are numbers or texts with units."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from stiction._checks import validate_number
from stiction._errors import ArgumentError
from stiction._units import Quantity, quantity, quantity_in_core_units, short_repr, to_core_units, unit_names


def split_values(value: Any) -> list[Any]:
    """Split a text, or each text in a list, at the commas, and return all parts in one flat list.

    An argument that is neither a text nor a one-dimensional list is the only item.
    """
    if isinstance(value, str):
        return [item.strip() for item in value.split(",")]
    is_sequence = isinstance(value, (list, tuple, range, np.ndarray)) and _count_dimensions(value) == 1
    return [item for element in value for item in split_values(element)] if is_sequence else [value]


def _count_dimensions(value: Any) -> int | None:
    try:
        return np.ndim(value)
    except ValueError:
        # NumPy raises ValueError for a nested sequence whose rows have different lengths.
        return None


def _split_required_values(name: str, value: Any) -> list[Any]:
    values = split_values(value)
    if not values:
        raise ArgumentError(f"{{{name}}} must have at least one value, got {{got}}", got=short_repr(value))
    return values


def parse_quantity(name: str, value: Any, kind: str) -> Quantity:
    """Parse an argument as a quantity, such as a pressure. A bare number is in core units (µm, GPa, mN)."""
    try:
        return (
            quantity(value, kind)
            if isinstance(value, str)
            else quantity_in_core_units(validate_number("", value), kind)
        )
    except ValueError as error:
        raise ArgumentError.for_argument(name, str(error).strip()) from None


def parse_quantities(name: str, value: Any, kind: str) -> list[Quantity]:
    """Parse one or more quantities of the kind `kind`, such as "pressure", from an argument."""
    reject_decimal_commas(name, value)
    return [parse_quantity(name, item, kind) for item in _split_required_values(name, value)]


def contains_text(value: Any) -> bool:
    """Return whether an argument is a text, or a list or tuple with a text."""
    return isinstance(value, str) or (isinstance(value, (list, tuple)) and any(isinstance(item, str) for item in value))


def split_texts(name: str, value: Any) -> Any:
    """Split a text, or each text in a list, at its commas. Return an argument without texts unchanged.

    Raises an `ArgumentError` if a comma may be a decimal mark.
    """
    if not contains_text(value):
        return value
    reject_decimal_commas(name, value)
    items = split_values(value)
    return value if len(items) == 1 and isinstance(value, str) else items


def convert_friction_parameters(mu0: Any, tau0: Any) -> tuple[Any, Any]:
    """Convert mu0 and tau0 (GPa) from texts to numbers. Return arguments that are numbers or None unchanged."""
    return (
        parse_coefficients("mu0", mu0) if contains_text(mu0) else mu0,
        to_core_units("tau0", split_texts("tau0", tau0), "pressure"),
    )


_DECIMAL_COMMA_PATTERN = re.compile(r"(?<![\d.])\d+,\d+(?!\d|\.(?!\.))")
"""Pattern of a comma that may be a decimal mark, as in "0,2" or "0,2..0,3" but not in "0, 2" or "0.2,0.3"."""


def reject_decimal_commas(name: str, value: Any) -> None:
    """Raise an `ArgumentError` if a text contains a comma that may be a decimal mark."""
    for item in value if isinstance(value, (list, tuple)) else [value]:
        if isinstance(item, str) and (match := _DECIMAL_COMMA_PATTERN.search(item)):
            as_decimal, as_list = match[0].replace(",", "."), match[0].replace(",", ", ")
            raise ArgumentError(
                f'{{{name}}} must not have a comma between digits, got {{got}}; write "{as_decimal}" for one number '
                f'or "{as_list}" for two', got=short_repr(item),
            )  # fmt: skip


def parse_numbers(name: str, value: Any, *, integers: bool = False) -> list[float]:
    """Parse an argument as a list of numbers. The argument is a number, a list, or a text with commas.

    If `integers` is true, commas always separate numbers: "0,90" is 0 and 90.
    """
    if not integers:
        reject_decimal_commas(name, value)
    try:
        return [
            float(item) if isinstance(item, str) else validate_number("", item)
            for item in _split_required_values(name, value)
        ]
    except ArgumentError:
        raise
    except ValueError:
        raise ArgumentError(
            f'{{{name}}} must be one or more numbers, as in "0.3,0.4", got {{got}}', got=short_repr(value)
        ) from None


MAX_INPUT_NUMBER = 1e6
"""Largest accepted coefficient, percentage or limit of a range. Larger numbers are rejected as mistakes."""


def parse_coefficients(name: str, value: Any) -> list[float]:
    """Parse one or more numbers from an argument, and reject numbers below 0 or above `MAX_INPUT_NUMBER`."""
    numbers = parse_numbers(name, value)
    if any(item < 0 for item in numbers):
        raise ArgumentError(f"{{{name}}} must be at least 0, got {{got}}", got=short_repr(value))
    if not all(0 <= item <= MAX_INPUT_NUMBER for item in numbers):
        raise ArgumentError(
            f"{{{name}}} must be finite and from 0 to {MAX_INPUT_NUMBER:g}, got {{got}}", got=short_repr(value)
        )
    return numbers


def validate_nonnegative_values(name: str, values: list[Any], argument: Any) -> list[Any]:
    """Return the numbers in a list, or raise an `ArgumentError` if one of these numbers is negative."""
    if not all(value >= 0 for value in values):
        raise ArgumentError(f"{{{name}}} must be at least 0, got {{got}}", got=short_repr(argument))
    return values


def parse_load(name: str, value: Any, *, or_zero: bool = False) -> tuple[Quantity, bool]:
    """Parse a load. Return it with a flag that is True for a pressure and False for a force.

    A number without a unit is a force in mN. A pressure acts on the slider.
    The load must be above 0 or, if `or_zero` is True, at least 0.
    """
    reject_decimal_commas(name, value)
    load_kinds = ("force", "pressure")
    if isinstance(value, str) and value.strip() == "0":
        load, kind = parse_quantity(name, 0.0, "force"), "force"
    elif not isinstance(value, str):
        load, kind = parse_quantity(name, value, "force"), "force"
    else:
        unit = value.strip().lstrip("+-0123456789._eE ")
        kind = next((kind for kind in load_kinds if unit in unit_names(kind)), "")
        if not kind:
            allowed = "; ".join(
                ", ".join(unit_name for unit_name in unit_names(kind) if unit_name.isascii()) for kind in load_kinds
            )
            raise ArgumentError(
                f'{{{name}}} must be a force or a pressure with its unit, as in "10 mN" or "10 MPa" ({allowed}), '
                "got {got}", got=short_repr(value),
            )  # fmt: skip
        load = parse_quantity(name, value, kind)
    if not (load > 0 or (or_zero and load >= 0)):
        zero_load_hint = "" if load else "; a load of 0 is for bodies that adhere"
        raise ArgumentError(f"{{{name}}} must be above 0, got {{got}}{zero_load_hint}", got=short_repr(value))
    return load, kind == "pressure"
