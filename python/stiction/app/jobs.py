"""What the page asks for: the library reads results, and a command in a process of its own computes, one at a time.

A job is what somebody could type: its line gives the same numbers, "stop" is its Ctrl-C, and a scan that is more than
the machine can take ends the command and not the server.
"""

from __future__ import annotations

import asyncio
import hashlib
import re
import shlex
import shutil
import signal
import sys
from asyncio.subprocess import PIPE
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiction.studies.onset import onset_beside
from stiction.studies.resolution import resolution_at
from stiction.studies.store import Stored, open_stored
from stiction.views.answer import answers
from stiction.views.asked import at_asked_loads
from stiction.views.report import report_page
from stiction.views.result import Result, read_result
from stiction.views.rows import answer_record, csv_text, record_text

if TYPE_CHECKING:
    import xarray

LOOK = 0.4  # seconds between two looks at how far a command has come
PATIENCE = 5.0  # seconds that a command has to write what it has computed, once it is to end
MOST_WAITING = 8  # jobs in the queue
MOST_OUTPUT = 2**25  # bytes that a command may print
FAULTS = (OSError, ValueError, ImportError, MemoryError, RuntimeError)  # of what is read or computed here
TOO = ", here and in the pictures"
END_OF_RECORD = b"\n}\n"  # what the JSON of a command ends with; all that it does after that is to draw


class RefusedError(ValueError):
    """What a command, or the page, refuses: a sentence."""


@dataclass(eq=False)
class Job:
    """A command, and what is known of its result."""

    number: int
    title: str
    arguments: list[str]  # of `stiction`
    folder: Path
    first: Callable[[], Result | None] | None = None  # a first answer, by asperities
    state: str = "waiting"  # running, done, stopped, failed
    words: str = "waits for the one before it"
    by: str = ""
    finished: int = 0
    total: int = 0
    versions: int = 0
    result: Result | None = None  # of which the answer is
    files: Path | None = None  # what can be saved
    answer: Any = None
    error: str = ""
    is_ending: bool = False
    task: asyncio.Task[None] | None = None

    def public(self) -> dict[str, Any]:
        """What the page knows of it."""
        names = ("number", "title", "state", "words", "by", "finished", "total", "error", "answer", "versions")
        return {name: getattr(self, name) for name in names} | {"command": shlex.join(["stiction", *self.arguments])}

    def stop(self) -> None:
        """End its command; it is stopped when what is finished of it is told."""
        if self.state in ("waiting", "running") and self.task is not None and not self.is_ending:
            self.is_ending, self.words = True, "stopping"
            self.task.cancel()


class Jobs:
    """All jobs of a server, in a folder of its own."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.all: dict[int, Job] = {}
        self._folders = 0
        self._one = asyncio.Lock()
        self._few = asyncio.Semaphore(2)
        self._private = re.compile(rf"{re.escape(str(root))}/(?:files/\w+/)?")

    def without_paths(self, text: str) -> str:
        """Text in which the scans have the names that they came with."""
        return self._private.sub("", text)

    def add(self, title: str, arguments: list[str], *, folder: Path | None = None, first: Any = None) -> Job:
        """Put a command into the queue, which goes on where the same one ended, or a result that is there."""
        if sum(job.state == "waiting" for job in self.all.values()) >= MOST_WAITING:
            raise RefusedError(f"{MOST_WAITING} jobs are waiting already: stop one of them")
        same = [each for each in arguments if not re.match("--(mu0|tau0)=", each)]
        own = self.root / "results" / hashlib.sha256("\0".join(same).encode()).hexdigest()[:12] / arguments[0]
        job = self.all[len(self.all) + 1] = Job(len(self.all) + 1, title, arguments, folder or own, first)
        job.task = asyncio.create_task(self._end(job))
        return job

    async def _end(self, job: Job) -> None:
        """A job from its beginning to one of its ends, which it has come to when its last answer is there."""
        try:
            async with self._one:
                job.state = "running"
                await self._do(job)
            end = "done"
        except asyncio.CancelledError:
            end = "stopped"
            with suppress(*FAULTS):  # nothing is there, or nothing touches
                await self._tell(job, partial(read_result, job.folder))
        except FAULTS as error:
            end, job.error = "failed", self.without_paths(str(error) or "there is not enough memory for this")
        job.state, job.words = end, ""

    async def _do(self, job: Job) -> None:
        if job.first is not None and not job.folder.exists():
            job.words = "pressing asperities"
            with suppress(*FAULTS):  # what is wrong, the command says
                first = await asyncio.to_thread(job.first)
                if first is not None:
                    by = f"a first answer, by asperities at {first.dataset.sizes['repetition']} positions{TOO}"
                    await self._tell(job, lambda: first, by)
        if job.folder.is_relative_to(self.root):
            job.words = "computing"
            watch = asyncio.create_task(self._watch(job))
            try:
                end = "--json" if job.arguments[0] == "pair" else "--part=1/1"
                await command(["stiction", *job.arguments, end, f"--output={job.folder}"])
            finally:
                watch.cancel()
                await asyncio.wait([watch])
        job.words = "drawing"
        await self._tell(job, partial(read_result, job.folder))

    async def _watch(self, job: Job) -> None:
        """Follow what a command writes; what is there is told whenever it has doubled."""
        told = 2  # of fewer there is no interval
        while True:
            await asyncio.sleep(LOOK)
            with suppress(*FAULTS):  # nothing is there yet, or nothing touches
                await self._count(job)
                if job.total > job.finished >= 2 * told:
                    told = job.finished
                    by = f"so far, at {told} of {job.total} positions{TOO}"
                    await self._tell(job, partial(read_result, job.folder), by)
            if 0 < job.total == job.finished:
                job.words = "over cut-offs, and how it begins to slide"

    async def _count(self, job: Job) -> None:
        stored = await asyncio.to_thread(open_stored, job.folder)
        job.finished, job.total = stored.count, stored.study.ensemble.repetitions

    async def _tell(self, job: Job, take: Callable[[], Result], by: str = "") -> None:
        """Take a result as the answer, with its page and what can be saved; the first numbers do not wait for these."""
        result, at, answer = await asyncio.to_thread(_answered, take)
        if job.answer is None and by:
            job.answer, job.by = answer, by
        self._folders += 1  # the thread of an answer that was given up may still write into its own
        files = self.root / "shared" / f"{self._folders}"
        await asyncio.to_thread(self._write, result, at, files, "" if by else job.arguments[0], job.folder.name)
        job.answer, job.by, job.result, job.files, job.versions = answer, by, result, files, job.versions + 1
        if isinstance(result.source, Stored):
            job.finished = int(result.source.finished.size)
            job.total = result.study.ensemble.repetitions

    def _write(self, result: Result, at: xarray.Dataset, files: Path, command: str, name: str) -> None:
        """Write what can be saved of a result; as long as its command goes on the page alone."""
        source, study, beside = result.source, result.study, result.beside
        texts = {"page.html": report_page([source], names=[name])}
        if isinstance(source, Stored) and command:
            over, onset = resolution_at(source), onset_beside(source)
            texts |= {
                "result.json": record_text(command, at, study, beside=beside, over=over, onset=onset),
                "result.csv": csv_text(at, study, beside=beside),
                "study.toml": (source.path / "study.toml").read_text("utf-8"),
            }
        files.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (files / name).write_text(self.without_paths(text), "utf-8", "replace")

    async def look(self, arguments: list[str]) -> str:
        """What `look` says of a scan; a few at a time."""
        async with self._few:
            return self.without_paths(await command(["stiction.app.look", *arguments]))


def _answered(take: Callable[[], Result]) -> tuple[Result, xarray.Dataset, Any]:
    result = take()
    at = at_asked_loads(result.source)
    return result, at, answer_record(answers(at, result.study, beside=result.beside)[0])


def at(result: Result, numbers: list[float], dimension: float | None) -> str:
    """The record of a result at a load (mN), mu0 and tau0 (GPa), as `stiction at` gives it."""
    load, mu0, tau0 = numbers
    found = result.at([load], mu0=[mu0], tau0=[tau0])
    if dimension is not None:
        found = found.sel(fractal_dimension=[dimension], method="nearest").isel(amplitude=[0])
    return record_text("at", found, result.study, beside=result.beside)


async def command(arguments: list[str]) -> str:
    """What a module prints to its end or that of a record, in a process that ends with the server, however that ends.

    Raises
    ------
    RefusedError
        With the sentence that the process has said.
    """
    alone = ["setpriv", "--pdeathsig=KILL"] if shutil.which("setpriv") else []  # Linux has it
    process = await asyncio.create_subprocess_exec(
        *alone, sys.executable, "-P", "-m", *arguments, stdin=asyncio.subprocess.DEVNULL, stdout=PIPE, stderr=PIPE,
        limit=MOST_OUTPUT,
    )  # fmt: skip
    printed, said = process.stdout, process.stderr
    assert printed is not None and said is not None  # noqa: PT018
    errors = asyncio.create_task(said.read())
    try:
        return (await printed.readuntil(END_OF_RECORD)).decode()
    except asyncio.LimitOverrunError:
        raise RefusedError("the command says more than a page can hold") from None
    except asyncio.IncompleteReadError as ended:
        if await process.wait() == 0:
            return ended.partial.decode()
        lines = [line.removeprefix("stiction: ") for line in (await errors).decode(errors="replace").splitlines()]
        told = [line for line in lines if not line.startswith(("warning: ", "try stiction "))]
        raise RefusedError("\n".join(told[-3:]) or "the command was ended") from None
    finally:
        if process.returncode is None:
            process.send_signal(signal.SIGINT)
            with suppress(TimeoutError):
                await asyncio.wait_for(process.wait(), PATIENCE)
        if process.returncode is None:
            process.kill()
        errors.cancel()
