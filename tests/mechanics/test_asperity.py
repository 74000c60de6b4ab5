import numpy as np
import pytest
from reference import pressing
from stiction import Profile, Surface, asperities

# Relative difference between one spline from two solvers: round-off of the second differences, relative to their rms.
SPLINE_TOLERANCE = 1e-12


@pytest.mark.parametrize("side", ["lower", "upper"])
@pytest.mark.parametrize("dimension", [1.0, 1.7])
def test_slope_and_curvature_of_asperities_equal_values_of_a_natural_spline_from_scipy(
    create_rough_profiles, dimension, side
):
    profile = create_rough_profiles(dimension)[0]
    slope, curvature, normal, radius = pressing.fit_spheres(profile.heights, profile.spacing, upper=side == "upper")
    asperity_table = asperities(profile, side)
    assert np.abs(asperity_table.slope - slope).max() < SPLINE_TOLERANCE * slope.std()
    assert np.abs(asperity_table.curvature - curvature).max() < SPLINE_TOLERANCE * curvature.std()
    assert np.abs(asperity_table.normal[:, [0, 2]] - normal).max() < SPLINE_TOLERANCE
    assert np.allclose(1 / asperity_table.radius, 1 / radius, rtol=0, atol=SPLINE_TOLERANCE * curvature.std())


def test_asperities_of_a_circle_have_the_radius_and_centre_of_the_circle(create_circular_arc):
    # The curvature error of the spline is of second order in spacing / radius. The ends are ten points away.
    apex, radius = 0.5, 2.0
    for side, height in (("lower", -radius), ("upper", radius)):
        arc = asperities(create_circular_arc(apex, radius, 0.002, 500, side), side)
        inner_range = slice(20, -20)
        assert np.allclose(arc.radius[inner_range], radius, rtol=2e-6)
        assert np.allclose(arc.centre[inner_range], [apex, 0, height], atol=4e-6)


def test_asperities_at_profile_ends_have_zero_curvature_and_result_arrays_are_read_only():
    profile = Profile(np.sin(np.arange(30.0)), spacing=0.1)
    lower = asperities(profile, "lower")
    assert lower.curvature[[0, -1]].tolist() == [0, 0]
    assert np.isinf(lower.radius[[0, -1]]).all()
    assert not any(array.flags.writeable for array in vars(lower).values())


def test_asperities_function_rejects_a_side_that_is_neither_upper_nor_lower():
    with pytest.raises(ValueError, match="side must be one of 'lower', 'upper', got 'left'"):
        asperities(Profile(np.arange(9.0), spacing=1), "left")


def test_asperities_function_rejects_a_surface_instead_of_a_profile():
    with pytest.raises(ValueError, match="profile must be a Profile, got Surface"):
        asperities(Surface(np.eye(9), spacing=1), "lower")
