"""Reading of measured profiles and height maps: choice of a reader for each file, interpretation of its content."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np

from stiction._checks import parse_path
from stiction._files import UnreadableFileError, check_is_file, describe_os_error
from stiction._repr import format_with_unit
from stiction._text import printable_path, printable_text
from stiction._warnings import warn_caller
from stiction.surfaces.measured.decode import decode_text, is_text
from stiction.surfaces.measured.excel import read_excel
from stiction.surfaces.measured.instrument import is_reader_installed, read_instrument_file
from stiction.surfaces.measured.interpret import (
    InterpretedScan,
    MissingPointTreatment,
    OutlierTreatment,
    ReadOptions,
    to_profile,
    to_profile_or_surface,
    to_surface,
    validate_read_options,
)
from stiction.surfaces.measured.npy import read_npy
from stiction.surfaces.measured.raw import (
    MAX_FILE_BYTES,
    MAX_TEXT_BYTES,
    FileCaveat,
    FormatError,
    FormatWarning,
    HeightProvenance,
    RawHeights,
    ReaderResult,
)
from stiction.surfaces.measured.shapes import NameOrIndex, select_heights
from stiction.surfaces.measured.text import find_layout, read_text
from stiction.surfaces.measured.x3p import read_x3p
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

TEXT_SUFFIXES = ("", ".txt", ".csv", ".tsv", ".dat", ".asc", ".prn", ".xy", ".xyz", ".text", ".hfm")

READERS: dict[str, Callable[[bytes], ReaderResult]] = {
    ".npy": read_npy,
    ".x3p": read_x3p,
    ".xlsx": read_excel,
    **dict.fromkeys(TEXT_SUFFIXES, read_text),
}
"""File readers by file name extension, in lower case.

SurfaceTopography reads all other files, and binary files with the extension of a text file.
"""

_FILE_SIGNATURES = {
    b"\x93NUMPY": ((".npy",), "a NumPy array (.npy)"),
    b"PK": ((".x3p", ".xlsx"), "a zip archive, as X3P and workbooks are"),
}
"""First bytes of some types of files, with the usual file name extensions and a description of each type."""

MAX_DESCRIPTION_BYTES = 100_000
# This pattern matches DABAM files that contain slopes (format 1 or 3) instead of heights (format 2 or 4).
_DABAM_FORMAT_PATTERN = re.compile(rb'\A\s*\{.*"FILE_FORMAT"\s*:\s*([13])\s*[,}]', re.DOTALL)

MissingValueCodes = str | float | Sequence[str | float]
_Body = TypeVar("_Body", bound=Profile | Surface)


@dataclass(frozen=True)
class FileReading(Generic[_Body]):
    """Profile or height map read from a file, with a record of how the file was interpreted."""

    body: _Body
    file: str
    source: HeightProvenance
    unit: str
    """Unit of the heights in the file."""
    missing: int
    """Number of points in the file that have no height."""
    points: int
    """Number of points in the file."""
    caveats: tuple[FileCaveat, ...]

    def __str__(self) -> str:
        shape = " × ".join(map(str, self.body.heights.shape))
        steps = np.unique(self.body.spacings).tolist()
        spacing_text = format_with_unit(steps[0], "µm")
        if len(steps) > 1:
            along_y, along_x = (format_with_unit(spacing, "µm") for spacing in self.body.spacings[:2])
            spacing_text = f"{along_x} along x and {along_y} along y"
        source = self.source
        heights = (
            f"heights from {printable_text(source.column)} in {self.unit}"
            if source.column
            else f"heights in {self.unit}"
        )
        parts = [source.layout or "unknown layout", f"{shape} points", f"{spacing_text} apart", heights]
        parts += [f"{self.missing} of {self.points} missing" if self.missing else "none missing"]
        if source.lines is not None:
            skipped_text = " and ".join(
                f"{count} {where}"
                for count, where in ((source.lines_above, "above"), (source.lines_below, "below"))
                if count
            )
            parts += [
                f"lines {source.lines[0]} to {source.lines[1]}" + (f" ({skipped_text} skipped)" if skipped_text else "")
            ]
            format_words = [
                source.encoding,
                source.separator,
                f"decimal {'comma' if source.decimal_mark == ',' else 'point'}",
            ]
            parts += [", ".join(word for word in format_words if word)]
        return "; ".join(parts)

    def to_json_fields(self) -> dict[str, Any]:
        """Return the interpretation of the file (layout, column, units, caveats and others) as JSON fields."""
        source = self.source
        return {
            "file": self.file, "layout": source.layout, "points": list(self.body.heights.shape),
            "spacing_um": list(self.body.spacings), "heights": source.column, "unit": self.unit,
            "missing_points": self.missing, "encoding": source.encoding, "separator": source.separator,
            "decimal_mark": source.decimal_mark, "lines": None if source.lines is None else list(source.lines),
            "lines_above": source.lines_above, "lines_below": source.lines_below,
            "caveats": [{"name": caveat.name, "text": caveat.text, "remedy": caveat.remedy} for caveat in self.caveats],
        }  # fmt: skip


def read_profile(
    path: str | os.PathLike[str],
    *,
    unit: str | tuple[str, str] | None = None,
    spacing: str | None = None,
    missing: MissingPointTreatment = "error",
    channel: NameOrIndex | None = None,
    columns: NameOrIndex | Sequence[NameOrIndex] | None = None,
    outliers: OutlierTreatment = "keep",
    crop: str | Sequence[str] | None = None,
    missing_value: MissingValueCodes | None = None,
    accept: str | Sequence[str] | None = None,
) -> Profile:
    """Read a measured profile from a file.

    Parameters
    ----------
    path : path
        Text or CSV with one column of heights, or two of positions and heights, below an optional header; a NumPy array
        (.npy) of the same; X3P; a workbook (.xlsx) with the package openpyxl (``pip install openpyxl``); or a line scan
        in a format of SurfaceTopography (``pip install SurfaceTopography``).
    unit : str or (str, str), optional
        Unit of all lengths in the file ("um"), or of positions and of heights (("mm", "um")): m, mm, um, nm, pm.
        Required if the file contains no units; otherwise it must agree with them.
    spacing : str, optional
        Distance between neighbouring points, such as "0.5 um". Required if the file contains neither positions nor a
        spacing; otherwise it must agree with them.
    missing : {"error", "interpolate", "mask"}
        Treatment of points without a height: empty cells, NaN, asterisks or dashes. "mask" excludes these points from
        contact. "interpolate" puts them on a straight line between their neighbours. Both remove missing points at the
        ends of a profile. The history contains their number and position.
    channel : str or int, optional
        Name of the channel of an instrument file, or of the sheet of a workbook, or its number counted from 0. The
        default is the first channel of heights, or the only sheet. The history contains the choice and the
        alternatives.
    columns : (str or int, str or int), or str or int, optional
        Names or numbers, counted from 0, of the columns of positions and of heights in a table, or of heights only. The
        unit in a name can be omitted.
    outliers : {"keep", "mask"}
        "mask" treats points beyond 6 robust deviations of their neighbours, in groups of up to four, as missing.
    crop : str or sequence of str, optional
        Range to read, with units: "x0,x1" such as "10 um,50 um", or "x0,x1,y0,y1" for a surface. Applied first.
    missing_value : float, str, or several, optional
        Numbers, as in the file, or words that mark points without a height, such as -9999 or "Err".
    accept : str or sequence of str, optional
        Names of caveats to accept, such as "whole-numbers"; a `FormatWarning` contains them.

    Returns
    -------
    profile : Profile
        Profile in µm that starts at x = 0. The history describes what was read and the source of the spacing.

    Raises
    ------
    FormatError
        A `ValueError`, if the file cannot be read, is not a profile, is not uniform, lacks a unit, contradicts an
        argument, or has missing points.
    ValueError
        If an argument is invalid.

    Warns
    -----
    FormatWarning
        If the file contradicts itself, or if its heights or its size are implausible. The warning contains the name of
        each caveat and the option that resolves it.

    See Also
    --------
    read_surface : Maps.
    read_measurement : Profile or surface, depending on the file.
    write_profile : Inverse function.

    Notes
    -----
    Positions may deviate from a uniform grid within their printed digits. The spacing is (last - first)/(n - 1), unless
    the argument or the header gives a spacing that agrees with all positions as printed.

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
    return _read_profile_or_map(
        path,
        validate_read_options(unit, spacing, missing, channel, columns, outliers, crop, missing_value, accept),
        to_profile,
    )


def read_surface(
    path: str | os.PathLike[str],
    *,
    unit: str | tuple[str, str] | None = None,
    spacing: str | tuple[str, str] | None = None,
    missing: MissingPointTreatment = "error",
    channel: NameOrIndex | None = None,
    outliers: OutlierTreatment = "keep",
    crop: str | Sequence[str] | None = None,
    missing_value: MissingValueCodes | None = None,
    accept: str | Sequence[str] | None = None,
) -> Surface:
    """Read a measured surface from a file.

    Parameters
    ----------
    path : path
        Text or CSV with a matrix of heights of at least four columns, with x along the columns, and optionally its
        width and height in a header such as that of Gwyddion; a NumPy array (.npy); X3P; a workbook (.xlsx) with the
        package openpyxl (``pip install openpyxl``); or a format of SurfaceTopography (``pip install
        SurfaceTopography``).
    unit, missing, channel, outliers, crop, missing_value, accept
        As for `read_profile`. Missing points are interpolated along their row, or along the column if a neighbour in
        the row is missing.
    spacing : str or (str, str), optional
        Distance between neighbouring points, or distances between rows and between columns (Δy, Δx), such as "0.5 um".
        Required if the file contains no spacing; otherwise it must agree with it.

    Returns
    -------
    surface : Surface
        Surface in µm that starts at x = y = 0. The history describes what was read and the source of the spacing.

    Raises
    ------
    FormatError
        A `ValueError`, as for `read_profile`, or if the file is not a map.
    ValueError
        If an argument is invalid.

    Warns
    -----
    FormatWarning
        As for `read_profile`.

    See Also
    --------
    read_profile : Lines.
    read_measurement : Profile or surface, depending on the file.
    write_surface : Inverse function.

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
    return _read_profile_or_map(
        path,
        validate_read_options(unit, spacing, missing, channel, None, outliers, crop, missing_value, accept),
        to_surface,
    )


def read_measurement(
    path: str | os.PathLike[str],
    *,
    unit: str | tuple[str, str] | None = None,
    spacing: str | tuple[str, str] | None = None,
    missing: MissingPointTreatment = "error",
    channel: NameOrIndex | None = None,
    columns: NameOrIndex | Sequence[NameOrIndex] | None = None,
    outliers: OutlierTreatment = "keep",
    crop: str | Sequence[str] | None = None,
    missing_value: MissingValueCodes | None = None,
    accept: str | Sequence[str] | None = None,
) -> Profile | Surface:
    """Read a measured profile or height map; the content of the file determines which of the two is returned.

    Parameters
    ----------
    path, unit, missing, channel, columns, outliers, crop, missing_value, accept
        As for `read_profile`.
    spacing : str or (str, str), optional
        As for `read_surface`; a single value for a profile.

    Returns
    -------
    body : Profile or Surface
        Heights in µm: a surface if the file contains a map, otherwise a profile.

    Raises
    ------
    FormatError
        A `ValueError`, as for `read_profile`.
    ValueError
        If an argument is invalid.

    Warns
    -----
    FormatWarning
        As for `read_profile`.

    See Also
    --------
    read_profile, read_surface : Functions that accept only one kind of file.

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
    return _read_profile_or_map(
        path,
        validate_read_options(unit, spacing, missing, channel, columns, outliers, crop, missing_value, accept),
        to_profile_or_surface,
    )


def read_with_interpretation(path: str | os.PathLike[str], **options: Any) -> FileReading[Profile | Surface]:
    """Read a measured profile or height map, and record how the file was interpreted.

    The options are those of `read_measurement`. Caveats are returned in `caveats`, and no warning is issued.
    """
    option_names = ("unit", "spacing", "missing", "channel", "columns", "outliers", "crop", "missing_value", "accept")
    given_options = {"missing": "error", "outliers": "keep"} | {
        name: options.pop(name) for name in option_names if name in options
    }
    if options:
        raise ValueError(f"options for a file must be among {', '.join(option_names)}, got {next(iter(options))}")
    option_values = {name: given_options.get(name) for name in option_names}
    return _interpret_file(path, validate_read_options(**option_values), to_profile_or_surface)  # type: ignore[arg-type]


def _read_profile_or_map(
    path: str | os.PathLike[str],
    options: ReadOptions,
    convert: Callable[[RawHeights, str, ReadOptions], InterpretedScan[_Body]],
) -> _Body:
    """Read a profile or height map from a file, and issue a `FormatWarning` for each caveat the user did not accept."""
    reading = _interpret_file(path, options, convert)
    for caveat in reading.caveats:
        warn_caller(f"{printable_path(path)}: {caveat}", FormatWarning)
    return reading.body


def _interpret_file(
    path: str | os.PathLike[str],
    options: ReadOptions,
    convert: Callable[[RawHeights, str, ReadOptions], InterpretedScan[_Body]],
) -> FileReading[_Body]:
    """Read a profile or height map from a file, and record how the content of the file was interpreted.

    Every error message starts with the path.
    """
    path = parse_path("path", path)
    try:
        raw = select_heights(_read_content(path, options.words), options.channel, options.columns)
        interpreted_scan = convert(raw, path.name, options)
    except OSError as error:
        raise FormatError(f"{printable_path(path)}: cannot be read: {describe_os_error(error)}") from None
    except MemoryError:
        raise FormatError(f"{printable_path(path)}: does not fit into the memory of this machine") from None
    except ValueError as error:
        raise FormatError(f"{printable_path(path)}: {error}") from None
    return FileReading(
        interpreted_scan.body,
        path.name,
        raw.source,
        interpreted_scan.unit,
        interpreted_scan.missing,
        raw.heights.size,
        interpreted_scan.caveats,
    )


def _read_content(path: Path, words: tuple[str, ...]) -> ReaderResult:
    """Read a file with the reader that suits the file name extension and the first bytes of the file."""
    suffix = path.suffix.lower()
    try:
        check_is_file(path)
    except UnreadableFileError as error:
        raise FormatError(str(error)) from None
    size = path.stat().st_size
    if size == 0:
        raise FormatError("is empty")
    if size > MAX_FILE_BYTES:
        raise FormatError(f"has {size} bytes; at most {MAX_FILE_BYTES} can be read")
    _reject_described_slopes(path)
    reader = READERS.get(suffix)
    with path.open("rb") as file:
        first_bytes = file.read(4096)
    for signature, (suffixes, name) in _FILE_SIGNATURES.items():
        if reader is not None and first_bytes.startswith(signature) != (suffix in suffixes):
            name = name if first_bytes.startswith(signature) else f"not {name}"
            raise FormatError(f"has the file name extension {suffix or '(none)'}, but its content is {name}")
    if reader is None and first_bytes.startswith(b"\x93NUMPY"):
        reader = read_npy
    if reader is None and is_text(first_bytes) and size <= MAX_TEXT_BYTES:
        try:
            if find_layout(decode_text(path.read_bytes(), words)) is not None:
                reader = read_text
        except FormatError:
            pass
    if reader is read_text and size > MAX_TEXT_BYTES:
        raise FormatError(f"has {size} bytes of text; at most {MAX_TEXT_BYTES} can be read; save the heights as .npy")
    if reader is read_text and not is_text(first_bytes):
        return _read_binary_file(path)
    if reader is None:
        return _read_instrument_or_text_file(path, first_bytes, words)
    if reader in (read_text, read_excel):
        return reader(path.read_bytes(), words)
    return reader(path.read_bytes())


def _reject_described_slopes(path: Path) -> None:
    """Raise `FormatError` for a .dat file of the X-ray mirror database DABAM if its description declares slopes."""
    description = path.with_suffix(".txt")
    if path.suffix.lower() != ".dat" or not description.is_file() or description.stat().st_size > MAX_DESCRIPTION_BYTES:
        return
    match = _DABAM_FORMAT_PATTERN.search(description.read_bytes())
    if match is not None:
        raise FormatError(
            f"contains slopes, not heights, according to FILE_FORMAT {match[1].decode()} in {description.name}; "
            "integrate them to heights first"
        )


def _read_binary_file(path: Path) -> ReaderResult:
    """Read a file that turned out to be binary instead of text, with the package SurfaceTopography."""
    if is_reader_installed():
        try:
            return read_instrument_file(path)
        except FormatError as error:
            raise FormatError(f"is binary, not text, and {error}") from None
    kind_text = f", although its file name ends in {path.suffix}" if path.suffix else " without a file name extension"
    raise FormatError(
        f"is a binary file{kind_text}; the package "
        "SurfaceTopography may be able to read it (pip install SurfaceTopography)"
    )


def _read_instrument_or_text_file(path: Path, start: bytes, words: tuple[str, ...]) -> ReaderResult:
    """Read a file with SurfaceTopography or, if SurfaceTopography cannot read it, as a table of text."""
    try:
        return read_instrument_file(path)
    except FormatError as error:
        if not is_text(start) or path.stat().st_size > MAX_TEXT_BYTES:
            raise
        try:
            return read_text(path.read_bytes(), words)
        except FormatError:
            raise error from None
