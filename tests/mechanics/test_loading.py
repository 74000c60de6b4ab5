import numpy as np
import pytest
from stiction import Profile, approach_at_load, press

# Relative error of the load at an approach whose relative error is 1e-12, if the load is a low power of the approach.
LOAD_TOLERANCE = 1e-11
ARC_TOLERANCE = 1e-6


@pytest.mark.parametrize("detection", ["cell", "gap-minimum"])
def test_approach_of_circular_arcs_at_a_load_equals_hertz_solution(create_circular_arc, detection):
    radius, spacing = 1.0, 1e-3
    lower = create_circular_arc(0.5003, radius, spacing, 1001, "lower")
    upper = create_circular_arc(0.5003, radius, spacing, 1001, "upper")
    # The apexes lie between grid points, at this height difference from the nearest points.
    apex_height = 2 * (radius - np.sqrt(radius**2 - 0.0003**2))
    overlaps = np.array([1e-4, 1e-3, 1e-2])
    loads = 4 / 3 * 10.0 * np.sqrt(radius / 2) * overlaps**1.5
    result = approach_at_load(upper, lower, loads, mu0=0.3, detection=detection)
    np.testing.assert_allclose(result + apex_height, overlaps, rtol=ARC_TOLERANCE, atol=1e-9)


def test_approaches_at_several_loads_have_the_array_shape_of_the_loads(create_rough_profiles):
    upper, lower = create_rough_profiles(1.2)
    loads = np.array([[1e-4, 1e-3, 3e-3], [2e-3, 2e-4, 1e-2]])
    result = approach_at_load(upper, lower, loads, mu0=0.4)
    assert result.shape == loads.shape
    assert approach_at_load(upper, lower, 1e-3, mu0=0.4) == result[0, 1]


@pytest.mark.parametrize("detection", ["cell", "gap-minimum"])
@pytest.mark.parametrize("dimension", [1.1, 1.4, 1.6])
@pytest.mark.parametrize("shear", ["+x", "-x"])
def test_approach_at_a_load_is_the_smallest_approach_that_carries_this_load(
    create_rough_profiles, dimension, detection, shear
):
    upper, lower = create_rough_profiles(dimension)
    choices = {"detection": detection, "shear": shear, "effective_modulus": 20.0}
    friction = {"mu0": 0.4, "tau0": 0.2}
    loads = np.geomspace(1e-4, 1e-2, 7)
    result = approach_at_load(upper, lower, loads, **friction, **choices)
    is_reached = np.isfinite(result)
    assert is_reached.sum() >= 3
    if not is_reached.all():
        approaches = np.ptp(upper.heights - lower.heights) * np.geomspace(1e-4, 1.0, 400)
        loads_at_approaches = press(upper, lower, approaches, **choices).normal_load(**friction)
        # At D = 1.6 single contacts with a high load appear and vanish within one or two steps.
        assert (loads_at_approaches >= loads[~is_reached].min()).mean() < 0.03
    for load, approach in zip(loads[is_reached], result[is_reached], strict=True):
        loads_around_result = press(upper, lower, [approach * (1 - 1e-11), approach], **choices).normal_load(**friction)
        assert loads_around_result[0] < load * (1 + LOAD_TOLERANCE)
        assert loads_around_result[1] >= load * (1 - LOAD_TOLERANCE)
        # No smaller approach supports the load, except for contacts that vanish within a step of the search.
        loads_below_result = press(upper, lower, approach * np.geomspace(1e-4, 1 / 1.1, 200), **choices).normal_load(
            **friction
        )
        assert (loads_below_result >= load).mean() < 0.03


def test_approach_at_a_given_load_increases_with_friction(create_rough_profiles):
    upper, lower = create_rough_profiles(1.3)
    approach_without_friction, approach_with_friction = (
        approach_at_load(upper, lower, 1e-3, mu0=mu0) for mu0 in (0.0, 1.0)
    )
    assert approach_with_friction > approach_without_friction


def test_approach_at_an_unreachable_load_is_nan(create_circular_arc):
    flat = Profile(np.zeros(401), spacing=0.01)
    assert np.isnan(approach_at_load(flat, flat, 1.0, mu0=0.3))
    ball = create_circular_arc(2.003, 3.0, 0.01, 401, "lower")
    assert np.isnan(approach_at_load(flat, ball, 1e9, mu0=0.3))
    assert np.isfinite(approach_at_load(flat, ball, 1e-3, mu0=0.3))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"loads": 0.0}, "loads must be above 0"),
        ({"loads": [1.0, -1.0]}, "loads must be above 0"),
        ({"loads": np.nan}, "loads must be finite"),
        ({"loads": "1 nm"}, "loads has the unit 'nm', which is not a unit of force"),
        ({"mu0": -0.1}, "mu0 must not be negative"),
        ({"mu0": [0.1, 0.2]}, "mu0 must be a finite number"),
        ({"tau0": np.inf}, "tau0 must be a finite number"),
        ({"shear": "x"}, "shear must be one of"),
    ],
)
def test_search_for_the_approach_at_a_load_rejects_invalid_arguments(create_rough_profiles, arguments, words):
    upper, lower = create_rough_profiles(1.2)
    with pytest.raises(ValueError, match=words):
        approach_at_load(upper, lower, **({"loads": 1e-3, "mu0": 0.4} | arguments))
