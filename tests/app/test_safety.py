"""Tests of the access control and of the limits of the app server."""

import asyncio
import json
import os
import resource
import shlex
import signal
import socket
import stat
import subprocess
import threading
import tomllib
import zipfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from pathlib import Path
from types import SimpleNamespace
from urllib.parse import quote

import pytest

pytest.importorskip("starlette", reason="the extra app is not installed")

from app.server_process import start_server, wait_until, write_maps
from stiction import Study, Surface, flipped, interface, run, self_affine_surface, write_interface, write_surface
from stiction.app import jobs, server
from stiction.app.jobs import JobQueue, RejectedRequestError, run_module
from stiction.app.server import MAX_CONCURRENT_REQUESTS

SMALL_ENSEMBLE = {"ensemble.repetitions": 2, "surfaces.points": 3000}
MAX_SERVER_MEMORY = 400e6  # bytes, for a server that has loaded xarray and reads one scan at a time


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    with start_server(tmp_path_factory.mktemp("app"), "--keep") as server:
        server.cookie_line = server.log_in()
        yield server


@pytest.fixture(scope="module")
def map_scans(app, tmp_path_factory):
    """Identifiers of two uploaded maps, in the form in which a request for a job contains them."""
    paths = write_maps(tmp_path_factory.mktemp("maps"))
    return {body_name: app.upload(path) for body_name, path in zip(("upper", "lower"), paths, strict=True)}


def test_access_token_is_valid_only_once_and_cookie_is_inaccessible_to_scripts(app):
    assert "HttpOnly" in app.cookie_line
    assert "samesite=strict" in app.cookie_line.lower()
    assert app.request("GET", f"/?token={app.token}", cookie="")[0] == 403


@pytest.mark.parametrize(
    "path",
    ["/", "/app.js", "/jobs", "/results", "/jobs/1/page.html", "/scans/upper/upper.csv", "/?token=x", "/?token="],
)
@pytest.mark.parametrize("cookie", ["", "stiction-1=x", "stiction-{port}=wrong"])
def test_requests_without_cookie_are_rejected(app, path, cookie):
    status, _, body = app.request("GET", path, cookie=cookie.format(port=app.port))
    assert status == 403
    assert len(body) < 200


@pytest.mark.parametrize("host", ["evil.example", "localhost:{port}", "127.0.0.1", "127.0.0.1:1", "", None])
def test_requests_with_foreign_host_names_are_rejected(app, host):
    """Check that access is refused if a hostile page makes its host name resolve to 127.0.0.1."""
    status, _, _ = app.request("GET", "/", Host=host and host.format(port=app.port))
    assert status in (400, 421)


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1:{port}"])
def test_requests_from_other_origins_are_rejected(app, origin):
    for method, path in (("GET", "/"), ("POST", "/demo"), ("POST", "/jobs"), ("PUT", "/scans?name=a.csv")):
        assert app.request(method, path, b"{}", Origin=origin.format(port=app.port))[0] == 403


def test_cross_site_requests_and_post_requests_without_origin_are_rejected(app):
    assert app.request("POST", "/demo", b"", Origin=None)[0] == 403
    assert app.request("GET", "/", Sec_Fetch_Site="cross-site")[0] == 403
    assert app.request("GET", "/", Sec_Fetch_Site="same-site")[0] == 403
    assert app.request("GET", "/", Sec_Fetch_Site="same-origin")[0] == 200


def test_content_security_policy_blocks_external_and_unsafe_resources(app):
    _, headers, _ = app.request("GET", "/")
    assert "default-src 'none'" in headers["content-security-policy"]
    assert "unsafe" not in headers["content-security-policy"]
    assert headers["cache-control"] == "no-store"
    assert headers["x-content-type-options"] == "nosniff"


def test_server_listens_on_the_loopback_interface_only(app):
    with socket.socket() as client:
        client.settimeout(2)
        assert client.connect_ex(("127.0.0.1", int(app.port))) == 0
    with socket.socket() as client:
        client.settimeout(2)
        assert client.connect_ex((_network_address(), int(app.port))) != 0


def _network_address():
    """Return the network address of this computer, or an unused address if it has none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        try:
            client.connect(("198.51.100.1", 9))
        except OSError:
            return "198.51.100.1"
        return client.getsockname()[0]


@pytest.mark.parametrize(
    "name", ["../../etc/x", "..%2f..%2fx.csv", "/etc/cron.d/x", "..", "", "a\\..\\b.csv", "\0x.csv", "x" * 5000, "-r"]
)
def test_upload_with_any_file_name_stays_inside_the_upload_directory(app, name):
    paths_before = {path for path in app.directory.rglob("*") if "files" not in path.parts}
    status, _, body = app.request("PUT", f"/scans?name={quote(name)}", b"x (um),z (um)\n0,0\n1,1\n" + name.encode())
    assert status == 200
    (private_directory,) = app.find_private_directories()
    (stored_file,) = (private_directory / "files" / json.loads(body)["scan"]).iterdir()
    assert len(stored_file.name) <= 60
    assert {path for path in app.directory.rglob("*") if "files" not in path.parts} == paths_before


@pytest.mark.parametrize(
    "path", ["/jobs/1/../../etc/passwd", "/jobs/999/page.html", "/jobs/x/page.html", "/app.py",
             "/app.%2e%2e%2fserver.py", "/scans/../lock", "/scans/999", "/results/../../x"]
)  # fmt: skip
def test_requests_for_paths_outside_the_app_are_rejected(app, path):
    assert app.request("GET", path)[0] in (403, 404)


@pytest.mark.parametrize(
    "options",
    [
        {"command": "table", "options": []},
        {"command": "pair", "options": [["output", "/tmp/x"]], "upper": "1", "lower": "1"},
        {"command": "pair", "options": [["mu0", 3]], "upper": "1", "lower": "1"},
        {"command": "pair", "options": [], "upper": "../x", "lower": {}},
        {"command": "open", "name": "../.."},
        {"command": "open", "name": {}},
        {"command": "pair", "options": [3], "upper": {}, "lower": []},
        {"command": "run", "options": [["set", "x" * 300]]},
        {"command": "run", "options": [["set", 'surfaces={kind="measured",upper={file="/etc/passwd"}}']]},
        {"command": "run", "options": [["set", "surfaces.kind=measured"]]},
        {"command": "run", "options": [["set", "friction.interface=/etc/passwd"]]},
        {"command": "run", "options": [["set", "ensemble.seed=1\n[contact]"]]},
        [],
    ],
    ids=str,
)
def test_server_rejects_jobs_that_the_page_does_not_offer(app, options):
    assert app.request("POST", "/jobs", json.dumps(options).encode())[0] in (400, 404)
    assert app.list_jobs() == []


@pytest.mark.soak
@pytest.mark.parametrize(
    ("option", "text", "reason"),
    [
        ("mu0", "abc", '"μ0" must be one or more numbers'),
        ("mu0", "0,12", '"μ0" must not have a comma between digits'),
        ("hardness", "2±0,2 GPa", '"hardness" must not have a comma between digits'),
        ("load", "5 apples", '"load" must be a force or a pressure'),
        ("shifts", "0", '"positions" must be a whole number'),
        ("crop", "5", '"crop" of UPPER must be "x0,x1"'),
        ("junction-growth", "a", '"junction growth" must be a number'),
    ],
)
def test_invalid_form_entry_is_reported_with_its_option_name_and_adds_no_job(app, map_scans, option, text, reason):
    num_jobs = len(app.list_jobs())
    options = {"upper": "brass", "load": "1 MPa", "mu0": "0.2", "tau0": "20 MPa"} | {option: text}
    response = app.post_json("/jobs", {"command": "pair", "options": list(options.items()), **map_scans})
    assert response["option"] == option
    assert response["error"].startswith(reason)
    assert str(app.directory) not in response["error"]
    assert len(app.list_jobs()) == num_jobs


@pytest.fixture(scope="module")
def finished_pair_job(app, map_scans, tmp_path_factory):
    """Finished job of a pair with an interface file, two directions and two dwell times, and its study file."""
    path = tmp_path_factory.mktemp("interface") / "film.csv"
    write_interface(interface("MoS2 on bearing steel, dry air"), path)
    options = {"upper": "steel", "lower": "brass", "hardness": "1.2 GPa", "load": "10 MPa", "shifts": "1"}
    options |= {"direction": "0,90", "wait": "1 min,1 h", "creep": "0.03", "interface": app.upload(path)}
    job = app.post_json("/jobs", {"command": "pair", "options": list(options.items()), **map_scans})["job"]
    finished_job = wait_until(app.list_jobs, lambda jobs: jobs[-1]["state"] in ("done", "failed"))[-1]
    assert finished_job["state"] == "done", finished_job["error"]
    return finished_job, tomllib.loads(app.request("GET", f"/jobs/{job}/study.toml")[2].decode())


def test_job_uses_the_directions_dwell_times_and_creep_exponent_entered_in_the_web_form(finished_pair_job):
    _, study = finished_pair_job
    assert study["contact"]["direction"] == [0, 90]
    assert study["friction"]["wait"] == ["1 min", "1 h"]
    assert study["friction"]["creep"] == 0.03


def test_job_uses_an_uploaded_interface_file_and_shows_its_name_only(finished_pair_job):
    job, study = finished_pair_job
    assert "--interface=film.csv" in job["command"]
    assert study["friction"]["interface"]["file"] == "film.csv"


def test_shear_job_shows_an_interval_without_an_upper_limit(app, tmp_path):
    lower = self_affine_surface(1, hurst_exponent=0.8, rms=105.0, shape=(32, 32), spacing=50.0)
    request = {"command": "shear"}
    for body_name, face in (("upper", flipped(lower)), ("lower", lower)):
        write_surface(Surface(face.heights, spacing=face.spacing), tmp_path / f"{body_name}.csv")
        request[body_name] = app.upload(tmp_path / f"{body_name}.csv")
    options = {"young": "30 GPa", "poisson": "0.25", "load": "1 MPa", "mu0": "0.5..2", "path": "150 um"}
    app.post_json("/jobs", request | {"options": list(options.items())})
    finished_job = wait_until(app.list_jobs, lambda jobs: jobs[-1]["state"] in ("done", "failed"))[-1]
    assert finished_job["state"] == "done", finished_job["error"]
    assert [line["text"].endswith(", ∞)") for line in finished_job["answer"]["lines"]] == [True, True]


def test_request_that_specifies_the_interface_by_a_file_path_is_rejected(app, map_scans):
    request = {"command": "pair", "options": [["load", "1 MPa"], ["interface", "/etc/passwd"]], **map_scans}
    assert app.request("POST", "/jobs", json.dumps(request).encode())[0] == 400


@pytest.mark.parametrize("content", [b"mu0,tau0\n0.1,0.2\n", b"\xff\x00", b""])
def test_uploaded_file_that_is_no_interface_file_is_reported_next_to_its_form_field(app, map_scans, tmp_path, content):
    path = tmp_path / "other.csv"
    path.write_bytes(content)
    options = {"upper": "steel", "lower": "brass", "load": "10 MPa", "interface": app.upload(path)}
    response = app.post_json("/jobs", {"command": "pair", "options": list(options.items()), **map_scans})
    assert response["option"] == "interface"
    assert response["error"].startswith('"interface" other.csv is not an interface file')


def test_malformed_requests_print_nothing_in_the_terminal_of_the_server(tmp_path):
    with start_server(tmp_path, "--keep") as server:
        for _ in range(3):
            with socket.create_connection(("127.0.0.1", int(server.port))) as connection:
                connection.sendall(b"\x16\x03\x01 no request\r\n\r\n")
                assert b"400" in connection.recv(100)
        server.process.send_signal(signal.SIGTERM)
        assert server.process.stderr.read() == ""


def test_queued_job_shows_which_job_it_waits_for(tmp_path):
    queue = JobQueue(tmp_path)
    for number, state in enumerate(("done", "running", "waiting", "waiting"), 1):
        queue.jobs_by_number[number] = jobs.Job(number, f"pair {number}", ["pair"], tmp_path, state=state)
    assert [job["words"] for job in queue.page_data()] == ["", "", "waiting for pair 2", "waiting for pair 3"]


def test_oversized_upload_is_rejected_before_it_is_received(app):
    size = 3_000_000_000
    assert app.request("PUT", "/scans?name=x.npy", b"", Content_Length=str(size))[0] == 413
    num_sent_bytes = 0
    with socket.create_connection(("127.0.0.1", int(app.port)), timeout=60) as client:
        sent_headers = {
            "Host": f"127.0.0.1:{app.port}", "Origin": app.origin, "Cookie": app.cookie, "X-Stiction-Key": app.key,
            "Transfer-Encoding": "chunked",
        }  # fmt: skip
        header_lines = "".join(f"{name}: {value}\r\n" for name, value in sent_headers.items())
        client.sendall(f"PUT /scans?name=x.npy HTTP/1.1\r\n{header_lines}\r\n".encode())
        chunk = b"1000000\r\n" + bytes(2**24) + b"\r\n"
        try:
            while num_sent_bytes < size:
                client.sendall(chunk)
                num_sent_bytes += 2**24
        except OSError:
            pass
    assert num_sent_bytes < size / 5
    assert app.resident_memory() < MAX_SERVER_MEMORY
    assert (
        wait_until(
            lambda: list(app.find_private_directories()[0].glob("*.partial")), lambda partial_files: not partial_files
        )
        == []
    )
    assert app.is_alive()


def test_desktop_menu_entry_starts_the_app(app):
    (app.directory / "applications").touch()
    status, _, body = app.request("POST", "/menu", b"")
    assert (status, b"File exists" in body) == (400, True)
    (app.directory / "applications").unlink()
    status, _, body = app.request("POST", "/menu", b"")
    assert status == 200
    desktop_entry = (app.directory / "applications" / "stiction.desktop").read_text("utf-8")
    assert json.loads(body)["file"] == str(app.directory / "applications" / "stiction.desktop")
    arguments = dict(line.split("=", 1) for line in desktop_entry.splitlines()[1:])
    assert arguments["Path"] == str(app.directory)
    command = [*shlex.split(arguments["Exec"]), "--help"]
    assert "two scans" in subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_requests_with_invalid_or_oversized_bodies_are_rejected(app):
    assert app.request("POST", "/jobs", b"", Content_Length=str(10**6))[0] == 413
    assert app.request("POST", "/jobs", b"", Transfer_Encoding="chunked", Content_Length="2")[0] == 411
    assert app.request("POST", "/jobs", b"[" * 2**16)[0] == 400


@pytest.mark.soak
@pytest.mark.parametrize("name", ["bomb.x3p", "bomb.xlsx"])
def test_decompression_bomb_is_reported_as_a_read_error(app, name, tmp_path):
    path = tmp_path / name
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        member_name = "main.xml" if name.endswith("x3p") else "xl/worksheets/sheet1.xml"
        with archive.open(member_name, "w", force_zip64=True) as file:
            for _ in range(80):
                file.write(bytes(4_000_000))
    status, _, body = app.request("GET", f"/scans/{app.upload(path)}")
    assert status == 200
    assert json.loads(body)["error"].startswith(f"{name}: ")
    assert app.resident_memory() < MAX_SERVER_MEMORY
    assert app.is_alive()


@pytest.mark.soak
def test_server_survives_a_thousand_simultaneous_requests(app):
    def request_profiles(_):
        return app.request("GET", f"/profiles?set={quote('[]')}")[0]

    with ThreadPoolExecutor(250) as pool:
        statuses = list(pool.map(request_profiles, range(1000)))
    assert set(statuses) <= {200, 503}
    assert statuses.count(200) > 50
    assert app.resident_memory() < MAX_SERVER_MEMORY
    assert wait_until(app.is_alive, bool)


def test_temporary_directory_is_private_and_is_removed_when_the_server_stops(tmp_path):
    with start_server(tmp_path) as server:
        server.log_in()
        (private_directory,) = server.find_private_directories()
        assert stat.S_IMODE(private_directory.stat().st_mode) == 0o700
        server.post_json("/demo", {})
        server.process.send_signal(signal.SIGINT)
        assert server.process.wait(60) == 0
        assert server.find_private_directories() == []


@pytest.mark.soak
def test_unfinished_uploads_count_towards_the_storage_limit(app):
    header_lines = (
        f"Host: 127.0.0.1:{app.port}\r\nOrigin: {app.origin}\r\nCookie: {app.cookie}\r\nX-Stiction-Key: {app.key}"
    )
    (private_directory,) = app.find_private_directories()
    for _ in range(2):  # The second round of uploads succeeds only if the storage of the first round has been released.
        with ExitStack() as stack:
            for _ in range(6):
                client = stack.enter_context(socket.create_connection(("127.0.0.1", int(app.port))))
                client.sendall(
                    f"PUT /scans?name=x HTTP/1.1\r\n{header_lines}\r\nContent-Length: 300000000\r\n\r\n1".encode()
                )
            wait_until(lambda: len(list(private_directory.glob("*.partial"))), lambda count: count == 6)
            assert app.request("PUT", "/scans?name=x", b"", Content_Length="300000000")[0] == 413
        assert (
            wait_until(lambda: list(private_directory.glob("*.partial")), lambda partial_files: not partial_files) == []
        )


@pytest.mark.soak
def test_upload_to_a_full_disk_is_rejected_and_removed(app):
    limits = resource.prlimit(app.process.pid, resource.RLIMIT_FSIZE)
    resource.prlimit(app.process.pid, resource.RLIMIT_FSIZE, (10**5, limits[1]))
    try:
        status, _, body = app.request("PUT", "/scans?name=x.csv", bytes(3 * 10**6))
    finally:
        resource.prlimit(app.process.pid, resource.RLIMIT_FSIZE, limits)
    assert (status, b"File too large" in body) == (400, True)
    assert list(app.find_private_directories()[0].glob("*.partial")) == []


def test_result_with_undecodable_name_is_listed_but_not_opened(app):
    for name in (b"fine", b"bad\xff"):
        directory = os.path.join(os.fsencode(app.directory), name)
        os.makedirs(os.path.join(directory, b"blocks"))
        with open(os.path.join(directory, b"study.toml"), "wb"):
            pass
    status, _, body = app.request("GET", "/results")
    assert status == 200
    assert [entry["name"] for entry in json.loads(body)] == ["bad\N{REPLACEMENT CHARACTER}", "fine"]
    assert app.request("POST", "/jobs", b'{"command": "open", "name": "bad\\udcff"}')[0] == 404


@pytest.mark.soak
def test_stopped_jobs_with_blocked_previews_do_not_block_requests(app, tmp_path):
    """Stopped jobs end although the commands that compute their previews are blocked."""
    upper, lower = (app.upload(path) for path in write_maps(tmp_path))
    assert [app.request("GET", f"/scans/{scan}")[0] for scan in (upper, lower)] == [200, 200]
    options = [["young", "10 GPa"], ["poisson", "0.3"], ["mu0", "0.2"], ["load", "1 MPa"]]
    with app.block_commands(0):
        for num_shifts in range(2, 8):
            arguments = {
                "command": "pair",
                "upper": upper,
                "lower": lower,
                "options": [*options, ["shifts", f"{num_shifts}"]],
            }
            job = app.post_json("/jobs", arguments)["job"]
            wait_until(
                lambda: app.list_jobs()[-1]["words"], lambda progress_text: progress_text == "computing a preview"
            )
            app.post_json(f"/jobs/{job}/stop", {})
        assert app.request("GET", f"/scans/{upper}")[0] == 200
        wait_until(lambda: {item["state"] for item in app.list_jobs()[-6:]}, lambda states: states == {"stopped"})


@pytest.mark.parametrize("is_ending", [False, True])
def test_job_is_marked_as_stopped_before_the_server_reads_its_partial_result(tmp_path, monkeypatch, is_ending):
    async def run_job():
        has_started, has_begun_reading, may_continue = asyncio.Event(), asyncio.Event(), asyncio.Event()

        async def run_module(arguments, **_):
            (has_started if arguments[0] == "stiction" else has_begun_reading).set()
            await (asyncio.Event() if arguments[0] == "stiction" else may_continue).wait()
            return '{"answer": {}, "finished": 3, "total": 9}'

        monkeypatch.setattr("stiction.app.jobs.run_module", run_module)
        queue = JobQueue(tmp_path)
        job = queue.add("a pair", ["pair"])
        await has_started.wait()
        job.stop()
        await has_begun_reading.wait()
        assert (job.state, job.activity) == ("stopped", "reading the finished part")
        if is_ending:
            await asyncio.wait_for(queue.shut_down(), 60)
        else:
            may_continue.set()
            await job.task
        assert (job.state, job.finished) == ("stopped", 0 if is_ending else 3)
        assert is_ending or not job.activity

    asyncio.run(run_job())


@pytest.fixture
def fake_pair_command(monkeypatch):
    """Replace the command of a pair by a function that writes small files, and returns a record with two points."""
    json_points = [{"reported": False, "caveats": []}, {"reported": True, "caveats": [{"text": "use --tip"}]}]

    async def run_module(arguments, on_record=None, **_):
        if '"preview"' in arguments[1]:
            await asyncio.Event().wait()
        if arguments[0] != "stiction":
            return '{"answer": "finished part", "finished": 1, "total": 2}'
        assert arguments[1] == "pair"
        directory = Path(arguments[-1].removeprefix("--output="))
        run(Study.named("quick").with_changes(SMALL_ENSEMBLE), store=directory)
        for name in ("report.html", "result.csv"):
            (directory / name).write_text(f"{name} of {directory}")
        record = json.dumps({"command": str(directory), "points": json_points})
        on_record(record)
        if "--fail" in arguments:
            raise jobs.RejectedRequestError(f"{directory}/report.html: No space left on device")
        return record

    monkeypatch.setattr("stiction.app.jobs.run_module", run_module)


def test_finished_pair_job_shows_its_files_instead_of_a_slow_preview(tmp_path, fake_pair_command):
    async def run_job():
        queue = JobQueue(tmp_path)
        job = queue.add("a pair", ["pair"], preview=([], []))
        await job.task
        return job

    job = asyncio.run(run_job())
    assert (job.state, job.error, job.scope, job.finished, job.total) == ("done", "", "", 2, 2)
    assert job.record["reported"]
    assert "--tip" not in job.record["caveats"][0]["text"]
    texts = {file.name: file.read_text() for file in job.files.iterdir()}
    assert texts["page.html"].startswith("report.html of results/")
    assert set(texts) == {"page.html", "result.csv", "result.json", "study.toml"}
    assert not any(str(tmp_path) in text for text in texts.values())


def test_pair_job_whose_report_cannot_be_written_still_shows_its_result(tmp_path, fake_pair_command):
    async def run_job():
        job = JobQueue(tmp_path).add("a pair", ["pair", "--fail"], preview=([], []))
        await job.task
        return job

    job = asyncio.run(run_job())
    assert (job.state, job.scope, job.files, job.page_data()["versions"]) == ("failed", "", None, 0)
    assert job.record["reported"]
    assert job.error.startswith("the report of this result could not be written: results/")
    assert job.error.endswith("/report.html: No space left on device")


def test_values_of_a_finished_pair_job_are_not_replaced_by_an_intermediate_result(tmp_path, monkeypatch):
    """The progress must not be checked after the command has printed its values, even while it still draws."""

    async def run_module(arguments, on_record=None, **_):
        if arguments[0] != "stiction":
            return '{"answer": "intermediate result", "finished": 8, "total": 16}'
        on_record('{"points": [{"reported": true, "caveats": []}]}')
        await asyncio.sleep(0.2)
        raise jobs.RejectedRequestError("the command ended")

    async def run_job():
        job = JobQueue(tmp_path).add("a pair", ["pair"])
        await job.task
        return job

    ensemble = SimpleNamespace(repetitions=16)
    stored_result = SimpleNamespace(num_finished=8, study=SimpleNamespace(ensemble=ensemble))
    monkeypatch.setattr("stiction.app.jobs.run_module", run_module)
    monkeypatch.setattr(jobs, "open_stored_result", lambda _: stored_result)
    monkeypatch.setattr(jobs, "POLL_INTERVAL", 0.02)
    job = asyncio.run(run_job())
    assert (job.record["reported"], job.scope) == (True, "")
    assert job.error == "the report of this result could not be written: the command ended"


@pytest.mark.parametrize("failing_source", ["preview", "directory"])
def test_unexpected_error_in_preview_or_progress_is_logged_while_the_command_continues(
    tmp_path, monkeypatch, caplog, failing_source
):
    """The preview or the monitor of the progress fails, before the command ends."""

    async def run_module(arguments, on_record=None, **_):
        if arguments[0] != "stiction":
            return json.dumps({"answer": {}, "finished": 1, "total": 9} if failing_source == "directory" else {})
        while not caplog.records:
            await asyncio.sleep(0.01)
        on_record('{"points": [{"reported": true, "caveats": []}]}')
        raise jobs.RejectedRequestError("the command ended")

    def open_stored_result(directory):
        raise AttributeError(f"no attribute of {directory.name}") if failing_source == "directory" else ValueError

    async def run_job():
        job = JobQueue(tmp_path).add("a pair", ["pair"], preview=([], []))
        await asyncio.wait_for(job.task, 60)
        return job

    monkeypatch.setattr("stiction.app.jobs.run_module", run_module)
    monkeypatch.setattr(jobs, "open_stored_result", open_stored_result)
    assert asyncio.run(run_job()).error.endswith("the command ended")
    (record,) = caplog.records
    assert record.levelname == "ERROR"
    assert record.exc_info[0] is {"preview": KeyError, "directory": AttributeError}[failing_source]


def test_job_with_an_unexpected_error_fails_with_a_message_and_is_logged(tmp_path, monkeypatch, caplog):
    async def run_module(arguments, **_):
        raise KeyError(arguments[0])

    async def run_job():
        job = JobQueue(tmp_path).add("a pair", ["pair"])
        await asyncio.gather(job.task, return_exceptions=True)
        return job

    monkeypatch.setattr("stiction.app.jobs.run_module", run_module)
    job = asyncio.run(run_job())
    assert (job.state, job.activity) == ("failed", "")
    assert "unexpected error" in job.error
    (record,) = caplog.records
    assert record.exc_info[0] is KeyError


def test_command_and_its_preview_together_use_at_most_the_memory_of_the_machine(tmp_path, monkeypatch):
    memory_fractions = {}

    async def run_module(arguments, memory, **_):
        kind = "preview" if '"preview"' in arguments[1] else arguments[0]
        memory_fractions[kind] = memory
        if kind == "preview":
            return "null"
        await asyncio.sleep(0.1)
        raise jobs.RejectedRequestError("the command failed")

    async def run_job():
        job = JobQueue(tmp_path).add("a pair", ["pair"], preview=([], []))
        await job.task
        return job

    monkeypatch.setattr("stiction.app.jobs.run_module", run_module)
    assert asyncio.run(run_job()).error == "the command failed"
    assert set(memory_fractions) == {"preview", "stiction"}
    assert sum(memory_fractions.values()) < 1


def test_pair_job_that_is_stopped_while_its_files_are_copied_shows_its_stored_result(
    tmp_path, monkeypatch, fake_pair_command
):
    copying_started, may_continue, open_stored_result = threading.Event(), threading.Event(), jobs.open_stored_result

    def open_after_signal(directory):
        if threading.current_thread() is not threading.main_thread() and (directory / "report.html").exists():
            copying_started.set()
            assert may_continue.wait(60)
        return open_stored_result(directory)

    async def run_job():
        queue = JobQueue(tmp_path)
        job = queue.add("a pair", ["pair"])
        await asyncio.to_thread(copying_started.wait, 60)
        job.stop()
        await job.task
        may_continue.set()
        await asyncio.get_running_loop().shutdown_default_executor()
        return job

    monkeypatch.setattr(jobs, "open_stored_result", open_after_signal)
    job = asyncio.run(run_job())
    assert (job.state, job.record, job.finished, job.versions) == ("stopped", "finished part", 1, 2)


def test_cancelled_task_ends_only_after_its_subprocess_has_ended(monkeypatch):
    async def run_job():
        processes, original_create = [], asyncio.create_subprocess_exec

        async def create_process(*arguments, **options):
            processes.append(await original_create(*arguments, **options))
            return processes[-1]

        monkeypatch.setattr("asyncio.create_subprocess_exec", create_process)
        task = asyncio.create_task(run_module(["http.server", "0"], memory=0.5))
        while not processes:
            await asyncio.sleep(0.01)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        assert processes[0].returncode is not None

    asyncio.run(run_job())


@pytest.mark.parametrize(
    "statement",
    ["from stiction._core import missing_name", "from stiction import _core; _core.missing_name()"],
    ids=["import", "call"],
)
def test_module_of_the_app_reports_a_compiled_core_that_does_not_fit_the_python_files(statement):
    with pytest.raises(RejectedRequestError, match=r"^the compiled part of stiction \(_core\) does not fit .* build"):
        asyncio.run(run_module(["timeit", "--number=1", statement], memory=0.5))


def test_profile_preview_rejects_studies_of_measured_surfaces(app):
    changes = quote(json.dumps({"surfaces": {"kind": "measured", "upper": {"file": "/etc/passwd"}}}))
    assert app.request("GET", f"/profiles?set={changes}")[0] == 400


def test_server_answers_requests_despite_many_idle_connections(tmp_path):
    with start_server(tmp_path, "--keep") as server, ExitStack() as stack:
        server.log_in()
        # Wait, because the event loop accepts several batches of connections before it closes the oldest ones.
        resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (512, 512))
        for _ in range(800):
            idle_connection = stack.enter_context(socket.create_connection(("127.0.0.1", int(server.port)), timeout=60))
            idle_connection.sendall(b"GET / HTTP/1.1\r\n")
        assert [server.request("GET", "/jobs")[0] for _ in range(3)] == [200, 200, 200]
        server.process.send_signal(signal.SIGTERM)
        assert server.process.wait(60) == 0
        assert server.process.stderr.read() == ""


def test_server_at_its_request_limit_rejects_further_requests_with_a_message(app):
    header_lines = (
        f"Host: 127.0.0.1:{app.port}\r\nOrigin: {app.origin}\r\nCookie: {app.cookie}\r\nX-Stiction-Key: {app.key}"
    )
    (private_directory,) = app.find_private_directories()
    with ExitStack() as stack:
        for _ in range(MAX_CONCURRENT_REQUESTS):
            client = stack.enter_context(socket.create_connection(("127.0.0.1", int(app.port))))
            client.sendall(f"PUT /scans?name=x HTTP/1.1\r\n{header_lines}\r\nContent-Length: 9\r\n\r\n1".encode())
        wait_until(
            lambda: len(list(private_directory.glob("*.partial"))), lambda count: count == MAX_CONCURRENT_REQUESTS
        )
        status, _, body = app.request("GET", "/jobs")
        assert (status, f"already has {MAX_CONCURRENT_REQUESTS} requests" in body.decode()) == (503, True)
        assert app.request("GET", "/jobs", cookie="")[0] == 403
    assert wait_until(lambda: app.request("GET", "/jobs")[0], lambda status: status == 200)


def test_response_that_takes_too_long_is_replaced_by_a_timeout_message(tmp_path, monkeypatch):
    monkeypatch.setattr(server, "MAX_REQUEST_TIME", 0.05)
    app = server.Server(tmp_path, tmp_path, 1)
    monkeypatch.setattr(app, "_rejection_response", lambda request: None)
    monkeypatch.setattr(app, "_app", lambda *_: asyncio.Event().wait())
    messages = []

    async def record_message(message):
        messages.append(message)

    asyncio.run(app({"type": "http", "method": "GET", "path": "/jobs", "headers": []}, None, record_message))
    assert messages[0]["status"] == 503
    assert b"took longer" in messages[1]["body"]


def test_server_prints_no_traceback_if_terminated_during_requests_and_jobs(tmp_path):
    with start_server(tmp_path, "--keep") as server, server.block_commands(0):
        server.log_in()
        upper, lower = (server.upload(path) for path in write_maps(tmp_path))
        options = [["young", "10 GPa"], ["poisson", "0.3"], ["mu0", "0.2"], ["load", "1 MPa"]]
        for seed in range(3):
            arguments = {
                "command": "pair",
                "upper": upper,
                "lower": lower,
                "options": [*options, ["shifts", f"{seed + 2}"]],
            }
            server.post_json("/jobs", arguments)
        wait_until(server.list_jobs, lambda jobs: jobs[0]["total"])
        with ThreadPoolExecutor(8) as pool:
            responses = [pool.submit(server.request, "GET", f"/scans/{upper}") for _ in range(8)]
            server.process.send_signal(signal.SIGTERM)
            assert server.process.wait(60) == 0
            assert all(
                future_response.exception() or future_response.result()[0] in (200, 503)
                for future_response in responses
            )
        assert server.process.stderr.read() == ""


def test_job_of_a_killed_command_fails_with_the_name_of_the_signal(tmp_path):
    with start_server(tmp_path, "--keep") as server:
        server.log_in()
        upper, lower = (server.upload(path) for path in write_maps(tmp_path))
        options = [["young", "10 GPa"], ["poisson", "0.3"], ["mu0", "0.2"], ["load", "1 MPa"]]
        with server.block_commands(0):
            server.post_json("/jobs", {"command": "pair", "upper": upper, "lower": lower, "options": options})
            wait_until(server.list_jobs, lambda jobs: jobs[0]["total"])
            for process_id in _list_child_process_ids(server.process.pid):
                memory_bytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
                assert resource.prlimit(process_id, resource.RLIMIT_DATA)[0] <= 0.5 * memory_bytes
                os.kill(process_id, signal.SIGKILL)
            (job,) = wait_until(server.list_jobs, lambda jobs: jobs[0]["state"] == "failed")
        assert "SIGKILL" in job["error"]


def _list_child_process_ids(parent_id):
    process_ids = []
    for status_file in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # a listed process may have ended before its status is read
            if int(status_file.read_text(encoding="utf-8").rpartition(")")[2].split()[1]) == parent_id:
                process_ids.append(int(status_file.parent.name))
    return process_ids
