"""Test the indentation size effect: small contacts of metals are harder than the indentation that measured them."""

from functools import cache

import numpy as np
import pytest
from stiction import Result, pair
from stiction._number_format import format_with_unit
from stiction.mechanics.friction import STATUS_BULK_SHEAR, FrictionLaw
from stiction.mechanics.hardness import estimate_indentation_depth, size_effect_factor
from stiction.summary.assessment import SizeEffect, estimate_size_effect
from stiction.views.sentence import inputs_text
from support.rough_surfaces import rough_maps

pytestmark = pytest.mark.usefixtures("no_companion_files")

METAL_OPTIONS = {
    "effective_modulus": 100.0, "hardness": 0.5, "load": "20 MPa", "cutoff": "none", "shifts": 6, "mu0": 0.2,
    "tau0": 0.02, "yield_exponent": 1.15, "junction_growth": "slip-line 5.6", "onset": 0,
}  # fmt: skip


@cache
def press_metals(**options):
    return pair(*rough_maps(5, rms=0.05, shortest_wavelength=0.4), **METAL_OPTIONS | options)


def get_mean(result, name):
    values = result.at()[name].sel(statistic="mean")
    return values.sel(sliding="all").item() if "sliding" in values.dims else values.item()


def test_size_effect_factor_is_the_ratio_of_nix_gao_hardnesses_at_two_depths():
    hardness_at = lambda depth: 1.3 * np.sqrt(1 + 0.5 / depth)  # noqa: E731
    assert size_effect_factor(0.5, 0.03, 4.0) == pytest.approx(hardness_at(0.03) / hardness_at(4.0), rel=1e-12)
    assert size_effect_factor(0.5, 0.03) == pytest.approx(hardness_at(0.03) / 1.3, rel=1e-12)
    assert size_effect_factor(0.5, 0.03, 0.03) == 1


def test_indent_of_the_estimated_depth_has_the_same_ratio_of_slope_to_radius_as_the_contacts():
    slope_of_vickers = np.sqrt(np.pi / 24.5)  # slope of a cone with the area 24.5 h² of a Vickers indentation
    radius, slope, count = 0.3, 0.1, 5
    depth = estimate_indentation_depth(count * np.pi * radius**2, count, slope)
    assert slope_of_vickers / (depth / slope_of_vickers) == pytest.approx(slope / radius, rel=1e-12)
    assert estimate_indentation_depth(count * 2 * radius, count, slope, are_lines=True) == pytest.approx(
        depth, rel=1e-12
    )


def test_contact_hardness_is_the_hardness_at_the_indentation_depth_of_the_contacts():
    without_indent, result = press_metals(), press_metals(indent="2 um")
    depth = estimate_indentation_depth(
        *(
            get_mean(press_metals(yield_exponent=10.0), name)
            for name in ("contact_area", "contact_count", "rms_gradient")
        )
    )
    value, lower, upper = result.at()["contact_hardness"].values.ravel()
    assert value == pytest.approx(0.5 * size_effect_factor(np.sqrt(0.2), depth, 2.0), rel=0.05)
    for limit, length in ((lower, 0.1), (upper, 2.0)):
        factor = size_effect_factor(length, depth, 2.0)
        assert limit == pytest.approx(0.5 * factor, rel=0.05)
    harder_result = press_metals(hardness=float(value))
    for name, tolerance in (("mean_friction", 0.01), ("contact_area", 0.03), ("contact_area_at_onset", 0.03)):
        assert get_mean(result, name) == pytest.approx(get_mean(harder_result, name), rel=tolerance)
    assert get_mean(result, "mean_friction") < get_mean(without_indent, "mean_friction")
    assert get_mean(result, "closure") == get_mean(without_indent, "closure")


def test_contact_hardness_is_the_same_for_both_definitions_of_a_mean_load():
    result = press_metals(indent="2 um")
    elastic, mean = (result.at(load_definition=definition)["contact_hardness"] for definition in ("elastic", "mean"))
    assert mean.dims == elastic.dims
    np.testing.assert_array_equal(mean.sel(statistic="mean"), elastic.sel(statistic="mean"))


def test_hardness_test_as_shallow_as_the_contacts_leaves_friction_nearly_unchanged():
    depth = estimate_indentation_depth(
        *(get_mean(press_metals(), name) for name in ("contact_area", "contact_count", "rms_gradient"))
    )
    result = press_metals(indent=float(depth))
    assert result.value == pytest.approx(press_metals().value, rel=5e-3)
    assert result.interval == pytest.approx(press_metals().interval, rel=0.01)


def test_interval_with_an_indentation_agrees_with_results_at_the_limits_of_the_size_effect():
    result = press_metals(indent="2 um")
    _, *hardnesses = result.at()["contact_hardness"].values.ravel()
    ends = [press_metals(hardness=float(hardness)) for hardness in hardnesses]
    assert result.interval[1] == pytest.approx(ends[0].value, rel=0.02)
    assert result.interval[0] == pytest.approx(ends[1].value, rel=0.03)
    assert result.budget["input"].iloc[0] == "the indentation size effect"
    value, lower, upper = (
        format_with_unit(contact_hardness, "GPa") for contact_hardness in result.at()["contact_hardness"].values.ravel()
    )
    text = f"measured 2 µm deep, {value} [{lower}, {upper}] in the contacts"
    assert text in inputs_text(result.summary().first)
    assert result.summary().first.hardness == pytest.approx(get_mean(result, "contact_hardness"))


UNCERTAIN_GROWTH_AND_HARDNESS = {"junction_growth": "slip-line 5.14..6.05", "hardness": "0.5 GPa ± 10 %"}


@pytest.mark.parametrize("indent", [None, "2 um"])
def test_intervals_at_several_loads_agree_with_intervals_at_single_loads(indent):
    dataset = press_metals(**UNCERTAIN_GROWTH_AND_HARDNESS, indent=indent).dataset
    several_loads = Result.of(dataset).at(["10 MPa", "20 MPa"], mu0=[0.1, 0.4], tau0=[0.02, 0.1])["friction_combined"]
    for index, load in enumerate(several_loads["load"].values):
        single_load = Result.of(dataset).at(load, mu0=0.4, tau0=0.1)["friction_combined"]
        selected_values = several_loads.isel(load=index, mu0=1, tau0=1)
        np.testing.assert_allclose(selected_values.squeeze(), single_load.squeeze(), rtol=1e-12)


def test_yield_pressures_of_input_samples_are_computed_once_for_all_loads(monkeypatch):
    result = press_metals(**UNCERTAIN_GROWTH_AND_HARDNESS)
    compute_pressure = FrictionLaw.yield_pressure
    num_computed = []

    def count_arrays_of_hardnesses(law, hardness):
        num_computed[-1] += np.size(hardness) > 1
        return compute_pressure(law, hardness)

    monkeypatch.setattr(FrictionLaw, "yield_pressure", count_arrays_of_hardnesses)
    for num_loads in (1, 3):
        num_computed.append(0)
        loads = np.linspace(0.2, 0.8, num_loads) * result.study.contact.loading_steps()[-1]
        Result.of(result.dataset).at(loads, mu0=[0.1, 0.4], quantities=["contact_count"])
    assert num_computed[0] == num_computed[1] > 0


def test_missing_indentation_depth_adds_a_caveat_for_metals_only():
    result, measured = press_metals(), press_metals(indent="2 um")
    polymer = press_metals(effective_modulus=5.0, hardness=0.025, load="1 MPa", tau0=1e-3)
    texts = [
        " ".join(caveat.text for caveat in pair_result.summary().points[0].caveats)
        for pair_result in (result, polymer, measured)
    ]
    assert "times as hard as large ones" in texts[0]
    assert "as hard as large ones" not in texts[1] + texts[2]


@pytest.mark.parametrize("tau0", [0.0, 0.02])
def test_true_area_has_a_note_if_the_size_effect_is_larger_than_its_interval(tau0):
    exact, uncertain, measured = (
        press_metals(tau0=tau0, **options) for options in ({}, {"hardness": "0.1..2.5 GPa"}, {"indent": "2 um"})
    )
    note = "The interval of the true area does not include the size effect: small contacts may be 2.2 times as hard"
    assert note in " ".join(str(exact).split())
    assert "size effect" not in str(uncertain) + str(measured)
    reduction = float(" ".join(str(exact).split()).split("and the true area ")[1].split(" % smaller")[0]) / 100
    depth = estimate_indentation_depth(
        *(get_mean(exact, name) for name in ("contact_area", "contact_count", "rms_gradient"))
    )
    harder = press_metals(tau0=tau0, hardness=float(0.5 * size_effect_factor(0.5, depth)))
    expected = 1 - get_mean(harder, "contact_area") / get_mean(exact, "contact_area")
    assert reduction == pytest.approx(expected, abs=0.05)


def test_note_on_the_true_area_names_the_load_and_never_states_a_hardness_ratio_of_one():
    text = " ".join(str(press_metals(load="10 MPa, 20 MPa")).split())
    assert "does not include the size effect at " in text
    assert "10 MPa): small contacts may be 2." in text
    assert SizeEffect(20.0, 1.0).hardness_text == "1.24 % harder than large ones"
    assert SizeEffect(1.0, 1.0).hardness_text == "1.2 times as hard as large ones"


def test_size_effect_on_the_lower_limit_of_a_coefficient_is_at_most_the_reduction_of_the_true_area():
    point = press_metals(hardness=0.01, load="5 MPa", tau0="100 MPa").summary().first
    assert point.rules[0].status == STATUS_BULK_SHEAR
    (text,) = (caveat.text for caveat in point.caveats if "as hard as large ones" in caveat.text)
    effect = float(text.split("the coefficient ")[1].removesuffix(" % lower")) / 100
    size_effect = estimate_size_effect(point.values, point.study)
    assert 0 < effect == pytest.approx(size_effect.area_reduction, rel=0.02)


def test_very_hard_metal_has_a_caveat_if_an_indentation_is_given():
    options = {"hardness": 5.0, "tau0": 0.3, "load": "200 MPa"}
    texts = [
        " ".join(caveat.text for caveat in press_metals(**options, indent=indent).summary().first.caveats)
        for indent in (None, "2 um")
    ]
    assert "as hard as large ones" not in texts[0]
    assert "metals as hard as 5 GPa have a smaller indentation size effect than assumed" in texts[1]


@pytest.mark.parametrize("name", ["closure", "closure_stiffness", "normal_stiffness", "unloading_stiffness"])
def test_closure_and_stiffness_are_computed_without_the_size_effect(name):
    without_indent, result = (
        pair_result.at()[name].values.ravel() for pair_result in (press_metals(), press_metals(indent="2 um"))
    )
    assert result == pytest.approx(without_indent, rel=1e-3)


def test_text_about_several_loads_states_the_range_of_their_contact_hardnesses():
    result = press_metals(indent="2 um", load="10 MPa, 20 MPa")
    values = result.at()["contact_hardness"].sel(statistic="mean").values.ravel()
    assert values[0] > 1.02 * values[1]
    min_hardness, max_hardness = (format_with_unit(float(value), "GPa") for value in (values.min(), values.max()))
    assert f"measured 2 µm deep, {min_hardness} to {max_hardness} [" in " ".join(str(result).split())


def test_caveat_about_the_size_effect_and_contact_hardness_use_the_same_depth():
    text = next(
        caveat.text for caveat in press_metals(yield_exponent=0.7).summary().first.caveats if "deep" in caveat.text
    )
    depth = 1e-3 * float(text.split(" nm deep")[0].split()[-1])
    expected = 0.5 * size_effect_factor(np.sqrt(0.2), depth, 2.0)
    assert get_mean(press_metals(yield_exponent=0.7, indent="2 um"), "contact_hardness") == pytest.approx(
        expected, rel=3e-3
    )


@pytest.mark.parametrize(("options", "expected_term"), [
    ({"indent": "0 um"}, "indent must be above 0"), ({"indent": "2 GPa"}, "indent"),
    ({"indent": "2 um", "hardness": None}, "indent needs hardness, because contacts do not yield without a hardness$"),
    ({"indent": "2 um", "work_of_adhesion": "50 mJ/m^2"}, "indent must not be combined with work_of_adhesion"),
    ({"indent": "1..5 um"}, "indent must be one number with a unit of length, not a range, got '1..5 um'"),
])  # fmt: skip
def test_pair_function_rejects_invalid_indentations(options, expected_term):
    defaults = {"junction_growth": None, "yield_exponent": None} if len(options) > 1 else {}
    with pytest.raises(ValueError, match=expected_term):
        press_metals(**defaults | options)


def test_indentation_is_rejected_unless_the_softer_body_is_a_metal():
    options = {"effective_modulus": None, "hardness": None, "upper": "steel", "indent": "2 um"}
    assert press_metals(**options, lower="brass").summary().first.value > 0.2
    with pytest.raises(ValueError, match=r"^indent must not be given for PMMA, because .* metals"):
        press_metals(**options, lower="PMMA")
