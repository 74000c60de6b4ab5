"""Tests of messages, and of environments in which the command must not end with a traceback."""

import os
import subprocess
import sys
import threading

import pytest
from stiction import read_spectrum
from stiction.cli import application, main
from stiction.surfaces.measured.raw import FormatError
from support.command import assert_rejected, call_stiction, check_stiction

TINY = [
    "--set", "surfaces.fractal_dimension=[1.1]", "--set", "surfaces.points=1000", "--set", "surfaces.extent=1 um",
    "--set", "ensemble.repetitions=2", "--set", "contact.approach.count=3", "--set", 'figures.draw=["area"]',
]  # fmt: skip


def shell(script, *arguments, cwd):
    """Run a shell script in which "$@" is the command."""
    command = ["bash", "-o", "pipefail", "-c", script, "bash", sys.executable, "-m", "stiction", *arguments]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False, timeout=120)


def test_run_continues_after_its_reader_closes_the_pipe(tmp_path):
    completed = shell('"$@" | true', "run", "quick", *TINY, cwd=tmp_path)
    assert completed.returncode == 0
    assert all(line.startswith("repetitions ") for line in completed.stderr.splitlines())  # progress, of a busy machine
    assert (tmp_path / "quick" / "area.png").exists()
    completed = shell('"$@" | true', "studies", "figure6", cwd=tmp_path)
    assert (completed.returncode, completed.stderr) == (0, "")


def test_commands_report_full_disk_and_replace_unencodable_letters(tmp_path):
    completed = shell('"$@" > /dev/full', "studies", cwd=tmp_path)
    assert_rejected(completed, "stiction: ", "No space left on device")
    completed = subprocess.run(
        [sys.executable, "-m", "stiction", "run", "quick", *TINY, "--set", "figures.draw=[]"],
        cwd=tmp_path, capture_output=True, check=False, timeout=120, env=os.environ | {"PYTHONIOENCODING": "latin-1"},
    )  # fmt: skip
    assert (completed.returncode, completed.stderr) == (0, b"")
    assert "?_s [95 %]" in completed.stdout.decode("latin-1")


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (MemoryError(), "stiction: not enough memory for this computation"),
        (RecursionError(), "stiction: the input is nested too deeply"),
        (SystemError("error return without exception set"), "stiction: error return without exception set; a limit"),
        (ImportError("failed to map segment"), "stiction: failed to map segment"),
        (OSError(23, "Too many open files in system", "a\nb"), "stiction: a\\nb: Too many open files in system"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_exhausted_resource_is_reported_in_one_message(tmp_path, monkeypatch, error, words):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr("stiction.studies.pipeline.complete_blocks", fail)
    assert_rejected(call_stiction("run", "quick", *TINY, cwd=tmp_path), words)


def test_interrupt_during_import_gives_no_traceback(monkeypatch):
    def interrupt():
        raise KeyboardInterrupt

    ended = []
    monkeypatch.setattr(application, "start", interrupt)
    monkeypatch.setattr(os, "_exit", ended.append)
    with pytest.raises(SystemExit):
        main()
    assert ended == [130]


def test_failed_thread_start_is_reported_in_one_message(tmp_path, monkeypatch):
    """A limit on processes stops the command before it creates a result."""

    def refuse(_):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    assert_rejected(call_stiction("run", "quick", *TINY, cwd=tmp_path), "stiction: can't start new thread")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("[surfaces]\npoints = " + "{a=" * 900 + "1" + "}" * 900, "is not TOML"),
        ("[surfaces]\namplitude = " + "[" * 300 + "]" * 300, "surfaces.amplitude[0]"),
        ("k" * 990_000 + " = 1", "kkk: unknown key"),
        ('"\\u001b[31mred\\u0007" = 1', "\\x1b[31mred\\x07: unknown key"),
        ('"a\\nstiction: all is well" = 1', "a\\nstiction: all is well: unknown key"),
    ],
    ids=str.strip,
)
def test_hostile_study_is_rejected_in_short_lines(tmp_path, content, words):
    (tmp_path / "s.toml").write_text(content)
    completed = call_stiction("run", "s.toml", cwd=tmp_path)
    assert_rejected(completed, words)
    assert completed.stderr.replace("\n", "").isprintable()
    assert len(completed.stderr) < 1000
    assert all(line.startswith("stiction: s.toml: ") for line in completed.stderr.splitlines())


def test_pipes_and_devices_are_rejected_as_inputs(tmp_path):
    for name in ("fifo.toml", "fifo.csv"):
        os.mkfifo(tmp_path / name)  # which would be waited for
    for name in ("fifo.toml", "/dev/zero"):
        assert_rejected(call_stiction("run", name, "-o", "o", cwd=tmp_path), f"{name}: is not a regular file")
    assert_rejected(call_stiction("characterise", "fifo.csv", cwd=tmp_path), "fifo.csv: is not a file")
    with pytest.raises(FormatError, match="is not a regular file"):
        read_spectrum(tmp_path / "fifo.csv")


def test_names_of_any_kind_are_printed_on_one_line(tmp_path):
    for name in ("a\nstiction: all is well", "\x1b[31m", "a/b" * 1500, "x" * 5000):
        completed = call_stiction("info", name, cwd=tmp_path)
        assert_rejected(completed, "stiction: ")
        assert len(completed.stderr.splitlines()) == 1
        assert len(completed.stderr) < 500
        assert completed.stderr.strip().isprintable()


def test_reports_and_exports_accept_long_names(tmp_path):
    check_stiction("run", "quick", *TINY, "-o", ".", cwd=tmp_path)
    long = "x" * 240
    for command, option, end in (("report", "--output=", ".html"), ("export", "", ".nc"), ("export", "", ".csv")):
        check_stiction(command, ".", f"{option}{long}{end}", cwd=tmp_path)
        assert (tmp_path / f"{long}{end}").stat().st_size > 1000


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (("characterize", "scan.csv"), "did you mean characterise?"),
        (("pair", "a.csv", "b.csv", "--mu0", 0.2, "--load", "1 mN", "--mechanics", "halfspace"), "half-space?"),
    ],
)
def test_command_suggests_nearest_known_word(arguments, hint, tmp_path):
    assert_rejected(call_stiction(*arguments, cwd=tmp_path), hint)


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_command_with_closed_streams_computes_and_writes(tmp_path, closed):
    completed = shell(f'"$@" {closed}', "run", "quick", *TINY, cwd=tmp_path)
    assert (completed.returncode, completed.stderr) == (0, "" if "2" in closed else completed.stderr)
    assert "Traceback" not in completed.stderr
    assert (tmp_path / "quick" / "area.png").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits address space")
@pytest.mark.parametrize("limit", [150_000, 450_000, 1_040_000])
def test_low_address_space_is_reported_in_one_message(tmp_path, limit):
    completed = shell(f'ulimit -v {limit}; "$@"', "run", "quick", *TINY, cwd=tmp_path)
    assert_rejected(completed, "memory is limited to", "at least 1073 MB")


EMPTY = [
    (["pair", "", "lower.csv"], "UPPER"), (["pair", "upper.csv", ""], "LOWER"),
    (["pair", "a.csv,,b.csv", "c"], "UPPER"), (["pair", "--gap", ""], "--gap"),
    (["pair", "a.csv", "b.csv", "-o", ""], "--output"),
    (["run", "quick", "--output="], "--output"), (["info", ""], "DIR"), (["characterise", "a.csv", ""], "FILE"),
    (["calibrate", "--pair", "", "--load", "1 mN", "--measured", "0.2"], "--pair"),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "name"), EMPTY, ids=str)
def test_empty_name_is_rejected(tmp_path, arguments, name):
    (tmp_path / "scan.csv").write_text("0,1\n1,2\n")
    more = ["--effective-modulus", "1 GPa", "--load", "1 mN", "--mu0", "0.2"] if arguments[0] == "pair" else []
    assert_rejected(call_stiction(*arguments, *more, cwd=tmp_path), name, "empty")
    assert [path.name for path in tmp_path.iterdir()] == ["scan.csv"]
