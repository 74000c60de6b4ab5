"""The netCDF file of some members of a result: how it is made, and how it is checked when it is read.

What a file holds is compared with its study in one place, before anybody else sees it: names, kinds of numbers,
dimensions and ranges. Units and names are never taken from a file, because the study says them.
"""

from __future__ import annotations

import functools
import io
import threading
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import h5py
import numpy as np
from numpy.typing import NDArray

from stiction.studies.members import about
from stiction.studies.result import (
    OF_MEMBERS,
    TITLE,
    About,
    Array,
    Arrays,
    coordinates_of,
    dataset_of,
    is_measured,
    variables_of,
)
from stiction.studies.study import Study, study_from_text

if TYPE_CHECKING:
    import xarray

SAME = 1e-9
"""Largest relative difference between a coordinate and what its study says: another machine may round otherwise."""

LARGEST = 1e100
"""Largest magnitude of a number in a file, far above any in core units, so that sums of squares do not overflow."""

TEXT_OF_BODIES = ("upper", "lower")
NUMBERS_OF_BODIES = (
    "shape",
    "spacing_um",
    "fraction_used",
    "upper_spacing_um",
    "lower_spacing_um",
    "upper_extent_um",
    "lower_extent_um",
)
"""Attributes of a result of measured bodies, besides those of every result."""


SEAL = b"stiction crc32 "
"""What an exported file ends with, before the checksum of all that precedes, because HDF5 may run for ever in a damaged
file. HDF5 reads no further than its own end, and what else writes into the file takes the seal off."""

EXEMPT = ("title", "mechanics", "poisson_ratio", "x", "y")
"""Attributes of files beside a result that need not be one finite number: text, two, or unknown of surrogates."""

MOST_BESIDE = 2**26
"""Bytes of a file that lies beside a result."""


WORDS = ("units", "long_name")
"""Attributes of a variable of such a file."""


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


_making = threading.Lock()
"""So that threads, whose first blocks end at the same time, make one template and not one each."""


@functools.lru_cache(maxsize=4)
def _template(study: Study, count: int) -> bytes:
    """The file of this many members, filled with zeros.

    To make one takes 40 ms, most of it for names and units, which all files of a study share.
    """
    numbers = range(count)
    arrays = {name: np.zeros(each.shape, each.dtype) for name, each in variables_of(study, numbers).items()}
    if is_measured(study):
        arrays |= {name: np.zeros(count, dtype) for name, dtype in OF_MEMBERS.items()}
    image = io.BytesIO()
    write(dataset_of(study, numbers, arrays, about(study)), image)
    return image.getvalue()


def write(
    dataset: xarray.Dataset,
    file: Path | io.BytesIO,
    *,
    growing: str | None = None,
    chunks: Mapping[str, tuple[int, ...]] | None = None,
) -> None:
    """Write a dataset to a netCDF file, of which no number means that one is missing.

    This is what `xarray.Dataset.to_netcdf` does, but for its locks: a worker of Dask would ask its scheduler for one. A
    dimension may be `growing` afterwards, and `chunks` are shapes of those of some variables.
    """
    import h5netcdf
    from xarray.conventions import cf_encoder, encode_dataset_coordinates

    variables, attributes = encode_dataset_coordinates(dataset)
    for variable in variables.values():
        variable.encoding = {"_FillValue": None}
    variables, attributes = cf_encoder(variables, attributes)
    with h5netcdf.File(file, "w") as made:
        made.dimensions = {str(dim): None if dim == growing else size for dim, size in dataset.sizes.items()}
        for name, value in attributes.items():
            made.attrs[str(name)] = value
        for name, variable in variables.items():
            values = variable.values
            dtype = h5py.string_dtype() if values.dtype.kind in "UO" else values.dtype
            data = values.astype(object) if values.dtype.kind == "U" else values
            written = made.create_variable(
                str(name), variable.dims, dtype, data=data, chunks=(chunks or {}).get(str(name))
            )
            for attribute, value in variable.attrs.items():
                written.attrs[attribute] = value


def seal(file: BinaryIO) -> None:
    """Put the checksum of a file, open for reading and writing, at its end."""
    file.seek(0)
    checksum = 0
    while part := file.read(2**24):
        checksum = zlib.crc32(part, checksum)
    file.write(SEAL + b"%08x" % checksum)


# ---- Reading --------------------------------------------------------------------------------------------------------


def decoded(content: bytes) -> Members:
    """What a file holds, checked; a `DamageError` if it is not the result of the study that it says."""
    with _opened(content) as file:
        study, version = _study(file)
        numbers = _numbers(file, study)
        wanted = variables_of(study, numbers)
        wanted |= {
            name: Array(("repetition",), numbers.shape, dtype, {})
            for name, dtype in (OF_MEMBERS.items() if is_measured(study) else ())
        }
        arrays = {name: _values(file, name, each) for name, each in wanted.items()}
        said = {name: each for name, each in coordinates_of(study, []).items() if name != "repetition"}
        exact = {name: _is_exact(file, name, *each) for name, each in said.items()}
        of_bodies = _about(file) if is_measured(study) else About()
    for name, values in arrays.items():
        _check_range(name, values, wanted[name], arrays.get("surrogate"))
    return Members(study, version, numbers, arrays, of_bodies, all(exact.values()))


def decoded_beside(
    content: bytes,
    variables: Mapping[str, tuple[str, ...]],
    numbers: Iterable[str],
    text: Mapping[str, list[str]],
    optional: Mapping[str, tuple[str, ...]],
) -> xarray.Dataset:
    """What a small file beside a result holds, checked, see `read_beside`; a `DamageError` if it is not that."""
    import xarray

    sizes = {name: len(words) for name, words in text.items()}
    held: dict[str, Any] = {}
    with _opened(content) as file:
        wanted = {**variables, **(optional if all(name in file for name in optional) else {})}
        for name, dims in wanted.items():
            found = _variable(file, name)
            sizes = dict(zip(dims, found.shape, strict=False)) | sizes
            if found.shape != tuple(map(sizes.get, dims)) or not 0 < 8 * found.size <= MOST_BESIDE:
                raise DamageError(f"has {name} of another shape: {found.shape}")
            dtype = np.dtype(np.float32 if found.dtype == np.float32 else np.float64)
            values = _values(file, name, Array(dims, found.shape, dtype, {}))
            if (np.abs(values.astype(np.float64)) > LARGEST).any():
                raise DamageError(f"has a {name} that cannot be")
            held[name] = (dims, values, {each: found.attrs[each] for each in WORDS if each in found.attrs})
        for name, words in text.items():
            if not _is_exact(file, name, Array((name,), (len(words),), np.dtype("U1"), {}), np.array(words)):
                raise DamageError(f"has another {name}")
            held[name] = ((name,), np.array(words))
        for name in numbers:
            _numbers_of(file, name, unknown=True)  # surrogates are not moved over each other
        said = {name: np.asarray(value) for name, value in file.attrs.items() if not name.startswith("_")}
    # No scales are taken from the file.
    attributes = {name: each.item() if each.size == 1 else each for name, each in said.items()}
    for name, value in attributes.items():
        if name not in EXEMPT and not (isinstance(value, int | float) and np.isfinite(value)):
            raise DamageError(f"has a {name} that is no number")
    coordinates = {name: each for name, each in held.items() if name in sizes}
    return xarray.Dataset({name: held[name] for name in wanted if name not in sizes}, coordinates, attributes)


@contextmanager
def _opened(content: bytes) -> Iterator[h5py.File]:
    end = len(content) - len(SEAL) - 8
    if content[end:-8] == SEAL and content[-8:] != b"%08x" % zlib.crc32(memoryview(content)[:end]):
        raise DamageError("is not what was written")
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            yield file
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError, MemoryError):
        # All that HDF5 is known to answer to a file that is none, or that lies about itself.
        raise DamageError("is no netCDF file that can be read") from None


def _study(file: h5py.File) -> tuple[Study, str]:
    said = {name: file.attrs.get(name) for name in ("title", "study", "stiction_version")}
    if said["title"] != TITLE or not all(isinstance(text, str) for text in said.values()):
        raise DamageError("does not say of what study it is")
    return _parsed(str(said["study"])), str(said["stiction_version"])


@functools.lru_cache(maxsize=8)
def _parsed(text: str) -> Study:
    try:
        return study_from_text(text, "its study")
    except ValueError as error:
        raise DamageError(f"has a study that cannot be read: {error}") from None


def _numbers(file: h5py.File, study: Study) -> NDArray[np.int64]:
    count = _variable(file, "repetition").size
    if not 0 < count <= study.ensemble.repetitions:
        raise DamageError(f"has {count} repetitions, and its study {study.ensemble.repetitions}")
    numbers = _values(file, "repetition", Array(("repetition",), (count,), np.dtype(np.int64), {}))
    if numbers[0] < 0 or numbers[-1] >= study.ensemble.repetitions or not (np.diff(numbers) > 0).all():
        raise DamageError("has repetitions that its study has not, or that are not in order")
    return numbers


def _variable(file: h5py.File, name: str) -> h5py.Dataset:
    """A variable that stands in the file itself."""
    link = file.get(name, getlink=True)
    found = file[name] if isinstance(link, h5py.HardLink) else None
    if not isinstance(found, h5py.Dataset) or found.external or found.is_virtual:
        raise DamageError(f"has no variable {name}")
    return found


def _values(file: h5py.File, name: str, wanted: Array) -> NDArray[Any]:
    """The numbers of a variable, which are read only if they are of the kind and number that are wanted."""
    found = _variable(file, name)
    stored = np.dtype(np.int8) if wanted.dtype == np.bool_ else wanted.dtype  # netCDF has no truth values
    if found.dtype != stored:
        raise DamageError(f"has {name} of another kind: {found.dtype}, not {stored}")
    if found.shape != wanted.shape:
        raise DamageError(f"has {name} of another shape: {found.shape}, not {wanted.shape}")
    if wanted.dims and wanted.dims != (name,):
        dims = tuple(scale[0].name.rpartition("/")[2] if len(scale) == 1 else "" for scale in found.dims)
        if dims != wanted.dims:
            raise DamageError(f"has {name} over other dimensions: {', '.join(dims)}")
    return np.asarray(found[...], wanted.dtype)


def _is_exact(file: h5py.File, name: str, wanted: Array, values: NDArray[Any]) -> bool:
    """Whether a coordinate is that of the study to the last bit; an error if it is another one."""
    if wanted.dtype.kind == "U":
        found = _variable(file, name)
        is_text = h5py.check_string_dtype(found.dtype) and found.shape == values.shape
        is_exact = is_same = bool(is_text) and found.asstr()[...].tolist() == values.tolist()
    else:
        numbers = _values(file, name, wanted)
        is_exact = np.array_equal(numbers, values)
        is_same = is_exact or np.allclose(numbers, values, rtol=SAME, atol=0)
    if not is_same:
        raise DamageError(f"has another {name} than its study")
    return bool(is_exact)


def _about(file: h5py.File) -> About:
    """What a file says of measured bodies."""
    scalar = Array((), (), np.dtype(np.float64), {})
    area = float(_values(file, "nominal_area", scalar))
    if not 0 < area < LARGEST:
        raise DamageError(f"has a nominal_area of {area}")
    said: dict[str, Any] = {}
    for name in TEXT_OF_BODIES:
        said[name] = file.attrs.get(name)
        if not isinstance(said[name], str):
            raise DamageError(f"does not say what its {name} body is")
    for name in NUMBERS_OF_BODIES:
        said[name] = _numbers_of(file, name)
        if not (said[name] > 0).all():
            raise DamageError(f"has a {name} of {said[name].tolist()}")
    return About(nominal_area=area, attributes=said)


def _numbers_of(file: h5py.File, name: str, *, unknown: bool = False) -> NDArray[Any]:
    """An attribute that is a number, or two; NaN where it may be unknown."""
    numbers: NDArray[Any] = np.atleast_1d(file.attrs.get(name, ""))
    if numbers.dtype.kind not in "if" or numbers.shape not in ((1,), (2,)):
        raise DamageError(f"has no {name} of its bodies")
    if not ((np.abs(numbers) < LARGEST) | (np.isnan(numbers) & unknown)).all():
        raise DamageError(f"has a {name} of {numbers.tolist()}")
    return numbers


def _check_range(name: str, values: NDArray[Any], wanted: Array, surrogate: NDArray[np.bool_] | None) -> None:
    """No number that no computation gives; NaN is what has no answer."""
    if name in ("x", "y") and surrogate is not None:
        is_wrong = np.isnan(values) & ~surrogate
    elif values.dtype.kind == "i":
        is_wrong = (values < 0) | (values >= len(wanted.attributes.get("flag_values", range(2**63 - 1))))
    elif name.startswith(("share_", "fraction_")) or "_share_" in name:
        is_wrong = (values < -SAME) | (values > 1 + SAME)
    elif name in ("contact_area", "normal_elastic"):
        is_wrong = values < 0
    else:
        is_wrong = np.zeros(1, np.bool_)
    if values.dtype.kind == "f":
        is_wrong = is_wrong | (np.abs(values) > LARGEST)
    if is_wrong.any():
        raise DamageError(f"has a {name} that cannot be: {values[np.broadcast_to(is_wrong, values.shape)][0]}")
