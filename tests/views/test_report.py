"""Tests of the files of reports on results and on scans."""

import html
import os
import re

import numpy as np
import pytest
from stiction import Profile, Result, Study, levelled, pair, run, self_affine
from stiction.mechanics.quantities import STIFFNESS_PER_AREA_QUANTITIES
from stiction.study.study import parse_study_of_dataset
from stiction.summary.report_data import collect_report_data, evaluate_measured_values
from stiction.summary.report_grid import NUM_REPORT_LOADS, ReportGrid
from stiction.views.files import REPORT_FILE_SIGNATURE
from stiction.views.report import ReportError, report_page, save_report
from stiction.views.report.measured import measured_report_content
from stiction.views.report.surface import surface_page
from stiction.views.text import result_text
from support.generated_studies import SMALL_STUDY, empty_dataset
from support.report_numbers import ReportEvaluator
from support.studies_of_files import create_study_from_files as create_study_from_files
from support.studies_of_files import write_maps


@pytest.mark.usefixtures("omit_report_panels")
def test_report_escapes_html_in_study_attributes_and_name(generated_dataset, maps_dataset):
    page = report_page(
        generated_dataset.assign_attrs(stiction_version="<b>"), name="</script><script>alert(1)</script>"
    )
    assert "alert(1)</script>" not in page
    assert "stiction &lt;b&gt;" in page
    assert html.escape(parse_study_of_dataset(generated_dataset).to_toml()) in page
    dataset_with_script = maps_dataset.assign_attrs(upper="<script>alert(2)</script>\nread")
    assert "<script>alert(2)" not in report_page(dataset_with_script)


def test_report_is_limited_in_size_and_contains_its_licence(generated_dataset):
    text = report_page(generated_dataset)
    assert text.startswith(REPORT_FILE_SIGNATURE)
    for words in ("GNU GENERAL PUBLIC LICENSE", "How to Apply These Terms to Your New Programs"):
        assert words in text
    num_cells = generated_dataset.sizes["fractal_dimension"] * len(SMALL_STUDY.surfaces.amplitudes())
    num_pairs = np.prod([axis.values.size for axis in ReportGrid(Result(generated_dataset)).axes])
    assert len(text.encode()) < 250_000 + 6 * 20 * num_cells * NUM_REPORT_LOADS * num_pairs


def test_result_that_is_too_large_for_a_report_is_rejected(monkeypatch, generated_dataset, maps_dataset):
    monkeypatch.setattr("stiction.views.report.result.MAX_REPORT_VALUES", {True: 100, False: 79})
    with pytest.raises(ReportError, match=r"at most 79 .* choose fewer fractal dimensions, amplitudes or directions"):
        report_page(generated_dataset)
    with pytest.raises(ReportError, match=r"at most 100 .* choose fewer loads, cutoffs or directions"):
        report_page(maps_dataset)


def test_report_of_a_result_without_finished_pairs_is_rejected(generated_dataset):
    with pytest.raises(ReportError, match="must have at least one member that is solved at every load"):
        report_page(generated_dataset.isel(repetition=[]))


@pytest.mark.usefixtures("omit_report_panels")
def test_report_title_contains_the_names_of_the_study_or_the_scan_files(generated_dataset, maps_dataset):
    assert "<title>study – static friction – stiction</title>" in report_page(generated_dataset)
    assert "<title>mine – " in report_page(generated_dataset, name="mine")
    quick_dataset = empty_dataset(Study.named("quick")).assign_attrs(study=Study.named("quick").to_toml())
    assert "<title>quick – " in report_page(quick_dataset)
    assert "<title>upper-maps.npy on lower-maps.npy – " in report_page(maps_dataset)
    assert "<title>upper-maps.npy on lower-maps.npy (mine) – " in report_page(maps_dataset, name="mine")


def test_report_of_a_dataset_without_a_study_is_rejected(generated_dataset):
    with pytest.raises(ReportError):
        report_page(generated_dataset.drop_attrs())


def test_saving_a_report_overwrites_reports_but_no_other_files(generated_dataset, tmp_path, monkeypatch, request):
    # Evaluate the data only once, because this test is only about the written files.
    report_data = collect_report_data(Result.of(generated_dataset))
    monkeypatch.setattr("stiction.views.report.result.collect_report_data", lambda *_: report_data)
    path = tmp_path / "report.html"
    path.write_text(f"{REPORT_FILE_SIGNATURE}old")
    save_report(generated_dataset, path)
    assert len(path.read_bytes()) > 100_000
    os.mkfifo(tmp_path / "pipe")
    foreign_file = tmp_path / "thesis.html"
    foreign_file.write_text("years of work")
    request.getfixturevalue("omit_report_panels")
    with pytest.raises(ReportError, match="pipe"):  # The command does not wait for a program that reads the pipe.
        save_report(generated_dataset, tmp_path / "pipe")
    for bad_path in (foreign_file, tmp_path, tmp_path / "no/report.html"):
        with pytest.raises(ReportError):
            save_report(generated_dataset, bad_path)
    assert foreign_file.read_text() == "years of work"
    assert sorted(item.name for item in tmp_path.iterdir()) == ["pipe", "report.html", "thesis.html"]


def test_report_of_a_scan_lists_caveats_and_escapes_text():
    profile = levelled(self_affine(1, hurst_exponent=0.7, rms=0.05, points=6001, spacing=0.01), "line")
    file_and_command = {"name": "<b>.npy", "command": "<i>"}
    curved_heights = profile.heights + np.linspace(-1, 1, len(profile)) ** 2
    page = surface_page(
        Profile(curved_heights, spacing=0.01, history=("<script>alert(1)</script>",)), **file_and_command
    ).html()
    assert re.search(
        r"<li>Form \(a parabola\) contributes \d+ % of the mean square height, and carries the load; try --level", page
    )
    assert "<li>" not in surface_page(profile, **file_and_command).body
    assert "alert(1)</script>" not in page
    assert "<b>" not in page
    assert "<code>&lt;i&gt;</code>" in page


@pytest.mark.usefixtures("omit_report_panels")
def test_report_states_how_each_scan_file_was_read(tmp_path):
    rows = np.column_stack([0.5 * np.arange(64), np.random.default_rng(0).standard_normal(64)])
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header="x (um),height (um)", comments="")
    (tmp_path / "b.csv").write_text((tmp_path / "a.csv").read_text().replace("(um)", "(nm)"))
    files = [str(tmp_path / f"{name}.csv") for name in "ab"]
    result = pair(*files, load="1 MPa", mu0=0.2, effective_modulus=100.0, offsets=4, onset=0, accept="tall")
    page = html.unescape(report_page(result.source))
    assert [name in page for name in ("How a.csv was read", "How b.csv was read")] == [True, True]
    file_reading_table = page[page.index("How a.csv was read") :]
    cells = dict(
        re.findall(
            r'<th scope="row">(.*?)</th><td>(.*?)</td>', file_reading_table[: file_reading_table.index("</table>")]
        )
    )
    assert cells["layout"] == "positions and heights"
    assert cells["spacing"] == "0.5 µm along x"
    assert cells["unit of heights in the file"] == "um"
    assert cells["missing points"] == "0 of 64"
    assert cells["lines"] == "2 to 65; 1 above and 0 below skipped"
    assert cells["given, not read from the file"] == "accept = tall"
    (tmp_path / "a.csv").unlink()
    assert "How a.csv was read" not in html.unescape(report_page(result.source))


@pytest.mark.usefixtures("disable_figures")
@pytest.mark.parametrize("fixture_name", ["maps_dataset", "profiles_dataset"])
def test_report_contains_area_fractions_only_if_the_terminal_output_contains_area_fractions(fixture_name, request):
    """The nominal area of spheres on a strip has no meaning."""
    result = Result(request.getfixturevalue(fixture_name))
    content = measured_report_content(collect_report_data(result), evaluate_measured_values(result), "")
    terminal_text = result_text(result.summary(), verbose=True)
    has_nominal_area = "true area A/A0" in terminal_text
    assert has_nominal_area == (fixture_name == "maps_dataset")
    names = {table.name for table in content.quantities}
    assert has_nominal_area == bool(names & {"contact_area_fraction", *STIFFNESS_PER_AREA_QUANTITIES})
    assert {content.facts["curves"][name]["of"] for name in ("area", "stiffness")} <= names
    assert has_nominal_area == ("MPa" in content.facts["loads"]["unit"])
    load_index = content.facts["loads"]["values"].index(result.summary().first.at["load"])
    load_text = content.facts["loads"]["texts"][load_index]
    assert has_nominal_area == ("MPa" in load_text)
    assert load_text in terminal_text


@pytest.mark.usefixtures("disable_figures")
@pytest.mark.parametrize("fixture_name", ["maps_dataset", "profiles_dataset"])
def test_quantities_in_a_report_have_the_labels_numbers_and_units_of_the_terminal_output(
    fixture_name, request, monkeypatch
):
    monkeypatch.setenv("COLUMNS", "200")
    result = Result(request.getfixturevalue(fixture_name))
    report_data, measured_values = collect_report_data(result), evaluate_measured_values(result)
    load_index = measured_values.loads.size // 2
    summary = result.summary(float(measured_values.loads[load_index]), mu0=0.3, tau0=0.0)
    terminal_text = result_text(summary, verbose=True)
    printed_tables = [
        table
        for table in measured_report_content(report_data, measured_values, "").quantities
        if f"\n{table.words.lower()}" in terminal_text.lower()
    ]
    assert len(printed_tables) > 5
    for table in printed_tables:
        value_text, _, unit = table.to_record()["texts"][0][0][load_index].partition("\N{NO-BREAK SPACE}")
        row = f"{table.words[0].lower()}{table.words[1:]}{f' ({unit})' if unit else ''}"
        assert re.search(rf"^{re.escape(row)} +{re.escape(value_text)}( no interval)?$", terminal_text, re.MULTILINE), (
            row
        )


@pytest.mark.usefixtures("omit_report_panels")
def test_report_starts_with_the_sliding_rule_of_the_interface(dataset_with_interface_for_opposing_contacts):
    report = ReportEvaluator(report_page(dataset_with_interface_for_opposing_contacts))
    point = Result(dataset_with_interface_for_opposing_contacts).summary().first
    assert report.facts["rules"] == [rule.rule for rule in point.rules] == ["opposing", "all"]
    assert "film.csv belong to friction at opposing contacts only" in report.facts["ruleNote"]
    for index, rule in enumerate(point.rules):
        displayed_point = report.evaluate_quantity("friction", 0.3, 0.0, rule=index, load=report.facts["start"]["load"])
        assert [displayed_point[name] for name in ("value", "lower", "upper")] == pytest.approx(
            [rule.value, rule.lower, rule.upper], rel=1e-6
        )


@pytest.mark.usefixtures("omit_report_panels")
def test_report_states_the_junction_growth_coefficient_alpha(tmp_path):
    spacing = write_maps(tmp_path)
    contact = 'load = ["1 mN", "2 mN"]\nhardness = "2 GPa"\njunction_growth = 9'
    study = create_study_from_files(tmp_path, spacing=spacing, members=3, contact=contact)
    page = html.unescape(report_page(run(study)))
    assert "hardness 2 GPa, junction growth: α = 9." in page


@pytest.mark.usefixtures("omit_report_panels")
def test_report_shows_the_coefficient_as_a_lower_limit_if_the_softer_body_shears(tmp_path):
    spacing = write_maps(tmp_path)
    contact = 'load = ["1 mN", "2 mN"]\nhardness = "0.3 GPa"\njunction_growth = "slip-line"'
    study = create_study_from_files(tmp_path, spacing=spacing, members=3, contact=contact)
    report = ReportEvaluator(report_page(run(study)))
    rule = report.facts["rules"].index("all")
    displayed_point = report.evaluate_quantity("friction", max(report.facts["axes"]["mu0"]["values"]), 0.0, rule=rule)
    assert displayed_point["status"] == "bulk-shear"
    assert re.fullmatch(r"≥ 0\.\d+ \[0\.\d+, ∞\)", displayed_point["coefficient"])
    names = [status["name"] for status in report.facts["statuses"] if status["hasValue"]]
    assert names == ["ok", "bulk-shear"]
