"""Self-affine surfaces: isotropic Gaussian roughness by Fourier synthesis over an area."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats, choice, number, read_only, whole_number
from stiction.surfaces.fractal import _SIDE_KEY
from stiction.surfaces.profile import MOST_POINTS, Side
from stiction.surfaces.surface import Surface, lengths

_ROUND_UP = 1 + 1e-9
"""For a ratio of two lengths that shall count as a whole number although it is not quite one."""


def self_affine_surface(
    seed: int,
    *,
    hurst_exponent: float,
    rms: float,
    shape: tuple[int, int],
    spacing: float | tuple[float, float],
    longest_wavelength: float | None = None,
    shortest_wavelength: float | None = None,
    repetition: int = 0,
    side: Side = "lower",
) -> Surface:
    r"""A self-affine Gaussian surface, isotropic and periodic, by Fourier synthesis.

    Its spectrum is C2D ∝ q^(-2-2H) between two wavelengths, flat beyond the longest (roll-off) and zero below the
    shortest (cut-off).

    Parameters
    ----------
    seed, repetition : int
        At least 0.
    side : {"lower", "upper"}
        The random numbers follow from these three and from the numbers of waves along x and y alone, so a finer grid
        of the same extent and the same wavelengths samples the same surface.
    hurst_exponent : float
        H, above 0 and at most 2.
    rms : float, µm
        Root-mean-square height Sq, above 0; the surface has it exactly, and a mean of zero.
    shape : (int, int)
        Rows (along y) and columns (along x), at least 4 each.
    spacing : float or (float, float), µm
        Distances between neighbouring rows and between neighbouring columns; one number for both.
    longest_wavelength : float, µm, optional
        The roll-off, above `shortest_wavelength` and at most the longer side, which is the default.
    shortest_wavelength : float, µm, optional
        The cut-off, at least and by default twice the larger spacing. Waves at a Nyquist wave number are left out.

    Raises
    ------
    ValueError
        If an argument is outside its range, or no wave lies between the wavelengths.

    Notes
    -----
    .. math:: z(x, y) = \sum_{i,j} a_{ij} \cos(2πi x/L_x + 2πj y/L_y + φ_{ij}),
              \qquad \langle a_{ij}^2 \rangle \propto C_{2D}(q_{ij})

    over half of the plane of wave vectors; a² is distributed exponentially, as heights with a normal distribution
    have it, and all are scaled together to the wanted rms. The waves (i, 0), (i, 1), (i, -1), (i, 2) and so on take
    the 64-bit words of ``PCG64(SeedSequence([seed, repetition, side, i]))`` two by two, as `random_phases` makes
    phases of words: the first is φ, the second gives the amplitude.

    Examples
    --------
    >>> from stiction import self_affine_surface
    >>> surface = self_affine_surface(1, hurst_exponent=0.8, rms=0.1, shape=(64, 64), spacing=0.05)
    >>> round(float(surface.heights.std()), 12)
    0.1
    """
    hurst = number("hurst_exponent", hurst_exponent, above=0)
    if hurst > 2:
        raise ValueError(f"hurst_exponent must be above 0 and at most 2, got {hurst_exponent!r}")
    rms = number("rms", rms, unit="µm", above=0)
    if not isinstance(shape, (tuple, list)) or len(shape) != 2:
        raise ValueError(f"shape must be (rows, columns), got {shape!r}")
    rows, columns = (whole_number("shape", size, least=4, most=MOST_POINTS) for size in shape)
    if rows * columns > MOST_POINTS:
        raise ValueError(f"shape must hold at most {MOST_POINTS} points, got {shape!r}")
    along_y, along_x = lengths("spacing", spacing)
    extent_y, extent_x = rows * along_y, columns * along_x
    longer = max(extent_y, extent_x)
    finest = 2 * max(along_y, along_x)
    shortest = finest
    if shortest_wavelength is not None:
        shortest = number("shortest_wavelength", shortest_wavelength, unit="µm", above=0)
        if shortest * _ROUND_UP < finest:
            raise ValueError(
                f"shortest_wavelength must be at least twice the larger spacing, {finest:g} µm, "
                f"got {shortest_wavelength!r}"
            )
    longest = longer
    if longest_wavelength is not None:
        longest = number("longest_wavelength", longest_wavelength, unit="µm", above=shortest)
        if longest > longer * _ROUND_UP:
            raise ValueError(f"longest_wavelength must be at most the longer side, {longer:g} µm, got {longest!r}")
    choice("side", side, Side)
    seed = whole_number("seed", seed, least=0)
    repetition = whole_number("repetition", repetition, least=0)

    along = [
        min((size - 1) // 2, int(extent / shortest * _ROUND_UP))
        for size, extent in ((columns, extent_x), (rows, extent_y))
    ]
    # j = 0, 1, -1, 2, -2 and so on: the order in which words are taken, whatever the grid.
    order = np.arange(1, 2 * along[1] + 2)
    j = np.where(order % 2 == 0, order // 2, -(order // 2))
    transform = np.zeros((rows, columns // 2 + 1), dtype=np.complex128)
    power = 0.0
    for i in range(along[0] + 1):
        # In wave numbers of the longest wavelength.
        q = longest * np.hypot(i / extent_x, j / extent_y)
        kept = q * shortest <= longest * _ROUND_UP
        if i == 0:
            kept &= j > 0  # the other half of these waves is their mirror image
        count = int(np.flatnonzero(kept)[-1]) + 1 if kept.any() else 0
        if count == 0:
            continue
        words = np.random.PCG64(np.random.SeedSequence([seed, repetition, _SIDE_KEY[side], i])).random_raw(2 * count)
        uniform = (words >> np.uint64(11)).astype(np.float64).reshape(count, 2) / 2**53
        kept = kept[:count]
        phase, draw = uniform[kept].T
        waves = j[:count][kept]
        square = np.maximum(q[:count][kept], 1.0) ** (-2 - 2 * hurst) * -np.log1p(-draw)
        power += float(square.sum()) / 2
        wave = np.sqrt(square) * np.exp(2j * math.pi * phase)
        transform[waves, i] = wave
        if i == 0:
            transform[-waves, i] = wave.conj()
    if not power > 0:
        raise ValueError(f"shortest_wavelength must be at most the longer side, {longer:g} µm, got {shortest:g}")
    transform *= rms / math.sqrt(power) * rows * columns / 2
    return Surface(read_only(_inverse(transform, (rows, columns))), spacing=(along_y, along_x))


def _inverse(transform: NDArray[np.complex128], shape: tuple[int, int]) -> Floats:
    from scipy.fft import irfft2

    return np.asarray(irfft2(transform, shape, overwrite_x=True), dtype=np.float64)
