"""Measure the time of areal contact in units of one FFT of the map, and compare it with a boundary-element solver.

Times are processor times of one thread, which other jobs do not affect. Times of two threads are wall times.
"""

import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from measure import measure_peak_mebibytes
from scipy.fft import rfft2
from stiction import candidates, press, self_affine_surface

MAP_LENGTH = 16.0  # µm
MAX_APPROACH = 0.15  # approach in µm, twice the rms height of the gap
APPROACHES = np.linspace(0, MAX_APPROACH, 41)[1:]
DIRECTIONS = np.arange(0, 360, 10)
SLIDING_RULES = ("opposing", "all")
NUM_REPEATS = 9


def create_pair(
    points: int, *, shortest_wavelength: float | None = 0.5, repetition: int = 0, longest_wavelength: float = 4.0
):
    return [
        self_affine_surface(
            3, hurst_exponent=0.8, rms=0.05, shape=(points, points), spacing=MAP_LENGTH / points,
            shortest_wavelength=shortest_wavelength,
            longest_wavelength=longest_wavelength, side=side, repetition=repetition,
        )
        for side in ("upper", "lower")
    ]  # fmt: skip


def press_with_both_rules(upper, lower):
    contact_candidates = candidates(upper, lower, deepest=MAX_APPROACH)
    return [press(contact_candidates, APPROACHES, direction=DIRECTIONS, sliding=rule) for rule in SLIDING_RULES]


def measure_thread_time(call: Callable[[], object]) -> float:
    start = time.thread_time()
    call()
    return time.thread_time() - start


def median_times(*calls: Callable[[], object], num_repeats: int = NUM_REPEATS) -> list[float]:
    """Return the median time (s) of each of several calls, which alternate so that other jobs affect all equally."""
    times = [[measure_thread_time(call) for call in calls] for _ in range(num_repeats)]
    return [statistics.median(column) for column in zip(*times, strict=True)]


def press_large_pair() -> None:
    press_with_both_rules(*create_pair(2048))


def create_large_pair() -> None:
    create_pair(2048)


def run_benchmark() -> list[tuple[str, str]]:
    small_pair, rough_pair, large_pair = create_pair(512), create_pair(512, shortest_wavelength=None), create_pair(2048)
    transform_time, pair_time, candidate_time, fine_pair_time, large_transform_time, large_pair_time = median_times(
        lambda: rfft2(small_pair[0].heights, workers=1),
        lambda: press_with_both_rules(*small_pair),
        lambda: candidates(*small_pair, deepest=MAX_APPROACH),
        lambda: press_with_both_rules(*rough_pair),
        lambda: rfft2(large_pair[0].heights, workers=1),
        lambda: press_with_both_rules(*large_pair),
    )
    curve, rough_pair_curve = press_with_both_rules(*small_pair)[0], press_with_both_rules(*rough_pair)[0]
    count_text = f"{curve.contact_count[-1]} contacts"
    rows = [
        ("T: scipy.fft.rfft2 of one map of 512 x 512", f"{1e3 * transform_time:.2f} ms"),
        (
            f"pair of 512 x 512, 40 approaches, 36 directions, both rules, {count_text}",
            f"{pair_time / transform_time:.1f} T",
        ),
        ("search for the candidates alone", f"{candidate_time / transform_time:.1f} T"),
        (
            f"the same pair with roughness down to the grid spacing, {rough_pair_curve.contact_count[-1]} contacts",
            f"{fine_pair_time / transform_time:.1f} T",
        ),
        ("pair of 2048 x 2048, time per point relative to 512 x 512", f"{large_pair_time / pair_time / 16:.2f}"),
        ("pair of 2048 x 2048, in units of one FFT of this map", f"{large_pair_time / large_transform_time:.1f}"),
        ("peak memory, 2048 x 2048", f"{measure_peak_mebibytes(press_large_pair):.0f} MiB"),
        ("peak memory without the contact calculation", f"{measure_peak_mebibytes(create_large_pair):.0f} MiB"),
    ]
    pairs = [create_pair(512, repetition=repetition) for repetition in range(8)]
    speedups = []
    for _ in range(3):
        wall_times = []
        for workers in (1, 2):
            start = time.perf_counter()
            with ThreadPoolExecutor(workers) as pool:
                list(pool.map(lambda pair: [press_with_both_rules(*pair) for _ in range(8)], pairs))
            wall_times.append(time.perf_counter() - start)
        speedups.append(wall_times[0] / wall_times[1])
    return [
        *rows,
        ("speed-up by a second thread, pairs of 512 x 512", f"{max(speedups):.2f}"),
        *compare_with_boundary_elements(),
    ]


def compare_with_boundary_elements() -> list[tuple[str, str]]:
    """Compare with tamaas on a periodic map, at a load with 1 % of the area in contact and a mean error of 1e-6."""
    import tamaas

    points = 1024
    upper, lower = create_pair(points)
    gap = upper.heights - lower.heights
    stiction_time = median_times(lambda: press_with_both_rules(upper, lower), num_repeats=5)[0]
    curve = press_with_both_rules(upper, lower)[0]
    approach_index = int(np.searchsorted(curve.contact_area, 0.01 * MAP_LENGTH**2))
    tamaas.initialize(1)
    tamaas.set_log_level(tamaas.LogLevel.error)
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [MAP_LENGTH, MAP_LENGTH], [points, points])
    model.E, model.nu = 10.0, 0.0
    pressure = curve.normal_elastic[approach_index] / MAP_LENGTH**2
    solver = tamaas.PolonskyKeerRey(model, np.ascontiguousarray(-gap), 1e-6)
    solver.max_iter = 5000
    start = time.thread_time()
    relative_error = solver.solve(pressure)
    tamaas_time = time.thread_time() - start
    assert relative_error < 1e-6, relative_error
    is_contact = model.traction > 0
    perimeter = sum(int((is_contact != np.roll(is_contact, 1, axis)).sum()) for axis in (0, 1))
    contact_fraction = tamaas.Statistics2D.contact(model.traction, perimeter)
    return [
        ("tamaas, one load at 1024 x 1024, time relative to 40 approaches", f"{tamaas_time / stiction_time:.0f}"),
        ("the same ratio for each load", f"{40 * tamaas_time / stiction_time:.0f}"),
        (
            f"our area over tamaas' at that load, {100 * contact_fraction:.2g} % of the nominal one",
            f"{curve.contact_area[approach_index] / MAP_LENGTH**2 / contact_fraction:.2f}",
        ),
    ]
