"""The application that the groups of commands are added to, and how it speaks."""

from __future__ import annotations

import os
import sys
import warnings
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from stiction._core import __version__
from stiction._files import reason
from stiction._text import LONGEST_LINE, named, printable

INTERRUPTED = 130
"""Exit status, as of a shell's own commands."""

BAD_INPUT = 2
"""Exit status."""

UsageError: type[Exception] = typer.BadParameter.__mro__[1]
"""What the parser raises of options; versions of typer have it from different places."""


def say(text: str, kind: str = "") -> None:
    """Tell the person, on standard error; what is foreign in it moves no cursor and begins no line of its own."""
    lines = [f"stiction: {kind}{printable(line, LONGEST_LINE)}" for line in text.split("\n") if line]
    print("\n".join(lines), file=sys.stderr)


def tell(text: str) -> None:
    """Print what was asked for, on standard output; whoever stops listening does not stop the work."""
    try:
        typer.echo("\n".join(printable(line, sys.maxsize) for line in text.removesuffix("\n").split("\n")))
    except BrokenPipeError:
        # Also when Python flushes it at the end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """Tell the person of a warning."""
    say(str(message), "warning: ")


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


def start() -> int:
    """Run the command that the arguments are; its exit status."""
    _open_streams()
    warnings.showwarning = show_warning
    try:
        return int(app(standalone_mode=False) or 0)
    except UsageError as error:
        if type(error).__name__ == "NoArgsIsHelpError":
            error.show()  # type: ignore[attr-defined]
        else:
            context = getattr(error, "ctx", None)
            command = context.command_path if context else "stiction"
            say(f"{error.format_message()}\ntry {command} --help")  # type: ignore[attr-defined]
    except MemoryError:
        say("there is not enough memory for this")
    except RecursionError:
        say("something in the input is too deep")
    except OSError as error:
        about = f"{named(error.filename)}: " if isinstance(error.filename, str) else ""
        say(f"{about}{reason(error)}")
    except (ValueError, ImportError) as error:
        say(str(error) or type(error).__name__)
    except (RuntimeError, SystemError) as error:  # no thread can be started, or a library had no memory to say so
        say(f"{error}; perhaps memory or processes are limited here")
    except KeyboardInterrupt:
        say("interrupted")
        return INTERRUPTED
    except SystemExit:  # by the parser, whose help nobody reads to its end
        return 0
    return BAD_INPUT


def _open_streams() -> None:
    """Streams that were closed lead nowhere: what is opened next must not take their places."""
    while (file := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(file, True)
    os.close(file)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115, as long as the process


def _print_version(wanted: bool) -> None:
    if wanted:
        tell(f"stiction {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    pass
