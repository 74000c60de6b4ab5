"""Reference for the onset of sliding: bounded tractions by dense matrices and an active set.

Find q with 0 <= q <= bound and a given sum, so that the displacement K q is constant where 0 < q < bound, not smaller
where q = 0, and not larger where q is at its bound.
"""

import numpy as np

SLIP_ROUND_OFF = 1e-13


def traction(compliance, bound, total):
    """Return the traction with a given sum, and the displacement of the sticking points."""
    least, most = np.zeros(bound.size, bool), np.zeros(bound.size, bool)
    recorded = set()
    for _ in range(10 * bound.size):
        sticks = ~(least | most)
        q = np.where(most, bound, 0.0)
        count = int(sticks.sum())
        system = np.zeros((count + 1, count + 1))
        system[:-1, :-1] = compliance[np.ix_(sticks, sticks)]
        system[:-1, -1], system[-1, :-1] = -1.0, 1.0
        right = np.append(-(compliance @ q)[sticks], total - q.sum())
        solved = np.linalg.solve(system, right)
        q[sticks], way = solved[:-1], solved[-1]
        moved = compliance @ q
        slack, room = SLIP_ROUND_OFF * np.abs(moved).max(), SLIP_ROUND_OFF * bound.max()
        wrong = (sticks & ((q < -room) | (q > bound + room))) | (most & (moved > way + slack))
        wrong |= least & (moved < way - slack)
        if not wrong.any():
            return np.clip(q, 0, bound), way
        # Exchange all points while the set is new; else only the first, which terminates (Murty).
        state = least.tobytes() + most.tobytes()
        if state in recorded:
            wrong[np.flatnonzero(wrong)[0] + 1 :] = False
        recorded.add(state)
        freed = wrong & ~sticks
        least, most = least & ~freed, most & ~freed
        least |= wrong & sticks & (q < 0)
        most |= wrong & sticks & (q > 0)
    raise AssertionError("the active set does not settle")


def stepped(compliance, bound, ways):
    """Return loads and dissipation for a sequence of displacements with slip in both directions.

    Each step minimises 1/2 q·Kq - q·(displacement - slip) with |q| <= bound, by sweeps over the points.
    """
    slip = np.zeros(bound.size)
    q = np.zeros(bound.size)
    loads, lost = [], []
    diagonal = np.diag(compliance)
    for way in ways:
        moved = compliance @ q
        for _ in range(100_000):
            change = 0.0
            for i in range(bound.size):
                new = min(max(q[i] + (way - slip[i] - moved[i]) / diagonal[i], -bound[i]), bound[i])
                if new != q[i]:
                    moved += compliance[:, i] * (new - q[i])
                    change = max(change, abs(new - q[i]))
                    q[i] = new
            if change <= 1e-10 * bound.max():
                break
        after = np.where(np.abs(q) < bound, slip, way - compliance @ q)
        lost.append(q @ (after - slip))
        slip = after
        loads.append(q.sum())
    return np.array(loads), np.array(lost)
