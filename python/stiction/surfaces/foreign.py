"""Profiles and surfaces that other libraries hold, taken as they are: heights, spacing and unit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._shown import with_unit
from stiction.surfaces.measured.raw import LENGTH_UNITS
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

EQUAL_STEPS = 1e-6
"""Of a step: coordinates whose steps differ by more are not on a uniform grid."""


def body_from(name: str, other: Any, *, unit: str | None = None) -> Profile | Surface:
    """A profile or a surface from an object of SurfaceTopography, surfalize or xarray.

    Parameters
    ----------
    name : str
        Of the argument, for errors.
    other : object
        A SurfaceTopography topography or line scan, a surfalize Surface, or an xarray DataArray with units.
    unit : str, optional
        Of all lengths, where the object says none.

    Raises
    ------
    ValueError
        If it is none of these, has no unit, or points are missing.
    """
    if isinstance(other, (Profile, Surface)):
        return other
    kind = f"{type(other).__module__.split('.')[0]} {type(other).__name__}"
    if hasattr(other, "dims") and hasattr(other, "coords") and hasattr(other, "attrs"):
        return _of_data_array(name, other, kind, unit)
    if hasattr(other, "heights") and hasattr(other, "physical_sizes"):
        return _of_topography(name, other, kind, unit)
    if hasattr(other, "data") and hasattr(other, "step_x") and hasattr(other, "step_y"):
        heights = np.asarray(other.data, dtype=np.float64)
        return _body(name, heights, (float(other.step_y), float(other.step_x)), 1.0, kind)
    raise ValueError(
        f"{name} must be a Profile or a Surface, or one of SurfaceTopography, surfalize or xarray, got "
        f"{type(other).__name__}"
    )


def data_array_of(body: Profile | Surface) -> xarray.DataArray:
    """Heights over y and x, or x, with units and history; `body_from` gives the same body back."""
    import xarray

    dims = ("y", "x") if isinstance(body, Surface) else ("x",)
    along = {"units": "um", "long_name": "position"}
    coordinates: dict[str, Any] = {name: ((name,), getattr(body, name), along) for name in dims}
    attributes = {"units": "um", "long_name": "height", "history": "\n".join(body.history)}
    return xarray.DataArray(body.heights, coordinates, dims, "height", attributes)


def words_of(body: Profile | Surface) -> str:
    """A body in a line: its size, its spacing, its roughness and where it is from."""
    size = " × ".join(map(str, body.heights.shape))
    steps = np.unique(body.spacing).tolist()
    apart = with_unit(steps[0], "µm")
    if isinstance(body, Surface) and len(steps) > 1:
        apart = f"{with_unit(body.spacing[1], 'µm')} apart along x and {with_unit(body.spacing[0], 'µm')} along y"
    else:
        apart += " apart"
    rough = "Sq" if isinstance(body, Surface) else "Pq"
    made = f"; {', '.join(body.history)}" if body.history else ""
    return (
        f"{type(body).__name__} of {size} points, {apart}, {rough} {with_unit(float(body.heights.std()), 'µm')}{made}"
    )


def _of_topography(name: str, other: Any, kind: str, unit: str | None) -> Profile | Surface:
    """Of SurfaceTopography, whose first axis is x."""
    factor = _factor(name, other.unit or unit, kind)
    given = np.ma.asarray(other.heights())
    if np.ma.is_masked(given):
        raise ValueError(f"{name} has points without a height; fill them first, as by interpolate_undefined_data()")
    heights = np.asarray(np.ma.getdata(given), dtype=np.float64)
    if heights.ndim == 2:
        x, y = (float(size) / points for size, points in zip(other.physical_sizes, heights.shape, strict=True))
        return _body(name, heights.T, (y, x), factor, kind)
    if not other.is_uniform:
        return _body(name, heights, (_step(name, "x", other.positions()),), factor, kind)
    return _body(name, heights, (float(other.physical_sizes[0]) / heights.size,), factor, kind)


def _of_data_array(name: str, other: Any, kind: str, unit: str | None) -> Profile | Surface:
    """Of xarray: heights over y and x, or over x, each with its unit in ``attrs["units"]``."""
    wanted = {1: ("x",), 2: ("y", "x")}.get(other.ndim)
    if wanted is None or set(other.dims) != set(wanted):
        raise ValueError(f"{name} must have the dimensions y and x, or x alone, got {', '.join(map(str, other.dims))}")
    other = other.transpose(*wanted)
    spacing = []
    for axis in wanted:
        if axis not in other.coords:
            raise ValueError(f"{name} must have a coordinate {axis}, in µm or with its unit in attrs")
        along = other.coords[axis]
        factor = _factor(f"{name}.{axis}", along.attrs.get("units", unit), kind)
        spacing.append(_step(name, axis, np.asarray(along.values, dtype=np.float64)) * factor)
    factor = _factor(name, other.attrs.get("units", unit), kind)
    body = _body(name, np.asarray(other.values, dtype=np.float64) * factor, tuple(spacing), 1.0, kind)
    history = other.attrs.get("history")
    if history is None:
        return body
    made = tuple(each for each in str(history).split("\n") if each)
    return type(body)(body.heights, spacing=body.spacing, history=made)  # type: ignore[arg-type]


def _step(name: str, axis: str, positions: Any) -> float:
    """Distance of neighbouring points that are equally far from each other."""
    at = np.asarray(positions, dtype=np.float64)
    steps = np.diff(at)
    if not steps.size or not (steps > 0).all() or np.ptp(steps) > EQUAL_STEPS * steps.mean():
        raise ValueError(f"{name} must have equal steps along {axis}, in rising order")
    first = float(steps[0])
    is_exact = np.array_equal(at, at[0] + np.arange(at.size) * first)
    return first if is_exact else float((at[-1] - at[0]) / steps.size)


def _factor(name: str, unit: Any, kind: str) -> float:
    if unit not in LENGTH_UNITS:
        allowed = ", ".join(each for each in LENGTH_UNITS if len(each) < 3 and each.isascii())
        raise ValueError(f"{name} must have a unit of length ({allowed}), or be given one, got {unit!r} of a {kind}")
    return float(LENGTH_UNITS[unit])


def _body(name: str, heights: Any, spacing: tuple[float, ...], factor: float, kind: str) -> Profile | Surface:
    if np.isnan(heights).any():
        raise ValueError(f"{name} has {int(np.isnan(heights).sum())} points without a height; fill them first")
    history = (f"taken from a {kind}",)
    if heights.ndim == 1:
        return Profile(heights * factor, spacing=spacing[0] * factor, history=history)
    both = (spacing[0] * factor, spacing[1] * factor)
    return Surface(np.ascontiguousarray(heights) * factor, spacing=both, history=history)
