"""Measure the size of the interactive report on figure6, and its response time in headless Chromium."""

import statistics
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import xarray
from stiction import Study, friction_map, run
from stiction.views.report import save_report

BENCHMARK_DIRECTORY = Path(__file__).parent
sys.path.insert(0, str(BENCHMARK_DIRECTORY.parent / "tests"))
from support import browser  # noqa: E402

NUM_KEY_PRESSES = 40
NUM_RANDOM_POINTS = 20
MAX_PACKING_ERROR = 1e-6
# JavaScript that records the time from each key press until the frame is redrawn.
TIMING_SCRIPT = """
window.times = [];
for (const slider of document.querySelectorAll("input[type=range]"))
  slider.addEventListener("input", (event) =>
    requestAnimationFrame(() => setTimeout(() => times.push(performance.now() - event.timeStamp))));
"""


def measure_key_press(driver, slider: str) -> float:
    """Return the median time (ms) from a key press on a slider until the page is redrawn."""
    # Start in the middle, and alternate between right and left key, so that the slider does not reach its ends.
    set_middle_script = "const e = arguments[0]; e.value = (Number(e.min) + Number(e.max)) / 2"
    driver.execute_script(set_middle_script + "; times.length = 0", driver.find_element("id", slider))
    for i in range(NUM_KEY_PRESSES):
        driver.find_element("id", slider).send_keys("\ue014" if i % 2 == 0 else "\ue012")
        browser.wait_for_drawing(driver)
    redraw_times = driver.execute_script("return times")
    assert len(redraw_times) == NUM_KEY_PRESSES, len(redraw_times)
    return statistics.median(redraw_times)


def measure_largest_error(driver, dataset: xarray.Dataset) -> float:
    """Return the largest relative error of numbers and interval limits at random points of the report."""
    generator = np.random.default_rng(1)
    relative_errors = [0.0]
    loads, parameters = driver.execute_script("return [loads, parameters]")
    for _ in range(NUM_RANDOM_POINTS):
        dimension_index, load = int(generator.integers(50)), int(generator.integers(len(loads)))
        mu0, tau0 = (float(generator.choice(parameters[name]["values"])) for name in ("mu0", "tau0"))
        script = (
            "const [d, load, mu0, tau0] = arguments;"
            "const at = frictionAt(facts.rules[0], d, load, placeAt(parameters, mu0, tau0), 0);"
            "return [at.status, at.value, at.lower, at.upper]"
        )
        status, *report_values = driver.execute_script(script, dimension_index, load, mu0, tau0)
        reference_map = friction_map(
            dataset.isel(fractal_dimension=[dimension_index]), [loads[load]], mu0=[mu0], tau0=[tau0 / 1000]
        ).squeeze()
        if status == "ok" and str(reference_map["status"].values) == "ok":
            expected_values = np.array(
                [float(reference_map[name]) for name in ("friction_coefficient", "lower", "upper")]
            )
            relative_errors.append(float(np.abs(np.array(report_values) / expected_values - 1).max()))
    return max(relative_errors)


def run_benchmark() -> list[tuple[str, str]]:
    dataset = run(Study.named("figure6"), store=BENCHMARK_DIRECTORY.parent / "build/figure6").dataset
    with tempfile.TemporaryDirectory() as directory, browser.start_browser(f"{directory}/profile") as driver:
        page = Path(directory) / "report.html"
        start = time.perf_counter()
        save_report(dataset, page)
        save_time = time.perf_counter() - start
        start = time.perf_counter()
        browser.open_page(driver, page)
        open_time = time.perf_counter() - start
        largest_error = measure_largest_error(driver, dataset)
        assert largest_error < MAX_PACKING_ERROR, largest_error
        driver.execute_script(TIMING_SCRIPT)
        mu0_time, *other_times = (measure_key_press(driver, name) for name in ("mu0", "tau0", "dimension", "load"))
        report_size = page.stat().st_size
    return [
        ("size of the page for 50 dimensions, 100 repetitions and 40 approaches", f"{report_size / 1e6:.1f} MB"),
        ("time to write the page, time to open it", f"{save_time:.1f} s, {open_time:.1f} s"),
        ("median time from a step of the mu0 slider to the redrawn view", f"{mu0_time:.0f} ms"),
        ("median times for the sliders of tau0, fractal dimension and load",
         ", ".join(f"{other_time:.0f}" for other_time in other_times) + " ms"),
        (f"largest relative error at {NUM_RANDOM_POINTS} random points", f"{largest_error:.1g}"),
    ]  # fmt: skip
