"""Preview of scans as JSON: command `python -m stiction.app.preview FILE OPTIONS [FILE OPTIONS]`.

For one scan, the command prints the contents with a small image. For two scans, it prints whether they fit into each
other. OPTIONS is JSON text with options of `read_measurement` by name. Imports take most of the run time, so this
module uses neither Matplotlib nor the declarations of the form fields.
"""

from __future__ import annotations

import base64
import io
import json
import sys
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
import PIL.Image

from stiction._checks import Floats
from stiction._number_format import format_with_unit
from stiction.surfaces.measured.reading import read_with_interpretation
from stiction.surfaces.preparation import flipped, levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.registration import do_faces_fit
from stiction.surfaces.roughness import reject_flat_or_small_surface, rms_gradient, roughness_parameters

# Maximum number of points along each side of the preview of a map; a profile may have three times as many.
MAX_PREVIEW_SIDE_POINTS = 160
# These colours are visible on light and on dark backgrounds.
PROFILE_COLOURS = ("#7a8490", "#8a63c7")


def preview_scan(file: str, options: dict[str, Any]) -> dict[str, Any]:
    """Return a summary of a scan with a small image, or the reason why the file cannot be read.

    Messages contain names of command-line options, which the server replaces with the labels of form fields.
    """
    with warnings.catch_warnings(record=True) as caught_warnings:
        warnings.simplefilter("always")
        try:
            scan = read_with_interpretation(file, **options)
            body = scan.body
            levelled_body = levelled(body, "line" if isinstance(body, Profile) else "plane")  # type: ignore[call-overload]
            if isinstance(levelled_body, Profile):
                parameters = roughness_parameters(levelled_body)
                height, slope = parameters.Pq, parameters.Pdq
            else:
                reject_flat_or_small_surface(levelled_body)
                height, slope = float(levelled_body.heights.std()), rms_gradient(levelled_body, "seven-point")
        except (ValueError, ImportError, MemoryError) as error:
            return {"error": str(error) or "not enough memory for this scan"}
    is_profile = isinstance(levelled_body, Profile)
    names = ("Pq", "Pdq") if is_profile else ("Sq", "Sdq")
    extent_text = " × ".join(format_with_unit(item, "um") for item in np.atleast_1d(body.extent)[::-1])
    points = " × ".join(f"{item}" for item in np.shape(body.heights)[::-1])
    if isinstance(levelled_body, Profile):
        image_type, image = (
            "svg+xml",
            draw_lines_svg(levelled_body.heights[:: -(-len(levelled_body) // (3 * MAX_PREVIEW_SIDE_POINTS))]).encode(),
        )
    else:
        image_type, image = "png", render_height_map_png(levelled_body.heights, levelled_body.extent)
    warning_texts = [*scan.caveats, *(item.message for item in caught_warnings)]
    return {
        "holds": "profile" if is_profile else "surface", names[0]: height, names[1]: slope,
        "words": f"{extent_text}, {points} points; "
        f"{names[0]} {format_with_unit(height, 'um')}, slope {names[1]} {slope:.3g}",
        "points": int(np.size(body.heights)), "reading": str(scan),
        "warning": "; ".join(map(str, warning_texts)),
        "picture": f"data:image/{image_type};base64,{base64.b64encode(image).decode()}",
    }  # fmt: skip


def compare_scans(files: Sequence[str], options: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return whether two scanned faces fit together, and suggest a path length for their shear test.

    The path is a tenth of the scan length. Scans that cannot be read do not fit.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            upper, lower = (
                read_with_interpretation(file, **file_options).body
                for file, file_options in zip(files, options, strict=True)
            )
            do_fit = type(upper) is type(lower) and do_faces_fit(flipped(upper), lower)
    except (ValueError, ImportError, MemoryError):
        return {"fits": False}
    return {"fits": do_fit, "path": format_with_unit(float(np.min(np.atleast_1d(lower.extent))) / 10, "um")}


def draw_lines_svg(*lines: Floats) -> str:
    """Draw profiles as an SVG image, all with the same vertical scale."""
    lowest_height, highest_height = min(map(np.min, lines)), max(map(np.max, lines))
    elements = ""
    for line, colour in zip(lines, PROFILE_COLOURS, strict=False):
        x, y = (
            np.linspace(0, 300, len(line)),
            95 - 90 * (line - lowest_height) / ((highest_height - lowest_height) or 1.0),
        )
        points = " ".join(f"{px:.1f},{py:.1f}" for px, py in zip(x, y, strict=True))
        elements += f'<polyline fill="none" stroke="{colour}" points="{points}"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 300 100">{elements}</svg>'


def render_height_map_png(heights: Floats, extent: tuple[float, float]) -> bytes:
    """Draw a height map as a grey PNG image with square pixels. The first row of the map is at the bottom.

    The grey levels equal those of the colour map of heights in other figures to within one level.
    """
    pixel_counts = [max(2, round(MAX_PREVIEW_SIDE_POINTS * length / max(extent))) for length in extent]
    rows, columns = (
        np.linspace(0, count - 1, pixel_count).round().astype(int)
        for count, pixel_count in zip(heights.shape, pixel_counts, strict=True)
    )
    pixels = heights[np.ix_(rows[::-1], columns)]
    levels = 256 * ((pixels - pixels.min()) / (np.ptp(pixels) or 1.0))
    file = io.BytesIO()
    PIL.Image.fromarray(np.minimum(levels, 255).astype(np.uint8)).save(file, "png")
    return file.getvalue()


def main() -> None:
    """Print the preview of a scan, or the comparison of two scans, as JSON."""
    # Some options of `read_measurement` must be tuples, but JSON stores tuples as lists.
    files, options = sys.argv[1::2], [
        {name: tuple(value) if isinstance(value, list) else value for name, value in json.loads(text).items()}
        for text in sys.argv[2::2]
    ]  # fmt: skip
    print(json.dumps(preview_scan(files[0], options[0]) if len(files) == 1 else compare_scans(files, options)))


if __name__ == "__main__":
    main()
