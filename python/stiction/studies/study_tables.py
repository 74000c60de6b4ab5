"""The tables of a study file, and which keys belong to which surfaces and mechanics."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, cast, get_args

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag, create_model, model_validator
from pydantic_core import PydanticCustomError

from stiction._checks import Floats
from stiction._units import quantity
from stiction.mechanics.half_space import Boundary
from stiction.mechanics.law import LAWS, NAMED, Law, LawName
from stiction.mechanics.model import ContactModel, Curvature, Detection, Direction, Shear, Sliding
from stiction.studies.study_values import (
    LIST,
    MOST_VALUES,
    NAME,
    RANGE,
    Approaches,
    ApproachRange,
    Coefficients,
    DimensionRange,
    Dimensions,
    Directions,
    Extent,
    Length,
    Lengths,
    LoadRange,
    Loads,
    Modulus,
    Rules,
    Share,
    Side,
    Strengths,
    Table,
    array_of,
    as_tuple,
    degrees_of,
    range_or_list,
)
from stiction.surfaces.fractal import Convention
from stiction.surfaces.profile import FEWEST_POINTS, MOST_POINTS, AmplitudeMeasure
from stiction.surfaces.spectrum import ROUND_UP
from stiction.surfaces.surface import SurfaceAmplitude

WM, SELF_AFFINE = "weierstrass-mandelbrot", "self-affine"

_WORDS = {
    "profile": "profiles",
    WM: "Weierstrass-Mandelbrot surfaces",
    SELF_AFFINE: "self-affine surfaces",
    "asperities": "asperities",
    "half-space": "the half-space",
}
"""The cases that a table may be of."""

_KEYS = {
    "points": ("profile",),
    "generator": (WM, SELF_AFFINE),
    "shape": (WM, SELF_AFFINE),
    "length_scale": ("profile", WM),
    "gamma": ("profile", WM),
    "directions": ("profile", WM),
    "frequencies": ("profile", WM),
    "band_limit": ("profile", WM),
    "longest_wavelength": (SELF_AFFINE,),
    "shortest_wavelength": (SELF_AFFINE,),
    "law": ("asperities",),
    "detection": ("asperities",),
    "curvature": ("asperities",),
    "approach": ("asperities",),
    "load": ("half-space",),
    "boundary": ("half-space",),
    "hardness": ("half-space",),
    "compliance_share": ("half-space",),
}
"""Keys that belong to some cases only."""

LATER = {"kind": "profile", "mechanics": "asperities", "sliding": "opposing"}
"""Keys that came later, with what studies are that do not have them: they are left out of such texts."""


def belongs(key: str, case: str) -> bool:
    """Whether a table of that case has the key."""
    return case in _KEYS.get(key, (case,))


def _check_keys(given: Mapping[str, Any], case: str) -> None:
    for key, value in given.items():
        if value is not None and case in _WORDS and not belongs(key, case):
            owners = " and ".join(_WORDS[each] for each in _KEYS[key])
            raise PydanticCustomError("key", "belongs to {owners}, not to {case}", {
                "key": key, "owners": owners, "case": _WORDS[case],
            })  # fmt: skip


def _fault_at(key: str, message: str) -> PydanticCustomError:
    return PydanticCustomError("key", "{message}", {"key": key, "message": message})


class Surfaces(Table):
    """Pairs of fractal profiles, or of surfaces."""

    kind: Literal["profile", "surface"] = Field(
        default="profile", description="What is pressed together: lines or areas."
    )
    generator: Literal["weierstrass-mandelbrot", "self-affine"] = Field(
        default="weierstrass-mandelbrot",
        description="The paper's Eq. 1 over an area, or Gaussian roughness with a power-law spectrum.",
    )
    fractal_dimension: Annotated[
        Annotated[DimensionRange, Tag(RANGE)] | Annotated[Dimensions, Tag(LIST)], range_or_list
    ] = Field(
        default=DimensionRange(start=1.0, stop=1.7, count=50),
        description="D, in the measure of `convention`; of surfaces that of a section.",
    )
    amplitude: Lengths = Field(
        default=(quantity("0.1 um", "length"),),
        description="Height that each profile or surface is scaled to, in the measure of `amplitude_measure`.",
    )
    amplitude_measure: AmplitudeMeasure | SurfaceAmplitude = Field(
        default="height",
        description="Which height the amplitude is: total, mean (Ra, Sa) or root mean square (Rq, Sq).",
    )
    length_scale: Length = Field(
        default=quantity("1 um", "length"), description="L of Eq. 1, the scale of its longest waves."
    )
    longest_wavelength: Length | None = Field(
        default=None, description="Roll-off of the spectrum: the longer side unless given."
    )
    shortest_wavelength: Length | None = Field(
        default=None, description="Cut-off of the spectrum: twice the larger spacing unless given."
    )
    extent: Extent = Field(
        default=quantity("40 um", "length"),
        description='Length of a profile, or of surfaces the lengths along y and x, `["10 um", "10 um"]` unless given.',
    )
    points: int = Field(
        default=150_000,
        ge=FEWEST_POINTS,
        le=MOST_POINTS,
        description="Points of a profile; the spacing is the extent over the points.",
    )
    shape: Annotated[tuple[Side, Side], as_tuple] = Field(
        default=(512, 512), description="Rows and columns of a surface."
    )
    gamma: float = Field(default=1.5, gt=1, description="Ratio of neighbouring frequencies in Eq. 1.")
    directions: int = Field(default=40, ge=1, le=MOST_VALUES, description="M of Eq. 1: directions of its waves.")
    frequencies: int = Field(
        default=40, ge=1, le=MOST_VALUES, description="n_max of Eq. 1: frequencies of each direction."
    )
    convention: Convention = Field(
        default="paper",
        description="The paper's D, H = 4 - 2D, or the textbooks', H = 2 - D, which self-affine surfaces have.",
    )
    band_limit: Literal["none", "nyquist"] = Field(
        default="none",
        description="Whether waves that the grid cannot carry fold back, as in the paper, or are left out.",
    )

    @model_validator(mode="before")
    @classmethod
    def _with_defaults_of_its_kind(cls, given: Any) -> Any:
        if not isinstance(given, Mapping):
            return given
        case = _case_of(given)
        _check_keys(given, case)
        defaults: dict[str, Any] = {}
        if case in (WM, SELF_AFFINE):
            defaults["extent"] = ["10 um", "10 um"]
        if case == SELF_AFFINE:
            defaults["convention"] = "classical"
        return defaults | dict(given)

    @model_validator(mode="after")
    def _is_of_its_kind(self) -> Surfaces:
        measures = AmplitudeMeasure if self.kind == "profile" else SurfaceAmplitude
        if self.amplitude_measure not in get_args(measures):
            allowed = ", ".join(f'"{each}"' for each in get_args(measures))
            raise _fault_at("amplitude_measure", f'must be one of {allowed}, got "{self.amplitude_measure}"')
        pair = isinstance(self.extent, tuple)
        if pair != (self.kind == "surface"):
            wanted = "one length" if pair else 'two lengths, along y and x, as in ["10 um", "10 um"]'
            raise _fault_at("extent", f"of {_WORDS[self.case]} must be {wanted}")
        if self.kind == "surface" and self.shape[0] * self.shape[1] > MOST_POINTS:
            raise _fault_at("shape", f"must hold at most {MOST_POINTS} points, got {list(self.shape)}")
        if self.case == SELF_AFFINE:
            if self.convention != "classical":
                raise _fault_at(
                    "convention", f'of self-affine surfaces must be "classical": H = 2 - D, got "{self.convention}"'
                )
            self._check_wavelengths()
        return self

    def _check_wavelengths(self) -> None:
        longer, finest, longest = max(self.extents()), 2 * max(self.spacings()), self.longest()
        shortest = finest if self.shortest_wavelength is None else float(self.shortest_wavelength)
        if longest > longer * ROUND_UP:
            raise _fault_at("longest_wavelength", f"must be at most the longer side, {longer:g} um, got {longest:g} um")
        if shortest * ROUND_UP < finest:
            raise _fault_at(
                "shortest_wavelength", f"must be at least twice the larger spacing, {finest:g} um, got {shortest:g} um"
            )
        if not shortest < longest:
            raise _fault_at("shortest_wavelength", f"must be below the longest, {longest:g} um, got {shortest:g} um")

    @property
    def case(self) -> str:
        """What the surfaces are, of the three that there are."""
        return _case_of(vars(self))

    def longest(self) -> float:
        """The longest wavelength, µm: that of Eq. 1, or of self-affine surfaces."""
        if self.case != SELF_AFFINE:
            return float(self.length_scale)
        return max(self.extents()) if self.longest_wavelength is None else float(self.longest_wavelength)

    def extents(self) -> tuple[float, float]:
        """Lengths of surfaces along y and x, µm."""
        along_y, along_x = cast("tuple[float, float]", self.extent)
        return float(along_y), float(along_x)

    def spacings(self) -> tuple[float, float]:
        """Distances between rows and between columns of surfaces, µm."""
        (along_y, along_x), (rows, columns) = self.extents(), self.shape
        return along_y / rows, along_x / columns

    def fractal_dimensions(self) -> Floats:
        """All values of the fractal dimension."""
        return array_of(self.fractal_dimension)

    def amplitudes(self) -> Floats:
        """All amplitudes, µm."""
        return array_of(self.amplitude)


def _case_of(given: Mapping[str, Any]) -> str:
    """What surfaces are that a table says."""
    if given.get("kind", "profile") == "profile":
        return "profile"
    return str(given.get("generator", WM))


class LawTable(Table):
    """A contact law with its parameters; of each law that has some there is a subclass, made from its fields."""

    def law(self) -> Law:
        """The law itself."""
        kind = next(law for law in LAWS if law.name == getattr(self, "name", None))
        return kind(**{each.name: float(getattr(self, each.name)) for each in dataclasses.fields(kind)})


_KINDS: dict[str, Any] = {"µm": Length, "GPa": Modulus}


def _table_of(law: type[Law]) -> type[LawTable]:
    def entry(parameter: dataclasses.Field[Any]) -> Any:
        given = parameter.metadata
        kind = _KINDS.get(given["unit"]) or Annotated[float, Field(ge=given["least"], le=given["most"])]
        return kind, ...

    name: Any = Literal[law.name]
    entries: dict[str, Any] = {"name": (name, ...)} | {each.name: entry(each) for each in dataclasses.fields(law)}
    return create_model(f"{law.__name__}Table", __base__=LawTable, __doc__=law.__doc__, **entries)


_LAW_TABLES = {law.name: _table_of(law) for law in LAWS if dataclasses.fields(law)}


def _kind_of_law(value: object) -> str | None:
    if isinstance(value, str):
        return NAME
    name = value.get("name") if isinstance(value, Mapping) else getattr(value, "name", None)
    return name if name in _LAW_TABLES else None


_law = Discriminator(
    _kind_of_law,
    custom_error_type="law",
    custom_error_message="must be "
    + " or ".join(f'"{name}"' for name in NAMED)
    + ", or a table of name "
    + " or ".join(f'"{name}" ({", ".join(list(table.model_fields)[1:])})' for name, table in _LAW_TABLES.items()),
)
# For the type checker a law is one of two; for pydantic it is a name or one of the tables.
if TYPE_CHECKING:
    LawEntry = LawName | LawTable
else:
    LawEntry = Annotated[
        Union[Annotated[LawName, Tag(NAME)], *(Annotated[table, Tag(name)] for name, table in _LAW_TABLES.items())],
        _law,
    ]


class Contact(Table):
    """How a pair is pressed together."""

    mechanics: Literal["asperities", "half-space"] = Field(
        default="asperities", description="Hertzian contacts that do not interact, or the elastic half-space."
    )
    effective_modulus: Modulus = Field(
        default=quantity("10 GPa", "pressure"), description="E*, the elasticity of both bodies."
    )
    law: LawEntry = Field(
        default="hertz-sphere",
        description='What a contact carries; `{ name = "jackson-green", yield_strength = ..., poisson_ratio = ... }`.',
    )
    detection: Detection = Field(
        default="cell",
        description="What counts as a contact: the paper's criterion, or minima of the gap, the default on surfaces.",
    )
    curvature: Curvature = Field(
        default="convex",
        description="Whether both bodies must be convex where they touch, or only relatively, the default on surfaces.",
    )
    shear: Shear = Field(default="+x", description="Where the upper body is about to move along a profile.")
    direction: Directions = Field(
        default=None,
        description="The same in place of `shear`; on surfaces also degrees from +x towards +y, or a list.",
    )
    sliding: Rules = Field(
        default="opposing",
        description="Which contacts rub: those that oppose the motion, as in the paper, or all; or a list of both.",
    )
    approach: Annotated[Annotated[ApproachRange, Tag(RANGE)] | Annotated[Approaches, Tag(LIST)], range_or_list] = Field(
        default=ApproachRange(start=quantity("0.1 nm", "length"), stop=quantity("40 nm", "length"), count=40),
        description="How far the bodies are pressed together.",
    )

    load: Annotated[Annotated[LoadRange, Tag(RANGE)] | Annotated[Loads, Tag(LIST)], range_or_list] = Field(
        default=LoadRange(start=quantity("0.01 mN", "force"), stop=quantity("1 mN", "force"), count=8),
        description="Elastic normal loads to press the bodies to.",
    )
    boundary: Boundary = Field(
        default="free", description="What lies beyond the edges: nothing, or the same surfaces again."
    )
    hardness: Modulus | None = Field(
        default=None, description="The largest pressure of the half-space; none is elastic."
    )
    compliance_share: Share = Field(default=0.5, description="The lower body's share of the compliance.")

    @model_validator(mode="before")
    @classmethod
    def _has_keys_of_its_mechanics(cls, given: Any) -> Any:
        if isinstance(given, Mapping):
            _check_keys(given, str(given.get("mechanics", "asperities")))
        return given

    @model_validator(mode="after")
    def _has_one_direction_of_motion(self) -> Contact:
        if self.direction is not None and self.shear != "+x":
            raise _fault_at("direction", f'must not be given beside shear, got "{self.shear}" for that')
        return self

    def model(self, sliding: Sliding | None = None) -> ContactModel:
        """What `press` takes, under one of the sliding rules, by default the first."""
        return ContactModel(
            effective_modulus=float(self.effective_modulus),
            law=self.law if isinstance(self.law, str) else self.law.law(),
            detection=self.detection,
            curvature=self.curvature,
            shear=self.shear,
            direction=self.direction,
            sliding=sliding or self.rules()[0],
        )

    def rules(self) -> tuple[Sliding, ...]:
        """Every sliding rule."""
        return self.sliding if isinstance(self.sliding, tuple) else (self.sliding,)

    def ways(self) -> tuple[Direction, ...]:
        """Every direction, whichever key says it."""
        given = self.shear if self.direction is None else self.direction
        return given if isinstance(given, tuple) else (given,)

    def degrees(self) -> Floats:
        """Every direction, from +x towards +y."""
        return np.array([degrees_of(way) for way in self.ways()])

    @property
    def step(self) -> str:
        """What a pair is pressed to, one after the other: "approach" or "load"."""
        return "approach" if self.mechanics == "asperities" else "load"

    def steps(self) -> Floats:
        """All approaches (µm) or loads (mN)."""
        return array_of(self.approach if self.mechanics == "asperities" else self.load)

    def approaches(self) -> Floats:
        """All approaches, µm."""
        return array_of(self.approach)


class Friction(Table):
    """Molecular friction coefficients and adhesive shear strengths that the figures show."""

    mu0: Coefficients = Field(
        default=(0.1, 0.4, 1.0), description="Molecular friction coefficients that the figures show."
    )
    tau0: Strengths = Field(
        default=tuple(quantity(f"{tau0} MPa", "pressure") for tau0 in ("0", "0.5", "10", "100", "200")),
        description="Adhesive shear strengths that the figures show.",
    )


class Ensemble(Table):
    """How many pairs, and where their random numbers start."""

    repetitions: int = Field(
        default=100, ge=1, le=100_000_000, description="Pairs for each fractal dimension and amplitude."
    )
    seed: int = Field(
        default=2016,
        ge=0,
        lt=2**63,
        description="Where the random numbers start; the same seed gives the same surfaces.",
    )


FigureName = Literal["profiles", "length-scales", "friction", "area"]


def _distinct(names: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"must name each figure once, but {name!r} is there {names.count(name)} times")
    return names


class Figures(Table):
    """What is drawn of the result."""

    draw: Annotated[tuple[FigureName, ...], as_tuple, AfterValidator(_distinct)] = Field(
        default=("friction", "area"), description="Which figures `run` and `plot` draw."
    )
