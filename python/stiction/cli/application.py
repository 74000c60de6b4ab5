"""The application that the commands are added to, and how it speaks."""

from __future__ import annotations

import difflib
import io
import os
import re
import shutil
import signal
import sys
import textwrap
import warnings
from _thread import interrupt_main, start_new_thread
from collections.abc import Callable, Collection
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, TypeVar, cast

import typer
from typer.core import TyperCommand, TyperGroup
from typer.exceptions import TyperException

from stiction._core import __version__, build
from stiction._errors import ArgumentError
from stiction._files import describe_os_error
from stiction._text import MAX_LINE_LENGTH, printable, printable_path
from stiction.cli import BAD_INPUT, INTERRUPTED, end_at_interrupt

Function = TypeVar("Function", bound=Callable[..., Any])


def say(text: str, kind: str = "") -> None:
    """Tell the person, on standard error; what is foreign in it moves no cursor and begins no line of its own."""
    lines = [f"stiction: {kind}{printable(line, MAX_LINE_LENGTH)}" for line in text.split("\n") if line]
    if sys.stderr.isatty():
        width = shutil.get_terminal_size().columns
        lines = [textwrap.fill(line, width, subsequent_indent="  ", break_long_words=False) for line in lines]
    _clear()
    print("\n".join(lines), file=sys.stderr)


def interrupted(more: str = "") -> typer.Exit:
    """Say that the command was interrupted; another Ctrl-C would only add a traceback."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    say(f"interrupted{more}")
    return typer.Exit(INTERRUPTED)


def announce(text: str) -> None:
    """Tell whoever watches a terminal what takes a moment, in a line that the next one takes the place of."""
    if is_watched():
        line = f"stiction: {printable(text, MAX_LINE_LENGTH)}"[: shutil.get_terminal_size().columns - 1]
        _clear(f"{line}\r")


def _clear(more: str = "") -> None:
    """Empty the line of a terminal; not by way of a progress bar, which would print what moves the cursor."""
    if is_watched():
        print(f"\x1b[2K{more}", end="", file=sys.__stderr__ or sys.stderr, flush=True)


def is_watched() -> bool:
    """Whether messages go to a terminal."""
    return sys.stderr.isatty()


def tell(text: str) -> None:
    """Print what was asked for, on standard output; whoever stops listening does not stop the work."""
    lines = [printable(line, sys.maxsize) for line in text.removesuffix("\n").split("\n")]
    if sys.stdout.isatty():
        lines = [_ANSWER.sub(lambda found: typer.style(found[0], bold=True), line) for line in lines]
    try:
        _clear()
        typer.echo("\n".join(lines))
    except OSError as error:
        # What takes nothing more leads to nowhere: Python flushes what is left, and would fail once more.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise


_ANSWER = re.compile("^(μ_s = [^ ]+( \\[.*?\\])?|Quote it|Quote with care|Do not quote)(?![^ ;])")
"""What is bold on a terminal: number and verdict."""


def show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """Print a warning on standard error, once for each command."""
    if str(message) not in _WARNED:
        _WARNED.add(str(message))
        say(str(message), "warning: ")


_WARNED: set[str] = set()  # warnings that the command has printed


COMMANDS: dict[str, dict[str, tuple[str, str]]] = {
    "Measured surfaces": {
        "pair": ("pair", "Static friction of two measured surfaces at given loads."),
        "characterise": ("characterise", "Roughness, spectrum and Hurst exponent of a measured surface."),
        "calibrate": ("calibrate", "mu0 and tau0 from friction that was measured."),
        "interfaces": ("calibrate", "Strengths of interfaces that were read in a source."),
        "materials": ("materials", "Elasticity and hardness of materials, with sources."),
        "app": ("app", "All of it in a browser: drop two scans on a page."),
    },
    "Studies": {
        "run": ("studies", "Compute a study, or what is missing of it, and draw it."),
        "studies": ("studies", "List the built-in studies, or print one as a study file."),
    },
    "Results of both": {
        "at": ("at", "Friction, area and stiffness at one load, and whether to quote them."),
        "info": ("results", "Show what a result is, how far it has come, how far to trust it."),
        "plot": ("results", "Draw the figures of a result again."),
        "report": ("results", "Make one interactive page, for any browser."),
        "export": ("results", "Write a result to one netCDF file, or its table to a CSV file."),
    },
    "Contact laws": {"table": ("table", "Friction, true area and stiffness of rough surfaces for another code.")},
}
"""Commands by group, each with the module that adds it and a line of help, which is printed without the modules."""

STATUSES = f"""Exit status: 0 done, {BAD_INPUT} bad input (one message says what), {INTERRUPTED} interrupted."""


def examples(*lines: str) -> str:
    """What the help of a command ends with: commands to copy, and what exit statuses mean."""
    return "\b\n" + "\n".join(["Examples:", *(f"  {line}" for line in lines), "", STATUSES])


_DEFAULT = re.compile(r"\[default: \(([^()]*)\)")  # a default in words, which typer puts into brackets of its own
_RANGE = re.compile(r"(; )?\bx[<>]=?[-\d.]+")
_TYPE = re.compile(r" <[\w\[\] ]+>$")  # what typer adds to a help text, and to a name


SHOW_ALL = "stiction.show_all"
"""Key of a context's `meta`, set where the help lists all options."""


def option_was_given(context: typer.Context, name: str) -> bool:
    """Return whether the command line has an option or argument, with whatever value."""
    source = context.get_parameter_source(name)
    return source is not None and source.name != "DEFAULT"


class _Command(TyperCommand):
    """Names arguments and options by what they are called alone, and lists options in their panels."""

    common: Collection[str] = ()  # parameters that the short help lists, of a command with many

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        texts = [each.partition("=")[2] if each.startswith("--") and "=" in each else each for each in args]
        rest = super().parse_args(ctx, args)
        if "" in texts and "." not in texts:  # an empty text is a path, that of the current folder
            for each in cast("list[Any]", self.params):
                value = ctx.params.get(each.name)
                if Path() in (value if isinstance(value, (list, tuple)) else [value]):
                    raise typer.BadParameter("must not be empty", ctx, each)
        return rest

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        return [re.sub("[{}]", "", piece) for piece in super().collect_usage_pieces(ctx)]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        panels: dict[str, list[tuple[str, str]]] = {}
        for each in self.get_params(ctx):
            usual = "Arguments" if each.param_type_name == "argument" else "Options"
            title = getattr(each, "rich_help_panel", None) or usual
            is_listed = SHOW_ALL in ctx.meta or not self.common or each.name in (*self.common, "help")
            if is_listed and (record := each.get_help_record(ctx)):
                text = _RANGE.sub("", _DEFAULT.sub(r"[default: \1", record[1])).replace("[]", "").rstrip()
                panels.setdefault(title, []).append((_TYPE.sub("", record[0]), text))
        for title, rows in panels.items():
            with formatter.section(title):
                formatter.write_dl(rows)


class _Commands(TyperGroup):
    """Imports the module of a command when it is asked for; what the modules use takes a moment."""

    def list_commands(self, ctx: Any) -> list[str]:
        return [name for group in COMMANDS.values() for name in group]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        modules = {name: module for group in COMMANDS.values() for name, (module, _) in group.items()}
        if cmd_name not in modules:
            return None
        with end_at_interrupt():
            import_module(f"stiction.cli.{modules[cmd_name]}")
        added = cast("_Command", typer.main.get_command(_ADDED[cmd_name]))
        added.common = _COMMON.get(cmd_name, ())
        return added

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        for title, group in COMMANDS.items():
            with formatter.section(title):
                formatter.write_dl([(name, sentence) for name, (_, sentence) in group.items()])

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:  # of which typer makes a bare status
            raise interrupted() from None


# Without rich's markup: loading what it takes would be half of the time that help takes.
_PLAIN: dict[str, Any] = {
    "rich_markup_mode": None, "pretty_exceptions_enable": False, "add_completion": False,
    "context_settings": {"help_option_names": ["-h", "--help"]},
}  # fmt: skip

app = typer.Typer(
    name="stiction",
    cls=_Commands,
    help="The coefficient of static friction of rough surfaces, from their shape.",
    epilog=examples(
        "stiction pair upper.csv lower.csv --young '210 GPa' \\",
        "    --poisson 0.3 --mu0 0.2 --load '10 MPa'",
        "stiction run quick            # a map of friction, in seconds",
        "stiction COMMAND --help",
    ),
    no_args_is_help=True,
    **(_PLAIN | {"add_completion": True}),
)

_ADDED: dict[str, typer.Typer] = {}  # each command that has been added


_COMMON: dict[str, Collection[str]] = {}  # parameters in the short help, of commands with many


def command(name: str, *lines: str, common: Collection[str] = ()) -> Callable[[Function], Function]:
    """Add a command whose help ends with these examples, and lists the common parameters alone unless all are."""
    own = _ADDED[name] = typer.Typer(**_PLAIN)
    _COMMON[name] = common
    return own.command(name, cls=_Command, epilog=examples(*lines))


_OPTIONS = {"height_scale": "--scale-heights", "compute=True": "--compute"}
"""Options of `at` that are called otherwise than the arguments of `Result.at`."""


def _option_name(argument: str) -> str:
    """Return how the command line names an argument."""
    from stiction.studies.pair_options import name_on_command_line

    return _OPTIONS.get(argument) or name_on_command_line(argument)


def start() -> int:
    """Run the command that the arguments are; its exit status."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # ? for letters that its encoding lacks
    warnings.showwarning = show_warning
    _WARNED.clear()
    warnings.filterwarnings("ignore", category=RuntimeWarning)  # of NumPy; what has no number is said in a sentence
    sys.unraisablehook = _interrupt_again
    try:
        return int(app(standalone_mode=False, prog_name="stiction") or 0)
    except TyperException as error:
        if type(error).__name__ == "NoArgsIsHelpError":
            error.show()  # type: ignore[attr-defined]
        else:
            context = getattr(error, "ctx", None)
            command = context.command_path if context else "stiction"
            said = error.format_message()
            # A number out of its range is said in the words of the library that looks at it.
            said = re.sub(r"^Invalid value for '([^']+)': Input should be ", r"\1 must be ", said)
            said = _with_nearest_command(said)
            say(f"{said}\ntry {command} --help")
    except MemoryError:
        say("there is not enough memory for this")
    except RecursionError:
        say("something in the input is too deep")
    except OSError as error:
        about = f"{printable_path(error.filename)}: " if isinstance(error.filename, str) else ""
        say(f"{about}{describe_os_error(error)}")
    except ArgumentError as error:
        say(error.with_names(_option_name))
    except (ValueError, ImportError) as error:
        say(str(error) or type(error).__name__)
    except (RuntimeError, SystemError) as error:  # no thread can be started, or a library had no memory to say so
        say(f"{error or type(error).__name__}; perhaps memory or processes are limited here")
    except KeyboardInterrupt:
        return interrupted().exit_code
    except SystemExit:  # by the parser, whose help nobody reads to its end
        return 0
    return BAD_INPUT


def _with_nearest_command(message: str) -> str:
    """Return a message of the parser, with the nearest command appended if it is about an unknown one."""
    unknown = re.match(r"No such command '([^']*)'", message)
    names = [name for group in COMMANDS.values() for name in group]
    near = difflib.get_close_matches(unknown[1], names, n=1) if unknown else []
    return f"no such command '{unknown[1]}'; did you mean {near[0]}?" if unknown and near else message


def _interrupt_again(ignored: Any) -> None:
    """Let Ctrl-C, which Python ignores where it cleans up, be a moment later."""
    if issubclass(ignored.exc_type, KeyboardInterrupt):
        start_new_thread(interrupt_main, ())
    else:
        sys.__unraisablehook__(ignored)


def _print_version(wanted: bool) -> None:
    if wanted:
        tell(f"stiction {__version__}")
        tell("built with " + ", ".join(f"{what.replace('_', ' ')} {value}" for what, value in build().items()))
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Show version and build, and exit."),
    ] = False,
) -> None:
    pass
