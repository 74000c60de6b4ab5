"""Test joint tables against `Result.at`, their files, and the card of CalculiX in a finite-element model."""

import copy
import io
import json
import pickle
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pandas
import pytest
from stiction import half_space, material, open_result, pair, self_affine_surface
from stiction.study.members import read_measured_bodies
from stiction.summary.evaluation import Evaluation
from stiction.summary.joint_table import STIFFNESS_OVER_MEASURED_STIFFNESS, build_joint_table
from stiction.views.files import summary_csv
from stiction.views.rows import summary_table
from stiction.views.style import axis_label
from support.command import assert_rejected, call_stiction, check_stiction

pytestmark = pytest.mark.usefixtures("no_companion_files")

ROOT = Path(__file__).parents[2]
SAMPLE_SCANS = ROOT / "examples/scans"
CONDITION_OF_MODEL_ERROR = "two mated rock fractures of 86 mm at 1 to 9.8 MPa; unknown for other faces and pressures"
# Units of length (in µm) and stress (in GPa) of each unit system.
UNIT_SYSTEMS = {"mm,N,MPa": (1e3, 1e-3), "m,N,Pa": (1e6, 1e-9), "um,mN,GPa": (1.0, 1.0)}
NUM_POSITIONS = 8
NUMBER_PATTERN = r"[0-9]+(?:\.[0-9]+)?(?:e[-+]?[0-9]+)?"


@pytest.fixture(scope="module", autouse=True)
def evaluate_once():
    """Evaluate each result only once at the same loads, because files in all units and formats show the same values.

    For the same reason, the joint table of a result in one system of units is computed only once.
    """

    def compute_once(method):
        values = {}

        def compute_or_copy(result, *arguments, **options):
            call_key = id(result), pickle.dumps((arguments, options))
            if call_key not in values:
                values[call_key] = result, method(result, *arguments, **options)
            return copy.deepcopy(values[call_key][1])

        return compute_or_copy

    with pytest.MonkeyPatch.context() as patch:
        for name in ("at", "joint_table"):
            patch.setattr(Evaluation, name, compute_once(getattr(Evaluation, name)))
        yield


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    return tmp_path_factory.mktemp("joint")


@pytest.fixture(scope="module")
def result(directory):
    """Return the result of the pair in README, with fewer positions."""
    return pair(
        SAMPLE_SCANS / "lapped_upper.csv", SAMPLE_SCANS / "lapped_lower.csv", upper="steel", lower="brass",
        hardness="120 HV ± 10 %", mu0=0.2, tau0="50 MPa", load="50 MPa", offsets=NUM_POSITIONS, onset=0,
        directory=directory / "pair",
    )  # fmt: skip


@pytest.fixture(scope="module")
def table(result):
    return result.joint_table()


@pytest.fixture(scope="module")
def values(result, table):
    """Return the values of the result at the loads of its joint table."""
    return result.at([row.load for row in table.rows]).sel(sliding="all").squeeze()


def get_closure(row):
    return row.estimates["closure"].value


def export_text(result, path, **options):
    path.unlink(missing_ok=True)
    result.export(path, **options)
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize("units", UNIT_SYSTEMS)
def test_joint_table_contains_the_values_of_the_result_at_each_nominal_pressure(result, values, units):
    length, pressure = UNIT_SYSTEMS[units]
    table = result.joint_table(units=units)
    loads = np.array([row.load for row in table.rows])
    steps = result.study.contact.loading_steps()
    assert [row.load for row in table.rows if row.is_computed] == pytest.approx(steps)
    assert (loads[1:] / loads[:-1]).max() < 1.16
    assert loads.tolist() == values["load"].values.tolist()
    pressures = [row.pressure.value * pressure for row in table.rows]
    assert pressures == pytest.approx((loads / result.nominal_area).tolist())
    factors = {
        "closure": length, "closure_stiffness": 1e6 * pressure / length, "contact_area_fraction": 1.0,
        "unloading_closure_stiffness": 1e6 * pressure / length, "friction_combined": 1.0,
        "tangential_stiffness_per_area": 1e6 * pressure / length,
    }  # fmt: skip
    kinds = {}
    for name, factor in factors.items():
        estimates = [row.estimates[name] for row in table.rows]
        in_table = np.array([[estimate.value, estimate.lower, estimate.upper] for estimate in estimates])
        expected = values[name].sel(statistic=["mean", "lower", "upper"])
        np.testing.assert_allclose(in_table * factor, expected, rtol=1e-12)
        (kinds[name],) = {estimate.kind for estimate in estimates}
    assert set(kinds.values()) == {"combined"}
    for percentile in (5, 50, 95):
        percentiles = [row.friction(percentile) for row in table.rows]
        expected = values["friction_percentiles"].sel(percentile=percentile)
        np.testing.assert_allclose([estimate.value for estimate in percentiles], expected)
        assert {estimate.kind for estimate in percentiles} == {"prediction"}


def test_tangential_stiffness_of_a_joint_with_parallel_grooves_equals_its_unloading_stiffness(table):
    for row in table.rows:
        unloading = row.estimates["unloading_closure_stiffness"].value
        assert row.estimates["tangential_stiffness_per_area"].value == pytest.approx(unloading)
        assert row.estimates["closure_stiffness"].value <= unloading * 1.001
    (note,) = [note for note in table.notes if "parallel grooves" in note]
    (first_shear, first_poisson), (second_shear, second_poisson) = (
        (metal.young_modulus / (2 + 2 * metal.poisson_ratio), metal.poisson_ratio)
        for metal in (material("mild steel"), material("brass"))
    )
    # Dundurs' constant β of steel on brass in plane strain
    beta = (first_shear * (1 - 2 * second_poisson) - second_shear * (1 - 2 * first_poisson)) / (
        2 * (first_shear * (1 - second_poisson) + second_shear * (1 - first_poisson))
    )
    assert f"beta is {abs(beta):.1g}," in note


def test_joint_table_assesses_the_coefficient_at_each_pressure(result, directory, table):
    loads = [row.load for row in table.rows]
    expected = [point.assessment for point in result.summarize_dataset(result.at(loads)).reported_points]
    assert {"Do not quote", "Quote with care"} <= set(expected)
    assert [row.assessment for row in table.rows] == expected
    frame = pandas.read_csv(io.StringIO(export_text(result, directory / "joint.csv", joint=True)))
    assert frame["assessment of mu_s"].tolist() == expected
    card_lines = export_text(result, directory / "joint.inp", joint=True).splitlines()
    rows = [line.rsplit("; ", 1)[1] for line in card_lines if line.endswith(("; Do not quote", "; Quote with care"))]
    assert rows == expected
    assert any(
        f"Do not quote ({expected.count('Do not quote')} of {len(expected)} pressures)" in note for note in table.notes
    )


def test_joint_table_of_maps_states_mindlins_ratio_and_missing_percentiles():
    bodies = [
        self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(48, 48), spacing=0.1, side=side)
        for side in ("upper", "lower")
    ]
    result = pair(*bodies, load="10 MPa", young="200 GPa,100 GPa", poisson="0.3,0.35", mu0=0.2, shifts=1, onset=0)
    table = result.joint_table("20 MPa", mu0=0.4)
    compliances = [(1 - nu**2) / young_modulus for nu, young_modulus in ((0.3, 200), (0.35, 100))]
    tangential = [(2 - nu) * (1 + nu) / (2 * young_modulus) for nu, young_modulus in ((0.3, 200), (0.35, 100))]
    (row,) = table.rows
    assert row.pressure.value == pytest.approx(20)
    assert table.mu0 == 0.4
    ratio = row.estimates["tangential_stiffness_per_area"].value / row.estimates["unloading_closure_stiffness"].value
    assert ratio == pytest.approx(sum(compliances) / sum(tangential), rel=1e-2)
    assert any("Mindlin's ratio" in note and "0.3 and 0.35" in note for note in table.notes)
    assert any("at least three positions" in note for note in table.notes)
    assert row.friction(5).status == "no-prediction"


def read_card_numbers(card):
    """Return all numbers of a card as texts, except those within words and in the description above the table."""
    lines = [re.sub(r"^(\*\*|!|#) ", "", line) for line in card.splitlines()]
    text = " ".join(lines)
    valid_range = re.search(r"Valid from .*?\. Below", text)[0]
    text = re.sub(r"\b(5|50|95) %|INTER19[25]", "", f"{valid_range} {text[text.index('Table: ') :]}")
    return re.findall(rf"(?<![\w.]){NUMBER_PATTERN}(?![\w.]*[A-Za-z])", text)


@pytest.mark.parametrize("units", UNIT_SYSTEMS)
def test_csv_file_of_a_joint_table_contains_every_number_of_the_table(result, directory, units):
    table = result.joint_table(units=units)
    csv = export_text(result, directory / "joint.csv", joint=True, units=units)
    frame = pandas.read_csv(directory / "joint.csv")
    cells = {cell for line in csv.splitlines()[1:] for cell in line.split(",")}
    estimates = [estimate for row in table.rows for estimate in row.estimates.values()]
    values = [
        number
        for estimate in estimates
        for number in (estimate.value, estimate.lower, estimate.upper)
        if not np.isnan(number)
    ]
    in_rows = {f"{value:.9g}" for value in values}
    model_errors = {f"0.45 to 1.19 times the measured stiffness ({CONDITION_OF_MODEL_ERROR})", "not validated"}
    inputs = {f"{table.mu0:.9g}", f"{table.tau0 / UNIT_SYSTEMS[units][1]:.9g}", table.sliding}
    assert cells - in_rows - model_errors - inputs == {
        "0", "1", "combined", "prediction", "Do not quote", "Quote with care",
    }  # fmt: skip
    assert inputs <= cells
    assert in_rows <= cells
    assert len(frame) == len(table.rows)
    assert frame.filter(like="kind").nunique().eq(1).all()
    record = json.loads(export_text(result, directory / "joint.json", joint=True, units=units))
    in_record = {f"{value[name]:.9g}" for value in record["values"] for name in ("value", "lower", "upper")
                 if value[name] is not None}  # fmt: skip
    assert in_record == in_rows
    rounded = {f"{value:.{digits}g}" for value in values for digits in (4, 6)}
    for ending in (".inp", ".mac", ".liggghts"):
        card = export_text(result, directory / f"card{ending}", units=units)
        numbers = read_card_numbers(card)
        assert len(numbers) > 5 * len(frame)
        # Numbers in a card that are no results: the origin of the curve, and counts of materials, constants and points.
        assert set(numbers) - rounded <= {"0", "1", "2", str(len(frame))}, ending
        assert card.isascii()
        assert max(map(len, card.splitlines())) < 256
    assert f"{get_closure(table.reference):.6g}" in export_text(result, directory / "card.inp", units=units)


def test_friction_and_stiffness_in_an_exported_solver_input_have_at_most_four_digits(result, directory):
    """Pressures and closures have six, because other programs derive the stiffness from their differences."""
    friction, stiffness = re.search(
        r"^\*FRICTION\n(.*), (.*)$", export_text(result, directory / "card.inp"), re.M
    ).groups()
    assert max(len(re.sub(r"^0\.0*|\.|e.*", "", number)) for number in (friction, stiffness)) <= 4
    card = export_text(result, directory / "card.inp")
    assert len(re.findall(r"^50, ", card, re.MULTILINE)) == 1
    assert len(re.findall(r"^\*\* 0\..*, , 50$", card, re.MULTILINE)) == 1


def test_computed_joint_table_has_the_stiffness_of_direct_solutions_at_every_pressure(result, directory):
    check_stiction("export", "pair", "computed.csv", "--joint", "--compute", cwd=directory)
    frame = pandas.read_csv(directory / "computed.csv")
    assert frame["computed"].all()
    computed_result = open_result(directory / "pair/joint")
    pressures = frame["nominal pressure (MPa)"].to_numpy()
    values_at_pressures = computed_result.at([f"{pressure} MPa" for pressure in pressures]).sel(sliding="all").squeeze()
    for name, title in (
        ("closure_stiffness", "stiffness of closure"),
        ("tangential_stiffness_per_area", "tangential stiffness"),
    ):
        np.testing.assert_allclose(
            frame[f"{title} (MPa/mm)"], values_at_pressures[name].sel(statistic="mean"), rtol=1e-6
        )
    study = result.study
    bodies, contact = read_measured_bodies(study), study.contact.solver_arguments()
    pairs = [bodies.member(member, 0.0).pair for member in range(NUM_POSITIONS)]
    for index in (2, 14, 30):
        loads = result.nominal_area * 1e-3 * pressures[index] * np.array([0.999, 1.001])
        closures = np.mean([half_space(*pair, loads, **contact).closure for pair in pairs], axis=0)
        expected = 1e3 * np.diff(loads)[0] / result.nominal_area / (1e-3 * np.diff(closures)[0])
        assert frame["stiffness of closure (MPa/mm)"][index] == pytest.approx(expected, rel=0.01)
    interpolated_table = pandas.read_csv(io.StringIO(export_text(result, directory / "joint.csv", joint=True)))
    assert interpolated_table["nominal pressure (MPa)"].tolist() == pytest.approx(pressures.tolist())
    assert 0 < interpolated_table["computed"].sum() < len(frame)
    assert any("--compute" in note for note in result.joint_table().notes)
    assert not any("--compute" in note for note in computed_result.joint_table().notes)


def test_result_evaluated_for_one_quantity_has_the_interval_of_a_complete_evaluation(result):
    closure = result.at(quantities=["closure"])["closure"].squeeze()
    np.testing.assert_array_equal(closure, result.at()["closure"].squeeze())


def test_comments_in_exported_joint_files_state_units_and_materials_and_range_of_validity(result, directory):
    texts = {ending: export_text(result, directory / f"card{ending}") for ending in (".inp", ".mac", ".liggghts")}
    for text in texts.values():
        words = " ".join(re.sub("(?m)^(\\*\\*|!|#) ", "", text).split())
        for part in ("Units: mm, N, MPa", "mild steel on brass", "assessment:", "Valid from 5 to 500 MPa", "one value"):
            assert part in words.replace("one coefficient", "one value"), part
    assert "Set FKN and FKT of the contact to minus the" in " ".join(re.sub("(?m)^! ", "", texts[".mac"]).split())


def test_json_file_of_a_joint_table_contains_units_and_notes_and_kinds_of_intervals(result, directory, table):
    record = json.loads(export_text(result, directory / "joint.json", joint=True, units="um,mN,GPa"))
    assert record["units"] == {"length": "um", "force": "mN", "pressure": "GPa"}
    assert record["notes"][0] == table.notes[0]
    values = [value for value in record["values"] if value["at"]["load"] == table.reference.load]
    percentiles = {value["at"]["percentile"]: value["value"] for value in values if "percentile" in value["at"]}
    assert percentiles == {percentile: table.reference.friction(percentile).value for percentile in (5, 50, 95)}
    (closure,) = [value for value in values if value["name"] == "closure"]
    assert (closure["unit"], closure["kind"]) == ("um", "combined")
    inputs = {"mu0": 0.2, "tau0": 0.05, "load_unit": "mN", "tau0_unit": "GPa"}
    assert record["assessments"] == [
        {"load": row.load, "assessment": row.assessment} | inputs for row in table.rows
    ]  # fmt: skip


def test_joint_table_counts_closures_from_a_given_pressure(result, table):
    closure_by_pressure = {row.pressure.value: row.estimates["closure"] for row in table.rows}
    shifted_table = result.joint_table(closure_from="50 MPa", units="mm,N,MPa")
    start = closure_by_pressure[50.0]
    assert (shifted_table.closure_from.value, shifted_table.closure_from.unit) == (50.0, "MPa")
    assert table.closure_from.value == 0
    assert [row.pressure.value for row in shifted_table.rows] == [row.pressure.value for row in table.rows]
    for row in shifted_table.rows:
        shifted = row.estimates["closure"]
        assert shifted.value == pytest.approx(closure_by_pressure[row.pressure.value].value - start.value, abs=1e-15)
        if row.pressure.value == 50.0:
            assert shifted.value == 0
            assert not shifted.has_interval
        else:
            assert shifted.lower < shifted.value < shifted.upper
    # Near the pressure from which the closure is counted, its relative limits are those of the compliance.
    index = [row.pressure.value for row in table.rows].index(50.0) + 1
    shifted, stiffness = (shifted_table.rows[index].estimates[name] for name in ("closure", "closure_stiffness"))
    for limit, other_limit in (("lower", "upper"), ("upper", "lower")):
        ratio = stiffness.value / getattr(stiffness, other_limit)
        assert getattr(shifted, limit) / shifted.value == pytest.approx(ratio, rel=0.1)  # mean of both pressures
    assert any("since a nominal pressure of 50 MPa" in note for note in shifted_table.notes)
    assert any("since first contact" in note and "--closure-from" in note for note in table.notes)


def test_joint_table_includes_the_pressure_from_which_closures_are_counted(result):
    shifted_table = result.joint_table(["20 MPa", "80 MPa"], closure_from="7 MPa")
    assert [row.pressure.value for row in shifted_table.rows] == pytest.approx([7, 20, 80])
    assert get_closure(shifted_table.rows[0]) == 0
    first, last = (get_closure(row) for row in result.joint_table(["7 MPa", "80 MPa"]).rows)
    assert get_closure(shifted_table.rows[-1]) == pytest.approx(last - first)
    with pytest.raises(ValueError, match=r"closure_from must be a pressure .* \(5 MPa to 500 MPa\), got 1 MPa"):
        result.joint_table(closure_from="1 MPa")
    with pytest.raises(ValueError, match="closure_from must be a finite number above 0 mN, got -1"):
        result.joint_table(closure_from=-1)


@pytest.mark.parametrize("name", ["card.inp", "card.mac"])
def test_exported_curve_starts_with_the_stiffness_at_the_pressure_from_which_closures_are_counted(
    result, directory, name
):
    card = export_text(result, directory / name, closure_from="20 MPa")
    pattern = r"^([-\d.e+]+), ([-\d.e+]+)$" if name == "card.inp" else r"^TBPT,,([-\d.e+]+),([-\d.e+]+)$"
    points = np.array(re.findall(pattern, card.split("*FRICTION")[0], re.MULTILINE), float)
    points = points[points.any(axis=1)]  # without the origin
    pressures, closures = points.T if name == "card.inp" else points.T[::-1]
    (start,) = result.joint_table(["20 MPa"]).rows
    assert pressures[0] == 20
    assert (np.diff(closures) > 0).all()
    assert pressures[0] / closures[0] == pytest.approx(start.estimates["closure_stiffness"].value, rel=1e-4)
    last = result.joint_table().rows[-1]
    assert closures[-1] - closures[0] == pytest.approx(get_closure(last) - get_closure(start), rel=1e-4)
    words = " ".join(re.sub(r"(?m)^(\*\*|!) ", "", card).split())
    assert "Below 20 MPa, from which the closure is counted, the curve is a straight line" in words


def build_table_with_changed_stiffness(result, loads, start, changed_load, statistics, number=np.nan):
    """Return the joint table of a result, after the stiffness at one load was replaced by a number."""
    at = result.at(loads)
    is_replaced = (at["load"] == changed_load) & at["statistic"].isin(statistics)
    at["closure_stiffness"] = at["closure_stiffness"].where(~is_replaced, number)
    return build_joint_table(at, result.study, "mm,N,MPa", dict.fromkeys(loads, "Quote it"), start)


@pytest.mark.parametrize(("statistics", "number"), [(["lower", "upper"], np.nan), (["mean", "lower", "upper"], np.inf)])
def test_closure_has_no_interval_at_and_beyond_a_load_whose_stiffness_has_no_interval(
    result, table, statistics, number
):
    loads = [row.load for row in table.rows]
    start, count = 5, len(loads)
    for index, expected in ((2, range(3, count)), (start + 2, range(start + 2))):
        shifted_table = build_table_with_changed_stiffness(
            result, loads, loads[start], loads[index], statistics, number
        )
        with_interval = [
            number for number, row in enumerate(shifted_table.rows) if row.estimates["closure"].has_interval
        ]
        assert with_interval == [number for number in expected if number != start]


def test_joint_table_rejects_a_start_of_the_closure_at_which_the_stiffness_is_unknown(result, table):
    loads = [row.load for row in table.rows]
    message = "closure_from must be a pressure at which the stiffness of closure is known, got "
    with pytest.raises(ValueError, match=message):
        build_table_with_changed_stiffness(result, loads, loads[5], loads[5], ["mean", "lower", "upper"])


@pytest.mark.parametrize("name", ["card.inp", "card.mac"])
def test_intervals_in_comments_of_a_card_contain_the_closures_of_the_card(result, directory, name):
    for closure_from in (None, "20 MPa"):
        card = export_text(result, directory / name, closure_from=closure_from)
        pattern = r"^([-\d.e+]+), ([-\d.e+]+)$" if name == "card.inp" else r"^TBPT,,([-\d.e+]+),([-\d.e+]+)$"
        points = np.array(re.findall(pattern, card.split("*FRICTION")[0], re.MULTILINE), float)[
            :, :: -1 if name == "card.mac" else 1
        ]
        rows = re.findall(r"^(?:\*\*|!) ([\d.e+-]+); (?:\[([\d.e+-]+), ([\d.e+-]+)\])?;", card, re.MULTILINE)
        limits_by_pressure = {float(pressure): limits for pressure, *limits in rows}
        curve = [(pressure, closure) for pressure, closure in points.tolist() if pressure > 0]
        assert {pressure for pressure, limits in limits_by_pressure.items() if limits[0]} == {
            pressure for pressure, _ in curve if pressure != 20 or closure_from is None
        }
        for pressure, closure in curve:
            if limits_by_pressure[pressure][0]:
                lower, upper = map(float, limits_by_pressure[pressure])
                assert lower < closure < upper
        assert len(limits_by_pressure) > len(curve) if closure_from else len(limits_by_pressure) == len(curve)
        assert "are negative" not in " ".join(re.sub(r"(?m)^(\*\*|!) ", "", card).split())


def test_exported_joint_files_state_the_error_of_the_model_and_from_which_pressure_closures_are_counted(
    result, directory
):
    frame = pandas.read_csv(
        io.StringIO(export_text(result, directory / "joint.csv", joint=True, closure_from="20 MPa"))
    )
    assert frame["closure counted from (MPa)"].unique().tolist() == [20]
    (error,) = frame["stiffness of closure: model error (not in the interval)"].unique()
    assert error == f"0.45 to 1.19 times the measured stiffness ({CONDITION_OF_MODEL_ERROR})"
    assert frame["tangential stiffness: model error (not in the interval)"].unique().tolist() == ["not validated"]
    record = json.loads(export_text(result, directory / "joint.json", joint=True, load=["20 MPa", "80 MPa"]))
    assert (record["closure_from"]["value"], record["closure_from"]["unit"]) == (0, "MPa")
    errors = {error["name"]: error["computed_over_measured"] for error in record["model_errors"]}
    assert errors == {"closure_stiffness": [0.45, 1.19], "tangential_stiffness_per_area": None}
    assert record["model_errors"][0]["evidence"] == CONDITION_OF_MODEL_ERROR
    assert "(80 MPa)" in record["sentence"]  # the load of the table that is nearest to the load of the pair
    card = " ".join(re.sub("(?m)^# ", "", export_text(result, directory / "card.liggghts")).split())
    for words in (
        f"0.45 to 1.19 times the measured stiffness ({CONDITION_OF_MODEL_ERROR})",
        "This stiffness is not validated",
        "since first contact",
    ):
        assert words in card


def test_stiffness_of_closure_has_the_same_name_in_tables_joint_files_and_figures(result, directory):
    stiffness = result.at()["closure_stiffness"].sel(statistic="mean").values.ravel()[0]
    name = "stiffness of closure (MPa/mm)"
    assert float(summary_table(result.summary())[name].iloc[0]) == pytest.approx(float(stiffness), rel=1e-3)
    assert name in pandas.read_csv(io.StringIO(export_text(result, directory / "names.csv", joint=True)))
    assert axis_label("closure_stiffness") == name


def test_stated_error_of_the_model_covers_the_errors_of_the_measured_fractures():
    table = (ROOT / "docs/generated/fracture_errors.md").read_text(encoding="utf-8")
    tangents = [line.split("|") for line in table.splitlines() if line.startswith("| tangent")]
    errors = [float(cells[column].replace("−", "-").rstrip(" %")) for cells in tangents for column in (4, 7)]
    assert [1 + min(errors) / 100, 1 + max(errors) / 100] == pytest.approx(STIFFNESS_OVER_MEASURED_STIFFNESS)


def test_export_command_writes_joint_tables_and_rejects_wrong_options(result, directory):
    completed = check_stiction("export", "pair", "from_command.csv", "--joint", cwd=directory)
    assert "count the closure from a small pressure instead (--closure-from)" in " ".join(completed.stdout.split())
    expected = export_text(result, directory / "joint.csv", joint=True)
    assert (directory / "from_command.csv").read_text(encoding="utf-8") == expected
    for arguments, message in (
        (("x.tex", "--joint"), "must end in .csv"),
        (("x.dat",), "or .inp (a card for Abaqus and CalculiX) or .mac (a card for Ansys) or .liggghts (a card for"),
        (("x.inp", "--units", "in,lbf,psi"), "units must be one of 'mm,N,MPa'"),
        (("x.csv", "--units", "m,N,Pa"), "--units applies only to joint tables and cards"),
        (("x.csv", "--closure-from", "9 MPa"), "--closure-from applies only to joint tables and cards"),
        (("x.csv", "--joint", "--closure-from", "9"), "--closure-from must be a force or a pressure with its unit"),
        (("x.csv", "--joint", "--closure-from", "9 Pa"), "--closure-from must be a pressure at which the pair has a"),
        (("x.csv", "--compute"), "--compute applies only to joint tables and cards"),
        (("x.inp", "--workers", "2"), "--workers requires --compute"),
        (("from_command.csv", "--joint"), "from_command.csv"),
    ):
        assert_rejected(call_stiction("export", "pair", *arguments, cwd=directory), message)
    with pytest.raises(ValueError, match="mu0 must be a single value, got"):
        result.joint_table(mu0=[0.2, 0.3])
    with pytest.raises(ValueError, match="must end in"):
        result.export(directory / "x.json")
    small_study_changes = {"ensemble.repetitions": 2, "surfaces.points": 3000}
    changes = [option for key, value in small_study_changes.items() for option in ("--set", f"{key}={value}")]
    check_stiction("run", "quick", *changes, "-o", "generated", cwd=directory, without_figures=True)
    generated_result = open_result(directory / "generated")
    with pytest.raises(ValueError, match="needs a measured pair, got generated surfaces"):
        generated_result.joint_table()
    for options in ((), ("--closure-from", "5 MPa")):
        command = call_stiction("export", "generated", "generated.inp", *options, "--compute", cwd=directory)
        assert_rejected(command, "needs a measured pair, got generated surfaces")


def test_exported_tables_at_given_loads_contain_the_values_of_the_result(result, directory):
    check_stiction("export", "pair", "at.csv", "--load", "20 MPa,80 MPa", cwd=directory)
    table = pandas.read_csv(directory / "at.csv")
    pressures = sorted(set(table["normal load (mN)"] / (1e-3 * result.nominal_area)))
    assert pressures == pytest.approx([20, 80])
    values = result.at(["20 MPa", "80 MPa"]).sel(statistic="mean", sliding="all").squeeze()
    expected = result.summary(["20 MPa", "80 MPa"])
    pandas.testing.assert_frame_equal(table, pandas.read_csv(io.StringIO(summary_csv(expected))))
    check_stiction("export", "pair", "joint_at.csv", "--joint", "--load", "20 MPa,80 MPa", cwd=directory)
    joint_table = pandas.read_csv(directory / "joint_at.csv")
    assert joint_table["nominal pressure (MPa)"].tolist() == pytest.approx([20, 80])
    np.testing.assert_allclose(joint_table["stiffness of closure (MPa/mm)"], values["closure_stiffness"], rtol=1e-8)
    assert not joint_table["computed"].any()


def test_card_contains_the_coefficient_and_stiffness_at_the_given_load_and_the_whole_closure_curve(result, directory):
    check_stiction("export", "pair", "card_at.inp", "--load", "80 MPa", "--closure-from", "20 MPa", cwd=directory)
    card = (directory / "card_at.inp").read_text()
    whole_card = export_text(result, directory / "card.inp", closure_from="20 MPa")
    curve, whole_curve = (
        re.findall(r"^([-\d.e+]+), [-\d.e+]+$", text.split("*FRICTION")[0], re.M) for text in (card, whole_card)
    )
    assert {float(pressure) for pressure in curve} == {80, *(float(pressure) for pressure in whole_curve)}
    (row,) = result.joint_table("80 MPa").rows
    expected = [row.friction(50).value, row.estimates["tangential_stiffness_per_area"].value]
    for text in (card, export_text(result, directory / "card.inp", load="80 MPa")):
        assert "stick slope (tangential stiffness) at 80 MPa," in " ".join(text.replace("** ", "").split())
        (friction,) = re.findall(r"^\*FRICTION\n(.*), (.*)$", text, re.M)
        assert [float(number) for number in friction] == pytest.approx(expected, rel=1e-3)


def test_exported_card_requires_a_single_load_within_the_computed_loads(result, directory):
    message = "--load must be a single load for a card, which has one tangential stiffness for all pressures; choose"
    for options in ((), ("--compute",)):
        command = call_stiction("export", "pair", "x.mac", "--load", "20 MPa,80 MPa", *options, cwd=directory)
        assert_rejected(command, f"{message} one of 20 MPa, 80 MPa")
    assert_rejected(call_stiction("export", "pair", "x.mac", "--load", "9 GPa", cwd=directory), "no values at")
    assert not (directory / "x.mac").exists()


def test_exported_card_of_a_pair_with_several_loads_requires_the_load_option(tmp_path):
    result = small_pair(mu0=0.1, shifts=3, load=["10 kPa", "20 kPa"])
    with pytest.raises(ValueError, match=r"load must be a single load for a card.*; choose one of 10 kPa, 20 kPa"):
        result.export(tmp_path / "card.inp")
    result.export(tmp_path / "card.inp", load="20 kPa")
    assert "(tangential stiffness) at 0.02 MPa" in (tmp_path / "card.inp").read_text()


def test_exported_card_at_zero_load_requires_an_adhesive_pair_computed_at_zero_load(tmp_path):
    adhesion = {"work_of_adhesion": "50 mJ/m^2", "adhesion_range": "5 nm"}
    unloaded_result = small_pair(mu0=0.1, shifts=3, load=["0", "20 kPa"], **adhesion)
    negligible_load = float(unloaded_result.at([0.0])["load"][0])
    assert unloaded_result.joint_table(reference_load="0 mN").reference.load == negligible_load > 0
    cards = [export_text(unloaded_result, tmp_path / "card.inp", load=load) for load in ("0 mN", negligible_load)]
    assert cards[0] == cards[1]
    for options, message in (
        (adhesion, "the closure of the pair is unknown at .* Pa; compute the pair at this load"),
        ({}, "loads must be above 0 mN"),
    ):
        with pytest.raises(ValueError, match=message):
            small_pair(mu0=0.1, shifts=3, **options).export(tmp_path / "new.inp", load="0 mN")
    assert not (tmp_path / "new.inp").exists()


def test_export_of_a_card_rejects_an_empty_list_of_loads(result, tmp_path):
    for extension in ("inp", "mac"):
        with pytest.raises(ValueError, match=r"^load must have at least one value, got \[\]$"):
            result.export(tmp_path / f"card.{extension}", load=[])


def test_export_command_computes_results_at_given_loads_outside_the_range_of_the_study(result, directory):
    check_stiction("export", "pair", "given.csv", "--joint", "--load", "20 MPa,900 MPa", "--compute", cwd=directory)
    table = pandas.read_csv(directory / "given.csv")
    assert table["nominal pressure (MPa)"].tolist() == pytest.approx([20, 900])
    assert table["computed"].all()
    check_stiction("export", "pair", "given.inp", "--load", "900 MPa", "--compute", cwd=directory)
    assert "(tangential stiffness) at 900 MPa" in (directory / "given.inp").read_text()


def test_export_command_warns_of_loads_without_values_and_rejects_a_table_without_any_values(result, directory):
    completed = check_stiction(
        "export", "pair", "some.csv", "--joint", "--load", "20 MPa,9 GPa", cwd=directory, columns=200
    )
    assert "no values at" in completed.stderr
    assert pandas.read_csv(directory / "some.csv")["nominal pressure (MPa)"].tolist() == pytest.approx([20])
    for arguments in (("none.csv", "--joint"), ("none.csv",)):
        completed = call_stiction("export", "pair", *arguments, "--load", "9 GPa", cwd=directory)
        assert_rejected(completed, "no values at")
    assert_rejected(call_stiction("export", "pair", "x.nc", "--load", "20 MPa", cwd=directory), "must end in .csv")
    assert_rejected(call_stiction("export", "pair", "x.npy", "--gap", cwd=directory), "--gap applies only to shear")


def small_pair(rms=0.3, **options):
    bodies = [
        self_affine_surface(3, hurst_exponent=0.8, rms=rms, shape=(32, 32), spacing=1.0, side=side)
        for side in ("upper", "lower")
    ]
    options = {"load": "20 kPa", **options}
    return pair(*bodies, effective_modulus="80 GPa", onset=0, cutoff="none", **options)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"mu0": 0, "tau0": 0, "shifts": 4}, "the coefficient is 0"),
        ({"mu0": 0, "tau0": 0, "shifts": 1}, "the coefficient is 0"),
        ({"mu0": 0.1, "shifts": 2}, "a prediction needs at least three positions"),
        ({"mu0": 2, "rms": 60.0, "shifts": 16}, "a prediction needs a coefficient with an interval"),  # sticks
    ],
)
def test_notes_of_a_joint_table_and_exported_card_state_why_percentiles_are_missing(tmp_path, options, reason):
    result = small_pair(**options)
    assert [note for note in result.joint_table().notes if "No percentiles" in note] == [f"No percentiles: {reason}."]
    card = export_text(result, tmp_path / "card.inp")
    assert "\n*FRICTION" not in card
    assert "No coefficient" not in card
    assert card.endswith("\n** No *FRICTION, because there is no median of mu_s: see the notes above.\n")


def test_export_command_validates_file_and_units_before_it_computes_the_joint_table(tmp_path):
    small_pair(mu0=0.1, shifts=3, directory=tmp_path / "pair")
    (tmp_path / "old.csv").write_text("old")
    for arguments, message in (
        (("old.csv", "--joint"), "old.csv: already exists"),
        (("new.txt", "--joint"), "must end in .csv"),
        (("card.inp", "--units", "furlong"), "units must be one of 'mm,N,MPa'"),
        (("missing/card.inp",), "card.inp: cannot be written: No such file or directory"),
        (("old.csv/card.inp",), "card.inp: cannot be written: "),
    ):
        assert_rejected(call_stiction("export", "pair", *arguments, "--compute", cwd=tmp_path), message)
        assert not (tmp_path / "pair/joint").exists(), arguments
    assert (tmp_path / "old.csv").read_text() == "old"


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_calculix_block_with_the_exported_card_has_the_tabulated_stiffness_and_sliding_load(
    result, directory, tmp_path
):
    """Run the example of the page on finite-element models: four pressures, a small push, and sliding."""
    shutil.copy(ROOT / "examples/block.inp", tmp_path)
    export_text(result, tmp_path / "card.inp")
    completed = subprocess.run(["ccx", "block"], cwd=tmp_path, capture_output=True, text=True, timeout=100, check=False)
    output = (tmp_path / "block.dat").read_text()
    closures = [-float(line.split()[3]) for line in re.findall(r"^ +1 .*$", output, re.MULTILINE)]
    forces = [float(line.split()[0]) for line in re.findall(r"force .*\n\n(.*)\n", output)]
    assert (len(closures), len(forces)) == (4, 2), completed.stdout
    table = result.joint_table()
    pressures, in_table = zip(
        *((row.pressure.value, row.estimates["closure"].value) for row in table.rows), strict=True
    )
    np.testing.assert_allclose(closures, np.interp([10, 50, 100, 200], pressures, in_table), rtol=1e-5)
    at_pressures = result.joint_table([f"{pressure} MPa" for pressure in (10, 50, 100, 200)]).rows
    np.testing.assert_allclose(closures, [get_closure(row) for row in at_pressures], rtol=1e-3)
    reference = table.reference
    stiffness = reference.estimates["tangential_stiffness_per_area"].value
    assert forces == pytest.approx([stiffness * 100 * 2e-5, reference.friction(50).value * 200 * 100], rel=1e-3)


def test_joint_files_contain_every_combination_of_mu0_and_tau0_and_the_sliding_rule(tmp_path):
    result = small_pair(mu0="0.1,0.2", tau0="10 MPa,50 MPa", shifts=3, directory=tmp_path / "pair")
    loads = ["20 kPa", "40 kPa"]
    export_text(result, tmp_path / "joint.csv", joint=True, load=loads)
    frame = pandas.read_csv(tmp_path / "joint.csv")
    pairs = [(0.1, 10), (0.1, 50), (0.2, 10), (0.2, 50)]
    assert list(zip(frame["mu0"], frame["tau0 (MPa)"], strict=True)) == [pair for pair in pairs for _ in loads]
    assert set(frame["sliding"]) == {"all"}
    expected = result.at(loads, mu0=[0.1, 0.2], tau0=[0.01, 0.05]).sel(sliding="all", statistic="mean")
    coefficients = expected["friction_combined"].squeeze().transpose("mu0", "tau0", "load").values.ravel()
    np.testing.assert_allclose(frame["mu_s"], coefficients, rtol=1e-8)
    check_stiction("export", "pair", "one.csv", "--joint", "--mu0", "0.2", "--tau0", "10 MPa", cwd=tmp_path)
    one_frame = pandas.read_csv(tmp_path / "one.csv")
    assert (set(one_frame["mu0"]), set(one_frame["tau0 (MPa)"])) == ({0.2}, {10})
    record = json.loads(export_text(result, tmp_path / "joint.json", joint=True, load=loads))
    assert {(entry["mu0"], entry["tau0"]) for entry in record["assessments"]} == {(a, b / 1000) for a, b in pairs}
    assert {(entry["load_unit"], entry["tau0_unit"]) for entry in record["assessments"]} == {("mN", "GPa")}
    assert record["sliding"] == "all"
    assert len(record["sentence"].splitlines()) == len(pairs)
    assert sum(note.startswith("Coefficient of static friction") for note in record["notes"]) == 1
    assert [
        (value["at"]["mu0"], value["at"]["sliding"])
        for value in record["values"]
        if value["name"] == "friction_combined"
    ] == [(mu0, "all") for mu0, _ in pairs for _ in loads]
    for path in ("card.inp", "card.mac", "card.liggghts"):
        with pytest.raises(ValueError, match=r"mu0 must be a single value for a card.*choose one of 0\.1, 0\.2"):
            result.export(tmp_path / path)
        with pytest.raises(ValueError, match=r"tau0 must be a single value for a card.*choose one of 10 MPa, 50 MPa"):
            result.export(tmp_path / path, mu0=0.2)
    assert_rejected(call_stiction("export", "pair", "a.inp", cwd=tmp_path), "--mu0 must be a single value for a card")
    result.export(tmp_path / "card.inp", mu0="0.2", tau0="10 MPa")
    assert "*FRICTION" in (tmp_path / "card.inp").read_text()
    result.export(tmp_path / "table.csv", mu0=0.3)
    assert set(pandas.read_csv(tmp_path / "table.csv")["mu0"]) == {0.3}


def test_joint_table_warns_of_loads_without_a_row():
    result = small_pair(mu0=0.1, shifts=3)
    with pytest.warns(UserWarning, match=r"no values at .*\(5 GPa\): the computed loads are") as caught_warnings:
        table = result.joint_table(["20 kPa", "5 GPa"])
    assert len(table.rows) == 1
    assert caught_warnings[0].filename == __file__
    with pytest.raises(ValueError, match="no values at"):
        result.joint_table("5 GPa")
