"""Expected effect of further friction tests on the predicted friction coefficient of a pair."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from stiction._checks import Floats, check_instance
from stiction.calibration.friction_tests import find_pair_hardness
from stiction.calibration.prediction import Interface
from stiction.mechanics.friction import FrictionLaw
from stiction.mechanics.hardness import MAX_ELASTIC_PRESSURE_RATIO, ball_yield_pressure
from stiction.study.input_distributions import Z_95
from stiction.study.interfaces import StrengthFit, ValueWithLimits, round_median_strength

DEFAULT_RELATIVE_ERROR = 0.05
BALL_LOAD_RANGE = 100.0


class PlannedTests(NamedTuple):
    """Plan of friction tests: its text, and the 95 % interval of a pair's coefficient expected after these tests."""

    text: str
    coefficient: ValueWithLimits


class PlanConditions(NamedTuple):
    """Assumptions about further friction tests: number, relative error, hardness, true area per load of a ball."""

    num_tests: int
    # Median relative error of the friction coefficients measured so far, or `DEFAULT_RELATIVE_ERROR` if unknown.
    relative_error: float
    is_error_known: bool
    # True area per load (1/GPa) of a ball at its highest and at its lowest tested load, which may be the same load.
    ball_area_per_load: tuple[float, float]
    # Hardness (GPa) of the wanted pair or, if it is not given, of the tested bodies; NaN if both are unknown.
    hardness: float

    @property
    def ball_yield_limit(self) -> float:
        """Mean pressure (GPa) at which a ball starts to yield, or NaN if the hardness is unknown."""
        return ball_yield_pressure(self.hardness)


def find_plan_conditions(interface: Interface, hardness: float = math.nan) -> PlanConditions:
    """Return the assumptions of `plan_tests` about further friction tests, such as the number of tests.

    `hardness` is the hardness (GPa) of the wanted pair. NaN stands for the hardness of the present tests.
    """
    if math.isnan(hardness):
        hardness = interface.tested_hardness
    if math.isnan(hardness):
        # An interface file contains the hardness of the tested bodies only as random samples, so their median is used.
        hardness = float(np.median(interface.fits[0].hardness))
    relative_errors = [
        uncertainty / coefficient for _, coefficient, uncertainty, slid in interface.tests if slid and coefficient > 0
    ]
    relative_error = float(np.median(relative_errors)) if relative_errors else math.nan
    is_error_known = math.isfinite(relative_error)
    num_tests = max(len(interface.tests), 1)
    ball_areas_per_load = _compute_areas_per_load_of_ball_tests(interface.area_per_load, num_tests, hardness)
    return PlanConditions(
        num_tests, relative_error if is_error_known else DEFAULT_RELATIVE_ERROR, is_error_known,
        (float(ball_areas_per_load[0]), float(ball_areas_per_load[-1])), hardness,
    )  # fmt: skip


def _compute_areas_per_load_of_ball_tests(area_per_load: float, count: int, hardness: float) -> Floats:
    """Return the true area per load A/F (1/GPa) in each planned test of a ball, sorted by decreasing load.

    The ball does not yield at the highest load, if the hardness (GPa) is not NaN. For a ball (Hertz), A/F is
    proportional to F^(-1/3). μ0 and τ0 need a second A/F, so a single test has the highest load or, if the ball would
    yield at this A/F, the lowest load.
    """
    ball_ratio = BALL_LOAD_RANGE ** (1 / 6)
    central_area_per_load = float(np.fmax(area_per_load, ball_ratio / ball_yield_pressure(hardness)))
    if count == 1 and central_area_per_load > area_per_load:
        return np.array([central_area_per_load * ball_ratio])
    return np.asarray(central_area_per_load * np.geomspace(1 / ball_ratio, ball_ratio, count))


def list_plans_that_vary_area_per_load(
    area_per_load: float, count: int, hardness: float = math.nan
) -> Iterator[tuple[str, Floats]]:
    """Yield plans of tests that separate mu0 from tau0: a description, and the true area per load (1/GPa) of each test.

    `area_per_load` and `count` are the mean true area per load (1/GPa) and the number of the present tests. `hardness`
    is that of the bodies (GPa), or NaN if it is unknown. A finish whose contacts would yield is left out.
    """
    tests = _count_tests(count)
    loads = "one load" if count == 1 else "two decades of load"
    yield (
        f"{tests} of a smooth ball below yield, {loads}",
        _compute_areas_per_load_of_ball_tests(area_per_load, count, hardness),
    )
    rough_area_per_load = area_per_load / 3
    if not rough_area_per_load * MAX_ELASTIC_PRESSURE_RATIO * hardness < 1:
        yield f"{tests} of a second finish, elastic, three times as rough", np.full(count, rough_area_per_load)
    yield f"{tests} with the same film on a body twice as hard", np.full(count, area_per_load / 2)


def _count_tests(count: int) -> str:
    return "1 test" if count == 1 else f"{count} tests"


def plan_tests(interface: Interface, result: Any, load: float | str) -> tuple[PlannedTests, ...]:
    """Return plans of further friction tests, sorted by the expected interval width of a pair's friction coefficient.

    Parameters
    ----------
    interface : Interface
        Result of `calibrate`, or an interface from a file.
    result : Result, HalfSpaceCurve, LoadCurve or Ball
        Pair whose coefficient is wanted.
    load : float or str, mN

    Returns
    -------
    tuple of PlannedTests
        The planned tests are as many as the present ones and have their median relative error. They are assumed to
        measure the coefficients that follow from the medians of mu0 and tau0. Tests of the pair itself have the same
        common error as the present tests. The text of this plan says so if this error is unknown, because an older
        version wrote the interface file. No interval is wider than the present interval. A planned ball has the
        hardness of the pair or, if the pair is elastic, of the present tests, and does not yield.

    Notes
    -----
    Each joint sample of mu0, tau0 and the shared inputs is weighted by the probability of the planned measurements.

    An interface file does not contain the tests, so that a single test with a relative error of 5 % is planned.

    Examples
    --------
    >>> from stiction import Ball, FrictionTest, calibrate
    >>> from stiction.calibration.planning import plan_tests
    >>> ball, wanted = Ball("5 mm", "3 GPa"), Ball("50 mm", "3 GPa")
    >>> tests = [FrictionTest(ball, "20 mN", coefficient=0.3, uncertainty=0.01) for _ in range(3)]
    >>> plan_tests(calibrate(tests), wanted, "20 mN")[0].text
    '3 tests of this pair at this load'
    """
    check_instance("interface", interface, Interface, "an Interface, as returned by calibrate()")
    conditions = find_plan_conditions(interface, find_pair_hardness(result))
    count, relative_error = conditions.num_tests, conditions.relative_error
    central_law = FrictionLaw(*round_median_strength(interface))
    plans, present = [], interface.predict(result, load)
    for text, areas_per_load in list_plans_that_vary_area_per_load(interface.area_per_load, count, conditions.hardness):
        expected = central_law.force(1.0, areas_per_load)
        planned = partial(
            _resample_by_expected_results,
            areas_per_load=areas_per_load,
            expected=expected,
            error=relative_error * expected,
        )
        fit, bounds = planned(interface.fits[0]), interface.fits[0].fits_at_bounds
        fit = replace(
            fit, fits_at_bounds={bound_name: planned(fit_at_bound) for bound_name, fit_at_bound in bounds.items()}
        )
        planned_coefficient = replace(interface, fits=(fit,)).predict(result, load)
        plans.append(PlannedTests(text, _limit_to_present_interval(planned_coefficient, present)))
    value = present[0]
    is_common_error_known = not math.isnan(interface.common)
    common_error = interface.common if is_common_error_known else 0.0
    half_width = _estimate_half_width(present, common_error, relative_error / math.sqrt(count))
    text = f"{_count_tests(count)} of this pair at this load" + (
        "" if is_common_error_known else ", without an error that all tests share"
    )
    plans.append(PlannedTests(text, (value, max(value - half_width, 0.0), value + half_width)))
    return tuple(sorted(plans, key=lambda plan: plan.coefficient[2] - plan.coefficient[1]))


def _estimate_half_width(present: ValueWithLimits, common_error: float, error: float) -> float:
    """Estimate the half width of the 95 % interval of a friction coefficient after further tests of the same pair.

    `error` is the relative standard error of the mean of these tests. The tests do not reduce `common_error`, which
    they share with the present tests.
    """
    value, low, high = present
    if not value > 0:
        return 0.0
    present_error = (high - low) / (2 * Z_95 * value)
    common_error = min(common_error, present_error)
    variance, new_variance = present_error**2 - common_error**2, error**2
    if math.isfinite(variance):
        new_variance *= variance / (variance + new_variance)
    return Z_95 * value * math.sqrt(new_variance + common_error**2)


def _limit_to_present_interval(planned: ValueWithLimits, present: ValueWithLimits) -> ValueWithLimits:
    """Limit the interval expected after planned tests to the present interval of the friction coefficient.

    Sampling scatter can make the expected interval wider than the present interval.
    """
    (value, low, high), (_, present_low, present_high) = planned, present
    return value, min(max(low, present_low), value), max(min(high, present_high), value)


def _resample_by_expected_results(
    fit: StrengthFit, areas_per_load: Floats, expected: Floats, error: Floats
) -> StrengthFit:
    """Resample mu0 and tau0, weighted by the likelihood of the results that are expected from planned friction tests.

    The planned tests have the given true areas per load (1/GPa), expected coefficients and standard errors.
    """
    predicted = FrictionLaw(fit.mu0[:, np.newaxis], fit.tau0[:, np.newaxis]).force(1.0, areas_per_load)
    log_weights = -0.5 * (((predicted - expected) / error) ** 2).sum(axis=1)
    return fit.resample(log_weights)
