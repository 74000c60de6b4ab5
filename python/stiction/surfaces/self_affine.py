"""Self-affine Gaussian profiles and surfaces, by Fourier synthesis."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np

from stiction._checks import check_bool, check_choice, number, read_only, whole_number
from stiction.surfaces.fractal import SIDE_KEY, random_phases
from stiction.surfaces.profile import MAX_POINTS, MIN_POINTS, Profile, Side
from stiction.surfaces.spectrum import ROUND_OFF_FACTOR
from stiction.surfaces.surface import Surface, parse_lengths, parse_shape

Amplitudes = Literal["rayleigh", "fixed"]


def self_affine(
    seed: int,
    *,
    hurst_exponent: float,
    rms: float,
    points: int,
    spacing: float,
    longest_wavelength: float | None = None,
    shortest_wavelength: float | None = None,
    periodic: bool = False,
    amplitudes: Amplitudes = "rayleigh",
    repetition: int = 0,
    side: Side = "lower",
) -> Profile:
    r"""Generate a self-affine Gaussian profile by Fourier synthesis.

    Its spectrum is C1D ∝ q^(-1-2H) between two wavelengths, flat beyond the longest (roll-off) and zero below the
    shortest (cut-off).

    Parameters
    ----------
    seed, repetition : int
    side : {"lower", "upper"}
        The random numbers are `random_phases` of these three. The wavelengths take them one after the other from the
        longest on, so a finer grid of the same extent and the same cut-off gives the same profile.
    hurst_exponent : float
        H, above 0 and at most 2; above 1 the profile is smooth, and the paper's D is below 1.5.
    rms : float, µm
        Root-mean-square height, above 0: that of the spectrum, which a profile has on average over random numbers and
        length. `Profile.with_amplitude` gives it to one profile exactly.
    points : int
    spacing : float, µm
    longest_wavelength : float, µm, optional
        The roll-off, above `shortest_wavelength`; by default the extent. In a periodic profile at most the extent.
    shortest_wavelength : float, µm, optional
        The cut-off, at least and by default twice the spacing. Harmonics at the Nyquist wave number itself are
        left out.
    periodic : bool
        Whether the profile shall end where it begins. If not, it is cut out of one with a period of at least twice its
        extent and four times the longest wavelength, as a measured profile is cut out of a surface.
    amplitudes : {"rayleigh", "fixed"}
        "rayleigh" draws the amplitude of each wavelength, as heights with a normal distribution have it: the spectrum
        of a profile scatters about the wanted one by its own size. "fixed" gives a periodic profile exactly the wanted
        spectrum and rms, whatever the random numbers, and only phases are random.

    Notes
    -----
    .. math:: z(x) = \sum_k a_k \cos(q_k x + φ_k), \qquad \langle a_k^2 \rangle \propto C(q_k)

    Examples
    --------
    >>> from stiction import roughness_parameters, self_affine
    >>> profile = self_affine(
    ...     1, hurst_exponent=0.8, rms=0.1, points=1000, spacing=0.01, periodic=True, amplitudes="fixed"
    ... )
    >>> round(roughness_parameters(profile).Pq, 12)
    0.1
    """
    check_choice("amplitudes", amplitudes, Amplitudes)
    check_bool("periodic", periodic)
    hurst, rms = _exponent_and_height(hurst_exponent, rms)
    points = whole_number("points", points, minimum=MIN_POINTS, maximum=MAX_POINTS)
    spacing = number("spacing", spacing, unit="µm", above=0)
    extent = points * spacing
    shortest = _shortest(shortest_wavelength, 2 * spacing, "spacing")
    longest = extent
    if longest_wavelength is not None:
        longest = number("longest_wavelength", longest_wavelength, unit="µm", above=shortest)
    if periodic and longest > extent * ROUND_OFF_FACTOR:
        raise ValueError(
            f"longest_wavelength of a periodic profile must be at most its extent, {extent:g} µm, "
            f"got {longest_wavelength!r}"
        )
    period = points
    while not periodic and (period < 2 * points or period * spacing * ROUND_OFF_FACTOR < 4 * longest):
        period *= 2
    if period > MAX_POINTS:
        raise ValueError(
            f"points and longest_wavelength need a period of {period} points, and at most {MAX_POINTS} are allowed"
        )
    harmonics = min((period - 1) // 2, int(period * spacing / shortest * ROUND_OFF_FACTOR))
    if harmonics < 1:
        raise ValueError(f"shortest_wavelength must be at most the extent, {extent:g} µm, got {shortest:g}")
    wave_number = 2 * math.pi / (period * spacing) * np.arange(1, harmonics + 1)
    power = np.maximum(wave_number * longest / (2 * math.pi), 1.0) ** (-1 - 2 * hurst)
    power /= power.sum()
    random = random_phases(seed, repetition=repetition, side=side, directions=harmonics, frequencies=2)
    if amplitudes == "rayleigh":
        power *= -np.log1p(-random[:, 1] / (2 * math.pi))
    transform = np.zeros(period // 2 + 1, dtype=np.complex128)
    transform[1 : harmonics + 1] = rms * period / 2 * np.sqrt(2 * power) * np.exp(1j * random[:, 0])
    return Profile(np.fft.irfft(transform, period)[:points], spacing=spacing)


def _exponent_and_height(hurst_exponent: Any, rms: Any) -> tuple[float, float]:
    hurst = number("hurst_exponent", hurst_exponent, above=0)
    if hurst > 2:
        raise ValueError(f"hurst_exponent must be above 0 and at most 2, got {hurst_exponent!r}")
    return hurst, number("rms", rms, unit="µm", above=0)


def _shortest(wavelength: Any, finest: float, of: str) -> float:
    """Return the shortest wavelength (µm), by default the finest of the grid: twice its spacing."""
    shortest = finest if wavelength is None else number("shortest_wavelength", wavelength, unit="µm", above=0)
    if shortest * ROUND_OFF_FACTOR < finest:
        raise ValueError(f"shortest_wavelength must be at least twice the {of}, {finest:g} µm, got {wavelength!r}")
    return shortest


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
    r"""Generate an isotropic, periodic, self-affine Gaussian surface by Fourier synthesis.

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
    from scipy.fft import irfft2

    hurst, rms = _exponent_and_height(hurst_exponent, rms)
    rows, columns = parse_shape(shape, least=4)
    along_y, along_x = parse_lengths("spacing", spacing)
    extent_y, extent_x = rows * along_y, columns * along_x
    longer = max(extent_y, extent_x)
    shortest = _shortest(shortest_wavelength, 2 * max(along_y, along_x), "larger spacing")
    longest = longer
    if longest_wavelength is not None:
        longest = number("longest_wavelength", longest_wavelength, unit="µm", above=shortest)
        if longest > longer * ROUND_OFF_FACTOR:
            raise ValueError(f"longest_wavelength must be at most the longer side, {longer:g} µm, got {longest!r}")
    check_choice("side", side, Side)
    seed = whole_number("seed", seed, minimum=0)
    repetition = whole_number("repetition", repetition, minimum=0)

    along = [
        min((size - 1) // 2, int(extent / shortest * ROUND_OFF_FACTOR))
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
        kept = q * shortest <= longest * ROUND_OFF_FACTOR
        if i == 0:
            kept &= j > 0  # the other half of these waves is their mirror image
        count = int(np.flatnonzero(kept)[-1]) + 1 if kept.any() else 0
        if count == 0:
            continue
        words = np.random.PCG64(np.random.SeedSequence([seed, repetition, SIDE_KEY[side], i])).random_raw(2 * count)
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
    heights = irfft2(transform, (rows, columns), overwrite_x=True)
    return Surface(read_only(heights), spacing=(along_y, along_x))
