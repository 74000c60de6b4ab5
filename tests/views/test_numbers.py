"""Numbers of the report: values, intervals, statuses, decimals and assessments are those of the library."""

import itertools

import numpy as np
import pytest
from stiction import Study, friction_map, run
from stiction._number_format import quoted
from stiction.studies.budget import add_uncertainty
from stiction.studies.evaluation import at_load
from stiction.studies.nodes import Axis, excess, interpolated
from stiction.studies.point import rules_of
from stiction.studies.study import study_of
from stiction.studies.summary import summarize
from stiction.views.report import report_page
from stiction.views.report.tables import decimals_of
from support.generated_studies import SMALL_STUDY, empty_dataset

pytest.importorskip("py_mini_racer", reason="mini-racer is not installed")

from support.report_numbers import ReportNumbers

PACKED = 1e-6  # relative error of a packed number
MOST_EXCESS = 3.0  # errors at single settings over the tolerances by which the nodes are chosen


def invented(reached):
    """Sums that are of no surface: loads that rise and fall, fall below zero, and repetitions that carry nothing."""
    data = empty_dataset(SMALL_STUDY)
    random = np.random.default_rng(9)
    shape = data["normal_elastic"].shape
    rise = np.arange(1, shape[-1] + 1) ** 1.5
    size = random.lognormal(0, 0.6, shape[:3])[..., np.newaxis] * rise * random.lognormal(0, 0.3, shape)
    size[:, :, 5:8, :4] = 0
    size[1, 0, 1:] = 0  # one repetition alone carries load
    size[2, 0] = 0  # none does
    touches = size > 0
    for name in ("normal_elastic", "tangential_frictional", "contact_area", "overlap_load", "normal_adhesive"):
        data[name].values[:] = size * random.uniform(0.1, 0.9, shape)
    for name in ("load_beyond_hertz", "load_below_grid"):
        data[name].values[:] = data["normal_elastic"].values * random.uniform(0, 1, shape)
    data["normal_frictional"].values[:] = -size * random.uniform(0, 0.7, shape)
    data["normal_adhesive"].values *= -0.5
    data["tangential_elastic"].values[:] = size * random.uniform(-0.2, 0.4, shape) * reached
    data["tangential_adhesive"].values[:] = size * random.uniform(0, 0.5, shape)
    for name in ("tangential_elastic", "tangential_frictional", "tangential_adhesive"):
        data[name].values[3, 1, 1:] = 0  # one repetition alone resists, and the mean of the others has no logarithm
    data["normal_elastic"].values[3, 0, :, 0] = 0.5  # a load that is reached at the first approach
    data["contact_count"].values[:] = 3 * touches
    data["crossed_count"].values[:] = random.integers(0, 4, shape) * touches
    return data


@pytest.fixture(scope="module")
def numbers(result):
    return ReportNumbers(report_page(result))


# ---- Interpolation and text ------------------------------------------------------------------------------------------


def test_script_interpolates_as_the_library(numbers):
    axes = tuple(Axis(np.array([0.0, 0.1, 0.3, 0.7, 1.0]) * most, np.array([0.2]) * most) for most in (1.0, 50.0))
    table = np.random.default_rng(2).uniform(size=(6, 6))
    table[0, 0] = np.nan
    facts = {
        name: {"rising": axis.rising.tolist(), "bounds": axis.bounds}
        for name, axis in zip(("mu0", "tau0"), axes, strict=True)
    }
    values = [None if np.isnan(item) else item for item in table.ravel()]
    for mu0, tau0 in itertools.product((0.0, 0.1, 0.15, 0.2, 0.5, 1.0), (0.0, 3.0, 10.0, 34.0, 50.0)):
        result = numbers(
            "(axes, values, mu0, tau0) => between(values.map((each) => each ?? NaN), 0, placeAt(axes, mu0, tau0))",
            facts, values, mu0, tau0,
        )  # fmt: skip
        assert result == pytest.approx(float(interpolated(axes, table, mu0, tau0)), rel=1e-12, nan_ok=True)


def test_interval_has_no_upper_end_beside_a_node_without_one(numbers):
    script = """(mu0) => {
      const axes = {mu0: {rising: [0, 1, 2], bounds: []}, tau0: {rising: [0, 1, 2], bounds: []}};
      const three = (list) => list.flatMap((each) => [each, each, each]);
      const floats = three([1, 2, 3, 0.5, 1, 2, 2, 3, Infinity]);
      const offsets = {a_value: 0, a_lower: 9, a_upper: 18, a_decimals: 0, a_upper_decimals: 0};
      const point = pointAt({offsets, floats, small: Array(9).fill(1)}, "a", 0, placeAt(axes, mu0, 0.5));
      return [point.upper, quoted(point)];
    }"""
    assert numbers(script, 0.5) == [2.5, "1.5 [0.8, 2.5]"]
    assert numbers(script, 1.01) == [np.inf, "2.0 [1.0, ∞)"]


def test_value_has_no_status_ok_beside_a_node_without_a_value(numbers):
    script = """(mu0) => statusAt([0, 0, 0, 0, 1, 1], 0, placeAt({mu0: {rising: [0, 1, 2], bounds: []},
      tau0: {rising: [0, 1], bounds: []}}, mu0, 0), [{isOk: true}, {isOk: false}])"""
    assert [numbers(script, mu0) for mu0 in (0.9, 1.0, 1.1, 2.0)] == [0, 0, 1, 1]


@pytest.mark.parametrize("scale", [3.3e-4, 0.1147, 0.99951, 17.251, 1234.0])
def test_numbers_are_printed_by_the_decimals_of_the_terminal(numbers, scale):
    random = np.random.default_rng(3)
    value = scale * random.uniform(0.9, 1.1, 40)
    width = scale * 10 ** random.uniform(-6, 0.5, 40)
    lower, upper = value - width, value + width
    upper[:5] = np.inf
    lower[5:8] = upper[5:8] = np.nan
    upper[8:12] = 300 * value[8:12]
    decimals, of_upper = decimals_of(value, lower, upper)
    result = numbers(
        "(points) => points.map(([value, lower, upper, decimals, upperDecimals]) => quoted({value, lower: lower ?? NaN,"
        " upper: upper === 'inf' ? Infinity : upper ?? NaN, decimals, upperDecimals}))",
        [
            [v, *(None if np.isnan(x) else "inf" if np.isinf(x) else x for x in (a, b)), int(d), int(u)]
            for v, a, b, d, u in zip(value.tolist(), lower.tolist(), upper.tolist(), decimals, of_upper, strict=True)
        ],
    )
    expected = [
        quoted(*item).replace("-", "\u2212")
        for item in zip(value.tolist(), lower.tolist(), upper.tolist(), strict=True)
    ]
    assert result == expected


# ---- Generated bodies ------------------------------------------------------------------------------------------------


HALF_PLANES = {
    "contact.mechanics": "half-space", "contact.load": {"start": "10 uN", "stop": "1 mN", "count": 5},
    "contact.sliding": ["opposing", "all"], "surfaces.points": 512, "surfaces.extent": "5 um",
    "ensemble.repetitions": 4, "surfaces.band_limit": "nyquist", "surfaces.fractal_dimension": [1.1, 1.4],
}  # fmt: skip


def of_generated(data, numbers, settings):
    """Compare friction of a report with `friction_map`; returns statuses, and errors over the tolerances."""
    facts = numbers.facts
    statuses, errors = [], []
    for cell, rule, way, load, mu0, tau0 in settings:
        at = friction_map(data, [facts["loads"]["values"][load]], mu0=[mu0], tau0=[tau0])
        at = at.isel(fractal_dimension=cell, amplitude=0, load=0, mu0=0, tau0=0)
        at = at.isel(sliding=rule) if "sliding" in at.dims else at
        at = at.isel(direction=way) if "direction" in at.dims else at
        point = numbers.point("friction", mu0, tau0, cell=cell, rule=rule, way=way, load=load)
        status = str(at["status"].values)
        if not point["isFine"]:
            status = "between-nodes"
        elif point["status"] != status:
            status = f"{point['status']} for {status}"
        elif status == "ok":
            arguments = np.array([point[name] for name in ("value", "lower", "upper")])
            expected = np.array([float(at[name]) for name in ("friction_coefficient", "lower", "upper")])
            errors.append(float(excess(arguments, expected)))
        statuses.append(status)
    return statuses, errors


def settings_of(numbers, count, seed):
    facts, random = numbers.facts, np.random.default_rng(seed)
    most = facts["axes"]["mu0"]["most"], facts["axes"]["tau0"]["most"] / 1000
    for _ in range(count):
        place = [int(random.integers(len(facts[name]))) for name in ("rules", "ways")]
        cell, load = (int(random.integers(len(facts[name]["values"]))) for name in ("cells", "loads"))
        yield cell, *place, load, random.uniform(0, most[0]), random.uniform(0, most[1])


@pytest.mark.parametrize("name", ["asperities", "half-planes"])
def test_friction_of_generated_bodies_is_that_of_the_library(result, numbers, name):
    if name == "half-planes":
        result = run(Study.named("quick").with_changes(HALF_PLANES)).dataset
        numbers = ReportNumbers(report_page(result))
    statuses, errors = of_generated(result, numbers, settings_of(numbers, 60, 5))
    expected = {"ok", "not-reached", "self-locked", "below-range", "between-nodes"}
    assert np.mean([status in expected for status in statuses]) > 0.9
    assert len(errors) > 15
    assert np.quantile(errors, 0.8) < MOST_EXCESS


@pytest.mark.parametrize("reached", [0.0, 1.0])
def test_nodes_of_any_sums_are_those_of_the_library(reached):
    data = invented(reached)
    numbers = ReportNumbers(report_page(data))
    axes = numbers.facts["axes"]
    random = np.random.default_rng(3)
    settings = [
        (
            int(random.integers(4)),
            0,
            0,
            int(random.integers(40)),
            axes["mu0"]["rising"][m],
            axes["tau0"]["rising"][t] / 1000,
        )
        for m, t in itertools.product(range(0, len(axes["mu0"]["rising"]), 2), range(0, len(axes["tau0"]["rising"]), 2))
    ]
    statuses, errors = of_generated(data, numbers, settings * 2)
    assert not [status for status in statuses if " for " in status or status == "between-nodes"]
    assert max(errors, default=0.0) < 0.1


def test_members_without_a_solution_are_left_out(result):
    data = result.copy(deep=True)
    data["normal_elastic"].loc[{"repetition": 3, "approach": data["approach"][-1]}] = np.nan
    numbers = ReportNumbers(report_page(data))
    assert numbers.facts["repetitions"] == data.sizes["repetition"] - 1
    own = study_of(data).friction
    statuses, errors = of_generated(data, numbers, [(1, 0, 0, 20, own.mu0[0], float(own.tau0[0]))])
    assert statuses == ["ok"]
    assert max(errors) < 0.1


def test_report_of_bodies_that_do_not_touch_has_no_loads():
    data = empty_dataset(SMALL_STUDY.with_changes({"contact.approach": ["0 nm"]}))
    assert ReportNumbers(report_page(data)).facts["loads"]["values"] == []


@pytest.mark.parametrize("case", ["asperities", "soft", "invented"])
def test_assessments_of_generated_bodies_are_those_of_the_library(result, case):
    data = invented(0.0) if case == "invented" else result
    if case == "soft":
        data = data.assign_attrs(study=study_of(data).with_changes({"contact.effective_modulus": "50 MPa"}).to_toml())
    study, numbers = study_of(data), ReportNumbers(report_page(data))
    assert numbers.facts["quotedRule"] == rules_of(study)[0]
    loads = numbers.facts["loads"]["values"]
    verdicts = set()
    for mu0, tau0 in itertools.product(study.friction.mu0[:2], study.friction.tau0[:2]):
        picked = [4, 15, 25, 35]
        at = at_load(data, [loads[index] for index in picked], mu0=[mu0], tau0=[float(tau0)])
        for one in summarize(at, study).points:
            place = [data[name].values.tolist().index(one.at[name]) for name in ("fractal_dimension", "amplitude")]
            load = int(np.argmin(np.abs(np.array(loads) - one.at["load"])))
            computed = numbers.judgement(mu0, float(tau0), cell=place[0], amplitude=place[1], way=0, load=load)
            assert computed["verdict"] == one.verdict
            assert [item["cure"] for item in computed["caveats"]] == [caveat.cure for caveat in one.caveats]
            verdicts.add(one.verdict)
    assert "Do not quote" in verdicts


# ---- Measured bodies -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["maps", "lines"])
def measured(request):
    """A result of measured bodies and the numbers of its report."""
    data = request.getfixturevalue(request.param)
    return data, ReportNumbers(report_page(data))


def test_friction_of_measured_surfaces_equals_the_library(measured):
    data, numbers = measured
    facts, errors = numbers.facts, []
    study = study_of(data)
    own = (0, 0, 0, 0, study.friction.mu0[0], float(study.friction.tau0[0]))
    for _, rule, way, load, mu0, tau0 in (own, *settings_of(numbers, 25, 4)):
        at = at_load(data, [facts["loads"]["values"][load]], mu0=[mu0], tau0=[tau0])
        at = add_uncertainty(at, data, budget=False).isel(load=0, mu0=0, tau0=0, cut_off=0, sliding=rule)
        is_whole = facts["ways"][way]["isWhole"]
        place = {"rule": rule, "way": way, "load": load}
        point = numbers.point("friction" if is_whole else "sampling", mu0, tau0, **place)
        expected = (
            at["friction_combined"]
            if is_whole
            else at["friction_coefficient"].isel(direction=facts["ways"][way]["directions"][0])
        )
        assert point["status"] == "ok"
        arguments = np.array([point[name] for name in ("value", "lower", "upper")])
        errors.append(float(excess(arguments, expected.values)))
        if (mu0, tau0) == own[4:]:
            assert point["text"] == quoted(*expected.values.tolist())
            assert errors[-1] < 0.1
        if not is_whole:  # no interval that would be surer than that over all directions
            shown = numbers.point("friction", mu0, tau0, **place)
            assert np.isnan(shown["lower"])
            assert "[" not in shown["text"]
    assert np.quantile(errors, 0.9) < MOST_EXCESS


def test_headline_of_a_report_is_that_of_the_answers(measured):
    data, numbers = measured
    study = study_of(data)
    at = at_load(data, [float(load) for load in study.friction.load])
    rules = numbers.facts["rules"]
    for one in summarize(add_uncertainty(at, data), study).points:
        load = numbers.facts["loads"]["values"].index(one.at["load"])
        for value in one.rules:
            point = numbers.point("friction", one.at["mu0"], one.at["tau0"], rule=rules.index(value.rule), load=load)
            assert point["text"] == quoted(value.value, value.lower, value.upper)


def test_contacts_of_measured_surfaces_equal_the_library(measured):
    data, numbers = measured
    reference = at_load(data, data["load"].values, mu0=[0.3], tau0=[0.0]).isel(cut_off=0)
    names = [fact["name"] for fact in numbers.facts["quantities"]]
    assert {"contact_area_fraction", "contact_count", "mean_pressure", "normal_stiffness"} <= set(names)
    factors = {value["of"]: value["factor"] for value in numbers.facts["curves"].values()}
    for fact in numbers.facts["quantities"]:
        expected = factors.get(fact["name"], 1) * reference[fact["name"]].transpose("load", "statistic").values
        assert np.array(fact["points"][0][0], float) == pytest.approx(expected, rel=1e-12, nan_ok=True)


# ---- Drawing ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def drawing(numbers):
    """The functions of `plots.js` that need no page."""
    from importlib import resources

    text = (resources.files("stiction.views.report") / "plots.js").read_text("utf-8")
    numbers._engine.eval(
        text.split("// ---- Axes ---")[0].split("// ---- Ticks and cells")[1].partition("\n")[2] + "; null"
    )
    return numbers


@pytest.mark.parametrize(
    ("low", "high", "is_log", "texts"),
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
def test_ticks_are_round(drawing, low, high, is_log, texts):
    result = drawing("(...at) => ticksOf(...at)", low, high, is_log, 6)
    assert [tick["text"] for tick in result if tick["text"]] == texts
    assert all(low * (1 - 1e-9) <= tick["value"] <= high * (1 + 1e-9) for tick in result)


@pytest.mark.parametrize("scale", [1.0, 1e-4, 1e4])
def test_edges_of_cells_are_their_middles(drawing, scale):
    centres = (scale * 2.0 ** np.arange(7)).tolist()
    ends = drawing("(centres) => edges(centres)", centres)
    assert (np.array(ends[1:-1]) == (np.array(centres[1:]) + centres[:-1]) / 2).all()
    assert ends[0] < centres[0]
    assert ends[-1] > centres[-1]
    # Lines on a map between cells that are true and cells that are false.
    x, y = [0, 1, 2], [0, 10, 20]
    assert drawing("(...at) => boundary([[true, false], [true, null]], ...at)", x, y) == [[1, 0, 1, 10]]
    assert drawing("(...at) => boundary([[true], [false]], ...at)", x[:2], y) == [[0, 10, 1, 10]]
