"""Job queue of the app, which runs commands in separate processes, one command at a time.

A job is a command that a user could type: the command line gives the same numbers, and "stop" has the same effect as
Ctrl-C. A scan or result that exceeds the memory limit ends the command, but not the server.
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
from asyncio import StreamReader
from asyncio.subprocess import PIPE, Process
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stiction._errors import UNFIT_CORE_MESSAGE, is_caused_by_unfit_core
from stiction._estimate import Estimate
from stiction.app.form import find_first_option_name, replace_option_names, replace_option_names_in_caveats
from stiction.solve.executors import PROGRESS_PREFIX
from stiction.solve.store import open_stored_result

POLL_INTERVAL = 0.4  # s
MAX_SHUTDOWN_TIME = 5.0  # s
KILLED_PROCESS_TIMEOUT = 1.0  # s
MAX_WAITING_JOBS = 8
MAX_OUTPUT_BYTES = 2**25
JOB_MEMORY_FRACTION = 0.5
# Fraction of the machine's memory that a short process of the app may use; two short processes may run in parallel.
READER_MEMORY_FRACTION = 0.25
SCOPE_TEXT_SUFFIX = ", here and in the pictures"
# A command prints its JSON record before it draws figures. These characters end the JSON record.
END_OF_JSON_RECORD = b"\n}\n"
# Files that the user can save after each command: the name in the app, mapped to the name that the command writes.
FILES_BY_COMMAND = {
    "pair": {"page.html": "report.html", "result.csv": "result.csv", "study.toml": "study.toml"},
    "shear": {"page.html": "report.html", "result.csv": "shear.csv"},
}


REPORTED_EXCEPTIONS = (OSError, ValueError, ImportError, MemoryError, RuntimeError)
"""Exceptions whose messages the app shows to the user."""


class RejectedRequestError(ValueError):
    """Error raised if the app rejects a request.

    The page shows the message of the error.
    """


def hide_private_paths(text: str, root: Path | str) -> str:
    """Remove the private directory of the app from all paths in a text, so that only the names of scan files remain."""
    return re.sub(rf"{re.escape(str(root))}/(?:files/\w+/)?", "", text)


@dataclass(eq=False)
class Job:
    """Job in the queue of the app: a command of stiction with its progress and its result."""

    number: int
    title: str
    arguments: list[str]
    directory: Path
    preview: tuple[list[str], Any] | None = None  # None without a preview
    # State of the job: "waiting", "running", "done", "stopped" or "failed".
    state: str = "waiting"
    file_stem: str = ""
    activity: str = ""
    scope: str = ""
    finished: int = 0
    total: int = 0
    versions: int = 0
    files: Path | None = None
    record: Any = None
    error: str = ""
    is_ending: bool = False
    task: asyncio.Task[None] | None = None

    def page_data(self) -> dict[str, Any]:
        """Return the state, progress, result and error of the job as data for the page."""
        field_names = ("number", "title", "state", "finished", "total")
        return {name: getattr(self, name) for name in field_names} | {
            "words": self.activity, "by": self.scope, "answer": self.record, "error": replace_option_names(self.error),
            "command": shlex.join(["stiction", *self.arguments]), "option": find_first_option_name(self.error),
            "versions": self.versions if self.files else 0,
        }  # fmt: skip

    def show_result(
        self, record: Any, files: Path | None, *, scope: str = "", counts: tuple[int, int] | None = None
    ) -> None:
        """Store the coefficients and caveats of a result for display on the page.

        `files` is the directory with the files that the user can save, or None if they have not been written. `scope`
        describes the members of an intermediate result. `counts` contains the number of finished members and the number
        of all members; None leaves both unchanged.
        """
        self.record, self.files, self.scope, self.versions = record, files, scope, self.versions + 1
        if counts is not None:
            self.finished, self.total = counts

    def stop(self) -> None:
        """Stop the command of the job.

        After its process has ended, the finished part of its result is read.
        """
        if self.state in ("waiting", "running") and self.task is not None and not self.is_ending:
            self.is_ending, self.activity = True, "stopping"
            self.task.cancel()


class JobQueue:
    """Queue of the app's jobs, with the directory that contains the results of these jobs."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.jobs_by_number: dict[int, Job] = {}
        self._directory_count = 0
        self._is_ending = False
        self._job_lock = asyncio.Lock()
        self._reader_slots = asyncio.Semaphore(2)

    def add(
        self,
        title: str,
        arguments: list[str],
        *,
        file_stem: str = "",
        directory: Path | None = None,
        preview: Any = None,
    ) -> Job:
        """Add a command to the job queue.

        If the result of the command is partly stored, only the missing members are computed.

        Files of the result are saved under the name `file_stem`, which is the title by default.
        """
        if sum(job.state == "waiting" for job in self.jobs_by_number.values()) >= MAX_WAITING_JOBS:
            raise RejectedRequestError(f"{MAX_WAITING_JOBS} jobs are already waiting; stop one of these jobs first")
        # Jobs that differ only in mu0 and tau0 share a stored result, unless their command is `shear`.
        is_shear = arguments[0] == "shear"
        identifying_arguments = [item for item in arguments if is_shear or not re.match("--(mu0|tau0)=", item)]
        digest = hashlib.sha256("\0".join(identifying_arguments).encode()).hexdigest()[:12]
        directory = directory or self.root / "results" / digest / arguments[0]
        job = self.jobs_by_number[len(self.jobs_by_number) + 1] = Job(
            len(self.jobs_by_number) + 1, title, arguments, directory, preview, file_stem=file_stem or title
        )
        job.task = asyncio.create_task(self._run_job(job))
        job.task.add_done_callback(_print_unexpected_error)
        return job

    def page_data(self) -> list[dict[str, Any]]:
        """Return the data of all jobs that the page of the app shows.

        For a waiting job, the data name the job before it.
        """
        records, previous_title = [], ""
        for job in self.jobs_by_number.values():
            record = job.page_data()
            if job.state == "waiting" and previous_title and not job.is_ending:
                record["words"] = f"waiting for {previous_title}"
            if job.state in ("waiting", "running"):
                previous_title = job.title
            records.append(record)
        return records

    async def shut_down(self) -> None:
        """Stop all jobs, and wait for the end of their processes. Results that follow are not shown."""
        self._is_ending = True
        for job in self.jobs_by_number.values():
            job.stop()
            if job.state == "stopped" and job.task is not None:
                job.task.cancel()
        await asyncio.gather(*(job.task for job in self.jobs_by_number.values() if job.task), return_exceptions=True)

    async def _run_job(self, job: Job) -> None:
        """Run a job until its command ends, and read its final result."""
        final_state = "failed"
        try:
            async with self._job_lock:
                job.state = "running"
                await self._run_command(job)
            final_state = "done"
        except asyncio.CancelledError:
            final_state, has_begun = "stopped", job.state == "running"
            job.state, job.activity = final_state, "reading the finished part"
            # Reading the result fails if no result is stored yet, or if the surfaces do not touch.
            with suppress(*REPORTED_EXCEPTIONS):
                if has_begun and not self._is_ending:
                    await self._read_result(job)
        except REPORTED_EXCEPTIONS as error:
            has_only_values = job.record is not None and job.files is None
            job.error = "the report of this result could not be written: " * has_only_values + hide_private_paths(
                str(error) or "not enough memory for this computation", self.root
            )
        except Exception:
            job.error = "unexpected error; the terminal of the server shows the details"
            raise
        finally:
            job.state, job.activity = final_state, ""

    async def _run_command(self, job: Job) -> None:
        if job.directory.is_relative_to(self.root):
            record = await self._compute_result(job)
            if job.arguments[0] in FILES_BY_COMMAND:
                await self._show_files(job, record)
                return
        job.activity = "drawing"
        await self._read_result(job)

    async def _compute_result(self, job: Job) -> str:
        """Run the command of a job until it ends, and return its output.

        The commands `pair` and `shear` print a JSON record, and then write a report and a table.
        """
        job.activity, has_record = "computing", job.arguments[0] in FILES_BY_COMMAND
        monitor_task = asyncio.create_task(self._monitor_progress(job))
        reading_tasks = [monitor_task]
        if job.preview is not None and not job.directory.exists():
            reading_tasks.append(asyncio.create_task(self._show_preview(job)))
        for task in reading_tasks:
            task.add_done_callback(_print_unexpected_error)

        def show_values(record: str) -> None:
            """Send the coefficients of a finished result to the page before the figures of the result are drawn."""
            monitor_task.cancel()
            job.activity = "drawing"
            job.show_result(_read_shown_values(job, record), None)

        output_option = "--json" if has_record else "--part=1/1"
        arguments = ["stiction", *job.arguments, output_option, f"--output={job.directory}"]
        try:
            return await run_module(
                arguments, grace_time=MAX_SHUTDOWN_TIME, memory=JOB_MEMORY_FRACTION, on_record=show_values
            )
        finally:
            for task in reading_tasks:
                task.cancel()
            await asyncio.wait(reading_tasks)

    async def _show_preview(self, job: Job) -> None:
        """Show a preview of the result while the command of a job computes, unless the command finishes earlier."""
        job.activity = "computing a preview"
        # An error of the preview is ignored, because the command of the job reports the same error.
        with suppress(*REPORTED_EXCEPTIONS):
            await self._read_result(
                job, "preview with the asperity model, without hardness, at {finished} positions", preview=job.preview
            )
        if job.activity == "computing a preview":
            job.activity = "computing"

    async def _show_files(self, job: Job, record: str) -> None:
        """Copy the files that a finished command wrote, and show them with the coefficients in its JSON record."""
        files = self._choose_directory()
        # The thread that copies files may outlast a stopped job, so the thread must not change the job.
        counts = await asyncio.to_thread(self._copy_files, job, files, record)
        job.show_result(_read_shown_values(job, record), files, counts=counts)

    def _copy_files(self, job: Job, files: Path, record: str) -> tuple[int, int] | None:
        """Copy the files and the JSON record of a job to a new directory.

        Returns the numbers of finished members and of all members for the command `pair`, and None for other commands.
        """
        sources = FILES_BY_COMMAND[job.arguments[0]]
        file_texts = {name: (job.directory / source).read_text("utf-8") for name, source in sources.items()}
        files.mkdir(parents=True)
        for name, text in (file_texts | {"result.json": record}).items():
            (files / name).write_text(hide_private_paths(text, self.root), "utf-8", "replace")
        if job.arguments[0] != "pair":
            return None
        stored_result = open_stored_result(job.directory)
        return stored_result.num_finished, stored_result.study.ensemble.repetitions

    async def _monitor_progress(self, job: Job) -> None:
        """Monitor the progress of a command, and read its result each time the number of members has doubled."""
        num_reported = 2
        while True:
            await asyncio.sleep(POLL_INTERVAL)
            with suppress(*REPORTED_EXCEPTIONS):
                stored_result = await asyncio.to_thread(open_stored_result, job.directory)
                job.finished, job.total = stored_result.num_finished, stored_result.study.ensemble.repetitions
                if job.total > job.finished >= 2 * num_reported:
                    num_reported = job.finished
                    await self._read_result(job, "so far, at {finished} of {total} positions")
            if 0 < job.total == job.finished:
                job.activity = "computing the cutoff study and the onset of sliding"

    async def _read_result(self, job: Job, scope: str = "", **source: Any) -> None:
        """Read the finished part of a job's result, and write its report. `scope` is empty for the final result."""
        files = self._choose_directory()
        request = {"directory": str(job.directory), "name": job.directory.name,
                   "command": "" if scope else job.arguments[0],
                   "files": str(files), "root": str(self.root)}  # fmt: skip
        arguments = ["stiction.app.result_worker", json.dumps(request | source)]
        # The reader of a preview gets less memory, because the command of the job runs at the same time.
        memory = READER_MEMORY_FRACTION if source else JOB_MEMORY_FRACTION
        response = json.loads(await run_module(arguments, memory=memory))
        if response is None or (source and job.versions):
            return
        job.show_result(
            response["answer"],
            files,
            scope=scope and scope.format_map(response) + SCOPE_TEXT_SUFFIX,
            counts=None if source else (response["finished"], response["total"]),
        )

    def _choose_directory(self) -> Path:
        """Return an unused path for the directory of a job's result files."""
        self._directory_count += 1
        return self.root / "shared" / f"{self._directory_count}"

    async def evaluate_result(self, job: Job, numbers: list[float], dimension: float | None) -> str:
        """Return the JSON record of a job's result at another load (mN), mu0 and tau0 (GPa)."""
        load, mu0, tau0 = numbers
        options = [f"--load={load!r} mN", f"--mu0={mu0!r}", f"--tau0={tau0!r} GPa"]
        options += [] if dimension is None else [f"--d={dimension!r}"]
        return await self.run_module_in_reader_slot(["stiction", "at", str(job.directory), *options, "--json"])

    async def run_module_in_reader_slot(self, arguments: list[str]) -> str:
        """Run a Python module that takes little time, and return its output. Two modules may run in parallel."""
        async with self._reader_slots:
            return hide_private_paths(await run_module(arguments, memory=READER_MEMORY_FRACTION), self.root)


def _print_unexpected_error(task: asyncio.Task[None]) -> None:
    """Print the error of a failed task on the terminal of the app.

    Other tasks continue.
    """
    if not task.cancelled() and (error := task.exception()) is not None:
        context = {"message": "unexpected error in a job", "exception": error, "task": task}
        task.get_loop().call_exception_handler(context)


def _read_shown_values(job: Job, record: str) -> dict[str, Any]:
    """Read the coefficients and caveats that the app displays, from the JSON record that a job has printed."""
    return _read_shear_test(record) if job.arguments[0] == "shear" else _read_reported_point(record)


def _read_shear_test(record: str) -> dict[str, Any]:
    """Read the peak coefficient, the final coefficient and the caveats of a shear test from the test's JSON record."""
    shear_record, lines = json.loads(record), []
    for name, place_text in (("peak_friction_coefficient", "at the peak"), ("end_friction_coefficient", "at the end")):
        entry = next(quantity for quantity in shear_record["values"] if quantity["name"] == name)
        if entry["value"] is not None:
            lines.append({"place": place_text, "text": Estimate.from_record(entry).text(), "value": entry["value"]})
    return {"at": {}, "lines": lines, "caveats": [replace_option_names(caveat) for caveat in shear_record["caveats"]]}


def _read_reported_point(record: str) -> dict[str, Any]:
    """Return the first result point (one load, mu0 and tau0) that the JSON record of a pair marks as reported.

    If the record has no result points, its remark is raised as an error.
    """
    pair_record = json.loads(record)
    if "points" not in pair_record:
        raise RejectedRequestError(pair_record["remark"])
    return replace_option_names_in_caveats(next(point for point in pair_record["points"] if point["reported"]))


def memory_limit_command_prefix(memory: float) -> list[str]:
    """Return a command prefix that limits a command's memory, and kills the command when stiction ends.

    The prefix is empty if the system lacks the commands `setpriv` or `prlimit`.
    """
    if not (shutil.which("setpriv") and shutil.which("prlimit")):
        return []
    import resource

    max_bytes = int(memory * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    limits = resource.getrlimit(resource.RLIMIT_DATA)
    max_bytes = min([max_bytes, *(limit for limit in limits if limit != resource.RLIM_INFINITY)])
    return ["setpriv", "--pdeathsig=KILL", "prlimit", f"--data={max_bytes}"]


async def run_module(
    arguments: list[str], *, memory: float, grace_time: float = 0.0, on_record: Callable[[str], None] | None = None
) -> str:
    """Run a Python module in a process that ends with the server, and return its output up to the end of a JSON record.

    Without `on_record`, the process is killed after the record. Otherwise, `on_record` is called with the record, and
    the process runs until it ends. The process may use a fraction `memory` of the machine's memory. After a
    cancellation it has `grace_time` seconds to write its results. Raises `RejectedRequestError` with the message of the
    process.
    """
    async with _start_module(arguments, memory, grace_time) as (process, output_stream, error_task):
        output, has_record = await _read_record(output_stream)
        if has_record:
            if on_record is None:
                return output
            on_record(output)
            await output_stream.read()
        if (status := await process.wait()) != 0:
            raise RejectedRequestError(_failure_message(status, (await error_task).decode(errors="replace")))
        return output


@asynccontextmanager
async def _start_module(
    arguments: list[str], memory: float, grace_time: float
) -> AsyncIterator[tuple[Process, StreamReader, asyncio.Task[bytes]]]:
    """Start a Python module in a process, which is ended when the context ends.

    A task reads the error output, so that a full pipe does not block the process. A process that still runs on exit is
    interrupted, and killed after `grace_time` seconds.
    """
    process = await asyncio.create_subprocess_exec(
        *memory_limit_command_prefix(memory), sys.executable, "-P", "-m", *arguments, stdin=asyncio.subprocess.DEVNULL,
        stdout=PIPE, stderr=PIPE, limit=MAX_OUTPUT_BYTES,
    )  # fmt: skip
    output_stream, error_stream = process.stdout, process.stderr
    assert output_stream is not None and error_stream is not None  # noqa: PT018
    error_task = asyncio.create_task(error_stream.read())
    try:
        yield process, output_stream, error_task
    finally:
        if process.returncode is None and grace_time:
            process.send_signal(signal.SIGINT)
            with suppress(TimeoutError):
                await asyncio.wait_for(process.wait(), grace_time)
        if process.returncode is None:
            process.kill()
            # The connection of a killed process would stay open if the event loop closed before the process ends.
            with suppress(TimeoutError):
                await asyncio.wait_for(process.wait(), KILLED_PROCESS_TIMEOUT)
        error_task.cancel()


async def _read_record(stream: StreamReader) -> tuple[str, bool]:
    """Return output up to the end of a JSON record, and True. Without a record, return all output and False."""
    try:
        return (await stream.readuntil(END_OF_JSON_RECORD)).decode(), True
    except asyncio.LimitOverrunError:
        raise RejectedRequestError("the output of the command is too long for the page") from None
    except asyncio.IncompleteReadError as incomplete:
        return incomplete.partial.decode(), False


def _failure_message(status: int, error_output: str) -> str:
    """Return the error message for a failed command, from its exit status and its error output.

    A negative status is minus the number of the signal that ended the command.
    """
    if status < 0:
        return f"the system ended the command ({signal.Signals(-status).name}); memory may be insufficient"
    lines = [line.removeprefix("stiction: ") for line in error_output.splitlines()]
    messages = [line for line in lines if not line.startswith(("warning: ", PROGRESS_PREFIX, "try stiction "))]
    if messages and is_caused_by_unfit_core(messages[-1]):
        return UNFIT_CORE_MESSAGE
    return "\n".join(messages[-3:]) or "the command ended without a message"
