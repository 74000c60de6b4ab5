"""Tests of at, info, export, plot and run on results of a study, of profiles and of maps."""

import csv
import json
import shutil

import pytest
import xarray
from stiction import open_result, run, self_affine, self_affine_surface, write_profile, write_surface
from stiction._number_format import quoted
from stiction.studies.evaluation import at_load
from stiction.studies.store import open_stored
from stiction.studies.summary import summarize
from stiction.views.rows import SCHEMA
from support.command import assert_rejected, call_stiction, check_stiction
from support.generated_studies import SMALL_STUDY

MATERIAL = ("--effective-modulus", "10 GPa", "--mu0", "0.3", "--tau0", "0 MPa,20 MPa")

PAIRS = {
    "lines": ("upper.csv", "lower.csv", *MATERIAL, "--load", "0.1 mN", "--offsets", "8"),
    "maps": (
        "upper.npy", "lower.npy", "--unit", "um", "--spacing", "0.2 um", *MATERIAL,
        "--load", "10 MPa", "--load", "5 MPa", "--shifts", "3", "--mechanics", "asperities",
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory, no_figures):
    """Two scans, two maps, a study, and a pair of each kind."""
    path = tmp_path_factory.mktemp("results")
    for side in ("upper", "lower"):
        scan = self_affine(1, hurst_exponent=0.8, rms=0.05, points=600, spacing=0.05, side=side)
        write_profile(scan, path / f"{side}.csv")
        rough = {"rms": 0.02, "shape": (24, 24), "spacing": 0.2, "shortest_wavelength": 0.8}
        write_surface(self_affine_surface(1, hurst_exponent=0.8, side=side, **rough), path / f"{side}.npy")
    run(
        SMALL_STUDY.with_changes({"ensemble.repetitions": 4, "friction.tau0": ["0 MPa", "100 MPa"]}),
        store=path / "study",
    )
    with no_figures():
        for name, arguments in PAIRS.items():
            assert said("pair", *arguments, "--output", name, cwd=path)
    return path


def said(*arguments, cwd):
    completed = check_stiction(*arguments, cwd=cwd, without_figures=True)
    return completed.stdout


# ---- at --------------------------------------------------------------------------------------------------------------


AT = {
    "study": (
        ("--load", "1 uN", "--d", "1.3", "--mu0", "0.35", "--tau0", "20 MPa"), [1e-3], {"mu0": [0.35], "tau0": [0.02]},
    ),
    "lines": (("--load", "0.12 mN", "--mu0", "0.25"), [0.12], {"mu0": [0.25]}),
    "maps": (("--load", "8 MPa", "--mu0", "0.25", "--tau0", "5 MPa"), [], {"mu0": [0.25], "tau0": [0.005]}),
}  # fmt: skip


@pytest.mark.parametrize("name", AT)
def test_at_equals_library_for_any_mu0_and_tau0(folder, name):
    arguments, loads, material = AT[name]
    record = json.loads(said("at", name, *arguments, "--json", cwd=folder))
    stored = open_stored(folder / name)
    if name == "maps":
        loads = [8e-3 * record["nominal_area"]]
    expected = at_load(stored, loads, **material)
    if name == "study":
        expected = expected.sel(fractal_dimension=[1.3], method="nearest").isel(amplitude=[0])
    expected = summarize(expected, stored.study).points
    assert [one["verdict"] for one in record["answers"]] == [one.verdict for one in expected]
    assert [one["at"]["load"] for one in record["answers"]] == pytest.approx([one.at["load"] for one in expected])
    for one, other in zip(record["answers"], expected, strict=True):
        assert [rule["value"] for rule in one["rules"]] == pytest.approx([rule.value for rule in other.rules])
    text = said("at", name, *arguments, cwd=folder)
    first = expected[0].rules[0]
    assert quoted(first.value, first.lower, first.upper) in text
    assert expected[0].verdict in text


def test_at_uses_defaults_of_the_result_and_reports_status(folder):
    record = json.loads(said("at", "lines", "--load", "0.1 mN", "--json", cwd=folder))
    assert [(one["at"]["mu0"], one["at"]["tau0"]) for one in record["answers"]] == [(0.3, 0.0), (0.3, 0.02)]
    text = said("at", "study", "--load", "1 uN", "--mu0", "0.4", cwd=folder)
    assert text.splitlines()[0].endswith("τ0 = 0, 100 MPa (--tau0).")
    assert [line.split()[0] for line in text.splitlines()[1:6]] == ["D", "1", "1", "1.2", "1.2"]
    text = said("at", "study", "--load", "1 N", "--d", "1.3", "--mu0", "0.3", "--tau0", "0 MPa", cwd=folder)
    assert text.startswith("μ_s = not-reached")
    assert "! no solved load is as large" in text


def test_at_without_options_uses_conditions_of_the_study(folder):
    record = json.loads(said("at", "maps", "--json", cwd=folder))
    study = open_stored(folder / "maps").study
    options = [(float(load), 0.3, float(tau0)) for load in study.friction.load for tau0 in study.friction.tau0]
    assert [(one["at"]["load"], one["at"]["mu0"], one["at"]["tau0"]) for one in record["answers"]] == options
    record = json.loads(said("at", "study", "--load", "1 uN", "--json", cwd=folder))
    friction = open_stored(folder / "study").study.friction
    assert {one["at"]["tau0"] for one in record["answers"]} == {0.0, 0.1}
    assert {one["at"]["mu0"] for one in record["answers"]} == set(friction.mu0)


def test_at_in_one_direction_uses_that_direction(folder):
    arguments = ("at", "maps", "--load", "10 MPa", "--tau0", "0 MPa")
    one = json.loads(said(*arguments, "--direction", "30", "--json", cwd=folder))
    assert "the upper body moves at 30°" in said(*arguments, "--direction", "30", cwd=folder)
    assert "the mean over 12 directions and 3 positions" in said(*arguments, cwd=folder)
    at = at_load(open_stored(folder / "maps"), [one["answers"][0]["at"]["load"]], tau0=[0.0])
    expected = at["friction_coefficient"].sel(direction=30.0, sliding="all", statistic="mean").squeeze()
    assert one["answers"][0]["rules"][0]["value"] == pytest.approx(float(expected))


def test_at_accepts_lists_as_pair_does(folder):
    arguments = ("at", "study", "--tau0", "0 MPa,100 MPa", "--json")
    lists = json.loads(said(*arguments, "--load", "1 uN,2 uN", "--mu0", "0.3,0.4", "--d", "1.3,1.0", cwd=folder))
    once = json.loads(said(*arguments, "--load", "1 uN", "--load", "2 uN", "--mu0", "0.4", "--d", "1", cwd=folder))
    conditions = [one["at"] for one in lists["answers"]]
    assert len(conditions) == 2 * 2 * 2 * 2
    assert sorted({one["load"] for one in conditions}) == pytest.approx([1e-3, 2e-3])
    assert len({one["fractal_dimension"] for one in conditions}) == 2
    values = {json.dumps(one["at"]): one["rules"] for one in lists["answers"]}
    assert all(values[json.dumps(one["at"])] == one["rules"] for one in once["answers"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("study", "--load", "-1 mN", "--mu0", "0.3"), ["--load must be above 0"]),
        (("study", "--load", "1 mN", "--mu0", "-0.3"), ["--mu0 must be at least 0"]),
        (("study", "--load", "1 mN", "--tau0", "-1 MPa"), ["--tau0 must be at least 0"]),
        (("study", "--load", "1 um"), ["--load"]),
        (("study", "--load", "1 MPa"), ["--load of a study must be a force"]),
        (("study",), ["give --load: the study has no loads"]),
        (("study", "--load", "1 mN", "--mu0", "0,2"), ['write "0.2" for one number or "0, 2" for two']),
        (("study", "--load", "0,5 mN"), ['"0.5"']),
        (("maps", "--load", "3,5 MPa"), ['"3.5"']),
        (("maps", "--load", "0"), ["--load must be above 0, got '0'; a load of 0 is for bodies that adhere"]),
        (("lines", "--load", "1 mN", "--d", "1.3"), ["--d is for studies"]),
        (("study", "--load", "1 mN", "--d", "flat"), ["--d must be a number or several"]),
        (("maps", "--load", "1 mN", "--amplitude", "1 um"), ["--amplitude is for studies"]),
        (("maps", "--load", "1 mN", "--direction", "31"), ["--direction must be a direction of"]),
        (("nowhere", "--load", "1 mN"), ["nowhere: no such directory"]),
    ],
)
def test_at_names_the_option_that_it_rejects(folder, arguments, words):
    assert_rejected(call_stiction("at", *arguments, cwd=folder), *words)


# ---- info, export, run, plot -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["study", "lines", "maps"])
def test_info_has_the_same_schema_for_every_result(folder, name):
    record = json.loads(said("info", name, "--json", cwd=folder))
    assert list(record)[:3] == ["schema", "stiction", "command"]
    assert (record["schema"], record["command"]) == (SCHEMA, "info")
    assert record["finished"] == record["repetitions"] == open_stored(folder / name).study.ensemble.repetitions
    assert record["values"]
    assert all({"verdict", "caveats", "sentence"} <= set(one) for one in record["answers"])
    assert said("report", name, "--output", f"{name}.html", cwd=folder)
    text = said("info", name, cwd=folder)
    assert f"{record['finished']} of {record['repetitions']} finished" in text
    if name == "study":
        assert text.count("μ_s [95 %] at ") == 2, "a table for each amplitude"
        assert "D" in text
    assert f"\n{record['answers'][0]['verdict']}" in text or " (1 of 2)" in text
    if name == "study":
        return
    loads = [one["at"]["load"] for one in record["answers"]]
    assert loads == sorted(loads), "those of a pair need not rise"
    assert len(set(loads)) == {"maps": 2, "lines": 1}[name]


def test_scale_heights_computes_on_request_and_prints_table_or_json(folder, tmp_path):
    shutil.copytree(folder / "maps", tmp_path / "maps")
    arguments = ("at", "maps", "--scale-heights", "0.5,1,2", "--load", "10 MPa", "--mu0", "0.25")
    assert_rejected(
        call_stiction(*arguments, cwd=tmp_path),
        "--scale-heights needs 2 factors from 0.5 to 2 computed, about ", "give --compute",
    )  # fmt: skip
    text = said(*arguments, "--compute", cwd=tmp_path)
    rows = [line.split() for line in text.splitlines() if line[:1].isdigit()]
    assert [row[0] for row in rows[:3]] == ["0.5", "1", "2"]
    assert said(*arguments, cwd=tmp_path) == text
    record = json.loads(said(*arguments, "--json", cwd=tmp_path))
    assert (record["kind"], record["scaled"], record["solved"]) == ("pair", "both", [0.5, 1.0, 2.0])
    load = 10e-3 * record["nominal_area"]
    at = open_result(tmp_path / "maps").at(load, mu0=0.25, height_scale=[0.5, 1, 2])
    names = {value["name"] for value in record["values"]}
    assert {"friction_combined", "contact_area_fraction", "rms_gradient", "upper_rms", "lower_rms"} <= names
    for value in record["values"]:
        if value["name"] == "friction_combined":
            where = {name: value["at"][name] for name in ("height_scale", "tau0", "sliding")}
            assert value["value"] == pytest.approx(
                float(at["friction_combined"].sel(where | {"statistic": "mean"}).item())
            )
    assert "height_scale" in said("plot", "maps", "--output", "figures", cwd=tmp_path)


@pytest.mark.parametrize(
    ("name", "arguments", "words"),
    [
        ("maps", ("--scale-heights", "0"), "--scale-heights must be from 0.01 to 100, got '0'"),
        ("maps", ("--scale-heights=-1",), "--scale-heights must be from 0.01 to 100, got '-1'"),
        ("maps", ("--scale-heights", "a..b"), "--scale-heights must be factors"),
        ("maps", ("--scale-heights", "4..0.25"), "--scale-heights must be factors"),
        ("maps", ("--scale-heights", "x"), "--scale-heights must be"),
        ("maps", ("--scale-heights", "2", "--scaled", "left"), "scaled must be one of"),
        ("maps", ("--scale-heights", "2", "--direction", "0"), "--direction cannot be combined with --scale-heights"),
        ("maps", ("--scaled", "upper"), "--scaled requires --scale-heights"),
        ("maps", ("--compute",), "--compute requires --scale-heights"),
        ("study", ("--scale-heights", "2", "--load", "1 uN"), "--scale-heights needs two measured surfaces"),
        ("study", ("--scale-heights", "2", "--load", "1 uN", "--compute"), "needs two measured surfaces"),
    ],
)  # fmt: skip
def test_scale_heights_rejects_bad_input(folder, name, arguments, words):
    assert_rejected(call_stiction("at", name, *arguments, cwd=folder), words)


@pytest.mark.parametrize("name", ["study", "lines", "maps"])
def test_export_writes_result_or_table(folder, name, tmp_path):
    said("export", name, str(tmp_path / "r.nc"), cwd=folder)
    with xarray.open_dataset(tmp_path / "r.nc", engine="h5netcdf") as exported:
        exported = exported.load()
    whole = open_stored(folder / name).dataset()
    assert set(whole.data_vars) == set(exported.data_vars)
    for variable in whole.data_vars:
        assert exported[variable].equals(whole[variable]), variable
    said("export", name, str(tmp_path / "r.csv"), cwd=folder)
    rows = list(csv.DictReader((tmp_path / "r.csv").read_text(encoding="utf-8").splitlines()))
    record = json.loads(said("info", name, "--json", cwd=folder))
    assert {row["verdict"] for row in rows} == {one["verdict"] for one in record["answers"]}
    for file in ("r.nc", "r.csv"):
        assert_rejected(call_stiction("export", name, str(tmp_path / file), cwd=folder), "exists already")
    for file in ("r.xlsx", "r"):
        assert_rejected(call_stiction("export", name, file, cwd=folder), "must end in .nc", ".csv")


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("name", ["lines", "maps"])
def test_run_extends_result_in_its_directory(folder, name, tmp_path):
    shutil.copytree(folder / name, tmp_path / name)
    total = open_stored(tmp_path / name).study.ensemble.repetitions
    said("run", str(tmp_path / name), "--set", f"ensemble.repetitions={total + 2}", cwd=folder)
    assert open_stored(tmp_path / name).finished.size == total + 2
    assert_rejected(call_stiction("run", str(tmp_path / name), "--set", "friction.mu0=[-1]", cwd=folder), "mu0")


def test_plot_uses_output_directory_and_formats(folder, tmp_path, monkeypatch):
    values = []

    def drawn(_, where, *, formats):
        values.append((where, formats))
        return [where / "a.pdf"]

    monkeypatch.setattr("stiction.views.figures.draw_figures", drawn)
    text = said("plot", "lines", "--output", str(tmp_path / "figures"), "--format", "pdf,svg", cwd=folder)
    assert text.splitlines() == [f"wrote {tmp_path / 'figures' / 'a.pdf'}"]
    assert values == [(tmp_path / "figures", ("pdf", "svg"))]
    assert_rejected(call_stiction("plot", "lines", "--format", "bmp", cwd=folder), "formats must be")
