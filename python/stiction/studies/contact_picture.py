"""The contacts of members, solved once more: of a typical one for pictures, kept as a small file, and as a frame."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array, whole_number
from stiction.mechanics.half_space import HalfSpaceCurve, half_space
from stiction.mechanics.model import THICKNESS
from stiction.mechanics.quantities import attributes_of
from stiction.studies.contact_statistics import Table
from stiction.studies.contact_tables import HalfSpace
from stiction.studies.evaluation import member_values
from stiction.studies.maps import cells_of
from stiction.studies.measured_surfaces import Measured
from stiction.studies.member_solution import OneLoad
from stiction.studies.members import load_bodies, pair_of
from stiction.studies.result import Result
from stiction.studies.store import StoredResult, read_companion
from stiction.studies.study import Study
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import pandas
    import xarray

FILE = "picture.nc"  # name of the file in the folder of a result
MOST_PICTURED = 512  # rows and columns of a map that are kept
IN_PULL_OFFS = (0.25, 0.5, 1, 2, 3, 4)  # loads over the pull-off force at which coming and going are drawn
AROUND_LARGEST = 8  # the part of the map that is kept of the pressure about the contact that carries most
FEWEST_POINTS = 16

_OF_CONTACTS = {
    "contact_x": ("x", "um", "middle of a contact along x"),
    "contact_y": ("y", "um", "middle of a contact along y"),
    "contact_force": ("force", "mN", "load on a contact"),
    "contact_patch_area": ("area", "um^2", "area of a contact on the ground plan"),
    "contact_slope_x": ("slope_x", "1", "mean slope of a contact along x"),
    "contact_slope_y": ("slope_y", "1", "mean slope of a contact along y; it opposes the directions in which it rises"),
    "contact_at_edge": ("at_edge", "1", "whether a contact reaches the edge of the scans"),
}

_UNITS = {"fractal_dimension": "", "amplitude": "_um", "cut_off": "_um"}  # of the cells, as columns have them


def contact_picture(result: Result | xarray.Dataset, load: float | None = None) -> xarray.Dataset | None:
    """Heights, contacts and pressures of the member whose true area is nearest to the mean.

    Parameters
    ----------
    result : Result, or xarray.Dataset of member sums
        Of measured bodies; of all others there is no picture.
    load : float, mN, optional
        By default the first that its study asks for.

    Returns
    -------
    xarray.Dataset or None
        Of maps upper_height and lower_height (µm) over height_y and height_x, and patch, the number of the contact at
        each place from 1 on; of the half-space also zoom_pressure (GPa) and zoom_height (µm) over zoom_y and zoom_x,
        about the contact that carries most of those inside. Of lines lower_height and gap (µm) over height_x. Every
        contact over contact: contact_x, contact_y, contact_force, contact_patch_area, contact_slope_x, contact_slope_y,
        contact_at_edge. Attributes member, load_mN, x and y (µm, how far the upper body is moved). None where no member
        has an answer.

    Raises
    ------
    ValueError
        If the files that the study names are not there any more.
    """
    result = Result.of(result)
    study = result.study
    if not isinstance(study.surfaces, Measured):
        return None
    load = float(study.friction.load[0]) if load is None else load
    cut_off = study.surfaces.quoted_cut_off()
    members = member_values(result, [load]).isel(load=0).sel(cut_off=cut_off)
    area = members["contact_area"].values
    if not np.isfinite(area).any():
        return None
    index = int(members["repetition"].values[typical(area)])
    member = load_bodies(study).member(index, cut_off)
    pressed = OneLoad.of(study, member.pair, load)
    if pressed is None:
        return None
    table = pressed.table()
    made = _of_maps(pressed, table) if study.is_areal else _of_lines(pressed)
    for name, (own, unit, words) in _OF_CONTACTS.items():
        made[name] = ("contact", getattr(table, own).astype(np.float64), {"units": unit, "long_name": words})
    return made.assign_attrs({"member": index, "load_mN": load, "x": member.x, "y": member.y})


def coming_and_going(result: Result) -> xarray.Dataset | None:
    """Load, area (µm²) and approach of a member that adheres, pressed and drawn apart; None if not solved."""
    import xarray

    study = result.study
    contact = study.contact
    if not isinstance(contact, HalfSpace) or not contact.adheres:
        return None
    most, first = float(contact.steps()[-1]), dict.fromkeys(study.surfaces.cells(), 0)
    found = member_values(result, [most])["contact_area"].isel(first)
    area, members = found.values[:, 0], found["repetition"].values
    index = int(members[typical(area)]) if np.isfinite(area).any() else 0
    cell = {name: float(values[0]) for name, values in study.surfaces.cells().items()}
    try:
        pair = _pair(study, index, cell)
        pressed: Any = functools.partial(half_space, *pair, **contact.solid())
        loads = np.array([0, *IN_PULL_OFFS]) * pressed([0.0]).pull_off
        loads = np.append(loads[loads < most], most)
        coming, going = pressed(loads), pressed(loads[::-1])
        ways = [coming, going, going.parting]
    except (RuntimeError, ValueError, OSError):
        return None
    names = ("load", "contact_load", "contact_area", "approach")
    table = {name: ("point", np.concatenate([getattr(each, name) for each in ways])) for name in names}
    table["going"] = ("point", np.repeat([False, True, True], [each.load.size for each in ways]))
    nominal = pair[1].extent * THICKNESS if isinstance(pair[1], Profile) else math.prod(pair[1].extent)
    return xarray.Dataset(table, attrs={"nominal_area": nominal, "member": index})


def load_contact_picture(result: StoredResult) -> xarray.Dataset | None:
    """The picture that lies beside a stored result, if there is one; a `StoreError` if it is damaged."""
    zoom = ("zoom_pressure", "zoom_height") if result.study.uses_half_space else ()
    of_bodies = ("upper_height", "patch", *zoom) if result.study.is_areal else ("gap",)
    return read_companion(result.path / FILE, (*_OF_CONTACTS, "lower_height", *of_bodies))


def typical(area: Floats) -> int:
    """The place of the value that is nearest to the mean of those that are known."""
    return int(np.nanargmin(np.abs(area - np.nanmean(area))))


def _of_lines(pressed: OneLoad) -> xarray.Dataset:
    import xarray

    upper, lower = pressed.upper, pressed.lower
    if isinstance(pressed.curve, HalfSpaceCurve):
        gap = pressed.curve.contact(0).gap
    else:
        gap = upper.heights - lower.heights
        gap = gap - gap.min() - pressed.curve.approach[0]
    length = {"units": "um"}
    return xarray.Dataset(
        {"lower_height": ("height_x", lower.heights, length), "gap": ("height_x", gap, length)},
        {"height_x": ("height_x", lower.x - lower.x[0], length)},
    )


def _of_maps(pressed: OneLoad, table: Table) -> xarray.Dataset:
    import xarray

    upper, lower, pressure = pressed.upper, pressed.lower, None
    if isinstance(pressed.curve, HalfSpaceCurve):
        solved = pressed.curve.at(0)
        pressure, patch = solved.on_grid(solved.values), solved.on_grid(solved.patch)
    else:
        patch = _discs(lower, table)
    (rows, columns), (dy, dx) = lower.heights.shape, lower.spacing
    step = -(-max(rows, columns) // MOST_PICTURED)
    length = {"units": "um"}
    variables: dict[str, Any] = {
        f"{side}_height": (("height_y", "height_x"), body.heights[::step, ::step], length)
        for side, body in (("upper", upper), ("lower", lower))
    }
    variables["patch"] = (("height_y", "height_x"), patch[::step, ::step].astype(np.int32), {"units": "1"})
    coordinates: dict[str, Any] = {
        "height_y": ("height_y", np.arange(0, rows, step) * dy, length),
        "height_x": ("height_x", np.arange(0, columns, step) * dx, length),
    }
    if pressure is not None:
        inside = ~table.at_edge if (~table.at_edge).any() else np.ones(table.force.size, dtype=bool)
        most = int(np.argmax(np.where(inside, table.force, -1.0)))
        box = []
        for at, size in ((table.y[most] / dy, rows), (table.x[most] / dx, columns)):
            part = min(max(size // AROUND_LARGEST, FEWEST_POINTS), size)
            first = int(np.clip(at - part / 2, 0, size - part))
            box.append(slice(first, first + part))
        variables["zoom_pressure"] = (("zoom_y", "zoom_x"), pressure[*box], {"units": "GPa"})
        variables["zoom_height"] = (("zoom_y", "zoom_x"), lower.heights[*box], length)
        for name, part, width in zip(("zoom_y", "zoom_x"), box, (dy, dx), strict=True):
            coordinates[name] = (name, np.arange(part.start, part.stop) * width, attributes_of(name[-1]))
    return xarray.Dataset(variables, coordinates)


def _discs(lower: Surface, table: Table) -> NDArray[Any]:
    """Numbers of the contacts of asperities over a map, as discs of their areas."""
    found, (dy, dx) = np.zeros(lower.heights.shape, np.int32), lower.spacing
    for number, (x, y, radius) in enumerate(zip(table.x, table.y, np.sqrt(table.area / np.pi), strict=True), 1):
        low, high = (
            np.maximum([(y + way * radius) / dy, (x + way * radius) / dx], 0).round().astype(int) for way in (-1, 1)
        )
        rows, columns = (np.arange(first, last + 1) for first, last in zip(low, high, strict=True))
        inside = np.hypot(rows[:, np.newaxis] * dy - y, columns * dx - x) <= radius + min(dx, dy) / 2
        part = found[low[0] : high[0] + 1, low[1] : high[1] + 1]
        part[inside[: part.shape[0], : part.shape[1]]] = number
    return found


# ---- As a frame -----------------------------------------------------------------------------------------------------


def contact_frame(result: Result, loads: ArrayLike, members: int | Sequence[int] | None = None) -> pandas.DataFrame:
    """Every contact of some members at elastic loads (mN), solved once more: see `Result.contacts`."""
    import pandas

    study = result.study
    wanted = np.unique(np.atleast_1d(float_array("load", loads)))
    if not wanted.size or not (wanted > 0).all():
        raise ValueError(f"load must be above 0 mN, got {loads!r}")
    areas = member_values(result, wanted)["contact_area"]
    chosen = None if members is None else _checked(members, areas["repetition"].values.tolist())
    cells = cells_of(areas.to_dataset())
    parts = []
    for place in np.ndindex(*(areas.sizes[name] for name in cells)):
        at = areas.isel(dict(zip(cells, place, strict=True)))
        cell = {name: float(at[name]) for name in cells}
        for load, index in _places(at, wanted, chosen):
            pressed = OneLoad.of(study, _pair(study, index, cell), load)
            if pressed is not None:
                columns: dict[str, Any] = {f"{name}{_UNITS[name]}": value for name, value in cell.items()}
                table = pressed.table()
                columns |= {"load_mN": load, "x_um": table.x, "y_um": table.y, "force_mN": table.force}
                columns |= {"area_um2": table.area, "mean_pressure_GPa": table.force / table.area}
                columns |= {"slope_x": table.slope_x, "slope_y": table.slope_y, "at_edge": table.at_edge}
                parts.append(pandas.DataFrame({"member": index} | columns))
    if not parts:
        raise ValueError("nothing touches at these loads, or no member has an answer there, so there are no contacts")
    return pandas.concat(parts, ignore_index=True)


def _checked(members: int | Sequence[int], known: list[int]) -> list[int]:
    listed = [members] if np.ndim(members) == 0 else list(members)  # type: ignore[arg-type]
    found = [whole_number("members", each, minimum=0) for each in listed]
    if not found or not set(found) <= set(known):
        raise ValueError(
            f"members must be some of the {len(known)} of the result, from {min(known)} on, got {members!r}"
        )
    return found


def _places(at: xarray.DataArray, loads: Floats, chosen: list[int] | None) -> Iterator[tuple[float, int]]:
    """Loads and members; unless these are given, at each load the one whose true area is nearest to the mean."""
    for load in loads.tolist():
        if chosen is not None:
            yield from ((load, index) for index in chosen)
            continue
        area = at.sel(load=load).values
        if np.isfinite(area).any():
            yield load, int(at["repetition"].values[typical(area)])


def _pair(study: Study, index: int, cell: dict[str, float]) -> Any:
    if study.is_measured:
        return load_bodies(study).member(index, cell["cut_off"]).pair
    return pair_of(study, index, **cell)
