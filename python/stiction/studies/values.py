"""Values of a study file: quantities with units, lists that increase, ranges."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

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
    model_validator,
)
from pydantic_core import PydanticCustomError

from stiction._checks import Floats
from stiction._units import Quantity, quantity, shortened
from stiction.mechanics.model import Direction, Sliding
from stiction.surfaces.profile import FEWEST_POINTS, MOST_POINTS

MOST_VALUES = 10_000
"""Largest number of values of one parameter of a study."""

MOST_MATERIALS = 100
"""Largest number of mu0, of tau0 and of cut-off wavelengths."""


def read_length(text: object) -> Quantity:
    """A length above 0."""
    value = quantity(text, "length")
    if not value > 0:
        raise ValueError(f"must be above 0, got {value.text!r}")
    return value


def _reader(kind: str, *, zero: bool) -> PlainValidator:
    def read(text: object) -> Quantity:
        value = quantity(text, kind)
        if not (value > 0 or (zero and float(value) == 0)):
            raise ValueError(f"must be {'at least' if zero else 'above'} 0, got {value.text!r}")
        return value

    return PlainValidator(read)


def written(value: Any) -> Any:
    """A quantity as a person wrote it, a number in few digits, some of these as a list; what is no number as it is."""
    if isinstance(value, tuple):
        return tuple(map(written, value))
    if isinstance(value, Quantity):
        return value.text
    return f"{value:g}" if isinstance(value, float) else value


def _increasing(values: tuple[float, ...]) -> tuple[float, ...]:
    for previous, value in itertools.pairwise(values):
        if not value > previous:
            raise ValueError(f"must increase, but {written(previous)} is followed by {written(value)}")
    return values


as_written = PlainSerializer(written)
Length = Annotated[Quantity, _reader("length", zero=False), as_written]
LengthOrZero = Annotated[Quantity, _reader("length", zero=True), as_written]
Modulus = Annotated[Quantity, _reader("pressure", zero=False), as_written]
Strength = Annotated[Quantity, _reader("pressure", zero=True), as_written]
Force = Annotated[Quantity, _reader("force", zero=False), as_written]
Fraction = Annotated[float, Field(ge=0, le=1)]
Side = Annotated[int, Field(ge=FEWEST_POINTS, le=MOST_POINTS)]
Dimension = Annotated[float, Field(ge=1, lt=2)]
Coefficient = Annotated[float, Field(ge=0)]

# TOML has lists; a study is immutable.
as_tuple = BeforeValidator(lambda values: tuple(values) if isinstance(values, list) else values)
_values = (as_tuple, Field(min_length=1, max_length=MOST_VALUES), AfterValidator(_increasing))
_few_values = (as_tuple, Field(min_length=1, max_length=MOST_MATERIALS), AfterValidator(_increasing))
Dimensions = Annotated[tuple[Dimension, ...], *_values]
Lengths = Annotated[tuple[Length, ...], *_values]
Approaches = Annotated[tuple[LengthOrZero, ...], *_values]
Loads = Annotated[tuple[Force, ...], *_values]
Strengths = Annotated[tuple[Strength, ...], *_few_values]
Coefficients = Annotated[tuple[Coefficient, ...], *_few_values]
CutOffs = Annotated[tuple[LengthOrZero, ...], *_few_values]
LoadsOfInterest = Annotated[tuple[Force, ...], *_few_values]


def _several(values: tuple[Any, ...], name: str, same: Any) -> tuple[Any, ...]:
    if not 1 <= len(values) <= MOST_VALUES:
        raise ValueError(f"must have from 1 to {MOST_VALUES} {name}s, got {len(values)}")
    if len({same(value) for value in values}) < len(values):
        raise ValueError(f"must have each {name} once, got {shortened(list(values))}")
    return values


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
    return _several(tuple(one(item) for item in value), "direction", degrees_of)


def _read_compass(value: object) -> tuple[float, ...]:
    """Directions of measured areas, in degrees from 0 to below 360; one of them is a list of one."""
    directions = _read_direction(value)
    if directions is None:
        raise ValueError("must be degrees or a list of degrees, got none")
    listed = directions if isinstance(directions, tuple) else (directions,)
    if len(listed) > MOST_DIRECTIONS:
        raise ValueError(f"must have at most {MOST_DIRECTIONS} directions, got {len(listed)}")
    return tuple(degrees_of(direction) for direction in listed)


MOST_DEGREES = 360
"""Largest direction, to either side."""

MOST_DIRECTIONS = 360
"""Largest number of directions of measured areas."""


def degrees_of(direction: Direction) -> float:
    """From +x towards +y, from 0 to 360."""
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


Directions = Annotated[Direction | tuple[Direction, ...] | None, PlainValidator(_read_direction)]
Compass = Annotated[tuple[float, ...], PlainValidator(_read_compass)]
Rules = Annotated[Sliding | tuple[Sliding, ...], PlainValidator(_read_sliding)]


class Table(BaseModel):
    """A table of a study file: only known keys, exact types, never changed."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, validate_default=True)


def fault_at(key: str, message: str) -> PydanticCustomError:
    """The error that a table has a fault at one of its keys."""
    return PydanticCustomError("key", "{message}", {"key": key, "message": message})


def _check_range(bounds: Any) -> None:
    if bounds.count == 1 and bounds.start != bounds.stop:
        raise ValueError("a range of count 1 must stop where it starts")
    if bounds.count > 1 and not bounds.stop > bounds.start:
        raise ValueError(f"must stop above its start, got {written(bounds.start)} to {written(bounds.stop)}")


class DimensionRange(Table):
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


class _Steps(Table):
    """Both ends included, in equal steps (linear) or ratios (geometric)."""

    start: Any
    stop: Any
    count: int = Field(ge=1, le=MOST_VALUES)
    spacing: Literal["linear", "geometric"] = "geometric"

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        _check_range(self)
        if self.spacing == "geometric" and float(self.start) == 0:
            raise ValueError("a geometric range cannot start at 0")
        return self

    def values(self) -> Floats:
        """(count,) array, µm or mN."""
        space = np.geomspace if self.spacing == "geometric" else np.linspace
        return np.asarray(space(float(self.start), float(self.stop), self.count), dtype=np.float64)


class ApproachRange(_Steps):
    """Approaches."""

    start: LengthOrZero
    stop: LengthOrZero


class LoadRange(_Steps):
    """Normal loads."""

    start: Force
    stop: Force


# Which of a range or a list a value is, told before it is read, so that its faults are those of one kind.
RANGE, LIST = "a range", "a list"


def _kind_of_values(value: object) -> str | None:
    if isinstance(value, (Mapping, Table)):
        return RANGE
    return LIST if isinstance(value, (list, tuple)) else None


_range_or_list = Discriminator(
    _kind_of_values,
    custom_error_type="range_or_list",
    custom_error_message="must be a list, or a table with start, stop and count",
)
DimensionsOrRange = Annotated[Annotated[DimensionRange, Tag(RANGE)] | Annotated[Dimensions, Tag(LIST)], _range_or_list]
ApproachesOrRange = Annotated[Annotated[ApproachRange, Tag(RANGE)] | Annotated[Approaches, Tag(LIST)], _range_or_list]
LoadsOrRange = Annotated[Annotated[LoadRange, Tag(RANGE)] | Annotated[Loads, Tag(LIST)], _range_or_list]


def array_of(values: DimensionRange | ApproachRange | LoadRange | tuple[float, ...]) -> Floats:
    """All values of a range or a list."""
    return np.array(values, dtype=np.float64) if isinstance(values, tuple) else values.values()
