"""The table `[contact]` of a study: by asperities or by the half-space, of generated or of measured surfaces."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, PlainSerializer, PlainValidator, create_model, model_validator

from stiction._checks import Floats
from stiction._units import exact, quantity, shortened
from stiction.mechanics.half_space import Boundary
from stiction.mechanics.law import LAWS, NAMED, HertzCylinder, Law, LawName, law_of
from stiction.mechanics.model import ContactModel, Curvature, Detection, Direction, Shear, Sliding
from stiction.studies.values import (
    ApproachesOrRange,
    ApproachRange,
    Compass,
    Directions,
    Fraction,
    Length,
    LoadRange,
    LoadsOrRange,
    Modulus,
    Rules,
    Strength,
    Table,
    array_of,
    as_tuple,
    degrees_of,
    fault_at,
)

COMPASS = tuple(30.0 * step for step in range(12))
"""Directions of measured areas unless others are given, degrees."""


# ---- Laws -----------------------------------------------------------------------------------------------------------


class LawTable(Table):
    """A contact law with its parameters; each law that has some has a subclass, made from its fields."""

    name: str

    def law(self) -> Law:
        """The law itself."""
        kind = next(law for law in LAWS if law.name == self.name)
        return kind(**{each.name: float(getattr(self, each.name)) for each in dataclasses.fields(kind)})


_KINDS: dict[str, Any] = {"µm": Length, "GPa": Modulus}


def _table_of(law: type[Law]) -> type[LawTable]:
    def entry(parameter: dataclasses.Field[Any]) -> Any:
        given = parameter.metadata
        kind = _KINDS.get(given["unit"]) or Annotated[float, Field(ge=given["least"], le=given["most"])]
        return kind, ...

    name: Any = Literal[law.name]
    entries: dict[str, Any] = {"name": (name, ...)} | {each.name: entry(each) for each in dataclasses.fields(law)}
    return create_model(f"{law.__name__}Table", __base__=LawTable, __module__=__name__, __doc__=law.__doc__, **entries)


LAW_TABLES: dict[str, type[LawTable]] = {law.name: _table_of(law) for law in LAWS if dataclasses.fields(law)}
globals().update({table.__name__: table for table in LAW_TABLES.values()})  # so that their instances are pickled


def _read_law(value: object) -> LawName | LawTable:
    """A law by its name, or a table of its parameters."""
    for name in NAMED:
        if value == name:
            return name  # type: ignore[return-value]
    if isinstance(value, LawTable):
        return value
    table = LAW_TABLES.get(str(value.get("name"))) if isinstance(value, Mapping) else None
    if table is None:
        named = " or ".join(f'"{name}"' for name in NAMED)
        tables = " or ".join(
            f'"{name}" ({", ".join(list(table.model_fields)[1:])})' for name, table in LAW_TABLES.items()
        )
        raise ValueError(f"must be {named}, or a table of name {tables}, got {shortened(value)}")
    return table.model_validate(value)


LawEntry = Annotated[
    LawName | LawTable,
    PlainValidator(_read_law),
    PlainSerializer(lambda law: law.model_dump() if isinstance(law, LawTable) else law),
]


def entry_of(law: Law | LawName) -> LawName | LawTable:
    """A law as a study has it."""
    law = law_of(law)
    if law.name not in LAW_TABLES:
        return law.name  # type: ignore[return-value]
    values: dict[str, Any] = {"name": law.name}
    for each in dataclasses.fields(law):
        value, unit = getattr(law, each.name), each.metadata["unit"]
        values[each.name] = exact(value, unit.replace("µ", "u")) if unit in _KINDS else value
    return LAW_TABLES[law.name].model_validate(values)


# ---- What all contacts have -----------------------------------------------------------------------------------------

_Name = Annotated[str, Field(min_length=1, max_length=80)]
_Ratio = Annotated[float, Field(gt=-1, le=0.5)]
TwoNames = Annotated[tuple[_Name, _Name], as_tuple]
TwoRatios = Annotated[tuple[_Ratio, _Ratio], as_tuple]
"""Of the upper and the lower body."""


class ContactTable(Table):
    """How a pair is pressed together: elasticity, and where the upper body is about to move."""

    effective_modulus: Modulus = Field(
        default=quantity("10 GPa", "pressure"), description="E*, the elasticity of both bodies."
    )

    def rules(self) -> tuple[Sliding, ...]:
        """Every sliding rule."""
        raise NotImplementedError

    def ways(self) -> tuple[Direction, ...]:
        """Every direction of motion."""
        raise NotImplementedError

    def degrees(self) -> Floats:
        """Every direction of motion, from +x towards +y."""
        return np.array([degrees_of(way) for way in self.ways()])

    def motions(self) -> dict[str, list[Any]]:
        """Sliding rules and directions (degrees) of which there is a list: more dimensions of what depends on them."""
        raise NotImplementedError


class GeneratedContact(ContactTable):
    """How a generated pair is pressed together: one or several rules and directions."""

    materials: ClassVar[None] = None
    poisson_ratio: ClassVar[None] = None

    shear: Shear = Field(default="+x", description="Where the upper body is about to move along a profile.")
    direction: Directions = Field(
        default=None,
        description="The same in place of `shear`; on surfaces also degrees from +x towards +y, or a list.",
    )
    sliding: Rules = Field(
        default="opposing",
        description="Which contacts rub: those that oppose the motion, as in the paper, or all; or a list of both.",
    )

    @model_validator(mode="after")
    def _has_one_direction_of_motion(self) -> GeneratedContact:
        if self.direction is not None and self.shear != "+x":
            raise fault_at("direction", f'must not be given beside shear, got "{self.shear}" for that')
        return self

    def rules(self) -> tuple[Sliding, ...]:
        """Every sliding rule."""
        return self.sliding if isinstance(self.sliding, tuple) else (self.sliding,)

    def ways(self) -> tuple[Direction, ...]:
        """Every direction, whichever key says it."""
        given = self.shear if self.direction is None else self.direction
        return given if isinstance(given, tuple) else (given,)

    def motions(self) -> dict[str, list[Any]]:
        """Sliding rules and directions (degrees) of which there is a list."""
        lists: dict[str, list[Any]] = {}
        if isinstance(self.sliding, tuple):
            lists["sliding"] = list(self.sliding)
        if isinstance(self.direction, tuple):
            lists["direction"] = self.degrees().tolist()
        return lists


class MeasuredContact(ContactTable):
    """How a measured pair is pressed together: to loads, under both sliding rules."""

    sliding: ClassVar[tuple[Sliding, ...]] = ("all", "opposing")
    onset: ClassVar[None] = None

    load: LoadsOrRange = Field(
        description="Elastic normal loads that the members are pressed to; loads around `friction.load` unless given."
    )
    materials: TwoNames | None = Field(
        default=None, description="Names of what the upper and the lower body are made of; they change nothing."
    )
    poisson_ratio: TwoRatios | None = Field(
        default=None, description="Of the upper and the lower body, for the onset of sliding; 0.3 of both unless given."
    )

    def rules(self) -> tuple[Sliding, ...]:
        """Both rules: all contacts rub, as where mu0 was measured, or those that oppose the motion, as in the paper."""
        return self.sliding

    def motions(self) -> dict[str, list[Any]]:
        """Both rules and all directions (degrees)."""
        return {"sliding": list(self.rules()), "direction": self.degrees().tolist()}

    @property
    def step(self) -> Literal["load"]:
        """What a pair is pressed to, one after the other."""
        return "load"

    def steps(self) -> Floats:
        """All loads, mN."""
        return array_of(self.load)


class ByHalfSpace(ContactTable):
    """Keys of the half-space."""

    law: ClassVar[None] = None

    mechanics: Literal["half-space"] = Field(default="half-space", description="The elastic half-space.")
    boundary: Boundary = Field(
        default="free", description="What lies beyond the edges: nothing, or the same surfaces again."
    )
    hardness: Modulus | None = Field(
        default=None, description="The largest pressure of the half-space; none is elastic."
    )
    compliance_share: Fraction = Field(default=0.5, description="The lower body's fraction of the compliance.")

    def solid(self) -> dict[str, Any]:
        """What `half_space` takes besides bodies, loads and motion."""
        return {
            "effective_modulus": float(self.effective_modulus),
            "boundary": self.boundary,
            "compliance_share": self.compliance_share,
            "hardness": None if self.hardness is None else float(self.hardness),
        }


class ByAsperities(ContactTable):
    """Keys of asperities."""

    hardness: ClassVar[None] = None

    mechanics: Literal["asperities"] = Field(
        default="asperities", description="Hertzian contacts that do not interact."
    )
    law: LawEntry = Field(
        default="hertz-sphere",
        description='What a contact carries; `{ name = "jackson-green", yield_strength = ..., poisson_ratio = ... }`.',
    )
    detection: Detection = Field(
        default="cell", description="What counts as a contact: the paper's criterion, or minima of the gap."
    )
    curvature: Curvature = Field(
        default="convex", description="Whether both bodies must be convex where they touch, or only relatively."
    )

    def model(self, sliding: Sliding | None = None) -> ContactModel:
        """What `press` takes, under one of the sliding rules, by default the first."""
        return ContactModel(
            effective_modulus=float(self.effective_modulus),
            law=self.law if isinstance(self.law, str) else self.law.law(),
            detection=self.detection,
            curvature=self.curvature,
            sliding=sliding or self.rules()[0],
        )


# ---- How they begin to slide ----------------------------------------------------------------------------------------


class OnsetTable(Table):
    """Strengths at which it is kept how each pair begins to slide, all contacts rubbing; others need another run."""

    mu0: float = Field(default=0.4, ge=0, description="Molecular friction coefficient.")
    tau0: Strength = Field(default=quantity("0 MPa", "pressure"), description="Adhesive shear strength.")
    poisson_ratio: float = Field(default=0.3, gt=-1, le=0.5, description="Of both bodies.")

    @model_validator(mode="after")
    def _holds(self) -> OnsetTable:
        if self.mu0 == 0 and float(self.tau0) == 0:
            raise ValueError("mu0 and tau0 must not both be 0: nothing would hold the bodies")
        return self


# ---- Generated surfaces ---------------------------------------------------------------------------------------------


class Asperities(GeneratedContact, ByAsperities):
    """Contacts of asperities, pressed over approaches."""

    case: ClassVar[str] = "contact of profiles by asperities"

    approach: ApproachesOrRange = Field(
        default=ApproachRange(start=quantity("0.1 nm", "length"), stop=quantity("40 nm", "length"), count=40),
        description="How far the bodies are pressed together.",
    )
    onset: OnsetTable | None = Field(
        default=None,
        description="Whether it is kept how each pair begins to slide, and at which strengths, as in `{ mu0 = 0.4 }`.",
    )

    @model_validator(mode="after")
    def _has_an_onset(self) -> Asperities:
        if self.onset is not None and isinstance(law_of(self.model().law), HertzCylinder):
            raise fault_at("onset", "must not be given with cylinders: a line load moves far points without limit")
        return self

    @property
    def step(self) -> Literal["approach"]:
        """What a pair is pressed to, one after the other."""
        return "approach"

    def steps(self) -> Floats:
        """All approaches, µm."""
        return array_of(self.approach)

    def approaches(self) -> Floats:
        """All approaches, µm."""
        return array_of(self.approach)

    def model(self, sliding: Sliding | None = None) -> ContactModel:
        """What `press` takes in all directions, under one of the sliding rules, by default the first."""
        return replace(super().model(sliding), shear=self.shear, direction=self.direction)


class AsperitiesOnSurfaces(Asperities):
    """The same on surfaces: contacts are minima of the gap, and whatever is relatively convex touches."""

    case: ClassVar[str] = "contact of surfaces by asperities"

    detection: Detection = Field(default="gap-minimum", description="What counts as a contact: minima of the gap.")
    curvature: Curvature = Field(
        default="signed", description="Whether both bodies must be convex where they touch, or only relatively."
    )


class HalfSpace(GeneratedContact, ByHalfSpace):
    """Contact by the half-space, pressed over loads."""

    case: ClassVar[str] = "contact by the half-space"
    onset: ClassVar[None] = None

    load: LoadsOrRange = Field(
        default=LoadRange(start=quantity("0.01 mN", "force"), stop=quantity("1 mN", "force"), count=8),
        description="Elastic normal loads to press the bodies to.",
    )

    @property
    def step(self) -> Literal["load"]:
        """What a pair is pressed to, one after the other."""
        return "load"

    def steps(self) -> Floats:
        """All loads, mN."""
        return array_of(self.load)


# ---- Measured surfaces ----------------------------------------------------------------------------------------------


class _AroundTheCompass(MeasuredContact):
    """Directions of measured areas."""

    direction: Compass = Field(
        default=COMPASS, description="Where the upper body is about to move, degrees from +x towards +y."
    )

    def ways(self) -> tuple[Direction, ...]:
        """Every direction of motion."""
        return self.direction


class _AlongTheLine(MeasuredContact):
    """Directions of measured lines."""

    direction: ClassVar[None] = None

    def ways(self) -> tuple[Direction, ...]:
        """Both directions along a line."""
        return ("+x", "-x")


class AsperitiesOfAreas(_AroundTheCompass, ByAsperities):
    """Contacts of asperities of measured areas, pressed over loads."""

    case: ClassVar[str] = "contact of measured areas by asperities"

    detection: Detection = Field(default="gap-minimum", description="What counts as a contact: minima of the gap.")
    curvature: Curvature = Field(
        default="signed", description="Whether both bodies must be convex where they touch, or only relatively."
    )


class HalfSpaceOfAreas(_AroundTheCompass, ByHalfSpace):
    """Contact of measured areas by the half-space."""

    case: ClassVar[str] = "contact of measured areas by the half-space"


class AsperitiesOfLines(_AlongTheLine, ByAsperities):
    """Contacts of asperities of measured lines, pressed over loads."""

    case: ClassVar[str] = "contact of measured lines by asperities"

    detection: Detection = Field(
        default="gap-minimum", description="What counts as a contact: the paper's criterion, or minima of the gap."
    )


class HalfSpaceOfLines(_AlongTheLine, ByHalfSpace):
    """Contact of measured lines by half-planes."""

    case: ClassVar[str] = "contact of measured lines by the half-space"


Contact = Asperities | HalfSpace | AsperitiesOfAreas | HalfSpaceOfAreas | AsperitiesOfLines | HalfSpaceOfLines
"""The table `[contact]` of a study."""
