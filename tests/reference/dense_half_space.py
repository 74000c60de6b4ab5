"""Reference for the half-space: dense matrices and the active set of Lawson & Hanson."""

import numpy as np
import scipy.linalg
import scipy.optimize
from scipy.integrate import quad


def influence(shape, spacing, modulus, *, periodic):
    """Return the displacements (µm) of a grid under 1 GPa on the cell at its origin.

    Periodic grids use the sum over wavenumbers of 2/(E*|k|) cos k(x - x'). Others use integrals over the cell of
    -2 ln r/(π E*) for profiles and 1/(π E* r) for maps.
    """
    index = np.meshgrid(*[np.arange(n) for n in shape], indexing="ij")
    if periodic:
        table = np.zeros(shape)
        for wave in np.ndindex(shape):
            turns = [(m if 2 * m <= n else m - n) for m, n in zip(wave, shape, strict=True)]
            k = 2 * np.pi * np.array([m / (n * s) for m, n, s in zip(turns, shape, spacing, strict=True)])
            if any(turns):
                phase = 2 * np.pi * sum(m * i / n for m, i, n in zip(turns, index, shape, strict=True))
                table += 2 / (modulus * np.sqrt(k @ k)) * np.cos(phase) / np.prod(shape)
        return table
    table = np.empty(shape)
    for place in np.ndindex(shape):
        if len(shape) == 1:
            x, a = place[0] * spacing[0], spacing[0] / 2
            inside = [0.0] if x == 0 else None
            table[place] = quad(lambda s, x=x: -2 / np.pi / modulus * np.log(abs(x - s)), -a, a, points=inside)[0]
        else:
            (y, x), (b, a) = np.multiply(place, spacing), np.divide(spacing, 2)

            # 1/(π E* r) along x in closed form, along y by quadrature.
            def strip(s, x=x, y=y, a=a):
                return np.diff(np.arcsinh(np.array([x - a, x + a]) / abs(y - s)))[0] / np.pi / modulus

            inside = [0.0] if place[0] == 0 else None
            table[place] = quad(strip, -b, b, points=inside, epsabs=0, epsrel=1e-12, limit=400)[0]
    return table


def matrix(shape, spacing, modulus, *, periodic, points=None):
    """Return the displacement at all points, or at points given by indices, under 1 GPa on each of them."""
    table = influence(shape, spacing, modulus, periodic=periodic)
    points = np.argwhere(np.ones(shape)) if points is None else points
    apart = points[:, None, :] - points[None, :, :]
    apart = apart % np.array(shape) if periodic else np.abs(apart)
    return table[tuple(np.moveaxis(apart, -1, 0))]


def displacement(pressure, spacing, modulus, *, periodic):
    """Return displacements (µm) of larger grids in double precision: by all wavenumbers, or by Love's logarithms on a
    grid of twice the size."""
    shape = pressure.shape
    if periodic:
        waves = np.meshgrid(
            *[2 * np.pi * np.fft.fftfreq(n, step) for n, step in zip(shape, spacing, strict=True)], indexing="ij"
        )
        k = np.sqrt(sum(wave**2 for wave in waves))
        k.flat[0] = np.inf
        return np.fft.ifftn(np.fft.fftn(pressure) * 2 / (modulus * k)).real
    # Cells at distances from -n to n - 1 points; corners are half a point before.
    corners = [(np.arange(-n, n + 1) - 0.5) * step for n, step in zip(shape, spacing, strict=True)]
    if len(shape) == 1:
        (x,) = corners
        influence = -2 / (np.pi * modulus) * np.diff(x * (np.log(np.abs(x)) - 1))
    else:
        y, x = np.meshgrid(*corners, indexing="ij")
        r = np.hypot(x, y)
        # Integral of 1/r from the origin to a corner, at even distances, so that no logarithm is of 0.
        x, y, sign = np.abs(x), np.abs(y), np.sign(x) * np.sign(y)
        integral = sign * (x * np.log((y + r) / x) + y * np.log((x + r) / y))
        influence = np.diff(np.diff(integral, axis=0), axis=1) / (np.pi * modulus)
    for axis, n in enumerate(shape):
        influence = np.roll(influence, -n, axis)
    padded = np.pad(pressure, [(0, n) for n in shape])
    whole = np.fft.ifftn(np.fft.fftn(padded) * np.fft.fftn(influence)).real
    return whole[tuple(slice(n) for n in shape)]


def faults(pressure, gap, spacing, modulus, load, *, periodic, tolerance, hardness=np.inf):
    """Return the violated conditions as text: 0 <= p <= hardness, open gap at p = 0, closed gap in between, overlap at
    p = hardness; the unit is the standard deviation of heights, or of displacements under uniform pressure."""
    u = displacement(pressure, spacing, modulus, periodic=periodic)
    even = (
        np.zeros(1) if periodic else displacement(np.full(gap.shape, pressure.mean()), spacing, modulus, periodic=False)
    )
    unit = max(gap.std(), even.std()) or max(spacing) / modulus * pressure.mean()
    potential = (u + gap) / unit
    between, capped = (pressure > 0) & (pressure < hardness), pressure >= hardness
    approach = potential[between].mean() if between.any() else potential[capped].max()
    result = potential - approach
    wrong = {
        "load": abs(pressure.sum() * np.prod(spacing) / load - 1), "suction": -min(pressure.min(), 0) / pressure.max(),
        "above the hardness": max(pressure.max() / hardness - 1, 0),
        "open under pressure": np.max(result[pressure > 0], initial=0), "overlap": np.max(-result[~capped], initial=0),
    }  # fmt: skip
    return [f"{name} {size:.1e}" for name, size in wrong.items() if not size <= tolerance]


def pressure(matrix, gap, approach, *, total=None, bound=np.inf):
    """Return pressures (GPa) at an approach, within 0 and bounds; bodies overlap only at the bound.

    If `total` is given, the displacement may have an arbitrary constant.
    """
    lift = 0.0 if total is None else matrix.max()
    factor = scipy.linalg.cholesky(matrix + lift, lower=True)
    right = approach + lift * (total or 0.0) - gap.ravel()
    right = scipy.linalg.solve_triangular(factor, right, lower=True)
    if np.isinf(bound).all():
        return scipy.optimize.nnls(factor.T, right, maxiter=10_000)[0]
    # Active set of Stark & Parker, which requires distinct bounds.
    most = np.broadcast_to(bound, gap.shape).ravel()
    bears = most > 0
    result = np.zeros(most.size)
    result[bears] = scipy.optimize.lsq_linear(
        factor.T[:, bears], right, (0, most[bears]), method="bvls", tol=1e-15, max_iter=10_000
    ).x
    return result
