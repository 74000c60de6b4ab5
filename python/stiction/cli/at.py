"""Command `stiction at`: a result at other loads, mu0 or tau0, or for surfaces with scaled heights."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction._errors import ArgumentError
from stiction._text import printable_path, printable_text
from stiction.cli.application import command, print_output, report_interruption, show_status
from stiction.cli.loads import LoadsOption, parse_loads, report_missing_loads
from stiction.cli.options import JsonOption, Mu0Option, Tau0Option, VerboseOption, WorkersOption, option, reject_options

if TYPE_CHECKING:
    import xarray

    from stiction.solve.store import StoredResult
    from stiction.study.study import Study
    from stiction.summary.summary import PointSummary


WidthOption = Annotated[
    str | None, option("--width LENGTH", "Contact width of two profiles, for loads in newtons.", "1 um")
]
FractalDimensionOption = Annotated[
    str | None,
    option("--d NUMBERS", 'Fractal dimensions of generated surfaces; the nearest are used, "1.1,1.3".', "all"),
]
HurstOption = Annotated[
    str | None, option("--hurst NUMBERS", "Hurst exponents of self-affine surfaces; the nearest are used.", "all")
]
AmplitudeOption = Annotated[
    str | None, option("--amplitude LENGTH", "Amplitude of generated surfaces; the nearest is used.", "the first")
]
DirectionOption = Annotated[
    float | None, option("--direction DEGREES", "Sliding direction of the upper body.", "mean over all directions")
]

_scaled_height_option = partial(option, panel="Scaled heights")
ScaleHeightsOption = Annotated[
    str | None,
    _scaled_height_option("--scale-heights FACTORS", 'Multiply heights by factors, "0.5,1,2" or "0.25..4".', False),
]
ScaledSurfacesOption = Annotated[
    str, _scaled_height_option("--scaled both|upper|lower", "Surfaces whose heights are scaled.")
]
ComputeOption = Annotated[
    bool, _scaled_height_option("--compute", "Compute missing factors, and store them in DIR.", False)
]


@command(
    "at",
    "stiction at figure6 --load '1 uN' --d 1.1 --mu0 0.4 --tau0 '0 MPa'",
    "stiction at figure6 --load '1 uN' --d 1.1 --mu0 0.4 --tau0 '200 MPa' --json",
    "stiction at pair                            # at the loads of the pair",
    "stiction at pair --load '10 MPa' --mu0 0.2,0.3",
    "stiction at pair --scale-heights 0.25..4 --compute",
)
def at(
    context: typer.Context,
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Directory of a result of `pair` or `run`.")],
    load: LoadsOption = None,
    width: WidthOption = None,
    d: FractalDimensionOption = None,
    hurst: HurstOption = None,
    amplitude: AmplitudeOption = None,
    mu0: Mu0Option = None,
    tau0: Tau0Option = None,
    direction: DirectionOption = None,
    scale_heights: ScaleHeightsOption = None,
    scaled: ScaledSurfacesOption = "both",
    compute: ComputeOption = False,
    workers: WorkersOption = None,
    verbose: VerboseOption = False,
    as_json: JsonOption = False,
) -> None:
    """Print the static friction, true contact area and stiffness of a result at given loads, with intervals.

    Loads, mu0 and tau0 default to the values of the study. Other values need no new contact computation, but loads must
    be between the smallest and the largest computed load. Intervals include the range of mu0 or tau0 in the study only
    at its central value, next to which the range is printed; any other value is exact. A warning names loads outside
    the computed range; if no load has values, the exit status is 2. If there are more points than fit on a screen, a
    selection is printed; --verbose and --json contain all points. Each factor of --scale-heights is computed once and
    stored with the result.
    """
    from stiction._arguments import (
        parse_coefficients,
        parse_numbers,
        parse_quantities,
        parse_quantity,
        validate_nonnegative_values,
    )
    from stiction.cli.result_output import VERBOSE_OPTION, open_result_with_warning
    from stiction.evaluate.computed_loads import find_loads_without_values, find_neighbouring_loads
    from stiction.views import rows
    from stiction.views.text import (
        default_friction_parameters_text,
        interpolation_records,
        interpolation_text,
        result_text,
    )

    result = open_result_with_warning(directory)
    for name, text in (("mu0", mu0), ("tau0", tau0)):
        _reject_range(name, text, directory, result.study)
    mu0_values = None if mu0 is None else parse_coefficients("mu0", mu0)
    tau0_values = None
    if tau0 is not None:
        tau0_values = validate_nonnegative_values("tau0", parse_quantities("tau0", tau0, "pressure"), tau0)
    if scale_heights is None:
        reject_options(context, "requires --scale-heights", "scaled", "compute", "workers")
    else:
        reject_options(context, "cannot be combined with --scale-heights", "d", "hurst", "amplitude", "direction")
        loads = parse_loads(result, load, width)
        assert result.stored is not None, "the result was opened from a directory"
        _print_height_factor_results(
            result.stored, scale_heights, scaled, loads, mu0_values, tau0_values, compute=compute, workers=workers,
            as_json=as_json,
        )  # fmt: skip
        return
    amplitude_length = None if amplitude is None else parse_quantity("amplitude", amplitude, "length")
    points = result.at(parse_loads(result, load, width), mu0=mu0_values, tau0=tau0_values, budget=True)
    dimensions = None if d is None else parse_numbers("d", d)
    if hurst is not None:
        if d is not None or getattr(result.study.surfaces, "generator", "") != "self-affine":
            raise ArgumentError(
                "{hurst} must be omitted if the surfaces are not self-affine or --d is given, got {hurst} {got}",
                got=repr(hurst),
            )
        dimensions = [2 - exponent for exponent in parse_numbers("hurst", hurst)]
    amplitudes = None if amplitude_length is None else [amplitude_length]
    points = _select_cells_with_nearest_parameters(points, dimensions, amplitudes)
    if direction is not None:
        points = _select_direction(points, direction)
    missing_loads = find_loads_without_values(result, points)
    report_missing_loads(result, points, missing_loads)
    neighbours = find_neighbouring_loads(result.study, points["load"].values)
    node_points: Sequence[PointSummary] = ()
    if neighbours:
        node_loads = sorted({load for loads in neighbours.values() for load in loads})
        points_at_nodes = result.at(node_loads, mu0=mu0_values, tau0=tau0_values, load_definition="elastic")
        node_points = result.summarize_dataset(
            _select_cells_with_nearest_parameters(points_at_nodes, dimensions, amplitudes)
        ).points
    if as_json:
        fields = {"interpolated": interpolation_records(neighbours, node_points)} if neighbours else {}
        print_output(rows.summary_json("at", result.summarize_dataset(points), **fields))
    else:
        summary = result.summarize_dataset(points.drop_sel(load=missing_loads))
        if default_text := default_friction_parameters_text(result.study, mu0=mu0 is None, tau0=tau0 is None):
            print_output(default_text)
        print_output(result_text(summary, verbose=verbose, complete_command=VERBOSE_OPTION))
        if neighbours:
            print_output(interpolation_text(neighbours, node_points, result.nominal_area))


def _reject_range(name: str, text: str | None, directory: Path, study: Study) -> None:
    """Raise an `ArgumentError` if the text for mu0 or tau0 contains a range or a number with an uncertainty.

    For measured bodies, the message contains the command that accepts the first such range. If a friction law defines
    mu0 and tau0 of the study, it recommends another law instead, because the command would replace the law.
    """
    from stiction._arguments import reject_decimal_commas, split_values

    if text is None:
        return
    reject_decimal_commas(name, text)
    range_texts = [item for item in split_values(text) if _is_range(name, item)]
    if not range_texts:
        return
    message = f"{{{name}}} must be one or more numbers without ranges, got {{got}}"
    if (law := study.friction.interface) is not None:
        message += (
            "; mu0 and tau0 of this pair come from the friction law {law}: for another range, run stiction pair with "
            "another law file (--interface)"
        )
    elif study.is_measured:
        message += f"; for another range, run stiction run {{directory}} --set 'friction.{name}=\"{{text}}\"'"
    fields = {
        "directory": shlex.quote(printable_path(directory)), "law": printable_path("" if law is None else law.file)
    }  # fmt: skip
    raise ArgumentError(message, got=repr(text), text=printable_text(range_texts[0]), **fields)


def _is_range(name: str, text: str) -> bool:
    """Return whether the text for mu0 or tau0 is valid, and is a range or has an uncertainty."""
    from stiction.study.input_distributions import parse_study_input

    try:
        return not parse_study_input(name, text).is_exact
    except ValueError:
        return False


def _print_height_factor_results(
    stored_result: StoredResult, text: str, scaled: str, loads: list[float], mu0: Any, tau0: Any, *, compute: bool,
    workers: int | None, as_json: bool,
) -> None:  # fmt: skip
    """Print the friction of a stored pair for scaled heights, one result per height factor.

    If `compute` is true, missing results are computed first.
    """
    from stiction._threads import thread_pool_executor
    from stiction.companions.height_scale import (
        compute_results_at_height_factors,
        evaluate_at_height_factors,
        parse_height_factors,
    )
    from stiction.evaluate.computed_loads import find_loads_outside_range
    from stiction.result import Result
    from stiction.views.height_scale import height_scale_json, height_scale_text

    scaled_bodies: Any = scaled
    height_factors = parse_height_factors(text)
    if compute:
        try:
            with thread_pool_executor(workers) as executor:
                compute_results_at_height_factors(
                    stored_result, height_factors, scaled_bodies, executor, progress=True, announce=show_status
                )
        except KeyboardInterrupt:
            raise report_interruption(
                "; results for the height factors computed so far are stored; run the same command again to resume"
            ) from None
    points = evaluate_at_height_factors(stored_result, height_factors, loads, mu0=mu0, tau0=tau0, scaled=scaled_bodies)
    result = Result(stored_result)
    missing_loads = find_loads_outside_range(result, points)
    report_missing_loads(result, points, missing_loads)
    if as_json:
        print_output(height_scale_json(points, stored_result.study))
    else:
        print_output(height_scale_text(points.drop_sel(load=missing_loads), stored_result.study))


def _select_cells_with_nearest_parameters(
    dataset: xarray.Dataset, dimensions: list[float] | None, amplitudes: Sequence[float] | None
) -> xarray.Dataset:
    """Select the surfaces whose fractal dimensions and amplitudes (µm) are nearest to the requested numbers.

    By default, all dimensions and the first amplitude are selected.
    """
    selected_values = {"--d": ("fractal_dimension", dimensions), "--amplitude": ("amplitude", amplitudes)}
    for option_name, (name, values) in selected_values.items():
        if values is not None:
            if name not in dataset.dims:
                raise ValueError(
                    f"{option_name} applies only to studies of generated surfaces; got {option_name} "
                    f"{', '.join(f'{v:g}' for v in values)}"
                )
            dataset = dataset.sel({name: values}, method="nearest").drop_duplicates(name)
    return dataset.isel(amplitude=[0]) if "amplitude" in dataset.dims and amplitudes is None else dataset


def _select_direction(dataset: xarray.Dataset, direction: float) -> xarray.Dataset:
    from stiction.mechanics.quantities import UNCERTAINTY_QUANTITIES

    directions = dataset["direction"].values.reshape(-1).tolist() if "direction" in dataset.coords else []
    if direction % 360 not in directions:
        directions_text = ", ".join(f"{value:g}" for value in directions) or "none"
        raise ValueError(
            f"--direction must be one of the directions in the result ({directions_text}), got {direction:g}"
        )
    selected_dataset = dataset.drop_vars(["mean_friction", "friction_by_axis"], errors="ignore")
    if "direction" not in selected_dataset.dims:
        return selected_dataset
    return selected_dataset.drop_vars([name for name in UNCERTAINTY_QUANTITIES if name in selected_dataset]).sel(
        direction=direction % 360
    )
