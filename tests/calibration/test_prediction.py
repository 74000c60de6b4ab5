"""Test predictions of calibrated interfaces against a joint Monte Carlo calculation, and against known true values."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.special import ndtri
from stiction import Ball, FrictionTest, calibrate, pair, read_interface, write_interface
from stiction.calibration.planning import plan_tests
from stiction.evaluate.member_values import interpolate_member_sums
from support.rough_surfaces import rough_maps

pytestmark = pytest.mark.usefixtures("no_companion_files")

BALL = Ball("5 mm", "80 GPa")
MIN_HARDNESS, MAX_HARDNESS = 0.8, 1.25  # GPa, 95 % interval of the log-normal hardness
MIN_EXPONENT, MAX_EXPONENT = 0.7, 1.6  # limits of a uniform distribution
UNCERTAIN_INPUTS = {
    "hardness": f"{MIN_HARDNESS}..{MAX_HARDNESS} GPa",
    "yield_exponent": f"uniform {MIN_EXPONENT}..{MAX_EXPONENT}",
}
PAIR_OPTIONS = {
    "load": "20 MPa", "effective_modulus": "80 GPa", "junction_growth": 0, "shifts": 4, "direction": [0.0, 180.0],
    "onset": 0,
}  # fmt: skip
MU0, TAU0, RELATIVE_ERROR = 0.15, 0.05, 0.02
RMS_HEIGHT_OF_TESTED_PAIR, RMS_HEIGHT_OF_PREDICTED_PAIR = 0.05, 0.02  # µm
BALL_LOADS = (5.0, 50.0, 500.0, 5000.0)
NUM_MONTE_CARLO_SAMPLES = 200_000

INTERVAL_TOLERANCE = 0.05
"""Tolerance of interval limits, as a fraction of the width. The interval is computed from 4000 joint samples."""

PARAMETER_TOLERANCE = 0.1
"""Tolerance of the limits of fitted parameters, as a fraction of their distance.

Tests have few nuisance points. Without the weights of these points, limits of the hardness deviate by at least 0.18.
"""


@cache
def press_pair(rms_roughness: float, hardness: Any = UNCERTAIN_INPUTS["hardness"], exponent: Any = None) -> Any:
    """Return the result of a rough pair at 20 MPa."""
    exponent = UNCERTAIN_INPUTS["yield_exponent"] if exponent is None else exponent
    maps = rough_maps(1, rms=rms_roughness, shortest_wavelength=0.5)
    return pair(*maps, hardness=hardness, yield_exponent=exponent, mu0=MU0, tau0=f"{TAU0} GPa", **PAIR_OPTIONS)


@cache
def fit_log_area_per_load(rms_roughness: float) -> np.ndarray:
    """Return the coefficients of ln(A/F) as a quadratic polynomial of ln(hardness) and the yield exponent.

    The pair is solved at nine combinations of hardness and exponent.
    """
    nodes = [
        (hardness, exponent)
        for hardness in (0.7, 1.0, 1.4)
        for exponent in (MIN_EXPONENT, (MIN_EXPONENT + MAX_EXPONENT) / 2, MAX_EXPONENT)
    ]
    areas = []
    for hardness, exponent in nodes:
        table = press_pair(rms_roughness, f"{hardness} GPa", exponent).at("20 MPa")
        areas.append((table["contact_area"].sel(statistic="mean") / table["load"]).item())
    return np.linalg.lstsq(build_polynomial(*np.transpose(nodes)), np.log(areas), rcond=None)[0]


def build_polynomial(hardness: Any, exponent: Any) -> np.ndarray:
    x, y = np.log(hardness), np.asarray(exponent)
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y, x * x * y, x * y * y, x * x * y * y], axis=-1)


def area_per_load(rms_roughness: float, hardness: Any, exponent: Any) -> Any:
    return np.exp(build_polynomial(hardness, exponent) @ fit_log_area_per_load(rms_roughness))


def log_hardness_distribution() -> tuple[float, float]:
    """Return the mean and the standard deviation of the logarithm of the hardness (GPa)."""
    return 0.5 * math.log(MIN_HARDNESS * MAX_HARDNESS), math.log(MAX_HARDNESS / MIN_HARDNESS) / (2 * 1.96)


def draw_inputs(random: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Draw the hardness (GPa) and the yield exponent from their distributions."""
    middle, deviation = log_hardness_distribution()
    return np.exp(random.normal(middle, deviation, count)), random.uniform(MIN_EXPONENT, MAX_EXPONENT, count)


def simulate_tests(
    hardness: float, exponent: float, random: np.random.Generator, *, with_ball: bool = True, mu0: float = MU0,
    tau0: float = TAU0,
) -> list:  # fmt: skip
    """Return tests of a rough pair with given hardness (GPa) and exponent, and of a ball, with random errors."""
    areas = [area_per_load(RMS_HEIGHT_OF_TESTED_PAIR, hardness, exponent)] * 3
    bodies = [(press_pair(RMS_HEIGHT_OF_TESTED_PAIR), "20 MPa")] * 3
    if with_ball:
        areas += [BALL.area_per_load(load) for load in BALL_LOADS]
        bodies += [(BALL, load) for load in BALL_LOADS]
    return [
        FrictionTest(
            body, load, coefficient=y * (1 + RELATIVE_ERROR * random.standard_normal()), uncertainty=RELATIVE_ERROR * y
        )
        for (body, load), y in zip(bodies, mu0 + tau0 * np.array(areas), strict=True)
    ]


def relative_area_error(result: Any) -> float:
    """Return the relative standard error of the true area over the positions of a result."""
    sums = interpolate_member_sums(result, np.array([0.02 * result.nominal_area]))["tangential_adhesive"]
    areas = sums.sel(sliding="all").mean("direction").values.ravel()
    return float(areas.std(ddof=1) / areas.mean() / math.sqrt(areas.size))


def max_friction_for_finer_scans(coefficient: Any, mu0: Any, plastic_friction: Any, contacts: float) -> Any:
    """Return the highest coefficient that a finer scan would give. All arguments but `contacts` may be arrays."""
    factor = math.exp(max(1 / math.sqrt(contacts), 0.1))
    adhesive, plastic = np.maximum(coefficient, plastic_friction) - mu0, plastic_friction - mu0
    return coefficient + np.minimum(adhesive * factor, plastic + (adhesive - plastic) * factor**2) - adhesive


@cache
def read_contacts_and_position_error() -> tuple[float, float]:
    """Return the number of contacts of the predicted pair, and the relative standard error of its mean coefficient."""
    point = press_pair(RMS_HEIGHT_OF_PREDICTED_PAIR).at("20 MPa")
    _, lower, upper = point["mean_friction"].sel(sliding="all").squeeze().values
    return 4 * point["contact_count"].sel(statistic="mean").item(), math.log(upper / lower) / (2 * 1.96)


def add_errors_of_scans(coefficient: Any, mu0: Any, plastic_friction: Any, fraction: Any, score: Any) -> Any:
    """Return the coefficient that the whole faces have, given the coefficient that their scans give.

    `fraction` is the position between the limits of the coefficient for finer scans, and `score` the normal score of
    the error of the mean over positions.
    """
    contacts, position_error = read_contacts_and_position_error()
    lowest = np.minimum(plastic_friction, coefficient)
    highest = np.maximum(max_friction_for_finer_scans(coefficient, mu0, plastic_friction, contacts), lowest)
    return (lowest + fraction * (highest - lowest)) * np.exp(position_error * score)


def draw_strengths(tests: list, pair_area: np.ndarray, random: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Draw mu0 and tau0 given the tests, for each true area per load of the tested pair. Also return the weights.

    The tests determine both coefficients. Each draw is weighted by the evidence of the tests.
    """
    areas = np.stack(
        [
            np.full(NUM_MONTE_CARLO_SAMPLES, BALL.area_per_load(float(t.load))) if t.result is BALL else pair_area
            for t in tests
        ],
        axis=1,
    )
    weight, y = np.array([1 / test.uncertainty**2 for test in tests]), np.array([test.coefficient for test in tests])
    information = np.empty((NUM_MONTE_CARLO_SAMPLES, 2, 2))
    information[:, 0, 0], information[:, 1, 1] = weight.sum(), areas**2 @ weight
    information[:, 0, 1] = information[:, 1, 0] = areas @ weight
    covariance = np.linalg.inv(information)
    best = np.einsum(
        "nij,nj->ni", covariance, np.stack([np.full(NUM_MONTE_CARLO_SAMPLES, weight @ y), areas @ (weight * y)], axis=1)
    )
    chi_squared = (y - best[:, :1] - best[:, 1:] * areas) ** 2 @ weight
    deviates = np.einsum(
        "nij,nj->ni", np.linalg.cholesky(covariance), random.standard_normal((NUM_MONTE_CARLO_SAMPLES, 2))
    )
    mu0, tau0 = (best + deviates).T
    evidence = (
        np.exp(-0.5 * (chi_squared - chi_squared.min())) * np.sqrt(np.linalg.det(covariance)) * areas.mean(axis=1)
    )
    return mu0, tau0, np.where((mu0 >= 0) & (tau0 >= 0), evidence, 0.0)


def draw_strengths_of_one_pair(
    tests: list, pair_area: np.ndarray, fraction: Any, random: np.random.Generator
) -> tuple[np.ndarray, ...]:
    """Draw mu0 and tau0 given tests on one pair, which determine only the sum. mu0 is a given fraction of this sum."""
    weight, y = np.array([1 / test.uncertainty**2 for test in tests]), np.array([test.coefficient for test in tests])
    total = random.normal(weight @ y / weight.sum(), 1 / math.sqrt(weight.sum()), NUM_MONTE_CARLO_SAMPLES)
    return fraction * total, (1 - fraction) * total / pair_area, total


def weighted_limits(samples: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the 2.5 % and the 97.5 % quantile of weighted samples."""
    order = np.argsort(samples)
    return np.interp([0.025, 0.975], np.cumsum(weight[order]) / weight.sum(), samples[order])


def compute_limits_by_brute_force(tests: list, *, with_ball: bool) -> dict[str, np.ndarray]:
    """Return 95 % limits of fitted parameters and of the predicted coefficient, given the tests, from random draws.

    The parameters are mu0, tau0 (GPa), and the normal scores of hardness and exponent. Hardness, exponent and area
    errors are drawn from their distributions, and are the same in the tests and in the predicted pair.
    """
    random = np.random.default_rng(5)
    hardness, exponent = draw_inputs(random, NUM_MONTE_CARLO_SAMPLES)
    area_error = np.exp(
        relative_area_error(press_pair(RMS_HEIGHT_OF_TESTED_PAIR)) * random.standard_normal(NUM_MONTE_CARLO_SAMPLES)
    )
    pair_area = area_per_load(RMS_HEIGHT_OF_TESTED_PAIR, hardness, exponent) * area_error
    scores, fraction = random.standard_normal(NUM_MONTE_CARLO_SAMPLES), random.random(NUM_MONTE_CARLO_SAMPLES)
    if with_ball:
        draws = [draw_strengths(tests, pair_area, random)]
    else:
        fractions = random.random(NUM_MONTE_CARLO_SAMPLES), 0.0, 1.0
        draws = [draw_strengths_of_one_pair(tests, pair_area, each, random) for each in fractions]
    intervals = []
    for mu0, tau0, weight in draws:
        coefficient = mu0 + tau0 * area_per_load(RMS_HEIGHT_OF_PREDICTED_PAIR, hardness, exponent)
        coefficient = add_errors_of_scans(coefficient, mu0, mu0 + tau0 / hardness, fraction, scores)
        intervals.append(weighted_limits(coefficient, weight))
    lowers, uppers = np.transpose(intervals)
    mu0, tau0, weight = draws[0]
    middle, deviation = log_hardness_distribution()
    samples_by_name = {
        "mu0": mu0, "tau0": tau0, "hardness": (np.log(hardness) - middle) / deviation,
        "yield_exponent": ndtri((exponent - MIN_EXPONENT) / (MAX_EXPONENT - MIN_EXPONENT)),
    }  # fmt: skip
    limits = {name: weighted_limits(samples, weight) for name, samples in samples_by_name.items()}
    return limits | {"coefficient": np.array([lowers.min(), uppers.max()])}


@pytest.mark.parametrize("with_ball", [True, False])
def test_prediction_and_pair_agree_with_a_joint_monte_carlo_calculation(tmp_path, with_ball) -> None:
    tests = simulate_tests(0.9, 1.3, np.random.default_rng(2), with_ball=with_ball)
    strength = calibrate(tests, common=0.0, sliding="all")
    assert strength.separated == with_ball
    predicted = strength.predict(press_pair(RMS_HEIGHT_OF_PREDICTED_PAIR), "20 MPa")
    write_interface(strength, tmp_path / "film")
    maps = rough_maps(1, rms=RMS_HEIGHT_OF_PREDICTED_PAIR, shortest_wavelength=0.5)
    result = pair(*maps, interface=tmp_path / "film", **UNCERTAIN_INPUTS, **PAIR_OPTIONS)
    assert predicted == pytest.approx((result.value, *result.interval), rel=1e-6)
    assert read_interface(tmp_path / "film").predict(result, "20 MPa") == pytest.approx(predicted, rel=1e-6)
    limits = compute_limits_by_brute_force(tests, with_ball=with_ball)
    expected, (fit,) = limits.pop("coefficient"), strength.fits
    samples_by_name = {"mu0": fit.mu0, "tau0": fit.tau0} | {name.split()[0]: fit.scores[name] for name in fit.scores}
    for name, expected_limits in limits.items():
        fitted_limits = np.quantile(samples_by_name[name], [0.025, 0.975])
        assert fitted_limits == pytest.approx(expected_limits, abs=PARAMETER_TOLERANCE * np.ptp(expected_limits)), name
    # The interval is widened to contain the range of coefficients for finer scans at the central inputs.
    mu0, tau0, hardness = (
        float(value)
        for value in (result.study.friction.mu0[0], result.study.friction.tau0[0], result.study.contact.hardness)
    )
    *_, upper = result.at("20 MPa")["mean_friction"].sel(sliding="all").squeeze().values
    contacts, _ = read_contacts_and_position_error()
    expected[1] = max(expected[1], max_friction_for_finer_scans(upper, mu0, mu0 + tau0 / hardness, contacts))
    assert predicted[1:] == pytest.approx(expected, abs=INTERVAL_TOLERANCE * np.ptp(expected))


def test_prediction_contains_the_true_coefficient_in_most_synthetic_cases() -> None:
    random, num_cases, num_covered = np.random.default_rng(7), 24, 0
    for hardness, exponent in zip(*draw_inputs(random, num_cases), strict=True):
        tests = simulate_tests(hardness, exponent, random)
        coefficient = MU0 + TAU0 * area_per_load(RMS_HEIGHT_OF_PREDICTED_PAIR, hardness, exponent)
        truth = add_errors_of_scans(coefficient, MU0, MU0 + TAU0 / hardness, random.random(), random.standard_normal())
        _, lower, upper = calibrate(tests, common=0.0, sliding="all").predict(
            press_pair(RMS_HEIGHT_OF_PREDICTED_PAIR), "20 MPa"
        )
        num_covered += lower < truth < upper
    assert num_covered >= 22  # with 95 % coverage, fewer have a probability of 3 %


def test_prediction_from_tests_of_one_pair_contains_the_true_coefficient_if_mu0_is_zero() -> None:
    random, num_cases, num_covered, tau0 = np.random.default_rng(7), 24, 0, 0.08
    for hardness, exponent in zip(*draw_inputs(random, num_cases), strict=True):
        tests = simulate_tests(hardness, exponent, random, with_ball=False, mu0=0.0, tau0=tau0)
        coefficient = tau0 * area_per_load(RMS_HEIGHT_OF_PREDICTED_PAIR, hardness, exponent)
        truth = add_errors_of_scans(coefficient, 0.0, tau0 / hardness, random.random(), random.standard_normal())
        strength = calibrate(tests, common=0.0, sliding="all")
        assert strength.possible_zeros == ("mu0", "tau0")
        _, lower, upper = strength.predict(press_pair(RMS_HEIGHT_OF_PREDICTED_PAIR), "20 MPa")
        num_covered += lower < truth < upper
    assert num_covered >= 22


def test_prediction_interval_does_not_widen_if_tests_of_the_same_pair_are_added() -> None:
    test = FrictionTest(press_pair(RMS_HEIGHT_OF_TESTED_PAIR), "20 MPa", coefficient=0.25, uncertainty=0.01)
    widths = []
    for num_tests in range(1, 9):
        strength = calibrate([test] * num_tests, common=0.0, sliding="all")
        widths.append(np.ptp(strength.predict(press_pair(RMS_HEIGHT_OF_PREDICTED_PAIR), "20 MPa")[1:]))
    assert (np.diff(widths) < 0.02 * widths[0]).all()
    assert widths[-1] < widths[0]


def test_planned_tests_of_a_pair_share_the_common_error_of_its_existing_tests() -> None:
    result, widths, planned_widths = press_pair(RMS_HEIGHT_OF_TESTED_PAIR), {}, {}
    for common in (0.0, 0.05):
        tests = [FrictionTest(result, "20 MPa", coefficient=0.25, uncertainty=0.005) for _ in range(4)]
        strength = calibrate(tests, common=common, sliding="all")
        widths[common] = np.ptp(strength.predict(result, "20 MPa")[1:])
        plans = {plan.text: np.ptp(plan.coefficient[1:]) for plan in plan_tests(strength, result, "20 MPa")}
        assert max(plans.values()) <= widths[common]
        planned_widths[common] = plans["4 tests of this pair at this load"]
    # Eight tests have an error of 2 %/√8. An error of 5 % that all tests share remains.
    assert planned_widths[0.0] == pytest.approx(2 * 1.96 * 0.25 * 0.02 / math.sqrt(8), rel=0.1)
    assert planned_widths[0.05] == pytest.approx(2 * 1.96 * 0.25 * math.hypot(0.05, 0.02 / math.sqrt(8)), rel=0.1)


def test_planned_tests_share_the_common_error_of_the_tests_in_an_interface_file(tmp_path) -> None:
    result = press_pair(RMS_HEIGHT_OF_TESTED_PAIR)
    test = FrictionTest(result, "20 MPa", coefficient=0.25, uncertainty=0.005)
    write_interface(calibrate([test] * 4, common=0.1, sliding="all"), tmp_path / "film")
    text = (tmp_path / "film").read_text()
    (tmp_path / "old").write_text(text.replace("# common error of the tests: 0.1\n", ""))
    strength, old_strength = read_interface(tmp_path / "film"), read_interface(tmp_path / "old")
    assert strength.common == 0.1
    assert math.isnan(old_strength.common)
    assert "common error of the tests" not in strength.about
    plans, old_plans = (
        {plan.text: np.ptp(plan.coefficient[1:]) for plan in plan_tests(each, result, "20 MPa")}
        for each in (strength, old_strength)
    )
    assert plans["1 test of this pair at this load"] > 0.99 * 2 * 1.96 * strength.predict(result, "20 MPa")[0] * 0.1
    assert "1 test of this pair at this load, without an error that all tests share" in old_plans
    assert "1 test of this pair at this load" not in old_plans
    (tmp_path / "old").write_text(text.replace("tests: 0.1\n", "tests: 10 %\n"))
    with pytest.raises(ValueError, match="old is a damaged interface file"):
        read_interface(tmp_path / "old")


def test_uninformative_test_of_a_pair_does_not_narrow_its_predicted_interval() -> None:
    """A ball determines mu0 and tau0; a test of the pair with an error of 30 % adds nothing to the area of the pair."""
    result, random = press_pair(RMS_HEIGHT_OF_PREDICTED_PAIR), np.random.default_rng(5)
    ball_tests = [
        FrictionTest(BALL, load, coefficient=y * (1 + 0.01 * random.standard_normal()), uncertainty=0.01 * y)
        for load, y in ((load, MU0 + TAU0 * BALL.area_per_load(load)) for load in BALL_LOADS)
    ]
    uninformative_test = FrictionTest(result, "20 MPa", coefficient=0.25, uncertainty=0.3)
    widths = []
    for tests in (ball_tests, [*ball_tests, uninformative_test]):
        _, lower, upper = calibrate(tests, common=0.0, sliding="all").predict(result, "20 MPa")
        widths.append(upper - lower)
    assert widths[1] == pytest.approx(widths[0], rel=0.05)
