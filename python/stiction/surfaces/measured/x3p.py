"""Reader for X3P files (ISO 25178-72), which are zip archives of main.xml and binary data."""

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
from stiction.surfaces.measured.raw import (
    MAX_TEXT_BYTES,
    FileCaveat,
    FormatError,
    HeightProvenance,
    RawHeights,
    check_point_count,
    parse_positive_number,
    read_member_chunks,
)
from stiction.surfaces.profile import MAX_POINTS

_STORED_NUMBER_TYPES = {"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}
_MAIN_XML_FILE = "main.xml"

_XML_NUMBER_PATTERN = re.compile(
    r"[+-]?([0-9]{1,400}(\.[0-9]{0,400})?|\.[0-9]{1,400})(e[+-]?[0-9]{1,9})?|[+-]?inf|nan", re.I
)
"""Regular expression for numbers in XML Schema, which have ASCII digits and no underscores."""

# Maximum size (bytes) of main.xml, and maximum number of its XML elements, not counting points listed in main.xml.
_MAX_MAIN_XML_BYTES = 4_000_000
_MAX_XML_ELEMENTS = 100_000
_MAX_BYTES_PER_POINT = 200
_MAX_SPARE_MASK_BYTES = 64
_MAX_XML_DEPTH = 6


def read_x3p(data: bytes) -> RawHeights:
    """Read the heights of an X3P file, together with the positions or the spacings of the points.

    Lengths in the file are in metres.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return _read_archive(archive)
    except FormatError:
        raise
    except Exception as error:
        # The modules zipfile and zlib raise many classes of errors for a corrupt archive.
        raise FormatError(f"is a damaged X3P file ({type(error).__name__}: {str(error)[:80]})") from None


def _read_archive(archive: zipfile.ZipFile) -> RawHeights:
    main_xml_names = [
        name for name in archive.namelist() if name.rpartition("/")[2] == _MAIN_XML_FILE and name.count("/") <= 1
    ]
    if not main_xml_names:
        raise FormatError(f"is a zip archive without {_MAIN_XML_FILE}, so it is not an X3P file")
    # Some programs store all files of an X3P archive in a subdirectory.
    directory = min(main_xml_names, key=len).removesuffix(_MAIN_XML_FILE)
    root = _MainXml(archive, directory)
    feature = _get_element_text(root, "Record1/FeatureType")
    if feature not in ("PRF", "SUR"):
        raise FormatError(f"contains the feature type {feature!r}; only profiles (PRF) and surfaces (SUR) can be read")
    axes = {name: _StoredAxis(root, name) for name in "XYZ"}
    shape = _read_shape(root)
    points = math.prod(shape)
    if not 0 < points <= MAX_POINTS:
        raise FormatError(f"declares {points} points; between 1 and {MAX_POINTS} can be read")
    absolute_axes = [name for name in "XYZ" if axes[name].is_absolute]
    if "Z" not in absolute_axes:
        raise FormatError("has incremental heights, which X3P does not allow")
    if feature == "SUR" and absolute_axes != ["Z"]:
        raise FormatError("contains a point cloud, a surface with coordinates for each point; only grids can be read")
    columns = _read_columns(archive, root, {name: axes[name].stored for name in absolute_axes}, points)
    heights = axes["Z"].to_lengths(columns["Z"])
    if (mask_link := _get_element_text(root, "Record3/DataLink/ValidPointsLink", "")) != "":
        valid_bits = np.frombuffer(
            b"".join(read_member_chunks(archive, root.directory + mask_link, points // 8 + _MAX_SPARE_MASK_BYTES)),
            dtype=np.uint8,
        )
        if valid_bits.size * 8 < points:
            raise FormatError(
                f"has a mask of valid points of only {valid_bits.size} bytes, which is too short for {points} points"
            )
        heights[np.unpackbits(valid_bits, count=points, bitorder="little") == 0] = np.nan
    caveats = tuple(caveat for name in absolute_axes for caveat in axes[name].caveats)
    common_arguments: dict[str, Any] = {
        "unit": "m",
        "position_unit": "m",
        "caveats": caveats,
        "source": HeightProvenance("X3P"),
    }
    if feature == "SUR":
        return RawHeights(
            heights.reshape(shape), spacing=(axes["Y"].increment, axes["X"].increment), **common_arguments
        )
    if shape[0] != 1:
        raise FormatError(f"contains {shape[0]} profiles; only one can be read")
    if "Y" in absolute_axes and np.ptp(axes["Y"].to_lengths(columns["Y"])) > 0:
        raise FormatError("contains a profile whose y coordinate varies; only profiles along x can be read")
    if "X" in absolute_axes:
        positions = axes["X"].to_lengths(columns["X"])
        increment = abs(axes["X"].increment)
        digit_values = {
            "<f4": np.spacing(np.abs(positions).astype(np.float32)).astype(np.float64), "<f8": np.zeros(points),
        }.get(axes["X"].stored, np.full(points, increment))  # fmt: skip
        return RawHeights(heights, positions=positions, digits=lambda: digit_values, **common_arguments)
    return RawHeights(heights, spacing=(axes["X"].increment,), **common_arguments)


class _MainXml:
    """Contents of main.xml in an X3P file: texts keyed by XML path, and the points that main.xml may list."""

    def __init__(self, archive: zipfile.ZipFile, directory: str) -> None:
        self.directory = directory
        self.texts: dict[str, str] = {}
        self.listed_points: list[str] | None = None
        self._element_path: list[str] = []
        self._words: list[str] = []
        self._element_count = 0
        # Some programs add an XML namespace to all elements.
        parser = expat.ParserCreate(namespace_separator="}")
        parser.buffer_text = True
        parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = self._reject_document_type
        parser.StartElementHandler = self._handle_start_tag
        parser.EndElementHandler = self._handle_end_tag
        parser.CharacterDataHandler = self._words.append
        num_bytes = 0
        for chunk in read_member_chunks(archive, directory + _MAIN_XML_FILE, MAX_TEXT_BYTES):
            parser.Parse(chunk)
            num_bytes += len(chunk)
            if num_bytes > _MAX_MAIN_XML_BYTES + (
                0 if self.listed_points is None else _MAX_BYTES_PER_POINT * math.prod(_read_shape(self))
            ):
                raise FormatError(
                    f"has a {_MAIN_XML_FILE} of more than {num_bytes - len(chunk)} bytes, too many for its points"
                )
        parser.Parse(b"", True)

    def _reject_document_type(self, *_: object) -> None:
        raise FormatError(f"has a document type declaration in {_MAIN_XML_FILE}, which X3P does not allow")

    def _handle_start_tag(self, tag: str, _: object) -> None:
        name = tag.rpartition("}")[2]
        self._element_path.append(name)
        self._words.clear()
        if name == "DataList":
            self.listed_points = []
        if name != "Datum":
            self._element_count += 1
            if self._element_count > _MAX_XML_ELEMENTS:
                raise FormatError(f"has more than {_MAX_XML_ELEMENTS} elements in {_MAIN_XML_FILE}")

    def _handle_end_tag(self, _: str) -> None:
        text = "".join(self._words)
        self._words.clear()
        if self._element_path[-1] == "Datum" and self.listed_points is not None:
            self.listed_points.append(text.strip())
        elif len(self._element_path) <= _MAX_XML_DEPTH:
            self.texts.setdefault("/".join(self._element_path[1:]), text)
        self._element_path.pop()


class _StoredAxis:
    """Storage format of one axis (x, y or z) in an X3P file: data type, increment and offset."""

    def __init__(self, root: _MainXml, name: str) -> None:
        path = f"Record1/Axes/C{name}"
        kind = _get_element_text(root, f"{path}/AxisType", "I" if name != "Z" else "A")
        stored_type = _get_element_text(root, f"{path}/DataType", "D")
        if kind not in ("I", "A") or stored_type not in _STORED_NUMBER_TYPES:
            raise FormatError(
                f"has a {name} axis with axis type {kind!r} and data type {stored_type!r}; the axis type must be "
                "I (incremental) or A (absolute), and the data type I, L, F or D"
            )
        self.is_absolute = kind == "A"
        self.stored = _STORED_NUMBER_TYPES[stored_type]
        self.increment = _parse_element_number(root, f"{path}/Increment", math.nan)
        self.caveats: tuple[FileCaveat, ...] = ()
        # The increment in an X3P file does not apply to lengths stored as floating-point numbers.
        if self.is_absolute and stored_type in ("F", "D"):
            if abs(self.increment) > 0 and self.increment != 1:
                self.caveats = (
                    FileCaveat(
                        "x3p-increment",
                        f"{name} is stored in floating point, as metres, and has an increment of {self.increment:g}, "
                        "which is not applied",
                        "compare a height with the same height in another program; if they agree, accept it (--accept "
                        "x3p-increment)",
                    ),
                )
            self.increment = 1.0
        elif self.is_absolute and not abs(self.increment) > 0:
            raise FormatError(f"stores {name} as integers, but has no Increment that scales them")
        elif name == "Z":
            # A negative height factor would turn the heights upside down.
            self.increment = parse_positive_number(
                _get_element_text(root, f"{path}/Increment"), f"for {path}/Increment"
            )
        self.offset = _parse_element_number(root, f"{path}/Offset", 0.0)

    def to_lengths(self, stored: NDArray[Any]) -> Floats:
        with np.errstate(all="ignore"):
            return stored.astype(np.float64) * self.increment + self.offset


def _read_shape(root: _MainXml) -> tuple[int, int]:
    """Return the number of rows and the number of columns of the heights in an X3P file."""
    if (list_dimension := _get_element_text(root, "Record3/ListDimension", "")) != "":
        return 1, _parse_count(list_dimension)
    x, y, z = (_parse_count(_get_element_text(root, f"Record3/MatrixDimension/Size{name}")) for name in "XYZ")
    if z != 1:
        raise FormatError(f"contains {z} layers; only one can be read")
    return y, x


def _read_columns(
    archive: zipfile.ZipFile, root: _MainXml, stored: dict[str, str], points: int
) -> dict[str, NDArray[Any]]:
    """Read the coordinates of all points from an X3P file: one array per axis, keyed by axis name."""
    if root.listed_points is not None:
        return _parse_listed_points(root.listed_points, list(stored), points)
    row_type = np.dtype(list(stored.items()))
    data_link, num_bytes = (
        root.directory + _get_element_text(root, "Record3/DataLink/PointDataLink"),
        points * row_type.itemsize,
    )
    stored_bytes = num_bytes
    if data_link in archive.namelist():
        member = archive.getinfo(data_link)
        stored_bytes = member.file_size
        check_point_count(points, member.compress_size)
    data = b"".join(read_member_chunks(archive, data_link, num_bytes)) if stored_bytes == num_bytes else b""
    if len(data) != num_bytes:
        raise FormatError(
            f"declares {points} points of {row_type.itemsize} bytes, but has {len(data) or stored_bytes} bytes"
        )
    checksum = _get_element_text(root, "Record3/DataLink/MD5ChecksumPointData", "").lower()
    if checksum not in ("", hashlib.md5(data, usedforsecurity=False).hexdigest()):
        raise FormatError("is damaged: its heights do not match its checksum")
    point_records = np.frombuffer(data, dtype=row_type)
    return {name: point_records[name] for name in stored}


def _parse_listed_points(rows: list[str], absolute_axes: list[str], points: int) -> dict[str, NDArray[Any]]:
    """Parse points that an X3P file lists as text, one line per point.

    Semicolons separate axes, and empty strings mark missing points.
    """
    if len(rows) != points:
        raise FormatError(f"declares {points} points, but lists {len(rows)}")
    columns: dict[str, NDArray[Any]] = {name: np.full(points, np.nan) for name in absolute_axes}
    for index, row in enumerate(rows):
        cells = [cell.strip() for cell in row.split(";")]
        cells = [cell for cell in cells if cell] if len(cells) > len(absolute_axes) else cells
        if not row:
            continue
        if len(cells) != len(absolute_axes):
            raise FormatError(
                f"lists {row[:40]!r} as point {index}, counted from 0; this point must have "
                f"{len(absolute_axes)} number(s)"
            )
        for name, cell in zip(absolute_axes, cells, strict=True):
            columns[name][index] = _parse_float(cell)
    return columns


def _get_element_text(root: _MainXml, path: str, default: str | None = None) -> str:
    text = root.texts.get(path, "").strip()
    if text:
        return text
    if default is None:
        raise FormatError(f"lacks {path} in {_MAIN_XML_FILE}")
    return default


def _parse_element_number(root: _MainXml, path: str, default: float) -> float:
    text = _get_element_text(root, path, "")
    return _parse_float(text) if text else default


def _parse_float(text: str) -> float:
    if _XML_NUMBER_PATTERN.fullmatch(text) is None:
        raise FormatError(f"has {text[:40]!r} instead of a number")
    return float(text)


def _parse_count(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 12):
        raise FormatError(f"has {text[:40]!r} where the count of points is expected")
    return int(text)
