"""Conversion of heights and spacing from a scan file to µm, and detection of missing points (third reading step)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Generic, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats, check_choice, make_read_only, parse_names, unwrap_scalar
from stiction._units import Quantity, quantity, short_repr
from stiction.surfaces.measured.plausibility import FILE_CAVEAT_NAMES, ScannedHeights, find_caveats
from stiction.surfaces.measured.raw import (
    LENGTH_UNITS,
    DeclaredLength,
    FileCaveat,
    FormatError,
    RawHeights,
    parse_length_unit,
)
from stiction.surfaces.measured.shapes import MAX_STEP_UNEVENNESS, NameOrIndex
from stiction.surfaces.missing_data import (
    MIN_OUTLIER_SIGMAS,
    describe_missing_points,
    find_outliers,
    interpolate_missing_points,
)
from stiction.surfaces.preparation import find_crop_range
from stiction.surfaces.profile import MIN_POINTS, Profile
from stiction.surfaces.surface import Surface

MissingPointTreatment = Literal["error", "interpolate", "mask"]
OutlierTreatment = Literal["keep", "mask"]

MIN_PROFILE_LENGTH_IN_LAST_DIGITS = 1000
"""Minimum length of a profile with slightly uneven positions, in units of the last printed digit of the positions.

The spacing then has a relative error of at most 1/1000.
"""

_SPACING_RANGE = (1e-6, 1e6)
# Largest plausible length or height (µm). A larger number has a wrong unit or marks a missing point.
_MAX_PLAUSIBLE_LENGTH = 1e9
# Relative tolerance of codes for missing points, because single precision rounds such codes.
MISSING_CODE_TOLERANCE = 1e-6
_Length = TypeVar("_Length", float, Floats)


@dataclass(frozen=True)
class ReadOptions:
    """Options for reading a scan file, after validation."""

    position_unit: str | None
    height_unit: str | None
    spacing: tuple[Quantity | None, Quantity | None]
    missing: MissingPointTreatment
    channel: NameOrIndex | None
    columns: tuple[NameOrIndex, ...] | None
    outliers: OutlierTreatment
    crop: tuple[float, ...] | None  # µm, first and last x (and y)
    codes: tuple[float, ...] = ()  # in the unit of the file
    words: tuple[str, ...] = ()
    accept: tuple[str, ...] = ()
    # True if the caller gives a single unit: for heights, and for positions if the file declares no unit for them.
    one_unit: bool = False


def validate_read_options(
    unit: Any, spacing: Any, missing: MissingPointTreatment, channel: Any = None, columns: Any = None,
    outliers: OutlierTreatment = "keep", crop: Any = None, missing_value: Any = None, accept: Any = None,
) -> ReadOptions:  # fmt: skip
    """Validate the options for reading a scan file, and return them as `ReadOptions`."""
    codes, words = _parse_missing_markers(missing_value)
    accepted = [] if accept is None else accept.split(",") if isinstance(accept, str) else parse_names("accept", accept)
    accepted_names = tuple(name.strip() for name in accepted)
    if not set(accepted_names) <= set(FILE_CAVEAT_NAMES):
        raise ValueError(f"accept must be one or more of {', '.join(FILE_CAVEAT_NAMES)}, got {short_repr(accept)}")
    check_choice("missing", missing, MissingPointTreatment)
    check_choice("outliers", outliers, OutlierTreatment)
    crop = crop.split(",") if isinstance(crop, str) else crop
    if crop is not None and not (isinstance(crop, (list, tuple)) and len(crop) in (2, 4)):
        raise ValueError(f'crop must be "x0,x1" or "x0,x1,y0,y1", got {short_repr(crop)}')
    pair = spacing if isinstance(spacing, tuple) else (spacing, spacing)
    if len(pair) != 2:
        raise ValueError(f"spacing must be one length or a pair of lengths (Δy, Δx), got {short_repr(spacing)}")
    if columns is not None:
        columns = (columns,) if isinstance(columns, (str, int)) else columns
        if not isinstance(columns, (tuple, list)) or len(columns) not in (1, 2, 3):
            raise ValueError(
                "columns must be one column (heights), two (positions and heights), or three (x, y and z), got "
                f"{columns!r}"
            )
    for name, selection in (("channel", channel), *(("columns", column) for column in columns or ())):
        if selection is not None and (isinstance(selection, bool) or not isinstance(selection, (str, int))):
            raise ValueError(f"{name} must be a name or a number counted from 0, got {short_repr(selection)}")
    columns = None if columns is None else tuple(columns)
    dy, dx = (None if axis_spacing is None else _parse_length("spacing", axis_spacing) for axis_spacing in pair)
    crop = None if crop is None else tuple(float(_parse_length("crop", bound, allows_zero=True)) for bound in crop)
    return ReadOptions(
        *_parse_position_and_height_units(unit),
        (dy, dx),
        missing,
        channel,
        columns,
        outliers,
        crop,
        codes,
        words,
        accepted_names,
        isinstance(unit, str),
    )


def _parse_missing_markers(given: Any) -> tuple[tuple[float, ...], tuple[str, ...]]:
    """Split the user's markers of missing points into numbers and words."""
    given_markers = given.split(",") if isinstance(given, str) else () if given is None else given
    given_markers = given_markers if isinstance(given_markers, (list, tuple, set, np.ndarray)) else (given_markers,)
    codes, words = [], []
    for marker in map(unwrap_scalar, given_markers):
        if isinstance(marker, bool) or not isinstance(marker, (str, int, float)) or not str(marker).strip():
            raise ValueError(f"missing_value must be one or more numbers or words, got {short_repr(given)}")
        try:
            codes.append(float(marker))
        except (ValueError, OverflowError):
            word = str(marker).strip()
            if not word.isprintable():
                raise ValueError(f"missing_value must have printable words, got {short_repr(given)}") from None
            words.append(word)
    return tuple(codes), tuple(words)


def _flatten_single_line(raw: RawHeights) -> RawHeights:
    """Convert a matrix of heights that has only one row or one column to a profile."""
    if raw.heights.ndim == 1 or min(raw.heights.shape) > 1:
        return raw
    profile_axis = int(raw.heights.shape[1] > 1)
    return replace(
        raw, heights=raw.heights.ravel(), spacing=None if raw.spacing is None else (raw.spacing[profile_axis],)
    )


_Body = TypeVar("_Body", bound=Profile | Surface, covariant=True)


@dataclass(frozen=True)
class InterpretedScan(Generic[_Body]):
    """Profile or height map from a file, with height unit, number of missing points, and caveats about the file."""

    body: _Body
    unit: str
    missing: int
    caveats: tuple[FileCaveat, ...] = ()


def to_profile_or_surface(raw: RawHeights, name: str, options: ReadOptions) -> InterpretedScan[Profile | Surface]:
    """Convert the content of a scan file to a profile or, if there are several rows and columns, to a height map."""
    if _flatten_single_line(raw).heights.ndim == 1:
        return to_profile(raw, name, options)
    return to_surface(raw, name, options)


def to_profile(raw: RawHeights, name: str, options: ReadOptions) -> InterpretedScan[Profile]:
    """Convert the content of a scan file to a profile."""
    raw = _flatten_single_line(raw)
    if raw.heights.ndim != 1:
        raise FormatError(
            f"contains {raw.heights.shape[0]} rows of {raw.heights.shape[1]} columns, but a profile has one column of "
            "heights or two columns of positions and heights; read surfaces with read_surface()"
        )
    if raw.heights.size < MIN_POINTS:
        raise FormatError(
            f"contains too few points, {raw.heights.size}; a profile must have at least {MIN_POINTS} points, and a "
            "map two rows and two columns"
        )
    given, other_spacing = options.spacing
    if given != other_spacing:
        raise FormatError("contains a profile, but the option spacing has two lengths; give one spacing")
    _require_unit_or_spacing(raw, options)
    heights, unit, caveats, height_history = _convert_heights(raw, options)
    dx, steps, spacing_caveats = _determine_profile_spacing(raw, _choose_position_unit(raw, options), given)
    caveats += _find_spacing_as_height(raw, given)
    if dx < 0:
        heights, dx = heights[::-1], -dx
        steps.append("reversed, because its positions decreased")
    return _make_profile_or_surface(
        Profile, raw, name, options, heights, (_validate_spacing(dx),), [*height_history, *steps], unit,
        [*caveats, *spacing_caveats],
    )  # fmt: skip


def to_surface(raw: RawHeights, name: str, options: ReadOptions) -> InterpretedScan[Surface]:
    """Convert the content of a scan file to a height map."""
    raw = _flatten_single_line(raw)
    if raw.heights.ndim != 2:
        raise FormatError(f"contains a profile of {raw.heights.size} points; read profiles with read_profile()")
    _require_unit_or_spacing(raw, options)
    heights, unit, caveats, steps = _convert_heights(raw, options)
    if raw.size is not None and raw.spacing is None:
        (dy, dx), size_history = _compute_spacings_from_size(raw.size, heights.shape, options.spacing)
        steps += size_history
    elif raw.spacing is not None:
        length_unit = _resolve_unit("positions", raw.position_unit, _choose_position_unit(raw, options))
        dy, dx = (
            _validate_spacing_agreement(_to_micrometres(declared, length_unit), given)
            for declared, given in zip(raw.spacing, options.spacing, strict=True)
        )
        _reject_contradicting_grid(raw, (dy, dx))
    elif options.spacing[0] is not None and options.spacing[1] is not None:
        dy, dx = float(options.spacing[0]), float(options.spacing[1])
        # The file does not specify whether its spacing applies to rows or to columns.
        declared, tolerance = _find_declared_spacing(raw) or (dx, 0.0)
        if min(abs(declared - dy), abs(declared - dx)) > tolerance:
            raise FormatError(
                f"declares a spacing of {declared:g} µm, but the option spacing is {dy:g} µm "
                f"along y and {dx:g} µm along x"
            )
        _reject_contradicting_spacing(raw, (dy, dx))
    else:
        raise FormatError(f"{_NO_MAP_SPACING_MESSAGE}{_describe_unclear_spacing(raw)}")
    return _make_profile_or_surface(
        Surface, raw, name, options, heights, (_validate_spacing(dy), _validate_spacing(dx)), steps, unit, caveats
    )


def _make_profile_or_surface(
    kind: Any, raw: RawHeights, name: str, options: ReadOptions, heights: Floats, spacing: tuple[float, ...],
    steps: Sequence[str], unit: str, caveats: Sequence[FileCaveat],
) -> InterpretedScan[Any]:  # fmt: skip
    scan = ScannedHeights(
        heights,
        spacing,
        factor=LENGTH_UNITS[unit] * (raw.factor or 1.0),
        from_text=raw.source.lines is not None,
        declared_range=None
        if raw.height_range is None
        else raw.height_range.length * LENGTH_UNITS[raw.height_range.unit],
    )
    num_missing = int(np.count_nonzero(np.isnan(heights)))
    found_caveats = () if num_missing == heights.size else find_caveats(scan)
    remaining_caveats = tuple(
        caveat for caveat in (*raw.caveats, *caveats, *found_caveats) if caveat.name not in options.accept
    )
    accepted_names = sorted({caveat.name for caveat in (*raw.caveats, *caveats, *found_caveats)} & set(options.accept))
    steps = [*steps, *(f"accepted: {name}" for name in accepted_names)]
    try:
        heights, missing, crop_and_fill_steps = _crop_and_fill_gaps(heights, spacing, options)
    except FormatError as error:
        code_caveats = [item for item in remaining_caveats if item.name == "repeated-extreme"]
        raise FormatError("; ".join([str(error), *map(str, code_caveats)])) from None
    history = (f"read from {name}", *raw.history, *steps, *crop_and_fill_steps)
    heights = make_read_only(heights) if heights.base is None else heights
    body = kind(heights, spacing=spacing[0] if kind is Profile else spacing, history=history, missing=missing)
    return InterpretedScan(body, unit, num_missing, remaining_caveats)


# ---- Units and spacings ---------------------------------------------------------------------------------------------


def _parse_position_and_height_units(unit: Any) -> tuple[str | None, str | None]:
    """Return the user's units of positions and of heights.

    A single unit applies to positions and heights.
    """
    pair = unit if isinstance(unit, tuple) else (unit, unit)
    if len(pair) != 2 or not all(
        quantity_unit is None or (isinstance(quantity_unit, str) and parse_length_unit(quantity_unit))
        for quantity_unit in pair
    ):
        raise ValueError(f"unit must be a unit of length (m, mm, um, nm, pm) or a pair of them, got {short_repr(unit)}")
    return pair


def _parse_length(name: str, text: Any, *, allows_zero: bool = False) -> Quantity:
    """Parse a length, which must be above 0 unless `allows_zero` is set."""
    try:
        length = quantity(text.strip() if allows_zero and isinstance(text, str) else text, "length")
    except ValueError as error:
        raise ValueError(f"{name} {error}") from None
    if not (allows_zero or length > 0):
        raise ValueError(f"{name} must be above 0, got {short_repr(text)}")
    return length


def _resolve_unit(quantity_name: str, declared_unit: str | None, given_unit: str | None) -> str:
    """Return the unit of positions or heights: the unit in the file, or the caller's unit if the file has none.

    Raises `FormatError` if there is no unit, or if the units of file and caller disagree.
    """
    file_unit = None if declared_unit is None else parse_length_unit(declared_unit)
    if declared_unit is not None and file_unit is None:
        raise FormatError(
            f"has {quantity_name} in {declared_unit!r}, which is not a supported unit of length (m, mm, um, nm, ...); "
            f"convert the {quantity_name} first"
        )
    caller_unit = None if given_unit is None else parse_length_unit(given_unit)
    if file_unit is not None and caller_unit is not None and LENGTH_UNITS[file_unit] != LENGTH_UNITS[caller_unit]:
        raise FormatError(f"declares its {quantity_name} in {declared_unit}, but the option unit is {given_unit}")
    unit = file_unit if file_unit is not None else caller_unit
    if unit is None:
        raise FormatError(f'does not contain the unit of its {quantity_name}; give the unit, as in "um" (--unit um)')
    return unit


def _choose_position_unit(raw: RawHeights, options: ReadOptions) -> str | None:
    """Return the caller's unit of positions, or None if the unit in the file takes precedence.

    The file's unit takes precedence over a single unit that the caller gives for all lengths.
    """
    is_declared_in_file = raw.position_unit is not None and parse_length_unit(raw.position_unit) is not None
    return None if options.one_unit and is_declared_in_file else options.position_unit


def _to_micrometres(values: _Length, unit: str) -> _Length:
    factor = LENGTH_UNITS[unit]
    # Division by 1000 converts 100 nm to exactly 0.1 µm, unlike multiplication by 1e-3.
    return values / round(1 / factor) if factor < 1 else values * factor


def _convert_heights(raw: RawHeights, options: ReadOptions) -> tuple[Floats, str, list[FileCaveat], list[str]]:
    """Convert the heights of a scan file to µm, with NaN at missing points.

    Also returns unit, caveats and history.
    """
    unit, caveats, steps = _choose_height_unit(raw, options.height_unit)
    numbers = raw.heights
    for code in (*raw.codes, *options.codes):
        tolerance = MISSING_CODE_TOLERANCE * abs(code) if math.isfinite(code) else 0.0
        with np.errstate(all="ignore"):
            is_missing = (numbers == code) | (np.abs(numbers - code) <= tolerance)
        if is_missing.any():
            numbers = np.where(is_missing, np.nan, numbers)
            steps.append(f"{int(is_missing.sum())} points of {code:g} are missing points")
        elif code in options.codes:
            steps.append(f"no point is {code:g}, the code for missing points")
    with np.errstate(all="ignore"):
        if raw.factor is not None:
            numbers = numbers * raw.factor
            steps.append(f"multiplied by {raw.factor:g} {unit}, as declared in the file")
        heights = _to_micrometres(numbers, unit)
        min_height, max_height = np.fmin.reduce(heights, axis=None), np.fmax.reduce(heights, axis=None)
        while not (min_height >= -_MAX_PLAUSIBLE_LENGTH and max_height <= _MAX_PLAUSIBLE_LENGTH) and not np.isnan(
            min_height
        ):
            extreme_height = max_height if max_height > _MAX_PLAUSIBLE_LENGTH else min_height
            is_missing = heights == extreme_height
            if is_missing.sum() < 2 or np.isinf(extreme_height):
                num_outside = int((np.abs(heights) > _MAX_PLAUSIBLE_LENGTH).sum())
                raise FormatError(
                    f"contains an impossible height of {extreme_height:.3g} µm ({num_outside} such values); if it "
                    f"marks missing points, use --missing-value {extreme_height / LENGTH_UNITS[unit]:.6g}"
                )
            heights = np.where(is_missing, np.nan, heights)
            steps.append(
                f"{int(is_missing.sum())} points of {extreme_height:.3g} µm, an impossible height, are missing points"
            )
            min_height, max_height = np.fmin.reduce(heights, axis=None), np.fmax.reduce(heights, axis=None)
    return heights, unit, caveats, steps


def _choose_height_unit(raw: RawHeights, given: str | None) -> tuple[str, list[FileCaveat], list[str]]:
    """Return the height unit, a list of caveats about the file, and entries for the history of the scan.

    If the file declares a factor with a unit, this unit has priority.
    """
    if raw.factor is None or given is None or raw.unit is None or parse_length_unit(raw.unit) is None:
        return _resolve_unit("heights", raw.unit, given), [], []
    file_unit, caller_unit = str(parse_length_unit(raw.unit)), str(parse_length_unit(given))
    if LENGTH_UNITS[file_unit] == LENGTH_UNITS[caller_unit]:
        return file_unit, [], []
    text = f"unit is {given}, but the file converts its heights to {file_unit} by a factor, which is applied"
    return file_unit, [FileCaveat("unit-not-needed", text, "omit --unit")], []


_NO_MAP_SPACING_MESSAGE = (
    'contains no spacing; give it, as in "0.5 um" (--spacing "0.5 um"), or "2 um" for rows and "0.5 um" for columns'
)


def _require_unit_or_spacing(raw: RawHeights, options: ReadOptions) -> None:
    """Raise one `FormatError` that names unit and spacing if both are missing in the scan file and in the options."""
    lacks_unit = raw.unit is None and options.height_unit is None
    lacks_spacing = options.spacing == (None, None) and all(
        value is None
        for value in (raw.positions, raw.spacing, raw.size, raw.declared_spacing if raw.heights.ndim == 1 else None)
    )
    if not (lacks_unit and lacks_spacing):
        return
    example = '--unit um --spacing "0.5 um"'
    hint = (
        f"; its header has a spacing of {' and '.join(f'{item:g}' for item in raw.bare_spacing)} without a unit"
        if raw.bare_spacing
        else _describe_unclear_spacing(raw)
    )
    raise FormatError(
        "contains neither the unit of its heights nor the spacing of its points; give the unit, as in "
        f'"um", and the spacing, as in "0.5 um" ({example}){hint}'
    )


def _describe_unclear_spacing(raw: RawHeights) -> str:
    """Return a clause that quotes a header line with a length that may be a spacing.

    Returns "" without such a line.
    """
    if (unclear := raw.unclear_spacing) is None:
        return ""
    reason = "does not name the axes of its spacings" if len(unclear.lengths) > 1 else "may be another length"
    return f"; its header line {unclear.line[:80]!r} {reason}"


def _reject_contradicting_spacing(raw: RawHeights, given: tuple[float, ...]) -> None:
    """Raise `FormatError` if a header's spacing without a unit contradicts the user's spacing in every possible unit.

    Two spacings in a header line of uncertain meaning must equal the user's spacings in either order.
    """
    unclear = raw.unclear_spacing
    has_two_spacings = unclear is not None and len(unclear.lengths) == len(given) == 2
    if unclear and has_two_spacings and not np.allclose(sorted(unclear.lengths), sorted(given), MAX_STEP_UNEVENNESS):
        raise FormatError(
            f"declares two spacings in its header line {unclear.line[:80]!r}, which differ from the option spacing, "
            f"{' and '.join(f'{item:g}' for item in given)} µm"
        )
    if raw.bare_spacing is None:
        return
    bare_spacing = raw.bare_spacing if len(raw.bare_spacing) == len(given) else raw.bare_spacing * len(given)
    ratios = [value / bare for value, bare in zip(given, bare_spacing[: len(given)], strict=True) if bare > 0]
    units = set(LENGTH_UNITS.values())
    if ratios and not any(all(abs(ratio / unit - 1) <= 1e-3 for ratio in ratios) for unit in units):
        raise FormatError(
            f"declares a spacing of {' and '.join(f'{item:g}' for item in bare_spacing)} without a unit in its header, "
            f"but no unit of length makes this spacing equal to the option spacing, "
            f"{' and '.join(f'{item:g}' for item in given)} µm"
        )


def _reject_contradicting_grid(raw: RawHeights, spacing: tuple[float, float]) -> None:
    """Raise `FormatError` if the spacings (µm) of listed points contradict the spacings or the size in the header."""
    for step, declared in zip(spacing, raw.declared_spacings or (), strict=False):
        declared_length = declared.to_micrometres()
        if abs(declared_length - step) > max(
            0.51 * declared.digit_in_micrometres, MAX_STEP_UNEVENNESS * declared_length
        ):
            raise FormatError(f"declares a spacing of {declared_length:g} µm, but its positions are {step:g} µm apart")
    for step, points, declared in zip(spacing, raw.heights.shape, raw.size or (), strict=False):
        declared_length = declared.to_micrometres()
        tolerance = max(0.51 * declared.digit_in_micrometres, MAX_STEP_UNEVENNESS * declared_length)
        if not (points - 1) * step - tolerance <= declared_length <= points * step + tolerance:
            raise FormatError(
                f"declares a size of {declared_length:g} µm, but its positions span {(points - 1) * step:g} µm"
            )


def _compute_spacings_from_size(
    size: tuple[DeclaredLength, DeclaredLength], shape: tuple[int, ...], given: tuple[Quantity | None, Quantity | None]
) -> tuple[tuple[float, float], list[str]]:
    """Compute a map's spacings from the size that the file declares; return them with an entry for the map's history.

    A spacing given by the user is preferred, and must agree with the declared size within its rounding or 0.1 %.
    """
    spacings = []
    for declared_size, num_points, given_spacing in zip(size, shape, given, strict=True):
        spacing = declared_size.to_micrometres() / num_points
        tolerance = max(0.51 * declared_size.digit_in_micrometres / num_points, MAX_STEP_UNEVENNESS * spacing)
        if given_spacing is not None and abs(given_spacing - spacing) > tolerance:
            raise FormatError(
                f"declares a size that implies a spacing of {spacing:.7g} µm, but the option spacing is "
                f"{given_spacing.text}"
            )
        spacings.append(spacing if given_spacing is None else float(given_spacing))
    height, width = (f"{declared_size.length:g} {declared_size.unit}" for declared_size in size)
    return (spacings[0], spacings[1]), [f"its size is {width} along x and {height} along y (header)"]


def _determine_profile_spacing(
    raw: RawHeights, unit: str | None, given: Quantity | None
) -> tuple[float, list[str], list[FileCaveat]]:
    """Return a profile's spacing (µm), entries for the profile's history, and caveats about the file.

    The spacing is negative if the positions decrease.
    """
    declared = _find_declared_spacing(raw)
    if raw.positions is None:
        if raw.spacing is not None:
            own_spacing = _to_micrometres(raw.spacing[0], _resolve_unit("positions", raw.position_unit, unit))
            return _validate_spacing_agreement(own_spacing, given), [], []
        if declared is not None:
            if given is not None and abs(given - declared[0]) > declared[1]:
                raise FormatError(f"declares a spacing of {declared[0]:g} µm, but the option spacing is {given.text}")
            return given if given is not None else declared[0], [], []
        if given is None and (unclear := raw.unclear_spacing) is not None and len(unclear.lengths) == 1:
            text = f"its header line {unclear.line[:80]!r} is used as the distance between points"
            remedy = "give --spacing if it is another length, or accept it"
            return _validate_spacing(unclear.lengths[0]), [], [FileCaveat("spacing", text, remedy)]
        if given is None:
            raise FormatError(
                'contains heights only; give the spacing of its points, as in "0.5 um" (--spacing "0.5 um")'
                f"{_describe_unclear_spacing(raw)}"
            )
        _reject_contradicting_spacing(raw, (given,))
        return given, [], []
    length_unit = _resolve_unit("positions", raw.position_unit, unit)
    with np.errstate(all="ignore"):
        x = _to_micrometres(raw.positions, length_unit)
        if not np.isfinite(x).all() or np.abs(x).max() > _MAX_PLAUSIBLE_LENGTH:
            point_index = int(np.flatnonzero(~(np.abs(x) <= _MAX_PLAUSIBLE_LENGTH))[0])
            raise FormatError(
                f"has no usable position at point {point_index}, counted from 0; each height must have a position"
            )
        resolution = _PositionResolution(raw, length_unit)
        mean_spacing = float((x[-1] - x[0]) / (x.size - 1))
        direction = -1.0 if mean_spacing < 0 else 1.0
        if given is not None:
            if (
                _find_worst_unexplained_deviation(x, direction * given, resolution, MAX_STEP_UNEVENNESS * given)
                is not None
            ):
                _reject_uneven_positions(x, mean_spacing, resolution)
                numbering_hint = "".join(f"; {caveat.remedy}" for caveat in raw.caveats if caveat.name == "numbering")
                raise FormatError(
                    f"has positions with a spacing of {abs(mean_spacing):.7g} µm, but the option spacing is "
                    f"{given.text}{numbering_hint}"
                )
            return direction * given, [f"spacing {given:.7g} µm (as given; positions agree)"], []
        if (
            declared is not None
            and _find_worst_unexplained_deviation(x, direction * declared[0], resolution, 1e-9 * declared[0]) is None
        ):
            return direction * declared[0], [f"spacing {declared[0]:.7g} µm (header and positions agree)"], []
        _reject_uneven_positions(x, mean_spacing, resolution)
    caveats: list[FileCaveat] = []
    history_entry = f"spacing {abs(mean_spacing):.7g} µm from its positions"
    if declared is not None:
        if abs(abs(mean_spacing) - declared[0]) > declared[1] + resolution.values.max() / (x.size - 1):
            caveats.append(
                FileCaveat(
                    "spacing",
                    f"its declared spacing is {declared[0]:g} µm, but the spacing of its positions is "
                    f"{abs(mean_spacing):.7g} µm, which is used",
                    "check the unit of positions, --unit",
                )
            )
        history_entry += f", declared as {declared[0]:g} µm"
    return mean_spacing, [history_entry], caveats


def _find_spacing_as_height(raw: RawHeights, given: Quantity | None) -> list[FileCaveat]:
    """Return a caveat if the first or the last height equals the user's spacing, and so may not be a height."""
    if given is None or raw.positions is not None or any(caveat.name == "first-number" for caveat in raw.caveats):
        return []
    end_numbers = {"first": float(raw.heights[0])}
    # In a column of heights without a name, the last number may be the spacing.
    if raw.source.column in ("", "column 0"):
        end_numbers["last"] = float(raw.heights[-1])
    for end_name, number in end_numbers.items():
        if any(math.isclose(number * factor, given, rel_tol=1e-9) for factor in LENGTH_UNITS.values()):
            text = f"the {end_name} number, {number:g}, equals the option spacing"
            return [
                FileCaveat("first-number", text, "delete it if it is the spacing instead of a height, or accept it")
            ]
    return []


def _find_declared_spacing(raw: RawHeights) -> tuple[float, float] | None:
    """Return the spacing (µm) that the header of a profile declares, and the rounding error (µm) of this spacing."""
    if raw.declared_spacing is None:
        return None
    return raw.declared_spacing.to_micrometres(), 0.51 * raw.declared_spacing.digit_in_micrometres


class _PositionResolution:
    """Resolution of the positions printed in a file: the place value (µm) of each position's last digit."""

    def __init__(self, raw: RawHeights, unit: str) -> None:
        self._raw, self._unit = raw, unit

    @cached_property
    def values(self) -> Floats:
        assert self._raw.positions is not None
        if self._raw.digits is None:
            return np.zeros(self._raw.positions.shape)
        with np.errstate(all="ignore"):
            return _to_micrometres(self._raw.digits(), self._unit)


def _find_worst_unexplained_deviation(
    x: Floats, spacing: float, resolution: _PositionResolution, slack: float
) -> tuple[int, float] | None:
    """Return index and deviation of the position that deviates most from a uniform grid, beyond rounding of its digits.

    Returns None if rounding explains all deviations. The place values of the printed digits are computed only if the
    exact positions deviate from a uniform grid.
    """
    if _find_worst_position_deviation(x, spacing, np.zeros(x.size), slack) is None:
        return None
    return _find_worst_position_deviation(x, spacing, resolution.values, slack)


def _find_worst_position_deviation(
    x: Floats, spacing: float, last_digit_values: Floats, slack: float
) -> tuple[int, float] | None:
    """Return index and deviation of the position whose deviation from a uniform grid most exceeds its rounding error.

    Returns None if rounding explains all deviations.
    """
    steps = np.arange(x.size)
    deviations = x - x[0] - steps * spacing
    # Rounding of both end positions changes their distance by up to one unit of the last digit, truncation by less.
    tolerance = np.maximum(last_digit_values, np.linspace(last_digit_values[0], last_digit_values[-1], x.size)) * (
        1 + 1e-6
    )
    round_off = 4 * np.finfo(np.float64).eps * np.abs(x).max()
    excess_deviations = np.abs(deviations) - tolerance - slack - round_off
    point_index = int(np.argmax(excess_deviations))
    return (point_index, float(deviations[point_index])) if excess_deviations[point_index] > 0 else None


def _reject_uneven_positions(x: Floats, mean_spacing: float, resolution: _PositionResolution) -> None:
    """Raise `FormatError` if positions are not equally spaced, or if they have too few digits for their spacing."""
    if mean_spacing == 0:
        raise FormatError("has its first and last point at the same position")
    worst_point = _find_worst_unexplained_deviation(
        x, mean_spacing, resolution, MAX_STEP_UNEVENNESS * abs(mean_spacing)
    )
    if worst_point is not None:
        point_index, deviations = worst_point
        raise FormatError(
            f"is not uniform: point {point_index}, counted from 0, is at {x[point_index]:.7g} µm, which is "
            f"{abs(deviations):.3g} µm from where a uniform spacing of {abs(mean_spacing):.6g} µm would place it; "
            "resample the profile first"
        )
    is_uniform = np.abs(np.diff(x) - mean_spacing).max() <= MAX_STEP_UNEVENNESS * abs(mean_spacing)
    if not is_uniform and abs(x[-1] - x[0]) < MIN_PROFILE_LENGTH_IN_LAST_DIGITS * resolution.values.max():
        raise FormatError(
            f"has positions with too few digits to compute their spacing (about {abs(mean_spacing):.3g} µm); give the "
            'spacing, as in "0.5 um"'
        )


def _validate_spacing_agreement(file_spacing: float, given: Quantity | None) -> float:
    if given is not None and not abs(file_spacing - given) <= MAX_STEP_UNEVENNESS * abs(file_spacing):
        raise FormatError(f"has a spacing of {file_spacing:.7g} µm, but the option spacing is {given.text}")
    return file_spacing


def _validate_spacing(spacing: float) -> float:
    min_spacing, max_spacing = _SPACING_RANGE
    if not min_spacing <= spacing <= max_spacing:
        raise FormatError(
            f"has a spacing of {spacing:g} µm, but the spacing must be between {min_spacing:g} and {max_spacing:g} µm"
        )
    return spacing


# ---- Missing points -------------------------------------------------------------------------------------------------


def _crop_and_fill_gaps(
    heights: Floats, spacing: tuple[float, ...], options: ReadOptions
) -> tuple[Floats, NDArray[np.bool_] | None, list[str]]:
    """Crop heights to the user's region, and interpolate or mask missing points.

    Returns heights, a mask of missing points, and history entries.
    """
    steps: list[str] = []
    if options.crop is not None:
        if len(options.crop) != 2 * heights.ndim:
            raise FormatError(f"crop must have {2 * heights.ndim} positions for this file, got {len(options.crop)}")
        crop_limits = zip(
            options.crop[::-2], options.crop[-2::-2], heights.shape, spacing, "yx"[2 - heights.ndim :], strict=True
        )
        crop_ranges = [
            find_crop_range(f" along {axis}", size, step, start, stop) for stop, start, size, step, axis in crop_limits
        ]
        heights = heights[tuple(slice(first_index, end) for first_index, end, _ in crop_ranges)]
        steps.append(f"cropped to {' and '.join(description for _, _, description in crop_ranges[::-1])}")
    is_gap, missing = np.isnan(heights), options.missing
    if is_gap.any() and is_gap.all():
        raise FormatError("has no heights: all points are missing")
    if is_gap.any() and missing == "error":
        first_gap = np.argwhere(is_gap)[0].tolist()
        position = f"point {first_gap[0]}" if is_gap.ndim == 1 else f"row {first_gap[0]}, column {first_gap[1]}"
        raise FormatError(
            f"lacks {int(is_gap.sum())} of {is_gap.size} heights, the first at {position}, counted from 0; "
            "use only the measured points (--missing mask), or interpolate the missing points (--missing interpolate)"
        )
    if options.outliers == "mask" and (outlier_mask := find_outliers(heights)).any():
        missing = "mask" if missing == "error" else missing
        is_gap, heights = is_gap | outlier_mask, np.where(outlier_mask, np.nan, heights)
        steps.append(
            f"{int(outlier_mask.sum())} outliers beyond {MIN_OUTLIER_SIGMAS:g} deviations of their neighbours removed"
        )
    if heights.ndim == 1 and (is_gap[0] or is_gap[-1]):
        measured_indices = np.flatnonzero(~is_gap)
        measured_range = slice(int(measured_indices[0]), int(measured_indices[-1]) + 1)
        steps.append(
            f"{heights.size - (measured_range.stop - measured_range.start)} missing points at its ends removed"
        )
        heights, is_gap = heights[measured_range], is_gap[measured_range]
    if not is_gap.any():
        return heights, None, steps
    filled_heights = interpolate_missing_points(heights, extrapolate=missing == "mask")
    if num_left := int(np.isnan(filled_heights).sum()):
        raise FormatError(
            f"has {num_left} missing points at its edges, where interpolation is impossible; "
            "use only the measured points (--missing mask)"
        )
    treatment = "masked" if missing == "mask" else "interpolated"
    steps.append(f"{int(is_gap.sum())} missing points {treatment}, {describe_missing_points(is_gap, spacing)}")
    return filled_heights, is_gap if missing == "mask" else None, steps
