"""Atomic writing of files, and reading of files up to a limited size."""

from __future__ import annotations

import errno
import os
import platform
import re
import secrets
import stat
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from stiction._text import printable_path

PARTIAL_FILE_NAME_PATTERN = re.compile(r"\.stiction-([0-9a-f]{8})-([0-9]+)-([0-9a-f]{8})-[0-9a-f]{8}\.partial")
"""Pattern for the names of partial files, which a killed process leaves behind.

The name contains the machine, the process id, the run and a random number.
"""

# Age (s) above which a partial file from another machine counts as abandoned.
MAX_PARTIAL_FILE_AGE = 3600.0
# Interval (s) between renewals of the file that claims a directory. A claim expires only after several missed renewals.
CLAIM_FILE_REFRESH_INTERVAL = 300.0
_MACHINE_TOKEN = f"{zlib.crc32(platform.node().encode()):08x}"
# A random token identifies this process, because the operating system reuses process numbers.
_PROCESS_TOKEN = secrets.token_hex(4)
_NUM_BYTES_SEARCHED_FOR_FILE_MARK = 2**16


# ---- Writing --------------------------------------------------------------------------------------------------------


@contextmanager
def create_file_atomically(path: Path, error_type: type[ValueError]) -> Iterator[Path]:
    """Yield a temporary file, which is renamed to `path` when it is complete.

    An existing file is not replaced.
    """
    check_creatable(path, error_type)
    # Unlike `os.rename`, `os.link` never replaces an existing file.
    with _translate_os_errors(path, error_type), _open_partial_file(path, os.link) as partial_path:
        yield partial_path


def check_creatable(path: Path, error_type: type[ValueError]) -> None:
    """Raise an error of type `error_type` if a path exists (even as a broken link) or its directory is missing."""
    with _translate_os_errors(path, error_type):
        if os.path.lexists(path):
            raise FileExistsError
        # The trailing slash of the path makes `os.stat` raise an error if the parent directory is missing or is a file.
        os.stat(os.path.join(path.parent, ""))


@contextmanager
def replace_file_atomically(path: Path, mark: bytes, error_type: type[ValueError]) -> Iterator[Path]:
    """Yield a temporary file that replaces `path` when it is complete.

    An existing file must contain `mark`.

    A file that does not contain the bytes `mark` near its start or its end was not written by this package.
    """
    check_replaceable(path, mark, error_type)
    with _translate_os_errors(path, error_type), _open_partial_file(path, Path.replace) as partial_path:
        yield partial_path


def check_replaceable(path: Path, mark: bytes, error_type: type[ValueError]) -> None:
    """Raise an error of type `error_type` if a path exists and is not a file that contains the bytes `mark`.

    Stiction writes this mark to its files. A dangling link counts as existing.
    """
    with _translate_os_errors(path, error_type):
        if os.path.lexists(path) and not contains_file_mark(path, mark):
            raise error_type(
                f"{printable_path(path)}: already exists and was not written by stiction; remove it, or choose "
                "another name"
            )


def create_atomically(path: Path, content: bytes) -> None:
    """Write a new file that appears under its final name only after it is complete.

    If several processes create the same path at the same time, exactly one succeeds, provided that the file system has
    hard links.
    """
    if os.path.lexists(path):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))
    try:
        with _open_partial_file(path, os.link) as partial_path:
            partial_path.write_bytes(content)
    except FileExistsError:
        raise
    except OSError:
        # Creating the file fails if the disk is full, or if the file system has no hard links.
        if os.path.lexists(path):
            raise
        write_atomically(path, content)


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file under a temporary name, and move the complete file to `path`, where it replaces an old file."""
    with _open_partial_file(path, Path.replace) as partial_path:
        partial_path.write_bytes(content)


@contextmanager
def _open_partial_file(path: Path, move_file: Callable[[Path, Path], object]) -> Iterator[Path]:
    """Yield an empty file under a temporary name in the directory of `path`.

    After success, `move_file` moves the file to `path`. After an error, the file is removed.
    """
    partial_path = path.parent / new_partial_file_name()
    # The partial file is created inside `try`, so that it is removed even if Ctrl-C is pressed immediately afterwards.
    try:
        os.close(os.open(partial_path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666))
        yield partial_path
        move_file(partial_path, path)
    finally:
        with suppress(OSError):
            partial_path.unlink(missing_ok=True)


def new_partial_file_name() -> str:
    """Return a unique name for a partial file, that is, for a file that is still being written."""
    return f".stiction-{_MACHINE_TOKEN}-{os.getpid()}-{_PROCESS_TOKEN}-{secrets.token_hex(4)}.partial"


class DirectoryClaim:
    """Lock file that reserves a directory for one run until the end of a `with` block.

    A thread refreshes the file, because other machines ignore a claim that is older than `MAX_PARTIAL_FILE_AGE`. If the
    process is killed, the file stays and becomes stale, so that it does not lock the directory.
    """

    def __init__(self, directory: str | Path) -> None:
        self.file = Path(directory) / new_partial_file_name()
        self._has_ended = threading.Event()
        self._refresh_thread: threading.Thread | None = None

    def __enter__(self) -> DirectoryClaim:
        return self

    def __exit__(self, *_: object) -> None:
        self._has_ended.set()
        try:
            if self._refresh_thread is not None:
                self._refresh_thread.join()
        finally:
            with suppress(OSError):
                self.file.unlink(missing_ok=True)

    def acquire(self) -> None:
        """Create the lock file in the directory, and refresh it at regular intervals. The directory must exist."""
        self.file.touch()
        if self._refresh_thread is None:
            self._refresh_thread = threading.Thread(target=self._refresh_regularly, daemon=True)
            self._refresh_thread.start()

    def _refresh_regularly(self) -> None:
        while not self._has_ended.wait(CLAIM_FILE_REFRESH_INTERVAL):
            with suppress(OSError):
                # Another machine may have removed the claim file as abandoned.
                self.file.touch()

    def find_other_claim(self) -> Path | None:
        """Return the lock file of another active run in the same directory.

        Returns None if no other run is active in the directory.

        If two runs acquire their claims first and call this function afterwards, at least one of them finds the other.
        """
        for entry, is_stale in _scan_partial_files(self.file.parent):
            if not is_stale and entry.name != self.file.name:
                return Path(entry)
        return None


def remove_stale_partial_files(directory: Path) -> None:
    """Remove unfinished files from a directory if the processes that wrote these files have ended.

    Files that cannot be removed are ignored.
    """
    with suppress(OSError):
        for entry, is_stale in _scan_partial_files(directory):
            if is_stale:
                with suppress(OSError):
                    os.unlink(entry)


def _scan_partial_files(directory: Path) -> Iterator[tuple[os.DirEntry[str], bool]]:
    """Yield each unfinished file in a directory, and whether it is stale (its process ended, or it is too old)."""
    with os.scandir(directory) as iterator:
        entries = list(iterator)
    for entry in entries:
        match = PARTIAL_FILE_NAME_PATTERN.fullmatch(entry.name)
        # Another process may have completed and renamed the partial file in the meantime.
        with suppress(FileNotFoundError):
            if match and entry.is_file(follow_symlinks=False):
                yield entry, _is_stale_partial_file(entry, *match.groups())


def _is_stale_partial_file(entry: os.DirEntry[str], machine_token: str, process: str, process_token: str) -> bool:
    if machine_token != _MACHINE_TOKEN or os.name != "posix":
        return time.time() - entry.stat(follow_symlinks=False).st_mtime > MAX_PARTIAL_FILE_AGE
    if int(process) == os.getpid():
        return process_token != _PROCESS_TOKEN
    try:
        os.kill(int(process), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:
        pass
    return False


@contextmanager
def _translate_os_errors(path: Path, error_type: type[ValueError]) -> Iterator[None]:
    try:
        yield
    except FileExistsError:
        raise error_type(f"{printable_path(path)}: already exists; remove it, or choose another name") from None
    except OSError as error:
        raise error_type(f"{printable_path(path)}: cannot be written: {describe_os_error(error)}") from None


def contains_file_mark(path: Path, mark: bytes) -> bool:
    """Return whether a path is a file that contains the byte string `mark` near the start or the end of the file."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        head = file.read(_NUM_BYTES_SEARCHED_FOR_FILE_MARK)
        file.seek(max(len(head), path.stat().st_size - _NUM_BYTES_SEARCHED_FOR_FILE_MARK))
        return mark in head or mark in file.read(_NUM_BYTES_SEARCHED_FOR_FILE_MARK)


# ---- Reading --------------------------------------------------------------------------------------------------------


class UnreadableFileError(Exception):
    """Error raised if a path is not a regular file, or if the file is too long or starts with unexpected bytes."""


def check_is_file(path: Path) -> None:
    """Raise `UnreadableFileError` for a directory, a device or a pipe."""
    if not stat.S_ISREG(mode := path.stat().st_mode):
        raise UnreadableFileError("is a directory" if stat.S_ISDIR(mode) else "is not a file")


def read_file_bytes(path: Path, max_bytes: int, start: bytes = b"") -> bytes:
    """Return the bytes of a regular file.

    For a device or a pipe, raise an error instead of waiting.

    The error is an `UnreadableFileError` if the path is not a regular file, or if the file is longer than `max_bytes`
    or does not begin with `start`. It is an `OSError` if the file cannot be read.
    """
    file_status = path.stat()
    if not (stat.S_ISREG(file_status.st_mode) or stat.S_ISDIR(file_status.st_mode)):
        raise UnreadableFileError("is not a regular file")
    if stat.S_ISREG(file_status.st_mode) and file_status.st_size > max_bytes:
        raise UnreadableFileError(f"is longer than {max_bytes} bytes")
    with open(path, "rb", opener=_open_nonblocking) as file:
        head = file.read(len(start))
        if head != start:
            raise UnreadableFileError(f"does not begin with {start.decode()!r}")
        return head + file.read()


def _open_nonblocking(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def describe_os_error(error: OSError) -> str:
    """Return the reason stated in an `OSError`, but not the file name, because the file may be temporary."""
    return os.strerror(error.errno) if error.errno else str(error)
