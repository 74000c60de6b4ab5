"""Ensemble means at given loads. The friction coefficient is the mean tangential load over the mean normal load."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.evaluate import intervals
from stiction.evaluate.intervals import INTERVAL_STATISTICS
from stiction.evaluate.maps import evaluate_ensemble_quantities, find_cell_dimensions
from stiction.evaluate.member_means import find_axes_with_both_directions
from stiction.evaluate.member_values import interpolate_member_sums, member_values
from stiction.mechanics.friction import LOAD_SUM_NAMES, FrictionLaw
from stiction.mechanics.quantities import (
    INTERPOLATED_QUANTITIES,
    QUANTITIES,
    RATIO_QUANTITIES,
    is_requested,
    quantity_attributes,
)
from stiction.solve.member_sums import MemberSums
from stiction.study.study import find_step_dimension

if TYPE_CHECKING:
    import xarray

MIN_STIFFNESS_STEPS = 3


def average_ensemble(
    result: MemberSums, loads: Floats, mu0: Floats, tau0: Floats, names: Collection[str] | None
) -> xarray.Dataset:
    """Return ensemble means of friction and other quantities at given mean normal loads, with 95 % intervals.

    `names` lists quantities to evaluate besides friction; None stands for all.
    """
    import xarray

    head = result.head
    ratio_names = [name for name in RATIO_QUANTITIES if is_requested(name, names)]
    evaluate = partial(_evaluate_direction_groups, result, loads, mu0, tau0, includes_ratios=bool(ratio_names))
    quantities = [name for name in _list_ensemble_quantities(head) if is_requested(name, names)]
    # Friction carries part of the normal load, so area and stiffness at a normal load depend slightly on mu0 and tau0.
    if "direction" in head.dims:
        all_directions = np.arange(head.sizes["direction"])[np.newaxis]
        means = evaluate(["friction_coefficient", *quantities], all_directions)
        means = {name: table.isel(direction=0) for name, table in means.items()}
        coefficient_table = evaluate(["friction_coefficient"])["friction_coefficient"]
    else:
        means = evaluate(["friction_coefficient", *quantities])
        coefficient_table = means["friction_coefficient"]
    variables: dict[str, Any] = {
        "friction_coefficient": _add_statistic_dimension(coefficient_table, "friction_coefficient"),
        "status": coefficient_table["status"].variable,
    }
    if "direction" in head.dims:
        variables["mean_friction"] = _add_statistic_dimension(means["friction_coefficient"], "friction_coefficient")
        axes, direction_pairs = find_axes_with_both_directions(head["direction"].values)
        if axes.size:
            axis_means = _add_statistic_dimension(
                evaluate(["friction_coefficient"], direction_pairs)["friction_coefficient"], "friction_coefficient"
            )
            dims = ["axis" if dim == "direction" else dim for dim in axis_means.dims]
            variables["friction_by_axis"] = xarray.Variable(dims, axis_means.values, axis_means.attrs)
            coefficient_table = coefficient_table.assign_coords(axis=("axis", axes, quantity_attributes("axis")))
    variables |= {name: _add_statistic_dimension(means[name], name) for name in quantities}
    if result.study.contact.adheres and is_requested("pull_off", names):
        variables |= _average_unloaded_members(result, loads[:1], mu0, tau0)
    coefficients = means["friction_coefficient"]
    variables |= {name: coefficients[name].variable for name in ratio_names if name in coefficients}
    variables |= {"members": ((), result.members.size, {"units": "1", "long_name": "members"})}
    dataset = xarray.Dataset(variables, coefficient_table.coords, coefficient_table.attrs).assign_coords(
        statistic=INTERVAL_STATISTICS
    )
    return dataset.transpose(*find_cell_dimensions(dataset), ...)


def _list_ensemble_quantities(head: xarray.Dataset) -> list[str]:
    """Return the names of all quantities with ensemble means, except friction and ratios such as the mean pressure."""
    has_stiffness = head.sizes[find_step_dimension(head)] >= MIN_STIFFNESS_STEPS
    stored_names = [name for name in INTERPOLATED_QUANTITIES if QUANTITIES[name].shown and name in head.data_vars]
    return [*stored_names, *(["normal_stiffness"] if has_stiffness else [])]


def _evaluate_direction_groups(
    result: MemberSums, loads: Floats, mu0: Floats, tau0: Floats, quantities: Sequence[str],
    groups: NDArray[np.intp] | None = None, *, includes_ratios: bool,
) -> dict[str, xarray.Dataset]:  # fmt: skip
    """Evaluate quantities at given mean normal loads, averaged over the directions of motion in each group.

    The groups are direction indices with the shape (groups, directions). Without groups, no average is computed.
    """
    import xarray

    def average_groups(piece: xarray.Dataset) -> xarray.Dataset:
        grouped_piece = piece.isel(direction=xarray.DataArray(groups, dims=("group", "way")))
        grouped_piece = grouped_piece.mean("way", skipna=False, keep_attrs=True).rename(group="direction")
        return grouped_piece.assign_coords(
            direction=("direction", np.arange(grouped_piece.sizes["direction"], dtype=float))
        )

    transform = None if groups is None else average_groups
    return evaluate_ensemble_quantities(
        result, loads, mu0, tau0, quantities, transform, includes_ratios=includes_ratios
    )


def _average_unloaded_members(result: MemberSums, loads: Floats, mu0: Floats, tau0: Floats) -> dict[str, Any]:
    """Average the pull-off force and the friction force at zero external load over the members.

    A further mean is the fraction of the members whose pull-off force is only a lower bound.
    """
    import xarray

    variables = {}
    members = member_values(result, loads, mu0=mu0, tau0=tau0)
    for name in ("pull_off", "share_of_pull_off_bounds", "friction_at_no_load"):
        values = members[name].transpose("repetition", ...)
        means = np.stack(intervals.average_independent_values(values.values), axis=-1)
        first_rule = {dim: 0 for dim in values.dims if dim == "sliding" and dim not in result.head.dims}
        variables[name] = xarray.Variable((*values.dims[1:], "statistic"), means, values.attrs).isel(first_rule)
    return variables


def _add_statistic_dimension(table: xarray.Dataset, name: str) -> xarray.Variable:
    """Combine a mean and its interval limits in one variable with the dimension `statistic`."""
    import xarray

    variable = table[name]
    estimates = np.stack([table[column].values for column in (name, "lower", "upper")], axis=-1)
    return xarray.Variable((*variable.dims, "statistic"), estimates, variable.attrs)


def compute_ensemble_friction(
    result: MemberSums | xarray.Dataset, loads: Floats, mu0: Floats, tau0: Floats
) -> xarray.DataArray:
    """Return the friction coefficient mean(F_T) / mean(F_N) with its jackknife interval, at given loads (mN).

    The given loads are those that the contacts carry without friction.

    The means are taken over members and directions. The dimensions are cells, sliding, load, mu0, tau0 and statistic.
    The coefficient is NaN if mean(F_N) is not above 0.
    """
    import xarray

    contact_sums = interpolate_member_sums(result, loads).mean("direction")
    dims = [str(dim) for dim in contact_sums[LOAD_SUM_NAMES[0]].dims if dim != "repetition"]
    sums = {
        name: contact_sums[name].transpose("repetition", *dims).values[..., np.newaxis, np.newaxis]
        for name in LOAD_SUM_NAMES
    }
    law = FrictionLaw(mu0[:, np.newaxis], tau0)
    # Array of the shape (2, members, ..., mu0, tau0): normal loads at index 0 of the first axis, tangential loads at 1.
    member_loads = np.stack([law.load("normal", sums), law.load("tangential", sums)])
    load_sums = member_loads.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where(load_sums[0] > 0, load_sums[1] / load_sums[0], np.nan)
        sums_without_member = load_sums[:, np.newaxis] - member_loads
        jackknife_changes = sums_without_member[1] / sums_without_member[0] - mean
    jackknife_sums = intervals.PowerSums(mean.shape)
    jackknife_sums.add_values(np.moveaxis(jackknife_changes, 0, -1))
    half_width = (
        jackknife_sums.half_width() if contact_sums.sizes["repetition"] >= intervals.MIN_SAMPLE_SIZE else np.nan
    )
    estimates = np.stack([mean, np.maximum(mean - half_width, 0.0), mean + half_width], axis=-1)
    attributes = quantity_attributes("friction_coefficient")
    return xarray.DataArray(estimates, dims=(*dims, "mu0", "tau0", "statistic"), attrs=attributes)
