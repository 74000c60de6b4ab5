"""Arrays of numbers in a report; for each number, the report also stores how many decimals to print."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats
from stiction._estimate import Estimate, count_estimate_decimals
from stiction._number_format import MIN_NUMBER_ROUNDED_TO_ONE, NumberFormat

# A report stores this number of leading bytes of each double; four bytes give a relative precision of 5e-7.
STORED_FLOAT_BYTES = 4

# Level 7 of zlib takes a sixth of the time of level 9, and makes files only 0.5 % larger.
_COMPRESSION_LEVEL = 7


def encode_doubles(values: ArrayLike, num_leading_bytes: int) -> str:
    """Compress floating-point numbers to text: the first bytes of all numbers, then the second bytes, and so on.

    Each number is rounded to `num_leading_bytes` bytes. Bytes at the same position are similar, especially signs and
    exponents, so this order compresses best.
    """
    bits = np.ascontiguousarray(values, np.float64).ravel().view(np.uint64)
    num_dropped_bits = 8 * (8 - num_leading_bytes)
    if num_dropped_bits:
        bits = bits + np.uint64(1 << (num_dropped_bits - 1))
    byte_planes = bits.astype(">u8").view(np.uint8).reshape(-1, 8)[:, :num_leading_bytes].T
    return base64.b64encode(zlib.compress(byte_planes.tobytes(), _COMPRESSION_LEVEL)).decode("ascii")


def encode_small_integers(values: NDArray[np.int8]) -> str:
    """Store whole numbers from -128 to 127 in one byte each, compress the bytes, and encode them as base64 text."""
    return base64.b64encode(zlib.compress(values.tobytes(), _COMPRESSION_LEVEL)).decode("ascii")


@dataclass(frozen=True, eq=False)
class EstimateArray:
    """Array of estimates: its last axis has three elements (value, lower limit and upper limit).

    A page also stores how many decimals to print, for `digits` (1 or 2) digits of the interval's half width. A number
    without an interval has as many decimals as the estimate in `reference`, whose shape must broadcast. If there are
    `formats` by size, in descending order of `minimum`, a page also stores the index of each number's format. Decimals
    are counted after the division by the factor of the format; the number of digits of the format is not used.
    """

    values: Floats
    reference: Floats | None = None
    digits: int = 1
    formats: Sequence[NumberFormat] = ()

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return a dictionary of arrays that represent the estimates on a page, with keys such as "decimals"."""
        indices = find_format_indices(self.values[..., 0], self.formats) if self.formats else None
        factors = 1.0 if indices is None else np.array([item.factor for item in self.formats])[indices, np.newaxis]
        estimates = np.moveaxis(self.values / factors, -1, 0)
        value_decimals, upper_limit_decimals = count_estimate_decimals(*estimates, digits=self.digits)
        if self.reference is not None:
            reference_decimals, _ = count_estimate_decimals(*np.moveaxis(self.reference, -1, 0), digits=self.digits)
            value_decimals = np.where(np.isnan(self.values[..., 1]), reference_decimals, value_decimals)
        columns: dict[str, NDArray[Any]] = {
            end: self.values[..., index] for index, end in enumerate(("value", "lower", "upper"))
        }
        columns |= {"decimals": value_decimals, "upper_decimals": upper_limit_decimals}
        return columns if indices is None else columns | {"format": indices}


@dataclass(frozen=True, eq=False)
class NumberArray:
    """Array of numbers without intervals; the size of a number decides in which format the page prints it.

    `formats` are the formats by size, in descending order of `minimum`.
    """

    values: Floats
    formats: Sequence[NumberFormat]

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return two arrays for the page, in a dictionary: the numbers, and the index of each number's format."""
        return {"value": self.values, "format": find_format_indices(self.values, self.formats)}


def find_format_indices(values: Floats, formats: Sequence[NumberFormat]) -> NDArray[np.int8]:
    """Return, for each number, the index in `formats` of the format that `format_number` selects."""
    sizes = np.where(np.isnan(values) | (values == 0), 1.0, np.abs(values))
    minima = MIN_NUMBER_ROUNDED_TO_ONE * np.array([item.minimum for item in reversed(formats)])
    return (len(minima) - np.searchsorted(minima, sizes, side="right")).astype(np.int8)


ReportArray = NDArray[Any] | EstimateArray | NumberArray
"""Array that a page stores: floating-point numbers, integers from -128 to 127, estimates, or formatted numbers."""


@dataclass(frozen=True)
class PackedArrays:
    """All arrays of a report, encoded as text for the page.

    `texts` contains two encoded arrays: all floating-point numbers, and all small whole numbers. `offsets` contains, by
    column name, the index of the column's first number in the decoded array. `formats` contains, by array name, the
    formats of numbers and estimates.
    """

    offsets: dict[str, int]
    formats: dict[str, list[dict[str, Any]]]
    texts: dict[str, str]


def pack_arrays(arrays: Mapping[str, ReportArray]) -> PackedArrays:
    """Encode all arrays of a report as text for the page.

    Estimates and numbers with formats are split into columns, whose names start with the name of the array.
    """
    columns: dict[str, NDArray[Any]] = {}
    for name, array in arrays.items():
        if isinstance(array, EstimateArray | NumberArray):
            columns |= {f"{name}_{ending}": column for ending, column in array.columns().items()}
        else:
            columns[name] = np.asarray(array)
    floats: list[Floats] = [np.zeros(0)]
    small_integers = [np.zeros(0, np.int8)]
    offsets = {}
    for name, column in columns.items():
        target: list[Any] = floats if column.dtype.kind == "f" else small_integers
        offsets[name] = sum(item.size for item in target)
        target.append(column.astype(target[0].dtype, copy=False).ravel())
    texts = {
        "floats": encode_doubles(np.concatenate(floats), STORED_FLOAT_BYTES),
        "small": encode_small_integers(np.concatenate(small_integers)),
    }
    formats = {
        name: [{"factor": item.factor, "digits": item.digits, "text": item.text} for item in array.formats]
        for name, array in arrays.items() if isinstance(array, EstimateArray | NumberArray)
    }  # fmt: skip
    return PackedArrays(offsets, formats, texts)


QUANTITY_DIGITS = 2


def estimate_with_unit_text(point: Sequence[float], unit: str) -> str:
    """Return an estimate with its unit as text, as on a terminal: "12.1 [11.0, 13.3] µm²"."""
    estimate = Estimate(*point).in_prefixed_unit(unit)
    return "none" if np.isnan(estimate.value) else f"{estimate.text()}\u00a0{estimate.unit}".strip()


@dataclass(frozen=True, eq=False)
class QuantityEstimates:
    """Estimates that a report shows for a quantity that does not depend on mu0 or tau0.

    Attributes
    ----------
    name, words : str
        Name of the quantity, and its label on the page.
    unit : str
        Core unit of the quantity, or "%".
    estimates : ndarray of float
        Value, lower limit and upper limit (last axis) for each kind of member, cutoff and load.
    factor : float
        Conversion factor to the unit of the plot of the quantity.
    limit : float or None
        Value above which the quantity is marked.
    """

    name: str
    words: str
    unit: str
    estimates: Floats
    factor: float
    limit: float | None

    def to_record(self) -> dict[str, Any]:
        """Return estimates as JSON fields: numbers, decimals, texts, and whether each number exceeds `limit`."""
        points = self.factor * self.estimates
        decimals, upper_limit_decimals = count_estimate_decimals(*np.moveaxis(points, -1, 0), digits=QUANTITY_DIGITS)
        texts = [
            [[estimate_with_unit_text(point, self.unit) for point in row] for row in load_rows]
            for load_rows in self.estimates.tolist()
        ]
        is_beyond = self.estimates[..., 0] > (np.inf if self.limit is None else self.limit)
        return {
            "name": self.name, "words": self.words, "points": points, "decimals": decimals.tolist(),
            "upperDecimals": upper_limit_decimals.tolist(), "texts": texts, "isBeyond": is_beyond.tolist(),
        }  # fmt: skip
