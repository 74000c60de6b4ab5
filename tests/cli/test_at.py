"""Tests of the commands `at`, `info`, `export`, `plot` and `run` on a study, a pair of profiles and a pair of maps."""

import csv
import json
import re
import shutil

import numpy as np
import pytest
import xarray
from stiction import open_result, run, self_affine, self_affine_surface, write_profile, write_surface
from stiction.evaluate.at_load import at_load
from stiction.solve.store import open_stored_result
from stiction.summary.summary import summarize
from stiction.views.json_record import SCHEMA_VERSION
from support.command import assert_rejected, call_stiction, check_stiction, disable_companion_files, disable_reports
from support.generated_studies import SMALL_STUDY

MATERIAL_OPTIONS = ("--effective-modulus", "10 GPa", "--mu0", "0.3", "--tau0", "0 MPa,20 MPa")

PAIR_ARGUMENTS = {
    "lines": ("upper.csv", "lower.csv", *MATERIAL_OPTIONS, "--load", "0.1 mN", "--offsets", "8"),
    "maps": (
        "upper.npy", "lower.npy", "--unit", "um", "--spacing", "0.2 um", *MATERIAL_OPTIONS,
        "--load", "10 MPa", "--load", "5 MPa", "--shifts", "3", "--mechanics", "asperities",
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def results_directory(tmp_path_factory, no_figures):
    """Directory with two profiles, two maps and three results: of a study, of the profiles and of the maps."""
    path = tmp_path_factory.mktemp("results")
    for side in ("upper", "lower"):
        scan = self_affine(1, hurst_exponent=0.8, rms=0.05, points=600, spacing=0.05, side=side)
        write_profile(scan, path / f"{side}.csv")
        surface_options = {"rms": 0.02, "shape": (24, 24), "spacing": 0.2, "shortest_wavelength": 0.8}
        write_surface(self_affine_surface(1, hurst_exponent=0.8, side=side, **surface_options), path / f"{side}.npy")
    run(
        SMALL_STUDY.with_changes({"ensemble.repetitions": 4, "friction.tau0": ["0 MPa", "100 MPa"]}),
        store=path / "study",
    )
    with no_figures(), disable_reports(), disable_companion_files():
        for name, arguments in PAIR_ARGUMENTS.items():
            assert get_stiction_output("pair", *arguments, "--output", name, cwd=path)
    return path


def get_stiction_output(*arguments, cwd):
    completed = check_stiction(*arguments, cwd=cwd, without_figures=True)
    return completed.stdout


# ---- at --------------------------------------------------------------------------------------------------------------


LOAD_AND_PARAMETER_CASES = {
    "study": (
        ("--load", "1 uN", "--d", "1.3", "--mu0", "0.35", "--tau0", "20 MPa"), [1e-3], {"mu0": [0.35], "tau0": [0.02]},
    ),
    "lines": (("--load", "0.12 mN", "--mu0", "0.25"), [0.12], {"mu0": [0.25]}),
    "maps": (("--load", "8 MPa", "--mu0", "0.25", "--tau0", "5 MPa"), [], {"mu0": [0.25], "tau0": [0.005]}),
}  # fmt: skip


@pytest.mark.parametrize("name", LOAD_AND_PARAMETER_CASES)
def test_at_command_prints_the_same_values_as_the_python_function_for_given_mu0_and_tau0(results_directory, name):
    options, loads, friction_parameters = LOAD_AND_PARAMETER_CASES[name]
    output_record = json.loads(get_stiction_output("at", name, *options, "--json", cwd=results_directory))
    stored_result = open_stored_result(results_directory / name)
    if name == "maps":
        loads = [8e-3 * output_record["nominal_area"]]
    expected_points = at_load(stored_result, loads, **friction_parameters)
    if name == "study":
        expected_points = expected_points.sel(fractal_dimension=[1.3], method="nearest").isel(amplitude=[0])
    expected_points = summarize(expected_points, stored_result.study).points
    assert [json_point["assessment"] for json_point in output_record["points"]] == [
        json_point.assessment for json_point in expected_points
    ]
    assert [json_point["at"]["load"] for json_point in output_record["points"]] == pytest.approx(
        [json_point.at["load"] for json_point in expected_points]
    )
    for json_point, point in zip(output_record["points"], expected_points, strict=True):
        assert [rule["coefficient"]["value"] for rule in json_point["rules"]] == pytest.approx(
            [rule.value for rule in point.rules]
        )
    text = get_stiction_output("at", name, *options, cwd=results_directory)
    first_rule = expected_points[0].rules[0]
    assert str(first_rule) in text
    assert expected_points[0].assessment in text


def test_at_command_uses_mu0_and_tau0_of_the_study_by_default_and_reports_unreached_loads(results_directory):
    record = json.loads(get_stiction_output("at", "lines", "--load", "0.1 mN", "--json", cwd=results_directory))
    assert [(json_point["at"]["mu0"], json_point["at"]["tau0"]) for json_point in record["points"]] == [
        (0.3, 0.0),
        (0.3, 0.02),
    ]
    text = get_stiction_output("at", "study", "--load", "1 uN", "--mu0", "0.4", cwd=results_directory)
    assert text.splitlines()[0].endswith("τ0 = 0, 100 MPa (--tau0).")
    assert [line.split()[0] for line in text.splitlines()[1:6]] == ["D", "1", "1", "1.2", "1.2"]
    record = json.loads(
        get_stiction_output(
            "at", "study", "--load", "1 uN,1 N", "--d", "1.3", "--mu0", "0.3", "--json", cwd=results_directory
        )
    )
    assert [json_point["status"] for json_point in record["points"]] == ["ok", "ok", "not-reached", "not-reached"]


@pytest.mark.parametrize(
    ("name", "options"),
    [("study", ("--load", "1 N", "--d", "1.3")), ("maps", ("--load", "1 Pa")), ("maps", ("--load", "1 Pa,1 TPa"))],
)
@pytest.mark.parametrize("json_options", [(), ("--json",)])
def test_at_command_rejects_the_loads_if_all_are_outside_the_computed_range(
    results_directory, name, options, json_options
):
    completed = call_stiction("at", name, *options, *json_options, cwd=results_directory)
    assert_rejected(completed, "no values at ", "the computed loads are ")
    assert completed.stdout == ""


@pytest.mark.parametrize("more_options", [(), ("--scale-heights", "1")])
def test_at_command_warns_about_loads_outside_the_computed_range_and_omits_these_loads(results_directory, more_options):
    arguments = ("at", "maps", *more_options, "--tau0", "0 MPa")
    completed = check_stiction(*arguments, "--load", "1 Pa,10 MPa", cwd=results_directory, without_figures=True)
    assert completed.stdout == get_stiction_output(*arguments, "--load", "10 MPa", cwd=results_directory)
    assert completed.stderr.count("no values at ") == 1
    assert "(1 Pa)" in completed.stderr


def test_at_command_without_options_uses_mu0_and_tau0_and_loads_of_the_study(results_directory):
    record = json.loads(get_stiction_output("at", "maps", "--json", cwd=results_directory))
    study = open_stored_result(results_directory / "maps").study
    expected_conditions = [
        (float(load), 0.3, float(tau0)) for load in study.friction.load for tau0 in study.friction.tau0
    ]
    assert [
        (json_point["at"]["load"], json_point["at"]["mu0"], json_point["at"]["tau0"]) for json_point in record["points"]
    ] == expected_conditions
    record = json.loads(get_stiction_output("at", "study", "--load", "1 uN", "--json", cwd=results_directory))
    friction = open_stored_result(results_directory / "study").study.friction
    assert {json_point["at"]["tau0"] for json_point in record["points"]} == {0.0, 0.1}
    assert {json_point["at"]["mu0"] for json_point in record["points"]} == set(friction.mu0)


def test_at_command_prints_friction_for_the_direction_of_motion_given_as_an_option(results_directory):
    arguments = ("at", "maps", "--load", "10 MPa", "--tau0", "0 MPa")
    record = json.loads(get_stiction_output(*arguments, "--direction", "30", "--json", cwd=results_directory))
    assert "the upper body moves at 30°" in get_stiction_output(*arguments, "--direction", "30", cwd=results_directory)
    assert "the mean over 12 directions and 3 positions" in get_stiction_output(*arguments, cwd=results_directory)
    dataset = at_load(open_stored_result(results_directory / "maps"), [record["points"][0]["at"]["load"]], tau0=[0.0])
    expected = dataset["friction_coefficient"].sel(direction=30.0, sliding="all", statistic="mean").squeeze()
    assert record["points"][0]["rules"][0]["coefficient"]["value"] == pytest.approx(float(expected))


def test_at_command_accepts_comma_separated_values_and_repeated_options(results_directory):
    arguments = ("at", "study", "--tau0", "0 MPa,100 MPa", "--json")
    record_of_lists = json.loads(
        get_stiction_output(
            *arguments, "--load", "1 uN,2 uN", "--mu0", "0.3,0.4", "--d", "1.3,1.0", cwd=results_directory
        )
    )
    record_of_repeated_options = json.loads(
        get_stiction_output(
            *arguments, "--load", "1 uN", "--load", "2 uN", "--mu0", "0.4", "--d", "1", cwd=results_directory
        )
    )
    conditions = [json_point["at"] for json_point in record_of_lists["points"]]
    assert len(conditions) == 2 * 2 * 2 * 2
    assert sorted({json_point["load"] for json_point in conditions}) == pytest.approx([1e-3, 2e-3])
    assert len({json_point["fractal_dimension"] for json_point in conditions}) == 2
    rules_by_condition = {json.dumps(json_point["at"]): json_point["rules"] for json_point in record_of_lists["points"]}
    assert all(
        rules_by_condition[json.dumps(json_point["at"])] == json_point["rules"]
        for json_point in record_of_repeated_options["points"]
    )


def test_at_command_marks_the_value_to_which_the_range_of_the_study_applies(results_directory, tmp_path):
    shutil.copytree(results_directory / "maps", tmp_path / "maps")
    ranges = ("--set", 'friction.mu0="0.25..0.35"', "--set", 'friction.tau0="0..40 MPa"')
    check_stiction("run", "maps", *ranges, cwd=tmp_path, without_figures=True, without_report=True)
    arguments = ("at", "maps", "--load", "10 MPa", "--mu0", "0.3", "--tau0", "0 MPa,20 MPa,40 MPa")
    lines = get_stiction_output(*arguments, cwd=tmp_path).splitlines()
    table = [line for line in lines if line.startswith(("0 ", "20 MPa", "40 MPa"))]
    assert [re.split("  +", line)[0] for line in table] == ["0", "20 MPa (0..40 MPa)", "40 MPa"]
    text = " ".join(" ".join(lines).split())
    assert "τ0 = 20 MPa with the study's range (0..40 MPa), every other τ0 exact" in text
    assert "μ0 = 0.3 (0.25..0.35)" in text
    points = json.loads(get_stiction_output(*arguments, "--json", cwd=tmp_path))["points"]
    assert [point["ranges"]["tau0"] for point in points] == [None, "0..40 MPa", None]
    assert {point["ranges"]["mu0"] for point in points} == {"0.25..0.35"}
    widths = {
        point["at"]["tau0"]: np.ptp([point["rules"][0]["coefficient"][end] for end in ("lower", "upper")])
        for point in points
    }
    assert widths[0.02] > max(widths[0.0], widths[0.04])
    exact_points = json.loads(get_stiction_output(*arguments, "--mu0", "0.32", "--json", cwd=tmp_path))["points"]
    assert {point["at"]["mu0"]: point["ranges"]["mu0"] for point in exact_points} == {0.32: None}


@pytest.mark.parametrize(
    ("arguments", "expected_words"),
    [
        (("study", "--load", "-1 mN", "--mu0", "0.3"), ["--load must be above 0"]),
        (("study", "--load", "1 mN", "--mu0", "-0.3"), ["--mu0 must be at least 0"]),
        (("study", "--load", "1 mN", "--tau0", "-1 MPa"), ["--tau0 must be at least 0"]),
        (("study", "--load", "1 um"), ["--load"]),
        (("study", "--load", "1 MPa"), ["--load must be a force if the result has no nominal area"]),
        (("study",), ["--load must be given, because the study has no loads"]),
        (("study", "--load", "1 mN", "--mu0", "0,2"), ['"0.2"', '"0, 2"']),
        (("study", "--load", "0,5 mN"), ['"0.5"']),
        (("maps", "--load", "3,5 MPa"), ['"3.5"']),
        (("maps", "--load", "0"), ["--load must be above 0", "adhere"]),
        (("lines", "--load", "1 mN", "--d", "1.3"), ["--d applies only to studies"]),
        (("study", "--load", "1 mN", "--d", "flat"), ["--d must be one or more numbers"]),
        (("maps", "--load", "1 mN", "--amplitude", "1 um"), ["--amplitude applies only to studies"]),
        (("maps", "--load", "1 mN", "--direction", "31"), ["--direction must be one of the directions in"]),
        (("nowhere", "--load", "1 mN"), ["nowhere: no such directory"]),
        (("maps", "--mu0", "0.1..0.2"), ["--mu0 must be one or more numbers without ranges, got '0.1..0.2'"]),
        (("lines", "--tau0", "5±1 MPa"), ["""stiction run lines --set 'friction.tau0="5±1 MPa"'"""]),
        (
            ("maps", "--tau0", "5 MPa,0..4 MPa"),
            ["--tau0 must be one or more numbers without ranges, got '5 MPa,0..4 MPa'"],
        ),
        (("maps", "--tau0", "5 MPa,0..4 MPa"), ["""stiction run maps --set 'friction.tau0="0..4 MPa"'"""]),
        (("maps", "--mu0", "0,1..2,5"), ["--mu0 must not have a comma between digits, got '0,1..2,5'"]),
    ],
)
def test_error_of_the_at_command_names_the_rejected_option(results_directory, arguments, expected_words):
    assert_rejected(call_stiction("at", *arguments, cwd=results_directory), *expected_words)


def test_at_command_rejects_a_range_and_prints_a_run_command_with_the_directory_in_quotes(results_directory, tmp_path):
    shutil.copytree(results_directory / "maps", tmp_path / "two words")
    rejected = call_stiction("at", "two words", "--mu0", "0.1..0.2", cwd=tmp_path)
    assert_rejected(rejected, """stiction run 'two words' --set 'friction.mu0="0.1..0.2"'""")


def test_at_command_rejects_a_range_for_a_pair_with_a_friction_law_without_suggesting_to_drop_the_law(
    results_directory,
):
    law, maps = "MoS2 on bearing steel, dry air", PAIR_ARGUMENTS["maps"]
    index = maps.index("--mu0")
    arguments = (*maps[:index], *maps[index + 4 :], "--interface", law, "--output", "with_law")
    check_stiction("pair", *arguments, cwd=results_directory, without_figures=True, without_report=True)
    rejected = call_stiction("at", "with_law", "--mu0", "0.1..0.2", cwd=results_directory)
    assert_rejected(rejected, f"come from the friction law {law}: for another range, run stiction pair with another")
    assert "--set" not in rejected.stderr


# ---- info, export, run, plot -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["study", "lines", "maps"])
def test_info_command_writes_json_with_the_same_schema_for_every_result(results_directory, name):
    record = json.loads(get_stiction_output("info", name, "--json", cwd=results_directory))
    assert list(record)[:3] == ["schema", "stiction", "command"]
    assert (record["schema"], record["command"]) == (SCHEMA_VERSION, "info")
    assert (
        record["finished"]
        == record["repetitions"]
        == open_stored_result(results_directory / name).study.ensemble.repetitions
    )
    assert record["values"]
    assert all({"assessment", "caveats", "sentence"} <= set(json_point) for json_point in record["points"])
    assert get_stiction_output("report", name, "--output", f"{name}.html", cwd=results_directory)
    text = get_stiction_output("info", name, cwd=results_directory)
    assert f"{record['finished']} of {record['repetitions']} finished" in text
    if name == "study":
        assert text.count("μ_s [95 %] at ") == 2, "a table for each amplitude"
        assert "D" in text
    assert f"\n{record['points'][0]['assessment']}" in text or " (1 of 2)" in text
    if name == "study":
        return
    loads = [json_point["at"]["load"] for json_point in record["points"]]
    assert loads == sorted(loads), "--load options of a pair may be in any order"
    assert len(set(loads)) == {"maps": 2, "lines": 1}[name]


def test_at_command_computes_missing_height_factors_only_with_the_compute_option(results_directory, tmp_path):
    shutil.copytree(results_directory / "maps", tmp_path / "maps")
    arguments = ("at", "maps", "--scale-heights", "0.5,1,2", "--load", "10 MPa", "--mu0", "0.25")
    assert_rejected(
        call_stiction(*arguments, cwd=tmp_path),
        "--scale-heights needs results at 2 factors", "--compute",
    )  # fmt: skip
    text = get_stiction_output(*arguments, "--compute", cwd=tmp_path)
    rows = [line.split() for line in text.splitlines() if line[:1].isdigit()]
    assert [row[0] for row in rows[:3]] == ["0.5", "1", "2"]
    areas = open_result(tmp_path / "maps").at("10 MPa", mu0=0.25, height_scale=[0.5, 1, 2])["contact_area_fraction"]
    for value, lower, upper in 100 * areas.squeeze().values:
        assert lower < value < upper
        printed_intervals = [re.findall(r"(\S+) \[(\S+), (\S+)\] %$", line) for line in text.splitlines()]
        assert any(
            np.allclose(np.array(row[0], float), [value, lower, upper], rtol=0.1) for row in printed_intervals if row
        )
    assert get_stiction_output(*arguments, cwd=tmp_path) == text
    record = json.loads(get_stiction_output(*arguments, "--json", cwd=tmp_path))
    assert (record["kind"], record["scaled"], record["solved"]) == ("pair", "both", [0.5, 1.0, 2.0])
    load = 10e-3 * record["nominal_area"]
    dataset = open_result(tmp_path / "maps").at(load, mu0=0.25, height_scale=[0.5, 1, 2])
    names = {value["name"] for value in record["values"]}
    assert {"friction_combined", "contact_area_fraction", "rms_gradient", "upper_rms", "lower_rms"} <= names
    for value in record["values"]:
        if value["name"] == "friction_combined":
            selection = {name: value["at"][name] for name in ("height_scale", "tau0", "sliding")}
            assert value["value"] == pytest.approx(
                float(dataset["friction_combined"].sel(selection | {"statistic": "mean"}).item())
            )
    assert "height_scale" in get_stiction_output("plot", "maps", "--output", "figures", cwd=tmp_path)


@pytest.mark.parametrize(
    ("name", "arguments", "expected_message"),
    [
        ("maps", ("--scale-heights", "0"), "--scale-heights must be from 0.01 to 100, got '0'"),
        ("maps", ("--scale-heights=-1",), "--scale-heights must be from 0.01 to 100, got '-1'"),
        ("maps", ("--scale-heights", "a..b"), "--scale-heights must be a list of factors"),
        ("maps", ("--scale-heights", "4..0.25"), "--scale-heights must be a list of factors"),
        ("maps", ("--scale-heights", "x"), "--scale-heights must be"),
        ("maps", ("--scale-heights", "2", "--scaled", "left"), "scaled must be one of"),
        ("maps", ("--scale-heights", "2", "--direction", "0"), "--direction cannot be combined with --scale-heights"),
        ("maps", ("--scaled", "upper"), "--scaled requires --scale-heights"),
        ("maps", ("--compute",), "--compute requires --scale-heights"),
        ("study", ("--scale-heights", "2", "--load", "1 uN"), "--scale-heights needs two measured surfaces"),
        ("study", ("--scale-heights", "2", "--load", "1 uN", "--compute"), "needs two measured surfaces"),
    ],
)  # fmt: skip
def test_at_command_rejects_invalid_options_for_height_factors(results_directory, name, arguments, expected_message):
    assert_rejected(call_stiction("at", name, *arguments, cwd=results_directory), expected_message)


@pytest.mark.parametrize("name", ["study", "lines", "maps"])
def test_export_command_writes_netcdf_or_csv_without_overwriting_files(results_directory, name, tmp_path):
    get_stiction_output("export", name, str(tmp_path / "r.nc"), cwd=results_directory)
    with xarray.open_dataset(tmp_path / "r.nc", engine="h5netcdf") as exported_dataset:
        exported_dataset = exported_dataset.load()
    dataset = open_stored_result(results_directory / name).dataset()
    assert set(dataset.data_vars) == set(exported_dataset.data_vars)
    for variable in dataset.data_vars:
        assert exported_dataset[variable].equals(dataset[variable]), variable
    get_stiction_output("export", name, str(tmp_path / "r.csv"), cwd=results_directory)
    rows = list(csv.DictReader((tmp_path / "r.csv").read_text(encoding="utf-8").splitlines()))
    record = json.loads(get_stiction_output("info", name, "--json", cwd=results_directory))
    assert {row["assessment"] for row in rows} == {json_point["assessment"] for json_point in record["points"]}
    for file_name in ("r.nc", "r.csv"):
        assert_rejected(
            call_stiction("export", name, str(tmp_path / file_name), cwd=results_directory), "already exists"
        )
    for file_name in ("r.xlsx", "r"):
        assert_rejected(call_stiction("export", name, file_name, cwd=results_directory), "must end in .nc", ".csv")


@pytest.mark.usefixtures("disable_figures", "no_reports")
@pytest.mark.parametrize("name", ["lines", "maps"])
def test_run_command_adds_repetitions_to_a_result_directory(results_directory, name, tmp_path):
    shutil.copytree(results_directory / name, tmp_path / name)
    num_repetitions = open_stored_result(tmp_path / name).study.ensemble.repetitions
    get_stiction_output(
        "run", str(tmp_path / name), "--set", f"ensemble.repetitions={num_repetitions + 2}", cwd=results_directory
    )
    assert open_stored_result(tmp_path / name).finished_members.size == num_repetitions + 2
    assert_rejected(
        call_stiction("run", str(tmp_path / name), "--set", "friction.mu0=[-1]", cwd=results_directory), "mu0"
    )


def test_plot_command_writes_figures_in_the_requested_formats_to_the_output_directory(
    results_directory, tmp_path, monkeypatch
):
    calls = []

    def record_call(_, output_directory, *, formats):
        calls.append((output_directory, formats))
        return [output_directory / "a.pdf"]

    monkeypatch.setattr("stiction.views.figures.draw_figures", record_call)
    text = get_stiction_output(
        "plot", "lines", "--output", str(tmp_path / "figures"), "--format", "pdf,svg", cwd=results_directory
    )
    assert text.splitlines() == [f"wrote {tmp_path / 'figures' / 'a.pdf'}"]
    assert calls == [(tmp_path / "figures", ("pdf", "svg"))]
    assert_rejected(call_stiction("plot", "lines", "--format", "bmp", cwd=results_directory), "formats must be")
