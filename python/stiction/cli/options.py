"""Options that several commands take, each declared once, and what their texts mean."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction._text import printable_path
from stiction.cli.application import announce, option_was_given
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


_output = partial(option, panel="Output")
Json = Annotated[bool, _output("--json", "Print JSON alone on standard output; messages go elsewhere.")]
Verbose = Annotated[bool, _output("--verbose -v", "Show all: inputs, directions, cut-offs, onset, quantities.")]


def measurement(file: Path, asked: Mapping[str, str | None]) -> Reading[Profile | Surface]:
    """Return the profile or surface in a file, and what was understood of it, by options that are texts."""
    from stiction.studies.pair_options import split_list
    from stiction.surfaces.measured.reading import load_reading
    from stiction.surfaces.measured.spectrum_file import is_spectrum

    if is_spectrum(file):
        raise ValueError(
            f"{printable_path(file)}: is the spectrum of several scans, which stiction pair takes in place of one"
        )
    announce_reader(file)
    given: dict[str, Any] = {name: split_list(name, text) for name, text in asked.items() if text is not None}
    return load_reading(file, **given)


def announce_reader(file: Path) -> None:
    """Tell whoever watches that what reads a file of an instrument takes longer to load than the file to be read."""
    from stiction.surfaces.measured.reading import READERS

    if file.suffix.lower() not in READERS and file.is_file() and "SurfaceTopography" not in sys.modules:
        announce(f"loading SurfaceTopography, which takes some seconds, to read {printable_path(file.name)}")


def refuse(context: typer.Context, why: str, *names: str) -> None:
    """Options that are given where they do not apply."""
    for name in names:
        if option_was_given(context, name):
            option = f"--{name.replace('_', '-')}"
            value = context.params[name]
            raise ValueError(f"{option} {why}, got {option}" + (f" {value}" if value is not True else ""))
