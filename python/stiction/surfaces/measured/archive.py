"""Members of zip archives from strangers, read no further than was agreed."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator

from stiction.surfaces.measured.raw import FormatError

_CHUNK = 1 << 16
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""Methods of compression that unpack no more than is asked for at a time."""


def chunks(archive: zipfile.ZipFile, name: str, most: int) -> Iterator[bytes]:
    """A member piece by piece, at most so many bytes, whatever the archive's directory says of its size."""
    try:
        info = archive.getinfo(name)
    except KeyError:
        raise FormatError(f"lacks {name[:80]!r}, where its data should be") from None
    if info.compress_type not in _METHODS:
        raise FormatError(f"holds {name[:80]!r} compressed by another method than deflate")
    if info.file_size > most:
        raise FormatError(f"holds {name[:80]!r} of {info.file_size} bytes; at most {most} can be read")
    total = 0
    with archive.open(info) as member:
        while chunk := member.read(_CHUNK):
            total += len(chunk)
            if total > most:
                raise FormatError(f"holds {name[:80]!r} of more than {most} bytes")
            yield chunk
