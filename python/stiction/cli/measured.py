"""Commands on measured profiles and surfaces: characterise, pair."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import typer

from stiction._checks import choice
from stiction._units import quantity
from stiction.cli.application import app, say, tell
from stiction.cli.map_pair import chosen_mechanics, draw_map_pair, prepared, press_areas, show_map_pair
from stiction.mechanics.closed_forms import effective_modulus as _effective_modulus
from stiction.mechanics.law import NAMED, JacksonGreen
from stiction.studies.map_pair import SHIFTS
from stiction.studies.map_pair import TITLE as MAP_PAIR
from stiction.surfaces.measured.reading import read_measurement
from stiction.surfaces.pairing import LINES
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
Channel = Annotated[
    str | None,
    typer.Option(
        "--channel",
        metavar="NAME|NUMBER",
        help="What to read of a file of several channels or sheets, numbers from 0 on.",
        show_default="the first of heights",
    ),
]
Columns = Annotated[
    str | None,
    typer.Option(
        "--columns",
        metavar="X,Z|Z",
        help="Of a table, names or numbers from 0 on, of positions and heights or of heights.",
        show_default=False,
    ),
]
ChannelOfEach = Annotated[
    list[str] | None,
    typer.Option("--channel", metavar="NAME|NUMBER", help="The same.", show_default=False),
]
ColumnsOfEach = Annotated[
    list[str] | None,
    typer.Option("--columns", metavar="X,Z|Z", help="The same.", show_default=False),
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
        typer.Option("--output", "-o", metavar="PNG", help="The figure to draw.", show_default="./FILE.png"),
    ] = None,
) -> None:
    """Show what a measured profile or surface is like: parameters, spectrum, Hurst exponent."""
    from stiction.surfaces.lines import lines_along_both
    from stiction.views import characterisation as views
    from stiction.views.figures import save_picture

    fitted = _band(band)
    body = _levelled(_line(_measurement(file, unit, spacing, missing, channel, columns), row, column), level)
    if isinstance(body, Profile):
        tell(views.characterisation_text(body, band=fitted))
        figure = views.characterisation_figure(body, band=fitted)
    else:
        along_x, along_y = lines_along_both(body, band=fitted)
        tell(views.surface_characterisation_text(body, along_x, along_y, band=fitted))
        figure = views.surface_characterisation_figure(body, along_x, along_y, band=fitted)
    path = output if output is not None else Path(f"{file.stem}.png")
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
    shortest, longest = (_quantity("--band", part.strip(), "length") for part in parts)
    return shortest, longest


@app.command()
def pair(
    upper: Annotated[Path, typer.Argument(metavar="UPPER", help="A measured profile or surface: the slider.")],
    lower: Annotated[Path, typer.Argument(metavar="LOWER", help="What it is carried over; the same file may be both.")],
    mu0: Annotated[
        str, typer.Option("--mu0", metavar="NUMBERS", help='Molecular friction coefficients, "0.3" or "0.3,0.4".')
    ],
    load: Annotated[
        list[str],
        typer.Option(
            "--load",
            metavar="FORCE",
            help='Normal load on the slider, "0.1 mN", or per its area, "10 MPa". Repeatable.',
        ),
    ],
    effective_modulus: Annotated[
        str | None,
        typer.Option("--effective-modulus", metavar="PRESSURE", help='E*, as in "10 GPa".', show_default=False),
    ] = None,
    young: Annotated[
        str | None,
        typer.Option(
            "--young",
            metavar="PRESSURES",
            help='Instead of E*: Young\'s modulus of both bodies or of one after the other, "200 GPa,70 GPa".',
            show_default=False,
        ),
    ] = None,
    poisson: Annotated[
        str | None,
        typer.Option(
            "--poisson", metavar="NUMBERS", help='Poisson\'s ratios, "0.3" or "0.3,0.33".', show_default=False
        ),
    ] = None,
    tau0: Annotated[
        str, typer.Option("--tau0", metavar="PRESSURES", help='Adhesive shear strengths, "0 MPa,50 MPa".')
    ] = "0 MPa",
    offsets: Annotated[
        int | None,
        typer.Option(
            "--offsets", min=1, help="Positions along the lower profile.", show_default="64, or 1 for several lines"
        ),
    ] = None,
    travel: Annotated[
        str | None,
        typer.Option("--travel", metavar="LENGTH", help="Offset of the last position.", show_default="half the length"),
    ] = None,
    lines: Annotated[
        int | None,
        typer.Option(
            "--lines",
            metavar="N",
            min=1,
            help="Press so many pairs of lines of maps instead of their areas; also of surrogates.",
            show_default=f"{LINES} of surrogates, and of a map and a profile",
        ),
    ] = None,
    along: Annotated[
        str | None,
        typer.Option("--along", metavar="x|y", help="Direction of the lines of surfaces.", show_default="x"),
    ] = None,
    level: Annotated[
        str | None,
        typer.Option(
            "--level",
            metavar="TREND",
            help="What is taken off each line: mean, line, quadratic or none; off each map: plane or quadratic.",
            show_default="line, plane",
        ),
    ] = None,
    surrogates: Annotated[
        str | None,
        typer.Option(
            "--surrogates",
            metavar="none|upper|lower|both",
            help="Lines replaced by profiles of equal spectrum, new phases.",
            show_default="none",
        ),
    ] = None,
    seed: Annotated[int | None, typer.Option("--seed", help="Of the surrogates.", show_default="2016")] = None,
    law: Annotated[
        str | None,
        typer.Option(
            "--law",
            metavar="hertz-sphere|hertz-cylinder|jackson-green",
            help="Contact law of lines.",
            show_default="hertz-sphere",
        ),
    ] = None,
    yield_strength: Annotated[
        str | None,
        typer.Option(
            "--yield-strength", metavar="PRESSURE", help="Of the softer body, for jackson-green.", show_default=False
        ),
    ] = None,
    hardness: Annotated[
        str | None,
        typer.Option(
            "--hardness",
            metavar="PRESSURE",
            help="For jackson-green instead of it: 2.84 times as much. Of maps: the most that the pressure can be.",
            show_default=False,
        ),
    ] = None,
    detection: Annotated[
        str | None,
        typer.Option(
            "--detection",
            metavar="gap-minimum|cell",
            help="How contacts of lines are found.",
            show_default="gap-minimum",
        ),
    ] = None,
    curvature: Annotated[
        str | None,
        typer.Option(
            "--curvature",
            metavar="convex|signed",
            help="Whether cups of lines count as well.",
            show_default="convex",
        ),
    ] = None,
    mechanics: Annotated[
        str | None,
        typer.Option(
            "--mechanics",
            metavar="half-space|asperities",
            help="How maps are pressed: the exact elastic answer, or a fast one.",
            show_default="half-space",
        ),
    ] = None,
    check: Annotated[bool, typer.Option("--check", help="Press maps by both mechanics, side by side.")] = False,
    direction: Annotated[
        str | None,
        typer.Option(
            "--direction",
            metavar="DEGREES",
            help='Of maps, where the upper is about to move, from +x towards +y: "0,90".',
            show_default="the compass in 30",
        ),
    ] = None,
    shifts: Annotated[
        int | None,
        typer.Option("--shifts", metavar="N", min=1, help="Relative positions of maps.", show_default=str(SHIFTS)),
    ] = None,
    rotate: Annotated[
        float | None,
        typer.Option("--rotate", metavar="DEGREES", help="Turn the upper map in its plane.", show_default=False),
    ] = None,
    unit: Units = None,
    spacing: Spacings = None,
    missing: MissingPoints = "error",
    channel: ChannelOfEach = None,
    columns: ColumnsOfEach = None,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Where the results go.")] = Path("pair"),
    replace: Annotated[bool, typer.Option("--replace", help="Write over the results of an earlier pair.")] = False,
) -> None:
    """Static friction of two measured profiles or surfaces at given loads, in both directions, with intervals.

    Heights of both files point out of the material. A profile is carried over the other; maps are pressed as areas, or
    as pairs of lines with --lines.
    """
    from stiction.studies import export as exports
    from stiction.studies import traverse as traverses
    from stiction.surfaces.pairing import paired_lines
    from stiction.views import traverse as views

    table, listed = output / views.RESULT, output / views.TABLE
    wanted = [_load(each) for each in load]
    coefficients = _numbers("--mu0", mu0)
    strengths = [_quantity("--tau0", each, "pressure") for each in _listed(tau0)]
    modulus, ratio = _elasticity(effective_modulus, young, poisson, law or "hertz-sphere")
    bodies = [
        _measurement(
            file,
            _either(unit, index, "--unit"),
            _either(spacing, index, "--spacing"),
            missing,
            _either(channel, index, "--channel"),
            _either(columns, index, "--columns"),
        )
        for index, file in enumerate((upper, lower))
    ]
    surfaces = any(isinstance(body, Surface) for body in bodies)
    if all(isinstance(body, Surface) for body in bodies) and lines is None:
        for option, value in (
            ("--offsets", offsets), ("--travel", travel), ("--along", along), ("--surrogates", surrogates),
            ("--seed", seed), ("--law", law), ("--yield-strength", yield_strength), ("--detection", detection),
            ("--curvature", curvature),
        ):  # fmt: skip
            _refuse(option, value, "is for lines; give --lines as well", applies=False)
        by = chosen_mechanics(mechanics, check=check)
        _refuse("--hardness", hardness, "is for the half-space alone, of maps", by == ("half-space",))
        maps = prepared(*bodies, level=level, angle=rotate)  # type: ignore[arg-type]
        _check_directory(output, table, replace=replace)
        press_areas(
            *maps, wanted, mechanics=by, mu0=coefficients, tau0=strengths, effective_modulus=modulus,
            compliance_share=_compliance_share(modulus, young, poisson),
            hardness=None if hardness is None else _quantity("--hardness", hardness, "pressure"),
            directions=None if direction is None else _numbers("--direction", direction), shifts=shifts,
            files=f"{upper.name} on {lower.name}", output=output, table=table, replace=replace,
        )  # fmt: skip
        return
    areal: dict[str, object] = {
        "--mechanics": mechanics, "--check": check or None, "--direction": direction, "--shifts": shifts,
        "--rotate": rotate,
    }  # fmt: skip
    for option, given in areal.items():
        _refuse(option, given, "is for the areas of two maps, without --lines", applies=False)
    contact: Any = {
        "effective_modulus": modulus,
        "law": _law(law or "hertz-sphere", yield_strength, hardness, ratio),
        "detection": detection or "gap-minimum",
        "curvature": curvature or "convex",
    }
    surrogates = "none" if surrogates is None else surrogates
    _refuse(
        "--lines", lines, "is for surfaces and surrogates; two profiles are one pair", surfaces or surrogates != "none"
    )
    _refuse("--along", along, "is for surfaces", surfaces)
    _refuse("--seed", seed, "is for --surrogates", surrogates != "none")
    uppers, lowers = paired_lines(
        *bodies,
        travel=None if travel is None else _quantity("--travel", travel, "length"),
        level=None if level == "none" else level or "line",  # type: ignore[arg-type]
        lines=LINES if lines is None else lines,
        along="x" if along is None else along,  # type: ignore[arg-type]
        surrogates=surrogates,  # type: ignore[arg-type]
        seed=2016 if seed is None else seed,
    )
    room = lowers[0].extent - uppers[0].extent
    positions = offsets if offsets is not None else 1 if len(uppers) > 1 else OFFSETS
    if positions > 1 and not room > 0:
        raise ValueError(f"--offsets {positions} needs a --travel LENGTH, for which the slider is shortened")
    area = uppers[0].extent * traverses.THICKNESS
    loads = [amount * (area if per_area else 1.0) for amount, per_area in wanted]
    for sentence in views.doubts(uppers, lowers, loads, mu0=coefficients, **contact):
        say(sentence)
    _check_directory(output, table, replace=replace)
    result = traverses.traverse(
        uppers, lowers, traverses.loads_around(loads),
        mu0=coefficients if len(coefficients) > 1 else coefficients[0],
        tau0=strengths if len(strengths) > 1 else strengths[0],
        # One line on itself is no pair at 0; several are not on themselves.
        offsets=0.0 if len(uppers) > 1 and positions == 1 and travel is None
        else room * np.arange(1, positions + 1) / positions,
        progress=sys.stderr.isatty(), **contact,
    )  # fmt: skip
    result.attrs["loads_mN"] = np.array(loads)
    mean = traverses.traverse_mean(result)
    typer.echo(views.traverse_text(result, mean, loads), nl=False)
    exports.export(result, table, replace=replace)
    typer.echo(f"wrote {table}")
    listed.write_text(views.traverse_csv(mean, loads), encoding="utf-8")
    typer.echo(f"wrote {listed}")
    for path in views.save_traverse_figures(result, mean, loads, output, bodies=(uppers, lowers), **contact):
        typer.echo(f"wrote {path}")


def _compliance_share(modulus: float, young: str | None, poisson: str | None) -> float:
    """Of the lower body: half unless both are given."""
    if young is None or poisson is None:
        return 0.5
    stiffness, ratio = _quantity("--young", _listed(young)[-1], "pressure"), _numbers("--poisson", poisson)[-1]
    return float(modulus * (1 - ratio**2) / stiffness)


def paired(directory: Path) -> Any:
    """The result that `pair` wrote into a directory, or None."""
    import xarray

    from stiction.views.traverse import RESULT

    table = directory / RESULT
    if not table.is_file():
        return None
    try:
        with xarray.open_dataset(table, engine="h5netcdf") as kept:
            result = kept.load()
    except (OSError, ValueError, KeyError) as error:
        raise ValueError(f"{table}: cannot be read: {error}") from None
    if result.attrs.get("title") not in ("stiction traverse", MAP_PAIR) or "loads_mN" not in result.attrs:
        raise ValueError(f"{table}: is not what stiction pair wrote")
    return result


def show_pair(result: Any) -> None:
    """The table of a pair."""
    if result.attrs["title"] == MAP_PAIR:
        show_map_pair(result)
        return
    from stiction.studies.traverse import traverse_mean
    from stiction.views.traverse import traverse_text

    typer.echo(traverse_text(result, traverse_mean(result), np.atleast_1d(result.attrs["loads_mN"])), nl=False)


def draw_pair(result: Any, directory: Path) -> None:
    """The figures of a pair that need no profiles."""
    if result.attrs["title"] == MAP_PAIR:
        draw_map_pair(result, directory)
        return
    from stiction.studies.traverse import traverse_mean
    from stiction.views.traverse import save_traverse_figures

    loads = np.atleast_1d(result.attrs["loads_mN"])
    for path in save_traverse_figures(result, traverse_mean(result), loads, directory):
        typer.echo(f"wrote {path}")


OFFSETS = 64
"""Positions of one pair by default: some seconds of computing, and enough for an interval."""

_FILES = (".nc", ".csv", ".pdf", ".png", ".svg", ".txt", ".html", ".json", ".xlsx", ".zip")


def _check_directory(output: Path, table: Path, *, replace: bool) -> None:
    """Whatever would keep results from being written is said before anything is computed."""
    if output.suffix.lower() in _FILES and not output.is_dir():
        raise ValueError(f"--output {output}: is the name of a file; results go into a directory")
    if table.exists() and not replace:
        raise ValueError(f"{table}: exists already; --replace writes over it, --output DIR puts the results elsewhere")
    try:
        output.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=output):
            pass
    except OSError as error:
        raise ValueError(f"{output}: cannot be written: {os.strerror(error.errno or 0)}") from None


def _refuse(option: str, value: object, why: str, applies: bool) -> None:
    """An option that is given where it does not apply."""
    if value is not None and not applies:
        raise ValueError(f"{option} {why}, got {option} {value}")


def _listed(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")]


def _numbers(option: str, text: str) -> list[float]:
    try:
        return [float(part) for part in _listed(text)]
    except ValueError:
        raise ValueError(f'{option} must be a number or several, as in "0.3,0.4", got {text!r}') from None


def _load(text: str) -> tuple[float, bool]:
    """A load in mN, or in GPa of the slider's area, and whether it is that."""
    try:
        return float(quantity(text, "pressure")), True
    except ValueError:
        return _quantity("--load", text, "force"), False


def _elasticity(modulus: str | None, young: str | None, poisson: str | None, law: str) -> tuple[float, float | None]:
    """E* in GPa, and Poisson's ratio of the softer body if any is given."""
    if (modulus is None) == (young is None):
        raise ValueError("give --effective-modulus, or --young and --poisson" + (", not both" if young else ""))
    ratios = None if poisson is None else _numbers("--poisson", poisson)
    if ratios is not None and (len(ratios) > 2 or not all(0 <= ratio <= 0.5 for ratio in ratios)):
        raise ValueError(f"--poisson must be one or two numbers from 0 to 0.5, got {poisson!r}")
    if modulus is not None:
        _refuse("--poisson", poisson, "is for --young and --law jackson-green", law == "jackson-green")
        if ratios is not None and len(ratios) > 1:
            raise ValueError(f"--poisson beside --effective-modulus is of the softer body alone, got {poisson!r}")
        return _quantity("--effective-modulus", modulus, "pressure"), None if ratios is None else ratios[0]
    moduli = [_quantity("--young", part, "pressure") for part in _listed(str(young))]
    if len(moduli) > 2:
        raise ValueError(f"--young must be one modulus or two, got {young!r}")
    if ratios is None:
        raise ValueError("--young needs --poisson, of both bodies or of one after the other")
    (first, second), (upper, lower) = (2 * moduli)[:2], (2 * ratios)[:2]
    return float(_effective_modulus(first, upper, second, lower)), upper if first <= second else lower


def _law(law: str, yield_strength: str | None, hardness: str | None, ratio: float | None) -> Any:
    """A contact law by its name and the options that it needs."""
    names = [*NAMED, JacksonGreen.name]
    if law not in names:
        raise ValueError(f"--law must be one of {', '.join(names)}, got {law!r}")
    yields = law == JacksonGreen.name
    _refuse("--yield-strength", yield_strength, "is for --law jackson-green", yields)
    _refuse("--hardness", hardness, "is for --law jackson-green", yields)
    if not yields:
        return law
    if (yield_strength is None) == (hardness is None):
        raise ValueError("--law jackson-green needs --yield-strength or --hardness, one of them")
    if ratio is None:
        raise ValueError("--law jackson-green needs --poisson, of the softer body")
    strength = (
        _quantity("--hardness", hardness, "pressure") / HARDNESS
        if hardness is not None
        else _quantity("--yield-strength", str(yield_strength), "pressure")
    )
    return JacksonGreen(yield_strength=strength, poisson_ratio=ratio)


HARDNESS = 2.84
"""Hardness over yield strength, of the law at small contact radii."""


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


def _measurement(
    file: Path, unit: str | None, spacing: str | None, missing: str, channel: str | None, columns: str | None
) -> Profile | Surface:
    """What a file holds, by the options that every command takes for it."""
    return read_measurement(
        file, unit=_one_or_pair(unit), spacing=_one_or_pair(spacing), missing=missing,  # type: ignore[arg-type]
        channel=channel, columns=_one_or_pair(columns),
    )  # fmt: skip


def _one_or_pair(text: str | None) -> Any:
    return text if text is None or "," not in text else tuple(part.strip() for part in text.split(","))
