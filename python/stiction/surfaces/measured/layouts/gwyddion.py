"""Layout of text files that Gwyddion exports, in any interface language.

The first line of numbers is the top of the image.

::

    # Kanal: Topo
    # Breite: 4.000 µm
    # Höhe: 3.000 µm
    # Einheiten: nm
    0.7369      -0.2650 -1.7248
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.header import normalise_line
from stiction.surfaces.measured.layout import TextLayout
from stiction.surfaces.measured.raw import ColumnTable, HeightChannels, ReaderResult, parse_length_unit
from stiction.surfaces.measured.spacing_lines import parse_length
from stiction.surfaces.measured.text_table import parse_table

_LENGTH_COMMENT_PATTERN = re.compile(
    r"#\s*[^:=]{1,40}[:=]\s*([0-9]+(?:[.,][0-9]+)?(?:[eE][+-]?[0-9]+)?)\s*([^\W\d_]{1,12})\s*"
)
_COMMENT_LINE_PATTERN = re.compile(r"#\s*[^:=]{1,40}[:=]\s*(\S.{0,80})?")


def _parse_channel_comments(lines: Sequence[str]) -> list[str]:
    """Return the four comments above the heights of a channel: name, width, height and unit, in any language."""
    comments = []
    for line in map(normalise_line, lines):
        if not line.startswith("#"):
            break
        comments.append(line)
    return comments[-4:]


def _are_channel_comments(comments: Sequence[str]) -> bool:
    lengths = [_LENGTH_COMMENT_PATTERN.fullmatch(line) for line in comments]
    return (
        len(comments) >= 3
        and lengths[0] is None
        and all(match is not None and parse_length_unit(match[2]) for match in lengths[1:3])
        and all(_COMMENT_LINE_PATTERN.fullmatch(line) for line in comments)
    )


def _set_channel_data_from_comments(table: ColumnTable, comments: Sequence[str]) -> ColumnTable:
    width, height = (_LENGTH_COMMENT_PATTERN.fullmatch(line) for line in comments[1:3])
    assert width is not None
    assert height is not None
    along_y, along_x = (parse_length(*match.groups(), line=match.string) for match in (height, width))
    assert along_y is not None
    assert along_x is not None
    size = (along_y, along_x)
    unit = table.declared.unit
    if len(comments) > 3 and (match := _COMMENT_LINE_PATTERN.fullmatch(comments[3])) is not None and match[1]:
        unit = parse_length_unit(match[1].strip()) or match[1].strip()
    channel = _COMMENT_LINE_PATTERN.fullmatch(comments[0])
    column = (channel[1] or "") if channel else ""
    units = (None,) * table.values.shape[1]
    return replace(
        table, names=(), units=units, is_array=True, source=replace(table.source, column=column.strip()),
        declared=replace(table.declared, size=size, unit=unit, spacing=None, spacings=None, bare_spacing=None),
    )  # fmt: skip


def _read(text: DecodedText) -> ReaderResult:
    content = parse_table(text)
    if isinstance(content, ColumnTable):
        return _set_channel_data_from_comments(content, _parse_channel_comments(text.first_lines))
    assert isinstance(content, HeightChannels)
    read_block = content.read

    def read_channel_table(index: int) -> ColumnTable:
        table = read_block(index)
        assert isinstance(table, ColumnTable)
        assert table.source.lines is not None
        first = table.source.lines[0] - 1
        header_start = first
        while header_start > 0 and text.line(header_start - 1).startswith("#"):
            header_start -= 1
        return _set_channel_data_from_comments(table, _parse_channel_comments(text.nonempty_lines(header_start, first)))

    return replace(content, read=read_channel_table)


LAYOUT = TextLayout(
    "Gwyddion text", lambda text: _are_channel_comments(_parse_channel_comments(text.first_lines[:6])), _read
)
