"""`stiction pair`: two measured profiles or surfaces, as lines or as areas, and what it wrote."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, get_args

import typer

from stiction.cli.application import command
from stiction.cli.line_pair import draw_line_pair, press_lines, show_line_pair
from stiction.cli.map_pair import draw_map_pair, map_level, prepared, press_areas, show_map_pair
from stiction.cli.material import compliance_share, elasticity, law_of
from stiction.cli.options import (
    Channels,
    ColumnsOfEach,
    Json,
    MissingPoints,
    Spacings,
    Units,
    at_least_0,
    given,
    listed,
    load_of,
    measurement,
    numbers,
    of_each,
    quantity_of,
    refuse,
)
from stiction.studies.map_pair import SHIFTS, Mechanics
from stiction.studies.map_pair import TITLE as MAP_PAIR
from stiction.surfaces.pairing import LINES
from stiction.surfaces.preparation import levelled, turned_over
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

_OF_LINES = (
    "offsets", "travel", "along", "law", "yield_strength", "detection", "curvature",
)  # fmt: skip
_OF_AREAS = ("direction", "shifts", "rotate")


@command(
    "pair",
    "stiction pair upper.csv lower.csv --young '210 GPa' --poisson 0.3 --mu0 0.2 --tau0 '50 MPa' --load '10 mN'",
    "stiction pair map.npy map.npy --unit nm --spacing '1 um' --effective-modulus '9 GPa' --mu0 0.3 --load '9 MPa'",
    "stiction pair scan.csv scan.csv --surrogates both --effective-modulus '10 GPa' --mu0 0.3 --load '1 mN' --json",
)
def pair(
    context: typer.Context,
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
            "--offsets",
            metavar="N",
            min=1,
            help="Positions along the lower profile.",
            show_default="64, or 1 for several lines",
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
        str,
        typer.Option("--along", metavar="x|y", help="Direction of the lines of surfaces."),
    ] = "x",
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
        str,
        typer.Option(
            "--surrogates",
            metavar="N|none|upper|lower|both",
            help="Of areas: press so many pairs of surfaces of equal spectrum as well. Of lines: what they replace.",
        ),
    ] = "none",
    seed: Annotated[
        int, typer.Option("--seed", metavar="N", help="Where the random phases of surrogates start.")
    ] = 2016,
    law: Annotated[
        str,
        typer.Option(
            "--law",
            metavar="hertz-sphere|hertz-cylinder|jackson-green",
            help="Contact law of lines.",
        ),
    ] = "hertz-sphere",
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
        str,
        typer.Option(
            "--detection",
            metavar="gap-minimum|cell",
            help="How contacts of lines are found.",
        ),
    ] = "gap-minimum",
    curvature: Annotated[
        str,
        typer.Option(
            "--curvature",
            metavar="convex|signed",
            help="Whether cups of lines count as well.",
        ),
    ] = "convex",
    mechanics: Annotated[
        str | None,
        typer.Option(
            "--mechanics",
            metavar="half-space|asperities",
            help="The exact elastic answer (of lines: of half-planes), or a fast one.",
            show_default="half-space of maps, asperities of lines",
        ),
    ] = None,
    check: Annotated[bool, typer.Option("--check", help="Press by both mechanics, side by side.")] = False,
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
        int,
        typer.Option("--shifts", metavar="N", min=1, help="Relative positions of maps."),
    ] = SHIFTS,
    lay: Annotated[
        str | None,
        typer.Option(
            "--lay",
            metavar="grooves|isotropic",
            help="Of two profiles: across grooves, pressed as lines; or of surfaces alike in all directions, as areas.",
            show_default="lines",
        ),
    ] = None,
    rotate: Annotated[
        float | None,
        typer.Option("--rotate", metavar="DEGREES", help="Turn the upper map in its plane.", show_default=False),
    ] = None,
    unit: Units = None,
    spacing: Spacings = None,
    missing: MissingPoints = "error",
    channel: Channels = None,
    columns: ColumnsOfEach = None,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Where the results go.")] = Path("pair"),
    replace: Annotated[bool, typer.Option("--replace", help="Write over the results of an earlier pair.")] = False,
    as_json: Json = False,
) -> None:
    """Static friction of two measured profiles or surfaces at given loads, in both directions, with intervals.

    Heights of both files point out of the material. A profile is carried over the other; maps are pressed as areas, or
    as pairs of lines with --lines. What describes a file is given once for both, or twice, for one after the other.
    """
    from stiction.views.traverse import RESULT

    loads = [load_of(each) for each in load]
    for each, (amount, _) in zip(load, loads, strict=True):
        if not amount > 0:
            raise ValueError(f"--load must be above 0, got {each!r}")
    modulus, ratio = elasticity(context, effective_modulus, young, poisson, law)
    slider, base = (
        measurement(
            file,
            of_each(unit, index, "--unit"),
            of_each(spacing, index, "--spacing"),
            missing,
            of_each(channel, index, "--channel"),
            of_each(columns, index, "--columns"),
        )
        for index, file in enumerate((upper, lower))
    )
    common: dict[str, Any] = {
        "mu0": at_least_0("--mu0", numbers("--mu0", mu0), mu0),
        "tau0": at_least_0("--tau0", [quantity_of("--tau0", each, "pressure") for each in listed(tau0)], tau0),
        "effective_modulus": modulus,
        "output": output,
        "table": output / RESULT,
        "replace": replace,
        "as_json": as_json,
    }
    maps = isinstance(slider, Surface) and isinstance(base, Surface) and lines is None
    isotropic = _isotropic(slider, base, lay)
    if mechanics is not None and mechanics not in get_args(Mechanics):
        raise ValueError(f"--mechanics must be {' or '.join(get_args(Mechanics))}, got {mechanics!r}")
    if check and mechanics is not None:
        raise ValueError(f"--check presses by both, so --mechanics {mechanics} must not be given beside it")
    usual = "half-space" if maps or isotropic else "asperities"
    by = get_args(Mechanics) if check else (mechanics or usual,)
    if maps or isotropic:
        refuse(context, "is for lines; give --lines as well" if maps else "is for --lay grooves", *_OF_LINES)
        if by != ("half-space",):
            refuse(context, "is for the half-space alone, of maps", "hardness")
        if isotropic:
            refuse(context, "is for maps; of profiles give --surrogates", "shifts", "rotate", "lines")
            assert isinstance(slider, Profile)
            assert isinstance(base, Profile)
            trend: Any = "line" if level is None else level
            bodies: tuple[Profile, Profile] | tuple[Surface, Surface] = (
                turned_over(levelled(slider, trend)), levelled(base, trend),
            )  # fmt: skip
        else:
            assert isinstance(slider, Surface)
            assert isinstance(base, Surface)
            bodies = prepared(slider, base, level=map_level(level), angle=rotate)
        press_areas(
            bodies[0],
            bodies[1],
            loads,
            mechanics=by,
            compliance_share=compliance_share(modulus, young, poisson),
            hardness=None if hardness is None else quantity_of("--hardness", hardness, "pressure"),
            directions=None if direction is None else numbers("--direction", direction),
            shifts=None if isotropic else shifts,
            surrogates=_number_of_surrogates(surrogates),
            seed=seed,
            level="plane" if isotropic else map_level(level),
            files=f"{upper.name} on {lower.name}",
            **common,
        )
        return
    refuse(context, "is for the areas of two maps, without --lines", *_OF_AREAS)
    remark = ""
    if by == ("half-space",):
        refuse(
            context, "is for --mechanics asperities, of lines", "law", "yield_strength", "hardness", "detection",
            "curvature",
        )  # fmt: skip
        if lay is None and isinstance(slider, Profile) and isinstance(base, Profile):
            remark = "Half-planes are the same all along their third direction, as grooves are; --lay isotropic: areas."
    elif lay == "grooves":
        if given(context, "law") and law != "hertz-cylinder":
            raise ValueError(f"--lay grooves presses cylinders, so --law {law} must not be given beside it")
        law = "hertz-cylinder"
    elif isinstance(slider, Profile) and isinstance(base, Profile) and law != "hertz-cylinder":
        remark = (
            "Spheres on a strip 1 µm thick, for which there is nothing beside the line; --lay grooves (cylinders)\n"
            "or --lay isotropic (areas of their spectra) says what the surfaces are like across them."
        )
    surfaces = isinstance(slider, Surface) or isinstance(base, Surface)
    if not surfaces:
        refuse(context, "is for surfaces", "along")
    if surrogates == "none":
        refuse(context, "is for --surrogates", "seed")
        if not surfaces:
            refuse(context, "is for surfaces and surrogates; two profiles are one pair", "lines")
    press_lines(
        slider,
        base,
        loads,
        law=law_of(context, law, yield_strength, hardness, ratio),
        detection=detection,
        curvature=curvature,
        offsets=offsets,
        travel=None if travel is None else quantity_of("--travel", travel, "length"),
        level=None if level == "none" else level or "line",
        lines=LINES if lines is None else lines,
        mechanics=by,
        compliance_share=compliance_share(modulus, young, poisson),
        along=along,
        surrogates=surrogates,
        seed=seed,
        remark=remark,
        **common,
    )


def _isotropic(upper: Profile | Surface, lower: Profile | Surface, lay: str | None) -> bool:
    """Whether profiles stand for isotropic surfaces."""
    if lay is None:
        return False
    if lay not in ("grooves", "isotropic"):
        raise ValueError(f"--lay must be grooves or isotropic, got {lay!r}")
    if isinstance(upper, Surface) or isinstance(lower, Surface):
        raise ValueError("--lay is for two profiles; a map has its lay in it")
    return lay == "isotropic"


def _number_of_surrogates(text: str) -> int | None:
    """Of areas."""
    if text == "none":
        return None
    if not text.isdecimal() or not int(text):
        raise ValueError(f"--surrogates of areas must be a number of pairs of at least 1, got {text!r}")
    return int(text)


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


def show_pair(result: Any, *, as_json: bool = False) -> None:
    """The table of a pair, or its values as JSON."""
    (show_map_pair if result.attrs["title"] == MAP_PAIR else show_line_pair)(result, as_json=as_json)


def draw_pair(result: Any, directory: Path) -> None:
    """The figures of a pair that need neither its profiles nor its maps."""
    (draw_map_pair if result.attrs["title"] == MAP_PAIR else draw_line_pair)(result, directory)
