"""What commands answer: tables, one point, JSON, and the help that leads to them."""

import csv
import json
import math
import os
import re
import shlex
from importlib import import_module

import numpy as np
import pytest
import typer
from command import assert_refused, stiction_command
from small import SMALL
from stiction import friction_map, run, self_affine, self_affine_surface, write_profile, write_surface
from stiction.cli.application import COMMANDS, app
from stiction.studies import store, traverse
from stiction.surfaces.pairing import paired_lines
from stiction.views import answers
from stiction.views.digits import with_interval
from stiction.views.records import SCHEMA
from stiction.views.traverse import BOTH, means

MATERIAL = ("--effective-modulus", "10 GPa", "--mu0", "0.3")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two scans, two maps, and a study."""
    path = tmp_path_factory.mktemp("answers")
    for side in ("upper", "lower"):
        scan = self_affine(1, hurst_exponent=0.8, rms=0.05, points=600, spacing=0.05, side=side)
        write_profile(scan, path / f"{side}.csv")
        rough = {"rms": 0.02, "shape": (24, 24), "spacing": 0.2, "shortest_wavelength": 0.8}
        write_surface(self_affine_surface(1, hurst_exponent=0.8, side=side, **rough), path / f"{side}.npy")
    study = SMALL.with_changes({"ensemble.repetitions": 4, "friction.tau0": ["0 MPa", "100 MPa"]})
    run(study, store=path / "study/result.zarr")
    return path


def said(*arguments, cwd):
    done = stiction_command(*arguments, cwd=cwd)
    assert done.returncode == 0, done.stderr
    return done.stdout


# ---- Studies ---------------------------------------------------------------------------------------------------------


def test_info_ends_in_a_table_of_the_coefficient_that_is_the_map(folder):
    text = said("info", "study", cwd=folder)
    dataset = store.read(folder / "study/result.zarr")
    found = answers.answers(dataset)
    assert found.sizes["tau0"] == 2
    table = text[text.index("mu_s [95 %]") :].splitlines()
    assert table[0].startswith(f"mu_s [95 %] at mu0 = {float(found['mu0'][0]):g}, tau0 = 0 MPa")
    for line, load in zip(table[2:], found["load"].values, strict=False):
        at = found.sel(load=load).isel(amplitude=0, mu0=0, tau0=0)
        same = friction_map(dataset, [load], mu0=found["mu0"].values, tau0=[0.0])
        for d, cell in enumerate(re.split(r"  +", line.strip())[1:]):
            one = at.isel(fractal_dimension=d)
            if str(one["status"].values) != "ok":
                assert cell == str(one["status"].values)
                continue
            values = [float(one[name]) for name in ("friction_coefficient", "lower", "upper")]
            assert cell.rstrip("*") == with_interval(*values)
            twin = same.sel(fractal_dimension=float(one["fractal_dimension"]), amplitude=float(found["amplitude"][0]))
            assert float(twin["friction_coefficient"].squeeze()) == values[0]


def test_run_ends_in_the_same_table(folder):
    again = said("run", "mine.toml", "--output", "study", cwd=_with_study_file(folder))
    table = said("info", "study", cwd=folder)
    assert again.rstrip().endswith(table[table.index("mu_s [95 %]") :].rstrip())


def _with_study_file(folder):
    (folder / "mine.toml").write_text(store.info(folder / "study/result.zarr").study.to_toml(), encoding="utf-8")
    return folder


def test_a_study_whose_pairs_do_not_touch_has_no_table(folder):
    nothing = store.read(folder / "study/result.zarr").map(lambda sums: 0 * sums, keep_attrs=True)
    assert answers.answers_text(nothing).startswith("mu_s         none: ")


def test_at_is_the_map_at_any_mu0_and_tau0(folder):
    arguments = ("at", "study", "--load", "1 uN", "--d", "1.3", "--mu0", "0.35", "--tau0", "20 MPa")
    record = json.loads(said(*arguments, "--json", cwd=folder))
    dataset = store.read(folder / "study/result.zarr")
    part = dataset.sel(fractal_dimension=[1.3], method="nearest")
    one = friction_map(part, [1e-3], mu0=[0.35], tau0=[0.02]).isel(amplitude=0).squeeze()
    first = record["values"][0]
    assert first["name"] == "friction_coefficient"
    assert first["value"] == float(one["friction_coefficient"])
    assert first["at"]["load"] == 1e-3
    assert {value["name"] for value in record["values"]} >= {"contact_area", "normal_stiffness", "share_beyond_hertz"}
    text = said(*arguments, cwd=folder)
    assert with_interval(*(float(one[name]) for name in ("friction_coefficient", "lower", "upper"))) in text


def test_at_says_why_there_is_no_answer(folder):
    assert "no answer: not-reached" in said("at", "study", "--load", "1 N", "--d", "1.3", "--mu0", "0.3", cwd=folder)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--load", "-1 mN", "--d", "1.3", "--mu0", "0.3"), ["--load must be above 0"]),
        (("--load", "1 mN", "--d", "1.3", "--mu0", "-0.3"), ["--mu0 and --tau0 must be at least 0"]),
        (("--load", "1 um", "--d", "1.3", "--mu0", "0.3"), ["--load"]),
    ],
)
def test_at_refuses_by_the_name_of_the_option(folder, arguments, words):
    assert_refused(stiction_command("at", "study", *arguments, cwd=folder), *words)


# ---- Measured surfaces -----------------------------------------------------------------------------------------------


def test_both_directions_are_the_mean_of_each_position(folder):
    uppers, lowers = paired_lines(*(_profile(folder, side) for side in ("upper", "lower")))
    offsets = np.arange(1.0, 13.0)
    result = traverse.traverse(uppers, lowers, [0.1, 1e9], offsets=offsets, mu0=0.3, effective_modulus=10.0)
    mean = means(result)
    assert mean["shear"].values.tolist() == [BOTH, "+x", "-x"]
    at = result.isel(load=0)
    assert (at["status"] == "ok").all()
    expected = at["friction_coefficient"].mean()
    assert float(mean["friction_coefficient"].sel(shear=BOTH, statistic="mean").isel(load=0)) == pytest.approx(
        float(expected), rel=1e-12
    )
    assert mean["ok"].isel(load=1).values.tolist() == [0, 0, 0]
    assert mean["ok"].isel(load=0).values.tolist() == [12, 12, 12]


def _profile(folder, side):
    from stiction import read_profile

    return read_profile(folder / f"{side}.csv")


@pytest.mark.usefixtures("undrawn")
def test_pair_ends_in_a_sentence_that_says_whether_to_quote_it(folder):
    pressed = ("pair", "upper.csv", "lower.csv", *MATERIAL, "--replace")
    light = said(*pressed, "--load", "0.1 mN", "--offsets", "16", cwd=folder)
    assert "In short: at 0.1 mN mu_s = " in light
    assert "both directions" in light
    heavy = " ".join(said(*pressed, "--load", "0.1 mN", "--offsets", "3", cwd=folder).split())
    assert "Do not quote it: there is no interval" in heavy
    assert "It holds if the softer body is harder than" in heavy
    none = said(*pressed, "--load", "1 N", "--offsets", "8", cwd=folder)
    assert "none of the positions has an answer" in none


# ---- JSON ------------------------------------------------------------------------------------------------------------


RECORDED = {
    "info": ("info", "study"),
    "characterise": ("characterise", "upper.csv", "lower.csv"),
    "characterise-map": ("characterise", "upper.npy", "--unit", "um", "--spacing", "0.2 um"),
    "pair": ("pair", "upper.csv", "lower.csv", *MATERIAL, "--load", "0.1 mN", "--offsets", "8", "-o", "json-pair"),
    "pair-maps": (
        "pair", "upper.npy", "lower.npy", "--unit", "um", "--spacing", "0.2 um", *MATERIAL, "--load", "10 MPa",
        "--shifts", "3", "--mechanics", "asperities", "--output", "json-maps",
    ),
}  # fmt: skip


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("name", RECORDED)
def test_json_has_one_schema(folder, name):
    record = json.loads(said(*RECORDED[name], "--json", cwd=folder))
    assert list(record)[:3] == ["schema", "stiction", "command"]
    assert record["schema"] == SCHEMA
    assert record["command"] == RECORDED[name][0]
    assert record["values"]
    for value in record["values"]:
        assert list(value) == ["name", "value", "unit", "lower", "upper", "at", "status"]
        assert value["value"] is None or math.isfinite(value["value"])
        if None not in (value["lower"], value["value"], value["upper"]):
            assert value["lower"] <= value["value"] * (1 + 1e-9) + 1e-12
            assert value["value"] <= value["upper"] * (1 + 1e-9) + 1e-12


@pytest.mark.usefixtures("undrawn")
def test_json_of_a_stored_pair_is_that_of_the_pair(folder):
    first = said(*RECORDED["pair"], "--replace", "--json", cwd=folder)
    assert json.loads(said("info", "json-pair", "--json", cwd=folder)) == json.loads(first)


def test_several_files_make_one_table(folder):
    assert "wrote finishes.csv, 2 files" in said(
        "characterise", "upper.csv", "lower.csv", "-o", "finishes.csv", cwd=folder
    )
    rows = list(csv.DictReader((folder / "finishes.csv").read_text(encoding="utf-8").splitlines()))
    record = json.loads(said("characterise", "upper.csv", "lower.csv", "--json", cwd=folder))
    for row in rows:
        values = {value["name"]: value for value in record["values"] if value["at"]["file"] == row["file"]}
        assert float(row["Pq (um)"]) == pytest.approx(values["Pq"]["value"], rel=1e-8)
        assert row["hurst_exponent"] == "" or float(row["hurst_exponent"]) == pytest.approx(
            values["hurst_exponent"]["value"], rel=1e-8
        )
    done = stiction_command("characterise", "upper.csv", "lower.csv", "-o", "finishes.csv", cwd=folder)
    assert_refused(done, "finishes.csv: exists already")


# ---- Help ------------------------------------------------------------------------------------------------------------


def commands():
    for module in {module for group in COMMANDS.values() for module, _ in group.values()}:
        import_module(f"stiction.cli.{module}")
    return typer.main.get_command(app).commands


@pytest.mark.parametrize("name", [name for group in COMMANDS.values() for name in group])
def test_help_has_examples_that_the_command_takes_and_exit_statuses(name):
    command = commands()[name]
    context = command.context_class(command, info_name=f"stiction {name}")
    text = command.get_help(context)
    assert "Exit status: 0 done" in text
    assert "{" not in text.splitlines()[0]
    assert not re.search(r" <\w+>", text)
    lines = re.findall(rf"^ +(stiction {name}.*)$", text, re.MULTILINE)
    assert lines
    for line in lines:
        words = shlex.split(line.partition(" > ")[0])[2:]
        command.make_context(name, [word for word in words if word != "*.csv"] + ["x.csv"] * ("*.csv" in words))


def test_a_shell_completes_commands_and_options(monkeypatch, tmp_path):
    for words, at, expected in (("stiction ru", "1", "run"), ("stiction pair --mu", "2", "--mu0")):
        for name, value in (("_STICTION_COMPLETE", "complete_bash"), ("COMP_WORDS", words), ("COMP_CWORD", at)):
            monkeypatch.setenv(name, value)
        assert os.environ["COMP_WORDS"] == words
        assert expected in stiction_command(cwd=tmp_path).stdout.split()


def test_studies_says_what_each_computes(tmp_path):
    for line in said("studies", cwd=tmp_path).splitlines():
        assert re.fullmatch(r"[\w-]+ +[A-Z][^#]+\.", line)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("info", "nowhere"), ["nowhere: no such directory"]),
        (("info", "."), ["is not a result: neither a study nor a pair"]),
        (("run", "quick", "--set", "contact.law=none"), ["--set contact.law: "]),
        (("characterise", "upper.csv", "--band", "10 um,1 um"), ["--band must be the shortest and then the longest"]),
        (("pair", "upper.csv", "lower.csv", *MATERIAL, "--load", "-1 mN"), ["--load must be above 0"]),
        (("pair", "upper.csv", "lower.csv", *MATERIAL[:3], "-1", "--load", "1 mN"), ["--mu0 must be at least 0"]),
    ],
)
def test_messages_name_the_option(folder, tmp_path, arguments, words):
    where = tmp_path if arguments[0] == "info" else folder
    assert_refused(stiction_command(*arguments, cwd=where), *words)


def test_numbers_have_the_digits_that_their_interval_carries():
    assert with_interval(0.1552, 0.07024, 0.3431) == "0.16 [0.07, 0.34]"
    assert with_interval(2.188, 1.192, 4.013) == "2.2 [1.2, 4.0]"
    assert with_interval(0.123456, 0.1234, 0.1235) == "0.1235 [0.1234, 0.1235]"
    assert with_interval(1170.0, 970.0, 1380.0) == "1170 [970, 1380]"
    assert with_interval(math.nan, math.nan, math.nan) == "none"
    assert with_interval(0.5, math.nan, math.nan) == "0.5 no interval"
