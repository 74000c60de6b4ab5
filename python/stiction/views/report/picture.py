"""What a page shows of two measured maps at one member: their heights, their spectra, and the contacts there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.surfaces.spectrum import surface_spectrum
from stiction.surfaces.surface import Surface
from stiction.views.report.page import ReportError, deflated, listed, packed

if TYPE_CHECKING:
    import xarray

MOST_PIXELS = 256
"""Rows or columns of the heights that are drawn."""

MOST_CONTACTS = 400
"""Contacts that are drawn: those with the largest forces."""

CONTACT_BYTES = 4
"""Leading bytes of a double that are kept of what is only drawn."""

COLUMNS = ("x", "y", "force", "patch_area", "slope_x", "slope_y")
"""Variables of each contact, without the prefix `contact_`."""

FEWEST_WAVES = 16
"""Rows and columns from which on a map has a spectrum."""


def pictured(picture: xarray.Dataset) -> tuple[dict[str, Any], dict[str, str]]:
    """Facts and packed numbers of a picture as `contact_picture` makes it.

    Raises a `ReportError` if something is not there, or is no number.
    """
    try:
        along_y, along_x = picture["height_y"].values, picture["height_x"].values
        bodies = [picture[f"{side}_height"].transpose("height_y", "height_x").values for side in ("lower", "upper")]
        table = np.stack([picture[f"contact_{name}"].values for name in COLUMNS]).astype(np.float64)
        load, member = float(picture.attrs["load_mN"]), int(picture.attrs["member"])
        moved = [float(picture.attrs[name]) for name in ("x", "y")]
    except (KeyError, TypeError, ValueError) as error:
        raise ReportError(f"the picture is not what `contact_picture` makes: {error}") from None
    if not all(np.isfinite(each).all() for each in (*bodies, along_y, along_x, table)) or min(bodies[0].shape) < 2:
        raise ReportError("the picture has heights or contacts that are no numbers")
    dy, dx = float(along_y[1] - along_y[0]), float(along_x[1] - along_x[0])
    ranges, packs, spectra = [], {}, []
    for side, body in zip(("lower", "upper"), bodies, strict=True):
        levels, ends, extent = grey(body, (dy, dx))
        packs[side] = deflated(levels.tobytes())
        ranges.append(ends)
        if ends[1] > ends[0] and min(body.shape) >= FEWEST_WAVES:
            radial = surface_spectrum(Surface(body, spacing=(dy, dx))).radial()
            spectra.append(
                {"name": f"{side} body", "waveNumber": listed(radial.wave_number), "density": listed(radial.density)}
            )
    rows, columns = levels.shape
    drawn = np.argsort(-table[2], kind="stable")[:MOST_CONTACTS]
    packs["contacts"] = packed(table[:, drawn], CONTACT_BYTES)
    return {
        "picture": {
            "rows": rows, "columns": columns, "ranges": ranges, "load": load, "member": member,
            "moved": listed(moved), "extent": extent,
            "contacts": {"columns": list(COLUMNS), "count": int(drawn.size), "all": int(table.shape[1])},
        },
        "spectra": spectra or None,
    }, packs  # fmt: skip


def grey(heights: Floats, spacing: tuple[float, float]) -> tuple[NDArray[np.uint8], list[float], list[float]]:
    """Heights (µm) as bytes between the lowest and the highest, of few pixels; both ends; and the lengths they fill."""
    every = -(-max(heights.shape) // MOST_PIXELS)
    thin = heights[::every, ::every]
    low, high = float(thin.min()), float(thin.max())
    levels = np.rint(255 * (thin - low) / ((high - low) or 1)).astype(np.uint8)
    return levels, [low, high], [count * every * step for count, step in zip(thin.shape, spacing, strict=True)]
