"""Test `at_load`: the definitions of the load, and the means and intervals of the coefficient and other quantities."""

from pathlib import Path

import numpy as np
import pytest
import xarray
from stiction import (
    Result,
    Study,
    approach_at_load,
    area_map,
    friction_map,
    half_space,
    pair,
    press,
    run,
    self_affine_surface,
    stiffness_map,
)
from stiction.evaluate import budget, intervals
from stiction.evaluate.at_load import at_load
from stiction.evaluate.budget import add_uncertainty
from stiction.evaluate.load_range import choose_loads_in_range
from stiction.evaluate.member_means import find_axes_with_both_directions, include_interpolation_error
from stiction.evaluate.member_values import member_values
from stiction.mechanics.friction import STATUSES
from stiction.mechanics.quantities import (
    ONSET_QUANTITIES,
    QUANTITIES,
    RATIO_QUANTITIES,
    STIFFNESS_PER_AREA_QUANTITIES,
    quantity_names_shown_in,
    select_quantity_names,
)
from stiction.solve.member_sums import MemberSums
from stiction.study.contact_settings import MAX_AREAL_LOAD_RATIO, choose_load_steps
from stiction.study.members import read_measured_bodies
from stiction.study.study import parse_study
from stiction.views.quantities import quantities_paragraph, quantity_label
from stiction.views.rows import summary_table, values_frame
from support.rough_surfaces import rough_maps
from support.studies_of_files import create_study_from_files, write_maps, write_profiles

pytestmark = pytest.mark.usefixtures("no_companion_files")

SAMPLE_SCANS = Path(__file__).parents[2] / "examples/scans"

ROUND_OFF = 1e-9


@pytest.fixture(scope="module")
def areal_study_and_dataset(tmp_path_factory):
    directory = tmp_path_factory.mktemp("areas")
    study = create_study_from_files(directory, spacing=write_maps(directory), members=5)
    return study, run(study).dataset


@pytest.fixture(scope="module")
def profile_study_and_dataset(tmp_path_factory):
    directory = tmp_path_factory.mktemp("lines")
    study = create_study_from_files(
        directory, "lines", "asperities", spacing=write_profiles(directory), members=12, load="0.05 mN"
    )
    return study, run(study).dataset


def test_friction_of_profiles_at_a_load_equals_the_mean_of_press_results_over_positions(profile_study_and_dataset):
    study, result = profile_study_and_dataset
    pairs = [read_measured_bodies(study).member(index, 0.0).pair for index in range(12)]
    # Sort the positions, because the interval of the mean depends on their order.
    order = np.argsort(result["x"].values)
    material = {"mu0": 0.3, "tau0": 0.05}
    for load, mu0, tau0 in (("elastic", 0.0, 0.0), ("normal", *material.values())):
        table = at_load(result, [0.05], load_definition=load).sel(material).isel(cut_off=0, load=0)
        for angle, shear in ((0.0, "+x"), (180.0, "-x")):
            model = {"effective_modulus": 100.0, "detection": "gap-minimum", "shear": shear}
            curves = [
                press(*pair, approach_at_load(*pair, [0.05], mu0=mu0, tau0=tau0, **model), **model) for pair in pairs
            ]
            coefficients = np.array([curve.friction_coefficient(**material)[0] for curve in curves])[order]
            coefficients_at_load = table["friction_coefficient"].sel(sliding="opposing", direction=angle).values
            np.testing.assert_allclose(
                coefficients_at_load, intervals.average_correlated_values(coefficients), rtol=2e-3
            )
        if load == "elastic":
            area = np.array([curve.contact_area[0] for curve in curves])[order]
            np.testing.assert_allclose(table["contact_area"], intervals.average_correlated_values(area), rtol=1e-9)


def test_friction_is_equal_for_all_definitions_of_load_at_small_slopes(areal_study_and_dataset):
    _, result = areal_study_and_dataset
    tables = {
        load_definition: at_load(result, [2.0], load_definition=load_definition)
        for load_definition in ("mean", "elastic", "normal")
    }
    values = [table["mean_friction"].sel(statistic="mean").values for table in tables.values()]
    np.testing.assert_allclose(values[1], values[2], rtol=1e-3)
    np.testing.assert_allclose(values[0], values[1], rtol=2e-3)
    assert float(tables["elastic"]["load_definition_effect"].max()) < 1e-3
    assert {name: table.attrs["load_definition"] for name, table in tables.items()} == {
        name: name for name in tables
    }  # fmt: skip


def test_ensemble_mean_of_asperities_on_measured_maps_has_a_small_effect_of_the_load_definition():
    result = pair(
        *rough_maps(5, rms=0.05, shortest_wavelength=0.4), load="20 MPa", effective_modulus="80 GPa", mu0=0.2, shifts=2,
        mechanics="asperities",
    )  # fmt: skip
    elastic, mean = (result.at(load_definition=definition) for definition in ("elastic", "mean"))
    for rule in ("all", "opposing"):
        coefficients = [
            dataset["mean_friction"].sel(statistic="mean", sliding=rule).item() for dataset in (mean, elastic)
        ]
        assert coefficients[0] == pytest.approx(coefficients[1], rel=0.05)
    assert 0 < float(mean["load_definition_effect"].max()) < 0.05


def test_relative_effect_of_the_load_definition_on_friction_is_finite_if_friction_is_zero(areal_study_and_dataset):
    _, result = areal_study_and_dataset
    table = at_load(result, [2.0], mu0=[0.0, 0.3], tau0=[0.0])
    assert abs(table["mean_friction"].sel(sliding="all", mu0=0.0, statistic="mean").item()) < 1e-12
    assert np.isfinite(table["load_definition_effect"]).all()
    friction_free_table = at_load(result, [2.0], mu0=[0.0], tau0=[0.0])
    assert not np.isinf(friction_free_table["load_definition_effect"]).any()


def test_friction_of_generated_profiles_at_a_load_equals_the_value_in_the_friction_map():
    study = Study.named("quick").with_changes({
        "ensemble.repetitions": 4, "surfaces.points": 4000, "surfaces.fractal_dimension": [1.1, 1.3],
    })  # fmt: skip
    result = run(study).dataset
    load = float(choose_loads_in_range(result, 5)[2])
    table, friction = at_load(result, [load]), friction_map(result, [load])
    np.testing.assert_array_equal(table["friction_coefficient"].sel(statistic="mean"), friction["friction_coefficient"])
    np.testing.assert_array_equal(table["friction_coefficient"].sel(statistic="upper"), friction["upper"])
    assert int(table["members"]) == 4
    elastic_table = at_load(result, [load], load_definition="elastic")
    assert elastic_table["friction_coefficient"].dims == (
        "fractal_dimension", "amplitude", "sliding", "direction", "load", "mu0", "tau0", "statistic",
    )  # fmt: skip


GENERATED_MAPS_STUDY_TEMPLATE = """
[surfaces]
kind = "surface"
fractal_dimension = [1.3]
amplitude = ["5 nm"]
extent = ["5 um", "5 um"]
shape = [32, 32]
directions = 6
frequencies = 10

[contact]
mechanics = "{mechanics}"
sliding = ["opposing", "all"]
{lines}

[friction]
mu0 = [0.3]
tau0 = ["50 MPa"]

[ensemble]
repetitions = 3
"""
LOADS = 'load = { start = "0.001 mN", stop = "1 mN", count = 4 }'
MECHANICS_AND_CONTACT_KEYS_BY_STUDY = {
    "asperities": ("asperities", ""),
    "yielding": ("half-space", f'{LOADS}\nhardness = "0.5 GPa"'),
    "adhesive": ("half-space", f'{LOADS}\nwork_of_adhesion = "50 mJ/m^2"'),
}
MEAN_LOAD_QUANTITIES = {"normal_load", "tangential_load"}
QUANTITIES_PER_NOMINAL_AREA = {"contact_area_fraction", "nominal_pressure", *STIFFNESS_PER_AREA_QUANTITIES}


def run_study_of_generated_maps(name):
    mechanics, lines = MECHANICS_AND_CONTACT_KEYS_BY_STUDY[name]
    return run(
        parse_study(GENERATED_MAPS_STUDY_TEMPLATE.replace("{mechanics}", mechanics).replace("{lines}", lines), name)
    )


@pytest.mark.filterwarnings("ignore:adhesion_range")
@pytest.mark.parametrize("name", MECHANICS_AND_CONTACT_KEYS_BY_STUDY)
def test_data_frame_and_csv_file_of_an_ensemble_contain_every_quantity(name):
    result = run_study_of_generated_maps(name)
    quantities_of_members = {
        str(variable) for variable in result.at(load_definition="elastic").data_vars if QUANTITIES[str(variable)].shown
    }
    expected = quantities_of_members - MEAN_LOAD_QUANTITIES - {"share_opposing"}
    # The approach of an asperity study is given, not evaluated.
    expected -= {"approach"} if name == "asperities" else set()
    summary = result.summary()
    frame, table = values_frame(summary.at), summary_table(summary)
    assert expected <= {*frame["name"]}
    for quantity_name in expected & {*quantity_names_shown_in("csv")}:
        title = quantity_label(quantity_name, result.study)
        assert any(str(column).startswith(title) for column in table), title
    assert frame.loc[frame["name"] == "mean_pressure", "value"].notna().any()


@pytest.mark.filterwarnings("ignore:adhesion_range")
def test_values_at_a_load_contain_every_ratio_of_quantities_that_applies_to_the_surfaces(
    areal_study_and_dataset, profile_study_and_dataset
):
    measured_names = {
        str(variable) for study, dataset in (areal_study_and_dataset, profile_study_and_dataset)
        for variable in at_load(dataset, study.friction.load).data_vars
    }  # fmt: skip
    generated_names = {
        str(variable)
        for name in MECHANICS_AND_CONTACT_KEYS_BY_STUDY
        for variable in run_study_of_generated_maps(name).at().data_vars
    }
    shown_ratios = {name for name in RATIO_QUANTITIES if QUANTITIES[name].shown}
    assert shown_ratios - measured_names == {"share_overlapping"}
    assert shown_ratios - generated_names == QUANTITIES_PER_NOMINAL_AREA


def test_mean_pressure_of_an_ensemble_is_the_load_divided_by_the_mean_area():
    values = run_study_of_generated_maps("yielding").at()
    area = values["contact_area"].sel(statistic="mean")
    np.testing.assert_allclose(
        values["mean_pressure"], (values["load"] / area).transpose(*values["mean_pressure"].dims)
    )


def test_mean_pressure_has_three_digits_in_tables_and_caveats():
    point = run_study_of_generated_maps("yielding").summary().points[0]
    (table,) = quantities_paragraph([point])
    (text,) = (row[1] for row in table.rows if row[0].startswith("mean pressure"))
    assert text == f"{1e3 * point.mean_pressure:.3g}"


def test_overlapping_contacts_of_the_asperity_model_add_a_caveat():
    result = run_study_of_generated_maps("asperities")
    ratio = result.at()["share_overlapping"]
    assert 0 <= float(ratio.min()) < float(ratio.max()) <= 1
    assert "share_overlapping" in {caveat.name for point in result.summary().points for caveat in point.caveats}


def test_evaluating_selected_quantities_gives_the_values_of_a_complete_evaluation(areal_study_and_dataset):
    study, result = areal_study_and_dataset
    loads = study.contact.loading_steps()[1:3]
    complete_table = at_load(result, loads, mu0=[0.1, 0.4], tau0=[0.0, 0.02])
    selected_table = at_load(
        result, loads, mu0=[0.1, 0.4], tau0=[0.0, 0.02], names=("contact_count", "gentle_friction")
    )
    assert set(selected_table.data_vars) < set(complete_table.data_vars)
    assert {"mean_friction", "contact_area", "contact_count", "gentle_friction"} <= set(selected_table.data_vars)
    assert "load_definition_effect" not in selected_table
    for name in selected_table.data_vars:
        assert selected_table[name].equals(complete_table[name]), name


def test_stiffnesses_per_nominal_area_have_equal_units(areal_study_and_dataset):
    _, dataset = areal_study_and_dataset
    values = at_load(dataset, dataset["load"].values[:2]).squeeze()
    stiffness_per_area = values["normal_stiffness"] / values["nominal_area"] * 1e6  # GPa/µm to MPa/mm
    np.testing.assert_allclose(values["stiffness_per_area"], stiffness_per_area, rtol=1e-12)
    names = ("stiffness_per_area", "unloading_stiffness_per_area", "closure_stiffness")
    assert {values[name].attrs["units"] for name in names if name in values} == {"MPa/mm"}


@pytest.fixture(scope="module")
def result_of_yielding_maps():
    upper, lower = (
        self_affine_surface(
            6, hurst_exponent=0.8, rms=0.03, shape=(64, 64), spacing=0.1, shortest_wavelength=0.6, side=side
        )
        for side in ("upper", "lower")
    )
    options = {"young": "100 GPa,70 GPa", "poisson": "0.3,0.35", "hardness": "2 GPa", "cutoff": "none", "onset": 2}
    return pair(upper, lower, load=["20 MPa", "60 MPa"], mu0=0.2, tau0="50 MPa", shifts=4, **options)


def get_means(values, name):
    return values[name].sel(statistic="mean").values.ravel()


def test_closure_stiffness_is_the_derivative_of_load_with_respect_to_mean_closure(result_of_yielding_maps):
    """Compare with direct solutions at computed loads, and with finite differences at all loads."""
    result = result_of_yielding_maps
    steps = result.study.contact.loading_steps()
    contact = result.study.contact.solver_arguments()
    for index in (1, 2):
        loads = steps[index] * np.array([0.998, 1.002])
        closures = np.mean(
            [
                half_space(*read_measured_bodies(result.study).member(m, 0.0).pair, loads, **contact).closure
                for m in range(4)
            ],
            0,
        )
        expected_stiffness = 1e6 * np.diff(loads)[0] / result.nominal_area / np.diff(closures)[0]
        stiffness = get_means(result.at(steps[index]), "closure_stiffness")
        assert stiffness == pytest.approx(expected_stiffness, rel=0.01)
    loads = np.geomspace(1.001 * steps[0], 0.999 * steps[-1], 20)
    for load in loads:
        values = result.at(load * np.array([0.9995, 1.0, 1.0005]))
        closure = get_means(values, "closure")
        difference = 1e6 * 1e-3 * load / result.nominal_area / (closure[2] - closure[0])
        assert get_means(values, "closure_stiffness")[1] == pytest.approx(difference, rel=0.01)


def test_interpolated_stiffnesses_of_yielding_profiles_agree_with_direct_solutions():
    """Compare where half of the load is on yielded contacts, and where almost no contact yields."""
    result = pair(
        SAMPLE_SCANS / "lapped_upper.csv", SAMPLE_SCANS / "lapped_lower.csv", load="50 MPa",
        effective_modulus=78.7, hardness=1.27, mu0=0.2, mechanics="half-space", offsets=16, onset=0, cutoff="none",
    )  # fmt: skip
    loads = [result.nominal_area * pressure for pressure in (0.073, 0.28, 0.34, 0.41)]
    all_loads = sorted([*loads, *result.study.contact.loading_steps().tolist()])
    direct_result = run(result.study.with_changes({"contact.load": [f"{load} mN" for load in all_loads]}))
    interpolated_values, direct_values = (compared_result.at(loads) for compared_result in (result, direct_result))
    for name, tolerance in (
        ("closure", 0.005), ("closure_stiffness", 0.05), ("unloading_closure_stiffness", 0.05),
        ("tangential_stiffness_per_area", 0.05),
    ):  # fmt: skip
        np.testing.assert_allclose(
            get_means(interpolated_values, name), get_means(direct_values, name), rtol=tolerance, err_msg=name
        )


def test_tangential_stiffness_per_area_excludes_the_mean_tangential_displacement_of_the_half_space(
    result_of_yielding_maps,
):
    """Subtract the mean tangential displacement from that of distant points, as for the closure."""
    result = result_of_yielding_maps
    contact = result.study.contact
    for load in contact.loading_steps()[1:3]:
        compliances = []
        for member in range(4):
            curve = half_space(
                *read_measured_bodies(result.study).member(member, 0.0).pair, [load], **contact.solver_arguments()
            )
            onset = curve.onset(0, mu0=0.2, tau0=0.05, steps=[0.002], poisson=contact.poisson)
            ratio = curve.unloading_stiffness[0] / onset.stiffness
            bending = 1 / curve.unloading_stiffness[0] - 1 / (
                curve.unloading_closure_stiffness[0] * result.nominal_area
            )
            displacement = onset.displacement[0] - ratio * bending * onset.tangential_load[0]
            compliances.append(displacement / onset.tangential_load[0] * result.nominal_area)
        stiffness = get_means(result.at(load), "tangential_stiffness_per_area")
        assert stiffness == pytest.approx(1e6 / np.mean(compliances), rel=0.01)


def test_tangential_stiffness_agrees_with_closed_forms_for_grooves_and_spheres(
    areal_study_and_dataset, profile_study_and_dataset, tmp_path
):
    _, spheres = profile_study_and_dataset
    values = at_load(spheres, spheres["load"].values[3:5])
    ratio = get_means(values, "tangential_stiffness_per_area") / get_means(values, "unloading_closure_stiffness")
    np.testing.assert_allclose(ratio, 2 * (1 - 0.3) / (2 - 0.3), rtol=1e-9)
    study = create_study_from_files(tmp_path, "lines", spacing=write_profiles(tmp_path), members=4, load="0.05 mN")
    values = at_load(run(study), [0.05, 0.07])
    np.testing.assert_allclose(
        get_means(values, "tangential_stiffness_per_area"), get_means(values, "closure_stiffness"), rtol=1e-9
    )


def test_interval_for_generated_surfaces_is_computed_from_averages_over_directions():
    study = Study().with_changes({
        "ensemble.repetitions": 6, "surfaces.kind": "surface", "surfaces.shape": [24, 24], "contact.direction": [0, 90],
        "surfaces.extent": ["1.5 um", "1.5 um"], "surfaces.band_limit": "nyquist", "contact.approach.count": 5,
        "surfaces.fractal_dimension": [1.2, 1.5], "surfaces.amplitude": ["50 nm"],
    })  # fmt: skip
    result = run(study).dataset
    load = [float(choose_loads_in_range(result, 5)[2])]
    table, dataset_over_directions = at_load(result, load), result.mean("direction", keep_attrs=True)
    for name, quantity_map in (
        ("contact_area", area_map(dataset_over_directions, load)),
        ("normal_stiffness", stiffness_map(dataset_over_directions, load)),
    ):
        for statistic, variable in (("mean", name), ("lower", "lower"), ("upper", "upper")):
            np.testing.assert_allclose(table[name].sel(statistic=statistic), quantity_map[variable], rtol=ROUND_OFF)


def test_interval_for_measured_surfaces_is_computed_from_averages_over_directions(areal_study_and_dataset):
    _, result = areal_study_and_dataset
    values = member_values(result, [2.0], mu0=0.3)
    point = at_load(result, [2.0], mu0=0.3)
    friction = values["friction_coefficient"].isel(cut_off=0, load=0, mu0=0, tau0=0).sel(sliding="opposing")
    expected = intervals.average_independent_values(friction.mean("direction").values)
    computed_interval = point["mean_friction"].isel(cut_off=0, load=0, mu0=0, tau0=0).sel(sliding="opposing").values
    np.testing.assert_allclose(computed_interval, expected, rtol=ROUND_OFF)
    axis_means = friction.sel(direction=[60.0, 240.0]).mean("direction").values
    friction_along_axis = (
        point["friction_by_axis"].isel(cut_off=0, load=0, mu0=0, tau0=0).sel(sliding="opposing", axis=60.0)
    )
    np.testing.assert_allclose(friction_along_axis, intervals.average_independent_values(axis_means), rtol=ROUND_OFF)
    lower, upper = (
        float(point[name].isel(cut_off=0, load=0, mu0=0, tau0=0).sel(sliding="opposing"))
        for name in ("spread_low", "spread_high")
    )
    assert (lower, upper) == pytest.approx(tuple(np.quantile(friction.values, [0.1, 0.9])))


def test_mean_along_an_axis_requires_results_in_two_opposite_directions():
    axes, indices = find_axes_with_both_directions(np.array([30.0, 0.0, 210.0, 90.0, 180.0]))
    assert axes.tolist() == [0.0, 30.0]
    assert indices.tolist() == [[1, 4], [0, 2]]
    assert find_axes_with_both_directions(np.array([0.0, 45.0]))[0].size == 0


def test_load_that_no_pair_reaches_has_the_status_not_reached(areal_study_and_dataset, profile_study_and_dataset):
    for _, result in (areal_study_and_dataset, profile_study_and_dataset):
        highest_load = float(result["load"][-1])
        table = at_load(result, [2 * highest_load])
        assert np.isnan(table["friction_coefficient"]).all()
        assert set(np.unique(table["status"])) <= {"not-reached", "not-solved"}
        assert int(table["ok"].max()) == 0


def test_pair_without_a_solution_at_a_load_is_omitted_from_the_mean(areal_study_and_dataset):
    _, result = areal_study_and_dataset
    incomplete_result = result.copy(deep=True)
    incomplete_result["normal_elastic"].values[0, 1] = np.nan
    incomplete_result["status"].values[0, 1] = 5
    table = at_load(incomplete_result, [2.0])
    assert int(table["ok"].max()) == 4
    assert np.isfinite(table["mean_friction"]).all()
    assert member_values(incomplete_result, [2.0])["status"].isel(repetition=1).values.ravel()[0] == "not-solved"


@pytest.mark.parametrize("load_definition", ["elastic", "normal"])
def test_unsolved_load_has_the_status_not_solved_and_no_interpolated_value(areal_study_and_dataset, load_definition):
    _, result = areal_study_and_dataset
    step = 1
    incomplete_result = result.copy(deep=True)
    incomplete_result["status"].values[0, 0, step] = STATUSES.index("not-solved")
    for values in incomplete_result.data_vars.values():
        if values.dtype.kind == "f" and "load" in values.dims:
            values.loc[{"repetition": 0, "load": values["load"][step]}] = np.nan
    loads = incomplete_result["load"].values[step] * np.array([0.9, 1.0])
    status = member_values(incomplete_result, loads, load_definition=load_definition)["status"].transpose(
        "repetition", ...
    )
    assert (status[0] == "not-solved").all()
    assert (status[1:] == "ok").all()
    area_of_incomplete, area_of_complete = (
        member_values(item, result["load"].values[2:3])["contact_area"] for item in (incomplete_result, result)
    )
    np.testing.assert_array_equal(area_of_incomplete, area_of_complete)


def test_load_between_distant_load_steps_has_the_status_not_reached():
    curve, values = np.array([1e-3, 1.0, 10.0]), np.array([2e-3, 1.5, 12.0])
    crossing = intervals.LoadCrossings.from_curves(curve, np.array([1e-3, 0.1, 1.0, 3.0]), interpolates_ratio=True)
    assert crossing.reached.tolist() == [True, False, True, True]
    assert np.isnan(crossing.interpolate(values)).tolist() == [False, True, False, False]


def test_load_steps_are_inserted_between_given_loads_that_are_far_apart():
    loads = choose_load_steps([1e-3, 2e-3, 2.0], press="areas", mechanics="half-space")
    assert {1e-3, 2e-3, 2.0} <= set(loads.tolist())
    assert (loads[1:] / loads[:-1]).max() < 1.02 * MAX_AREAL_LOAD_RATIO
    close_loads = choose_load_steps([1.0, 3.0], press="areas", mechanics="half-space")
    assert close_loads.size == 4


def test_evaluation_at_a_load_rejects_invalid_input(areal_study_and_dataset):
    _, result = areal_study_and_dataset
    for changes, pattern in (
        ({"loads": [0.0]}, "loads must be above 0"), ({"mu0": -1.0}, "mu0 must not be negative"),
        ({"load_definition": "median"}, "load_definition must be one of"),
        ({"member_kind": "surrogates"}, "member_kind must be .shifts."),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=pattern):
            at_load(result, **({"loads": [2.0]} | changes))


INTERPOLATED_QUANTITIES = ("contact_area", "contact_count", "stiffness_per_area", "closure", "mean_friction")
MAX_INTERVAL_WIDTH_RATIO = 2.2
MIN_COVERAGE = 0.93


def compute_interpolation_errors(seed, *, points, longest_wavelength, shifts, hardness):
    """Return quantity, error between two loads, estimated error, and half width of the interval without this error.

    All numbers are logarithms. The estimated error is the part of the interval that is not due to the limited number of
    members.
    """
    bodies = [
        self_affine_surface(
            seed, side=side, hurst_exponent=0.8, rms=0.02, shape=(points, points), spacing=0.1, shortest_wavelength=0.4,
            longest_wavelength=longest_wavelength,
        )
        for side in ("upper", "lower")
    ]  # fmt: skip
    options = {
        "effective_modulus": 80.0, "onset": 0, "cutoff": "none", "mu0": 0.2, "tau0": 0.05, "shifts": shifts,
        "direction": [0, 180], "hardness": hardness,
    }  # fmt: skip
    result = pair(*bodies, load=["10 MPa", "30 MPa"], **options)
    loads = ["13 MPa", "17 MPa", "22 MPa"]
    interpolated_values = result.at(loads)
    solved_values = pair(*bodies, load=["10 MPa", *loads, "30 MPa"], **options).at(loads)
    members = member_values(result, interpolated_values["load"].values)
    members["mean_friction"] = members["friction_coefficient"].mean("direction")
    rows = []
    for name in INTERPOLATED_QUANTITIES:
        dims = [dim for dim in interpolated_values[name].dims if dim != "statistic"]
        # Compare compliances, because the mean of a stiffness is the inverse of the mean compliance.
        sign = -1 if "stiffness" in name else 1
        values = members[name].transpose("repetition", *dims).values ** sign
        mean, *limits = sign * np.log(intervals.average_independent_values(values))
        upper = np.maximum(*limits)
        estimate = np.log(interpolated_values[name].transpose(*dims, "statistic").values)
        np.testing.assert_allclose(estimate[..., 0], mean)
        interpolation_error = np.sqrt(np.maximum((estimate[..., 2] - mean) ** 2 - (upper - mean) ** 2, 0))
        difference = np.log(solved_values[name].sel(statistic="mean").transpose(*dims).values) - mean
        numbers = (difference, interpolation_error, upper - mean)
        rows += list(zip([name] * mean.size, *(array.ravel().tolist() for array in numbers), strict=True))
    return rows


def test_interval_between_computed_loads_contains_the_direct_solution_if_contacts_are_few():
    rows = [
        row
        for seed in range(6)
        for row in compute_interpolation_errors(
            seed, points=32, longest_wavelength=3.2, shifts=3 + seed % 3, hardness=None if seed % 2 else 2.0
        )
    ]
    difference, interpolation_error = (np.array([row[index] for row in rows]) for index in (1, 2))
    assert np.abs(difference).max() > 0.1
    assert np.mean(np.abs(difference) <= interpolation_error) > MIN_COVERAGE


def test_interval_between_computed_loads_is_narrow_if_contacts_are_many():
    rows = compute_interpolation_errors(3, points=128, longest_wavelength=0.8, shifts=8, hardness=None)
    widening = np.array(
        [np.hypot(1, interpolation_error / half_width) for _, _, interpolation_error, half_width in rows]
    )
    assert widening.max() < MAX_INTERVAL_WIDTH_RATIO
    friction_errors = [interpolation_error for name, _, interpolation_error, _ in rows if name == "mean_friction"]
    assert min(friction_errors) < 0.01
    assert max(friction_errors) < 0.05


def test_value_at_a_computed_load_does_not_depend_on_interpolated_loads(areal_study_and_dataset):
    study, result = areal_study_and_dataset
    load = study.contact.loading_steps()[:1]
    table_of_both_loads = at_load(result, [*load, 1.2 * load[0]]).isel(load=[0])
    assert table_of_both_loads.drop_attrs().equals(at_load(result, load).drop_attrs())


def test_upper_limit_of_the_interval_of_a_fraction_is_at_most_one(areal_study_and_dataset):
    _, dataset = areal_study_and_dataset
    changed_dataset = dataset.copy(deep=True)
    name = "share_on_largest"
    changed_dataset[name] = changed_dataset[name] * 0 + xarray.DataArray([1.0, 1.0, 0.7, 1.0, 0.9], dims="repetition")
    mean, lower, upper = at_load(changed_dataset, [2.0], names=[name])[name].values.ravel()
    assert mean == pytest.approx(0.92)
    assert lower < mean < upper == 1.0


def test_interval_of_the_true_area_does_not_exceed_the_nominal_area():
    upper, lower = (
        self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(32, 32), spacing=0.1, side=side)
        for side in ("upper", "lower")
    )
    result = pair(upper, lower, load="4 MPa", effective_modulus="40 MPa +- 50 %", mu0=0.2, shifts=3, onset=0)
    area, fraction = (result.at()[name].squeeze().values for name in ("contact_area", "contact_area_fraction"))
    assert fraction[0] < fraction[2] == 1
    np.testing.assert_allclose(area, fraction * result.nominal_area, rtol=1e-12)


def test_uncertainty_budget_is_computed_only_for_the_quoted_sliding_rule(areal_study_and_dataset):
    _, dataset = areal_study_and_dataset
    table = add_uncertainty(at_load(dataset, [2.0]), dataset)
    assert np.isfinite(table["remaining_width"].sel(sliding="all", input="positions")).all()
    assert np.isnan(table["remaining_width"].sel(sliding="opposing")).all()


def test_evaluation_at_a_load_computes_every_quantity_shown_in_outputs():
    maps = rough_maps(5, hurst_exponent=0.7, rms=0.01, points=32, spacing=0.1, shortest_wavelength=0.4)
    options = {"load": "20 MPa", "mu0": 0.2, "effective_modulus": "80 GPa", "shifts": 2, "cutoff": "none", "onset": 0}
    adhesion = {"work_of_adhesion": "50 mJ/m^2", "adhesion_range": "5 nm"}
    evaluated_names = set(ONSET_QUANTITIES)
    for added_options in ({"hardness": 1.0, "indent": "2 um"}, {"mechanics": "asperities"}, adhesion):
        evaluated_names |= set(pair(*maps, **options, **added_options, direction=[0.0, 180.0]).at().data_vars)
    assert set(select_quantity_names(lambda quantity: quantity.shown)) - evaluated_names == set()


def test_number_of_uncertainty_budgets_is_limited_for_all_study_loads_together_and_for_each_further_load(
    areal_study_and_dataset, monkeypatch
):
    study, dataset = areal_study_and_dataset
    other_load, *study_loads = study.contact.loading_steps()[:3].tolist()
    changes = {"friction.load": [f"{load!r} mN" for load in study_loads]}
    sums = MemberSums.of(dataset).with_study(study.with_changes(changes))
    table = at_load(sums, [other_load, *study_loads])
    monkeypatch.setattr(budget, "MAX_BUDGETED_COEFFICIENTS", table["mean_friction"].size // 3 // 3)
    widths = add_uncertainty(table, sums)["remaining_width"].sel(sliding="all", input="positions")
    assert np.isfinite(widths).all(["cut_off", "mu0", "tau0"]).values.tolist() == [True, False, False]


def test_interpolation_error_midway_between_loads_equals_its_closed_form():
    """In the middle between two points, the error is sqrt(3/4) of the half width of the changes."""
    values_below = np.array([1.0, -1.0, 2.0, -2.0])
    means = include_interpolation_error(
        np.zeros(3),
        np.zeros(4),
        values_below,
        -values_below,
        np.asarray(0.5),
        lambda values: np.array([0.0, -1.0, 1.0]),
    )
    assert means == pytest.approx([0.0, -(0.75**0.5), 0.75**0.5])


def test_at_method_accepts_the_strings_that_the_at_command_accepts(areal_study_and_dataset):
    result = Result.of(areal_study_and_dataset[1])
    loads = result.study.contact.loading_steps()[[1, 2]]
    load_texts = [f"{load!r} mN" for load in loads.tolist()]
    expected = result.at(loads, mu0=[0.3, 0.4], tau0=[0.01, 0.05], quantities=[])
    for load, mu0, tau0 in (
        (load_texts, ["0.3", "0.4"], ["10 MPa", "50 MPa"]),
        (",".join(load_texts), "0.3,0.4", "10 MPa,50 MPa"),
        ([", ".join(load_texts)], "0.3, 0.4", ["10 MPa", 0.05]),
    ):
        xarray.testing.assert_identical(result.at(load, mu0=mu0, tau0=tau0, quantities=[]), expected)
    single = result.at(load_texts[0], mu0="0.3", tau0="50 MPa", quantities=[])
    xarray.testing.assert_identical(single, result.at(loads[0], mu0=0.3, tau0=0.05, quantities=[]))
    for arguments, message in (
        ({"mu0": "rough"}, "mu0 must be one or more numbers, as in"),
        ({"mu0": "0,2"}, "mu0 must not have a comma between digits, got '0,2'"),
        ({"mu0": "-0.2"}, "mu0 must be at least 0, got '-0.2'"),
        ({"tau0": "10 MPa,5 um"}, "tau0 has the unit 'um', which is not a unit of pressure"),
        ({"load": "10 mN,5 um"}, "load must be a force or a pressure with its unit"),
        ({"load": "0,2 mN"}, "load must not have a comma between digits, got '0,2 mN'"),
    ):
        with pytest.raises(ValueError, match=message):
            result.at(**arguments)


def test_at_method_suggests_the_nearest_name_of_an_unknown_quantity(areal_study_and_dataset):
    result = Result.of(areal_study_and_dataset[1])
    assert "contact_area" in list(result.at())
    with pytest.raises(ValueError, match=r"list\(result.at\(\)\), got 'contactarea'; did you mean 'contact_area'\?"):
        result.at(quantities=["contactarea"])
