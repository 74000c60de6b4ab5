"""Execution of tasks in threads, on a cluster or in a forked process, with a progress bar."""

from __future__ import annotations

import builtins
import contextlib
import ctypes
import logging
import multiprocessing
import os
import re
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, ThreadPoolExecutor
from importlib import import_module
from typing import TYPE_CHECKING, Any, TypeVar, cast

from stiction._text import MAX_PATH_LENGTH, format_duration, printable_text
from stiction._threads import num_usable_cores, thread_pool_executor
from stiction._units import short_repr
from stiction._warnings import warn_caller
from stiction.study.values import StudyError

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.context import ForkProcess

MIN_THREADED_POINTS = 2**16
WORKER_DIED_MESSAGE = "a worker process ended unexpectedly; the available memory may be too small"
_Result = TypeVar("_Result")
CONNECTION_TIMEOUT = "15s"
# Number of the operation PR_SET_PDEATHSIG of the Linux function prctl.
_SET_PARENT_DEATH_SIGNAL = 1
PROGRESS_PREFIX = "progress: "
PROGRESS_LINE_INTERVAL = 60.0  # s


@contextlib.contextmanager
def executor_or_thread_pool(executor: Executor | None) -> Iterator[Executor]:
    """Yield the given executor or, without one, a thread pool that is closed when the context ends.

    Raises a `StudyError` if a worker process dies.
    """
    if executor is not None and not callable(getattr(executor, "submit", None)):
        raise StudyError(f"executor must be a concurrent.futures.Executor, got {type(executor).__name__}")
    try:
        if executor is not None:
            yield executor
        else:
            with thread_pool_executor() as pool:
                yield pool
    except BrokenExecutor:
        raise StudyError(WORKER_DIED_MESSAGE) from None


@contextlib.contextmanager
def evaluate_in_copy(function: Callable[[], _Result]) -> Iterator[Callable[[], _Result]]:
    """Evaluate a function in a forked copy of this process, and yield a function that waits for the returned value.

    The copy uses another core while this process runs Python code. If no copy can be made, or if it ends without a
    value, the yielded function evaluates the function in this process, which raises its errors.
    """
    if not _can_be_copied():
        yield function
        return
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_send_value, args=(function, receiver, sender), daemon=True)

    def receive_value() -> _Result:
        try:
            return cast("_Result", receiver.recv())
        except (EOFError, OSError):
            return function()

    with receiver:
        try:
            # Starting a process fails if a limit on processes or memory is reached.
            with sender, contextlib.suppress(OSError):
                _start_without_interrupts(process)
            yield receive_value
        finally:
            if process.pid is not None:
                process.kill()
                process.join()


def _start_without_interrupts(process: ForkProcess) -> None:
    """Start a forked copy of this process, in which Ctrl-C is blocked until the copy can handle it."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        # Python warns about copying a process that has threads, although OpenBLAS stops its threads in the copy.
        with warnings.catch_warnings(action="ignore", category=DeprecationWarning):
            process.start()
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def _can_be_copied() -> bool:
    """Return whether a forked copy of this process is safe and can use another core.

    A copy has none of the other threads, which may hold locks. On macOS, system libraries do not work in copies.
    """
    return (
        num_usable_cores() > 1
        and threading.active_count() == 1
        and not multiprocessing.current_process().daemon
        and sys.platform == "linux"
    )


def _send_value(function: Callable[[], Any], receiver: Connection, sender: Connection) -> None:
    """Call a function in a forked process, and send its value to the parent. Exit silently on an error or Ctrl-C.

    The forked process also ends if the original process is killed.
    """
    ctypes.CDLL(None).prctl(_SET_PARENT_DEATH_SIGNAL, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    receiver.close()
    with contextlib.suppress(Exception):
        sender.send(function())


def wrap_to_use_idle_threads(
    function: Callable[..., _Result], executor: Executor, tasks: int, points: int
) -> Callable[..., _Result]:
    """Wrap a task function so that idle threads of the pool take part in the task's Fourier transforms.

    Several threads compute each FFT if there are fewer tasks than threads and the grid is large. `tasks` is the number
    of tasks, and `points` is the number of grid points of each task.
    """
    num_workers = executor._max_workers if isinstance(executor, ThreadPoolExecutor) else 1
    threads_per_task = num_workers // max(tasks, 1)
    if points < MIN_THREADED_POINTS or threads_per_task < 2:
        return function

    def run_with_threads(*arguments: Any) -> _Result:
        import scipy.fft

        with scipy.fft.set_workers(threads_per_task):
            return function(*arguments)

    return run_with_threads


@contextlib.contextmanager
def progress_bar(
    label: str, total: int, finished: int, enabled: bool, estimate_progress: Callable[[], float] = lambda: 0.0
) -> Iterator[Callable[..., None]]:
    """Show a progress bar, and yield a function that adds newly finished tasks to the bar.

    A terminal or a notebook shows a progress bar after the first call of this function. Other output receives a line
    every `PROGRESS_LINE_INTERVAL`. Both show the number of finished tasks, unless there is only one task, and the
    percentage. `estimate_progress` returns the finished work beyond the number of finished tasks, in units of a task's
    mean work: the finished fractions of running tasks, and the excess of finished tasks with more work.

    Call the yielded function with 0 from time to time to update the display.
    """
    if not enabled:
        yield lambda count=1: None
        return
    with contextlib.ExitStack() as stack:
        show_progress: Callable[[float, int, str], None] | None = None
        may_show_bar = _may_show_progress_bar()
        start_time = last_time = time.monotonic()
        num_finished = finished

        def advance(count: int = 1) -> None:
            nonlocal num_finished, last_time, show_progress, may_show_bar
            num_finished += count
            completed, current_time = num_finished + estimate_progress(), time.monotonic()
            remaining_time = (
                (current_time - start_time) * (total - completed) / (completed - finished)
                if completed > finished
                else 0.0
            )
            remaining_text = format_duration(remaining_time) if completed > finished else "-"
            if show_progress is None and may_show_bar:
                # The package `rich`, which draws the progress bar, is imported while the workers already compute.
                show_progress = stack.enter_context(_progress_display(label, total, finished))
                may_show_bar = show_progress is not None
            if show_progress is not None:
                show_progress(completed, num_finished, remaining_text)
            elif current_time - last_time > PROGRESS_LINE_INTERVAL:
                last_time = current_time
                elapsed_text = format_duration(current_time - start_time)
                # With one task, the number of finished tasks would stay 0 until the end, so it is not printed.
                count_text = f"{num_finished}/{total} {label}, " if total > 1 else ""
                line = f"{count_text}{completed / total:.1%} after {elapsed_text}"
                line += f", about {remaining_text} left" if completed > finished else ""
                # Printing fails if standard error is closed.
                with contextlib.suppress(OSError):
                    print(f"{PROGRESS_PREFIX}{line}", file=sys.stderr, flush=True)

        yield advance


def _may_show_progress_bar() -> bool:
    """Return whether a progress bar may be visible on a terminal (standard error) or in a notebook.

    If True is returned, `rich` decides. Its import takes 50 ms.
    """
    return (
        (sys.stderr is not None and sys.stderr.isatty())
        or hasattr(builtins, "get_ipython")
        or not {"TTY_COMPATIBLE", "FORCE_COLOR"}.isdisjoint(os.environ)
    )


@contextlib.contextmanager
def _progress_display(label: str, total: int, finished: int) -> Iterator[Callable[[float, int, str], None] | None]:
    """Show a progress bar, and yield a function that sets finished work, finished tasks and remaining time.

    Yields None if there is neither a terminal nor a notebook.
    """
    from importlib.util import find_spec

    from rich import progress
    from rich.console import Console

    count_columns = (progress.TextColumn("{task.fields[num_finished]}/{task.total:.0f}"),) if total > 1 else ()
    columns = (
        progress.TextColumn(label), progress.BarColumn(), *count_columns, progress.TaskProgressColumn(),
        progress.TextColumn("elapsed"), progress.TimeElapsedColumn(), progress.TextColumn("left {task.fields[left]}"),
    )  # fmt: skip
    is_notebook = Console().is_jupyter
    # Without ipywidgets, rich would show no progress bar in a notebook, but one line of text at the end.
    console = Console(stderr=True, force_jupyter=None if find_spec("ipywidgets") else False)
    if not (console.is_terminal or is_notebook):
        yield None
        return
    with progress.Progress(*columns, console=console, transient=console.is_terminal) as display:
        task = display.add_task("", total=total, completed=finished, num_finished=finished, left="-")
        yield lambda completed, num_finished, left: display.update(
            task, completed=completed, num_finished=num_finished, left=left
        )


class ClusterError(ValueError):
    """Error raised if a Dask cluster cannot be reached or fails."""


@contextlib.contextmanager
def _suppress_disconnect_log() -> Iterator[None]:
    """Suppress Dask's messages about a lost scheduler, because a `ClusterError` reports the loss too."""
    loggers = [logging.getLogger(name) for name in ("distributed.client", "distributed.core", "tornado.application")]
    log_levels = [logger.level for logger in loggers]
    try:
        for logger in loggers:
            logger.setLevel(logging.CRITICAL)
        yield
    finally:
        for logger, level in zip(loggers, log_levels, strict=True):
            logger.setLevel(level)


@contextlib.contextmanager
def connect_to_cluster(address: str) -> Iterator[Executor]:
    """Connect to the Dask scheduler at an address, and yield an executor that runs tasks on the cluster.

    Raises a `ClusterError` if the scheduler does not respond, or if its workers die.
    """
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise ClusterError(
            "a Dask cluster requires the package 'distributed'; install it with: pip install distributed"
        ) from None
    if not re.fullmatch(r"([a-z]+://)?[^\s/:]+:[0-9]{1,5}|([a-z]+://)\[[0-9a-fA-F:]+\]:[0-9]{1,5}", address):
        raise ClusterError(
            f"the address of a Dask scheduler must have the form tcp://host:8786, got {short_repr(address)}"
        )
    try:
        client = distributed.Client(address, timeout=CONNECTION_TIMEOUT, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ClusterError(
            f"no Dask scheduler responds at {short_repr(address)}: "
            f"{printable_text(str(error).splitlines()[0], MAX_PATH_LENGTH)}"
        ) from None
    with _suppress_disconnect_log(), client:
        try:
            if not client.nthreads():
                message = f"the scheduler at {short_repr(address)} has no workers yet; waiting for them"
                warn_caller(message)
            yield client.get_executor()
        except distributed.scheduler.KilledWorker as error:
            raise ClusterError(f"the worker processes died while they computed a block of members: {error}") from None
        except CancelledError:
            message = "the connection to the scheduler was lost; finished blocks are kept, and the same command resumes"
            raise ClusterError(message) from None
