"""Options that several commands take, each declared once, and what their texts mean."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from stiction._text import named
from stiction.cli.application import announce
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface


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


_reading = partial(option, panel="Reading files")
_output = partial(option, panel="Output")

_unit = _reading(
    "--unit UNIT",
    'Of the lengths in the file, "um", or of positions and heights, "mm,um". Needed where it says none.',
    False,
)
_spacing = _reading(
    "--spacing LENGTH",
    'Distance of points, "0.5 um", or of rows and of columns, "2 um,0.5 um". Needed where the file has none.',
    False,
)
_channel = _reading(
    "--channel NAME|NUMBER",
    "What to read of a file of several channels or sheets, numbers from 0 on.",
    "the first of heights",
)
_columns = _reading(
    "--columns X,Z|Z", "Of a table, names or numbers from 0 on, of positions and heights or of heights.", False
)

_tip = _reading("--tip RADIUS", 'Of the stylus or the probe, "10 nm": what is sharper is its own.', False)
Json = Annotated[bool, _output("--json", "Print JSON alone on standard output; messages go elsewhere.")]
Verbose = Annotated[bool, _output("--verbose -v", "Show all: inputs, directions, cut-offs, onset, quantities.")]
Unit = Annotated[str | None, _unit]
Spacing = Annotated[str | None, _spacing]
Channel = Annotated[str | None, _channel]
Columns = Annotated[str | None, _columns]

# Of a command that reads two files: given once for both, or for one after the other.
Units = Annotated[list[str] | None, _unit]
Spacings = Annotated[list[str] | None, _spacing]
Channels = Annotated[list[str] | None, _channel]
ColumnsOfEach = Annotated[list[str] | None, _columns]
Tip = Annotated[str | None, _tip]
Tips = Annotated[list[str] | None, _tip]
MissingPoints = Annotated[str, _reading(
    "--missing error|mask|interpolate", "Of points without a height: press what is there, or put them on lines."
)]  # fmt: skip
Outliers = Annotated[str, _reading(
    "--outliers keep|mask", "Take single points beyond 6 robust deviations of their neighbours for missing ones."
)]  # fmt: skip
_crop = _reading("--crop X0,X1[,Y0,Y1]", 'What to read of the file: "10 um,60 um", of a map along x and y.', False)
Crop = Annotated[str | None, _crop]
Crops = Annotated[list[str] | None, _crop]


def option_of(argument: str) -> str:
    """How an argument is called on the command line."""
    return _OPTIONS.get(argument, f"--{argument.replace('_', '-')}")


_OPTIONS = {"upper": "UPPER", "lower": "LOWER", "upper_material": "--upper", "lower_material": "--lower"}
"""Options that are called otherwise than their arguments."""


def measurement(
    file: Path,
    unit: str | None,
    spacing: str | None,
    missing: str,
    channel: str | None,
    columns: str | None,
    outliers: str = "keep",
    crop: str | None = None,
) -> Profile | Surface:
    """What a file holds, by the options that every command takes for it."""
    from stiction.surfaces.measured.reading import read_measurement
    from stiction.surfaces.measured.spectrum_file import is_spectrum

    if is_spectrum(file):
        raise ValueError(f"{named(file)}: is the spectrum of several scans, which stiction pair takes in place of one")
    announce_reader(file)
    return read_measurement(
        file, unit=_one_or_pair(unit), spacing=_one_or_pair(spacing), missing=missing,  # type: ignore[arg-type]
        channel=channel, columns=_one_or_pair(columns), outliers=outliers, crop=crop,  # type: ignore[arg-type]
    )  # fmt: skip


def announce_reader(file: Path) -> None:
    """Tell whoever watches that what reads a file of an instrument takes longer to load than the file to be read."""
    from stiction.surfaces.measured.reading import READERS

    if file.suffix.lower() not in READERS and file.is_file() and "SurfaceTopography" not in sys.modules:
        announce(f"loading SurfaceTopography, which takes some seconds, to read {named(file.name)}")


def _one_or_pair(text: str | None) -> Any:
    return text if text is None or "," not in text else tuple(part.strip() for part in text.split(","))


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
