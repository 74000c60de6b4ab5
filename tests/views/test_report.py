import html
import os
import re
import shutil
import sys

import browser
import numpy as np
import pytest
from command import assert_refused, stiction_command
from small import SMALL
from stiction import friction_map, run
from stiction.studies import store
from stiction.studies.dataset import empty_dataset
from stiction.studies.study import study_of
from stiction.views.report import ReportError, report_page, save_report
from stiction.views.report.page import MARK

pytest.importorskip("plotly", reason="the extra 'report' is not installed")
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
    return driver.execute_script("return document.getElementById('map').data.find((trace) => trace.z).z")


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
    from selenium.webdriver import ActionChains

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
        area = opened.find_element("css selector", "#map .nsewdrag")
        opened.execute_script("arguments[0].scrollIntoView({block: 'center'})", area)
        x = area.rect["width"] * ((d + 0.5) / dimensions.size - 0.5)
        y = area.rect["height"] * (0.5 - (row + 0.5) / loads.size)
        actions = ActionChains(opened, duration=20).move_to_element_with_offset(area, round(x), round(y) + 3)
        actions.move_by_offset(0, -3).pause(0.2).perform()
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
    from selenium.webdriver import ActionChains

    area = opened.find_element("css selector", "#map .nsewdrag")
    x, y = round(-0.375 * area.rect["width"]), round(0.2 * area.rect["height"])
    ActionChains(opened).move_to_element_with_offset(area, x, y).click().perform()
    ActionChains(opened).move_to_element(by_id(opened, "area-title")).perform()
    browser.settle(opened)
    assert by_id(opened, "readout").text.startswith("Picked: D = 1.000")
    assert by_id(opened, "dimension").get_attribute("value") == "0"


@in_browser
def test_a_tap_takes_the_place_of_the_pointer(opened):
    area = opened.find_element("css selector", "#map .nsewdrag")
    opened.execute_script("arguments[0].scrollIntoView({block: 'center'})", area)
    left, top, width, height = opened.execute_script(
        "const r = arguments[0].getBoundingClientRect(); return [r.left, r.top, r.width, r.height]", area
    )
    for d in (0, 2):  # of four; the finger does not leave as a pointer does
        at = {"x": left + width * (d + 0.5) / 4, "y": top + 0.7 * height}
        opened.execute_cdp_cmd("Input.synthesizeTapGesture", at)
        browser.settle(opened)
        assert float(by_id(opened, "readout").get_attribute("data-dimension")) == pytest.approx(1 + 0.2 * d)
        assert by_id(opened, "dimension").get_attribute("value") == str(d)


@in_browser
def test_a_map_without_values_says_why(opened):
    from selenium.webdriver import ActionChains

    enter(opened, "load-high", 1000)
    enter(opened, "load-low", 500)
    area = opened.find_element("css selector", "#map .nsewdrag")
    opened.execute_script("arguments[0].scrollIntoView({block: 'center'})", area)
    x = round(0.375 * area.rect["width"])
    actions = ActionChains(opened, duration=20).move_to_element_with_offset(area, x, 3).move_by_offset(0, -3)
    actions.pause(0.2).perform()
    browser.settle(opened)
    assert by_id(opened, "readout").text.startswith("Under the pointer: D = 1.600")
    assert shown_in_full(opened) == ("not-reached", None)


@in_browser
def test_a_band_that_is_cut_off_is_said_to_be(driver, tmp_path, result):
    for data, is_cut in ((result.isel(repetition=[0, 1]), True), (result, False)):
        save_report(data, tmp_path / "report.html")
        browser.open_page(driver, tmp_path / "report.html")
        highest, top = driver.execute_script(
            "const {data, layout} = document.getElementById('friction');"
            "return [Math.max(...data[0].y), layout.yaxis.range[1]]"
        )
        assert highest <= top
        assert (highest == top) == is_cut
        assert ("cut off above" in by_id(driver, "friction-caption").text) == is_cut


@in_browser
@pytest.mark.parametrize("name", ["friction", "area"])
def test_curves_are_drawn_of_what_is_computed(opened, name):
    enter(opened, "mu0-number", 0.37)
    enter(opened, "tau0-number", 41)
    points, curve, band, loads = opened.execute_script(
        "const [band, curve] = document.getElementById(arguments[0]).data;"
        "const points = CURVES[arguments[0]].at(result, state.dimension, state.amplitude, loads, 0.37, 0.041);"
        "return [points, curve.y, band.y, curve.x]", name
    )  # fmt: skip
    assert loads == [point["load"] for point in points]
    assert curve == [point["value"] for point in points]
    assert sum(value is not None for value in curve) > 20
    banded = [point for point in points if point["lower"] is not None]
    ends = np.array([point["lower"] for point in banded] + [point["upper"] for point in reversed(banded)])
    drawn = np.array(band)
    # The band is cut where it leaves the axis; most of it does not.
    inside = (drawn > drawn.min() * (1 + 1e-9)) & (drawn < drawn.max() * (1 - 1e-9))
    assert inside.mean() > 0.5
    assert np.array_equal(drawn[inside], ends[inside])


@in_browser
@pytest.mark.parametrize(("name", "unit"), [("mu0", 0.01), ("tau0", 1.0)])
def test_a_key_on_a_slider_changes_map_curves_and_panel(opened, name, unit):
    from selenium.webdriver.common.keys import Keys

    def drawn():
        curves = opened.execute_script("return ['friction', 'area'].map((id) => document.getElementById(id).data[1].y)")
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
    assert opened.execute_script("return document.getElementById('map').data.find((t) => t.z).zmax") == pytest.approx(
        np.log10(2)
    )
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
    upper = np.array(opened.execute_script("return document.getElementById('profiles').data[3].y"))
    by_id(opened, "approach").send_keys(Keys.END)
    browser.settle(opened)
    nearer = np.array(opened.execute_script("return document.getElementById('profiles').data[3].y"))
    approaches = SMALL.contact.approaches()
    assert upper - nearer == pytest.approx(1000 * (approaches[-1] - approaches[0]))
    assert re.search(r"\d+ contacts? here", by_id(opened, "profiles-caption").text)


@in_browser
def test_nothing_is_asked_of_anybody(driver, page):
    browser.open_page(driver, page)
    by_id(driver, "mu0").send_keys("5")
    enter(driver, "tau0-number", 50)
    asked = [url for url in browser.requests(driver) if not url.startswith(("data:", "blob:"))]
    assert asked == [page.as_uri()]


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
        "return [...document.querySelectorAll('input, select, button, summary')].filter((e) => !e.disabled)"
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
        (result.isel(repetition=[0]), ["Unfinished: 1 of 12 repetitions", "there is one repetition"]),
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


def test_a_page_is_little_more_than_its_library(page, result):
    assert page.read_text("utf-8").startswith(MARK)
    assert page.stat().st_size < 2_600_000 + 10 * len(SMALL.surfaces.amplitudes()) * result["contact_area"].size * 7


def test_what_is_too_large_for_a_page_is_said(monkeypatch, result):
    monkeypatch.setattr("stiction.views.report.page.MOST_MEANS", 79)
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


def test_a_page_carries_the_licences_of_what_is_in_it(page):
    text = html.unescape(page.read_text("utf-8"))
    for words in (
        "Copyright 2012", "Plotly, Inc.", "Permission is hereby granted, free of charge", "MapLibre GL JS",
        "GNU GENERAL PUBLIC LICENSE", "How to Apply These Terms to Your New Programs", "version 3 or later",
    ):  # fmt: skip
        assert words in text


def test_many_repetitions_leave_out_their_intervals(monkeypatch, result):
    whole = len(report_page(result))
    monkeypatch.setattr("stiction.views.report.page.MOST_SUMS", 100)
    page = report_page(result)
    assert len(page) < whole - 10_000
    assert '"hasIntervals": false' in page


def test_without_plotly_it_says_what_to_install(monkeypatch, result):
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    with pytest.raises(ReportError, match=r"pip install 'stiction\[report\]'"):
        report_page(result)


def test_only_reports_are_replaced(result, tmp_path):
    path = tmp_path / "report.html"
    path.write_text(f"{MARK}old")
    save_report(result, path)
    assert len(path.read_bytes()) > 1_000_000
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
        (["nowhere"], "not a result"),
        (["damaged"], "damaged"),
        (["study", "-o", "mine.txt"], "else"),
    ):
        assert_refused(report(*arguments), word)
    assert store.read(tmp_path / "study/result.zarr").sizes["repetition"] == 2
