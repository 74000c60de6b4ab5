"""Combined intervals of all quantities at one load, μ0 and τ0, from samples of the uncertain inputs.

The uncertain inputs, the scatter between positions, and the unresolved roughness are propagated by sampling (JCGM 101,
2008) through the `ContactResponseToInputs`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats, make_read_only
from stiction._estimate import Interval
from stiction.evaluate.intervals import MAX_DEGREES_OF_FREEDOM, ScanPairMean
from stiction.evaluate.response import AreasBeforeShear, ContactResponseToInputs, InputValues, ResponseValues
from stiction.mechanics.brackets import friction_range_for_finer_scans, max_friction_for_finer_scans
from stiction.mechanics.friction import NEGLIGIBLE_COEFFICIENT, FrictionLaw
from stiction.mechanics.quantities import find_upper_bound
from stiction.study.input_distributions import NUM_INPUT_SAMPLES, Z_95, UncertainInput, generate_stratified_points
from stiction.study.inputs import Inputs
from stiction.study.interfaces import INTERVAL_COVERAGE, find_tail_probabilities

if TYPE_CHECKING:
    from stiction.study.study import Study

POSITIONS_INPUT_NAME, UNRESOLVED_ROUGHNESS_INPUT_NAME = "positions", "unresolved roughness"
UPPER_SCANS_INPUT_NAME, LOWER_SCANS_INPUT_NAME = "which piece of the upper part", "which piece of the lower part"
SAMPLING_INPUT_NAMES = (UPPER_SCANS_INPUT_NAME, LOWER_SCANS_INPUT_NAME, POSITIONS_INPUT_NAME)
"""Names of the uncertainty sources that are not inputs of the study: the choice of scans and of positions."""

INTERFACE_INPUT_NAME = "interface"
# The uncertainty budget fixes each input at these quantiles in turn, and averages the remaining interval widths.
FIXED_INPUT_QUANTILES = (0.1, 0.5, 0.9)

FRICTION_PERCENTILES = np.array([5.0, 50.0, 95.0])
"""Percentiles of the coefficient of a single test in `Result.at`.

Design codes use the lowest percentile as a minimum.
"""

# Upper limit of ln(coefficient of a single test / mean coefficient), so that the exponential cannot overflow.
MAX_LOG_COEFFICIENT_RATIO = 50.0
NORMAL_DECILE_RANGE = 2.563103131089201
"""Distance between the 10th and the 90th percentile of a normal distribution, in standard deviations."""

MAX_CACHED_AREAS = 64
# Maximum number of cached arrays of yield pressures: enough for all combinations of mu0 and tau0 in one report.
MAX_CACHED_PRESSURES = 256


@dataclass(frozen=True)
class JointSamples:
    """Joint samples of mu0, tau0 (GPa) and the inputs that a pair shares with the friction tests of its interface.

    Attributes
    ----------
    mu0, tau0 : array
    inputs : mapping of str to array
        Samples of the shared inputs by name, such as "hardness" (GPa).
    area_scores : array or None
        Normal scores of the error of the true area, if the interface was calibrated on this pair. The tests then
        include all errors of the true area, so that the pair needs no further ones.
    coverage : float
        Probability of the coefficients from these samples that a 95 % interval contains; less than 95 % for samples in
        which mu0 or tau0 is 0, if this value is less likely than others.
    """

    mu0: Floats
    tau0: Floats
    inputs: Mapping[str, Floats]
    area_scores: Floats | None = None
    coverage: float = INTERVAL_COVERAGE


_RESPONSE_INPUT_NAMES = (
    "mu0", "tau0", "hardness", "yield_exponent", "junction_growth", "area_loss", "size_effect",
)  # fmt: skip
"""Names of the inputs that a `ContactResponseToInputs` takes. Other inputs are elastic constants and determine E*."""

_Value = TypeVar("_Value")
_NO_FIXED_INPUTS: Mapping[str, float] = MappingProxyType({})


RatioName = Literal[
    "area", "area_at_onset", "pressure", "loading_stiffness", "unloading_stiffness", "closure", "closure_stiffness",
    "unloading_closure_stiffness", "friction_at_no_load", "contact_hardness",
]  # fmt: skip

COMBINED_QUANTITIES: Mapping[str, RatioName] = MappingProxyType({
    "contact_area": "area", "contact_area_fraction": "area", "contact_area_at_onset": "area_at_onset",
    "mean_pressure": "pressure", "normal_stiffness": "loading_stiffness", "closure": "closure",
    "closure_stiffness": "closure_stiffness", "stiffness_per_area": "loading_stiffness",
    "unloading_stiffness": "unloading_stiffness", "unloading_stiffness_per_area": "unloading_stiffness",
    "unloading_closure_stiffness": "unloading_closure_stiffness",
    "tangential_stiffness_per_area": "unloading_closure_stiffness", "friction_at_no_load": "friction_at_no_load",
    "contact_hardness": "contact_hardness",
})  # fmt: skip
"""Names of the quantities besides friction that have combined intervals, each with a ratio.

The ratio states by which factor uncertain inputs change the quantity.
"""


def compute_quantity_ratios(
    response: ContactResponseToInputs, inputs: InputValues, values: ResponseValues, central: ResponseValues
) -> dict[RatioName, Floats]:
    """Return the ratio of each contact quantity at given inputs to the same quantity at the central inputs.

    The closure is omitted. `values` and `central` are the quantities that the response gives for the inputs and for the
    central inputs.
    """
    hardness, central_hardness = (
        response.area.contact_hardness(response.load, input_values.hardness, input_values.size_effect)
        for input_values in (inputs, response.central)
    )
    area_ratio = values.area / central.area
    loading, unloading, closure_loading, closure_unloading = response.stiffness_ratios(inputs, values.area)
    # The areas at the onset of sliding are infinite if the contacts seize.
    with np.errstate(invalid="ignore"):
        onset_area_ratio = values.area_at_onset / central.area_at_onset
    return {
        "area": area_ratio, "area_at_onset": onset_area_ratio, "pressure": 1 / area_ratio,
        "loading_stiffness": loading, "unloading_stiffness": unloading,
        "closure_stiffness": closure_loading, "unloading_closure_stiffness": closure_unloading,
        "friction_at_no_load": response.friction_at_no_load_ratio(inputs),
        "contact_hardness": np.ones(()) if hardness is None else np.asarray(hardness / central_hardness),
    }  # fmt: skip


@dataclass(frozen=True)
class _InputSamples:
    """Random samples of the uncertain inputs, and of the errors of means over scans or over positions."""

    probabilities: dict[str, Floats]
    scores: dict[str, Floats]
    values: dict[str, Floats]
    modulus: Floats | float  # relative to E* of the study
    creep: Floats | None


class InputSampler:
    """Sampler of a study's uncertain inputs. All coefficients are evaluated with the same samples."""

    def __init__(self, study: Study) -> None:
        self._inputs = Inputs.from_study(study)
        self._creep = self._inputs.estimate("creep")
        self._cache: dict[Any, _InputSamples] = {}
        self._areas: dict[Any, AreasBeforeShear] = {}
        self._pressures: dict[Any, Any] = {}
        self._closures: tuple[Any, Floats] = (None, np.empty(0))
        self.intervals: dict[Any, Interval] = {}

    def draw_samples(
        self, inputs: Mapping[str, UncertainInput], names: tuple[str, ...], fixed: Mapping[str, float]
    ) -> _InputSamples:
        """Return samples of the sources in `names`. All samples are drawn on the first call and then cached.

        Inputs in `fixed` have the value at the given quantile.
        """
        samples_key = tuple(inputs), names, tuple(fixed.items())
        if samples_key not in self._cache:
            self._cache[samples_key] = self._generate_samples(inputs, names, fixed)
        return self._cache[samples_key]

    def relative_modulus(self, values: Mapping[str, Floats]) -> Floats | float:
        """Return E* for samples of the elastic constants, divided by the E* of the study."""
        return self._inputs.relative_modulus(values)

    def find_areas(self, key: Any, response: ContactResponseToInputs, inputs: InputValues) -> AreasBeforeShear:
        """Return the true areas (µm²) before shear for each sample of the inputs.

        The areas are cached, because all mu0 share them.
        """
        return _get_cached(self._areas, key, MAX_CACHED_AREAS, partial(response.areas_before_shear, inputs))

    def find_yield_pressure(self, key: Any, response: ContactResponseToInputs, inputs: InputValues) -> Any:
        """Return the contact pressure (GPa) at which contacts yield, for each sample of the inputs.

        The pressures are cached for other loads with the same `key`.
        """
        return _get_cached(self._pressures, key, MAX_CACHED_PRESSURES, partial(response.yield_pressure, inputs))

    def find_closures(self, key: Any, response: ContactResponseToInputs, inputs: InputValues) -> Floats:
        """Return the closure of the gap (µm) at each computed load, for each sample of the inputs.

        The closures do not depend on mu0 and tau0. The closures of the last key are cached for other loads. Samples
        with the key None are evaluated every time.
        """
        if key is None or key != self._closures[0]:
            self._closures = key, response.closures_at_computed_loads(inputs)
        return self._closures[1]

    def _generate_samples(
        self, inputs: Mapping[str, UncertainInput], names: tuple[str, ...], fixed: Mapping[str, float]
    ) -> _InputSamples:
        from scipy.special import ndtri

        if fixed:
            # If some inputs are fixed, all other inputs and errors keep the samples drawn without fixed inputs.
            samples = self.draw_samples(inputs, names, _NO_FIXED_INPUTS)
            probabilities = {name: np.array([quantile]) for name, quantile in fixed.items() if name in names}
        else:
            points = generate_stratified_points(len(names) + 1)
            samples = _InputSamples(
                {}, {}, {}, 1.0, None if self._creep is None else self._creep.quantile(points[:, -1])
            )
            probabilities = dict(zip(names, points.T, strict=False))
        input_values = samples.values | {
            name: uncertain_input.quantile(probabilities[name])
            for name, uncertain_input in inputs.items()
            if name in probabilities
        }
        return replace(
            samples,
            probabilities=samples.probabilities | probabilities,
            scores=samples.scores
            | {name: ndtri(values) for name, values in probabilities.items() if name in SAMPLING_INPUT_NAMES},
            values=input_values,
            modulus=self._inputs.relative_modulus(input_values),
        )


def _get_cached(cache: dict[Any, _Value], key: Any, max_size: int, compute: Callable[[], _Value]) -> _Value:
    """Return the cached value of a key. If there is no cached value, compute and cache the value first.

    A full cache drops its oldest value.
    """
    if key not in cache:
        if len(cache) == max_size:
            cache.pop(next(iter(cache)))
        cache[key] = compute()
    return cache[key]


class CombinedIntervals:
    """Combined intervals of the quantities in an `at_load` dataset, for one load, μ0, τ0 and sliding rule.

    `central` contains the quantities at the central inputs of `response`. `names` lists the uncertain inputs and
    sources of sampling uncertainty; it is empty if there is no coefficient or no interval. `drifts` contains, by source
    of sampling uncertainty, the standard deviations of the logarithm of the slope of the gap between the scan of a part
    and the whole part. `inputs` are the uncertain inputs whose values the samples of `strengths` do not contain.
    `area_error` is the relative standard error of the true area, for samples with scores of this error.
    """

    def __init__(
        self, point: Mapping[str, Any], response: ContactResponseToInputs, central: ResponseValues, study: Study,
        inputs: Mapping[str, Any], sampler: InputSampler, strengths: Sequence[JointSamples] = (),
        scan_mean: ScanPairMean | None = None, drifts: Mapping[str, float] = MappingProxyType({}),
        area_error: float = 0.0,
    ) -> None:  # fmt: skip
        self.study, self.response, self._sampler = study, response, sampler
        self.mu0, self.tau0, self.rule = float(point["mu0"]), float(point["tau0"]), str(point["sliding"])
        self.sampling_estimate: Floats = point["mean_friction"]
        self.names: tuple[str, ...] = ()
        self.inputs: dict[str, UncertainInput] = {name: study_input.estimate for name, study_input in inputs.items()}
        # `strengths` has samples from the fit of mu0 and tau0, and then samples from fits with mu0 = 0 or tau0 = 0.
        self.strengths = strengths
        self.is_tested = any(samples.area_scores is not None for samples in strengths)
        self.area_error = area_error
        self.drifts = drifts
        self._central = central
        self._scan_mean = scan_mean
        value, lower, upper = self.sampling_estimate.tolist()
        # Two faces given by their gap have one relative position, so the mean over positions has no sampling error.
        if study.is_gap:
            lower = upper = value
        if not (value > 0 and math.isfinite(lower) and math.isfinite(upper)):
            return
        self.value, self.sampling = value, (lower, upper)
        # Range of the friction coefficients that finer scans could give, computed from the mean coefficient.
        self.finest: tuple[float, float] | None = None
        # Range of coefficients that finer scans could give; its upper end is computed from the mean's upper limit.
        self.bracket: tuple[float, float] | None = None
        is_nonadhesive_half_space = study.uses_half_space and not study.contact.adheres
        if study.contact.hardness is not None and is_nonadhesive_half_space and self.rule == "all":
            self.contacts = float(point["contact_count"][0]) * float(point["members"])
            bracket_inputs = self.mu0, float(self._central.plastic_friction) - self.mu0, self.contacts
            self.finest = friction_range_for_finer_scans(value, *bracket_inputs)
            self.bracket = friction_range_for_finer_scans(value, *bracket_inputs, upper)
        self.standard_errors = (
            {} if self.is_tested else self._split_relative_error_by_source(*self.sampling, self.value)
        )
        self.scatter, self.freedom = self._find_test_scatter(point)
        is_unresolved = self.finest is not None and self.finest[1] > self.finest[0]
        # The mu0 and tau0 of an interface calibrated on this pair already include the errors of the pair's true area.
        sources = (*self.standard_errors, *self.drifts, *((UNRESOLVED_ROUGHNESS_INPUT_NAME,) if is_unresolved else ()))
        self.names = (
            *self.inputs,
            *((INTERFACE_INPUT_NAME,) if self.strengths else ()),
            *dict.fromkeys(() if self.is_tested else sources),
        )

    def _split_relative_error_by_source(self, lower: float, upper: float, value: float) -> dict[str, float]:
        """Split the relative standard error of a mean into the errors from upper scans, lower scans and positions.

        Zeros are omitted.
        """
        relative_width = math.log(upper / lower) if lower > 0 else (upper - lower) / value
        relative_error = relative_width / (2 * Z_95)
        if self._scan_mean is None:
            return {POSITIONS_INPUT_NAME: relative_error} if relative_error > 0 else {}
        total_deviation = math.sqrt(sum(self._scan_mean.variances)) or 1.0
        relative_errors = [
            relative_error * math.sqrt(variance) / total_deviation for variance in self._scan_mean.variances
        ]
        return {
            name: relative_error
            for name, relative_error in zip(SAMPLING_INPUT_NAMES, relative_errors, strict=True)
            if relative_error > 0
        }

    def _find_test_scatter(self, point: Mapping[str, Any]) -> tuple[float, float]:
        """Return the relative standard deviation of friction coefficients in single tests, and its degrees of freedom.

        A single test is a test of one new member in one direction.
        """
        if self._scan_mean is not None:
            return self._scan_mean.test / self.value, min(self._scan_mean.test_freedom, MAX_DEGREES_OF_FREEDOM)
        num_members = int(point["ok"].min())
        spread = 0.0 if self.study.is_gap else float(point["spread_high"]) - float(point["spread_low"])
        relative_deviation = spread / (NORMAL_DECILE_RANGE * self.value)
        return relative_deviation * math.sqrt(1 + 1 / max(num_members, 1)), float(max(num_members - 1, 1))

    # ---- Friction ----------------------------------------------------------------------------------------------------

    def estimate_zero_coefficient(self) -> tuple[float, float, float]:
        """Return a friction coefficient of 0 with its 95 % limits, or NaN if the coefficient is not 0.

        Relative errors of such a coefficient are undefined. Therefore, the interval is computed from samples of mu0 and
        tau0. It contains the coefficient and the interval of its mean, and its lower limit is at least 0. The result is
        NaN if the coefficient is not 0, or if neither mu0 nor tau0 is uncertain.
        """
        is_zero = (np.abs(self.sampling_estimate) < NEGLIGIBLE_COEFFICIENT).all()
        if not is_zero or not {"mu0", "tau0"} & self.inputs.keys():
            return math.nan, math.nan, math.nan
        unit_points = generate_stratified_points(2)
        mu0, tau0 = (
            self.inputs[name].quantile(unit_points[:, column]) if name in self.inputs else value
            for column, (name, value) in enumerate((("mu0", self.mu0), ("tau0", self.tau0)))
        )
        coefficients = np.broadcast_to(FrictionLaw(mu0, tau0).coefficient(self.response.sums), (NUM_INPUT_SAMPLES,))
        value, lower, upper = self.sampling_estimate.tolist()
        lower_limit, upper_limit = compute_equal_tailed_interval(coefficients).extended_to(
            (value, value), (lower, upper)
        )
        return value, max(lower_limit, 0.0), upper_limit

    def interval(self, fixed: Mapping[str, float] = _NO_FIXED_INPUTS) -> Interval:
        """Return the combined 95 % interval of the coefficient, with each input in `fixed` held at a given quantile.

        The interval contains the coefficient. Unless `fixed` contains these sources, it also contains the interval of
        the mean and the range of coefficients for finer scans.
        """
        included_intervals = [(self.value, self.value)]
        if self.is_tested:
            return self._compute_sampled_interval(fixed).extended_to(*included_intervals)
        if not set(fixed) & set(SAMPLING_INPUT_NAMES):
            included_intervals.append(self.sampling)
        if UNRESOLVED_ROUGHNESS_INPUT_NAME not in fixed and self.finest is not None and self.bracket is not None:
            included_intervals.append(self.finest if set(fixed) & set(SAMPLING_INPUT_NAMES) else self.bracket)
        return self._compute_sampled_interval(fixed).extended_to(*included_intervals)

    def remaining_interval_width(self, name: str) -> float:
        """Return the width of the combined interval that would remain if the input `name` were exact.

        The width is a mean over quantiles at which the input is fixed. Widths are compared as differences of the
        friction angle, which stays finite if samples seize.
        """
        friction_angle_widths = [
            _compute_friction_angle_difference(self._compute_sampled_interval({name: quantile}))
            for quantile in FIXED_INPUT_QUANTILES
        ]
        (lower, upper), sampled_width = (
            self.interval(),
            _compute_friction_angle_difference(self._compute_sampled_interval({})),
        )
        return (
            min(float(np.mean(friction_angle_widths)) / sampled_width, 1.0) * (upper - lower)
            if sampled_width > 0
            else upper - lower
        )

    @property
    def unlimited_fraction(self) -> float:
        """Fraction of the input samples that give friction without an upper limit."""
        if "junction_growth" not in self.inputs and not np.any(self.response.central.junction_growth):
            return 0.0
        return float(np.isinf(self._sample_friction({})[1]).mean())

    def predict_next_test(self) -> Interval:
        """Return the 95 % prediction interval for the coefficient of one further test in one direction of motion."""
        first_interval, *other_intervals = (
            compute_equal_tailed_interval(*samples, coverage)
            for samples, coverage in zip(self._next_test_samples, self._coverages, strict=True)
        )
        return first_interval.extended_to(
            *other_intervals, (self.value, self.value), *self._intervals_without_upper_limit
        )

    def predict_percentiles(self) -> Floats:
        """Return the 5th, 50th and 95th percentile of the friction coefficients that single tests would measure.

        The range of the percentiles encloses the mean coefficient.
        """
        probabilities = FRICTION_PERCENTILES / 100
        percentiles_by_strength = [
            compute_quantiles(
                probabilities
                if coverage == INTERVAL_COVERAGE
                else 0.5 + (probabilities - 0.5) * coverage / INTERVAL_COVERAGE,
                *samples,
            )
            for samples, coverage in zip(self._next_test_samples, self._coverages, strict=True)
        ]
        value = np.where(FRICTION_PERCENTILES == 50.0, np.nan, self.value)
        return extend_percentiles(percentiles_by_strength[0], [*percentiles_by_strength[1:], value])

    @cached_property
    def _next_test_samples(self) -> list[tuple[Floats, Floats]]:
        """Samples of the coefficient that one further friction test would measure, and of its upper limit.

        Student's t distribution applies to the logarithm of the coefficient, so that the coefficient is above 0. The
        test is at another place of a body whose roughness drifts, so that the drift counts twice. The list has one pair
        of arrays. For a calibrated interface, further pairs have mu0 = 0 or tau0 = 0.
        """
        scores = _compute_test_scores(self.freedom, len(self.names) + 1)
        log_scatter = math.sqrt(math.log1p(self.scatter**2))
        factor = np.exp(np.minimum(scores * log_scatter, MAX_LOG_COEFFICIENT_RATIO))
        fixed_quantiles = {name: 0.5 for name in self.standard_errors if name not in self.drifts}
        return self._sample_all_strengths(fixed_quantiles, factor=factor, drift_factor=math.sqrt(2))

    def friction_after_dwell(self, dwell_time: float) -> tuple[float, float, float]:
        """Return the coefficient after a dwell time (s), followed by the limits of the combined 95 % interval.

        The coefficient is NaN if the nominal pressure reaches the hardness.
        """
        creep, central_inputs = Inputs.from_study(self.study).estimate("creep"), self.response.central
        assert creep is not None, "a study with dwell times has a creep exponent"
        final_hardness = central_inputs.hardness * dwell_time**-creep.value
        if self.response.load / self.response.area.nominal_area >= final_hardness:
            return math.nan, math.nan, math.nan
        final = self.response.at_central_inputs(hardness=final_hardness)
        ratio = float(final.friction_coefficient / self._central.friction_coefficient)
        if not math.isfinite(ratio):
            return math.nan, math.nan, math.nan
        value = self.value * ratio
        upper = math.inf if final.has_no_upper_limit else value
        return value, *self._compute_interval_of_samples({}, dwell_time).extended_to((value, upper))

    # ---- Other quantities --------------------------------------------------------------------------------------------

    def widen_quantity_intervals(self, estimates: Mapping[str, Floats]) -> dict[str, Floats]:
        """Widen the intervals of contact quantities to include the effect of uncertain inputs.

        `estimates` contains the mean and the interval of the mean of each quantity, by name. An interval that cannot be
        computed stays an interval of the mean.
        """
        names = (*self.inputs, *((INTERFACE_INPUT_NAME,) if self.strengths else ()), *self.drifts)
        if not names:
            return dict(estimates)
        sampled_names = (*names, POSITIONS_INPUT_NAME)
        inputs, samples = self._sample_inputs({}, names=sampled_names)
        values = self.response.evaluate(inputs, *self._find_cached_areas_and_pressures(inputs, sampled_names))
        ratios = compute_quantity_ratios(self.response, inputs, values, self._central)
        if "closure" in estimates and self.response.closure_curve is not None:
            closures_key = None if self.strengths else (id(self.response.closure_curve), names)
            closures = self._sampler.find_closures(closures_key, self.response, inputs)
            ratios["closure"] = self.response.gap_closure_ratio(inputs, closures)
        combined_estimates = {}
        for name, estimate in estimates.items():
            value, lower, upper = estimate.tolist()
            combined_estimates[name] = estimate
            ratio = ratios.get(COMBINED_QUANTITIES[name])
            if ratio is None or not value > 0:
                continue
            if not (math.isfinite(lower) and math.isfinite(upper)):
                if not self.study.is_gap:
                    continue
                lower = upper = value
            relative_errors = self._split_relative_error_by_source(lower, upper, value)
            score = samples.scores[POSITIONS_INPUT_NAME] * math.hypot(*relative_errors.values())
            quantity_samples = np.broadcast_to(value * ratio * np.exp(score), (NUM_INPUT_SAMPLES,))
            if np.isnan(quantity_samples).any():
                continue
            lower_limit, upper_limit = compute_equal_tailed_interval(quantity_samples).extended_to((lower, upper))
            limit = find_upper_bound(name, self.response.area.nominal_area, uses_half_space=self.study.uses_half_space)
            combined_estimates[name] = np.array([value, lower_limit, max(min(upper_limit, limit), value)])
        return combined_estimates

    # ---- Samples -----------------------------------------------------------------------------------------------------

    def _compute_sampled_interval(self, fixed: Mapping[str, float]) -> Interval:
        if self.names == tuple(self.standard_errors) and not fixed and not self.drifts:
            upper = math.inf if self._central.has_no_upper_limit else self.sampling[1]
            return Interval(max(self.sampling[0], 0.0), upper)
        return self._compute_interval_of_samples(fixed)

    def _compute_interval_of_samples(self, fixed: Mapping[str, float], dwell_time: float = 1.0) -> Interval:
        """Sample the uncertain inputs, and return the 95 % interval of the resulting friction coefficients.

        For a calibrated interface, the interval also includes the intervals for mu0 = 0 and for tau0 = 0, if the tests
        permit such an interface. The interval is cached for further evaluations of the same coefficient, possibly
        together with other coefficients.
        """
        response = self.response
        # Beyond its 12th decimal, the estimate has round-off that depends on other coefficients, so the key is rounded.
        estimate = self.sampling_estimate.round(12).tobytes()
        coefficient = response.load, id(response.area), self.rule, self.mu0, self.tau0, estimate
        interval_key = coefficient, self.names, (*fixed.items(),), dwell_time
        if interval_key not in self._sampler.intervals:
            all_samples = self._sample_all_strengths(fixed, dwell_time)
            first_interval, *other_intervals = (
                compute_equal_tailed_interval(*samples, coverage)
                for samples, coverage in zip(all_samples, self._coverages, strict=False)
            )
            self._sampler.intervals[interval_key] = first_interval.extended_to(
                *other_intervals, *self._intervals_without_upper_limit
            )
        return self._sampler.intervals[interval_key]

    @property
    def _coverages(self) -> list[float]:
        """Fraction of samples, such as 0.95, that the interval for each entry in `strengths` must contain."""
        return [each.coverage for each in self.strengths] or [INTERVAL_COVERAGE]

    @property
    def _intervals_without_upper_limit(self) -> list[Interval]:
        """List with the interval [value, ∞) if friction at the central inputs has no upper limit; otherwise empty."""
        return [Interval(self.value, math.inf)] if self._central.has_no_upper_limit else []

    def _sample_all_strengths(
        self, fixed: Mapping[str, float], dwell_time: float = 1.0, factor: Floats | float = 1.0,
        drift_factor: float = 1.0,
    ) -> list[tuple[Floats, Floats]]:  # fmt: skip
        """Return, for each set of (mu0, tau0) samples, an array of friction coefficients and an array of upper limits.

        All samples are multiplied by `factor`.
        """
        num_strengths = 1 if INTERFACE_INPUT_NAME in fixed else max(len(self.strengths), 1)
        samples = (self._sample_friction(fixed, dwell_time, index, drift_factor) for index in range(num_strengths))
        return [(lower * factor, upper * factor) for lower, upper in samples]

    def _sample_friction(
        self, fixed: Mapping[str, float], dwell_time: float = 1.0, strength_index: int = 0, drift_factor: float = 1.0
    ) -> tuple[Floats, Floats]:
        """Return samples of the friction coefficient and of its upper limit, which may be infinite.

        `strength_index` selects an entry of `strengths`, if there are any. If unresolved roughness may change the
        coefficient, the samples are spread between the lowest and the highest coefficient for finer scans.
        """
        inputs, samples = self._sample_inputs(fixed, dwell_time, strength_index, drift_factor)
        known_values = self._find_cached_areas_and_pressures(inputs, self.names, fixed, dwell_time, drift_factor)
        contact_quantities = self.response.evaluate(inputs, *known_values)
        is_seized = np.isinf(contact_quantities.friction_coefficient)
        coefficients = self.value * (
            np.where(is_seized, 1.0, contact_quantities.friction_coefficient) / self._central.friction_coefficient
        )
        fractions = samples.probabilities.get(UNRESOLVED_ROUGHNESS_INPUT_NAME)
        if fractions is not None and self.finest is not None:
            plastic_friction = np.where(is_seized, inputs.mu0, contact_quantities.plastic_friction)
            lowest_coefficients = np.minimum(plastic_friction, coefficients)
            highest_coefficients = np.maximum(
                max_friction_for_finer_scans(
                    coefficients, inputs.mu0, plastic_friction - inputs.mu0, self.contacts
                ), lowest_coefficients,
            )  # fmt: skip
            coefficients = lowest_coefficients + fractions * (highest_coefficients - lowest_coefficients)
        coefficients = coefficients * np.exp(
            sum(error * samples.scores[name] for name, error in self.standard_errors.items())
        )
        coefficients = np.where(is_seized, np.inf, np.maximum(coefficients, 0.0))
        coefficients = np.broadcast_to(coefficients, (NUM_INPUT_SAMPLES,))
        has_no_limit = contact_quantities.has_no_upper_limit & ~is_seized
        return coefficients, np.where(has_no_limit, np.inf, coefficients) if has_no_limit.any() else coefficients

    def _find_cached_areas_and_pressures(
        self, inputs: InputValues, names: tuple[str, ...], fixed: Mapping[str, float] = _NO_FIXED_INPUTS,
        dwell_time: float = 1.0, drift_factor: float = 1.0,
    ) -> tuple[AreasBeforeShear | None, Any]:  # fmt: skip
        """Return the true area before shear and the yield pressure for each input sample. Both arrays are cached.

        Returns None for both with a calibrated interface.

        The areas are the same for all mu0 and tau0. The pressures are the same for all loads, unless the hardness
        depends on the depth of the contacts. The samples of a calibrated interface may include the hardness, so neither
        is cached.
        """
        if self.strengths:
            return None, None
        response, sampler = self.response, self._sampler
        contact = response.load, id(response.area)
        samples = tuple(self.inputs), names, (*fixed.items(),), dwell_time
        areas = sampler.find_areas((*contact, *samples, drift_factor), response, inputs)
        depth_key = () if response.area.indent is None else contact
        return areas, sampler.find_yield_pressure((*depth_key, *samples, self.mu0, self.tau0), response, inputs)

    def _sample_inputs(
        self, fixed: Mapping[str, float], dwell_time: float = 1.0, strength_index: int = 0, drift_factor: float = 1.0,
        names: tuple[str, ...] | None = None,
    ) -> tuple[InputValues, _InputSamples]:  # fmt: skip
        samples = self._sampler.draw_samples(self.inputs, self.names if names is None else names, fixed)
        drifts = {name: deviation for name, deviation in self.drifts.items() if name in samples.scores}
        drift = sum(drift_factor * deviation * samples.scores[name] for name, deviation in drifts.items())
        input_values = {
            name: samples.values.get(name, getattr(self.response.central, name)) for name in _RESPONSE_INPUT_NAMES
        }
        if samples.creep is not None and dwell_time != 1.0:
            input_values["hardness"] = input_values["hardness"] * dwell_time**-samples.creep
        height_factor = np.exp(drift) if drifts else 1.0
        inputs = InputValues(
            **input_values, uses_slip_lines=self.response.central.uses_slip_lines, modulus=samples.modulus,
            height_factor=height_factor,
        )  # fmt: skip
        if self.strengths:
            inputs = self._insert_interface_samples(inputs, samples, strength_index)
        return inputs, samples

    def _insert_interface_samples(
        self, inputs: InputValues, samples: _InputSamples, strength_index: int
    ) -> InputValues:
        """Return a copy of the inputs with joint samples of mu0, tau0 and the inputs shared with the friction tests.

        The joint samples are sorted by the coefficient that they give, so quantiles of the joint samples are also
        quantiles of the coefficient.
        """
        joint, central = self.strengths[strength_index], self.response.central
        joint_values = {"mu0": joint.mu0, "tau0": joint.tau0, **joint.inputs}
        changes: dict[str, Any] = {
            name: sample_values for name, sample_values in joint_values.items() if name in _RESPONSE_INPUT_NAMES
        }
        if joint.area_scores is not None:
            changes["area_ratio"] = np.exp(self.area_error * joint.area_scores)
        moduli = {name: sample_values for name, sample_values in joint_values.items() if name not in changes}
        if moduli:
            changes["modulus"] = self._sampler.relative_modulus(moduli)
        values = self.response.evaluate(replace(central, **changes))
        order = np.argsort(np.where(values.has_no_upper_limit, np.inf, values.friction_coefficient))
        indices = order[(samples.probabilities[INTERFACE_INPUT_NAME] * order.size).astype(int)]
        changes = {name: sample_values[indices] for name, sample_values in changes.items()}
        if moduli:
            selected_moduli = {name: sample_values[indices] for name, sample_values in moduli.items()}
            changes["modulus"] = self._sampler.relative_modulus(samples.values | selected_moduli)
        if "hardness" in changes:
            changes["hardness"] = changes["hardness"] * inputs.hardness / central.hardness
        return replace(inputs, **changes)


@lru_cache(maxsize=8)
def _compute_test_scores(freedom: float, num_dimensions: int) -> Floats:
    """Return stratified samples of Student's t distribution with `freedom` degrees of freedom."""
    from scipy.special import stdtrit

    return make_read_only(np.asarray(stdtrit(freedom, generate_stratified_points(num_dimensions)[:, -1])))


def _compute_friction_angle_difference(ends: tuple[float, float]) -> float:
    """Convert both limits of an interval of coefficients to friction angles, and return their difference (rad)."""
    return math.atan(ends[1]) - math.atan(ends[0])


def compute_equal_tailed_interval(
    values: NDArray[Any], upper_values: NDArray[Any] | None = None, coverage: float = INTERVAL_COVERAGE
) -> Interval:
    """Return the equal-tailed interval that contains the fraction `coverage` of samples; see `compute_quantiles`.

    Raises
    ------
    ValueError
        If a sample has no coefficient.
    """
    return Interval(*compute_quantiles(find_tail_probabilities(coverage), values, upper_values).tolist())


def compute_quantiles(
    probabilities: Floats, values: NDArray[Any], upper_values: NDArray[Any] | None = None, axis: int | None = None
) -> Floats:
    """Return quantiles of samples along an axis.

    Samples may be infinite.

    If `upper_values` are given, quantiles above the median are computed from `upper_values`.

    Raises
    ------
    ValueError
        If a sample has no coefficient.
    """
    if np.isnan(values).any():
        num_undefined = int(np.count_nonzero(np.isnan(values)))
        raise ValueError(
            f"the inputs are too uncertain, because the coefficient is undefined for {num_undefined} of {values.size} "
            "samples of the inputs; specify narrower ranges of the inputs"
        )

    # If samples are infinite, quantiles are not interpolated: an interpolation between two infinite samples gives NaN.
    method: Literal["inverted_cdf", "linear"] = "inverted_cdf" if np.isinf(values).any() else "linear"
    if upper_values is None or upper_values is values or not np.isinf(upper_values).any():
        return _find_quantiles(probabilities, values, axis, method)
    is_upper = probabilities > 0.5
    lower_quantiles = _find_quantiles(probabilities[~is_upper], values, axis, method)
    upper_quantiles = _find_quantiles(probabilities[is_upper], upper_values, axis, "inverted_cdf")
    quantiles = np.empty((probabilities.size, *np.shape(lower_quantiles)[1:]))
    quantiles[~is_upper], quantiles[is_upper] = lower_quantiles, upper_quantiles
    return quantiles


def _find_quantiles(
    probabilities: Floats, values: NDArray[Any], axis: int | None, method: Literal["inverted_cdf", "linear"]
) -> Floats:
    """Compute the same quantiles as `numpy.quantile`, but about five times as fast if `axis` is None.

    `numpy.partition` uses SIMD instructions only for a single index, and `numpy.quantile` passes several indices.
    """
    if axis is not None:
        return np.asarray(np.quantile(values, probabilities, axis=axis, method=method))
    find_quantile = _interpolate_quantile if method == "linear" else _select_quantile
    return np.array([find_quantile(probability, values.ravel()) for probability in probabilities])


def _select_quantile(probability: float, values: NDArray[Any]) -> float:
    """Return the smallest sample at which the empirical distribution function reaches a probability."""
    index = max(math.ceil(probability * values.size - 1), 0)
    return float(np.partition(values, index)[index])


def _interpolate_quantile(probability: float, values: NDArray[Any]) -> float:
    """Return a quantile by linear interpolation between samples. The samples must be finite."""
    position = probability * (values.size - 1)
    index = int(position)
    weight = position - index
    partitioned_values = np.partition(values, index)
    value_below = partitioned_values[index]
    value_above = partitioned_values[index + 1 :].min() if weight > 0 else value_below
    return float(
        value_below + (value_above - value_below) * weight
        if weight < 0.5
        else value_above - (value_above - value_below) * (1 - weight)
    )


def extend_percentiles(percentiles: Floats, other_percentiles: Iterable[Floats]) -> Floats:
    """Lower the percentiles below the median, and raise those above it, to include all `other_percentiles`.

    The median, and missing percentiles, are kept. NaN in the other percentiles is ignored.
    """
    all_percentiles = np.array([percentiles, *other_percentiles])
    with np.errstate(invalid="ignore"):
        lowest, highest = np.fmin.reduce(all_percentiles), np.fmax.reduce(all_percentiles)
    extended_percentiles = np.where(
        FRICTION_PERCENTILES < 50.0, lowest, np.where(FRICTION_PERCENTILES > 50.0, highest, percentiles)
    )
    return np.where(np.isnan(percentiles), percentiles, extended_percentiles)
