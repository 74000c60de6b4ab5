"""Reading measured profiles and surfaces: which reader takes which file."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from stiction._files import reason
from stiction._text import named
from stiction.surfaces.measured.excel import read_excel
from stiction.surfaces.measured.instrument import read_instrument
from stiction.surfaces.measured.interpret import (
    Missing,
    Outliers,
    ReadOptions,
    read_options,
    to_profile,
    to_profile_or_surface,
    to_surface,
)
from stiction.surfaces.measured.npy import read_npy
from stiction.surfaces.measured.raw import MOST_BYTES, MOST_TEXT_BYTES, Content, FormatError, FormatWarning, Raw
from stiction.surfaces.measured.table import Chosen, raw_of
from stiction.surfaces.measured.text import read_text
from stiction.surfaces.measured.x3p import read_x3p
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

TEXT_SUFFIXES = ("", ".txt", ".csv", ".tsv", ".dat", ".asc", ".prn", ".xy", ".text")

READERS: dict[str, Callable[[bytes], Content]] = {
    ".npy": read_npy,
    ".x3p": read_x3p,
    ".xlsx": read_excel,
    **dict.fromkeys(TEXT_SUFFIXES, read_text),
}
"""What takes a file apart, by the ending of its name in lower case; SurfaceTopography is asked about all others."""

_BEGINNINGS = {
    b"\x93NUMPY": ((".npy",), "a NumPy array (.npy)"),
    b"PK": ((".x3p", ".xlsx"), "a zip archive, as X3P and workbooks are"),
}
"""What the files of some endings begin with, and no others, and what it is."""

_Body = TypeVar("_Body", bound=Profile | Surface)


def read_profile(
    path: str | os.PathLike[str],
    *,
    unit: str | tuple[str, str] | None = None,
    spacing: str | None = None,
    missing: Missing = "error",
    channel: Chosen | None = None,
    columns: Chosen | Sequence[Chosen] | None = None,
    outliers: Outliers = "keep",
    crop: str | Sequence[str] | None = None,
) -> Profile:
    """Read a measured profile.

    Parameters
    ----------
    path : path
        Text or CSV with one column of heights or two of positions and heights, below any other text; a NumPy array
        (.npy), likewise; X3P; with the package openpyxl (``pip install openpyxl``) a workbook (.xlsx); or,
        with the package SurfaceTopography installed (``pip install SurfaceTopography``), what that
        reads of line scans.
    unit : str or (str, str), optional
        Of all lengths in the file ("um"), or of positions and of heights (("mm", "um")): m, mm, um, nm, pm. Needed
        where the file does not say; where it does, it must say the same.
    spacing : str, optional
        Distance between neighbouring points, as in "0.5 um". Needed where the file has neither positions nor a spacing;
        where it has, it must agree.
    missing : {"error", "interpolate", "mask"}
        What to do about points without a height, which are empty, NaN, or written as stars or dashes. With "mask"
        nothing touches where nothing was measured; "interpolate" puts them on a straight line between their neighbours.
        Both leave them out at the ends of a profile; how many and where is said in the history.
    channel : str or int, optional
        Name or number, from 0 on, of what to read of a file of an instrument, or of the sheet of a workbook. By default
        the first of heights, or the only sheet; which one it is, and what else there is, is said in the history.
    columns : (str or int, str or int), or str or int, optional
        Of a table, names or numbers, from 0 on, of the columns of positions and of heights, or of heights alone. The
        unit in a name may be left out.
    outliers : {"keep", "mask"}
        Whether points beyond 6 robust deviations of their neighbours, up to four together, are missing ones.
    crop : str or sequence of str, optional
        What to read of it: "x0,x1" with units, "10 um,50 um"; of a surface "x0,x1,y0,y1". Before all else is done.

    Returns
    -------
    Profile
        In µm, its x starting at zero; the history says what was read and from where the spacing is.

    Warns
    -----
    FormatWarning
        If a spacing that stands in words above the data differs from that of the positions by more than its last digit
        explains. The positions are right then.

    Raises
    ------
    FormatError
        A `ValueError`, if the file cannot be read, is no profile, is not uniform, lacks a unit or contradicts an
        argument, or has missing points.
    ValueError
        If an argument is not what it should be.

    Notes
    -----
    Positions need not be more uniform than their printed digits can show. The spacing is (last - first)/(n - 1), unless
    the argument or the text above the data gives one that fits all positions as printed.

    Examples
    --------
    >>> import pathlib
    >>> import tempfile
    >>> from stiction import read_profile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "scan.csv"
    >>> _ = path.write_text("x (um),z (nm)" + "".join(f"{chr(10)}{x},{x % 3}" for x in range(8)))
    >>> read_profile(path).extent
    8.0
    """
    return _read(path, read_options(unit, spacing, missing, channel, columns, outliers, crop), to_profile)


def read_surface(
    path: str | os.PathLike[str],
    *,
    unit: str | tuple[str, str] | None = None,
    spacing: str | tuple[str, str] | None = None,
    missing: Missing = "error",
    channel: Chosen | None = None,
    outliers: Outliers = "keep",
    crop: str | Sequence[str] | None = None,
) -> Surface:
    """Read a measured surface.

    Parameters
    ----------
    path : path
        Text or CSV with a matrix of heights of at least four columns, the columns along x, of which a header as that of
        Gwyddion may give width and height; a NumPy array (.npy); X3P; with the package openpyxl (``pip install
        openpyxl``) a workbook (.xlsx); or, with the package SurfaceTopography installed (``pip install
        SurfaceTopography``), what that reads.
    unit, missing, channel, outliers, crop
        As for `read_profile`. Missing points lie on a line between their neighbours in the row, and where these are
        missing too, in the column.
    spacing : str or (str, str), optional
        Distance between neighbouring points, or that between rows and that between columns (Δy, Δx).

    Examples
    --------
    >>> import pathlib
    >>> import tempfile
    >>> import numpy as np
    >>> from stiction import read_surface
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "map.npy"
    >>> np.save(path, np.eye(8))
    >>> read_surface(path, unit="nm", spacing="0.1 um")
    Surface of 8 × 8 points, 0.1 µm apart, Sq 0.3307 nm, not levelled; read from map.npy
    """
    return _read(path, read_options(unit, spacing, missing, channel, None, outliers, crop), to_surface)


def read_measurement(
    path: str | os.PathLike[str],
    *,
    unit: str | tuple[str, str] | None = None,
    spacing: str | tuple[str, str] | None = None,
    missing: Missing = "error",
    channel: Chosen | None = None,
    columns: Chosen | Sequence[Chosen] | None = None,
    outliers: Outliers = "keep",
    crop: str | Sequence[str] | None = None,
) -> Profile | Surface:
    """Read a measured profile or surface, whichever the file holds.

    Parameters
    ----------
    path, unit, missing, channel, columns, outliers, crop
        As for `read_profile`.
    spacing : str or (str, str), optional
        As for `read_surface`; a profile has one.

    Examples
    --------
    >>> import pathlib
    >>> import tempfile
    >>> from stiction import Profile, read_measurement, write_profile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "scan.csv"
    >>> write_profile(Profile([0.0, 0.1, 0.0, -0.1], spacing=0.5), path)
    >>> read_measurement(path).spacing
    0.5
    """
    return _read(path, read_options(unit, spacing, missing, channel, columns, outliers, crop), to_profile_or_surface)


def _read(
    path: str | os.PathLike[str],
    options: ReadOptions,
    convert: Callable[[Raw, str, ReadOptions], tuple[_Body, list[str]]],
) -> _Body:
    """Read a file and convert what it holds; every error and warning names the whole path."""
    path = Path(path)
    try:
        raw = raw_of(_content(path), options.channel, options.columns)
        body, doubts = convert(raw, path.name, options)
    except OSError as error:
        raise FormatError(f"{named(path)}: cannot be read: {reason(error)}") from None
    except MemoryError:
        raise FormatError(f"{named(path)}: is too large for the memory of this machine") from None
    except ValueError as error:
        raise FormatError(f"{named(path)}: {error}") from None
    for doubt in doubts:
        warnings.warn(f"{named(path)}: {doubt}", FormatWarning, stacklevel=3)  # of whoever called a public function
    return body


def _content(path: Path) -> Content:
    suffix = path.suffix.lower()
    if not path.is_file():
        path.stat()  # which says why there is none
        raise FormatError("is a directory" if path.is_dir() else "is not a file")
    size = path.stat().st_size
    if size == 0:
        raise FormatError("is empty")
    if size > MOST_BYTES:
        raise FormatError(f"has {size} bytes; at most {MOST_BYTES} can be read")
    reader = READERS.get(suffix)
    with path.open("rb") as file:
        start = file.read(8)
    for beginning, (suffixes, name) in _BEGINNINGS.items():
        if reader is not None and start.startswith(beginning) != (suffix in suffixes):
            name = name if start.startswith(beginning) else f"not {name}"
            raise FormatError(f"is named {suffix or 'without an ending'}, but what it holds is {name}")
    if reader is None and start.startswith(b"\x93NUMPY"):
        reader = read_npy
    if reader is None:
        return read_instrument(path)
    if reader is read_text and size > MOST_TEXT_BYTES:
        raise FormatError(f"has {size} bytes of text; at most {MOST_TEXT_BYTES} can be read: save it as .npy")
    return reader(path.read_bytes())
