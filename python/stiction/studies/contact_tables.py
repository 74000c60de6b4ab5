"""The table `[contact]` of a study, by asperities or by the half-space, and where each of its keys may stand."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, PlainSerializer, PlainValidator, create_model, model_validator

from stiction._checks import Floats, float_array
from stiction._units import MAGNITUDES, exact_quantity, quantity, short_repr
from stiction.mechanics.half_space import ADHESION_RANGE, Boundary, Tilt
from stiction.mechanics.law import LAWS, NAMED, HertzCylinder, Law, LawName, law_of
from stiction.mechanics.model import THICKNESS, ContactModel, Curvature, Detection, Direction, Shear, Sliding
from stiction.studies.generated_surfaces import Generated, Profiles
from stiction.studies.known import MAX_GROWTH
from stiction.studies.measured_surfaces import Measured
from stiction.studies.values import (
    REQUIRED,
    ApproachesOrRange,
    ApproachRange,
    Directions,
    Fraction,
    Keys,
    Length,
    LoadRange,
    LoadsOrRange,
    Modulus,
    Rules,
    Strength,
    Table,
    WorkOfAdhesion,
    array_of,
    as_tuple,
    chosen,
    completed,
    degrees_of,
    fault_at,
    written,
)

COMPASS = tuple(30.0 * step for step in range(12))  # directions of measured areas unless others are given, degrees
MOST_DIRECTIONS = 360  # largest number of directions of measured areas
_KINDS: dict[str, Any] = {"µm": Length, "GPa": Modulus}
AROUND = 30.0  # how far a curve of lines by asperities goes to both sides of the loads that are asked for
LOAD_STEPS = 25
AROUND_HALF_SPACE = 10.0  # as `AROUND`, of half-planes, where each load takes a solution
HALF_SPACE_STEPS = 7
AROUND_AREAS = 10**0.5  # ratio of the loads that are asked for to the one below and the one above them, of areas


# ---- Laws -----------------------------------------------------------------------------------------------------------


class LawTable(Table):
    """A contact law with its parameters; each law that has some has a subclass, made from its fields."""

    name: str

    def law(self) -> Law:
        """The law itself."""
        kind = next(law for law in LAWS if law.name == self.name)
        return kind(**{each.name: float(getattr(self, each.name)) for each in dataclasses.fields(kind)})


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
        raise ValueError(f"must be {named}, or a table of name {tables}, got {short_repr(value)}")
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
        values[each.name] = exact_quantity(value, unit.replace("µ", "u")) if unit in _KINDS else value
    return LAW_TABLES[law.name].model_validate(values)


# ---- Contacts -------------------------------------------------------------------------------------------------------

_Name = Annotated[str, Field(min_length=1, max_length=80)]
_Ratio = Annotated[float, Field(gt=-1, le=0.5)]
TwoNames = Annotated[tuple[_Name, _Name], as_tuple]
TwoRatios = Annotated[tuple[_Ratio, _Ratio], as_tuple]  # upper and lower body


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


class ContactTable(Table):
    """How a pair is pressed together; what a key is where it must not be given stands here, all defaults in `KEYS`."""

    effective_modulus: Modulus = Field(
        default=quantity("10 GPa", "pressure"), description="E*, the elasticity of both bodies."
    )
    shear: Shear = Field(default="+x", description="Where the upper body is about to move along a profile.")
    direction: Directions = Field(
        default=("+x", "-x"),
        description="Where the upper body is about to move, in place of `shear`; of areas also degrees from +x towards "
        "+y, or a list.",
    )
    sliding: Rules = Field(
        default=("all", "opposing"),
        description="Which contacts rub: those that oppose the motion, as in the paper, or all; or a list of both.",
    )
    load: LoadsOrRange | None = Field(
        default=None,
        description="Elastic normal loads to press the bodies to; of measured ones loads around `friction.load` unless "
        "given.",
    )
    materials: TwoNames | None = Field(
        default=None, description="Names of what the upper and the lower body are made of; they change nothing."
    )
    poisson_ratio: TwoRatios | None = Field(
        default=None, description="Of the upper and the lower body, for the onset of sliding; 0.3 of both unless given."
    )

    @model_validator(mode="after")
    def _has_one_direction_of_motion(self) -> Self:
        if self.direction is not None and self.shear != "+x":
            raise fault_at("direction", f'must not be given beside shear, got "{self.shear}" for that')
        return self

    @property
    def step(self) -> Literal["approach", "load"]:
        """What a pair is pressed to, one after the other."""
        return "approach" if self.load is None else "load"

    def steps(self) -> Floats:
        """All approaches, µm, or loads, mN."""
        return array_of(getattr(self, self.step))

    def rules(self) -> tuple[Sliding, ...]:
        """Every sliding rule."""
        return self.sliding if isinstance(self.sliding, tuple) else (self.sliding,)

    def ways(self) -> tuple[Direction, ...]:
        """Every direction of motion, whichever key says it."""
        given = self.shear if self.direction is None else self.direction
        return given if isinstance(given, tuple) else (given,)

    def degrees(self) -> Floats:
        """Every direction of motion, from +x towards +y."""
        return np.array([degrees_of(way) for way in self.ways()])

    def motions(self) -> dict[str, list[Any]]:
        """Sliding rules and directions (degrees) of which there is a list: more dimensions of what depends on them."""
        lists: dict[str, list[Any]] = {"sliding": list(self.rules()), "direction": self.degrees().tolist()}
        return {name: values for name, values in lists.items() if isinstance(getattr(self, name), tuple)}


class HalfSpace(ContactTable):
    """Contact by the elastic half-space."""

    law: ClassVar[None] = None
    onset: ClassVar[None] = None

    mechanics: Literal["half-space"] = Field(default="half-space", description="The elastic half-space.")
    boundary: Boundary = Field(description="What lies beyond the edges: nothing, or the same surfaces again.")
    hardness: Modulus | None = Field(description="The largest pressure of the half-space; none is elastic.")
    junction_growth: float | None = Field(
        default=None,
        ge=0,
        le=MAX_GROWTH,
        description="α of p² + α s² = H², by which plastic contacts grow under shear; none is 0, with a caveat.",
    )
    compliance_share: Fraction = Field(description="The lower body's fraction of the compliance.")
    work_of_adhesion: WorkOfAdhesion | None = Field(
        description="Energy that parts an area in contact; none is not known, and taken as 0."
    )
    adhesion_range: Length | None = Field(
        description="Gap over which the attraction falls off by 1/e; 0.5 nm unless given."
    )

    tilt: Tilt = Field(
        description="Whether the upper of free bodies keeps its orientation, or turns until the load is in the middle."
    )

    @model_validator(mode="after")
    def _grows(self) -> HalfSpace:
        if self.junction_growth and self.hardness is None:
            raise fault_at("junction_growth", "must not be given without a hardness: elastic contacts do not grow")
        if self.junction_growth and self.adheres:
            raise fault_at(
                "junction_growth", "must be 0 of bodies that adhere: their contacts at sliding are not solved"
            )
        return self

    @model_validator(mode="after")
    def _adheres(self) -> HalfSpace:
        if self.adhesion_range is not None and not self.adheres:
            raise fault_at("adhesion_range", "must not be given without a work_of_adhesion above 0")
        strength = float(self.work_of_adhesion or 0) / float(self.adhesion_range or ADHESION_RANGE)
        if self.hardness is not None and not strength < float(self.hardness):
            raise fault_at(
                "hardness", f"must be above work_of_adhesion over adhesion_range, {strength:g} GPa, under which bodies "
                f"flow without a load, got {written(self.hardness)!r}",
            )  # fmt: skip
        return self

    @property
    def adheres(self) -> bool:
        """Whether there is an attraction between the bodies."""
        return bool(self.work_of_adhesion)

    @model_validator(mode="after")
    def _can_turn(self) -> HalfSpace:
        if self.tilt == "free" and (self.adheres or self.boundary == "periodic"):
            raise fault_at("tilt", 'must be "fixed" of periodic bodies and with a work of adhesion, got "free"')
        return self

    def solid(self) -> dict[str, Any]:
        """What `half_space` takes besides bodies, loads and motion."""
        return {
            "effective_modulus": float(self.effective_modulus),
            "boundary": self.boundary,
            "compliance_share": self.compliance_share,
            "tilt": self.tilt,
            "hardness": None if self.hardness is None else float(self.hardness),
            **({"work_of_adhesion": float(self.work_of_adhesion)} if self.work_of_adhesion else {}),
            **({"adhesion_range": float(self.adhesion_range)} if self.adhesion_range else {}),
        }


class Asperities(ContactTable):
    """Contacts of asperities, which do not feel each other."""

    hardness: ClassVar[None] = None
    junction_growth: ClassVar[None] = None
    work_of_adhesion: ClassVar[None] = None
    adheres: ClassVar[bool] = False

    mechanics: Literal["asperities"] = Field(
        default="asperities", description="Hertzian contacts that do not interact."
    )
    law: LawEntry = Field(
        description='What a contact carries; `{ name = "jackson-green", yield_strength = ..., poisson_ratio = ... }`.'
    )
    detection: Detection = Field(
        description="What counts as a contact: the paper's criterion, or minima of the gap, which is all of areas."
    )
    curvature: Curvature = Field(description="Whether both bodies must be convex where they touch, or only relatively.")
    approach: ApproachesOrRange | None = Field(default=None, description="How far the bodies are pressed together.")
    onset: OnsetTable | None = Field(
        default=None,
        description="Whether it is kept how each pair begins to slide, and at which strengths, as in `{ mu0 = 0.4 }`.",
    )

    @model_validator(mode="after")
    def _has_an_onset(self) -> Asperities:
        if self.onset is not None and isinstance(law_of(self.model().law), HertzCylinder):
            raise fault_at("onset", "must not be given with cylinders: a line load moves far points without limit")
        return self

    def model(self, sliding: Sliding | None = None) -> ContactModel:
        """What `press` takes, under one of the sliding rules, by default the first; of loads without directions."""
        moved: Any = {} if self.approach is None else {"shear": self.shear, "direction": self.direction}
        return ContactModel(
            effective_modulus=float(self.effective_modulus),
            law=self.law if isinstance(self.law, str) else self.law.law(), detection=self.detection,
            curvature=self.curvature, sliding=sliding or self.rules()[0], **moved,
        )  # fmt: skip


Contact = Asperities | HalfSpace  # the table `[contact]` of a study
CONTACTS: dict[str, type[Contact]] = {"asperities": Asperities, "half-space": HalfSpace}  # cases by `mechanics`


# ---- Where its keys may stand ---------------------------------------------------------------------------------------

KEYS: Keys = {
    "law": {"asperities": "hertz-sphere"},
    "detection": {
        "asperities of generated lines": "cell", "asperities of measured lines": "gap-minimum",
        "asperities of areas": "gap-minimum",
    },
    "curvature": {"asperities of lines": "convex", "asperities of areas": "signed"},
    "boundary": {"the half-space": "free"},
    "hardness": {"the half-space": None},
    "compliance_share": {"the half-space": 0.5},
    "work_of_adhesion": {"the half-space": None},
    "adhesion_range": {"the half-space": None},
    "tilt": {"the half-space": "fixed"},
    "shear": {"generated surfaces": "+x"},
    "direction": {"generated surfaces": None, "measured areas": COMPASS},
    "sliding": {"generated surfaces": "opposing"},
    "approach": {
        "asperities of generated surfaces":
            ApproachRange(start=quantity("0.1 nm", "length"), stop=quantity("40 nm", "length"), count=40),
    },
    "onset": {"asperities of generated surfaces": None},
    "load": {
        "measured surfaces": REQUIRED,
        "the half-space of generated surfaces":
            LoadRange(start=quantity("0.01 mN", "force"), stop=quantity("1 mN", "force"), count=8),
    },
    "materials": {"measured surfaces": None},
    "poisson_ratio": {"measured surfaces": None},
}  # fmt: skip
"""Keys that not every table `[contact]` has, with their defaults."""


def contact_case(surfaces: type[Generated | Measured], given: Mapping[str, Any]) -> tuple[type[Contact], str]:
    """The case of a table by its key `mechanics`, and its place, as in "asperities of generated lines"."""
    bodies = surfaces.bodies
    mechanics = chosen("mechanics", given, CONTACTS, "half-space" if bodies == "measured areas" else "asperities")
    return CONTACTS[mechanics], f"{'the ' * (mechanics == 'half-space')}{mechanics} of {bodies}"


def read_contact(value: Mapping[str, Any], surfaces: Generated | Measured) -> Contact:
    """A table that goes with the surfaces."""
    case, place = contact_case(type(surfaces), value)
    contact = case.model_validate(completed(KEYS, place, value))
    direction = contact.direction
    if place.endswith("measured areas"):
        if direction is None or len(contact.ways()) > MOST_DIRECTIONS:
            raise fault_at("direction", f"must be from 1 to {MOST_DIRECTIONS} directions, got {short_repr(direction)}")
        contact = contact.model_copy(update={"direction": tuple(contact.degrees().tolist())})
    if isinstance(surfaces, Profiles) and direction not in (None, "+x", "-x"):
        raise fault_at("direction", f'must be "+x" or "-x" on profiles, got {short_repr(direction)}')
    if isinstance(contact, Asperities) and surfaces.is_areal:
        try:
            contact.model().for_surfaces()
        except ValueError as error:
            key, _, why = str(error).partition(" ")
            raise fault_at(key, why) from None
    if isinstance(contact, HalfSpace) and contact.hardness is not None and not isinstance(surfaces, Measured):
        area = float(surfaces.extent) * THICKNESS if isinstance(surfaces, Profiles) else math.prod(surfaces.extents())
        if not contact.steps()[-1] < (most := float(contact.hardness) * area):
            raise fault_at("load", f"must be below hardness times area, {most:g} mN")
    return contact


def _around(given: Floats, ratio: float, steps: int) -> Floats:
    """Given loads (mN), and enough others around them in equal ratios for a curve."""
    others = np.geomspace(given.min() / ratio, given.max() * ratio, steps)
    # Given ones stay to the bit; others next to them would be the same again.
    apart = np.abs(others[:, np.newaxis] / given - 1).min(axis=1) > 1e-6
    return np.unique(np.concatenate([given, others[apart]]))


def _filled(given: Floats) -> Floats:
    """Return given loads (mN) with others between, in equal ratios of at most `AROUND_AREAS` and a little more."""
    given = np.unique(given)
    steps = np.ceil(np.log(given[1:] / given[:-1]) / np.log(1.01 * AROUND_AREAS)).astype(int)
    between = [
        np.geomspace(low, high, count, endpoint=False)[1:]
        for low, high, count in zip(given[:-1], given[1:], steps, strict=True)
    ]
    return np.concatenate([given, *between])


def ladder(loads: ArrayLike, *, press: str, mechanics: str, most: float | None = None, lighter: int = 1) -> Floats:
    """Return loads (mN) to solve a measured pair at, all below `most`: the given ones, and others around and between.

    Areas have a number of `lighter` loads below the given ones, and loads in steps of at most `AROUND_AREAS` between.
    """
    given = np.atleast_1d(float_array("loads", loads))
    if not given.size or not (given > 0).all():
        raise ValueError(f"loads must be above 0 mN, got {loads!r}")
    if press == "lines" and mechanics == "asperities":
        around = _around(given, AROUND, LOAD_STEPS)
    elif press == "lines":
        around = _around(given, AROUND_HALF_SPACE, HALF_SPACE_STEPS)
    else:
        below = given.min() / AROUND_AREAS ** np.arange(1, lighter + 1)
        around = np.unique(np.concatenate([_filled(given), below, [given.max() * AROUND_AREAS]]))
    # Those that are asked for stay to the bit, the others are written in few digits.
    asked = set(given.tolist())
    short = np.array([load if load in asked else float(f"{load:.6g}") for load in around.tolist()])
    lowest, highest = MAGNITUDES["force"]
    short = short[(lowest <= short) & (short <= highest)]
    return short if most is None else short[short < most]
