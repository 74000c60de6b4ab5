"""Output of results by all commands: friction and assessment on the terminal, tables, figures, and reports."""

from __future__ import annotations

import contextlib
import shlex
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiction._text import printable_path
from stiction.cli.application import print_message, print_output, print_warning, show_status
from stiction.result import Result
from stiction.solve.store import StoreError, open_stored_result
from stiction.summary.summary import Summary
from stiction.views.files import OUTPUT_FILE_SIGNATURES, RESULT_TABLE_NAME, replace_text_file, result_csv
from stiction.views.rows import summary_json
from stiction.views.sentence import no_values_text, quotable_sentences
from stiction.views.text import main_values_text, resolution_and_onset_text, study_result_text

if TYPE_CHECKING:
    from stiction.result import Result
    from stiction.summary.summary import Summary


# With at most this number of caveat lines, the output of `pair` and `run` fits on a screen of 24 lines.
MAX_CAVEAT_LINES = 5

VERBOSE_OPTION = "--verbose"


def complete_output_command(result: Result) -> str:
    """Return the command that prints the friction of a stored result at all loads, mu0 and tau0, with all caveats."""
    return f"stiction info {shlex.quote(printable_path(result.path or Path()))} {VERBOSE_OPTION}"


def open_result_with_warning(directory: Path) -> Result:
    """Open the result in a directory, and print a warning if it is unfinished."""
    stored_result = open_stored_result(directory)
    num_repetitions = stored_result.study.ensemble.repetitions
    count_text = stored_result.study.member_names.with_count(num_repetitions)
    if not stored_result.num_finished:
        raise StoreError(f"{directory}: none of the {count_text} is finished yet")
    if stored_result.num_finished < num_repetitions:
        print_warning(f"{directory}: only {stored_result.num_finished} of {count_text} are finished")
    return Result(stored_result)


def print_result(result: Result, *, verbose: bool = False) -> None:
    """Print friction, assessment, cutoff study and onset of sliding of a result, at the loads of the study."""
    command = complete_output_command(result)
    options: dict[str, Any] = {"max_overview_lines": MAX_CAVEAT_LINES, "complete_command": command}
    print_output(study_result_text(_summarize(result), verbose=verbose, **options))


def print_pair_values(result: Result, *, verbose: bool = False) -> None:
    """Print the friction of a measured pair, without friction at several cutoffs and without the onset of sliding."""
    options: dict[str, Any] = {"max_lines": MAX_CAVEAT_LINES, "complete_command": complete_output_command(result)}
    print_output(main_values_text(_summarize(result), verbose=verbose, **options))


def print_resolution_and_onset(result: Result, *, verbose: bool = False) -> None:
    """Print a pair's onset of sliding and, if `verbose`, friction at several cutoffs; nothing without a coefficient."""
    if text := resolution_and_onset_text(_summarize(result), verbose=verbose):
        print_output(text)


def print_sentences(result: Result) -> None:
    """Print the quotable sentences of a result, one unwrapped line per load."""
    summary = _summarize(result)
    print_output("\n".join(quotable_sentences(summary)) if summary.points else no_values_text(summary))


def print_result_json(result: Result, command: str, **fields: Any) -> None:
    """Print a result as a JSON record, at the loads of the study."""
    print_output(summary_json(command, _summarize(result), **fields))


def _summarize(result: Result) -> Summary:
    """Return the summary of a result. If the result has no coefficient, the summary contains only the reason.

    If `Result.summary` raises a `ValueError`, the summary has no points, and `no_points_reason` contains the message.
    """
    import xarray

    try:
        # A warning about a large tau0 would be repeated here: it was already printed when the study was created.
        with warnings.catch_warnings(action="ignore"):
            return result.summary()
    except StoreError:
        raise
    except ValueError as error:
        return Summary(result.study, xarray.Dataset(), (), no_points_reason=str(error))


def write_pair_files(result: Result, *, print_written: Callable[[str], None]) -> None:
    """Write report, table and figure of a measured pair to its result directory, and print the names of the files.

    If another command has stored other mu0, tau0 or loads in the directory in the meantime, the files are written for
    these, so that they agree with the stored study.
    """
    directory = result.path
    assert directory is not None, "the result of the command is stored"
    show_status(f"the result is stored in {printable_path(directory)}; writing its table, figure and report")
    file_names: list[str] = []
    for _ in range(MAX_OUTPUT_ATTEMPTS):
        stored_result = open_stored_result(directory)
        is_current = stored_result.study.friction == result.study.friction
        if file_names and is_current:
            break
        result = result if is_current else Result(stored_result)
        file_names = _write_result_files(result, directory)
    print_written(f"wrote {file_names[0]} (open it), {' and '.join(file_names[1:])}")


MAX_OUTPUT_ATTEMPTS = 4


def _write_result_files(result: Result, directory: Path) -> list[str]:
    from stiction.views.report import evaluate_report

    report_path = directory / "report.html"
    # If the evaluation fails, no error is raised here, because drawing the report raises the same error.
    with contextlib.suppress(ValueError):
        # The quantities at all loads are evaluated first, because the processes for report and figures both need them.
        result.at_report_loads  # noqa: B018
    with evaluate_report(result, name=directory.resolve().name) as draw_report, draw_report() as get_report:
        # Matplotlib is imported only here, because an earlier import would delay the evaluation.
        from stiction.views.figures import draw_figures

        replace_text_file(directory / RESULT_TABLE_NAME, result_csv(result), OUTPUT_FILE_SIGNATURES[RESULT_TABLE_NAME])
        figure_paths = draw_figures(result, directory, first=True)
        get_report().save(report_path)
    return [str(report_path), RESULT_TABLE_NAME, *(figure_path.name for figure_path in figure_paths)]


def write_figures(result: Result, directory: Path, *, formats: Sequence[str] = ("png",)) -> None:
    """Draw the figures of a result, write them to files in a directory, and print the names of the files."""
    from stiction.views.figures import draw_figures

    show_status("drawing")
    for path in draw_figures(result, directory, formats=formats):
        print_output(f"wrote {printable_path(path)}")


def choose_message_printer(as_json: bool) -> Callable[[str], None]:
    """Return the function that prints messages: on standard error if JSON is printed, else on standard output."""
    return print_message if as_json else print_output
