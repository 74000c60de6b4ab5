"""Contact with free tilt: the upper surface rotates until the resultant force acts at the centre.

The solution minimises the energy at the given load. The slopes of the rotation are Lagrange multipliers of the moments,
which decrease as the slopes increase. This is a concave problem with two unknowns. It is solved by Newton steps with
the linear response of the contact points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stiction._checks import Floats
from stiction.mechanics.half_space_problem import (
    ContactSolution,
    ContactSolver,
    HalfSpaceProblem,
    TiltResponse,
    lever_arms,
    mean_moments,
    to_contact_solution,
)

# Maximum distance of the resultant force from the centre along an axis, as a fraction of the side length.
MAX_RELATIVE_FORCE_OFFSET = 1e-4
MAX_TILT_SOLVES_PER_LOAD = 60  # maximum number of times the contact problem is solved per load
# maximum displacement of the edge in one step, as a multiple of the standard deviation of the gap
MAX_EDGE_DISPLACEMENT_STEP = 0.5
# Smallest change of the moment per unit slope for which the tilt is defined.
# The change is divided by (mean pressure) · (side length)² / (standard deviation of the gap).
MIN_MOMENT_RESPONSE = 1e-6


def apply_tilt(problem: HalfSpaceProblem, slopes: Floats) -> HalfSpaceProblem:
    """Tilt the upper surface of a problem about its centre. `slopes` are along y and x, or along x for profiles."""
    plane = sum(slope * arm for slope, arm in zip(slopes, lever_arms(problem), strict=True))
    return replace(problem, upper=problem.upper + plane, gap=problem.gap + plane, tilt=problem.tilt + slopes)


def solve_with_balanced_tilt(
    problem: HalfSpaceProblem, loads: Floats, *, tolerance: float, progress: Callable[[int, int, float], object] | None
) -> list[ContactSolution]:
    """Find the tilt at which the resultant force acts at the centre. Return the contact at each load (mN)."""
    contact_solutions: list[ContactSolution] = []
    report = None if progress is None else lambda iteration, error: progress(len(contact_solutions), iteration, error)
    arms, shape = lever_arms(problem), problem.gap.shape
    side_lengths = np.array(shape) * np.array(problem.spacing)
    gap_deviation = float(problem.gap[problem.measured_point_mask > 0].std()) or 1.0

    def solve_contact_and_moments(
        rotated_problem: HalfSpaceProblem, load: float, near: Floats | None
    ) -> tuple[ContactSolution, Floats]:
        solver = ContactSolver(rotated_problem, "loads", load, tolerance=tolerance, report=report)
        solution = solver.at(load, near)
        contact_solution = to_contact_solution(rotated_problem, solution, load, scale=solver.scale)
        return contact_solution, mean_moments(solution.pressure.reshape(shape), arms)

    near = None
    for load in loads.tolist():
        mean_pressure = load / (problem.cell_area * problem.gap.size)
        contact_solution, moments = solve_contact_and_moments(problem, load, near)
        num_tried = 0
        while float(np.abs(moments / (mean_pressure * side_lengths)).max()) > MAX_RELATIVE_FORCE_OFFSET:
            near = contact_solution.on_grid(contact_solution.values).ravel()
            moments_per_slope = TiltResponse.solve(
                problem, contact_solution.on_grid(contact_solution.below_hardness)
            ).moments_per_slope
            slope_step = np.linalg.solve(
                np.diag(MIN_MOMENT_RESPONSE * mean_pressure * side_lengths**2 / gap_deviation) - moments_per_slope,
                moments,
            )
            slope_step *= min(
                1.0, MAX_EDGE_DISPLACEMENT_STEP * gap_deviation / float(np.abs(slope_step * side_lengths / 2).max())
            )
            # The energy is a concave function of the slopes.
            # A step beyond the maximum of the energy changes the sign of the moments.
            while num_tried < MAX_TILT_SOLVES_PER_LOAD:
                num_tried += 1
                candidate = solve_contact_and_moments(
                    apply_tilt(contact_solution.problem, np.asarray(slope_step, np.float64)), load, near
                )
                if float(candidate[1] @ slope_step) >= -MAX_EDGE_DISPLACEMENT_STEP * float(moments @ slope_step):
                    break
                slope_step = slope_step / 2
            else:
                raise RuntimeError(f"no solution at {load:g} mN: no tilt balances the surfaces")
            contact_solution, moments = candidate
        problem, near = contact_solution.problem, contact_solution.on_grid(contact_solution.values).ravel()
        contact_solutions.append(contact_solution)
    return contact_solutions
