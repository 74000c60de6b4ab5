"""Command-line options of `pair`, created from the declarations in `study.pair_options`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import typer

from stiction.cli.application import SHOW_ALL_OPTIONS_KEY, option_was_given, print_output
from stiction.cli.options import option
from stiction.study.pair_options import OPTION_GROUPS, PAIR_OPTIONS, format_command_line_name

PAIR_SHORT_HELP_PARAMETERS = frozenset(name for name, declared in PAIR_OPTIONS.items() if declared.is_common) | {
    "upper", "lower", "output", "help_all",
}  # fmt: skip
"""Names of the parameters in the short help of the command `pair`."""


class _CommandLineOptionNames(dict[str, str]):
    """Mapping that replaces placeholders in help texts by the command-line names of options."""

    def __missing__(self, name: str) -> str:
        return format_command_line_name(name)


def format_option_help(name: str) -> str:
    """Return the help text of a `pair` option, in which command-line names replace the placeholders."""
    return PAIR_OPTIONS[name].help.format_map(_CommandLineOptionNames())


def pair_option(name: str, *, repeatable: bool = True) -> Any:
    """Declare a `pair` option for the command line, in the help panel of the option's group."""
    declaration = PAIR_OPTIONS[name]
    panel = next(group.title for group in OPTION_GROUPS if name in group.model_fields)
    suffix = " Repeatable." if declaration.is_repeatable and repeatable else ""
    flags = f"{format_command_line_name(name)} {declaration.value}".strip()
    return option(flags, format_option_help(name) + suffix, declaration.default_text or False, panel=panel)


def pair_argument(name: str) -> Any:
    """Declare the command-line argument for one of the two bodies of `pair`."""
    return typer.Argument(metavar=PAIR_OPTIONS[name].value, help=format_option_help(name))


def read_given_options(context: typer.Context) -> dict[str, object]:
    """Return the `pair` options that the command line contains, keyed by the field names of `PairOptions`."""
    values: Mapping[str, object] = context.params
    return {name: value for name, value in values.items() if name in PAIR_OPTIONS and option_was_given(context, name)}


def _print_full_help(context: typer.Context, is_requested: bool) -> None:
    if is_requested:
        context.meta[SHOW_ALL_OPTIONS_KEY] = True
        print_output(context.get_help())
        raise typer.Exit


HelpAllOption = Annotated[
    bool, typer.Option("--help-all", callback=_print_full_help, is_eager=True, help="Show all options and exit.")
]
