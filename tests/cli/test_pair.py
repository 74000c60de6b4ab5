"""Tests of the options of `stiction pair`, and of complete runs from scan files to figures."""

import contextlib
import json
import sys
from pathlib import Path

import numpy as np
import pandas
import pytest
import stiction
import typer
from stiction import (
    Study,
    effective_modulus,
    hardness_under_shear,
    open_result,
    run,
    self_affine,
    self_affine_surface,
    write_profile,
)
from stiction._errors import ArgumentError
from stiction._estimate import Estimate
from stiction.cli.application import app, print_output
from stiction.cli.options import show_reader_import_status
from stiction.cli.pair_options import read_given_options
from stiction.evaluate import member_values
from stiction.evaluate.at_load import at_load
from stiction.solve import store
from stiction.solve.member_solution import solve_at_loads
from stiction.solve.store import export
from stiction.study.members import read_measured_bodies
from stiction.study.pair_options import validate_option_values
from stiction.study.pair_study import MeasuredPair
from stiction.study.values import StudyError
from stiction.summary.input_caveats import find_input_caveats
from support.command import assert_rejected, call_stiction, check_stiction

MATERIAL_OPTIONS = ["--effective-modulus", "10 GPa", "--mu0", "0.3", "--tau0", "50 MPa"]
LOAD_OPTION = ["--load", "20 uN"]
PROFILE_FILES = ["upper.csv", "lower.csv"]
MAP_ARGUMENTS = ["upper.npy", "lower.npy", "--unit", "um", "--spacing", "0.1 um"]
MAP_AND_PROFILE_ARGUMENTS = [
    "upper.npy",
    "lower.csv",
    "--unit",
    "um",
    "--unit",
    "um",
    "--spacing",
    "0.1 um",
    "--spacing",
    "0.01 um",
]


def create_profile(side):
    return self_affine(
        8, hurst_exponent=0.8, rms=0.03, points=2000, spacing=0.01, shortest_wavelength=0.2, longest_wavelength=3.0,
        side=side,
    )  # fmt: skip


def create_surface(side, points=64):
    return self_affine_surface(
        3, hurst_exponent=0.8, rms=0.02, shape=(points, points), spacing=0.1, longest_wavelength=3.2,
        shortest_wavelength=0.4, side=side,
    )  # fmt: skip


@pytest.fixture(scope="module")
def scans_directory(tmp_path_factory):
    directory = tmp_path_factory.mktemp("pair")
    for side in ("upper", "lower"):
        write_profile(create_profile(side), directory / f"{side}.csv")
        np.save(directory / f"{side}.npy", create_surface(side).heights)
    np.save(directory / "bare.npy", create_surface("upper").heights)
    (directory / "empty.csv").write_text("")
    (directory / "file").write_text("")
    return directory


def parse_pair_arguments(scans_directory, *arguments):
    """Parse the arguments of `pair`, and return the pair of bodies with its options."""
    group = typer.main.get_command(app)
    command = group.get_command(group.context_class(group), "pair")
    with (
        contextlib.chdir(scans_directory),
        command.make_context("pair", [str(argument) for argument in arguments]) as context,
    ):
        return MeasuredPair(validate_option_values(read_given_options(context)))


def parse_study(scans_directory, *arguments):
    """Parse the arguments of `pair`, and return the study that results."""
    with contextlib.chdir(scans_directory):
        return parse_pair_arguments(scans_directory, *arguments).study


def read_study_value(study, key):
    """Return the value of a dotted key of a study."""
    value = study
    for name in key.split("."):
        value = getattr(value, name)
    return value


# ---- Options ----------------------------------------------------------------------------------------------


REPETITIONS_KEY = "ensemble.repetitions"


@pytest.mark.parametrize(
    ("files", "options", "values"),
    [
        (PROFILE_FILES, [], {"surfaces.press": "lines", "contact.mechanics": "asperities", REPETITIONS_KEY: 64}),
        (PROFILE_FILES, ["--offsets", 9, "--travel", "2 um"], {REPETITIONS_KEY: 9, "surfaces.travel": 2.0}),
        (PROFILE_FILES, ["--level", "none", "--unit", "um"], {"surfaces.level": "none", "surfaces.lower.unit": "um"}),
        (PROFILE_FILES, ["--cutoff", "0.1 um,0 um,100 nm"], {"surfaces.cut_off": (0.0, 0.1)}),
        (PROFILE_FILES, ["--surrogates", "both"], {"surfaces.replace": "both", REPETITIONS_KEY: 128}),
        (PROFILE_FILES, ["--surrogates", "both", "--lines", 5, "--seed", 4], {REPETITIONS_KEY: 5, "ensemble.seed": 4}),
        (
            PROFILE_FILES,
            ["--law", "hertz-cylinder"],
            {"contact.law": "hertz-cylinder", "contact.detection": "gap-minimum"},
        ),
        (PROFILE_FILES, ["--lay", "grooves"], {"contact.law": "hertz-cylinder"}),
        (PROFILE_FILES, ["--detection", "cell"], {"contact.detection": "cell"}),
        (PROFILE_FILES, ["--curvature", "signed"], {"contact.curvature": "signed"}),
        (PROFILE_FILES, ["--mechanics", "half-space", "--hardness", "3 GPa"], {"contact.hardness": 3.0}),
        (PROFILE_FILES, ["--mu0", "0.4,0.3,0.4"], {"friction.mu0": (0.3, 0.4)}),
        (PROFILE_FILES, ["--tau0", "50 MPa,0 MPa,0.05 GPa"], {"friction.tau0": (0.0, 0.05)}),
        # The nominal area is 10 µm².
        (PROFILE_FILES, ["--load", "2 MPa", "--load", "0.01 mN"], {"friction.load": (0.01, 0.02)}),
        (
            PROFILE_FILES,
            ["--lay", "isotropic", "--level", "line"],
            {"surfaces.press": "surrogates", "surfaces.level": "plane"},
        ),
        (PROFILE_FILES, ["--lay", "isotropic", "--surrogates", 3], {REPETITIONS_KEY: 3}),
        (MAP_ARGUMENTS, [], {"surfaces.press": "areas", "contact.mechanics": "half-space", REPETITIONS_KEY: 16}),
        (MAP_ARGUMENTS, ["--shifts", 3, "--surrogates", 2], {REPETITIONS_KEY: 5, "surfaces.surrogates": 2}),
        (MAP_ARGUMENTS, ["--rotate", 20, "--tilt", "free"], {"surfaces.rotate": 20.0, "contact.tilt": "free"}),
        (MAP_ARGUMENTS, ["--level", "quadratic"], {"surfaces.level": "quadratic"}),
        (MAP_ARGUMENTS, ["--direction", "45,225"], {"contact.direction": (45.0, 225.0)}),
        (MAP_ARGUMENTS, ["--mechanics", "asperities"], {"contact.curvature": "signed"}),
        (
            MAP_ARGUMENTS,
            ["--missing", "interpolate", "--outliers", "mask"],
            {"surfaces.upper.missing": "interpolate", "surfaces.lower.outliers": "mask"},
        ),
        (MAP_ARGUMENTS, ["--crop", "0 um,4 um,0 um,5 um"], {"surfaces.lower.crop": (0.0, 4.0, 0.0, 5.0)}),
        (["--gap", *MAP_ARGUMENTS[1:]], [], {REPETITIONS_KEY: 1, "surfaces.gap": True}),
        (MAP_ARGUMENTS, ["--lines", 7, "--along", "y"], {REPETITIONS_KEY: 7, "surfaces.along": "y"}),
        (MAP_ARGUMENTS, ["--lines", 500], {REPETITIONS_KEY: 64}),
        (
            MAP_ARGUMENTS,
            ["--lines", 3, "--offsets", 2, "--travel", "1 um"],
            {REPETITIONS_KEY: 6, "surfaces.offsets": 2},
        ),
        (
            MAP_AND_PROFILE_ARGUMENTS,
            ["--lines", 3],
            {"surfaces.press": "lines", "surfaces.lower.spacing": 0.01, REPETITIONS_KEY: 3},
        ),
    ],
)
def test_option_of_the_pair_command_sets_the_corresponding_key_of_the_study(scans_directory, files, options, values):
    load = [] if "--load" in options else LOAD_OPTION
    study = parse_study(scans_directory, *files, *MATERIAL_OPTIONS, *load, *options)
    for key, value in values.items():
        assert read_study_value(study, key) == value


def test_map_given_as_a_gap_is_levelled_as_requested_and_pressed_on_a_flat(scans_directory):
    study = parse_study(
        scans_directory, "--gap", *MAP_ARGUMENTS[1:], *MATERIAL_OPTIONS, *LOAD_OPTION, "--tilt", "fixed"
    )
    assert study.surfaces.level == "mean"
    study = parse_study(
        scans_directory,
        "--gap",
        *MAP_ARGUMENTS[1:],
        *MATERIAL_OPTIONS,
        *LOAD_OPTION,
        "--tilt",
        "fixed",
        "--level",
        "plane",
    )
    assert study.surfaces.level == "plane"
    study = parse_study(
        scans_directory, "--gap", *MAP_ARGUMENTS[1:], *MATERIAL_OPTIONS, *LOAD_OPTION, "--level", "mean"
    )
    (upper, lower), gap = read_measured_bodies(study).member(0, 0.0).pair, create_surface("lower").heights
    assert not upper.heights.any()
    np.testing.assert_allclose(upper.heights - lower.heights, gap - gap.mean(), atol=1e-12)


@pytest.mark.parametrize("mechanics", ["half-space", "asperities"])
def test_closure_stiffness_exceeds_contact_stiffness_only_in_the_half_space_model(scans_directory, mechanics):
    study = parse_study(scans_directory, *MAP_ARGUMENTS, *MATERIAL_OPTIONS, *LOAD_OPTION, "--mechanics", mechanics)
    upper, lower = read_measured_bodies(study).member(0, 0.0).pair
    result = solve_at_loads(study, upper, lower, computes_unloading=True)
    stiffness_per_area = 1e6 * result["normal_stiffness"] / np.prod(upper.extent)  # MPa/mm
    if mechanics == "asperities":
        np.testing.assert_allclose(result["closure"], result["approach"])
        np.testing.assert_allclose(result["closure_stiffness"], stiffness_per_area)
    else:
        assert (result["closure"] < result["approach"]).all()
        assert (result["closure_stiffness"] > stiffness_per_area).all()


def test_study_rejects_free_tilt_with_periodic_boundary(scans_directory):
    study = parse_study(scans_directory, *MAP_ARGUMENTS, *MATERIAL_OPTIONS, *LOAD_OPTION, "--tilt", "free")
    with pytest.raises(StudyError, match='tilt: must be "fixed" if the boundaries are periodic'):
        study.with_changes({"contact.boundary": "periodic"})


def test_study_of_profiles_contains_file_checksums_and_positions_within_the_travel_distance(scans_directory):
    study = parse_study(
        scans_directory, *PROFILE_FILES, *MATERIAL_OPTIONS, *LOAD_OPTION, "--travel", "2 um", "--offsets", 1
    )
    assert study.surfaces.upper.file == str(scans_directory / "upper.csv")
    assert study.surfaces.upper.sha256 == study.surfaces.upper.checksum()
    assert read_measured_bodies(study).member(0, 0.0).x == pytest.approx(2)
    study = parse_study(
        scans_directory, *PROFILE_FILES, *MATERIAL_OPTIONS, *LOAD_OPTION, "--travel", "2 um", "--offsets", 9
    )
    offsets = [read_measured_bodies(study).member(index, 0.0).x for index in range(9)]
    assert 0 < min(offsets) < 0.5
    assert 1.5 < max(offsets) <= 2


def test_young_modulus_and_poisson_ratio_options_set_effective_modulus_and_compliance_fraction(scans_directory):
    arguments = ["--young", "20 GPa,30 GPa", "--poisson", "0.3,0.2", "--mu0", "0.3", "--mechanics", "half-space"]
    contact = parse_study(scans_directory, *PROFILE_FILES, *arguments, *LOAD_OPTION).contact
    modulus = float(effective_modulus(20.0, 0.3, 30.0, 0.2))
    assert contact.effective_modulus == modulus
    assert contact.compliance_share == pytest.approx(modulus * (1 - 0.2**2) / 30)


def test_hardness_by_jackson_and_green_equals_2_84_times_the_yield_strength(scans_directory):
    arguments = [*PROFILE_FILES, *MATERIAL_OPTIONS, *LOAD_OPTION, "--law", "jackson-green", "--poisson", "0.3"]
    options = (("--hardness", "568 MPa"), ("--yield-strength", "200 MPa"))
    law_by_hardness, law_by_yield_strength = (
        parse_study(scans_directory, *arguments, *option).contact.law for option in options
    )
    assert float(law_by_hardness.yield_strength) == pytest.approx(law_by_yield_strength.yield_strength)
    assert law_by_hardness.poisson_ratio == 0.3


def test_load_steps_extend_beyond_the_requested_loads_unless_the_hardness_limits_the_load(scans_directory):
    steps = parse_study(scans_directory, *PROFILE_FILES, *MATERIAL_OPTIONS, *LOAD_OPTION).contact.loading_steps()
    assert steps[[0, -1]] == pytest.approx([0.02 / 30, 0.02 * 30])
    assert 0.02 in steps
    contact_with_hardness = parse_study(
        scans_directory, *MAP_ARGUMENTS, *MATERIAL_OPTIONS, "--load", "100 MPa", "--hardness", "200 MPa"
    ).contact
    assert contact_with_hardness.loading_steps() == pytest.approx(np.array([10**-0.5, 1]) * 0.1 * 4.8**2)
    for arguments in ([*PROFILE_FILES, *LOAD_OPTION], [*MAP_ARGUMENTS, "--load", "100 MPa", "--hardness", "200 MPa"]):
        pair_with_check = parse_pair_arguments(scans_directory, *arguments, *MATERIAL_OPTIONS, "--check")
        with contextlib.chdir(scans_directory):
            study, check_study = pair_with_check.studies
        assert {study.contact.mechanics, check_study.contact.mechanics} == {"asperities", "half-space"}
        np.testing.assert_array_equal(study.contact.loading_steps(), check_study.contact.loading_steps())


def test_material_name_sets_the_modulus_and_the_hardness_and_the_yield_strength(scans_directory):
    from stiction.mechanics.materials import compliance_fraction, material, softer_hardness

    steel, brass = material("steel"), material("brass")
    arguments = ["--mu0", "0.3", *LOAD_OPTION, "--upper", "steel", "--lower", "brass"]
    contact = parse_study(scans_directory, *MAP_ARGUMENTS, *arguments).contact
    assert float(contact.effective_modulus) == pytest.approx(effective_modulus(steel, brass), rel=5e-3)
    assert float(contact.hardness) == pytest.approx(softer_hardness(steel, brass), rel=5e-3)
    assert contact.compliance_share == pytest.approx(compliance_fraction(steel, brass), rel=5e-3)
    assert float(parse_study(scans_directory, *MAP_ARGUMENTS, *arguments, "--hardness", "3 GPa").contact.hardness) == 3
    law = parse_study(scans_directory, *PROFILE_FILES, *arguments, "--law", "jackson-green").contact.law
    assert float(law.yield_strength) == pytest.approx(softer_hardness(steel, brass) / 2.84, rel=5e-3)
    with contextlib.chdir(scans_directory):
        remark_without_hardness, remark_with_hardness = (
            parse_pair_arguments(scans_directory, *MAP_ARGUMENTS, *arguments, *options).remarks[0]
            for options in ([], ["--hardness", "3 GPa"])
        )
    assert "brass" in remark_without_hardness
    assert "--hardness" in remark_with_hardness

    arguments = ["--mu0", "0.3", *LOAD_OPTION, "--upper", "PDMS", "--lower", "glass"]
    assert parse_study(scans_directory, *MAP_ARGUMENTS, *arguments).contact.hardness is None
    with contextlib.chdir(scans_directory):
        assert (
            parse_pair_arguments(scans_directory, *MAP_ARGUMENTS, *arguments).remarks[0].endswith("PDMS does not yield")
        )
    with pytest.raises(ArgumentError, match="PDMS does not yield"):
        parse_study(scans_directory, *MAP_ARGUMENTS, *arguments, "--hardness", "1 GPa")


def test_load_steps_start_at_a_requested_load_that_equals_the_smallest_allowed_load(scans_directory):
    steps = parse_study(
        scans_directory, *PROFILE_FILES, "--mu0", "0.3", "--effective-modulus", "10 GPa", "--load", "1e-12 mN"
    ).contact.loading_steps()
    assert steps[0] == pytest.approx(1e-12)
    assert steps.size > 1


@pytest.mark.parametrize(
    ("arguments", "expected_words"),
    [
        (["none.csv", "lower.csv"], ["none.csv", "cannot be read"]),
        (["bad\udcff.csv", "lower.csv"], ["file: must be text in UTF-8", "rename"]),
        (["upper.csv", "empty.csv"], ["empty.csv"]),
        (["bare.npy", "lower.csv"], ["bare.npy", "unit"]),
        ([*PROFILE_FILES, "--unit", "mm"], ["upper.csv", "the option unit is mm"]),
        ([*PROFILE_FILES, "--unit", "inch"], ["unit"]),
        ([*PROFILE_FILES, "--unit", "um", "--unit", "um", "--unit", "um"], ["--unit", "got 3"]),
        ([*PROFILE_FILES, "--missing", "guess"], ["--missing"]),
        ([*PROFILE_FILES, "--load", "-1 mN"], ["--load"]),
        ([*PROFILE_FILES, "--load", "0"], ["--load must be above 0"]),
        ([*PROFILE_FILES, "--load", "1e300 mN"], ["--load must be from 1e-12 to 1e+12 mN, got '1e300 mN'"]),
        (
            [*PROFILE_FILES, "--load", ",".join(f"{load} mN" for load in range(1, 102))],
            ["--load must have at most 100"],
        ),
        ([*PROFILE_FILES, "--mu0", "inf"], ["--mu0 must be finite and from 0 to 1e+06, got 'inf'"]),
        ([*PROFILE_FILES, "--mu0", "1e300"], ["--mu0 must be finite and from 0 to 1e+06, got '1e300'"]),
        ([*PROFILE_FILES, "--tau0", "inf MPa"], ["--tau0 must be from 1e-09 to 10000 GPa, got 'inf MPa'"]),
        ([*PROFILE_FILES, "--cutoff", "1e300 um"], ["--cutoff must be from 1e-06 to 1e+06 um"]),
        ([*PROFILE_FILES, "--output", "out.pdf"], ["out.pdf"]),
        ([*PROFILE_FILES, "--output", "file"], ["file"]),
        ([*PROFILE_FILES, "--output", "file/deeper"], ["file/deeper"]),
        ([*PROFILE_FILES, "--part", "3/2"], ["--part"]),
        ([*PROFILE_FILES, "--lines", "4"], ["--lines"]),
        ([*PROFILE_FILES, "--poisson", "0.3"], ["--poisson"]),
        (
            [*PROFILE_FILES, "--hardness", "3 GPa"],
            ["--hardness needs --mechanics half-space, or --law jackson-green with the asperity model"],
        ),
        ([*PROFILE_FILES, "--young", "200 GPa"], ["--effective-modulus", "--young"]),
        ([*PROFILE_FILES, "--law", "jackson-green"], ["--yield-strength or --hardness"]),
        ([*PROFILE_FILES, "--law", "jackson-green", "--hardness", "3 GPa"], ["--poisson"]),
        (
            [*PROFILE_FILES, "--law", "jackson-green", "--hardness", "3 GPa", "--yield-strength", "1 GPa"],
            ["--yield-strength"],
        ),
        ([*PROFILE_FILES, "--effective-modulus", "10 mN"], ["--effective-modulus"]),
        ([*PROFILE_FILES, "--load", "10 nm"], ["--load must be a force or a pressure", "mN", "MPa"]),
        ([*PROFILE_FILES, "--mu0", "-1"], ["--mu0 must be at least 0"]),
        ([*MAP_ARGUMENTS, "--hardness", "150 HB"], ["--hardness", "'HB'"]),
        (
            [*MAP_ARGUMENTS, "--load", "1 GPa", "--hardness", "0.5 GPa"],
            ["--load must give a pressure below the hardness (0.5 GPa)"],
        ),
        (
            [*PROFILE_FILES, "--mu0", ",".join(f"{index / 1000}" for index in range(101))],
            ["--mu0 must have at most 100 values, got 101"],
        ),
        ([*PROFILE_FILES, "--travel", "19 um"], ["travel"]),
        ([*PROFILE_FILES, "--offsets", "0"], ["--offsets"]),
        ([*PROFILE_FILES, "--level", "plane"], ["level"]),
        ([*PROFILE_FILES, "--lay", "isotropic", "--shifts", "3"], ["--shifts"]),
        ([*PROFILE_FILES, "--lay", "isotropic", "--offsets", "3"], ["--offsets"]),
        ([*PROFILE_FILES, "--lay", "grooves", "--law", "hertz-sphere"], ["--lay grooves"]),
        ([*PROFILE_FILES, "--shifts", "3"], ["--shifts"]),
        ([*PROFILE_FILES, "--direction", "3"], ["--direction"]),
        ([*PROFILE_FILES, "--mechanics", "springs"], ["--mechanics"]),
        ([*MAP_ARGUMENTS, "--along", "y"], ["--along"]),
        ([*MAP_ARGUMENTS, "--surrogates", "lower"], ["--surrogates"]),
        ([*MAP_ARGUMENTS, "--lay", "isotropic"], ["--lay"]),
        ([*MAP_ARGUMENTS, "--offsets", "3"], ["--offsets"]),
        ([*MAP_ARGUMENTS, "--lines", "3", "--shifts", "2"], ["--shifts"]),
        ([*MAP_ARGUMENTS, "--lines", "3", "--offsets", "2"], ["--offsets", "--travel"]),
        ([*MAP_ARGUMENTS, "--check", "--mechanics", "asperities"], ["--mechanics", "--check"]),
        ([*MAP_ARGUMENTS, "--mechanics", "asperities", "--hardness", "1 GPa"], ["--hardness"]),
        ([*MAP_ARGUMENTS, "--mechanics", "asperities", "--law", "hertz-cylinder"], ["law"]),
        ([*MAP_ARGUMENTS, "--hardness", "0.8 MPa"], ["--load", "hardness"]),
        ([*MAP_ARGUMENTS, "--hardness", "1 GPa", "--wait", "1 h"], ["--wait needs --creep"]),
        ([*MAP_ARGUMENTS, "--wait", "1 h", "--creep", "0.03"], ["--wait needs --hardness"]),
        ([*MAP_ARGUMENTS, "--hardness", "1 GPa", "--wait", "1 mn", "--creep", "0.03"], ["--wait", "'mn'", "min, h"]),
        ([*MAP_ARGUMENTS, "--hardness", "1 GPa", "--creep", "0.03"], ["--creep is for --wait"]),
        (
            [*MAP_ARGUMENTS, "--hardness", "1 GPa", "--wait", "1 h", "--creep", "-1"],
            ["--creep must be from 0 to 0.5", "'-1'"],
        ),
        *(
            (
                [*MAP_ARGUMENTS, "--hardness", hardnesses],
                [f"--hardness must be the hardness of the softer body, as one value or one range, got '{hardnesses}'"],
            )
            for hardnesses in ("210 HV,180 HV", "2.1 GPa,1.8 GPa", "210 HV ± 8 %,180 HV")
        ),
        (
            [*MAP_ARGUMENTS, "--hardness", "1 GPa", "--wait", "1 h", "--creep", "0.02,0.04"],
            ["--creep must be one value or one range, got '0.02,0.04'"],
        ),
        ([*MAP_ARGUMENTS, "--hardness", "0..2 GPa"], ["--hardness must be above 0, got '0..2 GPa'"]),
        ([*MAP_ARGUMENTS, "--hardness", "3"], ["--hardness", "unit of pressure", "HV", "HRC"]),
        ([*PROFILE_FILES, "--wait", "1 h", "--creep", "0.03"], ["--wait is for --mechanics half-space"]),
        ([*MAP_ARGUMENTS, "--level", "line"], ["level"]),
        ([*MAP_ARGUMENTS, "--tilt", "loose"], ["--tilt must be fixed or free, got 'loose'"]),
        ([*PROFILE_FILES, "--tilt", "free"], ["--tilt is for --mechanics half-space"]),
        ([], ["UPPER and LOWER", "--gap"]),
        ([*MAP_ARGUMENTS, "--gap", MAP_ARGUMENTS[0]], ["UPPER and LOWER", "--gap"]),
        (["--gap", "upper.csv"], ["--gap must be one map"]),
        (["--gap", *MAP_ARGUMENTS[1:], "--shifts", "3"], ["--shifts must not be combined with --gap"]),
        ([*MAP_ARGUMENTS, "--direction", "north"], ["--direction"]),
        ([*MAP_ARGUMENTS, "--direction", "0,360"], ["direction"]),
    ],
)
def test_pair_command_rejects_invalid_input(scans_directory, arguments, expected_words):
    completed = call_stiction(
        "pair", *MATERIAL_OPTIONS, *LOAD_OPTION, "--output", "bad", *arguments, cwd=scans_directory
    )
    assert_rejected(completed, *expected_words)
    assert not (scans_directory / "bad" / "blocks").exists()


def test_preview_and_model_check_of_a_pair_are_computed_without_dwell_times(scans_directory):
    dwell_time_options = ["--hardness", "1 GPa", "--wait", "1 h,1 min,1 h", "--creep", "0.03", "--check"]
    parsed_pair = parse_pair_arguments(
        scans_directory, *MAP_ARGUMENTS, *MATERIAL_OPTIONS, *LOAD_OPTION, *dwell_time_options
    )
    with contextlib.chdir(scans_directory):
        assert [list(map(float, study.friction.wait)) for study in parsed_pair.studies] == [[60.0, 3600.0], []]
        assert not parsed_pair.preview_study.friction.wait


@pytest.mark.usefixtures("omit_companion_files")
def test_pair_command_evaluates_the_stored_sums_of_each_load_only_once(scans_directory, tmp_path, monkeypatch):
    requests = []
    evaluate_piece = member_values._evaluate_piece

    def evaluate_and_record(piece, study, loads, mu0, tau0, load_definition, names, *other_arguments):
        quantities = None if names is None else frozenset(names)
        requests.extend((study.to_toml(), load_definition, quantities, float(load)) for load in loads)
        return evaluate_piece(piece, study, loads, mu0, tau0, load_definition, names, *other_arguments)

    monkeypatch.setattr(member_values, "_evaluate_piece", evaluate_and_record)
    monkeypatch.setattr("stiction.views.report.result.evaluate_in_copy", contextlib.nullcontext)
    options = ["--hardness", "0.5..1.5 GPa", "--load", "7 MPa", "--load", "9 MPa", "--shifts", 4, "--onset", 0]
    result = call_stiction(
        "pair", *MAP_ARGUMENTS, *MATERIAL_OPTIONS, *options, "-o", tmp_path / "out", cwd=scans_directory,
        without_figures=True,
    )  # fmt: skip
    assert result.returncode == 0
    assert (tmp_path / "out" / "report.html").exists()
    assert len({load for *_, load in requests}) > 2
    assert [request for request in set(requests) if requests.count(request) > 1] == []


@pytest.mark.usefixtures("omit_companion_files")
def test_pair_command_writes_table_and_figure_even_if_the_report_is_too_large(scans_directory, tmp_path, monkeypatch):
    monkeypatch.setattr("stiction.views.report.result.MAX_REPORT_VALUES", {True: 10, False: 10})
    options = [*MAP_ARGUMENTS, *MATERIAL_OPTIONS, *LOAD_OPTION, "--shifts", 2, "--onset", 0]
    result = call_stiction("pair", *options, "-o", tmp_path / "out", cwd=scans_directory, without_figures=True)
    assert result.returncode == 2
    assert "at most 10 coefficients for a report" in result.stderr
    file_names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"result.csv", "friction.png"} < file_names
    assert "report.html" not in file_names


@pytest.mark.parametrize(
    ("function", "message"),
    [
        ("views.figures.draw_figures", "the result is stored in"),
        ("cli.result_output.print_resolution_and_onset", "2 of 2 positions are finished and stored"),
    ],
)
def test_pair_command_interrupted_during_file_output_has_already_printed_the_result(
    function, message, scans_directory, tmp_path, monkeypatch
):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"stiction.{function}", interrupt)
    monkeypatch.setattr("stiction.cli.application.signal.signal", lambda *_: None)
    monkeypatch.setattr("os._exit", sys.exit)
    arguments = ["pair", *MAP_ARGUMENTS, *MATERIAL_OPTIONS, "--load", "7 MPa", "--shifts", 2, "--onset", 0]
    arguments += ["-o", tmp_path / "out"]
    interrupted_command = call_stiction(*arguments, cwd=scans_directory, without_report=True)
    assert interrupted_command.returncode == 130
    assert "μ_s = " in interrupted_command.stdout
    assert f"interrupted; {message}" in interrupted_command.stderr
    monkeypatch.undo()
    finished_command = call_stiction(*arguments, cwd=scans_directory, without_figures=True, without_report=True)
    assert finished_command.returncode == 0
    assert "already contains this study" in finished_command.stdout
    assert (tmp_path / "out" / "friction.png").exists()


@pytest.mark.usefixtures("omit_companion_files")
def test_csv_table_and_json_output_of_a_pair_contain_equal_intervals(scans_directory, tmp_path):
    options = ["--hardness", "0.5..1.5 GPa", "--junction-growth", 0, "--load", "7 MPa", "--shifts", 4]
    options += ["--direction", "0,90", "--onset", 0]
    call_stiction(
        "pair",
        *MAP_ARGUMENTS,
        *MATERIAL_OPTIONS,
        *options,
        "--output",
        tmp_path / "out",
        cwd=scans_directory,
        without_figures=True,
        without_report=True,
    )
    table = pandas.read_csv(tmp_path / "out" / "result.csv", comment="#").set_index("sliding")
    columns = [f"coefficient of static friction: {limit}" for limit in ("lower", "upper")]
    command = ["at", tmp_path / "out", "--load", "7 MPa", "--json"]
    for direction_option, has_interval in (([], 1), (["--direction", 0], 0)):
        (point,) = json.loads(call_stiction(*command, *direction_option, cwd=scans_directory).stdout)["points"]
        for rule in point["rules"]:
            coefficient = rule["coefficient"]
            limits = [coefficient["lower"], coefficient["upper"]]
            assert limits[0] <= coefficient["value"] <= limits[1]
            interval = table.loc[[rule["rule"]], columns].dropna().to_numpy()
            assert len(interval) == 1
            assert not has_interval or interval[0] == pytest.approx(limits, rel=1e-8)


@pytest.mark.usefixtures("omit_companion_files")
@pytest.mark.parametrize(
    "bodies", [["hole.csv", "lower.csv", "--offsets", 2], ["--gap", "hole.npy", *MAP_ARGUMENTS[2:]]]
)
def test_pair_command_writes_a_report_about_scans_with_missing_points(scans_directory, tmp_path, bodies):
    profile_heights, map_heights = create_profile("upper").heights.copy(), create_surface("upper").heights.copy()
    profile_heights[300:340] = map_heights[10:14, 20:26] = np.nan
    np.savetxt(
        scans_directory / "hole.csv",
        np.column_stack([np.arange(2000) * 0.01, profile_heights]),
        delimiter=",",
        header="x (um),z (um)",
    )
    np.save(scans_directory / "hole.npy", map_heights)
    options = ["--missing", "mask", "--mechanics", "half-space", "--onset", 0, "--output", tmp_path / "out"]
    check_stiction("pair", *bodies, *MATERIAL_OPTIONS, *LOAD_OPTION, *options, cwd=scans_directory)
    assert (tmp_path / "out" / "report.html").exists()


@pytest.mark.parametrize(
    ("arguments", "expected_words"),
    [
        (["--upper", "upper.csv", "--lower", "lower.csv"], ["materials", "the first two arguments are the files"]),
        ([*PROFILE_FILES, "--upper", "upper.csv"], ["--upper must be", "material", "'upper.csv'"]),
        ([*PROFILE_FILES, "--upper", "stele"], ["--upper must be", "steel"]),
        (
            [*PROFILE_FILES, "--upper", "TiN", "--lower", "steel"],
            [
                "'TiN'; the nearest are tin",
                "a coating much thinner",
                "give --young, --poisson and --hardness as numbers",
            ],
        ),
        (PROFILE_FILES, ["--effective-modulus", "--young", "--upper"]),
        (
            [*PROFILE_FILES, "--lower", "glass", "--young", "3 MPa"],
            ["--young and --poisson must be single values for the upper body", "or omit --lower"],
        ),
    ],
)
def test_pair_command_rejects_a_missing_material_and_a_file_name_given_as_material(
    scans_directory, arguments, expected_words
):
    assert_rejected(
        call_stiction("pair", *arguments, *LOAD_OPTION, "--mu0", "0.3", cwd=scans_directory), *expected_words
    )


# ---- Output --------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("omit_companion_files")
def test_preview_is_printed_to_standard_error_on_terminals(scans_directory, monkeypatch):
    for module in ("application", "pair"):
        monkeypatch.setattr(f"stiction.cli.{module}.is_stderr_terminal", lambda: True)
    command = [
        "pair",
        *MAP_ARGUMENTS,
        *MATERIAL_OPTIONS,
        "--load",
        "10 MPa",
        "--shifts",
        3,
        "--onset",
        0,
        "--json",
        "-o",
        "first",
    ]
    completed = check_stiction(*command, cwd=scans_directory, without_figures=True, without_report=True)
    assert "preliminary" in completed.stderr
    assert json.loads(completed.stdout)["command"] == "pair"
    with contextlib.chdir(scans_directory):
        preview_study = parse_pair_arguments(scans_directory, *command[1:]).preview_study
        friction = at_load(run(preview_study), [float(preview_study.friction.load[0])])["mean_friction"]
    mean = float(friction.sel(sliding="all", statistic="mean").squeeze())
    assert f"μ_s = {Estimate(mean)}  friction at all contacts" in completed.stderr
    for arguments in (
        [*PROFILE_FILES, *LOAD_OPTION],
        [*MAP_ARGUMENTS, "--load", "10 MPa", "--mechanics", "asperities"],
    ):
        with contextlib.chdir(scans_directory):
            assert parse_pair_arguments(scans_directory, *arguments, *MATERIAL_OPTIONS).preview_study is None
    repeated_call = call_stiction(*command, cwd=scans_directory, without_figures=True, without_report=True)
    assert "preliminary" not in repeated_call.stderr


SCANS_DIRECTORY = Path(__file__).parents[2] / "examples" / "scans"
STEEL_ON_BRASS_OPTIONS = ["--upper", "steel", "--lower", "brass", "--mu0", "0.2", "--tau0", "50 MPa"]
HONED_STEEL_OPTIONS = [
    "--upper",
    "steel",
    "--lower",
    "steel",
    "--hardness",
    "2±0.1 GPa",
    "--mu0",
    "0.2±0.01",
    "--tau0",
    "20±2 MPa",
    "--adhesion",
    "0 mJ/m^2",
    "--load",
    "20 mN",
    "--mechanics",
    "half-space",
    "--offsets",
    8,
    "--lay",
    "grooves",
]
RUBBER_ON_GLASS_OPTIONS = [
    "--upper",
    "rubber",
    "--lower",
    "glass",
    "--mu0",
    "0.3",
    "--tau0",
    "200 kPa",
    "--load",
    "100 kPa",
]


@pytest.mark.usefixtures("disable_figures", "no_reports")
@pytest.mark.parametrize(
    "arguments",
    [
        [
            SCANS_DIRECTORY / "lapped_upper.csv",
            SCANS_DIRECTORY / "lapped_lower.csv",
            *STEEL_ON_BRASS_OPTIONS,
            "--load",
            "10 mN",
            "--mechanics",
            "half-space",
            "--offsets",
            6,
        ],
        pytest.param(
            [
                SCANS_DIRECTORY / "ground_upper.x3p",
                SCANS_DIRECTORY / "ground_lower.x3p",
                *STEEL_ON_BRASS_OPTIONS,
                "--load",
                "10 MPa",
                "--shifts",
                4,
            ],
            marks=pytest.mark.soak,
        ),
        [*MAP_ARGUMENTS, *RUBBER_ON_GLASS_OPTIONS, "--shifts", 4],
        [*MAP_ARGUMENTS, *STEEL_ON_BRASS_OPTIONS, "--load", "10 MPa", "--shifts", 4],
        [SCANS_DIRECTORY / "honed_upper.csv", SCANS_DIRECTORY / "honed_lower.csv", *HONED_STEEL_OPTIONS],
    ],
    ids=["lapped", "ground", "rubber", "maps", "honed"],
)
def test_pair_command_output_fits_in_24_lines(scans_directory, arguments, tmp_path):
    options = {"cwd": scans_directory, "columns": 80, "without_figures": True, "without_report": True}
    completed = check_stiction("pair", *arguments, "-o", tmp_path / "out", **options)
    # Do not count the characters of paths, which are longer here than in the current directory.
    output = (completed.stderr + completed.stdout).replace(str(tmp_path / "out"), "out")
    text_before_paths, _, paths = output.partition("wrote ")
    assert "report.html" in paths
    num_lines = 1 + sum(1 + max(len(line) - 1, 0) // 80 for line in text_before_paths.splitlines())
    assert num_lines <= 23  # the last line of the terminal shows the prompt
    text = completed.stdout
    assert "μ_s" in text
    assert ("Quote it" in text) == ("2±0.1 GPa" in arguments)
    assert sum(text.count(expected_words) for expected_words in ("Quote it", "Quote with care", "Do not quote")) in (
        1,
        2,
    )
    assert not set(completed.stderr) & {"\x1b"}
    assert "warning" not in completed.stderr
    repeated_values = [
        text_part
        for text_part in ("E* = ", "hardness 6", "μ0 = ", "interval of the mean:")
        if text.count(text_part) > 1
    ]
    assert not repeated_values


def test_friction_value_and_assessment_are_bold_only_on_terminals(capsys, monkeypatch):
    text = "μ_s = 0.29 [0.24, 0.42]  if all\nQuote with care; measure\nQuote withers\n"
    print_output(text)
    assert capsys.readouterr().out == text
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.setattr("typer.echo", print)
    print_output(text)
    terminal_output = capsys.readouterr().out
    assert terminal_output.count("\x1b[1m") == 2
    assert "\x1b[1mμ_s = 0.29 [0.24, 0.42]\x1b[0m  if all" in terminal_output
    assert "\x1b[1mQuote with care\x1b[0m; measure" in terminal_output


def test_slow_import_of_a_scan_reader_package_is_announced_only_once(scans_directory, monkeypatch):
    monkeypatch.setattr("stiction.cli.application.is_stderr_terminal", lambda: True)
    (scans_directory / "scan.di").write_text("nothing")
    monkeypatch.delitem(sys.modules, "SurfaceTopography", raising=False)
    messages = []
    monkeypatch.setattr("stiction.cli.options.show_status", messages.append)
    show_reader_import_status(scans_directory / "scan.di")
    show_reader_import_status(scans_directory / "upper.csv")
    show_reader_import_status(scans_directory / "missing.di")
    assert [("SurfaceTopography" in message, "scan.di" in message) for message in messages] == [(True, True)]
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    show_reader_import_status(scans_directory / "scan.di")
    assert len(messages) == 1


# ---- Complete runs ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def model_check_output(scans_directory):
    """Output of `pair --check` on two profiles, which solves the pair with both contact models."""
    completed = check_stiction(
        "pair",
        *PROFILE_FILES,
        *MATERIAL_OPTIONS,
        *LOAD_OPTION,
        "--offsets",
        4,
        "--check",
        cwd=scans_directory,
        without_figures=True,
    )
    return completed


@pytest.fixture(scope="module")
def output_for_pair_of_maps(scans_directory):
    """Output of `pair` on two maps with the asperity model."""
    completed = check_stiction(
        "pair",
        *MAP_ARGUMENTS,
        *MATERIAL_OPTIONS,
        "--load",
        "10 MPa",
        "--shifts",
        3,
        "--mechanics",
        "asperities",
        "-o",
        "areas",
        cwd=scans_directory,
        without_figures=True,
    )
    return completed


def test_pair_command_writes_result_and_figures_and_report_and_model_check(
    scans_directory, model_check_output, output_for_pair_of_maps
):
    for directory in ("pair", "pair/half-space", "areas"):
        stored_dataset = store.read(scans_directory / directory)
        result = run(Study.from_toml(scans_directory / directory / "study.toml")).dataset
        for name, values in result.data_vars.items():
            np.testing.assert_array_equal(stored_dataset[name].values, values.values, err_msg=name)
        assert (scans_directory / directory / "result.csv").exists()
        assert list((scans_directory / directory).glob("*.png"))
        assert "</html>" in (scans_directory / directory / "report.html").read_text("utf-8")
    assert "By half-space" in model_check_output.stdout
    command = ["pair", *PROFILE_FILES, *MATERIAL_OPTIONS, *LOAD_OPTION, "--offsets", 4, "--check", "--json"]
    command = call_stiction(*command, cwd=scans_directory, without_figures=True, without_report=True)
    assert json.loads(command.stdout)["check"][0]["values"]
    assert "wrote" in output_for_pair_of_maps.stdout


@pytest.mark.usefixtures("disable_figures", "no_reports")
def test_pair_command_resumes_with_the_same_options_and_rejects_different_options(
    scans_directory, output_for_pair_of_maps
):
    command = [
        "pair",
        *MAP_ARGUMENTS,
        *MATERIAL_OPTIONS,
        "--load",
        "10 MPa",
        "--mechanics",
        "asperities",
        "-o",
        "areas",
    ]
    completed = check_stiction(*command, "--shifts", 4, "--json", cwd=scans_directory)
    assert json.loads(completed.stdout)
    assert "3 of 4 positions already existed" in completed.stderr
    (scans_directory / "areas" / "picture.nc").unlink()
    check_stiction(*command, "--shifts", 4, cwd=scans_directory)
    assert (scans_directory / "areas" / "picture.nc").exists()
    assert_rejected(
        call_stiction(*command, "--shifts", 4, "--rotate", 10, cwd=scans_directory), "contains another study"
    )
    check_stiction(*command, "--shifts", 2, "--rotate", 10, "--replace", cwd=scans_directory)
    assert store.open_stored_result(scans_directory / "areas").finished_members.size == 2


@pytest.mark.usefixtures("disable_figures", "no_reports")
def test_rejection_of_another_junction_growth_names_the_option_that_opens_the_stored_pair(scans_directory):
    command = ["pair", *MAP_ARGUMENTS, "--upper", "glass", "--mu0", 0.3, "--load", "10 MPa", "--shifts", 2]
    command += ["--onset", 0, "--output", "grown"]
    check_stiction(*command, "--junction-growth", "slip-line 5.2..5.6", cwd=scans_directory)
    option = "--junction-growth 'slip-line 5.2..5.6'"
    assert_rejected(call_stiction(*command, cwd=scans_directory), f"open the stored result with {option}")
    opened = check_stiction(*command, "--junction-growth", "slip-line 5.2..5.6", cwd=scans_directory)
    assert "grown already contains this study" in opened.stdout
    rejected = call_stiction(*command, "--rotate", 10, cwd=scans_directory)
    assert_rejected(rejected, "contains another study")
    assert option not in rejected.stderr


@pytest.mark.parametrize(
    ("options", "is_assumed"),
    [
        ([], True),
        (["--mechanics", "half-space"], True),
        (["--lay", "grooves"], None),
        (["--law", "hertz-cylinder"], None),
    ],
)
def test_study_of_two_profiles_states_that_the_lay_is_assumed_without_lay_and_law(scans_directory, options, is_assumed):
    study = parse_study(scans_directory, *PROFILE_FILES, *MATERIAL_OPTIONS, *LOAD_OPTION, *options)
    assert study.surfaces.lay_assumed is is_assumed


@pytest.mark.usefixtures("disable_figures", "no_reports", "omit_companion_files")
@pytest.mark.parametrize("lays", [("grooves", None), (None, "grooves")])
def test_pair_command_reuses_stored_positions_if_only_the_assumption_of_the_lay_differs(
    scans_directory, tmp_path, lays
):
    command = ["pair", *PROFILE_FILES, *MATERIAL_OPTIONS, *LOAD_OPTION, "--mechanics", "half-space", "--offsets", 8]
    commands = [
        [*command, "--onset", 0, "-o", tmp_path / "pair", *([] if lay is None else ["--lay", lay])] for lay in lays
    ]
    check_stiction(*commands[0], cwd=scans_directory)
    blocks = sorted((tmp_path / "pair/blocks").iterdir())
    contents = [block.read_bytes() for block in blocks]
    blocks[-1].unlink()
    assert "6 of 8 positions already existed" in check_stiction(*commands[1], cwd=scans_directory).stdout
    assert [block.read_bytes() for block in blocks[:-1]] == contents[:-1]
    assert open_result(tmp_path / "pair").study.surfaces.lay_assumed is (True if lays[1] is None else None)


@pytest.mark.usefixtures("disable_figures", "no_reports", "omit_companion_files")
def test_pair_command_with_changed_tau0_reuses_stored_repetitions(scans_directory):
    command = (
        "pair",
        *MAP_ARGUMENTS,
        "--effective-modulus",
        "10 GPa",
        "--mu0",
        "0.3",
        "--load",
        "1 MPa",
        "--shifts",
        2,
    )
    command += ("--mechanics", "asperities", "--onset", 0, "--output", "friction")
    check_stiction(*command, "--tau0", "0 MPa", cwd=scans_directory)
    blocks = sorted((scans_directory / "friction" / "blocks").iterdir())
    completed = check_stiction(*command, "--tau0", "50 MPa", cwd=scans_directory)
    assert "its 2 positions are kept" in completed.stderr
    assert "friction.tau0 = " in completed.stderr
    assert sorted((scans_directory / "friction" / "blocks").iterdir()) == blocks


@pytest.mark.usefixtures("disable_figures", "no_reports")
def test_concurrent_pair_commands_can_write_the_same_files(scans_directory, monkeypatch):
    """Two equal commands in one directory write the same files, and both must succeed."""
    from stiction.companions import contact_picture, onset

    def with_written_copy(compute, file_name):
        def compute_and_write_copy(*args, **options):
            dataset = compute(*args, **options)
            export(dataset, scans_directory / "twice" / file_name)
            return dataset

        return compute_and_write_copy

    for module, name, file_name in (
        (contact_picture, "contact_picture", contact_picture.CONTACT_PICTURE_FILE),
        (onset, "compute_onset", onset.ONSET_FILE),
    ):
        monkeypatch.setattr(module, name, with_written_copy(getattr(module, name), file_name))
    command = (
        "pair",
        *MAP_ARGUMENTS,
        *MATERIAL_OPTIONS,
        "--load",
        "1 MPa",
        "--shifts",
        2,
        "--mechanics",
        "asperities",
        "--onset",
        2,
    )
    completed = check_stiction(*command, "--output", "twice", cwd=scans_directory)
    assert "μ_s" in completed.stdout


@pytest.mark.usefixtures("disable_figures", "no_reports", "omit_companion_files")
def test_pair_commands_for_two_parts_of_a_run_give_a_complete_result(scans_directory):
    arguments = ["pair", *PROFILE_FILES, *MATERIAL_OPTIONS, *LOAD_OPTION, "--mu0", "30", "--offsets", 4, "-o", "parts"]
    for run_part in ("1/2", "2/2"):
        check_stiction(*arguments, "--part", run_part, cwd=scans_directory)
    assert store.open_stored_result(scans_directory / "parts").finished_members.size == 4
    completed = check_stiction(*arguments, cwd=scans_directory)
    assert "not in per cent" in completed.stdout


@pytest.mark.usefixtures("disable_figures", "no_reports", "omit_companion_files")
def test_run_command_rejects_a_changed_scan_file(scans_directory):
    arguments = [
        "pair",
        "scan.npy",
        "lower.npy",
        *MAP_ARGUMENTS[2:],
        *MATERIAL_OPTIONS,
        *LOAD_OPTION,
        "--mechanics",
        "asperities",
        "-o",
        "other",
    ]
    np.save(scans_directory / "scan.npy", create_surface("upper", 48).heights)
    check_stiction(*arguments, "--shifts", 1, cwd=scans_directory)
    np.save(scans_directory / "scan.npy", -create_surface("upper", 48).heights)
    command = ["run", "other", "--set", "ensemble.repetitions=2"]
    assert_rejected(call_stiction(*command, cwd=scans_directory), "scan.npy", "has changed since")


# ---- Measured data --------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("disable_figures", "no_reports")
def test_stylus_profile_paired_with_itself_at_one_position_is_shifted_by_the_travel_distance(
    find_measured_file, tmp_path
):
    file = find_measured_file("dektak-1.csv")
    shift_options = ["--travel", "200 um", "--offsets", "1", "--load", "10 mN", "--json"]
    check_stiction("pair", file, file, *MATERIAL_OPTIONS, *shift_options, cwd=tmp_path)
    result = store.read(tmp_path / "pair")
    assert float(result["x"][0]) == pytest.approx(200, abs=1)


@pytest.mark.usefixtures("disable_figures", "no_reports")
@pytest.mark.parametrize("lines", [4, 16])
def test_pair_command_presses_an_afm_map_on_its_surrogates(find_measured_file, tmp_path, lines):
    pytest.importorskip("SurfaceTopography")
    file = find_measured_file("di-4.di")
    arguments = ["--lines", lines, "--surrogates", "lower", "--along", "y", "--json"]
    check_stiction("pair", file, file, *MATERIAL_OPTIONS, *LOAD_OPTION, *arguments, cwd=tmp_path)
    assert store.read(tmp_path / "pair")["surrogate"].values.all()


# ---- Resolution, onset and filtered scans ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def directory_options_and_record(tmp_path_factory):
    """Directory, arguments and JSON output of `pair` on two maps that are large enough for cutoffs."""
    directory = tmp_path_factory.mktemp("beside")
    for side in ("upper", "lower"):
        surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(96, 96), spacing=0.1, side=side)
        np.save(directory / f"{side}.npy", surface.heights)
    options = ["--upper", "steel", "--lower", "brass", "--mu0", "0.2", "--tau0", "10 MPa", "--load", "10 MPa"]
    options += ["--shifts", 3, "--direction", "0,180", "--onset", 3, "--wait", "1 h", "--creep", 0.02]
    completed = check_stiction(
        "pair", *MAP_ARGUMENTS, *options, "--json", cwd=directory, without_figures=True, without_report=True
    )
    return directory, options, json.loads(completed.stdout)


def test_pair_command_reports_resolved_wavelengths_and_the_friction_range_for_finer_scans(directory_options_and_record):
    directory, _, record = directory_options_and_record
    resolution, json_points = record["resolution"], record["points"][0]
    assert resolution["wavelengths"]["shortest_um"] == pytest.approx(0.2)
    assert [entry["cut_off"] for entry in resolution["cutoffs"]] == pytest.approx([0, 0.2], rel=1e-3)
    pressure = float(hardness_under_shear(0.625, 0.2, 0.01, "slip-line"))
    assert json_points["finer_scans"]["from"] == pytest.approx(0.2 + 0.01 / pressure, rel=1e-3)
    assert json_points["finer_scans"]["to"] >= json_points["rules"][0]["coefficient"]["value"]
    stored_resolution = store.read(directory / "pair" / "resolution")
    expected = run(Study.from_toml(directory / "pair" / "resolution" / "study.toml")).dataset
    np.testing.assert_array_equal(stored_resolution["contact_area"].values, expected["contact_area"].values)
    pair_directory = directory / "pair"
    assert (pair_directory / "onset.csv").exists()
    assert [path.name for path in pair_directory.glob("*.png")] == ["friction.png"]
    check_stiction("plot", "pair", cwd=directory, without_figures=True)
    assert {"cut_off.png", "onset.png", "slip.png"} <= {path.name for path in pair_directory.iterdir()}


ESTIMATE_KEYS = ["name", "value", "unit", "lower", "upper", "kind", "at", "status"]
REJECTED_JSON_KEYS = {
    "answers", "by_slopes_alone", "cut_offs", "doubts", "freedom", "friction_all_round", "friction_known",
    "friction_waited", "from_roughness", "headline", "holds", "if_known", "next_test", "of_positions", "parts",
    "reading", "share", "sticking", "told", "verdict", "wait", "waited", "wave", "waves", "what", "words",
}  # fmt: skip
"""Keys that must not occur in JSON output, because they are not terms of the glossary."""


def iterate_json_objects(content):
    """Yield all objects in a JSON document."""
    if isinstance(content, dict):
        yield content
    for item in content.values() if isinstance(content, dict) else content if isinstance(content, list) else ():
        yield from iterate_json_objects(item)


def test_json_output_of_every_command_gives_each_value_with_its_interval_and_unit(directory_options_and_record):
    directory, _, record = directory_options_and_record
    commands = [
        ["info", "pair"], ["at", "pair", "--load", "12 MPa"], ["materials", "steel"], ["interfaces"],
        ["characterise", "upper.npy", "--unit", "um", "--spacing", "0.1 um"],
    ]  # fmt: skip
    outputs = [check_stiction(*command, "--json", cwd=directory).stdout for command in commands]
    records = [record, *map(json.loads, outputs)]
    for json_record in records:
        for item in iterate_json_objects(json_record):
            assert "value" not in item or list(item) == ESTIMATE_KEYS
            assert not {"lower", "upper"} & set(item) or list(item) == ESTIMATE_KEYS
            assert not REJECTED_JSON_KEYS & set(item)
    (point,) = (point for point in record["points"] if point["reported"])
    (rule,) = (rule for rule in point["rules"] if rule["rule"] == "all")
    kinds = [rule[name]["kind"] for name in ("coefficient", "mean", "prediction")]
    assert kinds == ["combined", "mean", "prediction"]
    assert {entry["coefficient"]["kind"] for entry in point["budget"]} == {"conditional"}
    assert [(estimate["kind"], estimate["at"]) for estimate in point["after_dwell"]] == [
        ("combined", {"dwell_time": 3600.0})
    ]
    assert record["onset"]["sliding_load"]["value"] == record["onset"]["curve"][-1]["tangential_load"]["value"]
    assert {"upper_body", "lower_body", "load_definition"} <= set(record)
    assert list(point["scans"]) == list(point["cutoffs"]) == ["upper_body", "lower_body"]


@pytest.mark.parametrize("is_given", [False, True])
def test_inputs_in_the_output_name_the_material_whose_hardness_comes_from_the_table(scans_directory, is_given):
    options = [*STEEL_ON_BRASS_OPTIONS, *LOAD_OPTION, "--shifts", 2, "--onset", 0, "--output", f"table{is_given}"]
    options += ["--hardness", "1.5 GPa"] if is_given else []
    completed = check_stiction(
        "pair", *MAP_ARGUMENTS, *options, cwd=scans_directory, without_figures=True, without_report=True
    )
    assert ("as in the table for brass" in " ".join(completed.stdout.split())) != is_given


def test_pair_command_reports_onset_of_sliding(directory_options_and_record):
    directory, arguments, record = directory_options_and_record
    onset = record["onset"]
    assert onset["members"] == 3
    assert onset["poisson_ratio"] == pytest.approx([0.295, 0.35], abs=1e-3)
    assert 0 < onset["displacement_at_sliding"]["value"] < 0.1
    (directory / "pair/onset.csv").unlink()
    completed = call_stiction(
        "pair", *MAP_ARGUMENTS, *arguments, "--verbose", cwd=directory, without_figures=True, without_report=True
    )
    assert "already contains this study" in completed.stdout
    assert not (directory / "pair/onset.csv").exists()
    assert onset["sentence"][:12] in completed.stdout
    assert "mild steel on brass" in completed.stdout
    assert "If small contacts are as hard as large ones, no finer scan gives less than the plastic limit." in " ".join(
        completed.stdout.split()
    )


def test_pair_command_solves_a_noisy_scan_both_unfiltered_and_filtered(tmp_path):
    clean_profile = self_affine(4, hurst_exponent=0.7, rms=0.003, points=1500, spacing=0.0167, shortest_wavelength=0.2)
    frequency = np.fft.rfftfreq(1500, 0.0167)
    phases = np.exp(2j * np.pi * np.random.default_rng(3).uniform(size=frequency.size))
    noise = np.fft.irfft(((frequency > 8) & (frequency < 18)) * phases, 1500)
    noisy_profile = stiction.Profile(clean_profile.heights + 1.3e-4 * noise / noise.std(), spacing=0.0167)
    options = {"load": "10 MPa", "mu0": 0.2, "effective_modulus": "80 GPa"}
    studies = {
        name: MeasuredPair.from_values(upper=profile, lower=profile, **options, **cutoff_option).study
        for name, profile, cutoff_option in (
            ("clean", clean_profile, {}), ("noisy", noisy_profile, {}), ("vouched", noisy_profile, {"cutoff": "none"}),
            ("cut", noisy_profile, {"cutoff": "0.3 um"}),
        )
    }  # fmt: skip
    assert [study.surfaces.vouched for study in studies.values()] == [None, None, True, None]
    cutoffs = {name: [float(value) for value in study.surfaces.cut_off] for name, study in studies.items()}
    assert (cutoffs["clean"], cutoffs["vouched"], cutoffs["cut"]) == ([0.0], [0.0], [0.3])
    assert cutoffs["noisy"] == [0.0, stiction.instrument_limit(noisy_profile).cut_off]
    (fault,) = [
        value for value in find_input_caveats(noisy_profile, noisy_profile, studies["cut"]) if value.severity == "fault"
    ]
    assert fault.cut_off < 0.3


def create_noisy_and_clean_profiles():
    clean_profile = self_affine(4, hurst_exponent=0.8, rms=0.003, points=1500, spacing=0.0167, shortest_wavelength=0.3)
    noise = np.random.default_rng(1).normal(size=1500)
    return stiction.Profile(clean_profile.heights + 5e-5 * noise, spacing=0.0167), clean_profile


def test_pair_command_filters_a_noise_floor_only_from_the_noisy_scan():
    noisy_profile, clean_profile = create_noisy_and_clean_profiles()
    limit = stiction.instrument_limit(noisy_profile)
    assert (limit.origin, limit.matters) == ("instrument", True)
    options = {"load": "10 MPa", "mu0": 0.2, "tau0": "50 MPa", "effective_modulus": "80 GPa", "offsets": 8}
    study = MeasuredPair.from_values(upper=noisy_profile, lower=clean_profile, **options).study
    assert [float(item) for item in study.surfaces.cut_off] == [limit.cut_off, 0.0]
    assert study.surfaces.both_readings
    assert [float(item.max_cut_off) for item in (study.surfaces.upper, study.surfaces.lower)] == [limit.cut_off, 0.0]
    filtered_upper, filtered_lower = read_measured_bodies(study).member(0, limit.cut_off).pair
    raw_upper, raw_lower = read_measured_bodies(study).member(0, 0.0).pair
    assert np.array_equal(filtered_lower.heights, raw_lower.heights)
    assert not np.array_equal(filtered_upper.heights, raw_upper.heights)
    result = stiction.pair(noisy_profile, clean_profile, onset=0, **options)
    filtered_point = result.summary().points[0]
    assert filtered_point.at["cut_off"] == limit.cut_off
    assert filtered_point.assessment != "Quote it"
    raw_point = next(point for point in result.summary().points if point.at["cut_off"] == 0)
    assert raw_point.covered
    assert filtered_point.lower <= raw_point.lower <= raw_point.upper <= filtered_point.upper
    assert result.to_dataframe()["cutoff (um)"].iloc[0] == pytest.approx(limit.cut_off)


def test_declared_texture_of_a_scan_prevents_filtering_and_unknown_textures_are_rejected():
    _, clean_profile = create_noisy_and_clean_profiles()
    profile_with_line = stiction.Profile(
        clean_profile.heights + 2e-4 * np.sin(2 * np.pi * np.arange(1500) / 8), spacing=0.0167
    )
    options = {"load": "10 MPa", "mu0": 0.2, "effective_modulus": "80 GPa"}
    study = MeasuredPair.from_values(upper=profile_with_line, lower=clean_profile, **options).study
    assert float(study.surfaces.cut_off[0]) == 0.0
    assert study.surfaces.both_readings
    study_with_texture = MeasuredPair.from_values(
        upper=profile_with_line, lower=clean_profile, texture="ground", **options
    ).study
    assert [float(item) for item in study_with_texture.surfaces.cut_off] == [0.0]
    assert [study_with_texture.surfaces.upper.texture, study_with_texture.surfaces.lower.texture] == [
        "ground",
        "ground",
    ]
    assert not any(
        item.severity == "fault" for item in find_input_caveats(profile_with_line, clean_profile, study_with_texture)
    )
    with pytest.raises(ValueError, match="must be one or two of turned, milled"):
        stiction.pair(profile_with_line, clean_profile, texture="shiny", **options)


def test_half_space_model_is_the_default_for_profiles_of_metals(scans_directory):
    options = ["--mu0", "0.3", *LOAD_OPTION, "--upper", "steel"]
    assert parse_study(scans_directory, *PROFILE_FILES, *options, "--lower", "brass").contact.mechanics == "half-space"
    assert (
        parse_study(scans_directory, *PROFILE_FILES, *options, "--lower", "brass", "--lay", "grooves").contact.hardness
        is not None
    )
    for asperity_options in (
        ["--lower", "PDMS"],
        ["--lower", "brass", "--law", "hertz-sphere"],
        ["--mechanics", "asperities"],
    ):
        assert (
            parse_study(scans_directory, *PROFILE_FILES, *options, *asperity_options).contact.mechanics == "asperities"
        )


def test_width_option_converts_the_force_on_the_specimen_to_the_force_per_um_of_specimen_width(scans_directory):
    arguments = ["--effective-modulus", "10 GPa", "--mu0", "0.3"]
    study = parse_study(scans_directory, *PROFILE_FILES, *arguments, "--load", "5 N", "--width", "5 mm")
    assert [float(load) for load in study.friction.load] == [1.0]
    study_of_two_loads = parse_study(
        scans_directory, *PROFILE_FILES, *arguments, "--load", "5 N", "--load", "2 MPa", "--width", "5 mm"
    )
    assert [float(load) for load in study_of_two_loads.friction.load] == [0.02, 1.0]
    for rejected_options in (["--load", "2 MPa"], ["--load", "5 N", "--lay", "isotropic"]):
        with pytest.raises(ArgumentError, match="width"):
            parse_study(scans_directory, *PROFILE_FILES, *arguments, *rejected_options, "--width", "5 mm")


@pytest.mark.usefixtures("disable_figures", "no_reports", "omit_companion_files")
def test_pair_command_lists_the_model_assumptions_for_profiles(scans_directory, tmp_path):
    arguments = ["pair", *PROFILE_FILES, "--upper", "steel", "--lower", "brass", "--mu0", "0.2", "--load", "40 MPa"]
    record = json.loads(
        check_stiction(*arguments, "--offsets", 8, "-o", tmp_path / "out", "--json", cwd=scans_directory).stdout
    )
    assumptions = record["points"][0]["assumptions"]
    assert assumptions == ["parallel grooves across the scans on a strip 1 µm wide", "no adhesion"]
    completed = check_stiction("at", tmp_path / "out", cwd=scans_directory)
    text = " ".join(completed.stdout.split())
    assert "Assumes parallel grooves across the scans on a strip 1 µm wide, no adhesion." in text
    table = (tmp_path / "out" / "result.csv").read_text()
    assert "; ".join(assumptions) in table
    assert "taken as grooved" not in completed.stderr
