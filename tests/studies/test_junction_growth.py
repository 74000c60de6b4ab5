"""Junction growth of a measured pair: plastic contacts under shear carry H' of `hardness_under_shear`, and grow."""

import numpy as np
import pytest
import xarray
from stiction import Surface, hardness_under_shear, pair, self_affine_surface, tabor_friction
from stiction.studies.hardness import _interpolate_loads
from stiction.studies.interfaces import ShearStrength

PLASTIC_TOLERANCE = 5e-3
"""Relative difference of contacts that all yield from Tabor's closed form."""

NODE_TOLERANCES = {"all": 0.01, "opposing": 0.03}
"""Relative difference of a coefficient from that of a pair pressed at H', by rule: an upper bound of "opposing"."""

STRENGTH = {"mu0": 0.2, "tau0": 0.05}
PLASTIC = {"effective_modulus": 100.0, "hardness": 0.5, "load": "20 MPa", "cutoff": "none", "shifts": 8}


def bodies(rms=0.05):
    rough = {"shape": (64, 64), "spacing": 0.1, "hurst_exponent": 0.8, "rms": rms, "shortest_wavelength": 0.4}
    return tuple(
        Surface(self_affine_surface(5, side=side, **rough).heights, spacing=0.1) for side in ("upper", "lower")
    )


def coefficient(result, rule="all", **at):
    point = result.at(**at) if at else result.at()
    return float(point["friction_all_round"].sel(statistic="mean", sliding=rule).isel(cut_off=0, load=0, mu0=0, tau0=0))


@pytest.fixture(scope="module")
def grown():
    return pair(*bodies(), **PLASTIC | STRENGTH, junction_growth=27)


@pytest.fixture(scope="module")
def unsheared():
    return pair(*bodies(), **PLASTIC | STRENGTH, junction_growth=0)


def test_fully_plastic_contacts_have_coefficient_of_tabor():
    result = pair(*bodies(0.01), **PLASTIC | STRENGTH | {"effective_modulus": 1e4}, junction_growth=27)
    expected = float(tabor_friction(PLASTIC["hardness"], **STRENGTH, alpha=27))
    assert coefficient(result) == pytest.approx(expected, rel=PLASTIC_TOLERANCE)


@pytest.mark.parametrize("rule", ["all", "opposing"])
@pytest.mark.parametrize("hardness", [0.5, 3.0])
def test_coefficient_equals_pair_solved_at_hardness_under_shear(rule, hardness):
    tau0 = 0.1 * hardness
    inputs = PLASTIC | {"mu0": 0.2, "tau0": tau0, "hardness": hardness}
    pressure = float(hardness_under_shear(hardness, 0.2, tau0, 27.0))
    direct = pair(*bodies(), **inputs | {"hardness": pressure}, junction_growth=0)
    result = pair(*bodies(), **inputs, junction_growth=27)
    assert coefficient(result, rule) == pytest.approx(coefficient(direct, rule), rel=NODE_TOLERANCES[rule])
    area = result.at()["contact_area_at_onset"].sel(statistic="mean").squeeze()
    assert float(area) == pytest.approx(float(direct.at()["contact_area"].sel(statistic="mean").squeeze()), rel=0.02)


def test_zero_growth_changes_no_bits(unsheared):
    default = pair(*bodies(), **PLASTIC | STRENGTH)
    assert unsheared.study.contact.junction_growth == 0
    assert default.study.contact.junction_growth is None
    assert unsheared.at().equals(default.at())
    assert unsheared.interval == default.interval


def test_friction_without_adhesive_strength_is_unchanged(grown, unsheared):
    assert coefficient(grown, tau0=[0.0]) == coefficient(unsheared, tau0=[0.0])
    at = grown.at(tau0=[0.0])
    assert (at["contact_area_at_onset"].sel(statistic="mean") > 1.1 * at["contact_area"].sel(statistic="mean")).all()


def test_interval_without_adhesive_strength_ignores_an_area_that_seizes(grown, unsheared):
    strong = {"mu0": [5.0], "tau0": [0.0]}  # H' is below the nominal pressure
    ends, wanted = (each.at(**strong)["friction_combined"].values for each in (grown, unsheared))
    assert np.isfinite(ends).all()
    assert ends == pytest.approx(wanted, rel=1e-12)


def test_other_strengths_need_no_new_solution(grown):
    other = pair(*bodies(), **PLASTIC | {"mu0": 0.1, "tau0": 0.03}, junction_growth=27)
    assert coefficient(grown, mu0=[0.1], tau0=[0.03]) == pytest.approx(coefficient(other), rel=5e-3)


def test_area_stiffness_and_contacts_are_before_shear(grown, unsheared):
    for name in ("contact_area", "contact_count", "mean_pressure", "normal_stiffness"):
        assert grown.at()[name].equals(unsheared.at()[name])


def test_interval_covers_the_range_of_growth():
    result = pair(*bodies(), **PLASTIC | STRENGTH, junction_growth="0..27")
    ends = [pair(*bodies(), **PLASTIC | STRENGTH, junction_growth=value) for value in (0.675, 26.325)]
    assert result.study.contact.junction_growth == 13.5
    lower, upper = result.interval
    assert lower == pytest.approx(coefficient(ends[0]), rel=0.02)
    assert upper == pytest.approx(coefficient(ends[1]), rel=0.02)
    assert result.budget["input"].iloc[0] == "the junction growth α"


def test_interface_stronger_than_the_bulk_has_status_seizure():
    result = pair(*bodies(), **PLASTIC | {"mu0": 0.2, "tau0": 0.11}, junction_growth=27)
    assert (result.at()["status"] == "seizure").all()
    assert np.isnan(result.value)
    assert result.verdict == "Do not quote"


@pytest.mark.parametrize(("tau0", "has_end"), [("60..90 MPa", True), ("70..130 MPa", False)])
def test_interval_is_open_if_many_samples_seize(tau0, has_end):
    result = pair(*bodies(), **PLASTIC | {"mu0": 0.2, "tau0": tau0}, junction_growth="20..27")
    assert np.isfinite(result.interval[1]) == has_end
    assert np.isfinite(result.interval[0])
    assert (result.at()["status"] == "ok").all()


def test_budget_counts_growth_that_seizes_at_one_of_its_values():
    result = pair(*bodies(), **PLASTIC | STRENGTH | {"hardness": "0.23..1.7 GPa"}, junction_growth="0..27")
    assert 0 < result.at()["fraction_seizing"].sel(sliding="all").item() < 0.025
    assert np.isfinite(result.interval[1])
    budget = result.budget.set_index("input")
    assert 0.01 < budget.loc["the junction growth α", "share"] < budget.loc["the hardness", "share"] < 1


def test_growth_after_dwell_uses_reduced_hardness():
    inputs = PLASTIC | STRENGTH | {"wait": "100 s", "creep": 0.05}
    waited = pair(*bodies(), **inputs, junction_growth=27).summary().points[0].waited[-1].value
    softer = pair(*bodies(), **PLASTIC | STRENGTH | {"hardness": 0.5 * 100**-0.05}, junction_growth=27)
    assert waited == pytest.approx(coefficient(softer), rel=0.01)


@pytest.mark.parametrize(("upper", "lower", "text"), [
    ("steel", "brass", "0..27"), ("PMMA", "steel", None), ("silicon", "silicon", None),
])  # fmt: skip
def test_metals_grow_by_default(upper, lower, text):
    result = pair(*bodies(), upper=upper, lower=lower, load="10 MPa", mu0=0.2, tau0=0.001, shifts=2, cutoff="none")
    assert result.study.known.junction_growth == text


@pytest.mark.parametrize(("arguments", "word"), [
    ({"junction_growth": -1.0}, "junction_growth"), ({"junction_growth": 101}, "100"),
    ({"junction_growth": "27..0"}, "smaller"), ({"junction_growth": 9, "hardness": None}, "hardness"),
    ({"junction_growth": 9, "mechanics": "asperities", "hardness": None}, "half-space"),
    ({"junction_growth": 9, "work_of_adhesion": "50 mJ/m^2"}, "work_of_adhesion"),
    ({"junction_growth": float("nan")}, "junction_growth"),
])  # fmt: skip
def test_bad_growth_is_rejected(arguments, word):
    with pytest.raises(ValueError, match=word):
        pair(*bodies(), **PLASTIC | STRENGTH | arguments)


def test_areas_between_solved_loads_follow_a_power_of_the_load():
    loads, areas = np.array([1.0, 4.0, 100.0]), np.array([3.0, 6.0, np.nan])
    solved = xarray.Dataset({"contact_area": ("load", areas)}, {"load": loads})
    found = _interpolate_loads(solved, np.array([0.1, 1.0, 2.0, 4.0]))["contact_area"].values
    assert found == pytest.approx([3.0, 3.0, 3.0 * 2**0.5, 6.0])


@pytest.mark.parametrize("alpha", [0.0, 9.0, 27.0])
def test_pressure_under_shear_of_a_coefficient_solves_the_yield_condition(alpha):
    hardness, mu = np.array([0.5, 2.0]), np.array([0.2, 0.6])
    pressure = ShearStrength("all", mu).under_shear(hardness, alpha)
    assert pressure**2 + alpha * (mu * pressure) ** 2 == pytest.approx(hardness**2, rel=1e-12)
