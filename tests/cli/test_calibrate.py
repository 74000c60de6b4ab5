"""Tests of `stiction calibrate` with friction tests on computed pairs and on a ball."""

import json

import numpy as np
import pytest
from stiction import (
    Ball,
    FrictionTest,
    Profile,
    Result,
    calibrate,
    interface,
    read_interface,
    run,
    self_affine_surface,
    write_interface,
    write_profile,
    write_surface,
)
from stiction._number_format import format_with_unit
from stiction.calibration.tests_file import parse_friction_tests
from stiction.solve.store import open_stored_result
from support.command import assert_rejected, call_stiction, check_stiction
from support.generated_studies import TINY_STUDY

TRUE_MU0, TRUE_TAU0 = 0.15, 0.012
BALL_OPTIONS = ("--ball", "5 mm", "--effective-modulus", "3 GPa")


def write_table(path, rows, header="load (mN),coefficient,uncertainty (%)"):
    path.write_text("\n".join(["# measured", header, *(",".join(map(str, row)) for row in rows)]) + "\n", "utf-8")
    return path


def create_ball_test_rows():
    """Return the load, the exact coefficient and the uncertainty (%) of five friction tests on a ball."""
    ball = Ball("5 mm", "3 GPa")
    return [(load, TRUE_MU0 + TRUE_TAU0 * ball.area_per_load(load), 3) for load in (5.0, 20.0, 100.0, 500.0, 2000.0)]


@pytest.fixture(scope="module")
def two_finishes_directory(tmp_path_factory):
    """Directory with results of a ground and of a lapped elastic pair, and with a table of their friction forces."""
    directory = tmp_path_factory.mktemp("finishes")
    rows = []
    for name, rms in (("ground", 0.04), ("lapped", 0.01)):
        for side, seed in (("upper", 1), ("lower", 2)):
            surface = self_affine_surface(seed, hurst_exponent=0.8, rms=rms, shape=(48, 48), spacing=0.1, side=side)
            write_surface(surface, directory / f"{name}_{side}.csv")
        check_stiction(
            "pair",
            f"{name}_upper.csv",
            f"{name}_lower.csv",
            "--effective-modulus",
            "80 GPa",
            "--mu0",
            TRUE_MU0,
            "--tau0",
            "300 MPa",
            "--load",
            "40 MPa",
            "--load",
            "160 MPa",
            "--shifts",
            4,
            "--onset",
            0,
            "-o",
            name,
            cwd=directory,
            without_figures=True,
            without_report=True,
        )
        result = Result(open_stored_result(directory / name))
        for load in (40, 80, 160):
            friction = result.at(f"{load} MPa", mu0=TRUE_MU0, tau0="300 MPa")["mean_friction"].sel(sliding="all")
            coefficient, force = float(friction.sel(statistic="mean").squeeze()), 1e-3 * load * result.nominal_area
            rows.append((1e-3 * force, 1e3 * force * coefficient, 20 * force * coefficient, name, f"{name} {load}", 1))
    write_table(directory / "forces.csv", rows, "load (N),force (uN),uncertainty (uN),pair,run,slid")
    return directory


def test_calibrate_command_recovers_and_stores_mu0_and_tau0_of_ball_tests(tmp_path):
    write_table(tmp_path / "forces.csv", create_ball_test_rows())
    completed = check_stiction("calibrate", "forces.csv", *BALL_OPTIONS, "-o", "film", cwd=tmp_path)
    first_line, *other_lines = completed.stdout.splitlines()
    assert first_line.startswith("μ0 + τ0 A/F = ")
    assert other_lines[0].startswith("μ0 = 0.1")
    assert float(other_lines[1].removeprefix("τ0 = ").split()[0]) == pytest.approx(12, rel=0.01)
    # The result has only one χ², because a smooth ball has the same area under both sliding rules.
    assert completed.stdout.count("χ²") == 1
    stored_interface = read_interface(tmp_path / "film")
    assert stored_interface.separated
    assert stored_interface.about["surfaces"] == "ball"
    assert (tmp_path / "film.png").read_bytes().startswith(b"\x89PNG")


def test_calibrate_command_requires_two_surface_finishes_to_separate_mu0_from_tau0(two_finishes_directory):
    arguments = ["forces.csv", "--pair", "ground", "--pair", "lapped/", "--sliding", "all", "--json"]
    record = json.loads(
        check_stiction("calibrate", *arguments, cwd=two_finishes_directory, without_figures=True).stdout
    )
    assert (record["kind"], record["separated"]) == ("interface", True)
    values = {item["name"]: item for item in record["values"]}
    assert values["mu0"]["lower"] < TRUE_MU0 < values["mu0"]["upper"]
    assert values["tau0"]["lower"] < 0.3 < values["tau0"]["upper"]
    single_pair = check_stiction(
        "calibrate", "--pair", "ground", "--load", "80 MPa", "--measured", "0.25±0.01", cwd=two_finishes_directory
    )
    assert "The tests determine only the sum μ0 + τ0 A/F" in " ".join(single_pair.stdout.split())
    assert "smooth ball" in single_pair.stdout


def test_calibrate_command_ranks_proposed_tests_by_the_remaining_interval_for_the_target_pair(two_finishes_directory):
    arguments = ["--pair", "ground", "--load", "80 MPa", "--measured", "0.25±0.01", "--target", "lapped"]
    text = check_stiction("calibrate", *arguments, cwd=two_finishes_directory).stdout
    assert "± μ0" not in text
    words = " ".join(text.split())
    assert "The fit assumes a further error of 2 % that all tests share (--common)." in words
    assert "Each of these tests has an error of 4 %, the median of your tests." in words
    record = json.loads(check_stiction("calibrate", *arguments, "--json", cwd=two_finishes_directory).stdout)
    assert [entry["text"].split("(")[1] for entry in record["predicted"]] == ["40 MPa)", "160 MPa)"]
    assert record["common"] == 0.02
    assert f"further tests, by the interval at {record['predicted'][0]['text']} " in words
    plans = record["further_tests"]
    widths = [entry["coefficient"]["upper"] - entry["coefficient"]["lower"] for entry in plans]
    present = record["predicted"][0]["coefficient"]
    assert plans[0]["text"] == "1 test of this pair at this load"
    assert widths == sorted(widths)
    assert widths[-1] < present["upper"] - present["lower"]
    rows = [line for line in text.splitlines() if line.startswith(tuple(entry["text"][:30] for entry in plans))]
    assert len(rows) == len(plans)


def test_calibrate_command_rejects_a_target_that_is_no_measured_pair(tmp_path):
    run(TINY_STUDY, store=tmp_path / "generated")
    arguments = ["--load", "20 mN", "--measured", "0.3±0.01", "--target", "generated"]
    completed = call_stiction("calibrate", *BALL_OPTIONS, *arguments, cwd=tmp_path)
    assert_rejected(completed, "--target must be the result of a measured pair with a load, got generated")


def test_error_about_missing_tested_surfaces_names_the_option_that_a_target_needs_in_addition(two_finishes_directory):
    arguments = ["--load", "80 MPa", "--measured", "0.25±0.01", "--target", "lapped"]
    completed = call_stiction("calibrate", *arguments, cwd=two_finishes_directory)
    assert_rejected(completed, "--pair DIR or --ball RADIUS must be given", "give --pair lapped too")


def test_calibrate_command_warns_about_a_ball_loaded_beyond_yield(tmp_path):
    options = ("--ball", "1 mm", "--upper", "PMMA", "--lower", "glass", "--load", "5 N", "--measured", "0.3±0.01")
    completed = check_stiction("calibrate", *options, cwd=tmp_path)
    assert "may exceed the yield limit" in completed.stderr


def test_caveat_about_a_yielding_ball_states_pressures_and_the_maximum_load_of_usable_tests(tmp_path):
    materials = {"upper_material": "PMMA", "lower_material": "glass"}
    ball = Ball("1 mm", **materials)
    yield_limit = 0.39 * ball.elasticity.hardness
    # The mean pressure of a Hertz contact is proportional to the cube root of the load.
    yield_load = (yield_limit * ball.area_per_load(1.0)) ** 3
    loads = [factor * yield_load for factor in (0.3, 0.9, 1.1, 4, 8)]
    write_table(tmp_path / "forces.csv", [(repr(load), 0.3, 3) for load in loads])
    options = ("--ball", "1 mm", "--upper", "PMMA", "--lower", "glass")
    message = " ".join(check_stiction("calibrate", "forces.csv", *options, cwd=tmp_path).stderr.split())
    assert f"{format_with_unit(2 * yield_limit, 'GPa')} in the test at {format_with_unit(loads[-1], 'mN')}" in message
    assert f"may exceed the yield limit, {format_with_unit(yield_limit, 'GPa')} (0.39 times the hardness)" in message
    assert f"leave out the 3 tests of the ball above {format_with_unit(yield_load, 'mN')}" in message
    assert "larger ball" in message
    write_table(tmp_path / "forces.csv", [(repr(load), 0.3, 3) for load in loads[:2]])
    assert check_stiction("calibrate", "forces.csv", *options, cwd=tmp_path).stderr == ""


def test_caveat_about_a_yielding_ball_uses_the_hardness_with_which_a_pair_of_its_materials_was_computed(tmp_path):
    for side in ("upper", "lower"):
        surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.1, shape=(24, 24), spacing=0.5, side=side)
        write_surface(surface, tmp_path / f"{side}.csv")
    materials = ("--upper", "steel", "--lower", "grey cast iron")
    options = ("--hardness", "1.9 GPa", "--mu0", 0.2, "--load", "100 MPa", "--shifts", 4, "--onset", 0, "-o", "fit")
    check_stiction(
        "pair", "upper.csv", "lower.csv", *materials, *options, cwd=tmp_path, without_figures=True, without_report=True
    )
    rows = ["pair,load (N),load (MPa),coefficient,uncertainty (%)", "ball,100,,0.3,3", "fit,,100,0.3,3"]
    (tmp_path / "forces.csv").write_text("\n".join(rows), "utf-8")
    arguments = ("forces.csv", "--pair", "fit", "--ball", "5 mm", "--sliding", "all")
    messages = [
        " ".join(check_stiction("calibrate", *arguments, *bodies, cwd=tmp_path, without_figures=True).stderr.split())
        for bodies in (materials, ("--upper", "steel", "--lower", "steel"))
    ]
    assert "the yield limit, 741 MPa (0.39 times the hardness of fit, 1.9 GPa)" in messages[0]
    assert "(0.39 times the hardness)" in messages[1]  # the pair has other materials


def test_calibrate_command_accepts_ball_options_if_no_friction_test_used_a_ball(two_finishes_directory):
    ball = ("--ball", "1 mm", "--upper", "PMMA", "--lower", "glass")
    arguments = ("forces.csv", "--pair", "ground", "--pair", "lapped", *ball, "--sliding", "all")
    completed = check_stiction("calibrate", *arguments, cwd=two_finishes_directory, without_figures=True)
    assert "yield limit" not in completed.stderr


def test_calibrate_command_reports_caveats_and_lay_of_the_tested_pairs(tmp_path):
    for side, seed in (("upper", 1), ("lower", 2)):
        surface = self_affine_surface(seed, hurst_exponent=0.8, rms=0.05, shape=(512, 512), spacing=0.1, side=side)
        write_profile(Profile(surface.heights[0], spacing=0.1), tmp_path / f"{side}.csv")
    options = ("--effective-modulus", "80 GPa", "--mu0", 0.2, "--offsets", 8, "--onset", 0)
    loads = ("--load", "0.1 MPa", "--load", "200 MPa")
    check_stiction(
        "pair", "upper.csv", "lower.csv", *options, *loads, "--mechanics", "half-space", "-o", "grooves",
        cwd=tmp_path, without_figures=True, without_report=True,
    )  # fmt: skip
    result = Result(open_stored_result(tmp_path / "grooves"))
    fault = result.summary("0.1 MPa").first.faults[0]
    arguments = ("calibrate", "--pair", "grooves", "--measured", "0.25±0.01", "--load")
    output = " ".join(check_stiction(*arguments, "0.1 MPa", cwd=tmp_path).stdout.split())
    assert "! grooves at " in output
    assert "(100 kPa), do not quote: " in output
    assert fault.text in output
    assert "grooves: computed for parallel grooves across the scans" in output
    record = json.loads(check_stiction(*arguments, "0.1 MPa", "--json", cwd=tmp_path).stdout)
    assert fault.text in record["pair_caveats"][0]
    assert len(record["lays"]) == 1
    check_stiction(*arguments, "0.1 MPa", "-o", "law", cwd=tmp_path, without_figures=True)
    assert fault.text in read_interface(tmp_path / "law").about["do not quote"]
    interface = calibrate([FrictionTest(result, "0.1 MPa", coefficient=0.25, uncertainty=0.01)])
    write_interface(interface, tmp_path / "python_law")
    caveats = [read_interface(tmp_path / name).about["do not quote"] for name in ("law", "python_law")]
    assert caveats[0] == caveats[1]
    (tmp_path / "grooves").rename(tmp_path / "target")
    ball = ("calibrate", "--ball", "1 mm", "--effective-modulus", "80 GPa", "--measured", "0.25±0.01", "--load", "1 mN")
    record = json.loads(check_stiction(*ball, "--target", "target", "--json", cwd=tmp_path).stdout)
    assert [lay.split(". ")[0] for lay in record["lays"]] == [
        "target: computed for parallel grooves across the scans on a strip 1 µm wide"
    ]


def test_calibrate_command_requests_missing_uncertainties_if_both_sliding_rules_were_fitted(two_finishes_directory):
    rows = ["load (mN),coefficient,pair", *(f"{load},0.2{load},ground" for load in (1, 2, 3))]
    (two_finishes_directory / "no_errors.csv").write_text("\n".join(rows))
    for options, is_requested in (((), True), (("--sliding", "all"), False)):
        arguments = ("calibrate", "no_errors.csv", "--pair", "ground", *options)
        output = check_stiction(*arguments, cwd=two_finishes_directory).stdout
        assert ("add a column uncertainty (%)" in " ".join(output.split())) == is_requested


@pytest.mark.parametrize(
    ("header", "row", "expected_words"),
    [
        ("load,coefficient", (1, 0.2), "load (mN)"),
        ("load (mN),friction", (1, 0.2), "friction"),
        ("load (mN),force (mN),coefficient", (1, 1, 1), "either force or coefficient"),
        ("load (mN),force (mN),uncertainty", (1, 1, 1), "needs a unit if there is a column force"),
        ("load (mN),coefficient,pair", (1, 0.2, "lapped"), "line 3: pair must be one of ball"),
        ("load (mN),coefficient,slid", (1, 0.2, "maybe"), "slid must be 1"),
        ("load (mN),coefficient", (1,), "line 3: has 1 cells"),
        ("load (mN),coefficient", (1, "x"), "coefficient must be a number"),
        ("load (MPa),coefficient", (1, 0.2), "load has the unit"),
        ("load (MPa),force (N)", (1, 20), "needs the column coefficient instead of force"),
        ("load (mN),coefficient,uncertainty (%)", (1, 0.2, -1), "uncertainty must be"),
        ("load (mN),coefficient (mN)", (1, 0.2), "coefficient has no unit"),
        ("load (mN),coefficient (%),uncertainty (%)", (1, 20, 3), "ambiguous"),
        ("load (mN),coefficient (%),uncertainty", (1, 20, 3), "ambiguous"),
        ("load (mN),coefficient,run (mN)", (1, 0.2, "a"), "run has no unit"),
        ("load (mN),coefficient,wait (mN)", (1, 0.2, 3), "the unit of wait must be one of s"),
        ("load (mN),coefficient,mu", (1, 0.2, 3), "has the unknown column 'mu'"),
        ("load (mN),force (mN),friction force (mN)", (1, 0.2, 3), "has two columns for force"),
        ("load (N),coefficient,load (mN)", (1, 0.2, 3), "has two columns for load in units of force"),
        ("load (MPa),coefficient,normal load (kPa)", (1, 0.2, 3), "has two columns for load in units of pressure"),
        ("load (MPa),load (N),force (N)", ("", 1, 20), "needs the column coefficient instead of force"),
        ("load (N),load (MPa),coefficient", (1, 2, 0.2), "line 3: load must be in one of the columns load (N) or"),
        ("load (N),load (MPa),coefficient", (1, 2, 0.2), "or load (MPa), got both"),
        ("load (kPa),normal force (uN),coefficient", ("", "", 0.2), "load (uN) or load (kPa), got neither"),
        ("load (N),load (MPa),coefficient", ("", 2, 0.2), "line 3: load has the unit 'MPa'"),
        ("load (N),load (MPa),coefficient", ("", "2 MPa", 0.2), "line 3: load must be a number, got '2 MPa'"),
        ("load (mN);coefficient", ("1,250;2,250",), "decimal"),
        ("load (mN),coefficient", ("0,5", "0,25"), "semicolons"),
    ],
)
def test_calibrate_command_rejects_a_contradictory_table_of_friction_tests(tmp_path, header, row, expected_words):
    write_table(tmp_path / "forces.csv", [row], header)
    assert_rejected(call_stiction("calibrate", "forces.csv", *BALL_OPTIONS, cwd=tmp_path), "forces.csv", expected_words)


@pytest.mark.parametrize(
    ("arguments", "expected_words"),
    [
        (("forces.csv",), "--pair DIR or --ball"),
        (BALL_OPTIONS, "FORCES.csv must be given, or --load and --measured"),
        ((*BALL_OPTIONS, "--load", "1 mN"), "--load and --measured"),
        ((*BALL_OPTIONS, "--load", "1 mN", "--measured", "0.25"), "uncertainty must be given if there are fewer"),
        ((*BALL_OPTIONS, "--load", "1 mN", "--measured", "red"), "--measured must be a number"),
        (("forces.csv", *BALL_OPTIONS, "--load", "1 mN"), "cannot be combined with FORCES.csv"),
        (("forces.csv", "--ball", "5 mm"), "--effective-modulus"),
        (("forces.csv", *BALL_OPTIONS, "--sliding", "none"), "sliding"),
        (("none.csv", *BALL_OPTIONS), "none.csv"),
        (("forces.csv", "--pair", "."), "not a result"),
        (("forces.csv", "--pair", ".", "--upper", "steel"), "not a result"),
    ],
)
def test_calibrate_command_rejects_conflicting_arguments(tmp_path, arguments, expected_words):
    write_table(tmp_path / "forces.csv", create_ball_test_rows())
    assert_rejected(call_stiction("calibrate", *arguments, cwd=tmp_path), expected_words)


def test_calibrate_command_accepts_semicolons_and_a_friction_test_that_did_not_slide(tmp_path):
    text = "load (mN);coefficient;uncertainty;slid\n" + "\n".join(
        f"{load};{coefficient};{0.03 * coefficient};1" for load, coefficient, _ in create_ball_test_rows()
    )
    (tmp_path / "forces.csv").write_text(f"{text}\n50;0.1;0.01;0\n", encoding="utf-8")
    completed = check_stiction("calibrate", "forces.csv", *BALL_OPTIONS, "--json", cwd=tmp_path)
    assert np.isclose(json.loads(completed.stdout)["fits"][0]["degrees_of_freedom"], 3)


def test_calibration_record_has_no_chi_squared_if_friction_tests_have_no_uncertainties(tmp_path):
    # Exact coefficients without errors would take 30 times as long as coefficients that scatter.
    scattered_rows = [
        (load, coefficient * scatter, error)
        for (load, coefficient, error), scatter in zip(
            create_ball_test_rows(), (1.01, 0.99, 1.0, 1.01, 0.99), strict=True
        )
    ]
    for header, rows in (
        ("load (mN),coefficient,uncertainty", scattered_rows),
        ("load (mN),coefficient", [row[:2] for row in scattered_rows]),
    ):
        write_table(tmp_path / "forces.csv", rows, header)
        completed = check_stiction("calibrate", "forces.csv", *BALL_OPTIONS, "--json", cwd=tmp_path)
        (fit, *_) = json.loads(completed.stdout)["fits"]
        has_errors = "uncertainty" in header
        assert (fit["chi_squared"] is not None, fit["probability"] is not None) == (has_errors, has_errors)


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1", "utf-16", "utf-16-le"])
def test_friction_tests_with_semicolons_and_decimal_commas_are_read_in_any_encoding(tmp_path, encoding):
    rows = [
        f"{1e3 * load:g};{load * coefficient:.6g};{0.03 * load * coefficient:.6g}"
        for load, coefficient, _ in create_ball_test_rows()
    ]
    lines_with_points = ["load (uN);force (mN);uncertainty (mN)", *rows]
    lines_with_commas = [
        "normal load [µN];friction force (mN);uncertainty in mN",
        *(row.replace(".", ",") for row in rows),
    ]
    (tmp_path / "plain.csv").write_text("\n".join(lines_with_points), encoding="utf-8")
    (tmp_path / "commas.csv").write_text("\r\n".join(lines_with_commas), encoding=encoding)
    bodies = {"ball": Ball("5 mm", "3 GPa")}
    tests_with_points, tests_with_commas = (
        parse_friction_tests(tmp_path / f"{name}.csv", bodies) for name in ("plain", "commas")
    )
    for expected, test in zip(tests_with_points, tests_with_commas, strict=True):
        assert (expected.load, expected.coefficient, expected.uncertainty) == (
            test.load,
            test.coefficient,
            test.uncertainty,
        )


def test_error_line_number_counts_line_breaks_inside_quotation_marks(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text('load (mN),coefficient,run\n1,0.2,"first\nrun"\n# a comment\n2,0.3,second\n3,much,third\n')
    with pytest.raises(ValueError, match="line 6: coefficient must be a number"):
        parse_friction_tests(path, {"ball": Ball("5 mm", "3 GPa")})
    path.write_text(path.read_text().replace("much", "0.4"))
    assert [test.run for test in parse_friction_tests(path, {"ball": Ball("5 mm", "3 GPa")})] == [
        "first\nrun",
        "second",
        "third",
    ]


def test_row_of_a_pair_whose_name_starts_with_a_number_sign_is_not_a_comment(tmp_path):
    path = tmp_path / "tests.csv"
    path.write_text("# comment\npair,load (mN),coefficient\n#1,1,0.2\n#2 is a comment,2,0.3\n#1,3,0.4\n")
    tests = parse_friction_tests(path, {"#1": Ball("5 mm", "3 GPa")})
    assert [test.coefficient for test in tests] == [0.2, 0.4]


def test_friction_tests_are_converted_from_the_units_in_their_column_names(tmp_path):
    (tmp_path / "a.csv").write_text("load (mN),coefficient (%),uncertainty (mN)\n2000,50,20\n")
    (tmp_path / "b.csv").write_text("load (N),friction force (N),uncertainty (%)\n2,1,2\n")
    for name in ("a.csv", "b.csv"):
        (test,) = parse_friction_tests(tmp_path / name, {"ball": Ball("5 mm", "3 GPa")})
        assert (test.load, test.coefficient, test.uncertainty) == (2000, 0.5, pytest.approx(0.01))


@pytest.mark.parametrize("title", ["load (N)", "normal force (N)"])
def test_table_of_friction_tests_accepts_both_forces_on_balls_and_pressures_on_pairs(two_finishes_directory, title):
    path = two_finishes_directory / "ball_and_pair.csv"
    path.write_text(f"pair;{title};load (MPa);coefficient\nball;0,5;;0,2\nground;;80;0,3\nground;0,000002;;0,25\n")
    pair = Result(open_stored_result(two_finishes_directory / "ground"))
    ball_test, *pair_tests = parse_friction_tests(path, {"ball": Ball("5 mm", "3 GPa"), "ground": pair})
    assert (ball_test.load, ball_test.coefficient) == (500, 0.2)
    assert [test.load for test in pair_tests] == [pytest.approx(0.08 * pair.nominal_area), 0.002]
    assert [test.coefficient for test in pair_tests] == [0.3, 0.25]


def test_friction_test_at_a_pressure_rejects_an_uncertainty_of_the_force(two_finishes_directory):
    pair = Result(open_stored_result(two_finishes_directory / "ground"))
    with pytest.raises(ValueError, match="uncertainty must be a number or a percentage if the load is a pressure"):
        FrictionTest(pair, "80 MPa", coefficient=0.3, uncertainty="5 mN")
    assert FrictionTest(pair, "80 MPa", coefficient=0.3, uncertainty="10 %").uncertainty == pytest.approx(0.03)
    at_force = FrictionTest(pair, "0.002 mN", coefficient=0.3, uncertainty="0.00002 mN")
    assert at_force.uncertainty == pytest.approx(0.01)


@pytest.mark.usefixtures("all_input_samples")
@pytest.mark.parametrize(
    "ranges",
    [
        ("--effective-modulus", "2..4.5 GPa"),
        ("--young", "2..4.5 GPa,70 GPa", "--poisson", "0.35..0.39,0.22"),
        ("--upper", "PMMA", "--lower", "glass"),
    ],
)
def test_calibrated_interval_of_tau0_contains_values_fitted_at_both_limits_of_the_modulus(tmp_path, ranges):
    write_table(tmp_path / "forces.csv", create_ball_test_rows())
    arguments = ("calibrate", "forces.csv", "--ball", "5 mm", "--json", "--sliding", "all")
    completed = check_stiction(*arguments, *ranges, cwd=tmp_path, without_figures=True)
    interval = {value["name"]: value for value in json.loads(completed.stdout)["values"]}["tau0"]
    moduli_ends = {"--effective-modulus": ("2", "4.5"), "--young": ("2.25", "4.86"), "--upper": ("2.49", "3.53")}[
        ranges[0]
    ]
    for modulus in moduli_ends:
        completed = check_stiction(
            *arguments, "--effective-modulus", f"{modulus} GPa", cwd=tmp_path, without_figures=True
        )
        tau0 = {value["name"]: value for value in json.loads(completed.stdout)["values"]}["tau0"]["value"]
        assert interval["lower"] < tau0 < interval["upper"]


def test_interfaces_command_lists_stored_interfaces_of_a_directory_or_file(tmp_path):
    write_interface(interface("MoS2 on bearing steel, dry air"), tmp_path / "film", {"operator": "A. B."})
    (tmp_path / "notes.txt").write_text("nothing")
    completed = call_stiction("interfaces", ".", cwd=tmp_path)
    assert completed.stdout.splitlines()[0] == "film"
    assert "operator A. B." in completed.stdout
    assert "notes" not in completed.stdout
    assert_rejected(call_stiction("interfaces", "nowhere", cwd=tmp_path), "nowhere", "listed")
    assert call_stiction("interfaces", "film", cwd=tmp_path).stdout == completed.stdout
    assert_rejected(call_stiction("interfaces", "notes.txt", cwd=tmp_path), "notes.txt", "not an interface file")
    (tmp_path / "empty").mkdir()
    assert "empty contains no interfaces" in call_stiction("interfaces", "empty", cwd=tmp_path).stdout
