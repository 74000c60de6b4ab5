"""Reference for the half-space: dense influence matrices and active-set solvers."""

import numpy as np
import scipy.linalg
import scipy.optimize
from scipy.integrate import quad


def influence_table(shape, spacing, modulus, *, periodic):
    """Return the displacements (µm) of all grid points due to a pressure of 1 GPa on the cell at the origin.

    Periodic grids use the sum of 2/(E*|k|) cos k(x - x') over wavenumbers. Free grids integrate -2 ln r/(π E*)
    (profiles) or 1/(π E* r) (maps) over the cell.
    """
    index = np.meshgrid(*[np.arange(n) for n in shape], indexing="ij")
    if periodic:
        table = np.zeros(shape)
        for wave in np.ndindex(shape):
            signed_indices = [(m if 2 * m <= n else m - n) for m, n in zip(wave, shape, strict=True)]
            k = 2 * np.pi * np.array([m / (n * s) for m, n, s in zip(signed_indices, shape, spacing, strict=True)])
            if any(signed_indices):
                phase = 2 * np.pi * sum(m * i / n for m, i, n in zip(signed_indices, index, shape, strict=True))
                table += 2 / (modulus * np.sqrt(k @ k)) * np.cos(phase) / np.prod(shape)
        return table
    table = np.empty(shape)
    for offset in np.ndindex(shape):
        if len(shape) == 1:
            x, a = offset[0] * spacing[0], spacing[0] / 2
            singular_points = [0.0] if x == 0 else None
            table[offset] = quad(
                lambda s, x=x: -2 / np.pi / modulus * np.log(abs(x - s)), -a, a, points=singular_points
            )[0]
        else:
            (y, x), (b, a) = np.multiply(offset, spacing), np.divide(spacing, 2)

            # The integral of 1/(π E* r) along x has a closed form, and the integral along y is computed numerically.
            def strip_integral(s, x=x, y=y, a=a):
                return np.diff(np.arcsinh(np.array([x - a, x + a]) / abs(y - s)))[0] / np.pi / modulus

            singular_points = [0.0] if offset[0] == 0 else None
            table[offset] = quad(strip_integral, -b, b, points=singular_points, epsabs=0, epsrel=1e-12, limit=400)[0]
    return table


def influence_matrix(shape, spacing, modulus, *, periodic, points=None):
    """Return the matrix of displacements at points due to 1 GPa at each point. By default, it contains all points."""
    table = influence_table(shape, spacing, modulus, periodic=periodic)
    points = np.argwhere(np.ones(shape)) if points is None else points
    offsets = points[:, None, :] - points[None, :, :]
    offsets = offsets % np.array(shape) if periodic else np.abs(offsets)
    return table[tuple(np.moveaxis(offsets, -1, 0))]


def compute_displacement(pressure, spacing, modulus, *, periodic):
    """Return the displacements (µm) due to given pressures, by Fourier transforms.

    Free grids use the closed form of Love on a grid of twice the size.
    """
    shape = pressure.shape
    if periodic:
        waves = np.meshgrid(
            *[2 * np.pi * np.fft.fftfreq(n, step) for n, step in zip(shape, spacing, strict=True)], indexing="ij"
        )
        k = np.sqrt(sum(wave**2 for wave in waves))
        k.flat[0] = np.inf
        return np.fft.ifftn(np.fft.fftn(pressure) * 2 / (modulus * k)).real
    corners = [(np.arange(-n, n + 1) - 0.5) * step for n, step in zip(shape, spacing, strict=True)]
    if len(shape) == 1:
        (x,) = corners
        influence = -2 / (np.pi * modulus) * np.diff(x * (np.log(np.abs(x)) - 1))
    else:
        y, x = np.meshgrid(*corners, indexing="ij")
        r = np.hypot(x, y)
        x, y, sign = np.abs(x), np.abs(y), np.sign(x) * np.sign(y)
        integral = sign * (x * np.log((y + r) / x) + y * np.log((x + r) / y))
        influence = np.diff(np.diff(integral, axis=0), axis=1) / (np.pi * modulus)
    for axis, n in enumerate(shape):
        influence = np.roll(influence, -n, axis)
    padded_pressure = np.pad(pressure, [(0, n) for n in shape])
    padded_displacement = np.fft.ifftn(np.fft.fftn(padded_pressure) * np.fft.fftn(influence)).real
    return padded_displacement[tuple(slice(n) for n in shape)]


def find_violations(pressure, gap, spacing, modulus, load, *, periodic, tolerance, hardness=np.inf):
    """Return the violated contact conditions as texts; the list is empty if the pressure solves the problem.

    The conditions are 0 <= p <= hardness, an open gap where p = 0, a closed gap where 0 < p < hardness, and overlap
    only where p = hardness. Gaps are divided by the standard deviation of the heights, or of the displacements under
    uniform pressure.
    """
    displacements = compute_displacement(pressure, spacing, modulus, periodic=periodic)
    uniform_displacement = (
        np.zeros(1)
        if periodic
        else compute_displacement(np.full(gap.shape, pressure.mean()), spacing, modulus, periodic=False)
    )
    unit = max(gap.std(), uniform_displacement.std()) or max(spacing) / modulus * pressure.mean()
    potential = (displacements + gap) / unit
    is_elastic, is_plastic = (pressure > 0) & (pressure < hardness), pressure >= hardness
    approach = potential[is_elastic].mean() if is_elastic.any() else potential[is_plastic].max()
    gap_after_contact = potential - approach
    errors = {
        "load": abs(pressure.sum() * np.prod(spacing) / load - 1), "suction": -min(pressure.min(), 0) / pressure.max(),
        "above the hardness": max(pressure.max() / hardness - 1, 0),
        "open under pressure": np.max(gap_after_contact[pressure > 0], initial=0),
        "overlap": np.max(-gap_after_contact[~is_plastic], initial=0),
    }  # fmt: skip
    return [f"{name} {size:.1e}" for name, size in errors.items() if not size <= tolerance]


def solve_pressure(matrix, gap, approach, *, total=None, bound=np.inf):
    """Return the pressures (GPa), from 0 to `bound`, at an approach. Bodies may overlap only where p = bound.

    If `total` is given, the displacement may have an arbitrary constant.
    """
    matrix_shift = 0.0 if total is None else matrix.max()
    factor = scipy.linalg.cholesky(matrix + matrix_shift, lower=True)
    right_hand_side = approach + matrix_shift * (total or 0.0) - gap.ravel()
    right_hand_side = scipy.linalg.solve_triangular(factor, right_hand_side, lower=True)
    if np.isinf(bound).all():
        return scipy.optimize.nnls(factor.T, right_hand_side, maxiter=10_000)[0]
    # lsq_linear (active set of Stark & Parker) requires different lower and upper bounds.
    bounds = np.broadcast_to(bound, gap.shape).ravel()
    has_bound = bounds > 0
    result = np.zeros(bounds.size)
    result[has_bound] = scipy.optimize.lsq_linear(
        factor.T[:, has_bound], right_hand_side, (0, bounds[has_bound]), method="bvls", tol=1e-15, max_iter=10_000
    ).x
    return result
