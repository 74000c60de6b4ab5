"""The text of a study file: TOML, read within bounds and written, and its faults in words."""

from __future__ import annotations

import difflib
import json
import tomllib
from collections.abc import Mapping
from typing import Any, TypeVar, get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from stiction._text import LONGEST_WORD, named, printable
from stiction._units import shortened
from stiction.studies.values import LIST, RANGE, Table

_Kind = TypeVar("_Kind", bound=Table)


class StudyError(ValueError):
    """A study that cannot be: one line per fault, each naming its key."""


def as_toml(value: Any) -> str:
    """A value of a study file."""
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
            written = [f"{key} = {as_toml(item)}" for key, item in value.items() if key != "body"]  # which is in memory
            return "{ " + ", ".join(written) + " }"
        case _:
            return "[" + ", ".join(as_toml(item) for item in value) + "]"


def toml(text: str) -> dict[str, Any]:
    """What a TOML text says; a `ValueError` if it is not TOML, or is deeper than any study."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("it is too deep") from None


def validated(kind: type[_Kind], data: Mapping[str, Any], source: str) -> _Kind:
    """A table of that kind with its data; errors call it by the name of its source."""
    try:
        return kind.model_validate(data)
    except ValidationError as error:
        faults = error.errors(include_url=False)
        lines = [f"{named(source)}: {_fault(kind, fault)}" for fault in faults[:5]]
        if len(faults) > 5:
            lines.append(f"{named(source)}: ... and {len(faults) - 5} more")
        raise StudyError("\n".join(lines)) from None


def _fault(kind: type[Table], fault: ErrorDetails) -> str:
    location = [part for part in fault["loc"] if part not in (RANGE, LIST)]
    key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in location).removeprefix(".")
    if fault["type"] == "key":
        key += f".{fault['ctx']['key']}"
    key = printable(key)
    if fault["type"] == "extra_forbidden":
        return f"{key}: unknown key{_suggestion(kind, location)}"
    message = fault["msg"].removeprefix("Value error, ")
    if fault["type"] == "model_type":
        message = "must be a table"
    if fault["type"] == "tuple_type":
        message = "must be a list"
    if fault["type"] == "string_unicode":
        message = "must be text in UTF-8, as the study that keeps it is (rename a file that is not)"
    if fault["type"] not in ("value_error", "missing", "range_or_list", "key", "too_short", "too_long"):
        message = f"{message[0].lower()}{message[1:]}, got {shortened(fault['input'])}"
    return f"{key}: {message}" if key else message


def _suggestion(kind: type[Table], location: list[int | str]) -> str:
    """Which key was meant, of all cases that the table may be of."""
    tables = [kind]
    for part in location[:-1]:
        fields = [table.model_fields[str(part)] for table in tables if str(part) in table.model_fields]
        tables = [table for field in fields for table in tables_of(field.annotation)]
    known = dict.fromkeys(name for table in tables for name in table.model_fields)
    close = difflib.get_close_matches(str(location[-1])[:LONGEST_WORD], known, n=1)
    return f"; is it {close[0]!r}?" if close else ""


def tables_of(annotation: Any) -> list[type[Table]]:
    """The tables that a value of this type may be."""
    if isinstance(annotation, type):
        return [annotation] if issubclass(annotation, Table) else []
    return [table for part in get_args(annotation) for table in tables_of(part)]
