"""Members whose computation has started: the progress of each member, and files of its finished steps.

    DIR/in_progress/0000003-1b2c3d4e5f6a7b8c/00007.npz     step 7 of member 3, for example the contact at one load
    DIR/in_progress/0000003-1b2c3d4e5f6a7b8c/state.npz     state in the middle of the next step

A member whose computation was interrupted continues from these files, with the same bits as without the interruption.
Only members that take longer than `STORAGE_INTERVAL` have files. The files are removed as soon as the block of the
member is stored. The name of the directory contains a checksum of the study, the software and the machine, because
other software or another machine may compute other bits.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import platform
import re
import time
import zipfile
import zlib
from collections.abc import Callable, Container
from functools import cache, cached_property, lru_cache
from pathlib import Path

import numpy as np

import stiction._core as _core
import stiction._files as _files
import stiction.mechanics as mechanics
from stiction._core import __version__
from stiction._errors import NoSolutionError
from stiction.mechanics.solution_record import SolutionRecord, StepResult
from stiction.study.study import Study

IN_PROGRESS_DIRECTORY = "in_progress"
STORAGE_INTERVAL = 15.0  # s
MAX_STEP_FILE_BYTES = 2**32
_STATE_FILE = "state.npz"
_STEP_FILE_PATTERN = re.compile(r"([0-9]{5,}|state)\.npz")
_MEMBER_DIRECTORY_PATTERN = re.compile(r"([0-9]{7,18})-[0-9a-f]{16}")
MAX_CACHED_ESTIMATES = 256
"""Maximum number of members whose estimated iterations are cached, because each display of the progress uses them."""

MAX_LINEAR_PROGRESS_FRACTION = 0.5
"""Fraction of the expected iterations up to which a member's progress is proportional to the number of iterations.

Beyond this fraction, the progress approaches 1 without reaching it, because the number of iterations is not known in
advance.
"""


class MembersInProgress:
    """Members that a run is computing: the progress of each member, and files of its finished steps.

    `estimate_iterations` returns the expected number of iterations of the member with a given index.
    `estimate_mean_iterations` returns the mean of these numbers over all members that the run computes. Without this
    function, all members count as equal work.
    """

    def __init__(
        self, study: Study, directory: Path | None, estimate_iterations: Callable[[int], float],
        estimate_mean_iterations: Callable[[], float] | None = None,
    ) -> None:  # fmt: skip
        self._study, self._directory = study, directory
        self._estimate_iterations = lru_cache(MAX_CACHED_ESTIMATES)(estimate_iterations)
        self._estimate_mean_iterations = estimate_mean_iterations
        self._records: dict[int, SolutionRecord] = {}
        self._excess_work = 0.0
        # Number of iterations of all finished members, and the number expected before these members were computed.
        self._finished_count, self._expected_finished_count = 0, 0.0

    @cached_property
    def _mean_iterations(self) -> float:
        return self._estimate_mean_iterations() if self._estimate_mean_iterations else 0.0

    def _get_relative_iterations(self, member: int) -> float:
        """Return the expected iterations of a member, divided by the mean over all members to be computed."""
        return self._estimate_iterations(member) / self._mean_iterations if self._mean_iterations else 1.0

    @cached_property
    def _steps_key(self) -> str:
        """Key that identifies the stored steps: a checksum of study, software and machine."""
        return compute_steps_key(self._study.to_toml())

    def add(self, member: int) -> SolutionRecord:
        """Add a member, and return the record of its steps, including steps that an interrupted run has stored."""
        record = (
            SolutionRecord() if self._directory is None else stored_record(self._directory, member, self._steps_key)
        )
        self._records[member] = record
        return record

    def remove(self, members: range) -> None:
        """Remove the records and the step files of members whose results are stored in a block."""
        for member in members:
            if record := self._records.pop(member, None):
                self._excess_work += self._get_relative_iterations(member) - 1
                if record.counter.count > 0:
                    self._finished_count += record.counter.count
                    self._expected_finished_count += self._estimate_iterations(member)
        if self._directory is not None:
            remove_stored_steps(self._directory, members)

    def estimate_progress(self) -> float:
        """Estimate the finished work, in units of a member's mean work, minus the number of finished members.

        The first members take more work than the others. When they are finished, more work is finished than their
        number says; this excess is 0 when all members are finished.
        """
        correction = self._finished_count / self._expected_finished_count if self._expected_finished_count > 0 else 1.0
        return self._excess_work + sum(
            self._get_relative_iterations(member)
            * _estimate_finished_fraction(
                record.counter.count / max(correction * self._estimate_iterations(member), 1.0)
            )
            for member, record in list(self._records.items())
        )


def compute_steps_key(inputs: str, modules: tuple[Path, ...] = ()) -> str:
    """Return the key of stored solution steps, a checksum of the inputs, the software and the machine.

    Steps with the same key are equal in every bit. `modules` are Python modules that determine, besides the solver, the
    steps into which a computation is divided.
    """
    import scipy

    checksum_inputs = (
        inputs, __version__, sorted(_core.build().items()), _hash_step_modules(modules), np.__version__,
        scipy.__version__, platform.node(), platform.machine(),
    )  # fmt: skip
    return hashlib.sha256(repr(checksum_inputs).encode()).hexdigest()[:16]


@cache
def _hash_step_modules(modules: tuple[Path, ...]) -> str:
    """Return a checksum of the Python modules in the package `stiction.mechanics` and of the given modules."""
    paths = [*sorted(Path(mechanics.__file__).parent.glob("*.py")), *modules]
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()


def stored_record(directory: Path, member: int, key: str) -> SolutionRecord:
    """Return a record that writes a member's finished steps to files, and reuses steps of an earlier run."""
    return _StoredRecord(directory / IN_PROGRESS_DIRECTORY / f"{member:07d}-{key}")


def _estimate_finished_fraction(iteration_ratio: float) -> float:
    """Estimate which fraction of a member is finished, from the ratio of finished to expected iterations."""
    if iteration_ratio <= MAX_LINEAR_PROGRESS_FRACTION:
        return iteration_ratio
    return 1 - MAX_LINEAR_PROGRESS_FRACTION**2 / iteration_ratio


def find_members_in_progress(directory: Path) -> set[int]:
    """Return the indices of the members with files of finished steps in a result directory."""
    return {
        member
        for member, member_directory in _list_member_directories(directory)
        if any(_STEP_FILE_PATTERN.fullmatch(path.name) for path in member_directory.iterdir())
    }


def find_steps_with_other_keys(directory: Path, member: int, key: str) -> list[Path]:
    """Return the directories of a member's stored steps whose names contain another key (a checksum) than `key`.

    Such steps belong to other inputs, other software or another machine.
    """
    return sorted(
        member_directory
        for found_member, member_directory in _list_member_directories(directory)
        if found_member == member and not member_directory.name.endswith(f"-{key}")
    )


def remove_stored_steps(directory: Path, members: Container[int] | None = None, key: str | None = None) -> None:
    """Remove the files of finished steps of the given members, or of all members, from a result directory.

    `members` selects the members, and `key` selects the checksum. By default, the steps of all members with any
    checksum are removed.
    """
    for member, member_directory in _list_member_directories(directory):
        if (members is None or member in members) and (key is None or member_directory.name.endswith(f"-{key}")):
            with contextlib.suppress(OSError):
                for path in member_directory.iterdir():
                    if _STEP_FILE_PATTERN.fullmatch(path.name):
                        path.unlink(missing_ok=True)
                _files.remove_stale_partial_files(member_directory)
                member_directory.rmdir()
    # The directory of steps may be missing, or it may still contain the finished steps of other members.
    with contextlib.suppress(OSError):
        (directory / IN_PROGRESS_DIRECTORY).rmdir()


def _list_member_directories(directory: Path) -> list[tuple[int, Path]]:
    try:
        paths = list((directory / IN_PROGRESS_DIRECTORY).iterdir())
    except OSError:
        return []
    matches = [(_MEMBER_DIRECTORY_PATTERN.fullmatch(path.name), path) for path in paths]
    return [(int(match[1]), path) for match, path in matches if match]


class _StoredRecord(SolutionRecord):
    """Record that stores the finished steps of a member in a directory, so that a later run can resume the member."""

    def __init__(self, directory: Path) -> None:
        super().__init__()
        self._directory = directory
        self._step = -1
        self._is_resuming, self._is_writable = True, True
        self._unsaved_steps: list[tuple[int, StepResult]] = []
        self._last_time = time.monotonic()
        self._first_count = 0

    def run_step(self, compute: Callable[[], StepResult], error_type: type[NoSolutionError]) -> StepResult:
        self._step += 1
        self._first_count = self.counter.count
        result = self._read_step(self._step)
        if result is not None:
            self.counter.add(int(result["iteration_count"]))
        else:
            try:
                result = compute()
            except error_type as error:
                result = {"failure": str(error)}
            result["iteration_count"] = self.counter.count - self._first_count
            if self._is_writable:
                self._unsaved_steps.append((self._step, result))
            if self._is_storage_due():
                self._write_steps({})
        if "failure" in result:
            raise error_type(str(result["failure"]))
        return result

    def read_state(self) -> StepResult | None:
        state = _read_result(self._directory / _STATE_FILE) if self._had_member_directory else None
        if state is None or int(state["step"]) != self._step:
            return None
        self.counter.add(int(state["iteration_count"]))
        return state

    def offer_state(self, get_state: Callable[[], StepResult]) -> None:
        if self._is_storage_due():
            step_counts = {"step": self._step, "iteration_count": self.counter.count - self._first_count}
            self._write_steps(get_state() | step_counts)

    @cached_property
    def _had_member_directory(self) -> bool:
        return self._directory.is_dir()

    def _read_step(self, step: int) -> StepResult | None:
        """Read the result of a finished step from its file.

        Returns None if this step or an earlier step is not stored.
        """
        result = (
            _read_result(self._directory / f"{step:05d}.npz")
            if self._is_resuming and self._had_member_directory
            else None
        )
        self._is_resuming = result is not None
        return result

    def _is_storage_due(self) -> bool:
        return self._is_writable and time.monotonic() - self._last_time > STORAGE_INTERVAL

    def _write_steps(self, state: StepResult) -> None:
        """Write the results of newly finished steps and the state of the current step to files.

        A failure to write does not end the computation; after an interruption, the member is computed again.
        """
        try:
            self._directory.parent.mkdir(exist_ok=True)
            self._directory.mkdir(exist_ok=True)
            for step, result in self._unsaved_steps:
                _files.write_atomically(self._directory / f"{step:05d}.npz", _encode_result(result))
            if state:
                _files.write_atomically(self._directory / _STATE_FILE, _encode_result(state))
        except OSError:
            self._is_writable = False
        self._unsaved_steps.clear()
        self._last_time = time.monotonic()


def _encode_result(result: StepResult) -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, **result)
    return file.getvalue()


def _read_result(path: Path) -> StepResult | None:
    """Read the result of a finished step from a file.

    Returns None if the file is missing or damaged.
    """
    try:
        with np.load(io.BytesIO(_files.read_file_bytes(path, MAX_STEP_FILE_BYTES)), allow_pickle=False) as file:
            return dict(file.items())
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error, _files.UnreadableFileError):
        return None
