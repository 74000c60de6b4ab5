"""Commands on studies: run, plot, report, info, export, claims, studies."""

from __future__ import annotations

import contextlib
import re
import warnings
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from stiction._core import __version__
from stiction._dask import show_dask
from stiction._text import named
from stiction._units import shortened
from stiction.cli.application import INTERRUPTED, announce, command, say, tell
from stiction.cli.options import Json
from stiction.mechanics.friction import Sums, Validity
from stiction.studies.executors import threads
from stiction.studies.processes import processes
from stiction.studies.runner import fill
from stiction.studies.streams import means as means_of
from stiction.studies.study import Study, differences, step_of, study_names, study_summary
from stiction.studies.study_text import StudyError, toml
from stiction.views.drawing import draw as drawn
from stiction.views.drawing import drawing

RESULT = "result.zarr"

PAPERS_FIGURES = ("figure2", "figure3", "figure5", "figure6", "figure7", "figure8")
"""Studies of the paper's."""

Workers = Annotated[
    int | None, typer.Option("--workers", "-w", metavar="N", min=1, help="Threads.", show_default="one for each core")
]
Cluster = Annotated[
    int | None,
    typer.Option("--cluster", metavar="N", min=1, help="Worker processes on this machine.", show_default=False),
]
Scheduler = Annotated[
    str | None, typer.Option("--scheduler", metavar="ADDRESS", help="A Dask scheduler, as in tcp://host:8786.")
]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value, as in ensemble.repetitions=10. Repeatable."),
]


@command(
    "run",
    "stiction run quick",
    "stiction run mine.toml --output results --workers 2",
    "stiction run figure6 --set ensemble.repetitions=10 --set 'contact.effective_modulus=70 GPa' --output stiffer",
)
def run_command(
    study: Annotated[str, typer.Argument(metavar="NAME_OR_FILE", help="A built-in study, or a study file (TOML).")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", "--store", metavar="DIR", help="Where the results go.", show_default="./NAME"),
    ] = None,
    workers: Workers = None,
    cluster: Cluster = None,
    scheduler: Scheduler = None,
    part: Annotated[
        str | None,
        typer.Option(
            "--part", metavar="I/N", help="Only the I-th of N parts, as in 3/16, beside others.", show_default=False
        ),
    ] = None,
    changes: Changes = None,
) -> None:
    """Compute a study, or what is missing of it, draw it, and print its friction at a few loads; or one part of it."""
    what = _changed(_study(study), changes)
    directory = output if output is not None else Path(Path(study).stem)
    which = None if part is None else _part(part)
    with contextlib.ExitStack() as stack:
        draw = stack.enter_context(drawing(directory / RESULT, directory)) if which is None else None
        with _executor(workers, cluster, scheduler) as executor:
            _fill(what, directory, executor, part=which)
        if draw is not None:
            announce("drawing")
            paths, answers = draw()
            for path in paths:
                tell(f"wrote {path}")
            tell(answers)


def _part(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"([1-9][0-9]{0,8})/([1-9][0-9]{0,8})", text)
    if not match or int(match[1]) > int(match[2]):
        raise StudyError(f"--part must be one of so many, as in 3/16, got {shortened(text)}")
    return int(match[1]), int(match[2])


@command("claims", "stiction claims", "stiction claims --json > claims.json")
def claims_command(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Where the results go.")] = Path(
        "claims"
    ),
    repetitions: Annotated[
        int | None,
        typer.Option(
            "--repetitions",
            metavar="N",
            min=20,
            help="Judge on so many as well.",
            show_default="100, the paper's",
        ),
    ] = None,
    columns: Annotated[
        bool,
        typer.Option(
            "--columns", help="Judge areas, half-planes and half-spaces too, on a share of the repetitions each."
        ),
    ] = False,
    workers: Workers = None,
    cluster: Cluster = None,
    scheduler: Scheduler = None,
    changes: Changes = None,
    as_json: Json = False,
) -> None:
    """Judge what the paper claims by its own studies, and by other choices where it leaves them open."""
    from stiction.studies import claims
    from stiction.views import records, tables

    replaced = _changes(changes or [])
    said = say if as_json else tell
    for name in claims.VARIANTS:
        claims.check(claims.variant_study(name).with_changes(replaced))
    others, beside = {}, {}
    with _executor(workers, cluster, scheduler) as executor:
        for name in PAPERS_FIGURES:
            dataset = _result(Study.named(name).with_changes(replaced), output / name, executor, said)
            _draw(dataset, output / name, said)
            if Study.named(name) == claims.claims_study():
                result, outcomes = dataset, claims.judge(dataset)
                last = outcomes
        for name in claims.VARIANTS:
            study = claims.variant_study(name).with_changes(replaced)
            dataset = _result(study, output / "variants" / name, executor, said)
            others[name] = claims.judge(dataset)
            if name == "default":
                others["amplitude 0.05 µm"] = claims.judge(dataset, amplitude=claims.FLATTER)
        most = result.sizes["repetition"]
        beside[f"lines, {most} repetitions"] = outcomes
        if repetitions is not None:
            most = repetitions
            study = claims.claims_study().with_changes({**replaced, "ensemble.repetitions": most})
            result = _result(study, output / "columns/lines", executor, said)
            beside[f"lines, {most} repetitions"] = last = claims.judge(result)
        beside["the same by bands"] = claims.judge(result, ruling="bands")
        del result
        for name, column in claims.COLUMNS.items() if columns else ():
            study = column.of(most)
            dataset = _result(study, output / "columns" / column.place, executor, said)
            beside[f"{name}, {study.ensemble.repetitions}"] = claims.judge(
                dataset, sliding=column.sliding, ruling="bands"
            )
    for file, text in (
        ("claims.md", tables.claims_markdown(outcomes)),
        ("variants.md", tables.variants_markdown(others)),
        ("columns.md", tables.columns_markdown(beside)),
    ):
        (output / file).write_text(text, encoding="utf-8")
        said(f"wrote {output / file}")
    tell(records.claims_record(last) if as_json else tables.claims_text(last))


@command("plot", "stiction plot figure6", "stiction plot figure6 --output figures")
def plot(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Where a study was written.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Where the figures go.", show_default="DIR")
    ] = None,
) -> None:
    """Draw the results of a study again, or what is finished of them; or those of a pair."""
    from stiction.cli.pair import draw_pair, paired
    from stiction.studies import store

    result = paired(directory)
    dataset = store.read(stored(directory)) if result is None else None
    if output is not None:
        try:
            output.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StudyError(f"{named(output)}: cannot be written: {error.strerror or error}") from None
    where = directory if output is None else output
    if result is None:
        _draw(dataset, where)
    else:
        draw_pair(result, where)


@command("report", "stiction report figure6", "stiction report quick figure6 -o both.html")
def report(
    directories: Annotated[
        list[Path],
        typer.Argument(metavar="DIR...", help="Where a study or a pair was written; two studies are compared."),
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE.html", help="The page to write.", show_default="DIR/report.html"),
    ] = None,
) -> None:
    """Make one interactive page, for any browser, of a study, or what is finished of it, or of a pair."""
    from stiction.cli.pair import paired
    from stiction.studies import store
    from stiction.views.report import save_report

    path = output if output is not None else directories[0] / "report.html"
    names = [each.resolve().name for each in directories]
    pairs = [paired(each) for each in directories]
    results = [
        store.read(stored(each)) if pair is None else pair for each, pair in zip(directories, pairs, strict=True)
    ]
    save_report(results, path, names=names)
    tell(f"wrote {path}")


@command("info", "stiction info figure6", "stiction info figure6 --json")
def info(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Where a study or a pair was written.")],
    as_json: Json = False,
) -> None:
    """Show what a study is, how far it has come, its friction at a few loads and how far to trust it; or a pair."""
    from stiction.cli.pair import paired, show_pair
    from stiction.studies import store
    from stiction.views import answers, records

    if (result := paired(directory)) is not None:
        show_pair(result, as_json=as_json)
        return
    kept = store.info(stored(directory))
    if as_json:
        with warnings.catch_warnings(action="ignore"):  # that it is not finished is in the record
            found = answers.answers(store.read(stored(directory))) if kept.finished else None
        tell(records.study_record(kept, found))
        return
    changes = [f"{key} = {value}" for key, _, value in differences(Study(), kept.study)]
    tell("study        " + "\n             ".join(["the defaults, but", *changes] if changes else ["the defaults"]))
    tell(f"repetitions  {kept.finished} of {kept.study.ensemble.repetitions} finished")
    tell(f"size         {kept.size / 2**20:.1f} MiB")
    tell("versions     " + ", ".join(f"{name} {version}" for name, version in kept.versions.items()))
    if kept.finished:
        with warnings.catch_warnings(action="ignore"):  # that it is not finished stands above
            dataset = store.read(stored(directory))
        _show_validity(dataset)
        tell(answers.answers_text(dataset))


def _show_validity(dataset: Any) -> None:
    """Of the mean over the repetitions: from the least to the most over fractal dimensions and amplitudes."""
    means: Any = means_of(dataset)
    step = step_of(dataset)
    if step == "load":
        figures = {name: means[f"{name}_share_at_hardness"] for name in ("load", "area")}
        figures = {f"{name}_at_hardness": figure for name, figure in figures.items()}
    else:
        figures = vars(Validity.of(Sums.of(means)))
    steps = dataset[step].values
    shown = sorted({0, steps.size // 2, steps.size - 1})
    titles = [f"at {steps[index]:.3g} mN" if step == "load" else f"at {1000 * steps[index]:.3g} nm" for index in shown]
    tell(f"{'validity':<24}" + "".join(f"{title:>18}" for title in titles))
    for name, figure in figures.items():
        columns = (figure.isel({step: index}).values for index in shown)
        ranges = "".join(f"{_range(column[~np.isnan(column)]):>18}" for column in columns)
        tell(f"  {name.replace('_', ' '):<22}{ranges}")


def _range(values: Any) -> str:
    return f"{values.min():.2g} to {values.max():.2g}" if values.size else "no contact"


@command("export", "stiction export figure6 figure6.nc")
def export(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Where a study was written.")],
    file: Annotated[Path, typer.Argument(metavar="FILE.nc", help="The file to write; it must not exist yet.")],
) -> None:
    """Write the results of a study or a pair, or what is finished of them, to one netCDF file."""
    from stiction.cli.pair import paired
    from stiction.studies import export as exports
    from stiction.studies import store

    result = paired(directory)
    exports.export(store.read(stored(directory)) if result is None else result, file)
    tell(f"wrote {file}")


@command("studies", "stiction studies", "stiction studies figure6 > mine.toml")
def studies(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="The study to print.", show_default=False)] = None,
) -> None:
    """List the built-in studies, or print one as a study file."""
    if name is not None:
        tell(Study.named(name).to_toml())
        return
    names = study_names()
    width = max(map(len, names)) + 2
    for each in names:
        tell(f"{each:<{width}}{study_summary(each)}")


def _executor(
    workers: int | None, cluster: int | None, scheduler: str | None
) -> contextlib.AbstractContextManager[Executor]:
    if sum(choice is not None for choice in (workers, cluster, scheduler)) > 1:
        raise StudyError("--workers, --cluster and --scheduler exclude each other")
    if cluster is not None:
        return processes(cluster)
    if scheduler is not None:
        show_dask()
        from stiction.studies.cluster import connected

        return connected(scheduler)
    return threads(workers)


def stored(directory: Path) -> Path:
    """The store of a study that was written to a directory."""
    if not directory.exists():
        raise StudyError(f"{named(directory)}: no such directory")
    if not (directory / RESULT).exists():
        raise StudyError(f"{named(directory)}: is not a result: neither a study nor a pair was written there")
    return directory / RESULT


def _result(study: Study, directory: Path, executor: Executor, said: Callable[[str], None]) -> Any:
    """The result of a study in a directory, of which what is there already is not computed again."""
    from stiction.studies import store

    _fill(study, directory, executor, said)
    return store.read(directory / RESULT)


def _fill(
    study: Study,
    directory: Path,
    executor: Executor,
    said: Callable[[str], None] = tell,
    part: tuple[int, int] | None = None,
) -> None:
    """Compute what a directory lacks of a study, or of a part of it."""
    from stiction.studies import store

    if directory.is_file():
        raise StudyError(f"{named(directory)} is a file; say where the results shall go with --output DIR")
    path = directory / RESULT
    stored = store.info(path).finished if path.exists() else 0
    try:
        held = fill(study, path, part=part, executor=executor, progress=True, say=said)
    except KeyboardInterrupt:
        # Said at once; the repetitions that are being computed come to their end first.
        say(f"interrupted{_how_to_go_on(path)}")
        raise typer.Exit(INTERRUPTED) from None
    if part is not None:
        kept = store.info(path)
        said(
            f"part {part[0]}/{part[1]} is finished, {held} repetitions; {kept.finished} of "
            f"{study.ensemble.repetitions} are in {path}"
        )
    elif stored < study.ensemble.repetitions:
        total = study.ensemble.repetitions
        said(f"wrote {path}" + (f" ({stored} of its {total} repetitions were there already)" if stored else ""))
    else:
        computed_by = store.info(path).versions["stiction"]
        by = "" if computed_by == __version__ else f", computed by stiction {computed_by}"
        said(f"{path} holds this study already{by}; drawing it again")


def _how_to_go_on(path: Path) -> str:
    from stiction.studies import store

    if not path.exists():
        return ""
    kept = store.info(path)
    total = kept.study.ensemble.repetitions
    return f"; {kept.finished} of {total} repetitions are finished and kept: the same command goes on from there"


def _draw(dataset: Any, directory: Path, said: Callable[[str], None] = tell) -> None:
    announce("drawing")
    for path in drawn(dataset, directory):
        said(f"wrote {path}")


def _study(name_or_file: str) -> Study:
    if name_or_file in study_names():
        return Study.named(name_or_file)
    path = Path(name_or_file)
    if path.suffix or path.exists() or len(path.parts) > 1:
        return Study.from_toml(path)
    return Study.named(name_or_file)  # and its list of names


def _changed(study: Study, assignments: list[str] | None) -> Study:
    """A study with what `--set` changes; errors name the option."""
    try:
        return study.with_changes(_changes(assignments or []))
    except StudyError as error:
        raise StudyError(str(error).replace("changes: ", "--set ")) from None


def _changes(assignments: list[str]) -> dict[str, Any]:
    changes = {}
    for assignment in assignments:
        key, equals, value = assignment.partition("=")
        if not equals or not key.strip():
            raise StudyError(f"--set needs KEY=VALUE, as in ensemble.repetitions=10, got {shortened(assignment)}")
        changes[key.strip()] = _value(value.strip())
    return changes


def _value(text: str) -> Any:
    """A TOML value; what is none is a string, so that quantities need no quotes of their own."""
    try:
        parsed = toml(f"value = {text}")
    except ValueError:
        return text
    return parsed["value"] if len(parsed) == 1 else text
