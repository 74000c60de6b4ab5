"""The contacts of one typical member of two measured maps, for pictures: solved once more, and kept as a small file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.mechanics.quantities import attributes_of
from stiction.studies.at_load import member_values
from stiction.studies.contact_statistics import Table
from stiction.studies.maps import study_of_result
from stiction.studies.members import bodies_of
from stiction.studies.one_load import OneLoad
from stiction.studies.store import read_beside
from stiction.studies.tables import MeasuredFriction
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

    from stiction.studies.maps import Result
    from stiction.studies.store import Stored

FILE = "picture.nc"
"""Name of the file in the folder of a result."""

MOST_PICTURED = 512
"""Rows and columns of a map that are kept."""

AROUND_LARGEST = 8
"""The part of the map that is kept of the pressure about the contact that carries most."""

FEWEST_POINTS = 16

_OF_CONTACTS = {
    "contact_x": ("x", "um", "middle of a contact along x"),
    "contact_y": ("y", "um", "middle of a contact along y"),
    "contact_force": ("force", "mN", "load on a contact"),
    "contact_patch_area": ("area", "um^2", "area of a contact on the ground plan"),
    "contact_slope_x": ("slope_x", "1", "mean slope of a contact along x"),
    "contact_slope_y": ("slope_y", "1", "mean slope of a contact along y; it opposes the directions in which it rises"),
}


def contact_picture(result: Result, load: float | None = None) -> xarray.Dataset | None:
    """Heights, contacts and pressures of the member whose true area is the median one.

    Parameters
    ----------
    result : xarray.Dataset or Stored
        Of measured areas; of all others there is no picture.
    load : float, mN, optional
        By default the first that its study asks for.

    Returns
    -------
    xarray.Dataset or None
        upper_height and lower_height (µm) over height_y and height_x; every contact over contact: contact_x, contact_y,
        contact_force, contact_patch_area, contact_slope_x, contact_slope_y; of the half-space also zoom_pressure (GPa)
        and zoom_height (µm) over zoom_y and zoom_x, about the contact that carries most of those inside. Attributes
        member, load_mN, x and y (µm, how far the upper map is moved). None where no member has an answer.

    Raises
    ------
    ValueError
        If the files that the study names are not there any more.
    """
    study = study_of_result(result)
    if not study.is_measured or not study.is_areal:
        return None
    assert isinstance(study.friction, MeasuredFriction)
    load = float(study.friction.load[0]) if load is None else load
    members = member_values(result, [load]).isel(cut_off=0, load=0)
    area = members["contact_area"].values
    if not np.isfinite(area).any():
        return None
    index = int(members["repetition"].values[typical(area)])
    member = bodies_of(study).member(index, float(study.surfaces.cells()["cut_off"][0]))
    upper, lower = member.pair
    assert isinstance(upper, Surface)
    assert isinstance(lower, Surface)
    pressed = OneLoad.of(study, member.pair, load)
    if pressed is None:
        return None
    attributes = {"member": index, "load_mN": load, "x": member.x, "y": member.y}
    return _dataset(upper, lower, pressed.table(), pressed.pressure()).assign_attrs(attributes)


def picture_beside(result: Stored) -> xarray.Dataset | None:
    """The picture that lies beside a stored result, if there is one; a `StoreError` if it is damaged."""
    zoom = ("zoom_pressure", "zoom_height") if result.study.by_half_space else ()
    return read_beside(result.path / FILE, (*_OF_CONTACTS, "upper_height", "lower_height", *zoom))


def typical(area: Floats) -> int:
    """The place of the value that is nearest to the median one of those that are known."""
    return int(np.nanargmin(np.abs(area - np.nanmedian(area))))


def _dataset(upper: Surface, lower: Surface, table: Table, pressure: Floats | None) -> xarray.Dataset:
    import xarray

    (rows, columns), (dy, dx) = lower.heights.shape, lower.spacing
    step = -(-max(rows, columns) // MOST_PICTURED)
    length = {"units": "um"}
    variables: dict[str, Any] = {
        f"{side}_height": (("height_y", "height_x"), body.heights[::step, ::step], length)
        for side, body in (("upper", upper), ("lower", lower))
    }
    variables |= {
        name: ("contact", getattr(table, own), {"units": unit, "long_name": words})
        for name, (own, unit, words) in _OF_CONTACTS.items()
    }
    coordinates: dict[str, Any] = {
        "height_y": ("height_y", np.arange(0, rows, step) * dy, length),
        "height_x": ("height_x", np.arange(0, columns, step) * dx, length),
    }
    if pressure is not None:
        inside = ~table.at_edge if (~table.at_edge).any() else np.ones(table.force.size, dtype=bool)
        most = int(np.argmax(np.where(inside, table.force, -1.0)))
        box = tuple(_around(at, size) for at, size in ((table.y[most] / dy, rows), (table.x[most] / dx, columns)))
        variables["zoom_pressure"] = (("zoom_y", "zoom_x"), pressure[box], {"units": "GPa"})
        variables["zoom_height"] = (("zoom_y", "zoom_x"), lower.heights[box], length)
        for name, part, width in zip(("zoom_y", "zoom_x"), box, (dy, dx), strict=True):
            coordinates[name] = (name, np.arange(part.start, part.stop) * width, attributes_of(name[-1]))
    return xarray.Dataset(variables, coordinates)


def _around(at: float, size: int) -> slice:
    part = min(max(size // AROUND_LARGEST, FEWEST_POINTS), size)
    first = int(np.clip(at - part / 2, 0, size - part))
    return slice(first, first + part)
