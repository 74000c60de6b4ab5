"""The files of a store: what they are called, what is in them, and how they come to be.

It is a group of Zarr 3, whose metadata are a few lines of JSON (Zarr core specification 3.0); tests hold them to what
Zarr writes. Zarr itself takes longer to be imported than to compute a small study, and several times as long over small
chunks; it reads a chunk that is missing as fill values, and not all of its versions rename.
"""

from __future__ import annotations

import json
import math
import re
import struct
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numcodecs
import numpy as np
from numpy.typing import NDArray

from stiction._files import HALF_WRITTEN, NotReadableError, content
from stiction.studies.dataset import Array, attributes_of_result, coordinates_of, variables_of
from stiction.studies.study import Study

SCHEMA = 2
"""Of the layout of a store; what a newer one means is not known here. In schema 1 every chunk is one repetition."""

COMPLETE = "complete"
METADATA = "zarr.json"
BLOCK = "repetitions_per_chunk"
"""Attribute of the root."""

FILL = {"f": np.nan, "i": -1, "b": False}
"""By kind of number, where a repetition is missing: whoever opens an unfinished store with something else sees no
zeros that look like results."""

PARTIAL = ".partial"
"""Of a store that is being begun."""

MOST_METADATA = 16 * 2**20
"""Bytes of a file of metadata: a study of the longest lists takes a twentieth."""

MOST_IN_CHUNK = 2**20
"""Bytes."""

FEWEST_BLOCKS = 512
"""Of a study that has so many repetitions: workers compute blocks, and the last ones should not wait for each other."""

_REPETITIONS_IN_CHUNK = 4096
"""Of the coordinate, whose chunks must not depend on how many there are."""

_LEVEL = -1
"""Of compression: sums hardly compress, and 0, which stands for 3, takes 3.5 times as long for a twentieth less."""

_zstd = numcodecs.Zstd(level=_LEVEL, checksum=True)  # without the checksum a flipped bit is a wrong number


def block_of(study: Study) -> int:
    """Repetitions in a chunk of a new store, a power of two: one where a study has few, or where they are large."""
    largest = max(each.size for each in variables_of(study, [0]).values())
    most = max(1, min(study.ensemble.repetitions // FEWEST_BLOCKS, MOST_IN_CHUNK // largest))
    return 1 << (most.bit_length() - 1)


def layout(study: Study, block: int, attributes: Mapping[str, Any] | None = None) -> dict[str, bytes]:
    """Every file of a store but the repetitions themselves, the root's metadata last.

    What an existing root says stays: the schema and the versions it was begun with, and what others added to it.
    """
    said = attributes_of_result(study)
    identity = {"stiction_schema": SCHEMA, BLOCK: block, "numpy_version": np.__version__}
    root = said | (identity if attributes is None else dict(attributes)) | {"study": said["study"]}
    flags = Array(
        ("repetition",), (study.ensemble.repetitions,), np.dtype(np.bool_), {"long_name": "whether it is finished"}
    )
    files = {}
    for name, each in {**variables_of(study), COMPLETE: flags}.items():
        files[f"{name}/{METADATA}"] = _metadata_of(each, block)
    for name, (each, values) in coordinates_of(study).items():
        if each.dtype.kind != "U":  # words, which the study says and Zarr 3 has no settled format for
            files[f"{name}/{METADATA}"] = _metadata_of(each, _REPETITIONS_IN_CHUNK)
            length = _REPETITIONS_IN_CHUNK if name == "repetition" else values.size
            for first in range(0, values.size, length):
                part = values[first : first + length]
                whole = np.full(length, FILL[each.dtype.kind], each.dtype)
                whole[: part.size] = part
                files[f"{name}/c.{first // length}"] = _compressed(whole)
    last = f"{COMPLETE}/{METADATA}"
    files[last] = files.pop(last)
    said_of_root = {"attributes": root | {"checksum": checksum(root)}, "zarr_format": 3, "node_type": "group"}
    return files | {METADATA: _json(said_of_root)}


def _metadata_of(array: Array, in_chunk: int) -> bytes:
    """Of an array whose chunks have so many repetitions, and all of the other dimensions."""
    chunk = [in_chunk if dim == "repetition" else size for dim, size in zip(array.dims, array.shape, strict=True)]
    fill = FILL[array.dtype.kind]
    endian = {} if array.dtype.itemsize == 1 else {"configuration": {"endian": "little"}}
    return _json({
        "shape": list(array.shape),
        "data_type": array.dtype.name,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunk}},
        # A file, not a directory, of each block.
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
        "fill_value": "NaN" if fill != fill else fill,
        "codecs": [
            {"name": "bytes", **endian},
            {"name": "zstd", "configuration": {"level": _LEVEL, "checksum": True}},
        ],
        "attributes": array.attributes,
        "dimension_names": list(array.dims),
        "zarr_format": 3,
        "node_type": "array",
        "storage_transformers": [],
    })  # fmt: skip


def _json(said: dict[str, Any]) -> bytes:
    return json.dumps(said, indent=2).encode()


def checksum(attributes: Mapping[str, Any]) -> str:
    """Of what a result is of: metadata have no checksum of their own, and a flipped bit would be another seed."""
    said = [attributes.get(name) for name in ("study", "stiction_version", "stiction_schema")]
    said += [attributes[BLOCK]] if BLOCK in attributes else []
    return f"{zlib.crc32(json.dumps(said).encode()):08x}"


def chunk(block: int, dimensions: int = 4) -> str:
    """File of a block of repetitions in the directory of a variable, whose third dimension they are."""
    return f"c.0.0.{block}" + (dimensions - 3) * ".0"


def is_known(name: str) -> bool:
    """Whether a name in a directory of a store is one that is given here, or what is left of writing it."""
    return name == METADATA or bool(_CHUNK.fullmatch(name)) or is_left_behind(name) or is_lock(name)


def is_lock(name: str) -> bool:
    """Whether a name is that of a lock, which lies among the flags while somebody writes."""
    return bool(_LOCK.fullmatch(name))


def is_left_behind(name: str) -> bool:
    """Whether a name is that of a file whose writer was killed."""
    return bool(HALF_WRITTEN.fullmatch(name) or _LEFT.fullmatch(name))


_CHUNK = re.compile(r"c(\.[0-9]{1,18}){1,6}")
_LOCK = re.compile(r"(block-[0-9]{1,18}|part-[0-9]{1,9}-of-[0-9]{1,9}|writer-[0-9a-f]{16})\.lock")
_LEFT = re.compile(r"(c(\.[0-9]{1,18}){1,4}|zarr\.json)\.partial")  # by versions that named it so


# ---- Metadata -------------------------------------------------------------------------------------------------------


class DecodingError(Exception):
    """A file that is not what was written."""


def metadata(file: Path) -> dict[str, Any]:
    """What a file of metadata says.

    Raises
    ------
    DecodingError
        If it is no regular file, or is not what was written.
    OSError
        If it cannot be read.
    """
    try:
        said = json.loads(_content(file, MOST_METADATA))
    except (ValueError, RecursionError):
        raise DecodingError("not what was written") from None
    if not isinstance(said, dict):
        raise DecodingError("not what was written")
    return said


def _content(file: Path, most: int) -> bytes:
    try:
        return content(file, most, link=False)
    except NotReadableError as error:
        raise DecodingError(str(error)) from None


# ---- Chunks ---------------------------------------------------------------------------------------------------------

_SKIPPED = 0x184D2A50
"""How a frame begins that every decoder of Zstandard leaves out: here the chunk's own name, variable/c.0.0.7.0."""


def decoded(file: Path, dtype: np.dtype[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """What `encoded` put into a file.

    Raises
    ------
    DecodingError
        If it is no regular file, is another chunk's, or is not what was written; no more memory is taken than the
        shape needs.
    OSError
        If it cannot be read.
    """
    size = dtype.itemsize * math.prod(shape)
    # What compression can add is a 256th at most.
    written = _content(file, size + size // 128 + 1000)
    try:
        said, end = _frame(written)
    except (IndexError, struct.error):
        raise DecodingError("not what was written") from None
    if said != size:
        raise DecodingError("not of the size that its study says")
    if end < len(written) and written[end:] != _name_frame(file):  # without a name by a version that wrote none
        raise DecodingError("not what was written, or another chunk's")
    values = np.empty(size, np.uint8)
    try:
        _zstd.decode(written[:end], values)
    except (RuntimeError, ValueError):
        raise DecodingError("not what was written") from None
    return values.view(dtype.newbyteorder("<")).reshape(shape)


def encoded(file: Path, values: NDArray[Any]) -> bytes:
    """Content of the file of a chunk."""
    return _compressed(values) + _name_frame(file)


def _compressed(values: NDArray[Any]) -> bytes:
    return bytes(_zstd.encode(np.ascontiguousarray(values, values.dtype.newbyteorder("<"))))


def _name_frame(file: Path) -> bytes:
    name = f"{file.parent.name}/{file.name}".encode()
    return struct.pack("<II", _SKIPPED, len(name)) + name


def _frame(written: bytes) -> tuple[int | None, int]:
    """Size of what a Zstandard frame holds (None if it does not say), and where the frame ends: RFC 8878, 3.1.1."""
    (magic,) = struct.unpack_from("<I", written)
    if magic != 0xFD2FB528:
        raise IndexError
    descriptor = written[4]
    single, checksum = descriptor >> 5 & 1, descriptor >> 2 & 1
    at = 5 + (not single) + (0, 1, 2, 4)[descriptor & 3]
    width = (single, 2, 4, 8)[descriptor >> 6]
    size = int.from_bytes(written[at : at + width], "little") + (256 if width == 2 else 0) if width else None
    at += width
    last = False
    while not last:
        header = int.from_bytes(written[at : at + 3], "little")
        last, kind, length = bool(header & 1), header >> 1 & 3, header >> 3
        if at + 3 > len(written):
            raise IndexError
        at += 3 + (1 if kind == 1 else length)  # of a byte that is repeated only the byte itself
    return size, at + 4 * checksum
