"""The contacts of members of a result as a frame of their own: a row for each, however many a member has."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, float_array, whole_number
from stiction.studies.at_load import member_values
from stiction.studies.contact_picture import typical
from stiction.studies.maps import cells_of, study_of_result
from stiction.studies.members import bodies_of, pair_of
from stiction.studies.one_load import OneLoad
from stiction.studies.study import Study

if TYPE_CHECKING:
    import pandas
    import xarray

    from stiction.studies.contact_statistics import Table
    from stiction.studies.maps import Result

_UNITS = {"fractal_dimension": "", "amplitude": "_um", "cut_off": "_um"}
"""Of the cells, as columns have them."""


def contact_frame(result: Result, loads: ArrayLike, members: int | Sequence[int] | None = None) -> pandas.DataFrame:
    """Every contact of some members at elastic loads (mN), solved once more: see `Result.contacts`."""
    import pandas

    study = study_of_result(result)
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
                columns = {f"{name}{_UNITS[name]}": value for name, value in cell.items()}
                parts.append(
                    pandas.DataFrame({"member": index, **columns, "load_mN": load} | _columns(pressed.table()))
                )
    if not parts:
        raise ValueError("nothing touches at these loads, or no member has an answer there, so there are no contacts")
    return pandas.concat(parts, ignore_index=True)


def _checked(members: int | Sequence[int], known: list[int]) -> list[int]:
    listed = [members] if np.ndim(members) == 0 else list(members)  # type: ignore[arg-type]
    found = [whole_number("members", each, least=0) for each in listed]
    if not found or not set(found) <= set(known):
        raise ValueError(
            f"members must be some of the {len(known)} of the result, from {min(known)} on, got {members!r}"
        )
    return found


def _places(at: xarray.DataArray, loads: Floats, chosen: list[int] | None) -> Iterator[tuple[float, int]]:
    """Loads and members; unless these are given, at each load the one whose true area is nearest to the median."""
    for load in loads.tolist():
        if chosen is not None:
            yield from ((load, index) for index in chosen)
            continue
        area = at.sel(load=load).values
        if np.isfinite(area).any():
            yield load, int(at["repetition"].values[typical(area)])


def _pair(study: Study, index: int, cell: dict[str, float]) -> Any:
    if study.is_measured:
        return bodies_of(study).member(index, cell["cut_off"]).pair
    return pair_of(study, index, **cell)


def _columns(table: Table) -> dict[str, Any]:
    return {
        "x_um": table.x, "y_um": table.y, "force_mN": table.force, "area_um2": table.area,
        "mean_pressure_GPa": table.force / table.area, "slope_x": table.slope_x, "slope_y": table.slope_y,
        "at_edge": table.at_edge,
    }  # fmt: skip
