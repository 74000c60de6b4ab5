"""Results as text: the answer first, nothing wider than the terminal, and nothing lost."""

from dataclasses import replace

import numpy as np
import pytest
from stiction._number_format import from_to, percent, quoted, significant, with_interval, with_unit
from stiction.studies.assessment import VERDICTS, Caveat
from stiction.studies.summary import Left, summarize
from stiction.views.text import (
    MAX_POINTS,
    assessment_text,
    axes_text,
    format_table,
    overview_text,
    quantities_text,
    result_text,
    wrap_text,
)
from support.synthetic_results import generated_result, generated_study, measured_result, measured_study, value_and_ends

COLUMNS = 80


@pytest.fixture(autouse=True)
def _columns(monkeypatch):
    monkeypatch.setenv("COLUMNS", str(COLUMNS))


MANY = {"loads": (0.5, 1.0, 10.0, 100.0), "mu0": (0.2, 0.3), "tau0": (0.0, 0.05), "cut_offs": (0.0, 0.2, 0.4)}

RESULTS = {
    "maps": (measured_result(), measured_study()),
    "with a hardness": (measured_result(rms_gradient=0.7), measured_study(hardness=3.0)),
    "many": (measured_result(**MANY), measured_study()),
    "with caveats": (measured_result(share_at_edge=0.6, contact_count=5.0, reading_difference=0.1), measured_study()),
    "lines": (measured_result(directions=(0.0, 180.0)), measured_study(press="lines", mechanics="asperities")),
    "without an answer": (
        measured_result(status="not-solved", all_rub=np.nan, opposing=np.nan, ok=0), measured_study(),
    ),
    "generated": (generated_result(), generated_study()),
}  # fmt: skip


@pytest.mark.parametrize("verbose", [False, True])
@pytest.mark.parametrize("name", RESULTS)
def test_text_fits_the_terminal_width(name, verbose):
    at, study = RESULTS[name]
    beside = [Caveat("a parabola is 82 % of its mean square height, and carries the load", "take it off", "caution")]
    text = result_text(summarize(at, study, input_caveats=beside), verbose=verbose)
    assert max(map(len, text.splitlines())) <= COLUMNS
    assert not any(line != line.rstrip() for line in text.splitlines())


def test_text_starts_with_value_and_assessment():
    lines = result_text(summarize(*RESULTS["with caveats"])).splitlines()
    assert lines[0].startswith("μ_s = 0.21 [0.20, 0.22]  friction at all contacts")
    verdict = lines.index("Do not quote")
    assert verdict < 10
    assert lines[verdict + 1].startswith("  ! 60 % of the load is on contacts at the edge")


def test_text_of_maps_fits_24_lines():
    text = result_text(summarize(*RESULTS["maps"]))
    assert len(text.splitlines()) <= 24
    for words in ("No grooves", "read from a.di"):
        assert words not in text
        assert words in result_text(summarize(*RESULTS["maps"]), verbose=True)


def test_spheres_on_a_strip_have_no_area_fraction():
    for mechanics, shown in (("asperities", False), ("half-space", True)):
        study = measured_study(press="lines", mechanics=mechanics)
        assert ("A/A0" in result_text(summarize(RESULTS["lines"][0], study))) == shown


def test_several_conditions_have_a_line_each():
    lines = result_text(summarize(measured_result(loads=(1.0, 10.0), tau0=(0.0, 0.05)), measured_study())).splitlines()
    assert lines[0].split()[:2] == ["load", "τ0"]
    assert [line.split()[:2] for line in lines[1:5]] == [["1", "mN"], ["1", "mN"], ["10", "mN"], ["10", "mN"]]
    assert all("0.21 [0.20, 0.22]" in line and line.endswith("Quote it") for line in lines[1:5])
    assert "with μ0 = 0.2, E* = 100 GPa" in " ".join(lines[5:7])


def test_caveats_of_several_points_give_their_count():
    at = measured_result(loads=(1.0, 10.0))
    at["share_at_edge"].loc[{"load": 1.0}] = 0.6
    text = result_text(summarize(at, measured_study()))
    assert "Do not quote" in text.splitlines()[1]
    assert "Quote it" in text.splitlines()[2]
    assert "edge (1 of 2)" in " ".join(text.split())


def test_remedy_without_visible_effect_is_left_out():
    one = summarize(measured_result(), measured_study()).points[0]
    for ends, message in (((0.205, 0.215), True), ((one.lower, one.upper - 1e-6), False)):
        options = replace(one, budget=(Left("finer waves", *ends, 0.0),))
        assert options.most is not None
        assert ("would give" in assessment_text([options])) == message


def test_columns_that_do_not_fit_are_wrapped():
    rows = [["name", "first column", "second column"], ["a", "1", "2"]]
    assert format_table(rows, 80).splitlines() == ["name  first column  second column", "a     1             2"]
    assert format_table(rows, 20).splitlines() == [
        "name  first column", "a     1", "name  second column", "a     2",
    ]  # fmt: skip


def test_wrapped_columns_repeat_all_label_columns():
    rows = [["load", "μ0", "first column", "second column"], ["1 mN", "0.2", "1", "2"]]
    assert format_table(rows, 26, labels=2).splitlines() == [
        "load  μ0   first column", "1 mN  0.2  1", "load  μ0   second column", "1 mN  0.2  2",
    ]  # fmt: skip


def test_wrapped_text_keeps_number_and_unit_together():
    text = wrap_text("x" * 33 + " τ0 = 50 MPa and more words that fill the line up to its end", 40)
    assert "τ0 = 50 MPa" in text.splitlines()[1]


def test_verbose_table_equals_the_result():
    at = measured_result(contact_count=123.0, share_on_largest=0.0421)
    text = quantities_text(at.isel(cut_off=0), measured_study(), verbose=True)
    rows = {line.split("  ")[0]: line.split("  ", 1)[1].strip() for line in text.splitlines()}
    count = next(value for name, value in rows.items() if "contacts" in name and "(" not in name)
    assert count == with_interval(*value_and_ends(123.0))
    assert rows["load on the largest contact (%)"] == with_interval(*value_and_ends(4.21))
    assert "error of the solution" in rows
    by_asperities = quantities_text(measured_result(error=np.nan).isel(cut_off=0), measured_study(), verbose=True)
    assert "error of the solution" not in by_asperities


@pytest.mark.parametrize(
    ("by_axis", "words"),
    [
        (
            [value_and_ends(0.1600, 0.011), value_and_ends(0.1535, 0.003)],
            "Grooves: friction along x is 4.2 % higher than along y.",
        ),
        (
            [value_and_ends(0.1535, 0.003), value_and_ends(0.1600, 0.011)],
            "Grooves: friction along y is 4.2 % higher than along x.",
        ),
        ([value_and_ends(0.1935, 0.022), value_and_ends(0.1913, 0.022)], "No grooves"),
        ([value_and_ends(0.16, np.nan), value_and_ends(0.15, np.nan)], "Grooves: unknown"),
    ],
)
def test_grooves_are_reported_if_intervals_of_axes_are_separate(by_axis, words):
    at = measured_result(by_axis=by_axis).isel(cut_off=0, load=0, mu0=0, tau0=0)
    text = axes_text(at, verbose=True)
    assert words in " ".join(text.split())
    assert [line.split()[0] for line in text.splitlines()[1:3]] == ["x", "y"]
    briefly = text.split("\n", 3)[3] if words.startswith("Grooves: friction") else ""
    assert axes_text(at) == briefly
    assert axes_text(measured_result(directions=(0.0, 180.0)).isel(cut_off=0, load=0, mu0=0, tau0=0)) == ""


def test_overview_has_a_row_for_each_cell_and_marks_invalid_values():
    at = generated_result(dimensions=(1.1, 1.2, 1.3, 1.4, 1.5))
    at["share_beyond_hertz"].loc[{"fractal_dimension": 1.4}] = 0.6
    at["status"].loc[{"fractal_dimension": 1.5, "load": 0.01}] = "not-reached"
    text = overview_text(summarize(at, generated_study()))
    assert max(map(len, text.splitlines())) <= COLUMNS
    assert text.count("μ_s [95 %] at μ0 = 0.4") == 1
    rows = [line.split()[:3] for line in text.splitlines() if line.startswith(("0 ", "100 MPa"))]
    assert len(rows) == 10
    assert text.count("not-reached") == 2
    assert text.count("0.25 [0.24, 0.26]*") == 4
    assert "* outside the model" in text


def test_overview_counts_caveats_beyond_its_lines():
    at = generated_result(dimensions=(1.1, 1.2), contact_count=3.0)
    at["share_beyond_hertz"].loc[{"fractal_dimension": 1.2}] = 0.6
    summary = summarize(at, generated_study())
    text, short = overview_text(summary), overview_text(summary, 1)
    assert " more: " not in text
    assert short.splitlines()[-1].endswith(" more: summary() shows all")
    assert overview_text(summary, 1, complete="--verbose").splitlines()[-1].endswith(" more: --verbose shows all")
    assert len(short.splitlines()) < len(text.splitlines())


def test_text_of_many_points_fits_on_a_screen():
    at = generated_result(loads=tuple(np.linspace(0.01, 1, 30)), dimensions=tuple(np.linspace(1.1, 1.5, 15)))
    summary = summarize(at, generated_study())
    lines = result_text(summary, complete="--verbose").splitlines()
    assert len(lines) <= 40
    rows = [line for line in lines if line[0:1].isdigit() and line.endswith(tuple(VERDICTS.values()))]
    assert 10 <= len(rows) <= MAX_POINTS
    assert f"Shown: {len(rows)} of {len(summary.headlines)} points; --verbose shows all." in lines
    complete = result_text(summary, verbose=True)
    assert "Shown" not in complete
    assert " more: " not in complete
    all_rows = [line for line in complete.splitlines() if line.endswith(tuple(VERDICTS.values()))]
    assert sum(line[0].isdigit() for line in all_rows) == len(summary.headlines)


def test_quantities_of_several_cells_name_the_cell_that_they_are_of():
    for dimensions, words in (((1.1, 1.2), "D = 1.1, mean [95 %]"), ((1.1,), "mean [95 %]")):
        text = result_text(summarize(generated_result(dimensions=dimensions), generated_study()))
        table = text[text.rindex("\n\n") :] if "\n\n" in text else text
        assert words.split()[0] in table
        assert ("D = 1.1" in table) == (len(dimensions) > 1)


def test_numbers_have_digits_that_their_interval_justifies():
    assert with_interval(0.1552, 0.07024, 0.3431) == "0.16 [0.07, 0.34]"
    assert with_interval(2.188, 1.192, 4.013) == "2.2 [1.2, 4.0]"
    assert with_interval(0.123456, 0.1234, 0.1235) == "0.1235 [0.1234, 0.1235]"
    assert with_interval(1170.0, 970.0, 1380.0) == "1170 [970, 1380]"
    assert with_interval(np.nan, np.nan, np.nan) == "none"
    assert with_interval(0.5, np.nan, np.nan) == "0.5 no interval"
    assert with_interval(1.0, 1.0, 1.0) == "1"


def test_numbers_have_documented_forms():
    assert quoted(0.2093, 0.1911, 0.2302) == "0.21 [0.19, 0.23]"
    assert quoted(0.1147, 0.1136, 0.1158) == "0.115 [0.114, 0.116]"
    assert quoted(0.1147, 0.1141, 0.1149) == "0.1147 [0.1141, 0.1149]"
    assert quoted(0.304, 0.302, 0.306) == "0.304 [0.302, 0.306]"
    assert quoted(0.2, 0.2 - 1e-6, 0.2 + 1e-6) == "0.2"
    assert quoted(0.0, 0.0, 0.0) == "0"
    assert quoted(np.nan) == "none"
    assert [from_to(0.0413, 0.188), from_to(0.2192, 0.2213)] == ["0.04 to 0.19", "0.219 to 0.221"]
    assert [significant(value) for value in (128.0, 96.4, 2.04e-5, 0.2, 0.0)] == ["130", "96", "0.00002", "0.2", "0"]
    assert [significant(96.4, 1), significant(0.00002036, 3)] == ["100", "0.0000204"]
    assert [with_unit(value, "pJ") for value in (0.0204, 102.0, 2040.0)] == ["20.4 fJ", "102 pJ", "2.04 nJ"]
    assert [percent(item) for item in (3.4e-7, 0.0042, 0.0421, 0.37, np.nan)] == [
        "less than 0.001 %", "0.42 %", "4.21 %", "37 %", "none",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1e-6, "mN", "1 nN"), (1e-4, "mN", "0.1 µN"), (0.05, "mN", "0.05 mN"), (2.0, "mN", "2 mN"), (5e3, "mN", "5 N"),
        (0.0005336, "mN", "0.534 µN"), (0.05, "GPa", "50 MPa"), (115.0, "GPa", "115 GPa"), (2e-6, "GPa", "2 kPa"),
        (0.1, "um", "100 nm"), (1500.0, "um", "1.5 mm"), (0.99996, "um", "1 µm"), (0.0, "GPa", "0 GPa"),
        (123456.0, "GPa", "123000 GPa"), (8.68e-8, "GPa", "86.8 Pa"),
    ],
)  # fmt: skip
def test_quantity_uses_unit_with_fewest_zeros(value, unit, text):
    assert with_unit(value, unit) == text


def test_large_quantities_use_larger_units():
    lines = quantities_text(
        measured_result(contact_area=1.01e7, contact_area_fraction=None), measured_study(), verbose=True
    )
    assert "true contact area (mm²)" in lines
    row = next(line for line in lines.splitlines() if line.startswith("true contact area"))
    assert row.split("  ")[-1].strip().startswith("10.1")
    assert with_unit(1.6e8, "um") == "160 m"
