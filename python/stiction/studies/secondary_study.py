"""A study that belongs to the result of a measured pair and is stored in a subfolder of the result.

Examples are the cutoff study, alternative preparations of the scans, and studies with scaled heights.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from stiction._files import FolderClaim
from stiction.studies.hardness import (
    AREAS_BY_HARDNESS_FILE,
    choose_hardness_and_modulus_nodes,
    compute_areas_at_nodes,
    count_contact_solutions_at_nodes,
    has_areas_at_nodes,
)
from stiction.studies.load_range import has_only_negligible_loads
from stiction.studies.member_solution import estimate_member_time, estimate_solution_time
from stiction.studies.member_sums import MemberSums
from stiction.studies.members_in_progress import remove_stored_steps
from stiction.studies.onset import ONSET_FILE, ONSET_TABLE_FILE
from stiction.studies.runner import complete_blocks, prepare_result_folder
from stiction.studies.store import (
    BLOCKS_FOLDER,
    STUDY_FILE,
    StoredResult,
    check_unedited,
    check_unused,
    export,
    open_result_to_complete,
)
from stiction.studies.study import Study, find_member_differences

TimeAnnouncer = Callable[[float], Any]  # function that receives the estimated time (s) on one core before a computation


def complete_secondary_study(
    study: Study, folder: Path, executor: Executor, *, progress: bool = False,
    announce_time: TimeAnnouncer = lambda _: None,
) -> MemberSums:  # fmt: skip
    """Compute the members of a secondary study that its folder does not contain yet, and return the result.

    A stored study with other members, for example of another pair, is removed first. Raises the errors of
    `compute_missing_blocks`.
    """
    existing_result = open_result_to_complete(folder)
    with FolderClaim(folder) as claim:
        if existing_result and find_member_differences(existing_result.study, study):
            remove_result(existing_result, claim)
        stored_result = prepare_result_folder(study, folder, claim)
        if num_missing := study.ensemble.repetitions - stored_result.num_finished:
            announce_time(num_missing * estimate_member_time(study))
        return MemberSums(complete_blocks(stored_result, executor=executor, progress=progress))


def compute_missing_areas(
    result: MemberSums, executor: Executor, *, announce_time: TimeAnnouncer = lambda _: None
) -> None:
    """Compute the true areas at other hardnesses and moduli that a stored result requires, unless they are stored.

    Raises a `ValueError` if files of the bodies are missing.
    """
    folder = result.path
    if folder is None or not lacks_areas_at_nodes(result):
        return
    announce_time(estimate_areas_time(result.study))
    if (areas := compute_areas_at_nodes(result.study, executor)) is not None:
        export(areas, folder / AREAS_BY_HARDNESS_FILE, replace=True)


def estimate_areas_time(study: Study) -> float:
    """Estimate the time (s) that one core needs to compute the areas at other hardnesses and moduli."""
    return count_contact_solutions_at_nodes(study) * estimate_solution_time(study) if study.uses_half_space else 0.0


def lacks_areas_at_nodes(result: MemberSums) -> bool:
    """Return whether a result requires true areas at hardnesses or moduli other than its own, and has none."""
    hardnesses, _ = choose_hardness_and_modulus_nodes(result.study)
    return bool(hardnesses.size) and not has_only_negligible_loads(result) and not has_areas_at_nodes(result)


def remove_result(stored_result: StoredResult, claim: FolderClaim) -> None:
    """Remove all files of a result (study, blocks, areas, onset) from a folder, but no other files.

    Raises a `StoreError` if the study file was written or edited by hand, or if another run uses the folder.
    """
    check_unedited(stored_result.path)
    claim.acquire()
    check_unused(stored_result.path, claim)
    for block in stored_result.blocks:
        (stored_result.path / BLOCKS_FOLDER / block.name).unlink(missing_ok=True)
    area_files = (AREAS_BY_HARDNESS_FILE,) if stored_result.study.is_measured else ()
    onset_files = (ONSET_FILE, ONSET_TABLE_FILE) if (stored_result.path / ONSET_FILE).exists() else ()
    remove_stored_steps(stored_result.path)
    for name in (STUDY_FILE, *area_files, *onset_files):
        (stored_result.path / name).unlink(missing_ok=True)
