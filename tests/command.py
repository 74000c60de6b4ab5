"""The `stiction` command as tests call it."""

import contextlib
import io
import os
import sys
import warnings
from types import SimpleNamespace
from unittest import mock

from stiction import cli


def nothing_drawn():
    """Figures have nothing on them while this is entered, and take no time."""
    return mock.patch("matplotlib.figure.Figure.draw", return_value=None)


def stiction_command(*arguments, cwd, columns=200, blank=False):
    """The command in this process, as a shell would see it: a new interpreter for each would take most of the time.

    Of a blank one nobody looks at what its figures and pages show.
    """
    out, err = io.StringIO(), io.StringIO()
    with (
        nothing_drawn() if blank else contextlib.nullcontext(),
        contextlib.chdir(cwd),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        warnings.catch_warnings(),  # main() replaces how they are shown
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


def stiction_done(*arguments, **options):
    """The same of a command that does what is asked of it."""
    done = stiction_command(*arguments, **options)
    assert done.returncode == 0, done.stderr
    return done


def assert_refused(done, *words):
    """One message of a few lines on standard error, exit status 2, no traceback."""
    assert done.returncode == 2, done
    assert "Traceback" not in done.stderr
    assert len(done.stderr.splitlines()) <= 8, done.stderr
    for word in words:
        assert word in done.stderr, done.stderr
