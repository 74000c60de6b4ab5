"""`stiction at`: what a result says at one load."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction._arguments import (
    parse_coefficients,
    parse_load,
    parse_numbers,
    parse_quantities,
    parse_quantity,
    reject_decimal_commas,
    reject_negative,
    split_values,
)
from stiction._errors import ArgumentError
from stiction.cli.application import announce, command, interrupted, tell
from stiction.cli.execution import Workers
from stiction.cli.options import Json, Verbose, option, refuse
from stiction.cli.result_output import opened
from stiction.mechanics.model import THICKNESS
from stiction.mechanics.quantities import UNCERTAINTY

if TYPE_CHECKING:
    import xarray

    from stiction.studies.result import Result
    from stiction.studies.store import Stored


Loads = Annotated[
    list[str] | None,
    option("--load FORCE", 'Normal load, "0.1 mN", or of measured bodies a pressure, "10 MPa,20 MPa".', "its own"),
]
Width = Annotated[str | None, option("--width LENGTH", "Of two profiles, the width that a force is on.", "1 um")]
Dimension = Annotated[
    str | None, option("--d NUMBERS", 'Of a study: the nearest fractal dimensions that it has, "1.1,1.3".', "all")
]
Hurst = Annotated[str | None, option("--hurst NUMBERS", "Of self-affine surfaces: the nearest Hurst exponents.", "all")]
Amplitude = Annotated[str | None, option("--amplitude LENGTH", "Of a study: the nearest that it has.", "its first")]
Mu0 = Annotated[str | None, option("--mu0 NUMBERS", 'Molecular friction coefficients, "0.3,0.4".', "its own")]
Tau0 = Annotated[str | None, option("--tau0 PRESSURES", 'Adhesive shear strengths, "0 MPa,50 MPa".', "its own")]
Direction = Annotated[
    float | None, option("--direction DEGREES", "Where the upper body is about to move.", "the mean of all")
]

_heights = partial(option, panel="Another finish")
ScaleHeights = Annotated[
    str | None, _heights("--scale-heights FACTORS", 'Heights times factors, "0.5,1,2" or "0.25..4".', False)
]
ScaledSurfaces = Annotated[str, _heights("--scaled both|upper|lower", "Surfaces whose heights are scaled.")]
Compute = Annotated[bool, _heights("--compute", "Compute the factors that are missing, and keep them in DIR.", False)]


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
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Where a study or a pair was written.")],
    load: Loads = None,
    width: Width = None,
    d: Dimension = None,
    hurst: Hurst = None,
    amplitude: Amplitude = None,
    mu0: Mu0 = None,
    tau0: Tau0 = None,
    direction: Direction = None,
    scale_heights: ScaleHeights = None,
    scaled: ScaledSurfaces = "both",
    compute: Compute = False,
    workers: Workers = None,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
    """Coefficient of static friction, true contact area and stiffness of a result at one load, with intervals.

    Loads, mu0 and tau0 that are not given are those of the study. Others need nothing pressed again. Each factor of
    --scale-heights is solved once and stored with the result.
    """
    from stiction.views import rows, text

    result = opened(directory)
    rubbing = None if mu0 is None else parse_coefficients("mu0", mu0)
    strengths = None
    if tau0 is not None:
        strengths = reject_negative("tau0", parse_quantities("tau0", tau0, "pressure"), tau0)
    if scale_heights is None:
        refuse(context, "is for --scale-heights", "scaled", "compute", "workers")
    else:
        refuse(context, "does not apply to --scale-heights", "d", "hurst", "amplitude", "direction")
        loads = _loads(result, load, width)
        assert result.stored is not None, "a directory is open"
        _at_height_scale(
            result.stored, scale_heights, scaled, loads, rubbing, strengths, compute=compute, workers=workers,
            as_json=as_json,
        )  # fmt: skip
        return
    length = None if amplitude is None else parse_quantity("amplitude", amplitude, "length")
    found = result.at(_loads(result, load, width), mu0=rubbing, tau0=strengths, budget=True)
    dimensions = None if d is None else parse_numbers("d", d)
    if hurst is not None:
        if d is not None or getattr(result.study.surfaces, "generator", "") != "self-affine":
            raise ArgumentError("{hurst} is for self-affine surfaces, without --d, got {got}", got=repr(hurst))
        dimensions = [2 - each for each in parse_numbers("hurst", hurst)]
    found = _cells(found, dimensions, None if length is None else [length])
    if direction is not None:
        found = _towards(found, direction)
    summary = result.summary_of(found)
    if as_json:
        tell(rows.record_text("at", summary))
    else:
        if own := text.own_values_text(result.study, mu0=mu0 is None, tau0=tau0 is None):
            tell(own)
        tell(text.result_text(summary, verbose=verbose))


def _at_height_scale(
    stored: Stored, text: str, scaled: str, loads: list[float], mu0: Any, tau0: Any, *, compute: bool,
    workers: int | None, as_json: bool,
) -> None:  # fmt: skip
    """Print a result over factors of its heights; those that are missing are computed on request."""
    from stiction.studies.executors import threads
    from stiction.studies.height_scale import at_height_scale, checked_factors, compute_factors
    from stiction.views.height_scale import height_scale_record, height_scale_text

    asked: Any = scaled
    factors = checked_factors(text)
    if compute:
        try:
            with threads(workers) as executor:
                compute_factors(stored, factors, asked, executor, progress=True, announce=announce)
        except KeyboardInterrupt:
            raise interrupted("; finished factors are kept: the same command goes on from there") from None
    at = at_height_scale(stored, factors, loads, mu0=mu0, tau0=tau0, scaled=asked)
    tell((height_scale_record if as_json else height_scale_text)(at, stored.study))


def _loads(result: Result, texts: list[str] | None, width: str | None) -> list[float]:
    """Return the loads of the options, or those of the study, in mN and in rising order; forces may be on a width."""
    strip = 1.0
    if width is not None:
        if result.study.surfaces.press != "lines":
            raise ArgumentError("{width} is for two profiles, got {got}", got=repr(width))
        strip = THICKNESS / float(parse_quantity("width", width, "length"))
    if not texts:
        if not result.study.friction.load:
            raise ArgumentError("give {load}: this study does not ask for loads of its own")
        return [float(load) for load in result.study.friction.load]
    reject_decimal_commas("load", texts)
    loads = set()
    for each in (part for text in texts for part in split_values(text)):
        amount, per_area = parse_load("load", each, or_zero=result.study.contact.adheres)
        force = float(amount) * (1.0 if per_area else strip)
        if per_area:
            coordinates = result.head.coords
            if "nominal_area" not in coordinates:
                raise ValueError(f"--load of a study must be a force, got {each!r}")
            force *= float(coordinates["nominal_area"])
        loads.add(float(f"{force:.12g}"))  # as that of a pair, so that it is the same
    return sorted(loads)


def _cells(found: xarray.Dataset, dimensions: list[float] | None, amplitudes: Sequence[float] | None) -> xarray.Dataset:
    """Return the cells nearest to the given dimensions and amplitudes (µm); all, and the first, if there are none."""
    nearest = {"--d": ("fractal_dimension", dimensions), "--amplitude": ("amplitude", amplitudes)}
    for flag, (name, values) in nearest.items():
        if values is not None:
            if name not in found.dims:
                raise ValueError(
                    f"{flag} is for studies of generated surfaces, got {', '.join(f'{v:g}' for v in values)}"
                )
            found = found.sel({name: values}, method="nearest").drop_duplicates(name)
    return found.isel(amplitude=[0]) if "amplitude" in found.dims and amplitudes is None else found


def _towards(found: xarray.Dataset, direction: float) -> xarray.Dataset:
    known = found["direction"].values.reshape(-1).tolist() if "direction" in found.coords else []
    if direction % 360 not in known:
        shown = ", ".join(f"{each:g}" for each in known) or "none"
        raise ValueError(f"--direction must be one of those of the result, {shown}; got {direction:g}")
    one = found.drop_vars(["friction_all_round", "friction_by_axis"], errors="ignore")
    if "direction" not in one.dims:
        return one
    return one.drop_vars([name for name in UNCERTAINTY if name in one]).sel(direction=direction % 360)
