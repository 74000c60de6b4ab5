"""Draw the screenshots of the report and of the app in docs/images, in headless Chromium, for the example in README.

The script takes about a minute on one core.
"""

import base64
import os
import re
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import stiction as st
from first import EXAMPLE_PAIR_OPTIONS, ROOT, SCANS_DIRECTORY
from stiction.views.report import save_report

IMAGE_DIRECTORY = ROOT / "docs/images"
WINDOW_WIDTH = 1280  # px
IMAGE_HEIGHTS = {"report": 1180, "app_scans": 900, "app_answer": 1000}  # px

sys.path.insert(0, str(ROOT / "tests"))
from support import browser  # noqa: E402


def set_theme(driver, dark: bool) -> None:
    media_features = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": media_features})


def save_screenshot(driver, name: str, height: int) -> None:
    """Save a screenshot of the upper part of a page."""
    clip_area = {"x": 0, "y": 0, "width": WINDOW_WIDTH, "height": height, "scale": 1}
    completed = driver.execute_cdp_cmd("Page.captureScreenshot", {"captureBeyondViewport": True, "clip": clip_area})
    (IMAGE_DIRECTORY / f"{name}.png").write_bytes(base64.b64decode(completed["data"]))


def save_report_screenshots(driver, directory: Path) -> None:
    """Save screenshots of the report of the pair in README, in light mode and in dark mode."""
    result = st.pair(
        SCANS_DIRECTORY / "lapped_upper.csv",
        SCANS_DIRECTORY / "lapped_lower.csv",
        directory=directory / "pair",
        load="50 MPa",
        **EXAMPLE_PAIR_OPTIONS,
    )
    save_report(result, directory / "report.html")
    for suffix, dark in (("", False), ("_dark", True)):
        set_theme(driver, dark)
        browser.open_page(driver, directory / "report.html", width=WINDOW_WIDTH)
        save_screenshot(driver, f"report{suffix}", IMAGE_HEIGHTS["report"])


def save_app_screenshots(driver, directory: Path) -> None:
    """Save screenshots of the app with its two sample surfaces: the form, and the result with the half-space model."""
    wait_until = lambda script: browser.wait_for(driver, lambda driver: driver.execute_script(f"return {script}"))  # noqa: E731
    server = subprocess.Popen(
        [sys.executable, "-m", "stiction", "app", "--demo"], cwd=directory, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"BROWSER": "true", "TMPDIR": f"{directory}"},
    )  # fmt: skip
    try:
        address = re.search(r"http:\S+", server.stderr.readline())[0]
        set_theme(driver, dark=False)
        metrics = {"width": WINDOW_WIDTH, "height": IMAGE_HEIGHTS["app_scans"], "deviceScaleFactor": 1, "mobile": False}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        driver.get(address)
        wait_until("['upper', 'lower'].every((side) => scans[side]?.holds)")
        save_screenshot(driver, "app_scans", IMAGE_HEIGHTS["app_scans"])
        driver.execute_script("document.querySelector('#pair .go').click()")
        wait_until("document.querySelector('#answer .value') !== null")
        wait_until("document.getElementById('job').dataset.state === 'done'")
        wait_until("reportDocument().getElementById('main')?.getAttribute('aria-busy') === 'false'")
        metrics["height"] = IMAGE_HEIGHTS["app_answer"]
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        driver.execute_script("document.activeElement.blur(); document.getElementById('inputs').scrollTo(0, 0)")
        browser.wait_for_drawing(driver)
        save_screenshot(driver, "app_answer", IMAGE_HEIGHTS["app_answer"])
    finally:
        server.send_signal(signal.SIGINT)
        server.wait()


def main() -> None:
    with tempfile.TemporaryDirectory() as directory, browser.start_browser(f"{directory}/profile") as driver:
        save_report_screenshots(driver, Path(directory))
        save_app_screenshots(driver, Path(directory))


if __name__ == "__main__":
    main()
