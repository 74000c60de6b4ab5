"""Test alternative preparations of scans: masked spikes, and an estimate of what a blunt tip did not reach."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import grey_dilation
from stiction import Profile, Study, Surface, open_result, pair, tip_reconstructed
from stiction.evaluate import budget
from stiction.evaluate.at_load import at_load
from stiction.evaluate.budget import add_uncertainty
from stiction.solve import alternative_preparations
from stiction.solve.alternative_preparations import (
    ALTERNATIVE_LABELS,
    ALTERNATIVES_DIRECTORY,
    TIP_CORRECTION,
    build_alternative_study,
)
from stiction.summary import evaluation
from stiction.summary.assessment import Caveat
from stiction.summary.report_grid import ReportGrid
from stiction.summary.report_values import evaluate_measured_report
from stiction.summary.summary import summarize
from stiction.surfaces.preparation import levelled
from stiction.surfaces.tip import sharpened
from stiction.views.assessment import most_useful_measurement_text
from stiction.views.rows import summary_json
from support.rough_surfaces import rough_maps, rough_profile

pytestmark = pytest.mark.usefixtures("no_companion_files")

SPACING = 0.1
TIP_RADIUS = 5.0  # µm
NUM_SPIKES = 4
PAIR_OPTIONS = {
    "load": "20 MPa", "mu0": 0.2, "tau0": "100 MPa", "effective_modulus": "80 GPa", "shifts": 4, "onset": 0,
    "direction": [0, 180],
}  # fmt: skip


def open_without_alternatives(result):
    """Return a stored result whose interval leaves out alternative preparations of the scans."""
    directory = result.path.with_name(f"{result.path.name}-without-alternatives")
    if not directory.exists():
        shutil.copytree(result.path, directory, ignore=shutil.ignore_patterns(ALTERNATIVES_DIRECTORY))
    return open_result(directory)


def scan_with_tip(surface, radius=TIP_RADIUS):
    """Return the scan of a surface as a spherical tip with a given radius records it."""
    half_width = int(np.sqrt(2 * radius * np.ptp(surface.heights)) / SPACING) + 1
    offsets = SPACING * np.arange(-half_width, half_width + 1)
    tip_shape = np.sqrt(radius**2 - offsets[:, None] ** 2 - offsets**2) - radius
    heights = grey_dilation(
        surface.heights, footprint=np.ones_like(tip_shape, bool), structure=tip_shape, mode="constant", cval=-np.inf
    )
    return Surface(heights, spacing=SPACING)


def add_spikes(surface, seed=2):
    """Return a scan in which a few points are 10 rms heights too high or too low."""
    generator = np.random.default_rng(seed)
    heights = surface.heights.copy()
    points = generator.choice(heights.size, NUM_SPIKES, replace=False)
    heights.flat[points] += 10 * heights.std() * np.array([1, -1, 1, 1])
    return Surface(heights, spacing=SPACING)


def contains_value(interval, value):
    return interval[0] <= value <= interval[1]


def contains_interval(interval, covered_interval):
    return contains_value(interval, covered_interval[0]) and contains_value(interval, covered_interval[1])


@pytest.fixture(scope="module")
def true_surfaces():
    return rough_maps(5, points=40, rms=0.02)


@pytest.fixture(scope="module")
def true_value(true_surfaces):
    return pair(*true_surfaces, cutoff="none", **PAIR_OPTIONS).value


@pytest.fixture(scope="module")
def blunt_tip_scans(true_surfaces):
    return [scan_with_tip(surface) for surface in true_surfaces]


@pytest.fixture(scope="module")
def blunt_result(blunt_tip_scans, tmp_path_factory):
    return pair(*blunt_tip_scans, tip=TIP_RADIUS, directory=tmp_path_factory.mktemp("blunt") / "result", **PAIR_OPTIONS)


@pytest.fixture(scope="module")
def spiked_scans(true_surfaces):
    return [add_spikes(surface) for surface in true_surfaces]


@pytest.fixture(scope="module")
def spiked_result(spiked_scans, tmp_path_factory):
    return pair(*spiked_scans, cutoff="none", directory=tmp_path_factory.mktemp("spikes") / "result", **PAIR_OPTIONS)


def test_interval_of_an_elastic_pair_includes_the_result_for_tip_corrected_scans(blunt_result, true_value):
    result_without_estimate = open_without_alternatives(blunt_result)
    assert blunt_result.value == result_without_estimate.value > true_value
    assert contains_value(blunt_result.interval, true_value)
    assert not contains_value(result_without_estimate.interval, true_value)
    assert contains_interval(blunt_result.prediction_interval, result_without_estimate.prediction_interval)
    (tip_caveat,) = (caveat for caveat in blunt_result.caveats if "tip does not resolve" in caveat.text)
    assert "the interval includes an estimate of this" in tip_caveat.text
    assert tip_caveat.severity == "fault"
    assert blunt_result.assessment == result_without_estimate.assessment == "Do not quote"


def test_interval_of_a_pair_with_spikes_contains_the_interval_computed_with_masked_spikes(
    spiked_result, spiked_scans, tmp_path
):
    files = [tmp_path / f"{name}.npy" for name in ("upper", "lower")]
    for path, scan in zip(files, spiked_scans, strict=True):
        np.save(path, scan.heights)
    masked_result = pair(
        *files, unit="um", spacing=SPACING, outliers="mask", cutoff="none", **PAIR_OPTIONS | {"load": "20 MPa"}
    )
    alternative = spiked_result.alternatives["spikes"]
    # Both results have the same load (mN), because the nominal area does not include masked points.
    assert alternative.value == pytest.approx(masked_result.value, rel=1e-2)
    assert contains_interval(spiked_result.interval, alternative.interval)
    result_without_estimate = open_without_alternatives(spiked_result)
    assert contains_interval(spiked_result.interval, result_without_estimate.interval)
    assert spiked_result.interval != result_without_estimate.interval
    (spike_caveat,) = (caveat for caveat in spiked_result.caveats if "rms heights" in caveat.text)
    assert "the interval includes the result for masked outliers" in spike_caveat.text
    assert spiked_result.assessment == result_without_estimate.assessment


@pytest.mark.parametrize("name", ["blunt_result", "spiked_result"])
def test_interval_widened_for_an_alternative_preparation_is_the_same_in_all_outputs(name, request):
    result = request.getfixturevalue(name)
    for opened_result in (result, open_result(result.path)):
        point = opened_result.summary().first
        assert result.interval == (point.lower, point.upper)
        combined_interval = opened_result.at()["friction_combined"].sel(sliding="all").squeeze()
        assert combined_interval.values.tolist() == [point.value, *result.interval]
        record = json.loads(summary_json("pair", opened_result.summary()))
        coefficient = record["points"][0]["rules"][0]["coefficient"]
        assert (coefficient["lower"], coefficient["upper"]) == result.interval
        (entry,) = (
            value
            for value in record["values"]
            if value["name"] == "friction_combined" and value["at"].get("sliding") == "all"
        )
        assert (entry["lower"], entry["upper"]) == result.interval
        row = next(row for _, row in opened_result.to_dataframe().iterrows() if row["sliding"] == "all")
        limits = [value for name, value in row.items() if name.endswith((": lower", ": upper")) and "mu_s" in name]
        assert set(result.interval) <= set(limits) or set(result.interval) <= set(row.tolist())


@pytest.mark.parametrize("name", ["blunt_result", "spiked_result"])
def test_interval_of_the_true_area_includes_the_result_of_an_alternative_preparation(name, request):
    result = request.getfixturevalue(name)
    point_without_alternative = open_without_alternatives(result).summary().first
    (alternative,) = result.alternatives.values()
    for quantity in ("contact_area", "contact_area_fraction", "mean_pressure"):
        estimate = result.summary().first.quantities[quantity]
        assert estimate.value == point_without_alternative.quantities[quantity].value
        assert contains_interval(estimate.interval, point_without_alternative.quantities[quantity].interval)
        assert contains_value(estimate.interval, alternative.summary().first.quantities[quantity].value)


def test_legend_of_the_friction_figure_states_that_intervals_include_errors_of_the_scans(blunt_result):
    legend_titles = [
        result.figure("friction").legends[0].get_title().get_text()
        for result in (blunt_result, open_without_alternatives(blunt_result))
    ]
    assert ["errors of the scans" in title for title in legend_titles] == [True, False]


def test_uncertainty_budget_lists_the_interval_without_the_alternative_preparation(blunt_result):
    budget = blunt_result.budget.set_index("input")
    own_interval = open_without_alternatives(blunt_result).interval
    row = budget.loc[ALTERNATIVE_LABELS["tip"]]
    assert (row["lower"], row["upper"]) == own_interval
    assert row["width"] == pytest.approx(own_interval[1] - own_interval[0])
    assert (budget["width"] <= blunt_result.interval[1] - blunt_result.interval[0]).all()


def test_combined_interval_includes_alternative_preparations_at_every_load_mu0_and_tau0(blunt_result):
    loads, strengths = [0.1, 0.2], {"mu0": [0.1, 0.3], "tau0": [0.0, 0.05]}
    combined_intervals, alternative_intervals = (
        compared_result.at(loads, **strengths, budget=True)["friction_combined"].values
        for compared_result in (blunt_result, blunt_result.alternatives["tip"])
    )
    intervals_without_alternative = add_uncertainty(
        at_load(blunt_result, loads, **strengths), open_without_alternatives(blunt_result), budget=False
    )["friction_combined"].values
    np.testing.assert_array_equal(combined_intervals[..., 0], intervals_without_alternative[..., 0])
    np.testing.assert_array_equal(
        combined_intervals[..., 1], np.minimum(intervals_without_alternative[..., 1], alternative_intervals[..., 1])
    )
    np.testing.assert_array_equal(
        combined_intervals[..., 2], np.maximum(intervals_without_alternative[..., 2], alternative_intervals[..., 2])
    )


def test_alternative_preparation_is_evaluated_once_for_the_interval_and_caveats_of_a_summary(blunt_result, monkeypatch):
    counts, expected = Counter(), (blunt_result.interval, blunt_result.caveats)

    def count_and_evaluate(sums, *args, **kwargs):
        counts[sums.path.name] += 1
        return at_load(sums, *args, **kwargs)

    for module in (budget, evaluation):
        monkeypatch.setattr(module, "at_load", count_and_evaluate)
    result = open_result(blunt_result.path)
    assert (result.interval, result.caveats) == expected
    assert counts == {"result": 1, "tip": 1}
    result.summary(0.1, mu0=0.3)
    assert counts == {"result": 2, "tip": 2}


@pytest.mark.parametrize("is_evaluated", [True, False])
def test_caveat_mentions_the_alternative_preparation_only_if_the_interval_includes_its_result(
    spiked_result, is_evaluated
):
    at, study = spiked_result.at(), spiked_result.study
    other_at = add_uncertainty(at_load(spiked_result.alternatives["spikes"], at["load"].values), spiked_result)
    if not is_evaluated:
        for name in ("mean_friction", "friction_combined", "friction_at_cutoff"):
            other_at[name] = other_at[name] * np.nan
    other_summary = summarize(other_at, study)
    summary = summarize(at, study, input_caveats=spiked_result.input_caveats, alternatives={"spikes": other_summary})
    (spike_caveat,) = (caveat for caveat in summary.first.caveats if "rms heights" in caveat.text)
    assert ("the interval includes the result for masked outliers" in spike_caveat.text) == is_evaluated


def test_pair_without_spikes_and_tip_radius_has_no_alternative_preparations(true_surfaces, tmp_path):
    result = pair(*true_surfaces, directory=tmp_path / "result", **PAIR_OPTIONS)
    assert result.alternatives == {}
    assert not (result.path / ALTERNATIVES_DIRECTORY).exists()


def test_area_interval_of_a_yielding_pair_includes_the_result_for_tip_corrected_scans(true_surfaces, tmp_path):
    options, tip_radius = PAIR_OPTIONS | {"hardness": "2 GPa"}, 4 * TIP_RADIUS
    scans = [scan_with_tip(surface, tip_radius) for surface in true_surfaces]
    result = pair(*scans, tip=tip_radius, directory=tmp_path / "result", **options)
    true_result = pair(*true_surfaces, cutoff="none", **options)
    estimate, own_estimate, true_estimate = (
        compared_result.summary().first.quantities["contact_area"]
        for compared_result in (result, open_without_alternatives(result), true_result)
    )
    assert estimate.value == own_estimate.value
    assert contains_value(estimate.interval, true_estimate.value)
    assert not contains_value(own_estimate.interval, true_estimate.value)
    (tip_caveat,) = (caveat for caveat in result.caveats if "tip does not resolve" in caveat.text)
    assert "the interval includes an estimate of this" in tip_caveat.text
    assert tip_caveat.severity == "caution"


def test_scan_without_spikes_is_recommended_unless_its_result_has_a_fault_besides_a_wide_interval(spiked_result):
    point = replace(spiked_result.summary().first, caveats=())
    expected_text = most_useful_measurement_text(point)
    assert expected_text.startswith("With a scan without spikes")
    faults = {
        name: Caveat(f"without outliers: {name}", "", "fault", name=name) for name in ("half_width", "contacts_missing")
    }
    assert most_useful_measurement_text(replace(point, caveats=(faults["half_width"],))) == expected_text
    assert most_useful_measurement_text(replace(point, caveats=tuple(faults.values()))) == ""


def test_uncertainty_budget_at_a_study_load_does_not_depend_on_another_requested_load(spiked_result):
    (load,) = (float(load) for load in spiked_result.study.friction.load)
    points = spiked_result.at([load, 3 * load], budget=True).sel(load=[load])
    expected_points = spiked_result.at(budget=True)
    for name in ("friction_at_cutoff", "remaining_interval", "remaining_width", "contact_area"):
        assert points[name].dims == expected_points[name].dims
        np.testing.assert_allclose(points[name].values, expected_points[name].values, rtol=1e-12)


def test_second_call_of_the_pair_function_adds_a_missing_alternative_preparation_to_the_interval(
    blunt_result, blunt_tip_scans, tmp_path
):
    directory = tmp_path / "result"
    shutil.copytree(blunt_result.path, directory)
    shutil.rmtree(directory / ALTERNATIVES_DIRECTORY)
    old_result = open_result(directory)
    assert old_result.interval == open_without_alternatives(blunt_result).interval
    assert any("the interval does not include this" in caveat.text for caveat in old_result.caveats)
    resumed_result = pair(*blunt_tip_scans, tip=TIP_RADIUS, directory=directory, **PAIR_OPTIONS)
    assert resumed_result.interval == open_result(directory).interval == blunt_result.interval


def test_pair_function_returns_its_result_with_a_caveat_if_an_alternative_preparation_fails(
    blunt_tip_scans, blunt_result, monkeypatch
):
    def raise_memory_error(*_):
        raise ValueError("no memory")

    monkeypatch.setattr(alternative_preparations, "build_alternative_study", raise_memory_error)
    result = pair(*blunt_tip_scans, tip=TIP_RADIUS, **PAIR_OPTIONS)
    assert result.interval == open_without_alternatives(blunt_result).interval
    assert any("the interval does not include this" in caveat.text for caveat in result.caveats)


def test_alternative_preparation_masks_outliers_and_corrects_scans_for_the_tip(blunt_result, spiked_result):
    study = build_alternative_study(blunt_result.study, "tip")
    assert {study.surfaces.upper.tip_correction, study.surfaces.lower.tip_correction} == {TIP_CORRECTION}
    assert build_alternative_study(spiked_result.study, "tip").surfaces.upper.tip_correction is None
    study = build_alternative_study(spiked_result.study, "spikes")
    assert study.surfaces.upper.outliers == study.surfaces.lower.outliers == "mask"


def test_study_file_contains_the_tip_correction(blunt_result, tmp_path):
    study = build_alternative_study(blunt_result.study, "tip")
    (tmp_path / "study.toml").write_text(study.to_toml(), "utf-8")
    assert Study.from_toml(tmp_path / "study.toml") == study
    for value in (0.0, 11.0):
        with pytest.raises(ValueError, match="tip_correction"):
            blunt_result.study.with_changes({"surfaces.upper.tip_correction": value})


@pytest.mark.parametrize("mechanics", ["asperities", "half-space"])
def test_interval_of_profiles_with_spikes_includes_the_result_without_spikes(mechanics):
    profiles = [rough_profile(seed, points=400) for seed in (3, 4)]
    heights = profiles[0].heights.copy()
    heights[[100, 250]] += 10 * heights.std()
    result = pair(
        Profile(heights, spacing=profiles[0].spacing), profiles[1], load="10 MPa", mu0=0.2, tau0="100 MPa",
        effective_modulus="80 GPa", mechanics=mechanics, cutoff="none", offsets=16, onset=0,
    )  # fmt: skip
    assert np.isfinite(result.interval).all()
    assert contains_interval(result.interval, result.alternatives["spikes"].interval)


@pytest.mark.parametrize("seed", [4, 6])
def test_assessment_of_a_pair_with_spikes_includes_the_faults_of_its_result_without_spikes(seed):
    surfaces = rough_maps(seed, points=40, rms=0.005)
    options = PAIR_OPTIONS | {"hardness": "1 GPa", "load": "10 MPa", "cutoff": "none", "junction_growth": 0}
    clean_result, result = pair(*surfaces, **options), pair(*map(add_spikes, surfaces), **options)
    own_point = open_without_alternatives(result).summary().first
    assert own_point.assessment == "Quote with care"
    assert own_point.bracket is not None
    point = result.summary().first
    assert point.assessment == clean_result.assessment == "Do not quote"
    assert {fault.name for fault in point.faults} == {fault.name for fault in clean_result.summary().first.faults}
    assert point.bracket is None
    assert (point.value, point.rules[0].interval_of_mean) == (own_point.value, own_point.rules[0].interval_of_mean)
    (same_point,) = result.summarize_dataset(result.at(budget=True).isel(load=0, mu0=0, tau0=0)).points
    assert same_point.caveats == point.caveats


def test_scan_sharpened_by_the_full_tip_correction_equals_the_tip_reconstruction(blunt_tip_scans):
    scan = levelled(blunt_tip_scans[0], "plane")
    reconstruction, _ = tip_reconstructed(scan, TIP_RADIUS)
    np.testing.assert_allclose(sharpened(scan, TIP_RADIUS, 1.0).heights, reconstruction.heights, atol=1e-12)
    doubly_sharpened_heights = sharpened(scan, TIP_RADIUS, 2.0).heights
    np.testing.assert_allclose(doubly_sharpened_heights, 2 * reconstruction.heights - scan.heights, atol=1e-12)


def test_tip_correction_keeps_missing_points_and_features_that_the_tip_resolves():
    x = np.arange(81) * SPACING
    is_missing = np.zeros(x.size, bool)
    is_missing[7] = True
    smooth_profile = Profile(0.01 * np.cos(np.pi / 2 * x), spacing=SPACING, missing=is_missing)
    sharp_profile = sharpened(smooth_profile, 1.0, 3.0)
    np.testing.assert_array_equal(sharp_profile.missing, is_missing)
    assert np.abs(sharp_profile.heights - smooth_profile.heights).max() < 0.05 * 0.01


def test_tip_correction_of_a_scan_does_not_depend_on_its_tilt(blunt_tip_scans):
    scan = levelled(blunt_tip_scans[0], "plane")
    tilt = 0.3 * SPACING * np.arange(scan.heights.shape[0])[:, np.newaxis]
    tilted_scan = scan.changed(scan.heights + tilt, "tilted")
    sharp_heights = sharpened(tilted_scan, TIP_RADIUS, 3.0).heights - tilt
    np.testing.assert_allclose(sharp_heights, sharpened(scan, TIP_RADIUS, 3.0).heights, atol=1e-12)


def test_interval_at_each_dwell_time_includes_the_alternative_preparation(spiked_scans):
    options = PAIR_OPTIONS | {"hardness": "1..3 GPa", "wait": "1 h", "junction_growth": 9, "creep": "0.02..0.05"}
    result = pair(*spiked_scans, cutoff="none", **options)
    alternative = result.alternatives["spikes"]
    result_without_alternative = open_without_alternatives(result)
    assert contains_interval(result.interval, alternative.interval)
    assert result.interval == (
        min(result_without_alternative.interval[0], alternative.interval[0]),
        max(result_without_alternative.interval[1], alternative.interval[1]),
    )
    (aged,), (other_aged,) = result.summary().first.after_dwell, alternative.summary().first.after_dwell
    assert contains_interval(aged.interval, other_aged.interval)
    rows, own_rows = result.budget.set_index("input"), result_without_alternative.budget.set_index("input")
    assert set(rows.index) == {*own_rows.index, ALTERNATIVE_LABELS["spikes"]}
    shared = own_rows.index
    assert (rows.loc[shared, "lower"] <= own_rows["lower"]).all()
    assert (rows.loc[shared, "upper"] >= own_rows["upper"]).all()


def test_intervals_in_a_report_are_widened_by_results_of_the_alternative_preparation(blunt_result):
    values = evaluate_measured_report(ReportGrid(blunt_result))
    load = float(blunt_result.study.friction.load[0])
    load_index = values.loads.tolist().index(load)
    point = blunt_result.summary().first
    area = values.load_quantities["contact_area"][0, 0, load_index]
    quantity = point.quantities["contact_area"]
    assert area.tolist() == pytest.approx([quantity.value, *quantity.interval])
    indices = [axis.find_index(point.at[name]) for axis, name in zip(values.axes, ("mu0", "tau0"), strict=True)]
    friction = values.friction[(0, 0, 0, 0, load_index, *indices)]
    assert friction.tolist() == pytest.approx([point.value, point.lower, point.upper])
    own_area = evaluate_measured_report(ReportGrid(open_without_alternatives(blunt_result))).load_quantities
    assert np.ptp(own_area["contact_area"][0, 0, load_index, 1:]) < np.ptp(area[1:])
