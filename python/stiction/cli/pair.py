"""Command `stiction pair`: static friction of two measured profiles or surfaces."""

from __future__ import annotations

import json
from concurrent.futures import Executor, Future
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction._text import printable_path, printable_text
from stiction.cli.application import (
    command,
    is_stderr_terminal,
    print_message,
    print_output,
    report_interruption,
    show_status,
)
from stiction.cli.options import (
    JsonOption,
    PartOption,
    SchedulerOption,
    VerboseOption,
    WorkersOption,
    option,
    show_reader_import_status,
)
from stiction.cli.pair_options import (
    PAIR_SHORT_HELP_PARAMETERS,
    HelpAllOption,
    pair_argument,
    pair_option,
    read_given_options,
)

if TYPE_CHECKING:
    from stiction.result import Result
    from stiction.study.study import Study


UpperFileArgument = Annotated[str | None, pair_argument("upper")]
LowerFileArgument = Annotated[str | None, pair_argument("lower")]
_output_option = partial(option, panel="Output")
OutputDirectoryOption = Annotated[Path, _output_option("--output -o DIR", "Directory for the results.")]
ReplaceOption = Annotated[bool, _output_option("--replace", "Overwrite the results of another pair.")]


@command(
    "pair",
    "stiction pair upper.csv lower.csv --upper steel --lower brass \\",
    "    --mu0 0.2 --tau0 '50 MPa' --load '50 MPa'",
    "stiction pair map.npy map.npy --unit nm --spacing '1 um' \\",
    "    --effective-modulus '9 GPa' --mu0 0.3 --load '9 MPa'",
    "stiction pair scan.csv scan.csv --surrogates both \\",
    "    --effective-modulus '10 GPa' --mu0 0.3 --load '1 mN' --json",
    "stiction run pair --set ensemble.repetitions=200   # more positions",
    common=PAIR_SHORT_HELP_PARAMETERS,
)
def pair(
    context: typer.Context,
    upper: UpperFileArgument = None,
    lower: LowerFileArgument = None,
    *,
    load: Annotated[list[str], pair_option("load")],
    width: Annotated[str | None, pair_option("width")] = None,
    mu0: Annotated[str | None, pair_option("mu0")] = None,
    tau0: Annotated[str | None, pair_option("tau0")] = None,
    interface: Annotated[str | None, pair_option("interface")] = None,
    direction: Annotated[str | None, pair_option("direction")] = None,
    upper_material: Annotated[str | None, pair_option("upper_material")] = None,
    lower_material: Annotated[str | None, pair_option("lower_material")] = None,
    effective_modulus: Annotated[str | None, pair_option("effective_modulus")] = None,
    young: Annotated[str | None, pair_option("young")] = None,
    poisson: Annotated[str | None, pair_option("poisson")] = None,
    hardness: Annotated[str | None, pair_option("hardness")] = None,
    yield_strength: Annotated[str | None, pair_option("yield_strength")] = None,
    junction_growth: Annotated[str | None, pair_option("junction_growth")] = None,
    yield_exponent: Annotated[str | None, pair_option("yield_exponent")] = None,
    indent: Annotated[str | None, pair_option("indent")] = None,
    area_loss: Annotated[str | None, pair_option("area_loss")] = None,
    wait: Annotated[str | None, pair_option("wait")] = None,
    creep: Annotated[str | None, pair_option("creep")] = None,
    work_of_adhesion: Annotated[str | None, pair_option("work_of_adhesion")] = None,
    adhesion_range: Annotated[str | None, pair_option("adhesion_range")] = None,
    check: Annotated[bool, pair_option("check")] = False,
    mechanics: Annotated[str | None, pair_option("mechanics")] = None,
    tilt: Annotated[str | None, pair_option("tilt")] = None,
    law: Annotated[str | None, pair_option("law")] = None,
    detection: Annotated[str | None, pair_option("detection")] = None,
    curvature: Annotated[str | None, pair_option("curvature")] = None,
    gap: Annotated[str | None, pair_option("gap")] = None,
    lay: Annotated[str | None, pair_option("lay")] = None,
    lines: Annotated[str | None, pair_option("lines")] = None,
    along: Annotated[str | None, pair_option("along")] = None,
    level: Annotated[str | None, pair_option("level")] = None,
    cutoff: Annotated[str | None, pair_option("cutoff")] = None,
    rotate: Annotated[str | None, pair_option("rotate")] = None,
    shifts: Annotated[str | None, pair_option("shifts")] = None,
    offsets: Annotated[str | None, pair_option("offsets")] = None,
    travel: Annotated[str | None, pair_option("travel")] = None,
    positions: Annotated[str | None, pair_option("positions")] = None,
    surrogates: Annotated[str | None, pair_option("surrogates")] = None,
    seed: Annotated[str | None, pair_option("seed")] = None,
    unit: Annotated[list[str] | None, pair_option("unit")] = None,
    spacing: Annotated[list[str] | None, pair_option("spacing")] = None,
    missing: Annotated[str | None, pair_option("missing")] = None,
    missing_value: Annotated[list[str] | None, pair_option("missing_value")] = None,
    outliers: Annotated[str | None, pair_option("outliers")] = None,
    crop: Annotated[list[str] | None, pair_option("crop")] = None,
    channel: Annotated[list[str] | None, pair_option("channel")] = None,
    columns: Annotated[list[str] | None, pair_option("columns")] = None,
    accept: Annotated[list[str] | None, pair_option("accept")] = None,
    texture: Annotated[list[str] | None, pair_option("texture")] = None,
    tip: Annotated[list[str] | None, pair_option("tip")] = None,
    onset: Annotated[str | None, pair_option("onset")] = None,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    part: PartOption = None,
    output: OutputDirectoryOption = Path("pair"),
    replace: ReplaceOption = False,
    verbose: VerboseOption = False,
    as_json: JsonOption = False,
    help_all: HelpAllOption = False,
) -> None:
    """Compute the static friction of two measured profiles or surfaces at given loads, with intervals.

    Heights increase outward from the material in both files. UPPER is the slider and LOWER the counterface. To face
    LOWER, the map UPPER is flipped about the x axis, which reverses its rows. Height maps are pressed as areal
    contacts, or as pairs of profiles with --lines. Options that describe a file apply to both
    files; repeat an option to set UPPER and LOWER separately. The result is a study in DIR that run, at, plot, report,
    info and export accept.
    """
    from stiction.cli.execution import check_output_directory, compute_result_in_directory, open_executor, parse_part
    from stiction.cli.result_output import (
        choose_message_printer,
        print_pair_values,
        print_resolution_and_onset,
        print_result_json,
        write_pair_files,
    )
    from stiction.solve.store import STUDY_FILE
    from stiction.study.members import find_body_attributes
    from stiction.study.pair_options import validate_option_values
    from stiction.study.pair_study import MeasuredPair
    from stiction.views.files import OUTPUT_FILE_SIGNATURES, check_all_replaceable
    from stiction.views.rows import summary_json

    part_number, print_written = parse_part(part), choose_message_printer(as_json)
    check_output_directory(output)
    check_all_replaceable(output, OUTPUT_FILE_SIGNATURES)
    measured_pair = MeasuredPair(validate_option_values(read_given_options(context)))
    show_status("reading and checking the scans")
    for file in measured_pair.files:
        show_reader_import_status(Path(file.file))
    studies = measured_pair.studies
    # The surfaces are checked before any file is written.
    find_body_attributes(studies[0])
    # Without `verbose`, the remark on the source of the elastic constants is omitted: the result has the source.
    first_remark = 0 if verbose else bool(measured_pair.elasticity.source)
    for remark in measured_pair.remarks[first_remark:]:
        print_message(remark)
    if verbose and not as_json:
        for file in measured_pair.files:
            for scan in file.scans:
                if scan.reading is not None:
                    print_output(f"{printable_text(scan.name)}: {scan.reading}")
    printed_results: list[Result] = []

    def print_values(result: Result) -> None:
        if as_json:
            return
        if printed_results:
            print_output(f"\nBy {result.study.contact.mechanics}:\n")
        print_pair_values(result, verbose=verbose)
        printed_results.append(result)

    def print_companions(result: Result) -> None:
        if not as_json and part_number is None:
            print_resolution_and_onset(result, verbose=verbose)

    with open_executor(workers, scheduler) as executor:
        results: list[Result] = []
        if replace or not (output / STUDY_FILE).exists():
            submit_preview(measured_pair.preview_study, executor)
        for study in studies:
            directory = output / study.contact.mechanics if results else output
            result = compute_result_in_directory(
                study,
                directory,
                executor,
                print_written=print_written,
                part=part_number,
                replace=replace,
                onset=measured_pair.options.onset,
                show_result=print_values,
                show_companions=print_companions,
            )
            results.append(result)
    if part_number is not None:
        return
    if as_json:
        model_check_records = [json.loads(summary_json("pair", result.summary())) for result in results[1:]]
        readings = [scan.reading for file in measured_pair.files for scan in file.scans]
        fields: dict[str, Any] = {"files": [reading.to_json_fields() for reading in readings if reading is not None]}
        if model_check_records:
            fields["check"] = model_check_records
        print_result_json(results[0], "pair", **fields)
    try:
        for result in results:
            write_pair_files(result, print_written=print_written)
    except KeyboardInterrupt:
        advice = "run the same command again to write its report, table and figure"
        raise report_interruption(f"; the result is stored in {printable_path(output)}: {advice}") from None


def compute_preview_line(study: Study) -> str:
    """Compute the first few members of a study, and return a line of text with a preview of the friction coefficient.

    Raises `ValueError` if the surfaces do not touch.
    """
    from stiction.pipeline import compute_preview_result
    from stiction.views.text import preview_text

    return preview_text(compute_preview_result(study).summary())


def submit_preview(study: Study | None, executor: Executor) -> None:
    """Compute a preview of the coefficient in a worker and print it, if standard error is a terminal.

    Nothing is computed if `study` is None.
    """

    def print_preview(future: Future[str]) -> None:
        # The preview fails if the surfaces do not touch.
        if not future.cancelled() and future.exception() is None:
            print_message(future.result())

    if study is not None and is_stderr_terminal():
        executor.submit(compute_preview_line, study).add_done_callback(print_preview)
