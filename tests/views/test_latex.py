"""Tests of results as a LaTeX table."""

import re

import pytest
from stiction import open_result, run
from stiction.studies.study import Study
from stiction.studies.summary import summarize
from stiction.views.latex import latex_table
from support.synthetic_results import generated_result, generated_study, measured_result, measured_study

SUMMARIES = {
    "pair": summarize(measured_result(loads=(1.0, 10.0), tau0=(0.0, 0.05)), measured_study()),
    "readings": summarize(measured_result(cut_offs=(0.0, 0.5)), measured_study()),
    "study": summarize(generated_result(dimensions=(1.1, 1.3)), generated_study()),
}


def table_cells(table):
    """Return the cells of the header and of each row of a table."""
    lines = re.findall(r"^(.*) \\\\$", table, re.MULTILINE)
    return [line.split(" & ") for line in lines]


@pytest.mark.parametrize("summary_name", SUMMARIES)
def test_latex_table_has_one_row_for_each_headline_result(summary_name):
    summary = SUMMARIES[summary_name]
    table = latex_table(summary)
    header, *rows = table_cells(table)
    assert len(rows) == len(summary.headlines)
    assert {len(row) for row in rows} == {len(header)}
    assert rf"\begin{{tabular}}{{{'l' * len(header)}}}" in table
    for row, point in zip(rows, summary.headlines, strict=True):
        assert row[-1] == point.verdict
        assert all(str(estimate) in row for estimate in point.rules)
    assert not re.search(r"(?<!\\)[%#_]", re.sub(r"^% .*$|\$.*?\$", "", table, flags=re.MULTILINE))


def test_latex_table_states_common_conditions_in_comments():
    table = latex_table(SUMMARIES["pair"])
    assert "% $\\mu_0$ = 0.2" in table
    header, *rows = table_cells(table)
    assert [row[:2] for row in rows] == [["1", "0"], ["1", "50"], ["10", "0"], ["10", "50"]]
    assert "(mN)" in header[0]
    assert "(MPa)" in header[1]


def test_latex_table_contains_the_area_fraction_with_its_interval_or_its_status():
    dataset = measured_result()
    point = summarize(dataset, measured_study()).first
    area_text = f"{point.quantities['contact_area_fraction'] / 0.01:.2u} \\%"
    assert "[" in area_text
    assert table_cells(latex_table(summarize(dataset, measured_study())))[1][-2] == area_text
    dataset["contact_status"] = dataset["contact_area_fraction"].isel(statistic=0).astype(str).copy()
    dataset["contact_status"][:] = "complete"
    assert table_cells(latex_table(summarize(dataset, measured_study())))[1][-2] == "complete"


def test_latex_table_shows_unfiltered_scans_as_none():
    assert "% cutoff (um) = none" in latex_table(SUMMARIES["pair"])
    cutoff_cells = [row[0] for row in table_cells(latex_table(SUMMARIES["readings"]))]
    assert cutoff_cells == ["cutoff (um)", "none", "0.5"]


def test_export_writes_latex_table_without_overwriting_files(tmp_path):
    study = Study.named("quick").with_changes({"ensemble.repetitions": 8, "surfaces.points": 3000})
    run(study, store=tmp_path / "result")
    result = open_result(tmp_path / "result")
    result.export(tmp_path / "table.tex")
    assert (tmp_path / "table.tex").read_text("utf-8") == latex_table(result.summary())
    with pytest.raises(ValueError, match="exists"):
        result.export(tmp_path / "table.tex")
