"""Evaluation of friction, contact area and other quantities of a result at given loads, with 95 % intervals.

*mean*: the mean normal load of the ensemble equals the given load, and coefficients are ratios of mean loads, as in the
figures of the paper. *elastic*: the elastic load of each member, before any contact slides, equals the given load.
*normal*: the normal load of each member at the onset of sliding, which includes friction on slopes, equals the given
load. For small slopes the three definitions agree to four digits.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, check_choice, float_array
from stiction._units import short_repr
from stiction.evaluate.contact_area import build_area_functions
from stiction.evaluate.ensemble_means import average_ensemble
from stiction.evaluate.intervals import MAX_RELATIVE_ROUND_OFF
from stiction.evaluate.load_range import replace_zero_load
from stiction.evaluate.maps import MAP_CELL_DIMENSION_NAMES, choose_mu0_and_tau0
from stiction.evaluate.member_means import AdjacentLoadValues, average_members
from stiction.evaluate.member_values import LoadDefinition, MemberKind, evaluate_members
from stiction.mechanics.closed_forms import DEFAULT_KAPPA, compute_small_slope_friction
from stiction.mechanics.quantities import is_requested, quantity_attributes
from stiction.solve.layout import arrange_axes
from stiction.solve.member_sums import MemberSums

if TYPE_CHECKING:
    import xarray


def at_load(
    result: MemberSums | xarray.Dataset, loads: ArrayLike, *,
    mu0: ArrayLike | None = None, tau0: ArrayLike | None = None, load_definition: LoadDefinition | None = None,
    member_kind: MemberKind | None = None, names: Collection[str] | None = None,
) -> xarray.Dataset:  # fmt: skip
    """Evaluate friction, true area and contact statistics at given loads, with 95 % intervals.

    Parameters
    ----------
    result : Result, or xarray.Dataset of member sums
    loads : (l,) array_like of float, mN
        Loads above 0. For adhesive bodies, a load of 0 is evaluated at `find_negligible_load`.
    mu0 : (m,) array_like of float, optional
    tau0 : (t,) array_like of float, GPa, optional
        By default the values in the study. Other values need no new computation of contacts.
    load_definition : {"mean", "elastic", "normal"}, optional
        Definition of the load; by default "mean" for generated bodies and "elastic" for measured bodies.
    member_kind : {"shifts", "surrogates"}, optional
        Members of measured areas to evaluate: pairs at relative positions of the two maps (the default if there are
        any), or pairs of surrogates.
    names : collection of str, optional
        Quantities to evaluate besides friction; all by default. The true area of measured bodies is always evaluated.

    Returns
    -------
    xarray.Dataset
        friction_coefficient and status have the dimensions of the cells, sliding and direction if there are several,
        load, mu0 and tau0. With opposite directions there are also friction_by_axis, the mean over both directions of
        an axis, and mean_friction, the mean over all directions. contact_area (µm²), contact_count,
        normal_stiffness and quantities of validity have the dimensions of the cells and load. If the study includes the
        onset of sliding, there are also tangential_stiffness (mN/µm), displacement_at_sliding (µm) and
        fraction_slipped; at the mean load of an ensemble the latter two are means weighted by the load of each pair.
        Measured bodies also have contact statistics, quantiles of areas and pressures, slopes of the gap and
        `gentle_friction`. The last dimension is statistic ("mean", "lower", "upper"). spread_low and spread_high are
        the 10th and 90th percentiles of single members, load_definition_effect is the largest relative difference
        between the coefficients for two definitions of the load (elastic, and normal or mean normal),
        members is the number of members, and ok is the number of members with a coefficient.

    Raises
    ------
    ValueError
        If a load, mu0 or tau0 is outside its range, or there are no members of the kind.
    """
    result = MemberSums.of(result)
    study = result.study
    is_measured = study.is_measured
    load_definition = ("elastic" if is_measured else "mean") if load_definition is None else load_definition
    check_choice("load_definition", load_definition, LoadDefinition)
    unique_loads = replace_zero_load(result, np.atleast_1d(float_array("loads", loads)))
    if not unique_loads.size or not (unique_loads > 0).all():
        raise ValueError(f"loads must be above 0 mN, got {short_repr(loads)}")
    strengths = choose_mu0_and_tau0(result, mu0, tau0)
    if load_definition == "mean":
        point = average_ensemble(result, unique_loads, *strengths, names)
    else:
        members = evaluate_members(result, unique_loads, *strengths, load_definition, member_kind, names)
        adjacent_load_values = None
        if (
            load_definition == "elastic"
            and (bracketing_loads := _find_bracketing_loads(result, unique_loads)) is not None
        ):
            computed_loads, (below, above), position = bracketing_loads
            values_at_computed_loads = evaluate_members(
                result, computed_loads, *strengths, "elastic", member_kind, names
            )
            adjacent_load_values = AdjacentLoadValues(
                values_at_computed_loads.isel(load=below), values_at_computed_loads.isel(load=above), position
            )
        point = average_members(study, members, names, adjacent_load_values)
        if is_measured:
            cell_dims = [str(dim) for dim in point.variables["rms_gradient"].dims if dim != "statistic"]
            gradient = arrange_axes(point.variables["rms_gradient"], ("statistic", *cell_dims))[0]
            directional_slope = arrange_axes(point.variables["rms_slope"], ("statistic", *cell_dims, "direction"))[0]
            modulus, rules = float(study.contact.effective_modulus), point["sliding"].values
            point = point.assign(
                estimate_small_slope_friction(cell_dims, gradient, directional_slope, rules, *strengths, modulus)
            )
    if study.contact.indent is not None and is_requested("contact_hardness", names):
        hardness = np.stack([area.contact_hardness(unique_loads) for area in result.compute_once(build_area_functions)])
        point["contact_hardness"] = (
            (*(name for name in MAP_CELL_DIMENSION_NAMES if name in point.dims), "load", "statistic"),
            np.repeat(hardness[..., np.newaxis], 3, axis=-1), quantity_attributes("contact_hardness"),
        )  # fmt: skip
    if is_measured and is_requested("load_definition_effect", names):
        other_definition: LoadDefinition = "normal" if load_definition == "elastic" else "elastic"
        # Ensemble means neglect junction growth and area loss, so the coefficient compared with them neglects both too.
        other_result = (
            result
            if load_definition != "mean" or not study.uses_half_space
            else result.with_study(study.with_changes({"contact.junction_growth": None, "contact.area_loss": None}))
        )
        members = evaluate_members(other_result, unique_loads, *strengths, other_definition, member_kind, ())
        other_coefficient = members.variables["friction_coefficient"].mean(("repetition", "direction"))
        coefficient = point.variables["mean_friction"].isel(statistic=0)
        # A coefficient of 0 is replaced by NaN, because a relative difference from 0 is undefined.
        is_zero = np.abs(coefficient.values) <= MAX_RELATIVE_ROUND_OFF
        coefficient = coefficient.copy(data=np.where(is_zero, np.nan, coefficient.values))
        other_dims = [str(dim) for dim in coefficient.dims if dim not in (*MAP_CELL_DIMENSION_NAMES, "load")]
        point["load_definition_effect"] = abs(other_coefficient / coefficient - 1).max(other_dims)
    return point.assign_attrs(load_definition=load_definition)


def _find_bracketing_loads(
    result: MemberSums, loads: Floats
) -> tuple[Floats, tuple[NDArray[np.intp], NDArray[np.intp]], Floats] | None:
    """Find the two computed loads (mN) next to each requested load: one below, and one above.

    Returns None if no load is interpolated.

    Returns the computed loads, the indices of the computed loads below and above each requested load, and its position
    between them, as a fraction of the distance in ln F.
    """
    if result.study.step_quantity != "load":
        return None
    steps = result.study.contact.loading_steps()
    above = np.minimum(np.searchsorted(steps, loads), steps.size - 1)
    is_between = (loads > steps[0]) & (loads < steps[above])
    if not is_between.any():
        return None
    below = np.where(is_between, above - 1, above)
    log_ratio = np.where(is_between, np.log(steps[above] / steps[below]), 1.0)
    position = np.where(is_between, np.log(loads / steps[below]) / log_ratio, 0.0)
    used_steps, indices = np.unique(np.stack([below, above]), return_inverse=True)
    first_indices, last_indices = indices.reshape(2, -1)
    return steps[used_steps], (first_indices, last_indices), position


def estimate_small_slope_friction(
    dims: list[str], gradient: Floats, slope: Floats, rules: Iterable[Any], mu0: Floats, tau0: Floats, modulus: float
) -> dict[str, Any]:
    """Estimate the friction coefficient for small slopes from the rms gradient and the rms slopes of the gap.

    The rms gradients have the shape (...), and the rms slopes have the shape (..., direction).
    """
    has_slopes = (gradient[..., np.newaxis] > 0) & (slope > 0)
    gradients, slopes = (
        np.where(has_slopes, array, 1.0)[..., None, None] for array in (gradient[..., np.newaxis], slope)
    )
    estimates = [
        compute_small_slope_friction(
            mu0[:, np.newaxis],
            tau0,
            rms_gradient=gradients,
            rms_slope=slopes,
            effective_modulus=modulus,
            kappa=DEFAULT_KAPPA,
            sliding=rule,
            slope_ratio=1.0,
            order=1,
        )
        for rule in rules
    ]
    values = np.where(has_slopes[..., np.newaxis, :, np.newaxis, np.newaxis], np.stack(estimates, axis=-4), np.nan)
    return {
        "gentle_friction": (
            [*dims, "sliding", "direction", "mu0", "tau0"], values, quantity_attributes("gentle_friction")
        )
    }  # fmt: skip
