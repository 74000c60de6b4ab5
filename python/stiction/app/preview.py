"""`python -m stiction.app.preview FILE READING`: what a scan holds, as JSON with a small picture.

READING is JSON: options of `read_measurement` by name, as texts.
"""

from __future__ import annotations

import base64
import io
import json
import sys
import warnings
from typing import Any

import numpy as np

from stiction._checks import Floats
from stiction._drawing import HEIGHT_MAP
from stiction._number_format import with_unit
from stiction.studies.pair_options import split_list
from stiction.surfaces.measured.reading import load_reading
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.roughness import check_roughness, rms_gradient, roughness_parameters

DRAWN = 160  # rows, columns or points of a picture, at most
COLOURS = ("#7a8490", "#8a63c7")  # of lower and upper lines; both are seen on light and on dark ground


def look(file: str, reading: dict[str, str]) -> dict[str, Any]:
    """What a scan holds, as `stiction characterise` says it, with a small picture; or why it cannot be read."""
    texts = {name.replace("-", "_"): text for name, text in reading.items() if text}
    given: dict[str, Any] = {name: split_list(name, text) for name, text in texts.items()}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            scan = load_reading(file, **given)
            body = scan.body
            level = levelled(body, "line" if isinstance(body, Profile) else "plane")  # type: ignore[call-overload]
            if isinstance(level, Profile):
                found = roughness_parameters(level)
                height, slope = found.Pq, found.Pdq
            else:
                check_roughness(level)
                height, slope = float(level.heights.std()), rms_gradient(level, "seven-point")
        except (ValueError, ImportError, MemoryError) as error:
            return {"error": str(error) or "there is not enough memory for this"}
    is_line = isinstance(level, Profile)
    names = ("Pq", "Pdq") if is_line else ("Sq", "Sdq")
    size = " × ".join(with_unit(each, "um") for each in np.atleast_1d(body.extent)[::-1])
    points = " × ".join(f"{each}" for each in np.shape(body.heights)[::-1])
    if isinstance(level, Profile):
        kind, picture = "svg+xml", svg(level.heights[:: -(-len(level) // (3 * DRAWN))]).encode()
    else:
        kind, picture = "png", png(level.heights, level.extent)
    return {
        "holds": "profile" if is_line else "surface", names[0]: height, names[1]: slope,
        "words": f"{size}, {points} points; {names[0]} {with_unit(height, 'um')}, slope {names[1]} {slope:.3g}",
        "points": int(np.size(body.heights)), "reading": str(scan),
        "warning": "; ".join([*map(str, scan.caveats), *(str(each.message) for each in caught)]),
        "picture": f"data:image/{kind};base64,{base64.b64encode(picture).decode()}",
    }  # fmt: skip


def svg(*lines: Floats) -> str:
    """Lines in one frame, as SVG."""
    low, high = min(map(np.min, lines)), max(map(np.max, lines))
    drawn = ""
    for line, colour in zip(lines, COLOURS, strict=False):
        x, y = np.linspace(0, 300, len(line)), 95 - 90 * (line - low) / ((high - low) or 1.0)
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
        drawn += f'<polyline fill="none" stroke="{colour}" points="{points}"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 300 100">{drawn}</svg>'


def png(heights: Floats, extent: tuple[float, float]) -> bytes:
    """A map in greys, whose first row is the lowest; its pixels are square."""
    from matplotlib.image import imsave

    sizes = [max(2, round(DRAWN * each / max(extent))) for each in extent]
    rows, columns = (np.linspace(0, n - 1, m).round().astype(int) for n, m in zip(heights.shape, sizes, strict=True))
    file = io.BytesIO()
    imsave(file, heights[np.ix_(rows, columns)], cmap=HEIGHT_MAP, origin="lower")
    return file.getvalue()


if __name__ == "__main__":
    print(json.dumps(look(sys.argv[1], json.loads(sys.argv[2]))))
