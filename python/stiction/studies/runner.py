"""Running a study: blocks of members, a task each, on any executor."""

from __future__ import annotations

import contextlib
import itertools
import math
import queue
import shutil
import socket
import time
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._core import __version__
from stiction._files import new_partial_name
from stiction._text import format_bytes, format_duration, printable_path
from stiction.studies.executors import BROKEN, given_or_threads, progress_bar, sharing
from stiction.studies.layout import OF_MEMBERS, Arrays, bytes_of_member, dataset_of, stacked
from stiction.studies.member_solution import cost_of_member, member_sums
from stiction.studies.members import about, points_of_member
from stiction.studies.result import Result
from stiction.studies.store import BLOCKS, Stored, StoreError, begin, put
from stiction.studies.study import Study
from stiction.studies.values import StudyError

if TYPE_CHECKING:
    import xarray

BLOCK_TIME = 1.5  # seconds of work in a block, which a kill loses, and of which writing the file is a few per cent
MOST_MEMBERS = 4096
MOST_BYTES = 2**24  # largest block
FEWEST_BLOCKS = 16  # blocks of a study that has so many members: workers should not wait long for the last one
LEAST_TIME = 0.06  # seconds of work below which a block is not worth its file, which takes some milliseconds
MOST_SUBMITTED = 1000  # tasks that wait on an executor at a time, if their results do not come here
FEWEST_SUBMITTED = 256  # tasks whose results come here, so that the workers of a large machine all have one
PATIENCE = 3.0  # seconds that an interrupted run waits for the blocks in hand
MOST_IN_MEMORY = 2**34  # bytes of a result that is not stored


def block_size(study: Study) -> int:
    """Members in a block."""
    by_time = int(min(BLOCK_TIME / max(cost_of_member(study), 1e-9), MOST_MEMBERS))
    by_size = MOST_BYTES // bytes_of_member(study)
    total = study.ensemble.repetitions
    worth_it = min(math.ceil(LEAST_TIME / max(cost_of_member(study), 1e-9)), total // 4)
    return max(1, min(by_time, by_size, max(total // FEWEST_BLOCKS, worth_it)))


# ---- Runs -----------------------------------------------------------------------------------------------------------


def run(
    study: Study, *, executor: Executor | None = None, store: str | Path | None = None, progress: bool = False
) -> Result:
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
    Result
        Its `dataset` has the variables of `LoadCurve` over fractal_dimension, amplitude (µm), repetition and approach
        (µm), with their units, the study's text and the version of stiction as attributes. Of surfaces those of
        `SurfaceLoadCurve`; by the half-space those of `HalfSpaceCurve` over load (mN) in place of approach. A list of
        sliding rules or of directions is one more dimension, sliding or direction (degrees), of what depends on it. Of
        measured bodies the cut-off (µm) stands in place of fractal_dimension and amplitude, and there are statistics of
        the contacts.

    Raises
    ------
    ValueError
        If the study cannot be computed, its result takes more than 16 GiB of memory without a store, or the store
        cannot be written, is another study's, is damaged, or lacks repetitions and was begun by another version
        of stiction.

    Examples
    --------
    >>> from stiction import Study, run
    >>> small = {"ensemble.repetitions": 2, "surfaces.points": 3000}
    >>> run(Study.named("quick").with_changes(small)).dataset["contact_area"].dims
    ('fractal_dimension', 'amplitude', 'repetition', 'approach')
    """
    size = study.ensemble.repetitions * bytes_of_member(study)
    if store is None and size > MOST_IN_MEMORY:
        raise StudyError(
            f"the result would take {size / 2**30:.0f} GiB of memory, more than {MOST_IN_MEMORY / 2**30:.0f}: give it "
            "a store, or take fewer ensemble.repetitions"
        )
    if store is None:
        return Result(_in_memory(study.with_known_files(), executor, progress))
    return Result(filled(prepared(study, store), executor=executor, progress=progress))


def fill(
    study: Study, folder: str | Path, *, part: tuple[int, int] | None = None, executor: Executor | None = None,
    progress: bool = False, say: Callable[[str], None] | None = None,
) -> int:  # fmt: skip
    """Compute what a folder lacks of a study, or of a part of it: of (3, 16) every 16th block from the third on.

    Processes with different parts share a folder; whoever comes without one computes what they leave. `say` is told
    what lies ahead. Returns how many repetitions of the study, or of the part, the folder holds; errors as of `run`.
    """
    stored = prepared(study, folder, part)
    stored = filled(stored, part=part, executor=executor, progress=progress, say=say)
    own = _Missing(stored, part)
    return own.total - own.count


def prepared(study: Study, folder: str | Path, part: tuple[int, int] | None = None) -> Stored:
    """A folder for a study, or a part of it, with what it holds already; errors as of `fill`."""
    if part is not None and not 1 <= part[0] <= part[1]:
        raise ValueError(f"part must be K of N, as in 3/16, got {part[0]}/{part[1]}")
    if (size := bytes_of_member(study)) > MOST_IN_MEMORY:
        keys = " or ".join(f"surfaces.{name}" for name in study.surfaces.cells())
        raise StudyError(
            f"a repetition would take {size / 2**30:.0f} GiB, more than {MOST_IN_MEMORY / 2**30:.0f}: take fewer "
            f"contact.{study.step} or {keys}"
        )
    return begin(folder, study.with_known_files(Path(folder)))


def filled(
    stored: Stored, *, part: tuple[int, int] | None = None, executor: Executor | None = None, progress: bool = False,
    say: Callable[[str], None] | None = None, late: Callable[[str], None] | None = None,
) -> Stored:  # fmt: skip
    """The folder when it holds all members of its study, or of a part of it; errors as of `fill`.

    `late` is given a new estimate after the first block, if the rest takes long and longer than was estimated.
    """
    missing = _Missing(stored, part)
    with contextlib.ExitStack() as stack:
        pool = stack.enter_context(given_or_threads(executor))
        advance = stack.enter_context(
            progress_bar("repetitions", missing.total, missing.total - missing.count, progress)
        )
        if missing.count:
            stack.enter_context(_kept(stored))
            _compute_into(stored, missing, pool, advance, say, late)
    stored = stored.again()
    if _Missing(stored, part).count:
        raise StoreError(f"{printable_path(stored.path)}: was removed or replaced while it was being written")
    return stored


def _compute_into(
    stored: Stored, missing: _Missing, pool: Executor, advance: Callable[[int], None],
    say: Callable[[str], None] | None, late: Callable[[str], None] | None,
) -> None:  # fmt: skip
    """Compute what is missing of a folder; workers elsewhere write it themselves, if they see the folder."""
    workers = getattr(pool, "_max_workers", None)  # of threads here; how many a cluster has may change
    started, is_first = time.monotonic(), late is not None and workers is not None

    def take(members: range, content: bytes | None) -> None:
        nonlocal is_first
        if content is not None:
            put(stored.path, members[0], content, len(members))
        advance(len(members))
        if is_first and late is not None and workers is not None:
            is_first = False
            words = _new_estimate(
                missing, len(members), time.monotonic() - started, workers, cost_of_member(stored.study)
            )
            if words:
                late(words)

    with contextlib.ExitStack() as stack:
        here = isinstance(pool, ThreadPoolExecutor)
        folder = None if here else stack.enter_context(_token(stored.path))
        is_seen = folder is not None and pool.submit(folder.is_seen).result()
        if say is not None:
            say(_ahead(stored, missing, here or is_seen, workers or 1))
        most = MOST_SUBMITTED if is_seen else FEWEST_SUBMITTED
        _compute(missing, pool, most, take, block_task, __version__, stored.study, folder)


@contextlib.contextmanager
def _token(path: Path) -> Iterator[Folder]:
    """A file by which workers know that they see the folder, and that somebody waits for them."""
    folder = Folder(path.resolve(), new_partial_name())
    token = folder.path / BLOCKS / folder.token
    try:
        try:
            token.touch(exist_ok=False)
        except OSError as error:
            raise StoreError(f"{printable_path(path)}: cannot be written: {error.strerror}") from None
        yield folder
    finally:
        with contextlib.suppress(OSError):
            token.unlink(missing_ok=True)


@contextlib.contextmanager
def _kept(stored: Stored) -> Iterator[None]:
    """Say in a StoreError how many members are finished, also where a worker has ended."""
    try:
        yield
    except (StoreError, BrokenExecutor) as error:
        said = BROKEN if isinstance(error, BrokenExecutor) else error
        raise StoreError(
            f"{said}\n{stored.again().count} of {stored.study.ensemble.repetitions} repetitions are finished and kept; "
            "running the study on it again continues from there"
        ) from None


def _in_memory(study: Study, executor: Executor | None, progress: bool) -> xarray.Dataset:
    nothing = Stored(Path(), study, ())
    missing = _Missing(nothing, None)
    axis = len(study.surfaces.cells())
    arrays: Arrays = {}

    def take(members: range, sums: Arrays) -> None:
        for name, values in sums.items():
            at = 0 if name in OF_MEMBERS else axis
            if name not in arrays:
                arrays[name] = np.empty((*values.shape[:at], missing.total, *values.shape[at + 1 :]), values.dtype)
            arrays[name][(*(slice(None),) * at, slice(members.start, members.stop))] = values
        advance(len(members))

    with contextlib.ExitStack() as stack:
        pool = stack.enter_context(given_or_threads(executor))
        advance = stack.enter_context(progress_bar("repetitions", missing.total, 0, progress))
        _compute(missing, pool, MOST_SUBMITTED, take, arrays_task, __version__, study)
    return dataset_of(study, range(missing.total), arrays, about(study))


LONG_RUN = 600.0  # seconds on all threads above which the estimate names what takes less


def _ahead(stored: Stored, missing: _Missing, is_seen: bool, workers: int) -> str:
    """What lies ahead: time, files, and who writes where that is not the workers; how much is free where it matters."""
    study = stored.study
    free = shutil.disk_usage(stored.path).free
    files = sum(1 for _ in missing)
    size = missing.count * bytes_of_member(study)
    room = f", with {format_bytes(free)} free" if size > free / 2 else ""
    who = "" if is_seen else "; the workers do not see the folder, so this process writes them"
    seconds = missing.count * cost_of_member(study)
    elapsed = seconds / min(workers, missing.count)
    time_text = f"about {format_duration(seconds)} of one core"
    time_text += f", {format_duration(elapsed)} on {workers} threads" if workers > 1 and elapsed > LONG_REST else ""
    advice = "; fewer repetitions or smaller scans take less" if elapsed > LONG_RUN else ""
    return (
        f"computing {missing.count} repetitions: {time_text}, {format_bytes(size)} in {files} "
        f"{'file' if files == 1 else 'files'}{room}{who}{advice}"
    )


LONG_REST = 60.0  # seconds of the remaining work from which on a new estimate is worth a line


def _new_estimate(missing: _Missing, members: int, seconds: float, workers: int, cost: float) -> str:
    """Return an estimate from the time of the first block; empty if the rest is short, or as was estimated."""
    rest = seconds * (missing.count / (members * workers) - 1)
    if rest < LONG_REST or seconds < 2 * members * cost:
        return ""
    took = f"{members} of {missing.count} repetitions took {format_duration(seconds)}"
    return f"{took}; the rest takes about {format_duration(rest)} more"


class _Missing:
    """The members of a study, or of a part of its blocks of so many, that are not finished: `count` of `total`."""

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


def _compute(
    missing: _Missing, pool: Executor, most: int, take: Callable[[range, Any], None], task: Callable[..., Any],
    *arguments: Any,
) -> None:  # fmt: skip
    """Compute blocks by a task, so many submitted at a time, each taken when done; errors cancel the others."""
    rest = iter(missing)
    task = sharing(task, pool, sum(1 for _ in missing), points_of_member(arguments[1]))
    waiting: dict[Future[Any], range] = {}
    # Not concurrent.futures.wait, which locks every one of them each time, and leaves some locked if it is interrupted.
    done: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()

    def submit(count: int) -> None:
        for members in itertools.islice(rest, count):
            future = pool.submit(task, *arguments, members)
            waiting[future] = members
            future.add_done_callback(done.put)

    try:
        submit(most)
        while waiting:
            future = done.get()
            take(waiting[future], future.result())
            del waiting[future]
            submit(most - len(waiting))
    finally:
        for future in waiting:
            future.cancel()
        for future in wait(waiting, PATIENCE).done:
            if not future.cancelled() and future.exception() is None:
                with contextlib.suppress(StoreError):
                    take(waiting[future], future.result())


# ---- Tasks ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Folder:
    """A folder into which a worker on another machine writes its blocks, if it sees it."""

    path: Path
    token: str  # name of a file among the blocks, which is there as long as the run that hands out the tasks

    def is_seen(self) -> bool:
        """Whether this process sees the folder."""
        return (self.path / BLOCKS / self.token).exists()


def block_task(version: str, study: Study, folder: Folder | None, members: range) -> bytes | None:
    """The file of a block of members; None where it was written into the folder, because that is seen from here."""
    from stiction.studies.store import encoded

    is_seen = folder is not None and folder.is_seen()
    content = encoded(study, members, arrays_task(version, study, members))
    if folder is None or not is_seen:
        return content
    put(folder.path, members[0], content, len(members))
    return None


def arrays_task(version: str, study: Study, members: range) -> Arrays:
    """The numbers of a block of members; errors as of `block_task`."""
    if version != __version__:
        raise StudyError(
            f"the worker on {socket.gethostname()} has stiction {__version__}, and {version} asks for the study; "
            "install the same version everywhere"
        )
    return stacked(study, [member_sums(study, member) for member in members])


# ---- The first members ----------------------------------------------------------------------------------------------

FIRST_MEMBERS = 4  # members of the first result


def first_result(study: Study) -> Result:
    """Return the result of the first members of a study of asperities; a `ValueError` if they cannot be pressed.

    It takes less than a second, while the half-space is being solved.
    """
    members = range(min(FIRST_MEMBERS, study.ensemble.repetitions))
    arrays = stacked(study, [member_sums(study, member) for member in members])
    return Result(dataset_of(study, members, arrays, about(study)))
