"""Base classes for the layouts of text files and workbooks that particular instruments write."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.raw import FormatError, ReaderResult, parse_number, parse_positive_number

WorkbookSheets = Mapping[str, Sequence[Sequence[Any]]]

MAX_DECLARED_COUNT = 100_000_000


def parse_header_number(
    header: Mapping[str, str], name: str, default: float | None = None, *, positive: bool = False
) -> float:
    """Parse the number at the start of a header field.

    Raises `FormatError` if there is no number or, with `positive`, if the number is not above 0.
    """
    text = header.get(name.casefold())
    if text is None:
        if default is None:
            raise FormatError(f"lacks a number for {name} in its header")
        return default
    return (parse_positive_number if positive else parse_number)(text, f"for {name} in its header")


def parse_header_integer(
    header: Mapping[str, str], name: str, minimum: int = 1, maximum: int = MAX_DECLARED_COUNT
) -> int:
    """Parse the integer at the start of a header field.

    Raises `FormatError` if the integer is missing or out of range.
    """
    value = parse_header_number(header, name)
    if not (value.is_integer() and minimum <= value <= maximum):
        raise FormatError(
            f"has {value:g} for {name} in its header; {name} must be a whole number from {minimum} to {maximum}"
        )
    return int(value)


@dataclass(frozen=True)
class TextLayout:
    """Layout of an instrument's text files: layout name, and functions that recognise and read such a file."""

    name: str
    recognises: Callable[[DecodedText], bool]
    read: Callable[[DecodedText], ReaderResult]


@dataclass(frozen=True)
class WorkbookLayout:
    """Layout of an instrument's Excel workbooks: layout name, and functions that recognise and read such a workbook."""

    name: str
    recognises: Callable[[WorkbookSheets], bool]
    read: Callable[[WorkbookSheets], ReaderResult]
