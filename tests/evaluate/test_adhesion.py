"""Test pairs and studies with adhesion: stored values, text, figures, caveats and rejected input."""

import json
import re

import numpy as np
import pytest
from stiction import Study, half_space, pair, run, self_affine_surface
from stiction._estimate import Estimate
from stiction.companions.contact_picture import compute_loading_cycle
from stiction.evaluate.at_load import at_load
from stiction.evaluate.computed_loads import (
    find_computed_load_range,
    find_loads_outside_range,
    find_loads_without_values,
)
from stiction.evaluate.point import is_unloaded, iterate_points
from stiction.evaluate.pull_off import PullOffValues
from stiction.mechanics.quantities import LOAD_INDEPENDENT_QUANTITIES
from stiction.study.members import read_measured_bodies
from stiction.summary.assessment import (
    MAX_NEGLECTED_ADHESION_FRACTION,
    TYPICAL_WORK_OF_ADHESION,
    estimate_adhesion_load_ratio,
)
from stiction.views.pull_off import pull_off_text
from stiction.views.rows import summary_json, summary_table
from stiction.views.spreadsheet import frame_to_csv
from stiction.views.text import main_values_text, result_text
from support.rough_surfaces import rough_maps

pytestmark = pytest.mark.usefixtures("no_companion_files")

REPEATED_SOLUTION_TOLERANCE = 1e-9
"""Relative tolerance between two solutions of one contact that start from different initial pressures."""

LOAD_PATH_TOLERANCE = 1e-3
"""Relative tolerance between two solutions at one load, which start from solutions at different loads."""

MAX_RATIO_OF_ESTIMATED_INCREASE = 2.0
"""Maximum ratio of the estimated to the computed increase of the load by adhesion, near the limit of 5 %."""

PAIR_OPTIONS = {
    "load": ["2 MPa", "20 MPa"],
    "mu0": 0.3,
    "tau0": "20 MPa",
    "effective_modulus": 80.0,
    "shifts": 3,
    "onset": 0,
}
ADHESION_OPTIONS = {"work_of_adhesion": "50 mJ/m^2"}


def rough_surface(side, rms=0.003, points=40):
    return self_affine_surface(
        3, hurst_exponent=0.8, rms=rms, shape=(points, points), spacing=0.01, longest_wavelength=0.2,
        shortest_wavelength=0.04, side=side,
    )  # fmt: skip


def run_pair(**changes):
    return pair(rough_surface("upper"), rough_surface("lower"), **PAIR_OPTIONS | changes)


@pytest.fixture(scope="module")
def adhesive_result():
    return run_pair(**ADHESION_OPTIONS)


def test_contact_sums_of_an_adhesive_pair_equal_sums_of_its_half_space_load_curve(adhesive_result):
    dataset, contact = adhesive_result.dataset.isel(cut_off=0, repetition=1), adhesive_result.study.contact
    bodies = read_measured_bodies(adhesive_result.study).member(1, 0.0).pair
    directions = {"direction": dataset["direction"].values.tolist(), "sliding": "all"}
    curve = half_space(*bodies, dataset["load"].values, **contact.solver_arguments(), **directions)
    free_curve = half_space(*bodies, [0.0], **contact.solver_arguments(), **directions)
    assert dataset["contact_load"].values == pytest.approx(curve.contact_load, rel=REPEATED_SOLUTION_TOLERANCE)
    assert float(dataset["pull_off"]) == pytest.approx(free_curve.pull_off, rel=LOAD_PATH_TOLERANCE)
    assert float(dataset["pull_off"]) > 0
    stored_loads = {
        name: dataset[f"unloaded_{name}"].sel(sliding="all").values for name in ("elastic", "frictional", "adhesive")
    }
    friction = stored_loads["elastic"] + 0.3 * stored_loads["frictional"] + 0.02 * stored_loads["adhesive"]
    assert friction == pytest.approx(
        free_curve.tangential_load(mu0=0.3, tau0=0.02)[:, 0], rel=REPEATED_SOLUTION_TOLERANCE
    )
    assert friction.mean() == pytest.approx(
        0.3 * free_curve.contact_load[0] + 0.02 * free_curve.contact_area[0], rel=0.05
    )


def test_friction_coefficient_with_adhesion_increases_as_the_load_decreases(adhesive_result):
    table = at_load(adhesive_result.source, adhesive_result.study.contact.loading_steps()).isel(
        cut_off=0, mu0=0, tau0=0
    )
    coefficient = table["mean_friction"].sel(sliding="all", statistic="mean").values
    assert (np.diff(coefficient) < 0).all()
    assert coefficient[0] > 3 * coefficient[-1]
    contact_load, area = (table[name].sel(statistic="mean").values for name in ("contact_load", "contact_area"))
    # The formula omits friction on slopes, which increases the contact load at the smallest load.
    assert (coefficient * table["load"].values)[1:] == pytest.approx((0.3 * contact_load + 0.02 * area)[1:], rel=0.03)
    assert table["mean_pressure"].sel(statistic="mean").values == pytest.approx(contact_load / area, rel=0.2)


def test_pull_off_force_is_shown_in_table_and_text_and_report_and_figure(adhesive_result, tmp_path):
    text = repr(adhesive_result)
    assert text.startswith("Sticks without a load: yes. Pull-off force ")
    for quantity_title in ("pull-off force", "pull-off pressure", "friction at no load", "contact load"):
        assert quantity_title in frame_to_csv(summary_table(adhesive_result.summary())).splitlines()[0]
    values = json.loads(summary_json("pair", adhesive_result.summary()))["values"]
    assert {value["unit"] for value in values if value["name"] in LOAD_INDEPENDENT_QUANTITIES} == {"mN", "GPa"}
    assert "adhesion 50 mJ/m² over 0.5 nm" in adhesive_result.sentence
    (friction_at_no_load,) = {
        value["value"] for value in values
        if value["name"] == "friction_at_no_load" and value["at"]["sliding"] == "all"
    }  # fmt: skip
    pull_off = next(value["value"] for value in values if value["name"] == "pull_off")
    assert friction_at_no_load > 0.3 * pull_off * 0.5
    page = adhesive_result.save_report(tmp_path / "page.html").read_text()
    assert "Loading and unloading" in page
    assert "friction at no load" in page
    loading_cycle = compute_loading_cycle(adhesive_result.source)
    unloading = loading_cycle.isel(point=loading_cycle["going"].values)
    assert float(loading_cycle["load"].min()) < 0 < float(loading_cycle["load"].max())
    assert float(unloading["load"][-1]) == float(loading_cycle["load"].min())
    assert (np.diff(unloading["contact_load"]) <= 0).all()
    assert len(adhesive_result.figure("adhesion").axes) == 2


def test_interval_of_friction_at_zero_load_agrees_with_percentiles_of_independent_samples(adhesive_result):
    """The friction at no load is linear in μ0 and τ0. The positions add a relative error to it."""
    result = run_pair(**ADHESION_OPTIONS, mu0="0.2..0.4", tau0="10..40 MPa")
    values = result.at()["friction_at_no_load"].isel(cut_off=0).squeeze(drop=True)
    exact_intervals = adhesive_result.at()["friction_at_no_load"].isel(cut_off=0).squeeze(drop=True)
    generator = np.random.default_rng(11)
    mu0 = generator.normal(0.3, 0.1 / 1.96, 200_000)
    tau0 = 0.02 * np.exp(generator.normal(0.0, np.log(2) / 1.96, mu0.size))
    for rule in ("all", "opposing"):
        elastic, frictional, adhesive_load = (
            float(result.dataset[f"unloaded_{name}"].sel(sliding=rule).mean())
            for name in ("elastic", "frictional", "adhesive")
        )
        _, lower, upper = exact_intervals.sel(sliding=rule).values
        errors = generator.normal(0.0, np.log(upper / lower) / (2 * 1.96), mu0.size)
        samples = (elastic + mu0 * frictional + tau0 * adhesive_load) * np.exp(errors)
        interval = values.sel(sliding=rule).values[1:]
        assert interval == pytest.approx(np.quantile(samples, [0.025, 0.975]), abs=0.03 * np.ptp(interval))


def test_adhesive_friction_at_zero_load_is_zero_if_mu0_and_tau0_are_zero():
    result = run_pair(**ADHESION_OPTIONS | {"mu0": 0, "tau0": 0, "effective_modulus": "60..100 GPa", "load": "2 MPa"})
    friction = result.at()["friction_at_no_load"].sel(sliding="all").values
    assert (friction == 0).all()
    assert "friction at no load 0 mN" in " ".join(repr(result).split())


def test_result_text_states_that_an_uncertain_modulus_does_not_change_the_attraction(adhesive_result):
    uncertain_result = run_pair(**ADHESION_OPTIONS | {"effective_modulus": "60..100 GPa", "load": "2 MPa"})
    note = "; its interval includes the effect of E* on the area, not on the attraction."
    for result, has_note in ((uncertain_result, True), (adhesive_result, False)):
        assert (note in " ".join(repr(result).split())) == has_note


def test_roughness_contribution_is_undefined_for_adhesive_pairs(adhesive_result):
    """The attraction, which depends on the roughness, raises the contribution of mu0 above mu0."""
    for point in adhesive_result.summary().points:
        assert point.contributions[0] > 1.02 * point.at["mu0"]
        assert point.roughness_contribution is None


def test_result_text_at_zero_load_states_whether_the_surfaces_adhere(adhesive_result):
    unloaded_result, two_load_result = (run_pair(load=load, **ADHESION_OPTIONS) for load in (0, ["0", "20 MPa"]))
    (unloaded_point,) = unloaded_result.summary().points
    assert unloaded_point.is_unloaded
    assert "at no load" in unloaded_result.sentence
    assert unloaded_point.pull_off.sticking_assessment == "yes"
    force, loaded_force = unloaded_point.pull_off.force, adhesive_result.summary().points[0].pull_off.force
    assert [force.value, *force.interval] == pytest.approx(
        [loaded_force.value, *loaded_force.interval], rel=LOAD_PATH_TOLERANCE
    )
    assert unloaded_result.dataset["load"].values.max() < 0.01 * float(unloaded_result.dataset["pull_off"].mean())
    assert [point.is_unloaded for point in two_load_result.summary().points] == [True, False]
    assert two_load_result.summary().points[1].value == pytest.approx(
        adhesive_result.summary().points[1].value, rel=LOAD_PATH_TOLERANCE
    )
    record = json.loads(summary_json("pair", unloaded_result.summary()))["points"][0]
    assert record["pull_off"]["sticks"] == "yes"
    assert record["pull_off"]["force"]["lower"] < record["pull_off"]["force"]["value"]
    assert record["assessment"] == "Do not quote"
    assert pull_off_text(unloaded_point.pull_off).removesuffix(".") in unloaded_result.sentence
    assert pull_off_text(unloaded_point.pull_off, "μ0 = 0.3").endswith(" with μ0 = 0.3.")
    text_of_two_mu0 = main_values_text(unloaded_result.summary(0, mu0=[0.2, 0.3]))
    assert "with μ0 = 0.2." in " ".join(text_of_two_mu0.split())
    with pytest.raises(ValueError, match="load must be above 0, got 0"):
        run_pair(load=0)
    for result, has_area in ((unloaded_result, True), (two_load_result, True), (adhesive_result, False)):
        table = at_load(result.source, [0.0]).isel(cut_off=0)
        assert np.isfinite(table["contact_area"].sel(statistic="mean")).all() == has_area
        assert table["pull_off"].sel(statistic="mean").values == pytest.approx(
            unloaded_point.pull_off.force.value, rel=0.01
        )
        assert is_unloaded(table.isel(load=0))
    with pytest.raises(ValueError, match="loads must be above 0"):
        at_load(run_pair().source, [0.0])


def test_zero_load_of_an_adhesive_pair_is_not_reported_as_outside_the_computed_loads(adhesive_result):
    values = adhesive_result.at([0.0, 1e3])
    negligible_load = float(values["load"][0])
    assert negligible_load < find_computed_load_range(adhesive_result)[0]
    assert find_loads_outside_range(adhesive_result, values) == [1e3]
    assert find_loads_without_values(adhesive_result, values) == [1e3]
    text = result_text(adhesive_result.summarize_dataset(values.sel(load=[negligible_load])))
    assert "Pull-off force" in text
    assert text.splitlines()[-1] != "."


def test_verbose_text_of_loads_of_zero_and_above_contains_only_finite_coefficients_along_the_axes():
    two_load_result = run_pair(load=["0", "20 MPa"], **ADHESION_OPTIONS)
    text = result_text(two_load_result.summary(), verbose=True)
    axis_lines = [line for line in text.splitlines() if line.startswith("along ")]
    coefficients = [float(line.split()[2]) for line in axis_lines]
    assert coefficients
    assert max(coefficients) < 5
    assert "nan" not in text


def test_loads_between_zero_and_the_lowest_solved_load_have_the_status_not_reached(adhesive_result):
    two_load_result = run_pair(load=["0", "20 MPa"], **ADHESION_OPTIONS)
    loads = two_load_result.study.contact.loading_steps()
    table = at_load(two_load_result.source, np.sqrt(loads[1:] * loads[:-1])).isel(cut_off=0, mu0=0, tau0=0)
    assert set(np.unique(table["status"].isel(load=0))) == {"not-reached"}
    assert np.isnan(table["contact_area"].isel(load=0)).all()
    area = table["contact_area"].sel(statistic="mean").values[1:]
    solved_area = (
        at_load(two_load_result.source, loads[1:])["contact_area"].sel(statistic="mean").isel(cut_off=0).values
    )
    assert (solved_area[:-1] <= area).all()
    assert (area <= 1.25 * solved_area[1:]).all()


@pytest.mark.parametrize(
    ("pressure", "is_bound", "sticks"),
    [
        ((2e-7, 1.5e-7, 2.5e-7), False, "yes"),
        ((2e-7, 0.5e-7, 3.5e-7), False, "uncertain"),
        ((2e-8, 1e-8, 3e-8), False, "no"),
        ((2e-8, 1e-8, 3e-8), True, "uncertain"),
        ((2e-8, np.nan, np.nan), False, "no"),
    ],
)
def test_assessment_of_whether_bodies_adhere_follows_from_the_interval_of_the_pull_off_pressure(
    pressure, is_bound, sticks
):
    pull_off_values = PullOffValues(
        force=Estimate(1e-6), pressure=Estimate(*pressure), friction=Estimate(1e-6), is_bound=is_bound
    )
    assert pull_off_values.sticking_assessment == sticks


def test_zero_work_of_adhesion_leaves_values_unchanged_and_adds_no_caveat(adhesive_result):
    caveat_text = "would increase"
    default_result, zero_adhesion_result = run_pair(), run_pair(work_of_adhesion="0 mJ/m^2")
    for name in default_result.dataset.data_vars:
        assert (default_result.dataset[name].values == zero_adhesion_result.dataset[name].values).all() or name in (
            "patch_area",
            "pressure",
        )
    assert set(adhesive_result.dataset.data_vars) - set(zero_adhesion_result.dataset.data_vars) == {
        "contact_load", "pull_off", "pull_off_is_bound", "unloaded_elastic", "unloaded_frictional", "unloaded_adhesive",
    }  # fmt: skip
    has_caveat = [
        any(caveat_text in caveat.text for caveat in result.caveats)
        for result in (default_result, zero_adhesion_result, adhesive_result)
    ]
    assert has_caveat == [True, False, False]
    # The pull-off force counts as a lower bound only if it exceeds the load at which it was found.
    (text,) = (caveat.text for caveat in default_result.caveats if caveat_text in caveat.text)
    assert re.search(r"by (about [\d.]+|more than 100) %$", text)
    steep_result = pair(rough_surface("upper", 0.03), rough_surface("lower", 0.03), **PAIR_OPTIONS | {"load": "20 MPa"})
    assert not any(caveat_text in caveat.text for caveat in steep_result.caveats)
    assert "adhesion" not in repr(zero_adhesion_result)


@pytest.mark.parametrize("surfaces", ["surface", "profile"])
def test_study_of_generated_surfaces_accepts_adhesion(surfaces):
    study = Study().with_changes({"surfaces.kind": surfaces, "contact.mechanics": "half-space"})
    changes = {
        "contact.work_of_adhesion": "50 mJ/m^2", "contact.boundary": "periodic", "contact.effective_modulus": "80 GPa",
        "surfaces.fractal_dimension": [1.2], "surfaces.amplitude": ["0.01 um"], "ensemble.repetitions": 3,
        "friction.mu0": [0.3], "friction.tau0": ["0 MPa"], "contact.sliding": ["all", "opposing"],
    }  # fmt: skip
    changes |= (
        {"surfaces.generator": "self-affine", "surfaces.extent": ["0.4 um", "0.4 um"], "surfaces.shape": [32, 32]}
        if surfaces == "surface" else {"surfaces.points": 1000, "surfaces.extent": "4 um"}
    )  # fmt: skip
    study = study.with_changes(changes)
    result = run(study.with_changes({"contact.load": ["0.003 mN", "0.01 mN", "0.03 mN"]})).dataset
    point = at_load(result, [0.01]).sel(sliding="all").squeeze()
    contact_load = float(point["contact_load"].sel(statistic="mean"))
    assert contact_load > 0.01
    coefficient = float(point["friction_coefficient"].sel(statistic="mean"))
    assert coefficient == pytest.approx(0.3 * contact_load / 0.01, rel=0.05)
    assert float(point["pull_off"].sel(statistic="mean")) == pytest.approx(result["pull_off"].mean())
    assert float(point["friction_at_no_load"].sel(statistic="mean")) > 0


@pytest.mark.parametrize(
    ("changes", "pattern"),
    [
        (
            {"work_of_adhesion": "50±10 mJ/m^2"},
            "work_of_adhesion must be one value, got .*; compute both limits of a range",
        ),
        ({"work_of_adhesion": "-1 mJ/m^2"}, "work_of_adhesion must be at least 0"),
        ({"adhesion_range": "1 nm"}, "adhesion_range is for work_of_adhesion"),
        (ADHESION_OPTIONS | {"mechanics": "asperities"}, "work_of_adhesion is for mechanics half-space alone"),
        (
            ADHESION_OPTIONS | {"hardness": "90 MPa"},
            "hardness must be above work_of_adhesion / adhesion_range = 0.1 GPa",
        ),
    ],
)
def test_pair_function_rejects_invalid_adhesion_options(changes, pattern):
    with pytest.raises(ValueError, match=pattern):
        run_pair(**changes)


def test_adhesion_range_that_the_grid_does_not_resolve_adds_a_caveat():
    options = PAIR_OPTIONS | {"effective_modulus": "1.5..2.5 GPa", "load": "2 MPa"}
    with pytest.warns(UserWarning, match="adhesion_range = 0.5 nm is increased to"):
        result = pair(rough_surface("upper", 0.01), rough_surface("lower", 0.01), **options, **ADHESION_OPTIONS)
    caveats = " ".join(caveat.text for caveat in result.caveats)
    assert "instead of 0.5 nm, because this grid" in caveats
    assert "the interval does not include the effect of E* on the attraction" in caveats


@pytest.mark.soak
@pytest.mark.filterwarnings("ignore:adhesion_range")
def test_estimated_effect_of_adhesion_agrees_with_adhesive_solutions():
    """Compare estimated and solved effects of adhesion of 60 random pairs near the limit of a caveat."""
    random, misjudged_increases, roughness = (
        np.random.default_rng(7),
        [],
        {"hurst_exponent": 0.8, "rms": 1.0, "shape": (64, 64)},
    )
    for _ in range(60):
        spacing, modulus = 10 ** random.uniform(-2.5, 0), 10 ** random.uniform(-1, 2.3)
        length = max(5e-4, np.sqrt(2 * spacing * TYPICAL_WORK_OF_ADHESION / modulus))
        slope = TYPICAL_WORK_OF_ADHESION / (length * modulus * 10 ** random.uniform(-2.5, -1.3))
        if not 0.003 < slope < 1:
            continue
        wavelengths = {"longest_wavelength": 32 * spacing, "shortest_wavelength": 4 * spacing}
        seed = int(random.integers(1e6))
        bodies = rough_maps(seed, spacing=spacing, **roughness, **wavelengths)
        rms_steps = [np.sqrt(sum((np.diff(body.heights, axis=a) ** 2).mean() for a in (0, 1))) for body in bodies]
        bodies = [
            body.with_amplitude(slope * spacing / np.sqrt(2) / rms_step, measure="Sq")
            for body, rms_step in zip(bodies, rms_steps, strict=True)
        ]
        load = f"{0.01 * modulus * slope * 1e3:.4g} MPa"
        options = {"load": load, "mu0": 0.3, "effective_modulus": modulus, "shifts": 1, "onset": 0, "direction": [0]}
        plain_result, result = pair(*bodies, **options), pair(*bodies, **options, **ADHESION_OPTIONS)
        point = next(iterate_points(plain_result.at_study_loads))
        estimated_increase = estimate_adhesion_load_ratio(point, plain_result.study)
        dataset = result.dataset.sel(load=float(result.study.friction.load[0]))
        solved_increase = float(dataset["contact_load"].squeeze() / dataset["load"]) - 1
        if (estimated_increase > MAX_NEGLECTED_ADHESION_FRACTION) != (
            solved_increase > MAX_NEGLECTED_ADHESION_FRACTION
        ):
            misjudged_increases.append(solved_increase)
    assert len(misjudged_increases) <= 4
    assert all(
        MAX_NEGLECTED_ADHESION_FRACTION / MAX_RATIO_OF_ESTIMATED_INCREASE
        < increase
        < MAX_NEGLECTED_ADHESION_FRACTION * MAX_RATIO_OF_ESTIMATED_INCREASE
        for increase in misjudged_increases
    )


@pytest.mark.filterwarnings("ignore:the pull-off force is at least")
def test_text_and_table_and_json_output_report_complete_contact(tmp_path):
    soft_result = run_pair(
        effective_modulus="2 MPa", load="1 MPa", tau0="0.1 MPa", adhesion_range="25 nm", **ADHESION_OPTIONS
    )
    fraction = soft_result.at_study_loads["contact_area_fraction"]
    assert float(fraction.max()) == 1
    assert soft_result.summary().points[0].contact_status == "complete"
    record = json.loads(summary_json("pair", soft_result.summary()))
    assert record["points"][0]["contact_status"] == "complete"
    (row,) = (item for item in record["values"] if item["name"] == "contact_area_fraction")
    assert (row["status"], row["value"]) == ("complete", 1.0)
    assert "rue area A/A0 complete" in " ".join(repr(soft_result).split())
    assert soft_result.to_dataframe()["contact status"].unique().tolist() == ["complete"]
    assert not any(
        "101 %" in text for text in (repr(soft_result), soft_result.save_report(tmp_path / "page.html").read_text())
    )


def test_stiffness_interval_at_an_interpolated_load_contains_the_adhesive_solution_at_this_load():
    """Check the interpolation of the stiffness of adhesive contacts, which is not proportional to the load."""
    loads = ["2 MPa", "6 MPa"]
    result = run_pair(load=loads, **ADHESION_OPTIONS)
    stiffness = result.at(["2 MPa", "3.5 MPa", "6 MPa"])["normal_stiffness"].squeeze(drop=True)
    at_2_mpa, interpolated_stiffness, at_6_mpa = stiffness.sel(statistic="mean").values
    lower, upper = stiffness.isel(load=1).sel(statistic=["lower", "upper"]).values
    direct_result = run_pair(load="3.5 MPa", **ADHESION_OPTIONS).at()["normal_stiffness"].sel(statistic="mean").item()
    assert at_2_mpa < interpolated_stiffness < at_6_mpa
    assert lower <= direct_result <= upper
