"""Whether calls let other threads run."""

import sys
import threading
import time

PATIENCE = 30.0  # seconds in which another thread has to get its turn on a busy machine


def ticks_during(call):
    """Call until another thread has run, and say whether it has: the interpreter alone gives it no turn."""
    ticked, done = threading.Event(), threading.Event()

    def tick():
        begun.set()
        done.wait()
        ticked.set()

    begun, interval = threading.Event(), sys.getswitchinterval()
    thread = threading.Thread(target=tick)
    thread.start()
    begun.wait()
    sys.setswitchinterval(10 * PATIENCE)  # only a lock that is released lets the other run
    end = time.monotonic() + PATIENCE
    try:
        done.set()
        while not ticked.is_set() and time.monotonic() < end:
            call()
        return ticked.is_set()
    finally:
        sys.setswitchinterval(interval)
        thread.join()
