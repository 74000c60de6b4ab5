"""Tests of reports in a browser: of results of generated and of measured surfaces, and of scans."""

import csv
import time
import xml.etree.ElementTree

import numpy as np
import pytest
from stiction import Result, friction_map, levelled, self_affine, self_affine_surface
from stiction.companions.contact_picture import contact_picture
from stiction.evaluate.at_load import at_load
from stiction.study.study import parse_study_of_dataset
from stiction.summary.characterisation import Characterisation
from stiction.summary.input_caveats import find_input_caveats
from stiction.summary.summary import summarize
from stiction.views.characterisation import CharacterisationTable
from stiction.views.report import report_page, save_report
from stiction.views.report.surface import surface_page
from support import browser
from support.generated_studies import SMALL_STUDY, empty_dataset

pytest.importorskip("selenium", reason="selenium is not installed")
pytestmark = browser.BROWSER_MARKS

MAX_PACKING_ERROR = 1e-6
CONTROL_KEY_BIT, SHIFT_KEY_BIT = 2, 8  # bits of modifier keys in the browser's debugging protocol
SCAN_OPTIONS = {"name": "scan.csv", "command": "stiction characterise scan.csv"}
FILE_READING_TABLE = '<table class="texts"><caption>How scan.csv was read</caption><tr><td>64 points</td></tr></table>'


@pytest.fixture(scope="module")
def profile():
    tilted_profile = self_affine(1, hurst_exponent=0.7, rms=0.05, points=6001, spacing=0.01)
    return levelled(tilted_profile, "line")


@pytest.fixture(scope="module")
def surface():
    tilted_surface = self_affine_surface(1, hurst_exponent=0.7, rms=0.05, shape=(60, 90), spacing=0.1)
    return levelled(tilted_surface, "plane")


@pytest.fixture(scope="module")
def pages(
    generated_dataset,
    maps_dataset,
    dataset_with_interface_for_opposing_contacts,
    profiles_dataset,
    profile,
    surface,
    tmp_path_factory,
):
    directory = tmp_path_factory.mktemp("pages")
    texts = {
        "study": report_page(generated_dataset),
        "maps": report_page(maps_dataset, picture=contact_picture(maps_dataset)),
        "interface": report_page(dataset_with_interface_for_opposing_contacts),
        "lines": report_page(profiles_dataset, picture=contact_picture(profiles_dataset)),
        "profile": surface_page(profile, **SCAN_OPTIONS).html(),
        "file": surface_page(profile, **SCAN_OPTIONS, reading=FILE_READING_TABLE).html(),
        "surface": surface_page(surface, **SCAN_OPTIONS).html(),
    }
    for name, text in texts.items():
        (directory / f"{name}.html").write_text(text, encoding="utf-8")
    return {name: directory / f"{name}.html" for name in texts}


PLOTS_WITH_AXES = {
    "study": {"map", "over", "friction", "area", "stiffness"},
    "maps": {"friction", "area", "stiffness"},
    "lines": {"friction", "area", "stiffness"},
}
"""Zoomable plots of each report. The compass is not zoomable, because it shows all angles and starts at zero."""


@pytest.fixture
def generated_report(driver, pages):
    """Browser with the report of the generated profiles; after the test the browser log must be empty."""
    browser.open_page(driver, pages["study"])
    yield driver
    assert log_is_empty(driver)


@pytest.fixture
def maps_report(driver, pages):
    """Browser with the report of two maps; after the test the browser log must be empty."""
    browser.open_page(driver, pages["maps"])
    yield driver
    assert log_is_empty(driver)


def log_is_empty(driver):
    messages = [entry for entry in driver.get_log("browser") if entry["level"] != "INFO"]
    assert messages == []
    return True


def find_element(driver, name):
    return driver.find_element("id", name)


def move_slider(driver, name, position):
    """Move the slider of mu0 or tau0 to a position, and return the value that the page shows beside it."""
    driver.execute_script(
        "const slider = document.getElementById(arguments[0]); slider.value = arguments[1];"
        "slider.dispatchEvent(new Event('input'))", name, position
    )  # fmt: skip
    browser.wait_for_drawing(driver)
    return driver.execute_script("return state[arguments[0]]", name)


def create_pointer_actions(driver, x, y):
    """Return a chain of actions that starts with a move of the pointer to a point."""
    from selenium.webdriver import ActionChains

    actions = ActionChains(driver, duration=20)
    actions.w3c_actions.pointer_action.move_to_location(round(x), round(y) + 3)
    actions.w3c_actions.pointer_action.move_to_location(round(x), round(y))
    return actions


def read_readout(driver):
    """Return the status of the displayed value, the value, and the limits of its interval."""
    generated_dataset = driver.execute_script("return {...document.getElementById('readout').dataset}")
    return generated_dataset["status"], [float(generated_dataset[name]) for name in ("value", "lower", "upper")]


def read_selection(driver):
    return driver.execute_script("return [state.dimension, state.load]")


def double_click(driver, x, y):
    """Double-click at a position, with a pause between the clicks as on a page that handles clicks slowly."""
    for count in (1, 2):
        for kind in ("mousePressed", "mouseReleased"):
            driver.execute_cdp_cmd(
                "Input.dispatchMouseEvent", {"type": kind, "x": x, "y": y, "button": "left", "clickCount": count}
            )
        time.sleep(0.6)


def read_axis_limits(driver, name="map"):
    """Return the current limits of the axes of a plot."""
    return driver.execute_script(
        "const {x, y} = document.getElementById(arguments[0]).axes; return [x.low, x.high, y.low, y.high]", name
    )


def compute_scaled_axis_limits(driver, plot):
    """Return the current limits of both axes of a plot, as logarithms for a logarithmic axis."""
    return np.reshape(
        driver.execute_script(
            "const {x, y} = document.getElementById(arguments[0]).axes;"
            "return [x, y].flatMap(({low, high, isLog}) => [low, high].map((v) => (isLog ? Math.log(v) : v)))", plot
        ), (2, 2)
    )  # fmt: skip


def send_mouse_event(driver, kind, x, y, *, modifiers=0, **options):
    event = {"type": kind, "x": x, "y": y, "modifiers": modifiers, "pointerType": "mouse", **options}
    driver.execute_cdp_cmd("Input.dispatchMouseEvent", event)


def send_touch_event(driver, kind, *points):
    touch_points = [{"x": x, "y": y, "id": index} for index, (x, y) in enumerate(points)]
    driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touch_points})


def zoom_by_wheel(driver, plot):
    """Turn the mouse wheel with Ctrl at a quarter of a plot's width and height from its lower left corner."""
    left, top, width, height = browser.find_axes_frame(driver, plot)
    send_mouse_event(
        driver, "mouseWheel", left + width / 4, top + 3 * height / 4, modifiers=CONTROL_KEY_BIT, deltaX=0, deltaY=-200
    )
    browser.wait_for(
        driver, lambda driver: driver.execute_script(f"return document.getElementById('{plot}').view != null")
    )
    browser.wait_for_drawing(driver)


@pytest.mark.parametrize(
    ("page_name", "plot"), [(page_name, plot) for page_name, plots in PLOTS_WITH_AXES.items() for plot in sorted(plots)]
)
def test_plot_can_be_zoomed_and_panned_by_mouse_keyboard_and_touch(driver, pages, page_name, plot):
    from selenium.webdriver.common.keys import Keys

    browser.open_page(driver, pages[page_name])
    browser.open_more_section(driver)
    initial_limits = compute_scaled_axis_limits(driver, plot)
    span = initial_limits[:, 1] - initial_limits[:, 0]
    zoom_by_wheel(driver, plot)
    zoomed_limits = compute_scaled_axis_limits(driver, plot)
    ratio = (zoomed_limits[:, 1] - zoomed_limits[:, 0]) / span
    assert ratio == pytest.approx(np.exp(-200 / 300), rel=1e-6)
    assert zoomed_limits[:, 0] + (zoomed_limits[:, 1] - zoomed_limits[:, 0]) / 4 == pytest.approx(
        initial_limits[:, 0] + span / 4, abs=0.01 * span.max()
    )
    left, top, width, height = browser.find_axes_frame(driver, plot)
    start = (left + width / 2, top + height / 2)
    send_mouse_event(driver, "mousePressed", *start, modifiers=SHIFT_KEY_BIT, button="left", clickCount=1)
    for fraction in (0.05, 0.1):
        end = start[0] + fraction * width, start[1] - fraction * height
        send_mouse_event(driver, "mouseMoved", *end, modifiers=SHIFT_KEY_BIT, button="left", buttons=1)
    send_mouse_event(driver, "mouseReleased", *end, modifiers=SHIFT_KEY_BIT, button="left", clickCount=1)
    browser.wait_for_drawing(driver)
    panned_limits = compute_scaled_axis_limits(driver, plot)
    assert (panned_limits - zoomed_limits)[0] == pytest.approx(-0.1 * ratio[0] * span[0], rel=0.05)
    assert (panned_limits - zoomed_limits)[1] == pytest.approx(-0.1 * ratio[1] * span[1], rel=0.05)
    browser.press_keys(driver, plot, Keys.SHIFT + Keys.ARROW_RIGHT + Keys.NULL)
    assert (compute_scaled_axis_limits(driver, plot) - panned_limits)[0] == pytest.approx(
        0.2 * ratio[0] * span[0], rel=0.05
    )
    browser.press_keys(driver, plot, "0")
    assert compute_scaled_axis_limits(driver, plot) == pytest.approx(initial_limits)
    browser.press_keys(driver, plot, "+")
    assert np.diff(compute_scaled_axis_limits(driver, plot)).ravel() == pytest.approx(span / 1.5)
    browser.press_keys(driver, plot, "-")
    assert compute_scaled_axis_limits(driver, plot) == pytest.approx(initial_limits)
    driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True, "maxTouchPoints": 2})
    left, top, width, height = browser.find_axes_frame(driver, plot)
    for event_type, distance_factor in (("touchStart", 1), ("touchMove", 1.5), ("touchMove", 2)):
        x = [left + width * (0.5 + 0.1 * direction * distance_factor) for direction in (-1, 1)]
        send_touch_event(driver, event_type, *((position, top + height / 2) for position in x))
    send_touch_event(driver, "touchEnd")
    browser.wait_for_drawing(driver)
    driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": False})
    zoomed_limits = compute_scaled_axis_limits(driver, plot)
    assert np.diff(zoomed_limits).ravel() == pytest.approx(span / 2, rel=0.05)
    assert zoomed_limits.mean(axis=1) == pytest.approx(initial_limits.mean(axis=1), abs=0.02 * span.max())
    assert log_is_empty(driver)


def test_report_of_a_scan_has_a_table_and_a_small_slope_estimate(driver, pages, profile):
    browser.open_page(driver, pages["profile"])
    table = driver.execute_script(
        "return [...document.querySelectorAll('tr')].map((row) => [...row.cells].map((cell) => cell.innerText))"
    )
    characterisation = Characterisation(profile)
    expected_rows = [(row.label, row.texts[0]) for row in CharacterisationTable(characterisation).rows if row.label]
    assert [name for name, *_ in table] == [name for name, _ in expected_rows]
    assert dict(table)["Pq"] == dict(expected_rows)["Pq"]
    text = driver.find_element("id", "main").text
    assert f"μₛ = {characterisation.friction_estimates[0]:.2f}" in text
    assert SCAN_OPTIONS["command"] in text


# ---- Generated profiles ---------------------------------------------------------------------------------------------


def test_numbers_shown_at_the_mouse_pointer_equal_library_values(generated_report, generated_dataset):
    random = np.random.default_rng(5)
    dimensions, loads = (
        generated_dataset["fractal_dimension"].values,
        np.array(generated_report.execute_script("return loads")),
    )
    statuses = set()
    num_values = generated_report.execute_script("return [parameters.mu0.values.length, parameters.tau0.values.length]")
    for _ in range(10):
        mu0, tau0 = (
            move_slider(generated_report, name, int(random.integers(count)))
            for name, count in zip(("mu0", "tau0"), num_values, strict=True)
        )
        dimension_index, load_index = random.integers(dimensions.size), random.integers(loads.size // 4, loads.size)
        # Cells have equal sizes: fractal dimensions have equal steps, and loads have equal ratios.
        left, top, width, height = browser.find_axes_frame(generated_report, "map")
        x, y = (
            left + width * (dimension_index + 0.5) / dimensions.size,
            top + height * (1 - (load_index + 0.5) / loads.size),
        )
        create_pointer_actions(generated_report, x, y).pause(0.2).perform()
        browser.wait_for_drawing(generated_report)
        reference = friction_map(generated_dataset, [loads[load_index]], mu0=[mu0], tau0=[tau0 / 1000])
        reference = reference.isel(fractal_dimension=dimension_index, amplitude=0, load=0, mu0=0, tau0=0)
        status, values = read_readout(generated_report)
        statuses.add(status)
        assert status == str(reference["status"].values)
        if status == "ok":
            expected = [float(reference[name]) for name in ("friction_coefficient", "lower", "upper")]
            np.testing.assert_allclose(values, expected, rtol=MAX_PACKING_ERROR, atol=1e-12)
    assert len(statuses) > 1


def test_click_selects_a_cell_of_the_friction_map_and_double_click_resets_the_zoom(generated_report):
    initial_limits = read_axis_limits(generated_report)
    left, top, width, height = browser.find_axes_frame(generated_report, "map")
    create_pointer_actions(generated_report, left + 0.125 * width, top + 0.7 * height).click().perform()
    browser.wait_for_drawing(generated_report)
    selection = read_selection(generated_report)
    assert selection[0] == 0
    browser.press_keys(generated_report, "map", "+")
    assert read_axis_limits(generated_report) != initial_limits
    left, top, width, height = browser.find_axes_frame(generated_report, "map")
    double_click(generated_report, left + 0.8 * width, top + 0.4 * height)
    browser.wait_for_drawing(generated_report)
    assert read_selection(generated_report) == selection
    assert read_axis_limits(generated_report) == pytest.approx(initial_limits)


def test_dragging_a_rectangle_and_clicking_zoom_buttons_change_the_zoom(generated_report):
    initial_limits = read_axis_limits(generated_report)
    left, top, width, height = browser.find_axes_frame(generated_report, "map")
    actions = create_pointer_actions(generated_report, left + 0.3 * width, top + 0.3 * height)
    actions.click_and_hold()
    for fraction in (0.5, 0.7):
        actions.w3c_actions.pointer_action.move_to_location(
            round(left + fraction * width), round(top + fraction * height)
        )
    actions.release().perform()
    browser.wait_for_drawing(generated_report)
    zoomed_limits = read_axis_limits(generated_report)
    assert zoomed_limits[:2] == pytest.approx(
        [initial_limits[0] + fraction * (initial_limits[1] - initial_limits[0]) for fraction in (0.3, 0.7)], rel=0.02
    )
    ratio = initial_limits[3] / initial_limits[2]
    assert zoomed_limits[2:] == pytest.approx([initial_limits[2] * ratio**fraction for fraction in (0.3, 0.7)], rel=0.1)
    zoom_in_button, _, reset_button = generated_report.find_elements("css selector", "#friction + .saves button")[:3]
    limits_before = read_axis_limits(generated_report, "friction")
    zoom_in_button.click()
    browser.wait_for_drawing(generated_report)
    limits_after = read_axis_limits(generated_report, "friction")
    assert limits_before[0] < limits_after[0] < limits_after[1] < limits_before[1]
    reset_button.click()
    browser.wait_for_drawing(generated_report)
    assert read_axis_limits(generated_report, "friction") == pytest.approx(limits_before)


def test_arrow_keys_move_the_selected_cell_of_the_friction_map(generated_report):
    from selenium.webdriver.common.keys import Keys

    generated_report.execute_script("pick(2, 20)")
    browser.wait_for_drawing(generated_report)
    dimension_index, load_index = read_selection(generated_report)
    browser.press_keys(generated_report, "map", Keys.ARROW_RIGHT + Keys.ARROW_UP * 3 + Keys.ARROW_LEFT * 2)
    assert read_selection(generated_report) == [dimension_index - 1, load_index + 3]
    browser.press_keys(generated_report, "area", Keys.ARROW_LEFT * 2)
    assert read_selection(generated_report) == [dimension_index - 1, load_index + 1]
    browser.press_keys(generated_report, "over", Keys.ARROW_RIGHT)
    assert read_selection(generated_report) == [dimension_index, load_index + 1]
    browser.press_keys(generated_report, "mu0", Keys.ARROW_RIGHT * 2)
    assert find_element(generated_report, "mu0-text").text == "0.8"
    assert generated_report.execute_script("return state.mu0") == 0.8


def test_friction_map_cells_beyond_the_range_of_the_model_are_hatched(generated_report):
    assert generated_report.find_elements("css selector", "dd.beyond") == []
    assert find_element(generated_report, "readout").get_attribute("data-status") == "ok"
    hatched_paths, coloured_paths = generated_report.execute_script(
        "const paths = [...document.querySelectorAll('#map path')];"
        "const of = (test) => paths.filter((each) => test(each.getAttribute('fill') ?? ''))"
        ".map((each) => each.getAttribute('d')).join('');"
        "return [of((fill) => fill.includes('beyond')), of((fill) => fill.startsWith('rgb'))]"
    )
    cells = [f"M{path}" for path in hatched_paths.split("M") if path]
    assert cells
    assert all(cell in coloured_paths for cell in cells)
    assert generated_report.execute_script("return document.querySelectorAll('#map [style*=fill-opacity]').length") == 0


def test_address_of_a_report_restores_the_selected_settings(driver, pages):
    browser.open_page(driver, pages["study"])
    mu0, tau0 = move_slider(driver, "mu0", 1), move_slider(driver, "tau0", 1)
    browser.press_keys(driver, "map", "\ue012\ue013\ue013")
    browser.wait_until_idle(driver)
    address, answer_text = driver.current_url, find_element(driver, "answer").text
    assert f"mu0={mu0}" in address
    driver.get("about:blank")
    driver.get(address)
    browser.wait_until_page_is_drawn(driver)
    assert find_element(driver, "answer").text == answer_text
    assert driver.execute_script("return [state.mu0, state.tau0]") == [mu0, tau0]
    driver.get("about:blank")
    driver.get(pages["study"].as_uri() + "#mu0=-3&tau0=NaN&load=x&d=&way=7&rule=%00&pair=<b>")
    browser.wait_until_page_is_drawn(driver)
    assert driver.execute_script("return [state.mu0, state.tau0, state.way, state.rule]") == [0.4, 0, 0, 0]
    assert log_is_empty(driver)


def test_figures_and_tables_are_saved_as_svg_or_png_or_csv_files(driver, pages, tmp_path):
    driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    browser.open_page(driver, pages["study"])
    for name in ("map", "friction"):
        for button in driver.find_elements("css selector", f"#{name} + .saves button"):
            if button.text not in ("SVG", "PNG", "CSV"):
                continue
            driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", button)
            file = tmp_path / f"study_{name}.{button.text.lower()}"
            button.click()
            browser.wait_for(
                driver, lambda _, file=file: file.exists()
            )  # Wait between downloads, because browsers block many simultaneous downloads.
    text = (tmp_path / "study_friction.svg").read_text("utf-8")
    assert "var(" not in text
    svg_text = " ".join(xml.etree.ElementTree.fromstring(text).itertext())
    assert "study: Friction coefficient against normal load" in svg_text
    for expected_text in ("μ0 = 0.4", "τ0 = 0 MPa", "D = ", "95 % interval", "View: #mu0=0.4"):
        assert expected_text in svg_text
    assert (tmp_path / "study_map.png").read_bytes().startswith(b"\x89PNG")
    with (tmp_path / "study_friction.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    points = driver.execute_script("return document.getElementById('friction').drawn.series[0].points")
    values = [point["value"] for point in points if point["value"] is not None]
    assert len(rows) == 40
    assert [float(row["mu_s"]) for row in rows if row["mu_s"]] == values


def test_report_map_shows_the_selected_quantity_and_amplitude(generated_report):
    from selenium.webdriver.support.ui import Select

    def read_map():
        browser.wait_until_idle(generated_report)
        return generated_report.execute_script("return document.getElementById('map').innerHTML")

    maps = [read_map()]
    for quantity in ("width", "area", "stiffness", "friction"):
        Select(find_element(generated_report, "quantity")).select_by_value(quantity)
        maps.append(read_map())
    assert len(set(maps)) == 4
    Select(find_element(generated_report, "amplitude")).select_by_visible_text("100 nm")
    assert read_map() not in maps


def test_report_states_why_values_are_missing(driver, tmp_path, generated_dataset):
    dataset_without_solution = generated_dataset.copy(deep=True)
    dataset_without_solution["normal_elastic"].values[0, 0, 3, 2] = np.nan
    for dataset, expected_words in (
        (empty_dataset(SMALL_STUDY.with_changes({"contact.approach": ["0 nm"]})), ["No pair of this study touches"]),
        (generated_dataset.isel(repetition=[0]), ["is unfinished: 1 of 12 repetitions", "there is one repetition"]),
        (
            generated_dataset.isel(fractal_dimension=[0], amplitude=[0], approach=[-1]),
            ["a single approach", "no value in this range"],
        ),
        (dataset_without_solution, ["1 repetition without a solution"]),
    ):
        save_report(dataset, tmp_path / "report.html")
        browser.open_page(driver, tmp_path / "report.html")
        text = driver.find_element("tag name", "body").text
        for expected_word in expected_words:
            assert expected_word in text
        assert log_is_empty(driver)


# ---- Measured surfaces ----------------------------------------------------------------------------------------------


def read_values_by_rule(driver):
    """Return the displayed coefficient of each sliding rule."""
    values = driver.find_elements("css selector", "#answer .value")
    return {
        value.get_attribute("data-rule"): float(value.find_element("tag name", "data").get_attribute("value"))
        for value in values
    }


def test_friction_displayed_for_maps_equals_library_values_after_controls_are_changed(maps_report, maps_dataset):
    from selenium.webdriver.support.ui import Select

    study = parse_study_of_dataset(maps_dataset)
    surfaces = [getattr(study.surfaces, side).read() for side in ("upper", "lower")]
    input_caveats = find_input_caveats(*surfaces, study, [0.1, 0.5])
    point = summarize(at_load(maps_dataset, [0.1]), study, input_caveats=input_caveats).points[0]
    assert maps_report.find_element("css selector", ".assessment").text == point.assessment
    caveats = maps_report.find_element("css selector", "#judgement").get_attribute("textContent")
    assert all(caveat.text[1:] in caveats for caveat in point.caveats)
    for mu0_index, tau0_index, load_index, direction_index in ((3, 0, 1, 0), (6, 2, 2, 3), (1, 0, 0, 1)):
        mu0, tau0 = move_slider(maps_report, "mu0", mu0_index), move_slider(maps_report, "tau0", tau0_index) / 1000
        Select(find_element(maps_report, "way")).select_by_index(direction_index)
        maps_report.execute_script("pick(0, arguments[0])", load_index)
        browser.wait_for_drawing(maps_report)
        reference = at_load(maps_dataset, maps_dataset["load"].values[[load_index]], mu0=[mu0], tau0=[tau0])
        name = "mean_friction" if direction_index == 0 else "friction_coefficient"
        reference = reference[name].isel(cut_off=0, load=0, mu0=0, tau0=0).sel(statistic="mean")
        reference = reference if direction_index == 0 else reference.isel(direction=direction_index - 1)
        expected = {rule: float(reference.sel(sliding=rule)) for rule in ("all", "opposing")}
        assert read_values_by_rule(maps_report) == pytest.approx(expected, rel=1e-4)
    # A report contains assessments only for the loads, mu0 and tau0 of the study. The button returns to these values.
    maps_report.find_element("css selector", "#judgement button").click()
    browser.wait_for_drawing(maps_report)
    assert maps_report.find_element("css selector", ".assessment").text == point.assessment


def test_report_shows_the_coefficient_for_the_sliding_rule_of_the_interface_first(
    driver, pages, dataset_with_interface_for_opposing_contacts
):
    browser.open_page(driver, pages["interface"])
    displayed_values = read_values_by_rule(driver)
    expected = {
        rule.rule: rule.value for rule in Result(dataset_with_interface_for_opposing_contacts).summary().first.rules
    }
    assert list(displayed_values) == list(expected) == ["opposing", "all"]
    assert displayed_values == pytest.approx(expected, rel=1e-4)
    assert "belong to friction at opposing contacts only" in find_element(driver, "answer").text
    driver.execute_script("for (const point of facts.points) point.most = 'With more positions.'; showReadout()")
    texts = [paragraph.text for paragraph in driver.find_elements("css selector", "#answer p")]
    second_coefficient = texts.index("friction at all contacts")
    assert "With more positions." in texts[:second_coefficient]
    assert not driver.find_elements("css selector", "#answer svg.bar")
    assert log_is_empty(driver)


def test_arrow_key_on_the_compass_changes_the_direction_and_tooltip_shows_numbers(maps_report):
    from selenium.webdriver.common.keys import Keys

    for expected_text in ("to +x", "to +y"):
        browser.press_keys(maps_report, "compass", Keys.ARROW_UP)
        assert expected_text in find_element(maps_report, "answer").text
    left, top, width, height = browser.find_axes_frame(maps_report, "friction")
    create_pointer_actions(maps_report, left + 0.5 * width, top + 0.5 * height).perform()
    browser.wait_for_drawing(maps_report)
    expected_text = maps_report.find_element("css selector", "#friction .tip").text
    assert "friction at all contacts" in expected_text
    assert "mN" in expected_text


# ---- All reports ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_report_is_accessible_and_sends_no_requests(driver, pages, scheme):
    axe = browser.load_axe_script()
    media_options = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", media_options)
    for page_name, path in pages.items():
        browser.open_page(driver, path)
        if page_name in PLOTS_WITH_AXES:
            move_slider(driver, "tau0", 1)
            browser.open_more_section(driver)
        assert browser.find_accessibility_violations(driver, axe) == []
        assert browser.find_foreign_requests(driver, path) == set()
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def test_printed_report_contains_complete_figures_and_parameters(driver, pages):
    paper_width = 720
    for path in (pages["study"], pages["maps"]):
        browser.open_page(driver, path, width=1280)
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        metrics = {"width": paper_width, "height": 1000, "deviceScaleFactor": 1, "mobile": False}
        plot_widths = driver.execute_script(
            "return [...document.querySelectorAll('.plot svg')].map((each) => each.clientWidth)"
        )
        # Figures are not drawn again for printing: they are scaled, and no part may be cropped.
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        cropped_plots = driver.execute_script(
            "return [...document.querySelectorAll('.plot svg')].filter((each) => each.checkVisibility()).filter("
            "(each) => { const {width, height, right} = each.getBoundingClientRect();"
            " const [, , w, h] = each.getAttribute('viewBox').split(' ');"
            " return right > innerWidth + 1 || Math.abs(height / width - h / w) > 0.02 ||"
            "  each.parentNode.getBoundingClientRect().height < height - 1; }).map((each) => each.parentNode.id)"
        )
        assert plot_widths
        assert cropped_plots == []
        assert driver.execute_script("return document.documentElement.scrollWidth") <= paper_width
        assert find_element(driver, "parameters").is_displayed()
        assert "μ0 = " in find_element(driver, "parameters").text
        num_visible_controls = driver.execute_script(
            "return [...document.querySelectorAll('form, button, input, select')]"
            ".filter((each) => each.checkVisibility()).length"
        )
        assert num_visible_controls == 0
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


def test_report_is_readable_at_double_font_size_and_on_a_phone(driver, pages):
    for page_name, path in pages.items():
        browser.open_page(driver, path, width=360, height=740)
        assert driver.execute_script("return [innerWidth, document.documentElement.scrollWidth]") == [360, 360]
        if page_name not in PLOTS_WITH_AXES:
            continue
        browser.open_page(driver, path, width=1280)
        font_size_script = "return parseFloat(getComputedStyle(document.querySelector('#friction text')).fontSize)"
        font_size = driver.execute_script(font_size_script)
        driver.execute_script("document.documentElement.style.fontSize = '200%'; dispatchEvent(new Event('resize'))")
        browser.wait_for_drawing(driver)
        assert driver.execute_script(font_size_script) == pytest.approx(2 * font_size)
        assert driver.execute_script("return document.documentElement.scrollWidth") <= 1280


def test_labels_of_the_compass_figure_do_not_overlap_on_a_phone(driver, pages):
    browser.open_page(driver, pages["maps"], width=360, height=740)
    overlapping_texts = driver.execute_script(
        "const texts = [...document.querySelectorAll('#compass text')]"
        ".map((each) => [each.textContent, each.getBoundingClientRect()]);"
        "return texts.flatMap(([name, a], i) => texts.slice(i + 1).filter(([, b]) => a.left < b.right"
        " && b.left < a.right && a.top < b.bottom && b.top < a.bottom).map(([other]) => [name, other]))"
    )
    assert overlapping_texts == []


def test_tab_key_reaches_every_control_of_a_report(generated_report):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.keys import Keys

    controls = generated_report.execute_script(
        "return [...document.querySelectorAll('input, select, button, summary, [tabindex]')]"
        ".filter((e) => !e.disabled && e.checkVisibility()).map((e) => e.id || e.tagName)"
    )
    reached_controls = set()
    for _ in range(len(controls) + 3):
        ActionChains(generated_report).send_keys(Keys.TAB).perform()
        reached_controls.add(
            generated_report.execute_script("const e = document.activeElement; return e.id || e.tagName")
        )
    assert len(controls) >= 14
    assert set(controls) <= reached_controls
    num_unlabelled_controls = generated_report.execute_script(
        "return [...document.querySelectorAll('input, select')].filter((e) => !e.labels.length && !e.ariaLabel).length"
    )
    assert num_unlabelled_controls == 0


def test_captions_of_area_and_stiffness_figures_mention_the_combined_interval(driver, pages):
    browser.open_page(driver, pages["maps"])
    browser.open_more_section(driver)
    for name in ("area", "stiffness"):
        caption = find_element(driver, f"{name}-caption").get_property("textContent")
        assert "Shaded: 95 % combined interval." in caption
    assert log_is_empty(driver)


def test_figure_in_a_wide_panel_has_the_width_of_the_panel(generated_report):
    browser.open_more_section(generated_report)
    figure_width, svg_width = generated_report.execute_script(
        "const figure = document.querySelector('.more .panel > .figure'); figure.parentElement.classList.add('wide');"
        "return [figure, figure.firstElementChild].map((element) => element.getBoundingClientRect().width)"
    )
    assert svg_width == figure_width > 1000
