"""Tests of the app in a browser: its results equal those of the command."""

import contextlib
import json
import shlex
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import SimpleNamespace

import numpy as np
import pytest
from support import browser

pytest.importorskip("starlette", reason="the extra app is not installed")
pytest.importorskip("selenium", reason="selenium is not installed")

from app.served import PATIENCE, served, until, write_maps
from stiction import Profile, Study, Surface, run, write_profile, write_surface
from stiction._number_format import with_unit
from stiction.app.run import MAX_WINDOW_ABSENCE, is_abandoned
from stiction.app.server import OPTIONS
from stiction.cli import result_output
from support.command import call_stiction, check_stiction

pytestmark = browser.BROWSER_MARKS

CHANGED = "field.dispatchEvent(new Event('input', {bubbles: true}))"
AGREEMENT = 1e-6  # the page has numbers in single precision
HARD = {"upper": "mild steel", "lower": "brass", "load": "5 MPa", "tau0": "20", "shifts": "4"}


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    with served(tmp_path_factory.mktemp("app"), "--keep") as server:
        yield server


@pytest.fixture(scope="module")
def driver(app, tmp_path_factory):
    """A browser with access to the server."""
    with browser.start_browser(tmp_path_factory.mktemp("profile")) as driver:
        driver.set_page_load_timeout(PATIENCE)
        size(driver)
        driver.get(app.address)
        cookie = driver.get_cookies()[0]
        assert cookie["httpOnly"]
        assert cookie["sameSite"] == "Strict"
        app.cookie = f"{cookie['name']}={cookie['value']}"
        app.key = driver.execute_script("return key")
        yield driver


@pytest.fixture
def fresh(driver, app):
    """An unused page without errors."""
    driver.get(f"{app.origin}/app.css")  # where no script remembers anything while it is forgotten
    driver.execute_script("sessionStorage.clear()")
    driver.get(app.origin)
    driver.get_log("browser")
    yield driver
    complaints = [entry["message"] for entry in driver.get_log("browser") if entry["level"] != "INFO"]
    assert [
        complaint for complaint in complaints if "status of 400" not in complaint and "status of 413" not in complaint
    ] == []


@pytest.fixture(scope="module")
def maps(tmp_path_factory):
    return write_maps(tmp_path_factory.mktemp("maps"))


def size(driver, width=1280, height=720, scheme="light"):
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})


def choose(driver, side, path):
    driver.find_element("id", f"{side}-file").send_keys(str(path))
    return until(lambda: seen(driver, side), lambda said: said["wrong"] or "…" not in said["hint"])


def drop(driver, side, path):
    """As with the mouse."""
    driver.execute_script(
        "const files = new DataTransfer(); files.items.add(new File([arguments[1]], arguments[2]));"
        "const dropped = new DragEvent('drop', {dataTransfer: files, bubbles: true});"
        "document.getElementById(`${arguments[0]}-drop`).dispatchEvent(dropped)",
        side, path.read_text("utf-8"), path.name,
    )  # fmt: skip
    return until(lambda: seen(driver, side), lambda said: said["wrong"] or "Sq" in said["hint"])


def seen(driver, side):
    return {
        name: driver.execute_script(f"return document.querySelector('#{side}-drop .{name}').textContent")
        for name in ("hint", "wrong")
    }


def fill(driver, values):
    for name, value in values.items():
        driver.execute_script(
            "const field = document.querySelector(arguments[0]); field.value = arguments[1];"
            "for (const kind of ['input', 'change']) field.dispatchEvent(new Event(kind, {bubbles: true}))",
            name if name.startswith("#") else f"[name={name}]", value,
        )  # fmt: skip


def press(driver, form="pair"):
    """Press the button, and wait until the page shows the job that this begins."""
    before = driver.execute_script("return current")
    driver.find_element("css selector", f"#{form} .go").send_keys("\n")
    until(lambda: driver.execute_script("return current"), lambda now: now != before)


def state(driver):
    """Return the state of the latest job on the page."""
    return driver.execute_script("return jobs.find(({number}) => number === current)?.state")


def finished(driver):
    """Return the final state of the job, with its error if it failed."""
    until(lambda: state(driver), lambda now: now not in (None, "waiting", "running"))
    words = "return jobs.find(({number}) => number === current).words"
    until(lambda: driver.execute_script(words), lambda text: not text)  # the finished part of a stopped job is read
    return " ".join([state(driver), driver.find_element("id", "job-wrong").text]).strip()


def answer(driver):
    """Return the unrounded numbers of each sliding rule on the page, and the sentence."""
    lines = "return [...document.querySelectorAll('#answer .value')].map((each) => ({...each.dataset}))"
    rules = driver.execute_script(lines)
    shown = {rule["rule"]: [float(rule[name]) for name in ("value", "lower", "upper")] for rule in rules}
    return shown, driver.execute_script("return document.getElementById('sentence')?.textContent")


def same_as(driver, folder, monkeypatch):
    """Return numbers and sentence of the command line that the page shows, run on the same files."""
    line = driver.find_element("id", "command").get_property("textContent")
    monkeypatch.setattr(result_output, "write_figures", lambda *_, **__: None)
    completed = check_stiction(*shlex.split(line)[1:], "--json", cwd=folder)
    return of_record(json.loads(completed.stdout))


def of_record(record):
    first = record["answers"][0]
    return {item["rule"]: [item["value"], item["lower"], item["upper"]] for item in first["rules"]}, first["sentence"]


def inside(driver, script):
    """Run a script in the report, which is the variable `inside`."""
    return driver.execute_script(f"const inside = document.getElementById('page').contentDocument; {script}")


def wait_for_page(driver):
    """Wait until the report of the latest result is drawn."""
    is_last = "inside?.URL.split('#')[0].endsWith(reportAddress)"
    busy = "getElementById('main')?.getAttribute('aria-busy')"
    busy = f"return {is_last} ? inside.{busy} : null"
    browser.wait_for(driver, lambda _: inside(driver, busy) == "false")


def test_fields_accept_ranges_and_hardness_scales(app, fresh, maps):
    for side, scan in zip(("upper", "lower"), maps, strict=True):
        choose(fresh, side, scan)
    fill(fresh, HARD | {"mu0": "0.2±0.02", "tau0": "20..80", "hardness": "150 HV"})
    press(fresh)
    until(lambda: answer(fresh)[0] or state(fresh) == "failed", bool)
    assert finished(fresh) == "done"
    line = fresh.find_element("id", "command").get_property("textContent")
    assert all(f"{each}'" in line for each in ("--mu0=0.2±0.02", "--tau0=20..80 MPa", "--hardness=150 HV"))
    value, low, high = answer(fresh)[0]["all"]
    assert high - low > 0.2 * value


def test_form_has_a_field_for_each_option_of_a_pair(fresh):
    fill(fresh, {"upper": "numbers", "lower": "numbers", "mechanics": "half-space", "lay": "grooves"})
    fill(fresh, {"cutoff": "0.1 um,0.2 um", "adhesion": "50", "tip": "10 nm", "mu0": "0,15..0,25", "hardness": "2±0,2"})
    fresh.execute_script("document.querySelectorAll('[name=columns]')[1].value = 'x,z'")
    options = fresh.execute_script("return pairOptions()")
    arguments = {"mechanics": "half-space", "lay": "grooves", "cutoff": "0.1 um,0.2 um", "adhesion": "50 mJ/m^2"}
    arguments |= {"tip": "10 nm", "hardness": "2±0.2 GPa", "mu0": "0.15..0.25"}
    assert arguments.items() <= dict(options).items()
    assert [value for name, value in options if name == "columns"] == ["", "x,z"]
    names = set(fresh.execute_script("return [...document.querySelectorAll('#pair [name]')].map(({name}) => name)"))
    assert names == set(OPTIONS["pair"])
    fill(fresh, {"missing-value": "-9999,NaN", "accept": "whole-numbers", "width": "1,5 mm"})
    options = fresh.execute_script("return pairOptions()")
    assert ["width", "1.5 mm"] in options
    assert [value for name, value in options if name == "missing-value"] == ["-9999,NaN", ""]
    assert [value for name, value in options if name == "accept"] == ["whole-numbers", ""]


def test_caveat_of_file_is_accepted_by_its_field(fresh, tmp_path):
    heights = np.round(np.random.default_rng(0).standard_normal((32, 32)) * 20)
    heights[3, 4:20] = -9999
    np.savetxt(tmp_path / "map.txt", heights, fmt="%d")
    for name, value in {"unit": "um", "spacing": "10 um"}.items():
        fresh.execute_script(f"document.querySelector('#upper-drop [name={name}]').value = '{value}'")
    assert "-9999" in choose(fresh, "upper", tmp_path / "map.txt")["wrong"]
    fresh.execute_script(
        "for (const [name, value] of [['missing-value', '-9999'], ['accept', 'whole-numbers'], "
        "['missing', 'interpolate']]) {"
        "const field = document.querySelector(`#upper-drop [name=${name}]`); field.value = value;"
        "field.dispatchEvent(new Event('change', {bubbles: true})); }"
    )
    until(lambda: seen(fresh, "upper"), lambda said: "Sq 19.4 µm" in said["hint"] and not said["wrong"])


def test_columns_field_selects_columns(fresh, tmp_path):
    rows = np.column_stack([0.5 * np.arange(64), 7.0 * np.ones(64), np.random.default_rng(0).standard_normal(64)])
    np.savetxt(tmp_path / "three.txt", rows)
    assert "columns" in choose(fresh, "upper", tmp_path / "three.txt")["wrong"]
    fresh.execute_script(
        "for (const [name, value] of [['columns', '0,2'], ['unit', 'um']]) {"
        "const field = document.querySelector(`#upper-drop [name=${name}]`); field.value = value;"
        "field.dispatchEvent(new Event('change', {bubbles: true})); }"
    )
    until(lambda: seen(fresh, "upper")["hint"], lambda hint: "64 points; Pq" in hint)


def test_scan_that_is_being_read_is_not_reported_missing(fresh):
    fresh.execute_script("arriving.lower = 1")
    fresh.find_element("css selector", "#pair .go").send_keys("\n")
    words = fresh.find_element("id", "pair-wrong").text
    assert "the upper scan is missing" in words
    assert "the lower scan is still being read" in words


def test_metal_profiles_give_a_result(fresh, tmp_path, monkeypatch, rough_pair):
    for side, profile in zip(("upper", "lower"), rough_pair(1.1, points=1500), strict=True):
        write_profile(Profile(profile.heights, spacing=0.05), tmp_path / f"{side}.csv")
        choose(fresh, side, tmp_path / f"{side}.csv")
    fill(fresh, {"upper": "mild steel", "lower": "brass", "load": "1 MPa", "tau0": "20..80"})
    fill(fresh, {"mechanics": "half-space", "lay": "grooves"})
    press(fresh)
    assert finished(fresh) == "done"
    shown = answer(fresh)
    assert shown == same_as(fresh, tmp_path, monkeypatch)
    assert 0.2 < shown[0]["all"][0] < 0.5


def test_maps_give_the_result_of_the_command_at_each_step(app, fresh, maps, monkeypatch):
    """Upload, compute, change mu0, share and reload: each step equals the command."""
    roughness = json.loads(call_stiction("characterise", maps[0], "--json", cwd=app.folder).stdout)["values"]
    height = with_unit(next(item["value"] for item in roughness if item["name"] == "Sq"), "um")
    assert f"Sq {height}," in drop(fresh, "upper", maps[0])["hint"]
    assert "Sq" in choose(fresh, "lower", maps[1])["hint"]
    fill(fresh, HARD)
    press(fresh)
    until(lambda: answer(fresh)[0] or state(fresh) == "failed", bool)
    assert finished(fresh) == "done"
    wait_for_page(fresh)
    expected = same_as(fresh, maps[0].parent, monkeypatch)
    assert answer(fresh) == expected
    on_page = inside(fresh, "return {...inside.getElementById('readout').dataset}")
    np.testing.assert_allclose(
        [float(on_page[name]) for name in ("value", "lower", "upper")], expected[0]["all"], rtol=AGREEMENT
    )

    # The slider of the page, and then the field of the form: the other follows, and so do words and line.
    for move in (
        lambda: inside(fresh, "const field = inside.getElementById('mu0'); field.value = 0.3;" + CHANGED),
        lambda: fill(fresh, {"mu0": "0.35"}),
    ):
        before = answer(fresh)[1]
        move()
        until(lambda: answer(fresh)[1], lambda sentence, before=before: sentence != before)
        mu0 = inside(fresh, "return inside.getElementById('mu0-number').value")
        assert fresh.find_element("name", "mu0").get_property("value") == mu0
        assert f"--mu0={mu0}" in fresh.find_element("id", "command").get_property("textContent")
        assert f"μ0 = {mu0}," in answer(fresh)[1]
    shown, message = answer(fresh)
    numbers, sentence = same_as(fresh, maps[0].parent, monkeypatch)
    assert message == sentence
    assert shown == {rule: pytest.approx(values, rel=1e-12) for rule, values in numbers.items()}

    job = fresh.execute_script("return current")
    for name, begins in (
        ("page.html", "<!doctype html>"), ("result.csv", "load"), ("result.json", "{"), ("study.toml", "# Written by"),
    ):  # fmt: skip
        status, headers, body = app.ask("GET", f"/jobs/{job}/{name}?save")
        assert status == 200
        assert headers["Content-Disposition"] == f'attachment; filename="{name}"'
        assert body.decode().lower().startswith(begins.lower()) or begins in body.decode().splitlines()[0]
        assert str(app.folder) not in body.decode(), name
    assert of_record(json.loads(app.ask("GET", f"/jobs/{job}/result.json")[2])) == expected

    assert app.ask("GET", f"/jobs/{job}/at?load=1&mu0=0.2&tau0=0&d=1.2")[0] == 400  # it has no dimensions

    fresh.refresh()
    assert finished(fresh) == "done"
    until(lambda: answer(fresh), lambda now: now == expected)
    until(lambda: seen(fresh, "upper")["hint"], lambda hint: height in hint)

    # Without the page's own private names it is the study of these files, wherever they are.
    (maps[0].parent / "study.toml").write_bytes(app.ask("GET", f"/jobs/{job}/study.toml")[2])
    check_stiction("run", "study.toml", "--part=1/2", "--output=again", cwd=maps[0].parent)


def test_stopped_job_is_stored_and_resumes_with_another_window_open(fresh, tmp_path, app):
    for side, path in zip(("upper", "lower"), write_maps(tmp_path, 64), strict=True):
        choose(fresh, side, path)
    fill(fresh, HARD | {"shifts": "400"})
    with app.held(40) as let_go:
        press(fresh)
        # Both at once: what the page has drawn so far, and that more is finished than it has drawn.
        until(lambda: app.jobs()[-1], lambda job: job["versions"] > 1 and job["finished"] > 8)
        until(lambda: fresh.find_element("id", "words").text, lambda text: "of 400" in text)
        fresh.find_element("id", "stop").click()
        until(lambda: app.jobs()[-1], is_ending)
        let_go()
        assert finished(fresh) == "stopped"
    told = app.jobs()[-1]
    assert 8 < told["finished"] < 400
    assert f"{told['finished']} of 400 are finished" in fresh.find_element("id", "answer").text
    studies = app.private()[0].glob("results/*/pair/study.toml")
    (folder,) = [path.parent for path in studies if "repetitions = 400" in path.read_text("utf-8")]
    message = call_stiction("info", folder, "--json", cwd=app.folder)
    assert answer(fresh) == of_record(json.loads(message.stdout))
    with app.held(200):
        press(fresh)
        until(lambda: app.jobs()[-1]["finished"], lambda count: count > told["finished"])
        look_at_another_window(fresh, app)


def look_at_another_window(fresh, app):
    """Check another window, whose job waits for this one."""
    first = fresh.current_window_handle
    fresh.switch_to.new_window("tab")
    try:
        fresh.get(app.origin)
        fresh.find_element("css selector", "#made > summary").click()
        press(fresh, "run")
        until(lambda: state(fresh), bool)
        assert [job["state"] for job in app.jobs()[-2:]] == ["running", "waiting"]
        assert fresh.find_element("id", "title").text == "Generated profiles"
        fresh.find_element("id", "stop").click()
        assert finished(fresh) == "stopped"
    finally:
        fresh.close()
        fresh.switch_to.window(first)
    assert fresh.find_element("id", "title").text == "upper_face.csv on lower_face.csv"
    fresh.find_element("id", "stop").click()
    until(lambda: app.jobs()[-2], is_ending)


def is_ending(job):
    """Return whether a job is stopping or stopped."""
    return "stopping" in job["words"] or job["state"] == "stopped"


def test_errors_are_those_of_the_command_at_their_field(fresh, maps, tmp_path, monkeypatch):
    broken, plain = tmp_path / "broken.x3p", tmp_path / "plain.txt"
    broken.write_bytes(b"PK\3\4" + bytes(100))
    np.savetxt(plain, np.random.default_rng(0).standard_normal((24, 24)))

    def told(path, *options):
        return (
            call_stiction("characterise", path.name, *options, cwd=tmp_path).stderr.removeprefix("stiction: ").strip()
        )

    def mend(name, value):
        fresh.execute_script(
            "const field = document.querySelector(`#upper-drop [name=${arguments[0]}]`); field.value = arguments[1];"
            "field.dispatchEvent(new Event('change', {bubbles: true}))",
            name, value,
        )  # fmt: skip

    assert choose(fresh, "upper", broken)["wrong"] == told(broken)
    assert choose(fresh, "upper", plain)["wrong"] == told(plain)
    mend("unit", "nm")
    expected = told(plain, "--unit", "nm")
    until(lambda: seen(fresh, "upper")["wrong"], lambda wrong: wrong == expected)
    mend("spacing", "0.1 um")
    until(lambda: seen(fresh, "upper")["hint"], lambda hint: "2.4 µm" in hint)
    fresh.find_element("css selector", "#pair .go").send_keys("\n")
    assert "the lower scan is missing" in fresh.find_element("id", "pair-wrong").text
    # A map whose file says its unit, and another grid, beside one whose file does not.
    other = tmp_path / "coarse.csv"
    write_surface(Surface(0.01 * np.random.default_rng(3).standard_normal((20, 30)), spacing=(0.15, 0.12)), other)
    choose(fresh, "lower", other)
    fill(fresh, HARD | {"load": "5 apples"})
    press(fresh)
    assert finished(fresh).startswith("failed")
    assert "'5 apples'" in fresh.find_element("id", "pair-wrong").text
    assert fresh.find_element("name", "load").get_attribute("aria-invalid") == "true"
    fill(fresh, {"load": "5 MPa"})
    press(fresh)
    assert finished(fresh) == "done"
    assert answer(fresh) == same_as(fresh, tmp_path, monkeypatch)


def test_first_result_has_at_most_the_requested_positions(app, fresh):
    """And sample surfaces can be saved, so that the line can be repeated; what is so far said of how many."""
    fresh.find_element("id", "demo").click()
    for side in ("upper", "lower"):
        assert "128 × 128" in until(lambda side=side: seen(fresh, side)["hint"], lambda hint: "Sq" in hint)
        link = fresh.find_element("css selector", f"#{side}-drop .save").get_attribute("href")
        _, headers, body = app.ask("GET", link.removeprefix(app.origin))
        assert headers["Content-Disposition"] == f'attachment; filename="{side}.csv"'
        assert body.count(b"\n") >= 128
    until(lambda: state(fresh), bool)  # they are pressed at once
    fresh.execute_script("postJson(`/jobs/${current}/stop`)")
    assert finished(fresh) in ("stopped", "done")
    fill(fresh, {"shifts": "2"})
    by = "preview with the asperity model, without hardness, at 2 positions, here and in the pictures"
    with app.held(0):
        press(fresh)
        until(lambda: fresh.find_element("id", "answer").text, lambda text: by in text)
        wait_for_page(fresh)
        fresh.find_element("id", "stop").click()
        until(lambda: app.jobs()[-1], is_ending)
    assert finished(fresh) == "stopped"
    shown = fresh.find_element("id", "answer").text
    assert shown.startswith("stopped")
    assert by in shown


def test_cookie_sent_to_another_port_gives_no_access(app, fresh):
    """A browser sends cookies to every port: of those it has one secret, and not the other."""
    seen = []

    class Other(BaseHTTPRequestHandler):
        def do_GET(self):
            seen.append(f"{self.path}\n{self.headers}")
            self.send_response(200)
            self.end_headers()

        def log_message(self, *_):
            """Print nothing."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Other) as other:
        threading.Thread(target=other.serve_forever).start()
        try:
            fresh.get(f"http://127.0.0.1:{other.server_port}/")
            assert fresh.execute_script("return localStorage.getItem('key')") is None
        finally:
            other.shutdown()
    assert any(app.cookie in item for item in seen)
    assert not any(app.key in item for item in seen)
    status, _, page = app.ask("GET", "/", X_Stiction_Key=None)
    assert status == 200
    assert app.key not in page.decode()
    for path in ("/jobs", "/jobs?key=", "/results", "/scans/x", "/jobs/1/page.html", "/profiles?set=[]"):
        assert app.ask("GET", path, X_Stiction_Key=None)[0] == 403
    for method, path in (("POST", "/jobs"), ("POST", "/demo"), ("PUT", "/scans?name=a.csv"), ("POST", "/menu")):
        assert app.ask(method, path, b"{}", X_Stiction_Key=None)[0] == 403


def test_profiles_use_asperity_model_by_default(fresh, tmp_path, monkeypatch, rough_pair):
    for side, profile in zip(("upper", "lower"), rough_pair(1.1, points=1500), strict=True):
        write_profile(Profile(profile.heights, spacing=0.05), tmp_path / f"{side}.csv")
        assert "Pq" in choose(fresh, side, tmp_path / f"{side}.csv")["hint"]
    fill(fresh, {"upper": "numbers", "lower": "numbers", "load": "1 mN", "tau0": "5"})
    for name, values in (("young", (200, 70)), ("poisson", (0.3, 0.33))):
        for field, value in zip(fresh.find_elements("name", name), values, strict=True):
            field.send_keys(str(value))
    press(fresh)
    assert finished(fresh) == "done"
    assert answer(fresh) == same_as(fresh, tmp_path, monkeypatch)


def test_sliders_change_generated_profiles_and_mark_the_map(fresh):
    fresh.find_element("css selector", "#made > summary").click()
    lines = "return document.getElementById('profile').src"
    before = until(lambda: fresh.execute_script(lines), bool)
    fill(fresh, {"#d": "2", "#seed": "5"})
    until(lambda: fresh.execute_script(lines), lambda now: now != before)
    press(fresh, "run")
    assert finished(fresh) == "done"
    wait_for_page(fresh)
    assert float(inside(fresh, "return inside.getElementById('readout').dataset.dimension")) == pytest.approx(1.1)
    assert inside(fresh, "return inside.getElementById('map-panel').hidden") is False


def test_results_in_directory_are_listed_and_opened(fresh, app):
    few = {"ensemble.repetitions": 2, "surfaces.points": 3000}
    run(Study.named("quick").with_changes(few), store=app.folder / "mine")
    (app.folder / "broken").mkdir()
    (app.folder / "broken" / "study.toml").write_text("surfaces = 3\n")
    (app.folder / "broken" / "blocks").mkdir()
    fresh.find_element("css selector", "#there > summary").click()
    button = until(lambda: fresh.find_elements("css selector", "#results li:last-child button"), bool)[0]
    assert "a study, 2 of 2" in fresh.find_element("id", "results").text
    button.click()
    assert finished(fresh) == "done"
    assert fresh.find_element("id", "title").text == "mine"
    until(lambda: fresh.find_element("id", "page").is_displayed(), bool)


def test_app_has_no_accessibility_violations(fresh, maps):
    """No finding of axe, without and with an answer, on a screen by day and a phone by night; nothing is cut off."""
    script = browser.load_axe_script()

    def check():
        for width, scheme in ((1280, "light"), (390, "dark")):
            size(fresh, width, 720, scheme)
            assert browser.find_accessibility_faults(fresh, script) == []
            assert fresh.execute_script("return document.documentElement.scrollWidth <= innerWidth")
        size(fresh)

    try:
        for place in ("#made", "#there", "details[name=what]"):  # by keys alone
            fresh.find_element("css selector", f"{place} > summary").send_keys("\n")
            check()
        for side, path in zip(("upper", "lower"), maps, strict=True):
            choose(fresh, side, path)
        fill(fresh, HARD)
        press(fresh)
        assert finished(fresh) == "done"
        wait_for_page(fresh)
        check()
    finally:
        size(fresh)


def test_server_waits_longer_for_the_first_window():
    window = SimpleNamespace(last_request_time=100.0, has_window=True)
    assert not is_abandoned(window, 100.0 + MAX_WINDOW_ABSENCE)
    assert is_abandoned(window, 100.5 + MAX_WINDOW_ABSENCE)
    assert not is_abandoned(SimpleNamespace(last_request_time=100.0, has_window=False), 100.5 + MAX_WINDOW_ABSENCE)


def test_server_ends_after_its_last_window_is_closed(tmp_path, tmp_path_factory):
    """Here it asks whether anybody is there once somebody was, and that is the last that it hears."""
    code = "from stiction.app import run; from stiction.cli.application import print_message; "
    code += "run.MAX_WINDOW_ABSENCE = 1.5; run.run(print_message=print_message)"
    with served(tmp_path, code=code) as server, browser.start_browser(tmp_path_factory.mktemp("profile")) as driver:
        driver.get(server.address)
        driver.get("about:blank")
        assert server.process.wait(PATIENCE) == 0
        assert server.private() == []
        with contextlib.suppress(OSError):
            assert server.ask("GET", "/")[0] is None
