"""Threads for computations."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor


def num_usable_cores() -> int:
    """Return the number of cores that this process may use."""
    num_cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return num_cores or 1


class _ThreadPool(ThreadPoolExecutor):
    """Thread pool that continues with fewer threads if the system cannot start the requested number."""

    def _adjust_thread_count(self) -> None:
        try:
            super()._adjust_thread_count()
        except RuntimeError:
            if not self._threads:
                raise


@contextlib.contextmanager
def thread_pool_executor(workers: int | None = None) -> Iterator[Executor]:
    """Yield a thread pool with one thread per core by default.

    The pool is closed when the context ends.

    If the system limits the number of threads, the pool works with the threads that can start. Raises a `RuntimeError`
    if no thread can start.
    """
    pool = _ThreadPool(workers or num_usable_cores(), thread_name_prefix="stiction")
    pool.submit(int)
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()
