"""Types of the values in a study file: quantities with units, increasing lists, and ranges."""

from __future__ import annotations

import difflib
import itertools
import json
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar, get_args, get_origin

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
    model_validator,
)
from pydantic_core import ErrorDetails, PydanticCustomError

from stiction._arguments import MAX_INPUT_NUMBER
from stiction._checks import Floats
from stiction._text import MAX_WORD_LENGTH, printable_path, printable_text
from stiction._units import Quantity, quantity, short_repr
from stiction.mechanics.model import Direction, SlidingRule
from stiction.surfaces.profile import MAX_POINTS, MIN_POINTS

MAX_NUM_PARAMETER_VALUES = 10_000
MAX_SHORT_LIST_LENGTH = 100
# The run time of tomllib increases with the square of the number of dots in a key.
MAX_KEY_DOTS = 100
MAX_DIRECTION_DEGREES = 360  # degrees


def _make_quantity_parser(kind: str, *, allows_zero: bool = False) -> Callable[[object], Quantity]:
    def parse_checked_quantity(text: object) -> Quantity:
        value = quantity(text, kind)
        if not (value > 0 or (allows_zero and float(value) == 0)):
            raise ValueError(f"must be {'at least' if allows_zero else 'above'} 0, got {short_repr(value.text)}")
        return value

    return parse_checked_quantity


parse_positive_length = _make_quantity_parser("length")


def format_quantities(value: Any) -> Any:
    """Format a quantity with its unit (or a plain number) as text; for a tuple, return a tuple of texts.

    Other values are returned unchanged.
    """
    if isinstance(value, tuple):
        return tuple(map(format_quantities, value))
    if isinstance(value, Quantity):
        return value.text
    return f"{value:g}" if isinstance(value, float) else value


def _require_increasing(values: tuple[float, ...]) -> tuple[float, ...]:
    for previous, value in itertools.pairwise(values):
        if not value > previous:
            raise ValueError(
                f"must increase, but {format_quantities(previous)} is followed by {format_quantities(value)}"
            )
    return values


quantity_serializer = PlainSerializer(format_quantities)
Length = Annotated[Quantity, PlainValidator(parse_positive_length), quantity_serializer]
SignedLength = Annotated[Quantity, PlainValidator(lambda text: quantity(text, "length")), quantity_serializer]
LengthOrZero = Annotated[
    Quantity, PlainValidator(_make_quantity_parser("length", allows_zero=True)), quantity_serializer
]
Modulus = Annotated[Quantity, PlainValidator(_make_quantity_parser("pressure")), quantity_serializer]
PressureOrZero = Annotated[
    Quantity, PlainValidator(_make_quantity_parser("pressure", allows_zero=True)), quantity_serializer
]
Force = Annotated[Quantity, PlainValidator(_make_quantity_parser("force")), quantity_serializer]
Time = Annotated[Quantity, PlainValidator(_make_quantity_parser("time")), quantity_serializer]
WorkOfAdhesion = Annotated[
    Quantity, PlainValidator(_make_quantity_parser("work of adhesion", allows_zero=True)), quantity_serializer
]
Fraction = Annotated[float, Field(ge=0, le=1)]
NumGridPoints = Annotated[int, Field(ge=MIN_POINTS, le=MAX_POINTS)]
FractalDimension = Annotated[float, Field(ge=1, lt=2)]
FrictionCoefficient = Annotated[float, Field(ge=0, le=MAX_INPUT_NUMBER)]


_Item = TypeVar("_Item")


def require_distinct(values: tuple[_Item, ...]) -> tuple[_Item, ...]:
    """Return a given tuple; raise a `ValueError` if two elements of the tuple are equal."""
    if len(set(values)) < len(values):
        raise ValueError("must differ from each other, but two values are equal")
    return values


# Tuples replace the lists of TOML, because tuples cannot change.
list_to_tuple_validator = BeforeValidator(lambda values: tuple(values) if isinstance(values, list) else values)
_long_list_constraints = (
    list_to_tuple_validator,
    Field(min_length=1, max_length=MAX_NUM_PARAMETER_VALUES),
    AfterValidator(_require_increasing),
)
_short_list_constraints = (
    list_to_tuple_validator,
    Field(min_length=1, max_length=MAX_SHORT_LIST_LENGTH),
    AfterValidator(_require_increasing),
)
FractalDimensions = Annotated[tuple[FractalDimension, ...], *_long_list_constraints]
Lengths = Annotated[tuple[Length, ...], *_long_list_constraints]
Approaches = Annotated[tuple[LengthOrZero, ...], *_long_list_constraints]
Loads = Annotated[tuple[Force, ...], *_long_list_constraints]
ShearStrengths = Annotated[tuple[PressureOrZero, ...], *_short_list_constraints]
FrictionCoefficients = Annotated[tuple[FrictionCoefficient, ...], *_short_list_constraints]
CutOffs = Annotated[
    tuple[LengthOrZero, ...],
    list_to_tuple_validator,
    Field(min_length=1, max_length=MAX_SHORT_LIST_LENGTH),
    AfterValidator(require_distinct),
]
_optional_short_list_constraints = (
    list_to_tuple_validator,
    Field(max_length=MAX_SHORT_LIST_LENGTH),
    AfterValidator(_require_increasing),
)
LoadsOfInterest = Annotated[tuple[Force, ...], *_optional_short_list_constraints]
Times = Annotated[tuple[Time, ...], *_optional_short_list_constraints]


def _build_one_or_tuple_validator(
    name: str, parse_value: Callable[[object], Any], identity: Callable[[Any], Any]
) -> PlainValidator:
    """Build a pydantic validator that accepts one value, or a list of different values."""

    def validate(value: object) -> Any:
        if not isinstance(value, (list, tuple)):
            return parse_value(value)
        if not 1 <= len(value) <= MAX_NUM_PARAMETER_VALUES:
            raise ValueError(f"must have from 1 to {MAX_NUM_PARAMETER_VALUES} {name}s, got {len(value)}")
        values = tuple(map(parse_value, value))
        if len(set(map(identity, values))) < len(values):
            raise ValueError(f"must contain each {name} only once, got {short_repr(list(values))}")
        return values

    return PlainValidator(validate)


def _parse_direction(value: object) -> Any:
    if isinstance(value, str) and value in ("+x", "-x"):
        return value
    if isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= MAX_DIRECTION_DEGREES:
        return float(value)
    raise ValueError(
        f'must be "+x", "-x" or degrees from {-MAX_DIRECTION_DEGREES} to {MAX_DIRECTION_DEGREES}, or a list of these, '
        f"got {short_repr(value)}"
    )


def direction_to_degrees(direction: Direction) -> float:
    """Convert a direction of motion, such as "-x" or 30, to an angle from +x towards +y, from 0 to below 360°."""
    return {"+x": 0.0, "-x": 180.0}[direction] if isinstance(direction, str) else direction % 360.0


def _parse_sliding_rule(value: object) -> Any:
    if value not in ("opposing", "all"):
        raise ValueError(f'must be "opposing" or "all", or a list of both, got {short_repr(value)}')
    return value


Directions = (
    Annotated[
        Direction | tuple[Direction, ...],
        _build_one_or_tuple_validator("direction", _parse_direction, direction_to_degrees),
    ]
    | None
)
SlidingRules = Annotated[
    SlidingRule | tuple[SlidingRule, ...], _build_one_or_tuple_validator("rule", _parse_sliding_rule, str)
]


class SettingsSection(BaseModel):
    """Base class for the sections of a study file.

    A section declares its keys, and is immutable.
    """

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, validate_default=True, defer_build=True
    )

    def __init__(self, **values: Any) -> None:
        """Validate the values of the section's keys.

        An invalid value raises a `StudyError` that names the key.
        """
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise _convert_validation_errors(type(self), error, "") from None

    # This attribute makes pydantic skip the constructors of nested sections, so that one error lists all faults.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]


class SettingsSectionVariant(SettingsSection):
    """Base class for a variant of a section, such as the section `[surfaces]` for measured maps.

    Each variant is a class with its own keys.
    """

    place: ClassVar[str]

    @classmethod
    def selectors(cls) -> dict[str, Any]:
        """Return the keys that select this variant of a section, such as `kind`, each with the required value."""
        return {
            key: field.default for key, field in cls.model_fields.items() if get_origin(field.annotation) is Literal
            and get_args(field.annotation) == (field.default,)
        }  # fmt: skip


def make_key_error(key: str, message: str) -> PydanticCustomError:
    """Create a validation error about a key of a section."""
    return PydanticCustomError("key", "{message}", {"key": key, "message": message})


def select_key_value(key: str, section: Mapping[str, Any], cases: Mapping[str, Any]) -> str:
    """Return the value of a section's key, such as `kind`, that decides which class validates the section.

    The default is the first name in `cases`.

    Raises an error if the value is not a name in `cases`.
    """
    value = section.get(key, next(iter(cases)))
    if not isinstance(value, str) or value not in cases:
        names = '" or "'.join(cases)
        raise make_key_error(key, f'must be "{names}", got {short_repr(value)}')
    return value


class _ValueRange(SettingsSection):
    """Range of numbers with equal steps, from a first to a last number."""

    start: Any
    stop: Any
    count: int = Field(ge=1, le=MAX_NUM_PARAMETER_VALUES)

    @model_validator(mode="after")
    def _require_valid_range(self) -> Self:
        if self.count == 1 and self.start != self.stop:
            raise ValueError("a range with count = 1 must have equal start and stop")
        if self.count > 1 and not self.stop > self.start:
            raise ValueError(
                f"must be a range whose stop is above its start, got {format_quantities(self.start)} to "
                f"{format_quantities(self.stop)}"
            )
        return self

    def values(self) -> Floats:
        """Compute the equally spaced numbers of the range; lengths are in µm, and loads in mN."""
        return np.linspace(float(self.start), float(self.stop), self.count)


class FractalDimensionRange(_ValueRange):
    """Range of fractal dimensions: first and last dimension, and number of dimensions."""

    start: FractalDimension
    stop: FractalDimension


class _SteppedValueRange(_ValueRange):
    """Range of quantities with equal differences (linear) or equal ratios (geometric) between successive quantities."""

    spacing: Literal["linear", "geometric"] = "geometric"

    @model_validator(mode="after")
    def _require_positive_start(self) -> Self:
        if self.spacing == "geometric" and float(self.start) == 0:
            raise ValueError("a geometric range cannot start at 0")
        return self

    def values(self) -> Floats:
        """Compute the linearly or geometrically spaced quantities of the range in core units (µm or mN)."""
        if self.spacing == "linear":
            return super().values()
        return np.geomspace(float(self.start), float(self.stop), self.count)


class ApproachRange(_SteppedValueRange):
    """Range of approach distances: first and last distance, number of distances, and linear or geometric spacing."""

    start: LengthOrZero
    stop: LengthOrZero


class LoadRange(_SteppedValueRange):
    """Range of normal loads: first and last load, number of loads, and linear or geometric spacing."""

    start: Force
    stop: Force


# Each value is tagged as a range or a list before validation: error messages then describe only the tagged form.
RANGE_TAG, LIST_TAG = "a range", "a list"


def _get_tag_of_range_or_list(value: object) -> str | None:
    if isinstance(value, (Mapping, SettingsSection)):
        return RANGE_TAG
    return LIST_TAG if isinstance(value, (list, tuple)) else None


_range_or_list_discriminator = Discriminator(
    _get_tag_of_range_or_list,
    custom_error_type="range_or_list",
    custom_error_message="must be a list, or a section with start, stop and count",
)
FractalDimensionsOrRange = Annotated[
    Annotated[FractalDimensionRange, Tag(RANGE_TAG)] | Annotated[FractalDimensions, Tag(LIST_TAG)],
    _range_or_list_discriminator,
]
ApproachesOrRange = Annotated[
    Annotated[ApproachRange, Tag(RANGE_TAG)] | Annotated[Approaches, Tag(LIST_TAG)], _range_or_list_discriminator
]
LoadsOrRange = Annotated[
    Annotated[LoadRange, Tag(RANGE_TAG)] | Annotated[Loads, Tag(LIST_TAG)], _range_or_list_discriminator
]


def to_value_array(values: _ValueRange | tuple[float, ...]) -> Floats:
    """Return the numbers in a list, or the numbers of a range with linear or geometric spacing, as an array."""
    return np.array(values, dtype=np.float64) if isinstance(values, tuple) else values.values()


# ---- Keys that only some variants of a section have -----------------------------------------------------------------


def check_keys(
    section: Mapping[Any, Any], case: type[SettingsSectionVariant], shared: Sequence[type[SettingsSectionVariant]]
) -> None:
    """Raise an error if a section lacks a required key, or has a key that this kind of section does not allow.

    `shared` lists base classes whose keys several variants have. Messages name these classes by their `place`.
    """
    for key in section:
        if key in case.model_fields:
            continue
        section_classes = [kind for kind in shared if key in kind.model_fields]
        base_classes = [
            kind
            for kind in section_classes
            if not any(kind is not base and issubclass(kind, base) for base in section_classes)
        ]
        if base_classes:
            other_sections = " and ".join(dict.fromkeys(kind.place for kind in base_classes))
            selectors = [kind.selectors().items() - case.selectors().items() for kind in base_classes]
            common_keys = sorted(set.intersection(*selectors))
            remedy = " and ".join(f"{name} = {format_toml_value(value)}" for name, value in common_keys)
            reason = f"belongs to {other_sections}, not to {case.place}"
            raise make_key_error(str(key), f"{reason}; the key requires {remedy}" if remedy else reason)
    for key, field in case.model_fields.items():
        if field.is_required() and key not in section:
            raise make_key_error(key, f"must be given for {case.place}")


_SettingsClass = TypeVar("_SettingsClass", bound=SettingsSection)


MAX_LISTED_FAULTS = 5


class StudyError(ValueError):
    """Error raised if a study is invalid.

    Each line of the message names one key and the error in its value.

    Attributes
    ----------
    faults : tuple of (str, str)
        Dotted key (empty for the whole study) and message of each fault.
    """

    def __init__(self, message: str, faults: tuple[tuple[str, str], ...] = ()) -> None:
        super().__init__(message)
        self.faults = faults or (("", message),)


def format_toml_value(value: Any) -> str:
    """Format a value of a study as TOML text."""
    match value:
        case None:
            return "none"
        case str():
            return json.dumps(value, ensure_ascii=False)
        case bool():
            return str(value).lower()
        case int():
            return f"{value:_}"
        case float():
            return repr(value)
        case dict():
            # A body in memory cannot be written in TOML.
            items = [f"{key} = {format_toml_value(item)}" for key, item in value.items() if key != "body"]
            return "{ " + ", ".join(items) + " }"
        case _:
            return "[" + ", ".join(format_toml_value(item) for item in value) + "]"


def format_toml_sections(sections: Mapping[str, Mapping[str, Any]]) -> str:
    """Format the sections of a study as TOML text, without empty sections."""
    section_texts = []
    for name, section in sections.items():
        lines = [f"{key} = {format_toml_value(value)}" for key, value in section.items()]
        section_texts += ["\n".join([f"[{name}]", *lines]) + "\n"] if lines else []
    return "\n".join(section_texts)


def parse_toml(text: str) -> dict[str, Any]:
    """Parse TOML text to a dictionary.

    Raises a `ValueError` if the text is invalid or nested too deeply.
    """
    text_pieces = re.split(r"([=,#{}\[\]\n])", text)
    key_texts = [piece for piece, separator in itertools.pairwise(text_pieces) if separator in ("=", "]")]
    if any(key_text.count(".") > MAX_KEY_DOTS for key_text in key_texts):
        raise ValueError("is nested too deeply")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("is nested too deeply") from None


def validate_section(section_class: type[_SettingsClass], data: Mapping[str, Any], source: str) -> _SettingsClass:
    """Create a section of a given class from keys and values, or raise a `StudyError` if a key or value is invalid.

    Error messages start with `source`, the name of the study.
    """
    try:
        return section_class.model_validate(data)
    except ValidationError as error:
        raise _convert_validation_errors(section_class, error, f"{printable_path(source)}: ") from None


def _convert_validation_errors(section_class: type[SettingsSection], error: ValidationError, prefix: str) -> StudyError:
    """Convert a pydantic error to a `StudyError` whose message has one line per invalid key."""
    faults = [_convert_validation_error(section_class, fault) for fault in error.errors(include_url=False)]
    lines = [f"{prefix}{key}: {reason}" if key else f"{prefix}{reason}" for key, reason in faults[:MAX_LISTED_FAULTS]]
    if len(faults) > MAX_LISTED_FAULTS:
        lines.append(f"{prefix}... and {len(faults) - MAX_LISTED_FAULTS} more")
    return StudyError("\n".join(lines), tuple(faults))


_ERROR_MESSAGE_TEMPLATES = {
    "finite_number": "must be a finite number", "float_type": "must be a number", "int_type": "must be a whole number",
    "bool_type": "must be true or false", "string_type": "must be text", "literal_error": "must be {expected}",
    "greater_than": "must be above {gt:g}", "greater_than_equal": "must be at least {ge:g}",
    "less_than": "must be below {lt:g}", "less_than_equal": "must be at most {le:g}",
    "missing": "must be given",
    "too_short": "must have at least {min_length} values, got {actual_length}",
    "too_long": "must have at most {max_length} values, got {actual_length}",
    "string_too_short": "must have at least {min_length} characters",
    "string_too_long": "must have at most {max_length} characters",
}  # fmt: skip
"""Templates of error messages that replace the messages of pydantic, by the error type of pydantic."""


def _convert_validation_error(section_class: type[SettingsSection], fault: ErrorDetails) -> tuple[str, str]:
    """Return the invalid key and an error message, converted from an error that pydantic reports about a section."""
    location = [key_part for key_part in fault["loc"] if key_part not in (RANGE_TAG, LIST_TAG)]
    key = "".join(
        f"[{key_part}]" if isinstance(key_part, int) else f".{key_part}" for key_part in location
    ).removeprefix(".")
    if fault["type"] == "key":
        key += f".{fault['ctx']['key']}"
    key = printable_text(key)
    if fault["type"] == "extra_forbidden":
        return key, f"unknown key{_suggest_keys(section_class, location)}"
    message = fault["msg"].removeprefix("Value error, ")
    if fault["type"] == "model_type":
        message = "must be a section"
    if fault["type"] == "tuple_type":
        message = "must be a list"
    if fault["type"] == "string_unicode":
        message = "must be text in UTF-8, the encoding of studies (rename files whose names have another encoding)"
    if (template := _ERROR_MESSAGE_TEMPLATES.get(fault["type"])) is not None:
        message = template.format_map(fault.get("ctx", {}))
    if fault["type"] not in ("value_error", "missing", "range_or_list", "key", "too_short", "too_long"):
        message = f"{message[0].lower()}{message[1:]}, got {short_repr(fault['input'])}"
    return key, message


MAX_SUGGESTIONS = 3


def _suggest_keys(section_class: type[SettingsSection], location: list[int | str]) -> str:
    """Return a hint for an unknown key: similar keys of the section or, if there are none, how to list all keys."""
    known_classes = [section_class]
    for parent_key in location[:-1]:
        parent_fields = [
            known_class.model_fields[str(parent_key)]
            for known_class in known_classes
            if str(parent_key) in known_class.model_fields
        ]
        known_classes = [
            known_class for field in parent_fields for known_class in find_section_classes(field.annotation)
        ]
    keys = dict.fromkeys(name for known_class in known_classes for name in known_class.model_fields)
    keys |= dict.fromkeys(name for known_class in known_classes for name in getattr(known_class, "other_keys", ()))
    unknown_key = str(location[-1])[:MAX_WORD_LENGTH]
    similar_keys = [*difflib.get_close_matches(unknown_key, keys, n=3), *(name for name in keys if unknown_key in name)]
    names = " or ".join(map(repr, list(dict.fromkeys(similar_keys))[:MAX_SUGGESTIONS]))
    return f"; is it {names}?" if names else "; stiction studies --keys lists all"


def find_section_classes(annotation: Any) -> list[type[SettingsSection]]:
    """Return the section classes in a study field's type annotation, for example the members of a union."""
    if isinstance(annotation, type):
        return [annotation] if issubclass(annotation, SettingsSection) else []
    return [section_class for argument in get_args(annotation) for section_class in find_section_classes(argument)]
