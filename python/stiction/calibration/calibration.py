"""Calibration of an interface: mu0 and tau0 from friction tests on scanned surfaces.

A test gives a coefficient y at a load, and its surfaces give six sums over the contacts at this load. Coefficient and
sums satisfy y (F_N0 + mu0 F_Nm + tau0 F_Na) = F_T0 + mu0 F_Tm + tau0 F_Ta, which is linear in mu0 and tau0. For small
slopes and friction at all contacts, this reduces to y = mu0 + tau0 A/F. The tests separate mu0 and tau0 only if A/F
varies among the tests.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from stiction._arguments import MAX_INPUT_NUMBER
from stiction._checks import check_bool, check_choice, validate_number
from stiction._units import short_repr, to_core_units
from stiction.calibration.fit import CalibrationProblem
from stiction.calibration.friction_tests import (
    Ball,
    FrictionTest,
    find_pair_faults,
    find_tested_hardness,
    list_sliding_rules,
)
from stiction.calibration.prediction import Interface
from stiction.mechanics.model import SlidingRule
from stiction.study.interfaces import (
    CAUTIONS_HEADER_ENTRY,
    ERROR_SCALING_P_VALUE_LIMIT,
    EXCLUSION_P_VALUE_LIMIT,
    FAULTS_HEADER_ENTRY,
    HARDNESS_HEADER_ENTRY,
    JUNCTION_GROWTH_HEADER_ENTRY,
    MIN_AREA_VARIATION,
    SLIDING_RULES,
    StrengthFit,
    round_median_strength,
)

# Errors of friction tests are estimated from the scatter of the tests only if at least this many tests reached sliding.
MIN_SLIDING_TESTS = 3
MAX_ERROR_SCALE = 3.0


def calibrate(
    tests: Sequence[FrictionTest],
    *,
    common: float = 0.02,
    sliding: SlidingRule | Literal["both"] = "both",
    mu0: float | None = None,
    tau0: float | str | None = None,
    outliers: bool = False,
) -> Interface:
    """Fit the joint distribution of mu0 and tau0 of an interface to friction tests on scanned surfaces.

    Parameters
    ----------
    tests : sequence of FrictionTest
    common : float
        Relative standard uncertainty that all tests share, such as that of the force sensor or the load.
    sliding : {"both", "all", "opposing"}
        Sliding rule. With "both", the rule "all" comes first unless the tests exclude it and fit the other rule.
    mu0, tau0 : float, tau0 in GPa or as text
        Exact value of mu0 or tau0, if it is known.
    outliers : bool
        True if the tests may have outliers; their errors then follow Student's t instead of a normal distribution.

    Returns
    -------
    Interface

    Raises
    ------
    ValueError
        If no test slid, or an argument is outside its range.

    Notes
    -----
    For fixed gain, areas, hardness, creep and moduli, the tests are linear in mu0 and tau0. The density of mu0 and tau0
    is computed on a grid, so it is correct even if all tests have the same A/F. The priors are uniform in mu0 and in
    tau0 A/F, from 0. Gain, areas and ranges are marginalized by adaptive importance sampling. At the best fit of all
    parameters, the residuals are compared with the errors. If the residuals are too large, the errors are assumed to be
    known only up to a factor. Runs have relative offsets, whose standard deviation has a half-Cauchy prior with a
    median of 10 %.

    Examples
    --------
    >>> from stiction import Ball, FrictionTest, calibrate
    >>> ball = Ball("5 mm", "3 GPa")
    >>> loads = [5.0, 20.0, 100.0, 500.0, 2000.0]
    >>> tests = [
    ...     FrictionTest(ball, load, coefficient=0.15 + 0.012 * ball.area_per_load(load), uncertainty=0.01)
    ...     for load in loads
    ... ]
    >>> interface = calibrate(tests)
    >>> interface.separated, round(interface.tau0[0], 3)
    (True, 0.012)
    """
    check_choice("sliding", sliding, Literal["both", "all", "opposing"])
    if not isinstance(tests, Sequence) or not all(isinstance(test, FrictionTest) for test in tests):
        raise ValueError(f"tests must be a sequence of FrictionTest objects, got {short_repr(tests)}")
    tests = tuple(tests)
    if not any(test.slid for test in tests):
        raise ValueError(
            "tests must contain at least one test with sliding, because a test without sliding gives only a lower bound"
        )
    check_bool("outliers", outliers)
    common = validate_number("common", common)
    if not 0 <= common < 1:
        raise ValueError(f"`common` must be at least 0 and below 1, got {short_repr(common)}")
    has_no_error = {test.uncertainty is None for test in tests}
    if len(has_no_error) > 1:
        raise ValueError("either all tests or no test must have an uncertainty")
    if True in has_no_error and sum(test.slid for test in tests) < MIN_SLIDING_TESTS:
        raise ValueError(
            f"uncertainty must be given if there are fewer than {MIN_SLIDING_TESTS} tests with sliding, "
            "because the uncertainty cannot be estimated from so few tests"
        )
    known_strengths = (
        None if mu0 is None else validate_number("mu0", mu0, below=MAX_INPUT_NUMBER),
        None
        if tau0 is None
        else validate_number("tau0", to_core_units("tau0", tau0, "pressure"), below=MAX_INPUT_NUMBER),
    )
    if any(value is not None and value < 0 for value in known_strengths):
        raise ValueError(f"mu0 and tau0 must not be negative, got mu0 {short_repr(mu0)} and tau0 {short_repr(tau0)}")
    available_rules = [rule for rule in SLIDING_RULES if all(rule in list_sliding_rules(test.result) for test in tests)]
    if all(isinstance(test.result, Ball) for test in tests) and sliding == "both":
        # A ball has one contact, for which both sliding rules give the same friction.
        available_rules = available_rules[:1]
    rules = available_rules if sliding == "both" else [sliding]
    if not available_rules:
        raise ValueError("the results of all tests must have coefficients for the same sliding rule")
    if not set(rules) <= set(available_rules):
        raise ValueError(
            f"sliding must be a rule for which every result has coefficients ({', '.join(available_rules)}), "
            f"got {short_repr(sliding)}"
        )
    problems = [CalibrationProblem(tests, rule, common, known_strengths, outliers=outliers) for rule in rules]
    fits = [problem.fit() for problem in problems]
    if (
        len(fits) == 2
        and fits[0].probability < EXCLUSION_P_VALUE_LIMIT
        and fits[1].probability > ERROR_SCALING_P_VALUE_LIMIT
    ):
        fits, problems = fits[::-1], problems[::-1]
    first_problem = problems[0]
    area_per_load_of_tests = fits[0].area_per_load_of_tests
    variation = first_problem.compute_area_per_load_variation(area_per_load_of_tests)
    is_separated = any(value is not None for value in known_strengths) or (
        len(tests) > 2 and variation >= MIN_AREA_VARIATION
    )
    mean_area_per_load = float(np.median(fits[0].area_per_load))
    if not math.isfinite(mean_area_per_load):
        mean_area_per_load = first_problem.average_over_tests(area_per_load_of_tests)
    test_points = [
        (float(ratio), float(test.coefficient or 0.0), float(test.uncertainty or math.nan), test.slid)
        for ratio, test in zip(area_per_load_of_tests, tests, strict=True)
    ]
    tested_hardness, loads = find_tested_hardness(tests), [float(test.load) for test in tests]
    advice = () if is_separated else first_problem.suggest_tests(mean_area_per_load, tested_hardness)
    header_entries = {"kind": "measured"} | (
        {HARDNESS_HEADER_ENTRY: first_problem.shared_hardness.text} if first_problem.shared_hardness else {}
    )
    header_entries |= (
        {JUNCTION_GROWTH_HEADER_ENTRY: first_problem.junction_growth.short_text}
        if first_problem.junction_growth is not None
        else {}
    )
    interface = Interface(
        tuple(fits), mean_area_per_load, variation, is_separated, advice, tuple(test_points), header_entries, common
    )
    interface = replace(
        interface,
        pair_faults=find_pair_faults(tests, *round_median_strength(interface)),
        exact_inputs=first_problem.exact_inputs,
        tested_hardness=tested_hardness,
        tested_loads=(min(loads), max(loads)),
    )
    interface = interface.with_caveats(FAULTS_HEADER_ENTRY, [": ".join(fault) for fault in interface.pair_faults])
    is_excluded = fits[0].probability < EXCLUSION_P_VALUE_LIMIT and fits[0].scale > MAX_ERROR_SCALE
    entry = FAULTS_HEADER_ENTRY if is_excluded else CAUTIONS_HEADER_ENTRY
    return interface.with_caveats(entry, [*_describe_misfit(fits[0], outliers=outliers)])


def _describe_misfit(fit: StrengthFit, *, outliers: bool) -> Iterator[str]:
    """Yield the reasons, if any, why friction tests agree poorly with the friction law that was fitted to the tests."""
    # With the option `outliers`, the fit uses the given errors of the tests without increasing them.
    if fit.probability < EXCLUSION_P_VALUE_LIMIT and not outliers:
        yield (
            f"its tests deviate from it by more than their errors allow (probability {fit.probability:.1g}), so the "
            f"errors were multiplied by {fit.scale:.2g}"
        )
    if fit.trend < EXCLUSION_P_VALUE_LIMIT:
        yield f"the deviations of its tests vary with the load (probability {fit.trend:.1g})"
