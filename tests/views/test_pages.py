"""Pages of results, generated and measured, and of one scan, as people use them in a browser."""

import csv
import xml.etree.ElementTree

import numpy as np
import pytest
from stiction import friction_map, levelled, self_affine, self_affine_surface
from stiction.studies.contact_picture import contact_picture
from stiction.studies.evaluation import at_load
from stiction.studies.input_caveats import find_input_caveats
from stiction.studies.nodes import excess
from stiction.studies.study import study_of
from stiction.studies.summary import summarize
from stiction.views.characterisation import Characterisation
from stiction.views.report import report_page, save_report
from stiction.views.report.surface import surface_page
from support import browser
from support.generated_studies import SMALL_STUDY, empty_dataset

pytest.importorskip("selenium", reason="selenium is not installed")
pytestmark = browser.BROWSER_MARKS

MOST_EXCESS = 10.0  # errors at single settings over the tolerances by which nodes are chosen
CONTROL, SHIFT = 2, 8  # bits of the browser's protocol
TABLE = {"name": "scan.csv", "command": "stiction characterise scan.csv"}


@pytest.fixture(scope="module")
def profile():
    created = self_affine(1, hurst_exponent=0.7, rms=0.05, points=6001, spacing=0.01)
    return levelled(created, "line")


@pytest.fixture(scope="module")
def surface():
    created = self_affine_surface(1, hurst_exponent=0.7, rms=0.05, shape=(60, 90), spacing=0.1)
    return levelled(created, "plane")


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


@pytest.fixture
def opened(driver, pages):
    """The page of `result` in a browser that has nothing to complain of."""
    browser.open_page(driver, pages["study"])
    yield driver
    assert no_complaints(driver)


@pytest.fixture
def opened_maps(driver, pages):
    """The page of two maps in a browser that has nothing to complain of."""
    browser.open_page(driver, pages["maps"])
    yield driver
    assert no_complaints(driver)


def no_complaints(driver):
    complaints = [entry for entry in driver.get_log("browser") if entry["level"] != "INFO"]
    assert complaints == []
    return True


def by_id(driver, name):
    return driver.find_element("id", name)


def enter(driver, name, value):
    """Type a number as a person does."""
    from selenium.webdriver.common.keys import Keys

    by_id(driver, name).send_keys(Keys.CONTROL + "a" + Keys.NULL, str(value))
    browser.wait_for_drawing(driver)


def pointer(driver, x, y):
    """A pointer that moves there."""
    from selenium.webdriver import ActionChains

    chain = ActionChains(driver, duration=20)
    chain.w3c_actions.pointer_action.move_to_location(round(x), round(y) + 3)
    chain.w3c_actions.pointer_action.move_to_location(round(x), round(y))
    return chain


def said(driver):
    """Status, value and ends of the interval of what the panel says."""
    result = driver.execute_script("return {...document.getElementById('readout').dataset}")
    return result["status"], [float(result[name]) for name in ("value", "lower", "upper")]


def picked(driver):
    return driver.execute_script("return [state.dimension, state.load]")


def ends(driver, name="map"):
    """Ends of the axes as they are looked at."""
    return driver.execute_script(
        "const {x, y} = document.getElementById(arguments[0]).axes; return [x.low, x.high, y.low, y.high]", name
    )


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
    left, top, width, height = browser.find_axes_frame(driver, plot)
    mouse(driver, "mouseWheel", left + width / 4, top + 3 * height / 4, modifiers=CONTROL, deltaX=0, deltaY=-200)
    browser.wait_for(
        driver, lambda driver: driver.execute_script(f"return document.getElementById('{plot}').view != null")
    )
    browser.wait_for_drawing(driver)


@pytest.mark.parametrize(("kind", "plot"), [(kind, plot) for kind, plots in KINDS.items() for plot in sorted(plots)])
def test_plots_zoom_and_pan(driver, pages, kind, plot):
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
    left, top, width, height = browser.find_axes_frame(driver, plot)
    start = (left + width / 2, top + height / 2)
    mouse(driver, "mousePressed", *start, modifiers=SHIFT, button="left", clickCount=1)
    for part in (0.05, 0.1):
        end = start[0] + part * width, start[1] - part * height
        mouse(driver, "mouseMoved", *end, modifiers=SHIFT, button="left", buttons=1)
    mouse(driver, "mouseReleased", *end, modifiers=SHIFT, button="left", clickCount=1)
    browser.wait_for_drawing(driver)
    moved = view(driver, plot)
    assert (moved - near)[0] == pytest.approx(-0.1 * ratio[0] * span[0], rel=0.05)
    assert (moved - near)[1] == pytest.approx(-0.1 * ratio[1] * span[1], rel=0.05)
    browser.press_keys(driver, plot, Keys.SHIFT + Keys.ARROW_RIGHT + Keys.NULL)
    assert (view(driver, plot) - moved)[0] == pytest.approx(0.2 * ratio[0] * span[0], rel=0.05)
    browser.press_keys(driver, plot, "0")
    assert view(driver, plot) == pytest.approx(whole)
    browser.press_keys(driver, plot, "+")
    assert np.diff(view(driver, plot)).ravel() == pytest.approx(span / 1.5)
    browser.press_keys(driver, plot, "-")
    assert view(driver, plot) == pytest.approx(whole)
    # Two fingers that move apart.
    driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True, "maxTouchPoints": 2})
    left, top, width, height = browser.find_axes_frame(driver, plot)
    for kind_of_event, times in (("touchStart", 1), ("touchMove", 1.5), ("touchMove", 2)):
        x = [left + width * (0.5 + 0.1 * side * times) for side in (-1, 1)]
        touch(driver, kind_of_event, *((item, top + height / 2) for item in x))
    touch(driver, "touchEnd")
    browser.wait_for_drawing(driver)
    driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": False})
    near = view(driver, plot)
    assert np.diff(near).ravel() == pytest.approx(span / 2, rel=0.05)
    assert near.mean(axis=1) == pytest.approx(whole.mean(axis=1), abs=0.02 * span.max())
    assert no_complaints(driver)


def test_report_of_surface_has_table_and_slope_estimate(driver, pages, profile):
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


# ---- Generated bodies ------------------------------------------------------------------------------------------------


def test_numbers_under_pointer_equal_the_library(opened, result):
    random = np.random.default_rng(5)
    dimensions, loads = result["fractal_dimension"].values, np.array(opened.execute_script("return loads"))
    recorded = set()
    errors = []
    for _ in range(10):
        mu0, tau0 = round(random.uniform(0, 1), 3), round(random.uniform(0, 200), 2)
        enter(opened, "mu0-number", mu0)
        enter(opened, "tau0-number", tau0)
        d, row = random.integers(dimensions.size), random.integers(loads.size // 4, loads.size)
        # Cells are of equal size: dimensions are in equal steps, and loads in equal ratios on a logarithmic axis.
        left, top, width, height = browser.find_axes_frame(opened, "map")
        x, y = left + width * (d + 0.5) / dimensions.size, top + height * (1 - (row + 0.5) / loads.size)
        pointer(opened, x, y).pause(0.2).perform()
        browser.wait_for_drawing(opened)
        reference = friction_map(result, [loads[row]], mu0=[mu0], tau0=[tau0 / 1000])
        reference = reference.isel(fractal_dimension=d, amplitude=0, load=0, mu0=0, tau0=0)
        status, numbers = said(opened)
        recorded.add(status)
        if status == "between-nodes":
            continue
        assert status == str(reference["status"].values)
        expected = [float(reference[name]) for name in ("friction_coefficient", "lower", "upper")]
        errors.append(float(excess(np.array(numbers), np.array(expected))))
    assert np.median(errors) < 1.0
    assert np.max(errors) < MOST_EXCESS
    assert len(recorded) > 1


def test_click_selects_and_double_click_resets(opened):
    whole = ends(opened)
    for _ in range(5):  # on a busy machine two clicks may be too far apart to be a double one
        left, top, width, height = browser.find_axes_frame(opened, "map")
        pointer(opened, left + 0.125 * width, top + 0.7 * height).click().perform()
        browser.wait_for_drawing(opened)
        before = picked(opened)
        assert before[0] == 0
        browser.press_keys(opened, "map", "+")
        assert ends(opened) != whole
        left, top, width, height = browser.find_axes_frame(opened, "map")
        pointer(opened, left + 0.8 * width, top + 0.4 * height).double_click().perform()
        browser.wait_for_drawing(opened)
        if ends(opened) == pytest.approx(whole):
            break
        browser.press_keys(opened, "map", "0")
    assert picked(opened) == before
    assert ends(opened) == pytest.approx(whole)


def test_rectangle_and_buttons_zoom(opened):
    whole = ends(opened)
    left, top, width, height = browser.find_axes_frame(opened, "map")
    chain = pointer(opened, left + 0.3 * width, top + 0.3 * height)
    chain.click_and_hold()
    for part in (0.5, 0.7):
        chain.w3c_actions.pointer_action.move_to_location(round(left + part * width), round(top + part * height))
    chain.release().perform()
    browser.wait_for_drawing(opened)
    near = ends(opened)
    assert near[:2] == pytest.approx([whole[0] + part * (whole[1] - whole[0]) for part in (0.3, 0.7)], rel=0.02)
    ratio = whole[3] / whole[2]
    assert near[2:] == pytest.approx([whole[2] * ratio**part for part in (0.3, 0.7)], rel=0.1)
    closer, _, all_of_it = opened.find_elements("css selector", "#friction + .saves button")[:3]
    before = ends(opened, "friction")
    closer.click()
    browser.wait_for_drawing(opened)
    after = ends(opened, "friction")
    assert before[0] < after[0] < after[1] < before[1]
    all_of_it.click()
    browser.wait_for_drawing(opened)
    assert ends(opened, "friction") == pytest.approx(before)


def test_arrow_keys_move_the_selection(opened):
    from selenium.webdriver.common.keys import Keys

    opened.execute_script("pick(2, 20)")
    browser.wait_for_drawing(opened)
    dimension, load = picked(opened)
    browser.press_keys(opened, "map", Keys.ARROW_RIGHT + Keys.ARROW_UP * 3 + Keys.ARROW_LEFT * 2)
    assert picked(opened) == [dimension - 1, load + 3]
    browser.press_keys(opened, "area", Keys.ARROW_LEFT * 2)
    assert picked(opened) == [dimension - 1, load + 1]
    browser.press_keys(opened, "over", Keys.ARROW_RIGHT)
    assert picked(opened) == [dimension, load + 1]
    browser.press_keys(opened, "mu0", Keys.ARROW_RIGHT * 5)
    assert float(by_id(opened, "mu0-number").get_attribute("value")) == pytest.approx(0.45)


def test_cells_beyond_the_model_are_hatched(opened):
    assert opened.find_elements("css selector", "dd.beyond") == []
    assert by_id(opened, "readout").get_attribute("data-status") == "ok"
    hatched, colours = opened.execute_script(
        "const paths = [...document.querySelectorAll('#map path')];"
        "const of = (test) => paths.filter((each) => test(each.getAttribute('fill') ?? ''))"
        ".map((each) => each.getAttribute('d')).join('');"
        "return [of((fill) => fill.includes('beyond')), of((fill) => fill.startsWith('rgb'))]"
    )
    cells = [f"M{each}" for each in hatched.split("M") if each]
    assert cells
    assert all(cell in colours for cell in cells)
    assert opened.execute_script("return document.querySelectorAll('#map [style*=fill-opacity]').length") == 0


def test_address_restores_the_view(driver, pages):
    browser.open_page(driver, pages["study"])
    enter(driver, "mu0-number", 0.37)
    enter(driver, "tau0-number", 41)
    browser.press_keys(driver, "map", "\ue012\ue013\ue013")
    browser.wait_until_idle(driver)
    address, recorded = driver.current_url, by_id(driver, "answer").text
    assert "mu0=0.37" in address
    driver.get("about:blank")
    driver.get(address)
    browser.wait_until_drawn(driver)
    assert by_id(driver, "answer").text == recorded
    assert driver.execute_script("return [state.mu0, state.tau0]") == [0.37, 41]
    # What is no view begins as without it.
    driver.get("about:blank")
    driver.get(pages["study"].as_uri() + "#mu0=-3&tau0=NaN&load=x&d=&way=7&rule=%00&pair=<b>")
    browser.wait_until_drawn(driver)
    assert driver.execute_script("return [state.mu0, state.tau0, state.way, state.rule]") == [0.4, 0, 0, 0]
    assert no_complaints(driver)


def test_figures_and_numbers_are_saved(driver, pages, tmp_path):
    driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    browser.open_page(driver, pages["study"])
    for name in ("map", "friction"):
        for button in driver.find_elements("css selector", f"#{name} + .saves button"):
            if button.text not in ("SVG", "PNG", "CSV"):
                continue
            driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", button)
            file = tmp_path / f"study_{name}.{button.text.lower()}"
            button.click()
            browser.wait_for(driver, lambda _, file=file: file.exists())  # a browser holds back many downloads at once
    text = (tmp_path / "study_friction.svg").read_text("utf-8")
    assert "var(" not in text
    words = " ".join(xml.etree.ElementTree.fromstring(text).itertext())
    assert "study: Friction coefficient against normal load" in words
    for item in ("μ0 = 0.4", "τ0 = 0 MPa", "D = ", "95 % interval", "View: #mu0=0.4"):
        assert item in words
    assert (tmp_path / "study_map.png").read_bytes().startswith(b"\x89PNG")
    with (tmp_path / "study_friction.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    points = driver.execute_script("return document.getElementById('friction').drawn.series[0].points")
    known = [point["value"] for point in points if point["value"] is not None]
    assert len(rows) == 40
    assert [float(row["mu_s"]) for row in rows if row["mu_s"]] == known


def test_other_quantities_and_amplitudes_are_selected(opened):
    from selenium.webdriver.support.ui import Select

    def drawn():
        browser.wait_until_idle(opened)
        return opened.execute_script("return document.getElementById('map').innerHTML")

    recorded = [drawn()]
    for what in ("width", "area", "stiffness", "friction"):
        Select(by_id(opened, "quantity")).select_by_value(what)
        recorded.append(drawn())
    assert len(set(recorded)) == 4  # the last is the first
    Select(by_id(opened, "amplitude")).select_by_visible_text("100 nm")
    assert drawn() not in recorded
    for name, wrong in (("mu0-number", "-1"), ("tau0-number", "e")):
        enter(opened, name, wrong)
    shown = [
        element.get_attribute("id")
        for element in opened.find_elements("css selector", ".wrong")
        if element.is_displayed()
    ]
    assert shown == ["mu0-wrong", "tau0-wrong"]


def test_missing_results_are_reported(driver, tmp_path, result):
    unsolved = result.copy(deep=True)
    unsolved["normal_elastic"].values[0, 0, 3, 2] = np.nan
    for data, words in (
        (empty_dataset(SMALL_STUDY.with_changes({"contact.approach": ["0 nm"]})), ["No pair of this study touches"]),
        (result.isel(repetition=[0]), ["is unfinished: 1 of 12 repetitions", "there is one repetition"]),
        (result.isel(fractal_dimension=[0], amplitude=[0], approach=[-1]), ["one approach", "no value in this range"]),
        (unsolved, ["1 repetition without a solution"]),
    ):
        save_report(data, tmp_path / "report.html")
        browser.open_page(driver, tmp_path / "report.html")
        text = driver.find_element("tag name", "body").text
        for word in words:
            assert word in text
        assert no_complaints(driver)


# ---- Measured bodies -------------------------------------------------------------------------------------------------


def rules_said(driver):
    """Value of each rule."""
    values = driver.find_elements("css selector", "#answer .value")
    return {
        value.get_attribute("data-rule"): float(value.find_element("tag name", "data").get_attribute("value"))
        for value in values
    }


def test_result_of_maps_equals_the_library_for_all_controls(opened_maps, maps):
    from selenium.webdriver.support.ui import Select

    study = study_of(maps)
    bodies = [getattr(study.surfaces, side).read() for side in ("upper", "lower")]
    beside = find_input_caveats(*bodies, study, [0.1, 0.5])
    first = summarize(at_load(maps, [0.1]), study, input_caveats=beside).points[0]
    assert opened_maps.find_element("css selector", ".verdict").text == first.verdict
    caveats = opened_maps.find_element("css selector", "#judgement").get_attribute("textContent")
    assert all(caveat.text[1:] in caveats for caveat in first.caveats)
    for mu0, tau0, load, way in ((0.3, 0.0, 1, 0), (0.62, 0.07, 2, 3), (0.1, 0.0, 0, 1)):
        enter(opened_maps, "mu0-number", mu0)
        enter(opened_maps, "tau0-number", 1000 * tau0)
        Select(by_id(opened_maps, "way")).select_by_index(way)
        opened_maps.execute_script("pick(0, arguments[0])", load)
        browser.wait_for_drawing(opened_maps)
        at = at_load(maps, maps["load"].values[[load]], mu0=[mu0], tau0=[tau0])
        name = "friction_all_round" if way == 0 else "friction_coefficient"
        at = at[name].isel(cut_off=0, load=0, mu0=0, tau0=0).sel(statistic="mean")
        at = at if way == 0 else at.isel(direction=way - 1)
        expected = {rule: float(at.sel(sliding=rule)) for rule in ("all", "opposing")}
        assert rules_said(opened_maps) == pytest.approx(expected, rel=1e-4)
    # What the library has not judged is not judged; one goes back to what it has.
    opened_maps.find_element("css selector", "#judgement button").click()
    browser.wait_for_drawing(opened_maps)
    assert opened_maps.find_element("css selector", ".verdict").text == first.verdict


def test_compass_sets_direction_and_curve_shows_numbers(opened_maps):
    from selenium.webdriver.common.keys import Keys

    for words in ("to +x", "to +y"):
        browser.press_keys(opened_maps, "compass", Keys.ARROW_UP)
        assert words in by_id(opened_maps, "answer").text
    left, top, width, height = browser.find_axes_frame(opened_maps, "friction")
    pointer(opened_maps, left + 0.5 * width, top + 0.5 * height).perform()
    browser.wait_for_drawing(opened_maps)
    words = opened_maps.find_element("css selector", "#friction .tip").text
    assert "friction at all contacts" in words
    assert "mN" in words


# ---- Everybody -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_report_is_accessible_and_sends_no_requests(driver, pages, scheme):
    axe = browser.load_axe_script()
    media = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
    for kind, path in pages.items():
        browser.open_page(driver, path)
        if kind in KINDS:
            enter(driver, "tau0-number", 50)
            browser.open_more(driver)
        assert browser.find_accessibility_faults(driver, axe) == []
        assert browser.foreign_requests(driver, path) == set()
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def test_printed_report_has_the_content_of_the_screen(driver, pages):
    paper = 720  # pixels between the margins of A4
    for path in (pages["study"], pages["maps"]):
        browser.open_page(driver, path, width=1280)
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        metrics = {"width": paper, "height": 1000, "deviceScaleFactor": 1, "mobile": False}
        widths = driver.execute_script(
            "return [...document.querySelectorAll('.plot svg')].map((each) => each.clientWidth)"
        )
        # The page is not drawn anew for paper, so pictures shrink as a whole: nothing of one is cut off.
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        cut = driver.execute_script(
            "return [...document.querySelectorAll('.plot svg')].filter((each) => each.checkVisibility()).filter("
            "(each) => { const {width, height, right} = each.getBoundingClientRect();"
            " const [, , w, h] = each.getAttribute('viewBox').split(' ');"
            " return right > innerWidth + 1 || Math.abs(height / width - h / w) > 0.02 ||"
            "  each.parentNode.getBoundingClientRect().height < height - 1; }).map((each) => each.parentNode.id)"
        )
        assert widths
        assert cut == []
        assert driver.execute_script("return document.documentElement.scrollWidth") <= paper
        assert by_id(driver, "parameters").is_displayed()
        assert "μ0 = " in by_id(driver, "parameters").text
        shown = driver.execute_script(
            "return [...document.querySelectorAll('form, button, input, select')]"
            ".filter((each) => each.checkVisibility()).length"
        )
        assert shown == 0
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


def test_report_is_readable_at_double_size_and_on_a_phone(driver, pages):
    for kind, path in pages.items():
        browser.open_page(driver, path, width=360, height=740)
        assert driver.execute_script("return [innerWidth, document.documentElement.scrollWidth]") == [360, 360]
        if kind not in KINDS:
            continue
        browser.open_page(driver, path, width=1280)
        size = "return parseFloat(getComputedStyle(document.querySelector('#friction text')).fontSize)"
        before = driver.execute_script(size)
        driver.execute_script("document.documentElement.style.fontSize = '200%'; dispatchEvent(new Event('resize'))")
        browser.wait_for_drawing(driver)
        assert driver.execute_script(size) == pytest.approx(2 * before)
        assert driver.execute_script("return document.documentElement.scrollWidth") <= 1280


def test_tab_key_reaches_every_control(opened):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.keys import Keys

    controls = opened.execute_script(
        "return [...document.querySelectorAll('input, select, button, summary, [tabindex]')]"
        ".filter((e) => !e.disabled && e.checkVisibility()).map((e) => e.id || e.tagName)"
    )
    reached = set()
    for _ in range(len(controls) + 3):
        ActionChains(opened).send_keys(Keys.TAB).perform()
        reached.add(opened.execute_script("const e = document.activeElement; return e.id || e.tagName"))
    assert len(controls) >= 14
    assert set(controls) <= reached
    unnamed = opened.execute_script(
        "return [...document.querySelectorAll('input, select')].filter((e) => !e.labels.length && !e.ariaLabel).length"
    )
    assert unnamed == 0
