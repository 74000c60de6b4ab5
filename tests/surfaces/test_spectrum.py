"""Tests of spectra and moments against their definitions and known surfaces."""

import math

import numpy as np
import pytest
from stiction import (
    Profile,
    Surface,
    estimate_hurst_exponent,
    levelled,
    power_spectrum,
    random_phases,
    rotated,
    roughness_parameters,
    spectral_moments,
    surface_spectrum,
    weierstrass_mandelbrot,
    weierstrass_mandelbrot_moments,
)
from support.rough_surfaces import AMPLITUDE, WAVELENGTH, rough_profile, self_affine_map, sinusoid

ROUND_OFF = 1e-12
AREAL_ROUND_OFF = 1e-11
# Error of the direction in degrees, for maps about ten wavelengths long and stretched by two.
# The error is below 3 degrees in 90 % of the cases.
LAY_ANGLE_TOLERANCE = 10.0


class TestPowerSpectrum:
    def test_spectrum_of_a_sinusoid_is_a_single_line(self):
        profile = sinusoid(16)
        spectrum = power_spectrum(profile, periodic=True)
        peak_index = int(np.argmax(spectrum.density))
        assert spectrum.wave_number[peak_index] == pytest.approx(2 * np.pi / WAVELENGTH, rel=ROUND_OFF)
        assert spectrum.density[peak_index] == pytest.approx(AMPLITUDE**2 * profile.extent / 4, rel=ROUND_OFF)
        assert np.delete(spectrum.density, peak_index).max() < ROUND_OFF * spectrum.density[peak_index]

    @pytest.mark.parametrize("points", [1000, 1001])
    def test_integral_of_the_spectrum_equals_the_mean_square_height(self, points):
        profile = rough_profile(points=points)
        spectrum = power_spectrum(profile, periodic=True)
        mean_square = roughness_parameters(profile).Pq ** 2
        assert spectrum.moment(0) == pytest.approx(mean_square, rel=ROUND_OFF)
        for per_decade in (1, 7, 10):
            binned = spectrum.in_bins(per_decade)
            assert binned.moment(0) == pytest.approx(mean_square, rel=ROUND_OFF)
            assert binned.count.sum() == (points - 1) / 2
            assert (np.diff(binned.wave_number) > 0).all()

    def test_power_spectrum_equals_its_definition(self):
        profile = rough_profile(points=64)
        window = np.sqrt(8 / 3) * np.sin(np.pi * np.arange(64) / 64) ** 2
        for periodic in (True, False):
            heights = (profile.heights - profile.heights.mean()) * (1.0 if periodic else window)
            spectrum = power_spectrum(profile, periodic=periodic)
            for q, density in zip(spectrum.wave_number, spectrum.density, strict=True):
                transform = profile.spacing * (heights * np.exp(-1j * q * profile.x)).sum()
                assert density == pytest.approx(abs(transform) ** 2 / profile.extent, rel=1e-9)

    def test_window_preserves_the_spectral_level_and_removes_leakage(self):
        profiles = [rough_profile(repetition=r, points=4096, longest_wavelength=4.0) for r in range(40)]
        density_with_window, density_without_window = (
            np.mean([power_spectrum(p, periodic=periodic).density for p in profiles], axis=0)
            for periodic in (False, True)
        )
        q = power_spectrum(profiles[0]).wave_number
        expected = np.maximum(q * 4.0 / (2 * np.pi), 1.0) ** -2.6
        # The spectrum has a variance of 0.1² over the harmonics of the period, which has 16384 points.
        density_on_fine_grid = np.maximum(np.arange(1, 8192) * 4.0 / 163.84, 1.0) ** -2.6
        expected *= 0.1**2 * np.pi / (density_on_fine_grid.sum() * 2 * np.pi / 163.84)
        # The spectrum of a thousand harmonics and 40 profiles scatters by 1 %, and leakage is at most 1.2 %.
        is_high_frequency = q > 100
        assert np.mean(density_with_window[is_high_frequency] / expected[is_high_frequency]) == pytest.approx(
            1, abs=0.02
        )
        assert np.mean(density_without_window[is_high_frequency] / expected[is_high_frequency]) > 1.3

    @pytest.mark.parametrize("invalid_arguments", [{"periodic": "yes"}, {"periodic": None}])
    def test_power_spectrum_rejects_invalid_arguments(self, invalid_arguments):
        for function in (power_spectrum, estimate_hurst_exponent, spectral_moments):
            with pytest.raises(ValueError, match="periodic"):
                function(rough_profile(), **invalid_arguments)
        with pytest.raises(ValueError, match="per_decade"):
            power_spectrum(rough_profile()).in_bins(0)


class TestSpectralMoments:
    def test_spectral_moments_of_a_sinusoid_equal_closed_forms(self):
        result = spectral_moments(sinusoid(16), periodic=True)
        q = 2 * np.pi / WAVELENGTH
        for order, value in enumerate((result.height, result.slope, result.curvature)):
            # Round-off at the highest of 64 harmonics is amplified by 8^(2j).
            assert value == pytest.approx(AMPLITUDE**2 / 2 * q ** (2 * order), rel=1e-10)
        assert result.nayak_parameter == pytest.approx(1, rel=1e-10)

    def test_spectral_moments_of_adjacent_bands_add_up(self):
        profile = rough_profile()
        all_moments = spectral_moments(profile)
        # The profile has no wavelength of exactly 0.35 µm, so no harmonic is counted twice.
        band_moments = (
            spectral_moments(profile, shortest_wavelength=0.35),
            spectral_moments(profile, longest_wavelength=0.35),
        )
        for name in ("height", "slope", "curvature"):
            assert sum(getattr(part, name) for part in band_moments) == pytest.approx(
                getattr(all_moments, name), rel=ROUND_OFF
            )

    def test_spectral_moments_reject_invalid_arguments(self):
        with pytest.raises(ValueError, match="longest_wavelength must be above"):
            spectral_moments(rough_profile(), shortest_wavelength=2.0, longest_wavelength=1.0)
        with pytest.raises(ValueError, match="must contain a wavelength of the profile"):
            spectral_moments(rough_profile(), shortest_wavelength=20.0)
        with pytest.raises(ValueError, match="flat"):
            spectral_moments(Profile([1.0] * 10, spacing=1.0))


def test_areal_spectrum_equals_its_definition():
    surface = self_affine_map(1, 0.7, (8, 9), spacing=(0.5, 0.25))
    window = [np.sqrt(8 / 3) * np.sin(np.pi * np.arange(n) / n) ** 2 for n in (8, 9)]
    for periodic in (True, False):
        heights = surface.heights - surface.heights.mean()
        if not periodic:
            heights = heights * window[0][:, np.newaxis] * window[1]
        spectrum = surface_spectrum(surface, periodic=periodic)
        for j, q_y in enumerate(spectrum.wave_number_y):
            for i, q_x in enumerate(spectrum.wave_number_x):
                wave = np.exp(-1j * (q_y * surface.y[:, np.newaxis] + q_x * surface.x))
                expected = 0 if q_x == q_y == 0 else abs((heights * wave).sum()) ** 2 * 0.125 / 72
                assert spectrum.density[j, i] == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_spectral_moments_of_a_surface_along_a_direction_equal_moments_of_its_profiles():
    surface = self_affine_map(2, 0.7)
    spectrum = surface_spectrum(surface, periodic=True)
    assert spectrum.moments(37).height == pytest.approx(surface.heights.var(), rel=AREAL_ROUND_OFF)
    # Moments of the surface along x are mean moments of the rows. Variations of the row mean have no slope along x.
    rows = [spectral_moments(surface.row(index), periodic=True) for index in range(128)]
    assert spectrum.moments(0).slope == pytest.approx(np.mean([row.slope for row in rows]), rel=1e-9)
    assert spectrum.moments(0).curvature == pytest.approx(np.mean([row.curvature for row in rows]), rel=1e-9)
    columns = [spectral_moments(surface.column(index), periodic=True) for index in range(160)]
    assert spectrum.moments(90).slope == pytest.approx(np.mean([column.slope for column in columns]), rel=1e-9)
    # In other directions, m2 is a quadratic form of the direction.
    slope_along, slope_across = spectrum.moments(20).slope, spectrum.moments(110).slope
    assert slope_along + slope_across == pytest.approx(
        spectrum.moments(0).slope + spectrum.moments(90).slope, rel=AREAL_ROUND_OFF
    )
    wave = np.cos(0.25 * np.pi * (surface.x / 0.5) + 0.5 * np.pi * (surface.y[:, np.newaxis] / 0.5))
    result = surface_spectrum(Surface(wave, spacing=0.5), periodic=True).moments(math.degrees(math.atan2(2, 1)))
    assert result.slope == pytest.approx(0.5 * (np.pi / 2) ** 2 * 5, rel=1e-9)
    assert result.nayak_parameter == pytest.approx(1, rel=1e-9)


def test_steepest_direction_of_a_surface_is_perpendicular_to_its_lay():
    phase = np.arange(128)[:, np.newaxis] * 0.2 * np.pi * 5 / 32 + np.arange(128) * 0.2 * np.pi * 10 / 32
    spectrum = surface_spectrum(Surface(np.cos(phase), spacing=1.0))
    assert spectrum.steepest_direction() == pytest.approx(math.degrees(math.atan2(1, 2)), abs=0.5)
    for angle in (10.0, 70.0, 130.0):
        for seed in range(4):
            surface = self_affine_map(seed, 0.7, (160, 160), whole=2, longest=20.0, stretch=2.0)
            rotated_spectrum = surface_spectrum(levelled(rotated(surface, angle), "plane"))
            angle_error = (rotated_spectrum.steepest_direction() - angle + 90) % 180 - 90
            assert abs(angle_error) < LAY_ANGLE_TOLERANCE


def test_radial_spectrum_includes_every_coefficient_exactly_once():
    surface = self_affine_map(3, 0.6, (64, 81), spacing=(0.5, 0.3))
    spectrum = surface_spectrum(surface, periodic=True)
    q, angle, density = spectrum.waves()
    assert (np.diff(q) >= 0).all()
    assert angle.min() >= 0
    assert angle.max() < 180
    # Each ring of the spectrum contains both a Fourier coefficient and its complex conjugate.
    area = (2 * np.pi / 32) * (2 * np.pi / 24.3)
    is_inside = np.hypot(spectrum.wave_number_y[:, np.newaxis], spectrum.wave_number_x) < np.pi / 0.5 * (1 - 1e-9)
    assert 2 * density.sum() * area == pytest.approx(spectrum.density[is_inside].sum() * area, rel=AREAL_ROUND_OFF)
    radial = spectrum.radial(7)
    assert radial.count.sum() == q.size
    assert (radial.density * radial.count).sum() == pytest.approx(density.sum(), rel=AREAL_ROUND_OFF)


def test_radial_spectrum_agrees_with_the_surfacetopography_library():
    topography = pytest.importorskip("SurfaceTopography")
    surface = self_affine_map(4, 0.8, (96, 128))
    topography_surface = topography.Topography(surface.heights.T - surface.heights.mean(), (64.0, 48.0), periodic=True)
    q, density = topography_surface.power_spectrum_from_area(nb_points_per_decade=5)
    is_compared = np.isfinite(density) & (q > 0.5) & (q < 5)
    spectrum = surface_spectrum(surface, periodic=True)
    wave_numbers, _, densities = spectrum.waves()
    edges = np.sqrt(q[1:] * q[:-1])
    for index in np.flatnonzero(is_compared)[1:-1]:
        is_in_ring = (wave_numbers > edges[index - 1]) & (wave_numbers < edges[index])
        # SurfaceTopography uses other ring edges. The density falls by half within a tenth of a decade.
        assert density[index] == pytest.approx(densities[is_in_ring].mean(), rel=0.35)


def test_mean_spectral_moments_of_weierstrass_mandelbrot_profiles_equal_exact_moments():
    # The mean of 20 profiles with a hundred independent wavelengths scatters by a few per cent.
    options = {"convention": "classical"}
    exact_moments = weierstrass_mandelbrot_moments(1.2, shortest_wavelength=0.02, **options)
    result = [
        spectral_moments(
            weierstrass_mandelbrot(
                random_phases(4, repetition=r), 1.2, points=8000, band_limit="nyquist", extent=80.0, **options
            )
        )
        for r in range(20)
    ]
    for name in ("slope", "curvature"):
        assert np.mean([getattr(m, name) for m in result]) == pytest.approx(getattr(exact_moments, name), rel=0.05)
