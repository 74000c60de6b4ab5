"""Where tasks are computed, in which order they come back, and how far they are."""

from __future__ import annotations

import collections
import contextlib
import itertools
import os
import sys
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import TypeVar

MOST_AHEAD = 16
"""Tasks that wait on an executor at a time, where their arguments are whole profiles."""

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
    """The results of a function, in the order of its arguments, of which some are submitted at a time."""
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
    """An executor that somebody else shuts down, or a thread for each core."""
    if given is not None:
        yield given
    else:
        with threads() as own:
            yield own


def threads(workers: int | None = None) -> Executor:
    """So many threads, or one for each core.

    Raises
    ------
    RuntimeError
        If not even one can be started: said before anything is begun.
    """
    pool = ThreadPoolExecutor(workers or available_cores())
    pool.submit(int).result()
    return pool


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def progress_bar(what: str, total: int, finished: int, wanted: bool) -> Iterator[Callable[..., None]]:
    """A bar on the terminal if it is wanted, or lines where there is none; what is called with how many more are."""
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
    """A line for every tenth, unless less than a second has gone by since the last."""
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
"""Seconds: what is quick says nothing."""
