"""The `stiction` command: parsing and printing only, a file for each group of commands."""

from __future__ import annotations

import math
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

INTERRUPTED = 130  # exit status, as of a shell's own commands
BAD_INPUT = 2  # exit status

MIN_ADDRESS_SPACE = 2**30
"""Bytes of address space (ulimit -v) below which OpenBLAS may wait for memory for ever while SciPy is loaded."""


def main() -> None:
    """Run the command: exit status 0, 2 for bad input with one message, 130 when interrupted."""
    _open_closed_streams()
    if (limit := _address_space()) < MIN_ADDRESS_SPACE:
        needed = MIN_ADDRESS_SPACE // 10**6
        print(
            f"stiction: memory is limited to {limit // 10**6} MB here (ulimit -v); at least {needed} MB are needed",
            file=sys.stderr,
        )
        sys.exit(BAD_INPUT)
    try:
        with end_at_interrupt():
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


@contextmanager
def end_at_interrupt() -> Iterator[None]:
    """End the process at Ctrl-C while modules are loaded: some catch every exception, and would go on."""

    def end(*_: object) -> None:
        os.write(2, b"stiction: interrupted\n")
        os._exit(INTERRUPTED)

    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield  # another handler, or none, as in the background of a shell
        return
    try:
        signal.signal(signal.SIGINT, end)
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _open_closed_streams() -> None:
    """Open standard streams that are closed, to nowhere: the next file to be opened would take their place."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            null = os.open(os.devnull, os.O_RDWR)  # gets the lowest number that is free
            setattr(sys, name, os.fdopen(null, "w" if number else "r"))


def _address_space() -> float:
    """Return the limit of address space in bytes, infinite where there is none."""
    try:
        import resource
    except ImportError:  # not on Windows
        return math.inf
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return math.inf if limit == resource.RLIM_INFINITY else limit
