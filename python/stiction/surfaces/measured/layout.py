"""Base classes for the text and workbook layouts of particular instruments."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.raw import FormatError, ReaderResult

WorkbookSheets = Mapping[str, Sequence[Sequence[Any]]]  # rows of cells, by sheet name

MAX_DECLARED_COUNT = 100_000_000  # maximum number of points or lines that a header may declare
_LEADING_NUMBER_PATTERN = re.compile(r"\s*([+-]?[0-9]{0,40}(?:[.,][0-9]{0,40})?(?:[eE][+-]?[0-9]{1,5})?)(?![0-9.,])")


def parse_header_number(header: Mapping[str, str], name: str, default: float | None = None) -> float:
    """Return the finite number at the start of a header value. Raises `FormatError` if there is no number."""
    text = header.get(name.casefold())
    if text is None and default is not None:
        return default
    match = _LEADING_NUMBER_PATTERN.match(text or "")
    try:
        value = float(match[1].replace(",", ".")) if match else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FormatError(
            f"lacks a number for {name}" if text is None else f"has {text[:40]!r} for {name}, not a number"
        )
    return value


def parse_header_integer(
    header: Mapping[str, str], name: str, minimum: int = 1, maximum: int = MAX_DECLARED_COUNT
) -> int:
    """Return the integer at the start of a header value. Raises `FormatError` if the integer is out of range."""
    value = parse_header_number(header, name)
    if not (value.is_integer() and minimum <= value <= maximum):
        raise FormatError(f"has {value:g} for {name}, which must be a whole number from {minimum} to {maximum}")
    return int(value)


@dataclass(frozen=True)
class TextLayout:
    """Text layout of an instrument: how its files are recognised and read."""

    name: str
    recognises: Callable[[DecodedText], bool]
    read: Callable[[DecodedText], ReaderResult]


@dataclass(frozen=True)
class WorkbookLayout:
    """Workbook layout of an instrument: how its workbooks are recognised and read."""

    name: str
    recognises: Callable[[WorkbookSheets], bool]
    read: Callable[[WorkbookSheets], ReaderResult]
