"""How commands compute what is missing of a study: in which folder, by which workers, with which messages."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import Annotated, Any

from stiction._text import printable_path
from stiction._units import short_repr
from stiction.cli.application import announce, interrupted, say, tell
from stiction.cli.options import option
from stiction.studies.executors import threads
from stiction.studies.pipeline import complete
from stiction.studies.result import Result
from stiction.studies.store import OtherStudyError, StoreError, open_stored
from stiction.studies.study import Study
from stiction.studies.values import StudyError

Workers = Annotated[
    int | None, option("--workers -w N", "Threads that compute.", "one for each core", least=1, panel="Computing")
]

Scheduler = Annotated[str | None, option(
    "--scheduler ADDRESS",
    "Compute on the workers of a Dask scheduler, as in tcp://host:8786.", False, panel="Computing",
)]  # fmt: skip

Part = Annotated[
    str | None, option("--part I/N", "Only the I-th of N parts, as in 3/16, beside others.", False, panel="Computing")
]

_FILES = (".nc", ".csv", ".pdf", ".png", ".svg", ".txt", ".html", ".json", ".xlsx", ".zip", ".toml")


def executor_of(workers: int | None, scheduler: str | None) -> contextlib.AbstractContextManager[Executor]:
    """What computes: threads, or the workers of a scheduler."""
    if scheduler is None:
        return threads(workers)
    if workers is not None:
        raise StudyError("--workers and --scheduler exclude each other")
    from stiction.studies.executors import connected

    return connected(scheduler)


def part_of(text: str | None) -> tuple[int, int] | None:
    """Which of how many parts, of the option `--part`."""
    if text is None:
        return None
    match = re.fullmatch(r"([1-9][0-9]{0,8})/([1-9][0-9]{0,8})", text)
    if not match or int(match[1]) > int(match[2]):
        raise StudyError(f"--part must be K/N with K from 1 to N, as in 3/16, got {short_repr(text)}")
    return int(match[1]), int(match[2])


def check_folder(directory: Path) -> None:
    """Refuse a folder for results that is, or is named as, a file."""
    if directory.is_file():
        raise StudyError(f"{printable_path(directory)} is a file; say where the results shall go with --output DIR")
    if directory.suffix.lower() in _FILES and not directory.exists():
        raise StudyError(f"--output {printable_path(directory)}: is the name of a file; results go into a directory")


def _advice(error: OtherStudyError, study: Study, *, replaceable: bool) -> str:
    """Return which options and commands get around a folder that has another study."""
    ways = ["--output DIR takes another folder"]
    if replaceable:
        ways.append("--replace writes over the stored result")
    steps, loads = error.stored.contact.steps(), [float(load) for load in study.friction.load]
    only_loads = all(key == "contact.load" for key, *_ in error.differ)
    if only_loads and loads and steps[0] <= min(loads) and max(loads) <= steps[-1]:
        options = " ".join(f"--load '{load.text}'" for load in study.friction.load)
        ways.append(f"stiction at {printable_path(error.path)} {options} reads these loads off it, and presses nothing")
    return "; ".join(ways)


def fill_folder(
    study: Study, directory: Path, executor: Executor, *, said: Callable[[str], None] = tell, **asked: Any
) -> Result:
    """`complete` with messages for a person at a terminal, `said` those of what was written; it may be interrupted."""
    check_folder(directory)
    try:
        return complete(study, directory, executor, progress=True, said=said, say=say, announce=announce, **asked)
    except OtherStudyError as error:
        raise error.with_advice(_advice(error, study, replaceable="replace" in asked)) from None
    except KeyboardInterrupt:
        words = ""
        with contextlib.suppress(StoreError):  # nothing is there yet
            stored = open_stored(directory)
            kept = f"{stored.count} of {stored.study.ensemble.repetitions} repetitions are finished and kept"
            words = f"; {kept}: the same command goes on from there"
        raise interrupted(words) from None
