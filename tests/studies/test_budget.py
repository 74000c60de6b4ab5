"""The whole uncertainty: limits that are known by heart, direct solutions over hardness and E*, and coverage."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray
from scipy.stats import halfnorm
from stiction import Study, Surface, cut_off, pair, self_affine_surface
from stiction.mechanics.friction import STATUS_OK
from stiction.studies import budget, hardness
from stiction.studies.budget import _CoefficientSamples, _numbers_at, add_uncertainty
from stiction.studies.evaluation import PerLoad, areas_of, at_load, member_sums
from stiction.studies.executors import thread_executor
from stiction.studies.hardness import choose_area_nodes, compute_areas_over_hardness, find_inputs
from stiction.studies.input_uncertainty import Z_95, parse_input
from stiction.studies.pair import pair_study
from stiction.studies.summary import summarize
from stiction.studies.values import StudyError
from support.rough_surfaces import rough_maps

SIDES = ("upper", "lower")
BY_DRAWS = 0.02  # largest difference of an end of an interval by draws from the exact one, over its width
BETWEEN, WIDE = 0.005, 0.008  # largest relative errors of friction between solutions; of a wide range on small maps
QUICK = {"shifts": 4, "direction": [0.0, 180.0], "onset": 0}
FEWER = QUICK | {"shifts": 3}  # where one solution is held to another at the same positions


def bodies(seed: int = 5, rms: float = 0.01, points: int = 64, finer: int = 1) -> list[Surface]:
    return rough_maps(
        seed, hurst_exponent=0.7, rms=rms, points=points * finer, spacing=0.05 / finer, shortest_wavelength=0.3 / finer
    )


def of(result, name="friction_known", rule="all"):
    return result.at_study_loads[name].sel(sliding=rule).squeeze().values


def test_interval_of_exact_inputs_is_the_sampling_interval() -> None:
    result = pair(*bodies(), load="2 MPa", mu0=0.2, tau0="50 MPa", effective_modulus="80 GPa", **QUICK)
    assert result.interval == pytest.approx(result.of_positions, rel=1e-9)
    assert result.budget["input"].tolist() == ["positions"]
    low, high = result.next_test
    assert low < result.of_positions[0] < result.of_positions[1] < high


def test_interval_at_a_load_is_independent_of_other_loads() -> None:
    result = pair(
        *bodies(), load=["2 MPa", "4 MPa"], mu0=0.2, tau0="50 MPa", effective_modulus="80 GPa",
        hardness="0.5..1.5 GPa", mechanics="half-space", **QUICK,
    )  # fmt: skip
    own = result.at_study_loads["load"].values.tolist()
    at = add_uncertainty(at_load(result.source, [*own, 1.5 * own[0]]), result.source, budget=False)
    assert at["load"].values.tolist() == sorted([*own, 1.5 * own[0]])
    for name in ("friction_combined", "friction_known", "friction_next_test"):
        assert at[name].dims == result.at_study_loads[name].dims
        np.testing.assert_array_equal(at[name].sel(load=own), result.at_study_loads[name])


def test_range_of_mu0_gives_equal_range_of_friction() -> None:
    kwargs = dict(load="2 MPa", tau0=0.0, effective_modulus="80 GPa", **QUICK)
    result = pair(*bodies(rms=0.001), mu0="0.2±0.02", **kwargs)
    assert result.interval == pytest.approx((0.2 - Z_95 * 0.02, 0.2 + Z_95 * 0.02), abs=BY_DRAWS * 4 * 0.02)
    assert result.budget["input"][0] == "μ0"
    uniform = pair(*bodies(rms=0.001), mu0="uniform 0.1..0.3", **kwargs)
    assert uniform.interval == pytest.approx((0.105, 0.295), abs=BY_DRAWS * 0.2)
    assert uniform.value == pytest.approx(0.2, rel=1e-3)


def test_range_of_tau0_scales_the_adhesive_part() -> None:
    result = pair(
        *bodies(rms=0.001), load="2 MPa", mu0=0.2, tau0="20..80 MPa", effective_modulus="80 GPa", **QUICK
    )  # fmt: skip
    _, adhesion, _ = result.summary().points[0].parts
    one_position = result.budget.set_index("input").loc["positions"]
    assert (one_position.lower, one_position.upper) == pytest.approx(
        (0.2 + adhesion / 2, 0.2 + 2 * adhesion), rel=BY_DRAWS
    )


def test_replaced_result_is_solved_over_hardness_again(tmp_path) -> None:
    kwargs = dict(load="20 MPa", mu0=0.2, tau0="50 MPa", hardness="1..3 GPa", **FEWER)
    pair(*bodies(), effective_modulus="80 GPa", directory=tmp_path, **kwargs)
    softer = pair(*bodies(), effective_modulus="20 GPa", directory=tmp_path, replace=True, **kwargs)
    assert softer.interval == pair(*bodies(), effective_modulus="20 GPa", **kwargs).interval


# Plastic, between elastic and plastic, and a range of E* that needs solutions at other loads.
@pytest.mark.parametrize(("rms", "modulus"), [(0.03, "70..90 GPa"), (0.003, "70..90 GPa"), (0.003, "48..112 GPa")])
def test_interval_over_hardness_and_modulus_agrees_with_direct_solutions(rms, modulus) -> None:
    kwargs = dict(load="20 MPa", mu0=0.2, tau0="50 MPa", **FEWER)
    result = pair(*bodies(rms=rms), hardness="0.3..1.5 GPa", effective_modulus=modulus, **kwargs)
    inputs = find_inputs(result.study)
    assert sorted(inputs) == ["effective_modulus", "hardness"]
    assert choose_area_nodes(result.study)[1].size == (3 if modulus.startswith("48") else 1)
    at = result.at_study_loads
    where = dict.fromkeys(("cut_off", "sliding", "load", "mu0", "tau0"), 0)
    six, areas = member_sums(result.source, at["load"].values), areas_of(at, result.source)
    friction = PerLoad.of(six.sel(sliding="all").mean())
    one = _CoefficientSamples(_numbers_at(at, where), where, result.study, inputs, friction, areas)
    one.names, one.places = tuple(inputs), {}  # the scan as it is, at these positions
    for part in (0.03, 0.7):
        hardness = float(inputs["hardness"].estimate.quantile(part))
        stiffness = float(inputs["effective_modulus"].estimate.quantile(part))
        direct = pair(*bodies(rms=rms), hardness=hardness, effective_modulus=stiffness, **kwargs)
        computed = one._friction_samples({"hardness": part, "effective_modulus": part})
        assert computed[0] == pytest.approx(direct.value, rel=WIDE if modulus.startswith("48") else BETWEEN)


def test_large_maps_solve_two_members_over_hardness(monkeypatch) -> None:
    options = {"mu0": 0.2, "tau0": "50 MPa", "effective_modulus": "80 GPa", "hardness": "1..3 GPa", "shifts": 4}
    study = pair_study(*bodies(), load="2 MPa", mechanics="half-space", direction=[0.0, 180.0], **options)
    with thread_executor(1) as executor:
        many = compute_areas_over_hardness(study, executor)
        monkeypatch.setattr(hardness, "MIN_LARGE_MAP_POINTS", 1)
        few = compute_areas_over_hardness(study, executor)
    assert (many.sizes["repetition"], few.sizes["repetition"]) == (4, 2)
    np.testing.assert_array_equal(few["contact_area"], many["contact_area"][:2])


@pytest.mark.parametrize("rms", [0.03, 0.003])  # plastic, and between elastic and plastic
def test_dwell_time_equals_reduced_hardness(rms) -> None:
    kwargs = dict(load="20 MPa", mu0=0.2, tau0="50 MPa", effective_modulus="80 GPa", **QUICK)
    waited = (
        pair(*bodies(rms=rms), hardness="0.8 GPa", wait=["1 s", "1 h", "10 d"], creep=0.04, **kwargs)
        .summary()
        .points[0]
    )
    assert [item.seconds for item in waited.waited] == [1, 3600, 864000]
    assert waited.waited[0].value == pytest.approx(waited.value, rel=1e-9)
    for item in waited.waited[1:]:
        softer = pair(*bodies(rms=rms), hardness=0.8 * item.seconds**-0.04, **kwargs)
        assert item.value == pytest.approx(softer.value, rel=BETWEEN)
        assert item.lower < item.value < item.upper
    if rms == 0.03:  # all contacts yield: m tau0/H, times what the logarithm is short of the power
        grown = 0.05 / 0.8 * (864000**0.04 - 1) / np.log(864000)
        assert waited.ageing == pytest.approx(grown, rel=0.02)


def test_range_of_creep_exponent_widens_aged_values_only() -> None:
    kwargs = dict(load="20 MPa", mu0=0.2, tau0="50 MPa", effective_modulus="80 GPa", hardness="0.8 GPa", **QUICK)
    exact, wide = (
        pair(*bodies(rms=0.03), wait="1 d", creep=m, **kwargs).summary().points[0] for m in ("0.03", "0.02..0.04")
    )
    assert exact.waited[0].value == pytest.approx(wide.waited[0].value, rel=1e-3)  # other nodes
    assert (exact.lower, exact.upper) == pytest.approx((wide.lower, wide.upper), rel=1e-9)
    low, high = (0.2 + 0.05 / 0.8 * 86400**m for m in (0.02, 0.04))
    assert wide.waited[0].upper - wide.waited[0].lower > 0.9 * (high - low)
    assert exact.waited[0].upper - exact.waited[0].lower < 0.3 * (high - low)


def test_named_materials_have_ranges_and_given_hardness_is_exact() -> None:
    kwargs = dict(load="2 MPa", mu0=0.2, tau0="50 MPa", upper="steel", lower="brass", junction_growth=0, **QUICK)
    named = pair(*bodies(rms=0.02), **kwargs)
    assert named.budget["input"][0] == "the hardness of the brass"
    assert named.budget["share"][0] > 0.5
    measured = pair(*bodies(rms=0.02), hardness=named.study.contact.hardness.text, **kwargs)
    assert measured.value == named.value
    assert np.ptp(measured.interval) < 0.5 * np.ptp(named.interval)
    lower, upper = named.budget.loc[0, ["lower", "upper"]]
    assert measured.interval == pytest.approx((lower, upper), abs=BY_DRAWS * np.ptp(named.interval))


def test_elastic_pair_over_modulus_agrees_with_direct_solutions() -> None:
    kwargs = dict(load="0.2 MPa", mu0=0.2, tau0="50 kPa", **QUICK)
    result = pair(*bodies(rms=0.01), effective_modulus="1.5..6 MPa", **kwargs)
    at, study = result.at_study_loads, result.study
    areas = areas_of(at, result.source)

    def area(found):
        return found.at_study_loads["contact_area"].sel(statistic="mean").item()

    for ratio in (0.6, 1.5):
        softer = pair(*bodies(rms=0.01), effective_modulus=float(study.contact.effective_modulus) * ratio, **kwargs)
        assert area(softer) / area(result) == pytest.approx(areas.area_ratio(0, None, ratio).item(), rel=BETWEEN)


def test_gap_has_the_interval_of_its_inputs_and_a_caveat() -> None:
    upper, lower = bodies(rms=0.03, points=128)
    common = {
        "load": "50 MPa", "mu0": 0.2, "tau0": "50 MPa", "effective_modulus": "80 GPa", "work_of_adhesion": 0,
        "onset": 0,
    }  # fmt: skip
    gap = Surface(lower.heights - upper.heights, spacing=0.05)
    known, exact = pair(gap=gap, hardness="0.5..1.5 GPa", **common), pair(gap=gap, **common)
    assert known.interval[0] < known.value < known.interval[1]
    assert "positions" not in known.budget["input"].tolist()
    assert np.isnan(known.of_positions).all()
    assert np.isnan(exact.interval).all()
    for result in (known, exact):
        assert any("a gap has one position" in caveat.text for caveat in result.caveats)
        assert not any("members that differ" in caveat.cure for caveat in result.caveats)


def test_material_name_combines_with_numbers_of_the_other_surface() -> None:
    def contact(**materials):
        return pair_study(*bodies(), load="50 kPa", mu0=0.2, tau0="0.2 MPa", **materials).contact

    rubber = contact(lower_material="glass", young="3 MPa", poisson=0.49)
    assert rubber.hardness is None
    both = contact(young="3 MPa,69.5 GPa", poisson="0.49,0.2")
    assert float(rubber.effective_modulus) == pytest.approx(float(both.effective_modulus))
    steel = contact(upper_material="brass", young="210 GPa", poisson=0.3)
    assert float(steel.hardness) == pytest.approx(0.625)
    with pytest.raises(ValueError, match="young and poisson must be one value each, of the body without a material"):
        contact(lower_material="glass", young="3 MPa,70 GPa", poisson=0.49)


def test_hardness_accepts_vickers_and_rockwell() -> None:
    assert parse_input("hardness", "150 HV", "hardness").value == pytest.approx(150 * 9.80665e-3 / 0.9272)
    rockwell = parse_input("hardness", "60 HRC", "hardness")
    assert rockwell.value == pytest.approx(697 * 9.80665e-3 / 0.9272)
    assert rockwell.low < rockwell.value < rockwell.high
    assert parse_input("hardness", "58..62 HRC", "hardness").distribution == "log-normal"
    with pytest.raises(ValueError, match="from 20 to 68 HRC"):
        parse_input("hardness", "12 HRC", "hardness")
    study = pair_study(*bodies(), load="2 MPa", mu0=0.2, effective_modulus="80 GPa", hardness="150±15 HV")
    assert float(study.contact.hardness) == pytest.approx(1.586, rel=1e-3)
    assert study.known.hardness == "150±15 HV"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"mu0": "0.3..0.2"}, "mu0 must be a range from a smaller"),
        ({"mu0": "0.2±0.02,0.3"}, "mu0 must be one value"),
        ({"hardness": "3 HB"}, "hardness .*unit"),
        ({"effective_modulus": "3±5 GPa"}, "effective_modulus must be at least twice its standard uncertainty"),
        ({"hardness": "1 GPa", "wait": "1 h", "creep": 5}, "creep must be at most 0.5"),
    ],
)
def test_pair_rejects_bad_ranges(options, words) -> None:
    with pytest.raises(ValueError, match=words):
        pair(*bodies(), **{"load": "2 MPa", "mu0": 0.2, "effective_modulus": "80 GPa", **QUICK, **options})


def test_study_stores_uncertain_inputs() -> None:
    result = pair(*bodies(), load="2 MPa", mu0="0.1..0.3", effective_modulus="80 GPa", **QUICK)
    again = Study.from_toml(result.path / "study.toml")
    assert find_inputs(again)["mu0"].estimate == parse_input("mu0", "0.1..0.3")
    with pytest.raises(StudyError, match=r"known.tau0.*unit"):
        again.with_changes({"known.tau0": "20..80"})


CASES = [pytest.param(2, id="some"), pytest.param(300, marks=pytest.mark.soak, id="all")]
LEAST = 0.92  # of 300 truths the interval covers so many at least; of a few, most


@pytest.mark.parametrize("truths", CASES)
def test_interval_covers_the_truth_of_random_inputs(truths) -> None:
    ranges = {"mu0": "0.15..0.25", "tau0": "20..80 MPa", "hardness": "0.5..1.5 GPa", "effective_modulus": "70..90 GPa"}
    covered = tested = 0
    rng = np.random.default_rng(2016)
    for seed in range(truths):
        # The truth has waves of half and of a quarter of the shortest one of the scans, or no others.
        finer = int(rng.choice([1, 2, 4]))
        whole = bodies(seed, rms=float(rng.choice([0.003, 0.01, 0.03])), points=48, finer=finer)
        recorded = [cut_off(item, 0.3, periodic=True) if finer > 1 else item for item in whole]
        scans = [Surface(item.heights[::finer, ::finer], spacing=0.05) for item in recorded]
        common = dict(load="4 MPa", **QUICK)
        message = pair(*scans, **ranges, **common)
        inputs = find_inputs(message.study)
        drawn = {name: float(inputs[name].estimate.quantile(rng.random())) for name in ranges}
        truth = pair(*whole, **drawn, **(common | {"shifts": 40}))
        covered += message.interval[0] <= truth.value <= message.interval[1]
        one = one_test(truth, rng)
        tested += message.next_test[0] <= one <= message.next_test[1]
    if truths < 100:
        assert min(covered, tested) >= truths - 1
        return
    print(f"covers {covered / truths:.3f}, next test {tested / truths:.3f}")
    assert covered / truths >= LEAST
    assert tested / truths >= LEAST


def one_test(truth, rng) -> float:
    """The coefficient of one member in one direction, of which the result has many."""
    from stiction.studies.evaluation import member_values

    members = member_values(truth.source, truth.at_study_loads["load"].values).sel(sliding="all").squeeze()
    assert (members["status"] == STATUS_OK).all()
    return float(rng.choice(members["friction_coefficient"].values.ravel()))


@pytest.mark.parametrize("tau0", ["0±50 MPa", "5±50 MPa", "20±200 MPa"])
def test_interval_contains_value_outside_truncated_distribution(tau0: str) -> None:
    result = pair(*bodies(), load="2 MPa", mu0=0.2, tau0=tau0, hardness="3 GPa", effective_modulus="80 GPa", **QUICK)
    assert result.interval[0] <= result.value <= result.interval[1]


def test_intervals_are_nested_and_positive(monkeypatch) -> None:
    monkeypatch.setattr(budget, "MAX_BUDGETS", 0)  # which take most of the time
    # Random statistics, of which the bracket and the sampling interval may be wider than the interval by samples.
    random = np.random.default_rng(5)
    result = pair(
        *bodies(), load="2 MPa", mu0=0.2, tau0="20..80 MPa", hardness="1 GPa", effective_modulus="80 GPa", **QUICK
    )
    at = result.at_study_loads
    for _ in range(300):
        value, scatter, half = random.uniform(0.21, 1.0), random.uniform(0.001, 1.5), random.uniform(0.001, 0.6)
        ends = value * np.array([1.0, 1 - half, 1 + half * random.uniform(0.5, 2)])
        point = at.assign(
            friction_all_round=at["friction_all_round"] * 0 + xarray.DataArray(ends, dims="statistic"),
            contact_count=at["contact_count"] * 0 + random.uniform(0.2, 30),
            spread_low=at["spread_low"] * 0 + value * (1 - scatter / 2),
            spread_high=at["spread_high"] * 0 + value * (1 + scatter),
        )
        (computed,) = summarize(add_uncertainty(point, result.source), result.study).points
        rule = computed.rules[0]
        assert rule.rule == "all"
        assert 0 < rule.lower <= rule.positions[0] <= rule.value <= rule.positions[1] <= rule.upper
        assert 0 < rule.next_test[0] <= rule.value <= rule.next_test[1]
        if computed.bracket is not None:
            assert rule.lower <= computed.bracket[0] <= computed.bracket[1] <= rule.upper


def test_equal_inputs_have_equal_fractions_of_the_budget() -> None:
    result = pair(
        *bodies(), load="2 MPa", mu0="0.2±0.025", tau0="20..80 MPa", young="6..16 GPa,6..16 GPa", poisson="0.3,0.3",
        hardness="1 GPa", **QUICK,
    )  # fmt: skip
    shares = result.budget.set_index("input")["share"]
    upper, lower = (shares[f"Young's modulus of the {side} body"] for side in ("upper", "lower"))
    assert upper == pytest.approx(lower, abs=0.01)
    assert shares.min() >= 0


def test_interval_of_a_coefficient_of_zero_has_the_range_of_mu0() -> None:
    options = {"load": "20 MPa", "effective_modulus": "80 GPa", "cutoff": "none"} | QUICK | {"shifts": 8}
    low, high = pair(*bodies(points=24), mu0="0±0.1", **options).interval
    assert low == 0
    assert high == pytest.approx(0.1 * halfnorm.ppf(0.975), rel=0.02)
    assert pair(*bodies(points=24), mu0=0.0, **options).interval[1] < budget.NEGLIGIBLE


CONTAINMENT_INPUTS = (
    {"mu0": "0.2±0.05", "tau0": "20..80 MPa", "effective_modulus": "40..60 GPa"},
    {"mu0": 0.2, "tau0": "50 MPa", "effective_modulus": "50 GPa", "hardness": "1..3 GPa"},
    {"mu0": "0.2±0.05", "tau0": "20..80 MPa", "effective_modulus": "50 GPa", "hardness": "2 GPa"},
)


@pytest.mark.parametrize("inputs", CONTAINMENT_INPUTS)
@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_combined_interval_contains_sampling_interval_and_bracket(inputs: dict[str, Any], noise: float) -> None:
    """The value lies between a hundredth and 99 hundredths of the interval, with wavelengths removed or not."""
    random = np.random.default_rng(7)
    rough = {"hurst_exponent": 0.7, "rms": 0.01, "shape": (48, 48), "spacing": 0.1, "shortest_wavelength": 0.5}
    heights = [self_affine_surface(5, side=side, **rough).heights for side in ("upper", "lower")]
    bodies = [Surface(z + noise * z.std() * random.standard_normal(z.shape), spacing=0.1) for z in heights]
    result = pair(*bodies, load="200 MPa", shifts=4, onset=0, direction=[0, 90], **inputs)
    points = [one for one in result.summary().points if not one.covered]
    assert points
    for one in points:
        for rule in one.rules:
            width = rule.upper - rule.lower
            assert rule.lower + 0.01 * width < rule.value < rule.upper - 0.01 * width
            assert rule.lower <= rule.positions[0] < rule.positions[1] <= rule.upper
        if "hardness" in inputs and one.bracket is not None:
            assert one.rules[0].lower <= one.bracket[0] <= one.bracket[1] <= one.rules[0].upper
