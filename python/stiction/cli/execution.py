"""Computation of a study in an output directory, with progress messages."""

from __future__ import annotations

import contextlib
import re
import shlex
import sys
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from stiction._text import printable_path
from stiction._threads import thread_pool_executor
from stiction._units import short_repr
from stiction.cli.application import print_message, print_output, report_interruption, show_status
from stiction.pipeline import complete_result
from stiction.result import Result
from stiction.solve.executors import connect_to_cluster
from stiction.solve.members_in_progress import find_members_in_progress
from stiction.solve.store import StoreError, StudyMismatchError, open_stored_result
from stiction.study.study import Study
from stiction.study.values import StudyError

_FILE_ENDINGS = (".nc", ".csv", ".pdf", ".png", ".svg", ".txt", ".html", ".json", ".xlsx", ".zip", ".toml")


def open_executor(workers: int | None, scheduler: str | None) -> contextlib.AbstractContextManager[Executor]:
    """Return an executor that runs tasks in the given number of threads, or on the workers of a Dask scheduler."""
    if scheduler is None:
        return thread_pool_executor(workers)
    if workers is not None:
        raise StudyError("--workers must not be combined with --scheduler")
    # The entry None, which `main` sets to prevent the import of Dask, is removed, because a cluster needs Dask.
    if sys.modules.get("dask") is None:
        sys.modules.pop("dask", None)
    return connect_to_cluster(scheduler)


def parse_part(text: str | None) -> tuple[int, int] | None:
    """Parse `--part I/N`, which selects part I of a computation in N parts, and return both numbers."""
    if text is None:
        return None
    match = re.fullmatch(r"([1-9][0-9]{0,8})/([1-9][0-9]{0,8})", text)
    if not match or int(match[1]) > int(match[2]):
        raise StudyError(f"--part must be I/N with I between 1 and N, such as 3/16, got {short_repr(text)}")
    return int(match[1]), int(match[2])


def check_output_directory(directory: Path) -> None:
    """Raise a `StudyError` if the output directory is a file, or has a name with a file extension."""
    if directory.is_file():
        raise StudyError(
            f"{printable_path(directory)} must be a directory, got a file; use --output DIR to choose a directory"
        )
    if directory.suffix.lower() in _FILE_ENDINGS and not directory.exists():
        raise StudyError(f"--output must be a directory, got the file name {printable_path(directory)}")


def _conflict_advice(error: StudyMismatchError, study: Study, *, is_replaceable: bool) -> str:
    """Return advice to a user whose output directory already contains the result of another study."""
    remedies = ["choose another directory with --output DIR"]
    if is_replaceable:
        remedies.append("overwrite the stored result with --replace")
        growth = error.stored.contact.junction_growth
        if growth is not None and [key for key, *_ in error.differences] == ["contact.junction_growth"]:
            remedies.append(f"open the stored result with --junction-growth {shlex.quote(growth.text)}")
    loading_steps, loads = error.stored.contact.loading_steps(), [float(load) for load in study.friction.load]
    only_loads = all(study_key == "contact.load" for study_key, *_ in error.differences)
    if only_loads and loads and loading_steps[0] <= min(loads) and max(loads) <= loading_steps[-1]:
        options = " ".join(f"--load '{load.text}'" for load in study.friction.load)
        remedies.append(
            f"evaluate the stored result at these loads: stiction at {printable_path(error.path)} {options}"
        )
    return "; or ".join(remedies)


def compute_result_in_directory(
    study: Study, directory: Path, executor: Executor, *, print_written: Callable[[str], None] = print_output,
    show_companions: Callable[[Result], Any] = lambda _: None, **options: Any,
) -> Result:  # fmt: skip
    """Compute the result of a study in a directory, write its files, and print the progress and file names.

    If Ctrl-C is pressed, print how to resume.

    `print_written` is called with the names of written files, and `show_companions` with the complete result.
    """
    check_output_directory(directory)
    try:
        result = complete_result(
            study, directory, executor, progress=True, print_finished=print_written, print_remark=print_message,
            announce=show_status, **options,
        )  # fmt: skip
        show_companions(result)
        return result
    except StudyMismatchError as error:
        is_replaceable = "replace" in options and not error.is_edited
        raise error.with_remedy(_conflict_advice(error, study, is_replaceable=is_replaceable)) from None
    except KeyboardInterrupt:
        resume_text = ""
        # Opening the result fails if no result is stored yet.
        with contextlib.suppress(StoreError):
            stored_result = open_stored_result(directory)
            count_text = study.member_names.with_count(stored_result.study.ensemble.repetitions)
            progress = f"{stored_result.num_finished} of {count_text} are finished and stored"
            if num_in_progress := len(find_members_in_progress(directory)):
                progress += f", and the finished steps of {num_in_progress} more"
            resume_text = f"; {progress}: run the same command again to resume"
        raise report_interruption(resume_text) from None
