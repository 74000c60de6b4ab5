"""Tests of scale-dependent slope and curvature against sums, closed forms and simulated instruments."""

import math
from dataclasses import replace

import numpy as np
import pytest
from stiction import (
    Profile,
    Surface,
    cut_off,
    estimate_hurst_exponent,
    instrument_limit,
    read_profile,
    read_surface,
    scale_dependent_roughness,
    self_affine,
    self_affine_surface,
    spectral_moments,
    surface_spectrum,
)
from stiction.surfaces.preparation import levelled
from stiction.surfaces.scale import fitted_and_limiting_power_laws, line_spectra
from support.machined_surfaces import MACHINED_SURFACES, filtered_noise, scale_to_unit_rms, turned_surface
from support.rough_surfaces import rough_profile, self_affine_map, sinusoid

ROUND_OFF = 1e-9
BIN_TOLERANCE = 0.03  # relative error of a slope that is interpolated between two of 48 bins per decade of wavelength


def test_scale_dependent_roughness_tends_to_the_spectral_moments():
    profile = rough_profile()
    moments = spectral_moments(profile, periodic=True)
    result = scale_dependent_roughness(profile, periodic=True)
    assert result.gradient[-1] ** 2 == pytest.approx(moments.slope, rel=ROUND_OFF)
    assert result.curvature[-1] ** 2 == pytest.approx(moments.curvature, rel=ROUND_OFF)
    surface = self_affine_map(1, 0.7, (64, 81), spacing=(0.5, 0.3))
    spectrum = surface_spectrum(surface, periodic=True)
    result = scale_dependent_roughness(surface, periodic=True)
    mean_square_gradient = spectrum.moments(0).slope + spectrum.moments(90).slope
    assert result.gradient[-1] ** 2 == pytest.approx(mean_square_gradient, rel=ROUND_OFF)
    q_y, q_x = np.meshgrid(spectrum.wave_number_y, spectrum.wave_number_x, indexing="ij")
    step = (2 * np.pi / 32) * (2 * np.pi / 24.3) / (4 * np.pi**2)
    laplacian = ((q_x**2 + q_y**2) ** 2 * spectrum.density).sum() * step
    assert result.curvature[-1] ** 2 == pytest.approx(laplacian / 4, rel=ROUND_OFF)


def test_scale_dependent_roughness_is_the_sum_of_the_spectrum_above_a_wavelength():
    x = np.arange(1000) * 0.1
    long_wave, short_wave = 0.3 * np.sin(2 * np.pi * x / 10), 0.02 * np.sin(2 * np.pi * x / 0.5)
    result = scale_dependent_roughness(Profile(long_wave + short_wave, spacing=0.1), periodic=True)
    slopes = [0.3 * 2 * np.pi / 10 / math.sqrt(2), 0.02 * 2 * np.pi / 0.5 / math.sqrt(2)]
    assert result.gradient_at([20.0, 5.0, 0.3]) == pytest.approx([0, slopes[0], math.hypot(*slopes)], rel=1e-6)
    assert float(result.fraction_below(5.0)) == pytest.approx(slopes[1] ** 2 / (slopes[0] ** 2 + slopes[1] ** 2))
    curvature = [slope * 2 * np.pi / length for slope, length in zip(slopes, (10, 0.5), strict=True)]
    assert float(result.curvature_at(0.3)) == pytest.approx(math.hypot(*curvature), rel=1e-6)
    assert result.gradient_at(1000.0) == 0


@pytest.mark.parametrize("hurst", [0.4, 0.8])
def test_scale_dependent_roughness_of_a_power_law_equals_closed_form(hurst):
    longest = 40.0
    profile = self_affine(
        1, hurst_exponent=hurst, rms=0.1, points=2**15, spacing=0.01, longest_wavelength=longest, periodic=True,
        amplitudes="fixed",
    )  # fmt: skip
    result = scale_dependent_roughness(profile, periodic=True)
    power = 2 - 2 * hurst
    for length in (0.05, 0.2, 1.0):
        ratio = (1 / length**power - 1 / longest**power) / (1 / 0.02**power - 1 / longest**power)
        assert float(result.gradient_at(length)) / result.gradient[-1] == pytest.approx(
            math.sqrt(ratio), rel=BIN_TOLERANCE
        )


def test_scale_dependent_roughness_is_independent_of_tilt_and_units():
    profile = self_affine(
        4, hurst_exponent=0.7, rms=0.1, points=8192, spacing=0.01, longest_wavelength=2.0, shortest_wavelength=0.2
    )
    result = scale_dependent_roughness(profile)
    rms_slope = math.sqrt(np.mean(np.square(np.diff(profile.heights) / 0.01)))
    # The window weights about a hundred wavelengths unequally, so the slope scatters by a few per cent.
    assert result.gradient[-1] == pytest.approx(rms_slope, rel=0.05)
    tilted_roughness = scale_dependent_roughness(Profile(5 + profile.heights + 0.3 * profile.x, spacing=0.01))
    assert tilted_roughness.gradient == pytest.approx(result.gradient, rel=1e-6)
    enlarged_roughness = scale_dependent_roughness(Profile(10 * profile.heights, spacing=0.1))
    assert enlarged_roughness.gradient == pytest.approx(result.gradient, rel=ROUND_OFF)
    assert 10 * enlarged_roughness.curvature == pytest.approx(result.curvature, rel=ROUND_OFF)


@pytest.mark.parametrize("hurst", [0.3, 0.8])
@pytest.mark.parametrize("is_areal", [True, False])
def test_slope_extrapolated_from_a_coarse_scan_agrees_with_the_slope_of_a_fine_scan(hurst, is_areal):
    """Compare the extrapolation from a coarse scan with a fine scan."""
    if is_areal:
        roughness_options = {"hurst_exponent": hurst, "rms": 0.1, "shape": (512, 512), "spacing": 0.01}
        fine_surface = self_affine_surface(3, longest_wavelength=1.28, **roughness_options)
        coarse_surface = self_affine_surface(3, longest_wavelength=1.28, shortest_wavelength=0.16, **roughness_options)
        coarse_surface = Surface(coarse_surface.heights[::8, ::8] * 1, spacing=0.08)
        scale = math.sqrt(
            surface_spectrum(fine_surface, periodic=True).radial().density[0]
            / surface_spectrum(coarse_surface, periodic=True).radial().density[0]
        )
        # Each surface was scaled to the given rms, so the coarse surface is scaled to the spectrum of the fine one.
        coarse_surface = Surface(scale * coarse_surface.heights, spacing=0.08)
    else:
        fine_surface = self_affine(3, hurst_exponent=hurst, rms=0.1, points=2**15, spacing=0.01, periodic=True)
        coarse_surface = Profile(np.fft.irfft(np.fft.rfft(fine_surface.heights)[: 2**11 + 1], 2**12) / 8, spacing=0.08)
    true_roughness = scale_dependent_roughness(fine_surface, periodic=True)
    coarse_roughness = scale_dependent_roughness(coarse_surface, periodic=True)
    estimate = estimate_hurst_exponent(coarse_surface, periodic=True)
    lines = [coarse_roughness.continued([0.02, 0.04, 0.1], line) for line in fitted_and_limiting_power_laws(estimate)]
    expected = true_roughness.gradient_at([0.02, 0.04, 0.1])
    assert lines[0] == pytest.approx(expected, rel=0.15)
    assert (lines[2] <= lines[0]).all()
    assert (lines[0] <= lines[1]).all()
    length = coarse_roughness.wavelength_of(float(lines[0][0]), estimate)
    assert length == pytest.approx(0.02, rel=1e-6)
    assert coarse_roughness.wavelength_of(float(coarse_roughness.gradient_at(0.3))) == pytest.approx(0.3, rel=1e-6)
    assert math.isnan(coarse_roughness.wavelength_of(2 * float(coarse_roughness.gradient[-1])))
    assert coarse_roughness.wavelength_of(1e-9) == pytest.approx(coarse_roughness.wavelength[0], rel=1e-6)


def test_extrapolated_slope_is_continuous_at_a_hurst_exponent_of_1():
    estimate = replace(estimate_hurst_exponent(rough_profile(points=4096)), value=1.0)
    roughness = scale_dependent_roughness(rough_profile(points=4096))
    close_estimate = replace(estimate, value=1 + 1e-9)
    assert roughness.continued(1e-4, estimate) == pytest.approx(roughness.continued(1e-4, close_estimate), rel=1e-6)


class TestInstrumentLimit:
    def test_instrument_limit_of_the_smallest_surface_is_set_by_the_pixel_size(self):
        small_surface = Surface([[0.0, 1.0], [2.0, 0.0]], spacing=1.0)
        assert instrument_limit(small_surface).reason == "pixels"
        with pytest.raises(ValueError, match=r"surface must have more points .* got 2 × 2 points"):
            surface_spectrum(small_surface).radial()

    @pytest.mark.parametrize("hurst", [0.3, 0.5, 0.8])
    def test_instrument_limit_of_a_noise_free_surface_is_set_by_the_pixel_size(self, hurst):
        for repetition in range(5):
            profile = self_affine(1, hurst_exponent=hurst, rms=0.1, points=8192, spacing=0.01, repetition=repetition)
            assert instrument_limit(profile).reason == "pixels"
        surface = self_affine_surface(1, hurst_exponent=hurst, rms=0.1, shape=(256, 256), spacing=(0.02, 0.01))
        result = instrument_limit(surface)
        assert (result.reason, result.wavelength, result.pixels) == ("pixels", 0.04, 0.04)
        subsampled_surface = Surface(
            surface.heights[::4, ::4], spacing=(0.08, 0.04)
        )  # subsampling, which also causes aliasing, must not look like noise
        assert instrument_limit(subsampled_surface).reason == "pixels"

    @pytest.mark.parametrize("noise", [0.3e-3, 1e-3, 1e-2])
    def test_spectrum_at_the_noise_limit_is_a_small_multiple_of_the_noise_power(self, noise):
        profile = self_affine(
            1, hurst_exponent=0.9, rms=0.1, points=2**14, spacing=0.01, periodic=True, amplitudes="fixed"
        )
        random_heights = np.random.default_rng(1).normal(size=profile.heights.size)
        result = instrument_limit(Profile(profile.heights + noise * random_heights, spacing=0.01), periodic=True)
        assert result.reason == "noise floor"
        # The spectrum is A n^-2.8 for harmonics n, and its sum is the mean square.
        harmonic = profile.extent / result.noise
        power = 0.1**2 * harmonic**-2.8 / (np.arange(1, 2**13) ** -2.8).sum()
        assert 1.2 < power / (noise**2 / 2**13) < 4  # power of the surface at the noise limit, relative to the noise

    def test_white_noise_profile_has_a_noise_limit_above_10_micrometres(self):
        result = instrument_limit(Profile(np.random.default_rng(2).normal(size=4096), spacing=0.1))
        assert result.reason == "noise floor"
        assert result.noise > 10

    def test_tip_limit_is_the_wavelength_at_which_surface_and_tip_have_equal_curvatures(self):
        surface = self_affine_surface(1, hurst_exponent=0.8, rms=0.1, shape=(256, 256), spacing=0.01)
        roughness = scale_dependent_roughness(surface)
        for radius in (0.02, 0.1, 1.0):
            result = instrument_limit(surface, tip_radius=radius)
            assert float(roughness.curvature_at(result.tip * 1.2)) < 0.1 / radius
            assert float(roughness.curvature_at(result.tip * 0.95)) > 0.1 / radius * 0.95
        assert result.reason == "tip"
        assert math.isnan(instrument_limit(surface, tip_radius=1e-5).tip)

    def test_instrument_limits_of_measured_scans_equal_recorded_limits(self, find_measured_file):
        surface = read_surface(find_measured_file("di-4.di"))
        result = instrument_limit(surface)
        assert result.reason == "noise floor"
        assert math.isnan(result.noise_x)
        assert result.noise_y == pytest.approx(6.37 * surface.spacing[0], rel=0.01)
        assert result.noise == result.wavelength == 0.125
        assert result.slope_fraction == pytest.approx(0.138, abs=0.001)
        assert instrument_limit(read_profile(find_measured_file("dektak-1.csv"))).reason == "pixels"

    def test_coloured_noise_is_detected_and_a_filter_restores_the_true_slope(self):
        points, spacing, num_filtered, num_correct = 4000, 1 / 60, 0, 0
        frequency = np.fft.rfftfreq(points, spacing)
        bands_by_colour = {
            "white": frequency > 0, "band": (frequency > 8) & (frequency < 18), "end": frequency > 24,
            "line": np.abs(frequency - 12) < 0.01,
        }  # fmt: skip
        for repetition in range(3):
            for hurst in (0.4, 0.6, 0.8):
                clean_profile = self_affine(
                    7, hurst_exponent=hurst, rms=0.01, points=points, spacing=spacing, repetition=repetition,
                    longest_wavelength=20.0, shortest_wavelength=8 * spacing,
                )  # fmt: skip
                assert instrument_limit(clean_profile).reason == "pixels"
                for seed, (name, band) in enumerate(bands_by_colour.items()):
                    random = np.random.default_rng([repetition, seed])
                    noise = np.fft.irfft(band * np.exp(2j * np.pi * random.uniform(size=band.size)), points)
                    heights = clean_profile.heights + 0.03 * clean_profile.heights.std() * noise / noise.std()
                    result = instrument_limit(Profile(heights, spacing=spacing))
                    if result.reason == "pixels":
                        assert name == "band"  # the hump is at most as high as the end of the spectrum of the surface
                        continue
                    slopes = [
                        np.gradient(cut_off(Profile(z, spacing=spacing), result.wavelength).heights).std()
                        for z in (heights, clean_profile.heights)
                    ]
                    num_filtered += 1
                    num_correct += abs(slopes[0] / slopes[1] - 1) < 0.05
        assert num_filtered >= 30
        assert num_correct >= 0.95 * num_filtered

    def test_hump_in_the_spectrum_at_long_wavelengths_is_not_reported_as_noise(self):
        rough_profile = self_affine(3, hurst_exponent=0.8, rms=0.01, points=8192, spacing=0.1, longest_wavelength=100.0)
        frequency = np.fft.rfftfreq(8192, 0.1)
        transform = np.fft.rfft(rough_profile.heights)
        transform[(frequency > 0.05) & (frequency < 0.12)] *= 30
        assert instrument_limit(Profile(np.fft.irfft(transform, 8192), spacing=0.1)).reason == "pixels"

    def test_rounded_heights_have_an_instrument_limit_due_to_quantisation(self):
        smooth_profile = self_affine(
            5, hurst_exponent=0.8, rms=0.1, points=4096, spacing=0.01, longest_wavelength=5.0, shortest_wavelength=0.5
        )
        rounded_profile = Profile(np.round(smooth_profile.heights, 3), spacing=0.01)
        assert instrument_limit(rounded_profile).reason == "quantisation"
        assert instrument_limit(levelled(rounded_profile, "line")).reason == "quantisation"


def make_body(heights, spacing=0.1):
    return (Profile if heights.ndim == 1 else Surface)(0.02 * scale_to_unit_rms(heights), spacing=spacing)


class TestMachinedTexture:
    @pytest.mark.parametrize("dimensions", [1, 2])
    @pytest.mark.parametrize("machining", MACHINED_SURFACES)
    def test_surface_without_noise_has_no_wavelengths_attributed_to_the_instrument(self, machining, dimensions):
        limits = [
            instrument_limit(
                make_body(MACHINED_SURFACES[machining](np.random.default_rng([seed, dimensions]), dimensions))
            )
            for seed in range(8)
        ]
        assert not any(limit.matters and limit.origin == "instrument" for limit in limits)
        assert sum(limit.matters for limit in limits) <= 1

    @pytest.mark.parametrize("feed", [10, 25, 60])
    def test_feed_marks_of_a_lathe_turned_profile_are_detected(self, feed):
        heights = turned_surface(np.random.default_rng(1), 1, feed=(feed, feed))
        assert instrument_limit(make_body(heights)).period == pytest.approx(0.1 * feed, rel=0.01)

    @pytest.mark.parametrize("feed", [120, 250])
    def test_cusps_of_unequal_depth_are_not_attributed_to_the_instrument(self, feed):
        profiles = [
            make_body(
                turned_surface(np.random.default_rng(seed), 1, feed=(0.9 * feed, 1.1 * feed), depth_variation=depth)
            )
            for depth in (0.15, 0.3)
            for seed in range(30)
        ]
        assert not any(instrument_limit(profile).matters for profile in profiles)
        rng = np.random.default_rng(1)
        noisy_profiles = [
            Profile(
                profile.heights + 0.1 * profile.heights.std() * rng.normal(size=len(profile)), spacing=profile.spacing
            )
            for profile in profiles[:10]
        ]
        if feed == 120:
            assert sum(instrument_limit(profile).matters for profile in noisy_profiles) >= 5

    @pytest.mark.parametrize("hurst", [0.3, 0.8, 1.0])
    def test_random_profile_has_no_feed_marks(self, hurst):
        for seed in range(10):
            heights = filtered_noise(np.random.default_rng(seed), (2048,), hurst)
            assert math.isnan(instrument_limit(make_body(heights)).period)

    def test_origin_of_noise_on_a_lathe_turned_profile_is_unknown_unless_the_texture_is_declared(self):
        rng = np.random.default_rng(3)
        heights = turned_surface(rng, 1, feed=(40, 40), rough=0.02, depth_variation=0.0)
        noisy_body = make_body(heights + 0.05 * heights.std() * rng.normal(size=heights.size))
        result = instrument_limit(noisy_body)
        assert (result.reason, result.origin, result.matters) == ("noise floor", "unknown", True)
        assert instrument_limit(noisy_body, texture=True).origin == "instrument"

    def test_single_spectral_line_has_unknown_origin_unless_the_texture_is_declared(self):
        rng = np.random.default_rng(1)
        smooth_heights = filtered_noise(rng, (4096,), 0.8, longest_wavelength=300, shortest_wavelength=20)
        body_with_line = make_body(smooth_heights + 0.05 * np.sin(2 * np.pi * np.arange(4096) / 8))
        result = instrument_limit(body_with_line)
        assert (result.reason, result.origin, result.matters) == ("line", "unknown", True)
        assert instrument_limit(body_with_line, texture=True).reason == "pixels"

    def test_white_noise_of_a_map_with_declared_texture_is_attributed_to_the_instrument(self):
        rng = np.random.default_rng(2)
        smooth_heights = filtered_noise(rng, (128, 128), 0.8, longest_wavelength=60, shortest_wavelength=6)
        noisy_body = make_body(smooth_heights + 0.05 * rng.normal(size=smooth_heights.shape))
        for texture in (False, True):
            result = instrument_limit(noisy_body, texture=texture)
            assert (result.reason, result.origin, result.matters) == ("noise floor", "instrument", True)


@pytest.mark.parametrize("periodic", [False, True])
def test_white_noise_map_has_as_many_independent_line_spectra_as_lines(periodic):
    noise = Surface(np.random.default_rng(6).normal(size=(96, 128)), spacing=0.1)
    for (*_, count, _), lines in zip(line_spectra(noise, periodic), noise.heights.shape, strict=True):
        assert np.median(count) == pytest.approx(lines, rel=0.05)


@pytest.mark.parametrize("degrees", [0, 5, 17])
def test_straight_grooves_have_only_one_independent_line_spectrum(degrees):
    y, x = np.indices((128, 128))
    x_across = x * math.cos(math.radians(degrees)) + y * math.sin(math.radians(degrees))
    frequencies = np.linspace(0.02, 0.4, 200)
    phases = np.random.default_rng(7).uniform(0, 2 * math.pi, frequencies.size)
    heights = sum(np.cos(2 * math.pi * f * x_across + phase) / f for f, phase in zip(frequencies, phases, strict=True))
    (_, _, count, _), _ = line_spectra(Surface(heights, spacing=0.1), False)
    assert np.median(count[5:45]) < 1.5


def noise_slope_fraction(noise, heights):
    """Return the fraction of the mean square slope of heights that is due to their noise, from windowed samples."""
    slope, total = (scale_dependent_roughness(Surface(z, spacing=0.1)).gradient[-1] for z in (noise, heights))
    return (slope / total) ** 2


class TestNoiseOfAnisotropicMap:
    """Grooves along y, along which noise limits the spectrum at longer wavelengths than across them."""

    @pytest.fixture(params=[1, 2, 3])
    def grooved_heights_and_rng(self, request):
        rng = np.random.default_rng(request.param)
        return filtered_noise(rng, (192, 192), 0.8, longest_wavelength=60, shortest_wavelength=5, stretch=6.0), rng

    @pytest.mark.parametrize("noise_rms", [0.002, 0.05])
    def test_filtering_at_the_instrument_limit_removes_white_noise_from_grooves(
        self, grooved_heights_and_rng, noise_rms
    ):
        heights, rng = grooved_heights_and_rng
        noise = noise_rms * rng.normal(size=heights.shape)
        scan = Surface(heights + noise, spacing=0.1)
        result = instrument_limit(scan)
        assert (result.reason, result.axis) == ("noise floor", "")
        assert result.noise_y > 3 * result.noise_x
        assert 0.4 < result.wavelength < 0.7
        assert result.slope_fraction == pytest.approx(noise_slope_fraction(noise, heights + noise), rel=0.2)
        clean_slope, filtered_slope = (
            math.hypot(*(np.diff(body, axis=axis).std() for axis in range(2)))
            for body in (heights, cut_off(scan, result.cut_off).heights)
        )
        assert filtered_slope == pytest.approx(clean_slope, rel=0.04)

    def test_noise_fraction_of_the_slope_includes_noise_hidden_by_roughness_across_the_grooves(self):
        rng = np.random.default_rng(4)
        heights = filtered_noise(rng, (192, 192), 0.8, longest_wavelength=60, stretch=30.0)
        noise = 0.03 * rng.normal(size=heights.shape)
        result = instrument_limit(Surface(heights + noise, spacing=0.1))
        assert (result.reason, result.axis) == ("noise floor", "y")
        assert math.isnan(result.noise_x)
        assert result.slope_fraction == pytest.approx(noise_slope_fraction(noise, heights + noise), rel=0.2)

    def test_narrow_map_whose_axes_share_no_wavenumbers_has_an_instrument_limit(self):
        rng = np.random.default_rng(5)
        heights = filtered_noise(rng, (512,), 0.8, longest_wavelength=100, shortest_wavelength=20) + 0.05 * rng.normal(
            size=(4, 512)
        )
        result = instrument_limit(Surface(heights, spacing=(0.001, 0.1)))
        assert result.reason in ("noise floor", "pixels")

    def test_height_offsets_between_rows_count_as_noise_along_y_but_not_along_x(self, grooved_heights_and_rng):
        heights, rng = grooved_heights_and_rng
        noise = 0.05 * rng.normal(size=(192, 1)) + np.zeros(heights.shape)
        result = instrument_limit(Surface(heights + noise, spacing=0.1))
        assert result.axis == "y"
        assert math.isnan(result.noise_x)
        assert result.slope_fraction == pytest.approx(noise_slope_fraction(noise, heights + noise), rel=0.2)


@pytest.mark.parametrize(
    ("function", "arguments", "message"),
    [
        (scale_dependent_roughness, {"body": [1.0]}, "body must be a Profile or a Surface, got list"),
        (scale_dependent_roughness, {"body": Profile(np.ones(9), spacing=1.0)}, "profile must not be flat"),
        (scale_dependent_roughness, {"body": sinusoid(16), "periodic": 1}, "periodic must be True or False"),
        (instrument_limit, {"body": [1.0]}, "body must be a Profile or a Surface, got list"),
        (
            instrument_limit,
            {"body": Surface(np.arange(9.0) + np.zeros((8, 1)), spacing=1.0)},
            "surface must not be flat",
        ),
        (instrument_limit, {"body": sinusoid(16), "periodic": 1}, "periodic must be True or False"),
        (instrument_limit, {"body": sinusoid(16), "tip_radius": 0.0}, "tip_radius must be a finite number above 0 µm"),
    ],
)
def test_instrument_limit_rejects_invalid_arguments(function, arguments, message):
    with pytest.raises(ValueError, match=message):
        function(**arguments)


def test_interpolation_of_gradient_and_wavelength_rejects_invalid_arguments():
    result = scale_dependent_roughness(sinusoid(16))
    with pytest.raises(ValueError, match="wavelength must be above 0"):
        result.gradient_at(0.0)
    with pytest.raises(ValueError, match="gradient must be a finite number above 0"):
        result.wavelength_of(-1.0)


@pytest.mark.parametrize("colour", ["white", "band"])
def test_filtering_at_the_instrument_cutoff_preserves_the_slope_of_a_noise_free_surface(colour):
    """Check that the cutoff removes little slope. A cutoff at `limit.wavelength` would reduce h' by 20 %."""
    for seed in range(6):
        clean_surface = self_affine_surface(
            seed, hurst_exponent=0.7, rms=0.002, shape=(192, 192), spacing=0.02, shortest_wavelength=0.2
        )
        q = np.hypot(*np.meshgrid(np.fft.fftfreq(192), np.fft.fftfreq(192)))
        transmission = np.ones(q.shape) if colour == "white" else (q > 0.15) & (q < 0.35)
        noise = np.fft.ifft2(np.fft.fft2(np.random.default_rng(seed).normal(size=q.shape)) * transmission).real
        scan = Surface(clean_surface.heights + 0.04 * clean_surface.heights.std() * noise / noise.std(), spacing=0.02)
        limit = instrument_limit(scan)
        assert limit.slope_fraction > 0.1
        assert 0.04 <= limit.cut_off < limit.wavelength
        bodies = (clean_surface, scan, cut_off(scan, limit.cut_off))
        slopes = [float(scale_dependent_roughness(body).gradient[-1]) for body in bodies]
        assert slopes[2] == pytest.approx(slopes[0], rel=0.06)
        assert slopes[1] > 1.06 * slopes[0]
