"""Several scans of each part: how members share them, how the variance is parted, and what the interval covers."""

from __future__ import annotations

import numpy as np
import pytest
from stiction import Profile, Study, Surface, open_result, pair, self_affine_surface
from stiction.studies.input_caveats import find_study_caveats
from stiction.studies.intervals import scans_mean, student_quantile
from stiction.studies.measured_surfaces import MeasuredFile
from stiction.studies.pair import Pair
from stiction.surfaces.measured.writing import write_surface
from stiction.views.sentence import note_text

QUICK = {"load": "2 MPa", "mu0": 0.2, "tau0": "50 MPa", "effective_modulus": "80 GPa", "direction": [0.0, 180.0]}
SEVERAL = [(3, 3), (3, 6), (4, 5), (6, 6)]  # scans of the upper and of the lower part
LEAST, MOST = 0.92, 0.98  # of 200 parts each
ROUND_OFF = 1e-12


def scan(seed: int, side: str, gradient: float = 1.0, points: int = 32) -> Surface:
    return self_affine_surface(
        seed, hurst_exponent=0.8, rms=0.01 * gradient, shape=(points, points), spacing=0.1, shortest_wavelength=0.5,
        side=side,
    )  # fmt: skip


def cells(upper: int, lower: int, times: int = 1):
    """Which scans members are of."""
    one, other = np.divmod(np.arange(upper * lower), lower)
    return np.tile(one, times), np.tile(other, times)


# ---- The estimator ---------------------------------------------------------------------------------------------------


def test_variances_equal_those_of_mean_squares() -> None:
    rng = np.random.default_rng(4)
    table = rng.standard_normal((4, 1)) * 3 + rng.standard_normal((1, 5)) * 2 + 0.3 * rng.standard_normal((4, 5))
    result = scans_mean(table.ravel(), *cells(4, 5))
    rows, columns = table.mean(axis=1), table.mean(axis=0)
    left = (table - rows[:, None] - columns + table.mean()).ravel()
    squares = 5 * rows.var(ddof=1), 4 * columns.var(ddof=1), left @ left / 12
    assert result.mean == pytest.approx(table.mean(), rel=ROUND_OFF)
    assert result.variances == pytest.approx(
        [(squares[0] - squares[2]) / 20, (squares[1] - squares[2]) / 20, squares[2] / 20]
    )
    total = squares[0] + squares[1] - squares[2]
    freedom = total**2 / (squares[0] ** 2 / 3 + squares[1] ** 2 / 4 + squares[2] ** 2 / 12)
    assert result.half_width == pytest.approx(float(student_quantile(freedom)) * np.sqrt(total / 20), rel=1e-9)


def test_scans_of_one_part_are_a_sample() -> None:
    values = np.array([1.0, 1.2, 0.9, 1.3])
    result = scans_mean(np.tile(values, 3), np.tile(np.arange(4), 3), np.zeros(12, int))
    half = float(student_quantile(3)) * values.std(ddof=1) / 2
    assert (result.mean, result.half_width) == pytest.approx((values.mean(), half))
    assert result.variances[1:] == (0.0, 0.0)
    assert scans_mean(np.ones(3), np.zeros(3, int), np.zeros(3, int)) is None


def test_member_without_solution_is_left_out() -> None:
    rng = np.random.default_rng(1)
    upper, lower = cells(3, 3, times=2)
    values = rng.standard_normal(18)
    values[4] = np.nan
    result = scans_mean(values, upper, lower)
    assert np.isfinite([result.mean, result.half_width, result.test]).all()


def coefficient(upper, lower):
    """mu_s of parts of these gradients: elastic adhesion, which falls as the gradient of the gap rises."""
    return 0.2 + 0.09 / np.sqrt((upper**2 + lower**2) / 2)


@pytest.mark.parametrize("spread", [0.0, 0.05, 0.2])
def test_interval_covers_the_mean_of_parts_and_the_next_test(spread) -> None:
    rng = np.random.default_rng(2016)

    def gradients(*shape):
        return np.exp(spread * rng.standard_normal(shape))

    truth = coefficient(gradients(200_000), gradients(200_000)).mean()
    covered, tested, times = [], [], 2
    for upper, lower in SEVERAL:
        for _ in range(200):
            one, other = cells(upper, lower, times)
            own = coefficient(gradients(upper)[one], gradients(lower)[other])
            result = scans_mean(own * (1 + 0.02 * rng.standard_normal(own.size)), one, other)
            covered.append(abs(result.mean - truth) <= result.half_width)
            test = float(coefficient(gradients(1), gradients(1))[0] * (1 + 0.02 * rng.standard_normal()))
            tested.append(abs(test - result.mean) <= float(student_quantile(result.test_freedom)) * result.test)
    by_counts = np.reshape(covered, (len(SEVERAL), -1)).mean(axis=1)
    print(f"spread {spread}: covers {np.mean(covered):.3f} {by_counts.round(3)}, next test {np.mean(tested):.3f}")
    assert LEAST <= np.mean(covered) <= MOST
    assert np.mean(tested) >= LEAST


# ---- Pairs of scans --------------------------------------------------------------------------------------------------


def test_pairs_of_scans_have_equal_member_counts() -> None:
    result = pair(
        [scan(i, "upper") for i in range(2)], [scan(i, "lower") for i in range(4)], onset=0, shifts=9, **QUICK
    )
    members = np.arange(result.study.ensemble.repetitions)
    assert members.size == 16
    upper, lower = result.study.surfaces.scans_of(members)
    assert np.bincount(4 * upper + lower).tolist() == [2] * 8
    assert np.bincount(upper[:4]).tolist() == [2, 2], "balanced from the first members on"
    assert open_result(result.path).interval == result.interval
    again = Study.from_toml(result.path / "study.toml")
    assert again.surfaces == result.study.surfaces


@pytest.mark.parametrize("spread", [0.0, 0.3])
def test_variability_between_places_is_in_interval_and_budget(spread) -> None:
    rng = np.random.default_rng(5)
    scans = [
        [scan(20 + i, side, np.exp(spread * rng.standard_normal())) for i in range(4)] for side in ("upper", "lower")
    ]
    arguments = {"mechanics": "asperities", "onset": 0, **QUICK}
    result = pair(*scans, shifts=32, **arguments)
    budget = result.budget.set_index("input")["share"]
    pieces = {"which piece of the upper part", "which piece of the lower part"} & set(budget.index)
    if spread:
        assert pieces
        assert budget[list(pieces)].sum() > 0.2
    assert "4 × 4 scans of both parts" in note_text(result.summary().first)
    one = pair(*(item[0] for item in scans), shifts=32, **arguments)
    assert "one scan of each part" in note_text(one.summary().first)
    assert np.ptp(result.interval) > (1.5 if spread else 0.0) * np.ptp(one.interval)
    low, high = result.next_test
    assert low <= result.interval[0] < result.interval[1] <= high


def test_scans_accept_list_directory_or_comma_separated_names(tmp_path) -> None:
    (tmp_path / "part").mkdir()
    names = []
    for index in range(2):
        names.append(str(tmp_path / "part" / f"a{index}.npy"))
        write_surface(scan(index, "upper"), names[-1])
    arguments = {"mechanics": "asperities", "onset": 0, "shifts": 4, **QUICK}
    other = scan(9, "lower")
    result = [pair(upper, other, **arguments) for upper in (names, ",".join(names), tmp_path / "part")]
    assert len({item.interval for item in result}) == 1
    table = (result[0].path / "study.toml").read_text()
    study = Study.from_toml(result[0].path / "study.toml")
    assert study.surfaces.upper.name == "a0.npy and 1 more"
    listed = study.with_changes({"surfaces.upper": [{"file": name} for name in names]})
    assert listed.surfaces.scan_counts == study.surfaces.scan_counts
    assert "others" in table


def test_pair_rejects_different_kinds_of_scans(tmp_path) -> None:
    arguments = {"mechanics": "asperities", "onset": 0, **QUICK}
    with pytest.raises(ValueError, match=r"surfaces.upper: the scans of a part must have the same points"):
        pair([scan(1, "upper"), scan(2, "upper", points=40)], scan(1, "lower"), **arguments)
    with pytest.raises(ValueError, match=r"surfaces.upper: two scans of a part are identical"):
        pair([scan(1, "upper"), scan(2, "upper"), scan(1, "upper")], scan(1, "lower"), **arguments)
    with pytest.raises(ValueError, match="second must have at least one scan"):
        pair(scan(1, "upper"), tmp_path, **arguments)
    with pytest.raises(ValueError, match=r"surfaces.surrogates: must be 0 if a part has several scans"):
        pair([scan(1, "upper"), scan(2, "upper")], scan(1, "lower"), surrogates=4, **arguments)


@pytest.mark.soak
@pytest.mark.parametrize("spread", [0.0, 0.2])
def test_solved_scans_cover_the_mean_of_their_parts(spread) -> None:
    rng = np.random.default_rng(7)
    arguments = {"mechanics": "asperities", "onset": 0, **QUICK}

    def scans_of(part: int, count: int):
        seeds = 1000 * part + np.arange(count)
        gradients = np.exp(spread * rng.standard_normal((2, count)))
        return [
            [scan(int(s), side, g) for s, g in zip(seeds, own, strict=True)]
            for side, own in zip(("upper", "lower"), gradients, strict=True)
        ]

    truth = pair(*scans_of(100, 24), shifts=576, **arguments).value  # all parts are of one kind
    result = [pair(*scans_of(part, 3 + part % 4), shifts=32, **arguments) for part in range(20)]
    covered = sum(item.interval[0] <= truth <= item.interval[1] for item in result)
    print(f"spread {spread}: {covered} of 20 cover {truth:.4f}")
    assert covered >= 17


def test_caveats_about_files_end_when_accepted(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    heights = np.cumsum(np.random.default_rng(1).normal(size=400)) * 0.01
    heights[[5, 77]] = -9999
    np.savetxt("codes.csv", np.c_[np.arange(400.0), heights], delimiter=",", header="x (um),z (um)")

    def of_files(**options):
        arguments = {"load": "1 mN", "mu0": "0.3", "effective_modulus": "10 GPa", "missing": "interpolate", **options}
        study = Pair.from_values(upper="codes.csv", lower="codes.csv", **arguments).study
        return [item for item in find_study_caveats(study) if "(repeated-extreme)" in item.cure]

    (caveat,) = of_files()
    assert (caveat.severity, caveat.text.partition(":")[0]) == ("caution", "both scans")
    assert "--missing-value -9999" in caveat.cure
    assert of_files(missing_value="-9999") == of_files(accept="repeated-extreme") == []
    (caveat,) = MeasuredFile.holding(Profile(heights, spacing=100.0), "upper").caveats
    assert caveat.name == "repeated-extreme"
