"""Job queue of the server: runs commands in separate processes, one at a time.

A job is a command that a user could type: the command line gives the same numbers, and "stop" has the effect of Ctrl-C.
A scan or result that exceeds the memory limit ends the command, not the server.
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

POLL_INTERVAL = 0.4  # seconds between two checks of the progress of a command
MAX_SHUTDOWN_TIME = 5.0  # seconds that a command has to write its results before it is killed
MAX_WAITING_JOBS = 8  # maximum number of jobs in the queue
MAX_OUTPUT = 2**25  # maximum number of bytes that a command may print
JOB_MEMORY = 0.5  # maximum fraction of the machine's memory for the one running job
READER_MEMORY = 0.25  # maximum fraction of the memory for each of two processes that read a scan or a result
SCOPE_TEXT = ", here and in the pictures"
END_OF_RECORD = b"\n}\n"  # end of the JSON of a command; the command draws figures afterwards


FAULTS = (OSError, ValueError, ImportError, MemoryError, RuntimeError)
"""Errors of a result or command that are reported in a message."""


class RefusedError(ValueError):
    """Rejected request, with a message for the page."""


def without_paths(text: str, root: Path | str) -> str:
    """Return text with private paths replaced by the names of the uploaded scans."""
    return re.sub(rf"{re.escape(str(root))}/(?:files/\w+/)?", "", text)


@dataclass(eq=False)
class Job:
    """Command in the queue, with its progress and result."""

    number: int
    title: str
    arguments: list[str]  # arguments of `stiction`
    folder: Path
    first: tuple[list[str], Any] | None = None  # scans and options of a preview with the asperity model
    state: str = "waiting"  # waiting, running, done, stopped or failed
    words: str = "waiting for the previous job"
    by: str = ""
    finished: int = 0
    total: int = 0
    versions: int = 0
    files: Path | None = None  # directory of files to save
    answer: Any = None
    error: str = ""
    is_ending: bool = False
    task: asyncio.Task[None] | None = None

    def public(self) -> dict[str, Any]:
        """Return the fields for the page."""
        names = ("number", "title", "state", "words", "by", "finished", "total", "error", "answer", "versions")
        own = {"command": shlex.join(["stiction", *self.arguments]), "option": first_option(self.error)}
        return {name: getattr(self, name) for name in names} | own | {"error": with_labels(self.error)}

    def stop(self) -> None:
        """Stop the command; the state changes when the finished part has been read."""
        if self.state in ("waiting", "running") and self.task is not None and not self.is_ending:
            self.is_ending, self.words = True, "stopping"
            self.task.cancel()


class Jobs:
    """Queue of all jobs of a server, in a directory of the server."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.all: dict[int, Job] = {}
        self._folders = 0
        self._is_ending = False
        self._job_lock = asyncio.Lock()
        self._reader_slots = asyncio.Semaphore(2)

    def add(self, title: str, arguments: list[str], *, folder: Path | None = None, first: Any = None) -> Job:
        """Add a command to the queue. A command with an existing result resumes it."""
        if sum(job.state == "waiting" for job in self.all.values()) >= MAX_WAITING_JOBS:
            raise RefusedError(f"{MAX_WAITING_JOBS} jobs are already waiting; stop one of them")
        same = [each for each in arguments if not re.match("--(mu0|tau0)=", each)]
        own = self.root / "results" / hashlib.sha256("\0".join(same).encode()).hexdigest()[:12] / arguments[0]
        job = self.all[len(self.all) + 1] = Job(len(self.all) + 1, title, arguments, folder or own, first)
        job.task = asyncio.create_task(self._run_job(job))
        return job

    async def end(self) -> None:
        """Stop all jobs and wait for them; their results are no longer shown."""
        self._is_ending = True
        for job in self.all.values():
            job.stop()
        await asyncio.gather(*(job.task for job in self.all.values() if job.task), return_exceptions=True)

    async def _run_job(self, job: Job) -> None:
        """Run a job to its end and read its last result."""
        try:
            async with self._job_lock:
                job.state = "running"
                await self._run_command(job)
            end = "done"
        except asyncio.CancelledError:
            end, has_begun = "stopped", job.state == "running"
            with suppress(*FAULTS):  # no result exists, or the surfaces do not touch
                if has_begun and not self._is_ending:
                    await self._read_result(job)
        except FAULTS as error:
            end, job.error = "failed", without_paths(str(error) or "not enough memory for this computation", self.root)
        job.state, job.words = end, ""

    async def _run_command(self, job: Job) -> None:
        if job.first is not None and not job.folder.exists():
            job.words = "computing a preview"
            with suppress(*FAULTS):  # the command itself reports the error
                await self._read_result(
                    job, "preview with the asperity model, without hardness, at {finished} positions", first=job.first
                )
        if job.folder.is_relative_to(self.root):
            job.words = "computing"
            watch = asyncio.create_task(self._watch(job))
            try:
                end = "--json" if job.arguments[0] == "pair" else "--part=1/1"
                line = ["stiction", *job.arguments, end, f"--output={job.folder}"]
                await run_module(line, patience=MAX_SHUTDOWN_TIME, memory=JOB_MEMORY)
            finally:
                watch.cancel()
                await asyncio.wait([watch])
        job.words = "drawing"
        await self._read_result(job)

    async def _watch(self, job: Job) -> None:
        """Follow the output of a command and read its result whenever the number of members has doubled."""
        told = 2  # with fewer members there is no interval
        while True:
            await asyncio.sleep(POLL_INTERVAL)
            with suppress(*FAULTS):  # no result exists yet, or the surfaces do not touch
                stored = await asyncio.to_thread(open_stored, job.folder)
                job.finished, job.total = stored.count, stored.study.ensemble.repetitions
                if job.total > job.finished >= 2 * told:
                    told = job.finished
                    await self._read_result(job, "so far, at {finished} of {total} positions")
            if 0 < job.total == job.finished:
                job.words = "computing the cutoff study and the onset of sliding"

    async def _read_result(self, job: Job, by: str = "", **of: Any) -> None:
        """Read the finished part of a job and write its report; the final result has no `by`."""
        self._folders += 1
        files = self.root / "shared" / f"{self._folders}"
        asked = {"folder": str(job.folder), "name": job.folder.name,
                 "command": "" if by else job.arguments[0], "files": str(files), "root": str(self.root)}  # fmt: skip
        told = json.loads(await run_module(["stiction.app.result_worker", json.dumps(asked | of)], memory=JOB_MEMORY))
        if told is None:
            return
        job.answer, job.files, job.versions = told["answer"], files, job.versions + 1
        job.by = by and by.format_map(told) + SCOPE_TEXT
        if not of:
            job.finished, job.total = told["finished"], told["total"]

    async def at(self, job: Job, numbers: list[float], dimension: float | None) -> str:
        """Return the record of a result at a load (mN), mu0 and tau0 (GPa)."""
        load, mu0, tau0 = numbers
        chosen = [f"--load={load!r} mN", f"--mu0={mu0!r}", f"--tau0={tau0!r} GPa"]
        chosen += [] if dimension is None else [f"--d={dimension!r}"]
        return await self.said(["stiction", "at", str(job.folder), *chosen, "--json"])

    async def said(self, arguments: list[str]) -> str:
        """Return the output of a module that finishes quickly; at most two run at a time."""
        async with self._reader_slots:
            return without_paths(await run_module(arguments, memory=READER_MEMORY), self.root)


def limit_prefix(memory: float) -> list[str]:
    """Return a command prefix that limits memory to a fraction and kills the process with its parent (Linux)."""
    if not (shutil.which("setpriv") and shutil.which("prlimit")):
        return []
    import resource

    total = int(memory * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    allowed = resource.getrlimit(resource.RLIMIT_DATA)
    limit = min([total, *(each for each in allowed if each != resource.RLIM_INFINITY)])
    return ["setpriv", "--pdeathsig=KILL", "prlimit", f"--data={limit}"]


async def run_module(arguments: list[str], *, memory: float, patience: float = 0.0) -> str:
    """Run a module in a process that ends with the server, and return its output up to the end of a record.

    The process may use a fraction `memory` of the machine's memory. After a cancellation it has `patience` seconds to
    write its results. Raises `RefusedError` with the message of the process.
    """
    process = await asyncio.create_subprocess_exec(
        *limit_prefix(memory), sys.executable, "-P", "-m", *arguments, stdin=asyncio.subprocess.DEVNULL,
        stdout=PIPE, stderr=PIPE, limit=MAX_OUTPUT,
    )  # fmt: skip
    output_stream, said = process.stdout, process.stderr
    assert output_stream is not None and said is not None  # noqa: PT018
    errors = asyncio.create_task(said.read())
    try:
        return (await output_stream.readuntil(END_OF_RECORD)).decode()
    except asyncio.LimitOverrunError:
        raise RefusedError("the output of the command is too long for the page") from None
    except asyncio.IncompleteReadError as ended:
        if (status := await process.wait()) == 0:
            return ended.partial.decode()
        if status < 0:
            name = signal.Signals(-status).name
            raise RefusedError(f"the system ended the command ({name}); memory may be insufficient") from None
        lines = [line.removeprefix("stiction: ") for line in (await errors).decode(errors="replace").splitlines()]
        told = [line for line in lines if not line.startswith(("warning: ", "try stiction "))]
        raise RefusedError("\n".join(told[-3:]) or "the command ended without a message") from None
    finally:
        if process.returncode is None and patience:
            process.send_signal(signal.SIGINT)
            with suppress(TimeoutError):
                await asyncio.wait_for(process.wait(), patience)
        if process.returncode is None:
            process.kill()
        errors.cancel()
