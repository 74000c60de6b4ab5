"""Results as files for other programs, by the ending of their names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from stiction._files import check_replaceable, new_file, replaced_file
from stiction._text import printable_path
from stiction.studies.result import Result
from stiction.views.latex import latex_table
from stiction.views.report.page import MARK
from stiction.views.spreadsheet import csv_of_frame
from stiction.views.style import MARKS

TABLE = "result.csv"
VIEWS = {TABLE: b"coefficient of static friction: lower", "report.html": MARK.encode(), "friction.png": MARKS[".png"]}
"""Files that a pair writes into its folder when it has been computed, and the mark by which each is recognised."""


def check_files(folder: Path, marks: Mapping[str, bytes]) -> None:
    """Raise a `ValueError` if a file in a folder, to be replaced later, exists without its mark."""
    for name, mark in marks.items():
        check_replaceable(folder / name, mark, ValueError)


def replace_text(path: Path, text: str, mark: bytes) -> None:
    """Write a text in place of an older file with the mark; a `ValueError` if another file has the name."""
    with replaced_file(path, mark, ValueError) as partial:
        partial.write_text(text, encoding="utf-8")


def new_text(path: Path, text: str) -> None:
    """Write a text to a new file; a `ValueError` if the file exists or cannot be written."""
    with new_file(path, ValueError) as partial:
        partial.write_text(text, encoding="utf-8")


def result_csv(result: Result) -> str:
    """Return the values of a result at the loads of its study as CSV."""
    return csv_of_frame(result.to_dataframe())


WRITERS: dict[str, tuple[str, Callable[[Result, Path], None]]] = {
    ".nc": ("the whole result", Result.to_netcdf),
    ".csv": ("a table", lambda result, path: new_text(path, result_csv(result))),
    ".tex": ("a LaTeX table", lambda result, path: new_text(path, latex_table(result.summary()))),
}
"""What writes a result to a file that does not exist yet, and what the file then holds, by the ending of its name."""


def write_result(result: Result, path: Path) -> None:
    """Write a result to a new file, in the format that its name says.

    Raises a `ValueError` if the file exists, cannot be written, or its name has no ending of `WRITERS`.
    """
    if path.suffix.lower() not in WRITERS:
        endings = " or ".join(f"{ending} ({what})" for ending, (what, _) in WRITERS.items())
        raise ValueError(f"{printable_path(path)}: its name must end in {endings}")
    WRITERS[path.suffix.lower()][1](result, path)
