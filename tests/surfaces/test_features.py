"""Tests of feature parameters of surfaces, such as the peak density, the mean peak curvature and S10z.

Peaks, pits and Wolf pruning are compared with a slow program that merges hills, and with egg-box surfaces.
"""

import math

import numpy as np
import pytest
from reference import roughness as reference_roughness
from stiction import Surface, surface_parameters
from stiction.surfaces.features import feature_parameters, find_significant_peaks
from support.rough_surfaces import self_affine_map


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("pruning", [0.0, 0.05, 0.2])
def test_significant_peaks_equal_peaks_found_by_a_slow_implementation_of_wolf_pruning(seed, pruning):
    heights = self_affine_map(seed, 0.6, (22, 27)).heights
    for sign in (1, -1):
        threshold = pruning * float(np.ptp(heights))
        expected = reference_roughness.wolf_pruned_peaks(sign * heights, threshold)
        result = {divmod(int(index), 27) for index in find_significant_peaks(sign * heights, threshold)}
        assert result == expected


@pytest.mark.parametrize("seed", range(3))
def test_feature_parameters_equal_their_definitions(seed):
    surface = self_affine_map(seed, 0.6, (24, 30), spacing=(0.5, 0.25))
    z = surface.heights - surface.heights.mean()
    result, expected = surface_parameters(surface), reference_roughness.feature_parameters(z, surface.spacing)
    for name, value in expected.items():
        assert getattr(result, name) == pytest.approx(value, rel=1e-9), name


def test_feature_parameters_of_an_egg_box_equal_closed_forms():
    # Each square of one wavelength contains one peak of height A and curvature A k²/2.
    points, amplitude, spacing = 40, 0.3, 0.05
    x = 2 * np.pi * (np.arange(5 * points) + points / 2 + 0.25) / points
    surface = Surface(amplitude / 2 * (np.cos(x)[:, np.newaxis] + np.cos(x)), spacing=spacing)
    result = surface_parameters(surface)
    wave_number = 2 * math.pi / (points * spacing)
    assert result.Spd == pytest.approx(25 / (5 * points * spacing) ** 2)
    assert result.Spc == pytest.approx(amplitude * wave_number**2 / 2, rel=5e-3)
    assert (result.S5p, result.S5v) == pytest.approx((amplitude, amplitude), rel=2e-3)
    assert result.S10z == pytest.approx(2 * amplitude, rel=2e-3)
    assert result.Ssw == pytest.approx(points * spacing)


def test_feature_parameters_count_a_plateau_as_one_peak():
    heights = np.zeros((12, 12))
    heights[2:5, 2:5], heights[7:10, 7:9] = 1.0, 2.0
    assert find_significant_peaks(heights, 0.1).size == 2
    assert find_significant_peaks(heights, 1.5).size == 1


def test_five_point_heights_are_nan_if_there_are_fewer_than_five_peaks():
    y, x = np.arange(20.0)[:, np.newaxis], np.arange(30.0)
    result = feature_parameters(-((x - 15) ** 2) - (y - 10) ** 2, (1.0, 1.0))
    assert math.isnan(result.peak_height)
    assert math.isnan(result.pit_depth)  # The surface has only four pits, its corners.
    assert result.density == pytest.approx(1 / 600)


def test_dominant_wavelength_equals_the_wavelength_of_the_largest_fourier_coefficient():
    surface = self_affine_map(3, 0.6, (18, 24), spacing=(0.5, 0.25))
    z = surface.heights - surface.heights.mean()
    assert surface_parameters(surface).Ssw == pytest.approx(
        reference_roughness.dominant_wavelength(z, surface.spacing), rel=1e-9
    )
