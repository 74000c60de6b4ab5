"""Reference for Eq. 1: the double sum over directions and frequencies, in extended precision."""

import numpy as np

EXTENDED = np.longdouble
PI = EXTENDED("3.14159265358979323846264338327950288")


def weierstrass_mandelbrot(phases, hurst_exponent, *, length_scale, gamma, extent, points, at=None, nyquist=False):
    """Return heights at the grid points `at` (default: all), long double; they equal the first row of a surface."""
    index = np.arange(points) if at is None else np.asarray(at)
    spacing = EXTENDED(extent / points)
    most = 0.5 / spacing if nyquist else np.inf
    return _sum(phases, hurst_exponent, length_scale, gamma, index.astype(EXTENDED) * spacing, 0, most, np.inf)


def weierstrass_mandelbrot_surface(phases, hurst_exponent, *, length_scale, gamma, extents, shape, at, nyquist=False):
    """Return heights at grid points `at` (k, 2) of (row, column), long double."""
    steps = [EXTENDED(extent / size) for extent, size in zip(extents, shape, strict=True)]
    y, x = (np.asarray(at)[:, k].astype(EXTENDED) * steps[k] for k in (0, 1))
    most_y, most_x = (0.5 / step if nyquist else np.inf for step in steps)
    return _sum(phases, hurst_exponent, length_scale, gamma, x, y, most_x, most_y)


def _sum(phases, hurst_exponent, length_scale, gamma, x, y, most_x, most_y):
    """Return the sum of all harmonics up to the largest number of turns per µm along x and y."""
    directions, frequencies = phases.shape
    gamma, length_scale, hurst = EXTENDED(gamma), EXTENDED(length_scale), EXTENDED(hurst_exponent)
    heights = np.zeros(x.shape, EXTENDED)
    for n in range(1, frequencies + 1):
        weight = length_scale**hurst * np.log(gamma) * gamma ** (-(n - 1) * hurst)
        for m in range(1, directions + 1):
            k = gamma ** (n - 1) / length_scale
            kx, ky = k * np.cos(PI * m / directions), k * np.sin(PI * m / directions)
            if abs(kx) > most_x or abs(ky) > most_y:
                continue
            phase = EXTENDED(phases[m - 1, n - 1])
            # Turns are wrapped before the cosine, because the argument reduction of x87 uses only 66 bits of pi.
            turns = kx * x + ky * y
            heights += weight * (np.cos(phase) - np.cos(2 * PI * (turns - np.rint(turns)) + phase))
    return heights
