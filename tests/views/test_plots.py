"""Plots of every kind of page as people look closer at them, and the page of one scan, in a browser."""

import re

import browser
import numpy as np
import pytest
from stiction import Profile, Surface, levelled, self_affine, self_affine_surface
from stiction.studies.contact_picture import contact_picture
from stiction.views.characterisation import Characterisation
from stiction.views.report import report_page
from stiction.views.report.surface import surface_page

pytest.importorskip("selenium", reason="selenium is not installed")
pytestmark = browser.IN_BROWSER

CONTROL, SHIFT = 2, 8  # bits of the browser's protocol
TABLE = {"name": "scan.csv", "command": "stiction characterise scan.csv"}


@pytest.fixture(scope="module")
def profile():
    made = self_affine(1, hurst_exponent=0.7, rms=0.05, points=6001, spacing=0.01)
    return levelled(made, "line")


@pytest.fixture(scope="module")
def surface():
    made = self_affine_surface(1, hurst_exponent=0.7, rms=0.05, shape=(60, 90), spacing=0.1)
    return levelled(made, "plane")


@pytest.fixture(scope="module")
def pages(result, maps, lines, profile, surface, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    texts = {
        "study": report_page(result), "maps": report_page(maps, picture=contact_picture(maps)),
        "lines": report_page(lines, picture=contact_picture(lines)), "profile": surface_page(profile, **TABLE).html(),
        "surface": surface_page(surface, **TABLE).html(),
    }  # fmt: skip
    for name, text in texts.items():
        (folder / f"{name}.html").write_text(text, encoding="utf-8")
    return {name: folder / f"{name}.html" for name in texts}


KINDS = {
    "study": {"map", "over", "friction", "area", "stiffness"},
    "maps": {"friction", "area", "stiffness"},
    "lines": {"friction", "area", "stiffness"},
}
"""Plots with axes of each page of a result; the compass begins at 0 and goes round, and is seen whole."""


def view(driver, plot):
    """Ends of both axes as they are looked at, logarithms where an axis is logarithmic."""
    return np.reshape(
        driver.execute_script(
            "const {x, y} = document.getElementById(arguments[0]).axes;"
            "return [x, y].flatMap(({low, high, isLog}) => [low, high].map((v) => (isLog ? Math.log(v) : v)))", plot
        ), (2, 2)
    )  # fmt: skip


def mouse(driver, kind, x, y, *, modifiers=0, **more):
    event = {"type": kind, "x": x, "y": y, "modifiers": modifiers, "pointerType": "mouse", **more}
    driver.execute_cdp_cmd("Input.dispatchMouseEvent", event)


def touch(driver, kind, *points):
    places = [{"x": x, "y": y, "id": index} for index, (x, y) in enumerate(points)]
    driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": places})


def wheel(driver, plot):
    """Turn the wheel with Ctrl over a point that is a quarter in from the left and the bottom."""
    left, top, width, height = browser.frame(driver, plot)
    mouse(driver, "mouseWheel", left + width / 4, top + 3 * height / 4, modifiers=CONTROL, deltaX=0, deltaY=-200)
    browser.wait(driver, lambda driver: driver.execute_script(f"return document.getElementById('{plot}').view != null"))
    browser.settle(driver)


@pytest.mark.parametrize(("kind", "plot"), [(kind, plot) for kind, plots in KINDS.items() for plot in sorted(plots)])
def test_every_plot_is_looked_at_closer_and_moved(driver, pages, kind, plot):
    from selenium.webdriver.common.keys import Keys

    browser.open_page(driver, pages[kind])
    browser.open_more(driver)
    whole = view(driver, plot)
    span = whole[:, 1] - whole[:, 0]
    wheel(driver, plot)
    near = view(driver, plot)
    # What was under the pointer stays there, and both axes are as much closer.
    ratio = (near[:, 1] - near[:, 0]) / span
    assert ratio == pytest.approx(np.exp(-200 / 300), rel=1e-6)
    assert near[:, 0] + (near[:, 1] - near[:, 0]) / 4 == pytest.approx(whole[:, 0] + span / 4, abs=0.01 * span.max())
    left, top, width, height = browser.frame(driver, plot)
    start = (left + width / 2, top + height / 2)
    mouse(driver, "mousePressed", *start, modifiers=SHIFT, button="left", clickCount=1)
    for part in (0.05, 0.1):
        end = start[0] + part * width, start[1] - part * height
        mouse(driver, "mouseMoved", *end, modifiers=SHIFT, button="left", buttons=1)
    mouse(driver, "mouseReleased", *end, modifiers=SHIFT, button="left", clickCount=1)
    browser.settle(driver)
    moved = view(driver, plot)
    assert (moved - near)[0] == pytest.approx(-0.1 * ratio[0] * span[0], rel=0.05)
    assert (moved - near)[1] == pytest.approx(-0.1 * ratio[1] * span[1], rel=0.05)
    browser.press(driver, plot, Keys.SHIFT + Keys.ARROW_RIGHT + Keys.NULL)
    assert (view(driver, plot) - moved)[0] == pytest.approx(0.2 * ratio[0] * span[0], rel=0.05)
    browser.press(driver, plot, "0")
    assert view(driver, plot) == pytest.approx(whole)
    browser.press(driver, plot, "+")
    assert np.diff(view(driver, plot)).ravel() == pytest.approx(span / 1.5)
    browser.press(driver, plot, "-")
    assert view(driver, plot) == pytest.approx(whole)
    # Two fingers that move apart.
    driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True, "maxTouchPoints": 2})
    left, top, width, height = browser.frame(driver, plot)
    for kind_of_event, times in (("touchStart", 1), ("touchMove", 1.5), ("touchMove", 2)):
        x = [left + width * (0.5 + 0.1 * side * times) for side in (-1, 1)]
        touch(driver, kind_of_event, *((each, top + height / 2) for each in x))
    touch(driver, "touchEnd")
    browser.settle(driver)
    driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": False})
    near = view(driver, plot)
    assert np.diff(near).ravel() == pytest.approx(span / 2, rel=0.05)
    assert near.mean(axis=1) == pytest.approx(whole.mean(axis=1), abs=0.02 * span.max())
    assert not [entry for entry in driver.get_log("browser") if entry["level"] != "INFO"]


# ---- The page of one scan --------------------------------------------------------------------------------------------


def test_a_page_has_the_table_and_what_slopes_say(driver, pages, profile):
    browser.open_page(driver, pages["profile"])
    said = driver.execute_script(
        "return [...document.querySelectorAll('tr')].map((row) => [...row.cells].map((cell) => cell.innerText))"
    )
    found = Characterisation(profile)
    rows = [(row.label, row.texts[0]) for row in found.rows if row.label]
    assert [name for name, *_ in said] == [name for name, _ in rows]
    assert dict(said)["Pq"] == dict(rows)["Pq"]
    text = driver.find_element("id", "main").text
    assert f"μₛ = {found.friction[0]:.2f}, by their slopes alone" in text
    assert TABLE["command"] in text


def test_a_page_of_a_scan_doubts_what_pair_would_doubt(profile):
    x = np.linspace(-1, 1, len(profile))
    bowed = surface_page(Profile(profile.heights + x**2, spacing=profile.spacing), **TABLE).html()
    assert re.search(r"<li>A parabola is \d+ % of its mean square height, and carries the load; try --level", bowed)
    assert "<li>" not in surface_page(profile, **TABLE).body


def test_text_of_a_file_is_text_on_its_page(surface):
    foreign = Surface(surface.heights, spacing=0.1, history=("<script>alert(1)</script>",))
    page = surface_page(foreign, name="<b>.npy", command="<i>").html()
    assert "alert(1)</script>" not in page
    assert "<b>" not in page
    assert "<code>&lt;i&gt;</code>" in page


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_page_of_a_scan_is_for_everybody(driver, pages, scheme):
    media = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
    for kind in ("profile", "surface"):
        browser.open_page(driver, pages[kind])
        assert browser.faults(driver, browser.axe()) == []
        assert browser.foreign_requests(driver, pages[kind]) == set()
        browser.open_page(driver, pages[kind], width=360, height=740)
        assert driver.execute_script("return document.documentElement.scrollWidth") == 360
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
