"""What every command does with a result: open it, say what may be quoted of it, write its table, draw it."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiction.cli.application import announce, say, show_warning, tell

if TYPE_CHECKING:
    from stiction.studies.result import Result


DOUBTS = 5  # lines of them that `pair` says, so that number and verdict stay on a terminal of 24 lines


def opened(directory: Path) -> Result:
    """The result in a directory, and a warning if it is not finished."""
    from stiction.studies.result import Result
    from stiction.studies.store import StoreError, open_stored

    stored = open_stored(directory)
    total = stored.study.ensemble.repetitions
    if not stored.count:
        raise StoreError(f"{directory}: none of its {total} repetitions is finished yet")
    if stored.count < total:
        show_warning(f"{directory}: {stored.count} of {total} repetitions are finished; the result has only those")
    return Result(stored)


def show_result(result: Result, **asked: Any) -> None:
    """Print what a result says at the loads of its study: all of `show_answer`."""
    show_answer(result, **asked)()


def show_answer(
    result: Result, *, command: str, as_json: bool = False, verbose: bool = False, about: dict[str, Any] | None = None
) -> Callable[[], None]:
    """Print text, or JSON, but for what lies beside a result, which what is returned prints; JSON is one."""
    from stiction.studies.store import StoreError
    from stiction.views import rows, text

    study = result.study
    try:
        with warnings.catch_warnings(action="ignore"):  # of tau0, which was told when the study was made
            summary = result.summary()
    except StoreError:
        raise
    except ValueError as error:  # nothing touches
        if as_json:
            tell(rows.record(command, [], **(about or {}), remark=str(error)))
        else:
            tell(f"μ_s  none: {error}")
        return lambda: None
    if not as_json:
        measured = study.is_measured
        most = DOUBTS if command == "pair" else None
        said = text.answer_text(summary, verbose=verbose, most=most) if measured else ""
        tell(said or text.overview_text(summary))

    def rest() -> None:
        whole = result.summary()  # with what was computed in the meantime
        if as_json:
            tell(rows.record_text(command, whole, **(about or {})))
        elif study.is_measured and (more := text.beside_text(whole, verbose=verbose)):
            tell(more)

    return rest


def write_views(result: Result, *, said: Callable[[str], None]) -> None:
    """Write the page, the table and a figure of a measured pair into its folder, and say so in two lines."""
    from stiction.views.figures import drawn
    from stiction.views.files import TABLE, VIEWS, replace_text, result_csv
    from stiction.views.report import save_report

    folder = result.path
    assert folder is not None, "the result of the command is stored"
    replace_text(folder / TABLE, result_csv(result), VIEWS[TABLE])
    announce("drawing")
    drawings = drawn(result, folder, first=True)
    page = folder / "report.html"
    save_report(result, page, name=folder.resolve().name)
    said(f"wrote {page} (open it), {' and '.join([TABLE, *(drawing.name for drawing in drawings)])}")


def draw_result(result: Result, directory: Path, *, formats: Sequence[str] = ("png",)) -> None:
    """Draw the figures of a result into a directory, and say which."""
    from stiction.views.figures import drawn

    announce("drawing")
    for path in drawn(result, directory, formats=formats):
        tell(f"wrote {path}")


def said_by(as_json: bool) -> Callable[[str], None]:
    """Where messages go: beside JSON, which is alone on standard output, to standard error."""
    return say if as_json else tell
