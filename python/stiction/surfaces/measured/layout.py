"""A layout of texts, or of workbooks, that the program of an instrument writes."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from stiction.surfaces.measured.decode import Text
from stiction.surfaces.measured.raw import Content, FormatError

Sheets = Mapping[str, Sequence[Sequence[Any]]]  # rows of cells by the names of sheets

MAX_COUNT = 100_000_000  # points, or lines, that a header may declare
_NUMBER = re.compile(r"\s*([+-]?[0-9]{0,40}(?:[.,][0-9]{0,40})?(?:[eE][+-]?[0-9]{1,5})?)(?![0-9.,])")


def number(facts: Mapping[str, str], name: str, default: float | None = None) -> float:
    """Return the finite number that the value of a fact begins with; a `FormatError` without one."""
    text = facts.get(name.casefold())
    if text is None and default is not None:
        return default
    match = _NUMBER.match(text or "")
    try:
        value = float(match[1].replace(",", ".")) if match else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FormatError(f"lacks a number for {name}" if text is None else f"has {text[:40]!r} for {name}, no number")
    return value


def whole(facts: Mapping[str, str], name: str, least: int = 1, most: int = MAX_COUNT) -> int:
    """Return the whole number that the value of a fact begins with; a `FormatError` if it is outside its range."""
    value = number(facts, name)
    if not (value.is_integer() and least <= value <= most):
        raise FormatError(f"has {value:g} for {name}, which must be a whole number from {least} to {most}")
    return int(value)


@dataclass(frozen=True)
class Layout:
    """How the texts of an instrument are recognised and read."""

    name: str
    recognise: Callable[[Text], bool]
    read: Callable[[Text], Content]


@dataclass(frozen=True)
class WorkbookLayout:
    """How the workbooks of an instrument are recognised and read."""

    name: str
    recognise: Callable[[Sheets], bool]
    read: Callable[[Sheets], Content]
