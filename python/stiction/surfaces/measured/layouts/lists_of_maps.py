r"""Maps as a list of numbers below a header of NanoScope or CODE V. They are recognised in order to be rejected.

NanoScope exports a map as a column of heights. CODE V interferograms are lists of integers with a scale.

::

    \*File list
    \Samps/line: 32
    Height(nm)
    -2.1031

    Title of the surface
    GRD 24 20 SUR WVL 0.6328 SSZ 1000 NDA -32768
    153 -20 12
"""

from __future__ import annotations

import re

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.layout import TextLayout
from stiction.surfaces.measured.raw import FormatError, RawHeights

_CODE_V_PATTERN = re.compile(r"GRD\s+[0-9]+\s+[0-9]+\s+(?:SUR|WFR|FIL)\b", re.IGNORECASE)


def _is_list_of_map(text: DecodedText) -> bool:
    is_nanoscope = text.line(0).lstrip("\\").startswith("*File list")
    return is_nanoscope or any(_CODE_V_PATTERN.match(line) for line in text.first_lines[:10])


def _reject(text: DecodedText) -> RawHeights:
    if text.line(0).lstrip("\\").startswith("*"):
        raise FormatError(
            "is a NanoScope list with one height per line; open the file of the instrument instead (.spm)"
        )
    raise FormatError("is a CODE V interferogram, whose numbers are scaled; export the heights as a matrix")


LAYOUT = TextLayout("list of a map", _is_list_of_map, _reject)
