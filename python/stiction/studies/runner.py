"""Running a study: one task per repetition, on any executor."""

from __future__ import annotations

import contextlib
import functools
import itertools
import queue
import socket
import threading
from collections.abc import Generator, Iterator
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._core import __version__
from stiction.studies.executors import given_or_threads, progress_bar
from stiction.studies.pairs import ProfileGenerator, scaled_surface, unscaled_surface
from stiction.studies.pressed import pressed
from stiction.studies.study import Study, study_from_text
from stiction.studies.study_text import StudyError
from stiction.surfaces.profile import AmplitudeMeasure, Profile, Side, scaled_profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

Sums = dict[str, NDArray[Any]]

SIDES: tuple[Side, Side] = ("upper", "lower")

MOST_SUBMITTED = 1000
"""Tasks that wait on an executor at a time."""

FAMILY_MEMORY = 64_000_000
"""Bytes of each body's profiles that a task holds at a time, so that its memory does not grow with the study."""


def repetition_sums(study: Study, repetition: int) -> Sums:
    """The sums of one repetition: each variable of a result as an array, without the dimension of repetitions."""
    from stiction.studies.dataset import empty_dataset

    variables = empty_dataset(study, [repetition]).data_vars
    sums: Sums = {str(name): np.empty_like(variable.values[:, :, 0]) for name, variable in variables.items()}
    pairs = _profiles(study, repetition) if study.surfaces.kind == "profile" else _surfaces(study, repetition)
    for place, upper, lower in pairs:
        for name, values in pressed(study, upper, lower).items():
            sums[name][place] = values.reshape(sums[name][place].shape)
    return sums


def _surfaces(study: Study, repetition: int) -> Iterator[tuple[tuple[int, int], Surface, Surface]]:
    """Each pair with its place (fractal dimension, amplitude)."""
    for d, dimension in enumerate(study.surfaces.fractal_dimensions()):
        upper, lower = (unscaled_surface(study, repetition, side, dimension) for side in SIDES)
        for a, amplitude in enumerate(study.surfaces.amplitudes()):
            yield (d, a), scaled_surface(study, upper, amplitude), scaled_surface(study, lower, amplitude)


def _profiles(study: Study, repetition: int) -> Iterator[tuple[tuple[int, int], Profile, Profile]]:
    """Each pair with its place (fractal dimension, amplitude); it is gone when the next one comes."""
    dimensions = study.surfaces.fractal_dimensions()
    amplitudes = study.surfaces.amplitudes()
    generator = ProfileGenerator.of(study)
    spacing = generator.spacing
    measure = cast("AmplitudeMeasure", study.surfaces.amplitude_measure)
    members = min(dimensions.size, max(1, FAMILY_MEMORY // (8 * study.surfaces.points)))
    memory = _memory((2, members + 1, study.surfaces.points))
    scratch = memory[:, -1]
    for first in range(0, dimensions.size, members):
        family = dimensions[first : first + members]
        uppers, lowers = memory[0, : family.size], memory[1, : family.size]
        generator.fill(uppers, family, repetition, "upper")
        generator.fill(lowers, family, repetition, "lower")
        for d, (upper, lower) in enumerate(zip(uppers, lowers, strict=True), start=first):
            for a, amplitude in enumerate(amplitudes):
                yield (
                    (d, a),
                    scaled_profile(upper, spacing, amplitude, measure, scratch[0]),
                    scaled_profile(lower, spacing, amplitude, measure, scratch[1]),
                )


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
        units, the study's text and the version of stiction as attributes. Of surfaces those of `SurfaceLoadCurve`; by
        the half-space those of `HalfSpaceCurve` over load (mN) in place of approach. A list of sliding rules or of
        directions is one more dimension, sliding or direction (degrees), of what depends on it.

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
        pool = stack.enter_context(given_or_threads(executor))
        advance = stack.enter_context(progress_bar("repetitions", study.ensemble.repetitions, len(finished), progress))
        # Closed before the executor is, or an interrupted run would first compute all that it has submitted.
        for repetition, sums in stack.enter_context(contextlib.closing(_computed(study, finished, pool))):
            if kept is not None:
                kept.save(repetition, sums)
            for name, values in sums.items():
                result[name].values[:, :, repetition] = values
            advance()
    return result


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
