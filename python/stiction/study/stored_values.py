"""Validation of the variables and attributes in stored files.

A file with a correct checksum may still contain values that no computation returns, for example if another program
changed the file. When a file is read, its variables and attributes are compared with their specifications.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.mechanics.quantities import MAX_STORED_VALUE

MIN_POSITIVE_STORED_VALUE = 1 / MAX_STORED_VALUE
"""Smallest positive number of a stored load, area or length. Quotients of stored numbers are then finite."""

STORED_VALUE_BOUNDS = (-MAX_STORED_VALUE, MAX_STORED_VALUE)
"""Bounds of stored numbers for which no narrower bounds are specified."""

POSITIVE_STORED_VALUE_BOUNDS = (MIN_POSITIVE_STORED_VALUE, MAX_STORED_VALUE)
"""Bounds of stored numbers that must be above 0, such as areas and grid spacings."""

_NUM_VALUES_PER_CHUNK = 2**14

_DTYPE_KINDS: dict[type, tuple[str, str]] = {
    float: ("fiu", "numbers"), int: ("iu", "integers"), bool: ("biu", "integers"), str: ("OUS", "text"),
}  # fmt: skip
"""NumPy type codes that a file may contain for each data type, and a phrase for error messages. NetCDF has no Boolean
type.
"""


class DamagedFileError(Exception):
    """Error raised if the content of a stored file is invalid.

    The message states the reason.
    """


@dataclass(frozen=True, kw_only=True)
class VariableSpec:
    """Specification of a variable in a stored file: dimensions, data type and bounds."""

    dims: tuple[str, ...] = ()
    dtype: type = float
    bounds: tuple[float, float] = STORED_VALUE_BOUNDS
    may_be_nan: bool = False
    is_required: bool = True
    ascending_dim: str = ""  # empty for any order


@dataclass(frozen=True, kw_only=True)
class AttributeSpec:
    """Specification of an attribute in a stored file: data type, number of values and bounds."""

    dtype: type = float
    sizes: tuple[int, ...] = (1,)
    bounds: tuple[float, float] = STORED_VALUE_BOUNDS
    may_be_nan: bool = False
    is_required: bool = True

    def encode(self, value: Any) -> Any:
        """Convert an attribute to the form in which files store attributes: text, or a one-dimensional array."""
        return str(value) if self.dtype is str else np.atleast_1d(np.asarray(value, self.dtype))


def check_values(
    name: str, values: NDArray[Any], *, dtype: type = float, bounds: tuple[float, float] = STORED_VALUE_BOUNDS,
    may_be_nan: bool = False,
) -> tuple[float, bool]:  # fmt: skip
    """Raise a `DamagedFileError` if a stored variable contains numbers of the wrong type, or outside its bounds.

    Returns the smallest finite number, or infinity if there is none, and whether a number is NaN.
    """
    dtype_kinds, type_text = _DTYPE_KINDS[dtype]
    if values.dtype.kind not in dtype_kinds:
        raise DamagedFileError(f"has {name} with the data type {values.dtype}, but {name} consists of {type_text}")
    if dtype is str or not values.size:
        return math.inf, False
    smallest_value, largest_value = _find_extremes(values)
    has_nan = math.isnan(smallest_value)
    if has_nan and not may_be_nan:
        raise DamagedFileError(f"has {name} with a value that is not a number")
    if has_nan or math.isinf(smallest_value) or math.isinf(largest_value):
        # An infinite number is permitted only if one of the bounds is the same infinite number.
        is_permitted = np.isnan(values) | np.isin(values, [bound for bound in bounds if math.isinf(bound)])
        smallest_value, largest_value = (
            _find_extremes(values[~is_permitted]) if not is_permitted.all() else (math.inf, -math.inf)
        )
    lower, upper = max(bounds[0], -MAX_STORED_VALUE), min(bounds[1], MAX_STORED_VALUE)
    if smallest_value < lower or largest_value > upper:
        value = smallest_value if smallest_value < lower else largest_value
        limit_text = f"at least {lower:g}" if smallest_value < lower else f"at most {upper:g}"
        raise DamagedFileError(f"has {name} = {value:g}, but {name} must be {limit_text}")
    return smallest_value, has_nan


def _find_extremes(values: NDArray[Any]) -> tuple[float, float]:
    """Return the smallest and the largest number of an array, or NaN for both if the array contains NaN.

    Each chunk of the values is read once from memory, because it fits into the cache.
    """
    flat_values = values.reshape(-1)
    chunk_starts = range(0, flat_values.size, _NUM_VALUES_PER_CHUNK)
    chunk_extremes = [
        (
            flat_values[start : start + _NUM_VALUES_PER_CHUNK].min(),
            flat_values[start : start + _NUM_VALUES_PER_CHUNK].max(),
        )
        for start in chunk_starts
    ]
    smallest, largest = np.array(chunk_extremes, np.float64).T
    return float(smallest.min()), float(largest.max())


def check_attributes(attributes: Mapping[str, Any], specs: Mapping[str, AttributeSpec]) -> None:
    """Raise a `DamagedFileError` if a stored attribute is missing or does not fit its specification."""
    for name, spec in specs.items():
        if name not in attributes:
            if spec.is_required:
                raise DamagedFileError(f"has no attribute '{name}'")
            continue
        value = attributes[name]
        if spec.dtype is str:
            if not isinstance(value, str):
                raise DamagedFileError(f"has the attribute '{name}', which is not text")
            continue
        values = np.atleast_1d(np.asarray(value))
        check_values(
            f"the attribute '{name}'", values, dtype=spec.dtype, bounds=spec.bounds, may_be_nan=spec.may_be_nan
        )
        if values.ndim != 1 or values.size not in spec.sizes:
            sizes_text = " or ".join(map(str, spec.sizes))
            raise DamagedFileError(f"has {values.size} values of the attribute '{name}' instead of {sizes_text}")


def check_increase(name: str, values: NDArray[Any], axis: int = 0) -> None:
    """Raise a `DamagedFileError` unless the numbers of a stored variable increase strictly along an axis."""
    if not (np.diff(values, axis=axis) > 0).all():
        raise DamagedFileError(f"has {name} with values that do not increase")


def check_missing_values(name: str, values: NDArray[Any], is_missing: NDArray[np.bool_]) -> None:
    """Raise a `DamagedFileError` unless a stored quantity is NaN at exactly the loads without a solution.

    `is_missing` has the shape (..., loads), and `values` may have further axes before the last.
    """
    further_axes = tuple(range(is_missing.ndim - 1, values.ndim - 1))
    if not np.array_equal(np.isnan(values), np.broadcast_to(np.expand_dims(is_missing, further_axes), values.shape)):
        raise DamagedFileError(f"has NaN at different loads in {name} and in normal_elastic")
