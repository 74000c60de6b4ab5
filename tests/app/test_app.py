"""Tests of the app in a browser; its results must equal those of the command line."""

import contextlib
import json
import re
import shlex
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import SimpleNamespace
from urllib.parse import unquote

import numpy as np
import pytest
from support import browser

pytest.importorskip("starlette", reason="the extra app is not installed")
pytest.importorskip("selenium", reason="selenium is not installed")

from app.server_process import MAX_WAITING_SECONDS, start_server, wait_until, write_maps
from stiction import (
    Profile,
    Study,
    Surface,
    interface,
    run,
    self_affine_surface,
    write_interface,
    write_profile,
    write_surface,
)
from stiction._estimate import Estimate
from stiction._number_format import format_with_unit
from stiction.app.form import replace_option_names
from stiction.app.run import SERVER_IDLE_TIMEOUT, is_server_abandoned
from stiction.app.server import ALLOWED_OPTIONS_BY_COMMAND
from stiction.cli import result_output
from stiction.views.point import SLIDING_RULE_DESCRIPTIONS
from support.command import call_stiction, check_stiction

# The commands of the server draw all samples, so that the same commands in this process must draw all samples, too.
pytestmark = [*browser.BROWSER_MARKS, pytest.mark.usefixtures("all_input_samples")]

DISPATCH_INPUT_EVENT_SCRIPT = "field.dispatchEvent(new Event('input', {bubbles: true}))"
MAX_ROUNDING_ERROR = 1e-6  # relative tolerance, because the report contains numbers in single precision
METAL_WEB_FORM_VALUES = {"upper": "mild steel", "lower": "brass", "load": "5 MPa", "tau0": "20", "shifts": "4"}


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    with start_server(tmp_path_factory.mktemp("app"), "--keep") as server:
        yield server


@pytest.fixture(scope="module")
def driver(app, tmp_path_factory):
    """Browser that is logged in to the server of the app."""
    with browser.start_browser(tmp_path_factory.mktemp("profile")) as driver:
        driver.set_page_load_timeout(MAX_WAITING_SECONDS)
        set_window_size(driver)
        driver.get(app.address)
        cookie = driver.get_cookies()[0]
        assert cookie["httpOnly"]
        assert cookie["sameSite"] == "Strict"
        app.cookie = f"{cookie['name']}={cookie['value']}"
        app.key = driver.execute_script("return key")
        yield driver


@pytest.fixture
def empty_page(driver, app):
    """Page of the app without inputs. After the test, the browser log must contain no unexpected error."""
    driver.get(f"{app.origin}/app.css")  # a page without scripts, which writes nothing to the storage
    driver.execute_script("sessionStorage.clear()")
    driver.get(app.origin)
    driver.get_log("browser")
    yield driver
    error_messages = [entry["message"] for entry in driver.get_log("browser") if entry["level"] != "INFO"]
    assert [
        error_message
        for error_message in error_messages
        if "status of 400" not in error_message and "status of 413" not in error_message
    ] == []


@pytest.fixture(scope="module")
def map_files(tmp_path_factory):
    return write_maps(tmp_path_factory.mktemp("maps"))


def set_window_size(driver, width=1280, height=720, scheme="light"):
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})


def choose_scan(driver, side, path):
    driver.find_element("id", f"{side}-file").send_keys(str(path))
    return wait_until(lambda: read_scan_texts(driver, side), lambda texts: texts["wrong"] or "…" not in texts["hint"])


def drop_scan_file(driver, side, path):
    """Drop a file on the field of a scan, as a user does with the mouse."""
    driver.execute_script(
        "const files = new DataTransfer(); files.items.add(new File([arguments[1]], arguments[2]));"
        "const dropped = new DragEvent('drop', {dataTransfer: files, bubbles: true});"
        "document.getElementById(`${arguments[0]}-drop`).dispatchEvent(dropped)",
        side, path.read_text("utf-8"), path.name,
    )  # fmt: skip
    return wait_until(lambda: read_scan_texts(driver, side), lambda texts: texts["wrong"] or "Sq" in texts["hint"])


def read_scan_texts(driver, side):
    return {
        name: driver.execute_script(f"return document.querySelector('#{side}-drop .{name}').textContent")
        for name in ("hint", "wrong")
    }


def fill_fields(driver, values):
    for name, value in values.items():
        driver.execute_script(
            "const field = document.querySelector(arguments[0]); field.value = arguments[1];"
            "for (const kind of ['input', 'change']) field.dispatchEvent(new Event(kind, {bubbles: true}))",
            name if name.startswith("#") else f"[name={name}]", value,
        )  # fmt: skip


def press_start_button(driver, form="pair"):
    """Press the start button of a form, and wait until the page shows the new job."""
    previous_job = driver.execute_script("return current")
    driver.find_element("css selector", f"#{form} .go").send_keys("\n")
    wait_until(lambda: driver.execute_script("return current"), lambda current_job: current_job != previous_job)


def read_job_state(driver):
    """Return the state of the job that the page shows."""
    return driver.execute_script("return jobs.find(({number}) => number === current)?.state")


def wait_until_finished(driver):
    """Wait until the job ends, and return its final state and its error message."""
    wait_until(lambda: read_job_state(driver), lambda current_state: current_state not in (None, "waiting", "running"))
    activity_script = "return jobs.find(({number}) => number === current).words"
    # The progress text of a stopped job remains until the app has read the partial result.
    wait_until(lambda: driver.execute_script(activity_script), lambda text: not text)
    return " ".join([read_job_state(driver), driver.find_element("id", "job-wrong").text]).strip()


def read_displayed_result(driver):
    """Return the displayed values and intervals by sliding rule, and the sentence about the first result."""
    script = "return [...document.querySelectorAll('#answer .value')].map((each) => ({...each.dataset}))"
    rules = driver.execute_script(script)
    interval_by_rule = {
        values_of_rule["rule"]: [json.loads(values_of_rule[name]) for name in ("value", "lower", "upper")]
        for values_of_rule in rules
    }
    return interval_by_rule, driver.execute_script("return document.getElementById('sentence')?.textContent")


def run_shown_command(driver, directory, monkeypatch):
    """Run the command line that the page shows on the same files, and return its values and its sentence to quote."""
    command_line = driver.find_element("id", "command").get_property("textContent")
    monkeypatch.setattr(result_output, "write_figures", lambda *_, **__: None)
    completed = check_stiction(*shlex.split(command_line)[1:], "--json", cwd=directory)
    return extract_first_answer(json.loads(completed.stdout))


def extract_first_answer(record):
    first_answer = record["points"][0]
    return {
        item["rule"]: [item["coefficient"][name] for name in ("value", "lower", "upper")]
        for item in first_answer["rules"]
    }, first_answer["sentence"]


def run_script_in_report(driver, script):
    """Run a script in the page, in which the variable `inside` is the document of the displayed report."""
    return driver.execute_script(f"const inside = document.getElementById('page').contentDocument; {script}")


def wait_for_report(driver):
    """Wait until the report of the latest result is drawn."""
    is_last_report = "inside?.URL.split('#')[0].endsWith(reportAddress)"
    busy_attribute = "getElementById('main')?.getAttribute('aria-busy')"
    busy_attribute = f"return {is_last_report} ? inside.{busy_attribute} : null"
    browser.wait_for(driver, lambda _: run_script_in_report(driver, busy_attribute) == "false")


def test_form_accepts_an_interface_file_and_keeps_the_file_after_a_reload(app, empty_page, map_files, tmp_path):
    for side, scan in zip(("upper", "lower"), map_files, strict=True):
        choose_scan(empty_page, side, scan)
    fill_fields(empty_page, {name: METAL_WEB_FORM_VALUES[name] for name in ("upper", "lower", "load", "shifts")})
    write_interface(interface("MoS2 on bearing steel, dry air"), tmp_path / "film.csv")
    empty_page.find_element("id", "interface-file").send_keys(str(tmp_path / "film.csv"))
    selected_text = "const [option] = form.interface.selectedOptions; return option.value && option.textContent"
    wait_until(lambda: empty_page.execute_script(selected_text), lambda text: text == "film.csv")
    assert empty_page.execute_script("return form.mu0.disabled")
    empty_page.refresh()
    assert empty_page.execute_script(selected_text) == "film.csv"
    wait_until(lambda: empty_page.execute_script("return arriving.upper + arriving.lower"), lambda number: number == 0)
    press_start_button(empty_page)
    assert wait_until_finished(empty_page) == "done"
    assert "--interface=film.csv" in empty_page.find_element("id", "command").get_property("textContent")
    (tmp_path / "other.csv").write_text("mu0,tau0\n0.1,0.2\n")
    empty_page.find_element("id", "interface-file").send_keys(str(tmp_path / "other.csv"))
    wait_until(lambda: empty_page.execute_script(selected_text), lambda text: text == "other.csv")
    empty_page.find_element("css selector", "#pair .go").send_keys("\n")
    message = "return document.getElementById('field-wrong')?.textContent"
    wait_until(lambda: empty_page.execute_script(message), lambda text: text and "is not an interface file" in text)


def test_form_accepts_uncertain_values_and_vickers_hardness(app, empty_page, map_files):
    for side, scan in zip(("upper", "lower"), map_files, strict=True):
        choose_scan(empty_page, side, scan)
    fill_fields(empty_page, METAL_WEB_FORM_VALUES | {"mu0": "0.2±0.02", "tau0": "20..80", "hardness": "150 HV"})
    press_start_button(empty_page)
    wait_until(lambda: read_displayed_result(empty_page)[0] or read_job_state(empty_page) == "failed", bool)
    assert wait_until_finished(empty_page) == "done"
    command_line = empty_page.find_element("id", "command").get_property("textContent")
    assert all(
        f"{argument}'" in command_line for argument in ("--mu0=0.2±0.02", "--tau0=20..80 MPa", "--hardness=150 HV")
    )
    value, lower, upper = read_displayed_result(empty_page)[0]["all"]
    assert upper - lower > 0.2 * value


def test_form_has_a_field_for_each_option_of_the_pair_command(empty_page):
    fill_fields(empty_page, {"upper": "numbers", "lower": "numbers", "mechanics": "half-space", "lay": "grooves"})
    fill_fields(
        empty_page,
        {"cutoff": "0.1 um,0.2 um", "adhesion": "50", "tip": "10 nm", "mu0": "0.15..0.25", "hardness": "2±0.2"},
    )
    empty_page.execute_script("document.querySelectorAll('[name=columns]')[1].value = 'x,z'")
    options = empty_page.execute_script("return pairOptions()")
    arguments = {"mechanics": "half-space", "lay": "grooves", "cutoff": "0.1 um,0.2 um", "adhesion": "50 mJ/m^2"}
    arguments |= {"tip": "10 nm", "hardness": "2±0.2 GPa", "mu0": "0.15..0.25"}
    assert arguments.items() <= dict(options).items()
    assert [value for name, value in options if name == "columns"] == ["", "x,z"]
    names = set(
        empty_page.execute_script("return [...document.querySelectorAll('#pair [name]')].map(({name}) => name)")
    )
    assert names == set(ALLOWED_OPTIONS_BY_COMMAND["pair"])
    fill_fields(empty_page, {"missing-value": "-9999,NaN", "accept": "whole-numbers", "load": "1 MPa, 5 MPa"})
    fill_fields(empty_page, {"outliers": "mask", "crop": "0 um,2 um", "texture": "turned", "junction-growth": "9"})
    fill_fields(empty_page, {"tilt": "free", "interface": "steel on ice", "mu0": "0,2"})
    options = empty_page.execute_script("return pairOptions()")
    assert ["load", "1 MPa, 5 MPa"] in options
    assert [option for option in options if option[0] == "outliers"] == [["outliers", "mask"]]
    assert [value for name, value in options if name == "crop"] == ["0 um,2 um", ""]
    assert [value for name, value in options if name == "texture"] == ["turned", ""]
    arguments = {"junction-growth": "9", "tilt": "free", "interface": "steel on ice"}
    assert arguments.items() <= dict(options).items()
    assert not {"mu0", "tau0"} & set(dict(options))
    fill_fields(empty_page, {"interface": ""})
    assert ["mu0", "0,2"] in empty_page.execute_script("return pairOptions()")
    assert [value for name, value in options if name == "missing-value"] == ["-9999,NaN", ""]
    assert [value for name, value in options if name == "accept"] == ["whole-numbers", ""]


def test_scan_caveat_disappears_after_the_option_named_in_the_caveat_is_set_in_the_form(empty_page, tmp_path):
    heights = np.round(np.random.default_rng(0).standard_normal((32, 32)) * 20)
    heights[3, 4:20] = -9999
    np.savetxt(tmp_path / "map.txt", heights, fmt="%d")
    for name, value in {"unit": "um", "spacing": "10 um"}.items():
        empty_page.execute_script(f"document.querySelector('#upper-drop [name={name}]').value = '{value}'")
    assert "-9999" in choose_scan(empty_page, "upper", tmp_path / "map.txt")["wrong"]
    empty_page.execute_script(
        "for (const [name, value] of [['missing-value', '-9999'], ['accept', 'whole-numbers'], "
        "['missing', 'interpolate']]) {"
        "const field = document.querySelector(`#upper-drop [name=${name}]`); field.value = value;"
        "field.dispatchEvent(new Event('change', {bubbles: true})); }"
    )
    wait_until(
        lambda: read_scan_texts(empty_page, "upper"), lambda texts: "Sq 19.4 µm" in texts["hint"] and not texts["wrong"]
    )


def test_preview_uses_the_latest_options_if_an_older_response_arrives_last(empty_page, tmp_path):
    rows = np.column_stack([0.5 * np.arange(64), 7.0 * np.ones(64), np.random.default_rng(0).standard_normal(64)])
    np.savetxt(tmp_path / "three.txt", rows)
    assert "columns" in choose_scan(empty_page, "upper", tmp_path / "three.txt")["wrong"]
    empty_page.execute_script(
        "const fetchNow = window.fetch; let delay = 2000; window.delayed = 0;"
        "window.fetch = async (...options) => {"
        "const wait = delay; delay = 0; const answer = await fetchNow(...options);"
        "await new Promise((resume) => setTimeout(resume, wait)); if (wait) window.delayed += 1; return answer; };"
        "for (const [name, value] of [['columns', '0,2'], ['unit', 'um']]) {"
        "const field = document.querySelector(`#upper-drop [name=${name}]`); field.value = value;"
        "field.dispatchEvent(new Event('change', {bubbles: true})); }"
    )
    wait_until(lambda: empty_page.execute_script("return window.delayed"), bool)
    wait_until(lambda: empty_page.execute_script("return arriving.upper"), lambda number: number == 0)
    texts = read_scan_texts(empty_page, "upper")
    assert "64 points; Pq" in texts["hint"]
    assert texts["wrong"] == ""


def test_panel_of_reading_options_opens_for_an_unreadable_scan_and_closes_for_a_readable_scan(
    empty_page, map_files, tmp_path
):
    text_file = tmp_path / "plain.txt"
    np.savetxt(text_file, np.random.default_rng(0).standard_normal((24, 24)))
    is_open = "return document.querySelector('#lower-drop details').open"
    assert choose_scan(empty_page, "lower", text_file)["wrong"]
    assert empty_page.execute_script(is_open)
    message_is_in_view = (
        "const [message, inputs] = ['#lower-drop .wrong', '#inputs'].map((each) => document.querySelector(each)"
        ".getBoundingClientRect()); return message.top >= inputs.top && message.bottom <= inputs.bottom"
    )
    assert empty_page.execute_script(message_is_in_view)
    choose_scan(empty_page, "lower", map_files[1])
    wait_until(lambda: read_scan_texts(empty_page, "lower")["hint"], lambda hint: "Sq" in hint)
    assert not empty_page.execute_script(is_open)
    empty_page.find_element("css selector", "#lower-drop summary").click()
    choose_scan(empty_page, "lower", text_file)
    choose_scan(empty_page, "lower", map_files[1])
    wait_until(lambda: read_scan_texts(empty_page, "lower")["hint"], lambda hint: "Sq" in hint)
    assert empty_page.execute_script(is_open)


def test_late_response_does_not_replace_newer_progress_of_a_job(empty_page):
    empty_page.execute_script(
        "const fetchNow = window.fetch; let isFirst = true; window.delayed = 0;"
        "window.fetch = async (...options) => {"
        "const isLate = isFirst; isFirst = false; if (!isLate) return fetchNow(...options);"
        "await new Promise((resume) => setTimeout(resume, 1000)); window.delayed += 1;"
        "return new Response(JSON.stringify([{number: -1}])); };"
        "poll(); poll();"
    )
    wait_until(lambda: empty_page.execute_script("return window.delayed"), bool)
    script = "setTimeout(() => arguments[0](jobs.map(({number}) => number)), 50)"
    assert -1 not in empty_page.execute_async_script(script)


def test_page_shows_the_assessment_of_a_job_that_has_no_report(empty_page):
    rule = {"rule": "all", "text": "0.31 [0.28, 0.34]", "coefficient": Estimate(0.31, 0.28, 0.34).to_record()}
    record = {"at": {}, "rules": [rule], "assessment": "Quote it", "caveats": [], "sentence": ""}
    job = {"number": 99, "title": "a pair", "state": "running", "finished": 4, "total": 8, "by": "so far", "words": ""}
    job |= {"answer": record, "error": "", "option": "", "command": "stiction pair a b", "versions": 1}
    failed_job = job | {"state": "failed", "by": "", "error": "the disk is full", "versions": 0}
    script = """const show = (job) => {
        [jobs, current, reportAddress] = [[job], job.number, withKey("/jobs/99/page.html?1")];
        render();
        const assessment = document.querySelector("#answer .assessment")?.textContent ?? "";
        return [byId("page").hidden, byId("share").hidden, assessment, byId("job-wrong").textContent];
      };
      return arguments[0].map(show)"""
    assert empty_page.execute_script(script, [job, failed_job]) == [
        [False, True, "", ""],
        [True, True, "Quote it", "the disk is full"],
    ]


def test_copy_button_has_its_original_label_again_after_two_clicks(empty_page):
    script = (
        "for (const text of ['x', 'x']) copy(byId('copy'), text);"
        "setTimeout(() => arguments[0](byId('copy').textContent), 2500)"
    )
    label = empty_page.execute_script("return byId('copy').textContent")
    assert empty_page.execute_async_script(script) == label


def test_form_distinguishes_missing_scans_from_scans_that_are_still_being_read(empty_page):
    empty_page.execute_script("arriving.lower = 1")
    empty_page.find_element("css selector", "#pair .go").send_keys("\n")
    message = empty_page.find_element("id", "pair-wrong").text
    assert re.search(r"upper scan.* missing.*lower scan.* being read", message, re.DOTALL)


def test_app_and_pair_command_give_equal_results_for_metal_profiles(
    empty_page, tmp_path, monkeypatch, create_rough_profiles
):
    for side, profile in zip(("upper", "lower"), create_rough_profiles(1.1, points=1500), strict=True):
        write_profile(Profile(profile.heights, spacing=0.05), tmp_path / f"{side}.csv")
        choose_scan(empty_page, side, tmp_path / f"{side}.csv")
    fill_fields(empty_page, {"upper": "mild steel", "lower": "brass", "load": "1 MPa", "tau0": "20..80"})
    fill_fields(empty_page, {"mechanics": "half-space", "lay": "grooves"})
    press_start_button(empty_page)
    assert wait_until_finished(empty_page) == "done"
    result = read_displayed_result(empty_page)
    assert result == run_shown_command(empty_page, tmp_path, monkeypatch)
    assert 0.2 < result[0]["all"][0] < 0.5


def test_app_and_pair_command_give_equal_results_for_maps_after_each_user_action(
    app, empty_page, map_files, monkeypatch
):
    """After each step, the app shows the result that the command prints: upload, compute, change mu0, save, reload."""
    roughness = json.loads(call_stiction("characterise", map_files[0], "--json", cwd=app.directory).stdout)["values"]
    height = format_with_unit(next(item["value"] for item in roughness if item["name"] == "Sq"), "um")
    assert f"Sq {height}," in drop_scan_file(empty_page, "upper", map_files[0])["hint"]
    assert "Sq" in choose_scan(empty_page, "lower", map_files[1])["hint"]
    fill_fields(empty_page, METAL_WEB_FORM_VALUES | {"junction-growth": "0"})
    press_start_button(empty_page)
    wait_until(lambda: read_displayed_result(empty_page)[0] or read_job_state(empty_page) == "failed", bool)
    assert wait_until_finished(empty_page) == "done"
    wait_for_report(empty_page)
    expected = run_shown_command(empty_page, map_files[0].parent, monkeypatch)
    assert read_displayed_result(empty_page) == expected
    hints = run_script_in_report(
        empty_page, "return [...inside.querySelectorAll('#answer .hint')].map((each) => each.textContent)"
    )
    interval_titles = [text.split(":")[0] for text in hints if text.startswith("Interval of the mean")]
    assert interval_titles
    titles_by_rule = [f"Interval of the mean, {SLIDING_RULE_DESCRIPTIONS[rule]}" for rule in expected[0]]
    assert interval_titles == [title for title in titles_by_rule if title in interval_titles]
    report_values = run_script_in_report(empty_page, "return {...inside.getElementById('readout').dataset}")
    np.testing.assert_allclose(
        [float(report_values[name]) for name in ("value", "lower", "upper")],
        expected[0]["all"],
        rtol=MAX_ROUNDING_ERROR,
    )

    move_slider = "const field = inside.getElementById('mu0'); field.value = 1;" + DISPATCH_INPUT_EVENT_SCRIPT
    for change_mu0, field_value, report_value in (
        (lambda: run_script_in_report(empty_page, move_slider), "0.1", 0.1),
        (lambda: fill_fields(empty_page, {"mu0": "0.4"}), "0.4", 0.4),
        (lambda: fill_fields(empty_page, {"mu0": "0.35"}), "0.35", 0.4),
    ):
        sentence_before = read_displayed_result(empty_page)[1]
        change_mu0()
        wait_until(
            lambda: read_displayed_result(empty_page)[1],
            lambda expected_sentence, sentence_before=sentence_before: expected_sentence != sentence_before,
        )
        mu0 = run_script_in_report(empty_page, "return inside.getElementById('readout').dataset.mu0")
        assert float(mu0) == report_value
        assert empty_page.find_element("name", "mu0").get_property("value") == field_value
        assert f"--mu0={field_value}" in empty_page.find_element("id", "command").get_property("textContent")
        assert f"μ0 = {field_value}," in read_displayed_result(empty_page)[1]
    shown_intervals, shown_sentence = read_displayed_result(empty_page)
    expected_intervals, expected_sentence = run_shown_command(empty_page, map_files[0].parent, monkeypatch)
    assert shown_sentence == expected_sentence
    assert shown_intervals == {rule: pytest.approx(values, rel=1e-12) for rule, values in expected_intervals.items()}

    job = empty_page.execute_script("return current")
    for name, expected_start in (
        ("page.html", "<!doctype html>"), ("result.csv", "load"), ("result.json", "{"), ("study.toml", "# Written by"),
    ):  # fmt: skip
        status, headers, body = app.request("GET", f"/jobs/{job}/{name}?save")
        assert status == 200
        saved_name = f"upper_face on lower_face.{name.partition('.')[2]}"
        assert unquote(headers["Content-Disposition"]) in (
            f"attachment; filename*=utf-8''{saved_name}",
            f'attachment; filename="{saved_name}"',
        )
        assert (
            body.decode().lower().startswith(expected_start.lower()) or expected_start in body.decode().splitlines()[0]
        )
        assert str(app.directory) not in body.decode(), name
    assert extract_first_answer(json.loads(app.request("GET", f"/jobs/{job}/result.json")[2])) == expected

    assert app.request("GET", f"/jobs/{job}/at?load=1&mu0=0.2&tau0=0&d=1.2")[0] == 400

    empty_page.refresh()
    assert wait_until_finished(empty_page) == "done"
    wait_until(lambda: read_displayed_result(empty_page), lambda current_result: current_result == expected)
    wait_until(lambda: read_scan_texts(empty_page, "upper")["hint"], lambda hint: height in hint)

    (map_files[0].parent / "study.toml").write_bytes(app.request("GET", f"/jobs/{job}/study.toml")[2])
    check_stiction("run", "study.toml", "--part=1/2", "--output=again", cwd=map_files[0].parent)


def write_fitting_faces(directory):
    """Write a rough face and the face that fits onto it, both as they would be scanned, and return the paths."""
    face = self_affine_surface(
        4, hurst_exponent=0.8, rms=1000.0, shape=(64, 64), spacing=500.0, shortest_wavelength=3000.0
    )
    paths = [directory / f"{side}_half.csv" for side in ("upper", "lower")]
    for path, body in zip(paths, (Surface(-face.heights[::-1], spacing=face.spacing), face), strict=True):
        write_surface(body, path)
    return paths


def is_shear_test_offered(driver):
    return driver.find_element("id", "shear").is_displayed()


def test_app_offers_a_shear_test_if_the_two_scanned_faces_fit_together(empty_page, map_files, tmp_path):
    paths = write_fitting_faces(tmp_path)
    for side, path in zip(("upper", "lower"), paths, strict=True):
        assert not is_shear_test_offered(empty_page)
        choose_scan(empty_page, side, path)
    wait_until(lambda: is_shear_test_offered(empty_page), bool)
    assert empty_page.find_element("css selector", "#shear [name=path]").get_property("value") == "3.2 mm"
    fill_fields(empty_page, {"upper": "numbers", "lower": "numbers", "load": "1 MPa", "mu0": "0.5..0.7", "tau0": "0"})
    for name, value in (("young", "30"), ("poisson", "0.25")):
        empty_page.execute_script(f"for (const field of form['{name}']) field.value = '{value}'")
    fill_fields(empty_page, {"hardness": "0.15", "cutoff": "1 mm", "#shear [name=normal-stiffness]": "1 MPa/mm"})
    press_start_button(empty_page, "shear")
    assert wait_until_finished(empty_page) == "done"
    command_line = empty_page.find_element("id", "command").get_property("textContent")
    assert "--cutoff" not in command_line
    record = json.loads(check_stiction(*shlex.split(command_line)[1:], "--json", cwd=tmp_path).stdout)
    values = {value["name"]: value["value"] for value in record["values"][:5]}
    displayed_form = empty_page.execute_script(
        "return [...document.querySelectorAll('#answer .value')]"
        ".map(({dataset}) => [dataset.place, Number(dataset.value)])"
    )
    assert displayed_form == [
        ["at the peak", pytest.approx(values["peak_friction_coefficient"])],
        ["at the end", pytest.approx(values["end_friction_coefficient"])],
    ]
    browser.wait_for(
        empty_page, lambda _: "on lower_half.csv" in (run_script_in_report(empty_page, "return inside?.title") or "")
    )
    assert not empty_page.find_element("css selector", "[data-file='study.toml']").is_displayed()
    choose_scan(empty_page, "upper", map_files[0])
    wait_until(lambda: is_shear_test_offered(empty_page), lambda is_offered: not is_offered)


def test_app_shows_why_a_shear_test_cannot_be_computed(empty_page, tmp_path):
    for side, path in zip(("upper", "lower"), write_fitting_faces(tmp_path), strict=True):
        choose_scan(empty_page, side, path)
    wait_until(lambda: is_shear_test_offered(empty_page), bool)
    fill_fields(empty_page, METAL_WEB_FORM_VALUES | {"#shear [name=path]": "30 mm"})
    press_start_button(empty_page, "shear")
    assert "must leave an overlap of at least 16 points" in wait_until_finished(empty_page)


def test_stopped_job_stores_its_partial_result_and_can_be_resumed(empty_page, tmp_path, app):
    for side, path in zip(("upper", "lower"), write_maps(tmp_path, 128), strict=True):
        choose_scan(empty_page, side, path)
    fill_fields(empty_page, METAL_WEB_FORM_VALUES | {"shifts": "280"})
    with app.block_commands(40) as unblock:
        press_start_button(empty_page)
        wait_until(lambda: app.list_jobs()[-1], lambda job: job["versions"] > 1 and job["finished"] > 8)
        wait_until(lambda: empty_page.find_element("id", "words").text, lambda text: "of 280" in text)
        empty_page.find_element("id", "stop").click()
        wait_until(lambda: app.list_jobs()[-1], is_stopping_or_stopped)
        unblock()
        assert wait_until_finished(empty_page) == "stopped"
    stopped_job = app.list_jobs()[-1]
    assert 8 < stopped_job["finished"] < 280
    assert f"{stopped_job['finished']} of 280 are finished" in empty_page.find_element("id", "answer").text
    studies = app.find_private_directories()[0].glob("results/*/pair/study.toml")
    (directory,) = [path.parent for path in studies if "repetitions = 280" in path.read_text("utf-8")]
    info = call_stiction("info", directory, "--json", cwd=app.directory)
    assert read_displayed_result(empty_page) == extract_first_answer(json.loads(info.stdout))
    with app.block_commands(200):
        press_start_button(empty_page)
        wait_until(lambda: app.list_jobs()[-1]["finished"], lambda count: count > stopped_job["finished"])
        check_queue_of_two_windows(empty_page, app)


def check_queue_of_two_windows(empty_page, app):
    """Queue a job from a second window while the job of the first window runs, and stop both jobs."""
    first_window = empty_page.current_window_handle
    empty_page.switch_to.new_window("tab")
    try:
        empty_page.get(app.origin)
        empty_page.find_element("css selector", "#made > summary").click()
        press_start_button(empty_page, "run")
        wait_until(lambda: read_job_state(empty_page), bool)
        assert [job["state"] for job in app.list_jobs()[-2:]] == ["running", "waiting"]
        assert empty_page.find_element("id", "title").text == "Generated profiles"
        assert empty_page.find_element("id", "words").text == "waiting for upper_face.csv on lower_face.csv"
        empty_page.find_element("id", "stop").click()
        assert wait_until_finished(empty_page) == "stopped"
    finally:
        empty_page.close()
        empty_page.switch_to.window(first_window)
    assert empty_page.find_element("id", "title").text == "upper_face.csv on lower_face.csv"
    empty_page.find_element("id", "stop").click()
    wait_until(lambda: app.list_jobs()[-2], is_stopping_or_stopped)


def is_stopping_or_stopped(job):
    """Return whether a job is stopping or stopped."""
    return "stopping" in job["words"] or job["state"] == "stopped"


def test_command_error_is_shown_at_the_form_field_that_caused_it(empty_page, map_files, tmp_path, monkeypatch):
    broken_file, text_file = tmp_path / "broken.x3p", tmp_path / "plain.txt"
    broken_file.write_bytes(b"PK\3\4" + bytes(100))
    np.savetxt(text_file, np.random.default_rng(0).standard_normal((24, 24)))

    def get_command_error(path, *options):
        """Return the error message of the command, in which field labels replace option names."""
        message = call_stiction("characterise", path.name, *options, cwd=tmp_path).stderr
        return replace_option_names(message.removeprefix("stiction: ").strip())

    def set_file_form_field(name, value):
        empty_page.execute_script(
            "const field = document.querySelector(`#upper-drop [name=${arguments[0]}]`); field.value = arguments[1];"
            "field.dispatchEvent(new Event('change', {bubbles: true}))",
            name, value,
        )  # fmt: skip

    assert choose_scan(empty_page, "upper", broken_file)["wrong"] == get_command_error(broken_file)
    # Empty the field, or else the browser does not report a second choice of the same file.
    assert empty_page.find_element("id", "upper-file").get_property("value") == ""
    assert choose_scan(empty_page, "upper", text_file)["wrong"] == get_command_error(text_file)
    set_file_form_field("unit", "nm")
    expected_message = get_command_error(text_file, "--unit", "nm")
    wait_until(lambda: read_scan_texts(empty_page, "upper")["wrong"], lambda wrong: wrong == expected_message)
    set_file_form_field("spacing", "0.1 um")
    wait_until(lambda: read_scan_texts(empty_page, "upper")["hint"], lambda hint: "2.4 µm" in hint)
    empty_page.find_element("css selector", "#pair .go").send_keys("\n")
    assert "the lower scan is missing" in empty_page.find_element("id", "pair-wrong").text
    csv_file = tmp_path / "coarse.csv"
    write_surface(Surface(0.01 * np.random.default_rng(3).standard_normal((20, 30)), spacing=(0.15, 0.12)), csv_file)
    choose_scan(empty_page, "lower", csv_file)
    fill_fields(empty_page, METAL_WEB_FORM_VALUES | {"load": "5 apples"})
    num_jobs = empty_page.execute_script("return jobs.length")
    empty_page.find_element("css selector", "#pair .go").send_keys("\n")
    message = wait_until(lambda: empty_page.find_elements("id", "field-wrong"), bool)[0]
    assert "'5 apples'" in message.text
    assert message.is_displayed()
    assert empty_page.execute_script("return arguments[0].previousElementSibling.control.name", message) == "load"
    assert empty_page.find_element("name", "load").get_attribute("aria-invalid") == "true"
    assert empty_page.execute_script("return jobs.length") == num_jobs
    fill_fields(empty_page, {"load": "5 MPa", "lay": "grooves"})
    assert empty_page.find_elements("id", "field-wrong") == []
    press_start_button(empty_page)
    assert wait_until_finished(empty_page).startswith("failed")
    message = empty_page.find_element("id", "field-wrong")
    assert empty_page.execute_script("return arguments[0].previousElementSibling.control.name", message) == "lay"
    assert message.is_displayed()
    fill_fields(empty_page, {"lay": ""})
    press_start_button(empty_page)
    assert wait_until_finished(empty_page) == "done"
    assert read_displayed_result(empty_page) == run_shown_command(empty_page, tmp_path, monkeypatch)


def test_preview_uses_no_more_positions_than_requested(app, empty_page):
    """Check also that the sample surfaces can be saved, so that the command line can be repeated."""
    empty_page.find_element("id", "demo").click()
    for side in ("upper", "lower"):
        assert "128 × 128" in wait_until(
            lambda side=side: read_scan_texts(empty_page, side)["hint"], lambda hint: "Sq" in hint
        )
        link = empty_page.find_element("css selector", f"#{side}-drop .save").get_attribute("href")
        _, headers, body = app.request("GET", link.removeprefix(app.origin))
        assert headers["Content-Disposition"] == f'attachment; filename="{side}.csv"'
        assert body.count(b"\n") >= 128
    wait_until(lambda: read_job_state(empty_page), bool)
    empty_page.execute_script("postJson(`/jobs/${current}/stop`)")
    assert wait_until_finished(empty_page) in ("stopped", "done")
    fill_fields(empty_page, {"shifts": "2"})
    preview_description = "preview with the asperity model, without hardness, at 2 positions, here and in the pictures"
    with app.block_commands(0):
        press_start_button(empty_page)
        wait_until(lambda: empty_page.find_element("id", "answer").text, lambda text: preview_description in text)
        wait_for_report(empty_page)
        empty_page.find_element("id", "stop").click()
        assert wait_until_finished(empty_page) == "stopped"
    answer_text = empty_page.find_element("id", "answer").text
    assert answer_text.startswith("stopped")
    assert preview_description in answer_text


def test_cookie_sent_to_another_port_does_not_grant_access(app, empty_page):
    """A browser sends a cookie to all ports of a host, so access also requires the key of the page."""
    received_requests = []

    class RequestRecordingHandler(BaseHTTPRequestHandler):
        def do_GET(self):
            received_requests.append(f"{self.path}\n{self.headers}")
            self.send_response(200)
            self.end_headers()

        def log_message(self, *_):
            """Print nothing."""

    with ThreadingHTTPServer(("127.0.0.1", 0), RequestRecordingHandler) as other_server:
        threading.Thread(target=other_server.serve_forever).start()
        try:
            empty_page.get(f"http://127.0.0.1:{other_server.server_port}/")
            assert empty_page.execute_script("return localStorage.getItem('key')") is None
        finally:
            other_server.shutdown()
    assert any(app.cookie in received_request for received_request in received_requests)
    assert not any(app.key in received_request for received_request in received_requests)
    status, _, start_page = app.request("GET", "/", X_Stiction_Key=None)
    assert status == 200
    assert app.key not in start_page.decode()
    for path in ("/jobs", "/jobs?key=", "/results", "/scans/x", "/jobs/1/page.html", "/profiles?set=[]"):
        assert app.request("GET", path, X_Stiction_Key=None)[0] == 403
    for method, path in (("POST", "/jobs"), ("POST", "/demo"), ("PUT", "/scans?name=a.csv"), ("POST", "/menu")):
        assert app.request(method, path, b"{}", X_Stiction_Key=None)[0] == 403


def test_app_uses_the_asperity_model_by_default_for_profiles_without_hardness(
    empty_page, tmp_path, monkeypatch, create_rough_profiles
):
    for side, profile in zip(("upper", "lower"), create_rough_profiles(1.1, points=1500), strict=True):
        write_profile(Profile(profile.heights, spacing=0.05), tmp_path / f"{side}.csv")
        assert "Pq" in choose_scan(empty_page, side, tmp_path / f"{side}.csv")["hint"]
    fill_fields(empty_page, {"upper": "numbers", "lower": "numbers", "load": "1 mN", "tau0": "5"})
    for name, values in (("young", (200, 70)), ("poisson", (0.3, 0.33))):
        for field, value in zip(empty_page.find_elements("name", name), values, strict=True):
            field.send_keys(str(value))
    press_start_button(empty_page)
    assert wait_until_finished(empty_page) == "done"
    assert read_displayed_result(empty_page) == run_shown_command(empty_page, tmp_path, monkeypatch)


def test_profile_preview_and_result_use_the_fractal_dimension_entered_in_the_form(empty_page):
    empty_page.find_element("css selector", "#made > summary").click()
    image_address_script = "return document.getElementById('profile').src"
    previous_address = wait_until(lambda: empty_page.execute_script(image_address_script), bool)
    fill_fields(empty_page, {"#d": "2", "#seed": "5"})
    wait_until(
        lambda: empty_page.execute_script(image_address_script), lambda image_address: image_address != previous_address
    )
    press_start_button(empty_page, "run")
    assert wait_until_finished(empty_page) == "done"
    wait_for_report(empty_page)
    assert float(
        run_script_in_report(empty_page, "return inside.getElementById('readout').dataset.dimension")
    ) == pytest.approx(1.1)
    assert run_script_in_report(empty_page, "return inside.getElementById('map-panel').hidden") is False


def test_app_lists_and_opens_results_in_the_working_directory(empty_page, app):
    changes = {"ensemble.repetitions": 2, "surfaces.points": 3000}
    run(Study.named("quick").with_changes(changes), store=app.directory / "mine")
    (app.directory / "broken").mkdir()
    (app.directory / "broken" / "study.toml").write_text("surfaces = 3\n")
    (app.directory / "broken" / "blocks").mkdir()
    empty_page.find_element("css selector", "#there > summary").click()
    button = wait_until(lambda: empty_page.find_elements("css selector", "#results li:last-child button"), bool)[0]
    assert "a study, 2 of 2" in empty_page.find_element("id", "results").text
    button.click()
    assert wait_until_finished(empty_page) == "done"
    assert empty_page.find_element("id", "title").text == "mine"
    wait_until(lambda: empty_page.find_element("id", "page").is_displayed(), bool)


def test_app_has_no_accessibility_violations(empty_page, map_files):
    """The page is checked with and without a result, on a large screen in light mode and on a phone in dark mode."""
    axe_script = browser.load_axe_script()

    def check_accessibility():
        for width, scheme in ((1280, "light"), (390, "dark")):
            set_window_size(empty_page, width, 720, scheme)
            assert browser.find_accessibility_violations(empty_page, axe_script) == []
            assert empty_page.execute_script("return document.documentElement.scrollWidth <= innerWidth")
        set_window_size(empty_page)

    try:
        for section in ("#made", "#there", "details[name=what]"):
            empty_page.find_element("css selector", f"{section} > summary").send_keys("\n")
            check_accessibility()
        for side, path in zip(("upper", "lower"), map_files, strict=True):
            choose_scan(empty_page, side, path)
        fill_fields(empty_page, METAL_WEB_FORM_VALUES)
        press_start_button(empty_page)
        assert wait_until_finished(empty_page) == "done"
        wait_for_report(empty_page)
        check_accessibility()
    finally:
        set_window_size(empty_page)


def test_server_is_treated_as_abandoned_only_if_a_browser_window_has_been_open():
    window = SimpleNamespace(last_request_time=100.0, has_window=True)
    assert not is_server_abandoned(window, 100.0 + SERVER_IDLE_TIMEOUT)
    assert is_server_abandoned(window, 100.5 + SERVER_IDLE_TIMEOUT)
    assert not is_server_abandoned(
        SimpleNamespace(last_request_time=100.0, has_window=False), 100.5 + SERVER_IDLE_TIMEOUT
    )


def test_server_stops_after_its_last_window_is_closed(tmp_path, tmp_path_factory):
    """Close a page that has sent only one request about open windows."""
    code = "from stiction.app import run; from stiction.cli.application import print_message; "
    code += "run.SERVER_IDLE_TIMEOUT = 1.5; run.run(print_message=print_message)"
    with (
        start_server(tmp_path, code=code) as server,
        browser.start_browser(tmp_path_factory.mktemp("profile")) as driver,
    ):
        driver.get(server.address)
        driver.get("about:blank")
        assert server.process.wait(MAX_WAITING_SECONDS) == 0
        assert server.find_private_directories() == []
        with contextlib.suppress(OSError):
            assert server.request("GET", "/")[0] is None
