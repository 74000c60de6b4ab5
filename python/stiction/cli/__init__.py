"""Command-line interface `stiction`, with one module per group of commands."""

from __future__ import annotations

import gc
import math
import os
import sys
from contextlib import suppress

from stiction.cli.exit_status import EXIT_BAD_INPUT, EXIT_INTERRUPTED, exit_on_interrupt

MIN_ADDRESS_SPACE = 2**30
"""Minimum address space (bytes, ulimit -v). With less, OpenBLAS may block forever while SciPy is imported."""

ALLOCATIONS_PER_COLLECTION = 1_000_000
"""Number of new objects after which Python's garbage collector searches for unused cycles of objects.

A command with a short computation allocates fewer objects, most of them in imported libraries. With Python's default,
700 in Python 3.11, the collector traverses these objects so often that `stiction pair` takes a tenth longer.
"""


def main() -> None:
    """Run a command, and exit with status 0 after success, 2 after bad input, or 130 after Ctrl-C."""
    gc.set_threshold(ALLOCATIONS_PER_COLLECTION)
    # For small matrices, one OpenBLAS thread suffices; others would occupy the processor for 0.1 s while they wait.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Pydantic would otherwise read the metadata of all installed packages to find its plugins.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # Xarray would otherwise import Dask, which takes 0.3 s and is needed only for computations on clusters.
    sys.modules.setdefault("dask", None)  # type: ignore[arg-type]
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
            # The application is imported inside `try`, so that Ctrl-C is handled during its import, too.
            from stiction.cli.application import run_command_line
        status = run_command_line()
    except KeyboardInterrupt:
        status = EXIT_INTERRUPTED
    # After Ctrl-C, `os._exit` ends the process without waiting for threads that are still computing.
    if status == EXIT_INTERRUPTED:
        with suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(status)
    # At the exit, Python would otherwise search all objects of imported libraries for unused cycles, which takes 0.2 s.
    gc.freeze()
    sys.exit(status)


def _redirect_closed_streams() -> None:
    """Redirect closed standard streams to the null device, so that files opened later do not replace the streams."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            # `os.fstat` fails for a closed stream, whose number `os.open` then reuses as the lowest free number.
            null_device = os.open(os.devnull, os.O_RDWR)
            setattr(sys, name, os.fdopen(null_device, "w" if number else "r"))


def _address_space_limit() -> float:
    """Return the limit of the address space (bytes) of this process.

    Returns infinity without a limit.
    """
    try:
        import resource
    except ImportError:
        # Windows has no module `resource`.
        return math.inf
    soft_limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return math.inf if soft_limit == resource.RLIM_INFINITY else soft_limit
