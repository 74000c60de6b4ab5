"""Tests of output files: commands write complete files or none, and replace only files that stiction wrote."""

import csv
import errno

import numpy as np
import pytest
from stiction import _files, open_result, pipeline, self_affine_surface, write_surface
from stiction.cli.result_output import write_pair_files
from stiction.cli.table import table_command
from stiction.solve import store
from support.command import assert_rejected, call_stiction, check_stiction

PAIR_COMMAND = ["pair", "upper.csv", "lower.csv", "--effective-modulus", "80 GPa", "--mu0", "0.2", "--load", "2 mN"]
PAIR_COMMAND += ["--shifts", "2", "--onset", "0"]
TABLE_COMMAND = ["table", "--effective-modulus", "10 GPa", "--hurst", "0.8", "--rms", "10 nm", "--points", "64"]
TABLE_COMMAND += ["--repetitions", "2", "--load", "1 MPa,3 MPa,9 MPa"]
CHARACTERISE_COMMAND = ["characterise", "upper.csv", "upper.csv"]


def create_scan(side, points=32):
    return self_affine_surface(
        5, hurst_exponent=0.8, rms=0.02, shape=(points, points), spacing=0.1, shortest_wavelength=0.5, side=side
    )


@pytest.fixture
def scans_directory(tmp_path):
    for side in ("upper", "lower"):
        write_surface(create_scan(side), tmp_path / f"{side}.csv")
    return tmp_path


COMMANDS_AND_OUTPUTS = [
    (PAIR_COMMAND, "pair/result.csv"),
    (PAIR_COMMAND, "pair/report.html"),
    (PAIR_COMMAND, "pair/friction.png"),
    (PAIR_COMMAND, "pair/onset.csv"),
    (PAIR_COMMAND, "pair/onset.nc"),
    (PAIR_COMMAND, "pair/picture.nc"),
    (TABLE_COMMAND, "table/table.csv"),
    (TABLE_COMMAND, "table/laws.csv"),
    (TABLE_COMMAND, "table/table.nc"),
    (CHARACTERISE_COMMAND, "characterised.csv"),
    ([*CHARACTERISE_COMMAND, "--together"], "joined.csv"),
    ([*CHARACTERISE_COMMAND, "--repeated"], "noise.csv"),
    ([*CHARACTERISE_COMMAND, "--repeated", "--output", "mine.csv"], "mine.csv"),
    (["characterise", "upper.csv"], "upper.html"),
    (["characterise", "upper.csv"], "upper.png"),
]


@pytest.mark.parametrize(("arguments", "name"), COMMANDS_AND_OUTPUTS)
@pytest.mark.parametrize("kind", ["file", "link", "dangling"])
def test_command_does_not_overwrite_a_file_of_another_program(scans_directory, arguments, name, kind):
    path, target = scans_directory / name, scans_directory / "elsewhere"
    path.parent.mkdir(exist_ok=True)
    if kind != "dangling":
        target.write_text("my own measurements")
    if kind == "file":
        target = target.rename(path)
    else:
        path.symlink_to(target)
    completed = call_stiction(*arguments, cwd=scans_directory)
    assert_rejected(completed, f"{path.name}: already exists")
    assert completed.stdout == ""
    assert target.read_text() == "my own measurements" if kind != "dangling" else not target.exists()


def test_csv_table_and_report_of_a_pair_use_mu0_of_an_edited_study_file(scans_directory):
    check_stiction(*PAIR_COMMAND, cwd=scans_directory, without_figures=True)
    directory = scans_directory / "pair"
    result, report = open_result(directory), (directory / "report.html").read_bytes()
    study_file = directory / "study.toml"
    study_file.write_text(study_file.read_text("utf-8").replace("mu0 = [0.2]", "mu0 = [0.4]"), "utf-8")
    write_pair_files(result, print_written=str)
    with (directory / "result.csv").open(encoding="utf-8", newline="") as file:
        assert {row["mu0"] for row in csv.DictReader(file)} == {"0.4"}
    assert (directory / "report.html").read_bytes() != report


@pytest.mark.parametrize("scan_name", ["result.csv", "onset.csv"])
def test_pair_command_does_not_overwrite_its_input_scan(scans_directory, scan_name):
    content = (scans_directory / "upper.csv").rename(scans_directory / scan_name).read_bytes()
    assert_rejected(
        call_stiction("pair", scan_name, *PAIR_COMMAND[2:], "-o", ".", cwd=scans_directory),
        f"{scan_name}: already exists",
    )
    assert (scans_directory / scan_name).read_bytes() == content


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (PAIR_COMMAND, ("result.csv", "report.html", "friction.png")),
        (TABLE_COMMAND, ("table.csv", "laws.csv", "table.nc")),
    ],
)
def test_command_overwrites_its_own_output(scans_directory, arguments, names):
    check_stiction(*arguments, cwd=scans_directory, without_figures=True)
    output_directory = scans_directory / arguments[0]
    inodes = {name: (output_directory / name).stat().st_ino for name in names}
    check_stiction(*arguments, *(["--mu0", "0.3"]), cwd=scans_directory, without_figures=True)
    assert all((output_directory / name).stat().st_ino != inode for name, inode in inodes.items())


def test_characterise_command_does_not_overwrite_any_of_the_repeated_scans(scans_directory):
    content = (scans_directory / "upper.csv").read_bytes()
    completed = call_stiction(*CHARACTERISE_COMMAND, "--repeated", "--output", "upper.csv", cwd=scans_directory)
    assert_rejected(completed, "upper.csv: already exists")
    assert (scans_directory / "upper.csv").read_bytes() == content


def test_export_command_leaves_no_partial_file_on_a_full_disk(scans_directory, monkeypatch):
    check_stiction(*PAIR_COMMAND, cwd=scans_directory, without_figures=True, without_report=True)

    def write_half_and_fail(path, text, **_):
        path.write_bytes(text.encode()[: len(text) // 2])
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(_files.Path, "write_text", write_half_and_fail)
    assert_rejected(call_stiction("export", "pair", "x.csv", cwd=scans_directory), "x.csv: cannot be written")
    assert not (scans_directory / "x.csv").exists()
    assert not list(scans_directory.glob(".stiction*"))


@pytest.mark.parametrize("first_character", ["=", "+", "-", "@"])
def test_csv_table_escapes_file_names_that_spreadsheets_would_read_as_formulas(scans_directory, first_character):
    name = f"{first_character}cmd.csv"
    (scans_directory / "upper.csv").rename(scans_directory / name)
    check_stiction("characterise", "--output", "t.csv", "--", name, "lower.csv", cwd=scans_directory)
    with (scans_directory / "t.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["file"] for row in rows] == [f"'{name}", "lower.csv"]
    assert np.isfinite(float(rows[0]["Ssk"]))


def test_pair_command_prints_the_estimated_time_only_for_long_computations(scans_directory, monkeypatch):
    options = {"cwd": scans_directory, "without_figures": True, "without_report": True}
    command = [*PAIR_COMMAND[: PAIR_COMMAND.index("--onset")], "--onset", "1"]
    tasks = ("computing 2 positions: about ", "onset of sliding: about ")
    short_output = check_stiction(*command, "-o", "short", **options).stderr
    assert not any(task in short_output for task in tasks)
    monkeypatch.setattr(pipeline, "MIN_ANNOUNCED_TIME", 0.0)
    long_output = check_stiction(*command, "-o", "long", **options).stderr
    assert all(task in long_output for task in tasks)
    for side in ("upper", "lower"):  # the smallest maps for which the pair has a cutoff study
        (scans_directory / f"{side}.csv").unlink()
        write_surface(create_scan(side, points=64), scans_directory / f"{side}.csv")
    command += ["--mechanics", "half-space", "--cutoff", "none"]
    half_space_output = check_stiction(*command, "-o", "half-space", **options).stderr
    lines = [line for line in half_space_output.splitlines() if " of one core" in line]
    assert [line.partition("stiction: ")[2].partition(": about ")[0] for line in lines] == [
        "computing 2 positions", "cutoff study after the result", "cutoff study", "onset of sliding",
    ]  # fmt: skip


def test_table_command_overwrites_a_table_that_an_identical_command_wrote_during_the_run(tmp_path, monkeypatch):
    def write_and_export(dataset, path, **options):
        export(dataset, path)
        export(dataset, path, **options)

    export = store.export
    monkeypatch.setattr(store, "export", write_and_export)
    options = {"effective_modulus": "10 GPa", "hurst": "0.8", "rms": "10 nm", "load": "1 MPa,3 MPa,9 MPa"}
    table_command(**options, points=64, repetitions=2, output=tmp_path / "table")
    assert (tmp_path / "table" / "laws.csv").exists()


def test_info_command_prints_a_sentence_for_each_load_even_if_the_result_must_not_be_quoted(scans_directory):
    loads = ["--load", "1 uN,2 mN,8 mN"]
    command = [word for word in PAIR_COMMAND if word not in ("--load", "2 mN")]
    call_stiction(*command, *loads, cwd=scans_directory, without_figures=True, without_report=True)
    sentences = call_stiction("info", "pair", "--sentence", cwd=scans_directory).stdout.splitlines()
    result = open_result(scans_directory / "pair")
    assert sentences == result.sentence.splitlines()
    points = result.summary().reported_points
    assert [point.assessment == "Do not quote" for point in points] == [
        sentence.startswith("There is no coefficient to quote") for sentence in sentences
    ]
    assert len(sentences) == 3
    for sentence, pressure_load in zip(sentences, ("1 µN", "2 mN", "8 mN"), strict=True):
        assert f"at {pressure_load} (" in sentence
    for option in ("--json", "--verbose"):
        assert_rejected(
            call_stiction("info", "pair", "--sentence", option, cwd=scans_directory), "--sentence must not be combined"
        )


def test_file_name_with_a_latex_instruction_is_escaped_in_all_outputs(scans_directory):
    name = r"$\write18{id}$.csv"
    (scans_directory / "upper.csv").rename(scans_directory / name)
    check_stiction("pair", name, *PAIR_COMMAND[2:], "-o", "mine", cwd=scans_directory)
    assert (scans_directory / "mine/friction.png").stat().st_size > 1000
    report = (scans_directory / "mine/report.html").read_text(encoding="utf-8")
    assert r"$\write18{id}$" in report
    for output in ("table.tex", "table.csv"):
        check_stiction("export", "mine", output, cwd=scans_directory)
    assert r"\write18" not in (scans_directory / "table.tex").read_text(encoding="utf-8")
    check_stiction("characterise", name, "lower.csv", "-o", "scans.csv", cwd=scans_directory)
    with (scans_directory / "scans.csv").open(newline="", encoding="utf-8") as file:
        assert [row[0] for row in csv.reader(file)][1:] == [name, "lower.csv"]
    check_stiction("characterise", name, "-o", "scan.html", cwd=scans_directory)
