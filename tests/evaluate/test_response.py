"""Test the true area of yielding pairs and all quantities as functions of the inputs, against direct solutions."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest
import xarray
from stiction import half_space, pair
from stiction.evaluate.at_load import at_load
from stiction.evaluate.budget import _iterate_intervals
from stiction.evaluate.contact_area import AreaFunction, build_area_functions, iterate_pieces_with_true_areas
from stiction.evaluate.intervals import student_quantile
from stiction.mechanics.hardness import yielded_area
from stiction.solve import member_solution
from stiction.solve.member_sums import MemberSums
from stiction.study.members import read_measured_bodies
from stiction.views.rows import values_frame
from support.rough_surfaces import rough_maps

pytestmark = pytest.mark.usefixtures("no_companion_files")

HARDNESS, MODULUS, LOAD = 1.0, 80.0, 20.0  # GPa, GPa, mN
PAIR_OPTIONS = {
    "mu0": 0.2, "tau0": "50 MPa", "effective_modulus": MODULUS, "shifts": 4, "cutoff": "none", "onset": 0,
    "direction": [0.0, 180.0],
}  # fmt: skip
NO_UNCERTAIN_INPUTS = {(PAIR_OPTIONS["mu0"], 0.05): ({}, [])}


def rough_pair(rms=0.01):
    return rough_maps(5, hurst_exponent=0.7, rms=rms, points=64, spacing=0.05, shortest_wavelength=0.3)


def press_rough_pair(hardness=HARDNESS, **options):
    return pair(*rough_pair(), **PAIR_OPTIONS | {"load": f"{LOAD} MPa", "hardness": hardness} | options)


def get_mean(result, name):
    return float(result.at_study_loads[name].sel(statistic="mean").squeeze())


@pytest.fixture(scope="module")
def result():
    return press_rough_pair(yield_exponent=1.25)


def solve_members(result, load, hardness):
    """Return the areas (µm²) and the adhesive tangential sums of all members, each solved on its own."""
    bodies, contact = read_measured_bodies(result.study), result.study.contact
    curves = [
        half_space(*bodies.member(index, 0.0).pair, [load], **contact.solver_arguments() | {"hardness": hardness})
        for index in range(result.study.ensemble.repetitions)
    ]
    return np.array([curve.contact_area[0] for curve in curves])


def test_true_area_follows_from_the_elastic_area_in_closed_form(result):
    load = float(result.study.friction.load[0])
    elastic_area = solve_members(result, load, None).mean()
    expected = float(yielded_area(elastic_area, load, HARDNESS, 1.25))
    assert expected > 1.05 * solve_members(result, load, HARDNESS).mean()
    assert get_mean(result, "contact_area") == pytest.approx(expected, rel=1e-9)
    assert get_mean(result, "mean_pressure") == pytest.approx(load / expected, rel=0.02)


def test_adhesive_friction_is_proportional_to_the_true_area(result):
    capped_area = solve_members(result, float(result.study.friction.load[0]), HARDNESS).mean()
    coefficients = {
        tau0: float(result.at(tau0=tau0)["friction_combined"].sel(statistic="mean", sliding="all").squeeze())
        for tau0 in (0.0, 0.05)
    }
    adhesive_part = coefficients[0.05] - coefficients[0.0]
    area_at_onset = result.at(tau0=0.05)["contact_area_at_onset"].sel(statistic="mean")
    true_area, load = float(area_at_onset.squeeze()), float(result.study.friction.load[0])
    assert adhesive_part == pytest.approx(0.05 * true_area / load, rel=0.01)
    assert adhesive_part > 1.05 * 0.05 * capped_area / load


def test_elastic_contact_area_is_computed_only_for_the_first_pairs_of_a_result(result, monkeypatch):
    all_members = result.dataset["elastic_area"]
    assert np.isfinite(all_members).all()
    monkeypatch.setattr(member_solution, "NUM_ELASTIC_MAP_MEMBERS", 2)
    first_members = press_rough_pair(yield_exponent=1.25).dataset["elastic_area"]
    np.testing.assert_array_equal(first_members[:, :2], all_members[:, :2])
    assert np.isnan(first_members[:, 2:]).all()


def test_mean_elastic_area_of_all_pairs_is_extrapolated_from_the_first_pairs(result):
    dataset = result.dataset.copy(deep=True)
    is_first = dataset["repetition"] < 2
    dataset["elastic_area"] = dataset["elastic_area"].where(is_first)
    dataset["contact_area"] = dataset["contact_area"] * xarray.where(is_first, 1.0, 1.5)
    area = build_area_functions(MemberSums.of(dataset))[0]
    areas, elastic_areas = (
        dataset[name].isel(cut_off=0).transpose("repetition", "load").values
        for name in ("contact_area", "elastic_area")
    )
    expected = elastic_areas[:2].mean(axis=0) * areas.mean(axis=0) / areas[:2].mean(axis=0)
    np.testing.assert_allclose(area.elastic_areas, expected)


def test_adhesive_forces_are_scaled_by_the_ratio_of_true_area_to_stored_area(result):
    (piece,) = iterate_pieces_with_true_areas(MemberSums.of(result.dataset))
    factor = (piece["contact_area"] / result.dataset["contact_area"]).mean("repetition")
    assert (factor > 1.05).any()
    for name in ("normal_adhesive", "tangential_adhesive"):
        np.testing.assert_allclose(piece[name], (result.dataset[name] * factor).transpose(*piece[name].dims), rtol=1e-9)
    for name in ("normal_frictional", "tangential_frictional", "contact_count"):
        np.testing.assert_array_equal(piece[name], result.dataset[name])


def test_estimated_elastic_area_is_at_most_the_area_at_pressures_limited_to_the_hardness():
    hard_result = press_rough_pair(20.0)
    study = hard_result.study.with_changes({"contact.yield_exponent": None})
    dataset = hard_result.dataset.drop_vars("elastic_area").assign_attrs(study=study.to_toml())
    areas = dataset["contact_area"].mean("repetition").values.ravel()
    elastic_areas = build_area_functions(MemberSums.of(dataset))[0].elastic_areas
    assert (elastic_areas <= areas * (1 + 1e-12)).all()
    assert (elastic_areas > 0.5 * areas).all()


def test_dataset_stores_the_contact_area_at_pressures_limited_to_the_hardness(result):
    load = float(result.study.friction.load[0])
    stored = result.dataset["contact_area"].sel(load=load).mean().item()
    assert stored == pytest.approx(solve_members(result, load, HARDNESS).mean(), rel=1e-9)


@pytest.mark.parametrize(
    "changes", [{"effective_modulus": 50.0}, {"effective_modulus": 130.0}, {"hardness": 0.4}, {"hardness": 3.0},
                {"yield_exponent": 1.0}, {"hardness": 0.5, "effective_modulus": 120.0, "yield_exponent": 1.5}],
)  # fmt: skip
def test_area_evaluated_at_another_hardness_or_modulus_equals_that_of_a_direct_solution(result, changes):
    area = result.compute_once(build_area_functions)[0]
    direct_result = press_rough_pair(**{"yield_exponent": 1.25} | changes)
    load = float(result.study.friction.load[0])
    ratio = area(
        load, hardness=changes.get("hardness", HARDNESS), modulus=changes.get("effective_modulus", MODULUS) / MODULUS,
        yield_exponent=changes.get("yield_exponent", 1.25),
    ) / area(load)  # fmt: skip
    expected = get_mean(direct_result, "contact_area") / get_mean(result, "contact_area")
    # The tolerance is large because this pair has few contacts.
    assert float(ratio) == pytest.approx(expected, rel=0.01)


def test_true_area_as_a_function_of_load_does_not_exceed_the_nominal_area():
    area = AreaFunction(np.array([1.0, 10.0]), np.array([2.0, 15.0]), 20.0, 0.5, 1.25)
    assert area([1.0, 10.0, 1e6]).tolist() == [pytest.approx(float(yielded_area(2.0, 1.0, 0.5, 1.25))), 20.0, 20.0]
    assert area.elastic_area(np.sqrt(10.0)) == pytest.approx(np.sqrt(30.0))


@pytest.mark.usefixtures("all_input_samples")
def test_interval_of_the_area_contains_the_areas_at_both_limits_of_the_hardness():
    result_of_range = press_rough_pair("0.8..1.25 GPa", yield_exponent=1.25)
    estimate = result_of_range.at()["contact_area"].squeeze()
    value, lower, upper = (float(estimate.sel(statistic=name)) for name in ("mean", "lower", "upper"))
    sampling = result_of_range.at()["contact_count"].squeeze()
    assert sampling.sel(statistic="lower") < sampling.sel(statistic="mean")
    areas = [get_mean(press_rough_pair(hardness, yield_exponent=1.25), "contact_area") for hardness in (0.8, 1.25)]
    assert lower == pytest.approx(areas[1], rel=0.02)
    assert upper == pytest.approx(areas[0], rel=0.02)
    assert lower < areas[1] < value < areas[0] < upper


@pytest.mark.parametrize(
    ("name", "limits", "rms"), [("hardness", (0.7, 1.3), 0.05), ("effective_modulus", (64.0, 96.0), 0.005)]
)
def test_limits_of_the_closure_interval_are_closures_at_the_limits_of_the_uncertain_input(name, limits, rms):
    """A gap has a single position, so that its interval contains only the inputs."""
    upper, _ = rough_maps(5, hurst_exponent=0.7, rms=rms, points=128, spacing=0.05, shortest_wavelength=0.3)
    options = {"hardness": 1.0, "effective_modulus": 80.0, "load": "50 MPa", "cutoff": "none", "onset": 0, "mu0": 0.2}
    options |= {"yield_exponent": 1.15, "junction_growth": 0}
    values_of_range = pair(gap=upper, **options | {name: f"{limits[0]}..{limits[1]} GPa"}).at()
    central_closure = get_mean(pair(gap=upper, **options), "closure")
    lower, upper_limit = (
        float(values_of_range["closure"].sel(statistic=statistic).squeeze()) / central_closure
        for statistic in ("lower", "upper")
    )
    direct = [get_mean(pair(gap=upper, **options | {name: limit}), "closure") for limit in limits]
    expected = np.array(sorted(direct)) / central_closure
    assert (lower, upper_limit) == pytest.approx(tuple(expected), abs=0.2 * np.ptp(expected))


def test_pressure_interval_is_the_load_divided_by_the_area_interval():
    table = press_rough_pair("0.8..1.25 GPa").at()
    area, pressure = (table[name].squeeze().values for name in ("contact_area", "mean_pressure"))
    assert pressure[1:] == pytest.approx((pressure[0] * area[0] / area[1:])[::-1], rel=0.01)


@pytest.mark.parametrize("hardness", [HARDNESS, "0.8..1.25 GPa"])
def test_summary_table_and_joint_table_give_a_quantity_the_same_kind_of_interval(hardness):
    result_of_range = press_rough_pair(hardness)
    quantities = result_of_range.summary().points[0].quantities
    rows = values_frame(result_of_range.at()).set_index("name")
    combined_quantities = {
        "contact_area",
        "contact_area_fraction",
        "mean_pressure",
        "normal_stiffness",
        "closure_stiffness",
    }
    assert (
        {quantities[name].kind for name in combined_quantities}
        == set(rows.loc[sorted(combined_quantities), "kind"])
        == {"combined"}
    )
    assert quantities["contact_count"].kind == rows.loc["contact_count", "kind"] == "mean"
    table = result_of_range.joint_table(result_of_range.study.friction.load).rows[0].estimates
    assert {table[name].kind for name in combined_quantities & set(table)} == {"combined"}


def test_reference_load_of_a_joint_table_is_the_first_load_of_the_study():
    result = press_rough_pair(load=["10 MPa", "40 MPa"])
    first_load, second_load = map(float, result.study.friction.load)
    assert result.joint_table([first_load, second_load]).reference.load == pytest.approx(first_load)


def test_uncertain_yield_exponent_widens_the_interval_of_the_contact_area():
    exact_result, result_of_range = (
        press_rough_pair(yield_exponent=exponent) for exponent in (1.15, "uniform 0.7 .. 1.6")
    )
    assert result_of_range.value == exact_result.value
    widths = [
        np.ptp(result.at()["contact_area"].sel(statistic=["lower", "upper"]).values)
        for result in (exact_result, result_of_range)
    ]
    assert widths[1] > 1.2 * widths[0]
    assert "the yield exponent m" in set(result_of_range.budget["input"]) - set(exact_result.budget["input"])


def test_results_without_elastic_areas_use_the_area_at_pressures_limited_to_the_hardness(result):
    study = result.study.with_changes({"contact.yield_exponent": None})
    dataset = result.dataset.drop_vars("elastic_area").assign_attrs(study=study.to_toml())
    sums = MemberSums.of(dataset)
    load = float(result.study.friction.load[0])
    area = float(type(result)(dataset).at()["contact_area"].sel(statistic="mean").squeeze())
    assert area == pytest.approx(solve_members(result, load, HARDNESS).mean(), rel=1e-9)
    function = build_area_functions(sums)[0]
    assert function(load, hardness=0.5) > function(load) > function(load, hardness=2.0)


@functools.cache
def press_large_maps(rms, **changes):
    """Return the result of large maps at the central inputs, which is solved only once for all tests."""
    maps = rough_maps(5, hurst_exponent=0.7, rms=rms, points=128, spacing=0.05, shortest_wavelength=0.3)
    return pair(*maps, **PAIR_OPTIONS | {"load": f"{LOAD} MPa", "hardness": HARDNESS, "yield_exponent": 1.15} | changes)


@pytest.mark.parametrize("rms", [0.005, 0.02, 0.05])
@pytest.mark.parametrize(
    "changes", [{"hardness": 0.5}, {"hardness": 2.0}, {"effective_modulus": 60.0}, {"effective_modulus": 100.0}]
)
def test_stiffness_evaluated_at_another_hardness_or_modulus_agrees_with_a_direct_solution(rms, changes):
    result, direct_result = press_large_maps(rms), press_large_maps(rms, **changes)
    dims = ("cut_off", "sliding", "load", "mu0", "tau0")
    _, intervals = next(_iterate_intervals(result, result.at_study_loads, dims, NO_UNCERTAIN_INPUTS, {}, {}))
    inputs = replace(
        intervals.response.central,
        hardness=changes.get("hardness", HARDNESS),
        modulus=changes.get("effective_modulus", MODULUS) / MODULUS,
    )
    areas = intervals.response.areas_before_shear(inputs)
    loading, unloading, *_ = intervals.response.stiffness_ratios(inputs, areas.true)
    for name, ratio, tolerance in (
        ("unloading_stiffness", unloading, 0.1), ("normal_stiffness", loading, 0.2),
    ):  # fmt: skip
        expected = get_mean(direct_result, name) / get_mean(result, name)
        assert float(ratio) == pytest.approx(expected, rel=tolerance)


UNLOADING_AND_LOADING_STIFFNESSES = (
    ("unloading_stiffness", "normal_stiffness"), ("unloading_closure_stiffness", "closure_stiffness"),
    ("unloading_stiffness_per_area", "stiffness_per_area"),
)  # fmt: skip
"""Pairs of stiffnesses while unloading and while loading, which are equal for elastic bodies."""


def test_loading_and_unloading_stiffness_of_elastic_pairs_have_equal_intervals():
    maps = rough_maps(5, hurst_exponent=0.8, rms=0.3, points=32, spacing=1.0)
    options = {"load": "20 kPa", "mu0": 0.1, "onset": 0, "cutoff": "none", "area_loss": 0}
    table = pair(*maps, **options, effective_modulus="1..4 MPa").at().squeeze()
    direct_tables = [pair(*maps, **options, effective_modulus=f"{modulus} MPa").at().squeeze() for modulus in (1, 4)]
    for unloading, loading in UNLOADING_AND_LOADING_STIFFNESSES:
        assert table[unloading].values == pytest.approx(table[loading].values, rel=1e-9)
    for name in ("unloading_stiffness", "tangential_stiffness_per_area"):
        direct_means = sorted(float(table[name].sel(statistic="mean")) for table in direct_tables)
        assert table[name].values[1:] == pytest.approx(direct_means, rel=0.12)


def test_unloading_stiffness_of_yielding_maps_exceeds_loading_stiffness_if_later_members_are_stiffer():
    maps = rough_maps(5, hurst_exponent=0.8, rms=0.3, points=32, spacing=1.0)
    options = {"load": "20 kPa", "mu0": 0.1, "onset": 0, "cutoff": "none", "shifts": 8}
    result = pair(*maps, **options, effective_modulus="2 MPa", hardness="0.2 MPa")
    # The unloading stiffness was computed for the first four members only.
    later_members = result.dataset["repetition"] >= 4
    names = ("normal_stiffness", "closure_stiffness")
    assert result.dataset["unloading_stiffness"].where(later_members, drop=True).isnull().all()
    stiffer = {name: result.dataset[name].where(~later_members, 3 * result.dataset[name]) for name in names}
    table = type(result)(result.dataset.assign(stiffer)).at().squeeze()
    for unloading, loading in UNLOADING_AND_LOADING_STIFFNESSES:
        ratio = float(table[unloading].sel(statistic="mean") / table[loading].sel(statistic="mean"))
        stored_names = {"unloading_stiffness_per_area": "unloading_stiffness", "stiffness_per_area": "normal_stiffness"}
        stored_unloading, stored_loading = (
            result.dataset[stored_names.get(name, name)].where(~later_members, drop=True).isel(load=1)
            for name in (unloading, loading)
        )
        member_ratios = stored_unloading / stored_loading
        assert 1 <= float(member_ratios.min()) <= ratio <= float(member_ratios.max())


def test_interval_of_unloading_stiffness_includes_the_scatter_of_the_ratio_by_which_it_was_estimated():
    maps = rough_maps(5, hurst_exponent=0.8, rms=0.3, points=32, spacing=1.0)
    options = {"load": "20 kPa", "mu0": 0.1, "onset": 0, "cutoff": "none", "shifts": 8}
    result = pair(*maps, **options, effective_modulus="2 MPa", hardness="0.2 MPa")
    dataset, complete_dataset, relative_errors = result.dataset, result.dataset, {}
    for unloading, loading in UNLOADING_AND_LOADING_STIFFNESSES[:2]:
        compliance_ratios = dataset[loading] / dataset[unloading]
        known_count = int(compliance_ratios.isel(load=1).notnull().sum())
        mean_ratio = compliance_ratios.mean("repetition")
        standard_error = compliance_ratios.std("repetition", ddof=1) / known_count**0.5
        relative_error = student_quantile(known_count - 1) * standard_error / mean_ratio
        relative_errors[unloading] = float(relative_error.isel(load=1).squeeze())
        estimates = dataset[unloading].fillna(dataset[loading] / mean_ratio)
        complete_dataset = complete_dataset.assign({unloading: estimates})
    load = result.study.friction.load
    table, complete_table = (at_load(each, load).squeeze() for each in (dataset, complete_dataset))
    for name, relative_error in relative_errors.items():
        assert relative_error > 0.01
        mean, *limits = table[name].values
        complete_mean, *complete_limits = complete_table[name].values
        assert mean == pytest.approx(complete_mean, rel=1e-12)
        expected = np.hypot(np.log(np.array(complete_limits) / mean), relative_error)
        assert np.abs(np.log(np.array(limits) / mean)) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("load", "has_caveat"), [(LOAD, True), (0.5, False)])
def test_area_at_pressures_limited_to_the_hardness_has_a_caveat_if_contacts_yield(load, has_caveat):
    new_result = (
        press_rough_pair(6.0, load=f"{load} MPa", tau0=0.0) if not has_caveat else press_rough_pair(load=f"{load} MPa")
    )
    study = new_result.study.with_changes({"contact.yield_exponent": None})
    old_result = type(new_result)(new_result.dataset.drop_vars("elastic_area").assign_attrs(study=study.to_toml()))
    assert any("yielding below the surface" in caveat.text for caveat in old_result.caveats) == has_caveat
    assert not any("yielding below the surface" in caveat.text for caveat in new_result.caveats)


def test_missing_elastic_areas_of_an_unfinished_result_are_estimated(result):
    dataset = result.dataset
    unfinished_dataset = dataset.assign(elastic_area=dataset["elastic_area"] * np.nan)
    areas = [get_mean(type(result)(pair_dataset), "contact_area") for pair_dataset in (dataset, unfinished_dataset)]
    assert areas[1] == pytest.approx(areas[0], rel=0.25)
    table = type(result)(unfinished_dataset).at()
    assert np.isfinite(table["friction_combined"]).all()


def test_hardness_does_not_change_the_area_of_adhesive_contacts_that_do_not_yield():
    maps = rough_maps(5, hurst_exponent=0.7, rms=0.01, points=32, spacing=0.1, shortest_wavelength=0.4)
    options = PAIR_OPTIONS | {"load": "0.2 MPa", "work_of_adhesion": "0.2 J/m^2", "adhesion_range": "2 nm"}
    result, softer_result = (pair(*maps, **options, hardness=hardness) for hardness in (3.0, 2.0))
    area, load = result.compute_once(build_area_functions)[0], float(result.study.friction.load[0])
    assert get_mean(softer_result, "contact_area") == pytest.approx(get_mean(result, "contact_area"), rel=1e-3)
    assert float(area(load)) == pytest.approx(get_mean(result, "contact_area"), rel=0.01)
    assert float(area(load, hardness=2.0)) == pytest.approx(float(area(load)), rel=1e-12)


def test_stiffness_of_surfaces_with_scaled_heights_agrees_with_a_direct_solution(result):
    maps = rough_pair()
    scaled_maps = [type(surface)(1.1 * surface.heights, spacing=surface.spacing) for surface in maps]
    options = PAIR_OPTIONS | {"load": f"{LOAD} MPa", "hardness": 20.0, "yield_exponent": 1.15}
    unscaled_result, scaled_result = pair(*maps, **options), pair(*scaled_maps, **options)
    dims = ("cut_off", "sliding", "load", "mu0", "tau0")
    _, intervals = next(
        _iterate_intervals(unscaled_result, unscaled_result.at_study_loads, dims, NO_UNCERTAIN_INPUTS, {}, {})
    )
    inputs = replace(intervals.response.central, height_factor=1.1)
    loading, *_ = intervals.response.stiffness_ratios(inputs, intervals.response.areas_before_shear(inputs).true)
    assert float(loading) == pytest.approx(
        get_mean(scaled_result, "normal_stiffness") / get_mean(unscaled_result, "normal_stiffness"), rel=0.05
    )
