"""What a scan holds, pictures beside the form, and two surfaces for whoever has none at hand."""

from __future__ import annotations

import base64
import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from stiction._checks import Floats
from stiction.studies.members import pairs_of
from stiction.studies.study import Study
from stiction.surfaces.measured.reading import read_measurement
from stiction.surfaces.measured.writing import write_surface
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.roughness import roughness_parameters, surface_parameters
from stiction.surfaces.self_affine import self_affine_surface
from stiction.views.digits import with_unit

DRAWN = 160
"""Rows, columns or points of a picture, at most."""

COLOURS = ("#7a8490", "#8a63c7")
"""Of lower and upper lines; both are seen on light and on dark ground."""


def look(file: str, unit: str, spacing: str, missing: Any) -> dict[str, Any]:
    """What a scan holds, as `stiction characterise` says it, with a small picture; or why it cannot be read."""
    of_unit, of_spacing = (tuple(text.split(",")) if "," in text else text or None for text in (unit, spacing))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            body = read_measurement(file, unit=of_unit, spacing=of_spacing, missing=missing)  # type: ignore[arg-type]
            level = levelled(body, "line" if isinstance(body, Profile) else "plane")  # type: ignore[call-overload]
            found: Any = roughness_parameters(level) if isinstance(level, Profile) else surface_parameters(level)
        except (ValueError, ImportError, MemoryError) as error:
            return {"error": str(error) or "there is not enough memory for this"}
    is_line = isinstance(level, Profile)
    names = ("Pq", "Pdq") if is_line else ("Sq", "Sdq")
    height, slope = (float(getattr(found, name)) for name in names)
    size = " × ".join(with_unit(each, "um") for each in np.atleast_1d(body.extent)[::-1])
    points = " × ".join(f"{each}" for each in np.shape(body.heights)[::-1])
    if isinstance(level, Profile):
        kind, picture = "svg+xml", svg(level.heights[:: -(-len(level) // (3 * DRAWN))]).encode()
    else:
        kind, picture = "bmp", bitmap(level.heights, level.extent)
    return {
        "holds": "profile" if is_line else "surface", names[0]: height, names[1]: slope,
        "words": f"{size}, {points} points; {names[0]} {with_unit(height, 'um')}, slope {names[1]} {slope:.3g}",
        "warning": "; ".join(str(each.message) for each in caught),
        "picture": f"data:image/{kind};base64,{base64.b64encode(picture).decode()}",
    }  # fmt: skip


def surfaces(folder: Path) -> list[Path]:
    """Write an upper and a lower ground face of 26 µm, heights 50 nm (Sq)."""
    made = [folder / f"{side}.csv" for side in ("upper", "lower")]
    for path in made:
        face = self_affine_surface(
            12, hurst_exponent=0.8, rms=0.05, shape=(128, 128), spacing=0.2, longest_wavelength=6.0,
            shortest_wavelength=1.0, side=path.stem,  # type: ignore[arg-type]
        )  # fmt: skip
        path.unlink(missing_ok=True)
        write_surface(face, path)
    return made


def profiles(changes: Any) -> str:
    """A picture of the first pair of the study that `quick` is with these changes, around where its profiles touch.

    Raises
    ------
    ValueError
        If the study takes no such change.
    """
    study = Study.named("quick").with_changes(changes)
    surfaces: Any = study.surfaces
    upper, lower = next(iter(pairs_of(study, 0, surfaces.fractal_dimensions()[:1], surfaces.amplitudes()[0])))
    touch = int(np.argmin(gap := upper.heights - lower.heights))
    width = min(len(lower), round(4 * surfaces.longest() / lower.spacing))
    start = max(0, min(touch - width // 2, len(lower) - width))
    seen = slice(start, start + width, max(1, width // (3 * DRAWN)))
    return svg(lower.heights[seen], upper.heights[seen] - gap[touch])


def svg(*lines: Floats) -> str:
    """Lines in one frame, as SVG."""
    low, high = min(map(np.min, lines)), max(map(np.max, lines))
    drawn = ""
    for line, colour in zip(lines, COLOURS, strict=False):
        x, y = np.linspace(0, 300, len(line)), 95 - 90 * (line - low) / ((high - low) or 1.0)
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
        drawn += f'<polyline fill="none" stroke="{colour}" points="{points}"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 300 100">{drawn}</svg>'


def bitmap(heights: Floats, extent: tuple[float, float]) -> bytes:
    """A map in greys as BMP, whose first row is the lowest, as that of a map is; its pixels are square."""
    sizes = [max(2, round(DRAWN * each / max(extent))) for each in extent]
    rows, columns = (np.linspace(0, n - 1, m).round().astype(int) for n, m in zip(heights.shape, sizes, strict=True))
    thin = heights[np.ix_(rows, columns)]
    grey = np.rint(255 * (thin - thin.min()) / (float(np.ptp(thin)) or 1.0)).astype(np.uint8)
    pixels = np.pad(grey, ((0, 0), (0, -sizes[1] % 4))).tobytes()
    palette = np.repeat(np.arange(256, dtype=np.uint8), 4).tobytes()
    head = (40, sizes[1], sizes[0], 1, 8, 0, len(pixels), 0, 0, 256, 0)
    return (
        struct.pack("<2sIII", b"BM", 1078 + len(pixels), 0, 1078)
        + struct.pack("<IiiHHIIiiII", *head)
        + palette
        + pixels
    )
