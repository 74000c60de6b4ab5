"""The tables of a study file, and of which case the tables of surfaces, contact and friction are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, Field

from stiction._units import quantity, shortened
from stiction.studies.contact_tables import (
    Asperities,
    AsperitiesOfAreas,
    AsperitiesOfLines,
    AsperitiesOnSurfaces,
    Contact,
    HalfSpace,
    HalfSpaceOfAreas,
    HalfSpaceOfLines,
)
from stiction.studies.generated_surfaces import (
    Generated,
    Profiles,
    SelfAffineSurfaces,
    WeierstrassMandelbrotSurfaces,
)
from stiction.studies.measured_surfaces import MEASURED, Measured
from stiction.studies.values import Coefficients, LoadsOfInterest, Strengths, Table, as_tuple, fault_at

Surfaces = Generated | Measured
"""The table `[surfaces]` of a study."""


class Friction(Table):
    """Molecular friction coefficients and adhesive shear strengths that the figures show."""

    mu0: Coefficients = Field(
        default=(0.1, 0.4, 1.0), description="Molecular friction coefficients that the figures show."
    )
    tau0: Strengths = Field(
        default=tuple(quantity(f"{tau0} MPa", "pressure") for tau0 in ("0", "0.5", "10", "100", "200")),
        description="Adhesive shear strengths that the figures show.",
    )


class MeasuredFriction(Table):
    """What is asked for of measured surfaces."""

    mu0: Coefficients = Field(description="Molecular friction coefficients.")
    tau0: Strengths = Field(default=(quantity("0 MPa", "pressure"),), description="Adhesive shear strengths.")
    load: LoadsOfInterest = Field(
        description="Normal loads that are asked for; `contact.load` is the curve around them."
    )


class Ensemble(Table):
    """How many members, and where their random numbers start."""

    repetitions: int = Field(
        default=100,
        ge=1,
        le=100_000_000,
        description="Pairs for each fractal dimension and amplitude, or of measured surfaces relative positions.",
    )
    seed: int = Field(
        default=2016,
        ge=0,
        lt=2**63,
        description="Where the random numbers start; the same seed gives the same surfaces.",
    )


FigureName = Literal["profiles", "length-scales", "friction", "area", "onset"]


def _distinct(names: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"must name each figure once, but {name!r} is there {names.count(name)} times")
    return names


class Figures(Table):
    """What is drawn of the result of generated surfaces."""

    draw: Annotated[tuple[FigureName, ...], as_tuple, AfterValidator(_distinct)] = Field(
        default=("friction", "area"), description="Which figures `run` and `plot` draw."
    )


# ---- Cases ----------------------------------------------------------------------------------------------------------

SURFACES: tuple[type[Surfaces], ...] = (
    Profiles, WeierstrassMandelbrotSurfaces, SelfAffineSurfaces, *MEASURED,
)  # fmt: skip
"""Every case of the table `[surfaces]`."""

_CONTACTS: dict[type[Surfaces], tuple[type[Contact], ...]] = {
    Profiles: (Asperities, HalfSpace),
    WeierstrassMandelbrotSurfaces: (AsperitiesOnSurfaces, HalfSpace),
    SelfAffineSurfaces: (AsperitiesOnSurfaces, HalfSpace),
    **{
        case: (HalfSpaceOfAreas, AsperitiesOfAreas) if case.is_areal else (AsperitiesOfLines, HalfSpaceOfLines)
        for case in MEASURED
    },
}
"""The cases of the table `[contact]` that go with each kind of surfaces; the first is the default."""

CONTACTS: tuple[type[Contact], ...] = tuple(dict.fromkeys(case for cases in _CONTACTS.values() for case in cases))
"""Every case of the table `[contact]`."""


_Case = TypeVar("_Case", bound=Table)


def surfaces_case(given: Mapping[str, Any]) -> type[Surfaces]:
    """The case of a table `[surfaces]`, by its keys `kind`, `generator` and `press`."""
    match given.get("kind", "profile"):
        case "profile":
            return Profiles
        case "surface":
            cases: dict[Any, type[Surfaces]] = {
                "weierstrass-mandelbrot": WeierstrassMandelbrotSurfaces, "self-affine": SelfAffineSurfaces,
            }  # fmt: skip
            return _chosen("generator", given.get("generator", "weierstrass-mandelbrot"), cases)
        case "measured":
            cases = {case.model_fields["press"].default: case for case in MEASURED}
            return _chosen("press", given.get("press", "areas"), cases)
        case other:
            raise fault_at("kind", f'must be "profile", "surface" or "measured", got {shortened(other)}')


def contact_case(surfaces: type[Surfaces], given: Mapping[str, Any]) -> type[Contact]:
    """The case of a table `[contact]`, by its key `mechanics` and by the surfaces."""
    cases: dict[Any, type[Contact]] = {case.model_fields["mechanics"].default: case for case in _CONTACTS[surfaces]}
    return _chosen("mechanics", given.get("mechanics", next(iter(cases))), cases)


def _chosen(key: str, value: Any, cases: dict[Any, type[_Case]]) -> type[_Case]:
    if not isinstance(value, str) or value not in cases:
        allowed = " or ".join(f'"{name}"' for name in cases)
        raise fault_at(key, f"must be {allowed}, got {shortened(value)}")
    return cases[value]


def read_surfaces(value: object) -> Surfaces:
    """A table `[surfaces]` of the case that it says."""
    if isinstance(value, SURFACES):
        return value
    if not isinstance(value, Mapping):
        raise ValueError(f"must be a table, got {shortened(value)}")
    return _of_case(surfaces_case(value), (), SURFACES, value)


def read_contact(value: object, surfaces: Surfaces) -> Contact:
    """A table `[contact]` of the case that it says and that goes with the surfaces."""
    if isinstance(value, CONTACTS):
        value = {key: getattr(value, key) for key in value.model_fields_set} | {"mechanics": value.mechanics}
    if not isinstance(value, Mapping):
        raise ValueError(f"must be a table, got {shortened(value)}")
    return _of_case(contact_case(type(surfaces), value), _CONTACTS[type(surfaces)], CONTACTS, value)


def read_friction(value: object, surfaces: Surfaces) -> Friction | MeasuredFriction:
    """A table `[friction]`, of generated or of measured surfaces."""
    if isinstance(value, (Friction, MeasuredFriction)):
        value = {key: getattr(value, key) for key in value.model_fields_set}
    if not isinstance(value, Mapping):
        raise ValueError(f"must be a table, got {shortened(value)}")
    if isinstance(surfaces, Measured):
        return MeasuredFriction.model_validate(value)
    if "load" in value:
        raise fault_at("load", f"belongs to measured surfaces, not to {surfaces.case}")
    return Friction.model_validate(value)


def _of_case(case: type[_Case], near: tuple[Any, ...], cases: tuple[Any, ...], given: Mapping[Any, Any]) -> _Case:
    """The table of that case; of a key of other cases it is said whose it is, near ones before all others."""
    for key in given:
        if key in case.model_fields:
            continue
        owners = [each.case for each in near if key in each.model_fields]
        owners = owners or [each.case for each in cases if key in each.model_fields]
        if owners:
            name = getattr(case, "case", "this table")
            raise fault_at(str(key), f"belongs to {' and '.join(dict.fromkeys(owners))}, not to {name}")
    return case.model_validate(given)
