"""The `stiction` command: parsing and printing only, a file for each group of commands."""

from __future__ import annotations

import sys

from stiction._dask import hide_dask, show_dask
from stiction.cli.application import start


def main() -> None:
    """Run the command: exit status 0, 2 for bad input with one message, 130 when interrupted."""
    hide_dask()
    try:
        sys.exit(start())
    finally:
        show_dask()  # to whoever calls this and goes on
