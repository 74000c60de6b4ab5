"""Tests of the values of mu0 and tau0 that a report shows, and of the result evaluated at them."""

from collections import Counter

import numpy as np
import pytest
from stiction import Result, Study, pair, run, self_affine_surface
from stiction.evaluate.combined_intervals import CombinedIntervals
from stiction.mechanics.friction import CENTRAL_SHEAR_RATIO
from stiction.study.study import parse_study
from stiction.summary.assessment import MAX_LOAD_FRACTION_AT_EDGE_WITHOUT_CAVEAT
from stiction.summary.report_grid import MAX_TAU0_OVER_MODULUS, ReportGrid, build_parameter_axes
from stiction.summary.report_values import STATUSES_BY_CODE, evaluate_generated_report, evaluate_measured_report
from support.generated_studies import SMALL_STUDY
from support.studies_of_files import create_study_from_files, write_maps
from support.synthetic_results import measured_study


def test_sliders_of_a_report_include_mu0_and_tau0_of_the_study():
    mu0, tau0 = build_parameter_axes(
        SMALL_STUDY.with_changes({"friction.mu0": [0.37], "friction.tau0": ["3 MPa", "21 MPa"]})
    )
    assert {0.0, 0.37, 1.0} <= set(mu0.values)
    assert tau0.values.tolist() == [0.0, 0.003, 0.005, 0.01, 0.015, 0.02, 0.021]
    assert not any(axis.has_range.any() for axis in (mu0, tau0))


@pytest.mark.parametrize("modulus", ["3 MPa", "79 GPa", "1 TPa"])
def test_tau0_slider_has_three_to_six_round_steps_up_to_a_fraction_of_the_modulus(tmp_path, modulus):
    study = create_study_from_files(tmp_path, spacing=write_maps(tmp_path))
    changes = {"contact.effective_modulus": modulus, "friction.tau0": ["0 MPa"]}
    _, tau0 = build_parameter_axes(study.with_changes(changes))
    steps = np.diff(tau0.values)
    largest_tau0 = MAX_TAU0_OVER_MODULUS * float(study.with_changes(changes).contact.effective_modulus)
    assert tau0.values[0] == 0
    assert steps == pytest.approx(steps[0])
    assert 3 <= steps.size <= 6
    assert largest_tau0 - steps[0] < tau0.values[-1] <= largest_tau0
    mantissa = float(f"{steps[0]:.6e}".split("e")[0])
    assert mantissa in (1, 2, 5)


def test_tau0_slider_ends_below_the_shear_strength_of_the_softer_body():
    changes = {"contact.effective_modulus": "1 TPa", "friction.tau0": ["0 MPa"]}
    _, tau0 = build_parameter_axes(measured_study(hardness=1.0).with_changes(changes))
    assert 0.5 / CENTRAL_SHEAR_RATIO < tau0.values[-1] < 0.71 / CENTRAL_SHEAR_RATIO


def test_mu0_slider_has_an_uncertainty_range_only_at_the_value_of_the_study(tmp_path):
    study = create_study_from_files(tmp_path, spacing=write_maps(tmp_path))
    assert [axis.has_range.any() for axis in build_parameter_axes(study)] == [False, False]
    changes = {"friction.tau0": ["40 MPa"], "friction.mu0": "0.25001..0.35"}
    mu0, tau0 = build_parameter_axes(study.with_changes(changes))
    (study_value,) = study.with_changes(changes).friction.mu0
    assert mu0.values[mu0.has_range].tolist() == [study_value]
    # No other mu0 may be within 1e-3 of that of the study, because it would get the range of the study.
    assert np.sort(np.abs(mu0.values - study_value))[1] > 1e-3 * study_value
    assert not tau0.has_range.any()


def test_report_values_of_measured_surfaces_equal_the_summary_at_the_inputs_of_the_study():
    upper, lower = (
        self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(32, 32), spacing=0.1, side=side)
        for side in ("upper", "lower")
    )
    result = pair(
        upper, lower, load=["10 MPa", "20 MPa"], effective_modulus="80 GPa", mu0=0.2, tau0="30 MPa", shifts=3,
        direction=[0, 90],
    )  # fmt: skip
    grid = ReportGrid(result)
    values = evaluate_measured_report(grid)
    num_values = tuple(axis.values.size for axis in grid.axes)
    # one kind of member, one cutoff, two sliding rules, three motions (the mean and two directions), two loads
    assert values.friction.shape == (1, 1, 2, 3, grid.loads.size, *num_values, 3)
    assert grid.num_coefficients == values.friction[..., 0].size
    assert values.has_combined.tolist() == [[True, False, False]]
    assert np.isnan(values.friction[:, :, :, 1:, ..., 1:]).all()
    assert values.check_limits["share_at_edge"] == MAX_LOAD_FRACTION_AT_EDGE_WITHOUT_CAVEAT
    assert values.check_limits["contact_area"] is None
    mu0_index, tau0_index = (axis.find_index(value) for axis, value in zip(grid.axes, (0.2, 0.03), strict=True))
    for point in result.summary().points:
        load_index = int(np.abs(grid.loads - point.at["load"]).argmin())
        for rule in point.rules:
            rule_index = result.study.contact.sliding_rules().index(rule.rule)
            index = (0, 0, rule_index, 0, load_index, mu0_index, tau0_index)
            assert values.friction[index].tolist() == pytest.approx([rule.value, rule.lower, rule.upper], rel=1e-9)
            assert values.sampling[index].tolist() == pytest.approx([rule.value, *rule.interval_of_mean], rel=1e-9)
            assert values.slopes[(*index[:4], mu0_index, tau0_index)] == pytest.approx(rule.slopes, rel=1e-9)
            assert STATUSES_BY_CODE[values.status_codes[index]] == point.status
            assert values.num_solved[index] == point.members


def test_coefficient_interval_is_computed_only_once_for_summary_budget_and_report(monkeypatch):
    counts = Counter()
    compute_samples = CombinedIntervals._sample_all_strengths

    def count_and_compute(self, fixed, dwell_time=1.0, **for_tests):
        if not for_tests:
            counts[self.response.area, self.rule, self.response.load, self.mu0, self.tau0, *fixed.items()] += 1
        return compute_samples(self, fixed, dwell_time, **for_tests)

    monkeypatch.setattr(CombinedIntervals, "_sample_all_strengths", count_and_compute)
    upper, lower = (
        self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(32, 32), spacing=0.1, side=side)
        for side in ("upper", "lower")
    )
    result = pair(upper, lower, load="10 MPa", effective_modulus="80 GPa", mu0="0.2 +- 0.05", shifts=3, onset=0)
    (point,) = result.summary().points
    assert point.budget
    evaluate_measured_report(ReportGrid(result))
    assert ("all", *(point.at[name] for name in ("load", "mu0", "tau0"))) in {
        call_arguments[1:] for call_arguments in counts
    }
    assert len(counts) > 10
    assert set(counts.values()) == {1}


def test_report_of_generated_surfaces_contains_an_assessment_at_each_point():
    result = run(SMALL_STUDY)
    grid = ReportGrid(result)
    values = evaluate_generated_report(grid, result.num_solved)
    friction = values.estimates["friction"]
    assert grid.num_coefficients == friction[..., 0].size
    assert values.status_codes.shape == friction.shape[:-1]
    assert not values.is_valid[values.status_codes > 0].any()
    assert values.assessment_indices.shape == friction[:, :, 0, ..., 0].shape
    assert values.assessment_indices.max() == len(values.caveat_sets) - 1
    has_fault = np.array([any(reason.severity == "fault" for reason in reasons) for reasons in values.caveat_sets])
    rule_index = list(result.study.contact.sliding_rules()).index("opposing")
    is_missing = np.isnan(friction[:, :, rule_index, ..., 0])
    assert [assessment == "Do not quote" for assessment in values.assessments] == has_fault.tolist()
    assert has_fault[values.assessment_indices][is_missing].all()


HALF_PLANE_STUDY = Study.named("figure6-half-plane").with_changes(
    {"ensemble.repetitions": 4, "surfaces.points": 1000, "surfaces.fractal_dimension": [1.1, 1.5]}
)
MAP_STUDY = """
[surfaces]
kind = "surface"
generator = "weierstrass-mandelbrot"
fractal_dimension = [1.05, 1.3]
amplitude = ["5 nm"]
extent = ["5 um", "5 um"]
shape = [32, 32]
directions = 6
frequencies = 10

[contact]
mechanics = "half-space"
effective_modulus = "10 GPa"
sliding = ["opposing", "all"]
load = { start = "0.001 mN", stop = "1 mN", count = 4 }
{extra}

[friction]
mu0 = [0.0, 0.3]
tau0 = ["0 MPa", "50 MPa"]

[ensemble]
repetitions = 5
"""
ASSESSED_STUDIES = {
    "asperities": SMALL_STUDY,
    "half-plane": HALF_PLANE_STUDY,
    **{
        name: parse_study(MAP_STUDY.replace("{extra}", line), name)
        for name, line in (("hard", 'hardness = "0.5 GPa"'), ("adhesive", 'work_of_adhesion = "50 mJ/m^2"'))
    },
}


@pytest.mark.filterwarnings("ignore:adhesion_range")
@pytest.mark.parametrize("name", [*ASSESSED_STUDIES, "lower bounds"])
def test_assessments_in_reports_of_generated_surfaces_equal_summary_assessments(name):
    result = run(ASSESSED_STUDIES["adhesive" if name == "lower bounds" else name])
    if name == "lower bounds":
        dataset = result.dataset.copy(deep=True)
        dataset["pull_off_is_bound"][...] = 1
        result = Result.of(dataset)
    grid = ReportGrid(result)
    values = evaluate_generated_report(grid, result.num_solved)
    cell_coordinates = [result.head[coordinate_name].values for coordinate_name in ("fractal_dimension", "amplitude")]
    mu0, tau0 = (axis.values[[0, 2, -1]] for axis in grid.axes)
    num_unloaded, unloaded_caveat_names = 0, set()
    for load_index in np.linspace(0, grid.loads.size - 1, 5).astype(int):
        for point in result.summary(grid.loads[[load_index]], mu0=mu0, tau0=tau0).points:
            coordinates = (*cell_coordinates, *(axis.values for axis in grid.axes))
            keys = ("fractal_dimension", "amplitude", "mu0", "tau0")
            cell_index, amplitude_index, mu0_index, tau0_index = (
                int(np.abs(coordinate_values - point.at[coordinate_name]).argmin())
                for coordinate_values, coordinate_name in zip(coordinates, keys, strict=True)
            )
            index = int(values.assessment_indices[cell_index, amplitude_index, 0, load_index, mu0_index, tau0_index])
            assert values.assessments[index] == point.assessment
            reasons, caveats = (
                sorted(caveat.name or caveat.text for caveat in group)
                for group in (values.caveat_sets[index], point.caveats)
            )
            assert reasons == caveats
            if point.is_unloaded:
                num_unloaded += 1
                unloaded_caveat_names |= {caveat.name for caveat in point.caveats}
    assert (num_unloaded > 0) == (name in ("adhesive", "lower bounds"))
    assert ("share_of_pull_off_bounds" in unloaded_caveat_names) == (name == "lower bounds")


def test_pressure_and_caveats_of_a_summary_refer_to_the_quoted_sliding_rule():
    result = run(HALF_PLANE_STUDY)
    (_, point) = result.summary([0.1], mu0=[1.0], tau0=[0.2]).points
    area = point.values["contact_area"].sel(statistic="mean")
    assert float(area.sel(sliding="opposing")) != pytest.approx(float(area.sel(sliding="all")), rel=1e-3)
    assert point.rules[0].rule == "opposing"
    pressure = point.at["load"] / float(area.sel(sliding="opposing"))
    assert point.mean_pressure == pytest.approx(pressure, rel=1e-12)
    assert [caveat.value for caveat in point.caveats if caveat.name == "mean_pressure"] == pytest.approx(
        [pressure], rel=1e-12
    )
