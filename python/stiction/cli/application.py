"""The application that the groups of commands are added to, and how it speaks."""

from __future__ import annotations

import sys
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from stiction._core import __version__

INTERRUPTED = 130
"""Exit status, as of a shell's own commands."""


def say(text: str) -> None:
    """Tell the person, on standard error."""
    print("\n".join(f"stiction: {line}" for line in text.splitlines()), file=sys.stderr)


class _Commands(TyperGroup):
    """Says that it was interrupted, of which typer makes an exit status without a word."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            say("interrupted")
            raise typer.Exit(INTERRUPTED) from None


app = typer.Typer(
    name="stiction",
    cls=_Commands,
    help="The coefficient of static friction of rough surfaces, from their shape.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"stiction {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    pass
