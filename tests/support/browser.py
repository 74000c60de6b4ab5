"""Control of Debian's Chromium in tests, with background requests disabled."""

import importlib.util
import json
import shutil
from contextlib import contextmanager
from pathlib import Path

import pytest

CHROMIUM_PATH, CHROMEDRIVER_PATH = shutil.which("chromium"), shutil.which("chromedriver")
CHROMIUM_FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars",
)  # fmt: skip
BROWSER_MARKS = [
    pytest.mark.browser,
    pytest.mark.skipif(
        not (CHROMIUM_PATH and CHROMEDRIVER_PATH), reason="Debian's chromium and chromium-driver are not installed"
    ),
]
IS_READY_SCRIPT = "return document.readyState === 'complete' && document.getElementById('main').ariaBusy !== 'true'"


@contextmanager
def start_browser(profile):
    """Return a Selenium driver that keeps user data in the directory `profile`, and logs requests and messages."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM_PATH
    for flag in (*CHROMIUM_FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"performance": "ALL", "browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(CHROMEDRIVER_PATH))
    driver.set_script_timeout(120)
    try:
        yield driver
    finally:
        driver.quit()


def open_page(driver, path, width=1280, height=900):
    """Open a report in the browser, and wait until the report is drawn."""
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    driver.get("about:blank")
    driver.get_log("performance")
    driver.get(path.as_uri())
    wait_until_page_is_drawn(driver)


def open_more_section(driver):
    """Open the section "More" of a report."""
    driver.execute_async_script(
        "const more = document.getElementById('more'); if (!more || more.open) arguments[0]();"
        "else { more.addEventListener('toggle', () => arguments[0]()); more.open = true; }"
    )
    wait_for_drawing(driver)


def wait_until_page_is_drawn(driver):
    wait_for(driver, lambda driver: driver.execute_script(IS_READY_SCRIPT))
    wait_for_drawing(driver)


def wait_for(driver, condition):
    from selenium.webdriver.support.ui import WebDriverWait

    WebDriverWait(driver, 60, 0.05).until(condition)


def wait_until_idle(driver):
    """Wait until the page is idle and has updated its address and its list of details."""
    wait_for(driver, lambda driver: driver.execute_script("return !frame && !redrawTimer"))


def load_axe_script():
    """Return the script of axe-core."""
    import pytest

    spec = importlib.util.find_spec("axe_playwright_python")
    if spec is None:
        pytest.skip("axe-playwright-python is not installed")
    return (Path(spec.origin).parent / "axe.min.js").read_text("utf-8")


RUN_AXE_SCRIPT = "axe.run({rules: {'label-content-name-mismatch': {enabled: true}}}).then(arguments[0])"


def find_accessibility_violations(driver, script):
    """Return the accessibility violations of a page and its frames, as pairs of rule and element."""
    driver.execute_script(script)
    report = driver.execute_async_script(RUN_AXE_SCRIPT)
    return [
        (violation["id"], [node["html"][:120] for node in violation["nodes"]]) for violation in report["violations"]
    ]


def wait_for_drawing(driver):
    """Wait until pending drawing is complete."""
    driver.execute_async_script(
        "const done = arguments[0];"
        "const left = () => (typeof pending === 'undefined' ? 0 : pending.size);"
        "const look = () => requestAnimationFrame(() => (left() ? look() : done())); look();"
    )


def find_axes_frame(driver, plot):
    """Return the frame of a plot's axes in the window, in pixels: left, top, width, and height."""
    return driver.execute_script(
        "const place = document.getElementById(arguments[0]); place.scrollIntoView({block: 'center'});"
        "const {left, top} = place.getBoundingClientRect(); const {x, y, width, height} = place.axes.frame;"
        "return [left + x, top + y, width, height]", plot
    )  # fmt: skip


def press_keys(driver, name, keys):
    """Press keys on an element and wait until the page is redrawn."""
    driver.find_element("id", name).send_keys(keys)
    wait_for_drawing(driver)


def find_foreign_requests(driver, path):
    """Return the addresses of all requests since a page was opened, without the address of the page itself."""
    messages = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    requested_addresses = [
        message["params"]["request"]["url"] for message in messages if message["method"] == "Network.requestWillBeSent"
    ]
    return {
        url
        for url in requested_addresses
        if not url.startswith(("data:", "blob:")) and url.split("#")[0] != path.as_uri()
    }
