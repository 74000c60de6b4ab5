"""Balanced bodies: the upper one turns until the resultant of the pressures is above the middle.

The pressure is the least energy of its load; the slopes of the turn are multipliers of its moments, so these fall as
slopes rise (a concave problem of two unknowns), and a Newton step from what the points under pressure answer leads
there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stiction._checks import Floats
from stiction.mechanics.half_space_problem import Answer, Pressed, Problem, Solver, arms_of, moments_of, pressed_of

BALANCED = 1e-4  # distance of the resultant from the middle over the length, along each axis
MOST = 60  # solutions for one load
FURTHEST = 0.5  # most that a step moves an edge, in deviations of the gap
STIFFEST = 1e-6  # least answer of a moment, in loads times length² over the deviation of the gap


def tilted(problem: Problem, slopes: Floats) -> Problem:
    """The upper body turned about its middle by slopes along y and x, or x."""
    plane = sum(slope * arm for slope, arm in zip(slopes, arms_of(problem), strict=True))
    return replace(problem, upper=problem.upper + plane, gap=problem.gap + plane, tilt=problem.tilt + slopes)


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
