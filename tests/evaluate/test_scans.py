"""Test pairs with several scans of each part: members, variance components and coverage of intervals."""

from __future__ import annotations

import os

import numpy as np
import pytest
from stiction import Profile, Study, Surface, open_result, pair, self_affine, self_affine_surface
from stiction.evaluate.intervals import average_scan_pairs, student_quantile
from stiction.study.measured_bodies import MeasuredBodySettings
from stiction.study.pair_study import MeasuredPair
from stiction.summary.input_caveats import find_study_caveats
from stiction.surfaces.measured.writing import write_surface
from stiction.surfaces.scan_defects import estimate_roughness_drift
from stiction.views.sentence import result_point_note

pytestmark = pytest.mark.usefixtures("no_companion_files")

PAIR_OPTIONS = {"load": "2 MPa", "mu0": 0.2, "tau0": "50 MPa", "effective_modulus": "80 GPa", "direction": [0.0, 180.0]}
SCAN_COUNTS = [(3, 3), (3, 6), (4, 5), (6, 6)]
MIN_COVERAGE, MAX_COVERAGE = 0.92, 0.98
ROUND_OFF = 1e-12


def rough_scan(seed: int, side: str, gradient: float = 1.0, points: int = 32) -> Surface:
    return self_affine_surface(
        seed, hurst_exponent=0.8, rms=0.01 * gradient, shape=(points, points), spacing=0.1, shortest_wavelength=0.5,
        side=side,
    )  # fmt: skip


def list_expected_scan_indices(upper: int, lower: int, times: int = 1):
    """Return the indices of the upper and the lower scan of each member."""
    upper_scans, lower_scans = np.divmod(np.arange(upper * lower), lower)
    return np.tile(upper_scans, times), np.tile(lower_scans, times)


# ---- average_scan_pairs ----------------------------------------------------------------------------------------------


def test_variance_of_the_mean_over_scans_is_computed_from_mean_squares() -> None:
    rng = np.random.default_rng(4)
    table = rng.standard_normal((4, 1)) * 3 + rng.standard_normal((1, 5)) * 2 + 0.3 * rng.standard_normal((4, 5))
    result = average_scan_pairs(table.ravel(), *list_expected_scan_indices(4, 5))
    rows, columns = table.mean(axis=1), table.mean(axis=0)
    residuals = (table - rows[:, None] - columns + table.mean()).ravel()
    mean_squares = 5 * rows.var(ddof=1), 4 * columns.var(ddof=1), residuals @ residuals / 12
    assert result.mean == pytest.approx(table.mean(), rel=ROUND_OFF)
    assert result.variances == pytest.approx(
        [(mean_squares[0] - mean_squares[2]) / 20, (mean_squares[1] - mean_squares[2]) / 20, mean_squares[2] / 20]
    )
    total_variance = mean_squares[0] + mean_squares[1] - mean_squares[2]
    degrees_of_freedom = total_variance**2 / (
        mean_squares[0] ** 2 / 3 + mean_squares[1] ** 2 / 4 + mean_squares[2] ** 2 / 12
    )
    assert result.half_width == pytest.approx(
        float(student_quantile(degrees_of_freedom)) * np.sqrt(total_variance / 20), rel=1e-9
    )


def test_mean_over_scans_of_one_face_has_a_student_t_interval() -> None:
    values = np.array([1.0, 1.2, 0.9, 1.3])
    result = average_scan_pairs(np.tile(values, 3), np.tile(np.arange(4), 3), np.zeros(12, int))
    half_width = float(student_quantile(3)) * values.std(ddof=1) / 2
    assert (result.mean, result.half_width) == pytest.approx((values.mean(), half_width))
    assert result.variances[1:] == (0.0, 0.0)
    assert average_scan_pairs(np.ones(3), np.zeros(3, int), np.zeros(3, int)) is None


def test_mean_over_scans_omits_missing_values() -> None:
    rng = np.random.default_rng(1)
    upper, lower = list_expected_scan_indices(3, 3, times=2)
    values = rng.standard_normal(18)
    values[4] = np.nan
    result = average_scan_pairs(values, upper, lower)
    assert np.isfinite([result.mean, result.half_width, result.test]).all()


def simulate_coefficient(upper, lower):
    """Return mu_s of two parts with given rms gradients; adhesive friction decreases with the gradient of the gap."""
    return 0.2 + 0.09 / np.sqrt((upper**2 + lower**2) / 2)


@pytest.mark.parametrize("spread", [0.0, 0.05, 0.2])
def test_intervals_from_several_scans_contain_the_true_mean_and_a_single_friction_test(spread) -> None:
    rng = np.random.default_rng(2016)

    def random_gradients(*shape):
        return np.exp(spread * rng.standard_normal(shape))

    true_coefficient = simulate_coefficient(random_gradients(200_000), random_gradients(200_000)).mean()
    covered, covered_tests, times = [], [], 2
    for upper, lower in SCAN_COUNTS:
        for _ in range(200):
            upper_scans, lower_scans = list_expected_scan_indices(upper, lower, times)
            coefficients = simulate_coefficient(
                random_gradients(upper)[upper_scans], random_gradients(lower)[lower_scans]
            )
            result = average_scan_pairs(
                coefficients * (1 + 0.02 * rng.standard_normal(coefficients.size)), upper_scans, lower_scans
            )
            covered.append(abs(result.mean - true_coefficient) <= result.half_width)
            new_coefficient = float(
                simulate_coefficient(random_gradients(1), random_gradients(1))[0] * (1 + 0.02 * rng.standard_normal())
            )
            covered_tests.append(
                abs(new_coefficient - result.mean) <= float(student_quantile(result.test_freedom)) * result.test
            )
    coverage_by_counts = np.reshape(covered, (len(SCAN_COUNTS), -1)).mean(axis=1)
    print(
        f"spread {spread}: covers {np.mean(covered):.3f} {coverage_by_counts.round(3)}, "
        f"next test {np.mean(covered_tests):.3f}"
    )
    assert MIN_COVERAGE <= np.mean(covered) <= MAX_COVERAGE
    assert np.mean(covered_tests) >= MIN_COVERAGE


# ---- Pairs of scans --------------------------------------------------------------------------------------------------


def test_number_of_positions_is_the_same_for_each_combination_of_scans() -> None:
    result = pair(
        [rough_scan(i, "upper") for i in range(2)],
        [rough_scan(i, "lower") for i in range(4)],
        onset=0,
        shifts=9,
        **PAIR_OPTIONS,
    )
    members = np.arange(result.study.ensemble.repetitions)
    assert members.size == 16
    upper, lower = result.study.surfaces.scan_indices_of_members(members)
    assert np.bincount(4 * upper + lower).tolist() == [2] * 8
    assert np.bincount(upper[:4]).tolist() == [2, 2], "the first four members use each scan equally often"
    assert open_result(result.path).interval == result.interval
    stored_study = Study.from_toml(result.path / "study.toml")
    assert stored_study.surfaces == result.study.surfaces


@pytest.mark.parametrize("spread", [0.0, 0.3])
def test_variability_between_scans_widens_the_interval_and_has_a_row_in_the_budget(spread) -> None:
    rng = np.random.default_rng(5)
    scans = [
        [rough_scan(20 + i, side, np.exp(spread * rng.standard_normal())) for i in range(4)]
        for side in ("upper", "lower")
    ]
    arguments = {"mechanics": "asperities", "onset": 0, **PAIR_OPTIONS}
    result = pair(*scans, shifts=32, **arguments)
    budget = result.budget.set_index("input")["fraction"]
    scan_rows = {"which piece of the upper part", "which piece of the lower part"} & set(budget.index)
    if spread:
        assert scan_rows
        assert budget[list(scan_rows)].sum() > 0.2
    assert "4 × 4 scans of both parts" in result_point_note(result.summary().first)
    single_scan_result = pair(*(scans_of_part[0] for scans_of_part in scans), shifts=32, **arguments)
    assert "one scan of each part" in result_point_note(single_scan_result.summary().first)
    assert np.ptp(result.interval) > (1.5 if spread else 0.0) * np.ptp(single_scan_result.interval)
    lower, upper = result.prediction_interval
    assert lower <= result.interval[0] < result.interval[1] <= upper


def test_pair_function_accepts_scans_as_a_list_or_as_a_directory_or_as_file_names(tmp_path) -> None:
    (tmp_path / "part").mkdir()
    names = []
    for index in range(2):
        names.append(str(tmp_path / "part" / f"a{index}.npy"))
        write_surface(rough_scan(index, "upper"), names[-1])
    arguments = {"mechanics": "asperities", "onset": 0, "shifts": 4, **PAIR_OPTIONS}
    lower_scan = rough_scan(9, "lower")
    results = [pair(upper, lower_scan, **arguments) for upper in (names, ",".join(names), tmp_path / "part")]
    assert len({item.interval for item in results}) == 1
    study_text = (results[0].path / "study.toml").read_text()
    study = Study.from_toml(results[0].path / "study.toml")
    assert study.surfaces.upper.name == "a0.npy and 1 more"
    study_of_list = study.with_changes({"surfaces.upper": [{"file": name} for name in names]})
    assert study_of_list.surfaces.scan_counts == study.surfaces.scan_counts
    assert "others" in study_text


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="requires named pipes")
def test_pair_function_rejects_a_directory_of_scans_that_contains_a_pipe(tmp_path) -> None:
    (tmp_path / "part").mkdir()
    for index in range(2):
        write_surface(rough_scan(index, "upper"), tmp_path / "part" / f"a{index}.npy")
    os.mkfifo(tmp_path / "part/pipe.npy")  # a program that reads this pipe would block
    with pytest.raises(ValueError, match=r"pipe\.npy: is not a file"):
        pair(tmp_path / "part", rough_scan(9, "lower"), mechanics="asperities", onset=0, shifts=4, **PAIR_OPTIONS)


def test_pair_function_rejects_identical_scans_and_scans_with_different_grids(tmp_path) -> None:
    arguments = {"mechanics": "asperities", "onset": 0, **PAIR_OPTIONS}
    with pytest.raises(ValueError, match=r"surfaces.upper: the scans of a body must have the same number of points"):
        pair([rough_scan(1, "upper"), rough_scan(2, "upper", points=40)], rough_scan(1, "lower"), **arguments)
    with pytest.raises(ValueError, match=r"surfaces.upper: two scans of a body are identical"):
        pair(
            [rough_scan(1, "upper"), rough_scan(2, "upper"), rough_scan(1, "upper")],
            rough_scan(1, "lower"),
            **arguments,
        )
    with pytest.raises(ValueError, match="second must contain at least one scan"):
        pair(rough_scan(1, "upper"), tmp_path, **arguments)
    with pytest.raises(ValueError, match="second must not contain an empty file name"):
        pair(rough_scan(1, "upper"), " ", **arguments)
    with pytest.raises(ValueError, match=r"surfaces.surrogates: must be 0 if a body has several scans"):
        pair([rough_scan(1, "upper"), rough_scan(2, "upper")], rough_scan(1, "lower"), surrogates=4, **arguments)


@pytest.mark.soak
@pytest.mark.parametrize("spread", [0.0, 0.2])
def test_interval_from_few_scans_contains_the_mean_friction_over_many_scans(spread) -> None:
    rng = np.random.default_rng(7)
    arguments = {"mechanics": "asperities", "onset": 0, **PAIR_OPTIONS}

    def generate_scans(part: int, count: int):
        seeds = 1000 * part + np.arange(count)
        gradients = np.exp(spread * rng.standard_normal((2, count)))
        return [
            [rough_scan(int(s), side, g) for s, g in zip(seeds, gradients_of_part, strict=True)]
            for side, gradients_of_part in zip(("upper", "lower"), gradients, strict=True)
        ]

    true_result = pair(*generate_scans(100, 24), shifts=576, **arguments).value
    results = [pair(*generate_scans(part, 3 + part % 4), shifts=32, **arguments) for part in range(20)]
    covered = sum(item.interval[0] <= true_result <= item.interval[1] for item in results)
    print(f"spread {spread}: {covered} of 20 cover {true_result:.4f}")
    assert covered >= 17


def test_repeated_extreme_height_adds_a_caveat_unless_declared_valid_or_missing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    heights = np.cumsum(np.random.default_rng(1).normal(size=400)) * 0.01
    heights[[5, 77]] = -9999
    np.savetxt("codes.csv", np.c_[np.arange(400.0), heights], delimiter=",", header="x (um),z (um)")

    def find_caveats_about_repeated_extremes(**options):
        arguments = {"load": "1 mN", "mu0": "0.3", "effective_modulus": "10 GPa", "missing": "interpolate", **options}
        study = MeasuredPair.from_values(upper="codes.csv", lower="codes.csv", **arguments).study
        return [item for item in find_study_caveats(study) if "(repeated-extreme)" in item.remedy]

    (caveat,) = find_caveats_about_repeated_extremes()
    assert (caveat.severity, caveat.text.partition(":")[0]) == ("caution", "both scans")
    assert "--missing-value -9999" in caveat.remedy
    assert (
        find_caveats_about_repeated_extremes(missing_value="-9999")
        == find_caveats_about_repeated_extremes(accept="repeated-extreme")
        == []
    )
    (caveat,) = MeasuredBodySettings.from_body(Profile(heights, spacing=100.0), "upper").caveats
    assert caveat.name == "repeated-extreme"


# ---- Drift of the roughness along a single scan ----------------------------------------------------------------------


def build_map(seed, *, drift=0.0, points=96):
    """Return a map that is cut from a stationary surface, whose logarithmic slope then changes by `drift` along x."""
    stationary = self_affine_surface(
        seed, hurst_exponent=0.8, rms=0.03, shape=(2 * points, 2 * points), spacing=0.2, longest_wavelength=4.0
    )
    factor = np.exp(drift * np.linspace(-0.5, 0.5, points))
    return Surface(stationary.heights[:points, :points] * factor, spacing=0.2)


DRIFT_OPTIONS = {"load": "60 MPa", "effective_modulus": 80.0, "mu0": 0.2, "tau0": "400 MPa", "shifts": 4, "onset": 0}
DRIFT_CAVEAT = "from one end of the scan to the other"


def test_roughness_drift_of_a_single_scan_widens_the_interval_and_appears_in_budget_and_caveat():
    result = pair(build_map(1, drift=0.8), build_map(2), **DRIFT_OPTIONS)
    lower, upper = result.interval
    assert lower < result.interval_of_mean[0] < result.interval_of_mean[1] < upper
    budget = result.budget.set_index("input")
    assert budget.index[0] == "which piece of the upper part"
    assert "which piece of the lower part" not in budget.index
    assert budget.loc["which piece of the upper part", ["lower", "upper"]].tolist() == pytest.approx(
        list(result.interval_of_mean), rel=0.01
    )
    caveats = [caveat for caveat in result.caveats if DRIFT_CAVEAT in caveat.text]
    assert [caveat.severity for caveat in caveats] == ["caution"]
    assert caveats[0].text.startswith("upper: ")
    assert result.prediction_interval[0] < lower < upper < result.prediction_interval[1]


def test_roughness_drift_of_plastic_contacts_or_several_scans_has_no_caveat():
    plastic_result = pair(
        build_map(1, drift=0.8), build_map(2), **DRIFT_OPTIONS | {"tau0": "50 MPa", "hardness": "0.3 GPa"}
    )  # fmt: skip
    assert not any(DRIFT_CAVEAT in caveat.text for caveat in plastic_result.caveats)
    upper_scans = [build_map(seed, drift=0.8) for seed in (1, 3, 4)]
    result_of_several_scans = pair(upper_scans, build_map(2), **DRIFT_OPTIONS)
    assert not any(DRIFT_CAVEAT in caveat.text for caveat in result_of_several_scans.caveats)


@pytest.mark.parametrize("masked", [False, True])
def test_estimated_drift_of_friction_is_proportional_to_the_drift_of_the_roughness(masked):
    def estimate_drifts(build_body, drift, count):
        return np.array([estimate_roughness_drift(build_body(seed, drift)) for seed in range(count)])

    def build_profile(seed, drift):
        heights = self_affine(
            seed, hurst_exponent=0.8, rms=0.1, points=4000, spacing=0.5, longest_wavelength=100.0
        ).heights[:2000]  # fmt: skip
        missing = np.arange(2000) % 97 < 9 if masked else None
        return Profile(heights * np.exp(drift * np.linspace(-0.5, 0.5, 2000)), spacing=0.5, missing=missing)

    def build_masked_map(seed, drift):
        surface = build_map(seed, drift=drift)
        missing = np.zeros(surface.heights.shape, bool)
        missing[10:30, 40:60] = masked
        return Surface(surface.heights, spacing=0.2, missing=missing if masked else None)

    for build_body in (build_profile, build_masked_map):
        assert (estimate_drifts(build_body, 0.0, 30) > 0).sum() <= 2
        assert estimate_drifts(build_body, 0.8, 6) == pytest.approx(0.8, abs=0.3)
