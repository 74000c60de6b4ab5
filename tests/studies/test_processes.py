import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from stiction import Study, run
from stiction.mechanics.quantities import SUMS
from stiction.studies import runner
from stiction.studies.processes import MOST_DEATHS, WorkerError, processes
from stiction.studies.study_text import StudyError

STUDY = Study().with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 3},
        "surfaces.points": 20_000,
        "surfaces.extent": "5 um",
        "contact.approach.count": 5,
        "ensemble.repetitions": 12,
    }
)
LONG = ["--set", "ensemble.repetitions=100000", "--set", "surfaces.points=20000", "--set", "surfaces.extent=5 um"]
PATIENCE = 60.0
"""Seconds for what takes one or two where nothing else runs."""


@pytest.fixture
def two_workers():
    with processes(2) as executor:
        yield executor


@pytest.fixture(scope="module")
def by_threads():
    return run(STUDY)


def assert_same_bits(one, other):
    for name in SUMS:
        assert one[name].values.tobytes() == other[name].values.tobytes(), name


def state_and_parent(process):
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[:2]
    except OSError:
        return "Z", "0"


def children(process):
    """Processes that another has started, and that have not ended."""
    numbers = [int(path.name) for path in Path("/proc").glob("[0-9]*")]
    found = {number: state_and_parent(number) for number in numbers}
    return {number for number, (state, parent) in found.items() if parent == str(process) and state != "Z"}


def wait_until(what):
    deadline = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_processes_give_the_bits_of_threads(two_workers, by_threads):
    assert_same_bits(run(STUDY, executor=two_workers), by_threads)


def test_each_is_a_process_of_its_own(two_workers):
    assert os.getpid() not in {two_workers.submit(os.getpid).result() for _ in range(8)}


def test_a_worker_that_dies_is_replaced(two_workers):
    """At any moment from its start on; those that are left go on."""
    study = STUDY.with_changes({"ensemble.repetitions": 40, "surfaces.fractal_dimension.count": 12})
    before, killed, over = children(os.getpid()), [], threading.Event()

    def kill():
        while len(killed) < MOST_DEATHS - 1 and not over.wait(0.2):
            for worker in list(children(os.getpid()) - before)[:1]:
                os.kill(worker, signal.SIGKILL)
                killed.append(worker)

    killer = threading.Thread(target=kill)
    killer.start()
    result = run(study, executor=two_workers)
    over.set()
    killer.join()
    assert killed
    assert_same_bits(result, run(study))


def test_a_task_that_kills_every_worker_is_given_up(two_workers):
    with pytest.raises(WorkerError, match="died: ended by signal 9"):
        two_workers.submit(suicide).result()
    assert two_workers.submit(int, "7").result() == 7
    assert MOST_DEATHS > 1


def suicide():
    os.kill(os.getpid(), signal.SIGKILL)


def test_what_a_task_raises_is_raised_here(two_workers):
    for error in (ValueError, OSError, EOFError, MemoryError, KeyboardInterrupt):
        with pytest.raises(error, match="told"):
            two_workers.submit(raise_, error).result()
    with pytest.raises(RuntimeError, match="UnpicklableError: told"):
        two_workers.submit(raise_, UnpicklableError).result()


class UnpicklableError(Exception):
    def __init__(self, what):
        super().__init__(what)
        self.handle = threading.Lock()


def raise_(error):
    raise error("told")


def test_a_worker_with_another_version_is_refused(two_workers, monkeypatch):
    monkeypatch.setattr(runner, "__version__", "0.0.1")
    with pytest.raises(StudyError, match=r"the worker on .* has stiction .*, and 0\.0\.1 asks for the study"):
        run(STUDY, executor=two_workers)


def start(cwd, **options):
    command = [sys.executable, "-m", "stiction", "run", "quick", "--cluster", "2", *LONG]
    process = subprocess.Popen(
        command, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True, **options
    )
    complete = cwd / "quick" / "result.zarr" / "complete"
    wait_until(lambda: process.poll() is not None or (complete / "c.3").exists())
    return process


def test_nobody_else_can_reach_the_workers(tmp_path):
    """No process of the run listens to anything."""
    process = start(tmp_path)
    try:
        family = [process.pid, *children(process.pid)]
        assert len(family) == 4  # with the one that draws
        held = {os.readlink(file) for each in family for file in Path(f"/proc/{each}/fd").iterdir()}
        listening = [
            row
            for table, column, state, inode in (("tcp", 3, "0A", 9), ("tcp6", 3, "0A", 9), ("unix", 3, "00010000", 6))
            for row in map(str.split, Path(f"/proc/net/{table}").read_text().splitlines()[1:])
            if row[column] == state and f"socket:[{row[inode]}]" in held
        ]
        assert listening == []
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_workers_end_with_the_run_that_they_are_of(tmp_path, number):
    """However that ends; by Ctrl-C, which all of them receive, with one line and nothing lost."""
    process = start(tmp_path)
    workers = children(process.pid)
    if number == signal.SIGINT:
        os.killpg(process.pid, number)
    else:
        process.send_signal(number)
    said, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == (130 if number == signal.SIGINT else -number)
    ahead, *rest = said.splitlines()
    assert ahead.startswith("to compute: 100000 repetitions, ")
    assert rest == [] or (number == signal.SIGINT and rest[0].startswith("stiction: interrupted; "))
    assert len(rest) <= 1
    wait_until(lambda: all(state_and_parent(worker)[0] == "Z" for worker in workers))
