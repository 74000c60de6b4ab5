"""Commands `stiction calibrate` and `stiction interfaces`: mu0 and tau0 from friction tests or the literature."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction._text import printable_path
from stiction.cli.application import command, print_message, print_output
from stiction.cli.options import JsonOption, option, reject_options
from stiction.cli.pair_options import pair_option

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from stiction.calibration.friction_tests import Ball

_TESTS_HELP = (
    'Friction tests, one per row. Columns: "load (mN)" and, for pairs, "load (MPa)"; "force (mN)" or coefficient; '
    "optional uncertainty, pair, run, slid and wait."
)
TestsFileArgument = Annotated[Path | None, typer.Argument(metavar="FORCES.csv", help=_TESTS_HELP, show_default=False)]
PairsOption = Annotated[
    list[Path] | None, option("--pair DIR", "Result of `pair` for the tested surfaces. Repeatable.", False)
]
BallRadiusOption = Annotated[
    str | None, option("--ball RADIUS", 'Smooth elastic ball on a flat, "5 mm", called ball in the column pair.', False)
]
LoadOption = Annotated[
    str | None, option("--load FORCE", 'Load of a single test, "10 mN", or for a pair "10 MPa".', False)
]
MeasuredCoefficientOption = Annotated[
    str | None, option("--measured NUMBER", 'Measured coefficient of a single test, "0.25±0.01".', False)
]
Mu0Option = Annotated[float | None, option("--mu0 NUMBER", "Known value of mu0; fit only tau0.", False)]
Tau0Option = Annotated[str | None, option("--tau0 PRESSURE", "Known value of tau0; fit only mu0.", False)]
SlidingOption = Annotated[str, option("--sliding all|opposing|both", "Contacts at which friction acts.")]
CommonUncertaintyOption = Annotated[
    float, option("--common NUMBER", "Relative uncertainty common to all tests, such as sensor gain and load.")
]
OutliersOption = Annotated[bool, option("--outliers", "Allow for outliers among the tests.")]
_BALL_OPTIONS = ("effective_modulus", "young", "poisson", "upper_material", "lower_material", "area_loss")
TargetOption = Annotated[
    Path | None,
    option("--target DIR", "Result of `pair` whose friction you want: predict it, and rank further tests.", False),
]
OutputOption = Annotated[
    Path | None,
    option("--output -o NAME", "File for the interface, to use with --interface; also writes NAME.png.", False),
]


@command(
    "calibrate",
    "stiction calibrate forces.csv --pair ground --pair lapped -o steel_brass",
    "stiction calibrate forces.csv --ball '5 mm' --upper PMMA --lower glass",
    "stiction calibrate forces.csv --pair ground --target lapped",
)
def calibrate(
    context: typer.Context,
    forces: TestsFileArgument = None,
    *,
    pair: PairsOption = None,
    ball: BallRadiusOption = None,
    load: LoadOption = None,
    measured: MeasuredCoefficientOption = None,
    mu0: Mu0Option = None,
    tau0: Tau0Option = None,
    sliding: SlidingOption = "both",
    common: CommonUncertaintyOption = 0.02,
    outliers: OutliersOption = False,
    effective_modulus: Annotated[str | None, pair_option("effective_modulus")] = None,
    young: Annotated[str | None, pair_option("young")] = None,
    poisson: Annotated[str | None, pair_option("poisson")] = None,
    upper_material: Annotated[str | None, pair_option("upper_material")] = None,
    lower_material: Annotated[str | None, pair_option("lower_material")] = None,
    area_loss: Annotated[str | None, pair_option("area_loss")] = None,
    target: TargetOption = None,
    output: OutputOption = None,
    as_json: JsonOption = False,
) -> None:
    """Fit mu0 and tau0 of an interface to friction tests on rough surfaces or on a smooth ball.

    A test determines mu0 + tau0 A/F, where A is the true contact area at the load F. Separate values of mu0 and tau0
    need tests with different A/F. If A/F varies too little, the output suggests a further test.
    """
    from stiction._arguments import parse_quantity
    from stiction.calibration.calibration import calibrate as fit_interface
    from stiction.calibration.friction_tests import Ball, FrictionTest
    from stiction.calibration.tests_file import parse_friction_tests
    from stiction.cli.result_output import choose_message_printer, open_result_with_warning
    from stiction.study.input_distributions import Z_95, parse_uncertain_input
    from stiction.study.interfaces import write_interface
    from stiction.views.calibration import (
        calibration_figure,
        calibration_json,
        calibration_text,
        list_lay_notes,
        predict_wanted_pair,
    )
    from stiction.views.style import save_figure

    bodies: dict[str, Any] = {directory.resolve().name: open_result_with_warning(directory) for directory in pair or ()}
    if len(bodies) < len(pair or ()):
        raise ValueError(
            "the directories given with --pair must have different names, because the column 'pair' lists the names"
        )
    if ball is not None:
        ball_radius = parse_quantity("ball", ball, "length")
        bodies["ball"] = Ball(
            float(ball_radius),
            effective_modulus,
            young=young,
            poisson=poisson,
            upper_material=upper_material,
            lower_material=lower_material,
            area_loss=area_loss,
        )
    else:
        reject_options(context, "requires --ball", *_BALL_OPTIONS)
    if not bodies:
        tests_of_target = (
            "" if target is None else f"; if you tested the target, give --pair {printable_path(target)} too"
        )
        raise ValueError(f"--pair DIR or --ball RADIUS must be given to specify the tested surfaces{tests_of_target}")
    if forces is not None:
        reject_options(context, "cannot be combined with FORCES.csv", "load", "measured")
        tests = parse_friction_tests(forces, bodies)
    elif load is None or measured is None:
        raise ValueError("FORCES.csv must be given, or --load and --measured for a single test")
    elif len(bodies) > 1:
        raise ValueError("--measured is for a single test, so it requires exactly one --pair or --ball")
    else:
        value = parse_uncertain_input("--measured", measured)
        standard_error = (value.high - value.low) / (2 * Z_95) or None
        tests = (FrictionTest(next(iter(bodies.values())), load, coefficient=value.value, uncertainty=standard_error),)
    target_result = None
    if target is not None:
        target_result = open_result_with_warning(target)
        if not (target_result.study.is_measured and target_result.study.friction.load):
            raise ValueError(
                f"--target must be the result of a measured pair with a load, got {printable_path(target)}"
            )
    interface = fit_interface(tests, common=common, sliding=sliding, mu0=mu0, tau0=tau0, outliers=outliers)  # type: ignore[arg-type]
    lays = [
        note
        for name, body in bodies.items()
        if not isinstance(body, Ball) and any(test.result is body for test in tests)
        for note in list_lay_notes(name, body)
    ]
    prediction = None
    if target is not None and target_result is not None:
        prediction = predict_wanted_pair(interface, target_result)
        lays += [note for note in list_lay_notes(target.resolve().name, target_result) if note not in lays]
    print_output(
        calibration_json(interface, lays, prediction) if as_json else calibration_text(interface, lays, prediction)
    )
    if ball is not None:
        loads = [float(test.load) for test in tests if test.result is bodies["ball"]]
        pairs = {name: result for name, result in bodies.items() if name != "ball"}
        if target is not None and target_result is not None:
            pairs[target.resolve().name] = target_result
        if caveat := _describe_yielding_ball(bodies["ball"], loads, pairs):
            print_message(caveat)
    if output is not None:
        print_written, figure_path = choose_message_printer(as_json), Path(f"{output}.png")
        description = {"tests": "one" if forces is None else forces.name, "surfaces": ", ".join(bodies)}
        write_interface(interface, output, description)
        save_figure(calibration_figure(interface), figure_path)
        print_written(f"wrote {output}, for stiction pair --interface, and {figure_path}")


def _describe_yielding_ball(ball: Ball, loads: Sequence[float], pairs: Mapping[str, Any]) -> str:
    """Return a caveat if the ball or the flat may yield at one of the loads (mN), or "" if neither can yield.

    The hardness is known only if the materials are given by name. Of the results `pairs`, by name, those of the same
    two materials determine the hardness: the lowest one counts.
    """
    from stiction._number_format import format_with_unit
    from stiction.calibration.friction_tests import find_pair_hardness
    from stiction.mechanics.hardness import BALL_YIELD_PRESSURE_RATIO, ball_yield_pressure

    if ball.elasticity.hardness is None or not loads:
        return ""
    hardness, hardness_text = float(ball.elasticity.hardness), "the hardness"
    if pair_hardnesses := [
        (find_pair_hardness(result), name)
        for name, result in pairs.items()
        if result.study.contact.hardness is not None
        and sorted(result.study.contact.materials or ()) == sorted(ball.elasticity.materials or ("",))
    ]:
        hardness, name = min(pair_hardnesses)
        hardness_text = f"the hardness of {name}, {format_with_unit(hardness, 'GPa')}"
    max_load, yield_limit = max(loads), ball_yield_pressure(hardness)
    max_pressure = 1 / ball.area_per_load(max_load)
    if max_pressure <= yield_limit:
        return ""
    # The mean pressure of a Hertz contact is proportional to F^(1/3).
    yield_load = max_load * (yield_limit / max_pressure) ** 3
    num_tests = sum(load > yield_load for load in loads)
    tests = "the test" if num_tests == 1 else f"the {num_tests} tests"
    return (
        f"the mean pressure under the ball, {format_with_unit(max_pressure, 'GPa')} in the test at "
        f"{format_with_unit(max_load, 'mN')}, may exceed the yield limit, {format_with_unit(yield_limit, 'GPa')} "
        f"({BALL_YIELD_PRESSURE_RATIO:g} times {hardness_text}); A/F is computed for elastic contact; leave out "
        f"{tests} of the ball above {format_with_unit(yield_load, 'mN')}, or test smaller loads or a larger ball"
    )


InterfacePathArgument = Annotated[
    Path | None, typer.Argument(metavar="PATH", help="Calibrated interface, or a directory.", show_default=False)
]


@command("interfaces", "stiction interfaces", "stiction interfaces .", "stiction interfaces --json")
def interfaces(path: InterfacePathArgument = None, as_json: JsonOption = False) -> None:
    """List the interfaces that `pair --interface` accepts: published ones, or calibrated ones at PATH.

    "Measured" values come from contacts of known area. "Lumped" values come from friction at a nominal pressure and do
    not separate the effect of roughness. Each value is a range for the listed pressures and conditions.
    """
    from stiction.study.interfaces import interfaces as builtin_interfaces
    from stiction.study.interfaces import read_interface_entries
    from stiction.views.calibration import interfaces_text
    from stiction.views.json_record import record_json

    values_by_name = builtin_interfaces() if path is None else read_interface_entries(path)
    if not (values_by_name or as_json):
        print_output(f"{path} contains no interfaces; stiction calibrate with --output NAME writes one")
        return
    interface_records = [{**values, "name": name} for name, values in values_by_name.items()]
    print_output(
        record_json("interfaces", [], interfaces=interface_records) if as_json else interfaces_text(interface_records)
    )
