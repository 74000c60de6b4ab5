"""Least-squares fits of circles, spheres and cylinders to the heights of round bodies."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._repr import format_with_unit

RoundForm = Literal["circle", "sphere", "cylinder"]
# Coordinates (x, y) in µm of the points of a map, relative to the middle of the map.
PointCoordinates = tuple[Floats, Floats]
_FormModel = Callable[[Floats, PointCoordinates], Floats]
# Lower bound of the computed cos² of the slope angle: the formula is negative beyond the equator of a sphere.
_MIN_COSINE_SQUARED = 1e-6
_FIT_TOLERANCE = 1e-12


def fit_round_form(
    heights: Floats, spacing: tuple[float, ...], missing: NDArray[np.bool_] | None, form: RoundForm
) -> tuple[Floats, str]:
    r"""Fit a circle, a sphere or a cylinder to heights by least squares in the height direction.

    Returns
    -------
    (ndarray, str)
        The heights of the fitted form, and a description of the form with its radius.

    Notes
    -----
    A sphere of curvature κ and slope s at the middle has the height

    .. math:: h = \frac{κu^2 + 2 s·u/g}{1/g + \sqrt{1/g^2 - κ(κu^2 + 2 s·u/g)}}, \qquad g = \sqrt{1 + s^2}

    at the position u from the middle; for κ = 0 it is a plane. A cylinder has this arc across its axis and a straight
    line along it.
    """
    from scipy.optimize import least_squares

    axis_coordinates = [
        step * (np.arange(points) - (points - 1) / 2) for points, step in zip(heights.shape, spacing, strict=True)
    ]
    x, y = axis_coordinates[-1], (axis_coordinates[0][:, np.newaxis] if len(axis_coordinates) == 2 else np.zeros(1))
    positions = np.broadcast_to(x, heights.shape), np.broadcast_to(y, heights.shape)
    measured_mask = np.ones(heights.shape, bool) if missing is None else ~missing
    measured_positions = positions[0][measured_mask], positions[1][measured_mask]
    measured_heights = heights[measured_mask]
    model, initial_parameters = (
        _FORM_MODELS[form],
        _estimate_form_parameters(form, measured_positions, measured_heights),
    )
    parameter_scales = np.maximum(
        np.abs(initial_parameters), _estimate_parameter_scales(form, measured_positions, measured_heights)
    )
    fitted_parameters = least_squares(
        lambda scaled_parameters: model(scaled_parameters * parameter_scales, measured_positions) - measured_heights,
        initial_parameters / parameter_scales, xtol=_FIT_TOLERANCE, ftol=_FIT_TOLERANCE
    ).x * parameter_scales  # fmt: skip
    curvature = float(fitted_parameters[1])
    radius = "an infinite radius" if curvature == 0 else f"radius {format_with_unit(1 / abs(curvature), 'µm')}"
    return model(fitted_parameters, positions), f"{'concave' if curvature > 0 else 'convex'} {form} of {radius}"


def _compute_arc_heights(squared_distance: Floats, tangent_height: Floats, curvature: float, cosine: float) -> Floats:
    """Return the heights of points on a tilted circular arc, measured from the height of the arc's middle.

    Each point is specified by its squared distance from the middle, and by the height of the tangent of the middle at
    this point, which has the sign of the tilt. `cosine` is the cosine of the angle of tilt.
    """
    rise = curvature * squared_distance + 2 * tangent_height * cosine
    root = np.sqrt(np.maximum(cosine**2 - curvature * rise, _MIN_COSINE_SQUARED))
    return np.asarray(rise / (cosine + root))


def _compute_sphere_heights(parameters: Floats, points: PointCoordinates) -> Floats:
    height, curvature, slope_x, slope_y = parameters
    x, y = points
    cosine = 1 / math.sqrt(1 + slope_x**2 + slope_y**2)
    return np.asarray(height + _compute_arc_heights(x**2 + y**2, slope_x * x + slope_y * y, curvature, cosine))


def _compute_circle_heights(parameters: Floats, points: PointCoordinates) -> Floats:
    return _compute_sphere_heights(np.append(parameters, 0.0), (points[0], np.zeros_like(points[0])))


def _compute_cylinder_heights(parameters: Floats, points: PointCoordinates) -> Floats:
    height, curvature, slope, slope_along_axis, angle = parameters
    x, y = points
    distance_across = y * math.cos(angle) - x * math.sin(angle)
    along_axis = x * math.cos(angle) + y * math.sin(angle)
    arc_heights = _compute_arc_heights(
        distance_across**2, slope * distance_across, curvature, 1 / math.sqrt(1 + slope**2)
    )
    return np.asarray(height + slope_along_axis * along_axis + arc_heights)


_FORM_MODELS: dict[str, _FormModel] = {
    "circle": _compute_circle_heights,
    "sphere": _compute_sphere_heights,
    "cylinder": _compute_cylinder_heights,
}


def _estimate_form_parameters(form: RoundForm, points: PointCoordinates, heights: Floats) -> Floats:
    """Estimate initial parameters for fitting a circle, sphere or cylinder, from a fitted parabola or paraboloid."""
    x, y = points
    if form == "circle":
        quadratic_term, slope, height = np.polynomial.polynomial.polyfit(x, heights, 2)[::-1]
        return np.array([height, 2 * quadratic_term, slope])
    design_matrix = np.stack([np.ones_like(x), x, y, x**2, x * y, y**2], axis=1)
    height, slope_x, slope_y, xx, xy, yy = np.linalg.lstsq(design_matrix, heights, rcond=None)[0]
    if form == "sphere":
        return np.array([height, xx + yy, slope_x, slope_y])
    curvatures, directions = np.linalg.eigh([[2 * xx, xy], [xy, 2 * yy]])
    # The axis of a cylinder is the direction of the smallest curvature.
    axis_direction = directions[:, int(np.argmin(np.abs(curvatures)))]
    angle = math.atan2(axis_direction[1], axis_direction[0])
    slope_along_axis = slope_x * axis_direction[0] + slope_y * axis_direction[1]
    slope = slope_y * axis_direction[0] - slope_x * axis_direction[1]
    return np.array([height, float(curvatures[int(np.argmax(np.abs(curvatures)))]), slope, slope_along_axis, angle])


def _estimate_parameter_scales(form: RoundForm, points: PointCoordinates, heights: Floats) -> Floats:
    """Return typical magnitudes of the parameters of a circle, sphere or cylinder, to normalise them in the fit."""
    largest_extent = max(float(np.ptp(points[0])), float(np.ptp(points[1])))
    height = float(np.ptp(heights))
    slopes = {
        "circle": [height / largest_extent],
        "sphere": [height / largest_extent] * 2,
        "cylinder": [height / largest_extent] * 2 + [1.0],
    }
    return np.array([height, 8 * height / largest_extent**2, *slopes[form]])
