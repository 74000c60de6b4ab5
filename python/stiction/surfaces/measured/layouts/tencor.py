"""Layout of text maps from KLA and Tencor stylus profilers. Each row begins with the trace number.

Profiles of these instruments, with columns such as Raw, RawLevel, Normal, Rough and Wavi, are ordinary tables. The
file contains no units: by default, resolutions are in µm and heights in Å.

::

    Number of Points    301
    Number of Traces    21
    X-Resolution        1.000000
    Y-Resolution        50.000000

    Trace       Data
    1   -36205.8        -35834  -35041
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.layout import TextLayout
from stiction.surfaces.measured.raw import ColumnTable, FormatError
from stiction.surfaces.measured.text_table import parse_table

_COUNT_PATTERN = re.compile(r"(?:Number of )?(Points|Traces)\s+([0-9]{1,7})\s*", re.IGNORECASE)


def _parse_counts(text: DecodedText) -> dict[str, int]:
    matches = (_COUNT_PATTERN.fullmatch(line) for line in text.first_lines[:40])
    return {match[1].casefold(): int(match[2]) for match in matches if match}


def _is_tencor_text(text: DecodedText) -> bool:
    return {"points", "traces"} <= _parse_counts(text).keys() and any(
        line.casefold().startswith("x-resolution") for line in text.first_lines[:40]
    )


def _read(text: DecodedText) -> ColumnTable:
    counts, table = _parse_counts(text), parse_table(text)
    if not isinstance(table, ColumnTable):
        raise FormatError("contains traces in several blocks; export them in one block with one trace per row")
    values, history = table.values, table.history
    rows, columns = values.shape
    if (
        rows == counts["traces"]
        and columns == counts["points"] + 1
        and np.array_equal(values[:, 0], values[0, 0] + np.arange(rows))
    ):
        values, history = values[:, 1:], (*history, "the first column, which numbers the traces, removed")
    if values.shape != (counts["traces"], counts["points"]):
        raise FormatError(
            f"declares {counts['traces']} traces of {counts['points']} points, but has {rows} rows of {columns} numbers"
        )
    bare_spacing = table.declared.bare_spacing
    return replace(
        table, values=values, names=(), units=(None,) * values.shape[1], is_array=True, digits=None, row_digits=None,
        history=history,
        declared=replace(
            table.declared, bare_spacing=bare_spacing if bare_spacing and len(bare_spacing) == 2 else None
        ),
    )  # fmt: skip


LAYOUT = TextLayout("KLA or Tencor traces", _is_tencor_text, _read)
