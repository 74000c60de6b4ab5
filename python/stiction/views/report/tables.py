"""Tables of numbers on a report page. Each number is stored with the number of decimals to print."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats
from stiction._estimate import MAX_FULL_PRECISION_END_RATIO, MAX_SIGNIFICANT_DIGITS, Estimate
from stiction._number_format import choose_prefixed_unit

# number of leading bytes of a double that are stored in a page; four bytes give a relative precision of 5e-7
STORED_FLOAT_BYTES = 4
NO_INTERVAL_CODE = -128  # number that replaces the number of decimals of the upper end if no interval is printed
# maximum number of decimals, and maximum number of digits before the decimal point that may be rounded
MAX_DECIMALS = 100


_COMPRESSION_LEVEL = 7  # zlib level; compression takes a sixth of the time of level 9 and produces 0.5 % more bytes


def encode_doubles(values: ArrayLike, num_leading_bytes: int) -> str:
    """Encode doubles, rounded to their leading bytes, as text: all first bytes, then all second bytes, and so on.

    Bytes at the same position are similar, especially signs and exponents, so this order compresses best.
    """
    bits = np.ascontiguousarray(values, np.float64).ravel().view(np.uint64)
    num_dropped_bits = 8 * (8 - num_leading_bytes)
    if num_dropped_bits:
        bits = bits + np.uint64(1 << (num_dropped_bits - 1))
    byte_planes = bits.astype(">u8").view(np.uint8).reshape(-1, 8)[:, :num_leading_bytes].T
    return base64.b64encode(zlib.compress(byte_planes.tobytes(), _COMPRESSION_LEVEL)).decode("ascii")


def encode_small_integers(values: NDArray[np.int8]) -> str:
    """Encode whole numbers from -128 to 127 as text."""
    return base64.b64encode(zlib.compress(values.tobytes(), _COMPRESSION_LEVEL)).decode("ascii")


@dataclass
class PackedArrays:
    """Concatenated arrays of a page. The dictionary `offsets` maps the name of each array to the start of the array."""

    offsets: dict[str, int] = field(default_factory=dict)
    floats: list[Floats] = field(default_factory=list)
    small_integers: list[NDArray[np.int8]] = field(default_factory=list)

    def add(self, name: str, values: ArrayLike) -> None:
        """Append floating-point numbers, or whole numbers from -128 to 127."""
        array = np.asarray(values)
        target: list[Any] = self.floats if array.dtype.kind == "f" else self.small_integers
        self.offsets[name] = sum(item.size for item in target)
        target.append(array.ravel() if array.dtype.kind == "f" else array.astype(np.int8).ravel())

    def add_estimates(self, name: str, points: Floats, *, decimals: Any = None) -> None:
        """Append values, lower ends and upper ends (last axis of `points`), and the numbers of decimals to print.

        `decimals` is the number of decimals for values without an interval.
        """
        for index, end in enumerate(("value", "lower", "upper")):
            self.add(f"{name}_{end}", points[..., index])
        value_decimals, upper_decimals = count_estimate_decimals(*np.moveaxis(points, -1, 0))
        if decimals is not None:
            value_decimals = np.where(np.isnan(points[..., 1]), decimals, value_decimals)
        self.add(f"{name}_decimals", value_decimals)
        self.add(f"{name}_upper_decimals", upper_decimals)

    def encoded_texts(self) -> dict[str, str]:
        """Return all numbers, encoded as text."""
        floats = np.concatenate(self.floats) if self.floats else np.zeros(0)
        small_integers = np.concatenate(self.small_integers) if self.small_integers else np.zeros(0, np.int8)
        return {"floats": encode_doubles(floats, STORED_FLOAT_BYTES), "small": encode_small_integers(small_integers)}


def count_estimate_decimals(mean: Floats, lower: Floats, upper: Floats) -> tuple[NDArray[np.int8], NDArray[np.int8]]:
    """Return how many decimals an `Estimate` prints: one number for mean and lower end, and one for the upper end.

    Decimals are negative for numbers that are rounded to tens or more. The decimals of the upper end are
    `NO_INTERVAL_CODE` if the text contains no interval.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        value_decimals = np.where(mean != 0, -np.floor(np.log10(np.abs(mean))), 0.0)
        upper_end = np.where(np.isinf(upper), 2 * mean - lower, upper)
        interval_decimals = -np.floor(np.log10((upper_end - lower) / 2))
        decimals = np.where(
            mean == 0,
            interval_decimals,
            np.clip(interval_decimals, value_decimals + 1, value_decimals + MAX_SIGNIFICANT_DIGITS - 1),
        )
        decimals = np.where(upper_end > lower, decimals, value_decimals + MAX_SIGNIFICANT_DIGITS - 1)
        has_no_interval = np.isnan(lower) | np.isnan(upper)
        decimals = np.where(has_no_interval, value_decimals + 1, decimals)
        is_huge = np.isfinite(upper) & (upper > MAX_FULL_PRECISION_END_RATIO * np.abs(mean)) & (mean != 0)
        upper_decimals = np.where(is_huge, -_rounded_decimal_exponents(upper), decimals)
        scale = 10.0 ** np.clip(decimals, -MAX_DECIMALS, MAX_DECIMALS)
        is_upper_equal = (
            ~has_no_interval & np.isfinite(upper) & (np.abs(np.round(lower * scale) - np.round(upper * scale)) < 1)
        )
    decimals, upper_decimals = (
        np.nan_to_num(np.clip(array, -MAX_DECIMALS, MAX_DECIMALS)) for array in (decimals, upper_decimals)
    )
    upper_decimals = np.where(has_no_interval, NO_INTERVAL_CODE, upper_decimals)
    # If both ends have the same printed digits, only the value is printed, without trailing zeros.
    for index in zip(*np.nonzero(is_upper_equal), strict=True):
        text = str(Estimate(float(mean[index]), float(lower[index]), float(upper[index])))
        if "[" not in text:
            decimals[index], upper_decimals[index] = len(text.partition(".")[2]), NO_INTERVAL_CODE
    return decimals.astype(np.int8), upper_decimals.astype(np.int8)


def _rounded_decimal_exponents(values: Floats) -> Floats:
    """Return the decimal exponents of positive values after rounding to one digit."""
    exponent = np.floor(np.log10(values))
    return np.asarray(np.where(np.round(values / 10.0**exponent) >= 10, exponent + 1, exponent))


def estimate_with_unit_text(point: Sequence[float], unit: str) -> str:
    """Return a value with its interval and unit, as in "12.1 [11.0, 13.3] µm²"; fractions are given in %."""
    value, lower, upper = point
    if np.isnan(value):
        return "none"
    factor, name = (
        (0.01, "%")
        if unit == "%"
        else (choose_prefixed_unit(value, unit) if unit in ("mN", "GPa", "um") else (1.0, unit))
    )
    if value == 0 and not upper > 0:
        return f"0 {name}".strip()
    return f"{Estimate(value, lower, upper) / factor}\u00a0{name}".strip()
