"""Commands on results of every kind, generated or measured: info, plot, report, export."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stiction._arguments import split_values
from stiction._text import printable_path
from stiction.cli.application import command, tell
from stiction.cli.options import Json, Verbose, option
from stiction.cli.result_output import draw_result, opened, show_result

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="Where a study or a pair was written.")]


@command("info", "stiction info figure6", "stiction info pair --verbose", "stiction info figure6 --json")
def info(directory: Directory, verbose: Verbose = False, as_json: Json = False) -> None:
    """Show what a result is, how far it has come, its friction at a few loads and how far to trust it."""
    from stiction.studies.result import Result
    from stiction.studies.store import open_stored
    from stiction.studies.study import Study, differences
    from stiction.views.text import fitted

    stored = open_stored(directory)
    study, finished = stored.study, stored.count
    if as_json:
        about = {
            "study": study.to_toml(), "finished": finished, "repetitions": study.ensemble.repetitions,
            "bytes": stored.size, "versions": {"stiction": stored.version},
        }  # fmt: skip
        show_result(Result(stored), command="info", as_json=True, about=about)
        return
    if not study.is_measured:
        changes = [f"{key} = {value}" for key, _, value in differences(Study(), study)]
        words = ["the defaults, but", *changes] if changes else ["the defaults"]
        for index, each in enumerate(words):
            tell(fitted(f"{'' if index else 'study':<13}{each}", hang=" " * 15))
    elif verbose:
        tell(study.to_toml())
    tell(f"repetitions  {finished} of {study.ensemble.repetitions} finished")
    tell(f"size         {stored.size / 2**20:.1f} MiB, by stiction {stored.version}")
    if finished:
        tell("")
        show_result(Result(stored), command="info", verbose=verbose)


@command("plot", "stiction plot figure6", "stiction plot pair --format pdf,svg --output figures")
def plot(
    directory: Directory,
    output: Annotated[Path | None, option("--output -o DIR", "Where the figures go.", "DIR")] = None,
    formats: Annotated[str, option("--format FORMATS", 'Of the figures, some of "png,pdf,svg".')] = "png",
) -> None:
    """Draw the figures of a result again, or of what is finished of it."""
    from stiction.views.style import checked_formats

    wanted = checked_formats(split_values(formats))
    result = opened(directory)
    where = directory if output is None else output
    try:
        where.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f"{printable_path(where)}: cannot be written: {error.strerror or error}") from None
    draw_result(result, where, formats=wanted)


@command("report", "stiction report figure6", "stiction report pair -o mine.html")
def report(
    directory: Directory,
    output: Annotated[Path | None, option("--output -o FILE.html", "The page to write.", "DIR/report.html")] = None,
) -> None:
    """Make one interactive page, for any browser, of a result, or of what is finished of it."""
    from stiction.views.report import save_report

    path = output if output is not None else directory / "report.html"
    save_report(opened(directory), path, name=directory.resolve().name)
    tell(f"wrote {path}")


@command(
    "export", "stiction export figure6 figure6.nc", "stiction export pair pair.csv", "stiction export pair pair.tex"
)
def export(
    directory: Directory,
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="The file to write, .nc, .csv or .tex; it must not exist yet.")
    ],
) -> None:
    """Write a result, or its finished part, to one netCDF file, or its values at the loads of `info` to a table."""
    from stiction.views.files import write_result

    write_result(opened(directory), file)
    tell(f"wrote {file}")
