"""Tests of self-affine profiles and surfaces: heights, spectra and random numbers."""

import numpy as np
import pytest
from stiction import Surface, power_spectrum, roughness_parameters, self_affine_surface
from support.rough_surfaces import rough_profile

ROUND_OFF = 1e-12
SURFACE_OPTIONS = {"hurst_exponent": 0.8, "rms": 0.1, "shape": (96, 128), "spacing": (0.02, 0.01)}


class TestSelfAffineProfile:
    def test_self_affine_profile_has_requested_spectrum_and_rms_height(self):
        profile = rough_profile(periodic=True, amplitudes="fixed", longest_wavelength=2.0, shortest_wavelength=0.05)
        assert roughness_parameters(profile).Pq == pytest.approx(0.1, rel=ROUND_OFF)
        spectrum = power_spectrum(profile, periodic=True)
        wavelength = 2 * np.pi / spectrum.wave_number
        is_in_plateau, is_beyond_cutoff = wavelength > 2.0 * (1 + 1e-9), wavelength < 0.05 * (1 - 1e-9)
        prefactors = (
            spectrum.density[~is_in_plateau & ~is_beyond_cutoff]
            * spectrum.wave_number[~is_in_plateau & ~is_beyond_cutoff] ** 2.6
        )
        assert np.allclose(prefactors, prefactors[0], rtol=1e-9, atol=0)
        assert np.allclose(
            spectrum.density[is_in_plateau], prefactors[0] * (2 * np.pi / 2.0) ** -2.6, rtol=1e-9, atol=0
        )
        assert spectrum.density[is_beyond_cutoff].max() < 1e-24 * spectrum.density[0]

    @pytest.mark.parametrize("periodic", [True, False])
    def test_ensemble_of_self_affine_profiles_has_the_requested_mean_square_height(self, periodic):
        squares = [
            roughness_parameters(rough_profile(repetition=r, periodic=periodic, longest_wavelength=0.5)).Pq ** 2
            for r in range(100)
        ]
        # The mean square of 100 profiles with about ten independent sections scatters by 4 %.
        # Subtracting the mean height reduces the mean square by another 4 %.
        assert np.mean(squares) == pytest.approx(0.1**2, rel=0.12)

    def test_profile_generated_on_a_finer_grid_contains_the_points_of_the_coarser_grid(self):
        options = {"shortest_wavelength": 0.05}
        for periodic in (True, False):
            coarse_profile = rough_profile(points=1000, spacing=0.01, periodic=periodic, **options)
            fine_profile = rough_profile(points=4000, spacing=0.0025, periodic=periodic, **options)
            assert np.allclose(fine_profile.heights[::4], coarse_profile.heights, rtol=0, atol=ROUND_OFF)

    def test_end_of_a_profile_joins_its_start_only_if_the_profile_is_periodic(self):
        def compute_relative_end_jump(profile):
            return abs(profile.heights[0] - profile.heights[-1]) / np.abs(np.diff(profile.heights)).max()

        assert max(compute_relative_end_jump(rough_profile(repetition=r, periodic=True)) for r in range(10)) < 2
        assert np.median([compute_relative_end_jump(rough_profile(repetition=r)) for r in range(10)]) > 5

    def test_self_affine_profile_is_reproducible_and_depends_on_seed(self):
        assert np.array_equal(rough_profile(1).heights, rough_profile(1).heights)
        for other_profile in (rough_profile(2), rough_profile(1, repetition=1), rough_profile(1, side="upper")):
            assert not np.allclose(rough_profile(1).heights, other_profile.heights)

    @pytest.mark.parametrize(
        ("invalid_arguments", "match"),
        [
            ({"hurst_exponent": 0.0}, "hurst_exponent"),
            ({"hurst_exponent": 2.1}, "hurst_exponent"),
            ({"rms": 0.0}, "rms"),
            ({"points": 3}, "points"),
            ({"points": 10**8}, "period"),
            ({"spacing": -1.0}, "spacing"),
            ({"spacing": 5e-324}, "spacing must be at least 2e-308"),
            ({"shortest_wavelength": 0.015}, "shortest_wavelength"),
            ({"longest_wavelength": 0.01}, "longest_wavelength"),
            ({"longest_wavelength": 11.0, "periodic": True}, "longest_wavelength"),
            ({"shortest_wavelength": 11.0, "periodic": True}, "shortest_wavelength"),
            ({"amplitudes": "random"}, "amplitudes"),
            ({"periodic": 1}, "periodic"),
            ({"seed": -1}, "seed"),
        ],
    )
    def test_self_affine_profile_rejects_invalid_arguments(self, invalid_arguments, match):
        with pytest.raises(ValueError, match=match):
            rough_profile(**invalid_arguments)


def create_surface(seed=3, **changes):
    return self_affine_surface(seed, **(SURFACE_OPTIONS | changes))


def compute_mean_powers(heights, extents):
    """Return the mean square of each Fourier coefficient in one half of the plane, and its wavenumber."""
    transform = np.fft.fft2(heights) / heights.size
    y, x = (np.fft.fftfreq(size, 1 / size) / extent for size, extent in zip(heights.shape, extents, strict=True))
    return np.abs(transform) ** 2, 2 * np.pi * np.hypot(y[:, None], x)


def test_self_affine_surface_has_requested_rms_height_and_zero_mean():
    for changes in ({}, {"longest_wavelength": 0.4}, {"shape": (4, 5), "spacing": 1.0}, {"rms": 1e-7}):
        heights = create_surface(**changes).heights
        assert heights.std() == pytest.approx((SURFACE_OPTIONS | changes)["rms"], rel=ROUND_OFF)
        assert abs(heights.mean()) < ROUND_OFF * heights.std()


@pytest.mark.parametrize("hurst", [0.3, 0.8, 1.5])
def test_surface_spectrum_is_a_power_law_with_plateau_and_cutoff(hurst):
    extents = (5.12, 5.12)
    spectra = []
    for repetition in range(8):
        created_surface = create_surface(
            shape=(256, 256), spacing=0.02, hurst_exponent=hurst, repetition=repetition,
            longest_wavelength=1.28, shortest_wavelength=0.08,
        )  # fmt: skip
        density, q = compute_mean_powers(created_surface.heights, extents)
        spectra.append(density)
    mean = np.mean(spectra, axis=0)
    assert mean[q > 2 * np.pi / 0.08 * 1.001].max() < 1e-25
    law = np.maximum(q * 1.28 / (2 * np.pi), 1) ** (-2 - 2 * hurst)
    level = mean[(q > 0) & (q < 2 * np.pi / 0.08)].sum() / law[(q > 0) & (q < 2 * np.pi / 0.08)].sum()
    for min_wavenumber, max_wavenumber in ((0.5, 4.0), (6.0, 10.0), (10.0, 20.0), (20.0, 40.0), (40.0, 75.0)):
        is_in_ring = (q > min_wavenumber) & (q < max_wavenumber)
        # The squared Fourier coefficients are exponentially distributed.
        # The tolerance is four standard errors of a mean over n / 2 independent coefficients of each of 8 surfaces.
        # The level of the plateau has the same tolerance, because few of the longest wavelengths determine it.
        ratio = np.mean(mean[is_in_ring] / law[is_in_ring]) / level
        assert ratio == pytest.approx(1, abs=4 / np.sqrt(4 * is_in_ring.sum()) + 0.15)


def test_self_affine_surface_is_isotropic_on_any_grid():
    surfaces = [
        create_surface(shape=(128, 256), spacing=(0.02, 0.01), shortest_wavelength=0.08, repetition=r)
        for r in range(20)
    ]
    rms_slopes_y = np.array([np.gradient(surface.heights, 0.02, axis=0).std() for surface in surfaces])
    rms_slopes_x = np.array([np.gradient(surface.heights[:, ::2], 0.02, axis=1).std() for surface in surfaces])
    # Hundreds of the shortest wavelengths determine the slope, so the mean of 20 surfaces agrees to 1 %.
    assert np.mean(rms_slopes_y**2) / np.mean(rms_slopes_x**2) == pytest.approx(1, abs=0.03)


def test_self_affine_surface_is_periodic():
    created_surface = create_surface(shape=(64, 64), spacing=0.02, shortest_wavelength=0.16)
    tiled_heights = np.tile(created_surface.heights, (2, 2))
    differences = np.abs(np.diff(tiled_heights, axis=1))
    assert differences[:, 63].max() <= np.delete(differences, 63, axis=1).max()
    assert (
        np.abs(np.diff(tiled_heights, axis=0))[63].max() <= np.abs(np.diff(created_surface.heights, axis=0)).max() * 1.5
    )


def test_surface_generated_on_a_finer_grid_contains_the_points_of_the_coarser_grid():
    coarse_surface = create_surface(shortest_wavelength=0.1, longest_wavelength=0.8)
    fine_surface = create_surface(
        shortest_wavelength=0.1, longest_wavelength=0.8, shape=(288, 256), spacing=(0.02 / 3, 0.005)
    )
    assert np.abs(fine_surface.heights[::3, ::2] - coarse_surface.heights).max() < ROUND_OFF


def test_self_affine_surface_is_reproducible_and_depends_on_seed():
    original_surface = create_surface()
    assert create_surface().heights.tobytes() == original_surface.heights.tobytes()
    for other_surface in (create_surface(seed=4), create_surface(repetition=1), create_surface(side="upper")):
        correlation = (other_surface.heights * original_surface.heights).mean() / 0.01
        # Long wavelengths dominate the heights, so two surfaces may be correlated by chance.
        assert abs(correlation) < 0.8
    ensemble = [
        create_surface(repetition=r).heights * create_surface(repetition=r, side="upper").heights for r in range(40)
    ]
    assert abs(np.mean(ensemble) / 0.01) < 4 * np.std(
        [original_surface.mean() / 0.01 for original_surface in ensemble]
    ) / np.sqrt(40)


def test_spectral_phases_of_a_generated_profile_equal_the_documented_random_numbers():
    # The strip contains a single harmonic (1, 0) along x. The second random word has no effect, because the rms is
    # given.
    sinusoidal_surface = self_affine_surface(
        5, hurst_exponent=0.5, rms=1.0, shape=(4, 64), spacing=(0.01, 0.125), shortest_wavelength=7.0, repetition=2
    )
    word = np.random.PCG64(np.random.SeedSequence([5, 2, 0, 1])).random_raw()
    phase = 2 * np.pi * (int(word) >> 11) / 2**53
    assert np.allclose(
        sinusoidal_surface.heights, np.sqrt(2) * np.cos(2 * np.pi * sinusoidal_surface.x / 8.0 + phase), atol=ROUND_OFF
    )


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"hurst_exponent": 0.0}, "hurst_exponent"),
        ({"hurst_exponent": 2.1}, "hurst_exponent"),
        ({"rms": 0.0}, "rms"),
        ({"shape": (3, 64)}, "shape"),
        ({"shape": 64}, "shape"),
        ({"shape": (20_000, 20_000)}, "shape must have at most"),
        ({"spacing": -1.0}, "spacing"),
        ({"spacing": (0.1, 0.1, 0.1)}, "spacing"),
        ({"spacing": (5e-324, 0.1)}, "spacing must be at least 2e-308"),
        ({"shortest_wavelength": 0.039}, "shortest_wavelength"),
        ({"shortest_wavelength": 1.93}, "shortest_wavelength"),
        ({"longest_wavelength": 2.0}, "longest_wavelength"),
        ({"longest_wavelength": 0.04}, "longest_wavelength"),
        ({"side": "left"}, "side"),
        ({"repetition": -1}, "repetition"),
        ({"rms": np.nan}, "rms"),
    ],
)
def test_self_affine_surface_rejects_invalid_arguments(changes, match):
    with pytest.raises(ValueError, match=match):
        create_surface(**changes)


class TestScalingToAmplitude:
    def test_surface_scaled_to_an_amplitude_has_that_amplitude_and_zero_mean(self):
        created_surface = create_surface()
        raised_surface = Surface(created_surface.heights + 5.0, spacing=created_surface.spacing, history=("made",))
        for measure, compute_amplitude in (("height", np.ptp), ("Sa", lambda h: np.abs(h).mean()), ("Sq", np.std)):
            scaled_surface = raised_surface.with_amplitude(0.3, measure)
            assert compute_amplitude(scaled_surface.heights) == pytest.approx(0.3, rel=ROUND_OFF)
            assert abs(scaled_surface.heights.mean()) < ROUND_OFF
            assert scaled_surface.spacing == created_surface.spacing
            assert scaled_surface.history == ("made", f"scaled to {measure} 0.3 µm")
            assert np.corrcoef(scaled_surface.heights.ravel(), created_surface.heights.ravel())[0, 1] == pytest.approx(
                1, rel=ROUND_OFF
            )

    def test_scaling_a_surface_rejects_flat_surfaces_and_invalid_arguments(self):
        flat = Surface(np.full((5, 5), 2.0), spacing=1.0)
        assert flat.is_flat
        assert not create_surface().is_flat
        with pytest.raises(ValueError, match="flat"):
            flat.with_amplitude(1.0)
        with pytest.raises(ValueError, match="amplitude"):
            create_surface().with_amplitude(0.0)
        with pytest.raises(ValueError, match="measure"):
            create_surface().with_amplitude(1.0, "Ra")
