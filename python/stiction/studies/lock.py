"""One writer at a time, or several that share: locks that die with their process, however that dies."""

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
def locked(path: Path, *, shared: bool = False) -> Iterator[None]:
    """Hold the lock of a file, alone or with others who share it.

    The file is there only as long as somebody holds it, or if its holder was killed.

    Raises
    ------
    BlockingIOError
        At once, if somebody else holds it; a thread of the same process is somebody else.
    OSError
        If the file cannot be made or locked.
    """
    with _holding(_acquired(path, shared)) as file:
        try:
            yield
        finally:
            with suppress(OSError):
                if file in _held and _is_at(file, path):  # not in a forked child, which has closed it
                    if shared:
                        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # only the last one can
                    path.unlink()  # before it is released, so that nobody holds a lock on a file that is gone


@contextmanager
def locked_directory(path: Path, *, shared: bool = False) -> Iterator[None]:
    """Hold the lock of a directory itself, by whatever name it is found; raises as `locked`."""
    file = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        fcntl.flock(file, _kind(shared))
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


def is_locked(path: Path) -> bool:
    """Whether somebody else holds the lock of a file, as far as this machine can tell; False where there is none."""
    try:
        file = os.open(path, os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(file)
    return False


def _kind(shared: bool) -> int:
    return (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB


def _acquired(path: Path, shared: bool) -> int:
    while True:
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)
        try:
            fcntl.flock(file, _kind(shared))
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
