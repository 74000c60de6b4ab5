"""Samples of the inputs of a friction coefficient, and the intervals that are computed from them.

The uncertain inputs, the scatter between positions, and the unresolved roughness are propagated by sampling (JCGM 101,
2008). The forces are linear in mu0 and tau0, and the true area is interpolated as a function of the hardness. By
similarity, the solution at (F, E*, H) equals the solution at (cF, cE*, cH).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._estimate import Interval
from stiction.evaluate.hardness_nodes import AreaInterpolator
from stiction.evaluate.intervals import MAX_DEGREES_OF_FREEDOM, ScanPairMean
from stiction.mechanics.brackets import friction_range_for_finer_scans, max_friction_for_finer_scans
from stiction.mechanics.closed_forms import solve_yield_condition
from stiction.mechanics.friction import NEGLIGIBLE_COEFFICIENT, ForcesPerLoad
from stiction.study.input_distributions import NUM_INPUT_SAMPLES, Z_95, UncertainInput, generate_stratified_points
from stiction.study.uncertain_inputs import compute_relative_modulus, find_creep_exponent, find_junction_growth

if TYPE_CHECKING:
    from stiction.study.study import Study

POSITIONS_INPUT_NAME, UNRESOLVED_ROUGHNESS_INPUT_NAME = "positions", "unresolved roughness"
UPPER_SCANS_INPUT_NAME, LOWER_SCANS_INPUT_NAME = "which piece of the upper part", "which piece of the lower part"
SAMPLING_INPUT_NAMES = (UPPER_SCANS_INPUT_NAME, LOWER_SCANS_INPUT_NAME, POSITIONS_INPUT_NAME)
"""Sources of uncertainty that are not inputs of the study: the choice of scans and of positions."""

INTERFACE_INPUT_NAME = "interface"  # name of the input that combines mu0 and tau0
# quantiles of an input; the uncertainty budget is computed with the input fixed at each of these quantiles
FIXED_INPUT_QUANTILES = (0.1, 0.5, 0.9)

# mu0 or tau0 counts as equal to its value in the study up to this relative difference
SAME_INPUT_TOLERANCE = 1e-3
# upper bound on ln(coefficient of a single test / mean coefficient), which prevents overflow
MAX_LOG_COEFFICIENT_RATIO = 50.0
# a bound on the tail is estimated from a subsample that contains one in this number of samples
TAIL_SUBSAMPLING_STRIDE = 61
_LOG_SLOPE_STEP = 0.05  # change of ln(slope) from which the sensitivity of the coefficient to the slope is computed
NORMAL_DECILE_RANGE = 2.563103131089201
"""Distance between the 10th and the 90th percentile of a normal distribution, in standard deviations."""

StrengthArrays = tuple[Floats, Floats, Floats | None, Floats | None]
"""Samples of mu0, tau0 (GPa), hardness (GPa) and α of junction growth. Each of the last two may be None."""


class CoefficientSamples:
    """Friction coefficient returned by `at_load`, and the input samples from which its interval is computed.

    `names` lists the uncertain inputs and sources of sampling uncertainty; it is empty if there is no coefficient or no
    interval. `drifts` contains, by source of sampling uncertainty, the standard deviations of the logarithm of the
    slope of the gap between the scan of a part and the whole part.
    """

    def __init__(
        self, point: Mapping[str, Any], load: int, study: Study, inputs: Mapping[str, Any], friction: ForcesPerLoad,
        areas: AreaInterpolator, strengths: Sequence[StrengthArrays] = (), scan_mean: ScanPairMean | None = None,
        drifts: Mapping[str, float] = MappingProxyType({}),
    ) -> None:  # fmt: skip
        self.study, self.friction, self.areas, self.load = study, friction, areas, load
        self.mu0, self.tau0, self.rule = float(point["mu0"]), float(point["tau0"]), str(point["sliding"])
        self.sampling_estimate: Floats = point["mean_friction"]  # coefficient and limits of its sampling interval
        self.names: tuple[str, ...] = ()
        self.inputs: dict[str, UncertainInput] = {name: each.estimate for name, each in inputs.items()}
        # The first entry contains joint samples of mu0 and tau0.
        # In each of the other entries, mu0 or tau0 equals its bound.
        self.strengths = self._drop_inputs_of_other_strengths(strengths)
        value, lower, upper = self.sampling_estimate.tolist()
        if study.is_gap:  # a gap has only one relative position
            lower = upper = value
        if not (value > 0 and math.isfinite(lower) and math.isfinite(upper)):
            return
        self.value, self.sampling = value, (lower, upper)
        self.growth = find_junction_growth(study)  # estimate of the junction-growth coefficient α
        # ratio of true areas with and without junction growth
        self.own_growth = float(point.get("area_growth", 1.0))
        # range of coefficients that finer scans could give
        self.finest: tuple[float, float] | None = None
        # the same range, widened by the confidence interval due to sampling
        self.bracket: tuple[float, float] | None = None
        is_nonadhesive_half_space = study.uses_half_space and not study.contact.adheres
        if study.contact.hardness is not None and is_nonadhesive_half_space and self.rule == "all":
            self.contacts = float(point["contact_count"][0]) * float(point["members"])
            bracket_inputs = self.mu0, self.tau0 / float(point["sheared_pressure"]), self.contacts
            self.finest = friction_range_for_finer_scans(value, *bracket_inputs)
            self.bracket = friction_range_for_finer_scans(value, *bracket_inputs, upper)
        # relative standard errors due to the drift of the roughness along single scans
        self.drift_errors = self._find_drift_errors(drifts)
        self.standard_errors = self._find_standard_errors(scan_mean) | self.drift_errors
        self.scatter, self.freedom = self._find_scatter(point, scan_mean)
        is_unresolved = self.finest is not None and self.finest[1] > self.finest[0]
        self.names = (
            *self.inputs,
            *((INTERFACE_INPUT_NAME,) if self.strengths else ()),
            *self.standard_errors,
            *((UNRESOLVED_ROUGHNESS_INPUT_NAME,) if is_unresolved else ()),
        )

    def _drop_inputs_of_other_strengths(self, strengths: Sequence[StrengthArrays]) -> Sequence[StrengthArrays]:
        """Drop mu0 or tau0 from the inputs if its value differs from the value in the study.

        A range in the study does not apply to other values of mu0 or tau0. Joint samples are then dropped too; the
        remaining joint samples are returned.
        """
        for name, value in (("mu0", self.mu0), ("tau0", self.tau0)):
            if self.study.friction.interface is None and name not in self.inputs:
                continue
            study_value = float(getattr(self.study.friction, name)[0])
            if abs(study_value - value) > SAME_INPUT_TOLERANCE * value:
                self.inputs.pop(name, None)
                strengths = ()
        return strengths

    def _find_standard_errors(self, scan_mean: ScanPairMean | None) -> dict[str, float]:
        """Return the nonzero relative standard errors of the mean due to the choice of scans and positions."""
        lower, upper = self.sampling
        relative_width = math.log(upper / lower) if lower > 0 else (upper - lower) / self.value
        error = relative_width / (2 * Z_95)
        if scan_mean is None:
            return {POSITIONS_INPUT_NAME: error} if error > 0 else {}
        total_deviation = math.sqrt(sum(scan_mean.variances)) or 1.0
        errors = [error * math.sqrt(variance) / total_deviation for variance in scan_mean.variances]
        return {name: each for name, each in zip(SAMPLING_INPUT_NAMES, errors, strict=True) if each > 0}

    def _find_drift_errors(self, drifts: Mapping[str, float]) -> dict[str, float]:
        """Return the nonzero relative standard errors of the coefficient due to drifts of the roughness.

        The drifts are standard deviations of the logarithm of the slope of the gap, by source. Multiplying all heights
        by a factor changes the true area in the same way as multiplying E* by this factor.
        """
        if not drifts:
            return {}
        hardness = None if self.areas.hardness is None else np.array([self.areas.hardness])
        smoother, rougher = (
            float(
                self.friction.compute_coefficient(
                    self.mu0,
                    self.tau0,
                    self.areas.area_ratio(self.load, hardness, math.exp(log_factor))[0] * self.own_growth,
                )
            )
            for log_factor in (-_LOG_SLOPE_STEP, _LOG_SLOPE_STEP)
        )
        if not smoother > rougher > 0:
            return {}
        sensitivity = math.log(smoother / rougher) / (2 * _LOG_SLOPE_STEP)
        return {name: sensitivity * drift for name, drift in drifts.items()}

    def _find_scatter(self, point: Mapping[str, Any], scan_mean: ScanPairMean | None) -> tuple[float, float]:
        """Return the relative standard deviation of single tests from the mean, and its degrees of freedom.

        A single test is a test of one new member in one direction.
        """
        if scan_mean is not None:
            return scan_mean.test / self.value, min(scan_mean.test_freedom, MAX_DEGREES_OF_FREEDOM)
        num_members = int(point["ok"].min())
        spread = 0.0 if self.study.is_gap else float(point["spread_high"]) - float(point["spread_low"])
        deviation = spread / (NORMAL_DECILE_RANGE * self.value)
        return deviation * math.sqrt(1 + 1 / max(num_members, 1)), float(max(num_members - 1, 1))

    def estimate_zero_coefficient(self) -> tuple[float, float, float]:
        """Return the 95 % interval of a coefficient that is 0 at the central inputs, after the coefficient itself.

        Relative errors of such a coefficient are undefined. The interval contains the coefficient and its sampling
        interval, and is not below 0. The result is NaN if the coefficient is not 0, or if neither mu0 nor tau0 is
        uncertain.
        """
        is_zero = (np.abs(self.sampling_estimate) < NEGLIGIBLE_COEFFICIENT).all()
        if not is_zero or not {"mu0", "tau0"} & self.inputs.keys():
            return math.nan, math.nan, math.nan
        unit_points = generate_stratified_points(2)
        mu0, tau0 = (
            self.inputs[name].quantile(unit_points[:, column]) if name in self.inputs else value
            for column, (name, value) in enumerate((("mu0", self.mu0), ("tau0", self.tau0)))
        )
        coefficients = np.broadcast_to(self.friction.compute_coefficient(mu0, tau0), (NUM_INPUT_SAMPLES,))
        value, lower, upper = self.sampling_estimate.tolist()
        low, high = compute_equal_tailed_interval(coefficients).extended_to((value, value), (lower, upper))
        return value, max(low, 0.0), high

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
        if self.names == tuple(self.standard_errors) and not fixed and not self.drift_errors:
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
            compute_equal_tailed_interval(self._compute_friction_samples(fixed, wait, index) * factor)
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
        # The next test is at another place of a part whose roughness drifts.
        place_scatter = sum(error**2 for error in self.drift_errors.values())
        scatter = math.sqrt(math.log1p(self.scatter**2 + place_scatter))
        factor = np.exp(np.minimum(scores * scatter, MAX_LOG_COEFFICIENT_RATIO))
        fixed = {name: 0.5 for name in self.standard_errors if name not in self.drift_errors}
        interval = self._compute_scaled_interval(fixed, factor=factor)
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
        """Return samples of the coefficient without sampling uncertainty, range widths, and a mask of seizing samples.

        If unresolved roughness may change the coefficient, the samples are the lowest coefficients for finer scans,
        and the range widths are the differences between the highest and the lowest. Otherwise, the range widths are
        None. The mask is None if no sample seizes.
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


def compute_equal_tailed_interval(values: NDArray[Any]) -> Interval:
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
