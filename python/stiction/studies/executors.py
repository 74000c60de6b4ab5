"""Executors of tasks, results in the order of their arguments, and how the progress of a run is shown."""

from __future__ import annotations

import collections
import contextlib
import itertools
import os
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, ThreadPoolExecutor
from typing import TypeVar

from stiction.studies.text import StudyError

MOST_AHEAD = 16
"""Tasks of `in_order` that wait on an executor at a time, because their arguments may be whole profiles."""

BROKEN = "a worker has ended before its time; perhaps memory is limited here"

_Argument = TypeVar("_Argument")
_Result = TypeVar("_Result")


def in_order(
    function: Callable[[_Argument], _Result],
    arguments: Iterable[_Argument],
    *,
    total: int,
    what: str,
    executor: Executor | None,
    progress: bool,
) -> Generator[_Result]:
    """Compute a function of many arguments on an executor; its results come in the order of the arguments."""
    with given_or_threads(executor) as pool, progress_bar(what, total, 0, progress) as advance:
        rest = iter(arguments)
        waiting = collections.deque(pool.submit(function, each) for each in itertools.islice(rest, MOST_AHEAD))
        try:
            while waiting:
                result = waiting.popleft().result()
                waiting.extend(pool.submit(function, each) for each in itertools.islice(rest, 1))
                advance()
                yield result
        finally:
            for future in waiting:
                future.cancel()


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
        TextColumn(what),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("elapsed"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    is_notebook = Console().is_jupyter
    # In a notebook rich draws by ipywidgets, or not at all; a line of text at the end is better than that.
    console = Console(stderr=True, force_jupyter=None if find_spec("ipywidgets") else False)
    with Progress(*columns, console=console, disable=not (console.is_terminal or is_notebook)) as bar:
        task = bar.add_task("", total=total, completed=finished)
        yield lambda count=1: bar.advance(task, count)
