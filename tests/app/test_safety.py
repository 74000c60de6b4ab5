"""Tests of access control and limits of the server, with requests that no browser would send."""

import asyncio
import json
import os
import resource
import shlex
import signal
import socket
import stat
import subprocess
import zipfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from pathlib import Path
from urllib.parse import quote

import pytest

pytest.importorskip("starlette", reason="the extra app is not installed")

from app.served import served, until, write_maps
from stiction.app.jobs import Jobs, run_module

MAX_RESULT_BYTES = 400e6  # bytes: it has xarray and its own pages, and reads a scan at a time


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    with served(tmp_path_factory.mktemp("app"), "--keep") as server:
        server.cookie_line = server.enter()
        yield server


def test_token_is_valid_once_and_cookie_is_protected(app):
    assert "HttpOnly" in app.cookie_line
    assert "samesite=strict" in app.cookie_line.lower()
    assert app.ask("GET", f"/?token={app.token}", cookie="")[0] == 403


@pytest.mark.parametrize(
    "path",
    ["/", "/app.js", "/jobs", "/results", "/jobs/1/page.html", "/scans/upper/upper.csv", "/?token=x", "/?token="],
)
@pytest.mark.parametrize("cookie", ["", "stiction-1=x", "stiction-{port}=wrong"])
def test_requests_without_cookie_are_rejected(app, path, cookie):
    status, _, body = app.ask("GET", path, cookie=cookie.format(port=app.port))
    assert status == 403
    assert len(body) < 200


@pytest.mark.parametrize("host", ["evil.example", "localhost:{port}", "127.0.0.1", "127.0.0.1:1", "", None])
def test_requests_with_other_host_names_are_rejected(app, host):
    """As pages have that let their name mean 127.0.0.1."""
    status, _, _ = app.ask("GET", "/", Host=host and host.format(port=app.port))
    assert status in (400, 421)


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1:{port}"])
def test_requests_from_other_origins_are_rejected(app, origin):
    for method, path in (("GET", "/"), ("POST", "/demo"), ("POST", "/jobs"), ("PUT", "/scans?name=a.csv")):
        assert app.ask(method, path, b"{}", Origin=origin.format(port=app.port))[0] == 403


def test_changes_require_origin_and_reading_same_site(app):
    assert app.ask("POST", "/demo", b"", Origin=None)[0] == 403
    assert app.ask("GET", "/", Sec_Fetch_Site="cross-site")[0] == 403
    assert app.ask("GET", "/", Sec_Fetch_Site="same-site")[0] == 403
    assert app.ask("GET", "/", Sec_Fetch_Site="same-origin")[0] == 200


def test_content_security_policy_allows_own_resources_only(app):
    _, headers, _ = app.ask("GET", "/")
    assert "default-src 'none'" in headers["content-security-policy"]
    assert "unsafe" not in headers["content-security-policy"]
    assert headers["cache-control"] == "no-store"
    assert headers["x-content-type-options"] == "nosniff"


def test_server_listens_on_loopback_only(app):
    with socket.socket() as client:
        client.settimeout(2)
        assert client.connect_ex(("127.0.0.1", int(app.port))) == 0
    with socket.socket() as client:
        client.settimeout(2)
        assert client.connect_ex((_own_address(), int(app.port))) != 0


def _own_address():
    """Return the network address of this computer, or an unused address if it has none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as some:
        try:
            some.connect(("198.51.100.1", 9))
        except OSError:
            return "198.51.100.1"
        return some.getsockname()[0]


@pytest.mark.parametrize(
    "name", ["../../etc/x", "..%2f..%2fx.csv", "/etc/cron.d/x", "..", "", "a\\..\\b.csv", "\0x.csv", "x" * 5000, "-r"]
)
def test_names_of_scans_are_not_used_as_paths(app, name):
    before = {path for path in app.folder.rglob("*") if "files" not in path.parts}
    status, _, body = app.ask("PUT", f"/scans?name={quote(name)}", b"x (um),z (um)\n0,0\n1,1\n" + name.encode())
    assert status == 200
    (root,) = app.private()
    (stored,) = (root / "files" / json.loads(body)["scan"]).iterdir()
    assert len(stored.name) <= 60
    assert {path for path in app.folder.rglob("*") if "files" not in path.parts} == before


@pytest.mark.parametrize(
    "path", ["/jobs/1/../../etc/passwd", "/jobs/999/page.html", "/jobs/x/page.html", "/app.py",
             "/app.%2e%2e%2fserver.py", "/scans/../lock", "/scans/999", "/results/../../x"]
)  # fmt: skip
def test_paths_outside_the_app_are_rejected(app, path):
    assert app.ask("GET", path)[0] in (403, 404)


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
        {"command": "run", "options": [["set", "known.interface=/etc/passwd"]]},
        {"command": "run", "options": [["set", "ensemble.seed=1\n[known]"]]},
        [],
    ],
    ids=str,
)
def test_jobs_reject_commands_that_the_page_does_not_offer(app, options):
    assert app.ask("POST", "/jobs", json.dumps(options).encode())[0] in (400, 404)
    assert app.jobs() == []


@pytest.mark.soak
def test_oversized_upload_is_rejected_before_it_is_received(app):
    size = 3_000_000_000
    assert app.ask("PUT", "/scans?name=x.npy", b"", Content_Length=str(size))[0] == 413
    sent = 0
    with socket.create_connection(("127.0.0.1", int(app.port)), timeout=60) as client:
        own = {
            "Host": f"127.0.0.1:{app.port}", "Origin": app.origin, "Cookie": app.cookie, "X-Stiction-Key": app.key,
            "Transfer-Encoding": "chunked",
        }  # fmt: skip
        head = "".join(f"{name}: {value}\r\n" for name, value in own.items())
        client.sendall(f"PUT /scans?name=x.npy HTTP/1.1\r\n{head}\r\n".encode())
        piece = b"1000000\r\n" + bytes(2**24) + b"\r\n"
        try:
            while sent < size:
                client.sendall(piece)
                sent += 2**24
        except OSError:
            pass
    assert sent < size / 5
    assert app.memory() < MAX_RESULT_BYTES
    assert until(lambda: list(app.private()[0].glob("*.partial")), lambda left: not left) == []
    assert app.is_alive()


def test_menu_entry_starts_the_app(app):
    (app.folder / "applications").touch()
    assert app.ask("POST", "/menu", b"")[::2] == (400, b"applications cannot be written: File exists")
    (app.folder / "applications").unlink()
    status, _, body = app.ask("POST", "/menu", b"")
    assert status == 200
    entry = (app.folder / "applications" / "stiction.desktop").read_text("utf-8")
    assert json.loads(body)["file"] == str(app.folder / "applications" / "stiction.desktop")
    arguments = dict(line.split("=", 1) for line in entry.splitlines()[1:])
    assert arguments["Path"] == str(app.folder)
    command = [*shlex.split(arguments["Exec"]), "--help"]
    assert "two scans" in subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_request_bodies_are_limited(app):
    assert app.ask("POST", "/jobs", b"", Content_Length=str(10**6))[0] == 413
    assert app.ask("POST", "/jobs", b"", Transfer_Encoding="chunked", Content_Length="2")[0] == 411
    assert app.ask("POST", "/jobs", b"[" * 2**16)[0] == 400


@pytest.mark.soak
@pytest.mark.parametrize("name", ["bomb.x3p", "bomb.xlsx"])
def test_decompression_bomb_is_reported_in_a_sentence(app, name, tmp_path):
    path = tmp_path / name
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        inside = "main.xml" if name.endswith("x3p") else "xl/worksheets/sheet1.xml"
        with archive.open(inside, "w", force_zip64=True) as file:
            for _ in range(80):
                file.write(bytes(4_000_000))
    status, _, body = app.ask("GET", f"/scans/{app.take(path)}")
    assert status == 200
    assert json.loads(body)["error"].startswith(f"{name}: ")
    assert app.memory() < MAX_RESULT_BYTES
    assert app.is_alive()


@pytest.mark.soak
def test_simultaneous_requests_are_answered_or_rejected(app):
    def ask(_):
        try:
            return app.ask("GET", "/")[0]
        except OSError:
            return "refused"

    with ThreadPoolExecutor(250) as pool:
        result = list(pool.map(ask, range(1000)))
    assert set(result) <= {200, "refused"}
    assert result.count(200) > 50
    assert app.memory() < MAX_RESULT_BYTES
    assert until(app.is_alive, bool)


def test_working_directory_is_private_and_removed(tmp_path):
    with served(tmp_path) as server:
        server.enter()
        (root,) = server.private()
        assert stat.S_IMODE(root.stat().st_mode) == 0o700
        server.post("/demo", {})
        server.process.send_signal(signal.SIGINT)
        assert server.process.wait(60) == 0
        assert server.private() == []


@pytest.mark.soak
def test_uploads_count_towards_the_limit_while_they_arrive(app):
    head = f"Host: 127.0.0.1:{app.port}\r\nOrigin: {app.origin}\r\nCookie: {app.cookie}\r\nX-Stiction-Key: {app.key}"
    (root,) = app.private()
    for _ in range(2):  # and no longer
        with ExitStack() as stack:
            for _ in range(6):
                client = stack.enter_context(socket.create_connection(("127.0.0.1", int(app.port))))
                client.sendall(f"PUT /scans?name=x HTTP/1.1\r\n{head}\r\nContent-Length: 300000000\r\n\r\n1".encode())
            until(lambda: len(list(root.glob("*.partial"))), lambda count: count == 6)
            assert app.ask("PUT", "/scans?name=x", b"", Content_Length="300000000")[0] == 413
        assert until(lambda: list(root.glob("*.partial")), lambda left: not left) == []


@pytest.mark.soak
def test_upload_on_full_disk_is_reported_in_a_sentence(app):
    limits = resource.prlimit(app.process.pid, resource.RLIMIT_FSIZE)
    resource.prlimit(app.process.pid, resource.RLIMIT_FSIZE, (10**5, limits[1]))
    try:
        status, _, body = app.ask("PUT", "/scans?name=x.csv", bytes(3 * 10**6))
    finally:
        resource.prlimit(app.process.pid, resource.RLIMIT_FSIZE, limits)
    assert (status, body) == (400, b"the scan cannot be stored: File too large")
    assert list(app.private()[0].glob("*.partial")) == []


def test_results_with_undecodable_names_are_listed(app):
    for name in (b"fine", b"bad\xff"):
        folder = os.path.join(os.fsencode(app.folder), name)
        os.makedirs(os.path.join(folder, b"blocks"))
        with open(os.path.join(folder, b"study.toml"), "wb"):
            pass
    status, _, body = app.ask("GET", "/results")
    assert status == 200
    assert [load["name"] for load in json.loads(body)] == ["bad\N{REPLACEMENT CHARACTER}", "fine"]
    assert app.ask("POST", "/jobs", b'{"command": "open", "name": "bad\\udcff"}')[0] == 404


@pytest.mark.soak
def test_stopped_first_results_do_not_block_requests(app, tmp_path):
    """Nothing that computes goes on meanwhile: they end without it."""
    upper, lower = (app.take(path) for path in write_maps(tmp_path))
    assert [app.ask("GET", f"/scans/{each}")[0] for each in (upper, lower)] == [200, 200]
    options = [["young", "10 GPa"], ["poisson", "0.3"], ["mu0", "0.2"], ["load", "1 MPa"]]
    with app.held(0):
        for shifts in range(2, 8):
            arguments = {
                "command": "pair",
                "upper": upper,
                "lower": lower,
                "options": [*options, ["shifts", f"{shifts}"]],
            }
            job = app.post("/jobs", arguments)["job"]
            until(lambda: app.jobs()[-1]["words"], lambda words: words == "computing a preview")
            app.post(f"/jobs/{job}/stop", {})
        assert app.ask("GET", f"/scans/{upper}")[0] == 200
        until(lambda: {item["state"] for item in app.jobs()[-6:]}, lambda states: states == {"stopped"})


@pytest.mark.parametrize("is_ending", [False, True])
def test_stopped_job_has_its_state_before_its_result_is_read(tmp_path, monkeypatch, is_ending):
    async def check():
        started, reading, released = asyncio.Event(), asyncio.Event(), asyncio.Event()

        async def run_module(arguments, **_):
            (started if arguments[0] == "stiction" else reading).set()
            await (asyncio.Event() if arguments[0] == "stiction" else released).wait()
            return '{"answer": {}, "finished": 3, "total": 9}'

        monkeypatch.setattr("stiction.app.jobs.run_module", run_module)
        queue = Jobs(tmp_path)
        job = queue.add("a pair", ["pair"])
        await started.wait()
        job.stop()
        await reading.wait()
        assert (job.state, job.activity) == ("stopped", "reading the finished part")
        if is_ending:
            await asyncio.wait_for(queue.end(), 60)
        else:
            released.set()
            await job.task
        assert (job.state, job.finished) == ("stopped", 0 if is_ending else 3)
        assert is_ending or not job.activity

    asyncio.run(check())


def test_cancelled_module_has_ended_when_its_task_ends(monkeypatch):
    async def check():
        processes, create = [], asyncio.create_subprocess_exec

        async def create_process(*arguments, **options):
            processes.append(await create(*arguments, **options))
            return processes[-1]

        monkeypatch.setattr("asyncio.create_subprocess_exec", create_process)
        task = asyncio.create_task(run_module(["http.server", "0"], memory=0.5))
        while not processes:
            await asyncio.sleep(0.01)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        assert processes[0].returncode is not None

    asyncio.run(check())


def test_sketch_of_measured_surfaces_is_rejected(app):
    changes = quote(json.dumps({"surfaces": {"kind": "measured", "upper": {"file": "/etc/passwd"}}}))
    assert app.ask("GET", f"/profiles?set={changes}")[0] == 400


def test_idle_connections_leave_file_descriptors_for_the_owner(tmp_path):
    with served(tmp_path, "--keep") as server, ExitStack() as stack:
        server.enter()
        resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (256, 256))
        for _ in range(400):
            idle = stack.enter_context(socket.create_connection(("127.0.0.1", int(server.port)), timeout=5))
            idle.sendall(b"GET / HTTP/1.1\r\n")
        assert [server.ask("GET", "/jobs")[0] for _ in range(3)] == [200, 200, 200]
        server.process.send_signal(signal.SIGTERM)
        assert server.process.wait(30) == 0
        assert server.process.stderr.read() == ""


def test_server_ends_without_traceback_during_requests_and_jobs(tmp_path):
    with served(tmp_path, "--keep") as server, server.held(0):
        server.enter()
        upper, lower = (server.take(path) for path in write_maps(tmp_path))
        options = [["young", "10 GPa"], ["poisson", "0.3"], ["mu0", "0.2"], ["load", "1 MPa"]]
        for seed in range(3):
            arguments = {
                "command": "pair",
                "upper": upper,
                "lower": lower,
                "options": [*options, ["shifts", f"{seed + 2}"]],
            }
            server.post("/jobs", arguments)
        until(server.jobs, lambda jobs: jobs[0]["total"])
        with ThreadPoolExecutor(8) as pool:
            answers = [pool.submit(server.ask, "GET", f"/scans/{upper}") for _ in range(8)]
            server.process.send_signal(signal.SIGTERM)
            assert server.process.wait(30) == 0
            assert all(answer.exception() or answer.result()[0] in (200, 503) for answer in answers)
        assert server.process.stderr.read() == ""


def test_killed_command_is_reported(tmp_path):
    with served(tmp_path, "--keep") as server:
        server.enter()
        upper, lower = (server.take(path) for path in write_maps(tmp_path))
        options = [["young", "10 GPa"], ["poisson", "0.3"], ["mu0", "0.2"], ["load", "1 MPa"]]
        with server.held(0):
            server.post("/jobs", {"command": "pair", "upper": upper, "lower": lower, "options": options})
            until(server.jobs, lambda jobs: jobs[0]["total"])
            for child in _children(server.process.pid):
                total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
                assert resource.prlimit(child, resource.RLIMIT_DATA)[0] <= 0.5 * total
                os.kill(child, signal.SIGKILL)
            (job,) = until(server.jobs, lambda jobs: jobs[0]["state"] == "failed")
        assert job["error"] == "the system ended the command (SIGKILL); memory may be insufficient"


def _children(parent):
    values = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # which has ended meanwhile
            if int(status.read_text(encoding="utf-8").rpartition(")")[2].split()[1]) == parent:
                values.append(int(status.parent.name))
    return values
