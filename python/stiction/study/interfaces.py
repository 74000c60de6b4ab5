"""Strength of interfaces (mu0 and tau0), from a published list or from calibration files.

An interface file has header lines that begin with "# ", and below them a table with one sample per row. The columns are
mu0, tau0, hardness, junction growth, the true area per load of the tests (A/F), and the normal score of each uncertain
input of the tests.
"""

from __future__ import annotations

import contextlib
import csv
import io
import math
import os
import tomllib
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, lru_cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from stiction._checks import Floats, check_callable, check_choice, check_instance, parse_path, validate_number
from stiction._files import UnreadableFileError, describe_os_error, read_file_bytes, replace_file_atomically
from stiction._text import printable_path, printable_text
from stiction._units import exact_quantity_text, short_repr
from stiction.mechanics.friction import FrictionLaw
from stiction.mechanics.model import SlidingRule
from stiction.study.input_distributions import (
    Z_95,
    FrictionCoefficientEntry,
    ShearStrengthEntry,
    UncertainInput,
    draw_input_samples,
    parse_study_input,
    parse_uncertain_input,
    select_by_weight,
)
from stiction.study.values import SettingsSection

if TYPE_CHECKING:
    import pandas

INTERFACE_FILE_HEADER = "# stiction interface"
INTERFACE_FILE_COLUMNS = (
    "mu0",
    "tau0 (GPa)",
    "hardness (GPa)",
    "junction growth",
    "area per load of the tests (1/GPa)",
)
MAX_INTERFACE_BYTES = 50_000_000  # bytes
_NUMERIC_HEADER_ENTRIES = ("area_per_load", "variation")

EXCLUSION_P_VALUE_LIMIT, ERROR_SCALING_P_VALUE_LIMIT = 0.01, 0.05
"""Limits of the p-value of a fit: for excluding the sliding rule, and for scaling the errors of the tests.

Below the first limit, the tests exclude the sliding rule. Below the second limit, the errors of the tests are scaled.
"""

MIN_AREA_VARIATION = 0.1
"""Minimum relative standard deviation of the area per load A/F among the tests, if both mu0 and tau0 are fitted."""

INTERVAL_COVERAGE = 0.95

DENSITY_WINDOW_WIDTH_AT_ZERO, DENSITY_WINDOW_WIDTH_AT_MAXIMUM = 0.05, 0.2
"""Widths of the windows in which the density of random samples is averaged: at 0, and at the maximum of the density.

The widths are fractions of the 97.5 % quantile. The density varies little near its maximum, so this window can be
wider, which makes the maximum less random.
"""

BOUND_HEADER_ENTRIES = {"mu0": "rows with mu0 = 0", "tau0": "rows with tau0 = 0"}
"""Header entries of an interface file: the numbers of rows, after the rows of the fit, in which mu0 or tau0 is 0."""

COMMON_ERROR_HEADER_ENTRY = "common error of the tests"
"""Header entry of an interface file that contains the relative standard uncertainty that all tests share.

Older files do not contain this entry.
"""

EXACT_INPUTS_HEADER_ENTRY = "exact inputs of the tests"
"""Header entry of an interface file that lists names and values (core units) of the inputs that are exact in tests.

The entry is missing if no input is exact, and in older files.
"""

TESTED_LOADS_HEADER_ENTRY = "loads of the tests (mN)"
"""Header entry of an interface file with the lowest and the highest load of the tests.

Older files do not contain this entry.
"""

RESERVED_HEADER_ENTRIES = (
    "sliding", *_NUMERIC_HEADER_ENTRIES, "separated", COMMON_ERROR_HEADER_ENTRY, *BOUND_HEADER_ENTRIES.values(),
    EXACT_INPUTS_HEADER_ENTRY, TESTED_LOADS_HEADER_ENTRY,
)  # fmt: skip
"""Header entries that `write_interface` derives from the interface, so that `about` must not contain them."""

SLIDING_RULES: tuple[SlidingRule, ...] = ("all", "opposing")

HARDNESS_HEADER_ENTRY = "hardness of the draws"
"""Header entry of an interface file that contains the hardness range, if all tests share this range."""

JUNCTION_GROWTH_HEADER_ENTRY = "junction growth of the draws"
"""Header entry of an interface file that contains the junction growth α of the tests.

The entry is missing if no test depends on α, or if α differs between tests.
"""

FAULTS_HEADER_ENTRY, CAUTIONS_HEADER_ENTRY = "do not quote", "quote with care"
"""Header entries of an interface file with caveats from its tests, according to which a coefficient may not be quoted,
or only with care.

`calibrate` fills these entries, so that the argument `about` of `write_interface` must not contain them.
"""

# For a file without columns of normal scores, scores are computed from the samples and limited to ± this number.
MAX_RECOVERED_NORMAL_SCORE = 5.0
_SCORE_COLUMN_PREFIX = "score of "


def shared_input_name(name: str, estimate: UncertainInput, pair_checksum: str) -> str:
    """Return a name that identifies an input: tests and pairs whose inputs have the same name share this input.

    Small contacts lose a larger fraction of their area than large ones, so another pair has another area loss.
    """
    text = f"{name} {estimate.distribution_text}"
    return f"{text} of {pair_checksum}" if name == "area_loss" else text


def area_error_name(pair_checksum: str) -> str:
    """Return the name of the relative error of a pair's true area. All friction tests of the pair share this error."""
    return f"area of {pair_checksum}"


# Estimate of a quantity: central number, lower limit and upper limit of its 95 % interval.
ValueWithLimits = tuple[float, float, float]


@dataclass(frozen=True)
class StrengthFit:
    """Fit of mu0 and tau0 to friction tests under one sliding rule: samples of mu0 and tau0, and quality of the fit."""

    sliding: SlidingRule
    # Chi-squared of the best fit, which has no meaning if the errors of the tests were not given.
    chi_squared: float
    # Degrees of freedom of the fit: number of tests that slid, minus number of fitted parameters.
    freedom: int
    # Probability that chance alone causes a larger chi-squared; NaN without given errors or degrees of freedom.
    probability: float
    scale: float
    # P-value of a trend of the residuals with the load. It is small if the fitted law does not describe the tests.
    trend: float
    # Random samples of mu0 and tau0 (GPa). Samples with the same index form a pair.
    mu0: Floats
    tau0: Floats
    # Hardness (GPa) for each sample of mu0 and tau0, or NaN if the tests have different hardnesses.
    hardness: Floats
    # Junction growth α for each sample of mu0 and tau0, or NaN if α differs between tests or has no effect.
    junction_growth: Floats
    # Area per load A/F (1/GPa) at the onset of sliding in the tests, or NaN if unknown.
    area_per_load: Floats
    # Standard normal scores of the samples of uncertain inputs and area errors, keyed by input or area-error name.
    # If a pair shares an uncertain input with the tests, the samples for the pair use the normal scores of this input.
    scores: Mapping[str, Floats] = field(default_factory=dict)
    # Fits with mu0 = 0 or tau0 = 0, keyed by the name of the fixed parameter, unless the tests exclude the value 0.
    fits_at_bounds: Mapping[str, StrengthFit] = field(default_factory=dict)
    # True area per load A/F (1/GPa) of each test; empty for a published interface or an interface from a file.
    area_per_load_of_tests: Floats = field(default_factory=lambda: np.empty(0))

    def resample(self, log_weights: Floats) -> StrengthFit:
        """Return a copy of the fit whose samples are drawn from the present samples in proportion to their weights.

        `log_weights` are the logarithms of the weights, which need no common scale. The fits at bounds are unchanged.
        """
        cumulative_weights = np.cumsum(np.exp(log_weights - log_weights.max()))
        indices = select_by_weight(cumulative_weights, log_weights.size, 0.5)
        sample_names = ("mu0", "tau0", "hardness", "junction_growth", "area_per_load")
        columns: dict[str, Any] = {name: getattr(self, name)[indices] for name in sample_names}
        return replace(self, **columns, scores={name: scores[indices] for name, scores in self.scores.items()})


@dataclass(frozen=True)
class InterfaceStrength:
    """Strength of an interface: joint distribution of molecular friction coefficient mu0 and shear strength tau0.

    Attributes
    ----------
    fits : tuple of StrengthFit
        Fits for the requested sliding rules, in order of preference.
    area_per_load : float, 1/GPa
        Median true area per load (A/F), averaged over the tests, at which mu0 + tau0 A/F is identified.
    variation : float
        Standard deviation of A/F among the tests that slid, divided by the mean; each test has the weight 1/error².
    separated : bool
        True if the tests determine mu0 and tau0 separately, rather than only the sum mu0 + tau0 A/F.
    advice : tuple of (str, float, float)
        Further tests that would separate mu0 and tau0, each with the expected standard errors of mu0 and tau0 (GPa)
        after these tests.
    tests : tuple of (float, float, float, bool)
        For each test: A/F (1/GPa), coefficient, standard uncertainty of the coefficient (NaN if not given), and True if
        the pair slid.
    about : mapping of str to str
        Kind ("measured", "lumped" or "bound"), materials, conditions and source.
    common : float
        Relative standard uncertainty that all tests share; NaN for a published interface or an older file.
    pair_faults : tuple of (str, str)
        Tested pair with the loads of its tests, and a fault that makes its A/F wrong. `about` contains these faults
        too. Empty for an interface from a file.
    exact_inputs : tuple of (str, float)
        Names and values (core units) of the inputs that are exact in at least one test, such as the hardness (GPa). The
        samples contain no error of these inputs.
    tested_hardness : float
        Lowest hardness (GPa) of the tested pairs or, if no pair has one, of the named materials of the tested balls.
        NaN if it is unknown, and for an interface from a file.
    tested_loads : tuple of float, mN
        Lowest and highest load of the tests; empty for a published interface or an older file.
    """

    fits: tuple[StrengthFit, ...]
    area_per_load: float
    variation: float
    separated: bool
    advice: tuple[tuple[str, float, float], ...] = ()
    tests: tuple[tuple[float, float, float, bool], ...] = ()
    about: Mapping[str, str] = field(default_factory=dict)
    common: float = math.nan
    pair_faults: tuple[tuple[str, str], ...] = ()
    exact_inputs: tuple[tuple[str, float], ...] = ()
    tested_hardness: float = math.nan
    tested_loads: tuple[float, ...] = ()

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read the strength of an interface from a file that `write_interface` wrote."""
        check_instance("path", path, (str, Path), "a path")
        try:
            lines = (
                read_file_bytes(parse_path("path", path), MAX_INTERFACE_BYTES, INTERFACE_FILE_HEADER.encode())
                .decode("utf-8")
                .splitlines()
            )
        except UnreadableFileError as error:
            raise ValueError(f"{printable_path(path)} is not an interface file: {error}") from None
        except OSError as error:
            raise ValueError(
                f"cannot read the interface file {printable_path(path)}: {describe_os_error(error)}"
            ) from None
        except UnicodeDecodeError:
            raise ValueError(
                f"{printable_path(path)} is not an interface file, because it is not a text file"
            ) from None
        header = dict(line[2:].partition(": ")[::2] for line in lines[1:] if line.startswith("# "))
        rows = [line for line in lines if line and not line.startswith("#")]
        try:
            num_columns, titles = len(INTERFACE_FILE_COLUMNS), next(csv.reader(rows))
            if (
                lines[0] != INTERFACE_FILE_HEADER
                or tuple(titles[:num_columns]) != INTERFACE_FILE_COLUMNS
                or not all(title.startswith(_SCORE_COLUMN_PREFIX) for title in titles[num_columns:])
            ):
                raise ValueError
            sample_table = np.array([[float(cell) for cell in row] for row in csv.reader(rows[1:])])
            area_per_load, variation = (float(header.pop(name)) for name in _NUMERIC_HEADER_ENTRIES)
            sliding, separated = header.pop("sliding"), header.pop("separated") == "yes"
            bound_row_counts = {
                name: int(header.pop(entry)) for name, entry in BOUND_HEADER_ENTRIES.items() if entry in header
            }
            common = float(header.pop(COMMON_ERROR_HEADER_ENTRY, math.nan))
            if not (math.isnan(common) or 0 <= common < 1):
                raise ValueError
            exact_inputs = tuple(
                (name, float(value))
                for name, _, value in (
                    item.partition(" ") for item in header.pop(EXACT_INPUTS_HEADER_ENTRY, "").split(", ") if item
                )
            )
            loads_text = header.pop(TESTED_LOADS_HEADER_ENTRY, "")
            tested_loads = tuple(float(load) for load in loads_text.split(", ") if load)
            if not all(0 < load < math.inf for load in tested_loads):
                raise ValueError
            check_choice("sliding", sliding, SlidingRule)
            parse_study_input("junction_growth", header.get(JUNCTION_GROWTH_HEADER_ENTRY, "0"))
        except (ValueError, KeyError, csv.Error, StopIteration):
            reason = "an entry of the header is missing or unknown, or a row does not have a number in each column"
            raise ValueError(f"{printable_path(path)} is a damaged interface file ({reason})") from None
        if (
            sample_table.ndim != 2
            or sample_table.shape[1] != len(titles)
            or not (np.isfinite(sample_table[:, :2]) & (sample_table[:, :2] >= 0)).all()
            or np.isnan(sample_table[:, num_columns:]).any()
        ):
            raise ValueError(f"{printable_path(path)} is a damaged interface file (mu0 and tau0 must be at least 0)")
        num_rows = len(sample_table) - sum(bound_row_counts.values())
        if num_rows < 1 or min(bound_row_counts.values(), default=1) < 1:
            raise ValueError(f"{printable_path(path)} is a damaged interface file (rows of samples are missing)")

        def build_fit(rows: Floats) -> StrengthFit:
            scores = {
                title.removeprefix(_SCORE_COLUMN_PREFIX): column
                for title, column in zip(titles[num_columns:], rows.T[num_columns:], strict=True)
            }
            fit = _build_strength_fit(sliding, *rows.T[:num_columns])
            return replace(fit, scores=scores or _compute_normal_scores_of_old_interface_file(fit, header))

        ends = np.cumsum([num_rows, *bound_row_counts.values()])
        fit, *fits_at_bounds = (build_fit(rows) for rows in np.split(sample_table, ends[:-1]))
        fit = replace(
            fit,
            fits_at_bounds=dict(zip(bound_row_counts, fits_at_bounds, strict=True))
            if bound_row_counts
            else _estimate_fits_at_bounds(fit),
        )
        return cls(
            (fit,), area_per_load, variation, separated, about=header, common=common, exact_inputs=exact_inputs,
            tested_loads=tested_loads,
        )  # fmt: skip

    @classmethod
    def named(cls, name_or_path: str | Path) -> Self:
        """Return the strength of a published interface by its name, or read the strength from an interface file."""
        check_instance("interface", name_or_path, (str, Path), "a name or a path")
        published_entry = _published_interfaces().get(str(name_or_path))
        if published_entry is None:
            if Path(name_or_path).is_file():
                return cls.read(name_or_path)
            known_names = "; ".join(_published_interfaces())
            raise ValueError(f"interface must be a file or one of {known_names}, got {short_repr(str(name_or_path))}")
        ranges: dict[str, UncertainInput] = {
            "mu0": parse_uncertain_input("mu0", published_entry["mu0"]),
            "tau0": parse_uncertain_input("tau0", published_entry["tau0"], "pressure"),
        }
        samples = draw_input_samples(ranges)
        unknown_samples = np.full(samples["mu0"].size, math.nan)
        fit = _build_strength_fit(
            "all", samples["mu0"], samples["tau0"], unknown_samples, unknown_samples, unknown_samples
        )
        description = {key: text for key, text in published_entry.items() if key not in ranges}
        return cls((fit,), math.nan, math.nan, separated=True, about={"name": str(name_or_path), **description})

    def __repr__(self) -> str:
        """Return a text with mu0 + tau0 A/F and, if the tests separate mu0 from tau0, with mu0 and tau0."""
        labelled_intervals = [("mu0 + tau0 A/F", self.identified, "")]
        if self.separated:
            tau0, low, high = (1e3 * value for value in self.tau0)
            labelled_intervals += [("mu0", self.mu0, ""), ("tau0", (tau0, low, high), " MPa")]
        rows = [
            f"  {name:<14}  {value:.4g} [{low:.4g}, {high:.4g}]{unit}"
            for name, (value, low, high), unit in labelled_intervals
            if math.isfinite(value)
        ]
        return "\n".join(["Interface", *rows, *(f"  {key:<14}  {text}" for key, text in self.about.items())])

    def with_caveats(self, entry: str, texts: Sequence[str]) -> Self:
        """Return a copy of the interface with caveats added to the faults or to the cautions in its file header.

        Interface files contain the caveats, so that they also apply to the coefficients of pairs with this interface.
        """
        all_texts = [*filter(None, [self.about.get(entry)]), *texts]
        return replace(self, about={**self.about, entry: "; ".join(all_texts)}) if texts else self

    @property
    def has_unknown_range(self) -> bool:
        """True if the source publishes a single number for mu0 and a single number for tau0, without ranges."""
        return bool(np.ptp(self.fits[0].mu0) == np.ptp(self.fits[0].tau0) == 0)

    @property
    def tested_area_per_load(self) -> ValueWithLimits:
        """Mean true area per load A/F (1/GPa) in the tests, with its 95 % interval.

        The limits are NaN without joint samples of A/F, as in older files.
        """
        samples = self.fits[0].area_per_load
        if not np.isfinite(samples).all():
            return self.area_per_load, math.nan, math.nan
        low, high = np.quantile(samples, find_tail_probabilities())
        return self.area_per_load, float(low), float(high)

    @property
    def identified(self) -> ValueWithLimits:
        """Sum mu0 + tau0 A/F at the A/F of the friction tests, with its 95 % interval. The tests determine this sum.

        A/F is the true area per load of the tests. The value is NaN if A/F is unknown.
        """
        if not np.isfinite(self.fits[0].area_per_load).all():
            return self.at(self.area_per_load) if math.isfinite(self.area_per_load) else (math.nan,) * 3
        return cover_credible_intervals(
            [(FrictionLaw(fit.mu0, fit.tau0).force(1.0, fit.area_per_load), each) for fit, each in self.sampled_fits]
        )

    @property
    def mu0(self) -> ValueWithLimits:
        """Molecular friction coefficient mu0 with its 95 % interval.

        The value is NaN if the tests do not separate mu0 from tau0.
        """
        return self.strength_intervals[0] if self.separated else (math.nan,) * 3

    @property
    def tau0(self) -> ValueWithLimits:
        """Adhesive shear strength tau0 (GPa) with its 95 % interval.

        The value is NaN if the tests do not separate tau0 from mu0.
        """
        return self.strength_intervals[1] if self.separated else (math.nan,) * 3

    @cached_property
    def strength_intervals(self) -> tuple[ValueWithLimits, ValueWithLimits]:
        """Median and 95 % interval of mu0 and of tau0 (GPa), even if the tests do not separate mu0 from tau0."""
        return self.interval_of(lambda mu0, tau0: mu0), self.interval_of(lambda mu0, tau0: tau0)

    @cached_property
    def sampled_fits(self) -> tuple[tuple[StrengthFit, float], ...]:
        """Fits of the interface to friction tests, each with the coverage (a probability) of the fit's interval.

        Intervals of the interface cover the intervals of all these fits. The coverage is 95 % for the first fit. For
        the fits with mu0 = 0 and with tau0 = 0, the coverage decreases with the probability of these values; fits that
        the tests exclude are missing (see `compute_coverage_at_bound`).
        """
        fit = self.fits[0]
        bounds = (
            (bound_fit, compute_coverage_at_bound(getattr(fit, name))) for name, bound_fit in fit.fits_at_bounds.items()
        )
        return (fit, INTERVAL_COVERAGE), *((bound_fit, coverage) for bound_fit, coverage in bounds if coverage > 0)

    @property
    def possible_zeros(self) -> tuple[str, ...]:
        """Names of the parameters (mu0, tau0) that may be 0 according to the tests; empty for a one-parameter fit."""
        fit = self.fits[0]
        return tuple(name for name in fit.fits_at_bounds if compute_coverage_at_bound(getattr(fit, name)) > 0)

    @property
    def samples_at_bounds(self) -> tuple[tuple[Floats, Floats], ...]:
        """Samples of mu0 and tau0 (GPa) from each fit with mu0 = 0 or tau0 = 0 that the tests do not exclude."""
        return tuple((fit.mu0, fit.tau0) for fit, _ in self.sampled_fits[1:])

    def interval_of(self, coefficient: Callable[[Floats, Floats], Floats]) -> ValueWithLimits:
        """Return the median and the 95 % interval of a quantity that is a function of mu0 and tau0 (GPa).

        The interval also covers the coefficients for mu0 = 0 and for tau0 = 0, unless the tests exclude these values.
        """
        check_callable("coefficient", coefficient)
        return cover_credible_intervals([(coefficient(fit.mu0, fit.tau0), each) for fit, each in self.sampled_fits])

    def at(self, area_per_load: float) -> ValueWithLimits:
        """Return the sum mu0 + tau0 A/F at a given true area per load A/F (1/GPa), with its 95 % interval."""
        area_per_load = validate_number("area_per_load", area_per_load)
        if area_per_load < 0:
            raise ValueError(f"area_per_load must be at least 0, got {area_per_load:g}")
        return self.interval_of(lambda mu0, tau0: FrictionLaw(mu0, tau0).force(1.0, area_per_load))

    @property
    def excluded(self) -> tuple[SlidingRule, ...]:
        """Sliding rules that the friction tests contradict, or no rules if the tests agree with none of them."""
        accepted_rules = [fit.sliding for fit in self.fits if fit.probability > ERROR_SCALING_P_VALUE_LIMIT]
        return tuple(fit.sliding for fit in self.fits if fit.probability < EXCLUSION_P_VALUE_LIMIT and accepted_rules)

    @cached_property
    def draws(self) -> pandas.DataFrame:
        """Table of samples from the joint distribution of mu0, tau0 (GPa) and hardness (GPa), one sample per row.

        The hardness is NaN unless all tests have the same hardness range.
        """
        import pandas

        fit = self.fits[0]
        return pandas.DataFrame({"mu0": fit.mu0, "tau0": fit.tau0, "hardness": fit.hardness})

    @property
    def junction_growth(self) -> UncertainInput | None:
        """Junction growth α in the tests, or None if tests differ in α or if α affects no test."""
        if JUNCTION_GROWTH_HEADER_ENTRY not in self.about:
            return None
        median = float(f"{np.median(self.fits[0].junction_growth):.4g}")
        return replace(parse_study_input("junction_growth", self.about[JUNCTION_GROWTH_HEADER_ENTRY]), value=median)

    def has_equal_junction_growth(self, growth: UncertainInput | None) -> bool:
        """Return whether a distribution of the junction growth α equals the distribution in the friction tests.

        The value None of `growth` stands for α = 0.
        """
        return has_growth_of_tests(growth, self.junction_growth)


def has_growth_of_tests(growth: UncertainInput | None, test_growth: UncertainInput | None) -> bool:
    """Return whether a junction growth α has the same distribution as in the calibration with friction tests.

    The value None of `growth` stands for α = 0, and the value None of `test_growth` for an unknown α.
    """
    if test_growth is None or growth is None:
        return test_growth is not None and test_growth.high == 0
    are_same_kind = test_growth.uses_slip_lines == growth.uses_slip_lines
    return (
        are_same_kind
        and test_growth.distribution == growth.distribution
        and np.allclose([test_growth.low, test_growth.high], [growth.low, growth.high])
    )


def compute_coverage_at_bound(values: Floats) -> float:
    """Return the interval coverage for a fit with mu0 = 0 (or tau0 = 0), from samples of the unconstrained fit.

    The samples are those of mu0 (or tau0) in a fit in which this parameter is free.

    A normal density falls to exp(-z²/2) of its maximum at z standard deviations. At 0, where the density falls to
    exp(-d²/2), the part of the 95 % region with z² < 1.96² - d² remains. This probability is 95 % if the density at 0
    is the maximum, and 0 if it is below exp(-1.96²/2) = 15 % of the maximum. A number is then excluded from being 0.
    """
    sorted_values = np.sort(values)
    scale = float(np.quantile(sorted_values, (1 + INTERVAL_COVERAGE) / 2))
    if not (math.isfinite(scale) and sorted_values[0] < scale):
        return 0.0

    def density(starts: Floats, width: float) -> Floats:
        window_ends = np.searchsorted(sorted_values, starts + width * scale, side="right")
        return np.asarray((window_ends - np.searchsorted(sorted_values, starts)) / width)

    density_at_bound = float(density(np.zeros(1), DENSITY_WINDOW_WIDTH_AT_ZERO)[0])
    max_density = max(float(density(sorted_values, DENSITY_WINDOW_WIDTH_AT_MAXIMUM).max()), density_at_bound)
    if density_at_bound == 0:
        return 0.0
    squared_score = max(Z_95**2 + 2 * math.log(density_at_bound / max_density), 0.0)
    # The probability is 95 % if the density is highest at 0, and lower otherwise; `min` removes the round-off of `erf`.
    return min(math.erf(math.sqrt(squared_score / 2)), INTERVAL_COVERAGE)


def find_tail_probabilities(coverage: float = INTERVAL_COVERAGE) -> Floats:
    """Return the cumulative probabilities at the two limits of an equal-tailed interval with the given coverage."""
    tail = round((1 - coverage) / 2, 12)
    return np.array([tail, 1 - tail])


def compute_credible_interval(
    values: Floats, bound: float = -math.inf, coverage: float = INTERVAL_COVERAGE
) -> ValueWithLimits:
    """Return the median of samples and a credible interval that contains 95 % of the samples by default.

    The interval has equal tails, unless the samples include the bound. Then the interval starts at the bound, and only
    the fraction of the lower tail that lies outside a region of highest density is left.
    """
    tails = find_tail_probabilities(coverage)
    low, high = (float(end) for end in np.quantile(values, tails))
    if math.isfinite(bound) and (coverage_at_bound := compute_coverage_at_bound(values - bound)) > 0:
        upper_tail = float(tails[0]) * (1 + coverage_at_bound / INTERVAL_COVERAGE)
        low, high = bound, float(np.quantile(values, 1 - upper_tail))
    return float(np.median(values)), low, high


def cover_credible_intervals(samples: Sequence[tuple[Floats, float]]) -> ValueWithLimits:
    """Return the median of the first array, and an interval that contains the credible intervals of all arrays.

    Each array is given with the probability of its interval.
    """
    medians, lower_limits, upper_limits = zip(
        *(compute_credible_interval(values, 0.0, coverage) for values, coverage in samples), strict=True
    )
    return medians[0], min(lower_limits), max(upper_limits)


# ---- Files -----------------------------------------------------------------------------------------------------------


def write_interface(interface: InterfaceStrength, path: str | Path, about: Mapping[str, str] | None = None) -> None:
    """Write the strength of an interface to a text file: a header, and one row per sample of (mu0, tau0).

    Parameters
    ----------
    interface : Interface
        Interface to write.
    path : path
        Path of the file. An existing file is replaced only if it is an interface file.
    about : mapping of str to str, optional
        Additional entries of the header, such as materials, conditions and operator.

    Raises
    ------
    ValueError
        If the path is a file of another kind, or if the file cannot be written.

    See Also
    --------
    read_interface : Inverse function.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from stiction import interface, read_interface, write_interface
    >>> with tempfile.TemporaryDirectory() as directory:
    ...     path = Path(directory) / "film.csv"
    ...     write_interface(interface("MoS2 on bearing steel, dry air"), path, {"operator": "A. B."})
    ...     read_interface(path).about["operator"]
    'A. B.'
    """
    check_instance("interface", interface, InterfaceStrength, "an Interface from calibrate()")
    about = {} if about is None else about
    check_instance("about", about, Mapping, "a mapping of names to texts")
    content = _format_interface(interface, about)
    with replace_file_atomically(parse_path("path", path), INTERFACE_FILE_HEADER.encode(), ValueError) as file:
        file.write_bytes(content)


def store_interface(interface: InterfaceStrength, directory: Path) -> Path:
    """Write the interface of a study to a file in a directory, and return the path of the file.

    The directory may contain interfaces of other studies, whose files are not changed.
    """
    content = _format_interface(interface, {})
    path = directory / "interface.csv"
    directory.mkdir(parents=True, exist_ok=True)
    if path.exists() and path.read_bytes() != content:
        path = directory / f"interface-{zlib.crc32(content):08x}.csv"
    write_interface(interface, path)
    return path


def _format_interface(interface: InterfaceStrength, about: Mapping[str, str]) -> bytes:
    header = {
        "sliding": interface.fits[0].sliding,
        "area_per_load": repr(interface.area_per_load),
        "variation": repr(interface.variation),
        "separated": "yes" if interface.separated else "no",
    }
    if not math.isnan(interface.common):
        header[COMMON_ERROR_HEADER_ENTRY] = repr(interface.common)
    if interface.exact_inputs:
        header[EXACT_INPUTS_HEADER_ENTRY] = ", ".join(f"{name} {value!r}" for name, value in interface.exact_inputs)
    if interface.tested_loads:
        header[TESTED_LOADS_HEADER_ENTRY] = ", ".join(map(repr, interface.tested_loads))
    fits_at_bounds = interface.fits[0].fits_at_bounds
    header |= {BOUND_HEADER_ENTRIES[name]: str(fit.mu0.size) for name, fit in fits_at_bounds.items()}
    reserved_keys = (*RESERVED_HEADER_ENTRIES, FAULTS_HEADER_ENTRY, CAUTIONS_HEADER_ENTRY)
    for key, value in {**interface.about, **about}.items():
        text = " ".join(str(value).split())
        is_reserved = key in RESERVED_HEADER_ENTRIES or (key in reserved_keys and key in about)
        if not key.strip() or is_reserved or ": " in f"{key} " or key != printable_text(key):
            raise ValueError(
                "each key of `about` must be printable and have no colon, and must not be one of "
                f"{', '.join(map(repr, reserved_keys))}, got {short_repr(key)}"
            )
        header[key] = printable_text(text, len(text))
    file_text, fit = io.StringIO(), interface.fits[0]
    titles = [*INTERFACE_FILE_COLUMNS, *(f"{_SCORE_COLUMN_PREFIX}{name}" for name in fit.scores)]
    file_text.write(
        "\n".join([INTERFACE_FILE_HEADER, *(f"# {key}: {value}" for key, value in header.items()), ",".join(titles)])
        + "\n"
    )
    for each in (fit, *fits_at_bounds.values()):
        columns = [each.mu0, each.tau0, each.hardness, each.junction_growth, each.area_per_load]
        columns += [each.scores[name] for name in fit.scores]
        np.savetxt(file_text, np.stack(columns, axis=1), fmt="%.9g", delimiter=",")
    return file_text.getvalue().encode()


def _build_strength_fit(sliding: Any, mu0: Any, tau0: Any, *other_samples: Any) -> StrengthFit:
    return StrengthFit(sliding, math.nan, 0, math.nan, 1.0, math.nan, mu0, tau0, *other_samples)


def _estimate_fits_at_bounds(fit: StrengthFit) -> dict[str, StrengthFit]:
    """Estimate the fits with mu0 = 0 and with tau0 = 0, which older interface files do not contain.

    The other coefficient is shifted so that the sum mu0 + tau0 A/F at the A/F of the tests does not change.
    """
    if not np.isfinite(fit.area_per_load).all() or np.ptp(fit.mu0) == 0 or np.ptp(fit.tau0) == 0:
        return {}
    zeros, sums = np.zeros(fit.mu0.size), FrictionLaw(fit.mu0, fit.tau0).force(1.0, fit.area_per_load)
    return {
        "mu0": replace(fit, mu0=zeros, tau0=sums / fit.area_per_load), "tau0": replace(fit, mu0=sums, tau0=zeros)
    }  # fmt: skip


def _compute_normal_scores_of_old_interface_file(fit: StrengthFit, header: Mapping[str, str]) -> dict[str, Floats]:
    """Compute normal scores of hardness and junction growth for an interface file of an old version.

    Such files contain the samples without scores.
    """
    from scipy.special import ndtr

    columns = {
        "hardness": (HARDNESS_HEADER_ENTRY, fit.hardness),
        "junction_growth": (JUNCTION_GROWTH_HEADER_ENTRY, fit.junction_growth),
    }
    nodes, scores = np.linspace(-MAX_RECOVERED_NORMAL_SCORE, MAX_RECOVERED_NORMAL_SCORE, 2001), {}
    for name, (entry, samples) in columns.items():
        if entry not in header or np.isnan(samples).any():
            continue
        try:
            estimate = parse_study_input(name, header[entry])
        except ValueError:
            continue
        if not estimate.is_exact:
            scores[shared_input_name(name, estimate, "")] = np.interp(samples, estimate.quantile(ndtr(nodes)), nodes)
    return scores


def interfaces() -> dict[str, dict[str, str]]:
    """Return all published interfaces by name, each as a dict of texts such as kind, mu0, tau0 and source.

    Returns
    -------
    entries : dict of str to dict of str to str
        Entries by name, such as kind, mu0 and tau0 with their units, conditions, motion and source.

    See Also
    --------
    interface : Single interface by its name.

    Examples
    --------
    >>> from stiction import interfaces
    >>> interfaces()["MoS2 on bearing steel, dry air"]["kind"]
    'measured'
    """
    return {name: dict(entry) for name, entry in _published_interfaces().items()}


@cache
def _published_interfaces() -> dict[str, dict[str, str]]:
    text = (resources.files("stiction.study") / "interfaces.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def read_interface_entries(path: str | Path) -> dict[str, dict[str, str]]:
    """Return the entries (kind, mu0, tau0, ...) of an interface file, or of all in a directory, keyed by file name.

    Files of other kinds in the directory are ignored.
    """
    entries, path = {}, Path(path)
    is_single_file = path.is_file()
    try:
        files = (
            [path]
            if is_single_file
            else sorted(directory_item for directory_item in path.iterdir() if directory_item.is_file())
        )
    except OSError as error:
        raise ValueError(f"{printable_path(path)} cannot be listed: {describe_os_error(error)}") from None
    for file in files:
        with contextlib.nullcontext() if is_single_file else contextlib.suppress(ValueError):
            interface_in_file = InterfaceStrength.read(file)
            (_, *mu0), (_, *tau0) = interface_in_file.strength_intervals
            entries[file.name] = {"kind": "measured", **interface_in_file.about} | {
                "mu0": f"{mu0[0]:.3g}..{mu0[1]:.3g}", "tau0": f"{1e3 * tau0[0]:.3g}..{1e3 * tau0[1]:.3g} MPa",
                "area_per_load": f"{interface_in_file.area_per_load:.3g} /GPa",
            }  # fmt: skip
    return entries


class InterfaceSettings(SettingsSection):
    """Section of a study file for an interface, which defines mu0 and tau0 together.

    `mu0`, `tau0` and `sliding` apply if the file of the interface is missing or has changed. `faults`, `cautions`,
    `separated` and `junction_growth` apply if the file is missing; older study files do not contain these keys.
    """

    file: str = Field(min_length=1, max_length=4096, description="Name or file of an interface.")
    mu0: FrictionCoefficientEntry
    tau0: ShearStrengthEntry
    sliding: SlidingRule = Field(
        default="all", description="Sliding rule under which mu0 and tau0 were fitted: all or opposing contacts."
    )
    faults: str | None = Field(
        default=None, description="Caveats of the tests, because of which no coefficient may be quoted; may be empty."
    )
    cautions: str | None = Field(
        default=None, description="Caveats of the tests, because of which to quote with care; may be empty."
    )
    separated: bool | None = Field(
        default=None, description="False if the tests determine only mu0 + tau0 A/F, and not mu0 and tau0 separately."
    )
    junction_growth: str | None = Field(
        default=None, description="Junction growth α of the tests; empty if α differs between tests or has no effect."
    )

    @classmethod
    def from_source(cls, name_or_path: str) -> InterfaceSettings:
        """Create the interface of a study from the name of a published interface, or from an interface file."""
        is_published = name_or_path in _published_interfaces()
        try:
            file = name_or_path if is_published else str(Path(name_or_path).resolve())
            strength = _read_cached_interface(file, 0 if is_published else Path(file).stat().st_mtime_ns)
        except OSError:
            # If the file cannot be read, `InterfaceStrength.named` raises an error that lists the published interfaces.
            strength = InterfaceStrength.named(name_or_path)
        mu0, tau0 = (
            _format_strength(median, interval, scale, unit)
            for median, interval, scale, unit in zip(
                round_median_strength(strength), strength.strength_intervals, (1.0, 1e3), ("", " MPa"), strict=True
            )
        )
        return cls.model_validate({
            "file": file, "mu0": mu0, "tau0": tau0, "sliding": strength.fits[0].sliding,
            "faults": strength.about.get(FAULTS_HEADER_ENTRY, ""),
            "cautions": strength.about.get(CAUTIONS_HEADER_ENTRY, ""), "separated": strength.separated,
            "junction_growth": strength.about.get(JUNCTION_GROWTH_HEADER_ENTRY, ""),
        })  # fmt: skip

    def find_current_entry(self) -> InterfaceSettings | None:
        """Return the study entry of the interface file; None if the file is unreadable or contains other mu0 or tau0.

        A changed file has other central values of mu0 or tau0. The ranges are not compared, because the rule for
        intervals of a fit depends on the version of the program that stored the entry.
        """
        try:
            entry = InterfaceSettings.from_source(self.file)
        except (ValueError, OSError):
            return None
        central_values, stored_values = ((float(each.mu0), float(each.tau0)) for each in (entry, self))
        return entry if central_values == stored_values else None

    def load(self) -> InterfaceStrength | None:
        """Load the strength of the interface, or return None if the interface file is missing or has changed."""
        if self.find_current_entry() is None:
            return None
        try:
            return _read_cached_interface(self.file, 0 if self.is_published else Path(self.file).stat().st_mtime_ns)
        except (ValueError, OSError):
            return None

    @property
    def caveats_of_missing_file(self) -> dict[str, str] | None:
        """Caveats of the friction tests that the study stores, if the interface file is missing; otherwise None.

        The value is also None if no caveats are stored. The caveats are unknown if the file has changed, or if an older
        version of the program stored this section.
        """
        if self.faults is None or self.cautions is None or os.path.lexists(self.file):
            return None
        return {FAULTS_HEADER_ENTRY: self.faults, CAUTIONS_HEADER_ENTRY: self.cautions}

    def find_junction_growth(self) -> UncertainInput | None:
        """Return the junction growth α of the tests from the interface file or, if the file is missing, from the study.

        Returns None if α differs between tests, has no effect on the tests or is unknown.
        """
        if (strength := self.load()) is not None:
            return strength.junction_growth
        if not self.junction_growth or self.caveats_of_missing_file is None:
            return None
        return parse_study_input("junction_growth", self.junction_growth)

    @property
    def is_published(self) -> bool:
        """True if the interface is in the published list, and False if it comes from a file."""
        return self.file in _published_interfaces()

    @property
    def name(self) -> str:
        """Name of a published interface, or name of an interface file without directory."""
        return Path(self.file).name

    @property
    def fitted_rule(self) -> SlidingRule:
        """Sliding rule under which mu0 and tau0 were fitted.

        Old study files do not contain this rule.
        """
        strength = self.load()
        return self.sliding if strength is None else strength.fits[0].sliding

    @model_serializer(mode="wrap")
    def _serialize(self, serialize: SerializerFunctionWrapHandler) -> Any:
        is_unchanged = self.is_published and InterfaceSettings.from_source(self.file) == self
        return self.file if is_unchanged else serialize(self)


def _format_strength(median: float, interval: ValueWithLimits, scale: float, unit: str) -> str:
    """Format mu0 or tau0 with its 95 % interval as text for a study file, such as "50 MPa (20..80 MPa)"."""
    low, high = (f"{scale * end:.4g}" for end in interval[1:])
    central = exact_quantity_text(median, "GPa") if unit else repr(median)
    return f"{central} ({low}..{high}{unit})" if float(low) < float(high) else central


@lru_cache(maxsize=8)
def _read_cached_interface(name_or_path: str, _modification_time: int) -> InterfaceStrength:
    return InterfaceStrength.named(name_or_path)


def round_median_strength(strength: InterfaceStrength) -> tuple[float, float]:
    """Return the medians of mu0 and tau0 (GPa), rounded to four digits."""
    mu0, tau0 = (float(f"{np.median(samples):.4g}") for samples in (strength.fits[0].mu0, strength.fits[0].tau0))
    return mu0, tau0
