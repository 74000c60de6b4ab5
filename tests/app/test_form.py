"""Fields of the app's form, made from the options of a pair."""

import html
import json

import pytest
from stiction.app.form import FIELDS, READING, fields_html, first_option, page_facts, with_labels
from stiction.studies.pair_options import PAIR_OPTIONS, ReadingOptions, list_choices


def test_reading_fields_are_reading_options():
    names = {flag.replace("-", "_") for flag in READING}
    assert names < set(ReadingOptions.model_fields)


@pytest.mark.parametrize("flag", FIELDS)
def test_field_is_in_one_place_of_the_form(flag):
    places = [place for place in ("scan", "more") if f'name="{flag}"' in fields_html(place)]
    assert places == ([FIELDS[flag].place] if FIELDS[flag].place in ("scan", "more") else [])


def test_choices_of_fields_are_values_of_their_options():
    for name, option in PAIR_OPTIONS.items():
        if option.field and option.field.choices and list_choices(name):
            assert {value for value, _ in option.field.choices} <= set(list_choices(name))


def test_units_are_added_to_bare_numbers_of_quantities_alone():
    numbers = json.loads(html.unescape(page_facts()))
    assert numbers["units"]["hardness"] == " GPa"
    assert set(numbers["units"]) | set(numbers["texts"]) <= set(FIELDS)
    assert not set(numbers["units"]) & set(numbers["texts"])


@pytest.mark.parametrize(
    ("message", "labelled", "option"),
    [
        ("--hardness must be above 0, got '0 GPa'", "\"hardness\" must be above 0, got '0 GPa'", "hardness"),
        (
            "--adhesion is for --mechanics half-space",
            '"work of adhesion" is for "contact model" half-space',
            "adhesion",
        ),
        ("--offsets is for lines; for maps give --lines", "--offsets is for lines; for maps give --lines", ""),
        ("a.csv: cannot be read", "a.csv: cannot be read", ""),
    ],
)
def test_messages_name_fields_by_their_labels(message, labelled, option):
    assert with_labels(message) == labelled
    assert first_option(message) == option
