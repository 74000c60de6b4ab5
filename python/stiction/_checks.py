"""What every public function asks of its arguments: one place for arrays, one for numbers, one for choices."""

from __future__ import annotations

import math
import operator
from numbers import Real
from typing import Any, TypeVar, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._units import quantity, shortened

Floats = NDArray[np.float64]
_KINDS = {"µm": "length", "GPa": "pressure", "mN": "force", "s": "time", "mN/µm": "work of adhesion"}
"""Kind of a quantity by the unit in which a number of it is."""

_Array = TypeVar("_Array", bound=NDArray[Any])


def float_array(name: str, values: ArrayLike, *, ndim: int | None = None) -> Floats:
    """A float64 C-contiguous array of finite real values, with `ndim` dimensions or any."""
    if np.ma.is_masked(values):
        raise ValueError(f"{name} has masked values; fill or remove them first")
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "iuf" and array.size:
            raise TypeError
        with np.errstate(over="ignore"):  # of longer floats: then they are infinite
            array = array.astype(np.float64, order="C", copy=False)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} must be an array of real numbers, got {type(values).__name__}") from None
    if ndim is not None and array.ndim != ndim:
        raise ValueError(f"{name} must have {ndim} dimension(s), got shape {array.shape}")
    # A sum of finite numbers is finite but for an overflow, and is faster than asking each.
    with np.errstate(over="ignore", invalid="ignore"):
        total = array.sum()
    if not np.isfinite(total) and (bad := ~np.isfinite(array)).any():
        first = tuple(int(i) for i in np.argwhere(bad)[0])
        where = f"{name}{list(first)}" if first else name
        raise ValueError(f"{name} must be finite, but {where} is {array[first]} ({int(bad.sum())} such values)")
    return array


def read_only(array: _Array) -> _Array:
    """The array itself, no longer writeable."""
    array.flags.writeable = False
    return array


def number(name: str, value: Any, *, unit: str = "", above: float = -math.inf, below: float = math.inf) -> float:
    """A finite float strictly between `above` and `below`.

    An array without dimensions counts as a number, and so does a text such as "39 nm" where the number has a unit.
    """
    given, value = value, scalar(value)
    if isinstance(value, str) and unit in _KINDS:
        try:
            value = float(quantity(value, _KINDS[unit]))
        except ValueError as error:
            raise ValueError(f"{name} {error}") from None
    try:
        result = float(value) if isinstance(value, Real) and not isinstance(value, bool) else math.nan
    except OverflowError:
        result = math.inf
    if not (math.isfinite(result) and above < result < below):
        bounds = [f"above {above:g}"] * (above > -math.inf) + [f"below {below:g}"] * (below < math.inf)
        allowed = " ".join(["a finite number", " and ".join(bounds)]).strip()
        raise ValueError(f"{name} must be {allowed}{f' {unit}' if unit else ''}, got {shortened(given)}")
    return result


def scalar(value: Any) -> Any:
    """Return the number or text in an array without dimensions, and any other value unchanged."""
    return value.item() if getattr(value, "ndim", None) == 0 and hasattr(value, "item") else value


def part_of_one(name: str, value: Any) -> float:
    """A number from 0 to 1."""
    part = number(name, value)
    if not 0 <= part <= 1:
        raise ValueError(f"{name} must be from 0 to 1, got {value!r}")
    return part


def whole_number(name: str, value: Any, *, least: int, most: int = 2**63 - 1) -> int:
    """An integer from `least` to `most`."""
    try:
        result = operator.index(scalar(value)) if not isinstance(scalar(value), bool) else least - 1
    except TypeError:
        result = least - 1
    if not least <= result <= most:
        limit = f" and at most {most}" if result > most else ""
        raise ValueError(f"{name} must be a whole number of at least {least}{limit}, got {shortened(value)}")
    return result


def choice(name: str, value: Any, literal: Any) -> None:
    """One of the strings of a `Literal`."""
    allowed = get_args(literal)
    value = scalar(value)
    if not (isinstance(value, str) and value in allowed):
        names = ", ".join(repr(item) for item in allowed)
        raise ValueError(f"{name} must be one of {names}, got {shortened(value)}")


def truth(name: str, value: Any) -> None:
    """True or False, and nothing that may be taken for one of them."""
    if not isinstance(scalar(value), bool):
        raise ValueError(f"{name} must be True or False, got {shortened(value)}")
