"""Tests of files that commands write: complete or absent, and never replacing a foreign file."""

import csv
import errno

import numpy as np
import pytest
from stiction import _files, open_result, self_affine_surface, write_surface
from stiction.cli.result_output import write_pair_files
from stiction.studies import pipeline
from support.command import assert_rejected, call_stiction, check_stiction

PAIR = ["pair", "upper.csv", "lower.csv", "--effective-modulus", "80 GPa", "--mu0", "0.2", "--load", "2 mN"]
PAIR += ["--shifts", "2", "--onset", "0"]
TABLE = ["table", "--effective-modulus", "10 GPa", "--hurst", "0.8", "--rms", "10 nm", "--points", "64"]
TABLE += ["--repetitions", "2", "--load", "1 MPa,3 MPa,9 MPa"]
SCANS = ["characterise", "upper.csv", "upper.csv"]


def scan(side, points=32):
    return self_affine_surface(
        5, hurst_exponent=0.8, rms=0.02, shape=(points, points), spacing=0.1, shortest_wavelength=0.5, side=side
    )


@pytest.fixture
def folder(tmp_path):
    for side in ("upper", "lower"):
        write_surface(scan(side), tmp_path / f"{side}.csv")
    return tmp_path


OUTPUTS = [
    (PAIR, "pair/result.csv"), (PAIR, "pair/report.html"), (PAIR, "pair/friction.png"), (PAIR, "pair/onset.csv"),
    (PAIR, "pair/onset.nc"), (PAIR, "pair/picture.nc"), (TABLE, "table/table.csv"), (TABLE, "table/laws.csv"),
    (TABLE, "table/table.nc"), (SCANS, "characterised.csv"), ([*SCANS, "--together"], "joined.csv"),
    ([*SCANS, "--repeated"], "noise.csv"), ([*SCANS, "--repeated", "--output", "mine.csv"], "mine.csv"),
    (["characterise", "upper.csv"], "upper.html"), (["characterise", "upper.csv"], "upper.png"),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "name"), OUTPUTS)
@pytest.mark.parametrize("kind", ["file", "link", "dangling"])
def test_command_rejects_output_over_foreign_file(folder, arguments, name, kind):
    path, target = folder / name, folder / "elsewhere"
    path.parent.mkdir(exist_ok=True)
    if kind != "dangling":
        target.write_text("my own measurements")
    if kind == "file":
        target = target.rename(path)
    else:
        path.symlink_to(target)
    completed = call_stiction(*arguments, cwd=folder)
    assert_rejected(completed, f"{path.name}: exists already")
    assert completed.stdout == ""  # before anything is computed
    assert target.read_text() == "my own measurements" if kind != "dangling" else not target.exists()


def test_files_of_pair_agree_with_study_that_another_command_stored(folder, no_figures):
    check_stiction(*PAIR, cwd=folder)
    result, report = open_result(folder / "pair"), (folder / "pair/report.html").read_bytes()
    study = folder / "pair/study.toml"
    study.write_text(study.read_text("utf-8").replace("mu0 = [0.2]", "mu0 = [0.4]"), "utf-8")
    write_pair_files(result, print_written=str)
    with (folder / "pair/result.csv").open(encoding="utf-8", newline="") as file:
        assert {row["mu0"] for row in csv.DictReader(file)} == {"0.4"}
    assert (folder / "pair/report.html").read_bytes() != report


@pytest.mark.parametrize("scan_name", ["result.csv", "onset.csv"])
def test_pair_rejects_directory_whose_output_is_its_own_scan(folder, scan_name):
    content = (folder / "upper.csv").rename(folder / scan_name).read_bytes()
    assert_rejected(call_stiction("pair", scan_name, *PAIR[2:], "-o", ".", cwd=folder), f"{scan_name}: exists")
    assert (folder / scan_name).read_bytes() == content


@pytest.mark.parametrize(("arguments", "names"), [
    (PAIR, ("result.csv", "report.html", "friction.png")), (TABLE, ("table.csv", "laws.csv", "table.nc")),
])  # fmt: skip
def test_command_replaces_its_own_output(folder, arguments, names):
    check_stiction(*arguments, cwd=folder)
    where = folder / arguments[0]
    first = {name: (where / name).stat().st_ino for name in names}
    check_stiction(*arguments, *(["--mu0", "0.3"]), cwd=folder)
    assert all((where / name).stat().st_ino != inode for name, inode in first.items())


def test_characterise_rejects_repeated_scan_as_output(folder):
    content = (folder / "upper.csv").read_bytes()
    completed = call_stiction(*SCANS, "--repeated", "--output", "upper.csv", cwd=folder)
    assert_rejected(completed, "upper.csv: exists already")
    assert (folder / "upper.csv").read_bytes() == content


def test_export_on_full_disk_leaves_no_file(folder, monkeypatch):
    check_stiction(*PAIR, cwd=folder)

    def write_half(path, text, **_):
        path.write_bytes(text.encode()[: len(text) // 2])
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(_files.Path, "write_text", write_half)
    assert_rejected(call_stiction("export", "pair", "x.csv", cwd=folder), "x.csv: cannot be written")
    assert not (folder / "x.csv").exists()
    assert not list(folder.glob(".stiction*"))


@pytest.mark.parametrize("start", ["=", "+", "-", "@"])
def test_csv_quotes_names_that_start_formulas(folder, start):
    name = f"{start}cmd.csv"
    (folder / "upper.csv").rename(folder / name)
    check_stiction("characterise", "--output", "t.csv", "--", name, "lower.csv", cwd=folder)
    with (folder / "t.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["file"] for row in rows] == [f"'{name}", "lower.csv"]
    assert np.isfinite(float(rows[0]["Ssk"]))  # a negative number stays a number


def test_pair_prints_estimated_time_without_terminal(folder, monkeypatch):
    assert "computing" not in check_stiction(*PAIR, "-o", "short", cwd=folder).stderr
    monkeypatch.setattr(pipeline, "MIN_ANNOUNCED_TIME", 0.0)
    assert "computing 2 repetitions: about " in check_stiction(*PAIR, "-o", "long", cwd=folder).stderr
