"""Test uncertain inputs: parsing of text, distributions and samples, and rejection of bad text."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.stats import qmc
from stiction.study.input_distributions import (
    SOBOL_GENERATORS,
    UNCERTAINTY_PATTERN,
    draw_input_samples,
    generate_sobol_points,
    parse_study_input,
    parse_uncertain_input,
)


@pytest.mark.parametrize(
    ("text", "kind", "ends", "distribution"),
    [
        ("0.2±0.02", "", (0.1608, 0.2392), "normal"),
        ("1.1 GPa +- 10 %", "pressure", (0.8844, 1.3156), "normal"),
        ("20..80 MPa", "pressure", (0.02, 0.08), "log-normal"),
        ("500 MPa .. 1.5 GPa", "pressure", (0.5, 1.5), "log-normal"),
        ("0.15..0.25", "", (0.15, 0.25), "normal"),
        ("uniform 0.1..0.3", "", (0.105, 0.295), "uniform"),
        ("0..50 MPa", "pressure", (0.00125, 0.04875), "uniform"),
        (0.3, "", (0.3, 0.3), "exact"),
    ],
)
@pytest.mark.usefixtures("all_input_samples")
def test_distribution_of_an_input_has_95_percent_of_its_samples_between_the_limits(
    text, kind, ends, distribution
) -> None:
    result = parse_uncertain_input("input", text, kind)
    assert result.distribution == distribution
    assert result.quantile([0.025, 0.975]) == pytest.approx(ends, rel=1e-3)
    values = draw_input_samples({"input": result})["input"]
    assert np.quantile(values, [0.025, 0.975]) == pytest.approx(ends, rel=0.01)


@pytest.mark.parametrize("count", [1, 2, 4096])
def test_sobol_points_equal_points_from_scipy(count) -> None:
    for dimensions in range(1, len(SOBOL_GENERATORS) + 2):
        expected_points = qmc.Sobol(dimensions, rng=np.random.default_rng(2016)).random(count)
        points = generate_sobol_points(dimensions, count, seed=2016)
        np.testing.assert_array_equal(points, np.clip(expected_points, 1e-9, 1 - 1e-9))


def test_samples_of_mu0_are_not_negative() -> None:
    assert draw_input_samples({"mu0": parse_uncertain_input("mu0", "0.01±0.02")})["mu0"].min() >= 0


@pytest.mark.parametrize(
    ("text", "kind", "pattern"),
    [
        ("0.2 MPa±0.02", "", "mu0 must be a number"),
        ("80..20 MPa", "pressure", "smaller to a larger"),
        ("20..80", "pressure", "unit of pressure"),
        ("-5..3 MPa", "pressure", "not negative"),
        ("nan", "", "finite"),
        ("0.2±0", "", "above 0"),
        (None, "", "must be a number"),
    ],
)
def test_invalid_value_of_an_uncertain_input_is_rejected(text, kind, pattern) -> None:
    with pytest.raises(ValueError, match=pattern):
        parse_uncertain_input("mu0", text, kind)


@pytest.mark.parametrize("text", ["150 ± 10 % HV", "150±10% HV", "150 HV ± 10 %", "150 HV10 ± 10 %", "150 ± 15 HV"])
def test_relative_uncertainty_of_hardness_is_accepted(text: str) -> None:
    result = parse_uncertain_input("hardness", text, "hardness")
    value = parse_uncertain_input("hardness", "150 HV", "hardness").value
    assert (result.value, result.low, result.high) == pytest.approx((value, 0.804 * value, 1.196 * value), rel=1e-4)


@pytest.mark.parametrize("text", ["59.9..60.1 HRC", "60±0.05 HRC", "60 HRC ± 0.05", "60 HRC ± 0.1 %"])
def test_range_of_a_rockwell_hardness_includes_the_uncertainty_of_its_conversion(text: str) -> None:
    plain_number, result = (parse_uncertain_input("hardness", item, "hardness") for item in ("60 HRC", text))
    assert (result.low, result.high) == pytest.approx((plain_number.low, plain_number.high), rel=0.01)
    assert result.high - result.low >= plain_number.high - plain_number.low - 1e-3
    ranged_input = parse_uncertain_input("hardness", "55..65 HRC", "hardness")
    limits = [parse_uncertain_input("hardness", f"{end} HRC", "hardness").value for end in (55, 65)]
    assert ranged_input.low < limits[0] < limits[1] < ranged_input.high


@pytest.mark.parametrize("text", ["150HV", "150 HV10", "150 HV 10", "150 HV0.5", "150 HV 0.5"])
def test_vickers_hardness_can_be_given_with_its_test_load(text: str) -> None:
    assert (
        parse_uncertain_input("hardness", text, "hardness").value
        == parse_uncertain_input("hardness", "150 HV", "hardness").value
    )
    assert UNCERTAINTY_PATTERN.search(text)


@pytest.mark.parametrize(
    ("name", "text", "quoted_text"),
    [
        ("poisson", "0.3±0.5", "0.3±0.5"), ("poisson", "0.4..0.6", "0.4..0.6"), ("mu0", "0.1..inf", "'inf'"),
        ("mu0", "0.2±1e308", "1e308"), ("tau0", "50 MPa ± 1e-320 %", "at least 1e-09"),
        ("hardness", "70±1 HRC", "70±1 HRC"), ("hardness", "1e300 HV", "1e300"),
    ],
)  # fmt: skip
def test_impossible_values_of_study_inputs_are_rejected(name: str, text: str, quoted_text: str) -> None:
    with pytest.raises(ValueError, match=re.escape(quoted_text)):
        parse_study_input(name, text)


def test_samples_of_poisson_ratio_do_not_exceed_one_half() -> None:
    values = parse_study_input("poisson", "0.45±0.02").quantile(np.linspace(1e-6, 1 - 1e-6, 1001))
    assert 0 < values.min() < values.max() == 0.5
