"""Commands on studies: run, plot, report, info, export, claims, studies."""

from __future__ import annotations

import contextlib
import sys
import tomllib
import warnings
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from stiction import __version__
from stiction.cli.application import INTERRUPTED, app, say
from stiction.mechanics.friction import Sums, Validity
from stiction.studies.runner import available_cores, run
from stiction.studies.study import Study, StudyError, differences, study_names

RESULT = "result.zarr"

Workers = Annotated[
    int | None, typer.Option("--workers", "-w", min=1, help="Threads.", show_default="one for each core")
]
Cluster = Annotated[
    int | None,
    typer.Option("--cluster", metavar="N", min=1, help="Worker processes of a local Dask cluster.", show_default=False),
]
Scheduler = Annotated[
    str | None, typer.Option("--scheduler", metavar="ADDRESS", help="A Dask scheduler, as in tcp://host:8786.")
]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value, as in ensemble.repetitions=10. Repeatable."),
]


@app.command("run")
def run_command(
    study: Annotated[str, typer.Argument(metavar="NAME_OR_FILE", help="A built-in study, or a study file (TOML).")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Where the results go.", show_default="./NAME")
    ] = None,
    workers: Workers = None,
    cluster: Cluster = None,
    scheduler: Scheduler = None,
    changes: Changes = None,
) -> None:
    """Compute a study, or what is missing of it, and draw it."""
    what = _study(study).with_changes(_changes(changes or []))
    directory = output if output is not None else Path(Path(study).stem)
    with _executor(workers, cluster, scheduler) as executor:
        dataset = _result(what, directory, executor)
    _draw(dataset, directory)


@app.command("claims")
def claims_command(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Where the results go.")] = Path(
        "claims"
    ),
    workers: Workers = None,
    changes: Changes = None,
) -> None:
    """Judge what the paper claims by its own studies, and by other choices where it leaves them open."""
    from stiction.studies import claims
    from stiction.views import tables

    replaced = _changes(changes or [])
    for name in claims.VARIANTS:
        claims.check(claims.variant_study(name).with_changes(replaced))
    others = {}
    with _executor(workers, None, None) as executor:
        for name in (name for name in study_names() if name.startswith("figure")):
            dataset = _result(Study.named(name).with_changes(replaced), output / name, executor)
            _draw(dataset, output / name)
            if Study.named(name) == claims.claims_study():
                outcomes = claims.judge(dataset)
        for name in claims.VARIANTS:
            study = claims.variant_study(name).with_changes(replaced)
            dataset = _result(study, output / "variants" / name, executor)
            others[name] = claims.judge(dataset)
            if name == "default":
                others["amplitude 0.05 µm"] = claims.judge(dataset, amplitude=claims.FLATTER)
    for file, text in (
        ("claims.md", tables.claims_markdown(outcomes)),
        ("variants.md", tables.variants_markdown(others)),
    ):
        (output / file).write_text(text, encoding="utf-8")
        typer.echo(f"wrote {output / file}")
    typer.echo(tables.claims_text(outcomes), nl=False)


@app.command()
def plot(directory: Annotated[Path, typer.Argument(metavar="DIR", help="Where a study was written.")]) -> None:
    """Draw the results of a study again, or what is finished of them."""
    from stiction.studies import store

    _draw(store.read(directory / RESULT), directory)


@app.command()
def report(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Where a study was written.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE.html", help="The page to write.", show_default="DIR/report.html"),
    ] = None,
) -> None:
    """Make one interactive page, for any browser, of the results of a study, or of what is finished of them."""
    from stiction.studies import store
    from stiction.views.report import save_report

    path = output if output is not None else directory / "report.html"
    save_report(store.read(directory / RESULT), path)
    typer.echo(f"wrote {path}")


@app.command()
def info(directory: Annotated[Path, typer.Argument(metavar="DIR", help="Where a study was written.")]) -> None:
    """Show what a study is, how far it has come, and how far its results are to be trusted."""
    from stiction.studies import store

    kept = store.info(directory / RESULT)
    changes = [f"{key} = {value}" for key, _, value in differences(Study(), kept.study)]
    typer.echo(
        "study        " + "\n             ".join(["the defaults, but", *changes] if changes else ["the defaults"])
    )
    typer.echo(f"repetitions  {kept.finished} of {kept.study.ensemble.repetitions} finished")
    typer.echo(f"size         {kept.size / 2**20:.1f} MiB")
    typer.echo("versions     " + ", ".join(f"{name} {version}" for name, version in kept.versions.items()))
    if kept.finished:
        with warnings.catch_warnings(action="ignore"):  # that it is not finished stands above
            dataset = store.read(directory / RESULT)
        _show_validity(dataset)


def _show_validity(dataset: Any) -> None:
    """Of the mean over the repetitions: from the least to the most over fractal dimensions and amplitudes."""
    figures = vars(Validity.of(Sums.of(dataset.mean("repetition"))))
    approaches = dataset["approach"].values
    shown = sorted({0, approaches.size // 2, approaches.size - 1})
    titles = [f"at {1000 * approaches[index]:.3g} nm" for index in shown]
    typer.echo(f"{'validity':<24}" + "".join(f"{title:>18}" for title in titles))
    for name, figure in figures.items():
        columns = (figure.isel(approach=index).values for index in shown)
        ranges = "".join(f"{_range(column[~np.isnan(column)]):>18}" for column in columns)
        typer.echo(f"  {name.replace('_', ' '):<22}{ranges}")


def _range(values: Any) -> str:
    return f"{values.min():.2g} to {values.max():.2g}" if values.size else "no contact"


@app.command()
def export(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Where a study was written.")],
    file: Annotated[Path, typer.Argument(metavar="FILE.nc", help="The file to write; it must not exist yet.")],
) -> None:
    """Write the results of a study, or what is finished of them, to one netCDF file."""
    from stiction.studies import export as exports
    from stiction.studies import store

    exports.export(store.read(directory / RESULT), file)
    typer.echo(f"wrote {file}")


@app.command()
def studies(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="The study to print.", show_default=False)] = None,
) -> None:
    """List the built-in studies, or print one as a study file."""
    if name is not None:
        typer.echo(Study.named(name).to_toml(), nl=False)
        return
    for each in study_names():
        typer.echo(each)


def _executor(
    workers: int | None, cluster: int | None, scheduler: str | None
) -> contextlib.AbstractContextManager[Executor]:
    if sum(choice is not None for choice in (workers, cluster, scheduler)) > 1:
        raise StudyError("--workers, --cluster and --scheduler exclude each other")
    if cluster is not None or scheduler is not None:
        from stiction.studies import cluster as clusters

        return clusters.local(cluster) if cluster is not None else clusters.connected(str(scheduler))
    return ThreadPoolExecutor(max_workers=workers or available_cores())


def _result(study: Study, directory: Path, executor: Executor) -> Any:
    """The result of a study in a directory, of which what is there already is not computed again."""
    from stiction.studies import store

    if directory.is_file():
        raise StudyError(f"{directory} is a file; say where the results shall go with --output DIR")
    path = directory / RESULT
    stored = store.info(path).finished if path.exists() else 0
    try:
        dataset = run(study, executor=executor, store=path, progress=sys.stderr.isatty())
    except KeyboardInterrupt:
        # Said at once; the repetitions that are being computed come to their end first.
        say(f"interrupted{_how_to_go_on(path)}")
        raise typer.Exit(INTERRUPTED) from None
    total = study.ensemble.repetitions
    if stored < total:
        typer.echo(f"wrote {path}" + (f" ({stored} of its {total} repetitions were there already)" if stored else ""))
    else:
        computed_by = dataset.attrs["stiction_version"]
        by = "" if computed_by == __version__ else f", computed by stiction {computed_by}"
        typer.echo(f"{path} holds this study already{by}; drawing it again")
    return dataset


def _how_to_go_on(path: Path) -> str:
    from stiction.studies import store

    if not path.exists():
        return ""
    kept = store.info(path)
    total = kept.study.ensemble.repetitions
    return f"; {kept.finished} of {total} repetitions are finished and kept: the same command goes on from there"


def _draw(dataset: Any, directory: Path) -> None:
    from stiction.views.figures import save_figures

    for path in save_figures(dataset, directory):
        typer.echo(f"wrote {path}")


def _study(name_or_file: str) -> Study:
    if name_or_file in study_names():
        return Study.named(name_or_file)
    path = Path(name_or_file)
    if path.suffix or path.exists() or len(path.parts) > 1:
        return Study.from_toml(path)
    return Study.named(name_or_file)  # and its list of names


def _changes(assignments: list[str]) -> dict[str, Any]:
    changes = {}
    for assignment in assignments:
        key, equals, value = assignment.partition("=")
        if not equals or not key.strip():
            raise StudyError(f"--set needs KEY=VALUE, as in ensemble.repetitions=10, got {assignment!r}")
        changes[key.strip()] = _value(value.strip())
    return changes


def _value(text: str) -> Any:
    """A TOML value; what is none is a string, so that quantities need no quotes of their own."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return parsed["value"] if len(parsed) == 1 else text
