"""Files that people ask for by name: written whole or not at all, and never over another of another kind."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def new_file(path: Path, failure: type[ValueError]) -> Iterator[Path]:
    """A file to write, which gets its name, that nothing has yet, when it is whole; or a failure that says why not."""
    with _partial(path, failure, os.link) as partial:  # unlike a rename, never over another file
        if os.path.lexists(path):
            raise FileExistsError
        yield partial


@contextmanager
def replaced_file(path: Path, mark: bytes, failure: type[ValueError]) -> Iterator[Path]:
    """A file to write, which takes the place of an older one when it is whole; one without the mark is left alone."""
    with _partial(path, failure, os.replace) as partial:
        if os.path.lexists(path) and not (path.is_file() and _begins_with(path, mark)):
            raise failure(f"{path}: exists already and is something else; remove it, or choose another name")
        yield partial


@contextmanager
def _partial(path: Path, failure: type[ValueError], put: Callable[[Path, Path], None]) -> Iterator[Path]:
    """A file beside a path, which is put there when it is whole, and is gone afterwards in any case."""
    partial = path.with_name(f"{path.name}.partial-{os.getpid()}")
    try:
        yield partial
        put(partial, path)
    except FileExistsError:
        raise failure(f"{path}: exists already; remove it, or choose another name") from None
    except OSError as error:
        raise failure(f"{path}: cannot be written: {os.strerror(error.errno) if error.errno else error}") from None
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def _begins_with(path: Path, mark: bytes) -> bool:
    with path.open("rb") as file:
        return file.read(len(mark)) == mark
