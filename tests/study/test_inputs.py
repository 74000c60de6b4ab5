"""Test the entries of a study for inputs that may be uncertain."""

import numpy as np
import pytest
from stiction import Study, pair, self_affine_surface
from stiction.study.study import parse_study
from stiction.study.uncertain_inputs import find_yield_exponent
from stiction.study.values import StudyError

HARD_CONTACT = {"contact.mechanics": "half-space", "contact.hardness": "1 GPa"}


@pytest.mark.parametrize(("entry", "central", "low", "high"), [
    ("uniform 1 .. 1.5", 1.25, 1.0, 1.5), (1.2, 1.2, 1.2, 1.2), ("1.2", 1.2, 1.2, 1.2), ("1.1..1.3", 1.2, 1.1, 1.3),
])  # fmt: skip
def test_yield_exponent_of_a_study_is_a_number_or_a_range(entry, central, low, high):
    study = Study().with_changes(HARD_CONTACT | {"contact.yield_exponent": entry})
    exponent = find_yield_exponent(parse_study(study.to_toml(), "text"))
    assert (study.contact.yield_exponent, exponent.value) == (central, central)
    assert (exponent.low, exponent.high) == (low, high)


@pytest.mark.parametrize(("changes", "reason"), [
    ({"contact.yield_exponent": "0.2..1.2"}, "must be from 0.5 to 10, including its uncertainty, got '0.2..1.2'"),
    ({"contact.yield_exponent": 11}, "must be from 0.5 to 10, including its uncertainty, got 11"),
    ({"contact.yield_exponent": True}, "must be a number, or a text with a range or an uncertainty, got True"),
    ({"contact.yield_exponent": 1.2, "contact.work_of_adhesion": "50 mJ/m^2"},
     "must not be given if work_of_adhesion is above 0, because the contacts then do not yield"),
])  # fmt: skip
def test_study_rejects_an_impossible_yield_exponent(changes, reason):
    with pytest.raises(StudyError) as caught:
        Study().with_changes(HARD_CONTACT | changes)
    assert caught.value.faults == (("contact.yield_exponent", reason),)


def compute_pair(**options):
    maps = [self_affine_surface(seed, hurst_exponent=0.8, rms=0.02, shape=(40, 40), spacing=0.1) for seed in (1, 2)]
    values = {"load": "10 MPa", "mu0": 0.2, "effective_modulus": "80 GPa", "cutoff": "none", "shifts": 1, "onset": 0}
    return pair(*maps, **values | options)


def test_yielding_pair_has_a_range_of_the_yield_exponent_by_default():
    assert compute_pair(hardness="2 GPa").study.contact.yield_exponent.text == "uniform 1 .. 1.5"
    assert compute_pair(hardness="2 GPa", yield_exponent=1.1).study.contact.yield_exponent == 1.1
    assert compute_pair().study.contact.yield_exponent is None
    adhesion = {"work_of_adhesion": "50 mJ/m^2", "adhesion_range": "20 nm"}
    assert compute_pair(hardness="4 GPa", **adhesion).study.contact.yield_exponent is None


@pytest.mark.parametrize(("options", "reason"), [
    ({"hardness": "2 GPa", "yield_exponent": "0..1"}, "yield_exponent must be from 0.5 to 10"),
    ({"yield_exponent": 1.2}, "yield_exponent needs hardness"),
])  # fmt: skip
def test_pair_rejects_an_impossible_yield_exponent(options, reason):
    with pytest.raises(ValueError, match=reason):
        compute_pair(**options)


def test_values_of_an_input_with_equal_numbers_differ_if_their_ranges_differ():
    first, second = (
        Study().with_changes(HARD_CONTACT | {"contact.yield_exponent": text}) for text in ("1.1..1.3", "1..1.4")
    )
    assert first.contact.yield_exponent == 1.2 == second.contact.yield_exponent
    assert first != second
    assert np.isclose(find_yield_exponent(first).quantile(0.975), 1.3)
