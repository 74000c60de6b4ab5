"""Pressures of an elastic half-space by dense matrices and Lawson & Hanson's active set: slow and obvious."""

import numpy as np
import scipy.linalg
import scipy.optimize
from scipy.integrate import quad


def points(shape, spacing):
    """Coordinates of every point, one row each."""
    axes = [np.arange(n) * step for n, step in zip(shape, spacing, strict=True)]
    return np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)


def periodic_matrix(shape, spacing, modulus):
    """Displacement at each point under 1 GPa at each other: the sum over waves 2/(E*|k|) cos k(x - x')."""
    x = points(shape, spacing)
    waves = np.meshgrid(
        *[2 * np.pi * np.fft.fftfreq(n, step) for n, step in zip(shape, spacing, strict=True)], indexing="ij"
    )
    matrix = np.zeros((len(x), len(x)))
    for k in zip(*[wave.ravel() for wave in waves], strict=True):
        size = np.hypot(*k) if len(k) == 2 else abs(k[0])
        if size > 0:
            phase = x @ np.array(k)
            matrix += 2 / (modulus * size) * np.cos(phase[:, None] - phase) / len(x)
    return matrix


def free_matrix(shape, spacing, modulus):
    """The same for loaded cells of a free half-space: integrals of -2 ln r/(π E*) and 1/(π E* r) over the cell."""
    x = points(shape, spacing)
    values = {}

    def influence(distance):
        key = tuple(np.round(np.abs(distance) / spacing).astype(int))
        if key not in values:
            away = np.array(key) * spacing
            if len(spacing) == 1:
                a = spacing[0] / 2
                at = [0.0] if key == (0,) else None
                values[key] = quad(lambda s: -2 / np.pi / modulus * np.log(abs(away[0] - s)), -a, a, points=at)[0]
            else:
                b, a = spacing[0] / 2, spacing[1] / 2

                # Along x in closed form, along y by quadrature.
                def strip(s):
                    h = abs(away[0] - s)
                    return (np.arcsinh((away[1] + a) / h) - np.arcsinh((away[1] - a) / h)) / np.pi / modulus

                inside = [0.0] if key[0] == 0 else None
                values[key] = quad(strip, -b, b, points=inside, epsabs=0, epsrel=1e-12, limit=200)[0]
        return values[key]

    return np.array([[influence(one - other) for other in x] for one in x])


def displacement(pressure, spacing, modulus, *, periodic):
    """The same displacements (µm) of larger grids, in double precision: every wave, or every cell on a grid twice as
    large, of Love's logarithms."""
    shape = pressure.shape
    if periodic:
        waves = np.meshgrid(
            *[2 * np.pi * np.fft.fftfreq(n, step) for n, step in zip(shape, spacing, strict=True)], indexing="ij"
        )
        k = np.sqrt(sum(wave**2 for wave in waves))
        k.flat[0] = np.inf
        return np.fft.ifftn(np.fft.fftn(pressure) * 2 / (modulus * k)).real
    # Cells at distances from -n to n - 1 points; their corners half a point before.
    corners = [(np.arange(-n, n + 1) - 0.5) * step for n, step in zip(shape, spacing, strict=True)]
    if len(shape) == 1:
        (x,) = corners
        influence = -2 / (np.pi * modulus) * np.diff(x * (np.log(np.abs(x)) - 1))
    else:
        y, x = np.meshgrid(*corners, indexing="ij")
        r = np.hypot(x, y)
        # The integral of 1/r from the origin to a corner; of even distances, so that no logarithm meets 0.
        x, y, sign = np.abs(x), np.abs(y), np.sign(x) * np.sign(y)
        integral = sign * (x * np.log((y + r) / x) + y * np.log((x + r) / y))
        influence = np.diff(np.diff(integral, axis=0), axis=1) / (np.pi * modulus)
    for axis, n in enumerate(shape):
        influence = np.roll(influence, -n, axis)
    padded = np.pad(pressure, [(0, n) for n in shape])
    whole = np.fft.ifftn(np.fft.fftn(padded) * np.fft.fftn(influence)).real
    return whole[tuple(slice(n) for n in shape)]


def faults(pressure, gap, spacing, modulus, load, *, periodic, tolerance, hardness=np.inf):
    """What a pressure breaks of 0 <= p <= hardness, an open gap where p = 0, a closed one between and an overlap where
    p = hardness, in words; the unit is the deviation of heights, or of displacements under an even pressure."""
    u = displacement(pressure, spacing, modulus, periodic=periodic)
    even = (
        np.zeros(1) if periodic else displacement(np.full(gap.shape, pressure.mean()), spacing, modulus, periodic=False)
    )
    unit = max(gap.std(), even.std()) or max(spacing) / modulus * pressure.mean()
    potential = (u + gap) / unit
    between, capped = (pressure > 0) & (pressure < hardness), pressure >= hardness
    approach = potential[between].mean() if between.any() else potential[capped].max()
    found = potential - approach
    wrong = {
        "load": abs(pressure.sum() * np.prod(spacing) / load - 1), "suction": -min(pressure.min(), 0) / pressure.max(),
        "above the hardness": max(pressure.max() / hardness - 1, 0),
        "open under pressure": np.max(found[pressure > 0], initial=0), "overlap": np.max(-found[~capped], initial=0),
    }  # fmt: skip
    return [f"{name} {size:.1e}" for name, size in wrong.items() if not size <= tolerance]


def pressure(matrix, gap, approach, *, total=None, bound=np.inf):
    """Pressures (GPa) from 0 to a bound, for all points or each, at an approach: open gaps where there is no pressure,
    overlaps only where it is at its bound. With their `total`, constants need no stiffness."""
    lift = 0.0 if total is None else matrix.max()
    factor = scipy.linalg.cholesky(matrix + lift, lower=True)
    right = approach + lift * (total or 0.0) - gap.ravel()
    right = scipy.linalg.solve_triangular(factor, right, lower=True)
    if np.isinf(bound).all():
        return scipy.optimize.nnls(factor.T, right, maxiter=10_000)[0]
    # Stark & Parker's active set, which wants room between the bounds.
    most = np.broadcast_to(bound, gap.shape).ravel()
    bears = most > 0
    found = np.zeros(most.size)
    found[bears] = scipy.optimize.lsq_linear(
        factor.T[:, bears], right, (0, most[bears]), method="bvls", tol=1e-15, max_iter=10_000
    ).x
    return found
