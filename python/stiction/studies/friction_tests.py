"""Friction tests from a table in a text file: a row a test, with units in the heads of its columns."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from stiction._files import NotReadableError, content, reason
from stiction._text import named, printable
from stiction._units import shortened
from stiction.studies.calibration import FrictionTest

COLUMNS = ("load", "force", "coefficient", "uncertainty", "pair", "run", "slid", "wait")
"""Names of columns; load and force need a unit, uncertainty may be in percent."""

LONGEST_FILE = 10_000_000  # largest number of bytes of a table
_TITLE = re.compile(r"\s*([^()]*?)\s*(?:\(\s*([^()]*?)\s*\))?\s*")
_SLID = {"": True, "1": True, "yes": True, "true": True, "0": False, "no": False, "false": False}


def friction_tests(path: str | Path, bodies: Mapping[str, Any]) -> tuple[FrictionTest, ...]:
    """The tests of a table with the columns load and force or coefficient, and others of `COLUMNS`.

    Parameters
    ----------
    path : path
        Text whose cells are separated by commas, semicolons or tabs; lines that begin with # are skipped.
    bodies : mapping of str to Result, HalfSpaceCurve, LoadCurve or Ball
        What may stand in the column pair, which may be missing where there is one.

    Raises
    ------
    ValueError
        If it cannot be read, or a cell is not what its column says; the message has the number of the line.
    """
    try:
        text = content(Path(path), LONGEST_FILE).decode("utf-8-sig")
    except OSError as error:
        raise ValueError(f"{named(path)}: cannot be read: {reason(error)}") from None
    except (UnicodeDecodeError, NotReadableError) as error:
        raise ValueError(f"{named(path)}: is no table of friction tests: {error}") from None
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip() and line[0] != "#"]
    if len(lines) < 2:
        raise ValueError(f"{named(path)}: has no tests: a line of names and a line for each test are needed")
    separator = next((each for each in "\t;" if each in lines[0][1]), ",")
    table = zip(
        (number for number, _ in lines), csv.reader((line for _, line in lines), delimiter=separator), strict=False
    )
    try:
        titles = _titles(next(table)[1])
        return tuple(_tests(table, titles, bodies))
    except (ValueError, csv.Error) as error:
        raise ValueError(f"{named(path)}: {error}") from None


def _titles(head: list[str]) -> dict[str, tuple[int, str]]:
    """Place and unit of each column."""
    found: dict[str, tuple[int, str]] = {}
    for place, cell in enumerate(head):
        match = _TITLE.fullmatch(cell)
        name = match[1].lower() if match else ""
        if not match or name not in COLUMNS or name in found:
            raise ValueError(f"has the column {shortened(printable(cell))}, and may have each of {', '.join(COLUMNS)}")
        found[name] = place, match[2] or ""
    if "load" not in found or len({"force", "coefficient"} & set(found)) != 1:
        raise ValueError("needs the columns load and either force or coefficient")
    for name in {"load", "force", "wait"} & set(found):
        if not found[name][1]:
            raise ValueError(f'the column {name} needs its unit, as in "{name} ({"s" if name == "wait" else "mN"})"')
    if "force" in found and "uncertainty" in found and not found["uncertainty"][1]:
        raise ValueError('uncertainty beside force needs a unit, as in "uncertainty (mN)" or "uncertainty (%)"')
    return found


def _tests(rows: Any, titles: dict[str, tuple[int, str]], bodies: Mapping[str, Any]) -> Iterator[FrictionTest]:
    for number, row in rows:
        try:
            if len(row) != len(titles):
                raise ValueError(f"has {len(row)} cells, and the first line {len(titles)}")
            cells = {name: row[place].strip() for name, (place, _) in titles.items()}
            yield _test(cells, {name: unit for name, (_, unit) in titles.items()}, bodies)
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from None


def _test(cells: dict[str, str], units: dict[str, str], bodies: Mapping[str, Any]) -> FrictionTest:
    name = cells.get("pair", "").rstrip("/") or (next(iter(bodies)) if len(bodies) == 1 else "")
    if name not in bodies:
        raise ValueError(f"pair must be one of {', '.join(bodies)}, got {shortened(name)}")
    if (slid := _SLID.get(cells.get("slid", "").lower())) is None:
        raise ValueError(f"slid must be 1, or 0 where it held, got {shortened(cells['slid'])}")
    asked: dict[str, Any] = {"slid": slid, "run": cells.get("run") or None}
    if cells.get("wait"):
        asked["wait"] = f"{cells['wait']} {units['wait']}"
    measured: dict[str, Any] = {}
    for each in {"force", "coefficient"} & set(cells):
        measured[each] = f"{cells[each]} {units[each]}" if each == "force" else _number(each, cells[each])
    test = FrictionTest(bodies[name], f"{cells['load']} {units['load']}", **measured, **asked)
    if not (error := cells.get("uncertainty")):
        return test
    unit, value = units["uncertainty"], float(test.coefficient or 0.0)
    if unit == "%":
        measured, uncertainty = {"coefficient": value}, 0.01 * _number("uncertainty", error) * value
    else:
        uncertainty = f"{error} {unit}" if unit else _number("uncertainty", error)  # type: ignore[assignment]
    return FrictionTest(bodies[name], test.load, uncertainty=uncertainty, **measured, **asked)


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{name} must be a number, got {shortened(text)}") from None
