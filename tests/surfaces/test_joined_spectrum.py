"""Tests of combined spectra from simulated scans of a generated surface with a known spectrum."""

import math

import numpy as np
import pytest
from stiction import Profile, Surface, joined_spectrum, scale_dependent_roughness, self_affine_surface, surface_spectrum

NUM_POINTS, SPACING = 1024, 0.01
# Relative error of a spectrum from a few pieces of a surface, in bins with at least a hundred Fourier coefficients.
BIN_TOLERANCE = 0.1


@pytest.fixture(scope="module")
def complete_surface():
    return self_affine_surface(
        7, hurst_exponent=0.8, rms=0.03, shape=(NUM_POINTS, NUM_POINTS), spacing=SPACING, longest_wavelength=1.28
    )


def scans_of_instruments(complete_surface, noise=1e-5):
    """Return scans of a coarse instrument with pixel averages and noise, and scans of pieces by finer instruments."""
    random = np.random.default_rng(1)
    means = complete_surface.heights.reshape(NUM_POINTS // 8, 8, NUM_POINTS // 8, 8).mean((1, 3))
    coarse_scan = Surface(means + noise * random.normal(size=means.shape), spacing=8 * SPACING)
    fine_scans = [
        Surface(complete_surface.heights[row : row + 512, column : column + 512], spacing=SPACING)
        for row in (0, 512) for column in (0, 512)
    ]  # fmt: skip
    return [coarse_scan, *fine_scans]


def true_spectrum(complete_surface, wave_number, per_decade):
    q, _, density = surface_spectrum(complete_surface, periodic=True).waves()
    half_width_factor = 10 ** (0.5 / per_decade)
    is_in_bin_of_centre = [
        (q >= centre / half_width_factor) & (q < centre * half_width_factor) for centre in wave_number
    ]
    return np.array([
        (density[is_in_bin] * (q[is_in_bin] / centre) ** 3).mean()
        for is_in_bin, centre in zip(is_in_bin_of_centre, wave_number, strict=True)
    ])  # fmt: skip


def test_joined_spectrum_agrees_with_the_spectrum_and_the_slope_of_the_surface(complete_surface):
    combined_spectrum = joined_spectrum(scans_of_instruments(complete_surface), per_decade=5)
    is_reliable = combined_spectrum.count > 300
    assert is_reliable.sum() > 5
    expected = true_spectrum(complete_surface, combined_spectrum.wave_number, 5)
    assert combined_spectrum.density[is_reliable] == pytest.approx(expected[is_reliable], rel=BIN_TOLERANCE)
    joined_roughness, true_roughness = (
        combined_spectrum.roughness(),
        scale_dependent_roughness(complete_surface, periodic=True),
    )
    for length in (0.3, 0.15, 0.1):
        assert float(joined_roughness.gradient_at(length)) == pytest.approx(
            float(true_roughness.gradient_at(length)), rel=0.05
        )
    assert combined_spectrum.reasons == ("pixels",) * 5
    assert combined_spectrum.bands[0] == pytest.approx((0.64, 1024 * SPACING / 3))
    assert combined_spectrum.contribution.sum(axis=0) == pytest.approx(np.ones(combined_spectrum.count.size))
    assert (combined_spectrum.contribution[0, combined_spectrum.wave_number > 2 * np.pi / 0.5] == 0).all()
    assert np.all(np.abs(np.log(combined_spectrum.disagreement)) < 0.4)


def test_joined_spectrum_reports_a_disagreement_if_one_scan_is_miscalibrated(complete_surface):
    scans = scans_of_instruments(complete_surface)
    miscalibrated_spectrum = joined_spectrum([Surface(2 * scans[0].heights, spacing=scans[0].spacing), *scans[1:]])
    # The spectrum is proportional to the square of the heights, so its ratio is about 4.
    assert 2.5 < miscalibrated_spectrum.disagreement[0] < 6
    assert np.log(miscalibrated_spectrum.disagreement[0]) > 2 * miscalibrated_spectrum.chance[0]
    joined_with_small_piece = joined_spectrum([scans[0], Surface(scans[1].heights[:256, :256], spacing=SPACING)])
    # A small piece contains few of the common wavelengths, so its expected scatter is larger.
    assert joined_with_small_piece.chance[1] > miscalibrated_spectrum.chance[0]
    single_scan_spectrum = joined_spectrum(scans[:1])
    assert np.isnan(single_scan_spectrum.chance).all()
    assert math.isnan(single_scan_spectrum.disagreement[0])
    assert (single_scan_spectrum.ratio == pytest.approx(1.0)) or np.isnan(single_scan_spectrum.ratio).any()


def test_joined_spectrum_excludes_wavelengths_limited_by_tip_or_noise(complete_surface):
    coarse_scan, fine_scan = scans_of_instruments(complete_surface, noise=0.02)[:2]
    joined_with_blunt_tip = joined_spectrum([coarse_scan, fine_scan], tip_radii=[None, 0.05])
    assert joined_with_blunt_tip.reasons[1] == "tip"
    curvature = scale_dependent_roughness(fine_scan).curvature_at(joined_with_blunt_tip.bands[1][0] * 1.2)
    assert float(curvature) < 0.1 / 0.05
    assert joined_spectrum([coarse_scan], per_decade=8).reasons == ("noise floor",)
    arguments = joined_spectrum([fine_scan], shortest_wavelengths=[0.5])
    assert arguments.bands[0][0] == 0.5
    assert arguments.reasons == ("given",)


def test_joined_spectrum_is_positive_at_wavelengths_between_the_bands_of_the_scans(complete_surface):
    coarse_scan, fine_scan = scans_of_instruments(complete_surface)[:2]
    combined_spectrum = joined_spectrum([coarse_scan, fine_scan], shortest_wavelengths=[1.5, None], per_decade=20)
    joined_with_gap = joined_spectrum([coarse_scan, fine_scan], shortest_wavelengths=[2.5, None], per_decade=10)
    assert (combined_spectrum.density > 0).all()
    gaps = joined_with_gap.count == 0
    assert (joined_with_gap.contribution[:, gaps] == 0).all()
    assert (np.diff(combined_spectrum.wave_number) > 0).all()


def test_joined_profiles_are_treated_as_sections_of_an_isotropic_surface(complete_surface):
    lines = [Profile(complete_surface.heights[row], spacing=SPACING) for row in (0, 300, 600, 900)]
    joined = joined_spectrum(lines, per_decade=5)
    true_roughness = scale_dependent_roughness(complete_surface, periodic=True)
    assert float(joined.roughness().gradient_at(0.1)) == pytest.approx(float(true_roughness.gradient_at(0.1)), rel=0.3)


def test_surface_generated_from_a_joined_spectrum_has_this_spectrum(complete_surface):
    joined = joined_spectrum(scans_of_instruments(complete_surface))
    body = joined.surface(3, shape=(512, 512), spacing=0.04)
    repeated_body = joined.surface(3, shape=(512, 512), spacing=0.04)
    assert np.array_equal(body.heights, repeated_body.heights)
    assert not np.array_equal(body.heights, joined.surface(3, shape=(512, 512), spacing=0.04, side="upper").heights)
    created_roughness = scale_dependent_roughness(body, periodic=True)
    assert float(created_roughness.gradient_at(0.2)) == pytest.approx(
        float(joined.roughness().gradient_at(0.2)), rel=0.08
    )
    assert body.history == (*joined.history, "a random surface of this spectrum, seed 3, repetition 0")
    assert "scan 5" in body.history[0]


@pytest.mark.parametrize(
    ("scans", "options", "message"),
    [
        ([], {}, "scans must contain at least one"),
        (None, {"tip_radii": [1.0, 2.0]}, "tip_radii must have one entry for each of the 1 scans, got 2"),
        (None, {"shortest_wavelengths": [-1.0]}, "shortest_wavelengths must be a finite number above 0 µm"),
        (None, {"shortest_wavelengths": [50.0]}, "has none: reliable wavelengths are above 50 µm"),
        (None, {"names": []}, "names must have one entry for each of the 1 scans, got 0"),
        (None, {"per_decade": 2}, "per_decade must be a whole number of at least 4"),
        ([Surface(np.ones((9, 9)), spacing=1.0)], {}, "surface must not be flat"),
    ],
)
def test_joined_spectrum_rejects_invalid_arguments(complete_surface, scans, options, message):
    with pytest.raises(ValueError, match=message):
        joined_spectrum([complete_surface] if scans is None else scans, **options)
