"""Reference for the Weierstrass-Mandelbrot function (Eq. 1 of the paper): the double sum in extended precision."""

import numpy as np

EXTENDED_PRECISION = np.longdouble
PI = EXTENDED_PRECISION("3.14159265358979323846264338327950288")


def weierstrass_mandelbrot(phases, hurst_exponent, *, length_scale, gamma, extent, points, at=None, nyquist=False):
    """Return the heights of a profile in extended precision, at the grid points `at` (default: all)."""
    index = np.arange(points) if at is None else np.asarray(at)
    spacing = EXTENDED_PRECISION(extent / points)
    max_frequency = 0.5 / spacing if nyquist else np.inf
    return _sum_harmonics(
        phases,
        hurst_exponent,
        length_scale,
        gamma,
        index.astype(EXTENDED_PRECISION) * spacing,
        0,
        max_frequency,
        np.inf,
    )


def weierstrass_mandelbrot_surface(phases, hurst_exponent, *, length_scale, gamma, extents, shape, at, nyquist=False):
    """Return the heights of a surface in extended precision, at grid points `at` of shape (k, 2): row, column."""
    steps = [EXTENDED_PRECISION(extent / size) for extent, size in zip(extents, shape, strict=True)]
    y, x = (np.asarray(at)[:, k].astype(EXTENDED_PRECISION) * steps[k] for k in (0, 1))
    max_frequency_y, max_frequency_x = (0.5 / step if nyquist else np.inf for step in steps)
    return _sum_harmonics(phases, hurst_exponent, length_scale, gamma, x, y, max_frequency_x, max_frequency_y)


def _sum_harmonics(phases, hurst_exponent, length_scale, gamma, x, y, max_frequency_x, max_frequency_y):
    """Return the sum of all harmonics up to the largest spatial frequency (1/µm) along x and y."""
    directions, frequencies = phases.shape
    gamma, length_scale, hurst = (
        EXTENDED_PRECISION(gamma),
        EXTENDED_PRECISION(length_scale),
        EXTENDED_PRECISION(hurst_exponent),
    )
    heights = np.zeros(x.shape, EXTENDED_PRECISION)
    for n in range(1, frequencies + 1):
        weight = length_scale**hurst * np.log(gamma) * gamma ** (-(n - 1) * hurst)
        for m in range(1, directions + 1):
            k = gamma ** (n - 1) / length_scale
            kx, ky = k * np.cos(PI * m / directions), k * np.sin(PI * m / directions)
            if abs(kx) > max_frequency_x or abs(ky) > max_frequency_y:
                continue
            phase = EXTENDED_PRECISION(phases[m - 1, n - 1])
            # Subtract whole periods first: x87 reduces the argument of a cosine with only 66 bits of pi.
            phase_in_turns = kx * x + ky * y
            heights += weight * (np.cos(phase) - np.cos(2 * PI * (phase_in_turns - np.rint(phase_in_turns)) + phase))
    return heights
