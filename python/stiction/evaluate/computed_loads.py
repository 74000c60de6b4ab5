"""Comparison of requested loads with the loads of a result: which loads lack a coefficient, and why."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiction.evaluate.maps import find_cell_dimensions
from stiction.evaluate.point import is_unloaded
from stiction.mechanics.friction import (
    STATUS_BELOW_RANGE,
    STATUS_NOT_REACHED,
    STATUS_NOT_SOLVED,
    STATUSES_WITH_COEFFICIENT,
)

if TYPE_CHECKING:
    import xarray
    from numpy.typing import ArrayLike

    from stiction.solve.member_sums import MemberSums
    from stiction.study.study import Study

_MEAN_LOAD_ROUND_OFF = 1e-6

NOT_COMPUTED_STATUSES = (STATUS_BELOW_RANGE, STATUS_NOT_REACHED, STATUS_NOT_SOLVED)
"""Statuses of requested loads that were not computed. All other statuses describe the contact."""


def find_loads_without_values(result: MemberSums, values: xarray.Dataset) -> list[float]:
    """Return the loads (mN) in a dataset that were not computed, and therefore have no coefficient.

    A computed load without a coefficient, for example because the contact is self-locked, is not returned. Neither is a
    negligible load on adhesive bodies, for which there is a pull-off force.
    """
    statuses = values["status"]
    other_dims = [dim for dim in statuses.dims if dim != "load"]
    loads = np.atleast_1d(values["load"].values)
    is_computed = np.atleast_1d((~statuses.isin(NOT_COMPUTED_STATUSES)).any(other_dims).values)
    has_coefficient = np.atleast_1d(statuses.isin(STATUSES_WITH_COEFFICIENT).any(other_dims).values)
    outside_loads = [] if has_coefficient.all() else find_loads_outside_range(result, values)
    is_missing = ~has_coefficient & (~is_computed | np.isin(loads, outside_loads))
    return [float(load) for load in loads[is_missing] if not is_unloaded(values.sel(load=load))]


def find_computed_load_range(result: MemberSums, values: xarray.Dataset | None = None) -> tuple[float, float]:
    """Return the smallest and the largest computed load (mN), where each load is a mean over members without friction.

    If a selection from `Result.at` is given as `values`, only its cutoffs, or its dimensions D and amplitudes, are
    considered.
    """
    loads = result.mean_elastic_loads
    if values is not None:
        selection = {
            name: np.atleast_1d(values[name].values)
            for name in find_cell_dimensions(loads.to_dataset(name="load_of_step"))
            if name in values.coords
        }
        loads = loads.sel(selection)
    computed_loads = loads.values[loads.values > 0]
    return float(computed_loads.min(initial=np.inf)), float(computed_loads.max(initial=0.0))


def find_neighbouring_loads(study: Study, loads: ArrayLike) -> dict[float, tuple[float, float]]:
    """Return the computed loads (mN) directly below and above each requested load.

    Requested loads that were computed, or that are outside the computed range, are left out. The result is empty for
    measured bodies, and if the steps are approaches.
    """
    if study.is_measured or study.step_quantity != "load":
        return {}
    steps = np.asarray(study.contact.loading_steps())
    neighbours = {}
    for load in np.atleast_1d(np.asarray(loads, float)).tolist():
        index = int(np.searchsorted(steps, load))
        is_computed = np.isclose(steps, load, rtol=_MEAN_LOAD_ROUND_OFF, atol=0.0).any()
        if 0 < index < steps.size and not is_computed:
            neighbours[load] = float(steps[index - 1]), float(steps[index])
    return neighbours


def find_loads_outside_range(result: MemberSums, values: xarray.Dataset) -> list[float]:
    """Return the loads (mN) outside the computed range, unless they are negligible compared with the pull-off force."""
    lowest_load, highest_load = find_computed_load_range(result, values)
    return [
        float(load)
        for load in np.atleast_1d(values["load"].values)
        if not lowest_load * (1 - _MEAN_LOAD_ROUND_OFF) <= load <= highest_load * (1 + _MEAN_LOAD_ROUND_OFF)
        and not is_unloaded(values.sel(load=load))
    ]
