"""The application that the groups of commands are added to, and how it speaks."""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Callable
from importlib import import_module
from typing import Annotated, Any, TypeVar

import typer
from typer.core import TyperCommand, TyperGroup

from stiction._core import __version__
from stiction._files import reason
from stiction._text import LONGEST_LINE, named, printable

INTERRUPTED = 130
"""Exit status, as of a shell's own commands."""

BAD_INPUT = 2
"""Exit status."""

Function = TypeVar("Function", bound=Callable[..., Any])

UsageError: type[Exception] = typer.BadParameter.__mro__[1]
"""What the parser raises of options; versions of typer have it from different places."""


def say(text: str, kind: str = "") -> None:
    """Tell the person, on standard error; what is foreign in it moves no cursor and begins no line of its own."""
    lines = [f"stiction: {kind}{printable(line, LONGEST_LINE)}" for line in text.split("\n") if line]
    print("\n".join(lines), file=sys.stderr)


def announce(text: str) -> None:
    """Tell whoever watches a terminal what takes a moment."""
    if sys.stderr.isatty():
        say(text)


def tell(text: str) -> None:
    """Print what was asked for, on standard output; whoever stops listening does not stop the work."""
    try:
        typer.echo("\n".join(printable(line, sys.maxsize) for line in text.removesuffix("\n").split("\n")))
    except OSError as error:
        # Python flushes what is left at the end, and would fail once more.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise


def show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """Tell the person of a warning."""
    say(str(message), "warning: ")


COMMANDS: dict[str, dict[str, tuple[str, str]]] = {
    "Studies": {
        "run": ("studies", "Compute a study, or what is missing of it, and draw it."),
        "plot": ("studies", "Draw the figures of a study or a pair again."),
        "at": ("at", "Friction, area and stiffness of a study at one load."),
        "report": ("studies", "Make one interactive page, for any browser."),
        "info": ("studies", "Show what a study is, how far it has come, how far to trust it."),
        "export": ("studies", "Write the results to one netCDF file."),
        "studies": ("studies", "List the built-in studies, or print one as a study file."),
        "claims": ("studies", "Judge what the paper claims by its own studies."),
    },
    "Measured surfaces": {
        "characterise": ("characterise", "Roughness, spectrum and Hurst exponent of a measured surface."),
        "pair": ("pair", "Static friction of two measured surfaces at given loads."),
    },
    "Contact laws": {
        "table": ("table", "Friction, true area and stiffness of rough surfaces for another code."),
    },
}
"""Of each group the commands, the module that adds each, and a line of help, which is printed without the modules."""


def _add_commands() -> None:
    """Import the module of the command that is asked for, or all where that is none: what they use takes a moment."""
    modules = {name: module for group in COMMANDS.values() for name, (module, _) in group.items()}
    asked = next((each for each in sys.argv[1:] if not each.startswith("-")), None)
    if "_STICTION_COMPLETE" in os.environ:  # a shell asks what may follow
        asked = None if len(words := os.environ.get("COMP_WORDS", "").split()) < 2 else words[1]
        for module in sorted(
            {module for module in modules.values() if asked not in modules or module == modules[asked]}
        ):
            import_module(f"stiction.cli.{module}")
        return
    if asked is None and sys.argv[1:]:
        return  # --help, --version
    for module in {modules[asked]} if asked in modules else sorted(set(modules.values())):
        import_module(f"stiction.cli.{module}")


STATUSES = f"""Exit status: 0 done, {BAD_INPUT} bad input (one message says what), {INTERRUPTED} interrupted."""


def examples(*lines: str) -> str:
    """What the help of a command ends with: commands to copy, and what exit statuses mean."""
    return "\b\n" + "\n".join(["Examples:", *(f"  {line}" for line in lines), "", STATUSES])


class _Command(TyperCommand):
    """Names arguments and options by what they are called alone, without types and braces."""

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        return [piece.strip("{}") for piece in super().collect_usage_pieces(ctx)]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        for title, kind in (("Arguments", "argument"), ("Options", "option")):
            records = [each.get_help_record(ctx) for each in self.get_params(ctx) if each.param_type_name == kind]
            if rows := [(re.sub(r" <[\w ]+>$", "", name), text) for name, text in filter(None, records)]:
                with formatter.section(title):
                    formatter.write_dl(rows)


class _Commands(TyperGroup):
    """Lists commands that are not imported, and says that it was interrupted, of which typer makes a bare status."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        for title, group in COMMANDS.items():
            with formatter.section(title):
                formatter.write_dl([(name, sentence) for name, (_, sentence) in group.items()])

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
    epilog=examples(
        "stiction run quick                          # a map of friction, in seconds",
        "stiction pair upper.csv lower.csv --young '210 GPa' --poisson 0.3 --mu0 0.2 --load '10 mN'",
        "stiction COMMAND --help",
    ),
    no_args_is_help=True,
    rich_markup_mode=None,  # loading what it takes would be half of the time that help takes
    pretty_exceptions_enable=False,
)


def command(name: str, *lines: str) -> Callable[[Function], Function]:
    """Add a command whose help ends with these examples."""
    return app.command(name, cls=_Command, epilog=examples(*lines))


def start() -> int:
    """Run the command that the arguments are; its exit status."""
    _open_streams()
    warnings.showwarning = show_warning
    try:
        _add_commands()
        return int(app(standalone_mode=False, prog_name="stiction") or 0)
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
        say(f"{error or type(error).__name__}; perhaps memory or processes are limited here")
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
