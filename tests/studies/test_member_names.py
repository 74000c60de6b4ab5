"""Tests of the names of members in texts for users."""

import pytest
from stiction import Study
from stiction.studies.member_names import count_members_text, find_member_names
from support.synthetic_results import measured_study

STUDIES_BY_PLURAL = {
    "repetitions": Study(),
    "positions": measured_study(),
    "pairs of surrogates": measured_study(press="surrogates"),
    "members": measured_study().with_changes({"surfaces.surrogates": 2}),
}


@pytest.mark.parametrize("plural", STUDIES_BY_PLURAL)
def test_members_are_named_by_the_surfaces_of_the_study(plural):
    study = STUDIES_BY_PLURAL[plural]
    singular = find_member_names(study)[0]
    assert (count_members_text(study, 1), count_members_text(study, 2.0)) == (f"1 {singular}", f"2 {plural}")


def test_members_of_pressed_lines_are_positions():
    assert find_member_names(measured_study(press="lines"))[1] == "positions"
