"""mu0 and tau0 from friction that was measured on surfaces that were scanned.

A test gives a coefficient y at a load. The surfaces give, at that load, the sums of which both forces are made, so that
y (F_N0 + mu0 F_Nm + tau0 F_Na) = F_T0 + mu0 F_Tm + tau0 F_Ta: a straight line in (mu0, tau0). Where contacts rub on
gentle slopes it is y = mu0 + tau0 A/F, and both are told apart only as far as A/F varies among the tests.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from stiction._checks import check_choice, number
from stiction._units import short_repr, to_core_units
from stiction.mechanics.model import Sliding
from stiction.studies.calibration_fit import MIN_VARIATION, CalibrationProblem
from stiction.studies.interfaces import (
    EXCLUDED,
    GROWTH,
    HARDNESS,
    RULES,
    UNLIKELY,
    Ball,
    FrictionTest,
    Interface,
    sliding_rules_of,
)

MIN_TESTS = 3  # tests that slid from whose scatter errors are found


def calibrate(
    tests: Sequence[FrictionTest],
    *,
    common: float = 0.02,
    sliding: Sliding | Literal["both"] = "both",
    mu0: float | None = None,
    tau0: float | str | None = None,
    outliers: bool = False,
) -> Interface:
    """The strength of an interface, mu0 and tau0 jointly, from friction tests on surfaces that were scanned.

    Parameters
    ----------
    tests : sequence of FrictionTest
    common : float
        Relative standard uncertainty that all tests share: of the force cell, of the load.
    sliding : {"both", "all", "opposing"}
        By which rule; of both, "all" is used unless the tests exclude it and not the other one.
    mu0, tau0 : float, tau0 in GPa or as text
        Where one of them is known.
    outliers : bool
        Whether there may be outliers among the tests: errors by Student's t in place of the normal distribution.

    Returns
    -------
    Interface

    Raises
    ------
    ValueError
        If there are no tests that slid, or an argument is outside its range.

    Notes
    -----
    Given gain, areas, hardness, creep and moduli the data are linear in mu0 and tau0. Their density is computed on a
    grid, which is exact however alike the tests are; both are at least 0, and all values of mu0 and of tau0 A/F are as
    likely beforehand. Gain, areas and ranges have distributions of their own and are marginalised by adaptive
    importance sampling. Residuals are judged at the best fit of all of these together. Where they are larger than the
    errors allow, the errors are known up to a factor. Runs have relative offsets whose standard deviation is unknown:
    their prior is half a Cauchy distribution with the median 10 %.

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
        raise ValueError(f"tests must be a sequence of FrictionTest, got {short_repr(tests)}")
    tests = tuple(tests)
    if not any(test.slid for test in tests):
        raise ValueError("tests must have one that slid: those that held are lower bounds alone")
    common = number("common", common)
    if not 0 <= common < 1:
        raise ValueError(f"common must be at least 0 and below 1, got {common!r}")
    held = {test.uncertainty is None for test in tests}
    if len(held) > 1:
        raise ValueError("uncertainty must be given of all tests, or of none")
    if True in held and sum(test.slid for test in tests) < MIN_TESTS:
        raise ValueError(f"uncertainty is needed of fewer than {MIN_TESTS} tests: their scatter says too little")
    known = (
        None if mu0 is None else number("mu0", mu0),
        None if tau0 is None else number("tau0", to_core_units("tau0", tau0, "pressure")),
    )
    if any(value is not None and value < 0 for value in known):
        raise ValueError("mu0 and tau0 must not be negative")
    there = [rule for rule in RULES if all(rule in sliding_rules_of(test.result) for test in tests)]
    if all(isinstance(test.result, Ball) for test in tests) and sliding == "both":
        there = there[:1]  # both rules are one
    rules = there if sliding == "both" else [sliding]
    if not rules or not set(rules) <= set(there):
        raise ValueError(
            f"sliding must be a rule that all results have ({', '.join(there) or 'none'}), got {sliding!r}"
        )
    problems = [CalibrationProblem(tests, rule, common, known, outliers=outliers) for rule in rules]
    fits = [problem.fit() for problem in problems]
    if len(fits) == 2 and fits[0].probability < EXCLUDED and fits[1].probability > UNLIKELY:
        fits, problems = fits[::-1], problems[::-1]
    first = problems[0]
    separated = any(value is not None for value in known) or (len(tests) > 2 and first.variation >= MIN_VARIATION)
    points = [
        (float(ratio), float(test.coefficient or 0.0), float(test.uncertainty or math.nan), test.slid)
        for ratio, test in zip(first.ratio, tests, strict=True)
    ]
    advice = () if separated else first.advice()
    about = {"kind": "measured"} | ({HARDNESS: first.shared_hardness.text} if first.shared_hardness else {})
    about |= {GROWTH: first.growth.short_text} if first.growth is not None else {}
    return Interface(tuple(fits), first.pivot, first.variation, separated, advice, tuple(points), about)
