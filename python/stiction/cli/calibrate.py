"""`stiction calibrate`: mu0 and tau0 from friction that was measured on surfaces that were pressed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from stiction._arguments import parse_quantity
from stiction.cli.application import command, say, tell
from stiction.cli.options import Json, option, refuse
from stiction.cli.pair_options import option_of
from stiction.cli.result_output import opened, said_by

_TESTS = 'Tests, a row each: "load (mN)", "force (mN)" or coefficient; uncertainty, pair, run, slid, wait.'
Forces = Annotated[Path | None, typer.Argument(metavar="FORCES.csv", help=_TESTS, show_default=False)]
Pairs = Annotated[list[Path] | None, option("--pair DIR", "What pair wrote of what was tested. Repeatable.", False)]
BallRadius = Annotated[str | None, option("--ball RADIUS", 'Smooth, on a flat, below yield: "5 mm"; pair ball.', False)]
Load = Annotated[str | None, option("--load FORCE", 'Of one test without a file: "10 mN", of a pair "10 MPa".', False)]
Measured = Annotated[str | None, option("--measured NUMBER", 'Its coefficient, "0.25±0.01".', False)]
Mu0 = Annotated[float | None, option("--mu0 NUMBER", "Where it is known.", False)]
Tau0 = Annotated[str | None, option("--tau0 PRESSURE", "Where it is known.", False)]
Sliding = Annotated[str, option("--sliding all|opposing|both", "Which contacts rub.")]
Common = Annotated[float, option("--common NUMBER", "Relative uncertainty that all tests share: gain, load.")]
Outliers = Annotated[bool, option("--outliers", "There may be outliers among the tests.")]
_MATERIALS = ("effective_modulus", "young", "poisson", "upper_material", "lower_material")
Output = Annotated[Path | None, option("--output -o NAME", "Keep it for --interface, with a picture NAME.png.", False)]


@command(
    "calibrate",
    "stiction calibrate forces.csv --pair ground --pair lapped -o steel_brass",
    "stiction calibrate forces.csv --ball '5 mm' --upper PMMA --lower glass",
    "stiction calibrate --pair ground --load '10 MPa' --measured '0.25±0.01'",
)
def calibrate(
    context: typer.Context,
    forces: Forces = None,
    *,
    pair: Pairs = None,
    ball: BallRadius = None,
    load: Load = None,
    measured: Measured = None,
    mu0: Mu0 = None,
    tau0: Tau0 = None,
    sliding: Sliding = "both",
    common: Common = 0.02,
    outliers: Outliers = False,
    effective_modulus: Annotated[str | None, option_of("effective_modulus")] = None,
    young: Annotated[str | None, option_of("young")] = None,
    poisson: Annotated[str | None, option_of("poisson")] = None,
    upper_material: Annotated[str | None, option_of("upper_material")] = None,
    lower_material: Annotated[str | None, option_of("lower_material")] = None,
    output: Output = None,
    as_json: Json = False,
) -> None:
    """Find mu0 and tau0 of an interface from friction tests on surfaces that were pressed, or on a ball.

    What tests know is mu0 + tau0 A/F at the true area A under the load F. Both are told apart where A/F differs among
    tests; elsewhere it says what would tell them apart.
    """
    from stiction.studies.calibration import calibrate as fitted
    from stiction.studies.input_uncertainty import Z_95, parse_input
    from stiction.studies.interfaces import Ball, FrictionTest, write_interface
    from stiction.studies.tests_file import friction_tests
    from stiction.views.calibration import calibration_figure, calibration_record, calibration_text
    from stiction.views.style import save_picture

    bodies: dict[str, Any] = {folder.resolve().name: opened(folder) for folder in pair or ()}
    if len(bodies) < len(pair or ()):
        raise ValueError("--pair must be folders of different names: by these the column pair calls them")
    if ball is not None:
        radius = parse_quantity("ball", ball, "length")
        bodies["ball"] = Ball(
            float(radius), effective_modulus, young=young, poisson=poisson, upper_material=upper_material,
            lower_material=lower_material,
        )  # fmt: skip
    else:
        refuse(context, "is for --ball", *_MATERIALS)
    if not bodies:
        raise ValueError("give what was tested: --pair DIR, or --ball RADIUS")
    if forces is not None:
        refuse(context, "is for one test without a file", "load", "measured")
        tests = friction_tests(forces, bodies)
    elif load is None or measured is None:
        raise ValueError("give FORCES.csv, or --load and --measured of one test")
    elif len(bodies) > 1:
        raise ValueError("--measured is of one test, on one --pair or one --ball")
    else:
        value = parse_input("--measured", measured)
        error = (value.high - value.low) / (2 * Z_95) or None
        tests = (FrictionTest(next(iter(bodies.values())), load, coefficient=value.value, uncertainty=error),)
    interface = fitted(tests, common=common, sliding=sliding, mu0=mu0, tau0=tau0, outliers=outliers)  # type: ignore[arg-type]
    tell(calibration_record(interface) if as_json else calibration_text(interface))
    if ball is not None and (elasticity := bodies["ball"].elasticity).hardness is not None:
        ratio = min(bodies["ball"].area_per_load(test.load) for test in tests if test.result is bodies["ball"])
        if 1 / ratio > YIELDS * elasticity.hardness:
            say(f"under the ball a mean pressure of {1e3 / ratio:.3g} MPa may be beyond yield, where A/F is another")
    if output is not None:
        said, picture = said_by(as_json), Path(f"{output}.png")
        about = {"tests": "one" if forces is None else forces.name, "surfaces": ", ".join(bodies)}
        write_interface(interface, output, about)
        save_picture(calibration_figure(interface), picture)
        said(f"wrote {output}, for stiction pair --interface, and {picture}")


YIELDS = 0.39
"""Mean pressure over hardness at which a ball begins to yield: 1.1 over 2.84 yield strengths (Johnson 1985, ch. 6)."""


InterfaceFolder = Annotated[
    Path | None, typer.Argument(metavar="FOLDER", help="Where your own are.", show_default=False)
]


@command("interfaces", "stiction interfaces", "stiction interfaces .", "stiction interfaces --json")
def interfaces(folder: InterfaceFolder = None, as_json: Json = False) -> None:
    """List strengths of interfaces as --interface of pair takes them: read in a source, or calibrated into a folder.

    Measured ones are of a contact of known area; lumped ones are coefficients of a nominal pressure, which hardly know
    of roughness. Each is a range at its pressures and conditions.
    """
    from stiction.studies.interfaces import interfaces as known
    from stiction.studies.interfaces import read_interfaces
    from stiction.views.calibration import interfaces_text
    from stiction.views.rows import record

    there = known() if folder is None else read_interfaces(folder)
    if not (there or as_json):
        tell(f"{folder}: holds no interfaces; stiction calibrate with --output NAME keeps one")
        return
    found = [{**about, "name": name} for name, about in there.items()]
    tell(record("interfaces", [], interfaces=found) if as_json else interfaces_text(found))
