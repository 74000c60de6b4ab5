"""Tables of numbers in a page, and the number of decimals to print."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats
from stiction._number_format import MAX_DIGITS, MAX_END_RATIO, prefix, quoted

FLOAT_BYTES = 4  # leading bytes of a double that a page keeps: 5e-7 of a number
NO_INTERVAL = -128  # decimals of an upper end that is not printed, nor the lower one
MAX_DECIMALS = 100


_COMPRESSION = 7  # a sixth of the time of 9 for half a per cent more bytes


def packed(values: ArrayLike, leading: int) -> str:
    """Return doubles as text, rounded to their leading bytes: all first bytes, then all second bytes, and so on.

    Bytes of the same place are alike, signs and exponents most, so this order takes the least room.
    """
    bits = np.ascontiguousarray(values, np.float64).ravel().view(np.uint64)
    dropped = 8 * (8 - leading)
    if dropped:
        bits = bits + np.uint64(1 << (dropped - 1))
    planes = bits.astype(">u8").view(np.uint8).reshape(-1, 8)[:, :leading].T
    return base64.b64encode(zlib.compress(planes.tobytes(), _COMPRESSION)).decode("ascii")


def packed_bytes(values: NDArray[np.int8]) -> str:
    """Return small whole numbers as text."""
    return base64.b64encode(zlib.compress(values.tobytes(), _COMPRESSION)).decode("ascii")


@dataclass
class Tables:
    """Arrays of a page in a row; `offsets` has the start of each."""

    offsets: dict[str, int] = field(default_factory=dict)
    floats: list[Floats] = field(default_factory=list)
    small: list[NDArray[np.int8]] = field(default_factory=list)

    def add(self, name: str, values: ArrayLike) -> None:
        """Append floating-point numbers, or whole numbers from -128 to 127."""
        array = np.asarray(values)
        kept: list[Any] = self.floats if array.dtype.kind == "f" else self.small
        self.offsets[name] = sum(each.size for each in kept)
        kept.append(array.ravel() if array.dtype.kind == "f" else array.astype(np.int8).ravel())

    def add_points(self, name: str, points: Floats, *, decimals: Any = None) -> None:
        """Append values, lower and upper ends (..., 3), and the decimals by which these are printed.

        Given decimals are those of values without an interval.
        """
        for index, part in enumerate(("value", "lower", "upper")):
            self.add(f"{name}_{part}", points[..., index])
        own, of_upper = decimals_of(*np.moveaxis(points, -1, 0))
        self.add(f"{name}_decimals", own if decimals is None else np.where(np.isnan(points[..., 1]), decimals, own))
        self.add(f"{name}_upper_decimals", of_upper)

    def packed(self) -> dict[str, str]:
        """Return all numbers as text."""
        floats = np.concatenate(self.floats) if self.floats else np.zeros(0)
        small = np.concatenate(self.small) if self.small else np.zeros(0, np.int8)
        return {"floats": packed(floats, FLOAT_BYTES), "small": packed_bytes(small)}


def decimals_of(mean: Floats, lower: Floats, upper: Floats) -> tuple[NDArray[np.int8], NDArray[np.int8]]:
    """Return the decimals with which `quoted` prints means and lower ends, and upper ends, of points (...).

    They are negative where numbers are rounded to tens. Those of the upper end are `NO_INTERVAL` where `quoted` prints
    none.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.where(mean != 0, -np.floor(np.log10(np.abs(mean))), 0.0)
        end = np.where(np.isinf(upper), 2 * mean - lower, upper)
        width = -np.floor(np.log10((end - lower) / 2))
        decimals = np.where(mean == 0, width, np.clip(width, size + 1, size + MAX_DIGITS - 1))
        decimals = np.where(end > lower, decimals, size + MAX_DIGITS - 1)
        missing = np.isnan(lower) | np.isnan(upper)
        decimals = np.where(missing, size + 1, decimals)
        is_huge = np.isfinite(upper) & (upper > MAX_END_RATIO * np.abs(mean)) & (mean != 0)
        of_upper = np.where(is_huge, -_exponent_of_digit(upper), decimals)
        scale = 10.0 ** np.clip(decimals, -MAX_DECIMALS, MAX_DECIMALS)
        near = ~missing & np.isfinite(upper) & (np.abs(np.round(lower * scale) - np.round(upper * scale)) < 1)
    decimals, of_upper = (np.nan_to_num(np.clip(each, -MAX_DECIMALS, MAX_DECIMALS)) for each in (decimals, of_upper))
    of_upper = np.where(missing, NO_INTERVAL, of_upper)
    for place in zip(*np.nonzero(near), strict=True):  # ends that are one number in print: of a value without zeros
        text = quoted(float(mean[place]), float(lower[place]), float(upper[place]))
        if "[" not in text:
            decimals[place], of_upper[place] = len(text.partition(".")[2]), NO_INTERVAL
    return decimals.astype(np.int8), of_upper.astype(np.int8)


def _exponent_of_digit(values: Floats) -> Floats:
    """Return the exponents of ten of positive values that are rounded to one digit."""
    exponent = np.floor(np.log10(values))
    return np.asarray(np.where(np.round(values / 10.0**exponent) >= 10, exponent + 1, exponent))


def text_with_unit(point: Sequence[float], unit: str) -> str:
    """Return a value with its interval (3,) in one unit: "12.1 [11.0, 13.3] µm²"; percent of a fraction for "%"."""
    value, lower, upper = point
    if np.isnan(value):
        return "none"
    factor, name = (0.01, "%") if unit == "%" else (prefix(value, unit) if unit in ("mN", "GPa", "um") else (1.0, unit))
    if value == 0 and not upper > 0:
        return f"0 {name}".strip()
    return f"{quoted(value / factor, lower / factor, upper / factor)}\u00a0{name}".strip()
