"""Measure the time of a pair of figure6 and of its parts in units of U, and the speed-up by a second thread."""

from concurrent.futures import Executor, ThreadPoolExecutor

import numpy as np
from measure import measure_in_time_units, measure_time_unit, median_time
from stiction import Study, random_phases, run, weierstrass_mandelbrot_family
from stiction.solve.member_solution import _get_reused_array, compute_member_arrays
from stiction.study.members import fill_profile_family

# Use many repetitions, so that the last one, which a single thread computes, takes little of the time.
NUM_REPETITIONS = 60
STUDY = Study.named("figure6").with_changes({"ensemble.repetitions": NUM_REPETITIONS})
NUM_PAIRS = NUM_REPETITIONS * 50
NUM_TIMING_ROUNDS = 10
NUM_ROUNDS_WITH_NEW_THREADS = 3
FFT_INPUT = np.random.default_rng(0).random(150_000)


def measure_time_with_new_threads(study: Study, workers: int) -> float:
    """Return the run time (s) of a study with new threads, which must first allocate memory."""
    with ThreadPoolExecutor(workers) as pool:
        return median_time(lambda: run(study, executor=pool), 1)


def measure_speedup(study: Study, one_thread_pool: Executor, two_thread_pool: Executor) -> float:
    """Return the speed of a study with two threads, relative to the speed with one thread."""
    return median_time(lambda: run(study, executor=one_thread_pool), 1) / median_time(
        lambda: run(study, executor=two_thread_pool), 1
    )


def run_benchmark() -> list[tuple[str, str]]:
    # Measured before a large memory block has been freed.
    unfreed_fft_time = median_time(lambda: np.fft.rfft(FFT_INPUT), 40)
    rows = [
        ("U", f"{1e3 * measure_time_unit():.2f} ms"),
        ("the same FFT in a process that has not yet freed a large memory block", f"{1e3 * unfreed_fft_time:.2f} ms"),
    ]
    for detection in ("cell", "gap-minimum"):
        study = STUDY.with_changes({"contact.detection": detection})
        with ThreadPoolExecutor(1) as one_thread_pool, ThreadPoolExecutor(2) as two_thread_pool:
            # The first run is not measured, because it allocates memory.
            measure_speedup(study, one_thread_pool, two_thread_pool)
            pair_time = (
                measure_in_time_units(
                    lambda study=study, one_thread_pool=one_thread_pool: run(study, executor=one_thread_pool), 3
                )
                / NUM_PAIRS
            )
            median_speedup = float(
                np.median([measure_speedup(study, one_thread_pool, two_thread_pool) for _ in range(NUM_TIMING_ROUNDS)])
            )
        serial_fraction = 2 / median_speedup - 1  # serial fraction of the run time according to Amdahl's law
        four_thread_speedup = 1 / (serial_fraction + (1 - serial_fraction) / 4)
        rows += [
            (f"a pair of figure6, {detection}, one thread", f"{pair_time:.2f} U"),
            (f"speed-up by a second thread, {detection}, median of {NUM_TIMING_ROUNDS}", f"{median_speedup:.2f}"),
            (f"speed-up by four threads, {detection}, estimated by Amdahl's law", f"{four_thread_speedup:.1f}"),
        ]
    new_thread_speedup = np.median(
        [
            measure_time_with_new_threads(STUDY, 1) / measure_time_with_new_threads(STUDY, 2)
            for _ in range(NUM_ROUNDS_WITH_NEW_THREADS)
        ]
    )
    rows.append(
        (
            f"speed-up by a second thread, cell, new threads and memory, median of {NUM_ROUNDS_WITH_NEW_THREADS}",
            f"{new_thread_speedup:.2f}",
        )
    )

    dimensions = STUDY.surfaces.fractal_dimensions()
    phases = random_phases(2016)
    one_profile_time = measure_in_time_units(lambda: weierstrass_mandelbrot_family(phases, dimensions[:1]))
    profile_buffer = _get_reused_array((dimensions.size, 150_000))
    generation_time = (
        2
        * measure_in_time_units(lambda: fill_profile_family(STUDY, profile_buffer, dimensions, 0, "upper"))
        / dimensions.size
    )
    rows += [
        ("generation: both bodies, 50 dimensions together", f"{generation_time:.2f} U a pair"),
        ("generation: one profile of one dimension", f"{one_profile_time:.1f} U"),
    ]
    for detection in ("cell", "gap-minimum"):
        for task, approach in (
            ("scaling and first contact only", ["0 nm"]),
            ("40 nm only", ["40 nm"]),
            ("40 approaches", None),
        ):
            study_changes = {"contact.detection": detection} | ({"contact.approach": approach} if approach else {})
            study = STUDY.with_changes(study_changes)
            pair_time = measure_in_time_units(lambda study=study: compute_member_arrays(study, 0)) / dimensions.size
            rows.append((f"scaling and contact, {detection}: {task}", f"{pair_time - generation_time:.2f} U a pair"))
    return rows
