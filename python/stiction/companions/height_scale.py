"""Friction and true area of a measured pair whose heights are multiplied by a factor, to model another finish.

A separate study is computed for each factor, and stored in the directory of the result. Friction at other factors is
interpolated.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from stiction._arguments import parse_numbers, reject_decimal_commas
from stiction._checks import Floats, check_choice, float_array
from stiction._errors import ArgumentError
from stiction._text import format_duration
from stiction._units import short_repr
from stiction.evaluate.at_load import at_load
from stiction.evaluate.budget import add_uncertainty
from stiction.evaluate.maps import warn_if_given_tau0_is_large
from stiction.evaluate.member_means import (
    AREA_ABOVE_NOMINAL_STATUS,
    MemberDependence,
    find_axes_with_both_directions,
    include_interpolation_error,
)
from stiction.evaluate.member_values import evaluate_members
from stiction.mechanics.friction import STATUS_OK
from stiction.mechanics.quantities import quantity_attributes
from stiction.solve.companion_study import CompanionStudy
from stiction.solve.executors import executor_or_thread_pool
from stiction.solve.member_solution import estimate_member_time
from stiction.solve.member_sums import MemberSums
from stiction.solve.store import StoredResult
from stiction.study.measured_bodies import MAX_HEIGHT_FACTOR as MAX_FACTOR
from stiction.study.measured_bodies import MIN_HEIGHT_FACTOR as MIN_FACTOR
from stiction.study.members import get_first_pair
from stiction.study.study import Study
from stiction.surfaces.pairing import SIDES

if TYPE_CHECKING:
    import xarray

HEIGHT_SCALE_DIRECTORY = "height_scale"
"""Name of the subdirectory of a result directory that contains one companion study per height factor."""

MAX_INTERPOLATED_LOG2_FACTOR_STEP = 0.5
"""Largest difference of log2(factor) between two computed height factors that allows interpolation between them."""

NUM_FACTOR_DIGITS = 6

ScaledBodies = Literal["both", "upper", "lower"]
"""Bodies whose heights are multiplied by a height factor: both bodies, the upper body or the lower body."""

_INTERPOLATED_VARIABLES = (
    "mean_friction", "friction_by_axis", "friction_combined", "friction_prediction", "spread_low", "spread_high",
    "contact_area", "contact_area_fraction", "contact_count", "mean_pressure", "normal_stiffness",
    "stiffness_per_area", "closure", "closure_stiffness", "tangential_stiffness_per_area", "rms_gradient",
    "rms_slope", "pull_off", "pull_off_pressure",
)  # fmt: skip
"""Variables of an `at_load` dataset that are interpolated between computed height factors."""


class MissingHeightFactorsError(ArgumentError):
    """Error raised if friction is requested at height factors that have not been computed.

    Attributes
    ----------
    factors : ndarray of float
        Factors that have to be computed.
    seconds : float
        Estimated time on one core.
    """

    def __init__(self, factors: Floats, seconds: float) -> None:
        range_text = f"{factors.size} factors from {factors[0]:g} to {factors[-1]:g}"
        factors_text = range_text if factors.size > 1 else f"the factor {factors[0]:g}"
        super().__init__(
            "{height_scale} needs results at {which}, about {time} on one core; give {compute=True} to compute them",
            which=factors_text, time=format_duration(seconds),
        )  # fmt: skip
        self.factors, self.seconds = factors, seconds


def parse_height_factors(factors: Any) -> Floats:
    """Parse height factors, and return them in ascending order with six significant digits.

    Parameters
    ----------
    factors : float, array_like or str
        Factors from 0.01 to 100. A string is a list, as in "0.5,1,2", or a range, as in "0.25..4", which stands for
        its two limits and all powers of √2 between them.

    Raises
    ------
    ArgumentError
        If a factor is not a number or out of range, or if the limits of a range are not in ascending order.
    """
    parsed_factors = _parse_factor_text(factors) if isinstance(factors, str) else float_array("height_scale", factors)
    parsed_factors = np.unique(
        [float(f"{factor:.{NUM_FACTOR_DIGITS}g}") for factor in np.ravel(parsed_factors).tolist()]
    )
    if not parsed_factors.size or not ((parsed_factors >= MIN_FACTOR) & (parsed_factors <= MAX_FACTOR)).all():
        allowed_range = f"from {MIN_FACTOR:g} to {MAX_FACTOR:g}"
        raise ArgumentError(
            "{height_scale} must be {allowed}, got {got}", allowed=allowed_range, got=short_repr(factors)
        )
    return parsed_factors


def _parse_factor_text(text: str) -> Floats:
    """Parse a list of height factors, as in "0.5,1,2", or a range, as in "0.25..4"."""
    try:
        if ".." not in text:
            if text.count(",") == 1:
                reject_decimal_commas("height_scale", text)
            return np.array(parse_numbers("height_scale", text, integers=True))
        smallest_factor, largest_factor = (float(text_part) for text_part in text.split(".."))
        if not MIN_FACTOR <= smallest_factor < largest_factor <= MAX_FACTOR:
            raise ValueError
    except ArgumentError:
        raise
    except ValueError:
        raise ArgumentError(
            '{height_scale} must be a list of factors, as in "0.5,1,2", or a range of increasing factors between '
            '{least:g} and {most:g}, as in "0.25..4", got {got}',
            least=MIN_FACTOR, most=MAX_FACTOR, got=short_repr(text),
        ) from None  # fmt: skip
    factor_nodes = _find_enclosing_powers_of_two(smallest_factor, largest_factor)
    return np.array(
        [
            smallest_factor,
            *factor_nodes[(factor_nodes > smallest_factor) & (factor_nodes < largest_factor)],
            largest_factor,
        ]
    )


def _find_enclosing_powers_of_two(low: float, high: float) -> Floats:
    """Return the height factors 2^(n/2), with consecutive integers n, that cover the range from `low` to `high`."""
    first_exponent, last_exponent = (
        math.floor(math.log2(low) / MAX_INTERPOLATED_LOG2_FACTOR_STEP),
        math.ceil(math.log2(high) / MAX_INTERPOLATED_LOG2_FACTOR_STEP),
    )
    powers = np.exp2(MAX_INTERPOLATED_LOG2_FACTOR_STEP * np.arange(first_exponent, last_exponent + 1)).clip(
        MIN_FACTOR, MAX_FACTOR
    )
    return np.unique([float(f"{power:.{NUM_FACTOR_DIGITS}g}") for power in powers.tolist()])


def find_missing_factors(factors: Floats, solved_factors: Floats) -> Floats:
    """Return the height factors that must be computed before friction can be interpolated at all requested factors.

    These are the requested factors that cannot be interpolated or, if they are fewer, the powers of 2 that enclose
    those factors.
    """
    missing_factors = np.array(
        [factor for factor in factors.tolist() if _find_enclosing_indices(solved_factors, factor) is None]
    )
    if not missing_factors.size:
        return missing_factors
    factor_nodes = np.setdiff1d(_find_enclosing_powers_of_two(missing_factors[0], missing_factors[-1]), solved_factors)
    return factor_nodes if factor_nodes.size < missing_factors.size else missing_factors


def _find_enclosing_indices(solved_factors: Floats, factor: float) -> tuple[int, int] | None:
    """Return the indices of the two computed height factors that enclose a requested height factor.

    Both indices are equal if the requested factor itself was computed. Returns None if no two computed factors enclose
    the requested factor, or if they differ too much for an interpolation.
    """
    upper = int(np.searchsorted(solved_factors, factor))
    if upper < solved_factors.size and solved_factors[upper] == factor:
        return upper, upper
    is_close = (
        0 < upper < solved_factors.size
        and math.log2(solved_factors[upper] / solved_factors[upper - 1]) < MAX_INTERPOLATED_LOG2_FACTOR_STEP * 1.001
    )
    return (upper - 1, upper) if is_close else None


def scale_study_heights(study: Study, factor: float, scaled: ScaledBodies) -> Study:
    """Return a copy of a study in which the heights of one or both measured bodies are multiplied by a factor.

    Raises
    ------
    ValueError
        If the study does not have two measured bodies.
    """
    if not study.is_measured or study.is_gap:
        unsupported_bodies = "the gap of one body" if study.is_measured else "generated surfaces"
        raise ArgumentError("{height_scale} needs two measured surfaces, got {kind}", kind=unsupported_bodies)
    check_choice("scaled", scaled, ScaledBodies)
    scaled_sides = SIDES if scaled == "both" else (scaled,)
    surfaces: Any = study.surfaces
    changed_surfaces = surfaces.with_changed_files(
        lambda file, side: file.with_height_factor(factor) if side in scaled_sides else file
    )
    return study.model_copy(update={"surfaces": changed_surfaces})


def find_factor_study(study: Study, path: Path, factor: float, scaled: ScaledBodies) -> CompanionStudy:
    """Return the companion study of a pair in which the heights of the chosen bodies are multiplied by `factor`."""
    return CompanionStudy(
        scale_study_heights(study, factor, scaled), path / HEIGHT_SCALE_DIRECTORY / f"{scaled}-{factor:.6g}"
    )


def open_results_by_factor(result: StoredResult, scaled: ScaledBodies) -> dict[float, MemberSums]:
    """Open all finished results of a pair with scaled heights, keyed by height factor in ascending order.

    The result of the unscaled pair is included as factor 1.
    """
    results = {1.0: MemberSums(result)}
    for directory in (result.path / HEIGHT_SCALE_DIRECTORY).glob(f"{scaled}-*"):
        try:
            factor = float(directory.name.removeprefix(f"{scaled}-"))
            factor_sums = find_factor_study(result.study, result.path, factor, scaled).open()
        except ValueError:
            # A subdirectory is skipped if its name is not a height factor.
            continue
        if factor_sums is not None:
            results[factor] = factor_sums
    return dict(sorted(results.items()))


def group_stored_factors(result: StoredResult) -> dict[ScaledBodies, list[float]]:
    """Return the height factors with stored results, keyed by the scaled bodies: both, upper or lower.

    A key is missing if the only stored factor is 1.
    """
    study = result.study
    if not study.is_measured or result.num_finished < study.ensemble.repetitions:
        return {}
    if not (result.path / HEIGHT_SCALE_DIRECTORY).is_dir():
        return {}
    factors: dict[ScaledBodies, list[float]] = {
        scaled: list(open_results_by_factor(result, scaled)) for scaled in get_args(ScaledBodies)
    }
    return {scaled: values for scaled, values in factors.items() if len(values) > 1}


def estimate_height_factor_time(study: Study, count: int) -> float:
    """Estimate the time (s) on one core to compute the results of a pair at `count` height factors."""
    return count * study.ensemble.repetitions * estimate_member_time(study)


def compute_results_at_height_factors(
    result: StoredResult, factors: Any, scaled: ScaledBodies = "both", executor: Executor | None = None, *,
    progress: bool = False, announce: Callable[[str], Any] = lambda _: None,
) -> None:  # fmt: skip
    """Compute and store results of a pair with scaled heights, for interpolation of friction at given height factors.

    Each factor is stored as a separate result, so that finished factors are kept if the run is interrupted. `announce`
    is called with a line of text before each factor. Raises the errors of `evaluate_at_height_factors` and of
    `compute_missing_blocks`.
    """
    missing_factors = find_missing_factors(
        parse_height_factors(factors), np.array(list(open_results_by_factor(result, scaled)))
    )
    with executor_or_thread_pool(executor) as pool:
        for index, factor in enumerate(missing_factors.tolist(), 1):
            announce(f"heights times {factor:g} ({index} of {missing_factors.size})")
            factor_study = find_factor_study(result.study, result.path, factor, scaled)
            factor_study.complete(pool, progress=progress)


# ---- Evaluation at a load --------------------------------------------------------------------------------------------


def evaluate_at_height_factors(
    result: StoredResult, factors: Any, loads: Any, *, mu0: Any = None, tau0: Any = None, scaled: ScaledBodies = "both"
) -> xarray.Dataset:
    """Evaluate friction, true area and stiffness of a measured pair with scaled heights.

    Parameters
    ----------
    result : StoredResult
    factors : float, array_like or str
        Factors from 0.01 to 100, in the form that `parse_height_factors` accepts; 1 is the pair as measured.
    loads : array_like of float, mN
    mu0, tau0 : array_like of float, optional
        By default the values in the study; tau0 in GPa.
    scaled : {"both", "upper", "lower"}
        Surfaces whose heights are scaled.

    Returns
    -------
    xarray.Dataset
        Variables at the quoted cutoff, with the dimension height_scale and the dimensions of `at_load`:
        mean_friction and friction_by_axis with the interval of the mean, friction_combined with the combined
        interval, true area, number of contacts, mean pressure, stiffness, and rms_gradient and rms_slope of the gap.
        upper_rms and lower_rms (µm) are the root-mean-square heights of both bodies of the first member, if their files
        exist. The attribute `solved` contains the computed factors.

    Raises
    ------
    MissingHeightFactorsError
        If a factor was not computed and is not close enough to computed factors for an interpolation.
    ValueError
        If the study does not have two measured surfaces, or is not finished, or if a factor is out of range.

    Notes
    -----
    Between computed factors, variables are interpolated by a monotone cubic in the logarithm of the factor. Positive
    variables are interpolated as logarithms. Intervals include the interpolation error, estimated as between loads.
    """
    import xarray

    factors, study = parse_height_factors(factors), result.study
    scale_study_heights(study, 1.0, scaled)
    if result.num_finished < study.ensemble.repetitions:
        raise ArgumentError("{height_scale} needs a finished result")
    results = open_results_by_factor(result, scaled)
    solved_factors = np.array(list(results))
    if (missing_factors := find_missing_factors(factors, solved_factors)).size:
        raise MissingHeightFactorsError(missing_factors, estimate_height_factor_time(study, missing_factors.size))
    enclosing_index_pairs = [
        enclosing_indices
        for factor in factors.tolist()
        if (enclosing_indices := _find_enclosing_indices(solved_factors, factor))
    ]
    points_by_factor = [
        add_uncertainty(at_load(scaled_result, loads, mu0=mu0, tau0=tau0), scaled_result, budget=False).isel(cut_off=0)
        for scaled_result in results.values()
    ]
    warn_if_given_tau0_is_large(results[1.0], tau0)
    unscaled_point = points_by_factor[list(results).index(1.0)]
    parameters = (unscaled_point["load"].values, unscaled_point["mu0"].values, unscaled_point["tau0"].values)
    used_indices = {index for pair in enclosing_index_pairs if pair[0] != pair[1] for index in pair}
    members = {
        index: evaluate_members(result_at_factor, *parameters).isel(cut_off=0)
        for index, result_at_factor in enumerate(results.values())
        if index in used_indices
    }
    if members:
        dependence = MemberDependence.from_coordinates(study, next(iter(members.values())))
    variables: dict[str, Any] = {}
    for name in (name for name in _INTERPOLATED_VARIABLES if all(name in point for point in points_by_factor)):
        values = np.stack([point[name].transpose(*unscaled_point[name].dims).values for point in points_by_factor])
        interpolated = np.stack(
            [
                _interpolate_between_factors(values, solved_factors, factor, indices)
                for factor, indices in zip(factors, enclosing_index_pairs, strict=True)
            ]
        )
        dims = unscaled_point[name].dims[:-1]
        for index, (factor, (lower, upper)) in enumerate(zip(factors.tolist(), enclosing_index_pairs, strict=True)):
            if lower == upper or "statistic" not in unscaled_point[name].dims:
                continue
            below, above = (_get_member_values(members[member_index], name, dims) for member_index in (lower, upper))
            if below is None or above is None:
                continue
            position = np.log(factor / solved_factors[lower]) / np.log(solved_factors[upper] / solved_factors[lower])
            interpolated[index] = include_interpolation_error(
                interpolated[index], (1 - position) * below + position * above, below, above, np.asarray(position),
                dependence.mean_with_interval,
            )  # fmt: skip
        # If a variable has the dimension "statistic", its last axis contains mean, lower limit and upper limit.
        if "statistic" in unscaled_point[name].dims:
            interpolated[..., 1] = np.minimum(interpolated[..., 1], interpolated[..., 0])
            interpolated[..., 2] = np.maximum(interpolated[..., 2], interpolated[..., 0])
        variables[name] = (("height_scale", *unscaled_point[name].dims), interpolated, unscaled_point[name].attrs)
    if all("contact_status" in point for point in points_by_factor):
        dims = unscaled_point["contact_status"].dims
        statuses = np.stack([point["contact_status"].transpose(*dims).values for point in points_by_factor])
        other_status = STATUS_OK if study.uses_half_space else AREA_ABOVE_NOMINAL_STATUS
        interpolated = np.stack(
            [np.where(statuses[i] == statuses[j], statuses[i], other_status) for i, j in enclosing_index_pairs]
        )
        variables["contact_status"] = (("height_scale", *dims), interpolated, unscaled_point["contact_status"].attrs)
    for side, rms in _compute_rms_heights(study).items():
        scaled_rms = rms * (factors if scaled in ("both", side) else np.ones(factors.size))
        variables[f"{side}_rms"] = ("height_scale", scaled_rms, quantity_attributes(f"{side}_rms"))
    used_dims = set(np.concatenate([np.ravel(dims) for dims, *_ in variables.values()]).tolist())
    scaled_coordinates: dict[str, Any] = {
        str(name): values for name, values in unscaled_point.coords.items() if set(values.dims) <= used_dims
    }
    scaled_coordinates["height_scale"] = ("height_scale", factors, quantity_attributes("height_scale"))
    return xarray.Dataset(
        variables, scaled_coordinates, unscaled_point.attrs | {"scaled": scaled, "solved": solved_factors}
    )


def _get_member_values(members: xarray.Dataset, name: str, dims: Sequence[Any]) -> Floats | None:
    """Return one quantity as an array whose first axis contains the members and whose next axes are `dims`.

    Returns None if the members do not have the quantity.
    """
    import xarray

    if name in ("mean_friction", "friction_combined", "friction_prediction"):
        quantity = members["friction_coefficient"].mean("direction", skipna=False)
    elif name == "friction_by_axis":
        axes, direction_pairs = find_axes_with_both_directions(members["direction"].values)
        pairs = xarray.DataArray(direction_pairs, coords={"axis": axes}, dims=("axis", "direction"))
        quantity = members["friction_coefficient"].isel(direction=pairs).mean("direction", skipna=False)
    elif name in members and set(members[name].dims) == {"repetition", *dims}:
        quantity = members[name]
    else:
        return None
    return np.asarray(quantity.transpose("repetition", *dims).values)


def _compute_rms_heights(study: Study) -> dict[str, float]:
    """Return the rms heights (µm) of upper and lower body in the first member, or {} if a scan file is missing."""
    try:
        return {side: float(np.std(body.heights)) for side, body in zip(SIDES, get_first_pair(study), strict=True)}
    except (ValueError, OSError):
        return {}


def _interpolate_between_factors(
    values: Floats, solved_factors: Floats, factor: float, neighbors: tuple[int, int]
) -> Floats:
    """Interpolate a quantity at a height factor from its values at the computed factors (first axis).

    The interpolation is a monotone cubic in log(factor), of log(values) if all values are positive. The result is NaN
    if a value at one of the two neighbouring factors is NaN.
    """
    from scipy.interpolate import PchipInterpolator

    lower, upper = neighbors
    if lower == upper:
        return np.asarray(values[lower])
    flat_values = values.reshape(solved_factors.size, -1)
    finite_mask = np.isfinite(flat_values)
    interpolated = np.full(flat_values.shape[1], np.nan)
    is_available = finite_mask[lower] & finite_mask[upper]
    log_factors = np.log(solved_factors)
    for is_finite in np.unique(finite_mask[:, is_available], axis=1).T:
        is_interpolated = is_available & (finite_mask == is_finite[:, np.newaxis]).all(axis=0)
        is_positive = is_interpolated & (flat_values[is_finite] > 0).all(axis=0)
        for is_selected, transform, inverse in (
            (is_positive, np.log, np.exp),
            (is_interpolated & ~is_positive, np.asarray, np.asarray),
        ):
            if is_selected.any():
                curve = PchipInterpolator(
                    log_factors[is_finite], transform(flat_values[np.ix_(is_finite, is_selected)])
                )
                interpolated[is_selected] = inverse(curve(math.log(factor)))
    return interpolated.reshape(values.shape[1:])
