"""The `stiction` command: parsing and printing only, a file for each group of commands."""

from __future__ import annotations

import os
import sys
from contextlib import suppress

INTERRUPTED = 130  # exit status, as of a shell's own commands


def main() -> None:
    """Run the command: exit status 0, 2 for bad input with one message, 130 when interrupted."""
    try:
        from stiction.cli.application import start

        status = start()
    except KeyboardInterrupt:  # while libraries are loaded
        status = INTERRUPTED
    if status == INTERRUPTED:  # threads may still compute, and nobody waits for them
        with suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(status)
    sys.exit(status)
