"""Test runs of studies: results, executors, interrupts, memory limits and progress."""

import builtins
import contextlib
import importlib.util
import math
import multiprocessing
import os
import signal
import threading
import time
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pytest
import stiction
from stiction import Study, _files, press, random_phases, run, weierstrass_mandelbrot
from stiction.mechanics import half_space_problem
from stiction.mechanics.quantities import SUM_QUANTITIES
from stiction.solve import executors, member_solution, runner
from stiction.solve.layout import compute_bytes_per_member
from stiction.solve.member_solution import compute_member_arrays, estimate_member_time
from stiction.solve.store import StoreError
from stiction.study import members
from stiction.study.study import parse_study_of_dataset
from stiction.study.values import StudyError
from support.generated_studies import TINY_STUDY, InlineExecutor, assert_same_bits, with_repetitions
from support.studies_of_files import create_study_from_files, write_maps
from support.thread_limits import allow_one_new_thread

RUNNER_STUDY = TINY_STUDY.with_changes(
    {
        "surfaces.fractal_dimension.count": 4,
        "surfaces.points": 5000,
        "surfaces.directions": 40,
        "surfaces.frequencies": 40,
        "contact.approach.count": 6,
        "ensemble.repetitions": 5,
    }
)


@pytest.fixture(scope="module")
def result():
    return run(RUNNER_STUDY).dataset


def test_results_of_a_run_equal_load_curves_of_single_pairs(result):
    assert result["normal_elastic"].shape == (4, 2, 5, 6)
    assert result["contact_count"].values.sum() > 1000
    for d, a, r in ((0, 0, 0), (2, 1, 3), (3, 0, 4)):
        upper, lower = (
            weierstrass_mandelbrot(
                random_phases(2016, repetition=r, side=side), result["fractal_dimension"].values[d], points=5000,
                extent=2.0,
            ).with_amplitude((0.05, 0.1)[a])
            for side in ("upper", "lower")
        )  # fmt: skip
        curve = press(upper, lower, result["approach"].values)
        for name in SUM_QUANTITIES:
            assert np.array_equal(result[name].values[d, a, r], getattr(curve, name)), name


def test_result_of_a_run_depends_on_every_study_key(result):
    """Check that a change of each key changes the result."""
    changes = {
        "surfaces.amplitude_measure": "Rq", "surfaces.length_scale": "0.9 um", "surfaces.extent": "2.1 um",
        "surfaces.points": 5001, "surfaces.gamma": 1.6, "surfaces.directions": 39, "surfaces.frequencies": 39,
        "surfaces.convention": "classical", "surfaces.band_limit": "nyquist", "contact.effective_modulus": "11 GPa",
        "contact.curvature": "signed", "contact.detection": "gap-minimum", "contact.law": "hertz-cylinder",
        "contact.shear": "-x", "ensemble.seed": 2017,
    }  # fmt: skip
    for study_key, value in changes.items():
        changed_dataset = run(RUNNER_STUDY.with_changes({study_key: value, "ensemble.repetitions": 1})).dataset
        changed_sums = [
            name
            for name in SUM_QUANTITIES
            if not np.array_equal(changed_dataset[name].values, result[name].values[:, :, :1])
        ]
        assert changed_sums, study_key


def test_results_are_bit_identical_for_all_executors_and_block_sizes(result, monkeypatch):
    for workers in (1, 2):
        with ThreadPoolExecutor(workers) as pool:
            assert_same_bits(run(RUNNER_STUDY, executor=pool).dataset, result)
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        assert_same_bits(run(RUNNER_STUDY, executor=pool).dataset, result)
    monkeypatch.setattr(runner, "MAX_SUBMITTED_TASKS", 2)
    for size in (1, 2, 3, 100):
        monkeypatch.setattr(runner, "choose_block_size", lambda study, size=size: size)
        assert_same_bits(run(RUNNER_STUDY, executor=InlineExecutor()).dataset, result)


def test_results_are_bit_identical_for_all_batch_sizes(result, monkeypatch):
    for rows in (1, 3):
        for module in (members, member_solution):
            monkeypatch.setattr(module, "MAX_BATCH_BYTES", rows * 8 * RUNNER_STUDY.surfaces.points)
        assert_same_bits(run(RUNNER_STUDY).dataset, result)


@pytest.mark.parametrize("points", [500, 1000, 4000, 20_000])
def test_peak_memory_of_a_task_is_within_the_documented_limit(monkeypatch, points):
    """Check the memory limit of a task that the page on clusters (cluster.md) documents."""
    batch_bytes = 8 * 2500
    monkeypatch.setattr(member_solution, "MAX_BATCH_BYTES", batch_bytes)
    allocated_arrays = []
    monkeypatch.setattr(
        member_solution,
        "_get_reused_array",
        lambda shape: allocated_arrays.append(np.empty(shape)) or allocated_arrays[-1],
    )
    study = RUNNER_STUDY.with_changes({"surfaces.points": points, "surfaces.fractal_dimension.count": 10})
    member_solution.compute_member_arrays(study, 0)
    (memory,) = allocated_arrays
    assert memory.nbytes <= max(2 * batch_bytes + 2 * 8 * points, 32 * points)


def test_result_of_a_run_contains_study_and_version_and_units(result):
    assert result.attrs["stiction_version"] == stiction.__version__
    assert parse_study_of_dataset(result) == RUNNER_STUDY
    assert all("units" in result[name].attrs and "long_name" in result[name].attrs for name in result.variables)
    assert result["approach"].attrs["units"] == "um"


@pytest.mark.parametrize("name", ["quick", "figure6", "figure7", "figure6-areal", "figure6-half-plane"])
def test_block_size_limits_the_time_and_memory_of_a_block(name):
    study = Study.named(name)
    for total in (1, 10, 100, 1_000_000):
        size = runner.choose_block_size(with_repetitions(total, study))
        assert 1 <= size <= runner.MAX_BLOCK_MEMBERS
        assert size == 1 or size * estimate_member_time(study) <= runner.TARGET_BLOCK_TIME
        assert size == 1 or size * compute_bytes_per_member(study) <= runner.MAX_BLOCK_BYTES
        assert math.ceil(total / size) >= min(total, 4)
        is_worth_its_file = (size - 1) * estimate_member_time(study) < runner.MIN_BLOCK_TIME
        assert is_worth_its_file or math.ceil(total / size) >= min(total, runner.MIN_BLOCKS_PER_RUN)


def test_pairs_that_are_solved_quickly_are_stored_in_four_blocks_of_equal_size(monkeypatch):
    """Check that blocks have one size, because the first file of each size takes as long as ten members of profiles."""
    monkeypatch.setattr(runner, "estimate_member_time", lambda _: 0.011)
    for total in (16, 64):
        assert runner.choose_block_size(with_repetitions(total, RUNNER_STUDY)) == total // 4


def test_run_of_a_study_with_an_impossible_frequency_ratio_gamma_raises_value_error():
    with pytest.raises(ValueError, match="gamma"):
        run(RUNNER_STUDY.with_changes({"surfaces.gamma": 100.0}))


def test_run_function_rejects_a_study_whose_result_would_exceed_the_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(runner, "compute_member_arrays", lambda *_: pytest.fail("computed"))
    study_of_many_members = RUNNER_STUDY.with_changes({"ensemble.repetitions": 10_000_000})
    with pytest.raises(
        ValueError, match=r"the result would take \d+ GiB of memory, more than the limit of 16 GiB; give a store"
    ):
        run(study_of_many_members)
    dimensions = {"start": 1.0, "stop": 1.9, "count": 10_000}
    study_of_large_members = RUNNER_STUDY.with_changes(
        {"surfaces.fractal_dimension": dimensions, "contact.approach.count": 10_000}
    )
    with pytest.raises(
        ValueError,
        match=r"a repetition would take \d+ GiB of memory, more than the limit of 16 GiB; reduce the number of values "
        r"of contact",
    ):
        runner.compute_missing_blocks(study_of_large_members, tmp_path / "r")
    assert list(tmp_path.iterdir()) == []


def test_interrupt_cancels_tasks_that_are_not_yet_started(monkeypatch):
    computed_repetitions, sums, interrupt_event = (
        [],
        runner.compute_member_arrays(with_repetitions(1), 0),
        threading.Event(),
    )

    def record_repetition_and_wait_for_interrupt(study, number):
        computed_repetitions.append(number)
        if number >= 200:
            interrupt_event.wait(60)
        return sums

    def raise_interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(runner, "compute_member_arrays", record_repetition_and_wait_for_interrupt)
    monkeypatch.setattr(runner, "progress_bar", lambda *_: contextlib.nullcontext(raise_interrupt))
    monkeypatch.setattr(runner, "SHUTDOWN_TIMEOUT", 0.1)
    interrupt_error = None
    with ThreadPoolExecutor(1) as pool:
        try:
            run(with_repetitions(800), executor=pool)
        except KeyboardInterrupt as error:
            interrupt_error = error  # The stored error keeps the frames of the run alive.
            interrupt_event.set()
    assert interrupt_error is not None
    assert len(computed_repetitions) < 800


# ---- Workers that end ------------------------------------------------------------------------------------------------


def test_unexpected_end_of_a_worker_process_is_reported(tmp_path):
    for directory, kind in ((None, StudyError), (tmp_path, StoreError)):
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
            os.kill(pool.submit(os.getpid).result(), signal.SIGKILL)
            with pytest.raises(kind, match=r"^a worker process ended unexpectedly; the available memory"):
                run(TINY_STUDY, executor=pool, store=directory)


# ---- Progress -------------------------------------------------------------------------------------------------------


def test_progress_of_a_run_is_printed_on_request(capfd, monkeypatch):
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    run(with_repetitions(2), progress=True)
    out, err = capfd.readouterr()
    assert "2/2" in out + err


def test_progress_of_a_run_is_not_printed_without_a_terminal(capfd):
    with executors.progress_bar("repetitions", 3, 0, True) as advance:
        for _ in range(3):
            advance()
    assert capfd.readouterr() == ("", "")


def test_progress_of_a_run_is_printed_as_text_in_a_notebook(capfd, monkeypatch):
    """Without ipywidgets, rich would print a warning instead of a progress bar."""
    if importlib.util.find_spec("ipywidgets"):
        pytest.skip("ipywidgets is installed")

    class ZMQInteractiveShell:
        """Stand-in for the shell of a notebook, which rich recognizes by the name of its class."""

    monkeypatch.setattr(builtins, "get_ipython", ZMQInteractiveShell, raising=False)
    run(with_repetitions(2), progress=True)
    assert "2/2" in capfd.readouterr().err


def test_computation_of_missing_pairs_prints_the_estimated_time_only_once(tmp_path):
    announcements = []
    for _ in range(2):
        runner.compute_missing_blocks(RUNNER_STUDY, tmp_path, announce=announcements.append)
    (line,) = announcements
    assert line.startswith("computing 5 repetitions: about ")
    assert line.endswith(" of one core, 23 kB in 5 files")


def test_remaining_time_of_a_run_is_estimated_from_the_time_of_its_first_block():
    missing_pairs = SimpleNamespace(count=16)
    text = runner._format_revised_time_estimate(TINY_STUDY, missing_pairs, 1, 480.0, 2, 8.5)
    assert text == "1 of 16 repetitions took 8 min; the rest takes about 56 min more"
    assert runner._format_revised_time_estimate(TINY_STUDY, missing_pairs, 1, 480.0, 2, 300.0) == text
    # Not printed, because the first estimate was 83 % of the measured time.
    assert runner._format_revised_time_estimate(TINY_STUDY, missing_pairs, 1, 480.0, 2, 400.0) == ""
    # Not printed, because little time remains.
    assert runner._format_revised_time_estimate(TINY_STUDY, missing_pairs, 1, 8.0, 2, 1.0) == ""
    # Not printed, because no repetitions remain.
    assert runner._format_revised_time_estimate(TINY_STUDY, missing_pairs, 4, 480.0, 4, 8.5) == ""


def test_run_computes_with_fewer_threads_if_not_all_threads_can_start(monkeypatch):
    started = allow_one_new_thread(monkeypatch)
    dataset = run(TINY_STUDY).dataset
    monkeypatch.undo()
    assert len(started) == 1
    assert_same_bits(dataset, run(TINY_STUDY, executor=InlineExecutor()).dataset)


def test_run_stops_at_every_error_except_a_load_without_solution(tmp_path, monkeypatch):
    """Check that a member does not store NaN if, for example, a library cannot start a thread."""
    study = create_study_from_files(tmp_path, spacing=write_maps(tmp_path), members=1)

    def fail_to_start_thread(*_, **__):
        raise RuntimeError("Resource temporarily unavailable")

    monkeypatch.setattr(half_space_problem, "grid_slopes", fail_to_start_thread)
    with pytest.raises(RuntimeError, match="Resource temporarily unavailable"):
        compute_member_arrays(study, 0)


class ExecutorThatAgesPartialFiles(Executor):
    """Executor that makes all partial files old before each task, and waits until the files are refreshed."""

    def __init__(self, directory, wait_until_recent):
        self.directory, self.wait_until_recent, self.ages = directory, wait_until_recent, []

    def submit(self, function, /, *args, **kwargs):
        files = list(self.directory.rglob("*.partial"))
        for file in files:
            os.utime(file, (0, 0))
        self.ages.append([self.wait_until_recent(file) for file in files])
        return InlineExecutor.submit(self, function, *args, **kwargs)


@pytest.mark.parametrize("is_removed", [False, True], ids=["old", "removed"])
def test_run_refreshes_its_claim_files_in_the_result_directory_while_it_computes(tmp_path, monkeypatch, is_removed):
    """Check that claims are refreshed, because other machines remove a claim that was not refreshed for an hour."""
    monkeypatch.setattr(_files, "CLAIM_FILE_REFRESH_INTERVAL", 0.01, raising=False)

    def wait_until_recent(file):
        if is_removed:
            file.unlink()
        for _ in range(300):
            with contextlib.suppress(FileNotFoundError):
                if time.time() - file.stat().st_mtime < 60:
                    return True
            time.sleep(0.01)
        return False

    executor = ExecutorThatAgesPartialFiles(tmp_path, wait_until_recent)
    run(with_repetitions(2), store=tmp_path / "result", executor=executor)
    # The first task only tests the directory. Each task finds two claims, one on the directory and one on its blocks.
    assert len(executor.ages) > 1
    assert all(is_recent == [True, True] for is_recent in executor.ages)
    assert list(tmp_path.rglob("*.partial")) == []
