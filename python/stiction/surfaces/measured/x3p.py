"""Heights in X3P files: a zip archive with main.xml and binary data, ISO 25178-72."""

from __future__ import annotations

import hashlib
import io
import math
import re
import zipfile
from typing import Any
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.surfaces.measured.raw import MOST_TEXT_BYTES, Caveat, FormatError, Raw, Source, chunks
from stiction.surfaces.profile import MAX_POINTS

_TYPES = {"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}
_MAIN = "main.xml"

_NUMBER = re.compile(r"[+-]?([0-9]{1,400}(\.[0-9]{0,400})?|\.[0-9]{1,400})(e[+-]?[0-9]{1,9})?|[+-]?inf|nan", re.I)
"""Numbers as XML Schema writes them: no underscores, and no digits of other scripts."""

_MOST_WORDS = 4_000_000  # bytes of main.xml, but for the points that it lists
_MOST_ELEMENTS = 100_000  # largest size of main.xml without its points
_BYTES_OF_A_POINT = 200
_SPARE = 64  # bytes of bits beyond the last point
_DEEPEST = 6


def read_x3p(data: bytes) -> Raw:
    """Take an X3P file apart; its lengths are in metres."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return _read(archive)
    except FormatError:
        raise
    except Exception as error:  # zipfile and zlib have many ways to fail
        raise FormatError(f"is a damaged X3P file ({type(error).__name__}: {str(error)[:80]})") from None


def _read(archive: zipfile.ZipFile) -> Raw:
    mains = [name for name in archive.namelist() if name.rpartition("/")[2] == _MAIN and name.count("/") <= 1]
    if not mains:
        raise FormatError(f"is a zip archive without {_MAIN}, so no X3P file")
    folder = min(mains, key=len).removesuffix(_MAIN)  # some programs put all into a folder
    root = _Main(archive, folder)
    feature = _text(root, "Record1/FeatureType")
    if feature not in ("PRF", "SUR"):
        raise FormatError(f"holds the feature type {feature!r}; profiles (PRF) and surfaces (SUR) can be read")
    axes = {name: _Axis(root, name) for name in "XYZ"}
    shape = _shape(root)
    points = math.prod(shape)
    if not 0 < points <= MAX_POINTS:
        raise FormatError(f"says it holds {points} points; from 1 to {MAX_POINTS} can be read")
    absolute = [name for name in "XYZ" if axes[name].absolute]
    if "Z" not in absolute:
        raise FormatError("has heights that are incremental, which X3P does not allow")
    if feature == "SUR" and absolute != ["Z"]:
        raise FormatError("holds a surface that is not on a grid, with a position for each point; it cannot be read")
    columns = _columns(archive, root, {name: axes[name].stored for name in absolute}, points)
    heights = axes["Z"].lengths(columns["Z"])
    if (link := _text(root, "Record3/DataLink/ValidPointsLink", "")) != "":
        bits = np.frombuffer(b"".join(chunks(archive, root.folder + link, points // 8 + _SPARE)), dtype=np.uint8)
        if bits.size * 8 < points:
            raise FormatError(f"says which of {points} points are valid in only {bits.size} bytes")
        heights[np.unpackbits(bits, count=points, bitorder="little") == 0] = np.nan
    caveats = tuple(caveat for name in absolute for caveat in axes[name].caveats)
    common: dict[str, Any] = {"unit": "m", "position_unit": "m", "caveats": caveats, "source": Source("X3P")}
    if feature == "SUR":
        return Raw(heights.reshape(shape), spacing=(axes["Y"].increment, axes["X"].increment), **common)
    if shape[0] != 1:
        raise FormatError(f"holds {shape[0]} profiles; one can be read")
    if "Y" in absolute and np.ptp(axes["Y"].lengths(columns["Y"])) > 0:
        raise FormatError("holds a profile whose points move along y as well; one along x can be read")
    if "X" in absolute:
        positions = axes["X"].lengths(columns["X"])
        increment = abs(axes["X"].increment)
        digit = {
            "<f4": np.spacing(np.abs(positions).astype(np.float32)).astype(np.float64), "<f8": np.zeros(points),
        }.get(axes["X"].stored, np.full(points, increment))  # fmt: skip
        return Raw(heights, positions=positions, digits=lambda: digit, **common)
    return Raw(heights, spacing=(axes["X"].increment,), **common)


class _Main:
    """The texts of main.xml by their paths below the root, and the points that it lists; no document type, no bombs."""

    def __init__(self, archive: zipfile.ZipFile, folder: str) -> None:
        self.folder = folder
        self.texts: dict[str, str] = {}
        self.listed: list[str] | None = None
        self._path: list[str] = []
        self._words: list[str] = []
        self._elements = 0
        parser = expat.ParserCreate(namespace_separator="}")  # some programs give all elements a namespace
        parser.buffer_text = True
        parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = self._refuse
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._words.append
        read = 0
        for chunk in chunks(archive, folder + _MAIN, MOST_TEXT_BYTES):
            parser.Parse(chunk)
            read += len(chunk)
            if read > _MOST_WORDS + (0 if self.listed is None else _BYTES_OF_A_POINT * math.prod(_shape(self))):
                raise FormatError(f"has a {_MAIN} of more than {read - len(chunk)} bytes, which its points do not need")
        parser.Parse(b"", True)

    def _refuse(self, *_: object) -> None:
        raise FormatError(f"has a document type of its own in {_MAIN}, which X3P has not")

    def _start(self, tag: str, _: object) -> None:
        name = tag.rpartition("}")[2]
        self._path.append(name)
        self._words.clear()
        if name == "DataList":
            self.listed = []
        if name != "Datum":
            self._elements += 1
            if self._elements > _MOST_ELEMENTS:
                raise FormatError(f"has more than {_MOST_ELEMENTS} elements in {_MAIN}")

    def _end(self, _: str) -> None:
        text = "".join(self._words)
        self._words.clear()
        if self._path[-1] == "Datum" and self.listed is not None:
            self.listed.append(text.strip())
        elif len(self._path) <= _DEEPEST:
            self.texts.setdefault("/".join(self._path[1:]), text)
        self._path.pop()


class _Axis:
    """How positions along one axis are stored."""

    def __init__(self, root: _Main, name: str) -> None:
        path = f"Record1/Axes/C{name}"
        kind = _text(root, f"{path}/AxisType", "I" if name != "Z" else "A")
        stored = _text(root, f"{path}/DataType", "D")
        if kind not in ("I", "A") or stored not in _TYPES:
            raise FormatError(
                f"has a {name} axis of type {kind!r} stored as {stored!r}; I or A, stored as I, L, F or D, is allowed"
            )
        self.absolute = kind == "A"
        self.stored = _TYPES[stored]
        self.increment = _number(root, f"{path}/Increment", math.nan)
        self.caveats: tuple[Caveat, ...] = ()
        if self.absolute and stored in ("F", "D"):  # lengths that need no factor
            if abs(self.increment) > 0 and self.increment != 1:
                self.caveats = (
                    Caveat(
                        "x3p-increment",
                        f"{name} is stored in floating point, as metres, and has an increment of {self.increment:g}, "
                        "which is not applied",
                        "compare a height with that of another program; if it agrees, "
                        "accept it (--accept x3p-increment)",
                    ),
                )
            self.increment = 1.0
        elif self.absolute and not abs(self.increment) > 0:
            raise FormatError(f"has whole numbers for {name}, but no Increment to multiply them by")
        self.offset = _number(root, f"{path}/Offset", 0.0)

    def lengths(self, stored: NDArray[Any]) -> Floats:
        with np.errstate(all="ignore"):
            return stored.astype(np.float64) * self.increment + self.offset


def _shape(root: _Main) -> tuple[int, int]:
    """Rows and columns."""
    if (listed := _text(root, "Record3/ListDimension", "")) != "":
        return 1, _count(listed)
    x, y, z = (_count(_text(root, f"Record3/MatrixDimension/Size{name}")) for name in "XYZ")
    if z != 1:
        raise FormatError(f"holds {z} layers; one can be read")
    return y, x


def _columns(archive: zipfile.ZipFile, root: _Main, stored: dict[str, str], points: int) -> dict[str, NDArray[Any]]:
    """What is stored of each point, by axis."""
    if root.listed is not None:
        return _listed(root.listed, list(stored), points)
    kind = np.dtype(list(stored.items()))
    link, wanted = root.folder + _text(root, "Record3/DataLink/PointDataLink"), points * kind.itemsize
    size = archive.getinfo(link).file_size if link in archive.namelist() else wanted
    data = b"".join(chunks(archive, link, wanted)) if size == wanted else b""
    if len(data) != wanted:
        raise FormatError(f"says it holds {points} points of {kind.itemsize} bytes, but has {len(data) or size} bytes")
    checksum = _text(root, "Record3/DataLink/MD5ChecksumPointData", "").lower()
    if checksum not in ("", hashlib.md5(data, usedforsecurity=False).hexdigest()):
        raise FormatError("is damaged: its heights do not have the checksum that it gives")
    table = np.frombuffer(data, dtype=kind)
    return {name: table[name] for name in stored}


def _listed(rows: list[str], absolute: list[str], points: int) -> dict[str, NDArray[Any]]:
    """Points that are written out: a text each, the axes separated by semicolons, empty if the point is missing."""
    if len(rows) != points:
        raise FormatError(f"says it holds {points} points, but lists {len(rows)}")
    columns: dict[str, NDArray[Any]] = {name: np.full(points, np.nan) for name in absolute}
    for at, row in enumerate(rows):
        cells = [cell.strip() for cell in row.split(";")]
        cells = [cell for cell in cells if cell] if len(cells) > len(absolute) else cells
        if not row:
            continue
        if len(cells) != len(absolute):
            raise FormatError(f"lists {row[:40]!r} as point {at}, from 0 on; {len(absolute)} number(s) are needed")
        for name, cell in zip(absolute, cells, strict=True):
            columns[name][at] = _float(cell)
    return columns


def _text(root: _Main, path: str, otherwise: str | None = None) -> str:
    text = root.texts.get(path, "").strip()
    if text:
        return text
    if otherwise is None:
        raise FormatError(f"lacks {path} in {_MAIN}")
    return otherwise


def _number(root: _Main, path: str, otherwise: float) -> float:
    text = _text(root, path, "")
    return _float(text) if text else otherwise


def _float(text: str) -> float:
    if _NUMBER.fullmatch(text) is None:
        raise FormatError(f"has {text[:40]!r} where a number should be")
    return float(text)


def _count(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 12):
        raise FormatError(f"has {text[:40]!r} where a number of points should be")
    return int(text)
