"""Tests of Z2, the joint roughness coefficient and the mean rising slope of faces."""

import math

import numpy as np
import pytest
from stiction import Profile, Surface, self_affine_surface
from stiction.surfaces.joint_roughness import measure_joint_roughness


def create_sawtooth(rise, fall, points=2000, spacing=127.0):
    """Return a profile with long teeth, which rise with one slope and fall with another."""
    period = 200
    top = round(period * fall / (rise + fall))
    x = np.arange(points) % period
    return Profile(spacing * np.where(x < top, rise * x, rise * top - fall * (x - top)), spacing=spacing)


def test_z2_and_jrc_of_a_ramp_follow_from_its_slope():
    ramp = Profile(0.2 * 127 * np.arange(1000.0), spacing=127.0)
    roughness = measure_joint_roughness(ramp, 0)
    assert roughness.sampling_interval == pytest.approx(1270)
    assert roughness.z2 == pytest.approx(0.2)
    assert roughness.jrc == pytest.approx(32.2 + 32.47 * math.log10(0.2))


def test_rising_slope_but_not_z2_depends_on_the_sense_of_the_motion():
    tooth = create_sawtooth(0.1, 0.3)
    forward_roughness, backward_roughness = (measure_joint_roughness(tooth, angle) for angle in (0, 180))
    assert forward_roughness.rising_slope == pytest.approx(0.1, rel=0.06)
    assert backward_roughness.rising_slope == pytest.approx(0.3, rel=0.15)  # less exact: some differences span a tip
    assert forward_roughness.rising_slope == backward_roughness.falling_slope
    assert forward_roughness.z2 == backward_roughness.z2


@pytest.mark.parametrize("slope", [0.05, 0.6])
def test_jrc_is_undefined_for_slopes_outside_the_range_of_its_correlation(slope):
    assert math.isnan(measure_joint_roughness(Profile(slope * 127 * np.arange(100.0), spacing=127.0), 0).jrc)


def test_jrc_is_undefined_if_the_grid_is_too_coarse():
    roughness = measure_joint_roughness(Profile(0.2 * 2000 * np.arange(100.0), spacing=2000.0), 0)
    assert roughness.sampling_interval == 2000
    assert math.isnan(roughness.jrc)


def test_z2_of_a_map_is_computed_along_any_direction_without_missing_points():
    y, x = np.mgrid[:80, :80] * 127.0
    plane = Surface(0.2 * x + 0.1 * y, spacing=127.0)
    for angle, slope in ((0, 0.2), (90, 0.1), (270, -0.1), (45, 0.3 / math.sqrt(2))):
        roughness = measure_joint_roughness(plane, angle)
        assert roughness.z2 == pytest.approx(abs(slope))
        assert (roughness.falling_slope if slope < 0 else roughness.rising_slope) == pytest.approx(abs(slope))
        assert roughness.sampling_interval == pytest.approx(1270, rel=0.05)
    is_missing = np.zeros((80, 80), bool)
    is_missing[:, 40:] = True
    surface_with_missing_points = Surface(np.where(is_missing, 1e5, plane.heights), spacing=127.0, missing=is_missing)
    assert measure_joint_roughness(surface_with_missing_points, 0).z2 == pytest.approx(0.2)


@pytest.mark.parametrize(("angle", "slope"), [(45, 0.3), (135, -0.1), (225, -0.3), (0, 0.2 * math.sqrt(2))])
def test_sampling_interval_is_reduced_to_the_size_of_a_small_map(angle, slope):
    y, x = np.mgrid[:40, :80] * 10.0
    roughness = measure_joint_roughness(Surface(0.2 * x + 0.1 * y, spacing=10.0), angle)
    assert roughness.z2 == pytest.approx(abs(slope) / math.sqrt(2))
    assert roughness.sampling_interval == pytest.approx(790 if angle == 0 else 390 * math.sqrt(2))


def test_isotropic_map_has_similar_roughness_along_all_directions():
    rough_map = self_affine_surface(
        1, hurst_exponent=0.8, rms=700.0, shape=(256, 256), spacing=400.0, longest_wavelength=30_000.0
    )
    values = [measure_joint_roughness(rough_map, angle).z2 for angle in (0, 30, 90)]
    assert max(values) < 1.25 * min(values)
