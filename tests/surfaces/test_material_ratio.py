"""Tests of the material ratio curve, whose values are compared with definitions and known distributions."""

import math

import numpy as np
import pytest
from reference import roughness as reference_roughness
from scipy.stats import norm
from stiction import Surface, material_ratio, roughness_parameters, section_parameters, surface_parameters
from stiction.surfaces.material_ratio import core_parameters, heights_at_material_ratios, material_volumes
from stiction.surfaces.parameters import PROFILE_PARAMETERS, ROUGHNESS_PARAMETERS, SURFACE_PARAMETERS
from support.rough_surfaces import rough_profile, self_affine_map


@pytest.fixture(scope="module")
def map_heights():
    surface = self_affine_map(2, 0.6, (30, 40))
    return surface.heights - surface.heights.mean()


def test_material_ratios_and_heights_equal_their_definitions(map_heights):
    z = map_heights.ravel().tolist()
    for ratio in (0.0, 0.025, 0.1, 0.5, 0.8, 1.0):
        assert heights_at_material_ratios(map_heights, ratio) == pytest.approx(
            reference_roughness.height_at_material_ratio(z, ratio), rel=1e-12
        )
    levels = [-10.0, -0.5, 0.0, 0.7, 10.0]
    expected = [reference_roughness.material_ratio_at_height(z, level) for level in levels]
    assert material_ratio(Surface(map_heights, spacing=1.0), levels) == pytest.approx(expected, abs=1e-12)
    assert material_ratio(rough_profile(), [100.0]) == 0


def test_core_roughness_parameters_equal_their_definition(map_heights):
    result, expected = (
        core_parameters(map_heights),
        reference_roughness.stratified_parameters(map_heights.ravel().tolist()),
    )
    assert result == pytest.approx([expected[name] for name in ("k", "pk", "vk", "mrk1", "mrk2")], rel=1e-9)


def test_material_and_void_volumes_equal_integrals_of_the_bearing_curve(map_heights):
    result, expected = (
        material_volumes(map_heights),
        reference_roughness.material_and_void_volumes(map_heights.ravel().tolist()),
    )
    assert result == pytest.approx([expected[name] for name in ("Vmp", "Vmc", "Vvc", "Vvv")], rel=1e-3)


def test_parameters_of_uniformly_distributed_heights_equal_closed_forms():
    # Heights are uniform from -1 to 1, so c(p) = 1 - 2 p, and the volume above ratio p is p².
    uniform_surface = Surface(
        np.random.default_rng(1).permutation(np.linspace(-1, 1, 40_000)).reshape(200, 200), spacing=1.0
    )
    result = surface_parameters(uniform_surface)
    expected = {
        "Sp": 1, "Sv": 1, "Smr": 0.5, "Sdc": 1.4, "Sxp": 0.95, "Vmp": 0.01, "Vmc": 0.63, "Vvc": 0.81 - 0.04,
        "Vvv": 0.04,
    }  # fmt: skip
    for name, value in expected.items():
        assert getattr(result, name) == pytest.approx(value, rel=1e-3), name


def test_parameters_of_normally_distributed_heights_equal_closed_forms():
    z = norm.isf((np.arange(250_000) + 0.5) / 250_000)
    result = surface_parameters(Surface(np.random.default_rng(2).permutation(z).reshape(500, 500), spacing=1.0))

    def material_volume(ratio):
        return norm.pdf(norm.isf(ratio)) - norm.isf(ratio) * ratio

    assert result.Sxp == pytest.approx(norm.isf(0.025), rel=1e-3)
    assert result.Sdc == pytest.approx(norm.isf(0.1) - norm.isf(0.8), rel=1e-3)
    assert result.Vmp == pytest.approx(material_volume(0.1), rel=2e-3)
    assert result.Vmc == pytest.approx(material_volume(0.8) - material_volume(0.1), rel=2e-3)
    assert result.Vvv == pytest.approx(material_volume(0.2), rel=2e-3)  # by symmetry
    assert result.Vvc == pytest.approx(material_volume(0.9) - material_volume(0.2), rel=2e-3)


def test_core_material_and_void_volumes_per_area_add_up_to_the_core_height(map_heights):
    result = material_volumes(map_heights)
    upper, lower = heights_at_material_ratios(map_heights, [0.1, 0.8])
    assert result.core_material + result.core_void == pytest.approx(upper - lower, rel=1e-12)


def test_repr_of_roughness_parameters_shows_units_and_missing_values():
    result = surface_parameters(Surface(np.add.outer(np.zeros(30), np.sin(np.arange(60.0))), spacing=0.5))
    lines = dict(line.strip().split(None, 1) for line in repr(result).splitlines()[1:])
    assert lines["Str"] == "none"
    assert lines["Spd"].endswith("1/µm²")
    assert lines["levelled"] == "no"
    with pytest.raises(AttributeError, match="SurfaceParameters has no parameter 'Ra'"):
        result.Ra  # noqa: B018
    assert math.isnan(result.Str)
    assert list(roughness_parameters(rough_profile()).values) == ["Pa", "Pq", "Pt", "Psk", "Pku", "Pdq"]


def test_roughness_parameters_scale_with_size_according_to_their_units():
    surface = self_affine_map(2, 0.6, (30, 40))
    assert tuple(surface_parameters(surface).values) == tuple(parameter.name for parameter in SURFACE_PARAMETERS)
    result = section_parameters(rough_profile(points=4000), lc=8.0)
    assert tuple(result.values) == tuple(parameter.name for letter in "RW" for parameter in PROFILE_PARAMETERS[letter])
    # `ROUGHNESS_PARAMETERS` is keyed by name, so its length is the sum only if all names are unique.
    assert len(ROUGHNESS_PARAMETERS) == len(SURFACE_PARAMETERS) + sum(map(len, PROFILE_PARAMETERS.values()))
    # If heights become ten times as large, a parameter changes by a power of this factor that depends on its unit.
    power_by_unit = {"µm": 1, "1/µm": 1, "": 0, "degrees": 0, "1/µm²": 0}
    lateral_powers = {"Sal": 0, "Ssw": 0, "Sdq": 1, "Sdr": 2}
    enlarged_parameters = surface_parameters(Surface(10 * surface.heights, spacing=(500.0, 500.0)))
    original_parameters = surface_parameters(Surface(surface.heights, spacing=(500.0, 500.0)))
    for name, value in original_parameters.values.items():
        factor = 10.0 ** lateral_powers.get(name, power_by_unit[ROUGHNESS_PARAMETERS[name].unit])
        assert enlarged_parameters.values[name] == pytest.approx(factor * value, rel=1e-4, nan_ok=True), name
