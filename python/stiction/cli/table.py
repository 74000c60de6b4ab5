"""Command `stiction table`: tables of friction, contact area and stiffness for another simulation code."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from stiction._text import printable_path
from stiction._units import short_repr
from stiction.cli.application import command, print_output
from stiction.cli.options import SchedulerOption, WorkersOption, option
from stiction.cli.pair_options import pair_option

NETCDF_FILE_NAME, CSV_FILE_NAME, LAWS_FILE_NAME = "table.nc", "table.csv", "laws.csv"


@command(
    "table",
    "stiction table --effective-modulus '10 GPa' --hurst 0.8 --rms '20 nm,50 nm'",
    "stiction table --young '70 GPa' --poisson 0.2 --load '1 MPa,9 MPa' --mu0 0.4",
)
def table_command(
    *,
    hurst: Annotated[str, option("--hurst NUMBERS", "Hurst exponents of the surfaces.")] = ("0.5,0.7,0.9"),
    rms: Annotated[str, option("--rms LENGTHS", "Root-mean-square heights Sq.")] = ("10 nm,30 nm,100 nm"),
    load: Annotated[
        str, option("--load PRESSURES", "Nominal pressures. The stiffness needs at least 3.")
    ] = "1 MPa,3 MPa,10 MPa,30 MPa,100 MPa",
    mu0: Annotated[str, option("--mu0 NUMBERS", "Molecular friction coefficients.")] = ("0.2,0.4,0.6"),
    tau0: Annotated[str, option("--tau0 PRESSURES", "Adhesive shear strengths.")] = "0 MPa",
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
    effective_modulus: Annotated[str | None, pair_option("effective_modulus")] = None,
    young: Annotated[str | None, pair_option("young")] = None,
    poisson: Annotated[str | None, pair_option("poisson")] = None,
) -> None:
    """Tabulate friction, true contact area and stiffness of self-affine surfaces for another simulation code.

    Pairs of generated surfaces are pressed as elastic half-spaces. The same command resumes an interrupted table.
    Further values of mu0 and tau0 need no new contact computation.
    """
    from stiction._arguments import parse_coefficients, parse_numbers, parse_quantities, parse_quantity, split_values
    from stiction.cli.execution import compute_result_in_folder, open_executor
    from stiction.evaluate.friction_table import friction_table, table_study
    from stiction.solve.store import CHECKSUM_PREFIX, export
    from stiction.study.elasticity import determine_elasticity
    from stiction.views.files import check_all_replaceable, replace_text_file
    from stiction.views.friction_table import fitted_laws_csv, friction_table_csv, friction_table_text

    modulus = determine_elasticity(effective_modulus, young, poisson).effective_modulus
    wavelength_limits = parse_quantities("wavelengths", wavelengths, "length")
    if len(wavelength_limits) != 2:
        raise ValueError(f'--wavelengths must be two lengths, such as "0.3 um,2.5 um", got {short_repr(wavelengths)}')
    shortest, longest = map(float, wavelength_limits)
    friction_parameters: dict[str, Any] = {
        "mu0": parse_coefficients("mu0", mu0),
        "tau0": parse_quantities("tau0", tau0, "pressure"),
    }
    study = table_study(
        hurst_exponents=parse_numbers("hurst", hurst),
        rms=parse_quantities("rms", rms, "length"),
        pressures=[_parse_pressure(value) for value in split_values(load)],
        effective_modulus=modulus,
        extent=float(parse_quantity("extent", extent, "length")),
        points=points,
        longest_wavelength=longest,
        shortest_wavelength=shortest,
        repetitions=repetitions,
        seed=seed,
    )
    signatures = {  # only files of an earlier table, which contain these bytes, may be overwritten
        NETCDF_FILE_NAME: CHECKSUM_PREFIX,
        CSV_FILE_NAME: b"stiffness over area (",
        LAWS_FILE_NAME: b"b of k/A0 = b p^c",
    }
    check_all_replaceable(output, signatures)
    with open_executor(workers, scheduler) as executor:
        result = compute_result_in_folder(study, output, executor)
    table = friction_table(result, **friction_parameters)
    print_output(friction_table_text(table))
    export(table, output / NETCDF_FILE_NAME, replace=True)
    for name, text in ((CSV_FILE_NAME, friction_table_csv(table)), (LAWS_FILE_NAME, fitted_laws_csv(table))):
        replace_text_file(output / name, text, signatures[name])
    for name in (NETCDF_FILE_NAME, CSV_FILE_NAME, LAWS_FILE_NAME):
        print_output(f"wrote {printable_path(output / name)}")


def _parse_pressure(text: str) -> float:
    from stiction._arguments import parse_load

    amount, is_per_area = parse_load("load", text)
    if not is_per_area:
        raise ValueError(f'--load must be a pressure, such as "10 MPa", got {short_repr(text)}')
    return float(amount)
