"""mu0 and tau0 from friction that was measured on surfaces that were scanned.

A test gives a coefficient y at a load. The surfaces give, at that load, the sums of which both forces are made, so that
y (F_N0 + mu0 F_Nm + tau0 F_Na) = F_T0 + mu0 F_Tm + tau0 F_Ta: a straight line in (mu0, tau0). Where contacts rub on
gentle slopes it is y = mu0 + tau0 A/F, and both are told apart only as far as A/F varies among the tests.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from stiction._checks import Floats, choice, number
from stiction._files import NotReadableError, content, reason
from stiction._text import named, printable
from stiction._units import in_core_units, shortened
from stiction.mechanics.model import Sliding
from stiction.studies.interfaces import (
    EXCLUDED,
    HARDNESS,
    RULES,
    UNLIKELY,
    Ball,
    Fit,
    FrictionTest,
    Interface,
    _friction_of,
    _rules_of,
)
from stiction.studies.known import sobol

if TYPE_CHECKING:
    pass

LEAST_VARIATION = 0.1  # standard deviation over mean of A/F among tests below which mu0 and tau0 are not told apart
NUISANCES = 128  # points of a Sobol sequence over gain of the force cell, areas of the surfaces, and hardness
STRENGTHS, COEFFICIENTS = 161, 97  # points of the grids of tau0, and of mu0 at each of these
DRAWS = 4000  # pairs of mu0 and tau0 that stand for their joint distribution
TAIL = 1e-7  # density over its maximum, below which the grid of tau0 ends
WIDE = 8.0  # half-width of the grid of mu0, standard deviations
LEAST_TESTS = 3  # tests that slid from whose scatter errors are found


FREEDOM = 4.0  # degrees of freedom of Student's t for tests among which there may be outliers


_CENTRED = np.linspace(0.0, 1.0, COEFFICIENTS)  # where points of mu0 stand between the ends of their grid


def calibrate(
    tests: Sequence[FrictionTest],
    *,
    common: float = 0.02,
    sliding: Sliding | Literal["both"] = "both",
    mu0: float | None = None,
    tau0: float | str | None = None,
    outliers: bool = False,
) -> Interface:
    """The strength of an interface, mu0 and tau0 jointly, from friction tests on surfaces that were scanned.

    Parameters
    ----------
    tests : sequence of FrictionTest
    common : float
        Relative standard uncertainty that all tests share: of the force cell, of the load.
    sliding : {"both", "all", "opposing"}
        By which rule; of both, "all" is used unless the tests exclude it and not the other one.
    mu0, tau0 : float, tau0 in GPa or as text
        Where one of them is known.
    outliers : bool
        Whether there may be outliers among the tests: errors by Student's t in place of the normal distribution.

    Returns
    -------
    Interface

    Raises
    ------
    ValueError
        If there are no tests that slid, or an argument is outside its range.

    Notes
    -----
    Given gain, areas and hardness the data are linear in mu0 and tau0. The density is computed on a grid of tau0, and
    at each of its points of mu0, which is exact however alike the tests are; both are at least 0, and all values of
    mu0 and of tau0 A/F are as likely beforehand. Gain and areas have normal distributions of their own, over which
    the densities are summed. Where residuals are larger than the errors allow, the errors are taken as known up to a
    factor.

    Examples
    --------
    >>> from stiction import Ball, FrictionTest, calibrate
    >>> ball = Ball("5 mm", "3 GPa")
    >>> loads = [5.0, 20.0, 100.0, 500.0, 2000.0]
    >>> tests = [
    ...     FrictionTest(ball, load, coefficient=0.15 + 0.012 * ball.area_per_load(load), uncertainty=0.01)
    ...     for load in loads
    ... ]
    >>> interface = calibrate(tests)
    >>> interface.separated, round(interface.tau0[0], 3)
    (True, 0.012)
    """
    choice("sliding", sliding, Literal["both", "all", "opposing"])
    tests = tuple(tests)
    if not all(isinstance(test, FrictionTest) for test in tests):
        raise ValueError("tests must be a sequence of FrictionTest")
    if not any(test.slid for test in tests):
        raise ValueError("tests must have one that slid: those that held are lower bounds alone")
    if not 0 <= number("common", common) < 1:
        raise ValueError(f"common must be at least 0 and below 1, got {common!r}")
    held = {test.uncertainty is None for test in tests}
    if len(held) > 1:
        raise ValueError("uncertainty must be given of all tests, or of none")
    if True in held and sum(test.slid for test in tests) < LEAST_TESTS:
        raise ValueError(f"uncertainty is needed of fewer than {LEAST_TESTS} tests: their scatter says too little")
    known = tuple(
        None if value is None else number(name, in_core_units(name, value, "pressure") if name == "tau0" else value)
        for name, value in (("mu0", mu0), ("tau0", tau0))
    )
    if any(value is not None and value < 0 for value in known):
        raise ValueError("mu0 and tau0 must not be negative")
    there = [rule for rule in RULES if all(rule in _rules_of(test.result) for test in tests)]
    if all(isinstance(test.result, Ball) for test in tests) and sliding == "both":
        there = there[:1]  # both rules are one
    rules = there if sliding == "both" else [sliding]
    if not rules or not set(rules) <= set(there):
        raise ValueError(
            f"sliding must be a rule that all results have ({', '.join(there) or 'none'}), got {sliding!r}"
        )
    problems = [_Problem(tests, rule, common, known, outliers=outliers) for rule in rules]
    fits = [problem.fit() for problem in problems]
    if len(fits) == 2 and fits[0].probability < EXCLUDED and fits[1].probability > UNLIKELY:
        fits, problems = fits[::-1], problems[::-1]
    first = problems[0]
    separated = any(value is not None for value in known) or (len(tests) > 2 and first.variation >= LEAST_VARIATION)
    points = [
        (float(ratio), float(test.coefficient or 0.0), float(test.uncertainty or math.nan), test.slid)
        for ratio, test in zip(first.ratio, tests, strict=True)
    ]
    advice = () if separated else first.advice()
    about = {"kind": "measured"} | ({HARDNESS: first.shared} if first.shared else {})
    return Interface(tuple(fits), first.pivot, first.variation, separated, advice, tuple(points), about)


class _Problem:
    """Equations rub mu0 + stick tau0 = right of all tests, (nuisances, tests) each, and their errors."""

    def __init__(
        self, tests: Sequence[FrictionTest], sliding: Sliding, common: float, known: Any, *, outliers: bool
    ) -> None:
        from scipy.special import ndtri

        self.sliding, self.known, self.outliers = sliding, known, outliers
        friction = [_friction_of(test, sliding) for test in tests]
        bodies = list({id(test.result): None for test in tests})
        places = np.array([bodies.index(id(test.result)) for test in tests])
        scatter = np.zeros(len(bodies))
        for place, found in zip(places, friction, strict=True):
            scatter[place] = max(scatter[place], found.scatter)
        yields = [found.yields for found in friction if found.yields is not None]
        keys = list(dict.fromkeys(each.key(name) for each in yields for name in each.known))
        points = sobol(1 + len(bodies) + len(keys), NUISANCES).copy()
        points[0] = 0.5  # the middle, by which fits are judged
        scores, columns = ndtri(points), dict(zip(keys, points.T[1 + len(bodies) :], strict=True))
        gain = np.exp(common * scores[:, :1])
        area = np.exp(scatter[places] * scores[:, 1:][:, places])
        areas = (1.0 if each.yields is None else each.yields.area(columns) for each in friction)
        area = area * np.stack([np.broadcast_to(each, NUISANCES) for each in areas], axis=1)
        measured = np.array([float(test.coefficient or 0.0) for test in tests]) / gain

        def of_all(name: str) -> Floats:
            return np.array([getattr(found, name) for found in friction])

        ones = {each.hardness for each in friction}
        self.hardness = np.full(NUISANCES, friction[0].hardness if len(ones) == 1 else math.nan)
        # What knows the hardness, where all tests are of bodies of one that is not known exactly.
        ranges = {each.yields and "hardness" in each.yields.known and each.yields.key("hardness") for each in friction}
        shared = friction[0].yields if len(ranges) == 1 and all(ranges) else None
        self.shared = "" if shared is None else shared.known["hardness"].text
        if shared is not None:
            self.hardness = shared.known["hardness"].quantile(columns[shared.key("hardness")])
        self.has_errors = tests[0].uncertainty is not None
        self.error = np.array([test.uncertainty if self.has_errors else 1.0 for test in tests], float)
        if not self.has_errors:  # all of one relative error
            self.error = np.maximum(measured[0], 1e-6 * measured[0].max())
        self.rub = of_all("rub") - measured * of_all("rub_normal")
        self.stick = (of_all("stick") - measured * of_all("stick_normal")) * area
        self.right = measured - of_all("elastic")
        self.slid = np.array([test.slid for test in tests])
        self.load = np.array([float(test.load) for test in tests])
        self.ratio = of_all("stick") / of_all("rub") * area[0]  # A/F, 1/GPa
        self._take_offsets_off([test.run for test in tests])

    def _take_offsets_off(self, runs: list[Any]) -> None:
        """Make the errors of equations independent, where tests of one run share an offset of unknown size."""
        names = [run for run in dict.fromkeys(runs) if run is not None and runs.count(run) > 1]
        if len(names) < 2:
            return
        member = np.array([[run == name for run in runs] for name in names], float)
        counts = member.sum(axis=1)
        residual = self._residual_of_best()
        means = member @ residual / counts
        within = float(
            ((residual - means @ member) ** 2 * member.any(axis=0)).sum() / max(1, counts.sum() - len(names))
        )
        between = max(0.0, float(means.var(ddof=1)) - within * float((1 / counts).mean()))
        part = 1 - np.sqrt(within / (within + counts * between)) if within > 0 else np.ones(len(names))
        take = np.eye(len(runs)) - (member.T * (part / counts)) @ member

        def apart(values: Floats) -> Floats:
            return np.asarray((values / self.error) @ take.T * self.error)

        self.rub, self.stick, self.right = apart(self.rub), apart(self.stick), apart(self.right)

    @cached_property
    def _weight(self) -> Floats:
        return np.where(self.slid, 1.0 / self.error**2, 0.0)

    @property
    def pivot(self) -> float:
        """A/F of the tests, 1/GPa, each with its weight."""
        return float(np.average(self.ratio, weights=self._weight))

    @property
    def variation(self) -> float:
        """Standard deviation over mean of A/F."""
        return float(np.sqrt(np.average((self.ratio - self.pivot) ** 2, weights=self._weight)) / self.pivot)

    def _best(self) -> tuple[float, float]:
        """The most likely mu0 and tau0, at least 0, without outliers, at the middle of gain and areas."""
        from scipy.optimize import lsq_linear

        weight = np.sqrt(self._weight)
        columns = np.stack([self.rub[0], self.stick[0]], axis=1)
        free = [value is None for value in self.known]
        values = np.array([0.0 if value is None else value for value in self.known])
        if any(free):
            right = self.right[0] - columns @ values
            scale = np.abs(columns[:, free]).max(axis=0)
            values[free] = (
                lsq_linear(columns[:, free] / scale * weight[:, None], right * weight, (0.0, np.inf)).x / scale
            )
        return float(values[0]), float(values[1])

    def _residual_of_best(self) -> Floats:
        mu0, tau0 = self._best()
        return np.asarray((self.right[0] - self.rub[0] * mu0 - self.stick[0] * tau0) / self.error)

    def fit(self) -> Fit:
        """The joint distribution of mu0 and tau0, and how well the tests fit."""
        from scipy.stats import chi2, linregress

        residual = self._residual_of_best()[self.slid]
        chi_squared = float((residual**2).sum())
        slid = int(self.slid.sum())
        # Where A/F is the same in all tests, one combination is what was fitted.
        fitted = min(sum(value is None for value in self.known), 1 if self.variation < LEAST_VARIATION else 2)
        freedom = max(0, slid - fitted)
        probability = float(chi2.sf(chi_squared, freedom)) if self.has_errors and freedom else math.nan
        is_scaled = freedom > 0 and (not self.has_errors or (probability < UNLIKELY and not self.outliers))
        scale = math.sqrt(chi_squared / freedom) if is_scaled else 1.0
        loads = np.log(self.load[self.slid])
        trend = float(linregress(loads, residual).pvalue) if residual.size > 2 and np.ptp(loads) > 0 else math.nan
        mu0, tau0, hardness = self._drawn(scale, freedom if is_scaled else None)
        scale = scale if self.has_errors else 1.0
        return Fit(self.sliding, chi_squared, freedom, probability, scale, trend, mu0, tau0, hardness)

    # ---- Density ----------------------------------------------------------------------------------------------------

    @cached_property
    def _rows(self) -> Floats:
        """(nuisances, at most 3, 3) rows of rub, stick and right side over errors, of tests that slid."""
        columns = (self.rub, self.stick, self.right)
        rows = np.stack([np.broadcast_to(each, self.right.shape) / self.error for each in columns], axis=-1)
        rows = rows[:, self.slid]
        return rows if self.outliers else np.asarray(np.linalg.qr(rows, mode="r"))

    def _log_density(self, mu0: Floats, tau0: Floats, nuisance: int, scale: float, freedom: int | None) -> Floats:
        """Logarithm of the density (...) of the data; with a freedom, of errors that are known up to a factor."""
        from scipy.special import log_ndtr

        slid = self._rows[nuisance] @ np.array([[-1.0, 0, 0], [0, -1, 0], [0, 0, 1]])
        squares = [(row[2] + row[0] * mu0 + row[1] * tau0) ** 2 for row in slid]
        if self.outliers:
            found = sum(-0.5 * (FREEDOM + 1) * np.log1p(each / (scale**2 * FREEDOM)) for each in squares)
        elif freedom is None:
            found = -0.5 * sum(squares)
        else:
            found = -0.5 * np.count_nonzero(self.slid) * np.log(sum(squares) + 1e-300)
        for test in np.flatnonzero(~self.slid):
            predicted = self.rub[nuisance, test] * mu0 + self.stick[nuisance, test] * tau0
            found = found + log_ndtr((predicted - self.right[nuisance, test]) / (scale * self.error[test]))
        return np.asarray(found)

    def _coefficients(self, tau0: Floats, nuisance: int, scale: float) -> Floats:
        """(tau0, COEFFICIENTS) grid of mu0: around the best one at each tau0, at least 0."""
        if self.known[0] is not None:
            return np.full((tau0.size, 1), self.known[0])
        weight = self._weight
        curvature = float((weight * self.rub[nuisance] ** 2).sum())
        right = self.right[nuisance] - self.stick[nuisance] * tau0[:, np.newaxis]
        best = (weight * self.rub[nuisance] * right).sum(axis=-1) / curvature
        half = WIDE * max(scale, 1.0) / math.sqrt(curvature)
        # Errors that are found from few tests have long tails.
        half *= (
            1.0 + 12.0 / max(1, int(self.slid.sum()) - 1) if not self.has_errors or scale > 1 or self.outliers else 1
        )
        if not self.slid.all():
            half *= 2.0
        low = np.maximum(best - half, 0.0)
        high = np.maximum(best + half, low + half)
        return np.asarray(low[:, np.newaxis] + (high - low)[:, np.newaxis] * _CENTRED[np.newaxis])

    def _on_grid(self, tau0: Floats, nuisance: int, scale: float, freedom: int | None) -> tuple[Floats, Floats]:
        """Grid of mu0 and logarithm of the probability of each of its cells, (tau0, mu0) each."""
        mu0 = self._coefficients(tau0, nuisance, scale)
        density = self._log_density(mu0, np.broadcast_to(tau0[:, np.newaxis], mu0.shape), nuisance, scale, freedom)
        if mu0.shape[1] > 1:
            density = density + np.log(np.gradient(mu0, axis=1))
        return mu0, density

    def _strengths(self, scale: float, freedom: int | None) -> Floats:
        """Grid of tau0 (GPa) that closes in on where the density is."""
        if self.known[1] is not None:
            return np.array([self.known[1]])
        top = float(np.max(np.abs(self.right[0]) + 20 * self.error * scale) / np.min(np.abs(self.stick[0])))
        low, high = 0.0, 2.0 * top
        for _ in range(6):
            grid = np.linspace(low, high, STRENGTHS)
            density = self._on_grid(grid, 0, scale, freedom)[1]
            marginal = np.logaddexp.reduce(density, axis=1)
            there = np.flatnonzero(marginal > marginal.max() + math.log(TAIL))
            step = grid[1] - grid[0]
            new = max(0.0, grid[there[0]] - step), grid[there[-1]] + step
            if new[1] - new[0] > 0.8 * (high - low):
                break
            low, high = new
        # Room for gains and areas that are not in the middle.
        spare = 0.15 * (high - low) + 0.1 * high
        return np.linspace(max(0.0, low - spare), high + spare, STRENGTHS)

    def _drawn(self, scale: float, freedom: int | None) -> tuple[Floats, Floats, Floats]:
        grid = self._strengths(scale, freedom)
        cells = [self._on_grid(grid, nuisance, scale, freedom) for nuisance in range(NUISANCES)]
        top = max(float(density.max()) for _, density in cells)
        # All values of tau0 A/F are as likely beforehand, so that a larger area is no more likely than a smaller one.
        area = np.abs(self.stick).mean(axis=1)
        weights = [np.exp(density - top) * each for (_, density), each in zip(cells, area / area[0], strict=True)]
        total = np.cumsum([float(weight.sum()) for weight in weights])
        random = np.random.default_rng(0)
        # Systematic: each nuisance has its share of the draws, and so have the cells within.
        wanted = (np.arange(DRAWS) + random.random()) / DRAWS * total[-1]
        counts = np.bincount(np.searchsorted(total, wanted), minlength=NUISANCES)
        mu0, tau0, hardness = [], [], []
        step = grid[1] - grid[0] if grid.size > 1 else 0.0
        for nuisance, count in enumerate(counts):
            if not count:
                continue
            values, weight = cells[nuisance][0], np.cumsum(weights[nuisance])
            place = np.searchsorted(weight, (np.arange(count) + random.random()) / count * weight[-1])
            row, column = np.divmod(np.minimum(place, weight.size - 1), values.shape[1])
            strength = np.maximum(grid[row] + step * (random.random(count) - 0.5), 0.0)
            width = np.gradient(values, axis=1)[row, column] if values.shape[1] > 1 else 0.0
            # A move along tau0 within a cell is one along the line on which the tests agree.
            moved = (grid[row] - strength) * self.pivot if self.known[0] is None else 0.0
            mu0.append(np.maximum(values[row, column] + width * (random.random(count) - 0.5) + moved, 0.0))
            tau0.append(strength)
            hardness.append(np.full(count, self.hardness[nuisance]))
        order = random.permutation(DRAWS)
        return tuple(np.concatenate(each)[order] for each in (mu0, tau0, hardness))  # type: ignore[return-value]

    # ---- Advice -----------------------------------------------------------------------------------------------------

    def advice(self) -> tuple[tuple[str, float, float], ...]:
        """What would tell mu0 and tau0 apart, with the standard errors that are expected."""
        mu0, tau0 = self._best()
        predicted = self.rub[0] * mu0 + self.stick[0] * tau0
        relative = float(np.median(self.error / np.maximum(predicted, 1e-12))) if self.has_errors else 0.05
        ratio, count = self.pivot, len(self.error)
        plans = (
            ("a smooth ball below yield, two decades of load", ratio * np.geomspace(0.3, 3, count)),
            ("as many tests on a second finish, elastic, three times as rough", np.full(count, ratio / 3)),
            ("as many tests with the same film on a body twice as hard", np.full(count, ratio / 2)),
        )
        found = []
        for words, more in plans:
            ratios = np.concatenate([np.full(count, ratio), more])
            errors = relative * np.maximum(mu0 + tau0 * ratios, 1e-12)
            matrix = np.stack([1 / errors, ratios / errors], axis=1)
            covariance = np.linalg.inv(matrix.T @ matrix)
            found.append((words, math.sqrt(covariance[0, 0]), math.sqrt(covariance[1, 1])))
        return tuple(found)


# ---- Tables of tests -------------------------------------------------------------------------------------------------

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
    for line, row in rows:
        try:
            if len(row) != len(titles):
                raise ValueError(f"has {len(row)} cells, and the first line {len(titles)}")
            cells = {name: row[place].strip() for name, (place, _) in titles.items()}
            yield _test(cells, {name: unit for name, (_, unit) in titles.items()}, bodies)
        except ValueError as error:
            raise ValueError(f"line {line}: {error}") from None


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
