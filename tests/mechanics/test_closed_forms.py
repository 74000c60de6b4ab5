"""Tests of closed forms against other packages and each other, and tests of the asperity model against closed forms."""

import math
import re
import warnings

import numpy as np
import pytest
import stiction
from hypothesis import given, settings
from hypothesis import strategies as st
from reference import elastic_plastic
from stiction import (
    HertzCylinder,
    HertzSphere,
    JacksonGreen,
    Profile,
    effective_modulus,
    force_and_area,
    hertz_cylinder,
    hertz_sphere,
    press,
    random_phases,
    slope_friction,
    weierstrass_mandelbrot,
    weierstrass_mandelbrot_moments,
    westergaard_contact_fraction,
)

REORDERING_TOLERANCE = 1e-13
length_strategy = st.floats(1e-4, 1e3)
modulus_strategy = st.floats(1e-2, 1e3)


@given(overlap=length_strategy, radius=length_strategy, modulus=modulus_strategy)
def test_force_and_area_of_core_contact_laws_equal_closed_forms(overlap, radius, modulus):
    arguments = {"overlap": overlap, "radius": radius, "effective_modulus": modulus}
    for law, expected in (
        (HertzSphere(), hertz_sphere(**arguments)),
        ("hertz-cylinder", hertz_cylinder(**arguments)),
        (HertzCylinder(width=2.5), hertz_cylinder(**arguments, width=2.5)),
    ):
        assert np.allclose(force_and_area(law, **arguments), expected, rtol=REORDERING_TOLERANCE, atol=0)


@given(
    ratio=st.floats(1e-2, 1e3),
    radius=length_strategy,
    modulus=modulus_strategy,
    strain=st.floats(1e-4, 0.05),
    poisson=st.floats(0, 0.5),
)
def test_jackson_green_law_of_the_core_equals_the_published_fit(ratio, radius, modulus, strain, poisson):
    strength = strain * modulus
    critical_overlap, force, area = elastic_plastic.jackson_green(ratio, radius, modulus, strength, poisson)
    law = JacksonGreen(yield_strength=strength, poisson_ratio=poisson)
    actual = force_and_area(law, overlap=ratio * critical_overlap, radius=radius, effective_modulus=modulus)
    if abs(ratio / 1.9 - 1) > 1e-9:  # At a ratio of 1.9, round-off decides which branch applies.
        # Powers of powers of ratios in the formula of Jackson and Green limit the accuracy to 1e-10.
        assert actual == pytest.approx((force, area), rel=1e-10)


@pytest.fixture(scope="session")
def reference_modules():
    """Return the ContactMechanics modules with reference solutions (Hertz, Westergaard), if they are installed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        names = ("Hertz", "Westergaard")
        return [pytest.importorskip(f"ContactMechanics.ReferenceSolutions.{n}", exc_type=ImportError) for n in names]


class TestAgainstContactMechanicsPackage:
    @settings(max_examples=50)
    @given(overlap=length_strategy, radius=length_strategy, modulus=modulus_strategy)
    def test_hertz_solution_of_a_sphere_agrees_with_the_contactmechanics_library(
        self, reference_modules, overlap, radius, modulus
    ):
        force, area = hertz_sphere(overlap, radius, modulus)
        assert reference_modules[0].normal_load(overlap, radius, modulus) == pytest.approx(
            float(force), rel=REORDERING_TOLERANCE
        )
        contact_radius, _ = reference_modules[0].radius_and_pressure(float(force), radius, modulus)
        assert math.pi * contact_radius**2 == pytest.approx(float(area), rel=REORDERING_TOLERANCE)

    def test_westergaard_contact_fraction_agrees_with_the_contactmechanics_library(self, reference_modules):
        # ContactMechanics gives the half-width in wavelengths, for pressures in units of π E* Δ / λ (total height 2Δ).
        pressures = np.linspace(0.01, 0.99, 20)
        contact_fraction = westergaard_contact_fraction(
            pressures * math.pi, amplitude=1.0, wavelength=1.0, effective_modulus=1.0
        )
        expected = 2 * np.array([reference_modules[1].contact_radius(p) for p in pressures])
        assert np.allclose(contact_fraction, expected, rtol=REORDERING_TOLERANCE, atol=0)


def test_asperity_model_of_a_sinusoid_tends_to_westergaard_solution_at_light_load():
    """At light loads the crests of a sinusoid on a flat do not interact, and the areas agree.

    The first correction of arcsin is p̄/p*/6, so the difference is proportional to the load.
    """
    wavelength, amplitude, modulus, points = 1.0, 0.01, 10.0, 4001
    spacing = 10 * wavelength / (points - 1)
    heights = amplitude * np.cos(2 * np.pi * (np.arange(points) * spacing - 0.2503) / wavelength)
    lower, upper = Profile(heights, spacing=spacing), Profile(np.zeros(points), spacing=spacing)
    curve = press(upper, lower, [1e-5, 1e-4], law="hertz-cylinder", detection="gap-minimum", effective_modulus=modulus)
    pressures = curve.normal_elastic / (10 * wavelength)
    exact_fraction = westergaard_contact_fraction(
        pressures, amplitude=amplitude, wavelength=wavelength, effective_modulus=modulus
    )
    difference = curve.contact_area / (10 * wavelength) / exact_fraction - 1
    relative_pressures = pressures / (math.pi * modulus * amplitude / wavelength)
    # The difference equals the next term of the series, to 10 %. The spline apex is accurate to 1e-5 of the overlap.
    assert np.allclose(difference, -relative_pressures / 6, rtol=0.1, atol=1e-5)
    assert relative_pressures[1] > 5 * relative_pressures[0]


class TestWeierstrassMandelbrotMoments:
    def test_exact_spectral_moments_equal_mean_moments_of_many_profiles(self):
        shape = {"directions": 10, "frequencies": 6}
        exact_moments = weierstrass_mandelbrot_moments(1.4, **shape)
        moment_sums = np.zeros(3)
        count = 400
        for r in range(count):
            phases = random_phases(3, repetition=r, **shape)
            profile = weierstrass_mandelbrot(phases, 1.4, points=8000, extent=20.0)
            slope = np.gradient(profile.heights, profile.spacing)
            curvature = np.gradient(slope, profile.spacing)
            moment_sums += [profile.heights.var(), np.square(slope).mean(), np.square(curvature[2:-2]).mean()]
        # Directions m and M - m interfere, so the power scatters by 30 %, and its mean over 400 profiles by 1.5 %.
        # Long wavelengths (small |cos|) do not have a whole number of periods.
        assert np.allclose(
            moment_sums / count, [exact_moments.height, exact_moments.slope, exact_moments.curvature], rtol=0.05
        )

    def test_exact_spectral_moments_depend_on_the_dimension_convention_and_the_shortest_wavelength(self):
        paper_moments = weierstrass_mandelbrot_moments(1.6)
        classical_moments = weierstrass_mandelbrot_moments(1.2, convention="classical")
        assert classical_moments.height == pytest.approx(paper_moments.height, rel=REORDERING_TOLERANCE)
        assert classical_moments.curvature == pytest.approx(paper_moments.curvature, rel=1e-12)
        band_limited_moments = weierstrass_mandelbrot_moments(1.6, shortest_wavelength=2 * 40 / 150_000)
        assert band_limited_moments.height < paper_moments.height
        assert band_limited_moments.curvature < 0.5 * paper_moments.curvature

    def test_exact_spectral_moments_reject_invalid_arguments(self):
        for invalid_arguments in ({"directions": 0}, {"gamma": 1.0}, {"length_scale": -1}, {"convention": "x"}):
            with pytest.raises(ValueError, match=next(iter(invalid_arguments))):
                weierstrass_mandelbrot_moments(1.5, **invalid_arguments)


def test_effective_modulus_of_equal_materials_is_half_of_their_plane_strain_modulus():
    assert effective_modulus(210.0, 0.3, 210.0, 0.3) == pytest.approx(210 / (1 - 0.09) / 2, rel=REORDERING_TOLERANCE)
    assert effective_modulus(210.0, 0.3, 1e12, 0.3) == pytest.approx(210 / (1 - 0.09), rel=1e-9)
    with pytest.raises(ValueError, match="poisson_lower"):
        effective_modulus(1.0, 0.3, 1.0, 0.6)


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda: hertz_sphere(0.0, 1.0, 1.0), "overlap"),
        (lambda: hertz_cylinder(1.0, 1.0, 1.0, width=math.nan), "width"),
        (lambda: slope_friction(-0.1, mu0=0.1), "slope_angle"),
        (lambda: slope_friction(0.1, mu0=-0.1), "mu0"),
        (lambda: slope_friction(0.1, mu0=0.1, tau0=0.1), "mean_pressure"),
        (lambda: westergaard_contact_fraction(0.1, amplitude=0, wavelength=1, effective_modulus=1), "amplitude"),
        (lambda: force_and_area("hertz-sphere", overlap=-1, radius=1), "overlap"),
        (lambda: force_and_area("jackson-green", overlap=1, radius=1), "law must be one of"),
        (lambda: force_and_area(3, overlap=1, radius=1), "law must be a contact law"),
        (lambda: force_and_area(HertzCylinder(width=-1), overlap=1, radius=1), "width"),
        (lambda: force_and_area(JacksonGreen(1.0, 0.3), overlap=1, radius=1), "yield_strength"),
        (lambda: force_and_area(JacksonGreen(0.1, 0.7), overlap=1, radius=1), "poisson_ratio"),
    ],
)
def test_closed_forms_reject_invalid_arguments(call, word):
    with pytest.raises(ValueError, match=word):
        call()


EXTREME_VALUES = (5e-324, 1e-300, 1e-150, 1e150, 1e300, 1.7e308)
CLOSED_FORMS = (
    ("effective_modulus", (210.0, 0.3, 100.0, 0.3), {}),
    ("hertz_sphere", (0.01, 1.0, 10.0), {}),
    ("hertz_cylinder", (0.01, 1.0, 10.0), {"width": 1.0}),
    ("hertz_line", (0.01, 1.0, 10.0), {"width": 1.0}),
    ("hertz_ellipse", (0.01, 1.0, 2.0, 10.0), {}),
    ("tabor_parameter", (1.0, 80.0), {"work_of_adhesion": 5e-5, "adhesion_range": 5e-4}),
    ("jkr", (0.0, 1.0, 80.0), {"work_of_adhesion": 5e-5}),
    ("dmt", (0.0, 1.0, 80.0), {"work_of_adhesion": 5e-5}),
    ("maugis_dugdale", (0.0, 1.0, 80.0), {"work_of_adhesion": 5e-5, "adhesion_range": 5e-4}),
    ("fuller_tabor", (0.01, 1.0, 80.0), {"work_of_adhesion": 5e-5}),
    ("gentle_friction", (0.4,), {"rms_gradient": 0.04, "effective_modulus": 10.0, "slope_ratio": 1.0}),
    ("slope_friction", (0.1,), {"mu0": 0.4, "tau0": 0.01, "mean_pressure": 1.0}),
    ("hardness_under_shear", (2.0, 0.2, 0.05, 9.0), {}),
    ("tabor_friction", (2.0, 0.2, 0.05, 9.0), {}),
    ("westergaard_contact_fraction", (0.01,), {"amplitude": 0.1, "wavelength": 1.0, "effective_modulus": 10.0}),
    ("westergaard_pressure", (0.1, 0.01), {"amplitude": 0.1, "wavelength": 1.0, "effective_modulus": 10.0}),
    ("westergaard_gap", (0.1, 0.01), {"amplitude": 0.1, "wavelength": 1.0, "effective_modulus": 10.0}),
)


@pytest.mark.parametrize(("name", "positional", "named"), CLOSED_FORMS, ids=[form[0] for form in CLOSED_FORMS])
def test_closed_forms_return_finite_values_or_raise_value_error_for_extreme_arguments(name, positional, named):
    """Replace one argument at a time by an extreme value, with NumPy's warnings as errors."""
    function = getattr(stiction, name)
    function(*positional, **named)
    messages = set()
    for value in EXTREME_VALUES:
        calls = [([*positional[:i], value, *positional[i + 1 :]], named) for i in range(len(positional))]
        calls += [(positional, {**named, argument_name: value}) for argument_name in named]
        for arguments, keywords in calls:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                try:
                    result = function(*arguments, **keywords)
                except ValueError as error:
                    messages.add(str(error))
                    continue
            parts = result if isinstance(result, tuple) else (result,)
            assert not any(np.isinf(part).any() for part in parts)
    assert all(
        re.search(f"^arguments of {name} must not be so large or so small|must be|must not", message)
        for message in messages
    ), messages


def test_closed_forms_accept_empty_arrays():
    assert stiction.gentle_friction(0.4, rms_gradient=0.04, effective_modulus=[]).shape == (0,)
    assert hertz_sphere([], 1.0, 10.0)[0].shape == (0,)


def test_closed_form_error_names_the_argument_that_is_not_positive():
    with pytest.raises(ValueError, match=r"^overlap must be above 0, got -0\.5$"):
        hertz_sphere(np.array([[0.1, -0.5]]), 1.0, 10.0)


def test_small_slope_friction_rejects_an_array_as_order_of_the_approximation():
    with pytest.raises(ValueError, match="order must be 1 or 2"):
        stiction.gentle_friction(0.4, rms_gradient=0.04, order=np.array([1, 2]))
