"""Executors of tasks, results in the order of their arguments, and how the progress of a run is shown."""

from __future__ import annotations

import collections
import contextlib
import itertools
import os
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from typing import Any, TypeVar

from stiction.studies.text import StudyError

MOST_AHEAD = 16
"""Tasks of `in_order` that wait on an executor at a time, because their arguments may be whole profiles."""

ENDED = "a worker has ended before its time"
BROKEN = f"{ENDED}; perhaps memory is limited here"

MOST_THREADS = 1000
"""As many as tasks of a run wait at a time."""

LOOK = 1.0
"""Seconds after which whoever waits for a task looks whether the threads are still there."""

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
                result = result_of(waiting.popleft(), pool)
                waiting.extend(pool.submit(function, each) for each in itertools.islice(rest, 1))
                advance()
                yield result
        finally:
            for future in waiting:
                future.cancel()


@contextlib.contextmanager
def given_or_threads(given: Executor | None) -> Iterator[Executor]:
    """Enter an executor that the caller shuts down, or where there is none, one with a thread for each core.

    Of a worker that ends meanwhile, a thread or a process, a `StudyError` tells.
    """
    try:
        if given is not None:
            yield given
        else:
            with threads() as own:
                yield own
    except BrokenExecutor:
        raise StudyError(BROKEN) from None


def threads(workers: int | None = None) -> Executor:
    """Make an executor with this many threads, at most 1000, by default one for each core.

    That a thread cannot be started is found out before anything is begun, and is a `RuntimeError`.
    """
    return _Threads(min(workers or available_cores(), MOST_THREADS))


class _Threads(ThreadPoolExecutor):
    """Threads that all begin at once, so that one that is missing later has ended."""

    _numbers = itertools.count()

    def __init__(self, count: int) -> None:
        self.count = count
        self.name = f"stiction-{next(self._numbers)}_"
        super().__init__(count, thread_name_prefix=self.name)
        begin = threading.Event()
        try:
            begun = [self.submit(begin.wait) for _ in range(count)]  # none is free for the next one before all are
        finally:
            begin.set()
        for each in begun:
            result_of(each, self)

    def check(self) -> None:
        """Raise a `BrokenExecutor` if a thread has ended."""
        if sum(each.name.startswith(self.name) for each in threading.enumerate()) < self.count:
            raise BrokenExecutor(ENDED)


def check_workers(pool: Executor) -> None:
    """Raise a `BrokenExecutor` if a thread of `threads` has ended: its task never will. Others notice that themselves.

    Python 3.11 ends a thread without a word that finds no memory for a call.
    """
    if isinstance(pool, _Threads):
        pool.check()


def result_of(future: Future[_Result], pool: Executor) -> _Result:
    """What a task of an executor returns; a `BrokenExecutor` if a worker has ended, as `check_workers` says."""
    while True:
        try:
            return future.result(LOOK)
        except TimeoutError:
            if future.done():  # just now, or by an error of this kind
                return future.result()
            check_workers(pool)


def all_of(pool: Executor, function: Callable[..., _Result], *arguments: Iterable[Any]) -> list[_Result]:
    """As `pool.map`, but that a worker that ends is noticed, as by `result_of`."""
    computing = [pool.submit(function, *each) for each in zip(*arguments, strict=True)]
    return [result_of(future, pool) for future in computing]


def available_cores() -> int:
    """Count the cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def progress_bar(what: str, total: int, finished: int, wanted: bool) -> Iterator[Callable[..., None]]:
    """Show progress as a bar, or as lines where there is no terminal; enter a function that adds to the count."""
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
    # In a notebook rich draws by ipywidgets, or not at all; a line of text at the end is better than that.
    notebook = Console(stderr=True).is_jupyter
    console = Console(stderr=True, force_jupyter=None if find_spec("ipywidgets") else False)
    if not (console.is_terminal or notebook):
        yield _progress_lines(what, total, finished)
        return
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("", total=total, completed=finished)
        yield lambda count=1: bar.advance(task, count)


def _progress_lines(what: str, total: int, finished: int) -> Callable[..., None]:
    """Print a line for every tenth, unless less than a second has gone by since the last one."""
    started = said = time.monotonic()
    number = finished

    def advance(count: int = 1) -> None:
        nonlocal said, number
        now, number = time.monotonic(), number + count
        tenth = (10 * number) // total > (10 * (number - count)) // total
        if tenth and number < total and now - said >= LINES_APART:
            said, passed = now, now - started
            left = passed * (total - number) / (number - finished)
            print(f"{what} {number} of {total}, {passed:.0f} s, about {left:.0f} s left", file=sys.stderr, flush=True)

    return advance


LINES_APART = 1.0
"""Least seconds between lines of progress, so that a short run prints none."""
