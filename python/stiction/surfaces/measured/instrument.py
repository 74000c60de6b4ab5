"""Reader for the files of instruments, based on the package SurfaceTopography."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from stiction.surfaces.measured.header import NON_HEIGHT_NAME_PATTERN
from stiction.surfaces.measured.raw import (
    ColumnTable,
    FormatError,
    HeightChannels,
    HeightProvenance,
    RawHeights,
    check_point_count,
)
from stiction.surfaces.profile import MAX_POINTS

_TEXT_FORMATS = ("asc", "xyz")
"""Plain text formats in which SurfaceTopography ignores units and other declarations of the header."""

_ARRAY_FORMATS = ("h5", "mat", "npz")
"""Formats with named arrays, which may contain heights, a mask, an axis or indices."""

_FORMATS_WITHOUT_SIGNATURE = ("hgt", "mat")
"""Formats without a signature. SurfaceTopography accepts any bytes as such a format, so the file must have its
extension.
"""

_UNSUPPORTED_FORMATS = {"nms": "a NanoFocus .nms file, whose spacing has no reliable unit"}
"""Formats that are rejected, because SurfaceTopography 1.27 computes a wrong spacing for some files."""

_ARRAY_WITHOUT_HEIGHTS_PATTERN = re.compile(
    r"(?:.*[/_ .-])?(?:[xyt]+|d[xy]|time|ax[ei]s|coord\w*|pos\w*|\w*mask\w*|(?:in)?valid\w*|flags?|ind(?:ex|ic)\w*|idx|"
    r"ids?|labels?|rows?|col(?:umn)?s?|err(?:or)?s?|std\w*|sigma|uncertaint\w*|weights?|quality|intensity|spacing|size|"
    r"units?|pixel\w*|scale|residuals?|noise|velocit\w*|speed|amplitude|gr[ae]y\w*)\d*",
    re.IGNORECASE,
)
"""Regular expression for the names of arrays that do not contain heights."""


def _denotes_no_heights(name: str) -> bool:
    """Return whether the name of an array in an instrument file shows that the array contains no heights."""
    words = name.replace("_", " ").replace("/", " ")
    return bool(_ARRAY_WITHOUT_HEIGHTS_PATTERN.fullmatch(name) or NON_HEIGHT_NAME_PATTERN.search(words))


def is_reader_installed() -> bool:
    """Return whether SurfaceTopography is installed."""
    return find_spec("SurfaceTopography") is not None


def read_instrument_file(path: Path) -> HeightChannels:
    """Read the height channels of an instrument file with SurfaceTopography, which supports about forty formats."""
    try:
        # SurfaceTopography warns about packages that are not installed.
        with warnings.catch_warnings(action="ignore"):
            import SurfaceTopography  # noqa: F401
    except ImportError:
        raise FormatError(
            f"has a name that ends in {path.suffix}; the package SurfaceTopography may be able to read it (pip "
            "install SurfaceTopography); the name of a text file should end in .csv or .txt"
        ) from None
    with _open_reader(path) as reader:
        if reader.format() in _TEXT_FORMATS:
            raise FormatError(
                "is text that cannot be read as a table of heights; rename it so that its name ends in .csv or .txt, "
                "and read it again to see the reason"
            )
        if (reason := _UNSUPPORTED_FORMATS.get(reader.format())) is not None:
            raise FormatError(f"is {reason}; export it as X3P or as text")
        if reader.format() in _FORMATS_WITHOUT_SIGNATURE and path.suffix.lower() != f".{reader.format()}":
            raise FormatError(_UNKNOWN_FORMAT_MESSAGE.format(""))
        names = tuple(str(channel.name)[:80] for channel in reader.channels)
        if not names:
            raise FormatError("contains no matrix of numbers that may be heights")
        default_index: int | None = int(reader.default_channel.index)
        if reader.format() in _ARRAY_FORMATS and (len(names) > 1 or _denotes_no_heights(names[0])):
            default_index = None
    return HeightChannels(names, lambda index: _read_channel(path, index, names[index]), default_index)


_UNKNOWN_FORMAT_MESSAGE = (
    "is not a profile or surface in a known format{}; save it as X3P, or as text ending in .csv or .txt"
)


@contextmanager
def _open_reader(path: Path) -> Iterator[Any]:
    from SurfaceTopography import open_topography

    try:
        with warnings.catch_warnings(action="ignore"), open_topography(str(path)) as reader:
            yield reader
    except FormatError:
        raise
    except Exception as error:
        # SurfaceTopography raises many classes of errors for a file that it cannot read.
        detail = f" ({type(error).__name__}: {' '.join(str(error).split())[:120]})"
        # `CannotDetectFileFormat` lists the errors of all readers of SurfaceTopography, so its text is left out.
        if type(error).__name__ == "CannotDetectFileFormat":
            detail = ""
        raise FormatError(_UNKNOWN_FORMAT_MESSAGE.format(detail)) from None


def _read_channel(path: Path, index: int, name: str) -> RawHeights | ColumnTable:
    with _open_reader(path) as reader:
        channel = reader.channels[index]
        points = math.prod(map(int, np.atleast_1d(channel.nb_grid_pts)))
        if points > MAX_POINTS:
            raise FormatError(f"contains {points} points; at most {MAX_POINTS} can be read")
        check_point_count(points, path.stat().st_size)
        # A tuple of units means that positions and measured values have different units, so the values are not heights.
        if isinstance(channel.unit, tuple):
            raise FormatError(f"has a channel {index} ({name}) that does not contain heights; choose another channel")
        has_sizes = channel.physical_sizes is not None
        # If a file lacks the required physical sizes, numbers of points replace them, and the spacing is ignored.
        size_arguments = {} if has_sizes else {"physical_sizes": tuple(map(float, np.atleast_1d(channel.nb_grid_pts)))}
        source = HeightProvenance(f"{reader.format()} by SurfaceTopography", column=name)
        topography = channel.topography(**size_arguments)
        heights = np.ma.filled(np.ma.asarray(topography.heights(), dtype=np.float64), np.nan)
        if reader.format() in _ARRAY_FORMATS:
            if np.isin(heights, (0.0, 1.0)).all():
                raise FormatError(
                    f"has a channel {index} ({name}) with only 0 and 1, like a mask; choose another channel"
                )
            return ColumnTable(np.atleast_2d(heights), is_array=True, source=source)
        unit = None if topography.unit is None else str(topography.unit)
        if not topography.is_uniform:
            positions = np.array(topography.positions(), dtype=np.float64)
            return RawHeights(heights, unit=unit, positions=positions, position_unit=unit, source=source)
        spacing = None
        if has_sizes:
            pixel_sizes = np.atleast_1d(topography.pixel_size)
            spacing = tuple(float(pixel_size) for pixel_size in reversed(pixel_sizes))
    # The first axis of a SurfaceTopography array is x.
    return RawHeights(np.ascontiguousarray(heights.T), unit=unit, spacing=spacing, position_unit=unit, source=source)
