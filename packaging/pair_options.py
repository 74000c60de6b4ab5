#!/usr/bin/env python3
"""Write the parameters of `stiction.pair` and of the commands, generated from the declared options of a pair.

pair_options.py write the files pair_options.py --check end with status 1 if a file differs from what would be written
"""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
import textwrap
from pathlib import Path

from stiction.study import pair_options
from stiction.study.pair_options import (
    DEFAULT_UNITS,
    OPTION_GROUPS,
    PAIR_OPTIONS,
    FileReadingOptions,
    PairOptions,
    format_python_name,
    list_option_choices,
)

ROOT = Path(__file__).resolve().parents[1]
PAIR_FUNCTION_FILE = ROOT / "python/stiction/measured_pair.py"
PAIR_COMMAND_FILE = ROOT / "python/stiction/cli/pair.py"
CHARACTERISE_COMMAND_FILE = ROOT / "python/stiction/cli/characterise.py"
LINE_LENGTH = 120
BODY_OPTION_NAMES = ("upper", "lower")
PYTHON_OPTION_NAMES = [name for name, option in PAIR_OPTIONS.items() if option.is_in_python]

DOCSTRING_TYPES = {
    "BodyScans": "str, path, Profile, Surface, JoinedSpectrum or array, or several",
    "GapInput": "str, path, Surface or array",
    "InterfaceInput": "str, path or Interface",
    "QuantityInput": "str or float",
    "QuantityInputs": "str or float, or several",
    "PositiveInteger": "int",
    "Seed": "int",
    "Degrees": "float",
    "Positions": "str or float, or several",
    "SurrogateChoice": "int or str",
    "str": "str",
    "bool": "bool",
}
"""Types as docstrings print them, by the name of the type in the declaration of an option."""


def option_types() -> dict[str, str]:
    """Return the declared type of each option of a pair, such as "Value | None"."""
    types = {}
    groups = [group.__name__ for group in OPTION_GROUPS]
    for node in ast.parse(inspect.getsource(pair_options)).body:
        if not isinstance(node, ast.ClassDef) or node.name not in groups:
            continue
        for statement in node.body:
            if (
                isinstance(statement, ast.AnnAssign)
                and isinstance(statement.target, ast.Name)
                and statement.target.id in PAIR_OPTIONS
            ):
                annotation = statement.annotation
                assert isinstance(annotation, ast.Subscript)
                assert isinstance(annotation.slice, ast.Tuple)
                types[statement.target.id] = ast.unparse(annotation.slice.elts[0])
    return types


def render_default_assignment(name: str) -> str:
    """Return the default of an option as an assignment, or "" if the option is required."""
    field = PairOptions.model_fields[name]
    return "" if field.is_required() else f" = {field.default!r}"


def render_function_parameters() -> str:
    """Return the parameters of `stiction.pair` as source text, with the two bodies first."""
    types = option_types()
    lines = [
        f"    {format_python_name(name)}: {types[name]}{render_default_assignment(name)},\n"
        for name in PYTHON_OPTION_NAMES
    ]
    body_parameters = [line for line in lines if line.lstrip().startswith(("first:", "second:"))]
    return "".join([*body_parameters, "    *,\n", *(line for line in lines if line not in body_parameters)])


def render_parameter_descriptions() -> str:
    """Return the parameter section of a docstring: the two bodies first, then the options by group."""
    types = option_types()
    ordered_names = [
        "upper",
        "lower",
        *(
            name
            for group in OPTION_GROUPS
            for name in group.model_fields
            if name in PYTHON_OPTION_NAMES and name not in BODY_OPTION_NAMES
        ),
    ]
    lines = []
    for name in ordered_names:
        option, declared_type = PAIR_OPTIONS[name], types[name].removesuffix(" | None")
        choices = ", ".join(f'"{choice}"' for choice in list_option_choices(name))
        type_text = (
            f"{{{choices}}}" if choices and declared_type != "InterfaceInput" else DOCSTRING_TYPES[declared_type]
        )
        unit = f", {DEFAULT_UNITS[option.kind]}" if option.kind else ""
        optional_text = (
            "" if PairOptions.model_fields[name].is_required() or name in BODY_OPTION_NAMES else ", optional"
        )
        default_sentence = f" By default {option.default_text}." if option.default_text else ""
        text = option.help.format_map(PythonNamesOfOptions()) + default_sentence
        lines.append(f"    {format_python_name(name)} : {type_text}{unit}{optional_text}")
        lines += textwrap.wrap(text, LINE_LENGTH, initial_indent=" " * 8, subsequent_indent=" " * 8)
    return "\n".join(lines) + "\n"


class PythonNamesOfOptions(dict[str, str]):
    """Mapping that replaces the placeholders in a help line by the Python names of options."""

    def __missing__(self, name: str) -> str:
        return f"`{format_python_name(name)}`"


def render_call_arguments() -> str:
    """Return the arguments with which `stiction.pair` calls `PairOptions`, as source text."""
    return "".join(f"                {name}={format_python_name(name)},\n" for name in PYTHON_OPTION_NAMES)


def render_command_parameters() -> str:
    """Return the parameters of the command `pair` as source text."""
    lines = []
    for name, option in PAIR_OPTIONS.items():
        if name in BODY_OPTION_NAMES:
            continue
        is_switch = PairOptions.model_fields[name].annotation is bool
        value_type = "bool" if is_switch else "list[str]" if option.is_repeatable else "str"
        value_type += "" if is_switch or not render_default_assignment(name) else " | None"
        lines.append(f'    {name}: Annotated[{value_type}, pair_option("{name}")]{render_default_assignment(name)},\n')
    return "".join(lines)


def render_reader_parameters() -> str:
    """Return the parameters of the command `characterise` that describe how files are read, as source text."""
    lines = []
    for name in FileReadingOptions.model_fields:
        repeatable_argument = ", repeatable=False" if PAIR_OPTIONS[name].is_repeatable else ""
        lines.append(f'    {name}: Annotated[str | None, pair_option("{name}"{repeatable_argument})] = None,\n')
    return "".join(lines)


def replace_section(text: str, start: str, end: str, new_section: str) -> str:
    """Replace the section of a text between the lines `start` and `end`."""
    text_before_start, found_start, text_after_start = text.partition(start)
    _, found_end, text_after_end = text_after_start.partition(end)
    assert found_start, start
    assert found_end, end
    return text_before_start + start + new_section + end + text_after_end


def generate_file_texts() -> dict[Path, str]:
    """Return the new text of each file with generated sections, by path."""
    pair_function_text = PAIR_FUNCTION_FILE.read_text("utf-8")
    pair_function_text = replace_section(
        pair_function_text, "def pair(\n", "    directory: str", render_function_parameters()
    )
    pair_function_text = replace_section(
        pair_function_text, "    Parameters\n    ----------\n", "    directory : path", render_parameter_descriptions()
    )
    pair_function_text = replace_section(
        pair_function_text, "options = PairOptions(\n", "            )\n", render_call_arguments()
    )
    pair_command_text = PAIR_COMMAND_FILE.read_text("utf-8")
    pair_command_text = replace_section(
        pair_command_text, "    lower: LowerFileArgument = None,\n    *,\n", "    workers:", render_command_parameters()
    )
    characterise_text = CHARACTERISE_COMMAND_FILE.read_text("utf-8")
    characterise_text = replace_section(
        characterise_text, 'help="Measured profiles or surfaces.")],\n    *,\n', "    row:", render_reader_parameters()
    )
    texts = {
        PAIR_FUNCTION_FILE: pair_function_text,
        PAIR_COMMAND_FILE: pair_command_text,
        CHARACTERISE_COMMAND_FILE: characterise_text,
    }
    return {path: format_code(text) for path, text in texts.items()}


def format_code(text: str) -> str:
    """Format a text with ruff."""
    ruff = Path(sys.executable).with_name("ruff")
    command = [str(ruff), "format", "--stdin-filename", str(PAIR_FUNCTION_FILE), "-"]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True, cwd=ROOT).stdout


def main() -> None:
    """Write the files, or with --check compare them with the generated text."""
    outdated_files = [path for path, text in generate_file_texts().items() if path.read_text("utf-8") != text]
    if "--check" in sys.argv:
        names = ", ".join(str(path.relative_to(ROOT)) for path in outdated_files)
        sys.exit(f"{names}: run packaging/pair_options.py" if outdated_files else 0)
    for path, text in generate_file_texts().items():
        path.write_text(text, "utf-8")


if __name__ == "__main__":
    main()
