"""Running a study: blocks of members, a task each, on any executor."""

from __future__ import annotations

import contextlib
import itertools
import math
import queue
import shutil
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, wait
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._core import __version__
from stiction._files import half_written
from stiction._text import bytes_text, duration_text, named
from stiction.studies.executors import BROKEN, LOOK, check_workers, given_or_threads, progress_bar, result_of
from stiction.studies.members import about
from stiction.studies.pressed import cost_of_member
from stiction.studies.result import OF_MEMBERS, Arrays, bytes_of_member, dataset_of
from stiction.studies.store import BLOCKS, MOST_MEMORY, Stored, StoreError, begin, open_stored, put
from stiction.studies.study import Study
from stiction.studies.tasks import Folder, arrays_task, block_task
from stiction.studies.text import StudyError

if TYPE_CHECKING:
    import xarray

BLOCK_TIME = 1.5
"""Seconds of work in a block, of which a kill loses those in hand, and of which writing the file is a few per cent."""

MOST_MEMBERS = 4096
MOST_BYTES = 2**24
"""Largest block."""

FEWEST_BLOCKS = 16
"""Blocks of a study that has so many members: workers should not wait long for the last one."""

LEAST_TIME = 0.06
"""Seconds of work below which a block is not worth its file, which takes two milliseconds."""

MOST_SUBMITTED = 1000
"""Tasks that wait on an executor at a time, if their results are small."""

MOST_WAITING = 2**28
"""Bytes of results that may wait here, where workers do not write them."""

PATIENCE = 1.0
"""Seconds that an interrupted run waits for its workers to write what they have."""

MOST_IN_MEMORY = 2**34
"""Bytes of a result that is not stored."""


def block_size(study: Study) -> int:
    """Members in a block."""
    by_time = int(min(BLOCK_TIME / max(cost_of_member(study), 1e-9), MOST_MEMBERS))
    by_size = MOST_BYTES // bytes_of_member(study)
    total = study.ensemble.repetitions
    worth_it = min(math.ceil(LEAST_TIME / max(cost_of_member(study), 1e-9)), total // 4)
    return max(1, min(by_time, by_size, max(total // FEWEST_BLOCKS, worth_it)))


# ---- Runs -----------------------------------------------------------------------------------------------------------


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
        Folder that blocks of repetitions are written to as they are computed, by the workers themselves where they see
        it. One that holds repetitions of the same study already is continued: what it holds is not computed again, and
        more repetitions may be asked for. Without a store the result is held in memory.
    progress : bool
        Whether to draw a progress bar on the terminal.

    Returns
    -------
    xarray.Dataset
        The variables of `LoadCurve` over fractal_dimension, amplitude (µm), repetition and approach (µm), with their
        units, the study's text and the version of stiction as attributes. Of surfaces those of `SurfaceLoadCurve`; by
        the half-space those of `HalfSpaceCurve` over load (mN) in place of approach. A list of sliding rules or of
        directions is one more dimension, sliding or direction (degrees), of what depends on it. Of measured bodies the
        cut-off (µm) stands in place of fractal_dimension and amplitude, and there are statistics of the contacts.

    Raises
    ------
    ValueError
        If the study cannot be computed, its result takes more than 16 GiB of memory, or 2 GiB if it is stored, or the
        store cannot be written, is another study's, is damaged, or lacks repetitions and was begun by another version
        of stiction.

    Examples
    --------
    >>> from stiction import Study, run
    >>> small = {"ensemble.repetitions": 2, "surfaces.points": 3000}
    >>> run(Study.named("quick").with_changes(small))["contact_area"].dims
    ('fractal_dimension', 'amplitude', 'repetition', 'approach')
    """
    size = study.ensemble.repetitions * bytes_of_member(study)
    if size > (most := MOST_IN_MEMORY if store is None else MOST_MEMORY):
        advice = "give it a store" if store is None else "stiction.studies.runner.fill computes it without reading it"
        raise StudyError(
            f"the result would take {size / 2**30:.0f} GiB of memory, more than {most / 2**30:.0f}: {advice}, or take "
            "fewer ensemble.repetitions"
        )
    if store is None:
        return _in_memory(study.with_known_files(), executor, progress)
    return _filled(study, Path(store), None, executor, progress, None).dataset()


def fill(
    study: Study,
    folder: str | Path,
    *,
    part: tuple[int, int] | None = None,
    executor: Executor | None = None,
    progress: bool = False,
    say: Callable[[str], None] | None = None,
) -> int:
    """Compute what a folder lacks of a study, or of a part of it: of (3, 16) every 16th block from the third on.

    Processes with different parts share a folder, on any file system that all of them see. What they leave is computed
    by whoever comes without a part. Once the first tasks are handed out, `say` is told what lies ahead: bytes, files,
    hours, and who writes. Returns how many repetitions of the study, or of the part, the folder holds. Raises a
    `ValueError` as `run` does, and if there is no such part.
    """
    stored = _filled(study, Path(folder), part, executor, progress, say)
    own = _Missing(stored, part)
    return own.total - own.count


def _filled(
    study: Study,
    path: Path,
    part: tuple[int, int] | None,
    executor: Executor | None,
    progress: bool,
    say: Callable[[str], None] | None,
) -> Stored:
    """A folder that holds all members of a study, or of a part of it."""
    if part is not None and not 1 <= part[0] <= part[1]:
        raise ValueError(f"part must be K of N, as in 3/16, got {part[0]}/{part[1]}")
    study = study.with_known_files(path)
    _check_disk(study, path)
    stored = begin(path, study)
    missing = _Missing(stored, part)
    with contextlib.ExitStack() as stack:
        pool = stack.enter_context(given_or_threads(executor))
        advance = stack.enter_context(
            progress_bar("repetitions", missing.total, missing.total - missing.count, progress)
        )
        if missing.count:
            stack.enter_context(_kept(path, study))
            _compute(stored, missing, pool, advance, say)
    filled = Stored(path, study, open_stored(path).blocks)
    if _Missing(filled, part).count:
        raise StoreError(f"{named(path)}: was removed or replaced while it was being written")
    return filled


def _compute(
    stored: Stored, missing: _Missing, pool: Executor, advance: Callable[[int], None], say: Callable[[str], None] | None
) -> None:
    """Compute what is missing."""
    waiting: dict[Future[tuple[int, Any]], range] = {}
    with contextlib.ExitStack() as stack:
        stack.callback(wait, waiting, PATIENCE)  # after the token is gone, and workers write what they have
        folder = stack.enter_context(_token(stored.path))
        is_seen = result_of(pool.submit(folder.is_seen), pool)
        most = MOST_SUBMITTED
        if not is_seen:
            most = max(32, min(most, MOST_WAITING // (missing.block * bytes_of_member(stored.study))))
        # Closed before the executor is, or an interrupted run would first compute all that it has submitted.
        results = stack.enter_context(
            contextlib.closing(_results(stored.study, missing, pool, block_task, folder, most, waiting))
        )
        next(results)
        if say is not None:
            say(_ahead(stored, missing, is_seen))
        for members, content in results:
            if content is not None:
                put(stored.path, members[0], content, len(members))
            advance(len(members))


@contextlib.contextmanager
def _token(path: Path) -> Iterator[Folder]:
    """A file by which workers know that they see the folder, and that somebody waits for them."""
    folder = Folder(path.resolve(), half_written())
    token = folder.path / BLOCKS / folder.token
    try:
        token.touch(exist_ok=False)
    except OSError as error:
        raise StoreError(f"{named(path)}: cannot be written: {error.strerror}") from None
    try:
        yield folder
    finally:
        with contextlib.suppress(OSError):
            token.unlink(missing_ok=True)


@contextlib.contextmanager
def _kept(path: Path, study: Study) -> Iterator[None]:
    """Say in a StoreError how many members are finished, also where a worker has ended."""
    try:
        yield
    except (StoreError, BrokenExecutor) as error:
        try:
            kept = Stored(path, study, open_stored(path).blocks).finished.size
        except StoreError:
            raise error from None
        said = BROKEN if isinstance(error, BrokenExecutor) else error
        raise StoreError(
            f"{said}\n{kept} of {study.ensemble.repetitions} repetitions are finished and kept; running the study on "
            "it again continues from there"
        ) from None


def _check_disk(study: Study, path: Path) -> None:
    """Refuse what no disk of that size can hold."""
    size = study.ensemble.repetitions * bytes_of_member(study)
    with contextlib.suppress(OSError, RuntimeError):  # which beginning the folder says better
        disk = shutil.disk_usage(next(each for each in path.resolve().parents if each.exists())).total
        if size > disk > 0:
            raise StudyError(
                f"the result would take {bytes_text(size)}, and the disk of {named(path)} has {bytes_text(disk)} in "
                "all: take fewer ensemble.repetitions"
            )


def _in_memory(study: Study, executor: Executor | None, progress: bool) -> xarray.Dataset:
    nothing = Stored(Path(), study, ())
    missing = _Missing(nothing, None)
    axis = len(study.surfaces.cells())
    arrays: Arrays = {}
    with contextlib.ExitStack() as stack:
        pool = stack.enter_context(given_or_threads(executor))
        advance = stack.enter_context(progress_bar("repetitions", missing.total, 0, progress))
        results = _results(study, missing, pool, arrays_task, None, MOST_SUBMITTED, {})
        for members, sums in stack.enter_context(contextlib.closing(results)):
            for name, values in (sums or {}).items():
                at = 0 if name in OF_MEMBERS else axis
                if name not in arrays:
                    shape = (*values.shape[:at], missing.total, *values.shape[at + 1 :])
                    arrays[name] = np.empty(shape, values.dtype)
                arrays[name][(*(slice(None),) * at, slice(members.start, members.stop))] = values
            advance(len(members))
    return dataset_of(study, range(missing.total), arrays, about(study))


def _ahead(stored: Stored, missing: _Missing, is_seen: bool) -> str:
    """What lies ahead: time, files, and who writes where that is not the workers; how much is free where it matters."""
    study = stored.study
    free = shutil.disk_usage(stored.path).free
    files = sum(1 for _ in missing)
    size = missing.count * bytes_of_member(study)
    room = f", with {bytes_text(free)} free" if size > free / 2 else ""
    who = "" if is_seen else "; the workers do not see the folder, so this process writes them"
    return (
        f"computing {missing.count} repetitions: about {duration_text(missing.count * cost_of_member(study))} of one "
        f"core, {bytes_text(size)} in {files} {'file' if files == 1 else 'files'}{room}{who}"
    )


class _Missing:
    """The members of a study, or of a part of its blocks, that are not finished.

    A `block` has so many members; `total` are those of the study, or of the part, and `count` those of them that are
    missing.
    """

    def __init__(self, stored: Stored, part: tuple[int, int] | None) -> None:
        members = stored.study.ensemble.repetitions
        self.block = block_size(stored.study)
        first, step = (1, 1) if part is None else part
        self._blocks = range(first - 1, -(-members // self.block), step)
        self._is_finished = np.zeros(members, np.bool_)
        self._is_finished[stored.finished] = True
        own = [self._is_finished[block * self.block : (block + 1) * self.block] for block in self._blocks]
        self.total = sum(map(len, own))
        self.count = self.total - int(sum(np.count_nonzero(each) for each in own))

    def __iter__(self) -> Iterator[range]:
        """Those of each block that are missing, as far as they follow each other."""
        for block in self._blocks:
            first = block * self.block
            is_finished = self._is_finished[first : first + self.block]
            # Where a run of missing members begins, and where it ends.
            edges = np.flatnonzero(np.diff(np.concatenate([[True], is_finished, [True]]).astype(np.int8)))
            for start, end in edges.reshape(-1, 2).tolist():
                yield range(first + start, first + end)


def _results(
    study: Study,
    missing: _Missing,
    pool: Executor,
    task: Callable[..., tuple[int, Any]],
    folder: Folder | None,
    most: int,
    waiting: dict[Future[tuple[int, Any]], range],
) -> Generator[tuple[range, Any]]:
    """Blocks as they are done, and what their tasks return; so many tasks are submitted, and waiting, at a time.

    What comes first is nothing, as soon as they are. Tasks that have not begun when this is closed are cancelled.
    """
    blocks = iter(missing)
    # Not concurrent.futures.wait, which locks every one of them each time, and leaves some locked if it is interrupted.
    done: queue.SimpleQueue[Future[tuple[int, Any]]] = queue.SimpleQueue()

    def submit(members: range) -> None:
        future = pool.submit(task, __version__, study, members, folder)
        waiting[future] = members
        future.add_done_callback(done.put)

    try:
        for members in itertools.islice(blocks, most):
            submit(members)
        yield range(0), None
        while True:
            for members in itertools.islice(blocks, max(0, most - len(waiting))):
                submit(members)
            if not waiting:
                return
            try:
                future = done.get(timeout=LOOK)
            except queue.Empty:
                check_workers(pool)
                continue
            members = waiting.pop(future)
            count, result = future.result()
            if count < len(members):
                submit(members[count:])
            yield members[:count], result
            del future, result
    finally:
        for future in waiting:
            future.cancel()
