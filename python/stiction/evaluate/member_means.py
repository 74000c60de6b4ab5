"""Means of friction and contact quantities over the members of a result, with intervals and statuses."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.evaluate import intervals
from stiction.mechanics import friction
from stiction.mechanics.friction import NEGLIGIBLE_COEFFICIENT, STATUS_DTYPE, STATUSES
from stiction.mechanics.quantities import (
    LOADING_COUNTERPARTS,
    STIFFNESS_QUANTITIES,
    find_upper_bound,
    is_requested,
    quantity_attributes,
)
from stiction.solve.contact_statistics import compute_sample_quantiles
from stiction.solve.layout import arrange_axes
from stiction.study.study import Study

if TYPE_CHECKING:
    import xarray

# Quantiles of the friction coefficients of individual members, stored as `spread_low` and `spread_high`.
SPREAD_QUANTILES = (0.1, 0.9)
FULL_CONTACT_STATUS, AREA_ABOVE_NOMINAL_STATUS = "complete", "above-nominal"
"""Statuses of contacts with a true area equal to the nominal area (first) or above it (second).

The sum of areas exceeds the nominal area if asperities overlap.
"""


@dataclass(frozen=True, eq=False)
class AdjacentLoadValues:
    """Quantities of all members at the two computed loads next to each requested load, one below and one above.

    The position of a requested load is a fraction of the distance in ln F; it is 0 at a computed load.
    """

    below: xarray.Dataset
    above: xarray.Dataset
    position: Floats


def average_members(
    study: Study,
    members: xarray.Dataset,
    names: Collection[str] | None,
    adjacent_load_values: AdjacentLoadValues | None = None,
) -> xarray.Dataset:
    """Average quantities over the members, with 95 % intervals of the means.

    `names` lists quantities to evaluate besides friction; None stands for all. With `adjacent_load_values`, the
    intervals at loads between computed loads include the interpolation error.
    """
    import xarray

    dependence = MemberDependence.from_coordinates(study, members)
    members, ratio_errors = estimate_missing_unloading_stiffnesses(members)
    if adjacent_load_values is not None:
        adjacent_load_values = replace(
            adjacent_load_values,
            below=estimate_missing_unloading_stiffnesses(adjacent_load_values.below)[0],
            above=estimate_missing_unloading_stiffnesses(adjacent_load_values.above)[0],
        )

    def average(dims: Sequence[str], get_values: Callable[[xarray.Dataset], Floats]) -> Floats:
        """Return the mean and the interval limits of a quantity over the members."""
        values = get_values(members)
        means = dependence.mean_with_interval(values)
        if adjacent_load_values is None or "load" not in dims:
            return means
        position = adjacent_load_values.position.reshape([-1 if dim == "load" else 1 for dim in dims])
        below, above = get_values(adjacent_load_values.below), get_values(adjacent_load_values.above)
        return include_interpolation_error(means, values, below, above, position, dependence.mean_with_interval)

    coordinates: dict[str, Any] = {
        str(name): members.variables[name]
        for name in members.coords
        if "repetition" not in members.variables[name].dims
    }
    nominal_area = float(members.coords.get("nominal_area", math.inf))
    find_limit = partial(find_upper_bound, nominal_area=nominal_area, uses_half_space=study.uses_half_space)
    variables = _average_quantities(members, average, names, find_limit, ratio_errors)
    if "contact_area_fraction" in variables:
        fraction_dims, fraction, attributes = variables["contact_area_fraction"]
        area_status, fraction = _classify_area_fractions(fraction, uses_half_space=study.uses_half_space)
        variables["contact_area_fraction"] = fraction_dims, fraction, attributes
        variables["contact_status"] = fraction_dims[:-1], area_status, quantity_attributes("contact_status")
    dims = [str(dim) for dim in members.variables["friction_coefficient"].dims if dim != "repetition"]
    dims_of_mean = [dim for dim in dims if dim != "direction"]
    direction_axis = dims.index("direction") + 1

    def get_coefficients(members: xarray.Dataset) -> Floats:
        return arrange_axes(members.variables["friction_coefficient"], ("repetition", *dims))

    coefficient, status = get_coefficients(members), arrange_axes(members.variables["status"], ("repetition", *dims))

    directional_dims, directional_means, attributes = variables["friction_coefficient"]
    is_downhill = directional_means[..., 0] < -NEGLIGIBLE_COEFFICIENT
    variables["friction_coefficient"] = (
        directional_dims,
        _remove_negative_means(directional_means, is_downhill),
        attributes,
    )
    # A mean over directions is undefined if the slider slides by itself in one direction, unless mu0 = tau0 = 0.
    has_strength = np.add.outer(members["mu0"].values, members["tau0"].values) > 0
    counts_as_downhill = is_downhill & ~(directional_means[..., 2] >= 0) & has_strength

    def average_coefficients(
        average_over_directions: Callable[[Floats], Floats],
        dims: list[str],
        name: str,
        is_any_downhill: NDArray[np.bool_],
    ) -> tuple[Any, ...]:
        means = _remove_round_off(
            average(dims, lambda members: average_over_directions(get_coefficients(members))), dims, members
        )
        is_removed = is_any_downhill | (means[..., 0] < -NEGLIGIBLE_COEFFICIENT)
        return (*dims, "statistic"), _remove_negative_means(means, is_removed), quantity_attributes(name)

    variables["mean_friction"] = average_coefficients(
        lambda coefficients: coefficients.mean(axis=direction_axis), dims_of_mean, "mean_friction",
        counts_as_downhill.any(axis=direction_axis - 1),
    )  # fmt: skip
    axes, direction_pairs = find_axes_with_both_directions(members["direction"].values)
    if members.sizes["direction"] > 1 and axes.size and is_requested("friction_by_axis", names):

        def average_opposite_directions(coefficients: Floats) -> Floats:
            return np.stack(
                [
                    np.take(coefficients, pair, axis=direction_axis).mean(axis=direction_axis)
                    for pair in direction_pairs
                ],
                axis=direction_axis,
            )

        variables["friction_by_axis"] = average_coefficients(
            average_opposite_directions, ["axis" if dim == "direction" else dim for dim in dims], "friction_by_axis",
            np.stack(
                [
                    np.take(counts_as_downhill, pair, axis=direction_axis - 1).any(axis=direction_axis - 1)
                    for pair in direction_pairs
                ],
                axis=direction_axis - 1,
            ),
        )  # fmt: skip
        coordinates["axis"] = ("axis", axes, quantity_attributes("axis"))
    single_coefficients = np.moveaxis(coefficient, direction_axis, 1)
    low_quantile, high_quantile = compute_sample_quantiles(
        single_coefficients.reshape(-1, *single_coefficients.shape[2:]), SPREAD_QUANTILES
    )
    statuses = np.where(is_downhill, np.array(friction.STATUS_DOWNHILL, STATUS_DTYPE), _find_common_statuses(status))
    variables |= {
        # A member that slides by itself needs no tangential load, so its coefficient counts as 0.
        "spread_low": (dims_of_mean, np.maximum(low_quantile, 0.0), quantity_attributes("spread_low")),
        "spread_high": (dims_of_mean, np.maximum(high_quantile, 0.0), quantity_attributes("spread_high")),
        "status": (dims, statuses, quantity_attributes("status")),
        "ok": (dims, np.isin(status, friction.STATUSES_WITH_COEFFICIENT).sum(axis=0), quantity_attributes("ok")),
        "members": ((), coefficient.shape[0], {"units": "1", "long_name": "members"}),
    }
    return xarray.Dataset(variables, coordinates | {"statistic": intervals.INTERVAL_STATISTICS}, members.attrs)


def estimate_missing_unloading_stiffnesses(members: xarray.Dataset) -> tuple[xarray.Dataset, dict[str, Floats]]:
    """Estimate the unloading stiffness of each member for which only the loading stiffness was computed.

    The missing stiffness is the member's loading stiffness times the ratio of both stiffnesses of the other members.
    Both stiffnesses then have means over the same members: a mean over the few members with both could be below the
    mean loading stiffness, which is impossible. The ratio is the inverse of the mean ratio of compliances, because
    compliances are averaged.

    The dict contains, by name of the stiffness, the half width of the 95 % interval of the ratio's logarithm. It is 0
    where no stiffness is missing, and NaN if fewer than `MIN_SAMPLE_SIZE` members have both stiffnesses.
    """
    estimates: dict[str, Any] = {}
    ratio_errors: dict[str, Floats] = {}
    for name, loading_name in LOADING_COUNTERPARTS.items():
        if name not in members.variables or loading_name not in members.variables:
            continue
        variable = members.variables[name]
        dims = ("repetition", *(str(dim) for dim in variable.dims if dim != "repetition"))
        stiffness, loading = (arrange_axes(members.variables[each], dims) for each in (name, loading_name))
        is_missing = np.isnan(stiffness) & ~np.isnan(loading)
        if not is_missing.any():
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            compliance_ratio = loading / stiffness
            mean_ratio, _, upper_ratio = intervals.average_independent_values(compliance_ratio)
            estimates[name] = dims, np.where(is_missing, loading / mean_ratio, stiffness), variable.attrs
            ratio_errors[name] = np.where(is_missing.any(axis=0), np.log(upper_ratio / mean_ratio), 0.0)
    return members.assign(estimates), ratio_errors


def _average_quantities(
    members: xarray.Dataset, average: Callable[[Sequence[str], Callable[[xarray.Dataset], Floats]], Floats],
    names: Collection[str] | None, find_limit: Callable[[str], float], ratio_errors: Mapping[str, Floats],
) -> dict[str, Any]:  # fmt: skip
    """Return the means of all quantities over the members.

    Loads are averaged only if `names` includes them.

    `find_limit` returns the largest upper limit of the interval of a quantity. `ratio_errors` widens the intervals of
    stiffnesses that were estimated for some members.
    """
    variables: dict[str, Any] = {}
    for name in map(str, members.data_vars):
        values = members.variables[name]
        is_load = name in ("normal_load", "tangential_load")
        if (is_load and not is_requested(name, names)) or values.dtype.kind != "f" or "repetition" not in values.dims:
            continue
        dims = [str(dim) for dim in values.dims if dim != "repetition"]
        get_values = partial(_get_member_values, name=name, dims=("repetition", *dims))
        means = average(dims, get_values)
        if name in STIFFNESS_QUANTITIES:
            means = _average_compliances(partial(average, dims), get_values, means)
        if name in ratio_errors:
            means = _include_ratio_error(means, ratio_errors[name])
        limit = find_limit(name)
        means = np.where(means > limit, np.maximum(limit, means[..., :1]), means)
        variables[name] = (*dims, "statistic"), means, values.attrs
    return variables


def _average_compliances(
    average: Callable[[Callable[[xarray.Dataset], Floats]], Floats],
    get_stiffnesses: Callable[[xarray.Dataset], Floats],
    mean_stiffnesses: Floats,
) -> Floats:
    """Return the mean stiffness dF/dδ over members, computed as the inverse of their mean compliance dδ/dF.

    Where the mean compliance is not above 0, because contacts disappear as the load grows, the mean stiffness remains.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        compliance, lower, upper = np.moveaxis(average(lambda members: 1 / get_stiffnesses(members)), -1, 0)
        limits = [1 / compliance, 1 / upper, np.where(lower > 0, 1 / lower, np.where(np.isnan(lower), np.nan, np.inf))]
    is_positive = (compliance > 0) & (mean_stiffnesses[..., 0] > 0)
    return np.where(is_positive[..., np.newaxis], np.stack(limits, axis=-1), mean_stiffnesses)


def _include_ratio_error(means: Floats, ratio_error: Floats) -> Floats:
    """Widen intervals of mean stiffnesses by the error of the ratio from which missing stiffnesses were estimated.

    Both half widths are combined in quadrature, as logarithms where the interval is positive.
    """
    mean, lower, upper = np.moveaxis(means, -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        limits = [
            np.where(
                (mean > 0) & (lower >= 0),
                mean * np.exp(sign * np.hypot(np.log(limit / mean), ratio_error)),
                mean + sign * np.hypot(limit - mean, mean * ratio_error),
            )
            for sign, limit in ((-1, lower), (1, upper))
        ]
    return np.where(ratio_error[..., np.newaxis] == 0, means, np.stack([mean, *limits], axis=-1))


def _get_member_values(members: xarray.Dataset, name: str, dims: Sequence[str]) -> Floats:
    return arrange_axes(members.variables[name], dims)


def include_interpolation_error(
    means: Floats, values: Floats, below: Floats, above: Floats, position: Floats,
    mean_with_interval: Callable[[Floats], Floats],
) -> Floats:  # fmt: skip
    """Widen the intervals of means to include the error of interpolation between two computed loads.

    The error has two parts, which are combined with the interval in quadrature. The random part is due to members whose
    quantities jump when contacts appear or merge: if the changes between the computed loads have the half width h, it
    is h sqrt(3 t (1 - t)) at the position t. (This is the error for numbers that scatter independently at the two loads
    and in the middle.) The systematic part is the difference from a power law. Logarithms are used for positive
    numbers.

    Parameters
    ----------
    means : (..., 3) array of float
        Mean, lower and upper limit.
    values, below, above : (members, ...) array of float
        Interpolated values, and values at the computed points below and above.
    position : array of float
        Position between the points, from 0 to 1; no error is added at 0.
    mean_with_interval : callable
        Function that computes means and limits, as `MemberDependence.mean_with_interval`.
    """
    mean, lower, upper = np.moveaxis(means, -1, 0)
    with np.errstate(all="ignore"):
        is_known = np.isfinite(below) & np.isfinite(above) & np.isfinite(values)
        is_positive = (~is_known | ((below > 0) & (above > 0) & (values > 0))).all(axis=0)
        change_between_loads = np.where(is_known, np.where(is_positive, np.log(above / below), above - below), np.nan)
        known_count = np.maximum(is_known.sum(axis=0), 1)
        mean_change = np.where(is_known, change_between_loads, 0.0).sum(axis=0) / known_count
        deviation = (change_between_loads - mean_change) * np.where(is_positive, values / mean, 1.0)
        deviation_limits = mean_with_interval(deviation)
        half_width = np.where(
            (deviation == 0).all(axis=0), 0.0, (deviation_limits[..., 2] - deviation_limits[..., 1]) / 2
        )
        random_error = np.sqrt(3 * position * (1 - position)) * half_width
        power_law = np.where(is_known, below ** (1 - position) * above**position, 0.0).sum(axis=0) / known_count
        log_error = np.where(is_positive, np.hypot(random_error, np.log(power_law / mean)), random_error)
        is_logarithmic = is_positive & (lower > 0)
        absolute_error = np.where(is_positive, mean * log_error, log_error)
        lower, upper = (
            np.where(
                is_logarithmic,
                mean * np.exp(sign * np.hypot(np.log(limit / mean), log_error)),
                mean + sign * np.hypot(limit - mean, absolute_error),
            )
            for sign, limit in ((-1, lower), (1, upper))
        )
        is_signed = np.logical_or.reduce([(array < 0).any(axis=0) for array in (below, above, values)])
    lower = np.where(is_signed | ~(mean >= 0), lower, np.maximum(lower, 0.0))
    widened_interval = np.stack([mean, lower, upper], axis=-1)
    return np.where(np.broadcast_to(position > 0, mean.shape)[..., np.newaxis], widened_interval, means)


def _find_common_statuses(statuses: NDArray[Any]) -> NDArray[Any]:
    """Combine the statuses of all members (first axis) into one status for each friction coefficient.

    The combined status has a coefficient if the status of any member has one. Otherwise, it is the most frequent
    status. The statuses with a coefficient are "ok" and "bulk-shear", whose coefficient is a lower limit.
    """
    status_counts = np.stack([(statuses == status).sum(axis=0) for status in STATUSES])
    most_frequent_statuses = np.array(STATUSES, STATUS_DTYPE)[status_counts.argmax(axis=0)]
    with_coefficient = friction.STATUSES_WITH_COEFFICIENT
    return np.select(
        [(statuses == status).any(axis=0) for status in with_coefficient],
        [np.array(status, STATUS_DTYPE) for status in with_coefficient], most_frequent_statuses,
    )  # fmt: skip


def _classify_area_fractions(fraction: Floats, *, uses_half_space: bool) -> tuple[NDArray[Any], Floats]:
    """Return the contact status for each true area fraction, and the fractions with values above 1 replaced.

    Half-space fractions above 1 become 1. In the asperity model, they become NaN. The fractions have the shape (...,
    3).
    """
    is_above_nominal = fraction[..., 0] > 1
    status = np.where(
        is_above_nominal, FULL_CONTACT_STATUS if uses_half_space else AREA_ABOVE_NOMINAL_STATUS, friction.STATUS_OK
    )
    limited_fraction = (
        np.minimum(fraction, 1.0) if uses_half_space else np.where(is_above_nominal[..., np.newaxis], np.nan, fraction)
    )
    return status, limited_fraction


def _remove_negative_means(means: Floats, is_removed: NDArray[np.bool_]) -> Floats:
    """Replace means and limits by NaN where `is_removed` is True, and negative means from round-off by 0.

    The last axis contains mean, lower limit and upper limit.
    """
    means = np.where(is_removed[..., np.newaxis], np.nan, means)
    means[..., 0] = np.where(means[..., 0] < 0, 0.0, means[..., 0])
    return means


def _remove_round_off(means: Floats, dims: Sequence[str], members: xarray.Dataset) -> Floats:
    """Replace mean coefficients that consist only of round-off by exact zeros, if mu0 = tau0 = 0.

    The means have the dimensions (*dims, statistic). Without interface strength, the contributions of opposite
    directions cancel except for round-off, which would have a random sign.
    """
    mu0, tau0 = (members[name].values.reshape([-1 if dim == name else 1 for dim in dims]) for name in ("mu0", "tau0"))
    # If there are too few members for an interval, its limits are NaN, and comparisons with NaN are False.
    exceeds_round_off = (np.abs(means) >= NEGLIGIBLE_COEFFICIENT).any(axis=-1)
    is_zero = ~exceeds_round_off & (mu0 == 0) & (tau0 == 0)
    return np.where(is_zero[..., np.newaxis] & ~np.isnan(means), 0.0, means)


def find_axes_with_both_directions(directions: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Return the angle (degrees) and direction indices of each axis along which both directions were computed.

    The indices have the shape (axes, 2).
    """
    angles = np.mod(directions, 360.0)
    axes, direction_pairs = [], []
    for index, angle in enumerate(angles):
        opposite_indices = np.flatnonzero(np.abs(np.mod(angles - angle - 180.0 + 1e-6, 360.0)) < 2e-6)
        if angle < 180.0 and opposite_indices.size:
            axes.append(float(angle))
            direction_pairs.append((index, int(opposite_indices[0])))
    order = np.argsort(axes)
    return np.array(axes)[order], np.array(direction_pairs, np.intp).reshape(-1, 2)[order]


@dataclass(frozen=True, eq=False)
class MemberDependence:
    """Kind of statistical dependence between members: none, correlation of neighbouring members, or shared scans."""

    order: NDArray[np.intp] | None = None
    lines: NDArray[np.intp] | None = None
    scans: tuple[Any, Any] | None = None

    @classmethod
    def from_coordinates(cls, study: Study, coordinates: Mapping[Any, Any]) -> MemberDependence:
        """Determine the statistical dependence of members from the positions of their cutouts.

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
        """Average a quantity over the members, ignoring NaN, and return the mean with its 95 % interval.

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
        # Columns in which the same members have finite values are averaged as one array.
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
    """Return the mean over pairs of scans with its 95 % limits; without `scan_mean`, a plain mean and NaN limits."""
    if scan_mean is None:
        finite_values = values[np.isfinite(values)]
        return float(finite_values.mean()) if finite_values.size else np.nan, np.nan, np.nan
    limits = intervals.interval_around_mean(scan_mean.mean, scan_mean.half_width, np.nanmin(values) < 0)
    return scan_mean.mean, float(limits[0]), float(limits[1])
