"""Tests of `stiction shear` and of stored shear tests: output files, resumption, messages."""

import json
import re
import shutil
from dataclasses import replace

import numpy as np
import pandas
import pytest
import stiction.direct_shear
import xarray
from stiction import (
    Profile,
    Surface,
    export_shear_test,
    flipped,
    interface,
    open_result,
    read_surface,
    self_affine_surface,
    shear_gap,
    shear_test,
)
from stiction.evaluate.shear_intervals import list_variations
from stiction.solve import members_in_progress
from stiction.solve.store import export
from stiction.views.figures.shear import shear_figure
from stiction.views.shear import list_caveats, shear_text
from support.command import assert_rejected, call_stiction, check_stiction

MAP_SHAPE = (48, 48)
SHEAR_OPTIONS = ("--unit", "um", "--spacing", "50 um", "--load", "1 MPa", "--young", "30 GPa", "--poisson", 0.25)
LOAD_AND_ELASTICITY = {"load": "1 MPa", "young": "30 GPa", "poisson": 0.25}


def create_faces():
    lower = self_affine_surface(
        4, hurst_exponent=0.8, rms=20.0, shape=MAP_SHAPE, spacing=50.0, shortest_wavelength=300.0
    )
    return Surface(flipped(lower).heights, spacing=lower.spacing), lower


def save_faces(directory):
    for name, face in zip(("upper.npy", "lower.npy"), create_faces(), strict=True):
        np.save(directory / name, face.heights)


@pytest.fixture
def directory(tmp_path):
    save_faces(tmp_path)
    return tmp_path


def run_shear(directory, *options, **settings):
    return check_stiction(
        "shear", "upper.npy", "lower.npy", *SHEAR_OPTIONS, *options, cwd=directory, columns=80, **settings
    )


# ---- Output ----------------------------------------------------------------------------------------------------------


def test_shear_command_prints_peak_and_table_and_writes_four_files(directory):
    completed = run_shear(directory, "--path", "0.5 mm", "--mu0", "0.5..0.7", "--hardness", "150 MPa", "--steps", 5)
    lines = completed.stdout.splitlines()
    assert lines[0].startswith("peak: μ = ")
    assert lines[0].endswith("°)")
    assert lines[1].startswith("dilation angle at the peak: ")
    assert lines[2].startswith("end:  μ = ")
    assert lines[2].endswith("µm")
    assert "95 % intervals: μ0" in lines
    assert max(map(len, lines)) <= 80
    assert sum(line.startswith(("0 ", "100 ", "200 ", "300 ", "400 ", "500 ")) for line in lines) == 6
    test = shear_test(
        *create_faces(), path="0.5 mm", steps=5, mu0="0.5..0.7", hardness="150 MPa", **LOAD_AND_ELASTICITY
    )
    table = np.genfromtxt(directory / "shear/shear.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    np.testing.assert_allclose(table["mu"], test.friction_coefficient, rtol=1e-6)
    np.testing.assert_allclose(table["shear_stress_MPa"], 1e3 * test.shear_stress, rtol=1e-6)
    assert (table["mu_lower"] < table["mu"]).all()
    stored_test = xarray.load_dataset(directory / "shear/shear.nc", engine="h5netcdf")
    xarray.testing.assert_allclose(stored_test.drop_attrs(), test.drop_attrs())
    assert (directory / "shear/shear.png").read_bytes()[1:4] == b"PNG"
    report = (directory / "shear/report.html").read_text()
    assert "upper.npy on lower.npy" in report
    assert lines[0].removeprefix("peak: ") in report
    assert report.count("<tr>") == 7


def test_shear_command_prints_json_with_peak_and_curve(directory):
    completed = run_shear(directory, "--path", "0.5 mm", "--mu0", 0.6, "--steps", 5, "--json", without_figures=True)
    record = json.loads(completed.stdout)
    assert (record["command"], record["kind"]) == ("shear", "shear")
    peak, displacement, *_ = record["values"]
    assert (peak["name"], peak["kind"], peak["lower"]) == ("peak_friction_coefficient", "", None)
    curve = [value for value in record["values"] if value["name"] == "friction_coefficient"]
    assert [value["at"]["displacement"] for value in curve] == [0, 100, 200, 300, 400, 500]
    assert max(value["value"] for value in curve) == peak["value"]
    assert displacement["value"] in (100, 200, 300, 400, 500)
    assert any("upper limit" in caveat for caveat in record["caveats"])


def test_shear_command_accepts_profiles_in_the_opposite_direction(tmp_path):
    _, lower = create_faces()
    for name, heights in (("upper.csv", -lower.heights[3]), ("lower.csv", lower.heights[3])):
        x = 0.05 * np.arange(heights.size)
        np.savetxt(tmp_path / name, np.c_[x, heights / 1e3], delimiter=",", header="x (mm),z (mm)", comments="")
    completed = check_stiction(
        "shear", "upper.csv", "lower.csv", "--path", "0.5 mm", "--direction", 180, "--mu0", 0.6, *SHEAR_OPTIONS[4:],
        cwd=tmp_path, without_figures=True,
    )  # fmt: skip
    assert "peak: μ = " in completed.stdout
    assert "u (" in completed.stdout


def test_shear_table_marks_displacements_at_which_the_face_slides_by_itself():
    x = np.arange(256) / 256
    tooth = Profile(10 * np.abs((2 * x) % 1 - 0.5), spacing=100 / 256)
    upper = Profile(-tooth.heights, spacing=tooth.spacing)
    test = shear_test(
        upper, tooth, path="40 um", steps=8, mu0=0.05, load="1 MPa", effective_modulus="30 GPa", boundary="periodic"
    )
    assert "slides by itself" in shear_text(test)
    assert any("the faces slide by themselves." in caveat for caveat in list_caveats(test))


# ---- Storage ---------------------------------------------------------------------------------------------------------


class Interruption:
    """Progress function that raises `KeyboardInterrupt` at a given step."""

    def __init__(self, step):
        self.step, self.calls = step, []

    def __call__(self, done, total):
        self.calls.append(done)
        if done == self.step:
            raise KeyboardInterrupt


def count_solved_contacts(monkeypatch):
    from stiction.mechanics import shear

    calls = []
    solve = shear.half_space
    monkeypatch.setattr(shear, "half_space", lambda *bodies, **options: calls.append(1) or solve(*bodies, **options))
    return calls


def test_shear_test_interrupted_while_solving_resumes_with_identical_results(tmp_path, monkeypatch):
    monkeypatch.setattr(members_in_progress, "STORAGE_INTERVAL", -1.0)
    options = {"path": "0.5 mm", "steps": 10, "mu0": 0.6, "hardness": "200 MPa"} | LOAD_AND_ELASTICITY
    uninterrupted_test = shear_test(*create_faces(), **options)
    with pytest.raises(KeyboardInterrupt):
        shear_test(*create_faces(), directory=tmp_path / "test", progress=Interruption(7), **options)
    solved_contacts = count_solved_contacts(monkeypatch)
    resumed_test = shear_test(*create_faces(), directory=tmp_path / "test", **options)
    assert 0 < len(solved_contacts) < 16
    xarray.testing.assert_identical(resumed_test.drop_attrs(), uninterrupted_test.drop_attrs())
    assert [path.name for path in (tmp_path / "test").iterdir()] == ["shear.nc"]
    solved_contacts.clear()
    opened_test = shear_test(*create_faces(), directory=tmp_path / "test", **options)
    assert not solved_contacts
    np.testing.assert_array_equal(opened_test.friction_coefficient, uninterrupted_test.friction_coefficient)


def test_shear_test_interrupted_while_computing_intervals_resumes_with_identical_results(tmp_path, monkeypatch):
    monkeypatch.setattr(members_in_progress, "STORAGE_INTERVAL", -1.0)
    options = {"path": "0.2 mm", "steps": 2, "mu0": 0.6, "hardness": "150..250 MPa", **LOAD_AND_ELASTICITY}
    lower = self_affine_surface(
        4, hurst_exponent=0.8, rms=20.0, shape=(128, 128), spacing=50.0, shortest_wavelength=300.0
    )
    faces = Surface(flipped(lower).heights, spacing=lower.spacing), lower
    interruption = Interruption(17)
    with pytest.raises(KeyboardInterrupt):
        shear_test(*faces, directory=tmp_path / "test", progress=interruption, **options)
    uninterrupted_test = shear_test(*faces, progress=(counts := Interruption(-1)), **options)
    # Seven shear curves are computed: the test itself, the tests at two limits of the hardness, and four strips.
    assert sorted(set(counts.calls)) == list(range(3 * 7 + 1))
    solved_contacts = count_solved_contacts(monkeypatch)
    resumed_test = shear_test(*faces, directory=tmp_path / "test", **options)
    assert 0 < len(solved_contacts) < 20
    xarray.testing.assert_identical(resumed_test.drop_attrs(), uninterrupted_test.drop_attrs())
    assert {name: value for name, value in resumed_test.attrs.items() if name != "key"} == pytest.approx(
        uninterrupted_test.attrs, nan_ok=True
    )


def test_shear_test_does_not_reuse_steps_stored_by_another_version_of_the_module_that_computes_steps(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(members_in_progress, "STORAGE_INTERVAL", -1.0)
    options = {"path": "0.5 mm", "steps": 4, "mu0": 0.6, "directory": tmp_path / "test"} | LOAD_AND_ELASTICITY
    with pytest.raises(KeyboardInterrupt):
        shear_test(*create_faces(), progress=Interruption(2), **options)
    (steps_directory,) = (tmp_path / "test/in_progress").iterdir()
    first_module, *other_modules = stiction.direct_shear._STEP_MODULES
    changed_module = tmp_path / first_module.name
    changed_module.write_bytes(first_module.read_bytes() + b"# changed\n")
    monkeypatch.setattr(stiction.direct_shear, "_STEP_MODULES", (changed_module, *other_modules))
    with pytest.warns(UserWarning, match=f"{steps_directory.name}: steps of a shear test that was interrupted"):
        shear_test(*create_faces(), **options)
    assert list((tmp_path / "test/in_progress").iterdir()) == [steps_directory]


def test_shear_test_does_not_reuse_stored_steps_if_the_limits_of_an_uncertain_input_have_changed(tmp_path, monkeypatch):
    monkeypatch.setattr(members_in_progress, "STORAGE_INTERVAL", -1.0)
    options = {"path": "0.2 mm", "steps": 2, "mu0": 0.6, "hardness": "150..250 MPa", **LOAD_AND_ELASTICITY}
    options |= {"strips": 0, "directory": tmp_path / "test"}
    with pytest.raises(KeyboardInterrupt):
        shear_test(*create_faces(), progress=Interruption(5), **options)
    (steps_directory,) = (tmp_path / "test/in_progress").iterdir()

    def list_other_variations(samples):
        return [replace(variation, ratio=1.01 * variation.ratio) for variation in list_variations(samples)]

    monkeypatch.setattr(stiction.direct_shear, "list_variations", list_other_variations)
    with pytest.warns(UserWarning, match=f"{steps_directory.name}: steps of a shear test that was interrupted"):
        shear_test(*create_faces(), **options)


STORED_TEST_OPTIONS = {"path": "0.5 mm", "steps": 2, "mu0": 0.6} | LOAD_AND_ELASTICITY


@pytest.fixture(scope="module")
def stored_test_directory(tmp_path_factory):
    """Return the directory of a shear test with the options `STORED_TEST_OPTIONS`; tests must copy it."""
    directory = tmp_path_factory.mktemp("stored") / "test"
    shear_test(*create_faces(), **STORED_TEST_OPTIONS, directory=directory)
    return directory


@pytest.mark.parametrize(
    "changed",
    [
        {"mu0": 0.5},
        {"path": "0.4 mm"},
        {"load": "2 MPa"},
        {"hardness": "1 GPa"},
        {"direction": 180},
        {"tilt": "free"},
        {"mu0": "0.5..0.7"},
        {"mu0": None, "interface": "MoS2 on bearing steel, dry air"},
    ],
)
def test_shear_test_replaces_another_shear_test_in_its_directory_only_on_request(
    tmp_path, stored_test_directory, changed
):
    options = STORED_TEST_OPTIONS | {"directory": shutil.copytree(stored_test_directory, tmp_path / "test")}
    with pytest.raises(ValueError, match="contains another shear test; choose another directory"):
        shear_test(*create_faces(), **options | changed)
    replacing_test = shear_test(*create_faces(), **options | changed, replace=True)
    assert replacing_test.attrs["key"] == shear_test(*create_faces(), **options | changed).attrs["key"]


# ---- Messages --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--path", "5 mm"), "sliding path must leave an overlap of at least 16 points along each axis, got 5000 µm"),
        (("--path", "2 s"), "path"),
        (("--path", "0.5 mm", "--normal-stiffness", "5 GPa"), "--normal-stiffness must be a pressure per length"),
        (("--path", "0.5 mm", "--hardness", "2..1 GPa"), "--hardness must be a range from a smaller to a larger value"),
        (("--path", "0.5 mm", "--interface", "tar"), "--mu0 must not be combined with --interface, which contains mu0"),
        (("--path", "0.5 mm", "--lower", "tar"), "--lower must be the name of a known material"),
        (("--path", "0.5 mm", "--strips", "2.5"), "--strips"),
        (("--path", "0.5 mm", "--strips", 9), "--strips must be 0, or from 2 to 3 for these faces and this path"),
        (("--path", "0.5 mm", "--tilt", "loose"), "tilt must be one of 'fixed', 'free', got 'loose'"),
        (("--path", "0.5 mm", "--mu0", "-1"), "--mu0 must be finite and from 0 to 1e+06, got '-1'"),
        (("--path", "0.5 mm", "--output", "lower.npy"), "lower.npy must be a directory"),
    ],
)  # fmt: skip
def test_shear_command_rejects_invalid_options_with_a_one_line_error(directory, options, message):
    options = options if "--mu0" in options else (*options, "--mu0", 0.6)
    assert_rejected(call_stiction("shear", "upper.npy", "lower.npy", *SHEAR_OPTIONS, *options, cwd=directory), message)


def test_shear_command_rejects_a_directory_with_another_test(directory):
    for mu0 in (0.6, 0.5):
        completed = call_stiction(
            "shear", "upper.npy", "lower.npy", *SHEAR_OPTIONS, "--path", "0.2 mm", "--steps", 1, "--mu0", mu0,
            cwd=directory, without_figures=True,
        )  # fmt: skip
    assert_rejected(completed, "shear contains another shear test;", "or overwrite the test with --replace")


# ---- Export ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def computed_rough_directory(tmp_path_factory):
    """Return a directory with the files and the shear test of two faces that differ by noise; tests must copy it."""
    directory = tmp_path_factory.mktemp("rough")
    save_faces(directory)
    noise = np.random.default_rng(3).normal(0, 0.5, MAP_SHAPE)
    np.save(directory / "upper.npy", np.load(directory / "upper.npy") + noise)
    run_shear(
        directory, "--path", "0.2 mm", "--steps", 2, "--mu0", "0.5..0.7", "--hardness", "300 MPa", without_figures=True
    )
    return directory


@pytest.fixture
def rough_directory(tmp_path, computed_rough_directory):
    """Return a copy of the directory with the shear test of two faces that differ by noise."""
    return shutil.copytree(computed_rough_directory, tmp_path, dirs_exist_ok=True)


def export_shear(directory, *arguments):
    check_stiction("export", "shear", *arguments, cwd=directory)
    return directory / arguments[0]


@pytest.mark.parametrize("name", ["gap.npy", "gap.csv"])
def test_exported_gap_is_read_by_pair_without_unit_and_spacing(rough_directory, name):
    gap = read_surface(export_shear(rough_directory, name, "--gap"))
    test = xarray.load_dataset(rough_directory / "shear/shear.nc", engine="h5netcdf")
    np.testing.assert_array_equal(gap.heights, test["gap"].values)
    assert gap.spacing == (50.0, 50.0)
    check_stiction(
        "pair", "--gap", name, "--young", "30 GPa", "--poisson", 0.25, "--hardness", "300 MPa", "--mu0", 0.6,
        "--load", "1 MPa", "--cutoff", "none", "--onset", 0, cwd=rough_directory, without_figures=True,
    )  # fmt: skip
    result = open_result(rough_directory / "pair").at()
    for quantity in ("closure", "closure_stiffness"):
        value = float(result[quantity].sel(statistic="mean").values.flat[0])
        assert value == pytest.approx(float(test[quantity][-1]), rel=1e-3)


def test_exported_parameters_contain_the_printed_peak_and_the_stiffness_at_each_stress(rough_directory):
    table = pandas.read_csv(export_shear(rough_directory, "parameters.csv", "--joint"))
    test = xarray.load_dataset(rough_directory / "shear/shear.nc", engine="h5netcdf")
    np.testing.assert_allclose(table["normal stress (MPa)"], 1e3 * test["normal_stress"], rtol=1e-8)
    np.testing.assert_allclose(table["closure (mm)"], 1e-3 * test["closure"], rtol=1e-8)
    np.testing.assert_allclose(table["stiffness of closure (MPa/mm)"], test["closure_stiffness"], rtol=1e-8)
    last_row, attributes = table.iloc[-1], test.attrs
    for title, limit in (("", ""), (": lower", "_lower"), (": upper", "_upper")):
        coefficient = attributes[f"peak{limit}"]
        assert last_row[f"peak friction coefficient{title}"] == pytest.approx(coefficient)
        assert last_row[f"peak friction angle (deg){title}"] == pytest.approx(np.degrees(np.arctan(coefficient)))
        stress = attributes[f"peak_shear_stress_GPa{limit}"]
        assert last_row[f"shear strength (MPa){title}"] == pytest.approx(1e3 * stress)
    assert last_row["dilation angle at the peak (deg)"] == pytest.approx(attributes["peak_dilation_angle_deg"])
    assert last_row["dilation at the end (mm)"] == pytest.approx(1e-3 * float(test["dilation"][-1]))
    assert last_row["Z2"] == pytest.approx(attributes["z2"])
    assert (table["closure counted from (MPa)"] == 0).all()
    assert table["intervals"].unique().tolist() == ["95 % intervals: μ0"]
    assert table["peak friction angle (deg)"][:-1].isna().all()
    ratio = last_row["shear strength (MPa)"] / last_row["normal stress at the shear strength (MPa)"]
    assert ratio == pytest.approx(last_row["peak friction coefficient"], rel=1e-3)


def test_exported_parameters_state_that_they_have_no_intervals_if_inputs_are_exact(tmp_path):
    options = {"path": "0.2 mm", "steps": 2, "mu0": 0.6, "hardness": "300 MPa", **LOAD_AND_ELASTICITY}
    test = shear_test(*create_faces(), **options)
    for ending in ("csv", "json"):
        export_shear_test(test, tmp_path / f"parameters.{ending}", joint=True)
    table = pandas.read_csv(tmp_path / "parameters.csv")
    assert not [title for title in table if title.endswith((": lower", ": upper"))]
    record = json.loads((tmp_path / "parameters.json").read_text(encoding="utf-8"))
    (text,) = table["intervals"].unique()
    assert text == record["intervals"]
    assert text.startswith("no intervals")
    assert any("error of the model" in note for note in record["notes"])


def test_exported_shear_strength_and_normal_stress_are_at_one_displacement(tmp_path):
    options = {"path": "0.4 mm", "steps": 4, "mu0": 0.6, "hardness": "150 MPa", **LOAD_AND_ELASTICITY}
    test = shear_test(*create_faces(), normal_stiffness="20 MPa/mm", **options)
    assert int(np.argmax(test["friction_coefficient"].values)) < 4
    export_shear_test(test, tmp_path / "parameters.csv", joint=True)
    last_row = pandas.read_csv(tmp_path / "parameters.csv").iloc[-1]
    assert last_row["displacement at the shear strength (mm)"] == pytest.approx(0.4)
    assert last_row["shear strength (MPa)"] == pytest.approx(1e3 * float(test["shear_stress"][4]))
    ratio = last_row["shear strength (MPa)"] / last_row["normal stress at the shear strength (MPa)"]
    assert ratio == pytest.approx(float(test["friction_coefficient"][4]))
    assert ratio < 0.99 * last_row["peak friction coefficient"]


def test_exported_parameters_in_json_have_units_and_inputs_and_caveats(rough_directory):
    file = export_shear(rough_directory, "parameters.json", "--joint", "--units", "m,N,Pa")
    record = json.loads(file.read_text(encoding="utf-8"))
    test = xarray.load_dataset(rough_directory / "shear/shear.nc", engine="h5netcdf")
    assert (record["kind"], record["units"]) == ("shear_joint", {"length": "m", "force": "N", "pressure": "Pa"})
    assert record["inputs"]["mu0"] == "0.5..0.7"
    assert record["caveats"] == list_caveats(test)
    (strength,) = [value for value in record["values"] if value["name"] == "peak_shear_stress"]
    assert (strength["unit"], strength["kind"]) == ("Pa", "combined")
    assert strength["value"] == pytest.approx(1e9 * test.attrs["peak_shear_stress_GPa"])
    stiffnesses = [value for value in record["values"] if value["name"] == "closure_stiffness"]
    np.testing.assert_allclose([value["value"] for value in stiffnesses], 1e9 * test["closure_stiffness"])
    assert stiffnesses[-1]["at"]["normal_stress"] == pytest.approx(1e6)


def test_exported_curve_and_dataset_are_those_of_the_shear_test(rough_directory):
    curve = export_shear(rough_directory, "curve.csv").read_text()
    assert curve == (rough_directory / "shear/shear.csv").read_text()
    dataset = xarray.load_dataset(export_shear(rough_directory, "all.nc"), engine="h5netcdf")
    stored_dataset = xarray.load_dataset(rough_directory / "shear/shear.nc", engine="h5netcdf")
    xarray.testing.assert_identical(dataset.drop_attrs(), stored_dataset.drop_attrs())


def test_export_command_rejects_options_that_do_not_apply_to_shear_tests(rough_directory):
    for arguments, message in (
        (("x.inp", "--joint"), "must end in .csv"),
        (("x.tex",), "must end in .nc (the whole test) or .csv (the curve)"),
        (("x.txt", "--gap"), "must end in .npy (a NumPy array) or .csv (a matrix)"),
        (("x.csv", "--joint", "--closure-from", "1 MPa"), "--closure-from does not apply to shear tests"),
        (("x.csv", "--load", "1 MPa"), "--load does not apply to shear tests; remove --load 1 MPa"),
        (("x.csv", "--units", "m,N,Pa"), "--units requires --joint"),
        (("x.csv", "--joint", "--gap"), "--joint cannot be combined with --gap"),
        (("upper.npy", "--gap"), "upper.npy"),
    ):
        assert_rejected(call_stiction("export", "shear", *arguments, cwd=rough_directory), message)


def test_result_is_exported_although_its_directory_contains_an_export_named_like_a_shear_test(rough_directory):
    export_shear(rough_directory, "gap.npy", "--gap")
    check_stiction(
        "pair", "--gap", "gap.npy", "--effective-modulus", "16 GPa", "--mu0", 0.6, "--load", "1 MPa",
        "--cutoff", "none", "--onset", 0, cwd=rough_directory, without_figures=True,
    )  # fmt: skip
    check_stiction("export", "pair", "pair/shear.nc", cwd=rough_directory)
    check_stiction("export", "pair", "pair.csv", cwd=rough_directory)
    (rough_directory / "pair/shear.nc").write_bytes(b"of the user")
    check_stiction("export", "pair", "again.csv", cwd=rough_directory)
    assert (rough_directory / "again.csv").read_bytes() == (rough_directory / "pair.csv").read_bytes()


def test_shear_and_export_commands_reject_a_directory_with_a_file_of_another_origin(rough_directory):
    options = ("--path", "0.2 mm", "--steps", 1, "--mu0", 0.6)
    shear_arguments = ("shear", "upper.npy", "lower.npy", *SHEAR_OPTIONS, *options, "-o", "other")
    (rough_directory / "other").mkdir()
    file = rough_directory / "other/shear.nc"
    file.write_bytes(b"of the user")
    for arguments in (("export", "other", "x.csv"), shear_arguments):
        message = "other/shear.nc was not written by stiction shear; move the file, or choose another directory"
        assert_rejected(call_stiction(*arguments, cwd=rough_directory), message)
    file.unlink()
    export(xarray.Dataset({"height": 1.0}), file)
    for arguments in (("export", "other", "x.csv"), shear_arguments):
        assert_rejected(call_stiction(*arguments, cwd=rough_directory), "other/shear.nc contains no shear test;")


def test_shear_test_of_an_earlier_version_is_opened_but_has_no_gap_to_export(tmp_path):
    options = {"path": "0.5 mm", "steps": 1, "mu0": 0.6, "directory": tmp_path / "shear", **LOAD_AND_ELASTICITY}
    test = shear_test(*create_faces(), **options)
    new_names = ["gap", "closure", "closure_stiffness"]
    old_test = test.drop_vars([*new_names, "gap_y", "gap_x", "normal_stress"])
    export(old_test, tmp_path / "shear/shear.nc", replace=True)
    xarray.testing.assert_identical(shear_test(*create_faces(), **options).drop_attrs(), old_test.drop_attrs())
    assert "stiffness" not in shear_text(old_test)
    remedy = "repeat the test with stiction shear --replace, or with shear_test(..., replace=True)"
    assert_rejected(call_stiction("export", "shear", "gap.npy", "--gap", cwd=tmp_path), remedy)
    with pytest.raises(ValueError, match=re.escape(remedy)):
        shear_gap(old_test)
    assert "gap" in shear_test(*create_faces(), **options, replace=True)


# ---- Caveats ---------------------------------------------------------------------------------------------------------


def test_shear_command_does_not_replace_a_file_of_the_user(directory):
    (directory / "shear").mkdir()
    (directory / "shear/shear.csv").write_text("displacement (um),mu\n1,2\n")
    completed = call_stiction(
        "shear", "upper.npy", "lower.npy", *SHEAR_OPTIONS, "--path", "0.5 mm", "--mu0", 0.6, cwd=directory
    )
    assert_rejected(completed, "was not written by stiction")
    assert (directory / "shear/shear.csv").read_text() == "displacement (um),mu\n1,2\n"


def test_shear_test_rejects_the_directory_of_a_study_and_leaves_it_unchanged(tmp_path):
    (tmp_path / "study.toml").write_text("")
    steps = tmp_path / "in_progress/0000000-0123456789abcdef"
    steps.mkdir(parents=True)
    options = {"path": "0.5 mm", "steps": 1, "mu0": 0.6, **LOAD_AND_ELASTICITY}
    with pytest.raises(ValueError, match="contains the result of a study; choose another directory"):
        shear_test(*create_faces(), directory=tmp_path, **options)
    assert steps.exists()


@pytest.mark.parametrize("name", ["file", "file/folder"])
def test_shear_test_rejects_a_directory_that_cannot_be_created(tmp_path, name):
    (tmp_path / "file").write_text("")
    options = {"path": "0.5 mm", "steps": 1, "mu0": 0.6, **LOAD_AND_ELASTICITY}
    with pytest.raises(ValueError, match="file"):
        shear_test(*create_faces(), directory=tmp_path / name, **options)


def test_finished_shear_test_can_be_opened_by_other_versions_of_the_software(tmp_path, monkeypatch):
    options = {"path": "0.5 mm", "steps": 1, "mu0": 0.6, "directory": tmp_path, **LOAD_AND_ELASTICITY}
    test = shear_test(*create_faces(), **options)
    monkeypatch.setattr(np, "__version__", "99")
    xarray.testing.assert_identical(shear_test(*create_faces(), **options), test)


def test_shear_strength_is_the_largest_stress_even_if_the_coefficient_peaks_earlier():
    options = {"path": "0.4 mm", "steps": 4, "mu0": 0.6, "hardness": "150 MPa", **LOAD_AND_ELASTICITY}
    test = shear_test(*create_faces(), normal_stiffness="20 MPa/mm", **options)
    assert int(np.argmax(test.friction_coefficient.values)) < 4
    assert int(np.argmax(test.shear_stress.values)) == 4
    assert f"shear strength: {1e3 * float(test.shear_stress[4]):.3g} MPa at 400 µm" in shear_text(test)
    text = "The shear stress is largest at the end of the path, because the normal load rises: choose a longer path."
    assert text in list_caveats(test)


def test_shear_stress_that_rises_because_the_overlap_shrinks_has_a_caveat():
    lower = self_affine_surface(1, hurst_exponent=0.8, rms=20.0, shape=(32, 32), spacing=50.0)
    upper = Surface(-lower.heights[::-1], spacing=lower.spacing)
    test = shear_test(upper, lower, path="300 um", mu0=0.6, hardness="150 MPa", **LOAD_AND_ELASTICITY)
    assert int(np.argmax(test.shear_stress.values)) == test.sizes["displacement"] - 1
    assert list_caveats(test)[0] == (
        "The shear stress is largest at the end of the path, because the overlap shrinks: choose a shorter path, or "
        "shear longer faces."
    )


def test_shear_test_of_faces_that_do_not_fit_at_the_start_has_a_caveat_about_the_fit():
    upper, lower = create_faces()
    options = {"path": "0.5 mm", "steps": 1, "mu0": 0.6, **LOAD_AND_ELASTICITY}
    fitting, unrelated_face = (
        shear_test(face, lower, **options) for face in (upper, Surface(upper.heights[::-1, ::-1], spacing=50.0))
    )
    assert fitting.attrs["fit_correlation"] > 0.99
    assert abs(unrelated_face.attrs["fit_correlation"]) < 0.3
    assert "agree poorly where the path starts" in " ".join(list_caveats(unrelated_face))
    assert "agree poorly" not in " ".join(list_caveats(fitting))


@pytest.mark.parametrize("rule", ["all", "opposing"])
def test_shear_test_with_an_interface_calibrated_for_opposing_contacts_has_a_caveat(rule):
    film = interface("MoS2 on bearing steel, dry air")
    film = replace(film, fits=(replace(film.fits[0], sliding=rule),))
    test = shear_test(*create_faces(), path="0.5 mm", steps=1, interface=film, **LOAD_AND_ELASTICITY)
    assert test.attrs["interface_rule"] == rule
    assert any(
        "fit them with stiction calibrate --sliding all" in caveat_text for caveat_text in list_caveats(test)
    ) == (rule == "opposing")


def test_shear_test_repeats_the_caveats_of_its_interface():
    film = interface("MoS2 on bearing steel, dry air").with_caveats("do not quote", ["its tests contradict it"])
    test = shear_test(*create_faces(), path="0.5 mm", steps=1, interface=film, **LOAD_AND_ELASTICITY)
    assert any(text.startswith("Interface joint samples: its tests contradict it; ") for text in list_caveats(test))


def test_finished_shear_test_is_not_reused_after_caveats_or_ranges_of_its_interface_change(tmp_path):
    film = interface("MoS2 on bearing steel, dry air")
    fit = film.fits[0]
    scores = {"effective_modulus normal 9.608..10.39": np.linspace(-2, 2, fit.mu0.size)}
    options = {"path": "0.5 mm", "steps": 1, "load": "1 MPa", "effective_modulus": "10 GPa ± 2 %"}
    shear_test(*create_faces(), interface=film, directory=tmp_path / "test", **options)
    shear_test(*create_faces(), interface=film, directory=tmp_path / "test", **options)
    changed_films = (
        film.with_caveats("do not quote", ["its tests contradict it"]),
        replace(film, fits=(replace(fit, scores=scores),)),
    )
    for changed_film in changed_films:
        with pytest.raises(ValueError, match="contains another shear test"):
            shear_test(*create_faces(), interface=changed_film, directory=tmp_path / "test", **options)


@pytest.mark.parametrize(
    ("waviness", "noise", "caveat"),
    [
        (0.0, 0.0, None),
        (0.0, 2.0, None),
        (10.0, 0.5, "their gap (rms 5.85 µm) is larger than their noise"),
        (300.0, 0.0, "agree poorly even where"),
    ],
)
def test_gap_between_registered_faces_has_a_caveat_if_it_exceeds_the_noise_of_the_faces(waviness, noise, caveat):
    upper, lower = create_faces()
    unrelated_face = self_affine_surface(9, hurst_exponent=0.8, rms=1.0, shape=upper.heights.shape, spacing=50.0)
    change = 0.7 * waviness * unrelated_face.heights + np.random.default_rng(1).normal(0, noise, upper.heights.shape)
    changed_face = Surface(upper.heights + change, spacing=50.0)
    options = {"path": "0.5 mm", "steps": 1, "mu0": 0.6, "register": True, "strips": 0, **LOAD_AND_ELASTICITY}
    caveats = list_caveats(shear_test(changed_face, lower, **options))
    if caveat is None:
        assert not [text for text in caveats if "where" in text and "fit best" in text]
    else:
        assert caveat in caveats[0]


def test_shear_peak_of_perfectly_mated_faces_has_a_caveat_because_the_peak_precedes_displacement(directory):
    test = shear_test(*create_faces(), path="0.5 mm", steps=2, mu0=0.6, tau0="3 MPa", **LOAD_AND_ELASTICITY)
    assert test.attrs["peak_displacement_um"] == 0
    assert "The peak is before the faces move" in " ".join(list_caveats(test))


@pytest.mark.parametrize(
    ("noise", "steps", "remedy"),
    [
        (0.0, 2, "Report the peak with its spacing (50 µm), or scan both faces"),
        (0.5, 2, "use a finer scan"),
        (0.0, 1, "use more steps"),
    ],
)
def test_peak_at_the_first_displacement_has_a_caveat_whose_remedy_suits_the_fit_of_the_faces(noise, steps, remedy):
    upper, lower = create_faces()
    upper = Surface(upper.heights + np.random.default_rng(3).normal(0, noise, MAP_SHAPE), spacing=upper.spacing)
    options = {"mu0": 0.6, "hardness": "150 MPa", **LOAD_AND_ELASTICITY}
    test = shear_test(upper, lower, path="0.1 mm", steps=steps, **options)
    test = test.assign(friction_coefficient=("displacement", np.r_[0.5, 1.0, np.full(steps - 1, 0.9)]))
    (caveat,) = [caveat for caveat in list_caveats(test) if "The peak is at the first displacement" in caveat]
    assert remedy in caveat


def test_shear_test_has_caveats_about_missing_hardness_and_about_load_at_the_edges_of_faces():
    x = np.linspace(-1, 1, 201)
    bowl = Profile(40 * x**2, spacing=5.0)
    upper = Profile(-bowl.heights, spacing=5.0)
    text = " ".join(list_caveats(shear_test(upper, bowl, path="0.2 mm", steps=4, mu0=0.4, **LOAD_AND_ELASTICITY)))
    for words in ("at the edges of the faces", "The peak is at the first displacement", "Without a hardness"):
        assert words in text


def test_shear_coefficient_that_rises_until_the_end_of_the_path_has_a_caveat():
    x = np.linspace(0, 1, 201)
    ramp, pin = Profile(40 * x**2, spacing=5.0), Profile(40 * np.exp(-((10 * x - 2) ** 2)), spacing=5.0)
    test = shear_test(pin, ramp, path="0.3 mm", steps=4, mu0=0.4, level="none", **LOAD_AND_ELASTICITY)
    assert "The coefficient is largest at the end of the path: choose a longer path." in list_caveats(test)


def test_shear_test_of_faces_that_lock_prints_no_peak():
    steep_face = Profile(100 * np.abs(np.arange(512) / 512 % 0.25 - 0.125), spacing=100 / 512)
    locked_test = shear_test(
        Profile(-steep_face.heights, spacing=steep_face.spacing), steep_face, path="5 um", steps=2, mu0=1.5,
        boundary="periodic", **LOAD_AND_ELASTICITY,
    )  # fmt: skip
    assert any("the faces lock" in caveat for caveat in list_caveats(locked_test))
    assert not shear_text(locked_test).startswith("peak:")


def test_shear_test_of_faces_that_lock_is_printed_and_drawn():
    face = create_faces()[1]
    steep_face = Surface(20 * face.heights, spacing=face.spacing)
    test = shear_test(
        Surface(flipped(steep_face).heights, spacing=steep_face.spacing),
        steep_face,
        path="0.5 mm",
        steps=2,
        mu0=3.0,
        **LOAD_AND_ELASTICITY,
    )
    assert "locks" in shear_text(test)
    shear_figure(test).canvas.draw()


def test_shear_peak_with_few_contacts_has_a_caveat():
    _, lower = create_faces()
    options = {"path": "0.5 mm", "steps": 4, "mu0": 0.6, "hardness": "150 MPa", **LOAD_AND_ELASTICITY}
    profile = Profile(lower.heights[3], spacing=50.0)
    test = shear_test(Profile(-profile.heights, spacing=50.0), profile, **options)
    peak = int(np.argmax(test.friction_coefficient.values))
    assert test.contact_count[peak] < 10
    assert "so the result depends on chance" in " ".join(list_caveats(test))
    test_with_many_contacts = shear_test(*create_faces(), **options | {"load": "40 MPa"})
    assert (
        test_with_many_contacts.contact_count[int(np.argmax(test_with_many_contacts.friction_coefficient.values))] >= 10
    )
    assert "depends on chance" not in " ".join(list_caveats(test_with_many_contacts))


@pytest.mark.parametrize(
    ("mu0", "hardness", "has_caveat"),
    [(0.6, "150 MPa", True), (0.35, "150 MPa", False), (0.6, "1 TPa", False), (0.6, None, False)],
)
def test_shear_peak_has_a_caveat_if_asperities_shear_before_they_slide(mu0, hardness, has_caveat):
    options = {"path": "0.5 mm", "steps": 4, "mu0": mu0, "hardness": hardness} | LOAD_AND_ELASTICITY
    caveats = list_caveats(shear_test(*create_faces(), **options))
    assert any("shear before they slide, at a coefficient of about 0.36" in caveat for caveat in caveats) == has_caveat


@pytest.mark.parametrize(("tau0", "expected"), [("0.1 MPa", 0), ("1 MPa", 1)])
def test_shear_test_states_that_asperities_shear_first_if_tau0_raises_friction_above_the_limit(tau0, expected):
    # At half the hardness, contacts have a friction of 26.25 MPa plus τ0; the shear strength is 150 MPa/5.6 = 26.8 MPa.
    options = {"path": "0.1 mm", "steps": 1, "mu0": 0.35, "tau0": tau0, "hardness": "150 MPa"} | LOAD_AND_ELASTICITY
    assert shear_test(*create_faces(), **options).attrs["body_shears_first"] == expected


def test_shear_command_reprints_a_stored_shear_test_whose_faces_were_divided_into_strips(directory):
    options = ("--path", "0.2 mm", "--mu0", 0.6, "--hardness", "150 MPa", "--steps", 2, "--strips", 2)
    first_output, second_output = (run_shear(directory, *options).stdout for _ in range(2))
    assert "95 % intervals: scatter between 2 strips of the faces" in first_output
    assert second_output == first_output


def test_info_of_a_shear_test_states_where_its_values_are(directory):
    run_shear(directory, "--path", "0.5 mm", "--mu0", 0.6, "--steps", 1)
    assert_rejected(
        call_stiction("info", "shear", cwd=directory),
        "shear contains a shear test",
        "read shear.csv or shear.nc in this directory",
    )


def test_shear_peak_above_the_limit_of_rock_joints_has_a_caveat():
    face = create_faces()[1]
    steep_face = Surface(6 * face.heights, spacing=face.spacing)
    upper = Surface(flipped(steep_face).heights, spacing=steep_face.spacing)
    test = shear_test(upper, steep_face, path="0.5 mm", steps=2, mu0=0.6, hardness="150 MPa", **LOAD_AND_ELASTICITY)
    assert test.attrs["peak"] > 2.75
    assert list_caveats(test)[0].startswith("The peak is above 70°")
