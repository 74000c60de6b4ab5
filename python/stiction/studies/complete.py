"""A folder made complete: the blocks of a study, and of a measured pair its contacts, cut-offs and onset of sliding."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from stiction._files import replace as put
from stiction.studies.runner import fill, filled, prepared
from stiction.studies.same_study import computed_otherwise
from stiction.studies.store import BLOCKS, STUDY, Stored, open_stored
from stiction.studies.study import Study

Say = Callable[[str], Any]
"""A function that tells a person a line."""


def _nothing(_: str) -> None:
    """Tell nobody."""


def complete(
    study: Study, folder: Path, executor: Executor, *, replace: bool = False, onset: int | None = None,
    progress: bool = False,
) -> Stored:  # fmt: skip
    """Compute what a folder lacks of a study and of what is kept beside it; another study there may be replaced."""
    if replace and (folder / STUDY).exists():
        remove_result(folder)
    stored = prepared(study, folder)
    is_new = stored.count < study.ensemble.repetitions
    stored = filled(stored, executor=executor, progress=progress)
    write_picture(stored, anew=is_new)
    fill_beside(stored, executor, onset, progress=progress)
    return stored


def write_picture(stored: Stored, *, anew: bool) -> None:
    """Write the contacts of a typical member of measured areas beside its blocks, for figures and pages."""
    if not stored.study.is_measured or not stored.study.is_areal:
        return
    from stiction.studies.contact_picture import FILE, contact_picture
    from stiction.studies.export import export

    if not anew and (stored.path / FILE).exists():
        return
    try:
        picture = contact_picture(stored)
    except ValueError:  # the files are not there any more
        return
    if picture is not None:
        export(picture, stored.path / FILE, replace=True)


def fill_beside(
    stored: Stored, executor: Executor, onset: int | None = None, *, progress: bool = False, announce: Say = _nothing,
    say: Say = _nothing,
) -> None:  # fmt: skip
    """Compute what is kept beside the result of a measured pair, and not there yet: cut-offs, and the onset of sliding.

    Parameters
    ----------
    stored : Stored
    executor : concurrent.futures.Executor
    onset : int, optional
        Members whose onset is computed, 0 for none; a few by default.
    progress : bool
        Whether to draw progress bars.
    announce, say : callable
        Told what is about to be computed, and why it is not.
    """
    from stiction.studies.export import export
    from stiction.studies.onset import FILE, TABLE, backbone, onset_beside, onset_of_result
    from stiction.studies.resolution import FOLDER, resolution_study

    if not stored.study.is_measured:
        return
    try:
        over = resolution_study(stored.study)
        if over is not None:
            folder = stored.path / FOLDER
            if (folder / STUDY).exists() and computed_otherwise(open_stored(folder).study, over):
                remove_result(folder)  # of another pair, or of other loads
            announce("over cut-offs")
            fill(over, folder, executor=executor, progress=progress)
        there = onset_beside(stored)
        if onset == 0 or (there is not None and onset in (None, int(there.attrs["members"]))):
            return
        announce("onset of sliding")
        curve = onset_of_result(stored.study, executor, members=onset)
    except ValueError as error:  # the files are not there any more
        say(f"without cut-offs or onset: {error}")
        return
    if curve is not None:
        export(curve, stored.path / FILE, replace=True)
        put(stored.path / TABLE, backbone(curve).encode())


def remove_result(directory: Path) -> None:
    """Remove the study and the blocks of a result, and nothing else that lies in its folder."""
    from stiction.studies.onset import FILE, TABLE

    for block in open_stored(directory).blocks:
        (directory / BLOCKS / block.name).unlink(missing_ok=True)
    for name in (STUDY, FILE, TABLE) if (directory / FILE).exists() else (STUDY,):
        (directory / name).unlink(missing_ok=True)
