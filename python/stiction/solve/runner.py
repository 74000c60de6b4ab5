"""Run of a study: blocks of members, each computed as a separate task of an executor."""

from __future__ import annotations

import contextlib
import functools
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

from stiction._checks import check_bool, check_instance, parse_path
from stiction._core import __version__
from stiction._files import DirectoryClaim
from stiction._text import format_bytes, format_duration, printable_path
from stiction.solve.executors import (
    WORKER_DIED_MESSAGE,
    executor_or_thread_pool,
    progress_bar,
    wrap_to_use_idle_threads,
)
from stiction.solve.layout import (
    MEMBER_COORDINATE_TYPES,
    ArraysByName,
    build_dataset,
    compute_bytes_per_member,
    stack_members,
)
from stiction.solve.member_solution import (
    compute_member_arrays,
    estimate_member_iterations,
    estimate_member_time,
    estimate_thread_time_factor,
    sum_over_members,
)
from stiction.solve.member_sums import MemberSums
from stiction.solve.members_in_progress import MembersInProgress, remove_stored_steps
from stiction.solve.store import (
    BLOCKS_DIRECTORY,
    STUDY_FILE,
    StoredResult,
    StoreError,
    create_or_open_result,
    encode_members,
    import_dataset_packages,
    is_complete,
    write_block,
)
from stiction.study.members import check_scans_provide_all_members, count_grid_points, find_body_attributes
from stiction.study.study import Study
from stiction.study.values import StudyError

if TYPE_CHECKING:
    import xarray

# Computing time (s) of a block of members: long compared with the time to store it, but a small loss in a crash.
TARGET_BLOCK_TIME = 1.5
MAX_BLOCK_MEMBERS = 4096
MAX_BLOCK_BYTES = 2**24
# Minimum number of blocks of members in a run: with fewer, idle workers could wait a long time for the last block.
MIN_BLOCKS_PER_RUN = 16
# Minimum computing time (s) of a block, because the first block file of each size takes 0.1 s to write.
MIN_BLOCK_TIME = 0.2
MAX_SUBMITTED_TASKS = 1000
MAX_TASKS_THAT_RETURN_BLOCKS = 256
PROGRESS_INTERVAL = 0.5  # s
SHUTDOWN_TIMEOUT = 3.0  # s
MAX_BYTES_IN_MEMORY = 2**34


def choose_block_size(study: Study) -> int:
    """Return how many members one block contains, given a member's computing time and memory."""
    size_by_time = int(min(TARGET_BLOCK_TIME / max(estimate_member_time(study), 1e-9), MAX_BLOCK_MEMBERS))
    size_by_bytes = MAX_BLOCK_BYTES // compute_bytes_per_member(study)
    num_members = study.ensemble.repetitions
    min_size = min(math.ceil(MIN_BLOCK_TIME / max(estimate_member_time(study), 1e-9)), num_members // 4)
    return max(1, min(size_by_time, size_by_bytes, max(num_members // MIN_BLOCKS_PER_RUN, min_size)))


# ---- Runs -----------------------------------------------------------------------------------------------------------


def compute_member_sums(
    study: Study, *, executor: Executor | None = None, store: str | Path | None = None, progress: bool = False
) -> MemberSums:
    """Compute forces and areas, summed over contacts, for all members of a study, and store the sums if requested.

    Without a directory, the forces and areas are only in memory.
    """
    check_instance("study", study, Study, "a Study")
    check_bool("progress", progress)
    size = study.ensemble.repetitions * compute_bytes_per_member(study)
    if store is None and size > MAX_BYTES_IN_MEMORY:
        raise StudyError(
            f"the result would take {size / 2**30:.0f} GiB of memory, more than the limit of "
            f"{MAX_BYTES_IN_MEMORY / 2**30:.0f} GiB; give a store, or reduce ensemble.repetitions"
        )
    if store is None:
        return MemberSums(_run_in_memory(study.with_checksums(), executor, progress))
    store = parse_path("store", store)
    with DirectoryClaim(store) as claim:
        stored_result = prepare_result_directory(study, store, claim)
        return MemberSums(complete_blocks(stored_result, executor=executor, progress=progress))


def compute_missing_blocks(
    study: Study, directory: str | Path, *, part: tuple[int, int] | None = None, executor: Executor | None = None,
    progress: bool = False, announce: Callable[[str], None] | None = None,
) -> int:  # fmt: skip
    """Compute all blocks of members that the result directory of a study lacks.

    With `part`, only some of the blocks are computed: the part (3, 16) is every 16th block, starting with the third.
    Several processes can compute different parts in one directory. `announce` receives a line about the work ahead.
    Returns the number of finished members of the study or, with `part`, of the part. Raises the errors of `run`.
    """
    with DirectoryClaim(directory) as claim:
        stored_result = complete_blocks(
            prepare_result_directory(study, directory, claim, part),
            part=part,
            executor=executor,
            progress=progress,
            announce=announce,
        )
    unfinished_members = _UnfinishedMembers(stored_result, part)
    return unfinished_members.total - unfinished_members.count


def prepare_result_directory(
    study: Study, directory: str | Path, claim: DirectoryClaim, part: tuple[int, int] | None = None
) -> StoredResult:
    """Create or open the result directory of a study, and reserve the directory for this run.

    Raises the errors of `compute_missing_blocks`.
    """
    if part is not None and not 1 <= part[0] <= part[1]:
        raise ValueError(f"`part` must be (K, N) with K from 1 to N, got ({part[0]}, {part[1]})")
    if (size := compute_bytes_per_member(study)) > MAX_BYTES_IN_MEMORY:
        study_keys = " or ".join(f"surfaces.{name}" for name in study.surfaces.cell_coordinates())
        raise StudyError(
            f"a repetition would take {size / 2**30:.0f} GiB of memory, more than the limit of "
            f"{MAX_BYTES_IN_MEMORY / 2**30:.0f} GiB; reduce the number of values of "
            f"contact.{study.step_quantity} or {study_keys}"
        )
    if not is_complete(directory, study):
        check_scans_provide_all_members(study.with_checksums())
    return create_or_open_result(directory, study.with_checksums(Path(directory)), claim)


def complete_blocks(
    stored_result: StoredResult, *, part: tuple[int, int] | None = None, executor: Executor | None = None,
    progress: bool = False, announce: Callable[[str], None] | None = None, update: Callable[[str], None] | None = None,
    meanwhile: Callable[[], object] = import_dataset_packages,
) -> StoredResult:  # fmt: skip
    """Compute the missing blocks of a stored result, and return the complete result.

    `update` receives a new estimate of the run time after the first block, if much time remains and the first estimate
    was too low. `meanwhile` is called once while the workers compute. Raises the errors of `compute_missing_blocks`.
    """
    unfinished_members = _UnfinishedMembers(stored_result, part)
    # A killed run may have left behind the step files of members whose block was already stored.
    remove_stored_steps(stored_result.path, stored_result.finished_members)
    with contextlib.ExitStack() as stack:
        pool = stack.enter_context(executor_or_thread_pool(executor))
        members_in_progress = _create_members_in_progress(stored_result.study, stored_result.path, unfinished_members)
        advance = stack.enter_context(
            progress_bar(
                stored_result.study.member_names.plural,
                unfinished_members.total,
                unfinished_members.total - unfinished_members.count,
                progress,
                members_in_progress.estimate_progress,
            )
        )
        if unfinished_members.count:
            stack.enter_context(_add_finished_count_to_errors(stored_result))
            _compute_blocks(
                stored_result, unfinished_members, members_in_progress, pool, advance, announce, update, meanwhile
            )
    stored_result = stored_result.reload()
    if _UnfinishedMembers(stored_result, part).count or not (stored_result.path / STUDY_FILE).exists():
        raise StoreError(
            f"{printable_path(stored_result.path)}: files were removed while the study was running; run the study again"
        )
    return stored_result


def _create_members_in_progress(
    study: Study, directory: Path | None, unfinished_members: _UnfinishedMembers | None = None
) -> MembersInProgress:
    def estimate_mean_iterations() -> float:
        assert unfinished_members is not None
        return sum_over_members(estimate_member_iterations, study, unfinished_members) / unfinished_members.count

    return MembersInProgress(
        study,
        directory,
        functools.partial(estimate_member_iterations, study),
        None if unfinished_members is None else estimate_mean_iterations,
    )


def _compute_blocks(
    stored_result: StoredResult, unfinished_members: _UnfinishedMembers, members_in_progress: MembersInProgress,
    pool: Executor, advance: Callable[[int], None], announce: Callable[[str], None] | None,
    update: Callable[[str], None] | None, meanwhile: Callable[[], object],
) -> None:  # fmt: skip
    """Compute the missing blocks of a stored result, and write one file per block.

    Workers that can access the directory write the block files.
    """
    # For a cluster, `num_workers` is None, because the number of workers of a cluster varies.
    num_workers = getattr(pool, "_max_workers", None)
    start_time, is_first = time.monotonic(), update is not None and num_workers is not None

    def accept_block(members: range, content: bytes | None) -> None:
        nonlocal is_first
        if content is not None:
            write_block(stored_result.path, members[0], content, len(members))
        members_in_progress.remove(members)
        advance(len(members))
        if is_first and update is not None and num_workers is not None:
            is_first, study = False, stored_result.study
            time_factor = estimate_thread_time_factor(study) if num_workers > 1 else 1.0
            estimate = _format_revised_time_estimate(
                study,
                unfinished_members,
                len(members),
                time.monotonic() - start_time,
                num_workers,
                time_factor * sum_over_members(estimate_member_time, study, [members]) / len(members),
                time_factor * sum_over_members(estimate_member_time, study, unfinished_members),
            )
            if estimate:
                update(estimate)

    with contextlib.ExitStack() as stack:
        is_local = isinstance(pool, ThreadPoolExecutor)
        directory = None if is_local else stack.enter_context(_create_run_token(stored_result.path))
        is_visible = directory is not None and pool.submit(directory.is_accessible).result()
        if announce is not None:
            announce(
                _describe_remaining_work(stored_result, unfinished_members, is_local or is_visible, num_workers or 1)
            )
        max_tasks = MAX_SUBMITTED_TASKS if is_visible else MAX_TASKS_THAT_RETURN_BLOCKS
        counts_iterations = is_local and stored_result.study.uses_half_space
        task = (
            functools.partial(compute_block, members_in_progress=members_in_progress)
            if counts_iterations
            else compute_block
        )
        _submit_member_ranges(
            unfinished_members,
            pool,
            max_tasks,
            accept_block,
            advance,
            task,
            __version__,
            stored_result.study,
            directory,
            meanwhile=meanwhile,
        )


@contextlib.contextmanager
def _create_run_token(path: Path) -> Iterator[SharedResultDirectory]:
    """Mark a run as active by a file in its result directory. The file exists until the end of the `with` block.

    If a worker finds the token file, the worker can access the directory, and the run is still active.
    """
    with DirectoryClaim(path.resolve() / BLOCKS_DIRECTORY) as token:
        try:
            token.acquire()
        except OSError as error:
            raise StoreError(f"{printable_path(path)}: cannot be written: {error.strerror}") from None
        yield SharedResultDirectory(path.resolve(), token.file.name)


@contextlib.contextmanager
def _add_finished_count_to_errors(stored_result: StoredResult) -> Iterator[None]:
    """Append the number of finished members to the messages of storage errors and of errors from dead workers."""
    try:
        yield
    except (StoreError, BrokenExecutor) as error:
        reason = WORKER_DIED_MESSAGE if isinstance(error, BrokenExecutor) else error
        raise StoreError(
            f"{reason}\n{stored_result.reload().num_finished} of "
            f"{stored_result.study.member_names.with_count(stored_result.study.ensemble.repetitions)} are finished and "
            "kept; run the study in the same directory again to resume"
        ) from None


def _run_in_memory(study: Study, executor: Executor | None, progress: bool) -> xarray.Dataset:
    unfinished_members = _UnfinishedMembers(StoredResult(Path(), study, ()), None)
    axis = len(study.surfaces.cell_coordinates())
    arrays: ArraysByName = {}

    def accept_arrays(members: range, sums: ArraysByName) -> None:
        for name, values in sums.items():
            member_axis = 0 if name in MEMBER_COORDINATE_TYPES else axis
            if name not in arrays:
                shape = (*values.shape[:member_axis], unfinished_members.total, *values.shape[member_axis + 1 :])
                arrays[name] = np.empty(shape, values.dtype)
            arrays[name][(*(slice(None),) * member_axis, slice(members.start, members.stop))] = values
        members_in_progress.remove(members)
        advance(len(members))

    with contextlib.ExitStack() as stack:
        pool = stack.enter_context(executor_or_thread_pool(executor))
        members_in_progress = _create_members_in_progress(study, None, unfinished_members)
        advance = stack.enter_context(
            progress_bar(
                study.member_names.plural, unfinished_members.total, 0, progress, members_in_progress.estimate_progress
            )
        )
        counts_iterations = isinstance(pool, ThreadPoolExecutor) and study.uses_half_space
        task = (
            functools.partial(compute_block_arrays, members_in_progress=members_in_progress)
            if counts_iterations
            else compute_block_arrays
        )
        _submit_member_ranges(
            unfinished_members, pool, MAX_SUBMITTED_TASKS, accept_arrays, advance, task, __version__, study
        )
    return build_dataset(study, range(unfinished_members.total), arrays, find_body_attributes(study))


LONG_RUN_TIME = 600.0  # s, on all threads


def _describe_remaining_work(
    stored_result: StoredResult, unfinished_members: _UnfinishedMembers, is_visible: bool, workers: int
) -> str:
    """Describe the remaining members, time and files in one line, with the free disk space if it may be too small."""
    study = stored_result.study
    free_bytes = shutil.disk_usage(stored_result.path).free
    num_files = sum(1 for _ in unfinished_members)
    result_bytes = unfinished_members.count * compute_bytes_per_member(study)
    space_text = f", with {format_bytes(free_bytes)} free" if result_bytes > free_bytes / 2 else ""
    writer_text = "" if is_visible else "; the workers cannot reach the directory, so this process writes the files"
    seconds = sum_over_members(estimate_member_time, study, unfinished_members)
    num_threads = min(workers, unfinished_members.count)
    elapsed_time = seconds / num_threads * (estimate_thread_time_factor(study) if num_threads > 1 else 1.0)
    time_text = f"about {format_duration(seconds)} of one core"
    time_text += (
        f", {format_duration(elapsed_time)} on {workers} threads"
        if workers > 1 and elapsed_time > MIN_REPORTED_TIME
        else ""
    )
    advice = (
        f"; fewer {study.member_names.plural} or smaller surfaces reduce the time"
        if elapsed_time > LONG_RUN_TIME
        else ""
    )
    return (
        f"computing {study.member_names.with_count(unfinished_members.count)}: {time_text}, "
        f"{format_bytes(result_bytes)} in {num_files} {'file' if num_files == 1 else 'files'}"
        f"{space_text}{writer_text}{advice}"
    )


MIN_REPORTED_TIME = 60.0  # s
MIN_TIME_RATIO_FOR_NEW_ESTIMATE = 1.5


def _format_revised_time_estimate(
    study: Study, unfinished_members: _UnfinishedMembers, members: int, seconds: float, workers: int, cost: float,
    total_cost: float | None = None,
) -> str:  # fmt: skip
    """Return a line with a new estimate of the remaining time, made after the first block.

    `members` members took `seconds`, instead of the estimated time `cost` (s) per member. `total_cost` is the estimated
    time of all unfinished members, by default that of equal members. The line is empty if little time remains, or if
    the first estimate was not too low.
    """
    expected_seconds = members * cost
    total_cost = unfinished_members.count * cost if total_cost is None else total_cost
    remaining_time = seconds * (total_cost / (expected_seconds * workers) - 1)
    if remaining_time < MIN_REPORTED_TIME or seconds < MIN_TIME_RATIO_FOR_NEW_ESTIMATE * expected_seconds:
        return ""
    count_text = study.member_names.with_count(unfinished_members.count)
    progress_text = f"{members} of {count_text} took {format_duration(seconds)}"
    return f"{progress_text}; the rest takes about {format_duration(remaining_time)} more"


class _UnfinishedMembers:
    """Ranges of members that a run still has to compute, each within a single block of members."""

    def __init__(self, stored_result: StoredResult, part: tuple[int, int] | None) -> None:
        num_members = stored_result.study.ensemble.repetitions
        self.block_size = choose_block_size(stored_result.study)
        first_part, step = (1, 1) if part is None else part
        self._blocks = range(first_part - 1, -(-num_members // self.block_size), step)
        self._is_finished = np.zeros(num_members, np.bool_)
        self._is_finished[stored_result.finished_members] = True
        finished_by_block = [
            self._is_finished[block * self.block_size : (block + 1) * self.block_size] for block in self._blocks
        ]
        self.total = sum(map(len, finished_by_block))
        self.count = self.total - int(sum(np.count_nonzero(is_finished) for is_finished in finished_by_block))

    def __iter__(self) -> Iterator[range]:
        """Yield the ranges of missing members, block by block."""
        for block in self._blocks:
            first_index = block * self.block_size
            is_finished = self._is_finished[first_index : first_index + self.block_size]
            # For each range of missing members, `edges` contains the first index and the index after the last one.
            edges = np.flatnonzero(np.diff(np.concatenate([[True], is_finished, [True]]).astype(np.int8)))
            for start, end in edges.reshape(-1, 2).tolist():
                yield range(first_index + start, first_index + end)


def _submit_member_ranges(
    unfinished_members: _UnfinishedMembers, pool: Executor, max_tasks: int, accept: Callable[[range, Any], None],
    advance: Callable[[int], None], task: Callable[..., Any], *arguments: Any,
    meanwhile: Callable[[], object] = import_dataset_packages,
) -> None:  # fmt: skip
    """Run a task in a pool for each range of missing members, and pass each task's result to `accept`.

    `meanwhile` is called after the first tasks are submitted. While tasks run, `advance` is called with 0, which
    updates the displayed progress. At most `max_tasks` tasks are queued at a time. An error cancels the remaining
    tasks.
    """
    # SciPy is imported before tasks start, because its import may fail if two threads start it at the same time.
    import scipy  # noqa: F401

    ranges = iter(unfinished_members)
    task = wrap_to_use_idle_threads(task, pool, sum(1 for _ in unfinished_members), count_grid_points(arguments[1]))
    pending_members: dict[Future[Any], range] = {}
    # Results arrive through a queue, because an interrupted `concurrent.futures.wait` would leave some futures locked.
    finished_futures: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()

    def submit_tasks(count: int) -> None:
        for members in itertools.islice(ranges, count):
            future = pool.submit(task, *arguments, members)
            pending_members[future] = members
            future.add_done_callback(finished_futures.put)

    try:
        submit_tasks(max_tasks)
        meanwhile()
        while pending_members:
            try:
                future = finished_futures.get(timeout=PROGRESS_INTERVAL)
            except queue.Empty:
                advance(0)
                continue
            accept(pending_members[future], future.result())
            del pending_members[future]
            submit_tasks(max_tasks - len(pending_members))
    finally:
        for future in pending_members:
            future.cancel()
        for future in wait(pending_members, SHUTDOWN_TIMEOUT).done:
            if not future.cancelled() and future.exception() is None:
                with contextlib.suppress(StoreError):
                    accept(pending_members[future], future.result())


# ---- Tasks ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SharedResultDirectory:
    """Result directory to which workers write their block files, if they can access the directory."""

    path: Path
    token: str

    def is_accessible(self) -> bool:
        """Return whether this process can access the directory and the run has not ended."""
        return (self.path / BLOCKS_DIRECTORY / self.token).exists()


def compute_block(
    version: str, study: Study, directory: SharedResultDirectory | None, members: range,
    members_in_progress: MembersInProgress | None = None,
) -> bytes | None:  # fmt: skip
    """Compute a block of members and write its file. Return the file content if the directory is inaccessible."""
    if directory is not None and directory.is_accessible():
        members_in_progress = _create_members_in_progress(study, directory.path)
    content = encode_members(study, members, compute_block_arrays(version, study, members, members_in_progress))
    # If the run has ended, another study may use the directory, so the block is not written.
    if directory is None or not directory.is_accessible():
        return content
    write_block(directory.path, members[0], content, len(members))
    return None


def compute_block_arrays(
    version: str, study: Study, members: range, members_in_progress: MembersInProgress | None = None
) -> ArraysByName:
    """Compute the arrays of all variables for a block of members.

    Raises a `StudyError` if `version` is not the version of this process.
    """
    if version != __version__:
        raise StudyError(
            f"the worker on {socket.gethostname()} has stiction {__version__}, but the study was submitted with "
            f"{version}; install the same version on all machines"
        )
    if members_in_progress is None or not study.uses_half_space:
        return stack_members(study, [compute_member_arrays(study, member) for member in members])
    return stack_members(
        study, [compute_member_arrays(study, member, members_in_progress.add(member)) for member in members]
    )


# ---- Preview from the first members ---------------------------------------------------------------------------------

NUM_PREVIEW_MEMBERS = 4


def compute_preview_sums(study: Study) -> MemberSums:
    """Compute the forces and areas, summed over contacts, of the first few members, to preview a result.

    With the asperity model, which also serves as a preview of a half-space result, the computation takes less than a
    second. Raises a `ValueError` if the contact of these members cannot be computed.
    """
    members = range(min(NUM_PREVIEW_MEMBERS, study.ensemble.repetitions))
    arrays = stack_members(study, [compute_member_arrays(study, member) for member in members])
    return MemberSums(build_dataset(study, members, arrays, find_body_attributes(study)))
