"""The page's own arithmetic, held to that of the library without a browser."""

import numpy as np
import pytest
from scipy.special import stdtrit
from small import SMALL
from stiction import area_map, contacts, friction_map, random_phases, run, weierstrass_mandelbrot
from stiction.studies.dataset import empty_dataset
from stiction.studies.study import study_of
from stiction.views.report.page import MOST_CONTACTS, WINDOW, report_page

pytest.importorskip("plotly", reason="the extra 'report' is not installed")
pytest.importorskip("py_mini_racer", reason="mini-racer is not installed")

from page_numbers import PageNumbers

AGREEMENT = 1e-6
"""The page keeps 2e-9 of each sum; intervals are differences of these."""

SHAPES = 2e-4
"""The page keeps 1e-4 of what is only drawn."""

STATUSES = {"ok", "no-contact", "self-locked", "not-reached", "below-range"}

STUDIES = {
    "small": {},
    "to the left": {"contact.shear": "-x", "surfaces.amplitude": ["70 nm"]},
    "all curvatures at the minima of the gap": {"contact.curvature": "signed", "contact.detection": "gap-minimum"},
    "cylinders": {"contact.law": "hertz-cylinder"},
    "classical": {"surfaces.convention": "classical", "surfaces.amplitude_measure": "Rq"},
    "one dimension": {"surfaces.fractal_dimension": [1.3], "surfaces.amplitude": ["50 nm"]},
    "two repetitions": {"ensemble.repetitions": 2},
    "one repetition": {"ensemble.repetitions": 1},
    "one approach": {"contact.approach": ["10 nm"]},
}


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


@pytest.fixture(scope="module", autouse=True)
def without_plotly():
    """The numbers need no library of plots, and packing it takes most of the time of a page."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stiction.views.report.page._plotly", str)
        yield


@pytest.fixture(scope="module")
def result(small_result):
    return small_result


@pytest.fixture(scope="module")
def numbers(result):
    return PageNumbers(report_page(result))


def statuses_held_to_the_library(numbers, data, loads, mu0, tau0):
    """Friction and area of every dimension and amplitude are those of the maps; returns the statuses."""
    statuses = []
    for function, map_of, name in (
        ("frictionAt", friction_map, "friction_coefficient"),
        ("areaAt", area_map, "contact_area"),
    ):
        wanted = map_of(data, loads, mu0=[mu0], tau0=[tau0]).isel(mu0=0, tau0=0)
        wanted = wanted.transpose("fractal_dimension", "amplitude", "load")
        for d, a in np.ndindex(wanted["status"].shape[:2]):
            at = wanted.isel(fractal_dimension=d, amplitude=a)
            found = numbers.arrays(function, d, a, list(loads), mu0, tau0)
            assert np.array_equal(found.pop("status"), at["status"].values)
            for key, values in found.items():
                expected = at[name if key == "value" else key].values
                if key in ("lower", "upper"):
                    # Ends are mean exp(±h): an error of h, relative to it, is h times as much of an end.
                    ratio = (at["upper"] / at["lower"]).values
                    h = np.maximum(np.log(np.where(np.isfinite(ratio) & (ratio > 1), ratio, 1.0)) / 2, 1.0)
                    values = expected + (values - expected) / h
                assert values == pytest.approx(expected, rel=AGREEMENT, abs=1e-12, nan_ok=True), key
            statuses += at["status"].values.tolist()
    return statuses


@pytest.mark.parametrize("changes", STUDIES.values(), ids=STUDIES)
def test_friction_and_area_of_studies_are_those_of_the_library(changes):
    data = run(SMALL.with_changes(changes))
    numbers = PageNumbers(report_page(data))
    lowest, highest = numbers("() => facts.loads")
    loads = np.geomspace(lowest / 3, 3 * highest, 30).tolist()
    random = np.random.default_rng(5)
    statuses = [
        status
        for mu0, tau0 in [(0.0, 0.0), (0.4, 0.0), *random.uniform([0, 0], [1, 0.3], (2, 2)).tolist()]
        for status in statuses_held_to_the_library(numbers, data, loads, mu0, tau0)
    ]
    assert ("ok" in statuses) == (data.sizes["approach"] > 1)
    assert set(statuses) <= set(numbers("() => Object.keys(facts.statuses)")) == STATUSES


@pytest.mark.parametrize("reached", [0.0, 1.0])
def test_every_way_to_read_off_is_that_of_the_library(reached):
    data = invented(reached)
    numbers = PageNumbers(report_page(data))
    loads = np.append(np.geomspace(0.05, 60, 40), 0.5).tolist()
    statuses = []
    for mu0, tau0 in [(0.0, 0.0), *np.random.default_rng(3).uniform([0, 0], [1.5, 1.0], (5, 2)).tolist()]:
        statuses += statuses_held_to_the_library(numbers, data, loads, mu0, tau0)
    assert set(statuses) == STATUSES


def test_the_map_of_the_page_is_that_of_the_library(numbers, result):
    loads = np.geomspace(1e-5, 1, 25).tolist()
    wanted = friction_map(result, loads, mu0=[0.3], tau0=[0.04]).isel(amplitude=1, mu0=0, tau0=0)
    wanted = wanted.transpose("load", "fractal_dimension")
    found = numbers("(loads) => frictionMap(result, 1, loads, 0.3, 0.04)", loads)
    assert np.array_equal(found.pop("status"), wanted["status"].values)
    for name, values in found.items():
        expected = wanted["friction_coefficient" if name == "value" else name].values
        assert np.array(values, float) == pytest.approx(expected, rel=AGREEMENT, nan_ok=True)


def test_without_intervals_there_is_none(monkeypatch, result):
    monkeypatch.setattr("stiction.views.report.page.MOST_SUMS", 100)
    numbers = PageNumbers(report_page(result))
    found = numbers.arrays("frictionAt", 1, 0, [1e-3], 0.4, 0.0)
    wanted = friction_map(result, [1e-3], mu0=[0.4], tau0=[0.0]).isel(fractal_dimension=1, amplitude=0)
    assert found["value"] == pytest.approx(wanted["friction_coefficient"].values.ravel(), rel=AGREEMENT)
    assert np.isnan([found["lower"], found["upper"]]).all()


def test_nothing_touches():
    data = empty_dataset(SMALL.with_changes({"contact.approach": ["0 nm"]}))
    numbers = PageNumbers(report_page(data))
    assert numbers("() => facts.loads") == []
    assert set(statuses_held_to_the_library(numbers, data, [1e-3, 1.0], 0.4, 0.0)) == {"no-contact"}
    assert numbers("(map) => colourRange(facts, [frictionMap(result, 0, [1], 0.4, 0)])") == [0.1, 1]


def test_what_is_packed_comes_out_again(numbers, result):
    for name, relative in (("means", 0.0), ("sums", 2e-9)):
        kept = numbers(f"() => Array.from(result.{name}.contact_area)")
        expected = result["contact_area"].transpose("fractal_dimension", "amplitude", "repetition", "approach").values
        expected = expected.mean(axis=2) if name == "means" else expected
        assert np.array(kept) == pytest.approx(expected.ravel(), rel=relative, abs=0)


def test_quantiles_of_student(numbers):
    freedom = np.concatenate([np.linspace(1, 12, 50), np.geomspace(13, 1e5, 30)])
    found = numbers("(list) => list.map((freedom) => studentQuantile(0.975, freedom))", freedom.tolist())
    assert found == pytest.approx(stdtrit(freedom, 0.975), rel=1e-10)


def test_contacts_in_the_window_are_those_of_the_whole_profiles(numbers, result):
    surfaces, approaches = study_of(result).surfaces, result["approach"].values
    d, a, k = 1, 1, 7
    upper, lower = (
        weierstrass_mandelbrot(
            random_phases(SMALL.ensemble.seed, side=side),
            surfaces.fractal_dimensions()[d],
            extent=float(surfaces.extent),
            points=surfaces.points,
        ).with_amplitude(surfaces.amplitudes()[a])
        for side in ("upper", "lower")
    )
    example = numbers("(...at) => exampleAt(facts, profiles, contacts, ...at)", d, a, k)
    found = [[example["x"][0] + each["x"], *(each[name] for name in ("normal", "force", "opposes"))]
             for each in example["contacts"]]  # fmt: skip
    whole = contacts(upper, lower, approaches[k])
    first = round(example["x"][0] / lower.spacing)
    inside = (whole.index >= first) & (whole.index < first + WINDOW)
    expected = np.stack([whole.centre[:, 0], whole.normal[:, 0], whole.force, whole.opposing], axis=1)[inside]
    assert 1 < len(expected) < MOST_CONTACTS
    assert example["leftOut"] == 0
    assert np.array(found, float) == pytest.approx(expected, rel=SHAPES, abs=1e-4 * lower.spacing)
    heights = 1000 * lower.heights[first : first + WINDOW]
    drawn = np.array(example["lower"])
    assert drawn - drawn[0] == pytest.approx(heights - heights[0], abs=SHAPES * np.abs(drawn).max())


@pytest.mark.parametrize(
    ("call", "text"),
    [
        ("shown(0.123456)", "0.1235"),
        ("shown(-1.5e-7, 3)", "−1.50 × 10⁻⁷"),
        ("shown(123456)", "1.235 × 10⁵"),
        ("shown(NaN)", "–"),
        ("lengthName(0.05)", "50 nm"),
        ("lengthName(2.5)", "2.5 µm"),
    ],
)
def test_numbers_for_people(numbers, call, text):
    assert numbers(f"() => {call}") == text


@pytest.mark.parametrize("scale", [1.0, 1e-4, 1e4])
def test_geometric_loads_and_edges_hold_their_ends(numbers, scale):
    loads = numbers("(low, high) => geometric(low, high, 7)", scale, 64 * scale)
    assert loads == pytest.approx(scale * 2.0 ** np.arange(7))
    ends = numbers("(centres) => edges(centres)", loads)
    assert (np.array(ends[1:-1]) == (np.array(loads[1:]) + loads[:-1]) / 2).all()
    assert ends[0] < loads[0]
    assert ends[-1] > loads[-1]


def test_lines_and_outlines_of_a_map(numbers):
    x, y = [0, 1, 2], [0, 10, 20]
    assert numbers("(...at) => boundary([[0.2, 0.8], [0.2, null]], 0.5, ...at)", x, y) == [[1, 1, None], [0, 10, None]]
    assert numbers("(...at) => outlines([['a', 'b'], ['a', 'a']], 'a', ...at)", x, y) == [
        [0, 1, 1, 0, 0, None, 1, 2, 2, 1, 1, None],
        [0, 0, 20, 20, 0, None, 10, 10, 20, 20, 10, None],
    ]
