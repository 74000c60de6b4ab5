"""Local web server of the app: access control, uploaded scans, jobs and results."""

from __future__ import annotations

import asyncio
import hashlib
import html
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

from stiction._files import replace_file_atomically
from stiction._units import short_repr
from stiction.app import sample_surfaces
from stiction.app.form import (
    FILE_READING_FLAGS,
    FORM_FIELDS_BY_FLAG,
    SHEAR_FLAGS,
    SHEAR_FORM_FLAGS,
    fields_html,
    find_first_option_name,
    format_error,
    group_option_values,
    page_data_json,
    parse_reading_options,
    replace_option_names,
    replace_option_names_in_caveats,
    replace_option_names_in_preview,
)
from stiction.app.jobs import Job, JobQueue, RejectedRequestError, hide_private_paths
from stiction.mechanics.materials import materials
from stiction.solve.store import open_stored_result
from stiction.study.interfaces import interfaces
from stiction.study.pair_study import MeasuredPair
from stiction.surfaces.pairing import SIDES

# Maximum size (bytes) of an uploaded scan, equal to the limit for text files in the readers of measured surfaces.
MAX_SCAN_BYTES = 300_000_000
MAX_TOTAL_SCAN_BYTES = 2_000_000_000  # bytes
MAX_REQUEST_BYTES = 2**16  # bytes
MAX_REQUEST_TIME = 120.0  # s
# Maximum number of requests at the same time; a single browser sends at most six.
MAX_CONCURRENT_REQUESTS = 64
MAX_SCAN_NAME_LENGTH = 60  # characters
MAX_LISTED_RESULTS = 100
MAX_PREVIEWED_SCAN_POINTS = 2**21
REQUEST_EXCEPTIONS = (ValueError, TypeError, RecursionError, OSError, ClientDisconnect)
ACCESS_KEY_HEADER = "x-stiction-key"
# Paths that a browser may request without the access key, because they contain no private data.
PUBLIC_PATHS = ("/", "/app.js", "/app.css")

ALLOWED_OPTIONS_BY_COMMAND = {
    "pair": tuple(FORM_FIELDS_BY_FLAG), "run": ("set",), "shear": (*SHEAR_FLAGS, *SHEAR_FORM_FLAGS),
}  # fmt: skip
"""Names of the options that the page may set, by command."""

ALLOWED_STUDY_CHANGE_PATTERN = re.compile(
    r"(surfaces\.(fractal_dimension|amplitude|length_scale|convention)|ensemble\.(seed|repetitions))=.*"
)
"""Pattern of the study settings that the page may change, none of which is a file name."""

REPORT_SECURITY_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "frame-ancestors 'self'"
)
RESPONSE_HEADERS = {
    "content-security-policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "cache-control": "no-store", "x-content-type-options": "nosniff", "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin", "cross-origin-resource-policy": "same-origin",
    "connection": "close",
}  # fmt: skip
SERVER_ENDED_RESPONSE = PlainTextResponse("The server has ended.\n", 503)
BUSY_RESPONSE = PlainTextResponse(f"The server already has {MAX_CONCURRENT_REQUESTS} requests; try again later.\n", 503)
TIMEOUT_RESPONSE = PlainTextResponse(f"The request took longer than {MAX_REQUEST_TIME:.0f} s.\n", 503)
CROSS_ORIGIN_RESPONSE = PlainTextResponse("Requests of other pages are rejected.\n", 403)


class Server:
    """ASGI application that serves the app. It stores uploaded scans and new results in the directory `root`.

    Existing results are read from `working_directory`.

    The server accepts requests only from `origin`. The first request needs `token`; all other requests need two
    secrets: a cookie, which a browser also sends to other ports of this computer, and a key, which only the page has.
    `last_request_time` is the time of the last request of a window, on the clock of the event loop.
    """

    def __init__(self, root: Path, working_directory: Path, port: int, *, has_demo: bool = False) -> None:
        self.root, self.working_directory, self.has_demo = root, working_directory, has_demo
        self.host = f"127.0.0.1:{port}"
        self.origin = f"http://{self.host}"
        self.token: str | None = secrets.token_urlsafe(24)
        self._cookie_secret, self._cookie_name = secrets.token_urlsafe(24), f"stiction-{port}"
        self._access_key = secrets.token_urlsafe(24)
        self.jobs = JobQueue(root)
        self.scans: dict[str, Path] = {}
        self.points: dict[str, int] = {}
        self.num_arriving_bytes = 0
        self.last_request_time, self.has_window = 0.0, False
        self._running_requests: set[asyncio.Task[Any]] = set()
        self._has_ended = False
        routes: list[tuple[str, str, Any]] = [
            ("GET", "/", self.get_page), ("GET", "/app.{kind:str}", self.get_asset),
            ("PUT", "/scans", self.store_scan), ("GET", "/scans/{scan}", self.preview_scan),
            ("POST", "/demo", self.add_sample_surfaces), ("GET", "/scans/{scan}/{name}", self.get_scan),
            ("GET", "/jobs", self.list_jobs), ("POST", "/jobs", self.add_job),
            ("POST", "/jobs/{job:int}/stop", self.stop_job), ("GET", "/jobs/{job:int}/at", self.evaluate_result),
            ("GET", "/jobs/{job:int}/{name}", self.get_result_file), ("GET", "/results", self.list_results),
            ("GET", "/profiles", self.draw_profiles), ("GET", "/fit", self.compare_scans),
            ("POST", "/menu", self.add_menu_entry),
        ]  # fmt: skip
        self._app = Starlette(
            routes=[Route(path, handler, methods=[method]) for method, path, handler in routes],
            exception_handlers=dict.fromkeys(REQUEST_EXCEPTIONS, _error_response),
            lifespan=self._lifespan,
        )  # fmt: skip

    @asynccontextmanager
    async def _lifespan(self, _: Starlette) -> AsyncIterator[None]:
        yield
        await self.jobs.shut_down()

    def shut_down(self) -> None:
        """Answer all pending and later requests with the message that the server was shut down."""
        self._has_ended = True
        for task in self._running_requests:
            task.cancel()

    # ---- Access control ---------------------------------------------------------------------------------------------

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Respond to requests from the app's own page, and reject all other requests."""

        async def send_with_headers(message: Any) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in RESPONSE_HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        if scope["type"] != "http":
            return await self._app(scope, receive, send)
        rejection = SERVER_ENDED_RESPONSE if self._has_ended else self._rejection_response(Request(scope))
        if rejection is None and len(self._running_requests) >= MAX_CONCURRENT_REQUESTS:
            rejection = BUSY_RESPONSE
        if rejection is not None:
            return await rejection(scope, receive, send_with_headers)
        task: Any = asyncio.current_task()
        self._running_requests.add(task)
        try:
            async with asyncio.timeout(MAX_REQUEST_TIME):
                await self._app(scope, receive, send_with_headers)
        except TimeoutError:
            rejection = TIMEOUT_RESPONSE
        except asyncio.CancelledError:
            rejection = SERVER_ENDED_RESPONSE
        finally:
            self._running_requests.discard(task)
        if rejection is not None:
            # Sending an error raises RuntimeError if the response has already started.
            with suppress(RuntimeError):
                await rejection(scope, receive, send_with_headers)

    def _rejection_response(self, request: Request) -> Response | None:
        headers = request.headers
        if headers.getlist("host") != [self.host]:
            return PlainTextResponse(f"This server accepts requests for {self.origin} only.\n", 421)
        origin = headers.getlist("origin")
        if any(item != self.origin for item in origin) or (request.method != "GET" and not origin):
            return CROSS_ORIGIN_RESPONSE
        token = request.query_params.get("token", "")
        if request.url.path == "/" and request.method == "GET" and token:
            if self.token is not None and _are_secrets_equal(token, self.token):
                self.token = None
                response = RedirectResponse(f"/#{self._access_key}", 303)
                response.set_cookie(self._cookie_name, self._cookie_secret, httponly=True, samesite="strict", path="/")
                return response
        elif headers.get("sec-fetch-site", "none") not in ("same-origin", "none"):
            return CROSS_ORIGIN_RESPONSE
        access_key = headers.get(ACCESS_KEY_HEADER) or request.query_params.get("key", "")
        has_access = request.url.path in PUBLIC_PATHS or _are_secrets_equal(access_key, self._access_key)
        if not (_are_secrets_equal(request.cookies.get(self._cookie_name, ""), self._cookie_secret) and has_access):
            return PlainTextResponse(
                "Open the address that `stiction app` has printed. It works in one browser.\n", 403
            )
        return None

    # ---- Pages ------------------------------------------------------------------------------------------------------

    async def get_page(self, _: Request) -> Response:
        """Return the page of the app."""
        material_options = "".join(
            f'<option value="{material.name}" data-young="{float(material.young_modulus):.4g}" '
            f'data-poisson="{float(material.poisson_ratio):.3g}">{material.name}</option>'
            for material in sorted(materials(), key=lambda material: material.name)
        )
        interface_options = "".join(f"<option>{html.escape(name)}</option>" for name in interfaces())
        demo_attribute, menu_attribute = "demo" if self.has_demo else "", "" if sys.platform == "linux" else "hidden"
        text = Template(_read_package_file("app/app.html")).substitute(
            materials=material_options, interfaces=interface_options, demo=demo_attribute, menu=menu_attribute,
            max_bytes=MAX_SCAN_BYTES, reading=fields_html("scan"), more=fields_html("more"), facts=page_data_json(),
        )  # fmt: skip
        return Response(text, media_type="text/html")

    async def get_asset(self, request: Request) -> Response:
        """Return the script of the page, or a style sheet of the report or of the app."""
        file_type = request.path_params["kind"]
        if file_type == "js":
            return Response(_read_package_file("app/app.js"), media_type="text/javascript")
        if file_type != "css":
            _raise_not_found()
        return Response(
            _read_package_file("views/report/page.css") + _read_package_file("app/app.css"), media_type="text/css"
        )

    async def add_menu_entry(self, _: Request) -> Response:
        """Add the app to the applications menu of the desktop, so that it starts without a terminal."""
        for path in (sys.executable, self.working_directory):
            if re.search(r'["`$\\%\n]', str(path)):
                reason = 'it has a line break or one of the characters " ` $ \\ %'
                raise RejectedRequestError(f"{path}: a menu entry cannot contain this path, because {reason}")
        applications_directory = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local/share") / "applications"
        applications_directory.mkdir(parents=True, exist_ok=True)
        with replace_file_atomically(
            applications_directory / "stiction.desktop", b"Name=stiction\n", ValueError
        ) as partial_path:
            partial_path.write_text(
                "[Desktop Entry]\nType=Application\nName=stiction\nComment=Static friction of two surfaces\n"
                f'Exec="{sys.executable}" -P -m stiction app\nPath={self.working_directory}\nCategories=Science;\n',
                "utf-8",
            )
        return JSONResponse({"file": str(applications_directory / "stiction.desktop")})

    # ---- Scans ------------------------------------------------------------------------------------------------------

    async def store_scan(self, request: Request) -> Response:
        """Store an uploaded scan under its file name without special characters."""
        num_stored_bytes = sum(path.stat().st_size for path in self.scans.values())
        num_bytes = _request_body_length(
            request, min(MAX_SCAN_BYTES, MAX_TOTAL_SCAN_BYTES - num_stored_bytes - self.num_arriving_bytes)
        )
        name = re.sub(r"[^\w.() -]", "_", re.split(r"[/\\]", request.query_params.get("name", ""))[-1]).strip(". ")
        stem, separator, extension = name.rpartition(".")
        name = (
            f"{(stem or 'scan')[: MAX_SCAN_NAME_LENGTH - 10]}{separator}{extension[:9]}"
            if separator
            else (name or "scan")[:MAX_SCAN_NAME_LENGTH]
        )
        partial_path = self.root / f"{secrets.token_hex(4)}.partial"
        digest = hashlib.sha256(name.encode())
        self.num_arriving_bytes += num_bytes
        try:
            with partial_path.open("wb") as file:
                async for chunk in request.stream():
                    digest.update(chunk)
                    await asyncio.to_thread(file.write, chunk)
            scan_identifier = digest.hexdigest()[:16]
            path = self.root / "files" / scan_identifier / name
            path.parent.mkdir(parents=True, exist_ok=True)
            partial_path.rename(path)
            self.scans[scan_identifier] = path
        except OSError as error:
            # Reading the upload raises RuntimeError if the request has already ended.
            with suppress(RuntimeError):
                # The browser shows the error message only after the whole upload has been read.
                async for _ in request.stream():
                    pass
            raise RejectedRequestError(f"the scan cannot be stored: {error.strerror}") from None
        finally:
            self.num_arriving_bytes -= num_bytes
            partial_path.unlink(missing_ok=True)
        return JSONResponse({"scan": scan_identifier})

    async def add_sample_surfaces(self, _: Request) -> Response:
        """Store the two sample scans in the same way as uploaded scans."""
        paths = await asyncio.to_thread(sample_surfaces.write_sample_surfaces, self.root / "files" / "demo")
        self.scans |= {path.stem: path for path in paths}
        return JSONResponse([{"scan": path.stem, "name": path.name} for path in paths])

    def _find_scan_path(self, identifier: object) -> Path:
        if identifier not in self.scans:
            raise HTTPException(404, "this scan is no longer available; drop its file onto the page again")
        return self.scans[str(identifier)]

    async def get_scan(self, request: Request) -> Response:
        """Return the content of a scan file."""
        path = self._find_scan_path(request.path_params["scan"])
        return FileResponse(path, filename=path.name)

    async def preview_scan(self, request: Request) -> Response:
        """Return the preview of a scan: a summary with a small image, or the reason why the file cannot be read."""
        scan, query = request.path_params["scan"], request.query_params
        reading_options = parse_reading_options({flag: query.get(flag, "")[:80] for flag in FILE_READING_FLAGS})
        output = await self.jobs.run_module_in_reader_slot(
            ["stiction.app.preview", str(self._find_scan_path(scan)), json.dumps(reading_options)]
        )
        preview = replace_option_names_in_preview(json.loads(output))
        self.points[scan] = preview.get("points", 0)
        return Response(json.dumps(preview), media_type="application/json")

    async def compare_scans(self, request: Request) -> Response:
        """Return whether the faces on two scans fit into each other.

        Reading options have names such as "upper.unit".
        """
        query, arguments = request.query_params, []
        for side in SIDES:
            option_texts = {flag: query.get(f"{side}.{flag}", "")[:80] for flag in FILE_READING_FLAGS}
            path = self._find_scan_path(query.get(side))
            arguments += [str(path), json.dumps(parse_reading_options(option_texts))]
        output = await self.jobs.run_module_in_reader_slot(["stiction.app.preview", *arguments])
        return Response(output, media_type="application/json")

    # ---- Jobs ------------------------------------------------------------------------------------------------------

    async def list_jobs(self, _: Request) -> Response:
        """Return the state and progress of all jobs."""
        self.last_request_time, self.has_window = asyncio.get_running_loop().time(), True
        jobs = json.dumps(self.jobs.page_data())
        return Response(hide_private_paths(jobs, self.root), media_type="application/json")

    async def add_job(self, request: Request) -> Response:
        """Add a job to the queue: `pair` or `shear` for scans, `run` for generated surfaces, or `info` for a result.

        An invalid entry of the form is reported with its option, and no job is added.
        """
        _request_body_length(request, MAX_REQUEST_BYTES)
        if not isinstance(request_data := await request.json(), dict):
            raise HTTPException(400)
        command, options = request_data.get("command"), request_data.get("options")
        if command == "open":
            name = request_data.get("name", "")
            directory = self._find_result_directories().get(name) or _raise_not_found("this result no longer exists")
            return JSONResponse({"job": self.jobs.add(name, ["info", name], directory=directory).number})
        if command not in ALLOWED_OPTIONS_BY_COMMAND or not isinstance(options, list):
            raise HTTPException(400)
        for name, value in options:
            if name not in ALLOWED_OPTIONS_BY_COMMAND[command] or not isinstance(value, str) or len(value) > 200:
                raise HTTPException(400)
            if name == "set" and not ALLOWED_STUDY_CHANGE_PATTERN.fullmatch(value):
                raise HTTPException(
                    400, f"the field 'set' must be one of the settings on the page, got {short_repr(value)}"
                )
            if name == "interface" and value not in interfaces() and value not in self.scans:
                raise HTTPException(
                    400, f"interface must be one of the interfaces on the page, got {short_repr(value)}"
                )
        options = [
            (name, str(self.scans[value]) if name == "interface" and value in self.scans else value)
            for name, value in options
        ]
        arguments = [f"--{name}" if name == "register" else f"--{name}={value}" for name, value in options]
        if command == "run":
            return JSONResponse({"job": self.jobs.add("Generated profiles", ["run", "quick", *arguments]).number})
        scan_identifiers = [request_data.get(side) for side in ("upper", "lower")]
        files = [self._find_scan_path(scan_identifier) for scan_identifier in scan_identifiers]
        title, file_stem = (" on ".join(getattr(file, part) for file in files) for part in ("name", "stem"))
        if command == "shear":
            job = self.jobs.add(title, ["shear", *map(str, files), *arguments], file_stem=file_stem)
            return JSONResponse({"job": job.number})
        try:
            await asyncio.to_thread(
                MeasuredPair.check_entries, upper=files[0], lower=files[1], **group_option_values(options)
            )
        except ValueError as error:
            message = hide_private_paths(format_error(error), self.root)
            return JSONResponse({"error": replace_option_names(message), "option": find_first_option_name(message)})
        is_preview_possible = all(
            0 < self.points.get(str(scan_identifier), 0) <= MAX_PREVIEWED_SCAN_POINTS
            for scan_identifier in scan_identifiers
        )
        preview = ([str(file) for file in files], options) if is_preview_possible else None
        job = self.jobs.add(title, ["pair", *map(str, files), *arguments], file_stem=file_stem, preview=preview)
        return JSONResponse({"job": job.number})

    def _find_job(self, request: Request) -> Job:
        return self.jobs.jobs_by_number.get(request.path_params["job"]) or _raise_not_found()

    async def stop_job(self, request: Request) -> Response:
        """Stop a job. The finished part of its result is kept."""
        self._find_job(request).stop()
        return JSONResponse({})

    async def evaluate_result(self, request: Request) -> Response:
        """Return the coefficients of a result at another mu0 and tau0."""
        job, query = self._find_job(request), request.query_params
        load_mu0_tau0 = [float(query.get(name, "nan")) for name in ("load", "mu0", "tau0")]
        output = await self.jobs.evaluate_result(job, load_mu0_tau0, float(query["d"]) if "d" in query else None)
        points = json.loads(output)["points"]
        return JSONResponse({"points": [replace_option_names_in_caveats(record) for record in points]})

    async def get_result_file(self, request: Request) -> Response:
        """Return a file of a job's result: report, JSON, CSV or study file."""
        job, name = self._find_job(request), request.path_params["name"]
        directory = job.files or _raise_not_found()
        if name not in [path.name for path in directory.iterdir()]:
            _raise_not_found()
        saved_name = f"{job.file_stem}{Path(name).suffix}" if "save" in request.query_params else None
        return FileResponse(
            directory / name, filename=saved_name, headers={"content-security-policy": REPORT_SECURITY_POLICY}
        )

    # ---- Existing results and generated surfaces -------------------------------------------------------------

    def _find_result_directories(self) -> dict[str, Path]:
        directories = [
            path.parent for path in self.working_directory.glob("*/study.toml") if (path.parent / "blocks").is_dir()
        ]
        return {
            os.fsencode(directory.name).decode("utf-8", "replace"): directory
            for directory in sorted(directories)[:MAX_LISTED_RESULTS]
        }

    async def list_results(self, _: Request) -> Response:
        """Return the results in the working directory, with their progress."""
        return JSONResponse(
            await asyncio.to_thread(
                lambda: [_stored_result_list_entry(*item) for item in self._find_result_directories().items()]
            )
        )

    async def draw_profiles(self, request: Request) -> Response:
        """Return an image of two generated profiles near first contact."""
        changes = dict(json.loads(request.query_params.get("set", "")))
        if not all(ALLOWED_STUDY_CHANGE_PATTERN.fullmatch(f"{study_key}=") for study_key in changes):
            raise HTTPException(400)
        return Response(await asyncio.to_thread(sample_surfaces.draw_profiles, changes), media_type="image/svg+xml")


def _stored_result_list_entry(name: str, directory: Path) -> dict[str, Any]:
    try:
        stored_result = open_stored_result(directory)
    except ValueError as error:
        return {"name": name, "error": str(error)}
    return {
        "name": name, "finished": stored_result.num_finished, "total": stored_result.study.ensemble.repetitions,
        "kind": stored_result.study.surfaces.kind,
    }  # fmt: skip


def _read_package_file(name: str) -> str:
    # `resources.files` avoids the import of `stiction.views.report`, which would load Matplotlib and pandas.
    return (resources.files("stiction") / name).read_text("utf-8")


def _are_secrets_equal(first: str, second: str) -> bool:
    return secrets.compare_digest(first.encode(), second.encode())


def _raise_not_found(reason: str | None = None) -> Any:
    raise HTTPException(404, reason)


async def _error_response(_: Request, error: Exception) -> Response:
    message = str(error)
    if isinstance(error, OSError):
        message = f"{Path(error.filename or '').name or 'this'} cannot be written: {error.strerror}"
    return PlainTextResponse(message.encode("utf-8", "replace"), 400)


def _request_body_length(request: Request, max_length: int) -> int:
    """Return the length of a request body in bytes, or raise an HTTPException if the length is unknown or too large."""
    length_text = request.headers.get("content-length", "")
    if "transfer-encoding" in request.headers or not length_text.isdecimal():
        raise HTTPException(411)
    if int(length_text) > max_length:
        raise HTTPException(
            413,
            f"a scan must not exceed {MAX_SCAN_BYTES / 1e6:.0f} MB, and all scans together must not exceed "
            f"{MAX_TOTAL_SCAN_BYTES / 1e6:.0f} MB",
        )
    return int(length_text)
