"""Esri ASCII grid, as GIS programs and some microscopes write it: the first line of numbers has the largest y.

::

    ncols         40
    nrows         30
    xllcorner     0.0
    yllcorner     0.0
    cellsize      0.05
    NODATA_value  -9999
    0.12633 0.12257 -9999
"""

from __future__ import annotations

import numpy as np

from stiction.surfaces.measured.decode import Text
from stiction.surfaces.measured.layout import Layout, number, whole
from stiction.surfaces.measured.raw import FormatError, Raw
from stiction.surfaces.measured.split import dialect_of, numbers_of, runs_of
from stiction.surfaces.measured.text import source_of

_KEYS = ("ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "dx", "dy", "nodata_value")


def _said(text: Text) -> dict[str, str]:
    words = (line.replace("=", " ").split() for line in text.head[:12])
    return {row[0].casefold(): " ".join(row[1:]) for row in words if row and row[0].casefold() in _KEYS}


def _read(text: Text) -> Raw:
    said = _said(text)
    facts = {key: number(said, key) for key in said}
    runs = runs_of(text)
    if not runs:
        raise FormatError("has no heights below its header")
    block = numbers_of(text, *runs[0], dialect_of(text, *runs[0]))
    shape = (whole(said, "nrows"), whole(said, "ncols"))
    if len(runs) > 1 or block.values.size != shape[0] * shape[1]:
        raise FormatError(f"declares {shape[0]} rows of {shape[1]} heights, and has {block.values.shape}")
    dx = facts.get("cellsize", facts.get("dx"))
    dy = facts.get("cellsize", facts.get("dy"))
    heights = np.ascontiguousarray(block.values.reshape(shape)[::-1])
    return Raw(
        heights, bare_spacing=None if dx is None or dy is None else (dy, dx), source=source_of(block),
        codes=(facts["nodata_value"],) if "nodata_value" in facts else (),
        history=("rows turned round: the first line has the largest y",),
    )  # fmt: skip


LAYOUT = Layout("Esri ASCII grid", lambda text: {"ncols", "nrows"} <= _said(text).keys(), _read)
