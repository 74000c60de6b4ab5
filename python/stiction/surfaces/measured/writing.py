"""Writing profiles and surfaces, every number to the bit."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from stiction._checks import Floats
from stiction._files import new_file
from stiction.surfaces.measured.raw import FormatError
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface


def write_profile(profile: Profile, path: str | os.PathLike[str]) -> None:
    """Write a profile, every number to the bit.

    Parameters
    ----------
    profile : Profile
    path : path
        Ending in .csv: positions and heights in µm, with the spacing, the history and the units above them; or in .npy:
        the heights alone, in µm, so that reading it back needs `unit` and `spacing`. It must not exist yet, and appears
        when it is whole.

    Raises
    ------
    FormatError
        If the ending is another, or the file exists already or cannot be written.
    """
    if not isinstance(profile, Profile):
        raise ValueError(f"profile must be a Profile, got {type(profile).__name__}")
    with _new_file(path, (".csv", ".npy")) as partial:
        if Path(path).suffix.lower() == ".npy":
            _save(partial, profile.heights)
            return
        with partial.open("w", encoding="utf-8", newline="\n") as file:
            file.write(f"# spacing: {profile.spacing!r} um\n")
            file.writelines(f"# history: {' '.join(step.split())}\n" for step in profile.history)
            file.write("x (um),z (um)\n")
            pairs = zip(profile.x.tolist(), profile.heights.tolist(), strict=True)
            file.writelines(f"{x!r},{z!r}\n" for x, z in pairs)


def write_surface(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write the heights of a surface in µm to a NumPy array, ending in .npy; otherwise as `write_profile`."""
    if not isinstance(surface, Surface):
        raise ValueError(f"surface must be a Surface, got {type(surface).__name__}")
    with _new_file(path, (".npy",)) as partial:
        _save(partial, surface.heights)


def _save(path: Path, heights: Floats) -> None:
    with path.open("wb") as file:  # np.save() would add an ending
        np.save(file, heights)


@contextmanager
def _new_file(path: str | os.PathLike[str], suffixes: tuple[str, ...]) -> Iterator[Path]:
    """`new_file` of a name that says what is in it."""
    path = Path(path)
    if path.suffix.lower() not in suffixes:
        raise FormatError(f"{path}: cannot be written: its name must end in {' or '.join(suffixes)}")
    with new_file(path, FormatError) as partial:
        yield partial
