"""Start a server of `stiction app`, and send it arbitrary requests."""

import contextlib
import http.client
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import quote

from stiction import self_affine_surface, write_surface

MAX_WAITING_SECONDS = 60.0
BLOCKING_SITECUSTOMIZE_DIRECTORY = Path(__file__).parent / "member_block"


class ServerProcess:
    """Server process with its address, cookie and key."""

    def __init__(self, process, directory):
        self.process, self.directory, self.cookie, self.key = process, directory, "", ""
        start_message = process.stderr.readline() + process.stderr.readline()
        self.port, self.token = re.search(r"http://127\.0\.0\.1:(\d+)/\?token=(\S+)", start_message).groups()
        self.origin = f"http://127.0.0.1:{self.port}"
        self.address = f"{self.origin}/?token={self.token}"

    def request(self, method, path, body=None, *, cookie=None, **headers):
        """Send a request, and return the status, headers and body of the response.

        By default the request has the headers that the page of the app sends; a header of None is omitted.
        """
        sent_headers = {"Host": f"127.0.0.1:{self.port}", "Cookie": self.cookie if cookie is None else cookie}
        sent_headers |= {"X-Stiction-Key": self.key}
        sent_headers |= {} if method == "GET" else {"Origin": self.origin}
        sent_headers |= {name.replace("_", "-"): value for name, value in headers.items()}
        connection = http.client.HTTPConnection("127.0.0.1", int(self.port), timeout=MAX_WAITING_SECONDS)
        with contextlib.closing(connection):
            connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
            for name, value in sent_headers.items():
                if value is not None:
                    connection.putheader(name, value)
            if body is not None and "Content-Length" not in sent_headers:
                connection.putheader("Content-Length", str(len(body)))
            connection.endheaders(body)
            response = connection.getresponse()
            return response.status, response.headers, response.read()

    def log_in(self):
        """Log in with the token in the address of the server, and return the header that sets the cookie."""
        status, headers, _ = self.request("GET", f"/?token={self.token}")
        assert status == 303
        self.cookie = headers["Set-Cookie"].split(";")[0]
        self.key = headers["Location"].removeprefix("/#")
        return headers["Set-Cookie"]

    def post_json(self, path, content):
        status, _, body = self.request("POST", path, json.dumps(content).encode())
        assert status == 200, body
        return json.loads(body)

    def upload(self, path):
        """Upload a scan file and return its identifier."""
        status, _, body = self.request("PUT", f"/scans?name={quote(path.name)}", path.read_bytes())
        assert status == 200, body
        return json.loads(body)["scan"]

    def list_jobs(self):
        """Return the list of jobs as the server sends it to the page."""
        return json.loads(self.request("GET", "/jobs")[2])

    def resident_memory(self):
        """Return the resident memory of the server process in bytes."""
        with open(f"/proc/{self.process.pid}/statm", encoding="utf-8") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    def is_alive(self):
        return self.process.poll() is None and self.request("GET", "/")[0] == 200

    @contextlib.contextmanager
    def block_commands(self, member):
        """Block commands at the given ensemble member until the context ends."""
        blocking_file = self.directory / "hold"
        blocking_file.write_text(str(member))
        try:
            yield blocking_file.unlink
        finally:
            blocking_file.unlink(missing_ok=True)

    def find_private_directories(self):
        """Return the private working directories of the servers."""
        return sorted((self.directory / "tmp").glob("stiction-app-*"))


def wait_until(compute_value, is_met):
    """Compute a value repeatedly until it meets a condition, and return it."""
    deadline = time.monotonic() + 10 * MAX_WAITING_SECONDS
    while not is_met(latest_value := compute_value()):
        assert time.monotonic() < deadline, latest_value
        time.sleep(0.1)
    return latest_value


@contextlib.contextmanager
def start_server(directory, *options, code=""):
    """Start a server in a directory, which also contains its temporary files.

    The server is started by the command `stiction app`, or by `code` if it is given.
    """
    (directory / "tmp").mkdir(exist_ok=True)
    arguments = ["-c", code] if code else ["-m", "stiction", "app", *options]
    environment = {"TMPDIR": directory / "tmp", "BROWSER": "true", "XDG_DATA_HOME": directory}
    environment |= {"PYTHONPATH": BLOCKING_SITECUSTOMIZE_DIRECTORY, "STICTION_TEST_HOLD": directory / "hold"}
    process = subprocess.Popen(
        [sys.executable, *arguments], cwd=directory, stderr=subprocess.PIPE, text=True,
        env=os.environ | {name: str(value) for name, value in environment.items()},
    )  # fmt: skip
    try:
        yield ServerProcess(process, directory)
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
        try:
            process.wait(MAX_WAITING_SECONDS)
        finally:
            process.kill()
            process.stderr.close()


def write_maps(directory, num_rows=24):
    """Write two small rough height maps, and return their paths."""
    paths = []
    for side in ("upper", "lower"):
        surface = self_affine_surface(
            5, hurst_exponent=0.8, rms=0.02, shape=(num_rows, num_rows), spacing=0.1, side=side
        )
        paths.append(directory / f"{side}_face.csv")
        write_surface(surface, paths[-1])
    return paths
