"""Reading measured profiles and surfaces: the reader of a file, and what was understood of it."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np

from stiction._files import describe_os_error
from stiction._repr import with_unit
from stiction._text import printable, printable_path
from stiction.surfaces.measured.decode import decode, is_text
from stiction.surfaces.measured.excel import read_excel
from stiction.surfaces.measured.instrument import is_available, read_instrument
from stiction.surfaces.measured.interpret import (
    Interpreted,
    Missing,
    Outliers,
    ReadOptions,
    read_options,
    to_profile,
    to_profile_or_surface,
    to_surface,
)
from stiction.surfaces.measured.npy import read_npy
from stiction.surfaces.measured.raw import (
    MOST_BYTES,
    MOST_TEXT_BYTES,
    Caveat,
    Content,
    FormatError,
    FormatWarning,
    Raw,
    Source,
)
from stiction.surfaces.measured.shapes import Chosen, raw_of
from stiction.surfaces.measured.text import layout_of, read_text
from stiction.surfaces.measured.x3p import read_x3p
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

TEXT_SUFFIXES = ("", ".txt", ".csv", ".tsv", ".dat", ".asc", ".prn", ".xy", ".xyz", ".text", ".hfm")

READERS: dict[str, Callable[[bytes], Content]] = {
    ".npy": read_npy,
    ".x3p": read_x3p,
    ".xlsx": read_excel,
    **dict.fromkeys(TEXT_SUFFIXES, read_text),
}
"""Readers by the ending of a name in lower case. SurfaceTopography reads all others, and binary files among texts."""

_BEGINNINGS = {
    b"\x93NUMPY": ((".npy",), "a NumPy array (.npy)"),
    b"PK": ((".x3p", ".xlsx"), "a zip archive, as X3P and workbooks are"),
}
"""What the files of some endings begin with, and no others, and what it is."""

MissingValue = str | float | Sequence[str | float]
_Body = TypeVar("_Body", bound=Profile | Surface)


@dataclass(frozen=True)
class Reading(Generic[_Body]):
    """A profile or a surface that was read from a file, with what was understood of the file."""

    body: _Body
    file: str
    source: Source
    unit: str
    """Unit of the heights in the file."""
    missing: int
    """Points without a height in the file."""
    points: int
    """Points in the file."""
    caveats: tuple[Caveat, ...]

    def __str__(self) -> str:
        shape = " × ".join(map(str, self.body.heights.shape))
        steps = np.unique(self.body.spacings).tolist()
        apart = with_unit(steps[0], "µm")
        if len(steps) > 1:
            apart = (
                f"{with_unit(self.body.spacings[1], 'µm')} along x and {with_unit(self.body.spacings[0], 'µm')} along y"
            )
        source = self.source
        heights = f"heights {printable(source.column)} in {self.unit}" if source.column else f"heights in {self.unit}"
        parts = [source.layout or "unknown layout", f"{shape} points", f"{apart} apart", heights]
        parts += [f"{self.missing} of {self.points} missing" if self.missing else "none missing"]
        if source.lines is not None:
            skipped = " and ".join(
                f"{count} {where}"
                for count, where in ((source.lines_above, "above"), (source.lines_below, "below"))
                if count
            )
            parts += [f"lines {source.lines[0]} to {source.lines[1]}" + (f" ({skipped} skipped)" if skipped else "")]
            text = [source.encoding, source.separator, f"decimal {'comma' if source.decimal_mark == ',' else 'point'}"]
            parts += [", ".join(word for word in text if word)]
        return "; ".join(parts)

    def record(self) -> dict[str, Any]:
        """Return what was understood as fields for JSON."""
        source = self.source
        return {
            "file": self.file, "layout": source.layout, "points": list(self.body.heights.shape),
            "spacing_um": list(self.body.spacings), "heights": source.column, "unit": self.unit,
            "missing_points": self.missing, "encoding": source.encoding, "separator": source.separator,
            "decimal_mark": source.decimal_mark, "lines": None if source.lines is None else list(source.lines),
            "lines_above": source.lines_above, "lines_below": source.lines_below,
            "caveats": [{"name": each.name, "text": each.text, "cure": each.cure} for each in self.caveats],
        }  # fmt: skip


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
    missing_value: MissingValue | None = None,
    accept: str | Sequence[str] | None = None,
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
    missing_value : float, str, or several, optional
        Numbers, as they stand in the file, or words that mark points without a height, as in -9999 or "Err".
    accept : str or sequence of str, optional
        Names of doubts that are settled, as in "whole-numbers"; a `FormatWarning` names them.

    Returns
    -------
    Profile
        In µm, its x starting at zero; the history says what was read and from where the spacing is.

    Warns
    -----
    FormatWarning
        If the file contradicts itself, or if its heights or its size are hardly those of a surface: for each doubt its
        name and the option that settles it.

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
    return _read(
        path, read_options(unit, spacing, missing, channel, columns, outliers, crop, missing_value, accept), to_profile
    )


def read_surface(
    path: str | os.PathLike[str],
    *,
    unit: str | tuple[str, str] | None = None,
    spacing: str | tuple[str, str] | None = None,
    missing: Missing = "error",
    channel: Chosen | None = None,
    outliers: Outliers = "keep",
    crop: str | Sequence[str] | None = None,
    missing_value: MissingValue | None = None,
    accept: str | Sequence[str] | None = None,
) -> Surface:
    """Read a measured surface.

    Parameters
    ----------
    path : path
        Text or CSV with a matrix of heights of at least four columns, the columns along x, of which a header as that of
        Gwyddion may give width and height; a NumPy array (.npy); X3P; with the package openpyxl (``pip install
        openpyxl``) a workbook (.xlsx); or, with the package SurfaceTopography installed (``pip install
        SurfaceTopography``), what that reads.
    unit, missing, channel, outliers, crop, missing_value, accept
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
    return _read(
        path, read_options(unit, spacing, missing, channel, None, outliers, crop, missing_value, accept), to_surface
    )


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
    missing_value: MissingValue | None = None,
    accept: str | Sequence[str] | None = None,
) -> Profile | Surface:
    """Read a measured profile or surface, whichever the file holds.

    Parameters
    ----------
    path, unit, missing, channel, columns, outliers, crop, missing_value, accept
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
    return _read(
        path,
        read_options(unit, spacing, missing, channel, columns, outliers, crop, missing_value, accept),
        to_profile_or_surface,
    )


def reading_of(path: str | os.PathLike[str], **options: Any) -> Reading[Profile | Surface]:
    """Return a measured profile or surface with what was understood of its file, by the options of `read_measurement`.

    Doubts are in `caveats`, and no warning is issued.
    """
    allowed = ("unit", "spacing", "missing", "channel", "columns", "outliers", "crop", "missing_value", "accept")
    given = {"missing": "error", "outliers": "keep"} | {name: options.pop(name) for name in allowed if name in options}
    if options:
        raise ValueError(f"{next(iter(options))} is no option of a file ({', '.join(allowed)})")
    names = {name: given.get(name) for name in allowed}
    return _reading(path, read_options(**names), to_profile_or_surface)  # type: ignore[arg-type]


def _read(
    path: str | os.PathLike[str], options: ReadOptions, convert: Callable[[Raw, str, ReadOptions], Interpreted[_Body]]
) -> _Body:
    """Return the body in a file; doubts about it are warnings."""
    reading = _reading(path, options, convert)
    for caveat in reading.caveats:
        warnings.warn(
            f"{printable_path(path)}: {caveat}", FormatWarning, stacklevel=3
        )  # of whoever called a public function
    return reading.body


def _reading(
    path: str | os.PathLike[str], options: ReadOptions, convert: Callable[[Raw, str, ReadOptions], Interpreted[_Body]]
) -> Reading[_Body]:
    """Read a file and interpret it; every error names the whole path."""
    path = Path(path)
    try:
        raw = raw_of(_content(path, options.words), options.channel, options.columns)
        found = convert(raw, path.name, options)
    except OSError as error:
        raise FormatError(f"{printable_path(path)}: cannot be read: {describe_os_error(error)}") from None
    except MemoryError:
        raise FormatError(f"{printable_path(path)}: is too large for the memory of this machine") from None
    except ValueError as error:
        raise FormatError(f"{printable_path(path)}: {error}") from None
    return Reading(found.body, path.name, raw.source, found.unit, found.missing, raw.heights.size, found.caveats)


def _content(path: Path, words: tuple[str, ...]) -> Content:
    """Return what a file holds, by the reader for its name and its first bytes."""
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
        start = file.read(4096)
    for beginning, (suffixes, name) in _BEGINNINGS.items():
        if reader is not None and start.startswith(beginning) != (suffix in suffixes):
            name = name if start.startswith(beginning) else f"not {name}"
            raise FormatError(f"is named {suffix or 'without an ending'}, but what it holds is {name}")
    if reader is None and start.startswith(b"\x93NUMPY"):
        reader = read_npy
    if reader is None and is_text(start) and size <= MOST_TEXT_BYTES:
        try:
            if layout_of(decode(path.read_bytes(), words)) is not None:
                reader = read_text
        except FormatError:
            pass
    if reader is read_text and size > MOST_TEXT_BYTES:
        raise FormatError(f"has {size} bytes of text; at most {MOST_TEXT_BYTES} can be read: save it as .npy")
    if reader is read_text and not is_text(start):
        return _binary(path)
    if reader is None:
        return _of_instrument(path, start, words)
    if reader in (read_text, read_excel):
        return reader(path.read_bytes(), words)
    return reader(path.read_bytes())


def _binary(path: Path) -> Content:
    """Return what SurfaceTopography reads of a binary file that is named as a text."""
    if is_available():
        try:
            return read_instrument(path)
        except FormatError as error:
            raise FormatError(f"is binary, not text, and {error}") from None
    raise FormatError(
        f"is binary, not text, though it is named {path.suffix or 'without an ending'}; the package SurfaceTopography "
        "may read it: pip install SurfaceTopography"
    )


def _of_instrument(path: Path, start: bytes, words: tuple[str, ...]) -> Content:
    """Return what SurfaceTopography reads of a file, or a text of another name as a table."""
    try:
        return read_instrument(path)
    except FormatError as error:
        if not is_text(start) or path.stat().st_size > MOST_TEXT_BYTES:
            raise
        try:
            return read_text(path.read_bytes(), words)
        except FormatError:
            raise error from None
