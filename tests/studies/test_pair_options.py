"""Options of a pair: one declaration each, from which the command, the function, the study keys and the form follow."""

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
from stiction.studies.input_uncertainty import INPUT_KINDS
from stiction.studies.pair_options import (
    OPTION_GROUPS,
    PAIR_OPTIONS,
    PairOptions,
    format_command_line_name,
    format_python_name,
    read_options,
)
from stiction.studies.values import tables_of

ROOT = Path(__file__).parent.parent.parent


def command():
    group = typer.main.get_command(app)
    return group.get_command(group.context_class(group), "pair")


def test_generated_signatures_match_the_options():
    """Fails if packaging/pair_options.py has not been run after a change of an option."""
    script = ROOT / "packaging/pair_options.py"
    completed = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True, check=False)
    assert completed.returncode == 0, completed.stderr


def test_function_has_a_documented_parameter_for_each_option():
    parameters = inspect.signature(stiction.pair).parameters
    for name, option in PAIR_OPTIONS.items():
        if not option.is_in_python:
            assert name not in parameters
            continue
        assert parameters[format_python_name(name)].default in (None, inspect.Parameter.empty)
        assert f"\n    {format_python_name(name)} : " in stiction.pair.__doc__


def test_command_has_an_option_for_each_option_of_a_pair():
    parameters = {param.name: param for param in command().params}
    for name in PAIR_OPTIONS:
        names = (*parameters[name].opts, parameters[name].metavar)
        assert format_command_line_name(name) in names


def test_groups_share_no_option():
    names = [name for group in OPTION_GROUPS for name in group.model_fields]
    assert len(names) == len(set(names)) == len(PairOptions.model_fields)


@pytest.mark.parametrize("name", [name for name, option in PAIR_OPTIONS.items() if option.key])
def test_option_sets_a_key_that_studies_have(name):
    tables = [Study]
    for part in PAIR_OPTIONS[name].key.split("."):
        fields = [table.model_fields[part] for table in tables if part in table.model_fields]
        assert fields, PAIR_OPTIONS[name].key
        tables = [table for field in fields for table in tables_of(field.annotation)]


def test_placeholders_of_help_and_conditions_name_options():
    for option in PAIR_OPTIONS.values():
        for text in (option.help, *(apply.message for apply in option.applies)):
            assert text.format_map({name: name for name in PAIR_OPTIONS})


@pytest.mark.parametrize("name", INPUT_KINDS)
def test_input_that_may_be_a_range_is_an_option(name):
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
        ({"work_of_adhesion": {}}, "--adhesion must be a number or a text, got {}"),
        ({"upper_material": 3}, "--upper must be a text, got 3"),
        ({"surrogates": 2.5}, "--surrogates must be a number of pairs, or one of none, upper, lower, both, got 2.5"),
        ({"load": None}, "--load must be a number or a text, got None"),
        ({"hardnes": 1}, "--hardnes is no option of a pair; is it hardness?"),
    ],
)
def test_wrong_value_is_reported_by_the_name_on_the_command_line(values, message):
    with pytest.raises(ArgumentError) as caught:
        read_options({"load": "1 mN", **values})
    assert caught.value.with_names(format_command_line_name).startswith(message)


def test_option_without_value_has_its_default():
    options = read_options({"load": 1.0, "shifts": None, "check": False})
    assert all(options.given(name) is None for name in PAIR_OPTIONS if name != "load")


def test_short_help_lists_twelve_options(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    pair = command()
    short = pair.get_help(pair.context_class(pair, info_name="stiction pair"))
    listed = [line.split()[0] for line in short.splitlines() if line.startswith("  --")]
    assert len(short.splitlines()) <= 100
    assert len([name for name in listed if name not in ("--help-all", "--help")]) == 11  # and -o, --output
    assert "--cutoff" not in short


def test_long_help_lists_all_options(capsys):
    with pytest.raises(typer.Exit):
        command().make_context("stiction pair", ["--help-all"])
    text = capsys.readouterr().out
    assert all(format_command_line_name(name) in text for name in PAIR_OPTIONS)


def test_editor_completes_the_options_of_the_function():
    jedi = pytest.importorskip("jedi")
    source = "st.pair(miss"
    names = [each.name for each in jedi.Interpreter(source, [{"st": stiction}]).complete(1, len(source))]
    assert names == ["missing=", "missing_value="]
