"""Executors of tasks, and how the progress of a run is shown."""

from __future__ import annotations

import contextlib
import logging
import os
import re
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, ThreadPoolExecutor
from importlib import import_module
from typing import Any, TypeVar

from stiction._text import MAX_PATH_LENGTH, printable
from stiction._units import short_repr
from stiction.studies.values import StudyError

MIN_SHARED_POINTS = (
    2**16
)  # points of a problem whose transforms two threads share; in smaller ones they wait for each other
WORKER_DIED = "a worker has ended before its time; perhaps memory is limited here"
_Result = TypeVar("_Result")
PATIENCE = "15s"  # how long a scheduler may take to answer


@contextlib.contextmanager
def executor_or_threads(given: Executor | None) -> Iterator[Executor]:
    """Enter an executor that the caller shuts down, or one of threads; if a worker ends, a `StudyError` says so."""
    try:
        if given is not None:
            yield given
        else:
            with threads() as own:
                yield own
    except BrokenExecutor:
        raise StudyError(WORKER_DIED) from None


@contextlib.contextmanager
def threads(workers: int | None = None) -> Iterator[Executor]:
    """Enter an executor with so many threads, by default one for each core; a `RuntimeError` if none can be started."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    pool = ThreadPoolExecutor(workers or cores or 1, thread_name_prefix="stiction")
    pool.submit(int)
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


def share_threads(
    function: Callable[..., _Result], executor: Executor, tasks: int, points: int
) -> Callable[..., _Result]:
    """One of so many tasks of so many points; threads that few, large tasks leave share their transforms."""
    workers = executor._max_workers if isinstance(executor, ThreadPoolExecutor) else 1
    each = workers // max(tasks, 1)
    if points < MIN_SHARED_POINTS or each < 2:
        return function

    def shared(*arguments: Any) -> _Result:
        import scipy.fft

        with scipy.fft.set_workers(each):
            return function(*arguments)

    return shared


@contextlib.contextmanager
def progress_bar(what: str, total: int, finished: int, wanted: bool) -> Iterator[Callable[..., None]]:
    """Show progress as a bar, on a terminal or in a notebook; enter a function that adds to the count."""
    if not wanted:
        yield lambda count=1: None
        return
    from importlib.util import find_spec

    from rich import progress as shown
    from rich.console import Console

    columns = (
        shown.TextColumn(what), shown.BarColumn(), shown.MofNCompleteColumn(), shown.TextColumn("elapsed"),
        shown.TimeElapsedColumn(), shown.TextColumn("left"), shown.TimeRemainingColumn(),
    )  # fmt: skip
    is_notebook = Console().is_jupyter
    # In a notebook rich draws by ipywidgets, or not at all; a line of text at the end is better than that.
    console = Console(stderr=True, force_jupyter=None if find_spec("ipywidgets") else False)
    hidden = not (console.is_terminal or is_notebook)
    with shown.Progress(*columns, console=console, transient=console.is_terminal, disable=hidden) as bar:
        task = bar.add_task("", total=total, completed=finished)
        yield lambda count=1: bar.advance(task, count)


class ClusterError(ValueError):
    """A cluster that is not there, or cannot compute."""


@contextlib.contextmanager
def _without_disconnect_log() -> Iterator[None]:
    """Keep the client from logging a lost scheduler, tracebacks included, which a `ClusterError` reports."""
    loggers = [logging.getLogger(name) for name in ("distributed.client", "distributed.core", "tornado.application")]
    levels = [each.level for each in loggers]
    try:
        for each in loggers:
            each.setLevel(logging.CRITICAL)
        yield
    finally:
        for each, level in zip(loggers, levels, strict=True):
            each.setLevel(level)


@contextlib.contextmanager
def connect_cluster(address: str) -> Iterator[Executor]:
    """Connect to the workers of a scheduler by its address; a `ClusterError` without one, and where its workers die."""
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise ClusterError("a cluster needs the package distributed: pip install distributed") from None
    if not re.fullmatch(r"([a-z]+://)?[^\s/:]+:[0-9]{1,5}|([a-z]+://)\[[0-9a-fA-F:]+\]:[0-9]{1,5}", address):
        raise ClusterError(f"a Dask scheduler has an address such as tcp://host:8786, not {short_repr(address)}")
    try:
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ClusterError(
            f"no Dask scheduler answers at {short_repr(address)}: "
            f"{printable(str(error).splitlines()[0], MAX_PATH_LENGTH)}"
        ) from None
    with _without_disconnect_log(), client:
        try:
            if not client.nthreads():
                words = f"the scheduler at {short_repr(address)} has no workers yet; waiting for them"
                warnings.warn(words, stacklevel=3)
            yield client.get_executor()
        except distributed.scheduler.KilledWorker as error:
            raise ClusterError(f"a block was given up, because every worker that computed it died: {error}") from None
        except CancelledError:
            why = "the scheduler is gone; what was finished is kept, and the same command goes on"
            raise ClusterError(why) from None
