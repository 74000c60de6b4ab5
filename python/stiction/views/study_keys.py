"""Tables of all keys in study files, for the documentation and for the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, get_args, get_origin

from pydantic import WrapValidator
from pydantic_core import PydanticUndefined

from stiction._units import Quantity
from stiction.mechanics.law import CONTACT_LAWS_BY_NAME
from stiction.study import values
from stiction.study.contact_settings import (
    CONTACT_SETTINGS_CLASSES,
    SETTINGS_CLASSES_BY_CONTACT_LAW,
    SHARED_CONTACT_SETTINGS_CLASSES,
)
from stiction.study.generated_surfaces import SelfAffineSettings
from stiction.study.input_distributions import INPUT_KINDS, InputValue
from stiction.study.measured_bodies import MeasuredBodySettings
from stiction.study.study import (
    FRICTION_SETTINGS_CLASSES,
    SHARED_FRICTION_SETTINGS_CLASSES,
    SURFACE_SETTINGS_CLASSES,
    EnsembleSettings,
    FigureSettings,
)
from stiction.views.layout import wrap_text

KeyTableRow = tuple[str, str, str, str]

_QUANTITY_RANGE_TEXTS: tuple[tuple[Any, str], ...] = (
    (values.Length, "a length above 0"),
    (values.LengthOrZero, "a length, at least 0"),
    (values.Modulus, "a pressure above 0"),
    (values.PressureOrZero, "a pressure, at least 0"),
    (values.Force, "a force above 0"),
    (values.Time, "a time above 0"),
    (values.WorkOfAdhesion, "an energy per area, at least 0"),
)
"""Allowed range in words for each type of quantity that a key can have."""

_DEGREES_TEXT = f"degrees from {-values.MAX_DIRECTION_DEGREES} to {values.MAX_DIRECTION_DEGREES}"
_ALLOWED_VALUE_TEXTS = {
    "law": " or ".join(
        [
            *(f'`"{name}"`' for name in CONTACT_LAWS_BY_NAME),
            *(f'a section with the name `"{name}"`' for name in SETTINGS_CLASSES_BY_CONTACT_LAW),
        ]
    ),
    "sliding": '`"opposing"`, `"all"` or a list of both',
    "unit": "a unit of length or a list of two",
    "spacing": "a length above 0 or a list of two",
    "channel": "a name or a number from 0",
    "columns": "a name or a number from 0, or a list of two",
    "sha256": "64 hexadecimal digits",
    "interface": "a name of `stiction interfaces`, or a file",
    "file": "a name",
    "upper": "a section, see below",
    "lower": "a section, see below",
}
"""Phrases for the allowed values of keys that have their own parsers, by key."""

_UNCERTAIN_VALUE_TEXT = "a range or a value with its uncertainty"
_CONTACT_DESCRIPTION = "Contact model of each pair. The default for measured areas is the half-space."
_FRICTION_DESCRIPTION = "Loads and friction parameters of measured surfaces, or of the figures of generated surfaces."
_ALL_CONTACT_SETTINGS_CLASSES = tuple(
    dict.fromkeys(case for cases in CONTACT_SETTINGS_CLASSES.values() for case in cases.values())
)
_KEY_TABLES: tuple[
    tuple[str, str, tuple[type[values.SettingsSection], ...], tuple[type[values.SettingsSectionVariant], ...]], ...
] = (
    ("`[surfaces]`, generated", "Fractal profiles, or two kinds of areal surfaces.", SURFACE_SETTINGS_CLASSES[:3], ()),
    (
        "`[surfaces]`, measured",
        "Two measured files and their combination into pairs.",
        SURFACE_SETTINGS_CLASSES[3:],
        (),
    ),
    ("`upper` and `lower` of measured surfaces", f"{MeasuredBodySettings.__doc__}", (MeasuredBodySettings,), ()),
    ("`[contact]`", _CONTACT_DESCRIPTION, _ALL_CONTACT_SETTINGS_CLASSES, SHARED_CONTACT_SETTINGS_CLASSES),
    ("`[friction]`", _FRICTION_DESCRIPTION, FRICTION_SETTINGS_CLASSES, SHARED_FRICTION_SETTINGS_CLASSES),
    ("`[ensemble]`", f"{EnsembleSettings.__doc__}", (EnsembleSettings,), ()),
    ("`[figures]` of generated surfaces", f"{FigureSettings.__doc__}", (FigureSettings,), ()),
)
"""Key tables, one per section of a study file: title, description, classes, and base classes with shared keys."""


def list_key_tables() -> list[tuple[str, str, list[KeyTableRow]]]:
    """Return the title, description and rows of each table of study-file keys.

    Each key has one row.
    """
    tables = []
    for title, phrases, section_classes, base_classes in _KEY_TABLES:
        classes_by_row: dict[KeyTableRow, list[type[values.SettingsSection]]] = {}
        for section_class in section_classes:
            for key, field in section_class.model_fields.items():
                # Fields without `repr` contain bodies in memory, which are not keys of study files.
                if field.repr:
                    default = PydanticUndefined if field.is_required() else field.default
                    classes_by_row.setdefault(_key_row(key, default, field, section_classes), []).append(section_class)
        keys, rows = list(dict.fromkeys(row[0] for row in classes_by_row)), []
        for (key, default, allowed_values, meaning), key_owners in sorted(
            classes_by_row.items(), key=lambda item: keys.index(item[0][0])
        ):
            text = (
                ""
                if len(key_owners) == len(section_classes)
                else f" Only for {_join_with_and(_models_with_key(key_owners, section_classes, base_classes))}."
            )
            rows.append((key, default, allowed_values, meaning + text))
        for section_class in section_classes:
            if issubclass(section_class, SelfAffineSettings):
                other_keys = section_class.other_keys.items()
                rows += [
                    (f"`{key}`", "none", allowed_values, f"{text} Only for {section_class.place}.")
                    for key, (allowed_values, text) in other_keys
                ]
        tables.append((title, phrases, rows))
    return tables


def _models_with_key(
    owners: Sequence[type[values.SettingsSection]],
    section_classes: Sequence[type[values.SettingsSection]],
    base_classes: Sequence[type[values.SettingsSectionVariant]],
) -> list[str]:
    """Return a description of each kind of study-file section that may contain a given key.

    If all subclasses of a base class have the key, the description of the base class replaces their descriptions.
    """
    subclasses = {
        item: {section_class for section_class in section_classes if issubclass(section_class, item)}
        for item in base_classes
    }
    remaining_classes, class_names = set(owners), []
    for item in sorted(base_classes, key=lambda item: -len(subclasses[item])):
        if subclasses[item] <= remaining_classes:
            class_names.append(item.place)
            remaining_classes -= subclasses[item]
    return class_names + [
        section_class.place
        for section_class in section_classes
        if section_class in remaining_classes and issubclass(section_class, values.SettingsSectionVariant)
    ]


def study_keys_markdown() -> str:
    """Return the key tables of all sections of a study file as Markdown."""
    lines = []
    for title, phrases, rows in list_key_tables():
        lines += [f"## {title}", "", phrases, "", "| key | value | meaning |", "|---|---|---|"]
        for key, default, allowed_values, meaning in rows:
            lines.append(markdown_row((key, _value_text(default, allowed_values), meaning)))
        lines.append("")
    return "\n".join(lines)


def _value_text(default: str, allowed_values: str) -> str:
    """Return one table cell, narrow enough for small screens, with the allowed values and the default of a key."""
    match default:
        case "none":
            return allowed_values
        case "required":
            return f"{allowed_values}; required"
        case _:
            return default if default == allowed_values else f"{allowed_values}; default {default}"


def study_keys_text() -> str:
    """Return all keys of study files as text, with one paragraph per key."""
    blocks = []
    for title, _, rows in list_key_tables():
        lines = [title.replace("`", "")]
        for row in rows:
            key, default, allowed_values, meaning = (cell.replace("`", "") for cell in row)
            lines.append(
                wrap_text(f"{key} = {default}: {allowed_values}. {meaning}", indent="  ", hanging_indent="    ")
            )
        blocks.append("\n".join(lines))
    return "\n\n".join(blocks) + "\n"


def _key_row(
    key: str, default_value: Any, field_info: Any, section_classes: tuple[Any, ...]
) -> tuple[str, str, str, str]:
    """Return the table row of a study-file key: its name, default, allowed values and meaning.

    A key that selects a model class has a single row for all classes.
    """
    default = "required" if default_value is PydanticUndefined else _toml_default(default_value)
    if key not in ("generator", "press", "mechanics"):
        return f"`{key}`", default, _allowed_values_text(key, field_info), str(field_info.description)
    fields = [section_class.model_fields[key] for section_class in section_classes if key in section_class.model_fields]
    case_meanings = dict.fromkeys(
        f'`"{field.default}"`: {str(field.description).removesuffix(".")}' for field in fields
    )
    allowed_values = list(dict.fromkeys(f'`"{field.default}"`' for field in fields))
    return f"`{key}`", _toml_default(fields[0].default), _join_with_or(allowed_values), "; ".join(case_meanings) + "."


def _allowed_values_text(key: str, field_info: Any) -> str:
    if key in INPUT_KINDS and _accepts_type(field_info.annotation, InputValue):
        unit_text = "a pressure" if INPUT_KINDS[key] else "a number"
        count_text = "one or two of: " if _accepts_type(field_info.annotation, tuple) else ""
        return f"{count_text}{unit_text}, {_UNCERTAIN_VALUE_TEXT}"
    if any(isinstance(item, WrapValidator) for item in field_info.metadata):
        (text,) = _allowed_value_phrases(field_info.annotation, field_info.metadata)
        return f"{text}; or {_UNCERTAIN_VALUE_TEXT}"
    if key == "direction":
        singular_phrase = f'`"+x"`, `"-x"` or {_DEGREES_TEXT}'
        return f"{singular_phrase}, or a list of these"
    return _ALLOWED_VALUE_TEXTS.get(key) or _join_with_or(
        _allowed_value_phrases(field_info.annotation, field_info.metadata)
    )


def _accepts_type(annotation: Any, kind: type) -> bool:
    """Return whether a type annotation is the type `kind`, or contains this type."""
    return kind in (annotation, get_origin(annotation)) or any(
        _accepts_type(argument, kind) for argument in get_args(annotation)
    )


def _join_with_and(phrases: list[str]) -> str:
    return ", ".join(phrases[:-1]) + " and " + phrases[-1] if len(phrases) > 1 else phrases[0]


def markdown_row(cells: Sequence[str]) -> str:
    """Return a row of a Markdown table."""
    return "| " + " | ".join(cell.replace("|", r"\|").replace("E*", r"E\*") for cell in cells) + " |"


def _allowed_value_phrases(annotation: Any, metadata: Sequence[Any] = ()) -> list[str]:
    """Return a phrase for each kind of value that a type annotation allows, such as "a length"."""
    for quantity_type, phrases in _QUANTITY_RANGE_TEXTS:
        if annotation is quantity_type or any(item in metadata for item in quantity_type.__metadata__[:1]):
            return [phrases]
    # A `Quantity` without metadata is the spacing of a measured file: a length, which has its own parser.
    if annotation is Quantity:
        return ["a length"]
    if get_origin(annotation) is Literal:
        return [f"`{_toml_text(value)}`" for value in get_args(annotation)]
    if isinstance(annotation, type) and issubclass(annotation, values.SettingsSection):
        if "start" in annotation.model_fields:
            spacing = ", spacing" if "spacing" in annotation.model_fields else ""
            return [f"a range `{{ start, stop, count{spacing} }}`"]
        return [f"a section of {', '.join(f'`{name}`' for name in annotation.model_fields)}"]
    if get_origin(annotation) is tuple:
        items = [item for item in get_args(annotation) if item is not Ellipsis]
        text = _join_with_or(list(dict.fromkeys(phrases for item in items for phrases in _allowed_value_phrases(item))))
        for singular_phrase, plural_phrase in _NUMBER_LIST_TEXTS:
            text = text.replace(singular_phrase, plural_phrase)
        return [f"a list of {text}" if Ellipsis in get_args(annotation) else f"a list of {len(items)} {text}"]
    if hasattr(annotation, "__metadata__"):
        return _allowed_value_phrases(annotation.__origin__, annotation.__metadata__)
    if get_origin(annotation) is not None:
        alternatives = [_allowed_value_phrases(item) for item in get_args(annotation) if item is not type(None)]
        return list(dict.fromkeys(phrases for alternative in alternatives for phrases in alternative))
    bounds = {
        name: getattr(item, name)
        for item in _flatten_constraints(metadata)
        for name in _BOUND_WORDS
        if hasattr(item, name)
    }
    kind_name = {bool: "`true` or `false`", int: "a whole number", float: "a number", str: "a name"}[annotation]
    return [" ".join([kind_name, *(f"{_BOUND_WORDS[name]} {_format_bound(bound)}" for name, bound in bounds.items())])]


_NUMBER_LIST_TEXTS = tuple(
    (f"a {singular_phrase}", f"{singular_phrase}s")
    for singular_phrase in ("length", "pressure", "force", "time", "number", "whole number", "name")
)
_BOUND_WORDS = {"ge": "from", "gt": "above", "le": "to", "lt": "to below"}


def _flatten_constraints(metadata: Sequence[Any]) -> list[Any]:
    """Return all constraints in the metadata of a type annotation, including constraints inside a pydantic `Field`."""
    return [part for item in metadata for part in (item, *getattr(item, "metadata", ()))]


def _format_bound(end: float) -> str:
    exponent_of_two = round(math.log2(end)) if end > 1e9 else 0
    return f"2^{exponent_of_two}" if exponent_of_two and 2**exponent_of_two == end else f"{end:,}".replace(",", " ")


def _join_with_or(phrases: list[str]) -> str:
    return ", ".join(phrases[:-1]) + " or " + phrases[-1] if len(phrases) > 1 else phrases[0]


def _toml_default(value: Any) -> str:
    """Return the default of a key as Markdown code in TOML notation, or "none"."""
    if value is None:
        return "none"
    return f"`{_toml_text(value)}`"


def _toml_text(value: Any) -> str:
    if isinstance(value, Quantity):
        return f'"{value.text}"'
    if isinstance(value, tuple):
        return f"[{', '.join(map(_toml_text, value))}]"
    if isinstance(value, values.SettingsSection):
        entries = ((name, _toml_text(getattr(value, name))) for name in type(value).model_fields)
        return f"{{ {', '.join(f'{name} = {text}' for name, text in entries)} }}"
    if isinstance(value, bool):
        return "true" if value else "false"
    return f'"{value}"' if isinstance(value, str) else f"{value}"
