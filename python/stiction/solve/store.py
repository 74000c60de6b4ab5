"""Results on disk: a directory with a study file, and one file per block of members.

    DIR/study.toml                               the study; the first line contains a checksum of the other lines
    DIR/blocks/0000008-0000015-1b2c3d4e.nc       members 8 to 15; the last field is the CRC-32 of the file's bytes

Block files are created atomically and never changed: a file with its final name is a finished block, and a missing file
is a block that still has to be computed. The bits of a member depend only on the study and the number of the member.
Two processes of the same study may therefore write the same block, and no lock is needed. Blocks may overlap, for
example after a study was extended; each member is then read from the first file that contains it.
"""

from __future__ import annotations

import functools
import io
import math
import os
import re
import threading
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import stiction._files as _files
from stiction._core import __version__
from stiction._files import (
    DirectoryClaim,
    UnreadableFileError,
    contains_file_mark,
    create_file_atomically,
    describe_os_error,
    read_file_bytes,
    replace_file_atomically,
)
from stiction._text import printable_path, printable_text
from stiction._warnings import warn_caller
from stiction.mechanics.friction import STATUS_OK, STATUSES
from stiction.mechanics.quantities import GAP_QUANTITIES, QUANTITIES
from stiction.solve.layout import (
    MEMBER_COORDINATE_TYPES,
    RESULT_TITLE,
    ArraysByName,
    build_dataset,
    compute_bytes_per_member,
    compute_members_per_piece,
    coordinate_specs_and_values,
    share_read_only,
    variable_specs,
)
from stiction.solve.members_in_progress import remove_stored_steps
from stiction.study.member_sources import BODY_ATTRIBUTE_SPECS, BodyAttributes
from stiction.study.members import find_body_attributes
from stiction.study.stored_values import (
    MIN_POSITIVE_STORED_VALUE,
    POSITIVE_STORED_VALUE_BOUNDS,
    AttributeSpec,
    DamagedFileError,
    VariableSpec,
    check_attributes,
    check_increase,
    check_missing_values,
    check_values,
)
from stiction.study.study import (
    MAX_STUDY_BYTES,
    Study,
    StudyDifference,
    find_member_differences,
    find_section_differences,
    format_study_differences,
    parse_study,
)
from stiction.study.values import format_toml_sections, parse_toml

if TYPE_CHECKING:
    import h5py
    import xarray

STUDY_FILE = "study.toml"
SHEAR_TEST_FILE_NAME = "shear.nc"
BLOCKS_DIRECTORY = "blocks"
# Name of the file in which earlier versions of stiction stored true areas at hardnesses other than that of the study.
AREAS_BY_HARDNESS_FILE = "hardness.nc"
CONTACT_PICTURE_FILE = "picture.nc"
ONSET_FILE = "onset.nc"
ONSET_TABLE_FILE = "onset.csv"
STUDY_FILE_SIGNATURE = "# Written by stiction"
_STUDY_FILE_HEADER_PATTERN = re.compile(rb"# Written by stiction [^\n]*\. CRC-32 of the text below: ([0-9a-f]{8})\.")
# First line of study files from earlier versions of stiction, which wrote no checksum.
_OLD_STUDY_FILE_HEADER_PATTERN = re.compile(rb"# Written by stiction (\S+)\.")
MAX_RESULT_BYTES = 2**31
MAX_COMPANION_FILE_BYTES = 2**26
_BLOCK_NAME_PATTERN = re.compile(r"([0-9]{7,18})-([0-9]{7,18})-([0-9a-f]{8})\.nc")
MAX_WRITE_ATTEMPTS = 3


class StoreError(ValueError):
    """Error raised if a stored result cannot be read or written."""


@dataclass(frozen=True)
class BlockFile:
    """Block file of a result. Its name contains the first member, the last member and a checksum of the content."""

    first: int
    last: int
    checksum: int

    @property
    def file_name(self) -> str:
        """Name of the block file without its directory."""
        return f"{self.first:07d}-{self.last:07d}-{self.checksum:08x}.nc"


@dataclass(frozen=True)
class StoreInfo:
    """Description of a stored result: study, finished members, size of the block files, and stiction version."""

    study: Study
    finished: int
    size: int  # bytes, of all block files
    versions: dict[str, str]


@dataclass(frozen=True)
class StoredResult:
    """Result of a study, stored in a directory as a study file and several block files.

    Blocks are read on demand, and a result that fits into a single piece is cached.
    """

    path: Path
    study: Study
    blocks: tuple[BlockFile, ...]

    @cached_property
    def _block_ranges(self) -> list[tuple[BlockFile, int, int]]:
        """Block files of the result, each with the range of members to read: first index, and last index + 1.

        The ranges do not overlap, even if the blocks do.
        """
        block_ranges, next_member = [], 0
        for block in sorted(self.blocks, key=lambda block: (block.first, -block.last, block.checksum)):
            start, stop = max(block.first, next_member), min(block.last + 1, self.study.ensemble.repetitions)
            if start < stop:
                block_ranges.append((block, start, stop))
                next_member = stop
        return block_ranges

    @property
    def num_finished(self) -> int:
        """Number of finished members of the result."""
        return sum(stop - start for _, start, stop in self._block_ranges)

    @cached_property
    def finished_members(self) -> NDArray[np.intp]:
        """Indices of the finished members of the result, in ascending order."""
        return np.concatenate(
            [np.empty(0, np.intp), *(np.arange(start, stop) for _, start, stop in self._block_ranges)]
        )

    @cached_property
    def version(self) -> str:
        """Version of stiction that computed the first block or, if no block is stored, the version in use."""
        return self.first_block_content.version if self.blocks else __version__

    @cached_property
    def total_file_size(self) -> int:
        """Size of all block files together, in bytes."""
        return sum((self.path / BLOCKS_DIRECTORY / block.file_name).lstat().st_size for block in self.blocks)

    @property
    def nbytes(self) -> int:
        """Memory (bytes) that the finished members require."""
        return self.num_finished * compute_bytes_per_member(self.study)

    def reload(self) -> StoredResult:
        """Return the stored result with all block files that are in its directory now."""
        return StoredResult(self.path, self.study, _list_block_files(self.path))

    @cached_property
    def first_block_content(self) -> BlockFileContent:
        """Content of the first block file: its members, and the study for which they were computed.

        This study may differ from the study file, for example in inputs that do not affect the members.
        """
        return self._read_block(self._block_ranges[0][0] if self._block_ranges else self.blocks[0])

    def dataset(self) -> xarray.Dataset:
        """Return all finished members of the result as a dataset.

        Raises a `StoreError` if the dataset exceeds 2 GiB, or if the result has no finished members, is damaged, or
        does not match its study.
        """
        if not self.num_finished:
            count_text = self.study.member_names.with_count(self.study.ensemble.repetitions)
            raise StoreError(f"{printable_path(self.path)}: none of the {count_text} is finished yet")
        if self.nbytes > MAX_RESULT_BYTES:
            raise StoreError(
                f"{printable_path(self.path)}: the result takes {self.nbytes / 2**30:.1f} GiB of memory, more than "
                f"the limit of {MAX_RESULT_BYTES / 2**30:.0f} GiB; use Result.pieces, or open "
                f"{printable_path(self.path / BLOCKS_DIRECTORY)} with xarray.open_mfdataset"
            )
        return (
            self._whole_dataset.copy(deep=True)
            if self._members_per_piece >= self.num_finished
            else self._read_member_range(0, self.num_finished)
        )

    def first_member(self) -> xarray.Dataset:
        """Return the first finished member of the result as a dataset.

        At least one member must be finished.
        """
        return self._read_member_range(0, 1)

    def pieces(self, names: Iterable[str] | None = None) -> Iterator[xarray.Dataset]:
        """Yield the finished members in groups, so that only one group is in memory at a time."""
        selected_names, count = None if names is None else list(names), self.num_finished
        for piece_start in range(0, count, self._members_per_piece):
            piece = (
                self._whole_dataset
                if self._members_per_piece >= count
                else self._read_member_range(
                    piece_start, min(piece_start + self._members_per_piece, count), selected_names
                )
            )
            yield piece.copy() if selected_names is None else piece[selected_names]

    @cached_property
    def _members_per_piece(self) -> int:
        """Number of members in each group that the method `pieces` yields."""
        return compute_members_per_piece(compute_bytes_per_member(self.study))

    @cached_property
    def _whole_dataset(self) -> xarray.Dataset:
        """Dataset with all finished members.

        The arrays are read-only, because all tables and figures share them.
        """
        return share_read_only(self._read_member_range(0, self.num_finished))

    def _read_member_range(self, first: int, last: int, names: Collection[str] | None = None) -> xarray.Dataset:
        """Read the finished members `self.finished_members[first:last]` as a dataset.

        `names` lists the variables of the dataset; by default, the dataset has all variables.
        """
        version, member_numbers = self.version, self.finished_members[first:last]
        axis = len(self.study.surfaces.cell_coordinates())
        arrays: ArraysByName = {
            name: np.empty(spec.shape, spec.dtype)
            for name, spec in variable_specs(self.study, member_numbers, names).items()
        }
        if self.study.is_measured:
            arrays |= {name: np.empty(member_numbers.size, dtype) for name, dtype in MEMBER_COORDINATE_TYPES.items()}
        block_start = num_copied = 0
        for block, block_first, block_last in self._block_ranges:
            block_end = block_start + block_last - block_first
            if first < block_end and block_start < last:
                first_in_block = max(first, block_start) - block_start + block_first
                end_in_block = min(last, block_end) - block_start + block_first
                block_arrays = self._read_arrays(block, arrays)
                for name, values in arrays.items():
                    leading_slices = (slice(None),) * (0 if name in MEMBER_COORDINATE_TYPES else axis)
                    source_slice = slice(first_in_block - block.first, end_in_block - block.first)
                    values[(*leading_slices, slice(num_copied, num_copied + end_in_block - first_in_block))] = (
                        block_arrays[name][(*leading_slices, source_slice)]
                    )
                num_copied += end_in_block - first_in_block
            block_start = block_end
        bodies = self.first_block_content.bodies
        return build_dataset(self.study, member_numbers, arrays, bodies, names).assign_attrs(stiction_version=version)

    def _read_arrays(self, block: BlockFile, names: Collection[str]) -> ArraysByName:
        """Read the named arrays from a block of members. The first call for a block reads and checks all of its arrays.

        Later calls read only the arrays in `names`, unless the block is in memory.
        """
        is_first = block is self._block_ranges[0][0]
        if block in self._checked_blocks and not is_first:
            return self._read_checked_block(block, names)
        content = self.first_block_content if is_first else self._read_block(block)
        if differences := find_member_differences(content.study, self.study):
            raise _build_damage_error(
                self.path, block, f"does not match {STUDY_FILE}: {format_study_differences(differences[:1])}"
            )
        self._checked_blocks.add(block)
        return content.arrays

    @cached_property
    def _checked_blocks(self) -> set[BlockFile]:
        """Block files that were read and checked. Single variables of these files can be read without another check."""
        return set()

    def _read_block(self, block: BlockFile) -> BlockFileContent:
        """Read a block file, check its checksum and member numbers against the file name, and return its content."""
        with self._convert_read_errors(block):
            file_content = self._read_block_bytes(block)
            if zlib.crc32(file_content) != block.checksum:
                raise DamagedFileError("does not match its checksum")
            content = decode_members(file_content)
            if not np.array_equal(content.numbers, np.arange(block.first, block.last + 1)):
                raise DamagedFileError("does not contain the members that its file name states")
        return content

    def _read_checked_block(self, block: BlockFile, names: Collection[str]) -> ArraysByName:
        """Read only the arrays in `names` from a block file that has been checked before."""
        member_numbers = np.arange(block.first, block.last + 1)
        expected_shapes = {name: spec.shape for name, spec in variable_specs(self.study, member_numbers, names).items()}
        with self._convert_read_errors(block), _open_netcdf(self._read_block_bytes(block)) as file:
            return {
                name: _read_member_array(file, name, expected_shapes.get(name, member_numbers.shape)) for name in names
            }

    def _read_block_bytes(self, block: BlockFile) -> bytes:
        return read_file_bytes(self.path / BLOCKS_DIRECTORY / block.file_name, MAX_RESULT_BYTES)

    @contextmanager
    def _convert_read_errors(self, block: BlockFile) -> Iterator[None]:
        """Convert errors that occur during the reading of a block file to a `StoreError` that names the block file."""
        try:
            yield
        except OSError as error:
            raise _build_damage_error(self.path, block, f"cannot be read: {describe_os_error(error)}") from None
        except (UnreadableFileError, DamagedFileError) as error:
            raise _build_damage_error(self.path, block, str(error)) from None


def _build_damage_error(path: Path, block: BlockFile, reason: str) -> StoreError:
    return StoreError(
        f"{printable_path(path / BLOCKS_DIRECTORY / block.file_name)}: {reason}; remove that file and run the study "
        f"again to recompute members {block.first} to {block.last}"
    )


# ---- Reading --------------------------------------------------------------------------------------------------------


def read(path: str | Path) -> xarray.Dataset:
    """Read a result from a result directory, or from a netCDF file that `export` has written.

    If the study is not finished, the dataset contains only the finished repetitions, and a warning is issued.

    Returns
    -------
    xarray.Dataset
        The dataset of the result that `run` returned.

    Raises
    ------
    StoreError
        If there is no result at that path, or the result is damaged, larger than 2 GiB, or has no finished
        repetition.
    """
    path = Path(path)
    if path.is_file():
        try:
            content = decode_members(read_file_bytes(path, MAX_RESULT_BYTES))
        except (OSError, UnreadableFileError, DamagedFileError) as error:
            raise StoreError(
                f"{printable_path(path)}: {describe_os_error(error) if isinstance(error, OSError) else error}"
            ) from None
        dataset = build_dataset(content.study, content.numbers, content.arrays, content.bodies)
        return dataset.assign_attrs(stiction_version=content.version)
    stored_result = open_stored_result(path)
    result = stored_result.dataset()
    num_members = stored_result.study.ensemble.repetitions
    if stored_result.num_finished < num_members:
        warn_caller(
            f"{printable_path(path)}: {stored_result.num_finished} of "
            f"{stored_result.study.member_names.with_count(num_members)} are finished; the result contains only these"
        )
    return result


def read_companion_file(
    path: Path, variables: Mapping[str, VariableSpec], attributes: Mapping[str, AttributeSpec] | None = None
) -> xarray.Dataset | None:
    """Read a netCDF file that is stored alongside a result, and check the variables and attributes in the file.

    Returns None if the file does not exist. Raises a `StoreError` if the file is damaged.
    """
    try:
        file_content = read_file_bytes(path, MAX_COMPANION_FILE_BYTES)
        with _open_netcdf(file_content) as file:
            for name, spec in variables.items():
                if spec.is_required or name in file:
                    _read_variable(file, name)
            check_attributes(file.attrs, attributes or {})
            dataset = _read_dataset(file)
        for name, spec in variables.items():
            if name in dataset.variables:
                _check_variable(name, dataset[name], spec)
    except FileNotFoundError:
        return None
    except (OSError, UnreadableFileError, DamagedFileError) as error:
        reason = describe_os_error(error) if isinstance(error, OSError) else error
        raise StoreError(
            f"{printable_path(path)}: {reason}; remove the file, and run the study again to recreate it"
        ) from None
    return dataset


def _read_dataset(file: h5py.File) -> xarray.Dataset:
    """Read all variables and attributes of a netCDF file, without decoding them.

    The dataset equals the dataset that xarray would read with the engine h5netcdf, in a fifth of the time.
    """
    import xarray

    variables = {}
    for name in file:
        values = _read_variable(file, name)
        variable = file[name]
        attributes = _read_attributes(variable)
        if DIMENSION_WITHOUT_VARIABLE_TEXT.encode() in bytes(variable.attrs.get("NAME", b"")):
            continue
        # netCDF stores Boolean values as integers, which xarray marks with the attribute `dtype`.
        if attributes.pop("dtype", "") == "bool":
            values = values.astype(np.bool_)
        dims = [name] if variable.is_scale else [dim[0].name.removeprefix("/") for dim in variable.dims]
        variables[name] = xarray.Variable(dims, values, attributes)
    return xarray.Dataset(variables, attrs=_read_attributes(file))


_NETCDF_ATTRIBUTES = ("CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST", "DIMENSION_LABELS")
"""Names of the attributes by which a netCDF file stores the dimensions of its variables."""


def _read_attributes(source: h5py.File | h5py.Dataset) -> dict[str, Any]:
    """Read the attributes of a netCDF file or variable.

    An array with one element is returned as a scalar.
    """
    names = [name for name in source.attrs if name not in _NETCDF_ATTRIBUTES and not name.startswith("_N")]
    values_by_name = {name: np.asarray(source.attrs[name]) for name in names}
    return {name: value.item() if value.size == 1 else value for name, value in values_by_name.items()}


def _check_variable(name: str, variable: xarray.DataArray, spec: VariableSpec) -> None:
    if variable.dims != spec.dims:
        raise DamagedFileError(f"has {name} with the dimensions {variable.dims} instead of {spec.dims}")
    check_values(name, variable.values, dtype=spec.dtype, bounds=spec.bounds, may_be_nan=spec.may_be_nan)
    if spec.ascending_dim:
        check_increase(name, variable.values, variable.dims.index(spec.ascending_dim))


def open_stored_result(path: str | Path) -> StoredResult:
    """Open the result in a directory without reading its blocks.

    Raises a `StoreError` if the directory has no result.
    """
    path = Path(path)
    if not path.exists():
        raise StoreError(f"{printable_path(path)}: no such directory")
    if path.is_file():
        raise StoreError(f"{printable_path(path)} is a file, but a result is a directory")
    blocks = _list_block_files(path)
    try:
        study = _read_study_file(path)
    except FileNotFoundError:
        if (path / SHEAR_TEST_FILE_NAME).exists():
            raise StoreError(
                f"{printable_path(path)} contains a shear test, which info, plot and report do not read; read "
                f"shear.csv or {SHEAR_TEST_FILE_NAME} in this directory, or export the test with stiction export"
            ) from None
        raise StoreError(f"{printable_path(path)} is not a result, because it contains no {STUDY_FILE}") from None
    except OSError as error:
        raise StoreError(f"{printable_path(path)}: {STUDY_FILE} cannot be read: {describe_os_error(error)}") from None
    return StoredResult(path, study, blocks)


def load_shear_test(directory: Path) -> xarray.Dataset | None:
    """Return the finished shear test in a directory, or None if the directory contains no shear test.

    Raises a `StoreError` if the file is not one that a shear test wrote.
    """
    import xarray

    path = directory / SHEAR_TEST_FILE_NAME
    if not path.exists():
        return None
    try:
        is_ours = contains_file_mark(path, CHECKSUM_PREFIX)
    except OSError as error:
        raise StoreError(f"{printable_path(path)}: cannot be read: {describe_os_error(error)}") from None
    if not is_ours:
        raise StoreError(
            f"{printable_path(path)} was not written by stiction shear; move the file, or choose another directory"
        )
    dataset = xarray.load_dataset(path, engine="h5netcdf")
    if "displacement" not in dataset.variables:
        raise StoreError(f"{printable_path(path)} contains no shear test; move the file, or choose another directory")
    return dataset


def open_result_to_complete(path: Path) -> StoredResult | None:
    """Open the result in a directory, or return None if the study file is missing or empty.

    Raises a `StoreError` if the study file is damaged.
    """
    file = path / STUDY_FILE
    return open_stored_result(path) if file.exists() and file.stat().st_size else None


def is_complete(path: str | Path, study: Study) -> bool:
    """Return whether the block files in a directory contain all members of a study.

    The block files are not read.
    """
    return StoredResult(Path(path), study, _list_block_files(Path(path))).num_finished == study.ensemble.repetitions


def info(path: str | Path) -> StoreInfo:
    """Return study, number of finished members, size of all block files, and stiction version of a stored result.

    At most one block file is read.

    Raises
    ------
    StoreError
        If there is no result at that path, or it is damaged.
    """
    stored_result = open_stored_result(path)
    return StoreInfo(
        stored_result.study,
        stored_result.num_finished,
        stored_result.total_file_size,
        {"stiction": printable_text(stored_result.version)},
    )


def _list_block_files(path: Path) -> tuple[BlockFile, ...]:
    try:
        names = sorted(os.listdir(path / BLOCKS_DIRECTORY))
    except (FileNotFoundError, NotADirectoryError):
        return ()
    except OSError as error:
        raise StoreError(
            f"{printable_path(path / BLOCKS_DIRECTORY)}: cannot be read: {describe_os_error(error)}"
        ) from None
    matches = (_BLOCK_NAME_PATTERN.fullmatch(name) for name in names)
    blocks = (BlockFile(int(match[1]), int(match[2]), int(match[3], 16)) for match in matches if match)
    return tuple(block for block in blocks if block.first <= block.last)


def _read_study_file(path: Path) -> Study:
    try:
        text = read_file_bytes(path / STUDY_FILE, MAX_STUDY_BYTES).decode()
    except (UnreadableFileError, UnicodeDecodeError) as error:
        raise StoreError(f"{printable_path(path / STUDY_FILE)} is not a study: {printable_text(error)}") from None
    # An empty study file is valid TOML, but was probably caused by a crash of the machine.
    if not text.strip():
        raise StoreError(
            f"{printable_path(path / STUDY_FILE)} is empty; run the study again in this directory to restore the file"
        )
    return parse_study(text, str(path / STUDY_FILE))


# ---- Writing --------------------------------------------------------------------------------------------------------


def create_or_open_result(path: str | Path, study: Study, claim: DirectoryClaim | None = None) -> StoredResult:
    """Create the result of a study in a directory, or open it if the directory already contains it.

    Stale partial files are removed. The claim of the run, if given, is acquired, so that no other study can use the
    directory. Raises a `StoreError` if the directory cannot be written, contains another study, is in use by a run of
    another study, or was created by another version.
    """
    path = Path(path)
    if path.is_file():
        raise StoreError(f"{printable_path(path)} is a file; give a directory for the results")
    stored_result = StoredResult(path, study, _list_block_files(path))
    _check_resumable(stored_result)
    if os.path.lexists(path / STUDY_FILE) and not _contains_study(path, study):
        _check_study_file_may_be_replaced(path, study)
    try:
        with DirectoryClaim(path) if claim is None else nullcontext(claim) as claim:
            (path / BLOCKS_DIRECTORY).mkdir(parents=True, exist_ok=True)
            for directory in (path, path / BLOCKS_DIRECTORY):
                _files.remove_stale_partial_files(directory)
            claim.acquire()
            if not _contains_study(path, study):
                _write_study_file(stored_result, claim)
    except (OSError, RuntimeError) as error:
        # A symbolic link that refers to itself causes a RuntimeError.
        if stored_result.num_finished < study.ensemble.repetitions:
            reason = describe_os_error(error) if isinstance(error, OSError) else error
            raise StoreError(f"{printable_path(path)}: cannot be written: {reason}") from None
    return stored_result


def _write_study_file(stored_result: StoredResult, claim: DirectoryClaim) -> None:
    """Write the study file of a result.

    An existing study file is replaced only if stiction wrote it, and if no other run uses the directory.
    """
    path, study = stored_result.path, stored_result.study
    text = study.to_toml()
    content = f"{_format_study_file_header(text)}\n\n{text}".encode()
    try:
        _files.create_atomically(path / STUDY_FILE, content)
    except FileExistsError:
        # Another run of the same study may have written the study file.
        if _contains_study(path, study):
            return
        if not _contains_study(path, study, repetitions_may_differ=True):
            check_directory_is_unused(path, claim)
        # A run ends its claim on a directory only after writing its blocks, so claims are checked before blocks.
        _check_resumable(stored_result.reload())
        _check_study_file_may_be_replaced(path, study)
        _files.write_atomically(path / STUDY_FILE, content)


def _format_study_file_header(text: str) -> str:
    """Return the first line of a study file, with a checksum that shows whether the file was edited later."""
    return f"{STUDY_FILE_SIGNATURE} {__version__}. CRC-32 of the text below: {zlib.crc32(text.encode()):08x}."


def remove_result(stored_result: StoredResult, claim: DirectoryClaim) -> None:
    """Remove the files of a result, such as the study file and the block files, from its directory, but no other files.

    Raises a `StoreError` if the study file was written or edited by hand, or if another run uses the directory.
    """
    check_study_file_is_unedited(stored_result.path)
    claim.acquire()
    check_directory_is_unused(stored_result.path, claim)
    for block in stored_result.blocks:
        (stored_result.path / BLOCKS_DIRECTORY / block.file_name).unlink(missing_ok=True)
    area_files = (AREAS_BY_HARDNESS_FILE,) if stored_result.study.is_measured else ()
    onset_files = (ONSET_FILE, ONSET_TABLE_FILE) if (stored_result.path / ONSET_FILE).exists() else ()
    remove_stored_steps(stored_result.path)
    for name in (STUDY_FILE, *area_files, *onset_files):
        (stored_result.path / name).unlink(missing_ok=True)


def _check_resumable(stored_result: StoredResult) -> None:
    """Raise a `StoreError` if an unfinished result was begun with another study, version or machine."""
    if not stored_result.blocks:
        return
    path, content, num_members = (
        stored_result.path,
        stored_result.first_block_content,
        stored_result.study.ensemble.repetitions,
    )
    if differences := find_member_differences(content.study, stored_result.study):
        raise StudyMismatchError(path, content.study, differences)
    last_member = max(block.last for block in stored_result.blocks)
    if last_member >= num_members:
        raise StoreError(
            f"{printable_path(path)}: repetition {last_member} is finished, and ensemble.repetitions = {num_members} "
            f"would discard it; set ensemble.repetitions to at least {last_member + 1}, or choose another directory"
        )
    if stored_result.num_finished == num_members:
        return
    if content.version != __version__:
        version = printable_text(content.version)
        raise StoreError(
            f"{printable_path(path)} was created by stiction {version}, and results of this version, {__version__}, "
            f"may differ; finish the result with stiction {version}, or choose another directory"
        )
    if not content.is_exact:
        raise StoreError(
            f"{printable_path(path)} was created on another machine or with another version of NumPy, so its "
            "coordinates, such as loads, differ slightly from the coordinates of the study; finish the result on the "
            "original machine with the original version of NumPy, or choose another directory"
        )


def check_study_file_is_unedited(path: Path) -> None:
    """Raise a `StoreError` if the study file in a directory was written or edited by hand.

    An empty file, which a crash of the machine may leave, and changed line ends are accepted. Symbolic links are
    rejected.
    """
    file = path / STUDY_FILE
    try:
        content = read_file_bytes(file, MAX_STUDY_BYTES).replace(b"\r\n", b"\n")
        header, _, text = content.partition(b"\n\n")
        match = _STUDY_FILE_HEADER_PATTERN.fullmatch(header)
        if not file.is_symlink() and (
            not content.strip()
            or (match is not None and int(match[1], 16) == zlib.crc32(text))
            or _is_old_study_file(path, header, text)
        ):
            return
    except OSError as error:
        raise StoreError(f"{printable_path(file)}: cannot be read: {describe_os_error(error)}") from None
    except UnreadableFileError as error:
        raise StoreError(f"{printable_path(file)}: {error}; choose another directory, or remove this file") from None
    raise EditedStudyError(
        f"{printable_path(file)} was written or edited by hand, so it is not replaced; choose another directory, or "
        "move this file"
    )


def _is_old_study_file(path: Path, header: bytes, text: bytes) -> bool:
    """Return whether a study file was written by an early version of stiction, which stored no checksums.

    The version in the file must be the version of the blocks. Such a result can be extended, although a changed value
    in the study file would not be noticed.
    """
    match, blocks = _OLD_STUDY_FILE_HEADER_PATTERN.fullmatch(header), _list_block_files(path)
    if match is None or not blocks:
        return False
    try:
        study = parse_study(text.decode(), STUDY_FILE)
        has_usual_format = format_toml_sections(parse_toml(text.decode())).encode() == text
        return has_usual_format and StoredResult(path, study, blocks).version.encode() == match[1]
    except ValueError:
        return False


def _check_study_file_may_be_replaced(path: Path, study: Study) -> None:
    """Raise a `StudyMismatchError` if the study file in a directory must be kept, because it was edited by hand."""
    try:
        check_study_file_is_unedited(path)
    except EditedStudyError:
        stored_study = _read_study_file(path)
        differences = find_section_differences(stored_study, study)
        raise StudyMismatchError(path, stored_study, differences, is_edited=True) from None


def check_directory_is_unused(path: Path, claim: DirectoryClaim) -> None:
    """Raise a `StoreError` if another active run uses the result directory of this run."""
    if competitor := claim.find_other_claim():
        raise StoreError(
            f"{printable_path(path)} is in use by another run; wait until that run ends, or choose another directory; "
            f"if there is no such run, remove {printable_path(competitor)}"
        )


def _contains_study(path: Path, study: Study, *, repetitions_may_differ: bool = False) -> bool:
    """Return whether the study file in a directory is readable and contains a given study."""
    try:
        stored_study = _read_study_file(path)
    except (OSError, ValueError):
        return False
    if not repetitions_may_differ:
        return stored_study == study
    return all(study_key == "ensemble.repetitions" for study_key, *_ in find_section_differences(stored_study, study))


class EditedStudyError(StoreError):
    """Error raised if a run would replace a study file that was written or edited by hand."""


class StudyMismatchError(StoreError):
    """Error raised if a directory contains the result of a different study."""

    def __init__(
        self,
        path: Path,
        stored: Study,
        differences: list[StudyDifference],
        advice: str = "",
        *,
        is_edited: bool = False,
    ) -> None:
        advice = advice or (
            "choose another directory" if is_edited else "give another directory, or replace the stored result"
        )
        edit_text = f" in a {STUDY_FILE} that was written or edited by hand" if is_edited else ""
        super().__init__(
            f"{printable_path(path)} contains another study{edit_text}; {advice}\n"
            f"{format_study_differences(differences)}"
        )
        self.path, self.stored, self.differences, self.is_edited = path, stored, differences, is_edited

    def with_remedy(self, advice: str) -> StudyMismatchError:
        """Return a copy of the error with `advice` at the end of the message."""
        return StudyMismatchError(self.path, self.stored, self.differences, advice, is_edited=self.is_edited)


def write_block(path: Path, first_member: int, content: bytes, num_members: int) -> None:
    """Write a block file that contains `num_members` members, starting with the member `first_member`.

    Raises a `StoreError` if the file cannot be written.
    """
    block = BlockFile(first_member, first_member + num_members - 1, zlib.crc32(content))
    for attempt in range(1, MAX_WRITE_ATTEMPTS + 1):
        try:
            _files.write_atomically(path / BLOCKS_DIRECTORY / block.file_name, content)
            return
        except FileNotFoundError:
            # Another process may have removed the partial file.
            if attempt == MAX_WRITE_ATTEMPTS or not (path / BLOCKS_DIRECTORY).is_dir():
                raise StoreError(f"{printable_path(path)} was removed or replaced while it was being written") from None
        except OSError as error:
            raise StoreError(f"{printable_path(path)}: cannot be written: {describe_os_error(error)}") from None


# ---- The file of a block ---------------------------------------------------------------------------------------------

STORED_ATTRIBUTES_NOT_OF_BODIES = ("title", "study", "stiction_version", "_NCProperties")

CHECKSUM_PREFIX = b"stiction crc32 "
"""Bytes before the checksum at the end of an exported file.

The checksum is verified first, because HDF5 may never return from reading a damaged file. HDF5 ignores bytes after its
own data, and programs that modify the file remove the checksum.
"""

_template_file_lock = threading.Lock()
_dataset_package_import_lock = threading.Lock()


@dataclass(frozen=True)
class BlockFileContent:
    """Content of a block file: arrays of its members, their study, and the stiction version of the computation."""

    study: Study
    version: str
    numbers: NDArray[np.int64]
    arrays: ArraysByName
    bodies: BodyAttributes
    is_exact: bool


def encode_members(study: Study, numbers: Sequence[int], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Convert the arrays of several members to the bytes of a block file.

    Equal members give equal bytes.
    """
    import_dataset_packages()
    import h5py

    with _template_file_lock:
        template = _encode_block_of_zeros(study, len(numbers))
    file_image = io.BytesIO(template)
    with h5py.File(file_image, "r+") as file:
        for name, values in {"repetition": np.asarray(numbers), **arrays}.items():
            # Low-level functions of h5py take a third of the time that h5py's classes would take.
            identifier = h5py.h5d.open(file.id, name.encode())
            if identifier.shape != values.shape:
                raise ValueError(f"{name} must have the shape {identifier.shape}, got {values.shape}")
            identifier.write(h5py.h5s.ALL, h5py.h5s.ALL, np.ascontiguousarray(values, identifier.dtype))
    return file_image.getvalue()


@functools.lru_cache(maxsize=4)
def _encode_block_of_zeros(study: Study, count: int) -> bytes:
    """Return the bytes of a block file of `count` members in which all numbers are 0, for use as a template.

    Copying a template is much faster than writing a new file, because names and units take longer to write than values.
    """
    member_numbers = range(count)
    arrays = {name: np.zeros(spec.shape, spec.dtype) for name, spec in variable_specs(study, member_numbers).items()}
    if study.is_measured:
        arrays |= {name: np.zeros(count, dtype) for name, dtype in MEMBER_COORDINATE_TYPES.items()}
    file_image = io.BytesIO()
    write_dataset(build_dataset(study, member_numbers, arrays, find_body_attributes(study)), file_image)
    return file_image.getvalue()


def import_dataset_packages() -> None:
    """Import the packages that encode blocks, so that the first finished block does not wait for the import.

    The import takes 0.3 s, in which other threads compute. Only one thread imports at a time: if two threads import
    xarray, each may need a module that the other has not finished, and one import then fails.
    """
    with _dataset_package_import_lock:
        import h5py  # noqa: F401
        import xarray.conventions  # noqa: F401


def write_dataset(dataset: xarray.Dataset, file: io.BytesIO) -> None:
    """Write a dataset to a netCDF file, with the content that xarray would write.

    xarray would look up each dimension in the file for each variable, which takes three times as long, and its locks
    would require a Dask scheduler in Dask workers.
    """
    import h5py
    from xarray.conventions import cf_encoder, encode_dataset_coordinates

    variables, attributes = encode_dataset_coordinates(dataset)
    for variable in variables.values():
        variable.encoding = {"_FillValue": None}
    variables, attributes = cf_encoder(variables, attributes)
    dimension_numbers = {str(dim): number for number, dim in enumerate(dataset.sizes)}
    with h5py.File(file, "w", track_order=True) as output:
        _write_netcdf_properties(output)
        _write_attributes(output, attributes)
        scales: dict[str, h5py.Dataset] = {}
        for dim, size in dataset.sizes.items():
            if dim not in variables:
                scale = scales[str(dim)] = _create_variable(output, str(dim), np.zeros(size, ">f4"))
                scale.make_scale(f"{DIMENSION_WITHOUT_VARIABLE_TEXT}{size:10}")
                scale.attrs["_Netcdf4Dimid"] = np.int32(dimension_numbers[str(dim)])
        # All other variables refer to the coordinates of the dimensions, so the coordinates are written first.
        for name, variable in sorted(variables.items(), key=lambda item: item[0] not in dataset.sizes):
            netcdf_variable = _create_variable(output, str(name), variable.values)
            dims = [str(dim) for dim in variable.dims]
            if name in dimension_numbers:
                scales[str(name)] = netcdf_variable
                netcdf_variable.make_scale(str(name))
            for axis, dim in enumerate(dims if name not in dimension_numbers else ()):
                h5py.h5ds.attach_scale(netcdf_variable.id, scales[dim].id, axis)
            if dims:
                netcdf_variable.attrs["_Netcdf4Coordinates"] = np.array(
                    [dimension_numbers[dim] for dim in dims], np.int32
                )
                netcdf_variable.attrs["_Netcdf4Dimid"] = np.int32(dimension_numbers[dims[0]])
            _write_attributes(netcdf_variable, variable.attrs)


DIMENSION_WITHOUT_VARIABLE_TEXT = "This is a netCDF dimension but not a netCDF variable."
"""Beginning of the label that the netCDF format requires for a dimension without coordinates. The size follows."""


def _create_variable(file: h5py.File, name: str, values: NDArray[Any]) -> h5py.Dataset:
    import h5py

    dtype = h5py.string_dtype() if values.dtype.kind in "UO" else values.dtype
    # In the netCDF format, a dimension of size 0 is unlimited.
    max_shape = tuple(size or None for size in values.shape) if 0 in values.shape else None
    return file.create_dataset(
        name, data=values.astype(object) if values.dtype.kind == "U" else values, dtype=dtype, maxshape=max_shape,
        track_order=True,
    )  # fmt: skip


def _write_attributes(target: h5py.File | h5py.Dataset, attributes: Mapping[Any, Any]) -> None:
    """Write attributes to a netCDF file or variable.

    As in the netCDF format, a number is stored as an array with one element.
    """
    for name, value in attributes.items():
        target.attrs[str(name)] = np.atleast_1d(value) if np.isscalar(value) and not isinstance(value, str) else value


def _write_netcdf_properties(file: h5py.File) -> None:
    """Write the hidden attribute by which programs recognize a netCDF file."""
    import h5py

    text = f"version=2,h5py={h5py.version.version},hdf5={h5py.version.hdf5_version}".encode()
    text_type = h5py.h5t.C_S1.copy()
    text_type.set_size(len(text) + 1)
    scalar_space = h5py.h5s.create(h5py.h5s.SCALAR)
    h5py.h5a.create(file.id, b"_NCProperties", text_type, scalar_space).write(np.array(text, f"S{len(text) + 1}"))


def append_checksum(file: io.BytesIO) -> None:
    """Append `CHECKSUM_PREFIX` and a checksum of all bytes written so far to a file."""
    file.seek(0, io.SEEK_END)
    file.write(CHECKSUM_PREFIX + b"%08x" % zlib.crc32(file.getbuffer()))


def decode_members(content: bytes) -> BlockFileContent:
    """Decode the bytes of a block file, and check the decoded arrays and attributes.

    Raises a `DamagedFileError` if the arrays do not match the study in the file, or if an array or an attribute has
    values that no computation returns.
    """
    with _open_netcdf(content) as file:
        title, text, version = (file.attrs.get(name) for name in ("title", "study", "stiction_version"))
        if title != RESULT_TITLE or not isinstance(text, str):
            raise DamagedFileError("has no attribute 'study'")
        if not isinstance(version, str):
            raise DamagedFileError("has no attribute 'stiction_version'")
        study = _parse_stored_study(text)
        repetitions = _read_variable(file, "repetition")
        check_values("repetition", repetitions, dtype=int, bounds=(0, np.iinfo(np.int64).max))
        if repetitions.ndim != 1 or np.unique(repetitions).size < repetitions.size:
            raise DamagedFileError("contains a repetition more than once")
        arrays = {
            name: _read_member_array(file, name, spec.shape)
            for name, spec in variable_specs(study, repetitions).items()
        }
        check_member_arrays(study, arrays)
        arrays = {name: values.astype(QUANTITIES[name].dtype, copy=False) for name, values in arrays.items()}
        bodies = BodyAttributes()
        if study.is_measured:
            for name, dtype in MEMBER_COORDINATE_TYPES.items():
                coordinate = _read_variable(file, name, repetitions.shape)
                # Surrogates have no positions, so their x and y are NaN.
                check_values(
                    name, coordinate, dtype=QUANTITIES[name].dtype, bounds=QUANTITIES[name].stored_bounds,
                    may_be_nan=True,
                )  # fmt: skip
                arrays[name] = coordinate.astype(dtype)
            stored_attributes = {
                name: file.attrs[name] for name in file.attrs if name not in STORED_ATTRIBUTES_NOT_OF_BODIES
            }
            check_attributes(stored_attributes, BODY_ATTRIBUTE_SPECS)
            attributes = {
                name: value if isinstance(value, str) else np.atleast_1d(value)
                for name, value in stored_attributes.items()
            }
            nominal_area = _read_variable(file, "nominal_area", ())
            check_values("nominal_area", nominal_area, bounds=POSITIVE_STORED_VALUE_BOUNDS)
            bodies = BodyAttributes(float(nominal_area), attributes)
        coordinates = {
            name: spec_and_values
            for name, spec_and_values in coordinate_specs_and_values(study, []).items()
            if name != "repetition"
        }
        is_exact = [np.array_equal(_read_variable(file, name), values) for name, (_, values) in coordinates.items()]
    return BlockFileContent(study, version, repetitions, arrays, bodies, all(is_exact))


def check_member_arrays(study: Study, arrays: ArraysByName) -> None:
    """Raise a `DamagedFileError` if member arrays contain numbers that a computation cannot produce.

    Values may be NaN only where a solver can fail, which is at given loads and for the pull-off force. If a solver
    fails at a load, all contact sums are NaN. A contact that carries a load has an area.
    """
    can_fail = study.step_quantity == "load"
    smallest_values, names_with_nan = {}, []
    for name, values in arrays.items():
        quantity = QUANTITIES[name]
        smallest_values[name], has_nan = check_values(
            name, values, dtype=quantity.dtype, bounds=quantity.stored_bounds,
            may_be_nan=can_fail and name not in GAP_QUANTITIES,
        )  # fmt: skip
        names_with_nan += [name] * has_nan
    load, area = arrays["normal_elastic"], arrays["contact_area"]
    for name, values in (("normal_elastic", load), ("contact_area", area)):
        is_small = smallest_values[name] < MIN_POSITIVE_STORED_VALUE
        if is_small and ((values > 0) & (values < MIN_POSITIVE_STORED_VALUE)).any():
            raise DamagedFileError(f"has {name} with a value between 0 and {MIN_POSITIVE_STORED_VALUE:g}")
    if smallest_values["contact_area"] == 0 and ((area == 0) & (load > 0)).any():
        raise DamagedFileError("has contact_area = 0 at a load above 0")
    is_missing = np.isnan(load) if names_with_nan else np.zeros(load.shape, dtype=bool)
    for name, values in arrays.items():
        is_step_sum = QUANTITIES[name].kind == "sum" and "step" in QUANTITIES[name].along
        if names_with_nan and is_step_sum and values.dtype.kind == "f":
            check_missing_values(name, values, is_missing)
    if "status" in arrays:
        check_values("status", arrays["status"], dtype=int, bounds=(0, len(STATUSES) - 1))
        if not np.array_equal(arrays["status"] != STATUSES.index(STATUS_OK), is_missing):
            raise DamagedFileError(
                "has a status that contradicts normal_elastic, which is NaN exactly at loads without a solution"
            )


@contextmanager
def _open_netcdf(content: bytes) -> Iterator[h5py.File]:
    import h5py

    content_length = len(content) - len(CHECKSUM_PREFIX) - 8
    if content[content_length:-8] == CHECKSUM_PREFIX and content[-8:] != b"%08x" % zlib.crc32(
        memoryview(content)[:content_length]
    ):
        raise DamagedFileError("does not match its checksum")
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            yield file
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError, MemoryError):
        # For a file that is not an HDF5 file, h5py may raise several classes of errors.
        raise DamagedFileError("is not a readable netCDF file") from None


@functools.lru_cache(maxsize=8)
def _parse_stored_study(text: str) -> Study:
    try:
        return parse_study(text, "its study")
    except ValueError as error:
        raise DamagedFileError(f"contains a study that cannot be read: {error}") from None


def _read_member_array(file: h5py.File, name: str, shape: tuple[int, ...]) -> NDArray[Any]:
    """Read a variable of a block.

    The values are NaN if the version that wrote the block did not compute the variable.
    """
    if name in QUANTITIES and QUANTITIES[name].is_optional and name not in file:
        return np.full(shape, np.nan)
    return _read_variable(file, name, shape)


def _read_variable(file: h5py.File, name: str, shape: tuple[int, ...] | None = None) -> NDArray[Any]:
    """Read a variable of an HDF5 file.

    Variables that are links to other data are rejected.
    """
    import h5py

    encoded_name = name.encode()
    hdf5_links = file.id.links
    is_stored_here = hdf5_links.exists(encoded_name) and hdf5_links.get_info(encoded_name).type == h5py.h5l.TYPE_HARD
    identifier: Any = h5py.h5o.open(file.id, encoded_name) if is_stored_here else None
    creation_properties = identifier.get_create_plist() if isinstance(identifier, h5py.h5d.DatasetID) else None
    if (
        creation_properties is None
        or creation_properties.get_external_count()
        or creation_properties.get_layout() == h5py.h5d.VIRTUAL
    ):
        raise DamagedFileError(f"has no variable {name}")
    dtype, stored_shape = identifier.dtype, identifier.shape
    # A small damaged file may declare a huge array, so the stored size is checked before memory is allocated.
    if identifier.get_storage_size() < math.prod(stored_shape) * dtype.itemsize:
        raise DamagedFileError(f"declares {name} but does not store it")
    if shape not in (None, stored_shape):
        raise DamagedFileError(f"has {name} with the shape {stored_shape} instead of {shape}")
    if dtype.kind not in "biuf":
        variable = h5py.Dataset(identifier)
        return np.asarray(variable.asstr()[...] if h5py.check_string_dtype(dtype) else variable[...])
    values = np.empty(stored_shape, dtype)
    identifier.read(h5py.h5s.ALL, h5py.h5s.ALL, values)
    return values


# ---- Export ----------------------------------------------------------------------------------------------------------


class ExportError(ValueError):
    """Error raised if a result cannot be exported to a file."""


def export(dataset: xarray.Dataset, path: str | Path, *, replace: bool = False) -> None:
    """Write a dataset with all variables, coordinates and attributes to a netCDF file.

    Parameters
    ----------
    dataset : xarray.Dataset
    path : path
        File to create, which must not exist yet. The file appears only when it is complete.
    replace : bool
        True to replace an existing file that this function wrote.

    Raises
    ------
    ExportError
        If the file exists or cannot be written.
    """
    path = Path(path)
    with (
        replace_file_atomically(path, CHECKSUM_PREFIX, ExportError)
        if replace
        else create_file_atomically(path, ExportError) as partial
    ):
        # HDF5 may crash if the disk is full, so the content of the file is first created in memory.
        content = io.BytesIO()
        write_dataset(dataset, content)
        append_checksum(content)
        partial.write_bytes(content.getbuffer())
