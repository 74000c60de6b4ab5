"""`stiction characterise`: one measured profile or surface."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from stiction._checks import choice
from stiction._text import named
from stiction.cli.application import command, tell
from stiction.cli.options import Channel, Columns, Json, MissingPoints, Spacing, Unit, measurement, quantity_of
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface


@command(
    "characterise",
    "stiction characterise lapped.csv",
    "stiction characterise map.npy --unit nm --spacing '2 um,0.5 um' --row 17",
    "stiction characterise *.csv --output finishes.csv",
    "stiction characterise lapped.csv --json",
)
def characterise(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Measured profiles or surfaces.")],
    unit: Unit = None,
    spacing: Spacing = None,
    missing: MissingPoints = "error",
    channel: Channel = None,
    columns: Columns = None,
    row: Annotated[
        int | None, typer.Option("--row", metavar="N", min=0, help="Of a surface, this row alone, from 0 on.")
    ] = None,
    column: Annotated[
        int | None, typer.Option("--column", metavar="N", min=0, help="Of a surface, this column alone, from 0 on.")
    ] = None,
    level: Annotated[
        str | None,
        typer.Option(
            "--level",
            metavar="TREND",
            help="What to subtract: none, mean, line or quadratic; of a surface none, mean, plane or quadratic.",
            show_default="line, plane",
        ),
    ] = None,
    band: Annotated[
        str | None,
        typer.Option(
            "--band",
            metavar="SHORTEST,LONGEST",
            help='Wavelengths to fit the Hurst exponent to, "1 um,100 um".',
            show_default="found",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="The figure to draw, or the table to write of several files.",
            show_default="./FILE.png, ./characterised.csv",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Show what a measured profile or surface is like: parameters, spectrum, Hurst exponent.

    Of one file it prints a table and draws a figure; of several it writes one CSV file, a row for each.
    """
    from stiction.surfaces.lines import lines_along_both
    from stiction.views import characterisation as views
    from stiction.views import records
    from stiction.views.style import save_picture

    fitted = _band(band)
    told = []
    for file in files:
        body = _levelled(_line(measurement(file, unit, spacing, missing, channel, columns), row, column), level)
        if as_json or len(files) > 1:
            told.append((str(file), body, records.characterisation(body, fitted)))
    if as_json:
        tell(records.characterisation_record(told))
        return
    if len(files) > 1:
        table = output if output is not None else Path("characterised.csv")
        if table.exists():
            raise ValueError(f"{named(table)}: exists already; --output FILE.csv puts the table elsewhere")
        text = records.characterisation_csv(told)
        table.write_text(text, encoding="utf-8")
        tell(f"wrote {table}, {len(files)} files")
        return
    if isinstance(body, Profile):
        tell(views.characterisation_text(body, band=fitted))
        figure = views.characterisation_figure(body, band=fitted)
    else:
        along_x, along_y = lines_along_both(body, band=fitted)
        tell(views.surface_characterisation_text(body, along_x, along_y, band=fitted))
        figure = views.surface_characterisation_figure(body, along_x, along_y, band=fitted)
    path = output if output is not None else Path(f"{files[0].stem}.png")
    save_picture(figure, path)
    tell(f"wrote {path}")


def _line(body: Profile | Surface, row: int | None, column: int | None) -> Profile | Surface:
    """A row or a column of a surface, if one is asked for."""
    for name, index, other in (("row", row, column), ("column", column, row)):
        if index is None:
            continue
        if isinstance(body, Profile) or other is not None:
            raise ValueError(f"--{name} is " + ("for surfaces" if other is None else "not for use with --column"))
        count = body.heights.shape[name == "column"]
        if index >= count:
            raise ValueError(f"--{name} must be at most {count - 1}, got {index}")
        return body.row(index) if name == "row" else body.column(index)
    return body


def _levelled(body: Profile | Surface, level: Any) -> Profile | Surface:
    if level == "none":
        return body
    if isinstance(body, Profile):
        level = "line" if level is None else level
        choice("--level", level, Literal["none", "mean", "line", "quadratic"])
        return levelled(body, level)
    level = "plane" if level is None else level
    choice("--level", level, Literal["none", "mean", "plane", "quadratic"])
    return levelled(body, level)


def _band(text: str | None) -> tuple[float, float] | None:
    """Two wavelengths in µm."""
    if text is None:
        return None
    parts = text.split(",")
    if len(parts) != 2:
        raise ValueError(f'--band needs two wavelengths, as in "1 um,100 um", got {text!r}')
    shortest, longest = (quantity_of("--band", part.strip(), "length") for part in parts)
    if not shortest < longest:
        raise ValueError(f"--band must be the shortest and then the longest wavelength, got {text!r}")
    return shortest, longest
