"""Reference for the asperity model of two maps: a slow implementation with NumPy and splines of SciPy."""

from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.interpolate import NdBSpline, make_interp_spline
from scipy.optimize import brentq
from scipy.special import ellipe, ellipkm1


class SplineSurface:
    """Natural cubic spline surface; x along columns and y along rows, both in µm."""

    def __init__(self, heights, spacing):
        y, x = (np.arange(size) * step for size, step in zip(heights.shape, spacing, strict=True))
        along_x = make_interp_spline(x, heights, k=3, bc_type="natural", axis=1)
        along_y = make_interp_spline(y, along_x.c.T, k=3, bc_type="natural", axis=0)
        self.spline = NdBSpline((along_y.t, along_x.t), np.ascontiguousarray(along_y.c), k=3)

    def __call__(self, x, y, along_x=0, along_y=0):
        return self.spline(np.column_stack([y, x]), nu=(along_y, along_x))

    def gradient(self, x, y):
        return np.array([self(x, y, 1, 0), self(x, y, 0, 1)])

    def hessian(self, x, y):
        xx, xy, yy = self(x, y, 2, 0), self(x, y, 1, 1), self(x, y, 0, 2)
        return np.array([[xx, xy], [xy, yy]])


def find_minima(heights, spacing):
    """Return the local minima (n, 2) of a splined map, found by Newton's method from 16 starting points per cell."""
    return _find_minima(heights.tobytes(), heights.shape, tuple(spacing))


@lru_cache(maxsize=8)
def _find_minima(values, shape, spacing):
    heights = np.frombuffer(values).reshape(shape)
    spline = SplineSurface(heights, spacing)
    rows, columns = heights.shape
    step = np.array([spacing[1], spacing[0]])
    extent = step * [columns - 1, rows - 1]
    fractions = (np.arange(4) + 0.5) / 4
    y, x = np.meshgrid(
        (np.arange(rows - 1)[:, None] + fractions).ravel(), (np.arange(columns - 1)[:, None] + fractions).ravel(),
        indexing="ij",
    )  # fmt: skip
    position = np.column_stack([x.ravel(), y.ravel()]) * step
    start = position.copy()
    for _ in range(40):
        gradient = spline.gradient(*position.T)
        hessian = spline.hessian(*position.T)
        determinant = hessian[0, 0] * hessian[1, 1] - hessian[0, 1] ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            newton_step = (
                np.array([
                    hessian[1, 1] * gradient[0] - hessian[0, 1] * gradient[1],
                    hessian[0, 0] * gradient[1] - hessian[0, 1] * gradient[0],
                ])
                / determinant
            ).T  # fmt: skip
        position = position - newton_step
        # Drop points that moved far away, because other starting points are nearer to their minima.
        is_near = (
            (np.abs(position - start) < 1.5 * step).all(axis=1)
            & (position > 0).all(axis=1)
            & (position < extent).all(axis=1)
        )
        position, start, newton_step = position[is_near], start[is_near], newton_step[is_near]
        if position.size == 0 or np.abs(newton_step / step).max() < 1e-13:
            break
    hessian = spline.hessian(*position.T)
    is_minimum = (hessian[0, 0] > 0) & (hessian[0, 0] * hessian[1, 1] > hessian[0, 1] ** 2)
    has_converged = (np.abs(newton_step) < 1e-9 * step).all(axis=1)
    position = position[is_minimum & has_converged]
    order = np.lexsort(np.round(position / step * 1e6).T)
    position = position[order]
    is_first = np.ones(len(position), dtype=bool)
    is_first[1:] = (np.abs(np.diff(position, axis=0)) > 2e-6 * step).any(axis=1)
    return position[is_first]


def solve_axis_ratio(longer_radius, shorter_radius):
    """Return the axis ratio k = b/a of a Hertzian contact ellipse and the integral K (Johnson, section 4.2)."""

    def elliptic_integrals(k):
        return ellipkm1(k**2), ellipe(1 - k**2)

    def radius_ratio(k):
        integral_k, integral_e = elliptic_integrals(k)
        return k**2 * (integral_k - integral_e) / (integral_e - k**2 * integral_k)

    if longer_radius / shorter_radius < 1 + 1e-5:
        # For nearly equal radii, the integrals lose digits by cancellation, but their limit is accurate to 1e-11.
        k = (shorter_radius / longer_radius) ** (2 / 3)
    else:
        k = brentq(lambda k: radius_ratio(k) - shorter_radius / longer_radius, 1e-9, 1 - 1e-7, xtol=1e-16, rtol=1e-14)
    return k, elliptic_integrals(k)[0]


def compute_semi_axes(longer_radius, shorter_radius, overlap):
    """Return the semi-axes of a Hertzian contact ellipse, and the complete elliptic integral K."""
    k, integral_k = solve_axis_ratio(longer_radius, shorter_radius)
    integral_e = ellipe(1 - k**2)
    if k > 1 - 1e-6:
        a = np.sqrt(overlap * longer_radius * (1 + (1 - k) / 4))
    else:
        a = np.sqrt(2 * overlap * longer_radius * (integral_k - integral_e) / (integral_k * (1 - k**2)))
    return a, k * a, integral_k


def ellipse_fractions_on_map(centre, along, across, extent):
    """Return the fractions of force and area of a contact ellipse that lie within the map.

    The ellipse is centre + r (cos θ along + sin θ across), r <= 1, with semi-axes `along` and `across`. The fractions
    are integrals over rays from the centre to the edge of the map or of the ellipse.
    """

    def ray_length(theta):
        """Return the distance at which each ray leaves the map or the ellipse."""
        ray = np.cos(theta)[:, None] * along + np.sin(theta)[:, None] * across
        with np.errstate(divide="ignore"):
            edge_distance = np.where(ray > 0, (extent - centre) / ray, np.where(ray < 0, -centre / ray, np.inf))
        return np.minimum(1, edge_distance.min(axis=1))

    # The ray length is smooth between the map corners and the intersections of ellipse and map edge.
    angles = [-np.pi, np.pi]
    axes = np.column_stack([along, across])
    for x in (0, extent[0]):
        for y in (0, extent[1]):
            c, s = np.linalg.solve(axes, np.array([x, y]) - centre)
            angles.append(np.arctan2(s, c))
    for k in (0, 1):
        size = np.hypot(along[k], across[k])
        for distance in (-centre[k], extent[k] - centre[k]):
            if abs(distance) < size:
                middle_angle, half_angle = np.arctan2(across[k], along[k]), np.arccos(distance / size)
                angles += [np.angle(np.exp(1j * (middle_angle + sign * half_angle))) for sign in (-1, 1)]
    angles = np.sort(angles)
    nodes, weights = np.polynomial.legendre.leggauss(100)
    force = area = 0.0
    for begin, end in pairwise(angles):
        r = ray_length(0.5 * (begin + end) + 0.5 * (end - begin) * nodes)
        area += 0.5 * (end - begin) * (weights @ r**2) / 2
        force += 0.5 * (end - begin) * (weights @ (1 - (1 - r**2) ** 1.5)) / 3
    return force / (2 * np.pi / 3), area / np.pi


def find_contacts(upper, lower, spacing, approach, *, effective_modulus=10.0, convex=False):
    """Return the contacts of two maps at an approach, each as a dict of its quantities."""
    gap = upper - lower
    lowest_gap = gap.min()
    gap_spline, lower_spline, upper_spline = (
        SplineSurface(gap, spacing),
        SplineSurface(lower, spacing),
        SplineSurface(upper, spacing),
    )
    extent = (np.array(gap.shape) - 1)[::-1] * np.array(spacing)[::-1]
    contact_list = []
    for x, y in find_minima(gap, spacing):
        height = float(gap_spline([x], [y])[0]) - lowest_gap
        if height >= approach:
            continue
        if convex:
            bodies = (upper_spline.hessian([x], [y])[..., 0], -lower_spline.hessian([x], [y])[..., 0])
            if min(np.linalg.eigvalsh(body).min() for body in bodies) <= 0:
                continue
        slope = lower_spline.gradient([x], [y])[:, 0]
        q = np.sqrt(1 + slope @ slope)
        normal = np.array([-slope[0], -slope[1], 1]) / q
        # Principal directions of the gap in the tangent plane, whose metric is I + slope slopeᵀ.
        metric = np.eye(2) + np.outer(slope, slope)
        root = np.linalg.inv(np.linalg.cholesky(metric))
        curvature, vectors = np.linalg.eigh(root @ (gap_spline.hessian([x], [y])[..., 0] / q) @ root.T)
        directions = (root.T @ vectors).T  # The rows are sorted by curvature, the lower curvature first.
        longer_radius, shorter_radius = 1 / curvature
        overlap = (approach - height) / q
        a, b, integral_k = compute_semi_axes(longer_radius, shorter_radius, overlap)
        half_extent = np.sqrt((a * directions[0]) ** 2 + (b * directions[1]) ** 2)
        crosses_edge = (np.array([x, y]) < half_extent).any() or (np.array([x, y]) + half_extent > extent).any()
        ellipse = np.array([x, y]), a * directions[0], b * directions[1]
        force_fraction, area_fraction = ellipse_fractions_on_map(*ellipse, extent) if crosses_edge else (1.0, 1.0)
        contact_list.append({
            "x": x, "y": y, "z": float(lower_spline([x], [y])[0]), "normal": normal,
            "radii": (longer_radius, shorter_radius),
            "axes": (a * np.sqrt(area_fraction), b * np.sqrt(area_fraction)), "along": directions[0],
            "overlap": overlap, "leaves": crosses_edge,
            "force": force_fraction * 2 / 3 * np.pi * a * overlap * effective_modulus / integral_k,
            "area": area_fraction * np.pi * a * b,
        })  # fmt: skip
    return contact_list


def sum_contacts(contact_list, angle, sliding="opposing"):
    """Return sums over contacts for a motion of the upper body. `angle` is in degrees from +x towards +y."""
    s = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0])
    across = np.array([-s[1], s[0], 0])
    total = dict.fromkeys(
        [
            *("contact_count", "contact_area", "load_at_edge", "normal_elastic", "normal_frictional"),
            *("normal_adhesive", "tangential_elastic", "tangential_frictional", "tangential_adhesive"),
            *("lateral_elastic", "lateral_frictional", "lateral_adhesive"),
        ],
        0.0,
    )
    for contact in contact_list:
        n, force, area = contact["normal"], contact["force"], contact["area"]
        total["contact_count"] += 1
        total["contact_area"] += area
        total["normal_elastic"] += force * n[2]
        total["load_at_edge"] += force * n[2] * contact["leaves"]
        if sliding == "opposing" and not s @ n < 0:
            continue
        t = -s + (s @ n) * n
        t /= np.linalg.norm(t)
        for component, size in (("frictional", force), ("adhesive", area)):
            total[f"normal_{component}"] += size * t[2]
            total[f"tangential_{component}"] -= size * (s @ t)
            total[f"lateral_{component}"] -= size * (across @ t)
        total["tangential_elastic"] -= force * (s @ n)
        total["lateral_elastic"] -= force * (across @ n)
    return total
