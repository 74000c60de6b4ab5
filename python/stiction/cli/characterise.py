"""`stiction characterise`: one measured profile or surface."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

import typer

from stiction._arguments import parse_quantity
from stiction._files import check_replaceable
from stiction._text import MAX_PATH_LENGTH, printable, printable_path
from stiction.cli.application import command, option_was_given, say, tell
from stiction.cli.options import Json, measurement, option
from stiction.cli.pair_options import given_options, option_of
from stiction.studies.measured_surfaces import TEXTURES
from stiction.studies.pair_options import READING
from stiction.surfaces.preparation import ProfileForm, SurfaceForm, levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    from stiction.views.characterisation import Characterisation

Row = Annotated[int | None, option("--row N", "Of a surface, this row alone, from 0 on.", least=0)]
Column = Annotated[int | None, option("--column N", "Of a surface, this column alone, from 0 on.", least=0)]
Level = Annotated[str | None, option(
    "--level --form FORM",
    "Form to subtract: none, mean, line, quadratic, cubic to sextic or circle; of a surface plane instead of line, and "
    "sphere or cylinder.", "line, plane",
)]  # fmt: skip
LongCutoff = Annotated[
    str | None,
    option("--lc LENGTH", "Cutoff λc of R-parameters, and of S-parameters if given.", "by the setting class"),
]
ShortCutoff = Annotated[
    str | None, option("--ls LENGTH", "Cutoff λs of R-parameters, and of S-parameters if given; none for no filter.",
                       "by the setting class"),
]  # fmt: skip
Robust = Annotated[bool, option("--robust", "Take the robust Gaussian regression filter for λc.")]
Band = Annotated[
    str | None, option("--band SHORTEST,LONGEST", 'Wavelengths to fit the Hurst exponent to, "1 um,100 um".', "found")
]
CutOff = Annotated[
    str | None, option("--cutoff LENGTH", 'Take off waves shorter than this (Gaussian), "0.1 um".', "the scan as it is")
]
Together = Annotated[bool, option("--together", "Several scans of one surface, alike in all directions: one spectrum.")]
Repeated = Annotated[bool, option("--repeated", "Two scans of one place: what both have, and the noise of one.")]
DryRun = Annotated[bool, option("--dry-run", "Show how each file is read, and nothing else.")]
Output = Annotated[
    Path | None,
    option(
        "--output -o FILE",
        "What to write, by its ending: of a file its page, or its figure and the page; of several a table.",
        "./FILE.html and .png, ./characterised.csv, ./joined.csv and .png, ./repeated.npy, ./noise.csv and .png",
    ),
]


@command(
    "characterise",
    "stiction characterise lapped.csv",
    "stiction characterise lapped.csv --dry-run",
    "stiction characterise map.npy --unit nm --spacing '2 um,0.5 um' --row 17",
    "stiction characterise *.csv --output finishes.csv",
    "stiction characterise lapped.csv --cutoff '100 nm' --tip '2 um' --json",
    "stiction characterise turned.csv --form circle --lc '0.8 mm'",
    "stiction characterise coarse.x3p fine.di --together",
    "stiction characterise first.di second.di --repeated",
)
def characterise(
    context: typer.Context,
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="Measured profiles or surfaces.")],
    *,
    unit: Annotated[str | None, option_of("unit", repeatable=False)] = None,
    spacing: Annotated[str | None, option_of("spacing", repeatable=False)] = None,
    missing: Annotated[str | None, option_of("missing")] = None,
    missing_value: Annotated[str | None, option_of("missing_value", repeatable=False)] = None,
    outliers: Annotated[str | None, option_of("outliers")] = None,
    crop: Annotated[str | None, option_of("crop", repeatable=False)] = None,
    channel: Annotated[str | None, option_of("channel", repeatable=False)] = None,
    columns: Annotated[str | None, option_of("columns", repeatable=False)] = None,
    accept: Annotated[str | None, option_of("accept", repeatable=False)] = None,
    texture: Annotated[str | None, option_of("texture", repeatable=False)] = None,
    tip: Annotated[str | None, option_of("tip", repeatable=False)] = None,
    row: Row = None,
    column: Column = None,
    level: Level = None,
    lc: LongCutoff = None,
    ls: ShortCutoff = None,
    robust: Robust = False,
    band: Band = None,
    cutoff: CutOff = None,
    together: Together = False,
    repeated: Repeated = False,
    dry_run: DryRun = False,
    output: Output = None,
    as_json: Json = False,
) -> None:
    """Show what a measured profile or surface is like: parameters, spectrum, Hurst exponent.

    Of one file it prints a table, makes a page for any browser and draws a figure; of several it writes one CSV file, a
    row for each. With --json it writes only what --output says.
    """
    from stiction.surfaces.cut_off import cut_off
    from stiction.views import characterisation as views
    from stiction.views.files import new_text
    from stiction.views.rows import record
    from stiction.views.style import save_picture

    reading = {name: str(text) for name, text in given_options(context).items() if name in READING}
    outputs = (
        [] if dry_run or (as_json and output is None) else _outputs(files, output, together=together, repeated=repeated)
    )
    fitted = _band(band)
    shortest = None if cutoff is None else parse_quantity("cutoff", cutoff, "length")
    filters = _filters(lc, ls, robust=robust, joined=together or repeated)
    if texture is not None and texture not in TEXTURES:
        raise ValueError(f"--texture must be {', '.join(TEXTURES)}, got {texture!r}")
    radius = None if tip is None else parse_quantity("tip", tip, "length")
    found, readings = [], []
    for file in files:
        read = measurement(file, reading)
        readings.append(read)
        if not as_json:
            tell(f"{printable(file.name)}: {read}")
            for caveat in read.caveats:
                say(f"{printable_path(file)}: {caveat}")
        if dry_run:
            continue
        body = _levelled(_line(read.body, row, column), level)
        body = body if shortest is None else cut_off(body, shortest)
        found.append(
            views.Characterisation(body, band=fitted, tip_radius=radius, textured=texture is not None, **filters)
        )
    if dry_run:
        if as_json:
            tell(record("characterise", [], kind="files", files=[each.record() for each in readings]))
        return
    if together or repeated:
        (_together if together else _repeated)(files, found, outputs, as_json=as_json)
        return
    told = [(printable(str(file), MAX_PATH_LENGTH), each) for file, each in zip(files, found, strict=True)]
    if as_json:
        tell(views.characterisation_record(told, readings=[each.record() for each in readings]))
    elif len(files) == 1:
        tell(views.characterisation_text(found[0]))
    for path in outputs:
        what = ""
        if len(files) > 1:
            what = f", {len(files)} files"
            new_text(path, views.characterisation_csv(told))
        elif path.suffix.lower() == ".html":
            from stiction.views.report.reading import reading_table
            from stiction.views.report.surface import surface_page

            what = ", the page alone" if len(outputs) == 1 else ""
            same = ["stiction", "characterise", files[0].name]  # without the folders of the file and of the output
            for each in context.command.params:
                if each.name not in ("files", "output", "as_json") and option_was_given(context, each.name):
                    same += [each.opts[0], str(context.params[each.name])]
            table = reading_table(readings[0], reading)
            name = printable(files[0].name)
            surface_page(found[0], name=name, command=shlex.join(same), reading=table).save(path)
        else:
            from stiction.views.figures.roughness import characterisation_figure

            save_picture(characterisation_figure(found[0]), path)
        (say if as_json else tell)(f"wrote {printable_path(path)}{what}")


def _together(files: list[Path], found: list[Characterisation], outputs: list[Path], *, as_json: bool) -> None:
    from stiction.surfaces.joined_spectrum import joined_spectrum
    from stiction.surfaces.measured.spectrum_file import write_spectrum
    from stiction.views.rows import record
    from stiction.views.scans import joined_figure, joined_record, joined_text
    from stiction.views.style import save_picture

    names = [file.name for file in files]
    names = names if len(set(names)) == len(names) else list(map(str, files))
    joined = joined_spectrum([each.body for each in found], tip_radii=[each.tip_radius for each in found], names=names)
    tell(record("characterise", [], kind="joined", **joined_record(joined)) if as_json else joined_text(joined))
    for path in outputs:
        if path.suffix.lower() == ".csv":
            write_spectrum(joined, path)
        else:
            save_picture(joined_figure(joined), path)
        (say if as_json else tell)(f"wrote {printable_path(path)}, {len(files)} scans")


def _repeated(files: list[Path], found: list[Characterisation], outputs: list[Path], *, as_json: bool) -> None:
    from stiction.surfaces.measured.writing import write_profile, write_surface
    from stiction.surfaces.repeated_scans import compare_repeated_scans
    from stiction.views.files import new_text
    from stiction.views.rows import record
    from stiction.views.scans import octaves_csv, repeated_figure, repeated_record, repeated_text
    from stiction.views.style import save_picture

    twice = compare_repeated_scans(found[0].body, found[1].body)
    tell(record("characterise", [], kind="repeated", **repeated_record(twice)) if as_json else repeated_text(twice))
    for path in outputs:
        if path.suffix.lower() == ".npy":
            if isinstance(twice.scan, Profile):
                write_profile(twice.scan, path)
            else:
                write_surface(twice.scan, path)
        elif path.suffix.lower() == ".csv":
            new_text(path, octaves_csv(twice))
        else:
            save_picture(repeated_figure(twice), path)
        (say if as_json else tell)(f"wrote {printable_path(path)}, {' and '.join(file.name for file in files)}")


def _outputs(files: list[Path], output: Path | None, *, together: bool, repeated: bool) -> list[Path]:
    """Return the files to write; raise a `ValueError` if one would replace a file that is not a figure or a report."""
    from stiction.views.report.page import MARK
    from stiction.views.style import MARKS

    paths = _paths(files, output, together=together, repeated=repeated)
    marks = {".html": MARK.encode(), **MARKS}
    for path in paths:
        if (ending := path.suffix.lower()) in marks:
            check_replaceable(path, marks[ending], ValueError)
        elif os.path.lexists(path):
            raise ValueError(f"{printable_path(path)}: exists already; move it, or choose another name with --output")
    return paths


def _paths(files: list[Path], output: Path | None, *, together: bool, repeated: bool) -> list[Path]:
    if repeated and (len(files) != 2 or together):
        raise ValueError(f"--repeated is for two scans of one place, without --together, got {len(files)}")
    if together and len(files) < 2:
        raise ValueError("--together is for several scans of one surface, got 1")
    pictures = [".png", ".pdf", ".svg"]
    endings = [".csv", *pictures] if together else [".csv"] if len(files) > 1 else [".html", *pictures]
    endings = [".npy", ".csv", *pictures] if repeated else endings
    if output is None and repeated:
        return [Path("repeated.npy"), Path("noise.csv"), Path("noise.png")]
    if output is None:
        stem, count = ("joined", 2) if together else ("characterised", 1) if len(files) > 1 else (files[0].stem, 2)
        return [Path(f"{stem}{ending}") for ending in endings[:count]]
    if output.suffix.lower() not in endings:
        allowed = " or ".join([", ".join(endings[:-1]), endings[-1]] if len(endings) > 1 else endings)
        raise ValueError(f"{printable_path(output)}: cannot be written: its name must end in {allowed}")
    several = together or len(files) > 1
    return [output] if several or output.suffix.lower() == ".html" else [output.with_suffix(".html"), output]


def _line(body: Profile | Surface, row: int | None, column: int | None) -> Profile | Surface:
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
    is_line = isinstance(body, Profile)
    level = ("line" if is_line else "plane") if level is None else level
    allowed = "none", *get_args(ProfileForm if is_line else SurfaceForm)
    if level not in allowed:
        raise ValueError(f"--level must be one of {', '.join(map(repr, allowed))}, got {level!r}")
    return levelled(body, level)


def _filters(lc: str | None, ls: str | None, *, robust: bool, joined: bool) -> dict[str, Any]:
    """Parse the cutoffs of roughness parameters."""
    if joined and (lc is not None or ls is not None or robust):
        raise ValueError("--lc, --ls and --robust are not for use with --together or --repeated")
    long = None if lc is None else parse_quantity("lc", lc, "length")
    short = 0.0 if ls == "none" else None if ls is None else parse_quantity("ls", ls, "length")
    return {"lc": long, "ls": short, "robust": robust}


def _band(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    parts = text.split(",")
    if len(parts) != 2:
        raise ValueError(f'--band needs two wavelengths, as in "1 um,100 um", got {text!r}')
    shortest, longest = (parse_quantity("band", part.strip(), "length") for part in parts)
    if not shortest < longest:
        raise ValueError(f"--band must be the shortest and then the longest wavelength, got {text!r}")
    return shortest, longest
