"""A layout of texts, or of workbooks, that the program of an instrument writes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from stiction.surfaces.measured.decode import Text
from stiction.surfaces.measured.raw import Content

Sheets = Mapping[str, Sequence[Sequence[Any]]]  # rows of cells by the names of sheets


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
