"""Measurement of the time and memory of a run.

The unit of time, U, is one real FFT of 150 000 numbers, which is measured between the other calls.

The C library requests the memory of an FFT from the system at each call, until a large block has been freed once. Then
the library keeps the memory, and U is smaller by a factor of up to two. U is measured in this state, so costs in units
of U are upper bounds.
"""

import multiprocessing
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

_FFT_INPUT = np.random.default_rng(0).random(150_000)


def retain_freed_memory() -> None:
    """Free a large block of memory, so that the C library keeps freed blocks of up to this size."""
    large_block = np.ones(3 << 20)  # 24 MiB
    del large_block


def median_time(call: Callable[[], object], num_repeats: int = 5) -> float:
    """Return the median time (s) of a call."""
    times = []
    for _ in range(num_repeats):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def measure_time_unit(num_repeats: int = 40) -> float:
    """Return the duration (s) of the time unit U, which is one FFT of a fixed input."""
    retain_freed_memory()
    return median_time(lambda: np.fft.rfft(_FFT_INPUT), num_repeats)


def measure_in_time_units(call: Callable[[], object], num_repeats: int = 5) -> float:
    """Return the median time of a call in units of U. U is timed around each call, because the clock rate drifts."""
    ratios = []
    for _ in range(num_repeats):
        unit_before = measure_time_unit(10)
        call_time = median_time(call, 1)
        ratios.append(call_time / ((unit_before + measure_time_unit(10)) / 2))
    return statistics.median(ratios)


def measure_peak_mebibytes(call: Callable[[], object]) -> float:
    """Return the peak memory (MiB) of a new process that makes a call."""
    context = multiprocessing.get_context("spawn")
    queue = context.Queue()
    process = context.Process(target=_send_peak_mebibytes, args=(call, queue))
    process.start()
    peak_memory = queue.get()
    process.join()
    return float(peak_memory)


def _send_peak_mebibytes(call: Callable[[], object], queue: "multiprocessing.Queue[float]") -> None:
    call()
    # getrusage is unsuitable, because a new process inherits the peak memory of its parent.
    lines = Path("/proc/self/status").read_text("ascii").splitlines()
    queue.put(next(float(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM")))
