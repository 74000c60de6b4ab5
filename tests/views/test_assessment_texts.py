"""Tests of assessments and their sentences; each caveat has a case with it and a case without it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from stiction.evaluate.member_means import MemberDependence
from stiction.evaluate.point import iterate_points
from stiction.mechanics.closed_forms import DEFAULT_KAPPA
from stiction.study.values import quantity
from stiction.summary.assessment import METAL_YIELD_PRESSURE_RATIO, YIELD_PRESSURE_RATIO, Caveat, build_pressure_checks
from stiction.summary.summary import POSSIBLE_NOISE_INPUT_NAME, summarize, summarize_point
from stiction.views.latex import latex_table
from stiction.views.layout import format_paragraph
from stiction.views.point import averaged_directions_text, cutoff_text
from stiction.views.rows import point_record, summary_table
from stiction.views.sentence import (
    MIN_STATED_LOAD_DEFINITION_EFFECT,
    finer_scan_text,
    inputs_text,
    list_all_assumptions,
    quotable_sentence,
    result_point_detail_sentences,
    small_slope_estimate_text,
)
from stiction.views.text import coefficients_paragraph
from support.synthetic_results import generated_result, generated_study, measured_result, measured_study


def summarize_single_point(dataset, study):
    result = summarize(dataset, study).points
    assert len(result) == 1
    return result[0]


def get_caveat_texts(point):
    return "; ".join(caveat.text for caveat in point.caveats)


def test_summary_of_measured_surfaces_lists_the_coefficient_for_all_contacts_first():
    point = summarize_single_point(measured_result(), measured_study(hardness=3.0))
    assert [rule.rule for rule in point.rules] == ["all", "opposing"]
    assert (point.value, point.lower, point.upper) == pytest.approx((0.21, 0.1995, 0.2205))
    assert (point.assessment, point.caveats) == ("Quote it", ())
    for words in (
        "μ_s = 0.21 [0.20, 0.22] with friction at all contacts",
        "0.110 [0.104, 0.116] with friction at opposing contacts only",
        "10 mN (1 MPa)",
        "μ0 = 0.2",
        "τ0 = 50 MPa",
        "E* = 100 GPa",
        "hardness 3 GPa",
        "points 100 nm apart",
        "the mean over 4 directions and 16 positions",
        "roughness contributes",
    ):
        assert words in quotable_sentence(point)
    assert quotable_sentence(point).endswith(".")
    assert (point.rules[0].low, point.rules[0].high) == (0.04, 0.19)
    assert summarize_single_point(measured_result(all_contacts=0.1, half_width_ratio=1.2), measured_study()).lower == 0
    dataset = measured_result()
    dataset["friction_coefficient"] *= 9  # values in single directions do not enter the mean over directions
    assert summarize_single_point(dataset, measured_study()).value == 0.21


def test_summary_of_generated_surfaces_has_only_the_coefficient_for_opposing_contacts():
    points = summarize(generated_result(), generated_study()).points
    assert [point.at["fractal_dimension"] for point in points] == [1.1] * 4 + [1.4] * 4
    assert [rule.rule for rule in points[0].rules] == ["opposing"]
    assert "D = 1.1" in quotable_sentence(points[0])
    assert "elastic" not in inputs_text(points[0])


def test_summary_has_one_result_point_for_each_combination_of_load_mu0_and_tau0():
    points = summarize(measured_result(loads=(1.0, 10.0), mu0=(0.2, 0.3), tau0=(0.0, 0.05)), measured_study()).points
    assert [(point.at["load"], point.at["mu0"], point.at["tau0"]) for point in points] == [
        (load, mu0, tau0) for load in (1.0, 10.0) for mu0 in (0.2, 0.3) for tau0 in (0.0, 0.05)
    ]


def test_summary_has_one_result_point_for_each_cutoff():
    points = summarize(measured_result(cut_offs=(0.0, 0.5)), measured_study()).points
    assert ["low-pass filtered at 500 nm" in quotable_sentence(point) for point in points] == [False, True]


@pytest.mark.parametrize(
    ("cut_offs", "expected_text"),
    [
        (((0.0,), (0.0,)), "none"),
        (((2.0,), (2.0,)), "2 µm"),
        (((2.0,), (5.0,)), "2 µm (upper) and 5 µm (lower)"),
        (((0.0,), (5.0,)), "5 µm (lower only)"),
        (((0.5, 0.5), (0.0,)), "500 nm (upper only)"),
        (((2.0, 1.0, 2.0), (5.0,)), "1 µm to 2 µm (upper) and 5 µm (lower)"),
        (((0.0, 1.0), (1.0, 0.0)), "none to 1 µm"),
    ],
)
def test_text_about_cutoffs_lists_the_cutoffs_of_both_scans_if_these_cutoffs_differ(cut_offs, expected_text):
    assert cutoff_text(cut_offs) == expected_text


def test_summary_texts_and_json_records_contain_the_cutoff_of_each_body():
    study = measured_study(hardness=2.0)
    scans = {
        side: getattr(study.surfaces, side).model_copy(update={"max_cut_off": quantity(f"{limit} um", "length")})
        for side, limit in (("upper", 0.2), ("lower", 0.5))
    }
    study = study.model_copy(update={"surfaces": study.surfaces.model_copy(update=scans)})
    summary = summarize(measured_result(cut_offs=(0.5, 0.0)), study)
    filtered_point, unfiltered_point = summary.points
    cutoffs = "200 nm (upper) and 500 nm (lower)"
    assert f"low-pass filtered at {cutoffs}" in inputs_text(filtered_point)
    assert f"scans filtered at {cutoffs}" in list_all_assumptions(filtered_point)
    assert "scans not filtered" in list_all_assumptions(unfiltered_point)
    table = format_paragraph(coefficients_paragraph(summary.points))
    assert cutoffs in table
    assert "none" in table
    assert "0.2 (upper) and 0.5 (lower)" in latex_table(summary)
    records = [point_record(point) for point in summary.points]
    assert [record["cutoffs"] for record in records] == [
        {"upper_body": [0.2], "lower_body": [0.5]}, {"upper_body": [0.0], "lower_body": [0.0]},
    ]  # fmt: skip
    csv_table = summary_table(summary)
    columns = ["cutoff (um)", "upper body cutoff (um)", "lower body cutoff (um)"]
    assert {tuple(row) for row in csv_table[columns].values.tolist()} == {(0.5, 0.2, 0.5), (0.0, 0.0, 0.0)}
    equal_table = summary_table(summarize(measured_result(cut_offs=(0.5, 0.0)), measured_study(hardness=2.0)))
    assert "upper body cutoff (um)" not in equal_table


FAULT_CASES = {
    "steep": ({"rms_gradient": 1.1}, {"rms_gradient": 0.9}, "gradient"),
    "pressure": (
        {"mean_pressure": 1.1 * YIELD_PRESSURE_RATIO * 100},
        {"mean_pressure": 0.9 * METAL_YIELD_PRESSURE_RATIO * 100},
        "pressure",
    ),
    "edge": ({"share_at_edge": 0.55}, {"share_at_edge": 0.2}, "edge"),
    "points": ({"contact_count": 1e4, "contact_area": 90.0}, {"contact_count": 1e4, "contact_area": 110.0}, "points"),
    "contacts": ({"contact_count": 0.6, "members": 16}, {"contact_count": 12.0}, "contacts"),
    "few contacts": ({"contact_count": 4.9}, {"contact_count": 12.0}, "too few contacts, 4.9 on average"),
    "one contact": ({"share_on_largest": 0.51}, {"share_on_largest": 0.39}, "one contact carries 51 %"),
    "below 0": ({"all_contacts": -0.01}, {"all_contacts": 0.01}, "below 0"),
    "beyond Hertz": ({"share_beyond_hertz": 0.6}, {"share_beyond_hertz": 0.4}, "Hertz"),
    "below the grid": ({"share_below_grid": 0.6}, {"share_below_grid": 0.4}, "spacing"),
    "wide": ({"half_width_ratio": 0.55}, {"half_width_ratio": 0.45}, "interval"),
    "no interval": ({"half_width_ratio": np.nan}, {}, "no interval"),
    "few answers": ({"ok": 7}, {"ok": 8}, "of 16 positions"),
    "area": ({"contact_area_fraction": 1.01}, {"contact_area_fraction": 0.99}, "true area"),
    "merged": ({"share_overlapping": 0.6}, {"share_overlapping": 0.05}, "overlap"),
}


def test_quotable_sentence_states_the_assessment_the_caveats_the_version_and_the_adhesion():
    caveat = Caveat("a parabola carries the load", "try --level quadratic", "caution")
    dataset = measured_result().assign_attrs(stiction_version="1.2.3")
    (point,) = summarize(dataset, measured_study(), input_caveats=[caveat]).points
    sentence = quotable_sentence(point)
    assert f"assessment: {point.assessment} ({caveat.text}" in sentence
    assert "stiction 1.2.3" in sentence
    assert "no adhesion" in sentence


@pytest.mark.parametrize("case_name", FAULT_CASES)
def test_quotable_sentence_about_a_result_with_a_fault_contains_no_coefficient(case_name):
    fault_changes, unaffected_changes, word = FAULT_CASES[case_name]
    point = summarize_single_point(measured_result(**fault_changes), measured_study())
    assert point.assessment == "Do not quote"
    assert word in " ".join(caveat.text for caveat in point.caveats if caveat.severity == "fault")
    assert "μ_s =" not in quotable_sentence(point)
    assert word in quotable_sentence(point)
    assert summarize_single_point(measured_result(**unaffected_changes), measured_study()).assessment == "Quote it"


CAUTION_CASES = {
    "pressure": ({"mean_pressure": 1.1 * METAL_YIELD_PRESSURE_RATIO * 100}, "harder than 1.1 GPa"),
    "edge": ({"share_at_edge": 0.3}, "30 % of the load is on contacts at the edge"),
    "small contacts": ({"fraction_on_small": 0.6}, "at most 4 points"),
    "few contacts": ({"contact_count": 9.0}, "few"),
    "one contact": ({"share_on_largest": 0.45}, "one contact carries"),
    "merging": ({"share_overlapping": 0.2}, "overlap"),
}


@pytest.mark.parametrize("case_name", CAUTION_CASES)
def test_result_with_a_caution_has_a_caveat_that_states_the_reason_for_the_caution(case_name):
    caution_changes, expected_words = CAUTION_CASES[case_name]
    point = summarize_single_point(measured_result(**caution_changes), measured_study())
    assert point.assessment == "Quote with care"
    assert expected_words in get_caveat_texts(point)
    assert "μ_s = 0.21" in quotable_sentence(point)


def test_scan_much_coarser_than_the_other_scan_adds_a_caveat():
    for spacing, expected_words in (([0.4, 0.1], "the lower scan is 4 times coarser than the upper"), ([0.2, 0.1], "")):
        dataset = measured_result().assign_attrs(upper_spacing_um=[0.1, 0.1], lower_spacing_um=spacing)
        point = summarize_single_point(dataset, measured_study())
        assert expected_words in get_caveat_texts(point)
        assert point.assessment == ("Quote with care" if expected_words else "Quote it")


def test_surrogates_much_smaller_than_the_scan_add_a_caveat():
    study = measured_study()
    study = study.with_changes({"surfaces.press": "surrogates"})
    for shape, assessment in ((300, "Quote with care"), (600, "Quote it")):
        dataset = measured_result().assign_attrs(shape=[shape, shape], spacing_um=[0.1, 0.1])
        for side in ("upper", "lower"):
            dataset = dataset.assign_attrs({f"{side}_spacing_um": [0.1], f"{side}_extent_um": [100.0]})
        point = summarize_single_point(dataset, study)
        assert point.assessment == assessment
        expected_words = "pieces of 30 µm are pressed, without the longer wavelengths of the scan of 100 µm"
        assert (expected_words in get_caveat_texts(point)) == (shape == 300)
        remedies = [caveat.remedy for caveat in point.caveats if caveat.text == expected_words]
        remedy = "omit --lay isotropic if the faces have grooves, and use height maps if they have none"
        assert remedies == [remedy] * (shape == 300)


@pytest.mark.parametrize(
    ("half_width_ratio", "is_assumed", "has_caveat"), [(0.01, True, True), (0.1, True, False), (0.01, False, False)]
)
def test_assumed_lay_adds_a_caveat_if_the_interval_excludes_the_coefficient_without_roughness(
    half_width_ratio, is_assumed, has_caveat
):
    study = measured_study(press="lines", mu0=(0.2,)).with_changes(
        {"surfaces.lay_assumed": True if is_assumed else None}
    )
    point = summarize_single_point(measured_result(all_contacts=0.21, half_width_ratio=half_width_ratio), study)
    (caveat,) = [caveat for caveat in point.caveats if "the lay is assumed" in caveat.text] or [None]
    assert (caveat is not None) == has_caveat
    if caveat is not None:
        limits_text = (
            "the coefficient may be anything down to 0.200 and the second coefficient may be anything down to 0.100"
        )
        assert caveat.text.endswith(f"; with another lay, {limits_text}")
        assert "--lay isotropic" in caveat.remedy
        assert point.assessment == "Quote with care"


@pytest.mark.parametrize(("opposing", "has_caveat"), [(0.11, False), (0.12, True)])
def test_assumed_lay_adds_a_caveat_even_if_another_lay_may_change_only_the_second_coefficient(opposing, has_caveat):
    study = measured_study(press="lines", mu0=(0.2,)).with_changes({"surfaces.lay_assumed": True})
    point = summarize_single_point(measured_result(all_contacts=0.21, opposing=opposing, half_width_ratio=0.1), study)
    texts = [caveat.text for caveat in point.caveats if "the lay is assumed" in caveat.text]
    text = (
        "the lay is assumed: parallel grooves on both faces; with another lay, the second coefficient may be anything"
    )
    assert texts == [f"{text} down to 0.100"] * has_caveat
    assert (point.assessment == "Quote with care") == has_caveat


@pytest.mark.parametrize(("all_contacts", "has_caveat"), [(0.203, False), (0.206, True)])
@pytest.mark.parametrize("options", [{}, {"mechanics": "asperities", "adhesion": None}], ids=["grooves", "spheres"])
def test_assumed_lay_adds_a_caveat_only_if_another_lay_may_change_a_coefficient_by_more_than_two_per_cent(
    options, all_contacts, has_caveat
):
    study = measured_study(press="lines", mu0=(0.2,), **options).with_changes({"surfaces.lay_assumed": True})
    result = measured_result(all_contacts=all_contacts, opposing=all_contacts / 2, half_width_ratio=0.001)
    assert ("the lay is assumed" in get_caveat_texts(summarize_single_point(result, study))) == has_caveat


@pytest.mark.parametrize(("half_width_ratio", "has_caveat"), [(0.01, True), (0.1, False)])
def test_caveat_about_assumed_spherical_asperities_states_no_direction(half_width_ratio, has_caveat):
    study = measured_study(press="lines", mechanics="asperities", adhesion=None, mu0=(0.2,))
    study = study.with_changes({"surfaces.lay_assumed": True})
    point = summarize_single_point(measured_result(all_contacts=0.21, half_width_ratio=half_width_ratio), study)
    texts = [caveat.text for caveat in point.caveats if "the lay is assumed" in caveat.text]
    assert texts == ["the lay is assumed: spherical asperities on both faces"] * has_caveat


@pytest.mark.parametrize(
    ("numbers", "study"),
    [
        ({"contact_count": 9.0, "contact_area_fraction": 0.4}, {}),
        ({"mean_pressure": 20.0}, {"hardness": 2.0}),
        ({"mean_pressure": 20.0}, {"mechanics": "asperities", "law": "jackson-green"}),
    ],
)
def test_assessment_of_a_result_without_caveats_recommends_quoting_the_result(numbers, study):
    assert summarize_single_point(measured_result(**numbers), measured_study(**study)).assessment == "Quote it"


@pytest.mark.parametrize(
    ("study", "remedy"),
    [
        (measured_study(), "give the hardness of the softer body"),
        (
            measured_study(mechanics="asperities"),
            "give the hardness of the softer body with --mechanics half-space, or with --law jackson-green",
        ),
        (generated_study(), "use lower heights, a lower D, or the contact law jackson-green"),
    ],
)
def test_caveat_about_high_pressure_recommends_inputs_that_the_contact_model_accepts(study, remedy):
    ((check, *_),) = build_pressure_checks(study, 80.0)
    assert check.remedy == remedy


@pytest.mark.parametrize("kind", ["measured", "generated"])
def test_rubber_like_material_has_no_caveat_about_high_pressure(kind):
    dataset, study = (
        (measured_result(), measured_study()) if kind == "measured" else (generated_result(), generated_study())
    )
    dataset["mean_pressure"] = 0 * dataset["mean_pressure"] + 2e-4
    for modulus, has_caveat in ((0.003, False), (0.2, False)):
        study = study.with_changes({"contact.effective_modulus": f"{modulus} GPa"})
        dataset = dataset.assign_coords(effective_modulus=modulus)
        assert any("pressure" in caveat.text for caveat in summarize(dataset, study).points[0].caveats) == has_caveat
    dataset["mean_pressure"] = 0 * dataset["mean_pressure"] + 0.02
    assert any("pressure" in caveat.text for caveat in summarize(dataset, study).points[0].caveats)


def test_pressure_above_the_yield_strength_of_a_soft_material_adds_a_caveat():
    study = measured_study(mechanics="asperities")
    study = study.with_changes({"contact.materials": ["mild steel", "brass"]})
    dataset = measured_result(mean_pressure=2.0).assign_coords(effective_modulus=0.05)
    assert any("brass yields" in caveat.text for caveat in summarize(dataset, study).points[0].caveats)


def test_high_pressure_of_generated_surfaces_adds_a_caution_but_no_fault():
    for pressure, assessment in ((0.4, "Quote it"), (0.6, "Quote with care")):
        points = summarize(generated_result(mean_pressure=pressure), generated_study()).points
        assert {point.assessment for point in points} == {assessment}


def test_quotable_sentence_about_a_result_without_coefficient_states_the_reason():
    point = summarize_single_point(
        measured_result(status="not-reached", all_contacts=np.nan, opposing=np.nan, ok=0), measured_study()
    )
    assert (point.status, point.assessment) == ("not-reached", "Do not quote")
    assert "the load is above the computed loads" in quotable_sentence(point)
    point_without_status = summarize_single_point(
        measured_result(all_contacts=np.nan, opposing=np.nan), measured_study()
    )
    text = format_paragraph(coefficients_paragraph([point_without_status]))
    assert text.startswith("μ_s = none")
    assert "ok" not in text.splitlines()[0]


def test_caveats_about_inputs_are_listed_after_faults_of_the_result():
    input_caveat = Caveat("a parabola carries the load", "try --level quadratic", "caution")
    dataset = measured_result(share_at_edge=0.6)
    point = summarize_point(next(iterate_points(dataset)), measured_study(), [input_caveat])
    assert [caveat.severity for caveat in point.caveats] == ["fault", "caution"]
    assert point.caveats[1] == input_caveat


@pytest.mark.parametrize(
    ("directions", "description"),
    [
        ([0.0], "the upper body moves to +x"),
        ([30.0], "the upper body moves at 30°"),
        ([0.0, 45.0], "the mean over 0° and 45°"),
        ([90.0, 270.0], "the mean over both directions along y"),
        (list(range(0, 360, 30)), "the mean over 12 directions all round"),
        (list(range(0, 180, 30)), "the mean over 0°, 30°, 60°, 90°, 120° and 150°"),
    ],
)
def test_text_about_averaged_directions_describes_one_two_or_evenly_spaced_directions(directions, description):
    assert averaged_directions_text(directions) == description


def test_quotable_sentence_about_profiles_states_directions_and_nominal_pressure():
    point = summarize_single_point(
        measured_result(directions=(0.0, 180.0)), measured_study(press="lines", mechanics="asperities")
    )
    assert "the mean over both directions and 16 positions" in quotable_sentence(point)
    assert "(1 MPa)" not in quotable_sentence(
        point
    )  # With spheres, the nominal pressure would depend on the chosen width of the strip.
    for study in ({"mechanics": "asperities", "law": "hertz-cylinder"}, {"mechanics": "half-space"}):
        point = summarize_single_point(measured_result(directions=(0.0, 180.0)), measured_study(press="lines", **study))
        assert "(1 MPa)" in quotable_sentence(point)


def test_quotable_sentence_states_the_definition_of_load_if_the_definition_changes_the_coefficient():
    for difference, is_given in (
        (2 * MIN_STATED_LOAD_DEFINITION_EFFECT, True),
        (MIN_STATED_LOAD_DEFINITION_EFFECT / 2, False),
    ):
        sentence = quotable_sentence(
            summarize_single_point(measured_result(load_definition_effect=difference), measured_study())
        )
        assert ("the load is the elastic contact force" in sentence) == is_given
        assert ("with another definition of the load μ_s differs by 2 %" in sentence) == is_given


def test_text_about_the_small_slope_estimate_lists_neglected_effects():
    gradient, pressure = 0.2, 100 * 0.2 / DEFAULT_KAPPA
    dataset_at_matching_pressure = measured_result(rms_gradient=gradient, mean_pressure=pressure)
    for dataset, hardness, effects in (
        (dataset_at_matching_pressure, None, []),
        (dataset_at_matching_pressure, 5.0, ["hardness is not considered"]),
        (measured_result(rms_gradient=gradient, mean_pressure=pressure / 2), None, ["does not apply"]),
    ):
        study = measured_study(hardness=hardness)
        text = small_slope_estimate_text(summarize_single_point(dataset, study))
        assert "0.21 with friction at all contacts" in text
        for effect_name in ("hardness", "does not apply"):
            assert (effect_name in text) == any(effect_name in effect for effect in effects)
    dataset_without_tau0 = measured_result(rms_gradient=gradient, mean_pressure=pressure / 2, tau0=(0.0,))
    assert "does not apply" not in small_slope_estimate_text(
        summarize_single_point(dataset_without_tau0, measured_study())
    )


def test_caveat_mentions_the_interval_only_at_loads_at_which_the_coefficient_has_an_interval():
    note = "; the interval includes the result for masked outliers"
    caveat = Caveat("2 points are sharp", "mask them", "caution", interval_note=note)
    dataset = measured_result(loads=(1.0, 10.0))
    for name in ("mean_friction", "friction_coefficient"):
        dataset[name].loc[{"load": 1.0, "statistic": ["lower", "upper"]}] = np.nan
    points = summarize(dataset, measured_study(), input_caveats=[caveat]).points
    assert [point.rules[0].has_interval for point in points] == [False, True]
    texts = [next(caveat.text for caveat in point.caveats if caveat.remedy == "mask them") for point in points]
    assert texts == [caveat.text, caveat.text + note]


@pytest.mark.parametrize("is_floor", [True, False])
def test_summary_interval_contains_the_filtered_and_the_unfiltered_coefficient(is_floor):
    cut_offs = (0.5, 0.0) if is_floor else (0.0, 0.5)
    dataset = measured_result(cut_offs=cut_offs, loads=(1.0, 10.0), half_width_ratio=0.02, all_contacts=0.25)
    for name in ("mean_friction", "friction_coefficient"):
        dataset[name][{"cut_off": 1}] *= 0.84
    combined_intervals = dataset["mean_friction"].isel(cut_off=[0, 1])
    dataset["friction_at_cutoff"] = combined_intervals
    dataset["remaining_interval"] = combined_intervals.expand_dims(input=["hardness"])
    dataset["remaining_width"] = (
        combined_intervals.sel(statistic="mean", drop=True).expand_dims(input=["hardness"]) * 0.02
    )
    dataset = dataset.assign_coords(input_label=("input", ["the hardness"]))
    severity = "caution" if is_floor else "fault"
    caveat = Caveat("waves below 400 nm have 40 % of the slope", "--cutoff '400 nm'", severity, 0.4, True)
    study = measured_study(hardness=2.0).with_changes({"surfaces.both_readings": True})
    summary_points = summarize(dataset, study, input_caveats=[caveat]).points
    assert [point.covered for point in summary_points] == [False, False, True, True]
    assert [point.at["cut_off"] for point in summary_points] == [cut_offs[0]] * 2 + [cut_offs[1]] * 2
    for point in [result_point for result_point in summary_points if not result_point.covered]:
        assert point.assessment == ("Quote with care" if is_floor else "Do not quote")
        assert (point.value, point.lower, point.upper) == pytest.approx((0.25, 0.21 * 0.98, 0.25 * 1.02))
        word = "with" if is_floor else "without"
        assert point.caveats[0].text.startswith(f"{caveat.text}; {word} them μ_s is 0.210 [0.206, 0.214]")
        assert [(remaining.label, remaining.lower) for remaining in point.budget] == [
            (POSSIBLE_NOISE_INPUT_NAME, pytest.approx(0.245)),
            ("the hardness", pytest.approx(0.2058)),
        ]
        assert point.dominant_input.label == POSSIBLE_NOISE_INPUT_NAME
        assert (point.bracket is None) == (not is_floor)
    summary_of_all = summarize(dataset, measured_study(hardness=2.0))
    assert summary_of_all.reported_points == list(summary_of_all.points)


def test_uncertainty_budget_of_a_result_without_an_interval_has_no_entry_for_possible_noise():
    dataset = measured_result(cut_offs=(0.5, 0.0), half_width_ratio=0.02, all_contacts=0.25)
    study = measured_study(hardness=2.0).with_changes({"surfaces.both_readings": True})
    assert [entry.label for entry in summarize(dataset, study).points[0].budget] == [POSSIBLE_NOISE_INPUT_NAME]
    for upper_limit in (np.nan, np.inf):
        dataset["mean_friction"].loc[{"cut_off": 0.5, "statistic": "upper"}] = upper_limit
        assert summarize(dataset, study).points[0].budget == ()


def test_filtered_result_inherits_the_faults_of_the_unfiltered_result():
    dataset = measured_result(cut_offs=(0.5, 0.0), half_width_ratio=0.02, all_contacts=0.25)
    dataset["mean_friction"].loc[{"cut_off": 0.0, "statistic": "upper"}] = (
        2.0  # Half width of the interval of the unfiltered scan, which is too wide for a quotable result.
    )
    study = measured_study(hardness=2.0).with_changes({"surfaces.both_readings": True})
    filtered_point, raw_point = summarize(dataset, study).points
    assert raw_point.assessment == filtered_point.assessment == "Do not quote"
    assert any(fault.text.startswith("as measured: ") for fault in filtered_point.faults)


# ---- Materials and finer scans --------------------------------------------------------------------------------------


def study_with_materials(hardness, names=("mild steel", "brass")):
    study = measured_study(hardness=hardness)
    return study.with_changes({"contact.materials": list(names)})


def test_friction_range_for_finer_scans_starts_at_the_plastic_limit_and_ends_above_the_coefficient():
    point = summarize(measured_result(all_contacts=0.24, half_width_ratio=0.01), measured_study(hardness=2.0)).points[0]
    limit = 0.2 + 0.05 / 2
    # The excess over the plastic limit is multiplied by exp(0.2), because load moves between the contacts.
    assert point.bracket == pytest.approx((limit, limit + (0.24 * 1.01 - limit) * math.exp(0.2)))
    assert "a finer scan would give 0.225 (μ0 + τ0/H) to 0.246, unless small contacts are harder" in quotable_sentence(
        point
    )
    point_at_limit = summarize(
        measured_result(all_contacts=0.2, half_width_ratio=1e-4, tau0=(0.0,)), measured_study(hardness=2.0)
    ).points[0]
    assert "a finer scan would give 0.200 (μ0 + τ0/H)" in quotable_sentence(point_at_limit)
    assert summarize(measured_result(), measured_study()).points[0].bracket is None
    asperity_study = measured_study(hardness=2.0, mechanics="asperities")
    assert summarize(measured_result(), asperity_study).points[0].bracket is None


@pytest.mark.parametrize(
    ("input_range", "expected_text"), [("1.1 GPa", "1.1 GPa;"), ("0.9..1.3 GPa", "1.08 GPa (0.9..1.3 GPa);")]
)
def test_quotable_sentence_states_the_hardness_with_its_range(input_range, expected_text):
    study = measured_study(hardness=1.1).with_changes({"contact.hardness": input_range})
    assert f"hardness {expected_text}" in quotable_sentence(summarize_single_point(measured_result(), study)).replace(
        ", points", ";"
    )


def test_quotable_sentence_states_the_number_of_surrogate_pairs():
    point = summarize(measured_result(members=16), measured_study(press="surrogates")).points[0]
    assert "16 pairs of surrogates (random surfaces with these spectra)" in quotable_sentence(point)
    study = measured_study().with_changes({"surfaces.surrogates": 8, "ensemble.repetitions": 24})
    point = summarize(measured_result(members=16), study).points[0]
    assert "16 positions (without the 8 pairs of surrogates, which the report lists)" in quotable_sentence(point)
    assert "random" not in quotable_sentence(summarize(measured_result(members=16), measured_study()).points[0])


def test_text_of_inputs_states_materials_and_the_hardness_range_of_the_softer_body():
    study = study_with_materials(0.625).with_changes({"contact.hardness": "0.625 GPa (0.23..1.7 GPa)"})
    point = summarize(measured_result(load_share_at_hardness=0.9), study).points[0]
    assert "mild steel on brass" in inputs_text(point)
    assert "hardness 625 MPa (230 MPa to 1.7 GPa)" in inputs_text(point)


@pytest.mark.parametrize(
    ("tau0", "expected_words"),
    [(0.01, None), (0.05, "τ0 is 45 % of the shear strength of the softer body"), (0.13, "no upper limit")],
)
def test_junction_growth_that_would_raise_friction_by_5_percent_adds_a_caveat_if_neglected(tau0, expected_words):
    dataset = measured_result(load_share_at_hardness=0.9, mu0=(0.1 if tau0 < 0.02 else 0.2,), tau0=(tau0,))
    caveats = summarize(dataset, study_with_materials(0.625)).points[0].caveats
    growth_caveats = [caveat.text for caveat in caveats if "junction growth" in caveat.text]
    assert len(growth_caveats) == (expected_words is not None)
    assert expected_words is None or expected_words in growth_caveats[0]
    caveats_of_elastic_contact = (
        summarize(measured_result(load_share_at_hardness=0.0, tau0=(tau0,)), study_with_materials(0.625))
        .points[0]
        .caveats
    )
    assert not any("junction growth" in caveat.text for caveat in caveats_of_elastic_contact)


def test_zero_tau0_adds_a_caveat_that_the_coefficient_is_the_given_mu0():
    dataset = measured_result(tau0=(0.0,))
    dataset["mean_friction"] = dataset["mean_friction"] / 0.21 * 0.2012
    caveats = [caveat.text for caveat in summarize(dataset, measured_study()).points[0].caveats]
    assert caveats == ["τ0 is 0, so the coefficient is the given μ0; the surfaces add 0.001"]


@pytest.mark.parametrize(
    ("pressure", "severity"), [(2.0, ["fault"]), (1.0, ["caution"]), (0.2, [])], ids=["all", "some", "none"]
)
def test_pressure_beyond_yield_adds_a_caveat_that_names_the_material(pressure, severity):
    study = measured_study(mechanics="asperities")
    study = study.with_changes({"contact.materials": ["mild steel", "brass"]})
    caveats = summarize(measured_result(mean_pressure=pressure), study).points[0].caveats
    brass_caveats = [caveat for caveat in caveats if "brass" in caveat.text]
    assert [caveat.severity for caveat in brass_caveats] == severity
    assert all("brass yields at 230 MPa to 1.7 GPa" in caveat.text for caveat in brass_caveats)


@pytest.mark.parametrize(
    "study", [study_with_materials(2.0), study_with_materials(0.625, ("one", "another")), measured_study(hardness=2.0)]
)
def test_text_of_inputs_states_no_range_for_a_given_hardness(study):
    point = summarize(measured_result(load_share_at_hardness=0.9), study).points[0]
    assert "known" not in inputs_text(point)
    assert not any("softer material" in caveat.text for caveat in point.caveats)


def test_friction_range_for_finer_scans_is_omitted_if_the_result_has_a_fault():
    point = summarize(measured_result(all_contacts=47.0, rms_gradient=300.0), measured_study(hardness=2.0)).points[0]
    assert (point.assessment, point.bracket) == ("Do not quote", None)
    assert not any("finer scan" in sentence for sentence in result_point_detail_sentences(point))


def test_friction_range_for_finer_scans_starts_at_a_coefficient_below_the_plastic_limit():
    lower, upper = (
        summarize(measured_result(all_contacts=0.22, half_width_ratio=0.01), measured_study(hardness=2.0))
        .points[0]
        .bracket
    )
    assert lower == pytest.approx(0.22)
    assert lower < upper


@pytest.mark.parametrize("changes", [{"contact_count": 4.9}, {"share_on_largest": 0.51}])
def test_few_contacts_are_no_fault_if_a_large_contact_area_shows_that_contacts_have_merged(changes):
    assert summarize_single_point(measured_result(**changes), measured_study()).assessment == "Do not quote"
    assert (
        summarize_single_point(measured_result(**changes, contact_area_fraction=0.35), measured_study()).assessment
        != "Do not quote"
    )


def test_roughness_contribution_equals_the_coefficient_minus_the_contributions_of_mu0_and_tau0():
    study = measured_study(hardness=3.0)
    point = summarize_single_point(measured_result(all_contacts=0.23), study)
    assert point.roughness_contribution == pytest.approx(0.23 - 0.2 - 0.05 / 3.0)
    assert point.hardness == 3.0
    assert summarize_single_point(
        measured_result(all_contacts=0.23), measured_study()
    ).roughness_contribution == pytest.approx(0.03)
    assert summarize(generated_result(), generated_study()).points[0].roughness_contribution is None


def test_text_about_finer_scans_states_the_hardness():
    text = finer_scan_text(summarize_single_point(measured_result(), measured_study(hardness=3.0)))
    assert text.startswith("with H = 3 GPa a finer scan would give 0.21")
    assert finer_scan_text(summarize_single_point(measured_result(), measured_study())) == ""


@pytest.mark.parametrize(("half_width", "is_stated"), [(0.02, True), (0.5, False)])
def test_effect_of_finer_scans_is_stated_unless_the_effect_is_small_compared_with_the_interval(half_width, is_stated):
    point = summarize_single_point(measured_result(), measured_study(hardness=3.0))
    rules = tuple(replace(rule, lower=rule.value - half_width, upper=rule.value + half_width) for rule in point.rules)
    text = " ".join(result_point_detail_sentences(replace(point, rules=rules)))
    assert ("a finer scan would give" in text) == is_stated
    assert point.bracket is not None


def test_results_of_generated_surfaces_have_caveats_about_few_contacts_and_zero_tau0():
    point = summarize(generated_result(contact_count=7.0), generated_study()).points[0]
    assert "few contacts, 7 on average" in get_caveat_texts(point)
    assert summarize(generated_result(contact_count=3.0), generated_study()).points[0].assessment == "Do not quote"
    assert "τ0 is 0, so the coefficient is the given μ0" in get_caveat_texts(
        summarize(generated_result(friction=0.4), generated_study()).points[0]
    )


@pytest.mark.parametrize(
    ("study", "members"),
    [
        (measured_study(), "positions"),
        (measured_study(press="surrogates"), "pairs of surrogates"),
        (measured_study().with_changes({"surfaces.surrogates": 2}), "members"),
    ],
)
def test_caveats_name_pairs_or_positions_by_the_same_word_as_the_study(study, members):
    expected_texts = {
        ("half_width_ratio", np.nan): "the coefficient has no interval; an interval "
        f"requires at least 3 different {members}",
        ("half_width_ratio", 0.55): f"the interval of the mean is wider than ±50 %; use more {members}",
        ("contact_count", 0.6): f"all {members} together have fewer than 10 contacts, on average 0.6 per "
        f"{study.member_names.singular}; use a higher load, larger surfaces or more {members}",
        ("share_of_pull_off_bounds", 0.25): f"the pull-off force is a lower bound: 25 % of the {members} have only a "
        "bound; call half_space to see the reason as a warning",
        ("ok", 7): f"only 7 of 16 {members} have a coefficient; check the statuses, and try another load",
        ("all_contacts", np.nan): f"there is no coefficient; check how many {members} have a coefficient",
    }  # fmt: skip
    for (name, value), expected_text in expected_texts.items():
        caveats = summarize_single_point(measured_result(**{name: value}), study).caveats
        assert expected_text in [f"{caveat.text}; {caveat.remedy}" for caveat in caveats]


@pytest.mark.parametrize(("press", "min_positions"), [("areas", 3), ("lines", 8)])
def test_caveat_about_a_missing_interval_states_how_many_positions_an_interval_requires(press, min_positions):
    study = measured_study(press=press)
    (caveat,) = summarize_single_point(measured_result(half_width_ratio=np.nan), study).faults
    assert caveat.remedy == f"an interval requires at least {min_positions} different positions"
    values = np.random.default_rng(1).normal(1.0, 0.1, min_positions)
    for count in (min_positions - 1, min_positions):
        coordinates = {"line": np.zeros(count), "x": np.arange(count), "y": np.zeros(count)}
        dependence = MemberDependence.from_coordinates(study, coordinates)
        _, *limits = dependence.mean_with_interval(values[:count])
        assert np.isfinite(limits).all() == (count == min_positions)


def test_caveats_use_the_word_repetitions_for_pairs_of_generated_surfaces():
    point = summarize(generated_result(contact_count=0.05), generated_study()).points[0]
    assert "all repetitions together have fewer than 10 contacts" in get_caveat_texts(point)


def test_caveat_about_few_contacts_of_a_single_gap_does_not_mention_positions():
    study = measured_study().with_changes({"surfaces.gap": True})
    point = summarize_single_point(measured_result(contact_count=4.0, members=1, ok=1), study)
    (fault,) = point.faults
    assert (fault.text, fault.remedy) == (
        "fewer than 10 contacts in the gap: 4", "use larger surfaces or a higher load",
    )  # fmt: skip


def test_caveat_object_contains_the_checked_value_and_the_limit_of_this_value():
    (caveat,) = summarize_single_point(measured_result(share_at_edge=0.6), measured_study()).caveats
    assert (caveat.name, caveat.value, caveat.limit) == ("share_at_edge", pytest.approx(0.6), 0.5)
    assert caveat.text == "60 % of the load is on contacts at the edge"
