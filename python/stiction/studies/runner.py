"""Running a study: one task per repetition, on any executor."""

from __future__ import annotations

import collections
import contextlib
import functools
import itertools
import os
import queue
import socket
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._core import __version__
from stiction.mechanics.contact import press
from stiction.mechanics.quantities import SUMS
from stiction.studies.study import Study, StudyError, study_from_text
from stiction.surfaces.fractal import Side, fill_family, random_phases
from stiction.surfaces.profile import scaled_profile

if TYPE_CHECKING:
    import xarray

Sums = dict[str, NDArray[Any]]

MOST_SUBMITTED = 1000
"""Tasks that wait on an executor at a time."""

MOST_AHEAD = 16
"""The same, where arguments are whole profiles."""

FAMILY_MEMORY = 64_000_000
"""Bytes of each body's profiles that a task holds at a time, so that its memory does not grow with the study."""


def repetition_sums(study: Study, repetition: int) -> Sums:
    """The sums of one repetition: each variable of `SUMS` as an array (fractal dimension, amplitude, approach)."""
    dimensions = study.surfaces.fractal_dimensions()
    amplitudes = study.surfaces.amplitudes()
    approaches = study.contact.approaches()
    model = study.contact.model()
    spacing = float(study.surfaces.extent) / study.surfaces.points
    measure = study.surfaces.amplitude_measure
    shape = (dimensions.size, amplitudes.size, approaches.size)
    sums: Sums = {name: np.empty(shape, np.int64 if name.endswith("_count") else np.float64) for name in SUMS}
    members = min(dimensions.size, max(1, FAMILY_MEMORY // (8 * study.surfaces.points)))
    memory = _memory((2, members + 1, study.surfaces.points))
    scratch = memory[:, -1]
    for first in range(0, dimensions.size, members):
        family = dimensions[first : first + members]
        uppers, lowers = memory[0, : family.size], memory[1, : family.size]
        _fill(uppers, study, repetition, "upper", family)
        _fill(lowers, study, repetition, "lower", family)
        for d, (upper, lower) in enumerate(zip(uppers, lowers, strict=True), start=first):
            for a, amplitude in enumerate(amplitudes):
                curve = press(
                    scaled_profile(upper, spacing, amplitude, measure, scratch[0]),
                    scaled_profile(lower, spacing, amplitude, measure, scratch[1]),
                    approaches,
                    model=model,
                )
                for name in SUMS:
                    sums[name][d, a] = getattr(curve, name)
    return sums


def task(version: str, study: str, repetition: int) -> Sums:
    """`repetition_sums`, wherever it is computed: the study as text, and the version that asks for it.

    Raises
    ------
    StudyError
        If another version of stiction is to compute it, whose results may differ.
    """
    if version != __version__:
        raise StudyError(
            f"the worker on {socket.gethostname()} has stiction {__version__}, and {version} asks for the study; "
            "install the same version everywhere"
        )
    return repetition_sums(_parsed(study), repetition)


@functools.lru_cache(maxsize=4)
def _parsed(text: str) -> Study:
    return study_from_text(text, "the study")


_kept = threading.local()


def _memory(shape: tuple[int, ...]) -> Floats:
    """An uninitialised array; a thread's tasks use the same again, because new pages are slow to come by."""
    memory: Floats | None = getattr(_kept, "memory", None)
    if memory is None or memory.shape != shape:
        _kept.memory = memory = np.empty(shape)
    return memory


def _fill(heights: Floats, study: Study, repetition: int, side: Side, dimensions: Floats) -> None:
    surfaces = study.surfaces
    phases = random_phases(
        study.ensemble.seed,
        repetition=repetition,
        side=side,
        directions=surfaces.directions,
        frequencies=surfaces.frequencies,
    )
    fill_family(
        heights,
        phases,
        dimensions,
        length_scale=float(surfaces.length_scale),
        gamma=surfaces.gamma,
        extent=float(surfaces.extent),
        convention=surfaces.convention,
        band_limit=None if surfaces.band_limit == "none" else surfaces.band_limit,
    )


def run(
    study: Study,
    *,
    executor: Executor | None = None,
    store: str | Path | None = None,
    progress: bool = False,
) -> xarray.Dataset:
    """Run a study.

    Parameters
    ----------
    study : Study
    executor : concurrent.futures.Executor, optional
        Where repetitions are computed; a thread for each core by default. Any executor gives the same bits.
    store : path, optional
        Zarr store that every repetition is written to as soon as it is computed. One that holds repetitions of the
        same study already is continued: what it holds is not computed again, and more repetitions may be asked for.
    progress : bool
        Whether to draw a progress bar on the terminal.

    Returns
    -------
    xarray.Dataset
        The variables of `LoadCurve` over fractal_dimension, amplitude (µm), repetition and approach (µm), with their
        units, the study's text and the version of stiction as attributes.

    Raises
    ------
    ValueError
        If the study cannot be computed, or the store cannot be written, is another study's, is damaged, is being
        written by somebody else, or lacks repetitions and was begun by another version of stiction.
    """
    from stiction.studies.dataset import empty_dataset
    from stiction.studies.store import opened

    with contextlib.ExitStack() as stack:
        kept = None if store is None else stack.enter_context(opened(store, study))
        result = empty_dataset(study) if kept is None else kept.result
        finished = frozenset() if kept is None else kept.finished
        pool = stack.enter_context(_executor(executor))
        advance = stack.enter_context(_progress_bar("repetitions", study.ensemble.repetitions, len(finished), progress))
        # Closed before the executor is, or an interrupted run would first compute all that it has submitted.
        for repetition, sums in stack.enter_context(contextlib.closing(_computed(study, finished, pool))):
            if kept is not None:
                kept.save(repetition, sums)
            for name, values in sums.items():
                result[name].values[:, :, repetition, :] = values
            advance()
    return result


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
    with _executor(executor) as pool, _progress_bar(what, total, 0, progress) as advance:
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
def _executor(given: Executor | None) -> Iterator[Executor]:
    if given is not None:
        yield given  # its owner shuts it down
    else:
        with ThreadPoolExecutor(max_workers=available_cores()) as own:
            yield own


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _computed(study: Study, finished: frozenset[int], pool: Executor) -> Generator[tuple[int, Sums]]:
    """Other repetitions as they are done; of however many, so many are submitted at a time."""
    repetitions = (each for each in range(study.ensemble.repetitions) if each not in finished)
    waiting: dict[Future[Sums], int] = {}
    # Not concurrent.futures.wait, which locks every one of them each time, and leaves some locked if it is interrupted.
    done: queue.SimpleQueue[Future[Sums]] = queue.SimpleQueue()
    text = study.to_toml()
    try:
        while True:
            for repetition in itertools.islice(repetitions, MOST_SUBMITTED - len(waiting)):
                future = pool.submit(task, __version__, text, repetition)
                waiting[future] = repetition
                future.add_done_callback(done.put)
            if not waiting:
                return
            future = done.get()
            yield waiting.pop(future), future.result()
    finally:
        for future in waiting:
            future.cancel()


@contextlib.contextmanager
def _progress_bar(what: str, total: int, finished: int, wanted: bool) -> Iterator[Callable[[], None]]:
    if not wanted:
        yield lambda: None
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
    in_notebook = None if find_spec("ipywidgets") else False
    with Progress(*columns, console=Console(stderr=True, force_jupyter=in_notebook)) as bar:
        task = bar.add_task("", total=total, completed=finished)
        yield lambda: bar.advance(task)
