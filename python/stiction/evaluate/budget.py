"""Combined intervals of a result, and the uncertainty budget: the interval that remains if one input is exact."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._estimate import extend_intervals
from stiction.evaluate.at_load import at_load
from stiction.evaluate.combined_intervals import (
    COMBINED_QUANTITIES,
    FRICTION_PERCENTILES,
    INTERFACE_INPUT_NAME,
    LOWER_SCANS_INPUT_NAME,
    POSITIONS_INPUT_NAME,
    SAMPLING_INPUT_NAMES,
    UNRESOLVED_ROUGHNESS_INPUT_NAME,
    UPPER_SCANS_INPUT_NAME,
    CombinedIntervals,
    InputSampler,
    JointSamples,
    extend_percentiles,
)
from stiction.evaluate.contact_area import build_area_functions, compute_stiffness_exponents
from stiction.evaluate.intervals import ScanPairMean, average_scan_pairs
from stiction.evaluate.member_values import estimate_area_error, interpolate_member_sums, member_values
from stiction.evaluate.point import list_rules_with_reported_first
from stiction.evaluate.response import ContactResponseToInputs, InputValues, build_closure_curves
from stiction.mechanics.friction import LOAD_SUM_NAMES, sums_per_load
from stiction.mechanics.quantities import INTERVAL_KIND_ATTRIBUTE, QUANTITIES_SUMMED_AT_ZERO_LOAD, quantity_attributes
from stiction.solve.alternative_preparations import ALTERNATIVE_LABELS, AlternativeName, load_stored_alternatives
from stiction.solve.layout import arrange_axes, share_read_only
from stiction.solve.member_sums import MemberSums
from stiction.study.inputs import Inputs, StudyInput
from stiction.study.interfaces import InterfaceStrength, ValueWithLimits, area_error_name, round_median_strength
from stiction.study.shared_inputs import apply_ranges_of_pair, find_shared_inputs
from stiction.surfaces.pairing import SIDES

if TYPE_CHECKING:
    import xarray

    from stiction.study.study import Study

MAX_BUDGETED_COEFFICIENTS = 100
"""Maximum number of coefficients, at the loads of the study, for which uncertainty budgets are computed."""

MAX_NAMED_SHARED_INPUTS = 2

INTERVALS_COVERING_ALTERNATIVES = (
    "friction_combined",
    "friction_at_cutoff",
    "friction_prediction",
    "friction_after_dwell",
    "remaining_interval",
)
"""Names of the coefficient's intervals that also cover results for alternative preparations of the scans."""

COMBINED_INTERVAL_ATTRIBUTES = {INTERVAL_KIND_ATTRIBUTE: "combined"}

_INTERVAL_VARIABLES = (
    "mean_friction", "spread_low", "spread_high", "ok", "members", "contact_count", "mu0", "tau0", "sliding",
)  # fmt: skip
"""Names of the variables of an `at_load` dataset that determine the interval of a coefficient."""


def add_uncertainty(
    at: xarray.Dataset, result: MemberSums | xarray.Dataset, *, budget: bool = True, tests: bool = True
) -> xarray.Dataset:
    """Add combined intervals, prediction intervals and the uncertainty budget to a dataset of `at_load`.

    `friction_at_cutoff` contains the combined 95 % interval at each cutoff, or NaN if the cutoff has none.
    `friction_combined` contains the interval to report: this interval or, if it is missing, the interval of the mean.
    If scans are evaluated at two cutoffs, the reported interval at the first cutoff covers the results at both.
    `friction_prediction` contains the prediction interval of a test at one position in one direction,
    `friction_percentiles` the 5th, 50th and 95th percentile of such tests, and `friction_after_dwell` the interval
    after each dwell time. With `budget`, which takes most of the time, the dataset also has the dimension `input`
    (uncertain inputs of the study, positions and unresolved roughness) and the variables `remaining_interval` and
    `remaining_width`: the interval that would remain if the input were exact, and its width. Without `tests`, only
    `friction_combined` is added. Results of generated bodies are returned unchanged.

    All these intervals, and the intervals of the true area, cover the results for the alternative preparations of the
    scans that are stored with the result. Each of these preparations is an `input` too. If the interface was calibrated
    on this pair, the tests include errors of the scans, and no interval covers alternative preparations.
    """
    result = MemberSums.of(result)
    if not result.study.is_measured or at.attrs.get("load_definition") != "elastic":
        return at
    original = _add_own_uncertainty(at, result, budget=budget, tests=tests)
    if is_tested_pair(result.study, Inputs.from_study(result.study).strength):
        return original
    if budget:
        alternatives = evaluate_alternatives(result, at)
    else:
        names = [name for name in (*COMBINED_QUANTITIES, "contact_count") if name in at]
        alternatives = _evaluate_alternatives_uncached(result, at, names, budget=False, tests=tests)
    return _widen_intervals_to_alternatives(original, alternatives) if alternatives else original


def evaluate_alternatives(result: MemberSums, at: xarray.Dataset) -> dict[AlternativeName, xarray.Dataset]:
    """Evaluate the friction for each alternative preparation of the scans, at every load, mu0 and tau0 of a dataset.

    The datasets of the last call are cached.
    """
    cache = result.compute_once(_create_cache)
    points = tuple(at[name].values.tobytes() for name in ("load", "mu0", "tau0"))
    alternatives = cache.get(points)
    if alternatives is None:
        values = _evaluate_alternatives_uncached(result, at)
        alternatives = {name: share_read_only(dataset) for name, dataset in values.items()}
        # Missing results are not cached, because they may be computed later.
        if alternatives:
            cache.clear()
            cache[points] = alternatives
    return alternatives


def _create_cache(_: MemberSums) -> dict[Any, dict[AlternativeName, xarray.Dataset]]:
    return {}


def _evaluate_alternatives_uncached(
    result: MemberSums, at: xarray.Dataset, names: Collection[str] | None = None, *,
    budget: bool = True, tests: bool = True,
) -> dict[AlternativeName, xarray.Dataset]:  # fmt: skip
    loads, mu0, tau0 = (at[name].values for name in ("load", "mu0", "tau0"))
    return {
        name: add_uncertainty(
            at_load(alternative, loads, mu0=mu0, tau0=tau0, names=names), alternative, budget=budget, tests=tests
        )
        for name, alternative in load_stored_alternatives(result).items()
    }


_VariablesByName = dict[str, tuple[tuple[str, ...], Floats]]


def is_tested_pair(study: Study, strength: InterfaceStrength | None) -> bool:
    """Return whether an interface was calibrated on the pair of a study."""
    return strength is not None and area_error_name(study.pair_checksum) in strength.fits[0].scores


def predict_coefficient(result: MemberSums, load: float, strength: InterfaceStrength) -> ValueWithLimits:
    """Predict the friction coefficient of a measured pair and its combined interval, from an interface and a load (mN).

    The number and its interval are those of `pair` with this interface. The sliding rule is the rule under which mu0
    and tau0 were fitted. The fitted α of junction growth is used if the interface was calibrated with the junction
    growth of the result.
    """
    alternatives = {} if is_tested_pair(result.study, strength) else load_stored_alternatives(result)
    values, *alternative_values = (
        _evaluate_with_interface_strength(sums, load, strength) for sums in (result, *alternatives.values())
    )
    value, lower, upper = (
        _extend_estimates(values, alternative_values).tolist() if alternative_values else values.tolist()
    )
    return value, lower, upper


def _evaluate_with_interface_strength(result: MemberSums, load: float, strength: InterfaceStrength) -> Floats:
    """Return a pair's friction coefficient at a load (mN) with its combined interval, from samples of mu0 and tau0."""
    fit, study = strength.fits[0], result.study
    mu0, tau0 = round_median_strength(strength)
    changes: dict[str, Any] = {"friction.interface": None, "friction.mu0": [mu0], "friction.tau0": [f"{tau0!r} GPa"]}
    growth_estimate = Inputs.from_study(study).estimate("junction_growth")
    if (
        strength.junction_growth is not None
        and growth_estimate is not None
        and not growth_estimate.is_exact
        and (strength.has_equal_junction_growth(growth_estimate))
    ):
        changes["contact.junction_growth"] = f"{strength.junction_growth.value:.6g} ({strength.junction_growth.text})"
    sums = result.with_study(study.with_changes(changes))
    dataset = at_load(sums, [load], mu0=[mu0], tau0=[tau0], names=["contact_count"])
    combined_friction = _add_own_uncertainty(dataset, sums, budget=False, tests=False, strength=strength)[
        "friction_combined"
    ]
    return np.asarray(combined_friction.sel(sliding=fit.sliding).isel(cut_off=0, load=0, mu0=0, tau0=0).values)


def _add_own_uncertainty(
    at: xarray.Dataset, result: MemberSums, *, budget: bool, tests: bool, strength: InterfaceStrength | None = None
) -> xarray.Dataset:
    """Return a dataset with combined intervals and uncertainty budgets for the chosen preparation of the scans only.

    If given, `strength` replaces the interface of the study.
    """
    is_study_load = np.isin(at["load"].values, [float(load) for load in result.study.friction.load])
    num_coefficients = at["mean_friction"].size // at.sizes["statistic"]
    is_budgeted = _find_budgeted_loads(is_study_load, num_coefficients) if budget else None
    tables, coordinates = _evaluate_uncertainty(at, result, is_budgeted=is_budgeted, tests=tests, strength=strength)
    variables = {
        name: (
            dims,
            values,
            quantity_attributes(name) | (COMBINED_INTERVAL_ATTRIBUTES if name in COMBINED_QUANTITIES else {}),
        )
        for name, (dims, values) in tables.items()
    }
    return at.assign(variables).assign_coords(coordinates)


def _evaluate_uncertainty(
    at: xarray.Dataset,
    result: MemberSums,
    *,
    is_budgeted: NDArray[np.bool_] | None,
    tests: bool,
    strength: InterfaceStrength | None,
) -> tuple[_VariablesByName, dict[str, Any]]:
    """Compute the combined intervals and uncertainty budgets for all loads, mu0 and tau0 in a dataset.

    `is_budgeted` is a mask of the loads at which uncertainty budgets are computed, or None to omit the budgets.
    """
    study = result.study
    dims = tuple(str(dim) for dim in at["mean_friction"].dims if dim != "statistic")
    shape = tuple(at.sizes[dim] for dim in dims)
    study_inputs = Inputs.from_study(study)
    inputs_by_strength = {
        (mu0, tau0): find_inputs_and_strengths(study_inputs.replaced(mu0=mu0, tau0=tau0), strength, study.pair_checksum)
        for mu0 in at["mu0"].values.tolist()
        for tau0 in at["tau0"].values.tolist()
    }
    sampled_names = {name for inputs, _ in inputs_by_strength.values() for name in inputs}
    joint_samples = next((strengths[0] for _, strengths in inputs_by_strength.values() if strengths), None)
    inputs = {name: study_input for name, study_input in study_inputs.uncertain.items() if name in sampled_names}
    scan_means = _average_pairs_of_scans(result, at, dims)
    drifts = find_slope_drifts(at.attrs)
    input_names = [
        *([] if joint_samples is None else [INTERFACE_INPUT_NAME]),
        *inputs,
        *(name for name in SAMPLING_INPUT_NAMES if scan_means or name in drifts or name == POSITIONS_INPUT_NAME),
        UNRESOLVED_ROUGHNESS_INPUT_NAME,
    ]
    coefficient_intervals, test_intervals = np.full((*shape, 3), np.nan), np.full((*shape, 3), np.nan)
    remaining_intervals, remaining_widths = (
        np.full((len(input_names), *shape, 3), np.nan),
        np.full((len(input_names), *shape), np.nan),
    )
    percentiles = np.full((*shape, FRICTION_PERCENTILES.size), np.nan)
    dwell_intervals, unlimited_fractions = np.full((*shape, len(study.friction.wait), 3), np.nan), np.zeros(shape)
    quantities = _QuantitiesWithCombinedIntervals(at, dims)
    reported_rule = list_rules_with_reported_first(study)[0]
    for position, samples in _iterate_intervals(result, at, dims, inputs_by_strength, scan_means, drifts):
        quantities.add_intervals(position, samples)
        if not samples.names:
            coefficient_intervals[position] = samples.estimate_zero_coefficient()
            continue
        coefficient_intervals[position] = samples.value, *samples.interval()
        if not tests:
            continue
        unlimited_fractions[position] = samples.unlimited_fraction
        test_intervals[position] = samples.value, *samples.predict_next_test()
        percentiles[position] = samples.predict_percentiles()
        for index, wait in enumerate(study.friction.wait):
            dwell_intervals[(*position, index)] = samples.friction_after_dwell(float(wait))
        is_reported = samples.rule == reported_rule
        if not is_reported or is_budgeted is None or not is_budgeted[position[dims.index("load")]]:
            continue
        for index, name in enumerate(input_names):
            if name in samples.names:
                remaining_intervals[(index, *position)] = samples.value, *samples.interval({name: 0.5})
                remaining_widths[(index, *position)] = samples.remaining_interval_width(name)
    interval_dims = (*dims, "statistic")
    tables: _VariablesByName = {
        "friction_combined": (interval_dims, _get_combined_coefficients(at, study, dims, coefficient_intervals)),
        **quantities.tables,
    }
    if not tests:
        return tables, {}
    percent_attributes = quantity_attributes("percentile")
    coordinates: dict[str, Any] = {"percentile": ("percentile", FRICTION_PERCENTILES, percent_attributes)}
    # Percentiles of friction at the first cutoff are widened to include the percentiles at all other cutoffs.
    if study.surfaces.both_readings and "cut_off" in dims:
        percentiles_by_cutoff = np.moveaxis(percentiles, dims.index("cut_off"), 0)
        percentiles_by_cutoff[0] = extend_percentiles(percentiles_by_cutoff[0], percentiles_by_cutoff[1:])
    tables |= {
        "friction_percentiles": ((*dims, "percentile"), percentiles),
        "friction_at_cutoff": (interval_dims, coefficient_intervals),
        "friction_prediction": (interval_dims, test_intervals),
    }
    if is_budgeted is not None:
        tables |= {
            "remaining_interval": (("input", *interval_dims), remaining_intervals),
            "remaining_width": (("input", *dims), remaining_widths),
        }
        labels_by_input = {name: study_input.label for name, study_input in inputs.items()}
        if joint_samples is not None:
            labels_by_input[INTERFACE_INPUT_NAME] = _label_interface(study_inputs, joint_samples)
        labels = [labels_by_input.get(name, name) for name in input_names]
        coordinates |= {"input": ("input", input_names), "input_label": ("input", labels)}
    if "junction_growth" in Inputs.from_study(study).entries:
        tables["fraction_unlimited"] = dims, unlimited_fractions
    if study.friction.wait:
        tables["friction_after_dwell"] = (*dims, "dwell_time", "statistic"), dwell_intervals
        coordinates["dwell_time"] = ("dwell_time", np.array(study.friction.wait, float), {"units": "s"})
    return tables, coordinates


_UncertainInputsAndStrengthSamples = tuple[dict[str, StudyInput], list[JointSamples]]


def find_inputs_and_strengths(
    study_inputs: Inputs, strength: InterfaceStrength | None = None, pair_checksum: str = ""
) -> _UncertainInputsAndStrengthSamples:
    """Return the uncertain inputs of a study. For a calibrated interface, also return samples of mu0 and tau0.

    The joint samples contain each input that also affected the tests of the interface, because its error is the same in
    the tests and in the pair. If both give the input ranges with the same central value, the narrower range applies.
    Without an interface, there are no samples. If given, `strength` replaces the interface of the inputs.
    `pair_checksum` identifies the pair among the tested pairs.
    """
    inputs = {name: study_input for name, study_input in study_inputs.uncertain.items() if name != "creep"}
    if (interface := strength or study_inputs.strength) is None:
        return inputs, []
    estimates = {name: entry.estimate for name, entry in study_inputs.entries.items()}
    shared_inputs = find_shared_inputs(interface, estimates, pair_checksum)
    strengths = []
    for fit, coverage in apply_ranges_of_pair(interface, shared_inputs).sampled_fits:
        # If the pair and the tests share an uncertain input, the samples drawn by the calibration are used.
        shared = {name: shared_inputs[name].sample(fit) for name in inputs if name in shared_inputs}
        area_scores = fit.scores.get(area_error_name(pair_checksum))
        strengths.append(JointSamples(fit.mu0, fit.tau0, shared, area_scores, coverage))
    replaced_names = {"mu0", "tau0", *strengths[0].inputs}
    return {name: entry for name, entry in inputs.items() if name not in replaced_names}, strengths


def _label_interface(study_inputs: Inputs, joint_samples: JointSamples) -> str:
    """Return the label of an interface in the uncertainty budget, with the inputs that are sampled together with it."""
    names = sorted(joint_samples.inputs, key=lambda name: name != "hardness")
    labels = [study_inputs.uncertain[name].label for name in names]
    if len(labels) > MAX_NAMED_SHARED_INPUTS:
        labels = [labels[0], "other inputs of its tests"]
    return " with ".join(filter(None, ("the interface", " and ".join(labels))))


def find_slope_drifts(attributes: Mapping[str, Any]) -> dict[str, float]:
    """Estimate the variation of ln(rms slope of the gap) between places on a body, from the drift along the scan.

    The keys name the body with a single scan: upper scans or lower scans. The slope at another place on a body is
    assumed to differ by as much as the slopes at the two ends of the scan.
    """
    names = zip(SIDES, (UPPER_SCANS_INPUT_NAME, LOWER_SCANS_INPUT_NAME), strict=True)
    return {name: float(np.prod(attributes[f"{side}_drift"])) for side, name in names if f"{side}_drift" in attributes}


def _average_pairs_of_scans(
    result: MemberSums, at: xarray.Dataset, dims: Sequence[str]
) -> dict[tuple[int, ...], ScanPairMean | None]:
    """Average each friction coefficient over all pairs of scans, and return the means with their variance components.

    The components are the variances due to upper scans, lower scans and positions. The result is empty for a single
    pair of scans.
    """
    surfaces: Any = result.study.surfaces
    if math.prod(surfaces.scan_counts) == 1:
        return {}
    members = member_values(result, at["load"].values, mu0=at["mu0"].values, tau0=at["tau0"].values)
    table = arrange_axes(members.variables["friction_coefficient"], (*dims, "repetition", "direction"))
    scans = surfaces.scan_indices_of_members(members["repetition"].values)
    shape = table.shape[: len(dims)]
    return {position: average_scan_pairs(table[position], *scans) for position in np.ndindex(*shape)}


class _QuantitiesWithCombinedIntervals:
    """Combined intervals of all quantities other than the friction coefficient, such as true area and stiffness.

    Each friction coefficient widens these intervals in turn.
    """

    def __init__(self, at: xarray.Dataset, dims: Sequence[str]) -> None:
        self._dims = dims
        self.tables: _VariablesByName = {}
        for name in COMBINED_QUANTITIES:
            if name in at and "statistic" in (variable := at.variables[name]).dims:
                own_dims = (*(dim for dim in dims if dim in variable.dims), "statistic")
                self.tables[name] = own_dims, arrange_axes(variable, own_dims).copy()

    def add_intervals(self, position: tuple[int, ...], intervals: CombinedIntervals) -> None:
        """Store the combined intervals of all quantities at the array indices `position` of a friction coefficient."""
        indices = dict(zip(self._dims, position, strict=True))
        estimates, positions = {}, {}
        for name, (dims, values) in self.tables.items():
            # If a quantity does not vary along a dimension, its interval is computed only at index 0 of the dimension.
            if any(index > 0 for dim, index in indices.items() if dim not in dims):
                continue
            positions[name] = tuple(indices[dim] for dim in dims[:-1])
            estimates[name] = values[positions[name]]
        if estimates:
            for name, estimate in intervals.widen_quantity_intervals(estimates).items():
                self.tables[name][1][positions[name]] = estimate


def _create_sampler(result: MemberSums) -> InputSampler:
    return InputSampler(result.study)


def _iterate_intervals(
    result: MemberSums, at: xarray.Dataset, dims: Sequence[str],
    inputs_by_strength: Mapping[tuple[float, float], _UncertainInputsAndStrengthSamples],
    scan_means: Mapping[tuple[int, ...], ScanPairMean | None], drifts: Mapping[str, float],
) -> Iterator[tuple[tuple[int, ...], CombinedIntervals]]:  # fmt: skip
    """Yield the combined intervals for each friction coefficient in a dataset, with the coefficient's array indices.

    `inputs_by_strength` contains the results of `find_inputs_and_strengths` by mu0 and tau0.
    """
    study, contact, sampler = result.study, result.study.contact, result.compute_once(_create_sampler)
    areas = result.compute_once(build_area_functions)
    loads = at["load"].values
    log_steps, exponents_at_steps = np.log(contact.loading_steps()), result.compute_once(compute_stiffness_exponents)
    stiffness_exponents = np.stack([np.interp(np.log(loads), log_steps, row) for row in exponents_at_steps], axis=1)
    law = Inputs.from_study(study).friction_law(np.nan, np.nan)
    closure_curves = result.compute_once(build_closure_curves)
    study_inputs = InputValues(
        mu0=np.nan, tau0=np.nan,
        hardness=np.nan if contact.hardness is None else float(contact.hardness),
        yield_exponent=areas[0].yield_exponent,
        junction_growth=law.junction_growth, uses_slip_lines=law.uses_slip_lines, area_loss=law.area_loss,
    )  # fmt: skip
    values_by_name = _get_arrays_over_dims(
        {name: at.variables[name] for name in _INTERVAL_VARIABLES if name in at.variables}, at, dims
    )
    member_sums = interpolate_member_sums(result, loads)
    contact_sums = {name: member_sums.variables[name].mean(("repetition", "direction")) for name in LOAD_SUM_NAMES}
    sums_by_name = _get_arrays_over_dims(contact_sums, at, dims)
    area_errors = None
    if any(samples.area_scores is not None for _, strengths in inputs_by_strength.values() for samples in strengths):
        adhesive_sums = member_sums["tangential_adhesive"].mean("direction")
        errors = adhesive_sums.reduce(_estimate_area_errors, "repetition")
        area_errors = _get_arrays_over_dims({"error": errors.variable}, at, dims)["error"]
    sums_at_no_load = {}
    if "friction_at_no_load" in at:
        mean_sums = result.means(QUANTITIES_SUMMED_AT_ZERO_LOAD).mean("direction")
        sums_at_no_load = _get_arrays_over_dims(
            {name: mean_sums.variables[name] for name in QUANTITIES_SUMMED_AT_ZERO_LOAD}, at, dims
        )
    shape = tuple(at.sizes[dim] for dim in dims)
    all_inputs = replace(study_inputs, mu0=at["mu0"].values[:, np.newaxis], tau0=at["tau0"].values)
    # Quantities at the central inputs, each an array over mu0 and tau0; keyed by the indices along other dimensions.
    central_values: dict[tuple[int, ...], Any] = {}
    for position in np.ndindex(*shape):
        indices = dict(zip(dims, position, strict=True))
        point = {name: values[position] for name, values in values_by_name.items()}
        response = ContactResponseToInputs(
            float(loads[indices["load"]]),
            sums_per_load({name: sums[position] for name, sums in sums_by_name.items()}),
            areas[indices.get("cut_off", 0)],
            replace(study_inputs, mu0=float(point["mu0"]), tau0=float(point["tau0"])),
            tuple(stiffness_exponents[indices["load"]].tolist()),
            {name: float(sums[position]) for name, sums in sums_at_no_load.items()} or None,
            closure_curves[indices.get("cut_off", 0)],
        )
        cell_indices = tuple(index for dim, index in indices.items() if dim not in ("mu0", "tau0"))
        if cell_indices not in central_values:
            central_values[cell_indices] = response.evaluate(all_inputs)
        central_quantities = central_values[cell_indices].select_sample(indices["mu0"], indices["tau0"])
        inputs, strengths = inputs_by_strength[float(point["mu0"]), float(point["tau0"])]
        scan_mean = scan_means.get(position)
        intervals = CombinedIntervals(
            point, response, central_quantities, study, inputs, sampler, strengths, scan_mean, drifts,
            float(area_errors[position]) if area_errors is not None else 0.0,
        )  # fmt: skip
        yield position, intervals


def _estimate_area_errors(adhesive_sums: Floats, axis: int, **_: Any) -> Floats:
    """Return the relative standard error of the mean true area, estimated from the scatter of areas between members."""
    return np.apply_along_axis(lambda sums: estimate_area_error(sums[np.isfinite(sums)]), axis, adhesive_sums)


def _find_budgeted_loads(is_study_load: NDArray[np.bool_], num_coefficients: int) -> NDArray[np.bool_]:
    """Return a boolean array that is True for each load at which uncertainty budgets are computed.

    `MAX_BUDGETED_COEFFICIENTS` limits the coefficients at all study loads together, and at each further load alone.
    Therefore, the budget at a load does not depend on other loads that are evaluated in addition.
    """
    num_coefficients_per_load = num_coefficients // is_study_load.size
    num_counted_loads = np.where(is_study_load, np.count_nonzero(is_study_load), 1)
    return np.asarray(num_counted_loads * num_coefficients_per_load <= MAX_BUDGETED_COEFFICIENTS)


def _widen_intervals_to_alternatives(
    original: xarray.Dataset, alternatives: Mapping[AlternativeName, xarray.Dataset]
) -> xarray.Dataset:
    """Widen intervals to include the intervals for alternative preparations of the scans.

    The names of the alternatives become the attribute `alternatives`. The uncertainty budget gets one row per
    alternative: the interval that would remain without this alternative. Each other row is extended by the same row in
    the budgets of the alternatives.
    """
    variables = {}
    names = (*(name for name in INTERVALS_COVERING_ALTERNATIVES if name != "remaining_interval"), *COMBINED_QUANTITIES)
    for name in (variable_name for variable_name in names if variable_name in original):
        dims = original[name].dims
        alternative_values = [alternative[name].transpose(*dims).values for alternative in alternatives.values()]
        variables[name] = (dims, _extend_estimates(original[name].values, alternative_values), original[name].attrs)
    if "friction_percentiles" in original:
        dims = original["friction_percentiles"].dims
        percentiles = [
            dataset["friction_percentiles"].transpose(*dims).values for dataset in (original, *alternatives.values())
        ]
        covering_percentiles = extend_percentiles(percentiles[0], percentiles[1:])
        variables["friction_percentiles"] = (dims, covering_percentiles, original["friction_percentiles"].attrs)
    covering_dataset = original.assign(variables).assign_attrs(alternatives=list(alternatives))
    if "remaining_interval" not in original:
        return covering_dataset
    dims = original["remaining_interval"].dims[1:]
    labels_by_input = {
        str(name): str(label)
        for dataset in (original, *alternatives.values())
        for name, label in zip(dataset["input"].values, dataset["input_label"].values, strict=True)
    }
    remaining_intervals = _extend_estimates(
        _get_intervals_with_one_exact_input(original, labels_by_input, dims),
        [_get_intervals_with_one_exact_input(dataset, labels_by_input, dims) for dataset in alternatives.values()],
    )
    is_budgeted = _find_budgeted_coefficients(original, dims)
    intervals = {name: dataset["friction_at_cutoff"].transpose(*dims).values for name, dataset in alternatives.items()}
    original_intervals = original["friction_at_cutoff"].transpose(*dims).values
    rows = np.stack(
        [
            np.where(
                is_budgeted,
                _extend_estimates(
                    original_intervals,
                    [other_intervals for other_name, other_intervals in intervals.items() if other_name != name],
                ),
                np.nan,
            )
            for name in alternatives
        ]
    )
    labels = [ALTERNATIVE_LABELS[name] for name in alternatives]
    other_inputs = covering_dataset.drop_vars(["remaining_interval", "remaining_width", "input", "input_label"])
    remaining_rows = np.concatenate([remaining_intervals, rows])
    return other_inputs.assign(
        remaining_interval=(("input", *dims), remaining_rows, original["remaining_interval"].attrs),
        remaining_width=(
            ("input", *dims[:-1]),
            remaining_rows[..., 2] - remaining_rows[..., 1],
            original["remaining_width"].attrs,
        ),
    ).assign_coords(
        input=("input", [*labels_by_input, *alternatives]), input_label=("input", [*labels_by_input.values(), *labels])
    )


def _get_intervals_with_one_exact_input(at: xarray.Dataset, names: Iterable[str], dims: Sequence[Any]) -> Floats:
    """Return, for each named input, the interval of the coefficient that would remain if this input were exact.

    An alternative preparation can have other inputs, such as a drift of the roughness. For an input that is missing in
    the dataset, the combined interval is returned.
    """
    rows = at["remaining_interval"].transpose("input", *dims).values
    rows_by_name = dict(zip(at["input"].values.tolist(), rows, strict=True))
    combined_intervals = np.where(
        _find_budgeted_coefficients(at, dims), at["friction_at_cutoff"].transpose(*dims).values, np.nan
    )
    return np.stack([rows_by_name.get(name, combined_intervals) for name in names])


def _find_budgeted_coefficients(at: xarray.Dataset, dims: Sequence[Any]) -> NDArray[np.bool_]:
    """Return a boolean array that is True for each coefficient with an uncertainty budget in the dataset."""
    remaining_widths = at["remaining_width"].transpose("input", *dims[:-1]).values
    return np.asarray(~np.isnan(remaining_widths).all(axis=0)[..., np.newaxis])


def _extend_estimates(estimates_to_widen: Floats, included_estimates: Iterable[Floats]) -> Floats:
    """Widen the interval of each estimate to include the intervals of other estimates of the same quantity.

    The last axis of each array contains value, lower limit and upper limit.
    """
    limits = extend_intervals(estimates_to_widen[..., 1:], *(estimates[..., 1:] for estimates in included_estimates))
    return np.concatenate([estimates_to_widen[..., :1], limits], axis=-1)


def _get_arrays_over_dims(
    variables: Mapping[str, Any], at: xarray.Dataset, dims: Sequence[str]
) -> dict[str, NDArray[Any]]:
    """Convert dataset variables to arrays whose first axes correspond, in order, to the dimensions in `dims`.

    Variables that lack a dimension are constant along it. The arrays are much faster to index than variables.
    """
    arrays = {}
    for name, variable in variables.items():
        own_dims, other_dims = [dim for dim in dims if dim in variable.dims], set(variable.dims).difference(dims)
        values = arrange_axes(variable, (*own_dims, *(dim for dim in variable.dims if dim in other_dims)))
        expanded_values = values[tuple(slice(None) if dim in own_dims else np.newaxis for dim in dims)]
        shape = (*(at.sizes[dim] for dim in dims), *values.shape[len(own_dims) :])
        arrays[name] = np.broadcast_to(expanded_values, shape)
    return arrays


def _get_combined_coefficients(
    at: xarray.Dataset, study: Study, dims: Sequence[str], known_intervals: Floats
) -> Floats:
    """Return the reported coefficients as an array whose last axis contains value, lower limit and upper limit."""
    combined_friction = arrange_axes(at.variables["mean_friction"], (*dims, "statistic")).copy()
    lower_limits = combined_friction[..., 1]
    combined_friction[..., 1] = np.where((lower_limits < 0) & (combined_friction[..., 0] >= 0), 0.0, lower_limits)
    # Only NaN marks an interval that was not computed: a computed interval may have an infinite upper limit.
    is_known = ~np.isnan(known_intervals).any(axis=-1)
    combined_friction[is_known] = known_intervals[is_known]
    if study.surfaces.both_readings and "cut_off" in dims:
        coefficients_by_cutoff = np.moveaxis(combined_friction, dims.index("cut_off"), 0)
        coefficients_by_cutoff[0] = _extend_estimates(coefficients_by_cutoff[0], coefficients_by_cutoff[1:])
    return combined_friction
