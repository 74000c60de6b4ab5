"""The page of a result, and of one scan, as a file."""

import html
import os
import re

import numpy as np
import pytest
from stiction import Profile, Study, levelled, pair, run, self_affine
from stiction.studies.nodes import LOAD_STEPS, MAX_NODES
from stiction.studies.study import study_of
from stiction.views.report import ReportError, report_page, save_report
from stiction.views.report.page import MARK
from stiction.views.report.surface import surface_page
from support.generated_studies import SMALL_STUDY, empty_dataset
from support.studies_of_files import study_of_files as study_of_files
from support.studies_of_files import write_maps


@pytest.mark.usefixtures("undrawn")
def test_report_escapes_text_of_study(result, maps):
    page = report_page(result.assign_attrs(stiction_version="<b>"), name="</script><script>alert(1)</script>")
    assert "alert(1)</script>" not in page
    assert "stiction &lt;b&gt;" in page
    assert html.escape(study_of(result).to_toml()) in page
    nasty = maps.assign_attrs(upper="<script>alert(2)</script>\nread")
    assert "<script>alert(2)" not in report_page(nasty)


def test_report_is_small_and_contains_its_licence(result):
    text = report_page(result)
    assert text.startswith(MARK)
    for words in ("GNU GENERAL PUBLIC LICENSE", "How to Apply These Terms to Your New Programs"):
        assert words in text
    cells = result.sizes["fractal_dimension"] * len(SMALL_STUDY.surfaces.amplitudes())
    assert len(text.encode()) < 250_000 + 6 * 20 * cells * LOAD_STEPS * MAX_NODES**2


def test_report_rejects_too_large_result(monkeypatch, result, maps):
    monkeypatch.setattr("stiction.views.report.generated.MAX_POINTS", 79)
    with pytest.raises(ReportError, match="more than the 79"):
        report_page(result)
    monkeypatch.setattr("stiction.views.report.measured.MAX_POINTS", 100)
    with pytest.raises(ReportError, match="more than the 100"):
        report_page(maps)


def test_report_rejects_empty_result(result):
    with pytest.raises(ReportError, match="no member of the result has a solution"):
        report_page(result.isel(repetition=[]))


@pytest.mark.usefixtures("undrawn")
def test_report_title_names_study_or_files(result, maps):
    assert "<title>study – static friction – stiction</title>" in report_page(result)
    assert "<title>mine – " in report_page(result, name="mine")
    quick = empty_dataset(Study.named("quick")).assign_attrs(study=Study.named("quick").to_toml())
    assert "<title>quick – " in report_page(quick)
    assert "<title>upper-maps.npy on lower-maps.npy – " in report_page(maps)
    assert "<title>upper-maps.npy on lower-maps.npy (mine) – " in report_page(maps, name="mine")


def test_report_rejects_dataset_without_study(result):
    with pytest.raises(ReportError):
        report_page(result.drop_attrs())


def test_save_report_replaces_only_reports(result, tmp_path):
    path = tmp_path / "report.html"
    path.write_text(f"{MARK}old")
    save_report(result, path)
    assert len(path.read_bytes()) > 100_000
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ReportError, match="something else"):  # and does not wait for somebody to write into it
        save_report(result, tmp_path / "pipe")
    other = tmp_path / "thesis.html"
    other.write_text("years of work")
    for bad in (other, tmp_path, tmp_path / "no/report.html"):
        with pytest.raises(ReportError):
            save_report(result, bad)
    assert other.read_text() == "years of work"
    assert sorted(item.name for item in tmp_path.iterdir()) == ["pipe", "report.html", "thesis.html"]


def test_report_of_scan_has_caveats_and_escapes_text():
    profile = levelled(self_affine(1, hurst_exponent=0.7, rms=0.05, points=6001, spacing=0.01), "line")
    scan = {"name": "<b>.npy", "command": "<i>"}
    bowed = profile.heights + np.linspace(-1, 1, len(profile)) ** 2
    page = surface_page(Profile(bowed, spacing=0.01, history=("<script>alert(1)</script>",)), **scan).html()
    assert re.search(
        r"<li>Form \(a parabola\) is \d+ % of the mean square height, and carries the load; try --level", page
    )
    assert "<li>" not in surface_page(profile, **scan).body
    assert "alert(1)</script>" not in page
    assert "<b>" not in page
    assert "<code>&lt;i&gt;</code>" in page


def test_report_lists_how_each_file_was_read(tmp_path):
    rows = np.column_stack([0.5 * np.arange(64), np.random.default_rng(0).standard_normal(64)])
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header="x (um),height (um)", comments="")
    (tmp_path / "b.csv").write_text((tmp_path / "a.csv").read_text().replace("(um)", "(nm)"))
    files = [str(tmp_path / f"{name}.csv") for name in "ab"]
    result = pair(*files, load="1 MPa", mu0=0.2, effective_modulus=100.0, offsets=4, onset=0, accept="tall")
    page = html.unescape(report_page(result.source))
    assert [name in page for name in ("How a.csv was read", "How b.csv was read")] == [True, True]
    table = page[page.index("How a.csv was read") :]
    cells = dict(re.findall(r'<th scope="row">(.*?)</th><td>(.*?)</td>', table[: table.index("</table>")]))
    assert cells["layout"] == "positions and heights"
    assert cells["spacing"] == "0.5 µm along x"
    assert cells["unit of heights in the file"] == "um"
    assert cells["missing points"] == "0 of 64"
    assert cells["lines"] == "2 to 65; 1 above and 0 below skipped"
    assert cells["given, not read from the file"] == "accept = tall"
    (tmp_path / "a.csv").unlink()
    assert "How a.csv was read" not in html.unescape(report_page(result.source))


def test_report_of_growing_contacts_names_alpha(tmp_path):
    spacing = write_maps(tmp_path)
    contact = 'load = ["1 mN", "2 mN"]\nhardness = "2 GPa"\njunction_growth = 9'
    study = study_of_files(tmp_path, spacing=spacing, members=3, contact=contact)
    page = html.unescape(report_page(run(study)))
    assert "hardness 2 GPa, junction growth α = 9." in page
