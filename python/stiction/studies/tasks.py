"""What a worker does: one block of members, computed and written."""

from __future__ import annotations

import socket
import time
from dataclasses import dataclass
from pathlib import Path

from stiction._core import __version__
from stiction.studies.pressed import member_sums
from stiction.studies.result import Arrays, stacked
from stiction.studies.store import BLOCKS, put
from stiction.studies.study import Study
from stiction.studies.text import StudyError

LOOK = 0.2
"""Seconds after which a task looks again whether anybody waits for it."""


@dataclass(frozen=True)
class Folder:
    """Where a task writes its block, if the worker sees it."""

    path: Path
    token: str  # name of a file among the blocks, which is there as long as the run that hands out the tasks

    def is_seen(self) -> bool:
        """Whether this process sees the folder, and the run still waits for its tasks."""
        return (self.path / BLOCKS / self.token).exists()


def block_task(version: str, study: Study, members: range, folder: Folder) -> tuple[int, bytes | None]:
    """Compute a block of a study, and write its file, wherever this runs.

    If the run has ended before the block is complete, or a member fails, what was computed is written. Returns how many
    of the members were computed, from the first on, and the file of the block, if it could not be written because the
    folder is not seen from here. Raises a `StudyError` if another version of stiction asks for it, whose results may
    differ, and a `StoreError` if it cannot be written.
    """
    from stiction.studies.netcdf import encoded

    _check(version)
    is_seen = folder.is_seen()
    done: list[Arrays] = []
    looked = time.monotonic()
    for member in members:
        try:
            done.append(member_sums(study, member))
        except Exception:
            if not done:
                raise
            break  # it will be the first of what is left
        if is_seen and time.monotonic() - looked > LOOK:
            if not folder.is_seen():
                break
            looked = time.monotonic()
    content = encoded(study, members[: len(done)], stacked(study, done))
    if not is_seen:
        return len(done), content
    put(folder.path, members[0], content, len(done))
    return len(done), None


def arrays_task(version: str, study: Study, members: range, _: None) -> tuple[int, Arrays]:
    """Compute some members that are not stored; see `block_task`."""
    _check(version)
    return len(members), stacked(study, [member_sums(study, member) for member in members])


def _check(version: str) -> None:
    """Refuse work for another version of stiction."""
    if version != __version__:
        raise StudyError(
            f"the worker on {socket.gethostname()} has stiction {__version__}, and {version} asks for the study; "
            "install the same version everywhere"
        )
