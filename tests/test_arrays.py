"""Test functions with NumPy arrays instead of profiles and surfaces, and with lengths as texts with units."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
import stiction
from stiction import (
    Profile,
    Surface,
    estimate_hurst_exponent,
    half_space,
    levelled,
    pair,
    power_spectrum,
    roughness_parameters,
    scale_dependent_roughness,
    self_affine_surface,
    surface_parameters,
    surface_spectrum,
)

HEIGHT_ARRAYS = [
    self_affine_surface(1, hurst_exponent=0.8, rms=0.01, shape=(48, 48), spacing=0.1, side=side).heights
    for side in ("upper", "lower")
]
UPPER_SURFACE, LOWER_SURFACE = (Surface(z, spacing=(0.1, 0.1)) for z in HEIGHT_ARRAYS)
LINE_HEIGHTS = HEIGHT_ARRAYS[0][0]


@pytest.mark.parametrize("spacing", [0.1, "100 nm", ("0.1 um", 0.1)])
def test_array_with_spacing_and_unit_is_treated_as_a_surface(spacing):
    result = surface_parameters(1e3 * HEIGHT_ARRAYS[0], spacing=spacing, unit="nm")
    assert result.Sq == pytest.approx(surface_parameters(UPPER_SURFACE).Sq, rel=1e-12)
    assert result.Sdq == pytest.approx(surface_parameters(UPPER_SURFACE).Sdq, rel=1e-12)


@pytest.mark.parametrize(("function", "heights"), [
    (lambda z, **options: roughness_parameters(z, **options).Pq, LINE_HEIGHTS),
    (lambda z, **options: power_spectrum(z, **options).density, LINE_HEIGHTS),
    (lambda z, **options: surface_spectrum(z, **options).density, HEIGHT_ARRAYS[0]),
    (lambda z, **options: levelled(z, "mean", **options).heights, LINE_HEIGHTS),
    (lambda z, **options: levelled(z, "plane", **options).heights, HEIGHT_ARRAYS[0]),
    (lambda z, **options: estimate_hurst_exponent(z, **options).value, HEIGHT_ARRAYS[0]),
    (lambda z, **options: scale_dependent_roughness(z, **options).gradient, HEIGHT_ARRAYS[0]),
])  # fmt: skip
def test_functions_of_a_single_body_accept_arrays_of_heights(function, heights):
    body = (Profile if heights.ndim == 1 else Surface)(heights, spacing=0.1)
    assert np.array_equal(function(heights, spacing="0.1 um"), function(body))


def test_half_space_function_and_pair_function_accept_arrays_of_heights():
    expected = half_space(UPPER_SURFACE, LOWER_SURFACE, [1e-3], effective_modulus=10.0)
    curve = half_space(*HEIGHT_ARRAYS, [1e-3], spacing="100 nm", effective_modulus=10.0)
    assert np.array_equal(curve.contact_area, expected.contact_area)
    options = {"load": "1 MPa", "mu0": 0.2, "effective_modulus": "10 GPa", "shifts": 2, "onset": 0}
    curve = pair(1e3 * HEIGHT_ARRAYS[0], 1e3 * HEIGHT_ARRAYS[1], spacing="0.1 um", unit="nm", **options)
    assert curve.value == pytest.approx(pair(UPPER_SURFACE, LOWER_SURFACE, **options).value, rel=1e-9)


@pytest.mark.parametrize(("function", "words"), [
    (
        lambda: pair(*HEIGHT_ARRAYS, load="1 MPa", mu0=0.2, effective_modulus="10 GPa"),
        "spacing must be given for an array",
    ),
    (
        lambda: pair(*HEIGHT_ARRAYS, unit="um,nm", spacing=0.1, load="1 MPa", mu0=0.2, effective_modulus="10 GPa"),
        r"^unit must be one unit of length for arrays, such as um or nm, got \['um', 'nm'\]",
    ),
    (
        lambda: pair(*HEIGHT_ARRAYS, spacing=-1, load="1 MPa", mu0=0.2, effective_modulus="10 GPa"),
        "^spacing must be a finite number above 0",
    ),
    (lambda: half_space(*HEIGHT_ARRAYS, [1e-3]), r"upper must be .*Surface\(z, spacing=...\)"),
    (lambda: surface_parameters(UPPER_SURFACE, spacing=0.1), "spacing must be omitted"),
    (lambda: surface_parameters(LINE_HEIGHTS, spacing=0.1), "shape"),
    (lambda: surface_parameters(HEIGHT_ARRAYS[0], spacing=0.1, unit="V"), "unit must be"),
    (lambda: surface_parameters(HEIGHT_ARRAYS[0], spacing="0.1"), "spacing"),
    (lambda: Surface(HEIGHT_ARRAYS[0], spacing="39 mN"), "spacing has the unit 'mN'"),
    (lambda: half_space(UPPER_SURFACE, LOWER_SURFACE, [1e-3], spacing=0.1), "spacing must be omitted"),
])  # fmt: skip
def test_array_of_heights_with_missing_or_contradictory_arguments_is_rejected(function, words):
    with pytest.raises(ValueError, match=words):
        function()


def test_lengths_can_be_given_as_strings_with_units():
    assert Surface(HEIGHT_ARRAYS[0], spacing="39 nm").spacing == (0.039, 0.039)
    assert Profile(LINE_HEIGHTS, spacing="39 nm").spacing == 0.039
    assert UPPER_SURFACE.with_amplitude("50 nm").heights.max() == UPPER_SURFACE.with_amplitude(0.05).heights.max()
    text = self_affine_surface(1, hurst_exponent=0.8, rms="10 nm", shape=(48, 48), spacing="0.1 um")
    assert np.array_equal(text.heights, HEIGHT_ARRAYS[1])


BODY_ARGUMENT_NAMES = ("body", "profile", "surface", "upper", "lower", "scan", "first")
NON_BODY_ARGUMENTS = {
    "path": "never.csv",
    "level": "mean",
    "angle": 10.0,
    "effective_modulus": 10.0,
    "seed": 1,
    "mechanics": "half-space",
}


@pytest.mark.parametrize("name", [
    name for name in sorted(stiction.__all__)
    if inspect.isfunction(each := getattr(stiction, name))
    and set(inspect.signature(each).parameters) & set(BODY_ARGUMENT_NAMES)
])  # fmt: skip
@pytest.mark.parametrize("wrong_value", [np.zeros((24, 24)), 3, "x", None], ids=["array", "number", "text", "none"])
def test_functions_that_take_a_body_reject_other_arguments(name, wrong_value):
    function = getattr(stiction, name)
    arguments = {
        value.name: wrong_value if value.name in BODY_ARGUMENT_NAMES else NON_BODY_ARGUMENTS.get(value.name, 1.0)
        for value in inspect.signature(function).parameters.values()
        if value.name in BODY_ARGUMENT_NAMES or (value.default is value.empty and value.kind is not value.VAR_KEYWORD)
    }
    with pytest.raises(ValueError, match=r"must|give|is for"):
        function(**arguments)
