"""Command-line interface `stiction`, which parses arguments and prints results. Each group of commands has a module."""

from __future__ import annotations

import _thread
import math
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

EXIT_INTERRUPTED = 130  # exit status after Ctrl-C, the same as in shells
EXIT_BAD_INPUT = 2  # exit status after an error in the input

MIN_ADDRESS_SPACE = 2**30
"""Address space in bytes (ulimit -v) below which OpenBLAS may block forever while SciPy is imported."""


def main() -> None:
    """Run the command and exit with status 0, status 2 after a message for bad input, or status 130 after Ctrl-C."""
    _redirect_closed_streams()
    if (address_space := _address_space_limit()) < MIN_ADDRESS_SPACE:
        min_megabytes = MIN_ADDRESS_SPACE // 10**6
        print(
            f"stiction: the memory is limited to {address_space // 10**6} MB (ulimit -v); "
            f"at least {min_megabytes} MB are needed",
            file=sys.stderr,
        )
        sys.exit(EXIT_BAD_INPUT)
    try:
        with exit_on_interrupt():
            from stiction.cli.application import run_command_line
        status = run_command_line()
    except KeyboardInterrupt:  # Ctrl-C was pressed during the import of libraries
        status = EXIT_INTERRUPTED
    if status == EXIT_INTERRUPTED:  # exit without waiting for threads that still run a computation
        with suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(status)
    sys.exit(status)


@contextmanager
def exit_on_interrupt() -> Iterator[None]:
    """Exit on Ctrl-C while modules are imported, because some modules catch every exception.

    OpenBLAS raises the same signal if it cannot start its threads, for example if the number of processes is limited.
    """

    def exit_process(*_: object) -> None:
        if _can_start_thread():
            os.write(2, b"stiction: interrupted\n")
            os._exit(EXIT_INTERRUPTED)
        os.write(2, b"stiction: no thread can be started; the number of processes may be limited (ulimit -u)\n")
        os._exit(EXIT_BAD_INPUT)

    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield  # keep a custom handler; in a background job, keep ignoring SIGINT
        return
    try:
        signal.signal(signal.SIGINT, exit_process)
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _can_start_thread() -> bool:
    try:
        _thread.start_new_thread(lambda: None, ())
    except RuntimeError:
        return False
    return True


def _redirect_closed_streams() -> None:
    """Redirect closed standard streams to the null device, so that no other file gets their descriptors."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            null_device = os.open(os.devnull, os.O_RDWR)  # `open` returns the lowest free descriptor
            setattr(sys, name, os.fdopen(null_device, "w" if number else "r"))


def _address_space_limit() -> float:
    """Return the address-space limit of this process in bytes, or infinity if there is none."""
    try:
        import resource
    except ImportError:  # Windows has no module `resource`
        return math.inf
    soft_limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return math.inf if soft_limit == resource.RLIM_INFINITY else soft_limit
