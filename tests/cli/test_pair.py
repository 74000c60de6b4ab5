"""Tests of `stiction pair`: its options, and a few pairs from files to figures."""

import contextlib
import json
import sys
from pathlib import Path

import numpy as np
import pandas
import pytest
import stiction
import typer
from stiction import Study, effective_modulus, run, self_affine, self_affine_surface, tabor_friction, write_profile
from stiction._errors import ArgumentError
from stiction._number_format import quoted
from stiction.cli.application import app, print_output
from stiction.cli.options import show_reader_import
from stiction.cli.pair_options import given_options
from stiction.studies import store
from stiction.studies.evaluation import at_load
from stiction.studies.input_caveats import find_input_caveats
from stiction.studies.member_solution import solve_at_loads
from stiction.studies.members import load_bodies
from stiction.studies.pair import Pair
from stiction.studies.pair_options import read_options
from stiction.studies.store import export
from stiction.studies.values import StudyError
from support.command import assert_rejected, call_stiction, check_stiction

MATERIAL = ["--effective-modulus", "10 GPa", "--mu0", "0.3", "--tau0", "50 MPa"]
LOAD = ["--load", "20 uN"]
PROFILES = ["upper.csv", "lower.csv"]
MAPS = ["upper.npy", "lower.npy", "--unit", "um", "--spacing", "0.1 um"]
MIXED = ["upper.npy", "lower.csv", "--unit", "um", "--unit", "um", "--spacing", "0.1 um", "--spacing", "0.01 um"]


def profile(side):
    return self_affine(
        8, hurst_exponent=0.8, rms=0.03, points=2000, spacing=0.01, shortest_wavelength=0.2, longest_wavelength=3.0,
        side=side,
    )  # fmt: skip


def surface(side, points=64):
    return self_affine_surface(
        3, hurst_exponent=0.8, rms=0.02, shape=(points, points), spacing=0.1, longest_wavelength=3.2,
        shortest_wavelength=0.4, side=side,
    )  # fmt: skip


@pytest.fixture(scope="module")
def where(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pair")
    for side in ("upper", "lower"):
        write_profile(profile(side), folder / f"{side}.csv")
        np.save(folder / f"{side}.npy", surface(side).heights)
    np.save(folder / "bare.npy", surface("upper").heights)
    (folder / "empty.csv").write_text("")
    (folder / "file").write_text("")
    return folder


def asked(where, *arguments):
    """Return the parsed options of a command line."""
    group = typer.main.get_command(app)
    command = group.get_command(group.context_class(group), "pair")
    with contextlib.chdir(where), command.make_context("pair", [str(argument) for argument in arguments]) as context:
        return Pair(read_options(given_options(context)))


def study_of(where, *arguments):
    """Return the study of a command line."""
    with contextlib.chdir(where):
        return asked(where, *arguments).study


def value_at(study, key):
    """Return the value of a dotted key of a study."""
    value = study
    for part in key.split("."):
        value = getattr(value, part)
    return value


# ---- What is asked for ----------------------------------------------------------------------------------------------


REPETITIONS = "ensemble.repetitions"


@pytest.mark.parametrize(
    ("files", "options", "values"),
    [
        (PROFILES, [], {"surfaces.press": "lines", "contact.mechanics": "asperities", REPETITIONS: 64}),
        (PROFILES, ["--offsets", 9, "--travel", "2 um"], {REPETITIONS: 9, "surfaces.travel": 2.0}),
        (PROFILES, ["--level", "none", "--unit", "um"], {"surfaces.level": "none", "surfaces.lower.unit": "um"}),
        (PROFILES, ["--cutoff", "0.1 um,0 um,100 nm"], {"surfaces.cut_off": (0.0, 0.1)}),
        (PROFILES, ["--surrogates", "both"], {"surfaces.replace": "both", REPETITIONS: 128}),
        (PROFILES, ["--surrogates", "both", "--lines", 5, "--seed", 4], {REPETITIONS: 5, "ensemble.seed": 4}),
        (PROFILES, ["--law", "hertz-cylinder"], {"contact.law": "hertz-cylinder", "contact.detection": "gap-minimum"}),
        (PROFILES, ["--lay", "grooves"], {"contact.law": "hertz-cylinder"}),
        (PROFILES, ["--detection", "cell"], {"contact.detection": "cell"}),
        (PROFILES, ["--curvature", "signed"], {"contact.curvature": "signed"}),
        (PROFILES, ["--mechanics", "half-space", "--hardness", "3 GPa"], {"contact.hardness": 3.0}),
        (PROFILES, ["--mu0", "0.4,0.3,0.4"], {"friction.mu0": (0.3, 0.4)}),
        (PROFILES, ["--tau0", "50 MPa,0 MPa,0.05 GPa"], {"friction.tau0": (0.0, 0.05)}),
        (PROFILES, ["--load", "2 MPa", "--load", "0.01 mN"], {"friction.load": (0.01, 0.02)}),  # on 10 µm²
        (
            PROFILES,
            ["--lay", "isotropic", "--level", "line"],
            {"surfaces.press": "surrogates", "surfaces.level": "plane"},
        ),
        (PROFILES, ["--lay", "isotropic", "--surrogates", 3], {REPETITIONS: 3}),
        (MAPS, [], {"surfaces.press": "areas", "contact.mechanics": "half-space", REPETITIONS: 16}),
        (MAPS, ["--shifts", 3, "--surrogates", 2], {REPETITIONS: 5, "surfaces.surrogates": 2}),
        (MAPS, ["--rotate", 20, "--tilt", "free"], {"surfaces.rotate": 20.0, "contact.tilt": "free"}),
        (MAPS, ["--level", "quadratic"], {"surfaces.level": "quadratic"}),
        (MAPS, ["--direction", "45,225"], {"contact.direction": (45.0, 225.0)}),
        (MAPS, ["--mechanics", "asperities"], {"contact.curvature": "signed"}),
        (
            MAPS,
            ["--missing", "interpolate", "--outliers", "mask"],
            {"surfaces.upper.missing": "interpolate", "surfaces.lower.outliers": "mask"},
        ),
        (MAPS, ["--crop", "0 um,4 um,0 um,5 um"], {"surfaces.lower.crop": (0.0, 4.0, 0.0, 5.0)}),
        (["--gap", *MAPS[1:]], [], {REPETITIONS: 1, "surfaces.gap": True}),
        (MAPS, ["--lines", 7, "--along", "y"], {REPETITIONS: 7, "surfaces.along": "y"}),
        (MAPS, ["--lines", 500], {REPETITIONS: 64}),
        (MAPS, ["--lines", 3, "--offsets", 2, "--travel", "1 um"], {REPETITIONS: 6, "surfaces.offsets": 2}),
        (MIXED, ["--lines", 3], {"surfaces.press": "lines", "surfaces.lower.spacing": 0.01, REPETITIONS: 3}),
    ],
)
def test_pair_option_sets_key_of_study(where, files, options, values):
    load = [] if "--load" in options else LOAD
    study = study_of(where, *files, *MATERIAL, *load, *options)
    for key, value in values.items():
        assert value_at(study, key) == value


def test_gap_is_used_unchanged_at_one_position(where):
    study = study_of(where, "--gap", *MAPS[1:], *MATERIAL, *LOAD, "--tilt", "fixed")
    assert study.surfaces.level == "mean"
    study = study_of(where, "--gap", *MAPS[1:], *MATERIAL, *LOAD, "--tilt", "fixed", "--level", "plane")
    assert study.surfaces.level == "plane"
    study = study_of(where, "--gap", *MAPS[1:], *MATERIAL, *LOAD, "--level", "mean")
    (upper, lower), gap = load_bodies(study).member(0, 0.0).pair, surface("lower").heights
    assert not upper.heights.any()
    np.testing.assert_allclose(upper.heights - lower.heights, gap - gap.mean(), atol=1e-12)


@pytest.mark.parametrize("mechanics", ["half-space", "asperities"])
def test_closure_is_stored_with_its_stiffness(where, mechanics):
    study = study_of(where, *MAPS, *MATERIAL, *LOAD, "--mechanics", mechanics)
    upper, lower = load_bodies(study).member(0, 0.0).pair
    result = solve_at_loads(study, upper, lower, unloads=True)
    over_area = 1e6 * result["normal_stiffness"] / np.prod(upper.extent)  # MPa/mm
    if mechanics == "asperities":
        np.testing.assert_allclose(result["closure"], result["approach"])
        np.testing.assert_allclose(result["closure_stiffness"], over_area)
    else:
        assert (result["closure"] < result["approach"]).all()
        assert (result["closure_stiffness"] > over_area).all()


def test_free_tilt_of_periodic_surfaces_is_rejected(where):
    study = study_of(where, *MAPS, *MATERIAL, *LOAD, "--tilt", "free")
    with pytest.raises(StudyError, match='tilt: must be "fixed" with periodic boundaries'):
        study.with_changes({"contact.boundary": "periodic"})


def test_study_has_checksums_of_files_and_travel(where):
    study = study_of(where, *PROFILES, *MATERIAL, *LOAD, "--travel", "2 um", "--offsets", 1)
    assert study.surfaces.upper.file == str(where / "upper.csv")
    assert study.surfaces.upper.sha256 == study.surfaces.upper.checksum()
    assert load_bodies(study).member(0, 0.0).x == pytest.approx(2)
    study = study_of(where, *PROFILES, *MATERIAL, *LOAD, "--travel", "2 um", "--offsets", 9)
    offsets = [load_bodies(study).member(index, 0.0).x for index in range(9)]
    assert 0 < min(offsets) < 0.5
    assert 1.5 < max(offsets) <= 2


def test_moduli_of_two_materials_give_effective_modulus_and_compliance_fraction(where):
    arguments = ["--young", "20 GPa,30 GPa", "--poisson", "0.3,0.2", "--mu0", "0.3", "--mechanics", "half-space"]
    contact = study_of(where, *PROFILES, *arguments, *LOAD).contact
    modulus = float(effective_modulus(20.0, 0.3, 30.0, 0.2))
    assert contact.effective_modulus == modulus
    assert contact.compliance_share == pytest.approx(modulus * (1 - 0.2**2) / 30)


def test_hardness_equals_multiple_of_yield_strength(where):
    law = [*PROFILES, *MATERIAL, *LOAD, "--law", "jackson-green", "--poisson", "0.3"]
    one, other = (study_of(where, *law, *words).contact.law for words in
                  (("--hardness", "568 MPa"), ("--yield-strength", "200 MPa")))  # fmt: skip
    assert float(one.yield_strength) == pytest.approx(other.yield_strength)
    assert one.poisson_ratio == 0.3


def test_load_steps_surround_the_requested_loads(where):
    steps = study_of(where, *PROFILES, *MATERIAL, *LOAD).contact.steps()
    assert steps[[0, -1]] == pytest.approx([0.02 / 30, 0.02 * 30])
    assert 0.02 in steps
    capped = study_of(where, *MAPS, *MATERIAL, "--load", "100 MPa", "--hardness", "200 MPa").contact
    assert capped.steps() == pytest.approx(np.array([10**-0.5, 1]) * 0.1 * 4.8**2)
    for arguments in ([*PROFILES, *LOAD], [*MAPS, "--load", "100 MPa", "--hardness", "200 MPa"]):
        checked = asked(where, *arguments, *MATERIAL, "--check")
        with contextlib.chdir(where):
            one, other = checked.studies
        assert {one.contact.mechanics, other.contact.mechanics} == {"asperities", "half-space"}
        np.testing.assert_array_equal(one.contact.steps(), other.contact.steps())


def test_materials_are_given_by_name(where):
    from stiction.mechanics.materials import compliance_fraction, material, softer_hardness

    steel, brass = material("steel"), material("brass")
    arguments = ["--mu0", "0.3", *LOAD, "--upper", "steel", "--lower", "brass"]
    contact = study_of(where, *MAPS, *arguments).contact
    assert float(contact.effective_modulus) == pytest.approx(effective_modulus(steel, brass), rel=5e-3)
    assert float(contact.hardness) == pytest.approx(softer_hardness(steel, brass), rel=5e-3)
    assert contact.compliance_share == pytest.approx(compliance_fraction(steel, brass), rel=5e-3)
    assert float(study_of(where, *MAPS, *arguments, "--hardness", "3 GPa").contact.hardness) == 3
    yielding = study_of(where, *PROFILES, *arguments, "--law", "jackson-green").contact.law
    assert float(yielding.yield_strength) == pytest.approx(softer_hardness(steel, brass) / 2.84, rel=5e-3)
    with contextlib.chdir(where):
        message, measured = (
            asked(where, *MAPS, *arguments, *more).remarks[0] for more in ([], ["--hardness", "3 GPa"])
        )
    assert "brass" in message
    assert measured.endswith("the hardness is that of --hardness")

    # Rubber does not yield.
    arguments = ["--mu0", "0.3", *LOAD, "--upper", "PDMS", "--lower", "glass"]
    assert study_of(where, *MAPS, *arguments).contact.hardness is None
    with contextlib.chdir(where):
        assert asked(where, *MAPS, *arguments).remarks[0].endswith("PDMS does not yield")
    with pytest.raises(ArgumentError, match="PDMS does not yield"):
        study_of(where, *MAPS, *arguments, "--hardness", "1 GPa")


def test_smallest_load_has_no_lower_steps(where):
    steps = study_of(
        where, *PROFILES, "--mu0", "0.3", "--effective-modulus", "10 GPa", "--load", "1e-12 mN"
    ).contact.steps()
    assert steps[0] == pytest.approx(1e-12)
    assert steps.size > 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.csv", "lower.csv"], ["none.csv", "cannot be read"]),
        (["bad\udcff.csv", "lower.csv"], ["file: must be text in UTF-8", "rename"]),
        (["upper.csv", "empty.csv"], ["empty.csv"]),
        (["bare.npy", "lower.csv"], ["bare.npy", "unit"]),
        ([*PROFILES, "--unit", "mm"], ["upper.csv", "unit is mm"]),
        ([*PROFILES, "--unit", "inch"], ["unit"]),
        ([*PROFILES, "--unit", "um", "--unit", "um", "--unit", "um"], ["--unit", "got 3"]),
        ([*PROFILES, "--missing", "guess"], ["--missing"]),
        ([*PROFILES, "--load", "-1 mN"], ["--load"]),
        ([*PROFILES, "--load", "0"], ["--load must be above 0"]),
        ([*PROFILES, "--load", "1e300 mN"], ["--load must be from 1e-12 to 1e+12 mN, got '1e300 mN'"]),
        ([*PROFILES, "--load", ",".join(f"{load} mN" for load in range(1, 102))], ["--load must have at most 100"]),
        ([*PROFILES, "--mu0", "inf"], ["--mu0 must be finite and from 0 to 1e+06, got 'inf'"]),
        ([*PROFILES, "--mu0", "1e300"], ["--mu0 must be finite and from 0 to 1e+06, got '1e300'"]),
        ([*PROFILES, "--tau0", "inf MPa"], ["--tau0 must be from 1e-09 to 10000 GPa, got 'inf MPa'"]),
        ([*PROFILES, "--cutoff", "1e300 um"], ["--cutoff must be from 1e-06 to 1e+06 um"]),
        ([*PROFILES, "--output", "out.pdf"], ["out.pdf"]),
        ([*PROFILES, "--output", "file"], ["file"]),
        ([*PROFILES, "--output", "file/deeper"], ["file/deeper"]),
        ([*PROFILES, "--part", "3/2"], ["--part"]),
        ([*PROFILES, "--lines", "4"], ["--lines"]),
        ([*PROFILES, "--poisson", "0.3"], ["--poisson"]),
        ([*PROFILES, "--hardness", "3 GPa"], ["--hardness"]),
        ([*PROFILES, "--young", "200 GPa"], ["--effective-modulus", "--young"]),
        ([*PROFILES, "--law", "jackson-green"], ["--yield-strength or --hardness"]),
        ([*PROFILES, "--law", "jackson-green", "--hardness", "3 GPa"], ["--poisson"]),
        (
            [*PROFILES, "--law", "jackson-green", "--hardness", "3 GPa", "--yield-strength", "1 GPa"],
            ["--yield-strength"],
        ),
        ([*PROFILES, "--effective-modulus", "10 mN"], ["--effective-modulus"]),
        ([*PROFILES, "--load", "10 nm"], ["--load must be a force or a pressure", "mN", "MPa"]),
        ([*PROFILES, "--mu0", "-1"], ["--mu0 must be at least 0"]),
        ([*MAPS, "--hardness", "150 HB"], ["--hardness", "'HB'"]),
        ([*MAPS, "--load", "1 GPa", "--hardness", "0.5 GPa"], ["--load must be below the hardness, 0.5 GPa"]),
        (
            [*PROFILES, "--mu0", ",".join(f"{index / 1000}" for index in range(101))],
            ["--mu0 must have at most 100 values, got 101"],
        ),
        ([*PROFILES, "--travel", "19 um"], ["travel"]),
        ([*PROFILES, "--offsets", "0"], ["--offsets"]),
        ([*PROFILES, "--level", "plane"], ["level"]),
        ([*PROFILES, "--lay", "isotropic", "--shifts", "3"], ["--shifts"]),
        ([*PROFILES, "--lay", "isotropic", "--offsets", "3"], ["--offsets"]),
        ([*PROFILES, "--lay", "grooves", "--law", "hertz-sphere"], ["--lay grooves"]),
        ([*PROFILES, "--shifts", "3"], ["--shifts"]),
        ([*PROFILES, "--direction", "3"], ["--direction"]),
        ([*PROFILES, "--mechanics", "springs"], ["--mechanics"]),
        ([*MAPS, "--along", "y"], ["--along"]),
        ([*MAPS, "--surrogates", "lower"], ["--surrogates"]),
        ([*MAPS, "--lay", "isotropic"], ["--lay"]),
        ([*MAPS, "--offsets", "3"], ["--offsets"]),
        ([*MAPS, "--lines", "3", "--shifts", "2"], ["--shifts"]),
        ([*MAPS, "--lines", "3", "--offsets", "2"], ["--offsets", "--travel"]),
        ([*MAPS, "--check", "--mechanics", "asperities"], ["--mechanics", "--check"]),
        ([*MAPS, "--mechanics", "asperities", "--hardness", "1 GPa"], ["--hardness"]),
        ([*MAPS, "--mechanics", "asperities", "--law", "hertz-cylinder"], ["law"]),
        ([*MAPS, "--hardness", "0.8 MPa"], ["--load", "hardness"]),
        ([*MAPS, "--hardness", "1 GPa", "--wait", "1 h"], ["--wait needs --creep"]),
        ([*MAPS, "--wait", "1 h", "--creep", "0.03"], ["--wait needs --hardness"]),
        ([*MAPS, "--hardness", "1 GPa", "--wait", "1 mn", "--creep", "0.03"], ["--wait", "'mn'", "min, h"]),
        ([*MAPS, "--hardness", "1 GPa", "--creep", "0.03"], ["--creep is for --wait"]),
        ([*MAPS, "--hardness", "1 GPa", "--wait", "1 h", "--creep", "-1"], ["--creep must be finite", "'-1'"]),
        ([*MAPS, "--hardness", "0..2 GPa"], ["--hardness must be above 0, got '0..2 GPa'"]),
        ([*MAPS, "--hardness", "3"], ["--hardness", "unit of pressure", "HV and HRC are also accepted"]),
        ([*PROFILES, "--wait", "1 h", "--creep", "0.03"], ["--wait is for --mechanics half-space"]),
        ([*MAPS, "--level", "line"], ["level"]),
        ([*MAPS, "--tilt", "loose"], ["--tilt must be fixed or free, got 'loose'"]),
        ([*PROFILES, "--tilt", "free"], ["--tilt is for --mechanics half-space"]),
        ([], ["give UPPER and LOWER, or the --gap between them"]),
        ([*MAPS, "--gap", MAPS[0]], ["give UPPER and LOWER, or the --gap between them"]),
        (["--gap", "upper.csv"], ["--gap must be one map"]),
        (["--gap", *MAPS[1:], "--shifts", "3"], ["--shifts must not be combined with --gap"]),
        ([*MAPS, "--direction", "north"], ["--direction"]),
        ([*MAPS, "--direction", "0,360"], ["direction"]),
    ],
)
def test_pair_rejects_bad_input(where, arguments, words):
    completed = call_stiction("pair", *MATERIAL, *LOAD, "--output", "bad", *arguments, cwd=where)
    assert_rejected(completed, *words)
    assert not (where / "bad" / "blocks").exists()


def test_dwell_time_is_left_out_of_preview_and_check(where):
    waiting = ["--hardness", "1 GPa", "--wait", "1 h,1 min,1 h", "--creep", "0.03", "--check"]
    arguments = asked(where, *MAPS, *MATERIAL, *LOAD, *waiting)
    with contextlib.chdir(where):
        assert [list(map(float, study.friction.wait)) for study in arguments.studies] == [[60.0, 3600.0], []]
        assert not arguments.preview_study.friction.wait


def test_table_and_json_have_equal_intervals(where, tmp_path):
    options = ["--hardness", "0.5..1.5 GPa", "--load", "7 MPa", "--shifts", 4, "--direction", "0,90", "--onset", 0]
    call_stiction("pair", *MAPS, *MATERIAL, *options, "--output", tmp_path / "out", cwd=where, without_figures=True)
    table = pandas.read_csv(tmp_path / "out" / "result.csv", comment="#").set_index("sliding")
    ends = [f"coefficient of static friction: {end}" for end in ("lower", "upper")]
    read = ["at", tmp_path / "out", "--load", "7 MPa", "--json"]
    for more, reported in (([], 1), (["--direction", 0], 0)):
        for rule in json.loads(call_stiction(*read, *more, cwd=where).stdout)["answers"][0]["rules"]:
            assert rule["lower"] <= rule["value"] <= rule["upper"]
            known = table.loc[[rule["rule"]], ends].dropna().to_numpy()
            assert len(known) == 1
            assert not reported or known[0] == pytest.approx([rule["lower"], rule["upper"]], rel=1e-8)


@pytest.mark.parametrize("bodies", [["hole.csv", "lower.csv", "--offsets", 2], ["--gap", "hole.npy", *MAPS[2:]]])
def test_report_of_profiles_and_gaps_with_missing_points_is_written(where, tmp_path, bodies):
    lines, rows = profile("upper").heights.copy(), surface("upper").heights.copy()
    lines[300:340] = rows[10:14, 20:26] = np.nan
    np.savetxt(
        where / "hole.csv", np.column_stack([np.arange(2000) * 0.01, lines]), delimiter=",", header="x (um),z (um)"
    )
    np.save(where / "hole.npy", rows)
    options = ["--missing", "mask", "--mechanics", "half-space", "--onset", 0, "--output", tmp_path / "out"]
    check_stiction("pair", *bodies, *MATERIAL, *LOAD, *options, cwd=where)
    assert (tmp_path / "out" / "report.html").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--upper", "upper.csv", "--lower", "lower.csv"], ["materials, such as steel; the files come first"]),
        (
            [*PROFILES, "--upper", "upper.csv"],
            ["--upper must be the name of a material", "the files come first", "'upper.csv'"],
        ),
        ([*PROFILES, "--upper", "stele"], ["--upper must be", "steel"]),
        (PROFILES, ["--effective-modulus", "--young", "--upper"]),
        (
            [*PROFILES, "--lower", "glass", "--young", "3 MPa"],
            ["--young and --poisson must be one value each, of the body without a material"],
        ),
    ],
)
def test_pair_requires_materials_and_distinguishes_them_from_files(where, arguments, words):
    assert_rejected(call_stiction("pair", *arguments, *LOAD, "--mu0", "0.3", cwd=where), *words)


# ---- While it is computed --------------------------------------------------------------------------------------------


def test_preview_is_printed_to_standard_error_of_a_terminal(where, monkeypatch):
    for module in ("application", "pair"):
        monkeypatch.setattr(f"stiction.cli.{module}.has_terminal", lambda: True)
    command = ["pair", *MAPS, *MATERIAL, "--load", "10 MPa", "--shifts", 3, "--onset", 0, "--json", "-o", "first"]
    completed = check_stiction(*command, cwd=where, without_figures=True)
    assert "preliminary, with asperities: μ_s = " in completed.stderr
    assert json.loads(completed.stdout)["command"] == "pair"
    with contextlib.chdir(where):
        by_asperities = asked(where, *command[1:]).preview_study
        value = at_load(run(by_asperities), [float(by_asperities.friction.load[0])])["friction_all_round"]
    mean = float(value.sel(sliding="all", statistic="mean").squeeze())
    assert f"μ_s = {quoted(mean)}  friction at all contacts" in completed.stderr
    for arguments in ([*PROFILES, *LOAD], [*MAPS, "--load", "10 MPa", "--mechanics", "asperities"]):
        with contextlib.chdir(where):
            assert asked(where, *arguments, *MATERIAL).preview_study is None
    again = call_stiction(*command, cwd=where, without_figures=True)
    assert "preliminary" not in again.stderr, "what is there already has its answer"


SCANS = Path(__file__).parents[2] / "examples" / "scans"
STEEL_ON_BRASS = ["--upper", "steel", "--lower", "brass", "--mu0", "0.2", "--tau0", "50 MPa"]
HONED = ["--upper", "steel", "--lower", "steel", "--hardness", "2±0.1 GPa", "--mu0", "0.2±0.01", "--tau0", "20±2 MPa",
         "--adhesion", "0 mJ/m^2", "--load", "20 mN", "--mechanics", "half-space"]  # fmt: skip
RUBBER = ["--upper", "rubber", "--lower", "glass", "--mu0", "0.3", "--tau0", "200 kPa", "--load", "100 kPa"]


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    "arguments",
    [
        [SCANS / "lapped_upper.csv", SCANS / "lapped_lower.csv", *STEEL_ON_BRASS, "--load", "10 mN",
         "--mechanics", "half-space", "--offsets", 16],
        pytest.param([SCANS / "ground_upper.x3p", SCANS / "ground_lower.x3p", *STEEL_ON_BRASS, "--load", "10 MPa",
                      "--shifts", 4], marks=pytest.mark.soak),
        [*MAPS, *RUBBER, "--shifts", 4],
        [*MAPS, *STEEL_ON_BRASS, "--load", "10 MPa", "--shifts", 4],
        [SCANS / "honed_upper.csv", SCANS / "honed_lower.csv", *HONED],
    ],
    ids=["lapped", "ground", "rubber", "maps", "honed"],
)  # fmt: skip
def test_pair_output_fits_24_lines(where, arguments, tmp_path):
    completed = check_stiction("pair", *arguments, "-o", tmp_path / "out", cwd=where, columns=80)
    answer, _, paths = (completed.stderr + completed.stdout).partition(
        "wrote "
    )  # longer here than in a folder of one's own
    assert "report.html" in paths
    of_terminal = 1 + sum(1 + max(len(line) - 1, 0) // 80 for line in answer.splitlines())
    assert of_terminal <= 23, "the last one is the prompt"
    text = completed.stdout
    assert "μ_s" in text
    assert ("Quote it" in text) == ("2±0.1 GPa" in arguments)
    assert sum(text.count(words) for words in ("Quote it", "Quote with care", "Do not quote")) in (1, 2)
    assert not set(completed.stderr) & {"\x1b"}
    assert "warning" not in completed.stderr, "of what the user has not given"
    facts = [word for word in ("E* = ", "hardness 6", "μ0 = ", "positions alone") if text.count(word) > 1]
    assert not facts, "each fact once"


def test_value_and_assessment_are_bold_on_terminals_only(capsys, monkeypatch):
    lines = "μ_s = 0.29 [0.24, 0.42]  if all\nQuote with care; measure\nQuote withers\n"
    print_output(lines)
    assert capsys.readouterr().out == lines
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.setattr("typer.echo", print)
    print_output(lines)
    bold = capsys.readouterr().out
    assert bold.count("\x1b[1m") == 2
    assert "\x1b[1mμ_s = 0.29 [0.24, 0.42]\x1b[0m  if all" in bold
    assert "\x1b[1mQuote with care\x1b[0m; measure" in bold


def test_slow_reader_is_announced_once(where, monkeypatch):
    monkeypatch.setattr("stiction.cli.application.has_terminal", lambda: True)
    (where / "scan.di").write_text("nothing")
    monkeypatch.delitem(sys.modules, "SurfaceTopography", raising=False)
    events = []
    monkeypatch.setattr("stiction.cli.options.show_status", events.append)
    show_reader_import(where / "scan.di")
    show_reader_import(where / "upper.csv")
    show_reader_import(where / "missing.di")
    assert events == ["loading SurfaceTopography, which takes some seconds, to read scan.di"]
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    show_reader_import(where / "scan.di")
    assert len(events) == 1


# ---- From files to figures ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def checked(where):
    """Result of two profiles with both contact models."""
    completed = check_stiction(
        "pair", *PROFILES, *MATERIAL, *LOAD, "--offsets", 4, "--check", cwd=where, without_figures=True
    )
    return completed


@pytest.fixture(scope="module")
def areas(where):
    """Result of two maps with the asperity model."""
    completed = check_stiction(
        "pair", *MAPS, *MATERIAL, "--load", "10 MPa", "--shifts", 3, "--mechanics", "asperities", "-o", "areas",
        cwd=where, without_figures=True,
    )  # fmt: skip
    return completed


def test_pair_result_supports_commands_on_results(where, checked, areas):
    for folder in ("pair", "pair/half-space", "areas"):
        stored = store.read(where / folder)
        result = run(Study.from_toml(where / folder / "study.toml")).dataset
        for name, values in result.data_vars.items():
            np.testing.assert_array_equal(stored[name].values, values.values, err_msg=name)
        assert (where / folder / "result.csv").exists()
        assert list((where / folder).glob("*.png"))
        assert "</html>" in (where / folder / "report.html").read_text("utf-8")
    assert "By half-space" in checked.stdout
    again = ["pair", *PROFILES, *MATERIAL, *LOAD, "--offsets", 4, "--check", "--json"]
    again = call_stiction(*again, cwd=where, without_figures=True)
    assert json.loads(again.stdout)["check"][0]["values"]
    assert "wrote" in areas.stdout


@pytest.mark.usefixtures("undrawn")
def test_pair_resumes_with_same_options_and_rejects_others(where, areas):
    again = ["pair", *MAPS, *MATERIAL, "--load", "10 MPa", "--mechanics", "asperities", "-o", "areas"]
    completed = check_stiction(*again, "--shifts", 4, "--json", cwd=where)
    assert json.loads(completed.stdout)
    assert "3 of 4 repetitions already existed" in completed.stderr
    (where / "areas" / "picture.nc").unlink()
    check_stiction(*again, "--shifts", 4, cwd=where)
    assert (where / "areas" / "picture.nc").exists()
    assert_rejected(call_stiction(*again, "--shifts", 4, "--rotate", 10, cwd=where), "contains another study")
    check_stiction(*again, "--shifts", 2, "--rotate", 10, "--replace", cwd=where)
    assert store.open_stored(where / "areas").finished.size == 2


@pytest.mark.usefixtures("undrawn")
def test_pair_with_other_friction_uses_stored_positions(where):
    command = ("pair", *MAPS, "--effective-modulus", "10 GPa", "--mu0", "0.3", "--load", "1 MPa", "--shifts", 2)
    command += ("--mechanics", "asperities", "--onset", 0, "--output", "friction")
    check_stiction(*command, "--tau0", "0 MPa", cwd=where)
    recorded = sorted((where / "friction" / "blocks").iterdir())
    completed = check_stiction(*command, "--tau0", "50 MPa", cwd=where)
    assert "friction has results for other friction; its 2 repetitions are kept" in completed.stderr
    assert "friction.tau0 = " in completed.stderr
    assert sorted((where / "friction" / "blocks").iterdir()) == recorded


@pytest.mark.usefixtures("undrawn")
def test_pair_replaces_files_of_a_concurrent_writer(where, monkeypatch):
    """Two equal commands in one directory: both give a result."""
    from stiction.studies import contact_picture, onset

    def beside(make, file):
        def made(*args, **options):
            dataset = make(*args, **options)
            export(dataset, where / "twice" / file)
            return dataset

        return made

    for module, name in ((contact_picture, "contact_picture"), (onset, "compute_onset")):
        monkeypatch.setattr(module, name, beside(getattr(module, name), module.FILE))
    command = ("pair", *MAPS, *MATERIAL, "--load", "1 MPa", "--shifts", 2, "--mechanics", "asperities", "--onset", 2)
    completed = check_stiction(*command, "--output", "twice", cwd=where)
    assert "μ_s" in completed.stdout


@pytest.mark.usefixtures("undrawn")
def test_pair_in_parts_completes_result(where):
    arguments = ["pair", *PROFILES, *MATERIAL, *LOAD, "--mu0", "30", "--offsets", 4, "-o", "parts"]
    for part in ("1/2", "2/2"):
        check_stiction(*arguments, "--part", part, cwd=where)
    assert store.open_stored(where / "parts").finished.size == 4
    completed = check_stiction(*arguments, cwd=where)
    assert "not in per cent" in completed.stdout, "the caveat is printed, and the command continues"


@pytest.mark.usefixtures("undrawn")
def test_run_rejects_changed_scan_file(where):
    arguments = [
        "pair",
        "scan.npy",
        "lower.npy",
        *MAPS[2:],
        *MATERIAL,
        *LOAD,
        "--mechanics",
        "asperities",
        "-o",
        "other",
    ]
    np.save(where / "scan.npy", surface("upper", 48).heights)
    check_stiction(*arguments, "--shifts", 1, cwd=where)
    np.save(where / "scan.npy", -surface("upper", 48).heights)
    more = ["run", "other", "--set", "ensemble.repetitions=2"]
    assert_rejected(call_stiction(*more, cwd=where), "scan.npy", "has changed since")


# ---- Measured data --------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("undrawn")
def test_stylus_profile_slides_on_itself(measured, tmp_path):
    file = measured("dektak-1.csv")
    shifted = ["--travel", "200 um", "--offsets", "1", "--load", "10 mN", "--json"]
    check_stiction("pair", file, file, *MATERIAL, *shifted, cwd=tmp_path)
    result = store.read(tmp_path / "pair")
    assert float(result["x"][0]) == pytest.approx(200, abs=1)


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("lines", [4, 16])  # of four no interval of the mean is known
def test_pair_of_afm_map_and_surrogate_is_computed(measured, tmp_path, lines):
    pytest.importorskip("SurfaceTopography")
    file = measured("di-4.di")
    arguments = ["--lines", lines, "--surrogates", "lower", "--along", "y", "--json"]
    check_stiction("pair", file, file, *MATERIAL, *LOAD, *arguments, cwd=tmp_path)
    assert store.read(tmp_path / "pair")["surrogate"].values.all()


# ---- What is computed beside ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def beside(tmp_path_factory):
    """Two maps with named materials, large enough for cutoffs."""
    folder = tmp_path_factory.mktemp("beside")
    for side in ("upper", "lower"):
        created = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(96, 96), spacing=0.1, side=side)
        np.save(folder / f"{side}.npy", created.heights)
    arguments = ["--upper", "steel", "--lower", "brass", "--mu0", "0.2", "--tau0", "50 MPa", "--load", "10 MPa"]
    arguments += ["--shifts", 3, "--direction", "0,180", "--onset", 3]
    completed = check_stiction("pair", *MAPS, *arguments, "--json", cwd=folder)
    return folder, arguments, json.loads(completed.stdout)


def test_pair_reports_resolution_and_plastic_limit(beside):
    folder, _, record = beside
    resolution, answer = record["resolution"], record["answers"][0]
    assert resolution["waves"]["shortest_um"] == pytest.approx(0.2)
    assert [item["cut_off"] for item in resolution["cut_offs"]] == pytest.approx([0, 0.2], rel=1e-3)
    assert answer["finer_scans"]["from"] == pytest.approx(float(tabor_friction(0.625, 0.2, 0.05, 13.5)), rel=1e-3)
    assert answer["finer_scans"]["to"] >= answer["rules"][0]["value"]
    stored = store.read(folder / "pair" / "resolution")
    expected = run(Study.from_toml(folder / "pair" / "resolution" / "study.toml")).dataset
    np.testing.assert_array_equal(stored["contact_area"].values, expected["contact_area"].values)
    files = folder / "pair"
    assert (files / "onset.csv").exists()
    assert [path.name for path in files.glob("*.png")] == ["friction.png"]
    check_stiction("plot", "pair", cwd=folder)
    assert {"cut_off.png", "onset.png", "slip.png"} <= {path.name for path in files.iterdir()}


def test_pair_reports_onset_of_sliding(beside):
    folder, arguments, record = beside
    onset = record["onset"]
    assert onset["members"] == 3
    assert onset["poisson_ratio"] == pytest.approx([0.295, 0.35], abs=1e-3)
    assert 0 < onset["displacement_at_sliding"]["mean"] < 0.1
    # The same again computes nothing, and says the same as text.
    (folder / "pair/onset.csv").unlink()
    completed = call_stiction("pair", *MAPS, *arguments, "--verbose", cwd=folder, without_figures=True)
    assert "already contains this study" in completed.stdout
    assert not (folder / "pair/onset.csv").exists()
    assert onset["sentence"][:12] in completed.stdout
    assert "mild steel on brass" in completed.stdout
    assert "plastic limit" in completed.stdout


def test_scan_with_unattributed_hump_is_also_computed_filtered(tmp_path):
    clean = self_affine(4, hurst_exponent=0.7, rms=0.003, points=1500, spacing=0.0167, shortest_wavelength=0.2)
    frequency = np.fft.rfftfreq(1500, 0.0167)
    phases = np.exp(2j * np.pi * np.random.default_rng(3).uniform(size=frequency.size))
    noise = np.fft.irfft(((frequency > 8) & (frequency < 18)) * phases, 1500)
    noisy = stiction.Profile(clean.heights + 1.3e-4 * noise / noise.std(), spacing=0.0167)
    asked = {"load": "10 MPa", "mu0": 0.2, "effective_modulus": "80 GPa"}
    studies = {
        name: Pair.from_values(upper=body, lower=body, **asked, **more).study
        for name, body, more in (
            ("clean", clean, {}), ("noisy", noisy, {}), ("vouched", noisy, {"cutoff": "none"}),
            ("cut", noisy, {"cutoff": "0.3 um"}),
        )
    }  # fmt: skip
    assert [study.surfaces.vouched for study in studies.values()] == [None, None, True, None]
    lengths = {name: [float(item) for item in study.surfaces.cut_off] for name, study in studies.items()}
    assert (lengths["clean"], lengths["vouched"], lengths["cut"]) == ([0.0], [0.0], [0.3])
    assert lengths["noisy"] == [0.0, stiction.instrument_limit(noisy).cut_off]
    (fault,) = [item for item in find_input_caveats(noisy, noisy, studies["cut"]) if item.severity == "fault"]
    assert fault.cut_off < 0.3  # so that the answer with this cut-off has no such caveat


def noisy_and_clean():
    clean = self_affine(4, hurst_exponent=0.8, rms=0.003, points=1500, spacing=0.0167, shortest_wavelength=0.3)
    noise = np.random.default_rng(1).normal(size=1500)
    return stiction.Profile(clean.heights + 5e-5 * noise, spacing=0.0167), clean


def test_noise_floor_is_filtered_from_its_scan_and_reported():
    noisy, clean = noisy_and_clean()
    limit = stiction.instrument_limit(noisy)
    assert (limit.origin, limit.matters) == ("instrument", True)
    asked = {"load": "10 MPa", "mu0": 0.2, "tau0": "50 MPa", "effective_modulus": "80 GPa", "offsets": 8}
    study = Pair.from_values(upper=noisy, lower=clean, **asked).study
    assert [float(item) for item in study.surfaces.cut_off] == [limit.cut_off, 0.0]
    assert study.surfaces.both_readings
    assert [float(item.max_cut_off) for item in (study.surfaces.upper, study.surfaces.lower)] == [limit.cut_off, 0.0]
    slider, track = load_bodies(study).member(0, limit.cut_off).pair
    raw_slider, raw_track = load_bodies(study).member(0, 0.0).pair
    assert np.array_equal(track.heights, raw_track.heights)
    assert not np.array_equal(slider.heights, raw_slider.heights)
    result = stiction.pair(noisy, clean, onset=0, **asked)
    filtered = result.summary().points[0]
    assert filtered.at["cut_off"] == limit.cut_off
    assert filtered.verdict != "Quote it"
    other = next(point for point in result.summary().points if point.at["cut_off"] == 0)
    assert other.covered
    assert filtered.lower <= other.lower <= other.upper <= filtered.upper
    assert result.to_dataframe()["cut-off (um)"].iloc[0] == pytest.approx(limit.cut_off)


def test_declared_texture_preserves_its_line_and_unknown_texture_is_rejected():
    _, clean = noisy_and_clean()
    humming = stiction.Profile(clean.heights + 2e-4 * np.sin(2 * np.pi * np.arange(1500) / 8), spacing=0.0167)
    asked = {"load": "10 MPa", "mu0": 0.2, "effective_modulus": "80 GPa"}
    study = Pair.from_values(upper=humming, lower=clean, **asked).study
    assert float(study.surfaces.cut_off[0]) == 0.0
    assert study.surfaces.both_readings
    ground = Pair.from_values(upper=humming, lower=clean, texture="ground", **asked).study
    assert [float(item) for item in ground.surfaces.cut_off] == [0.0]
    assert [ground.surfaces.upper.texture, ground.surfaces.lower.texture] == ["ground", "ground"]
    assert not any(item.severity == "fault" for item in find_input_caveats(humming, clean, ground))
    with pytest.raises(ValueError, match="must be turned, milled"):
        stiction.pair(humming, clean, texture="shiny", **asked)


def test_profiles_of_hard_materials_use_the_half_space(where):
    material = ["--mu0", "0.3", *LOAD, "--upper", "steel"]
    assert study_of(where, *PROFILES, *material, "--lower", "brass").contact.mechanics == "half-space"
    assert study_of(where, *PROFILES, *material, "--lower", "brass", "--lay", "grooves").contact.hardness is not None
    for others in (["--lower", "PDMS"], ["--lower", "brass", "--law", "hertz-sphere"], ["--mechanics", "asperities"]):
        assert study_of(where, *PROFILES, *material, *others).contact.mechanics == "asperities"


def test_force_on_width_becomes_force_per_strip(where):
    arguments = ["--effective-modulus", "10 GPa", "--mu0", "0.3"]
    wide = study_of(where, *PROFILES, *arguments, "--load", "5 N", "--width", "5 mm")
    assert [float(load) for load in wide.friction.load] == [1.0]
    both = study_of(where, *PROFILES, *arguments, "--load", "5 N", "--load", "2 MPa", "--width", "5 mm")
    assert [float(load) for load in both.friction.load] == [0.02, 1.0]
    for refused in (["--load", "2 MPa"], ["--load", "5 N", "--lay", "isotropic"]):
        with pytest.raises(ArgumentError, match="width"):
            study_of(where, *PROFILES, *arguments, *refused, "--width", "5 mm")


@pytest.mark.usefixtures("undrawn")
def test_result_of_profiles_lists_its_assumptions(where, tmp_path):
    arguments = ["pair", *PROFILES, "--upper", "steel", "--lower", "brass", "--mu0", "0.2", "--load", "40 MPa"]
    record = json.loads(check_stiction(*arguments, "--offsets", 8, "-o", tmp_path / "out", "--json", cwd=where).stdout)
    assumed = record["answers"][0]["assumptions"]
    assert assumed == ["parallel grooves across the scans on a strip 1 µm wide", "no adhesion"]
    completed = check_stiction("at", tmp_path / "out", cwd=where)
    text = " ".join(completed.stdout.split())
    assert "Assumes parallel grooves across the scans on a strip 1 µm wide, no adhesion." in text
    table = (tmp_path / "out" / "result.csv").read_text()
    assert "; ".join(assumed) in table
    assert "taken as grooved" not in completed.stderr
