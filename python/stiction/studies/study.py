"""What to compute: a study, validated, from a TOML file or the built-in library."""

from __future__ import annotations

import dataclasses
import difflib
import itertools
import json
import tomllib
from collections.abc import Iterator, Mapping
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

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
from pydantic_core import ErrorDetails

from stiction._checks import Floats
from stiction._units import Quantity, quantity, shortened
from stiction.mechanics.law import LAWS, NAMED, Law, LawName
from stiction.mechanics.model import ContactModel, Curvature, Detection, Shear
from stiction.mechanics.quantities import SUMS
from stiction.surfaces.fractal import Convention
from stiction.surfaces.profile import FEWEST_POINTS, MOST_POINTS, AmplitudeMeasure

if TYPE_CHECKING:
    import xarray

MOST_MEMORY = 16 * 2**30
"""Bytes of a result, which is held in memory."""

MOST_VALUES = 10_000
"""Of any one parameter of a study."""

LONGEST_FILE = 1_000_000
"""Bytes of a study file; a study is a page."""


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
Dimension = Annotated[float, Field(ge=1, lt=2)]
Coefficient = Annotated[float, Field(ge=0)]

# TOML has lists; a study is immutable.
_as_tuple = BeforeValidator(lambda values: tuple(values) if isinstance(values, list) else values)
_values = (_as_tuple, Field(min_length=1, max_length=MOST_VALUES), AfterValidator(_increasing))
Dimensions = Annotated[tuple[Dimension, ...], *_values]
Lengths = Annotated[tuple[Length, ...], *_values]
Approaches = Annotated[tuple[LengthOrZero, ...], *_values]
Strengths = Annotated[tuple[Strength, ...], *_values]
Coefficients = Annotated[tuple[Coefficient, ...], *_values]


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


def _array(values: DimensionRange | ApproachRange | tuple[float, ...]) -> Floats:
    return np.array(values, dtype=np.float64) if isinstance(values, tuple) else values.values()


# ---- Tables ---------------------------------------------------------------------------------------------------------


class Surfaces(_Table):
    """Pairs of fractal profiles."""

    fractal_dimension: Annotated[
        Annotated[DimensionRange, Tag(_RANGE)] | Annotated[Dimensions, Tag(_LIST)], _either
    ] = DimensionRange(start=1.0, stop=1.7, count=50)
    amplitude: Lengths = (quantity("0.1 um", "length"),)
    amplitude_measure: AmplitudeMeasure = "height"
    length_scale: Length = quantity("1 um", "length")
    extent: Length = quantity("40 um", "length")
    points: int = Field(default=150_000, ge=FEWEST_POINTS, le=MOST_POINTS)
    gamma: float = Field(default=1.5, gt=1)
    directions: int = Field(default=40, ge=1, le=MOST_VALUES)
    frequencies: int = Field(default=40, ge=1, le=MOST_VALUES)
    convention: Convention = "paper"
    band_limit: Literal["none", "nyquist"] = "none"

    def fractal_dimensions(self) -> Floats:
        """All values of the fractal dimension."""
        return _array(self.fractal_dimension)

    def amplitudes(self) -> Floats:
        """All amplitudes, µm."""
        return _array(self.amplitude)


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

    effective_modulus: Modulus = quantity("10 GPa", "pressure")
    law: LawEntry = "hertz-sphere"
    detection: Detection = "cell"
    curvature: Curvature = "convex"
    shear: Shear = "+x"
    approach: Annotated[Annotated[ApproachRange, Tag(_RANGE)] | Annotated[Approaches, Tag(_LIST)], _either] = (
        ApproachRange(start=quantity("0.1 nm", "length"), stop=quantity("40 nm", "length"), count=40)
    )

    def model(self) -> ContactModel:
        """What `press` takes."""
        return ContactModel(
            effective_modulus=float(self.effective_modulus),
            law=self.law if isinstance(self.law, str) else self.law.law(),
            detection=self.detection,
            curvature=self.curvature,
            shear=self.shear,
        )

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
    "number unit" in files and plain numbers in core units (µm, GPa) inside.

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

    @model_validator(mode="after")
    def _fits(self) -> Study:
        pairs = self.surfaces.fractal_dimensions().size * self.surfaces.amplitudes().size * self.ensemble.repetitions
        size = 8 * len(SUMS) * pairs * self.contact.approaches().size
        if size > MOST_MEMORY:
            raise ValueError(
                f"the result would take {size / 2**30:.0f} GiB, more than {MOST_MEMORY / 2**30:.0f}: take fewer "
                "ensemble.repetitions, contact.approach, surfaces.fractal_dimension or surfaces.amplitude"
            )
        return self

    @classmethod
    def named(cls, name: str) -> Study:
        """A built-in study; their names are `study_names()`.

        Raises
        ------
        StudyError
            If there is none of that name.
        """
        if name not in study_names():
            raise StudyError(f"there is no built-in study {name!r}; there are {', '.join(study_names())}")
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
            with Path(path).open("rb") as file:
                raw = file.read(LONGEST_FILE + 1)
        except OSError as error:
            raise StudyError(f"{path}: cannot be read: {error.strerror or error}") from None
        if len(raw) > LONGEST_FILE:
            raise StudyError(f"{path}: is longer than {LONGEST_FILE} bytes, which no study is")
        try:
            return study_from_text(raw.decode("utf-8"), str(path))
        except UnicodeDecodeError:
            raise StudyError(f"{path}: is not a text file, so it is no study") from None

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
        data = self.model_dump()
        for key, value in changes.items():
            table: Any = data
            if not isinstance(key, str):
                raise StudyError(f"{key!r}: unknown key")
            *path, last = key.split(".")
            for part in path:
                table = table.setdefault(part, {}) if isinstance(table, dict) else None
            if not isinstance(table, dict):
                raise StudyError(f"{key}: unknown key")
            table[last] = value
        return _validated(data, "changes")

    def to_toml(self) -> str:
        """The whole study as TOML, every key written out; `Study.from_toml` reads it back equal."""
        tables = []
        for name, table in self.model_dump().items():
            lines = [f"{key} = {_toml(value)}" for key, value in table.items()]
            tables.append("\n".join([f"[{name}]", *lines]) + "\n")
        return "\n".join(tables)


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
        data = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        raise StudyError(f"{source}: is not TOML: {error}") from None
    return _validated(data, source)


def _validated(data: Mapping[str, Any], source: str) -> Study:
    try:
        return Study.model_validate(data)
    except ValidationError as error:
        faults = error.errors(include_url=False)
        lines = [f"{source}: {_fault(fault)}" for fault in faults[:5]]
        if len(faults) > 5:
            lines.append(f"{source}: ... and {len(faults) - 5} more")
        raise StudyError("\n".join(lines)) from None


def _fault(fault: ErrorDetails) -> str:
    location = [part for part in fault["loc"] if part not in _TAGS]
    key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in location).removeprefix(".")
    if fault["type"] == "extra_forbidden":
        return f"{key}: unknown key{_suggestion(location)}"
    message = fault["msg"].removeprefix("Value error, ")
    if fault["type"] == "model_type":
        message = "must be a table"
    if fault["type"] == "tuple_type":
        message = "must be a list"
    if fault["type"] not in ("value_error", "missing", "range_or_list", "law", "too_short", "too_long"):
        message = f"{message[0].lower()}{message[1:]}, got {shortened(fault['input'])}"
    return f"{key}: {message}" if key else message


def _suggestion(location: list[int | str]) -> str:
    table: Any = Study.model_fields
    for part in location[:-1]:
        field = table.get(part)
        table = getattr(getattr(field, "annotation", None), "model_fields", {})
    close = difflib.get_close_matches(str(location[-1]), list(table), n=1)
    return f"; is it {close[0]!r}?" if close else ""
