"""`stiction characterise`: one measured profile or surface."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from stiction._arguments import quantity_of
from stiction._checks import choice
from stiction._text import named
from stiction.cli.application import command, say, tell
from stiction.cli.options import (
    Channel,
    Columns,
    Json,
    MissingPoints,
    Spacing,
    Unit,
    given,
    measurement,
    option,
)
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

Row = Annotated[int | None, option("--row", "N", "Of a surface, this row alone, from 0 on.", least=0)]
Column = Annotated[int | None, option("--column", "N", "Of a surface, this column alone, from 0 on.", least=0)]
Level = Annotated[
    str | None,
    option(
        "--level",
        "TREND",
        "What to subtract: none, mean, line or quadratic; of a surface none, mean, plane or quadratic.",
        "line, plane",
    ),
]
Band = Annotated[
    str | None,
    option("--band", "SHORTEST,LONGEST", 'Wavelengths to fit the Hurst exponent to, "1 um,100 um".', "found"),
]
CutOff = Annotated[
    str | None,
    option("--cutoff", "LENGTH", 'Take off waves shorter than this (Gaussian), "0.1 um".', "the scan as it is"),
]
Tip = Annotated[
    str | None, option("--tip", "RADIUS", 'Of the stylus or the probe, "10 nm": what is sharper is its own.', False)
]
Together = Annotated[
    bool,
    option("--together", None, "Several scans of one surface, alike in all directions: one spectrum."),
]
Output = Annotated[
    Path | None,
    option(
        "--output -o",
        "FILE",
        "What to write, by its ending: of a file its page or its figure, of several a table, of --together either.",
        "./FILE.html and .png, ./characterised.csv, ./joined.csv and .png",
    ),
]


@command(
    "characterise",
    "stiction characterise lapped.csv",
    "stiction characterise map.npy --unit nm --spacing '2 um,0.5 um' --row 17",
    "stiction characterise *.csv --output finishes.csv",
    "stiction characterise lapped.csv --cutoff '100 nm' --tip '2 um' --json",
    "stiction characterise coarse.x3p fine.di --together",
)
def characterise(
    context: typer.Context,
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="Measured profiles or surfaces.")],
    unit: Unit = None,
    spacing: Spacing = None,
    missing: MissingPoints = "error",
    channel: Channel = None,
    columns: Columns = None,
    row: Row = None,
    column: Column = None,
    level: Level = None,
    band: Band = None,
    cutoff: CutOff = None,
    tip: Tip = None,
    together: Together = False,
    output: Output = None,
    as_json: Json = False,
) -> None:
    """Show what a measured profile or surface is like: parameters, spectrum, Hurst exponent.

    Of one file it prints a table, makes a page for any browser and draws a figure; of several it writes one CSV file, a
    row for each. With --json it writes only what --output says.
    """
    from stiction.views import roughness_rows as rows

    fitted = _band(band)
    shortest = None if cutoff is None else quantity_of("cutoff", cutoff, "length")
    radius = None if tip is None else quantity_of("tip", tip, "length")
    bodies = [
        _cut_off(
            _levelled(_line(measurement(file, unit, spacing, missing, channel, columns), row, column), level), shortest
        )
        for file in files
    ]
    if together:
        _together(files, bodies, radius, output, as_json=as_json)
        return
    told = [
        (str(file), body, rows.characterisation(body, fitted, radius))
        for file, body in zip(files, bodies, strict=True)
        if as_json or len(files) > 1
    ]
    if as_json:
        tell(rows.characterisation_record(told))
    if output is None and as_json:
        return
    if len(files) > 1:
        _write(output or Path("characterised.csv"), rows.characterisation_csv(told), f"{len(files)} files", as_json)
    else:
        _show(context, files[0], bodies[0], fitted, radius)


def _write(table: Path, text: str, what: str, as_json: bool) -> None:
    """Write a new CSV file, and say so."""
    if table.exists():
        raise ValueError(f"{named(table)}: exists already; --output FILE.csv puts the table elsewhere")
    table.write_text(text, encoding="utf-8")
    (say if as_json else tell)(f"wrote {table}, {what}")


def _together(
    files: list[Path], bodies: list[Profile | Surface], radius: float | None, output: Path | None, *, as_json: bool
) -> None:
    """Say what several scans of one surface are together, and write their spectrum."""
    from stiction.surfaces.joined import joined_spectrum
    from stiction.surfaces.measured.spectrum_file import write_spectrum
    from stiction.views import scale_rows
    from stiction.views.figures.joined import joined_figure
    from stiction.views.rows import record
    from stiction.views.style import save_picture

    if len(files) < 2:
        raise ValueError("--together is for several scans of one surface, got 1")
    names = [file.name for file in files]
    names = names if len(set(names)) == len(names) else list(map(str, files))
    joined = joined_spectrum(bodies, tip_radii=[radius] * len(bodies), names=names)
    if as_json:
        tell(record("characterise", [], kind="joined", **scale_rows.joined_record(joined)))
    else:
        tell(scale_rows.joined_text(joined))
    if output is not None or not as_json:
        for path in (Path("joined.csv"), Path("joined.png")) if output is None else (output,):
            if path.suffix.lower() == ".csv":
                write_spectrum(joined, path)
            else:
                save_picture(joined_figure(joined), path)
            (say if as_json else tell)(f"wrote {path}, {len(files)} scans")


def _cut_off(body: Profile | Surface, shortest: float | None) -> Profile | Surface:
    """A body without waves shorter than this (µm), if that is asked for."""
    from stiction.surfaces.cut_off import cut_off

    try:
        return body if shortest is None else cut_off(body, shortest)
    except ValueError as error:
        raise ValueError(str(error).replace("wavelength", "--cutoff", 1)) from None


def _show(
    context: typer.Context, file: Path, body: Profile | Surface, band: tuple[float, float] | None, radius: float | None
) -> None:
    """Print the table of one body, make its page, and draw its figure."""
    from stiction.surfaces.lines import lines_along_both
    from stiction.views import characterisation as views
    from stiction.views.figures import roughness
    from stiction.views.report.surface import surface_page
    from stiction.views.style import save_picture

    output, as_json = context.params["output"], context.params["as_json"]
    along = () if isinstance(body, Profile) else lines_along_both(body, band=band)
    if not as_json:
        tell(
            views.characterisation_text(body, band=band, tip_radius=radius)
            if isinstance(body, Profile)
            else views.surface_characterisation_text(body, *along, band=band, tip_radius=radius)
        )
    for path in (Path(f"{file.stem}.html"), Path(f"{file.stem}.png")) if output is None else (output,):
        if path.suffix.lower() == ".html":
            words = {"name": file.name, "command": _same_as(context, file)}
            surface_page(body, along, band=band, tip_radius=radius, **words).save(path)
        else:
            figure = (
                roughness.characterisation_figure(body, band=band)
                if isinstance(body, Profile)
                else roughness.surface_characterisation_figure(body, *along, band=band)
            )
            save_picture(figure, path)
        (say if as_json else tell)(f"wrote {path}")


def _same_as(context: typer.Context, file: Path) -> str:
    """The command that makes this page: what was given, but for the folder of the file and of the output."""
    words = ["stiction", "characterise", file.name]
    for each in context.command.params:
        if each.name not in ("files", "output", "as_json") and given(context, each.name):
            words += [each.opts[0], str(context.params[each.name])]
    return shlex.join(words)


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
    shortest, longest = (quantity_of("band", part.strip(), "length") for part in parts)
    if not shortest < longest:
        raise ValueError(f"--band must be the shortest and then the longest wavelength, got {text!r}")
    return shortest, longest
