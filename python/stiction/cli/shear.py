"""Command `stiction shear`: direct shear test of two faces that fit."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction._text import printable_path, printable_text
from stiction.cli.application import command, print_output, report_interruption, show_status
from stiction.cli.options import JsonOption, load_measurement, option
from stiction.cli.pair_options import pair_argument, pair_option, read_given_options

if TYPE_CHECKING:
    from stiction.surfaces.profile import Profile
    from stiction.surfaces.surface import Surface

CSV_FILE_NAME, FIGURE_FILE_NAME, REPORT_FILE_NAME = "shear.csv", "shear.png", "report.html"

_output_option = functools.partial(option, panel="Output")


@command(
    "shear",
    "stiction shear upper.csv lower.csv --path '2 mm' --load '1 MPa' \\",
    "    --mu0 0.6 --young '30 GPa' --poisson 0.25 --hardness '150 MPa'",
    "stiction shear upper.npy lower.npy --unit um --spacing '0.5 mm' \\",
    "    --path '5 mm' --load '1 MPa' --normal-stiffness '5 MPa/mm' \\",
    "    --direction 180 --mu0 0.5..0.7 --young '30 GPa' --poisson 0.25",
)
def shear(
    context: typer.Context,
    upper: Annotated[str, pair_argument("upper")],
    lower: Annotated[str, pair_argument("lower")],
    *,
    path: Annotated[str, option("--path LENGTH", 'Displacement of UPPER at the end, "2 mm".', False)],
    load: Annotated[str, option(
        "--load PRESSURE", 'Normal stress on the overlap at the start, "1 MPa", or a force.', False,
    )],
    mu0: Annotated[str | None, option(
        "--mu0 NUMBER", 'Molecular friction coefficient, "0.6", or "0.5..0.7".', False,
    )] = None,
    tau0: Annotated[str | None, option(
        "--tau0 PRESSURE", 'Adhesive shear strength, "0 MPa", or "0..1 MPa".', "0 MPa",
    )] = None,
    interface: Annotated[str | None, pair_option("interface")] = None,
    steps: Annotated[int, option("--steps N", "Number of displacements, at most one per grid point.", minimum=1)] = 40,
    direction: Annotated[
        float, option("--direction DEGREES", "Direction of the motion of UPPER, from +x towards +y.")
    ] = 0.0,
    normal_stiffness: Annotated[str | None, option(
        "--normal-stiffness STIFFNESS", 'Increase of the normal stress per dilation, "5 MPa/mm".', "constant load",
    )] = None,
    upper_material: Annotated[str | None, pair_option("upper_material")] = None,
    lower_material: Annotated[str | None, pair_option("lower_material")] = None,
    young: Annotated[str | None, pair_option("young")] = None,
    poisson: Annotated[str | None, pair_option("poisson")] = None,
    effective_modulus: Annotated[str | None, pair_option("effective_modulus")] = None,
    hardness: Annotated[str | None, option(
        "--hardness PRESSURE",
        'Largest contact pressure, the strength of the asperities, "150 MPa" or "120 HV ± 10 %".',
        "the material's hardness, or none",
    )] = None,
    tilt: Annotated[str, option(
        "--tilt fixed|free", "Orientation of UPPER: fixed, or tilted until the load is centred.",
    )] = "fixed",
    level: Annotated[str | None, option(
        "--level FORM", "Trend to subtract from each face: none, mean, plane (maps) or line (profiles).",
        "plane or line",
    )] = None,
    register: Annotated[
        bool, option("--register", "Start where the faces fit best: shift, rotate and tilt UPPER.")
    ] = False,
    strips: Annotated[int | None, option(
        "--strips N", "Number of strips along the motion that are sheared one by one for the intervals; 0 for none.",
        "4 to 8 of large maps",
    )] = None,
    unit: Annotated[list[str] | None, pair_option("unit")] = None,
    spacing: Annotated[list[str] | None, pair_option("spacing")] = None,
    missing: Annotated[str | None, pair_option("missing")] = None,
    missing_value: Annotated[list[str] | None, pair_option("missing_value")] = None,
    outliers: Annotated[str | None, pair_option("outliers")] = None,
    crop: Annotated[list[str] | None, pair_option("crop")] = None,
    channel: Annotated[list[str] | None, pair_option("channel")] = None,
    columns: Annotated[list[str] | None, pair_option("columns")] = None,
    accept: Annotated[list[str] | None, pair_option("accept")] = None,
    output: Annotated[Path, _output_option("--output -o DIR", "Directory for the results.")] = Path("shear"),
    replace: Annotated[bool, _output_option("--replace", "Overwrite another shear test.")] = False,
    verbose: Annotated[bool, _output_option("--verbose -v", "Show all displacements.")] = False,
    as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Compute a direct shear test of two faces that fit, such as a rock joint.

    Heights increase outward from the material in both files. UPPER is flipped as by pair, and starts at the same corner
    as LOWER. It moves along one direction at constant load, or with --normal-stiffness at constant stiffness. The same
    command resumes an interrupted test.
    """
    from stiction.cli.execution import check_output_directory
    from stiction.cli.result_output import choose_message_printer
    from stiction.direct_shear import shear_test
    from stiction.solve.store import SHEAR_TEST_FILE_NAME
    from stiction.study.pair_options import READING_OPTION_NAMES
    from stiction.views.figures.shear import shear_figure
    from stiction.views.files import REPORT_FILE_SIGNATURE, check_all_replaceable, replace_text_file
    from stiction.views.json_record import record_json
    from stiction.views.report.shear import shear_page
    from stiction.views.shear import CSV_SIGNATURE, describe_inputs, list_caveats, shear_csv, shear_text, shear_values
    from stiction.views.style import FIGURE_FILE_SIGNATURES, save_figure

    check_output_directory(output)
    signatures = {
        CSV_FILE_NAME: CSV_SIGNATURE, FIGURE_FILE_NAME: FIGURE_FILE_SIGNATURES[".png"],
        REPORT_FILE_NAME: REPORT_FILE_SIGNATURE.encode(),
    }  # fmt: skip
    check_all_replaceable(output, signatures)
    reading_options = {
        name: value for name, value in read_given_options(context).items() if name in READING_OPTION_NAMES
    }
    faces = [_load_face(Path(file), index, reading_options) for index, file in enumerate((upper, lower))]
    tilt_choice: Any = tilt
    level_choice: Any = level
    try:
        test = shear_test(
            *faces, path=path, load=load, mu0=mu0, tau0=tau0, interface=interface, steps=steps, direction=direction,
            normal_stiffness=normal_stiffness, upper_material=upper_material, lower_material=lower_material,
            young=young, poisson=poisson, effective_modulus=effective_modulus, hardness=hardness, tilt=tilt_choice,
            level=level_choice, register=register, strips=strips, directory=output, replace=replace,
            progress=lambda done, total: show_status(f"{done} of {total} steps"),
        )  # fmt: skip
    except KeyboardInterrupt:
        raise report_interruption("; run the same command again to resume from the stored steps") from None
    if as_json:
        inputs, caveats = describe_inputs(test), list_caveats(test)
        print_output(record_json("shear", shear_values(test), kind="shear", inputs=inputs, caveats=caveats))
    else:
        print_output(shear_text(test, verbose=verbose))
    replace_text_file(output / CSV_FILE_NAME, shear_csv(test), signatures[CSV_FILE_NAME])
    show_status("drawing")
    save_figure(shear_figure(test), output / FIGURE_FILE_NAME)
    name = f"{printable_text(Path(upper).name)} on {printable_text(Path(lower).name)}"
    shear_page(test, name=name).save(output / REPORT_FILE_NAME)
    names = ", ".join((REPORT_FILE_NAME, CSV_FILE_NAME, FIGURE_FILE_NAME))
    choose_message_printer(as_json)(f"wrote {printable_path(output)}/: {names} and {SHEAR_TEST_FILE_NAME}")


def _load_face(file: Path, index: int, options: dict[str, Any]) -> Profile | Surface:
    """Load the scan of the upper or the lower face of a direct shear test.

    If an option is given twice, the first is for the upper face, the second for the lower.
    """
    from stiction.study.pair_options import select_body_value

    option_texts = {name: str(select_body_value(name, values, index)) for name, values in options.items()}
    return load_measurement(file, option_texts).body
