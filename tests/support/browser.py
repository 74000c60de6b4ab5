"""A browser that is driven like a person's: Debian's Chromium, which asks for nothing of its own."""

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
    """A driver with a user-data directory of its own, whose logs have every request and every message."""
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
    """Open a report, and wait until it is drawn."""
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    driver.get("about:blank")
    driver.get_log("performance")
    driver.get(path.as_uri())
    wait_until_drawn(driver)


def open_more(driver):
    """Open what is behind "More" of the page of a result."""
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
    """Wait until the page has done what it does when nothing changes any more."""
    driver.execute_async_script("setTimeout(arguments[0], 2 * REST)")
    settle(driver)


def axe():
    """The script of axe-core, from a package of the tests."""
    import pytest

    spec = importlib.util.find_spec("axe_playwright_python")
    if spec is None:
        pytest.skip("axe-playwright-python is not installed")
    return (Path(spec.origin).parent / "axe.min.js").read_text("utf-8")


AXE = "axe.run({rules: {'label-content-name-mismatch': {enabled: true}}}).then(arguments[0])"


def faults(driver, script):
    """All that axe-core finds in a page and in those inside it, with the elements."""
    driver.execute_script(script)
    result = driver.execute_async_script(AXE)
    return [(fault["id"], [node["html"][:120] for node in fault["nodes"]]) for fault in result["violations"]]


def settle(driver):
    """Let everything be drawn that is to be drawn."""
    driver.execute_async_script(
        "const done = arguments[0];"
        "const left = () => (typeof wanted === 'undefined' ? 0 : wanted.size);"
        "const look = () => requestAnimationFrame(() => (left() ? look() : done())); look();"
    )


def frame(driver, plot):
    """Where a plot is drawn inside of its axes, in the window: left, top, width, height."""
    return driver.execute_script(
        "const place = document.getElementById(arguments[0]); place.scrollIntoView({block: 'center'});"
        "const {left, top} = place.getBoundingClientRect(); const {x, y, width, height} = place.axes.frame;"
        "return [left + x, top + y, width, height]", plot
    )  # fmt: skip


def press(driver, name, keys):
    """Press keys on an element, and let what they do be drawn."""
    driver.find_element("id", name).send_keys(keys)
    settle(driver)


def foreign_requests(driver, path):
    """Addresses of all requests since the page of a file was opened, but for its own."""
    messages = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    sent = [
        message["params"]["request"]["url"] for message in messages if message["method"] == "Network.requestWillBeSent"
    ]
    return {url for url in sent if not url.startswith(("data:", "blob:")) and url.split("#")[0] != path.as_uri()}
