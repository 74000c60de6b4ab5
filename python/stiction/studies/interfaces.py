"""Strengths of interfaces as files, those that were read in a source by their names, and tables of friction tests.

A file is a table of draws, mu0, tau0 and hardness, under a head of lines that begin with "# ": who reads it elsewhere
skips these.
"""

from __future__ import annotations

import contextlib
import csv
import io
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache, lru_cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._files import NotReadableError, content, reason, replaced_file
from stiction._text import named, printable
from stiction._units import shortened
from stiction.studies.calibration import Fit, FrictionTest, Interface, highest_density
from stiction.studies.known import Known, draws, known

if TYPE_CHECKING:
    from stiction.studies.study import Study

HEAD = "# stiction interface"  # first line of a file
COLUMNS = ("mu0", "tau0 (GPa)", "hardness (GPa)")
LONGEST_FILE = 50_000_000  # largest number of bytes of a file of an interface
_NUMBERS = ("area_per_load", "variation")


def write_interface(interface: Interface, path: str | Path, about: Mapping[str, str] | None = None) -> None:
    """Write an interface as a text file: its head, and a row a draw.

    Parameters
    ----------
    interface : Interface
    path : path
    about : mapping of str to str, optional
        Materials, conditions, who measured: lines of the head.

    Raises
    ------
    ValueError
        If something else has that name, or the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from stiction import interface, read_interface, write_interface
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "film.csv"
    ...     write_interface(interface("MoS2 on bearing steel, dry air"), path, {"operator": "A. B."})
    ...     read_interface(path).about["operator"]
    'A. B.'
    """
    head = {
        "sliding": interface.fits[0].sliding,
        "area_per_load": repr(interface.area_per_load),
        "variation": repr(interface.variation),
        "separated": "yes" if interface.separated else "no",
        **{key: " ".join(str(value).split()) for key, value in {**interface.about, **(about or {})}.items()},
    }
    text = io.StringIO()
    text.write("\n".join([HEAD, *(f"# {key}: {value}" for key, value in head.items()), ",".join(COLUMNS)]) + "\n")
    fit = interface.fits[0]
    np.savetxt(text, np.stack([fit.mu0, fit.tau0, fit.hardness], axis=1), fmt="%.9g", delimiter=",")
    with replaced_file(Path(path), HEAD.encode(), ValueError) as file:
        file.write_text(text.getvalue(), encoding="utf-8")


def read_interface(path: str | Path) -> Interface:
    """Read what `write_interface` wrote.

    Raises
    ------
    ValueError
        If it cannot be read, or is no such file.

    Examples
    --------
    >>> from stiction import read_interface
    >>> read_interface("no such file")
    Traceback (most recent call last):
    ...
    ValueError: no such file: cannot be read as an interface: No such file or directory
    """
    try:
        lines = content(Path(path), LONGEST_FILE).decode("utf-8").splitlines()
    except OSError as error:
        raise ValueError(f"{named(path)}: cannot be read as an interface: {reason(error)}") from None
    except UnicodeDecodeError:
        raise ValueError(f"{named(path)}: is not a text file, so it is no interface") from None
    head = dict(line[2:].partition(": ")[::2] for line in lines[1:] if line.startswith("# "))
    rows = [line for line in lines if line and not line.startswith("#")]
    if not lines or lines[0] != HEAD or not rows or tuple(next(csv.reader(rows))) != COLUMNS:
        raise ValueError(f"{named(path)}: is no interface: its first line is not {HEAD!r}")
    try:
        table = np.array([[float(cell) for cell in row] for row in csv.reader(rows[1:])])
        ratio, variation = (float(head.pop(name)) for name in _NUMBERS)
        sliding, separated = head.pop("sliding"), head.pop("separated") == "yes"
    except (ValueError, KeyError):
        said = "an entry of its head is missing, or a row is not of three numbers"
        raise ValueError(f"{named(path)}: is a damaged interface: {said}") from None
    if table.ndim != 2 or table.shape[1] != 3 or not (np.isfinite(table[:, :2]) & (table[:, :2] >= 0)).all():
        raise ValueError(f"{named(path)}: is a damaged interface: mu0 and tau0 must be numbers of at least 0")
    fit = _fit(sliding, *table.T)
    return Interface((fit,), ratio, variation, separated, about=head)


def _fit(sliding: Any, mu0: Any, tau0: Any, hardness: Any) -> Fit:
    return Fit(sliding, math.nan, 0, math.nan, 1.0, math.nan, mu0, tau0, hardness)


@cache
def interfaces() -> dict[str, dict[str, str]]:
    """Interfaces whose strength was read in a source, by name: what is known of each, as text.

    Examples
    --------
    >>> from stiction import interfaces
    >>> interfaces()["MoS2 on bearing steel, dry air"]["kind"]
    'measured'
    """
    text = (resources.files("stiction.studies") / "interfaces.toml").read_text(encoding="utf-8")
    return {str(name): table for name, table in tomllib.loads(text).items()}


def interfaces_in(folder: str | Path) -> dict[str, dict[str, str]]:
    """What `interfaces` gives, of the files in a folder that `write_interface` wrote; others are passed over."""
    found = {}
    try:
        paths = sorted(path for path in Path(folder).iterdir() if path.is_file())
    except OSError as error:
        raise ValueError(f"{named(folder)}: cannot be listed: {reason(error)}") from None
    for path in paths:
        with contextlib.suppress(ValueError):
            own = read_interface(path)
            fit, about = own.fits[0], {"kind": "measured", **own.about}
            low, high = zip(*(highest_density(each, 0.0)[1:] for each in (fit.mu0, 1e3 * fit.tau0)), strict=True)
            found[path.name] = about | {
                "mu0": f"{low[0]:.3g}..{high[0]:.3g}", "tau0": f"{low[1]:.3g}..{high[1]:.3g} MPa",
                "area_per_load": f"{own.area_per_load:.3g} /GPa",
            }  # fmt: skip
    return found


def interface(name_or_path: str | Path) -> Interface:
    """An interface by its name, one of `interfaces`, or from the file that `stiction calibrate` wrote.

    Raises
    ------
    ValueError
        If there is no such name or file.

    Examples
    --------
    >>> from stiction import interface
    >>> interface("MoS2 on bearing steel, dry air").about["motion"]
    'kinetic'
    """
    table = interfaces().get(str(name_or_path))
    if table is None:
        if Path(name_or_path).is_file():
            return read_interface(name_or_path)
        names = "; ".join(interfaces())
        raise ValueError(f"interface must be a file or one of {names}, got {str(name_or_path)!r}")
    ranges: dict[str, Known] = {"mu0": known("mu0", table["mu0"]), "tau0": known("tau0", table["tau0"], "pressure")}
    values = draws(ranges)
    fit = _fit("all", values["mu0"], values["tau0"], np.full(values["mu0"].size, math.nan))
    about = {key: text for key, text in table.items() if key not in ranges}
    return Interface((fit,), math.nan, math.nan, separated=True, about={"name": str(name_or_path), **about})


def interface_of(study: Study) -> Interface | None:
    """The strength by which a study was asked for; None where it was by none, or that is gone or another by now."""
    text = study.known.interface
    if text is None:
        return None
    try:
        found = _kept(text, 0 if text in interfaces() else Path(text).stat().st_mtime_ns)
    except (ValueError, OSError):
        return None
    mu0, tau0 = medians(found)
    return found if study.friction.mu0 == (mu0,) and [float(each) for each in study.friction.tau0] == [tau0] else None


@lru_cache(maxsize=8)
def _kept(text: str, _changed: int) -> Interface:
    return interface(text)


def medians(found: Interface) -> tuple[float, float]:
    """Medians of mu0 and of tau0 (GPa), in four digits."""
    mu0, tau0 = (float(f"{np.median(each):.4g}") for each in (found.fits[0].mu0, found.fits[0].tau0))
    return mu0, tau0


# ---- Friction tests --------------------------------------------------------------------------------------------------

TEST_COLUMNS = ("load", "force", "coefficient", "uncertainty", "pair", "run", "slid", "wait")
"""Names of columns; load and force need a unit, uncertainty may be in percent."""

LONGEST_TABLE = 10_000_000  # largest number of bytes of a table of tests
_TITLE = re.compile(r"\s*([^()]*?)\s*(?:\(\s*([^()]*?)\s*\))?\s*")
_SLID = {"": True, "1": True, "yes": True, "true": True, "0": False, "no": False, "false": False}


def friction_tests(path: str | Path, bodies: Mapping[str, Any]) -> tuple[FrictionTest, ...]:
    """The tests of a table with the columns load and force or coefficient, and others of `TEST_COLUMNS`.

    Its pair names one of the bodies, results or balls. A `ValueError` says which line is not what its columns say.
    """
    try:
        text = content(Path(path), LONGEST_TABLE).decode("utf-8-sig")
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
        if not match or name not in TEST_COLUMNS or name in found:
            raise ValueError(
                f"has the column {shortened(printable(cell))}, and may have each of {', '.join(TEST_COLUMNS)}"
            )
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
