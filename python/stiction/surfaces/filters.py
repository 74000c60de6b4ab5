"""Gaussian filters of ISO 16610 for profiles and surfaces: linear and robust, with end-effect correction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any, Literal

import numpy as np

from stiction._checks import Floats, choice, number, truth
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectrum import ROUND_OFF_FACTOR
from stiction.surfaces.surface import AnyBody, Surface, as_body

FilterKind = Literal["S", "L"]
Powers = tuple[int, ...]
_REACH = (
    1.6  # cutoff wavelengths to each side over which weights are summed; beyond, they are below 1e-15 of the largest
)
_MIN_WEIGHTS = 64  # weights to each side; for cutoffs of two or three points they fall slowly, here to 1e-5
_MIN_COVERAGE = 1e-6  # weight of the points in reach, as a fraction of all, below which no mean line is estimated
_MIN_PIVOT = 1e-9  # pivot of the normalised local equations below which they do not fix a polynomial
_BIWEIGHT = 4.4478  # times the median absolute deviation: three standard deviations of normally distributed heights
_ROBUST_TOLERANCE = 1e-4  # largest change of the mean line over the biweight scale at which the iteration ends
_MAX_ITERATIONS = 200


def filtered(
    body: AnyBody, *, cutoff: float, kind: FilterKind = "S", robust: bool = False, periodic: bool = False
) -> AnyBody:
    r"""Apply an S-filter or an L-filter of ISO 16610 to a profile or a surface.

    Parameters
    ----------
    body : Profile or Surface
        Points that are missing have no weight. The filtered heights at these points are estimates from the others.
    cutoff : float, µm
        Nesting index: the wavelength of which the Gaussian filter transmits half the amplitude. From two points (of
        the finer spacing) to the shortest side.
    kind : {"S", "L"}
        "S" removes the small lateral scales and returns the mean line, such as the primary profile for λs or the
        waviness for λc. "L" removes the large lateral scales and returns the deviation from the mean line, such as the
        roughness profile for λc.
    robust : bool
        Estimate the mean line with Tukey's biweight, so that deep valleys, scratches and spikes do not pull it.
    periodic : bool
        Whether the body ends where it begins. Not available with `robust`.

    Returns
    -------
    Profile or Surface
        On the same grid; the step is added to its history.

    Raises
    ------
    ValueError
        If the cutoff is outside its range, or the robust iteration does not converge.

    Notes
    -----
    The linear filter is that of ISO 16610-21 and, along both axes, ISO 16610-61. A wave of length λ is left with

    .. math:: \exp[-\ln 2\,(λ_c/λ)^2] = \exp[-π (αλ_c/λ)^2], \qquad α = (\ln 2/π)^{1/2}

    of its amplitude. Towards the ends and beside missing points, where a part of the weights
    :math:`\exp[-π (x/αλ_c)^2]` has no points, a straight line (along both axes of a surface) is fitted with the
    remaining ones: the moments of zeroth and first order are retained, which ISO 16610-28 offers for end effects.

    The robust filter is the Gaussian regression filter of second degree of ISO 16610-31 and ISO 16610-71: the local
    polynomials are fitted with the Gaussian weights times :math:`[1 - (r/c)^2]^2` for residuals of magnitude r below c,
    where c is 4.4478 times the median of r, until no point of the mean line moves by more than 1e-4 c.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, filtered
    >>> wave = Profile(np.cos(2 * np.pi * np.arange(200) / 20), spacing=0.1)  # wavelength 2 µm
    >>> round(float(filtered(wave, cutoff=2.0, kind="L", periodic=True).heights[0]), 6)
    0.5
    """
    choice("kind", kind, FilterKind)
    truth("robust", robust)
    truth("periodic", periodic)
    body = as_body("body", body)
    if robust and periodic:
        raise ValueError("periodic must be False for a robust filter, got True")
    length = checked_cutoff("cutoff", cutoff, body, longest=1.0)
    smooth = robust_mean(body, length) if robust else gaussian_mean(body, length, periodic=periodic)
    words = f"{'robust Gaussian regression' if robust else 'Gaussian'}, {length:g} µm"
    if kind == "S":
        return body.changed(smooth, f"S-filter ({words})")  # type: ignore[return-value]
    return body.changed(body.heights - smooth, f"L-filter ({words})")  # type: ignore[return-value]


def checked_cutoff(name: str, value: Any, body: Profile | Surface, *, longest: float) -> float:
    """Return a cutoff (µm) from two points of the finer spacing to a fraction of the shortest side."""
    sides = [points * step for points, step in zip(body.heights.shape, body.spacings, strict=True)]
    length = number(name, value, unit="µm", above=0)
    low, high = 2 * min(body.spacings), longest * min(sides)
    if not low <= length * ROUND_OFF_FACTOR or not length <= high * ROUND_OFF_FACTOR:
        part = "the shortest side" if longest == 1 else "a third of the shortest side"
        raise ValueError(f"{name} must be from two points, {low:g} µm, to {part}, {high:g} µm, got {value!r}")
    return length


def transmission(wave_number: Floats, cutoff: float) -> Floats:
    """Return the fraction of the amplitude of waves (2π/λ, 1/µm) that the Gaussian filter of a cutoff (µm) leaves."""
    return np.asarray(np.exp(-math.log(2) * np.square(wave_number * cutoff / (2 * math.pi))))


def gaussian_mean(body: Profile | Surface, cutoff: float, *, periodic: bool = False) -> Floats:
    """Compute the mean line or mean surface of the linear Gaussian filter with a cutoff (µm)."""
    mean = body.heights.mean()
    heights = body.heights - mean
    lengths = [cutoff / step for step in body.spacings]
    measured = None if body.missing is None else (~body.missing).astype(np.float64)
    if periodic:
        smooth = _transmitted(heights if measured is None else heights * measured, lengths)
        if measured is not None:
            smooth = _covered(smooth, _transmitted(measured, lengths), heights)
    elif measured is not None:
        smooth = _regression(heights, measured, lengths, _linear(heights.ndim))
    else:
        smooth = heights
        for axis, length in enumerate(lengths):
            smooth = _regression_along(smooth, axis, length) if smooth.shape[axis] > 1 else smooth
    return np.asarray(smooth + mean)


def robust_mean(body: Profile | Surface, cutoff: float) -> Floats:
    """Compute the mean line or mean surface of the robust Gaussian regression filter with a cutoff (µm)."""
    mean = body.heights.mean()
    heights = body.heights - mean
    lengths = [cutoff / step for step in body.spacings]
    measured = np.ones(heights.shape) if body.missing is None else (~body.missing).astype(np.float64)
    weights, before = measured, heights
    for _ in range(_MAX_ITERATIONS):
        smooth = _regression(heights, weights, lengths, _quadratic(heights.ndim))
        residual = np.abs(heights - smooth)
        scale = _BIWEIGHT * float(np.median(residual[measured > 0]))
        if np.abs(smooth - before).max() <= _ROBUST_TOLERANCE * scale or scale == 0:
            return np.asarray(smooth + mean)
        weights, before = measured * np.square(np.maximum(1 - np.square(residual / scale), 0)), smooth
    raise ValueError(f"the robust filter did not converge in {_MAX_ITERATIONS} iterations: use the Gaussian filter")


# ---- Weighted sums --------------------------------------------------------------------------------------------------


def _transmitted(heights: Floats, lengths: Sequence[float]) -> Floats:
    """Smooth periodic heights by the transmission along each axis; cutoffs in points."""
    from scipy.fft import irfft, rfft, rfftfreq

    for axis, length in enumerate(lengths):
        points = heights.shape[axis]
        factor = _along(transmission(2 * math.pi * rfftfreq(points), length), axis, heights.ndim)
        heights = irfft(rfft(heights, axis=axis) * factor, points, axis=axis)
    return heights


def _covered(sums: Floats, weights: Floats, heights: Floats) -> Floats:
    """Divide sums by weights; heights where there is no weight."""
    enough = weights > _MIN_COVERAGE
    return np.where(enough, sums / np.where(enough, weights, 1), heights)


def _along(values: Any, axis: int, ndim: int) -> Any:
    """Return values along one axis, for broadcasting."""
    return np.reshape(values, [-1 if each == axis else 1 for each in range(ndim)])


def _linear(ndim: int) -> list[Powers]:
    """Return the powers of x, or of y and x, of a straight line along each axis."""
    return list(product(range(2), repeat=ndim))


def _quadratic(ndim: int) -> list[Powers]:
    """Return the powers of x, or of y and x, of a polynomial of second degree."""
    return [powers for powers in product(range(3), repeat=ndim) if sum(powers) <= 2]


class _Kernel:
    """Transforms of the Gaussian weights times powers of the offset, along an axis of so many points."""

    def __init__(self, points: int, length: float) -> None:
        from scipy.fft import irfft, next_fast_len, rfftfreq

        reach = min(points - 1, max(math.ceil(_REACH * length), _MIN_WEIGHTS))
        self.points = points
        self.padded: int = next_fast_len(points + reach, real=True)
        # The weights whose transform is the transmission up to the Nyquist wave number.
        fine = next_fast_len(max(self.padded, 4 * reach + 2), real=True)
        self._weights = irfft(transmission(2 * math.pi * rfftfreq(fine), length), fine)[: reach + 1]
        self._offset = np.arange(reach + 1) / length

    def line(self, power: int) -> Floats:
        """Weights times (x' - x)^power over the cutoff, cyclic, for convolution with heights at x'."""
        values = self._weights * self._offset**power
        line = np.zeros(self.padded)
        line[: values.size] = values if power % 2 == 0 else -values
        if values.size > 1:
            line[self.padded - values.size + 1 :] = values[:0:-1]
        return line


def _regression_along(heights: Floats, axis: int, length: float) -> Floats:
    """Compute the values at each point of the straight line that is fitted along an axis with Gaussian weights."""
    from scipy.fft import irfft, rfft

    kernel = _Kernel(heights.shape[axis], length)
    powers = [_along(rfft(kernel.line(power)), axis, heights.ndim) for power in range(3)]
    inside = tuple(slice(kernel.points) if each == axis else slice(None) for each in range(heights.ndim))
    transform = rfft(heights, kernel.padded, axis=axis)
    zeroth, first = (irfft(transform * each, kernel.padded, axis=axis)[inside] for each in powers[:2])
    mask = rfft(_along(np.ones(kernel.points), axis, heights.ndim), kernel.padded, axis=axis)
    m0, m1, m2 = (irfft(mask * each, kernel.padded, axis=axis)[inside] for each in powers)
    return np.asarray((m2 * zeroth - m1 * first) / (m0 * m2 - m1**2))


def _regression(heights: Floats, weights: Floats, lengths: Sequence[float], basis: Sequence[Powers]) -> Floats:
    """Compute the values at each point of local polynomials, fitted with Gaussian weights times those of the points."""
    from scipy.fft import irfftn, rfft, rfftn

    kernels = [_Kernel(*each) for each in zip(heights.shape, lengths, strict=True)]
    padded = [kernel.padded for kernel in kernels]
    inside = tuple(slice(points) for points in heights.shape)
    # Transforms along all axes but the last are complex and full; along the last they are half as long.
    lines = [
        [
            _along((np.fft.fft if axis < heights.ndim - 1 else rfft)(kernel.line(power)), axis, heights.ndim)
            for power in range(2 * max(map(max, basis)) + 1)
        ]
        for axis, kernel in enumerate(kernels)
    ]

    def sums(transform: Any, powers: Sequence[int]) -> Floats:
        for axis, power in enumerate(powers):
            transform = transform * lines[axis][power]
        return np.asarray(irfftn(transform, padded)[inside])

    of_weights, of_heights = rfftn(weights, padded), rfftn(weights * heights, padded)
    right = [sums(of_heights, powers) for powers in basis]
    pairs = {_added(one, other) for one in basis for other in basis}
    moments = {powers: sums(of_weights, powers) for powers in pairs}
    return _constants(basis, moments, right, heights)


def _added(one: Powers, other: Powers) -> Powers:
    """Return the powers of a product of two terms."""
    return tuple(a + b for a, b in zip(one, other, strict=True))


def _constants(basis: Sequence[Powers], moments: dict[Powers, Floats], right: list[Floats], heights: Floats) -> Floats:
    """Solve for the constant terms, the first of the basis, of all local polynomials by elimination of the others.

    Where the points do not fix the polynomial it is that of degree zero; where none is in reach the height is kept.
    """
    terms = range(len(basis))
    total = np.where(moments[basis[0]] > _MIN_COVERAGE, moments[basis[0]], 1)
    # Row k is that of term k; what is left of the rows after each elimination stays symmetric.
    rows = {(k, m): moments[_added(basis[k], basis[m])] / total for k in terms for m in range(k + 1)}
    values = [each / total for each in right]
    constant = values[0]
    fixed = moments[basis[0]] > _MIN_COVERAGE
    inside = fixed.copy()
    for last in reversed(terms[1:]):
        fixed &= rows[last, last] > _MIN_PIVOT
        pivot = np.where(fixed, rows[last, last], 1)
        for k in range(last):
            factor = rows[last, k] / pivot
            values[k] = values[k] - factor * values[last]
            for m in range(k + 1):
                rows[k, m] = rows[k, m] - factor * rows[last, m]
    fixed &= rows[0, 0] > _MIN_PIVOT
    solved = values[0] / np.where(fixed, rows[0, 0], 1)
    return np.where(fixed, solved, np.where(inside, constant, heights))
