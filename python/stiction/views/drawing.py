"""Pictures of a study in processes beside each other: Python draws on one core, and what drawing needs loads slowly."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from stiction._dask import hide_dask
from stiction.studies.executors import available_cores
from stiction.studies.processes import WorkerError, processes

if TYPE_CHECKING:
    import xarray

_NEEDED = (
    "xarray",
    "stiction.studies.store",
    "stiction.views.answers",
    "matplotlib.figure",
    "matplotlib.backends.backend_agg",
)
"""Of drawing and of answers, in the order in which they are needed."""


@contextlib.contextmanager
def drawing(store: Path, directory: Path) -> Iterator[Callable[[], tuple[list[Path], str]]]:
    """What draws a stored result into a directory when it is called, and gives its files and its answers as text.

    A process gets ready for it meanwhile. What has all that is needed already draws by itself.
    """
    if all(name in sys.modules for name in _NEEDED):
        yield lambda: _drawn(store, directory)
        return
    with processes(1) as pool:
        pool.submit(_get_ready)

        def drawn() -> tuple[list[Path], str]:
            try:
                return pool.submit(_drawn, store, directory).result()
            except (OSError, WorkerError):  # there is no room for another process
                return _drawn(store, directory)

        yield drawn


def _get_ready() -> None:
    hide_dask()
    with contextlib.suppress(ImportError):  # said where it is needed
        for name in _NEEDED:
            import_module(name)
        from stiction.views.style import warm_up

        warm_up()


def _drawn(store: Path, directory: Path) -> tuple[list[Path], str]:
    from stiction.studies.store import read
    from stiction.views.answers import answers_text

    dataset = read(store)
    return draw(dataset, directory), answers_text(dataset)


def draw(dataset: xarray.Dataset, directory: Path) -> list[Path]:
    """`save_figures`, by two processes where there are as many cores, and one can be a copy of the other."""
    from stiction.views.figures import pictures

    found = list(pictures(dataset, directory))
    if len(found) == 1 or available_cores() == 1 or sys.platform != "linux":
        return [each() for _, each in found]
    other = multiprocessing.get_context("fork").Process(target=_draw_and_end, args=([each for _, each in found[1::2]],))
    try:
        with warnings.catch_warnings(action="ignore", category=DeprecationWarning):  # of threads, which wait
            other.start()
    except OSError:  # there is no room for another process
        return [each() for _, each in found]
    try:
        for _, each in found[::2]:
            each()
    finally:
        other.join()
    if other.exitcode:  # whatever it was is said here
        for _, each in found[1::2]:
            each()
    return [path for path, _ in found]


def _draw_and_end(pictures: Sequence[Callable[[], object]]) -> None:
    try:
        for each in pictures:
            each()
    except BaseException:
        os._exit(1)
    os._exit(0)
