"""Layout of Esri ASCII grids, written by GIS programs and some microscopes.

The first line of numbers has the largest y.

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

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.layout import TextLayout, parse_header_integer, parse_header_number
from stiction.surfaces.measured.raw import FormatError, RawHeights
from stiction.surfaces.measured.split import detect_dialect, find_numeric_line_runs, parse_number_block
from stiction.surfaces.measured.text_table import make_height_provenance

_HEADER_NAMES = (
    "ncols",
    "nrows",
    "xllcorner",
    "yllcorner",
    "xllcenter",
    "yllcenter",
    "cellsize",
    "dx",
    "dy",
    "nodata_value",
)


def _parse_header(text: DecodedText) -> dict[str, str]:
    rows = (line.replace("=", " ").split() for line in text.first_lines[:12])
    return {row[0].casefold(): " ".join(row[1:]) for row in rows if row and row[0].casefold() in _HEADER_NAMES}


def _read(text: DecodedText) -> RawHeights:
    header = _parse_header(text)
    values = {name: parse_header_number(header, name, positive=name in ("cellsize", "dx", "dy")) for name in header}
    runs = find_numeric_line_runs(text)
    if not runs:
        raise FormatError("has no heights below its header")
    block = parse_number_block(text, *runs[0], detect_dialect(text, *runs[0]))
    shape = (parse_header_integer(header, "nrows"), parse_header_integer(header, "ncols"))
    if len(runs) > 1 or block.values.size != shape[0] * shape[1]:
        raise FormatError(
            f"declares {shape[0]} rows of {shape[1]} heights, but contains an array of shape {block.values.shape}"
        )
    dx = values.get("cellsize", values.get("dx"))
    dy = values.get("cellsize", values.get("dy"))
    heights = np.ascontiguousarray(block.values.reshape(shape)[::-1])
    return RawHeights(
        heights, bare_spacing=None if dx is None or dy is None else (dy, dx), source=make_height_provenance(block),
        codes=(values["nodata_value"],) if "nodata_value" in values else (),
        history=("rows reversed: the first line has the largest y",),
    )  # fmt: skip


LAYOUT = TextLayout("Esri ASCII grid", lambda text: {"ncols", "nrows"} <= _parse_header(text).keys(), _read)
