import html
import os
import re
import shutil

import browser
import numpy as np
import pytest
from command import assert_refused, stiction_command
from small import SMALL
from stiction import Study, friction_map, run
from stiction.studies import store
from stiction.studies.dataset import empty_dataset
from stiction.studies.study import study_of
from stiction.views.report import ReportError, report_page, save_report
from stiction.views.report.page import MARK

pytest.importorskip("selenium", reason="selenium is not installed")

in_browser = pytest.mark.skipif(
    not (browser.CHROMIUM and browser.DRIVER), reason="Debian's chromium and chromium-driver are not installed"
)

AGREEMENT = 1e-6
"""The page keeps 2e-9 of each sum; intervals are differences of these."""


@pytest.fixture(scope="module")
def result(small_result):
    return small_result


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    with browser.browser(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


@pytest.fixture(scope="module")
def page(result, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    save_report(result, path)
    return path


@pytest.fixture
def opened(driver, page):
    """The page of `result` in a browser that has nothing to complain of."""
    browser.open_page(driver, page)
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


def map_values(driver):
    return driver.execute_script("return [maps[0].value, document.getElementById('map-0').innerHTML]")


def inner(driver, name="map-0"):
    """Where a plot is drawn inside of its axes: left, top, width, height, in the window."""
    return driver.execute_script(
        "const place = document.getElementById(arguments[0]); place.scrollIntoView({block: 'center'});"
        "const {left, top} = place.getBoundingClientRect(); const {x, y, width, height} = place.axes.frame;"
        "return [left + x, top + y, width, height]", name
    )  # fmt: skip


def pointer(driver, x, y):
    """A pointer that moves there."""
    from selenium.webdriver import ActionChains

    chain = ActionChains(driver, duration=20)
    chain.w3c_actions.pointer_action.move_to_location(round(x), round(y) + 3)
    chain.w3c_actions.pointer_action.move_to_location(round(x), round(y))
    return chain


def shown_in_full(driver):
    """What the panel says: value, ends of the interval, load and status."""
    text = by_id(driver, "readout").text
    status = driver.find_element("css selector", "#readout dd.status").text
    number = r"([-+\d.e]+|none)"
    match = re.search(rf"In full: {number} \[{number}, {number}\] at D = {number}, {number} mN", text)
    if match is None:
        return status, None
    return status, [np.nan if part == "none" else float(part) for part in match.groups()]


# ---- In a browser ----------------------------------------------------------------------------------------------------


@in_browser
def test_numbers_under_the_pointer_are_those_of_the_library(opened, result):
    random = np.random.default_rng(5)
    dimensions = result["fractal_dimension"].values
    loads = np.array(opened.execute_script("return loads"))
    seen = set()
    for _ in range(10):
        mu0, tau0 = round(random.uniform(0, 1), 3), round(random.uniform(0, 300), 2)
        enter(opened, "mu0-number", mu0)
        enter(opened, "tau0-number", tau0)
        d, row = random.integers(dimensions.size), random.integers(20, loads.size)
        # Cells are of equal size: dimensions are in equal steps, and loads in equal ratios on a logarithmic axis.
        left, top, width, height = inner(opened)
        x, y = left + width * (d + 0.5) / dimensions.size, top + height * (1 - (row + 0.5) / loads.size)
        pointer(opened, x, y).pause(0.2).perform()
        browser.settle(opened)
        wanted = friction_map(result, [loads[row]], mu0=[mu0], tau0=[tau0 / 1000])
        wanted = wanted.isel(fractal_dimension=d, amplitude=0, load=0, mu0=0, tau0=0)
        status, numbers = shown_in_full(opened)
        seen.add(status)
        assert "Under the pointer" in by_id(opened, "readout").text
        assert status == str(wanted["status"].values)
        if status != "ok":
            assert numbers is None
            continue
        expected = [float(wanted[name]) for name in ("friction_coefficient", "lower", "upper")]
        assert numbers == pytest.approx([*expected, dimensions[d], loads[row]], rel=AGREEMENT, nan_ok=True)
    assert len(seen) > 1


@in_browser
def test_a_click_picks_a_cell_that_stays(opened):
    left, top, width, height = inner(opened)
    pointer(opened, left + 0.125 * width, top + 0.7 * height).click().perform()
    pointer(opened, 5, 400).perform()
    browser.settle(opened)
    assert by_id(opened, "readout").text.startswith("Picked: D = 1.000")
    assert by_id(opened, "dimension").get_attribute("value") == "0"


@in_browser
def test_a_tap_takes_the_place_of_the_pointer(opened):
    left, top, width, height = inner(opened)
    for d in (0, 2):  # of four; the finger does not leave as a pointer does
        at = {"x": left + width * (d + 0.5) / 4, "y": top + 0.7 * height}
        opened.execute_cdp_cmd("Input.synthesizeTapGesture", at)
        browser.settle(opened)
        assert float(by_id(opened, "readout").get_attribute("data-dimension")) == pytest.approx(1 + 0.2 * d)
        assert by_id(opened, "dimension").get_attribute("value") == str(d)


@in_browser
def test_arrow_keys_move_the_picked_point(opened):
    from selenium.webdriver.common.keys import Keys

    dimension, load = (int(by_id(opened, name).get_attribute("value")) for name in ("dimension", "load"))
    by_id(opened, "map-0").send_keys(Keys.ARROW_RIGHT + Keys.ARROW_UP * 3 + Keys.ARROW_LEFT * 2)
    browser.settle(opened)
    assert int(by_id(opened, "dimension").get_attribute("value")) == dimension - 1
    assert int(by_id(opened, "load").get_attribute("value")) == load + 3
    by_id(opened, "map-0").send_keys(Keys.ARROW_LEFT * 9)
    browser.settle(opened)
    assert by_id(opened, "dimension").get_attribute("value") == "0"


@in_browser
def test_a_rectangle_zooms_and_a_double_click_shows_all(opened):
    whole = opened.execute_script("return [loads, state.seen]")
    left, top, width, height = inner(opened)
    chain = pointer(opened, left + 0.3 * width, top + 0.3 * height)
    chain.click_and_hold()
    for share in (0.5, 0.7):
        chain.w3c_actions.pointer_action.move_to_location(round(left + share * width), round(top + share * height))
    chain.release().perform()
    browser.settle(opened)
    loads, seen = opened.execute_script("return [loads, state.seen]")
    assert seen == [1, 2]
    assert loads[0] == pytest.approx(whole[0][24], rel=0.2)
    assert loads[-1] == pytest.approx(whole[0][56], rel=0.2)
    left, top, width, height = inner(opened, "over")
    pointer(opened, left + 0.4 * width, top + 0.5 * height).double_click().perform()
    pointer(opened, *(inner(opened)[:2])).perform()
    left, top, width, height = inner(opened)
    pointer(opened, left + 0.5 * width, top + 0.5 * height).double_click().perform()
    browser.settle(opened)
    assert opened.execute_script("return [loads, state.seen]") == whole


@in_browser
def test_an_address_is_a_view(driver, page):
    browser.open_page(driver, page)
    enter(driver, "mu0-number", 0.37)
    enter(driver, "tau0-number", 41)
    by_id(driver, "map-0").send_keys("\ue012\ue013\ue013")
    enter(driver, "load-high", 0.02)
    browser.rest(driver)
    address, seen = driver.current_url, by_id(driver, "readout").text
    assert "mu0=0.37" in address
    driver.get("about:blank")
    driver.get(address)
    browser.wait_until_drawn(driver)
    assert by_id(driver, "readout").text == seen
    assert driver.execute_script("return [state.mu0, state.tau0, loads.at(-1)]") == [0.37, 41, 0.02]
    # What is no view begins as without it.
    driver.get("about:blank")
    bad = "#mu0=-3&tau0=NaN&load=x&d=&low=9&high=1&motion=7&seen=%00&dark=<b>&pair=1e9&from=3&to=1"
    driver.get(page.as_uri() + bad)
    browser.wait_until_drawn(driver)
    assert driver.execute_script("return [state.mu0, state.tau0, state.motion, state.seen]") == [0.4, 0, 0, [0, 3]]
    assert no_complaints(driver)


@in_browser
def test_pictures_and_numbers_are_saved(driver, page, tmp_path):
    import csv
    import xml.etree.ElementTree

    driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    browser.open_page(driver, page)
    names = ("map-0", "over", "friction", "area", "stiffness", "profiles")
    for name in names:
        for button in driver.find_elements("css selector", f"#{name} + .saves button"):
            assert driver.execute_script("return arguments[0].ariaLabel", button).startswith(button.text)
            driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", button)
            file = tmp_path / f"study_{name}.{button.text.lower()}"
            button.click()
            browser.wait(driver, lambda _, file=file: file.exists())  # a browser holds back many downloads at once
    wanted = {f"study_{name}.{kind}" for name in names for kind in ("svg", "png", "csv")}
    assert wanted <= {each.name for each in tmp_path.iterdir()}
    for name in names:
        root = xml.etree.ElementTree.parse(tmp_path / f"study_{name}.svg").getroot()
        assert root.tag.endswith("svg")
        assert "var(" not in (tmp_path / f"study_{name}.svg").read_text("utf-8")
        assert (tmp_path / f"study_{name}.png").read_bytes().startswith(b"\x89PNG")
    with (tmp_path / "study_friction.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 80
    points = driver.execute_script("return document.getElementById('friction').drawn.series[0].points")
    known = [point["value"] for point in points if point["value"] is not None]
    assert [float(row["friction"]) for row in rows if row["friction"]] == known
    with (tmp_path / "study_map-0.csv").open(encoding="utf-8", newline="") as file:
        assert len(list(csv.DictReader(file))) == 80 * 4


@in_browser
def test_colours_follow_what_is_shown_unless_they_are_kept(opened):
    ends = "return [document.getElementById('colour-low').value, document.getElementById('colour-high').value]"
    start = opened.execute_script(ends)
    enter(opened, "mu0-number", 1.5)
    browser.rest(opened)
    fitted = opened.execute_script(ends)
    assert float(fitted[0]) > float(start[0])
    by_id(opened, "lock").click()
    enter(opened, "mu0-number", 0.2)
    browser.rest(opened)
    assert opened.execute_script(ends) == fitted
    by_id(opened, "lock").click()
    browser.rest(opened)
    assert opened.execute_script(ends) != fitted


@in_browser
def test_a_view_begins_where_the_model_is_meant_for(opened):
    assert opened.find_elements("css selector", "dd.beyond") == []
    assert by_id(opened, "readout").get_attribute("data-status") == "ok"


@in_browser
@pytest.mark.parametrize("what", ["width", "area", "stiffness"])
def test_other_quantities_are_mapped(opened, what):
    from selenium.webdriver.support.ui import Select

    before = map_values(opened)
    Select(by_id(opened, "quantity")).select_by_value(what)
    browser.rest(opened)
    assert map_values(opened) != before
    low, high = opened.execute_script("return state.colours")
    assert 0 < low < high


@in_browser
def test_two_results_are_side_by_side(driver, result, tmp_path):
    other = run(SMALL.with_changes({"ensemble.repetitions": 3, "contact.effective_modulus": "20 GPa"}))
    save_report([result, other], tmp_path / "report.html", names=["soft", "stiff <b>"])
    browser.open_page(driver, tmp_path / "report.html")
    assert driver.title.startswith("soft and stiff <b>")
    load = float(by_id(driver, "readout").get_attribute("data-load"))
    d = int(by_id(driver, "dimension").get_attribute("value"))
    values = [float(e.get_attribute("value")) for e in driver.find_elements("css selector", "#answer .value data")]
    for found, data in zip(values, (result, other), strict=True):
        wanted = friction_map(data.isel(fractal_dimension=[d], amplitude=[0]), [load], mu0=[0.4], tau0=[0.0])
        assert found == pytest.approx(float(wanted["friction_coefficient"].squeeze()), rel=AGREEMENT)
    assert len(driver.find_elements("css selector", "#maps .plot svg")) == 2
    assert no_complaints(driver)


@in_browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_serious_fault_for_those_who_cannot_see(driver, page, scheme):
    axe = browser.axe()
    driver.execute_cdp_cmd(
        "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    )
    browser.open_page(driver, page)
    assert browser.serious_faults(driver, axe) == []
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


@in_browser
def test_twice_the_size_of_text(driver, page):
    browser.open_page(driver, page, width=1280)
    texts = "body, .hint, .interval, input[type=number], select, #friction text, .value"
    sizes = f"return [...document.querySelectorAll('{texts}')]"
    sizes += ".map((e) => parseFloat(getComputedStyle(e).fontSize))"
    before = driver.execute_script(sizes)
    driver.execute_script("document.documentElement.style.fontSize = '200%'; dispatchEvent(new Event('resize'))")
    browser.settle(driver)
    after = driver.execute_script(sizes)
    assert min(after) == pytest.approx(2 * min(before))
    assert driver.execute_script("return document.documentElement.scrollWidth") <= 1280


@in_browser
def test_a_map_without_values_says_why(opened):
    enter(opened, "load-high", 1000)
    enter(opened, "load-low", 500)
    left, top, width, _ = inner(opened)
    pointer(opened, left + 0.875 * width, top + 10).pause(0.2).perform()
    browser.settle(opened)
    assert by_id(opened, "readout").text.startswith("Under the pointer: D = 1.600")
    assert shown_in_full(opened) == ("not-reached", None)


@in_browser
def test_a_band_that_is_cut_off_is_said_to_be(driver, tmp_path, result):
    for data, is_cut in ((result.isel(repetition=[0, 1]), True), (result, False)):
        save_report(data, tmp_path / "report.html")
        browser.open_page(driver, tmp_path / "report.html")
        highest, top = driver.execute_script(
            "const {series, high} = document.getElementById('friction').drawn;"
            "return [Math.max(...series[0].points.map((p) => p.upper).filter(Number.isFinite)), high]"
        )
        assert (highest > top) == is_cut
        assert ("cut off above" in by_id(driver, "friction-caption").text) == is_cut


@in_browser
@pytest.mark.parametrize("name", ["friction", "area", "stiffness"])
def test_curves_are_drawn_of_what_is_computed(opened, name):
    enter(opened, "mu0-number", 0.37)
    enter(opened, "tau0-number", 41)
    points, drawn, loads = opened.execute_script(
        "const {series: [{points}]} = document.getElementById(arguments[0]).drawn;"
        "const {result, d, a} = picked(0);"
        "const computed = readOff(result, arguments[0], d, a, loads, 0.37, 0.041);"
        "return [computed, points, loads]", name
    )  # fmt: skip
    assert [point["value"] for point in drawn] == [point["value"] for point in points]
    assert [point["x"] for point in drawn] == loads
    assert sum(point["value"] is not None for point in points) > 20
    # A curve and its band have the places of their values on the axes.
    far = opened.execute_script(
        "const place = document.getElementById(arguments[0]); const {X, Y} = place.axes;"
        "const {series: [{points}], low, high} = place.drawn;"
        "const d = [...place.querySelectorAll('path')].map((each) => each.getAttribute('d')).join(' ');"
        "return points.filter(({value}) => value > 0).filter(({x, value}) =>"
        " !d.includes(`${X(x).toFixed(1)} ${Y(Math.min(Math.max(value, low), high)).toFixed(1)}`)).length", name
    )  # fmt: skip
    assert far == 0


@in_browser
@pytest.mark.parametrize(("name", "unit"), [("mu0", 0.01), ("tau0", 1.0)])
def test_a_key_on_a_slider_changes_map_curves_and_panel(opened, name, unit):
    from selenium.webdriver.common.keys import Keys

    def drawn():
        browser.rest(opened)
        curves = opened.execute_script(
            "return ['friction', 'area', 'stiffness', 'over'].map((id) => document.getElementById(id).innerHTML)"
        )
        return [map_values(opened), *curves, by_id(opened, "readout").text]

    before, start = drawn(), float(by_id(opened, f"{name}-number").get_attribute("value"))
    by_id(opened, name).send_keys(Keys.ARROW_RIGHT * 5)
    browser.settle(opened)
    after = drawn()
    assert float(by_id(opened, f"{name}-number").get_attribute("value")) == pytest.approx(start + 5 * unit)
    assert all(one != other for one, other in zip(before, after, strict=True))
    by_id(opened, name).send_keys(Keys.ARROW_LEFT * 5)
    browser.settle(opened)
    assert drawn() == before


@in_browser
def test_amplitude_loads_and_colours_are_picked(opened):
    from selenium.webdriver.support.ui import Select

    before = map_values(opened)
    Select(by_id(opened, "amplitude")).select_by_visible_text("100 nm")
    browser.settle(opened)
    other = map_values(opened)
    assert other != before
    assert "100 nm" in by_id(opened, "profiles-caption").text
    enter(opened, "load-high", 0.01)
    assert opened.execute_script("return loads.at(-1)") == 0.01
    assert map_values(opened) != other
    enter(opened, "colour-high", 2)
    assert opened.execute_script("return state.colours[1]") == 2
    kept = map_values(opened)
    for name, wrong in (("mu0-number", "-1"), ("load-high", "0"), ("tau0-number", "e")):
        enter(opened, name, wrong)
        assert not opened.execute_script("return arguments[0].validity.valid", by_id(opened, name))
        assert by_id(opened, f"{name.split('-')[0]}-wrong").is_displayed()
        assert map_values(opened) == kept
    enter(opened, "load-high", 1)
    by_id(opened, "mu0").send_keys("\ue014")
    shown = [e.get_attribute("id") for e in opened.find_elements("css selector", ".wrong") if e.is_displayed()]
    assert shown == ["tau0-wrong"]


@in_browser
def test_profiles_come_nearer_with_the_approach(opened):
    from selenium.webdriver.common.keys import Keys

    by_id(opened, "approach").send_keys(Keys.HOME)
    browser.settle(opened)
    upper = np.array(opened.execute_script("return document.getElementById('profiles').drawn.upper"))
    by_id(opened, "approach").send_keys(Keys.END)
    browser.settle(opened)
    nearer = np.array(opened.execute_script("return document.getElementById('profiles').drawn.upper"))
    approaches = SMALL.contact.approaches()
    assert upper - nearer == pytest.approx(1000 * (approaches[-1] - approaches[0]))
    assert re.search(r"\d+ contacts? here", by_id(opened, "profiles-caption").text)


@in_browser
def test_nothing_is_asked_of_anybody(driver, page):
    browser.open_page(driver, page)
    by_id(driver, "mu0").send_keys("5")
    enter(driver, "tau0-number", 50)
    asked = [url for url in browser.requests(driver) if not url.startswith(("data:", "blob:"))]
    assert {url.split("#")[0] for url in asked} == {page.as_uri()}


@in_browser
def test_a_phone_does_not_scroll_sideways(driver, page):
    browser.open_page(driver, page, width=360, height=740)
    assert driver.execute_script("return [innerWidth, document.documentElement.scrollWidth]") == [360, 360]
    wide = driver.execute_script(
        "return [...document.querySelectorAll('body *')].filter((e) => e.getBoundingClientRect().right > 361"
        " && !e.closest('pre')).map((e) => e.outerHTML.slice(0, 80))"
    )
    assert wide == []
    assert no_complaints(driver)


@in_browser
def test_the_tabulator_reaches_every_control(opened):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.keys import Keys

    controls = opened.execute_script(
        "return [...document.querySelectorAll('input, select, button, summary, [tabindex]')]"
        ".filter((e) => !e.disabled && e.checkVisibility())"
        ".map((e) => e.id || e.tagName)"
    )
    reached = []
    for _ in range(len(controls) + 3):
        ActionChains(opened).send_keys(Keys.TAB).perform()
        reached.append(
            opened.execute_script(
                "const e = document.activeElement; return [e.id || e.tagName, getComputedStyle(e).outlineStyle]"
            )
        )
    assert len(controls) >= 14
    assert set(controls) <= {name for name, _ in reached}
    assert {outline for name, outline in reached if name in controls} == {"solid"}
    unnamed = opened.execute_script(
        "return [...document.querySelectorAll('input, select')].filter((e) => !e.labels.length && !e.ariaLabel).length"
    )
    assert unnamed == 0


@in_browser
def test_what_is_missing_is_said(driver, tmp_path, result):
    untouched = SMALL.with_changes({"contact.approach": ["0 nm"]})
    last = result.isel(fractal_dimension=[0], amplitude=[0])
    for data, words in (
        (empty_dataset(untouched), ["No pair of this study touches", "No contacts here"]),
        (result.isel(repetition=[0]), ["is unfinished: 1 of 12 repetitions", "there is one repetition"]),
        (last.isel(approach=[-1]), ["one approach", "no value in this range"]),
        (last, ["D = 1.000", "95 % interval"]),
    ):
        save_report(data, tmp_path / "report.html")
        browser.open_page(driver, tmp_path / "report.html")
        text = driver.find_element("tag name", "body").text
        for word in words:
            assert word in text
        assert no_complaints(driver)


# ---- The file --------------------------------------------------------------------------------------------------------


def test_text_of_a_study_is_text_on_the_page(result):
    nasty = study_of(result).to_toml() + "# </script><script>alert(1)</script> <!-- ${packed} &amp;\n"
    page = report_page(result.assign_attrs(study=nasty, stiction_version="<b>"))
    assert "alert(1)</script>" not in page
    assert html.escape(nasty) in page
    assert "stiction &lt;b&gt;" in page


def test_a_page_is_little_more_than_its_numbers(page, result):
    assert page.read_text("utf-8").startswith(MARK)
    assert page.stat().st_size < 300_000 + 10 * len(SMALL.surfaces.amplitudes()) * result["contact_area"].size * 7


def test_what_is_too_large_for_a_page_is_said(monkeypatch, result):
    monkeypatch.setattr("stiction.views.report.study.MOST_MEANS", 79)
    with pytest.raises(ReportError, match="80 pairs times approaches, more than the 79"):
        report_page(result)


@pytest.mark.parametrize("gap", ["repetition", "approach"])
def test_nothing_makes_no_page(result, gap):
    with pytest.raises(ReportError, match=f"nothing along '{gap}'"):
        report_page(result.isel({gap: []}))


@pytest.mark.parametrize("bad", [np.inf, np.nan])
@pytest.mark.parametrize("name", ["normal_elastic", "tangential_adhesive", "amplitude"])
def test_what_is_not_finite_makes_no_page(result, name, bad):
    wrong = result.copy(deep=True)
    if name in wrong.coords:
        wrong = wrong.assign_coords({name: [bad] * wrong.sizes[name]})
    else:
        wrong[name].values[1, 0, 3, 2] = bad
    with pytest.raises(ReportError, match=f"{name} that is not finite"):
        report_page(wrong)


def test_a_part_of_a_result_makes_no_page(result):
    with pytest.raises(ReportError, match="no crossed_count"):
        report_page(result.drop_vars("crossed_count"))


def test_a_page_carries_its_licence(page):
    text = html.unescape(page.read_text("utf-8"))
    for words in ("GNU GENERAL PUBLIC LICENSE", "How to Apply These Terms to Your New Programs", "version 3 or later"):
        assert words in text


def test_many_repetitions_leave_out_their_intervals(monkeypatch, result):
    whole = len(report_page(result))
    monkeypatch.setattr("stiction.views.report.study.MOST_SUMS", 100)
    page = report_page(result)
    assert len(page) < whole - 10_000
    assert '"hasIntervals": false' in page


def test_a_page_is_called_by_its_study_and_says_its_material(result):
    page = report_page(result)
    assert "<title>study – static friction – stiction</title>" in page
    assert "E* = 10 GPa. Contacts that rub: opposing. The upper body moves to +x." in page
    assert "<title>mine – " in report_page(result, names=["mine"])
    quick = empty_dataset(Study.named("quick")).assign_attrs(study=Study.named("quick").to_toml())
    assert "<title>quick – " in report_page(quick)


def test_a_page_is_of_datasets(result):
    for wrong in (None, [result, 3]):
        with pytest.raises(ReportError, match=r"must be an xarray\.Dataset"):
            report_page(wrong)


def test_a_page_has_one_result_or_two(result):
    for count in (0, 3):
        with pytest.raises(ReportError, match=f"one result or two, got {count}"):
            report_page([result] * count)


def test_only_reports_are_replaced(result, tmp_path):
    path = tmp_path / "report.html"
    path.write_text(f"{MARK}old")
    save_report(result, path)
    assert len(path.read_bytes()) > 100_000
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ReportError, match="something else"):  # and does not wait for somebody to write into it
        save_report(result, tmp_path / "pipe")
    (tmp_path / "pipe").unlink()
    other = tmp_path / "thesis.html"
    other.write_text("years of work")
    for bad, reason in (
        (other, "something else"),
        (tmp_path, "something else"),
        (tmp_path / "no/report.html", "No such"),
    ):
        with pytest.raises(ReportError, match=reason):
            save_report(result, bad)
    assert other.read_text() == "years of work"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["report.html", "thesis.html"]


def test_the_command_writes_where_it_says(tmp_path):
    small = SMALL.with_changes({"ensemble.repetitions": 2, "surfaces.amplitude": ["50 nm"]})
    run(small, store=tmp_path / "study/result.zarr")

    def report(*arguments):
        return stiction_command("report", *arguments, cwd=tmp_path)

    done = report("study")
    assert (done.returncode, done.stdout) == (0, f"wrote {os.path.join('study', 'report.html')}\n"), done.stderr
    assert report("study", "-o", "other.html").returncode == 0
    (tmp_path / "mine.txt").write_text("mine")
    shutil.copytree(tmp_path / "study", tmp_path / "damaged")
    (tmp_path / "damaged/result.zarr/zarr.json").write_text("{}")
    for arguments, word in (
        (["nowhere"], "no such directory"),
        (["damaged"], "damaged"),
        (["study", "-o", "mine.txt"], "else"),
    ):
        assert_refused(report(*arguments), word)
    assert store.read(tmp_path / "study/result.zarr").sizes["repetition"] == 2
