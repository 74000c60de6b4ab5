"""Test members of studies of measured surfaces against direct solutions."""

import tracemalloc

import numpy as np
import pytest
from stiction import Profile, approach_at_load, flipped, half_space, levelled, press
from stiction._errors import NoSolutionError
from stiction.mechanics.friction import STATUSES
from stiction.solve import member_solution
from stiction.solve.contact_statistics import PairSlopeStatistics, compute_slopes
from stiction.solve.layout import (
    MEMBER_COORDINATE_TYPES,
    build_dataset,
    list_variable_names,
    stack_members,
    variable_specs,
)
from stiction.solve.member_solution import (
    compute_member_arrays,
    estimate_member_iterations,
    estimate_member_time,
    sum_over_members,
)
from stiction.study.members import find_body_attributes, read_measured_bodies
from support.rough_surfaces import rough_maps
from support.studies_of_files import create_study_from_files, write_maps, write_profiles

ROUND_OFF = 1e-9


@pytest.mark.parametrize("mechanics", ["half-space", "asperities"])
def test_stored_values_of_a_pair_of_maps_equal_values_of_its_half_space_solution(tmp_path, mechanics):
    study = create_study_from_files(tmp_path, mechanics=mechanics, spacing=write_maps(tmp_path))
    loads, angles = study.contact.loading_steps(), study.contact.direction_angles()
    values = compute_member_arrays(study, 2)
    upper, lower = read_measured_bodies(study).member(2, 0.0).pair
    for rule, sliding in enumerate(study.contact.sliding_rules()):
        if mechanics == "half-space":
            curve = half_space(upper, lower, loads, effective_modulus=100.0, direction=angles, sliding=sliding)
        else:
            approaches = approach_at_load(upper, lower, loads, mu0=0.0, effective_modulus=100.0)
            curve = press(upper, lower, approaches, effective_modulus=100.0, direction=angles, sliding=sliding)
        for name in ("tangential_elastic", "normal_frictional", "tangential_adhesive"):
            np.testing.assert_allclose(values[name][0, rule], getattr(curve, name), rtol=ROUND_OFF, atol=1e-14)
        np.testing.assert_allclose(values["contact_area"][0], curve.contact_area, rtol=ROUND_OFF)
        np.testing.assert_allclose(values["approach"][0], curve.approach, rtol=ROUND_OFF)
    np.testing.assert_allclose(values["normal_elastic"][0], loads, rtol=1e-6)
    assert (values["status"] == STATUSES.index("ok")).all()


def test_unloading_stiffness_of_yielding_bodies_is_computed_only_for_the_first_pairs(tmp_path):
    study = create_study_from_files(tmp_path, spacing=write_maps(tmp_path), contact='hardness = "4 GPa"')
    study = study.with_changes({"surfaces.cut_off": ["0 um", "0.3 um", "0.6 um"]})
    is_finite = [
        np.isfinite(compute_member_arrays(study, member)["unloading_stiffness"]).all(axis=-1).tolist()
        for member in (3, 4)
    ]
    assert is_finite == [[True, True, False], [False, False, False]]
    elastic_study = study.with_changes({"contact.hardness": None})
    stiffness = compute_member_arrays(elastic_study, 4)
    np.testing.assert_array_equal(stiffness["unloading_stiffness"], stiffness["normal_stiffness"])


def test_slope_statistics_of_a_pair_use_less_memory_than_the_slopes():
    upper, lower = rough_maps(points=128)
    tracemalloc.start()
    slopes = PairSlopeStatistics.from_pair(upper, lower)
    stored_bytes = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert stored_bytes < 0.5 * upper.heights.nbytes
    gap_slopes = [
        upper_slope - lower_slope
        for upper_slope, lower_slope in zip(*(compute_slopes(body) for body in (upper, lower)), strict=True)
    ]
    rms_gradient, rms_slopes = slopes.compute_gap_slopes(np.array([0.0, 90.0]))
    np.testing.assert_allclose(
        rms_slopes, [np.sqrt(np.mean(np.square(slope))) for slope in reversed(gap_slopes)], rtol=ROUND_OFF
    )
    assert rms_gradient == pytest.approx(np.hypot(*rms_slopes), rel=ROUND_OFF)


@pytest.mark.parametrize("mechanics", ["half-space", "asperities"])
def test_stored_values_of_a_pair_of_profiles_equal_sums_over_its_contacts(tmp_path, mechanics):
    study = create_study_from_files(tmp_path, "lines", mechanics, spacing=write_profiles(tmp_path), load="0.05 mN")
    loads = study.contact.loading_steps()
    values, member = compute_member_arrays(study, 3), read_measured_bodies(study).member(3, 0.0)
    scans = [Profile(np.load(tmp_path / f"{side}.npy"), spacing=0.02) for side in ("upper", "lower")]
    upper_profile, lower_profile = (levelled(scan, "line") for scan in scans)
    slider = levelled(Profile(flipped(upper_profile).heights[:600], spacing=0.02), "line")
    first_point = round(member.x / 0.02)
    assert 0 < first_point <= 600
    counterface = Profile(lower_profile.heights[first_point : first_point + 600], spacing=0.02)
    for direction_index, shear in enumerate(("+x", "-x")):
        for rule, sliding in enumerate(study.contact.sliding_rules()):
            if mechanics == "half-space":
                curve = half_space(
                    slider, counterface, loads, effective_modulus=100.0, direction=shear, sliding=sliding
                )
            else:
                model = {"effective_modulus": 100.0, "detection": "gap-minimum", "shear": shear}
                approaches = approach_at_load(slider, counterface, loads, mu0=0.0, **model)
                curve = press(slider, counterface, approaches, sliding=sliding, **model)
            for name in ("tangential_elastic", "normal_adhesive", "tangential_frictional"):
                np.testing.assert_allclose(
                    values[name][0, rule, direction_index],
                    getattr(curve, name),
                    rtol=ROUND_OFF,
                    atol=1e-14,
                    err_msg=name,
                )
    assert np.isnan(values["approach"]).all() == (mechanics == "half-space")


def test_dataset_of_solved_pairs_has_the_variables_declared_by_its_study(tmp_path):
    study = create_study_from_files(tmp_path, mechanics="asperities", spacing=write_maps(tmp_path), members=3)
    arrays_of_members = [compute_member_arrays(study, index) for index in range(3)]
    dataset = build_dataset(study, range(3), stack_members(study, arrays_of_members), find_body_attributes(study))
    assert set(dataset.data_vars) == set(list_variable_names(study))
    for name, item in variable_specs(study).items():
        assert dataset[name].dims == item.dims
        assert dataset[name].shape == item.shape
        assert "long_name" in dataset[name].attrs
    assert set(MEMBER_COORDINATE_TYPES) <= set(dataset.coords)
    assert float(dataset["nominal_area"]) == pytest.approx(3.6**2)
    assert "flipped" in dataset.attrs["upper"]


def test_pair_with_an_unsolved_load_has_values_at_the_other_loads(tmp_path, monkeypatch):
    study = create_study_from_files(tmp_path, spacing=write_maps(tmp_path), members=1)
    loads = study.contact.loading_steps()

    def solve_or_fail(upper, lower, loads, **rest):
        if np.isclose(loads, study.contact.loading_steps()[1]).any():
            raise NoSolutionError("no solution")
        return half_space(upper, lower, loads, **rest)

    monkeypatch.setattr(member_solution, "half_space", solve_or_fail)
    values = compute_member_arrays(study, 0)
    assert values["status"][0].tolist() == [
        STATUSES.index("not-solved" if index == 1 else "ok") for index in range(loads.size)
    ]
    assert np.isnan(values["normal_elastic"][0]).tolist() == [index == 1 for index in range(loads.size)]
    assert values["contact_count"][0, 1] == 0


def test_estimated_solution_time_of_a_pair_does_not_depend_on_the_number_of_pairs(tmp_path):
    spacing = write_maps(tmp_path)
    study_of_few_members, study_of_many_members = (
        create_study_from_files(tmp_path, spacing=spacing, members=count) for count in (2, 200)
    )
    assert estimate_member_time(study_of_few_members) == estimate_member_time(study_of_many_members) > 0


def test_estimated_solution_time_of_an_adhesive_pair_increases_with_its_compliance(tmp_path):
    spacing = write_maps(tmp_path)
    estimated_times = [
        estimate_member_time(
            create_study_from_files(tmp_path, spacing=spacing).with_changes(
                {"contact.mechanics": "half-space", "contact.work_of_adhesion": "50 mJ/m^2",
                 "contact.effective_modulus": modulus}
            )
        )
        for modulus in ("1 kPa", "1 GPa", "1 TPa")
    ]  # fmt: skip
    assert estimated_times[0] > estimated_times[1] > estimated_times[2] > 0
    assert estimated_times[0] > 15 * estimated_times[2]


def test_study_rejects_a_changed_scan_file_when_the_bodies_are_loaded(tmp_path):
    study = create_study_from_files(tmp_path, spacing=write_maps(tmp_path)).with_checksums()
    read_measured_bodies(study)
    np.save(tmp_path / "upper.npy", np.load(tmp_path / "upper.npy") * 2)
    with pytest.raises(ValueError, match=r"upper\.npy has changed since"):
        read_measured_bodies(study.with_changes({"ensemble.seed": 5}))


def create_half_space_study(directory, monkeypatch, num_points, **contact):
    """Return a study of maps that functions for run time estimates regard as maps with the given number of points."""
    monkeypatch.setattr(member_solution, "count_grid_points", lambda study: num_points)
    changes = {f"contact.{name}": value for name, value in contact.items()}
    return create_study_from_files(directory, spacing=write_maps(directory)).with_changes(
        {"contact.mechanics": "half-space"} | changes
    )


@pytest.mark.parametrize("num_points", [512**2, 2048**2])
def test_estimated_solution_time_of_maps_is_doubled_by_a_free_boundary(tmp_path, monkeypatch, num_points):
    free_time, periodic_time = (
        estimate_member_time(create_half_space_study(tmp_path, monkeypatch, num_points, boundary=boundary))
        for boundary in ("free", "periodic")
    )
    assert free_time == pytest.approx(2 * periodic_time, rel=0.01)


@pytest.mark.parametrize("estimate", [estimate_member_time, estimate_member_iterations])
def test_estimated_work_for_large_maps_is_about_doubled_by_the_elastic_area(tmp_path, monkeypatch, estimate):
    study = create_half_space_study(tmp_path, monkeypatch, 1536**2, hardness="1 GPa", yield_exponent=0.5)
    with_elastic_area, with_unloading, other = (estimate(study, member) for member in (0, 3, 5))
    assert with_elastic_area == pytest.approx(2.15 * other, rel=0.05)
    assert with_unloading == pytest.approx(1.25 * other, rel=0.05)
    assert other == estimate(study, None)
    total = sum_over_members(estimate, study, [range(1), range(1, 8)])
    assert total == pytest.approx(sum(estimate(study, member) for member in range(8)))


@pytest.mark.parametrize("options", [{}, {"hardness": "1 GPa", "work_of_adhesion": "50 mJ/m^2"}])
def test_estimated_work_is_equal_for_all_members_without_hardness_or_with_adhesion(tmp_path, monkeypatch, options):
    study = create_half_space_study(tmp_path, monkeypatch, 512**2, **options)
    for estimate in (estimate_member_time, estimate_member_iterations):
        assert estimate(study, 0) == estimate(study, 5) == estimate(study, None) > 0


def test_estimated_number_of_iterations_increases_only_for_large_maps(tmp_path, monkeypatch):
    iterations = [
        estimate_member_iterations(create_half_space_study(tmp_path, monkeypatch, side**2)) for side in (128, 512, 1536)
    ]
    assert iterations[0] == iterations[1]
    assert iterations[2] == pytest.approx(1.5 * iterations[1], rel=0.1)


def test_estimated_number_of_iterations_for_soft_adhesive_maps_does_not_depend_on_the_grid_size(tmp_path, monkeypatch):
    soft_adhesion_options = {"work_of_adhesion": "50 mJ/m^2", "effective_modulus": "1 kPa"}
    iterations = [
        estimate_member_iterations(create_half_space_study(tmp_path, monkeypatch, side**2, **soft_adhesion_options))
        for side in (128, 256, 512, 1024)
    ]
    assert iterations == pytest.approx(iterations[:1] * 4, rel=0.01)
