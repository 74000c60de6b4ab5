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
    """Return a context in which Matplotlib draws nothing, which saves time."""
    return mock.patch("matplotlib.figure.Figure.draw", return_value=None)


def call_stiction(*arguments, cwd, columns=200, without_figures=False):
    """Run `stiction` in this process and return its exit status and output.

    A new interpreter for each command would take most of the time. With `without_figures` figures are empty.
    """
    out, err = io.StringIO(), io.StringIO()
    with (
        disable_drawing() if without_figures else contextlib.nullcontext(),
        contextlib.chdir(cwd),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        warnings.catch_warnings(),  # main() replaces the function that shows warnings
        mock.patch.object(sys, "argv", ["stiction", *map(str, arguments)]),
        mock.patch.dict(os.environ, {"COLUMNS": str(columns), "CI": "1"}),
    ):
        warnings.simplefilter("default")
        try:
            cli.main()
            status = 0
        except SystemExit as end:
            status = end.code or 0
    return SimpleNamespace(returncode=status, stdout=out.getvalue(), stderr=err.getvalue())


def check_stiction(*arguments, **options):
    """Run `stiction` as `call_stiction` does, and assert that it succeeds."""
    completed = call_stiction(*arguments, **options)
    assert completed.returncode == 0, completed.stderr
    return completed


def assert_rejected(completed, *words):
    """Assert exit status 2 and at most 8 lines on standard error that contain the words and no traceback."""
    assert completed.returncode == 2, completed
    assert "Traceback" not in completed.stderr
    assert len(completed.stderr.splitlines()) <= 8, completed.stderr
    for word in words:
        assert word in completed.stderr, completed.stderr
