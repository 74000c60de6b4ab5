"""Tests of the form of the app, which has a field for each option of `pair`."""

import html
import json

import numpy as np
import pytest
from stiction.app.form import (
    FILE_READING_FLAGS,
    FORM_FIELDS_BY_FLAG,
    fields_html,
    find_first_option_name,
    page_data_json,
    parse_reading_options,
    replace_option_names,
    replace_option_names_in_caveats,
    replace_option_names_in_preview,
)
from stiction.app.preview import preview_scan
from stiction.study.pair_options import PAIR_OPTIONS, FileReadingOptions, list_option_choices


def test_form_fields_of_reader_options_have_the_names_of_these_options():
    names = {flag.replace("-", "_") for flag in FILE_READING_FLAGS}
    assert names < set(FileReadingOptions.model_fields)


@pytest.mark.parametrize("flag", FORM_FIELDS_BY_FLAG)
def test_form_shows_each_field_in_only_one_section(flag):
    sections = [place for place in ("scan", "more") if f'name="{flag}"' in fields_html(place)]
    assert sections == (
        [FORM_FIELDS_BY_FLAG[flag].place] if FORM_FIELDS_BY_FLAG[flag].place in ("scan", "more") else []
    )


def test_choices_of_a_form_field_are_valid_values_of_its_option():
    for name, option in PAIR_OPTIONS.items():
        if option.field and option.field.choices and list_option_choices(name):
            assert {value for value, _ in option.field.choices} <= set(list_option_choices(name))


def test_form_has_default_units_for_quantities_but_not_for_text_fields():
    page_data = json.loads(html.unescape(page_data_json()))
    assert page_data["units"]["hardness"] == " GPa"
    assert set(page_data["units"]) <= set(FORM_FIELDS_BY_FLAG)
    assert set(page_data["shared"]) == {"missing", "outliers"}


@pytest.mark.parametrize(
    ("message", "expected_message", "option"),
    [
        ("--hardness must be above 0, got '0 GPa'", "\"hardness\" must be above 0, got '0 GPa'", "hardness"),
        (
            "--adhesion is for --mechanics half-space",
            '"work of adhesion" is for "contact model": half-space (exact)',
            "adhesion",
        ),
        ("--missing-value -999 marks points", '"missing value" -999 marks points', "missing-value"),
        ("--offsets is for lines; for maps give --lines", "--offsets is for lines; for maps give --lines", ""),
        (
            'a.csv lacks 3 heights; missing="mask" (--missing mask) uses only measured points',
            'a.csv lacks 3 heights; "missing points": leave them out uses only measured points',
            "",
        ),
        ("--crop of UPPER must be", '"crop" of UPPER must be', "crop"),
        ("a.csv: cannot be read", "a.csv: cannot be read", ""),
    ],
)
def test_option_names_in_error_messages_are_replaced_with_form_labels(message, expected_message, option):
    assert replace_option_names(message) == expected_message
    assert find_first_option_name(message) == option


def test_option_names_in_caveats_are_replaced_with_form_labels():
    caveats = [{"text": "adhesion is neglected", "remedy": "specify --adhesion or --lines", "severity": "caution"}]
    assert replace_option_names_in_caveats({"value": 1, "caveats": caveats}) == {
        "value": 1,
        "caveats": [
            {"text": "adhesion is neglected", "remedy": 'specify "work of adhesion" or --lines', "severity": "caution"}
        ],
    }


def test_reading_options_of_the_form_become_arguments_of_the_reader():
    texts = {"spacing": "1 um,2 um", "missing-value": "-9999", "unit": "", "load": "1 mN"}
    assert parse_reading_options(texts) == {"spacing": ("1 um", "2 um"), "missing_value": "-9999"}


def test_preview_refers_to_form_fields_and_choices_by_their_labels(tmp_path):
    heights = np.random.default_rng(1).standard_normal((16, 16))
    reading_options = parse_reading_options({"unit": "um", "spacing": "1 um", "missing": ""})
    np.save(tmp_path / "missing.npy", np.where(heights > 2, np.nan, heights))
    preview = preview_scan(f"{tmp_path / 'missing.npy'}", reading_options)
    error_message = replace_option_names_in_preview(preview)["error"]
    labels = dict(FORM_FIELDS_BY_FLAG["missing"].choices)
    assert f'"missing points": {labels["mask"]}' in error_message
    assert f'"missing points": {labels["interpolate"]}' in error_message
    np.save(tmp_path / "code.npy", np.where(heights > 1.5, -999, heights))
    preview = preview_scan(f"{tmp_path / 'code.npy'}", reading_options)
    warning = replace_option_names_in_preview(preview)["warning"]
    assert '"missing value" -999' in warning
    assert "--" not in error_message + warning
    assert "=" not in error_message + warning


@pytest.mark.parametrize("choice", [value for value, _ in FORM_FIELDS_BY_FLAG["missing"].choices])
def test_preview_accepts_every_form_choice_for_missing_points(choice, tmp_path):
    heights = np.random.default_rng(1).standard_normal((16, 16))
    heights[5, 5:8] = np.nan
    np.save(tmp_path / "missing.npy", heights)
    reading_options = parse_reading_options({"unit": "um", "spacing": "1 um", "missing": choice})
    record = preview_scan(f"{tmp_path / 'missing.npy'}", reading_options)
    assert record["points"] == 256
