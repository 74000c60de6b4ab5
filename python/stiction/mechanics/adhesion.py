"""Equilibria of two adhesive elastic half-spaces whose attraction decays exponentially with the gap.

The attraction is σ(g) = w/ρ exp(-g/ρ). Each iteration reduces the undeformed gap g0 by the displacement Kσ due to the
attraction, solves the contact, and evaluates σ at the new gap, until σ no longer changes.

Under a constant external load each iteration lowers the energy, because the energy of the attraction is a concave
function of the gap. A smaller load or attraction gives a larger gap at every point. Therefore, from a contact under a
larger load, the attraction decreases with every iteration, either to the first equilibrium of bodies that are pulled
apart, or until the bodies separate. In the second case the bodies do not bear the load, because the attraction of any
equilibrium would be a lower bound.

Near the pull-off load of soft bodies, the edges of the contacts move by less than a grid cell per iteration, and each
iteration solves a contact problem. Conjugate gradients (`EnergyMinimizer`) change pressure and attraction together, so
that the edges move by about a cell per step. These steps may pass an equilibrium. The same steps replace iterations of
maps that converge slowly under a given load.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

import stiction._core as _core
from stiction._caching import cached_property
from stiction._checks import Floats
from stiction._errors import NoSolutionError
from stiction.mechanics.half_space_problem import (
    AdhesionState,
    ContactSolution,
    HalfSpaceProblem,
    coarsen_problem,
    solver_thread_count,
    take_every_second_point,
    to_contact_solution,
)
from stiction.mechanics.solution_record import SolutionRecord, StepResult

# Number of steps without extrapolation between two extrapolated steps; steps without extrapolation damp oscillations.
NUM_UNACCELERATED_STEPS = 2
MAX_EXTRAPOLATION_FACTOR = 10.0
MAX_SOLVES_PER_LOAD = 2000
# After this many contact solutions for a map, the energy is minimized, which takes fewer iterations for soft bodies.
MAX_SOLVES_BEFORE_MINIMIZATION = 6
MAX_SOLVES_PER_CONTACT_LOAD = 60
MAX_SOLVES_PER_TRIAL_CONTACT_LOAD = 12
MAX_STALLED_SOLVES = 20
MAX_RESIDUAL_TO_TOLERANCE_RATIO = 10.0
# Smallest tolerance of a contact solution; with a smaller tolerance, round-off may prevent convergence.
MIN_SOLUTION_TOLERANCE = 1e-8
TOLERANCE_TO_RESIDUAL_RATIO = 0.05
# Without extrapolation, errors of contact solutions do not grow from step to step, so their tolerance may be large.
PLAIN_TOLERANCE_TO_RESIDUAL_RATIO = 1.0
MAX_SOLUTION_TOLERANCE = 1e-3
# Numerical errors may raise the attraction by this fraction of the maximum attraction while the bodies separate.
MAX_NUMERICAL_ATTRACTION_INCREASE = 1e-3
# Bodies count as separate if the contact load is below this fraction of the mean attraction at first contact.
MIN_CONTACT_LOAD_RATIO = 1e-3
CONTACT_LOAD_REDUCTION_RATIO = 0.6
# Relative difference of the final two loads in a pull-off search: an equilibrium exists at one, but not at the other.
PULL_OFF_LOAD_TOLERANCE = 0.01
# A load is the pull-off load only if, at a load lower by this fraction, plain iterations separate the bodies.
LOAD_MARGIN_OF_MINIMUM_CHECK = 0.05
MIN_PREDICTED_LOAD_DECREASE = 0.003
MIN_CONTACT_LOAD_DIFFERENCE = 0.01
MAX_REFINEMENT_SOLVES = 6
# Maximum relative change of the external load per step: in a larger step, separating bodies may skip equilibria.
MAX_LOAD_STEP = 0.1
MAX_TRIAL_LOADS = 40
# If a grid has at least this many points per side, its pull-off load is first searched for on a coarser grid.
MIN_COARSENED_POINTS = 128

MAX_MINIMIZATION_STEPS = 10_000
MINIMIZATION_TO_ACCEPTED_RESIDUAL_RATIO = 0.5


class EquilibriumNotFoundError(NoSolutionError):
    """Error raised if no equilibrium of adhesive bodies is found."""


@dataclass
class _IterationState:
    """State of an iteration towards an adhesive equilibrium, so that an interrupted iteration can resume."""

    attraction: Floats
    pressure: Floats | None = None
    contact_load: float = math.nan
    # Attraction after the last step without extrapolation: the iteration returns to it if extrapolation loses contact.
    plain_attraction: Floats | None = None
    residual: float = math.inf
    least_residual: float = math.inf
    tolerance_ratio: float = TOLERANCE_TO_RESIDUAL_RATIO
    stalled_count: int = 0
    number: int = 0

    num_states: int = 0
    best_state: AdhesionState | None = None
    best_state_number: int = 0
    best_residual: float = math.inf
    last_residual: float = math.inf

    def to_step_result(self) -> StepResult:
        """Convert the iteration state to a storable mapping of names to arrays and numbers."""
        result = {name: value for name, value in vars(self).items() if value is not None and name != "best_state"}
        best_state = {} if self.best_state is None else vars(self.best_state)
        return result | {f"best_{name}": value for name, value in best_state.items()}

    @classmethod
    def from_step_result(cls, result: StepResult) -> _IterationState:
        """Restore an iteration state from a mapping that `to_step_result` returned."""
        field_values = {
            field.name: _to_array_or_number(result[field.name]) for field in fields(cls) if field.name in result
        }
        if "best_pressure" in result:
            field_values["best_state"] = _to_adhesion_state(
                {name.removeprefix("best_"): value for name, value in result.items() if name.startswith("best_")}
            )
        return cls(**field_values)


def _to_array_or_number(value: Any) -> Any:
    """Return a zero-dimensional array as a Python number, and any other array unchanged."""
    return value if np.ndim(value) else np.asarray(value).item()


def _to_adhesion_state(result: StepResult) -> AdhesionState:
    return AdhesionState(
        **{
            field.name: _to_array_or_number(result[field.name])
            for field in fields(AdhesionState)
            if field.name in result
        }
    )


class AdhesionSolver:
    """Solver for the equilibria of two elastic half-spaces with adhesive attraction."""

    def __init__(
        self, problem: HalfSpaceProblem, *, tolerance: float, report: Callable[[int, float], object] | None,
        record: SolutionRecord | None = None,
    ) -> None:  # fmt: skip
        self.record = record or SolutionRecord()
        self.problem, self.report, self.solver_tolerance, self.max_residual = (
            problem,
            report,
            tolerance,
            MAX_RESIDUAL_TO_TOLERANCE_RATIO * tolerance,
        )
        self.range, self.uncertainty_reason = problem.adhesion_range, ""
        self.max_attraction = problem.work_of_adhesion / self.range
        self.bound = np.array([np.inf if problem.hardness is None else problem.hardness])
        # The relative error of the attraction equals the error of the gap divided by the range of the attraction.
        self.relative_range = self.range / float(problem.gap.std() or 1)
        self.tolerance = max(
            min(tolerance, MAX_RESIDUAL_TO_TOLERANCE_RATIO * tolerance * self.relative_range), MIN_SOLUTION_TOLERANCE
        )
        self.max_trial_solves = (
            MAX_SOLVES_PER_TRIAL_CONTACT_LOAD if problem.gap.ndim == 2 else MAX_SOLVES_PER_CONTACT_LOAD
        )
        self.min_contact = MIN_CONTACT_LOAD_RATIO * float(self.attraction_at_gap(problem.gap).mean())

    def attraction_at_gap(self, gap: Floats) -> Floats:
        """Return the attraction (GPa) at given gaps (µm).

        A negative gap counts as 0.
        """
        return np.asarray(self.max_attraction * np.exp(np.maximum(gap, 0) / -self.range))

    def solve_at_contact_pressure(
        self, near: AdhesionState, contact_load: float, *, earlier_state: AdhesionState,
        max_solves: int = MAX_SOLVES_PER_CONTACT_LOAD,
    ) -> AdhesionState:  # fmt: skip
        """Find the adhesive equilibrium at a mean contact pressure (GPa) by iteration, starting from the state `near`.

        Nowhere may the attraction exceed the attraction in `earlier_state`: the bodies then support the load when they
        are pulled apart. Otherwise, or if the iteration has not converged after `max_solves` contact solutions,
        `EquilibriumNotFoundError` is raised.
        """

        def solve() -> StepResult:
            iteration = self._start_iteration(near)
            for state, residual in self._iterate_to_equilibrium(
                iteration, lambda _: contact_load, MAX_EXTRAPOLATION_FACTOR
            ):
                max_attraction = earlier_state.attraction + MAX_NUMERICAL_ATTRACTION_INCREASE * self.max_attraction
                if residual <= self.max_residual and (state.attraction <= max_attraction).all():
                    return dict(vars(state))
                if residual <= self.max_residual:
                    break
                if residual < iteration.best_residual:
                    iteration.best_residual, iteration.best_state_number = residual, iteration.num_states
                num_states_since_best = iteration.num_states - iteration.best_state_number
                if num_states_since_best > MAX_STALLED_SOLVES or iteration.num_states == max_solves:
                    break
                iteration.num_states += 1
            raise EquilibriumNotFoundError("the iteration between attraction and contact pressures did not converge")

        return _to_adhesion_state(self.record.run_step(solve, EquilibriumNotFoundError))

    def find_equilibrium_at_pressure(
        self, near: AdhesionState | None, load: float, *, max_factor: float = MAX_EXTRAPOLATION_FACTOR,
        max_solves: int | None = None,
    ) -> tuple[AdhesionState, bool]:  # fmt: skip
        """Return the contact state at an external pressure (GPa), and whether this state is in equilibrium.

        The iteration starts from the state `near`, or from bodies without attraction if `near` is None. After
        `max_solves` contact solutions, if given, the last state is returned with False.

        If the bodies separate, the iterated state with the smallest change is returned with False. Separation is
        certain only with plain steps (`max_factor` = 1), because extrapolated steps may pass an equilibrium.
        `EquilibriumNotFoundError` is raised if the iteration has neither converged nor lost contact after
        `MAX_SOLVES_PER_LOAD` contact solutions.
        """
        min_contact = self.min_contact if near is None else -math.inf

        def solve() -> StepResult:
            iteration = self._start_iteration(near)
            if max_factor == 1 and iteration.number == 0:
                iteration.tolerance_ratio = PLAIN_TOLERANCE_TO_RESIDUAL_RATIO
            states = self._iterate_to_equilibrium(
                iteration, lambda mean_attraction: max(load + mean_attraction, min_contact), max_factor
            )
            for state, residual in states:
                if residual <= self.max_residual:
                    return vars(state) | {"is_balanced": True}
                if iteration.num_states + 1 == max_solves:
                    return vars(state) | {"is_balanced": False}
                if iteration.num_states == MAX_SOLVES_PER_LOAD:
                    raise EquilibriumNotFoundError(
                        "the iteration between attraction and contact pressures did not converge"
                    )
                # The residuals of the first two states are ignored, because they may be small by chance.
                if residual < min(iteration.last_residual, iteration.best_residual) and iteration.num_states > 1:
                    iteration.best_state, iteration.best_residual = state, residual
                iteration.last_residual = residual
                iteration.num_states += 1
            slowest_state = iteration.best_state or near
            assert slowest_state is not None
            return vars(slowest_state) | {"is_balanced": False}

        result = self.record.run_step(solve, EquilibriumNotFoundError)
        return _to_adhesion_state(result), bool(result["is_balanced"])

    def _start_iteration(self, near: AdhesionState | None) -> _IterationState:
        """Return the first state: that of an interrupted iteration, else `near`, else a state without attraction."""
        if (state := self.record.read_state()) is not None:
            return _IterationState.from_step_result(state)
        if near is None:
            return _IterationState(np.zeros_like(self.problem.gap))
        return _IterationState(near.attraction, near.pressure)

    def _iterate_to_equilibrium(
        self, state: _IterationState, contact_load: Callable[[float], float], max_factor: float
    ) -> Iterator[tuple[AdhesionState, float]]:
        """Yield contact states and relative changes of the attraction in each iteration, until the bodies separate.

        The contact load (GPa) is a function of the mean attraction. After `NUM_UNACCELERATED_STEPS` plain steps, a step
        is extrapolated as a geometric series with the ratio of the last two changes, limited to `max_factor` times the
        last change.
        """
        for number in itertools.count(state.number):
            state.number = number
            self.record.offer_state(state.to_step_result)
            attraction = state.attraction
            mean_attraction = float(attraction.mean())
            mean_pressure = contact_load(mean_attraction)
            if mean_pressure < self.min_contact and state.plain_attraction is not None:
                state.attraction, state.plain_attraction = state.plain_attraction, None
                continue
            if mean_pressure < self.min_contact:
                return
            tolerance = self._solution_tolerance(state)
            contact_state, gap = self._solve_contact(state, mean_pressure, tolerance)
            state.pressure = contact_state.pressure
            attraction_change = self.attraction_at_gap(gap) - attraction
            previous_residual, residual = (
                state.residual,
                float(np.abs(attraction_change).mean()) / (mean_pressure + mean_attraction),
            )
            if residual > self.max_residual or tolerance <= self.tolerance:
                yield contact_state, residual
            state.residual = residual
            state.stalled_count = 0 if residual < state.least_residual else state.stalled_count + 1
            state.least_residual = min(state.least_residual, residual)
            # If the residual stops decreasing, contact solutions may be too inaccurate, so their tolerance is reduced.
            if state.stalled_count > MAX_STALLED_SOLVES:
                state.tolerance_ratio, state.stalled_count = state.tolerance_ratio / 10, 0
            next_attraction = np.clip(attraction + attraction_change, 0.0, self.max_attraction)
            state.plain_attraction = None
            if number % (NUM_UNACCELERATED_STEPS + 1) == NUM_UNACCELERATED_STEPS and max_factor > 1:
                state.plain_attraction = next_attraction
                step_factor = _extrapolation_factor(residual, previous_residual, max_factor)
                next_attraction = np.clip(attraction + step_factor * attraction_change, 0.0, self.max_attraction)
            state.attraction = next_attraction

    def _solution_tolerance(self, state: _IterationState) -> float:
        """Return the tolerance of the next contact solution, which decreases with the residual of the iteration.

        The tolerance is proportional to the residual of the iteration, within limits.
        """
        tolerance = state.tolerance_ratio * self.relative_range * state.residual
        return min(max(self.tolerance, tolerance), MAX_SOLUTION_TOLERANCE)

    def _solve_contact(
        self, state: _IterationState, contact_load: float, tolerance: float
    ) -> tuple[AdhesionState, Floats]:
        """Solve the contact at a mean contact pressure (GPa) under the current attraction.

        Return the contact and its gap (µm).
        """
        if not contact_load < self.bound[0]:
            raise EquilibriumNotFoundError("the attraction raises the pressure to the hardness at all points")
        grids, threads = self.problem.grids, solver_thread_count()
        attracted_gap = self.problem.gap - grids.displacement(state.attraction, threads=threads)
        solver = _core.HalfSpaceSolver(attracted_gap, grids, bound=self.bound, tolerance=tolerance, threads=threads)
        solution = solver.at(
            contact_load, near=state.pressure, threads=threads, progress=self.report, counter=self.record.counter
        )
        if not solution.error <= max(tolerance, self.solver_tolerance):
            raise EquilibriumNotFoundError("the solver for the contact pressures under attraction did not converge")
        displacement = grids.displacement(solution.pressure.reshape(attracted_gap.shape), threads=threads)
        contact_state = AdhesionState(
            solution.pressure,
            state.attraction,
            contact_load,
            contact_load - float(state.attraction.mean()),
            solution.approach,
            solution.error,
            solution.iterations,
        )
        return contact_state, attracted_gap + displacement - solution.approach

    def at(self, load: float, near: AdhesionState | None) -> AdhesionState:
        """Compute the equilibrium of the adhesive contact under an external pressure (GPa).

        The iteration starts from `near`, or without contact for None.
        """
        if near is None and load < 0:
            near = self._find_equilibrium(None, 0.0)[0]
        state, is_balanced = self._find_equilibrium(near, load)
        if not is_balanced:
            state, is_balanced = self.find_equilibrium_at_pressure(near, load, max_factor=1.0)
        if not is_balanced:
            assert near is not None
            least_load = (
                f"{self.mean_pressure_to_force(find_state_of_lowest_load(self.trace_separation(near)).load):.4g} mN"
            )
            raise EquilibriumNotFoundError(
                f"the lowest load that the bodies support is {least_load} or lower; {self.uncertainty_reason}"
                if self.uncertainty_reason
                else f"the bodies separate at {least_load}"
            )
        return state

    def _find_equilibrium(self, near: AdhesionState | None, load: float) -> tuple[AdhesionState, bool]:
        """Return the contact state at an external pressure (GPa), and whether this state is in equilibrium.

        The energy of maps is minimized if their iteration converges slowly. If the minimization finds no equilibrium,
        the slow iteration decides.
        """
        if self.problem.gap.ndim == 2:
            state, is_balanced = self.find_equilibrium_at_pressure(
                near, load, max_solves=MAX_SOLVES_BEFORE_MINIMIZATION
            )
            if is_balanced:
                return state, True
            with contextlib.suppress(EquilibriumNotFoundError):
                minimum = self.minimize_energy(state, load)
                if minimum is not None:
                    return minimum, True
        return self.find_equilibrium_at_pressure(near, load)

    def trace_separation(self, start: AdhesionState) -> list[AdhesionState]:
        """Return the equilibria passed while the bodies are pulled apart, down to the lowest external load (pull-off).

        If the bodies are hard, equilibria at decreasing contact loads lead past the minimum of the external load. If
        this minimum is not certain, loads are tried by energy minimization, until the bodies separate under a load that
        is lower by `PULL_OFF_LOAD_TOLERANCE`. On large grids, the first of these loads is the minimum load on a grid of
        twice the spacing. If an iteration does not converge, `uncertainty_reason` contains the reason.
        """
        self.uncertainty_reason = ""
        opening_state = self.find_opening_state(start)
        states = [start] if opening_state is None else [start, opening_state]
        first_states = states
        states = self.refine_minimum_load(self.extend_unloading_states(states))
        if self._is_minimum_certain(states, first_states[-1]):
            return states
        # No energy minimization starts from a state found at a given contact load, because this state may be unstable.
        states, stable_states = [*first_states, find_state_of_lowest_load(states)], list(first_states)
        # External load = contact load - mean attraction, where the mean attraction decreases from state to state.
        # In states after `first_states`, the external load exceeds -(mean attraction in the last of `first_states`).
        unsupported_load, is_certain = -first_states[-1].mean_attraction, True
        try:
            first_load = self._find_pull_off_load_on_coarser_grid(start)
            relative_step, approach_step = math.inf if first_load == 0 else 2 * PULL_OFF_LOAD_TOLERANCE, 0.5
            for number in range(MAX_TRIAL_LOADS):
                near, least_load = find_state_of_lowest_load(stable_states), find_state_of_lowest_load(states).load
                load = (least_load + unsupported_load) / 2
                if least_load < 0:
                    next_load = (1 + PULL_OFF_LOAD_TOLERANCE) * least_load
                    if unsupported_load >= next_load and is_certain:
                        return states
                    if unsupported_load > (1 + MAX_LOAD_STEP) * least_load:
                        load = -math.sqrt(least_load * unsupported_load)
                    load = min(max(load, (1 + relative_step) * least_load), next_load)
                    relative_step *= 2
                    if unsupported_load >= next_load:
                        # The bodies separated after a large change of the load, so they may have skipped equilibria.
                        is_near = near.load < (1 - MAX_LOAD_STEP) * unsupported_load
                        load = unsupported_load if is_near else near.load + approach_step * (least_load - near.load)
                if number == 0 and unsupported_load < first_load < least_load:
                    load, relative_step = first_load, 2 * PULL_OFF_LOAD_TOLERANCE
                state = self.minimize_energy(near, load)
                if state is not None:
                    states = sorted([*states, state], key=lambda state: -state.load)
                    stable_states.append(state)
                    if load <= unsupported_load:
                        unsupported_load, is_certain = -first_states[-1].mean_attraction, True
                elif load > least_load:
                    approach_step /= 2
                else:
                    unsupported_load, is_certain = load, near.load < (1 - MAX_LOAD_STEP) * load
                    relative_step = math.inf
        except EquilibriumNotFoundError as error:
            self.uncertainty_reason = str(error)
            return states
        self.uncertainty_reason = f"{MAX_TRIAL_LOADS} trial loads were too few to find the minimum"
        return states

    def _is_minimum_certain(self, states: list[AdhesionState], start: AdhesionState) -> bool:
        """Return whether it is certain that no equilibrium exists slightly below the lowest load in `states`.

        If bounds on the load do not decide, iterations from the equilibrium `start` do. Extrapolated steps may pass an
        equilibrium, plain steps cannot.
        """
        least_load = find_state_of_lowest_load(states).load
        # Between two equilibria, the external load is at least (later contact load) - (earlier mean attraction).
        load_bounds = [later.contact_load - earlier.mean_attraction for earlier, later in itertools.pairwise(states)]
        if min([*load_bounds, -states[-1].mean_attraction]) >= (1 + PULL_OFF_LOAD_TOLERANCE) * least_load:
            return True
        ends_before_minimum = states[-1].load == least_load and states[-1].contact_load > self.min_contact
        if least_load >= 0 or ends_before_minimum:
            return False
        try:
            return not any(
                self.find_equilibrium_at_pressure(start, (1 + margin) * least_load, max_factor=max_factor)[1]
                for margin, max_factor in (
                    (PULL_OFF_LOAD_TOLERANCE, MAX_EXTRAPOLATION_FACTOR),
                    (LOAD_MARGIN_OF_MINIMUM_CHECK, 1.0),
                )
            )
        except EquilibriumNotFoundError:
            return False

    def minimize_energy(self, near: AdhesionState, load: float) -> AdhesionState | None:
        """Return the equilibrium at an external pressure (GPa) by energy minimization.

        Returns None if the bodies separate.

        The minimization starts from the nearby state `near`. The result of the minimization is iterated until it has
        the accuracy of `find_equilibrium_at_pressure`. `EquilibriumNotFoundError` is raised if the minimization does
        not converge.
        """

        def solve() -> StepResult:
            state = self._minimizer.minimize(near, load)
            return {"is_balanced": False} if state is None else vars(state) | {"is_balanced": True}

        result = self.record.run_step(solve, EquilibriumNotFoundError)
        if not result["is_balanced"]:
            return None
        state, is_balanced = self.find_equilibrium_at_pressure(_to_adhesion_state(result), load)
        return state if is_balanced else None

    @cached_property
    def _minimizer(self) -> EnergyMinimizer:
        return EnergyMinimizer(self)

    def _find_pull_off_load_on_coarser_grid(self, start: AdhesionState) -> float:
        """Return the pull-off load as external pressure (GPa), computed on a grid with twice the spacing.

        The energy minimization on this grid starts from the contact `start`. Returns 0 if the grid is small or no such
        load is found.
        """
        if min(self.problem.gap.shape) < MIN_COARSENED_POINTS:
            return 0.0
        solver = AdhesionSolver(
            coarsen_problem(self.problem), tolerance=self.solver_tolerance, report=None, record=self.record
        )
        pressure, attraction = (
            take_every_second_point(values.reshape(self.problem.gap.shape))
            for values in (start.pressure, start.attraction)
        )
        near = AdhesionState(pressure.ravel(), attraction, float(pressure.mean()), start.load)
        try:
            coarse_start = solver.minimize_energy(near, start.load)
            if coarse_start is None:
                return 0.0
            return min(find_state_of_lowest_load(solver.trace_separation(coarse_start)).load, 0.0)
        except EquilibriumNotFoundError:
            return 0.0

    def extend_unloading_states(self, states: list[AdhesionState]) -> list[AdhesionState]:
        """Append equilibria at decreasing contact loads to a series of states, and return the extended series.

        The series ends when the external load rises, or when no further equilibrium is found.
        """
        states = list(states)
        while states[-1].contact_load > self.min_contact and states[-1] is find_state_of_lowest_load(states):
            try:
                states.append(
                    self.solve_at_contact_pressure(
                        states[-1],
                        CONTACT_LOAD_REDUCTION_RATIO * states[-1].contact_load,
                        earlier_state=states[0],
                        max_solves=self.max_trial_solves,
                    )
                )
            except EquilibriumNotFoundError:
                break
        return states

    def find_opening_state(self, state: AdhesionState) -> AdhesionState | None:
        """Return the equilibrium at which complete contact begins to open.

        Returns None if contact is not complete.

        Before the contact opens, all points move together, and the attraction is the attraction in full contact.
        """
        if not (state.pressure.all() and (state.pressure < self.bound[0]).all()):
            return None
        grids, gap = self.problem.grids, self.problem.gap
        unit_pressure, unit_displacement = grids.linear_response(
            np.ones(gap.shape, bool), threads=solver_thread_count()
        )
        pressure_scale = float((state.pressure / unit_pressure.ravel()).min())
        pressure = np.maximum(state.pressure - pressure_scale * unit_pressure.ravel(), 0)
        contact_load = float(pressure.mean())
        return AdhesionState(
            pressure,
            state.attraction,
            contact_load,
            contact_load - state.mean_attraction,
            state.approach - pressure_scale * unit_displacement,
        )

    def refine_minimum_load(self, states: list[AdhesionState]) -> list[AdhesionState]:
        """Return the given states and additional equilibria near the interpolated minimum of the external load."""
        states = list(states)
        for _ in range(MAX_REFINEMENT_SOLVES):
            minimum_index = min(range(len(states)), key=lambda index: states[index].load)
            candidates = []
            for first_index in (minimum_index - 1, minimum_index):
                adjacent_states = states[max(first_index, 0) : first_index + 2]
                if (
                    len(adjacent_states) == 2
                    and adjacent_states[1].contact_load
                    < (1 - MIN_CONTACT_LOAD_DIFFERENCE) * adjacent_states[0].contact_load
                ):
                    candidates.append(
                        (
                            *_interpolate_minimum_load(
                                states[max(first_index - 1, 0) : first_index + 3], *adjacent_states
                            ),
                            first_index,
                        )
                    )
            load, contact_load, first_index = min(candidates, default=(0.0, 0.0, 0))
            if load >= (1 + MIN_PREDICTED_LOAD_DECREASE) * states[minimum_index].load:
                break
            try:
                states.insert(
                    first_index + 1,
                    self.solve_at_contact_pressure(
                        states[first_index], contact_load, earlier_state=states[0], max_solves=self.max_trial_solves
                    ),
                )
            except EquilibriumNotFoundError:
                break
        return states

    def mean_pressure_to_force(self, mean: float) -> float:
        """Convert a mean pressure (GPa) on the whole grid to a force (mN)."""
        return mean * self.problem.cell_area * self.problem.gap.size


class EnergyMinimizer:
    """Minimizer of the energy of an adhesive contact under constant load, by preconditioned conjugate gradients."""

    def __init__(self, solver: AdhesionSolver) -> None:
        self.solver, self.problem, self.record = solver, solver.problem, solver.record
        self.limits = {
            "max_residual": MINIMIZATION_TO_ACCEPTED_RESIDUAL_RATIO * solver.max_residual,
            "max_accepted_residual": MAX_RESIDUAL_TO_TOLERANCE_RATIO * solver.max_residual,
            "min_contact_load": solver.min_contact,
        }
        self._core = _core.EnergyMinimizer(
            self.problem.gap, self.problem.grids, max_attraction=solver.max_attraction, range=solver.range,
            hardness=float(solver.bound[0]), threads=solver_thread_count(),
        )  # fmt: skip

    def minimize(self, near: AdhesionState, load: float) -> AdhesionState | None:
        """Minimize the energy at an external pressure (GPa), starting from the state `near`.

        Return None on separation.
        """
        state = self._restore_or_start_minimization(near, load)
        for _ in range(state.number, MAX_MINIMIZATION_STEPS):
            self.record.offer_state(state.fields)
            outcome = self._core.step(state, load, **self.limits, threads=solver_thread_count())
            if outcome == "separated":
                return None
            if outcome == "balanced":
                return self._to_adhesion_state(state, load)
            if outcome == "stalled":
                break
            self.record.counter.add(1)
        force = self.solver.mean_pressure_to_force(load)
        raise EquilibriumNotFoundError(f"at a load of {force:.4g} mN, the energy minimization did not converge")

    def _restore_or_start_minimization(self, near: AdhesionState, load: float) -> _core.MinimizationState:
        """Return the stored state of an interrupted minimization or, if no state is stored, a new initial state."""
        if (fields := self.record.read_state()) is not None:
            return _core.MinimizationState({name: _to_array_or_number(value) for name, value in fields.items()})
        shape = self.problem.gap.shape
        pressure, attraction = near.pressure.reshape(shape), near.attraction.reshape(shape)
        return self._core.start(pressure, attraction, load, threads=solver_thread_count())

    def _to_adhesion_state(self, state: _core.MinimizationState, load: float) -> AdhesionState:
        pressure, attraction = self._core.stresses(state)
        attraction = attraction.reshape(self.problem.gap.shape)
        return AdhesionState(pressure, attraction, load + float(attraction.mean()), load, state.approach)


def _extrapolation_factor(residual: float, previous_residual: float, max_factor: float) -> float:
    """Return the factor, at most `max_factor`, by which to extrapolate an iteration step of the attraction.

    It is the sum 1/(1 - r) of the geometric series whose ratio r is the ratio of the two last residuals.
    """
    residual_ratio = residual / previous_residual if previous_residual else 0.0
    return 1 / (1 - residual_ratio) if residual_ratio < 1 - 1 / max_factor else max_factor


def find_state_of_lowest_load(states: list[AdhesionState]) -> AdhesionState:
    """Return the equilibrium under the lowest (most negative) external load."""
    return min(states, key=lambda state: state.load)


def _interpolate_minimum_load(
    states: list[AdhesionState], upper: AdhesionState, lower: AdhesionState
) -> tuple[float, float]:
    """Interpolate the minimum of the external load, and return this minimum and the contact load there (both GPa).

    The mean attraction is interpolated by a polynomial in the logarithm of the contact load.
    """
    log_contact_loads, mean_attractions = (
        np.array(values)
        for values in zip(*((math.log(state.contact_load), state.mean_attraction) for state in states), strict=True)
    )
    coefficients = np.polyfit(
        log_contact_loads - log_contact_loads.mean(), mean_attractions, log_contact_loads.size - 1
    )
    log_contact_load = np.linspace(math.log(upper.contact_load), math.log(lower.contact_load), 41)[1:-1]
    external_load = np.exp(log_contact_load) - np.polyval(coefficients, log_contact_load - log_contact_loads.mean())
    minimum_index = int(np.argmin(external_load))
    return float(external_load[minimum_index]), float(math.exp(log_contact_load[minimum_index]))


def solve_with_adhesion(
    problem: HalfSpaceProblem, loads: Floats, *, tolerance: float,
    progress: Callable[[int, int, float], object] | None, record: SolutionRecord,
) -> list[ContactSolution]:  # fmt: skip
    """Solve the adhesive contact under each external load (mN), starting from the solution under the previous load."""
    solutions: list[ContactSolution] = []
    report = None if progress is None else lambda iteration, error: progress(len(solutions), iteration, error)
    solver = AdhesionSolver(problem, tolerance=tolerance, report=report, record=record)
    total_area = problem.cell_area * problem.gap.size
    state = None
    for load in loads.tolist():
        try:
            state = solver.at(load / total_area, state)
        except EquilibriumNotFoundError as error:
            raise NoSolutionError(f"no solution at {load:g} mN: {error}") from None
        solutions.append(to_contact_solution(problem, state, load, state.attraction))
    return solutions


def solve_separation(
    contact_solution: ContactSolution, *, tolerance: float, record: SolutionRecord
) -> tuple[list[ContactSolution], str]:
    """Return the contact solutions during separation, and the reason why the pull-off load may be uncertain.

    The reason is "" if the pull-off load is certain.
    """
    problem, total_area = (
        contact_solution.problem,
        contact_solution.problem.cell_area * contact_solution.problem.gap.size,
    )
    solver = AdhesionSolver(problem, tolerance=tolerance, report=None, record=record)
    pressure = contact_solution.on_grid(contact_solution.values)
    start_values = float(pressure.mean()), contact_solution.load / total_area, contact_solution.approach
    start = AdhesionState(pressure.ravel(), np.asarray(contact_solution.attraction), *start_values)
    descending_states, least_load = [], start.load
    # Under a decreasing external load, bodies reach only equilibria at loads below all earlier equilibrium loads.
    for state in solver.trace_separation(start)[1:]:
        if state.load < least_load:
            descending_states.append(state)
            least_load = state.load
    later_solutions = [
        to_contact_solution(problem, state, state.load * total_area, state.attraction) for state in descending_states
    ]
    return [contact_solution, *later_solutions], solver.uncertainty_reason
