"""Test interpolation between the values of mu0 and tau0 at which a report stores friction coefficients."""

import numpy as np
import pytest
from stiction import Result, Study, pair, run, self_affine_surface
from stiction.study.study import parse_study
from stiction.summary.assessment import CAUTION_LOAD_FRACTION_AT_EDGE
from stiction.summary.nodes import (
    INTERVAL_TOLERANCE,
    MAX_SHOWN_ERROR_RATIO,
    VALUE_TOLERANCE,
    NodeAxis,
    build_initial_axes,
    compute_error_to_tolerance_ratio,
    find_interpolated_panels,
    find_largest_errors,
    interpolate_table,
    refine_axes,
)
from stiction.summary.values_at_nodes import ORDERED_STATUSES, evaluate_generated_nodes, evaluate_measured_nodes
from support.generated_studies import SMALL_STUDY
from support.studies_of_files import create_study_from_files, write_maps

NODE_AXES = NodeAxis(np.array([0.0, 0.1, 0.25, 0.6, 1.0])), NodeAxis(np.array([0.0, 0.02, 0.05, 0.1, 0.2]))


def create_grid(axes=NODE_AXES):
    return np.meshgrid(axes[0].values, axes[1].values, indexing="ij")


def analytic_friction(mu0, tau0):
    """Return a smooth coefficient and its interval ends as functions of mu0 and tau0."""
    mu0, tau0 = np.asarray(mu0)[:, np.newaxis], np.asarray(tau0)
    value = (0.01 + mu0 + 3 * tau0) / (1 - 0.2 * mu0)
    width = np.hypot(0.02, 0.5 * mu0 * tau0 + 0.1 * mu0)
    return np.stack([value, value - width, value + 1.2 * width], axis=-1)


@pytest.mark.parametrize("power", [0, 1, 2, 3])
def test_interpolation_in_a_report_reproduces_cubic_polynomials_exactly(power):
    mu0, tau0 = create_grid()
    table = (mu0 + 0.3) ** power * (tau0 - 0.1) ** power
    for point in ((0.07, 0.015), (0.3, 0.07), (0.99, 0.199), (0.25, 0.13)):
        assert interpolate_table(NODE_AXES, table, *point) == pytest.approx(
            (point[0] + 0.3) ** power * (point[1] - 0.1) ** power
        )


def test_interpolation_in_a_report_is_bilinear_next_to_undefined_nodes():
    mu0, tau0 = create_grid()
    table = mu0 + 2 * tau0
    table[-1, -1] = np.nan
    assert interpolate_table(NODE_AXES, table, 0.4, 0.07) == pytest.approx(0.54)
    assert np.isnan(interpolate_table(NODE_AXES, table, 0.8, 0.15))
    assert interpolate_table(NODE_AXES, table, 0.6, 0.2) == pytest.approx(1.0)  # This point is a node.


def test_node_of_an_uncertain_input_is_used_only_at_values_close_to_the_node():
    axis = NodeAxis(np.array([0.0, 0.1, 0.3, 0.7, 1.0]), np.array([0.2]))
    assert axis.weights(0.2).tolist() == [0, 0, 0, 0, 0, 1]
    assert axis.weights(0.2001)[-1] == 1
    assert axis.weights(0.21)[-1] == 0
    assert axis.weights(0.21).sum() == pytest.approx(1)


def test_node_axes_of_a_report_contain_mu0_and_tau0_of_the_study():
    mu0, tau0 = build_initial_axes(
        SMALL_STUDY.with_changes({"friction.mu0": [0.37], "friction.tau0": ["3 MPa", "21 MPa"]})
    )
    assert 0.37 in mu0.rising
    assert {0.003, 0.021} <= set(tau0.rising)
    assert [axis.rising[0] for axis in (mu0, tau0)] == [0, 0]
    assert tau0.rising[-1] == 0.021  # a study of generated surfaces limits the range of tau0


def test_node_axis_of_an_uncertain_input_has_a_separate_node_at_the_value_of_the_input(tmp_path):
    study = create_study_from_files(tmp_path, spacing=write_maps(tmp_path))
    assert [axis.ranged.size for axis in build_initial_axes(study)] == [0, 0]
    changes = {"friction.tau0": ["40 MPa"], "friction.mu0": "0.25..0.35"}
    mu0, tau0 = build_initial_axes(study.with_changes(changes))
    assert mu0.ranged.tolist() == [0.3]
    assert np.abs(mu0.rising - 0.3).min() > 3e-4
    assert tau0.ranged.size == 0


def test_interpolation_errors_on_refined_node_axes_are_below_ten_times_the_tolerance():
    coarse_axes = tuple(NodeAxis(axis.rising[[0, 2, 4]]) for axis in NODE_AXES)
    axes = refine_axes(coarse_axes, analytic_friction)
    assert sum(axis.rising.size for axis in axes) > 6
    table = analytic_friction(axes[0].values, axes[1].values)
    random = np.random.default_rng(1).uniform([0, 0], [1, 0.2], (50, 2))
    errors = [
        float(
            compute_error_to_tolerance_ratio(
                interpolate_table(axes, np.moveaxis(table, -1, 0), *point),
                analytic_friction(point[:1], point[1:])[0, 0],
            )
        )
        for point in random
    ]
    assert np.quantile(errors, 0.9) < 2
    value_error, ends_error = find_largest_errors(axes, table, analytic_friction)
    assert 0 < value_error < 10 * VALUE_TOLERANCE
    assert 0 < ends_error < 10 * INTERVAL_TOLERANCE


def test_limited_refinement_of_node_axes_adds_nodes_where_errors_are_largest():
    def analytic_friction_with_steep_end(mu0, tau0):
        """Return points whose upper end rises steeply at large tau0."""
        points = analytic_friction(mu0, tau0)
        points[..., 2] += 1e-3 / (0.22 - np.asarray(tau0))
        return points

    axes = refine_axes(
        (NODE_AXES[0], NodeAxis(NODE_AXES[1].rising[[0, 1, 2, 4]])), analytic_friction_with_steep_end, max_nodes=6
    )
    added_nodes = np.setdiff1d(axes[1].rising, NODE_AXES[1].rising)
    assert axes[1].rising.size == 6
    assert added_nodes.min() > 0.1


def test_panels_between_nodes_are_not_interpolated_if_errors_exceed_the_printed_tolerance():
    def analytic_friction_with_cusp(mu0, tau0):
        """Return points whose upper end has a cusp along mu0, at large tau0."""
        friction_values = analytic_friction(mu0, tau0)
        cusp_height = np.maximum(0.0, 0.1 - np.abs(np.asarray(mu0)[:, np.newaxis] - 0.4)) * (np.asarray(tau0) > 0.08)
        friction_values[..., 2] += 5 * cusp_height
        return friction_values

    axes = tuple(NodeAxis(np.linspace(0, axis.rising[-1], 21)) for axis in NODE_AXES)
    mu0, tau0 = (axis.rising for axis in axes)
    assert find_interpolated_panels(axes, analytic_friction(mu0, tau0)).all()
    is_hidden = ~find_interpolated_panels(axes, analytic_friction_with_cusp(mu0, tau0))
    assert not is_hidden[:, 0].any()  # The cusp is at large tau0 only.
    hidden_mu0 = mu0[is_hidden[:, -2]]
    assert {0.3, 0.4} <= set(hidden_mu0.round(3))
    assert hidden_mu0.min() >= 0.3 - 3 / 20  # A cubic polynomial extends over three panels.
    assert hidden_mu0.max() <= 0.5 + 2 / 20


def test_panels_between_nodes_are_interpolated_only_if_the_error_in_the_middle_of_each_panel_is_small():
    """Compare the mask with true errors for an upper end that diverges at large tau0."""

    def analytic_friction_with_steep_end(mu0, tau0):
        friction_values = analytic_friction(mu0, tau0)
        friction_values[..., 2] += 0.01 / (0.21 - np.asarray(tau0))
        return friction_values

    is_shown = find_interpolated_panels(
        NODE_AXES, analytic_friction_with_steep_end(*(axis.values for axis in NODE_AXES))
    )[:-1, :-1]
    middles = [axis.panel_split_points() for axis in NODE_AXES]
    table = np.moveaxis(analytic_friction_with_steep_end(*(axis.values for axis in NODE_AXES)), -1, 0)
    error = np.full(is_shown.shape, np.nan)
    for panel_index in np.ndindex(*is_shown.shape):
        mu0, tau0 = (middle[index] for middle, index in zip(middles, panel_index, strict=True))
        value, lower, upper = analytic_friction_with_steep_end([mu0], [tau0])[0, 0]
        error[panel_index] = np.abs(interpolate_table(NODE_AXES, table, mu0, tau0) - (value, lower, upper)).max() / (
            upper - lower
        )
    assert is_shown.any()
    assert not is_shown.all()
    assert (error[is_shown] < MAX_SHOWN_ERROR_RATIO).all()


def test_panels_with_a_jump_or_an_undefined_node_are_not_interpolated():
    mu0, tau0 = create_grid()
    smooth_values = 0.1 + mu0 + tau0
    friction_values = np.stack([smooth_values, 0.9 * smooth_values, 1.1 * smooth_values], axis=-1)
    assert find_interpolated_panels(NODE_AXES, friction_values).all()
    points_with_jump = np.where(mu0[..., np.newaxis] > 0.5, 3 * friction_values, friction_values)
    assert not find_interpolated_panels(NODE_AXES, points_with_jump)[2, :4].any()
    undefined_points = friction_values.copy()
    undefined_points[4, 4] = np.nan
    assert not find_interpolated_panels(NODE_AXES, undefined_points)[3, 3]
    assert find_interpolated_panels(NODE_AXES, undefined_points)[:3, :3].all()
    unbounded_points = friction_values.copy()
    unbounded_points[:, 4, 2] = np.inf
    assert not find_interpolated_panels(NODE_AXES, unbounded_points)[:4, 3].any()
    assert find_interpolated_panels(NODE_AXES, unbounded_points)[:4, :3].all()
    unbounded_points[..., 2] = np.inf
    assert find_interpolated_panels(NODE_AXES, unbounded_points).all()


def test_extra_node_does_not_change_the_interpolation_of_cubic_polynomials():
    axis = NODE_AXES[0]
    change_with_node_below, change_with_node_above = axis.weight_changes_with_extra_node(0.7)
    assert np.isnan(change_with_node_above).all()  # There is no node above 1.
    assert change_with_node_below @ axis.values**3 == pytest.approx(0, abs=1e-12)
    assert (axis.weights(0.7) + change_with_node_below) @ axis.values**4 == pytest.approx(0.7**4)
    assert [change.any() for change in axis.weight_changes_with_extra_node(0.6)] == [False, False]  # 0.6 is a node.


def test_values_at_nodes_of_measured_surfaces_equal_the_summary_at_the_inputs_of_the_study():
    upper, lower = (
        self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(32, 32), spacing=0.1, side=side)
        for side in ("upper", "lower")
    )
    result = pair(
        upper, lower, load=["10 MPa", "20 MPa"], effective_modulus="80 GPa", mu0=0.2, tau0="30 MPa", shifts=3,
        direction=[0, 90],
    )  # fmt: skip
    nodes = result.nodes
    values = evaluate_measured_nodes(nodes)
    num_nodes = tuple(axis.values.size for axis in nodes.axes)
    # one kind of member, one cutoff, two sliding rules, three motions (the mean and two directions), two loads
    assert values.friction.shape == (1, 1, 2, 3, nodes.loads.size, *num_nodes, 3)
    assert nodes.num_coefficients == values.friction[..., 0].size
    assert values.has_combined.tolist() == [[True, False, False]]
    assert np.isnan(values.friction[:, :, :, 1:, ..., 1:]).all()
    assert values.check_limits["share_at_edge"] == CAUTION_LOAD_FRACTION_AT_EDGE
    assert values.check_limits["contact_area"] is None
    mu0_index, tau0_index = (
        int(np.abs(axis.values - value).argmin()) for axis, value in zip(nodes.axes, (0.2, 0.03), strict=True)
    )
    for point in result.summary().points:
        load_index = int(np.abs(nodes.loads - point.at["load"]).argmin())
        for rule in point.rules:
            rule_index = result.study.contact.sliding_rules().index(rule.rule)
            index = (0, 0, rule_index, 0, load_index, mu0_index, tau0_index)
            assert values.friction[index].tolist() == pytest.approx([rule.value, rule.lower, rule.upper], rel=1e-9)
            assert values.sampling[index].tolist() == pytest.approx([rule.value, *rule.interval_of_mean], rel=1e-9)
            assert values.slopes[(*index[:4], mu0_index, tau0_index)] == pytest.approx(rule.slopes, rel=1e-9)
            assert ORDERED_STATUSES[values.status_codes[index]] == point.status
            assert values.num_solved[index] == point.members


def test_values_at_nodes_of_generated_surfaces_contain_an_assessment_of_each_point():
    result = run(SMALL_STUDY)
    nodes = result.nodes
    values = evaluate_generated_nodes(nodes, result.num_solved)
    friction = values.estimates["friction"]
    assert nodes.num_coefficients == friction[..., 0].size
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
def test_assessments_at_nodes_of_generated_surfaces_equal_those_of_summaries(name):
    result = run(ASSESSED_STUDIES["adhesive" if name == "lower bounds" else name])
    if name == "lower bounds":
        dataset = result.dataset.copy(deep=True)
        dataset["pull_off_is_bound"][...] = 1
        result = Result.of(dataset)
    nodes = result.nodes
    values = evaluate_generated_nodes(nodes, result.num_solved)
    cell_coordinates = [nodes.values[0][each].values for each in ("fractal_dimension", "amplitude")]
    mu0, tau0 = (axis.values[[0, 2, -1]] for axis in nodes.axes)
    num_unloaded, unloaded_caveat_names = 0, set()
    for load_index in np.linspace(0, nodes.loads.size - 1, 5).astype(int):
        for point in result.summary(nodes.loads[[load_index]], mu0=mu0, tau0=tau0).points:
            coordinates = (*cell_coordinates, *(axis.values for axis in nodes.axes))
            keys = ("fractal_dimension", "amplitude", "mu0", "tau0")
            cell_index, amplitude_index, mu0_index, tau0_index = (
                int(np.abs(each - point.at[key]).argmin()) for each, key in zip(coordinates, keys, strict=True)
            )
            index = int(values.assessment_indices[cell_index, amplitude_index, 0, load_index, mu0_index, tau0_index])
            assert values.assessments[index] == point.assessment
            reasons, caveats = (
                sorted(each.name or each.text for each in group) for group in (values.caveat_sets[index], point.caveats)
            )
            assert reasons == caveats
            if point.is_unloaded:
                num_unloaded += 1
                unloaded_caveat_names |= {caveat.name for caveat in point.caveats}
    assert (num_unloaded > 0) == (name in ("adhesive", "lower bounds"))
    assert ("share_of_pull_off_bounds" in unloaded_caveat_names) == (name == "lower bounds")


def test_pressure_and_caveats_of_a_point_are_those_of_the_quoted_sliding_rule():
    result = run(HALF_PLANE_STUDY)
    (_, point) = result.summary([0.1], mu0=[1.0], tau0=[0.2]).points
    area = point.values["contact_area"].sel(statistic="mean")
    assert float(area.sel(sliding="opposing")) != pytest.approx(float(area.sel(sliding="all")), rel=1e-3)
    assert point.rules[0].rule == "opposing"
    pressure = point.at["load"] / float(area.sel(sliding="opposing"))
    assert point.mean_pressure == pytest.approx(pressure, rel=1e-12)
    assert [each.value for each in point.caveats if each.name == "mean_pressure"] == pytest.approx(
        [pressure], rel=1e-12
    )
