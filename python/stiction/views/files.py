"""Results as files for other programs, by the ending of their names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from stiction._text import named
from stiction.studies.store import export
from stiction.views.asked import at_asked_loads
from stiction.views.inputs import doubts_of_study
from stiction.views.rows import csv_text

if TYPE_CHECKING:
    from stiction.studies.store import Stored


def write_table(stored: Stored, path: Path) -> None:
    """Write the values of a result at the loads of its study as CSV."""
    text = csv_text(at_asked_loads(stored), stored.study, beside=doubts_of_study(stored.study))
    path.write_text(text, encoding="utf-8")


WRITERS: dict[str, tuple[str, Callable[[Stored, Path], None]]] = {
    ".nc": ("the whole result", export),
    ".csv": ("a table", write_table),
}
"""What writes a result to a file that does not exist yet, and what the file then holds, by the ending of its name."""


def write_result(stored: Stored, path: Path) -> None:
    """Write a result to a new file, in the format that its name says.

    Raises a `ValueError` if the file exists, cannot be written, or its name has no ending of `WRITERS`.
    """
    if path.suffix.lower() not in WRITERS:
        endings = " or ".join(f"{ending} ({what})" for ending, (what, _) in WRITERS.items())
        raise ValueError(f"{named(path)}: its name must end in {endings}")
    if path.exists():
        raise ValueError(f"{named(path)}: exists already; remove it, or choose another name")
    WRITERS[path.suffix.lower()][1](stored, path)
