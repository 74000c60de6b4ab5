"""Options of commands that are options of a pair, as `studies.pair_options` declares them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import typer

from stiction.cli.application import SHOW_ALL, option_was_given, tell
from stiction.cli.options import option
from stiction.studies.pair_options import GROUPS, OPTIONS, name_on_command_line

COMMON = frozenset(name for name, each in OPTIONS.items() if each.is_common) | {"upper", "lower", "output", "help_all"}
"""Parameters of `pair` in its short help."""


class _Names(dict[str, str]):
    """Names of options on the command line, for the placeholders of a help line."""

    def __missing__(self, name: str) -> str:
        return name_on_command_line(name)


def help_of(name: str) -> str:
    """Return the help line of an option of a pair, with the names of a command line."""
    return OPTIONS[name].help.format_map(_Names())


def option_of(name: str, *, repeatable: bool = True) -> Any:
    """Return an option of a pair as one of a command, in the panel of its group."""
    declared = OPTIONS[name]
    panel = next(group.title for group in GROUPS if name in group.model_fields)
    more = " Repeatable." if declared.is_repeatable and repeatable else ""
    flags = f"{name_on_command_line(name)} {declared.value}".strip()
    return option(flags, help_of(name) + more, declared.usual or False, panel=panel)


def argument_of(name: str) -> Any:
    """Return a body of a pair as an argument of a command."""
    return typer.Argument(metavar=OPTIONS[name].value, help=help_of(name))


def given_options(context: typer.Context) -> dict[str, object]:
    """Return the options of a pair that a command line has, by the names of their fields."""
    values: Mapping[str, object] = context.params
    return {name: value for name, value in values.items() if name in OPTIONS and option_was_given(context, name)}


def _show_all(context: typer.Context, wanted: bool) -> None:
    if wanted:
        context.meta[SHOW_ALL] = True
        tell(context.get_help())
        raise typer.Exit


HelpAll = Annotated[
    bool, typer.Option("--help-all", callback=_show_all, is_eager=True, help="Show all options and exit.")
]
