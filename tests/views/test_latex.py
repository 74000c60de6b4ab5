"""Tests of results as a LaTeX table."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from stiction import open_result, pair, run
from stiction.study.study import Study
from stiction.summary.summary import summarize
from stiction.views.latex import latex_table
from support.rough_surfaces import rough_maps
from support.synthetic_results import generated_result, generated_study, measured_result, measured_study

pytestmark = pytest.mark.usefixtures("no_companion_files")

SUMMARIES_BY_NAME = {
    "pair": summarize(measured_result(loads=(1.0, 10.0), tau0=(0.0, 0.05)), measured_study()),
    "readings": summarize(measured_result(cut_offs=(0.0, 0.5)), measured_study()),
    "study": summarize(generated_result(dimensions=(1.1, 1.3)), generated_study()),
}


def parse_table_cells(table):
    """Return the cells of the header and of all rows of a LaTeX table."""
    lines = re.findall(r"^(.*) \\\\$", table, re.MULTILINE)
    return [line.split(" & ") for line in lines]


@pytest.mark.parametrize("summary_name", SUMMARIES_BY_NAME)
def test_latex_table_has_one_row_for_each_quoted_coefficient(summary_name):
    summary = SUMMARIES_BY_NAME[summary_name]
    table = latex_table(summary)
    header, *rows = parse_table_cells(table)
    assert len(rows) == len(summary.reported_points)
    assert {len(row) for row in rows} == {len(header)}
    assert rf"\begin{{tabular}}{{{'l' * len(header)}}}" in table
    for row, point in zip(rows, summary.reported_points, strict=True):
        assert row[-1] == point.assessment
        assert all(str(estimate) in row for estimate in point.rules)
    assert not re.search(r"(?<!\\)[%#_]", re.sub(r"^% .*$|\$.*?\$", "", table, flags=re.MULTILINE))


def test_latex_table_states_conditions_common_to_all_rows_in_comments():
    table = latex_table(SUMMARIES_BY_NAME["pair"])
    assert "% $\\mu_0$ = 0.2" in table
    header, *rows = parse_table_cells(table)
    assert [row[:2] for row in rows] == [["1", "0"], ["1", "50"], ["10", "0"], ["10", "50"]]
    assert "(mN)" in header[0]
    assert "(MPa)" in header[1]


def test_latex_table_contains_the_area_fraction_with_its_interval_or_its_status():
    dataset = measured_result()
    point = summarize(dataset, measured_study()).first
    area_text = f"{point.quantities['contact_area_fraction'].in_unit('%', 0.01).text()} \\%"
    assert "[" in area_text
    assert parse_table_cells(latex_table(summarize(dataset, measured_study())))[1][-2] == area_text
    dataset["contact_status"] = dataset["contact_area_fraction"].isel(statistic=0).astype(str).copy()
    dataset["contact_status"][:] = "complete"
    assert parse_table_cells(latex_table(summarize(dataset, measured_study())))[1][-2] == "complete"


def test_latex_table_prints_the_word_none_as_the_cutoff_of_unfiltered_scans():
    assert "% cutoff (um) = none" in latex_table(SUMMARIES_BY_NAME["pair"])
    cutoff_cells = [row[0] for row in parse_table_cells(latex_table(SUMMARIES_BY_NAME["readings"]))]
    assert cutoff_cells == ["cutoff (um)", "none", "0.5"]


@pytest.fixture(scope="module")
def pair_table(tmp_path_factory):
    """Return the table of a pair of named materials with uncertain inputs, two pressures and a special file name."""
    directory = tmp_path_factory.mktemp("pair")
    files = [directory / "face_1 & 50%.npy", directory / "b.npy"]
    for path, body in zip(files, rough_maps(1, points=40), strict=True):
        np.save(path, body.heights)
    options = {"unit": "um", "spacing": "0.1 um", "cutoff": "none", "direction": [0, 180], "shifts": 8, "onset": 0}
    options |= {"upper": "silicon", "lower": "brass", "hardness": "2 GPa", "junction_growth": 0}
    result = pair(*files, mu0="0.12±0.02", tau0="100..300 MPa", load=["20 MPa", "60 MPa"], **options)
    return latex_table(result.summary())


def test_latex_table_lists_pressures_and_its_caption_states_materials_input_ranges_and_positions(pair_table):
    header, *rows = parse_table_cells(pair_table)
    column = header.index("$F_N/A_0$ (MPa)")
    assert [row[column] for row in rows] == ["20", "60"]
    (caption,) = re.findall(r"^\\caption\{(.*)\}$", pair_table, re.MULTILINE)
    expected_parts = [
        r"face\_1 \& 50\%.npy on b.npy", "silicon on brass", r"$\mu_0$ = 0.12 (0.12$\pm$0.02)", "(100..300 MPa)",
        "hardness 2 GPa", "the mean over both directions along x and 8 positions", "one scan of each part",
        "$A/A_0$",
    ]  # fmt: skip
    assert [part for part in expected_parts if part not in caption] == []


def test_latex_table_is_a_table_float_with_booktabs_rules(pair_table):
    lines = [line for line in pair_table.splitlines() if line.startswith("\\") or line.startswith("%")]
    commands = [re.match(r"\\?\w+(\{\w+\})?|%.*", line)[0] for line in lines]
    assert [command for command in commands if not command.startswith("%")] == [
        r"\begin{table}", r"\centering", r"\caption", r"\begin{tabular}", r"\toprule", r"\midrule", r"\bottomrule",
        r"\end{tabular}", r"\end{table}",
    ]  # fmt: skip
    assert "booktabs" in commands[0]
    without_comments = re.sub(r"^%.*$", "", pair_table, flags=re.MULTILINE)
    assert without_comments.isascii()
    assert without_comments.count("{") == without_comments.count("}")


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
def test_latex_compiles_the_exported_table(pair_table, tmp_path):
    document = "\\documentclass{article}\\usepackage{booktabs}\\begin{document}\n" + pair_table + "\\end{document}\n"
    (tmp_path / "table.tex").write_text(document, encoding="utf-8")
    completed = subprocess.run(
        ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "table.tex"], cwd=tmp_path, capture_output=True,
        check=False,
    )  # fmt: skip
    assert completed.returncode == 0, completed.stdout.decode(errors="replace")[-2000:]


def test_export_writes_latex_table_without_overwriting_files(tmp_path):
    study = Study.named("quick").with_changes({"ensemble.repetitions": 8, "surfaces.points": 3000})
    run(study, store=tmp_path / "result")
    result = open_result(tmp_path / "result")
    result.export(tmp_path / "table.tex")
    assert (tmp_path / "table.tex").read_text("utf-8") == latex_table(result.summary())
    with pytest.raises(ValueError, match="exists"):
        result.export(tmp_path / "table.tex")
