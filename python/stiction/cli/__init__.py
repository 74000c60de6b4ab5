"""The `stiction` command: parsing and printing only, a file for each group of commands."""

from __future__ import annotations

import sys
import warnings
from typing import Any

from stiction.cli import measured, studies  # noqa: F401, each adds its commands
from stiction.cli.application import INTERRUPTED, app, say


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    print(f"stiction: warning: {message}", file=sys.stderr)


def main() -> None:
    """Run the command: exit status 0, 2 for bad input with one message, 130 when interrupted."""
    warnings.showwarning = _show_warning
    try:
        app()
    except (ValueError, OSError, MemoryError) as error:
        say(str(error) or type(error).__name__)
        sys.exit(2)
    except KeyboardInterrupt:
        say("interrupted")
        sys.exit(INTERRUPTED)
