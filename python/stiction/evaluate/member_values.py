"""Friction and contact quantities of each member at given loads, for any mu0 and tau0."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, check_choice, float_array
from stiction._units import short_repr
from stiction.evaluate.contact_area import compute_onset_area_and_friction_factors, iterate_pieces_with_true_areas
from stiction.evaluate.intervals import MAX_RELATIVE_ROUND_OFF, LoadCrossings
from stiction.evaluate.load_range import replace_zero_load
from stiction.evaluate.maps import MOTION_DIMENSION_NAMES, choose_mu0_and_tau0, find_cell_dimensions
from stiction.mechanics import friction
from stiction.mechanics.friction import (
    LOAD_SUM_NAMES,
    STATUS_DTYPE,
    STATUSES,
    STATUSES_WITH_COEFFICIENT,
    FrictionLaw,
    compute_ratios,
)
from stiction.mechanics.law import HertzCylinder
from stiction.mechanics.mindlin import compliance_ratio
from stiction.mechanics.onset import DEFAULT_POISSON_RATIO
from stiction.mechanics.quantities import (
    DISTRIBUTION_QUANTITIES,
    GAP_QUANTITIES,
    INTERPOLATED_QUANTITIES,
    LOADING_COUNTERPARTS,
    QUANTITIES,
    QUANTITIES_SUMMED_AT_ZERO_LOAD,
    STIFFNESS_PER_AREA_FACTOR,
    VALIDITY_RATIO_OPERANDS,
    is_requested,
    quantity_attributes,
)
from stiction.solve.layout import arrange_axes
from stiction.solve.member_sums import MemberSums
from stiction.study.inputs import Inputs
from stiction.study.study import Study, find_step_dimension

if TYPE_CHECKING:
    import xarray

LATERAL_SUM_NAMES = ("lateral_elastic", "lateral_frictional", "lateral_adhesive")

_FRICTION_VARIABLES = (
    "friction_coefficient",
    "normal_load",
    "tangential_load",
    "status",
    "contact_area",
    "contact_count",
    *GAP_QUANTITIES,
)
"""Names of the quantities that are always evaluated, because intervals of friction depend on them."""

LoadDefinition = Literal["mean", "elastic", "normal"]
MemberKind = Literal["shifts", "surrogates"]


def member_values(
    result: MemberSums | xarray.Dataset, loads: ArrayLike, *,
    mu0: ArrayLike | None = None, tau0: ArrayLike | None = None,
    load_definition: LoadDefinition = "elastic", member_kind: MemberKind | None = None,
) -> xarray.Dataset:  # fmt: skip
    """Evaluate friction and contact quantities at given loads for each member of a result.

    Parameters
    ----------
    result, loads, mu0, tau0, member_kind
        As for `at_load`.
    load_definition : {"elastic", "normal"}

    Returns
    -------
    xarray.Dataset
        friction_coefficient, normal_load and tangential_load (mN) and status have the dimensions of the cells,
        repetition, sliding, direction, load, mu0 and tau0; a single sliding rule or direction is a dimension of length
        1. Height maps with the asperity model at elastic loads also have lateral_load (mN). Other quantities have the
        dimensions of the cells, repetition and load (and fraction_below), and are evaluated at the elastic load.
    """
    check_choice("load_definition", load_definition, LoadDefinition)
    if load_definition == "mean":
        raise ValueError("load_definition must be 'elastic' or 'normal' for single members, got 'mean'")
    result = MemberSums.of(result)
    unique_loads = np.unique(np.atleast_1d(float_array("loads", loads)))
    strengths = choose_mu0_and_tau0(result, mu0, tau0)
    members = evaluate_members(result, unique_loads, *strengths, load_definition, member_kind)
    if load_definition == "elastic" and set(LATERAL_SUM_NAMES) <= set(result.head.data_vars):
        sums = interpolate_member_sums(result, unique_loads, LATERAL_SUM_NAMES, member_kind=member_kind)
        lateral_sums = {name: sums[name].values[..., np.newaxis, np.newaxis] for name in LATERAL_SUM_NAMES}
        lateral = (
            Inputs.from_study(result.study)
            .friction_law(strengths[0][:, np.newaxis], strengths[1])
            .load("lateral", lateral_sums)
        )
        dims = (*sums[LATERAL_SUM_NAMES[0]].dims, "mu0", "tau0")
        members = members.assign(lateral_load=(dims, lateral, quantity_attributes("lateral_load")))
    return members


def evaluate_members(
    result: MemberSums, loads: Floats, mu0: Floats, tau0: Floats, load_definition: LoadDefinition = "elastic",
    member_kind: MemberKind | None = None, names: Collection[str] | None = None,
) -> xarray.Dataset:  # fmt: skip
    """Evaluate the contact quantities of each member, and its friction at the onset of sliding, at given loads.

    For a measured study, the dataset at the study's elastic loads, mu0 and tau0 is evaluated only once for each result.
    """
    if load_definition == "elastic" and member_kind is None and names is None:
        selection = {"load": loads, "mu0": mu0, "tau0": tau0}
        study_values = _get_study_inputs(result)
        if all(np.isin(values, study_values[name]).all() for name, values in selection.items()):
            return result.compute_once(_evaluate_study_members).sel(selection)
    return _evaluate_members_uncached(result, loads, mu0, tau0, load_definition, member_kind, names)


def _get_study_inputs(result: MemberSums) -> dict[str, Floats]:
    """Return the loads (mN), mu0 and tau0 (GPa) of a study, keyed by name.

    A study of generated surfaces has no loads.
    """
    settings = result.study.friction
    loads = np.array([float(load) for load in settings.load] if result.study.is_measured else [])
    return {
        "load": replace_zero_load(result, loads),
        "mu0": np.unique(settings.mu0),
        "tau0": np.unique([float(strength) for strength in settings.tau0]),
    }


def _evaluate_study_members(result: MemberSums) -> xarray.Dataset:
    loads, mu0, tau0 = _get_study_inputs(result).values()
    return _evaluate_members_uncached(result, loads, mu0, tau0)


def _evaluate_members_uncached(
    result: MemberSums, loads: Floats, mu0: Floats, tau0: Floats, load_definition: LoadDefinition = "elastic",
    member_kind: MemberKind | None = None, names: Collection[str] | None = None,
) -> xarray.Dataset:  # fmt: skip
    contact = result.study.contact
    onset = (
        compute_onset_area_and_friction_factors(result, loads, mu0, tau0)
        if contact.junction_growth or contact.area_loss
        else None
    )

    def evaluate_piece(piece: xarray.Dataset) -> xarray.Dataset:
        return _evaluate_piece(piece, result.study, loads, mu0, tau0, load_definition, names, onset)

    return _evaluate_pieces(result, member_kind, evaluate_piece)


def interpolate_member_sums(
    result: MemberSums | xarray.Dataset,
    loads: Floats,
    names: Sequence[str] = LOAD_SUM_NAMES,
    *,
    member_kind: MemberKind | None = None,
) -> xarray.Dataset:
    """Interpolate forces and areas, summed over each member's contacts, at given loads (mN).

    The given loads are those that the contacts carry without friction.

    By default, these are the six sums that determine friction. The dimensions are cells, repetition, sliding, direction
    and load.
    """
    import xarray

    result = MemberSums.of(result)
    study = result.study

    def evaluate_piece(piece: xarray.Dataset) -> xarray.Dataset:
        sums, load_crossings = _find_load_crossings(piece, loads, names)
        dims = (*find_cell_dimensions(piece), "repetition", *MOTION_DIMENSION_NAMES, "load")
        values = np.broadcast_arrays(*map(load_crossings.interpolate, sums.values()))
        coordinates = {
            str(name): piece.variables[name]
            for name in piece.coords
            if {*piece.variables[name].dims} <= {*dims} - {"load"}
        }
        return xarray.Dataset(
            {name: (dims, array) for name, array in zip(sums, values, strict=True)},
            _get_missing_motion_coordinates(piece, study) | coordinates,
        )

    return _evaluate_pieces(result, member_kind, evaluate_piece, ["normal_elastic", *names])


def estimate_area_error(adhesive_sums: Floats) -> float:
    """Return the relative standard error of the mean true area, from one sum of contact areas per member.

    The error is 0 for a single member.
    """
    count = len(adhesive_sums)
    return float(adhesive_sums.std(ddof=1) / adhesive_sums.mean() / math.sqrt(count)) if count > 1 else 0.0


def _evaluate_pieces(
    result: MemberSums, member_kind: MemberKind | None, evaluate: Callable[[xarray.Dataset], xarray.Dataset],
    names: Collection[str] | None = None,
) -> xarray.Dataset:  # fmt: skip
    import xarray

    pieces = [evaluate(piece) for piece in iterate_pieces_with_true_areas(result, names) if piece.sizes["repetition"]]
    values = pieces[0] if len(pieces) == 1 else xarray.concat(
        pieces, "repetition", data_vars="minimal", coords="minimal", compat="override", combine_attrs="override"
    )  # fmt: skip
    if "surrogate" not in values.coords:
        return values
    is_surrogate = values.variables["surrogate"].values.astype(bool)
    is_wanted = bool(is_surrogate.all()) if member_kind is None else member_kind == "surrogates"
    if not (is_surrogate == is_wanted).any():
        other_kind: MemberKind = "shifts" if is_wanted else "surrogates"
        raise ValueError(f"member_kind must be {other_kind!r} for this result, got {short_repr(member_kind)}")
    is_selected = is_surrogate == is_wanted
    return values if is_selected.all() else values.isel(repetition=np.flatnonzero(is_selected))


def _evaluate_piece(
    piece: xarray.Dataset, study: Study, loads: Floats, mu0: Floats, tau0: Floats, load_definition: LoadDefinition,
    names: Collection[str] | None, onset: tuple[Floats, Floats] | None,
) -> xarray.Dataset:  # fmt: skip
    """Evaluate friction and contact quantities of a group of members at given loads.

    `names` lists quantities to evaluate besides `_FRICTION_VARIABLES`; None stands for all. `onset` is the result of
    `compute_onset_area_and_friction_factors`, or None if shear does not change the area.
    """
    import xarray

    member_dims = (*find_cell_dimensions(piece), "repetition")
    sums_at_steps, load_crossings = _find_load_crossings(piece, loads)
    law = Inputs.from_study(study).friction_law(mu0[:, np.newaxis], tau0)
    if load_definition == "elastic":
        contact_sums = {name: load_crossings.interpolate(values) for name, values in sums_at_steps.items()}
        forces = _MemberForces.at_elastic_loads(contact_sums, load_crossings, law)
    else:
        are_steps_loads = find_step_dimension(piece) == "load"
        forces = _MemberForces.at_normal_loads(sums_at_steps, loads, law, interpolates_ratio=are_steps_loads)
    status = _determine_member_status(piece, loads, forces)
    if onset is not None:
        strength_sums = {
            name: load_crossings.interpolate(values)[..., np.newaxis, np.newaxis]
            for name, values in sums_at_steps.items() if not name.endswith("_elastic")
        }  # fmt: skip
        forces, status = _grow_contacts(forces, status, law, strength_sums, *onset)
    with np.errstate(divide="ignore", invalid="ignore"):
        coefficient = np.where(np.isin(status, STATUSES_WITH_COEFFICIENT), forces.tangential / forces.normal, np.nan)
    dims = (*member_dims, *MOTION_DIMENSION_NAMES, "load", "mu0", "tau0")
    variables: dict[str, Any] = {
        "friction_coefficient": (dims, coefficient, quantity_attributes("friction_coefficient")),
        "normal_load": (dims, forces.normal, quantity_attributes("normal_load")),
        "tangential_load": (dims, forces.tangential, quantity_attributes("tangential_load")),
        "status": (dims, status, quantity_attributes("status")),
    }
    requested_names = None if names is None else {*_FRICTION_VARIABLES, *names}
    if requested_names is not None and "tangential_stiffness_per_area" in requested_names:
        requested_names.add("unloading_closure_stiffness")
    if requested_names is not None:
        # Unloading stiffnesses of some members are estimated from their loading stiffnesses.
        requested_names |= {loading for name, loading in LOADING_COUNTERPARTS.items() if name in requested_names}
    if load_definition == "elastic":
        variables |= _compute_opposing_fraction(piece, member_dims, contact_sums)
    variables |= _interpolate_quantities(piece, member_dims, load_crossings, requested_names)
    variables |= {name: piece.variables[name] for name in GAP_QUANTITIES if name in piece.variables}
    if "pull_off" in piece.variables:
        variables |= _evaluate_pull_off(piece, member_dims, law)
    if "unloading_closure_stiffness" in variables:
        dims_of_stiffness, stiffness = variables["unloading_closure_stiffness"][:2]
        variables["tangential_stiffness_per_area"] = (
            dims_of_stiffness,
            stiffness * find_tangential_stiffness_ratio(study),
            quantity_attributes("tangential_stiffness_per_area"),
        )
    variables = _replace_sums_by_ratios(variables, piece.coords.get("nominal_area"))
    if onset is not None:
        area_growth, _ = onset
        area = np.asarray(variables["contact_area"][1])[..., np.newaxis, np.newaxis]
        area_at_onset = area * np.where(np.isfinite(area_growth), area_growth, np.nan)[:, np.newaxis]
        variables["contact_area_at_onset"] = (
            (*member_dims, "load", "mu0", "tau0"), area_at_onset, quantity_attributes("contact_area_at_onset"),
        )  # fmt: skip
    variables = {name: variable for name, variable in variables.items() if is_requested(name, requested_names)}
    coordinates: dict[str, Any] = {
        str(name): piece.variables[name]
        for name in piece.coords
        if name not in (find_step_dimension(piece), "mu0", "tau0")
    }
    parameters = {"load": loads, "mu0": mu0, "tau0": tau0}
    coordinates |= _get_missing_motion_coordinates(piece, study) | {
        name: (name, parameter_values, quantity_attributes(name)) for name, parameter_values in parameters.items()
    }
    return xarray.Dataset(variables, coordinates, piece.attrs)


@dataclass(frozen=True, eq=False)
class _MemberForces:
    """Normal and tangential loads (mN) of members at the onset of sliding, and masks of the loads that members reach.

    The masks mark loads that a member reaches, and loads below the first loading step. The arrays have the shape (...,
    sliding, direction, load, mu0, tau0), or a shape that broadcasts to it.
    """

    normal: Floats
    tangential: Floats
    is_reached: NDArray[np.bool_]
    is_below: NDArray[np.bool_]

    @classmethod
    def at_elastic_loads(
        cls, contact_sums: Mapping[str, Floats], load_crossings: LoadCrossings, law: FrictionLaw
    ) -> _MemberForces:
        """Compute each member's normal and tangential load with friction from sums at given loads without friction."""
        is_reached, is_below = (
            mask[..., None, None, :, None, None] for mask in (load_crossings.reached, load_crossings.below)
        )
        return cls(*_compute_loads(contact_sums, law), is_reached, is_below)

    @classmethod
    def at_normal_loads(
        cls, sums_at_steps: Mapping[str, Floats], loads: Floats, law: FrictionLaw, *, interpolates_ratio: bool
    ) -> _MemberForces:
        """Interpolate each member's tangential load at given normal loads (mN), and return both loads."""
        # The axis of loading steps is moved to the end, because loads are interpolated along the last axis.
        normal_load, tangential_load = (np.moveaxis(array, -3, -1) for array in _compute_loads(sums_at_steps, law))
        normal_load = np.broadcast_to(normal_load, tangential_load.shape)
        with np.errstate(invalid="ignore"):
            positive_normal = np.where(normal_load > 0, normal_load, np.nan) if interpolates_ratio else normal_load
        crossing = LoadCrossings.from_curves(
            positive_normal, loads, interpolates_ratio=interpolates_ratio
        ).without_crossings_after_nan(normal_load, loads)
        arrays: tuple[Any, ...] = (
            crossing.interpolate(normal_load), crossing.interpolate(tangential_load), crossing.reached, crossing.below
        )  # fmt: skip
        return cls(*(np.moveaxis(array, -1, -3) for array in arrays))


def _compute_loads(sums: Mapping[str, Floats], law: FrictionLaw) -> tuple[Floats, Floats]:
    """Compute the normal and tangential load (mN) of each member from forces and areas summed over its contacts.

    The last two axes of the loads are mu0 and tau0.
    """
    columns = {name: sums[name][..., np.newaxis, np.newaxis] for name in LOAD_SUM_NAMES}
    return law.load("normal", columns), law.load("tangential", columns)


def _grow_contacts(
    forces: _MemberForces, status: NDArray[Any], law: FrictionLaw, sums: Mapping[str, Floats], area_growth: Floats,
    fraction: Floats,
) -> tuple[_MemberForces, NDArray[Any]]:  # fmt: skip
    """Return the loads and statuses of members after shear has enlarged or reduced the contact area.

    The friction force is also reduced if the softer body shears. `sums` are the contact sums at the loads, which mu0
    and tau0 multiply. `area_growth` and `fraction` come from `compute_onset_area_and_friction_factors`.
    """
    area_growth, fraction = (factors[:, np.newaxis, np.newaxis, np.newaxis] for factors in (area_growth, fraction))
    added_area = np.where(law.tau0 > 0, area_growth * fraction - 1, 0.0)
    with np.errstate(invalid="ignore"):
        normal_load, tangential_load = (
            load + law.force((fraction - 1) * sums[f"{name}_frictional"], added_area * sums[f"{name}_adhesive"])
            for name, load in (("normal", forces.normal), ("tangential", forces.tangential))
        )
    has_coefficient = status == friction.STATUS_OK
    status = np.array(np.broadcast_to(status, normal_load.shape))
    status[has_coefficient & (fraction < 1)] = friction.STATUS_BULK_SHEAR
    status[has_coefficient & (normal_load <= 0)] = friction.STATUS_SELF_LOCKED
    status[has_coefficient & np.isinf(added_area)] = friction.STATUS_SEIZURE
    return replace(forces, normal=normal_load, tangential=tangential_load), status


def _compute_opposing_fraction(
    piece: xarray.Dataset, member_dims: tuple[str, ...], contact_sums: Mapping[str, Floats]
) -> dict[str, Any]:
    """Return the fraction of the load carried by contacts that oppose the motion, if both sliding rules are stored."""
    rules = piece["sliding"].values.tolist() if "sliding" in piece.dims else []
    if not {"opposing", "all"} <= set(rules):
        return {}
    opposing_load, total_load = (
        np.take(contact_sums["tangential_frictional"], rules.index(rule), axis=len(member_dims))
        for rule in ("opposing", "all")
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        # To first order in the slopes, the tangential friction force of contacts per unit mu0 equals their normal load.
        fraction = opposing_load / total_load
    return {"share_opposing": ((*member_dims, "direction", "load"), fraction, quantity_attributes("share_opposing"))}


def _interpolate_quantities(
    piece: xarray.Dataset, member_dims: tuple[str, ...], load_crossings: LoadCrossings, names: Collection[str] | None
) -> dict[str, Any]:
    """Interpolate the normal load without friction, and other quantities, at the requested loads.

    The result is a dict keyed by name.
    """
    step_dimension, variables = find_step_dimension(piece), {}
    for name in (*INTERPOLATED_QUANTITIES, *DISTRIBUTION_QUANTITIES):
        if name not in piece.variables or not (name == "normal_elastic" or is_requested(name, names)):
            continue
        stored_values = piece.variables[name]
        if step_dimension in stored_values.dims:
            value_dims = (*member_dims, *(["fraction_below"] if name in DISTRIBUTION_QUANTITIES else []))
            quantity = QUANTITIES[name]
            are_sums = quantity.proportional and (quantity.proportional_with_adhesion or "pull_off" not in piece)
            interpolated = load_crossings.interpolate(
                _to_float_array(stored_values, (*value_dims, step_dimension)), are_sums=are_sums
            )
            variables[name] = (*value_dims, "load"), interpolated, stored_values.attrs
    if step_dimension == "load" and "pull_off" not in piece:
        _interpolate_displacements_and_stiffnesses(piece, member_dims, load_crossings, variables)
    return variables


def find_tangential_stiffness_ratio(study: Study) -> float:
    """Return the ratio of a pair's initial tangential stiffness to its normal stiffness during unloading.

    The ratio is 1 for grooves, which deform in plane strain. For isotropic surfaces, it is Mindlin's ratio (1949) for
    the Poisson's ratios of both bodies.
    """
    contact: Any = study.contact
    poisson = contact.poisson or DEFAULT_POISSON_RATIO
    transverse_fraction = 1.0 if has_grooves(study) else 0.5
    return float(1 / compliance_ratio(poisson, getattr(contact, "compliance_share", 0.5), transverse_fraction))


def has_grooves(study: Study) -> bool:
    """Return whether the profiles of a study represent surfaces with parallel grooves, not isotropic surfaces."""
    if study.is_areal:
        return False
    contact: Any = study.contact
    return study.uses_half_space or isinstance(contact.contact_model().law, HertzCylinder)


ELASTIC_WEIGHT_EXPONENT = 4
"""Exponent with which the ratio of loading to unloading stiffness is the weight of elastic contacts.

For a pair of profiles that yields at 2 to 70 % of its contacts, interpolated unloading stiffnesses deviate by 1.3 %
(rms) and at most 3 %.
"""

_STIFFNESS_NAMES_BY_DISPLACEMENT = {
    "closure": ("closure_stiffness", "unloading_closure_stiffness"),
    "approach": ("normal_stiffness", "unloading_stiffness"),
}
"""Names of displacements, each with its derivatives: the stiffness during loading and during unloading."""


def _interpolate_displacements_and_stiffnesses(
    piece: xarray.Dataset, member_dims: tuple[str, ...], load_crossings: LoadCrossings, variables: dict[str, Any]
) -> None:
    """Interpolate displacements δ and stiffnesses between computed loads F, consistent with stiffness = dF/dδ.

    Only the loading stiffness is dF/dδ.

    Between two computed loads, a displacement is the cubic in the logarithm of the load that has the stored
    displacements and stiffnesses. The loading stiffness is the inverse of the slope of this cubic. The unloading
    stiffness is a weighted geometric mean of two estimates: the loading stiffness times the interpolated ratio of both,
    which is exact for elastic contacts, and a power law with a smooth exponent, which yielding does not disturb. The
    weights follow from the yielding.
    """
    steps = piece["load"].values
    for name, stiffness_names in _STIFFNESS_NAMES_BY_DISPLACEMENT.items():
        if any(variable_name not in piece.variables for variable_name in (name, stiffness_names[0])):
            continue
        per_area = STIFFNESS_PER_AREA_FACTOR / float(piece["nominal_area"]) if name == "closure" else 1.0
        stored_values = {
            variable_name: _to_float_array(piece.variables[variable_name], (*member_dims, "load"))
            for variable_name in (name, *stiffness_names)
            if variable_name in piece.variables
        }
        loading = stored_values[stiffness_names[0]]
        with np.errstate(divide="ignore", invalid="ignore"):
            displacement, slope = load_crossings.interpolate_with_slopes(
                stored_values[name], per_area * steps / loading
            )
            stiffness = per_area * load_crossings.loads / slope
            values = {name: displacement, stiffness_names[0]: stiffness}
            if stiffness_names[1] in stored_values:
                unloading = stored_values[stiffness_names[1]]
                ratio = load_crossings.interpolate(unloading / loading, are_sums=False)
                log_unloading = load_crossings.interpolate_smoothly(np.log(unloading))
                elasticity = load_crossings.min_at_bracketing_steps(np.minimum(loading / unloading, 1.0))
                weight = np.nan_to_num(elasticity) ** ELASTIC_WEIGHT_EXPONENT
                log_by_ratio = np.where(weight > 0, np.log(ratio * stiffness), 0.0)
                values[stiffness_names[1]] = np.exp(weight * log_by_ratio + (1 - weight) * log_unloading)
        for variable_name, array in values.items():
            if variable_name in variables:
                dims, interpolated, attributes = variables[variable_name]
                is_between_steps = np.isfinite(array) & (load_crossings.fraction != 1)
                variables[variable_name] = dims, np.where(is_between_steps, array, interpolated), attributes


def _evaluate_pull_off(piece: xarray.Dataset, member_dims: tuple[str, ...], law: FrictionLaw) -> dict[str, Any]:
    """Return each member's pull-off force, whether this force is a lower bound, and the friction force at zero load."""
    is_bound = (_to_float_array(piece.variables["pull_off_is_bound"], member_dims) != 0).astype(np.float64)
    zero_load_sums = {
        name: _to_float_array(piece.variables[name], (*member_dims, *MOTION_DIMENSION_NAMES), missing=True)[
            ..., None, None
        ]
        for name in QUANTITIES_SUMMED_AT_ZERO_LOAD
    }
    direction_axis = len(member_dims) + 1
    # In the model, adhesive contacts lose area under shear but do not grow, so only the area loss is applied.
    tangential = law.load("unloaded", zero_load_sums, 1 - law.area_loss).mean(axis=direction_axis)
    pull_off = _to_float_array(piece.variables["pull_off"], member_dims)[..., None, None, None]
    tangential = np.where(abs(tangential) <= MAX_RELATIVE_ROUND_OFF * pull_off, 0.0, tangential)
    return {
        "pull_off": piece.variables["pull_off"],
        "share_of_pull_off_bounds": (member_dims, is_bound, quantity_attributes("share_of_pull_off_bounds")),
        "friction_at_no_load": (
            (*member_dims, "sliding", "mu0", "tau0"), tangential, quantity_attributes("friction_at_no_load")
        ),
    }  # fmt: skip


def _determine_member_status(piece: xarray.Dataset, loads: Floats, forces: _MemberForces) -> NDArray[Any]:
    """Return the status of each member for each sliding rule, direction, load, mu0 and tau0."""
    is_known = np.isfinite(forces.normal)
    is_locked = is_known & (forces.normal <= 0)
    status = friction.choose_statuses(
        touched=True, reached=is_known & forces.is_reached & ~is_locked, locked=is_locked, below=forces.is_below
    )
    status = np.array(np.broadcast_to(status, forces.normal.shape), STATUS_DTYPE)
    step_dimension = find_step_dimension(piece)
    if "status" in piece:
        # A load without a friction coefficient gets the status of the next loading step, unless this status is "ok".
        status_codes = _to_float_array(
            piece.variables["status"], (*find_cell_dimensions(piece), "repetition", step_dimension)
        ).astype(int)
        step_values = piece[step_dimension].values
        step_index = np.minimum(np.searchsorted(step_values, loads), step_values.size - 1)
        step_status = np.array(STATUSES)[status_codes[..., step_index]][..., None, None, :, None, None]
        step_status = np.broadcast_to(step_status, status.shape)
        is_replaced = (status != friction.STATUS_OK) & (step_status != friction.STATUS_OK)
        status[is_replaced] = step_status[is_replaced]
    return status


def _find_load_crossings(
    piece: xarray.Dataset, loads: Floats, names: Sequence[str] = LOAD_SUM_NAMES
) -> tuple[dict[str, Floats], LoadCrossings]:
    """Return summed contact forces and areas, and the steps at which load curves reach the requested loads.

    The sums are taken over the contacts of a member.
    """
    step_dimension = find_step_dimension(piece)
    member_dims = (*find_cell_dimensions(piece), "repetition")
    # Variables of xarray are much faster to access than data arrays, because variables have no coordinates.
    piece_variables = piece.variables
    elastic_loads = _to_float_array(piece_variables["normal_elastic"], (*member_dims, step_dimension))
    curve = (
        elastic_loads
        if step_dimension == "approach"
        else np.where(np.isfinite(elastic_loads), piece[step_dimension].values, np.nan)
    )
    sums = {
        name: _to_float_array(
            piece_variables[name], (*member_dims, *MOTION_DIMENSION_NAMES, step_dimension), missing=True
        )
        for name in names
    }
    return sums, LoadCrossings.from_curves(
        curve, loads, interpolates_ratio=step_dimension == "load"
    ).without_crossings_after_nan(curve, loads)


def _get_missing_motion_coordinates(piece: xarray.Dataset, study: Study) -> dict[str, Any]:
    """Return coordinates for the sliding rule and the direction of motion if the result lacks these dimensions."""
    coordinate_values = {
        "sliding": list(study.contact.sliding_rules()),
        "direction": list(study.contact.direction_angles()),
    }
    return {
        name: ((name,), coordinate_values[name][:1], quantity_attributes(name))
        for name in MOTION_DIMENSION_NAMES
        if name not in piece.dims
    }


def _replace_sums_by_ratios(variables: dict[str, Any], nominal_area: Any) -> dict[str, Any]:
    """Replace sums over contacts by ratios of two sums, such as the mean pressure, which is load over area."""
    dims, elastic = variables["normal_elastic"][:2]
    if nominal_area is not None and "pull_off" in variables:
        pull_off = variables["pull_off"]
        pressure = pull_off.values / float(nominal_area)
        variables["pull_off_pressure"] = (pull_off.dims, pressure, quantity_attributes("pull_off_pressure"))
    sums = {name: variable[1] for name, variable in variables.items() if isinstance(variable, tuple)}
    ratios = compute_ratios(sums, elastic, None if nominal_area is None else float(nominal_area))
    shown_variables = {
        name: variable
        for name, variable in variables.items()
        if QUANTITIES[name].shown or name not in VALIDITY_RATIO_OPERANDS
    }
    return shown_variables | {name: (dims, values, quantity_attributes(name)) for name, values in ratios.items()}


def _to_float_array(array: xarray.Variable, dims: tuple[str, ...], *, missing: bool = False) -> Floats:
    """Return a variable as an array of floats, with the dimensions in the given order.

    If `missing` is true, missing dimensions are added with the length 1.
    """
    own_dims = [dim for dim in dims if dim in array.dims]
    values = arrange_axes(array, own_dims).astype(np.float64)
    if not missing:
        return values
    return np.asarray(values[tuple(slice(None) if dim in own_dims else np.newaxis for dim in dims)])
