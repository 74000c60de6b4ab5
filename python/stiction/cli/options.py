"""Options that several commands take, each declared once, and what their texts mean."""

from __future__ import annotations

import inspect
import itertools
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

import typer

from stiction._text import printable_path
from stiction.cli.application import Function, announce
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    from stiction.surfaces.measured.reading import Reading


def option(
    flags: str, means: str, usually: str | bool = True, *, panel: str | None = None, least: int | None = None
) -> Any:
    """An option of a command, as its help shows it.

    It is called by its flags, "--output -o DIR", behind which stands what it takes, in capitals, and nothing behind a
    switch. Its default is `usually` so in words, or it is said whether the default is shown. The panel is the section
    of help that it is in.
    """
    names = [word for word in flags.split() if word.startswith("-")]
    takes = " ".join(flags.split()[len(names) :]) or None
    return typer.Option(*names, metavar=takes, help=means, show_default=usually, rich_help_panel=panel, min=least)


def optional(
    flags: str, means: str, usually: str | bool = True, *, kind: Any = str, panel: str, least: int | None = None
) -> Any:
    """The type of an argument that is None unless its option, as of `option`, is given."""
    return Annotated[kind | None, option(flags, means, usually, panel=panel, least=least)]


def with_options(*tables: Mapping[str, Any]) -> Callable[[Function], Function]:
    """Let a command, behind its positional arguments, take options by their names and types, which `**asked` gets."""

    def added(function: Function) -> Function:
        signature = inspect.signature(function, eval_str=True)
        own = [each for each in signature.parameters.values() if each.kind is not each.VAR_KEYWORD]
        place = sum(each.kind is each.POSITIONAL_OR_KEYWORD for each in own)
        more = []
        for name, kind in itertools.chain.from_iterable(table.items() for table in tables):
            of = get_args(kind)[0]  # a switch is off, what may be None is, and others must be given
            usual = False if of is bool else None if type(None) in get_args(of) else inspect.Parameter.empty
            more.append(inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=kind, default=usual))
        function.__signature__ = signature.replace(parameters=[*own[:place], *more, *own[place:]])  # type: ignore[attr-defined]
        return function

    return added


_material = partial(optional, panel="Material")

ELASTICITY = {
    "effective_modulus": _material("--effective-modulus PRESSURE", 'E*, as in "10 GPa".', False),
    "young": _material(
        "--young PRESSURES",
        'Instead of E*: Young\'s modulus of both bodies or of one after the other, "200 GPa,70 GPa".', False,
    ),
    "poisson": _material("--poisson NUMBERS", 'Poisson\'s ratios, "0.3" or "0.3,0.33".', False),
}  # fmt: skip
"""Elasticity by numbers."""

MATERIALS = {
    "upper_material": _material(
        "--upper MATERIAL", "Instead of E*: what the slider is made of, by name, as in steel.", False
    ),
    "lower_material": _material(
        "--lower MATERIAL", "What it is carried over; that of --upper by default.", False
    ),
}  # fmt: skip
"""Materials of both bodies."""

_reading = partial(option, panel="Reading files")
_output = partial(option, panel="Output")
Json = Annotated[bool, _output("--json", "Print JSON alone on standard output; messages go elsewhere.")]
Verbose = Annotated[bool, _output("--verbose -v", "Show all: inputs, directions, cut-offs, onset, quantities.")]

_READING = {
    "unit": _reading(
        "--unit UNIT",
        'Of the lengths in the file, "um", or of positions and heights, "mm,um". Needed where it says none.', False,
    ),
    "spacing": _reading(
        "--spacing LENGTH",
        'Distance of points, "0.5 um", or of rows and of columns, "2 um,0.5 um". Needed where the file has none.',
        False,
    ),
    "missing": _reading(
        "--missing error|mask|interpolate",
        "Of points without a height: press what is there, or put them on lines.", "error",
    ),
    "outliers": _reading(
        "--outliers keep|mask",
        "Whether points beyond 6 robust deviations of their neighbours, up to 4 together, are missing ones.", "keep",
    ),
    "crop": _reading(
        "--crop X0,X1[,Y0,Y1]", 'What to read of the file: "10 um,60 um", of a map along x and y.', False
    ),
    "channel": _reading(
        "--channel NAME|NUMBER",
        "What to read of a file of several channels or sheets, numbers from 0 on.", "the first of heights",
    ),
    "columns": _reading(
        "--columns Z|X,Z|X,Y,Z", "Of a table, names or numbers from 0 on: of heights, or below positions.", False
    ),
    "missing_value": _reading(
        "--missing-value NUMBERS|WORDS", 'Marks of points without a height, as they stand in the file, "-9999".', False
    ),
    "accept": _reading(
        "--accept NAMES", 'Doubts about a file that are settled, by their names, "whole-numbers".', False
    ),
    "texture": _reading(
        "--texture PROCESS",
        "How it was machined (turned, milled, ground, ...): lines and humps of its spectrum are then its own.", False,
    ),
    "tip": _reading("--tip RADIUS", 'Of the stylus or the probe, "10 nm": what is sharper is its own.', False),
}  # fmt: skip

FILE = {name: Annotated[str | None, each] for name, each in _READING.items()}  # how each file is read

FILES = FILE | {
    name: Annotated[list[str] | None, each] for name, each in _READING.items() if name not in ("missing", "outliers")
}
"""How two files are read, each option given once for both or for one after the other."""


def measurement(file: Path, asked: Mapping[str, str | None]) -> Reading[Profile | Surface]:
    """Return the profile or surface in a file, and what was understood of it, by the options of `FILE`."""
    from stiction.surfaces.measured.reading import reading_of
    from stiction.surfaces.measured.spectrum_file import is_spectrum

    if is_spectrum(file):
        raise ValueError(
            f"{printable_path(file)}: is the spectrum of several scans, which stiction pair takes in place of one"
        )
    announce_reader(file)
    given: dict[str, Any] = {name: text for name, text in asked.items() if text is not None}
    for name in ("unit", "spacing", "columns"):
        if "," in given.get(name, ""):
            given[name] = tuple(part.strip() for part in given[name].split(","))
    return reading_of(file, **given)


def announce_reader(file: Path) -> None:
    """Tell whoever watches that what reads a file of an instrument takes longer to load than the file to be read."""
    from stiction.surfaces.measured.reading import READERS

    if file.suffix.lower() not in READERS and file.is_file() and "SurfaceTopography" not in sys.modules:
        announce(f"loading SurfaceTopography, which takes some seconds, to read {printable_path(file.name)}")


def given(context: typer.Context, name: str) -> bool:
    """Whether an option is there, with whatever value."""
    source = context.get_parameter_source(name)
    return source is not None and source.name != "DEFAULT"


def refuse(context: typer.Context, why: str, *names: str) -> None:
    """Options that are given where they do not apply."""
    for name in names:
        if given(context, name):
            option = f"--{name.replace('_', '-')}"
            value = context.params[name]
            raise ValueError(f"{option} {why}, got {option}" + (f" {value}" if value is not True else ""))
