"""Adhesion of a half-space: an attraction that falls off with the gap, as a traction on the solver that has none.

With σ(g) = w/ρ exp(-g/ρ), press the gap g0 - Kσ, take σ of the gap that comes out, and repeat until both agree.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from operator import attrgetter

import numpy as np

import stiction._core as _core
from stiction._checks import Floats
from stiction.mechanics.half_space_problem import Pressed, Problem, State, pressed_of, threads

DEPTH = 5  # steps before that Anderson's acceleration combines

PLAIN = 2
"""Plain repetitions between two accelerated ones: these alone lead through a jump, and all others end it sooner.

Of 120 random bodies (E* 1 MPa to 200 GPa, w 1 mJ/m² to 1 J/m²) none was left unsolved by 2, and 14 by 0."""

WORSE = 1.5  # growth of the residual over the least since then at which earlier steps are forgotten
MOST = 200  # solutions for one contact; strongly adhering soft bodies have taken 150
MOST_PLAIN = 500  # plain repetitions for one, where accelerated ones lead to complete contact, or nowhere
STALLED = 60  # solutions without a lower residual after which a contact is given up
REGULAR = 1e-10  # added to the normal equations of the acceleration, as a part of their diagonal
LOOSER = 10.0  # residual of the attraction, as a part of the contact load and the attraction, over the tolerance
INNERMOST = 1e-8  # least tolerance of a solution; below it round-off stalls some
FEWEST = 1e-3  # contact load at which a branch begins and ends, over the attraction of bodies that touch at a point
STRIDE = 0.6  # contact load over the one before on a branch
SHORTEST = 0.9  # stride at which a branch that does not converge ends
RISEN = 0.02  # part of the least load by which a branch must have risen again to be known to have passed it
REFINEMENTS = 4  # parabolas through the three lowest loads of a branch, whose least then is known to 1e-4 of itself
SEARCHES = 60  # secants for a load between two contact loads


class Attraction:
    """The attraction of a problem, and contacts in equilibrium with it."""

    def __init__(self, problem: Problem, *, tolerance: float, report: Callable[[int, float], object] | None) -> None:
        self.problem, self.report, self.asked, self.enough = problem, report, tolerance, LOOSER * tolerance
        self.range, self.ended = problem.adhesion_range, ""  # why a branch ended early
        self.most = problem.work_of_adhesion / self.range
        self.bound = np.array([np.inf if problem.hardness is None else problem.hardness])
        # An error of the gap is one of the attraction in proportion to gap over range.
        self.tolerance = max(min(tolerance, LOOSER * tolerance * self.range / float(problem.gap.std() or 1)), INNERMOST)
        self.fewest = FEWEST * float(self.of(problem.gap).mean())

    def of(self, gap: Floats) -> Floats:
        """GPa at gaps (µm); that of contact where bodies overlap."""
        return np.asarray(self.most * np.exp(np.maximum(gap, 0) / -self.range))

    def settled(
        self, near: State | None, *, contact: float | None = None, load: float = 0.0, plain: bool = False
    ) -> State | None:
        """The contact at a mean pressure or an external load, which `plain` repetitions do not leap over; or None."""
        grids, gap = self.problem.grids, self.problem.gap
        attraction = np.zeros_like(gap) if near is None else near.attraction
        pressure = None if near is None else near.pressure
        steps: list[tuple[Floats, Floats]] = []
        recent, best, least = np.inf, 0, np.inf
        for count in range(MOST_PLAIN if plain else MOST):
            mean = max(load + float(attraction.mean()), self.fewest) if contact is None else contact
            if not mean < self.bound[0]:
                return None
            lowered = gap - grids.displacement(attraction, threads=threads())
            solver = _core.HalfSpaceSolver(
                lowered, grids, bound=self.bound, tolerance=self.tolerance, threads=threads()
            )
            solution = solver.at(mean, near=pressure, threads=threads(), progress=self.report)
            pressure = solution.pressure
            if not solution.error <= self.asked:
                return None
            moved = grids.displacement(pressure.reshape(gap.shape), threads=threads())
            change = self.of(lowered + moved - solution.approach) - attraction
            residual = float(np.abs(change).mean()) / (mean + float(attraction.mean()))
            if residual <= self.enough:
                known = solution.approach, solution.error, solution.iterations
                return State(pressure, attraction, mean, mean - float(attraction.mean()), *known)
            if residual < least:
                best, least = count, residual
            elif count - best > STALLED and not plain:
                return None
            if residual > WORSE * recent:
                steps.clear()
                recent = residual
            recent = min(recent, residual)
            steps = [*steps[-DEPTH:], (attraction, change)]
            step = change if plain or count % (PLAIN + 1) < PLAIN else _accelerated(steps)
            attraction = np.clip(attraction + step, 0.0, self.most)
        return None

    def at(self, load: float, near: State | None) -> State:
        """The contact at a mean external load (GPa) on the branch of the one before; the first jump in."""
        if load >= 0:
            found = self.settled(near, load=load)
            if found is None or (found.pressure.all() and (near is None or not near.pressure.all())):
                found = self.settled(near, load=load, plain=True) or found
            if found is not None:
                return found
        start = near or self.settled(None) or self.settled(None, contact=self.fewest)
        if start is None:
            raise RuntimeError("the first touch does not converge")
        states = self.branch(start, STRIDE if start.load > load else 1 / STRIDE, until=load)
        lowest = self.lowest(states)
        before = [one for one in states if one.load < load and one.contact >= lowest.contact] or [lowest]
        after = [one for one in states if one.load >= load and one.contact > before[-1].contact]
        if lowest.load > load or not after:
            raise RuntimeError(f"the bodies come off at {self.force(lowest.load):.4g} mN")
        return self.between(max(before, key=attrgetter("contact")), min(after, key=attrgetter("contact")), load)

    def branch(self, near: State, stride: float, until: float = -np.inf) -> list[State]:
        """States from one on, by a factor on their contact load, until a load and the least one have been passed."""
        states, coming = [near], stride > 1
        while True:
            state, factor = None, stride
            while state is None and abs(math.log(factor)) > -math.log(SHORTEST):
                state = self.settled(states[-1], contact=states[-1].contact * factor)
                factor = math.sqrt(factor) if state is None else factor
            if state is None:
                self.ended = f"at a contact load of {self.force(states[-1].contact):.4g} mN it does not converge"
                if until > -np.inf:
                    raise RuntimeError(self.ended)
                return states
            states.append(state)
            least = min(one.load for one in states)
            risen = least < 0 and state.load > least + RISEN * abs(least)
            if coming and state.load >= until and (risen or least < until):
                return states
            if not coming and (state.load <= until or risen or state.contact < self.fewest):
                return states

    def lowest(self, states: list[State]) -> State:
        """The state of the least load, by parabolas through the three lowest over the logarithm of the contact load."""
        place = int(np.argmin([one.load for one in states]))
        three = states[max(place - 1, 0) : place + 2]
        for _ in range(REFINEMENTS):
            if len(three) < 3:
                break
            x, y = (np.array(each) for each in zip(*((math.log(s.contact), s.load) for s in three), strict=True))
            bend, slope, _ = np.polyfit(x - x[1], y, 2)
            middle = three[1]
            if not bend > 0 or abs(slope / (2 * bend)) < 1e-3:
                break
            found = self.settled(middle, contact=middle.contact * math.exp(-slope / (2 * bend)))
            if found is None:
                break
            four = sorted([*three, found], key=attrgetter("contact"))
            place = int(np.argmin([one.load for one in four]))
            three = four[max(place - 1, 0) : place + 2]
        return min(three, key=lambda one: one.load)

    def between(self, one: State, other: State, load: float) -> State:
        """The state at a load between those of two others: secants over the contact load (Illinois)."""
        ends = [(math.log(each.contact), each.load - load) for each in (one, other)]
        near, last = other, None
        for _ in range(SEARCHES):
            (left, below), (right, above) = ends
            middle = left - below * (right - left) / (above - below)
            found = self.settled(near, contact=math.exp(middle))
            if found is None:
                break
            miss = found.load - load
            if abs(miss) <= self.enough * (found.contact + abs(load)):
                return found
            side = int(miss * above > 0)
            ends[side] = (middle, miss)
            if side == last:
                ends[1 - side] = (ends[1 - side][0], ends[1 - side][1] / 2)
            last, near = side, found
        raise RuntimeError("the attraction does not converge")

    def force(self, mean: float) -> float:
        """mN, of a mean pressure in GPa."""
        return mean * self.problem.cell * self.problem.gap.size


def _accelerated(steps: list[tuple[Floats, Floats]]) -> Floats:
    """The step that Anderson's acceleration takes from attractions and their changes."""
    changes = np.array([change.ravel() for _, change in steps])
    values = np.array([value.ravel() for value, _ in steps])
    if len(steps) == 1:
        return steps[0][1]
    differences = np.diff(changes, axis=0)
    square = differences @ differences.T
    square[np.diag_indices_from(square)] *= 1 + REGULAR
    parts = np.linalg.lstsq(square, differences @ changes[-1], rcond=None)[0]
    return np.asarray((changes[-1] - parts @ (np.diff(values, axis=0) + differences)).reshape(steps[0][1].shape))


def sticking(
    problem: Problem, loads: Floats, *, tolerance: float, progress: Callable[[int, int, float], object] | None
) -> list[Pressed]:
    """The contact at each external load (mN), one after the other on its branch."""
    contacts: list[Pressed] = []
    report = None if progress is None else lambda iteration, error: progress(len(contacts), iteration, error)
    attraction = Attraction(problem, tolerance=tolerance, report=report)
    whole = problem.cell * problem.gap.size
    state = None
    for load in loads.tolist():
        try:
            state = attraction.at(load / whole, state)
        except RuntimeError as error:
            raise RuntimeError(f"no solution at {load:g} mN: {error}") from None
        contacts.append(pressed_of(problem, state, load, state.attraction))
    return contacts


def drawn_apart(pressed: Pressed, *, tolerance: float) -> tuple[list[Pressed], str]:
    """The contacts from one on as bodies are drawn apart, that of the least load the last, and why they ended early."""
    problem, whole = pressed.problem, pressed.problem.cell * pressed.problem.gap.size
    attraction = Attraction(problem, tolerance=tolerance, report=None)
    pressure = pressed.on_grid(pressed.values)
    start = State(pressure.ravel(), np.asarray(pressed.attraction), float(pressure.mean()), pressed.load / whole)
    states = attraction.branch(start, STRIDE)
    lowest = attraction.lowest(states)
    ways = [one for one in states[1:] if one.contact > lowest.contact and one.load > lowest.load] + [lowest]
    later = [pressed_of(problem, one, one.load * whole, one.attraction) for one in ways if one is not start]
    return [pressed, *later], attraction.ended
