"""Adhesion of a half-space: an attraction that falls off with the gap, as a traction on the solver that has none.

With σ(g) = w/ρ exp(-g/ρ), press the gap g0 - Kσ, take σ of the gap that comes out, and repeat until both agree.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

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
PATIENCE = 20  # the same on the way apart, where a smaller stride is tried next
SHORTEST = 0.93  # stride at which a branch that does not converge ends
NEGLECTED = 0.01  # part of the least load by which a lower one may be missed
MAX_NEGLECTED = 0.1  # the same where the contacts near it are too few
SMOOTH = 0.005  # part of the least load by which an interpolated one may differ where states need no others between
NARROWEST = 0.01  # logarithm of the ratio of contact loads below which no states are put between two
MARGIN = 4  # fortieths of a span at whose ends no state is put
MAX_REFINED, FEW_REFINED = 16, 2  # states between others; where the way ended early
STEEPER = 2.0  # slope of the load over the contact load that may stand between states, over the largest between two
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
        self, near: State | None, *, contact: float | None = None, load: float = 0.0, plain: bool = False,
        patience: int = STALLED,
    ) -> State | None:  # fmt: skip
        """The contact at a mean pressure or an external load, which `plain` repetitions do not leap over; or None.

        None is returned after `patience` solutions without a lower residual.
        """
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
            elif count - best > patience and not plain:
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
        if start.load <= load:
            return self.between(*self.pushed(start, load), load)
        states = self.unloaded(start, until=load)
        if states[-1].load > load:
            states = self.refined(states)
        crossing = next((pair for pair in pairwise(states) if pair[1].load <= load), None)
        if crossing is None:
            least = f"{self.force(lowest(states).load):.4g} mN"
            raise RuntimeError(
                f"bodies bear at least {least}; {self.ended}" if self.ended else f"bodies come off at {least}"
            )
        return self.between(*crossing, load)

    def near(self, contact: float, *states: State | None) -> State | None:
        """Return the contact at a mean pressure (GPa) that is found first from states (None: no attraction)."""
        for state in states:
            if (found := self.settled(state, contact=contact, patience=PATIENCE)) is not None:
                return found
        return None

    def pushed(self, state: State, load: float) -> tuple[State, State]:
        """Return two states of rising contact load, from one on, between whose loads a load (GPa) lies."""
        factor = 1 / STRIDE
        while True:
            following = self.settled(state, contact=state.contact * factor)
            if following is None and factor < 1 / SHORTEST:
                raise RuntimeError(self.stalled(state))
            if following is None:
                factor = math.sqrt(factor)
            elif following.load >= load:
                return state, following
            else:
                state, factor = following, 1 / STRIDE

    def unloaded(self, start: State, until: float = -np.inf) -> list[State]:
        """Return states of falling contact load from one on, until a load (GPa) is reached, or no less is possible.

        The attraction falls with the contact load, so that no later load is below minus the last mean attraction.
        """
        states, factor, self.ended = [start], STRIDE, ""
        if (opening := self.opening(start)) is not None:
            states.append(opening)
        least = lowest(states).load
        while least > until and states[-1].contact > self.fewest and states[-1].held > -least:
            state = self.near(states[-1].contact * factor, states[-1])
            if state is None and factor > SHORTEST:
                self.ended = self.stalled(states[-1])
                break
            if state is None:
                factor = math.sqrt(factor)
                continue
            states.append(state)
            least, factor = min(least, state.load), max(factor**2, STRIDE)
        return states

    def opening(self, state: State) -> State | None:
        """Return the state in which complete contact opens, where the least pressure is 0; None if it is incomplete.

        All points move alike until then, and the attraction is that of contact everywhere.
        """
        if not (state.pressure.all() and (state.pressure < self.bound[0]).all()):
            return None
        grids, gap = self.problem.grids, self.problem.gap
        unit, moved = grids.linear_response(np.ones(gap.shape, bool), threads=threads())
        part = float((state.pressure / unit.ravel()).min())
        pressure = np.maximum(state.pressure - part * unit.ravel(), 0)
        contact = float(pressure.mean())
        return State(pressure, state.attraction, contact, contact - state.held, state.approach - part * moved)

    def refined(self, states: list[State]) -> list[State]:
        """Return the states with others between them wherever a lower load than their least is possible.

        Between two states the load is at least the contact load of the later less the attraction of the earlier one.
        Where it is interpolated well at a state between them, no others are needed.
        """
        states, closed, count = list(states), set(), FEW_REFINED if self.ended else MAX_REFINED
        while True:
            least, pairs = lowest(states).load, list(pairwise(states))
            slope = min(STEEPER * max((a.load - b.load) / (a.contact - b.contact) for a, b in pairs), 1.0)
            opened = [
                (one.load - slope * (one.contact - other.contact), place)
                for place, (one, other) in enumerate(pairs)
                if other.contact < (1 - NARROWEST) * one.contact and (id(one), id(other)) not in closed
            ]
            possible, place = min(opened, default=(0.0, 0))
            if possible >= (1 + NEGLECTED) * least:
                return states
            if count == 0:
                if possible < (1 + MAX_NEGLECTED) * least:
                    self.ended = self.ended or f"{MAX_REFINED} contacts near it are too few"
                return states
            count -= 1
            one, other = pairs[place]
            curve = _interpolation(states[max(place - 1, 0) : place + 3])
            contact = _lowest_between(curve, one.contact, other.contact)
            found = self.near(contact, one, other)
            if found is None:
                self.ended = self.stalled(one)
                closed.add((id(one), id(other)))
                count = min(count, FEW_REFINED)
                continue
            states.insert(place + 1, found)
            expected = contact - float(curve(math.log(contact)))
            if abs(found.load - expected) <= SMOOTH * abs(least):
                closed |= {(id(one), id(found)), (id(found), id(other))}

    def stalled(self, state: State) -> str:
        """Return why a branch ended at a state."""
        return f"at a contact load of {self.force(state.contact):.4g} mN it does not converge"

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


def lowest(states: list[State]) -> State:
    """Return the state of the least load."""
    return min(states, key=lambda state: state.load)


def _interpolation(states: list[State]) -> Callable[[float | Floats], Floats]:
    """Return the polynomial of the mean attraction (GPa) over the logarithm of the contact load through states."""
    x, y = (np.array(each) for each in zip(*((math.log(s.contact), s.held) for s in states), strict=True))
    middle = x.mean()
    factors = np.polyfit(x - middle, y, x.size - 1)
    return lambda place: np.polyval(factors, np.asarray(place) - middle)


def _lowest_between(curve: Callable[[float | Floats], Floats], upper: float, lower: float) -> float:
    """Return where between two contact loads the interpolated load is least, or the middle if that is at an end."""
    x = np.linspace(math.log(lower), math.log(upper), 41)
    place = int(np.argmin(np.exp(x) - curve(x)))
    return math.exp(x[place] if MARGIN <= place < x.size - MARGIN else x[x.size // 2])


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
    states = attraction.refined(attraction.unloaded(start))
    ways, least = [], start.load
    for state in states[1:]:  # under a falling load the bodies leave out what only less load holds
        if state.load < least:
            ways.append(state)
            least = state.load
    later = [pressed_of(problem, state, state.load * whole, state.attraction) for state in ways]
    return [pressed, *later], attraction.ended
