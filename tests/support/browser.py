"""Drive Debian's Chromium in tests, without requests of its own."""

import importlib.util
import json
import shutil
from contextlib import contextmanager
from pathlib import Path

import pytest

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars",
)  # fmt: skip
IN_BROWSER = [
    pytest.mark.browser,
    pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="Debian's chromium and chromium-driver are not installed"),
]
READY = "return document.readyState === 'complete' && document.getElementById('main').ariaBusy !== 'true'"


@contextmanager
def browser(profile):
    """Return a driver with its own user-data directory, which logs every request and every message."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in (*FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"performance": "ALL", "browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    driver.set_script_timeout(120)
    try:
        yield driver
    finally:
        driver.quit()


def open_page(driver, path, width=1280, height=900):
    """Open a report and wait until it is drawn."""
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    driver.get("about:blank")
    driver.get_log("performance")
    driver.get(path.as_uri())
    wait_until_drawn(driver)


def open_more(driver):
    """Open the section "More" of a report."""
    driver.execute_async_script(
        "const more = document.getElementById('more'); if (!more || more.open) arguments[0]();"
        "else { more.addEventListener('toggle', () => arguments[0]()); more.open = true; }"
    )
    settle(driver)


def wait_until_drawn(driver):
    wait(driver, lambda driver: driver.execute_script(READY))
    settle(driver)


def wait(driver, until):
    from selenium.webdriver.support.ui import WebDriverWait

    WebDriverWait(driver, 60, 0.05).until(until)


def rest(driver):
    """Wait until the page is idle and has updated its address and details."""
    driver.execute_async_script("setTimeout(arguments[0], 2 * REDRAW_DELAY)")
    settle(driver)


def axe():
    """Return the script of axe-core."""
    import pytest

    spec = importlib.util.find_spec("axe_playwright_python")
    if spec is None:
        pytest.skip("axe-playwright-python is not installed")
    return (Path(spec.origin).parent / "axe.min.js").read_text("utf-8")


AXE = "axe.run({rules: {'label-content-name-mismatch': {enabled: true}}}).then(arguments[0])"


def faults(driver, script):
    """Return the accessibility violations in a page and its frames, with the elements."""
    driver.execute_script(script)
    result = driver.execute_async_script(AXE)
    return [(fault["id"], [node["html"][:120] for node in fault["nodes"]]) for fault in result["violations"]]


def settle(driver):
    """Wait until pending drawing is complete."""
    driver.execute_async_script(
        "const done = arguments[0];"
        "const left = () => (typeof pending === 'undefined' ? 0 : pending.size);"
        "const look = () => requestAnimationFrame(() => (left() ? look() : done())); look();"
    )


def frame(driver, plot):
    """Return left, top, width and height of the axes of a plot in the window."""
    return driver.execute_script(
        "const place = document.getElementById(arguments[0]); place.scrollIntoView({block: 'center'});"
        "const {left, top} = place.getBoundingClientRect(); const {x, y, width, height} = place.axes.frame;"
        "return [left + x, top + y, width, height]", plot
    )  # fmt: skip


def press(driver, name, keys):
    """Press keys on an element and wait until the page is redrawn."""
    driver.find_element("id", name).send_keys(keys)
    settle(driver)


def foreign_requests(driver, path):
    """Return the addresses of all requests since a file was opened, except for the file."""
    messages = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    sent = [
        message["params"]["request"]["url"] for message in messages if message["method"] == "Network.requestWillBeSent"
    ]
    return {url for url in sent if not url.startswith(("data:", "blob:")) and url.split("#")[0] != path.as_uri()}
