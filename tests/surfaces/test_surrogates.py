"""Tests of surrogates, whose spectra are compared with known surfaces and estimated from sections."""

from itertools import pairwise

import numpy as np
import pytest
from stiction import (
    Profile,
    half_space,
    isotropic_spectrum,
    isotropic_surface,
    levelled,
    power_spectrum,
    roughness_parameters,
    self_affine_surface,
    spectral_moments,
    surface_spectrum,
    surrogate,
)
from support.rough_surfaces import rough_profile

ROUND_OFF = 1e-12
FIT_ROUND_OFF = 1e-9

RING_TOLERANCE = 0.1
"""Relative error of a spectral density in rings of a quarter octave, within which it falls by up to a half."""

STATISTICAL_TOLERANCE = 0.1
"""Relative scatter of the rms gradient of one line, and of area and friction of a few pairs of pieces."""


class TestSurrogate:
    @pytest.mark.parametrize("points", [1000, 1001])
    def test_surrogate_of_a_periodic_profile_has_the_same_spectrum(self, points):
        profile = rough_profile(points=points, periodic=True)
        surrogate_profile = surrogate(profile, 5, periodic=True)
        density, surrogate_density = (power_spectrum(p, periodic=True).density for p in (profile, surrogate_profile))
        assert np.allclose(density, surrogate_density, rtol=1e-9, atol=ROUND_OFF**2 * density.max())
        assert abs(np.corrcoef(profile.heights, surrogate_profile.heights)[0, 1]) < 0.9
        assert surrogate_profile.heights.mean() == pytest.approx(profile.heights.mean(), abs=ROUND_OFF)

    def test_surrogate_of_a_profile_has_the_same_mean_and_rms_height(self):
        for profile in (
            rough_profile(),
            rough_profile(points=1001),
            Profile(rough_profile().heights + 7.0, spacing=0.01),
        ):
            other_surrogate = surrogate(profile, 5, repetition=2)
            assert other_surrogate.heights.mean() == pytest.approx(profile.heights.mean(), abs=ROUND_OFF)
            assert roughness_parameters(other_surrogate).Pq == pytest.approx(
                roughness_parameters(profile).Pq, rel=1e-11
            )

    @pytest.mark.parametrize("points", [8, 9, 10, 11])
    def test_surrogate_spectrum_equals_the_averaged_spectrum_of_the_mirrored_profile(self, points):
        heights = rough_profile(points=points).heights
        mirrored_heights = np.concatenate([heights, heights[::-1]]) - heights.mean()
        density = np.abs(np.fft.fft(mirrored_heights)) ** 2
        even_indices = 2 * np.arange(1, points // 2 + 1)
        averaged_powers = (
            density[even_indices] / 2 + (density[even_indices - 1] + density[(even_indices + 1) % (2 * points)]) / 4
        )
        surrogate_powers = np.abs(np.fft.rfft(surrogate(Profile(heights, spacing=1.0), 3).heights)[1:]) ** 2
        assert np.allclose(
            surrogate_powers / surrogate_powers.sum(), averaged_powers / averaged_powers.sum(), rtol=1e-9, atol=0
        )

    @pytest.mark.parametrize("hurst", [0.4, 0.8])
    @pytest.mark.parametrize("longest", [4.0, 40.0])
    def test_surrogate_preserves_the_rms_slope_and_the_spectrum_at_short_wavelengths(self, hurst, longest):
        slope_ratios, short_wave_ratios = [], []
        for r in range(20):
            profile = rough_profile(points=4096, longest_wavelength=longest, hurst_exponent=hurst, repetition=r)
            tilt = np.polynomial.Polynomial.fit(profile.x, profile.heights, 1)(profile.x)
            profile = Profile(profile.heights - tilt, spacing=profile.spacing)
            other_surrogate = surrogate(profile, 5, repetition=r)
            slope_ratios.append(
                roughness_parameters(other_surrogate, derivative="neighbours").Pdq
                / roughness_parameters(profile, derivative="neighbours").Pdq
            )
            original_slope, surrogate_slope = (
                spectral_moments(p, longest_wavelength=0.1, periodic=p is other_surrogate).slope
                for p in (profile, other_surrogate)
            )
            short_wave_ratios.append(surrogate_slope / original_slope)
        # The windowed sum over 2000 harmonics of one profile scatters by 3 %. Each end adds a corner.
        assert np.mean(slope_ratios) == pytest.approx(1, abs=0.02)
        assert np.max(np.abs(np.log(slope_ratios))) < 0.05
        assert np.mean(short_wave_ratios) == pytest.approx(1, abs=0.03)

    def test_surrogate_is_reproducible_and_depends_on_the_seed(self):
        profile = rough_profile()
        assert np.array_equal(surrogate(profile, 1).heights, surrogate(profile, 1).heights)
        other_surrogates = [surrogate(profile, 1, repetition=r) for r in range(3)] + [
            surrogate(profile, 1, side="upper")
        ]
        for first_surrogate, two in pairwise(other_surrogates):
            assert not np.allclose(first_surrogate.heights, two.heights)

    def test_surrogate_rejects_invalid_arguments(self):
        with pytest.raises(ValueError, match="flat"):
            surrogate(Profile([1.0] * 10, spacing=1.0), 1)
        with pytest.raises(ValueError, match="seed"):
            surrogate(rough_profile(), -1)
        with pytest.raises(ValueError, match="periodic"):
            surrogate(rough_profile(), 1, periodic="no")


def create_map(hurst, side="lower", shape=(256, 2048), spacing=0.1):
    return self_affine_surface(
        4, hurst_exponent=hurst, rms=0.05, shape=shape, spacing=spacing, longest_wavelength=6.4,
        shortest_wavelength=0.8, side=side,
    )  # fmt: skip


@pytest.mark.parametrize("hurst", [0.4, 0.9])
def test_spectrum_of_an_isotropic_surface_is_recovered_from_its_section(hurst):
    """Check a profile whose spectrum C1D(k) is exactly the sum of a known C2D over all transverse wavenumbers."""
    points, spacing = 512, 0.5
    q = 2 * np.pi * np.fft.fftfreq(points, spacing)
    known_density = np.maximum(np.hypot(q[:, np.newaxis], q), 20 * q[1]) ** (-2 - 2 * hurst)
    mean = known_density.sum(axis=0)[: points // 2 + 1] / (points * spacing)
    phases = np.exp(2j * np.pi * np.random.default_rng(1).random(mean.size))
    phases[[0, -1]] = [0, 1]
    profile = Profile(np.fft.irfft(np.sqrt(mean * points / spacing) * phases, points), spacing=spacing)
    np.testing.assert_allclose(power_spectrum(profile, periodic=True).density, mean[1:], rtol=FIT_ROUND_OFF)
    result = isotropic_spectrum(profile, periodic=True)
    expected = np.maximum(result.wave_number, 20 * q[1]) ** (-2 - 2 * hurst)
    # Exclude interpolated rings, and rings next to the corner of the roll-off, which is rounded.
    is_reliable = (result.count >= 4) & (np.abs(np.log(result.wave_number / (20 * q[1]))) > 0.35)
    np.testing.assert_allclose(result.density[is_reliable], expected[is_reliable], rtol=RING_TOLERANCE)


@pytest.mark.parametrize("hurst", [0.4, 0.9])
def test_rms_gradient_of_an_isotropic_surface_is_root_2_times_the_rms_slope_of_its_section(hurst):
    body = create_map(hurst)
    original_spectrum = surface_spectrum(body, periodic=True)
    gradient = np.sqrt(original_spectrum.moments(0).slope + original_spectrum.moments(90).slope)
    for row in (0, 100):
        section = levelled(body.row(row), "line")
        created_surface = isotropic_surface(section, 1, shape=(256, 256))
        assert created_surface.spacing == (0.1, 0.1)
        created_spectrum = surface_spectrum(created_surface, periodic=True)
        assert np.sqrt(created_spectrum.moments(0).slope + created_spectrum.moments(90).slope) == pytest.approx(
            gradient, rel=STATISTICAL_TOLERANCE
        )
        assert created_spectrum.moments(0).slope == pytest.approx(
            created_spectrum.moments(90).slope, rel=2 * STATISTICAL_TOLERANCE
        )


def test_mean_slope_of_isotropic_surfaces_equals_the_mean_slope_of_their_section():
    section = create_map(0.7, shape=(64, 512)).row(3)
    spectrum = isotropic_spectrum(section, periodic=True)
    slopes = [
        surface_spectrum(isotropic_surface(section, 1, shape=(64, 64), repetition=index, periodic=True), periodic=True)
        .moments(0)
        .slope
        for index in range(40)
    ]
    # The profile and the surface have these wavelengths in common; 64 points contain all of them except the longest.
    expected = spectral_moments(section, periodic=True).slope
    assert np.mean(slopes) == pytest.approx(expected, rel=4 * np.std(slopes) / np.sqrt(40) / expected)
    # The sum is the number of harmonics; the harmonic at the Nyquist wavenumber counts half.
    assert spectrum.count.sum() == pytest.approx(255.5)


def test_isotropic_surface_scales_with_its_section_and_depends_on_the_seed():
    section = create_map(0.7, shape=(64, 512)).row(3)
    original_surface = isotropic_surface(section, 7, shape=(64, 96), repetition=2, side="upper")
    enlarged_surface = isotropic_surface(
        Profile(10 * section.heights + 3, spacing=1.0), 7, shape=(64, 96), repetition=2, side="upper"
    )
    np.testing.assert_allclose(
        enlarged_surface.heights, 10 * original_surface.heights, rtol=1e-6, atol=1e-6 * original_surface.heights.std()
    )
    assert original_surface.history == (*section.history, "an isotropic surface of its spectrum, seed 7, repetition 2")
    assert np.abs(original_surface.heights.mean()) < FIT_ROUND_OFF
    assert isotropic_surface(section, 7).heights.shape == (512, 512)
    for changed_arguments in ({"seed": 8}, {"repetition": 3}, {"side": "lower"}):
        other_surface = isotropic_surface(
            section, **{"seed": 7, "shape": (64, 96), "repetition": 2, "side": "upper"} | changed_arguments
        )
        assert np.abs(other_surface.heights - original_surface.heights).max() > 0.01


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"profile": Profile(np.zeros(100), spacing=1.0)}, "flat profile"),
        ({"shape": (3, 64)}, "shape must be a whole number of at least 4"),
        ({"shape": 64}, r"shape must be \(rows, columns\)"),
        ({"shape": (10**5, 10**5)}, "shape must have at most"),
        ({"seed": -1}, "seed must be"),
        ({"side": "middle"}, "side must be one of"),
        ({"periodic": "yes"}, "periodic must be True or False"),
    ],
)
def test_isotropic_surface_rejects_invalid_arguments(changes, words):
    arguments = {"profile": create_map(0.7, shape=(64, 256)).row(0), "seed": 1} | changes
    with pytest.raises(ValueError, match=words):
        isotropic_surface(arguments.pop("profile"), arguments.pop("seed"), **arguments)


@pytest.mark.soak
def test_isotropic_surfaces_from_sections_have_contact_area_and_friction_of_the_original_maps():
    """Check pieces of 128 by 128 points.

    The script docs/scripts/isotropic.py uses larger pieces for H from 0.4 to 0.9.
    """
    bodies = [create_map(0.7, side, shape=(128, 1024)) for side in ("upper", "lower")]

    def compute_mean_area_and_friction(pairs):
        values = []
        for pair in pairs:
            area = np.prod(pair[0].extent)
            curve = half_space(*pair, [0.02 * area], direction=[0.0, 90.0, 180.0, 270.0])
            friction = curve.friction_coefficient(mu0=0.4, tau0=0.1)
            values.append([curve.contact_area[0] / area, friction.mean()])
        return np.mean(values, axis=0)

    values_of_maps = compute_mean_area_and_friction(
        [
            levelled(type(body)(body.heights[:, first_column : first_column + 128], spacing=0.1), "plane")
            for body in bodies
        ]
        for first_column in range(0, 1024, 128)
    )  # fmt: skip
    values_of_created_maps = compute_mean_area_and_friction(
        [
            isotropic_surface(levelled(body.row(20 * index), "line"), 1, shape=(128, 128), side=side, repetition=index)
            for body, side in zip(bodies, ("upper", "lower"), strict=True)
        ]
        for index in range(6)
    )  # fmt: skip
    np.testing.assert_allclose(values_of_created_maps, values_of_maps, rtol=STATISTICAL_TOLERANCE)
