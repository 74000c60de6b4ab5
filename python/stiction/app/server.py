"""Local web server of the app: access control, uploaded scans, jobs and results."""

from __future__ import annotations

import asyncio
import hashlib
import json
import os
import re
import secrets
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

from starlette.applications import Starlette
from starlette.datastructures import MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route

from stiction._files import replaced_file
from stiction._units import short_repr
from stiction.app import sample_surfaces
from stiction.app.form import FIELDS, READING, fields_html, numbers_json
from stiction.app.jobs import Job, Jobs, RefusedError, without_paths
from stiction.mechanics.materials import materials
from stiction.studies.store import open_stored

MAX_SCAN_BYTES = 300_000_000  # maximum number of bytes of a scan, as much text as the readers accept
MAX_TOTAL_BYTES = 2_000_000_000  # maximum number of bytes of all scans
MAX_REQUEST_BYTES = 2**16  # maximum number of bytes of any other request
MAX_REQUEST_TIME = 120.0  # maximum number of seconds for a request and its response
MAX_NAME_LENGTH = 60  # maximum number of characters of a scan name
MAX_LISTED_RESULTS = 100  # maximum number of listed results
MAX_PREVIEW_POINTS = 2**21  # maximum number of points of a scan for a preview
REQUEST_ERRORS = (ValueError, TypeError, RecursionError, OSError, ClientDisconnect)
KEY_HEADER = "x-stiction-key"
PUBLIC_PATHS = ("/", "/app.js", "/app.css")  # paths without private content, for which the cookie is sufficient

OPTIONS = {"pair": tuple(FIELDS), "run": ("set",)}
"""Options of each command that the page may set."""

CHANGES = re.compile(
    r"(surfaces\.(fractal_dimension|amplitude|length_scale|convention)|ensemble\.(seed|repetitions))=.*"
)
"""Keys of a study that the page may set: generated surfaces, without file names."""

REPORT_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "frame-ancestors 'self'"
)
HEADERS = {
    "content-security-policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "cache-control": "no-store", "x-content-type-options": "nosniff", "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin", "cross-origin-resource-policy": "same-origin",
    "connection": "close",  # further data on the connection is not read
}  # fmt: skip
ENDED_RESPONSE = PlainTextResponse("The server has ended.\n", 503)
FOREIGN_RESPONSE = PlainTextResponse("Requests of other pages are rejected.\n", 403)


class Server:
    """ASGI application of the page. Scans and results are in `root`, existing results in `here`.

    The server accepts requests from `origin` only. The first request needs `token`, all others two secrets: a cookie,
    which a browser also sends to other ports of this computer, and a key, which only the page has. `asked` is the time
    of the last request of a window by the clock of the event loop.
    """

    def __init__(self, root: Path, here: Path, port: int, *, has_demo: bool = False) -> None:
        self.root, self.here, self.has_demo = root, here, has_demo
        self.host = f"127.0.0.1:{port}"
        self.origin = f"http://{self.host}"
        self.token: str | None = secrets.token_urlsafe(24)
        self._secret, self._cookie = secrets.token_urlsafe(24), f"stiction-{port}"
        self._key = secrets.token_urlsafe(24)
        self.jobs = Jobs(root)
        self.scans: dict[str, Path] = {}
        self.points: dict[str, int] = {}
        self.arriving = 0
        self.asked, self.has_window = 0.0, False
        self._requests: set[asyncio.Task[Any]] = set()
        self._has_ended = False
        routes: list[tuple[str, str, Any]] = [
            ("GET", "/", self.page), ("GET", "/app.{kind:str}", self.part),
            ("PUT", "/scans", self.take), ("GET", "/scans/{scan}", self.look), ("POST", "/demo", self.demo),
            ("GET", "/scans/{scan}/{name}", self.scan), ("GET", "/jobs", self.list_jobs), ("POST", "/jobs", self.ask),
            ("POST", "/jobs/{job:int}/stop", self.stop), ("GET", "/jobs/{job:int}/at", self.at),
            ("GET", "/jobs/{job:int}/{what}", self.share), ("GET", "/results", self.results),
            ("GET", "/profiles", self.profiles), ("POST", "/menu", self.menu),
        ]  # fmt: skip
        self._app = Starlette(
            routes=[Route(path, handler, methods=[method]) for method, path, handler in routes],
            exception_handlers=dict.fromkeys(REQUEST_ERRORS, _refusal),
            lifespan=self._life,
        )  # fmt: skip

    @asynccontextmanager
    async def _life(self, _: Starlette) -> AsyncIterator[None]:
        yield
        await self.jobs.end()

    def end(self) -> None:
        """Answer all pending and later requests with the message that the server has ended."""
        self._has_ended = True
        for task in self._requests:
            task.cancel()

    # ---- Access control ---------------------------------------------------------------------------------------------

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Answer a request of our own page and reject all others."""

        async def sent(message: Any) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        if scope["type"] != "http":
            return await self._app(scope, receive, send)
        if self._has_ended:
            return await ENDED_RESPONSE(scope, receive, sent)
        task: Any = asyncio.current_task()
        self._requests.add(task)
        try:
            async with asyncio.timeout(MAX_REQUEST_TIME):
                await (self._refused(Request(scope)) or self._app)(scope, receive, sent)
        except TimeoutError:
            pass
        except asyncio.CancelledError:
            with suppress(RuntimeError):  # the response has already started
                await ENDED_RESPONSE(scope, receive, sent)
        finally:
            self._requests.discard(task)

    def _refused(self, request: Request) -> Response | None:
        headers = request.headers
        if headers.getlist("host") != [self.host]:
            return PlainTextResponse(f"This server accepts requests for {self.origin} only.\n", 421)
        origin = headers.getlist("origin")
        if any(each != self.origin for each in origin) or (request.method != "GET" and not origin):
            return FOREIGN_RESPONSE
        token = request.query_params.get("token", "")
        if request.url.path == "/" and request.method == "GET" and token:
            if self.token is not None and _same(token, self.token):
                self.token = None
                response = RedirectResponse(f"/#{self._key}", 303)
                response.set_cookie(self._cookie, self._secret, httponly=True, samesite="strict", path="/")
                return response
        elif headers.get("sec-fetch-site", "none") not in ("same-origin", "none"):
            return FOREIGN_RESPONSE
        key = headers.get(KEY_HEADER) or request.query_params.get("key", "")
        is_known = request.url.path in PUBLIC_PATHS or _same(key, self._key)
        if not (_same(request.cookies.get(self._cookie, ""), self._secret) and is_known):
            return PlainTextResponse(
                "Open the address that `stiction app` has printed. It works in one browser.\n", 403
            )
        return None

    # ---- Pages ------------------------------------------------------------------------------------------------------

    async def page(self, _: Request) -> Response:
        """Return the page."""
        words = "".join(
            f'<option value="{each.name}" data-young="{float(each.young_modulus):.4g}" '
            f'data-poisson="{float(each.poisson_ratio):.3g}">{each.name}</option>'
            for each in sorted(materials(), key=lambda each: each.name)
        )
        demo, menu = "demo" if self.has_demo else "", "" if sys.platform == "linux" else "hidden"
        text = Template(_file("app.html")).substitute(
            materials=words, demo=demo, menu=menu, most=MAX_SCAN_BYTES, reading=fields_html("scan"),
            more=fields_html("more"), numbers=numbers_json(),
        )  # fmt: skip
        return Response(text, media_type="text/html")

    async def part(self, request: Request) -> Response:
        """Return the script, or the style sheets of the report and the app."""
        kind = request.path_params["kind"]
        if kind == "js":
            return Response(_file("app.js"), media_type="text/javascript")
        if kind != "css":
            _missing()
        return Response(_file("page.css", "stiction.views.report") + _file("app.css"), media_type="text/css")

    async def menu(self, _: Request) -> Response:
        """Add the app to the applications menu of the desktop, so that it starts without a terminal."""
        if re.search(r'["`$\\%\n]', f"{sys.executable}{self.here}"):
            raise RefusedError(f"{sys.executable}: this path cannot be used in a menu entry")
        data = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local/share") / "applications"
        data.mkdir(parents=True, exist_ok=True)
        with replaced_file(data / "stiction.desktop", b"Name=stiction\n", ValueError) as partial:
            partial.write_text(
                "[Desktop Entry]\nType=Application\nName=stiction\nComment=Static friction of two surfaces\n"
                f'Exec="{sys.executable}" -P -m stiction app\nPath={self.here}\nCategories=Science;\n',
                "utf-8",
            )
        return JSONResponse({"file": str(data / "stiction.desktop")})

    # ---- Scans ------------------------------------------------------------------------------------------------------

    async def take(self, request: Request) -> Response:
        """Store an uploaded scan under the last part of its name, without special characters."""
        kept = sum(path.stat().st_size for path in self.scans.values())
        length = _length(request, min(MAX_SCAN_BYTES, MAX_TOTAL_BYTES - kept - self.arriving))
        name = re.sub(r"[^\w.() -]", "_", re.split(r"[/\\]", request.query_params.get("name", ""))[-1]).strip(". ")
        stem, dot, ending = name.rpartition(".")
        name = (
            f"{(stem or 'scan')[: MAX_NAME_LENGTH - 10]}{dot}{ending[:9]}"
            if dot
            else (name or "scan")[:MAX_NAME_LENGTH]
        )
        partial = self.root / f"{secrets.token_hex(4)}.partial"
        digest = hashlib.sha256(name.encode())
        self.arriving += length
        try:
            with partial.open("wb") as file:
                async for chunk in request.stream():
                    digest.update(chunk)
                    await asyncio.to_thread(file.write, chunk)
            scan = digest.hexdigest()[:16]  # an identical scan gets the same identifier
            path = self.root / "files" / scan / name
            path.parent.mkdir(parents=True, exist_ok=True)
            partial.rename(path)
            self.scans[scan] = path
        except OSError as error:
            with suppress(RuntimeError):  # the request is complete
                async for _ in request.stream():  # otherwise the browser would not receive the error
                    pass
            raise RefusedError(f"the scan cannot be stored: {error.strerror}") from None
        finally:
            self.arriving -= length
            partial.unlink(missing_ok=True)
        return JSONResponse({"scan": scan})

    async def demo(self, _: Request) -> Response:
        """Return two sample surfaces as if they had been uploaded."""
        found = await asyncio.to_thread(sample_surfaces.surfaces, self.root / "files" / "demo")
        self.scans |= {path.stem: path for path in found}
        return JSONResponse([{"scan": path.stem, "name": path.name} for path in found])

    def _scan(self, number: object) -> Path:
        if number not in self.scans:
            raise HTTPException(404, "this scan is no longer available; drop it again")
        return self.scans[str(number)]

    async def scan(self, request: Request) -> Response:
        """Return a scan as a file."""
        path = self._scan(request.path_params["scan"])
        return FileResponse(path, filename=path.name)

    async def look(self, request: Request) -> Response:
        """Return the preview of a scan."""
        scan, query = request.path_params["scan"], request.query_params
        reading = json.dumps({name: query.get(name, "")[:80] for name in READING})
        said = await self.jobs.said(["stiction.app.preview", str(self._scan(scan)), reading])
        self.points[scan] = json.loads(said).get("points", 0)
        return Response(said, media_type="application/json")

    # ---- Jobs -------------------------------------------------------------------------------------------------------

    async def list_jobs(self, _: Request) -> Response:
        """Return the progress of all jobs."""
        self.asked, self.has_window = asyncio.get_running_loop().time(), True
        jobs = json.dumps([job.public() for job in self.jobs.all.values()])
        return Response(without_paths(jobs, self.root), media_type="application/json")

    async def ask(self, request: Request) -> Response:
        """Add a command to the queue: `pair` for two scans, `run` for generated surfaces, or an existing result."""
        _length(request, MAX_REQUEST_BYTES)
        if not isinstance(asked := await request.json(), dict):
            raise HTTPException(400)
        command, options = asked.get("command"), asked.get("options")
        if command == "open":
            name = asked.get("name", "")
            folder = self._folders().get(name) or _missing("this result no longer exists")
            return JSONResponse({"job": self.jobs.add(name, ["info", name], folder=folder).number})
        if command not in OPTIONS or not isinstance(options, list):
            raise HTTPException(400)
        for name, value in options:
            if name not in OPTIONS[command] or not isinstance(value, str) or len(value) > 200:
                raise HTTPException(400)
            if name == "set" and not CHANGES.fullmatch(value):
                raise HTTPException(400, f"the page cannot set {short_repr(value)}")
        chosen = [f"--{name}={value}" for name, value in options]
        if command == "run":
            return JSONResponse({"job": self.jobs.add("Generated profiles", ["run", "quick", *chosen]).number})
        scans = [asked.get(side) for side in ("upper", "lower")]
        files = [self._scan(scan) for scan in scans]
        is_small = all(0 < self.points.get(str(scan), 0) <= MAX_PREVIEW_POINTS for scan in scans)
        first = ([str(file) for file in files], options) if is_small else None
        title = " on ".join(file.name for file in files)
        return JSONResponse({"job": self.jobs.add(title, ["pair", *map(str, files), *chosen], first=first).number})

    def _job(self, request: Request) -> Job:
        return self.jobs.all.get(request.path_params["job"]) or _missing()

    async def stop(self, request: Request) -> Response:
        """Stop a job and keep its finished part."""
        self._job(request).stop()
        return JSONResponse({})

    async def at(self, request: Request) -> Response:
        """Return the values of a result for other mu0 and tau0."""
        job, query = self._job(request), request.query_params
        numbers = [float(query.get(name, "nan")) for name in ("load", "mu0", "tau0")]
        said = await self.jobs.at(job, numbers, float(query["d"]) if "d" in query else None)
        return Response(said, media_type="application/json")

    async def share(self, request: Request) -> Response:
        """Return the report, JSON, CSV or study file of a job."""
        folder, what = self._job(request).files or _missing(), request.path_params["what"]
        if what not in [each.name for each in folder.iterdir()]:
            _missing()
        name = what if "save" in request.query_params else None
        return FileResponse(folder / what, filename=name, headers={"content-security-policy": REPORT_POLICY})

    # ---- Existing results and generated surfaces -------------------------------------------------------------

    def _folders(self) -> dict[str, Path]:
        found = [each.parent for each in self.here.glob("*/study.toml") if (each.parent / "blocks").is_dir()]
        return {os.fsencode(each.name).decode("utf-8", "replace"): each for each in sorted(found)[:MAX_LISTED_RESULTS]}

    async def results(self, _: Request) -> Response:
        """Return the results in the current directory with their progress."""
        return JSONResponse(await asyncio.to_thread(lambda: [_listed(*each) for each in self._folders().items()]))

    async def profiles(self, request: Request) -> Response:
        """Return an image of two generated profiles around their first contact."""
        changes = dict(json.loads(request.query_params.get("set", "")))
        if not all(CHANGES.fullmatch(f"{key}=") for key in changes):
            raise HTTPException(400)
        return Response(await asyncio.to_thread(sample_surfaces.profiles, changes), media_type="image/svg+xml")


def _listed(name: str, folder: Path) -> dict[str, Any]:
    try:
        stored = open_stored(folder)
    except ValueError as error:
        return {"name": name, "error": str(error)}
    return {
        "name": name, "finished": stored.count, "total": stored.study.ensemble.repetitions,
        "kind": stored.study.surfaces.kind,
    }  # fmt: skip


def _file(name: str, package: str = "stiction.app") -> str:
    return (resources.files(package) / name).read_text("utf-8")


def _same(one: str, other: str) -> bool:
    return secrets.compare_digest(one.encode(), other.encode())


def _missing(why: str | None = None) -> Any:
    raise HTTPException(404, why)


async def _refusal(_: Request, refused: Exception) -> Response:
    words = str(refused)
    if isinstance(refused, OSError):
        words = f"{Path(refused.filename or '').name or 'this'} cannot be written: {refused.strerror}"
    return PlainTextResponse(words.encode("utf-8", "replace"), 400)


def _length(request: Request, most: int) -> int:
    """Return the length of a request body; raise HTTPException if it is too long or unknown."""
    length = request.headers.get("content-length", "")
    if "transfer-encoding" in request.headers or not length.isdecimal():
        raise HTTPException(411)
    if int(length) > most:
        raise HTTPException(
            413,
            f"the limit is {MAX_SCAN_BYTES / 1e6:.0f} MB for a scan and {MAX_TOTAL_BYTES / 1e6:.0f} MB for all scans",
        )
    return int(length)
