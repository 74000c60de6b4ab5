"""Measure how many repetitions per second idle Dask workers can store, and how many workers this rate supports.

The cluster consists of two workers on this machine and the scheduling process. Workers write the blocks themselves, or
send them.
"""

import multiprocessing
import pickle
import statistics
import tempfile
import time
from concurrent.futures import Executor, ProcessPoolExecutor
from pathlib import Path

import numpy as np
from measure import median_time
from stiction import Study
from stiction.solve import runner
from stiction.solve.layout import compute_bytes_per_member, stack_members
from stiction.solve.member_solution import compute_member_arrays
from stiction.solve.store import encode_members

STUDY_NAMES = ("figure6", "figure6-areal", "figure6-half-plane")
NUM_BLOCKS = 60
"""Number of blocks that each run stores."""

NUM_DIFFERENT_MEMBERS = 7
"""Number of different repetitions, which are stored again and again."""

NUM_RUNS = 3
"""Number of runs with and without a shared directory. The median of the runs is reported."""

_compute_block_by_solver = runner.compute_block


class StoredContactSumsReader:
    """Task that computes nothing: each process reads stored sums from a file once, and returns them."""

    def __init__(self, path: str, has_shared_directory: bool) -> None:
        self.path = path
        self.has_shared_directory = has_shared_directory

    def __call__(self, version: str, study: Study, directory: runner.SharedResultDirectory, members: range) -> object:
        if self.path not in _stored_sums_by_path:
            _stored_sums_by_path[self.path] = pickle.loads(Path(self.path).read_bytes())
        runner.compute_member_arrays = lambda _, member: _stored_sums_by_path[self.path][member % NUM_DIFFERENT_MEMBERS]
        return _compute_block_by_solver(
            version,
            study,
            directory if self.has_shared_directory else runner.SharedResultDirectory(Path("/nowhere"), ""),
            members,
        )


_stored_sums_by_path: dict[str, list[dict]] = {}


def randomise_sums(sums: dict) -> list[dict]:
    """Return copies of the contact sums of a repetition with random changes, which compress like real sums."""
    generator = np.random.default_rng(0)

    def randomise_values(values: np.ndarray) -> np.ndarray:
        if values.dtype.kind == "i":
            return values + (values > 0) * generator.integers(0, 9, values.shape)
        return values * generator.lognormal(0, 0.5, values.shape)

    return [{name: randomise_values(values) for name, values in sums.items()} for _ in range(NUM_DIFFERENT_MEMBERS)]


def measure_storage_rates(
    study: Study, sums: list[dict], executor: Executor, *, has_shared_directory: bool
) -> tuple[float, float]:
    """Return the number of repetitions stored per second, and the scheduler's processor time (s) per repetition."""
    with tempfile.TemporaryDirectory() as directory:
        sums_file = Path(directory) / "sums.pickle"
        sums_file.write_bytes(pickle.dumps(sums))
        runner.compute_block = StoredContactSumsReader(str(sums_file), has_shared_directory)
        block_size = runner.choose_block_size(study)
        num_parts = -(-study.ensemble.repetitions // (block_size * NUM_BLOCKS))
        try:
            # The first run is not measured, because it imports all modules.
            runner.compute_missing_blocks(study, Path(directory) / "r", part=(2, num_parts), executor=executor)
            start, driver_start = time.perf_counter(), time.process_time()
            num_stored = runner.compute_missing_blocks(
                study, Path(directory) / "r", part=(1, num_parts), executor=executor
            )
            return num_stored / (time.perf_counter() - start), (time.process_time() - driver_start) / num_stored
        finally:
            runner.compute_block = _compute_block_by_solver


def run_benchmark() -> list[tuple[str, str]]:
    rows = []
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as executor:
        for name in STUDY_NAMES:
            study = Study.named(name).with_changes({"ensemble.repetitions": 1_000_000})
            is_half_plane = name == "figure6-half-plane"  # one run of this study takes 90 s
            reduced_study = study.with_changes({"surfaces.fractal_dimension": [1.2]}) if is_half_plane else study
            num_dimensions = study.surfaces.fractal_dimensions().size if is_half_plane else 1
            sums = compute_member_arrays(reduced_study, 0)
            member_time = num_dimensions * median_time(
                lambda reduced_study=reduced_study: compute_member_arrays(reduced_study, 1), 1 if is_half_plane else 3
            )
            members = randomise_sums({name: values.repeat(num_dimensions, axis=0) for name, values in sums.items()})
            block_size = runner.choose_block_size(study)
            block = stack_members(study, [members[i % NUM_DIFFERENT_MEMBERS] for i in range(block_size)])
            encode_members(study, range(block_size), block)
            writing_time = (
                median_time(
                    lambda study=study, block_size=block_size, block=block: encode_members(
                        study, range(block_size), block
                    ),
                    5,
                )
                / block_size
            )
            results_by_run = [
                (
                    measure_storage_rates(study, members, executor, has_shared_directory=True),
                    measure_storage_rates(study, members, executor, has_shared_directory=False),
                )
                for _ in range(NUM_RUNS)
            ]
            worker_storage_rate, driver_time = (
                statistics.median(worker_result[i] for worker_result, _ in results_by_run) for i in range(2)
            )
            driver_storage_rate = statistics.median(driver_result[0] for _, driver_result in results_by_run)
            rows += [
                (f"repetition of {name}: time on one core", f"{member_time:.3g} s"),
                ("... size of the stored sums", f"{compute_bytes_per_member(study) / 1e3:.0f} kB"),
                ("... repetitions in a block", f"{block_size}"),
                (
                    "... time to encode the sums, and fraction of the computing time",
                    f"{1e3 * writing_time:.2g} ms, {100 * writing_time / member_time:.2f} %",
                ),
                ("... repetitions per second that two idle workers store", f"{worker_storage_rate:.0f}"),
                ("... repetitions per second that the driver stores for two workers", f"{driver_storage_rate:.0f}"),
                ("... processor time of the driver per repetition", f"{1e6 * driver_time:.0f} µs"),
                ("... number of workers that one driver supports", f"{member_time / driver_time:.0f}"),
            ]
    return rows
