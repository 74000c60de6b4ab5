"""Third step of reading: resolve the units, the spacing and the missing points of a scan, in µm.

Nothing is guessed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Generic, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats, check_choice, read_only
from stiction._units import Quantity, quantity
from stiction.surfaces.measured.plausibility import CAVEATS, Scan, caveats_of
from stiction.surfaces.measured.raw import LENGTH_UNITS, Caveat, FormatError, Raw, Stated, length_unit
from stiction.surfaces.measured.shapes import UNEVEN, Chosen
from stiction.surfaces.missing_data import MIN_OUTLIER_DEVIATIONS, describe_missing, find_outliers, interpolate_missing
from stiction.surfaces.preparation import find_crop_range
from stiction.surfaces.profile import MIN_POINTS, Profile
from stiction.surfaces.surface import Surface

Missing = Literal["error", "interpolate", "mask"]
Outliers = Literal["keep", "mask"]

TELLING = 1000
"""Last printed digits that the length must have, if they make up for uneven positions: the spacing is then good to
1/1000."""

_SPACINGS = (1e-6, 1e6)
_HIGHEST = 1e9  # µm; what is outside is no length of a surface, but a slip of the unit or a mark for missing points
SAME = 1e-6  # relative difference of a height from a code for missing points, in files of single precision
_Length = TypeVar("_Length", float, Floats)


@dataclass(frozen=True)
class ReadOptions:
    """What the caller says about a file, checked."""

    position_unit: str | None
    height_unit: str | None
    spacing: tuple[Quantity | None, Quantity | None]
    missing: Missing
    channel: Chosen | None
    columns: tuple[Chosen, ...] | None
    outliers: Outliers
    crop: tuple[float, ...] | None  # first and last x, and of a surface y, µm
    codes: tuple[float, ...] = ()  # heights of missing points, as they stand in the file
    words: tuple[str, ...] = ()  # words for them
    accept: tuple[str, ...] = ()  # names of caveats that are settled
    one_unit: bool = False  # whether one unit is given for all lengths: then it is for those without one in the file


def read_options(
    unit: Any, spacing: Any, missing: Missing, channel: Any = None, columns: Any = None, outliers: Outliers = "keep",
    crop: Any = None, missing_value: Any = None, accept: Any = None,
) -> ReadOptions:  # fmt: skip
    """Check what the caller says about a file."""
    codes, words = _codes(missing_value)
    accepted = tuple(part.strip() for part in accept.split(",")) if isinstance(accept, str) else tuple(accept or ())
    if not set(accepted) <= set(CAVEATS):
        raise ValueError(f"accept must be one of {', '.join(CAVEATS)}, or several, got {accept!r}")
    check_choice("missing", missing, Missing)
    check_choice("outliers", outliers, Outliers)
    crop = crop.split(",") if isinstance(crop, str) else crop
    if crop is not None and not (isinstance(crop, (list, tuple)) and len(crop) in (2, 4)):
        raise ValueError(f'crop must be "x0,x1" or "x0,x1,y0,y1", got {crop!r}')
    pair = spacing if isinstance(spacing, tuple) else (spacing, spacing)
    if len(pair) != 2:
        raise ValueError(f"spacing must be one quantity or a pair (Δy, Δx), got {spacing!r}")
    if columns is not None:
        columns = (columns,) if isinstance(columns, (str, int)) else columns
        if not isinstance(columns, (tuple, list)) or len(columns) not in (1, 2, 3):
            raise ValueError(
                "columns must be one of heights, or two of positions and heights, or three of x, y and z, "
                f"got {columns!r}"
            )
    for name, each in (("channel", channel), *(("columns", column) for column in columns or ())):
        if each is not None and (isinstance(each, bool) or not isinstance(each, (str, int))):
            raise ValueError(f"{name} must be a name or a number from 0 on, got {each!r}")
    columns = None if columns is None else tuple(columns)
    dy, dx = (None if each is None else _length("spacing", each) for each in pair)
    crop = None if crop is None else tuple(float(_length("crop", each, zero=True)) for each in crop)
    return ReadOptions(
        *_units(unit),
        (dy, dx),
        missing,
        channel,
        columns,
        outliers,
        crop,
        codes,
        words,
        accepted,
        isinstance(unit, str),
    )


def _codes(given: Any) -> tuple[tuple[float, ...], tuple[str, ...]]:
    """Return codes of missing points that are numbers, and those that are words."""
    parts = given.split(",") if isinstance(given, str) else () if given is None else given
    parts = (parts,) if isinstance(parts, (int, float)) else parts
    codes, words = [], []
    for part in parts:
        if isinstance(part, bool) or not isinstance(part, (str, int, float)) or not str(part).strip():
            raise ValueError(f"missing_value must be a number or a word, or several, got {given!r}")
        try:
            codes.append(float(part))
        except ValueError:
            words.append(str(part).strip())
    return tuple(codes), tuple(words)


def _without_unit_axis(raw: Raw) -> Raw:
    """A matrix of one row or one column as the profile that it is."""
    if raw.heights.ndim == 1 or min(raw.heights.shape) > 1:
        return raw
    along = int(raw.heights.shape[1] > 1)
    return replace(raw, heights=raw.heights.ravel(), spacing=None if raw.spacing is None else (raw.spacing[along],))


_Body = TypeVar("_Body", bound=Profile | Surface, covariant=True)


@dataclass(frozen=True)
class Interpreted(Generic[_Body]):
    """A profile or a surface with what was resolved on the way."""

    body: _Body
    unit: str  # of heights in the file
    missing: int  # points without a height in the file
    caveats: tuple[Caveat, ...] = ()


def to_profile_or_surface(raw: Raw, name: str, options: ReadOptions) -> Interpreted[Profile | Surface]:
    """Return a profile or a surface, whichever the file holds."""
    if _without_unit_axis(raw).heights.ndim == 1:
        return to_profile(raw, name, options)
    return to_surface(raw, name, options)


def to_profile(raw: Raw, name: str, options: ReadOptions) -> Interpreted[Profile]:
    """Return a profile."""
    raw = _without_unit_axis(raw)
    if raw.heights.ndim != 1:
        raise FormatError(
            f"holds {raw.heights.shape[0]} rows of {raw.heights.shape[1]} columns; a profile has one column of "
            "heights or two of positions and heights, and read_surface() reads surfaces"
        )
    if raw.heights.size < MIN_POINTS:
        raise FormatError(
            f"holds too few points, {raw.heights.size}: a profile needs at least {MIN_POINTS}, a map two rows and "
            "two columns"
        )
    given, other = options.spacing
    if given != other:
        raise FormatError("holds a profile, which has one spacing; two are given")
    _ask_for_all(raw, options)
    heights, unit, caveats, coded = _heights(raw, options)
    dx, steps, doubts = _profile_spacing(raw, _given_lateral(raw, options), given)
    if dx < 0:
        heights, dx = heights[::-1], -dx
        steps.append("turned round, because its positions decreased")
    return _interpreted(Profile, raw, name, options, heights, (_sane(dx),), [*coded, *steps], unit, [*caveats, *doubts])


def to_surface(raw: Raw, name: str, options: ReadOptions) -> Interpreted[Surface]:
    """Return a surface."""
    raw = _without_unit_axis(raw)
    if raw.heights.ndim != 2:
        raise FormatError(f"holds a profile of {raw.heights.size} points; read_profile() reads profiles")
    _ask_for_all(raw, options)
    heights, unit, caveats, steps = _heights(raw, options)
    if raw.size is not None and raw.spacing is None:
        (dy, dx), said = _of_size(raw.size, heights.shape, options.spacing)
        steps += said
    elif raw.spacing is not None:
        length = _unit("positions", raw.position_unit, _given_lateral(raw, options))
        dy, dx = (_agreeing(_in_um(own, length), each) for own, each in zip(raw.spacing, options.spacing, strict=True))
        _compare_declared(raw, (dy, dx))
    elif options.spacing[0] is not None and options.spacing[1] is not None:
        dy, dx = float(options.spacing[0]), float(options.spacing[1])
        own, off = _stated(raw) or (dx, 0.0)  # of one of the two, whichever
        if min(abs(own - dy), abs(own - dx)) > off:
            raise FormatError(f"says that its spacing is {own:g} µm, but {dy:g} µm and {dx:g} µm are given")
        _compare_bare(raw, (dy, dx))
    else:
        raise FormatError(_NO_MAP_SPACING)
    return _interpreted(Surface, raw, name, options, heights, (_sane(dy), _sane(dx)), steps, unit, caveats)


def _interpreted(
    kind: Any, raw: Raw, name: str, options: ReadOptions, heights: Floats, spacing: tuple[float, ...],
    steps: Sequence[str], unit: str, caveats: Sequence[Caveat],
) -> Interpreted[Any]:  # fmt: skip
    scan = Scan(
        heights, spacing, factor=LENGTH_UNITS[unit] * (raw.factor or 1.0), from_text=raw.source.lines is not None
    )
    absent = int(np.count_nonzero(np.isnan(heights)))
    found = () if absent == heights.size else caveats_of(scan)
    kept = tuple(each for each in (*raw.caveats, *caveats, *found) if each.name not in options.accept)
    accepted = sorted({each.name for each in (*raw.caveats, *caveats, *found)} & set(options.accept))
    steps = [*steps, *(f"accepted: {name}" for name in accepted)]
    try:
        heights, missing, filled = _without_gaps(heights, spacing, options)
    except FormatError as error:
        codes = [each for each in kept if each.name == "repeated-extreme"]
        raise FormatError("; ".join([str(error), *map(str, codes)])) from None
    history = (f"read from {name}", *raw.history, *steps, *filled)
    heights = read_only(heights) if heights.base is None else heights  # which the body then need not copy
    body = kind(heights, spacing=spacing[0] if kind is Profile else spacing, history=history, missing=missing)
    return Interpreted(body, unit, absent, kept)


# ---- Units and spacings ---------------------------------------------------------------------------------------------


def _units(unit: Any) -> tuple[str | None, str | None]:
    """Units of positions and of heights."""
    pair = unit if isinstance(unit, tuple) else (unit, unit)
    if len(pair) != 2 or not all(each is None or (isinstance(each, str) and length_unit(each)) for each in pair):
        raise ValueError(f"unit must be a unit of length (m, mm, um, nm, pm) or a pair of them, got {unit!r}")
    return pair


def _length(name: str, text: Any, *, zero: bool = False) -> Quantity:
    """A length, or a position, which may be `zero` or below."""
    try:
        length = quantity(text.strip() if zero and isinstance(text, str) else text, "length")
    except ValueError as error:
        raise ValueError(f"{name} {error}") from None
    if not (zero or length > 0):
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
        raise FormatError(f'does not say in which unit its {what} are; give the unit, as in "um" (--unit um)')
    return unit


def _given_lateral(raw: Raw, options: ReadOptions) -> str | None:
    """Return the unit of positions that is given; one unit for all lengths is not for those that the file has."""
    known = options.one_unit and raw.position_unit is not None and length_unit(raw.position_unit) is not None
    return None if known else options.position_unit


def _in_um(values: _Length, unit: str) -> _Length:
    factor = LENGTH_UNITS[unit]
    # A division, where it is one, so that 100 nm are 0.1 µm to the bit.
    return values / round(1 / factor) if factor < 1 else values * factor


def _heights(raw: Raw, options: ReadOptions) -> tuple[Floats, str, list[Caveat], list[str]]:
    """Return heights in µm, NaN where they are missing, their unit, doubts, and steps of the history."""
    unit, caveats, steps = _height_unit(raw, options.height_unit)
    numbers = raw.heights
    for code in (*raw.codes, *options.codes):
        at = np.abs(numbers - code) <= SAME * abs(code)
        if at.any():
            numbers = np.where(at, np.nan, numbers)
            steps.append(f"{int(at.sum())} points of {code:g} are missing points")
        elif code in options.codes:
            steps.append(f"no point is {code:g}, the code for missing points")
    with np.errstate(all="ignore"):
        if raw.factor is not None:
            numbers = numbers * raw.factor
            steps.append(f"multiplied by {raw.factor:g} {unit}, as the file says")
        heights = _in_um(numbers, unit)
        lowest, highest = np.fmin.reduce(heights, axis=None), np.fmax.reduce(heights, axis=None)
        while not (lowest >= -_HIGHEST and highest <= _HIGHEST) and not np.isnan(lowest):
            value = highest if highest > _HIGHEST else lowest
            at = heights == value
            if at.sum() < 2 or np.isinf(value):
                wild = int((np.abs(heights) > _HIGHEST).sum())
                raise FormatError(
                    f"holds a height of {value:.3g} µm, which no surface has ({wild} such values); if it marks missing "
                    f"points, --missing-value {value / LENGTH_UNITS[unit]:.6g} says so"
                )
            heights = np.where(at, np.nan, heights)
            steps.append(f"{int(at.sum())} points of {value:.3g} µm, which no surface has, are missing points")
            lowest, highest = np.fmin.reduce(heights, axis=None), np.fmax.reduce(heights, axis=None)
    return heights, unit, caveats, steps


def _height_unit(raw: Raw, given: str | None) -> tuple[str, list[Caveat], list[str]]:
    """Return the unit of heights; a file that converts its numbers by a factor of its own needs none."""
    if raw.factor is None or given is None or raw.unit is None or length_unit(raw.unit) is None:
        return _unit("heights", raw.unit, given), [], []
    own, caller = str(length_unit(raw.unit)), str(length_unit(given))
    if LENGTH_UNITS[own] == LENGTH_UNITS[caller]:
        return own, [], []
    text = f"unit says {given}, but the file converts its heights to {own} by a factor, which is applied"
    return own, [Caveat("unit-not-needed", text, "leave out --unit")], []


_NO_MAP_SPACING = (
    'holds no spacing; give it, as in "0.5 um" (--spacing "0.5 um"), or "2 um" for rows and "0.5 um" for columns'
)


def _ask_for_all(raw: Raw, options: ReadOptions) -> None:
    """Refuse a file that lacks its units and its spacing, with one message for both."""
    lacks_unit = raw.unit is None and options.height_unit is None
    lacks_spacing = options.spacing == (None, None) and all(
        each is None for each in (raw.positions, raw.spacing, raw.size, raw.stated if raw.heights.ndim == 1 else None)
    )
    if not (lacks_unit and lacks_spacing):
        return
    example = '--unit um --spacing "0.5 um"'
    bare = (
        f"; its header has a spacing of {' and '.join(f'{each:g}' for each in raw.bare_spacing)} without a unit"
        if raw.bare_spacing
        else ""
    )
    raise FormatError(
        "does not say in which unit its heights are, and holds no spacing of its points; give the unit, as in "
        f'"um", and the spacing, as in "0.5 um" ({example}){bare}'
    )


def _compare_bare(raw: Raw, given: tuple[float, ...]) -> None:
    """Refuse a spacing that is no multiple by units of that which stands in the header without a unit."""
    if raw.bare_spacing is None:
        return
    own = raw.bare_spacing if len(raw.bare_spacing) == len(given) else raw.bare_spacing * len(given)
    ratios = [each / bare for each, bare in zip(given, own[: len(given)], strict=True) if bare > 0]
    units = set(LENGTH_UNITS.values())
    if ratios and not any(all(abs(ratio / unit - 1) <= 1e-3 for ratio in ratios) for unit in units):
        raise FormatError(
            f"has a spacing of {' and '.join(f'{each:g}' for each in own)} in its header, without a unit, but spacing "
            f"says {' and '.join(f'{each:g}' for each in given)} µm"
        )


def _compare_declared(raw: Raw, spacing: tuple[float, float]) -> None:
    """Reject positions (spacings in µm) that contradict the spacings or the size in the words of a file."""
    for step, stated in zip(spacing, raw.stated_spacings or (), strict=False):
        own = stated.length * LENGTH_UNITS[stated.unit]
        if abs(own - step) > max(0.51 * stated.digit * LENGTH_UNITS[stated.unit], UNEVEN * own):
            raise FormatError(f"says that its spacing is {own:g} µm, but its positions are {step:g} µm apart")
    for step, points, stated in zip(spacing, raw.heights.shape, raw.size or (), strict=False):
        own, digit = stated.length * LENGTH_UNITS[stated.unit], stated.digit * LENGTH_UNITS[stated.unit]
        off = max(0.51 * digit, UNEVEN * own)
        if not (points - 1) * step - off <= own <= points * step + off:
            raise FormatError(f"says that its size is {own:g} µm, but its positions span {(points - 1) * step:g} µm")


def _of_size(
    size: tuple[Stated, Stated], shape: tuple[int, ...], given: tuple[Quantity | None, Quantity | None]
) -> tuple[tuple[float, float], list[str]]:
    """Spacings of an area of a size that stands in words, and what the history says of them."""
    spacings = []
    for own, points, each in zip(size, shape, given, strict=True):
        length = own.length * LENGTH_UNITS[own.unit] / points
        off = max(0.51 * own.digit * LENGTH_UNITS[own.unit] / points, UNEVEN * length)
        if each is not None and abs(each - length) > off:
            raise FormatError(f"says by its size that its spacing is {length:.7g} µm, but spacing says {each.text}")
        spacings.append(length if each is None else float(each))
    height, width = (f"{own.length:g} {own.unit}" for own in size)
    return (spacings[0], spacings[1]), [f"its size is {width} along x and {height} along y (header)"]


def _profile_spacing(raw: Raw, unit: str | None, given: Quantity | None) -> tuple[float, list[str], list[Caveat]]:
    """Return the spacing of a profile (µm, negative if its positions decrease), steps of the history, and doubts."""
    stated = _stated(raw)
    if raw.positions is None:
        if raw.spacing is not None:
            own_spacing = _in_um(raw.spacing[0], _unit("positions", raw.position_unit, unit))
            return _agreeing(own_spacing, given), [], []
        if stated is not None:
            if given is not None and abs(given - stated[0]) > stated[1]:
                raise FormatError(f"says that its spacing is {stated[0]:g} µm, but spacing says {given.text}")
            return given if given is not None else stated[0], [], []
        if given is None:
            raise FormatError('holds heights only; give the spacing of its points, as in "0.5 um" (--spacing "0.5 um")')
        _compare_bare(raw, (given,))
        return given, [], []
    length = _unit("positions", raw.position_unit, unit)
    with np.errstate(all="ignore"):
        x = _in_um(raw.positions, length)
        if not np.isfinite(x).all() or np.abs(x).max() > _HIGHEST:
            at = int(np.flatnonzero(~(np.abs(x) <= _HIGHEST))[0])
            raise FormatError(f"has no usable position at point {at}, from 0 on; each height needs one")
        digit = _Digits(raw, length)
        measured = float((x[-1] - x[0]) / (x.size - 1))
        direction = -1.0 if measured < 0 else 1.0
        if given is not None:
            if _worst_as_printed(x, direction * given, digit, UNEVEN * given) is not None:
                _refuse_uneven(x, measured, digit)  # if it is not uniform at all, that is what is wrong
                numbering = "".join(f"; {each.cure}" for each in raw.caveats if each.name == "numbering")
                raise FormatError(
                    f"says by its positions that the spacing is {abs(measured):.7g} µm, but spacing says "
                    f"{given.text}{numbering}"
                )
            return direction * given, [f"spacing {given:.7g} µm (as given; positions agree)"], []
        if stated is not None and _worst_as_printed(x, direction * stated[0], digit, 1e-9 * stated[0]) is None:
            return direction * stated[0], [f"spacing {stated[0]:.7g} µm (header and positions agree)"], []
        _refuse_uneven(x, measured, digit)
    doubts: list[Caveat] = []
    step = f"spacing {abs(measured):.7g} µm from its positions"
    if stated is not None:
        if abs(abs(measured) - stated[0]) > stated[1] + digit.values.max() / (x.size - 1):
            doubts.append(
                Caveat(
                    "spacing",
                    f"its spacing is said to be {stated[0]:g} µm, but its positions are {abs(measured):.7g} µm apart, "
                    "which is taken",
                    "check the unit of positions, --unit",
                )
            )
        step += f", where it says {stated[0]:g} µm"
    return measured, [step], doubts


def _stated(raw: Raw) -> tuple[float, float] | None:
    """The spacing that stands in words in a file and how far off it may be, µm."""
    if raw.stated is None:
        return None
    factor = LENGTH_UNITS[raw.stated.unit]
    return raw.stated.length * factor, 0.51 * raw.stated.digit * factor


class _Digits:
    """What the last printed digits of positions are worth (µm), computed when it is needed first."""

    def __init__(self, raw: Raw, unit: str) -> None:
        self._raw, self._unit = raw, unit

    @cached_property
    def values(self) -> Floats:
        assert self._raw.positions is not None
        if self._raw.digits is None:
            return np.zeros(self._raw.positions.shape)
        with np.errstate(all="ignore"):
            return _in_um(self._raw.digits(), self._unit)


def _worst_as_printed(x: Floats, spacing: float, digit: _Digits, slack: float) -> tuple[int, float] | None:
    """Return `_worst` of the printed digits, which most positions do not need to be uniform."""
    if _worst(x, spacing, np.zeros(x.size), slack) is None:
        return None
    return _worst(x, spacing, digit.values, slack)


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


def _refuse_uneven(x: Floats, measured: float, digit: _Digits) -> None:
    """Refuse positions that are not uniform, or have too few digits to tell their spacing."""
    if measured == 0:
        raise FormatError("has first and last point at the same position")
    worst = _worst_as_printed(x, measured, digit, UNEVEN * abs(measured))
    if worst is not None:
        at, off = worst
        raise FormatError(
            f"is not uniform: point {at}, from 0 on, is at {x[at]:.7g} µm, {abs(off):.3g} µm away from where a spacing "
            f"of {abs(measured):.6g} µm puts it; resample it first"
        )
    even = np.abs(np.diff(x) - measured).max() <= UNEVEN * abs(measured)
    if not even and abs(x[-1] - x[0]) < TELLING * digit.values.max():
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


def _without_gaps(
    heights: Floats, spacing: tuple[float, ...], options: ReadOptions
) -> tuple[Floats, NDArray[np.bool_] | None, list[str]]:
    """Cropped heights without outliers and bridged, where they are masked, and what was done."""
    steps: list[str] = []
    if options.crop is not None:
        if len(options.crop) != 2 * heights.ndim:
            raise FormatError(f"is cropped by {2 * heights.ndim} positions, got {len(options.crop)}")
        ends = zip(
            options.crop[::-2], options.crop[-2::-2], heights.shape, spacing, "yx"[2 - heights.ndim :], strict=True
        )
        pieces = [find_crop_range(f" along {axis}", size, step, start, stop) for stop, start, size, step, axis in ends]
        heights = heights[tuple(slice(first, end) for first, end, _ in pieces)]
        steps.append(f"cropped to {' and '.join(words for _, _, words in pieces[::-1])}")
    gaps, missing = np.isnan(heights), options.missing
    if gaps.any() and gaps.all():
        raise FormatError("has no heights: all points are missing")
    if gaps.any() and missing == "error":
        first = np.argwhere(gaps)[0].tolist()
        at = f"point {first[0]}" if gaps.ndim == 1 else f"row {first[0]}, column {first[1]}"
        raise FormatError(
            f"has {int(gaps.sum())} missing points of {gaps.size}, the first at {at}, from 0 on; "
            'missing="mask" (--missing mask) presses what is there, and missing="interpolate" (--missing interpolate) '
            "puts them on a line between their neighbours"
        )
    if options.outliers == "mask" and (outlying := find_outliers(heights)).any():
        missing = "mask" if missing == "error" else missing
        gaps, heights = gaps | outlying, np.where(outlying, np.nan, heights)
        steps.append(
            f"{int(outlying.sum())} outliers beyond {MIN_OUTLIER_DEVIATIONS:g} deviations of their neighbours taken out"
        )
    if heights.ndim == 1 and (gaps[0] or gaps[-1]):
        known = np.flatnonzero(~gaps)
        inside = slice(int(known[0]), int(known[-1]) + 1)
        steps.append(f"{heights.size - (inside.stop - inside.start)} missing points at its ends left out")
        heights, gaps = heights[inside], gaps[inside]
    if not gaps.any():
        return heights, None, steps
    full = interpolate_missing(heights, extrapolate=missing == "mask")
    if left := int(np.isnan(full).sum()):
        raise FormatError(
            f"has {left} missing points at its edges without neighbours on both sides to interpolate from; "
            'missing="mask" (--missing mask) presses what is there'
        )
    done = "masked" if missing == "mask" else "interpolated"
    steps.append(f"{int(gaps.sum())} missing points {done}, {describe_missing(gaps, spacing)}")
    return full, gaps if missing == "mask" else None, steps
