"""Tests of R- and W-parameters: closed forms of sinusoids, slow definitions, setting classes and rejected input."""

import math

import numpy as np
import pytest
from reference import roughness as reference_roughness
from reference.gaussian_filters import mean_line
from stiction import Profile, levelled, section_parameters, self_affine
from stiction.surfaces.parameters import PROFILE_PARAMETERS
from stiction.surfaces.profile_elements import mean_profile_element

ROUND_OFF = 1e-10


def sinusoid(wavelength, amplitude=1.0, *, waves=40, points=100, phase=0.3):
    """Return a sinusoid over whole periods with any phase. Heights and lengths are in µm."""
    x = np.arange(waves * points) / points
    return Profile(amplitude * np.sin(2 * np.pi * x + phase), spacing=wavelength / points)


def ground_profile(seed=1, points=4500, spacing=0.5):
    """Return the profile of a ground surface with some waviness."""
    rough_profile = self_affine(
        seed, hurst_exponent=0.7, rms=0.3, points=points, spacing=spacing, longest_wavelength=60.0
    )
    x = spacing * np.arange(points)
    return levelled(Profile(rough_profile.heights + 0.5 * np.cos(2 * np.pi * x / 1000), spacing=spacing), "line")


class TestSectionsOfSinusoid:
    @pytest.mark.parametrize("ratio", [0.1, 0.25, 1.0])
    def test_roughness_parameters_of_a_sinusoid_equal_closed_forms(self, ratio):
        # After the L-filter the amplitude is A (1 - t) with the transmission t = exp(-π (α λc/λ)²).
        wavelength = 800 * ratio
        # The profile has fifteen sections of whole periods, so its ends do not influence the five middle sections.
        computed_parameters = section_parameters(
            sinusoid(wavelength, 2.0, waves=round(15 / ratio), points=400), lc=800, ls=0
        )
        amplitude = 2.0 * (1 - math.exp(-math.pi * math.log(2) / math.pi / ratio**2))
        tolerance = 1e-4  # relative error of heights at 400 points per wavelength
        assert computed_parameters.Ra == pytest.approx(2 * amplitude / math.pi, rel=tolerance)
        assert computed_parameters.Rq == pytest.approx(amplitude / math.sqrt(2), rel=tolerance)
        assert computed_parameters.Rz == pytest.approx(2 * amplitude, rel=tolerance)
        assert computed_parameters.Rdq == pytest.approx(
            2 * math.pi / wavelength * amplitude / math.sqrt(2), rel=3e-3
        )  # The tolerance is larger, because the slope is not computed at six points.
        assert computed_parameters.Rku == pytest.approx(1.5, rel=tolerance)
        assert computed_parameters.RSm == pytest.approx(wavelength, rel=tolerance)
        assert computed_parameters.Rc == pytest.approx(2 * amplitude, rel=tolerance)
        assert computed_parameters.Rmr == pytest.approx(0.5, abs=0.002)
        assert computed_parameters.Rdc == pytest.approx(2 * amplitude * math.cos(math.pi * 0.2), rel=0.002)

    def test_s_filter_halves_the_amplitude_of_a_sinusoid_with_the_nesting_index_as_wavelength(self):
        computed_parameters = section_parameters(sinusoid(8.0, waves=700), lc=800, ls=8)
        assert computed_parameters.Ra == pytest.approx(0.5 * 2 / math.pi, rel=2e-3)

    def test_waviness_of_a_sinusoid_with_the_cutoff_wavelength_has_half_the_amplitude(self):
        computed_parameters = section_parameters(sinusoid(800.0, waves=40), lc=800, ls=0)
        assert computed_parameters.Wq == pytest.approx(0.5 / math.sqrt(2), rel=0.02)
        assert computed_parameters.WSm == pytest.approx(800, rel=0.01)
        assert computed_parameters.Wc == pytest.approx(1.0, rel=0.05)


@pytest.fixture(scope="module")
def profile():
    return ground_profile(points=900)


@pytest.fixture(scope="module")
def reference_heights(profile):
    """Return roughness in the evaluation length, and waviness, by slow filters with λs = 4 µm and λc = 80 µm."""
    primary = mean_line(profile.heights, 0.5, 4.0)
    waviness = mean_line(primary, 0.5, 80.0)
    return (primary - waviness)[50:850].tolist(), waviness.tolist()


@pytest.fixture(scope="module")
def computed_parameters(profile):
    return section_parameters(profile, lc=80, ls=4)


class TestSectionParameterDefinitions:
    def test_evaluation_length_is_five_sections_in_the_middle_of_the_profile(self, computed_parameters):
        assert (
            computed_parameters.filters.start,
            computed_parameters.filters.stop,
            computed_parameters.filters.sections,
        ) == (50, 850, 5)

    def test_roughness_parameters_equal_their_definitions(self, reference_heights, computed_parameters):
        z = reference_heights[0]
        mean_peak_height, mean_pit_depth = reference_roughness.mean_section_extremes(z, 5)
        spacing, mean_element_height = reference_roughness.mean_profile_element(z, mean_peak_height, mean_pit_depth)
        expected = reference_roughness.height_parameters(z, 0.5) | reference_roughness.stratified_parameters(z)
        expected |= {
            "p": mean_peak_height,
            "v": mean_pit_depth,
            "z": mean_peak_height + mean_pit_depth,
            "Sm": 0.5 * spacing,
            "c": mean_element_height,
        }
        expected |= {
            "mr": reference_roughness.material_ratio_at_height(z, 0),
            "dc": reference_roughness.height_at_material_ratio(z, 0.2)
            - reference_roughness.height_at_material_ratio(z, 0.8),
        }
        assert sorted(f"R{suffix}" for suffix in expected) == sorted(
            parameter.name for parameter in PROFILE_PARAMETERS["R"]
        )
        for suffix, value in expected.items():
            # The slow filter samples the Gaussian with eight points at λs. Ratios change by whole points.
            tolerance = {"abs": 2 / 800} if suffix.startswith("mr") else {"rel": 2e-4, "abs": 2e-4}
            assert getattr(computed_parameters, f"R{suffix}") == pytest.approx(value, **tolerance), suffix

    def test_waviness_parameters_equal_their_definitions(self, reference_heights, computed_parameters):
        z = reference_heights[1]
        spacing, mean_element_height = reference_roughness.mean_profile_element(z, max(z), -min(z))
        expected = reference_roughness.height_parameters(z, 0.5) | {"Sm": 0.5 * spacing, "c": mean_element_height}
        for suffix, value in expected.items():
            assert getattr(computed_parameters, f"W{suffix}") == pytest.approx(value, rel=2e-4, abs=1e-6), suffix


def test_small_hills_and_dales_are_not_counted_as_profile_elements():
    # A dale with a depth of 5 % between two hills does not end an element.
    wave = np.concatenate([np.sin(np.linspace(0, np.pi, 50)), [-0.05], np.sin(np.linspace(0, np.pi, 50))])
    heights = np.concatenate([wave, -wave] * 4)
    assert mean_profile_element(heights, 1.0, 1.0)[0] == pytest.approx(202, rel=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_profile_elements_are_invariant_under_reversal_and_flip(seed):
    heights = ground_profile(seed).heights
    original_element = mean_profile_element(heights, 0.5, 0.7)
    assert mean_profile_element(heights[::-1], 0.5, 0.7) == pytest.approx(original_element, rel=1e-9)
    assert mean_profile_element(-heights, 0.7, 0.5) == pytest.approx(original_element, rel=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_mean_width_of_profile_elements_agrees_with_the_reference_implementation(seed):
    heights = ground_profile(seed, points=1500).heights
    assert mean_profile_element(heights, 0.5, 0.7) == pytest.approx(
        reference_roughness.mean_profile_element(heights, 0.5, 0.7), rel=1e-9
    )


class TestSettingClass:
    @pytest.mark.parametrize(
        ("amplitude", "wavelength", "name", "lc", "ls"),
        [
            (0.01, 20.0, "Sc1", 80, 2.5), (0.01, 60.0, "Sc2", 250, 2.5), (0.1, 20.0, "Sc2", 250, 2.5),
            (1.0, 20.0, "Sc3", 800, 2.5), (0.01, 390.0, "Sc3", 800, 2.5), (5.0, 20.0, "Sc4", 2500, 8),
            (30.0, 20.0, "Sc5", 8000, 25),
        ],
    )  # fmt: skip
    def test_settings_class_for_section_parameters_is_chosen_from_ra_and_rsm(self, amplitude, wavelength, name, lc, ls):
        x = 0.5 * np.arange(20_000)
        profile = Profile(amplitude * np.sin(2 * np.pi * x / wavelength), spacing=0.5)
        computed_parameters = section_parameters(profile).filters
        assert (computed_parameters.lc, computed_parameters.ls, computed_parameters.reason[:3]) == (lc, ls, name)

    def test_profile_on_a_coarse_grid_has_no_s_filter(self):
        x = 5.0 * np.arange(2000)
        assert section_parameters(Profile(np.sin(2 * np.pi * x / 100), spacing=5.0)).filters.ls is None

    def test_short_profile_is_evaluated_over_fewer_sections(self):
        computed_parameters = section_parameters(sinusoid(50.0, waves=39), lc=800)
        assert computed_parameters.filters.sections == 2
        assert computed_parameters.filters.stop - computed_parameters.filters.start == 3200

    def test_robust_filter_is_affected_less_by_a_groove_than_the_linear_filter(self):
        profile = ground_profile(points=3000)
        heights = profile.heights.copy()
        heights[1500:1560] -= 20
        grooved_profile = Profile(heights, spacing=0.5)
        linear_parameters, robust_parameters = (
            section_parameters(grooved_profile, lc=250, robust=value) for value in (False, True)
        )
        parameters_without_groove = section_parameters(profile, lc=250)
        assert abs(robust_parameters.Rp - parameters_without_groove.Rp) < 0.2 * abs(
            linear_parameters.Rp - parameters_without_groove.Rp
        )

    @pytest.mark.parametrize("points_per_cutoff", [4, 5, 5.84])
    def test_s_filter_at_short_cutoffs_gives_the_mean_line_of_a_spiked_profile(self, points_per_cutoff):
        heights = ground_profile(points=900).heights.copy()
        heights[::61] -= 2.0
        ls = 0.5 * points_per_cutoff
        computed_parameters = section_parameters(Profile(heights, spacing=0.5), lc=80, ls=ls)
        primary = mean_line(heights, 0.5, ls)
        z = (primary - mean_line(primary, 0.5, 80.0))[50:850]
        assert computed_parameters.Rt == pytest.approx(np.ptp(z), rel=ROUND_OFF)
        assert computed_parameters.Rsk == pytest.approx(np.mean(z**3) / np.mean(z**2) ** 1.5, rel=ROUND_OFF)

    def test_missing_points_do_not_affect_the_waviness(self):
        profile, is_missing = ground_profile(points=3000), np.zeros(3000, bool)
        is_missing[1400:1403] = True
        heights = np.where(is_missing, 50.0, profile.heights)
        computed_parameters = section_parameters(Profile(heights, spacing=0.5, missing=is_missing), lc=250)
        assert computed_parameters.Wt == pytest.approx(section_parameters(profile, lc=250).Wt, rel=0.05)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, r"one section length is 80 µm, and the profile is 50 µm long: measure a longer one"),
        ({"lc": 60.0}, "one section length is 60 µm"),
        ({"lc": 2.0}, r"lc must be at least 3.5 µm \(7 points\), got 2 µm"),
        ({"lc": -1.0}, "lc must be a finite number above 0 µm"),
        ({"lc": 40.0, "ls": 0.7}, r"ls must be 0, or between 1 µm \(two grid spacings\) and 40 µm \(lc\), got 0.7 µm"),
        ({"lc": 40.0, "ls": 41.0}, "ls must be 0, or between 1 µm"),
        ({"lc": 40.0, "ls": -2.0}, "ls must be"),
        ({"lc": 40.0, "sections": 0}, "sections must be a whole number of at least 1"),
    ],
)
def test_section_parameters_reject_invalid_arguments(options, message):
    with pytest.raises(ValueError, match=message):
        section_parameters(Profile(np.sin(np.arange(100.0)), spacing=0.5), **options)


def test_section_parameters_reject_profiles_that_are_too_coarse_or_too_short():
    x = 50.0 * np.arange(1000)
    with pytest.raises(ValueError, match=r"^Ra .* require a section length of 250 µm; its points are 50 µm apart"):
        section_parameters(Profile(0.05 * np.sin(2 * np.pi * x / 110), spacing=50.0))
    with pytest.raises(ValueError, match=r"^its points are 2000 µm apart, and a section needs at least 7"):
        section_parameters(Profile(np.sin(x), spacing=2000.0))
    assert section_parameters(Profile(np.sin(2 * np.pi * x / 800), spacing=50.0)).filters.reason.startswith("Sc")
    with pytest.raises(ValueError, match=r"^Ra .* require a section length of 8000 µm; the profile is 2000 µm long"):
        section_parameters(Profile(20 * np.sin(np.arange(4000) / 20), spacing=0.5))


def test_section_parameters_reject_a_flat_profile():
    with pytest.raises(ValueError, match="flat"):
        section_parameters(Profile(np.ones(1000), spacing=0.5))


def test_section_roughness_of_a_straight_profile_is_zero():
    computed_parameters = section_parameters(Profile(np.linspace(-1, 1, 1000), spacing=0.5), lc=80)
    assert computed_parameters.Ra < 1e-9


def test_section_parameters_reject_a_negative_nesting_index():
    with pytest.raises(ValueError, match="ls must be 0 or above, got -1"):
        section_parameters(sinusoid(8.0, waves=700), lc=800, ls=-1)
