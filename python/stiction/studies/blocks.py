"""Repetitions of a store by blocks: so many in a chunk of each variable, and their flags, which are written last.

Any process that sees the store may write a block, as long as it holds the lock of that block. It reads what is finished
there, puts its own beside it, and replaces the chunks and then the flags, each by a rename: what is finished keeps its
bits, and at any moment the store is whole.
"""

from __future__ import annotations

import os
import re
import time
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction._files import NotReadableError, content, reason, replace
from stiction._text import named
from stiction.studies.layout import (
    COMPLETE,
    FILL,
    METADATA,
    MOST_METADATA,
    DecodingError,
    chunk,
    decoded,
    encoded,
)
from stiction.studies.lock import is_locked, locked

PATIENCE = 60.0
"""Seconds to wait for somebody else who writes the same block, which takes a fraction of one."""


class StoreError(ValueError):
    """A store that cannot be written or read."""


class NotWrittenError(Exception):
    """Why the system refused to write a block."""


@dataclass(frozen=True)
class Blocks:
    """The blocks of a store, to be read."""

    path: Path
    shown: Path  # the name it was given, for messages
    size: int  # repetitions in each

    def finished(self, total: int) -> NDArray[np.intp]:
        """Repetitions that carry their flag, of so many, in order.

        Raises
        ------
        StoreError
            If a flag is damaged.
        """
        try:
            files = os.listdir(self.path / COMPLETE)
        except OSError as error:
            raise StoreError(f"{named(self.shown)}: is damaged: {COMPLETE}: {error.strerror or error}") from None
        blocks = sorted(int(match[1]) for file in files if (match := re.fullmatch(r"c\.(0|[1-9][0-9]{0,17})", file)))
        found = [block * self.size + np.flatnonzero(self.flags(block)) for block in blocks if block * self.size < total]
        numbers = np.concatenate([np.empty(0, np.intp), *found])
        return np.asarray(numbers[numbers < total])

    def flags(self, block: int) -> NDArray[np.bool_]:
        """(size,): which repetitions of a block are finished."""
        name = f"{COMPLETE}/c.{block}"
        try:
            return decoded(self.path / name, np.dtype(np.bool_), (self.size,))
        except FileNotFoundError:
            return np.zeros(self.size, np.bool_)
        except (OSError, DecodingError) as error:
            raise self._damage(name, block, error) from None

    def read(self, name: str, dtype: np.dtype[Any], shape: tuple[int, ...], block: int) -> NDArray[Any]:
        """A variable of a block, whose shape is that of one repetition, with all of its repetitions third."""
        file = f"{name}/{chunk(block, len(shape) + 1)}"
        try:
            return decoded(self.path / file, dtype, (*shape[:2], self.size, *shape[2:]))
        except (OSError, DecodingError) as error:
            raise self._damage(file, block, error) from None

    def _damage(self, file: str, block: int, error: Exception) -> StoreError:
        why = reason(error) if isinstance(error, OSError) else error
        flag = self.shown / COMPLETE / f"c.{block}"
        first, last = block * self.size, (block + 1) * self.size - 1
        return StoreError(
            f"{named(self.shown)}: is damaged: {file}: {why}\n"
            f"to have {f'repetition {first}' if first == last else f'repetitions {first} to {last}'} computed again, "
            f"remove {named(flag)} and run its study on it again"
        )


@dataclass(frozen=True)
class Writing:
    """The blocks of a store, to be written: by whoever opened it, and by workers that it hands this to."""

    blocks: Blocks
    root: int  # checksum of the root's metadata, to know the store by
    writer: str  # of the locks, the one that is held by whoever opened it

    def is_shared(self) -> bool:
        """Whether this process sees the store of whoever opened it, and their locks: then it may write a block."""
        return self._root() == self.root and is_locked(self.blocks.path / COMPLETE / self.writer)

    def stored(self, repetitions: Sequence[int]) -> frozenset[int]:
        """Those of some repetitions of one block that are finished."""
        block = repetitions[0] // self.blocks.size
        return frozenset((block * self.blocks.size + np.flatnonzero(self.blocks.flags(block))).tolist())

    def check_is_there(self) -> None:
        """Raise a StoreError if somebody has removed the store, or put something else in its place."""
        if self._root() != self.root:
            raise StoreError(f"{named(self.blocks.shown)}: was removed or replaced while it was being written")

    def _root(self) -> int | None:
        return root_checksum(self.blocks.path)

    def save(self, repetitions: Sequence[int], sums: Mapping[str, NDArray[Any]]) -> bool:
        """Store some repetitions of one block for good; what others have stored in the meantime stays.

        Parameters
        ----------
        repetitions : (n,) sequence of int
        sums : mapping of str to (..., ..., n, ...) ndarray
            Each variable of the result.

        Returns
        -------
        bool
            Whether they are stored; they are not if whoever opened the store has closed it, or was killed.

        Raises
        ------
        StoreError
            If the store is gone or damaged.
        NotWrittenError
            If it cannot be written; what was finished before stays so.
        """
        self.check_is_there()
        block = repetitions[0] // self.blocks.size
        try:
            with self._alone(block):
                if not self.is_shared():
                    self.check_is_there()
                    return False
                flags = self.blocks.flags(block)
                places = np.asarray(repetitions) - block * self.blocks.size
                fresh = ~flags[places]
                if not fresh.any():
                    return True
                for name, values in sums.items():
                    file = self.blocks.path / name / chunk(block, values.ndim)
                    own = values if fresh.all() else values[:, :, fresh]
                    replace(file, encoded(file, self._beside(name, own, block, flags, places[fresh])))
                flag = self.blocks.path / COMPLETE / f"c.{block}"
                flags[places] = True
                replace(flag, encoded(flag, flags))
                return True
        except OSError as error:
            self.check_is_there()
            raise NotWrittenError(reason(error)) from None

    def _beside(
        self, name: str, values: NDArray[Any], block: int, flags: NDArray[np.bool_], places: NDArray[np.intp]
    ) -> NDArray[Any]:
        """A whole block of a variable: what is finished there, some repetitions at their places, and nothing."""
        if np.array_equal(places, np.arange(self.blocks.size)):
            return values  # most blocks are written in one go, and copies take longer than writing does
        shape = (*values.shape[:2], *values.shape[3:])
        if flags.any():
            whole = self.blocks.read(name, values.dtype, shape, block)
        else:
            whole = np.full((*shape[:2], self.blocks.size, *shape[2:]), FILL[values.dtype.kind], values.dtype)
        whole[:, :, places] = values
        return whole

    def wait_for_others(self) -> None:
        """Until nobody writes any more who was writing a block when this was called."""
        deadline = time.monotonic() + PATIENCE
        for lock in list((self.blocks.path / COMPLETE).glob("block-*.lock")):
            while is_locked(lock) and time.monotonic() < deadline:
                time.sleep(0.01)

    @contextmanager
    def _alone(self, block: int) -> Iterator[None]:
        deadline = time.monotonic() + PATIENCE
        while True:
            lock = locked(self.blocks.path / COMPLETE / f"block-{block}.lock")
            try:
                lock.__enter__()
                break
            except BlockingIOError:
                if time.monotonic() > deadline:
                    raise StoreError(
                        f"{named(self.blocks.shown)}: somebody else has been writing block {block} for {PATIENCE:g} s"
                    ) from None
                time.sleep(0.01)
        try:
            yield
        finally:
            lock.__exit__(None, None, None)


def root_checksum(path: Path) -> int | None:
    """Of the root's metadata as they stand; None if there are none."""
    try:
        return zlib.crc32(content(path / METADATA, MOST_METADATA, link=False))
    except (OSError, NotReadableError):
        return None
