"""Results on disk: a Zarr store that grows by repetitions and may be killed at any moment.

Repetitions are kept in blocks, as `blocks` says. Only what carries its flag counts. All metadata follow from the study,
which stands in the root and is written last when repetitions are added: what was interrupted is put right by writing
the metadata again.

One process holds the store alone and computes what is missing; or several share it, each with a part of the blocks of
its own. None of those may change the metadata: that is done by whoever comes first, alone for that moment.
"""

from __future__ import annotations

import json
import os
import random
import secrets
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._core import __version__
from stiction._files import NotReadableError, content, reason, replace
from stiction._text import named, printable
from stiction.studies.blocks import Blocks, NotWrittenError, StoreError, Writing, root_checksum
from stiction.studies.dataset import NAMES, coordinates_of
from stiction.studies.layout import (
    BLOCK,
    COMPLETE,
    METADATA,
    PARTIAL,
    SCHEMA,
    DecodingError,
    block_of,
    checksum,
    decoded,
    is_known,
    is_left_behind,
    is_lock,
    layout,
    metadata,
)
from stiction.studies.lock import locked, locked_directory
from stiction.studies.study import Study, differences, study_of_attributes
from stiction.studies.study_text import StudyError

if TYPE_CHECKING:
    import xarray

_CHECKED = ("data_type", "chunk_grid", "chunk_key_encoding", "fill_value", "dimension_names", "attributes")
"""Of an array's metadata; codecs may be spelt differently by other versions of Zarr, and the shape may have grown."""

PATIENCE = 60.0
"""Seconds that a part waits for another process to have laid out the store."""


class BusyError(StoreError):
    """A store that somebody else is writing."""


@dataclass(frozen=True)
class StoreInfo:
    """What a store holds."""

    study: Study
    finished: int  # repetitions, of study.ensemble.repetitions
    size: int  # bytes on disk
    versions: dict[str, str]  # of stiction, the schema and NumPy when it was begun


# ---- Reading --------------------------------------------------------------------------------------------------------


def read(path: str | Path) -> xarray.Dataset:
    """Read a result from its store: into memory, or if it is larger than 256 MiB, whatever is asked for when it is.

    Of a study that is not finished, the dataset has the finished repetitions only, and a warning says so.

    Parameters
    ----------
    path : path

    Returns
    -------
    xarray.Dataset
        What `run` returned.

    Raises
    ------
    StoreError
        If there is no result at that path, or none of its repetitions is finished, or it is damaged.
    """
    path = Path(path)
    root = _Root.of(path, path)
    _check_metadata(path, path, root)
    total = root.study.ensemble.repetitions
    finished = root.blocks(path, path).finished(total)
    if not finished.size:
        raise StoreError(f"{named(path)}: none of its {total} repetitions is finished yet")
    if finished.size < total:
        warnings.warn(
            f"{named(path)}: {finished.size} of {total} repetitions are finished; the result has only those",
            stacklevel=2,
        )
    return _dataset(path, path, root, finished)


def info(path: str | Path) -> StoreInfo:
    """What a store holds, without reading its results.

    Raises
    ------
    StoreError
        If there is no result at that path, or it is damaged.
    """
    path = Path(path)
    root = _Root.of(path, path)
    names = {"stiction": "stiction_version", "schema": "stiction_schema", "numpy": "numpy_version"}
    size = 0
    for folder, _, files in os.walk(path):
        for file in files:
            with suppress(FileNotFoundError):  # a writer may be at work
                size += os.lstat(Path(folder, file)).st_blocks * 512
    return StoreInfo(
        root.study,
        root.blocks(path, path).finished(root.study.ensemble.repetitions).size,
        size,
        {name: printable(root.attributes.get(attribute, "unknown")) for name, attribute in names.items()},
    )


@dataclass(frozen=True)
class _Root:
    """What the root of a store says."""

    attributes: dict[str, Any]
    study: Study
    version: str

    @classmethod
    def of(cls, path: Path, shown: Path) -> _Root:
        """Of a store that messages call by the name it was given."""
        try:
            said = metadata(path / METADATA)
        except (FileNotFoundError, NotADirectoryError):
            raise StoreError(f"{named(shown)}: is not a result of stiction: there is no {METADATA} in it") from None
        except OSError as error:
            raise StoreError(f"{named(shown)}: cannot be read: {reason(error)}") from None
        except DecodingError as error:
            raise StoreError(
                f"{named(shown)}: is not a result of stiction, or is damaged: {METADATA}: {error}"
            ) from None
        attributes = said.get("attributes")
        if not isinstance(attributes, dict) or type(attributes.get("stiction_schema")) is not int:
            raise StoreError(
                f"{named(shown)}: is not a result of stiction, or is damaged: {METADATA} does not say what it is"
            )
        schema, version = attributes["stiction_schema"], printable(attributes.get("stiction_version"))
        if schema > SCHEMA:
            raise StoreError(
                f"{named(shown)}: has schema {printable(schema)}, written by stiction {version}; "
                f"this is stiction {__version__}, which knows schemas up to {SCHEMA}"
            )
        if attributes.get("checksum") != checksum(attributes):
            raise StoreError(f"{named(shown)}: is damaged: {METADATA} is not what was written")
        try:
            root = cls(attributes, study_of_attributes(attributes), str(attributes.get("stiction_version")))
        except StudyError as error:
            raise StoreError(f"{named(shown)}: its study, of stiction {version}, cannot be read: {error}") from None
        try:
            _check_kinds(path, shown)
        except OSError as error:
            raise StoreError(f"{named(shown)}: cannot be read: {reason(error)}") from None
        if not 1 <= root.block <= _MOST_IN_BLOCK:
            raise StoreError(f"{named(shown)}: is damaged: {METADATA} does not say how its chunks are")
        return root

    @property
    def block(self) -> int:
        """Repetitions in a chunk; 0 if that is not said."""
        said = 1 if self.attributes["stiction_schema"] == 1 else self.attributes.get(BLOCK)
        return said if type(said) is int else 0

    def blocks(self, path: Path, shown: Path) -> Blocks:
        """What stands in a store of this root."""
        return Blocks(path, shown, self.block)


_MOST_IN_BLOCK = 2**20


def _folders() -> list[str]:
    """Directories that a store may have."""
    return [*NAMES, COMPLETE]


def _check_kinds(path: Path, shown: Path) -> None:
    """That nothing which is read or written by its name leads out of the store."""
    for folder in _folders():
        for name, kind in ((folder, Path.is_dir), (f"{folder}/{METADATA}", Path.is_file)):
            file = path / name
            if os.path.lexists(file) and (file.is_symlink() or not kind(file)):
                raise StoreError(
                    f"{named(shown)}: is damaged: {name} is a link, or not a "
                    f"{'directory' if kind is Path.is_dir else 'regular file'}"
                )


def _check_metadata(path: Path, shown: Path, root: _Root) -> None:
    for name, expected in layout(root.study.with_changes({"ensemble.repetitions": 1}), root.block).items():
        if not name.endswith(f"/{METADATA}"):
            continue
        try:
            stored = metadata(path / name)
        except (OSError, DecodingError):
            stored = {}
        wanted = json.loads(expected)
        if any(stored.get(key) != wanted[key] for key in _CHECKED):
            raise StoreError(f"{named(shown)}: is damaged: {name}; running its study on it again writes that anew")


def _dataset(path: Path, shown: Path, root: _Root, repetitions: NDArray[np.intp]) -> xarray.Dataset:
    """The dataset of some repetitions, all of them finished."""
    from stiction.studies.lazy import stored_dataset

    coordinates = {
        name: (array, values if name in ("repetition", "sliding") else _coordinate(path, name, values))
        for name, (array, values) in coordinates_of(root.study, repetitions).items()
    }
    return stored_dataset(root.study, root.version, root.blocks(path, shown), coordinates, repetitions)


def _coordinate(path: Path, name: str, expected: NDArray[Any]) -> NDArray[Any]:
    """As written, which another kind of machine may not repeat to the last digit; as expected if that is damaged."""
    try:
        return decoded(path / name / "c.0", expected.dtype, expected.shape)
    except (OSError, DecodingError):
        return expected


# ---- Writing --------------------------------------------------------------------------------------------------------


class Store:
    """A store that is open for writing, by nobody else or by nobody else in the same part.

    Attributes
    ----------
    finished : (n,) ndarray of int
        Repetitions that were stored when it was opened, in order.
    block : int
        Repetitions in a chunk.
    writing : Writing
        What a worker needs to store repetitions by itself.
    """

    def __init__(self, path: Path, shown: Path, root: _Root, finished: NDArray[np.intp], writer: str) -> None:
        self.finished = finished
        self.block = root.block
        self.writing = Writing(root.blocks(path, shown), root_checksum(path) or 0, writer)
        self._path = path
        self._shown = shown
        self._root = root

    def save(self, repetitions: Sequence[int], sums: Mapping[str, NDArray[Any]]) -> None:
        """`Writing.save`, by whoever opened the store; also a StoreError if somebody removed the lock of that."""
        if not self.writing.save(repetitions, sums):
            raise StoreError(
                f"{named(self._shown)}: somebody removed {self.writing.writer}, by which its writer is known"
            )

    def dataset(self, repetitions: NDArray[np.intp]) -> xarray.Dataset:
        """The result of some repetitions, all of them finished."""
        return _dataset(self._path, self._shown, self._root, repetitions)

    @contextmanager
    def refusals(self) -> Iterator[None]:
        """A StoreError in place of a `NotWrittenError`, that says how many repetitions are finished."""
        try:
            yield
        except NotWrittenError as error:
            self.writing.check_is_there()
            total = self._root.study.ensemble.repetitions
            finished = self.writing.blocks.finished(total).size
            raise StoreError(
                f"{named(self._shown)}: cannot be written: {error}\n{finished} of {total} repetitions are "
                "finished and kept; running the study on it again continues from there"
            ) from None


@contextmanager
def opened(path: str | Path, study: Study, part: tuple[int, int] | None = None) -> Iterator[Store]:
    """Open the store of a study for writing: a new one, or one that holds some or all of its repetitions.

    One that holds all of them need not be writeable. Parts, such as (3, 16), share a store with each other.

    Raises
    ------
    StoreError
        If it cannot be written; if somebody else writes it; if it is no store, or a damaged one; if it holds something
        of another study; or if it lacks repetitions and was begun by another version, whose bits may differ.
    """
    shown = Path(path)
    with _written(shown):
        real = shown.resolve()
        real.parent.mkdir(parents=True, exist_ok=True)
    with ExitStack() as locks:
        with _written(shown):
            store = _whole(real, shown, study, locks) if part is None else _shared(real, shown, study, part, locks)
        yield store
        store.writing.check_is_there()


def _whole(path: Path, shown: Path, study: Study, locks: ExitStack) -> Store:
    """A store that nobody else writes."""
    try:
        _enter(locks, locked(path.with_name(f"{path.name}.lock")), shown)
    except OSError:
        store = _to_be_read(path, shown, study)
        if store is None:
            raise
        return store
    root, finished = _laid_out(path, shown, study, locks)
    return _announced(path, shown, root, finished, locks)


def _shared(path: Path, shown: Path, study: Study, part: tuple[int, int], locks: ExitStack) -> Store:
    """A store that others share, laid out for the study by the first of them that comes."""
    deadline = time.monotonic() + PATIENCE
    lock = path.with_name(f"{path.name}.lock")
    while True:
        try:
            with ExitStack() as own:
                _enter(own, locked(lock, shared=True), shown)
                if path.is_dir() and not path.is_symlink():
                    _enter(own, locked_directory(path, shared=True), shown)
                    root = _Root.of(path, shown)
                    if _is_laid_out(path, shown, root, study):
                        _enter(own, locked(path / COMPLETE / f"part-{part[0]}-of-{part[1]}.lock"), shown, part)
                        finished = root.blocks(path, shown).finished(study.ensemble.repetitions)
                        locks.push(own.pop_all())
                        return _announced(path, shown, root, finished, locks)
            with ExitStack() as alone:
                _enter(alone, locked(lock), shown)
                _laid_out(path, shown, study, alone)
        except BusyError:
            if time.monotonic() > deadline:
                raise
            time.sleep(random.uniform(0.02, 0.2))


def _is_laid_out(path: Path, shown: Path, root: _Root, study: Study) -> bool:
    """Whether a store is the very study's, with nothing to be changed; a StoreError if it cannot be."""
    _check_study(shown, root.study, study)
    _check_same_bits(path, shown, root, study)
    return all(_holds(path / name, wanted) for name, wanted in layout(study, root.block, root.attributes).items())


def _announced(path: Path, shown: Path, root: _Root, finished: NDArray[np.intp], locks: ExitStack) -> Store:
    """A store with a lock in it that workers know this process by."""
    writer = f"writer-{secrets.token_hex(8)}.lock"
    store = Store(path, shown, root, finished, writer)
    locks.callback(store.writing.wait_for_others)  # after which nobody writes for it, and then the store is let go
    locks.enter_context(locked(path / COMPLETE / writer))
    return store


def _enter(
    locks: ExitStack, lock: AbstractContextManager[None], shown: Path, part: tuple[int, int] | None = None
) -> None:
    try:
        locks.enter_context(lock)
    except BlockingIOError:
        if part is not None:
            raise StoreError(f"{named(shown)}: somebody else is computing part {part[0]}/{part[1]} of it") from None
        raise BusyError(f"{named(shown)}: somebody else is writing it") from None


@contextmanager
def _written(shown: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, RuntimeError) as error:  # RuntimeError: a symbolic link to itself
        raise StoreError(f"{named(shown)}: cannot be written: {getattr(error, 'strerror', None) or error}") from None


def _to_be_read(path: Path, shown: Path, study: Study) -> Store | None:
    """A store that nothing is to be written to; None if something is."""
    if not path.is_dir():
        return None
    root = _Root.of(path, shown)
    finished = root.blocks(path, shown).finished(root.study.ensemble.repetitions)
    if finished.size < study.ensemble.repetitions:
        return None
    _check_metadata(path, shown, root)
    return Store(path, shown, _asked(shown, root, finished, study), finished, "")


def _laid_out(path: Path, shown: Path, study: Study, locks: ExitStack) -> tuple[_Root, NDArray[np.intp]]:
    """Begin a store, or bring one to the layout of a study that it holds; its root, and what is finished."""
    partial = path.with_name(f"{path.name}{PARTIAL}")
    removed = []  # nothing is, before all that may be refused has been looked at
    if os.path.lexists(path):
        if path.is_dir():
            _enter(locks, locked_directory(path), shown)
        root = _Root.of(path, shown)
        finished = root.blocks(path, shown).finished(root.study.ensemble.repetitions)
        if finished.size:
            asked = _asked(shown, root, finished, study)
            if finished.size < study.ensemble.repetitions:
                _check_same_bits(path, shown, root, study)
            _lay_out_again(path, layout(study, root.block, root.attributes))
            return asked, finished
        _files_of(path, shown)  # whatever it was to be: there is nothing in it
        removed.append(path)
    files = layout(study, block_of(study))
    if os.path.lexists(partial):
        _files_of(partial, partial)
        _enter(locks, locked_directory(partial), shown)
        removed.append(partial)
    for directory in reversed(removed):
        if directory == path:
            path.rename(partial)
        for each in _files_of(partial, shown):
            each.rmdir() if each.is_dir() else each.unlink()
    _begin(path, partial, files, shown, locks)
    return _Root.of(path, shown), np.empty(0, np.intp)


def _files_of(store: Path, shown: Path) -> list[Path]:
    """Everything in a store without results, and last itself.

    Raises
    ------
    StoreError
        If it holds anything that was not written here.
    """
    found = []

    def foreign(file: Path) -> StoreError:
        return StoreError(
            f"{named(shown)}: holds no finished repetition, but {printable(file.relative_to(store))}, which is not "
            "of stiction; choose another place, or remove it"
        )

    if store.is_symlink() or not store.is_dir():
        raise StoreError(f"{named(shown)}: is in the way; choose another place, or remove it")
    folders = _folders()
    for entry in store.iterdir():
        if entry.is_symlink():
            raise foreign(entry)
        if entry.is_dir() and entry.name in folders:
            for file in entry.iterdir():
                if file.is_symlink() or not file.is_file() or not is_known(file.name):
                    raise foreign(file)
                found.append(file)
        elif not (entry.is_file() and (entry.name == METADATA or is_left_behind(entry.name))):
            raise foreign(entry)
        found.append(entry)
    return [*found, store]


def _begin(path: Path, partial: Path, layout: Mapping[str, bytes], shown: Path, locks: ExitStack) -> None:
    """A store without any repetition, which appears at its path when it is whole."""
    partial.mkdir()
    try:
        _enter(locks, locked_directory(partial), shown)
        for name, wanted in layout.items():
            (partial / name).parent.mkdir(exist_ok=True)
            (partial / name).write_bytes(wanted)
        partial.rename(path)
    except OSError:
        with suppress(OSError):
            for each in _files_of(partial, shown):
                each.rmdir() if each.is_dir() else each.unlink()
        raise


def _asked(shown: Path, root: _Root, finished: NDArray[np.intp], study: Study) -> _Root:
    """The root as it will be, of a study that is asked for; a StoreError if the store does not hold that."""
    _check_study(shown, root.study, study)
    total = study.ensemble.repetitions
    if finished[-1] >= total:
        raise StoreError(
            f"{named(shown)}: repetition {finished[-1]} is finished, and ensemble.repetitions = {total} would drop it; "
            f"ask for at least {finished[-1] + 1}, or choose another place"
        )
    return _Root(root.attributes | {"study": study.to_toml()}, study, root.version)


def _lay_out_again(path: Path, layout: Mapping[str, bytes]) -> None:
    """Bring a store to its layout, in the layout's order, and remove what a killed writer left half-written."""
    for folder in (path, *(path / each for each in _folders())):
        for file in folder.iterdir() if folder.is_dir() else ():
            if not file.is_symlink() and file.is_file():
                if is_lock(file.name):
                    with suppress(BlockingIOError), locked(file):
                        pass  # and removed, if nobody holds it: a worker may, whose command was killed
                elif is_left_behind(file.name):
                    file.unlink()
    for name, wanted in layout.items():
        file = path / name
        if not _holds(file, wanted):
            file.parent.mkdir(exist_ok=True)
            replace(file, wanted)


def _holds(file: Path, wanted: bytes) -> bool:
    try:
        return content(file, len(wanted), link=False) == wanted
    except (FileNotFoundError, NotReadableError):
        return False


def _check_study(shown: Path, stored: Study, asked: Study) -> None:
    # What friction and figures are asked for is applied to the sums afterwards.
    differ = [
        each
        for each in differences(stored, asked)
        if each[0].startswith(("surfaces.", "contact.")) or each[0] == "ensemble.seed"
    ]
    if differ:
        lines = [f"{key} = {_short(there)} there, {_short(here)} here" for key, there, here in differ[:4]]
        if len(differ) > 4:
            lines.append(f"... and {len(differ) - 4} more")
        raise StoreError(
            "\n".join([f"{named(shown)}: holds another study; choose another place, or remove it", *lines])
        )


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."


def _check_same_bits(path: Path, shown: Path, root: _Root, study: Study) -> None:
    """Repetitions that are still to come must be those that an undisturbed run would have computed."""
    if root.version != __version__:
        version = printable(root.version)
        raise StoreError(
            f"{named(shown)}: was begun by stiction {version} and this is {__version__}, whose results may differ; "
            f"finish it with stiction {version}, or choose another place"
        )
    for name, (_, here) in coordinates_of(study, []).items():
        if name in ("repetition", "sliding"):
            continue
        if not np.array_equal(here, _coordinate(path, name, here)):
            raise StoreError(
                f"{named(shown)}: was begun on a machine or with a NumPy whose {name} differs in the last digits; "
                "finish it there, or choose another place"
            )
