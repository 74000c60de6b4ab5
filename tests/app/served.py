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

import numpy as np
from stiction import Surface, self_affine_surface, write_surface

PATIENCE = 60.0
HELD = Path(__file__).parent / "held"


class Served:
    """Server process with its address, cookie and key."""

    def __init__(self, process, folder):
        self.process, self.folder, self.cookie, self.key = process, folder, "", ""
        message = process.stderr.readline() + process.stderr.readline()
        self.port, self.token = re.search(r"http://127\.0\.0\.1:(\d+)/\?token=(\S+)", message).groups()
        self.origin = f"http://127.0.0.1:{self.port}"
        self.address = f"{self.origin}/?token={self.token}"

    def ask(self, method, path, body=None, *, cookie=None, **headers):
        """Return status, headers and body of a request; headers default to those of the page, None leaves one out."""
        own = {"Host": f"127.0.0.1:{self.port}", "Cookie": self.cookie if cookie is None else cookie}
        own |= {"X-Stiction-Key": self.key}
        own |= {} if method == "GET" else {"Origin": self.origin}
        own |= {name.replace("_", "-"): value for name, value in headers.items()}
        connection = http.client.HTTPConnection("127.0.0.1", int(self.port), timeout=PATIENCE)
        with contextlib.closing(connection):
            connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
            for name, value in own.items():
                if value is not None:
                    connection.putheader(name, value)
            if body is not None and "Content-Length" not in own:
                connection.putheader("Content-Length", str(len(body)))
            connection.endheaders(body)
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read()

    def enter(self):
        """Open the address as a browser would."""
        status, headers, _ = self.ask("GET", f"/?token={self.token}")
        assert status == 303
        self.cookie = headers["Set-Cookie"].split(";")[0]
        self.key = headers["Location"].removeprefix("/#")
        return headers["Set-Cookie"]

    def post(self, path, asked):
        status, _, body = self.ask("POST", path, json.dumps(asked).encode())
        assert status == 200, body
        return json.loads(body)

    def take(self, path):
        """Upload a file, and return its identifier."""
        status, _, body = self.ask("PUT", f"/scans?name={quote(path.name)}", path.read_bytes())
        assert status == 200, body
        return json.loads(body)["scan"]

    def jobs(self):
        """Return the jobs as the page receives them."""
        return json.loads(self.ask("GET", "/jobs")[2])

    def memory(self):
        """Return the resident memory of the server process in bytes."""
        with open(f"/proc/{self.process.pid}/statm", encoding="utf-8") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    def is_alive(self):
        return self.process.poll() is None and self.ask("GET", "/")[0] == 200

    @contextlib.contextmanager
    def held(self, member):
        """Make commands wait at a member until the context ends."""
        hold = self.folder / "hold"
        hold.write_text(str(member))
        try:
            yield hold.unlink
        finally:
            hold.unlink(missing_ok=True)

    def private(self):
        """Return the private directories of servers."""
        return sorted((self.folder / "tmp").glob("stiction-app-*"))


def until(value, holds):
    """Return a value as soon as it satisfies a condition."""
    end = time.monotonic() + 10 * PATIENCE
    while not holds(result := value()):
        assert time.monotonic() < end, result
        time.sleep(0.1)
    return result


@contextlib.contextmanager
def served(folder, *options, code=""):
    """Start a server in a directory, by the command or by other code; its temporary directory is inside."""
    (folder / "tmp").mkdir(exist_ok=True)
    what = ["-c", code] if code else ["-m", "stiction", "app", *options]
    own = {"TMPDIR": folder / "tmp", "BROWSER": "true", "XDG_DATA_HOME": folder}
    own |= {"PYTHONPATH": HELD, "STICTION_TEST_HOLD": folder / "hold"}
    process = subprocess.Popen(
        [sys.executable, *what], cwd=folder, stderr=subprocess.PIPE, text=True,
        env=os.environ | {name: str(value) for name, value in own.items()},
    )  # fmt: skip
    try:
        yield Served(process, folder)
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
        try:
            process.wait(PATIENCE)
        finally:
            process.kill()
            process.stderr.close()


def write_maps(folder, size=24):
    """Write two small rough maps."""
    paths = []
    for side in ("upper", "lower"):
        face = self_affine_surface(5, hurst_exponent=0.8, rms=0.02, shape=(size, size), spacing=0.1, side=side)
        paths.append(folder / f"{side}_face.csv")
        write_surface(face, paths[-1])
    return paths


def write_other_grid(folder):
    """Write a map on another grid."""
    rng = np.random.default_rng(3)
    write_surface(Surface(0.01 * rng.standard_normal((20, 30)), spacing=(0.15, 0.12)), folder / "coarse.csv")
    return folder / "coarse.csv"
