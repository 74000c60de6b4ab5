"""Preparation of measured heights: levelling, flipping, cropping, rotation and resampling."""

from __future__ import annotations

import math
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, check_choice, validate_number
from stiction._units import short_repr
from stiction.surfaces.form import fit_round_form
from stiction.surfaces.profile import MAX_POINTS, MIN_POINTS, Profile, select_from_mask
from stiction.surfaces.surface import AnyBody, Surface, as_body

ProfileTrend = Literal["mean", "line", "quadratic"]
SurfaceTrend = Literal["mean", "plane", "quadratic"]
ProfileForm = Literal["mean", "line", "quadratic", "cubic", "quartic", "quintic", "sextic", "circle"]
SurfaceForm = Literal["mean", "plane", "quadratic", "cubic", "quartic", "quintic", "sextic", "sphere", "cylinder"]
# Part that is kept of the longer body if two bodies have different lengths: its start or its middle.
GridAlignment = Literal["start", "middle"]
# Errors of positions up to this fraction of the grid spacing count as round-off.
GRID_POSITION_TOLERANCE = 1e-9
LEVELLING_ROUND_OFF = 1e-14
_TREND_DEGREES = {"mean": 0, "line": 1, "plane": 1, "quadratic": 2, "cubic": 3, "quartic": 4, "quintic": 5, "sextic": 6}
_DEGREE_ORDINALS = {2: "second", 3: "third", 4: "fourth", 5: "fifth", 6: "sixth"}

_LEVELLING_HISTORY_ENTRIES = {
    "mean": "levelled by the mean",
    "line": "levelled by a line",
    "quadratic": "levelled by a parabola",
    "plane": "levelled by a plane",
}

FLIPPED_HISTORY_ENTRY = "flipped"
"""Entry that `flipped` adds to the history of a body."""

_FLIP_HISTORY_ENTRIES = FLIPPED_HISTORY_ENTRY, "turned over"
"""History entries that record a flip: the current entry, and the entry of earlier versions."""

# At this distance (points) from its ends, a spline hardly depends on the end conditions.
_SPLINE_MARGIN_POINTS = 32
_ALIGNMENT_TEXTS = {"start": "first", "middle": "middle"}
_NEIGHBOUR_ROUNDING_FUNCTIONS = (np.floor, np.ceil)


@overload
def levelled(body: Profile, trend: ProfileForm) -> Profile: ...
@overload
def levelled(body: Surface, trend: SurfaceForm) -> Surface: ...
@overload
def levelled(body: ArrayLike, trend: Any, *, spacing: Any, unit: str = ...) -> Profile | Surface: ...
def levelled(body: Any, trend: Any, *, spacing: Any = None, unit: str = "um") -> Profile | Surface:
    r"""Level a body: subtract a least-squares trend or form from the heights (F-operation of ISO 25178-2).

    Parameters
    ----------
    body : Profile, Surface or array_like
        Heights. Missing points have no weight.
    trend : str
        For a profile "mean", "line", "quadratic", "cubic", "quartic", "quintic", "sextic" or "circle"; for a surface
        "plane" instead of "line", and "sphere" or "cylinder" instead of "circle". A line or a plane removes
        the tilt of the instrument. A polynomial of higher degree (total degree in x and y) also removes the form error
        of its guide or the form of the body. A circle, a sphere and a cylinder include a tilt.
    spacing : float (µm) or str, or a pair (y, x) of either
        Distance between the points of an array, such as 0.5 or "39 nm"; required for arrays.
    unit : str
        Unit of the heights of an array.

    Returns
    -------
    result : Profile or Surface
        The body minus the trend, with a mean of zero over the measured points; the step is added to its history.

    Raises
    ------
    ValueError
        If the trend has none of these names.

    See Also
    --------
    filtered : Removal of waviness.

    Notes
    -----
    The polynomials are orthogonal on the uniform grid, and are computed by their three-term recurrence. Each
    coefficient of the least-squares fit is therefore a quotient of two sums. On surfaces, the basis functions are
    products of two polynomials. Circles, spheres
    and cylinders are fitted along the height, not along their normals.

    Examples
    --------
    >>> from stiction import Profile, levelled
    >>> profile = levelled(Profile([1.0, 2.0, 3.0, 4.5, 5.5], spacing=0.5), "line")
    >>> profile.heights.round(3)
    array([ 0.1 , -0.05, -0.2 ,  0.15,  0.  ])
    >>> profile.history
    ('levelled by a line',)
    """
    scan: Profile | Surface = as_body("body", body, spacing=spacing, unit=unit)
    check_choice("trend", trend, ProfileForm if isinstance(scan, Profile) else SurfaceForm)
    if trend not in _TREND_DEGREES:
        form, description = fit_round_form(scan.heights, scan.spacings, scan.missing, trend)
        residual = scan.heights - form
        mean = residual.mean() if scan.missing is None else residual[~scan.missing].mean()
        return scan.changed(residual - mean, f"levelled by a {description}")
    degree = _TREND_DEGREES[trend]
    axis_polynomials = [_compute_orthogonal_polynomials(points, degree) for points in scan.heights.shape]
    if isinstance(scan, Profile):
        basis = axis_polynomials[0]
        description = _LEVELLING_HISTORY_ENTRIES.get(
            trend, f"levelled by a polynomial of {_DEGREE_ORDINALS.get(degree)} degree"
        )
    else:
        basis = [
            axis_polynomials[0][j][:, np.newaxis] * axis_polynomials[1][i]
            for j in range(degree + 1)
            for i in range(degree + 1 - j)
        ]
        description = (
            f"levelled by a polynomial of {_DEGREE_ORDINALS[degree]} degree"
            if degree > 1
            else _LEVELLING_HISTORY_ENTRIES[trend]
        )
    return scan.changed(_subtract_fit(scan.heights, basis, scan.missing), description)


def _compute_orthogonal_polynomials(points: int, degree: int) -> list[Floats]:
    """Return orthogonal polynomials of degrees 0 to `degree`, evaluated at the points of a uniform grid."""
    t = (np.arange(points) - (points - 1) / 2) / points
    polynomials = [np.ones(1), t]
    for _ in range(2, degree + 1):
        current, previous = polynomials[-1], np.broadcast_to(polynomials[-2], points)
        polynomials.append(t * current - (t * current * previous).sum() / np.square(previous).sum() * previous)
    return polynomials[: degree + 1]


def _subtract_fit(heights: Floats, basis: list[Floats], missing: NDArray[np.bool_] | None) -> Floats:
    """Subtract from heights the least-squares fit of basis functions, which are orthogonal on a grid without gaps.

    If only round-off remains, the result is zero.
    """
    residual = heights
    if missing is not None:
        basis_values = np.stack([np.broadcast_to(function, heights.shape)[~missing] for function in basis], axis=1)
        for factor, function in zip(np.linalg.lstsq(basis_values, heights[~missing])[0].tolist(), basis, strict=True):
            residual = residual - factor * function
        return residual
    for function in basis:
        squared_norm = np.broadcast_to(np.square(function), heights.shape).sum()
        residual = residual - (residual * function).sum() / squared_norm * function
    return residual if np.abs(residual).max() > LEVELLING_ROUND_OFF * np.abs(heights).max() else np.zeros(heights.shape)


def flipped(body: AnyBody) -> AnyBody:
    """Flip a profile or a height map upside down, so that it can face another body from above.

    Parameters
    ----------
    body : Profile or Surface
        Heights that increase out of the material.

    Returns
    -------
    upper : Profile or Surface
        The body rotated by 180° about the x axis: its heights have the opposite sign, x is unchanged, and the last row
        of a surface becomes the first. The step is added to the history.

    Examples
    --------
    >>> from stiction import Profile, flipped
    >>> flipped(Profile([0.5, 1.0, 2.0, 1.0], spacing=0.5)).heights
    array([-0.5, -1. , -2. , -1. ])
    """
    body = as_body("body", body)
    if isinstance(body, Profile):
        return body.changed(-body.heights, FLIPPED_HISTORY_ENTRY)
    return body.changed(
        -body.heights[::-1], FLIPPED_HISTORY_ENTRY, missing=select_from_mask(body.missing, slice(None, None, -1))
    )


def count_flips(body: Profile | Surface) -> int:
    """Return the number of flips in the history of a profile or a height map."""
    return sum(step in _FLIP_HISTORY_ENTRIES for step in body.history)


def list_history_without_flips(body: Profile | Surface) -> tuple[str, ...]:
    """Return the history of a profile or a height map without the entries for flips."""
    return tuple(step for step in body.history if step not in _FLIP_HISTORY_ENTRIES)


@overload
def cropped(body: Profile, start: float = ..., stop: float | None = ...) -> Profile: ...
@overload
def cropped(body: Surface, start: tuple[float, float] = ..., stop: tuple[float, float] | None = ...) -> Surface: ...
def cropped(body: Profile | Surface, start: Any = 0.0, stop: Any = None) -> Profile | Surface:
    """Crop a profile along x, or a height map along y and x.

    Parameters
    ----------
    body : Profile or Surface
        Body to crop.
    start, stop : float, µm, or (float, float) for a surface
        Positions within the extent, along y and x for a surface; by default the beginning and the end.

    Returns
    -------
    piece : Profile or Surface
        The selected points, with x (and y) starting at 0; the step is added to the history.

    Raises
    ------
    ValueError
        If the positions are not ascending within the extent, or if fewer than 4 points remain along an axis.

    Notes
    -----
    The piece contains the points with start <= x < stop, so adjacent pieces share no point.

    Examples
    --------
    >>> from stiction import Profile, cropped
    >>> cropped(Profile([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], spacing=0.5), 0.5, 2.5).heights
    array([1., 2., 3., 4.])
    """
    body = as_body("body", body)
    axes: tuple[str, ...] = ("",)
    starts, stops = [start], [stop]
    if isinstance(body, Surface):
        axes = " along y", " along x"
        starts, stops = ([value, value] if np.ndim(value) == 0 else value for value in (start, stop))
        if len(starts) != 2 or len(stops) != 2:
            raise ValueError(
                f"start and stop of a surface must be pairs (y, x), got {short_repr(start)} and {short_repr(stop)}"
            )
    ranges = [
        find_crop_range(*axis_arguments)
        for axis_arguments in zip(axes, body.heights.shape, body.spacings, starts, stops, strict=True)
    ]
    selected_slices = tuple(slice(first_point, end) for first_point, end, _ in ranges)
    history_entry = f"cropped to {' and '.join(range_text for _, _, range_text in ranges)}"
    return body.changed(
        body.heights[selected_slices], history_entry, missing=select_from_mask(body.missing, selected_slices)
    )


def find_crop_range(along: str, points: int, spacing: float, start: Any, stop: Any) -> tuple[int, int, str]:
    """Return the range of a crop along one axis: first index, index after the last point, and the range as text."""
    extent = points * spacing
    start = validate_number("start", start, unit="µm")
    stop = extent if stop is None else validate_number("stop", stop, unit="µm")
    tolerance = GRID_POSITION_TOLERANCE * spacing
    if not -tolerance <= start < stop <= extent + tolerance:
        raise ValueError(
            f"start must be below stop, and both must be within the extent of {extent:g} µm{along}, got {start:g} and "
            f"{stop:g} µm"
        )
    first_index, end_index = (
        min(max(math.ceil(position / spacing - GRID_POSITION_TOLERANCE), 0), points) for position in (start, stop)
    )
    if end_index - first_index < MIN_POINTS:
        raise ValueError(
            f"start and stop must leave at least {MIN_POINTS} points, got {end_index - first_index} points from "
            f"{start:g} to {stop:g} µm{along} at a spacing of {spacing:g} µm"
        )
    return first_index, end_index, f"{start:g} to {stop:g} µm{along}"


@overload
def on_common_grid(a: Profile, b: Profile, *, align: GridAlignment = ...) -> tuple[Profile, Profile]: ...
@overload
def on_common_grid(a: Surface, b: Surface, *, align: GridAlignment = ...) -> tuple[Surface, Surface]: ...
def on_common_grid(
    a: Any, b: Any, *, align: GridAlignment = "start"
) -> tuple[Profile, Profile] | tuple[Surface, Surface]:
    """Resample two profiles or two maps to one grid that has the finer of both spacings and the shorter length.

    Parameters
    ----------
    a, b : Profile, or both Surface
        Bodies to resample.
    align : {"start", "middle"}
        Part of the longer body to keep along each axis: the part from 0, or the middle part (to half a spacing), which
        is useful after a rotation.

    Returns
    -------
    a, b : Profile, or both Surface
        Bodies with equal spacing and number of points along each axis. Heights on the finer grid are unchanged. The
        coarser body is interpolated along one axis after the other by natural cubic splines, as in the contact models.
        The steps are added to the histories.

    Raises
    ------
    ValueError
        If one body is a profile and the other a surface, or if the common grid is too large.

    Notes
    -----
    On the finer grid no measured point is lost and nothing is aliased. Resampling a coarse scan does not add roughness
    below its spacing.

    Examples
    --------
    >>> from stiction import Profile, on_common_grid
    >>> fine, coarse = Profile([0.0, 1.0, 0.0, 1.0, 0.0], spacing=0.5), Profile([0.0, 1.0, 2.0, 3.0], spacing=1.0)
    >>> on_common_grid(fine, coarse)[1].heights
    array([0. , 0.5, 1. , 1.5, 2. ])
    """
    check_choice("align", align, GridAlignment)
    if not any(isinstance(a, kind) and isinstance(b, kind) for kind in (Profile, Surface)):
        raise ValueError(
            f"both bodies must be profiles or both must be surfaces, got {type(a).__name__} and {type(b).__name__}"
        )
    spacing = tuple(map(min, a.spacings, b.spacings))
    lengths = (
        [(points - 1) * step for points, step in zip(body.heights.shape, body.spacings, strict=True)] for body in (a, b)
    )
    shape = tuple(_count_grid_points(length, step) for length, step in zip(map(min, *lengths), spacing, strict=True))
    if len(shape) == 2 and (math.prod(shape) > MAX_POINTS or min(shape) < 2):
        raise ValueError(
            f"the common grid must have at least 2 x 2 and at most {MAX_POINTS} points, got {shape[0]} x {shape[1]}"
        )
    return _resample_to_grid(a, spacing, shape, align), _resample_to_grid(b, spacing, shape, align)


def _count_grid_points(length: float, spacing: float) -> int:
    """Return the number of points of a grid that extends from 0 to a given length (µm).

    A point within round-off of the length is included.
    """
    return math.floor(length / spacing + GRID_POSITION_TOLERANCE) + 1


def _resample_to_grid(body: Any, spacing: tuple[float, ...], shape: tuple[int, ...], align: GridAlignment) -> Any:
    """Resample a body to a grid with given spacings (µm) and shape.

    If the body has this grid, it is returned unchanged.
    """
    old_spacings = body.spacings
    if (old_spacings, body.heights.shape) == (spacing, shape):
        return body
    heights, missing = body.heights, body.missing
    for axis, (old_spacing, new_spacing, points) in enumerate(zip(old_spacings, spacing, shape, strict=True)):
        heights, missing = (
            _resample_along_axis(point_values, old_spacing, new_spacing, points, axis, align)
            for point_values in (heights, missing)
        )
    is_profile, size_text = len(shape) == 1, " rows of ".join(map(str, shape))
    spacing_text = " and ".join(f"{axis_spacing:g}" for axis_spacing in spacing)
    if old_spacings == spacing:
        history_entry = f"cropped to its {_ALIGNMENT_TEXTS[align]} {size_text} points"
    else:
        spacing_change = (
            f"from a spacing of {old_spacings[0]:g} to {spacing_text}"
            if is_profile
            else f"to spacings of {spacing_text}"
        )
        history_entry = (
            f"splined {spacing_change} µm, {size_text} points{' about its middle' if align == 'middle' else ''}"
        )
    return body.changed(heights, history_entry, spacing=spacing[0] if is_profile else spacing, missing=missing)


def resample_piece(
    surface: Surface, spacing: tuple[float, float], origin: tuple[int, int], shape: tuple[int, int]
) -> Surface:
    """Resample a piece of a height map to given spacings (µm) by natural splines.

    `origin` is the first row and column of the piece at these spacings.
    """
    heights, missing = surface.heights, surface.missing
    for axis in (0, 1):
        old_spacing, new_spacing, first, points = surface.spacing[axis], spacing[axis], origin[axis], shape[axis]
        if old_spacing == new_spacing:
            selected_slices = (slice(None),) * axis + (slice(first, first + points),)
            heights, missing = heights[selected_slices], select_from_mask(missing, selected_slices)
            continue
        from scipy.interpolate import CubicSpline

        old_points = heights.shape[axis]
        positions = np.minimum((first + np.arange(points)) * (new_spacing / old_spacing), old_points - 1)
        missing = _resample_missing_mask(missing, positions, axis)
        begin = max(0, math.floor(positions[0]) - _SPLINE_MARGIN_POINTS)
        end = min(old_points, math.ceil(positions[-1]) + 1 + _SPLINE_MARGIN_POINTS)
        cropped_heights = np.take(heights, np.arange(begin, end), axis=axis)
        heights = CubicSpline(np.arange(begin, end), cropped_heights, axis=axis, bc_type="natural")(positions)
    (rows, columns), (dy, dx) = shape, spacing
    history_entry = (
        f"cut to {rows} rows of {columns} points from {origin[0] * dy:.6g} and {origin[1] * dx:.6g} µm (y, x), "
        f"spacings {dy:g} and {dx:g} µm"
    )
    return surface.changed(np.asarray(heights), history_entry, spacing=spacing, missing=missing)


def _resample_missing_mask(missing: Any, positions: Floats, axis: int) -> Any:
    """Resample a mask of missing points along one axis.

    A new point is missing if one of its old neighbours is missing.
    """
    if missing is None:
        return None
    missing_below, missing_above = (
        np.take(missing, rounding(positions).astype(np.intp), axis=axis) for rounding in _NEIGHBOUR_ROUNDING_FUNCTIONS
    )
    return missing_below | missing_above


def _resample_along_axis(
    heights: Any, old_spacing: float, spacing: float, points: int, axis: int, align: GridAlignment = "start"
) -> Any:
    """Resample heights along one axis by natural cubic splines.

    A mask of missing points can be given instead of heights.

    If the spacing does not change, the axis is only cropped.
    """
    if heights is None:
        return None
    last_index = heights.shape[axis] - 1
    # `start` is the position of the first new point, in units of the old spacing.
    ratio = spacing / old_spacing
    start = max(0.0, (last_index - (points - 1) * ratio) / 2) if align == "middle" else 0.0
    if old_spacing == spacing:
        selected_slice = slice(int(start), int(start) + points)
        return heights[selected_slice] if axis == 0 else heights[:, selected_slice]
    from scipy.interpolate import CubicSpline

    # Round-off must not move a position beyond the last point.
    positions = np.minimum(start + np.arange(points) * ratio, last_index)
    if heights.dtype == np.bool_:
        return _resample_missing_mask(heights, positions, axis)
    return np.asarray(CubicSpline(np.arange(last_index + 1), heights, axis=axis, bc_type="natural")(positions))


def rotated(surface: Surface, angle: float) -> Surface:
    """Rotate a height map about its middle, in the plane of the map.

    Parameters
    ----------
    surface : Surface
        Surface to rotate.
    angle : float, degrees
        Angle of rotation, from +x towards +y. Multiples of 90 preserve every height; other angles require
        interpolation.

    Returns
    -------
    result : Surface
        The largest axis-parallel rectangle within the rotated surface, with the same spacings (exchanged at odd
        multiples of 90). The fraction that was cut off is added to its history.

    Raises
    ------
    ValueError
        If the surface or the result has fewer than 4 points along an axis.

    Notes
    -----
    Heights are interpolated with `scipy.interpolate.RectBivariateSpline`. Its cubic splines attenuate wavelengths near
    twice the spacing; unlike `scipy.ndimage` it does not extend the surface by reflection.

    Examples
    --------
    >>> from stiction import Surface, rotated
    >>> rotated(Surface([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]], spacing=1.0), 90).heights
    array([[3., 0.],
           [4., 1.],
           [5., 2.]])
    """
    surface = as_body("surface", surface, Surface)
    angle = validate_number("angle", angle)
    quarter_turns, remaining_angle = divmod(angle, 90.0)
    if remaining_angle == 0:
        heights = np.rot90(surface.heights, -int(quarter_turns) % 4)
        spacing = surface.spacing if quarter_turns % 2 == 0 else surface.spacing[::-1]
        missing = None if surface.missing is None else np.rot90(surface.missing, -int(quarter_turns) % 4)
        return surface.changed(heights, f"rotated by {angle:g} degrees", spacing=spacing, missing=missing)
    if min(surface.heights.shape) < MIN_POINTS:
        raise ValueError(
            f"angle must be a multiple of 90 degrees for a surface with fewer than {MIN_POINTS} rows or columns, "
            f"got {angle:g} degrees"
        )
    (dy, dx), (rows, columns) = surface.spacing, surface.heights.shape
    side_lengths = (rows - 1) * dy, (columns - 1) * dx
    radians = math.radians(angle)
    height, width = inscribed_rectangle(*side_lengths, radians)
    shape = math.floor(height / dy) + 1, math.floor(width / dx) + 1
    if min(shape) < MIN_POINTS:
        raise ValueError(
            f"angle must leave at least {MIN_POINTS} rows and points per row, got {shape[0]} rows of {shape[1]} "
            f"points at {angle:g} degrees"
        )
    y = (np.arange(shape[0]) - (shape[0] - 1) / 2)[:, np.newaxis] * dy
    x = (np.arange(shape[1]) - (shape[1] - 1) / 2) * dx
    heights, missing = interpolate_rotated(surface, y, x, radians)
    lost_fraction = 1 - shape[0] * shape[1] / surface.heights.size
    history_entry = f"rotated by {angle:g} degrees, {100 * lost_fraction:.0f} % cut off"
    return surface.changed(heights, history_entry, missing=missing)


def interpolate_rotated(surface: Surface, y: Any, x: Any, angle: float) -> tuple[Floats, Any]:
    """Return the heights of a map that is rotated about its middle by an angle (radians), at the given points.

    The given points are at distances y (a column) and x (µm) from the middle. Returns heights and a mask of
    missing points, which is None if the map has no missing points.
    """
    from scipy.interpolate import RectBivariateSpline

    (dy, dx), (rows, columns) = surface.spacing, surface.heights.shape
    source_row = ((rows - 1) * dy / 2 - x * math.sin(angle) + y * math.cos(angle)) / dy
    source_column = ((columns - 1) * dx / 2 + x * math.cos(angle) + y * math.sin(angle)) / dx
    spline = RectBivariateSpline(np.arange(rows), np.arange(columns), surface.heights)
    source_row, source_column = np.clip(source_row, 0, rows - 1), np.clip(source_column, 0, columns - 1)
    heights, missing = spline.ev(source_row, source_column), None
    if surface.missing is not None:
        corner_indices = [
            (round_y(source_row).astype(np.intp), round_x(source_column).astype(np.intp))
            for round_y in _NEIGHBOUR_ROUNDING_FUNCTIONS
            for round_x in _NEIGHBOUR_ROUNDING_FUNCTIONS
        ]
        missing = np.logical_or.reduce([surface.missing[corner_index] for corner_index in corner_indices])
    return heights, missing


def inscribed_rectangle(height: float, width: float, angle: float) -> tuple[float, float]:
    """Return height and width of the largest rectangle, with sides along x and y, inside a rotated rectangle."""
    sine, cosine = abs(math.sin(angle)), abs(math.cos(angle))
    longer_side, shorter_side = max(height, width), min(height, width)
    # For a narrow rectangle, two corners of the inscribed rectangle lie on the longer sides of the rotated rectangle.
    if shorter_side <= 2 * sine * cosine * longer_side:
        half_shorter = shorter_side / 2
        width_across, length_along = half_shorter / cosine, half_shorter / sine
        return (length_along, width_across) if height >= width else (width_across, length_along)
    cosine_of_double_angle = cosine**2 - sine**2
    return (height * cosine - width * sine) / cosine_of_double_angle, (
        width * cosine - height * sine
    ) / cosine_of_double_angle


def resampled(profile: Profile, spacing: float) -> Profile:
    """Resample a profile to another spacing (µm) by interpolation with a natural cubic spline.

    The profile is unchanged if the spacing is equal.
    """
    points = _count_grid_points((len(profile) - 1) * profile.spacing, spacing)
    if points > MAX_POINTS:
        raise ValueError(
            f"spacing must give at most {MAX_POINTS} points over {profile.extent:g} µm, got {points} points at "
            f"{spacing:g} µm"
        )
    resampled: Profile = _resample_to_grid(profile, (spacing,), (points,), "start")
    return resampled
