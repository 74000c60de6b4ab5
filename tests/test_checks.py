"""Tests of the argument checks of all public functions."""

from __future__ import annotations

import numpy as np
import pytest
import stiction
import xarray
from stiction import effective_modulus, half_space, hertz_sphere, self_affine_surface
from stiction._checks import check_bool, check_choice, validate_number, validate_whole_number
from stiction.mechanics.model import SlidingRule

ZERO_DIMENSIONAL_TYPES = [np.float64, np.float32, np.int32, np.array, xarray.DataArray]


@pytest.mark.parametrize("create_value", ZERO_DIMENSIONAL_TYPES, ids=lambda create_value: create_value.__name__)
def test_number_check_accepts_zero_dimensional_arrays(create_value):
    result = validate_number("x", create_value(3), above=0)
    assert (result, type(result)) == (3.0, float)
    with pytest.raises(ValueError, match="x must be a finite number above 5"):
        validate_number("x", create_value(3), above=5)


@pytest.mark.parametrize("value", [np.array(True), np.array([3.0]), np.array("3"), np.bool_(True), "3", None, 1j])
def test_number_check_rejects_values_that_are_not_numbers(value):
    with pytest.raises(ValueError, match="x must be a finite number"):
        validate_number("x", value)


def test_integer_and_choice_checks_accept_zero_dimensional_arrays():
    assert validate_whole_number("n", np.array(3), minimum=1) == 3
    check_bool("t", np.array(True))
    check_choice("sliding", np.array("all"), SlidingRule)
    for value in ([], {}, np.zeros(3), 1.0, None):
        with pytest.raises(ValueError, match="sliding must be one of"):
            check_choice("sliding", value, SlidingRule)


def test_effective_modulus_computed_from_scalar_inputs_is_a_float():
    assert type(effective_modulus(210, 0.3, 210, 0.3)) is float
    moduli_from_arrays = effective_modulus([210, 70], 0.3, 210, 0.3)
    assert isinstance(moduli_from_arrays, np.ndarray)
    assert moduli_from_arrays[0] == effective_modulus(210, 0.3, 210, 0.3)


def test_half_space_accepts_zero_dimensional_arrays():
    bodies = [
        self_affine_surface(1, hurst_exponent=0.8, rms=0.01, shape=(32, 32), spacing=0.1, side=side)
        for side in ("upper", "lower")
    ]
    modulus, hardness = np.asarray(10.0), xarray.DataArray(1.0)
    curve = half_space(*bodies, [np.asarray(1e-3)], effective_modulus=modulus, hardness=hardness)
    expected = half_space(*bodies, [1e-3], effective_modulus=10.0, hardness=1.0)
    assert np.array_equal(curve.contact_area, expected.contact_area)
    assert curve.friction_coefficient(mu0=np.asarray(0.3)) == expected.friction_coefficient(mu0=0.3)
    assert np.ndim(hertz_sphere(0.1, 1.0, 10.0)[0]) == 0


FUNCTIONS_OF_RESULTS = {
    "area_map": lambda value: stiction.area_map(value, [1.0]),
    "friction_map": lambda value: stiction.friction_map(value, [1.0]),
    "friction_table": stiction.friction_table,
    "nondimensional": stiction.nondimensional,
    "pair_of": lambda value: stiction.pair_of(value, 1, fractal_dimension=1.3, amplitude=0.1),
    "resolution_friction": lambda value: stiction.resolution_friction(value, mu0=0.2),
    "stiffness_map": lambda value: stiction.stiffness_map(value, [1.0]),
}


@pytest.mark.parametrize("name", FUNCTIONS_OF_RESULTS)
@pytest.mark.parametrize("value", [np.ones((4, 4)), "folder", None, 3])
def test_functions_that_take_a_result_reject_other_objects(name, value):
    argument = "study" if name == "pair_of" else "result"
    with pytest.raises(ValueError, match=f"^{argument} must be .*, got {type(value).__name__}$"):
        FUNCTIONS_OF_RESULTS[name](value)


@pytest.mark.parametrize("value", [np.array([0.1, 0.2]), np.array([]), 3])
def test_material_argument_must_be_a_name(value):
    with pytest.raises(ValueError, match="upper_material must be the name of a material"):
        stiction.Ball("5 mm", upper_material=value)
