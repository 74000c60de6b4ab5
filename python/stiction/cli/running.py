"""How commands compute what is missing of a study: in which folder, by which workers, with which messages."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import Annotated

from stiction._core import __version__
from stiction._text import named
from stiction._units import shortened
from stiction.cli.application import announce, interrupted, say, tell
from stiction.cli.options import option
from stiction.studies.complete import fill_beside, remove_result, write_picture
from stiction.studies.executors import threads
from stiction.studies.runner import filled, prepared
from stiction.studies.same_study import Difference, listed
from stiction.studies.store import STUDY, Stored, StoreError, open_stored
from stiction.studies.study import Study, differences
from stiction.studies.text import StudyError

Workers = Annotated[
    int | None, option("--workers -w", "N", "Threads that compute.", "one for each core", least=1, panel="Computing")
]

Scheduler = Annotated[
    str | None,
    option(
        "--scheduler",
        "ADDRESS",
        "Compute on the workers of a Dask scheduler, as in tcp://host:8786.",
        False,
        panel="Computing",
    ),
]

Part = Annotated[
    str | None,
    option("--part", "I/N", "Only the I-th of N parts, as in 3/16, beside others.", False, panel="Computing"),
]

_FILES = (".nc", ".csv", ".pdf", ".png", ".svg", ".txt", ".html", ".json", ".xlsx", ".zip", ".toml")


def executor_of(workers: int | None, scheduler: str | None) -> contextlib.AbstractContextManager[Executor]:
    """What computes: threads, or the workers of a scheduler."""
    if scheduler is None:
        return threads(workers)
    if workers is not None:
        raise StudyError("--workers and --scheduler exclude each other")
    from stiction.studies.cluster import connected

    return connected(scheduler)


def part_of(text: str | None) -> tuple[int, int] | None:
    """Which of how many parts, of the option `--part`."""
    if text is None:
        return None
    match = re.fullmatch(r"([1-9][0-9]{0,8})/([1-9][0-9]{0,8})", text)
    if not match or int(match[1]) > int(match[2]):
        raise StudyError(f"--part must be K/N with K from 1 to N, as in 3/16, got {shortened(text)}")
    return int(match[1]), int(match[2])


def check_folder(directory: Path) -> None:
    """Refuse a folder for results that is, or is named as, a file."""
    if directory.is_file():
        raise StudyError(f"{named(directory)} is a file; say where the results shall go with --output DIR")
    if directory.suffix.lower() in _FILES and not directory.exists():
        raise StudyError(f"--output {named(directory)}: is the name of a file; results go into a directory")


def fill_folder(
    study: Study,
    directory: Path,
    executor: Executor,
    *,
    said: Callable[[str], None] = tell,
    part: tuple[int, int] | None = None,
    replace: bool = False,
    beside: bool = True,
    onset: int | None = None,
    progress: bool = True,
) -> Stored:
    """Compute what a folder lacks of a study, or of one of its parts, and say what was done.

    Parameters
    ----------
    study : Study
    directory : Path
    executor : concurrent.futures.Executor
    said : callable
        Prints the names of files that were written.
    part : (int, int), optional
        Which of how many parts.
    replace : bool
        Whether the result of another study that lies there is removed.
    beside, onset
        Whether the picture of contacts and what `fill_beside` computes are wanted too, and its onset.
    progress : bool
        Whether to draw a progress bar.

    Returns
    -------
    Stored
        What the folder holds now.
    """
    check_folder(directory)
    there = open_stored(directory) if (directory / STUDY).exists() else None
    if replace and there:
        remove_result(directory)
    total = study.ensemble.repetitions
    try:
        stored = prepared(study, directory, part)
        before = stored.count
        if there and before and (other := _other_friction(there.study, stored.study)):
            say(f"{directory} was asked for other friction; its {before} repetitions are kept, and its table, page and "
                f"figures are replaced\n{listed(other)}")  # fmt: skip
        stored = filled(stored, part=part, executor=executor, progress=progress, say=said)
    except KeyboardInterrupt:
        raise interrupted(_how_to_go_on(directory)) from None
    if beside and part is None:
        write_picture(stored, anew=before < total)
    if part is not None:
        said(f"part {part[0]}/{part[1]} is finished; {stored.count} of {total} repetitions are in {directory}")
    elif before < total:
        said(f"wrote {directory}" + (f" ({before} of its {total} repetitions were there already)" if before else ""))
    else:
        by = "" if stored.version == __version__ else f", computed by stiction {stored.version}"
        said(f"{directory} holds this study already{by}")
    if beside and part is None:
        fill_beside(stored, executor, onset, progress=progress, announce=announce, say=say)
    return stored


def _other_friction(one: Study, other: Study) -> list[Difference]:
    return [each for each in differences(one, other) if each[0].startswith("friction.")]


def _how_to_go_on(directory: Path) -> str:
    try:
        stored = open_stored(directory)
    except StoreError:
        return ""
    finished, total = stored.count, stored.study.ensemble.repetitions
    return f"; {finished} of {total} repetitions are finished and kept: the same command goes on from there"
