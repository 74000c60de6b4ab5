"""Tests of error messages, and of environments in which the command must not end with a traceback."""

import gc
import os
import subprocess
import sys
import threading

import pytest
from stiction import read_spectrum
from stiction.cli import application, main
from stiction.surfaces.measured.raw import FormatError
from support.command import assert_rejected, call_stiction, check_stiction

SMALL_STUDY_OPTIONS = [
    "--set", "surfaces.fractal_dimension=[1.1]", "--set", "surfaces.points=1000", "--set", "surfaces.extent=1 um",
    "--set", "ensemble.repetitions=2", "--set", "contact.approach.count=3", "--set", 'figures.draw=["area"]',
]  # fmt: skip


def run_shell_script(script, *arguments, cwd):
    """Run a shell script in which "$@" is the command with its arguments, with buffered output as usual."""
    command = ["bash", "-o", "pipefail", "-c", script, "bash", sys.executable, "-m", "stiction", *arguments]
    environment = os.environ | {"PYTHONUNBUFFERED": ""}
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False, timeout=120, env=environment)


def test_run_command_finishes_even_if_its_output_pipe_is_closed(tmp_path):
    completed = run_shell_script('"$@" | true', "run", "quick", *SMALL_STUDY_OPTIONS, cwd=tmp_path)
    assert completed.returncode == 0
    assert all(line.startswith("repetitions ") for line in completed.stderr.splitlines())
    assert (tmp_path / "quick" / "area.png").exists()
    completed = run_shell_script('"$@" | true', "materials", cwd=tmp_path)
    assert (completed.returncode, completed.stderr) == (0, "")


def test_full_output_device_is_reported_and_unencodable_characters_are_replaced(tmp_path):
    for arguments in (["materials"], ["--help"]):
        completed = run_shell_script('"$@" > /dev/full', *arguments, cwd=tmp_path)
        assert_rejected(completed, "stiction: ", "No space left on device")
    for arguments in (["materials"], ["--help"], []):
        assert run_shell_script('"$@" > /dev/full 2>&1', *arguments, cwd=tmp_path).returncode == 2
    for arguments in (["info", "none"], []):
        assert run_shell_script('"$@" 2> /dev/full', *arguments, cwd=tmp_path).returncode == 2
    completed = subprocess.run(
        [sys.executable, "-m", "stiction", "interfaces"], cwd=tmp_path, capture_output=True, check=False, timeout=120,
        env=os.environ | {"PYTHONIOENCODING": "latin-1"},
    )  # fmt: skip
    assert (completed.returncode, completed.stderr) == (0, b"")
    assert "?0 = " in completed.stdout.decode("latin-1")


@pytest.mark.parametrize(
    ("raised_error", "expected_message"),
    [
        (MemoryError(), "stiction: not enough memory for this computation"),
        (RecursionError(), "stiction: the input is nested too deeply"),
        (SystemError("error return without exception set"), "stiction: error return without exception set; a limit"),
        (ImportError("failed to map segment"), "stiction: failed to map segment"),
        (OSError(23, "Too many open files in system", "a\nb"), "stiction: a\\nb: Too many open files in system"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_exhausted_system_resource_is_reported_without_traceback(tmp_path, monkeypatch, raised_error, expected_message):
    def raise_error(*_, **__):
        raise raised_error

    monkeypatch.setattr("stiction.pipeline.complete_blocks", raise_error)
    assert_rejected(call_stiction("run", "quick", *SMALL_STUDY_OPTIONS, cwd=tmp_path), expected_message)


@pytest.mark.parametrize("workers", [1, 2])
def test_compiled_core_that_lacks_a_required_function_is_reported_as_unfit(tmp_path, monkeypatch, workers):
    monkeypatch.delattr("stiction._core.press_profile_batches")
    completed = call_stiction("run", "quick", *SMALL_STUDY_OPTIONS, "--workers", workers, cwd=tmp_path)
    assert_rejected(completed, "stiction: the compiled part of stiction (_core) does not fit its Python files: build")


def test_compiled_core_that_lacks_an_imported_name_is_reported_as_unfit(monkeypatch, capsys):
    def import_missing_name(**_):
        from stiction._core import missing_name  # noqa: F401

    monkeypatch.setattr(application, "app", import_missing_name)
    assert application.run_command_line() == 2
    assert capsys.readouterr().err.startswith("stiction: the compiled part of stiction (_core) does not fit")


def test_attribute_error_of_another_object_keeps_its_traceback(monkeypatch):
    monkeypatch.setattr(application, "app", lambda **_: object().missing_name)
    with pytest.raises(AttributeError, match="missing_name"):
        application.run_command_line()


def test_command_that_is_interrupted_during_imports_exits_with_status_130(monkeypatch):
    def raise_interrupt():
        raise KeyboardInterrupt

    exit_statuses = []
    monkeypatch.setattr(application, "run_command_line", raise_interrupt)
    monkeypatch.setattr(os, "_exit", exit_statuses.append)
    with pytest.raises(SystemExit):
        main()
    assert exit_statuses == [130]


@pytest.mark.parametrize("error_type", [ImportError, RuntimeError])
def test_import_error_caused_by_an_interrupt_is_reported_as_an_interrupt(monkeypatch, capsys, error_type):
    """An extension module that is interrupted while it is imported raises ImportError."""

    def raise_error(**_):
        raise error_type("initialization failed") from KeyboardInterrupt()

    monkeypatch.setattr(application, "app", raise_error)
    monkeypatch.setattr(application.signal, "signal", lambda *_: None)
    assert application.run_command_line() == 130
    assert capsys.readouterr().err == "stiction: interrupted\n"


def test_deletion_of_a_partly_constructed_object_prints_no_error(monkeypatch, capfd):
    class PartlyConstructedObject:
        def __del__(self):
            self.file.close()

    monkeypatch.setattr(sys, "unraisablehook", application._handle_unraisable)
    PartlyConstructedObject()
    gc.collect()
    assert capfd.readouterr().err == ""


def test_short_command_runs_without_garbage_collection(tmp_path):
    """Check that a command avoids garbage collections, each of which visits the objects of all imported libraries."""
    script = (
        "import atexit, gc, sys, stiction.cli; collections = []; gc.collect(); gc.freeze(); "
        "gc.callbacks.append(lambda phase, info: collections.append(gc.get_threshold()[0])); "
        "atexit.register(lambda: print(sum(each > 700 for each in collections), file=sys.stderr)); "
        f"sys.argv = ['stiction', 'run', 'quick', *{SMALL_STUDY_OPTIONS}]; stiction.cli.main()"
    )
    completed = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert completed.stderr.splitlines()[-1] == "0"


def test_failed_thread_start_is_reported_without_traceback(tmp_path, monkeypatch):
    """Check that a command that cannot start a thread ends before it creates a result."""

    def fail_to_start(_):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", fail_to_start)
    assert_rejected(
        call_stiction("run", "quick", *SMALL_STUDY_OPTIONS, cwd=tmp_path), "stiction: can't start new thread"
    )
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("study_text", "expected_message"),
    [
        ("[surfaces]\npoints = " + "{a=" * 900 + "1" + "}" * 900, "is not valid TOML"),
        ("[surfaces]\namplitude = " + "[" * 300 + "]" * 300, "surfaces.amplitude[0]"),
        ("k" * 990_000 + " = 1", "kkk: unknown key"),
        ("k" + ".k" * 490_000 + " = 1", "is nested too deeply"),
        ("table = {k" + ".k" * 490_000 + " = 1}", "is nested too deeply"),
        ("[k" + ".k" * 490_000 + "]", "is nested too deeply"),
        ('"\\u001b[31mred\\u0007" = 1', "\\x1b[31mred\\x07: unknown key"),
        ('"a\\nstiction: all is well" = 1', "a\\nstiction: all is well: unknown key"),
    ],
    ids=lambda text: text[:20].strip(),
)
def test_malicious_study_file_is_rejected_with_a_short_printable_error(tmp_path, study_text, expected_message):
    (tmp_path / "s.toml").write_text(study_text)
    completed = call_stiction("run", "s.toml", cwd=tmp_path)
    assert_rejected(completed, expected_message)
    assert completed.stderr.replace("\n", "").isprintable()
    assert len(completed.stderr) < 1000
    assert all(line.startswith("stiction: s.toml: ") for line in completed.stderr.splitlines())


def test_commands_reject_pipes_and_devices_as_input_files(tmp_path):
    for name in ("fifo.toml", "fifo.csv"):
        # Opening a pipe for reading waits until another program opens the pipe for writing.
        os.mkfifo(tmp_path / name)
    for name in ("fifo.toml", "/dev/zero"):
        assert_rejected(call_stiction("run", name, "-o", "o", cwd=tmp_path), f"{name}: is not a regular file")
    assert_rejected(call_stiction("characterise", "fifo.csv", cwd=tmp_path), "fifo.csv: is not a file")
    with pytest.raises(FormatError, match="is not a regular file"):
        read_spectrum(tmp_path / "fifo.csv")


def test_unprintable_file_name_is_escaped_in_a_one_line_error(tmp_path):
    for name in ("a\nstiction: all is well", "\x1b[31m", "a/b" * 1500, "x" * 5000):
        completed = call_stiction("info", name, cwd=tmp_path)
        assert_rejected(completed, "stiction: ")
        assert len(completed.stderr.splitlines()) == 1
        assert len(completed.stderr) < 500
        assert completed.stderr.strip().isprintable()


def test_report_command_and_export_command_accept_long_file_names(tmp_path):
    check_stiction("run", "quick", *SMALL_STUDY_OPTIONS, "-o", ".", cwd=tmp_path)
    long_name = "x" * 240
    for command, option, file_ending in (
        ("report", "--output=", ".html"),
        ("export", "", ".nc"),
        ("export", "", ".csv"),
    ):
        check_stiction(command, ".", f"{option}{long_name}{file_ending}", cwd=tmp_path)
        assert (tmp_path / f"{long_name}{file_ending}").stat().st_size > 1000


@pytest.mark.parametrize(
    ("arguments", "suggestion"),
    [
        (("characterize", "scan.csv"), "did you mean characterise?"),
        (("pair", "a.csv", "b.csv", "--mu0", 0.2, "--load", "1 mN", "--mechanics", "halfspace"), "half-space?"),
    ],
)
def test_error_about_a_misspelt_command_or_choice_suggests_a_correction(arguments, suggestion, tmp_path):
    assert_rejected(call_stiction(*arguments, cwd=tmp_path), suggestion)


@pytest.mark.parametrize("redirections", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_command_writes_its_result_even_if_standard_streams_are_closed(tmp_path, redirections):
    completed = run_shell_script(f'"$@" {redirections}', "run", "quick", *SMALL_STUDY_OPTIONS, cwd=tmp_path)
    assert (completed.returncode, completed.stderr) == (0, "" if "2" in redirections else completed.stderr)
    assert "Traceback" not in completed.stderr
    assert (tmp_path / "quick" / "area.png").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits address space")
@pytest.mark.parametrize("limit", [150_000, 450_000, 1_040_000])
def test_low_memory_limit_is_reported_without_traceback(tmp_path, limit):
    completed = run_shell_script(f'ulimit -v {limit}; "$@"', "run", "quick", *SMALL_STUDY_OPTIONS, cwd=tmp_path)
    assert_rejected(completed, "memory is limited to", "at least 1073 MB")


INTERRUPT_SCRIPT = """
import _thread, signal
from stiction import cli
def fail(*_):
    raise RuntimeError("can't start new thread")
if not {can_start_thread}:
    _thread.start_new_thread = fail
with cli.exit_on_interrupt():
    signal.raise_signal(signal.SIGINT)
"""
"""Script that is sent the signal of Ctrl-C while it imports modules."""


@pytest.mark.parametrize(
    ("can_start_thread", "status", "message"),
    [(True, 130, "stiction: interrupted\n"), (False, 2, "stiction: no thread can be started; the number of ")],
)
def test_interrupt_signal_is_reported_as_a_thread_limit_error_only_if_threads_cannot_start(
    can_start_thread, status, message
):
    """OpenBLAS raises this signal if it cannot start its threads."""
    script = INTERRUPT_SCRIPT.format(can_start_thread=can_start_thread)
    completed = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=60)
    assert completed.returncode == status
    assert completed.stderr.startswith(message)


THREAD_COUNT_SCRIPT = """
import os, sys
from stiction.cli import main
sys.argv = ["stiction", "pair", "--help"]
try:
    main()
finally:
    assert "numpy" in sys.modules
    print("threads:", len(os.listdir("/proc/self/task")))
"""
"""Script that prints the number of threads of a command after NumPy was imported."""


@pytest.mark.skipif(sys.platform != "linux", reason="the threads of a process are counted in /proc")
def test_command_starts_no_threads_for_linear_algebra():
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    completed = subprocess.run(
        [sys.executable, "-c", THREAD_COUNT_SCRIPT], capture_output=True, text=True, check=False, timeout=60,
        env=environment,
    )  # fmt: skip
    assert completed.stdout.endswith("threads: 1\n")


COMMANDS_WITH_EMPTY_NAMES = [
    (["pair", "", "lower.csv"], "UPPER"), (["pair", "upper.csv", ""], "LOWER"),
    (["pair", "a.csv,,b.csv", "c"], "UPPER"), (["pair", "--gap", ""], "--gap"),
    (["pair", "a.csv", "b.csv", "-o", ""], "--output"),
    (["run", "quick", "--output="], "--output"), (["info", ""], "DIR"), (["characterise", "a.csv", ""], "FILE"),
    (["calibrate", "--pair", "", "--load", "1 mN", "--measured", "0.2"], "--pair"),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "argument_name"), COMMANDS_WITH_EMPTY_NAMES, ids=str)
def test_commands_reject_empty_file_names(tmp_path, arguments, argument_name):
    (tmp_path / "scan.csv").write_text("0,1\n1,2\n")
    required_options = (
        ["--effective-modulus", "1 GPa", "--load", "1 mN", "--mu0", "0.2"] if arguments[0] == "pair" else []
    )
    assert_rejected(call_stiction(*arguments, *required_options, cwd=tmp_path), argument_name, "empty")
    assert [path.name for path in tmp_path.iterdir()] == ["scan.csv"]
