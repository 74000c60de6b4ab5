"""Combined uncertainty of a friction coefficient, and the interval that would remain if an input were exact.

The uncertain inputs, the scatter between positions, and the unresolved roughness are propagated by sampling (JCGM 101,
2008). The forces are linear in mu0 and tau0, and the true area is interpolated as a function of the hardness. By
similarity, the solution at (F, E*, H) equals the solution at (cF, cE*, cH).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._estimate import Interval, extend_intervals
from stiction.mechanics.brackets import friction_range_for_finer_scans, max_friction_for_finer_scans
from stiction.mechanics.closed_forms import hardness_under_shear, solve_yield_condition
from stiction.mechanics.friction import LOAD_SUM_NAMES, ForcesPerLoad
from stiction.mechanics.quantities import quantity_attributes
from stiction.studies.alternatives import ALTERNATIVE_LABELS, AlternativeName
from stiction.studies.at_load import at_load
from stiction.studies.hardness import (
    AreaInterpolator,
    compute_relative_modulus,
    find_creep_exponent,
    find_junction_growth,
    find_uncertain_inputs,
    has_areas_at_nodes,
)
from stiction.studies.input_uncertainty import NUM_INPUT_SAMPLES, Z_95, UncertainInput, generate_stratified_points
from stiction.studies.interfaces import HARDNESS_HEADER_ENTRY, find_interface
from stiction.studies.intervals import MAX_DEGREES_OF_FREEDOM, ScanPairMean, average_scan_pairs
from stiction.studies.junction_growth import build_area_interpolator, compute_area_growth_ratio
from stiction.studies.member_means import NEGLIGIBLE_COEFFICIENT
from stiction.studies.member_values import interpolate_member_sums, member_values
from stiction.studies.result import Result

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

POSITIONS_INPUT_NAME, UNRESOLVED_ROUGHNESS_INPUT_NAME = "positions", "unresolved roughness"
UPPER_SCANS_INPUT_NAME, LOWER_SCANS_INPUT_NAME = "which piece of the upper part", "which piece of the lower part"
SAMPLING_INPUT_NAMES = (UPPER_SCANS_INPUT_NAME, LOWER_SCANS_INPUT_NAME, POSITIONS_INPUT_NAME)
"""Sources of uncertainty that are not inputs of the study: the choice of scans and of positions."""

INTERFACE_INPUT_NAME = "interface"  # name of the input that combines mu0 and tau0
# quantiles of an input; the uncertainty budget is computed with the input fixed at each of these quantiles
FIXED_INPUT_QUANTILES = (0.1, 0.5, 0.9)
MAX_BUDGETED_COEFFICIENTS = 100
"""Maximum number of coefficients, at the loads of the study, for which uncertainty budgets are computed."""

# mu0 or tau0 counts as equal to its value in the study up to this relative difference
SAME_INPUT_TOLERANCE = 1e-3
# upper bound on ln(coefficient of a single test / mean coefficient), which prevents overflow
MAX_LOG_COEFFICIENT_RATIO = 50.0
# a bound on the tail is estimated from a subsample that contains one in this number of samples
TAIL_SUBSAMPLING_STRIDE = 61
NORMAL_DECILE_RANGE = 2.563103131089201
"""Distance between the 10th and the 90th percentile of a normal distribution, in standard deviations."""

COVERED_NAMES = ("friction_combined", "friction_known", "friction_next_test", "friction_waited", "friction_if_known")
"""Intervals of the coefficient that cover the results for alternative preparations of the scans."""

AREA_NAMES = ("contact_area", "contact_area_fraction", "contact_area_at_onset", "mean_pressure")
"""Quantities whose intervals also cover the results for alternative preparations of the scans."""

_INTERVAL_VARIABLES = (
    "friction_all_round", "spread_low", "spread_high", "ok", "members", "contact_count", "mu0", "tau0", "sliding",
)  # fmt: skip
"""Variables that determine the interval of a coefficient."""

StrengthArrays = tuple[Floats, Floats, Floats | None, Floats | None]
"""Samples of mu0, tau0 (GPa), hardness (GPa) and α of junction growth. Each of the last two may be None."""


def add_uncertainty(
    at: xarray.Dataset, result: Result | xarray.Dataset, *, budget: bool = True, tests: bool = True
) -> xarray.Dataset:
    """Add combined intervals, predictions and the uncertainty budget to a dataset returned by `at_load`.

    `friction_known` contains the combined 95 % interval. `friction_combined` contains the interval to report: the
    combined interval or, without one, the sampling interval. If scans are evaluated at two cutoffs, the interval at the
    first cutoff covers the results at both. `friction_next_test` contains the prediction interval of a test at one
    position in one direction, and `friction_waited` the interval after each dwell time. With `budget`, which takes most
    of the time, the dataset also has the dimension `input` (inputs of `find_uncertain_inputs`, positions and unresolved
    roughness) and the variables `friction_if_known` and `width_if_known`: the interval that would remain if the input
    were exact, and its width. Without `tests`, only `friction_combined` is added. Results of generated bodies are
    returned unchanged.

    All these intervals, and the intervals of the true area, cover the results for the alternative preparations of the
    scans that are stored with the result. Each of these preparations is an `input` too.
    """
    result = Result.of(result)
    if not result.study.is_measured or at.attrs.get("reading") != "elastic":
        return at
    own = _add_own_uncertainty(at, result, budget=budget, tests=tests)
    if not result.alternatives:
        return own
    names = [name for name in (*AREA_NAMES, "contact_count") if name in at]
    loads, mu0, tau0 = (at[name].values for name in ("load", "mu0", "tau0"))
    alternatives = {
        name: add_uncertainty(at_load(other, loads, mu0=mu0, tau0=tau0, names=names), other, budget=budget, tests=tests)
        for name, other in result.alternatives.items()
    }
    return _cover_alternatives(own, alternatives)


_Tables = dict[str, tuple[tuple[str, ...], Floats]]  # dimensions and values of variables, by name


def _add_own_uncertainty(at: xarray.Dataset, result: Result, *, budget: bool, tests: bool) -> xarray.Dataset:
    """Add the variables of `add_uncertainty` without the results for alternative preparations of the scans."""
    is_study_load = np.isin(at["load"].values, [float(load) for load in result.study.friction.load])
    load_groups = _group_loads(is_study_load, result)
    num_coefficients = at["friction_all_round"].size // at.sizes["statistic"]
    is_budgeted = _find_budgeted_loads(is_study_load, num_coefficients)
    tables, coordinates = zip(
        *(
            _evaluate_uncertainty(
                at if len(load_groups) == 1 else at.isel(load=indices),
                result,
                is_budgeted=is_budgeted[indices] if budget else None,
                tests=tests,
            )
            for indices in load_groups
        ),
        strict=True,
    )
    variables = {
        name: (dims, values, quantity_attributes(name))
        for name, (dims, values) in _merge_load_groups(tables, load_groups).items()
    }
    return at.assign(variables).assign_coords(coordinates[0])


def _group_loads(is_study_load: NDArray[np.bool_], result: Result) -> list[NDArray[np.intp]]:
    """Return groups of load indices. The loads of a group are evaluated together.

    The loads of the study form a separate group if other loads would change their intervals. All loads of a group share
    the hardness nodes, from which areas are interpolated.
    """
    depends_on_other_loads = bool(result.study.contact.junction_growth) or has_areas_at_nodes(result)
    if is_study_load.all() or not is_study_load.any() or not depends_on_other_loads:
        return [np.arange(is_study_load.size)]
    return [np.flatnonzero(is_study_load), np.flatnonzero(~is_study_load)]


def _merge_load_groups(groups: Sequence[_Tables], load_indices: Sequence[NDArray[np.intp]]) -> _Tables:
    """Merge tables that were evaluated for groups of loads. The indices of these loads determine the order."""
    order = np.argsort(np.concatenate(load_indices))
    return {
        name: (
            dims,
            np.concatenate([group[name][1] for group in groups], axis=dims.index("load")).take(
                order, axis=dims.index("load")
            ),
        )
        for name, (dims, _) in groups[0].items()
    }


def _evaluate_uncertainty(
    at: xarray.Dataset, result: Result, *, is_budgeted: NDArray[np.bool_] | None, tests: bool
) -> tuple[_Tables, dict[str, Any]]:
    """Evaluate the variables of `add_uncertainty` and their coordinates for loads that are evaluated together.

    `is_budgeted` is a mask of the loads at which uncertainty budgets are computed, or None to omit the budgets.
    """
    study = result.study
    inputs, strengths = find_uncertain_inputs(study), []
    if (study_interface := find_interface(study)) is not None:
        fit, hardness = study_interface.fits[0], inputs.get("hardness")
        fit_has_same_hardness = hardness is not None and hardness.estimate.describes_same_hardness(
            study_interface.about.get(HARDNESS_HEADER_ENTRY, "")
        )
        growth = fit.junction_growth if study_interface.has_equal_junction_growth(find_junction_growth(study)) else None
        hardness_and_growth = fit.hardness if fit_has_same_hardness else None, growth
        strengths = [
            (*each, *hardness_and_growth) for each in ((fit.mu0, fit.tau0), *study_interface.samples_at_bounds)
        ]
        replaced_names = (
            "mu0",
            "tau0",
            *(("hardness",) if fit_has_same_hardness else ()),
            *(("junction_growth",) if growth is not None else ()),
        )
        inputs = {name: each for name, each in inputs.items() if name not in replaced_names}
    dims = tuple(str(dim) for dim in at["friction_all_round"].dims if dim != "statistic")
    shape = tuple(at.sizes[dim] for dim in dims)
    scan_means: dict[tuple[int, ...], ScanPairMean | None] = {}
    surfaces: Any = study.surfaces
    if math.prod(surfaces.scan_counts) > 1:  # split the variance of each coefficient by source (scans, positions)
        members = member_values(result, at["load"].values, mu0=at["mu0"].values, tau0=at["tau0"].values)
        table = members["friction_coefficient"].transpose(*dims, "repetition", "direction")
        scans = surfaces.scan_indices_of_members(table["repetition"].values)
        scan_means = {position: average_scan_pairs(table.values[position], *scans) for position in np.ndindex(*shape)}
    input_names = [
        *([INTERFACE_INPUT_NAME] if strengths else []),
        *inputs,
        *(SAMPLING_INPUT_NAMES if scan_means else (POSITIONS_INPUT_NAME,)),
        UNRESOLVED_ROUGHNESS_INPUT_NAME,
    ]
    coefficient_intervals, test_intervals = np.full((*shape, 3), np.nan), np.full((*shape, 3), np.nan)
    remaining_intervals, remaining_widths = (
        np.full((len(input_names), *shape, 3), np.nan),
        np.full((len(input_names), *shape), np.nan),
    )
    dwell_intervals, seizing_fractions = np.full((*shape, len(study.friction.wait), 3), np.nan), np.zeros(shape)
    areas = build_area_interpolator(at, result)
    interval_variables = {name: at.variables[name] for name in _INTERVAL_VARIABLES if name in at.variables}
    values_by_name = _get_arrays_over_dims(
        interval_variables | _compute_pressure_and_growth_under_shear(at, study, areas), at, dims
    )
    contact_sums = interpolate_member_sums(result, at["load"].values).mean(("repetition", "direction"))
    sums_by_name = _get_arrays_over_dims({name: contact_sums.variables[name] for name in LOAD_SUM_NAMES}, at, dims)
    pressures = at["load"].values / float(at["nominal_area"])
    # Consecutive coefficients have the same mu0 and tau0, and therefore use the same samples.
    interface_axes = [dims.index(name) for name in ("mu0", "tau0")]
    for position in sorted(np.ndindex(*shape), key=lambda position: [position[index] for index in interface_axes]):
        indices = dict(zip(dims, position, strict=True))
        numbers = {name: values[position] for name, values in values_by_name.items()}
        forces_per_load = ForcesPerLoad.from_contact_sums(
            {name: values[position] for name, values in sums_by_name.items()}
        )
        samples = _CoefficientSamples(
            numbers, indices, study, inputs, forces_per_load, areas, strengths, scan_means.get(position)
        )
        if not samples.names:
            point = numbers["friction_all_round"]
            if (np.abs(point) < NEGLIGIBLE_COEFFICIENT).all() and {"mu0", "tau0"} & samples.inputs.keys():
                coefficient_intervals[position] = point[0], *_compute_interval_of_zero_coefficient(samples, point)
            continue
        coefficient_intervals[position] = samples.value, *samples.interval()
        if not tests:
            continue
        seizing_fractions[position] = samples.seizing_fraction
        test_intervals[position] = samples.value, *samples.predict_next_test()
        for index, wait in enumerate(study.friction.wait):
            dwell_intervals[(*position, index)] = samples.friction_after_dwell(float(wait), pressures[samples.load])
        is_quoted = str(at["sliding"].values[indices["sliding"]]) == "all"
        if not is_quoted or is_budgeted is None or not is_budgeted[indices["load"]]:
            continue
        for index, name in enumerate(input_names):
            if name in samples.names:
                remaining_intervals[(index, *position)] = samples.value, *samples.interval({name: 0.5})
                remaining_widths[(index, *position)] = samples.remaining_interval_width(name)
    interval_dims = (*dims, "statistic")
    combined_intervals = _get_combined_coefficients(at, study, dims, coefficient_intervals)
    if not tests:
        return {"friction_combined": (interval_dims, combined_intervals)}, {}
    tables: _Tables = {
        "friction_combined": (interval_dims, combined_intervals),
        "friction_known": (interval_dims, coefficient_intervals),
        "friction_next_test": (interval_dims, test_intervals),
    }
    if is_budgeted is not None:
        tables |= {
            "friction_if_known": (("input", *interval_dims), remaining_intervals),
            "width_if_known": (("input", *dims), remaining_widths),
        }
    if find_junction_growth(study) is not None:
        tables["fraction_seizing"] = dims, seizing_fractions
    labels = [
        inputs[name].label if name in inputs else {INTERFACE_INPUT_NAME: "the interface"}.get(name, name)
        for name in input_names
    ]
    coordinates = {}
    if is_budgeted is not None:
        coordinates = {"input": ("input", input_names), "input_words": ("input", labels)}
    if study.friction.wait:
        tables["friction_waited"] = (*dims, "wait", "statistic"), dwell_intervals
        coordinates["wait"] = ("wait", np.array(study.friction.wait, float), {"units": "s"})  # type: ignore[assignment]
    return tables, coordinates


def _find_budgeted_loads(is_study_load: NDArray[np.bool_], num_coefficients: int) -> NDArray[np.bool_]:
    """Return a mask of the loads at which uncertainty budgets are computed.

    The limit applies to the coefficients at all loads of the study together, and to each other load on its own.
    Therefore, the budget at a load does not depend on other loads that are evaluated in addition.
    """
    num_coefficients_per_load = num_coefficients // is_study_load.size
    num_counted_loads = np.where(is_study_load, np.count_nonzero(is_study_load), 1)
    return np.asarray(num_counted_loads * num_coefficients_per_load <= MAX_BUDGETED_COEFFICIENTS)


def _cover_alternatives(own: xarray.Dataset, alternatives: Mapping[AlternativeName, xarray.Dataset]) -> xarray.Dataset:
    """Extend intervals to cover the intervals for alternative preparations of the scans.

    The names of the alternatives become the attribute `alternatives`. An uncertainty budget gets a row for each
    alternative, which contains the interval without this alternative. The other rows are extended by the same rows of
    the alternatives.
    """
    variables = {}
    for name in (each for each in (*COVERED_NAMES, *AREA_NAMES) if each in own):
        dims = own[name].dims
        others = [other[name].transpose(*dims).values for other in alternatives.values()]
        variables[name] = (dims, _extend_estimates(own[name].values, others), own[name].attrs)
    covered = own.assign(variables).assign_attrs(alternatives=list(alternatives))
    if "friction_if_known" not in own:
        return covered
    dims = own["friction_if_known"].dims[1:]
    is_budgeted = ~np.isnan(own["width_if_known"].transpose("input", *dims[:-1]).values).all(axis=0)
    intervals = {name: each["friction_known"].transpose(*dims).values for name, each in alternatives.items()}
    own_intervals = own["friction_known"].transpose(*dims).values
    rows = np.stack(
        [
            np.where(
                is_budgeted[..., np.newaxis],
                _extend_estimates(own_intervals, [each for other, each in intervals.items() if other != name]),
                np.nan,
            )
            for name in alternatives
        ]
    )
    labels = [ALTERNATIVE_LABELS[name] for name in alternatives]
    other_inputs = covered.drop_vars(["friction_if_known", "width_if_known", "input", "input_words"])
    remaining = np.concatenate([covered["friction_if_known"].transpose("input", *dims).values, rows])
    return other_inputs.assign(
        friction_if_known=(("input", *dims), remaining, own["friction_if_known"].attrs),
        width_if_known=(("input", *dims[:-1]), remaining[..., 2] - remaining[..., 1], own["width_if_known"].attrs),
    ).assign_coords(
        input=("input", [*own["input"].values.tolist(), *alternatives]),
        input_words=("input", [*own["input_words"].values.tolist(), *labels]),
    )


def _extend_estimates(own: Floats, others: Iterable[Floats]) -> Floats:
    """Extend the intervals of estimates to include the intervals of other estimates.

    The last axis of each array contains value, lower limit and upper limit.
    """
    limits = extend_intervals(own[..., 1:], *(each[..., 1:] for each in others))
    return np.concatenate([own[..., :1], limits], axis=-1)


def _compute_pressure_and_growth_under_shear(
    at: xarray.Dataset, study: Study, areas: AreaInterpolator
) -> dict[str, xarray.Variable]:
    """Return the pressure H' (GPa) under shear and the junction-growth ratio for each combination of mu0 and tau0.

    Both are computed at the hardness in the study. The result is empty if the study has no hardness. Without junction
    growth, H' equals the hardness.
    """
    import xarray

    if (hardness := areas.hardness) is None:
        return {}
    mu0, tau0 = at["mu0"].values, at["tau0"].values
    pressure = np.full((mu0.size, tau0.size), hardness)
    growth_ratios = np.ones((at.sizes["sliding"], at.sizes["load"], *pressure.shape))
    if (growth := find_junction_growth(study)) is not None:
        pressure = hardness_under_shear(hardness, mu0[:, np.newaxis], tau0, growth.value)
        rules = at["sliding"].values.tolist()
        growth_ratios = np.stack([compute_area_growth_ratio(areas, study, rule, mu0, tau0) for rule in rules])
        growth_ratios[..., tau0 == 0] = 1.0
    dims = ("mu0", "tau0")
    return {
        "sheared_pressure": xarray.Variable(dims, pressure),
        "area_growth": xarray.Variable(("sliding", "load", *dims), growth_ratios),
    }


def _get_arrays_over_dims(
    variables: Mapping[str, Any], at: xarray.Dataset, dims: Sequence[str]
) -> dict[str, NDArray[Any]]:
    """Return variables of a dataset as arrays whose first array axes are the given dimensions.

    Variables that lack a dimension are constant along it. The arrays are much faster to index than variables.
    """
    sizes = {dim: at.sizes[dim] for dim in dims}
    return {
        name: variable.set_dims(sizes | dict(variable.sizes)).transpose(*dims, ...).values
        for name, variable in variables.items()
    }


def _compute_interval_of_zero_coefficient(samples: _CoefficientSamples, point: Floats) -> tuple[float, float]:
    """Return the 95 % interval of a coefficient that is 0, for which relative errors are undefined.

    The interval contains the coefficient and its sampling interval, and is not below 0.
    """
    unit_points = generate_stratified_points(2)
    mu0, tau0 = (
        samples.inputs[name].quantile(unit_points[:, column]) if name in samples.inputs else value
        for column, (name, value) in enumerate((("mu0", samples.mu0), ("tau0", samples.tau0)))
    )
    coefficients = np.broadcast_to(samples.friction.compute_coefficient(mu0, tau0), (NUM_INPUT_SAMPLES,))
    value, lower, upper = point.tolist()
    low, high = _compute_equal_tailed_interval(coefficients).extended_to((value, value), (lower, upper))
    return max(low, 0.0), high


def _get_combined_coefficients(
    at: xarray.Dataset, study: Study, dims: Sequence[str], known_intervals: Floats
) -> Floats:
    """Return the reported coefficients and their interval limits as an array of shape (*dims, statistic)."""
    combined = at["friction_all_round"].transpose(*dims, "statistic").values.copy()
    lower_limits = combined[..., 1]
    combined[..., 1] = np.where((lower_limits < 0) & (combined[..., 0] >= 0), 0.0, lower_limits)
    # an interval counts as known even if its upper limit is infinite
    is_known = ~np.isnan(known_intervals).any(axis=-1)
    combined[is_known] = known_intervals[is_known]
    # the interval of the first cutoff covers the intervals of all cutoffs
    if study.surfaces.both_readings and "cut_off" in dims:
        by_cutoff = np.moveaxis(combined, dims.index("cut_off"), 0)
        by_cutoff[0] = _extend_estimates(by_cutoff[0], by_cutoff[1:])
    return combined


class _CoefficientSamples:
    """Friction coefficient returned by `at_load`, and the input samples from which its interval is computed.

    `names` lists the uncertain inputs and sources of sampling uncertainty; it is empty if there is no coefficient or no
    interval.
    """

    def __init__(
        self, point: Any, indices: Mapping[str, int], study: Study, inputs: Any, friction: ForcesPerLoad,
        areas: AreaInterpolator, strengths: Sequence[StrengthArrays] = (), scan_mean: ScanPairMean | None = None,
    ) -> None:  # fmt: skip
        self.study, self.friction, self.areas, self.load = study, friction, areas, indices.get("load", 0)
        self.mu0, self.tau0 = float(point["mu0"]), float(point["tau0"])
        self.names: tuple[str, ...] = ()
        self.inputs: dict[str, UncertainInput] = {name: each.estimate for name, each in inputs.items()}
        # The range of mu0 or tau0 in the study does not apply to other values of mu0 or tau0.
        for name, study_value in (("mu0", self.mu0), ("tau0", self.tau0)):
            interface_value = float(getattr(study.friction, name)[0]) if study.known.interface else None
            central_value = (
                self.inputs[name].value if name in self.inputs and interface_value is None else interface_value
            )
            if central_value is not None and abs(central_value - study_value) > SAME_INPUT_TOLERANCE * study_value:
                self.inputs.pop(name, None)
                strengths = ()
        value, lower, upper = point["friction_all_round"].tolist()
        if study.is_gap:  # a gap has only one relative position
            lower = upper = value
        if not (value > 0 and math.isfinite(lower) and math.isfinite(upper)):
            return
        self.value, self.sampling = value, (lower, upper)
        # range of coefficients that finer scans could give, widened by the confidence interval due to sampling
        self.bracket: tuple[float, float] | None = None
        # The first entry contains joint samples of mu0 and tau0.
        # In each of the other entries, mu0 or tau0 equals its bound.
        self.strengths = strengths
        self.rule = str(point["sliding"])
        self.growth = find_junction_growth(study)  # estimate of the junction-growth coefficient α
        # ratio of true areas with and without junction growth
        self.own_growth = float(point.get("area_growth", 1.0))
        hardness = study.contact.hardness
        self.finest: tuple[float, float] | None = None  # range of coefficients that finer scans could give
        is_nonadhesive_half_space = study.uses_half_space and not study.contact.adheres
        if hardness is not None and is_nonadhesive_half_space and self.rule == "all":
            self.contacts = float(point["contact_count"][0]) * float(point["members"])
            bracket_inputs = self.mu0, self.tau0 / float(point["sheared_pressure"]), self.contacts
            self.finest = friction_range_for_finer_scans(value, *bracket_inputs)
            self.bracket = friction_range_for_finer_scans(value, *bracket_inputs, upper)
        relative_width = math.log(upper / lower) if lower > 0 else (upper - lower) / value
        relative_error, members = relative_width / (2 * Z_95), int(point["ok"].min())
        spread = 0.0 if study.is_gap else float(point["spread_high"]) - float(point["spread_low"])
        # relative standard deviation of single members in a single direction from the mean over members
        self.scatter = spread / (NORMAL_DECILE_RANGE * value) * math.sqrt(1 + 1 / max(members, 1))
        self.freedom = float(max(members - 1, 1))
        relative_errors = {
            POSITIONS_INPUT_NAME: relative_error
        }  # relative standard error of the mean due to each source
        if scan_mean is not None:
            total_deviation = math.sqrt(sum(scan_mean.variances)) or 1.0
            relative_errors = {
                n: relative_error * math.sqrt(each) / total_deviation
                for n, each in zip(SAMPLING_INPUT_NAMES, scan_mean.variances, strict=True)
            }
            self.scatter, self.freedom = scan_mean.test / value, min(scan_mean.test_freedom, MAX_DEGREES_OF_FREEDOM)
        self.standard_errors = {name: each for name, each in relative_errors.items() if each > 0}
        unresolved_inputs = (
            (UNRESOLVED_ROUGHNESS_INPUT_NAME,) if self.finest is not None and self.finest[1] > self.finest[0] else ()
        )
        self.names = (
            *self.inputs,
            *((INTERFACE_INPUT_NAME,) if strengths else ()),
            *self.standard_errors,
            *unresolved_inputs,
        )

    def interval(self, fixed: Mapping[str, float] | None = None) -> Interval:
        """Return the 95 % interval of the coefficient with some inputs fixed at the given quantiles.

        The interval contains the value. It also contains the sampling interval and the range of coefficients for finer
        scans, unless these sources are fixed.
        """
        fixed = fixed or {}
        included_intervals = [(self.value, self.value)]
        if not set(fixed) & set(SAMPLING_INPUT_NAMES):
            included_intervals.append(self.sampling)
        if UNRESOLVED_ROUGHNESS_INPUT_NAME not in fixed and self.finest is not None and self.bracket is not None:
            included_intervals.append(self.finest if set(fixed) & set(SAMPLING_INPUT_NAMES) else self.bracket)
        return self._compute_sampled_interval(fixed).extended_to(*included_intervals)

    def remaining_interval_width(self, name: str) -> float:
        """Return the mean width of the interval that would remain if the named input were known exactly.

        Widths are compared as differences of the friction angle, which stays finite if samples seize.
        """
        friction_angle_widths = [
            _compute_friction_angle_difference(self._compute_sampled_interval({name: quantile}))
            for quantile in FIXED_INPUT_QUANTILES
        ]
        (low, high), sampled_width = (
            self.interval(),
            _compute_friction_angle_difference(self._compute_sampled_interval({})),
        )
        return (
            min(float(np.mean(friction_angle_widths)) / sampled_width, 1.0) * (high - low)
            if sampled_width > 0
            else high - low
        )

    def _compute_sampled_interval(self, fixed: Mapping[str, float]) -> Interval:
        if self.names == tuple(self.standard_errors) and not fixed:
            return Interval(max(self.sampling[0], 0.0), self.sampling[1])
        from scipy.special import ndtri

        # A fixed source of sampling uncertainty multiplies all samples by the same factor, which is 1 at its median.
        fixed_at_medians = {name: 0.5 if name in self.standard_errors else fixed[name] for name in fixed}
        factor = math.exp(
            sum(self.standard_errors[name] * ndtri(fixed[name]) for name in fixed if name in self.standard_errors)
        )
        low, high = self.areas.get_or_compute(
            ("interval", tuple(fixed_at_medians.items())),
            (self,),
            lambda: self._compute_scaled_interval(fixed_at_medians),
        )
        return Interval(low * factor, high * factor)

    def _compute_scaled_interval(
        self, fixed: Mapping[str, float], wait: float = 1.0, factor: Floats | float = 1.0
    ) -> Interval:
        """Multiply the coefficient samples by a factor, and return the limits of their 95 % interval.

        The interval is extended to include the samples with mu0 or tau0 at its bound.
        """
        num_strengths = 1 if INTERFACE_INPUT_NAME in fixed else max(len(self.strengths), 1)
        first, *others = (
            _compute_equal_tailed_interval(self._compute_friction_samples(fixed, wait, index) * factor)
            for index in range(num_strengths)
        )
        return first.extended_to(*others)

    @property
    def seizing_fraction(self) -> float:
        """Fraction of input samples for which the contacts seize."""
        if self.growth is None:
            return 0.0
        return float(np.isinf(self._compute_friction_samples({})).mean())

    def _compute_pressure_under_shear(self, hardness: Any, mu0: Any, tau0: Any, alpha: Any = None) -> Any:
        """Return the contact pressure H' (GPa) under shear, or NaN at seizure.

        By default, `alpha` is the central value in the study.
        """
        if self.growth is None:
            return hardness
        pressure = solve_yield_condition(hardness, mu0, tau0, self.growth.value if alpha is None else alpha)
        return float(pressure) if pressure.ndim == 0 else pressure

    def _compute_area_growth_under_shear(self, hardness: Floats, tau0: Any, pressure: Any, modulus: Any = 1.0) -> Any:
        """Return the ratio of the true area at the onset of sliding to the true area before shear.

        The ratio is infinite at seizure. It is 1 for tau0 = 0, because friction then does not depend on the area.
        `pressure` is the value of `_compute_pressure_under_shear` (GPa).
        """
        if self.growth is None or (np.ndim(tau0) == 0 and tau0 == 0):
            return 1.0
        return self.areas.growth_ratio(self.load, self.rule, hardness, pressure, modulus)

    def predict_next_test(self) -> Interval:
        """Return the 95 % prediction interval for a test of one new member in one direction of motion.

        Student's t distribution applies to the logarithm of the coefficient, so that the interval is above 0.
        """
        from scipy.special import stdtrit

        scores = self.areas.get_or_compute(
            ("t", len(self.names), self.freedom),
            (),
            lambda: stdtrit(self.freedom, generate_stratified_points(len(self.names) + 1)[:, -1]),
        )
        scatter = math.sqrt(math.log1p(self.scatter**2))
        factor = np.exp(np.minimum(scores * scatter, MAX_LOG_COEFFICIENT_RATIO))
        interval = self._compute_scaled_interval(dict.fromkeys(self.standard_errors, 0.5), factor=factor)
        return interval.extended_to((self.value, self.value))

    def friction_after_dwell(self, wait: float, pressure: float) -> tuple[float, float, float]:
        """Return the friction coefficient after a dwell time (s), together with the limits of its 95 % interval.

        They are NaN if the nominal pressure reaches the hardness.
        """
        creep, hardness = find_creep_exponent(self.study), self.areas.hardness
        assert creep is not None, "a study with dwell times has a creep exponent"
        assert hardness is not None, "a study with dwell times has a hardness"
        final_hardness = hardness * wait**-creep.value
        if pressure >= final_hardness:
            return math.nan, math.nan, math.nan
        final_and_initial_hardness = np.array([final_hardness]), np.array([hardness])
        area, initial_growth = (
            self._compute_area_growth_under_shear(
                each_hardness, self.tau0, self._compute_pressure_under_shear(each_hardness, self.mu0, self.tau0)
            )
            for each_hardness in final_and_initial_hardness
        )
        if not np.isfinite(area).all():
            return math.nan, math.nan, math.nan
        area = self.areas.area_ratio(self.load, final_and_initial_hardness[0], 1.0) * area
        initial_coefficient = self.friction.compute_coefficient(self.mu0, self.tau0, initial_growth)
        coefficient = self.friction.compute_coefficient(self.mu0, self.tau0, area)
        value = float((self.value * coefficient / initial_coefficient)[0])
        return value, *self._compute_scaled_interval({}, wait).extended_to((value, value))

    def _compute_friction_samples(
        self, fixed: Mapping[str, float], wait: float = 1.0, strength_index: int = 0
    ) -> Floats:
        """Return samples of the coefficient. Sources of sampling uncertainty can be fixed only at their medians.

        `strength_index` selects an entry of `strengths`, if there are any.
        """
        other_names = {*self.standard_errors, UNRESOLVED_ROUGHNESS_INPUT_NAME}
        fixed_inputs = {name: quantile for name, quantile in fixed.items() if name not in other_names}
        coefficients, range_widths, seizing_mask = self.areas.get_or_compute(
            ("coefficients", tuple(fixed_inputs.items()), wait, strength_index),
            (self,),
            lambda: self._compute_coefficients_of_inputs(fixed_inputs, wait, strength_index),
        )
        probabilities, scores, *_ = self._draw_input_samples({}, wait)
        if range_widths is not None:
            fractions = fixed.get(UNRESOLVED_ROUGHNESS_INPUT_NAME, probabilities[UNRESOLVED_ROUGHNESS_INPUT_NAME])
            coefficients = coefficients + fractions * range_widths
        if unfixed_errors := {name: error for name, error in self.standard_errors.items() if name not in fixed}:
            coefficients = coefficients * self.areas.get_or_compute(
                ("sampling factors", tuple(unfixed_errors), wait),
                (self,),
                lambda: np.exp(sum(error * scores[name] for name, error in unfixed_errors.items())),
            )
        coefficients = np.maximum(coefficients, 0.0)
        coefficients = np.where(seizing_mask, np.inf, coefficients) if seizing_mask is not None else coefficients
        return np.broadcast_to(coefficients, (NUM_INPUT_SAMPLES,))

    def _compute_coefficients_of_inputs(
        self, fixed: Mapping[str, float], wait: float, strength_index: int
    ) -> tuple[Floats, Floats | None, NDArray[np.bool_] | None]:
        """Return samples of the coefficient without sampling uncertainty, and a mask of the samples that seize.

        If shorter wavelengths may change the coefficient, the first array contains the lowest coefficients for finer
        scans, and the second array the widths of their ranges. The mask is None if no sample seizes.
        """
        probabilities, _, samples, hardness, modulus = self._draw_input_samples(fixed, wait)
        strength = self.strengths[strength_index] if self.strengths else None
        area = self._compute_area_ratio_samples(fixed, wait)
        mu0, tau0 = samples.get("mu0", self.mu0), samples.get("tau0", self.tau0)
        growth_samples = None
        # The interface samples are sorted by coefficient, so their quantiles are also quantiles of the coefficient.
        if strength is not None:
            hardness_samples, growth_samples = strength[2:]
            interface_areas = (
                1.0 if hardness_samples is None else self.areas.area_ratio(self.load, hardness_samples, 1.0)
            )
            interface_hardness = (
                np.full(strength[0].shape, self.areas.hardness or np.nan)
                if hardness_samples is None
                else hardness_samples
            )
            pressure = self._compute_pressure_under_shear(interface_hardness, *strength[:2], growth_samples)
            interface_areas = interface_areas * self._compute_area_growth_under_shear(
                interface_hardness, strength[1], pressure
            )
            with np.errstate(invalid="ignore"):
                order = np.argsort(self.friction.compute_coefficient(*strength[:2], interface_areas))
            indices = order[(probabilities[INTERFACE_INPUT_NAME] * order.size).astype(int)]
            mu0, tau0 = strength[0][indices], strength[1][indices]
            growth_samples = None if growth_samples is None else growth_samples[indices]
            if hardness_samples is not None:
                hardness = hardness_samples[indices] * hardness / float(self.areas.hardness or 1.0)
                area = self.areas.area_ratio(self.load, hardness, modulus)
        if self.growth is not None:
            if strength is None:
                pressure = self._compute_pressure_samples(fixed, wait)
            else:
                alpha = samples.get("junction_growth", self.growth.value) if growth_samples is None else growth_samples
                pressure = self._compute_pressure_under_shear(hardness, mu0, tau0, alpha)
            area = area * self._compute_area_growth_under_shear(hardness, tau0, pressure, modulus)
            hardness = pressure
        central_coefficient = self.friction.compute_coefficient(self.mu0, self.tau0, self.own_growth)
        # If no input is uncertain, these arrays contain a single number.
        with np.errstate(invalid="ignore"):
            coefficients = self.value * self.friction.compute_coefficient(mu0, tau0, area) / central_coefficient
        seizing_mask = np.isinf(area)
        if is_seizing := bool(seizing_mask.any()):
            coefficients, hardness = np.where(seizing_mask, 1.0, coefficients), np.where(seizing_mask, np.inf, hardness)
        range_widths = None
        if UNRESOLVED_ROUGHNESS_INPUT_NAME in probabilities and self.finest is not None:
            lowest_coefficients = np.minimum(mu0 + tau0 / hardness, coefficients)
            highest_coefficients = np.maximum(
                max_friction_for_finer_scans(coefficients, mu0, tau0 / hardness, self.contacts), lowest_coefficients
            )
            coefficients, range_widths = lowest_coefficients, highest_coefficients - lowest_coefficients
        return coefficients, range_widths, seizing_mask if is_seizing else None

    def _draw_input_samples(
        self, fixed: Mapping[str, float], wait: float
    ) -> tuple[dict[str, Floats], dict[str, Floats], dict[str, Floats], Floats, Floats | float]:
        """Draw samples of the inputs. Return uniform values, normal scores, input values, hardnesses and E* ratios.

        An exact hardness is an array of a single number, unless contacts grow under shear or creep. The samples are
        cached, because they depend neither on the load nor on exact values of mu0 and tau0.
        """
        from scipy.special import ndtri

        def draw_uncached_samples() -> Any:
            unit_points = generate_stratified_points(len(self.names) + 1)
            probabilities = dict(zip(self.names, unit_points.T, strict=False))
            probabilities |= {
                name: np.full(NUM_INPUT_SAMPLES, quantile) for name, quantile in fixed.items() if name in probabilities
            }
            samples = {name: self.inputs[name].quantile(probabilities[name]) for name in self.inputs}
            # With junction growth, each sample needs its own hardness.
            num_exact = 1 if self.growth is None else NUM_INPUT_SAMPLES
            hardness = samples.get("hardness", np.full(num_exact, self.areas.hardness or np.nan))
            if (creep := find_creep_exponent(self.study)) is not None:
                hardness = hardness * wait ** -creep.quantile(unit_points[:, -1])
            scores = {name: ndtri(probabilities[name]) for name in self.standard_errors}
            return probabilities, scores, samples, hardness, compute_relative_modulus(self.study, samples)

        return self.areas.get_or_compute(("inputs", self.names, tuple(fixed.items()), wait), (), draw_uncached_samples)  # type: ignore[no-any-return]

    def _compute_area_ratio_samples(self, fixed: Mapping[str, float], wait: float) -> Floats:
        """Return samples of the true area before shear, divided by the true area for the central inputs.

        The samples are cached for each load.
        """

        def compute_uncached_samples() -> Floats:
            *_, hardness, modulus = self._draw_input_samples(fixed, wait)
            return self.areas.area_ratio(self.load, None if self.areas.hardness is None else hardness, modulus)

        return self.areas.get_or_compute(
            ("area ratio", self.names, tuple(fixed.items()), wait, self.load), (), compute_uncached_samples
        )

    def _compute_pressure_samples(self, fixed: Mapping[str, float], wait: float) -> Floats:
        """Return samples of the contact pressure H' (GPa) under shear, which are cached for reuse at other loads."""
        assert self.growth is not None, "contacts grow under shear"
        _, _, samples, hardness, _ = self._draw_input_samples(fixed, wait)
        central_values = {"mu0": self.mu0, "tau0": self.tau0, "junction_growth": self.growth.value}
        inputs = [samples.get(name, value) for name, value in central_values.items()]
        return self.areas.get_or_compute(
            "pressure", (hardness, *inputs), lambda: self._compute_pressure_under_shear(hardness, *inputs)
        )


def _compute_friction_angle_difference(ends: tuple[float, float]) -> float:
    """Return the difference (rad) between the friction angles that correspond to the limits of an interval."""
    return math.atan(ends[1]) - math.atan(ends[0])


def _compute_equal_tailed_interval(values: NDArray[Any]) -> Interval:
    """Return the limits of the equal-tailed interval that contains 95 % of the samples.

    The upper limit is infinite if more than 2.5 % of the samples are infinite.

    Raises
    ------
    ValueError
        If a sample has no coefficient.
    """
    if np.isnan(values).any():
        num_undefined = int(np.count_nonzero(np.isnan(values)))
        raise ValueError(
            f"the inputs are too uncertain, because {num_undefined} of {values.size} samples have no coefficient; "
            "specify narrower ranges"
        )
    probabilities = np.array([0.025, 0.975])
    if np.isinf(values).any():  # quantiles are not interpolated if samples are infinite
        low_rank, high_rank = np.maximum(np.ceil(probabilities * values.size).astype(int) - 1, 0).tolist()
        return Interval(
            float(_select_smallest_values(values, low_rank + 1)[-1]),
            float(-_select_smallest_values(-values, values.size - high_rank)[-1]),
        )
    positions = probabilities * (values.size - 1)
    low_rank, high_rank = np.minimum(positions.astype(int), values.size - 2).tolist()
    low, above_low = _select_smallest_values(values, low_rank + 2)[-2:]
    above_high, high = -_select_smallest_values(-values, values.size - high_rank)[-2:]
    low_fraction, high_fraction = positions - [low_rank, high_rank]
    return Interval(float(low + low_fraction * (above_low - low)), float(high + high_fraction * (above_high - high)))


def _select_smallest_values(values: Floats, count: int) -> Floats:
    """Return the smallest `count` values, of which only the last two are sorted.

    For small fractions of many values, this takes a quarter of the time of partitioning all values.
    """
    subsample = values[::TAIL_SUBSAMPLING_STRIDE]
    bound_rank = 3 * count // (2 * TAIL_SUBSAMPLING_STRIDE) + 1
    bound = np.partition(subsample, bound_rank)[bound_rank] if bound_rank < subsample.size else np.inf
    smallest = values[values <= bound]
    if smallest.size < count:  # The subsample is not representative.
        smallest = values.copy()
    smallest.partition([max(count - 2, 0), count - 1])
    return np.asarray(smallest[:count])
