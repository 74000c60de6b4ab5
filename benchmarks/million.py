"""Measure how long a result of a million repetitions takes to store, open, map and extend.

The sums are synthetic. There are few fractal dimensions and approaches, so that the cost of repetitions dominates.
"""

import os
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from stiction import Study, area_map, friction_map, stiffness_map
from stiction.solve import runner, store
from stiction.solve.member_solution import get_array_shapes_and_types
from stiction.solve.runner import compute_missing_blocks

NUM_REPETITIONS = 1_000_000
NUM_ADDED_REPETITIONS = 10_000
STUDY = Study().with_changes(
    {
        "surfaces.fractal_dimension": [1.2, 1.5],
        "contact.approach.count": 8,
        "friction.mu0": [0.4],
        "friction.tau0": ["0 MPa"],
        "ensemble.repetitions": NUM_REPETITIONS,
    }
)
NUM_DIFFERENT_MEMBERS = 4099
"""Number of different repetitions, a prime number, so that all blocks differ."""


def create_synthetic_sums_function(study: Study) -> Callable[[Study, int], dict]:
    """Return a function that returns synthetic sums: powers of the approach (Hertz) times a random factor."""
    generator = np.random.default_rng(study.ensemble.seed)
    approach_numbers = np.arange(1.0, 1 + study.contact.loading_steps().size)
    stored_members = []
    for _ in range(NUM_DIFFERENT_MEMBERS):
        random_factor = generator.lognormal(0, 1, (study.surfaces.fractal_dimensions().size, 1, 1))
        sums = {}
        for array_index, (name, (shape, dtype)) in enumerate(get_array_shapes_and_types(study).items()):
            values = random_factor * (array_index + approach_numbers) ** 1.5 * (1 + 0.1 * generator.random(shape))
            sums[name] = values.astype(dtype)
        stored_members.append(sums)
    return lambda _, repetition: stored_members[repetition % NUM_DIFFERENT_MEMBERS]


def call_and_time(function: Callable[[], object]) -> tuple[object, float]:
    start = time.perf_counter()
    result = function()
    return result, time.perf_counter() - start


def run_benchmark() -> list[tuple[str, str]]:
    # Blocks have the maximum size, because synthetic repetitions take no time.
    original_functions = runner.compute_member_arrays, runner.estimate_member_time
    runner.compute_member_arrays, runner.estimate_member_time = create_synthetic_sums_function(STUDY), lambda _: 0.0
    try:
        with tempfile.TemporaryDirectory() as directory:
            result_directory = Path(directory) / "r"
            _, writing_time = call_and_time(lambda: compute_missing_blocks(STUDY, result_directory))
            num_files = sum(len(files) for _, _, files in os.walk(result_directory))
            stored_info, info_time = call_and_time(lambda: store.info(result_directory))
            result, opening_time = call_and_time(lambda: store.open_stored_result(result_directory))
            loads = np.geomspace(20, 60, 20)
            maps_and_times = [
                call_and_time(lambda compute_map=compute_map: compute_map(result, loads))
                for compute_map in (friction_map, area_map, stiffness_map)
            ]
            assert (maps_and_times[0][0]["status"] == "ok").all()
            longer_study = STUDY.with_changes({"ensemble.repetitions": NUM_REPETITIONS + NUM_ADDED_REPETITIONS})
            num_stored, continuation_time = call_and_time(
                lambda: compute_missing_blocks(longer_study, result_directory)
            )
            assert num_stored == NUM_REPETITIONS + NUM_ADDED_REPETITIONS
            _, recheck_time = call_and_time(lambda: compute_missing_blocks(longer_study, result_directory))
    finally:
        runner.compute_member_arrays, runner.estimate_member_time = original_functions
    peak_memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return [
        (
            f"{NUM_REPETITIONS / 1e6:g} million repetitions, 2 pairs of 8 approaches each",
            f"{result.nbytes / 1e9:.2f} GB",
        ),
        ("compute synthetic sums, and store them", f"{writing_time:.0f} s"),
        ("number of files, and size on disk", f"{num_files}, {stored_info.size / 1e9:.2f} GB"),
        ("read the progress, open the result", f"{info_time:.1f} s, {opening_time:.1f} s"),
        (
            "maps of friction, area, stiffness at 20 loads",
            ", ".join(f"{map_time:.1f}" for _, map_time in maps_and_times) + " s",
        ),
        (
            f"add {NUM_ADDED_REPETITIONS} repetitions; find no missing repetitions",
            f"{continuation_time:.1f} s, {recheck_time:.1f} s",
        ),
        ("peak memory of all steps", f"{peak_memory:.0f} MiB"),
    ]
