"""The files of a store: what they are called, what is in them, and how they come to be.

Zarr itself lays the store out. Chunks are written and read here: Zarr takes several times as long over small ones,
reads a chunk that is missing as fill values, and not all of its versions rename.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numcodecs
import numpy as np
import xarray
import zarr
from numpy.typing import NDArray
from zarr.codecs import ZstdCodec

SCHEMA = 1
"""Of the layout of a store; what a newer one means is not known here."""

COMPLETE = "complete"
METADATA = "zarr.json"
PARTIAL = ".partial"
_REPETITIONS_IN_CHUNK = 4096
"""Of the coordinate, whose chunks must not depend on how many there are."""

_LEVEL = 0
_zstd = numcodecs.Zstd(level=_LEVEL, checksum=True)  # without the checksum a flipped bit is a wrong number


def layout(dataset: xarray.Dataset, attributes: Mapping[str, Any] | None = None) -> dict[str, bytes]:
    """Every file of a store but the repetitions themselves, the root's metadata last."""
    identity = {"stiction_schema": SCHEMA, "numpy_version": np.__version__, "zarr_version": zarr.__version__}
    # What an existing root says stays: the versions it was begun with, and what others added to it.
    root = dataset.attrs | identity | dict(attributes or {}) | {"study": dataset.attrs["study"]}
    files: dict[str, Any] = {}
    group = zarr.create_group(
        zarr.storage.MemoryStore(files), zarr_format=3, attributes=root | {"checksum": checksum(root)}
    )
    repetitions = dataset.sizes["repetition"]
    complete = xarray.Variable("repetition", np.zeros(repetitions, np.bool_), {"long_name": "whether it is finished"})
    for name, variable in {**dataset.variables, COMPLETE: complete}.items():
        chunks = {"repetition": _REPETITIONS_IN_CHUNK} if name == "repetition" else {"repetition": 1}
        array = group.create_array(
            str(name),
            shape=variable.shape,
            dtype=variable.dtype,
            chunks=tuple(chunks.get(str(dim), size) for dim, size in variable.sizes.items()),
            # Whoever opens an unfinished store with something else sees no zeros that look like results.
            fill_value={"f": np.nan, "i": -1, "b": False}[variable.dtype.kind],
            compressors=ZstdCodec(level=_LEVEL, checksum=True),
            chunk_key_encoding={"name": "default", "separator": "."},  # a file, not a directory, of each repetition
            dimension_names=[str(dim) for dim in variable.dims],
            attributes=variable.attrs,
        )
        if name in dataset.coords:
            array[...] = variable.values
    contents = {name: buffer.to_bytes() for name, buffer in files.items()}
    last = (f"{COMPLETE}/{METADATA}", METADATA)
    return dict(sorted(contents.items(), key=lambda item: last.index(item[0]) if item[0] in last else -1))


def checksum(attributes: Mapping[str, Any]) -> str:
    """Of what a result is of: metadata have no checksum of their own, and a flipped bit would be another seed."""
    said = [attributes.get(name) for name in ("study", "stiction_version", "stiction_schema")]
    return f"{zlib.crc32(json.dumps(said).encode()):08x}"


def chunk(repetition: int) -> str:
    """File of a repetition in the directory of a variable."""
    return f"c.0.0.{repetition}.0"


class DecodingError(Exception):
    """A file that is not what was written."""


def decoded(file: Path, dtype: np.dtype[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """What `encoded` put into a file."""
    content = file.read_bytes()
    try:
        values = _zstd.decode(content)
    except (RuntimeError, ValueError, MemoryError):
        raise DecodingError("not what was written") from None
    if len(values) != dtype.itemsize * int(np.prod(shape)):
        raise DecodingError("not of the size that its study says")
    return np.frombuffer(values, dtype.newbyteorder("<")).reshape(shape)


def encoded(values: NDArray[Any]) -> bytes:
    """Content of the file of a chunk."""
    return bytes(_zstd.encode(np.ascontiguousarray(values, values.dtype.newbyteorder("<"))))


def replace(file: Path, content: bytes) -> None:
    """Write a file that appears under its name when it is whole."""
    partial = file.with_name(f"{file.name}{PARTIAL}")
    try:
        partial.write_bytes(content)
        partial.replace(file)
    except OSError:
        with suppress(OSError):
            partial.unlink(missing_ok=True)
        raise
