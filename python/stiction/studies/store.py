"""Results on disk: a folder with the study, and a file for each block of members, put there whole and never changed.

    DIR/study.toml                               what is computed
    DIR/blocks/0000008-0000015-1b2c3d4e.nc       members 8 to 15; the last word is the CRC-32 of the file's bytes

A block appears under its name when it is whole, so what is there is finished, and what is not there is to be computed.
The bits of a member depend on the study and its number alone, so two writers may do the same block: nothing is locked.
Files may overlap, for example where a study was extended; each member is then read from the first file that has it.
"""

from __future__ import annotations

import functools
import io
import os
import re
import threading
import warnings
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import stiction._files as _files
from stiction._core import __version__
from stiction._files import NotReadableError, describe_os_error, new_file, read_content, replaced_file
from stiction._text import printable, printable_path
from stiction.studies.layout import (
    OF_MEMBERS,
    TITLE,
    Arrays,
    bytes_of_member,
    coordinates_of,
    dataset_of,
    piece_of,
    variables_of,
)
from stiction.studies.measured_surfaces import About
from stiction.studies.members import about
from stiction.studies.study import (
    LONGEST_FILE,
    Difference,
    Study,
    computed_otherwise,
    differences,
    differences_text,
    study_from_text,
)

if TYPE_CHECKING:
    import h5py
    import xarray

STUDY = "study.toml"
BLOCKS = "blocks"
MARK = "# Written by stiction"  # beginning of a study that a command wrote into a folder
MOST_MEMORY = 2**31  # bytes of a result that is read into memory at once
MOST_BESIDE = 2**26  # bytes of a file that lies beside a result
_NAME = re.compile(r"([0-9]{7,18})-([0-9]{7,18})-([0-9a-f]{8})\.nc")
_ATTEMPTS = 3


class StoreError(ValueError):
    """A result that cannot be written or read."""


@dataclass(frozen=True)
class Block:
    """A file of some members, as its name says."""

    first: int
    last: int
    checksum: int

    @property
    def name(self) -> str:
        """Name of the file."""
        return f"{self.first:07d}-{self.last:07d}-{self.checksum:08x}.nc"


@dataclass(frozen=True)
class StoreInfo:
    """What a folder holds."""

    study: Study
    finished: int  # repetitions, of study.ensemble.repetitions
    size: int  # bytes on disk
    versions: dict[str, str]  # of stiction, when it was begun


@dataclass(frozen=True)
class Stored:
    """A result in its folder, of which blocks are read when they are asked for; one that is a single piece, once."""

    path: Path
    study: Study
    blocks: tuple[Block, ...]

    @cached_property
    def _used(self) -> list[tuple[Block, int, int]]:
        """Blocks, and which members are read from each, from the first to before the last."""
        used, covered = [], 0
        for block in sorted(self.blocks, key=lambda block: (block.first, -block.last, block.checksum)):
            first, last = max(block.first, covered), min(block.last + 1, self.study.ensemble.repetitions)
            if first < last:
                used.append((block, first, last))
                covered = last
        return used

    @property
    def count(self) -> int:
        """Number of members that are there."""
        return sum(last - first for _, first, last in self._used)

    @cached_property
    def finished(self) -> NDArray[np.intp]:
        """The members that are there, in order."""
        return np.concatenate([np.empty(0, np.intp), *(np.arange(first, last) for _, first, last in self._used)])

    @cached_property
    def version(self) -> str:
        """Version of stiction that began the result; that of this one, if nothing is finished yet."""
        return self.begun.version if self.blocks else __version__

    @cached_property
    def size(self) -> int:
        """Bytes of the files."""
        return sum((self.path / BLOCKS / block.name).lstat().st_size for block in self.blocks)

    @property
    def nbytes(self) -> int:
        """Bytes of the result in memory."""
        return self.count * bytes_of_member(self.study)

    def again(self) -> Stored:
        """The same folder with the blocks that it holds now."""
        return Stored(self.path, self.study, _listed(self.path))

    @cached_property
    def begun(self) -> Members:
        """The members of the first block, of whatever study they are."""
        return self._read(self._used[0][0] if self._used else self.blocks[0])

    def dataset(self) -> xarray.Dataset:
        """The whole result; a `StoreError` if it takes more than 2 GiB, is not begun, damaged or another study's."""
        total = self.study.ensemble.repetitions
        if not self.count:
            raise StoreError(f"{printable_path(self.path)}: none of its {total} repetitions is finished yet")
        if self.nbytes > MOST_MEMORY:
            raise StoreError(
                f"{printable_path(self.path)}: the result takes {self.nbytes / 2**30:.1f} GiB of memory, more than "
                f"{MOST_MEMORY / 2**30:.0f}; Result.pieces reads it piece by piece, and "
                f"xarray.open_mfdataset opens {printable_path(self.path / BLOCKS)}"
            )
        return self._piece.copy(deep=True) if self._step >= self.count else self._some(0, self.count)

    def pieces(self, names: Iterable[str] | None = None) -> Iterator[xarray.Dataset]:
        """Read the result piece by piece, in order, so that one piece is in memory at a time; see `Result.pieces`."""
        wanted, count = None if names is None else list(names), self.count
        for first in range(0, count, self._step):
            piece = self._piece if self._step >= count else self._some(first, min(first + self._step, count))
            yield piece.copy() if wanted is None else piece[wanted]

    @cached_property
    def _step(self) -> int:
        """Members of a piece."""
        return piece_of(bytes_of_member(self.study))

    @cached_property
    def _piece(self) -> xarray.Dataset:
        """The whole result, whose numbers must not be changed: every table and figure reads it again."""
        whole = self._some(0, self.count)
        for variable in whole.data_vars.values():
            variable.values.flags.writeable = False
        return whole

    def _some(self, first: int, last: int) -> xarray.Dataset:
        """The finished members from one to before another, counted among the finished ones."""
        version, numbers = self.version, self.finished[first:last]  # of a block that holds what it says
        axis = len(self.study.surfaces.cells())
        arrays: Arrays = {
            name: np.empty(each.shape, each.dtype) for name, each in variables_of(self.study, numbers).items()
        }
        if self.study.is_measured:
            arrays |= {name: np.empty(numbers.size, dtype) for name, dtype in OF_MEMBERS.items()}
        begin = done = 0
        of_bodies = None
        for block, one, other in self._used:
            end = begin + other - one
            if first < end and begin < last:
                low, high = max(first, begin) - begin + one, min(last, end) - begin + one
                members = self.begun if block is self._used[0][0] else self._read(block)
                if differ := computed_otherwise(members.study, self.study):
                    raise _damaged(
                        self.path, block, f"is of another study than {STUDY}: {differences_text(differ[:1])}"
                    )
                of_bodies = of_bodies or members.about
                for name, values in arrays.items():
                    lead = (slice(None),) * (0 if name in OF_MEMBERS else axis)
                    there = slice(low - block.first, high - block.first)
                    values[(*lead, slice(done, done + high - low))] = members.arrays[name][(*lead, there)]
                done += high - low
            begin = end
        return dataset_of(self.study, numbers, arrays, of_bodies).assign_attrs(stiction_version=version)

    def _read(self, block: Block) -> Members:
        """A block whose checksum is that of its name: it is ours, and taken as it is."""
        try:
            written = read_content(self.path / BLOCKS / block.name, MOST_MEMORY)
            if zlib.crc32(written) != block.checksum:
                raise DamageError("is not what was written")
            members = decoded(written)
            if not np.array_equal(members.numbers, np.arange(block.first, block.last + 1)):
                raise DamageError("has other repetitions than its name says")
        except OSError as error:
            raise _damaged(self.path, block, f"cannot be read: {describe_os_error(error)}") from None
        except (NotReadableError, DamageError) as error:
            raise _damaged(self.path, block, str(error)) from None
        return members


def _damaged(path: Path, block: Block, why: str) -> StoreError:
    return StoreError(
        f"{printable_path(path / BLOCKS / block.name)}: {why}; to have repetitions {block.first} to {block.last} "
        "computed again, remove that file and run the study again"
    )


# ---- Reading --------------------------------------------------------------------------------------------------------


def read(path: str | Path) -> xarray.Dataset:
    """Read a result: from its folder, or from a netCDF file that `export` wrote.

    Of a study that is not finished, the dataset has the finished repetitions only, and a warning says so.

    Returns
    -------
    xarray.Dataset
        The dataset of the result that `run` returned.

    Raises
    ------
    StoreError
        If there is no result at that path, or none of its repetitions is finished, or it is damaged or larger than
        2 GiB.
    """
    path = Path(path)
    if path.is_file():
        try:
            members = decoded(read_content(path, MOST_MEMORY))
        except (OSError, NotReadableError, DamageError) as error:
            raise StoreError(
                f"{printable_path(path)}: {describe_os_error(error) if isinstance(error, OSError) else error}"
            ) from None
        exported = dataset_of(members.study, members.numbers, members.arrays, members.about)
        return exported.assign_attrs(stiction_version=members.version)
    stored = open_stored(path)
    result = stored.dataset()
    total = stored.study.ensemble.repetitions
    if stored.count < total:
        warnings.warn(
            f"{printable_path(path)}: {stored.count} of {total} repetitions are finished; the result has only those",
            stacklevel=2,
        )
    return result


def read_beside(path: Path, names: Iterable[str]) -> xarray.Dataset | None:
    """The small dataset with these variables beside a result; None without one, a `StoreError` if it is damaged."""
    import xarray

    try:
        written = read_content(path, MOST_BESIDE)
        options: dict[str, Any] = {"engine": "h5netcdf", "decode_cf": False, "phony_dims": "sort"}
        with _opened(written) as file:
            for name in names:
                _values(file, name)
            with xarray.open_dataset(io.BytesIO(written), **options) as dataset:
                dataset.load()
    except FileNotFoundError:
        return None
    except (OSError, NotReadableError, DamageError) as error:
        why = describe_os_error(error) if isinstance(error, OSError) else error
        raise StoreError(
            f"{printable_path(path)}: {why}; to have it made again, remove it and run the study again"
        ) from None
    attributes = {name: np.asarray(value) for name, value in dataset.attrs.items()}
    dataset.attrs = {name: each.item() if each.size == 1 else each for name, each in attributes.items()}
    return dataset


def open_stored(path: str | Path) -> Stored:
    """Open the result in a folder, without reading its blocks; a `StoreError` if there is none."""
    path = Path(path)
    if not path.exists():
        raise StoreError(f"{printable_path(path)}: no such directory")
    blocks = _listed(path)
    try:
        study = _study(path)
    except FileNotFoundError:
        raise StoreError(f"{printable_path(path)}: is not a result: there is no {STUDY} in it") from None
    except OSError as error:
        raise StoreError(f"{printable_path(path)}: {STUDY} cannot be read: {describe_os_error(error)}") from None
    return Stored(path, study, blocks)


def info(path: str | Path) -> StoreInfo:
    """What a folder holds, without reading more of it than one block.

    Raises
    ------
    StoreError
        If there is no result at that path, or it is damaged.
    """
    stored = open_stored(path)
    return StoreInfo(stored.study, stored.count, stored.size, {"stiction": printable(stored.version)})


def _listed(path: Path) -> tuple[Block, ...]:
    try:
        names = sorted(os.listdir(path / BLOCKS))
    except (FileNotFoundError, NotADirectoryError):
        return ()
    except OSError as error:
        raise StoreError(f"{printable_path(path / BLOCKS)}: cannot be read: {describe_os_error(error)}") from None
    found = (_NAME.fullmatch(name) for name in names)
    blocks = (Block(int(match[1]), int(match[2]), int(match[3], 16)) for match in found if match)
    return tuple(block for block in blocks if block.first <= block.last)


def _study(path: Path) -> Study:
    try:
        text = read_content(path / STUDY, LONGEST_FILE).decode()
    except (NotReadableError, UnicodeDecodeError) as error:
        raise StoreError(f"{printable_path(path / STUDY)}: is no study: {printable(error)}") from None
    return study_from_text(text, str(path / STUDY))


# ---- Writing --------------------------------------------------------------------------------------------------------


def begin(path: str | Path, study: Study) -> Stored:
    """Begin a result in a folder, or open one of the same study to be continued; what was half written is removed.

    Raises a `StoreError` if it cannot be written, holds another study, or would be continued by another version.
    """
    path = Path(path)
    if path.is_file():
        raise StoreError(f"{printable_path(path)}: is a file; say in which directory the results shall go")
    stored = Stored(path, study, _listed(path))
    if stored.blocks:
        _check(stored)
    if os.path.lexists(path / STUDY) and not _says(path, study):
        _check_replaceable(path, study)
    try:
        (path / BLOCKS).mkdir(parents=True, exist_ok=True)
        for folder in (path, path / BLOCKS):
            _files.remove_stale_partials(folder)
        if not _says(path, study):
            _files.write_atomically(path / STUDY, f"{MARK} {__version__}.\n\n{study.to_toml()}".encode())
    except (OSError, RuntimeError) as error:  # RuntimeError: a symbolic link to itself
        if stored.count < study.ensemble.repetitions:
            why = describe_os_error(error) if isinstance(error, OSError) else error
            raise StoreError(f"{printable_path(path)}: cannot be written: {why}") from None
    return stored


def _check(stored: Stored) -> None:
    """That a folder with blocks can be continued as the study says."""
    path, begun, total = stored.path, stored.begun, stored.study.ensemble.repetitions
    if differ := computed_otherwise(begun.study, stored.study):
        raise OtherStudyError(path, begun.study, differ)
    last = max(block.last for block in stored.blocks)
    if last >= total:
        raise StoreError(
            f"{printable_path(path)}: repetition {last} is finished, and ensemble.repetitions = {total} would drop it; "
            f"ask for at least {last + 1}, or choose another place"
        )
    if stored.count == total:
        return
    if begun.version != __version__:
        version = printable(begun.version)
        raise StoreError(
            f"{printable_path(path)}: was begun by stiction {version} and this is {__version__}, whose results may "
            f"differ; finish it with stiction {version}, or choose another place"
        )
    if not begun.is_exact:
        raise StoreError(
            f"{printable_path(path)}: was begun on a machine or with a NumPy whose steps differ in the last digits; "
            "finish it there, or choose another place"
        )


def _check_replaceable(path: Path, study: Study) -> None:
    """Raise a `StoreError` if the study in a folder was not written by a command, so that it is not replaced."""
    try:
        if read_content(path / STUDY, LONGEST_FILE).startswith(MARK.encode()):
            return
        stored = _study(path)
    except OSError as error:
        raise StoreError(f"{printable_path(path / STUDY)}: cannot be read: {describe_os_error(error)}") from None
    except NotReadableError as error:
        raise StoreError(f"{printable_path(path / STUDY)}: {error}; choose another place, or remove it") from None
    raise OtherStudyError(path, stored, differences(stored, study))


def _says(path: Path, study: Study) -> bool:
    """Whether the folder has this very study."""
    try:
        return _study(path) == study
    except (OSError, ValueError):
        return False


class OtherStudyError(StoreError):
    """A folder has the result of another study than the one that was to be computed."""

    def __init__(self, path: Path, stored: Study, differ: list[Difference], advice: str = "") -> None:
        advice = advice or "give another directory, or replace the stored result"
        super().__init__(f"{printable_path(path)}: holds another study; {advice}\n{differences_text(differ)}")
        self.path, self.stored, self.differ = path, stored, differ

    def with_advice(self, advice: str) -> OtherStudyError:
        """Return the same error with another remedy."""
        return OtherStudyError(self.path, self.stored, self.differ, advice)


def put(path: Path, first: int, written: bytes, count: int) -> None:
    """Put the file of so many members, from the first on, into a folder; a `StoreError` if it cannot be written."""
    block = Block(first, first + count - 1, zlib.crc32(written))
    for attempt in range(1, _ATTEMPTS + 1):
        try:
            _files.write_atomically(path / BLOCKS / block.name, written)
            return
        except FileNotFoundError:  # somebody on another machine took the half-written file for one that was left
            if attempt == _ATTEMPTS or not (path / BLOCKS).is_dir():
                raise StoreError(
                    f"{printable_path(path)}: was removed or replaced while it was being written"
                ) from None
        except OSError as error:
            raise StoreError(f"{printable_path(path)}: cannot be written: {describe_os_error(error)}") from None


# ---- The file of a block ---------------------------------------------------------------------------------------------

# A file whose checksum holds is as it was written, and trusted: compared are the study that it is of, and its shapes.

OF_EVERY_RESULT = ("title", "study", "stiction_version", "_NCProperties")  # attributes; others are of bodies

SEAL = b"stiction crc32 "
"""End of an exported file, before the checksum of all that precedes: HDF5 may run for ever in a damaged file. HDF5
reads no further than its own end, and whatever else writes into the file takes the seal off."""

_making = threading.Lock()  # so that threads whose first blocks end at once make one template, not one each


class DamageError(Exception):
    """Why a file is not the result that its study says."""


@dataclass(frozen=True)
class Members:
    """Some members of a result, as a file holds them."""

    study: Study  # that they were computed for
    version: str  # of stiction that computed them
    numbers: NDArray[np.int64]
    arrays: Arrays
    about: About
    is_exact: bool  # whether its coordinates are those of the study to the last bit


def encoded(study: Study, numbers: Sequence[int], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """The file of some members, from arrays as `stacked` makes them; equal members give equal bytes."""
    import h5py

    with _making:
        template = _template(study, len(numbers))
    image = io.BytesIO(template)
    with h5py.File(image, "r+") as file:
        file["repetition"][...] = numbers
        for name, values in arrays.items():
            file[name][...] = values
    return image.getvalue()


@functools.lru_cache(maxsize=4)
def _template(study: Study, count: int) -> bytes:
    """The file of so many members, filled with zeros: most of the time of a file goes for names and units."""
    numbers = range(count)
    arrays = {name: np.zeros(each.shape, each.dtype) for name, each in variables_of(study, numbers).items()}
    if study.is_measured:
        arrays |= {name: np.zeros(count, dtype) for name, dtype in OF_MEMBERS.items()}
    image = io.BytesIO()
    write(dataset_of(study, numbers, arrays, about(study)), image)
    return image.getvalue()


def write(dataset: xarray.Dataset, file: io.BytesIO) -> None:
    """Write a dataset to a netCDF file as xarray does, but for its locks, for which workers of Dask ask a scheduler."""
    import h5netcdf
    import h5py
    from xarray.conventions import cf_encoder, encode_dataset_coordinates

    variables, attributes = encode_dataset_coordinates(dataset)
    for variable in variables.values():
        variable.encoding = {"_FillValue": None}
    variables, attributes = cf_encoder(variables, attributes)
    with h5netcdf.File(file, "w") as made:
        made.dimensions = {str(dim): size for dim, size in dataset.sizes.items()}
        for name, value in attributes.items():
            made.attrs[str(name)] = value
        for name, variable in variables.items():
            values = variable.values
            dtype = h5py.string_dtype() if values.dtype.kind in "UO" else values.dtype
            data = values.astype(object) if values.dtype.kind == "U" else values
            written = made.create_variable(str(name), variable.dims, dtype, data=data)
            for attribute, value in variable.attrs.items():
                written.attrs[attribute] = value


def seal(file: io.BytesIO) -> None:
    """Put the checksum of a file at its end."""
    file.seek(0, io.SEEK_END)
    file.write(SEAL + b"%08x" % zlib.crc32(file.getbuffer()))


def decoded(content: bytes) -> Members:
    """The members in a file; a `DamageError` if it is not the result of the study that it says."""
    with _opened(content) as file:
        title, text, version = (file.attrs.get(name) for name in ("title", "study", "stiction_version"))
        if title != TITLE or not isinstance(text, str):
            raise DamageError("does not say of what study it is")
        study = _parsed(text)
        numbers = _values(file, "repetition")
        arrays = {name: _values(file, name, each.shape) for name, each in variables_of(study, numbers).items()}
        of_bodies = About()
        if study.is_measured:
            arrays |= {name: _values(file, name, numbers.shape).astype(dtype) for name, dtype in OF_MEMBERS.items()}
            known = {name: file.attrs[name] for name in file.attrs if name not in OF_EVERY_RESULT}
            attributes = {name: each if isinstance(each, str) else np.atleast_1d(each) for name, each in known.items()}
            of_bodies = About(float(_values(file, "nominal_area")), attributes)
        steps = {name: each for name, each in coordinates_of(study, []).items() if name != "repetition"}
        is_exact = [np.array_equal(_values(file, name), values) for name, (_, values) in steps.items()]
    return Members(study, str(version), numbers, arrays, of_bodies, all(is_exact))


@contextmanager
def _opened(content: bytes) -> Iterator[h5py.File]:
    import h5py

    end = len(content) - len(SEAL) - 8
    if content[end:-8] == SEAL and content[-8:] != b"%08x" % zlib.crc32(memoryview(content)[:end]):
        raise DamageError("is not what was written")
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            yield file
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError, MemoryError):
        # All that HDF5 is known to answer to a file that is none.
        raise DamageError("is no netCDF file that can be read") from None


@functools.lru_cache(maxsize=8)
def _parsed(text: str) -> Study:
    try:
        return study_from_text(text, "its study")
    except ValueError as error:
        raise DamageError(f"has a study that cannot be read: {error}") from None


def _values(file: h5py.File, name: str, shape: tuple[int, ...] | None = None) -> NDArray[Any]:
    """Numbers or words of a variable that stands in the file itself, and in no other one."""
    import h5py

    found = file.get(name) if isinstance(file.get(name, getlink=True), h5py.HardLink) else None
    if not isinstance(found, h5py.Dataset) or found.external or found.is_virtual:
        raise DamageError(f"has no variable {name}")
    if found.id.get_storage_size() < found.nbytes:  # a small file may claim any size
        raise DamageError(f"has {name} that was never written")
    if shape not in (None, found.shape):
        raise DamageError(f"has {name} of another shape: {found.shape}, not {shape}")
    return np.asarray(found.asstr()[...] if h5py.check_string_dtype(found.dtype) else found[...])


# ---- Export ----------------------------------------------------------------------------------------------------------


class ExportError(ValueError):
    """A file that cannot be written."""


def export(dataset: xarray.Dataset, path: str | Path, *, replace: bool = False) -> None:
    """Write a dataset to a netCDF file, with every variable, coordinate and attribute; its numbers keep every bit.

    Parameters
    ----------
    dataset : xarray.Dataset
    path : path
        Must not exist yet. It appears when it is whole.
    replace : bool
        Whether it may exist as a file that this function wrote, which it then takes the place of.

    Raises
    ------
    ExportError
        If it exists or cannot be written.
    """
    path = Path(path)
    with replaced_file(path, SEAL, ExportError) if replace else new_file(path, ExportError) as partial:
        whole = io.BytesIO()  # because HDF5 may crash where a disk is full
        write(dataset, whole)
        seal(whole)
        partial.write_bytes(whole.getbuffer())
