"""ASCII export of SPIP (Image Metrology) and of programs that follow it: sizes in nm unless units are given.

::

    # File Format = ASCII
    # x-pixels = 128
    # y-pixels = 128
    # x-length = 1000
    # y-length = 1000
    # z-unit = nm
    # Start of Data:
    0.1	0.2	0.3
"""

from __future__ import annotations

import re

from stiction.surfaces.measured.decode import Text
from stiction.surfaces.measured.header import normal
from stiction.surfaces.measured.layout import Layout, number, whole
from stiction.surfaces.measured.raw import FormatError, Raw, length_unit
from stiction.surfaces.measured.split import dialect_of, numbers_of, runs_of
from stiction.surfaces.measured.text import source_of

_SAID = re.compile(r"#?\s*([A-Za-z][\w -]{0,30}?)\s*[=:]\s*(.{1,60}?)\s*")


def _said(text: Text) -> dict[str, str]:
    matches = (_SAID.fullmatch(normal(line)) for line in text.head[:100])
    return {match[1].casefold(): match[2] for match in matches if match}


def _recognise(text: Text) -> bool:
    said = _said(text)
    return {"x-pixels", "y-pixels", "x-length", "y-length"} <= said.keys() and text.line(0).startswith("#")


def _read(text: Text) -> Raw:
    said = _said(text)
    runs = runs_of(text)
    if not runs:
        raise FormatError("has no heights below its header")
    first, last = max(runs, key=lambda run: int(text.starts[run[1] + 1] - text.starts[run[0]]))
    block = numbers_of(text, first, last, dialect_of(text, first, last))
    rows, columns = whole(said, "y-pixels"), whole(said, "x-pixels")
    if block.values.shape != (rows, columns):
        raise FormatError(f"declares {rows} rows of {columns} heights, and has {block.values.shape}")
    units = {said.get(f"{axis}-unit", "nm") for axis in "xy"}
    if len(units) > 1:
        raise FormatError("has lengths along x and y in different units")
    unit, factor = said.get("z-unit"), None
    if unit is None:
        unit, factor = "nm", number(said, "bit2nm") if "bit2nm" in said else None
    spacing = (number(said, "y-length") / rows, number(said, "x-length") / columns)
    return Raw(
        block.values, unit=length_unit(unit) or unit, factor=factor, spacing=spacing, position_unit=units.pop(),
        source=source_of(block),
    )  # fmt: skip


LAYOUT = Layout("SPIP ASCII", _recognise, _read)
