"""Commands for stored results of pairs and studies: `info`, `plot`, `report` and `export`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction._text import printable_path
from stiction.cli.application import command, print_output
from stiction.cli.loads import LoadsOption, parse_loads, report_missing_loads
from stiction.cli.options import JsonOption, Mu0Option, Tau0Option, VerboseOption, WorkersOption, option, reject_options

if TYPE_CHECKING:
    from stiction.result import Result

JOINT_DIRECTORY = "joint"
"""Name of the subdirectory of a pair's result directory for the result at all loads of the joint table."""

DirectoryArgument = Annotated[Path, typer.Argument(metavar="DIR", help="Directory of a result of `pair` or `run`.")]


SentenceOption = Annotated[
    bool, option("--sentence", "Print only the sentence to quote for each load, with all conditions.")
]


@command("info", "stiction info figure6", "stiction info pair --verbose", "stiction info pair --sentence")
def info(
    directory: DirectoryArgument,
    verbose: VerboseOption = False,
    as_json: JsonOption = False,
    sentence: SentenceOption = False,
) -> None:
    """Show the inputs of a result, its progress, its friction at a few loads, and its reliability."""
    from stiction.cli.result_output import open_result_with_warning, print_result, print_result_json, print_sentences
    from stiction.result import Result
    from stiction.solve.store import open_stored_result
    from stiction.study.member_names import MIXED_MEMBER_NAMES, POSITION_NAMES, SURROGATE_PAIR_NAMES
    from stiction.study.study import Study, find_section_differences
    from stiction.views.layout import wrap_text

    if sentence:
        if as_json or verbose:
            raise ValueError(f"--sentence must not be combined with {'--json' if as_json else '--verbose'}")
        print_sentences(open_result_with_warning(directory))
        return
    stored_result = open_stored_result(directory)
    study, num_finished = stored_result.study, stored_result.num_finished
    if as_json:
        fields: dict[str, Any] = {
            "study": study.to_toml(), "finished": num_finished, "repetitions": study.ensemble.repetitions,
            "bytes": stored_result.total_file_size, "versions": {"stiction": stored_result.version},
        }  # fmt: skip
        print_result_json(Result(stored_result), "info", **fields)
        return
    if not study.is_measured:
        changes = [f"{key} = {value}" for key, _, value in find_section_differences(Study(), study)]
        lines = ["default values except", *changes] if changes else ["default values"]
        for index, line in enumerate(lines):
            print_output(wrap_text(f"{'' if index else 'study':<13}{line}", hanging_indent=" " * 15))
    elif verbose:
        print_output(study.to_toml())
    kinds_text = ""
    if study.is_measured and study.member_names == MIXED_MEMBER_NAMES:
        surfaces: Any = study.surfaces
        num_surrogates = surfaces.first_scan_member_index
        position_text = POSITION_NAMES.with_count(study.ensemble.repetitions - num_surrogates)
        kinds_text = f": {SURROGATE_PAIR_NAMES.with_count(num_surrogates)}, then {position_text}"
    print_output(
        f"{study.member_names.plural:<11}  {num_finished} of {study.ensemble.repetitions} finished{kinds_text}"
    )
    print_output(
        f"size         {stored_result.total_file_size / 2**20:.1f} MiB, computed by stiction {stored_result.version}"
    )
    if num_finished:
        print_output("")
        print_result(Result(stored_result), verbose=verbose)


@command("plot", "stiction plot figure6", "stiction plot pair --format pdf,svg --output figures")
def plot(
    directory: DirectoryArgument,
    output: Annotated[Path | None, option("--output -o DIR", "Directory for the figures.", "DIR")] = None,
    formats: Annotated[str, option("--format FORMATS", 'Formats of the figures, from "png,pdf,svg".')] = "png",
) -> None:
    """Redraw the figures of a complete or unfinished result."""
    from stiction._arguments import split_values
    from stiction.cli.result_output import open_result_with_warning, write_figures
    from stiction.views.style import parse_formats

    chosen_formats = parse_formats(split_values(formats))
    result = open_result_with_warning(directory)
    figure_directory = directory if output is None else output
    try:
        figure_directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f"{printable_path(figure_directory)}: cannot be written: {error.strerror or error}") from None
    write_figures(result, figure_directory, formats=chosen_formats)


@command("report", "stiction report figure6", "stiction report pair -o mine.html")
def report(
    directory: DirectoryArgument,
    output: Annotated[Path | None, option("--output -o FILE.html", "File to write.", "DIR/report.html")] = None,
) -> None:
    """Write an interactive HTML report on a complete or unfinished result."""
    from stiction.cli.result_output import open_result_with_warning
    from stiction.views.report import save_report

    path = output if output is not None else directory / "report.html"
    save_report(open_result_with_warning(directory), path, name=directory.resolve().name)
    print_output(f"wrote {printable_path(path)}")


@command(
    "export",
    "stiction export figure6 figure6.nc",
    "stiction export pair pair.csv",
    "stiction export pair joint.csv --joint --compute",
    "stiction export pair joint.csv --joint --load '2 MPa,5 MPa'",
    "stiction export pair card.inp --units m,N,Pa --closure-from '0.1 MPa'",
    "stiction export shear parameters.csv --joint",
    "stiction export shear gap.npy --gap",
)
def export(
    context: typer.Context,
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="Directory of a result of `pair`, `run` or `shear`.")
    ],
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="File to write: .nc, .csv or .tex; with --joint, .csv or .json; with --gap, .npy or .csv; or a card "
            "of the joint for Abaqus and CalculiX (.inp), Ansys (.mac) or LIGGGHTS (.liggghts). It must not exist.",
        ),
    ],
    *,
    load: LoadsOption = None,
    mu0: Mu0Option = None,
    tau0: Tau0Option = None,
    joint: Annotated[
        bool,
        option(
            "--joint",
            "Write the joint: closure, stiffness and friction against pressure, and true area, or "
            "for shear tests peak and dilation.",
        ),
    ] = False,
    gap: Annotated[bool, option("--gap", "Write the gap between the faces of a shear test, for `pair --gap`.")] = False,
    units: Annotated[
        str | None, option("--units UNITS", "Units of the joint: mm,N,MPa, m,N,Pa or um,mN,GPa.", "mm,N,MPa")
    ] = None,
    closure_from: Annotated[
        str | None,
        option(
            "--closure-from PRESSURE",
            'Count the closure of the joint from this pressure, such as "0.1 MPa", or from a force.',
            "first contact",
        ),
    ] = None,
    compute: Annotated[
        bool, option("--compute", "Compute the contacts at all pressures of the joint, and store them in DIR/joint.")
    ] = False,
    workers: WorkersOption = None,
) -> None:
    """Write the stored result, a table of its values, or the joint for a finite-element model.

    A netCDF file contains the whole result, and a .csv file the values at --load or at the loads shown by `info`, for
    all fractal dimensions. The joint is a table of contact properties against pressure (--joint), or a card that
    contains them. A card contains the whole closure curve, and one tangential stiffness, at --load. Between the
    computed loads, the values of the joint are interpolated unless --compute is given. For a shear test, a .csv file
    contains the curve or, with --joint, the parameters of a joint model.
    """
    from stiction.cli.result_output import open_result_with_warning
    from stiction.direct_shear import export_shear_test
    from stiction.evaluate.computed_loads import find_loads_without_values
    from stiction.solve.store import STUDY_FILE, load_shear_test
    from stiction.summary.joint_table import DEFAULT_JOINT_UNITS, FIRST_CONTACT_NOTE
    from stiction.views.files import check_joint_file, choose_card_load, choose_joint_parameters, is_card

    chosen_units: Any = units
    # In the directory of a study, a file named like a stored shear test may be an export of the study.
    has_study = (directory / STUDY_FILE).exists()
    if not has_study and (test := load_shear_test(directory)) is not None:
        reject_options(
            context, "does not apply to shear tests", "load", "mu0", "tau0", "compute", "workers", "closure_from"
        )
        if gap:
            reject_options(context, "cannot be combined with --gap", "joint", "units")
        elif not joint:
            reject_options(context, "requires --joint", "units")
        export_shear_test(test, file, joint=joint, gap=gap, units=chosen_units)
        print_output(f"wrote {printable_path(file)}")
        return
    reject_options(context, "applies only to shear tests", "gap")
    result = open_result_with_warning(directory)
    loads = None if load is None else parse_loads(result, load)
    if compute:
        if not (joint or is_card(file)):
            reject_options(context, "applies only to joint tables and cards", "compute")
        check_joint_file(file, DEFAULT_JOINT_UNITS if units is None else chosen_units)
        choose_joint_parameters(result, file, mu0, tau0)
        card_load = choose_card_load(result, loads) if is_card(file) else None
        table_loads = None if is_card(file) else loads
        result = _compute_joint(result, directory / JOINT_DIRECTORY, workers, table_loads, closure_from, card_load)
        loads = loads if card_load is None else [card_load]
    else:
        reject_options(context, "requires --compute", "workers")
    # The export of a joint table or finite-element card prints its own warning about missing loads.
    if loads is not None and not (joint or is_card(file)):
        values = result.at(loads, quantities=[])
        report_missing_loads(result, values, find_loads_without_values(result, values))
    result.export(
        file, load=loads, mu0=mu0, tau0=tau0, joint=joint, units=chosen_units, closure_from=closure_from
    )  # fmt: skip
    print_output(f"wrote {printable_path(file)}")
    if (joint or is_card(file)) and closure_from is None:
        print_output(f"{FIRST_CONTACT_NOTE} (--closure-from).")


def _compute_joint(
    result: Result, directory: Path, workers: int | None, loads: list[float] | None, closure_from: str | None,
    card_load: float | None,
) -> Result:  # fmt: skip
    """Recompute a stored pair at the loads (mN) that a finite-element model of its joint requires.

    These are `loads`, or else the loads of a full table, with `card_load` and the load of `closure_from`.

    A result of another study in the directory is replaced.
    """
    from stiction.cli.execution import compute_result_in_directory, open_executor
    from stiction.solve.store import StudyMismatchError
    from stiction.summary.joint_table import build_joint_study, parse_closure_start

    study, area = result.study, result.nominal_area
    start_load = None if closure_from is None else parse_closure_start(closure_from, study, area)
    further_loads = [load for load in (start_load, card_load) if load is not None]
    study = build_joint_study(study, area, loads, *further_loads)
    with open_executor(workers, None) as executor:
        try:
            return compute_result_in_directory(study, directory, executor, onset=0)
        except StudyMismatchError:
            return compute_result_in_directory(study, directory, executor, onset=0, replace=True)
