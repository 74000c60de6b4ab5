"""Recognition of files from a long trace profiler, which are rejected because they contain slopes.

Three numbers follow the header: the focal length, the step (mm) and the number of points. The rows are positions and
slopes, without names or units.

::

    average Forward/rotated
    24/01/2013 at 14:38
    No ref/gravity correction
    817.099976
    -1.000000
    1001
    -500.0000000        2.7114492
"""

from __future__ import annotations

import re

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.layout import TextLayout
from stiction.surfaces.measured.raw import FormatError, RawHeights

MAX_HEADER_LINES = 12
_CORRECTION_PATTERN = re.compile(r"\W*(?:no )?ref\w*\b[^/]{0,30}/\s*(?:no )?gravity\b.*", re.IGNORECASE)
_LONE_NUMBER_PATTERN = re.compile(r"#?\s*-?[0-9]+(?:\.[0-9]*)?\s*")


def _is_slope_profile(text: DecodedText) -> bool:
    lines = text.first_lines[:MAX_HEADER_LINES]
    return any(
        _CORRECTION_PATTERN.fullmatch(line) and all(map(_LONE_NUMBER_PATTERN.fullmatch, lines[place + 1 : place + 4]))
        for place, line in enumerate(lines)
    )


def _reject_slope_profile(text: DecodedText) -> RawHeights:
    raise FormatError("contains slopes of a long trace profiler, not heights; integrate them to heights first")


LAYOUT = TextLayout("slopes of a long trace profiler", _is_slope_profile, _reject_slope_profile)
