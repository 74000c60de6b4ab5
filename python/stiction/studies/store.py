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
import shutil
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray

from stiction._core import __version__
from stiction.mechanics.quantities import SUMS
from stiction.studies.dataset import empty_dataset
from stiction.studies.files import (
    COMPLETE,
    METADATA,
    PARTIAL,
    SCHEMA,
    DecodingError,
    checksum,
    chunk,
    decoded,
    encoded,
    layout,
    replace,
)
from stiction.studies.lock import locked
from stiction.studies.study import Study, StudyError, differences, study_of

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
    _check_metadata(path, root.study)
    finished = _finished(path, path, root.study)
    total = root.study.ensemble.repetitions
    if not finished:
        raise StoreError(f"{path}: none of its {total} repetitions is finished yet")
    if len(finished) < total:
        warnings.warn(
            f"{path}: {len(finished)} of {total} repetitions are finished; the result has only those", stacklevel=2
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
        {name: str(root.attributes.get(attribute, "unknown")) for name, attribute in names.items()},
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
            metadata = json.loads((path / METADATA).read_bytes())
        except (FileNotFoundError, NotADirectoryError):
            raise StoreError(f"{shown}: is not a result of stiction: there is no {METADATA} in it") from None
        except OSError as error:
            raise StoreError(f"{shown}: cannot be read: {error.strerror or error}") from None
        except (ValueError, RecursionError):
            raise StoreError(f"{shown}: is not a result of stiction, or is damaged: {METADATA}") from None
        attributes = metadata.get("attributes") if isinstance(metadata, dict) else None
        if not isinstance(attributes, dict) or "stiction_schema" not in attributes:
            raise StoreError(f"{shown}: is not a result of stiction, or is damaged: {METADATA} does not say what it is")
        schema, version = attributes["stiction_schema"], attributes.get("stiction_version")
        if isinstance(schema, int) and schema > SCHEMA:
            raise StoreError(
                f"{shown}: has schema {schema}, written by stiction {version}; "
                f"this is stiction {__version__}, which knows schemas up to {SCHEMA}"
            )
        if attributes.get("checksum") != checksum(attributes):
            raise StoreError(f"{shown}: is damaged: {METADATA} is not what was written")
        try:
            return cls(attributes, study_of(xarray.Dataset(attrs=attributes)), str(version))
        except StudyError as error:
            raise StoreError(f"{shown}: its study, of stiction {version}, cannot be read: {error}") from None


def _check_metadata(path: Path, study: Study) -> None:
    for name, expected in layout(empty_dataset(study, [])).items():
        if not name.endswith(f"/{METADATA}"):
            continue
        try:
            stored = json.loads((path / name).read_bytes())
        except (OSError, ValueError, RecursionError):
            stored = None
        wanted = json.loads(expected)
        if not isinstance(stored, dict) or any(stored.get(key) != wanted[key] for key in _CHECKED):
            raise StoreError(f"{path}: is damaged: {name}; running its study on it again writes that anew")


def _finished(path: Path, shown: Path, study: Study) -> list[int]:
    """Repetitions that carry their flag, in order."""
    try:
        files = os.listdir(path / COMPLETE)
    except OSError as error:
        raise StoreError(f"{shown}: is damaged: {COMPLETE}: {error.strerror or error}") from None
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
        if name != "repetition":
            stored = _coordinate(path, str(name), coordinate.variable)
            dataset[name] = coordinate.copy(data=stored)
    arrays = {name: dataset[name].values for name in SUMS}
    for index, repetition in enumerate(repetitions):
        if repetition in finished:
            for name, array in arrays.items():
                file = f"{name}/{chunk(repetition)}"
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
    reason = error.strerror if isinstance(error, OSError) else error
    return StoreError(
        f"{shown}: is damaged: {file}: {reason}\n"
        f"to have repetition {repetition} computed again, remove {shown / COMPLETE / f'c.{repetition}'} and run its "
        "study on it again"
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
        """Store a repetition for good: each variable of `SUMS` as an array (fractal dimension, amplitude, approach).

        Raises
        ------
        StoreError
            If it cannot be written; what was finished before stays so.
        """
        self.check_is_there()
        try:
            for name in SUMS:
                replace(self._path / name / chunk(repetition), encoded(sums[name]))
            replace(self._path / COMPLETE / f"c.{repetition}", encoded(np.ones(1, np.bool_)))
        except OSError as error:
            self.check_is_there()
            raise StoreError(
                f"{self._shown}: cannot be written: {error.strerror or error}\n{self._saved} of "
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
        raise StoreError(f"{self._shown}: was removed or replaced while it was being written")


@contextmanager
def opened(path: str | Path, study: Study) -> Iterator[Store]:
    """Open the store of a study for writing: a new one, or one that holds some or all of its repetitions.

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
    with _lock(real, shown):
        with _written(shown):
            store = _opened(real, shown, study)
        yield store
        store.check_is_there()


@contextmanager
def _lock(real: Path, shown: Path) -> Iterator[None]:
    lock = locked(real.with_name(f"{real.name}.lock"))
    with _written(shown):
        try:
            lock.__enter__()
        except BlockingIOError:
            raise StoreError(f"{shown}: somebody else is writing it") from None
    try:
        yield
    finally:
        lock.__exit__(None, None, None)


@contextmanager
def _written(shown: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, RuntimeError) as error:  # RuntimeError: a symbolic link to itself
        raise StoreError(f"{shown}: cannot be written: {getattr(error, 'strerror', None) or error}") from None


def _opened(path: Path, shown: Path, study: Study) -> Store:
    partial = path.with_name(f"{path.name}{PARTIAL}")
    if os.path.lexists(partial):
        shutil.rmtree(partial)
    if os.path.lexists(path):
        root = _Root.of(path, shown)
        finished = _finished(path, shown, root.study)
        if finished:
            return _continued(path, shown, root, finished, study)
        path.rename(partial)  # whatever it was to be: there is nothing in it
        shutil.rmtree(partial)
    result = empty_dataset(study)
    _begin(path, partial, result)
    return Store(path, shown, result, ())


def _begin(path: Path, partial: Path, dataset: xarray.Dataset) -> None:
    """A store without any repetition, which appears at its path when it is whole."""
    try:
        for name, content in layout(dataset).items():
            (partial / name).parent.mkdir(parents=True, exist_ok=True)
            (partial / name).write_bytes(content)
        partial.rename(path)
    except OSError:
        shutil.rmtree(partial, ignore_errors=True)
        raise


def _continued(path: Path, shown: Path, root: _Root, finished: list[int], study: Study) -> Store:
    _check_study(shown, root.study, study)
    total = study.ensemble.repetitions
    if finished[-1] >= total:
        raise StoreError(
            f"{shown}: repetition {finished[-1]} is finished, and ensemble.repetitions = {total} would drop it; "
            f"ask for at least {finished[-1] + 1}, or choose another place"
        )
    new = _Root(root.attributes, study, root.version)
    result = _loaded(path, shown, new, frozenset(finished), range(total))
    if len(finished) < total:
        _check_same_bits(shown, new, result)
    _lay_out_again(path, layout(result, root.attributes))
    return Store(path, shown, result, finished)


def _lay_out_again(path: Path, layout: Mapping[str, bytes]) -> None:
    """Bring a store to its layout, in the layout's order, and remove what a killed writer left half-written."""
    for folder in (path, *(each for each in path.iterdir() if each.is_dir())):
        for file in folder.glob(f"*{PARTIAL}"):
            file.unlink()
    for name, content in layout.items():
        file = path / name
        if not (file.exists() and file.read_bytes() == content):
            file.parent.mkdir(exist_ok=True)
            replace(file, content)


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
        raise StoreError("\n".join([f"{shown}: holds another study; choose another place, or remove it", *lines]))


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."


def _check_same_bits(shown: Path, root: _Root, result: xarray.Dataset) -> None:
    """Repetitions that are still to come must be those that an undisturbed run would have computed."""
    if root.version != __version__:
        raise StoreError(
            f"{shown}: was begun by stiction {root.version} and this is {__version__}, whose results may differ; "
            f"finish it with stiction {root.version}, or choose another place"
        )
    here = empty_dataset(root.study).coords
    for name in here:
        if not np.array_equal(here[name].values, result[name].values):
            raise StoreError(
                f"{shown}: was begun on a machine or with a NumPy whose {name} differs in the last digits; "
                "finish it there, or choose another place"
            )
