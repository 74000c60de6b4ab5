"""Tests of the closed form as a function of the cutoff: its terms, its limits, and the half-space model."""

import math

import numpy as np
import pytest
from stiction import Profile, gentle_friction, resolution, scale_dependent_roughness, spectral_resolution
from support.rough_surfaces import rough_maps

PAIR_OPTIONS = {"pressure": 0.05, "hardness": 4.0, "mu0": 0.2, "tau0": 0.2, "effective_modulus": 115.0}


def create_rough_surfaces(points=256):
    wavelengths = {"longest_wavelength": min(1.28, 0.02 * points), "shortest_wavelength": 0.08}
    return rough_maps(6, hurst_exponent=0.6, rms=0.01, points=points, spacing=0.02, **wavelengths)


def measure_roughness_of_bodies(bodies):
    return [scale_dependent_roughness(body, periodic=True) for body in bodies]


def test_elastic_pressure_in_the_spectral_estimate_is_limited_to_the_hardness():
    upper, lower = measure_roughness_of_bodies(create_rough_surfaces())
    result = spectral_resolution(upper, lower, **PAIR_OPTIONS)
    gradient = np.hypot(upper.gradient_at(result.wavelength), lower.gradient_at(result.wavelength))
    assert result.rms_gradient.values == pytest.approx(gradient)
    pressure = np.minimum(115.0 * gradient / 2.2, 4.0)
    # The area is at most the nominal area, so the mean pressure is at least the nominal pressure.
    limited_pressure = np.maximum(pressure, 0.05)
    assert result.mean_pressure.values == pytest.approx(limited_pressure)
    assert result.contact_area_fraction.values == pytest.approx(0.05 / limited_pressure)
    mu = result.friction_coefficient.sel(sliding="all").values
    assert mu == pytest.approx(0.2 + 0.2 / limited_pressure)
    assert mu[-1] == pytest.approx(0.2 + 0.2 / 4.0)
    wavelength = float(result.plastic_wavelength)
    assert float(result.rms_gradient.sel(wavelength=wavelength)) >= 2.2 * 4.0 / 115.0
    elastic_result = spectral_resolution(upper, lower, **PAIR_OPTIONS | {"hardness": None})
    ratio = np.asarray(upper.gradient_at(result.wavelength) / lower.gradient_at(result.wavelength))
    expected = gentle_friction(0.2, 0.2, rms_gradient=gradient, effective_modulus=115.0, kappa=2.2, slope_ratio=ratio)
    is_light = elastic_result.contact_area_fraction.values < 1
    assert elastic_result.friction_coefficient.sel(sliding="opposing").values[is_light] == pytest.approx(
        expected[is_light]
    )
    assert math.isnan(elastic_result.plastic_wavelength)


def test_spectral_estimate_of_the_effect_of_scan_resolution_agrees_with_half_space_model():
    bodies = create_rough_surfaces()
    upper, lower = measure_roughness_of_bodies(bodies)
    load = 0.05 * (256 * 0.02) ** 2
    half_space_result = resolution(
        *bodies, [load], hardness=4.0, mu0=0.2, tau0=0.2, effective_modulus=115.0, boundary="periodic", cut_offs=[]
    )
    result = spectral_resolution(upper, lower, **PAIR_OPTIONS, wavelengths=[0.04])
    assert float(result.contact_area_fraction[0]) == pytest.approx(
        float(half_space_result.contact_area_fraction[0, 0]), rel=0.15
    )
    # A contact patch opposes the motion as a whole, with a smaller slope than its points.
    for rule, tolerance in (("all", 0.05), ("opposing", 0.15)):
        estimated_friction, solved_friction = (
            item.friction_coefficient.sel(sliding=rule).values.ravel()[0] for item in (result, half_space_result)
        )
        assert estimated_friction == pytest.approx(solved_friction, rel=tolerance)


def test_spectral_estimate_for_a_surface_on_a_flat_assumes_zero_slope_of_the_flat():
    upper = measure_roughness_of_bodies(create_rough_surfaces(64))[0]
    result = spectral_resolution(upper, None, **PAIR_OPTIONS)
    assert result.rms_gradient.values == pytest.approx(upper.gradient_at(result.wavelength))
    friction_at_opposing, friction_at_all_contacts = (
        result.friction_coefficient.sel(sliding=rule).values for rule in ("opposing", "all")
    )
    assert friction_at_opposing == pytest.approx(friction_at_all_contacts / 2)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"pressure": 0.0}, "pressure must be a finite number above 0 GPa"),
        ({"hardness": 0.01}, "hardness must be a finite number above 0.05 GPa"),
        ({"mu0": -1.0}, "mu0 must not be negative"),
        ({"kappa": 0.0}, "kappa must be a finite number above 0"),
        ({"wavelengths": [1e3]}, "wavelengths must be at most the longest"),
        ({"wavelengths": [0.0]}, "wavelength must be above 0"),
    ],
)
def test_spectral_resolution_function_rejects_invalid_arguments(changes, message):
    upper, lower = measure_roughness_of_bodies(create_rough_surfaces(32))
    with pytest.raises(ValueError, match=message):
        spectral_resolution(upper, lower, **PAIR_OPTIONS | changes)
    profile_roughness = scale_dependent_roughness(Profile(np.sin(np.arange(99.0)), spacing=0.1))
    with pytest.raises(ValueError, match="must be ScaleDependentRoughness objects computed from surfaces"):
        spectral_resolution(profile_roughness, lower, **PAIR_OPTIONS)
