"""Companion studies: variants of a measured pair's study, each stored in a subdirectory of the pair's result.

Examples are the cutoff study, alternative preparations of the scans, and studies with scaled heights.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stiction._files import DirectoryClaim
from stiction.solve.member_solution import estimate_member_time
from stiction.solve.member_sums import MemberSums
from stiction.solve.runner import complete_blocks, prepare_result_directory
from stiction.solve.store import STUDY_FILE, StoredResult, open_result_to_complete, open_stored_result, remove_result
from stiction.study.study import Study, find_member_differences

# Function that receives the estimated computing time (s) on one core as its only argument.
TimeAnnouncer = Callable[[float], Any]


@dataclass(frozen=True)
class CompanionStudy:
    """Variant of a measured pair's study, and the directory in which the result of the variant is stored."""

    study: Study
    directory: Path

    def open(self, *, allow_unfinished: bool = False) -> MemberSums | None:
        """Open the stored result of the companion study, which contains the forces and areas of each member.

        Friction can be evaluated from the forces and areas with any mu0 and tau0.

        Returns None if the directory is missing or damaged, if it stores the result of another pair, or if members are
        missing. With `allow_unfinished`, one finished member suffices.
        """
        if not (self.directory / STUDY_FILE).exists():
            return None
        try:
            stored_result = open_stored_result(self.directory)
        except ValueError:
            # A companion study whose directory is damaged counts as missing.
            return None
        if find_member_differences(stored_result.study, self.study):
            return None
        num_members = self.study.ensemble.repetitions
        is_finished = stored_result.num_finished == num_members == stored_result.study.ensemble.repetitions
        if not (is_finished or (allow_unfinished and stored_result.num_finished)):
            return None
        return MemberSums(StoredResult(self.directory, self.study, stored_result.blocks))

    def complete(
        self, executor: Executor, *, progress: bool = False, announce_time: TimeAnnouncer = lambda _: None,
        meanwhile: Callable[[], object] = lambda: None,
    ) -> MemberSums:  # fmt: skip
        """Compute the missing members of the companion study, and return the forces and areas of all members.

        A stored result of another study, for example of another pair, is removed first. `meanwhile` is called once
        while the workers compute. Raises the errors of `compute_missing_blocks`.
        """
        existing_result = open_result_to_complete(self.directory)
        with DirectoryClaim(self.directory) as claim:
            if existing_result and find_member_differences(existing_result.study, self.study):
                remove_result(existing_result, claim)
            stored_result = prepare_result_directory(self.study, self.directory, claim)
            if num_missing := self.study.ensemble.repetitions - stored_result.num_finished:
                announce_time(num_missing * estimate_member_time(self.study))
            return MemberSums(complete_blocks(stored_result, executor=executor, progress=progress, meanwhile=meanwhile))
