"""Worker processes on this machine, each at the end of a pipe that nobody else can open."""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

MOST_DEATHS = 5
"""Of workers over one task, which is then given up."""


_CODE = """
import os, sys
try:
    sys.path[:] = {path!r}
    from {name} import _serve
except BaseException:
    os._exit(1)
_serve({file})
"""
"""Modules are looked for where this process does: what lies in the working directory is not imported."""


class WorkerError(ValueError):
    """A task whose workers die."""


@contextlib.contextmanager
def processes(workers: int) -> Iterator[Executor]:
    """Worker processes, one task each at a time; one that dies is replaced, and computes its task again.

    On leaving, what is still being computed ends at once.

    Raises
    ------
    WorkerError
        By a task that is given up, because every worker that computed it died.
    """
    pool = _Processes(workers)
    try:
        yield pool
    finally:
        pool.stop()


class _Processes(ThreadPoolExecutor):
    """A thread for each process, which sends it a task and waits for the result."""

    def __init__(self, workers: int) -> None:
        super().__init__(workers, initializer=_leave_interrupts_to_the_main_thread)
        self._own = threading.local()
        self._all: set[_Worker] = set()
        self._changing = threading.Lock()
        self._stopped = False

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
        return super().submit(self._computed, function, args, kwargs)

    def stop(self) -> None:
        """End the processes, whatever they do."""
        with self._changing:
            self._stopped = True
            for worker in self._all:
                worker.kill()
        self.shutdown(cancel_futures=True)
        for worker in self._all:
            worker.close()

    def _computed(self, function: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
        message = pickle.dumps((function, args, kwargs))
        ends: list[str] = []
        while len(ends) < MOST_DEATHS:
            worker = self._worker()
            try:
                answer = worker.answer(message)
            except (EOFError, OSError):  # its end of the pipe is closed
                ends.append(self._buried(worker))
                continue
            result, error = pickle.loads(answer)
            if error is not None:
                raise error
            return result
        raise WorkerError(
            f"a task was given up, because every process that took it died: {ends[-1]}; "
            "perhaps there is not enough memory for so many"
        )

    def _worker(self) -> _Worker:
        """That of this thread."""
        worker: _Worker | None = getattr(self._own, "worker", None)
        if worker is None:
            with self._changing:
                if self._stopped:
                    raise WorkerError("the processes were ended")
                self._own.worker = worker = _Worker()
                self._all.add(worker)
        return worker

    def _buried(self, worker: _Worker) -> str:
        self._own.worker = None
        with self._changing:
            self._all.discard(worker)
        worker.kill()
        return worker.close()


class _Worker:
    """A process, and this end of its pipe."""

    def __init__(self) -> None:
        self._pipe, there = Pipe()
        code = _CODE.format(path=sys.path, name=__name__, file=there.fileno())
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-c", code], pass_fds=[there.fileno()], stdin=subprocess.DEVNULL
            )
        except BaseException:
            self._pipe.close()
            raise
        finally:
            there.close()

    def answer(self, message: bytes) -> bytes:
        """What the process makes of a message; an EOFError or OSError if it is no longer there."""
        self._pipe.send_bytes(message)
        return self._pipe.recv_bytes()

    def kill(self) -> None:
        self._process.kill()

    def close(self) -> str:
        """How the process ended."""
        status = self._process.wait()
        self._pipe.close()
        return f"ended by signal {-status}" if status < 0 else f"ended with status {status}"


def _leave_interrupts_to_the_main_thread() -> None:
    # Processes started by this thread inherit it: Ctrl-C reaches them as well, and is not theirs to answer.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def _serve(file: int) -> None:
    """What a worker does: tasks come and results go until the other end is closed, by whatever."""
    pipe = Connection(file)
    tasks: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_compute, args=(pipe, tasks), daemon=True).start()
    with contextlib.suppress(EOFError, OSError):
        while True:
            tasks.put(pipe.recv_bytes())
    os._exit(0)  # in the middle of a task, whose result nobody waits for


def _compute(pipe: Connection, tasks: queue.SimpleQueue[bytes]) -> None:
    while True:
        message = tasks.get()
        try:
            function, args, kwargs = pickle.loads(message)
            answer = pickle.dumps((function(*args, **kwargs), None))
        except BaseException as error:
            answer = _failure(error)
        pipe.send_bytes(answer)


def _failure(error: BaseException) -> bytes:
    with contextlib.suppress(Exception):
        answer = pickle.dumps((None, error))
        pickle.loads(answer)  # which not every exception allows
        return answer
    return pickle.dumps((None, RuntimeError(f"{type(error).__name__}: {error}")))
