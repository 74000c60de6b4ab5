"""Tests of results as text: the coefficient comes first, and no line is wider than the terminal."""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray
from stiction._estimate import Estimate
from stiction._number_format import format_percent, format_significant, format_with_unit
from stiction.mechanics.quantities import QUANTITIES
from stiction.summary.assessment import ASSESSMENTS_BY_SEVERITY, Caveat
from stiction.summary.summary import Summary, UncertaintyBudgetEntry, summarize
from stiction.views.assessment import assessment_paragraph
from stiction.views.layout import format_paragraph
from stiction.views.overview import overview_text
from stiction.views.point import nominal_area_text
from stiction.views.quantities import percent_text, quantities_paragraph
from stiction.views.rows import summary_json
from stiction.views.text import (
    MAX_PRINTED_POINTS,
    grooves_paragraph,
    main_values_text,
    resolution_and_onset_text,
    result_text,
    study_result_text,
)
from support.synthetic_results import generated_result, generated_study, measured_result, measured_study, value_and_ends

TERMINAL_WIDTH = 80


@pytest.fixture(autouse=True)
def set_terminal_width(monkeypatch):
    monkeypatch.setenv("COLUMNS", str(TERMINAL_WIDTH))


MULTI_VALUE_ARGUMENTS = {
    "loads": (0.5, 1.0, 10.0, 100.0),
    "mu0": (0.2, 0.3),
    "tau0": (0.0, 0.05),
    "cut_offs": (0.0, 0.2, 0.4),
}

DATASETS_AND_STUDIES = {
    "maps": (measured_result(), measured_study()),
    "with a hardness": (measured_result(rms_gradient=0.7), measured_study(hardness=3.0)),
    "many": (measured_result(**MULTI_VALUE_ARGUMENTS), measured_study()),
    "with caveats": (
        measured_result(share_at_edge=0.6, contact_count=5.0, load_definition_effect=0.1),
        measured_study(),
    ),
    "lines": (measured_result(directions=(0.0, 180.0)), measured_study(press="lines", mechanics="asperities")),
    "without a solution": (
        measured_result(status="not-solved", all_contacts=np.nan, opposing=np.nan, ok=0),
        measured_study(),
    ),
    "generated": (generated_result(), generated_study()),
}


@pytest.mark.parametrize("verbose", [False, True])
@pytest.mark.parametrize("case_name", DATASETS_AND_STUDIES)
def test_result_text_fits_the_terminal_width(case_name, verbose):
    dataset, study = DATASETS_AND_STUDIES[case_name]
    input_caveats = [
        Caveat("a parabola is 82 % of its mean square height, and carries the load", "take it off", "caution")
    ]
    text = result_text(summarize(dataset, study, input_caveats=input_caveats), verbose=verbose)
    assert max(map(len, text.splitlines())) <= TERMINAL_WIDTH
    assert not any(line != line.rstrip() for line in text.splitlines())


def test_result_text_starts_with_coefficient_and_assessment():
    lines = result_text(summarize(*DATASETS_AND_STUDIES["with caveats"])).splitlines()
    assert lines[0].startswith("μ_s = 0.21 [0.20, 0.22]  friction at all contacts")
    assessment_index = lines.index("Do not quote")
    assert assessment_index < 10
    assert lines[assessment_index + 1].startswith("  ! 60 % of the load is on contacts at the edge")


@pytest.mark.parametrize(("area", "text"), [(2000.0, "2000 µm²"), (5181.6, "5182 µm²"), (2.304e9, "2304 mm²")])
def test_nominal_area_is_printed_in_a_unit_that_suits_its_size(area, text):
    assert nominal_area_text(area) == text


def test_intervals_in_verbose_direction_tables_are_labelled_as_intervals_of_the_mean():
    dataset = measured_result()
    text = result_text(summarize(dataset, measured_study()), verbose=True)
    tables = text.split("\n\n")
    for label in ("along x", "upper body to +x"):
        (table,) = [table for table in tables if f"\n{label} " in table]
        assert table.startswith("μ_s [sampling]")
    assert "are 95 % intervals of the mean for exact inputs." in " ".join(text.split())
    dataset = dataset.assign(friction_combined=dataset["mean_friction"])
    text = " ".join(result_text(summarize(dataset, measured_study()), verbose=True).split())
    assert "all other intervals in the following tables are those of the mean" in text
    assert "alternative preparations" not in text
    dataset = dataset.assign_attrs(alternatives=["tip"])
    text = " ".join(result_text(summarize(dataset, measured_study()), verbose=True).split())
    assert "include the uncertain inputs and alternative preparations of the scans" in text


def test_lines_with_coefficients_of_four_digits_are_not_wrapped():
    dataset = measured_result(all_contacts=0.21, opposing=0.1022, half_width_ratio=0.002)
    lines = result_text(summarize(dataset, measured_study())).splitlines()
    assert lines[0].endswith("]  friction at all contacts")
    assert lines[1] == "      0.1022 [0.1020, 0.1024]  friction at opposing contacts only"


def test_result_text_of_maps_fits_in_24_lines():
    text = result_text(summarize(*DATASETS_AND_STUDIES["maps"]))
    assert len(text.splitlines()) <= 24
    for words in ("No grooves", "read from a.di"):
        assert words not in text
        assert words in result_text(summarize(*DATASETS_AND_STUDIES["maps"]), verbose=True)


def test_result_text_for_profiles_and_asperity_model_omits_the_area_fraction():
    for mechanics, has_area_fraction in (("asperities", False), ("half-space", True)):
        study = measured_study(press="lines", mechanics=mechanics)
        assert ("A/A0" in result_text(summarize(DATASETS_AND_STUDIES["lines"][0], study))) == has_area_fraction


def test_result_text_has_one_line_for_each_combination_of_load_mu0_and_tau0():
    lines = result_text(summarize(measured_result(loads=(1.0, 10.0), tau0=(0.0, 0.05)), measured_study())).splitlines()
    assert lines[0].split()[:2] == ["load", "τ0"]
    assert [line.split()[:2] for line in lines[1:5]] == [["1", "mN"], ["1", "mN"], ["10", "mN"], ["10", "mN"]]
    assert all("0.21 [0.20, 0.22]" in line and line.endswith("Quote it") for line in lines[1:5])
    assert "with μ0 = 0.2, E* = 100 GPa" in " ".join(lines[5:7])


def test_caveat_that_applies_to_one_of_several_loads_states_this_load():
    dataset = measured_result(loads=(1.0, 10.0))
    dataset["share_at_edge"].loc[{"load": 1.0}] = 0.6
    text = result_text(summarize(dataset, measured_study()))
    assert "Do not quote" in text.splitlines()[1]
    assert "Quote it" in text.splitlines()[2]
    assert "edge (1 of 2: 100 kPa)" in " ".join(text.split())


def test_assessment_lists_a_remedy_only_if_the_remedy_would_change_the_printed_interval():
    point = summarize(measured_result(), measured_study()).points[0]
    cases = (
        ((0.205, 0.215), True),
        ((point.lower, point.upper - 1e-6), False),
        ((point.value - 1e-6, point.value + 1e-6), False),
    )
    for ends, is_listed in cases:
        entry = UncertaintyBudgetEntry(point.value, *ends, label="unresolved roughness", width=0.0)
        point_with_budget = replace(point, budget=(entry,))
        assert point_with_budget.dominant_input is not None
        assert ("the interval would be" in format_paragraph(assessment_paragraph([point_with_budget]))) == is_listed


def test_verbose_text_contains_contact_count_largest_contact_load_and_solution_error():
    dataset = measured_result(contact_count=123.0, share_on_largest=0.0421)
    text = format_paragraph(quantities_paragraph(summarize(dataset, measured_study()).points, verbose=True))
    rows = {line.split("  ")[0]: line.split("  ", 1)[1].strip() for line in text.splitlines()}
    count_text = next(value for name, value in rows.items() if "contacts" in name and "(" not in name)
    assert count_text == Estimate(*value_and_ends(123.0)).table_text
    assert rows["load on the largest contact (%)"] == Estimate(*value_and_ends(4.21)).table_text
    assert "error of the solution" in rows
    points_of_asperity_model = summarize(measured_result(error=np.nan), measured_study()).points
    text_of_asperity_model = format_paragraph(quantities_paragraph(points_of_asperity_model, verbose=True))
    assert "error of the solution" not in text_of_asperity_model


@pytest.mark.parametrize(
    ("by_axis", "expected_words"),
    [
        (
            [value_and_ends(0.1600, 0.011), value_and_ends(0.1535, 0.003)],
            "Grooves: friction along x is 4.2 % higher than along y.",
        ),
        (
            [value_and_ends(0.1535, 0.003), value_and_ends(0.1600, 0.011)],
            "Grooves: friction along y is 4.2 % higher than along x.",
        ),
        (
            [value_and_ends(0.1931, 0.0001), value_and_ends(0.19295, 0.0001)],
            "No grooves: the axes differ by less than 1 %.",
        ),
        ([value_and_ends(0.1935, 0.022), value_and_ends(0.1913, 0.022)], "No grooves"),
        ([value_and_ends(0.16, np.nan), value_and_ends(0.15, np.nan)], "Grooves: unknown"),
    ],
)
def test_grooves_are_reported_if_friction_intervals_along_the_axes_are_disjoint(by_axis, expected_words):
    point = summarize(measured_result(by_axis=by_axis), measured_study()).first
    text = format_paragraph(grooves_paragraph(point, verbose=True))
    assert expected_words in " ".join(text.split())
    assert [line.split()[:2] for line in text.splitlines()[1:3]] == [["along", "x"], ["along", "y"]]
    expected_text = text.split("\n", 3)[3] if expected_words.startswith("Grooves: friction") else ""
    assert format_paragraph(grooves_paragraph(point)) == expected_text
    point_with_one_axis = summarize(measured_result(directions=(0.0, 180.0)), measured_study()).first
    assert grooves_paragraph(point_with_one_axis) == []


def test_verbose_text_contains_direction_dependent_quantities_only_for_a_single_direction():
    label = "load that opposes"
    for directions, is_printed in (((0.0,), True), ((0.0, 180.0), False)):
        dataset = measured_result(directions=directions, share_opposing=None)
        values = np.broadcast_to(value_and_ends(0.74), (len(directions), 3))
        dataset["share_opposing"] = ("direction", "statistic"), values
        point = summarize(dataset, measured_study()).first
        assert ("share_opposing" in point.quantities) == is_printed
        assert (label in result_text(summarize(dataset, measured_study()), verbose=True)) == is_printed


def test_text_and_json_of_a_summary_without_coefficients_state_the_reason():
    for study, text_function in ((measured_study(), main_values_text), (generated_study(), overview_text)):
        summary = Summary(study, xarray.Dataset(), (), no_points_reason="the surfaces do not touch")
        assert text_function(summary) == "μ_s  none: the surfaces do not touch"
        assert resolution_and_onset_text(summary) == ""
        record = json.loads(summary_json("pair", summary, dry=True))
        assert (record["values"], record["remark"], record["dry"]) == ([], summary.no_points_reason, True)


def test_number_without_an_interval_is_printed_with_two_digits():
    dataset = generated_result(share_beyond_hertz=0.1234)
    dataset["share_beyond_hertz"] = dataset["share_beyond_hertz"].sel(statistic="mean", drop=True)
    point = summarize(dataset, generated_study()).first
    assert point.numbers["share_beyond_hertz"] == 0.1234
    (table,) = quantities_paragraph([point], verbose=True)
    assert dict(table.rows)[f"{QUANTITIES['share_beyond_hertz'].table_label} (%)"] == "12"


def test_overview_has_one_row_for_each_combination_of_parameters_and_marks_invalid_values():
    dataset = generated_result(dimensions=(1.1, 1.2, 1.3, 1.4, 1.5))
    dataset["share_beyond_hertz"].loc[{"fractal_dimension": 1.4}] = 0.6
    dataset["status"].loc[{"fractal_dimension": 1.5, "load": 0.01}] = "not-reached"
    text = overview_text(summarize(dataset, generated_study()))
    assert max(map(len, text.splitlines())) <= TERMINAL_WIDTH
    assert text.count("μ_s [95 %] at μ0 = 0.4") == 1
    rows = [line.split()[:3] for line in text.splitlines() if line.startswith(("0 ", "100 MPa"))]
    assert len(rows) == 10
    assert text.count("not-reached") == 2
    assert text.count("0.25 [0.24, 0.26]*") == 4
    assert "* outside the model" in text


@pytest.mark.parametrize("shorten", [{"max_lines": 1}, {"max_groups": 1}])
def test_shortened_caveat_list_contains_all_faults_and_the_number_of_other_caveats(shorten):
    faults = [Caveat(f"fault {name}", "repair it", "fault") for name in "ab"]
    cautions = [Caveat(f"caution {name}", "check it", "caution") for name in "ab"]
    points = [
        replace(point, caveats=caveats)
        for point, caveats in zip(
            summarize(generated_result(dimensions=(1.1, 1.2)), generated_study()).points,
            ((*cautions, faults[0]), (*cautions, *faults)),
            strict=False,
        )
    ]
    lines = format_paragraph(assessment_paragraph(points, complete_command="stiction info DIR", **shorten)).splitlines()
    assert [line[:10] for line in lines[1:]] == ["  ! fault ", "  ! fault ", "  2 more c"]
    assert lines[-1] == "  2 more caveats: stiction info DIR shows all"
    assert len(format_paragraph(assessment_paragraph(points)).splitlines()) == 5


def test_caveat_grouped_over_fractal_dimensions_states_the_range_of_each_number_in_its_text():
    points = summarize(generated_result(dimensions=(1.1, 1.2, 1.3)), generated_study()).points
    pressures, counts = ("950 kPa", "116 MPa", "1.2 GPa"), ("3", "12.5", "12.5")
    points = [
        replace(
            point,
            caveats=(Caveat(f"the pressure is {pressure}, with {count} contacts above 1 %", "check it", "caution"),),
        )
        for point, pressure, count in zip(points, pressures, counts, strict=False)
    ]
    text = " ".join(format_paragraph(assessment_paragraph(points)).split())
    assert "the pressure is 950 kPa to 1.2 GPa, with 3 to 12.5 contacts above 1 % (3 of 3); check it" in text
    text = " ".join(format_paragraph(assessment_paragraph(points[1:])).split())
    assert "the pressure is 116 MPa to 1.2 GPa, with 12.5 contacts above 1 % (2 of 2)" in text


@pytest.mark.parametrize(
    ("texts", "expected_text"),
    [
        (("version 2024.11.27 with 5 µm", "version 2024.11.27 with 6 µm"), "version 2024.11.27 with 5 to 6 µm"),
        (("the slope is 1e-05", "the slope is 3e-06"), "the slope is 3e-06 to 1e-05"),
        (("from 1...2 GPa", "from 1...3 GPa"), "from 1...2 to 3 GPa"),
    ],
)
def test_caveats_that_differ_only_in_numbers_are_grouped_even_with_dates_and_exponents(texts, expected_text):
    points = summarize(generated_result(dimensions=(1.1, 1.2)), generated_study()).points
    points = [
        replace(point, caveats=(Caveat(text, "check it", "caution"),))
        for point, text in zip(points, texts, strict=False)
    ]
    assert f"{expected_text} (2 of 2); check it" in " ".join(format_paragraph(assessment_paragraph(points)).split())


def test_overview_omits_caveats_of_low_severity_beyond_the_maximum_number_of_lines():
    dataset = generated_result(dimensions=(1.1, 1.2), contact_count=20.0)
    summary = summarize(dataset, generated_study())
    caveats = tuple(Caveat(f"caution {name}", "check it", "caution") for name in "ab")
    summary = replace(summary, points=tuple(replace(point, caveats=caveats) for point in summary.points))
    assert " more caveat" not in overview_text(summary)
    short_text = overview_text(summary, 1, complete_command="stiction info DIR --verbose")
    assert short_text.splitlines()[-1] == "  1 more caveat: stiction info DIR --verbose shows all"


def test_result_text_is_an_overview_table_only_for_generated_surfaces():
    measured_summary, generated_summary = (
        summarize(*DATASETS_AND_STUDIES[name]) for name in ("with caveats", "generated")
    )
    for verbose in (False, True):
        text = study_result_text(measured_summary, verbose=verbose, max_overview_lines=1, complete_command="--verbose")
        assert text == result_text(measured_summary, verbose=verbose, complete_command="--verbose")
    texts = (
        study_result_text(generated_summary, max_overview_lines=1),
        study_result_text(generated_summary, verbose=True),
    )
    assert texts == (overview_text(generated_summary, 1), overview_text(generated_summary))


def test_result_text_for_many_loads_and_mu0_and_tau0_has_at_most_40_lines():
    dataset = generated_result(loads=tuple(np.linspace(0.01, 1, 15)), dimensions=tuple(np.linspace(1.1, 1.5, 15)))
    summary = summarize(dataset, generated_study())
    lines = result_text(summary, complete_command="--verbose").splitlines()
    assert len(lines) <= 40
    rows = [line for line in lines if line[0:1].isdigit() and line.endswith(tuple(ASSESSMENTS_BY_SEVERITY.values()))]
    assert 10 <= len(rows) <= MAX_PRINTED_POINTS
    assert f"Shown: {len(rows)} of {len(summary.reported_points)} points; --verbose shows all." in lines
    verbose_text = result_text(summary, verbose=True)
    assert "Shown" not in verbose_text
    assert " more caveat" not in verbose_text
    all_rows = [line for line in verbose_text.splitlines() if line.endswith(tuple(ASSESSMENTS_BY_SEVERITY.values()))]
    assert sum(line[0].isdigit() for line in all_rows) == len(summary.reported_points)


def test_heading_of_a_quantity_table_states_the_fractal_dimension_if_there_are_several():
    for dimensions, expected_heading in (((1.1, 1.2), "D = 1.1, mean [95 %]"), ((1.1,), "mean [95 %]")):
        text = result_text(summarize(generated_result(dimensions=dimensions), generated_study()))
        table = text[text.rindex("\n\n") :] if "\n\n" in text else text
        assert expected_heading.split()[0] in table
        assert ("D = 1.1" in table) == (len(dimensions) > 1)


def test_percentage_is_printed_with_three_digits_and_an_undefined_percentage_as_none():
    assert [percent_text(fraction) for fraction in (0.1087, 0.06353, 0.0, np.nan)] == [
        "10.9 %",
        "6.35 %",
        "0 %",
        "none",
    ]


def test_formatted_numbers_have_the_documented_number_of_digits():
    assert [format_significant(value) for value in (128.0, 96.4, 2.04e-5, 0.2, 0.0)] == [
        "130",
        "96",
        "0.00002",
        "0.2",
        "0",
    ]
    assert [format_significant(96.4, 1), format_significant(0.00002036, 3)] == ["100", "0.0000204"]
    assert [format_with_unit(value, "pJ") for value in (0.0204, 102.0, 2040.0)] == ["20.4 fJ", "102 pJ", "2.04 nJ"]
    assert [format_percent(value) for value in (3.4e-7, 0.0042, 0.0421, 0.37, np.nan)] == [
        "less than 0.001 %",
        "0.42 %",
        "4.21 %",
        "37 %",
        "none",
    ]


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1e-6, "mN", "1 nN"), (1e-4, "mN", "0.1 µN"), (0.05, "mN", "0.05 mN"), (2.0, "mN", "2 mN"), (5e3, "mN", "5 N"),
        (0.0005336, "mN", "0.534 µN"), (0.05, "GPa", "50 MPa"), (115.0, "GPa", "115 GPa"), (2e-6, "GPa", "2 kPa"),
        (0.1, "um", "100 nm"), (1500.0, "um", "1.5 mm"), (0.99996, "um", "1 µm"), (0.0, "GPa", "0 GPa"),
        (123456.0, "GPa", "123000 GPa"), (8.68e-8, "GPa", "86.8 Pa"),
    ],
)  # fmt: skip
def test_quantity_is_printed_in_the_unit_that_requires_the_fewest_zeros(value, unit, text):
    assert format_with_unit(value, unit) == text


def test_large_areas_are_printed_in_mm2_and_large_lengths_in_m():
    dataset = measured_result(contact_area=1.01e7, contact_area_fraction=None)
    text = format_paragraph(quantities_paragraph(summarize(dataset, measured_study()).points, verbose=True))
    assert "true contact area (mm²)" in text
    area_row = next(line for line in text.splitlines() if line.startswith("true contact area"))
    assert area_row.split("  ")[-1].strip().startswith("10.1")
    assert format_with_unit(1.6e8, "um") == "160 m"
