"""Conversion between profiles or height maps of this package and objects of other libraries."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from stiction._repr import format_with_unit
from stiction._units import short_repr
from stiction.surfaces.measured.raw import LENGTH_UNITS

if TYPE_CHECKING:
    import xarray

    from stiction._checks import Floats

# A grid counts as uniform if its largest and smallest step differ by at most this fraction of the mean step.
SPACING_TOLERANCE = 1e-6


class ExtractedHeights(NamedTuple):
    """Heights, spacing, history and missing points, extracted from a profile, a map, or another library's object."""

    heights: Floats  # µm, (n,) or (rows, columns)
    spacing: tuple[float, ...]  # (Δx,) or (Δy, Δx), µm
    history: tuple[str, ...]
    missing: Any = None


def extract_heights(name: str, other: Any, *, unit: str | None = None) -> ExtractedHeights:
    """Extract heights (µm) and spacing from an object of this package, SurfaceTopography, surfalize or xarray.

    `unit` applies to all lengths if the object has no unit. Messages refer to the object by the argument name `name`.
    """
    if hasattr(other, "heights") and hasattr(other, "history"):
        spacing = tuple(np.atleast_1d(other.spacing).tolist())
        return ExtractedHeights(other.heights, spacing, other.history, getattr(other, "missing", None))
    type_name = f"{type(other).__module__.split('.')[0]} {type(other).__name__}"
    if hasattr(other, "dims") and hasattr(other, "coords") and hasattr(other, "attrs"):
        return _extract_from_data_array(name, other, type_name, unit)
    if hasattr(other, "heights") and hasattr(other, "physical_sizes"):
        return _extract_from_topography(name, other, type_name, unit)
    if hasattr(other, "data") and hasattr(other, "step_x") and hasattr(other, "step_y"):
        heights = np.asarray(other.data, dtype=np.float64)
        return _make_extracted_heights(name, heights, (float(other.step_y), float(other.step_x)), 1.0, type_name)
    raise ValueError(
        f"{name} must be a Profile or a Surface, or an object from SurfaceTopography, surfalize or xarray, got "
        f"{type(other).__name__}"
    )


def to_data_array(heights: Floats, history: tuple[str, ...], **positions: Floats) -> xarray.DataArray:
    """Convert heights and positions (µm) to an xarray.DataArray with units.

    `extract_heights` is the inverse.
    """
    import xarray

    coordinate_attributes = {"units": "um", "long_name": "position"}
    coordinates: dict[str, Any] = {name: ((name,), values, coordinate_attributes) for name, values in positions.items()}
    attributes = {"units": "um", "long_name": "height", "history": "\n".join(history)}
    return xarray.DataArray(heights, coordinates, tuple(positions), "height", attributes)


def describe_body(kind: str, heights: Floats, spacing: tuple[float, ...], history: tuple[str, ...]) -> str:
    """Describe a profile or a height map in one line: size, spacing, roughness and history."""
    shape_text = " × ".join(map(str, heights.shape))
    distinct_spacings = np.unique(spacing).tolist()
    spacing_text = f"{format_with_unit(distinct_spacings[0], 'µm')} apart"
    if len(distinct_spacings) > 1:
        spacing_text = (
            f"{format_with_unit(spacing[1], 'µm')} apart along x and {format_with_unit(spacing[0], 'µm')} along y"
        )
    roughness_text = f"{'Pq' if heights.ndim == 1 else 'Sq'} {format_with_unit(float(heights.std()), 'µm')}"
    if history and not any(history_entry.startswith("levelled") for history_entry in history):
        roughness_text += ", not levelled"
    history_text = f"; {', '.join(history)}" if history else ""
    return f"{kind} of {shape_text} points, {spacing_text}, {roughness_text}{history_text}"


def _extract_from_topography(name: str, other: Any, type_name: str, unit: str | None) -> ExtractedHeights:
    """Extract heights (µm) and spacing from an object of the package SurfaceTopography.

    Arrays of this package have x as the first axis.
    """
    unit_factor = _parse_unit_factor(name, other.unit or unit, type_name)
    masked_heights = np.ma.asarray(other.heights())
    if np.ma.is_masked(masked_heights):
        raise ValueError(
            f"{name} must have a height at every point; fill missing points first, for example with "
            "interpolate_undefined_data()"
        )
    heights = np.asarray(np.ma.getdata(masked_heights), dtype=np.float64)
    if heights.ndim == 1 and not other.is_uniform:
        return _make_extracted_heights(
            name, heights, (_find_uniform_spacing(name, "x", other.positions()),), unit_factor, type_name
        )
    spacings = [float(size) / points for size, points in zip(other.physical_sizes, heights.shape, strict=True)]
    return _make_extracted_heights(name, heights.T, tuple(spacings[::-1]), unit_factor, type_name)


def _extract_from_data_array(name: str, other: Any, type_name: str, unit: str | None) -> ExtractedHeights:
    """Extract heights (µm) and spacing from a DataArray with the dimension x, or the dimensions y and x.

    The attribute "units" of heights and coordinates gives their units. `unit` replaces a missing attribute.
    """
    axes = {1: ("x",), 2: ("y", "x")}.get(other.ndim)
    if axes is None or set(other.dims) != set(axes):
        raise ValueError(f"{name} must have the dimensions y and x, or x alone, got {', '.join(map(str, other.dims))}")
    other = other.transpose(*axes)
    spacing = []
    for axis in axes:
        if axis not in other.coords:
            raise ValueError(f"{name} must have a coordinate {axis}, in µm or with its unit in attrs")
        coordinate = other.coords[axis]
        unit_factor = _parse_unit_factor(name, coordinate.attrs.get("units", unit), type_name, axis=axis)
        spacing.append(_find_uniform_spacing(name, axis, np.asarray(coordinate.values, dtype=np.float64)) * unit_factor)
    unit_factor = _parse_unit_factor(name, other.attrs.get("units", unit), type_name)
    extracted_heights = _make_extracted_heights(
        name, np.asarray(other.values, dtype=np.float64) * unit_factor, tuple(spacing), 1.0, type_name
    )
    if other.attrs.get("history") is None:
        return extracted_heights
    return extracted_heights._replace(history=tuple(filter(None, str(other.attrs["history"]).split("\n"))))


def _find_uniform_spacing(name: str, axis: str, positions: Any) -> float:
    """Return the spacing of positions, or raise a `ValueError` if the positions do not increase in equal steps."""
    coordinates = np.asarray(positions, dtype=np.float64)
    steps = np.diff(coordinates)
    if not steps.size or not (steps > 0).all() or np.ptp(steps) > SPACING_TOLERANCE * steps.mean():
        raise ValueError(f"{name} must have increasing positions with equal steps along {axis}")
    first_step = float(steps[0])
    is_exact = np.array_equal(coordinates, coordinates[0] + np.arange(coordinates.size) * first_step)
    return first_step if is_exact else float((coordinates[-1] - coordinates[0]) / steps.size)


def _parse_unit_factor(name: str, unit: Any, type_name: str, *, axis: str | None = None) -> float:
    if unit not in LENGTH_UNITS:
        allowed_units = ", ".join(
            unit_symbol for unit_symbol in LENGTH_UNITS if len(unit_symbol) < 3 and unit_symbol.isascii()
        )
        raise ValueError(
            f"{name} must have a unit of length{'' if axis is None else f' along {axis}'} ({allowed_units}), "
            f"set in the {type_name} or with unit=, got {short_repr(unit)}"
        )
    return float(LENGTH_UNITS[unit])


def _make_extracted_heights(
    name: str, heights: Any, spacing: tuple[float, ...], unit_factor: float, type_name: str
) -> ExtractedHeights:
    if np.isnan(heights).any():
        raise ValueError(
            f"{name} must have a height at every point, got {int(np.isnan(heights).sum())} points without a height; "
            "fill these points first"
        )
    return ExtractedHeights(
        np.ascontiguousarray(heights) * unit_factor,
        tuple(step * unit_factor for step in spacing),
        (f"taken from a {type_name}",),
    )
