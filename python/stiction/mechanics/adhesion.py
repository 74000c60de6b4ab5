"""Adhesion of a half-space: an attraction that falls off with the gap, as a traction on the solver that has none.

With σ(g) = w/ρ exp(-g/ρ), press the gap g0 - Kσ, take σ of the gap that comes out, and repeat until both agree.

Under a constant external load each repetition lowers the energy, because the energy of the attraction is a concave
function of the gap. A smaller load or attraction gives a larger gap at every point. So from a contact under a larger
load the attraction decreases with every repetition, either to the first contact on the way apart, or until the bodies
come off. In the second case they do not bear the load, since the attraction of any contact would be a lower bound.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator

import numpy as np

import stiction._core as _core
from stiction._checks import Floats
from stiction.mechanics.half_space_problem import ContactSolution, Problem, State, threads, to_contact_solution

PLAIN = 2  # plain steps between two longer ones, which damp the shapes that these overshoot
LONGEST = 10.0  # length of a longer step over that of a plain one
MAX_SOLUTIONS = 2000  # solutions for one contact at an external load, some of which lead through jumps
MAX_SETTLING, PATIENCE = 60, 20  # solutions for one at a contact load, and those without a lower residual
LOOSER = 10.0  # residual of the attraction, relative to the contact load and the attraction, over the tolerance
INNERMOST = 1e-8  # smallest tolerance of a solution; below it round-off stalls some
INEXACT, LOOSEST = 0.05, 1e-3  # error of a solution over the residual before it, and its largest tolerance
CLOSER = 1e-3  # increase of the attraction on the way apart, over its maximum, that is an error of the solutions
FEWEST = 1e-3  # contact load below which bodies have come off, over the attraction of bodies that touch at a point
STRIDE = 0.6  # contact load over the one before on the way apart
NEGLECTED = 0.01  # relative error of the least load
FIRST_STEP = 0.05  # relative difference between the least load and the first one tried below it, if that is unknown
SMOOTH = 0.003  # relative difference between the least load and an interpolated one that is not computed
NARROWEST = 0.01  # relative difference of contact loads between which no load is interpolated
MAX_REFINED = 6  # contacts at interpolated loads
MAX_TRIALS = 24  # external loads that are tried on the way apart


class UnsolvedError(RuntimeError):
    """No contact in equilibrium with its attraction was found."""


class Attraction:
    """The attraction of a problem, and contacts in equilibrium with it."""

    def __init__(self, problem: Problem, *, tolerance: float, report: Callable[[int, float], object] | None) -> None:
        self.problem, self.report, self.asked, self.enough = problem, report, tolerance, LOOSER * tolerance
        self.range, self.uncertain = problem.adhesion_range, ""  # why the least load is uncertain
        self.most = problem.work_of_adhesion / self.range
        self.bound = np.array([np.inf if problem.hardness is None else problem.hardness])
        # An error of the gap is one of the attraction in proportion to gap over range.
        self.relative_range = self.range / float(problem.gap.std() or 1)
        self.tolerance = max(min(tolerance, LOOSER * tolerance * self.relative_range), INNERMOST)
        self.fewest = FEWEST * float(self.of(problem.gap).mean())

    def of(self, gap: Floats) -> Floats:
        """GPa at gaps (µm); that of contact where bodies overlap."""
        return np.asarray(self.most * np.exp(np.maximum(gap, 0) / -self.range))

    def settle(self, near: State, contact: float, *, before: State) -> State:
        """Return the contact at a mean pressure (GPa) on the way apart from an earlier one, iterated from a near one.

        An `UnsolvedError` is raised if the iteration fails, or if it leads to a contact in which some points are closer
        than in the earlier one. If none are, bodies that are drawn apart bear the load of the contact.
        """
        least, best = math.inf, 0
        for count, (state, residual) in enumerate(self._repetitions(near, lambda _: contact, LONGEST)):
            if residual <= self.enough and (state.attraction <= before.attraction + CLOSER * self.most).all():
                return state
            if residual <= self.enough:
                break
            if residual < least:
                least, best = residual, count
            if count - best > PATIENCE or count == MAX_SETTLING:
                break
        raise UnsolvedError("the attraction does not converge")

    def relax(self, near: State | None, load: float, *, longest: float = LONGEST) -> tuple[State, bool]:
        """Return the contact to which bodies go under an external load (GPa), from another or from none, and True.

        If the bodies come off, return the contact that changes most slowly on the way, and False. That is certain if
        the longest step is that of plain repetitions, 1: longer steps may lead past a contact. An `UnsolvedError` is
        raised if `MAX_SOLUTIONS` do not decide.
        """
        first = self.fewest if near is None else -math.inf
        slowest, least, before = near, math.inf, math.inf
        repetitions = self._repetitions(near, lambda held: max(load + held, first), longest)
        for count, (state, residual) in enumerate(repetitions):
            if residual <= self.enough:
                return state, True
            if count == MAX_SOLUTIONS:
                raise UnsolvedError("the attraction does not converge")
            if residual < min(before, least) and count > 1:  # the first are slow because they are near an equilibrium
                slowest, least = state, residual
            before = residual
        assert slowest is not None
        return slowest, False

    def _repetitions(
        self, near: State | None, contact_load: Callable[[float], float], longest: float
    ) -> Iterator[tuple[State, float]]:
        """Yield contacts, and the change of their attraction over the forces, until the bodies come off.

        The contact load (GPa) is a function of the mean attraction. The attraction changes as in the last repetition
        plus, after `PLAIN` of them, the rest of a geometric series with the ratio of the last two changes, but at most
        `longest` times the change.
        """
        grids, gap = self.problem.grids, self.problem.gap
        attraction = np.zeros_like(gap) if near is None else near.attraction
        pressure = None if near is None else near.pressure
        plain: Floats | None = None  # attraction after a plain step, if the last one was longer
        residual = least = math.inf
        inexact, slow = INEXACT, 0
        for count in itertools.count():
            held = float(attraction.mean())
            mean = contact_load(held)
            if mean < self.fewest and plain is not None:
                attraction, plain = plain, None
                continue
            if mean < self.fewest:
                return
            if not mean < self.bound[0]:
                raise UnsolvedError("the attraction brings all points to the hardness")
            tolerance = min(max(self.tolerance, inexact * self.relative_range * residual), LOOSEST)
            lowered = gap - grids.displacement(attraction, threads=threads())
            solver = _core.HalfSpaceSolver(lowered, grids, bound=self.bound, tolerance=tolerance, threads=threads())
            solution = solver.at(mean, near=pressure, threads=threads(), progress=self.report)
            if not solution.error <= max(tolerance, self.asked):
                raise UnsolvedError("the pressures do not converge")
            pressure = solution.pressure
            moved = grids.displacement(pressure.reshape(gap.shape), threads=threads())
            change = self.of(lowered + moved - solution.approach) - attraction
            before, residual = residual, float(np.abs(change).mean()) / (mean + held)
            known = solution.approach, solution.error, solution.iterations
            if residual > self.enough or tolerance <= self.tolerance:
                yield State(pressure, attraction, mean, mean - held, *known), residual
            slow = 0 if residual < least else slow + 1
            least = min(least, residual)
            if slow > PATIENCE:  # errors of the solutions may be what is left
                inexact, slow = inexact / 10, 0
            ratio = residual / before if before else 0.0
            length = 1 / (1 - ratio) if ratio < 1 - 1 / longest else longest
            following, plain = np.clip(attraction + change, 0.0, self.most), None
            if count % (PLAIN + 1) == PLAIN and longest > 1:
                plain, following = following, np.clip(attraction + length * change, 0.0, self.most)
            attraction = following

    def at(self, load: float, near: State | None) -> State:
        """Return the contact at a mean external load (GPa), to which bodies go from the one before, or from none."""
        if near is None and load < 0:
            near = self.relax(None, 0.0)[0]
        found, holds = self.relax(near, load)
        if not holds:
            found, holds = self.relax(near, load, longest=1.0)
        if not holds:
            assert near is not None
            least = f"{self.force(lowest(self.draw_apart(near)).load):.4g} mN"
            raise UnsolvedError(
                f"bodies bear at least {least}; {self.uncertain}" if self.uncertain else f"bodies come off at {least}"
            )
        return found

    def draw_apart(self, start: State) -> list[State]:
        """Return contacts in the order of falling contact load, from one on to that of the least load or farther.

        Some contacts at falling contact loads lead near the least load. Then lower loads are tried, with longer steps
        and finally, from the start, by plain repetitions: under a load that is lower by `NEGLECTED` the bodies come
        off. If that is not certain, `uncertain` gives the reason.
        """
        self.uncertain = ""
        opening = self.opening(start)
        states = [start] if opening is None else [start, opening]
        first = certain = states[-1]
        states = self.refine(self.unload(states))
        step = FIRST_STEP if states[-1] is lowest(states) else NEGLECTED
        not_borne = -math.inf
        for _ in range(MAX_TRIALS):
            least = lowest(states).load
            # Between two contacts, the contact load is at least that of the later one and the attraction at most that
            # of the earlier one.
            possible = min([b.contact - a.held for a, b in itertools.pairwise(states)] + [-states[-1].held])
            if possible >= (1 + NEGLECTED) * least:
                return states
            load = (least + max(possible, not_borne)) / 2
            if least < 0:
                load = min(max(load, (1 + step) * least), (1 + NEGLECTED) * least)
            try:
                found, holds = self.relax(first, load) if load > not_borne else (first, False)
                if not holds and load >= (1 + NEGLECTED) * least:
                    found, holds = self.relax(certain, load, longest=1.0)
                    if not holds:
                        return states
                    certain, not_borne = found, -math.inf
            except UnsolvedError:
                self.uncertain = f"at a load of {self.force(load):.4g} mN the attraction does not converge"
                return states
            if holds:
                first, step = found, 2 * step
            else:
                not_borne = load
                try:
                    found = self.settle(found, found.contact, before=start)
                except UnsolvedError:
                    continue
                if found.load >= least:
                    continue
                step = NEGLECTED
            states = sorted([*states, found], key=lambda state: -state.contact)
        self.uncertain = f"{MAX_TRIALS} loads are too few"
        return states

    def unload(self, states: list[State]) -> list[State]:
        """Return contacts continued to smaller contact loads until the load rises, or until no other is found."""
        states = list(states)
        while states[-1].contact > self.fewest and states[-1] is lowest(states):
            try:
                states.append(self.settle(states[-1], STRIDE * states[-1].contact, before=states[0]))
            except UnsolvedError:
                break
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

    def refine(self, states: list[State]) -> list[State]:
        """Return the states with others where the load that is interpolated between them is lower than the least."""
        states = list(states)
        for _ in range(MAX_REFINED):
            place = min(range(len(states)), key=lambda at: states[at].load)
            lower = []
            for first in (place - 1, place):
                pair = states[max(first, 0) : first + 2]
                if len(pair) == 2 and pair[1].contact < (1 - NARROWEST) * pair[0].contact:
                    lower.append((*_interpolated_minimum(states[max(first - 1, 0) : first + 3], *pair), first))
            load, contact, first = min(lower, default=(0.0, 0.0, 0))
            if load >= (1 + SMOOTH) * states[place].load:
                break
            try:
                states.insert(first + 1, self.settle(states[first], contact, before=states[0]))
            except UnsolvedError:
                break
        return states

    def force(self, mean: float) -> float:
        """mN, of a mean pressure in GPa."""
        return mean * self.problem.cell * self.problem.gap.size


def lowest(states: list[State]) -> State:
    """Return the state of the least load."""
    return min(states, key=lambda state: state.load)


def _interpolated_minimum(states: list[State], upper: State, lower: State) -> tuple[float, float]:
    """Return the least interpolated load (GPa) between two of up to four states, and its contact load.

    The mean attraction is interpolated by a polynomial over the logarithm of the contact load.
    """
    x, y = (np.array(values) for values in zip(*((math.log(s.contact), s.held) for s in states), strict=True))
    factors = np.polyfit(x - x.mean(), y, x.size - 1)
    place = np.linspace(math.log(upper.contact), math.log(lower.contact), 41)[1:-1]
    load = np.exp(place) - np.polyval(factors, place - x.mean())
    least = int(np.argmin(load))
    return float(load[least]), float(math.exp(place[least]))


def solve_with_adhesion(
    problem: Problem, loads: Floats, *, tolerance: float, progress: Callable[[int, int, float], object] | None
) -> list[ContactSolution]:
    """The contact at each external load (mN), one after the other on its branch."""
    contacts: list[ContactSolution] = []
    report = None if progress is None else lambda iteration, error: progress(len(contacts), iteration, error)
    attraction = Attraction(problem, tolerance=tolerance, report=report)
    whole = problem.cell * problem.gap.size
    state = None
    for load in loads.tolist():
        try:
            state = attraction.at(load / whole, state)
        except RuntimeError as error:
            raise RuntimeError(f"no solution at {load:g} mN: {error}") from None
        contacts.append(to_contact_solution(problem, state, load, state.attraction))
    return contacts


def pull_apart(pressed: ContactSolution, *, tolerance: float) -> tuple[list[ContactSolution], str]:
    """The contacts from one on as bodies are drawn apart, that of the least load the last, and why they ended early."""
    problem, whole = pressed.problem, pressed.problem.cell * pressed.problem.gap.size
    attraction = Attraction(problem, tolerance=tolerance, report=None)
    pressure = pressed.on_grid(pressed.values)
    known = float(pressure.mean()), pressed.load / whole, pressed.approach
    start = State(pressure.ravel(), np.asarray(pressed.attraction), *known)
    ways, least = [], start.load
    # A contact that bears less load than an earlier one is not on the way of bodies under a falling load.
    for state in attraction.draw_apart(start)[1:]:
        if state.load < least:
            ways.append(state)
            least = state.load
    later = [to_contact_solution(problem, state, state.load * whole, state.attraction) for state in ways]
    return [pressed, *later], attraction.uncertain
