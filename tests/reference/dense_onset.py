"""Reference for the onset of sliding: bounded tangential tractions by dense matrices and an active set.

The traction q has 0 <= q <= bound and a given sum. The displacement K q is constant where 0 < q < bound, at least as
large where q = 0, and at most as large where q = bound.
"""

import numpy as np

SLIP_ROUND_OFF = 1e-13


def solve_traction(compliance, bound, total):
    """Return the bounded traction with the sum `total`, and the displacement of the points that stick."""
    is_zero, is_slipping = np.zeros(bound.size, bool), np.zeros(bound.size, bool)
    visited_states = set()
    for _ in range(10 * bound.size):
        is_sticking = ~(is_zero | is_slipping)
        q = np.where(is_slipping, bound, 0.0)
        count = int(is_sticking.sum())
        system = np.zeros((count + 1, count + 1))
        system[:-1, :-1] = compliance[np.ix_(is_sticking, is_sticking)]
        system[:-1, -1], system[-1, :-1] = -1.0, 1.0
        right_hand_side = np.append(-(compliance @ q)[is_sticking], total - q.sum())
        solution = np.linalg.solve(system, right_hand_side)
        q[is_sticking], displacement = solution[:-1], solution[-1]
        displacements = compliance @ q
        displacement_tolerance, traction_tolerance = (
            SLIP_ROUND_OFF * np.abs(displacements).max(),
            SLIP_ROUND_OFF * bound.max(),
        )
        is_violated = (is_sticking & ((q < -traction_tolerance) | (q > bound + traction_tolerance))) | (
            is_slipping & (displacements > displacement + displacement_tolerance)
        )
        is_violated |= is_zero & (displacements < displacement - displacement_tolerance)
        if not is_violated.any():
            return np.clip(q, 0, bound), displacement
        # Change all violated points or, if the same active set occurred before, only the first one, so that the loop
        # ends (Murty).
        state = is_zero.tobytes() + is_slipping.tobytes()
        if state in visited_states:
            is_violated[np.flatnonzero(is_violated)[0] + 1 :] = False
        visited_states.add(state)
        is_freed = is_violated & ~is_sticking
        is_zero, is_slipping = is_zero & ~is_freed, is_slipping & ~is_freed
        is_zero |= is_violated & is_sticking & (q < 0)
        is_slipping |= is_violated & is_sticking & (q > 0)
    raise AssertionError("the active set does not converge")


def simulate_displacement_steps(compliance, bound, displacements):
    """Return the loads and the dissipated energies for a sequence of displacements, with slip in both directions.

    Each step minimises 1/2 q·Kq - q·(displacement - slip) with |q| <= bound by Gauss-Seidel iterations.
    """
    slip = np.zeros(bound.size)
    q = np.zeros(bound.size)
    loads, dissipation = [], []
    diagonal = np.diag(compliance)
    for displacement in displacements:
        elastic_displacements = compliance @ q
        for _ in range(100_000):
            change = 0.0
            for i in range(bound.size):
                new_traction = min(
                    max(q[i] + (displacement - slip[i] - elastic_displacements[i]) / diagonal[i], -bound[i]), bound[i]
                )
                if new_traction != q[i]:
                    elastic_displacements += compliance[:, i] * (new_traction - q[i])
                    change = max(change, abs(new_traction - q[i]))
                    q[i] = new_traction
            if change <= 1e-10 * bound.max():
                break
        new_slip = np.where(np.abs(q) < bound, slip, displacement - compliance @ q)
        dissipation.append(q @ (new_slip - slip))
        slip = new_slip
        loads.append(q.sum())
    return np.array(loads), np.array(dissipation)
