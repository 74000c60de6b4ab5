"""Test combined intervals of a contact whose area and friction are known in closed form."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm, t
from stiction.evaluate.combined_intervals import (
    POSITIONS_INPUT_NAME,
    UPPER_SCANS_INPUT_NAME,
    CombinedIntervals,
    InputSampler,
    compute_quantiles,
)
from stiction.evaluate.contact_area import AreaFunction
from stiction.evaluate.response import ContactResponseToInputs, InputValues
from stiction.study.inputs import Inputs
from support.synthetic_results import measured_study

LOAD, ELASTIC_AREA, NOMINAL_AREA = 10.0, 20.0, 10_000.0  # mN, µm², µm²
QUANTILE_ERROR = 0.01  # relative error of the logarithm of a quantile that is estimated from samples


def build_intervals(
    changes=None, *, hardness=None, mu0=0.0, tau0=0.05, half_width=0.0, spread=0.0, ok=(8, 8), sliding="all",
    drifts=None, area=ELASTIC_AREA, growth=0.0,
):  # fmt: skip
    """Return the intervals of a pair with the coefficient mu0 + tau0 A/F, where A is proportional to the load."""
    study = measured_study(hardness=hardness, mu0=[mu0]).with_changes(
        {"friction.tau0": [f"{tau0} GPa"]} | (changes or {})
    )
    loads = np.array([1.0, LOAD, 100.0])
    areas = AreaFunction(loads, area / LOAD * loads, NOMINAL_AREA, hardness, 1.15)
    names = [f"{load}_{part}" for load in ("normal", "tangential") for part in ("elastic", "frictional", "adhesive")]
    central_area = float(areas(LOAD))
    sums = dict.fromkeys(names, 0.0) | {
        "normal_elastic": 1.0, "tangential_frictional": 1.0, "tangential_adhesive": central_area / LOAD,
    }  # fmt: skip
    inputs = Inputs.from_study(study)
    central_values = InputValues(
        mu0=mu0, tau0=tau0, hardness=np.nan if hardness is None else hardness, yield_exponent=1.15,
        junction_growth=growth, uses_slip_lines=growth > 0,
    )  # fmt: skip
    response = ContactResponseToInputs(LOAD, sums, areas, central_values)
    values = response.evaluate(central_values)
    value = float(values.friction_coefficient)
    point = {
        "mean_friction": value * np.array([1.0, math.exp(-half_width), math.exp(half_width)]), "mu0": mu0, "tau0": tau0,
        "spread_low": value * (1 - spread / 2), "spread_high": value * (1 + spread / 2), "ok": np.array(ok),
        "members": max(ok), "contact_count": np.array([50.0]), "sliding": sliding,
    }  # fmt: skip
    uncertain_inputs = {name: uncertain_input for name, uncertain_input in inputs.uncertain.items() if name != "creep"}
    return CombinedIntervals(
        point, response, values, study, uncertain_inputs, InputSampler(study), drifts={} if drifts is None else drifts
    )


def log_width(interval):
    return math.log(interval[1] / interval[0])


def test_prediction_interval_has_the_degrees_of_freedom_of_the_direction_with_fewest_pairs():
    intervals, num_members, spread = build_intervals(spread=0.2, ok=(4, 8)), 4, 0.2
    deviation = spread / (norm.ppf(0.9) - norm.ppf(0.1)) * math.sqrt(1 + 1 / num_members)
    scale = math.sqrt(math.log1p(deviation**2))
    lower, upper = intervals.predict_next_test()
    expected = intervals.value * np.exp(scale * t.ppf([0.025, 0.975], num_members - 1))
    assert np.log([lower, upper]) == pytest.approx(np.log(expected), abs=QUANTILE_ERROR)
    percentiles = intervals.value * np.exp(scale * t.ppf([0.05, 0.5, 0.95], num_members - 1))
    assert np.log(intervals.predict_percentiles()) == pytest.approx(np.log(percentiles), abs=QUANTILE_ERROR)


def test_prediction_interval_includes_the_effect_of_roughness_drift_on_the_mean_and_on_the_new_test():
    intervals = build_intervals(drifts={UPPER_SCANS_INPUT_NAME: 0.1}, half_width=1e-6)
    limits = norm.ppf([0.025, 0.975])
    assert log_width(intervals.interval()) == pytest.approx(0.1 * np.ptp(limits), rel=QUANTILE_ERROR)
    prediction = intervals.predict_next_test()
    assert log_width(prediction) == pytest.approx(math.sqrt(2) * 0.1 * np.ptp(limits), rel=QUANTILE_ERROR)


def test_combined_interval_adds_input_error_and_scatter_in_quadrature():
    changes = {"friction.tau0": "0.03..0.08 GPa"}
    intervals = build_intervals(changes, tau0=0.04899, half_width=0.3)
    deviations = math.log(0.08 / 0.03) / (2 * norm.ppf(0.975)), 0.3 / norm.ppf(0.975)
    assert log_width(intervals.interval()) == pytest.approx(
        2 * norm.ppf(0.975) * math.hypot(*deviations), rel=QUANTILE_ERROR
    )
    assert log_width(intervals.interval({"tau0": 0.5})) == pytest.approx(0.6, rel=QUANTILE_ERROR)
    intervals_with_scatter = build_intervals(changes, tau0=0.04899, half_width=0.8)
    assert log_width(intervals_with_scatter.interval({POSITIONS_INPUT_NAME: 0.5})) == pytest.approx(
        math.log(0.08 / 0.03), rel=QUANTILE_ERROR
    )


@pytest.mark.usefixtures("all_input_samples")
def test_uncertainty_budget_averages_the_remaining_interval_width_over_possible_values_of_an_input():
    """A wide log-normal tau0 scales the effect of the modulus, so the mean width exceeds the width at the median."""
    changes = {"friction.tau0": "0.002..0.2 GPa", "contact.effective_modulus": "50..200 GPa"}
    intervals = build_intervals(changes, mu0=0.2, tau0=0.02)
    tau0, modulus = (
        Inputs.from_study(intervals.study).entries[name].estimate for name in ("tau0", "effective_modulus")
    )
    random = np.random.default_rng(3).random((2, 100_000))

    def compute_friction_angle_interval_width(strengths):
        coefficients = 0.2 + strengths * ELASTIC_AREA / LOAD * 100 / modulus.quantile(random[1])
        return np.ptp(np.arctan(np.quantile(coefficients, [0.025, 0.975])))

    widths = [compute_friction_angle_interval_width(tau0.quantile(quantile)) for quantile in (0.1, 0.5, 0.9)]
    assert np.mean(widths) > 1.5 * widths[1]
    expected = (
        np.mean(widths) / compute_friction_angle_interval_width(tau0.quantile(random[0])) * np.ptp(intervals.interval())
    )
    assert intervals.remaining_interval_width("tau0") == pytest.approx(expected, rel=0.03)


def test_combined_interval_of_the_true_area_is_limited_to_the_nominal_area():
    intervals = build_intervals({"contact.effective_modulus": "50..200 GPa"}, area=0.9 * NOMINAL_AREA, half_width=1e-6)
    estimates = {name: np.array([0.9, 0.85, 0.95]) for name in ("contact_area_fraction", "normal_stiffness")}
    widened_intervals = intervals.widen_quantity_intervals(estimates)
    assert widened_intervals["contact_area_fraction"][2] == 1.0
    assert widened_intervals["contact_area_fraction"][1] < 0.6
    assert widened_intervals["contact_area_fraction"][0] == 0.9


def test_combined_interval_of_a_quantity_contains_the_interval_of_the_mean():
    intervals = build_intervals({"friction.tau0": "0.0499..0.0501 GPa"}, half_width=1e-6)
    skewed = np.array([20.0, 19.0, 30.0])
    widened_intervals = intervals.widen_quantity_intervals({"contact_area": skewed})["contact_area"]
    assert widened_intervals[0] == 20.0
    assert widened_intervals[1] <= 19.0
    assert widened_intervals[2] >= 30.0


def test_contact_area_and_pressure_intervals_follow_the_range_of_the_modulus():
    intervals = build_intervals({"contact.effective_modulus": "80..125 GPa"}, half_width=1e-6)
    names = ("contact_area", "contact_area_fraction", "mean_pressure", "normal_stiffness", "unloading_stiffness")
    widened_intervals = intervals.widen_quantity_intervals({name: np.array([0.5, 0.5, 0.5]) for name in names})
    for name in names[:3]:
        assert widened_intervals[name][1:] / 0.5 == pytest.approx([0.8, 1.25], rel=QUANTILE_ERROR)
    # If the area is proportional to the load, the stiffness does not depend on the modulus.
    for name in names[3:]:
        assert widened_intervals[name][1:] / 0.5 == pytest.approx([1.0, 1.0], rel=QUANTILE_ERROR)


def test_uncertain_tau0_widens_only_the_interval_of_the_contact_area_at_the_onset_of_sliding():
    changes = {"friction.tau0": "uniform 0.05 .. 0.15 GPa", "contact.junction_growth": "slip-line 5.6"}
    intervals = build_intervals(changes, hardness=1.0, tau0=0.1, area=0.5, growth=5.6, half_width=1e-6)
    areas = {name: np.array([12.0, 12.0, 12.0]) for name in ("contact_area", "contact_area_at_onset")}
    widened_intervals = intervals.widen_quantity_intervals(areas)
    response = intervals.response
    expected = [
        12.0 * float(response.at_central_inputs(tau0=tau0).area_at_onset / response.at_central_inputs().area_at_onset)
        for tau0 in (0.0525, 0.1475)
    ]
    assert expected[1] > 1.1 * expected[0]
    assert widened_intervals["contact_area_at_onset"][1:] == pytest.approx(expected, rel=QUANTILE_ERROR)
    assert widened_intervals["contact_area"][1:] == pytest.approx([12.0, 12.0])


def test_coefficient_after_dwell_is_computed_with_the_hardness_for_each_sample_of_the_creep_exponent():
    changes = {"friction.wait": ["1 h"], "friction.creep": "uniform 0.01 .. 0.05", "contact.junction_growth": None}
    intervals = build_intervals(changes, hardness=1.0, tau0=0.1, area=0.5, half_width=1e-6, sliding="opposing")
    value, lower, upper = intervals.friction_after_dwell(3600.0)
    response, exponents = intervals.response, np.array([0.03, 0.011, 0.049])
    expected = intervals.value * np.array(
        [
            float(response.at_central_inputs(hardness=3600.0**-exponent).friction_coefficient)
            / float(response.at_central_inputs().friction_coefficient)
            for exponent in exponents
        ]
    )
    assert [value, lower, upper] == pytest.approx(expected, rel=QUANTILE_ERROR)
    assert intervals.friction_after_dwell(1.0)[0] == pytest.approx(intervals.value)


@pytest.mark.parametrize(("tau0", "limit", "dwell_time"), [(0.1883, 0.1885, 1.0), (0.182, 0.1823, 2.0)])
def test_friction_interval_has_no_upper_limit_if_the_softer_body_shears_at_central_input_values(
    tau0, limit, dwell_time
):
    """The softer body shears at the central tau0, but in less than 2.5 % of the samples."""
    changes = {
        "friction.wait": ["2 s"], "friction.creep": 0.05, "contact.junction_growth": "slip-line 5.6",
        "friction.tau0": f"{tau0} GPa (uniform 0.1 .. {limit} GPa)",
    }  # fmt: skip
    intervals = build_intervals(changes, hardness=1.0, tau0=tau0, area=0.5, growth=5.6, half_width=1e-6)
    value, lower, upper = intervals.friction_after_dwell(dwell_time)
    assert 0 < lower < value < math.inf == upper
    ends = [intervals.interval()[1], intervals.predict_next_test()[1]]
    assert np.isinf(ends).tolist() == [dwell_time == 1.0] * 2
    assert intervals.unlimited_fraction < 0.025


def test_friction_samples_have_no_upper_limit_if_tau0_exceeds_the_shear_strength():
    """The softer body shears if tau0 exceeds its shear strength H/R, because mu0 is 0."""
    changes = {"friction.tau0": "uniform 0.15 .. 0.2 GPa", "contact.junction_growth": "slip-line 5.6"}
    intervals = build_intervals(changes, hardness=1.0, tau0=0.175, area=0.5, growth=5.6)
    strength = 1 / 5.6
    # The model neglects reductions of the friction force of up to 5 %.
    expected = (0.2 - strength / 0.95) / 0.05
    assert intervals.unlimited_fraction == pytest.approx(expected, abs=0.02)


def test_interval_of_a_friction_coefficient_of_zero_starts_at_zero():
    intervals = build_intervals({"friction.mu0": "0 .. 0.1"}, mu0=0.05, tau0=0.0)
    zero = replace(intervals.response.central, mu0=0.0)
    point = {"mean_friction": np.zeros(3), "mu0": 0.0, "tau0": 0.0, "sliding": "all"}
    study, inputs = intervals.study, Inputs.from_study(intervals.study).uncertain
    response = replace(intervals.response, central=zero, sums=intervals.response.sums | {"tangential_elastic": -0.01})
    at_zero = CombinedIntervals(point, response, SimpleNamespace(), study, inputs, InputSampler(study))
    value, lower, upper = at_zero.estimate_zero_coefficient()
    assert (value, lower) == (0.0, 0.0)
    assert upper == pytest.approx(0.0975 - 0.01, rel=QUANTILE_ERROR)


@pytest.mark.parametrize("size", [1, 2, 3, 41, 1000])
def test_quantiles_of_finite_and_infinite_samples_are_bit_identical_to_those_of_numpy(size):
    probabilities = np.array([0.0, 0.025, 0.05, 0.25, 0.5, 0.95, 0.975, 1.0])
    samples = np.random.default_rng(size).lognormal(size=size)
    for values in (samples, samples.round(1)):
        np.testing.assert_array_equal(compute_quantiles(probabilities, values), np.quantile(values, probabilities))
        infinite = np.where(values > 2.0, np.inf, values)
        infinite[0] = np.inf
        np.testing.assert_array_equal(
            compute_quantiles(probabilities, infinite), np.quantile(infinite, probabilities, method="inverted_cdf")
        )


def test_quantiles_above_the_median_are_infinite_if_enough_upper_values_are_infinite():
    samples = np.random.default_rng(1).lognormal(size=1000)
    upper_samples = np.where(samples > np.quantile(samples, 0.9), np.inf, samples)
    lower, upper = compute_quantiles(np.array([0.025, 0.975]), samples, upper_samples)
    assert lower == np.quantile(samples, 0.025)
    assert upper == math.inf
