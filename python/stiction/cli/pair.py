"""`stiction pair`: two measured profiles or surfaces as a study, which is computed and shown as every study is."""

from __future__ import annotations

import json
from collections.abc import Sequence
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from stiction.cli import pair_options as options
from stiction.cli.application import announce, command, is_watched, say, tell
from stiction.cli.options import Channels, ColumnsOfEach, Json, MissingPoints, Spacings, Units, Verbose
from stiction.cli.pair_study import SHIFTS, Asked
from stiction.cli.running import Part, Scheduler, Workers, check_folder, executor_of, fill_folder, part_of
from stiction.studies.store import STUDY, Stored
from stiction.studies.study import Study

if TYPE_CHECKING:
    from stiction.views.answer import Doubt


@command(
    "pair",
    "stiction pair upper.csv lower.csv --upper steel --lower brass \\",
    "    --mu0 0.2 --tau0 '50 MPa' --load '10 mN'",
    "stiction pair map.npy map.npy --unit nm --spacing '1 um' \\",
    "    --effective-modulus '9 GPa' --mu0 0.3 --load '9 MPa'",
    "stiction pair scan.csv scan.csv --surrogates both \\",
    "    --effective-modulus '10 GPa' --mu0 0.3 --load '1 mN' --json",
    "stiction run pair --set ensemble.repetitions=200   # more positions",
)
def pair(
    context: typer.Context,
    upper: options.UpperFile,
    lower: options.LowerFile,
    mu0: options.Mu0,
    load: options.Loads,
    tau0: options.Tau0 = "0 MPa",
    direction: options.Directions = None,
    effective_modulus: options.EffectiveModulus = None,
    young: options.Young = None,
    poisson: options.Poisson = None,
    upper_material: options.UpperMaterial = None,
    lower_material: options.LowerMaterial = None,
    hardness: options.Hardness = None,
    law: options.ContactLaw = "hertz-sphere",
    yield_strength: options.YieldStrength = None,
    mechanics: options.Mechanics = None,
    check: options.Check = False,
    lines: options.LinesOfMaps = None,
    lay: options.Lay = None,
    surrogates: options.Surrogates = "none",
    seed: options.Seed = 2016,
    level: options.Level = None,
    cutoff: options.CutOff = None,
    offsets: options.Offsets = None,
    travel: options.Travel = None,
    along: options.LinesAlong = "x",
    detection: options.Detection = "gap-minimum",
    curvature: options.Curvature = None,
    shifts: options.Shifts = SHIFTS,
    rotate: options.Rotation = None,
    onset: options.OnsetMembers = None,
    unit: Units = None,
    spacing: Spacings = None,
    missing: MissingPoints = "error",
    channel: Channels = None,
    columns: ColumnsOfEach = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    part: Part = None,
    output: options.Folder = Path("pair"),
    replace: options.Replace = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
    """Static friction of two measured profiles or surfaces at given loads, with intervals.

    Heights of both files point out of the material. Of two profiles the upper one is carried along the lower; maps are
    pressed as areas, or as pairs of lines with --lines. Options that describe a file apply to both; give them twice to
    set UPPER and LOWER separately. The result is a study in DIR, which run, at, plot, report, info and export take.
    """
    _press(Asked.of(context), context)


def _press(asked: Asked, context: typer.Context) -> None:
    """Compute what is asked for, show it, and write it."""
    from stiction.cli.showing import said_by, show_result, write_views
    from stiction.studies.members import about
    from stiction.views.inputs import doubts_of_inputs

    values = asked.values
    output, as_json = values["output"], values["as_json"]
    part, said = part_of(values["part"]), said_by(as_json)
    check_folder(output)
    studies = asked.studies()
    about(studies[0])  # refuses what cannot be pressed, before anything is written
    doubts = doubts_of_inputs(asked.upper, asked.lower, studies[0], [float(load) for load in asked.loads])
    with executor_of(values["workers"], values["scheduler"]) as executor:
        results: list[Stored] = []
        if values["replace"] or not (output / STUDY).exists():
            announce_first(asked.first_study(), executor)
        for study in studies:
            folder = output / study.contact.mechanics if results else output
            results.append(
                fill_folder(
                    study, folder, executor, said=said, part=part, replace=values["replace"], onset=values["onset"]
                )
            )
    if part is not None:
        return
    first, *others = results
    show_result(
        first, command="pair", as_json=as_json, verbose=values["verbose"], beside=doubts,
        about={"check": [record_of(other, doubts) for other in others]} if as_json and others else None,
    )  # fmt: skip
    for other in others if not as_json else ():
        tell(f"\nBy {other.study.contact.mechanics}:\n")
        show_result(other, command="pair", verbose=values["verbose"], beside=doubts)
    for remark in asked.remarks():
        say(remark)
    for result in results:
        write_views(result, beside=doubts, said=said)


def announce_first(study: Study | None, executor: Executor) -> None:
    """Have a worker tell whoever watches a terminal what asperities say, while the others solve the half-space."""
    from stiction.views.first import first_text

    def told(done: Future[str]) -> None:
        if not done.cancelled() and done.exception() is None:  # where nothing touches there is nothing to say
            announce(done.result())

    if study is not None and is_watched():
        executor.submit(first_text, study).add_done_callback(told)


def record_of(result: Stored, doubts: Sequence[Doubt]) -> Any:
    """What JSON says of a result by the other mechanics."""
    from stiction.views.asked import at_asked_loads
    from stiction.views.rows import record_text

    return json.loads(record_text("pair", at_asked_loads(result), result.study, beside=doubts))
