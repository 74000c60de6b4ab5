"""The page's own arithmetic, held to that of the library without a browser."""

import itertools

import numpy as np
import pytest
from scipy.special import stdtrit
from stiction import Study, area_map, friction_map, gentle_friction, run, stiffness_map
from stiction._number_format import percent, quoted, significant, with_unit
from stiction.studies import intervals
from stiction.studies.at_load import at_load
from stiction.studies.input_caveats import doubts_of_study
from stiction.studies.point import rules_of
from stiction.studies.study import study_of
from stiction.studies.summary import summarize
from stiction.views.report import report_page
from support.generated_studies import SMALL, empty_dataset

pytest.importorskip("py_mini_racer", reason="mini-racer is not installed")

from support.report_numbers import PageNumbers

AGREEMENT = 1e-6  # the page keeps 2e-9 of each sum; intervals are differences of these
MEASURED = 1e-9  # of measured bodies the page keeps every bit
READ_OFF = {"ok", "no-contact", "self-locked", "not-reached", "below-range"}


def invented(reached):
    """Sums that are of no surface: loads that rise and fall, fall below zero, and repetitions that carry nothing."""
    data = empty_dataset(SMALL)
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
    return PageNumbers(report_page(result))


# ---- Means of generated bodies ---------------------------------------------------------------------------------------

MAPS = {
    "friction": (friction_map, "friction_coefficient"),
    "area": (area_map, "contact_area"),
    "stiffness": (stiffness_map, "normal_stiffness"),
}


def statuses_held_to_the_library(numbers, data, loads, mu0, tau0, motion=0):
    """Friction, area and stiffness of every dimension and amplitude are those of the maps; returns the statuses."""
    statuses = []
    has_stiffness = numbers("() => facts.hasStiffness")
    for quantity, (map_of, name) in MAPS.items():
        if quantity == "stiffness" and not has_stiffness:
            continue
        wanted = map_of(data, loads, mu0=[mu0], tau0=[tau0]).isel(mu0=0, tau0=0)
        wanted = wanted.transpose("fractal_dimension", "amplitude", "load")
        for d, a in np.ndindex(wanted["status"].shape[:2]):
            at = wanted.isel(fractal_dimension=d, amplitude=a)
            found = numbers.arrays(quantity, d, a, list(loads), mu0, tau0, motion=motion)
            assert np.array_equal(found.pop("status"), at["status"].values)
            for key, values in found.items():
                if key not in at and key not in ("value", "lower", "upper"):
                    continue  # what areas and half-spaces have besides
                expected = at[name if key == "value" else key].values
                if key in ("lower", "upper"):
                    # Ends are mean exp(±h): an error of h, relative to it, is h times as much of an end.
                    with np.errstate(invalid="ignore", divide="ignore"):
                        ratio = (at["upper"] / at["lower"]).values
                    h = np.maximum(np.log(np.where(np.isfinite(ratio) & (ratio > 1), ratio, 1.0)) / 2, 1.0)
                    values = expected + (values - expected) / h
                assert values == pytest.approx(expected, rel=AGREEMENT, abs=1e-12, nan_ok=True), key
            statuses += at["status"].values.tolist()
    return statuses


HALF_PLANES = {
    "contact.mechanics": "half-space", "contact.load": {"start": "10 uN", "stop": "1 mN", "count": 5},
    "contact.sliding": ["opposing", "all"], "surfaces.points": 512, "surfaces.extent": "5 um",
    "ensemble.repetitions": 4, "surfaces.band_limit": "nyquist", "surfaces.fractal_dimension": [1.1, 1.4],
}  # fmt: skip


def test_every_rule_of_half_planes_is_that_of_the_library():
    data = run(Study.named("quick").with_changes(HALF_PLANES)).dataset
    numbers = PageNumbers(report_page(data))
    lowest, highest = numbers("() => facts.loads")
    loads = np.geomspace(lowest / 3, 3 * highest, 20).tolist()
    for m, rule in enumerate(numbers("() => facts.rules")):
        one = data.sel(sliding=rule)
        assert "ok" in statuses_held_to_the_library(numbers, one, loads, 0.4, 0.1, motion=m)


@pytest.mark.parametrize("reached", [0.0, 1.0])
def test_every_way_to_read_off_is_that_of_the_library(reached):
    data = invented(reached)
    numbers = PageNumbers(report_page(data))
    loads = np.append(np.geomspace(0.05, 60, 40), 0.5).tolist()
    statuses = []
    for mu0, tau0 in [(0.0, 0.0), *np.random.default_rng(3).uniform([0, 0], [1.5, 1.0], (5, 2)).tolist()]:
        statuses += statuses_held_to_the_library(numbers, data, loads, mu0, tau0)
    assert set(statuses) == READ_OFF


def test_members_without_a_solution_are_left_out_as_by_the_library(result):
    data = result.copy(deep=True)
    for name in ("normal_elastic", "tangential_elastic", "contact_area"):
        data[name].loc[{"repetition": 3, "approach": data["approach"][-1]}] = np.nan
    numbers = PageNumbers(report_page(data))
    assert numbers("() => facts.repetitions") == data.sizes["repetition"] - 1
    assert "ok" in statuses_held_to_the_library(numbers, data, [1e-3, 1e-2], 0.4, 0.1)


def test_the_map_of_the_page_is_that_of_the_library(numbers, result):
    loads = np.geomspace(1e-5, 1, 25).tolist()
    wanted = friction_map(result, loads, mu0=[0.3], tau0=[0.04]).isel(amplitude=1, mu0=0, tau0=0)
    wanted = wanted.transpose("load", "fractal_dimension")
    found = numbers("(loads) => mapOf(result, 'friction', 1, loads, 0.3, 0.04)", loads)
    ok = wanted["status"].values == "ok"
    assert np.array_equal(found["status"], wanted["status"].values)
    assert np.array(found["value"], float) == pytest.approx(
        wanted["friction_coefficient"].values, rel=AGREEMENT, nan_ok=True
    )
    limits = {"share_beyond_hertz": 0.5, "share_below_grid": 0.5}
    trusted = np.logical_and.reduce([~(wanted[name].values > limit) for name, limit in limits.items()])
    assert np.array_equal(np.array(found["trusted"])[ok], trusted[ok])
    assert 0 < trusted[ok].mean() < 1
    sound = trusted & ~(wanted["relative_overlap"].values > 0.1) & ~(wanted["share_crossed"].values > 0.5)
    assert np.array_equal(np.array(found["isSound"])[ok], sound[ok])
    d, row = numbers("(map) => beginning(map)", found)
    assert sound[row, d]
    widths = numbers("(loads) => mapOf(result, 'width', 1, loads, 0.3, 0.04).value", loads)
    expected = (wanted["upper"] - wanted["lower"]) / (2 * wanted["friction_coefficient"])
    assert np.array(widths, float) == pytest.approx(expected.values, rel=1e-5, nan_ok=True)
    d, row = numbers("(map, widths) => beginning(map, widths)", found, widths)
    assert widths[row][d] == pytest.approx(np.nanmin(np.where(sound, np.array(widths, float), np.nan)))


def test_nothing_touches():
    data = empty_dataset(SMALL.with_changes({"contact.approach": ["0 nm"]}))
    numbers = PageNumbers(report_page(data))
    assert numbers("() => facts.loads") == []
    assert set(statuses_held_to_the_library(numbers, data, [1e-3, 1.0], 0.4, 0.0)) == {"no-contact"}
    assert numbers("() => colourRange(facts, mapOf(result, 'friction', 0, [1], 0.4, 0))") == [0.1, 1]


def test_what_is_packed_comes_out_again(numbers, result):
    for name, relative in (("means", 0.0), ("sums", 2e-9)):
        kept = numbers(f"() => Array.from(result.{name}.contact_area)")
        expected = result["contact_area"].transpose("fractal_dimension", "amplitude", "repetition", "approach").values
        expected = expected.mean(axis=2) if name == "means" else expected
        assert np.array(kept) == pytest.approx(expected.ravel(), rel=relative, abs=0)


# ---- The verdict -----------------------------------------------------------------------------------------------------

JUDGED = """(d, a, m, loads, mu0, tau0) => loads.map((load) => {
  const at = readOff(results[m], 'friction', d, a, [load], mu0, tau0)[0];
  const doubts = doubtsOfEnsemble(facts, at, readOff(results[m], 'area', d, a, [load], mu0, tau0)[0].value);
  return [verdictOf(facts, doubts), doubts];
})"""


def verdicts_held_to_the_library(data, loads, material, changes=None):
    """Verdict and doubts of every cell, load and rule of a page are those of the terminal; returns the verdicts."""
    data = data if changes is None else data.assign_attrs(study=study_of(data).with_changes(changes).to_toml())
    study, numbers = study_of(data), PageNumbers(report_page(data))
    assert numbers("() => facts.quotedRule") == rules_of(study)[0]
    rules = numbers("() => facts.rules")
    verdicts = set()
    for (m, rule), (mu0, tau0) in itertools.product(enumerate(rules), material):
        own = data.sel(sliding=rule) if "sliding" in data.dims else data
        alone = study.with_changes({"contact.sliding": rule})
        wanted = {
            (one.at["fractal_dimension"], one.at["amplitude"], one.at["load"]): one
            for one in summarize(at_load(own, loads, mu0=[mu0], tau0=[tau0]), alone).points
        }
        for d, a in np.ndindex(data.sizes["fractal_dimension"], data.sizes["amplitude"]):
            cell = float(data["fractal_dimension"][d]), float(data["amplitude"][a])
            for load, (verdict, doubts) in zip(loads, numbers(JUDGED, d, a, m, loads, mu0, tau0), strict=True):
                one = wanted[(*cell, load)]
                said = [{"text": each.text, "cure": each.cure, "severity": each.severity} for each in one.doubts]
                assert (verdict, sorted(doubts, key=lambda each: each["severity"] != "fault")) == (one.verdict, said)
                verdicts.add(verdict)
    return verdicts


def test_the_verdict_of_a_page_of_asperities_is_that_of_the_library(result):
    loads = np.geomspace(1e-4, 0.3, 9).tolist()
    for modulus in ("10 GPa", "50 MPa"):
        changes = {"contact.effective_modulus": modulus}
        assert verdicts_held_to_the_library(result, loads, [(0.1, 0.0), (0.4, 0.002)], changes) == {
            "Quote with care",
            "Do not quote",
        }


@pytest.mark.parametrize("reached", [0.0, 1.0])
def test_the_verdict_where_nothing_is_as_it_should_be_is_that_of_the_library(reached):
    loads = np.geomspace(0.05, 60, 7).tolist()
    assert "Do not quote" in verdicts_held_to_the_library(invented(reached), loads, [(0.0, 0.0), (1.2, 0.4)])


def test_the_verdict_of_a_page_of_half_planes_is_that_of_the_library():
    data = run(Study.named("quick").with_changes(HALF_PLANES)).dataset
    assert len(verdicts_held_to_the_library(data, [0.02, 0.3, 0.9], [(0.2, 0.0), (0.6, 0.3)])) > 1


def test_the_answers_on_a_page_of_measured_bodies_are_those_of_the_library(measured):
    data, numbers = measured
    study = study_of(data)
    asked = [float(load) for load in study.friction.load]
    wanted = summarize(at_load(data, asked), study, input_caveats=doubts_of_study(study)).points
    found = numbers("() => facts.answers.map(({verdict, doubts}) => [verdict, doubts])")
    assert found == [
        [one.verdict, [{"text": each.text, "cure": each.cure, "severity": each.severity} for each in one.doubts]]
        for one in wanted
    ]


# ---- Members of measured bodies --------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["maps", "lines"])
def measured(request):
    """A result of measured bodies and the numbers of its page."""
    data = request.getfixturevalue(request.param)
    return data, PageNumbers(report_page(data))


@pytest.mark.parametrize(("mu0", "tau0"), [(0.3, 0.0), (0.37, 0.08)])
def test_friction_of_measured_bodies_is_that_of_the_library(measured, mu0, tau0):
    data, numbers = measured
    loads = data["load"].values
    wanted = at_load(data, loads, mu0=[mu0], tau0=[tau0]).isel(mu0=0, tau0=0, cut_off=0)
    every = list(range(data.sizes["direction"]))
    for r, rule in enumerate(numbers("() => facts.rules")):
        for chosen, name in [*(([d], "friction_coefficient") for d in every), (every, "friction_all_round")]:
            at = wanted[name].sel(sliding=rule)
            at = at.isel(direction=chosen[0]) if "direction" in at.dims else at
            motions = [r * len(every) + d for d in chosen]
            found = numbers(
                "(chosen, loads, mu0, tau0) => readOff({...result, chosen}, 'friction', 0, 0, loads, mu0, tau0)"
                ".map(({value, lower, upper}) => [value, lower, upper])", motions, loads.tolist(), mu0, tau0,
            )  # fmt: skip
            assert np.array(found) == pytest.approx(at.transpose("load", "statistic").values, rel=MEASURED, nan_ok=True)
            alone = numbers(
                "(way, rule, mu0, tau0) => slopesAlone(result, 0, way, rule, mu0, tau0)", chosen, rule, mu0, tau0
            )
            slopes = wanted["gentle_friction"].sel(sliding=rule).isel(direction=chosen)
            slopes = slopes.sel(statistic="mean") if "statistic" in slopes.dims else slopes
            assert alone == pytest.approx(float(slopes.mean()), rel=MEASURED)


def test_contacts_of_measured_bodies_are_those_of_the_library(measured):
    data, numbers = measured
    loads = data["load"].values
    wanted = at_load(data, loads, mu0=[0.3], tau0=[0.0]).isel(cut_off=0)
    names = numbers("() => facts.quantities.map(({name}) => name)")
    assert {"contact_area_fraction", "contact_count", "mean_pressure", "normal_stiffness"} <= set(names)
    for name in names:
        found = numbers(
            "(name, loads) => readOff(result, name, 0, 0, loads, 0.3, 0).map(({value, lower, upper}) =>"
            " [value, lower, upper])", name, loads.tolist(),
        )  # fmt: skip
        expected = wanted[name].transpose("load", "statistic").values
        assert np.array(found) == pytest.approx(expected, rel=MEASURED, abs=1e-15, nan_ok=True), name
    # A load that was not computed has no value.
    assert numbers("() => readOff(result, 'friction', 0, 0, [0.3], 0.3, 0)[0].status") == "not-reached"


@pytest.mark.parametrize("sliding", ["opposing", "all"])
def test_friction_by_the_slope_alone_is_that_of_the_library(numbers, sliding):
    for mu0, tau0, gradient, slope in ((0.4, 0.0, 0.3, 0.2), (0.3, 0.2, 0.04, 0.05), (2.0, 1.0, 0.1, 9.0)):
        found = numbers(
            "(...at) => gentleFriction(...at)", mu0, tau0,
            {"gradient": gradient, "slope": slope, "modulus": 10.0, "kappa": 2.2}, sliding,
        )  # fmt: skip
        wanted = gentle_friction(mu0, tau0, rms_gradient=gradient, rms_slope=slope, kappa=2.2, sliding=sliding)
        assert found == pytest.approx(float(wanted), rel=1e-12, nan_ok=True)


@pytest.mark.parametrize("sample", [[0.1, 0.2, 0.4], [0.1, 0.5], [-1.0, 2.0, 3.0, np.nan], [0.0, 0.01, 3.0]])
def test_means_of_a_sample_are_those_of_the_library(numbers, sample):
    found = numbers(
        "(sample) => ofSample(sample.map((x) => (x === null ? NaN : x)), facts)",
        [None if np.isnan(x) else x for x in sample],
    )
    assert found == pytest.approx([float(x) for x in intervals.of_sample(np.array(sample))], rel=1e-9, nan_ok=True)


@pytest.mark.parametrize(
    "values", [np.sin(np.arange(9.0)), np.exp(np.sin(np.arange(40.0))), [1.0] * 9, [0.1, 0.2, 0.3]]
)
def test_means_of_neighbours_are_those_of_the_library(numbers, values):
    found = numbers("(values) => ofNeighbours(values, facts)", list(values))
    assert found == pytest.approx([float(x) for x in intervals.of_neighbours(np.array(values))], rel=1e-9, nan_ok=True)


# ---- Pieces ----------------------------------------------------------------------------------------------------------


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
def test_ticks_are_round(numbers, low, high, is_log, texts):
    found = numbers("(...at) => ticksOf(...at)", low, high, is_log, 6)
    assert [tick["text"] for tick in found if tick["text"]] == texts
    assert all(low * (1 - 1e-9) <= tick["value"] <= high * (1 + 1e-9) for tick in found)


def test_quantiles_of_student(numbers):
    freedom = np.concatenate([np.linspace(1, 12, 50), np.geomspace(13, 1e5, 30)])
    found = numbers("(list) => list.map((freedom) => studentQuantile(facts, freedom))", freedom.tolist())
    assert found == pytest.approx(stdtrit(freedom, 0.975), rel=1e-10)


@pytest.mark.parametrize("value", [0.0, 5e-4, 0.1147, 0.99951, 17.251, 1234.0])
def test_numbers_for_people_are_those_of_the_terminal(numbers, value):
    assert numbers("(value) => quoted(value)", value) == quoted(value)
    assert numbers("(value) => percent(value)", value) == percent(value)
    for low, high in ((0.98, 1.03), (0.9999, 1.0002), (1.0, 1.0), (0.2, 300.0)):
        ends = (value, low * value, high * value)
        assert numbers("(...ends) => quoted(...ends)", *ends) == quoted(*ends)
    for digits in (1, 2, 3):
        assert numbers("(...at) => significant(...at)", value, digits) == significant(value, digits)
    for unit in ("mN", "GPa", "um"):
        assert numbers("(value, unit) => withUnit(value, unit)", value, unit) == with_unit(value, unit)


@pytest.mark.parametrize("scale", [1.0, 1e-4, 1e4])
def test_geometric_loads_and_edges_hold_their_ends(numbers, scale):
    loads = numbers("(low, high) => geometric(low, high, 7)", scale, 64 * scale)
    assert loads == pytest.approx(scale * 2.0 ** np.arange(7))
    ends = numbers("(centres) => edges(centres)", loads)
    assert (np.array(ends[1:-1]) == (np.array(loads[1:]) + loads[:-1]) / 2).all()
    assert ends[0] < loads[0]
    assert ends[-1] > loads[-1]
    # Lines on a map between what is true and what is false.
    x, y = [0, 1, 2], [0, 10, 20]
    assert numbers("(...at) => boundary([[true, false], [true, null]], ...at)", x, y) == [[1, 0, 1, 10]]
    assert numbers("(...at) => boundary([[true], [false]], ...at)", x[:2], y) == [[0, 10, 1, 10]]
