"""Tests of the words that output uses for members."""

import pytest
from stiction import Study
from support.synthetic_results import measured_study

STUDIES_BY_PLURAL = {
    "repetitions": Study(),
    "positions": measured_study(),
    "pairs of surrogates": measured_study(press="surrogates"),
    "members": measured_study().with_changes({"surfaces.surrogates": 2}),
}


@pytest.mark.parametrize("plural", STUDIES_BY_PLURAL)
def test_output_calls_members_pairs_or_positions_depending_on_the_kind_of_study(plural):
    study = STUDIES_BY_PLURAL[plural]
    singular = study.member_names.singular
    assert (study.member_names.with_count(1), study.member_names.with_count(2.0)) == (f"1 {singular}", f"2 {plural}")


def test_pairs_are_called_positions_if_lines_of_maps_are_pressed():
    assert measured_study(press="lines").member_names.plural == "positions"
