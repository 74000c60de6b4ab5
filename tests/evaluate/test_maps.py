import numpy as np
import pytest
import xarray
from stiction import Study, friction_map, run, stiffness_map
from stiction.evaluate.at_load import at_load
from stiction.evaluate.maps import area_map
from stiction.mechanics.load_curve import LoadCurve
from stiction.result import Result
from support.generated_studies import empty_dataset

ROUND_OFF = 1e-12
APPROACHES = np.linspace(0.01, 0.1, 10)
MAP_FUNCTIONS = {"friction_coefficient": friction_map, "contact_area": area_map, "normal_stiffness": stiffness_map}


def create_result(normal, tangential, *, frictional=None, area=None, count=None):
    """Return a result with one fractal dimension and one amplitude; arrays have the axes (repetition, approach)."""
    normal, tangential = np.atleast_2d(normal), np.atleast_2d(tangential)
    study = Study().with_changes(
        {
            "surfaces.fractal_dimension": [1.3], "contact.approach": [f"{k + 1} nm" for k in range(normal.shape[1])],
            "ensemble.repetitions": normal.shape[0], "friction.mu0": [0.0], "friction.tau0": ["0 MPa"],
        }
    )  # fmt: skip
    result = empty_dataset(study)
    result["normal_elastic"].values[0, 0] = normal
    result["tangential_elastic"].values[0, 0] = tangential
    result["normal_frictional"].values[0, 0] = 0 if frictional is None else frictional
    result["contact_area"].values[0, 0] = 0 if area is None else area
    result["contact_count"].values[0, 0] = 1 if count is None else count
    return result


def compute_friction_map(result, loads, **kwargs):
    return friction_map(result, loads, **kwargs).isel(fractal_dimension=0, amplitude=0, mu0=0, tau0=0)


def test_friction_map_interpolates_loads_linearly_in_the_approach():
    result = create_result([1.0, 2.0, 4.0], [0.5, 1.5, 1.7])
    values = compute_friction_map(result, [1.0, 1.5, 2.0, 3.0, 4.0])["friction_coefficient"].values
    assert np.allclose(values, [0.5, 1.0 / 1.5, 0.75, 1.6 / 3, 1.7 / 4], rtol=ROUND_OFF)


def test_friction_map_is_mean_tangential_over_mean_normal_load_of_all_pairs_even_without_contact():
    result = create_result([[1.0, 3.0], [0.0, 1.0], [0.0, 0.0]], [[0.9, 0.9], [0.0, 0.6], [0.0, 0.0]])
    # The mean normal loads at the two approaches are 1/3 and 4/3, and the mean tangential loads are 0.3 and 0.5.
    values = compute_friction_map(result, [4 / 3])["friction_coefficient"].values
    assert np.allclose(values, [0.5 / (4 / 3)], rtol=ROUND_OFF)


def test_friction_map_uses_the_first_approach_at_which_the_load_rises_to_the_requested_load():
    result = create_result([1.0, 3.0, 2.0, 5.0], [0.1, 0.3, 0.8, 5.0])
    assert np.allclose(compute_friction_map(result, [2.5])["friction_coefficient"], [0.25 / 2.5], rtol=ROUND_OFF)
    result = create_result([1.0, -3.0, 2.0, 5.0], [0.1, 0.3, 0.8, 5.0])
    assert np.allclose(compute_friction_map(result, [2.0])["friction_coefficient"], [0.4], rtol=ROUND_OFF)
    assert np.allclose(
        compute_friction_map(result, [0.75])["friction_coefficient"], [(0.3 + 0.75 * 0.5) / 0.75], rtol=ROUND_OFF
    )


def test_friction_map_has_a_status_instead_of_extrapolated_values_outside_its_loads():
    result = create_result([1.0, 2.0], [0.5, 1.0])
    table = compute_friction_map(result, [0.9, 1.0, 2.0, 2.1])
    assert table["status"].values.tolist() == ["below-range", "ok", "ok", "not-reached"]
    assert np.isfinite(table["friction_coefficient"]).values.tolist() == [False, True, True, False]

    self_locked_result = create_result([1.0, 2.0, 3.0], [0.5, 1.0, 1.5], frictional=[0.0, -1.5, -4.0])
    table = compute_friction_map(self_locked_result, [0.9, 1.2, 2.0], mu0=1.0)
    assert table["status"].values.tolist() == ["below-range", "self-locked", "self-locked"]
    assert compute_friction_map(self_locked_result, [1.2], mu0=0.1)["status"].values.tolist() == ["ok"]

    separating_result = create_result([[1.0, 2.0, 0.0]], [[0.5, 1.0, 0.0]], count=[[1, 1, 0]])
    assert compute_friction_map(separating_result, [3.0])["status"].values.tolist() == ["not-reached"]

    separated_result = create_result([0.0, 0.0], [0.0, 0.0], count=0)
    table = compute_friction_map(separated_result, [1.0])
    assert table["status"].values.tolist() == ["no-contact"]
    assert np.isnan(table["friction_coefficient"]).all()


@pytest.mark.parametrize(
    ("normal", "tangential", "load", "value", "width"),
    [
        ([[2.0]], [[1.0]], 2.0, 0.5, np.nan),
        ([[0.0, 0.0]] * 4 + [[1.0, 2.0]], [[0.0, 0.0]] * 4 + [[0.5, 1.0]], 0.3, 0.5, np.nan),
        ([[1.0, 2.0]] * 5, [[0.5, 1.0]] * 5, 1.5, 0.5, 0.0),
        ([[1.0, 2.0], [1.1, 2.5]], [[0.0, 0.0]] * 2, 1.5, 0.0, 0.0),
    ],
)
def test_friction_map_interval_is_nan_for_few_pairs_and_zero_for_identical_pairs(
    normal, tangential, load, value, width
):
    table = compute_friction_map(create_result(normal, tangential), [load])
    value_and_ends = [float(table[name][0]) for name in ("friction_coefficient", "lower", "upper")]
    assert value_and_ends == pytest.approx([value, value + width, value + width], rel=ROUND_OFF, nan_ok=True)


def test_friction_map_has_an_interval_if_only_some_pairs_reach_the_load():
    normal = np.array([[1.0, 2.0], [1.2, 3.0], [0.8, 4.0]])
    table = compute_friction_map(create_result(normal, 0.5 * normal * [[1.0], [1.1], [0.9]]), [2.99])
    assert table["status"].values.tolist() == ["ok"]
    assert table["lower"].values[0] < table["friction_coefficient"].values[0] < table["upper"].values[0]


def test_lower_limits_of_friction_map_intervals_are_not_negative():
    random = np.random.default_rng(4)
    for _ in range(50):
        normal = np.exp(2 * random.standard_normal((3, 1))) * [[1.0, 2.0, 3.0]]
        table = compute_friction_map(
            create_result(normal, normal * np.exp(2 * random.standard_normal((3, 1)))),
            [float(2.99 * normal[:, 0].mean())],
        )
        assert 0 <= table["lower"].values[0] <= table["friction_coefficient"].values[0] <= table["upper"].values[0]


def test_validity_indicators_are_interpolated_at_the_requested_load():
    result = create_result([1.0, 2.0, 4.0], [0.5, 1.5, 1.7])
    result["load_below_grid"].values[0, 0] = [0.5, 0.5, 3.5]
    result["overlap_load"].values[0, 0] = [0.1, 0.4, 0.8]
    result["crossed_count"].values[0, 0] = [0, 1, 3]
    table = compute_friction_map(result, [2.0, 3.0, 5.0])
    assert table["share_below_grid"].values == pytest.approx([0.25, 2 / 3, np.nan], nan_ok=True)
    assert table["relative_overlap"].values == pytest.approx([0.2, 0.2, np.nan], nan_ok=True)
    assert table["share_crossed"].values == pytest.approx([0.5, 2 / 3, np.nan], nan_ok=True)


def test_friction_map_uses_mu0_and_tau0_of_the_study_by_default():
    result = empty_dataset(Study().with_changes({"surfaces.fractal_dimension": [1.0], "ensemble.repetitions": 2}))
    table = friction_map(result, [1.0])
    assert table["mu0"].values.tolist() == [0.1, 0.4, 1.0]
    assert table["tau0"].values.tolist() == [0, 0.0005, 0.01, 0.1, 0.2]
    assert table["friction_coefficient"].dims == ("fractal_dimension", "amplitude", "load", "mu0", "tau0")
    assert {table[name].attrs["units"] for name in ("load", "tau0")} == {"mN", "GPa"}


def test_friction_map_of_a_dataset_without_a_study_requires_mu0_and_tau0_as_arguments():
    result = create_result([1.0, 2.0], [0.5, 1.0]).drop_attrs()
    assert compute_friction_map(result, [1.5], mu0=0.0, tau0=0.0)["status"].values.tolist() == ["ok"]
    with pytest.raises(ValueError, match="mu0 and tau0 must be given"):
        friction_map(result, [1.5])


@pytest.mark.parametrize("loads", [[-1.0], [np.nan], [[1.0]], []])
def test_friction_map_rejects_invalid_loads(loads):
    with pytest.raises(ValueError, match="loads"):
        friction_map(create_result([1.0], [1.0]), loads)


def test_area_map_interpolates_linearly_in_the_approach():
    table = area_map(create_result([1.0, 2.0, 4.0], [0.5, 1.5, 1.7], area=[10.0, 20.0, 60.0]), [1.5, 3.0])
    assert np.allclose(table["contact_area"].values.ravel(), [15, 40], rtol=ROUND_OFF)
    assert table["contact_area"].attrs["units"] == "um^2"


# ---- Coverage ----------------------------------------------------------------------------------------------------

NUM_ENSEMBLES = 2000
# Minimum coverage of 95 % intervals by (spread, scatter) and number of repetitions.
# If a lognormal load has few repetitions, the coverage is below 0.95, because small samples often miss the tail.
MIN_COVERAGE = {
    (0.3, 0.3): {5: 0.93, 10: 0.935, 24: 0.94, 100: 0.94},
    (0.8, 0.5): {5: 0.88, 10: 0.91, 24: 0.925, 100: 0.935},
    (1.0, 1.0): {5: 0.81, 10: 0.845, 24: 0.885, 100: 0.915},  # here 1 % of the repetitions determine most of the mean
}
MAX_COVERAGE = 0.975


def simulate_ensembles(repetitions, ensembles, *, spread, scatter, seed, touching=1.0):
    """Return ensembles whose loads are power laws of the approach times lognormal factors.

    The dimension `fractal_dimension` is the index of the ensemble. The factors of F_N and F_T are correlated, and mu_s
    is proportional to F_N^-0.1, so that an error of the approach at a load changes the friction coefficient.
    """
    random = np.random.default_rng(seed)
    shape = (ensembles, 1, repetitions, 1)
    factor = np.exp(spread * random.standard_normal(shape) - spread**2 / 2)
    friction_factor = np.exp(scatter * random.standard_normal(shape) - scatter**2 / 2)
    factor = factor * (random.random(shape) < touching) / touching
    normal_load = factor * APPROACHES**1.5
    tangential_load = factor * friction_factor * 0.3 * APPROACHES**1.35
    zeros = np.zeros_like(normal_load)
    dims = ("fractal_dimension", "amplitude", "repetition", "approach")
    fields = {name: (dims, zeros) for name in LoadCurve.__dataclass_fields__ if name.startswith(("normal", "tangent"))}
    fields |= {"normal_elastic": (dims, normal_load), "tangential_elastic": (dims, tangential_load)}
    fields |= {"contact_count": (dims, np.ones(normal_load.shape, int)), "contact_area": (dims, zeros)}
    coordinates = {"fractal_dimension": np.arange(ensembles), "amplitude": [0.1], "approach": APPROACHES}
    return xarray.Dataset(fields, coordinates)


@pytest.mark.parametrize("repetitions", [10, *(pytest.param(count, marks=pytest.mark.soak) for count in (5, 24, 100))])
@pytest.mark.parametrize(
    ("spread", "scatter"),
    [item if item == (0.8, 0.5) else pytest.param(*item, marks=pytest.mark.soak) for item in MIN_COVERAGE],
)
def test_friction_map_intervals_contain_the_true_value_in_95_percent_of_cases(repetitions, spread, scatter):
    # Request the true mean load at one of the approaches, at which interpolation adds no error.
    load = APPROACHES[5] ** 1.5
    true_coefficient = 0.3 * APPROACHES[5] ** 1.35 / load
    result = simulate_ensembles(repetitions, NUM_ENSEMBLES, spread=spread, scatter=scatter, seed=repetitions)
    table = friction_map(result, [load], mu0=0.0, tau0=0.0)
    is_ok = table["status"].values.ravel() == "ok"
    assert is_ok.mean() > 0.9
    coverage = (
        ((table["lower"] <= true_coefficient) & (true_coefficient <= table["upper"])).values.ravel()[is_ok].mean()
    )
    assert MIN_COVERAGE[spread, scatter][repetitions] <= coverage <= MAX_COVERAGE, coverage


def test_friction_map_intervals_cover_95_percent_of_cases_if_half_of_the_pairs_lack_contact():
    load = APPROACHES[5] ** 1.5
    true_coefficient = 0.3 * APPROACHES[5] ** 1.35 / load
    result = simulate_ensembles(24, NUM_ENSEMBLES, spread=0.5, scatter=0.3, seed=5, touching=0.5)
    table = friction_map(result, [load], mu0=0.0, tau0=0.0)
    is_ok = table["status"].values.ravel() == "ok"
    coverage = (
        ((table["lower"] <= true_coefficient) & (true_coefficient <= table["upper"])).values.ravel()[is_ok].mean()
    )
    assert 0.9 <= coverage <= MAX_COVERAGE


def test_stiffness_map_equals_the_derivative_of_the_mean_load():
    # Central differences give the exact derivative of the parabola F = k δ².
    approach = np.arange(1, 8) * 1e-3
    stiffness = np.array([[1000.0], [3000.0]])
    result = create_result(stiffness * approach**2, np.zeros((2, 7)))
    loads = 2000 * approach[1:-1] ** 2
    computed_map = stiffness_map(result, loads).isel(fractal_dimension=0, amplitude=0, mu0=0, tau0=0)
    assert np.allclose(computed_map["normal_stiffness"], 2 * 2000 * approach[1:-1], rtol=ROUND_OFF)
    assert computed_map["normal_stiffness"].attrs["units"] == "mN/um"
    assert (computed_map["lower"] < computed_map["normal_stiffness"]).all()
    assert (computed_map["upper"] > computed_map["normal_stiffness"]).all()


def test_stiffness_map_includes_frictional_and_adhesive_loads():
    approach = np.arange(1, 6) * 1e-3
    result = create_result(1000 * approach, np.zeros(5), frictional=-500 * approach)
    stiffness = stiffness_map(result, [2.0], mu0=[0.0, 0.4], tau0=[0.0])["normal_stiffness"]
    assert np.allclose(stiffness.values.ravel(), [1000.0, 800.0], rtol=ROUND_OFF)


def test_stiffness_map_requires_a_result_with_at_least_three_approaches():
    with pytest.raises(ValueError, match="3 approaches"):
        stiffness_map(create_result([1.0, 2.0], [0.1, 0.2]), [1.5])


def test_evaluation_of_all_quantities_reads_the_stored_result_only_twice(monkeypatch):
    result = run(Study.named("quick").with_changes({"ensemble.repetitions": 6, "surfaces.points": 3000}))
    loads = result.mean_elastic_loads.values.max() * np.array([0.1, 0.5])
    maps = [(name, evaluate(result, loads)) for name, evaluate in MAP_FUNCTIONS.items()]
    requested_names = []
    read_pieces = Result.pieces
    monkeypatch.setattr(
        Result, "pieces", lambda self, names=None: requested_names.append(names) or read_pieces(self, names)
    )
    points = at_load(result, loads)
    assert len(requested_names) == 2
    for name, single_map in maps:
        for statistic, variable in (("mean", name), ("lower", "lower"), ("upper", "upper")):
            xarray.testing.assert_equal(
                points[name].sel(statistic=statistic).reset_coords(drop=True),
                single_map[variable].reset_coords(drop=True),
            )
    np.testing.assert_array_equal(points["share_beyond_hertz"], maps[0][1]["share_beyond_hertz"])
    requested_names.clear()
    assert "share_beyond_hertz" not in at_load(result, loads, names=["contact_area"])
    assert {name for names in requested_names for name in names}.isdisjoint({"overlap_load", "crossed_count"})
