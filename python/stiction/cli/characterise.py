"""Command `stiction characterise`: roughness of measured profiles and surfaces."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

import typer

from stiction._text import MAX_PATH_LENGTH, printable_path, printable_text
from stiction._units import short_repr
from stiction.cli.application import command, option_was_given, print_message, print_output
from stiction.cli.options import JsonOption, VerboseOption, load_measurement, option
from stiction.cli.pair_options import pair_option, read_given_options

if TYPE_CHECKING:
    from stiction.summary.characterisation import Characterisation
    from stiction.surfaces.profile import Profile
    from stiction.surfaces.surface import Surface


RowOption = Annotated[
    int | None, option("--row N", "Characterise only this row of a surface, counted from 0.", minimum=0)
]
ColumnOption = Annotated[
    int | None, option("--column N", "Characterise only this column of a surface, counted from 0.", minimum=0)
]
LevelOption = Annotated[str | None, option(
    "--level --form FORM",
    "Form to subtract. Profiles: none, mean, line, quadratic, cubic to sextic, or circle. Surfaces: plane instead of "
    "line, and sphere or cylinder instead of circle.", "line, plane",
)]  # fmt: skip
LongCutoffOption = Annotated[
    str | None, option("--lc LENGTH", "Cutoff λc of R-parameters, and of S-parameters if given.", "by setting class")
]
ShortCutoffOption = Annotated[
    str | None, option("--ls LENGTH", "Cutoff λs of R-parameters, and of S-parameters if given; none for no filter.",
                       "by setting class"),
]  # fmt: skip
RobustOption = Annotated[bool, option("--robust", "Use the robust Gaussian regression filter for λc.")]
BandOption = Annotated[
    str | None,
    option("--band SHORTEST,LONGEST", 'Wavelengths for the fit of the Hurst exponent, "1 um,100 um".', "automatic"),
]
CutOffOption = Annotated[
    str | None, option("--cutoff LENGTH", 'Cutoff wavelength of a Gaussian low-pass filter, "0.1 um".', "no filter")
]
TogetherOption = Annotated[bool, option("--together", "Join several scans of an isotropic surface into one spectrum.")]
RepeatedOption = Annotated[
    bool, option("--repeated", "Compare two scans of the same place: common heights, and noise.")
]
DryRunOption = Annotated[bool, option("--dry-run", "Only show how each file is read.")]
OutputOption = Annotated[
    Path | None,
    option(
        "--output -o FILE",
        "File to write. For one scan .html writes a report, .png a figure and a report; for several scans .csv.",
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
    unit: Annotated[str | None, pair_option("unit", repeatable=False)] = None,
    spacing: Annotated[str | None, pair_option("spacing", repeatable=False)] = None,
    missing: Annotated[str | None, pair_option("missing")] = None,
    missing_value: Annotated[str | None, pair_option("missing_value", repeatable=False)] = None,
    outliers: Annotated[str | None, pair_option("outliers")] = None,
    crop: Annotated[str | None, pair_option("crop", repeatable=False)] = None,
    channel: Annotated[str | None, pair_option("channel", repeatable=False)] = None,
    columns: Annotated[str | None, pair_option("columns", repeatable=False)] = None,
    accept: Annotated[str | None, pair_option("accept", repeatable=False)] = None,
    texture: Annotated[str | None, pair_option("texture", repeatable=False)] = None,
    tip: Annotated[str | None, pair_option("tip", repeatable=False)] = None,
    row: RowOption = None,
    column: ColumnOption = None,
    level: LevelOption = None,
    lc: LongCutoffOption = None,
    ls: ShortCutoffOption = None,
    robust: RobustOption = False,
    band: BandOption = None,
    cutoff: CutOffOption = None,
    together: TogetherOption = False,
    repeated: RepeatedOption = False,
    dry_run: DryRunOption = False,
    output: OutputOption = None,
    verbose: VerboseOption = False,
    as_json: JsonOption = False,
) -> None:
    """Compute roughness parameters, spectrum and Hurst exponent of measured profiles or surfaces.

    For one file, print the main parameters (all of them with --verbose), and write an HTML report and a figure. For
    several files, write one CSV file with a row for each. With --json, write only the file of --output.
    """
    from stiction._arguments import parse_quantity
    from stiction.cli.result_output import choose_message_printer
    from stiction.study.measured_bodies import MACHINING_PROCESSES
    from stiction.study.pair_options import READING_OPTION_NAMES
    from stiction.summary.characterisation import Characterisation
    from stiction.surfaces.cut_off import cut_off
    from stiction.views import characterisation as views
    from stiction.views.files import write_new_text_file
    from stiction.views.json_record import record_json
    from stiction.views.report.reading import file_reading_table
    from stiction.views.style import save_figure

    reading_options = {
        name: str(text) for name, text in read_given_options(context).items() if name in READING_OPTION_NAMES
    }
    output_paths = (
        []
        if dry_run or (as_json and output is None)
        else _choose_output_paths(files, output, together=together, repeated=repeated)
    )
    _reject_unused_options(context, together=together, repeated=repeated)
    hurst_band = _parse_band(band)
    cutoff_wavelength = None if cutoff is None else parse_quantity("cutoff", cutoff, "length")
    filters = _parse_filters(lc, ls, robust=robust)
    if texture is not None and texture not in MACHINING_PROCESSES:
        raise ValueError(f"--texture must be one of {', '.join(MACHINING_PROCESSES)}, got {short_repr(texture)}")
    tip_radius = None if tip is None else parse_quantity("tip", tip, "length")
    characterisations, readings = [], []
    for file in files:
        scan = load_measurement(file, reading_options)
        readings.append(scan)
        if not as_json:
            print_output(f"{printable_text(file.name)}: {scan}")
            for caveat in scan.caveats:
                print_message(f"{printable_path(file)}: {caveat}")
        if dry_run:
            continue
        body = _level_body(_select_row_or_column(scan.body, row, column), level)
        body = body if cutoff_wavelength is None else cut_off(body, cutoff_wavelength)
        characterisations.append(
            Characterisation(body, band=hurst_band, tip_radius=tip_radius, textured=texture is not None, **filters)
        )
    if dry_run:
        if as_json:
            print_output(
                record_json("characterise", [], kind="files", files=[scan.to_json_fields() for scan in readings])
            )
        return
    if together or repeated:
        (_print_joined_spectrum if together else _print_scan_comparison)(
            files, characterisations, output_paths, as_json=as_json
        )
        return
    characterised_files = [
        (printable_text(str(file), MAX_PATH_LENGTH), result)
        for file, result in zip(files, characterisations, strict=True)
    ]
    if as_json:
        print_output(
            views.characterisation_json(characterised_files, readings=[scan.to_json_fields() for scan in readings])
        )
    elif len(files) == 1:
        print_output(views.characterisation_text(characterisations[0], headline_only=not verbose))
    for path in output_paths:
        remark = ""
        if len(files) > 1:
            remark = f", {len(files)} files"
            write_new_text_file(path, views.characterisation_csv(characterised_files))
        elif path.suffix.lower() == ".html":
            from stiction.views.report.surface import surface_page

            remark = ", without a figure" if len(output_paths) == 1 else ""
            arguments = ["stiction", "characterise", files[0].name]
            for parameter in context.command.params:
                if parameter.name not in ("files", "output", "verbose", "as_json") and option_was_given(
                    context, parameter.name
                ):
                    arguments += [parameter.opts[0], str(context.params[parameter.name])]
            reading_table_html = file_reading_table(readings[0], reading_options)
            name = printable_text(files[0].name)
            surface_page(
                characterisations[0], name=name, command=shlex.join(arguments), reading=reading_table_html
            ).save(path)
        else:
            from stiction.views.figures.roughness import characterisation_figure

            save_figure(characterisation_figure(characterisations[0]), path)
        choose_message_printer(as_json)(f"wrote {printable_path(path)}{remark}")


def _print_joined_spectrum(
    files: list[Path], scans: list[Characterisation], outputs: list[Path], *, as_json: bool
) -> None:
    """Print the power spectrum joined from several scans, and write the output files of the command."""
    from stiction.cli.result_output import choose_message_printer
    from stiction.surfaces.joined_spectrum import joined_spectrum
    from stiction.surfaces.measured.spectrum_file import write_spectrum
    from stiction.views.characterisation import find_outlier_caveats
    from stiction.views.json_record import record_json
    from stiction.views.scans import joined_spectrum_figure, joined_spectrum_record, joined_spectrum_text
    from stiction.views.style import save_figure

    names = _choose_scan_names(files)
    joined_scans = joined_spectrum(
        [scan.body_without_outliers for scan in scans], tip_radii=[scan.tip_radius for scan in scans], names=names
    )
    caveats = find_outlier_caveats(scans, names, consequence="excluded from the spectrum", option="--outliers mask")
    print_output(
        record_json("characterise", [], kind="joined", **joined_spectrum_record(joined_scans, caveats))
        if as_json
        else joined_spectrum_text(joined_scans, caveats)
    )
    for path in outputs:
        if path.suffix.lower() == ".csv":
            write_spectrum(joined_scans, path)
        else:
            save_figure(joined_spectrum_figure(joined_scans), path)
        choose_message_printer(as_json)(f"wrote {printable_path(path)}, {len(files)} scans")


def _choose_scan_names(files: list[Path]) -> list[str]:
    """Return a name for each scan: its file name, or its path if any two scans have the same file name."""
    names = [file.name for file in files]
    return names if len(set(names)) == len(names) else list(map(str, files))


def _print_scan_comparison(
    files: list[Path], scans: list[Characterisation], outputs: list[Path], *, as_json: bool
) -> None:
    """Print the comparison of two scans of the same place, and write the output files that the user requests."""
    from stiction.cli.result_output import choose_message_printer
    from stiction.surfaces.measured.writing import write_profile, write_surface
    from stiction.surfaces.profile import Profile
    from stiction.surfaces.repeated_scans import compare_repeated_scans
    from stiction.views.characterisation import find_outlier_caveats
    from stiction.views.files import write_new_text_file
    from stiction.views.json_record import record_json
    from stiction.views.scans import octave_noise_csv, repeated_scans_figure, repeated_scans_record, repeated_scans_text
    from stiction.views.style import save_figure

    comparison = compare_repeated_scans(
        scans[0].body, scans[1].body, outliers=[scan.excluded_outliers for scan in scans]
    )
    caveats = find_outlier_caveats(
        scans, _choose_scan_names(files), consequence="excluded from the noise, but not from the mean scan",
        option="--outliers mask --missing interpolate",
    )  # fmt: skip
    print_output(
        record_json("characterise", [], kind="repeated", **repeated_scans_record(comparison, caveats))
        if as_json
        else repeated_scans_text(comparison, caveats)
    )
    for path in outputs:
        if path.suffix.lower() == ".npy":
            if isinstance(comparison.scan, Profile):
                write_profile(comparison.scan, path)
            else:
                write_surface(comparison.scan, path)
        elif path.suffix.lower() == ".csv":
            write_new_text_file(path, octave_noise_csv(comparison))
        else:
            save_figure(repeated_scans_figure(comparison), path)
        choose_message_printer(as_json)(f"wrote {printable_path(path)}, {' and '.join(file.name for file in files)}")


def _choose_output_paths(files: list[Path], output: Path | None, *, together: bool, repeated: bool) -> list[Path]:
    """Return the paths of the output files of `characterise`.

    Only figures and reports may replace existing files.
    """
    from stiction._files import check_replaceable
    from stiction.views.files import REPORT_FILE_SIGNATURE
    from stiction.views.style import FIGURE_FILE_SIGNATURES

    paths = _list_output_paths(files, output, together=together, repeated=repeated)
    file_marks = {".html": REPORT_FILE_SIGNATURE.encode(), **FIGURE_FILE_SIGNATURES}
    for path in paths:
        if (file_extension := path.suffix.lower()) in file_marks:
            check_replaceable(path, file_marks[file_extension], ValueError)
        elif os.path.lexists(path):
            raise ValueError(f"{printable_path(path)}: already exists; move it, or choose another name with --output")
    return paths


def _list_output_paths(files: list[Path], output: Path | None, *, together: bool, repeated: bool) -> list[Path]:
    if repeated and together:
        raise ValueError("--repeated must not be combined with --together")
    if repeated and len(files) != 2:
        raise ValueError(f"--repeated requires two scans of the same place, got {len(files)}")
    if together and len(files) < 2:
        raise ValueError("--together requires at least 2 scans of one surface, got 1")
    image_extensions = [".png", ".pdf", ".svg"]
    file_extensions = (
        [".csv", *image_extensions] if together else [".csv"] if len(files) > 1 else [".html", *image_extensions]
    )
    file_extensions = [".npy", ".csv", *image_extensions] if repeated else file_extensions
    if output is None and repeated:
        return [Path("repeated.npy"), Path("noise.csv"), Path("noise.png")]
    if output is None:
        stem, count = ("joined", 2) if together else ("characterised", 1) if len(files) > 1 else (files[0].stem, 2)
        return [Path(f"{stem}{file_extension}") for file_extension in file_extensions[:count]]
    if output.suffix.lower() not in file_extensions:
        allowed_extensions = " or ".join(
            [", ".join(file_extensions[:-1]), file_extensions[-1]] if len(file_extensions) > 1 else file_extensions
        )
        raise ValueError(f"--output must end in {allowed_extensions}, got {printable_path(output)}")
    has_several_files = together or len(files) > 1
    return [output] if has_several_files or output.suffix.lower() == ".html" else [output.with_suffix(".html"), output]


def _select_row_or_column(body: Profile | Surface, row: int | None, column: int | None) -> Profile | Surface:
    """Return the chosen row or column of a surface as a profile, or `body` unchanged if none is chosen."""
    from stiction.surfaces.profile import Profile

    for name, index, other_index in (("row", row, column), ("column", column, row)):
        if index is None:
            continue
        if isinstance(body, Profile) or other_index is not None:
            raise ValueError(
                f"--{name} "
                + ("applies only to surfaces" if other_index is None else "cannot be combined with --column")
            )
        count = body.heights.shape[name == "column"]
        if index >= count:
            raise ValueError(f"--{name} must be at most {count - 1}, got {index}")
        return body.row(index) if name == "row" else body.column(index)
    return body


def _level_body(body: Profile | Surface, level: Any) -> Profile | Surface:
    """Subtract a trend or a form, such as a line or a plane, from the heights of a body.

    By default, the form is a line for a profile, and a plane for a surface.
    """
    from stiction.surfaces.preparation import ProfileForm, SurfaceForm, levelled
    from stiction.surfaces.profile import Profile

    if level == "none":
        return body
    is_profile = isinstance(body, Profile)
    level = ("line" if is_profile else "plane") if level is None else level
    allowed_forms = "none", *get_args(ProfileForm if is_profile else SurfaceForm)
    if level not in allowed_forms:
        raise ValueError(f"--level must be one of {', '.join(map(repr, allowed_forms))}, got {short_repr(level)}")
    return levelled(body, level)


def _reject_unused_options(context: typer.Context, *, together: bool, repeated: bool) -> None:
    """Raise a `ValueError` if the user gave an option that has no effect on joined spectra or on repeated scans."""
    names = ["lc", "ls", "robust", "band", "texture", *(["tip"] if repeated else [])]
    given_names = [name for name in names if option_was_given(context, name)]
    if given_names and (together or repeated):
        raise ValueError(f"--{given_names[0]} must not be combined with {'--together' if together else '--repeated'}")


def _parse_filters(lc: str | None, ls: str | None, *, robust: bool) -> dict[str, Any]:
    """Parse the options `--lc`, `--ls` and `--robust`, which set the filters for roughness parameters."""
    from stiction._arguments import parse_quantity

    long_cutoff = None if lc is None else parse_quantity("lc", lc, "length")
    short_cutoff = 0.0 if ls == "none" else None if ls is None else parse_quantity("ls", ls, "length")
    return {"lc": long_cutoff, "ls": short_cutoff, "robust": robust}


def _parse_band(text: str | None) -> tuple[float, float] | None:
    """Parse the limits (µm) of the wavelength band for the Hurst exponent, with the shortest wavelength first."""
    from stiction._arguments import parse_quantity

    if text is None:
        return None
    limit_texts = text.split(",")
    if len(limit_texts) != 2:
        raise ValueError(f'--band must be two wavelengths, such as "1 um,100 um", got {short_repr(text)}')
    shortest_wavelength, longest_wavelength = (
        parse_quantity("band", limit_text.strip(), "length") for limit_text in limit_texts
    )
    if not shortest_wavelength < longest_wavelength:
        raise ValueError(f"--band must start with the shorter wavelength, got {short_repr(text)}")
    return shortest_wavelength, longest_wavelength
