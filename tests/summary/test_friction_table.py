"""Test friction tables: values against direct solutions, monotonic quantities, fitted laws and the command."""

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pandas
import pytest
import xarray
from stiction import Result, half_space, interface, material, open_result, pair_of, run, write_interface
from stiction.solve.store import export
from stiction.summary.friction_table import friction_table, table_study
from stiction.views.friction_table import friction_table_csv, friction_table_text
from stiction.views.joint import joint_frame
from support.command import assert_rejected, call_stiction, check_stiction
from support.studies_of_files import write_profiles

TABLE_OPTIONS = {
    "hurst_exponents": [0.6, 0.8], "rms": [0.01, 0.03], "pressures": [0.003, 0.01, 0.03, 0.1], "points": 48,
    "shortest_wavelength": 0.625, "repetitions": 4, "mu0": [0.3], "tau0": [0.0, 0.05],
}  # fmt: skip

SOLUTION_TOLERANCE = 1e-4  # relative difference between two solutions that start from different pressures


@pytest.fixture(scope="module")
def dataset():
    return run(table_study(**TABLE_OPTIONS)).dataset


@pytest.fixture(scope="module")
def table(dataset):
    return friction_table(dataset)


def test_friction_table_equals_means_over_directly_solved_pairs(dataset, table):
    study = table_study(**TABLE_OPTIONS)
    loads = [pressure * 100 for pressure in TABLE_OPTIONS["pressures"]]
    curves = {rule: [] for rule in ("opposing", "all")}
    for repetition in range(4):
        upper, lower = pair_of(study, repetition, fractal_dimension=1.4, amplitude=0.03)
        assert upper.heights.std() == pytest.approx(0.03)
        for rule, result in curves.items():
            result.append(
                half_space(upper, lower, loads, boundary="periodic", direction=[0.0, 90.0, 180.0, 270.0], sliding=rule)
            )
    cell = table.sel(hurst_exponent=0.6, method="nearest").sel(rms=0.03, method="nearest")
    area = np.mean([curve.contact_area for curve in curves["all"]], axis=0) / 100
    np.testing.assert_allclose(cell["contact_area_fraction"].sel(statistic="mean"), area, rtol=SOLUTION_TOLERANCE)
    for rule, result in curves.items():
        normal, tangential = (
            np.mean([getattr(curve, f"{component}_load")(mu0=0.3, tau0=0.05) for curve in result], axis=(0, 1))
            for component in ("normal", "tangential")
        )
        mean = cell["friction_coefficient"].sel(sliding=rule, mu0=0.3, tau0=0.05, statistic="mean")
        np.testing.assert_allclose(mean, tangential / normal, rtol=SOLUTION_TOLERANCE)
    # The stiffness of fixed contact patches differs from dF/dδ, because contact patches also appear and merge.
    stiffness_of_fixed_patches = 1e6 * np.mean([curve.stiffness for curve in curves["all"]], axis=0) / 100  # MPa/mm
    ratio = cell["normal_stiffness"].sel(statistic="mean").values[1:-1] / stiffness_of_fixed_patches[1:-1]
    assert ((ratio > 0.8) & (ratio < 1.3)).all()


def test_fitted_stiffness_law_is_undefined_if_the_approach_decreases_as_the_load_increases(dataset, table):
    changed_dataset = dataset.copy(deep=True)
    changed_dataset["approach"].values[0, 0, 1] *= -1
    result = friction_table(changed_dataset)
    for name in ("stiffness_factor", "stiffness_exponent", "stiffness_deviation"):
        assert np.isnan(result[name].isel(hurst_exponent=1, rms=0)).all()
        assert result[name].isel(hurst_exponent=0).equals(table[name].isel(hurst_exponent=0))


def test_friction_table_has_smaller_areas_for_larger_slopes_and_more_friction_for_larger_tau0(table):
    mean = table.sel(statistic="mean")
    for name in ("contact_area_fraction", "normal_stiffness", "approach"):
        assert (mean[name].diff("pressure") > 0).all(), name
    assert (mean["contact_area_fraction"].diff("rms") < 0).all()
    assert (mean["contact_area_fraction"].diff("hurst_exponent") > 0).all()
    assert (mean["friction_coefficient"].diff("tau0") > 0).all()
    lower, upper = (table["contact_area_fraction"].sel(statistic=item) for item in ("lower", "upper"))
    assert ((lower < mean["contact_area_fraction"]) & (mean["contact_area_fraction"] < upper)).all()


def test_fitted_area_law_agrees_with_areas_at_light_pressures(table):
    for index in np.ndindex(2, 2):
        cell = table.isel(hurst_exponent=index[0], rms=index[1])
        mean = cell.sel(statistic="mean")
        is_light = mean["contact_area_fraction"].values <= 0.1
        pressure = table["pressure"].values[is_light]
        deviation = np.abs(
            mean["contact_area_fraction"].values[is_light] / (float(mean["area_factor"]) * pressure) - 1
        ).max()
        assert deviation == pytest.approx(float(cell["area_deviation"]))
        assert deviation < 0.25
        assert 0.6 < float(mean["stiffness_exponent"]) < 1.1


def test_fitted_laws_of_a_friction_table_recover_exact_power_laws(dataset):
    """Fit laws to areas and approaches that follow the laws exactly."""
    exact_dataset = dataset.copy(deep=True)
    pressure = exact_dataset["load"].values / 100
    exact_dataset["contact_area"].values[...] = 100 * 1.5 * pressure
    exact_dataset["approach"].values[...] = 0.02 * np.log(pressure) + 1
    result = friction_table(exact_dataset)
    assert result["area_factor"].values == pytest.approx(1.5)
    assert result["area_deviation"].values == pytest.approx(0, abs=1e-12)
    assert result["stiffness_factor"].values == pytest.approx(50e6)  # 50 GPa/µm at a pressure of 1 GPa, in MPa/mm
    assert result["normal_stiffness"].attrs["units"] == "MPa/mm"
    assert "stiffness over area (MPa/mm)" in friction_table_csv(result)
    assert re.search(r"\b50\b", friction_table_text(result))
    assert result["stiffness_exponent"].values == pytest.approx(1)


def test_assessments_in_friction_tables_equal_summary_assessments_and_depend_on_the_sliding_rule(dataset, table):
    result = Result.of(dataset)
    result_at_loads = result.at(100 * table["pressure"].values, load_definition="elastic")
    for point in result.summarize_dataset(result_at_loads).points:
        conditions = {"hurst_exponent": 2 - point.at["fractal_dimension"], "rms": point.at["amplitude"]}
        conditions |= {"pressure": point.at["load"] / 100} | {name: point.at[name] for name in ("mu0", "tau0")}
        assert table["assessment"].sel(sliding="opposing").sel(conditions, method="nearest").item() == point.assessment
    # If tau0 is 0, friction at all contacts equals the given mu0, so it has a caveat and must not be quoted.
    without_tau0 = table["assessment"].sel(tau0=0.0)
    assert "Quote it" not in without_tau0.sel(sliding="all").values
    assert "Quote it" in without_tau0.sel(sliding="opposing").values


def test_friction_table_of_an_earlier_version_is_written_without_assessments(table):
    columns = friction_table_csv(table).splitlines()[0]
    assert columns.endswith(",assessment")
    assert friction_table_csv(table.drop_vars("assessment")).splitlines()[0] == columns.removesuffix(",assessment")


def test_friction_table_interval_is_consistent_with_the_standard_error_over_pairs(dataset, table):
    """Compare the upper half-width with the standard error of the coefficients of the pairs."""
    friction = table["friction_coefficient"].isel(hurst_exponent=0, rms=0, mu0=0, tau0=0, pressure=3).sel(sliding="all")
    mean, lower, upper = friction.values
    assert lower < mean < upper
    pairs = dataset.isel(fractal_dimension=1, amplitude=0, load=3).sel(sliding="all").mean("direction")
    coefficients = (pairs["tangential_elastic"] + 0.3 * pairs["tangential_frictional"]) / (
        pairs["normal_elastic"] + 0.3 * pairs["normal_frictional"]
    )
    standard_error = float(coefficients.std(ddof=1)) / 2
    assert 2 * standard_error < upper - mean < 14 * standard_error


def test_friction_table_rejects_a_study_of_generated_profiles(small_result):
    with pytest.raises(ValueError, match="must be from a study of generated height maps"):
        friction_table(small_result)


COMMAND_OPTIONS = [
    "--effective-modulus", "10 GPa", "--hurst", "0.8", "--rms", "20 nm", "--load", "3 MPa,10 MPa,30 MPa",
    "--points", "32", "--wavelengths", "0.625 um,2.5 um", "--repetitions", "3",
]  # fmt: skip


def test_table_command_writes_the_same_table_as_the_library(tmp_path):
    check_stiction("table", *COMMAND_OPTIONS, cwd=tmp_path)
    study = table_study(
        hurst_exponents=[0.8], rms=[0.02], pressures=[0.003, 0.01, 0.03], points=32, shortest_wavelength=0.625,
        repetitions=3,
    )  # fmt: skip
    expected = friction_table(run(study))
    with xarray.open_dataset(tmp_path / "table" / "table.nc", engine="h5netcdf") as file_dataset:
        assert (file_dataset["assessment"] == expected["assessment"]).all()
        for name in expected.drop_vars("assessment").data_vars:
            np.testing.assert_allclose(file_dataset[name].values, expected[name].values, rtol=1e-9, err_msg=name)
    rows = list(csv.DictReader((tmp_path / "table" / "table.csv").read_text().splitlines()))
    assert len(rows) == 2 * 3 * 3
    assert [float(row["pressure (MPa)"]) for row in rows[::3]] == pytest.approx([3, 10, 30, 3, 10, 30])
    coefficient = expected["friction_coefficient"].isel(sliding=0, hurst_exponent=0, rms=0, pressure=0, mu0=0, tau0=0)
    assert float(rows[0]["mu_s"]) == pytest.approx(float(coefficient[0]))
    laws = list(csv.DictReader((tmp_path / "table" / "laws.csv").read_text().splitlines()))
    assert float(laws[0]["c of k/A0 = b p^c"]) == pytest.approx(float(expected["stiffness_exponent"][0, 0, 0]))
    assert [row["assessment"] for row in rows[:3]] == expected["assessment"].isel(pressure=0).values[0].ravel().tolist()
    # The command with another mu0 replaces the table, even the table of an earlier version, which lacks assessments.
    export(expected.drop_vars("assessment"), tmp_path / "table" / "table.nc", replace=True)
    (tmp_path / "table" / "table.csv").write_text(friction_table_csv(expected.drop_vars("assessment")))
    completed = check_stiction("table", *COMMAND_OPTIONS, "--mu0", "0.1", cwd=tmp_path)
    frame = pandas.read_csv(tmp_path / "table" / "table.csv")
    assert (len(frame), frame["mu0"].unique().tolist()) == (2 * 3, [0.1])
    for text, count in frame["assessment"].value_counts().items():
        assert f"{text} ({count})" in " ".join(completed.stdout.split())
    assert open_result(tmp_path / "table").study.friction.mu0 == (0.1,)
    assert "μ0 = 0.1," in check_stiction("info", "table", cwd=tmp_path).stdout


def test_at_command_accepts_a_pressure_as_load_for_a_friction_table_and_prints_assessments(tmp_path):
    check_stiction("table", *COMMAND_OPTIONS, "--mu0", "0.2", cwd=tmp_path)
    by_pressure, by_force = (
        check_stiction("at", "table", "--load", load, cwd=tmp_path).stdout for load in ("5 MPa", "0.5 mN")
    )
    assert by_pressure == by_force
    frame = pandas.read_csv(tmp_path / "table" / "table.csv").set_index(["contacts with friction", "pressure (MPa)"])
    assessment_at_3_mpa, assessment_at_10_mpa = (
        frame.loc[("opposing", pressure), "assessment"] for pressure in (3.0, 10.0)
    )
    text = (
        f"Interpolated at 0.5 mN (5 MPa), between 0.3 mN (3 MPa): {assessment_at_3_mpa} "
        f"and 1 mN (10 MPa): {assessment_at_10_mpa}."
    )
    assert text in " ".join(by_pressure.split())
    record = json.loads(check_stiction("at", "table", "--load", "5 MPa", "--json", cwd=tmp_path).stdout)
    assert record["interpolated"] == [
        {
            "load": 0.5,
            "between": [
                {"load": 0.3, "assessments": {assessment_at_3_mpa: 1}},
                {"load": 1.0, "assessments": {assessment_at_10_mpa: 1}},
            ],
        }
    ]
    assert "Interpolated" not in check_stiction("at", "table", "--load", "10 MPa", cwd=tmp_path).stdout


def test_table_command_accepts_materials_and_hardness_and_interface(tmp_path):
    materials = ["--upper", "steel", "--lower", "brass"]
    check_stiction("table", *materials, *COMMAND_OPTIONS[2:], "--output", "soft", cwd=tmp_path)
    interface = ["--hardness", "5 GPa", "--interface", "rock on rock, below 200 MPa", "--output", "hard"]
    check_stiction("table", *materials, *interface, *COMMAND_OPTIONS[2:], cwd=tmp_path)
    soft_table, hard_table = (pandas.read_csv(tmp_path / name / "table.csv") for name in ("soft", "hard"))
    hardness = {name: open_result(tmp_path / name).study.contact.hardness for name in ("soft", "hard")}
    brass = material("brass").hardness
    assert float(hardness["soft"]) == pytest.approx(float(brass), rel=1e-5)
    assert float(hardness["hard"]) == 5.0
    areas = [table.groupby("pressure (MPa)")["A/A0 (%)"].first() for table in (soft_table, hard_table)]
    assert (areas[0] > areas[1]).all()
    assert sorted(soft_table["mu0"].unique()) == [0.2, 0.4, 0.6]
    assert hard_table["mu0"].nunique() == hard_table["tau0 (MPa)"].nunique() == 1


@pytest.mark.parametrize("rule", ["all", "opposing"])
def test_table_command_starts_with_the_sliding_rule_of_the_interface(tmp_path, rule):
    film = interface("MoS2 on bearing steel, dry air")
    write_interface(replace(film, fits=(replace(film.fits[0], sliding=rule),)), tmp_path / "film.csv")
    output = check_stiction("table", *COMMAND_OPTIONS, "--interface", "film.csv", cwd=tmp_path).stdout
    headings = [f"μ_s {name} contacts" for name in ("all", "opposing")]
    assert (output.index(headings[0]) < output.index(headings[1])) == (rule == "all")
    frame = pandas.read_csv(tmp_path / "table" / "table.csv")
    assert frame["contacts with friction"].iloc[0] == rule
    for command in ("info", "at"):
        arguments = [command, "table", *(["--load", "10 MPa"] if command == "at" else [])]
        printed_text = " ".join(check_stiction(*arguments, cwd=tmp_path).stdout.split())
        assert (printed_text.index("all contacts") < printed_text.index("opposing contacts")) == (rule == "all"), (
            command
        )


def test_table_command_writes_the_joint_table_of_measured_profiles(tmp_path, monkeypatch):
    monkeypatch.setattr("stiction.summary.joint_table.MAX_RATIO_OF_SUCCESSIVE_LOADS", 4.0)
    write_profiles(tmp_path)
    options = ["--unit", "um", "--spacing", "0.02 um", "--upper", "steel", "--lower", "brass", "--hardness", "2 GPa"]
    arguments = ["--mu0", "0.2,0.3", "--tau0", "50 MPa", "--load", "5 MPa,50 MPa"]
    check_stiction("table", "upper.npy", "lower.npy", *options, *arguments, cwd=tmp_path)
    frame = pandas.read_csv(tmp_path / "table" / "table.csv")
    result = open_result(tmp_path / "table")
    for mu0 in (0.2, 0.3):
        expected = joint_frame([result.joint_table(mu0=mu0, tau0=0.05)])
        rows = frame[frame["mu0"] == mu0].reset_index(drop=True)
        for name in ("nominal pressure (MPa)", "closure (mm)", "tangential stiffness (MPa/mm)", "mu_s 5 %"):
            np.testing.assert_allclose(rows[name], expected[name], rtol=1e-8)
        is_study_load = np.isclose(rows["nominal pressure (MPa)"], 50)
        point = result.summary("50 MPa", mu0=mu0, tau0=0.05).first
        assert rows["assessment of mu_s"][is_study_load].tolist() == [point.assessment]
    assert_rejected(
        call_stiction("table", "upper.npy", "lower.npy", *options, *arguments, "--hurst", "0.8", cwd=tmp_path),
        "--hurst applies only to generated surfaces",
    )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (["--mu0", "0.2", "--interface", "steel on ice"], "--interface must not be combined with --mu0 or --tau0"),
        (["--load", "1 mN"], "--load must be a pressure"),
        (["--wavelengths", "1 um"], "--wavelengths must be two lengths"),
        (["--hurst", "rough"], "--hurst must be one or more numbers"),
    ],
)
def test_table_command_rejects_invalid_options(tmp_path, changes, message):
    assert_rejected(call_stiction("table", *COMMAND_OPTIONS, *changes, cwd=tmp_path), message)
    assert not (tmp_path / "table" / "table.nc").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"hurst_exponents": [1.2]}, r"hurst_exponents must be above 0 and at most 1, got \[1.2\]"),
        ({"hurst_exponents": ["a"]}, "hurst_exponents must be an array of real numbers"),
        ({"hurst_exponents": []}, "hurst_exponents must be numbers above 0"),
        ({"rms": [-1]}, "rms must be numbers above 0"), ({"pressures": [0.0]}, "pressures must be numbers above 0"),
        ({"mu0": [-1]}, "mu0 must not be negative"), ({"extent": "x"}, "extent must be"),
        ({"effective_modulus": 0}, "effective_modulus must be a finite number above 0"),
        ({"points": 3}, "surfaces.shape.*must be at least 4"), ({"repetitions": 0}, "ensemble.repetitions.*at least 1"),
        ({"shortest_wavelength": 100}, "must be below the longest wavelength"),
    ],
)  # fmt: skip
def test_friction_table_rejects_impossible_values_without_mentioning_pydantic(arguments, message):
    with pytest.raises(ValueError, match=message) as error_info:
        table_study(**arguments)
    assert "pydantic" not in str(error_info.value)


def test_friction_table_accepts_single_numbers_instead_of_lists():
    assert table_study(rms=0.03, mu0=0.3, hurst_exponents=0.8) == table_study(
        rms=[0.03], mu0=[0.3], hurst_exponents=[0.8]
    )


def test_table_command_prints_the_number_of_values_that_must_not_be_quoted(tmp_path):
    options = ["--effective-modulus", "10 GPa", "--hurst", "0.8", "--rms", "20 nm", "--points", "64"]
    options += ["--wavelengths", "1.25 um,2.5 um", "--mu0", "0.3"]
    few_contacts = check_stiction("table", *options, "--load", "10 kPa,100 MPa", cwd=tmp_path).stdout
    counts = "Do not quote (2), Quote with care (1), Quote it (1)"
    assert f"Assessment of 4 coefficients (column assessment): {counts}." in " ".join(few_contacts.split())
    assert "What helps: use larger surfaces or a higher load" in " ".join(few_contacts.split())
    many_contacts = check_stiction("table", *options, "--load", "30 MPa,100 MPa", "-o", "high", cwd=tmp_path).stdout
    assert "Do not quote" not in many_contacts
