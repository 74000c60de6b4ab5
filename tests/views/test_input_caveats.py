"""Tests of caveats about inputs; each caveat has a case with it and a case without it."""

import re
from typing import ClassVar

import numpy as np
import pytest
from stiction import (
    Profile,
    Surface,
    compare_repeated_scans,
    cut_off,
    flipped,
    instrument_limit,
    interface,
    levelled,
    pair,
    scale_dependent_roughness,
    self_affine,
)
from stiction.study.measured_bodies import MeasuredBodySettings
from stiction.study.study_description import get_pair_name
from stiction.summary.input_caveats import (
    MAX_PARABOLA_HEIGHT_FRACTION,
    MAX_PLAUSIBLE_MU0,
    MAX_PRESSURE_OVER_MODULUS,
    MIN_SPIKE_SHARPNESS_RATIO,
    find_alternatives,
    find_input_caveats,
    find_scan_caveats,
)
from stiction.surfaces.hidden_noise import find_hidden_noise
from support.machined_surfaces import MACHINED_SURFACES, scale_to_unit_rms
from support.rough_surfaces import rough_maps, self_affine_map
from support.studies_of_files import pair_study
from support.synthetic_results import measured_study

pytestmark = pytest.mark.usefixtures("no_contact_pictures")


@pytest.fixture(autouse=True)
def ignore_caveats_of_files(monkeypatch):
    """Ignore caveats of scan files, because the files of `measured_study` do not exist."""
    monkeypatch.setattr(MeasuredBodySettings, "caveats", ())


@pytest.fixture(scope="module")
def rough_profile():
    return self_affine(1, hurst_exponent=0.8, rms=0.05, points=2000, spacing=0.05, longest_wavelength=5.0)


def find_caveat_texts(upper, lower, *, mu0=(0.2,), loads=()):
    return [caveat.text for caveat in find_input_caveats(upper, lower, measured_study(mu0=mu0), loads)]


def test_height_range_that_is_large_for_the_scan_length_adds_a_caveat(rough_profile):
    tall_profile = Profile(rough_profile.heights * 1000, spacing=rough_profile.spacing)
    assert any(text.startswith("upper: heights span") for text in find_caveat_texts(tall_profile, rough_profile))
    heights = np.outer(np.hanning(8), np.hanning(8))
    surface = Surface(heights / heights.max(), spacing=1.0)
    assert find_caveat_texts(surface, surface) == []
    assert find_caveat_texts(Surface(10 * surface.heights, spacing=1.0), surface) == [
        "upper: heights span 10 µm on a length of 8 µm"
    ]
    tall_profile = Profile(rough_profile.heights * 1e6, spacing=rough_profile.spacing)
    caveats = find_input_caveats(tall_profile, rough_profile, measured_study())
    assert [caveat.severity for caveat in caveats if "heights span" in caveat.text] == ["fault"]


def test_form_error_of_a_profile_adds_a_caveat_unless_the_form_is_removed(rough_profile):
    x = np.linspace(-1, 1, 2000)
    for curvature_height, has_caveat in ((1.0, True), (0.01, False)):
        curved_profile = Profile(rough_profile.heights + curvature_height * x**2, spacing=rough_profile.spacing)
        assert (
            any(
                "lower: form (a parabola) contributes" in text
                for text in find_caveat_texts(rough_profile, curved_profile)
            )
            == has_caveat
        )
    assert 0 < MAX_PARABOLA_HEIGHT_FRACTION < 1
    curved_profile = Profile(rough_profile.heights + x**2, spacing=rough_profile.spacing)
    study = measured_study()
    study = study.with_changes({"surfaces.level": "quadratic"})  # a quadratic fit removes the parabola
    assert find_input_caveats(rough_profile, curved_profile, study) == ()


@pytest.mark.parametrize(
    ("name", "has_caveat"), [("rock on rock, below 200 MPa", True), ("MoS2 on bearing steel, dry air", False)]
)
def test_interface_adds_a_caveat_only_if_the_ranges_of_mu0_and_tau0_are_unknown(rough_profile, name, has_caveat):
    study = pair_study(
        rough_profile, rough_profile, effective_modulus="10 GPa", load="1 MPa", interface=name, mechanics="asperities"
    )
    texts = [caveat.text for caveat in find_input_caveats(rough_profile, rough_profile, study)]
    assert any("does not include the uncertainty of μ0 and τ0" in text for text in texts) == has_caveat
    assert interface(name).has_unknown_range == has_caveat


def test_spikes_of_a_profile_add_a_caveat_that_states_the_number_of_spikes(rough_profile):
    heights = rough_profile.heights.copy()
    heights[[500, 1200]] += 2 * MIN_SPIKE_SHARPNESS_RATIO * np.abs(np.diff(heights, 2)).max()
    caveats = find_caveat_texts(Profile(heights, spacing=rough_profile.spacing), rough_profile)
    assert [text for text in caveats if "as sharp as usual" in text] == [
        "upper: 2 points are more than 12 times as sharp as usual, and would come into contact first"
    ]


@pytest.mark.parametrize("points", [[0], [-1], [700, 701, 702]], ids=["first point", "last point", "three points"])
def test_spikes_at_profile_ends_and_spikes_of_several_points_add_a_caveat(rough_profile, points):
    heights = rough_profile.heights.copy()
    heights[points] += 6 * heights.std()
    caveats = find_scan_caveats(Profile(heights, spacing=rough_profile.spacing))
    assert any("as sharp as usual" in caveat.text for caveat in caveats)


@pytest.mark.parametrize("kind", [kind for kind in MACHINED_SURFACES if kind != "milled"])
def test_cusps_of_machined_profiles_are_not_reported_as_spikes(kind):
    for seed in range(3):
        heights = 0.02 * scale_to_unit_rms(MACHINED_SURFACES[kind](np.random.default_rng(seed), 1))
        assert not any(
            "as sharp as usual" in caveat.text for caveat in find_scan_caveats(Profile(heights, spacing=0.1))
        )


@pytest.mark.parametrize("kind", MACHINED_SURFACES)
def test_spikes_of_a_map_add_a_caveat_that_states_the_number_of_spikes(kind):
    rng = np.random.default_rng(1)
    heights = 0.02 * scale_to_unit_rms(MACHINED_SURFACES[kind](rng, 2))

    def find_spike_caveats(heights):
        caveats = find_scan_caveats(Surface(heights, spacing=0.1))
        return [caveat for caveat in caveats if "outliers mask" in caveat.remedy]

    assert find_spike_caveats(heights) == []
    heights[[5, 40, 41, 90], [7, 60, 60, 127]] += 0.3
    (caveat,) = find_spike_caveats(heights)
    assert caveat.severity == "caution"
    assert "4 points are more than 6 rms heights from their neighbours" in caveat.text


def test_caveat_that_applies_to_both_scans_is_listed_once(rough_profile):
    tall_profile = Profile(rough_profile.heights * 1000, spacing=rough_profile.spacing)
    caveats = find_caveat_texts(tall_profile, tall_profile)
    assert len(caveats) == len(set(caveats))
    assert all(text.startswith("both scans: ") for text in caveats)


def test_implausibly_large_mu0_and_loads_add_caveats(rough_profile):
    assert (
        find_caveat_texts(
            rough_profile,
            rough_profile,
            mu0=(MAX_PLAUSIBLE_MU0,),
            loads=[0.9 * MAX_PRESSURE_OVER_MODULUS * 100 * rough_profile.extent],
        )
        == []
    )
    assert "μ0 = 30" in find_caveat_texts(rough_profile, rough_profile, mu0=(0.2, 30.0))[0]
    load = 1.1 * MAX_PRESSURE_OVER_MODULUS * 100 * rough_profile.extent
    assert "above a tenth of E*" in find_caveat_texts(rough_profile, rough_profile, loads=[load])[0]


def test_noise_and_spectral_lines_add_caveats_unless_unfiltered_scans_are_accepted():
    rng = np.random.default_rng(5)
    clean_profile = self_affine(1, hurst_exponent=0.8, rms=0.05, points=4096, spacing=0.01, shortest_wavelength=0.5)
    noisy_profile = Profile(clean_profile.heights + 2e-4 * rng.normal(size=4096), spacing=0.01)
    profile_with_line = Profile(clean_profile.heights + 5e-4 * np.sin(2 * np.pi * np.arange(4096) / 8), spacing=0.01)
    for profile, expected_words in ((noisy_profile, "as for noise"), (profile_with_line, "has a line")):
        caveat = next(
            other_caveat
            for other_caveat in find_input_caveats(profile, profile, measured_study())
            if expected_words in other_caveat.text
        )
        limit = instrument_limit(profile)
        assert caveat.cut_off == limit.cut_off < limit.noise < 0.6
        assert caveat.severity == ("fault" if limit.slope_fraction > 0.1 else "caution")
        study_without_filter = measured_study().with_changes({"surfaces.vouched": True})
        assert not any(
            expected_words in other_caveat.text
            for other_caveat in find_input_caveats(profile, profile, study_without_filter)
        )
    profile_with_faint_noise = Profile(
        clean_profile.heights + 1e-5 * np.random.default_rng(1).normal(size=4096), spacing=0.01
    )
    assert instrument_limit(profile_with_faint_noise).reason == "noise floor"
    assert not any(
        "like noise" in text for text in find_caveat_texts(profile_with_faint_noise, profile_with_faint_noise)
    )
    assert any("of the mean square slope" in text for text in find_caveat_texts(noisy_profile, noisy_profile))


def test_noise_caveat_suggests_no_cutoff_above_a_third_of_the_scan_length():
    noise_profile = Profile(0.1 * np.random.default_rng(2).normal(size=960), spacing=0.5)
    short_profile = self_affine(3, points=200, spacing=0.5, hurst_exponent=0.7, rms=0.01, shortest_wavelength=5.0)
    cutoff = instrument_limit(noise_profile).cut_off
    assert short_profile.extent / 3 < cutoff < noise_profile.extent / 3
    (remedy,) = (
        caveat.remedy
        for caveat in find_input_caveats(noise_profile, short_profile, measured_study())
        if "noise" in caveat.text
    )
    assert "--cutoff '" not in remedy
    assert "33.3 µm" in remedy
    with pytest.raises(ValueError, match=r"cutoff must be .*33.3333 µm"):
        pair(noise_profile, short_profile, load="10 MPa", mu0=0.2, effective_modulus="80 GPa", cutoff=f"{cutoff:g} um")


def test_wavelengths_that_the_tip_does_not_resolve_add_a_caveat():
    scan = self_affine(
        3, points=3000, spacing=0.01, hurst_exponent=0.7, rms=0.01, longest_wavelength=5.0, shortest_wavelength=0.05
    )
    options = {"load": "10 MPa", "mu0": 0.2, "effective_modulus": "80 GPa"}
    study = pair_study(scan, scan, tip="20 um", **options)
    assert instrument_limit(scan, tip_radius=20.0).reason == "tip"
    # The scan is not filtered, because a filter would also smooth the surface where the tip has smoothed it already.
    assert study.surfaces.cell_coordinates()["cut_off"].tolist() == [0.0]
    (caveat,) = find_input_caveats(scan, scan, study)
    assert "does not resolve: the surface is steeper" in caveat.text
    assert "interval does not include" in caveat.interval_note
    assert instrument_limit(scan, tip_radius=20.0).slope_fraction > 0.1
    # The caveat is a fault, because elastic results do not converge at short wavelengths.
    assert caveat.severity == "fault"
    plastic_study = study.with_changes({"contact.mechanics": "half-space", "contact.hardness": "2 GPa"})
    (plastic_caveat,) = find_input_caveats(scan, scan, plastic_study)
    assert plastic_caveat.severity == "caution"
    assert plastic_caveat.interval_note == ""  # the range for finer scans already allows for steeper surfaces
    noisy_scan = Profile(scan.heights + 1e-3 * np.random.default_rng(1).normal(size=3000), spacing=0.01)
    study = pair_study(noisy_scan, noisy_scan, tip="20 um", **options)
    assert study.surfaces.cell_coordinates()["cut_off"].tolist() == [instrument_limit(noisy_scan).cut_off, 0.0]
    caveats = find_input_caveats(noisy_scan, noisy_scan, study)
    assert [
        plastic_caveat.severity for plastic_caveat in caveats if "of the mean square slope" in plastic_caveat.text
    ] == ["caution", "fault"]
    with pytest.raises(ValueError, match="tip"):
        pair_study(scan, scan, tip="20", **options)


@pytest.mark.parametrize("options", [{"cutoff": "200 nm"}, {}])
def test_fraction_of_the_slope_that_the_tip_does_not_resolve_is_computed_from_filtered_scans(options):
    noise = np.random.default_rng(1).normal(size=(2, 3000))
    clean_profile = self_affine(
        3, points=3000, spacing=0.01, hurst_exponent=0.8, rms=0.005, longest_wavelength=5.0, shortest_wavelength=0.1
    )
    scans = [Profile(clean_profile.heights + 3e-4 * noise_heights, spacing=0.01) for noise_heights in noise]
    study = pair_study(*scans, tip="2 um", load="10 MPa", mu0=0.2, effective_modulus="80 GPa", **options)
    cutoff = study.surfaces.reported_cut_off()
    own_cutoffs = [
        min(cutoff, float(body.max_cut_off or cutoff)) for body in (study.surfaces.upper, study.surfaces.lower)
    ]
    filtered_scans = [cut_off(scan, own_cutoff) for scan, own_cutoff in zip(scans, own_cutoffs, strict=True)]
    expected_percentages = [
        f"{100 * instrument_limit(scan, tip_radius=2.0).slope_fraction:.0f}" for scan in filtered_scans
    ]
    unfiltered_percentages = [f"{100 * instrument_limit(scan, tip_radius=2.0).slope_fraction:.0f}" for scan in scans]
    assert expected_percentages != unfiltered_percentages
    texts = [caveat.text for caveat in find_input_caveats(*scans, study) if "does not resolve" in caveat.text]
    assert " ".join(texts).count("%") == len(texts)
    assert all(any(percentage in text for text in texts) for percentage in expected_percentages)


def test_noise_caveat_states_the_noise_fraction_that_a_given_cutoff_leaves():
    clean_profile = self_affine(
        97, points=8000, spacing=0.25, longest_wavelength=60.0, shortest_wavelength=2.0, hurst_exponent=0.8, rms=0.25
    )
    rng = np.random.default_rng(1)
    scans = [Profile(clean_profile.heights + rng.normal(0, 0.005, 8000), spacing=0.25) for _ in range(2)]
    comparison = compare_repeated_scans(*scans)
    options = {"load": "10 MPa", "mu0": 0.2, "effective_modulus": "80 GPa"}
    for scan, cutoff, expected_severity in (
        (scans[0], "130 nm", "fault"), (scans[0], "500 nm", "fault"),
        (comparison.scan, f"{comparison.limit} um", "caution"),
    ):  # fmt: skip
        assert instrument_limit(scan).matters
        study = pair_study(scan, scan, cutoff=cutoff, **options)
        (caveat,) = (caveat for caveat in find_input_caveats(scan, scan, study) if "spectrum is flat" in caveat.text)
        assert caveat.severity == expected_severity
        noise = Profile(scan.heights - clean_profile.heights[: scan.heights.size], spacing=0.25)
        filter_length = study.surfaces.reported_cut_off()
        if scan is scans[0]:
            gradients = [
                scale_dependent_roughness(cut_off(profile, filter_length)).gradient[-1] for profile in (noise, scan)
            ]
            percentage = float(re.search(r"(\d+) %", caveat.text)[1])
            assert percentage == pytest.approx(100 * (gradients[0] / gradients[1]) ** 2, abs=2)


def test_tip_radius_adds_no_caveat_if_the_filter_removes_all_wavelengths_that_the_tip_does_not_resolve():
    scan = self_affine(
        3, points=3000, spacing=0.01, hurst_exponent=0.7, rms=0.01, longest_wavelength=5.0, shortest_wavelength=0.05
    )
    options = {"tip": "500 nm", "load": "10 MPa", "mu0": 0.2, "effective_modulus": "80 GPa"}
    for cutoff, expected_alternatives in (("5 nm", ["tip"]), ("1 um", [])):
        study = pair_study(scan, scan, cutoff=cutoff, **options)
        texts = [caveat.text for caveat in find_input_caveats(scan, scan, study)]
        assert [name for name in find_alternatives(study) if name == "tip"] == expected_alternatives
        assert any("does not resolve" in text for text in texts) == bool(expected_alternatives)


class TestNoiseHiddenByRoughness:
    """White noise in maps whose spectra have no flat end."""

    options: ClassVar[dict[str, str]] = {"load": "10 MPa", "mu0": "0.2", "effective_modulus": "80 GPa"}

    @staticmethod
    def create_maps_with_noise(noise, shortest=None):
        """Return two maps with white noise, whose rms is given relative to the rms roughness."""
        maps = rough_maps(
            1,
            hurst_exponent=0.7,
            rms=0.02,
            points=96,
            spacing=0.1,
            longest_wavelength=9.6,
            shortest_wavelength=shortest,
        )
        rng = np.random.default_rng(1)
        return [Surface(surface.heights + noise * 0.02 * rng.normal(size=(96, 96)), spacing=0.1) for surface in maps]

    def test_suspected_noise_adds_a_result_for_filtered_scans(self):
        noisy_maps = self.create_maps_with_noise(0.1)
        assert [instrument_limit(noisy_map).reason for noisy_map in noisy_maps] == ["pixels", "pixels"]
        study = pair_study(*noisy_maps, **self.options)
        cutoff = max(find_hidden_noise(noisy_map).cut_off for noisy_map in noisy_maps)
        assert study.surfaces.both_readings
        assert study.surfaces.cell_coordinates()["cut_off"].tolist() == [0.0, cutoff]
        caveats = [caveat for caveat in find_input_caveats(*noisy_maps, study) if "may contribute" in caveat.text]
        assert {caveat.severity for caveat in caveats} == {"caution"}
        assert all(caveat.has_second_cutoff for caveat in caveats)
        for changes in ({"cutoff": "none"}, {"texture": "ground"}):
            study = pair_study(*noisy_maps, **self.options, **changes)
            assert study.surfaces.cell_coordinates()["cut_off"].tolist() == [0.0]
            assert find_input_caveats(*noisy_maps, study) == ()

    def test_noise_of_each_scan_is_removed_at_its_own_cutoff(self):
        rough_map, smooth_map = self.create_maps_with_noise(0.1)[0], self.create_maps_with_noise(0.1, shortest=0.8)[1]
        limits = instrument_limit(smooth_map), find_hidden_noise(rough_map)
        assert limits[0].origin == "instrument"
        study = pair_study(rough_map, smooth_map, **self.options)
        assert study.surfaces.cell_coordinates()["cut_off"].tolist() == [max(limit.cut_off for limit in limits), 0.0]
        assert study.surfaces.upper.select_cut_off_of_scan(np.inf) == pytest.approx(limits[1].cut_off, rel=1e-12)
        assert study.surfaces.lower.select_cut_off_of_scan(np.inf) == pytest.approx(limits[0].cut_off, rel=1e-12)

    def test_maps_without_noise_are_pressed_only_unfiltered(self):
        study = pair_study(*self.create_maps_with_noise(0.0), **self.options)
        assert study.surfaces.cell_coordinates()["cut_off"].tolist() == [0.0]
        assert study.surfaces.both_readings is None

    def test_pair_interval_contains_the_filtered_and_the_unfiltered_result(self):
        result = pair(*self.create_maps_with_noise(0.1), **self.options, tau0="100 MPa", shifts=4, onset=0)
        unfiltered_point, filtered_point = result.summary().points
        assert (unfiltered_point.at["cut_off"], filtered_point.covered) == (0.0, True)
        assert result.value == unfiltered_point.value < filtered_point.value
        assert result.interval[1] == pytest.approx(filtered_point.upper, rel=1e-9)
        assert result.interval[1] > result.interval_of_mean[1]


def test_caveats_of_a_single_gap_do_not_mention_two_scans(tmp_path):
    heights = rough_maps(1, points=40)[0].heights.copy()
    heights[5, 5] += 15 * heights.std()
    heights[15:25, 15:25] = np.nan
    np.save(tmp_path / "gap.npy", heights)
    options = {"load": "20 MPa", "mu0": 0.2, "tau0": "100 MPa", "effective_modulus": "80 GPa", "onset": 0}
    options |= {"unit": "um", "spacing": "0.1 um", "missing": "interpolate", "cutoff": "none", "direction": [0, 180]}
    result = pair(gap=tmp_path / "gap.npy", **options)
    texts = [caveat.text for caveat in result.caveats]
    assert result.summary().first.roughness_contribution is None
    assert "oughness contributes" not in result.sentence
    assert get_pair_name(result.study) == "gap.npy"
    assert any("1 point is more than 6 rms heights from its neighbours" in text for text in texts)
    for word in ("neighbours", "interpolated"):
        assert [text.partition(":")[0] for text in texts if word in text] == ["gap"]


# ---- Form and steps of maps ------------------------------------------------------------------------------------------


def short_wave_map(seed, points=256):
    """Return heights with an rms of 1, whose longest wavelength is a twelfth of the side of the map."""
    return self_affine_map(seed, 0.8, (points, points), longest=points / 12, spacing=(1.0, 1.0)).heights


def find_form_and_step_texts(body, **options):
    return [
        caveat.text for caveat in find_scan_caveats(body, **options) if "form (" in caveat.text or "step" in caveat.text
    ]


def test_spherical_map_adds_a_caveat_unless_the_spherical_form_is_removed():
    y, x = np.indices((256, 256)) / 255 - 0.5
    capped_map = Surface(0.5 * short_wave_map(1) - 4 * 2 * (x**2 + y**2), spacing=0.5)
    assert [text.split(" contributes")[0] for text in find_form_and_step_texts(capped_map)] == ["form (a parabola)"]
    assert find_form_and_step_texts(levelled(capped_map, "quadratic")) == []
    plain_map = Surface(0.5 * short_wave_map(1), spacing=0.5)
    assert "upper: form (a parabola)" in " ".join(find_caveat_texts(capped_map, plain_map))
    study = measured_study().with_changes({"surfaces.level": "quadratic"})
    assert not any("form (" in caveat.text for caveat in find_input_caveats(capped_map, plain_map, study))


@pytest.mark.parametrize("angle", [0, 37, 90, 141])
@pytest.mark.parametrize("tilt", [0, 0.01])
def test_height_step_in_a_map_adds_a_caveat_with_the_step_height_unless_cropped_away(angle, tilt):
    y, x = np.indices((256, 256)) - 128
    across = x * np.cos(np.radians(angle)) + y * np.sin(np.radians(angle))
    heights = 0.025 * short_wave_map(2) + 2.0 * (across > 20) + tilt * x
    (text,) = find_form_and_step_texts(Surface(heights, spacing=0.5))
    height = float(text.removeprefix("a step of ").split(" µm")[0])
    assert height == pytest.approx(2.0, rel=0.01)
    one_side = heights[: heights.shape[0] // 4, :64] if angle != 141 else heights[:64, -64:]
    assert find_form_and_step_texts(Surface(one_side, spacing=0.5)) == []


def test_height_step_in_a_profile_adds_a_caveat_with_the_step_height():
    heights = 0.025 * short_wave_map(3)[7]
    (text,) = find_form_and_step_texts(Profile(heights + 2.0 * (np.arange(heights.size) > 90), spacing=0.5))
    assert text.startswith("a step of 2")


def test_height_step_in_a_map_with_missing_points_adds_a_caveat():
    is_missing = np.random.default_rng(1).random((256, 256)) < 0.3
    is_missing[:30, :30] = True
    heights = 0.025 * short_wave_map(4) + 2.0 * (np.arange(256) > 100)
    (text,) = find_form_and_step_texts(Surface(heights, spacing=0.5, missing=is_missing))
    assert float(text.removeprefix("a step of ").split(" µm")[0]) == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize("kind", ["Gaussian", "turned", "turned roughly", "milled", "ground", "honed"])
def test_maps_without_form_error_and_height_steps_have_no_caveat_about_form_or_steps(kind):
    for seed in range(10):
        heights = (
            short_wave_map(seed, 128) if kind == "Gaussian" else MACHINED_SURFACES[kind](np.random.default_rng(seed), 2)
        )
        assert find_form_and_step_texts(Surface(0.02 * scale_to_unit_rms(heights), spacing=0.1)) == []


# ---- Mirrored faces --------------------------------------------------------------------------------------------------


def find_mirror_caveats(upper, lower, **surface_changes):
    study = measured_study().with_changes(
        {"surfaces.positions": [["0 um", "0 um"]]}
        | {f"surfaces.{name}": value for name, value in surface_changes.items()}
    )
    return [caveat for caveat in find_input_caveats(upper, lower, study) if "position (0, 0)" in caveat.text]


def test_faces_that_fit_better_when_mirrored_add_a_caveat_with_both_gaps_and_a_remedy():
    lower = Surface(3.0 * short_wave_map(5, 96), spacing=2.0)
    noise = 0.1 * short_wave_map(6, 96)
    matching_face = flipped(lower).heights + noise
    assert find_mirror_caveats(Surface(matching_face, spacing=2.0), lower) == []
    faces_and_remedies = [
        (matching_face[::-1, ::-1], "use --rotate 180"), (matching_face[::-1], "reverse the rows"),
        (matching_face[:, ::-1], "reverse the columns"),
    ]  # fmt: skip
    for face, remedy in faces_and_remedies:
        (caveat,) = find_mirror_caveats(Surface(face, spacing=2.0), lower)
        assert caveat.severity == "caution"
        assert caveat.remedy.startswith(remedy)
        gaps = [float(text) for text in re.findall(r"is (\S+) µm, but (\S+) nm for", caveat.text)[0]]
        assert gaps == [pytest.approx(3.0 * np.sqrt(2), rel=0.2), pytest.approx(100, rel=0.05)]
    assert find_mirror_caveats(Surface(matching_face[::-1, ::-1], spacing=2.0), lower, rotate=180) == []


def test_mirroring_caveat_is_omitted_for_faces_that_do_not_match_or_have_given_positions():
    upper, lower = (Surface(short_wave_map(seed, 96), spacing=2.0) for seed in (7, 8))
    assert find_mirror_caveats(upper, lower) == []
    matching_face = Surface(flipped(lower).heights[::-1], spacing=2.0)
    assert find_mirror_caveats(matching_face, lower, positions=[["4 um", "0 um"]]) == []
    is_missing = np.zeros((96, 96), bool)
    is_missing[3:9, 50:] = True
    (caveat,) = find_mirror_caveats(Surface(matching_face.heights, spacing=2.0, missing=is_missing), lower)
    assert ", but 0 µm for" in caveat.text
