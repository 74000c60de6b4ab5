"""Commands on measured profiles and surfaces: characterise, pair."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import typer

from stiction._checks import choice
from stiction._units import quantity
from stiction.cli.application import app
from stiction.surfaces.formats import read_measurement
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

# Of every command that reads measured profiles or surfaces.
Unit = Annotated[
    str | None,
    typer.Option(
        "--unit",
        metavar="UNIT",
        help='Of the lengths in the file, "um", or of positions and heights, "mm,um". Needed where it says none.',
        show_default=False,
    ),
]
Spacing = Annotated[
    str | None,
    typer.Option(
        "--spacing",
        metavar="LENGTH",
        help='Distance of points, "0.5 um", or of rows and of columns, "2 um,0.5 um". Needed where the file has none.',
        show_default=False,
    ),
]
Units = Annotated[
    list[str] | None,
    typer.Option("--unit", metavar="UNIT", help="As for characterise; twice if the files differ.", show_default=False),
]
Spacings = Annotated[
    list[str] | None,
    typer.Option("--spacing", metavar="LENGTH", help="The same.", show_default=False),
]
MissingPoints = Annotated[
    str, typer.Option("--missing", metavar="error|interpolate", help="What to do about points without a height.")
]


@app.command()
def characterise(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A measured profile or surface.")],
    unit: Unit = None,
    spacing: Spacing = None,
    missing: MissingPoints = "error",
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
            help="What to subtract: none, mean, line or quadratic; of a surface none, mean or plane.",
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
        typer.Option("--output", "-o", metavar="PNG", help="The figure to draw.", show_default="./FILE.png"),
    ] = None,
) -> None:
    """Show what a measured profile or surface is like: parameters, spectrum, Hurst exponent."""
    from stiction.surfaces.lines import line_roughness
    from stiction.views import characterisation as views
    from stiction.views.figures import save_picture

    fitted = _band(band)
    body = _levelled(_line(_measurement(file, unit, spacing, missing), row, column), level)
    if isinstance(body, Profile):
        typer.echo(views.characterisation_text(body, band=fitted), nl=False)
        figure = views.characterisation_figure(body, band=fitted)
    else:
        along_x, along_y = (line_roughness(body, along, band=fitted) for along in ("x", "y"))
        typer.echo(views.surface_characterisation_text(body, along_x, along_y), nl=False)
        figure = views.surface_characterisation_figure(body, along_x, along_y)
    path = output if output is not None else Path(f"{file.stem}.png")
    save_picture(figure, path)
    typer.echo(f"wrote {path}")


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
    choice("--level", level, Literal["none", "mean", "plane"])
    return levelled(body, level)


def _band(text: str | None) -> tuple[float, float] | None:
    """Two wavelengths in µm."""
    if text is None:
        return None
    parts = text.split(",")
    if len(parts) != 2:
        raise ValueError(f'--band needs two wavelengths, as in "1 um,100 um", got {text!r}')
    shortest, longest = (_quantity("--band", part.strip(), "length") for part in parts)
    return shortest, longest


@app.command()
def pair(
    upper: Annotated[Path, typer.Argument(metavar="UPPER", help="A measured profile or surface: the slider.")],
    lower: Annotated[Path, typer.Argument(metavar="LOWER", help="What it is carried over; the same file may be both.")],
    effective_modulus: Annotated[str, typer.Option("--effective-modulus", metavar="PRESSURE", help='As in "10 GPa".')],
    mu0: Annotated[float, typer.Option("--mu0", metavar="NUMBER", help="Molecular friction coefficient.")],
    load: Annotated[
        list[str], typer.Option("--load", metavar="FORCE", help='Normal load on the slider, "0.1 mN". Repeatable.')
    ],
    tau0: Annotated[str, typer.Option("--tau0", metavar="PRESSURE", help="Adhesive shear strength.")] = "0 MPa",
    offsets: Annotated[
        int | None,
        typer.Option(
            "--offsets", min=1, help="Positions along the lower profile.", show_default="16, or 1 for several lines"
        ),
    ] = None,
    travel: Annotated[
        str | None,
        typer.Option("--travel", metavar="LENGTH", help="Offset of the last position.", show_default="half the length"),
    ] = None,
    lines: Annotated[int, typer.Option("--lines", min=1, help="Pairs of lines of surfaces, or of surrogates.")] = 16,
    along: Annotated[str, typer.Option("--along", metavar="x|y", help="Direction of the lines of surfaces.")] = "x",
    level: Annotated[
        str, typer.Option("--level", metavar="mean|line|quadratic|none", help="What is taken off each line.")
    ] = "line",
    surrogates: Annotated[
        str,
        typer.Option(
            "--surrogates",
            metavar="none|upper|lower|both",
            help="Replaced by profiles of equal spectrum, new phases.",
        ),
    ] = "none",
    seed: Annotated[int, typer.Option("--seed", help="Of the surrogates.")] = 2016,
    law: Annotated[str, typer.Option("--law", metavar="hertz-sphere|hertz-cylinder", help="Contact law.")] = (
        "hertz-sphere"
    ),
    detection: Annotated[
        str, typer.Option("--detection", metavar="gap-minimum|cell", help="How contacts are found.")
    ] = "gap-minimum",
    curvature: Annotated[
        str, typer.Option("--curvature", metavar="convex|signed", help="Whether cups count as well.")
    ] = "convex",
    unit: Units = None,
    spacing: Spacings = None,
    missing: MissingPoints = "error",
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Where the results go.")] = Path("pair"),
) -> None:
    """Static friction of two measured profiles or surfaces at given loads, in both directions, with intervals.

    Heights of both files point out of the material. A profile is carried over the other; of surfaces, lines are paired.
    """
    from stiction.studies import export as exports
    from stiction.studies import traverse as traverses
    from stiction.views import traverse as views

    bodies = [
        _measurement(file, _either(unit, index, "--unit"), _either(spacing, index, "--spacing"), missing)
        for index, file in enumerate((upper, lower))
    ]
    loads = [_quantity("--load", each, "force") for each in load]
    contact: Any = {
        "effective_modulus": _quantity("--effective-modulus", effective_modulus, "pressure"),
        "law": law,
        "detection": detection,
        "curvature": curvature,
    }
    uppers, lowers = traverses.paired_lines(
        *bodies,
        travel=None if travel is None else _quantity("--travel", travel, "length"),
        level=None if level == "none" else level,  # type: ignore[arg-type]
        lines=lines, along=along, surrogates=surrogates, seed=seed,  # type: ignore[arg-type]
    )  # fmt: skip
    table = output / "result.nc"
    if table.exists():
        raise ValueError(f"{table}: exists already; say where the results shall go with --output DIR")
    room = lowers[0].extent - uppers[0].extent
    positions = offsets if offsets is not None else 1 if len(uppers) > 1 else 16
    if positions > 1 and not room > 0:
        raise ValueError(f"--offsets {positions} needs a --travel LENGTH, for which the slider is shortened")
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f"{output}: cannot be written: {os.strerror(error.errno or 0)}") from None
    result = traverses.traverse(
        uppers, lowers, traverses.loads_around(loads),
        mu0=mu0, tau0=_quantity("--tau0", tau0, "pressure"),
        # One line on itself is no pair at 0; several are not on themselves.
        offsets=0.0 if len(uppers) > 1 and positions == 1 and travel is None
        else room * np.arange(1, positions + 1) / positions,
        progress=sys.stderr.isatty(), **contact,
    )  # fmt: skip
    mean = traverses.traverse_mean(result)
    typer.echo(views.traverse_text(result, mean, loads), nl=False)
    exports.export(result, table)
    typer.echo(f"wrote {table}")
    for path in views.save_traverse_figures(result, mean, loads, uppers, lowers, output, **contact):
        typer.echo(f"wrote {path}")


def _quantity(option: str, text: str, kind: str) -> float:
    try:
        return float(quantity(text, kind))
    except ValueError as error:
        raise ValueError(f"{option} {error}") from None


def _either(values: list[str] | None, index: int, option: str) -> str | None:
    """An option that is given once for both files, or for each of them."""
    if not values:
        return None
    if len(values) > 2:
        raise ValueError(f"{option} is for both files, or given twice for one after the other, got {len(values)}")
    return values[index] if len(values) == 2 else values[0]


def _measurement(file: Path, unit: str | None, spacing: str | None, missing: str) -> Profile | Surface:
    """What a file holds, by the options that every command takes for it."""
    return read_measurement(file, unit=_one_or_pair(unit), spacing=_one_or_pair(spacing), missing=missing)  # type: ignore[arg-type]


def _one_or_pair(text: str | None) -> Any:
    return text if text is None or "," not in text else tuple(part.strip() for part in text.split(","))
