"""Results on disk: a Zarr store that grows by a repetition at a time and may be killed at any moment.

A repetition is a chunk of each variable, and a flag in `complete` that is written last; a file appears under its name
when it is whole, by a rename. Only what carries its flag counts, and it is never written again. All metadata follow
from the study, which stands in the root and is written last when repetitions are added: what was interrupted is put
right by writing the metadata again.
"""

from __future__ import annotations

import json
import os
import re
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray

from stiction._core import __version__
from stiction._files import NotReadableError, content, reason, replace
from stiction._text import named, printable
from stiction.studies.dataset import NAMES, empty_dataset
from stiction.studies.layout import (
    COMPLETE,
    METADATA,
    PARTIAL,
    SCHEMA,
    DecodingError,
    checksum,
    chunk,
    decoded,
    encoded,
    is_known,
    is_left_behind,
    layout,
    metadata,
)
from stiction.studies.lock import locked, locked_directory
from stiction.studies.study import Study, differences, study_of
from stiction.studies.study_text import StudyError

_CHECKED = ("data_type", "chunk_grid", "chunk_key_encoding", "fill_value", "dimension_names", "attributes")
"""Of an array's metadata; codecs may be spelt differently by other versions of Zarr, and the shape may have grown."""


class StoreError(ValueError):
    """A store that cannot be written or read."""


@dataclass(frozen=True)
class StoreInfo:
    """What a store holds."""

    study: Study
    finished: int  # repetitions, of study.ensemble.repetitions
    size: int  # bytes on disk
    versions: dict[str, str]  # of stiction, the schema, NumPy and Zarr when it was begun


# ---- Reading --------------------------------------------------------------------------------------------------------


def read(path: str | Path) -> xarray.Dataset:
    """Read a result from its store, into memory.

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
    _check_metadata(path, path, root.study)
    finished = _finished(path, path, root.study)
    total = root.study.ensemble.repetitions
    if not finished:
        raise StoreError(f"{named(path)}: none of its {total} repetitions is finished yet")
    if len(finished) < total:
        warnings.warn(
            f"{named(path)}: {len(finished)} of {total} repetitions are finished; the result has only those",
            stacklevel=2,
        )
    return _loaded(path, path, root, finished, finished)


def info(path: str | Path) -> StoreInfo:
    """What a store holds, without reading its results.

    Raises
    ------
    StoreError
        If there is no result at that path, or it is damaged.
    """
    path = Path(path)
    root = _Root.of(path, path)
    names = {
        "stiction": "stiction_version", "schema": "stiction_schema", "numpy": "numpy_version", "zarr": "zarr_version",
    }  # fmt: skip
    size = 0
    for folder, _, files in os.walk(path):
        for file in files:
            with suppress(FileNotFoundError):  # a writer may be at work
                size += os.lstat(Path(folder, file)).st_blocks * 512
    return StoreInfo(
        root.study,
        len(_finished(path, path, root.study)),
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
            root = cls(attributes, study_of(xarray.Dataset(attrs=attributes)), str(attributes.get("stiction_version")))
        except StudyError as error:
            raise StoreError(f"{named(shown)}: its study, of stiction {version}, cannot be read: {error}") from None
        try:
            _check_kinds(path, shown)
        except OSError as error:
            raise StoreError(f"{named(shown)}: cannot be read: {reason(error)}") from None
        return root


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


def _check_metadata(path: Path, shown: Path, study: Study) -> None:
    for name, expected in layout(empty_dataset(study, [])).items():
        if not name.endswith(f"/{METADATA}"):
            continue
        try:
            stored = metadata(path / name)
        except (OSError, DecodingError):
            stored = {}
        wanted = json.loads(expected)
        if any(stored.get(key) != wanted[key] for key in _CHECKED):
            raise StoreError(f"{named(shown)}: is damaged: {name}; running its study on it again writes that anew")


def _finished(path: Path, shown: Path, study: Study) -> list[int]:
    """Repetitions that carry their flag, in order."""
    try:
        files = os.listdir(path / COMPLETE)
    except OSError as error:
        raise StoreError(f"{named(shown)}: is damaged: {COMPLETE}: {error.strerror or error}") from None
    numbers = sorted(int(match[1]) for file in files if (match := re.fullmatch(r"c\.(0|[1-9][0-9]{0,17})", file)))
    return [
        repetition
        for repetition in numbers
        if repetition < study.ensemble.repetitions and _flag(path, shown, repetition)
    ]


def _flag(path: Path, shown: Path, repetition: int) -> bool:
    name = f"{COMPLETE}/c.{repetition}"
    try:
        return bool(decoded(path / name, np.dtype(np.bool_), (1,))[0])
    except (OSError, DecodingError) as error:
        raise _damage(shown, name, repetition, error) from None


def _loaded(
    path: Path, shown: Path, root: _Root, finished: Collection[int], repetitions: Sequence[int]
) -> xarray.Dataset:
    """The dataset of some repetitions, zeros where they are not finished."""
    dataset = empty_dataset(root.study, repetitions)
    dataset.attrs["stiction_version"] = root.version
    for name, coordinate in dataset.coords.items():
        if name not in ("repetition", "sliding"):
            stored = _coordinate(path, str(name), coordinate.variable)
            dataset[name] = coordinate.copy(data=stored)
    arrays = {str(name): dataset[name].values for name in dataset.data_vars}
    for index, repetition in enumerate(repetitions):
        if repetition in finished:
            for name, array in arrays.items():
                file = f"{name}/{chunk(repetition, array.ndim)}"
                try:
                    array[:, :, index] = decoded(path / file, array.dtype, array[:, :, index].shape)
                except (OSError, DecodingError) as error:
                    raise _damage(shown, file, repetition, error) from None
    return dataset


def _coordinate(path: Path, name: str, expected: xarray.Variable) -> NDArray[Any]:
    """As written, which another kind of machine may not repeat to the last digit; as expected if that is damaged."""
    try:
        return decoded(path / name / "c.0", expected.dtype, expected.shape)
    except (OSError, DecodingError):
        return expected.values


def _damage(shown: Path, file: str, repetition: int, error: Exception) -> StoreError:
    why = reason(error) if isinstance(error, OSError) else error
    flag = shown / COMPLETE / f"c.{repetition}"
    return StoreError(
        f"{named(shown)}: is damaged: {file}: {why}\n"
        f"to have repetition {repetition} computed again, remove {named(flag)} and run its study on it again"
    )


# ---- Writing --------------------------------------------------------------------------------------------------------


class Store:
    """A store that is open for writing, by nobody else.

    Attributes
    ----------
    result : xarray.Dataset
        Every repetition of the study: as they are stored, or zeros.
    finished : frozenset of int
        Repetitions that were stored when it was opened.
    """

    def __init__(self, path: Path, shown: Path, result: xarray.Dataset, finished: Collection[int]) -> None:
        self.result = result
        self.finished = frozenset(finished)
        self._path = path
        self._shown = shown
        self._saved = len(self.finished)
        self._identity = path.stat()

    def save(self, repetition: int, sums: Mapping[str, NDArray[Any]]) -> None:
        """Store a repetition for good: each variable of the result, without the dimension of repetitions.

        Raises
        ------
        StoreError
            If it cannot be written; what was finished before stays so.
        """
        self.check_is_there()
        try:
            for name, values in sums.items():
                file = self._path / name / chunk(repetition, values.ndim + 1)
                replace(file, encoded(file, values))
            flag = self._path / COMPLETE / f"c.{repetition}"
            replace(flag, encoded(flag, np.ones(1, np.bool_)))
        except OSError as error:
            self.check_is_there()
            raise StoreError(
                f"{named(self._shown)}: cannot be written: {reason(error)}\n{self._saved} of "
                f"{self.result.sizes['repetition']} repetitions are finished and kept; running the study on it again "
                "continues from there"
            ) from None
        self._saved += 1

    def check_is_there(self) -> None:
        """Raise a StoreError if somebody has removed the store, or put something else in its place."""
        try:
            if os.path.samestat(self._path.stat(), self._identity) and (self._path / METADATA).exists():
                return
        except OSError:
            pass
        raise StoreError(f"{named(self._shown)}: was removed or replaced while it was being written")


@contextmanager
def opened(path: str | Path, study: Study) -> Iterator[Store]:
    """Open the store of a study for writing: a new one, or one that holds some or all of its repetitions.

    One that holds all of them need not be writeable.

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
            try:
                _enter(locks, locked(real.with_name(f"{real.name}.lock")), shown)
            except OSError:
                store = _whole(real, shown, study)
                if store is None:
                    raise
            else:
                store = _opened(real, shown, study, locks)
        yield store
        store.check_is_there()


def _enter(locks: ExitStack, lock: AbstractContextManager[None], shown: Path) -> None:
    try:
        locks.enter_context(lock)
    except BlockingIOError:
        raise StoreError(f"{named(shown)}: somebody else is writing it") from None


@contextmanager
def _written(shown: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, RuntimeError) as error:  # RuntimeError: a symbolic link to itself
        raise StoreError(f"{named(shown)}: cannot be written: {getattr(error, 'strerror', None) or error}") from None


def _whole(path: Path, shown: Path, study: Study) -> Store | None:
    """A store that nothing is to be written to; None if something is."""
    if not path.is_dir():
        return None
    root = _Root.of(path, shown)
    finished = _finished(path, shown, root.study)
    if len(finished) < study.ensemble.repetitions:
        return None
    _check_metadata(path, shown, root.study)
    return Store(path, shown, _loaded_as(path, shown, root, finished, study), finished)


def _opened(path: Path, shown: Path, study: Study, locks: ExitStack) -> Store:
    partial = path.with_name(f"{path.name}{PARTIAL}")
    removed = []  # nothing is, before all that may be refused has been looked at
    if os.path.lexists(path):
        if path.is_dir():
            _enter(locks, locked_directory(path), shown)
        root = _Root.of(path, shown)
        finished = _finished(path, shown, root.study)
        if finished:
            return _continued(path, shown, root, finished, study)
        _files_of(path, shown)  # whatever it was to be: there is nothing in it
        removed.append(path)
    result = empty_dataset(study)
    files = layout(result)
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
    return Store(path, shown, result, ())


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


def _continued(path: Path, shown: Path, root: _Root, finished: list[int], study: Study) -> Store:
    result = _loaded_as(path, shown, root, finished, study)
    if len(finished) < study.ensemble.repetitions:
        _check_same_bits(shown, _Root(root.attributes, study, root.version), result)
    _lay_out_again(path, layout(result, root.attributes))
    return Store(path, shown, result, finished)


def _loaded_as(path: Path, shown: Path, root: _Root, finished: list[int], study: Study) -> xarray.Dataset:
    """Every repetition of a study from a store that holds some; a StoreError if that is not of the same study."""
    _check_study(shown, root.study, study)
    total = study.ensemble.repetitions
    if finished[-1] >= total:
        raise StoreError(
            f"{named(shown)}: repetition {finished[-1]} is finished, and ensemble.repetitions = {total} would drop it; "
            f"ask for at least {finished[-1] + 1}, or choose another place"
        )
    return _loaded(path, shown, _Root(root.attributes, study, root.version), frozenset(finished), range(total))


def _lay_out_again(path: Path, layout: Mapping[str, bytes]) -> None:
    """Bring a store to its layout, in the layout's order, and remove what a killed writer left half-written."""
    for folder in (path, *(path / each for each in _folders())):
        for file in folder.iterdir() if folder.is_dir() else ():
            if is_left_behind(file.name) and file.is_file() and not file.is_symlink():
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


def _check_same_bits(shown: Path, root: _Root, result: xarray.Dataset) -> None:
    """Repetitions that are still to come must be those that an undisturbed run would have computed."""
    if root.version != __version__:
        version = printable(root.version)
        raise StoreError(
            f"{named(shown)}: was begun by stiction {version} and this is {__version__}, whose results may differ; "
            f"finish it with stiction {version}, or choose another place"
        )
    here = empty_dataset(root.study).coords
    for name in here:
        if not np.array_equal(here[name].values, result[name].values):
            raise StoreError(
                f"{named(shown)}: was begun on a machine or with a NumPy whose {name} differs in the last digits; "
                "finish it there, or choose another place"
            )
