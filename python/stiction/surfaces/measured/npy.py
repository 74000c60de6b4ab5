"""Heights in NumPy arrays (.npy)."""

from __future__ import annotations

import io
import math
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._text import printable
from stiction.surfaces.measured.raw import FormatError, Raw, Source, Table
from stiction.surfaces.profile import MAX_POINTS

SPACINGS = ("spacing_y_um", "spacing_x_um")
"""Fields of the second array in a file of `write_surface`; that of `write_profile` has the last alone."""

_MOST_HISTORY = 1_000_000  # characters of the third array, the history


def write_npy(file: Any, heights: Floats, spacing: tuple[float, ...], history: tuple[str, ...]) -> None:
    """Write three arrays one after the other: heights, spacings in µm, history; `numpy.load` gives the first."""
    np.save(file, heights)
    np.save(file, np.array(spacing, dtype=[(name, np.float64) for name in SPACINGS[-len(spacing) :]]))
    np.save(file, np.array(history, dtype=np.str_))


def read_npy(data: bytes) -> Table | Raw:
    """Take an array apart, and the spacing and history that may follow it; no objects are loaded."""
    file = io.BytesIO(data)
    stored = _array(file, data)
    if stored.dtype.kind not in "iuf" or stored.ndim not in (1, 2):
        raise FormatError(
            f"holds an array of {stored.dtype} and shape {stored.shape}; heights are real numbers along x, or y and x"
        )
    if stored.size == 0:
        raise FormatError("holds an array without points")
    if stored.size > MAX_POINTS:
        raise FormatError(f"holds {stored.size} points; at most {MAX_POINTS} can be read")
    with np.errstate(all="ignore"):
        heights = np.array(stored, dtype=np.float64, order="C")
    beside = _beside(file, data)
    if beside is not None and len(beside[0]) == heights.ndim:
        spacing, history = beside
        return Raw(
            heights, unit="um", spacing=spacing, position_unit="um", history=history, source=Source("NumPy array")
        )
    values = heights.reshape(-1, 1) if heights.ndim == 1 else heights
    return Table(values, area=True, source=Source("NumPy array"))


def _beside(file: io.BytesIO, data: bytes) -> tuple[tuple[float, ...], tuple[str, ...]] | None:
    """Spacings and history that `write_npy` put behind the heights; None where anything else stands there."""
    try:
        spacing, history = _array(file, data), _array(file, data)
    except FormatError:
        return None
    if spacing.shape != () or spacing.dtype.names not in (SPACINGS, SPACINGS[-1:]):
        return None
    if history.ndim != 1 or history.dtype.kind != "U" or history.nbytes > 4 * _MOST_HISTORY:
        return None
    return tuple(float(length) for length in spacing.item()), tuple(printable(step, 1000) for step in history.tolist())


def _array(file: io.BytesIO, data: bytes) -> NDArray[Any]:
    """The next array of a file, as a view of its bytes."""
    try:
        with warnings.catch_warnings(action="ignore"):
            first = np.lib.format.read_magic(file) == (1, 0)
            header = np.lib.format.read_array_header_1_0 if first else np.lib.format.read_array_header_2_0
            shape, fortran_order, kind = header(file)
    except Exception as error:  # the header is a Python literal, which fails in many ways
        said = " ".join(str(error).split())[:80]
        raise FormatError(f"is a damaged .npy file, or one of objects ({said})") from None
    if kind.hasobject or any(isinstance(count, bool) for count in shape):
        raise FormatError("is a damaged .npy file, or one of objects")
    points, rest = math.prod(shape), len(data) - file.tell()
    if min(shape, default=0) < 0 or points * kind.itemsize > rest:
        raise FormatError(f"is a damaged .npy file: of {points} points it holds {rest} bytes")
    if points * kind.itemsize == 0:
        return np.empty(shape if points == 0 else (0,), kind)
    stored = np.frombuffer(data, dtype=kind, count=points, offset=file.tell())
    file.seek(points * kind.itemsize, io.SEEK_CUR)
    return stored.reshape(shape, order="F" if fortran_order else "C")
