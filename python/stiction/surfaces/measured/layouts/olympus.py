"""Layout of CSV files from Olympus OLS (LEXT) microscopes. Each row begins with the row number.

::

    Model,OLS5000
    X Resolution[um],0.625
    Y Resolution[um],0.625
    Z Resolution[um],0.001
    DataLine,POS = 1,POS = 2,POS = 3
    1,11.844,11.917,12.457
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.header import normalise_line
from stiction.surfaces.measured.layout import TextLayout
from stiction.surfaces.measured.raw import ColumnTable, FormatError, parse_length_unit
from stiction.surfaces.measured.text_table import parse_table

_HEIGHT_UNIT_LINE_PATTERN = re.compile(r"\W*Z\s*Resolution\s*[\[(]\s*([^\])]{1,12}?)\s*[\])].*", re.IGNORECASE)


def _read(text: DecodedText) -> ColumnTable:
    table = parse_table(text)
    if not isinstance(table, ColumnTable):
        raise FormatError("contains more than one map; export each map to its own file")
    rows = table.values.shape[0]
    if table.values.shape[1] < 3 or not np.array_equal(table.values[:, 0], table.values[0, 0] + np.arange(rows)):
        raise FormatError("has no row numbers in the first column, unlike exports of this microscope")
    unit = next(
        (
            parse_length_unit(match[1]) or match[1]
            for line in text.first_lines
            if (match := _HEIGHT_UNIT_LINE_PATTERN.fullmatch(normalise_line(line)))
        ),
        None,
    )
    return replace(
        table, values=table.values[:, 1:], names=table.names[1:], units=(unit,) * (table.values.shape[1] - 1),
        is_array=True, digits=None, row_digits=None,
        history=(*table.history, "the first column, which numbers the rows, removed"),
    )  # fmt: skip


LAYOUT = TextLayout(
    "Olympus OLS map",
    lambda text: any(re.match(r"\W*DataLine\W+POS\b", line, re.I) for line in text.first_lines),
    _read,
)
