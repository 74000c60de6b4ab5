r"""Detection of text files that are rejected: height lists (NanoScope, CODE V, ISO 5436-2), images and meshes.

NanoScope exports a map as a column of heights. The numbers of CODE V and ISO 5436-2 (.smd, .prf) have a scale.

::

    \*File list
    \Samps/line: 32
    Height(nm)
    -2.1031

    Title of the surface
    GRD 24 20 SUR WVL 0.6328 SSZ 1000 NDA -32768
    153 -20 12

    ISO 5436 - 2000 laboratory
    PRF 0 laboratory
    CX I 300 mm 1.0 D 5.0e-04
    CZ A 300 um 1.0e-4 L
"""

from __future__ import annotations

import re

from stiction.surfaces.measured.decode import DecodedText
from stiction.surfaces.measured.layout import TextLayout
from stiction.surfaces.measured.raw import FormatError, RawHeights

_CODE_V_PATTERN = re.compile(r"GRD\s+[0-9]+\s+[0-9]+\s+(?:SUR|WFR|FIL)\b", re.IGNORECASE)
_TEXT_IMAGE_PATTERN = re.compile(r"P[123](?:\s+[0-9]+\s+[0-9]+(?:\s+[0-9]+)?)?", re.IGNORECASE)
_ELEMENT_FACE_PATTERN = re.compile(r"element face [1-9]", re.IGNORECASE)
_SMD_PATTERN = re.compile(r"C[XZ]\s+[AIM]\s+[0-9][0-9.e+]{0,20}\s+[nuµm]?m\s+[0-9.]", re.IGNORECASE)


def _is_list_of_heights(text: DecodedText) -> bool:
    is_nanoscope = text.line(0).lstrip("\\").startswith("*File list")
    patterns = (_CODE_V_PATTERN, _SMD_PATTERN, _ELEMENT_FACE_PATTERN)
    is_image = _TEXT_IMAGE_PATTERN.fullmatch(text.line(0).strip()) is not None
    return (
        is_nanoscope or is_image or any(pattern.match(line) for line in text.first_lines[:30] for pattern in patterns)
    )


def _reject_list_of_heights(text: DecodedText) -> RawHeights:
    if text.line(0).lstrip("\\").startswith("*"):
        raise FormatError(
            "is a NanoScope list with one height per line; open the file of the instrument instead (.spm)"
        )
    if _TEXT_IMAGE_PATTERN.fullmatch(text.line(0).strip()):
        raise FormatError("is an image as text (.pgm, .ppm), whose grey values have no height scale")
    if any(map(_SMD_PATTERN.match, text.first_lines[:30])):
        raise FormatError(
            "is an SMD or PRF file (ISO 5436-2), whose numbers need a scale factor that is not read; export it as X3P"
        )
    if any(map(_ELEMENT_FACE_PATTERN.match, text.first_lines[:30])):
        raise FormatError("is a mesh with faces (.ply); export only its points as x, y, z")
    raise FormatError(
        "is a CODE V interferogram, whose integers need a scale factor that is not read; export the heights as a matrix"
    )


LAYOUT = TextLayout("list of scaled numbers", _is_list_of_heights, _reject_list_of_heights)
