"""The options of `stiction pair`, in the groups that its help shows."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

PRESSED = "What is pressed"
MATERIAL = "Material"
MOTION = "Load and motion"
LINES = "Only for lines"
AREAS = "Only for areas"
FILES = "Reading files"
OUTPUT = "Output"

UpperFile = Annotated[Path, typer.Argument(metavar="UPPER", help="A measured profile or surface: the slider.")]
LowerFile = Annotated[Path, typer.Argument(metavar="LOWER", help="What it is carried over; the same file may be both.")]

# ---- What is pressed ------------------------------------------------------------------------------------------------

Mechanics = Annotated[
    str | None,
    typer.Option(
        "--mechanics", metavar="half-space|asperities", show_default="half-space of areas, asperities of lines",
        help="The exact elastic answer (of lines: of half-planes), or a fast one.", rich_help_panel=PRESSED,
    ),
]  # fmt: skip
Check = Annotated[
    bool,
    typer.Option("--check", help="Press by the other mechanics as well, into DIR/NAME.", rich_help_panel=PRESSED),
]
LinesOfMaps = Annotated[
    int | None,
    typer.Option(
        "--lines", metavar="N", min=1, show_default="128 of surrogates, and of a map and a profile",
        help="Press so many pairs of lines of maps instead of their areas; also of surrogates.",
        rich_help_panel=PRESSED,
    ),
]  # fmt: skip
Lay = Annotated[
    str | None,
    typer.Option(
        "--lay", metavar="grooves|isotropic", show_default="lines", rich_help_panel=PRESSED,
        help="Of two profiles: across grooves, pressed as lines; or of surfaces alike in all directions, as areas.",
    ),
]  # fmt: skip
Surrogates = Annotated[
    str,
    typer.Option(
        "--surrogates", metavar="N|none|upper|lower|both", rich_help_panel=PRESSED,
        help="Of areas: press so many pairs of surfaces of equal spectrum as well. Of lines: what they replace.",
    ),
]  # fmt: skip
Seed = Annotated[
    int,
    typer.Option(
        "--seed", metavar="N", min=0, help="Where the random phases of surrogates start.", rich_help_panel=PRESSED
    ),
]
Level = Annotated[
    str | None,
    typer.Option(
        "--level", metavar="TREND", show_default="line, plane", rich_help_panel=PRESSED,
        help="What is taken off each line: mean, line, quadratic or none; off each map: mean, plane or quadratic.",
    ),
]  # fmt: skip
CutOff = Annotated[
    str | None,
    typer.Option(
        "--cutoff", metavar="LENGTHS", show_default="the scan as it is", rich_help_panel=PRESSED,
        help='Take off waves shorter than this (Gaussian), "0.1 um"; several, "0 um,0.1 um", are pressed each.',
    ),
]  # fmt: skip

Curvature = Annotated[
    str | None,
    typer.Option(
        "--curvature", metavar="convex|signed", help="Whether cups count as well as summits.",
        show_default="convex of lines, signed of areas", rich_help_panel=PRESSED,
    ),
]  # fmt: skip

OnsetMembers = Annotated[
    int | None,
    typer.Option(
        "--onset", metavar="N", min=0, show_default="16, of areas by the half-space 4", rich_help_panel=PRESSED,
        help="Members of which it is computed how they begin to slide; 0 for none.",
    ),
]  # fmt: skip

# ---- Material -------------------------------------------------------------------------------------------------------

EffectiveModulus = Annotated[
    str | None,
    typer.Option(
        "--effective-modulus", metavar="PRESSURE", help='E*, as in "10 GPa".', show_default=False,
        rich_help_panel=MATERIAL,
    ),
]  # fmt: skip
Young = Annotated[
    str | None,
    typer.Option(
        "--young", metavar="PRESSURES", show_default=False, rich_help_panel=MATERIAL,
        help='Instead of E*: Young\'s modulus of both bodies or of one after the other, "200 GPa,70 GPa".',
    ),
]  # fmt: skip
Poisson = Annotated[
    str | None,
    typer.Option(
        "--poisson", metavar="NUMBERS", help='Poisson\'s ratios, "0.3" or "0.3,0.33".', show_default=False,
        rich_help_panel=MATERIAL,
    ),
]  # fmt: skip
UpperMaterial = Annotated[
    str | None,
    typer.Option(
        "--upper", metavar="MATERIAL", show_default=False, rich_help_panel=MATERIAL,
        help="Instead of E*: what the slider is made of, by name, as in steel.",
    ),
]  # fmt: skip
LowerMaterial = Annotated[
    str | None,
    typer.Option(
        "--lower", metavar="MATERIAL", help="What it is carried over; that of --upper by default.",
        show_default=False, rich_help_panel=MATERIAL,
    ),
]  # fmt: skip
Hardness = Annotated[
    str | None,
    typer.Option(
        "--hardness", metavar="PRESSURE", show_default=False, rich_help_panel=MATERIAL,
        help="Of the softer body: the most that the pressure can be; for jackson-green 2.84 yield strengths.",
    ),
]  # fmt: skip
ContactLaw = Annotated[
    str,
    typer.Option(
        "--law", metavar="hertz-sphere|hertz-cylinder|jackson-green", help="Contact law of asperities.",
        rich_help_panel=MATERIAL,
    ),
]  # fmt: skip
YieldStrength = Annotated[
    str | None,
    typer.Option(
        "--yield-strength", metavar="PRESSURE", help="Of the softer body, for jackson-green.", show_default=False,
        rich_help_panel=MATERIAL,
    ),
]  # fmt: skip

# ---- Load and motion ------------------------------------------------------------------------------------------------

Mu0 = Annotated[
    str,
    typer.Option(
        "--mu0", metavar="NUMBERS", help='Molecular friction coefficients, "0.3" or "0.3,0.4".',
        rich_help_panel=MOTION,
    ),
]  # fmt: skip
Tau0 = Annotated[
    str,
    typer.Option(
        "--tau0", metavar="PRESSURES", help='Adhesive shear strengths, "0 MPa,50 MPa".', rich_help_panel=MOTION
    ),
]
Loads = Annotated[
    list[str],
    typer.Option(
        "--load", metavar="FORCE", rich_help_panel=MOTION,
        help='Normal load on the slider, "0.1 mN", or per its area, "10 MPa". Repeatable.',
    ),
]  # fmt: skip
Directions = Annotated[
    str | None,
    typer.Option(
        "--direction", metavar="DEGREES", show_default="the compass in 30", rich_help_panel=MOTION,
        help='Of areas, where the upper is about to move, from +x towards +y: "0,90".',
    ),
]  # fmt: skip

# ---- Only for lines -------------------------------------------------------------------------------------------------

Offsets = Annotated[
    int | None,
    typer.Option(
        "--offsets", metavar="N", min=1, help="Positions along the lower profile.",
        show_default="64, or 1 for several lines", rich_help_panel=LINES,
    ),
]  # fmt: skip
Travel = Annotated[
    str | None,
    typer.Option(
        "--travel", metavar="LENGTH", help="The largest offset.", show_default="half the length",
        rich_help_panel=LINES,
    ),
]  # fmt: skip
LinesAlong = Annotated[
    str, typer.Option("--along", metavar="x|y", help="Direction of the lines of maps.", rich_help_panel=LINES)
]
Detection = Annotated[
    str,
    typer.Option(
        "--detection", metavar="gap-minimum|cell", help="How contacts of asperities are found.", rich_help_panel=LINES
    ),
]
# ---- Only for areas -------------------------------------------------------------------------------------------------

Shifts = Annotated[
    int, typer.Option("--shifts", metavar="N", min=1, help="Relative positions of maps.", rich_help_panel=AREAS)
]
Rotation = Annotated[
    float | None,
    typer.Option(
        "--rotate", metavar="DEGREES", help="Turn the upper map in its plane.", show_default=False,
        rich_help_panel=AREAS,
    ),
]  # fmt: skip

# ---- Output ---------------------------------------------------------------------------------------------------------

Folder = Annotated[
    Path,
    typer.Option("--output", "-o", metavar="DIR", help="Where the results go.", rich_help_panel=OUTPUT),
]
Replace = Annotated[
    bool, typer.Option("--replace", help="Write over the results of another pair.", rich_help_panel=OUTPUT)
]
