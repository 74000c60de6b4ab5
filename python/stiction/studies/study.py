"""What to compute: a study, validated, from a TOML file or the built-in library."""

from __future__ import annotations

import dataclasses
import difflib
import itertools
import json
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, cast, get_args

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    PlainSerializer,
    PlainValidator,
    Tag,
    ValidationError,
    create_model,
    model_validator,
)
from pydantic_core import ErrorDetails, PydanticCustomError

from stiction._checks import Floats
from stiction._files import NotReadableError, content, reason
from stiction._text import LONGEST_NAME, LONGEST_WORD, named, printable
from stiction._units import Quantity, quantity, shortened
from stiction.mechanics.half_space import WIDTH, Boundary
from stiction.mechanics.law import LAWS, NAMED, Law, LawName
from stiction.mechanics.model import ContactModel, Curvature, Detection, Direction, Shear, Sliding
from stiction.mechanics.quantities import AREAL_SUMS, DIRECTED, HALF_SPACE_SUMS, SUMS
from stiction.surfaces.fractal import Convention
from stiction.surfaces.profile import FEWEST_POINTS, MOST_POINTS, AmplitudeMeasure
from stiction.surfaces.spectrum import ROUND_UP
from stiction.surfaces.surface import SurfaceAmplitude

if TYPE_CHECKING:
    import xarray

MOST_MEMORY = 16 * 2**30
"""Bytes of a result, which is held in memory."""

MOST_VALUES = 10_000
"""Of any one parameter of a study."""

LONGEST_FILE = 1_000_000
"""Bytes of a study file; a study is a page."""

MOST_HARMONICS = 1_000_000
"""Directions times frequencies, of which each takes a phase, and time at every point."""

MOST_PARTS = 20
"""Of a dotted key: those of a study have three, and a parser takes a time that grows with their square."""


class StudyError(ValueError):
    """A study that cannot be: one line per fault, each naming its key."""


# ---- Values ---------------------------------------------------------------------------------------------------------


def _reader(kind: str, *, zero: bool) -> PlainValidator:
    def read(text: object) -> Quantity:
        value = quantity(text, kind)
        if not (value > 0 or (zero and float(value) == 0)):
            raise ValueError(f"must be {'at least' if zero else 'above'} 0, got {value.text!r}")
        return value

    return PlainValidator(read)


def _text(value: float) -> str:
    return value.text if isinstance(value, Quantity) else f"{value:g}"


def _increasing(values: tuple[float, ...]) -> tuple[float, ...]:
    for previous, value in itertools.pairwise(values):
        if not value > previous:
            raise ValueError(f"must increase, but {_text(previous)} is followed by {_text(value)}")
    return values


_as_text = PlainSerializer(_text)
Length = Annotated[Quantity, _reader("length", zero=False), _as_text]
LengthOrZero = Annotated[Quantity, _reader("length", zero=True), _as_text]
Modulus = Annotated[Quantity, _reader("pressure", zero=False), _as_text]
Strength = Annotated[Quantity, _reader("pressure", zero=True), _as_text]
Force = Annotated[Quantity, _reader("force", zero=False), _as_text]
Share = Annotated[float, Field(ge=0, le=1)]
Side = Annotated[int, Field(ge=FEWEST_POINTS, le=MOST_POINTS)]
Dimension = Annotated[float, Field(ge=1, lt=2)]
Coefficient = Annotated[float, Field(ge=0)]

# TOML has lists; a study is immutable.
_as_tuple = BeforeValidator(lambda values: tuple(values) if isinstance(values, list) else values)
_values = (_as_tuple, Field(min_length=1, max_length=MOST_VALUES), AfterValidator(_increasing))
Dimensions = Annotated[tuple[Dimension, ...], *_values]
Lengths = Annotated[tuple[Length, ...], *_values]
Approaches = Annotated[tuple[LengthOrZero, ...], *_values]
Loads = Annotated[tuple[Force, ...], *_values]
Strengths = Annotated[tuple[Strength, ...], *_values]
Coefficients = Annotated[tuple[Coefficient, ...], *_values]


def _several(values: tuple[Any, ...], name: str, same: Any) -> tuple[Any, ...]:
    if not 1 <= len(values) <= MOST_VALUES:
        raise ValueError(f"must have from 1 to {MOST_VALUES} {name}s, got {len(values)}")
    if len({same(value) for value in values}) < len(values):
        raise ValueError(f"must have each {name} once, got {shortened(list(values))}")
    return values


def _read_extent(value: object) -> Quantity | tuple[Quantity, Quantity]:
    """A length, or two, along y and x."""
    one: Any = _reader("length", zero=False).func
    if not isinstance(value, (list, tuple)):
        return one(value)  # type: ignore[no-any-return]
    if len(value) != 2:
        raise ValueError(f"must be a length, or of surfaces two, along y and x, got {shortened(value)}")
    return one(value[0]), one(value[1])


def _read_direction(value: object) -> Any:
    """One direction, or a tuple of some."""

    def one(item: object) -> str | float:
        if isinstance(item, str) and item in ("+x", "-x"):
            return item
        if isinstance(item, (int, float)) and not isinstance(item, bool) and abs(item) <= MOST_DEGREES:
            return float(item)
        raise ValueError(
            f'must be "+x", "-x" or degrees from {-MOST_DEGREES} to {MOST_DEGREES}, or a list of these, '
            f"got {shortened(item)}"
        )

    if not isinstance(value, (list, tuple)):
        return None if value is None else one(value)
    return _several(tuple(one(item) for item in value), "direction", _degrees)


MOST_DEGREES = 360
"""Of a direction, to either side."""


def _degrees(direction: Direction) -> float:
    return {"+x": 0.0, "-x": 180.0}[direction] if isinstance(direction, str) else direction % 360.0


def _read_sliding(value: object) -> Any:
    """One sliding rule, or a tuple of some."""

    def one(item: object) -> str:
        if item not in ("opposing", "all"):
            raise ValueError(f'must be "opposing" or "all", or a list of both, got {shortened(item)}')
        return str(item)

    if not isinstance(value, (list, tuple)):
        return one(value)
    return _several(tuple(one(item) for item in value), "rule", str)


# For the type checker an extent is one length, which those of surfaces are not: `Surfaces.extents` is for them.
if TYPE_CHECKING:
    Extent = Quantity
    Directions = Direction | tuple[Direction, ...] | None
    Rules = Sliding | tuple[Sliding, ...]
else:
    Extent = Annotated[
        Any,
        PlainValidator(_read_extent),
        PlainSerializer(lambda value: list(map(_text, value)) if isinstance(value, tuple) else _text(value)),
    ]
    Directions = Annotated[Any, PlainValidator(_read_direction)]
    Rules = Annotated[Any, PlainValidator(_read_sliding)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, validate_default=True)


def _check_range(bounds: Any) -> None:
    if bounds.count == 1 and bounds.start != bounds.stop:
        raise ValueError("a range of count 1 must stop where it starts")
    if bounds.count > 1 and not bounds.stop > bounds.start:
        raise ValueError(f"must stop above its start, got {_text(bounds.start)} to {_text(bounds.stop)}")


class DimensionRange(_Table):
    """Equally spaced fractal dimensions, both ends included."""

    start: Dimension
    stop: Dimension
    count: int = Field(ge=1, le=MOST_VALUES)

    @model_validator(mode="after")
    def _is_a_range(self) -> DimensionRange:
        _check_range(self)
        return self

    def values(self) -> Floats:
        """(count,) array."""
        return np.linspace(self.start, self.stop, self.count)


class ApproachRange(_Table):
    """Approaches, both ends included, in equal steps (linear) or ratios (geometric)."""

    start: LengthOrZero
    stop: LengthOrZero
    count: int = Field(ge=1, le=MOST_VALUES)
    spacing: Literal["linear", "geometric"] = "geometric"

    @model_validator(mode="after")
    def _is_a_range(self) -> ApproachRange:
        _check_range(self)
        if self.spacing == "geometric" and float(self.start) == 0:
            raise ValueError("a geometric range cannot start at 0")
        return self

    def values(self) -> Floats:
        """(count,) array, µm."""
        space = np.geomspace if self.spacing == "geometric" else np.linspace
        return np.asarray(space(float(self.start), float(self.stop), self.count), dtype=np.float64)


class LoadRange(_Table):
    """Normal loads, both ends included, in equal steps (linear) or ratios (geometric)."""

    start: Force
    stop: Force
    count: int = Field(ge=1, le=MOST_VALUES)
    spacing: Literal["linear", "geometric"] = "geometric"

    @model_validator(mode="after")
    def _is_a_range(self) -> LoadRange:
        _check_range(self)
        return self

    def values(self) -> Floats:
        """(count,) array, mN."""
        space = np.geomspace if self.spacing == "geometric" else np.linspace
        return np.asarray(space(float(self.start), float(self.stop), self.count), dtype=np.float64)


# Which of a range or a list a value is, told before it is read, so that its faults are those of one kind.
_RANGE, _LIST, _NAME = "a range", "a list", "a name"
_TAGS = (_RANGE, _LIST, _NAME, *(law.name for law in LAWS))


def _range_or_list(value: object) -> str | None:
    if isinstance(value, (Mapping, _Table)):
        return _RANGE
    return _LIST if isinstance(value, (list, tuple)) else None


_either = Discriminator(
    _range_or_list,
    custom_error_type="range_or_list",
    custom_error_message="must be a list, or a table with start, stop and count",
)


def _array(values: DimensionRange | ApproachRange | LoadRange | tuple[float, ...]) -> Floats:
    return np.array(values, dtype=np.float64) if isinstance(values, tuple) else values.values()


# ---- Tables ---------------------------------------------------------------------------------------------------------


_WM, _SELF_AFFINE = "weierstrass-mandelbrot", "self-affine"

_WORDS = {
    "profile": "profiles",
    _WM: "Weierstrass-Mandelbrot surfaces",
    _SELF_AFFINE: "self-affine surfaces",
    "asperities": "asperities",
    "half-space": "the half-space",
}
"""The cases that a table may be of."""

_KEYS = {
    "points": ("profile",),
    "generator": (_WM, _SELF_AFFINE),
    "shape": (_WM, _SELF_AFFINE),
    "length_scale": ("profile", _WM),
    "gamma": ("profile", _WM),
    "directions": ("profile", _WM),
    "frequencies": ("profile", _WM),
    "band_limit": ("profile", _WM),
    "longest_wavelength": (_SELF_AFFINE,),
    "shortest_wavelength": (_SELF_AFFINE,),
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

_LATER = {"kind": "profile", "mechanics": "asperities", "sliding": "opposing"}
"""Keys that came later, with what studies are that do not have them: they are left out of such texts."""


def _belongs(key: str, case: str) -> bool:
    return case in _KEYS.get(key, (case,))


def _check_keys(given: Mapping[str, Any], case: str) -> None:
    for key, value in given.items():
        if value is not None and case in _WORDS and not _belongs(key, case):
            owners = " and ".join(_WORDS[each] for each in _KEYS[key])
            raise PydanticCustomError("key", "belongs to {owners}, not to {case}", {
                "key": key, "owners": owners, "case": _WORDS[case],
            })  # fmt: skip


def _fault_at(key: str, message: str) -> PydanticCustomError:
    return PydanticCustomError("key", "{message}", {"key": key, "message": message})


class Surfaces(_Table):
    """Pairs of fractal profiles, or of surfaces."""

    kind: Literal["profile", "surface"] = "profile"
    generator: Literal["weierstrass-mandelbrot", "self-affine"] = "weierstrass-mandelbrot"
    fractal_dimension: Annotated[
        Annotated[DimensionRange, Tag(_RANGE)] | Annotated[Dimensions, Tag(_LIST)], _either
    ] = DimensionRange(start=1.0, stop=1.7, count=50)
    amplitude: Lengths = (quantity("0.1 um", "length"),)
    amplitude_measure: AmplitudeMeasure | SurfaceAmplitude = "height"
    length_scale: Length = quantity("1 um", "length")
    longest_wavelength: Length | None = None
    shortest_wavelength: Length | None = None
    extent: Extent = quantity("40 um", "length")
    points: int = Field(default=150_000, ge=FEWEST_POINTS, le=MOST_POINTS)
    shape: Annotated[tuple[Side, Side], _as_tuple] = (512, 512)
    gamma: float = Field(default=1.5, gt=1)
    directions: int = Field(default=40, ge=1, le=MOST_VALUES)
    frequencies: int = Field(default=40, ge=1, le=MOST_VALUES)
    convention: Convention = "paper"
    band_limit: Literal["none", "nyquist"] = "none"

    @model_validator(mode="before")
    @classmethod
    def _with_defaults_of_its_kind(cls, given: Any) -> Any:
        if not isinstance(given, Mapping):
            return given
        case = _case_of(given)
        _check_keys(given, case)
        defaults: dict[str, Any] = {}
        if case in (_WM, _SELF_AFFINE):
            defaults["extent"] = ["10 um", "10 um"]
        if case == _SELF_AFFINE:
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
        if self.case == _SELF_AFFINE:
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
        if self.case != _SELF_AFFINE:
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
        return _array(self.fractal_dimension)

    def amplitudes(self) -> Floats:
        """All amplitudes, µm."""
        return _array(self.amplitude)


def _case_of(given: Mapping[str, Any]) -> str:
    """What surfaces are that a table says."""
    if given.get("kind", "profile") == "profile":
        return "profile"
    return str(given.get("generator", _WM))


class LawTable(_Table):
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
        return _NAME
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
        Union[Annotated[LawName, Tag(_NAME)], *(Annotated[table, Tag(name)] for name, table in _LAW_TABLES.items())],
        _law,
    ]


class Contact(_Table):
    """How a pair is pressed together."""

    mechanics: Literal["asperities", "half-space"] = "asperities"
    effective_modulus: Modulus = quantity("10 GPa", "pressure")
    law: LawEntry = "hertz-sphere"
    detection: Detection = "cell"
    curvature: Curvature = "convex"
    shear: Shear = "+x"
    direction: Directions = None
    sliding: Rules = "opposing"
    approach: Annotated[Annotated[ApproachRange, Tag(_RANGE)] | Annotated[Approaches, Tag(_LIST)], _either] = (
        ApproachRange(start=quantity("0.1 nm", "length"), stop=quantity("40 nm", "length"), count=40)
    )

    load: Annotated[Annotated[LoadRange, Tag(_RANGE)] | Annotated[Loads, Tag(_LIST)], _either] = LoadRange(
        start=quantity("0.01 mN", "force"), stop=quantity("1 mN", "force"), count=8
    )
    boundary: Boundary = "free"
    hardness: Modulus | None = None
    compliance_share: Share = 0.5

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
        return np.array([_degrees(way) for way in self.ways()])

    @property
    def step(self) -> str:
        """What a pair is pressed to, one after the other: "approach" or "load"."""
        return "approach" if self.mechanics == "asperities" else "load"

    def steps(self) -> Floats:
        """All approaches (µm) or loads (mN)."""
        return _array(self.approach if self.mechanics == "asperities" else self.load)

    def approaches(self) -> Floats:
        """All approaches, µm."""
        return _array(self.approach)


class Friction(_Table):
    """Molecular friction coefficients and adhesive shear strengths that the figures show."""

    mu0: Coefficients = (0.1, 0.4, 1.0)
    tau0: Strengths = tuple(quantity(f"{tau0} MPa", "pressure") for tau0 in ("0", "0.5", "10", "100", "200"))


class Ensemble(_Table):
    """How many pairs, and where their random numbers start."""

    repetitions: int = Field(default=100, ge=1, le=100_000_000)
    seed: int = Field(default=2016, ge=0, lt=2**63)


FigureName = Literal["profiles", "length-scales", "friction", "area"]


def _distinct(names: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"must name each figure once, but {name!r} is there {names.count(name)} times")
    return names


class Figures(_Table):
    """What is drawn of the result."""

    draw: Annotated[tuple[FigureName, ...], _as_tuple, AfterValidator(_distinct)] = ("friction", "area")


class Study(_Table):
    """A study: which pairs of surfaces, how they are pressed, over which parameters.

    Tables left out, and keys left out of tables, take the values of the paper's Fig. 6. Quantities are
    "number unit" in files and plain numbers in core units (µm, GPa, mN) inside. Keys belong to a kind of surfaces or
    of mechanics; those of another kind are refused.

    Examples
    --------
    >>> from stiction import Study
    >>> study = Study.named("figure6").with_changes({"ensemble.repetitions": 10})
    >>> study.ensemble.repetitions, float(study.surfaces.extent)
    (10, 40.0)
    """

    surfaces: Surfaces = Surfaces()
    contact: Contact = Contact()
    friction: Friction = Friction()
    ensemble: Ensemble = Ensemble()
    figures: Figures = Figures()

    @model_validator(mode="before")
    @classmethod
    def _with_defaults_of_its_surfaces(cls, given: Any) -> Any:
        """On surfaces contacts are gap minima, and whatever is relatively convex touches."""
        if not isinstance(given, Mapping):
            return given
        surfaces, contact = given.get("surfaces", {}), given.get("contact", {})
        if isinstance(contact, Contact):
            contact = {name: getattr(contact, name) for name in contact.model_fields_set}
        kind = getattr(surfaces, "kind", None) or (surfaces.get("kind") if isinstance(surfaces, Mapping) else None)
        if kind != "surface" or not isinstance(contact, Mapping) or contact.get("mechanics") == "half-space":
            return given
        return {**given, "contact": {"detection": "gap-minimum", "curvature": "signed"} | dict(contact)}

    @model_validator(mode="after")
    def _goes_together(self) -> Study:
        contact, on_profiles = self.contact, self.surfaces.kind == "profile"
        if on_profiles and not (contact.direction is None or contact.direction in ("+x", "-x")):
            raise ValueError(
                f'contact.direction: must be "+x" or "-x" on profiles, got {shortened(_plain(contact.direction))}'
            )
        if not on_profiles:
            if drawn := [name for name in self.figures.draw if name not in ("friction", "area")]:
                raise ValueError(f'figures.draw: "{drawn[0]}" is of profiles, and surfaces.kind is "surface"')
            if contact.mechanics == "asperities":
                try:
                    contact.model().for_surfaces()
                except ValueError as error:
                    raise ValueError(f"contact.{error}") from None
        if contact.hardness is not None:
            area = float(self.surfaces.extent) * WIDTH if on_profiles else float(np.prod(self.surfaces.extents()))
            most = float(contact.hardness) * area
            if not contact.steps()[-1] < most:
                raise ValueError(f"contact.load: must be below hardness times area, {most:g} mN")
        return self

    @model_validator(mode="after")
    def _fits(self) -> Study:
        harmonics = self.surfaces.directions * self.surfaces.frequencies
        if harmonics > MOST_HARMONICS:
            raise ValueError(
                f"surfaces.directions times surfaces.frequencies must be at most {MOST_HARMONICS}, got {harmonics}"
            )
        pairs = self.surfaces.fractal_dimensions().size * self.surfaces.amplitudes().size * self.ensemble.repetitions
        curves = sum(math.prod(map(len, self.motions().values())) if name in DIRECTED else 1 for name in self.sums())
        size = 8 * curves * pairs * self.contact.steps().size
        if size > MOST_MEMORY:
            raise ValueError(
                f"the result would take {size / 2**30:.0f} GiB, more than {MOST_MEMORY / 2**30:.0f}: take fewer "
                f"ensemble.repetitions, contact.{self.contact.step}, surfaces.fractal_dimension or surfaces.amplitude"
            )
        return self

    def sums(self) -> tuple[str, ...]:
        """Names of what a result of the study has of each pair at each approach or load."""
        if self.contact.mechanics == "half-space":
            return HALF_SPACE_SUMS
        return SUMS if self.surfaces.kind == "profile" else SUMS + AREAL_SUMS

    def motions(self) -> dict[str, list[Any]]:
        """Sliding rules and directions (degrees) of which there is a list: more dimensions of what depends on them."""
        lists: dict[str, list[Any]] = {}
        if isinstance(self.contact.sliding, tuple):
            lists["sliding"] = list(self.contact.sliding)
        if isinstance(self.contact.direction, tuple):
            lists["direction"] = self.contact.degrees().tolist()
        return lists

    @classmethod
    def named(cls, name: str) -> Study:
        """A built-in study; their names are `study_names()`.

        Raises
        ------
        StudyError
            If there is none of that name.
        """
        if name not in study_names():
            raise StudyError(f"there is no built-in study {shortened(name)}; there are {', '.join(study_names())}")
        return study_from_text((_LIBRARY / f"{name}.toml").read_text(encoding="utf-8"), name)

    @classmethod
    def from_toml(cls, path: str | Path) -> Study:
        """Read a study file.

        Raises
        ------
        StudyError
            If the file cannot be read, is not TOML, or has unknown keys, wrong units or impossible values.
        """
        try:
            raw = content(Path(path), LONGEST_FILE)
            return study_from_text(raw.decode("utf-8"), str(path))
        except OSError as error:
            raise StudyError(f"{named(path)}: cannot be read: {reason(error)}") from None
        except NotReadableError as error:
            raise StudyError(f"{named(path)}: {error}, so it is no study") from None
        except UnicodeDecodeError:
            raise StudyError(f"{named(path)}: is not a text file, so it is no study") from None

    def with_changes(self, changes: Mapping[str, Any]) -> Study:
        """The study with some values replaced, by dotted key.

        Parameters
        ----------
        changes : mapping
            Such as ``{"ensemble.repetitions": 10, "surfaces.amplitude": ["50 nm"]}``.

        Raises
        ------
        StudyError
            If a key is unknown or a value impossible.
        """
        data = self._written()
        if changes.keys() & {"surfaces.kind", "surfaces.generator", "contact.mechanics"}:
            data = self._of_another_kind(changes)
        for key, value in changes.items():
            table: Any = data
            if not isinstance(key, str):
                raise StudyError(f"{shortened(key)}: unknown key")
            *path, last = key.split(".")
            for part in path:
                table = table.setdefault(part, {}) if isinstance(table, dict) else None
            if not isinstance(table, dict):
                raise StudyError(f"{printable(key)}: unknown key")
            table[last] = value
        return _validated(data, "changes")

    def to_toml(self) -> str:
        """The whole study as TOML, with every key that it has; `Study.from_toml` reads it back equal."""
        tables = []
        for name, table in self._written().items():
            lines = [f"{key} = {_toml(value)}" for key, value in table.items()]
            tables.append("\n".join([f"[{name}]", *lines]) + "\n")
        return "\n".join(tables)

    def _of_another_kind(self, changes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
        """All keys with the defaults of the new kind, but for what differs from those of the old one and belongs."""
        old: dict[str, dict[str, Any]] = {
            "surfaces": {"kind": self.surfaces.kind, "generator": self.surfaces.generator},
            "contact": {"mechanics": self.contact.mechanics},
        }
        new = {
            section: {key: changes.get(f"{section}.{key}", value) for key, value in table.items()}
            for section, table in old.items()
        }
        for tables in (old, new):
            if tables["surfaces"]["kind"] == "profile":
                del tables["surfaces"]["generator"]
        before, fresh = (_validated(tables, "changes") for tables in (old, new))
        cases = {"surfaces": fresh.surfaces.case, "contact": fresh.contact.mechanics}
        was, written = before._written(), fresh._written()
        for section, table in self._written().items():
            for key, value in table.items():
                if was[section].get(key) != value and _belongs(key, cases.get(section, "")):
                    written[section][key] = value
        return written

    def _written(self) -> dict[str, dict[str, Any]]:
        """Every key of each table but those of other kinds, those that are not given, and those that came later."""
        cases = {"surfaces": self.surfaces.case, "contact": self.contact.mechanics}
        return {
            name: {
                key: value
                for key, value in table.items()
                if value is not None
                and _belongs(key, cases.get(name, ""))
                and (key not in _LATER or value != _LATER[key])
            }
            for name, table in self.model_dump().items()
        }


_LIBRARY = resources.files("stiction.studies") / "library"


def study_names() -> list[str]:
    """Names of the built-in studies, sorted."""
    return sorted(item.name.removesuffix(".toml") for item in _LIBRARY.iterdir() if item.name.endswith(".toml"))


def study_of(dataset: xarray.Dataset) -> Study:
    """The study that a result came from.

    Raises
    ------
    StudyError
        If the dataset does not say.
    """
    if not isinstance(dataset.attrs.get("study"), str):
        raise StudyError(
            "the dataset does not say what study it is of (attribute 'study'), so mu0 and tau0 must be given"
        )
    return study_from_text(dataset.attrs["study"], "the dataset's study")


def differences(one: Study, other: Study) -> list[tuple[str, str, str]]:
    """Every value that differs, in the order of a study file: its dotted key, and what it is in either, as TOML."""
    return list(_differences(one, other, ""))


def _differences(one: _Table, other: _Table, prefix: str) -> Iterator[tuple[str, str, str]]:
    texts = one.model_dump(), other.model_dump()
    for name in type(one).model_fields:
        values = getattr(one, name), getattr(other, name)
        if values[0] == values[1]:
            continue
        if isinstance(values[0], _Table) and type(values[0]) is type(values[1]):
            yield from _differences(*values, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", _toml(texts[0][name]), _toml(texts[1][name])


# ---- Text -----------------------------------------------------------------------------------------------------------


def _toml(value: Any) -> str:
    match value:
        case None:
            return "none"
        case str():
            return json.dumps(value, ensure_ascii=False)
        case int():
            return f"{value:_}"
        case float():
            return repr(value)
        case dict():
            return "{ " + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + " }"
        case _:
            return "[" + ", ".join(_toml(item) for item in value) + "]"


def study_from_text(text: str, source: str) -> Study:
    """The study that a TOML text is; errors call it by the name of its source."""
    try:
        data = toml(text)
    except ValueError as error:
        raise StudyError(f"{named(source)}: is not TOML: {printable(error, LONGEST_NAME)}") from None
    return _validated(data, source)


def toml(text: str) -> dict[str, Any]:
    """What a TOML text says.

    Raises
    ------
    ValueError
        If it is not TOML, or is deeper than any study.
    """
    if any(key.group().count(".") >= MOST_PARTS for key in _DOTTED.finditer(_STRINGS.sub("s", text))):
        raise ValueError(f"a key has more than {MOST_PARTS} parts")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("it is too deep") from None


# Each of these takes a time that grows with the length of the text, whatever is in it.
_STRINGS = re.compile(
    r"""\"{3}(?:\\.|[^\\])*?(?:\"{3}|\Z)|'{3}.*?(?:'{3}|\Z)|"(?:\\.|[^"\\\n])*"?|'[^'\n]*'?|\#[^\n]*""", re.DOTALL
)
"""Strings and comments."""

_DOTTED = re.compile(r"[\w-]+(?:[ \t]*\.[ \t]*[\w-]+)*")


def _validated(data: Mapping[str, Any], source: str) -> Study:
    try:
        return Study.model_validate(data)
    except ValidationError as error:
        faults = error.errors(include_url=False)
        lines = [f"{named(source)}: {_fault(fault)}" for fault in faults[:5]]
        if len(faults) > 5:
            lines.append(f"{named(source)}: ... and {len(faults) - 5} more")
        raise StudyError("\n".join(lines)) from None


def _fault(fault: ErrorDetails) -> str:
    location = [part for part in fault["loc"] if part not in _TAGS]
    key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in location).removeprefix(".")
    if fault["type"] == "key":
        key += f".{fault['ctx']['key']}"
    key = printable(key)
    if fault["type"] == "extra_forbidden":
        return f"{key}: unknown key{_suggestion(location)}"
    message = fault["msg"].removeprefix("Value error, ")
    if fault["type"] == "model_type":
        message = "must be a table"
    if fault["type"] == "tuple_type":
        message = "must be a list"
    if fault["type"] not in ("value_error", "missing", "range_or_list", "law", "key", "too_short", "too_long"):
        message = f"{message[0].lower()}{message[1:]}, got {shortened(fault['input'])}"
    return f"{key}: {message}" if key else message


def _plain(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value


def _suggestion(location: list[int | str]) -> str:
    table: Any = Study.model_fields
    for part in location[:-1]:
        field = table.get(part)
        table = getattr(getattr(field, "annotation", None), "model_fields", {})
    close = difflib.get_close_matches(str(location[-1])[:LONGEST_WORD], list(table), n=1)
    return f"; is it {close[0]!r}?" if close else ""
