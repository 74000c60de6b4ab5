"""Running a study: blocks of repetitions, a task each, on any executor."""

from __future__ import annotations

import contextlib
import functools
import itertools
import math
import queue
import shutil
import socket
import threading
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._core import __version__
from stiction._text import named
from stiction.studies.dataset import empty_dataset, variables_of
from stiction.studies.executors import given_or_threads, progress_bar
from stiction.studies.pairs import FAMILY_MEMORY, ProfileGenerator, scaled_surface, unscaled_surface
from stiction.studies.pressed import pressed, pressed_families
from stiction.studies.study import Study, study_from_text
from stiction.studies.study_text import StudyError
from stiction.surfaces.profile import AmplitudeMeasure, Profile, Side, scaled_profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

    from stiction.studies.blocks import Writing
    from stiction.studies.store import Store

Sums = dict[str, NDArray[Any]]

SIDES: tuple[Side, Side] = ("upper", "lower")

MOST_SUBMITTED = 1000
"""Tasks that wait on an executor at a time, if their results are small."""

MOST_WAITING = 2**28
"""Bytes of results that may wait to be stored here, where workers do not store them."""

SLOW = 1.0
"""Seconds of a pair above which nothing else matters."""

TASK = 2.0
"""Seconds after which a task begins no further repetition, but has those stored that it has: the most that is lost."""

MOST_PACKED = 10
"""Times that numbers may take more room than on the disk."""

MOST_MEMORY = 16 * 2**30
"""Bytes of a result that is not stored."""

CACHE_LINE = 64
"""Bytes."""


def repetition_sums(study: Study, repetition: int) -> Sums:
    """The sums of one repetition: each variable of a result as an array, without the dimension of repetitions."""
    sums: Sums = {name: np.empty(shape, dtype) for name, (shape, dtype) in _arrays(study).items()}
    is_profile, asperities = study.surfaces.kind == "profile", study.contact.mechanics == "asperities"
    if is_profile and asperities:
        parts: Iterator[tuple[Any, Sums]] = _families(study, repetition)
    else:
        pairs = _profiles(study, repetition) if is_profile else _surfaces(study, repetition)
        parts = ((place, pressed(study, upper, lower)) for place, upper, lower in pairs)
    for place, part in parts:
        for name, values in part.items():
            sums[name][place] = values.reshape(sums[name][place].shape)
    return sums


@functools.lru_cache(maxsize=4)
def _arrays(study: Study) -> dict[str, tuple[tuple[int, ...], np.dtype[Any]]]:
    """Shape and kind of each variable of a repetition."""
    variables = variables_of(study, [0]).items()
    return {name: ((*each.shape[:2], *each.shape[3:]), each.dtype) for name, each in variables}


def _surfaces(study: Study, repetition: int) -> Iterator[tuple[tuple[int, int], Surface, Surface]]:
    """Each pair with its place (fractal dimension, amplitude)."""
    for d, dimension in enumerate(study.surfaces.fractal_dimensions()):
        upper, lower = (unscaled_surface(study, repetition, side, dimension) for side in SIDES)
        for a, amplitude in enumerate(study.surfaces.amplitudes()):
            yield (d, a), scaled_surface(study, upper, amplitude), scaled_surface(study, lower, amplitude)


def _families(study: Study, repetition: int) -> Iterator[tuple[slice, Sums]]:
    """Pairs of some fractal dimensions at a time, pressed together."""
    for place, uppers, lowers, scratch in _generated(study, repetition):
        yield place, pressed_families(study, uppers, lowers, scratch)


def _profiles(study: Study, repetition: int) -> Iterator[tuple[tuple[int, int], Profile, Profile]]:
    """Each pair with its place (fractal dimension, amplitude); it is gone when the next one comes."""
    spacing = ProfileGenerator.of(study).spacing
    measure = cast("AmplitudeMeasure", study.surfaces.amplitude_measure)
    for place, (uppers, _), (lowers, _), scratch in _generated(study, repetition):
        for d, (upper, lower) in enumerate(zip(uppers, lowers, strict=True), start=place.start):
            for a, amplitude in enumerate(study.surfaces.amplitudes()):
                yield (
                    (d, a),
                    scaled_profile(upper, spacing, amplitude, measure, scratch[0]),
                    scaled_profile(lower, spacing, amplitude, measure, scratch[1]),
                )


def _generated(
    study: Study, repetition: int
) -> Iterator[tuple[slice, tuple[Floats, Floats], tuple[Floats, Floats], Floats]]:
    """Unscaled profiles and their levels at some fractal dimensions at a time, and memory for a scaled pair."""
    dimensions = study.surfaces.fractal_dimensions()
    generator = ProfileGenerator.of(study)
    members = min(dimensions.size, max(1, FAMILY_MEMORY // (8 * study.surfaces.points)))
    memory = _memory((2 * members + 2, study.surfaces.points))
    for first in range(0, dimensions.size, members):
        family = dimensions[first : first + members]
        uppers, lowers = memory[: family.size], memory[members : members + family.size]
        yield (
            slice(first, first + family.size),
            (uppers, generator.fill(uppers, family, repetition, "upper")),
            (lowers, generator.fill(lowers, family, repetition, "lower")),
            memory[-2:],
        )


def task(version: str, study: str, repetitions: Sequence[int], writing: Writing | None) -> tuple[int, Sums | None]:
    """Some repetitions of a block, wherever they are computed: as many of the first as there is time for.

    Parameters
    ----------
    version : str
        Of the stiction that asks for them.
    study : str
        As text.
    repetitions : sequence of int
    writing : Writing, optional
        The store that they go to.

    Returns
    -------
    count : int
        How many were computed.
    sums : dict, optional
        What `repetition_sums` has of each, stacked as the third dimension; None if they are stored already, because the
        store is seen from here.

    Raises
    ------
    StudyError
        If another version of stiction is to compute it, whose results may differ.
    StoreError, NotWrittenError
        If they cannot be stored.
    """
    if version != __version__:
        raise StudyError(
            f"the worker on {socket.gethostname()} has stiction {__version__}, and {version} asks for the study; "
            "install the same version everywhere"
        )
    parsed, until = _parsed(study), time.monotonic() + TASK
    shared = writing is not None and writing.is_shared()
    # Somebody who was killed before they said so may have stored some.
    stored = writing.stored(repetitions) if writing is not None and shared else frozenset()
    done: dict[int, Sums] = {}
    count = 0
    for repetition in repetitions:
        if repetition not in stored:
            try:
                done[repetition] = repetition_sums(parsed, repetition)
            except ValueError:
                if not count:
                    raise
                break  # it will be the first of what is left
        count += 1
        if time.monotonic() > until:
            break
    if not done:
        return count, None
    sums = {name: np.stack([each[name] for each in done.values()], axis=2) for name in _arrays(parsed)}
    if writing is not None and shared and writing.save(list(done), sums):
        return count, None
    return count, sums


@functools.lru_cache(maxsize=4)
def _parsed(text: str) -> Study:
    return study_from_text(text, "the study")


_kept = threading.local()


def _memory(shape: tuple[int, ...]) -> Floats:
    """An uninitialised array; a thread's tasks use the same again, because new pages are slow to come by.

    It begins on a line of the cache: wide writes across two lines cost two.
    """
    memory: Floats | None = getattr(_kept, "memory", None)
    if memory is None or memory.shape != shape:
        whole = np.empty(math.prod(shape) + CACHE_LINE // 8)
        begin = -whole.__array_interface__["data"][0] % CACHE_LINE // 8
        _kept.memory = memory = whole[begin : begin + math.prod(shape)].reshape(shape)
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
        Zarr store that repetitions are written to as they are computed, by the workers themselves where they see it.
        One that holds repetitions of the same study already is continued: what it holds is not computed again, and more
        repetitions may be asked for. Without a store the result is held in memory.
    progress : bool
        Whether to draw a progress bar on the terminal.

    Returns
    -------
    xarray.Dataset
        The variables of `LoadCurve` over fractal_dimension, amplitude (µm), repetition and approach (µm), with their
        units, the study's text and the version of stiction as attributes. Of surfaces those of `SurfaceLoadCurve`; by
        the half-space those of `HalfSpaceCurve` over load (mN) in place of approach. A list of sliding rules or of
        directions is one more dimension, sliding or direction (degrees), of what depends on it. Of a stored result that
        is larger than 256 MiB, variables are read from there when something of them is asked for.

    Raises
    ------
    ValueError
        If the study cannot be computed, or the store cannot be written, is another study's, is damaged, is being
        written by somebody else, or lacks repetitions and was begun by another version of stiction.
    """
    if store is None:
        return _in_memory(study, executor, progress)
    return computed(study, store, executor=executor, progress=progress)


def computed(
    study: Study,
    store: str | Path,
    *,
    part: tuple[int, int] | None = None,
    executor: Executor | None = None,
    progress: bool = False,
    say: Callable[[str], None] | None = None,
) -> xarray.Dataset:
    """`run` into a store; or one of so many parts, such as (3, 16): every 16th block from the third on.

    Processes with different parts share a store, which any file system will do for that all see and that locks. What
    they leave is computed by whoever comes without a part.

    Parameters
    ----------
    say : function, optional
        Is told what lies ahead once the first tasks are handed out: bytes, files, hours, and who writes.

    Returns
    -------
    xarray.Dataset
        Of the whole study, or of the part.

    Raises
    ------
    ValueError
        As `run`; and if the same part is being computed by somebody else, or there is no such part.
    """
    with _filled(study, store, part, executor, progress, say) as (kept, repetitions):
        return kept.dataset(repetitions)


def fill(
    study: Study,
    store: str | Path,
    *,
    part: tuple[int, int] | None = None,
    executor: Executor | None = None,
    progress: bool = False,
    say: Callable[[str], None] | None = None,
) -> int:
    """`computed` for whoever reads the store afterwards: how many repetitions of the study, or the part, it holds."""
    with _filled(study, store, part, executor, progress, say) as (_, repetitions):
        return int(repetitions.size)


@contextlib.contextmanager
def _filled(
    study: Study,
    store: str | Path,
    part: tuple[int, int] | None,
    executor: Executor | None,
    progress: bool,
    say: Callable[[str], None] | None,
) -> Iterator[tuple[Store, NDArray[np.intp]]]:
    """A store that holds all repetitions of a study, or of a part of it, and which these are."""
    from stiction.studies.store import opened

    if part is not None and not 1 <= part[0] <= part[1]:
        raise ValueError(f"part must be one of so many, as in 3/16, got {part[0]}/{part[1]}")
    _check_disk(study, Path(store))
    with contextlib.ExitStack() as stack:
        kept = stack.enter_context(opened(store, study, part))
        missing = _Missing(study.ensemble.repetitions, kept.block, kept.finished, part)
        pool = stack.enter_context(given_or_threads(executor))
        most = MOST_SUBMITTED
        if missing.count:
            shared = pool.submit(_is_shared, kept.writing).result()
            if not shared:
                most = max(32, min(most, MOST_WAITING // (kept.block * _size(study))))
        here = missing.total - missing.count
        advance = stack.enter_context(progress_bar("repetitions", missing.total, here, progress))
        stack.enter_context(kept.refusals())
        # Closed before the executor is, or an interrupted run would first compute all that it has submitted.
        results = stack.enter_context(contextlib.closing(_results(study, missing, pool, kept.writing, most)))
        next(results)
        if missing.count and say is not None:
            say(_ahead(study, missing, kept.block, Path(store), shared))
        for repetitions, sums in results:
            if sums is not None:
                kept.save(repetitions, sums)
            advance(len(repetitions))
        yield kept, missing.all()


def _check_disk(study: Study, store: Path) -> None:
    """Refuse what cannot be: numbers pack to a tenth at best."""
    size = study.ensemble.repetitions * _size(study)
    with contextlib.suppress(OSError, RuntimeError):  # which opening the store says better
        disk = shutil.disk_usage(next(each for each in store.resolve().parents if each.exists())).total
        if size > MOST_PACKED * disk > 0:
            raise StudyError(
                f"the result would take up to {_bytes(size)}, and the disk of {named(store)} has {_bytes(disk)} in "
                "all: take fewer ensemble.repetitions"
            )


def _in_memory(study: Study, executor: Executor | None, progress: bool) -> xarray.Dataset:
    total = study.ensemble.repetitions
    size = total * _size(study)
    if size > MOST_MEMORY:
        raise StudyError(
            f"the result would take {size / 2**30:.0f} GiB of memory, more than {MOST_MEMORY / 2**30:.0f}: give it a "
            "store, or take fewer ensemble.repetitions"
        )
    result = empty_dataset(study)
    arrays = {str(name): each.values for name, each in result.data_vars.items()}
    missing = _Missing(total, 1, np.empty(0, np.intp), None)
    with contextlib.ExitStack() as stack:
        pool = stack.enter_context(given_or_threads(executor))
        advance = stack.enter_context(progress_bar("repetitions", total, 0, progress))
        for repetitions, sums in stack.enter_context(
            contextlib.closing(_results(study, missing, pool, None, MOST_SUBMITTED))
        ):
            for name, values in (sums or {}).items():
                arrays[name][:, :, repetitions] = values
            advance(len(repetitions))
    return result


def _ahead(study: Study, missing: _Missing, block: int, store: Path, shared: bool) -> str:
    """What lies ahead: bytes before they are packed, files, time by fractal dimensions in the middle, who writes."""
    dimensions = study.surfaces.fractal_dimensions().tolist()

    def taken(count: int) -> float:
        middle = len(dimensions) // 2
        some = study.with_changes({"surfaces.fractal_dimension": dimensions[middle : middle + count]})
        began = time.thread_time()
        repetition_sums(some, 0)
        return time.thread_time() - began

    one = further = taken(1)
    if one < SLOW:  # what many have in common counts, and the first time everything is slower
        (_, one), (_, three) = ((taken(count), taken(count)) for count in (1, 3))
        further = max(three - one, 0.0) / 2
    seconds = (one + (len(dimensions) - 1) * further) * missing.count
    files = -(-missing.count // block) * (len(study.sums()) + 1)
    free = shutil.disk_usage(store).free
    who = "the workers write them" if shared else "the workers do not see the store, so this process writes them"
    return (
        f"to compute: {missing.count} repetitions, up to {_bytes(missing.count * _size(study))} in {files} files "
        f"({_bytes(free)} are free), about {_time(seconds)} of one core; {who}"
    )


def _bytes(size: float) -> str:
    power = min(4, max(1, int(math.log(max(size, 1), 1000))))
    return f"{size / 1000**power:.3g} {' kMGT'[power]}B"


def _time(seconds: float) -> str:
    for most, unit in ((60, "s"), (60, "min"), (48, "hours")):
        if seconds < most:
            return f"{seconds:.2g} {unit}"
        seconds /= most if unit != "hours" else 24
    return f"{seconds:.3g} days"


def _is_shared(writing: Writing) -> bool:
    """Whether a worker sees the store, asked there."""
    return writing.is_shared()


def _size(study: Study) -> int:
    """Bytes of a repetition."""
    return sum(dtype.itemsize * math.prod(shape) for shape, dtype in _arrays(study).values())


class _Missing:
    """The repetitions of a study, or of a part of its blocks, that are not finished."""

    def __init__(self, total: int, block: int, finished: NDArray[np.intp], part: tuple[int, int] | None) -> None:
        self._block = block
        self._blocks = range(-(-total // block)) if part is None else range(part[0] - 1, -(-total // block), part[1])
        self._is_finished = np.zeros(total, np.bool_)
        self._is_finished[finished] = True
        own = self.all()
        self.total = own.size
        self.count = int(own.size - self._is_finished[own].sum())

    def all(self) -> NDArray[np.intp]:
        """Finished or not."""
        blocks = np.asarray(self._blocks, np.intp)
        numbers = (blocks[:, np.newaxis] * self._block + np.arange(self._block)).ravel()
        return np.asarray(numbers[numbers < self._is_finished.size])

    def __iter__(self) -> Iterator[list[int]]:
        """Those of each block that are missing."""
        for block in self._blocks:
            first = block * self._block
            missing = np.flatnonzero(~self._is_finished[first : first + self._block])
            if missing.size:
                yield (first + missing).tolist()


def _results(
    study: Study, missing: _Missing, pool: Executor, writing: Writing | None, most: int
) -> Generator[tuple[list[int], Sums | None]]:
    """Repetitions of a block as they are done, and their sums if they are not stored; so many blocks are submitted.

    What comes first is nothing, as soon as they are.
    """
    blocks = iter(missing)
    waiting: dict[Future[tuple[int, Sums | None]], list[int]] = {}
    # Not concurrent.futures.wait, which locks every one of them each time, and leaves some locked if it is interrupted.
    done: queue.SimpleQueue[Future[tuple[int, Sums | None]]] = queue.SimpleQueue()
    text = study.to_toml()

    def submit(repetitions: list[int]) -> None:
        future = pool.submit(task, __version__, text, repetitions, writing)
        waiting[future] = repetitions
        future.add_done_callback(done.put)

    try:
        for repetitions in itertools.islice(blocks, most):
            submit(repetitions)
        yield [], None
        while True:
            for repetitions in itertools.islice(blocks, max(0, most - len(waiting))):
                submit(repetitions)
            if not waiting:
                return
            future = done.get()
            repetitions = waiting.pop(future)
            count, sums = future.result()
            if count < len(repetitions):
                submit(repetitions[count:])
            yield repetitions[:count], sums
            del future, sums
    finally:
        for future in waiting:
            future.cancel()
