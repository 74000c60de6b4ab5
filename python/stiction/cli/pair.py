"""`stiction pair`: two measured profiles or surfaces as a study, which is computed and shown as every study is."""

from __future__ import annotations

import json
from collections.abc import Callable
from concurrent.futures import Executor, Future
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from stiction._text import printable
from stiction.cli.application import command, is_watched, say, tell
from stiction.cli.options import (
    ELASTICITY,
    FILES,
    MATERIALS,
    Json,
    Verbose,
    announce_reader,
    option,
    optional,
    with_options,
)
from stiction.cli.running import Part, Scheduler, Workers, check_folder, executor_of, fill_folder, part_of
from stiction.studies.measured_surfaces import SHIFTS
from stiction.studies.pair import LAW, Pair
from stiction.studies.result import Result
from stiction.studies.store import STUDY
from stiction.studies.study import SEED, Study

UpperFile = Annotated[str | None, typer.Argument(
    metavar="UPPER", help="A measured profile or surface: the slider. Scans of several places: a.csv,b.csv or a folder."
)]  # fmt: skip
LowerFile = Annotated[str | None, typer.Argument(
    metavar="LOWER", help="What it is carried over; the same file may be both."
)]  # fmt: skip
_motion = partial(optional, panel="Load and motion")
_material = partial(optional, panel="Material")
_pressed = partial(optional, panel="What is pressed")
_of_lines = partial(optional, panel="Only for lines")
_of_areas = partial(optional, panel="Only for areas")
_output = partial(option, panel="Output")

MOTION = {
    "load": Annotated[list[str], option(
        "--load PRESSURE", 'Normal load over the nominal area, "10 MPa", or a force, "0.1 mN". Repeatable.',
        panel="Load and motion",
    )],
    "width": _motion("--width LENGTH", "Of two profiles, the width across them that a force is on.", "1 um"),
    "mu0": _motion("--mu0 NUMBERS", 'Molecular friction coefficients, "0.3" or "0.3,0.4".', False),
    "tau0": _motion("--tau0 PRESSURES", 'Adhesive shear strengths, "0 MPa,50 MPa".', "0 MPa"),
    "interface": _motion(
        "--interface NAME|FILE", "Instead of both: as stiction calibrate kept them or interfaces lists them.", False
    ),
    "direction": _motion(
        "--direction DEGREES", 'Of areas, where the upper is about to move, from +x towards +y: "0,90".',
        "the compass in 30",
    ),
    "tilt": _motion(
        "--tilt fixed|free", "Whether the slider turns until the load is in its middle, as on a ball joint.", "fixed"
    ),
}  # fmt: skip

STRENGTH = {
    "hardness": _material(
        "--hardness PRESSURE",
        "Of the softer body: the most that the pressure can be; for jackson-green 2.84 yield strengths.", False,
    ),
    "junction_growth": _material(
        "--junction-growth NUMBER", "α by which plastic contacts grow under shear, \"9\" or \"0..27\"; 0 for none.",
        "0..27 of metals by name",
    ),
    "wait": _material(
        "--wait TIMES", 'Under load before it is sheared, "1 min,1 h"; the hardness is that after 1 s.', False
    ),
    "creep": _material(
        "--creep NUMBER", 'Exponent m of indentation creep, "0.03" or "0.02..0.05": hardness (t/1 s)^-m.', False
    ),
    "work_of_adhesion": _material(
        "--adhesion ENERGY", 'Work of adhesion, "50 mJ/m^2"; "0 mJ/m^2" says that there is none.', "taken as 0",
    ),
    "adhesion_range": _material("--adhesion-range LENGTH", "Gap over which the attraction falls off.", "0.5 nm"),
    "law": _material("--law hertz-sphere|hertz-cylinder|jackson-green", "Contact law of asperities.", LAW),
    "yield_strength": _material("--yield-strength PRESSURE", "Of the softer body, for jackson-green.", False),
}  # fmt: skip

PRESSED = {
    "gap": _pressed(
        "--gap FILE", "In place of UPPER and LOWER: a map that is the gap of two faces, as of a fracture.", False
    ),
    "mechanics": _pressed(
        "--mechanics half-space|asperities", "The exact elastic answer (of lines: of half-planes), or a fast one.",
        "asperities of lines, but of two profiles of metals",
    ),
    "check": Annotated[
        bool, option("--check", "Press by the other mechanics as well, into DIR/NAME.", panel="What is pressed")
    ],
    "lines": _pressed(
        "--lines N",
        "Press this many pairs of lines of two maps, not their areas; also the number of surrogates of lines.",
        "128 of surrogates, and of a map and a profile", kind=int, least=1,
    ),
    "lay": _pressed(
        "--lay grooves|isotropic",
        "Of two profiles: across grooves, pressed as lines; or of surfaces alike in all directions, as areas.", "lines",
    ),
    "surrogates": _pressed(
        "--surrogates N|none|upper|lower|both",
        "Of areas: press this many pairs of random surfaces of equal spectrum as well. Of lines: the body to replace.",
    ),
    "seed": _pressed("--seed N", "Where the random phases of surrogates start.", str(SEED), kind=int, least=0),
    "level": _pressed(
        "--level TREND",
        "What is taken off each line: mean, line, quadratic or none; off each map: mean, plane or quadratic.",
        "line, plane",
    ),
    "cutoff": _pressed(
        "--cutoff LENGTHS",
        'Take off waves shorter than this (Gaussian), "0.1 um"; several are pressed each; none vouches for all.',
        "waves that are hardly the surface's, off and on",
    ),
    "curvature": _pressed(
        "--curvature convex|signed", "Whether cups count as well as summits.", "convex of lines, signed of areas"
    ),
}  # fmt: skip

LINES = {
    "offsets": _of_lines(
        "--offsets N", "Positions along the lower profile.", "64, or 1 for several lines", kind=int, least=1
    ),
    "travel": _of_lines("--travel LENGTH", "The largest offset.", "half the length"),
    "along": _of_lines("--along x|y", "Direction of the lines of maps.", "x"),
    "detection": _of_lines("--detection gap-minimum|cell", "How contacts of asperities are found.", "gap-minimum"),
}  # fmt: skip

AREAS = {
    "shifts": _of_areas("--shifts N", "Relative positions of maps.", str(SHIFTS), kind=int, least=1),
    "rotate": _of_areas("--rotate DEGREES", "Turn the upper map in its plane.", False, kind=float),
}

OnsetMembers = Annotated[int | None, option(
    "--onset N", "Members of which it is computed how they begin to slide; 0 for none.",
    "16, of areas by the half-space 4", panel="What is pressed", least=0,
)]  # fmt: skip
Folder = Annotated[Path, _output("--output -o DIR", "Where the results go.")]
Replace = Annotated[bool, _output("--replace", "Write over the results of another pair.")]


@command(
    "pair",
    "stiction pair upper.csv lower.csv --upper steel --lower brass \\",
    "    --mu0 0.2 --tau0 '50 MPa' --load '50 MPa'",
    "stiction pair map.npy map.npy --unit nm --spacing '1 um' \\",
    "    --effective-modulus '9 GPa' --mu0 0.3 --load '9 MPa'",
    "stiction pair scan.csv scan.csv --surrogates both \\",
    "    --effective-modulus '10 GPa' --mu0 0.3 --load '1 mN' --json",
    "stiction run pair --set ensemble.repetitions=200   # more positions",
)
@with_options(MOTION, ELASTICITY, MATERIALS, STRENGTH, PRESSED, LINES, AREAS, FILES)
def pair(
    upper: UpperFile = None,
    lower: LowerFile = None,
    *,
    onset: OnsetMembers = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    part: Part = None,
    output: Folder = Path("pair"),
    replace: Replace = False,
    verbose: Verbose = False,
    as_json: Json = False,
    **asked: Any,
) -> None:
    """Static friction of two measured profiles or surfaces at given loads, with intervals.

    Heights of both files point out of the material. Of two profiles the upper one is carried along the lower; maps are
    pressed as areas, or as pairs of lines with --lines. Options that describe a file apply to both; give them twice to
    set UPPER and LOWER separately. The result is a study in DIR, which run, at, plot, report, info and export take.
    """
    from stiction.cli.showing import said_by, show_answer, show_result, write_views
    from stiction.studies.members import about
    from stiction.views.files import VIEWS, check_files
    from stiction.views.rows import record_text

    chosen, said = part_of(part), said_by(as_json)
    check_folder(output)
    check_files(output, VIEWS)
    bodies = Pair(upper=upper, lower=lower, **asked)
    for file in bodies.files:
        announce_reader(Path(file.file))
    studies = bodies.studies
    about(studies[0])  # refuses what cannot be pressed, before anything is written
    for remark in bodies.remarks[0 if verbose else bool(bodies.elasticity.source) :]:  # of materials the answer has it
        say(remark)
    if verbose and not as_json:
        for file in bodies.files:
            for scan in file.scans:
                if scan.reading is not None:
                    tell(f"{printable(scan.name)}: {scan.reading}")
    rests: list[Callable[[], None]] = []

    def answered(result: Result) -> None:
        if as_json:
            return
        if rests:
            tell(f"\nBy {result.study.contact.mechanics}:\n")
        rests.append(show_answer(result, command="pair", verbose=verbose))

    with executor_of(workers, scheduler) as executor:
        results: list[Result] = []
        if replace or not (output / STUDY).exists():
            announce_first(bodies.first_study, executor)
        for study in studies:
            folder = output / study.contact.mechanics if results else output
            result = fill_folder(
                study, folder, executor, said=said, part=chosen, replace=replace, onset=onset, answered=answered
            )
            for rest in rests[len(results) :]:
                rest()
            results.append(result)
    if chosen is not None:
        return
    if as_json:
        checks = [
            json.loads(record_text("pair", each.at_study_loads, each.study, beside=each.input_caveats))
            for each in results[1:]
        ]
        readings = [scan.reading for file in bodies.files for scan in file.scans]
        about_files = {"files": [each.record() for each in readings if each is not None]}
        show_result(results[0], command="pair", as_json=True, about=about_files | ({"check": checks} if checks else {}))
    for result in results:
        write_views(result, said=said)


def announce_first(study: Study | None, executor: Executor) -> None:
    """Have a worker tell whoever watches a terminal what asperities say, while the others solve the half-space."""
    from stiction.views.text import first_text

    def told(done: Future[str]) -> None:
        if not done.cancelled() and done.exception() is None:  # where nothing touches there is nothing to say
            say(done.result())

    if study is not None and is_watched():
        executor.submit(first_text, study).add_done_callback(told)
