"""Test `calibrate` against least squares, brute force and known true values, and its rejection of bad input."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator
from stiction import (
    Ball,
    FrictionTest,
    HalfSpaceCurve,
    Interface,
    calibrate,
    half_space,
    hardness_under_shear,
    material,
    open_result,
    pair,
    read_interface,
    write_interface,
)
from stiction._estimate import Estimate
from stiction.calibration.fit import CalibrationProblem
from stiction.calibration.planning import find_plan_conditions
from stiction.mechanics.friction import FrictionLaw
from stiction.study.inputs import Inputs
from stiction.study.interfaces import (
    HARDNESS_HEADER_ENTRY,
    JUNCTION_GROWTH_HEADER_ENTRY,
    compute_coverage_at_bound,
    compute_credible_interval,
)
from stiction.study.shared_inputs import apply_ranges_of_pair, find_shared_inputs
from stiction.views.calibration import WantedPairPrediction, calibration_json, calibration_text, predict_wanted_pair
from support.rough_surfaces import rough_maps

pytestmark = pytest.mark.usefixtures("no_companion_files")

BALL = Ball("5 mm", "3 GPa")
LOADS = np.geomspace(5.0, 2000.0, 8)
MU0, TAU0, RELATIVE_ERROR = 0.15, 0.012, 0.03

SAMPLING_TOLERANCE = 0.04
"""Tolerance of interval limits, as a fraction of the width: the scatter of 95 % intervals from 4000 samples."""


def simulate_ball_tests(
    *, mu0: float = MU0, tau0: float = TAU0, seed: int = 3, error: float = RELATIVE_ERROR
) -> list[FrictionTest]:
    """Return eight friction tests on a ball, with random relative errors."""
    random = np.random.default_rng(seed)
    true_coefficients = [mu0 + tau0 * BALL.area_per_load(load) for load in LOADS]
    return [
        FrictionTest(BALL, load, coefficient=y * (1 + error * random.standard_normal()), uncertainty=error * y)
        for load, y in zip(LOADS, true_coefficients, strict=True)
    ]


def fit_least_squares(tests: list[FrictionTest]) -> tuple[np.ndarray, np.ndarray]:
    """Return the least-squares estimate of (mu0, tau0) without bounds, and its covariance."""
    uncertainties = np.array([test.uncertainty for test in tests])
    matrix = np.array([[1.0, BALL.area_per_load(float(test.load))] for test in tests]) / uncertainties[:, np.newaxis]
    covariance = np.linalg.inv(matrix.T @ matrix)
    return covariance @ matrix.T @ (np.array([test.coefficient for test in tests]) / uncertainties), covariance


def test_calibration_with_mu0_and_tau0_far_above_zero_equals_a_least_squares_fit() -> None:
    tests = simulate_ball_tests(seed=4)
    interface = calibrate(tests, common=0.0, sliding="all")
    best, covariance = fit_least_squares(tests)
    for index, result in enumerate((interface.mu0, interface.tau0)):
        deviation = math.sqrt(covariance[index, index])
        expected = best[index] + 1.96 * deviation * np.array([0, -1, 1])
        assert result == pytest.approx(expected, abs=SAMPLING_TOLERANCE * 3.92 * deviation)


def test_calibration_with_a_parameter_at_its_bound_agrees_with_brute_force_integration() -> None:
    tests = simulate_ball_tests(tau0=0.0, seed=11)
    interface = calibrate(tests, common=0.0, sliding="all")
    mu0, tau0 = np.meshgrid(np.linspace(0.1, 0.2, 801), np.linspace(0.0, 0.003, 801), indexing="ij")
    log_likelihood = np.zeros(mu0.shape)
    for test in tests:
        predicted_coefficients = mu0 + tau0 * BALL.area_per_load(float(test.load))
        log_likelihood -= 0.5 * ((test.coefficient - predicted_coefficients) / test.uncertainty) ** 2
    weight = np.exp(log_likelihood - log_likelihood.max()).ravel()
    values = np.random.default_rng(0).choice(weight.size, 200_000, p=weight / weight.sum())
    for name, samples, interval in (("mu0", mu0, interface.mu0), ("tau0", tau0, interface.tau0)):
        expected = compute_credible_interval(samples.ravel()[values], 0.0)
        result = compute_credible_interval(interface.draws[name].to_numpy(), 0.0)
        assert result == pytest.approx(expected, abs=SAMPLING_TOLERANCE * (expected[2] - expected[1]))
        assert interval[0] == result[0]
        assert interval[1] <= result[1] < result[2] <= interval[2]
    assert interface.tau0[1] == 0.0


def test_error_common_to_all_tests_widens_the_interval_of_the_combination_of_mu0_and_tau0() -> None:
    tests = simulate_ball_tests()
    narrow_interval, wide_interval = (
        calibrate(tests, common=common_error, sliding="all").identified for common_error in (0.0, 0.1)
    )
    assert wide_interval[2] - wide_interval[1] == pytest.approx(
        math.hypot(narrow_interval[2] - narrow_interval[1], 0.1 * 3.92 * wide_interval[0]), rel=0.1
    )


def test_friction_tests_on_a_single_pair_determine_only_a_combination_of_mu0_and_tau0() -> None:
    curve = compute_rough_load_curve(0.02, 1)
    tests = [
        FrictionTest(curve, load, coefficient=float(y), uncertainty=0.03 * float(y))
        for load, y in zip(curve.load, curve.friction_coefficient(mu0=0.2, tau0=0.3), strict=True)
    ]
    interface = calibrate(tests)
    assert not interface.separated
    assert np.isnan([*interface.mu0, *interface.tau0]).all()
    assert interface.identified[1] < 0.2 + 0.3 * interface.area_per_load < interface.identified[2]
    assert interface.excluded == ()


def test_calibration_advice_predicts_the_errors_after_ball_tests_over_two_decades_of_load() -> None:
    curve = compute_rough_load_curve(0.02, 1)
    tests = [FrictionTest(curve, load, coefficient=0.3, uncertainty=0.009) for load in curve.load]
    interface = calibrate(tests)
    (_, mu0_error, tau0_error), *_ = interface.advice
    pair_ratio = interface.area_per_load
    loads = np.geomspace(1.0, 100.0, len(tests))
    ball_ratios = pair_ratio * np.array([BALL.area_per_load(load) for load in loads]) / BALL.area_per_load(10.0)
    ratios = np.array([*([pair_ratio] * len(tests)), *ball_ratios])
    design_matrix = np.stack([np.ones_like(ratios), ratios], axis=1)
    expected = 0.009 * np.sqrt(np.diag(np.linalg.inv(design_matrix.T @ design_matrix)))
    assert (mu0_error, tau0_error) == pytest.approx(expected, rel=0.25)


def test_friction_tests_on_two_surface_finishes_predict_friction_on_a_third_finish() -> None:
    curves = [compute_rough_load_curve(rms, seed) for rms, seed in ((0.01, 1), (0.04, 2))]
    random = np.random.default_rng(1)
    tests = [
        FrictionTest(
            curve, load, coefficient=float(y) * (1 + 0.02 * random.standard_normal()), uncertainty=0.02 * float(y)
        )
        for curve in curves
        for load, y in zip(curve.load, curve.friction_coefficient(mu0=0.2, tau0=0.3), strict=True)
    ]
    interface = calibrate(tests, sliding="all")
    assert interface.separated
    assert interface.mu0[1] < 0.2 < interface.mu0[2]
    assert interface.tau0[1] < 0.3 < interface.tau0[2]
    third_curve = compute_rough_load_curve(0.02, 5)
    value, lower, upper = interface.predict(third_curve, float(third_curve.load[1]))
    assert lower < float(third_curve.friction_coefficient(mu0=0.2, tau0=0.3)[1]) < upper
    assert lower < value < upper
    assert list(interface.draws.columns) == ["mu0", "tau0", "hardness"]


def compute_rough_load_curve(rms: float, seed: int):
    """Return the load curve of two rough surfaces as elastic half-spaces, with friction at all contacts."""
    upper, lower = rough_maps(seed, rms=rms, points=64)
    loads = np.geomspace(0.05, 0.4, 4) * 6.4**2
    return half_space(upper, lower, loads, effective_modulus=80.0, sliding="all", boundary="periodic")


def test_friction_test_accepts_a_result_of_the_pair_function() -> None:
    upper, lower = rough_maps()
    result = pair(
        upper, lower, load=["40 MPa", "160 MPa"], mu0=0.2, tau0="50 MPa", upper="steel", lower="brass", shifts=4,
        onset=0,
    )  # fmt: skip
    coefficient = result.at("80 MPa", mu0=0.2, tau0="50 MPa")["mean_friction"].sel(sliding="all", statistic="mean")
    expected_coefficient = float(coefficient.squeeze())
    tests = [
        FrictionTest(result, load, coefficient=expected_coefficient, uncertainty=0.01) for load in ("80 MPa", "2 mN")
    ]
    # The nominal pressure acts on the pieces of the maps that are in contact, not on complete maps.
    assert tests[0].load == pytest.approx(0.08 * result.nominal_area)
    interface = calibrate(tests)
    assert [fit.sliding for fit in interface.fits] == ["all", "opposing"]
    assert interface.predict(result, "80 MPa")[0] == pytest.approx(expected_coefficient, rel=0.02)
    hardness_of_brass = Inputs.from_study(result.study).estimate("hardness")
    assert interface.about[HARDNESS_HEADER_ENTRY] == hardness_of_brass.text
    assert interface.draws["hardness"].median() == pytest.approx(hardness_of_brass.value, rel=0.1)


def rough_surface_pair(rms: float) -> list[Any]:
    return rough_maps(1, rms=rms, shortest_wavelength=0.5)


PAIR_OPTIONS = {"load": ["20 MPa", "50 MPa"], "mu0": 0.2, "tau0": "50 MPa", "effective_modulus": "80 GPa", "shifts": 4,
           "direction": [0.0, 180.0], "onset": 0}  # fmt: skip


def test_uncertainty_of_a_hardness_shared_by_all_pairs_cancels_in_the_prediction(tmp_path) -> None:
    hardness = "0.5..1.5 GPa"
    tested_pair, predicted_pair = (
        pair(*rough_surface_pair(rms), hardness=hardness, **PAIR_OPTIONS) for rms in (0.03, 0.02)
    )
    tests = [FrictionTest(tested_pair, load, coefficient=0.25, uncertainty=0.005) for load in ("20 MPa", "50 MPa")]
    strength = calibrate(tests, sliding="all")
    assert strength.draws["hardness"].quantile([0.025, 0.975]).to_numpy() == pytest.approx([0.5, 1.5], rel=0.1)
    value, lower, upper = strength.predict(predicted_pair, "50 MPa")
    assert value == pytest.approx(0.25, rel=0.02)
    assert upper - lower < 0.035
    unrelated_pair = pair(*rough_surface_pair(0.02), hardness="0.5..1.51 GPa", **PAIR_OPTIONS)
    assert np.ptp(strength.predict(unrelated_pair, "50 MPa")[1:]) > 3 * (upper - lower)
    # A hardness given by the same text as in the interface file has the same error as in the calibration.
    write_interface(strength, tmp_path / "film.csv")
    arguments = {name: value for name, value in PAIR_OPTIONS.items() if name not in ("mu0", "tau0")}
    shared_result, unrelated_result = (
        pair(*rough_surface_pair(0.02), hardness=text, interface=tmp_path / "film.csv", **arguments)
        for text in (hardness, "0.5..1.51 GPa")
    )
    assert np.ptp(shared_result.interval) < 0.5 * np.ptp(unrelated_result.interval)
    for predicted_result, is_shared in ((shared_result, True), (unrelated_result, False)):
        labels = predicted_result.budget["input"].tolist()
        (label,) = (text for text in labels if text.startswith("the interface"))
        assert (("the hardness" in label), ("the hardness" in labels)) == (is_shared, not is_shared)
    result_in_other_unit = pair(
        *rough_surface_pair(0.02), hardness="500..1500MPa", interface=tmp_path / "film.csv", **arguments
    )
    assert result_in_other_unit.interval == pytest.approx(shared_result.interval, rel=1e-6)


@cache
def press_yielding_pair(rms: float, hardness: str) -> Any:
    """Return the result of a yielding pair, which is solved only once for all tests."""
    return pair(*rough_surface_pair(rms), hardness=hardness, yield_exponent=1.15, **PAIR_OPTIONS)


def test_two_ranges_of_one_hardness_give_the_interval_of_the_narrower_range(tmp_path) -> None:
    def fit_law(hardness: str) -> Any:
        tests = [FrictionTest(press_yielding_pair(0.05, hardness), "20 MPa", coefficient=0.25, uncertainty=0.002)] * 4
        return calibrate(tests, common=0.0, sliding="all", mu0=0.1)

    law, narrow_law = fit_law("1 GPa ± 10 %"), fit_law("1 GPa ± 2 %")
    hardnesses = ("1 GPa ± 10 %", "1 GPa ± 2 %", "1 GPa", "1 GPa ± 20 %", "1.01 GPa ± 2 %")
    targets = {text: press_yielding_pair(0.02, text) for text in hardnesses}
    intervals = {text: np.array(law.predict(target, "20 MPa")) for text, target in targets.items()}
    widths = {text: np.ptp(interval[1:]) for text, interval in intervals.items()}
    assert max(widths[text] for text in ("1 GPa ± 2 %", "1 GPa", "1 GPa ± 20 %")) < 1.03 * widths["1 GPa ± 10 %"]
    assert widths["1.01 GPa ± 2 %"] > 1.3 * widths["1 GPa ± 10 %"]
    expected = np.array(narrow_law.predict(targets["1 GPa ± 2 %"], "20 MPa"))
    assert intervals["1 GPa ± 2 %"] == pytest.approx(expected, abs=0.05 * np.ptp(expected[1:]))
    (caveat,) = predict_wanted_pair(law, targets["1 GPa ± 2 %"]).caveats
    assert caveat.startswith("! the hardness is 1 GPa ± 2 %, but 1 GPa ± 10 % in the tests of the interface")
    write_interface(law, tmp_path / "film")
    options = {name: value for name, value in PAIR_OPTIONS.items() if name not in ("mu0", "tau0")}
    for text in targets:
        result = pair(
            *rough_surface_pair(0.02), hardness=text, yield_exponent=1.15, interface=tmp_path / "film", **options
        )
        assert result.interval == pytest.approx(tuple(intervals[text][1:]), rel=1e-6)
        caveats = [caveat for caveat in result.caveats if "in the tests of the interface" in caveat.text]
        assert len(caveats) == (text not in ("1 GPa ± 10 %", "1.01 GPa ± 2 %"))
        if caveats:
            assert f"the hardness is {text}, but 1 GPa ± 10 % in the tests" in caveats[0].text
            assert "ranges of one quantity" in caveats[0].text
            assert result.assessment != "Quote it"


@cache
def fit_law_for_exact_hardness() -> Interface:
    """Return the interface that tests of a pair with a hardness of exactly 1 GPa determine."""
    test = FrictionTest(press_yielding_pair(0.05, "1 GPa"), "20 MPa", coefficient=0.25, uncertainty=0.002)
    return calibrate([test] * 4, common=0.0, sliding="all", mu0=0.1)


@pytest.mark.parametrize(("text", "is_equal"), [("1 GPa ± 10 %", True), ("1 GPa", False), ("1.01 GPa ± 10 %", False)])
def test_range_of_a_hardness_that_is_exact_in_the_tests_applies_in_full_and_has_a_caveat(
    text, is_equal, tmp_path
) -> None:
    law = fit_law_for_exact_hardness()
    assert dict(law.exact_inputs) == {"hardness": 1.0, "effective_modulus": 80.0, "yield_exponent": 1.15}
    write_interface(law, tmp_path / "film")
    assert read_interface(tmp_path / "film").exact_inputs == law.exact_inputs
    target = press_yielding_pair(0.02, text)
    caveats = predict_wanted_pair(law, target).caveats
    assert len(caveats) == is_equal
    if is_equal:
        assert caveats[0].startswith(
            "! the hardness is 1 GPa ± 10 %, but exact in the tests of the interface; its error"
        )
        options = PAIR_OPTIONS | {"mu0": None, "tau0": None, "interface": tmp_path / "film"}
        result = pair(*rough_surface_pair(0.02), hardness=text, yield_exponent=1.15, **options)
        (caveat,) = [caveat for caveat in result.caveats if "exact in the tests" in caveat.text]
        assert f"! {caveat.text}; {caveat.remedy}" == caveats[0]
        assert result.assessment != "Quote it"
        exact_interval = law.predict(press_yielding_pair(0.02, "1 GPa"), "20 MPa")
        assert np.ptp(law.predict(target, "20 MPa")[1:]) > 1.3 * np.ptp(exact_interval[1:])


@pytest.mark.parametrize(("tested_load", "direction"), [("20 MPa", "low"), ("400 MPa", "high")])
def test_size_effect_of_a_tested_pair_has_a_caveat_only_at_loads_that_differ_from_the_test_loads(
    tested_load, direction, tmp_path
) -> None:
    options = PAIR_OPTIONS | {"hardness": "0.5 GPa", "yield_exponent": 1.15, "load": "20 MPa, 400 MPa"}
    test = FrictionTest(pair(*rough_surface_pair(0.05), **options), tested_load, coefficient=0.25, uncertainty=0.002)
    law = calibrate([test], common=0.0, sliding="all", mu0=0.0)
    write_interface(law, tmp_path / "film")
    assert read_interface(tmp_path / "film").tested_loads == law.tested_loads == (test.load, test.load)
    result = pair(*rough_surface_pair(0.05), **options | {"mu0": None, "tau0": None, "interface": tmp_path / "film"})
    texts = [
        [caveat.text for caveat in point.caveats if "small contacts of metals" in caveat.text]
        for point in result.summary().points
    ]
    tested_texts, other_texts = texts if tested_load == "20 MPa" else texts[::-1]
    assert not tested_texts
    (text,) = other_texts
    assert f"({tested_load})), so the coefficient may be too {direction}" in text


@cache
def press_soft_pair(indent: str | None, **options: Any) -> Any:
    """Return the result of a pair with the given size of hardness indents. The same options are solved only once."""
    inputs = {"hardness": "0.5 GPa ± 10 %", "yield_exponent": 1.15, "indent": indent, **PAIR_OPTIONS}
    return pair(*rough_surface_pair(0.05), **inputs | options)


@pytest.mark.parametrize(("tested_indent", "indent"), [(None, None), ("2 um", "2 um"), ("2 um", None), (None, "2 um")])
def test_size_effect_has_a_caveat_only_if_it_differs_between_the_pair_and_tests_of_the_pair(
    tested_indent, indent, tmp_path
) -> None:
    test = FrictionTest(press_soft_pair(tested_indent), "20 MPa", coefficient=0.25, uncertainty=0.002)
    law = calibrate([test], common=0.0, sliding="all")
    write_interface(law, tmp_path / "film")
    result = press_soft_pair(indent, mu0=None, tau0=None, interface=tmp_path / "film")
    differences = [caveat for caveat in result.caveats if "τ0 of the interface belongs" in caveat.text]
    predicted_caveats = predict_wanted_pair(law, press_soft_pair(indent)).caveats
    assert predicted_caveats == tuple(f"! {caveat.text}; {caveat.remedy}" for caveat in differences)
    if tested_indent == indent:
        assert not differences
        assert not any("as hard as large ones" in caveat.text for caveat in result.caveats)
        assert result.value == pytest.approx(0.25, rel=0.02)
    else:
        assert len(differences) == 1
        subject = "the pair includes" if indent else "the tests of the interface include"
        assert differences[0].text.startswith(f"{subject} the hardness increase of small contacts (--indent), unlike")
        assert result.assessment != "Quote it"
    if indent is None:
        result = press_soft_pair(None, mu0=0.1, tau0="100 MPa")
        assert any("as hard as large ones" in caveat.text for caveat in result.caveats)


def test_exact_hardness_does_not_widen_the_narrower_range_of_the_modulus() -> None:
    def press_pair(rms: float, modulus: str, hardness: str) -> Any:
        options = {**PAIR_OPTIONS, "effective_modulus": modulus}
        return pair(*rough_surface_pair(rms), hardness=hardness, yield_exponent=1.15, **options)

    tests = [
        FrictionTest(press_pair(0.05, "80 GPa ± 10 %", "1 GPa ± 10 %"), "20 MPa", coefficient=0.25, uncertainty=0.002)
    ] * 4
    law = calibrate(tests, common=0.0, sliding="all", mu0=0.1)
    inputs = Inputs.from_study(press_pair(0.02, "80 GPa ± 3 %", "1 GPa").study)
    estimates = {name: entry.estimate for name, entry in inputs.entries.items()}
    shared_inputs = find_shared_inputs(law, estimates)
    fit = apply_ranges_of_pair(law, shared_inputs).fits[0]
    standard_deviations = {name: each.sample(fit).std() / each.tested.value for name, each in shared_inputs.items()}
    assert standard_deviations["effective_modulus"] < 0.04
    assert standard_deviations["hardness"] < 0.04


@pytest.mark.parametrize("relative_error", ["2e-7 %", "0.0001 %", "0.01 %", "0.3 %"])
def test_wider_modulus_range_of_a_ball_gives_the_prediction_of_the_tested_range(relative_error) -> None:
    ball = Ball("5 mm", f"210 GPa ± {relative_error}")
    law = calibrate([FrictionTest(ball, "20 mN", coefficient=0.3, uncertainty=0.01) for _ in range(3)])
    expected = law.predict(ball, "20 mN")
    assert law.predict(Ball("5 mm", "210 GPa ± 1 %"), "20 mN") == pytest.approx(expected, rel=2e-4)
    (shared_input,) = find_shared_inputs(law, Ball("5 mm", "210 GPa ± 1 %").moduli.inputs).values()
    width = ball.moduli.inputs["effective_modulus"].high - ball.moduli.inputs["effective_modulus"].low
    assert shared_input.tested.high - shared_input.tested.low == pytest.approx(width, rel=0.1)


def test_prediction_treats_equal_limits_of_a_tested_range_as_an_exact_input() -> None:
    ball = Ball("5 mm", "210 GPa ± 0.01 %")
    law = calibrate([FrictionTest(ball, "20 mN", coefficient=0.3, uncertainty=0.01) for _ in range(3)])
    (scores,) = (scores for name, scores in law.fits[0].scores.items() if name.startswith("effective_modulus"))
    old_fit = replace(law.fits[0], scores={"effective_modulus normal 210..210": scores}, fits_at_bounds={})
    old_law = replace(law, fits=(old_fit,))
    assert np.isfinite(old_law.predict(Ball("5 mm", "210 GPa ± 1 %"), "20 mN")).all()


def test_calibration_text_explains_an_infinite_upper_limit_and_repeats_caveats_about_ranges() -> None:
    interface = calibrate(simulate_ball_tests(), common=0.0)
    points = ("1 mN (20 MPa)", (0.3, 0.2, 0.4)), ("2 mN (40 MPa)", (0.3, 0.2, math.inf))
    prediction = WantedPairPrediction(points, (), ("! E* is 3 GPa, but 2 to 4 GPa in the tests",))
    texts = [
        " ".join(calibration_text(interface, (), each).split())
        for each in (prediction, replace(prediction, points=points[:1]))
    ]
    assert [("An upper limit of ∞ means that" in text) for text in texts] == [True, False]
    records = [
        json.loads(calibration_json(interface, (), each))
        for each in (prediction, replace(prediction, points=points[:1]))
    ]
    assert [bool(record["unlimited"]) for record in records] == [True, False]
    assert all("! E* is 3 GPa, but 2 to 4 GPa in the tests" in text for text in texts)


@pytest.mark.parametrize(("num_tests", "loads_text"), [(1, "one load"), (3, "two decades of load")])
def test_plan_of_further_ball_tests_states_the_loads_and_conditions_of_the_tests(num_tests, loads_text) -> None:
    interface = calibrate([FrictionTest(BALL, "20 mN", coefficient=0.3, uncertainty=0.015)] * num_tests)
    assert interface.advice[0][0].endswith(f"of a smooth ball below yield, {loads_text}")
    conditions = json.loads(calibration_json(interface))["plan_conditions"]
    assert (conditions["tests"], conditions["relative_error"]) == (num_tests, pytest.approx(0.05))
    low, high = conditions["ball_area_per_load_per_GPa"]
    assert (high / low) ** 3 == pytest.approx(1 if num_tests == 1 else 100)
    range_text = f"{low:.3g} 1/GPa" if num_tests == 1 else f"{low:.3g} to {high:.3g} 1/GPa"
    assert f"A/F of the ball is {range_text}" in " ".join(calibration_text(interface).split())


@pytest.mark.parametrize("num_tests", [1, 3])
def test_planned_tests_on_yielding_bodies_are_below_the_yield_limit_of_the_hardness_of_the_pair(num_tests, tmp_path):
    result, hardness = compute_plastic_pair("slip-line"), 0.625
    tests = [FrictionTest(result, "20 MPa", coefficient=0.2, uncertainty=0.01)] * num_tests
    interface = calibrate(tests, common=0.0, sliding="all")
    write_interface(interface, tmp_path / "law")
    ball_tests = [FrictionTest(BALL, load, coefficient=0.3, uncertainty=0.015) for load in LOADS[:num_tests]]
    ball_interface = calibrate(ball_tests, common=0.0)
    for law, wanted in ((interface, None), (read_interface(tmp_path / "law"), None), (ball_interface, result)):
        prediction = None if wanted is None else predict_wanted_pair(law, wanted)
        conditions = json.loads(calibration_json(law, (), prediction))["plan_conditions"]
        yield_limit = conditions["ball_yield_limit_GPa"]
        assert yield_limit == pytest.approx(0.39 * hardness)
        assert 1 / min(conditions["ball_area_per_load_per_GPa"]) <= yield_limit * (1 + 1e-9)
    # Contacts at half the hardness count as yielding, so that no elastic finish has a third of the area.
    assert not any("elastic" in text for text, *_ in interface.advice)
    assert "(0.39 times the hardness of 625 MPa)" in " ".join(calibration_text(interface).split())
    assert json.loads(calibration_json(ball_interface))["plan_conditions"]["ball_yield_limit_GPa"] is None


def test_planned_ball_has_the_hardness_of_its_materials_if_no_pair_has_a_hardness() -> None:
    ball = Ball("5 mm", upper_material="PMMA", lower_material="glass")
    interface = calibrate([FrictionTest(ball, "20 mN", coefficient=0.3, uncertainty=0.015)])
    assert find_plan_conditions(interface).hardness == float(material("PMMA").hardness)


def test_narrower_modulus_of_a_ball_applies_to_its_tests_as_in_a_fit_with_this_range() -> None:
    def fit_law(modulus: str) -> Any:
        ball = Ball("5 mm", modulus)
        return calibrate(
            [
                FrictionTest(ball, test.load, coefficient=test.coefficient, uncertainty=test.uncertainty)
                for test in simulate_ball_tests()
            ],
            common=0.0,
        )

    target = Ball("0.5 mm", "3 GPa ± 3 %")
    law, narrow_law = fit_law("3 GPa ± 10 %"), fit_law("3 GPa ± 3 %")
    expected = narrow_law.predict(target, "10 mN")
    assert law.predict(target, "10 mN") == pytest.approx(expected, abs=0.05 * np.ptp(expected[1:]))
    assert np.ptp(law.predict(Ball("0.5 mm", "3 GPa"), "10 mN")[1:]) < 1.02 * np.ptp(expected[1:])
    independent_target = Ball("0.5 mm", "3.01 GPa ± 3 %")
    assert np.ptp(law.predict(independent_target, "10 mN")[1:]) > 1.5 * np.ptp(expected[1:])


def test_friction_tests_at_several_dwell_times_separate_mu0_from_tau0() -> None:
    rough_result = pair(
        *rough_surface_pair(0.03), hardness="0.8 GPa", junction_growth=0, wait=["1 s", "300 d"], creep=0.05,
        **PAIR_OPTIONS,
    )  # fmt: skip
    table, tests = rough_result.at("20 MPa"), []
    ratio = (table["contact_area"].sel(statistic="mean") / table["load"]).item()
    for wait, seconds in (("1 s", 1.0), ("1 h", 3600.0), ("300 d", 300 * 86400.0)):
        y = 0.2 + 0.05 * ratio * seconds**0.05
        tests.append(FrictionTest(rough_result, "20 MPa", coefficient=y, uncertainty=0.002, wait=wait))
    strength = calibrate(tests, sliding="all")
    assert strength.separated
    assert strength.mu0[0] == pytest.approx(0.2, abs=0.01)
    assert strength.tau0[0] == pytest.approx(0.05, rel=0.1)


@pytest.mark.parametrize(("mu0", "tau0"), [(0, 0), (5, 0), (0.2, "5 GPa")])
def test_mu0_and_tau0_of_a_tested_pair_have_no_effect_on_the_law(mu0, tau0) -> None:
    def fit_law(mu0: Any, tau0: Any) -> Any:
        options = {**PAIR_OPTIONS, "mu0": mu0, "tau0": tau0, "load": "60 MPa", "hardness": "1 GPa"}
        result = pair(*rough_surface_pair(0.03), **options)
        return calibrate([FrictionTest(result, "60 MPa", coefficient=0.3, uncertainty=0.01)], sliding="all")

    law, expected = fit_law(mu0, tau0), fit_law(0.2, "50 MPa")
    np.testing.assert_array_equal(law.fits[0].mu0, expected.fits[0].mu0)
    # Faults differ in the name of the pair, which is that of a temporary directory.
    assert [fault for _, fault in law.pair_faults] == [fault for _, fault in expected.pair_faults]


def test_area_factor_of_a_friction_test_contains_exact_inputs_too() -> None:
    factor = FrictionTest(Ball("5 mm", "3 GPa"), "20 mN", coefficient=0.3).area_factor
    assert {name: value.value for name, value in factor.inputs.items()} == {"effective_modulus": 3.0, "area_loss": 0.0}
    assert factor.uncertain_inputs == {}
    assert factor.onset_area_and_friction_factors({}, FrictionLaw(0.1, 0.01)) == (1.0, 1.0)
    cases = [
        ({"hardness": "1 GPa", "junction_growth": 0, "wait": "1 s", "creep": 0.05}, {"creep"}),
        ({"hardness": "1 GPa ± 10 %", "yield_exponent": 1.15, "junction_growth": 0}, {"hardness"}),
    ]
    for options, uncertain_names in cases:
        result = pair(*rough_surface_pair(0.05), **PAIR_OPTIONS, **options)
        factor = FrictionTest(result, "20 MPa", coefficient=0.3).area_factor
        entries = Inputs.from_study(result.study).entries
        assert factor.inputs == {name: entries[name].estimate for name in entries if name not in ("mu0", "tau0")}
        assert uncertain_names <= factor.uncertain_inputs.keys() < factor.inputs.keys()


def test_calibration_infers_the_true_modulus_within_its_range() -> None:
    # The true modulus is 1.8 standard deviations above the middle of its range, as tests with an exact ball reveal.
    ranged_ball, exact_ball = Ball("5 mm", "2..4.5 GPa"), Ball("5 mm", "30 GPa")
    modulus = 3.0 * 1.5 ** (1.8 / 1.96)
    true_ball = Ball("5 mm", modulus)
    tests = [
        FrictionTest(body, load, coefficient=y, uncertainty=0.005 * y)
        for body, area in ((ranged_ball, true_ball), (exact_ball, exact_ball))
        for load in LOADS
        for y in [MU0 + TAU0 * area.area_per_load(load)]
    ]
    interface = calibrate(tests, common=0.0)
    fit = interface.fits[0]
    (score,) = fit.scores.values()
    assert np.median(score) == pytest.approx(1.8, abs=0.2)
    assert fit.scale == 1.0
    assert interface.mu0[1] < MU0 < interface.mu0[2]
    assert interface.tau0[1] < TAU0 < interface.tau0[2]


def test_calibration_over_a_range_of_moduli_agrees_with_a_brute_force_calculation() -> None:
    min_modulus, max_modulus = 2.0, 4.5
    body = Ball("5 mm", f"{min_modulus}..{max_modulus} GPa")
    tests = [
        FrictionTest(body, test.load, coefficient=test.coefficient, uncertainty=test.uncertainty)
        for test in simulate_ball_tests(seed=4)
    ]
    interface = calibrate(tests, common=0.0)
    best, covariance = fit_least_squares(tests)
    random = np.random.default_rng(0)
    samples_at_mean_modulus = random.multivariate_normal(best, covariance, 400_000)
    # Contact area per load, A/F, is proportional to E*^(-2/3). The prior is flat in tau0 A/F, so tau0 is proportional
    # to E*^(2/3).
    relative_moduli = np.exp(random.standard_normal(400_000) / 1.96 * 0.5 * math.log(max_modulus / min_modulus))
    tau0 = samples_at_mean_modulus[:, 1] * relative_moduli ** (2 / 3)
    for result, samples in ((interface.mu0, samples_at_mean_modulus[:, 0]), (interface.tau0, tau0)):
        expected = np.quantile(samples, [0.5, 0.025, 0.975])
        assert result == pytest.approx(expected, abs=SAMPLING_TOLERANCE * np.ptp(expected))


@pytest.mark.parametrize(
    "contact_options", [{}, {"hardness": "0.5..1.5 GPa"}, {"hardness": "1..2 GPa", "junction_growth": 9}]
)
def test_prediction_for_a_pair_equals_the_combined_interval_computed_with_the_interface(
    tmp_path, contact_options
) -> None:
    strength = calibrate(simulate_ball_tests(), common=0.0, sliding="all")
    write_interface(strength, tmp_path / "film.csv")
    options = {name: value for name, value in PAIR_OPTIONS.items() if name not in ("mu0", "tau0")} | contact_options
    options["effective_modulus"] = "80 GPa ± 5 %"
    predicted_pair = pair(*rough_surface_pair(0.01), mu0=0.2, tau0="50 MPa", **options)
    value, *ends = strength.predict(predicted_pair, "20 MPa")
    result = pair(*rough_surface_pair(0.01), interface=tmp_path / "film.csv", **options)
    width = np.ptp(result.interval)
    assert ends == pytest.approx(result.interval, abs=0.01 * width)
    assert value == pytest.approx(result.value, abs=0.1 * width)


def test_inputs_of_tested_yielding_pairs_have_the_same_errors_in_another_pair(tmp_path) -> None:
    options = PAIR_OPTIONS | {"hardness": "2 GPa ± 10 %", "effective_modulus": "80 GPa ± 5 %"}
    tested_pair = pair(*rough_surface_pair(0.05), **options)
    tests = [FrictionTest(tested_pair, "20 MPa", coefficient=0.25, uncertainty=0.004)] * 3
    strength = calibrate(tests, common=0.0, sliding="all")
    write_interface(strength, tmp_path / "film.csv")
    options = {name: value for name, value in options.items() if name not in ("mu0", "tau0")}
    result = pair(*rough_surface_pair(0.02), interface=tmp_path / "film.csv", **options)
    for interface in (strength, read_interface(tmp_path / "film.csv")):
        assert interface.predict(result, "20 MPa") == pytest.approx((result.value, *result.interval), rel=1e-6)
    assert set(result.budget["input"]) == {
        "the interface with the hardness and other inputs of its tests", "positions", "unresolved roughness"
    }  # fmt: skip
    independent_fit = replace(strength.fits[0], scores={})
    *_, low, high = replace(strength, fits=(independent_fit,)).predict(result, "20 MPa")
    assert np.ptp(result.interval) < 0.95 * (high - low)


def test_interface_file_without_scores_keeps_the_correlation_of_mu0_and_tau0_with_the_hardness(tmp_path) -> None:
    tested_pair, predicted_pair = (
        pair(*rough_surface_pair(rms), hardness="0.5..1.5 GPa", yield_exponent=1.15, **PAIR_OPTIONS)
        for rms in (0.03, 0.02)
    )
    tests = [FrictionTest(tested_pair, load, coefficient=0.25, uncertainty=0.005) for load in ("20 MPa", "50 MPa")]
    strength = calibrate(tests, sliding="all")
    write_interface(replace(strength, fits=(replace(strength.fits[0], scores={}),)), tmp_path / "old.csv")
    old_strength = read_interface(tmp_path / "old.csv")
    name = "hardness log-normal 0.5..1.5"
    assert old_strength.fits[0].scores[name] == pytest.approx(strength.fits[0].scores[name], abs=1e-3)
    (_, low, high), (_, *expected) = (each.predict(predicted_pair, "50 MPa") for each in (old_strength, strength))
    assert [low, high] == pytest.approx(expected, abs=0.1 * np.ptp(expected))


def test_uncertainty_budget_of_a_tested_pair_lists_the_interface_but_no_contact_area_errors(tmp_path) -> None:
    options = PAIR_OPTIONS | {"hardness": "2 GPa ± 10 %"}
    tested_pair = pair(*rough_surface_pair(0.03), **options)
    tests = [FrictionTest(tested_pair, load, coefficient=0.25, uncertainty=0.004) for load in ("20 MPa", "50 MPa")]
    strength = calibrate(tests, common=0.0, sliding="all")
    write_interface(strength, tmp_path / "film.csv")
    options = {name: value for name, value in options.items() if name not in ("mu0", "tau0")}
    result = pair(*rough_surface_pair(0.03), interface=tmp_path / "film.csv", **options)
    assert result.study.pair_checksum == tested_pair.study.pair_checksum
    assert strength.predict(tested_pair, "20 MPa") == pytest.approx((result.value, *result.interval), rel=1e-6)
    assert result.budget["input"].tolist() == ["the interface with the hardness and other inputs of its tests"]
    assert result.interval == pytest.approx([0.244, 0.256], abs=0.003)


def test_prediction_interval_for_the_tested_pair_omits_the_error_of_its_contact_area() -> None:
    tested_pair = pair(*rough_surface_pair(0.03), hardness="0.8 GPa", **PAIR_OPTIONS)
    tests = [FrictionTest(tested_pair, "20 MPa", coefficient=0.25, uncertainty=0.0025)] * 4
    strength = calibrate(tests, common=0.0, sliding="all")
    prediction_for_same_pair = strength.predict(tested_pair, "20 MPa")
    prediction_for_other_pair = strength.predict(
        pair(*rough_surface_pair(0.02), hardness="0.8 GPa", **PAIR_OPTIONS), "20 MPa"
    )
    assert prediction_for_same_pair[1:] == pytest.approx(np.array([0.99, 1.01]) * 0.25, abs=0.0004)
    # The coefficient is that of the medians of mu0 and tau0, which the tests do not separate.
    assert prediction_for_same_pair[0] == pytest.approx(0.25, abs=0.0015)
    assert np.ptp(prediction_for_other_pair[1:]) > 2 * np.ptp(prediction_for_same_pair[1:])


def test_prediction_interval_includes_samples_with_mu0_at_the_lower_bound(tmp_path) -> None:
    tests = simulate_ball_tests(mu0=0.0, seed=11)
    interface = calibrate(tests, common=0.0, sliding="all")
    assert interface.mu0[1] == 0.0
    (tau0_at_bound,) = [tau0 for mu0, tau0 in interface.samples_at_bounds if not mu0.any()]
    # With mu0 = 0, only tau0 is unknown, and its estimate is a weighted mean with a normal error.
    ratio = np.array([BALL.area_per_load(float(test.load)) / test.uncertainty for test in tests])
    scaled_coefficients = np.array([test.coefficient / test.uncertainty for test in tests])
    estimate, error = ratio @ scaled_coefficients / (ratio @ ratio), 1 / math.sqrt(ratio @ ratio)
    assert np.median(tau0_at_bound) == pytest.approx(estimate, abs=0.1 * error)
    assert np.std(tau0_at_bound) == pytest.approx(error, rel=0.05)
    distant_ball = ball_and_load(interface.area_per_load / 3)
    write_interface(interface, tmp_path / "film.csv")
    for strength in (interface, read_interface(tmp_path / "film.csv")):
        _, lower, upper = strength.predict(*distant_ball)
        assert strength.possible_zeros == ("mu0",)
        coverage = compute_coverage_at_bound(strength.fits[0].mu0)
        low, high = np.quantile(tau0_at_bound, [(1 - coverage) / 2, (1 + coverage) / 2])
        assert lower <= low * interface.area_per_load / 3 * 1.000001 < upper
        assert strength.tau0[2] >= high * 0.999999
    text = " ".join(calibration_text(interface).split())
    assert "The tests do not exclude μ0 = 0, so all intervals include the results for this case." in text
    assert json.loads(calibration_json(interface))["possible_zeros"] == ["mu0"]


def test_calibration_with_mu0_fixed_at_zero_reports_no_samples_at_the_lower_bound() -> None:
    interface = calibrate(simulate_ball_tests(mu0=0.0), common=0.0, mu0=0.0, sliding="all")
    assert interface.samples_at_bounds == interface.possible_zeros == ()


def test_fits_with_mu0_or_tau0_at_zero_agree_with_tests_of_a_pair_whose_contacts_grow() -> None:
    tests = simulate_junction_growth_tests(27.0, 27.0, balls=False)
    interface = calibrate(tests, common=0.0, sliding="all")
    assert not interface.separated
    (_, tau0), (mu0, _) = interface.samples_at_bounds
    for strengths in ((0.0, np.median(tau0)), (np.median(mu0), 0.0)):
        coefficient = solve_coefficient(*(float(value) for value in strengths), 27.0)
        assert coefficient == pytest.approx(tests[0].coefficient, rel=0.005)
    text = " ".join(calibration_text(interface).split())
    assert "; all intervals include the results for μ0 = 0 and τ0 = 0." in text
    ends_text = f"μ0 = {np.median(mu0):.3g}, τ0 = 0, to μ0 = 0, τ0 = {1e3 * np.median(tau0):.3g} MPa"
    assert f"The tests allow all values near the line from {ends_text};" in text


def test_both_ends_of_the_printed_line_of_mu0_and_tau0_give_the_median_coefficient() -> None:
    random = np.random.default_rng(4)
    interface = calibrate([FrictionTest(BALL, 100.0, coefficient=0.4, uncertainty=0.02)], common=0.0, sliding="all")
    area_per_load = np.exp(0.2 * random.standard_normal(4000))
    total, mu0 = random.normal(0.4, 0.01, 4000), random.uniform(0.15, 0.4, 4000)
    mu0 = np.minimum(mu0, total)
    bound = replace(interface.fits[0], mu0=total, tau0=np.zeros(4000))
    fit = replace(bound, mu0=mu0, tau0=(total - mu0) / area_per_load, fits_at_bounds={"tau0": bound})
    interface = replace(interface, fits=(fit,), separated=False)
    assert interface.possible_zeros == ("tau0",)
    text = " ".join(calibration_text(interface).split())
    ends = re.search(r"near the line from μ0 = (\S+), τ0 = 0, to μ0 = (\S+), τ0 = (\S+) MPa", text)
    assert ends is not None
    high_mu0, low_mu0, high_tau0 = (float(number) for number in ends.groups())
    assert high_mu0 == pytest.approx(0.4, abs=0.002)
    assert low_mu0 == pytest.approx(np.quantile(fit.mu0, 0.025), abs=1e-3)
    # The median of A/F is 1/GPa.
    assert low_mu0 + 1e-3 * high_tau0 == pytest.approx(high_mu0, abs=0.02)


def test_mean_area_per_load_of_opposing_contacts_that_grow_is_within_its_interval(tmp_path) -> None:
    tests = [FrictionTest(compute_plastic_pair("slip-line"), "20 MPa", coefficient=0.2, uncertainty=0.01)] * 3
    interface = calibrate(tests, common=0.0, sliding="opposing")
    value, lower, upper = interface.tested_area_per_load
    assert lower < value < upper
    assert all(lower < area_per_load < upper for area_per_load, *_ in interface.tests)
    text = " ".join(calibration_text(interface).split())
    assert f"A/F of the tests: {Estimate(value, lower, upper).text()} 1/GPa" in text
    assert interface.area_per_load == value
    write_interface(interface, tmp_path / "law")
    assert read_interface(tmp_path / "law").tested_area_per_load[0] == value
    # Without a hardness, no yield limit moves the ball tests away from the mean A/F.
    fit_without_hardness = replace(interface.fits[0], hardness=np.full_like(interface.fits[0].hardness, math.nan))
    elastic_interface = replace(interface, fits=(fit_without_hardness,), tested_hardness=math.nan)
    assert math.prod(find_plan_conditions(elastic_interface).ball_area_per_load) == pytest.approx(value**2)
    (identified, *_) = json.loads(calibration_json(interface))["values"]
    assert identified["at"]["area_per_load_per_GPa"] == pytest.approx(value)


@pytest.mark.parametrize("sliding", ["all", "opposing"])
def test_scatter_of_coefficients_does_not_change_the_areas_of_equal_tests(sliding: Any) -> None:
    pair_result = compute_plastic_pair("slip-line")
    tests = [FrictionTest(pair_result, "20 MPa", coefficient=y, uncertainty=0.05) for y in (0.12, 0.2, 0.28)]
    interface = calibrate(tests, common=0.0, sliding=sliding)
    assert interface.variation == pytest.approx(0.0, abs=1e-4)
    assert not interface.separated
    assert interface.fits[0].freedom == 2


def test_samples_of_a_strong_interface_have_a_finite_area() -> None:
    tests = [FrictionTest(compute_plastic_pair("slip-line"), "20 MPa", coefficient=0.32, uncertainty=0.02)] * 2
    interface = calibrate(tests, common=0.0, sliding="opposing")
    assert np.isfinite(interface.fits[0].area_per_load).all()
    assert interface.possible_zeros == ("mu0", "tau0")


def test_fit_with_mu0_cells_of_zero_width_issues_no_warning(monkeypatch) -> None:
    """Near seizure, the width of a cell can be below the round-off of mu0."""
    choose_grid = CalibrationProblem._choose_mu0_grid_at_tau0

    def choose_grid_with_a_row_of_zero_width(*arguments: Any) -> Any:
        mu0_start, mu0_step = choose_grid(*arguments)
        return mu0_start, np.where(np.arange(mu0_step.shape[-1]) == 0, 0.0, mu0_step)

    monkeypatch.setattr(CalibrationProblem, "_choose_mu0_grid_at_tau0", choose_grid_with_a_row_of_zero_width)
    interface = calibrate(simulate_ball_tests(), common=0.0)
    assert interface.mu0[1] < MU0 < interface.mu0[2]


def test_understated_errors_of_friction_tests_are_scaled_up() -> None:
    tests = simulate_ball_tests(error=0.1, seed=2)
    tests_of_small_errors = [
        FrictionTest(BALL, test.load, coefficient=test.coefficient, uncertainty=test.uncertainty / 5) for test in tests
    ]
    fit = calibrate(tests_of_small_errors, sliding="all").fits[0]
    assert fit.probability < 0.05
    assert fit.scale > 2
    assert calibrate(tests, sliding="all").fits[0].scale == 1.0


@pytest.mark.parametrize(("factor", "entry"), [(0.5, ""), (1.2, "quote with care"), (20.0, "do not quote")])
def test_calibration_stores_a_caveat_if_the_tests_contradict_the_fitted_law(tmp_path, factor, entry) -> None:
    # The residuals alternate, so that they do not vary with the load.
    tests = [
        FrictionTest(BALL, load, coefficient=y * (1 + 0.03 * factor * (-1) ** index), uncertainty=0.02 * y)
        for index, load in enumerate(LOADS)
        for y in [MU0 + TAU0 * BALL.area_per_load(load)]
    ]
    write_interface(calibrate(tests, sliding="all"), tmp_path / "film")
    about = read_interface(tmp_path / "film").about
    assert [name for name in ("quote with care", "do not quote") if name in about] == ([entry] if entry else [])
    assert not entry or "its tests deviate from it by more than their errors allow (probability " in about[entry]


def test_unknown_uncertainties_of_friction_tests_are_estimated_from_their_scatter() -> None:
    tests = simulate_ball_tests(seed=4)
    tests_without_errors = [FrictionTest(BALL, test.load, coefficient=test.coefficient) for test in tests]
    expected, result = (calibrate(item, sliding="all", common=0.0) for item in (tests, tests_without_errors))
    ratio = (result.identified[2] - result.identified[1]) / (expected.identified[2] - expected.identified[1])
    assert 0.5 < ratio < 2.5


def test_friction_tests_without_sliding_are_lower_bounds_of_the_coefficient() -> None:
    sliding_tests = simulate_ball_tests()
    identified_values = calibrate(sliding_tests[:2], sliding="all").identified
    static_coefficient = sliding_tests[0].coefficient * 1.05
    static_tests = [FrictionTest(BALL, LOADS[0], coefficient=static_coefficient, uncertainty=0.01, slid=False)] * 3
    bounded_interface = calibrate([*sliding_tests[:2], *static_tests], sliding="all")
    area_per_load = BALL.area_per_load(LOADS[0])
    limit_before = np.quantile(
        calibrate(sliding_tests[:2], sliding="all").draws.eval(f"mu0 + tau0 * {area_per_load}"), 0.05
    )
    limit_after = np.quantile(bounded_interface.draws.eval(f"mu0 + tau0 * {area_per_load}"), 0.05)
    assert limit_after > limit_before
    assert identified_values[0] > 0


# ---- Junction growth -------------------------------------------------------------------------------------------------

PLASTIC_PAIR_OPTIONS = PAIR_OPTIONS | {"hardness": "0.625 GPa", "yield_exponent": 1.15}
STEEL_BALL = Ball("5 mm", "80 GPa")
DIRECT_SOLUTION_TOLERANCE = 0.01
"""Relative tolerance between a coefficient predicted at another hardness and a pair solved at that hardness."""


@cache
def compute_plastic_pair(alpha: Any, rms: float = 0.03, hardness: str = "0.625 GPa") -> Any:
    """Return the result of a pair with junction growth, whose contacts all yield at 0.625 GPa."""
    return pair(*rough_surface_pair(rms), **PLASTIC_PAIR_OPTIONS | {"hardness": hardness}, junction_growth=alpha)


@cache
def solve_coefficient(mu0: float, tau0: float, alpha: float, rms: float = 0.03, hardness: float = 0.625) -> float:
    """Return the coefficient at 20 MPa of the pair of `compute_plastic_pair`, solved at its hardness under shear."""
    pressure = float(hardness_under_shear(hardness, mu0, tau0, alpha))
    result = pair(
        *rough_surface_pair(rms),
        **PLASTIC_PAIR_OPTIONS | {"hardness": pressure, "mu0": mu0, "tau0": tau0},
        junction_growth=0,
    )
    return float(result.at("20 MPa")["mean_friction"].sel(sliding="all", statistic="mean").squeeze())


def simulate_junction_growth_tests(
    alpha: Any, true_junction_growth: float, *, balls: bool = True, mu0: float = 0.2, tau0: float = 0.05
) -> list[Any]:
    """Return exact friction tests on a plastic pair, and on a steel ball that does not yield."""
    y = solve_coefficient(mu0, tau0, true_junction_growth)
    tests = [FrictionTest(compute_plastic_pair(alpha), "20 MPa", coefficient=y, uncertainty=0.01 * y) for _ in range(3)]
    for load in (5.0, 50.0, 500.0, 5000.0) if balls else ():
        y = mu0 + tau0 * STEEL_BALL.area_per_load(load)
        tests.append(FrictionTest(STEEL_BALL, load, coefficient=y, uncertainty=0.01 * y))
    return tests


@cache
def fit_junction_growth_tests(alpha: Any, true_junction_growth: float, **options: Any) -> Interface:
    """Return the interface that these tests determine, which is fitted only once for all tests of this file."""
    return calibrate(simulate_junction_growth_tests(alpha, true_junction_growth), sliding="all", **options)


@pytest.mark.parametrize("growth", [3.0, 27.0])
def test_calibration_with_junction_growth_recovers_mu0_and_tau0(growth: float) -> None:
    interface = fit_junction_growth_tests(growth, growth, common=0.0)
    assert interface.mu0[0] == pytest.approx(0.2, abs=0.005)
    assert interface.tau0[0] == pytest.approx(0.05, rel=0.02)
    assert interface.mu0[1] < 0.2 < interface.mu0[2]
    assert set(interface.fits[0].junction_growth) == {growth}
    assert interface.about[JUNCTION_GROWTH_HEADER_ENTRY] == f"{growth:g}"


def test_calibration_with_slip_lines_recovers_mu0_and_tau0_and_samples_the_hardness_ratio(tmp_path) -> None:
    tests = simulate_junction_growth_tests("slip-line", "slip-line", mu0=0.2, tau0=0.02)
    interface = calibrate(tests, common=0.0, sliding="all")
    assert interface.mu0[1] < 0.2 < interface.mu0[2]
    assert interface.tau0[1] < 0.02 < interface.tau0[2]
    ratios = interface.fits[0].junction_growth
    assert 5.14 <= ratios.min() < 5.4 < 5.8 < ratios.max() <= 6.05
    assert interface.about[JUNCTION_GROWTH_HEADER_ENTRY] == "slip-line"
    write_interface(interface, tmp_path / "film.csv")
    assert read_interface(tmp_path / "film.csv").junction_growth.uses_slip_lines
    value, lower, upper = interface.predict(compute_plastic_pair("slip-line"), "20 MPa")
    assert lower < solve_coefficient(0.2, 0.02, "slip-line") < upper < 0.3
    assert value == pytest.approx(solve_coefficient(0.2, 0.02, "slip-line"), rel=0.02)


def test_prediction_for_an_interface_stronger_than_the_softer_body_has_no_upper_limit() -> None:
    interface = calibrate(simulate_ball_tests(mu0=0.3, tau0=0.05), sliding="all")
    value, lower, upper = interface.predict(compute_plastic_pair("slip-line"), "20 MPa")
    assert 0.1 < lower <= value < 0.45
    assert upper == math.inf


def test_calibration_with_junction_growth_agrees_with_a_brute_force_calculation() -> None:
    tests = simulate_junction_growth_tests(27.0, 27.0)
    interface = fit_junction_growth_tests(27.0, 27.0, common=0.0)
    axes = np.linspace(0.17, 0.23, 9), np.linspace(0.043, 0.057, 9)
    friction = compute_plastic_pair(27.0).at("20 MPa", mu0=axes[0], tau0=axes[1])["mean_friction"]
    predict = RegularGridInterpolator(
        axes, friction.sel(sliding="all", statistic="mean").squeeze().values, method="cubic"
    )
    mu0, tau0 = np.meshgrid(*(np.linspace(axis[0], axis[-1], 401) for axis in axes), indexing="ij")
    log_likelihood = np.zeros(mu0.shape)
    plastic_coefficient = predict((mu0, tau0))
    for test in tests:
        predicted_coefficients = (
            mu0 + tau0 * STEEL_BALL.area_per_load(float(test.load))
            if test.result is STEEL_BALL
            else plastic_coefficient
        )
        log_likelihood -= 0.5 * ((test.coefficient - predicted_coefficients) / test.uncertainty) ** 2
    weight = np.exp(log_likelihood - log_likelihood.max()).ravel()
    values = np.random.default_rng(0).choice(weight.size, 200_000, p=weight / weight.sum())
    for samples, value_and_interval in ((mu0, interface.mu0), (tau0, interface.tau0)):
        expected = np.quantile(samples.ravel()[values], [0.5, 0.025, 0.975])
        assert value_and_interval == pytest.approx(expected, abs=2 * SAMPLING_TOLERANCE * np.ptp(expected[1:]))


def test_friction_tests_on_both_a_ball_and_a_plastic_pair_determine_junction_growth() -> None:
    interface = calibrate(simulate_junction_growth_tests("0..27", 9.0), common=0.0, sliding="all")
    lower, middle, upper = np.quantile(interface.fits[0].junction_growth, [0.025, 0.5, 0.975])
    assert lower < 9.0 < upper
    assert middle == pytest.approx(9.0, abs=1.0)
    assert upper - lower < 8.0  # The interval from the given range of α alone would have a width of 25.7.
    assert "narrow the range to α = " in " ".join(calibration_text(interface).split())


def test_friction_tests_on_one_plastic_pair_do_not_determine_junction_growth() -> None:
    interface = calibrate(simulate_junction_growth_tests("0..27", 9.0, balls=False), sliding="all")
    lower, upper = np.quantile(interface.fits[0].junction_growth, [0.025, 0.975])
    assert lower < 1.5
    assert upper > 24.0
    assert "α = 0..27, a range that the tests do not narrow" in " ".join(calibration_text(interface).split())
    value, *ends = interface.predict(compute_plastic_pair("0..27"), "20 MPa")
    assert value == pytest.approx(solve_coefficient(0.2, 0.05, 9.0), rel=0.01)
    assert np.ptp(ends) < 0.12 * value  # The given range of α alone would give an interval from 0.28 to 0.376.


@pytest.mark.parametrize(("alpha", "true_junction_growth"), [(9.0, 9.0), ("0..27", 9.0), ("0..27", 20.0)])
def test_prediction_interval_for_a_harder_pair_contains_the_direct_solution(
    alpha: Any, true_junction_growth: float
) -> None:
    interface = fit_junction_growth_tests(alpha, true_junction_growth)
    expected = solve_coefficient(0.2, 0.05, true_junction_growth, 0.02, 1.25)
    value, lower, upper = interface.predict(compute_plastic_pair(alpha, 0.02, "1.25 GPa"), "20 MPa")
    assert lower < expected < upper
    assert value == pytest.approx(expected, rel=0.02)


def test_prediction_that_neglects_junction_growth_exceeds_the_direct_solution() -> None:
    interface = calibrate(simulate_junction_growth_tests(0, 20.0), sliding="all")
    predicted_coefficient, *_ = interface.predict(compute_plastic_pair(0, 0.02, "1.25 GPa"), "20 MPa")
    assert predicted_coefficient > 1.05 * solve_coefficient(0.2, 0.05, 20.0, 0.02, 1.25)
    assert interface.fits[0].scale > 1.5
    assert interface.about[JUNCTION_GROWTH_HEADER_ENTRY] == "0"


def test_prediction_issues_a_warning_if_result_and_tests_have_different_junction_growth() -> None:
    interface = fit_junction_growth_tests(9.0, 9.0)
    with pytest.warns(UserWarning, match="calibrated with junction growth 9, and the result has 0"):
        interface.predict(compute_plastic_pair(0), "20 MPa")
    interface.predict(STEEL_BALL, 50.0)  # there is no warning, because the ball does not yield


def test_calibration_of_tests_below_yield_reports_no_junction_growth() -> None:
    assert JUNCTION_GROWTH_HEADER_ENTRY not in calibrate(simulate_ball_tests()).about


def test_interface_file_preserves_junction_growth(tmp_path) -> None:
    path = tmp_path / "film.csv"
    interface = fit_junction_growth_tests("0..27", 9.0)
    write_interface(interface, path)
    stored_interface = read_interface(path)
    assert stored_interface.about[JUNCTION_GROWTH_HEADER_ENTRY] == "0..27"
    assert stored_interface.fits[0].junction_growth == pytest.approx(interface.fits[0].junction_growth, rel=1e-6)
    options = {name: value for name, value in PLASTIC_PAIR_OPTIONS.items() if name not in ("mu0", "tau0")}
    result = pair(*rough_surface_pair(0.03), **options, interface=path)
    assert result.study.contact.junction_growth.estimate.text == "0..27"
    assert result.study.contact.junction_growth == pytest.approx(9.0, abs=1.0)
    expected = interface.predict(compute_plastic_pair("0..27"), "20 MPa")
    table = result.at("20 MPa")["friction_combined"].sel(sliding="all").squeeze()
    assert table.values[0] == pytest.approx(solve_coefficient(0.2, 0.05, 9.0), rel=0.02)
    assert np.ptp(table.values[1:]) < 2 * np.ptp(expected[1:])
    contradicting_result = pair(*rough_surface_pair(0.03), **options, interface=path, junction_growth=20)
    assert any("calibrated with junction growth 0..27" in caveat.text for caveat in contradicting_result.caveats)
    # The study contains the junction growth of the tests.
    path.unlink()
    reopened = open_result(contradicting_result.path)
    assert any("calibrated with junction growth 0..27" in caveat.text for caveat in reopened.caveats)


def test_outlier_among_friction_tests_does_not_shift_a_robust_fit() -> None:
    tests = simulate_ball_tests()
    tests_with_outlier = [*tests, FrictionTest(BALL, LOADS[4], coefficient=3 * tests[4].coefficient, uncertainty=0.03)]
    expected = calibrate(tests, sliding="all").identified
    robust_interface = calibrate(tests_with_outlier, sliding="all", outliers=True).identified
    assert abs(robust_interface[0] - expected[0]) < 0.3 * (expected[2] - expected[1])


def test_error_common_to_all_tests_of_a_run_widens_the_interval() -> None:
    random = np.random.default_rng(8)
    offsets = {run: 0.1 * random.standard_normal() for run in "abcd"}
    tests = [
        FrictionTest(
            BALL, load, run=run, uncertainty=0.02 * y,
            coefficient=y * (1 + offsets[run] + 0.02 * random.standard_normal()),
        )
        for run in offsets
        for load in LOADS[::2]
        for y in [MU0 + TAU0 * BALL.area_per_load(load)]
    ]  # fmt: skip
    tests_without_runs = [
        FrictionTest(BALL, test.load, coefficient=test.coefficient, uncertainty=test.uncertainty) for test in tests
    ]
    interval_with_runs, interval_without_runs = (
        calibrate(item, sliding="all", common=0.0).identified for item in (tests, tests_without_runs)
    )
    assert interval_with_runs[2] - interval_with_runs[1] > interval_without_runs[2] - interval_without_runs[1]


def test_calibration_does_not_change_a_given_mu0_or_tau0() -> None:
    tests = simulate_ball_tests()
    interface_with_fixed_tau0 = calibrate(tests[:1], sliding="all", tau0="12 MPa")
    assert interface_with_fixed_tau0.separated
    assert set(interface_with_fixed_tau0.draws["tau0"]) == {0.012}
    assert calibrate(tests[:1], sliding="all", mu0=0.15).mu0 == (0.15, 0.15, 0.15)


@pytest.mark.parametrize(
    ("call", "pattern"),
    [
        (lambda: calibrate([]), "must contain at least one test with sliding"),
        (lambda: calibrate([3]), "must be a sequence of FrictionTest"),
        (
            lambda: calibrate(simulate_ball_tests(), mu0=1e300),
            r"^mu0 must be a finite number below 1e\+06, got 1e\+300$",
        ),
        (
            lambda: calibrate(simulate_ball_tests(), tau0=1e300),
            r"^tau0 must be a finite number below 1e\+06, got 1e\+300$",
        ),
        (lambda: FrictionTest(BALL, 1), "either coefficient or force"),
        (lambda: FrictionTest(BALL, 1, coefficient=0.1, force=1), "either coefficient or force"),
        (lambda: FrictionTest(BALL, "1 um", coefficient=0.1), "load .* unit"),
        (lambda: FrictionTest(BALL, 1, coefficient=-0.1), "not be negative"),
        (lambda: FrictionTest(BALL, 1, coefficient=1e-310, uncertainty=1e-311), "must be at least 1e-15"),
        (lambda: calibrate(simulate_ball_tests(), common=2), "below 1"),
        (lambda: calibrate(simulate_ball_tests(), tau0="3 um"), "tau0"),
        (
            lambda: calibrate([*simulate_ball_tests(), FrictionTest(BALL, 1, coefficient=0.1)]),
            "either all tests or no test must have",
        ),
    ],
)
def test_calibration_rejects_invalid_input(call, pattern: str) -> None:
    with pytest.raises(ValueError, match=pattern):
        call()


@cache
def load_curve_of_rough_surfaces(rms: float, hardness: float | None = None) -> HalfSpaceCurve:
    """Return the load curve of a pair of rough surfaces at eight loads."""
    surfaces = rough_maps(7, rms=rms, points=64, shortest_wavelength=0.4)
    loads = np.geomspace(0.001, 0.01, 8) * 6.4**2
    return half_space(*surfaces, loads, effective_modulus=60.0, boundary="periodic", hardness=hardness, sliding="all")


def compute_true_coefficient(body: Any, load: float, mu0: float, tau0: float) -> float:
    """Return the static friction coefficient of a ball or a load curve at a load (mN)."""
    if isinstance(body, Ball):
        return mu0 + tau0 * body.area_per_load(load)
    return float(np.interp(load, body.load, np.ravel(body.friction_coefficient(mu0=mu0, tau0=tau0))))


def ball_and_load(ratio: float) -> tuple[Ball, float]:
    """Return a ball, and the load (mN) at which its contact area per load is `ratio` (1/GPa)."""
    return BALL, 100.0 * (BALL.area_per_load(100.0) / ratio) ** 3


ROUGH_FINISH, SMOOTH_FINISH, SOFT_FINISH = (0.003, None), (0.001, None), (0.003, 0.1)
FRICTION_TEST_SERIES: dict[str, Any] = {
    "ball": ((None,), {}),
    "no adhesion": ((None,), {"tau0": 0.0}),
    "no mu0": ((None,), {"mu0": 0.0}),
    "one plastic pair": ((SOFT_FINISH,), {}),
    "one elastic pair": ((ROUGH_FINISH,), {}),
    "two finishes": ((ROUGH_FINISH, SMOOTH_FINISH), {}),
    "ball and pair": ((None, ROUGH_FINISH), {}),
    "two finishes, no adhesion": ((ROUGH_FINISH, SMOOTH_FINISH), {"tau0": 0.0}),
    "two finishes, no mu0": ((ROUGH_FINISH, SMOOTH_FINISH), {"mu0": 0.0}),
    "errors understated twice": ((ROUGH_FINISH, SMOOTH_FINISH), {"noise": 0.06}),
    "a tenth outliers": ((ROUGH_FINISH, SMOOTH_FINISH), {"outliers": 0.1}),
    "half without sliding": ((ROUGH_FINISH, SMOOTH_FINISH), {"static": 0.5}),
}


def simulate_coverage(kind: str, count: int) -> np.ndarray:
    """Simulate `count` test series, and return whether the predicted intervals contain the true mu_s.

    The array of shape (count, 3) has columns for 1/3, 1 and 3 times the area per load of the tests.
    """
    body_options, settings = FRICTION_TEST_SERIES[kind]
    bodies = [BALL if item is None else load_curve_of_rough_surfaces(*item) for item in body_options]
    loads = [LOADS if item is BALL else item.load for item in bodies]
    loaded_bodies = [(body, load) for body, item in zip(bodies, loads, strict=True) for load in item[:: len(bodies)]]
    random, is_covered = np.random.default_rng(1), []
    for _ in range(count):
        mu0 = settings.get("mu0", random.uniform(0.05, 0.4))
        tau0 = settings.get("tau0", random.uniform(0.005, 0.05))
        common_factor, tests = 1 + 0.02 * random.standard_normal(), []
        for body, load in loaded_bodies:
            y = compute_true_coefficient(body, load, mu0, tau0) * common_factor
            coefficient = y * (1 + settings.get("noise", 0.03) * random.standard_normal())
            if random.random() < settings.get("outliers", 0.0):
                coefficient *= random.choice([0.5, 1.5])
            is_static = random.random() < settings.get("static", 0.0) and any(test.slid for test in tests)
            coefficient *= random.uniform(0.6, 0.95) if is_static else 1.0
            tests.append(FrictionTest(body, load, coefficient=coefficient, uncertainty=0.03 * y, slid=not is_static))
        result: Interface = calibrate(tests, sliding="all", outliers="outliers" in settings)
        ratios = result.area_per_load * np.array([1 / 3, 1, 3])
        ends = [result.predict(*ball_and_load(ratio))[1:] for ratio in ratios]
        is_covered.append([lower <= mu0 + tau0 * x <= upper for x, (lower, upper) in zip(ratios, ends, strict=True)])
        assert result.separated == (result.variation >= 0.1)
    return np.array(is_covered)


def test_prediction_intervals_from_ball_tests_contain_the_true_friction() -> None:
    assert (
        simulate_coverage("ball", 40)[:, 1].sum() >= 34
    )  # At a coverage of 95 %, fewer than 34 of 40 intervals contain the true value with a probability of 0.4 %.


@pytest.mark.soak
@pytest.mark.parametrize("kind", FRICTION_TEST_SERIES)
def test_prediction_intervals_contain_the_true_friction_for_every_kind_of_test_series(kind: str) -> None:
    coverage = simulate_coverage(kind, 300).mean(axis=0)
    print(kind, coverage.round(3))
    assert coverage[1] > 0.92
    assert coverage.min() > 0.9


def test_calibration_intervals_agree_with_minos_intervals() -> None:
    iminuit = pytest.importorskip("iminuit")
    tests = simulate_ball_tests(seed=5)

    def chi_squared(mu0: float, tau0: float) -> float:
        predicted_coefficients = [mu0 + tau0 * BALL.area_per_load(float(test.load)) for test in tests]
        return sum(
            ((test.coefficient - y) / test.uncertainty) ** 2
            for test, y in zip(tests, predicted_coefficients, strict=True)
        )

    minuit = iminuit.Minuit(chi_squared, mu0=0.1, tau0=0.01)
    minuit.errordef = iminuit.Minuit.LEAST_SQUARES
    minuit.migrad()
    minuit.minos(cl=0.95)
    interface = calibrate(tests, common=0.0, sliding="all")
    for name, result in (("mu0", interface.mu0), ("tau0", interface.tau0)):
        width = minuit.merrors[name].upper - minuit.merrors[name].lower
        value = minuit.values[name]
        expected = value, value + minuit.merrors[name].lower, value + minuit.merrors[name].upper
        assert result == pytest.approx(expected, abs=SAMPLING_TOLERANCE * width)


@pytest.mark.parametrize(("modulus", "has_interval"), [("3 GPa", False), ("2..4 GPa", True)])
def test_calibration_text_states_an_interval_of_area_per_load_if_the_modulus_is_uncertain(modulus, has_interval):
    ball = Ball("5 mm", modulus)
    tests = [
        FrictionTest(ball, float(load), coefficient=MU0 + TAU0 * BALL.area_per_load(load), uncertainty=0.003)
        for load in LOADS
    ]
    interface = calibrate(tests)
    condition_text = (
        " ".join(calibration_text(interface).split()).partition("A/F of the tests: ")[2].partition("1/GPa")[0]
    )
    numbers = [float(word.strip("[],")) for word in condition_text.split()]
    assert numbers[0] == pytest.approx(interface.area_per_load, rel=0.01)
    range_text = " ".join(calibration_text(interface).split()).partition("the tests span ")[2].partition(" 1/GPa")[0]
    ratios = [ball.area_per_load(float(load)) for load in LOADS]
    assert [float(word) for word in range_text.split(" to ")] == pytest.approx([min(ratios), max(ratios)], rel=0.01)
    assert len(numbers) == (3 if has_interval else 1)
    if has_interval:
        assert numbers[2] / numbers[1] == pytest.approx(2 ** (2 / 3), rel=0.05)


# ---- Area loss of soft bodies ----------------------------------------------------------------------------------------

SOFT_BALL = Ball("5 mm", "2 MPa")


def simulate_soft_ball_tests(ball: Ball, loss: float) -> list[Any]:
    tests = []
    for load in (1.0, 10.0, 100.0):
        y = 0.1 + 3e-4 * (1 - loss) * ball.area_per_load(load)
        tests.append(FrictionTest(ball, load, coefficient=y, uncertainty=0.01 * y))
    return tests


def test_soft_ball_has_an_uncertain_area_loss_by_default() -> None:
    assert SOFT_BALL.lost_fraction.text == "0..0.3"
    assert float(BALL.lost_fraction) == 0
    assert float(Ball("5 mm", "2 MPa", area_loss=0.1).lost_fraction) == 0.1
    with pytest.raises(ValueError, match=r"area_loss must be from 0 to 0\.9"):
        Ball("5 mm", "2 MPa", area_loss="0..1.5")


@pytest.mark.parametrize(
    "arguments",
    [
        {"effective_modulus": "2..4.5 GPa", "area_loss": "0.1..0.2"},
        {"young": "2..3 GPa, 70 GPa", "poisson": "0.3, 0.2"},
        {"upper_material": "PMMA", "lower_material": "glass"},
    ],
)
def test_changing_the_radius_of_a_ball_copy_keeps_its_input_ranges(arguments: dict[str, Any]) -> None:
    ball = replace(Ball("5 mm", **arguments), radius="2 mm")
    assert ball == Ball("2 mm", **arguments)
    assert repr(ball) == repr(Ball("2 mm", **arguments))
    assert ball.moduli.inputs


def test_changing_the_modulus_of_a_ball_copy_updates_its_area_loss() -> None:
    assert replace(SOFT_BALL, effective_modulus="3 GPa") == BALL
    assert replace(SOFT_BALL, effective_modulus="3 GPa", area_loss=0.1).lost_fraction == 0.1


@pytest.mark.parametrize("ball", [
    Ball("5 mm", "2 MPa"), Ball("5 mm", "2..4 MPa", area_loss="0.1..0.2"), Ball(5e3, 1.5),
    Ball("5 mm", young="2 GPa, 3 GPa", poisson="0.3, 0.3"),
    Ball("5 mm", upper_material="steel", lower_material="PMMA"),
], ids=repr)  # fmt: skip
def test_repr_of_a_ball_creates_an_equal_ball(ball: Ball) -> None:
    assert eval(repr(ball)) == ball


def test_calibration_with_a_known_area_loss_recovers_tau0() -> None:
    ball = Ball("5 mm", "2 MPa", area_loss=0.2)
    interface = calibrate(simulate_soft_ball_tests(ball, 0.2), common=0.0, sliding="all")
    assert interface.tau0[0] == pytest.approx(3e-4, rel=0.01)


def test_prediction_interval_excludes_the_error_of_the_area_loss_only_for_the_tested_ball() -> None:
    interface = calibrate(simulate_soft_ball_tests(SOFT_BALL, 0.15), common=0.0, sliding="all")
    _, lower_tau0, upper_tau0 = interface.tau0
    assert lower_tau0 < 3e-4 * 0.9
    assert upper_tau0 > 3e-4 * 1.1
    widths = []
    for ball in (SOFT_BALL, Ball("4 mm", "2 MPa")):
        value, lower, upper = interface.predict(ball, 10.0)
        assert lower < 0.1 + 3e-4 * 0.85 * ball.area_per_load(10.0) < upper
        widths.append((upper - lower) / value)
    assert widths[0] < 0.05
    assert widths[1] > 0.2
