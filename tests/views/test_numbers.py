"""Tests of the scripts of the report, which must compute the numbers and assessments of the library."""

import functools
import itertools
import re
from importlib import resources

import numpy as np
import pytest
from stiction import Study, friction_map, run
from stiction._estimate import Estimate, count_estimate_decimals
from stiction._number_format import format_significant, list_number_formats
from stiction.evaluate.at_load import at_load
from stiction.evaluate.budget import add_uncertainty
from stiction.study.study import parse_study_of_dataset
from stiction.summary.assessment import MAX_AFFECTED_FRACTION, LimitCheck
from stiction.summary.summary import summarize
from stiction.views.report import report_page
from stiction.views.report.tables import NumberArray
from support.generated_studies import SMALL_STUDY, empty_dataset

pytest.importorskip("py_mini_racer", reason="mini-racer is not installed")

from support.report_numbers import ReportEvaluator

pytestmark = pytest.mark.usefixtures("no_report_panels")

MAX_PACKING_ERROR = 1e-6  # relative error


def create_arbitrary_sums(tangential_factor):
    """Return a dataset of arbitrary contact sums, including sums that no surface could have.

    Loads rise and fall with the approach and may be negative, and some repetitions carry no load.
    """
    dataset = empty_dataset(SMALL_STUDY)
    random = np.random.default_rng(9)
    shape = dataset["normal_elastic"].shape
    load_growth = np.arange(1, shape[-1] + 1) ** 1.5
    random_loads = random.lognormal(0, 0.6, shape[:3])[..., np.newaxis] * load_growth * random.lognormal(0, 0.3, shape)
    random_loads[:, :, 5:8, :4] = 0
    random_loads[1, 0, 1:] = 0  # only one repetition of this pair of parameters carries a load
    random_loads[2, 0] = 0  # no repetition of this pair of parameters carries a load
    has_contact = random_loads > 0
    for name in ("normal_elastic", "tangential_frictional", "contact_area", "overlap_load", "normal_adhesive"):
        dataset[name].values[:] = random_loads * random.uniform(0.1, 0.9, shape)
    for name in ("load_beyond_hertz", "load_below_grid"):
        dataset[name].values[:] = dataset["normal_elastic"].values * random.uniform(0, 1, shape)
    dataset["normal_frictional"].values[:] = -random_loads * random.uniform(0, 0.7, shape)
    dataset["normal_adhesive"].values *= -0.5
    dataset["tangential_elastic"].values[:] = random_loads * random.uniform(-0.2, 0.4, shape) * tangential_factor
    dataset["tangential_adhesive"].values[:] = random_loads * random.uniform(0, 0.5, shape)
    for name in ("tangential_elastic", "tangential_frictional", "tangential_adhesive"):
        dataset[name].values[3, 1, 1:] = (
            0  # only one repetition has a tangential force, and the mean of all others is 0, which has no logarithm
        )
    dataset["normal_elastic"].values[3, 0, :, 0] = 0.5
    dataset["contact_count"].values[:] = 3 * has_contact
    dataset["crossed_count"].values[:] = random.integers(0, 4, shape) * has_contact
    return dataset


@functools.cache
def evaluate_arbitrary_sums(tangential_factor):
    """Return the dataset of `create_arbitrary_sums`, with an evaluator for the numbers of its report."""
    dataset = create_arbitrary_sums(tangential_factor)
    return dataset, ReportEvaluator(report_page(dataset))


@pytest.fixture(scope="module")
def report_evaluator(generated_dataset):
    return ReportEvaluator(report_page(generated_dataset))


# ---- Text ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("digits", [1, 2])
@pytest.mark.parametrize("scale", [3.3e-4, 0.1147, 0.99951, 17.251, 1234.0, 56_789.0, 4.2e7])
def test_report_script_prints_numbers_with_as_many_decimals_as_the_terminal_output(report_evaluator, scale, digits):
    random = np.random.default_rng(3)
    value = scale * random.uniform(0.9, 1.1, 40)
    half_width = scale * 10 ** random.uniform(-6, 0.5, 40)
    lower, upper = value - half_width, value + half_width
    upper[:5] = np.inf
    lower[5:8] = upper[5:8] = np.nan
    upper[8:12] = 300 * value[8:12]
    upper[12] = 1e11 * value[12]
    if digits == 2:
        value[5] = 2 * scale
    decimals, decimals_of_upper = count_estimate_decimals(value, lower, upper, digits=digits)
    texts = report_evaluator(
        "(points) => points.map(([value, lower, upper, decimals, upperDecimals]) => quoted({value, lower: lower ?? NaN,"
        " upper: upper === 'inf' ? Infinity : upper ?? NaN, decimals, upperDecimals}))",
        [
            [v, *(None if np.isnan(x) else "inf" if np.isinf(x) else x for x in (a, b)), int(d), int(u)]
            for v, a, b, d, u in zip(
                value.tolist(), lower.tolist(), upper.tolist(), decimals, decimals_of_upper, strict=True
            )
        ],
    )
    expected_texts = [
        Estimate(*value_and_interval).text(digits).replace("-", "\u2212")
        for value_and_interval in zip(value.tolist(), lower.tolist(), upper.tolist(), strict=True)
    ]
    assert texts == expected_texts


@pytest.mark.parametrize(
    ("shown", "values"),
    [
        ("digits", [0.93, 1.4, 2.25, 7.1, 14.2, 123.0]),
        ("digit", [0.0007, 0.000012, 0.2]),
        ("percent", [0.0, 1e-7, 0.0031, 0.0612, 0.099961, 0.125, 0.46, 0.999, 2.34]),
        ("GPa", [0.0, 0.735, 1.12, 0.99997, 12.3, 3.4e-4]),
        ("um", [0.0421, 1.0, 2500.0]),
    ],
)
def test_report_script_prints_numbers_in_caveats_like_the_terminal_output(report_evaluator, shown, values):
    check = LimitCheck("name", 0.5, "{}", "check it", shown=shown)
    array = NumberArray(np.array(values), list_number_formats(shown))
    texts = report_evaluator(
        "(formats, values, indices) => values.map((value, i) => printed({value, format: formats[indices[i]]}))",
        [item._asdict() for item in array.formats], values, array.columns()["format"].tolist(),
    )  # fmt: skip
    assert texts == [check.to_caveat({"name": value}).text for value in values]


def test_report_scripts_contain_no_fixed_number_of_printed_digits():
    scripts = [
        (resources.files("stiction.views.report") / f"{name}.js").read_text("utf-8") for name in ("numbers", "result")
    ]
    digits = re.findall(r"to(?:Fixed|Precision)\((\d+)", "".join(scripts))
    assert set(digits) <= {"12"}  # Twelve digits remove rounding errors from inputs.


# ---- Generated profiles ---------------------------------------------------------------------------------------------


HALF_PLANE_STUDY_OVERRIDES = {
    "contact.mechanics": "half-space",
    "contact.load": {"start": "10 uN", "stop": "1 mN", "count": 5},
    "contact.sliding": ["opposing", "all"],
    "surfaces.points": 512,
    "surfaces.extent": "5 um",
    "ensemble.repetitions": 4,
    "surfaces.band_limit": "nyquist",
    "surfaces.fractal_dimension": [1.1, 1.4],
}


def find_relative_error(values, expected):
    """Return the largest relative error of finite numbers, and require all other numbers to be equal."""
    is_finite = np.isfinite(expected)
    np.testing.assert_array_equal(values[~is_finite], expected[~is_finite])
    difference = np.abs(values - expected)[is_finite]
    return float(np.max(difference / np.maximum(np.abs(expected[is_finite]), 1e-12), initial=0.0))


def compare_friction(dataset, report_evaluator, settings):
    """Compare the friction of a report with `friction_map`, and return statuses and relative errors."""
    facts = report_evaluator.facts
    statuses, errors = [], []
    for cell_index, rule_index, way_index, load_index, mu0, tau0 in settings:
        reference = friction_map(dataset, [facts["loads"]["values"][load_index]], mu0=[mu0], tau0=[tau0])
        reference = reference.isel(fractal_dimension=cell_index, amplitude=0, load=0, mu0=0, tau0=0)
        reference = reference.isel(sliding=rule_index) if "sliding" in reference.dims else reference
        reference = reference.isel(direction=way_index) if "direction" in reference.dims else reference
        point = report_evaluator.evaluate_quantity(
            "friction", mu0, tau0, cell=cell_index, rule=rule_index, way=way_index, load=load_index
        )
        status = str(reference["status"].values)
        if point["status"] != status:
            status = f"{point['status']} for {status}"
        elif status == "ok":
            values = np.array([point[name] for name in ("value", "lower", "upper")])
            expected = np.array([float(reference[name]) for name in ("friction_coefficient", "lower", "upper")])
            errors.append(find_relative_error(values, expected))
        statuses.append(status)
    return statuses, errors


def random_settings(report_evaluator, count, seed):
    facts, random = report_evaluator.facts, np.random.default_rng(seed)
    mu0_values, tau0_values = (facts["axes"][name]["values"] for name in ("mu0", "tau0"))
    for _ in range(count):
        indices = [int(random.integers(len(facts[name]))) for name in ("rules", "ways")]
        cell_index, load_index = (int(random.integers(len(facts[name]["values"]))) for name in ("cells", "loads"))
        yield cell_index, *indices, load_index, random.choice(mu0_values), random.choice(tau0_values) / 1000


@pytest.mark.parametrize("case_name", ["asperities", "half-planes"])
def test_friction_in_reports_of_generated_profiles_equals_library_values(
    generated_dataset, report_evaluator, case_name
):
    if case_name == "half-planes":
        generated_dataset = run(Study.named("quick").with_changes(HALF_PLANE_STUDY_OVERRIDES)).dataset
        report_evaluator = ReportEvaluator(report_page(generated_dataset))
    statuses, errors = compare_friction(generated_dataset, report_evaluator, random_settings(report_evaluator, 60, 5))
    assert set(statuses) <= {"ok", "not-reached", "self-locked", "below-range"}
    assert len(errors) > 15
    assert max(errors) < MAX_PACKING_ERROR


@pytest.mark.parametrize("tangential_factor", [0.0, 1.0])
def test_friction_in_reports_equals_library_values_even_for_random_stored_loads(tangential_factor):
    dataset, report_evaluator = evaluate_arbitrary_sums(tangential_factor)
    axes = report_evaluator.facts["axes"]
    random = np.random.default_rng(3)
    settings = [
        (int(random.integers(4)), 0, 0, int(random.integers(40)), mu0, tau0 / 1000)
        for mu0, tau0 in itertools.product(axes["mu0"]["values"][::2], axes["tau0"]["values"][::2])
    ]
    statuses, errors = compare_friction(dataset, report_evaluator, settings)
    assert not [status for status in statuses if " for " in status]
    assert max(errors, default=0.0) < MAX_PACKING_ERROR


def test_friction_in_reports_ignores_pairs_without_a_solution(generated_dataset):
    dataset = generated_dataset.copy(deep=True)
    dataset["normal_elastic"].loc[{"repetition": 3, "approach": dataset["approach"][-1]}] = np.nan
    report_evaluator = ReportEvaluator(report_page(dataset))
    assert report_evaluator.facts["repetitions"] == dataset.sizes["repetition"] - 1
    friction = parse_study_of_dataset(dataset).friction
    statuses, errors = compare_friction(
        dataset, report_evaluator, [(1, 0, 0, 20, friction.mu0[0], float(friction.tau0[0]))]
    )
    assert statuses == ["ok"]
    assert max(errors) < MAX_PACKING_ERROR


def test_report_of_profiles_without_contact_offers_no_loads():
    dataset = empty_dataset(SMALL_STUDY.with_changes({"contact.approach": ["0 nm"]}))
    assert ReportEvaluator(report_page(dataset)).facts["loads"]["values"] == []


@pytest.mark.parametrize("case_name", ["asperities", "soft", "invented"])
def test_assessments_in_reports_of_generated_profiles_equal_library_assessments(
    generated_dataset, report_evaluator, case_name
):
    dataset = generated_dataset
    if case_name == "invented":
        dataset, report_evaluator = evaluate_arbitrary_sums(0.0)
    if case_name == "soft":
        dataset = dataset.assign_attrs(
            study=parse_study_of_dataset(dataset).with_changes({"contact.effective_modulus": "50 MPa"}).to_toml()
        )
        report_evaluator = ReportEvaluator(report_page(dataset))
    study = parse_study_of_dataset(dataset)
    loads = report_evaluator.facts["loads"]["values"]
    assessments = set()
    for mu0, tau0 in itertools.product(study.friction.mu0[:2], study.friction.tau0[:2]):
        load_indices = [4, 15, 25, 35]
        reference = at_load(dataset, [loads[index] for index in load_indices], mu0=[mu0], tau0=[float(tau0)])
        for point in summarize(reference, study).points:
            indices = [
                dataset[name].values.tolist().index(point.at[name]) for name in ("fractal_dimension", "amplitude")
            ]
            load_index = int(np.argmin(np.abs(np.array(loads) - point.at["load"])))
            assessment = report_evaluator.evaluate_assessment(
                mu0, float(tau0), cell=indices[0], amplitude=indices[1], way=0, load=load_index
            )
            assert assessment["assessment"] == point.assessment
            for name in ("text", "remedy"):
                expected_texts = [getattr(caveat, name) for caveat in point.caveats]
                assert [caveat[name] for caveat in assessment["caveats"]] == expected_texts
            assessments.add(point.assessment)
    assert "Do not quote" in assessments


def test_area_in_reports_of_generated_surfaces_has_the_unit_and_digits_of_terminal_output():
    dataset = create_arbitrary_sums(1.0)
    dataset["contact_area"].values *= 3e4
    report_evaluator, study = ReportEvaluator(report_page(dataset)), parse_study_of_dataset(dataset)
    mu0, tau0 = study.friction.mu0[0], float(study.friction.tau0[0])
    texts = set()
    for load_index in range(0, 40, 4):
        reference = at_load(dataset, [report_evaluator.facts["loads"]["values"][load_index]], mu0=[mu0], tau0=[tau0])
        for point in summarize(reference, study).points:
            estimate = point.quantities["contact_area"].in_prefixed_unit()
            cell = dataset["fractal_dimension"].values.tolist().index(point.at["fractal_dimension"])
            amplitude = dataset["amplitude"].values.tolist().index(point.at["amplitude"])
            cell_position = {"cell": cell, "amplitude": amplitude, "load": load_index}
            shown_point = report_evaluator.evaluate_quantity("area", mu0, tau0, **cell_position)
            expected_text = "none" if np.isnan(estimate.value) else f"{estimate.text()} {estimate.unit}"
            assert shown_point["text"] == expected_text
            texts.add(expected_text.split(" ")[-1])
    assert {"µm²", "mm²"} <= texts


def test_validity_indicators_in_profile_reports_equal_validity_indicators_in_tables(
    generated_dataset, report_evaluator
):
    study = parse_study_of_dataset(generated_dataset)
    mu0, tau0 = study.friction.mu0[1], float(study.friction.tau0[1])
    load = report_evaluator.facts["loads"]["values"][25]
    reference = at_load(generated_dataset, [load], mu0=[mu0], tau0=[tau0])
    are_beyond = []
    for point in summarize(reference, study).points:
        cell_position = {
            "cell": generated_dataset["fractal_dimension"].values.tolist().index(point.at["fractal_dimension"]),
            "amplitude": generated_dataset["amplitude"].values.tolist().index(point.at["amplitude"]),
        }
        for name in ("share_beyond_hertz", "share_below_grid"):
            text, is_beyond = report_evaluator.format_validity(name, mu0, tau0, **cell_position, load=25)
            fraction = point.numbers[name]
            assert is_beyond == (fraction > MAX_AFFECTED_FRACTION)
            if np.isfinite(fraction):  # infinite and undefined fractions are not shown
                assert text == f"{format_significant(100 * fraction)} %"
                are_beyond.append(is_beyond)
    assert set(are_beyond) == {0, 1}


# ---- Measured surfaces ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["maps_dataset", "profiles_dataset"])
def dataset_and_evaluator(request):
    """Dataset of measured surfaces, with an evaluator for the numbers of its report."""
    dataset = request.getfixturevalue(request.param)
    return dataset, ReportEvaluator(report_page(dataset))


def test_friction_in_reports_of_measured_surfaces_equals_library_values(dataset_and_evaluator):
    dataset, report_evaluator = dataset_and_evaluator
    facts, errors = report_evaluator.facts, []
    study = parse_study_of_dataset(dataset)
    study_setting = (0, 0, 0, 0, study.friction.mu0[0], float(study.friction.tau0[0]))
    for _, rule_index, way_index, load_index, mu0, tau0 in (study_setting, *random_settings(report_evaluator, 12, 4)):
        reference = at_load(dataset, [facts["loads"]["values"][load_index]], mu0=[mu0], tau0=[tau0])
        reference = add_uncertainty(reference, dataset, budget=False).isel(
            load=0, mu0=0, tau0=0, cut_off=0, sliding=rule_index
        )
        is_whole = facts["ways"][way_index]["isWhole"]
        indices = {"rule": rule_index, "way": way_index, "load": load_index}
        point = report_evaluator.evaluate_quantity("friction" if is_whole else "sampling", mu0, tau0, **indices)
        expected = (
            reference["friction_combined"]
            if is_whole
            else reference["friction_coefficient"].isel(direction=facts["ways"][way_index]["directions"][0])
        )
        assert point["status"] == "ok"
        values = np.array([point[name] for name in ("value", "lower", "upper")])
        errors.append(find_relative_error(values, expected.values))
        if (mu0, tau0) == study_setting[4:]:
            assert point["text"] == str(Estimate(*expected.values.tolist()))
        if not is_whole:
            point_over_directions = report_evaluator.evaluate_quantity("friction", mu0, tau0, **indices)
            assert np.isnan(point_over_directions["lower"])
            assert "[" not in point_over_directions["text"]
    assert max(errors) < MAX_PACKING_ERROR


def test_coefficient_texts_in_a_report_equal_coefficient_texts_of_the_summary(dataset_and_evaluator):
    dataset, report_evaluator = dataset_and_evaluator
    study = parse_study_of_dataset(dataset)
    reference = at_load(dataset, [float(load_index) for load_index in study.friction.load])
    rules = report_evaluator.facts["rules"]
    for point in summarize(add_uncertainty(reference, dataset), study).points:
        load_index = report_evaluator.facts["loads"]["values"].index(point.at["load"])
        for rule in point.rules:
            report_point = report_evaluator.evaluate_quantity(
                "friction", point.at["mu0"], point.at["tau0"], rule=rules.index(rule.rule), load=load_index
            )
            assert report_point["text"] == str(rule)


def test_contact_values_in_reports_of_measured_surfaces_equal_library_values(dataset_and_evaluator):
    dataset, report_evaluator = dataset_and_evaluator
    reference = at_load(dataset, dataset["load"].values, mu0=[0.3], tau0=[0.0]).isel(cut_off=0)
    names = [quantity["name"] for quantity in report_evaluator.facts["quantities"]]
    assert {"contact_area", "contact_count", "mean_pressure", "normal_stiffness"} <= set(names)
    factors = {value["of"]: value["factor"] for value in report_evaluator.facts["curves"].values()}
    for quantity in report_evaluator.facts["quantities"]:
        expected = factors.get(quantity["name"], 1) * reference[quantity["name"]].transpose("load", "statistic").values
        assert np.array(quantity["points"][0][0], float) == pytest.approx(expected, rel=1e-12, nan_ok=True)


# ---- Drawing ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def drawing_functions(report_evaluator):
    """Functions of `plots.js` that do not need an HTML document."""
    text = (resources.files("stiction.views.report") / "plots.js").read_text("utf-8")
    report_evaluator._engine.eval(
        text.split("// ---- Axes ---")[0].split("// ---- Ticks and cells")[1].partition("\n")[2] + "; null"
    )
    return report_evaluator


@pytest.mark.parametrize(
    ("lower_limit", "upper_limit", "is_log", "expected_texts"),
    [
        (0.0, 1.0, False, ["0", "0.2", "0.4", "0.6", "0.8", "1"]),
        (1.0, 1.72, False, ["1", "1.2", "1.4", "1.6"]),
        (0.2, 0.5, True, ["0.2", "0.25", "0.3", "0.35", "0.4", "0.45", "0.5"]),
        (2e-6, 0.3, True, ["10⁻⁵", "10⁻⁴", "0.001", "0.01", "0.1"]),
        (2e-9, 0.3, True, ["10⁻⁸", "10⁻⁶", "10⁻⁴", "0.01"]),
        (0.03, 3.0, True, ["0.03", "0.1", "0.3", "1", "3"]),
        (5.0, 5.0, False, ["5"]),
    ],
)
def test_axis_ticks_have_round_values_within_the_axis_limits(
    drawing_functions, lower_limit, upper_limit, is_log, expected_texts
):
    ticks = drawing_functions("(...at) => ticksOf(...at)", lower_limit, upper_limit, is_log, 6)
    assert [tick["text"] for tick in ticks if tick["text"]] == expected_texts
    assert all(lower_limit * (1 - 1e-9) <= tick["value"] <= upper_limit * (1 + 1e-9) for tick in ticks)


@pytest.mark.parametrize("scale", [1.0, 1e-4, 1e4])
def test_cell_edges_of_a_friction_map_are_midpoints_between_cell_centres(drawing_functions, scale):
    centres = (scale * 2.0 ** np.arange(7)).tolist()
    cell_edges = drawing_functions("(centres) => edges(centres)", centres)
    assert (np.array(cell_edges[1:-1]) == (np.array(centres[1:]) + centres[:-1]) / 2).all()
    assert cell_edges[0] < centres[0]
    assert cell_edges[-1] > centres[-1]
    x, y = [0, 1, 2], [0, 10, 20]
    assert drawing_functions("(...at) => boundary([[true, false], [true, null]], ...at)", x, y) == [[1, 0, 1, 10]]
    assert drawing_functions("(...at) => boundary([[true], [false]], ...at)", x[:2], y) == [[0, 10, 1, 10]]
