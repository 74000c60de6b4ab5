"""95 % intervals for a shear test, from uncertain inputs and from differences between strips of the two faces.

Inputs are propagated by sampling (JCGM 101, 2008). μ0 and τ0 enter at the solved contacts. The hardness and E* change
the contacts, so the test is repeated at both limits of each of these inputs, and the curves are interpolated.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction._estimate import extend_intervals
from stiction.evaluate.budget import find_inputs_and_strengths
from stiction.evaluate.combined_intervals import compute_quantiles
from stiction.mechanics.friction import LOAD_SUM_NAMES, STATUS_DOWNHILL, STATUS_OK, STATUS_SELF_LOCKED, FrictionLaw
from stiction.mechanics.shear import CLOSURE_NAMES, ShearBox, compute_dilation_angles
from stiction.study.input_distributions import NUM_INPUT_SAMPLES, generate_sobol_points
from stiction.study.inputs import Inputs
from stiction.study.interfaces import INTERVAL_COVERAGE, InterfaceStrength, find_tail_probabilities

if TYPE_CHECKING:
    import xarray as xr

MIN_INPUT_SAMPLES = 2**10
# Maximum product of the numbers of input samples and displacements; the product determines the memory use.
MAX_CURVE_VALUE_COUNT = 2**21
CONTACT_INPUTS = ("hardness", "effective_modulus")
"""Inputs that change the contact solution, so that the shear test is repeated at both ends of their ranges."""

MIN_WEIGHT_NEAR_LIMIT = 0.5
"""Weight of an input limit above which a sample of the input has no value if the limit has none."""

CURVE_NAMES = ("friction_coefficient", "shear_stress", "dilation")
"""Names of the quantities that have an interval at each displacement of a shear test."""

SHEAR_INTERVAL_ATTRIBUTES = ("peak", "peak_displacement_um", "peak_dilation_angle_deg", "peak_shear_stress_GPa", "end")
"""Names of the dataset attributes of a shear test that have an interval."""

# Arrays keyed by quantity. The first axis of each array runs over random input samples or over strips of the faces.
_Samples = dict[str, Floats]


@dataclass(frozen=True)
class ShearInputSamples:
    """Samples of the inputs of a shear test, with the same number of samples for each input.

    `contact_inputs` contains the uncertain inputs among `CONTACT_INPUTS`, relative to their central values.
    `probabilities` are cumulative probabilities of another quantity, which is independent of the inputs. `coverage` is
    the probability of the samples that a 95 % interval contains, as in `JointSamples`.
    """

    mu0: Floats
    tau0: Floats
    contact_inputs: Mapping[str, Floats]
    probabilities: Floats
    coverage: float = INTERVAL_COVERAGE


def _generate_sample_points(dimensions: int, num_displacements: int) -> Floats:
    """Return points of a Sobol sequence, one point per sample of the inputs.

    The number of samples decreases with the number of displacements.
    """
    count = min(NUM_INPUT_SAMPLES, 2 ** int(math.log2(MAX_CURVE_VALUE_COUNT / num_displacements)))
    return generate_sobol_points(dimensions, max(count, MIN_INPUT_SAMPLES), seed=2016)


def draw_shear_samples(
    inputs: Inputs, strength: InterfaceStrength | None, num_displacements: int
) -> list[ShearInputSamples]:
    """Draw samples of a shear test's inputs and, for a calibrated interface, samples with mu0 = 0 or tau0 = 0."""
    uncertain_inputs, joint_strengths = find_inputs_and_strengths(inputs, strength)
    if not uncertain_inputs and all(np.ptp(joint.mu0) == np.ptp(joint.tau0) == 0 for joint in joint_strengths):
        return []
    *points, probabilities, interface_points = _generate_sample_points(len(uncertain_inputs) + 2, num_displacements).T
    input_samples = {
        name: study_input.estimate.quantile(column)
        for column, (name, study_input) in zip(points, uncertain_inputs.items(), strict=True)
    }
    mu0, tau0 = (input_samples.get(name, np.full(probabilities.size, inputs.central(name))) for name in ("mu0", "tau0"))

    def find_ratios(values: Mapping[str, Floats]) -> dict[str, Floats]:
        ratios = {"effective_modulus": np.asarray(inputs.relative_modulus(values))}
        return ratios | ({"hardness": values["hardness"] / inputs.central("hardness")} if "hardness" in values else {})

    samples = [ShearInputSamples(mu0, tau0, find_ratios(input_samples), probabilities)]
    if joint_strengths:
        index = (interface_points * joint_strengths[0].mu0.size).astype(int)
        samples = [
            ShearInputSamples(
                joint.mu0[index],
                joint.tau0[index],
                find_ratios(input_samples | {name: samples[index] for name, samples in joint.inputs.items()}),
                probabilities,
                joint.coverage,
            )
            for joint in joint_strengths
        ]
    return [
        replace(
            test_samples,
            contact_inputs={name: ratio for name, ratio in test_samples.contact_inputs.items() if np.ptp(ratio) > 0},
        )
        for test_samples in samples
    ]


@dataclass(frozen=True)
class ContactVariation:
    """Change of one contact input, such as the hardness, in a shear test: name of the input, and change factor."""

    name: str
    ratio: float

    def apply_to(self, box: ShearBox) -> ShearBox:
        """Return a copy of a shear test in which the value of one contact input is multiplied by `ratio`."""
        changes: Any = {self.name: getattr(box, self.name) * self.ratio}
        return replace(box, **changes)


def list_variations(samples: Sequence[ShearInputSamples]) -> list[ContactVariation]:
    """Return the input changes for repetitions of a simulated shear test: each contact input at each of its limits."""
    if not samples:
        return []
    return [
        ContactVariation(name, float(f"{limit:.6g}"))
        for name in CONTACT_INPUTS
        if name in samples[0].contact_inputs
        for limit in np.quantile(samples[0].contact_inputs[name], find_tail_probabilities())
    ]


class _SampledCurves:
    """Curves of a shear test for each sample of the inputs, interpolated between simulations at varied inputs.

    The curves are linear in the logarithm of the input. The effects of two inputs are added. `has_no_solution` is True
    for samples near a limit at which the contact has no solution, with the shape (samples, displacements). A sample is
    near a limit if it is nearer to the limit than to the central value, on the logarithmic scale.
    """

    def __init__(
        self, test: xr.Dataset, samples: ShearInputSamples, variations: Sequence[tuple[ContactVariation, xr.Dataset]]
    ) -> None:
        self._test, self._terms = test, []
        self.has_no_solution = np.zeros((1, test.sizes["displacement"]), bool)
        for variation, varied_test in variations:
            logarithm = math.log(variation.ratio)
            weight = np.clip(np.log(samples.contact_inputs[variation.name])[:, np.newaxis] / logarithm, 0.0, 1.0)
            self._terms.append((weight, varied_test))
            is_lost = ~np.isin(varied_test["status"].values, (STATUS_OK, STATUS_DOWNHILL))
            self.has_no_solution = self.has_no_solution | ((weight > MIN_WEIGHT_NEAR_LIMIT) & is_lost)

    def sample(self, get_curve: Callable[[xr.Dataset], Floats]) -> Floats:
        """Interpolate, for each input sample, the curve that `get_curve` reads from the dataset of a shear test.

        Values are NaN for samples near a limit at which the curve is NaN.
        """
        central_curve = get_curve(self._test)
        effects = []
        for weight, varied_test in self._terms:
            difference = get_curve(varied_test) - central_curve
            is_unknown = (weight > MIN_WEIGHT_NEAR_LIMIT) & np.isnan(difference)
            effects.append(np.where(is_unknown, np.nan, weight * np.nan_to_num(difference)))
        return np.asarray(central_curve + sum(effects))


def _sample_test(
    test: xr.Dataset, samples: ShearInputSamples, variations: Sequence[tuple[ContactVariation, xr.Dataset]]
) -> _Samples:
    """Return the curves and peak values of a simulated shear test for each sample of the inputs.

    Coefficients are infinite where the faces lock, or where the contact has no solution.
    """
    curves = _SampledCurves(test, samples, variations)
    law = FrictionLaw(samples.mu0[:, np.newaxis], samples.tau0[:, np.newaxis])
    load_ratios = {
        name: curves.sample(partial(_divide_values, name=name, divisor="normal_load")) for name in LOAD_SUM_NAMES
    }
    normal, tangential = (law.load(load, load_ratios) for load in ("normal", "tangential"))
    with np.errstate(invalid="ignore"):
        coefficient = np.divide(tangential, normal, out=np.full_like(normal, np.inf), where=normal > 0)
    coefficient = np.where(curves.has_no_solution, np.inf, coefficient)
    dilation = curves.sample(partial(_get_values, name="dilation"))
    stress = coefficient * curves.sample(lambda varied_test: _divide_values(varied_test, "normal_load", "overlap_area"))
    stress = np.where(curves.has_no_solution, np.inf, stress)
    count = len(coefficient)
    closures = {name: curves.sample(partial(_get_values, name=name)) for name in CLOSURE_NAMES}
    return _summarize_samples(test, coefficient, stress, np.broadcast_to(dilation, coefficient.shape)) | {
        name: np.broadcast_to(values, (count, values.shape[-1])) for name, values in closures.items()
    }


def _get_values(test: xr.Dataset, name: str) -> Floats:
    return np.asarray(test[name].values)


def _divide_values(test: xr.Dataset, name: str, divisor: str) -> Floats:
    return np.asarray((test[name] / test[divisor]).values)


def _summarize_samples(test: xr.Dataset, coefficient: Floats, stress: Floats, dilation: Floats) -> _Samples:
    """Combine samples of the coefficient, stress and dilation of a shear test into curves and peak values.

    A peak is the largest value among displacements with status "ok".
    """
    displacement, is_ok = test["displacement"].values, test["status"].values == STATUS_OK
    values = {"friction_coefficient": coefficient, "shear_stress": stress, "dilation": dilation}
    if is_ok[-1]:
        values["end"] = coefficient[:, -1]
    if test.attrs["peak_status"] == STATUS_OK:
        rows = np.arange(len(coefficient))
        peaks = np.where(is_ok & ~np.isnan(coefficient), coefficient, -np.inf).argmax(axis=1)
        values["peak"], values["peak_displacement_um"] = coefficient[rows, peaks], displacement[peaks]
        values["peak_dilation_angle_deg"] = compute_dilation_angles(displacement, dilation)[rows, peaks]
        values["peak_shear_stress_GPa"] = np.where(is_ok & ~np.isnan(stress), stress, -np.inf).max(axis=1)
    return values


@dataclass(frozen=True)
class _StripMeanErrors:
    """Standard error of each quantity's mean over the strips of both faces, and the number of solved strips."""

    errors: _Samples
    counts: _Samples

    def error_quantiles(self, name: str, shape: tuple[int, ...], probabilities: Floats) -> Floats:
        """Return quantiles of the error of the mean over strips, with the given probabilities along the first axis.

        The error has Student's t distribution. Quantiles are NaN if fewer than two strips have a solution.
        """
        from scipy.special import stdtrit

        standard_error, strip_count = (
            np.broadcast_to(values_by_name.get(name, np.nan), shape) for values_by_name in (self.errors, self.counts)
        )
        probabilities = probabilities.reshape(-1, *[1] * len(shape))
        return np.asarray(stdtrit(np.maximum(np.nan_to_num(strip_count) - 1, 1), probabilities) * standard_error)


def _estimate_strip_errors(test: xr.Dataset, strips: Sequence[xr.Dataset]) -> _StripMeanErrors:
    """Return the standard error of each quantity's mean over the strips of both faces, ignoring unsolved strips.

    The peak of a strip is found among the displacements at which the strip has a solution.
    """
    coefficient = np.stack(
        [_divide_values(strip, "shear_stress", "normal_load") * strip["overlap_area"].values for strip in strips]
    )
    coefficient = np.where(np.isfinite(coefficient), coefficient, np.nan)
    stress, dilation = (np.stack([strip[name].values for strip in strips]) for name in ("shear_stress", "dilation"))
    standard_errors, strip_counts = {}, {}
    values_by_name = _summarize_samples(test, coefficient, stress, dilation)
    values_by_name |= {name: np.stack([strip[name].values for strip in strips]) for name in CLOSURE_NAMES}
    for name, values in values_by_name.items():
        is_known = np.isfinite(values)
        strip_counts[name] = is_known.sum(axis=0)
        has_scatter = strip_counts[name] > 1
        mean = np.where(is_known, values, 0.0).sum(axis=0) / np.maximum(strip_counts[name], 1)
        squares = np.where(is_known, (values - mean) ** 2, 0.0).sum(axis=0)
        freedom = np.where(has_scatter, strip_counts[name] * (strip_counts[name] - 1), 1)
        standard_errors[name] = np.where(has_scatter, np.sqrt(squares / freedom), np.nan)
    return _StripMeanErrors(standard_errors, strip_counts)


def add_shear_intervals(
    test: xr.Dataset, samples: Sequence[ShearInputSamples], variations: Sequence[tuple[ContactVariation, xr.Dataset]],
    strips: Sequence[xr.Dataset],
) -> xr.Dataset:  # fmt: skip
    """Add 95 % intervals to the curves, the closure and the peak values of a shear test.

    `variations` are the tests at the limits of the inputs, and `strips` are the tests of the strips. The standard error
    of the mean over the strips counts as the error of the test, with Student's t distribution. There is no interval
    where fewer than two strips have a solution. If the contact has no solution at a limit of an input, dilation and
    closure have no interval there, and the upper limit of friction is infinite; the lower limit is 0 unless the faces
    lock. Each interval contains the computed number. The interval of the displacement at the peak also contains the
    displacements before and after the peak. A curve and the dilation angle have no interval if they are the same for
    all samples.
    """
    strip_errors = _estimate_strip_errors(test, strips) if strips else None
    if samples:
        sampled_tests = [_sample_test(test, input_samples, variations) for input_samples in samples]
        probabilities = samples[0].probabilities
        coverages = [input_samples.coverage for input_samples in samples]
    elif strips:
        curves = (_get_values(test, name)[np.newaxis] for name in CURVE_NAMES)
        closures = {name: _get_values(test, name)[np.newaxis] for name in CLOSURE_NAMES}
        sampled_tests, probabilities = (
            [_summarize_samples(test, *curves) | closures],
            _generate_sample_points(1, test.sizes["displacement"])[:, 0],
        )
        coverages = [INTERVAL_COVERAGE]
    else:
        return test
    limits = {}
    for name in sampled_tests[0]:
        value = test[name].values if name in (*CURVE_NAMES, *CLOSURE_NAMES) else np.asarray(test.attrs[name])
        shift = 0.0 if strip_errors is None else strip_errors.error_quantiles(name, value.shape, probabilities)
        limits[name] = _extend_to_value(
            name,
            value,
            [
                _compute_interval_limits(sampled_test[name] + shift, coverage)
                for sampled_test, coverage in zip(sampled_tests, coverages, strict=True)
            ],
        )
    _open_lower_limits(test, limits, [varied_test for _, varied_test in variations])
    return _add_interval_limits(test, limits)


def _open_lower_limits(test: xr.Dataset, limits: Mapping[str, Floats], varied_tests: Sequence[xr.Dataset]) -> None:
    """Set lower limits of friction to 0 where a shear test has no solution if an input is at a limit of its range.

    If the faces lock at the end of the range, lower limits are unchanged, because locking only raises the friction.
    """
    is_lost = np.zeros(test.sizes["displacement"], bool)
    for varied_test in varied_tests:
        is_lost |= ~np.isin(varied_test["status"].values, (STATUS_OK, STATUS_DOWNHILL, STATUS_SELF_LOCKED))
    is_lost &= test["status"].values == STATUS_OK
    for name in ("friction_coefficient", "shear_stress"):
        limits[name][is_lost, 0] = 0.0
    for name, is_open in (("peak", is_lost.any()), ("peak_shear_stress_GPa", is_lost.any()), ("end", is_lost[-1])):
        if is_open and name in limits:
            limits[name][..., 0] = 0.0


def _compute_interval_limits(values: Floats, coverage: float) -> Floats:
    """Return the equal-tailed interval that contains the fraction `coverage` of samples along the first axis.

    Returns NaN if a sample is NaN.
    """
    columns = values.reshape(len(values), -1)
    limits = np.full((columns.shape[1], 2), np.nan)
    is_known = ~np.isnan(columns).any(axis=0)
    if is_known.any():
        limits[is_known] = compute_quantiles(find_tail_probabilities(coverage), columns[:, is_known], axis=0).T
    return limits.reshape(*values.shape[1:], 2)


def _extend_to_value(name: str, value: Floats, limits: Sequence[Floats]) -> Floats:
    """Widen interval limits to include the computed value, and raise negative limits to 0, except those of dilation."""
    first_limits, *other_limits = limits
    extended_limits = extend_intervals(first_limits, *other_limits, np.stack([value, value], axis=-1))
    return extended_limits if "dilation" in name else np.maximum(extended_limits, 0.0)


def _add_interval_limits(test: xr.Dataset, limits: Mapping[str, Floats]) -> xr.Dataset:
    """Return a copy of a shear test with interval limits added to its curves, peak values and final values."""
    attributes: dict[str, float] = {}
    displacement = test["displacement"].values
    for name in SHEAR_INTERVAL_ATTRIBUTES:
        if name not in limits or np.isnan(limits[name]).any():
            continue
        lower, upper = map(float, limits[name])
        if name == "peak_dilation_angle_deg" and lower == upper:
            # If all samples peak at the same computed displacement, the spread of the true peaks is unknown.
            continue
        if name == "peak_displacement_um":
            index = int(np.nanargmax(test["friction_coefficient"].values))
            before, after = displacement[[max(index - 1, 0), min(index + 1, displacement.size - 1)]]
            lower, upper = min(lower, float(before)), min(max(upper, float(after)), float(displacement[-1]))
        attributes |= {f"{name}_lower": lower, f"{name}_upper": upper}
    is_ok = test["status"].values == STATUS_OK
    variables = {
        f"{name}_interval": (
            ("end", *test[name].dims), np.where(is_ok, limits[name].T, np.nan) if name == "friction_coefficient"
            else limits[name].T,
            test[name].attrs | {"long_name": f"95 % interval of the {test[name].attrs['long_name']}"},
        )
        for name in (*CURVE_NAMES, *CLOSURE_NAMES)
        # A curve that is equal for all input samples and strips gets no interval: its uncertainty is unknown, not 0.
        if not (limits[name][..., 0] == limits[name][..., 1])[~np.isnan(test[name].values)].all()
    }  # fmt: skip
    return test.assign_coords(end=["lower", "upper"]).assign(variables).assign_attrs(attributes)
