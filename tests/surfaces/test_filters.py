"""Tests of S- and L-filters (ISO 16610): direct least squares, transmission of sinusoids, and limits."""

import math

import numpy as np
import pytest
from reference.gaussian_filters import mean_line, mean_surface, robust_mean_line
from stiction import Profile, Surface, cut_off, filtered
from support.rough_surfaces import rough_profile, self_affine_map

ROUND_OFF = 1e-12

SAMPLING_TOLERANCE = 1e-6
"""Error relative to the total height for cutoffs of nine points or more. It is the difference of sampled Gaussian
weights and a truncated transform."""


def total_height(body):
    return float(np.ptp(body.heights))


class TestGaussianFilter:
    @pytest.mark.parametrize("cutoff", [0.15, 0.6, 2.0])
    def test_s_filter_equals_weighted_least_squares_at_each_point(self, cutoff):
        profile = rough_profile(points=200)  # the profile is 2 µm long
        expected = mean_line(profile.heights, profile.spacing, cutoff)
        result = filtered(profile, cutoff=cutoff).heights
        assert np.abs(result - expected).max() < SAMPLING_TOLERANCE * total_height(profile)

    def test_l_filtered_heights_are_deviations_from_s_filtered_heights(self):
        for body in (rough_profile(points=300), self_affine_map(1, 0.7, (40, 60), spacing=(0.5, 0.25))):
            cutoff = 40 * min(body.spacings)
            parts = [filtered(body, cutoff=cutoff, kind=kind) for kind in ("S", "L")]
            assert np.abs(parts[0].heights + parts[1].heights - body.heights).max() < ROUND_OFF * total_height(body)
            assert [part.history[-1][:8] for part in parts] == ["S-filter", "L-filter"]

    @pytest.mark.parametrize("ratio", [0.25, 0.5, 1.0, 2.0, 4.0])
    def test_filtered_sinusoid_has_the_transmission_stated_in_the_standard(self, ratio):
        # The transmission of the mean line is exp(-π (α λc/λ)²) with α = sqrt(ln 2/π).
        # The transmission of the roughness profile is 1 minus that of the mean line.
        wavelength, cutoff = 0.4, 0.4 * ratio
        wave = Profile(np.sin(2 * np.pi * np.arange(800) / 80), spacing=wavelength / 80)
        gaussian_transmission = math.exp(-math.pi * (math.sqrt(math.log(2) / math.pi) * ratio) ** 2)
        middle_range = slice(360, 440)  # the middle is at least a wavelength away from the ends, beyond all weights
        for kind, factor in (("S", gaussian_transmission), ("L", 1 - gaussian_transmission)):
            result = filtered(wave, cutoff=cutoff, kind=kind).heights[middle_range]
            assert np.abs(result - factor * wave.heights[middle_range]).max() < 1e-9

    def test_l_filter_removes_straight_lines_and_planes_up_to_the_edges(self):
        x = 0.1 * np.arange(60)
        for body in (Profile(3 + 2 * x, spacing=0.1), Surface(3 + 2 * x + x[:, np.newaxis], spacing=0.1)):
            assert np.abs(filtered(body, cutoff=5.0, kind="L").heights).max() < ROUND_OFF * 100

    def test_low_pass_filter_equals_the_s_filter(self):
        for body in (rough_profile(points=300), self_affine_map(1, 0.7, (40, 60), spacing=(0.5, 0.25))):
            cutoff = 9 * min(body.spacings)
            assert np.array_equal(cut_off(body, cutoff).heights, filtered(body, cutoff=cutoff).heights)


class TestMissingPoints:
    def test_filtered_profile_equals_reference_with_zero_weights_at_missing_points(self):
        profile, is_missing = rough_profile(points=200), np.zeros(200, bool)
        is_missing[[0, 1, 50, 51, 52, 53, 120]] = True
        expected = mean_line(profile.heights, profile.spacing, 0.3, weights=(~is_missing).astype(float))
        results = [
            filtered(Profile(heights, spacing=profile.spacing, missing=is_missing), cutoff=0.3).heights
            for heights in (profile.heights, np.where(is_missing, 1e3, profile.heights))
        ]
        for result in results:
            assert np.abs(result - expected)[~is_missing].max() < SAMPLING_TOLERANCE * total_height(profile)

    def test_filtered_surface_equals_reference_with_zero_weights_at_missing_points(self):
        surface, is_missing = self_affine_map(1, 0.7, (24, 30), spacing=(0.5, 0.25)), np.zeros((24, 30), bool)
        is_missing[3:9, 10:14], is_missing[20:, :4] = True, True
        expected = mean_surface(
            surface.heights, surface.spacing, 6.0, [(0, 0), (0, 1), (1, 0), (1, 1)], (~is_missing).astype(float)
        )
        result = filtered(Surface(surface.heights, spacing=surface.spacing, missing=is_missing), cutoff=6.0).heights
        assert np.abs(result - expected)[~is_missing].max() < SAMPLING_TOLERANCE * total_height(surface)

    def test_filter_preserves_heights_at_missing_points_far_from_measured_points(self):
        is_missing = np.zeros(400, bool)
        is_missing[100:300] = True
        profile = Profile(np.linspace(0, 1, 400) ** 2, spacing=1.0, missing=is_missing)
        result = filtered(profile, cutoff=9.0).heights
        assert result[200] == pytest.approx(profile.heights[200], rel=1e-9)
        periodically_filtered = filtered(profile, cutoff=9.0, periodic=True).heights
        assert periodically_filtered[200] == pytest.approx(profile.heights[200], rel=1e-9)


class TestRobustFilter:
    def test_robust_profile_filter_equals_iterated_least_squares(self):
        profile = rough_profile(points=120)
        heights = profile.heights.copy()
        heights[[30, 31, 80]] -= 3 * total_height(profile)
        scratched_profile = Profile(heights, spacing=profile.spacing)
        expected = robust_mean_line(heights, profile.spacing, 0.3)
        result = filtered(scratched_profile, cutoff=0.3, robust=True).heights
        assert np.abs(result - expected).max() < 1e-3 * total_height(profile)

    def test_robust_surface_filter_recovers_a_paraboloid_despite_noise_and_scratches(self):
        y, x = 0.1 * np.arange(40)[:, np.newaxis], 0.1 * np.arange(50)
        form = 0.3 * x**2 - 0.2 * y**2 + 0.1 * x * y
        scratched_heights = form + 1e-3 * np.random.default_rng(1).normal(size=form.shape)
        scratched_heights[:, 20:22] -= 1.0
        result = filtered(Surface(scratched_heights, spacing=0.1), cutoff=2.0, robust=True).heights
        linear = filtered(Surface(scratched_heights, spacing=0.1), cutoff=2.0).heights
        # The error limit is three standard deviations of the noise. The largest errors occur in corners of the map.
        assert np.abs(result - form).max() < 3e-3
        assert np.abs(linear - form).max() > 0.05

    def test_robust_filter_of_normally_distributed_heights_agrees_with_a_local_quadratic_fit(self):
        surface = self_affine_map(1, 0.7, (16, 20), spacing=(0.5, 0.25))
        terms = [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (2, 0)]
        result = filtered(surface, cutoff=4.0, robust=True).heights
        weights = np.ones(surface.heights.shape)
        for _ in range(40):
            expected = mean_surface(surface.heights, surface.spacing, 4.0, terms, weights)
            residual = np.abs(surface.heights - expected)
            weights = np.maximum(1 - (residual / (4.4478 * np.median(residual))) ** 2, 0) ** 2
        assert np.abs(result - expected).max() < 1e-3 * total_height(surface)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"cutoff": 0.004}, r"cutoff must be between 0.005 µm \(half the spacing\) and 3 µm \(the shortest side\)"),
        ({"cutoff": 3.1}, "cutoff must be between 0.005 µm"),
        ({"cutoff": 1.0, "kind": "R"}, "kind must be one of 'S', 'L'"),
        ({"cutoff": 1.0, "robust": True, "periodic": True}, "periodic must be False for a robust filter"),
    ],
)
def test_filter_rejects_invalid_arguments(options, message):
    with pytest.raises(ValueError, match=message):
        filtered(rough_profile(points=300), **options)


def test_filter_accepts_a_cutoff_as_long_as_the_profile():
    assert filtered(rough_profile(points=300), cutoff=3.0, kind="L").heights.size == 300


@pytest.mark.parametrize("points", [0.5, 1.0, 2.0, 3.9])
@pytest.mark.parametrize("has_missing", [False, True])
def test_filter_with_a_short_cutoff_does_not_amplify_noise_at_edges_and_missing_points(points, has_missing):
    heights = np.random.default_rng(1).normal(size=(48, 40))
    is_missing = np.zeros(heights.shape, dtype=bool)
    is_missing[20:26, 10:13] = is_missing[:3, 5] = has_missing
    surface = Surface(np.where(is_missing, 0.0, heights), spacing=0.1, missing=is_missing if has_missing else None)
    smoothed_heights = filtered(surface, cutoff=0.1 * points).heights
    assert np.abs(smoothed_heights[~is_missing]).max() < 1.05 * np.abs(heights).max()
    assert np.square(smoothed_heights[~is_missing]).mean() < np.square(heights).mean()
    tilted_plane = Surface(np.add.outer(0.3 * np.arange(48), np.arange(40)), spacing=0.1)
    np.testing.assert_allclose(filtered(tilted_plane, cutoff=0.1 * points).heights, tilted_plane.heights, atol=1e-9)
