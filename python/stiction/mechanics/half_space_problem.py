"""A pair of bodies as an elastic half-space: what is asked of it, checked, and what comes out at one load."""

from __future__ import annotations

import copyreg
import math
import sys
import weakref
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiction._core as _core
from stiction._caching import cached_property
from stiction._checks import Floats, float_array, read_only
from stiction.mechanics.model import THICKNESS
from stiction.mechanics.patches import PatchSums, patch_sums, slopes
from stiction.surfaces.profile import Profile, combine_missing
from stiction.surfaces.surface import Surface

MOST_KEPT = 2**20
"""Points of a grid whose kernels are kept when nobody uses them: 35 MB; a quarter of a free load takes to make them."""

SMALL = 0.01  # tilt of a linear answer: what it moves an edge over what the load moves the points
PRECISE = 1e-7  # tolerance of linear answers
UNBOUND = 1e9  # bound of linear answers to a mean pressure of 1, which coarse grids have means of
LONGEST_CELL = 1e6  # ratio of the sides of a grid's cell, above which heights on it are no surface


_shared: weakref.WeakValueDictionary[tuple[Any, ...], _core.HalfSpaceGrids] = weakref.WeakValueDictionary()
_keys: weakref.WeakKeyDictionary[_core.HalfSpaceGrids, tuple[Any, ...]] = weakref.WeakKeyDictionary()
_last: deque[_core.HalfSpaceGrids] = deque(maxlen=1)
_even: weakref.WeakKeyDictionary[_core.HalfSpaceGrids, Floats] = weakref.WeakKeyDictionary()


def grids_of(
    shape: tuple[int, ...], spacing: tuple[float, ...], effective_modulus: float, *, periodic: bool
) -> _core.HalfSpaceGrids:
    """The grids of a problem, the same ones as long as anyone holds them: they have the kernels."""
    key = shape, spacing, effective_modulus, periodic
    grids = _shared.get(key)
    if grids is None:
        grids = _core.HalfSpaceGrids(shape, spacing, effective_modulus=effective_modulus, periodic=periodic)
        _shared[key], _keys[grids] = grids, key
    if math.prod(shape) <= MOST_KEPT:
        _last.append(grids)
    return grids


def _grids_from(
    shape: tuple[int, ...], spacing: tuple[float, ...], effective_modulus: float, periodic: bool
) -> _core.HalfSpaceGrids:
    return grids_of(shape, spacing, effective_modulus, periodic=periodic)


# Copies, and curves that come back from another process, compute the kernels again where none has them.
copyreg.pickle(_core.HalfSpaceGrids, lambda grids: (_grids_from, _keys[grids]))


def threads() -> int:
    """Threads that share the transforms of one solution, as `scipy.fft.set_workers` says if anybody has called it."""
    fft = sys.modules.get("scipy.fft")
    return 1 if fft is None else int(fft.get_workers())


@dataclass(frozen=True, eq=False)
class Problem:
    """Heights of two bodies and their gap (µm, its least is 0) with what their contact depends on, in core units."""

    upper: Floats
    lower: Floats
    gap: Floats
    spacing: tuple[float, ...]
    compliance_share: float
    grids: _core.HalfSpaceGrids
    hardness: float | None
    work_of_adhesion: float = 0.0
    adhesion_range: float = 0.0
    missing: NDArray[np.bool_] | None = None  # where one body was not measured, and nothing touches
    tilt: Floats | float = 0.0  # slopes along y and x, or x, by which the upper body is turned about its middle
    turns: bool = False  # whether it turns until the resultant is in the middle

    @property
    def periodic(self) -> bool:
        """Whether the bodies go on beyond the edges."""
        return self.grids.periodic

    @cached_property
    def cell(self) -> float:
        """µm², of a grid point."""
        return float(np.prod(self.spacing)) * (THICKNESS if len(self.spacing) == 1 else 1.0)

    @cached_property
    def area(self) -> float:
        """µm², nominal: of points that were measured in both."""
        return self.cell * (self.gap.size - (0 if self.missing is None else int(self.missing.sum())))

    @property
    def has_approach(self) -> bool:
        """Whether far points stay: not on a free half-plane."""
        return self.periodic or len(self.spacing) == 2

    @property
    def measured(self) -> Floats:
        """1 where both bodies were measured, else 0."""
        return np.ones_like(self.gap) if self.missing is None else np.where(self.missing, 0.0, 1.0)

    @cached_property
    def even(self) -> Floats:
        """Displacement under an even pressure of 1 GPa on what was measured, µm; 0 of whole periodic bodies."""
        if self.missing is not None:
            return np.asarray(self.grids.displacement(self.measured, threads=threads()))
        if (known := _even.get(self.grids)) is None:
            known = _even[self.grids] = read_only(self.grids.displacement(self.measured, threads=threads()))
        return known

    @cached_property
    def slope(self) -> list[Floats]:
        """Slopes of the deformed interface along y and x, or x, at every point."""
        share = self.compliance_share
        interface = (1 - share) * self.lower + share * self.upper
        return [along.ravel() for along in slopes(interface, self.spacing, periodic=self.periodic)]


@dataclass(frozen=True, eq=False)
class Pressed:
    """The contact at a load (mN): of its points pressure (GPa), share of their cells in contact, and patch."""

    problem: Problem
    load: float
    points: NDArray[np.int64]
    values: Floats
    share: Floats
    patch: NDArray[np.int32]
    approach: float
    error: float
    iterations: int
    attraction: Floats | float = 0.0

    @property
    def adhering(self) -> float:
        """mN, of the attraction."""
        return float(np.sum(self.attraction)) * self.problem.cell

    @property
    def closure(self) -> float:
        """Mean gap that was lost since first touch, µm."""
        even, cell = self.problem.even, self.problem.cell
        moved = float(self.values @ even.ravel()[self.points]) - float(np.sum(self.attraction * even))
        return self.approach - moved * cell / self.problem.area

    def on_grid(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values at the points, 0 elsewhere."""
        grid = np.zeros(self.problem.gap.size, values.dtype)
        grid[self.points] = values
        return grid.reshape(self.problem.gap.shape)

    def sums(self, directions: Floats) -> PatchSums:
        """Sums over each patch, for directions as (m, 2) horizontal unit vectors."""
        problem = self.problem
        slope = [along[self.points] for along in problem.slope]
        return patch_sums(self.values * problem.cell, self.share * problem.cell, slope, self.patch, directions)

    def row(self) -> dict[str, Any]:
        """What the solution says without friction."""
        capped = self.values == self.problem.hardness
        return {
            "load": self.load,
            "contact_load": self.load + self.adhering,
            "approach": self.approach if self.problem.has_approach else np.nan,
            "closure": self.closure,
            "error": self.error,
            "iterations": self.iterations,
            "contact_count": int(self.patch.max()),
            "load_share_at_hardness": float(self.values[capped].sum() / self.values.sum()),
            "area_share_at_hardness": float(capped.mean()),
        }

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """Points whose pressure is below the hardness."""
        return self.values < (np.inf if self.problem.hardness is None else self.problem.hardness)

    @cached_property
    def stiffness(self) -> float:
        """dF/dδ, mN/µm, of the points as they are; infinite at full periodic contact, NaN without an approach."""
        return self._stiffness_of(self.free)

    @cached_property
    def unloading_stiffness(self) -> float:
        """As `stiffness`, of all points: those that have yielded unload elastically."""
        return self.stiffness if self.free.all() else self._stiffness_of(np.ones_like(self.free))

    @cached_property
    def closure_stiffness(self) -> float:
        """dp/dc, GPa/µm, of the nominal pressure over the closure, of points as they are; infinite at full contact."""
        problem = self.problem
        if not self.free.any():
            return np.nan
        if problem.periodic and problem.missing is None:
            return self.stiffness / problem.area
        pressure, approach = self._answer
        lost = approach * problem.area / problem.cell - float((pressure * problem.even).sum())
        return 1 / lost if lost > 0 else np.inf

    @cached_property
    def _answer(self) -> tuple[Floats, float]:
        return self._answer_of(self.free)

    def _answer_of(self, free: NDArray[np.bool_]) -> tuple[Floats, float]:
        """Pressures (GPa) of sum 1 on free points under which these move alike, and by how much (µm)."""
        if not self.problem.turns:
            return self.problem.grids.linear_response(self.on_grid(free), threads=threads())
        return Answer.of(self.problem, self.on_grid(free)).to_load()

    def _stiffness_of(self, free: NDArray[np.bool_]) -> float:
        problem = self.problem
        if not (problem.has_approach and free.any()):
            return np.nan
        compliance = (self._answer if free is self.free else self._answer_of(free))[1]
        return problem.cell / compliance if compliance > 0 else np.inf


HIGHEST_GAP = 1e6  # largest gap over the length of the bodies; a half-space takes slopes far below 1


def problem_of(
    upper: Profile | Surface, lower: Profile | Surface, effective_modulus: float, *, periodic: bool,
    compliance_share: float, hardness: float | None,
) -> Problem:  # fmt: skip
    """Problem of two bodies on one grid; the rest is checked."""
    if upper.heights.shape != lower.heights.shape:
        raise ValueError(
            f"upper and lower must have equal shapes, got {upper.heights.shape!r} and {lower.heights.shape!r}"
        )
    spacing = upper.spacings
    cell = float(np.prod(spacing))
    if not (np.finfo(np.float64).tiny <= cell < np.inf and max(spacing) <= LONGEST_CELL * min(spacing)):
        raise ValueError(
            f"spacing must give cells of {np.finfo(np.float64).tiny:.0e} µm² or more whose sides differ by a factor of "
            f"at most {LONGEST_CELL:g}, got {upper.spacing!r} µm"
        )
    gap, missing = upper.heights - lower.heights, combine_missing(upper, lower)
    gap -= gap.min() if missing is None else gap[~missing].min()
    if not gap.max() <= HIGHEST_GAP * max(spacing) * max(gap.shape):
        raise ValueError(
            f"upper and lower must have a gap of at most {HIGHEST_GAP:g} times their length, got {gap.max():.3g} µm"
        )
    grids = grids_of(gap.shape, spacing, effective_modulus, periodic=periodic)
    return Problem(upper.heights, lower.heights, gap, spacing, compliance_share, grids, hardness, missing=missing)


Asked = Literal["loads", "approaches"]


def steps_of(problem: Problem, loads: ArrayLike | None, approaches: ArrayLike | None) -> tuple[Asked, Floats]:
    """What is asked for and its values, which the problem has an answer to."""
    name: Asked = "loads" if approaches is None else "approaches"
    asked = loads if approaches is None else approaches
    if asked is None or (loads is not None and approaches is not None):
        raise ValueError("half_space takes loads or approaches, one of them")
    steps = float_array(name, asked, ndim=1)
    if problem.work_of_adhesion > 0:
        if name == "approaches":
            raise ValueError("approaches are for bodies without adhesion; give loads")
        if not (steps.size > 0 and len(set(np.sign(np.diff(steps)))) <= 1 and np.diff(steps).all()):
            raise ValueError(f"loads must be strictly increasing or strictly decreasing, got {loads!r}")
    elif not (steps.size > 0 and (steps > 0).all() and (np.diff(steps) > 0).all()):
        unit = "mN" if name == "loads" else "µm"
        raise ValueError(f"{name} must be above 0 {unit} and strictly increasing, got {asked!r}")
    gap, hardness = problem.gap, problem.hardness
    if name == "loads":
        most = np.inf if hardness is None else hardness * problem.area
        if not steps.max() < most:
            raise ValueError(f"loads must be below hardness times area, {most:g} mN, got {loads!r}")
        return name, steps
    if hardness is not None:
        raise ValueError(f"approaches are for bodies without hardness; give loads, got hardness={hardness!r}")
    if not problem.has_approach:
        raise ValueError("approaches: a free half-plane has none; give loads, or boundary='periodic'")
    if problem.periodic and not steps[-1] < gap.mean():
        raise ValueError(f"approaches must be below {gap.mean():g} µm, where all points touch, got {approaches!r}")
    return name, steps


def arms_of(problem: Problem) -> list[Floats]:
    """Distance of each point from the middle of what was measured along y and x, or x, µm, to be broadcast."""
    arms = []
    for axis, (count, spacing) in enumerate(zip(problem.gap.shape, problem.spacing, strict=True)):
        others = tuple(each for each in range(problem.gap.ndim) if each != axis)
        weights, places = problem.measured.sum(axis=others), spacing * np.arange(count)
        shape = [count if each == axis else 1 for each in range(problem.gap.ndim)]
        arms.append((places - np.average(places, weights=weights)).reshape(shape))
    return arms


@dataclass(frozen=True, eq=False)
class Answer:
    """What points under pressure answer, as they are, to a mean load of 1 GPa and to slopes of the upper body."""

    pressure: Floats  # GPa, under the load
    approach: float  # µm
    moments: Floats  # (n,), GPa µm, under the load
    turned: list[Floats]  # GPa, of each slope of 1 under no load
    turning: Floats  # (n, n), their moments, by slope and axis: negative definite but for single points

    @classmethod
    def of(cls, problem: Problem, free: NDArray[np.bool_]) -> Answer:
        """That of free points, as a mask."""
        bound = np.where(free, UNBOUND, 0.0)
        arms = arms_of(problem)

        def solved(gap: Floats) -> tuple[Floats, float]:
            solver = _core.HalfSpaceSolver(gap, problem.grids, bound=bound, tolerance=PRECISE, threads=threads())
            found = solver.at(1.0, threads=threads())
            return found.pressure.reshape(gap.shape), found.approach

        level, approach = solved(np.zeros_like(problem.gap))
        moments = moments_of(level, arms)
        moved = float(np.abs(problem.grids.displacement(level, threads=threads())[free]).mean())
        turned = []
        for arm in arms:
            small = SMALL * moved / float(np.abs(arm).max())
            turned.append((solved(small * np.broadcast_to(arm, problem.gap.shape).copy())[0] - level) / small)
        turning = np.array([moments_of(each, arms) for each in turned])
        return cls(level, approach, moments, turned, (turning + turning.T) / 2)

    def to_load(self) -> tuple[Floats, float]:
        """Pressures of sum 1 and approach of a load that stays in the middle."""
        slopes = -np.linalg.lstsq(self.turning, self.moments, rcond=None)[0]
        pressure = self.pressure + sum(slope * each for slope, each in zip(slopes, self.turned, strict=True))
        return pressure / pressure.size, (self.approach + float(slopes @ self.moments)) / pressure.size


def moments_of(pressure: Floats, arms: list[Floats]) -> Floats:
    """Mean moments about the middle, GPa µm."""
    return np.array([float((pressure * arm).mean()) for arm in arms])


class Solver:
    """Contacts of a problem at loads (mN) or approaches (µm) up to the most; missing points are too deep to touch."""

    def __init__(
        self, problem: Problem, name: Asked, most: float, *, tolerance: float,
        report: Callable[[int, float], object] | None,
    ) -> None:  # fmt: skip
        self.problem, self.name, self.tolerance, self.report = problem, name, tolerance, report
        bound = np.array([np.inf if problem.hardness is None else problem.hardness])
        gap, self.scale = problem.gap, 1.0
        if (missing := problem.missing) is not None:
            # So deep that they are never reached, and a tolerance in proportion, as it is of the deviation of the gap.
            there = gap[~missing]
            moved = np.ptp(problem.grids.displacement(np.where(missing, 0.0, most / problem.area)))
            gap = np.where(missing, 2 * there.max() + 4 * (moved if name == "loads" else most), gap)
            self.scale = float(gap.std() / there.std()) if np.ptp(there) > 0 else 1.0
        self._core = _core.HalfSpaceSolver(
            gap, problem.grids, bound=bound, tolerance=tolerance / self.scale, threads=threads()
        )

    def at(self, step: float, near: Floats | None) -> _core.HalfSpaceSolution:
        """The contact at a load or approach; a `RuntimeError` if it does not reach the tolerance."""
        problem, loads = self.problem, self.name == "loads"
        value = step / (problem.cell * problem.gap.size) if loads else step
        solve = self._core.at if loads else self._core.at_approach
        solution = solve(value, near=near, threads=threads(), progress=self.report)
        if problem.missing is not None and solution.pressure.reshape(problem.gap.shape)[problem.missing].any():
            raise RuntimeError(f"no solution at {step:g}: missing points would touch")
        if not solution.error * self.scale <= self.tolerance:
            raise RuntimeError(
                f"no solution at {step:g} {'mN' if loads else 'µm'}: "
                f"error {solution.error * self.scale:.2g} after "
                f"{solution.iterations} iterations, above the tolerance {self.tolerance:g}"
            )
        return solution


@dataclass(frozen=True, eq=False)
class State:
    """A contact in equilibrium with its attraction; means over the grid in GPa, and `HalfSpaceSolution`'s words."""

    pressure: Floats
    attraction: Floats
    contact: float
    load: float
    approach: float = np.nan
    error: float = np.nan
    iterations: int = 0

    @property
    def held(self) -> float:
        """Mean attraction, GPa."""
        return self.contact - self.load


def pressed_of(
    problem: Problem, solution: _core.HalfSpaceSolution | State, load: float | None,
    attraction: Floats | float = 0.0, *, scale: float = 1.0,
) -> Pressed:  # fmt: skip
    """What a solution is at a load (mN), or at that of its pressure."""
    hardness = np.inf if problem.hardness is None else problem.hardness
    pressure = solution.pressure.reshape(problem.gap.shape)
    found: Any = _core.patches_of(pressure, periodic=problem.periodic, hardness=hardness)
    points, values, share, patch = map(read_only, found)
    load = float(values.sum()) * problem.cell if load is None else load
    known = solution.approach, solution.error * scale, solution.iterations
    return Pressed(problem, load, points, values, share, patch, *known, attraction)
