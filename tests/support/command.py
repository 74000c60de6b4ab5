"""Run the `stiction` command in tests."""

import contextlib
import io
import os
import sys
import warnings
from types import SimpleNamespace
from unittest import mock

from stiction import cli


def disable_drawing():
    """Return a context manager that disables drawing by Matplotlib, to save time."""
    return mock.patch("matplotlib.figure.Figure.draw", return_value=None)


def call_stiction(*arguments, cwd, columns=200, without_figures=False):
    """Run `stiction` in this process and return its exit status and output.

    This is faster than a new process. If `without_figures` is true, figures are empty.
    """
    out, err = io.StringIO(), io.StringIO()
    with (
        disable_drawing() if without_figures else contextlib.nullcontext(),
        contextlib.chdir(cwd),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        warnings.catch_warnings(),  # This restores the warning function that main() replaces.
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
    """Run `stiction` by `call_stiction`, and assert exit status 0."""
    completed = call_stiction(*arguments, **options)
    assert completed.returncode == 0, completed.stderr
    return completed


def assert_rejected(completed, *words):
    """Assert that a command failed with exit status 2 and a short message that contains the given words."""
    assert completed.returncode == 2, completed
    assert "Traceback" not in completed.stderr
    assert len(completed.stderr.splitlines()) <= 8, completed.stderr
    for word in words:
        assert word in completed.stderr, completed.stderr
