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


def pressure(matrix, gap, approach, *, total=None):
    """Non-negative pressures (GPa) whose gap is nowhere negative; with their `total`, constants need no stiffness."""
    lift = 0.0 if total is None else matrix.max()
    factor = scipy.linalg.cholesky(matrix + lift, lower=True)
    right = approach + lift * (total or 0.0) - gap.ravel()
    return scipy.optimize.nnls(factor.T, scipy.linalg.solve_triangular(factor, right, lower=True), maxiter=10_000)[0]
