"""Compare the processor times of half-space solvers on one thread at equal error."""

import importlib.util
import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.fft
from stiction import HalfSpaceCurve, Profile, Surface, half_space
from stiction.mechanics.half_space import BoundaryCondition

EFFECTIVE_MODULUS = 10.0
RMS_SLOPE = 0.1
STICTION_SOLVER_TOLERANCE = 1e-6
MEAN_PRESSURES_OVER_MODULUS_TIMES_SLOPE = (0.005, 0.03, 0.1)
"""Mean pressures in units of E* times the rms slope."""


def create_heights(
    shape: tuple[int, ...], min_wave_number: int, max_wave_number: int, hurst: float = 0.8
) -> np.ndarray:
    """Return a self-affine surface of unit length with an rms slope of 0.1 and a given range of wavelengths."""
    generator = np.random.default_rng(1)
    axis_wave_numbers = [np.fft.fftfreq(n, 1 / n) for n in shape[:-1]] + [np.fft.rfftfreq(shape[-1], 1 / shape[-1])]
    k = np.sqrt(sum(np.square(axis) for axis in np.meshgrid(*axis_wave_numbers, indexing="ij")))
    is_in_band = (k >= min_wave_number) & (k <= max_wave_number)
    amplitude = np.where(is_in_band, np.where(is_in_band, k, 1.0) ** (-hurst - len(shape) / 2), 0.0)
    heights = scipy.fft.irfftn(amplitude * np.exp(2j * np.pi * generator.random(k.shape)), shape)
    differences_by_axis = [
        np.diff(heights, axis=axis, append=np.take(heights, [0], axis)) * n for axis, n in enumerate(shape)
    ]
    return heights * RMS_SLOPE / np.sqrt(sum(np.mean(np.square(differences)) for differences in differences_by_axis))


def compute_solution_error(heights: np.ndarray, pressure: np.ndarray) -> float:
    """Return the error Σ p (v - min v)/(F h) of a solution: an energy bound divided by load F and rms height h."""
    n, m = heights.shape
    k = 2 * np.pi * np.hypot(np.fft.fftfreq(n, 1 / n)[:, None], np.fft.rfftfreq(m, 1 / m))
    compliance = np.divide(2 / EFFECTIVE_MODULUS, k, out=np.zeros_like(k), where=k > 0)
    potential = scipy.fft.irfft2(scipy.fft.rfft2(pressure) * compliance, heights.shape) - heights
    return float((pressure * (potential - potential.min())).sum() / pressure.sum() / heights.std())


def solve_by_stiction(heights: np.ndarray, load: float) -> HalfSpaceCurve:
    body = Surface(heights, spacing=(1 / heights.shape[0], 1 / heights.shape[1]))
    flat = Surface(np.zeros(heights.shape), spacing=body.spacing)
    return half_space(
        flat,
        body,
        [load],
        effective_modulus=EFFECTIVE_MODULUS,
        boundary="periodic",
        tolerance=STICTION_SOLVER_TOLERANCE,
    )


def create_tamaas_solver(tolerance: float, *, is_free: bool = False) -> Callable[[np.ndarray, float], np.ndarray]:
    import tamaas

    tamaas.initialize(1)
    tamaas.set_log_level(tamaas.LogLevel.error)

    def solve(heights: np.ndarray, load: float) -> np.ndarray:
        model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [1.0, 1.0], list(heights.shape))
        model.E, model.nu = EFFECTIVE_MODULUS, 0.0
        solver = tamaas.PolonskyKeerRey(model, heights.copy(), tolerance)
        if is_free:
            tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
            solver.setIntegralOperator("dcfft")
        solver.max_iter = 20_000
        solver.solve(load)
        return np.array(model.traction).reshape(heights.shape)

    return solve


def create_aspher_solver(tolerance: float) -> Callable[[np.ndarray, float], np.ndarray]:
    import aspher

    def solve(heights: np.ndarray, load: float) -> np.ndarray:
        result = aspher.solve_nested(
            grid_size=len(heights), gap=-heights.ravel(), p_nominal=load, E_star=EFFECTIVE_MODULUS, backend="periodic",
            tol=tolerance, precision="float_then_double",
        )  # fmt: skip
        return np.array(result.pressure).reshape(heights.shape)

    return solve


def measure_time_and_error(solve: Callable[..., Any], heights: np.ndarray, load: float) -> tuple[float, float]:
    """Return processor time and error of a solution."""
    start = time.process_time()
    solution = solve(heights, load)
    processor_time = time.process_time() - start
    return processor_time, compute_solution_error(
        heights, solution.contact(0).pressure if isinstance(solution, HalfSpaceCurve) else solution
    )


def run_benchmark(grid_sizes: tuple[int, ...] = (512, 1024)) -> list[tuple[str, str]]:
    # The solvers define their errors differently, but reach about the same common error with these tolerances.
    solvers = {"tamaas": create_tamaas_solver(STICTION_SOLVER_TOLERANCE)}
    if importlib.util.find_spec("aspher"):
        solvers["aspher"] = create_aspher_solver(1.5e-7)
    rows = []
    for n in grid_sizes:
        heights = create_heights((n, n), 4, n // 16)
        for pressure in MEAN_PRESSURES_OVER_MODULUS_TIMES_SLOPE:
            load = pressure * EFFECTIVE_MODULUS * RMS_SLOPE
            our_runs = [measure_time_and_error(solve_by_stiction, heights, load)]
            compared_runs = []
            for name, solve in solvers.items():
                compared_time, compared_error = measure_time_and_error(solve, heights, load)
                our_runs.append(measure_time_and_error(solve_by_stiction, heights, load))
                compared_runs.append((name, compared_time, compared_error))
            our_time = statistics.median(run[0] for run in our_runs)
            assert our_runs[0][1] < 1.1 * STICTION_SOLVER_TOLERANCE, our_runs
            result_text = f"{our_time:.2f} s, {our_runs[0][1]:.0e}" + "".join(
                f"; {name} {compared_time:.2f} s, {compared_error:.0e}: {compared_time / our_time:.1f} times"
                for name, compared_time, compared_error in compared_runs
            )
            rows.append((f"{n} x {n}, mean pressure {pressure} E* h': time and error", result_text))
            print(*rows[-1], flush=True)
    rows += [measure_map_position_time(), measure_thread_speedup(), measure_profile_solution_time()]
    return rows


def print_pressure_differences(grid_sizes: tuple[int, ...] = (256, 512, 1024)) -> None:
    """Print the largest difference from the pressures of tamaas, relative to the highest pressure.

    Takes some minutes.
    """
    for n in grid_sizes:
        heights = create_heights((n, n), 4, n // 16)
        body = Surface(heights, spacing=1 / n)
        flat = Surface(np.zeros(heights.shape), spacing=1 / n)
        for is_free in (False, True):
            solve = create_tamaas_solver(1e-10, is_free=is_free)
            for pressure in (0.002, 0.03, 0.5):
                load = pressure * EFFECTIVE_MODULUS * RMS_SLOPE
                boundary: BoundaryCondition = "free" if is_free else "periodic"
                curve = half_space(
                    flat, body, [load], effective_modulus=EFFECTIVE_MODULUS, boundary=boundary, tolerance=1e-7
                )
                stiction_pressure, tamaas_pressure = curve.contact(0).pressure, solve(heights, load)
                print(
                    n,
                    boundary,
                    pressure,
                    f"{np.abs(stiction_pressure - tamaas_pressure).max() / tamaas_pressure.max():.0e}",
                    flush=True,
                )


def measure_map_position_time(grid_size: int = 384) -> tuple[str, str]:
    """Measure the time for one position of two maps: three loads, 12 directions, two sliding rules and stiffness."""
    heights = create_heights((grid_size, grid_size), 4, grid_size // 16)
    body = Surface(heights, spacing=1 / grid_size)
    flat = Surface(np.zeros(heights.shape), spacing=1 / grid_size)
    loads = np.array(MEAN_PRESSURES_OVER_MODULUS_TIMES_SLOPE) * EFFECTIVE_MODULUS * RMS_SLOPE

    def solve_directions(directions: list[float]) -> HalfSpaceCurve:
        return half_space(flat, body, loads, effective_modulus=EFFECTIVE_MODULUS, direction=directions)

    def compute_all_values() -> None:
        curve = solve_directions([30.0 * i for i in range(12)])
        assert (curve.with_sliding("all").stiffness > 0).all()

    times = []
    for _ in range(5):
        for task in (lambda: solve_directions([0.0]), compute_all_values):
            start = time.process_time()
            task()
            times.append(time.process_time() - start)
    solution_time, total_time = statistics.median(times[::2]), statistics.median(times[1::2])
    return f"{grid_size} x {grid_size}, free, three loads: 12 directions, both rules and stiffness", (
        f"{total_time:.2f} s, {total_time / solution_time:.2f} times the time of the solutions"
    )


def measure_thread_speedup(grid_size: int = 1024) -> tuple[str, str]:
    """Return the speedup by a second thread, for the solver and for Fourier transforms alone."""
    heights = create_heights((grid_size, grid_size), 4, grid_size // 16)
    body = Surface(heights, spacing=1 / grid_size)
    flat = Surface(np.zeros(heights.shape), spacing=1 / grid_size)
    times: dict[int, list[float]] = {1: [], 2: []}
    for _ in range(3):
        for workers, worker_times in times.items():
            with scipy.fft.set_workers(workers):
                start = time.perf_counter()
                half_space(flat, body, [0.03 * EFFECTIVE_MODULUS * RMS_SLOPE], effective_modulus=EFFECTIVE_MODULUS)
                worker_times.append(time.perf_counter() - start)
    return (
        f"{grid_size} x {grid_size}, free: second thread for the transforms",
        f"{min(times[1]) / min(times[2]):.2f} times as fast",
    )


def measure_profile_solution_time(points: int = 131_072) -> tuple[str, str]:
    heights = create_heights((points,), 10, points // 32)
    body, flat = Profile(heights, spacing=1 / points), Profile(np.zeros(points), spacing=1 / points)
    times = []
    for _ in range(5):
        start = time.process_time()
        for _ in range(20):
            scipy.fft.rfft(heights)
        transform_time = (time.process_time() - start) / 20
        start = time.process_time()
        half_space(
            flat, body, [0.02 * EFFECTIVE_MODULUS * RMS_SLOPE], effective_modulus=EFFECTIVE_MODULUS, boundary="periodic"
        )
        times.append((time.process_time() - start) / transform_time)
    return f"a profile of {points} points, H 0.8, 0.02 E* h', in units of one real FFT of this length", (
        f"{statistics.median(times):.0f}"
    )


if __name__ == "__main__":
    for question, answer in run_benchmark():
        print(f"{question:75s} {answer}", flush=True)
