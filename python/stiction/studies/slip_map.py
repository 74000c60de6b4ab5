"""A map of what slips first over the contacts of one member of two measured maps, for pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.mechanics.half_space import HalfSpaceCurve
from stiction.studies.contact_picture import MOST_PICTURED
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    from stiction.mechanics.onset import Onset
    from stiction.studies.one_load import OneLoad

Variables = dict[str, tuple[Any, ...]]

_LENGTH = {"units": "um"}


def slip_map(pressed: OneLoad, onset: Onset) -> Variables:
    """Variables of a dataset: which fraction of the sliding load makes each point slip, and the heights below.

    Of the half-space ``slip`` over slip_y and slip_x, NaN where nothing touches; of asperities, which all slip at their
    edges from the start, ``contact_slip`` at which each slides as a whole, with contact_x, contact_y and contact_area.
    Of maps with more than 512 rows or columns the first of some neighbours is kept. Nothing of profiles.
    """
    lower = pressed.lower
    if not isinstance(lower, Surface):
        return {}
    (rows, columns), (dy, dx) = lower.heights.shape, lower.spacing
    step = -(-max(rows, columns) // MOST_PICTURED)
    found: Variables = {
        "slip_y": ("slip_y", np.arange(0, rows, step) * dy, _LENGTH),
        "slip_x": ("slip_x", np.arange(0, columns, step) * dx, _LENGTH),
        "lower_height": (("slip_y", "slip_x"), lower.heights[::step, ::step].astype(np.float32), _LENGTH),
    }
    fraction = onset.slip_load() / onset.sliding_load
    if isinstance(pressed.curve, HalfSpaceCurve):
        words = {"units": "1", "long_name": "tangential over sliding load at which a point slips"}
        first = _first_of_blocks(fraction.reshape(rows, columns), step)
        return found | {"slip": (("slip_y", "slip_x"), first.astype(np.float32), words)}
    table = pressed.table()
    of_contacts = {
        "slip": (fraction, "1", "tangential over sliding load at which a contact slides as a whole"),
        "x": (table.x, "um", "middle of a contact along x"),
        "y": (table.y, "um", "middle of a contact along y"),
        "area": (table.area, "um^2", "area of a contact"),
    }
    return found | {
        f"contact_{name}": ("contact", values, {"units": unit, "long_name": words})
        for name, (values, unit, words) in of_contacts.items()
    }


def _first_of_blocks(values: Floats, step: int) -> Floats:
    """The least number of each block of some rows and columns; NaN where there is none."""
    rows, columns = (-(-size // step) * step for size in values.shape)
    whole = np.full((rows, columns), np.inf)
    whole[: values.shape[0], : values.shape[1]] = np.where(np.isnan(values), np.inf, values)
    least = whole.reshape(rows // step, step, columns // step, step).min(axis=(1, 3))
    return np.where(np.isinf(least), np.nan, least)
