"""The page of a result as people use it, in a browser, and the file that it is."""

import csv
import html
import os
import xml.etree.ElementTree

import browser
import numpy as np
import pytest
from small import SMALL, empty_dataset
from stiction import Study, friction_map
from stiction.studies.at_load import at_load
from stiction.studies.contact_picture import contact_picture
from stiction.studies.study import study_of
from stiction.views.answer import answers
from stiction.views.inputs import doubts_of_inputs
from stiction.views.report import ReportError, report_page, save_report
from stiction.views.report.page import MARK

pytest.importorskip("selenium", reason="selenium is not installed")


def in_browser(test):
    """Give a test the marks of those in a browser."""
    for mark in browser.IN_BROWSER:
        test = mark(test)
    return test


AGREEMENT = 1e-6  # the page keeps 2e-9 of each sum; intervals are differences of these


@pytest.fixture(scope="module")
def page(result, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    save_report(result, path)
    return path


@pytest.fixture(scope="module")
def maps_page(maps, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "maps.html"
    save_report(maps, path, picture=contact_picture(maps))
    return path


@pytest.fixture
def opened(driver, page):
    """The page of `result` in a browser that has nothing to complain of."""
    browser.open_page(driver, page)
    yield driver
    assert no_complaints(driver)


@pytest.fixture
def opened_maps(driver, maps_page):
    """The page of two maps in a browser that has nothing to complain of."""
    browser.open_page(driver, maps_page)
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
    browser.settle(driver)


def pointer(driver, x, y):
    """A pointer that moves there."""
    from selenium.webdriver import ActionChains

    chain = ActionChains(driver, duration=20)
    chain.w3c_actions.pointer_action.move_to_location(round(x), round(y) + 3)
    chain.w3c_actions.pointer_action.move_to_location(round(x), round(y))
    return chain


def said(driver):
    """Status, value and ends of the interval of what the panel says."""
    found = driver.execute_script("return {...document.getElementById('readout').dataset}")
    return found["status"], [float(found[name]) for name in ("value", "lower", "upper")]


def picked(driver):
    return driver.execute_script("return [state.dimension, state.load]")


def view(driver, name="map"):
    """Ends of the axes as they are looked at."""
    return driver.execute_script(
        "const {x, y} = document.getElementById(arguments[0]).axes; return [x.low, x.high, y.low, y.high]", name
    )


# ---- Generated bodies ------------------------------------------------------------------------------------------------


@in_browser
def test_numbers_under_the_pointer_are_those_of_the_library(opened, result):
    random = np.random.default_rng(5)
    dimensions, loads = result["fractal_dimension"].values, np.array(opened.execute_script("return loads"))
    seen = set()
    for _ in range(10):
        mu0, tau0 = round(random.uniform(0, 1), 3), round(random.uniform(0, 300), 2)
        enter(opened, "mu0-number", mu0)
        enter(opened, "tau0-number", tau0)
        d, row = random.integers(dimensions.size), random.integers(20, loads.size)
        # Cells are of equal size: dimensions are in equal steps, and loads in equal ratios on a logarithmic axis.
        left, top, width, height = browser.frame(opened, "map")
        x, y = left + width * (d + 0.5) / dimensions.size, top + height * (1 - (row + 0.5) / loads.size)
        pointer(opened, x, y).pause(0.2).perform()
        browser.settle(opened)
        wanted = friction_map(result, [loads[row]], mu0=[mu0], tau0=[tau0 / 1000])
        wanted = wanted.isel(fractal_dimension=d, amplitude=0, load=0, mu0=0, tau0=0)
        status, numbers = said(opened)
        seen.add(status)
        assert status == str(wanted["status"].values)
        expected = [float(wanted[name]) for name in ("friction_coefficient", "lower", "upper")]
        assert numbers == pytest.approx(expected, rel=AGREEMENT, nan_ok=True)
    assert len(seen) > 1


@in_browser
def test_a_click_picks_and_two_clicks_pick_nothing_and_show_all(opened):
    whole = view(opened)
    for _ in range(5):  # on a busy machine two clicks may be too far apart to be a double one
        left, top, width, height = browser.frame(opened, "map")
        pointer(opened, left + 0.125 * width, top + 0.7 * height).click().perform()
        browser.settle(opened)
        before = picked(opened)
        assert before[0] == 0
        browser.press(opened, "map", "+")
        assert view(opened) != whole
        left, top, width, height = browser.frame(opened, "map")
        pointer(opened, left + 0.8 * width, top + 0.4 * height).double_click().perform()
        browser.settle(opened)
        if view(opened) == pytest.approx(whole):
            break
        browser.press(opened, "map", "0")
    assert picked(opened) == before
    assert view(opened) == pytest.approx(whole)


@in_browser
def test_one_looks_closer_by_rectangle_and_buttons(opened):
    whole = view(opened)
    left, top, width, height = browser.frame(opened, "map")
    chain = pointer(opened, left + 0.3 * width, top + 0.3 * height)
    chain.click_and_hold()
    for part in (0.5, 0.7):
        chain.w3c_actions.pointer_action.move_to_location(round(left + part * width), round(top + part * height))
    chain.release().perform()
    browser.settle(opened)
    near = view(opened)
    assert near[:2] == pytest.approx([whole[0] + part * (whole[1] - whole[0]) for part in (0.3, 0.7)], rel=0.02)
    ratio = whole[3] / whole[2]
    assert near[2:] == pytest.approx([whole[2] * ratio**part for part in (0.3, 0.7)], rel=0.1)
    closer, _, all_of_it = opened.find_elements("css selector", "#friction + .saves button")[:3]
    before = view(opened, "friction")
    closer.click()
    browser.settle(opened)
    after = view(opened, "friction")
    assert before[0] < after[0] < after[1] < before[1]
    all_of_it.click()
    browser.settle(opened)
    assert view(opened, "friction") == pytest.approx(before)


@in_browser
def test_arrow_keys_move_what_is_picked(opened):
    from selenium.webdriver.common.keys import Keys

    opened.execute_script("pick(2, 40)")
    browser.settle(opened)
    dimension, load = picked(opened)
    browser.press(opened, "map", Keys.ARROW_RIGHT + Keys.ARROW_UP * 3 + Keys.ARROW_LEFT * 2)
    assert picked(opened) == [dimension - 1, load + 3]
    browser.press(opened, "area", Keys.ARROW_LEFT * 2)
    assert picked(opened) == [dimension - 1, load + 1]
    browser.press(opened, "over", Keys.ARROW_RIGHT)
    assert picked(opened) == [dimension, load + 1]
    browser.press(opened, "mu0", Keys.ARROW_RIGHT * 5)
    assert float(by_id(opened, "mu0-number").get_attribute("value")) == pytest.approx(0.45)


@in_browser
def test_cells_beyond_the_model_are_hatched_and_keep_their_colour_and_a_view_begins_elsewhere(opened):
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


@in_browser
def test_an_address_is_a_view(driver, page):
    browser.open_page(driver, page)
    enter(driver, "mu0-number", 0.37)
    enter(driver, "tau0-number", 41)
    browser.press(driver, "map", "\ue012\ue013\ue013")
    browser.rest(driver)
    address, seen = driver.current_url, by_id(driver, "answer").text
    assert "mu0=0.37" in address
    driver.get("about:blank")
    driver.get(address)
    browser.wait_until_drawn(driver)
    assert by_id(driver, "answer").text == seen
    assert driver.execute_script("return [state.mu0, state.tau0]") == [0.37, 41]
    # What is no view begins as without it.
    driver.get("about:blank")
    driver.get(page.as_uri() + "#mu0=-3&tau0=NaN&load=x&d=&way=7&rule=%00&pair=<b>")
    browser.wait_until_drawn(driver)
    assert driver.execute_script("return [state.mu0, state.tau0, state.way, state.rule]") == [0.4, 0, 0, 0]
    assert no_complaints(driver)


@in_browser
def test_pictures_have_a_title_and_parameters_and_numbers_are_saved(driver, page, tmp_path):
    driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    browser.open_page(driver, page)
    for name in ("map", "friction"):
        for button in driver.find_elements("css selector", f"#{name} + .saves button"):
            if button.text not in ("SVG", "PNG", "CSV"):
                continue
            driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", button)
            file = tmp_path / f"study_{name}.{button.text.lower()}"
            button.click()
            browser.wait(driver, lambda _, file=file: file.exists())  # a browser holds back many downloads at once
    text = (tmp_path / "study_friction.svg").read_text("utf-8")
    assert "var(" not in text
    words = " ".join(xml.etree.ElementTree.fromstring(text).itertext())
    assert "study: Friction coefficient against normal load" in words
    for each in ("μ0 = 0.4", "τ0 = 0 MPa", "D = ", "95 % interval", "View: #mu0=0.4"):
        assert each in words
    assert (tmp_path / "study_map.png").read_bytes().startswith(b"\x89PNG")
    with (tmp_path / "study_friction.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    points = driver.execute_script("return document.getElementById('friction').drawn.series[0].points")
    known = [point["value"] for point in points if point["value"] is not None]
    assert len(rows) == 80
    assert [float(row["mu_s"]) for row in rows if row["mu_s"]] == known


@in_browser
def test_other_quantities_and_amplitudes_are_picked(opened):
    from selenium.webdriver.support.ui import Select

    def drawn():
        browser.rest(opened)
        return opened.execute_script("return document.getElementById('map').innerHTML")

    seen = [drawn()]
    for what in ("width", "area", "stiffness", "friction"):
        Select(by_id(opened, "quantity")).select_by_value(what)
        seen.append(drawn())
    assert len(set(seen)) == 4  # the last is the first
    Select(by_id(opened, "amplitude")).select_by_visible_text("100 nm")
    assert drawn() not in seen
    for name, wrong in (("mu0-number", "-1"), ("tau0-number", "e")):
        enter(opened, name, wrong)
    shown = [each.get_attribute("id") for each in opened.find_elements("css selector", ".wrong") if each.is_displayed()]
    assert shown == ["mu0-wrong", "tau0-wrong"]


@in_browser
def test_what_is_missing_is_said(driver, tmp_path, result):
    unsolved = result.copy(deep=True)
    unsolved["normal_elastic"].values[0, 0, 3, 2] = np.nan
    for data, words in (
        (empty_dataset(SMALL.with_changes({"contact.approach": ["0 nm"]})), ["No pair of this study touches"]),
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
        each.get_attribute("data-rule"): float(each.find_element("tag name", "data").get_attribute("value"))
        for each in values
    }


@in_browser
def test_the_answer_of_maps_is_that_of_the_library_and_moves_with_everything(opened_maps, maps):
    from selenium.webdriver.support.ui import Select

    study = study_of(maps)
    bodies = [getattr(study.surfaces, side).read() for side in ("upper", "lower")]
    beside = doubts_of_inputs(*bodies, study, [0.1, 0.5])
    first = answers(at_load(maps, [0.1]), study, beside=beside)[0]
    assert opened_maps.find_element("css selector", ".verdict").text == first.verdict
    doubts = opened_maps.find_element("css selector", "#judgement").get_attribute("textContent")
    assert all(doubt.text[1:] in doubts for doubt in first.doubts)
    for mu0, tau0, load, way in ((0.3, 0.0, 1, 0), (0.62, 0.07, 2, 3), (0.1, 0.0, 0, 1)):
        enter(opened_maps, "mu0-number", mu0)
        enter(opened_maps, "tau0-number", 1000 * tau0)
        Select(by_id(opened_maps, "way")).select_by_index(way)
        opened_maps.execute_script("pick(0, arguments[0])", load)
        browser.settle(opened_maps)
        at = at_load(maps, maps["load"].values[[load]], mu0=[mu0], tau0=[tau0])
        name = "friction_all_round" if way == 0 else "friction_coefficient"
        at = at[name].isel(cut_off=0, load=0, mu0=0, tau0=0).sel(statistic="mean")
        at = at if way == 0 else at.isel(direction=way - 1)
        wanted = {rule: float(at.sel(sliding=rule)) for rule in ("all", "opposing")}
        assert rules_said(opened_maps) == pytest.approx(wanted, rel=1e-9)
    # What the library has not judged is not judged; one goes back to what it has.
    opened_maps.find_element("css selector", "#judgement button").click()
    browser.settle(opened_maps)
    assert opened_maps.find_element("css selector", ".verdict").text == first.verdict


@in_browser
def test_the_compass_turns_the_direction_and_pointing_at_a_curve_tells_its_numbers(opened_maps):
    from selenium.webdriver.common.keys import Keys

    for words in ("to +x", "to +y"):
        browser.press(opened_maps, "compass", Keys.ARROW_UP)
        assert words in by_id(opened_maps, "answer").text
    left, top, width, height = browser.frame(opened_maps, "friction")
    pointer(opened_maps, left + 0.5 * width, top + 0.5 * height).perform()
    browser.settle(opened_maps)
    words = opened_maps.find_element("css selector", "#friction .tip").text
    assert "all contacts rub" in words
    assert "mN" in words


# ---- Everybody -------------------------------------------------------------------------------------------------------


@in_browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_serious_fault_for_those_who_cannot_see_and_nothing_is_asked_of_anybody(driver, page, maps_page, scheme):
    axe = browser.axe()
    media = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
    for path in (page, maps_page):
        browser.open_page(driver, path)
        enter(driver, "tau0-number", 50)
        browser.open_more(driver)
        assert browser.faults(driver, axe) == []
        assert browser.foreign_requests(driver, path) == set()
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


@in_browser
def test_paper_has_all_that_the_screen_has(driver, page, maps_page):
    paper = 720  # pixels between the margins of A4
    for path in (page, maps_page):
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


@in_browser
def test_text_is_read_twice_as_large_and_on_a_phone(driver, page, maps_page):
    for path in (page, maps_page):
        browser.open_page(driver, path, width=360, height=740)
        assert driver.execute_script("return [innerWidth, document.documentElement.scrollWidth]") == [360, 360]
        browser.open_page(driver, path, width=1280)
        size = "return parseFloat(getComputedStyle(document.querySelector('#friction text')).fontSize)"
        before = driver.execute_script(size)
        driver.execute_script("document.documentElement.style.fontSize = '200%'; dispatchEvent(new Event('resize'))")
        browser.settle(driver)
        assert driver.execute_script(size) == pytest.approx(2 * before)
        assert driver.execute_script("return document.documentElement.scrollWidth") <= 1280


@in_browser
def test_the_tabulator_reaches_every_control(opened):
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


# ---- The file --------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("undrawn")
def test_text_of_a_study_is_text_on_the_page(result, maps):
    page = report_page(result.assign_attrs(stiction_version="<b>"), name="</script><script>alert(1)</script>")
    assert "alert(1)</script>" not in page
    assert "stiction &lt;b&gt;" in page
    assert html.escape(study_of(result).to_toml()) in page
    nasty = maps.assign_attrs(upper="<script>alert(2)</script>\nread")
    assert "<script>alert(2)" not in report_page(nasty)


def test_a_page_is_little_more_than_its_numbers_and_its_licence(page, result):
    text = page.read_text("utf-8")
    assert text.startswith(MARK)
    for words in ("GNU GENERAL PUBLIC LICENSE", "How to Apply These Terms to Your New Programs"):
        assert words in text
    assert page.stat().st_size < 250_000 + 10 * len(SMALL.surfaces.amplitudes()) * result["contact_area"].size * 7


def test_what_is_too_large_for_a_page_is_said(monkeypatch, result, maps):
    monkeypatch.setattr("stiction.views.report.generated.MOST_MEANS", 79)
    with pytest.raises(ReportError, match="more than the 79"):
        report_page(result)
    monkeypatch.setattr("stiction.views.report.measured.MOST_VALUES", 100)
    with pytest.raises(ReportError, match="more than the 100"):
        report_page(maps)


def test_many_repetitions_leave_out_their_intervals(monkeypatch, result):
    monkeypatch.setattr("stiction.views.report.generated.MOST_SUMS", 100)
    assert '"hasIntervals": false' in report_page(result)


def test_nothing_makes_no_page(result):
    with pytest.raises(ReportError, match="repetition"):
        report_page(result.isel(repetition=[]))


@pytest.mark.usefixtures("undrawn")
def test_a_page_is_called_by_its_study_or_its_files(result, maps):
    assert "<title>study – static friction – stiction</title>" in report_page(result)
    assert "<title>mine – " in report_page(result, name="mine")
    quick = empty_dataset(Study.named("quick")).assign_attrs(study=Study.named("quick").to_toml())
    assert "<title>quick – " in report_page(quick)
    assert "<title>upper-maps.npy on lower-maps.npy – " in report_page(maps)
    assert "<title>upper-maps.npy on lower-maps.npy (mine) – " in report_page(maps, name="mine")


def test_a_page_is_of_a_result(result):
    with pytest.raises(ReportError):
        report_page(result.drop_attrs())


def test_only_reports_are_replaced(result, tmp_path):
    path = tmp_path / "report.html"
    path.write_text(f"{MARK}old")
    save_report(result, path)
    assert len(path.read_bytes()) > 100_000
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ReportError, match="something else"):  # and does not wait for somebody to write into it
        save_report(result, tmp_path / "pipe")
    other = tmp_path / "thesis.html"
    other.write_text("years of work")
    for bad in (other, tmp_path, tmp_path / "no/report.html"):
        with pytest.raises(ReportError):
            save_report(result, bad)
    assert other.read_text() == "years of work"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["pipe", "report.html", "thesis.html"]
