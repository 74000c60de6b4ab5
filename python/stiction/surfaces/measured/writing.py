"""Lossless file output of profiles and height maps, as .csv or .npy."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterable

from stiction._checks import check_instance, parse_path
from stiction._files import create_file_atomically
from stiction._text import printable_text
from stiction.surfaces.measured.npy import write_npy
from stiction.surfaces.measured.raw import FormatError
from stiction.surfaces.measured.shapes import MIN_MATRIX_COLUMNS
from stiction.surfaces.measured.text_table import MAX_HISTORY_ENTRY_CHARACTERS
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface


def write_profile(profile: Profile, path: str | os.PathLike[str]) -> None:
    """Write a profile with its spacing, unit and history to a .csv or .npy file.

    All numbers are preserved exactly.

    Parameters
    ----------
    profile : Profile
        Profile to write.
    path : path
        Path that ends in .csv or .npy. A .csv file contains positions and heights in µm, below the spacing, the history
        and the units. A .npy file contains the heights in µm, which `numpy.load` returns, followed by arrays of the
        spacing and the history. The file must not exist; it appears when it is complete.

    Raises
    ------
    FormatError
        A `ValueError`, if the path has another ending, or the file exists or cannot be written.

    See Also
    --------
    read_profile : Inverse function.

    Examples
    --------
    >>> import pathlib
    >>> import tempfile
    >>> from stiction import Profile, read_profile, write_profile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "scan.csv"
    >>> write_profile(Profile([0.0, 0.1, 0.0, -0.1], spacing=0.5), path)
    >>> read_profile(path).heights
    array([ 0. ,  0.1,  0. , -0.1])
    """
    check_instance("profile", profile, Profile, "a Profile")
    pairs = zip(profile.x.tolist(), profile.heights_with_nan.tolist(), strict=True)
    rows = itertools.chain(["x (um),z (um)\n"], (f"{x!r},{z!r}\n" for x, z in pairs))
    _write_body(profile, path, [f"# spacing: {profile.spacing!r} um\n"], rows)


def write_surface(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map with its spacings, unit and history to a .csv or .npy file.

    All numbers are preserved exactly.

    Parameters
    ----------
    surface : Surface
        Surface to write.
    path : path
        Path that ends in .csv or .npy. A .csv file contains the matrix of heights in µm, with at least four columns,
        below the spacings along y and x, the history and the unit. For .npy see `write_profile`.

    Raises
    ------
    FormatError
        A `ValueError`, as for `write_profile`, or if a .csv would have too few columns to be recognised as a matrix.

    See Also
    --------
    read_surface : Inverse function.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> from stiction import Surface, read_surface, write_surface
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "map.npy"
    >>> write_surface(Surface([[0.0, 1.0], [2.0, 3.0]], spacing=(0.5, 0.25)), path)
    >>> read_surface(path).spacing
    (0.5, 0.25)
    """
    check_instance("surface", surface, Surface, "a Surface")
    columns = surface.heights.shape[1]
    path = parse_path("path", path)
    if path.suffix.lower() == ".csv" and columns < MIN_MATRIX_COLUMNS:
        raise FormatError(
            f"{path}: cannot be written: a matrix in .csv must have at least {MIN_MATRIX_COLUMNS} columns, but the "
            f"surface has {columns}; choose .npy"
        )
    head = [f"# spacing along {axis}: {step!r} um\n" for axis, step in zip("yx", surface.spacing, strict=True)]
    rows = (",".join(map(repr, row)) + "\n" for row in surface.heights_with_nan.tolist())
    _write_body(surface, path, head, itertools.chain(["# heights (um)\n"], rows))


def _write_body(
    body: Profile | Surface, path: str | os.PathLike[str], header_lines: list[str], rows: Iterable[str]
) -> None:
    """Write a profile or height map to a .csv file, or as three arrays to a .npy file, including its history."""
    path = parse_path("path", path)
    if path.suffix.lower() not in (".csv", ".npy"):
        raise FormatError(f"{path}: cannot be written: its name must end in .csv or .npy")
    with create_file_atomically(path, FormatError) as partial_file:
        if path.suffix.lower() == ".npy":
            with partial_file.open("wb") as binary_file:
                write_npy(binary_file, body.heights_with_nan, body.spacings, body.history)
            return
        steps = (" ".join(step.split()) for step in body.history)
        history = [f"# history: {printable_text(step, MAX_HISTORY_ENTRY_CHARACTERS)}\n" for step in steps]
        with partial_file.open("w", encoding="utf-8", newline="\n") as file:
            file.writelines(itertools.chain(header_lines, history, rows))
