"""Growth of the true area under shear, and its effect on the values of members."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.evaluate.hardness_nodes import AreaInterpolator
from stiction.evaluate.maps import MOTION_DIMENSIONS, find_cell_dimensions
from stiction.mechanics import friction
from stiction.mechanics.closed_forms import hardness_under_shear
from stiction.mechanics.quantities import is_requested, quantity_attributes
from stiction.solve.member_sums import MemberSums
from stiction.study.study import Study

if TYPE_CHECKING:
    import xarray

ADHESIVE_SUMS = ("normal_adhesive", "tangential_adhesive")  # contact sums that increase with junction growth


def build_area_interpolator(dataset: xarray.Dataset, result: MemberSums, mean_areas: Floats) -> AreaInterpolator:
    """Create an interpolator that returns true areas for given hardness and E* at the loads of a dataset.

    `mean_areas` are the values of `compute_mean_areas`.
    """
    study, loads = result.study, dataset["load"].values
    area = dataset["contact_area"].sel(statistic="mean")
    area_per_load = area.mean([dim for dim in area.dims if dim != "load"]).values / loads
    gradient = float(dataset["rms_gradient"].sel(statistic="mean").mean())
    return AreaInterpolator.from_result(
        loads, area_per_load, gradient, compute_area_load_exponent(study, mean_areas, loads), study, result
    )


def build_member_area_interpolator(members: xarray.Dataset, result: MemberSums) -> AreaInterpolator:
    """Create an interpolator that returns true areas for a given hardness at the loads of the member values."""
    loads, area, gradient = members["load"].values, members["contact_area"], members["rms_gradient"]
    area_per_load = np.asarray(area.mean([dim for dim in area.dims if dim != "load"]).values) / loads
    study = result.study
    return AreaInterpolator.from_result(
        loads, area_per_load, float(gradient.mean()), np.zeros(loads.size), study, result
    )


def compute_area_load_exponent(study: Study, mean_areas: Floats, loads: Floats) -> Floats:
    """Return d ln(A/F) / d ln F at the given loads F (mN), where A is the mean true area.

    `mean_areas` (µm²) are the mean true areas at the loading steps of the study.
    """
    step_loads = study.contact.loading_steps()
    if step_loads.size > 1:
        area_per_load = mean_areas / step_loads
        is_known = np.isfinite(area_per_load) & (area_per_load > 0)
        if is_known.sum() > 1:
            exponent = np.gradient(np.log(area_per_load[is_known]), np.log(step_loads[is_known]))
            return np.asarray(np.interp(np.log(loads), np.log(step_loads[is_known]), exponent))
    return np.zeros(loads.size)


def compute_area_growth_ratio(areas: AreaInterpolator, study: Study, rule: str, mu0: Floats, tau0: Floats) -> Floats:
    """Return the ratio of the true area at the onset of sliding to the true area before shear.

    The ratio has the shape (loads, mu0, tau0), and is infinite at seizure.
    """
    assert areas.hardness is not None, "contacts that do not yield do not grow"
    pressure = hardness_under_shear(areas.hardness, mu0[:, np.newaxis], tau0, float(study.contact.junction_growth or 0))
    hardness = np.full(pressure.size, areas.hardness)
    growth_ratios = [areas.growth_ratio(load, rule, hardness, pressure.ravel()) for load in range(areas.pressures.size)]
    return np.array(growth_ratios).reshape(-1, *pressure.shape)


def apply_junction_growth(
    members: xarray.Dataset, study: Study, areas: AreaInterpolator, names: Collection[str] | None = None
) -> xarray.Dataset:
    """Recompute member values after junction growth. The adhesive forces then act on the grown contact area."""
    mu0, tau0 = members["mu0"].values, members["tau0"].values
    rules = members["sliding"].values.tolist()
    growth_ratios = {rule: compute_area_growth_ratio(areas, study, rule, mu0, tau0) for rule in ("all", *rules)}
    with np.errstate(invalid="ignore"):
        growth_factor = np.stack([growth_ratios[rule] for rule in rules])[
            :, np.newaxis
        ]  # shape (sliding, 1, load, mu0, tau0)
        added_strength = np.where(tau0 > 0, tau0 * (growth_factor - 1), 0.0)
    dims = (*find_cell_dimensions(members), "repetition", *MOTION_DIMENSIONS, "load", "mu0", "tau0")
    with np.errstate(invalid="ignore"):
        normal, tangential = (
            members[f"{name}_load"].transpose(*dims).values
            + added_strength * members[f"{name}_adhesive"].transpose(*dims[:-2]).values[..., np.newaxis, np.newaxis]
            for name in ("normal", "tangential")
        )
    status = members["status"].transpose(*dims).values.copy()
    has_coefficient = status == friction.STATUS_OK
    status[has_coefficient & (normal <= 0)] = friction.STATUS_SELF_LOCKED
    status[has_coefficient & np.isinf(added_strength)] = friction.STATUS_SEIZURE
    with np.errstate(invalid="ignore", divide="ignore"):
        coefficient = np.where(status == friction.STATUS_OK, tangential / normal, np.nan)
    values = {
        "friction_coefficient": coefficient, "normal_load": normal, "tangential_load": tangential, "status": status
    }  # fmt: skip
    grown_variables: dict[str, Any] = {name: (dims, each, members[name].attrs) for name, each in values.items()}
    if is_requested("contact_area_at_onset", names):
        growth_at_onset = np.where(np.isfinite(growth_ratios["all"]), growth_ratios["all"], np.nan)
        area_dims = tuple(dim for dim in dims if dim not in MOTION_DIMENSIONS)
        area = members["contact_area"].transpose(*area_dims[:-2]).values[..., np.newaxis, np.newaxis] * growth_at_onset
        grown_variables["contact_area_at_onset"] = (area_dims, area, quantity_attributes("contact_area_at_onset"))
    return members.drop_vars(ADHESIVE_SUMS).assign(grown_variables)
