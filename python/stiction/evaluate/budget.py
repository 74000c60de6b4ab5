"""Combined uncertainty of friction coefficients, and the interval that would remain if an input were exact."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._estimate import extend_intervals
from stiction.evaluate.at_load import at_load
from stiction.evaluate.coefficient_samples import (
    INTERFACE_INPUT_NAME,
    LOWER_SCANS_INPUT_NAME,
    POSITIONS_INPUT_NAME,
    SAMPLING_INPUT_NAMES,
    UNRESOLVED_ROUGHNESS_INPUT_NAME,
    UPPER_SCANS_INPUT_NAME,
    CoefficientSamples,
    StrengthArrays,
)
from stiction.evaluate.hardness_nodes import AreaInterpolator, has_areas_at_nodes
from stiction.evaluate.intervals import ScanPairMean, average_scan_pairs
from stiction.evaluate.junction_growth import build_area_interpolator, compute_area_growth_ratio
from stiction.evaluate.member_values import compute_mean_areas, interpolate_member_sums, member_values
from stiction.mechanics.closed_forms import hardness_under_shear
from stiction.mechanics.friction import LOAD_SUM_NAMES, ForcesPerLoad
from stiction.mechanics.quantities import quantity_attributes
from stiction.solve.alternative_preparations import ALTERNATIVE_LABELS, AlternativeName, load_stored_alternatives
from stiction.solve.member_sums import MemberSums
from stiction.study.inputs import find_interface
from stiction.study.interfaces import HARDNESS_HEADER_ENTRY
from stiction.study.uncertain_inputs import find_junction_growth, find_uncertain_inputs
from stiction.surfaces.pairing import SIDES

if TYPE_CHECKING:
    import xarray

    from stiction.study.study import Study

MAX_BUDGETED_COEFFICIENTS = 100
"""Maximum number of coefficients, at the loads of the study, for which uncertainty budgets are computed."""

COVERED_NAMES = (
    "friction_combined",
    "friction_at_cutoff",
    "friction_prediction",
    "friction_after_dwell",
    "remaining_interval",
)
"""Intervals of the coefficient that cover the results for alternative preparations of the scans."""

AREA_NAMES = ("contact_area", "contact_area_fraction", "contact_area_at_onset", "mean_pressure")
"""Quantities whose intervals also cover the results for alternative preparations of the scans."""

_INTERVAL_VARIABLES = (
    "mean_friction", "spread_low", "spread_high", "ok", "members", "contact_count", "mu0", "tau0", "sliding",
)  # fmt: skip
"""Variables that determine the interval of a coefficient."""


def add_uncertainty(
    at: xarray.Dataset, result: MemberSums | xarray.Dataset, *, budget: bool = True, tests: bool = True
) -> xarray.Dataset:
    """Add combined intervals, predictions and the uncertainty budget to a dataset returned by `at_load`.

    `friction_at_cutoff` contains the combined 95 % interval at each cutoff, or NaN without one. `friction_combined`
    contains the interval to report: this interval or, without one, the interval of the mean. If scans are evaluated at
    two cutoffs, the reported interval at the first cutoff covers the results at both. `friction_prediction` contains
    the prediction interval of a test at one position in one direction, and `friction_after_dwell` the interval after
    each dwell time. With `budget`, which takes most of the time, the dataset also has the dimension `input` (inputs of
    `find_uncertain_inputs`, positions and unresolved roughness) and the variables `remaining_interval` and
    `remaining_width`: the interval that would remain if the input were exact, and its width. Without `tests`, only
    `friction_combined` is added. Results of generated bodies are returned unchanged.

    All these intervals, and the intervals of the true area, cover the results for the alternative preparations of the
    scans that are stored with the result. Each of these preparations is an `input` too.
    """
    result = MemberSums.of(result)
    if not result.study.is_measured or at.attrs.get("load_definition") != "elastic":
        return at
    own = _add_own_uncertainty(at, result, budget=budget, tests=tests)
    stored_alternatives = load_stored_alternatives(result)
    if not stored_alternatives:
        return own
    names = [name for name in (*AREA_NAMES, "contact_count") if name in at]
    loads, mu0, tau0 = (at[name].values for name in ("load", "mu0", "tau0"))
    alternatives = {
        name: add_uncertainty(at_load(other, loads, mu0=mu0, tau0=tau0, names=names), other, budget=budget, tests=tests)
        for name, other in stored_alternatives.items()
    }
    return _cover_alternatives(own, alternatives)


_Tables = dict[str, tuple[tuple[str, ...], Floats]]  # dimensions and values of variables, by name


def _add_own_uncertainty(at: xarray.Dataset, result: MemberSums, *, budget: bool, tests: bool) -> xarray.Dataset:
    """Add the variables of `add_uncertainty` without the results for alternative preparations of the scans."""
    is_study_load = np.isin(at["load"].values, [float(load) for load in result.study.friction.load])
    load_groups = _group_loads(is_study_load, result)
    num_coefficients = at["mean_friction"].size // at.sizes["statistic"]
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


def _group_loads(is_study_load: NDArray[np.bool_], result: MemberSums) -> list[NDArray[np.intp]]:
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
    at: xarray.Dataset, result: MemberSums, *, is_budgeted: NDArray[np.bool_] | None, tests: bool
) -> tuple[_Tables, dict[str, Any]]:
    """Evaluate the variables of `add_uncertainty` and their coordinates for loads that are evaluated together.

    `is_budgeted` is a mask of the loads at which uncertainty budgets are computed, or None to omit the budgets.
    """
    study = result.study
    dims = tuple(str(dim) for dim in at["mean_friction"].dims if dim != "statistic")
    shape = tuple(at.sizes[dim] for dim in dims)
    inputs, strengths = _find_inputs_and_strengths(study)
    scan_means = _average_pairs_of_scans(result, at, dims)
    drifts = find_slope_drifts(at.attrs)
    input_names = [
        *([INTERFACE_INPUT_NAME] if strengths else []),
        *inputs,
        *(name for name in SAMPLING_INPUT_NAMES if scan_means or name in drifts or name == POSITIONS_INPUT_NAME),
        UNRESOLVED_ROUGHNESS_INPUT_NAME,
    ]
    coefficient_intervals, test_intervals = np.full((*shape, 3), np.nan), np.full((*shape, 3), np.nan)
    remaining_intervals, remaining_widths = (
        np.full((len(input_names), *shape, 3), np.nan),
        np.full((len(input_names), *shape), np.nan),
    )
    dwell_intervals, seizing_fractions = np.full((*shape, len(study.friction.wait), 3), np.nan), np.zeros(shape)
    pressures = at["load"].values / float(at["nominal_area"])
    for position, samples in _iterate_samples(result, at, dims, inputs, strengths, scan_means, drifts):
        if not samples.names:
            coefficient_intervals[position] = samples.estimate_zero_coefficient()
            continue
        coefficient_intervals[position] = samples.value, *samples.interval()
        if not tests:
            continue
        seizing_fractions[position] = samples.seizing_fraction
        test_intervals[position] = samples.value, *samples.predict_next_test()
        for index, wait in enumerate(study.friction.wait):
            dwell_intervals[(*position, index)] = samples.friction_after_dwell(float(wait), pressures[samples.load])
        if samples.rule != "all" or is_budgeted is None or not is_budgeted[samples.load]:
            continue
        for index, name in enumerate(input_names):
            if name in samples.names:
                remaining_intervals[(index, *position)] = samples.value, *samples.interval({name: 0.5})
                remaining_widths[(index, *position)] = samples.remaining_interval_width(name)
    interval_dims = (*dims, "statistic")
    tables: _Tables = {
        "friction_combined": (interval_dims, _get_combined_coefficients(at, study, dims, coefficient_intervals))
    }
    if not tests:
        return tables, {}
    coordinates: dict[str, Any] = {}
    tables |= {
        "friction_at_cutoff": (interval_dims, coefficient_intervals),
        "friction_prediction": (interval_dims, test_intervals),
    }
    if is_budgeted is not None:
        tables |= {
            "remaining_interval": (("input", *interval_dims), remaining_intervals),
            "remaining_width": (("input", *dims), remaining_widths),
        }
        labels = [
            inputs[name].label if name in inputs else {INTERFACE_INPUT_NAME: "the interface"}.get(name, name)
            for name in input_names
        ]
        coordinates |= {"input": ("input", input_names), "input_label": ("input", labels)}
    if find_junction_growth(study) is not None:
        tables["fraction_seizing"] = dims, seizing_fractions
    if study.friction.wait:
        tables["friction_after_dwell"] = (*dims, "dwell_time", "statistic"), dwell_intervals
        coordinates["dwell_time"] = ("dwell_time", np.array(study.friction.wait, float), {"units": "s"})
    return tables, coordinates


def _find_inputs_and_strengths(study: Study) -> tuple[dict[str, Any], list[StrengthArrays]]:
    """Return the uncertain inputs of a study, and the joint samples of mu0 and tau0 of its interface.

    The samples replace inputs that the interface was calibrated with. Without an interface, there are no samples.
    """
    inputs = find_uncertain_inputs(study)
    if (interface := find_interface(study)) is None:
        return inputs, []
    fit, hardness = interface.fits[0], inputs.get("hardness")
    fit_has_same_hardness = hardness is not None and hardness.estimate.describes_same_hardness(
        interface.about.get(HARDNESS_HEADER_ENTRY, "")
    )
    growth = fit.junction_growth if interface.has_equal_junction_growth(find_junction_growth(study)) else None
    hardness_and_growth = fit.hardness if fit_has_same_hardness else None, growth
    replaced_names = {"mu0", "tau0"} | ({"hardness"} if fit_has_same_hardness else set())
    replaced_names |= {"junction_growth"} if growth is not None else set()
    strengths = [(*each, *hardness_and_growth) for each in ((fit.mu0, fit.tau0), *interface.samples_at_bounds)]
    return {name: each for name, each in inputs.items() if name not in replaced_names}, strengths


def find_slope_drifts(attributes: Mapping[str, Any]) -> dict[str, float]:
    """Return the standard deviations of ln(rms slope of the gap) due to the drift of single scans, by source.

    The slope of another place on a part is assumed to differ by as much as the slopes at the two ends of the scan.
    """
    names = zip(SIDES, (UPPER_SCANS_INPUT_NAME, LOWER_SCANS_INPUT_NAME), strict=True)
    return {name: float(np.prod(attributes[f"{side}_drift"])) for side, name in names if f"{side}_drift" in attributes}


def _average_pairs_of_scans(
    result: MemberSums, at: xarray.Dataset, dims: Sequence[str]
) -> dict[tuple[int, ...], ScanPairMean | None]:
    """Return the mean of each coefficient over pairs of scans, with its variance split by source.

    The sources are scans and positions. The result is empty for a single pair of scans.
    """
    surfaces: Any = result.study.surfaces
    if math.prod(surfaces.scan_counts) == 1:
        return {}
    members = member_values(result, at["load"].values, mu0=at["mu0"].values, tau0=at["tau0"].values)
    table = members["friction_coefficient"].transpose(*dims, "repetition", "direction")
    scans = surfaces.scan_indices_of_members(table["repetition"].values)
    shape = table.shape[: len(dims)]
    return {position: average_scan_pairs(table.values[position], *scans) for position in np.ndindex(*shape)}


def _iterate_samples(
    result: MemberSums, at: xarray.Dataset, dims: Sequence[str], inputs: Mapping[str, Any],
    strengths: Sequence[StrengthArrays], scan_means: Mapping[tuple[int, ...], ScanPairMean | None],
    drifts: Mapping[str, float],
) -> Iterator[tuple[tuple[int, ...], CoefficientSamples]]:  # fmt: skip
    """Yield the indices of each coefficient (along `dims`) and the samples of its inputs."""
    study = result.study
    areas = build_area_interpolator(at, result, result.compute_once(compute_mean_areas))
    interval_variables = {name: at.variables[name] for name in _INTERVAL_VARIABLES if name in at.variables}
    values_by_name = _get_arrays_over_dims(
        interval_variables | _compute_pressure_and_growth_under_shear(at, study, areas), at, dims
    )
    contact_sums = interpolate_member_sums(result, at["load"].values).mean(("repetition", "direction"))
    sums_by_name = _get_arrays_over_dims({name: contact_sums.variables[name] for name in LOAD_SUM_NAMES}, at, dims)
    # Consecutive coefficients have the same mu0 and tau0, and therefore use the same samples.
    interface_axes = [dims.index(name) for name in ("mu0", "tau0")]
    shape = tuple(at.sizes[dim] for dim in dims)
    for position in sorted(np.ndindex(*shape), key=lambda position: [position[index] for index in interface_axes]):
        yield position, CoefficientSamples(
            {name: values[position] for name, values in values_by_name.items()}, position[dims.index("load")], study,
            inputs, ForcesPerLoad.from_contact_sums({name: sums[position] for name, sums in sums_by_name.items()}),
            areas, strengths, scan_means.get(position), drifts,
        )  # fmt: skip


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
    for name in (each for each in (*COVERED_NAMES, *AREA_NAMES) if each in own and each != "remaining_interval"):
        dims = own[name].dims
        others = [other[name].transpose(*dims).values for other in alternatives.values()]
        variables[name] = (dims, _extend_estimates(own[name].values, others), own[name].attrs)
    covered = own.assign(variables).assign_attrs(alternatives=list(alternatives))
    if "remaining_interval" not in own:
        return covered
    dims = own["remaining_interval"].dims[1:]
    labels_by_input = {
        str(name): str(label)
        for each in (own, *alternatives.values())
        for name, label in zip(each["input"].values, each["input_label"].values, strict=True)
    }
    remaining_intervals = _extend_estimates(
        _get_remaining_intervals(own, labels_by_input, dims),
        [_get_remaining_intervals(each, labels_by_input, dims) for each in alternatives.values()],
    )
    is_budgeted = _find_budgeted_coefficients(own, dims)
    intervals = {name: each["friction_at_cutoff"].transpose(*dims).values for name, each in alternatives.items()}
    own_intervals = own["friction_at_cutoff"].transpose(*dims).values
    rows = np.stack(
        [
            np.where(
                is_budgeted,
                _extend_estimates(own_intervals, [each for other, each in intervals.items() if other != name]),
                np.nan,
            )
            for name in alternatives
        ]
    )
    labels = [ALTERNATIVE_LABELS[name] for name in alternatives]
    other_inputs = covered.drop_vars(["remaining_interval", "remaining_width", "input", "input_label"])
    remaining = np.concatenate([remaining_intervals, rows])
    return other_inputs.assign(
        remaining_interval=(("input", *dims), remaining, own["remaining_interval"].attrs),
        remaining_width=(("input", *dims[:-1]), remaining[..., 2] - remaining[..., 1], own["remaining_width"].attrs),
    ).assign_coords(
        input=("input", [*labels_by_input, *alternatives]), input_label=("input", [*labels_by_input.values(), *labels])
    )


def _get_remaining_intervals(at: xarray.Dataset, names: Iterable[str], dims: Sequence[Any]) -> Floats:
    """Return the intervals that would remain if each of the named inputs were exact.

    An alternative preparation can have other inputs, such as a drift of the roughness. Without an input, the combined
    interval remains.
    """
    rows = at["remaining_interval"].transpose("input", *dims).values
    rows_by_name = dict(zip(at["input"].values.tolist(), rows, strict=True))
    combined = np.where(_find_budgeted_coefficients(at, dims), at["friction_at_cutoff"].transpose(*dims).values, np.nan)
    return np.stack([rows_by_name.get(name, combined) for name in names])


def _find_budgeted_coefficients(at: xarray.Dataset, dims: Sequence[Any]) -> NDArray[np.bool_]:
    """Return a mask of the coefficients with a budget. Its last axis, for the statistics, has the length 1."""
    widths = at["remaining_width"].transpose("input", *dims[:-1]).values
    return np.asarray(~np.isnan(widths).all(axis=0)[..., np.newaxis])


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


def _get_combined_coefficients(
    at: xarray.Dataset, study: Study, dims: Sequence[str], known_intervals: Floats
) -> Floats:
    """Return the reported coefficients and their interval limits as an array of shape (*dims, statistic)."""
    combined = at["mean_friction"].transpose(*dims, "statistic").values.copy()
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
