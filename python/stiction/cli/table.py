"""Command `stiction table`: tables of friction, contact area and stiffness for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from stiction._text import printable_path
from stiction._units import short_repr
from stiction.cli.application import command, print_output
from stiction.cli.options import SchedulerOption, WorkersOption, option
from stiction.cli.pair_options import pair_argument, pair_option

if TYPE_CHECKING:
    from stiction.study.elasticity import PairElasticity

NETCDF_FILE_NAME, CSV_FILE_NAME, FITTED_LAWS_FILE_NAME = "table.nc", "table.csv", "laws.csv"


@command(
    "table",
    "stiction table --effective-modulus '10 GPa' --hurst 0.8 --rms '20 nm,50 nm'",
    "stiction table --upper steel --lower brass --load '1 MPa,9 MPa' --mu0 0.4",
    "stiction table a.csv b.csv --upper steel --lower brass --mu0 0.2 --load 5MPa",
)
def table_command(
    upper: Annotated[str | None, pair_argument("upper")] = None,
    lower: Annotated[str | None, pair_argument("lower")] = None,
    *,
    hurst: Annotated[
        str | None, option("--hurst NUMBERS", "Hurst exponents of generated surfaces.", "0.5,0.7,0.9")
    ] = None,
    rms: Annotated[
        str | None, option("--rms LENGTHS", "Root-mean-square heights Sq of generated surfaces.", "10 nm,30 nm,100 nm")
    ] = None,
    load: Annotated[
        str, option("--load PRESSURES", "Nominal pressures. The stiffness needs at least 3.")
    ] = "1 MPa,3 MPa,10 MPa,30 MPa,100 MPa",
    mu0: Annotated[str | None, option("--mu0 NUMBERS", "Molecular friction coefficients.", "0.2,0.4,0.6")] = None,
    tau0: Annotated[str | None, option("--tau0 PRESSURES", "Adhesive shear strengths.", "0 MPa")] = None,
    interface: Annotated[str | None, pair_option("interface")] = None,
    extent: Annotated[str, option("--extent LENGTH", "Side length and period of the square surfaces.")] = "10 um",
    wavelengths: Annotated[
        str, option("--wavelengths SHORTEST,LONGEST", "Shortest (cutoff) and longest (roll-off) wavelength.")
    ] = "0.3125 um,2.5 um",
    points: Annotated[int, option("--points N", "Grid points along each side.", minimum=16)] = 256,
    repetitions: Annotated[int, option("--repetitions N", "Number of pairs of generated surfaces.", minimum=1)] = 12,
    seed: Annotated[int, option("--seed N", "Seed of the generated surfaces.")] = 2016,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    output: Annotated[Path, option("--output -o DIR", "Directory for the results.")] = Path("table"),
    upper_material: Annotated[str | None, pair_option("upper_material")] = None,
    lower_material: Annotated[str | None, pair_option("lower_material")] = None,
    effective_modulus: Annotated[str | None, pair_option("effective_modulus")] = None,
    young: Annotated[str | None, pair_option("young")] = None,
    poisson: Annotated[str | None, pair_option("poisson")] = None,
    hardness: Annotated[str | None, pair_option("hardness")] = None,
    unit: Annotated[list[str] | None, pair_option("unit")] = None,
    spacing: Annotated[list[str] | None, pair_option("spacing")] = None,
) -> None:
    """Tabulate friction, true contact area and stiffness against pressure for another simulation code.

    With UPPER and LOWER, the table is that of stiction export --joint, for each mu0 and tau0. Without files, pairs of
    generated self-affine surfaces are pressed as half-spaces. The same command resumes an interrupted table. Further
    values of mu0 and tau0 need no new contact computation.
    """
    if upper is not None:
        options = {
            "upper": upper, "lower": lower, "load": _split_at_commas(load), "mu0": mu0, "tau0": tau0,
            "interface": interface, "upper_material": upper_material, "lower_material": lower_material,
            "hardness": hardness, "effective_modulus": effective_modulus, "young": young, "poisson": poisson,
            "unit": unit, "spacing": spacing,
        }  # fmt: skip
        for name, value in (("hurst", hurst), ("rms", rms)):
            if value is not None:
                raise ValueError(f"--{name} applies only to generated surfaces, got --{name} {value}")
        given_options = {name: value for name, value in options.items() if value is not None}
        _tabulate_measured_pair(given_options, output, workers, scheduler)
        return
    from stiction._arguments import parse_coefficients, parse_numbers, parse_quantities, parse_quantity, split_values
    from stiction.cli.execution import compute_result_in_directory, open_executor
    from stiction.evaluate.point import SLIDING_RULE_ORDER
    from stiction.solve.store import CHECKSUM_PREFIX, export
    from stiction.study.elasticity import determine_elasticity
    from stiction.study.interfaces import InterfaceStrength, round_median_strength
    from stiction.summary.friction_table import friction_table, table_study
    from stiction.views.files import check_all_replaceable, replace_text_file
    from stiction.views.friction_table import (
        fitted_laws_csv,
        friction_table_csv,
        friction_table_text,
        table_assessment_text,
    )

    elasticity = determine_elasticity(effective_modulus, young, poisson, upper_material, lower_material)
    wavelength_limits = parse_quantities("wavelengths", wavelengths, "length")
    if len(wavelength_limits) != 2:
        raise ValueError(f'--wavelengths must be two lengths, such as "0.3 um,2.5 um", got {short_repr(wavelengths)}')
    shortest_wavelength, longest_wavelength = map(float, wavelength_limits)
    friction_parameters: dict[str, Any] = {
        "mu0": parse_coefficients("mu0", mu0 or "0.2,0.4,0.6"),
        "tau0": parse_quantities("tau0", tau0 or "0 MPa", "pressure"),
    }
    rules: list[str] = list(SLIDING_RULE_ORDER)
    if interface is not None:
        if mu0 is not None or tau0 is not None:
            raise ValueError("--interface must not be combined with --mu0 or --tau0, which the interface defines")
        strength = InterfaceStrength.named(interface)
        medians = round_median_strength(strength)
        friction_parameters = {name: [value] for name, value in zip(("mu0", "tau0"), medians, strict=True)}
        rules = sorted(rules, key=lambda rule: rule != strength.fits[0].sliding)
    study = table_study(
        hurst_exponents=parse_numbers("hurst", hurst or "0.5,0.7,0.9"),
        rms=parse_quantities("rms", rms or "10 nm,30 nm,100 nm", "length"),
        pressures=[_parse_pressure(value) for value in split_values(load)],
        effective_modulus=elasticity.effective_modulus,
        hardness=_choose_hardness(hardness, elasticity),
        extent=float(parse_quantity("extent", extent, "length")),
        points=points,
        longest_wavelength=longest_wavelength,
        shortest_wavelength=shortest_wavelength,
        repetitions=repetitions,
        seed=seed,
        **friction_parameters,
    )
    if interface is not None:
        study = study.with_changes({"contact.sliding": rules})
    # An existing file is replaced only if its first bytes show that this command wrote the file.
    signatures = {
        NETCDF_FILE_NAME: CHECKSUM_PREFIX,
        CSV_FILE_NAME: b"stiffness over area (",
        FITTED_LAWS_FILE_NAME: b"b of k/A0 = b p^c",
    }
    check_all_replaceable(output, signatures)
    with open_executor(workers, scheduler) as executor:
        result = compute_result_in_directory(study, output, executor)
    table = friction_table(result)
    print_output(friction_table_text(table, rules))
    if assessment_text := table_assessment_text(table, result.summary()):
        print_output(f"{assessment_text}\n")
    export(table, output / NETCDF_FILE_NAME, replace=True)
    for name, text in ((CSV_FILE_NAME, friction_table_csv(table)), (FITTED_LAWS_FILE_NAME, fitted_laws_csv(table))):
        replace_text_file(output / name, text, signatures[name])
    for name in (NETCDF_FILE_NAME, CSV_FILE_NAME, FITTED_LAWS_FILE_NAME):
        print_output(f"wrote {printable_path(output / name)}")


def _split_at_commas(text: str) -> list[str]:
    from stiction._arguments import split_values

    return list(split_values(text))


def _choose_hardness(hardness: str | None, elasticity: PairElasticity) -> str | float | None:
    """Return the given hardness. If it is None, return the hardness of the softer material, or None if unknown."""
    from stiction.mechanics.materials import material, softer_hardness

    if hardness is not None or elasticity.materials is None:
        return hardness
    softer_value = softer_hardness(*map(material, elasticity.materials))
    return None if softer_value is None else float(f"{softer_value:.6g}")


def _tabulate_measured_pair(options: dict[str, Any], output: Path, workers: int | None, scheduler: str | None) -> None:
    """Compute a measured pair, and write its contact law as a table for each combination of mu0 and tau0."""
    from stiction.cli.execution import compute_result_in_directory, open_executor
    from stiction.study.pair_options import validate_option_values
    from stiction.study.pair_study import build_study_from_options
    from stiction.views.files import check_all_replaceable, replace_text_file
    from stiction.views.joint import joint_frame
    from stiction.views.spreadsheet import frame_to_csv

    signature = b"nominal pressure ("
    check_all_replaceable(output, {CSV_FILE_NAME: signature})
    study = build_study_from_options(validate_option_values(options))
    with open_executor(workers, scheduler) as executor:
        result = compute_result_in_directory(study, output, executor, onset=0)
    tables = [
        result.joint_table(mu0=mu0, tau0=tau0)
        for mu0 in map(float, result.study.friction.mu0)
        for tau0 in map(float, result.study.friction.tau0)
    ]
    replace_text_file(output / CSV_FILE_NAME, frame_to_csv(joint_frame(tables)), signature)
    print_output(f"wrote {printable_path(output / CSV_FILE_NAME)}")


def _parse_pressure(text: str) -> float:
    from stiction._arguments import parse_load

    pressure, is_per_area = parse_load("load", text)
    if not is_per_area:
        raise ValueError(f'--load must be a pressure, such as "10 MPa", got {short_repr(text)}')
    return float(pressure)
