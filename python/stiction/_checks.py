"""Checks of function arguments: arrays, numbers, names and choices."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Iterable
from numbers import Real
from pathlib import Path
from typing import Any, TypeVar, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._units import quantity, short_repr

Floats = NDArray[np.float64]
_QUANTITY_KINDS_BY_UNIT = {"µm": "length", "GPa": "pressure", "mN": "force", "s": "time", "mN/µm": "work of adhesion"}
"""Kind of quantity for each core unit, such as "length" for µm."""

_Array = TypeVar("_Array", bound=NDArray[Any])


def float_array(name: str, values: ArrayLike, *, ndim: int | None = None) -> Floats:
    """Return numbers as a C-contiguous float64 array, or raise a `ValueError` if a number is infinite or NaN.

    `ndim` is the required number of dimensions; None accepts any number of dimensions.
    """
    if np.ma.is_masked(values):
        raise ValueError(f"{name} must not have masked values; fill or remove them first")
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "iuf" and array.size:
            raise TypeError
        # A long double may overflow to infinity in the conversion; the check below then rejects the array.
        with np.errstate(over="ignore"):
            array = array.astype(np.float64, order="C", copy=False)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} must be an array of real numbers, got {type(values).__name__}") from None
    if ndim is not None and array.ndim != ndim:
        raise ValueError(f"{name} must have {ndim} dimension(s), got shape {array.shape}")
    # A finite sum shows that all elements are finite, faster than a check of each element.
    with np.errstate(over="ignore", invalid="ignore"):
        array_sum = array.sum()
    if not np.isfinite(array_sum) and (is_nonfinite := ~np.isfinite(array)).any():
        first_index = tuple(int(i) for i in np.argwhere(is_nonfinite)[0])
        location = f"{name}{list(first_index)}" if first_index else name
        count_text = f"{np.count_nonzero(is_nonfinite)} of {is_nonfinite.size}"
        raise ValueError(
            f"{name} must be finite, got {array[first_index]} at {location} ({count_text} values are not finite)"
        )
    return array


def make_read_only(array: _Array) -> _Array:
    """Make an array read-only in place, and return the array."""
    array.flags.writeable = False
    return array


def validate_number(
    name: str, value: Any, *, unit: str = "", above: float = -math.inf, below: float = math.inf
) -> float:
    """Return a number as a float, or raise a `ValueError` unless it is finite and strictly between `above` and `below`.

    A zero-dimensional array counts as a number. If a unit is given, a string such as "39 nm" is accepted too.
    """
    argument, value = value, unwrap_scalar(value)
    if isinstance(value, str) and unit in _QUANTITY_KINDS_BY_UNIT:
        try:
            value = float(quantity(value, _QUANTITY_KINDS_BY_UNIT[unit]))
        except ValueError as error:
            raise ValueError(f"{name} {error}") from None
    try:
        number = float(value) if isinstance(value, Real) and not isinstance(value, bool) else math.nan
    except OverflowError:
        number = math.inf
    if not (math.isfinite(number) and above < number < below):
        bounds = [f"above {above:g}"] * (above > -math.inf) + [f"below {below:g}"] * (below < math.inf)
        allowed = " ".join(["a finite number", " and ".join(bounds)]).strip()
        raise ValueError(f"{name} must be {allowed}{f' {unit}' if unit else ''}, got {short_repr(argument)}")
    return number


def unwrap_scalar(value: Any) -> Any:
    """Return the number in a zero-dimensional array, or any other argument unchanged."""
    return value.item() if getattr(value, "ndim", None) == 0 and hasattr(value, "item") else value


def validate_fraction(name: str, value: Any) -> float:
    """Return a number from 0 to 1 as a float. Raise a `ValueError` for any other number."""
    number = validate_number(name, value)
    if not 0 <= number <= 1:
        raise ValueError(f"{name} must be from 0 to 1, got {short_repr(value)}")
    return number


def validate_whole_number(name: str, value: Any, *, minimum: int, maximum: int = 2**63 - 1) -> int:
    """Return a number, or raise a `ValueError` unless it is an integer from `minimum` to `maximum`."""
    try:
        number = operator.index(unwrap_scalar(value)) if not isinstance(unwrap_scalar(value), bool) else minimum - 1
    except TypeError:
        number = minimum - 1
    if not minimum <= number <= maximum:
        limit_text = f" and at most {maximum}" if number > maximum else ""
        raise ValueError(f"{name} must be a whole number of at least {minimum}{limit_text}, got {short_repr(value)}")
    return number


def check_instance(name: str, value: Any, kind: type | tuple[type, ...], words: str) -> None:
    """Raise a `ValueError` unless an argument is an instance of `kind`.

    The message describes `kind` by `words`.
    """
    if not isinstance(value, kind):
        raise ValueError(f"{name} must be {words}, got {type(value).__name__}")


def check_callable(name: str, value: Any) -> None:
    """Raise a `ValueError` unless an argument is callable."""
    if not callable(value):
        raise ValueError(f"{name} must be a function, got {short_repr(value)}")


def parse_path(name: str, value: Any) -> Path:
    """Convert a text to a path, or raise a `ValueError` if no file can have this name."""
    if not isinstance(value, (str, os.PathLike)):
        raise ValueError(f"{name} must be a path, got {type(value).__name__}")
    path = Path(value)
    try:
        is_possible = b"\0" not in os.fsencode(path)
    except UnicodeEncodeError:
        # A text with half of a UTF-16 surrogate pair cannot be encoded, so it cannot be a file name.
        is_possible = False
    if not is_possible:
        raise ValueError(f"{name} must be a path of printable characters, got {short_repr(os.fspath(path))}")
    return path


def parse_names(name: str, value: Any) -> list[str]:
    """Return the list of names in an argument, which is a single name or already a list of names."""
    names = [value] if isinstance(value, str) else value
    names = list(names) if isinstance(names, Iterable) and not isinstance(names, bytes) else [None]
    if not all(isinstance(item, str) for item in names):
        raise ValueError(f"{name} must be a name or a list of names, got {short_repr(value)}")
    return names


def check_choice(name: str, value: Any, literal: Any) -> None:
    """Raise a `ValueError` unless an argument is one of the strings that a `Literal` type allows."""
    allowed = get_args(literal)
    value = unwrap_scalar(value)
    if not (isinstance(value, str) and value in allowed):
        names = ", ".join(repr(item) for item in allowed)
        raise ValueError(f"{name} must be one of {names}, got {short_repr(value)}")


def check_bool(name: str, value: Any) -> None:
    """Raise a `ValueError` unless an argument is True or False.

    The numbers 0 and 1 are rejected.
    """
    if not isinstance(unwrap_scalar(value), bool):
        raise ValueError(f"{name} must be True or False, got {short_repr(value)}")
