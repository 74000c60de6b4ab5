"""Files that people ask for by name, written whole or not at all; and files of others, read within bounds."""

from __future__ import annotations

import os
import platform
import re
import secrets
import stat
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from stiction._text import named

HALF_WRITTEN = re.compile(r"\.stiction-([0-9a-f]{8})-([0-9]+)-([0-9a-f]{8})-[0-9a-f]{8}\.partial")
"""Name of a file that is being written: it says on which machine, and by which process. Whoever is killed leaves it."""

OLD = 3600.0  # seconds after which nobody is still writing a file on another machine
_HERE = f"{zlib.crc32(platform.node().encode()):08x}"
_THIS_RUN = secrets.token_hex(4)  # the number of a process may have been that of one that was killed
_MARKED = 2**16  # bytes at the beginning and at the end of a file in which its mark is searched


# ---- Writing --------------------------------------------------------------------------------------------------------


@contextmanager
def new_file(path: Path, failure: type[ValueError]) -> Iterator[Path]:
    """A file to write, which gets its name, that nothing has yet, when it is whole; or a failure that says why not."""
    with _said(path, failure):
        if os.path.lexists(path):
            raise FileExistsError
        with _partial(path, os.link) as partial:  # unlike a rename, never over another file
            yield partial


@contextmanager
def replaced_file(path: Path, mark: bytes, failure: type[ValueError]) -> Iterator[Path]:
    """A file to write, which takes the place of an older one when it is whole; one without the mark is left alone."""
    check_replaceable(path, mark, failure)
    with _said(path, failure), _partial(path, Path.replace) as partial:
        yield partial


def check_replaceable(path: Path, mark: bytes, failure: type[ValueError]) -> None:
    """Raise a failure if the path exists and is no file with the mark; a link that leads nowhere exists."""
    with _said(path, failure):
        if os.path.lexists(path) and not _is_ours(path, mark):
            raise failure(f"{named(path)}: exists already and is something else; remove it, or choose another name")


def replace(path: Path, content: bytes) -> None:
    """Write a file that appears under its name, in place of an older one, when it is whole."""
    with _partial(path, Path.replace) as partial:
        partial.write_bytes(content)


@contextmanager
def _partial(path: Path, put: Callable[[Path, Path], object]) -> Iterator[Path]:
    """An empty file beside a path, which is put there when it is whole, and is gone afterwards in any case."""
    partial = path.parent / half_written()
    try:  # from here on, for Ctrl-C comes as soon as the file is there
        os.close(os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666))
        yield partial
        put(partial, path)
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def half_written() -> str:
    """A new name that is unused, of a fixed length."""
    return f".stiction-{_HERE}-{os.getpid()}-{_THIS_RUN}-{secrets.token_hex(4)}.partial"


def sweep(folder: Path) -> None:
    """Remove the half-written files of processes that are gone; a folder that cannot be written stays as it is."""
    with suppress(OSError):
        for entry in os.scandir(folder):
            match = HALF_WRITTEN.fullmatch(entry.name)
            if match and entry.is_file(follow_symlinks=False) and _is_left_behind(entry, *match.groups()):
                with suppress(OSError):
                    os.unlink(entry)


def _is_left_behind(entry: os.DirEntry[str], machine: str, process: str, run: str) -> bool:
    if machine != _HERE or os.name != "posix":
        return time.time() - entry.stat(follow_symlinks=False).st_mtime > OLD
    if int(process) == os.getpid():
        return run != _THIS_RUN
    try:
        os.kill(int(process), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:
        pass
    return False


@contextmanager
def _said(path: Path, failure: type[ValueError]) -> Iterator[None]:
    try:
        yield
    except FileExistsError:
        raise failure(f"{named(path)}: exists already; remove it, or choose another name") from None
    except OSError as error:
        raise failure(f"{named(path)}: cannot be written: {reason(error)}") from None


def _is_ours(path: Path, mark: bytes) -> bool:
    if not path.is_file():
        return False
    with path.open("rb") as file:
        head = file.read(_MARKED)
        file.seek(max(len(head), path.stat().st_size - _MARKED))
        return mark in head or mark in file.read(_MARKED)


# ---- Reading --------------------------------------------------------------------------------------------------------


class NotReadableError(Exception):
    """A file that is not of the expected kind."""


def content(path: Path, most: int, start: bytes = b"") -> bytes:
    """Return the bytes of a regular file; devices and pipes are not waited for.

    Raises a `NotReadableError` if it is another kind of file, is longer than `most` bytes or does not begin with
    `start`, and an `OSError` if it cannot be read.
    """
    status = path.stat()
    if not (stat.S_ISREG(status.st_mode) or stat.S_ISDIR(status.st_mode)):
        raise NotReadableError("is no regular file")
    if stat.S_ISREG(status.st_mode) and status.st_size > most:
        raise NotReadableError(f"is longer than {most} bytes")
    with open(path, "rb", opener=_without_waiting) as file:
        head = file.read(len(start))
        if head != start:
            raise NotReadableError(f"does not begin with {start.decode()!r}")
        return head + file.read()


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def reason(error: OSError) -> str:
    """Why the system refused, without the name of a file that only we know."""
    return os.strerror(error.errno) if error.errno else str(error)
