"""Exit statuses of the command `stiction`, and a context that exits on Ctrl-C while modules are imported."""

from __future__ import annotations

import _thread
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

EXIT_INTERRUPTED = 130  # as in shells
EXIT_BAD_INPUT = 2


@contextmanager
def exit_on_interrupt() -> Iterator[None]:
    """Exit the process on Ctrl-C while modules are imported, because some modules catch all exceptions.

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
        # Only Python's default SIGINT handler is replaced: a background job, for example, continues to ignore SIGINT.
        yield
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
