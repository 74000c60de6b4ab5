"""Test the declarations of pair options and what is generated from them: command, function and study keys."""

import inspect
import subprocess
import sys
from pathlib import Path

import pytest
import stiction
import typer
from stiction import Study
from stiction._errors import ArgumentError
from stiction.cli.application import app
from stiction.study.input_distributions import INPUT_KINDS
from stiction.study.pair_options import (
    OPTION_GROUPS,
    PAIR_OPTIONS,
    PairOptions,
    format_command_line_name,
    format_python_name,
    validate_option_values,
)
from stiction.study.values import find_section_classes

ROOT = Path(__file__).parent.parent.parent
RUFF_PATH = Path(sys.executable).with_name("ruff")


def pair_command():
    group = typer.main.get_command(app)
    return group.get_command(group.context_class(group), "pair")


@pytest.mark.skipif(not RUFF_PATH.exists(), reason="ruff, which formats the generated code, is installed by ./dev lint")
def test_generated_signatures_of_the_pair_function_match_the_pair_options():
    """Check that packaging/pair_options.py was run after the last change of an option."""
    script = ROOT / "packaging/pair_options.py"
    completed = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True, check=False)
    assert completed.returncode == 0, completed.stderr


def test_pair_function_documents_a_parameter_for_every_option():
    parameters = inspect.signature(stiction.pair).parameters
    for name, option in PAIR_OPTIONS.items():
        if not option.is_in_python:
            assert name not in parameters
            continue
        assert parameters[format_python_name(name)].default in (None, inspect.Parameter.empty)
        assert f"\n    {format_python_name(name)} : " in stiction.pair.__doc__


def test_pair_command_accepts_every_declared_option():
    parameters = {param.name: param for param in pair_command().params}
    for name in PAIR_OPTIONS:
        names = (*parameters[name].opts, parameters[name].metavar)
        assert format_command_line_name(name) in names


def test_groups_of_pair_options_are_disjoint_and_complete():
    names = [name for group in OPTION_GROUPS for name in group.model_fields]
    assert len(names) == len(set(names)) == len(PairOptions.model_fields)


@pytest.mark.parametrize("name", [name for name, option in PAIR_OPTIONS.items() if option.key])
def test_pair_option_refers_to_an_existing_key_of_a_study(name):
    classes = [Study]
    for key_part in PAIR_OPTIONS[name].key.split("."):
        fields = [
            section_class.model_fields[key_part] for section_class in classes if key_part in section_class.model_fields
        ]
        assert fields, PAIR_OPTIONS[name].key
        classes = [section_class for field in fields for section_class in find_section_classes(field.annotation)]


def test_placeholders_in_texts_of_pair_options_are_option_names():
    for option in PAIR_OPTIONS.values():
        for text in (option.help, *(apply.message for apply in option.applies)):
            assert text.format_map({name: name for name in PAIR_OPTIONS})


@pytest.mark.parametrize("name", INPUT_KINDS)
def test_uncertain_input_has_a_pair_option_of_the_same_name(name):
    assert name in PAIR_OPTIONS


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"mechanics": "halfspace"}, "--mechanics must be half-space or asperities, got 'halfspace'; did you mean"),
        ({"shifts": 0}, "--shifts must be a whole number of at least 1, got 0"),
        ({"shifts": "2.5"}, "--shifts must be a whole number of at least 1, got '2.5'"),
        ({"shifts": True}, "--shifts must be a whole number of at least 1, got True"),
        ({"seed": -1}, "--seed must be a whole number of at least 0, got -1"),
        ({"rotate": float("nan")}, "--rotate must be a finite number of degrees, got nan"),
        ({"hardness": [1, 2]}, "--hardness must be one value, got [1, 2]"),
        ({"work_of_adhesion": {}}, "--adhesion must be a number or a string, got {}"),
        ({"upper_material": 3}, "--upper must be a string, got 3"),
        ({"surrogates": 2.5}, "--surrogates must be a number of pairs, or one of none, upper, lower, both, got 2.5"),
        ({"load": None}, "--load must be a number or a string, got None"),
        ({"hardnes": 1}, "--hardnes is no option of a pair; is it hardness?"),
    ],
)
def test_error_about_an_invalid_value_names_the_command_line_option(values, message):
    with pytest.raises(ArgumentError) as error_info:
        validate_option_values({"load": "1 mN", **values})
    assert error_info.value.translated_message(format_command_line_name).startswith(message)


def test_pair_options_with_value_none_or_false_are_treated_as_not_given():
    options = validate_option_values({"load": 1.0, "shifts": None, "check": False})
    assert all(options.option_value(name) is None for name in PAIR_OPTIONS if name != "load")


def test_short_help_of_the_pair_command_lists_thirteen_options_but_not_the_cutoff(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    pair = pair_command()
    help_text = pair.get_help(pair.context_class(pair, info_name="stiction pair"))
    listed_options = [line.split()[0] for line in help_text.splitlines() if line.startswith("  --")]
    assert len(help_text.splitlines()) <= 100
    listed_options = [name for name in listed_options if name not in ("--help-all", "--help")]
    assert len(listed_options) == 12  # The thirteenth option, --output, is listed as -o.
    assert "--cutoff" not in help_text


def test_long_help_of_the_pair_command_lists_all_options(capsys):
    with pytest.raises(typer.Exit):
        pair_command().make_context("stiction pair", ["--help-all"])
    text = capsys.readouterr().out
    assert all(format_command_line_name(name) in text for name in PAIR_OPTIONS)


def test_jedi_completes_options_of_the_pair_function():
    jedi = pytest.importorskip("jedi")
    source = "st.pair(miss"
    names = [completion.name for completion in jedi.Interpreter(source, [{"st": stiction}]).complete(1, len(source))]
    assert names == ["missing=", "missing_value="]
