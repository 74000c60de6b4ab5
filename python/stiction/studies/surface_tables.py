"""The table `[surfaces]` of a study: generated profiles and areas, and what is made of two measured files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args

from stiction._units import shortened
from stiction.studies.generated_surfaces import Generated, Profiles, SelfAffineSurfaces, WeierstrassMandelbrotSurfaces
from stiction.studies.measured_areas import MeasuredAreas, MeasuredSurrogates
from stiction.studies.measured_lines import MeasuredLines
from stiction.studies.values import chosen, fault_at

Measured = MeasuredAreas | MeasuredLines | MeasuredSurrogates
"""What a study of two measured files presses; a new kind of members is one more of these."""

Surfaces = Generated | Measured  # the table `[surfaces]` of a study
SURFACES: tuple[type[Surfaces], ...] = get_args(Surfaces)  # every case of the table


def _by(key: str, *cases: type[Surfaces]) -> tuple[str, dict[str, type[Surfaces]]]:
    return key, {case.model_fields[key].default: case for case in cases}


_CASES = {
    "profile": _by("kind", Profiles),
    "surface": _by("generator", WeierstrassMandelbrotSurfaces, SelfAffineSurfaces),
    "measured": _by("press", *get_args(Measured)),
}
"""By its key `kind` another key that says which case a table is of, and the cases, the first of them by default."""


def surfaces_case(given: Mapping[str, Any]) -> type[Surfaces]:
    """The case of a table, by its keys `kind`, `generator` and `press`."""
    key, cases = _CASES[chosen("kind", given, _CASES)]
    return cases[chosen(key, given, cases)]


def pressed(surfaces: type[Surfaces]) -> str:
    """What is pressed: generated or measured, lines or areas."""
    kind = "measured" if issubclass(surfaces, Measured) else "generated"
    return f"{kind} {'areas' if surfaces.is_areal else 'lines'}"


def read_surfaces(value: object) -> Surfaces:
    """A table of the case that it says."""
    if isinstance(value, SURFACES):
        return value
    if not isinstance(value, Mapping):
        raise ValueError(f"must be a table, got {shortened(value)}")
    case = surfaces_case(value)
    for key in value:
        owners = [each.case for each in SURFACES if key in each.model_fields]
        if owners and key not in case.model_fields:
            raise fault_at(str(key), f"belongs to {' and '.join(owners)}, not to {case.case}")
    return case.model_validate(value)
