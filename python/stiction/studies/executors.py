"""Executors of tasks, results in the order of their arguments, and how the progress of a run is shown."""

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
"""Tasks of `in_order` that wait on an executor at a time, because their arguments may be whole profiles."""

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
    """Enter an executor that the caller shuts down, or where there is none, one with a thread for each core."""
    if given is not None:
        yield given
    else:
        with threads() as own:
            yield own


def threads(workers: int | None = None) -> Executor:
    """Make an executor with this many threads, by default one for each core.

    That no thread can be started is found out before anything is begun, and is a `RuntimeError`.
    """
    pool = ThreadPoolExecutor(workers or available_cores())
    pool.submit(int).result()
    return pool


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
