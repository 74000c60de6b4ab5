"""Arrays of friction and contact quantities that a report shows for each load, mu0 and tau0."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.evaluate.point import NEGLIGIBLE_LOAD_RATIO, list_rules_with_reported_first
from stiction.mechanics import friction
from stiction.mechanics.quantities import QUANTITIES, quantity_names_shown_in
from stiction.summary.assessment import (
    MAX_AFFECTED_FRACTION,
    MIN_MERGED_AREA_FRACTION,
    Caveat,
    LimitCheck,
    assess_caveats,
    assess_ensemble_points,
    compute_checked_quantities,
    find_smallest_check_limit,
    list_contact_check_names,
)
from stiction.summary.report_grid import ParameterAxis, ReportGrid

if TYPE_CHECKING:
    import xarray

    from stiction.study.study import Study

STATUSES_BY_CODE = (friction.STATUS_OK, *sorted(name for name in friction.STATUSES if name != friction.STATUS_OK))
"""Statuses by code. If several directions have no coefficient, the status with the smallest code is reported."""

DIMENSIONS_OF_REPORT_ARRAYS = ("fractal_dimension", "amplitude", "sliding", "direction", "load", "mu0", "tau0")


# ---- Measured surfaces -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class ReportValuesOfMeasuredSurfaces:
    """Friction and contact quantities in a report on measured surfaces, for each load, mu0 and tau0.

    The first axes of the arrays are kind of member, cutoff, sliding rule, motion, load, mu0 and tau0. The last axis of
    estimates contains mean, lower limit and upper limit.

    Attributes
    ----------
    axes : pair of ParameterAxis
        Values of mu0 and tau0.
    loads : ndarray of float, mN
    motions : list of list of int
        Indices of the directions that are averaged for each motion.
    member_kinds : list of str or None
        Kinds of members; None stands for all members.
    friction : ndarray of float
        Estimates with combined intervals. The limits are NaN where `has_combined` is false.
    sampling : ndarray of float
        Estimates with intervals of the mean over positions.
    status_codes : ndarray of int
        Indices into `STATUSES_BY_CODE`.
    num_solved : ndarray of int
        Numbers of members with a coefficient.
    slopes : ndarray of float
        Small-slope estimates (kind, cutoff, rule, motion, mu0, tau0).
    has_combined : ndarray of bool
        True for each kind of member and motion with a combined interval.
    member_counts : list of int
        Number of members of each kind.
    load_quantities : dict
        Estimates (kind, cutoff, load) of each quantity that depends only on the load, by name.
    check_limits : dict
        Results of `find_smallest_check_limit` for these quantities.
    """

    axes: tuple[ParameterAxis, ParameterAxis]
    loads: Floats
    motions: list[list[int]]
    member_kinds: Sequence[str | None]
    friction: Floats
    sampling: Floats
    status_codes: NDArray[np.intp]
    num_solved: NDArray[Any]
    slopes: Floats
    has_combined: NDArray[np.bool_]
    member_counts: list[int]
    load_quantities: dict[str, Floats]
    check_limits: dict[str, float | None]


def evaluate_measured_report(grid: ReportGrid) -> ReportValuesOfMeasuredSurfaces:
    """Evaluate friction and contact quantities of measured surfaces for each load, mu0 and tau0 in a report."""
    tables, load_tables = grid.evaluate(), grid.evaluate_study_inputs()
    estimates, sampling, status_codes, num_solved, slopes = (
        np.stack(arrays) for arrays in zip(*(_stack_motions(values, grid.motions) for values in tables), strict=True)
    )
    # Only the first kind of members has combined intervals, and only for the mean over all directions of motion.
    has_combined = np.zeros((len(tables), len(grid.motions)), bool)
    has_combined[0] = [len(motion) == len(grid.motions[0]) for motion in grid.motions]
    estimates[
        np.broadcast_to(~has_combined[:, np.newaxis, np.newaxis, :, None, None, None], estimates.shape[:-1]), 1:
    ] = np.nan
    quantity_names = [name for name in quantity_names_shown_in("report") if name in load_tables[0]]
    return ReportValuesOfMeasuredSurfaces(
        axes=grid.axes,
        loads=grid.loads,
        motions=grid.motions,
        member_kinds=grid.member_kinds,
        friction=estimates,
        sampling=sampling,
        status_codes=status_codes,
        num_solved=num_solved,
        slopes=slopes,
        has_combined=has_combined,
        member_counts=[int(values["members"]) for values in tables],
        load_quantities={
            name: np.stack([values[name].transpose("cut_off", "load", "statistic").values for values in load_tables])
            for name in quantity_names
        },
        check_limits={name: find_smallest_check_limit(name, grid.study) for name in quantity_names},
    )


def _stack_motions(values: xarray.Dataset, motions: list[list[int]]) -> list[NDArray[Any]]:
    """Return, for each group of directions, coefficients, statuses, numbers of surface pairs and small-slope estimates.

    The arrays have one index for each group of directions in `motions`.
    """
    dims = ("cut_off", "sliding", "direction", "load", "mu0", "tau0")
    dims_of_mean = tuple(dim for dim in dims if dim != "direction")
    by_direction = values["friction_coefficient"].transpose(*dims, "statistic").values
    mean = values["mean_friction"].transpose(*dims_of_mean, "statistic").values
    combined_friction = (
        values["friction_combined"].transpose(*dims_of_mean, "statistic").values
        if "friction_combined" in values
        else mean
    )
    status, num_solved = (values[name].transpose(*dims).values for name in ("status", "ok"))
    slopes = values["gentle_friction"].transpose("cut_off", "sliding", "direction", "mu0", "tau0").values
    arrays_by_motion = []
    for directions in motions:
        is_mean = len(directions) == by_direction.shape[2]
        sampling = mean if is_mean else by_direction[:, :, directions[0]]
        arrays_by_motion.append(
            (
                combined_friction if is_mean else sampling,
                sampling,
                _find_status_codes(status[:, :, directions], sampling[..., 0]),
                num_solved[:, :, directions].min(axis=2),
                slopes[:, :, directions].mean(axis=2),
            )
        )
    return [np.stack(arrays, axis=2) for arrays in zip(*arrays_by_motion, strict=True)]


def _find_status_codes(statuses: NDArray[Any], values: Floats) -> NDArray[np.intp]:
    """Return one status code per coefficient, given the statuses of the directions (axis 2) that it averages."""
    bulk_shear_code = STATUSES_BY_CODE.index(friction.STATUS_BULK_SHEAR)
    codes = np.select([statuses == name for name in STATUSES_BY_CODE], range(len(STATUSES_BY_CODE)))
    lowest_codes = np.where(codes == 0, len(STATUSES_BY_CODE), codes).min(axis=2)
    not_solved_code = STATUSES_BY_CODE.index(friction.STATUS_NOT_SOLVED)
    is_lower_limit = (codes == bulk_shear_code).any(axis=2)
    return np.where(
        np.isfinite(values), np.where(is_lower_limit, bulk_shear_code, 0),
        np.where(lowest_codes == len(STATUSES_BY_CODE), not_solved_code, lowest_codes),
    )  # fmt: skip


# ---- Generated surfaces ----------------------------------------------------------------------------------------------

# Mean ratio of overlap to radius above which the asperity model is invalid.
MAX_OVERLAP_RADIUS_RATIO = 0.1

STATUSES_OF_GENERATED_SURFACES = (
    (friction.STATUS_OK, True),
    (friction.STATUS_OK, False),
    *((name, False) for name in friction.STATUSES if name != friction.STATUS_OK),
)
"""Statuses of generated surfaces by code, each with a flag that is True if the asperity model is valid."""


@dataclass(frozen=True, eq=False)
class ReportValuesOfGeneratedSurfaces:
    """Friction and contact quantities in a report on generated surfaces, for each load, mu0 and tau0.

    The first axes of the arrays are fractal dimension, amplitude, sliding rule, direction, load, mu0 and tau0. The last
    axis of estimates contains mean, lower limit and upper limit.

    Attributes
    ----------
    axes : pair of ParameterAxis
        Values of mu0 and tau0.
    estimates : dict
        Estimates of each panel in `QUANTITIES_BY_PANEL`; the stiffness only if it was computed.
    means : dict
        Means of all other quantities that reports show, by name.
    status_codes : ndarray of int
        Indices into `STATUSES_OF_GENERATED_SURFACES`.
    is_valid : ndarray of bool
        True if there is a coefficient, and no quantity in `means` exceeds its limit for a valid contact model.
    checked_numbers : dict
        Numbers that the assessment compares with limits, for the quoted sliding rule.
    caveat_sets : list of list of Caveat or LimitCheck
        Distinct assessments, each with faults first.
    assessment_indices : ndarray of int
        Index of the assessment of each point, for the quoted sliding rule.
    """

    axes: tuple[ParameterAxis, ParameterAxis]
    estimates: dict[str, Floats]
    means: dict[str, Floats]
    status_codes: NDArray[np.intp]
    is_valid: NDArray[np.bool_]
    checked_numbers: dict[str, Any]
    caveat_sets: list[list[Caveat | LimitCheck]]
    assessment_indices: NDArray[np.intp]

    @property
    def assessments(self) -> list[str]:
        """Assessments such as "Do not quote"; entry i belongs to the set of caveats `caveat_sets[i]`."""
        return [assess_caveats(caveats) for caveats in self.caveat_sets]


QUANTITIES_BY_PANEL = {"friction": "friction_coefficient", "area": "contact_area", "stiffness": "normal_stiffness"}
"""Quantity of generated surfaces that each panel of a report shows, with the interval of the quantity."""


def is_shown_in_report(name: str, values: Floats) -> bool:
    """Return whether a report shows a quantity: it has a finite value and, for some quantities, a nonzero value."""
    return bool(np.isfinite(values).any() and (not QUANTITIES[name].is_omitted_if_zero or np.nan_to_num(values).any()))


def get_validity_limit(name: str) -> float:
    """Return the upper limit of a quantity such as the overlap ratio; above the limit, the asperity model is invalid.

    Returns infinity for other quantities.
    """
    if QUANTITIES[name].kind != "validity":
        return math.inf
    return MAX_AFFECTED_FRACTION if QUANTITIES[name].percent else MAX_OVERLAP_RADIUS_RATIO


def evaluate_generated_report(grid: ReportGrid, num_members: int) -> ReportValuesOfGeneratedSurfaces:
    """Evaluate friction and contact quantities of generated surfaces for each load, mu0 and tau0 in a report.

    `num_members` is the number of solved members.
    """
    study, (table,) = grid.study, grid.evaluate()
    points = _order_dimensions(table["friction_coefficient"])
    shape: tuple[int, ...] = points.shape[:-1]
    estimates = {
        panel: np.broadcast_to(_order_dimensions(table[name]), points.shape)
        for panel, name in QUANTITIES_BY_PANEL.items()
        if name in table and (panel != "stiffness" or bool(table[name].notnull().any()))
    }
    other_names = [name for name in quantity_names_shown_in("report") if name not in QUANTITIES_BY_PANEL.values()]
    means = {name: _broadcast_means(table[name], shape) for name in other_names if name in table}
    means = {name: values for name, values in means.items() if is_shown_in_report(name, values)}
    statuses = np.broadcast_to(_order_dimensions(table["status"]), shape)
    checked_numbers = _compute_checked_numbers(table, estimates, study, num_members)
    rule_index = study.contact.sliding_rules().index(list_rules_with_reported_first(study)[0])
    checked_numbers = {name: values[:, :, rule_index] for name, values in checked_numbers.items()}
    is_beyond_limit = {name: values > get_validity_limit(name) for name, values in means.items()}
    hatched_masks = [mask for name, mask in is_beyond_limit.items() if "hatch" in QUANTITIES[name].shown]
    status_codes = np.where(np.logical_or.reduce([np.zeros(shape, bool), *hatched_masks]), 1, 0)
    for code, (name, _) in enumerate(STATUSES_OF_GENERATED_SURFACES):
        if name != friction.STATUS_OK:
            status_codes[statuses == name] = code
    return ReportValuesOfGeneratedSurfaces(
        grid.axes,
        estimates,
        means,
        status_codes,
        (status_codes == 0) & ~np.logical_or.reduce([np.zeros(shape, bool), *is_beyond_limit.values()]),
        checked_numbers,
        *assess_ensemble_points(
            study, statuses[:, :, rule_index], checked_numbers, _find_unloaded_points(table, statuses[:, :, rule_index])
        ),
    )


def _find_unloaded_points(table: xarray.Dataset, statuses: NDArray[Any]) -> NDArray[np.bool_]:
    """Return a mask of the report's values at loads that are negligible compared with the pull-off force."""
    if "pull_off" not in table:
        return np.zeros(statuses.shape, np.bool_)
    pull_off = table["pull_off"].sel(statistic="mean", drop=True)
    is_unloaded = _order_dimensions(table["load"] < NEGLIGIBLE_LOAD_RATIO * pull_off)
    return np.broadcast_to(is_unloaded[:, :, 0], statuses.shape)


def _compute_checked_numbers(
    table: xarray.Dataset, estimates: dict[str, Floats], study: Study, num_members: int
) -> dict[str, Any]:
    """Compute the quantities that have limits in the assessment of generated surfaces, keyed by name."""
    mu0, tau0 = (_order_dimensions(table[name]) for name in ("mu0", "tau0"))
    area = estimates["area"][..., 0]
    surfaces: Any = study.surfaces
    nominal_area = float(surfaces.nominal_area) if study.is_areal else math.inf
    value, lower, upper = np.moveaxis(estimates["friction"], -1, 0)
    quantities = {
        name: _broadcast_means(table[name], area.shape) for name in list_contact_check_names(study) if name in table
    }
    return quantities | compute_checked_quantities(
        value, lower, upper, mu0=mu0, tau0=tau0, pressure=_broadcast_means(table["mean_pressure"], area.shape),
        contact_count=_broadcast_means(table["contact_count"], area.shape),
        members=num_members, is_merged=area / nominal_area > MIN_MERGED_AREA_FRACTION,
    )  # fmt: skip


def _broadcast_means(table: xarray.DataArray, shape: tuple[int, ...]) -> Floats:
    """Broadcast the mean values of a quantity to the array shape that the report uses."""
    return np.broadcast_to(
        _order_dimensions(table.sel(statistic="mean") if "statistic" in table.dims else table), shape
    )


def _order_dimensions(table: xarray.DataArray) -> Floats:
    """Convert a data array to an array whose first axes are the dimensions `DIMENSIONS_OF_REPORT_ARRAYS`.

    A missing dimension gets length 1.
    """
    table = table.expand_dims([dim for dim in DIMENSIONS_OF_REPORT_ARRAYS if dim not in table.dims])
    return np.asarray(table.transpose(*DIMENSIONS_OF_REPORT_ARRAYS, ...).values)
