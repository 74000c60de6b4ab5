"""Contact map of a typical member, for storage with a result, and tables of the contacts of any member.

A result stores only sums over contacts, so the contact of each selected member is computed again.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array, unwrap_scalar, validate_whole_number
from stiction._errors import NoSolutionError
from stiction._units import short_repr
from stiction.evaluate.maps import find_cell_dimensions
from stiction.evaluate.member_values import member_values
from stiction.mechanics.half_space import HalfSpaceCurve, half_space
from stiction.mechanics.model import PROFILE_WIDTH
from stiction.mechanics.quantities import quantity_attributes
from stiction.solve.contact_statistics import ContactList
from stiction.solve.member_solution import PressedPair
from stiction.solve.member_sums import MemberSums
from stiction.solve.store import CONTACT_PICTURE_FILE, StoredResult, read_companion_file
from stiction.study.contact_settings import HalfSpaceSettings
from stiction.study.measured_surfaces import MeasuredSurfaceSettings
from stiction.study.members import pair_of, read_measured_bodies
from stiction.study.stored_values import POSITIVE_STORED_VALUE_BOUNDS, STORED_VALUE_BOUNDS, AttributeSpec, VariableSpec
from stiction.study.study import Study
from stiction.surfaces.pairing import SIDES
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import pandas
    import xarray

MAX_PICTURE_SIDE_POINTS = 512
LOADS_RELATIVE_TO_PULL_OFF = (0.25, 0.5, 1, 2, 3, 4)
ZOOM_FACTOR = 8
MIN_ZOOM_SIDE_POINTS = 16

_CONTACT_VARIABLE_SPECS = {
    "contact_x": ("x", "um", "centre of a contact along x"),
    "contact_y": ("y", "um", "centre of a contact along y"),
    "contact_force": ("force", "mN", "load on a contact"),
    "contact_patch_area": ("area", "um^2", "projected area of a contact"),
    "contact_slope_x": ("slope_x", "1", "mean slope of a contact along x"),
    "contact_slope_y": (
        "slope_y",
        "1",
        "mean slope of a contact along y; it opposes motion in directions of positive slope",
    ),
    "contact_at_edge": ("at_edge", "1", "whether a contact reaches the edge of the scans"),
}

_COLUMN_SUFFIXES = {"fractal_dimension": "", "amplitude": "_um", "cut_off": "_um"}


def contact_picture(result: MemberSums | xarray.Dataset, load: float | None = None) -> xarray.Dataset | None:
    """Compute heights, contacts and pressures of the member whose true area is nearest to the mean over members.

    Parameters
    ----------
    result : Result, or xarray.Dataset of member sums
        Result of measured bodies; generated bodies have no contact picture.
    load : float, mN, optional
        By default the first load in the table `[friction]` of the study.

    Returns
    -------
    xarray.Dataset or None
        For maps: upper_height and lower_height (µm) with dimensions height_y and height_x, and patch, which is the
        number of the contact at each point, counted from 1. With the half-space also zoom_pressure (GPa) and
        zoom_height (µm) with dimensions zoom_y and zoom_x, around the contact with the largest load. For
        lines: lower_height and gap (µm) with dimension height_x. With dimension contact: contact_x, contact_y,
        contact_force, contact_patch_area, contact_slope_x, contact_slope_y, contact_at_edge. Attributes: member,
        load_mN, x and y (µm, shift of the upper body). Returns None if the solver failed for all members.

    Raises
    ------
    ValueError
        If files of the study are missing.
    """
    result = MemberSums.of(result)
    study = result.study
    if not isinstance(study.surfaces, MeasuredSurfaceSettings):
        return None
    load = float(study.friction.load[0]) if load is None else load
    cut_off = study.surfaces.reported_cut_off()
    member_table = member_values(result, [load]).isel(load=0).sel(cut_off=cut_off)
    areas = member_table["contact_area"].values
    if not np.isfinite(areas).any():
        return None
    index = int(member_table["repetition"].values[find_index_nearest_to_mean(areas)])
    member = read_measured_bodies(study).member(index, cut_off)
    solution = PressedPair.solve(study, member.pair, load)
    if solution is None:
        return None
    table = solution.tabulate_contacts()
    picture = (
        _build_map_picture_dataset(solution, table) if study.is_areal else _build_profile_picture_dataset(solution)
    )
    for name, (column, unit, long_name) in _CONTACT_VARIABLE_SPECS.items():
        picture[name] = ("contact", getattr(table, column).astype(np.float64), {"units": unit, "long_name": long_name})
    return picture.assign_attrs({"member": index, "load_mN": load, "x": member.x, "y": member.y})


def compute_loading_cycle(result: MemberSums) -> xarray.Dataset | None:
    """Compute load, true area and approach of one typical pair of bodies during adhesive loading and unloading.

    Returns None for bodies without adhesion, or if the solver fails.
    """
    import xarray

    study = result.study
    contact = study.contact
    if not isinstance(contact, HalfSpaceSettings) or not contact.adheres:
        return None
    max_load, first_cell = float(contact.loading_steps()[-1]), dict.fromkeys(study.surfaces.cell_coordinates(), 0)
    areas = member_values(result, [max_load])["contact_area"].isel(first_cell)
    cell_areas, members = areas.values[:, 0], areas["repetition"].values
    index = int(members[find_index_nearest_to_mean(cell_areas)]) if np.isfinite(cell_areas).any() else 0
    cell = {name: float(values[0]) for name, values in study.surfaces.cell_coordinates().items()}
    try:
        pair = _get_member_bodies(study, index, cell)
        solve: Any = functools.partial(half_space, *pair, **contact.solver_arguments())
        loads = np.array([0, *LOADS_RELATIVE_TO_PULL_OFF]) * solve([0.0]).pull_off
        loads = np.append(loads[loads < max_load], max_load)
        loading, unloading = solve(loads), solve(loads[::-1])
        curves = [loading, unloading, unloading.parting]
    except (NoSolutionError, ValueError, OSError):
        return None
    names = ("load", "contact_load", "contact_area", "approach")
    table = {name: ("point", np.concatenate([getattr(curve, name) for curve in curves])) for name in names}
    table["going"] = ("point", np.repeat([False, True, True], [curve.load.size for curve in curves]))
    nominal_area = pair[1].extent * PROFILE_WIDTH if isinstance(pair[1], Profile) else math.prod(pair[1].extent)
    return xarray.Dataset(table, attrs={"nominal_area": nominal_area, "member": index})


def load_contact_picture(result: StoredResult) -> xarray.Dataset | None:
    """Read the contact map stored with a result.

    Returns None if the result has no contact map.

    Raises a `StoreError` if the file is damaged.
    """
    specs = {name: VariableSpec(dims=("contact",)) for name in _CONTACT_VARIABLE_SPECS}
    specs["contact_force"] = VariableSpec(dims=("contact",), bounds=POSITIVE_STORED_VALUE_BOUNDS)
    if not result.study.is_areal:
        specs |= {name: VariableSpec(dims=("height_x",), may_be_nan=True) for name in ("lower_height", "gap")}
    else:
        map_dims = ("height_y", "height_x")
        specs |= {f"{side}_height": VariableSpec(dims=map_dims, may_be_nan=True) for side in SIDES}
        specs["patch"] = VariableSpec(dims=map_dims, dtype=int, bounds=(0, STORED_VALUE_BOUNDS[1]))
    if result.study.is_areal and result.study.uses_half_space:
        zoom_dims = ("zoom_y", "zoom_x")
        specs |= {name: VariableSpec(dims=zoom_dims, may_be_nan=True) for name in ("zoom_pressure", "zoom_height")}
    axes = sorted({dim for spec in specs.values() for dim in spec.dims} - {"contact"})
    specs |= {name: VariableSpec(dims=(name,), ascending_dim=name) for name in axes}
    return read_companion_file(result.path / CONTACT_PICTURE_FILE, specs, _CONTACT_PICTURE_ATTRIBUTE_SPECS)


_CONTACT_PICTURE_ATTRIBUTE_SPECS: dict[str, AttributeSpec] = {
    "member": AttributeSpec(dtype=int, bounds=(0, STORED_VALUE_BOUNDS[1])),
    "load_mN": AttributeSpec(bounds=POSITIVE_STORED_VALUE_BOUNDS),
    "x": AttributeSpec(may_be_nan=True),
    "y": AttributeSpec(may_be_nan=True),
}


def find_index_nearest_to_mean(area: Floats) -> int:
    """Return the index of the member whose true area is closest to the mean of the given areas.

    NaN areas are ignored.
    """
    return int(np.nanargmin(np.abs(area - np.nanmean(area))))


def _build_profile_picture_dataset(solution: PressedPair) -> xarray.Dataset:
    import xarray

    upper, lower = solution.upper, solution.lower
    if isinstance(solution.curve, HalfSpaceCurve):
        gap = solution.curve.contact(0).gap
    else:
        gap = upper.heights - lower.heights
        gap = gap - gap.min() - solution.curve.approach[0]
    length_attributes = {"units": "um"}
    return xarray.Dataset(
        {"lower_height": ("height_x", lower.heights, length_attributes), "gap": ("height_x", gap, length_attributes)},
        {"height_x": ("height_x", lower.x - lower.x[0], length_attributes)},
    )


def _build_map_picture_dataset(solution: PressedPair, table: ContactList) -> xarray.Dataset:
    import xarray

    upper, lower, pressure = solution.upper, solution.lower, None
    if isinstance(solution.curve, HalfSpaceCurve):
        solution_at_load = solution.curve.at(0)
        pressure, patch_index = (
            solution_at_load.on_grid(solution_at_load.values),
            solution_at_load.on_grid(solution_at_load.patch),
        )
    else:
        patch_index = _build_disc_map(lower, table)
    (rows, columns), (dy, dx) = lower.heights.shape, lower.spacing
    stride = -(-max(rows, columns) // MAX_PICTURE_SIDE_POINTS)
    length_attributes = {"units": "um"}
    variables: dict[str, Any] = {
        f"{side}_height": (("height_y", "height_x"), body.heights[::stride, ::stride], length_attributes)
        for side, body in (("upper", upper), ("lower", lower))
    }
    variables["patch"] = (("height_y", "height_x"), patch_index[::stride, ::stride].astype(np.int32), {"units": "1"})
    coordinates: dict[str, Any] = {
        "height_y": ("height_y", np.arange(0, rows, stride) * dy, length_attributes),
        "height_x": ("height_x", np.arange(0, columns, stride) * dx, length_attributes),
    }
    if pressure is not None:
        largest_contact = int(np.argmax(table.force))
        window_slices = []
        for centre, side_points in ((table.y[largest_contact] / dy, rows), (table.x[largest_contact] / dx, columns)):
            window_size = min(max(side_points // ZOOM_FACTOR, MIN_ZOOM_SIDE_POINTS), side_points)
            first_index = int(np.clip(centre - window_size / 2, 0, side_points - window_size))
            window_slices.append(slice(first_index, first_index + window_size))
        variables["zoom_pressure"] = (("zoom_y", "zoom_x"), pressure[*window_slices], {"units": "GPa"})
        variables["zoom_height"] = (("zoom_y", "zoom_x"), lower.heights[*window_slices], length_attributes)
        for name, window, spacing in zip(("zoom_y", "zoom_x"), window_slices, (dy, dx), strict=True):
            coordinates[name] = (name, np.arange(window.start, window.stop) * spacing, quantity_attributes(name[-1]))
    return xarray.Dataset(variables, coordinates)


def _build_disc_map(lower: Surface, table: ContactList) -> NDArray[Any]:
    """Return a map of contact numbers in which each contact is a disc of equal area at its position."""
    contact_numbers, (dy, dx) = np.zeros(lower.heights.shape, np.int32), lower.spacing
    for number, (x, y, radius) in enumerate(zip(table.x, table.y, np.sqrt(table.area / np.pi), strict=True), 1):
        first_indices, last_indices = (
            np.maximum([(y + sign * radius) / dy, (x + sign * radius) / dx], 0).round().astype(int) for sign in (-1, 1)
        )
        rows, columns = (np.arange(first, last + 1) for first, last in zip(first_indices, last_indices, strict=True))
        is_in_disc = np.hypot(rows[:, np.newaxis] * dy - y, columns * dx - x) <= radius + min(dx, dy) / 2
        window = contact_numbers[first_indices[0] : last_indices[0] + 1, first_indices[1] : last_indices[1] + 1]
        window[is_in_disc[: window.shape[0], : window.shape[1]]] = number
    return contact_numbers


# ---- Data frame -----------------------------------------------------------------------------------------------------


def build_contact_table(
    result: MemberSums, loads: ArrayLike, members: int | Sequence[int] | None = None
) -> pandas.DataFrame:
    """Return a table with one row per contact of the selected members, at given loads (mN) without friction.

    `Result.contacts` describes the columns.
    """
    import pandas

    study = result.study
    unique_loads = np.unique(np.atleast_1d(float_array("load", loads)))
    if not unique_loads.size or not (unique_loads > 0).all():
        raise ValueError(f"load must be above 0 mN, got {short_repr(loads)}")
    areas = member_values(result, unique_loads)["contact_area"]
    indices = None if members is None else _validate_member_indices(members, areas["repetition"].values.tolist())
    cell_dimensions = find_cell_dimensions(areas.to_dataset())
    frames = []
    for cell_index in np.ndindex(*(areas.sizes[name] for name in cell_dimensions)):
        cell_areas = areas.isel(dict(zip(cell_dimensions, cell_index, strict=True)))
        cell = {name: float(cell_areas[name]) for name in cell_dimensions}
        for load, index in _select_members_at_loads(cell_areas, unique_loads, indices):
            solution = PressedPair.solve(study, _get_member_bodies(study, index, cell), load)
            if solution is not None:
                columns: dict[str, Any] = {f"{name}{_COLUMN_SUFFIXES[name]}": value for name, value in cell.items()}
                table = solution.tabulate_contacts()
                columns |= {"load_mN": load, "x_um": table.x, "y_um": table.y, "force_mN": table.force}
                columns |= {"area_um2": table.area, "mean_pressure_GPa": table.force / table.area}
                columns |= {"slope_x": table.slope_x, "slope_y": table.slope_y, "at_edge": table.at_edge}
                frames.append(pandas.DataFrame({"member": index} | columns))
    if not frames:
        raise ValueError(
            "there are no contacts at these loads: the chosen members do not touch, or could not be solved; "
            "choose other loads or members"
        )
    return pandas.concat(frames, ignore_index=True)


def _validate_member_indices(members: int | Sequence[int], available: list[int]) -> list[int]:
    members = unwrap_scalar(members)
    member_list = list(members) if isinstance(members, Iterable) else [members]
    indices = [validate_whole_number("members", index, minimum=0) for index in member_list]
    if not indices or not set(indices) <= set(available):
        raise ValueError(
            f"members must be indices of the {len(available)} members "
            f"of the result (the first index is {min(available)}), got {short_repr(members)}"
        )
    return indices


def _select_members_at_loads(
    areas: xarray.DataArray, loads: Floats, indices: list[int] | None
) -> Iterator[tuple[float, int]]:
    """Yield pairs of a load (mN) and a member index: all selected members or, by default, the most typical member."""
    for load in loads.tolist():
        if indices is not None:
            yield from ((load, index) for index in indices)
            continue
        area = areas.sel(load=load).values
        if np.isfinite(area).any():
            yield load, int(areas["repetition"].values[find_index_nearest_to_mean(area)])


def _get_member_bodies(study: Study, index: int, cell: dict[str, float]) -> Any:
    if study.is_measured:
        return read_measured_bodies(study).member(index, cell["cut_off"]).pair
    return pair_of(study, index, **cell)
