import numpy as np
import pytest
from stiction import Profile, Surface, half_space
from support.rough_surfaces import rough_maps

MAX_OFFSET = 1e-4  # residual distance of the resultant force from the centre, relative to the length
# Relative error of a stiffness from two loads that differ by ±2 %. Some points come into contact between these loads.
STIFFNESS_TOLERANCE = 0.03
DENSE_SOLUTION_TOLERANCE = 1e-5  # relative difference of results from those of dense matrices
BALL_TOLERANCE = 1e-3  # relative error of the tilt of a ball whose summit moves to the middle


def make_pair(seed, shape=(48, 64)):
    return rough_maps(seed, shape=shape)


def resultant(curve, index, missing=None):
    """Return the distance of the resultant force from the middle of the measured area, relative to its length."""
    contact = curve.contact(index)
    present = np.ones(contact.pressure.shape) if missing is None else 1.0 * ~missing
    places = np.indices(contact.pressure.shape).reshape(contact.pressure.ndim, -1)
    middles = [places @ weight.ravel() / weight.sum() for weight in (contact.pressure, present)]
    return (middles[0] - middles[1]) / contact.pressure.shape


@pytest.mark.parametrize("hardness", [None, 0.4])
@pytest.mark.parametrize("holes", [False, True])
def test_free_tilt_centres_the_resultant_force_and_stiffness_equals_the_load_derivative(hardness, holes):
    upper, lower = make_pair(3)
    missing = np.zeros(lower.heights.shape, bool)
    if holes:
        missing[:, 50:] = True
        lower = Surface(lower.heights, spacing=lower.spacing, missing=missing)
    loads = [0.1, 0.98, 1.0, 1.02, 5.0]
    fixed, free = (half_space(upper, lower, loads, tilt=tilt, hardness=hardness) for tilt in ("fixed", "free"))
    assert np.abs([resultant(fixed, index, missing) for index in range(5)]).max() > 0.05
    assert np.abs([resultant(free, index, missing) for index in range(5)]).max() < MAX_OFFSET
    assert not fixed.tilt.any()
    assert free.tilt.shape == (5, 2)
    area = (~missing).sum() * 0.01
    for curve in (fixed, free):
        rise = 0.04 / (curve.approach[3] - curve.approach[1])
        assert curve.stiffness[2] == pytest.approx(rise, rel=STIFFNESS_TOLERANCE)
        assert curve.closure_stiffness[2] == pytest.approx(
            0.04 / area / np.ptp(curve.closure[[1, 3]]), rel=STIFFNESS_TOLERANCE
        )
    assert (free.stiffness < fixed.stiffness.max()).any()


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_closure_equals_the_decrease_of_the_mean_gap(boundary):
    upper, lower = make_pair(5)
    holed = Surface(lower.heights, spacing=lower.spacing, missing=np.arange(64) >= 50 + np.zeros((48, 1)))
    for below in (holed, lower):
        curve = half_space(upper, below, [0.5, 5.0, 5.001], boundary=boundary, tolerance=1e-8)
        present = ~np.isnan(curve.contact(0).gap)
        gap = (upper.heights - lower.heights)[present]
        for index in range(3):
            lost = (gap - gap.min()).mean() - np.nanmean(curve.contact(index).gap)
            assert curve.closure[index] == pytest.approx(lost, rel=1e-9)
        rise = 0.001 / (present.sum() * 0.01) / (curve.closure[2] - curve.closure[1])
        assert curve.closure_stiffness[1] == pytest.approx(rise, rel=1e-3)
    if boundary == "periodic":
        np.testing.assert_allclose(curve.closure, curve.approach, rtol=1e-9)
        np.testing.assert_allclose(curve.closure_stiffness, curve.stiffness / (48 * 64 * 0.01), rtol=1e-9)
    else:
        assert (curve.closure < curve.approach).all()


def test_approach_and_moments_caused_by_tilt_agree_with_a_dense_matrix_calculation():
    from stiction.mechanics.half_space_problem import TiltResponse, lever_arms

    one = half_space(*make_pair(3, (24, 32)), [1.0]).at(0)
    problem, free = one.problem, one.on_grid(one.below_hardness)
    result, points = TiltResponse.solve(problem, free), np.flatnonzero(free)
    unit = np.eye(free.size).reshape(-1, *free.shape)
    kernel = np.array([problem.grids.displacement(unit[point]).ravel()[points] for point in points])
    whole = np.block([[kernel, -np.ones((points.size, 1))], [np.ones((1, points.size)), np.zeros((1, 1))]])
    arms = [np.broadcast_to(arm, free.shape).ravel()[points] for arm in lever_arms(problem)]
    level = np.linalg.solve(whole, np.r_[np.zeros(points.size), free.size])
    turned = [np.linalg.solve(whole, np.r_[-arm, 0.0])[:-1] for arm in arms]
    moments_per_slope = [[item @ arm / free.size for arm in arms] for item in turned]
    assert result.approach == pytest.approx(level[-1], rel=DENSE_SOLUTION_TOLERANCE)
    np.testing.assert_allclose(
        result.moments, [level[:-1] @ arm / free.size for arm in arms], rtol=DENSE_SOLUTION_TOLERANCE
    )
    np.testing.assert_allclose(result.moments_per_slope, moments_per_slope, rtol=100 * DENSE_SOLUTION_TOLERANCE)


@pytest.mark.parametrize("areal", [True, False])
def test_free_tilt_moves_the_summit_of_a_ball_to_the_middle(areal):
    x = (np.arange(65) - 32) * 0.1
    ball = -((x - 1.3) ** 2) / 40 - (x[:, np.newaxis] ** 2 / 40 if areal else 0)
    kind = Surface if areal else Profile
    curve = half_space(kind(0 * ball, spacing=0.1), kind(ball, spacing=0.1), [1e-2, 1.0], tilt="free")
    np.testing.assert_allclose(curve.tilt[:, -1], 1.3 / 20, rtol=BALL_TOLERANCE)
    assert np.isfinite(curve.closure).all()


def test_free_tilt_balances_a_single_contact_point():
    x = (np.arange(65) - 32) * 0.1
    ball = Surface(-((x - 1.3) ** 2) / 40 - x[:, np.newaxis] ** 2 / 40, spacing=0.1)
    curve = half_space(Surface(0 * ball.heights, spacing=0.1), ball, [1e-9], tilt="free")
    assert np.abs(resultant(curve, 0)).max() < MAX_OFFSET


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
        half_space(*make_pair(1, (16, 16)), **({"loads": [1.0], "tilt": "free"} | arguments))
