"""Tests of estimates: the interval determines the printed digits, and the magnitude determines the unit."""

import json
import math
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from stiction._estimate import Estimate, Interval, extend_intervals
from stiction._number_format import to_json


@pytest.mark.parametrize(
    ("value", "lower", "upper", "text"),
    [
        (0.2093, 0.1911, 0.2302, "0.21 [0.19, 0.23]"),
        (0.1147, 0.1136, 0.1158, "0.115 [0.114, 0.116]"),
        (0.1147, 0.1141, 0.1149, "0.1147 [0.1141, 0.1149]"),
        (0.304, 0.302, 0.306, "0.304 [0.302, 0.306]"),
        (0.2, 0.2 - 1e-6, 0.2 + 1e-6, "0.2"),
        (0.0, 0.0, 0.0, "0"),
        (0.2, 0.15, math.inf, "0.20 [0.15, ∞)"),
        (0.2093, math.nan, math.nan, "0.21"),
        (math.nan, 0.1, 0.2, "none"),
    ],
)
def test_estimate_is_rounded_to_the_first_digit_of_its_half_width(value, lower, upper, text):
    estimate = Estimate(value, lower, upper)
    assert str(estimate) == estimate.text(1) == text


@pytest.mark.parametrize(
    ("value", "lower", "upper", "text"),
    [
        (0.1552, 0.07024, 0.3431, "0.16 [0.07, 0.34]"),
        (2.188, 1.192, 4.013, "2.2 [1.2, 4.0]"),
        (0.123456, 0.1234, 0.1235, "0.1235 [0.1234, 0.1235]"),
        (1170.0, 970.0, 1380.0, "1170 [970, 1380]"),
        (1.0, 1.0, 1.0, "1"),
        (math.nan, math.nan, math.nan, "none"),
    ],
)
def test_estimate_in_a_table_is_rounded_to_the_second_digit_of_its_half_width(value, lower, upper, text):
    estimate = Estimate(value, lower, upper)
    assert estimate.text() == estimate.table_text == text


def test_missing_interval_of_an_estimate_is_stated_only_in_tables():
    estimate = Estimate(0.5)
    assert (estimate.text(), estimate.table_text) == ("0.5", "0.5 no interval")


def test_printed_interval_has_the_word_to_between_its_limits():
    assert str(Interval(0.0413, 0.188)) == "0.04 to 0.19"
    assert str(Interval(0.2192, 0.2213)) == "0.219 to 0.221"
    assert str(Interval(0.2, math.inf)) == "0.2 to ∞"
    assert str(Interval(0.2, 0.2)) == "0.2000"


def test_unit_prefix_of_an_estimate_is_determined_by_its_value():
    assert Estimate(0.25, 0.125, 0.5, unit="um").in_prefixed_unit() == Estimate(250.0, 125.0, 500.0, unit="nm")
    assert Estimate(0.25, 0.125, 0.5).in_prefixed_unit("%") == Estimate(25.0, 12.5, 50.0, unit="%")
    # The value is rounded before the unit is chosen, so it is not printed as 10000 mN/µm.
    stiffness = Estimate(9999.0, 9998.0, 10_000.0, unit="mN/um", name="stiffness", kind="mean")
    assert stiffness.in_prefixed_unit() == Estimate(9.999, 9.998, 10.0, unit="N/µm", name="stiffness", kind="mean")
    assert Estimate(3.0, 2.0, 4.0).in_prefixed_unit("1") == Estimate(3.0, 2.0, 4.0, unit="")
    assert [Estimate(value).in_prefixed_unit("mN").unit for value in (math.nan, 0.0, 2e-6)] == ["mN", "mN", "nN"]


def test_estimate_extended_to_another_estimate_includes_both_intervals_if_both_exist():
    estimate = Estimate(0.2, 0.1, 0.3)
    assert estimate.extended_to(Estimate(0.25, 0.15, 0.4)) == Estimate(0.2, 0.1, 0.4)
    assert estimate.extended_to(Estimate(0.25)) == estimate


def test_extending_an_estimate_without_interval_adds_no_interval():
    assert not Estimate(0.2).extended_to(Estimate(0.3, 0.25, 0.4)).has_interval


def test_interval_is_extended_to_the_outermost_limits_of_several_other_intervals():
    own_intervals = [[1.0, 2.0], [np.nan, np.nan], [1.0, np.inf]]
    extended = extend_intervals(own_intervals, [[0.5, 1.5]] * 3, [[np.nan, 3.0], [1.0, 2.0], [2.0, 4.0]])
    np.testing.assert_array_equal(extended, [[0.5, 3.0], [np.nan, np.nan], [0.5, np.inf]])
    assert Interval(1.0, 2.0).extended_to((1.5, 3.0), (1.2, 1.2)) == Interval(1.0, 3.0)


def test_estimate_is_immutable():
    with pytest.raises(FrozenInstanceError):
        Estimate(0.2).value = 0.3


@pytest.mark.parametrize(
    "estimate",
    [
        Estimate(3.0, 2.0, 4.0, name="closure", unit="um", kind="mean"),
        Estimate(3.0, 2.0, math.inf, kind="combined"),
        Estimate(3.0),
    ],
)
def test_estimate_read_from_its_json_object_has_the_same_interval(estimate):
    read_estimate = Estimate.from_record(json.loads(to_json(estimate.to_record())))
    assert repr(read_estimate) == repr(estimate)  # compare texts, because two NaN limits are not equal
