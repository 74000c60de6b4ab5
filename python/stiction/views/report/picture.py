"""What a page shows of two measured maps at one member: their heights, their spectra, and the contacts there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

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
"""Of each contact, behind the prefix `contact_`."""

FEWEST_WAVES = 16
"""Rows and columns from which on a map has a spectrum."""


def pictured(picture: xarray.Dataset) -> tuple[dict[str, Any], dict[str, str]]:
    """Facts and packed numbers of a picture as `contact_picture` makes it.

    Raises
    ------
    ReportError
        If something is not there, or is no number.
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
    every = -(-max(bodies[0].shape) // MOST_PIXELS)
    ranges, packs, spectra = [], {}, []
    for side, body in zip(("lower", "upper"), bodies, strict=True):
        thin = body[::every, ::every]
        low, high = float(thin.min()), float(thin.max())
        packs[side] = deflated(np.rint(255 * (thin - low) / ((high - low) or 1)).astype(np.uint8).tobytes())
        ranges.append([low, high])
        if high > low and min(body.shape) >= FEWEST_WAVES:
            radial = surface_spectrum(Surface(body, spacing=(dy, dx))).radial()
            spectra.append(
                {"name": f"{side} body", "waveNumber": listed(radial.wave_number), "density": listed(radial.density)}
            )
    rows, columns = thin.shape
    drawn = np.argsort(-table[2], kind="stable")[:MOST_CONTACTS]
    packs["contacts"] = packed(table[:, drawn], CONTACT_BYTES)
    return {
        "picture": {
            "rows": rows, "columns": columns, "ranges": ranges, "load": load, "member": member,
            "moved": listed(moved), "extent": [rows * every * dy, columns * every * dx],
            "contacts": {"columns": list(COLUMNS), "count": int(drawn.size), "all": int(table.shape[1])},
        },
        "spectra": spectra or None,
    }, packs  # fmt: skip
