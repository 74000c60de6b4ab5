"""The netCDF file of some members of a result: how it is made and read.

A file whose checksum holds is as it was written, and trusted: its numbers are taken as they are. Compared are the study
that it is of and the shapes that this says.
"""

from __future__ import annotations

import functools
import io
import threading
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from stiction.studies.members import about
from stiction.studies.result import OF_MEMBERS, TITLE, About, Arrays, coordinates_of, dataset_of, variables_of
from stiction.studies.study import Study, study_from_text

if TYPE_CHECKING:
    import xarray

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


# ---- Writing --------------------------------------------------------------------------------------------------------


def encoded(study: Study, numbers: Sequence[int], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """The file of some members, from arrays as `stacked` makes them; equal members give equal bytes."""
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


# ---- Reading --------------------------------------------------------------------------------------------------------


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


def decoded_beside(content: bytes, names: Iterable[str]) -> xarray.Dataset:
    """The dataset in a small file beside a result; a `DamageError` if it lacks one of these variables."""
    import xarray

    with _opened(content) as file:
        for name in names:
            _values(file, name)
        options: dict[str, Any] = {"engine": "h5netcdf", "decode_cf": False, "phony_dims": "sort"}
        with xarray.open_dataset(io.BytesIO(content), **options) as dataset:
            dataset.load()
    attributes = {name: np.asarray(value) for name, value in dataset.attrs.items()}
    dataset.attrs = {name: each.item() if each.size == 1 else each for name, each in attributes.items()}
    return dataset


@contextmanager
def _opened(content: bytes) -> Iterator[h5py.File]:
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
    found = file.get(name) if isinstance(file.get(name, getlink=True), h5py.HardLink) else None
    if not isinstance(found, h5py.Dataset) or found.external or found.is_virtual:
        raise DamageError(f"has no variable {name}")
    if found.id.get_storage_size() < found.nbytes:  # a small file may claim any size
        raise DamageError(f"has {name} that was never written")
    if shape not in (None, found.shape):
        raise DamageError(f"has {name} of another shape: {found.shape}, not {shape}")
    return np.asarray(found.asstr()[...] if h5py.check_string_dtype(found.dtype) else found[...])
