"""Reference for contact and friction of two maps: plain NumPy on scipy splines, slow and formula by formula."""

from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.interpolate import NdBSpline, make_interp_spline
from scipy.optimize import brentq
from scipy.special import ellipe, ellipkm1


class Spline:
    """Tensor product of natural cubic splines; x along columns, y along rows, both in µm."""

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


def minima(heights, spacing):
    """Return the positions (n, 2) of local minima of the spline of a map: Newton's method from 16 starts per cell."""
    return _minima(heights.tobytes(), heights.shape, tuple(spacing))


@lru_cache(maxsize=8)
def _minima(values, shape, spacing):
    heights = np.frombuffer(values).reshape(shape)
    spline = Spline(heights, spacing)
    rows, columns = heights.shape
    step = np.array([spacing[1], spacing[0]])
    most = step * [columns - 1, rows - 1]
    fractions = (np.arange(4) + 0.5) / 4
    y, x = np.meshgrid(
        (np.arange(rows - 1)[:, None] + fractions).ravel(), (np.arange(columns - 1)[:, None] + fractions).ravel(),
        indexing="ij",
    )  # fmt: skip
    at = np.column_stack([x.ravel(), y.ravel()]) * step
    start = at.copy()
    for _ in range(40):
        gradient = spline.gradient(*at.T)
        hessian = spline.hessian(*at.T)
        determinant = hessian[0, 0] * hessian[1, 1] - hessian[0, 1] ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            move = (
                np.array([
                    hessian[1, 1] * gradient[0] - hessian[0, 1] * gradient[1],
                    hessian[0, 0] * gradient[1] - hessian[0, 1] * gradient[0],
                ])
                / determinant
            ).T  # fmt: skip
        at = at - move
        # Another start is nearer to a minimum found farther away.
        near = (np.abs(at - start) < 1.5 * step).all(axis=1) & (at > 0).all(axis=1) & (at < most).all(axis=1)
        at, start, move = at[near], start[near], move[near]
        if at.size == 0 or np.abs(move / step).max() < 1e-13:
            break
    hessian = spline.hessian(*at.T)
    lowest = (hessian[0, 0] > 0) & (hessian[0, 0] * hessian[1, 1] > hessian[0, 1] ** 2)
    settled = (np.abs(move) < 1e-9 * step).all(axis=1)
    at = at[lowest & settled]
    order = np.lexsort(np.round(at / step * 1e6).T)
    at = at[order]
    different = np.ones(len(at), dtype=bool)
    different[1:] = (np.abs(np.diff(at, axis=0)) > 2e-6 * step).any(axis=1)
    return at[different]


def ellipse(longer, shorter):
    """Return k = b/a and K(sqrt(1 - k²)) for two radii of relative curvature (Johnson, section 4.2)."""

    def integrals(k):
        return ellipkm1(k**2), ellipe(1 - k**2)

    def ratio(k):
        first, second = integrals(k)
        return k**2 * (first - second) / (second - k**2 * first)

    if longer / shorter < 1 + 1e-5:
        k = (shorter / longer) ** (2 / 3)  # within 1e-11, where the integrals cancel
    else:
        k = brentq(lambda k: ratio(k) - shorter / longer, 1e-9, 1 - 1e-7, xtol=1e-16, rtol=1e-14)
    return k, integrals(k)[0]


def semi_axes(longer, shorter, overlap):
    """Return the semi-axes of the ellipse, and K."""
    k, first = ellipse(longer, shorter)
    second = ellipe(1 - k**2)
    if k > 1 - 1e-6:
        a = np.sqrt(overlap * longer * (1 + (1 - k) / 4))
    else:
        a = np.sqrt(2 * overlap * longer * (first - second) / (first * (1 - k**2)))
    return a, k * a, first


def inside(place, along, across, extent):
    """Return the fractions of Hertz's force and area on the map, by rays from the centre to the edge or the rim.

    The ellipse is place + r (cos θ along + sin θ across), r <= 1, with semi-axes `along` and `across`.
    """

    def reach(theta):
        """Return the distance at which each ray leaves the map or the ellipse."""
        ray = np.cos(theta)[:, None] * along + np.sin(theta)[:, None] * across
        with np.errstate(divide="ignore"):
            leaves = np.where(ray > 0, (extent - place) / ray, np.where(ray < 0, -place / ray, np.inf))
        return np.minimum(1, leaves.min(axis=1))

    # Rays to the corners, and to intersections of edge and rim.
    bends = [-np.pi, np.pi]
    axes = np.column_stack([along, across])
    for x in (0, extent[0]):
        for y in (0, extent[1]):
            c, s = np.linalg.solve(axes, np.array([x, y]) - place)
            bends.append(np.arctan2(s, c))
    for k in (0, 1):
        size = np.hypot(along[k], across[k])
        for distance in (-place[k], extent[k] - place[k]):
            if abs(distance) < size:
                middle, half = np.arctan2(across[k], along[k]), np.arccos(distance / size)
                bends += [np.angle(np.exp(1j * (middle + sign * half))) for sign in (-1, 1)]
    bends = np.sort(bends)
    nodes, weights = np.polynomial.legendre.leggauss(100)
    force = area = 0.0
    for begin, end in pairwise(bends):
        r = reach(0.5 * (begin + end) + 0.5 * (end - begin) * nodes)
        area += 0.5 * (end - begin) * (weights @ r**2) / 2
        force += 0.5 * (end - begin) * (weights @ (1 - (1 - r**2) ** 1.5)) / 3
    return force / (2 * np.pi / 3), area / np.pi


def contacts(upper, lower, spacing, approach, *, effective_modulus=10.0, convex=False):
    """Return a dict for each contact of two maps."""
    gap = upper - lower
    zero = gap.min()
    of_gap, of_lower, of_upper = Spline(gap, spacing), Spline(lower, spacing), Spline(upper, spacing)
    extent = (np.array(gap.shape) - 1)[::-1] * np.array(spacing)[::-1]
    values = []
    for x, y in minima(gap, spacing):
        height = float(of_gap([x], [y])[0]) - zero
        if height >= approach:
            continue
        if convex:
            bodies = (of_upper.hessian([x], [y])[..., 0], -of_lower.hessian([x], [y])[..., 0])
            if min(np.linalg.eigvalsh(body).min() for body in bodies) <= 0:
                continue
        p = of_lower.gradient([x], [y])[:, 0]
        q = np.sqrt(1 + p @ p)
        normal = np.array([-p[0], -p[1], 1]) / q
        # Directions of the tangent plane whose curvature is stationary, in its metric I + p pᵀ.
        metric = np.eye(2) + np.outer(p, p)
        root = np.linalg.inv(np.linalg.cholesky(metric))
        curvature, vectors = np.linalg.eigh(root @ (of_gap.hessian([x], [y])[..., 0] / q) @ root.T)
        directions = (root.T @ vectors).T  # rows, lower curvature first
        longer, shorter = 1 / curvature
        overlap = (approach - height) / q
        a, b, first = semi_axes(longer, shorter, overlap)
        reach = np.sqrt((a * directions[0]) ** 2 + (b * directions[1]) ** 2)
        leaves = (np.array([x, y]) < reach).any() or (np.array([x, y]) + reach > extent).any()
        ellipse_of = np.array([x, y]), a * directions[0], b * directions[1]
        of_force, of_area = inside(*ellipse_of, extent) if leaves else (1.0, 1.0)
        values.append({
            "x": x, "y": y, "z": float(of_lower([x], [y])[0]), "normal": normal, "radii": (longer, shorter),
            "axes": (a * np.sqrt(of_area), b * np.sqrt(of_area)), "along": directions[0],
            "overlap": overlap, "leaves": leaves,
            "force": of_force * 2 / 3 * np.pi * a * overlap * effective_modulus / first,
            "area": of_area * np.pi * a * b,
        })  # fmt: skip
    return values


def sums(found, angle, sliding="opposing"):
    """Return the sums of contacts for a motion of the upper body at an angle in degrees from +x towards +y."""
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
    for one in found:
        n, force, area = one["normal"], one["force"], one["area"]
        total["contact_count"] += 1
        total["contact_area"] += area
        total["normal_elastic"] += force * n[2]
        total["load_at_edge"] += force * n[2] * one["leaves"]
        if sliding == "opposing" and not s @ n < 0:
            continue
        t = -s + (s @ n) * n
        t /= np.linalg.norm(t)
        for part, size in (("frictional", force), ("adhesive", area)):
            total[f"normal_{part}"] += size * t[2]
            total[f"tangential_{part}"] -= size * (s @ t)
            total[f"lateral_{part}"] -= size * (across @ t)
        total["tangential_elastic"] -= force * (s @ n)
        total["lateral_elastic"] -= force * (across @ n)
    return total
