"""The table `[contact]` of a study: a class for each contact model on each kind of surfaces."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, PlainSerializer, PlainValidator, model_validator

from stiction._checks import Floats, float_array
from stiction._units import MAGNITUDES, exact_quantity, quantity, short_repr
from stiction.mechanics.half_space import ADHESION_RANGE, Boundary, Tilt
from stiction.mechanics.law import LAWS_BY_NAME, HertzCylinder, JacksonGreen, Law, LawName, as_law
from stiction.mechanics.model import THICKNESS, ContactModel, Curvature, Detection, Direction, Shear, Sliding
from stiction.studies.generated_surfaces import Generated, Profiles
from stiction.studies.input_uncertainty import MAX_GROWTH
from stiction.studies.measured_surfaces import Measured
from stiction.studies.values import (
    ApproachesOrRange,
    ApproachRange,
    Case,
    Directions,
    Fraction,
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
    check_keys,
    chosen,
    degrees_of,
    fault_at,
    written,
)

DEFAULT_DIRECTIONS = tuple(30.0 * step for step in range(12))  # of measured areas, degrees
MAX_DIRECTIONS = 360  # largest number of directions of measured areas
LINE_LOAD_FACTOR = 30.0  # ratio of the outermost loads of a curve to the requested loads, lines by asperities
LOAD_STEPS = 25
HALF_SPACE_LOAD_FACTOR = 10.0  # as `LINE_LOAD_FACTOR`, of half-planes, where each load takes a solution
HALF_SPACE_STEPS = 7
AREAL_LOAD_FACTOR = 10**0.5  # ratio of the loads that are asked for to the one below and the one above them, of areas


# ---- Laws -----------------------------------------------------------------------------------------------------------


class HertzCylinderTable(Table):
    """The law of elastic cylinders with their width."""

    name: Literal["hertz-cylinder"]
    width: Length

    def law(self) -> HertzCylinder:
        """Return the law."""
        return HertzCylinder(width=float(self.width))


class JacksonGreenTable(Table):
    """The law of Jackson and Green with the yield strength and Poisson's ratio of the softer body."""

    name: Literal["jackson-green"]
    yield_strength: Modulus
    poisson_ratio: Annotated[float, Field(ge=0, le=0.5)]

    def law(self) -> JacksonGreen:
        """Return the law."""
        return JacksonGreen(yield_strength=float(self.yield_strength), poisson_ratio=self.poisson_ratio)


LawTable = HertzCylinderTable | JacksonGreenTable
LAW_TABLES: dict[str, type[LawTable]] = {"hertz-cylinder": HertzCylinderTable, "jackson-green": JacksonGreenTable}
"""Tables of laws with parameters, by their key `name`."""


def _read_law(value: object) -> LawName | LawTable:
    """Read a law from its name, or from a table of its parameters."""
    for name in LAWS_BY_NAME:
        if value == name:
            return name  # type: ignore[return-value]
    if isinstance(value, LawTable):
        return value
    table = LAW_TABLES.get(str(value.get("name"))) if isinstance(value, Mapping) else None
    if table is None:
        names = " or ".join(f'"{name}"' for name in LAWS_BY_NAME)
        tables = " or ".join(
            f'"{name}" ({", ".join(list(table.model_fields)[1:])})' for name, table in LAW_TABLES.items()
        )
        raise ValueError(f"must be {names}, or a table of name {tables}, got {short_repr(value)}")
    return table.model_validate(value)


def _write_law(law: LawName | LawTable) -> object:
    return law if isinstance(law, str) else law.model_dump()


LawEntry = Annotated[LawName | LawTable, PlainValidator(_read_law), PlainSerializer(_write_law)]


def law_entry(law: Law | LawName) -> LawName | LawTable:
    """Return a law as a study has it."""
    law = as_law(law)
    if isinstance(law, HertzCylinder):
        return HertzCylinderTable(name="hertz-cylinder", width=exact_quantity(law.width, "um"))
    if isinstance(law, JacksonGreen):
        strength = exact_quantity(law.yield_strength, "GPa")
        return JacksonGreenTable(name="jackson-green", yield_strength=strength, poisson_ratio=law.poisson_ratio)
    return law.name  # type: ignore[return-value]


# ---- Contacts -------------------------------------------------------------------------------------------------------

_Name = Annotated[str, Field(min_length=1, max_length=80)]
_Ratio = Annotated[float, Field(gt=-1, le=0.5)]
DetectionKey = Annotated[
    Detection,
    Field(description="What counts as a contact: the paper's criterion, or minima of the gap, which is all of areas."),
]
CurvatureKey = Annotated[
    Curvature, Field(description="Whether both bodies must be convex where they touch, or only relatively.")
]
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


DIRECTION = (
    "Where the upper body is about to move, in place of `shear`; of areas also degrees from +x towards +y, or a list."
)
LOAD = "Elastic normal loads to press the bodies to; of measured ones loads around `friction.load` unless given."


class ContactTable(Case):
    """How a pair is pressed together, by any contact model on any kind of surfaces."""

    effective_modulus: Modulus = Field(
        default=quantity("10 GPa", "pressure"), description="E*, the elasticity of both bodies."
    )

    @property
    def step(self) -> Literal["approach", "load"]:
        """What a pair is pressed to, one after the other."""
        return "load"

    def steps(self) -> Floats:
        """All approaches, µm, or loads, mN."""
        raise NotImplementedError

    def rules(self) -> tuple[Sliding, ...]:
        """Every sliding rule."""
        raise NotImplementedError

    def ways(self) -> tuple[Direction, ...]:
        """Every direction of motion, whichever key says it."""
        raise NotImplementedError

    def degrees(self) -> Floats:
        """Every direction of motion, from +x towards +y."""
        return np.array([degrees_of(way) for way in self.ways()])

    def motions(self) -> dict[str, list[Any]]:
        """Sliding rules and directions (degrees) of which there is a list: more dimensions of what depends on them."""
        return {"sliding": list(self.rules()), "direction": self.degrees().tolist()}


# ---- Keys by the kind of surfaces -----------------------------------------------------------------------------------


class GeneratedContact(ContactTable):
    """Keys of the motion of generated surfaces."""

    place: ClassVar[str] = "generated surfaces"
    materials: ClassVar[None] = None
    poisson_ratio: ClassVar[None] = None

    shear: Shear = Field(default="+x", description="Where the upper body is about to move along a profile.")
    direction: Directions = Field(default=None, description=DIRECTION)
    sliding: Rules = Field(
        default="opposing",
        description="Which contacts rub: those that oppose the motion, as in the paper, or all; or a list of both.",
    )

    @model_validator(mode="after")
    def _has_one_direction_of_motion(self) -> Self:
        if self.direction is not None and self.shear != "+x":
            raise fault_at("direction", f'must not be given beside shear, got "{self.shear}" for that')
        return self

    def rules(self) -> tuple[Sliding, ...]:
        """Every sliding rule."""
        return self.sliding if isinstance(self.sliding, tuple) else (self.sliding,)

    def ways(self) -> tuple[Direction, ...]:
        """Every direction of motion, whichever key says it."""
        chosen = self.shear if self.direction is None else self.direction
        return chosen if isinstance(chosen, tuple) else (chosen,)

    def motions(self) -> dict[str, list[Any]]:
        """Sliding rules and directions (degrees) that are given as lists."""
        several = {"sliding": isinstance(self.sliding, tuple), "direction": isinstance(self.direction, tuple)}
        return {name: values for name, values in super().motions().items() if several[name]}


class GeneratedLoads(GeneratedContact):
    """The load curve of generated surfaces."""

    place: ClassVar[str] = "the half-space of generated surfaces"

    load: LoadsOrRange = Field(
        default=LoadRange(start=quantity("0.01 mN", "force"), stop=quantity("1 mN", "force"), count=8), description=LOAD
    )

    def steps(self) -> Floats:
        """All loads, mN."""
        return array_of(self.load)


class MeasuredContact(ContactTable):
    """Keys of measured surfaces, which are pressed to loads and moved both ways by both sliding rules."""

    place: ClassVar[str] = "measured surfaces"

    load: LoadsOrRange = Field(description=LOAD)
    materials: TwoNames | None = Field(
        default=None, description="Names of what the upper and the lower body are made of; they change nothing."
    )
    poisson_ratio: TwoRatios | None = Field(
        default=None, description="Of the upper and the lower body, for the onset of sliding; 0.3 of both unless given."
    )

    def steps(self) -> Floats:
        """All loads, mN."""
        return array_of(self.load)

    def rules(self) -> tuple[Sliding, ...]:
        """Both sliding rules."""
        return "all", "opposing"


class MeasuredLinesContact(MeasuredContact):
    """Lines of measured bodies, which are moved both ways."""

    place: ClassVar[str] = "measured lines"

    def ways(self) -> tuple[Direction, ...]:
        """Both directions of motion."""
        return "+x", "-x"


class MeasuredAreasContact(MeasuredContact):
    """Keys of measured areas, which are moved in several directions."""

    place: ClassVar[str] = "measured areas"

    direction: Directions = Field(default=DEFAULT_DIRECTIONS, description=DIRECTION)

    def ways(self) -> tuple[Direction, ...]:
        """Every direction of motion."""
        assert self.direction is not None
        return self.direction if isinstance(self.direction, tuple) else (self.direction,)


class HalfSpace(ContactTable):
    """Contact by the elastic half-space."""

    place: ClassVar[str] = "the half-space"
    law: ClassVar[None] = None
    onset: ClassVar[None] = None

    mechanics: Literal["half-space"] = Field(default="half-space", description="The elastic half-space.")
    boundary: Boundary = Field(
        default="free", description="What lies beyond the edges: nothing, or the same surfaces again."
    )
    hardness: Modulus | None = Field(
        default=None, description="The largest pressure of the half-space; none is elastic."
    )
    junction_growth: float | None = Field(
        default=None,
        ge=0,
        le=MAX_GROWTH,
        description="α of p² + α s² = H², by which plastic contacts grow under shear; none is 0, with a caveat.",
    )
    compliance_share: Fraction = Field(default=0.5, description="The lower body's fraction of the compliance.")
    work_of_adhesion: WorkOfAdhesion | None = Field(
        default=None, description="Energy that parts an area in contact; none is not known, and taken as 0."
    )
    adhesion_range: Length | None = Field(
        default=None, description="Gap over which the attraction falls off by 1/e; 0.5 nm unless given."
    )

    tilt: Tilt = Field(
        default="fixed",
        description="Whether the upper of free bodies keeps its orientation, or turns until the load is in the middle.",
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

    place: ClassVar[str] = "asperities"
    hardness: ClassVar[None] = None
    junction_growth: ClassVar[None] = None
    work_of_adhesion: ClassVar[None] = None
    adheres: ClassVar[bool] = False

    mechanics: Literal["asperities"] = Field(
        default="asperities", description="Hertzian contacts that do not interact."
    )
    law: LawEntry = Field(
        default="hertz-sphere",
        description='What a contact carries; `{ name = "jackson-green", yield_strength = ..., poisson_ratio = ... }`.',
    )
    detection: DetectionKey = "gap-minimum"
    curvature: CurvatureKey = "convex"

    def motion(self) -> dict[str, Any]:
        """Return the direction that a contact model takes, of loads none."""
        return {}

    def model(self, sliding: Sliding | None = None) -> ContactModel:
        """What `press` takes, under one of the sliding rules, by default the first."""
        return ContactModel(
            effective_modulus=float(self.effective_modulus),
            law=self.law if isinstance(self.law, str) else self.law.law(), detection=self.detection,
            curvature=self.curvature, sliding=sliding or self.rules()[0], **self.motion(),
        )  # fmt: skip


# ---- Each contact model on each kind of surfaces ---------------------------------------------------------------------


class GeneratedAsperities(Asperities, GeneratedContact):
    """Asperities of generated surfaces, pressed to approaches."""

    place: ClassVar[str] = "asperities of generated surfaces"

    approach: ApproachesOrRange = Field(
        default=ApproachRange(start=quantity("0.1 nm", "length"), stop=quantity("40 nm", "length"), count=40),
        description="How far the bodies are pressed together.",
    )
    onset: OnsetTable | None = Field(
        default=None,
        description="Whether it is kept how each pair begins to slide, and at which strengths, as in `{ mu0 = 0.4 }`.",
    )

    @model_validator(mode="after")
    def _has_an_onset(self) -> Self:
        if self.onset is not None and isinstance(as_law(self.model().law), HertzCylinder):
            raise fault_at("onset", "must not be given with cylinders: a line load moves far points without limit")
        return self

    @property
    def step(self) -> Literal["approach", "load"]:
        """What a pair is pressed to, one after the other."""
        return "approach"

    def steps(self) -> Floats:
        """All approaches, µm."""
        return array_of(self.approach)

    def motion(self) -> dict[str, Any]:
        """Return the direction that a contact model takes."""
        return {"shear": self.shear, "direction": self.direction}


class AsperitiesOfGeneratedLines(GeneratedAsperities):
    """Asperities of generated profiles."""

    place: ClassVar[str] = "asperities of generated lines"

    detection: DetectionKey = "cell"


class AsperitiesOfGeneratedAreas(GeneratedAsperities):
    """Asperities of generated surfaces."""

    place: ClassVar[str] = "asperities of generated areas"

    curvature: CurvatureKey = "signed"


class AsperitiesOfMeasuredLines(Asperities, MeasuredLinesContact):
    """Asperities of lines of measured bodies."""

    place: ClassVar[str] = "asperities of measured lines"
    onset: ClassVar[None] = None


class AsperitiesOfMeasuredAreas(Asperities, MeasuredAreasContact):
    """Asperities of measured height maps."""

    place: ClassVar[str] = "asperities of measured areas"
    onset: ClassVar[None] = None

    curvature: CurvatureKey = "signed"


class HalfSpaceOfGeneratedLines(HalfSpace, GeneratedLoads):
    """Half-planes of generated profiles."""

    place: ClassVar[str] = "the half-space of generated lines"


class HalfSpaceOfGeneratedAreas(HalfSpace, GeneratedLoads):
    """Half-spaces of generated surfaces."""

    place: ClassVar[str] = "the half-space of generated areas"


class HalfSpaceOfMeasuredLines(HalfSpace, MeasuredLinesContact):
    """Half-planes of lines of measured bodies."""

    place: ClassVar[str] = "the half-space of measured lines"


class HalfSpaceOfMeasuredAreas(HalfSpace, MeasuredAreasContact):
    """Half-spaces of measured height maps."""

    place: ClassVar[str] = "the half-space of measured areas"


Contact = (
    AsperitiesOfGeneratedLines
    | AsperitiesOfGeneratedAreas
    | AsperitiesOfMeasuredLines
    | AsperitiesOfMeasuredAreas
    | HalfSpaceOfGeneratedLines
    | HalfSpaceOfGeneratedAreas
    | HalfSpaceOfMeasuredLines
    | HalfSpaceOfMeasuredAreas
)
"""The table `[contact]` of a study."""

CONTACTS: dict[str, dict[str, type[Contact]]] = {
    "generated lines": {"asperities": AsperitiesOfGeneratedLines, "half-space": HalfSpaceOfGeneratedLines},
    "generated areas": {"asperities": AsperitiesOfGeneratedAreas, "half-space": HalfSpaceOfGeneratedAreas},
    "measured lines": {"asperities": AsperitiesOfMeasuredLines, "half-space": HalfSpaceOfMeasuredLines},
    "measured areas": {"half-space": HalfSpaceOfMeasuredAreas, "asperities": AsperitiesOfMeasuredAreas},
}
"""Cases of the table by the bodies and by the key `mechanics`, the first of which is the default."""

SHARED: tuple[type[ContactTable], ...] = (
    Asperities, GeneratedAsperities, MeasuredContact, GeneratedContact, MeasuredAreasContact, HalfSpace, GeneratedLoads,
)  # fmt: skip
"""Classes of keys that several cases share, by whose names messages say where a key belongs."""


def contact_case(surfaces: type[Generated | Measured], table: Mapping[str, Any]) -> type[Contact]:
    """Return the case of a table by the surfaces and its key `mechanics`."""
    cases = CONTACTS[surfaces.bodies]
    return cases[chosen("mechanics", table, cases)]


def read_contact(value: Mapping[str, Any], surfaces: Generated | Measured) -> Contact:
    """Read a table that goes with the surfaces."""
    case = contact_case(type(surfaces), value)
    check_keys(value, case, SHARED)
    contact = case.model_validate(value)
    if isinstance(contact, MeasuredAreasContact):
        direction = contact.direction
        if direction is None or len(contact.ways()) > MAX_DIRECTIONS:
            raise fault_at("direction", f"must be from 1 to {MAX_DIRECTIONS} directions, got {short_repr(direction)}")
        contact = contact.model_copy(update={"direction": tuple(contact.degrees().tolist())})
    is_profile = isinstance(surfaces, Profiles)
    if is_profile and isinstance(contact, GeneratedContact) and contact.direction not in (None, "+x", "-x"):
        raise fault_at("direction", f'must be "+x" or "-x" on profiles, got {short_repr(contact.direction)}')
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
    """Return given loads (mN) with others between, in equal ratios of at most `AREAL_LOAD_FACTOR` and a little more."""
    given = np.unique(given)
    steps = np.ceil(np.log(given[1:] / given[:-1]) / np.log(1.01 * AREAL_LOAD_FACTOR)).astype(int)
    between = [
        np.geomspace(low, high, count, endpoint=False)[1:]
        for low, high, count in zip(given[:-1], given[1:], steps, strict=True)
    ]
    return np.concatenate([given, *between])


def ladder(loads: ArrayLike, *, press: str, mechanics: str, most: float | None = None, lighter: int = 1) -> Floats:
    """Return loads (mN) to solve a measured pair at, all below `most`: the given ones, and others around and between.

    Areas get `lighter` loads below the given loads, and intermediate loads in ratios of at most `AREAL_LOAD_FACTOR`.
    """
    given = np.atleast_1d(float_array("loads", loads))
    if not given.size or not (given > 0).all():
        raise ValueError(f"loads must be above 0 mN, got {loads!r}")
    if press == "lines" and mechanics == "asperities":
        around = _around(given, LINE_LOAD_FACTOR, LOAD_STEPS)
    elif press == "lines":
        around = _around(given, HALF_SPACE_LOAD_FACTOR, HALF_SPACE_STEPS)
    else:
        below = given.min() / AREAL_LOAD_FACTOR ** np.arange(1, lighter + 1)
        around = np.unique(np.concatenate([_filled(given), below, [given.max() * AREAL_LOAD_FACTOR]]))
    # Those that are asked for stay to the bit, the others are written in few digits.
    asked = set(given.tolist())
    short = np.array([load if load in asked else float(f"{load:.6g}") for load in around.tolist()])
    lowest, highest = MAGNITUDES["force"]
    short = short[(lowest <= short) & (short <= highest)]
    return short if most is None else short[short < most]
