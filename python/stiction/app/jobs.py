"""What the page asks for, as commands of `stiction` in processes of their own: one at a time, the others in a queue.

Nothing is computed here. A job is what somebody could type, its numbers are the JSON that the command prints, its pages
are those of `stiction report`, and how far it has come is read from its folder. So a scan that is more than the machine
can take ends a command and not the server, "stop" is the end of a process, and the same line gives the same numbers.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
import re
import shlex
import sys
from asyncio.subprocess import PIPE, Process
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

LOOK = 0.4
"""Seconds between two looks at how far a command has come."""

BETWEEN_ANSWERS = 3.0
"""Seconds at least between two answers from what is finished."""

MOST_WAITING = 8
"""Jobs in the queue."""

MOST_OUTPUT = 2**25
"""Bytes that a command may print."""


class RefusedError(ValueError):
    """What a command, or the page, refuses: a sentence."""


@dataclass
class Job:
    """A command, and what is known of its result."""

    number: int
    title: str
    arguments: list[str]
    folder: Path
    fast: list[str] | None = None  # a quicker command for a first answer
    state: str = "waiting"  # running, done, stopped, failed
    words: str = "waits for the one before it"
    by: str = ""
    finished: int = 0
    total: int = 0
    pages: list[Path] = field(default_factory=list)
    shown: Path | None = None  # the folder of which the answer is
    record: dict[str, Any] | None = None
    error: str = ""
    pipe: asyncio.StreamWriter | None = None  # as long as it is open, its command goes on

    def public(self) -> dict[str, Any]:
        """What the page knows of it."""
        names = ("number", "title", "state", "words", "by", "finished", "total", "error")
        answers = (self.record or {}).get("answers", [])
        line = shlex.join(["stiction", *self.arguments])
        return {name: getattr(self, name) for name in names} | {
            "command": line, "page": len(self.pages), "answer": answers[0] if answers else None,
        }  # fmt: skip

    def stop(self) -> None:
        """End its commands; what is finished of it is kept."""
        if self.state in ("waiting", "running"):
            self.state = "stopped"
            if self.pipe is not None:
                self.pipe.close()


class Jobs:
    """All jobs of a server, in a folder of its own."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.all: dict[int, Job] = {}
        self._queue: asyncio.Queue[Job] = asyncio.Queue(MOST_WAITING)
        self._few = asyncio.Semaphore(2)  # of commands beside that of a job
        self._next: asyncio.Task[Process] | None = None
        self._private = re.compile(rf"(?:{re.escape(str(root))}/|(?<![\w/+]))files/\d+/|{re.escape(str(root))}/")

    def without_paths(self, text: str) -> str:
        """Text in which the scans have the names that they came with."""
        return self._private.sub("", text)

    def add(self, title: str, arguments: list[str], *, fast: list[str] | None = None) -> Job:
        """Put a command into the queue; it goes on where the same one ended."""
        same = [each for each in arguments if not re.match("--(mu0|tau0)=", each)]
        folder = self.root / "results" / hashlib.sha256("\0".join(same).encode()).hexdigest()[:12] / arguments[0]
        job = Job(len(self.all) + 1, title, arguments, folder, fast)
        try:
            self._queue.put_nowait(job)
        except asyncio.QueueFull:
            raise RefusedError(f"{MOST_WAITING} jobs are waiting already: stop one of them") from None
        self.all[job.number] = job
        return job

    def open(self, folder: Path) -> Job:
        """Put a result that is there already into the queue."""
        job = self.add(folder.name, ["info", str(folder)])
        job.folder = folder
        return job

    async def work(self) -> None:
        """Do one job after the other, as long as the server is there."""
        while True:
            job = await self._queue.get()
            if job.state != "waiting":
                continue
            job.state = "running"
            try:
                await self._do(job)
                job.state = "done" if job.state == "running" else job.state
            except (OSError, ValueError) as error:
                if job.state == "running":
                    job.state, job.error = "failed", str(error)
            if job.state == "stopped":
                await self._count(job)
                with suppress(RefusedError):
                    if job.finished:
                        job.record, job.by = await self._record(["info", str(job.folder)]), ""
                        await self._page(job, job.folder)
            job.words = ""

    async def _do(self, job: Job) -> None:
        if job.fast is not None and not job.folder.exists():
            job.words, job.by = "pressing asperities", "a first answer, by asperities"
            quick = job.folder.parent / "fast"
            job.record = await self._record([*job.fast, f"--output={quick}"], job)
            await self._page(job, quick)
        job.words = "computing"
        watch = asyncio.create_task(self._watch(job))
        try:
            if job.arguments[0] == "pair":
                job.record = await self._record([*job.arguments, f"--output={job.folder}"], job)
            elif job.arguments[0] == "run":
                await self.call([*job.arguments, "--part=1/1", f"--output={job.folder}"], job)
        finally:
            watch.cancel()
            await asyncio.wait([watch])
        await self._count(job)
        if job.arguments[0] != "pair":
            job.record = await self._record(["info", str(job.folder)])
        job.words, job.by = "drawing", ""
        await self._page(job, job.folder)

    async def _record(self, arguments: list[str], job: Job | None = None) -> Any:
        """The JSON that a command prints; then it is ended, for all that it does after that is to draw."""
        return json.loads(await self.call([*arguments, "--json"], job, until=b"\n}\n"))

    async def _page(self, job: Job, folder: Path) -> None:
        path = self.root / "pages" / f"{job.number}-{len(job.pages) + 1}.html"
        path.parent.mkdir(exist_ok=True)
        await self.call(["report", str(folder), f"--output={path}"])
        job.shown = folder
        job.pages.append(path)

    async def _watch(self, job: Job) -> None:
        """Follow what a command writes, and tell the answer of what is there."""
        told, loop = 0, asyncio.get_running_loop()
        last = loop.time()
        while True:
            await asyncio.sleep(LOOK)
            await self._count(job)
            if job.finished < 2 or job.finished == told or loop.time() - last < BETWEEN_ANSWERS:
                continue
            told = job.finished
            with suppress(RefusedError):
                job.record = await self._record(["info", str(job.folder)])
                job.by = f"so far, {told} of {job.total}"
            last = loop.time()
            if job.finished == job.total:
                job.words = "over cut-offs, and how it begins to slide"

    async def _count(self, job: Job) -> None:
        from stiction.studies.store import open_stored

        with suppress(ValueError):  # nothing is there yet
            stored = await asyncio.to_thread(open_stored, job.folder)
            job.finished, job.total = int(stored.finished.size), stored.study.ensemble.repetitions

    # ---- Commands ---------------------------------------------------------------------------------------------------

    def _begun(self) -> asyncio.Task[Process]:
        return asyncio.create_task(
            asyncio.create_subprocess_exec(
                sys.executable, "-P", "-m", "stiction.app.child", cwd=self.root, stdin=PIPE, stdout=PIPE, stderr=PIPE
            )
        )

    async def call(self, arguments: list[str], job: Job | None = None, *, until: bytes = b"") -> str:
        """What a command prints, to its end or until it ends with something; or `RefusedError` with its sentence."""
        async with self._few if job is None else nullcontext():
            waiting, self._next = self._next or self._begun(), self._begun()  # the next one is begun at once
            process = await waiting
            pipe, printed, said = process.stdin, process.stdout, process.stderr
            assert pipe is not None and printed is not None and said is not None  # noqa: PT018
            pipe.write(json.dumps(arguments).encode() + b"\n")
            if job is not None:
                job.pipe = pipe
                if job.state == "stopped":
                    pipe.close()
            errors, text = asyncio.create_task(said.read()), b""
            try:
                while chunk := await printed.read(2**16):
                    text += chunk
                    if len(text) > MOST_OUTPUT:
                        raise RefusedError("the command says more than a page can hold")
                    if until and text.endswith(until):
                        return text.decode()
                if await process.wait() == 0 and (job is None or job.state != "stopped"):
                    return text.decode()
                lines = [
                    line.removeprefix("stiction: ") for line in (await errors).decode(errors="replace").splitlines()
                ]
                told = [line for line in lines if not line.startswith(("warning: ", "try stiction "))]
                raise RefusedError(self.without_paths("\n".join(told[-3:])) or "the command was ended")
            finally:
                pipe.close()
                errors.cancel()
