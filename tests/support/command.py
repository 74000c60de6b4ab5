"""Calls of the `stiction` command in tests."""

import contextlib
import functools
import io
import os
import sys
import warnings
from types import SimpleNamespace
from unittest import mock

import typer
from stiction import cli
from stiction.views.files import REPORT_FILE_SIGNATURE, replace_text_file

# xarray needs Dask if Dask was available when xarray was imported, even if main() prevents the import.
with contextlib.suppress(ImportError):
    import dask.base  # noqa: F401


@contextlib.contextmanager
def disable_drawing():
    """Return a context manager in which Matplotlib neither draws figures nor computes their layout, to save time."""
    with (
        mock.patch("matplotlib.figure.Figure.draw", return_value=None),
        mock.patch("matplotlib.layout_engine.ConstrainedLayoutEngine.execute", return_value=None),
    ):
        yield


@contextlib.contextmanager
def disable_companion_files():
    """Return a context manager in which pairs compute no contact picture, cutoff study or onset, to save time."""
    with (
        mock.patch("stiction.pipeline.contact_picture", return_value=None),
        mock.patch("stiction.pipeline.compute_companion_files", return_value=None),
    ):
        yield


def empty_figures():
    """Return a context manager in which commands write empty figures under the names of the result's figures."""
    from matplotlib.figure import Figure
    from stiction.views.figures import standard

    select_figures = standard.select_figures

    def select_empty_figures(*arguments):
        # Use small empty figures, because most of the time for writing a figure is spent on compressing pixels.
        return ((name, functools.partial(Figure, figsize=(1, 1))) for name, _ in select_figures(*arguments))

    return mock.patch.object(standard, "select_figures", select_empty_figures)


def disable_reports():
    """Return a context manager in which reports of results are empty pages, to save time."""

    def write_empty_page(path):
        replace_text_file(path, REPORT_FILE_SIGNATURE, REPORT_FILE_SIGNATURE.encode())

    empty_page = mock.Mock(save=write_empty_page)
    return mock.patch.multiple(
        "stiction.views.report",
        save_report=lambda _, path, **__: write_empty_page(path),
        evaluate_report=lambda *_, **__: contextlib.nullcontext(lambda: contextlib.nullcontext(lambda: empty_page)),
    )


get_command_once = functools.cache(typer.main.get_command)
"""Cached function that builds a command from the signature of a function, which takes longer than a short command."""


def call_stiction(*arguments, cwd, columns=200, without_figures=False, without_report=False):
    """Run `stiction` in this process, and return its exit status and output.

    Running in this process is faster than starting a new one. If `without_figures` is true, figures are empty. If
    `without_report` is true, the report on a result is empty.
    """
    out, err = io.StringIO(), io.StringIO()
    with (
        disable_drawing() if without_figures else contextlib.nullcontext(),
        empty_figures() if without_figures else contextlib.nullcontext(),
        disable_reports() if without_report else contextlib.nullcontext(),
        mock.patch("typer.main.get_command", get_command_once),
        contextlib.chdir(cwd),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        warnings.catch_warnings(),  # restores the warning function that main() replaces
        mock.patch.object(sys, "argv", ["stiction", *map(str, arguments)]),
        mock.patch.dict(os.environ, {"COLUMNS": str(columns), "CI": "1"}),
    ):
        warnings.simplefilter("default")
        try:
            cli.main()
            status = 0
        except SystemExit as exit_request:
            status = exit_request.code or 0
    return SimpleNamespace(returncode=status, stdout=out.getvalue(), stderr=err.getvalue())


def check_stiction(*arguments, **options):
    """Run `stiction` with `call_stiction`, and assert exit status 0."""
    completed = call_stiction(*arguments, **options)
    assert completed.returncode == 0, completed.stderr
    return completed


def assert_rejected(completed, *words):
    """Assert that a command failed with exit status 2, and with a short message that contains given words."""
    assert completed.returncode == 2, completed
    assert "Traceback" not in completed.stderr
    assert len(completed.stderr.splitlines()) <= 8, completed.stderr
    for word in words:
        assert word in completed.stderr, completed.stderr
