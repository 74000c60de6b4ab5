"""The `stiction` command: parsing and printing only."""

from __future__ import annotations

import contextlib
import os
import sys
import tomllib
import warnings
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import typer
from typer.core import TyperGroup

from stiction import __version__
from stiction._checks import choice
from stiction._units import quantity
from stiction.mechanics.contact import Validity
from stiction.studies.runner import available_cores, run
from stiction.studies.study import Study, StudyError, differences, study_names
from stiction.surfaces.formats import read_measurement
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface


class _Commands(TyperGroup):
    """Says that it was interrupted, of which typer makes an exit status without a word."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            _say("interrupted")
            raise typer.Exit(INTERRUPTED) from None


app = typer.Typer(
    name="stiction",
    cls=_Commands,
    help="The coefficient of static friction of rough surfaces, from their shape.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

RESULT = "result.zarr"
INTERRUPTED = 130

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

# Of every command that reads measured profiles or surfaces.
Unit = Annotated[
    str | None,
    typer.Option(
        "--unit",
        metavar="UNIT",
        help='Of the lengths in the file, "um", or of positions and heights, "mm,um". Needed where it says none.',
        show_default=False,
    ),
]
Spacing = Annotated[
    str | None,
    typer.Option(
        "--spacing",
        metavar="LENGTH",
        help='Distance of points, "0.5 um", or of rows and of columns, "2 um,0.5 um". Needed where the file has none.',
        show_default=False,
    ),
]
Units = Annotated[
    list[str] | None,
    typer.Option("--unit", metavar="UNIT", help="As for characterise; twice if the files differ.", show_default=False),
]
Spacings = Annotated[
    list[str] | None,
    typer.Option("--spacing", metavar="LENGTH", help="The same.", show_default=False),
]
MissingPoints = Annotated[
    str, typer.Option("--missing", metavar="error|interpolate", help="What to do about points without a height.")
]


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"stiction {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    pass


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
    figures = vars(Validity.of(dataset.mean("repetition")))
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
def characterise(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A measured profile or surface.")],
    unit: Unit = None,
    spacing: Spacing = None,
    missing: MissingPoints = "error",
    row: Annotated[
        int | None, typer.Option("--row", metavar="N", min=0, help="Of a surface, this row alone, from 0 on.")
    ] = None,
    column: Annotated[
        int | None, typer.Option("--column", metavar="N", min=0, help="Of a surface, this column alone, from 0 on.")
    ] = None,
    level: Annotated[
        str | None,
        typer.Option(
            "--level",
            metavar="TREND",
            help="What to subtract: none, mean, line or quadratic; of a surface none, mean or plane.",
            show_default="line, plane",
        ),
    ] = None,
    band: Annotated[
        str | None,
        typer.Option(
            "--band",
            metavar="SHORTEST,LONGEST",
            help='Wavelengths to fit the Hurst exponent to, "1 um,100 um".',
            show_default="found",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="PNG", help="The figure to draw.", show_default="./FILE.png"),
    ] = None,
) -> None:
    """Show what a measured profile or surface is like: parameters, spectrum, Hurst exponent."""
    from stiction.surfaces.lines import line_roughness
    from stiction.views import characterisation as views
    from stiction.views.figures import save_picture

    fitted = _band(band)
    body = _levelled(_line(_measurement(file, unit, spacing, missing), row, column), level)
    if isinstance(body, Profile):
        typer.echo(views.characterisation_text(body, band=fitted), nl=False)
        figure = views.characterisation_figure(body, band=fitted)
    else:
        along_x, along_y = (line_roughness(body, along, band=fitted) for along in ("x", "y"))
        typer.echo(views.surface_characterisation_text(body, along_x, along_y), nl=False)
        figure = views.surface_characterisation_figure(body, along_x, along_y)
    path = output if output is not None else Path(f"{file.stem}.png")
    save_picture(figure, path)
    typer.echo(f"wrote {path}")


def _line(body: Profile | Surface, row: int | None, column: int | None) -> Profile | Surface:
    """A row or a column of a surface, if one is asked for."""
    for name, index, other in (("row", row, column), ("column", column, row)):
        if index is None:
            continue
        if isinstance(body, Profile) or other is not None:
            raise ValueError(f"--{name} is " + ("for surfaces" if other is None else "not for use with --column"))
        count = body.heights.shape[name == "column"]
        if index >= count:
            raise ValueError(f"--{name} must be at most {count - 1}, got {index}")
        return body.row(index) if name == "row" else body.column(index)
    return body


def _levelled(body: Profile | Surface, level: Any) -> Profile | Surface:
    if level == "none":
        return body
    if isinstance(body, Profile):
        level = "line" if level is None else level
        choice("--level", level, Literal["none", "mean", "line", "quadratic"])
        return levelled(body, level)
    level = "plane" if level is None else level
    choice("--level", level, Literal["none", "mean", "plane"])
    return levelled(body, level)


def _band(text: str | None) -> tuple[float, float] | None:
    """Two wavelengths in µm."""
    if text is None:
        return None
    parts = text.split(",")
    if len(parts) != 2:
        raise ValueError(f'--band needs two wavelengths, as in "1 um,100 um", got {text!r}')
    shortest, longest = (_quantity("--band", part.strip(), "length") for part in parts)
    return shortest, longest


@app.command()
def pair(
    upper: Annotated[Path, typer.Argument(metavar="UPPER", help="A measured profile or surface: the slider.")],
    lower: Annotated[Path, typer.Argument(metavar="LOWER", help="What it is carried over; the same file may be both.")],
    effective_modulus: Annotated[str, typer.Option("--effective-modulus", metavar="PRESSURE", help='As in "10 GPa".')],
    mu0: Annotated[float, typer.Option("--mu0", metavar="NUMBER", help="Molecular friction coefficient.")],
    load: Annotated[
        list[str], typer.Option("--load", metavar="FORCE", help='Normal load on the slider, "0.1 mN". Repeatable.')
    ],
    tau0: Annotated[str, typer.Option("--tau0", metavar="PRESSURE", help="Adhesive shear strength.")] = "0 MPa",
    offsets: Annotated[
        int | None,
        typer.Option(
            "--offsets", min=1, help="Positions along the lower profile.", show_default="16, or 1 for several lines"
        ),
    ] = None,
    travel: Annotated[
        str | None,
        typer.Option("--travel", metavar="LENGTH", help="Offset of the last position.", show_default="half the length"),
    ] = None,
    lines: Annotated[int, typer.Option("--lines", min=1, help="Pairs of lines of surfaces, or of surrogates.")] = 16,
    along: Annotated[str, typer.Option("--along", metavar="x|y", help="Direction of the lines of surfaces.")] = "x",
    level: Annotated[
        str, typer.Option("--level", metavar="mean|line|quadratic|none", help="What is taken off each line.")
    ] = "line",
    surrogates: Annotated[
        str,
        typer.Option(
            "--surrogates",
            metavar="none|upper|lower|both",
            help="Replaced by profiles of equal spectrum, new phases.",
        ),
    ] = "none",
    seed: Annotated[int, typer.Option("--seed", help="Of the surrogates.")] = 2016,
    law: Annotated[str, typer.Option("--law", metavar="hertz-sphere|hertz-cylinder", help="Contact law.")] = (
        "hertz-sphere"
    ),
    detection: Annotated[
        str, typer.Option("--detection", metavar="gap-minimum|cell", help="How contacts are found.")
    ] = "gap-minimum",
    curvature: Annotated[
        str, typer.Option("--curvature", metavar="convex|signed", help="Whether cups count as well.")
    ] = "convex",
    unit: Units = None,
    spacing: Spacings = None,
    missing: MissingPoints = "error",
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Where the results go.")] = Path("pair"),
) -> None:
    """Static friction of two measured profiles or surfaces at given loads, in both directions, with intervals.

    Heights of both files point out of the material. A profile is carried over the other; of surfaces, lines are paired.
    """
    from stiction.studies import export as exports
    from stiction.studies import traverse as traverses
    from stiction.views import pairing

    bodies = [
        _measurement(file, _either(unit, index, "--unit"), _either(spacing, index, "--spacing"), missing)
        for index, file in enumerate((upper, lower))
    ]
    loads = [_quantity("--load", each, "force") for each in load]
    contact: Any = {
        "effective_modulus": _quantity("--effective-modulus", effective_modulus, "pressure"),
        "law": law,
        "detection": detection,
        "curvature": curvature,
    }
    uppers, lowers = traverses.paired_lines(
        *bodies,
        travel=None if travel is None else _quantity("--travel", travel, "length"),
        level=None if level == "none" else level,  # type: ignore[arg-type]
        lines=lines, along=along, surrogates=surrogates, seed=seed,  # type: ignore[arg-type]
    )  # fmt: skip
    table = output / "result.nc"
    if table.exists():
        raise ValueError(f"{table}: exists already; say where the results shall go with --output DIR")
    room = lowers[0].extent - uppers[0].extent
    positions = offsets if offsets is not None else 1 if len(uppers) > 1 else 16
    if positions > 1 and not room > 0:
        raise ValueError(f"--offsets {positions} needs a --travel LENGTH, for which the slider is shortened")
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f"{output}: cannot be written: {os.strerror(error.errno or 0)}") from None
    result = traverses.traverse(
        uppers, lowers, traverses.loads_around(loads),
        mu0=mu0, tau0=_quantity("--tau0", tau0, "pressure"),
        # One line on itself is no pair at 0; several are not on themselves.
        offsets=0.0 if len(uppers) > 1 and positions == 1 and travel is None
        else room * np.arange(1, positions + 1) / positions,
        progress=sys.stderr.isatty(), **contact,
    )  # fmt: skip
    mean = traverses.traverse_mean(result)
    typer.echo(pairing.traverse_text(result, mean, loads), nl=False)
    exports.export(result, table)
    typer.echo(f"wrote {table}")
    for path in pairing.save_traverse_figures(result, mean, loads, uppers, lowers, output, **contact):
        typer.echo(f"wrote {path}")


def _quantity(option: str, text: str, kind: str) -> float:
    try:
        return float(quantity(text, kind))
    except ValueError as error:
        raise ValueError(f"{option} {error}") from None


def _either(values: list[str] | None, index: int, option: str) -> str | None:
    """An option that is given once for both files, or for each of them."""
    if not values:
        return None
    if len(values) > 2:
        raise ValueError(f"{option} is for both files, or given twice for one after the other, got {len(values)}")
    return values[index] if len(values) == 2 else values[0]


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


def _measurement(file: Path, unit: str | None, spacing: str | None, missing: str) -> Profile | Surface:
    """What a file holds, by the options that every command takes for it."""
    return read_measurement(file, unit=_one_or_pair(unit), spacing=_one_or_pair(spacing), missing=missing)  # type: ignore[arg-type]


def _one_or_pair(text: str | None) -> Any:
    return text if text is None or "," not in text else tuple(part.strip() for part in text.split(","))


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
        _say(f"interrupted{_how_to_go_on(path)}")
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


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    print(f"stiction: warning: {message}", file=sys.stderr)


def _say(text: str) -> None:
    print("\n".join(f"stiction: {line}" for line in text.splitlines()), file=sys.stderr)


def main() -> None:
    """Run the command: exit status 0, 2 for bad input with one message, 130 when interrupted."""
    warnings.showwarning = _show_warning
    try:
        app()
    except (ValueError, OSError, MemoryError) as error:
        _say(str(error) or type(error).__name__)
        sys.exit(2)
    except KeyboardInterrupt:
        _say("interrupted")
        sys.exit(INTERRUPTED)
