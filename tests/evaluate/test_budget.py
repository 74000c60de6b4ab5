"""Test the combined uncertainty against simple limits, direct solutions over hardness and E*, and true values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray
from scipy.stats import halfnorm
from stiction import Study, Surface, cut_off, pair, self_affine_surface
from stiction.evaluate import budget
from stiction.evaluate.at_load import at_load
from stiction.evaluate.budget import _iterate_intervals, add_uncertainty
from stiction.evaluate.combined_intervals import compute_equal_tailed_interval
from stiction.mechanics.friction import STATUS_OK
from stiction.study.input_distributions import Z_95, parse_uncertain_input
from stiction.study.inputs import Inputs
from stiction.study.values import StudyError
from stiction.summary.summary import summarize
from stiction.views.rows import point_record
from stiction.views.sentence import dwell_time_text
from support.rough_surfaces import rough_maps
from support.studies_of_files import pair_study

pytestmark = pytest.mark.usefixtures("no_companion_files")

SIDES = ("upper", "lower")
# Largest error of an interval limit due to random samples, as a fraction of the interval width.
MAX_SAMPLING_ERROR = 0.02
MAX_INTERPOLATION_ERROR, MAX_INTERPOLATION_ERROR_OF_WIDE_INPUTS = 0.005, 0.008
PAIR_OPTIONS = {"shifts": 4, "direction": [0.0, 180.0], "onset": 0}
THREE_POSITION_OPTIONS = PAIR_OPTIONS | {"shifts": 3}


LARGE_MAP_POINTS = 64


def rough_surfaces(seed: int = 5, rms: float = 0.01, points: int = 48, refinement: int = 1) -> list[Surface]:
    return rough_maps(
        seed,
        hurst_exponent=0.7,
        rms=rms,
        points=points * refinement,
        spacing=0.05 / refinement,
        shortest_wavelength=0.3 / refinement,
    )


def test_combined_interval_for_exact_inputs_equals_the_interval_of_the_mean() -> None:
    result = pair(*rough_surfaces(), load="2 MPa", mu0=0.2, tau0="50 MPa", effective_modulus="80 GPa", **PAIR_OPTIONS)
    assert result.interval == pytest.approx(result.interval_of_mean, rel=1e-9)
    assert result.budget["input"].tolist() == ["positions"]
    lower, upper = result.prediction_interval
    assert lower < result.interval_of_mean[0] < result.interval_of_mean[1] < upper


def test_combined_interval_at_a_load_does_not_depend_on_other_requested_loads() -> None:
    result = pair(
        *rough_surfaces(), load=["2 MPa", "4 MPa"], mu0=0.2, tau0="50 MPa", effective_modulus="80 GPa",
        hardness="0.5..1.5 GPa", mechanics="half-space", **PAIR_OPTIONS,
    )  # fmt: skip
    study_loads = result.at_study_loads["load"].values.tolist()
    table = add_uncertainty(at_load(result.source, [*study_loads, 1.5 * study_loads[0]]), result.source, budget=False)
    assert table["load"].values.tolist() == sorted([*study_loads, 1.5 * study_loads[0]])
    for name in ("friction_combined", "friction_at_cutoff", "friction_prediction"):
        assert table[name].dims == result.at_study_loads[name].dims
        np.testing.assert_array_equal(table[name].sel(load=study_loads), result.at_study_loads[name])


@pytest.mark.parametrize("hardness", [None, "2 GPa ± 10 %"])
def test_uncertainty_budget_at_a_load_is_independent_of_the_number_of_other_loads(monkeypatch, hardness) -> None:
    options = PAIR_OPTIONS | {"hardness": hardness, "mu0": "0.2..0.3", "tau0": "50 MPa"}
    result = pair(*rough_surfaces(), load="2 MPa", effective_modulus="80 GPa", **options)
    study_load = float(result.study.friction.load[0])
    friction = result.at_study_loads["mean_friction"]
    monkeypatch.setattr(budget, "MAX_BUDGETED_COEFFICIENTS", friction.size // friction.sizes["statistic"])
    other_loads = [factor * study_load for factor in (1.1, 1.2, 1.3)]
    all_loads = [study_load, *other_loads]
    table_of_all = result.at(all_loads, budget=True)
    assert (table_of_all["remaining_width"].sel(input="mu0", sliding="all") > 0).all()
    for load in all_loads:
        for name in ("remaining_interval", "remaining_width"):
            expected = result.at(load, budget=True)[name].sel(load=load)
            np.testing.assert_allclose(table_of_all[name].sel(load=load), expected, rtol=1e-12)


def test_friction_interval_equals_the_interval_of_mu0_if_only_mu0_is_uncertain() -> None:
    kwargs = dict(load="2 MPa", tau0=0.0, effective_modulus="80 GPa", **PAIR_OPTIONS)
    result = pair(*rough_surfaces(rms=0.001), mu0="0.2±0.02", **kwargs)
    assert result.interval == pytest.approx((0.2 - Z_95 * 0.02, 0.2 + Z_95 * 0.02), abs=MAX_SAMPLING_ERROR * 4 * 0.02)
    assert result.budget["input"][0] == "μ0"
    uniform_result = pair(*rough_surfaces(rms=0.001), mu0="uniform 0.1..0.3", **kwargs)
    assert uniform_result.interval == pytest.approx((0.105, 0.295), abs=MAX_SAMPLING_ERROR * 0.2)
    assert uniform_result.value == pytest.approx(0.2, rel=1e-3)


def test_limits_of_the_adhesive_friction_interval_are_proportional_to_the_limits_of_tau0() -> None:
    result = pair(
        *rough_surfaces(rms=0.001), load="2 MPa", mu0=0.2, tau0="20..80 MPa", effective_modulus="80 GPa", **PAIR_OPTIONS
    )  # fmt: skip
    _, adhesion, _ = result.summary().points[0].contributions
    positions_row = result.budget.set_index("input").loc["positions"]
    assert (positions_row.lower, positions_row.upper) == pytest.approx(
        (0.2 + adhesion / 2, 0.2 + 2 * adhesion), rel=MAX_SAMPLING_ERROR
    )


def test_replacing_a_stored_result_also_replaces_its_solutions_for_other_hardnesses(tmp_path) -> None:
    kwargs = dict(load="20 MPa", mu0=0.2, tau0="50 MPa", hardness="1..3 GPa", **THREE_POSITION_OPTIONS)
    pair(*rough_surfaces(), effective_modulus="80 GPa", directory=tmp_path, **kwargs)
    softer_result = pair(*rough_surfaces(), effective_modulus="20 GPa", directory=tmp_path, replace=True, **kwargs)
    assert softer_result.interval == pair(*rough_surfaces(), effective_modulus="20 GPa", **kwargs).interval


# The range of E* in the third case is so wide that it needs solutions at other loads.
@pytest.mark.parametrize(("rms", "modulus"), [(0.03, "70..90 GPa"), (0.003, "70..90 GPa"), (0.003, "48..112 GPa")])
def test_interval_for_uncertain_hardness_and_modulus_agrees_with_direct_solutions(rms, modulus) -> None:
    kwargs = dict(load="20 MPa", mu0=0.2, tau0="50 MPa", junction_growth=0, **THREE_POSITION_OPTIONS)
    result = pair(
        *rough_surfaces(rms=rms, points=LARGE_MAP_POINTS), hardness="0.3..1.5 GPa", effective_modulus=modulus, **kwargs
    )
    inputs = Inputs.from_study(result.study).uncertain
    assert sorted(inputs) == ["effective_modulus", "hardness", "yield_exponent"]
    table = result.at_study_loads
    dims = ("cut_off", "sliding", "load", "mu0", "tau0")
    position, samples = next(_iterate_intervals(result, table, dims, {(0.2, 0.05): (inputs, [])}, {}, {}))
    assert table["sliding"].values[position[1]] == "all"
    # The samples contain only errors of inputs, not the error of the mean over positions.
    samples.names, samples.standard_errors = tuple(inputs), {}
    for probability in (0.03, 0.7):
        hardness = float(inputs["hardness"].estimate.quantile(probability))
        effective_modulus = float(inputs["effective_modulus"].estimate.quantile(probability))
        direct_result = pair(
            *rough_surfaces(rms=rms, points=LARGE_MAP_POINTS),
            hardness=hardness,
            effective_modulus=effective_modulus,
            **kwargs,
        )
        friction_samples, _ = samples._sample_friction(
            {"hardness": probability, "effective_modulus": probability, "yield_exponent": 0.5}
        )
        assert friction_samples[0] == pytest.approx(
            direct_result.value,
            rel=MAX_INTERPOLATION_ERROR_OF_WIDE_INPUTS if modulus.startswith("48") else MAX_INTERPOLATION_ERROR,
        )


@pytest.mark.parametrize("infinite", [0, 300, 500])
def test_limits_of_the_combined_interval_equal_quantiles_of_input_samples(infinite) -> None:
    samples = np.random.default_rng(3).lognormal(size=2**14)
    samples[:infinite] = np.inf
    method = "inverted_cdf" if infinite else "linear"
    assert compute_equal_tailed_interval(samples) == pytest.approx(
        np.quantile(samples, [0.025, 0.975], method=method).tolist(), rel=1e-14
    )
    samples[0] = np.nan
    with pytest.raises(ValueError, match=r"coefficient is undefined for [0-9]+ of"):
        compute_equal_tailed_interval(samples)


def test_percentiles_of_a_single_friction_test_agree_with_percentiles_of_random_samples() -> None:
    """Sample mu0, tau0 and the scatter of tests; without a hardness, friction is linear in mu0 and tau0."""
    kwargs = dict(load=["20 MPa", "40 MPa"], effective_modulus="80 GPa", **PAIR_OPTIONS)
    result = pair(*rough_surfaces(rms=0.001), mu0="0.2 ± 0.02", tau0="20..80 MPa", **kwargs)
    values_at_load = result.at().isel(load=0).sel(sliding="all").squeeze()
    inputs = Inputs.from_study(result.study).uncertain
    random = np.random.default_rng(5)
    mu0, tau0 = (inputs[name].estimate.quantile(random.random(400_000)) for name in ("mu0", "tau0"))
    strengths = result.at(mu0=[0.0, 0.2], tau0=[0.0, 0.05]).isel(load=0).sel(sliding="all", statistic="mean")
    corner_coefficients = strengths["mean_friction"].squeeze(drop=True).transpose("mu0", "tau0").values
    coefficient = corner_coefficients[1, 0] * mu0 / 0.2 + corner_coefficients[0, 1] * tau0 / 0.05
    members = int(values_at_load["ok"].min())
    deviation = (
        float(values_at_load["spread_high"] - values_at_load["spread_low"])
        / 2.5631
        / corner_coefficients[1, 1]
        * np.sqrt(1 + 1 / members)
    )
    test_samples = coefficient * np.exp(random.standard_t(members - 1, mu0.size) * np.sqrt(np.log1p(deviation**2)))
    expected = np.quantile(test_samples, [0.05, 0.5, 0.95])
    percentiles = values_at_load["friction_percentiles"]
    assert percentiles["percentile"].values.tolist() == [5, 50, 95]
    np.testing.assert_allclose(percentiles, expected, atol=0.02 * (expected[2] - expected[0]))
    _, lower, upper = values_at_load["friction_prediction"].values
    assert lower < expected[0] < expected[2] < upper


@pytest.mark.parametrize("rms", [0.03, 0.003])
def test_friction_after_a_dwell_equals_friction_at_reduced_hardness(rms) -> None:
    kwargs = dict(load="20 MPa", mu0=0.2, tau0="50 MPa", junction_growth=0, effective_modulus="80 GPa", **PAIR_OPTIONS)
    aged_point = (
        pair(
            *rough_surfaces(rms=rms, points=LARGE_MAP_POINTS),
            hardness="0.8 GPa",
            wait=["1 s", "1 h", "10 d"],
            creep=0.04,
            **kwargs,
        )
        .summary()
        .points[0]
    )
    assert [dwell.seconds for dwell in aged_point.after_dwell] == [1, 3600, 864000]
    assert aged_point.after_dwell[0].value == pytest.approx(aged_point.value, rel=1e-9)
    for dwell in aged_point.after_dwell[1:]:
        softer_result = pair(
            *rough_surfaces(rms=rms, points=LARGE_MAP_POINTS), hardness=0.8 * dwell.seconds**-0.04, **kwargs
        )
        assert dwell.value == pytest.approx(softer_result.value, rel=MAX_INTERPOLATION_ERROR)
        assert dwell.lower < dwell.value < dwell.upper
    if rms == 0.03:  # All contacts yield, so the exact area grows as a power of the dwell time.
        increase_per_log_time = 0.05 / 0.8 * (864000**0.04 - 1) / np.log(864000)
        assert aged_point.ageing == pytest.approx(increase_per_log_time, rel=0.02)
    record = point_record(aged_point)["rate_and_state"]
    median_area = aged_point.values["patch_area"].sel(fraction_below=0.5, statistic="mean").item()
    assert record["b"]["value"] == aged_point.ageing
    assert (record["D_c"]["value"], record["D_c"]["unit"]) == (pytest.approx(2 * np.sqrt(median_area / np.pi)), "um")
    assert f"Rate and state: b = {aged_point.ageing:.2g}, " in dwell_time_text(aged_point)


def test_range_of_creep_exponent_widens_only_intervals_after_a_dwell() -> None:
    kwargs = dict(
        load="20 MPa",
        mu0=0.2,
        tau0="50 MPa",
        junction_growth=0,
        effective_modulus="80 GPa",
        hardness="0.3 GPa",
        **PAIR_OPTIONS,
    )
    kwargs["yield_exponent"] = 1.25
    exact_point, ranged_point = (
        pair(*rough_surfaces(rms=0.03, points=LARGE_MAP_POINTS), wait="1 d", creep=m, **kwargs).summary().points[0]
        for m in ("0.03", "0.02..0.04")
    )
    assert exact_point.after_dwell[0].value == pytest.approx(
        ranged_point.after_dwell[0].value, rel=1e-3
    )  # not exactly equal, because both pairs are solved at different hardnesses
    assert (exact_point.lower, exact_point.upper) == pytest.approx((ranged_point.lower, ranged_point.upper), rel=1e-9)
    lower, upper = (0.2 + 0.05 / 0.3 * 86400**m for m in (0.02, 0.04))
    assert ranged_point.after_dwell[0].upper - ranged_point.after_dwell[0].lower > 0.9 * (upper - lower)
    assert exact_point.after_dwell[0].upper - exact_point.after_dwell[0].lower < 0.3 * (upper - lower)


def test_hardness_of_a_named_material_has_a_range_but_a_given_hardness_is_exact() -> None:
    kwargs = dict(load="2 MPa", mu0=0.2, tau0="50 MPa", upper="steel", lower="brass", junction_growth=0, **PAIR_OPTIONS)
    named_result = pair(*rough_surfaces(rms=0.02), **kwargs)
    assert named_result.budget["input"][0] == "the hardness of the brass"
    assert named_result.budget["fraction"][0] > 0.5
    exact_result = pair(*rough_surfaces(rms=0.02), hardness=float(named_result.study.contact.hardness), **kwargs)
    assert exact_result.value == named_result.value
    assert np.ptp(exact_result.interval) < 0.5 * np.ptp(named_result.interval)
    lower, upper = named_result.budget.loc[0, ["lower", "upper"]]
    assert exact_result.interval == pytest.approx(
        (lower, upper), abs=MAX_SAMPLING_ERROR * np.ptp(named_result.interval)
    )


def test_interval_for_a_single_gap_includes_only_input_uncertainty_and_has_a_caveat() -> None:
    upper, lower = rough_surfaces(rms=0.03, points=128)
    options = {
        "load": "50 MPa", "mu0": 0.2, "tau0": "50 MPa", "effective_modulus": "80 GPa", "work_of_adhesion": 0,
        "onset": 0,
    }  # fmt: skip
    gap = Surface(lower.heights - upper.heights, spacing=0.05)
    ranged_result, exact_result = pair(gap=gap, hardness="0.5..1.5 GPa", **options), pair(gap=gap, **options)
    assert ranged_result.interval[0] < ranged_result.value < ranged_result.interval[1]
    assert "positions" not in ranged_result.budget["input"].tolist()
    assert np.isnan(ranged_result.interval_of_mean).all()
    assert np.isnan(exact_result.interval).all()
    for result in (ranged_result, exact_result):
        assert any("a gap has one position" in caveat.text for caveat in result.caveats)
        assert not any("members that differ" in caveat.remedy for caveat in result.caveats)


def test_material_name_can_be_combined_with_numbers_for_the_other_body() -> None:
    def contact_settings(**materials):
        return pair_study(*rough_surfaces(), load="50 kPa", mu0=0.2, tau0="0.2 MPa", **materials).contact

    rubber_on_glass = contact_settings(lower_material="glass", young="3 MPa", poisson=0.49)
    assert rubber_on_glass.hardness is None
    numeric_contact = contact_settings(young="3 MPa,69.5 GPa", poisson="0.49,0.2")
    assert float(rubber_on_glass.effective_modulus) == pytest.approx(float(numeric_contact.effective_modulus))
    brass_on_steel = contact_settings(upper_material="brass", young="210 GPa", poisson=0.3)
    assert float(brass_on_steel.hardness) == pytest.approx(0.625)
    with pytest.raises(ValueError, match="single values for the upper body"):
        contact_settings(lower_material="glass", young="3 MPa,70 GPa", poisson=0.49)


def test_hardness_option_accepts_vickers_and_rockwell_numbers() -> None:
    assert parse_uncertain_input("hardness", "150 HV", "hardness").value == pytest.approx(150 * 9.80665e-3 / 0.9272)
    rockwell = parse_uncertain_input("hardness", "60 HRC", "hardness")
    assert rockwell.value == pytest.approx(697 * 9.80665e-3 / 0.9272)
    assert rockwell.low < rockwell.value < rockwell.high
    assert parse_uncertain_input("hardness", "58..62 HRC", "hardness").distribution == "log-normal"
    with pytest.raises(ValueError, match="from 20 to 68 HRC"):
        parse_uncertain_input("hardness", "12 HRC", "hardness")
    study = pair_study(*rough_surfaces(), load="2 MPa", mu0=0.2, effective_modulus="80 GPa", hardness="150±15 HV")
    assert float(study.contact.hardness) == pytest.approx(1.586, rel=1e-3)
    assert study.contact.hardness.text == "150±15 HV"


@pytest.mark.parametrize(
    ("options", "pattern"),
    [
        ({"mu0": "0.3..0.2"}, "mu0 must be a range from a smaller"),
        ({"mu0": "0.2±0.02,0.3"}, "mu0 must not be a list"),
        ({"hardness": "3 HB"}, "hardness .*unit"),
        ({"effective_modulus": "3±5 GPa"}, "effective_modulus must be at least twice its standard uncertainty"),
        ({"hardness": "1 GPa", "wait": "1 h", "creep": 5}, "creep must be from 0 to 0.5"),
    ],
)
def test_pair_function_rejects_invalid_ranges_of_inputs(options, pattern) -> None:
    with pytest.raises(ValueError, match=pattern):
        pair(
            *rough_surfaces(), **{"load": "2 MPa", "mu0": 0.2, "effective_modulus": "80 GPa", **PAIR_OPTIONS, **options}
        )


def test_stored_study_preserves_uncertain_inputs() -> None:
    result = pair(*rough_surfaces(), load="2 MPa", mu0="0.1..0.3", effective_modulus="80 GPa", **PAIR_OPTIONS)
    stored_study = Study.from_toml(result.path / "study.toml")
    assert Inputs.from_study(stored_study).estimate("mu0") == parse_uncertain_input("mu0", "0.1..0.3")
    with pytest.raises(StudyError, match=r"friction.tau0.*unit"):
        stored_study.with_changes({"friction.tau0": "20..80"})


SURFACE_PAIR_COUNT_CASES = [pytest.param(2, id="some"), pytest.param(300, marks=pytest.mark.soak, id="all")]
MIN_COVERAGE = 0.92


@pytest.mark.parametrize("num_surface_pairs", SURFACE_PAIR_COUNT_CASES)
def test_combined_interval_contains_the_true_friction_for_random_inputs(num_surface_pairs) -> None:
    ranges = {"mu0": "0.15..0.25", "tau0": "20..80 MPa", "hardness": "0.5..1.5 GPa", "effective_modulus": "70..90 GPa"}
    num_covered = num_covered_tests = 0
    rng = np.random.default_rng(2016)
    for seed in range(num_surface_pairs):
        refinement = int(rng.choice([1, 2, 4]))
        true_surfaces = rough_surfaces(
            seed, rms=float(rng.choice([0.003, 0.01, 0.03])), points=48, refinement=refinement
        )
        filtered_surfaces = [
            cut_off(surface, 0.3, periodic=True) if refinement > 1 else surface for surface in true_surfaces
        ]
        scans = [Surface(surface.heights[::refinement, ::refinement], spacing=0.05) for surface in filtered_surfaces]
        options = dict(load="4 MPa", **PAIR_OPTIONS)
        predicted_result = pair(*scans, **ranges, **options)
        inputs = Inputs.from_study(predicted_result.study).uncertain
        true_inputs = {name: float(inputs[name].estimate.quantile(rng.random())) for name in ranges}
        true_result = pair(*true_surfaces, **true_inputs, **(options | {"shifts": 40}))
        num_covered += predicted_result.interval[0] <= true_result.value <= predicted_result.interval[1]
        tested_coefficient = simulate_friction_test(true_result, rng)
        num_covered_tests += (
            predicted_result.prediction_interval[0] <= tested_coefficient <= predicted_result.prediction_interval[1]
        )
    if num_surface_pairs < 100:
        assert min(num_covered, num_covered_tests) >= num_surface_pairs - 1
        return
    print(f"covers {num_covered / num_surface_pairs:.3f}, next test {num_covered_tests / num_surface_pairs:.3f}")
    assert num_covered / num_surface_pairs >= MIN_COVERAGE
    assert num_covered_tests / num_surface_pairs >= MIN_COVERAGE


def simulate_friction_test(true_result, rng) -> float:
    """Return the coefficient of a random member of the result in a random direction."""
    from stiction.evaluate.member_values import member_values

    members = member_values(true_result.source, true_result.at_study_loads["load"].values).sel(sliding="all").squeeze()
    assert (members["status"] == STATUS_OK).all()
    return float(rng.choice(members["friction_coefficient"].values.ravel()))


@pytest.mark.parametrize("tau0", ["0±50 MPa", "5±50 MPa", "20±200 MPa"])
def test_interval_contains_the_coefficient_if_the_distribution_of_tau0_is_truncated_at_zero(tau0: str) -> None:
    result = pair(
        *rough_surfaces(),
        load="2 MPa",
        mu0=0.2,
        tau0=tau0,
        hardness="3 GPa",
        effective_modulus="80 GPa",
        **PAIR_OPTIONS,
    )
    assert result.interval[0] <= result.value <= result.interval[1]


def test_combined_interval_contains_the_interval_of_the_mean_for_random_means_and_intervals(monkeypatch) -> None:
    monkeypatch.setattr(budget, "MAX_BUDGETED_COEFFICIENTS", 0)
    # Replace the statistics of the result by random ones, so that some ranges for finer scans exceed the interval.
    random = np.random.default_rng(5)
    result = pair(
        *rough_surfaces(),
        load="2 MPa",
        mu0=0.2,
        tau0="20..80 MPa",
        hardness="1 GPa",
        effective_modulus="80 GPa",
        **PAIR_OPTIONS,
    )
    count, ends, scatters, contact_counts = 100, [], [], []
    for _ in range(count):
        value, scatter, half_width = random.uniform(0.21, 1.0), random.uniform(0.001, 1.5), random.uniform(0.001, 0.6)
        ends.append(value * np.array([1.0, 1 - half_width, 1 + half_width * random.uniform(0.5, 2)]))
        scatters.append([value * (1 - scatter / 2), value * (1 + scatter)])
        contact_counts.append(random.uniform(0.2, 30))
    # One table contains all cases along the dimension of mu0, which takes a third of the time of one table per case.
    table = result.at_study_loads.isel(mu0=[0] * count)
    spread_low, spread_high = (xarray.DataArray(values, dims="mu0") for values in np.transpose(scatters))
    cases = table.assign(
        mean_friction=table["mean_friction"] * 0 + xarray.DataArray(ends, dims=("mu0", "statistic")),
        contact_count=table["contact_count"] * 0 + xarray.DataArray(contact_counts, dims="mu0"),
        spread_low=table["spread_low"] * 0 + spread_low,
        spread_high=table["spread_high"] * 0 + spread_high,
    )
    computed_points = summarize(add_uncertainty(cases, result.source), result.study).points
    assert len(computed_points) == count
    for computed_point in computed_points:
        rule = computed_point.rules[0]
        assert rule.rule == "all"
        assert 0 < rule.lower <= rule.interval_of_mean[0] <= rule.value <= rule.interval_of_mean[1] <= rule.upper
        assert 0 < rule.prediction_interval[0] <= rule.value <= rule.prediction_interval[1]
        if computed_point.bracket is not None:
            assert rule.lower <= computed_point.bracket[0] <= computed_point.bracket[1] <= rule.upper


def test_equally_uncertain_inputs_have_equal_fractions_in_the_uncertainty_budget() -> None:
    result = pair(
        *rough_surfaces(), load="2 MPa", mu0="0.2±0.025", tau0="20..80 MPa", young="6..16 GPa,6..16 GPa",
        poisson="0.3,0.3", hardness="1 GPa", yield_exponent=1.25, junction_growth=0, **PAIR_OPTIONS,
    )  # fmt: skip
    budget_fractions = result.budget.set_index("input")["fraction"]
    upper, lower = (budget_fractions[f"Young's modulus of the {side} body"] for side in ("upper", "lower"))
    assert upper == pytest.approx(lower, abs=0.01)
    assert budget_fractions.min() >= 0


def test_uncertainty_budget_of_a_yielding_pair_has_rows_for_positions_and_unresolved_roughness() -> None:
    result = pair(
        *rough_surfaces(), load="20 MPa", mu0=0.2, tau0="50 MPa", effective_modulus="80 GPa", hardness="1 GPa",
        yield_exponent=1.15, junction_growth=0, **PAIR_OPTIONS,
    )  # fmt: skip
    fractions = result.budget.set_index("input")["fraction"]
    assert set(fractions.index) == {"positions", "unresolved roughness"}
    assert fractions.min() > 0.05


SIX_DIRECTION_OPTIONS = PAIR_OPTIONS | {
    "load": "20 MPa", "effective_modulus": "80 GPa", "cutoff": "none", "shifts": 8,
    "direction": list(range(0, 360, 60)),
}  # fmt: skip


@pytest.mark.parametrize("seed", [5, 6, 7, 8])
def test_interval_for_an_uncertain_mu0_of_zero_extends_from_zero_to_a_half_normal_quantile(seed: int) -> None:
    result = pair(*rough_surfaces(seed, points=24), mu0="0±0.1", **SIX_DIRECTION_OPTIONS)
    assert result.value == 0
    lower, upper = result.interval
    assert lower == 0
    assert upper == pytest.approx(0.1 * halfnorm.ppf(0.975), rel=0.02)


def test_friction_coefficient_of_one_pair_is_exactly_zero_if_mu0_and_tau0_are_zero() -> None:
    result = pair(*rough_surfaces(points=24), mu0=0.0, **SIX_DIRECTION_OPTIONS)
    assert (result.value, *result.interval) == (0, 0, 0)
    assert not result.at().friction_by_axis.sel(sliding="all").values.any()
    assert "τ0 is 0, so the coefficient is the given μ0; the surfaces add 0" in [
        caveat.text for caveat in result.caveats
    ]


@pytest.mark.parametrize("seed", [0, 1, 5])
def test_mean_coefficient_of_two_pairs_is_exactly_zero_if_mu0_and_tau0_are_zero(seed: int) -> None:
    result = pair(*rough_surfaces(seed, points=24), mu0=0.0, **SIX_DIRECTION_OPTIONS | {"shifts": 2})
    assert result.value == 0
    assert not np.nan_to_num(result.at().friction_by_axis.sel(sliding="all", statistic="mean").values).any()


UNCERTAIN_INPUT_CASES = (
    {"mu0": "0.2±0.05", "tau0": "20..80 MPa", "effective_modulus": "40..60 GPa"},
    {"mu0": 0.2, "tau0": "50 MPa", "effective_modulus": "50 GPa", "hardness": "1..3 GPa"},
    {"mu0": "0.2±0.05", "tau0": "20..80 MPa", "effective_modulus": "50 GPa", "hardness": "2 GPa"},
)


@pytest.mark.parametrize("inputs", UNCERTAIN_INPUT_CASES)
@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_combined_interval_contains_interval_of_the_mean_and_friction_range_for_finer_scans(
    inputs: dict[str, Any], noise: float
) -> None:
    """Check the nested intervals of pairs with and without noise; the value must not be close to an end."""
    random = np.random.default_rng(7)
    roughness = {"hurst_exponent": 0.7, "rms": 0.01, "shape": (48, 48), "spacing": 0.1, "shortest_wavelength": 0.5}
    heights = [self_affine_surface(5, side=side, **roughness).heights for side in ("upper", "lower")]
    surfaces = [Surface(z + noise * z.std() * random.standard_normal(z.shape), spacing=0.1) for z in heights]
    result = pair(*surfaces, load="200 MPa", shifts=4, onset=0, direction=[0, 90], **inputs)
    points = [point for point in result.summary().points if not point.covered]
    assert points
    for point in points:
        for rule in point.rules:
            width = rule.upper - rule.lower
            assert rule.lower + 0.01 * width < rule.value < rule.upper - 0.01 * width
            assert rule.lower <= rule.interval_of_mean[0] < rule.interval_of_mean[1] <= rule.upper
        if "hardness" in inputs and point.bracket is not None:
            assert point.rules[0].lower <= point.bracket[0] <= point.bracket[1] <= point.rules[0].upper


def test_interval_evaluated_at_zero_mu0_and_tau0_ignores_the_range_of_mu0_in_the_study():
    upper, lower = (
        self_affine_surface(3, hurst_exponent=0.8, rms=0.03, shape=(32, 32), spacing=0.1, side=side)
        for side in ("upper", "lower")
    )
    result = pair(
        upper, lower, load="20 MPa", mu0="0.2 ± 0.02", tau0="30 MPa", effective_modulus="80 GPa", shifts=4, onset=0,
        cutoff="none",
    )  # fmt: skip
    loads = np.geomspace(0.05, 0.5, 12)
    combined_intervals = result.at(loads, mu0=[0.0], tau0=[0.0])["friction_combined"].sel(sliding="all")
    assert float(combined_intervals.sel(statistic="upper").max()) < 1e-9
