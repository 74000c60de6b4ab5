"""Test the evaluation of functions in a forked process.

Scripts run in processes of their own, because a process with several threads, as of pytest, is not copied.
"""

import os
import subprocess
import sys
import textwrap
import time

import pytest
from stiction import Study, run
from stiction.solve import executors
from stiction.views.figures import draw_figures
from stiction.views.report import save_report

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or len(os.sched_getaffinity(0)) < 2, reason="copies need Linux and two cores"
)


def run_script(script):
    """Run a script with `evaluate_in_copy` and the process id `pid`, and return its output. Errors fail the test."""
    start = "import os, signal, sys, threading, time\nfrom stiction.solve.executors import evaluate_in_copy\n"
    code = f"{start}pid = os.getpid()\n{textwrap.dedent(script)}"
    completed = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, start_new_session=True, check=False
    )
    assert completed.stderr == ""
    return completed.stdout.split()


def test_function_is_evaluated_in_a_forked_process():
    script = """
        print("printed once")
        with evaluate_in_copy(lambda: (os.getpid(), bytes(10**6))) as get_value:
            number, content = get_value()
        print(number == pid, len(content))
    """
    assert run_script(script) == ["printed", "once", "False", "1000000"]


@pytest.mark.parametrize(
    "preparation",
    [
        "threading.Thread(target=time.sleep, args=(1,)).start()",
        "os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])",
    ],
    ids=["several threads", "one core"],
)
def test_function_is_evaluated_without_a_fork_if_forking_is_unsafe_or_useless(preparation):
    script = f"""
        {preparation}
        with evaluate_in_copy(os.getpid) as get_number:
            print(get_number() == pid)
    """
    assert run_script(script) == ["True"]


@pytest.mark.parametrize("end", ["os.kill(os.getpid(), signal.SIGKILL)", "1 / 0", "(each for each in [1])"])
def test_function_is_evaluated_again_if_the_forked_process_returns_no_value(end):
    """Check a copy that is killed, an error in the copy, and a value that cannot be sent."""
    script = f"""
        def count():
            return 5 if os.getpid() == pid else {end}
        with evaluate_in_copy(count) as get_value:
            print(get_value())
    """
    assert run_script(script) == ["5"]


def test_error_in_a_forked_process_is_raised_in_its_parent():
    script = """
        def fail():
            raise ValueError("reason")
        try:
            with evaluate_in_copy(fail) as get_value:
                get_value()
        except ValueError as error:
            print(error)
    """
    assert run_script(script) == ["reason"]


def test_forked_process_ends_if_its_result_is_not_requested():
    script = """
        import multiprocessing
        start = time.monotonic()
        try:
            with evaluate_in_copy(lambda: time.sleep(30)):
                print(len(multiprocessing.active_children()))
                raise ValueError
        except ValueError:
            print(len(multiprocessing.active_children()), time.monotonic() - start < 10)
    """
    assert run_script(script) == ["1", "0", "True"]


def test_forked_process_ends_if_its_parent_is_killed():
    """The script ends with its last process, because the copy inherits the standard output."""
    script = """
        with evaluate_in_copy(lambda: time.sleep(50)):
            time.sleep(0.5)
            print("killed", flush=True)
            os.kill(pid, signal.SIGKILL)
    """
    start = time.monotonic()
    assert run_script(script) == ["killed"]
    assert time.monotonic() - start < 40


def test_interrupt_ends_the_forked_process_without_a_message():
    """Send the interrupt to all processes, as a terminal does."""
    script = """
        def interrupt_all():
            os.killpg(0, signal.SIGINT)
            time.sleep(30)
        start = time.monotonic()
        try:
            with evaluate_in_copy(interrupt_all) as get_value:
                get_value()
        except KeyboardInterrupt:
            print("interrupted", time.monotonic() - start < 10)
    """
    assert run_script(script) == ["interrupted", "True"]


@pytest.fixture(scope="module")
def stored_result(tmp_path_factory):
    """Return a stored result of a few members with two figures."""
    changes = {
        "surfaces.fractal_dimension.count": 3, "surfaces.points": 3000, "friction.mu0": [0.4],
        "ensemble.repetitions": 2,
    }  # fmt: skip
    return run(Study.named("quick").with_changes(changes), store=tmp_path_factory.mktemp("stored") / "small")


def test_report_evaluated_in_a_forked_process_equals_a_report_evaluated_without_fork(stored_result, tmp_path):
    script = f"""
        from stiction.cli import main
        sys.argv = ["stiction", "report", {str(stored_result.path)!r}, "-o", {str(tmp_path / "copy.html")!r}]
        main()
    """
    run_script(script)
    save_report(stored_result, tmp_path / "one.html", name="small")
    assert (tmp_path / "copy.html").read_bytes() == (tmp_path / "one.html").read_bytes()


def test_figures_and_numbers_of_a_report_are_evaluated_in_two_forked_processes(stored_result):
    script = f"""
        from stiction import open_result
        from stiction.views.report import pictures, result
        compose_content = result._compose_content
        def print_process_number(name, value):
            print(name, os.getpid() == pid, os.getpid(), flush=True)
            return value
        result._compose_content = lambda *arguments: print_process_number("numbers", compose_content(*arguments))
        pictures.draw_panels = lambda data: print_process_number("figures", {{True: "", False: ""}})
        result.report_page(open_result({str(stored_result.path)!r}))
    """
    words = run_script(script)
    assert {(name, is_original) for name, is_original in zip(words[::3], words[1::3], strict=True)} == {
        ("numbers", "False"), ("figures", "False"),
    }  # fmt: skip
    assert len(set(words[2::3])) == 2


def test_figures_drawn_by_two_processes_equal_figures_drawn_by_one_process(stored_result, tmp_path, monkeypatch):
    (tmp_path / "two").mkdir()
    script = f"""
        from stiction import open_result
        from stiction.views.figures import draw_figures
        result = open_result({str(stored_result.path)!r})
        paths = draw_figures(result, {str(tmp_path / "two")!r}, formats=["svg"])
        print(*[path.name for path in paths], sum(os.times()[2:4]) > 0)
    """
    *names, used_copy = run_script(script)
    assert used_copy == "True"

    def fail_if_started(*_):
        raise AssertionError("a process was started")

    (tmp_path / "one").mkdir()
    monkeypatch.setattr(executors, "num_usable_cores", lambda: 1)
    monkeypatch.setattr(executors, "_start_without_interrupts", fail_if_started)
    paths = draw_figures(stored_result, tmp_path / "one", formats=["svg"])
    assert [path.name for path in paths] == names
    assert len(names) == 2
    for name in names:
        assert (tmp_path / "two" / name).read_bytes() == (tmp_path / "one" / name).read_bytes()
