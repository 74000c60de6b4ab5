"""Cutting off the short waves of a profile or a surface by the Gaussian filter of ISO 16610."""

from __future__ import annotations

import math

import numpy as np

from stiction._checks import Floats, number, truth
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectrum import ROUND_UP
from stiction.surfaces.surface import AnyBody, Surface

LONGEST = 1 / 3  # longest wavelength that can be cut off, as a fraction of the shortest side: longer waves are too few
_REACH = 1.6  # wavelengths to each side over which weights are summed; beyond, they are below 1e-15 of the largest
_FEWEST_WEIGHTS = 64  # weights to each side; for wavelengths of two or three points they fall slowly, here to 1e-5


def cut_off(body: AnyBody, wavelength: float, *, periodic: bool = False) -> AnyBody:
    r"""A profile or a surface without its short waves, as a coarser instrument would see it.

    Parameters
    ----------
    body : Profile or Surface
    wavelength : float, µm
        Of which half the amplitude is left: from two points (of the finer spacing) to a third of the shortest side.
    periodic : bool
        Whether the body ends where it begins. If not, a straight line or a plane that it contains stays as it is up to
        its ends.

    Returns
    -------
    Profile or Surface
        On the same grid; the step is added to its history.

    Notes
    -----
    The Gaussian filter of ISO 16610-21 and, along both axes one after the other, ISO 16610-61. A wave of length λ is
    left with

    .. math:: \exp[-\ln 2\,(λ_c/λ)^2]

    of its amplitude, half of it at the wavelength λ_c. Towards the ends, where a part of the weights
    :math:`\exp[-π (x/αλ_c)^2]`, :math:`α = (\ln 2/π)^{1/2}`, has no points, a straight line is fitted with those that
    have: the moments of zeroth and first order are retained, which ISO 16610-28 offers for end effects.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, cut_off
    >>> wave = Profile(np.cos(2 * np.pi * np.arange(200) / 20), spacing=0.1)  # of length 2 µm
    >>> round(float(cut_off(wave, 2.0, periodic=True).heights[0]), 6)
    0.5
    """
    truth("periodic", periodic)
    if not isinstance(body, (Profile, Surface)):
        raise ValueError(f"body must be a Profile or a Surface, got {type(body).__name__}")
    spacing = body.spacings
    sides = [points * step for points, step in zip(body.heights.shape, spacing, strict=True)]
    length = number("wavelength", wavelength, unit="µm", above=0)
    shortest, longest = 2 * min(spacing), LONGEST * min(sides)
    if not shortest <= length * ROUND_UP or not length <= longest * ROUND_UP:
        raise ValueError(
            f"wavelength must be from two points, {shortest:g} µm, to a third of the shortest side, {longest:g} µm, "
            f"got {wavelength!r}"
        )
    mean = body.heights.mean()
    heights = body.heights - mean
    for axis, each in enumerate(spacing):
        heights = _smoothed(heights, axis, length / each, periodic) if heights.shape[axis] > 1 else heights
    step = f"waves shorter than {length:g} µm cut off (Gaussian filter, 50 % at {length:g} µm)"
    return body.changed(heights + mean, step)  # type: ignore[return-value]


def transmission(wave_number: Floats, wavelength: float) -> Floats:
    """Fraction of the amplitude of waves (2π/λ, 1/µm) that `cut_off` at a wavelength (µm) leaves."""
    return np.asarray(np.exp(-math.log(2) * np.square(wave_number * wavelength / (2 * math.pi))))


def _smoothed(heights: Floats, axis: int, length: float, periodic: bool) -> Floats:
    """Heights smoothed along an axis; the wavelength in points."""
    from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

    points = heights.shape[axis]
    shape = [1] * heights.ndim
    shape[axis] = -1
    if periodic:
        factor = transmission(2 * math.pi * rfftfreq(points), length).reshape(shape)
        return np.asarray(irfft(rfft(heights, axis=axis) * factor, points, axis=axis))
    reach = min(points - 1, max(math.ceil(_REACH * length), _FEWEST_WEIGHTS))
    padded = next_fast_len(points + reach, real=True)
    # The weights whose transform is the transmission up to the Nyquist wave number.
    fine = next_fast_len(max(padded, 4 * reach + 2), real=True)
    weights = irfft(transmission(2 * math.pi * rfftfreq(fine), length), fine)[: reach + 1]
    offset = np.arange(reach + 1)

    def kernel(values: Floats, sign: float) -> Floats:
        """Transform of weights over offsets 0 to reach, continued to negative ones evenly or oddly."""
        line = np.zeros(padded)
        line[: reach + 1] = values
        line[padded - reach :] = sign * values[:0:-1]
        return np.asarray(rfft(line)).reshape(shape)

    even, odd = kernel(weights, 1.0), kernel(-offset * weights, -1.0)  # of 1 and of ξ = x' - x
    transform = rfft(heights, padded, axis=axis)
    whole = [slice(None)] * heights.ndim
    whole[axis] = slice(points)
    inside = tuple(whole)
    zeroth, first = (irfft(transform * each, padded, axis=axis)[inside] for each in (even, odd))
    there = np.zeros(padded)
    there[:points] = 1.0
    mask = rfft(there).reshape(shape)
    square = kernel(np.square(offset) * weights, 1.0)
    m0, m1, m2 = (irfft(mask * each, padded, axis=axis)[inside] for each in (even, odd, square))
    # The value at x of the line that fits best with these weights.
    return np.asarray((m2 * zeroth - m1 * first) / (m0 * m2 - m1**2))
