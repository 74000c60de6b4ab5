"""Tests of the datasets that figures draw."""

import numpy as np
import pytest
import xarray
from stiction import Profile, Result, contacts, open_result, run
from stiction.companions.contact_forces import build_contact_forces
from stiction.study.members import pair_of, read_measured_bodies
from stiction.summary.figure_values import (
    evaluate_positions,
    find_opposing_contacts,
    generate_bodies_by_length_scale,
    generate_profiles,
    iterate_motions,
)
from stiction.summary.report_data import collect_report_data
from stiction.views.figures.standard import select_figures
from support.generated_studies import SMALL_STUDY
from support.studies_of_files import run_pair_of_maps, run_pair_of_profiles


@pytest.fixture(scope="module")
def result_of_profiles(tmp_path_factory):
    return Result.of(run_pair_of_profiles(tmp_path_factory.mktemp("lines")))


def test_contact_forces_in_a_figure_equal_forces_returned_by_the_contacts_function(create_circular_arc):
    upper, lower = (create_circular_arc(2.0, 5.0, 0.01, 401, side) for side in ("upper", "lower"))
    upper = Profile(upper.heights + 0.005 * np.sin(8 * upper.x), spacing=upper.spacing)
    forces = build_contact_forces(upper, lower, 0.02, mu0=0.3, tau0=0.05)
    contact_table = contacts(upper, lower, 0.02)
    assert forces.sizes["contact"] == len(contact_table) > 0
    np.testing.assert_array_equal(forces["contact_force"], contact_table.force)
    np.testing.assert_array_equal(forces["contact_centre"].sel(axis="z"), contact_table.centre[:, 2])
    friction = np.where(contact_table.opposing, 0.3 * contact_table.force + 0.05 * contact_table.area, 0)
    np.testing.assert_array_equal(forces["contact_friction"], friction)
    # The largest overlap of the undeformed profiles is the approach, 0.02 µm.
    assert float((forces["upper_height"] - forces["lower_height"]).min()) == pytest.approx(-0.02)


def test_contact_opposes_motion_in_directions_of_positive_mean_slope():
    slopes = {"contact_slope_x": [0.2, -0.2, -0.1], "contact_slope_y": [0.1, 0.1, -0.3]}
    picture = xarray.Dataset({name: ("contact", values) for name, values in slopes.items()})
    expected_masks = {0.0: [1, 0, 0], 90.0: [1, 1, 0], 180.0: [0, 1, 1], 225.0: [0, 1, 1], 270.0: [0, 0, 1]}
    masks = {direction: find_opposing_contacts(picture, direction).tolist() for direction in expected_masks}
    assert masks == expected_masks


def test_contact_forces_of_measured_profiles_are_taken_from_the_first_pair_in_contact(result_of_profiles):
    result, forces = result_of_profiles, result_of_profiles.contact_forces
    load = float(result.study.friction.load[0])
    members = result.dataset.isel(cut_off=0).sel(load=load, method="nearest")
    first_index = int(np.flatnonzero(members["contact_count"].values > 0)[0])
    assert forces.attrs["load_mN"] == load
    assert forces.attrs["approach_um"] == float(members["approach"][first_index])
    member = read_measured_bodies(result.study).member(int(members["repetition"][first_index]), 0.0)
    assert forces.attrs["x"] == member.x
    np.testing.assert_array_equal(forces["lower_height"], member.pair[1].heights)
    assert float(forces["contact_force"].sum()) == pytest.approx(load, rel=0.02)


def test_contact_forces_of_generated_profiles_are_taken_from_the_first_pair_at_median_approach(small_result):
    forces, study = Result.of(small_result).contact_forces, Result.of(small_result).study
    has_contact = (small_result["contact_count"] > 0).any(["repetition", "fractal_dimension", "amplitude"])
    approaches = small_result["approach"].values[has_contact.values]
    assert forces.attrs["approach_um"] == approaches[approaches.size // 2]
    cell = {name: float(forces[name]) for name in ("fractal_dimension", "amplitude")}
    _, lower = pair_of(study, 0, **cell)
    np.testing.assert_array_equal(forces["lower_height"], lower.heights)


def test_contact_forces_are_none_for_maps(tmp_path):
    assert Result.of(run_pair_of_maps(tmp_path)).contact_forces is None


def test_coefficients_in_the_positions_figure_have_the_reported_mean(result_of_profiles):
    point = result_of_profiles.at().isel(cut_off=0, load=0, mu0=0, tau0=0)
    positions = evaluate_positions(result_of_profiles, point)
    mean = positions["member_friction"].mean("repetition").transpose("direction", "sliding")
    expected = point["friction_coefficient"].sel(statistic="mean").transpose("direction", "sliding")
    np.testing.assert_allclose(mean, expected, rtol=1e-12)
    assert set(positions.data_vars) == {*point.data_vars, "member_friction"}


def test_figures_and_reports_of_stored_results_do_not_load_the_sums_of_all_pairs(tmp_path, monkeypatch):
    run(SMALL_STUDY.with_changes({"ensemble.repetitions": 3}), store=tmp_path)
    result = open_result(tmp_path)

    def fail_on_access(_):
        raise AssertionError("the sums of all members are in memory")

    monkeypatch.setattr(Result, "dataset", property(fail_on_access))
    assert result.head.sizes["repetition"] == 1
    assert [draw().get_figheight() > 0 for _, draw in select_figures(result)] == [True] * 4
    assert collect_report_data(result).num_solved == 3


def test_figure_names_contain_the_direction_of_motion_if_there_are_several(small_result):
    result = Result.of(small_result)
    assert list(iterate_motions(result)) == [("", result)]
    directions = xarray.DataArray([0.0, 90.0], dims="direction", name="direction")
    both_directions = small_result.expand_dims(direction=directions)
    results = dict(iterate_motions(Result.of(both_directions)))
    assert list(results) == ["_0", "_90"]
    assert [float(direction_result.dataset["direction"]) for direction_result in results.values()] == [0.0, 90.0]


def test_profiles_figure_shows_evenly_spaced_fractal_dimensions_of_the_study():
    assert list(generate_profiles(SMALL_STUDY)) == SMALL_STUDY.surfaces.fractal_dimensions().tolist()
    study = SMALL_STUDY.with_changes({"surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 20}})
    dimensions = study.surfaces.fractal_dimensions()
    assert list(generate_profiles(study)) == dimensions[[0, 5, 10, 14, 19]].tolist()


def test_length_scale_figure_shows_surfaces_with_the_extent_of_the_study():
    bodies = generate_bodies_by_length_scale(SMALL_STUDY)
    assert list(bodies) == [factor * float(SMALL_STUDY.surfaces.length_scale) for factor in (0.5, 1.0, 2.0)]
    for profile, surface in bodies.values():
        assert profile.extent == pytest.approx(float(SMALL_STUDY.surfaces.extent))
        assert surface.heights.shape[0] == min(400, SMALL_STUDY.surfaces.points)
