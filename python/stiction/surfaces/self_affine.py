"""Profiles of a wanted character: self-affine ones by Fourier synthesis, and surrogates of a given one."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from stiction._checks import choice, number, truth, whole_number
from stiction.surfaces.fractal import random_phases
from stiction.surfaces.profile import FEWEST_POINTS, MOST_POINTS, Profile, Side
from stiction.surfaces.roughness import refuse_flat
from stiction.surfaces.spectrum import ROUND_UP

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
    r"""A self-affine Gaussian profile, by Fourier synthesis.

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

    Raises
    ------
    ValueError
        If an argument is outside its range.

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
    choice("amplitudes", amplitudes, Amplitudes)
    truth("periodic", periodic)
    hurst = number("hurst_exponent", hurst_exponent, above=0)
    if hurst > 2:
        raise ValueError(f"hurst_exponent must be above 0 and at most 2, got {hurst_exponent!r}")
    rms = number("rms", rms, unit="µm", above=0)
    points = whole_number("points", points, least=FEWEST_POINTS, most=MOST_POINTS)
    spacing = number("spacing", spacing, unit="µm", above=0)
    extent = points * spacing
    shortest = 2 * spacing
    if shortest_wavelength is not None:
        shortest = number("shortest_wavelength", shortest_wavelength, unit="µm", above=0)
        if shortest * ROUND_UP < 2 * spacing:
            raise ValueError(
                f"shortest_wavelength must be at least twice the spacing, {2 * spacing:g} µm, "
                f"got {shortest_wavelength!r}"
            )
    longest = extent
    if longest_wavelength is not None:
        longest = number("longest_wavelength", longest_wavelength, unit="µm", above=shortest)
    if periodic and longest > extent * ROUND_UP:
        raise ValueError(
            f"longest_wavelength of a periodic profile must be at most its extent, {extent:g} µm, "
            f"got {longest_wavelength!r}"
        )
    period = points
    while not periodic and (period < 2 * points or period * spacing * ROUND_UP < 4 * longest):
        period *= 2
    if period > MOST_POINTS:
        raise ValueError(
            f"points and longest_wavelength need a period of {period} points, and at most {MOST_POINTS} are allowed"
        )
    harmonics = min((period - 1) // 2, int(period * spacing / shortest * ROUND_UP))
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


def surrogate(
    profile: Profile, seed: int, *, repetition: int = 0, side: Side = "lower", periodic: bool = False
) -> Profile:
    """A profile with the spectrum of a given one and new phases, with the same mean and Pq.

    Many of them are an ensemble of surfaces of which one has been measured.

    Parameters
    ----------
    profile : Profile
        Levelled, unless it is periodic: a slope of the whole would become waves as long as the profile.
    seed, repetition : int
    side : {"lower", "upper"}
        The phases are `random_phases` of these three.
    periodic : bool
        Whether the given profile is; its spectrum is then kept to round-off.

    Returns
    -------
    Profile
        Of as many points; periodic in any case.

    Raises
    ------
    ValueError
        If the profile is flat, or a number is negative.

    Notes
    -----
    A profile that is not periodic is continued by its mirror image, without a jump, and the spectrum of the two is
    averaged to the wave numbers of one. A window instead would take most of the ends away, and the straight line
    between the ends, taken off, would take some of the height with it. At last the surrogate is scaled to the Pq of the
    given profile. The corners at the two ends of the image put a spectrum of 1/q⁴ on top, and each density is averaged
    with a half of its neighbours: there are no sharp lines in the spectrum of such a surrogate, and for H near 1.5 and
    above it has too many short wavelengths.

    Random phases keep the spectrum alone. The heights become normally distributed: a surrogate of a worn or
    plateau-honed profile has lost its skewness, and grooves and other features are spread over the whole length.
    Theiler et al., Physica D 58 (1992) 77.

    Examples
    --------
    >>> from stiction import roughness_parameters, self_affine, surrogate
    >>> measured = self_affine(1, hurst_exponent=0.8, rms=0.1, points=1000, spacing=0.01)
    >>> ensemble = [surrogate(measured, 2016, repetition=repetition) for repetition in range(10)]
    >>> round(roughness_parameters(ensemble[0]).Pq / roughness_parameters(measured).Pq, 12)
    1.0
    """
    truth("periodic", periodic)
    refuse_flat(profile)
    mean = profile.heights.mean()
    heights = profile.heights - mean
    points = heights.size
    if periodic:
        amplitude = np.abs(np.fft.rfft(heights))
    else:
        # The image continues the profile without a jump. Of its harmonics, twice as close, every second is one of
        # the profile's length; the others go in halves to both sides.
        image = np.abs(np.fft.rfft(np.concatenate([heights, heights[::-1]]))) ** 2 / 2
        image = np.append(image, image[-2])
        own = 2 * np.arange(points // 2 + 1)
        amplitude = np.sqrt(image[own] / 2 + image[np.abs(own - 1)] / 4 + image[own + 1] / 4)
    phases = random_phases(seed, repetition=repetition, side=side, directions=points // 2, frequencies=1)[:, 0]
    transform = np.zeros(points // 2 + 1, dtype=np.complex128)
    transform[1:] = amplitude[1:] * np.exp(1j * phases)
    if points % 2 == 0:
        transform[-1] = math.copysign(amplitude[-1], math.cos(phases[-1]))
    made = np.fft.irfft(transform, points)
    made *= math.sqrt(np.mean(heights**2) / np.mean(made**2))
    return Profile(made + mean, spacing=profile.spacing)
