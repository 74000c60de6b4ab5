"""The page's server: who may ask, what may be asked for, and when it ends."""

from __future__ import annotations

import asyncio
import hashlib
import json
import re
import secrets
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response, StreamingResponse
from starlette.routing import Route

from stiction.app.jobs import Job, Jobs, RefusedError

MOST_BYTES = 300_000_000
"""Of a scan; as much text as the readers take."""

MOST_IN_ALL = 2_000_000_000
"""Of all scans."""

MOST_ASKED = 2**16
"""Bytes of any other request."""

SLOWEST = 120.0
"""Seconds for the body of a request."""

LONGEST = 60
"""Characters of the name of a scan."""

MOST_LISTED = 100
"""Results in the list."""

OPTIONS = {
    "pair": ("unit", "spacing", "missing", "upper", "lower", "young", "poisson", "hardness", "mu0", "tau0", "load",
             "level", "rotate", "shifts"),
    "run": ("set",),
}  # fmt: skip
"""What the page may ask of each command."""

ONLY_EXACT = ("hardness",)
"""Options that asperities do not have."""

PAGE = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "frame-ancestors 'self'"
)
APP = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "cache-control": "no-store", "x-content-type-options": "nosniff", "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin", "cross-origin-resource-policy": "same-origin",
}  # fmt: skip


class Server:
    """What the page asks for, and its answers.

    Attributes
    ----------
    root : Path
        A folder of its own, for scans and results.
    here : Path
        Where results are listed.
    origin : str
        Its own address, the only one that it answers to.
    token : str
        What the address has to say once.
    """

    def __init__(self, root: Path, here: Path, port: int, *, has_demo: bool = False) -> None:
        self.root, self.here, self.has_demo = root, here, has_demo
        self.host = f"127.0.0.1:{port}"
        self.origin = f"http://{self.host}"
        self.token: str | None = secrets.token_urlsafe(24)
        self._secret, self._cookie = secrets.token_urlsafe(24), f"stiction-{port}"
        self.jobs = Jobs(root)
        self.scans: dict[str, tuple[Path, str]] = {}  # number, as text: the file and its checksum
        self.windows = 0
        self.closed = asyncio.Event()  # set when it is to end
        routes: list[tuple[str, str, Any]] = [
            ("GET", "/", self.page), ("GET", "/app.{kind:str}", self.part), ("GET", "/events", self.events),
            ("PUT", "/scans", self.take), ("GET", "/scans/{scan}", self.look), ("POST", "/demo", self.demo),
            ("POST", "/jobs", self.ask), ("POST", "/jobs/{job:int}/stop", self.stop),
            ("GET", "/jobs/{job:int}/at", self.at), ("GET", "/jobs/{job:int}/{what}", self.share),
            ("GET", "/results", self.results), ("GET", "/profiles", self.profiles),
        ]  # fmt: skip
        self._app = Starlette(
            routes=[Route(path, handler, methods=[method]) for method, path, handler in routes],
            exception_handlers={RefusedError: _refusal, ClientDisconnect: _refusal}, lifespan=self._life,
        )  # fmt: skip

    @asynccontextmanager
    async def _life(self, _: Starlette) -> AsyncIterator[None]:
        working = asyncio.create_task(self.jobs.work())
        yield
        self.closed.set()
        working.cancel()
        for job in self.jobs.all.values():
            job.stop()

    # ---- Who may ask ------------------------------------------------------------------------------------------------

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Answer a request of our own page, and no other."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        request = Request(scope)
        refusal = self._refused(request)

        async def sent(message: Any) -> None:
            if message["type"] == "http.response.start":
                names = {name for name, _ in message["headers"]}
                more = HEADERS | ({} if b"content-security-policy" in names else {"content-security-policy": APP})
                if message["status"] >= 400:  # what else somebody sends is not read
                    more = more | {"connection": "close"}
                message["headers"] = [*message["headers"], *((k.encode(), v.encode()) for k, v in more.items())]
            await send(message)

        await (refusal or self._app)(scope, receive, sent)

    def _refused(self, request: Request) -> Response | None:
        headers = request.headers
        if headers.getlist("host") != [self.host]:
            return PlainTextResponse(f"This server answers to {self.origin} alone.\n", 421)
        origin = headers.getlist("origin")
        foreign = headers.get("sec-fetch-site", "none") not in ("same-origin", "none")
        if any(each != self.origin for each in origin) or (request.method != "GET" and not origin):
            return PlainTextResponse("Pages of others have nothing to ask for here.\n", 403)
        token = request.query_params.get("token", "")
        if request.url.path == "/" and request.method == "GET" and token:
            if self.token is not None and _same(token, self.token):
                self.token = None
                response = RedirectResponse("/", 303)
                response.set_cookie(self._cookie, self._secret, httponly=True, samesite="strict", path="/")
                return response
        elif foreign:
            return PlainTextResponse("Pages of others have nothing to ask for here.\n", 403)
        if not _same(request.cookies.get(self._cookie, ""), self._secret):
            return PlainTextResponse("Open the address that `stiction app` has printed: it opens one browser.\n", 403)
        return None

    # ---- Pages ------------------------------------------------------------------------------------------------------

    async def page(self, _: Request) -> Response:
        """The page itself."""
        from stiction.mechanics.materials import materials

        words = "".join(
            f'<option value="{each.name}" data-young="{float(each.young_modulus):.4g}" '
            f'data-poisson="{float(each.poisson_ratio):.3g}">{each.name}</option>'
            for each in sorted(materials(), key=lambda each: each.name)
        )
        text = Template(_file("app.html")).substitute(
            materials=words, demo="demo" if self.has_demo else "", most=MOST_BYTES
        )
        return Response(text, media_type="text/html")

    async def part(self, request: Request) -> Response:
        """Its script and its style, behind those of the report that it shares."""
        kinds = {"js": ("text/javascript", "numbers.js"), "css": ("text/css", "page.css")}
        if (kind := request.path_params["kind"]) not in kinds:
            raise HTTPException(404)
        media, shared = kinds[kind]
        return Response(_file(shared, "stiction.views.report") + _file(f"app.{kind}"), media_type=media)

    async def events(self, _: Request) -> Response:
        """All jobs whenever something about them is new, as long as a window is open."""

        async def told() -> AsyncIterator[str]:
            self.windows += 1
            last, quiet = "", 0
            try:
                while not self.closed.is_set():
                    now = self.jobs.without_paths(json.dumps([job.public() for job in self.jobs.all.values()]))
                    quiet += 1
                    if now != last or quiet > 50:  # also so that a window that is gone is noticed
                        yield f"data: {now}\n\n"
                        last, quiet = now, 0
                    with suppress(TimeoutError):
                        await asyncio.wait_for(self.closed.wait(), 0.2)
            finally:
                self.windows -= 1

        return StreamingResponse(told(), media_type="text/event-stream")

    # ---- Scans ------------------------------------------------------------------------------------------------------

    async def take(self, request: Request) -> Response:
        """Take a scan under the last part of its name, without whatever could mean something to a file system."""
        room = min(MOST_BYTES, MOST_IN_ALL - sum(path.stat().st_size for path, _ in self.scans.values()))
        too_large = f"a scan may have {room / 1e6:.0f} MB here"
        length = request.headers.get("content-length", "0")
        if not length.isdecimal() or int(length) > room:
            raise HTTPException(413, too_large)
        name = re.sub(r"[^\w.() -]", "_", re.split(r"[/\\]", request.query_params.get("name", ""))[-1]).strip(". ")
        stem, dot, ending = name.rpartition(".")
        name = f"{(stem or 'scan')[: LONGEST - 10]}{dot}{ending[:9]}" if dot else (name or "scan")[:LONGEST]
        number = f"{len(self.scans) + 1}-{secrets.token_hex(4)}"
        partial = self.root / f"{number}.partial"
        digest, size = hashlib.sha256(), 0
        try:
            async with asyncio.timeout(SLOWEST):
                with partial.open("wb") as file:
                    async for chunk in request.stream():
                        size += len(chunk)
                        if size > room:
                            raise HTTPException(413, too_large)
                        digest.update(chunk)
                        await asyncio.to_thread(file.write, chunk)
            return JSONResponse({"scan": self._keep(partial, name, digest.hexdigest())})
        except TimeoutError:
            raise HTTPException(408) from None
        finally:
            partial.unlink(missing_ok=True)

    def _keep(self, partial: Path, name: str, digest: str) -> str:
        """Give a scan its number; one that is there already has one."""
        for number, (path, known) in self.scans.items():
            if path.name == name and known == digest:
                return number
        number = f"{len(self.scans) + 1}"
        path = self.root / "files" / number / name
        path.parent.mkdir(parents=True)
        partial.rename(path)
        self.scans[number] = path, digest
        return number

    async def demo(self, _: Request) -> Response:
        """Two surfaces of our own, as if they had been dropped."""
        from stiction.app.look import surfaces

        made = await asyncio.to_thread(surfaces, self.root)
        return JSONResponse([{"scan": self._keep(path, path.name, path.name), "name": path.name} for path in made])

    def _scan(self, number: object) -> str:
        if number not in self.scans:
            raise HTTPException(404, "this scan is not here any more: drop it again")
        return str(self.scans[str(number)][0].relative_to(self.root))

    async def look(self, request: Request) -> Response:
        """What a scan holds."""
        reading = [request.query_params.get(name, "")[:40] for name in ("unit", "spacing")]
        missing = "interpolate" if request.query_params.get("missing") else "error"
        said = await self.jobs.call(["look", self._scan(request.path_params["scan"]), *reading, missing])
        return Response(self.jobs.without_paths(said), media_type="application/json")

    # ---- Jobs -------------------------------------------------------------------------------------------------------

    async def ask(self, request: Request) -> Response:
        """Put a command into the queue: `pair` of two scans, `run` of generated surfaces, or a result to be opened."""
        asked = await _asked(request)
        command = asked.get("command")
        if command == "open":
            return JSONResponse({"job": self.jobs.open(self._folder(asked.get("name"))).number})
        if command not in OPTIONS or not isinstance(options := asked.get("options"), list):
            raise HTTPException(400)
        chosen = []
        for name, value in options:
            if name not in OPTIONS[command] or not isinstance(value, str) or len(value) > 200:
                raise HTTPException(400)
            chosen.append(f"--{name}={value}")
        if command == "run":
            job = self.jobs.add("Generated profiles", ["run", "quick", *chosen])
            return JSONResponse({"job": job.number})
        files = [self._scan(asked.get(side)) for side in ("upper", "lower")]
        arguments = ["pair", *files, *chosen]
        fast = [each for each in arguments if not each.startswith(tuple(f"--{name}=" for name in ONLY_EXACT))]
        fast += ["--mechanics=asperities", "--onset=0", "--shifts=4"]
        title = " on ".join(Path(file).name for file in files)
        job = self.jobs.add(title, arguments, fast=fast if asked.get("maps") is True else None)
        return JSONResponse({"job": job.number})

    def _job(self, request: Request) -> Job:
        if (job := self.jobs.all.get(request.path_params["job"])) is None:
            raise HTTPException(404)
        return job

    async def stop(self, request: Request) -> Response:
        """End a job; what is finished of it is kept."""
        self._job(request).stop()
        return JSONResponse({})

    async def at(self, request: Request) -> Response:
        """The answer of a result for another mu0 and tau0, as `stiction at` gives it."""
        job = self._job(request)
        wanted = [f"--{n}={v[:40]}" for n in ("load", "mu0", "tau0", "d") if (v := request.query_params.get(n))]
        if job.shown is None:
            raise HTTPException(404)
        return Response(
            self.jobs.without_paths(await self.jobs.call(["at", str(job.shown), "--json", *wanted])),
            media_type="application/json",
        )

    async def share(self, request: Request) -> Response:
        """A page, JSON, CSV or the study of a job."""
        job, what = self._job(request), request.path_params["what"]
        if job.shown is None or not job.pages:
            raise HTTPException(404)
        policy = {"content-security-policy": PAGE}
        if what == "page.html":
            text, media = await asyncio.to_thread(job.pages[-1].read_text, "utf-8"), "text/html"
        elif what == "result.json":
            text, media = json.dumps(job.record, ensure_ascii=False, indent=1), "application/json"
        elif what == "study.toml":
            text, media = (job.shown / what).read_text("utf-8"), "text/plain"
        elif what == "result.csv":
            path = self.root / f"{secrets.token_hex(4)}.csv"
            await self.jobs.call(["export", str(job.shown), str(path)])
            text, media = path.read_text("utf-8"), "text/csv"
            path.unlink()
        else:
            raise HTTPException(404)
        saved = {"content-disposition": f'attachment; filename="{what}"'} if "save" in request.query_params else {}
        return Response(self.jobs.without_paths(text), media_type=media, headers=policy | saved)

    # ---- Results that are there, and generated surfaces -------------------------------------------------------------

    def _folders(self) -> list[Path]:
        found = [each.parent for each in self.here.glob("*/study.toml") if (each.parent / "blocks").is_dir()]
        return sorted(found, key=lambda each: each.name)[:MOST_LISTED]

    def _folder(self, name: object) -> Path:
        for folder in self._folders():
            if folder.name == name:
                return folder
        raise HTTPException(404, "there is no such result any more")

    async def results(self, _: Request) -> Response:
        """The results in the folder in which the server was begun, and how far each has come."""
        return JSONResponse(await asyncio.to_thread(lambda: [_listed(each) for each in self._folders()]))

    async def profiles(self, request: Request) -> Response:
        """A picture of two generated profiles around where they first touch."""
        from stiction.app.look import profiles

        try:
            changes = json.loads(request.query_params.get("set", ""))
            return Response(await asyncio.to_thread(profiles, changes), media_type="image/svg+xml")
        except (ValueError, TypeError, AttributeError) as error:
            raise RefusedError(str(error)) from None


def _listed(folder: Path) -> dict[str, Any]:
    from stiction.studies.store import open_stored

    try:
        stored = open_stored(folder)
    except ValueError as error:
        return {"name": folder.name, "error": str(error)}
    return {
        "name": folder.name, "finished": int(stored.finished.size), "total": stored.study.ensemble.repetitions,
        "kind": stored.study.surfaces.kind,
    }  # fmt: skip


def _file(name: str, package: str = "stiction.app") -> str:
    return (resources.files(package) / name).read_text("utf-8")


def _same(one: str, other: str) -> bool:
    return secrets.compare_digest(one.encode(), other.encode())


async def _refusal(_: Request, refused: Exception) -> Response:
    return PlainTextResponse(str(refused), 400)


async def _asked(request: Request) -> dict[str, Any]:
    """A small body of JSON."""
    body = b""
    async with asyncio.timeout(SLOWEST):
        async for chunk in request.stream():
            body += chunk
            if len(body) > MOST_ASKED:
                raise HTTPException(413)
    with suppress(ValueError):
        if isinstance(asked := json.loads(body), dict):
            return asked
    raise HTTPException(400)
