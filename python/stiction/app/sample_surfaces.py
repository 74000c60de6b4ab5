"""Generated surfaces of the app: two sample scans, and two profiles that change with the sliders."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stiction.app.preview import MAX_PREVIEW_SIDE_POINTS, draw_lines_svg
from stiction.study.members import generate_profile_pairs
from stiction.study.study import Study
from stiction.surfaces.measured.writing import write_surface
from stiction.surfaces.self_affine import self_affine_surface


def write_sample_surfaces(directory: Path) -> list[Path]:
    """Write two sample scans (sides of 26 µm, rms height Sq of 50 nm) as CSV files, unless the files exist."""
    directory.mkdir(parents=True, exist_ok=True)
    paths = [directory / f"{side}.csv" for side in ("upper", "lower")]
    for path in paths:
        if not path.exists():
            surface = self_affine_surface(
                12, hurst_exponent=0.8, rms=0.05, shape=(128, 128), spacing=0.2, longest_wavelength=6.0,
                shortest_wavelength=1.0, side=path.stem,  # type: ignore[arg-type]
            )  # fmt: skip
            write_surface(surface, path)
    return paths


def draw_profiles(changes: Any) -> str:
    """Draw two generated profiles in first contact as SVG, from the built-in study `quick` with changed settings."""
    study = Study.named("quick").with_changes(changes)
    surfaces: Any = study.surfaces
    upper, lower = next(
        iter(generate_profile_pairs(study, 0, surfaces.fractal_dimensions()[:1], surfaces.amplitudes()[0]))
    )
    contact_index = int(np.argmin(gap := upper.heights - lower.heights))
    width = min(len(lower), round(4 * surfaces.max_wavelength() / lower.spacing))
    start = max(0, min(contact_index - width // 2, len(lower) - width))
    window = slice(start, start + width, max(1, width // (3 * MAX_PREVIEW_SIDE_POINTS)))
    return draw_lines_svg(lower.heights[window], upper.heights[window] - gap[contact_index])
