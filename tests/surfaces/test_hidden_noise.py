"""Tests of fitted noise floors, and of white noise under the spectra of rough surfaces."""

import math

import numpy as np
import pytest
from stiction import Profile, Surface, cut_off, instrument_limit
from stiction.surfaces.floor_fit import MIN_FLOOR_LIKELIHOOD_GAIN, BinnedSpectrum, fit_noise_floor
from stiction.surfaces.hidden_noise import find_hidden_noise
from stiction.surfaces.scale import line_spectra
from support.machined_surfaces import filtered_noise, turned_surface

SPACING = 0.1
NUM_SURFACES = 6


def mean_square_slope(body):
    return sum(float(np.square(q) @ density) * float(q[0]) / math.pi for q, density, *_ in line_spectra(body, False))


def rough_heights(seed, hurst, shape=(128, 128)):
    rng = np.random.default_rng([seed, int(100 * hurst)])
    return filtered_noise(rng, shape, hurst, longest_wavelength=60), rng


class TestNoiseFloorFit:
    log_q = np.log(np.geomspace(1.0, 8.0, 24))

    def create_spectrum(self, exponent, level, floor=1.0, weight=1e4):
        density = np.exp(3.0 - exponent * self.log_q) + level * floor
        return BinnedSpectrum(self.log_q, density, np.full(self.log_q.size, weight), floor)

    @pytest.mark.parametrize("level", [0.1, 1.0, 30.0])
    def test_fit_of_noise_floor_recovers_parameters_of_exact_spectra(self, level):
        fit = fit_noise_floor(
            [self.create_spectrum(2.2, level), self.create_spectrum(3.1, level, floor=0.5)], exponents=(1.0, 5.0)
        )
        assert fit.level == pytest.approx(level, rel=0.01)
        assert fit.exponents == pytest.approx((2.2, 3.1), rel=0.01)
        end_density = [math.exp(3.0 - exponent * self.log_q[-1]) for exponent in (2.2, 3.1)]
        assert fit.ratios == pytest.approx((level / end_density[0], 0.5 * level / end_density[1]), rel=0.02)
        assert fit.is_significant

    def test_fit_of_noise_floor_finds_level_and_exponent_of_an_exact_spectrum_to_8_digits(self):
        fit = fit_noise_floor([self.create_spectrum(2.2, 1.0)], exponents=(1.0, 5.0))
        assert fit.level == pytest.approx(1.0, rel=1e-8)
        assert fit.exponents == pytest.approx((2.2,), rel=1e-8)

    def test_noise_floor_fitted_to_a_pure_power_law_is_not_significant(self):
        fit = fit_noise_floor([self.create_spectrum(2.2, 0.0)], exponents=(1.0, 5.0))
        assert not fit.is_significant
        assert fit.gain == pytest.approx(0.0, abs=1e-3)
        assert fit.exponents == pytest.approx((2.2,), rel=1e-3)

    def test_gain_of_a_noise_floor_fit_is_the_increase_of_the_log_likelihood_due_to_the_floor(self):
        spectrum = self.create_spectrum(2.2, 1.0, weight=3.0)
        fit = fit_noise_floor([spectrum], exponents=(1.0, 5.0))

        def negative_log_likelihood(level):
            exponents = np.linspace(1.0, 5.0, 401)[:, np.newaxis]
            prefactors = np.linspace(1.0, 5.0, 401)[:, np.newaxis, np.newaxis]
            model = np.exp(prefactors - exponents * self.log_q) + level
            return 3.0 * (np.log(model) + spectrum.density / model).sum(axis=-1).min()

        assert fit.gain == pytest.approx(negative_log_likelihood(0.0) - negative_log_likelihood(1.0), rel=0.01)
        assert fit.is_significant == (fit.gain > MIN_FLOOR_LIKELIHOOD_GAIN)


@pytest.mark.parametrize("hurst", [0.3, 0.5, 0.8])
def test_hidden_noise_is_not_reported_for_surfaces_without_noise(hurst):
    surfaces = [Surface(rough_heights(seed, hurst)[0], spacing=SPACING) for seed in range(NUM_SURFACES)]
    assert [find_hidden_noise(surface) for surface in surfaces] == [None] * NUM_SURFACES
    profiles = [Profile(rough_heights(seed, hurst, (2048,))[0], spacing=SPACING) for seed in range(4 * NUM_SURFACES)]
    # The spectrum of a single line has much scatter.
    assert sum(find_hidden_noise(profile) is not None for profile in profiles) <= 2


@pytest.mark.parametrize(("hurst", "noise_rms"), [(0.6, 0.15), (0.7, 0.1), (0.8, 0.08)])
def test_hidden_white_noise_is_estimated_even_if_the_spectrum_is_not_flat_at_short_wavelengths(hurst, noise_rms):
    for seed in range(NUM_SURFACES):
        heights, rng = rough_heights(seed, hurst)
        clean_surface, noisy_surface = (
            Surface(z, spacing=SPACING) for z in (heights, heights + noise_rms * rng.normal(size=heights.shape))
        )
        assert instrument_limit(noisy_surface).reason == "pixels"
        noise = find_hidden_noise(noisy_surface)
        mean_square_slopes = [
            mean_square_slope(body) for body in (clean_surface, noisy_surface, cut_off(noisy_surface, noise.cut_off))
        ]
        assert mean_square_slopes[1] > 1.25 * mean_square_slopes[0]
        assert noise.slope_fraction == pytest.approx(1 - mean_square_slopes[0] / mean_square_slopes[1], abs=0.09)
        assert math.sqrt(mean_square_slopes[2] / mean_square_slopes[0]) == pytest.approx(1.0, abs=0.13)


def test_estimated_noise_fraction_of_the_slope_is_correct_if_spacings_along_x_and_y_differ():
    heights, rng = rough_heights(1, 0.5, (128, 256))
    noisy_heights = heights + 0.1 * rng.normal(size=heights.shape)
    noise_on_square_grid, noise_on_stretched_grid = (
        find_hidden_noise(Surface(noisy_heights, spacing=spacing)) for spacing in (0.1, (0.1, 0.1001))
    )
    assert noise_on_stretched_grid.slope_fraction == pytest.approx(noise_on_square_grid.slope_fraction, rel=0.01)
    total_mean_square_slope = mean_square_slope(Surface(noisy_heights, spacing=(0.2, 0.1)))
    fraction = 1 - mean_square_slope(Surface(heights, spacing=(0.2, 0.1))) / total_mean_square_slope
    assert find_hidden_noise(Surface(noisy_heights, spacing=(0.2, 0.1))).slope_fraction == pytest.approx(
        fraction, abs=0.08
    )


def test_undersampled_surface_is_reported_as_possibly_noisy():
    fine_heights = filtered_noise(np.random.default_rng(1), (512, 512), 0.5, longest_wavelength=240)
    assert find_hidden_noise(Surface(fine_heights[::4, ::4], spacing=SPACING)).slope_fraction > 0.2


def test_hidden_noise_is_not_estimated_for_lathe_turned_profiles_with_feed_marks():
    heights = turned_surface(np.random.default_rng(1), 1, feed=(25, 25))
    noisy_heights = heights + 0.003 * heights.std() * np.random.default_rng(2).normal(size=heights.size)
    assert find_hidden_noise(Profile(noisy_heights, spacing=SPACING)) is None


def test_hidden_noise_is_not_reported_for_straight_grooves_with_aliased_edges():
    surfaces = [
        Surface(turned_surface(np.random.default_rng(seed), 2, rough=texture_roughness), spacing=SPACING)
        for seed in range(8)
        for texture_roughness in (0.05, 0.3)
    ]
    assert [find_hidden_noise(surface) for surface in surfaces] == [None] * len(surfaces)


@pytest.mark.parametrize("shape", [(2, 2), (3, 5), (9, 12)])
def test_hidden_noise_is_not_estimated_for_small_surfaces(shape):
    assert find_hidden_noise(Surface(np.random.default_rng(1).normal(size=shape), spacing=SPACING)) is None


def test_hidden_noise_is_not_reported_for_clean_straight_grooves():
    line_heights = filtered_noise(np.random.default_rng(3), (256,), 0.8, longest_wavelength=60)
    assert find_hidden_noise(Surface(np.tile(line_heights, (64, 1)), spacing=SPACING)) is None
