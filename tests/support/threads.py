"""Check that a call lets other threads run."""

import sys
import threading
import time

MAX_WAITING_TIME = 30.0  # seconds in which another thread gets its turn even on a busy machine


def runs_other_threads(call):
    """Return whether another thread runs during repeated calls, while the interpreter itself never switches threads."""
    started, released, ran = threading.Event(), threading.Event(), threading.Event()

    def wait_for_release():
        started.set()
        released.wait()
        ran.set()

    interval = sys.getswitchinterval()
    thread = threading.Thread(target=wait_for_release)
    thread.start()
    started.wait()
    sys.setswitchinterval(10 * MAX_WAITING_TIME)  # only a call that releases the lock lets the other thread run
    end = time.monotonic() + MAX_WAITING_TIME
    try:
        released.set()
        while not ran.is_set() and time.monotonic() < end:
            call()
        return ran.is_set()
    finally:
        sys.setswitchinterval(interval)
        thread.join()
