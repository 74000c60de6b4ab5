"""Tests of Hurst exponents of profiles and surfaces with known exponents."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from stiction import (
    Profile,
    Surface,
    estimate_hurst_exponent,
    levelled,
    power_spectrum,
    random_phases,
    surface_spectrum,
    weierstrass_mandelbrot,
)
from support.rough_surfaces import rough_profile, self_affine_map, sinusoid

BAND_ARGUMENTS = {"longest_wavelength": 4.0, "shortest_wavelength": 0.08}
CASE_OUTSIDE_STRESS_SUITE = (False, BAND_ARGUMENTS, False)
"""Case that also runs outside the stress suite: whether the profile is periodic, the band, whether it is specified."""


class TestProfileHurstExponent:
    # A 95 % interval misses 3 of 60 cases on average. The probability of more than 8 misses is 1 in 500.
    NUM_CASES, MAX_MISSED_INTERVALS = 60, 8

    @pytest.mark.parametrize(
        ("periodic", "band", "arguments"),
        [
            case if case == CASE_OUTSIDE_STRESS_SUITE else pytest.param(*case, marks=pytest.mark.soak)
            for case in product((True, False), ({}, BAND_ARGUMENTS), (True, False))
        ],
    )
    def test_hurst_interval_of_profiles_contains_the_true_exponent(self, periodic, band, arguments):
        num_misses, errors = 0, []
        for case, hurst in enumerate(np.linspace(0.3, 0.9, self.NUM_CASES)):
            profile = rough_profile(11, repetition=case, hurst_exponent=hurst, points=4096, periodic=periodic, **band)
            limits = band.get("shortest_wavelength", 0.02), band.get("longest_wavelength", profile.extent)
            result = estimate_hurst_exponent(profile, band=limits if arguments else None, periodic=periodic)
            num_misses += not result.lower <= hurst <= result.upper
            errors.append((result.value - hurst) / ((result.upper - result.lower) / 3.92))
            assert result.lower < result.value < result.upper
        assert num_misses <= self.MAX_MISSED_INTERVALS
        # The mean of 60 standardised errors scatters by 0.13. An estimated band may include part of a roll-off.
        assert abs(np.mean(errors)) < (0.5 if arguments else 0.8)

    def test_hurst_estimate_of_an_exact_power_law_is_exact(self):
        profile = rough_profile(hurst_exponent=0.6, periodic=True, amplitudes="fixed")
        result = estimate_hurst_exponent(profile, periodic=True)
        assert result.value == pytest.approx(0.6, abs=1e-9)
        assert result.fractal_dimension_classical == pytest.approx(1.4, abs=1e-9)
        assert result.fractal_dimension_paper == pytest.approx(1.7, abs=1e-9)
        assert result.harmonics == 499
        spectrum = power_spectrum(profile, periodic=True)
        assert np.allclose(result.density(spectrum.wave_number[:-1]), spectrum.density[:-1], rtol=1e-8, atol=0)

    def test_fitted_band_extends_from_the_roll_off_to_the_cutoff_of_the_spectrum(self):
        profile = rough_profile(points=60_000, longest_wavelength=10.0, shortest_wavelength=0.1)
        result = estimate_hurst_exponent(profile)
        # Next to the cutoff, the estimate omits one bin, whose width is a fifth of the wavelength.
        assert 0.1 <= result.shortest_wavelength < 0.1 * 1.5
        assert 10.0 / 2 < result.longest_wavelength < 10.0 * 1.5
        assert result.lower < 0.8 < result.upper

    def test_fitted_band_excludes_instrument_noise(self):
        profile = rough_profile(points=8192)
        noise = rough_profile(9, points=8192, hurst_exponent=1e-9, longest_wavelength=0.021, rms=0.01)  # flat
        result = estimate_hurst_exponent(Profile(profile.heights + noise.heights, spacing=0.01))
        assert result.shortest_wavelength > 0.04
        assert result.lower < 0.8 < result.upper

    def test_fitted_band_excludes_gradually_increasing_noise(self):
        # A fit to all wavelengths would give a mean H of 0.20, and one of forty intervals would contain the true value.
        result, num_covered = [], 0
        for repetition in range(30):
            options = {"points": 4096, "repetition": repetition, "longest_wavelength": 10.0}
            noise = np.random.default_rng(repetition).normal(size=4096) * 0.01
            noisy_profile = Profile(rough_profile(hurst_exponent=0.3, **options).heights + noise, spacing=0.01)
            estimate = estimate_hurst_exponent(noisy_profile)
            result.append(estimate)
            num_covered += estimate.lower < 0.3 < estimate.upper
        assert np.median([estimate.shortest_wavelength for estimate in result]) > 0.05
        assert np.mean([estimate.value for estimate in result]) == pytest.approx(0.3, abs=0.05)
        assert num_covered >= 24  # 35 of 40 intervals contained the exponent in a trial

    def test_hurst_estimate_is_invariant_under_tilt_and_scaling_and_reversal(self):
        profile = rough_profile(points=4096)
        original_estimate = estimate_hurst_exponent(profile)
        for heights, spacing in (
            (profile.heights + 5 * profile.x - 20, 0.01),
            (profile.heights * 1e-3, 0.01),
            (profile.heights, 7.0),
        ):
            changed_estimate = estimate_hurst_exponent(Profile(heights, spacing=spacing))
            assert changed_estimate.value == pytest.approx(original_estimate.value, abs=1e-9)
            assert changed_estimate.longest_wavelength / spacing == pytest.approx(
                original_estimate.longest_wavelength / 0.01
            )
        reversed_estimate = estimate_hurst_exponent(Profile(profile.heights[::-1], spacing=0.01))
        assert reversed_estimate.value == pytest.approx(
            original_estimate.value, abs=0.2 * (original_estimate.upper - original_estimate.lower)
        )

    def test_hurst_estimate_is_fitted_in_the_given_band(self):
        result = estimate_hurst_exponent(rough_profile(), band=(0.05, 2.0))
        assert 0.05 <= result.shortest_wavelength < result.longest_wavelength <= 2.0 * (1 + 1e-9)

    def test_hurst_interval_in_a_given_band_contains_the_weierstrass_mandelbrot_exponent(self):
        for dimension in (1.2, 1.6):
            profile = weierstrass_mandelbrot(random_phases(1), dimension, points=50_000)
            result = estimate_hurst_exponent(profile, band=(0.005, 0.9))
            assert result.lower < 4 - 2 * dimension < result.upper
            assert result.dispersion > 1

    def test_fitted_band_of_weierstrass_mandelbrot_profiles_ends_where_harmonics_separate(self):
        # Below a wavelength of about 0.04 µm, the harmonics of the 40 directions are separate lines in the spectrum.
        profile = weierstrass_mandelbrot(random_phases(1), 1.4, points=150_000)
        result = estimate_hurst_exponent(profile)
        assert 0.04 < result.shortest_wavelength < 0.05
        assert result.longest_wavelength > 0.5
        assert result.lower < 1.2 < result.upper

    @pytest.mark.parametrize(
        ("invalid_arguments", "match"),
        [
            ({"band": (1.0, 0.5)}, "band"),
            ({"band": 1.0}, "band"),
            ({"band": (0.0, 0.5)}, "band"),
            ({"band": (0.5, 0.51)}, "at least 8 harmonics"),
        ],
    )
    def test_hurst_estimate_rejects_invalid_arguments(self, invalid_arguments, match):
        with pytest.raises(ValueError, match=match):
            estimate_hurst_exponent(rough_profile(), **invalid_arguments)

    def test_hurst_estimate_raises_an_error_if_there_is_no_self_affine_band(self):
        white_noise = rough_profile(hurst_exponent=1e-9, longest_wavelength=0.021)
        for profile in (white_noise, sinusoid(16), Profile([0.0, 1.0, 0.0, 0.0], spacing=1.0)):
            with pytest.raises(ValueError, match="no self-affine band"):
                estimate_hurst_exponent(profile)
        for heights, match in (
            ([1.0] * 100, "flat"),
            (np.arange(100.0), "straight line"),
            # a step of one unit in the last place, so that the profile is straight up to round-off
            (np.where(np.arange(100) < 50, 0.7, np.nextafter(0.7, 1)), "straight line"),
            ([0.0, 1e60] * 50, "height"),
        ):
            with pytest.raises(ValueError, match=match):
                estimate_hurst_exponent(Profile(heights, spacing=1.0))

    def test_hurst_estimate_rejects_a_zigzag_profile(self):
        # All power is at the Nyquist wavenumber, which is not part of the fit.
        with pytest.raises(ValueError, match="no self-affine band"):
            estimate_hurst_exponent(Profile([0.0, 1.0] * 50, spacing=1.0), periodic=True)


def test_hurst_exponent_outside_0_to_1_or_with_a_wide_interval_has_a_caution():
    estimate = estimate_hurst_exponent(rough_profile(points=4096))
    assert estimate.caution is None
    assert estimate.interval_classical == (2 - estimate.upper, 2 - estimate.lower)
    assert estimate.interval_paper[0] < estimate.fractal_dimension_paper < estimate.interval_paper[1]
    for ends, caution in (
        (
            (0.446, -0.009, 1.114),
            "the 95 % interval of H, [-0.01, 1.11], is too wide to be useful: the band is 0.5 decades wide",
        ),
        ((0.9, 0.7, 1.1), "the 95 % interval of H, [0.70, 1.10], exceeds the range 0 to 1"),
        ((1.2, 1.1, 1.3), "H above 1 indicates a smooth surface"),
    ):
        value, lower, upper = ends
        changed_estimate = replace(
            estimate, value=value, lower=lower, upper=upper, shortest_wavelength=1.0, longest_wavelength=10**0.5
        )
        assert changed_estimate.caution is not None
        assert changed_estimate.caution.startswith(caution)


class TestSurfaceHurstExponent:
    NUM_CASES, MAX_MISSED_INTERVALS = 60, 8

    @pytest.mark.parametrize(
        ("longest", "arguments"),
        [
            (20.0, False),
            *(
                pytest.param(*case, marks=pytest.mark.soak)
                for case in ((20.0, True), (math.inf, False), (math.inf, True))
            ),
        ],
    )
    def test_hurst_interval_of_surfaces_contains_the_true_exponent(self, longest, arguments):
        misses = 0
        for case, hurst in enumerate(np.linspace(0.3, 0.9, self.NUM_CASES)):
            surface = self_affine_map(case, hurst, longest=longest, whole=2)
            result = estimate_hurst_exponent(surface, band=(1.0, min(longest, 30.0)) if arguments else None)
            misses += not result.lower <= hurst <= result.upper
        assert misses <= self.MAX_MISSED_INTERVALS

    def test_hurst_estimate_of_a_surface_is_invariant_under_scaling_and_tilt(self):
        surface = self_affine_map(5, 0.7, whole=2)
        estimate = estimate_hurst_exponent(surface, band=(1.5, 15.0))
        assert estimate.dimensions == 2
        assert 1.5 <= estimate.shortest_wavelength < estimate.longest_wavelength <= 15 * (1 + 1e-9)
        tilted_heights = surface.heights * 1e-4 + 0.3 * surface.x + 0.1 * surface.y[:, np.newaxis] + 7
        tilted_estimate = estimate_hurst_exponent(Surface(tilted_heights, spacing=0.5), band=(1.5, 15.0))
        assert tilted_estimate.value == pytest.approx(estimate.value, abs=1e-9)
        radial = surface_spectrum(levelled(surface, "plane")).radial(20)
        is_in_band = (radial.wave_number > 2 * np.pi / 15) & (radial.wave_number < 2 * np.pi / 1.5)
        ratio = radial.density[is_in_band] / estimate.density(radial.wave_number[is_in_band])
        assert np.average(ratio, weights=radial.count[is_in_band]) == pytest.approx(1, abs=0.05)

    def test_hurst_estimate_rejects_a_surface_without_spectrum(self):
        for surface, message in (
            (Surface(np.ones((9, 9)), spacing=1.0), "flat surface"),
            (Surface(np.arange(90.0).reshape(9, 10), spacing=1.0), "surface must not be a plane"),
        ):
            with pytest.raises(ValueError, match=message):
                estimate_hurst_exponent(surface)
        with pytest.raises(ValueError, match="at least 8 harmonics"):
            estimate_hurst_exponent(self_affine_map(5, 0.7), band=(1.01, 1.01001))
