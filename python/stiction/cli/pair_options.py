"""The options of `stiction pair`, in the groups that its help shows."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from stiction.cli.options import option

_pressed = partial(option, panel="What is pressed")
_material = partial(option, panel="Material")
_motion = partial(option, panel="Load and motion")
_of_lines = partial(option, panel="Only for lines")
_of_areas = partial(option, panel="Only for areas")
_output = partial(option, panel="Output")

UpperFile = Annotated[Path, typer.Argument(metavar="UPPER", help="A measured profile or surface: the slider.")]
LowerFile = Annotated[Path, typer.Argument(metavar="LOWER", help="What it is carried over; the same file may be both.")]

# ---- What is pressed ------------------------------------------------------------------------------------------------

Mechanics = Annotated[
    str | None,
    _pressed(
        "--mechanics",
        "half-space|asperities",
        "The exact elastic answer (of lines: of half-planes), or a fast one.",
        "half-space of areas, asperities of lines",
    ),
]
Check = Annotated[bool, _pressed("--check", None, "Press by the other mechanics as well, into DIR/NAME.")]
LinesOfMaps = Annotated[
    int | None,
    _pressed(
        "--lines",
        "N",
        "Press this many pairs of lines of two maps, not their areas; also the number of surrogates of lines.",
        "128 of surrogates, and of a map and a profile",
        least=1,
    ),
]
Lay = Annotated[
    str | None,
    _pressed(
        "--lay",
        "grooves|isotropic",
        "Of two profiles: across grooves, pressed as lines; or of surfaces alike in all directions, as areas.",
        "lines",
    ),
]
Surrogates = Annotated[
    str,
    _pressed(
        "--surrogates",
        "N|none|upper|lower|both",
        "Of areas: press this many pairs of random surfaces of equal spectrum as well. Of lines: the body to replace.",
    ),
]
Seed = Annotated[int, _pressed("--seed", "N", "Where the random phases of surrogates start.", least=0)]
Level = Annotated[
    str | None,
    _pressed(
        "--level",
        "TREND",
        "What is taken off each line: mean, line, quadratic or none; off each map: mean, plane or quadratic.",
        "line, plane",
    ),
]
CutOff = Annotated[
    str | None,
    _pressed(
        "--cutoff",
        "LENGTHS",
        'Take off waves shorter than this (Gaussian), "0.1 um"; several, "0 um,0.1 um", are pressed each.',
        "the scan as it is",
    ),
]

Curvature = Annotated[
    str | None,
    _pressed(
        "--curvature", "convex|signed", "Whether cups count as well as summits.", "convex of lines, signed of areas"
    ),
]

OnsetMembers = Annotated[
    int | None,
    _pressed(
        "--onset",
        "N",
        "Members of which it is computed how they begin to slide; 0 for none.",
        "16, of areas by the half-space 4",
        least=0,
    ),
]

# ---- Material -------------------------------------------------------------------------------------------------------

EffectiveModulus = Annotated[str | None, _material("--effective-modulus", "PRESSURE", 'E*, as in "10 GPa".', False)]
Young = Annotated[
    str | None,
    _material(
        "--young",
        "PRESSURES",
        'Instead of E*: Young\'s modulus of both bodies or of one after the other, "200 GPa,70 GPa".',
        False,
    ),
]
Poisson = Annotated[str | None, _material("--poisson", "NUMBERS", 'Poisson\'s ratios, "0.3" or "0.3,0.33".', False)]
UpperMaterial = Annotated[
    str | None,
    _material("--upper", "MATERIAL", "Instead of E*: what the slider is made of, by name, as in steel.", False),
]
LowerMaterial = Annotated[
    str | None, _material("--lower", "MATERIAL", "What it is carried over; that of --upper by default.", False)
]
Hardness = Annotated[
    str | None,
    _material(
        "--hardness",
        "PRESSURE",
        "Of the softer body: the most that the pressure can be; for jackson-green 2.84 yield strengths.",
        False,
    ),
]
ContactLaw = Annotated[
    str, _material("--law", "hertz-sphere|hertz-cylinder|jackson-green", "Contact law of asperities.")
]
YieldStrength = Annotated[
    str | None, _material("--yield-strength", "PRESSURE", "Of the softer body, for jackson-green.", False)
]

# ---- Load and motion ------------------------------------------------------------------------------------------------

Mu0 = Annotated[str, _motion("--mu0", "NUMBERS", 'Molecular friction coefficients, "0.3" or "0.3,0.4".')]
Tau0 = Annotated[str, _motion("--tau0", "PRESSURES", 'Adhesive shear strengths, "0 MPa,50 MPa".')]
Loads = Annotated[
    list[str], _motion("--load", "FORCE", 'Normal load on the slider, "0.1 mN", or per its area, "10 MPa". Repeatable.')
]
Directions = Annotated[
    str | None,
    _motion(
        "--direction",
        "DEGREES",
        'Of areas, where the upper is about to move, from +x towards +y: "0,90".',
        "the compass in 30",
    ),
]

# ---- Only for lines -------------------------------------------------------------------------------------------------

Offsets = Annotated[
    int | None, _of_lines("--offsets", "N", "Positions along the lower profile.", "64, or 1 for several lines", least=1)
]
Travel = Annotated[str | None, _of_lines("--travel", "LENGTH", "The largest offset.", "half the length")]
LinesAlong = Annotated[str, _of_lines("--along", "x|y", "Direction of the lines of maps.")]
Detection = Annotated[str, _of_lines("--detection", "gap-minimum|cell", "How contacts of asperities are found.")]
# ---- Only for areas -------------------------------------------------------------------------------------------------

Shifts = Annotated[int, _of_areas("--shifts", "N", "Relative positions of maps.", least=1)]
Rotation = Annotated[float | None, _of_areas("--rotate", "DEGREES", "Turn the upper map in its plane.", False)]

# ---- Output ---------------------------------------------------------------------------------------------------------

Folder = Annotated[Path, _output("--output -o", "DIR", "Where the results go.")]
Replace = Annotated[bool, _output("--replace", None, "Write over the results of another pair.")]
