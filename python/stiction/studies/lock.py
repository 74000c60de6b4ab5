"""One writer at a time: locks that die with their process, however that dies."""

from __future__ import annotations

import errno
import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_held: set[int] = set()


def _forget() -> None:
    # A forked worker that outlives its parent must not hold on to the lock. Closing a copy releases nothing.
    while _held:
        os.close(_held.pop())


os.register_at_fork(after_in_child=_forget)


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold the lock of a file, which is there only as long as it is held (or if its holder was killed).

    Raises
    ------
    BlockingIOError
        At once, if somebody else holds it; a thread of the same process is somebody else.
    OSError
        If the file cannot be made or locked.
    """
    with _holding(_acquired(path)) as file:
        try:
            yield
        finally:
            with suppress(OSError):
                if file in _held and _is_at(file, path):  # not in a forked child, which has closed it
                    path.unlink()  # before it is released, so that nobody holds a lock on a file that is gone


@contextmanager
def locked_directory(path: Path) -> Iterator[None]:
    """Hold the lock of a directory itself, by whatever name it is found; raises as `locked`."""
    file = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno != errno.EBADF:  # NFS locks only what is open for writing, which a directory cannot be
            os.close(file)
            raise
    with _holding(file):
        yield


@contextmanager
def _holding(file: int) -> Iterator[int]:
    _held.add(file)
    try:
        yield file
    finally:
        if file in _held:
            _held.remove(file)
            os.close(file)


def _acquired(path: Path) -> int:
    while True:
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _is_at(file, path):
                return file
        except BaseException:
            os.close(file)
            raise
        os.close(file)  # its last holder removed it after we had opened it


def _is_at(file: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file), path.stat(follow_symlinks=False))
    except FileNotFoundError:
        return False
