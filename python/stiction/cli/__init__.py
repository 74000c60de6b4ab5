"""The `stiction` command: parsing and printing only, a file for each group of commands."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command: exit status 0, 2 for bad input with one message, 130 when interrupted."""
    from stiction.cli.application import start  # the function `stiction.pair` needs no command line

    sys.exit(start())
