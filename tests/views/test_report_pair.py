"""The page of two measured surfaces, held to what `pair` writes."""

import html
import re

import browser
import numpy as np
import pytest
import xarray
from command import assert_refused, stiction_command
from scipy.special import stdtrit
from stiction import pressed_maps, self_affine_surface, write_surface
from stiction.studies.map_pair import FRICTION_SUMS
from stiction.studies.traverse import traverse_mean
from stiction.surfaces.preparation import turned_over
from stiction.views.report import ReportError, report_page, save_report

pytest.importorskip("selenium", reason="selenium is not installed")

in_browser = pytest.mark.skipif(
    not (browser.CHROMIUM and browser.DRIVER), reason="Debian's chromium and chromium-driver are not installed"
)

AGREEMENT = 1e-6

MATERIAL = ("--effective-modulus", "10 GPa", "--mu0", "0.3,0.5", "--tau0", "0 MPa,50 MPa")


def surface(side):
    return self_affine_surface(
        4, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1, shortest_wavelength=0.8, side=side
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory, no_figures):
    """Where maps and lines of them were pressed."""
    folder = tmp_path_factory.mktemp("pair")
    for side in ("lower", "upper"):
        write_surface(surface(side), folder / f"{side}.npy")
    common = ("pair", "upper.npy", "lower.npy", "--unit", "um", "--spacing", "0.1 um", *MATERIAL)
    for options in (
        ("--load", "0.05 mN", "--load", "0.5 mN", "--check", "--shifts", "4", "-o", "maps"),
        ("--load", "10 uN", "--lines", "9", "-o", "lines"),
    ):
        with no_figures():
            done = stiction_command(*common, *options, cwd=folder)
        assert done.returncode == 0, done.stderr
    return folder


def opened_result(folder):
    with xarray.open_dataset(folder / "result.nc", engine="h5netcdf") as kept:
        return kept.load()


@pytest.fixture(scope="module")
def maps(folder):
    return opened_result(folder / "maps")


@pytest.fixture(scope="module")
def lines(folder):
    return opened_result(folder / "lines")


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    with browser.browser(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


@pytest.fixture(scope="module")
def page(maps, folder):
    save_report(maps, folder / "maps.html")
    return folder / "maps.html"


@pytest.fixture
def opened(driver, page):
    browser.open_page(driver, page)
    yield driver
    assert [entry for entry in driver.get_log("browser") if entry["level"] != "INFO"] == []


def by_id(driver, name):
    return driver.find_element("id", name)


def enter(driver, name, value):
    from selenium.webdriver.common.keys import Keys

    by_id(driver, name).send_keys(Keys.CONTROL + "a" + Keys.NULL, str(value))
    browser.settle(driver)


def step_to(driver, name, index):
    """Move a slider by keys, as a person does."""
    from selenium.webdriver.common.keys import Keys

    last = round(float(by_id(driver, name).get_attribute("max")))
    right, left = Keys.HOME + Keys.ARROW_RIGHT * index, Keys.END + Keys.ARROW_LEFT * (last - index)
    by_id(driver, name).send_keys(min(right, left, key=len))
    browser.settle(driver)
    assert by_id(driver, name).get_attribute("value") == str(index)


def answers(driver):
    """Coefficient and interval of each series, and by the slope alone, in full."""
    values = [float(each.get_attribute("value")) for each in driver.find_elements("css selector", "#answer data")]
    return np.array(values).reshape(2, -1)


def mean_over_shifts(values):
    """Mean and half width of the interval by Student's t over the positions that have an answer."""
    count = values.notnull().sum("shift")
    return values.mean("shift"), stdtrit(count - 1, 0.975) * values.std("shift", ddof=1) / np.sqrt(count)


@in_browser
def test_numbers_of_maps_are_those_of_the_result(opened, maps):
    from selenium.webdriver.support.ui import Select

    random = np.random.default_rng(2)
    for _ in range(8):
        names = ("mechanics", "direction", "load", "mu0", "tau0")
        place = {name: int(random.integers(maps.sizes[name])) for name in names}
        at = maps.drop_dims("contact", errors="ignore").isel(place)
        enter(opened, "mu0-number", float(at["mu0"]))
        enter(opened, "tau0-number", 1000 * float(at["tau0"]))
        step_to(opened, "load", place["load"])
        step_to(opened, "direction", place["direction"])
        Select(by_id(opened, "mechanics")).select_by_index(place["mechanics"])
        browser.settle(opened)
        found = answers(opened)
        for rule in (0, 1):
            mean, half = mean_over_shifts(at["friction_coefficient"].isel(sliding=rule))
            expected = [float(mean), max(float(mean - half), 0.0), float(mean + half)]
            assert found[rule, :3] == pytest.approx(expected, rel=AGREEMENT, abs=1e-12)
            alone = float(at["gentle_friction"].isel(sliding=rule).mean("shift"))
            assert found[rule, 3] == pytest.approx(alone, rel=AGREEMENT)
        shown = {
            each.get_attribute("data-name"): float(each.find_element("css selector", "data").get_attribute("value"))
            for each in opened.find_elements("css selector", "#figures dd[data-name]")
        }
        assert {"contact_area_fraction", "contact_count", "normal_stiffness"} <= set(shown)
        for name, value in shown.items():
            assert value == pytest.approx(float(at[name].mean("shift")), rel=AGREEMENT), name


@in_browser
def test_other_materials_are_those_of_the_library(opened):
    upper, lower = turned_over(surface("upper")), surface("lower")
    enter(opened, "mu0-number", 0.17)
    enter(opened, "tau0-number", 23.5)
    load = opened.execute_script("return facts.loads[state.load]")
    wanted = pressed_maps(
        upper, lower, [load], mu0=0.17, tau0=0.0235, directions=[0.0], shifts=4, mechanics="half-space"
    )["friction_coefficient"]  # fmt: skip
    found = answers(opened)
    assert found[:, 0] == pytest.approx(wanted.mean("shift").values.ravel(), rel=AGREEMENT)


@in_browser
def test_the_compass_is_turned_by_mouse_and_keys(opened, maps):
    from selenium.webdriver.common.keys import Keys

    compass = by_id(opened, "compass")
    compass.send_keys(Keys.ARROW_LEFT * 2)
    browser.settle(opened)
    assert opened.execute_script("return facts.directions[state.direction]") == 60
    opened.execute_script("arguments[0].scrollIntoView({block: 'center'})", compass)
    from selenium.webdriver import ActionChains

    ActionChains(opened).move_to_element_with_offset(compass, -40, 2).click().perform()
    browser.settle(opened)
    assert opened.execute_script("return facts.directions[state.direction]") == 180
    assert by_id(opened, "direction-text").text == "−x"
    mean, _ = mean_over_shifts(
        maps["friction_coefficient"].isel(mechanics=0, mu0=0, tau0=0).sel(direction=180.0, sliding="opposing")
    )
    step = opened.execute_script("return state.load")
    assert answers(opened)[0, 0] == pytest.approx(float(mean[step]), rel=AGREEMENT)


@in_browser
def test_contacts_are_those_of_the_result(opened, maps):
    if "contact_x" not in maps:
        pytest.skip("the result has no contacts")
    shift, load = int(maps.attrs["pictured_shift"]), opened.execute_script("return state.load")
    own = maps.isel(
        contact=np.flatnonzero(
            (maps["contact_shift"] == shift) & (maps["contact_load"] == load) & (maps["contact_mechanics"] == 0)
        )
    )
    drawn = opened.execute_script("return document.getElementById('contacts').drawn.contacts")
    assert len(drawn) == own.sizes["contact"] > 3
    order = np.argsort(-own["contact_force"].values, kind="stable")
    for name in ("x", "y", "force"):
        assert [each[name] for each in drawn] == pytest.approx(own[f"contact_{name}"].values[order], rel=1e-5)
    assert [each["opposes"] for each in drawn] == (own["contact_slope_x"].values[order] > 0).tolist()
    assert len(opened.find_elements("css selector", "#contacts svg title")) == len(drawn)


@in_browser
def test_numbers_of_lines_are_those_of_the_result(driver, lines, tmp_path):
    save_report(lines, tmp_path / "lines.html")
    browser.open_page(driver, tmp_path / "lines.html")
    mean = traverse_mean(lines)
    for load in (0, 11):
        step_to(driver, "load", load)
        expected = mean["friction_coefficient"].isel(load=load, mu0=0, tau0=0)
        found = answers(driver)
        assert found[:, 0] == pytest.approx(expected.sel(statistic="mean").values, rel=AGREEMENT)
        assert found[:, 1:] == pytest.approx(expected.sel(statistic=["lower", "upper"]).values, rel=AGREEMENT)


@in_browser
def test_nothing_is_asked_of_anybody_and_a_phone_does_not_scroll(driver, page):
    browser.open_page(driver, page, width=360, height=740)
    enter(driver, "mu0-number", 0.2)
    asked = {url.split("#")[0] for url in browser.requests(driver) if not url.startswith(("data:", "blob:"))}
    assert asked == {page.as_uri()}
    assert driver.execute_script("return [innerWidth, document.documentElement.scrollWidth]") == [360, 360]


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
def test_an_address_is_a_view(driver, page):
    browser.open_page(driver, page)
    enter(driver, "mu0-number", 0.21)
    by_id(driver, "compass").send_keys("\ue012")
    browser.rest(driver)
    address, seen = driver.current_url, by_id(driver, "answer").text
    driver.get("about:blank")
    driver.get(address)
    browser.wait_until_drawn(driver)
    assert by_id(driver, "answer").text == seen
    assert "μ0 = 0.21" in seen


# ---- The file --------------------------------------------------------------------------------------------------------


def test_the_command_makes_the_page_of_a_pair(folder):
    for name in ("maps", "lines"):
        done = stiction_command("report", name, cwd=folder)
        assert (done.returncode, done.stdout) == (0, f"wrote {name}/report.html\n"), done.stderr
        text = (folder / name / "report.html").read_text("utf-8")
        printed = stiction_command("info", name, cwd=folder).stdout
        assert "In short: at" in printed
        assert html.escape(printed).strip() in text
        assert len(text) < 400_000
    assert_refused(stiction_command("report", "maps", "lines", cwd=folder), "a page of a pair has one")


def test_a_truncated_result_gives_one_sentence(folder):
    whole = (folder / "maps/result.nc").read_bytes()
    (folder / "cut").mkdir()
    for part in (0, 100, len(whole) // 2, len(whole) - 100):
        (folder / "cut/result.nc").write_bytes(whole[:part])
        assert_refused(stiction_command("report", "cut", cwd=folder), "result.nc")


@pytest.mark.parametrize("name", [*FRICTION_SUMS, "rms_slope", "nominal_area"])
def test_what_is_missing_is_said(maps, name):
    with pytest.raises(ReportError, match=f"has no {name}"):
        report_page(maps.drop_vars(name))


HOSTILE = [
    "</script><script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "${facts} $style $",
    "<!--<script>",
    "\x1b[31m",
]


def tags(page):
    """Names of its tags, without what is in its scripts."""
    own = re.sub(r'<script type="application/[^>]*>.*?</script>', "", page, flags=re.DOTALL)
    return [tag.split()[0] for tag in re.findall(r"<[a-zA-Z!/][^>]*", own)]


@pytest.fixture(scope="module")
def short_results(maps, lines):
    """Results of few loads, and the tags of their pages."""
    return [(result, tags(report_page(result))) for result in (maps, lines.isel(load=slice(8, 12)))]


@pytest.mark.parametrize("text", HOSTILE)
def test_text_of_a_file_is_text_on_the_page(short_results, text):
    for result, clean in short_results:
        wrong = result.copy()
        wrong.attrs |= dict.fromkeys(("files", "upper", "lower", "law", "stiction_version", text), text)
        for variable in wrong.variables.values():
            variable.attrs |= {"units": text, "long_name": text}
        page = report_page(wrong)
        assert tags(page) == clean
        assert text not in page or html.escape(text) == text
        assert "\x1b" not in page


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0])
@pytest.mark.parametrize("name", ["load", "effective_modulus", "nominal_area"])
def test_what_is_no_number_makes_no_page(maps, name, bad):
    wrong = maps.assign_coords({name: maps[name] * bad})
    with pytest.raises(ReportError, match="that is no number"):
        report_page(wrong)


def test_what_is_too_large_is_said(maps, monkeypatch):
    monkeypatch.setattr("stiction.views.report.pair.MOST_VALUES", 1000)
    with pytest.raises(ReportError, match="more than the 1000"):
        report_page(maps)
