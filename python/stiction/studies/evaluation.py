"""Evaluation of results at given loads. These can be elastic loads, normal loads or mean normal loads.

*mean*: the mean normal load of the ensemble equals the given load, and values are ratios of means, as in the figures of
the paper. *elastic*: the elastic load of each member, before any contact slides, equals the given load. *normal*: the
normal load of each member at the onset of sliding, which includes friction on slopes, equals the given load. For small
slopes the three definitions agree to four digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, check_choice, float_array
from stiction._units import short_repr
from stiction.mechanics import friction
from stiction.mechanics.closed_forms import gentle_friction, hardness_under_shear
from stiction.mechanics.friction import (
    LOAD_SUM_NAMES,
    STATUS_DTYPE,
    STATUSES,
    VALIDITY_RATIOS,
    compute_load,
    compute_loads,
    validity_ratio,
)
from stiction.mechanics.quantities import (
    COMMON_VALIDITY_QUANTITIES,
    DISTRIBUTION_QUANTITIES,
    GAP_QUANTITIES,
    INTERPOLATED_QUANTITIES,
    ONSET_QUANTITIES,
    QUANTITIES,
    STIFFNESS_PER_AREA_QUANTITIES,
    VALIDITY_RATIO_OPERANDS,
    ZERO_LOAD_SUM_QUANTITIES,
    quantity_attributes,
)
from stiction.studies import intervals
from stiction.studies.hardness import AreaInterpolator
from stiction.studies.intervals import LoadCrossings
from stiction.studies.maps import (
    MAP_CELL_DIMENSIONS,
    MOTION_DIMENSIONS,
    choose_mu0_and_tau0,
    evaluate_ensemble_quantities,
    find_cell_dimensions,
)
from stiction.studies.result import Result
from stiction.studies.study import Study, find_step_dimension

if TYPE_CHECKING:
    import xarray

LATERAL_SUMS = ("lateral_elastic", "lateral_frictional", "lateral_adhesive")
INTERVAL_STATISTICS = ["mean", "lower", "upper"]
SPREAD_QUANTILES = (0.1, 0.9)  # quantiles of the values of single members, stored as `spread_low` and `spread_high`
NEGLIGIBLE_COEFFICIENT = 1e-9
"""Largest coefficient that is attributed to round-off, for an interface without strength."""
NEGLIGIBLE_LOAD_RATIO = 0.01
"""Smallest ratio of load to pull-off force for which the load is not negligible and a coefficient has a meaning."""


ADHESIVE_SUMS = ("normal_adhesive", "tangential_adhesive")  # contact sums that increase with junction growth

MIN_STIFFNESS_STEPS = 3  # minimum number of approaches or loads needed to compute a stiffness

FULL_CONTACT_STATUS, AREA_ABOVE_NOMINAL_STATUS = "complete", "above-nominal"
"""Statuses of contacts with a true area equal to the nominal area (first) or above it (second).

The sum of areas exceeds the nominal area if asperities overlap.
"""


def at_load(
    result: Result | xarray.Dataset, loads: ArrayLike, *, mu0: ArrayLike | None = None, tau0: ArrayLike | None = None,
    reading: LoadDefinition | None = None, member_kind: MemberKind | None = None, names: Collection[str] | None = None,
) -> xarray.Dataset:  # fmt: skip
    """Evaluate friction, true area and contact statistics at given loads, and compute their 95 % intervals.

    Parameters
    ----------
    result : Result, or xarray.Dataset of member sums
    loads : (l,) array_like of float, mN
        Loads above 0. For adhesive bodies, a load of 0 is evaluated at `find_negligible_load`.
    mu0 : (m,) array_like of float, optional
    tau0 : (t,) array_like of float, GPa, optional
        By default the values in the study. Other values need no new computation of contacts.
    reading : {"mean", "elastic", "normal"}, optional
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
        an axis, and friction_all_round, the mean over all directions. contact_area (µm²), contact_count,
        normal_stiffness and quantities of validity have the dimensions of the cells and load. If the study includes the
        onset of sliding, there are also tangential_stiffness (mN/µm), displacement_at_sliding (µm) and
        fraction_slipped; at the mean load of an ensemble the latter two are means weighted by the load of each pair.
        Measured bodies also have contact statistics, quantiles of areas and pressures, slopes of the gap and
        `gentle_friction`. The last dimension is statistic ("mean", "lower", "upper"). spread_low and spread_high are
        the 10th and 90th percentiles of single members, reading_difference is the relative difference between the three
        definitions of the load, members is the number of members, and ok is the number of members with a coefficient.

    Raises
    ------
    ValueError
        If a load, mu0 or tau0 is outside its range, or there are no members of the kind.
    """
    result = Result.of(result)
    study = result.study
    is_measured = study.is_measured
    reading = reading or ("elastic" if is_measured else "mean")
    check_choice("reading", reading, LoadDefinition)
    unique_loads = np.unique(np.atleast_1d(float_array("loads", loads)))
    if study.contact.adheres and 0 in unique_loads:
        unique_loads = np.unique(np.where(unique_loads == 0, find_negligible_load(result), unique_loads))
    if not unique_loads.size or not (unique_loads > 0).all():
        raise ValueError(f"loads must be above 0 mN, got {short_repr(loads)}")
    strengths = choose_mu0_and_tau0(result, mu0, tau0)
    areas = None
    if reading == "mean":
        point = _evaluate_ensemble(result, unique_loads, *strengths, names)
    else:
        members = _evaluate_members_before_growth(result, unique_loads, *strengths, reading, member_kind, names)
        if study.contact.junction_growth:
            areas = _build_member_area_interpolator(members, result)
            members = _apply_junction_growth(members, study, areas, names)
        point = _average_members(study, members, names)
        if is_measured:
            gradient, slope = (point[name].sel(statistic="mean") for name in ("rms_gradient", "rms_slope"))
            cell_dims = [str(dim) for dim in gradient.dims]
            directional_slope = slope.transpose(*cell_dims, "direction").values
            modulus, rules = float(study.contact.effective_modulus), point["sliding"].values
            point = point.assign(
                estimate_small_slope_friction(cell_dims, gradient.values, directional_slope, rules, *strengths, modulus)
            )
    if is_measured and _is_requested("reading_difference", names):
        # `reading_difference` compares the coefficients at equal elastic load and at equal normal load.
        other_definition: LoadDefinition = "normal" if reading == "elastic" else "elastic"
        members = _evaluate_members_before_growth(
            result, unique_loads, *strengths, other_definition, member_kind, names
        )
        if areas is not None:
            members = _apply_junction_growth(members, study, areas, ())
        other_coefficient = members["friction_coefficient"].mean(("repetition", "direction"))
        coefficient = point["friction_all_round"].sel(statistic="mean")
        other_dims = [str(dim) for dim in coefficient.dims if dim not in (*MAP_CELL_DIMENSIONS, "load")]
        point["reading_difference"] = abs(other_coefficient / coefficient - 1).max(other_dims).variable
    return point.assign_attrs(reading=reading)


def has_only_negligible_loads(result: Result) -> bool:
    """Return whether the loads of the study are all negligible compared with the largest mean pull-off force."""
    study = result.study
    if not (study.contact.adheres and study.friction.load):
        return False
    return float(study.friction.load[-1]) < NEGLIGIBLE_LOAD_RATIO * max(_average_pull_off_by_piece(result))


def find_negligible_load(result: Result) -> float:
    """Return a load (mN) that is negligible compared with the pull-off force, if possible the smallest load step."""
    negligible_load = NEGLIGIBLE_LOAD_RATIO * min(_average_pull_off_by_piece(result))
    smallest_step = float(result.study.contact.loading_steps()[0])
    return smallest_step if smallest_step < negligible_load else 0.1 * negligible_load


def _average_pull_off_by_piece(result: Result) -> list[float]:
    """Return the mean pull-off force (mN) over the members in each piece of a result that is read at a time."""
    return [float(np.nanmean(piece["pull_off"].values)) for piece in result.pieces(["pull_off"])]


# ---- Directions ------------------------------------------------------------------------------------------------------


def find_axes_with_both_directions(directions: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Return the axes of motion (0 to 180 degrees) for which both opposite directions are given, and their indices.

    The indices have the shape (axes, 2).
    """
    angles = np.mod(directions, 360.0)
    axes, direction_pairs = [], []
    for index, angle in enumerate(angles):
        opposite = np.flatnonzero(np.abs(np.mod(angles - angle - 180.0 + 1e-6, 360.0)) < 2e-6)
        if angle < 180.0 and opposite.size:
            axes.append(float(angle))
            direction_pairs.append((index, int(opposite[0])))
    order = np.argsort(axes)
    return np.array(axes)[order], np.array(direction_pairs, np.intp).reshape(-1, 2)[order]


def _is_requested(name: str, names: Collection[str] | None) -> bool:
    """Return whether a quantity is requested. All quantities are requested if no names are given."""
    return names is None or name in names


# ---- Evaluation at the mean load of the ensemble ---------------------------------------------------------------------


def _evaluate_ensemble(
    result: Result, loads: Floats, mu0: Floats, tau0: Floats, names: Collection[str] | None
) -> xarray.Dataset:
    """Compute ensemble means at given mean loads. The dimension `statistic` contains means and interval limits."""
    import xarray

    def evaluate_direction_groups(
        quantities: Sequence[str], groups: NDArray[np.intp] | None = None
    ) -> dict[str, xarray.Dataset]:
        """Evaluate quantities at the given mean normal loads, after averaging over each group of directions."""

        def average_direction_groups(piece: xarray.Dataset) -> xarray.Dataset:
            grouped_piece = piece.isel(direction=xarray.DataArray(groups, dims=("group", "way")))
            grouped_piece = grouped_piece.mean("way", skipna=False, keep_attrs=True).rename(group="direction")
            return grouped_piece.assign_coords(
                direction=("direction", np.arange(grouped_piece.sizes["direction"], dtype=float))
            )

        transform = None if groups is None else average_direction_groups
        return evaluate_ensemble_quantities(
            result, loads, mu0, tau0, quantities, transform, includes_validity=bool(validity_names)
        )

    head = result.head
    validity_names = [name for name in COMMON_VALIDITY_QUANTITIES if _is_requested(name, names)]
    has_stiffness = head.sizes[find_step_dimension(head)] >= MIN_STIFFNESS_STEPS
    other_quantities = [name for name in (*ONSET_QUANTITIES, "contact_load") if name in head]
    quantities = [
        name
        for name in (
            "contact_area",
            "contact_count",
            *(["normal_stiffness"] if has_stiffness else []),
            *other_quantities,
        )
        if _is_requested(name, names)
    ]
    # Friction changes the normal load, so area and stiffness depend slightly on mu0 and tau0.
    round_means = evaluate_direction_groups(
        ["friction_coefficient", *quantities],
        np.arange(head.sizes["direction"])[np.newaxis] if "direction" in head.dims else None,
    )
    coefficient_table = round_means["friction_coefficient"]
    if "direction" in head.dims:
        round_means = {name: table.isel(direction=0) for name, table in round_means.items()}
        coefficient_table = evaluate_direction_groups(["friction_coefficient"])["friction_coefficient"]
    variables: dict[str, Any] = {
        "friction_coefficient": _add_statistic_dimension(coefficient_table, "friction_coefficient"),
        "status": coefficient_table["status"].variable,
    }
    if "direction" in head.dims:
        variables["friction_all_round"] = _add_statistic_dimension(
            round_means["friction_coefficient"], "friction_coefficient"
        )
        axes, direction_pairs = find_axes_with_both_directions(head["direction"].values)
        if axes.size:
            axis_means = _add_statistic_dimension(
                evaluate_direction_groups(["friction_coefficient"], direction_pairs)["friction_coefficient"],
                "friction_coefficient",
            )
            dims = ["axis" if each == "direction" else each for each in axis_means.dims]
            variables["friction_by_axis"] = xarray.Variable(dims, axis_means.values, axis_means.attrs)
            coefficient_table = coefficient_table.assign_coords(axis=("axis", axes, quantity_attributes("axis")))
    for name in quantities:
        variables[name] = _add_statistic_dimension(round_means[name], name)
    if result.study.contact.adheres and _is_requested("pull_off", names):
        unloaded_members = member_values(result, loads[:1], mu0=mu0, tau0=tau0)
        for name in ("pull_off", "share_of_pull_off_bounds", "friction_at_no_load"):
            unloaded_values = unloaded_members[name].transpose("repetition", ...)
            mean = np.stack(intervals.average_independent_values(unloaded_values.values), axis=-1)
            first_rule = {dim: 0 for dim in unloaded_values.dims if dim == "sliding" and dim not in head.dims}
            variables[name] = xarray.Variable(
                (*unloaded_values.dims[1:], "statistic"), mean, unloaded_values.attrs
            ).isel(first_rule)
    variables |= {name: round_means["friction_coefficient"][name].variable for name in validity_names}
    variables |= {"members": ((), result.members.size, {"units": "1", "long_name": "members"})}
    dataset = xarray.Dataset(variables, coefficient_table.coords, coefficient_table.attrs).assign_coords(
        statistic=INTERVAL_STATISTICS
    )
    return dataset.transpose(*find_cell_dimensions(dataset), ...)


def _add_statistic_dimension(table: xarray.Dataset, name: str) -> xarray.Variable:
    import xarray

    variable = table[name]
    values = np.stack([table[each].values for each in (name, "lower", "upper")], axis=-1)
    return xarray.Variable((*variable.dims, "statistic"), values, variable.attrs)


def choose_loads_in_range(result: Result | xarray.Dataset, steps: int = 80) -> Floats:
    """Return loads (mN) in a geometric series that covers the load range of a result."""
    elastic_loads = Result.of(result).mean_elastic_loads
    highest_load = float(elastic_loads.max())
    if not highest_load > 0:
        raise ValueError("no pair of this result is in contact at any step, so there is nothing to draw")
    lowest_load = float(
        elastic_loads.isel({find_step_dimension(elastic_loads.to_dataset(name="load_of_step")): 0}).max()
    )
    if not 1e-6 * highest_load < lowest_load < 0.5 * highest_load:
        lowest_load = 1e-6 * highest_load if lowest_load < highest_load / 2 else highest_load / 10
    return np.asarray(np.geomspace(lowest_load, highest_load, steps))


NUM_DEFAULT_LOADS = 3  # number of loads for which results are shown if the study specifies no loads


def choose_default_loads(result: Result) -> Floats:
    """Return the loads (mN) of the study. If the study has none, return a few loads within the range of the result.

    Raises a `ValueError` if there is no contact.
    """
    settings = result.study.friction
    if settings.load:
        return np.array([float(load) for load in settings.load])
    log_limits = np.log10(choose_loads_in_range(result, 2))
    loads = 10 ** (log_limits[0] + (log_limits[1] - log_limits[0]) * np.linspace(0.2, 0.8, NUM_DEFAULT_LOADS))
    return np.unique([float(f"{load:.0e}") for load in loads])


# ---- Means over members ----------------------------------------------------------------------------------------------


def _remove_round_off(means: Floats, dims: Sequence[str], members: xarray.Dataset) -> Floats:
    """If mu0 and tau0 are 0, replace round-off errors in means over opposite directions by 0.

    The means have the dimensions (*dims, statistic). Without strength, the contributions of opposite directions cancel
    except for round-off, which would have a random sign.
    """
    mu0, tau0 = (members[name].values.reshape([-1 if dim == name else 1 for dim in dims]) for name in ("mu0", "tau0"))
    # The limits of the interval are NaN if there are few members.
    exceeds_round_off = (np.abs(means) >= NEGLIGIBLE_COEFFICIENT).any(axis=-1)
    is_zero = ~exceeds_round_off & (mu0 == 0) & (tau0 == 0)
    return np.where(is_zero[..., np.newaxis] & ~np.isnan(means), 0.0, means)


def _average_members(study: Study, members: xarray.Dataset, names: Collection[str] | None) -> xarray.Dataset:
    import xarray

    member_dependence = MemberDependence.from_coordinates(study, members)
    has_several_directions = members.sizes["direction"] > 1
    member_variables = members.variables
    dims = [str(dim) for dim in member_variables["friction_coefficient"].dims if dim != "repetition"]
    variables: dict[str, Any] = {}
    for name in members.data_vars:
        if name in ("normal_load", "tangential_load") and not _is_requested(name, names):
            continue  # Normal and tangential loads are reported only for single members.
        values = member_variables[name]
        if values.dtype.kind == "f" and "repetition" in values.dims:
            value_dims = [dim for dim in values.dims if dim != "repetition"]
            means = member_dependence.mean_with_interval(values.transpose("repetition", *value_dims).values)
            limit = QUANTITIES[str(name)].bounds[1]
            means = np.where(means > limit, np.maximum(limit, means[..., :1]), means)
            variables[str(name)] = ((*value_dims, "statistic"), means, values.attrs)
    if "contact_area_fraction" in variables:
        own_dims, fraction, attributes = variables["contact_area_fraction"]
        status, fraction = _classify_area_fractions(fraction, uses_half_space=study.uses_half_space)
        variables["contact_area_fraction"] = (own_dims, fraction, attributes)
        variables["contact_status"] = (own_dims[:-1], status, quantity_attributes("contact_status"))
    coefficient = member_variables["friction_coefficient"].transpose("repetition", *dims).values
    direction_axis = dims.index("direction") + 1
    status = member_variables["status"].transpose("repetition", *dims).values
    ok = status == friction.STATUS_OK
    counts = np.stack([(status == each).sum(axis=0) for each in STATUSES])
    # If no member has a coefficient at a point, the point gets the most frequent status of the members.
    most_frequent_status = np.array(STATUSES, STATUS_DTYPE)[counts.argmax(axis=0)]
    common_status = np.where(ok.any(axis=0), np.array("ok", STATUS_DTYPE), most_frequent_status)
    other_dims = [dim for dim in dims if dim != "direction"]
    coordinates: dict[str, Any] = {
        str(name): each for name, each in members.coords.items() if "repetition" not in each.dims
    }
    round_mean = coefficient.mean(axis=direction_axis)
    variables["friction_all_round"] = (
        (*other_dims, "statistic"),
        _remove_round_off(member_dependence.mean_with_interval(round_mean), other_dims, members),
        quantity_attributes("friction_all_round"),
    )  # fmt: skip
    axes, direction_pairs = find_axes_with_both_directions(members["direction"].values)
    if has_several_directions and axes.size and _is_requested("friction_by_axis", names):
        coefficient_by_axis = np.stack(
            [np.take(coefficient, pair, axis=direction_axis).mean(axis=direction_axis) for pair in direction_pairs],
            axis=direction_axis,
        )
        axis_dims = ["axis" if dim == "direction" else dim for dim in dims]
        variables["friction_by_axis"] = (
            (*axis_dims, "statistic"),
            _remove_round_off(member_dependence.mean_with_interval(coefficient_by_axis), axis_dims, members),
            quantity_attributes("friction_by_axis"),
        )  # fmt: skip
        coordinates["axis"] = ("axis", axes, quantity_attributes("axis"))
    single_members = np.moveaxis(coefficient, direction_axis, 1)
    low, high = intervals.compute_sample_quantiles(
        single_members.reshape(-1, *single_members.shape[2:]), SPREAD_QUANTILES
    )  # NaN if no member has a coefficient
    variables |= {
        "spread_low": (other_dims, low, quantity_attributes("spread_low")),
        "spread_high": (other_dims, high, quantity_attributes("spread_high")),
        "status": (dims, common_status, quantity_attributes("status")),
        "ok": (dims, ok.sum(axis=0), quantity_attributes("ok")),
        "members": ((), coefficient.shape[0], {"units": "1", "long_name": "members"}),
    }  # fmt: skip
    return xarray.Dataset(variables, coordinates | {"statistic": INTERVAL_STATISTICS}, members.attrs)


def _classify_area_fractions(fraction: Floats, *, uses_half_space: bool) -> tuple[NDArray[Any], Floats]:
    """Return the contact status for each true area fraction, and the area fractions limited to 1.

    The fractions have the shape (..., 3). In the asperity model, fractions above 1 become NaN instead.
    """
    is_above_nominal = fraction[..., 0] > 1
    status = np.where(
        is_above_nominal, FULL_CONTACT_STATUS if uses_half_space else AREA_ABOVE_NOMINAL_STATUS, friction.STATUS_OK
    )
    limited_fraction = (
        np.minimum(fraction, 1.0) if uses_half_space else np.where(is_above_nominal[..., np.newaxis], np.nan, fraction)
    )
    return status, limited_fraction


@dataclass(frozen=True, eq=False)
class MemberDependence:
    """Statistical dependence between members: none, between neighbours on a line, or through shared scans."""

    order: NDArray[np.intp] | None = None
    lines: NDArray[np.intp] | None = None
    scans: tuple[Any, Any] | None = None

    @classmethod
    def from_coordinates(cls, study: Study, coordinates: Mapping[Any, Any]) -> MemberDependence:
        """Determine the dependence between members from their positions.

        Members on adjacent lines, or at adjacent positions of a line, are neighbours.
        """
        surfaces: Any = study.surfaces
        if math.prod(surfaces.scan_counts) > 1:
            return cls(scans=surfaces.scan_indices_of_members(np.asarray(coordinates["repetition"])))
        if not study.is_measured or study.is_areal:
            return cls()
        lines, x, y = (np.asarray(coordinates[name]) for name in ("line", "x", "y"))
        order = np.lexsort((x, lines, y))
        return cls(order, lines[order])

    def mean_with_interval(self, values: Floats) -> Floats:
        """Average values over the members, ignoring NaN. Return the mean and the limits of its 95 % interval.

        The values have the shape (members, ...), and the result has the shape (..., 3).
        """
        if self.scans is not None:
            columns = values.reshape(values.shape[0], -1).T
            rows = [
                _compute_mean_and_interval(column, intervals.average_scan_pairs(column, *self.scans))
                for column in columns
            ]
            return np.array(rows).reshape(*values.shape[1:], 3)
        if self.order is None or self.lines is None:
            return np.stack(intervals.average_independent_values(values), axis=-1)
        flat_values = values[self.order].reshape(values.shape[0], -1)
        # To save time, columns with the same missing members are evaluated together.
        # In most columns, no member is missing.
        is_finite = np.isfinite(flat_values)
        is_incomplete = ~is_finite.all(axis=0)
        masks, mask_indices = [np.ones(len(flat_values), bool)], np.zeros(flat_values.shape[1], np.intp)
        if is_incomplete.any():
            other_masks, other_group = np.unique(is_finite[:, is_incomplete].T, axis=0, return_inverse=True)
            masks += list(other_masks)
            mask_indices[is_incomplete] = 1 + other_group.ravel()
        means_and_limits = np.empty((flat_values.shape[1], 3))
        for mask_index in np.unique(mask_indices):
            is_in_group, mask = mask_indices == mask_index, masks[mask_index]
            means_and_limits[is_in_group] = np.stack(
                intervals.average_line_means(flat_values[mask][:, is_in_group], self.lines[mask]), axis=-1
            )
        return means_and_limits.reshape(*values.shape[1:], 3)


def _compute_mean_and_interval(values: Floats, scan_mean: intervals.ScanPairMean | None) -> tuple[float, float, float]:
    """Return the mean of the values and its interval limits. The limits are above 0 if no value is negative."""
    if scan_mean is None:
        finite_values = values[np.isfinite(values)]
        return float(finite_values.mean()) if finite_values.size else np.nan, np.nan, np.nan
    limits = intervals.interval_around_mean(scan_mean.mean, scan_mean.half_width, np.nanmin(values) < 0)
    return scan_mean.mean, float(limits[0]), float(limits[1])


# ---- Values of each member -------------------------------------------------------------------------------------------

LoadDefinition = Literal["mean", "elastic", "normal"]
MemberKind = Literal["shifts", "surrogates"]


def member_values(
    result: Result | xarray.Dataset, loads: ArrayLike, *, mu0: ArrayLike | None = None, tau0: ArrayLike | None = None,
    reading: LoadDefinition = "elastic", member_kind: MemberKind | None = None,
) -> xarray.Dataset:  # fmt: skip
    """Evaluate friction and contact quantities at given loads for each member of a result.

    Parameters
    ----------
    result, loads, mu0, tau0, of
        As for `at_load`.
    reading : {"elastic", "normal"}

    Returns
    -------
    xarray.Dataset
        friction_coefficient, normal_load and tangential_load (mN) and status have the dimensions of the cells,
        repetition, sliding, direction, load, mu0 and tau0; a single sliding rule or direction is a dimension of length
        1. Height maps with the asperity model at elastic loads also have lateral_load (mN). Other quantities have the
        dimensions of the cells, repetition and load (and fraction_below), and are evaluated at the elastic load.
    """
    if reading == "mean":
        raise ValueError("reading must be 'elastic' or 'normal', because a single member has no mean load")
    result = Result.of(result)
    unique_loads = np.unique(np.atleast_1d(float_array("loads", loads)))
    strengths = choose_mu0_and_tau0(result, mu0, tau0)
    members = _evaluate_members_before_growth(result, unique_loads, *strengths, reading, member_kind)
    if result.study.contact.junction_growth:
        members = _apply_junction_growth(members, result.study, _build_member_area_interpolator(members, result))
    if reading == "elastic" and set(LATERAL_SUMS) <= set(result.head.data_vars):
        sums = interpolate_member_sums(result, unique_loads, LATERAL_SUMS, member_kind=member_kind)
        lateral_sums = {name: sums[name].values[..., np.newaxis, np.newaxis] for name in LATERAL_SUMS}
        lateral = compute_load("lateral", lateral_sums, strengths[0][:, np.newaxis], strengths[1])
        dims = (*sums[LATERAL_SUMS[0]].dims, "mu0", "tau0")
        members = members.assign(lateral_load=(dims, lateral, quantity_attributes("lateral_load")))
    return members


def _evaluate_members_before_growth(
    result: Result, loads: Floats, mu0: Floats, tau0: Floats, reading: LoadDefinition, member_kind: MemberKind | None,
    names: Collection[str] | None = None,
) -> xarray.Dataset:  # fmt: skip
    """Evaluate each member of a result at given loads, without the effect of junction growth.

    If the contacts of the study grow, the dataset also contains the sums that `_apply_junction_growth` requires.
    """

    def evaluate_piece(piece: xarray.Dataset) -> xarray.Dataset:
        return _evaluate_piece(piece, result.study, loads, mu0, tau0, reading, names)

    return _evaluate_pieces(result, member_kind, evaluate_piece)


# ---- Junction growth -------------------------------------------------------------------------------------------------


def build_area_interpolator(dataset: xarray.Dataset, result: Result | xarray.Dataset) -> AreaInterpolator:
    """Create an interpolator that returns true areas for given hardness and E* at the loads of a dataset."""
    result = Result.of(result)
    study, loads = result.study, dataset["load"].values
    area = dataset["contact_area"].sel(statistic="mean")
    area_per_load = area.mean([dim for dim in area.dims if dim != "load"]).values / loads
    gradient = float(dataset["rms_gradient"].sel(statistic="mean").mean())
    return AreaInterpolator.from_result(
        loads, area_per_load, gradient, compute_area_load_exponent(result, loads), study, result
    )


def _build_member_area_interpolator(members: xarray.Dataset, result: Result) -> AreaInterpolator:
    """Create an interpolator that returns true areas for a given hardness at the loads of the member values."""
    loads, area, gradient = members["load"].values, members["contact_area"], members["rms_gradient"]
    area_per_load = np.asarray(area.mean([dim for dim in area.dims if dim != "load"]).values) / loads
    study = result.study
    return AreaInterpolator.from_result(
        loads, area_per_load, float(gradient.mean()), np.zeros(loads.size), study, result
    )


def compute_mean_areas(result: Result) -> Floats:
    """Return the true area (µm²) at each computed load, averaged over the members.

    `Result.compute_mean_areas` caches these areas.
    """
    zero_strength = np.zeros(1)
    areas = _evaluate_members_before_growth(
        result, result.study.contact.loading_steps(), zero_strength, zero_strength, "elastic", None, ()
    )
    return np.asarray(areas["contact_area"].mean([dim for dim in areas["contact_area"].dims if dim != "load"]).values)


def compute_area_load_exponent(result: Result, loads: Floats) -> Floats:
    """Return d ln(A/F) / d ln F at the given loads F (mN), where A is the mean true area."""
    step_loads = result.study.contact.loading_steps()
    if step_loads.size > 1:
        area_per_load = result.mean_areas / step_loads
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


def _apply_junction_growth(
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
    if _is_requested("contact_area_at_onset", names):
        growth_at_onset = np.where(np.isfinite(growth_ratios["all"]), growth_ratios["all"], np.nan)
        area_dims = tuple(dim for dim in dims if dim not in MOTION_DIMENSIONS)
        area = members["contact_area"].transpose(*area_dims[:-2]).values[..., np.newaxis, np.newaxis] * growth_at_onset
        grown_variables["contact_area_at_onset"] = (area_dims, area, quantity_attributes("contact_area_at_onset"))
    return members.drop_vars(ADHESIVE_SUMS).assign(grown_variables)


def interpolate_member_sums(
    result: Result | xarray.Dataset,
    loads: Floats,
    names: Sequence[str] = LOAD_SUM_NAMES,
    *,
    member_kind: MemberKind | None = None,
) -> xarray.Dataset:
    """Return contact sums of all members at elastic loads (mN). The default is the six sums that determine friction.

    The dimensions are cells, repetition, sliding, direction and load.
    """
    import xarray

    result = Result.of(result)
    study = result.study

    def evaluate_piece(piece: xarray.Dataset) -> xarray.Dataset:
        sums, load_crossings = _find_load_crossings(piece, loads, names)
        dims = (*find_cell_dimensions(piece), "repetition", *MOTION_DIMENSIONS, "load")
        values = np.broadcast_arrays(*map(load_crossings.interpolate, sums.values()))
        coordinates = {str(name): each for name, each in piece.coords.items() if {*each.dims} <= {*dims} - {"load"}}
        return xarray.Dataset(
            {name: (dims, each) for name, each in zip(sums, values, strict=True)},
            _get_missing_motion_coordinates(piece, study) | coordinates,
        )

    return _evaluate_pieces(result, member_kind, evaluate_piece)


def compute_ensemble_friction(
    result: Result | xarray.Dataset, loads: Floats, mu0: Floats, tau0: Floats
) -> xarray.DataArray:
    """Compute the ratio mean(F_T) / mean(F_N) at elastic loads (mN), with its jackknife interval.

    The means are taken over members and directions.

    The dimensions are cells, sliding, load, mu0, tau0 and statistic. The value is NaN if mean(F_N) is not above 0.
    """
    import xarray

    contact_sums = interpolate_member_sums(result, loads).mean("direction")
    dims = [str(dim) for dim in contact_sums[LOAD_SUM_NAMES[0]].dims if dim != "repetition"]
    sums = {name: contact_sums[name].transpose("repetition", *dims).values for name in LOAD_SUM_NAMES}
    member_loads = np.stack(compute_loads(sums, mu0, tau0))  # shape (2, members, ..., mu0, tau0)
    load_sums = member_loads.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where(load_sums[0] > 0, load_sums[1] / load_sums[0], np.nan)
        sums_without_member = load_sums[:, np.newaxis] - member_loads
        jackknife_changes = sums_without_member[1] / sums_without_member[0] - mean
    jackknife_sums = intervals.PowerSums(mean.shape)
    jackknife_sums.add(np.moveaxis(jackknife_changes, 0, -1))
    half_width = (
        jackknife_sums.half_width() if contact_sums.sizes["repetition"] >= intervals.MIN_SAMPLE_SIZE else np.nan
    )
    values = np.stack([mean, np.maximum(mean - half_width, 0.0), mean + half_width], axis=-1)
    attributes = quantity_attributes("friction_coefficient")
    return xarray.DataArray(values, dims=(*dims, "mu0", "tau0", "statistic"), attrs=attributes)


@dataclass(frozen=True, kw_only=True)
class ForcesPerLoad:
    """Normal and tangential forces per unit elastic load, expressed as linear functions of mu0 and tau0."""

    elastic: float = 0.0
    rub: float = 1.0
    stick: float
    rub_normal: float = 0.0
    stick_normal: float = 0.0

    @classmethod
    def from_contact_sums(cls, contact_sums: Mapping[str, Any], **more: Any) -> Self:
        """Create the linear functions from the six mean contact sums, which are divided by the elastic load."""
        sums_per_load = {name: float(contact_sums[name] / contact_sums["normal_elastic"]) for name in LOAD_SUM_NAMES}
        return cls(
            elastic=sums_per_load["tangential_elastic"], rub=sums_per_load["tangential_frictional"],
            stick=sums_per_load["tangential_adhesive"], rub_normal=sums_per_load["normal_frictional"],
            stick_normal=sums_per_load["normal_adhesive"], **more,
        )  # fmt: skip

    def compute_coefficient(self, mu0: Any, tau0: Any, area: Any = 1.0) -> Any:
        """Compute the friction coefficient for a true area that is `area` times the computed true area."""
        tangential = self.elastic + mu0 * self.rub + tau0 * self.stick * area
        return tangential / (1 + mu0 * self.rub_normal + tau0 * self.stick_normal * area)


def _evaluate_pieces(
    result: Result, member_kind: MemberKind | None, evaluate: Callable[[xarray.Dataset], xarray.Dataset]
) -> xarray.Dataset:
    import xarray

    pieces = [evaluate(piece) for piece in result.pieces() if piece.sizes["repetition"]]
    values = pieces[0] if len(pieces) == 1 else xarray.concat(
        pieces, "repetition", data_vars="minimal", coords="minimal", compat="override", combine_attrs="override"
    )  # fmt: skip
    if "surrogate" not in values.coords:
        return values
    is_surrogate = values["surrogate"].values.astype(bool)
    is_wanted = bool(is_surrogate.all()) if member_kind is None else member_kind == "surrogates"
    if not (is_surrogate == is_wanted).any():
        other_kind: MemberKind = "shifts" if is_wanted else "surrogates"
        raise ValueError(f"member_kind must be {other_kind!r} for this result, got {member_kind!r}")
    return values.isel(repetition=np.flatnonzero(is_surrogate == is_wanted))


_FRICTION_VARIABLES = (
    "friction_coefficient",
    "normal_load",
    "tangential_load",
    "status",
    "contact_area",
    *GAP_QUANTITIES,
)
"""Quantities that are always evaluated, because intervals of friction need the true area and the slopes of the gap."""


def _evaluate_piece(
    piece: xarray.Dataset, study: Study, loads: Floats, mu0: Floats, tau0: Floats, reading: LoadDefinition,
    names: Collection[str] | None,
) -> xarray.Dataset:  # fmt: skip
    """Evaluate one piece (group of members) of a result at given loads.

    If the steps are loads, values are interpolated over the logarithm of the load. `names` lists quantities to evaluate
    besides `_FRICTION_VARIABLES`; None stands for all.
    """
    import xarray

    cell_dims, step_dimension = find_cell_dimensions(piece), find_step_dimension(piece)
    member_dims = (*cell_dims, "repetition")
    piece_variables = piece.variables
    sums_at_steps, load_crossings = _find_load_crossings(piece, loads)
    motions = [name for name in MOTION_DIMENSIONS if name in piece.dims]
    contact_sums = (
        {name: load_crossings.interpolate(values) for name, values in sums_at_steps.items()}
        if reading == "elastic"
        else {}
    )
    if reading == "elastic":
        normal, tangential = compute_loads(contact_sums, mu0, tau0)
        is_reached, is_below = (
            load_crossings.reached[..., None, None, :, None, None],
            load_crossings.below[..., None, None, :, None, None],
        )
    else:
        # Values are interpolated to the given normal loads, and have the shape (..., load, mu0, tau0).
        normal, tangential = (np.moveaxis(each, -3, -1) for each in compute_loads(sums_at_steps, mu0, tau0))
        normal = np.broadcast_to(normal, tangential.shape)
        with np.errstate(invalid="ignore"):
            positive_normal = np.where(normal > 0, normal, np.nan) if step_dimension == "load" else normal
        normal_crossing = LoadCrossings.from_curves(
            positive_normal, loads, interpolates_ratio=step_dimension == "load"
        ).without_crossings_after_nan(normal, loads)
        is_reached, is_below = (np.moveaxis(each, -1, -3) for each in (normal_crossing.reached, normal_crossing.below))
        normal, tangential = (np.moveaxis(normal_crossing.interpolate(each), -1, -3) for each in (normal, tangential))
    status = _determine_member_status(piece, loads, normal, is_reached, is_below)
    with np.errstate(divide="ignore", invalid="ignore"):
        coefficient = np.where(status == friction.STATUS_OK, tangential / normal, np.nan)
    dims = (*member_dims, "sliding", "direction", "load", "mu0", "tau0")
    variables: dict[str, Any] = {
        "friction_coefficient": (dims, coefficient, quantity_attributes("friction_coefficient")),
        "normal_load": (dims, normal, quantity_attributes("normal_load")),
        "tangential_load": (dims, tangential, quantity_attributes("tangential_load")),
        "status": (dims, status, quantity_attributes("status")),
    }
    rules = [str(each) for each in piece["sliding"].values] if "sliding" in motions else []
    if contact_sums and {"opposing", "all"} <= set(rules):
        frictional_sums = contact_sums["tangential_frictional"]
        sums_by_rule = [
            np.take(frictional_sums, rules.index(rule), axis=len(member_dims)) for rule in ("opposing", "all")
        ]
        with np.errstate(divide="ignore", invalid="ignore"):
            # The denominator is the sum of F |t·s|. To first order in the slopes, this sum equals the load.
            opposing_fraction = sums_by_rule[0] / sums_by_rule[1]
        variables["share_opposing"] = (
            (*member_dims, "direction", "load"),
            opposing_fraction,
            quantity_attributes("share_opposing"),
        )
    requested_names = None if names is None else {*_FRICTION_VARIABLES, *names}
    for name in INTERPOLATED_QUANTITIES:
        if name != "normal_elastic" and not _is_requested(name, requested_names):
            continue
        if name in piece_variables and step_dimension in piece_variables[name].dims:
            interpolated = load_crossings.interpolate(
                _to_float_array(piece_variables[name], (*member_dims, step_dimension)),
                are_sums=QUANTITIES[name].proportional,
            )
            variables[name] = ((*member_dims, "load"), interpolated, piece_variables[name].attrs)
    for name in DISTRIBUTION_QUANTITIES:
        if name in piece_variables and _is_requested(name, requested_names):
            interpolated = load_crossings.interpolate(
                _to_float_array(piece_variables[name], (*member_dims, "fraction_below", step_dimension)), are_sums=False
            )
            variables[name] = ((*member_dims, "fraction_below", "load"), interpolated, piece_variables[name].attrs)
    for name in (*GAP_QUANTITIES, "pull_off"):
        if name in piece_variables:
            variables[name] = piece_variables[name]
    if "pull_off" in piece_variables:
        # An element is 1 if only a lower bound on the pull-off force of the member is known, and 0 otherwise.
        bounds = (_to_float_array(piece_variables["pull_off_is_bound"], member_dims) != 0).astype(np.float64)
        variables["share_of_pull_off_bounds"] = (member_dims, bounds, quantity_attributes("share_of_pull_off_bounds"))
        zero_load_sums = {
            name: _to_float_array(piece_variables[name], (*member_dims, *MOTION_DIMENSIONS), missing=True)[
                ..., None, None
            ]
            for name in ZERO_LOAD_SUM_QUANTITIES
        }
        friction_at_no_load = compute_load("unloaded", zero_load_sums, mu0[:, np.newaxis], tau0).mean(
            axis=len(member_dims) + 1
        )
        variables["friction_at_no_load"] = (
            (*member_dims, "sliding", "mu0", "tau0"), friction_at_no_load, quantity_attributes("friction_at_no_load"),
        )  # fmt: skip
    coordinates: dict[str, Any] = {
        str(name): each.variable for name, each in piece.coords.items() if name not in (step_dimension, "mu0", "tau0")
    }
    parameters = {"load": loads, "mu0": mu0, "tau0": tau0}
    coordinates |= _get_missing_motion_coordinates(piece, study) | {
        name: (name, each, quantity_attributes(name)) for name, each in parameters.items()
    }
    variables = _replace_sums_by_ratios(variables, piece.coords.get("nominal_area"))
    variables = {name: each for name, each in variables.items() if _is_requested(name, requested_names)}
    if study.contact.junction_growth:
        for name in ADHESIVE_SUMS:
            adhesive_sums = contact_sums[name] if contact_sums else load_crossings.interpolate(sums_at_steps[name])
            variables[name] = dims[:-2], np.broadcast_to(adhesive_sums, tangential.shape[:-2])
    return xarray.Dataset(variables, coordinates, piece.attrs)


def _find_load_crossings(
    piece: xarray.Dataset, loads: Floats, names: Sequence[str] = LOAD_SUM_NAMES
) -> tuple[dict[str, Floats], LoadCrossings]:
    """Return the members' contact sums, and the points at which the load curves reach the given loads."""
    step_dimension = find_step_dimension(piece)
    member_dims = (*find_cell_dimensions(piece), "repetition")
    # Access to variables is much faster than access to data arrays, because variables have no coordinates.
    piece_variables = piece.variables
    elastic_loads = _to_float_array(piece_variables["normal_elastic"], (*member_dims, step_dimension))
    curve = (
        elastic_loads
        if step_dimension == "approach"
        else np.where(np.isfinite(elastic_loads), piece[step_dimension].values, np.nan)
    )
    sums = {
        name: _to_float_array(piece_variables[name], (*member_dims, *MOTION_DIMENSIONS, step_dimension), missing=True)
        for name in names
    }
    return sums, LoadCrossings.from_curves(
        curve, loads, interpolates_ratio=step_dimension == "load"
    ).without_crossings_after_nan(curve, loads)


def _get_missing_motion_coordinates(piece: xarray.Dataset, study: Study) -> dict[str, Any]:
    """Return coordinates for the sliding rule and the direction unless these are dimensions of the result."""
    values = {"sliding": list(study.contact.sliding_rules()), "direction": list(study.contact.direction_angles())}
    return {
        name: ((name,), values[name][:1], quantity_attributes(name))
        for name in MOTION_DIMENSIONS
        if name not in piece.dims
    }


def _replace_sums_by_ratios(variables: dict[str, Any], nominal_area: Any) -> dict[str, Any]:
    """Add ratios of contact sums to the variables, and remove the sums that are needed only for these ratios."""
    dims, elastic = variables["normal_elastic"][:2]
    ratios: dict[str, Any] = {}
    if nominal_area is not None and "pull_off" in variables:
        pull_off = variables["pull_off"]
        pressure = pull_off.values / float(nominal_area)
        variables["pull_off_pressure"] = (pull_off.dims, pressure, quantity_attributes("pull_off_pressure"))
    if nominal_area is not None:
        area = float(nominal_area)
        ratios["contact_area_fraction"] = variables["contact_area"][1] / area
        ratios["nominal_pressure"] = np.broadcast_to(elastic, elastic.shape) / area
        for name in STIFFNESS_PER_AREA_QUANTITIES:
            if (stiffness := QUANTITIES[name].numerator) in variables:
                ratios[name] = 1e3 * variables[stiffness][1] / area  # converts mN/µm³ to GPa/mm
    with np.errstate(divide="ignore", invalid="ignore"):
        carried_load = variables["contact_load"][1] if "contact_load" in variables else elastic
        ratios["mean_pressure"] = carried_load / variables["contact_area"][1]
    sums = {name: each[1] for name, each in variables.items() if isinstance(each, tuple)}
    for name, (numerator, _) in VALIDITY_RATIOS.items():
        if numerator in sums and name not in sums:
            ratios[name] = validity_ratio(name, sums)
    shown_variables = {
        name: each for name, each in variables.items() if QUANTITIES[name].shown or name not in VALIDITY_RATIO_OPERANDS
    }
    return shown_variables | {name: (dims, values, quantity_attributes(name)) for name, values in ratios.items()}


def _to_float_array(array: xarray.Variable, dims: tuple[str, ...], *, missing: bool = False) -> Floats:
    """Convert a variable to an array of floats whose dimensions are in the given order.

    If `missing` is true, missing dimensions are added with the length 1.
    """
    own_dims = [dim for dim in dims if dim in array.dims]
    values = array.transpose(*own_dims).values.astype(np.float64)
    if not missing:
        return values
    return np.asarray(values[tuple(slice(None) if dim in own_dims else np.newaxis for dim in dims)])


def _determine_member_status(
    piece: xarray.Dataset, loads: Floats, normal: Floats, is_reached: Any, is_below: Any
) -> NDArray[Any]:
    """Return the status of each member as an array of shape (..., sliding, direction, load, mu0, tau0)."""
    is_known = np.isfinite(normal)
    is_locked = is_known & (normal <= 0)
    status = friction.choose_statuses(
        touched=True, reached=is_known & is_reached & ~is_locked, locked=is_locked, below=is_below
    )
    status = np.array(np.broadcast_to(status, normal.shape), STATUS_DTYPE)
    step_dimension = find_step_dimension(piece)
    if "status" in piece:
        # A member without a coefficient gets the status of the first step at or above the load.
        # If the status of this step is "ok", the status of the member is kept.
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


def estimate_small_slope_friction(
    dims: list[str], gradient: Floats, slope: Floats, rules: Iterable[Any], mu0: Floats, tau0: Floats, modulus: float
) -> dict[str, Any]:
    """Compute the small-slope estimate of friction from rms gradients and directional rms slopes of the gaps.

    The rms gradients have the shape (...), and the rms slopes have the shape (..., direction).
    """
    has_slopes = (gradient[..., np.newaxis] > 0) & (slope > 0)
    gradients, slopes = (
        np.where(has_slopes, each, 1.0)[..., None, None] for each in (gradient[..., np.newaxis], slope)
    )
    estimates = [
        gentle_friction(
            mu0[:, np.newaxis], tau0, rms_gradient=gradients, rms_slope=slopes, effective_modulus=modulus, sliding=rule
        )
        for rule in rules
    ]
    values = np.where(has_slopes[..., np.newaxis, :, np.newaxis, np.newaxis], np.stack(estimates, axis=-4), np.nan)
    return {
        "gentle_friction": (
            [*dims, "sliding", "direction", "mu0", "tau0"], values, quantity_attributes("gentle_friction")
        )
    }  # fmt: skip
