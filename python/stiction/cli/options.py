"""Options that several commands share, and loading of a scan with the reading options of a command."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction._text import printable_path
from stiction.cli.application import option_was_given, show_status

if TYPE_CHECKING:
    from stiction.surfaces.measured.reading import FileReading
    from stiction.surfaces.profile import Profile
    from stiction.surfaces.surface import Surface


def option(
    flags: str, description: str, default: str | bool = True, *, panel: str | None = None, minimum: int | None = None
) -> Any:
    """Declare a command-line option for typer.

    `flags` contains the names of the option and, unless it is a switch, a placeholder for its value, as in "--output -o
    DIR". `default` is the text that is shown as default value, or a bool that determines whether the actual default is
    shown. `panel` is the section of the help.
    """
    names = [word for word in flags.split() if word.startswith("-")]
    placeholder = " ".join(flags.split()[len(names) :]) or None
    return typer.Option(
        *names, metavar=placeholder, help=description, show_default=default, rich_help_panel=panel, min=minimum
    )


Mu0Option = Annotated[
    str | None, option("--mu0 NUMBERS", 'Molecular friction coefficients, such as "0.3,0.4".', "mu0 of the study")
]
Tau0Option = Annotated[
    str | None, option("--tau0 PRESSURES", 'Adhesive shear strengths, such as "0 MPa,50 MPa".', "tau0 of the study")
]
_output_option = partial(option, panel="Output")
JsonOption = Annotated[bool, _output_option("--json", "Print JSON on standard output, and messages on standard error.")]
VerboseOption = Annotated[
    bool, _output_option("--verbose -v", "Show all: inputs, directions, cutoffs, onset, quantities.")
]

WorkersOption = Annotated[
    int | None, option("--workers -w N", "Number of threads.", "one per core", minimum=1, panel="Computing")
]

SchedulerOption = Annotated[str | None, option(
    "--scheduler ADDRESS",
    "Compute on the workers of a Dask scheduler, such as tcp://host:8786.", False, panel="Computing",
)]  # fmt: skip

PartOption = Annotated[
    str | None, option("--part I/N", "Compute only the I-th of N parts, such as 3/16.", False, panel="Computing")
]


def load_measurement(file: Path, options: Mapping[str, str | None]) -> FileReading[Profile | Surface]:
    """Load a profile or surface from a file, with the reading options on the command line."""
    from stiction.study.pair_options import split_option_text
    from stiction.surfaces.measured.reading import read_with_interpretation
    from stiction.surfaces.measured.spectrum_file import is_spectrum_file

    if is_spectrum_file(file):
        raise ValueError(
            f"{printable_path(file)} is a spectrum of several scans; only stiction pair accepts a spectrum instead of "
            "a scan"
        )
    show_reader_import_status(file)
    values: dict[str, Any] = {name: split_option_text(name, text) for name, text in options.items() if text is not None}
    return read_with_interpretation(file, **values)


def show_reader_import_status(file: Path) -> None:
    """Show a message on the terminal if SurfaceTopography must be imported to read a file."""
    from stiction.surfaces.measured.reading import READERS

    if file.suffix.lower() not in READERS and file.is_file() and "SurfaceTopography" not in sys.modules:
        show_status(f"loading SurfaceTopography, which takes some seconds, to read {printable_path(file.name)}")


def reject_options(context: typer.Context, reason: str, *names: str) -> None:
    """Raise a `ValueError` with the given reason if the command line contains one of the named options."""
    for name in names:
        if option_was_given(context, name):
            option = f"--{name.replace('_', '-')}"
            value = context.params[name]
            value_text = "" if value is True else f" {' '.join(value) if isinstance(value, list) else value}"
            raise ValueError(f"{option} {reason}; remove {option}{value_text}")
