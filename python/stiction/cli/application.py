"""Typer application with all commands: help texts, messages, output, and exit statuses."""

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
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, TextIO, TypeVar, cast

import typer
from typer.core import TyperCommand, TyperGroup
from typer.exceptions import TyperException

from stiction._core import __version__, build
from stiction._errors import UNFIT_CORE_MESSAGE, ArgumentError, is_caused_by_unfit_core
from stiction._files import describe_os_error
from stiction._text import MAX_QUOTED_LINE_LENGTH, printable_path, printable_text
from stiction.cli.exit_status import EXIT_BAD_INPUT, EXIT_INTERRUPTED, exit_on_interrupt

Function = TypeVar("Function", bound=Callable[..., Any])


def print_message(text: str, kind: str = "") -> None:
    """Print a message on standard error, with escaped control characters.

    A failure to print is ignored.
    """
    lines = [f"stiction: {kind}{printable_text(line, MAX_QUOTED_LINE_LENGTH)}" for line in text.split("\n") if line]
    if sys.stderr.isatty():
        width = shutil.get_terminal_size().columns
        lines = [textwrap.fill(line, width, subsequent_indent="  ", break_long_words=False) for line in lines]
    try:
        _clear_line()
        print("\n".join(lines), file=sys.stderr, flush=True)
    except OSError:
        # Printing fails if standard error is closed, or if it is redirected to a file on a full disk.
        _redirect_to_null_device(sys.stderr)


def _redirect_to_null_device(stream: TextIO) -> None:
    """Redirect a stream to the null device after a failed write, so that the flush at exit does not fail too."""
    # A stream such as `io.StringIO` has no file descriptor.
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def report_interruption(detail: str = "") -> typer.Exit:
    """Print that the command was interrupted, and return an exception that exits with status 130."""
    # SIGINT is ignored from this point on, because a second Ctrl-C would only print a traceback.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    print_message(f"interrupted{detail}")
    return typer.Exit(EXIT_INTERRUPTED)


def show_status(text: str) -> None:
    """Show what the command is doing. The text appears in a terminal line that the next message overwrites."""
    if is_stderr_terminal():
        line = f"stiction: {printable_text(text, MAX_QUOTED_LINE_LENGTH)}"[: shutil.get_terminal_size().columns - 1]
        _clear_line(f"{line}\r")


def _clear_line(replacement: str = "") -> None:
    """Clear the current line of a terminal, and move the cursor to its start."""
    if is_stderr_terminal():
        print(f"\r\x1b[2K{replacement}", end="", file=sys.__stderr__ or sys.stderr, flush=True)


def is_stderr_terminal() -> bool:
    """Return whether standard error is a terminal."""
    return sys.stderr.isatty()


def print_output(text: str) -> None:
    """Print text on standard output.

    If the pipe that reads the output is closed, do nothing.
    """
    lines = [printable_text(line, sys.maxsize) for line in text.removesuffix("\n").split("\n")]
    if sys.stdout.isatty():
        lines = [_BOLD_TEXT_PATTERN.sub(lambda match: typer.style(match[0], bold=True), line) for line in lines]
    try:
        _clear_line()
        typer.echo("\n".join(lines))
    except OSError as error:
        _redirect_to_null_device(sys.stdout)
        if not isinstance(error, BrokenPipeError):
            raise


_BOLD_TEXT_PATTERN = re.compile("^(μ_s [=≥] [^ ]+( \\[.*?\\])?|Quote it|Quote with care|Do not quote)(?![^ ;])")
"""Pattern of the text that terminals show in bold: the friction coefficient and the assessment."""


def print_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """Print a warning on standard error, unless a warning with the same text has been printed before."""
    if str(message) not in _ALREADY_PRINTED_WARNINGS:
        _ALREADY_PRINTED_WARNINGS.add(str(message))
        print_message(str(message), "warning: ")


_ALREADY_PRINTED_WARNINGS: set[str] = set()


COMMANDS_BY_GROUP: dict[str, dict[str, tuple[str, str]]] = {
    "Measured surfaces": {
        "pair": ("pair", "Static friction of two measured surfaces at given loads."),
        "shear": ("shear", "Direct shear test of two faces that fit, such as a rock joint."),
        "characterise": ("characterise", "Roughness, spectrum and Hurst exponent of a measured surface."),
        "calibrate": ("calibrate", "Fit mu0 and tau0 to measured friction."),
        "interfaces": ("calibrate", "List measured shear strengths of interfaces, with sources."),
        "materials": ("materials", "List elastic constants and hardness of materials."),
        "app": ("app", "Open the browser app: drop in two scans."),
    },
    "Studies": {
        "run": ("studies", "Compute or resume a study, and draw its figures."),
        "studies": ("studies", "List the built-in studies, or print one as a study file."),
    },
    "Results of pairs and studies": {
        "at": ("at", "Friction, area and stiffness at other loads, mu0 and tau0."),
        "info": ("results", "Show inputs, progress, friction and reliability of a result."),
        "plot": ("results", "Draw the figures of a result again."),
        "report": ("results", "Write an interactive HTML report."),
        "export": ("results", "Write a result, or its joint for finite elements, to a file."),
    },
    "Contact laws": {"table": ("table", "Tabulate friction, area and stiffness for another code.")},
}
"""Module and help line of each command, by group, so that the help text needs no import of the modules."""

EXIT_STATUS_HELP = (
    f"Exit status: 0 success, {EXIT_BAD_INPUT} bad input (with one message), {EXIT_INTERRUPTED} interrupted."
)


def format_help_epilog(*lines: str) -> str:
    """Return the end of a command's help text: examples, and the meaning of the exit statuses."""
    return "\b\n" + "\n".join(["Examples:", *(f"  {line}" for line in lines), "", EXIT_STATUS_HELP])


# In help texts, Typer puts a default in parentheses if it is a description instead of a value.
_DEFAULT_VALUE_PATTERN = re.compile(r"\[default: \(([^()]*)\)")
_RANGE_LIMITS_PATTERN = re.compile(r"(; )?\bx[<>]=?[-\d.]+")
# Typer appends the type of an option to the option's name.
_OPTION_TYPE_PATTERN = re.compile(r" <[\w\[\] ]+>$")


SHOW_ALL_OPTIONS_KEY = "stiction.show_all"
"""Key in the `meta` of a typer context that makes the help list all options."""


def option_was_given(context: typer.Context, name: str) -> bool:
    """Return whether the user gave an option or argument on the command line, even with the default value."""
    parameter_source = context.get_parameter_source(name)
    return parameter_source is not None and parameter_source.name != "DEFAULT"


class _CommandWithHelpPanels(TyperCommand):
    """Command whose help lists the options in panels, but not the types and ranges of the options."""

    common: Collection[str] = ()

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        argument_values = [text.partition("=")[2] if text.startswith("--") and "=" in text else text for text in args]
        remainder = super().parse_args(ctx, args)
        # An empty path must be rejected, because Path("") is the current directory.
        if "" in argument_values and "." not in argument_values:
            for parameter in cast("list[Any]", self.params):
                value = ctx.params.get(parameter.name)
                if Path() in (value if isinstance(value, (list, tuple)) else [value]):
                    raise typer.BadParameter("must not be empty", ctx, parameter)
        return remainder

    def invoke(self, ctx: Any) -> Any:
        # OpenBLAS sends SIGINT to its own process if it cannot start its threads.
        with exit_on_interrupt():
            import_module("numpy")
        return super().invoke(ctx)

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        return [re.sub("[{}]", "", piece) for piece in super().collect_usage_pieces(ctx)]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        panels: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            default_title = "Arguments" if parameter.param_type_name == "argument" else "Options"
            title = getattr(parameter, "rich_help_panel", None) or default_title
            is_listed = SHOW_ALL_OPTIONS_KEY in ctx.meta or not self.common or parameter.name in (*self.common, "help")
            if is_listed and (record := parameter.get_help_record(ctx)):
                text = (
                    _RANGE_LIMITS_PATTERN.sub("", _DEFAULT_VALUE_PATTERN.sub(r"[default: \1", record[1]))
                    .replace("[]", "")
                    .rstrip()
                )
                panels.setdefault(title, []).append((_OPTION_TYPE_PATTERN.sub("", record[0]), text))
        for title, rows in panels.items():
            with formatter.section(title):
                formatter.write_dl(rows)


class _LazyCommandGroup(TyperGroup):
    """Group of commands in which the module of a command is imported only when the command runs."""

    def list_commands(self, ctx: Any) -> list[str]:
        return [name for group in COMMANDS_BY_GROUP.values() for name in group]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        modules = {name: module for group in COMMANDS_BY_GROUP.values() for name, (module, _) in group.items()}
        if cmd_name not in modules:
            return None
        with exit_on_interrupt():
            import_module(f"stiction.cli.{modules[cmd_name]}")
        result = cast("_CommandWithHelpPanels", typer.main.get_command(_COMMAND_APPLICATIONS[cmd_name]))
        result.common = _SHORT_HELP_PARAMETERS.get(cmd_name, ())
        return result

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        for title, group in COMMANDS_BY_GROUP.items():
            with formatter.section(title):
                formatter.write_dl([(name, description) for name, (_, description) in group.items()])

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            # After Ctrl-C, typer would exit without a message.
            raise report_interruption() from None


# Rich would take half of the time for printing the help, so the markup of Rich is disabled.
_TYPER_OPTIONS: dict[str, Any] = {
    "rich_markup_mode": None, "pretty_exceptions_enable": False, "add_completion": False,
    "context_settings": {"help_option_names": ["-h", "--help"]},
}  # fmt: skip

app = typer.Typer(
    name="stiction",
    cls=_LazyCommandGroup,
    help="Compute the coefficient of static friction of rough surfaces from their topography.",
    epilog=format_help_epilog(
        "stiction pair upper.csv lower.csv --young '210 GPa' \\",
        "    --poisson 0.3 --mu0 0.2 --load '10 MPa'",
        "stiction run quick            # a map of friction, in seconds",
        "stiction COMMAND --help",
    ),
    no_args_is_help=True,
    **(_TYPER_OPTIONS | {"add_completion": True}),
)

_COMMAND_APPLICATIONS: dict[str, typer.Typer] = {}
_SHORT_HELP_PARAMETERS: dict[str, Collection[str]] = {}


def command(name: str, *lines: str, common: Collection[str] = ()) -> Callable[[Function], Function]:
    """Register a function as a command, with examples in its help text.

    If `common` is given, the short help lists only these parameters.
    """
    application = _COMMAND_APPLICATIONS[name] = typer.Typer(**_TYPER_OPTIONS)
    _SHORT_HELP_PARAMETERS[name] = common
    return application.command(name, cls=_CommandWithHelpPanels, epilog=format_help_epilog(*lines))


_OPTION_NAMES_BY_ARGUMENT = {"height_scale": "--scale-heights", "compute=True": "--compute"}
"""Options of the command `at` whose names differ from the arguments of `Result.at`, by argument."""


def _option_name(argument: str) -> str:
    """Return the command-line option that corresponds to an argument of a Python function."""
    if argument in _OPTION_NAMES_BY_ARGUMENT:
        return _OPTION_NAMES_BY_ARGUMENT[argument]
    # The module `pair_options` imports numeric packages, which the help does not need, so it is imported only here.
    pair_options = import_module("stiction.study.pair_options")
    return str(pair_options.format_command_line_name(argument))


def run_command_line() -> int:
    """Run the command in `sys.argv` and return the exit status."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # Characters that the encoding of the stream lacks are printed as "?".
            stream.reconfigure(errors="replace")
    warnings.showwarning = print_warning
    _ALREADY_PRINTED_WARNINGS.clear()
    # The output explains missing results, so NumPy's warnings about NaN are of no use.
    warnings.filterwarnings("ignore", category=RuntimeWarning)
    sys.unraisablehook = _handle_unraisable
    try:
        with _reraise_hidden_interrupts():
            status = int(app(standalone_mode=False, prog_name="stiction") or 0)
            with suppress(BrokenPipeError):
                # Typer prints the help text without flushing the stream.
                sys.stdout.flush()
            return status
    except TyperException as error:
        if type(error).__name__ == "NoArgsIsHelpError":
            with suppress(OSError):
                error.show()  # type: ignore[attr-defined]
        else:
            context = getattr(error, "ctx", None)
            command = context.command_path if context else "stiction"
            message = error.format_message()
            # Pydantic's message about a number out of range is reworded in the style of all other messages.
            message = re.sub(r"^Invalid value for '([^']+)': Input should be ", r"\1 must be ", message)
            message = _add_command_suggestion(message)
            print_message(f"{message}\ntry {command} --help")
    except MemoryError:
        print_message("not enough memory for this computation")
    except RecursionError:
        print_message("the input is nested too deeply")
    except OSError as error:
        prefix = f"{printable_path(error.filename)}: " if isinstance(error.filename, str) else ""
        print_message(f"{prefix}{describe_os_error(error)}")
    except ArgumentError as error:
        print_message(error.translated_message(_option_name))
    except (AttributeError, ImportError) as error:
        is_core_unfit = is_caused_by_unfit_core(str(error))
        if isinstance(error, AttributeError) and not is_core_unfit:
            raise
        print_message(UNFIT_CORE_MESSAGE if is_core_unfit else str(error) or type(error).__name__)
    except ValueError as error:
        print_message(str(error) or type(error).__name__)
    # A RuntimeError or SystemError occurs if a thread cannot start, or if a library runs out of memory.
    except (RuntimeError, SystemError) as error:
        print_message(f"{error or type(error).__name__}; a limit on memory or processes may be the cause")
    except KeyboardInterrupt:
        return report_interruption().exit_code
    except SystemExit:
        # Typer raises SystemExit if the pipe that reads the help text is closed.
        return 0
    finally:
        _discard_unwritable_output()
    return EXIT_BAD_INPUT


def _discard_unwritable_output() -> None:
    """Flush standard output and standard error, and discard output that cannot be written.

    Otherwise Python would exit with a traceback and status 120.
    """
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            _redirect_to_null_device(stream)


def _add_command_suggestion(message: str) -> str:
    """Return the error message of the parser or, if a command is unknown, a message that suggests a similar command."""
    unknown_command = re.match(r"No such command '([^']*)'", message)
    names = [name for group in COMMANDS_BY_GROUP.values() for name in group]
    suggestions = difflib.get_close_matches(unknown_command[1], names, n=1) if unknown_command else []
    return (
        f"no such command '{unknown_command[1]}'; did you mean {suggestions[0]}?"
        if unknown_command and suggestions
        else message
    )


@contextmanager
def _reraise_hidden_interrupts() -> Iterator[None]:
    """Raise KeyboardInterrupt if Ctrl-C caused another exception, such as an ImportError, in the `with` block."""
    try:
        yield
    except Exception as error:
        causing_error: BaseException | None = error
        while causing_error is not None:
            if isinstance(causing_error, KeyboardInterrupt):
                raise KeyboardInterrupt from None
            causing_error = causing_error.__cause__ or causing_error.__context__
        raise


def _handle_unraisable(unraisable: Any) -> None:
    """Raise KeyboardInterrupt in the main thread if Ctrl-C interrupted a destructor, whose errors Python ignores.

    An AttributeError is ignored: the destructor of an object raises it if the constructor was interrupted.
    """
    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        start_new_thread(interrupt_main, ())
    elif not issubclass(unraisable.exc_type, AttributeError):
        sys.__unraisablehook__(unraisable)


def _print_version_and_exit(is_requested: bool) -> None:
    if is_requested:
        print_output(f"stiction {__version__}")
        print_output("built with " + ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in build().items()))
        raise typer.Exit


@app.callback()
def _declare_global_options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version_and_exit, is_eager=True, help="Show version and build, and exit."
        ),
    ] = False,
) -> None:
    pass
