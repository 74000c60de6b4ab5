"""Linear and robust Gaussian filters of ISO 16610 for profiles and height maps, corrected for end effects."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any, Literal

import numpy as np

from stiction._checks import Floats, check_bool, check_choice, validate_number
from stiction._errors import ArgumentError
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectrum import ROUND_OFF_FACTOR
from stiction.surfaces.surface import AnyBody, Surface, as_body

FilterKind = Literal["S", "L"]
MonomialExponents = tuple[int, ...]
# Shortest cutoff (points) of a filter: it transmits 96 % of the amplitude at the shortest wavelength, two points.
MIN_CUTOFF_POINTS = 0.5
_MIN_CUTOFF_POINTS_FOR_END_REGRESSION = 4.0
# Half width of the filter as a multiple of the cutoff. At larger distances, weights are below 1e-15 of the maximum.
_FILTER_HALF_WIDTH_IN_CUTOFFS = 1.6
# Minimum half width (points) of the filter. With cutoffs of two or three points, weights at 64 points are about 2e-5.
_MIN_HALF_WIDTH_POINTS = 64
_MIN_MEASURED_WEIGHT_FRACTION = 1e-6
_MIN_NORMALISED_PIVOT = 1e-9
# Scale of Tukey's biweight, in median absolute deviations: three standard deviations of normally distributed heights.
_BIWEIGHT_SCALE = 4.4478
_ROBUST_TOLERANCE_IN_BIWEIGHT_SCALES = 1e-4
_MAX_ROBUST_ITERATIONS = 200


def filtered(
    body: AnyBody, *, cutoff: float, kind: FilterKind = "S", robust: bool = False, periodic: bool = False
) -> AnyBody:
    r"""Apply an S-filter (low-pass) or an L-filter (high-pass) of ISO 16610 to a profile or a surface.

    Parameters
    ----------
    body : Profile or Surface
        Missing points have zero weight. Their filtered heights are estimated from the measured points.
    cutoff : float, µm
        Nesting index: the wavelength at which the Gaussian filter transmits half of the amplitude. It must be from half
        of the finer spacing, where the filter barely attenuates any wavelength, to the shortest side.
    kind : {"S", "L"}
        "S" removes the small lateral scales and returns the mean line, such as the primary profile for λs or the
        waviness for λc. "L" removes the large lateral scales and returns the deviation from the mean line, such as the
        roughness profile for λc.
    robust : bool
        True to estimate the mean line with Tukey's biweight, which limits the influence of deep valleys, scratches and
        spikes.
    periodic : bool
        True if the body is periodic. It must be False if `robust` is True.

    Returns
    -------
    result : Profile or Surface
        The filtered body on the same grid, with the step added to its history.

    Raises
    ------
    ValueError
        If the cutoff is outside its range, or the robust iteration does not converge.

    See Also
    --------
    cut_off : S-filter with a shorter call.
    levelled : Removal of tilt and form.

    Notes
    -----
    The linear filter is that of ISO 16610-21 and, along both axes, ISO 16610-61. At wavelength λ it transmits

    .. math:: \exp[-\ln 2\,(λ_c/λ)^2] = \exp[-π (αλ_c/λ)^2], \qquad α = (\ln 2/π)^{1/2}

    of the amplitude, at all wavelengths of the grid. `section_parameters` uses the sampled weighting function instead,
    which differs for cutoffs below ten points. Near the ends and near missing points, some of the weights
    :math:`\exp[-π (x/αλ_c)^2]` have no points. There a straight line (a bilinear function for a surface) is fitted with
    the remaining weights, which retains the moments of order zero and one, as ISO 16610-28 proposes. For
    cutoffs below four points, the heights are continued by reflection instead, and missing heights are interpolated.

    The robust filter is the Gaussian regression filter of second degree of ISO 16610-31 and ISO 16610-71: local
    polynomials are fitted with the Gaussian weights times :math:`[1 - (r/c)^2]^2` for residuals of magnitude r below c,
    where c is 4.4478 times the median of r. The iteration ends when no point of the mean line changes by more than 1e-4
    c.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, filtered
    >>> wave = Profile(np.cos(2 * np.pi * np.arange(200) / 20), spacing=0.1)  # wavelength 2 µm
    >>> round(float(filtered(wave, cutoff=2.0, kind="L", periodic=True).heights[0]), 6)
    0.5
    """
    check_choice("kind", kind, FilterKind)
    check_bool("robust", robust)
    check_bool("periodic", periodic)
    body = as_body("body", body)
    if robust and periodic:
        raise ValueError("periodic must be False for a robust filter, got True")
    cutoff_length = validate_cutoff("cutoff", cutoff, body, longest=1.0)
    mean_line = (
        robust_gaussian_low_pass(body, cutoff_length)
        if robust
        else gaussian_low_pass(body, cutoff_length, periodic=periodic)
    )
    description = f"{'robust Gaussian regression' if robust else 'Gaussian'}, {cutoff_length:g} µm"
    if kind == "S":
        return body.changed(mean_line, f"S-filter ({description})")  # type: ignore[return-value]
    return body.changed(body.heights - mean_line, f"L-filter ({description})")  # type: ignore[return-value]


def validate_cutoff(name: str, value: Any, body: Profile | Surface, *, longest: float) -> float:
    """Check that a cutoff (µm) is between half the grid spacing and `longest` times the body's shortest side.

    Returns the cutoff.
    """
    side_lengths = [points * step for points, step in zip(body.heights.shape, body.spacings, strict=True)]
    cutoff = validate_number(name, value, unit="µm", above=0)
    min_cutoff, max_cutoff = MIN_CUTOFF_POINTS * min(body.spacings), longest * min(side_lengths)
    if not min_cutoff <= cutoff * ROUND_OFF_FACTOR or not cutoff <= max_cutoff * ROUND_OFF_FACTOR:
        limit_text = "the shortest side" if longest == 1 else "a third of the shortest side"
        shown_value = repr(value) if isinstance(value, str) else f"{cutoff:g} µm"
        raise ArgumentError(
            f"{{{name}}} must be between {min_cutoff:g} µm (half the spacing) and {max_cutoff:g} µm ({limit_text}), "
            "got {got}",
            got=shown_value,
        )
    return cutoff


def gaussian_transmission(wave_number: Floats, cutoff: float) -> Floats:
    """Return the amplitude ratio (output to input) of a Gaussian low-pass filter at wave numbers (1/µm)."""
    return np.asarray(np.exp(-math.log(2) * np.square(wave_number * cutoff / (2 * math.pi))))


def gaussian_low_pass(
    body: Profile | Surface, cutoff: float, *, periodic: bool = False, samples_weights: bool = False
) -> Floats:
    """Return the heights (µm) of a body after a linear Gaussian low-pass filter: the mean line or mean surface.

    By default, the weights have the analytic transmission at all wavelengths of the grid. With `samples_weights`,
    the weights are the weighting function of ISO 16610-21 at the points, unless the cutoff is below four points or
    the body is periodic. The weights differ noticeably below ten points: analytic transmission makes ripples next to
    single-point spikes; sampled weights transmit more at the shortest wavelengths (0.125 instead of 0.0625 at four
    points).
    """
    mean = body.heights.mean()
    heights = body.heights - mean
    cutoffs_in_points = [cutoff / step for step in body.spacings]
    measured_weights = None if body.missing is None else (~body.missing).astype(np.float64)
    if periodic:
        mean_line = _filter_periodic(
            heights if measured_weights is None else heights * measured_weights, cutoffs_in_points
        )
        if measured_weights is not None:
            mean_line = _divide_by_weights(mean_line, _filter_periodic(measured_weights, cutoffs_in_points), heights)
    elif max(cutoffs_in_points) < _MIN_CUTOFF_POINTS_FOR_END_REGRESSION:
        mean_line = _filter_reflected(heights, cutoffs_in_points)
    elif measured_weights is not None:
        mean_line = _fit_local_polynomials(
            heights, measured_weights, cutoffs_in_points, _linear_exponents(heights.ndim), samples_weights
        )
    else:
        mean_line = heights
        for axis, cutoff_in_points in enumerate(cutoffs_in_points):
            if mean_line.shape[axis] > 1:
                mean_line = _fit_local_lines(mean_line, axis, cutoff_in_points, samples_weights)
    return np.asarray(mean_line + mean)


def robust_gaussian_low_pass(body: Profile | Surface, cutoff: float) -> Floats:
    """Return the heights (µm) of a body after a robust Gaussian low-pass filter: the mean line or mean surface."""
    mean = body.heights.mean()
    heights = body.heights - mean
    cutoffs_in_points = [cutoff / step for step in body.spacings]
    measured_weights = np.ones(heights.shape) if body.missing is None else (~body.missing).astype(np.float64)
    weights, previous_mean_line = measured_weights, heights
    for _ in range(_MAX_ROBUST_ITERATIONS):
        mean_line = _fit_local_polynomials(heights, weights, cutoffs_in_points, _quadratic_exponents(heights.ndim))
        residual = np.abs(heights - mean_line)
        biweight_scale = _BIWEIGHT_SCALE * float(np.median(residual[measured_weights > 0]))
        if (
            np.abs(mean_line - previous_mean_line).max() <= _ROBUST_TOLERANCE_IN_BIWEIGHT_SCALES * biweight_scale
            or biweight_scale == 0
        ):
            return np.asarray(mean_line + mean)
        weights, previous_mean_line = (
            measured_weights * np.square(np.maximum(1 - np.square(residual / biweight_scale), 0)),
            mean_line,
        )
    raise ValueError(
        f"the robust filter did not converge in {_MAX_ROBUST_ITERATIONS} iterations; use the Gaussian filter instead"
    )


# ---- Weighted sums --------------------------------------------------------------------------------------------------


def _filter_periodic(heights: Floats, cutoffs_in_points: Sequence[float]) -> Floats:
    """Apply a Gaussian low-pass filter to periodic heights.

    `cutoffs_in_points` contains the cutoff along each axis.
    """
    from scipy.fft import irfft, rfft, rfftfreq

    for axis, cutoff_in_points in enumerate(cutoffs_in_points):
        points = heights.shape[axis]
        transmission = _reshape_along_axis(
            gaussian_transmission(2 * math.pi * rfftfreq(points), cutoff_in_points), axis, heights.ndim
        )
        heights = irfft(rfft(heights, axis=axis) * transmission, points, axis=axis)
    return heights


def _filter_reflected(heights: Floats, cutoffs_in_points: Sequence[float]) -> Floats:
    """Apply a Gaussian low-pass filter to heights that are extended by reflection at the ends of the profile or map.

    A tilt is not changed.

    Reflection is used for short cutoffs (in points), whose weights oscillate. A straight line fitted with the weights
    on one side would then be unstable.
    """
    from scipy.fft import dctn, idctn

    tilt_plane = np.zeros_like(heights)
    transmission = np.ones_like(heights)
    for axis, cutoff_in_points in enumerate(cutoffs_in_points):
        points = heights.shape[axis]
        centred_index = np.arange(points) - (points - 1) / 2
        other_axes = tuple(other_axis for other_axis in range(heights.ndim) if other_axis != axis)
        slope = centred_index @ heights.mean(axis=other_axes) / max(float(centred_index @ centred_index), 1.0)
        tilt_plane = tilt_plane + slope * _reshape_along_axis(centred_index, axis, heights.ndim)
        transmission = transmission * _reshape_along_axis(
            gaussian_transmission(np.pi * np.arange(points) / points, cutoff_in_points), axis, heights.ndim
        )
    return np.asarray(tilt_plane + idctn(dctn(heights - tilt_plane, norm="ortho") * transmission, norm="ortho"))


def _divide_by_weights(sums: Floats, weights: Floats, heights: Floats) -> Floats:
    """Divide weighted sums of heights by sums of weights to obtain weighted mean heights.

    Where a sum of weights is too small, the height is kept.
    """
    is_covered = weights > _MIN_MEASURED_WEIGHT_FRACTION
    return np.where(is_covered, sums / np.where(is_covered, weights, 1), heights)


def _reshape_along_axis(values: Any, axis: int, ndim: int) -> Any:
    """Reshape a list of numbers to an array with `ndim` axes; the numbers vary along `axis` only."""
    return np.reshape(values, [-1 if index == axis else 1 for index in range(ndim)])


def _linear_exponents(ndim: int) -> list[MonomialExponents]:
    """Return the exponents of the polynomial terms 1 and x for profiles, and of 1, y, x and xy for maps."""
    return list(product(range(2), repeat=ndim))


def _quadratic_exponents(ndim: int) -> list[MonomialExponents]:
    """Return the exponents of all terms of a quadratic polynomial: in x for profiles, in x and y for maps."""
    return [powers for powers in product(range(3), repeat=ndim) if sum(powers) <= 2]


class _FilterKernel:
    """Gaussian filter weights along one axis, for convolution with heights by a fast Fourier transform."""

    def __init__(self, points: int, cutoff_in_points: float, samples_weights: bool = False) -> None:
        from scipy.fft import irfft, next_fast_len, rfftfreq

        half_width = min(
            points - 1, max(math.ceil(_FILTER_HALF_WIDTH_IN_CUTOFFS * cutoff_in_points), _MIN_HALF_WIDTH_POINTS)
        )
        self.points = points
        self.padded_size: int = next_fast_len(points + half_width, real=True)
        self._offset = np.arange(half_width + 1) / cutoff_in_points
        if samples_weights:
            self._weights = np.exp(-((math.pi * self._offset) ** 2) / math.log(2))
            self._weights /= 2 * self._weights.sum() - self._weights[0]
            return
        # The inverse transform of the analytic transmission gives weights that are exact up to the Nyquist wave number.
        transform_length = next_fast_len(max(self.padded_size, 4 * half_width + 2), real=True)
        self._weights = irfft(
            gaussian_transmission(2 * math.pi * rfftfreq(transform_length), cutoff_in_points), transform_length
        )[: half_width + 1]

    def compute_cyclic_weights(self, power: int) -> Floats:
        """Return filter weights times (distance / cutoff)^`power`, in the cyclic order for a Fourier transform."""
        half_weights = self._weights * self._offset**power
        weights = np.zeros(self.padded_size)
        weights[: half_weights.size] = half_weights if power % 2 == 0 else -half_weights
        if half_weights.size > 1:
            weights[self.padded_size - half_weights.size + 1 :] = half_weights[:0:-1]
        return weights


def _fit_local_lines(heights: Floats, axis: int, cutoff_in_points: float, samples_weights: bool) -> Floats:
    """Fit a line to the heights near each point along an axis, with Gaussian weights; return the fitted heights."""
    from scipy.fft import irfft, rfft

    kernel = _FilterKernel(heights.shape[axis], cutoff_in_points, samples_weights)
    kernel_transforms = [
        _reshape_along_axis(rfft(kernel.compute_cyclic_weights(power)), axis, heights.ndim) for power in range(3)
    ]
    unpadded_slices = tuple(slice(kernel.points) if index == axis else slice(None) for index in range(heights.ndim))
    transform = rfft(heights, kernel.padded_size, axis=axis)
    zeroth_moment, first_moment = (
        irfft(transform * power, kernel.padded_size, axis=axis)[unpadded_slices] for power in kernel_transforms[:2]
    )
    ones_transform = rfft(
        _reshape_along_axis(np.ones(kernel.points), axis, heights.ndim), kernel.padded_size, axis=axis
    )
    m0, m1, m2 = (
        irfft(ones_transform * power, kernel.padded_size, axis=axis)[unpadded_slices] for power in kernel_transforms
    )
    return np.asarray((m2 * zeroth_moment - m1 * first_moment) / (m0 * m2 - m1**2))


def _fit_local_polynomials(
    heights: Floats, weights: Floats, cutoffs_in_points: Sequence[float], basis: Sequence[MonomialExponents],
    samples_weights: bool = False,
) -> Floats:  # fmt: skip
    """Fit a weighted polynomial to the heights near each point; return the fitted heights at all points.

    The weights are Gaussian weights times `weights`.
    """
    from scipy.fft import irfftn, rfft, rfftn

    kernels = [
        _FilterKernel(*points_and_cutoff, samples_weights)
        for points_and_cutoff in zip(heights.shape, cutoffs_in_points, strict=True)
    ]
    padded_shape = [kernel.padded_size for kernel in kernels]
    unpadded_slices = tuple(slice(points) for points in heights.shape)
    kernel_transforms = [
        [
            _reshape_along_axis(
                (np.fft.fft if axis < heights.ndim - 1 else rfft)(kernel.compute_cyclic_weights(power)),
                axis,
                heights.ndim,
            )
            for power in range(2 * max(map(max, basis)) + 1)
        ]
        for axis, kernel in enumerate(kernels)
    ]

    def compute_weighted_sums(transform: Any, powers: Sequence[int]) -> Floats:
        for axis, power in enumerate(powers):
            transform = transform * kernel_transforms[axis][power]
        return np.asarray(irfftn(transform, padded_shape)[unpadded_slices])

    weights_transform, heights_transform = rfftn(weights, padded_shape), rfftn(weights * heights, padded_shape)
    right_sides = [compute_weighted_sums(heights_transform, powers) for powers in basis]
    product_exponents = {_multiply_monomials(a, b) for a in basis for b in basis}
    moments = {powers: compute_weighted_sums(weights_transform, powers) for powers in product_exponents}
    return _solve_constant_terms(basis, moments, right_sides, heights)


def _multiply_monomials(first_exponents: MonomialExponents, second_exponents: MonomialExponents) -> MonomialExponents:
    """Return the exponents of the product of two polynomial terms, given the exponents of both terms."""
    return tuple(a + b for a, b in zip(first_exponents, second_exponents, strict=True))


def _solve_constant_terms(
    basis: Sequence[MonomialExponents],
    moments: dict[MonomialExponents, Floats],
    right_sides: list[Floats],
    heights: Floats,
) -> Floats:
    """Solve the normal equations of each local polynomial by Gaussian elimination; return the constant coefficients.

    Where the equations are singular, the result is the weighted mean of the heights. Where no measured point is within
    reach, the result is the height of the point.
    """
    term_indices = range(len(basis))
    total_weight = np.where(moments[basis[0]] > _MIN_MEASURED_WEIGHT_FRACTION, moments[basis[0]], 1)
    # The normal equations remain symmetric during elimination, so only their lower triangle is stored.
    rows = {
        (k, m): moments[_multiply_monomials(basis[k], basis[m])] / total_weight
        for k in term_indices
        for m in range(k + 1)
    }
    reduced_right_sides = [right_side / total_weight for right_side in right_sides]
    constant_terms = reduced_right_sides[0]
    is_regular = moments[basis[0]] > _MIN_MEASURED_WEIGHT_FRACTION
    is_covered = is_regular.copy()
    for eliminated_term in reversed(term_indices[1:]):
        is_regular &= rows[eliminated_term, eliminated_term] > _MIN_NORMALISED_PIVOT
        pivot = np.where(is_regular, rows[eliminated_term, eliminated_term], 1)
        for k in range(eliminated_term):
            elimination_factor = rows[eliminated_term, k] / pivot
            reduced_right_sides[k] = reduced_right_sides[k] - elimination_factor * reduced_right_sides[eliminated_term]
            for m in range(k + 1):
                rows[k, m] = rows[k, m] - elimination_factor * rows[eliminated_term, m]
    is_regular &= rows[0, 0] > _MIN_NORMALISED_PIVOT
    solved_terms = reduced_right_sides[0] / np.where(is_regular, rows[0, 0], 1)
    return np.where(is_regular, solved_terms, np.where(is_covered, constant_terms, heights))
