"""Check whether a call releases the interpreter lock, so that other threads can run during the call."""

import sys
import threading
import time

MAX_WAITING_SECONDS = 30.0  # time (s) within which another thread starts, even on a busy machine


def releases_interpreter_lock(call):
    """Return whether another thread runs during calls, while the interpreter itself does not switch threads."""
    started, released, has_run = threading.Event(), threading.Event(), threading.Event()

    def wait_for_release():
        started.set()
        released.wait()
        has_run.set()

    interval = sys.getswitchinterval()
    thread = threading.Thread(target=wait_for_release)
    thread.start()
    started.wait()
    # Set a long switch interval, so that threads switch only when a lock is released.
    sys.setswitchinterval(10 * MAX_WAITING_SECONDS)
    end = time.monotonic() + MAX_WAITING_SECONDS
    try:
        released.set()
        while not has_run.is_set() and time.monotonic() < end:
            call()
        return has_run.is_set()
    finally:
        sys.setswitchinterval(interval)
        thread.join()
