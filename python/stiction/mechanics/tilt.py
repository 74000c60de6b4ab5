"""Balanced bodies: the upper one turns until the resultant of the pressures is above the middle.

The pressure is the least energy of its load; the slopes of the turn are multipliers of its moments, so these fall as
slopes rise (a concave problem of two unknowns), and a Newton step from what the points under pressure answer leads
there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats
from stiction.mechanics.half_space_problem import Pressed, Problem, Solver, pressed_of, threads

BALANCED = 1e-4  # distance of the resultant from the middle over the length, along each axis
MOST = 60  # solutions for one load
FURTHEST = 0.5  # most that a step moves an edge, in deviations of the gap
SMALL = 0.01  # tilt of a linear answer: what it moves an edge over what the load moves the points
PRECISE = 1e-7  # tolerance of linear answers
STIFFEST = 1e-6  # least answer of a moment, in loads times length² over the deviation of the gap
UNBOUND = 1e9  # bound of linear answers to a mean pressure of 1, which coarse grids have means of


def arms_of(problem: Problem) -> list[Floats]:
    """Distance of each point from the middle of what was measured along y and x, or x, µm, to be broadcast."""
    arms = []
    for axis, (count, spacing) in enumerate(zip(problem.gap.shape, problem.spacing, strict=True)):
        others = tuple(each for each in range(problem.gap.ndim) if each != axis)
        weights, places = problem.measured.sum(axis=others), spacing * np.arange(count)
        shape = [count if each == axis else 1 for each in range(problem.gap.ndim)]
        arms.append((places - np.average(places, weights=weights)).reshape(shape))
    return arms


def tilted(problem: Problem, slopes: Floats) -> Problem:
    """The upper body turned about its middle by slopes along y and x, or x."""
    plane = sum(slope * arm for slope, arm in zip(slopes, arms_of(problem), strict=True))
    return replace(problem, upper=problem.upper + plane, gap=problem.gap + plane, tilt=problem.tilt + slopes)


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


def balanced(
    problem: Problem, loads: Floats, *, tolerance: float, progress: Callable[[int, int, float], object] | None
) -> list[Pressed]:
    """The contact at each load (mN), its resultant in the middle; each begins from the tilt before."""
    contacts: list[Pressed] = []
    report = None if progress is None else lambda iteration, error: progress(len(contacts), iteration, error)
    arms, shape = arms_of(problem), problem.gap.shape
    lengths = np.array(shape) * np.array(problem.spacing)
    height = float(problem.gap[problem.measured > 0].std()) or 1.0

    def at(turned: Problem, load: float, near: Floats | None) -> tuple[Pressed, Floats]:
        solver = Solver(turned, "loads", load, tolerance=tolerance, report=report)
        solution = solver.at(load, near)
        pressed = pressed_of(turned, solution, load, scale=solver.scale)
        return pressed, moments_of(solution.pressure.reshape(shape), arms)

    near = None
    for load in loads.tolist():
        mean = load / (problem.cell * problem.gap.size)
        pressed, moments = at(problem, load, near)
        tried = 0
        while float(np.abs(moments / (mean * lengths)).max()) > BALANCED:
            near = pressed.on_grid(pressed.values).ravel()
            turning = Answer.of(problem, pressed.on_grid(pressed.free)).turning
            step = np.linalg.solve(np.diag(STIFFEST * mean * lengths**2 / height) - turning, moments)
            step *= min(1.0, FURTHEST * height / float(np.abs(step * lengths / 2).max()))
            # The energy is concave over slopes: beyond its crest along the step the moments change sides.
            while tried < MOST:
                tried += 1
                found = at(tilted(pressed.problem, np.asarray(step, np.float64)), load, near)
                if float(found[1] @ step) >= -FURTHEST * float(moments @ step):
                    break
                step = step / 2
            else:
                raise RuntimeError(f"no solution at {load:g} mN: no tilt is found at which the bodies are balanced")
            pressed, moments = found
        problem, near = pressed.problem, pressed.on_grid(pressed.values).ravel()
        contacts.append(pressed)
    return contacts
