"""Reference for the asperity model of two profiles: a slow implementation with natural splines of SciPy."""

from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline


def fit_spheres(heights, spacing, *, upper):
    """Return slope, curvature, normal (n, 2) and radius of curvature of a splined profile at each of its points."""
    spline = CubicSpline(np.arange(heights.size), heights, bc_type="natural")
    knots = np.arange(heights.size)
    slope = spline(knots, 1) / spacing
    curvature = spline(knots, 2) / spacing**2
    curvature[[0, -1]] = 0
    q = np.sqrt(1 + slope**2)
    normal = np.column_stack([-slope, np.ones_like(slope)]) / q[:, None]
    with np.errstate(divide="ignore"):
        radius = -(q**3) / curvature
    if upper:
        normal, radius = -normal, -radius
    radius[[0, -1]] = np.inf
    return slope, curvature, normal, radius


def find_contacts(upper, lower, spacing, approach, *, effective_modulus=10.0, signed=False):
    """Return the contacts at an approach as rows: index, n_x, n_z, overlap, effective radius, force, area."""
    gap = upper - lower
    gap = gap - gap.min()
    is_upper_flat, is_lower_flat = np.ptp(upper) == 0, np.ptp(lower) == 0
    _, _, n_u, r_u = fit_spheres(upper, spacing, upper=True)
    _, _, n_l, r_l = fit_spheres(lower, spacing, upper=False)
    rows = []
    for i in np.flatnonzero(gap <= approach):
        height_above_lower = gap[i] - approach
        if is_upper_flat or is_lower_flat:
            if is_upper_flat:
                sphere_radius, centre = r_l[i], -r_l[i] * n_l[i]
                if not np.isfinite(sphere_radius) or sphere_radius <= 0:
                    continue
                overlap = sphere_radius - (height_above_lower - centre[1])
                contact = centre + np.array([0, sphere_radius - overlap / 2])
            else:
                sphere_radius, centre = r_u[i], np.array([0, height_above_lower]) - r_u[i] * n_u[i]
                if not np.isfinite(sphere_radius) or sphere_radius <= 0:
                    continue
                overlap = sphere_radius - centre[1]
                contact = centre - np.array([0, sphere_radius - overlap / 2])
            n, radius = np.array([0.0, 1.0]), sphere_radius
        else:
            R_u, R_l = r_u[i], r_l[i]
            if not (np.isfinite(R_u) and np.isfinite(R_l)):
                continue
            inverse = 1 / R_u + 1 / R_l
            if inverse <= 0 or (not signed and (R_u <= 0 or R_l <= 0)):
                continue
            radius = 1 / inverse
            o_l = -R_l * n_l[i]
            o_u = np.array([0, height_above_lower]) - R_u * n_u[i]
            X = o_u - o_l
            distance = np.hypot(*X)
            n = np.sign(R_u * R_l) * X / distance
            overlap = R_u + R_l - distance if R_u > 0 and R_l > 0 else distance - abs(R_u + R_l)
            contact = o_l + X / 2 - (R_u - R_l) / 2 * n
        if not -spacing / 2 <= contact[0] < spacing / 2:
            continue
        if overlap <= 0 or n[1] <= 0:
            continue
        force = 4 / 3 * effective_modulus * np.sqrt(radius) * overlap**1.5
        rows.append((i, n[0], n[1], overlap, radius, force, np.pi * radius * overlap))
    return np.array(rows).reshape(-1, 7)


def sum_contacts(rows, sigma):
    """Return the sums over contacts that a `LoadCurve` contains, for one approach."""
    _, n_x, n_z, _, _, force, area = rows.T
    opposing = sigma * n_x < 0
    t_x, t_z = sigma * -n_z, sigma * n_x
    return {
        "contact_count": len(rows), "contact_area": area.sum(), "normal_elastic": (force * n_z).sum(),
        "tangential_elastic": -sigma * (force * n_x)[opposing].sum(),
        "normal_frictional": (force * t_z)[opposing].sum(),
        "tangential_frictional": -sigma * (force * t_x)[opposing].sum(),
        "normal_adhesive": (area * t_z)[opposing].sum(), "tangential_adhesive": -sigma * (area * t_x)[opposing].sum(),
    }  # fmt: skip


def sum_loads(rows, sigma, mu0, tau0):
    """Return F_N and F_T, summed over the contacts for given mu0 and tau0 (Eqs. 6 and 7 of the paper)."""
    normal = tangential = 0.0
    for _, n_x, n_z, _, _, force, area in rows:
        normal += force * n_z
        if sigma * n_x < 0:
            friction = mu0 * force + tau0 * area
            normal += friction * sigma * n_x
            tangential += -sigma * (force * n_x + friction * sigma * -n_z)
    return normal, tangential


@lru_cache(maxsize=1)
def _find_gap_minima(upper, lower):
    """Return splines of both profiles, positions of gap minima, and their heights above first contact."""
    upper, lower = np.frombuffer(upper), np.frombuffer(lower)
    x = np.arange(upper.size) * 1.0
    gap = CubicSpline(x, upper - lower, bc_type="natural")
    positions = gap.derivative().roots(extrapolate=False)
    positions = positions[(gap(positions, 2) > 0) & (positions > 0) & (positions < x[-1])]
    bodies = (CubicSpline(x, body, bc_type="natural") for body in (upper, lower))
    return *bodies, positions, gap(positions) - (upper - lower).min()


def find_contacts_at_minima(upper, lower, spacing, approach, *, effective_modulus=10.0, signed=False):
    """Return the contacts at the minima of the splined gap, as rows like those of `find_contacts`."""
    spline_u, spline_l, positions, heights = _find_gap_minima(upper.tobytes(), lower.tobytes())
    rows = []
    for position, height in zip(positions[heights <= approach], heights[heights <= approach], strict=True):
        slope = spline_l(position, 1) / spacing
        q = np.sqrt(1 + slope**2)
        with np.errstate(divide="ignore"):
            R_u = q**3 / (spline_u(position, 2) / spacing**2)
            R_l = -(q**3) / (spline_l(position, 2) / spacing**2)
        if np.ptp(upper) == 0 or np.ptp(lower) == 0:
            radius = R_l if np.ptp(upper) == 0 else R_u
            overlap = approach - height
            if radius > 0 and overlap > 0:
                force = 4 / 3 * effective_modulus * np.sqrt(radius) * overlap**1.5
                rows.append((int(position), 0.0, 1.0, overlap, radius, force, np.pi * radius * overlap))
            continue
        inverse = 1 / R_u + 1 / R_l
        if not np.isfinite([R_u, R_l]).all() or inverse <= 0 or (not signed and (R_u <= 0 or R_l <= 0)):
            continue
        n = np.array([-slope, 1]) / q
        X = (R_u + R_l) * n - (approach - height) * np.array([0, 1])
        distance = np.hypot(*X)
        n_c = np.sign(R_u * R_l) * X / distance
        overlap = R_u + R_l - distance if R_u > 0 and R_l > 0 else distance - abs(R_u + R_l)
        if overlap <= 0 or n_c[1] <= 0:
            continue
        radius = 1 / inverse
        force = 4 / 3 * effective_modulus * np.sqrt(radius) * overlap**1.5
        rows.append((int(position), n_c[0], n_c[1], overlap, radius, force, np.pi * radius * overlap))
    return np.array(rows).reshape(-1, 7)
