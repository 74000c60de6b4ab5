import numpy as np
import pytest
from scipy.spatial import ConvexHull
from stiction import Profile, Surface, half_space, self_affine_surface
from support.rough_surfaces import rough_maps

MAX_FORCE_OFFSET = 1e-4  # largest distance of the resultant force from the centre, relative to the side length
# Relative error of a stiffness from two loads that differ by ±2 %. Some points come into contact between these loads.
STIFFNESS_TOLERANCE = 0.03
DENSE_SOLUTION_TOLERANCE = 1e-5
BALL_TOLERANCE = 1e-3


def create_rough_surfaces(seed, shape=(48, 64)):
    return rough_maps(seed, shape=shape)


def compute_resultant_offset(curve, index, missing=None):
    """Return the distance of the resultant force from the middle of the measured area, divided by its length."""
    contact = curve.contact(index)
    is_measured = np.ones(contact.pressure.shape) if missing is None else 1.0 * ~missing
    grid_positions = np.indices(contact.pressure.shape).reshape(contact.pressure.ndim, -1)
    middles = [grid_positions @ weight.ravel() / weight.sum() for weight in (contact.pressure, is_measured)]
    return (middles[0] - middles[1]) / contact.pressure.shape


@pytest.mark.parametrize("hardness", [None, 0.4])
@pytest.mark.parametrize("has_holes", [False, True])
def test_free_tilt_centres_the_force_and_gives_a_stiffness_equal_to_the_derivative_of_the_load(hardness, has_holes):
    upper, lower = create_rough_surfaces(3)
    is_missing = np.zeros(lower.heights.shape, bool)
    if has_holes:
        is_missing[:, 50:] = True
        lower = Surface(lower.heights, spacing=lower.spacing, missing=is_missing)
    loads = [0.1, 0.98, 1.0, 1.02, 5.0]
    fixed_curve, free_curve = (
        half_space(upper, lower, loads, tilt=tilt, hardness=hardness) for tilt in ("fixed", "free")
    )
    assert np.abs([compute_resultant_offset(fixed_curve, index, is_missing) for index in range(5)]).max() > 0.05
    assert (
        np.abs([compute_resultant_offset(free_curve, index, is_missing) for index in range(5)]).max() < MAX_FORCE_OFFSET
    )
    assert not fixed_curve.tilt.any()
    assert free_curve.tilt.shape == (5, 2)
    area = (~is_missing).sum() * 0.01
    for curve in (fixed_curve, free_curve):
        expected_stiffness = 0.04 / (curve.approach[3] - curve.approach[1])
        assert curve.stiffness[2] == pytest.approx(expected_stiffness, rel=STIFFNESS_TOLERANCE)
        assert curve.closure_stiffness[2] == pytest.approx(
            0.04 / area / np.ptp(curve.closure[[1, 3]]), rel=STIFFNESS_TOLERANCE
        )
    assert (free_curve.stiffness < fixed_curve.stiffness.max()).any()


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_closure_equals_the_decrease_of_the_mean_gap(boundary):
    upper, lower = create_rough_surfaces(5)
    masked_lower = Surface(lower.heights, spacing=lower.spacing, missing=np.arange(64) >= 50 + np.zeros((48, 1)))
    for lower_body in (masked_lower, lower):
        curve = half_space(upper, lower_body, [0.5, 5.0, 5.001], boundary=boundary, tolerance=1e-8)
        is_measured = ~np.isnan(curve.contact(0).gap)
        gap = (upper.heights - lower.heights)[is_measured]
        for index in range(3):
            gap_decrease = (gap - gap.min()).mean() - np.nanmean(curve.contact(index).gap)
            assert curve.closure[index] == pytest.approx(gap_decrease, rel=1e-9)
        expected_stiffness = 0.001 / (is_measured.sum() * 0.01) / (curve.closure[2] - curve.closure[1])
        assert curve.closure_stiffness[1] == pytest.approx(expected_stiffness, rel=1e-3)
    if boundary == "periodic":
        np.testing.assert_allclose(curve.closure, curve.approach, rtol=1e-9)
        np.testing.assert_allclose(curve.closure_stiffness, curve.stiffness / (48 * 64 * 0.01), rtol=1e-9)
    else:
        assert (curve.closure < curve.approach).all()


def test_tilt_response_agrees_with_a_dense_matrix_calculation():
    from stiction.mechanics.half_space_problem import TiltResponse, lever_arms

    solution = half_space(*create_rough_surfaces(3, (24, 32)), [1.0]).at(0)
    problem, is_free = solution.problem, solution.on_grid(solution.below_hardness)
    result, points = TiltResponse.solve(problem, is_free), np.flatnonzero(is_free)
    unit_pressures = np.eye(is_free.size).reshape(-1, *is_free.shape)
    kernel = np.array([problem.grids.displacement(unit_pressures[point]).ravel()[points] for point in points])
    system = np.block([[kernel, -np.ones((points.size, 1))], [np.ones((1, points.size)), np.zeros((1, 1))]])
    arms = [np.broadcast_to(arm, is_free.shape).ravel()[points] for arm in lever_arms(problem)]
    untilted_solution = np.linalg.solve(system, np.r_[np.zeros(points.size), is_free.size])
    tilt_pressures = [np.linalg.solve(system, np.r_[-arm, 0.0])[:-1] for arm in arms]
    moments_per_slope = [[item @ arm / is_free.size for arm in arms] for item in tilt_pressures]
    assert result.approach == pytest.approx(untilted_solution[-1], rel=DENSE_SOLUTION_TOLERANCE)
    np.testing.assert_allclose(
        result.moments, [untilted_solution[:-1] @ arm / is_free.size for arm in arms], rtol=DENSE_SOLUTION_TOLERANCE
    )
    np.testing.assert_allclose(result.moments_per_slope, moments_per_slope, rtol=100 * DENSE_SOLUTION_TOLERANCE)


@pytest.mark.parametrize("is_areal", [True, False])
def test_free_tilt_moves_the_summit_of_a_ball_to_the_middle(is_areal):
    x = (np.arange(65) - 32) * 0.1
    ball = -((x - 1.3) ** 2) / 40 - (x[:, np.newaxis] ** 2 / 40 if is_areal else 0)
    body_class = Surface if is_areal else Profile
    curve = half_space(body_class(0 * ball, spacing=0.1), body_class(ball, spacing=0.1), [1e-2, 1.0], tilt="free")
    np.testing.assert_allclose(curve.tilt[:, -1], 1.3 / 20, rtol=BALL_TOLERANCE)
    assert np.isfinite(curve.closure).all()


def test_resultant_force_on_a_single_contact_point_is_centred_if_tilt_is_free():
    x = (np.arange(65) - 32) * 0.1
    ball = Surface(-((x - 1.3) ** 2) / 40 - x[:, np.newaxis] ** 2 / 40, spacing=0.1)
    curve = half_space(Surface(0 * ball.heights, spacing=0.1), ball, [1e-9], tilt="free")
    assert np.abs(compute_resultant_offset(curve, 0)).max() < MAX_FORCE_OFFSET


def find_rigid_contact(gap):
    """Return the indices of the points at which rigid surfaces with free tilt touch, with their load fractions.

    The points are the corners of the lower facet of the convex hull that lies under the centre.
    """
    positions = np.stack([axis.ravel() - axis.mean() for axis in np.indices(gap.shape)], axis=-1)
    hull = ConvexHull(np.column_stack([positions, gap.ravel()]))
    for corners, normal in zip(hull.simplices, hull.equations[:, :-1], strict=True):
        if normal[-1] < 0:
            fractions = np.linalg.solve(
                np.vstack([positions[corners].T, np.ones(corners.size)]), [0.0] * gap.ndim + [1]
            )
            if (fractions > 0).all():
                return corners, fractions
    raise AssertionError("the centre is below no facet")


@pytest.mark.parametrize("is_areal", [True, False])
@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_freely_tilting_bodies_touch_at_the_hull_facet_below_the_centre_at_vanishing_load(seed, is_areal):
    roughness_options = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (48, 48), "spacing": 0.1}
    upper, lower = (self_affine_surface(seed, side=side, **roughness_options) for side in ("upper", "lower"))
    upper, lower = (upper, lower) if is_areal else (upper.row(0), lower.row(0))
    curve = half_space(upper, lower, [1e-7], tilt="free")
    corners, fractions = find_rigid_contact(upper.heights - lower.heights)
    pressure = curve.contact(0).pressure.ravel()
    assert set(np.flatnonzero(pressure)) == set(corners)
    np.testing.assert_allclose(pressure[corners] / pressure.sum(), fractions, atol=2 * MAX_FORCE_OFFSET)


@pytest.mark.parametrize("hardness", [None, 0.05])
@pytest.mark.parametrize("relative_pressure", [1e-6, 1e-5, 1e-4])
def test_free_tilt_centres_the_resultant_force_even_at_low_loads(relative_pressure, hardness):
    roughness_options = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (48, 48), "spacing": 0.1}
    for seed in range(6):
        upper, lower = (self_affine_surface(seed, side=side, **roughness_options) for side in ("upper", "lower"))
        load = relative_pressure * 50 * 0.1 * 4.8**2  # h' of the gap is about 0.1, E* is 50 GPa, the side is 4.8 µm
        curve = half_space(upper, lower, [load], effective_modulus=50.0, tilt="free", hardness=hardness)
        contact = curve.contact(0)
        assert contact.pressure.sum() * 0.1**2 == pytest.approx(load)
        assert np.abs(compute_resultant_offset(curve, 0)).max() < MAX_FORCE_OFFSET
        # Points whose pressure equals the hardness yield.
        assert contact.gap.min() > (-1e-6 * 0.02 if hardness is None else -1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"tilt": "loose"}, "tilt must be one of 'fixed', 'free'"),
        (
            {"boundary": "periodic"},
            "tilt must be 'fixed' if the surfaces are periodic or adhesive, or if approaches are given, got 'free'",
        ),
        ({"work_of_adhesion": 1e-8}, "tilt must be 'fixed' if"),
        ({"loads": None, "approaches": [0.01]}, "tilt must be 'fixed' if"),
    ],
)
def test_half_space_rejects_invalid_tilt_arguments(arguments, message):
    with pytest.raises(ValueError, match=message):
        half_space(*create_rough_surfaces(1, (16, 16)), **({"loads": [1.0], "tilt": "free"} | arguments))
