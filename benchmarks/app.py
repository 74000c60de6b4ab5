"""Measure how long `stiction app` takes to start and to show its first result."""

import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BENCHMARK_DIRECTORY = Path(__file__).parent
sys.path.insert(0, str(BENCHMARK_DIRECTORY.parent / "tests"))
from support import browser  # noqa: E402


def set_window_size(driver, width: int, height: int) -> None:
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)


def measure_wait_for_script(driver, script: str) -> float:
    """Return the time (s) until a JavaScript expression is true."""
    start = time.perf_counter()
    browser.wait_for(driver, lambda driver: driver.execute_script(f"return {script}"))
    return time.perf_counter() - start


def run_benchmark() -> list[tuple[str, str]]:
    with tempfile.TemporaryDirectory() as directory, browser.start_browser(f"{directory}/profile") as driver:
        start = time.perf_counter()
        server = subprocess.Popen(
            [sys.executable, "-m", "stiction", "app", "--demo"], cwd=directory, stderr=subprocess.PIPE, text=True,
            env=os.environ | {"BROWSER": "true", "TMPDIR": directory},
        )  # fmt: skip
        try:
            address = re.search(r"http:\S+", server.stderr.readline())[0]
            response_time = time.perf_counter() - start
            set_window_size(driver, 1280, 720)
            page_start = time.perf_counter()
            driver.get(address)
            preview_time = measure_wait_for_script(driver, "['upper', 'lower'].every((side) => scans[side]?.holds)")
            paint_time = driver.execute_script(
                "return performance.getEntriesByName('first-contentful-paint')[0].startTime"
            )
            # The demonstration computes its pair without a click.
            measure_wait_for_script(driver, "document.querySelector('#answer .value') !== null")
            first_result_time = time.perf_counter() - page_start
            measure_wait_for_script(driver, "reportAddress !== '' && document.getElementById('progress').value > 0")
            measure_wait_for_script(driver, "reportDocument().readyState === 'complete'")
            measure_wait_for_script(driver, "document.getElementById('job').dataset.state === 'done'")
            result_time = time.perf_counter() - page_start
            measure_wait_for_script(
                driver, "reportDocument().getElementById('main')?.getAttribute('aria-busy') === 'false'"
            )
            server_memory = int(Path(f"/proc/{server.pid}/statm").read_text().split()[1]) * resource.getpagesize()
        finally:
            server.send_signal(signal.SIGINT)
            server.wait()
    return [
        ("load average of the machine", f"{os.getloadavg()[0]:.1f}"),
        (
            "time until the server responds, time until the page is drawn",
            f"{response_time:.1f} s, {paint_time / 1000:.2f} s",
        ),
        ("time until two maps of 128 x 128 points are shown with their roughness", f"{preview_time:.1f} s"),
        (
            "time from opening the page to the preview of the result, time to the final result",
            f"{first_result_time:.1f} s, {result_time:.1f} s",
        ),
        ("memory of the server at that time", f"{server_memory / 1e6:.0f} MB"),
    ]
