"""Reading and writing measured profiles and surfaces. A unit is never guessed."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np

from stiction._checks import Floats, choice
from stiction._files import new_file
from stiction._units import Quantity, quantity
from stiction.surfaces.profile import FEWEST_POINTS, MOST_POINTS, Profile
from stiction.surfaces.raw import (
    LENGTH_UNITS,
    MOST_BYTES,
    MOST_TEXT_BYTES,
    FormatError,
    FormatWarning,
    Raw,
    length_unit,
)
from stiction.surfaces.surface import Surface
from stiction.surfaces.text import read_text
from stiction.surfaces.x3p import read_x3p

__all__ = [
    "FormatError",
    "FormatWarning",
    "read_measurement",
    "read_profile",
    "read_surface",
    "write_profile",
    "write_surface",
]

Missing = Literal["error", "interpolate"]

TEXT_SUFFIXES = ("", ".txt", ".csv", ".tsv", ".dat", ".asc", ".prn", ".xy", ".text")

UNEVEN = 1e-3
"""Spacings by which a point may be off a uniform grid: nothing in the heights shows it, and positions that went through
single precision have it."""

TELLING = 1000
"""Last printed digits that the length must have, if they make up for uneven positions: the spacing is then good to
1/1000."""

FEW = 8
"""Columns, or rows, of positions and some heights; a surface has more."""

_SPACINGS = (1e-6, 1e6)
_HIGHEST = 1e9
"""µm; what is outside is no length of a surface, but a slip of the unit or a mark for missing points."""

_Body = TypeVar("_Body", bound=Profile | Surface)
_Length = TypeVar("_Length", float, Floats)


def read_profile(
    path: str | os.PathLike[str],
    *,
    unit: str | tuple[str, str] | None = None,
    spacing: str | None = None,
    missing: Missing = "error",
) -> Profile:
    """Read a measured profile.

    Parameters
    ----------
    path : path
        Text or CSV with one column of heights or two of positions and heights, below any other text; a NumPy array
        (.npy); X3P; or, with the package SurfaceTopography installed (``pip install "stiction[formats]"``), what that
        reads of line scans.
    unit : str or (str, str), optional
        Of all lengths in the file ("um"), or of positions and of heights (("mm", "um")): m, mm, um, nm, pm. Needed
        where the file does not say; where it does, it must say the same.
    spacing : str, optional
        Distance between neighbouring points, as in "0.5 um". Needed where the file has neither positions nor a spacing;
        where it has, it must agree.
    missing : {"error", "interpolate"}
        What to do about points without a height, which are empty, NaN, or written as stars or dashes. "interpolate"
        puts them on a straight line between their neighbours and leaves them out at the ends; how many is said in the
        history.

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
    """
    asked = _asked(unit, spacing, missing)
    return _made(path, lambda raw, name: _profile(raw, name, asked))


def read_surface(
    path: str | os.PathLike[str],
    *,
    unit: str | tuple[str, str] | None = None,
    spacing: str | tuple[str, str] | None = None,
    missing: Missing = "error",
) -> Surface:
    """Read a measured surface.

    Parameters
    ----------
    path : path
        Text or CSV with a matrix of heights of at least four columns, the columns along x; a NumPy array (.npy); X3P;
        or, with the package SurfaceTopography installed (``pip install "stiction[formats]"``), what that reads.
    unit, missing
        As for `read_profile`. Missing points lie on a line between their neighbours in the row, and where these are
        missing too, in the column.
    spacing : str or (str, str), optional
        Distance between neighbouring points, or that between rows and that between columns (Δy, Δx).

    Returns
    -------
    Surface

    Raises
    ------
    FormatError, ValueError
        As `read_profile`.
    """
    asked = _asked(unit, spacing, missing)
    return _made(path, lambda raw, name: _surface(raw, name, asked))


def read_measurement(
    path: str | os.PathLike[str],
    *,
    unit: str | tuple[str, str] | None = None,
    spacing: str | tuple[str, str] | None = None,
    missing: Missing = "error",
) -> Profile | Surface:
    """Read a measured profile or surface, whichever the file holds.

    Parameters
    ----------
    path, unit, missing
        As for `read_profile`.
    spacing : str or (str, str), optional
        As for `read_surface`; a profile has one.

    Returns
    -------
    Profile or Surface

    Raises
    ------
    FormatError, ValueError
        As `read_profile`.
    """
    asked = _asked(unit, spacing, missing)
    return _made(path, lambda raw, name: (_profile if raw.heights.ndim == 1 else _surface)(raw, name, asked))


# ---- From a file to numbers -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Asked:
    """What the caller says of a file."""

    position_unit: str | None
    height_unit: str | None
    spacing: tuple[Quantity | None, Quantity | None]
    missing: Missing


def _asked(unit: Any, spacing: Any, missing: Missing) -> _Asked:
    choice("missing", missing, Missing)
    pair = spacing if isinstance(spacing, tuple) else (spacing, spacing)
    if len(pair) != 2:
        raise ValueError(f"spacing must be one quantity or a pair (Δy, Δx), got {spacing!r}")
    return _Asked(*_units(unit), (_given("spacing", pair[0]), _given("spacing", pair[1])), missing)


def _made(path: str | os.PathLike[str], make: Callable[[Raw, str], _Body]) -> _Body:
    """What is made of a file and its name; every error says the whole path."""
    path = Path(path)
    try:
        return make(_unfolded(_raw(path)), path.name)
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise FormatError(f"{path}: cannot be read: {reason}") from None
    except MemoryError:
        raise FormatError(f"{path}: is too large for the memory of this machine") from None
    except ValueError as error:
        raise FormatError(f"{path}: {error}") from None


def _unfolded(raw: Raw) -> Raw:
    """A matrix of one row or one column as the profile that it is."""
    if raw.heights.ndim == 1 or min(raw.heights.shape) > 1:
        return raw
    along = int(raw.heights.shape[1] > 1)
    return replace(raw, heights=raw.heights.ravel(), spacing=None if raw.spacing is None else (raw.spacing[along],))


def _profile(raw: Raw, name: str, asked: _Asked) -> Profile:
    if raw.heights.ndim != 1:
        raise FormatError(
            f"holds {raw.heights.shape[0]} rows of {raw.heights.shape[1]} columns; a profile has one column of "
            "heights or two of positions and heights, and read_surface() reads surfaces"
        )
    if raw.heights.size < FEWEST_POINTS:
        raise FormatError(f"holds {raw.heights.size} point(s); a profile needs at least {FEWEST_POINTS}")
    given, other = asked.spacing
    if given != other:
        raise FormatError("holds a profile, which has one spacing; two are given")
    heights = _heights(raw, asked.height_unit)
    dx, steps = _profile_spacing(raw, asked.position_unit, given)
    if dx < 0:
        heights, dx = heights[::-1], -dx
        steps.append("turned round, because its positions decreased")
    heights, filled = _line_without_gaps(heights, asked.missing)
    return Profile(heights, spacing=_sane(dx), history=(f"read from {name}", *steps, *filled))


def _surface(raw: Raw, name: str, asked: _Asked) -> Surface:
    if raw.heights.ndim != 2:
        raise FormatError(f"holds a profile of {raw.heights.size} points; read_profile() reads profiles")
    heights = _heights(raw, asked.height_unit)
    if raw.spacing is not None:
        length = _unit("positions", raw.position_unit, asked.position_unit)
        dy, dx = (_agreeing(_in_um(own, length), each) for own, each in zip(raw.spacing, asked.spacing, strict=True))
    elif asked.spacing[0] is not None and asked.spacing[1] is not None:
        dy, dx = float(asked.spacing[0]), float(asked.spacing[1])
        own, off = _stated(raw) or (dx, 0.0)  # of one of the two, whichever
        if min(abs(own - dy), abs(own - dx)) > off:
            raise FormatError(f"says that its spacing is {own:g} µm, but {dy:g} µm and {dx:g} µm are given")
    else:
        raise FormatError('holds no spacing; give it, as in "0.5 um", or "2 um" for rows and "0.5 um" for columns')
    heights, filled = _area_without_gaps(heights, asked.missing)
    return Surface(heights, spacing=(_sane(dy), _sane(dx)), history=(f"read from {name}", *filled))


def _raw(path: Path) -> Raw:
    suffix = path.suffix.lower()
    if not path.is_file():
        path.stat()  # which says why there is none
        raise FormatError("is a directory" if path.is_dir() else "is not a file")
    size = path.stat().st_size
    if size == 0:
        raise FormatError("is empty")
    if size > MOST_BYTES:
        raise FormatError(f"has {size} bytes; at most {MOST_BYTES} can be read")
    with path.open("rb") as file:
        start = file.read(8)
    kind = ".npy" if start.startswith(b"\x93NUMPY") else ".x3p" if start.startswith(b"PK") else ""
    if suffix in (".npy", ".x3p", *TEXT_SUFFIXES) and kind != (suffix if suffix in (".npy", ".x3p") else ""):
        names = {".npy": "a NumPy array (.npy)", ".x3p": "a zip archive, as X3P is", "": "neither of .npy nor of .x3p"}
        raise FormatError(f"is named {suffix or 'without an ending'}, but what it holds is {names[kind]}")
    if kind == ".npy":
        return _without_positions(Raw(_array(path)))
    if suffix == ".x3p":
        return read_x3p(path.read_bytes())
    if suffix in TEXT_SUFFIXES:
        if size > MOST_TEXT_BYTES:
            raise FormatError(f"has {size} bytes of text; at most {MOST_TEXT_BYTES} can be read: save it as .npy")
        return _without_positions(read_text(path.read_bytes()))
    return _instrument(path)


def _without_positions(raw: Raw) -> Raw:
    """What is no more than numbers in rows and columns, unless some of these are positions."""
    if raw.heights.ndim == 2 and min(raw.heights.shape) > 1:
        rows, columns = raw.heights.shape
        first_column, first_row = _even(raw.heights[:, 0]), _even(raw.heights[0])
        plane = _even(raw.heights[:, -1]) and _even(raw.heights[-1])
        labelled = first_column and first_row
        if not plane and (labelled or (first_column and columns < FEW) or (first_row and rows < FEW)):
            raise FormatError(
                f"holds {rows} rows of {columns} columns, of which the first "
                f"{'row and column count' if labelled else 'column counts' if first_column else 'row counts'} "
                "evenly, as positions do; leave the heights alone"
            )
    return raw


def _even(values: Floats) -> bool:
    """Whether values but for the first, which may be a corner, rise or fall in equal steps."""
    steps = np.diff(values[1:])
    return steps.size > 2 and bool(np.ptp(steps) <= UNEVEN * abs(steps.mean()) and steps.mean() != 0)


def _array(path: Path) -> Floats:
    try:
        with warnings.catch_warnings(action="ignore"):
            stored = np.lib.format.open_memmap(path, mode="r")
    except OSError:
        raise
    except Exception as error:  # the header is a Python literal, which fails in many ways
        raise FormatError(f"is a damaged .npy file, or one of objects ({str(error)[:80]})") from None
    if stored.dtype.kind not in "iuf" or stored.ndim not in (1, 2):
        raise FormatError(
            f"holds an array of {stored.dtype} and shape {stored.shape}; heights are real numbers along x, or y and x"
        )
    if stored.size > MOST_POINTS:
        raise FormatError(f"holds {stored.size} points; at most {MOST_POINTS} can be read")
    with np.errstate(all="ignore"):
        return np.array(stored, dtype=np.float64, order="C")


def _instrument(path: Path) -> Raw:
    """By the readers of SurfaceTopography, which know some forty formats of instruments."""
    try:
        with warnings.catch_warnings(action="ignore"):  # of what it would use if it were there
            from SurfaceTopography import open_topography
    except ImportError:
        raise FormatError(
            f"ends in {path.suffix}, which the package SurfaceTopography may read: "
            'pip install "stiction[formats]"; text should end in .csv or .txt'
        ) from None
    try:
        with warnings.catch_warnings(action="ignore"), open_topography(str(path)) as reader:
            channel = reader.default_channel
            points = int(np.prod(channel.nb_grid_pts))
            if points > MOST_POINTS:
                raise FormatError(f"holds {points} points; at most {MOST_POINTS} can be read")
            known = channel.physical_sizes is not None
            body = channel.topography() if known else channel.topography(physical_sizes=_pixels(channel.nb_grid_pts))
            heights = np.ma.filled(np.ma.asarray(body.heights(), dtype=np.float64), np.nan)
            unit = None if body.unit is None else str(body.unit)
            if not body.is_uniform:
                positions = np.array(body.positions(), dtype=np.float64)
                return Raw(heights, unit=unit, positions=positions, digit=np.zeros(positions.shape), position_unit=unit)
            spacing = None
            if known:
                along_x_first = np.atleast_1d(body.pixel_size)
                spacing = tuple(float(each) for each in reversed(along_x_first))
    except FormatError:
        raise
    except Exception as error:  # forty readers have as many ways to fail
        said = f"{type(error).__name__}: {' '.join(str(error).split())[:120]}"
        if type(error).__name__ == "CannotDetectFileFormat":  # which goes on with what each of the forty says
            said = "none of its formats"
        raise FormatError(
            f"is no profile or surface that SurfaceTopography reads ({said}); text should end in .csv or .txt"
        ) from None
    # SurfaceTopography has x along the first axis.
    return Raw(np.ascontiguousarray(heights.T), unit=unit, spacing=spacing, position_unit=unit)


def _pixels(points: Any) -> Any:
    """Sizes of a body whose file gives none, for a reader that wants some: what is made of them is not used."""
    return tuple(float(each) for each in np.atleast_1d(points))


# ---- Units and spacings ---------------------------------------------------------------------------------------------


def _units(unit: Any) -> tuple[str | None, str | None]:
    """Of positions and of heights."""
    pair = unit if isinstance(unit, tuple) else (unit, unit)
    if len(pair) != 2 or not all(each is None or (isinstance(each, str) and length_unit(each)) for each in pair):
        raise ValueError(f"unit must be a unit of length (m, mm, um, nm, pm) or a pair of them, got {unit!r}")
    return pair


def _given(name: str, text: Any) -> Quantity | None:
    if text is None:
        return None
    try:
        length = quantity(text, "length")
    except ValueError as error:
        raise ValueError(f"{name} {error}") from None
    if not length > 0:
        raise ValueError(f"{name} must be above 0, got {text!r}")
    return length


def _unit(what: str, of_file: str | None, of_caller: str | None) -> str:
    """What file and caller say, of whom one must."""
    known = None if of_file is None else length_unit(of_file)
    if of_file is not None and known is None:
        raise FormatError(f"has {what} in {of_file!r}, which is no length that is known here (m, mm, um, nm, ...)")
    caller = None if of_caller is None else length_unit(of_caller)
    if known is not None and caller is not None and LENGTH_UNITS[known] != LENGTH_UNITS[caller]:
        raise FormatError(f"says that its {what} are in {of_file}, but unit says {of_caller}")
    unit = known if known is not None else caller
    if unit is None:
        raise FormatError(f'does not say in which unit its {what} are; give the unit, as in "um"')
    return unit


def _in_um(values: _Length, unit: str) -> _Length:
    factor = LENGTH_UNITS[unit]
    # A division, where it is one, so that 100 nm are 0.1 µm to the bit.
    return values / round(1 / factor) if factor < 1 else values * factor


def _heights(raw: Raw, unit: str | None) -> Floats:
    with np.errstate(all="ignore"):
        heights = _in_um(raw.heights, _unit("heights", raw.unit, unit))
        wild = np.abs(heights) > _HIGHEST
    if wild.any():
        value = heights[wild].flat[0]
        raise FormatError(
            f"holds a height of {value:.3g} µm, which is none of a surface ({int(wild.sum())} such values); "
            "if it marks missing points, write them as nan"
        )
    return heights


def _profile_spacing(raw: Raw, unit: str | None, given: Quantity | None) -> tuple[float, list[str]]:
    """Spacing of a profile in µm, negative if its positions decrease, and what the history says of it."""
    stated = _stated(raw)
    if raw.positions is None:
        if raw.spacing is not None:
            own_spacing = _in_um(raw.spacing[0], _unit("positions", raw.position_unit, unit))
            return _agreeing(own_spacing, given), []
        if stated is not None:
            if given is not None and abs(given - stated[0]) > stated[1]:
                raise FormatError(f"says that its spacing is {stated[0]:g} µm, but spacing says {given.text}")
            return given if given is not None else stated[0], []
        if given is None:
            raise FormatError('holds heights only; give the spacing of its points, as in "0.5 um"')
        return given, []
    length = _unit("positions", raw.position_unit, unit)
    digit = np.zeros(raw.positions.shape) if raw.digit is None else raw.digit
    with np.errstate(all="ignore"):
        x, digit = _in_um(raw.positions, length), _in_um(digit, length)
        if not np.isfinite(x).all() or np.abs(x).max() > _HIGHEST:
            at = int(np.flatnonzero(~(np.abs(x) <= _HIGHEST))[0])
            raise FormatError(f"has no usable position at point {at + 1}; each height needs one")
        measured = float((x[-1] - x[0]) / (x.size - 1))
        direction = -1.0 if measured < 0 else 1.0
        if given is not None:
            if _worst(x, direction * given, digit, UNEVEN * given) is not None:
                _worst_of(x, measured, digit)  # if it is not uniform at all, that is what is wrong
                raise FormatError(
                    f"says by its positions that the spacing is {abs(measured):.7g} µm, but spacing says {given.text}"
                )
            return direction * given, [f"spacing {given:.7g} µm as given, which fits its positions"]
        if stated is not None and _worst(x, direction * stated[0], digit, 1e-9 * stated[0]) is None:
            return direction * stated[0], [f"spacing {stated[0]:.7g} µm as it says, which fits its positions"]
        _worst_of(x, measured, digit)
    step = f"spacing {abs(measured):.7g} µm from its positions"
    if stated is not None:
        if abs(abs(measured) - stated[0]) > stated[1] + digit.max() / (x.size - 1):
            warnings.warn(
                f"its spacing is said to be {stated[0]:g} µm, but its positions are {abs(measured):.7g} µm apart, "
                "which is taken",
                FormatWarning,
                stacklevel=6,
            )
        step += f", where it says {stated[0]:g} µm"
    return measured, [step]


def _stated(raw: Raw) -> tuple[float, float] | None:
    """The spacing that stands in words in a file and how far off it may be, µm."""
    if raw.stated is None:
        return None
    factor = LENGTH_UNITS[raw.stated.unit]
    return raw.stated.spacing * factor, 0.51 * raw.stated.digit * factor


def _worst(x: Floats, spacing: float, digit: Floats, slack: float) -> tuple[int, float] | None:
    """The point that is most off a uniform grid and by how much, if the printed digits do not explain it."""
    steps = np.arange(x.size)
    off = x - x[0] - steps * spacing
    # Rounded, first and last point are off by half a digit each; cut off, by less than one together.
    explained = np.maximum(digit, np.linspace(digit[0], digit[-1], x.size)) * (1 + 1e-6)
    round_off = 4 * np.finfo(np.float64).eps * np.abs(x).max()
    beyond = np.abs(off) - explained - slack - round_off
    at = int(np.argmax(beyond))
    return (at, float(off[at])) if beyond[at] > 0 else None


def _worst_of(x: Floats, measured: float, digit: Floats) -> None:
    """Refuse positions that are not uniform, or have too few digits to tell their spacing."""
    if measured == 0:
        raise FormatError("has first and last point at the same position")
    worst = _worst(x, measured, digit, UNEVEN * abs(measured))
    if worst is not None:
        at, off = worst
        raise FormatError(
            f"is not uniform: point {at + 1} is at {x[at]:.7g} µm, {abs(off):.3g} µm away from where a spacing of "
            f"{abs(measured):.6g} µm puts it; resample it first"
        )
    even = np.abs(np.diff(x) - measured).max() <= UNEVEN * abs(measured)
    if not even and abs(x[-1] - x[0]) < TELLING * digit.max():
        raise FormatError(
            f"has positions with too few digits to tell their spacing ({abs(measured):.3g} µm?); give it, as in "
            '"0.5 um"'
        )


def _agreeing(own: float, given: Quantity | None) -> float:
    if given is not None and not abs(own - given) <= UNEVEN * abs(own):
        raise FormatError(f"says that its spacing is {own:.7g} µm, but spacing says {given.text}")
    return own


def _sane(spacing: float) -> float:
    lowest, highest = _SPACINGS
    if not lowest <= spacing <= highest:
        raise FormatError(f"has a spacing of {spacing:g} µm; from {lowest:g} to {highest:g} µm is allowed")
    return spacing


# ---- Missing points -------------------------------------------------------------------------------------------------


def _line_without_gaps(heights: Floats, missing: Missing) -> tuple[Floats, list[str]]:
    gaps = np.isnan(heights)
    if not gaps.any():
        return heights, []
    _refuse_gaps(gaps, missing)
    known = np.flatnonzero(~gaps)
    first, end = int(known[0]), int(known[-1]) + 1
    inside = int(gaps[first:end].sum())
    outside = heights.size - (end - first)
    steps = [f"{inside} missing points interpolated"] if inside else []
    steps += [f"{outside} missing points at its ends left out"] if outside else []
    return np.interp(np.arange(first, end), known, heights[known]), steps


def _area_without_gaps(heights: Floats, missing: Missing) -> tuple[Floats, list[str]]:
    gaps = np.isnan(heights)
    if not gaps.any():
        return heights, []
    _refuse_gaps(gaps, missing)
    filled = heights.copy()
    for lines in (filled, filled.T):
        for line in lines:
            known = np.flatnonzero(~np.isnan(line))
            if known.size:
                inside = slice(known[0], known[-1] + 1)
                line[inside] = np.interp(np.arange(known[0], known[-1] + 1), known, line[known])
    left = int(np.isnan(filled).sum())
    if left:
        raise FormatError(
            f"has {left} missing points at its edges without neighbours on both sides to interpolate from"
        )
    return filled, [f"{int(gaps.sum())} missing points interpolated"]


def _refuse_gaps(gaps: np.ndarray[Any, Any], missing: Missing) -> None:
    if gaps.all():
        raise FormatError("has no heights: all points are missing")
    if missing == "error":
        first = " ".join(str(int(index) + 1) for index in np.argwhere(gaps)[0])
        raise FormatError(
            f"has {int(gaps.sum())} missing points of {gaps.size}, the first at {first}; "
            '"interpolate" for missing puts them on a line between their neighbours'
        )


# ---- Writing --------------------------------------------------------------------------------------------------------


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
