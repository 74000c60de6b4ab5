"""Plain NumPy and SciPy program for comparison: one pair at a time, all cosines of Eq. 1, and complete splines."""

import numpy as np
from scipy.interpolate import CubicSpline


def generate_profile(phases, dimension, *, extent, points, amplitude, gamma=1.5):
    """Return a profile that is computed by the double sum of Eq. 1, and scaled to a total height."""
    directions, frequencies = phases.shape
    x = np.arange(points) * (extent / points)
    heights = np.zeros(points)
    for n in range(frequencies):
        weight = np.log(gamma) * gamma ** (2 * n * (dimension - 2))
        for m in range(1, directions + 1):
            wave_number = 2 * np.pi * gamma**n * np.cos(np.pi * m / directions)
            heights += weight * (np.cos(phases[m - 1, n]) - np.cos(wave_number * x + phases[m - 1, n]))
    heights -= heights.mean()
    return heights * (amplitude / np.ptp(heights))


def press(upper, lower, spacing, approaches, modulus=10.0):
    """Return contact count, area and force sums at each approach: cell detection, convex curvature, motion along x."""
    knots = np.arange(upper.size)
    bodies = []
    for heights, sign in ((upper, -1.0), (lower, 1.0)):
        spline = CubicSpline(knots, heights, bc_type="natural")
        slope, curvature = spline(knots, 1) / spacing, spline(knots, 2) / spacing**2
        q = np.sqrt(1 + slope**2)
        with np.errstate(divide="ignore"):
            bodies.append((sign * np.column_stack([-slope, np.ones_like(q)]) / q[:, None], -sign * q**3 / curvature))
    (n_u, r_u), (n_l, r_l) = bodies
    gap = upper - lower
    gap -= gap.min()
    rows = []
    for approach in approaches:
        i = np.flatnonzero((gap <= approach) & (r_u > 0) & (r_l > 0) & np.isfinite(r_u) & np.isfinite(r_l))
        o_l = -r_l[i, None] * n_l[i]
        separation = np.column_stack([np.zeros(i.size), gap[i] - approach]) - r_u[i, None] * n_u[i] - o_l
        distance = np.hypot(separation[:, 0], separation[:, 1])
        n = separation / distance[:, None]
        centre = o_l[:, 0] + separation[:, 0] / 2 - (r_u[i] - r_l[i]) / 2 * n[:, 0]
        overlap = r_u[i] + r_l[i] - distance
        is_contact = (centre >= -spacing / 2) & (centre < spacing / 2) & (overlap > 0) & (n[:, 1] > 0)
        n, overlap = n[is_contact], overlap[is_contact]
        radius = 1 / (1 / r_u[i][is_contact] + 1 / r_l[i][is_contact])
        force = 4 / 3 * modulus * np.sqrt(radius) * overlap**1.5
        area = np.pi * radius * overlap
        is_opposing = n[:, 0] < 0
        rows.append(
            (
                len(n), area.sum(), (force * n[:, 1]).sum(), -(force * n[:, 0])[is_opposing].sum(),
                (force * n[:, 0])[is_opposing].sum(), (force * n[:, 1])[is_opposing].sum(),
                (area * n[:, 0])[is_opposing].sum(), (area * n[:, 1])[is_opposing].sum(),
            )
        )  # fmt: skip
    return np.array(rows).T
