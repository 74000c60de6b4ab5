"""Option `--load` for stored results, and messages about loads without a friction coefficient."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from stiction._errors import ArgumentError
from stiction._units import short_repr
from stiction.cli.application import print_warning
from stiction.cli.options import option

if TYPE_CHECKING:
    import xarray

    from stiction.result import Result


LoadsOption = Annotated[
    list[str] | None,
    option(
        "--load FORCE", 'Normal loads, such as "0.1 mN" or, except for generated profiles, "10 MPa,20 MPa".',
        "loads of the study",
    ),
]  # fmt: skip


def parse_loads(result: Result, texts: list[str] | None, width: str | None = None) -> list[float]:
    """Parse the loads on the command line, or return the loads of the study if none are given.

    Return the loads (mN) in ascending order.
    """
    from stiction._arguments import parse_load, parse_quantity, reject_decimal_commas, split_values
    from stiction.mechanics.model import PROFILE_WIDTH

    width_factor = 1.0
    if width is not None:
        if result.study.surfaces.press != "lines":
            raise ArgumentError(
                "{width} must be omitted, because the result is not from two measured profiles, got {got}",
                got=repr(width),
            )
        width_factor = PROFILE_WIDTH / float(parse_quantity("width", width, "length"))
    if not texts:
        if not result.study.friction.load:
            raise ArgumentError("{load} must be given, because the study has no loads")
        return [float(load) for load in result.study.friction.load]
    reject_decimal_commas("load", texts)
    loads = set()
    for value in (load_text for text in texts for load_text in split_values(text)):
        amount, is_per_area = parse_load("load", value, or_zero=result.study.contact.adheres)
        force = float(amount) * (1.0 if is_per_area else width_factor)
        if is_per_area:
            if result.nominal_area is None:
                raise ValueError(f"--load must be a force if the result has no nominal area, got {short_repr(value)}")
            force *= result.nominal_area
        # Loads are rounded to twelve digits, as in `pair`, so that equal loads compare equal.
        loads.add(float(f"{force:.12g}"))
    return sorted(loads)


def report_missing_loads(result: Result, values: xarray.Dataset, missing_loads: Sequence[float]) -> None:
    """Print a warning about loads without a coefficient, or raise a `ValueError` if no load has a coefficient."""
    from stiction.summary.missing_loads import missing_loads_text

    if not missing_loads:
        return
    message = missing_loads_text(result, values, missing_loads)
    if len(missing_loads) == values["load"].size:
        raise ValueError(message)
    print_warning(message)
