"""Contact with free tilt: the upper surface tilts until the resultant force acts at the centre.

The solution minimises the energy at the given load. The slopes of the rotation are Lagrange multipliers of the moments,
which decrease as the slopes increase. This is a concave problem with two unknowns. It is solved by Newton steps with
the linear response of the contact points. If the Newton steps fail, they start again from the tilt at which rigid
surfaces would balance. A balanced tilt always exists, because a uniform pressure on the measured points acts at their
centre.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from stiction._checks import Floats
from stiction._errors import NoSolutionError
from stiction.mechanics.half_space_problem import (
    ContactSolution,
    ContactSolver,
    HalfSpaceProblem,
    TiltResponse,
    from_step_result,
    lever_arms,
    mean_moments,
    solver_thread_count,
    to_contact_solution,
    to_step_result,
)
from stiction.mechanics.solution_record import SolutionRecord, StepResult

MAX_RELATIVE_FORCE_OFFSET = 1e-4
MAX_TILT_SOLVES_PER_LOAD = 60
MAX_EDGE_DISPLACEMENT_STEP = 0.5
# This term is added to the diagonal of Newton's equations for the tilt, so that the equations have a solution.
# Unit of `ADDED_MOMENT_PER_SLOPE`: (mean pressure) · (side length)² / (standard deviation of the gap).
ADDED_MOMENT_PER_SLOPE = 1e-6
INDENTATION_TOLERANCE = 1e-6
MAX_CUTTING_PLANES = 200
# Accepted error of the potential energy of rigid surfaces, as a fraction of (load) · (range of the gap).
RIGID_TILT_TOLERANCE = 1e-12


def apply_tilt(problem: HalfSpaceProblem, slopes: Floats) -> HalfSpaceProblem:
    """Tilt the upper surface of a problem about its centre by given slopes: along y and x, or along x for profiles."""
    plane = sum(slope * arm for slope, arm in zip(slopes, lever_arms(problem), strict=True))
    return replace(
        problem, upper_heights=problem.upper_heights + plane, gap=problem.gap + plane, tilt=problem.tilt + slopes
    )


def solve_with_balanced_tilt(
    problem: HalfSpaceProblem, loads: Floats, *, tolerance: float,
    progress: Callable[[int, int, float], object] | None, record: SolutionRecord,
) -> list[ContactSolution]:  # fmt: skip
    """Solve the contact at each load (mN) with the tilt at which the resultant force acts at the centre."""
    contact_solutions: list[ContactSolution] = []
    report = None if progress is None else lambda iteration, error: progress(len(contact_solutions), iteration, error)
    arms, shape = lever_arms(problem), problem.gap.shape
    side_lengths = np.array(shape) * np.array(problem.spacing)
    gap_deviation = float(problem.gap[problem.measured_point_mask > 0].std()) or 1.0

    def solve_contact_and_moments(
        rotated_problem: HalfSpaceProblem, load: float, near: Floats | None, tolerance: float
    ) -> tuple[ContactSolution, Floats]:
        solver = ContactSolver(rotated_problem, "loads", load, tolerance=tolerance, report=report, record=record)
        solution = solver.at(load, near)
        contact_solution = to_contact_solution(rotated_problem, solution, load, scale=solver.scale)
        return contact_solution, mean_moments(solution.pressure.reshape(shape), arms)

    def search_balance(
        start: HalfSpaceProblem, load: float, near: Floats | None, tolerance: float
    ) -> ContactSolution | None:
        """Search for the balanced tilt by Newton's method, starting from the tilt in `start`.

        Return None if the search fails.
        """
        mean_pressure = load / (problem.cell_area * problem.gap.size)
        contact_solution, moments = solve_contact_and_moments(start, load, near, tolerance)
        num_tried = 0
        while float(np.abs(moments / (mean_pressure * side_lengths)).max()) > MAX_RELATIVE_FORCE_OFFSET:
            near = contact_solution.on_grid(contact_solution.values).ravel()
            moments_per_slope = TiltResponse.solve(
                start, contact_solution.on_grid(contact_solution.below_hardness)
            ).moments_per_slope
            slope_step = np.linalg.solve(
                np.diag(ADDED_MOMENT_PER_SLOPE * mean_pressure * side_lengths**2 / gap_deviation) - moments_per_slope,
                moments,
            )
            slope_step *= min(
                1.0, MAX_EDGE_DISPLACEMENT_STEP * gap_deviation / float(np.abs(slope_step * side_lengths / 2).max())
            )
            # If the tilt goes far beyond the energy maximum, the moments reverse their sign, so the change is halved.
            while num_tried < MAX_TILT_SOLVES_PER_LOAD:
                num_tried += 1
                candidate = solve_contact_and_moments(
                    apply_tilt(contact_solution.problem, np.asarray(slope_step, np.float64)), load, near, tolerance
                )
                if float(candidate[1] @ slope_step) >= -MAX_EDGE_DISPLACEMENT_STEP * float(moments @ slope_step):
                    break
                slope_step = slope_step / 2
            else:
                return None
            contact_solution, moments = candidate
        return contact_solution

    def solve_load(load: float) -> StepResult:
        last_solution = contact_solutions[-1] if contact_solutions else None
        start = problem if last_solution is None else last_solution.problem
        near = None if last_solution is None else last_solution.on_grid(last_solution.values).ravel()
        contact_solution = search_balance(start, load, near, tolerance)
        if contact_solution is None:
            # If the search fails, as may happen at low loads, it starts again from the tilt of rigid surfaces.
            rigid_problem = apply_tilt(start, find_rigid_tilt(start, load / start.cell_area))
            touching_solution = solve_contact_and_moments(rigid_problem, load, None, tolerance)[0]
            displacement = start.grids.displacement(
                touching_solution.on_grid(touching_solution.values), threads=solver_thread_count()
            )
            fine_tolerance = INDENTATION_TOLERANCE * float(np.ptp(displacement)) / gap_deviation
            contact_solution = search_balance(rigid_problem, load, None, min(tolerance, fine_tolerance))
        if contact_solution is None:
            raise NoSolutionError(f"no solution at {load:g} mN: the search for the tilt did not converge")
        return to_step_result(contact_solution)

    for load in loads.tolist():
        result = record.run_step(partial(solve_load, load), NoSolutionError)
        contact_solutions += from_step_result(problem, result)
    return contact_solutions


def find_rigid_tilt(problem: HalfSpaceProblem, total_pressure: float) -> Floats:
    """Return the slopes of the upper of two rigid surfaces at which contacts balance a load at the surface's centre.

    The load is the sum of the pressures at all points (GPa).

    Without a hardness, rigid surfaces then touch at three points (two points of profiles) around the centre. The slopes
    maximise the energy, a concave and piecewise linear function, by Kelley's cutting planes.
    """
    from scipy.optimize import linprog

    arms = [np.broadcast_to(arm / np.ptp(arm), problem.gap.shape).ravel() for arm in lever_arms(problem)]
    is_measured = problem.measured_point_mask.ravel() > 0
    gap_range = float(np.ptp(problem.gap.ravel()[is_measured])) or 1.0
    gap = np.where(is_measured, problem.gap.ravel() / gap_range, np.inf)
    max_fraction = 1.0 if problem.hardness is None else min(1.0, problem.hardness / total_pressure)
    num_points = int(np.ceil(1 / max_fraction))
    load_fractions = np.append(np.full(num_points - 1, max_fraction), 1 - (num_points - 1) * max_fraction)
    slope_bounds = [*((-gap.size, gap.size) for _ in arms), (None, None)]
    slopes, upper_bound = np.zeros(len(arms)), np.inf
    planes: list[list[float]] = []
    offsets: list[float] = []
    for _ in range(MAX_CUTTING_PLANES):
        tilted_gap = gap + sum(slope * arm for slope, arm in zip(slopes, arms, strict=True))
        lowest_points = np.argpartition(tilted_gap, num_points - 1)[:num_points]
        energy, moments = (
            float(load_fractions @ tilted_gap[lowest_points]),
            np.array([load_fractions @ arm[lowest_points] for arm in arms]),
        )
        if upper_bound - energy <= RIGID_TILT_TOLERANCE:
            break
        planes.append([*-moments, 1.0])
        offsets.append(energy - float(moments @ slopes))
        solution = linprog([*np.zeros(len(arms)), -1.0], A_ub=planes, b_ub=offsets, bounds=slope_bounds)
        # The optimum is recomputed as the intersection of the nearest cutting planes: `linprog` has a coarse tolerance.
        vertex, active_planes = solution.x, np.argsort(solution.slack)[: len(arms) + 1]
        if len(planes) > len(arms) and np.linalg.matrix_rank(np.array(planes)[active_planes]) == len(arms) + 1:
            vertex = np.linalg.solve(np.array(planes)[active_planes], np.array(offsets)[active_planes])
        slopes, upper_bound = vertex[:-1], vertex[-1]
    return np.asarray(slopes * gap_range / np.array([float(np.ptp(arm)) for arm in lever_arms(problem)]))
