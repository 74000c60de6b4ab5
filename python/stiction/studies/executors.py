"""Executors of tasks, and how the progress of a run is shown."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, ThreadPoolExecutor
from typing import Any, TypeVar

from stiction.studies.text import StudyError

LEAST_SHARED = 2**16
"""Points of a problem whose transforms two threads share; those of smaller ones wait for each other too often."""

BROKEN = "a worker has ended before its time; perhaps memory is limited here"
_Result = TypeVar("_Result")


@contextlib.contextmanager
def given_or_threads(given: Executor | None) -> Iterator[Executor]:
    """Enter an executor that the caller shuts down, or where there is none, one with a thread for each core.

    Of a worker process that ends meanwhile a `StudyError` tells.
    """
    try:
        if given is not None:
            yield given
        else:
            with threads() as own:
                yield own
    except BrokenExecutor:
        raise StudyError(BROKEN) from None


@contextlib.contextmanager
def threads(workers: int | None = None) -> Iterator[Executor]:
    """Enter an executor with this many threads, by default one for each core; errors do not wait for its tasks.

    That no thread can be started is found out before anything is begun, and is a `RuntimeError`.
    """
    pool = ThreadPoolExecutor(workers or available_cores(), thread_name_prefix="stiction")
    pool.submit(int)
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


def sharing(function: Callable[..., _Result], executor: Executor, tasks: int, points: int) -> Callable[..., _Result]:
    """A function that is one of so many tasks of an executor and solves problems of so many points: who uses its cores.

    Each thread of the executor does a task of its own. Where these are fewer than its threads and large, the threads
    that are left share the transforms of each. Bits are the same.
    """
    workers = executor._max_workers if isinstance(executor, ThreadPoolExecutor) else 1
    each = workers // max(tasks, 1)
    if points < LEAST_SHARED or each < 2:
        return function

    def shared(*arguments: Any) -> _Result:
        import scipy.fft

        with scipy.fft.set_workers(each):
            return function(*arguments)

    return shared


def available_cores() -> int:
    """Count the cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def progress_bar(what: str, total: int, finished: int, wanted: bool) -> Iterator[Callable[..., None]]:
    """Show progress as a bar, on a terminal or in a notebook; enter a function that adds to the count."""
    if not wanted:
        yield lambda count=1: None
        return
    from importlib.util import find_spec

    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn(what), BarColumn(), MofNCompleteColumn(), TextColumn("elapsed"), TimeElapsedColumn(),
        TextColumn("left"), TimeRemainingColumn(),
    )  # fmt: skip
    is_notebook = Console().is_jupyter
    # In a notebook rich draws by ipywidgets, or not at all; a line of text at the end is better than that.
    console = Console(stderr=True, force_jupyter=None if find_spec("ipywidgets") else False)
    shown, passing = console.is_terminal or is_notebook, console.is_terminal
    with Progress(*columns, console=console, transient=passing, disable=not shown) as bar:
        task = bar.add_task("", total=total, completed=finished)
        yield lambda count=1: bar.advance(task, count)
