"""Reader and writer of heights as NumPy arrays (.npy)."""

from __future__ import annotations

import io
import math
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._text import printable_text
from stiction.surfaces.measured.raw import ColumnTable, FormatError, HeightProvenance, RawHeights
from stiction.surfaces.profile import MAX_POINTS

SPACING_FIELDS = ("spacing_y_um", "spacing_x_um")
"""Fields of the spacing array in an NPY file of a height map. For a profile, the array has only the field along x."""

_MAX_STORED_HISTORY_LENGTH = 1_000_000


def write_npy(file: Any, heights: Floats, spacing: tuple[float, ...], history: tuple[str, ...]) -> None:
    """Write three arrays to one file, one after the other: heights, spacings (µm) and history.

    `numpy.load` returns the heights.
    """
    np.save(file, heights)
    np.save(file, np.array(spacing, dtype=[(name, np.float64) for name in SPACING_FIELDS[-len(spacing) :]]))
    np.save(file, np.array(history, dtype=np.str_))


def read_npy(data: bytes) -> ColumnTable | RawHeights:
    """Read an array of heights from a NumPy file, with the spacings and the history if the file contains them.

    Pickled objects are not loaded.
    """
    file = io.BytesIO(data)
    stored_array = _read_array(file, data)
    if stored_array.dtype.kind not in "iuf" or stored_array.ndim not in (1, 2):
        raise FormatError(
            f"contains an array of type {stored_array.dtype} and shape {stored_array.shape}, but heights must be real "
            "numbers along x, or along y and x"
        )
    if stored_array.size == 0:
        raise FormatError("contains an array without points")
    if stored_array.size > MAX_POINTS:
        raise FormatError(f"contains {stored_array.size} points; at most {MAX_POINTS} can be read")
    with np.errstate(all="ignore"):
        heights = np.array(stored_array, dtype=np.float64, order="C")
    metadata = _read_metadata(file, data)
    if metadata is not None and len(metadata[0]) == heights.ndim:
        spacing, history = metadata
        return RawHeights(
            heights,
            unit="um",
            spacing=spacing,
            position_unit="um",
            history=history,
            source=HeightProvenance("NumPy array"),
        )
    values = heights.reshape(-1, 1) if heights.ndim == 1 else heights
    return ColumnTable(values, is_array=True, source=HeightProvenance("NumPy array"))


def _read_metadata(file: io.BytesIO, data: bytes) -> tuple[tuple[float, ...], tuple[str, ...]] | None:
    """Read the spacings and the history that `write_npy` stores after the heights; return None if they are missing.

    Returns None if other content follows.
    """
    try:
        spacing, history = _read_array(file, data), _read_array(file, data)
    except FormatError:
        return None
    if spacing.shape != () or spacing.dtype.names not in (SPACING_FIELDS, SPACING_FIELDS[-1:]):
        return None
    if history.ndim != 1 or history.dtype.kind != "U" or history.nbytes > 4 * _MAX_STORED_HISTORY_LENGTH:
        return None
    return tuple(float(length) for length in spacing.item()), tuple(
        printable_text(step, 1000) for step in history.tolist()
    )


def _read_array(file: io.BytesIO, data: bytes) -> NDArray[Any]:
    """Read the next array in a NumPy file without copying the data."""
    try:
        with warnings.catch_warnings(action="ignore"):
            is_version_1 = np.lib.format.read_magic(file) == (1, 0)
            header = np.lib.format.read_array_header_1_0 if is_version_1 else np.lib.format.read_array_header_2_0
            shape, fortran_order, data_type = header(file)
    except Exception as error:
        # Parsing a corrupt NPY header can raise many classes of errors.
        reason = " ".join(str(error).split())[:80]
        raise FormatError(f"is a damaged .npy file, or contains Python objects instead of numbers ({reason})") from None
    if data_type.hasobject or any(isinstance(axis_length, bool) for axis_length in shape):
        raise FormatError("is a damaged .npy file, or contains Python objects instead of numbers")
    points, available_bytes = math.prod(shape), len(data) - file.tell()
    if min(shape, default=0) < 0 or points * data_type.itemsize > available_bytes:
        raise FormatError(f"is a damaged .npy file with {available_bytes} bytes, too few for its {points} points")
    if points * data_type.itemsize == 0:
        return np.empty(shape if points == 0 else (0,), data_type)
    stored_array = np.frombuffer(data, dtype=data_type, count=points, offset=file.tell())
    file.seek(points * data_type.itemsize, io.SEEK_CUR)
    return stored_array.reshape(shape, order="F" if fortran_order else "C")
