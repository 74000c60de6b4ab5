"""Test junction growth of a measured pair, in which plastic contacts grow under shear."""

import math

import numpy as np
import pytest
from stiction import Result, Surface, hardness_under_shear, pair, self_affine_surface, tabor_friction
from stiction.evaluate.at_load import at_load
from stiction.evaluate.member_values import member_values
from stiction.mechanics.friction import FrictionLaw
from stiction.solve.member_sums import MemberSums
from stiction.views.latex import latex_table
from stiction.views.sentence import contributions_text

pytestmark = pytest.mark.usefixtures("no_companion_files")

TABOR_TOLERANCE = 5e-3
"""Relative difference of the friction of a fully plastic pair from Tabor's closed form."""

INTERPOLATION_TOLERANCES = {"all": 0.01, "opposing": 0.03}
"""Relative differences of interpolated coefficients from pairs solved at the hardness under shear, by sliding rule."""

INTERFACE_STRENGTH = {"mu0": 0.2, "tau0": 0.05}
PLASTIC_OPTIONS = {"effective_modulus": 100.0, "hardness": 0.5, "load": "20 MPa", "cutoff": "none", "shifts": 8}


def rough_surfaces(rms=0.05, size=48):
    roughness = {"shape": (size, size), "spacing": 0.1, "hurst_exponent": 0.8, "rms": rms, "shortest_wavelength": 0.4}
    return tuple(
        Surface(self_affine_surface(5, side=side, **roughness).heights, spacing=0.1) for side in ("upper", "lower")
    )


def get_mean_coefficient(result, rule="all", **conditions):
    point = result.at(**conditions) if conditions else result.at()
    return float(point["mean_friction"].sel(statistic="mean", sliding=rule).isel(cut_off=0, load=0, mu0=0, tau0=0))


@pytest.fixture(scope="module")
def growth_result():
    return pair(*rough_surfaces(), **PLASTIC_OPTIONS | INTERFACE_STRENGTH, junction_growth=27)


@pytest.fixture(scope="module")
def result_without_growth():
    return pair(*rough_surfaces(), **PLASTIC_OPTIONS | INTERFACE_STRENGTH, junction_growth=0)


def test_contribution_of_tau0_acts_on_the_area_at_the_onset_of_sliding(growth_result):
    values, point = growth_result.at(), growth_result.summary().first
    areas = [float(values[name].sel(statistic="mean").squeeze()) for name in ("contact_area", "contact_area_at_onset")]
    contribution = point.contribution_terms["adhesion"]
    contribution_before_shear, expected = (point.at["tau0"] * area / point.at["load"] for area in areas)
    assert contribution == pytest.approx(expected, rel=1e-12)  # round-off
    assert contribution > 1.1 * contribution_before_shear
    assert f"{contribution:.3f} (τ0 on the area at the onset of sliding)" in contributions_text(point)


def test_friction_of_fully_plastic_contacts_equals_tabor_friction():
    result = pair(
        *rough_surfaces(0.01), **PLASTIC_OPTIONS | INTERFACE_STRENGTH | {"effective_modulus": 1e4}, junction_growth=27
    )
    expected = float(tabor_friction(PLASTIC_OPTIONS["hardness"], **INTERFACE_STRENGTH, alpha=27))
    assert get_mean_coefficient(result) == pytest.approx(expected, rel=TABOR_TOLERANCE)


@pytest.mark.parametrize("hardness", [0.5, 3.0])
def test_friction_with_junction_growth_equals_direct_solution_at_the_hardness_under_shear(hardness):
    tau0 = 0.1 * hardness
    inputs = PLASTIC_OPTIONS | {"mu0": 0.2, "tau0": tau0, "hardness": hardness}
    pressure = float(hardness_under_shear(hardness, 0.2, tau0, 27.0))
    direct_result = pair(*rough_surfaces(), **inputs | {"hardness": pressure}, junction_growth=0)
    result = pair(*rough_surfaces(), **inputs, junction_growth=27)
    for rule, tolerance in INTERPOLATION_TOLERANCES.items():
        assert get_mean_coefficient(result, rule) == pytest.approx(
            get_mean_coefficient(direct_result, rule), rel=tolerance
        )
    area = result.at()["contact_area_at_onset"].sel(statistic="mean").squeeze()
    assert float(area) == pytest.approx(
        float(direct_result.at()["contact_area"].sel(statistic="mean").squeeze()), rel=0.02
    )


def test_result_at_zero_junction_growth_equals_result_without_junction_growth(result_without_growth):
    study = result_without_growth.study
    assert study.contact.junction_growth == 0
    result = MemberSums.of(result_without_growth)
    without_key = result.with_study(study.with_changes({"contact.junction_growth": None}))
    names = ["mean_friction", "friction_coefficient", "contact_area"]
    values, expected = (at_load(member_sums, [20.0], names=names)[names] for member_sums in (result, without_key))
    assert values.equals(expected)


def test_friction_at_zero_tau0_is_independent_of_junction_growth(growth_result, result_without_growth):
    assert get_mean_coefficient(growth_result, tau0=[0.0]) == get_mean_coefficient(result_without_growth, tau0=[0.0])
    table = growth_result.at(tau0=[0.0])
    assert (
        table["contact_area_at_onset"].sel(statistic="mean") > 1.1 * table["contact_area"].sel(statistic="mean")
    ).all()


def test_interval_at_zero_tau0_is_finite_although_larger_tau0_causes_seizure(growth_result, result_without_growth):
    high_friction = {"mu0": [5.0], "tau0": [0.0]}  # the hardness under shear is below the nominal pressure
    interval, expected = (
        result.at(**high_friction)["friction_combined"].values for result in (growth_result, result_without_growth)
    )
    assert np.isfinite(interval).all()
    assert interval == pytest.approx(expected, rel=1e-12)


def test_friction_with_junction_growth_at_other_mu0_and_tau0_agrees_with_direct_solution(growth_result):
    direct_result = pair(*rough_surfaces(), **PLASTIC_OPTIONS | {"mu0": 0.1, "tau0": 0.03}, junction_growth=27)
    assert get_mean_coefficient(growth_result, mu0=[0.1], tau0=[0.03]) == pytest.approx(
        get_mean_coefficient(direct_result), rel=5e-3
    )


def test_contact_area_and_stiffness_before_shear_are_independent_of_junction_growth(
    growth_result, result_without_growth
):
    for name in ("contact_area", "contact_count", "mean_pressure", "normal_stiffness"):
        assert growth_result.at()[name].equals(result_without_growth.at()[name])


def test_friction_interval_contains_results_at_both_limits_of_junction_growth():
    result = pair(*rough_surfaces(), **PLASTIC_OPTIONS | INTERFACE_STRENGTH, junction_growth="0..27")
    results_at_ends = [
        pair(*rough_surfaces(), **PLASTIC_OPTIONS | INTERFACE_STRENGTH, junction_growth=value)
        for value in (0.675, 26.325)
    ]
    assert result.study.contact.junction_growth == 13.5
    lower, upper = result.interval
    assert lower == pytest.approx(get_mean_coefficient(results_at_ends[0]), rel=0.02)
    assert upper == pytest.approx(get_mean_coefficient(results_at_ends[1]), rel=0.02)
    assert result.budget["input"].iloc[0] == "the junction growth α"


def test_range_of_junction_growth_above_zero_raises_only_the_upper_limit_of_the_interval(
    growth_result, result_without_growth
):
    study = growth_result.study.with_changes({"contact.junction_growth": "0 (0..27)"})
    result = Result.of(growth_result.with_study(study))
    assert result.value == pytest.approx(result_without_growth.value, rel=1e-12)
    assert result.interval[0] <= result_without_growth.value
    assert result.interval[1] == pytest.approx(get_mean_coefficient(growth_result), rel=0.02)
    assert result.budget["input"].iloc[0] == "the junction growth α"


def test_interface_stronger_than_the_bulk_gives_the_status_seizure():
    result = pair(*rough_surfaces(), **PLASTIC_OPTIONS | {"mu0": 0.2, "tau0": 0.11}, junction_growth=27)
    assert (result.at()["status"] == "seizure").all()
    assert np.isnan(result.value)
    assert result.assessment == "Do not quote"


def replace_sums_by_load_multiples(result, **sum_ratios):
    """Return a result whose sums are given multiples of the elastic load in all directions."""
    dataset = result.dataset.copy(deep=True)
    for name, ratio in sum_ratios.items():
        dataset[name][...] = (
            (ratio * dataset["normal_elastic"]).broadcast_like(dataset[name]).transpose(*dataset[name].dims)
        )
    return Result.of(dataset)


def find_area_ratios(result):
    """Return the true area before shear per solved area, and the true area at the onset per area before shear."""
    values = result.at().sel(statistic="mean")
    area_before_shear, area_at_onset = (
        float(values[name].squeeze()) for name in ("contact_area", "contact_area_at_onset")
    )
    solved = result.dataset["contact_area"].sel(load=float(values["load"].squeeze()), method="nearest").mean()
    return area_before_shear / float(solved), area_at_onset / area_before_shear


def test_adhesive_contribution_to_the_normal_load_increases_with_contact_area_under_shear(growth_result):
    area_ratio, growth = find_area_ratios(growth_result)
    assert growth > 1.1
    ratio = -0.1 / (area_ratio * INTERFACE_STRENGTH["tau0"])
    values = replace_sums_by_load_multiples(growth_result, normal_adhesive=ratio, normal_frictional=0.0).at(
        per_member=True
    )
    load = float(values["load"].squeeze())
    np.testing.assert_allclose(values["normal_load"], load * (1 - 0.1 * growth), rtol=1e-9)
    assert (values["status"] == "ok").all()


def test_pair_that_loses_its_normal_load_as_contacts_grow_is_self_locked(growth_result):
    area_ratio, growth = find_area_ratios(growth_result)
    ratio = -1 / (area_ratio * INTERFACE_STRENGTH["tau0"] * math.sqrt(growth))
    result = replace_sums_by_load_multiples(growth_result, normal_adhesive=ratio, normal_frictional=0.0)
    values = result.at(per_member=True)
    assert (values["normal_load"] < 0).all()
    assert (values["status"] == "self-locked").all()
    assert values["friction_coefficient"].isnull().all()
    study = result.study.with_changes({"contact.junction_growth": None})
    without_growth = member_values(MemberSums.of(result).with_study(study), [float(values["load"].squeeze())])
    assert (without_growth["status"] == "ok").all()


@pytest.mark.parametrize(("tau0", "has_end"), [("60..90 MPa", True), ("70..130 MPa", False)])
def test_friction_interval_has_no_upper_limit_if_contacts_seize_in_many_samples(tau0, has_end):
    result = pair(*rough_surfaces(), **PLASTIC_OPTIONS | {"mu0": 0.2, "tau0": tau0}, junction_growth="20..27")
    assert np.isfinite(result.interval[1]) == has_end
    assert np.isfinite(result.interval[0])
    assert (result.at()["status"] == "ok").all()


def test_uncertainty_budget_includes_junction_growth_even_if_contacts_seize_in_only_a_few_input_samples():
    result = pair(
        *rough_surfaces(),
        **PLASTIC_OPTIONS | INTERFACE_STRENGTH | {"hardness": "0.23..1.7 GPa"},
        junction_growth="0..27",
    )
    assert 0 < result.at()["fraction_unlimited"].sel(sliding="all").item() < 0.025
    assert np.isfinite(result.interval[1])
    budget = result.budget.set_index("input")
    assert 0.01 < budget.loc["the junction growth α", "fraction"] < budget.loc["the hardness", "fraction"] < 1


def test_junction_growth_after_a_dwell_uses_the_reduced_hardness():
    inputs = PLASTIC_OPTIONS | INTERFACE_STRENGTH | {"wait": "100 s", "creep": 0.05}
    aged_coefficient = pair(*rough_surfaces(), **inputs, junction_growth=27).summary().points[0].after_dwell[-1].value
    softer_result = pair(
        *rough_surfaces(), **PLASTIC_OPTIONS | INTERFACE_STRENGTH | {"hardness": 0.5 * 100**-0.05}, junction_growth=27
    )
    assert aged_coefficient == pytest.approx(get_mean_coefficient(softer_result), rel=0.01)


@pytest.mark.parametrize(("options", "text"), [
    ({"upper": "steel", "lower": "brass"}, "slip-line"), ({"upper": "PMMA", "lower": "steel"}, "slip-line"),
    ({"effective_modulus": 100.0, "hardness": 0.5}, "slip-line"), ({"upper": "rubber", "lower": "steel"}, None),
    ({"effective_modulus": 100.0}, None), ({"upper": "steel", "lower": "brass", "junction_growth": 0}, None),
    ({"upper": "steel", "lower": "brass", "work_of_adhesion": "50 mJ/m^2"}, None),
])  # fmt: skip
def test_friction_of_yielding_bodies_follows_slip_line_theory_by_default(options, text):
    result = pair(*rough_surfaces(), load="1 MPa", mu0=0.2, tau0=0.001, shifts=2, cutoff="none", **options)
    growth = result.study.contact.junction_growth
    assert (growth and growth.text) == (text or growth)


@pytest.mark.parametrize(("arguments", "expected_term"), [
    ({"junction_growth": -1.0}, "junction_growth"), ({"junction_growth": 101}, "100"),
    ({"junction_growth": "27..0"}, "smaller"), ({"junction_growth": 9, "hardness": None}, "hardness"),
    ({"junction_growth": 9, "mechanics": "asperities", "hardness": None}, "half-space"),
    ({"junction_growth": 9, "work_of_adhesion": "50 mJ/m^2"}, "work_of_adhesion"),
    ({"junction_growth": float("nan")}, "junction_growth"), ({"junction_growth": "slip-line 9"}, "from 5 to 6.5"),
    ({"junction_growth": "slip lines"}, "slip lines"),
])  # fmt: skip
def test_pair_function_rejects_invalid_values_of_junction_growth(arguments, expected_term):
    with pytest.raises(ValueError, match=expected_term):
        pair(*rough_surfaces(), **PLASTIC_OPTIONS | INTERFACE_STRENGTH | arguments)


@pytest.mark.parametrize("alpha", [0.0, 9.0, 27.0])
def test_pressure_under_shear_satisfies_the_yield_condition(alpha):
    hardness, mu = np.array([0.5, 2.0]), np.array([0.2, 0.6])
    pressure = FrictionLaw(mu, 0.0, alpha).yield_pressure(hardness)
    assert pressure**2 + alpha * (mu * pressure) ** 2 == pytest.approx(hardness**2, rel=1e-12)


# ---- Slip lines ------------------------------------------------------------------------------------------------------

WEAK_INTERFACE = {"mu0": 0.2, "tau0": 0.03}


def test_slip_line_theory_gives_the_closed_form_friction_of_fully_plastic_contacts():
    options = PLASTIC_OPTIONS | WEAK_INTERFACE | {"effective_modulus": 1e4, "junction_growth": "slip-line 5.6"}
    expected = FrictionLaw(0.2, 0.03, 5.6, uses_slip_lines=True).plastic_coefficient(0.5)
    assert get_mean_coefficient(pair(*rough_surfaces(0.01), **options)) == pytest.approx(float(expected), rel=0.01)


@pytest.mark.parametrize(("hardness", "mu0", "tau0"), [(2.0, 0.2, 0.1), (5.0, 0.1, 0.5)])
def test_slip_line_theory_agrees_with_solutions_for_the_hardness_under_shear(hardness, mu0, tau0):
    options = {**PLASTIC_OPTIONS, "mu0": mu0, "tau0": tau0, "load": "50 MPa", "onset": 0}
    del options["hardness"]
    pressure = float(hardness_under_shear(hardness, mu0, tau0, "slip-line"))
    direct_result, result = (
        pair(*rough_surfaces(size=128), **options, hardness=given_hardness, junction_growth=growth)
        for given_hardness, growth in ((pressure, 0), (hardness, "slip-line 5.6"))
    )
    assert get_mean_coefficient(result) == pytest.approx(get_mean_coefficient(direct_result), rel=0.02)
    area = float(result.at()["contact_area_at_onset"].sel(statistic="mean").squeeze())
    assert area == pytest.approx(float(direct_result.at()["contact_area"].sel(statistic="mean").squeeze()), rel=0.02)


def solve_slip_lines(hardness, mu0, tau0, ratio):
    """Return the pressure of a yielding contact at the onset of sliding, by bisection over many samples."""
    min_pressure, max_pressure = 0.5 * hardness, hardness
    for _ in range(60):
        pressure = 0.5 * (min_pressure + max_pressure)
        fraction = np.minimum(ratio * (mu0 * pressure + tau0) / hardness, 1.0)
        limit = hardness * (1 + np.pi / 2 + np.arccos(fraction) + np.sqrt(1 - fraction**2)) / (2 + np.pi)
        min_pressure, max_pressure = (
            np.where(pressure < limit, pressure, min_pressure),
            np.where(pressure < limit, max_pressure, pressure),
        )
    return pressure


@pytest.mark.parametrize(("tau0", "limits"), [(0.025, (0.02, 0.03)), (0.05, (0.04, 0.06))])
def test_slip_line_interval_agrees_with_a_brute_force_calculation_if_all_contacts_yield(tau0, limits):
    text = f"uniform {limits[0]} GPa .. {limits[1]} GPa"
    options = PLASTIC_OPTIONS | {"effective_modulus": 1e4, "hardness": "0.5 GPa ± 5 %", "mu0": 0.2, "tau0": text}
    result = pair(*rough_surfaces(0.01), **options, junction_growth="slip-line")
    random, count = np.random.default_rng(3), 200_000
    ratio, strength = random.uniform(5.14, 6.05, count), random.uniform(*limits, count)
    hardness = 0.5 * (1 + 0.05 * random.standard_normal(count))
    coefficient = 0.2 + strength / solve_slip_lines(hardness, 0.2, strength, ratio)
    is_stronger = coefficient > 2 / ratio / 0.95  # the model neglects reductions of friction below 5 %
    coefficient = np.where(is_stronger, 2 / ratio, coefficient)
    lower = np.quantile(coefficient, 0.025)
    upper = np.quantile(np.where(is_stronger, np.inf, coefficient), 0.975, method="inverted_cdf")
    tolerance = 0.03 * (np.quantile(coefficient, 0.975) - lower)
    assert result.interval[0] == pytest.approx(lower, abs=tolerance)
    assert result.interval[1] == (pytest.approx(upper, abs=tolerance) if tau0 < 0.03 else math.inf)
    assert result.at()["fraction_unlimited"].max() == pytest.approx(is_stronger.mean(), abs=0.01)


@pytest.mark.parametrize("strength", [{"mu0": 0.2, "tau0": 0.11}, {"mu0": 0.6, "tau0": 0.0}])
def test_coefficient_is_a_lower_limit_if_the_interface_is_stronger_than_the_softer_body(strength):
    result = pair(*rough_surfaces(), **PLASTIC_OPTIONS | strength, junction_growth="slip-line")
    assert (result.at()["status"] == "bulk-shear").all()
    assert 2 / 6.05 < result.value < 1.05 * 2 / 5.6 + 0.02
    assert math.isinf(result.interval[1])
    assert 2 / 6.05 <= result.interval[0] <= result.value
    assert result.assessment == "Do not quote"
    limit_lines = str(result).splitlines()[:2]
    assert limit_lines[0].startswith(f"μ_s ≥ {result.value:.2f} [")
    assert limit_lines[1].startswith("    ≥ 0.")
    assert rf"$\geq$ {result.value:.2f} [" in latex_table(result.summary())
    assert str(result).count("interface is stronger than the softer body") == 1
    assert np.isfinite(result.at()["friction_coefficient"].sel(statistic="mean")).all()


def test_shear_of_the_softer_body_limits_the_contribution_of_mu0_to_the_normal_load():
    result = pair(*rough_surfaces(), **PLASTIC_OPTIONS, mu0=0.6)
    sum_ratios = {"normal_frictional": -0.5, "tangential_frictional": 1.0, "tangential_elastic": 0.0}
    values = replace_sums_by_load_multiples(result, **sum_ratios).at(per_member=True)
    load = float(values["load"].squeeze())
    limited_mu0 = values["tangential_load"] / load
    assert (values["status"] == "bulk-shear").all()
    assert (limited_mu0 < 0.59).all()
    np.testing.assert_allclose(values["normal_load"], load * (1 - 0.5 * limited_mu0), rtol=1e-9)


def test_shear_of_the_softer_body_limits_the_contribution_of_tau0_to_the_normal_load():
    result = pair(*rough_surfaces(), **PLASTIC_OPTIONS, mu0=0.2, tau0=0.11)
    area_ratio, growth = find_area_ratios(result)
    sum_ratios = {"normal_adhesive": -0.1 / (area_ratio * 0.11), "normal_frictional": 0.0, "tangential_adhesive": 0.0}
    sum_ratios |= {"tangential_frictional": 1.0, "tangential_elastic": 0.0}
    values = replace_sums_by_load_multiples(result, **sum_ratios).at(per_member=True)
    load = float(values["load"].squeeze())
    friction_fraction = values["tangential_load"] / (0.2 * load)
    assert (friction_fraction < 0.99).all()
    np.testing.assert_allclose(values["normal_load"], load * (1 - 0.1 * growth * friction_fraction), rtol=1e-9)


@pytest.mark.parametrize(("growth", "tau0", "load", "can_help"), [
    ("slip-line", "uniform 25 MPa .. 45 MPa", 20, False), ("0..100", "uniform 35 MPa .. 65 MPa", 20, False),
    ("4..9", "uniform 60 MPa .. 160 MPa", 200, True),
])  # fmt: skip
def test_caveat_about_unlimited_friction_recommends_a_smaller_load_only_if_this_would_limit_friction(
    growth, tau0, load, can_help
):
    options = {**PLASTIC_OPTIONS, "mu0": 0.2, "tau0": tau0, "junction_growth": growth}
    result, result_at_small_load = (
        pair(*rough_surfaces(), **options | {"load": f"{nominal_pressure} MPa"})
        for nominal_pressure in (load, load / 10)
    )
    assert math.isinf(result.interval[1])
    assert math.isfinite(result_at_small_load.interval[1]) == can_help
    (caveat,) = (caveat for caveat in result.summary().first.caveats if "samples of the inputs" in caveat.text)
    assert ("reduce the load" in caveat.remedy) == can_help


@pytest.mark.parametrize("mu0", [0.2, 0.6])
def test_friction_range_for_finer_scans_is_omitted_if_yielding_contacts_would_shear_the_body(mu0):
    options = PLASTIC_OPTIONS | {"hardness": 50.0, "shifts": 16}
    point = pair(*rough_surfaces(0.01), **options, mu0=mu0, junction_growth="slip-line").summary().first
    assert point.status == "ok"
    assert point.value == pytest.approx(mu0, rel=0.01)
    assert (point.bracket is None) == (mu0 > 2 / 5.6)
    assert (point.roughness_contribution is None) == (mu0 > 2 / 5.6)


def test_slip_line_theory_does_not_change_the_friction_of_an_elastic_pair_with_high_mu0():
    options = PLASTIC_OPTIONS | {"mu0": 0.6, "tau0": 0.0, "hardness": 60.0}
    result, without_growth = (pair(*rough_surfaces(), **options, junction_growth=growth) for growth in ("slip-line", 0))
    assert (result.at()["status"] == "ok").all()
    assert result.value == without_growth.value
    assert result.interval == pytest.approx(without_growth.interval, rel=1e-3)


@pytest.mark.parametrize(
    ("materials", "growth"),
    [
        ({"upper": "granite", "lower": "granite"}, 0.0),
        ({"upper": "steel", "lower": "granite"}, 5.6),
        ({"upper": "PMMA", "lower": "glass"}, 5.6),
        ({"upper": "glass"}, 0.0),
        ({"upper": "bearing steel", "lower": "glass"}, 0.0),
        ({"upper": "bearing steel", "lower": "glass", "hardness": "2 GPa"}, 5.6),
        ({"upper": "granite", "lower": "glass", "hardness": "2 GPa"}, 0.0),
        ({"effective_modulus": "60 GPa", "hardness": "8 GPa"}, 5.6),
    ],
    ids=lambda value: "-".join(value.values()) if isinstance(value, dict) else "",
)
def test_contacts_grow_by_slip_lines_by_default_unless_the_softer_body_is_a_named_brittle_material(materials, growth):
    result = pair(*rough_surfaces(), **materials, mu0=0.3, load="20 MPa", cutoff="none", shifts=2, onset=0)
    assert result.study.contact.junction_growth == growth
    unwrapped_text = " ".join(str(result).split())
    assert ("no junction growth" in unwrapped_text) == (growth == 0)


@pytest.mark.parametrize("options", [{}, {"hardness": "4 GPa"}], ids=["material hardness", "given hardness"])
def test_study_of_adhesive_rock_contains_no_junction_growth_unless_it_is_given(options):
    adhesion = {"work_of_adhesion": "50 mJ/m^2", "adhesion_range": "2 nm"}
    conditions = {"load": "20 MPa", "cutoff": "none", "shifts": 2, "onset": 0}
    options = options | {"upper": "granite", "mu0": 0.3} | adhesion | conditions
    result = pair(*rough_surfaces(), **options)
    assert result.study.contact.junction_growth is None
    assert "no junction growth" not in str(result)
    assert pair(*rough_surfaces(), **options, junction_growth=0).study.contact.junction_growth == 0


def test_coefficient_of_yielding_rock_has_an_upper_limit_unless_slip_lines_are_given():
    options = PLASTIC_OPTIONS | {"effective_modulus": None, "upper": "granite", "hardness": "4 GPa", "load": "500 MPa"}
    result = pair(*rough_surfaces(0.2), **options, mu0="0.35±0.05")
    assert result.value == pytest.approx(0.35, abs=0.02)
    assert result.interval[1] < 0.5
    with_slip_lines = pair(*rough_surfaces(0.2), **options, mu0="0.35±0.05", junction_growth="slip-line")
    assert math.isinf(with_slip_lines.interval[1])
    assert "--junction-growth 0" not in str(with_slip_lines)


@pytest.mark.parametrize("mu0", ["0.35±0.05", 0.6], ids=["some samples", "central inputs"])
def test_unlimited_coefficient_of_unnamed_bodies_recommends_no_junction_growth_for_rock(mu0):
    caveats = pair(*rough_surfaces(), **PLASTIC_OPTIONS, mu0=mu0).caveats
    remedies = [caveat.remedy for caveat in caveats]
    assert sum("for rock, glass or ceramics, use --junction-growth 0" in remedy for remedy in remedies) == 1
