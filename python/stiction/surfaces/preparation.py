"""What is done to measured heights before they touch: levelling, cropping, a common grid."""

from __future__ import annotations

import math
from typing import Any, Literal, overload

import numpy as np

from stiction._checks import Floats, choice, number
from stiction.surfaces.profile import FEWEST_POINTS, MOST_POINTS, Profile
from stiction.surfaces.surface import Surface

ProfileTrend = Literal["mean", "line", "quadratic"]
SurfaceTrend = Literal["mean", "plane"]

ON_POINT = 1e-9
"""Spacings within which a position is taken as that of a point: 0.3 is the third point of a spacing of 0.1."""

ROUND_OFF = 1e-14
"""Of the largest height, what is left of a straight line after it has been taken off."""


@overload
def levelled(body: Profile, trend: ProfileTrend) -> Profile: ...
@overload
def levelled(body: Surface, trend: SurfaceTrend) -> Surface: ...
def levelled(body: Profile | Surface, trend: Any) -> Profile | Surface:
    r"""Heights about their least-squares trend.

    Parameters
    ----------
    body : Profile or Surface
    trend : {"mean", "line", "quadratic"} for a profile, {"mean", "plane"} for a surface
        What is subtracted: the mean height; a straight line or a plane, which is the tilt of the instrument; a
        parabola, which is also the bow of its guide or the form of the body. A line or plane contains the mean, a
        parabola the line.

    Returns
    -------
    Profile or Surface
        Of the same spacing, with a mean of zero; the step is added to its history.

    Raises
    ------
    ValueError
        If the body or the trend is none of these.

    Notes
    -----
    On a uniform grid the polynomials :math:`1, t, t^2 - \overline{t^2}` with t measured from the middle are orthogonal,
    so each coefficient of the least-squares fit is a quotient of two sums.

    Examples
    --------
    >>> from stiction import Profile, levelled
    >>> profile = levelled(Profile([1.0, 2.0, 3.0, 4.5, 5.5], spacing=0.5), "line")
    >>> profile.heights.round(3)
    array([ 0.1 , -0.05, -0.2 ,  0.15,  0.  ])
    >>> profile.history
    ('levelled by a line',)
    """
    if isinstance(body, Profile):
        choice("trend", trend, ProfileTrend)
        degree = {"mean": 0, "line": 1, "quadratic": 2}[trend]
        heights = _without(body.heights, _orthogonal(body.heights.size, degree))
        return Profile(heights, spacing=body.spacing, history=(*body.history, _LEVELLED[trend]))
    if isinstance(body, Surface):
        choice("trend", trend, SurfaceTrend)
        rows, columns = body.heights.shape
        degree = {"mean": 0, "plane": 1}[trend]
        basis = [
            np.ones((1, 1)),
            *(along_x[np.newaxis, :] for along_x in _orthogonal(columns, degree)[1:]),
            *(along_y[:, np.newaxis] for along_y in _orthogonal(rows, degree)[1:]),
        ]
        return Surface(_without(body.heights, basis), spacing=body.spacing, history=(*body.history, _LEVELLED[trend]))
    raise ValueError(f"body must be a Profile or a Surface, got {type(body).__name__}")


_LEVELLED = {
    "mean": "levelled by the mean",
    "line": "levelled by a line",
    "quadratic": "levelled by a parabola",
    "plane": "levelled by a plane",
}


def _orthogonal(points: int, degree: int) -> list[Floats]:
    """Polynomials of degree 0 to `degree` that are orthogonal on a uniform grid, of size about one."""
    t = (np.arange(points) - (points - 1) / 2) / points
    square = np.square(t)
    return [np.ones(1), t, square - square.mean()][: degree + 1]


def _without(heights: Floats, basis: list[Floats]) -> Floats:
    """Heights less their projections on orthogonal functions, one after the other, which keeps the digits.

    Zero where only round-off is left, which would pass for roughness.
    """
    rest = heights
    for function in basis:
        norm = np.broadcast_to(np.square(function), heights.shape).sum()
        rest = rest - (rest * function).sum() / norm * function
    return rest if np.abs(rest).max() > ROUND_OFF * np.abs(heights).max() else np.zeros(heights.shape)


def turned_over(profile: Profile) -> Profile:
    """A profile as that of the upper body: heights out of the material are then heights down.

    The body is turned about the x axis, so that x stays.

    Examples
    --------
    >>> from stiction import Profile, turned_over
    >>> turned_over(Profile([0.5, 1.0, 2.0, 1.0], spacing=0.5)).heights
    array([-0.5, -1. , -2. , -1. ])
    """
    return Profile(-profile.heights, spacing=profile.spacing, history=(*profile.history, "turned over"))


def cropped(profile: Profile, start: float = 0.0, stop: float | None = None) -> Profile:
    """The points with start <= x < stop, so that neighbouring pieces share no point.

    Parameters
    ----------
    profile : Profile
    start, stop : float, µm
        Within the extent; without `stop`, to the end.

    Returns
    -------
    Profile
        Whose x starts at zero again; the step is added to its history.

    Raises
    ------
    ValueError
        If the positions are not in this order within the extent, or fewer than 4 points are left.

    Examples
    --------
    >>> from stiction import Profile, cropped
    >>> cropped(Profile([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], spacing=0.5), 0.5, 2.5).heights
    array([1., 2., 3., 4.])
    """
    start = number("start", start, unit="µm")
    stop = profile.extent if stop is None else number("stop", stop, unit="µm")
    slack = ON_POINT * profile.spacing
    if not -slack <= start < stop <= profile.extent + slack:
        raise ValueError(
            f"start and stop must be in this order and within the extent of {profile.extent:g} µm, "
            f"got {start:g} and {stop:g} µm"
        )
    first, end = (max(math.ceil(place / profile.spacing - ON_POINT), 0) for place in (start, stop))
    heights = profile.heights[first:end]
    if heights.size < FEWEST_POINTS:
        raise ValueError(
            f"at least {FEWEST_POINTS} points must be left, but from {start:g} to {stop:g} µm there are {heights.size} "
            f"at a spacing of {profile.spacing:g} µm"
        )
    return Profile(heights, spacing=profile.spacing, history=(*profile.history, f"cropped to {start:g} to {stop:g} µm"))


def on_common_grid(a: Profile, b: Profile) -> tuple[Profile, Profile]:
    """Two profiles on the finer of their grids, over the length that both have from x = 0 on.

    Parameters
    ----------
    a, b : Profile

    Returns
    -------
    (Profile, Profile)
        Of the same spacing and number of points. The profile with the finer grid keeps its heights to the bit; the
        other is interpolated by its natural cubic spline, the curve that contact mechanics sees in it anyway. The steps
        are added to their histories.

    Notes
    -----
    The finer grid, because no measured point is lost and nothing is folded back from above a Nyquist frequency. What
    was measured coarsely has no roughness below its own spacing on the finer grid either.

    Examples
    --------
    >>> from stiction import Profile, on_common_grid
    >>> fine, coarse = Profile([0.0, 1.0, 0.0, 1.0, 0.0], spacing=0.5), Profile([0.0, 1.0, 2.0, 3.0], spacing=1.0)
    >>> on_common_grid(fine, coarse)[1].heights
    array([0. , 0.5, 1. , 1.5, 2. ])
    """
    spacing = min(a.spacing, b.spacing)
    last = min((len(each) - 1) * each.spacing for each in (a, b))
    points = math.floor(last / spacing + ON_POINT) + 1
    return _on_grid(a, spacing, points), _on_grid(b, spacing, points)


def resampled(profile: Profile, spacing: float) -> Profile:
    """A profile at another spacing (µm), over its own length, by its natural cubic spline; its own grid as it is."""
    points = math.floor((len(profile) - 1) * profile.spacing / spacing + ON_POINT) + 1
    if points > MOST_POINTS:
        raise ValueError(
            f"{profile.extent:g} µm at a spacing of {spacing:g} µm are {points} points, and at most {MOST_POINTS} "
            "can be used"
        )
    return _on_grid(profile, spacing, points)


def _on_grid(profile: Profile, spacing: float, points: int) -> Profile:
    if profile.spacing == spacing:
        if points == len(profile):
            return profile
        step = f"cropped to its first {points} points"
        return Profile(profile.heights[:points], spacing=spacing, history=(*profile.history, step))
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(np.arange(len(profile)), profile.heights, bc_type="natural")
    # In steps of its own grid; a position a rounding beyond the last point is the last point.
    places = np.minimum(np.arange(points) * (spacing / profile.spacing), len(profile) - 1)
    step = f"splined from a spacing of {profile.spacing:g} to {spacing:g} µm, {points} points"
    return Profile(spline(places), spacing=spacing, history=(*profile.history, step))
