"""Test the true area that soft elastic bodies lose under shear."""

from functools import cache

import numpy as np
import pytest
from stiction import pair
from stiction.mechanics.materials import MAX_RUBBER_MODULUS
from stiction.summary.summary import summarize
from stiction.views.sentence import inputs_text
from support.rough_surfaces import rough_maps

pytestmark = pytest.mark.usefixtures("no_companion_files")

SLOPE_TOLERANCE = 5e-3
"""Relative tolerance of sums of parts of a coefficient: through the slopes, τ0 also changes the normal load."""

RUBBER_OPTIONS = {
    "effective_modulus": "2 MPa", "mu0": 0.1, "tau0": "0.1 MPa", "load": "20 kPa", "cutoff": "none", "shifts": 8,
}  # fmt: skip


def press_rubber(**options):
    return pair(*rough_maps(5, rms=0.05, shortest_wavelength=0.4), **RUBBER_OPTIONS | options)


@cache
def press_with_loss(area_loss):
    return press_rubber(area_loss=area_loss)


def get_mean(result, name, **inputs):
    values = result.at(**inputs)[name].sel(statistic="mean")
    return values.sel(sliding="all").item() if "sliding" in values.dims else values.item()


def test_area_loss_under_shear_reduces_the_contribution_of_tau0():
    result_without_loss, result_with_loss = press_with_loss(0), press_with_loss(0.2)
    mu0_part = get_mean(result_without_loss, "mean_friction", tau0=[0.0])
    parts = [get_mean(result, "mean_friction") - mu0_part for result in (result_without_loss, result_with_loss)]
    assert parts[1] == pytest.approx(0.8 * parts[0], rel=SLOPE_TOLERANCE)
    area = get_mean(result_with_loss, "contact_area")
    assert area == get_mean(result_without_loss, "contact_area")
    assert get_mean(result_with_loss, "contact_area_at_onset") == pytest.approx(0.8 * area, rel=1e-12)
    assert get_mean(result_with_loss, "mean_friction", tau0=[0.0]) == mu0_part


@pytest.mark.parametrize(("options", "text"), [
    ({"upper": "PDMS", "lower": "glass", "effective_modulus": None}, "0..0.3"),
    ({"effective_modulus": 0.99 * MAX_RUBBER_MODULUS}, "0..0.3"), ({"effective_modulus": MAX_RUBBER_MODULUS}, None),
    ({"effective_modulus": "2 MPa", "hardness": "5 MPa"}, None), ({"mechanics": "asperities"}, None),
    ({"effective_modulus": "2 MPa", "area_loss": "0.05..0.1"}, "0.05..0.1"),
])  # fmt: skip
def test_soft_elastic_bodies_have_an_area_loss_under_shear_by_default(options, text):
    area_loss = press_rubber(**options | {"shifts": 2}).study.contact.area_loss
    assert (area_loss and area_loss.text) == text


def test_friction_interval_of_soft_bodies_agrees_with_a_brute_force_calculation():
    moduli = np.array([1.4, 1.7, 2.0, 2.3, 2.6])
    # derivatives of the friction coefficient with respect to μ0 and τ0 (1/MPa), at each modulus
    results = [press_rubber(effective_modulus=f"{modulus} MPa", area_loss=0) for modulus in moduli]
    coefficients = np.array(
        [
            [
                get_mean(result_at_modulus, "mean_friction", mu0=[mu0], tau0=[tau0])
                for mu0, tau0 in ((0.1, 0.0), (0.0, 1e-4))
            ]
            for result_at_modulus in results
        ]
    )
    coefficients /= 0.1
    result = press_rubber(
        effective_modulus="2 MPa ± 5 %", mu0="0.1 ± 0.01", tau0="uniform 0.05 MPa .. 0.15 MPa", area_loss="0..0.3"
    )
    random, count = np.random.default_rng(4), 200_000
    modulus, mu0 = (
        value * (1 + deviation * random.standard_normal(count)) for value, deviation in ((2, 0.05), (0.1, 0.1))
    )
    tau0, area_loss = random.uniform(0.05, 0.15, count), random.uniform(0, 0.3, count)
    value, lower, upper = result.at()["mean_friction"].sel(sliding="all").values.ravel()
    log_standard_error = np.log(upper / lower) / (2 * 1.96)
    samples = mu0 * coefficients[2, 0] + tau0 * (1 - area_loss) * np.interp(modulus, moduli, coefficients[:, 1])
    samples *= np.exp(log_standard_error * random.standard_normal(count))
    expected = np.quantile(samples, [0.025, 0.975])
    assert result.interval == pytest.approx(expected, abs=0.03 * (expected[1] - expected[0]))
    assert value == pytest.approx(0.1 * coefficients[2, 0] + 0.1 * 0.85 * coefficients[2, 1], rel=SLOPE_TOLERANCE)


def test_uncertainty_budget_has_a_row_for_the_area_loss_and_the_text_states_the_range_of_the_loss():
    result = press_with_loss(None)
    assert result.budget["input"].iloc[0] == "the area loss under shear"
    assert "elastomer, area loss under shear 0..0.3" in inputs_text(result.summary().first)


def test_percentiles_of_a_single_friction_test_include_the_uncertainty_of_the_area_loss():
    widths = []
    for area_loss in (0.15, "0..0.3"):
        percentiles = press_with_loss(area_loss).at()["friction_percentiles"].sel(sliding="all").values.ravel()
        widths.append(percentiles[2] - percentiles[0])
    assert widths[1] > 1.2 * widths[0]


def test_friction_at_zero_load_includes_the_area_loss():
    options = {
        "work_of_adhesion": "0.1 mJ/m^2",
        "adhesion_range": "5 nm",
        "load": ["0 kPa", "20 kPa"],
        "shifts": 4,
        "onset": 0,
    }
    without_loss, with_loss = (press_rubber(**options, area_loss=area_loss) for area_loss in (0, 0.2))
    for name in ("friction_at_no_load", "tangential_load"):
        value, expected = (
            float(adhesive_result.at(mu0=[0.0])[name].sel(sliding="all", statistic="mean").mean())
            for adhesive_result in (with_loss, without_loss)
        )
        assert value == pytest.approx(0.8 * expected, rel=0.02)  # slopes slightly increase the friction force
    widths = []
    for area_loss in (0.15, "0..0.3"):
        _, lower, upper = (
            press_rubber(**options, area_loss=area_loss).at()["friction_at_no_load"].sel(sliding="all").values.ravel()
        )
        widths.append(upper - lower)
    assert widths[1] > widths[0]


def test_soft_bodies_add_a_caveat_if_their_study_has_no_area_loss():
    result = press_with_loss(0)
    study = result.study.with_changes({"contact.area_loss": None})
    texts, texts_with_loss = (
        " ".join(caveat.text for caveat in summarize(result.at(), summarized_study).points[0].caveats)
        for summarized_study in (study, result.study)
    )
    assert "lose up to 30 % of their true area" in texts
    assert "true area" not in texts_with_loss


@pytest.mark.parametrize(("arguments", "expected_term"), [
    ({"area_loss": -0.1}, "area_loss"), ({"area_loss": 0.95}, "0.9"), ({"area_loss": "0.3..0"}, "smaller"),
    (
        {"area_loss": "-0.1..0.2"},
        r"area_loss must be from 0 to 0\.9, also at the limits of its uncertainty, got '-0\.1\.\.0\.2'",
    ),
    ({"area_loss": 0.1, "hardness": "5 MPa"}, "hardness"), ({"area_loss": float("nan")}, "area_loss"),
    ({"area_loss": 0.1, "mechanics": "asperities"}, "half-space"),
])  # fmt: skip
def test_pair_function_rejects_invalid_area_losses(arguments, expected_term):
    with pytest.raises(ValueError, match=expected_term):
        press_rubber(**arguments)
