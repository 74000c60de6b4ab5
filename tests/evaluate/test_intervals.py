import numpy as np
import pytest
import scipy.special
import scipy.stats
from reference.jackknife import interval_at_load
from reference.neighbours import coverage_and_width, estimate_true_mean, simulate_correlated_positions
from stiction import _core
from stiction.evaluate.intervals import (
    MIN_NEIGHBOURING_POSITIONS,
    MeansAtLoads,
    average_correlated_values,
    average_independent_values,
    average_line_means,
)
from stiction.solve.contact_statistics import compute_sample_quantiles

NUM_TRIALS = 500  # 500 trials give a standard error of 1 % of the measured coverage.
MAX_WIDTH_RATIO = 1.5  # maximum median width for at least 32 values, relative to the width for a known variance

MIN_DEFINED_FRACTION = 0.85
"""Smallest fraction of traverses with an interval; if half of 16 correlated values are zero, all may be zero."""

# Minimum coverage by number of positions and correlation: the coverage from docs/scripts/intervals.py minus 0.03.
MIN_COVERAGE = {
    (16, 0.0): 0.95, (16, 0.4): 0.92, (16, 0.8): 0.78,
    (32, 0.0): 0.94, (32, 0.4): 0.90, (32, 0.8): 0.84,
    (64, 0.0): 0.94, (64, 0.4): 0.90, (64, 0.8): 0.87,
    (200, 0.0): 0.92, (200, 0.4): 0.90, (200, 0.8): 0.88,
}  # fmt: skip


# Number of values and correlation of the cases that also run outside the stress suite.
DEFAULT_CASES = ((16, 0.8), (64, 0.4), (200, 0.0))


@pytest.mark.parametrize(
    ("positions", "correlation"),
    [
        *DEFAULT_CASES,
        *(pytest.param(*case, marks=pytest.mark.soak) for case in MIN_COVERAGE if case not in DEFAULT_CASES),
    ],
)
@pytest.mark.parametrize("distribution", ["half zeros", "bounded", "lognormal 0.5"])
def test_interval_of_the_mean_of_correlated_values_contains_the_true_mean_and_is_less_than_twice_as_wide_as_needed(
    distribution, positions, correlation
):
    random = np.random.default_rng([positions, int(10 * correlation)])
    true_mean, smallest_width = estimate_true_mean(distribution, positions, correlation, random)
    coverage, width_ratio, defined_fraction = coverage_and_width(
        average_correlated_values,
        simulate_correlated_positions(distribution, NUM_TRIALS, positions, correlation, random),
        true_mean,
        smallest_width,
    )
    assert defined_fraction > MIN_DEFINED_FRACTION
    assert coverage >= MIN_COVERAGE[positions, correlation]
    assert width_ratio <= (MAX_WIDTH_RATIO if positions > 16 else 1.2 * MAX_WIDTH_RATIO)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9])
def test_interval_of_the_mean_of_correlated_values_agrees_with_a_dense_matrix_calculation(correlation):
    """Compare with the mixture of t distributions over correlations, computed with dense covariance matrices."""
    count = 20
    values = simulate_correlated_positions("normal", 1, count, correlation, np.random.default_rng(7))[0]
    correlations = np.arange(20) / 20
    lag = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    errors, weights = [], []
    for correlation in correlations:
        matrix = correlation**lag if correlation else np.eye(count)
        inverse = np.linalg.inv(matrix)
        centre = inverse.sum(axis=0) @ values / inverse.sum()
        squares = (values - centre) @ inverse @ (values - centre)
        errors.append(np.sqrt(squares / (count - 1) * matrix.sum()) / count)
        weights.append(
            np.sqrt(1 - correlation) / np.sqrt(np.linalg.det(matrix) * inverse.sum()) / squares ** ((count - 1) / 2)
        )
    weights = np.array(weights) / np.sum(weights)
    mean, lower, upper = average_correlated_values(values)
    skew_factor = scipy.stats.skew(values) / 3 / values.std(ddof=1)
    for end, sign in ((lower, -1), (upper, 1)):
        if end in (values.min(), values.max()):
            continue
        unskewed_distance = np.log1p(skew_factor * (end - mean)) / skew_factor
        assert weights @ scipy.stats.t(count - 1).cdf(sign * unskewed_distance / np.array(errors)) == pytest.approx(
            0.975
        )
    assert lower < mean < upper


@pytest.mark.parametrize("distribution", ["half zeros", "lognormal 0.5", "bounded"])
def test_interval_of_the_mean_of_correlated_values_follows_scaling_and_shift_and_ignores_reversal(distribution):
    values = simulate_correlated_positions(distribution, 1, 24, 0.4, np.random.default_rng(3))[0]
    expected = np.array(average_correlated_values(values))
    np.testing.assert_allclose(average_correlated_values(1e9 * values), 1e9 * expected, rtol=1e-9)
    np.testing.assert_allclose(average_correlated_values(values + 5), expected + 5, rtol=1e-9)
    np.testing.assert_allclose(average_correlated_values(values[::-1]), expected, rtol=1e-9)
    mean, lower, upper = average_correlated_values(-values)
    np.testing.assert_allclose([-mean, -upper, -lower], expected, rtol=1e-9)


def test_interval_of_the_mean_of_uncorrelated_neighbouring_values_is_a_student_t_interval():
    values = np.random.default_rng(8).normal(size=5000)
    half_width = 1.96 * values.std() / np.sqrt(values.size)
    _, lower, upper = average_correlated_values(values)
    assert upper - lower == pytest.approx(2 * half_width, rel=0.05)


def test_interval_of_the_mean_of_correlated_values_lies_within_the_range_of_the_values():
    random = np.random.default_rng(6)
    for distribution in ("half zeros", "bounded", "lognormal 1"):
        for values in simulate_correlated_positions(distribution, 50, MIN_NEIGHBOURING_POSITIONS, 0.6, random):
            mean, lower, upper = average_correlated_values(values)
            assert np.isnan(lower) or values.min() <= lower < mean < upper <= values.max()


def test_mean_of_too_few_or_identical_neighbouring_values_has_no_interval():
    assert np.isnan(average_correlated_values(np.arange(MIN_NEIGHBOURING_POSITIONS - 1.0))[1:]).all()
    mean, lower, upper = average_correlated_values(np.zeros(16))
    assert mean == 0
    assert np.isnan([lower, upper]).all()
    assert np.isnan(average_correlated_values(np.empty(0))).all()


# ---- average_independent_values --------------------------------------------------------------------------------------


def test_interval_of_a_sample_mean_contains_the_true_mean_in_95_percent_of_cases():
    generator = np.random.default_rng(11)
    mean, lower, upper = average_independent_values(5 + generator.normal(size=(8, 4000)))
    # The tolerance of the coverage is three standard errors of a fraction in 4000 trials.
    assert abs(float(((lower <= 5) & (upper >= 5)).mean()) - 0.95) < 3 * (0.95 * 0.05 / 4000) ** 0.5
    assert mean.mean() == pytest.approx(5, abs=0.05)


def test_interval_of_a_sample_mean_is_symmetric_if_values_have_both_signs():
    mean, lower, upper = average_independent_values(np.array([-1.0, 2.0, 3.0]))
    assert upper - mean == pytest.approx(mean - lower)
    assert lower < 0


@pytest.mark.parametrize("count", [4, 8, 16])
def test_interval_of_a_mean_of_exponential_samples_is_positive_and_contains_the_true_mean(count):
    mean, lower, upper = average_independent_values(np.random.default_rng(3).exponential(size=(count, 20_000)))
    assert (lower > 0).all()
    symmetric_upper = mean + (mean - lower)
    assert (upper > symmetric_upper).all()
    assert ((lower <= 1) & (upper >= 1)).mean() > 0.925


@pytest.mark.filterwarnings("ignore:All-NaN slice")
def test_sample_quantiles_equal_quantiles_from_numpy_with_and_without_missing_values():
    values = np.random.default_rng(7).standard_normal((37, 5, 6))
    probabilities = (0.0, 0.1, 0.5, 0.9, 1.0)
    np.testing.assert_array_equal(
        compute_sample_quantiles(values, probabilities), np.quantile(values, probabilities, axis=0)
    )
    values[values > 0.5] = np.nan
    values[:, 0, 0], values[1:, 1, 1] = np.nan, np.nan
    expected = np.nanquantile(values, probabilities, axis=0)
    np.testing.assert_array_equal(compute_sample_quantiles(values, probabilities), expected)


def test_sample_mean_ignores_missing_values():
    values = np.array([[1.0, 0.1, np.nan], [2.0, 0.0, 1.0], [3.0, 5.0, np.nan], [np.nan, 0.0, 2.0]])
    mean, lower, upper = average_independent_values(values)
    assert mean == pytest.approx([2.0, 1.275, 1.5])
    half_width = 4.302652730 / 3**0.5  # Student's t for 2 degrees of freedom
    assert (lower[0], upper[0]) == pytest.approx((2 * np.exp(-half_width / 2), 2 * np.exp(half_width / 2)))
    assert 0 < lower[1] < mean[1] < upper[1]
    assert np.isnan([lower[2], upper[2]]).all()


@pytest.mark.parametrize("lines", [1, 16])
def test_interval_of_the_mean_of_one_column_does_not_depend_on_other_columns(lines):
    values = np.exp(np.random.default_rng(0).normal(size=(64, 50)).cumsum(axis=0) * 0.3)
    lines_of_positions = np.arange(64) * lines // 64
    all_columns = np.stack(average_line_means(values, lines_of_positions))
    single_columns = [average_line_means(np.ascontiguousarray(column), lines_of_positions) for column in values.T]
    assert np.array_equal(all_columns, np.array(single_columns).T)


# Relative round-off of differences of logarithms whose arguments are ratios near 1.
JACKKNIFE_TOLERANCE = 1e-10


@pytest.mark.parametrize("repetitions", [3, 8, 60])
@pytest.mark.parametrize("dominates", [False, True])
def test_intervals_of_means_at_loads_agree_with_a_slow_jackknife(repetitions, dominates):
    random = np.random.default_rng(repetitions)
    steps, num_curves, load = np.arange(1.0, 13.0)[:, np.newaxis], 2, 4.3
    normal = steps * random.gamma(2.0, 0.5, (num_curves, 1, repetitions))
    values = np.sqrt(steps) * random.gamma(1.0, 1.0, (num_curves, 1, repetitions))
    if dominates:  # All repetitions but one are zero, so the interval is symmetric.
        values[..., 1:] = 0.0
    means = MeansAtLoads(normal.mean(axis=2), [values.mean(axis=2), normal.mean(axis=2)], repetitions, np.array([load]))
    for members in (slice(0, 2), slice(2, None)):
        means.add_repetitions(normal[..., members], [values[..., members], normal[..., members]])
    expected = [interval_at_load(normal[curve], values[curve], load) for curve in range(num_curves)]
    computed_intervals = np.stack([means.mean(0), *means.interval(0)], axis=-1)[:, 0]
    assert computed_intervals == pytest.approx(np.array(expected), rel=JACKKNIFE_TOLERANCE)
    assert np.stack([means.mean(1), *means.interval(1)]) == pytest.approx(load, rel=JACKKNIFE_TOLERANCE)


def test_mean_at_a_load_has_no_interval_if_only_one_repetition_carries_load():
    normal = np.zeros((1, 5, 4))
    normal[..., 2] = np.arange(1.0, 6.0)
    means = MeansAtLoads(normal.mean(axis=2), [normal.mean(axis=2)], 4, np.array([0.8]))
    means.add_repetitions(normal, [normal])
    assert means.mean(0) == pytest.approx(0.8)
    assert np.isnan(means.interval(0)).all()


def test_interval_of_a_mean_of_zero_is_zero_if_the_loads_differ_only_by_round_off():
    round_off = np.array([-1.0, 0.0, 1.0]) * np.finfo(float).eps
    normal = np.geomspace(0.01, 0.3, 5)[np.newaxis, :, np.newaxis] * (1 + round_off)
    values = np.where(normal > 0.05, normal, 0.0)
    means = MeansAtLoads(normal.mean(axis=2), [values.mean(axis=2)], 3, np.linspace(0.0101, 0.02, 50))
    means.add_repetitions(normal, [values])
    assert (means.mean(0) == 0).all()
    assert (np.stack(means.interval(0)) == 0).all()


def test_jackknife_sums_do_not_depend_on_the_memory_layout_of_curves():
    curves = np.random.default_rng(1).random((2, 3, 4))
    points = {"curve": np.array([1]), "step": np.array([2]), "slope": np.ones(1)}
    points |= {"fraction": np.array([0.5]), "load": curves[1, 1:].mean(keepdims=True).ravel(), "mean": np.ones(1)}
    expected, computed_sums = (
        _core.jackknife_sums(curves, np.asarray(curves, order=order), **points, total_repetitions=4) for order in "CF"
    )
    assert np.array_equal(computed_sums, expected)


def test_jackknife_sums_function_rejects_points_outside_the_curves_and_arrays_of_unequal_shape():
    curves, indices, numbers = np.ones((2, 3, 4)), np.array([1]), np.ones(1)
    points = {"curve": indices, "step": indices, **dict.fromkeys(("fraction", "load", "mean", "slope"), numbers)}
    for wrong_values, wrong_point in (
        (curves, {"step": np.array([3])}), (curves, {"curve": np.array([-1])}), (curves, {"mean": np.ones(2)}),
        (curves[:, :2], {}), (curves[0], {}),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=r"must"):
            _core.jackknife_sums(curves, wrong_values, **(points | wrong_point), total_repetitions=4)
