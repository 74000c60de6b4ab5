"""Text file of friction tests: a line of column titles with units, and one test per row."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stiction._files import UnreadableFileError, describe_os_error, read_file_bytes
from stiction._text import printable_path, printable_text
from stiction._units import short_repr, unit_names
from stiction.calibration.friction_tests import FrictionTest
from stiction.surfaces.measured.decode import decode_text

FRICTION_TEST_COLUMNS = ("load", "force", "coefficient", "uncertainty", "pair", "run", "slid", "wait")
"""Standard names of the columns in a file of friction tests."""

_COLUMN_ALIASES = {
    "normal force": "load", "normal load": "load",
    "friction force": "force", "tangential force": "force",
    "friction coefficient": "coefficient", "coefficient of friction": "coefficient",
    "coefficient of static friction": "coefficient",
    "standard uncertainty": "uncertainty", "dwell time": "wait", "waiting time": "wait",
}  # fmt: skip
"""Standard column name for each alternative title."""

_COLUMN_UNITS = {
    "load": (*unit_names("force"), *unit_names("pressure")), "pressure": unit_names("pressure"),
    "force": unit_names("force"),
    "coefficient": ("", "1", "%"),
    "uncertainty": ("", "1", "%", *unit_names("force")), "wait": unit_names("time"),
}  # fmt: skip
"""Accepted units by column. Other columns have no unit. `pressure` is the column of loads given as pressures."""

_COLUMN_TITLE_EXAMPLES = {"load": "load (mN)", "force": "force (mN)", "wait": "wait (s)"}
MAX_FRICTION_TEST_FILE_BYTES = 10_000_000
_COLUMN_TITLE_PATTERN = re.compile(
    r"\s*(.*?)\s*(?:[(\[<{]\s*([^()\[\]<>{}]*?)\s*[)\]>}]|(?:/|\s+in\s)\s*([^\W\d_]{1,4}|%))?\s*"
)
_THOUSANDS_PATTERN = re.compile(r"[+-]?[1-9][0-9]{0,2}(,[0-9]{3})+")
_SLID_BY_CELL_TEXT = {"": True, "1": True, "yes": True, "true": True, "0": False, "no": False, "false": False}


def parse_friction_tests(path: str | Path, bodies: Mapping[str, Any]) -> tuple[FrictionTest, ...]:
    """Parse a table of friction tests.

    The table needs a column `load`, and a column `force` or `coefficient`.

    `FRICTION_TEST_COLUMNS` lists all columns. There may be a column of loads given as forces and another of loads given
    as pressures; each row then has its load in one of the two columns. Columns are separated by tabs, semicolons or
    commas. With tabs or semicolons, decimal commas are accepted. The column `pair` contains the name of a result or
    ball in `bodies`. Raises a `ValueError` with the line number if a line is invalid.
    """
    try:
        text = decode_text(read_file_bytes(Path(path), MAX_FRICTION_TEST_FILE_BYTES)).data.decode()
    except OSError as error:
        raise ValueError(f"{printable_path(path)}: cannot be read: {describe_os_error(error)}") from None
    except (ValueError, UnreadableFileError) as error:
        raise ValueError(f"{printable_path(path)} is not a table of friction tests: {error}") from None
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not _is_comment(line, bodies)
    ]
    if len(lines) < 2:
        raise ValueError(
            f"{printable_path(path)} has no tests; it must have a line of column names and a line for each test"
        )
    separator = next((character for character in "\t;" if character in lines[0][1]), ",")
    try:
        reader = csv.reader((f"{line}\n" for _, line in lines), delimiter=separator)
        rows, line_numbers = [], []
        # A row may extend over several lines, because quoted cells may contain line breaks.
        for row in reader:
            rows.append(row)
            line_numbers.append(lines[reader.line_num - 1][0])
        table = _FrictionTestTable(_parse_column_titles(rows[0]), line_numbers[1:], rows[1:], bodies, separator)
        return tuple(table.parse_rows())
    except (ValueError, csv.Error) as error:
        raise ValueError(f"{printable_path(path)}: {error}") from None


def _is_comment(line: str, bodies: Mapping[str, Any]) -> bool:
    """Return whether a line is a comment: it starts with "#", but not with a body name such as "#1"."""
    return line.startswith("#") and re.split("[\t;,]", line)[0].strip().rstrip("/") not in bodies


def _parse_column_titles(title_row: list[str]) -> dict[str, tuple[int, str]]:
    """Return the index and the unit of each table column, keyed by the standard name of the column.

    The name of a column of loads given as pressures is `pressure`.
    """
    columns: dict[str, tuple[int, str]] = {}
    for index, cell in enumerate(title_row):
        match = _COLUMN_TITLE_PATTERN.fullmatch(cell)
        name = " ".join(match[1].lower().split()) if match else ""
        name, unit = _COLUMN_ALIASES.get(name, name), (match[2] or match[3] or "") if match else ""
        if name not in FRICTION_TEST_COLUMNS:
            raise ValueError(
                f"has the unknown column {_quote_cell(cell)}; known columns are {', '.join(FRICTION_TEST_COLUMNS)}"
            )
        if name == "load" and unit in unit_names("pressure"):
            name = "pressure"
        if name in columns:
            title = {"load": "load in units of force", "pressure": "load in units of pressure"}.get(name, name)
            raise ValueError(f"has two columns for {title}; the second is {_quote_cell(cell)}")
        if unit not in (allowed := _COLUMN_UNITS.get(name, ("",))):
            raise ValueError(
                _describe_unit_error(
                    name, cell, [unit_name for unit_name in allowed if unit_name.isascii() and unit_name]
                )
            )
        columns[name] = index, "" if unit == "1" else unit
    if not {"load", "pressure"} & set(columns) or len({"force", "coefficient"} & set(columns)) != 1:
        raise ValueError("needs the columns load and either force or coefficient")
    if {"force", "pressure"} <= set(columns):
        raise ValueError(
            "needs the column coefficient instead of force if the load is a pressure, because the area of the specimen "
            "is unknown; coefficient = force / (pressure * area of the specimen)"
        )
    if "uncertainty" in columns:
        unit = columns["uncertainty"][1]
        if "force" in columns and not unit:
            raise ValueError('the column uncertainty needs a unit if there is a column force, as in "uncertainty (mN)"')
        if unit == "%" and columns.get("coefficient", (0, ""))[1] == "%":
            raise ValueError(
                "uncertainty (%) is ambiguous if coefficients are in %, because it could be absolute or relative; "
                "write coefficients as numbers, such as 0.25"
            )
        if not unit and columns.get("coefficient", (0, ""))[1] == "%":
            raise ValueError(
                "uncertainty without a unit is ambiguous if coefficients are in %; "
                "write coefficients as numbers, such as 0.25"
            )
    return columns


def _describe_unit_error(name: str, cell: str, allowed: list[str]) -> str:
    if name in _COLUMN_TITLE_EXAMPLES and _COLUMN_TITLE_PATTERN.fullmatch(cell)[2] is None:  # type: ignore[index]
        return f'the column {name} needs its unit, as in "{_COLUMN_TITLE_EXAMPLES[name]}"'
    if name == "coefficient":
        return (
            f'has the column {_quote_cell(cell)}, but a coefficient has no unit; name a column of forces "force (mN)"'
        )
    if not allowed:
        return f"has the column {_quote_cell(cell)}, but {name} has no unit"
    return f"has the column {_quote_cell(cell)}, but the unit of {name} must be one of {', '.join(allowed)}"


def _quote_cell(cell: str) -> str:
    return short_repr(printable_text(cell))


@dataclass(frozen=True)
class _FrictionTestTable:
    titles: Mapping[str, tuple[int, str]]
    lines: list[int]
    rows: list[list[str]]
    bodies: Mapping[str, Any]
    separator: str

    def parse_rows(self) -> Iterator[FrictionTest]:
        """Yield one friction test per row of the table."""
        number_columns = [index for name, (index, _) in self.titles.items() if name in _COLUMN_UNITS]
        cells_with_commas = [
            row[index].strip()
            for row in self.rows
            for index in number_columns
            if index < len(row) and "," in row[index]
        ]
        if cells_with_commas and all(_THOUSANDS_PATTERN.fullmatch(cell) for cell in cells_with_commas):
            raise ValueError(
                f"commas, as in {cells_with_commas[0]!r}, may be decimal commas or thousands separators; "
                "write decimal points"
            )
        for line, row in zip(self.lines, self.rows, strict=True):
            try:
                while len(row) > len(self.titles) and not row[-1].strip():
                    row.pop()
                if len(row) != len(self.titles):
                    hint = "; decimal commas need semicolons between columns" if self.separator == "," else ""
                    raise ValueError(f"has {len(row)} cells, but the line of column names has {len(self.titles)}{hint}")
                yield self._parse_row({name: row[index].strip() for name, (index, _) in self.titles.items()})
            except ValueError as error:
                raise ValueError(f"line {line}: {error}") from None

    def _parse_row(self, cells: dict[str, str]) -> FrictionTest:
        bodies = self.bodies
        name = cells.get("pair", "").rstrip("/") or (next(iter(bodies)) if len(bodies) == 1 else "")
        if name not in bodies:
            raise ValueError(f"pair must be one of {', '.join(bodies)}, got {short_repr(name)}")
        if (slid := _SLID_BY_CELL_TEXT.get(cells.get("slid", "").lower())) is None:
            raise ValueError(f"slid must be 1 if the pair slid and 0 otherwise, got {short_repr(cells['slid'])}")
        arguments: dict[str, Any] = {"slid": slid, "run": cells.get("run") or None}
        for key in ("force", "wait", "uncertainty"):
            if cells.get(key):
                arguments[key] = self._parse_quantity(key, cells[key])
        if "coefficient" in cells:
            value = _parse_decimal_number("coefficient", cells["coefficient"])
            arguments["coefficient"] = value / 100 if self.titles["coefficient"][1] == "%" else value
        return FrictionTest(bodies[name], self._parse_load(cells), **arguments)

    def _parse_load(self, cells: Mapping[str, str]) -> float | str:
        load_columns = [name for name in ("load", "pressure") if name in cells]
        filled_columns = [name for name in load_columns if cells[name]]
        if len(load_columns) == 2 and len(filled_columns) != 1:
            titles = " or ".join(f"load ({self.titles[name][1]})" for name in load_columns)
            raise ValueError(
                f"load must be in one of the columns {titles}, got {'both' if filled_columns else 'neither'}"
            )
        (name,) = filled_columns or load_columns
        return self._parse_quantity(name, cells[name])

    def _parse_quantity(self, name: str, cell: str) -> float | str:
        unit = self.titles[name][1]
        value = _parse_decimal_number("load" if name == "pressure" else name, cell)
        return f"{cell.replace(',', '.')} {unit}" if unit else value


def _parse_decimal_number(name: str, text: str) -> float:
    try:
        if text.count(",") + text.count(".") > 1:
            raise ValueError
        return float(text.replace(",", "."))
    except ValueError:
        raise ValueError(f"{name} must be a number, got {short_repr(text)}") from None
