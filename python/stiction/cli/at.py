"""`stiction at`: what a study says at one load."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stiction.cli.application import command, tell
from stiction.cli.options import Json, quantity_of


@command(
    "at",
    "stiction at figure6 --load '1 uN' --d 1.3 --mu0 0.4",
    "stiction at figure6 --load '1 uN' --d 1.3 --mu0 0.4 --tau0 '200 MPa' --json",
)
def at(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Where a study was written.")],
    load: Annotated[str, typer.Option("--load", metavar="FORCE", help='Normal load, "0.1 mN".')],
    fractal_dimension: Annotated[
        float, typer.Option("--d", metavar="D", help="Fractal dimension; the nearest that the study has is taken.")
    ],
    mu0: Annotated[float, typer.Option("--mu0", metavar="NUMBER", help="Molecular friction coefficient.")],
    tau0: Annotated[str, typer.Option("--tau0", metavar="PRESSURE", help="Adhesive shear strength.")] = "0 MPa",
    amplitude: Annotated[
        str | None,
        typer.Option(
            "--amplitude", metavar="LENGTH", help="The nearest that the study has is taken.", show_default="its first"
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Coefficient of static friction, true contact area and normal stiffness of a study at one load, with intervals.

    Any mu0 and tau0 will do: they need not be those of the study, and nothing is computed again.
    """
    from stiction.cli.studies import stored
    from stiction.studies import store
    from stiction.views import answers, records

    force, strength = quantity_of("--load", load, "force"), quantity_of("--tau0", tau0, "pressure")
    if not force > 0:
        raise ValueError(f"--load must be above 0, got {load!r}")
    if not mu0 >= 0 or not strength >= 0:
        raise ValueError(f"--mu0 and --tau0 must be at least 0, got {mu0:g} and {tau0!r}")
    found = answers.point(
        store.read(stored(directory)), load=force, fractal_dimension=fractal_dimension, mu0=mu0, tau0=strength,
        amplitude=None if amplitude is None else quantity_of("--amplitude", amplitude, "length"),
    )  # fmt: skip
    if as_json:
        tell(records.point_record(found, load=force, mu0=mu0, tau0=strength))
    else:
        tell(answers.point_text(found, load=force, mu0=mu0, tau0=strength))
