"""Parsing of decoded text files: in the file layout of a known instrument, or otherwise as a table of numbers."""

from __future__ import annotations

import re
from dataclasses import replace

from stiction.surfaces.measured.decode import DecodedText, decode_text
from stiction.surfaces.measured.layout import TextLayout
from stiction.surfaces.measured.layouts import TEXT_LAYOUTS
from stiction.surfaces.measured.raw import HeightChannels, ReaderResult
from stiction.surfaces.measured.text_table import parse_table

_STICTION_FIRST_LINE_PATTERN = re.compile(r"# spacing(?: along y)?: [0-9.e+-]{1,30} um")
"""Regular expression for the first line of files that `write_profile` and `write_surface` write."""


def read_text(data: bytes, words: tuple[str, ...] = ()) -> ReaderResult:
    """Decode and parse a text file.

    `words` are additional words that mark missing points.
    """
    return parse_content(decode_text(data, words))


def parse_content(text: DecodedText) -> ReaderResult:
    """Parse a text with the first known instrument layout that matches, or as a table if no layout matches."""
    layout = find_layout(text)
    return parse_table(text) if layout is None else record_layout_and_encoding(layout.read(text), text, layout.name)


def find_layout(text: DecodedText) -> TextLayout | None:
    """Return the first instrument layout that recognises a text.

    Returns None if no layout recognises the text.
    """
    # A file that stiction wrote has no instrument's layout, even if its history resembles an instrument's header.
    if _STICTION_FIRST_LINE_PATTERN.fullmatch(text.line(0)):
        return None
    return next((layout for layout in TEXT_LAYOUTS if layout.recognises(text)), None)


def record_layout_and_encoding(content: ReaderResult, text: DecodedText, layout: str) -> ReaderResult:
    """Return content parsed from a text file, with the layout and encoding of this file added to its `source`."""
    if isinstance(content, HeightChannels):
        read_channel = content.read
        return replace(content, read=lambda line: record_layout_and_encoding(read_channel(line), text, layout))  # type: ignore[arg-type, return-value]
    return replace(content, source=replace(content.source, layout=layout, encoding=text.encoding))
