"""What the page asks for: commands in processes of their own compute it and read it, one job at a time.

A job is what somebody could type: its line gives the same numbers, "stop" is its Ctrl-C, and a scan or a result that is
more than the machine can take ends a command and not the server.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
import os
import re
import shlex
import shutil
import signal
import sys
from asyncio.subprocess import PIPE
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stiction.app.form import first_option, with_labels
from stiction.studies.store import open_stored

LOOK = 0.4  # seconds between two looks at how far a command has come
PATIENCE = 5.0  # seconds that a command has to write what it has computed, once it is to end
MOST_WAITING = 8  # jobs in the queue
MOST_OUTPUT = 2**25  # bytes that a command may print
MEMORY_OF_JOB = 0.5  # largest fraction of the memory of the machine for a job; one is computed at a time
MEMORY_OF_READER = 0.25  # the same for a process that reads a scan or a result, of which there are two at a time
TOO = ", here and in the pictures"
END_OF_RECORD = b"\n}\n"  # what the JSON of a command ends with; all that it does after that is to draw


FAULTS = (OSError, ValueError, ImportError, MemoryError, RuntimeError)
"""Errors that a result or a command can have, which are said in a sentence."""


class RefusedError(ValueError):
    """What a command, or the page, refuses: a sentence."""


def without_paths(text: str, root: Path | str) -> str:
    """Text in which the scans have the names that they came with."""
    return re.sub(rf"{re.escape(str(root))}/(?:files/\w+/)?", "", text)


@dataclass(eq=False)
class Job:
    """A command, and what is known of its result."""

    number: int
    title: str
    arguments: list[str]  # of `stiction`
    folder: Path
    first: tuple[list[str], Any] | None = None  # scans and options, of which there is a first answer by asperities
    state: str = "waiting"  # running, done, stopped, failed
    words: str = "waits for the one before it"
    by: str = ""
    finished: int = 0
    total: int = 0
    versions: int = 0
    files: Path | None = None  # what can be saved
    answer: Any = None
    error: str = ""
    is_ending: bool = False
    task: asyncio.Task[None] | None = None

    def public(self) -> dict[str, Any]:
        """What the page knows of it."""
        names = ("number", "title", "state", "words", "by", "finished", "total", "error", "answer", "versions")
        own = {"command": shlex.join(["stiction", *self.arguments]), "option": first_option(self.error)}
        return {name: getattr(self, name) for name in names} | own | {"error": with_labels(self.error)}

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
        self._is_ending = False
        self._one = asyncio.Lock()
        self._few = asyncio.Semaphore(2)

    def add(self, title: str, arguments: list[str], *, folder: Path | None = None, first: Any = None) -> Job:
        """Put a command into the queue, which goes on where the same one ended, or a result that is there."""
        if sum(job.state == "waiting" for job in self.all.values()) >= MOST_WAITING:
            raise RefusedError(f"{MOST_WAITING} jobs are waiting already: stop one of them")
        same = [each for each in arguments if not re.match("--(mu0|tau0)=", each)]
        own = self.root / "results" / hashlib.sha256("\0".join(same).encode()).hexdigest()[:12] / arguments[0]
        job = self.all[len(self.all) + 1] = Job(len(self.all) + 1, title, arguments, folder or own, first)
        job.task = asyncio.create_task(self._end(job))
        return job

    async def end(self) -> None:
        """Stop all jobs and wait for them; what is computed of them by then is not shown any more."""
        self._is_ending = True
        for job in self.all.values():
            job.stop()
        await asyncio.gather(*(job.task for job in self.all.values() if job.task), return_exceptions=True)

    async def _end(self, job: Job) -> None:
        """A job from its beginning to one of its ends, which it has come to when its last answer is there."""
        try:
            async with self._one:
                job.state = "running"
                await self._do(job)
            end = "done"
        except asyncio.CancelledError:
            end, has_begun = "stopped", job.state == "running"
            with suppress(*FAULTS):  # nothing is there, or nothing touches
                if has_begun and not self._is_ending:
                    await self._tell(job)
        except FAULTS as error:
            end, job.error = "failed", without_paths(str(error) or "there is not enough memory for this", self.root)
        job.state, job.words = end, ""

    async def _do(self, job: Job) -> None:
        if job.first is not None and not job.folder.exists():
            job.words = "pressing asperities"
            with suppress(*FAULTS):  # what is wrong, the command says
                await self._tell(
                    job, "a first answer, by asperities without hardness, at {finished} positions", first=job.first
                )
        if job.folder.is_relative_to(self.root):
            job.words = "computing"
            watch = asyncio.create_task(self._watch(job))
            try:
                end = "--json" if job.arguments[0] == "pair" else "--part=1/1"
                line = ["stiction", *job.arguments, end, f"--output={job.folder}"]
                await command(line, patience=PATIENCE, memory=MEMORY_OF_JOB)
            finally:
                watch.cancel()
                await asyncio.wait([watch])
        job.words = "drawing"
        await self._tell(job)

    async def _watch(self, job: Job) -> None:
        """Follow what a command writes; what is there is told whenever it has doubled."""
        told = 2  # of fewer there is no interval
        while True:
            await asyncio.sleep(LOOK)
            with suppress(*FAULTS):  # nothing is there yet, or nothing touches
                stored = await asyncio.to_thread(open_stored, job.folder)
                job.finished, job.total = stored.count, stored.study.ensemble.repetitions
                if job.total > job.finished >= 2 * told:
                    told = job.finished
                    await self._tell(job, "so far, at {finished} of {total} positions")
            if 0 < job.total == job.finished:
                job.words = "over cut-offs, and how it begins to slide"

    async def _tell(self, job: Job, by: str = "", **of: Any) -> None:
        """Take what is finished of a job as its answer, with its page; the last has no `by`, and all can be saved."""
        self._folders += 1
        files = self.root / "shared" / f"{self._folders}"
        asked = {"folder": str(job.folder), "name": job.folder.name,
                 "command": "" if by else job.arguments[0], "files": str(files), "root": str(self.root)}  # fmt: skip
        told = json.loads(await command(["stiction.app.result_worker", json.dumps(asked | of)], memory=MEMORY_OF_JOB))
        if told is None:
            return
        job.answer, job.files, job.versions = told["answer"], files, job.versions + 1
        job.by = by and by.format_map(told) + TOO
        if not of:
            job.finished, job.total = told["finished"], told["total"]

    async def at(self, job: Job, numbers: list[float], dimension: float | None) -> str:
        """The record of a result at a load (mN), mu0 and tau0 (GPa)."""
        load, mu0, tau0 = numbers
        chosen = [f"--load={load!r} mN", f"--mu0={mu0!r}", f"--tau0={tau0!r} GPa"]
        chosen += [] if dimension is None else [f"--d={dimension!r}"]
        return await self.said(["stiction", "at", str(job.folder), *chosen, "--json"])

    async def said(self, arguments: list[str]) -> str:
        """What a module prints that soon ends; a few at a time."""
        async with self._few:
            return without_paths(await command(arguments, memory=MEMORY_OF_READER), self.root)


def limited(memory: float) -> list[str]:
    """Return the beginning of a command line that limits memory to a fraction, and ends with its parent (Linux)."""
    if not (shutil.which("setpriv") and shutil.which("prlimit")):
        return []
    import resource

    total = int(memory * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    allowed = resource.getrlimit(resource.RLIMIT_DATA)
    limit = min([total, *(each for each in allowed if each != resource.RLIM_INFINITY)])
    return ["setpriv", "--pdeathsig=KILL", "prlimit", f"--data={limit}"]


async def command(arguments: list[str], *, memory: float, patience: float = 0.0) -> str:
    """What a module prints to its end or that of a record, in a process that ends with the server, however that ends.

    The process may take a fraction `memory` of that of the machine. Where nobody waits for it any more it has
    `patience` seconds to write what it has. A `RefusedError` has the sentence that the process has said.
    """
    process = await asyncio.create_subprocess_exec(
        *limited(memory), sys.executable, "-P", "-m", *arguments, stdin=asyncio.subprocess.DEVNULL,
        stdout=PIPE, stderr=PIPE, limit=MOST_OUTPUT,
    )  # fmt: skip
    printed, said = process.stdout, process.stderr
    assert printed is not None and said is not None  # noqa: PT018
    errors = asyncio.create_task(said.read())
    try:
        return (await printed.readuntil(END_OF_RECORD)).decode()
    except asyncio.LimitOverrunError:
        raise RefusedError("the command says more than a page can hold") from None
    except asyncio.IncompleteReadError as ended:
        if (status := await process.wait()) == 0:
            return ended.partial.decode()
        if status < 0:
            name = signal.Signals(-status).name
            raise RefusedError(f"the system has ended the command ({name}); perhaps memory is short") from None
        lines = [line.removeprefix("stiction: ") for line in (await errors).decode(errors="replace").splitlines()]
        told = [line for line in lines if not line.startswith(("warning: ", "try stiction "))]
        raise RefusedError("\n".join(told[-3:]) or "the command was ended") from None
    finally:
        if process.returncode is None and patience:
            process.send_signal(signal.SIGINT)
            with suppress(TimeoutError):
                await asyncio.wait_for(process.wait(), patience)
        if process.returncode is None:
            process.kill()
        errors.cancel()
