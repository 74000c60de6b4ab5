"""Heights in NumPy arrays (.npy)."""

from __future__ import annotations

import io
import math
import warnings

import numpy as np

from stiction.surfaces.measured.raw import FormatError, Table
from stiction.surfaces.profile import MOST_POINTS


def read_npy(data: bytes) -> Table:
    """Take an array apart; no objects are loaded."""
    file = io.BytesIO(data)
    try:
        with warnings.catch_warnings(action="ignore"):
            first = np.lib.format.read_magic(file) == (1, 0)
            header = np.lib.format.read_array_header_1_0 if first else np.lib.format.read_array_header_2_0
            shape, fortran_order, kind = header(file)
    except Exception as error:  # the header is a Python literal, which fails in many ways
        said = " ".join(str(error).split())[:80]
        raise FormatError(f"is a damaged .npy file, or one of objects ({said})") from None
    if kind.kind not in "iuf" or len(shape) not in (1, 2):
        if kind.hasobject:
            raise FormatError("is a damaged .npy file, or one of objects")
        raise FormatError(f"holds an array of {kind} and shape {shape}; heights are real numbers along x, or y and x")
    points, rest = math.prod(shape), len(data) - file.tell()
    if min(shape) < 0 or points * kind.itemsize > rest:
        raise FormatError(f"is a damaged .npy file: of {points} points it holds {rest} bytes")
    if points == 0:
        raise FormatError("holds an array without points")
    if points > MOST_POINTS:
        raise FormatError(f"holds {points} points; at most {MOST_POINTS} can be read")
    stored = np.frombuffer(data, dtype=kind, count=points, offset=file.tell())
    with np.errstate(all="ignore"):
        heights = np.array(stored.reshape(shape, order="F" if fortran_order else "C"), dtype=np.float64, order="C")
    return Table(heights.reshape(-1, 1) if heights.ndim == 1 else heights, area=True)
