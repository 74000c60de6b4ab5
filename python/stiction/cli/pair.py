"""`stiction pair`: two measured profiles or surfaces as a study, which is computed and shown as every study is."""

from __future__ import annotations

import json
from collections.abc import Callable
from concurrent.futures import Executor, Future
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from stiction._text import printable
from stiction.cli.application import command, is_watched, say, tell
from stiction.cli.execution import Part, Scheduler, Workers, check_folder, executor_of, fill_folder, part_of
from stiction.cli.options import Json, Verbose, announce_reader, option
from stiction.cli.pair_options import COMMON, HelpAll, argument_of, given_options, option_of
from stiction.studies.pair import Pair
from stiction.studies.pair_options import read_options
from stiction.studies.result import Result
from stiction.studies.store import STUDY
from stiction.studies.study import Study

UpperFile = Annotated[str | None, argument_of("upper")]
LowerFile = Annotated[str | None, argument_of("lower")]
_output = partial(option, panel="Output")
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
    common=COMMON,
)
def pair(
    context: typer.Context,
    upper: UpperFile = None,
    lower: LowerFile = None,
    *,
    load: Annotated[list[str], option_of("load")],
    width: Annotated[str | None, option_of("width")] = None,
    mu0: Annotated[str | None, option_of("mu0")] = None,
    tau0: Annotated[str | None, option_of("tau0")] = None,
    interface: Annotated[str | None, option_of("interface")] = None,
    direction: Annotated[str | None, option_of("direction")] = None,
    upper_material: Annotated[str | None, option_of("upper_material")] = None,
    lower_material: Annotated[str | None, option_of("lower_material")] = None,
    effective_modulus: Annotated[str | None, option_of("effective_modulus")] = None,
    young: Annotated[str | None, option_of("young")] = None,
    poisson: Annotated[str | None, option_of("poisson")] = None,
    hardness: Annotated[str | None, option_of("hardness")] = None,
    yield_strength: Annotated[str | None, option_of("yield_strength")] = None,
    junction_growth: Annotated[str | None, option_of("junction_growth")] = None,
    wait: Annotated[str | None, option_of("wait")] = None,
    creep: Annotated[str | None, option_of("creep")] = None,
    work_of_adhesion: Annotated[str | None, option_of("work_of_adhesion")] = None,
    adhesion_range: Annotated[str | None, option_of("adhesion_range")] = None,
    check: Annotated[bool, option_of("check")] = False,
    mechanics: Annotated[str | None, option_of("mechanics")] = None,
    tilt: Annotated[str | None, option_of("tilt")] = None,
    law: Annotated[str | None, option_of("law")] = None,
    detection: Annotated[str | None, option_of("detection")] = None,
    curvature: Annotated[str | None, option_of("curvature")] = None,
    gap: Annotated[str | None, option_of("gap")] = None,
    lay: Annotated[str | None, option_of("lay")] = None,
    lines: Annotated[str | None, option_of("lines")] = None,
    along: Annotated[str | None, option_of("along")] = None,
    level: Annotated[str | None, option_of("level")] = None,
    cutoff: Annotated[str | None, option_of("cutoff")] = None,
    rotate: Annotated[str | None, option_of("rotate")] = None,
    shifts: Annotated[str | None, option_of("shifts")] = None,
    offsets: Annotated[str | None, option_of("offsets")] = None,
    travel: Annotated[str | None, option_of("travel")] = None,
    surrogates: Annotated[str | None, option_of("surrogates")] = None,
    seed: Annotated[str | None, option_of("seed")] = None,
    unit: Annotated[list[str] | None, option_of("unit")] = None,
    spacing: Annotated[list[str] | None, option_of("spacing")] = None,
    missing: Annotated[str | None, option_of("missing")] = None,
    missing_value: Annotated[list[str] | None, option_of("missing_value")] = None,
    outliers: Annotated[str | None, option_of("outliers")] = None,
    crop: Annotated[list[str] | None, option_of("crop")] = None,
    channel: Annotated[list[str] | None, option_of("channel")] = None,
    columns: Annotated[list[str] | None, option_of("columns")] = None,
    accept: Annotated[list[str] | None, option_of("accept")] = None,
    texture: Annotated[list[str] | None, option_of("texture")] = None,
    tip: Annotated[list[str] | None, option_of("tip")] = None,
    onset: Annotated[str | None, option_of("onset")] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    part: Part = None,
    output: Folder = Path("pair"),
    replace: Replace = False,
    verbose: Verbose = False,
    as_json: Json = False,
    help_all: HelpAll = False,
) -> None:
    """Static friction of two measured profiles or surfaces at given loads, with intervals.

    Heights of both files point out of the material. Of two profiles the upper one is carried along the lower; maps are
    pressed as areas, or as pairs of lines with --lines. Options that describe a file apply to both; give them twice to
    set UPPER and LOWER separately. The result is a study in DIR, which run, at, plot, report, info and export take.
    """
    from stiction.cli.result_output import said_by, show_answer, show_result, write_views
    from stiction.studies.members import about
    from stiction.views.files import VIEWS, check_files
    from stiction.views.rows import record_text

    chosen, said = part_of(part), said_by(as_json)
    check_folder(output)
    check_files(output, VIEWS)
    bodies = Pair(read_options(given_options(context)))
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
                study,
                folder,
                executor,
                said=said,
                part=chosen,
                replace=replace,
                onset=bodies.options.onset,
                answered=answered,
            )
            for rest in rests[len(results) :]:
                rest()
            results.append(result)
    if chosen is not None:
        return
    if as_json:
        checks = [json.loads(record_text("pair", each.summary())) for each in results[1:]]
        readings = [scan.reading for file in bodies.files for scan in file.scans]
        about_files = {"files": [each.record() for each in readings if each is not None]}
        show_result(results[0], command="pair", as_json=True, about=about_files | ({"check": checks} if checks else {}))
    for result in results:
        write_views(result, said=said)


def first_line(study: Study) -> str:
    """Return the coefficient of the first members of a study of asperities; a `ValueError` if nothing touches."""
    from stiction.studies.runner import first_result
    from stiction.views.text import first_text

    return first_text(first_result(study).summary())


def announce_first(study: Study | None, executor: Executor) -> None:
    """Have a worker tell whoever watches a terminal what asperities say, while the others solve the half-space."""

    def told(done: Future[str]) -> None:
        if not done.cancelled() and done.exception() is None:  # where nothing touches there is nothing to say
            say(done.result())

    if study is not None and is_watched():
        executor.submit(first_line, study).add_done_callback(told)
