"""Friction tests in a table of text: a line of column names with units, and a row per test."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stiction._files import NotReadableError, describe_os_error, read_content
from stiction._text import printable, printable_path
from stiction._units import short_repr, unit_names
from stiction.studies.interfaces import FrictionTest
from stiction.surfaces.measured.decode import decode

TEST_COLUMNS = ("load", "force", "coefficient", "uncertainty", "pair", "run", "slid", "wait")
"""Names of columns."""

_COLUMN_ALIASES = {
    "normal force": "load", "normal load": "load",
    "friction force": "force", "tangential force": "force",
    "friction coefficient": "coefficient", "coefficient of friction": "coefficient",
    "coefficient of static friction": "coefficient",
    "standard uncertainty": "uncertainty", "dwell time": "wait", "waiting time": "wait",
}  # fmt: skip
"""Other names of columns."""

_COLUMN_UNITS = {
    "load": (*unit_names("force"), *unit_names("pressure")), "force": unit_names("force"),
    "coefficient": ("", "1", "%"),
    "uncertainty": ("", "1", "%", *unit_names("force")), "wait": unit_names("time"),
}  # fmt: skip
"""Units of each column; one without an entry has none."""

_TITLE_EXAMPLES = {"load": "load (mN)", "force": "force (mN)", "wait": "wait (s)"}
MAX_TEST_FILE_BYTES = 10_000_000
_TITLE_PATTERN = re.compile(
    r"\s*(.*?)\s*(?:[(\[<{]\s*([^()\[\]<>{}]*?)\s*[)\]>}]|(?:/|\s+in\s)\s*([^\W\d_]{1,4}|%))?\s*"
)
_THOUSANDS_PATTERN = re.compile(r"[+-]?[1-9][0-9]{0,2}(,[0-9]{3})+")
_SLID_VALUES = {"": True, "1": True, "yes": True, "true": True, "0": False, "no": False, "false": False}


def parse_friction_tests(path: str | Path, bodies: Mapping[str, Any]) -> tuple[FrictionTest, ...]:
    """Return the tests of a table with the columns load and force or coefficient, and others of `TEST_COLUMNS`.

    Columns are between tabs, semicolons or commas; beside tabs and semicolons decimals may be after commas. The column
    pair names one of the bodies, results or balls. A `ValueError` names the line that does not fit its columns.
    """
    try:
        text = decode(read_content(Path(path), MAX_TEST_FILE_BYTES)).data.decode()
    except OSError as error:
        raise ValueError(f"{printable_path(path)}: cannot be read: {describe_os_error(error)}") from None
    except (ValueError, NotReadableError) as error:
        raise ValueError(f"{printable_path(path)}: is not a table of friction tests: {error}") from None
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip() and line[0] != "#"]
    if len(lines) < 2:
        raise ValueError(f"{printable_path(path)}: has no tests: a line of names and a line for each test are needed")
    separator = next((each for each in "\t;" if each in lines[0][1]), ",")
    try:
        reader = csv.reader((f"{line}\n" for _, line in lines), delimiter=separator)
        rows, numbers = [], []
        for row in reader:  # which may contain line ends in quotes
            rows.append(row)
            numbers.append(lines[reader.line_num - 1][0])
        table = _Table(_parse_titles(rows[0]), numbers[1:], rows[1:], bodies, separator)
        return tuple(table.tests())
    except (ValueError, csv.Error) as error:
        raise ValueError(f"{printable_path(path)}: {error}") from None


def _parse_titles(head: list[str]) -> dict[str, tuple[int, str]]:
    """Place and unit of each column."""
    found: dict[str, tuple[int, str]] = {}
    for place, cell in enumerate(head):
        match = _TITLE_PATTERN.fullmatch(cell)
        name = " ".join(match[1].lower().split()) if match else ""
        name, unit = _COLUMN_ALIASES.get(name, name), (match[2] or match[3] or "") if match else ""
        if name not in TEST_COLUMNS:
            raise ValueError(f"has the column {_shown(cell)}, and may have each of {', '.join(TEST_COLUMNS)}")
        if name in found:
            raise ValueError(f"has two columns of {name}, the second one {_shown(cell)}")
        if unit not in (allowed := _COLUMN_UNITS.get(name, ("",))):
            raise ValueError(_wrong_unit(name, cell, [each for each in allowed if each.isascii() and each]))
        found[name] = place, "" if unit == "1" else unit
    if "load" not in found or len({"force", "coefficient"} & set(found)) != 1:
        raise ValueError("needs the columns load and either force or coefficient")
    if "uncertainty" in found:
        unit = found["uncertainty"][1]
        if "force" in found and not unit:
            raise ValueError('uncertainty beside force needs a unit, as in "uncertainty (mN)" or "uncertainty (%)"')
        if unit == "%" and found.get("coefficient", (0, ""))[1] == "%":
            raise ValueError(
                'uncertainty (%) beside coefficient (%) may be relative or not: give coefficients as numbers, "0.25"'
            )
        if not unit and found.get("coefficient", (0, ""))[1] == "%":
            raise ValueError(
                'uncertainty beside coefficient (%) may be in percent or not: give coefficients as numbers, "0.25"'
            )
    return found


def _wrong_unit(name: str, cell: str, allowed: list[str]) -> str:
    if name in _TITLE_EXAMPLES and _TITLE_PATTERN.fullmatch(cell)[2] is None:  # type: ignore[index]
        return f'the column {name} needs its unit, as in "{_TITLE_EXAMPLES[name]}"'
    if name == "coefficient":
        return f'has the column {_shown(cell)}, and a coefficient has no unit: forces go under "force (mN)"'
    if not allowed:
        return f"has the column {_shown(cell)}, and {name} has no unit"
    return f"has the column {_shown(cell)}, and {name} has one of the units {', '.join(allowed)}"


def _shown(cell: str) -> str:
    return short_repr(printable(cell))


@dataclass(frozen=True)
class _Table:
    titles: Mapping[str, tuple[int, str]]
    lines: list[int]
    rows: list[list[str]]
    bodies: Mapping[str, Any]
    separator: str

    def tests(self) -> Iterator[FrictionTest]:
        """The tests of all rows."""
        numbers = [place for name, (place, _) in self.titles.items() if name in _COLUMN_UNITS]
        commas = [
            row[place].strip() for row in self.rows for place in numbers if place < len(row) and "," in row[place]
        ]
        if commas and all(_THOUSANDS_PATTERN.fullmatch(cell) for cell in commas):
            raise ValueError(f"its commas, as in {commas[0]!r}, may be decimal or part thousands; write decimal points")
        for line, row in zip(self.lines, self.rows, strict=True):
            try:
                while len(row) > len(self.titles) and not row[-1].strip():
                    row.pop()
                if len(row) != len(self.titles):
                    hint = "; decimal commas need semicolons between columns" if self.separator == "," else ""
                    raise ValueError(f"has {len(row)} cells, and the line of names {len(self.titles)}{hint}")
                yield self._test({name: row[place].strip() for name, (place, _) in self.titles.items()})
            except ValueError as error:
                raise ValueError(f"line {line}: {error}") from None

    def _test(self, cells: dict[str, str]) -> FrictionTest:
        bodies = self.bodies
        name = cells.get("pair", "").rstrip("/") or (next(iter(bodies)) if len(bodies) == 1 else "")
        if name not in bodies:
            raise ValueError(f"pair must be one of {', '.join(bodies)}, got {short_repr(name)}")
        if (slid := _SLID_VALUES.get(cells.get("slid", "").lower())) is None:
            raise ValueError(f"slid must be 1, or 0 where it held, got {short_repr(cells['slid'])}")
        asked: dict[str, Any] = {"slid": slid, "run": cells.get("run") or None}
        for each in ("force", "wait", "uncertainty"):
            if cells.get(each):
                asked[each] = self._quantity(each, cells[each])
        if "coefficient" in cells:
            value = _number("coefficient", cells["coefficient"])
            asked["coefficient"] = value / 100 if self.titles["coefficient"][1] == "%" else value
        return FrictionTest(bodies[name], self._quantity("load", cells["load"]), **asked)

    def _quantity(self, name: str, cell: str) -> float | str:
        unit = self.titles[name][1]
        value = _number(name, cell)
        return f"{cell.replace(',', '.')} {unit}" if unit else value


def _number(name: str, text: str) -> float:
    try:
        if text.count(",") + text.count(".") > 1:
            raise ValueError
        return float(text.replace(",", "."))
    except ValueError:
        raise ValueError(f"{name} must be a number, got {short_repr(text)}") from None
