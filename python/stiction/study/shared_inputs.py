"""Inputs that a pair shares with the friction tests of its interface, possibly with different ranges.

The tests and the pair give the same range to most shared inputs, such as the hardness of a material. If the ranges
differ but have the same central value, they are two statements about one quantity, and the narrower range applies.
Ranges with different central values belong to two quantities, whose errors are independent.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stiction._checks import Floats
from stiction.study.input_distributions import Z_95, UncertainInput, compute_effective_sample_size
from stiction.study.interfaces import InterfaceStrength, StrengthFit, shared_input_name

MAX_RELATIVE_CENTRAL_VALUE_DIFFERENCE = 1e-3
"""Relative difference up to which two central values are equal; the limits of the tested ranges have four digits."""

MIN_SAMPLES_LEFT_BY_PAIR_RANGE = 500.0
"""Smallest effective number of samples that a range of the pair may leave of the samples of an interface.

With fewer samples, the limits of intervals would be random by more than about a twentieth of the width. A range that is
much narrower than that of the tests is therefore widened, to about a tenth of the width that it has in the tests if it
is the only narrower range.
"""

MAX_REQUIRED_FRACTION_OF_SAMPLES = 0.4
"""Largest fraction of all samples that must be left, for interfaces with few samples."""

WEIGHT_EXPONENT_REDUCTION_FACTOR = 0.9
RELATIVE_WIDTH_OF_EXACT_NUMBER = 1e-6
# Standard deviation (in half widths) of the normal density that continues a uniform density outside its range.
DENSITY_EDGE_WIDTH_IN_HALF_WIDTHS = 0.01

INPUTS_WITHOUT_RANGE_COMPARISON = ("mu0", "tau0", "junction_growth", "creep")
"""Inputs whose ranges are not compared here: the interface defines them, or has its own rule for them."""

_TESTED_RANGE_PATTERN = re.compile(r"(normal|log-normal|uniform) (\S+?)\.\.(\S+)")


@dataclass(frozen=True)
class SharedInput:
    """Input that a pair shares with friction tests of its interface: its distribution in the tests and in the pair.

    Attributes
    ----------
    score_name : str
        Name of the samples of the input in `StrengthFit.scores`.
    tested : UncertainInput
        Distribution of the input in the tests.
    stated : UncertainInput
        Distribution of the input in the pair; it may be exact.
    """

    score_name: str
    tested: UncertainInput
    stated: UncertainInput

    @property
    def has_equal_ranges(self) -> bool:
        """True if the input has the same distribution in the tests and in the pair."""
        return self.tested.distribution_text == self.stated.distribution_text

    @property
    def is_one_quantity(self) -> bool:
        """True if the input has equal central values in tests and pair, so that it is the same quantity in both."""
        return are_central_values_equal(self.tested.value, self.stated.value)

    @property
    def is_narrower_in_pair(self) -> bool:
        """True if the input has a narrower range in the pair than in the tests."""
        return self.stated.high - self.stated.low < self.tested.high - self.tested.low

    def sample(self, fit: StrengthFit) -> Floats:
        """Return samples of the input (GPa, or dimensionless), one for each sample of (mu0, tau0) in a fit."""
        from scipy.special import ndtr

        return self.tested.quantile(ndtr(fit.scores[self.score_name]))


def are_central_values_equal(tested_value: float, stated_value: float) -> bool:
    """Return whether an input has equal central values in the tests and in the pair, apart from rounding."""
    return math.isclose(tested_value, stated_value, rel_tol=MAX_RELATIVE_CENTRAL_VALUE_DIFFERENCE)


def find_shared_inputs(
    strength: InterfaceStrength, estimates: Mapping[str, UncertainInput], pair_checksum: str = ""
) -> dict[str, SharedInput]:
    """Return the inputs that a pair shares with the friction tests of an interface, keyed by name.

    `estimates` contains the distributions of the inputs of the pair, which may be exact. `pair_checksum` identifies the
    pair among the tested pairs. If the tests have several ranges of an input, the range that equals that of the pair is
    returned, or the narrowest range with the same central value.
    """
    scores, shared_inputs = strength.fits[0].scores, {}
    for name, stated in estimates.items():
        score_name = shared_input_name(name, stated, pair_checksum)
        if score_name in scores:
            shared_inputs[name] = SharedInput(score_name, stated, stated)
        elif name not in INPUTS_WITHOUT_RANGE_COMPARISON:
            candidates = _find_tested_ranges(scores, name, stated, pair_checksum)
            ranges_of_quantity = [each for each in candidates if each.is_one_quantity]
            if ranges_of_quantity:
                shared_inputs[name] = min(ranges_of_quantity, key=lambda each: each.tested.high - each.tested.low)
    return shared_inputs


def _find_tested_ranges(
    scores: Mapping[str, Floats], name: str, stated: UncertainInput, pair_checksum: str
) -> Iterator[SharedInput]:
    """Yield each range of an input in the friction tests, as a `SharedInput` that also contains the pair's range."""
    suffix = f" of {pair_checksum}" if name == "area_loss" else ""
    for score_name in scores:
        text = score_name.removeprefix(f"{name} ")
        if text == score_name or not text.endswith(suffix):
            continue
        if match := _TESTED_RANGE_PATTERN.fullmatch(text.removesuffix(suffix)):
            low, high = float(match[2]), float(match[3])
            # Files of earlier versions contain limits that were rounded to four digits, so both limits may be equal.
            distribution: Any = match[1] if low < high else "exact"
            value = math.sqrt(low * high) if distribution == "log-normal" else 0.5 * (low + high)
            tested = replace(
                stated, value=value, low=low, high=high, distribution=distribution, text=f"{match[2]}..{match[3]}"
            )
            yield SharedInput(score_name, tested, stated)


def apply_ranges_of_pair(strength: InterfaceStrength, shared_inputs: Mapping[str, SharedInput]) -> InterfaceStrength:
    """Resample an interface's mu0 and tau0 for inputs with narrower ranges in the pair than in the friction tests.

    Samples are selected in proportion to the ratio of the new to the old density of the inputs. They are then samples
    of the fit that the same tests would have given with the range of the pair.
    """
    narrower_inputs = [
        each for each in shared_inputs.values() if not each.has_equal_ranges and each.is_narrower_in_pair
    ]
    if not narrower_inputs:
        return strength

    def apply_to(fit: StrengthFit) -> StrengthFit:
        log_weights = [
            _compute_log_density(each.stated, each.sample(fit)) - _compute_log_density(each.tested, each.sample(fit))
            for each in narrower_inputs
        ]
        return fit.resample(_combine_weights(log_weights))

    fit = strength.fits[0]
    fits_at_bounds = {name: apply_to(fit_at_bound) for name, fit_at_bound in fit.fits_at_bounds.items()}
    return replace(strength, fits=(replace(apply_to(fit), fits_at_bounds=fits_at_bounds),))


def _compute_log_density(estimate: UncertainInput, values: Floats) -> Floats:
    """Return the natural logarithm of an input's probability density at given values, plus an arbitrary constant.

    The density of an exact number is that of a very narrow normal distribution. A uniform density decays like
    a normal density outside its range, so that its logarithm is finite everywhere.
    """
    half_width = max(0.5 * (estimate.high - estimate.low), RELATIVE_WIDTH_OF_EXACT_NUMBER * estimate.value)
    if estimate.distribution == "uniform":
        distance = np.maximum(np.abs(values - estimate.value) - half_width, 0.0)
        return np.asarray(-0.5 * (distance / (DENSITY_EDGE_WIDTH_IN_HALF_WIDTHS * half_width)) ** 2)
    if estimate.distribution == "log-normal":
        scores = 2 * Z_95 * np.log(values / estimate.value) / math.log(estimate.high / estimate.low)
        return np.asarray(-0.5 * scores**2 - np.log(values))
    return np.asarray(-0.5 * (Z_95 * (values - estimate.value) / half_width) ** 2)


def _combine_weights(log_weights: Sequence[Floats]) -> Floats:
    """Return the logarithm of the importance weight of each sample of (mu0, tau0), combined from all inputs.

    Weights of inputs are raised to powers below 1 until the effective number of samples is large enough. The exponent
    of the input that leaves the fewest samples is reduced, so that a much narrower range does not widen other ranges.
    """
    exponents, total = [1.0] * len(log_weights), sum(log_weights, np.zeros(log_weights[0].size))
    min_samples = min(MIN_SAMPLES_LEFT_BY_PAIR_RANGE, MAX_REQUIRED_FRACTION_OF_SAMPLES * total.size)
    while compute_effective_sample_size(total) < min_samples:
        sizes = [
            compute_effective_sample_size(exponent * each)
            for exponent, each in zip(exponents, log_weights, strict=True)
        ]
        exponents[int(np.argmin(sizes))] *= WEIGHT_EXPONENT_REDUCTION_FACTOR
        total = sum(
            (exponent * each for exponent, each in zip(exponents, log_weights, strict=True)), np.zeros(total.size)
        )
    return total
