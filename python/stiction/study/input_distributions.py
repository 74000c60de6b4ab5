"""Probability distributions of inputs: exact numbers, ranges, and numbers with a standard uncertainty.

Distributions are propagated by sampling (JCGM 101, 2008). The range of a hardness, a modulus or a strength represents a
log-normal distribution with 95 % of its probability within the range. The range of a coefficient, or a value with a
standard uncertainty, represents a normal distribution truncated at 0. A range that starts at 0 represents a uniform
distribution.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import PlainSerializer, PlainValidator, WrapValidator

from stiction._arguments import MAX_INPUT_NUMBER
from stiction._checks import Floats, make_read_only
from stiction._units import Quantity, exact_quantity_text, quantity, short_repr
from stiction.mechanics.friction import CENTRAL_SHEAR_RATIO, MAX_SHEAR_RATIO, MIN_SHEAR_RATIO
from stiction.study.values import FrictionCoefficients, ShearStrengths

InputDistribution = Literal["exact", "normal", "log-normal", "uniform"]
Z_95 = 1.959963984540054
# With fewer samples, the fractions of two equally uncertain inputs in an uncertainty budget could differ by over 0.01.
NUM_INPUT_SAMPLES = 2**14
MIN_RELATIVE_UNCERTAINTY = 1e-9
UNCERTAINTY_PATTERN = re.compile(r"\.\.|±|\+/?-|(?<![^\W\d_])(HV|HRC)(?![^\W\d_])")
"""Regular expression that finds a range, an uncertainty or a hardness scale in an input's text."""

_VICKERS_BY_ROCKWELL = {
    20: 238,
    25: 266,
    30: 302,
    35: 345,
    40: 392,
    45: 446,
    50: 513,
    55: 595,
    60: 697,
    65: 832,
    68: 940,
}
"""Vickers hardness (HV) of steels by Rockwell C hardness (HRC), from ISO 18265 (2013), table A.1, and ASTM E140."""

# Half width of the range of a hardness converted from HRC, as a fraction of the hardness (20 HV at 40 HRC).
ROCKWELL_CONVERSION_ERROR = 0.05
_GPA_PER_VICKERS = 9.80665e-3 / 0.9272
"""Mean contact pressure (GPa) of a Vickers indentation at 1 HV.

1 HV is 1 kgf per mm² of the indentation's surface, and the projected area is 0.9272 of this surface.
"""

_RANGE_PATTERN = re.compile(r"\s*(uniform\s+)?(.+?)\s*\.\.\s*(.+?)\s*")
_PLUS_MINUS_PATTERN = re.compile(r"\s*(.+?)\s*(?:±|\+-|\+/-)\s*(.+?)\s*")
# The range of an input may be in parentheses, as in "0.3 (0.2 .. 0.4)".
_CENTRAL_VALUE_PATTERN = re.compile(r"\s*([^()]+?)\s*\(\s*([^()]+?)\s*\)\s*")
# An uncertainty in per cent may be followed by a unit.
_PERCENT_PATTERN = re.compile(r"(.+?)\s*%\s*(.*)")
_TRAILING_UNIT_PATTERN = re.compile(r"(?<![^\W\d_])(?!inf\b|nan\b)[^\W\d_]+\s*$", re.IGNORECASE)
# The name of a Vickers scale may contain the test load, as in "HV10" or "HV 0.5".
_VICKERS_TEST_LOAD_PATTERN = re.compile(r"(?<![^\W\d_])HV\s*[0-9]+(\.[0-9]+)?(?![0-9.]*\s*[^\W\d_])")
InputKind = Literal["", "pressure", "modulus", "hardness"]
# An incompressible body has this Poisson's ratio.
MAX_POISSON_RATIO = 0.5
# Upper limit of the junction growth α. For a von Mises body with a hardness of three times its yield strength, α is 27.
MAX_JUNCTION_GROWTH_COEFFICIENT = 100.0
SLIP_LINE_TEXT = "slip-line"
MIN_HARDNESS_TO_SHEAR_RATIO, MAX_HARDNESS_TO_SHEAR_RATIO = 5.0, 6.5  # slip-line theory
# Accepted range of the yield exponent m; fits to rough surfaces usually give an m between 0.7 and 1.6.
MIN_YIELD_EXPONENT, MAX_YIELD_EXPONENT = 0.5, 10.0
MAX_AREA_LOSS = 0.9
# At the largest accepted creep exponent, the hardness falls to a third in each decade of time.
MAX_CREEP_EXPONENT = 0.5


@dataclass(frozen=True)
class UncertainInput:
    """Distribution of an input, in core units (µm, GPa, mN): exact number, or range and type of distribution."""

    # Central value of an input: the exact number, or the mean (geometric mean if log-normal) of the two limits.
    value: float
    # Limits of the 95 % interval of an input or, if its distribution is uniform, limits of the distribution.
    low: float
    high: float
    distribution: InputDistribution
    text: str
    maximum: float = math.inf
    # True if junction growth is specified as the ratio of hardness to shear strength, False if it is specified as α.
    uses_slip_lines: bool = False

    @property
    def is_exact(self) -> bool:
        """True if the input is an exact number."""
        return self.distribution == "exact"

    @property
    def short_text(self) -> str:
        """Short text of the input: up to six digits of an exact number, or the range as the user wrote it."""
        return f"{self.value:g}" if self.is_exact else self.text

    @property
    def distribution_text(self) -> str:
        """Text of the distribution in core units (µm, GPa, mN), such as "log-normal 1.059..1.294".

        The text is the same for every unit of the input.

        Limits are rounded to four digits, or to four digits of the width for a range narrower than 1 % of the input.
        """
        width = self.high - self.low
        digits = 4 if self.is_exact or width >= 0.01 * self.high else 4 + math.ceil(math.log10(self.high / width))
        limits = f"{self.low:.{digits}g}" if self.is_exact else f"{self.low:.{digits}g}..{self.high:.{digits}g}"
        return f"{self.distribution} {limits}{f' {SLIP_LINE_TEXT}' if self.uses_slip_lines else ''}"

    def quantile(self, probability: ArrayLike) -> Floats:
        """Return the quantiles of the distribution (core units) at given probabilities."""
        values = np.asarray(probability, dtype=np.float64)
        return np.minimum(self._compute_quantile(values), self.maximum)

    def _compute_quantile(self, probability: Floats) -> Floats:
        from scipy.special import ndtr, ndtri

        if self.is_exact:
            return np.full(probability.shape, self.value)
        if self.distribution == "uniform":
            return np.asarray(self.low + probability * (self.high - self.low))
        if self.distribution == "log-normal":
            return np.asarray(self.value * np.exp(ndtri(probability) / Z_95 * 0.5 * math.log(self.high / self.low)))
        deviation = (self.high - self.low) / (2 * Z_95)
        # Numbers below zero, which have the probability `probability_below_zero`, are excluded from the distribution.
        probability_below_zero = ndtr(-self.value / deviation)
        return np.asarray(
            np.maximum(
                self.value + deviation * ndtri(probability_below_zero + probability * (1 - probability_below_zero)), 0.0
            )
        )


def parse_uncertain_input(name: str, source: Any, kind: InputKind = "") -> UncertainInput:
    """Parse a number in core units (µm, GPa, mN), or a text such as "200 MPa", "20..80 MPa" or "150 ± 10 % HV".

    Raises
    ------
    ValueError
        If the input has another form, is negative, or is larger than `MAX_INPUT_NUMBER`.
    """
    if isinstance(source, UncertainInput):
        return source
    if not isinstance(source, str):
        value = _parse_value(name, source, kind)
        return UncertainInput(value, value, value, "exact", exact_quantity_text(value, "GPa") if kind else repr(value))
    text = " ".join(source.split())
    parsed_input = _parse_distribution(
        name, _VICKERS_TEST_LOAD_PATTERN.sub("HV", text) if kind == "hardness" else text, kind
    )
    if not parsed_input.high <= MAX_INPUT_NUMBER:
        raise ValueError(
            f"{name} must be at most {MAX_INPUT_NUMBER:g}, also at the limits of its uncertainty, "
            f"got {short_repr(text)}"
        )
    if (
        parsed_input.distribution == "normal"
        and parsed_input.high - parsed_input.low < 2 * Z_95 * MIN_RELATIVE_UNCERTAINTY * parsed_input.value
    ):
        raise ValueError(
            f"{name} must be exact or have a relative uncertainty of at least {MIN_RELATIVE_UNCERTAINTY:g}, "
            f"got {short_repr(text)}"
        )
    return replace(parsed_input, text=text)


def _parse_distribution(name: str, text: str, kind: InputKind) -> UncertainInput:
    """Parse a text such as "20..80 MPa" to the probability distribution of an input.

    Single spaces must separate the words.
    """
    is_rockwell = "HRC" in text and kind == "hardness"
    if match := _RANGE_PATTERN.fullmatch(text):
        is_uniform, first_text, last_text = match.groups()
        low, high = (_parse_value(name, limit, kind) for limit in _complete_units(first_text, last_text))
        if not 0 <= low < high:
            raise ValueError(f"{name} must be a range from a smaller to a larger value, got {short_repr(text)}")
        if kind in ("hardness", "modulus") and low == 0:
            raise ValueError(f"{name} must be above 0, got {short_repr(text)}")
        if is_rockwell:
            return _convert_rockwell_hardness(low, high, text)
        if is_uniform or low == 0:
            return UncertainInput(0.5 * (low + high), low, high, "uniform", text)
        if kind:
            return UncertainInput(math.sqrt(low * high), low, high, "log-normal", text)
        return UncertainInput(0.5 * (low + high), low, high, "normal", text)
    if match := _PLUS_MINUS_PATTERN.fullmatch(text):
        first_text, last_text = match.groups()
        if percent_match := _PERCENT_PATTERN.fullmatch(last_text):
            value = _parse_value(name, f"{first_text} {percent_match[2]}".strip(), kind)
            deviation = value * _parse_value(name, percent_match[1], "") / 100
            deviation = math.hypot(deviation, ROCKWELL_CONVERSION_ERROR * value / Z_95) if is_rockwell else deviation
        elif is_rockwell:
            central_value, standard_uncertainty = (
                _parse_number(name, _TRAILING_UNIT_PATTERN.sub("", text_part).strip())
                for text_part in (first_text, last_text)
            )
            limits = (central_value - Z_95 * standard_uncertainty, central_value + Z_95 * standard_uncertainty)
            if not min(_VICKERS_BY_ROCKWELL) <= limits[0] <= limits[1] <= max(_VICKERS_BY_ROCKWELL):
                hardness_limits = f"{min(_VICKERS_BY_ROCKWELL)} to {max(_VICKERS_BY_ROCKWELL)} HRC"
                raise ValueError(
                    f"{name} must be from {hardness_limits}, also at the limits of its uncertainty, "
                    f"got {short_repr(text)}"
                )
            low, high = (_parse_value(name, f"{limit:g} HRC", kind) for limit in limits)
            return _convert_rockwell_hardness(low, high, text)
        else:
            value, deviation = (
                _parse_value(name, text_part, kind) for text_part in _complete_units(first_text, last_text)
            )
        if not deviation > 0:
            raise ValueError(f"{name} must have an uncertainty above 0, got {short_repr(text)}")
        if kind in ("hardness", "modulus") and value < Z_95 * deviation:
            raise ValueError(
                f"{name} must be at least twice its standard uncertainty, got "
                f"{short_repr(text)}; specify a very uncertain value as a range, low..high"
            )
        return UncertainInput(value, value - Z_95 * deviation, value + Z_95 * deviation, "normal", text)
    value = _parse_value(name, text, kind)
    if text.endswith("HRC"):
        return _convert_rockwell_hardness(value, value, text)
    return UncertainInput(value, value, value, "exact", text)


def _convert_rockwell_hardness(low: float, high: float, text: str) -> UncertainInput:
    """Convert a range of Rockwell hardness (HRC) to a distribution in GPa, widened by the conversion error."""
    half_width = math.hypot(0.5 * math.log(high / low), ROCKWELL_CONVERSION_ERROR)
    value = math.sqrt(low * high)
    return UncertainInput(value, value * math.exp(-half_width), value * math.exp(half_width), "log-normal", text)


class _NumberOutsideRangeError(ValueError):
    """Error raised if an input is infinite, NaN, negative or larger than `MAX_INPUT_NUMBER`."""


def _parse_number(name: str, text: str) -> float:
    """Parse a dimensionless number from 0 to `MAX_INPUT_NUMBER`."""
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"{name} must be a number, got {short_repr(text)}") from None
    if not 0 <= value <= MAX_INPUT_NUMBER:
        allowed_range = f"finite and from 0 to {MAX_INPUT_NUMBER:g}"
        raise _NumberOutsideRangeError(f"{name} must be {allowed_range}, got {short_repr(text)}")
    return value


def _parse_value(name: str, source: Any, kind: str) -> float:
    """Parse a nonnegative number or a quantity with a unit, and return a number in core units (µm, GPa, mN).

    A text contains a unit if `kind` is not empty.
    """
    if isinstance(source, str) and not kind:
        return _parse_number(name, source)
    unit_match = _TRAILING_UNIT_PATTERN.search(source) if kind == "hardness" and isinstance(source, str) else None
    if unit_match and unit_match[0] in ("HV", "HRC"):
        number = _parse_number(name, source[: unit_match.start()].strip())
        if unit_match[0] == "HRC":
            if not min(_VICKERS_BY_ROCKWELL) <= number <= max(_VICKERS_BY_ROCKWELL):
                hardness_limits = f"{min(_VICKERS_BY_ROCKWELL)} to {max(_VICKERS_BY_ROCKWELL)} HRC"
                raise ValueError(f"{name} must be from {hardness_limits}, got {short_repr(source)}")
            number = math.exp(
                float(np.interp(number, list(_VICKERS_BY_ROCKWELL), np.log(list(_VICKERS_BY_ROCKWELL.values()))))
            )
        return number * _GPA_PER_VICKERS
    scale_hint = "; HV and HRC are also accepted" if kind == "hardness" else ""
    kind = "pressure" if kind else ""
    try:
        value = float(quantity(source, kind)) if kind and isinstance(source, str) else float(source)
    except (TypeError, ValueError, OverflowError) as error:
        reason = (
            f"{error}{scale_hint}"
            if kind and isinstance(source, str)
            else f"must be a number, got {short_repr(source)}"
        )
        raise ValueError(f"{name} {reason}") from None
    if not (math.isfinite(value) and value >= 0):
        raise _NumberOutsideRangeError(f"{name} must be finite and not negative, got {short_repr(source)}")
    return value


def _complete_units(first_text: str, last_text: str) -> tuple[str, str]:
    """Copy the unit of the last limit of a range to the first limit if the first limit has no unit.

    The unit of the first limit is copied to the last limit only if it is HV or HRC.
    """
    unit_matches = [_TRAILING_UNIT_PATTERN.search(text) for text in (first_text, last_text)]
    if unit_matches[0] is None and unit_matches[1] is not None:
        return f"{first_text} {unit_matches[1][0]}", last_text
    if unit_matches[0] is not None and unit_matches[1] is None and unit_matches[0][0].strip() in ("HV", "HRC"):
        return first_text, f"{last_text} {unit_matches[0][0]}"
    return first_text, last_text


SOBOL_BITS = 30

SOBOL_GENERATORS: tuple[tuple[int, tuple[int, ...]], ...] = (
    (1, (1,) * SOBOL_BITS), (3, (1,)), (7, (1, 3)), (11, (1, 3, 1)), (13, (1, 1, 1)), (19, (1, 1, 3, 3)),
    (25, (1, 3, 5, 13)), (37, (1, 1, 5, 5, 17)), (41, (1, 1, 5, 5, 5)), (47, (1, 1, 7, 11, 19)), (55, (1, 1, 5, 1, 1)),
    (59, (1, 1, 1, 3, 11)),
)  # fmt: skip
"""Primitive polynomial and initial direction numbers of each dimension (Joe and Kuo, SIAM J. Sci. Comput. 30, 2008)."""


def _compute_sobol_direction_bits(polynomial: int, initial_numbers: Sequence[int]) -> NDArray[np.uint32]:
    """Compute the direction numbers for one dimension of a Sobol sequence, as an array of their bits."""
    direction_numbers, degree = list(initial_numbers), polynomial.bit_length() - 1
    while len(direction_numbers) < SOBOL_BITS:
        direction_number = direction_numbers[-degree]
        for lag in range(1, degree + 1):
            if polynomial >> (degree - lag) & 1:
                direction_number ^= direction_numbers[-lag] << lag
        direction_numbers.append(direction_number)
    bits = [
        [number >> (index - row) & 1 if row <= index else 0 for index, number in enumerate(direction_numbers)]
        for row in range(SOBOL_BITS)
    ]
    return np.array(bits, dtype=np.uint32)


@lru_cache(maxsize=32)
def generate_sobol_points(dimensions: int, count: int = NUM_INPUT_SAMPLES, *, seed: int = 0) -> Floats:
    """Generate `count` points of a scrambled Sobol sequence in the unit cube, where `count` is a power of two.

    The points are those of `scipy.stats.qmc.Sobol`. For few dimensions, the points are computed here, because importing
    `scipy.stats` takes longer than evaluating a result.
    """
    generator, num_bits = np.random.default_rng(seed), round(math.log2(count))
    if dimensions > len(SOBOL_GENERATORS):
        from scipy.stats import qmc

        points = qmc.Sobol(dimensions, rng=generator).random_base2(num_bits)
    else:
        # The Sobol points are scrambled by Matoušek's method, with a random lower triangular matrix and a random shift.
        random_bits = partial(generator.spawn(1)[0].integers, 2, dtype=np.uint32)
        shift_bits = random_bits(size=(dimensions, SOBOL_BITS))
        matrices = np.tril(random_bits(size=(dimensions, SOBOL_BITS, SOBOL_BITS)), -1) + np.eye(
            SOBOL_BITS, dtype=np.uint32
        )
        place_values = 2 ** np.arange(SOBOL_BITS, dtype=np.uint32)
        integers = np.empty((count, dimensions), dtype=np.uint32)
        integers[0] = shift_bits @ place_values
        for dimension, matrix in enumerate(matrices):
            bits = matrix @ _compute_sobol_direction_bits(*SOBOL_GENERATORS[dimension]) % 2
            for index, number in enumerate((place_values[::-1] @ bits)[:num_bits]):
                # In Gray-code order, the second half of the points is the first half in reverse, with one bit flipped.
                first_half = integers[: 2**index, dimension]
                integers[2**index : 2 ** (index + 1), dimension] = first_half[::-1] ^ number
        points = integers * 0.5**SOBOL_BITS
    return make_read_only(np.clip(points, 1e-9, 1 - 1e-9))


def generate_stratified_points(dimensions: int) -> Floats:
    """Generate `NUM_INPUT_SAMPLES` points of a scrambled Sobol sequence in the unit cube, with a constant seed."""
    return generate_sobol_points(dimensions, NUM_INPUT_SAMPLES, seed=2016)


def select_by_weight(cumulative_weights: Floats, count: int, offset: float) -> NDArray[np.intp]:
    """Select `count` samples with probabilities proportional to their weights (systematic resampling).

    Returns the indices of the selected samples.

    `offset` is a number from 0 to 1 that shifts the selection.
    """
    targets = (np.arange(count) + offset) / count * cumulative_weights[-1]
    # Round-off may raise the last target above the sum of all weights, so no index exceeds that of the last weight.
    indices: NDArray[np.intp] = np.minimum(np.searchsorted(cumulative_weights, targets), cumulative_weights.size - 1)
    return indices


def compute_effective_sample_size(log_weight: Floats) -> float:
    """Return the effective sample size (Σw)²/Σw² of weighted samples, from the logarithms of the weights w."""
    weight = np.exp(log_weight - log_weight.max())
    return float(weight.sum() ** 2 / (weight**2).sum())


def draw_input_samples(inputs: Mapping[str, UncertainInput]) -> dict[str, Floats]:
    """Return `NUM_INPUT_SAMPLES` independent samples of each input, keyed by the name of the input."""
    points = generate_stratified_points(len(inputs))
    return {name: value.quantile(points[:, column]) for column, (name, value) in enumerate(inputs.items())}


# ---- Entries of a study file ----------------------------------------------------------------------------------------

INPUT_KINDS: dict[str, InputKind] = {
    "mu0": "", "tau0": "pressure", "hardness": "hardness", "effective_modulus": "modulus", "young": "modulus",
    "poisson": "", "creep": "", "junction_growth": "", "yield_exponent": "", "area_loss": "",
}  # fmt: skip
"""Kind of quantity of each input that may be uncertain, such as "pressure"; empty for dimensionless inputs."""

_INPUT_LIMITS = {
    "poisson": (0.0, MAX_POISSON_RATIO), "creep": (0.0, MAX_CREEP_EXPONENT), "area_loss": (0.0, MAX_AREA_LOSS),
    "junction_growth": (0.0, MAX_JUNCTION_GROWTH_COEFFICIENT),
    "yield_exponent": (MIN_YIELD_EXPONENT, MAX_YIELD_EXPONENT),
}  # fmt: skip
"""Smallest and largest allowed value of dimensionless inputs, such as Poisson's ratio."""


def parse_study_input(name: str, source: Any) -> UncertainInput:
    """Parse an input with a given name, such as "hardness", from a number, a range, or a text with an uncertainty.

    The name is a key of `INPUT_KINDS`. Error messages do not contain the name.
    """
    if name == "junction_growth" and isinstance(source, str) and source.split()[:1] == [SLIP_LINE_TEXT]:
        return _parse_slip_line_ratio(source)
    if name not in _INPUT_LIMITS:
        return parse_uncertain_input("", source, INPUT_KINDS[name])
    minimum, maximum = _INPUT_LIMITS[name]
    allowed_range = f"from {minimum:g} to {maximum:g}, also at the limits of its uncertainty"
    range_error = ValueError(f"must be {allowed_range}, got {short_repr(source)}")
    try:
        parsed_input = parse_uncertain_input("", source, INPUT_KINDS[name])
    except _NumberOutsideRangeError:
        raise range_error from None
    if parsed_input.high > maximum or parsed_input.low < minimum > 0:
        raise range_error
    return replace(parsed_input, maximum=maximum) if name in ("poisson", "area_loss") else parsed_input


def _parse_slip_line_ratio(source: str) -> UncertainInput:
    """Parse the word "slip-line" with an optional ratio H/k of hardness to shear strength, as in "slip-line 5.14"."""
    text = " ".join(source.split())
    ratio_text = text.removeprefix(SLIP_LINE_TEXT).strip()
    if not ratio_text:
        limits = MIN_SHEAR_RATIO, MAX_SHEAR_RATIO
        return UncertainInput(CENTRAL_SHEAR_RATIO, *limits, "uniform", text, uses_slip_lines=True)
    parsed_ratio = parse_uncertain_input("", ratio_text)
    if not MIN_HARDNESS_TO_SHEAR_RATIO <= parsed_ratio.low <= parsed_ratio.high <= MAX_HARDNESS_TO_SHEAR_RATIO:
        allowed_range = (
            f"from {MIN_HARDNESS_TO_SHEAR_RATIO:g} to {MAX_HARDNESS_TO_SHEAR_RATIO:g}, also at the limits of its "
            "uncertainty"
        )
        raise ValueError(f"must have a ratio of hardness to shear strength {allowed_range}, got {short_repr(source)}")
    return replace(parsed_ratio, text=text, uses_slip_lines=True)


class InputValue(Quantity):
    """Input of a study: central value, probability distribution, and the text from which both were parsed.

    The number is the central value in core units, with which contacts are computed. For a range, it is the mean of both
    limits, rounded to four digits. The mean is geometric for a log-normal distribution, and arithmetic otherwise.
    """

    estimate: UncertainInput

    def __new__(cls, value: float, estimate: UncertainInput, text: str | None = None) -> InputValue:
        """Create an input from its central value, its distribution and the text in the study file.

        By default, the text is that of the distribution.
        """
        result: Any = super().__new__(cls, value, estimate.text if text is None else text)
        result.estimate = estimate
        return result  # type: ignore[no-any-return]

    def __getnewargs__(self) -> tuple[float, UncertainInput, str]:  # type: ignore[override]
        return float(self), self.estimate, self.text

    def __eq__(self, other: object) -> bool:
        """Return whether two inputs have equal central values and, unless both are exact, equal distributions."""
        if isinstance(other, InputValue) and not (self.is_exact and other.is_exact):
            return float(self) == float(other) and self.estimate == other.estimate
        return float(self) == other

    __hash__ = Quantity.__hash__

    def __bool__(self) -> bool:
        """Return False for an exact input of 0, and True for any other input."""
        return float(self) != 0 or not self.is_exact

    @property
    def is_exact(self) -> bool:
        """True if the input is an exact number."""
        return self.estimate.is_exact


def parse_input_value(name: str, source: Any) -> InputValue:
    """Parse an input in a study file: a number, a quantity with its unit, or text with a range or an uncertainty.

    The name of the input is a key of `INPUT_KINDS`. A central value may precede its range, as in "0.6 GPa (0.2..1.7
    GPa)". Error messages do not contain the name.
    """
    if isinstance(source, InputValue):
        return source
    kind = INPUT_KINDS[name]
    if isinstance(source, Quantity) or (kind and not isinstance(source, str)):
        source = quantity(source, "pressure").text
    if isinstance(source, bool) or not isinstance(source, (str, int, float)):
        raise ValueError(f"must be a number, or a string with a range or an uncertainty, got {short_repr(source)}")
    try:
        value = _parse_input_value(name, source)
    except ValueError as error:
        if isinstance(source, str) and kind and source.lstrip().startswith("-"):
            raise ValueError(f"must be {_lower_bound_words(kind)} 0, got {short_repr(source)}") from None
        raise ValueError(str(error).strip()) from None
    if kind in ("hardness", "modulus") and not value > 0:
        raise ValueError(f"must be {_lower_bound_words(kind)} 0, got {short_repr(source)}")
    return value


def _lower_bound_words(kind: InputKind) -> str:
    return "above" if kind in ("hardness", "modulus") else "at least"


def _parse_input_value(name: str, source: Any) -> InputValue:
    if not isinstance(source, str):
        estimate = parse_study_input(name, source)
        return InputValue(estimate.value, estimate)
    if match := _CENTRAL_VALUE_PATTERN.fullmatch(source):
        central_input, estimate = (parse_study_input(name, text) for text in match.groups())
        if not central_input.is_exact or estimate.is_exact or not estimate.low <= central_input.value <= estimate.high:
            raise ValueError(
                "must be one number, followed by a range in parentheses that contains this number, "
                f"got {short_repr(source)}"
            )
        return InputValue(central_input.value, estimate, f"{central_input.text} ({estimate.text})")
    estimate = parse_study_input(name, source)
    if UNCERTAINTY_PATTERN.search(source):
        return InputValue(float(f"{estimate.value:.4g}"), estimate)
    if INPUT_KINDS[name]:
        estimate = replace(estimate, text=quantity(source, "pressure").text)
    return InputValue(estimate.value, estimate)


def _make_exact_value(value: float) -> InputValue:
    """Create an exact input from a number or a quantity."""
    number = float(value)
    text = value.text if isinstance(value, Quantity) else repr(number)
    return InputValue(number, UncertainInput(number, number, number, "exact", text))


def format_input_value(value: InputValue | None) -> Any:
    """Convert an input to a number or a text for a study file.

    The result is a number if the input is exact and has no unit, and text otherwise.
    """
    if value is None:
        return None
    try:
        float(value.text)
    except ValueError:
        return value.text
    return float(value)


def _parse_single_value(name: str, values: Any, parse_list: Callable[[Any], Any]) -> Any:
    """Parse mu0 or tau0 to a tuple that contains exact numbers, or a single uncertain number."""
    items = list(values) if isinstance(values, (list, tuple)) else [values]
    if any(isinstance(item, InputValue) or (isinstance(item, str) and _is_uncertain(item)) for item in items):
        if len(items) > 1:
            raise ValueError(
                f"must be a list of exact values, or one value with a range or an uncertainty, got {short_repr(items)}"
            )
        return (parse_input_value(name, items[0]),)
    if not isinstance(values, (list, tuple)) and isinstance(values, str) and not INPUT_KINDS[name]:
        items = [float(parse_input_value(name, values))]
    return tuple(map(_make_exact_value, parse_list(tuple(items))))


def _is_uncertain(text: str) -> bool:
    return UNCERTAINTY_PATTERN.search(text) is not None


def _format_values(values: tuple[InputValue, ...]) -> Any:
    entries = tuple(format_input_value(value) for value in values)
    return entries if values[0].is_exact else entries[0]


_input_value_serializer = PlainSerializer(format_input_value)
EffectiveModulusEntry = Annotated[
    InputValue, PlainValidator(partial(parse_input_value, "effective_modulus")), _input_value_serializer
]
YoungModulusEntry = Annotated[InputValue, PlainValidator(partial(parse_input_value, "young")), _input_value_serializer]
PoissonRatioEntry = Annotated[
    InputValue, PlainValidator(partial(parse_input_value, "poisson")), _input_value_serializer
]
HardnessEntry = Annotated[InputValue, PlainValidator(partial(parse_input_value, "hardness")), _input_value_serializer]
JunctionGrowthEntry = Annotated[
    InputValue, PlainValidator(partial(parse_input_value, "junction_growth")), _input_value_serializer
]
YieldExponentEntry = Annotated[
    InputValue, PlainValidator(partial(parse_input_value, "yield_exponent")), _input_value_serializer
]
AreaLossEntry = Annotated[InputValue, PlainValidator(partial(parse_input_value, "area_loss")), _input_value_serializer]
CreepExponentEntry = Annotated[InputValue, PlainValidator(partial(parse_input_value, "creep")), _input_value_serializer]
FrictionCoefficientEntry = Annotated[
    InputValue, PlainValidator(partial(parse_input_value, "mu0")), _input_value_serializer
]
ShearStrengthEntry = Annotated[InputValue, PlainValidator(partial(parse_input_value, "tau0")), _input_value_serializer]
FrictionCoefficientEntries = Annotated[
    FrictionCoefficients, WrapValidator(partial(_parse_single_value, "mu0")), PlainSerializer(_format_values)
]
ShearStrengthEntries = Annotated[
    ShearStrengths, WrapValidator(partial(_parse_single_value, "tau0")), PlainSerializer(_format_values)
]
