"""Instrument noise, estimated from two scans of the same area without assumptions about the noise spectrum."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats, make_read_only
from stiction._drawing import draw_scan_comparison
from stiction._repr import PlotReprMixin, axes_or_new_axes
from stiction._units import short_repr
from stiction.surfaces.filters import gaussian_transmission
from stiction.surfaces.missing_data import with_interpolated_points
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile, reject_missing_points
from stiction.surfaces.scale import MAX_NEGLIGIBLE_NOISE_FRACTION, mean_square_height_spectrum, round_up_wavelength
from stiction.surfaces.surface import Surface, as_body

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# With a smaller height range (µm), powers of the heights would underflow.
MIN_HEIGHT_RANGE = 1e-70
MIN_CORRELATION = 0.5
_SMOOTHING_WIDTHS = (8.0, 4.0, 2.0, 1.0, 0.0)  # points
_NUM_STEPS_PER_SMOOTHING_WIDTH = 4
# After a Gaussian filter (standard deviation: one point), white noise has one independent value per this many points.
_POINTS_PER_INDEPENDENT_VALUE = 2 * math.sqrt(math.pi)
_OVERLAP_MARGIN_POINTS = 3
_NUM_TRIAL_CUTOFFS = 400
_INTEGER_SHIFT_TOLERANCE_POINTS = 1e-4


@dataclass(frozen=True, eq=False, repr=False)
class RepeatedScans(PlotReprMixin):
    """Comparison of two scans of the same area: their noise and their common roughness in each wavelength octave.

    Attributes
    ----------
    scan : Profile or Surface
        Mean of both scans in their overlap, levelled.
    shift : tuple of float, µm
        Position of the origin of the second scan in the first scan, along x, or along y and x.
    correlation : float
        Correlation of the aligned heights.
    wavelength : (n,) ndarray, µm
        Shortest wavelength of every octave, from two points upwards.
    noise, common : (n,) ndarray, µm
        Root-mean-square height per octave of the noise of one scan, and of the heights that both scans share.
    noise_rms : float, µm
        Root-mean-square noise of one scan over all wavelengths.
    limit : float, µm
        Shortest cutoff, from two points upwards, that reduces noise to a tenth of the mean square slope of `scan`. Two
        points also if `slope_fraction` is at most a tenth and the scan needs no filter; NaN if no cutoff up to a third
        of the shortest side suffices.
    slope_fraction : float
        Fraction of the mean square slope of `scan`, without a filter, that is noise.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, compare_repeated_scans, self_affine
    >>> place = self_affine(1, hurst_exponent=0.8, rms=0.1, points=4096, spacing=0.01, shortest_wavelength=0.2)
    >>> noise = 1e-3 * np.random.default_rng(1).normal(size=(2, 4096))
    >>> found = compare_repeated_scans(*(Profile(place.heights + each, spacing=0.01) for each in noise))
    >>> round(1000 * found.noise_rms, 1)  # nm
    1.0
    """

    scan: Profile | Surface
    shift: tuple[float, ...] = field(metadata={"unit": "µm"})
    correlation: float
    wavelength: Floats = field(metadata={"unit": "µm"})
    noise: Floats = field(metadata={"unit": "µm"})
    common: Floats = field(metadata={"unit": "µm"})
    noise_rms: float = field(metadata={"unit": "µm"})
    limit: float = field(metadata={"unit": "µm"})
    slope_fraction: float

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the noise of two scans, and the roughness that both scans share, against the wavelength.

        Draws into the given axes, or into new ones, and returns them.
        """
        return draw_scan_comparison(axes_or_new_axes(ax), self)


def compare_repeated_scans(
    first: Profile | Surface, second: Profile | Surface, *, outliers: Sequence[NDArray[np.bool_]] | None = None
) -> RepeatedScans:
    r"""Compare two scans of the same area, and estimate the noise of the instrument.

    Parameters
    ----------
    first, second : Profile or Surface
        Two profiles or two surfaces with equal spacings that overlap by more than half, without missing points.
    outliers : sequence of two ndarray of bool, optional
        Masks of points of the first and of the second scan that are interpolated before the alignment and the estimate,
        because outliers look like white noise. The mean of both scans contains their measured heights. By default,
        no points are interpolated.

    Returns
    -------
    comparison : RepeatedScans
        Mean of both scans, their shift (µm), and the noise and the common heights (µm) per octave of the wavelength.

    Raises
    ------
    ValueError
        If types or spacings differ, if points are missing, if the scans show different areas, if they are identical
        except at outliers, if a scan is flat except for outliers, if all its points are outliers, or if a mask does not
        have the shape of its scan.

    See Also
    --------
    instrument_limit : Noise from a single scan.

    Notes
    -----
    The second scan is aligned by a sub-pixel shift, an offset and a tilt that minimise the mean square difference. For
    scans s + n₁ and s + n₂ with independent noise of equal spectrum C_n, the difference has the spectrum 2 C_n and the
    mean C_s + C_n/2, which gives both spectra without a noise model. Reproducible errors, for example of the tip or the
    optics, are common to both scans and are not detected.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, compare_repeated_scans, self_affine
    >>> place = self_affine(1, hurst_exponent=0.8, rms=0.1, points=4096, spacing=0.01, shortest_wavelength=0.2)
    >>> drifted = Profile(place.heights[30:] + 0.5, spacing=0.01)
    >>> compare_repeated_scans(place, drifted).shift
    (0.3,)
    """
    _check_scans(first, second)
    bodies_without_outliers = _interpolate_outliers(first, second, outliers)
    body_class: Any = type(first)
    if _are_identical(first, second, outliers):
        raise ValueError(
            "the scans `first` and `second` must be different scans to estimate noise, got identical scans"
            f"{'' if outliers is None else ' (except at outliers)'}"
        )
    trend: Any = "line" if body_class is Profile else "plane"

    def resample(bodies: Sequence[Any], shift: Floats) -> list[Floats]:
        """Return the levelled heights of both scans in their overlap, at the points of the first scan."""
        heights, other_heights = (levelled(body, trend).heights for body in bodies)
        return [
            levelled(body_class(scan_heights, spacing=first.spacing), trend).heights
            for scan_heights in _resample_at_shift(heights, other_heights, shift)
        ]

    shift_in_points = _find_shift(*(levelled(body, trend).heights for body in bodies_without_outliers))
    spacing = np.atleast_1d(first.spacing)
    rounded_shift = np.round(shift_in_points) if _is_integer_shift(shift_in_points) else shift_in_points
    shift = tuple(round(float(item), 12) for item in rounded_shift * spacing)
    first_heights, second_heights = resample(bodies_without_outliers, shift_in_points)
    correlation = float(np.corrcoef(first_heights.ravel(), second_heights.ravel())[0, 1])
    if not correlation > MIN_CORRELATION:
        raise ValueError(
            f"the scans `first` and `second` must be scans of the same area, "
            f"got heights with a correlation of {correlation:.2f} after the best alignment"
        )
    history_entry = (
        f"mean of two scans of the same area, the second shifted by {', '.join(f'{item:.4g}' for item in shift)} µm"
    )

    def average(heights: Sequence[Floats]) -> Profile | Surface:
        """Average the heights of both scans in the area that they share, and return a levelled body."""
        mean_heights = (heights[0] + heights[1]) / 2
        scan: Profile | Surface = body_class(
            mean_heights, spacing=first.spacing, history=(*first.history, history_entry)
        )
        return levelled(scan, trend)

    mean_without_outliers = average((first_heights, second_heights))
    has_outliers = bodies_without_outliers != (first, second)
    scan = average(resample((first, second), shift_in_points)) if has_outliers else mean_without_outliers
    q, spectrum_of_mean_scan = mean_square_height_spectrum(mean_without_outliers)
    are_identical = np.array_equal(first_heights, second_heights)
    half_difference_spectrum = (
        np.zeros(q.size)
        if are_identical
        else mean_square_height_spectrum(
            levelled(body_class((first_heights - second_heights) / 2, spacing=first.spacing), trend)
        )[1]
    )
    shortest_wavelength = 2 * float(spacing.max())
    octave_indices = np.maximum(np.floor(np.log2(2 * math.pi / (q * shortest_wavelength)) + 1e-9), 0).astype(np.intp)
    noise, common_roughness = (
        np.sqrt(np.maximum(np.bincount(octave_indices, octave_contributions), 0))
        for octave_contributions in (2 * half_difference_spectrum, spectrum_of_mean_scan - half_difference_spectrum)
    )
    wavelength = make_read_only(np.asarray(shortest_wavelength * np.exp2(np.arange(noise.size)), np.float64))
    noise_rms, max_cutoff = (
        float(np.std(first_heights - second_heights) / math.sqrt(2)),
        float(np.min(scan.extent)) / 3,
    )
    slope_fraction = float(half_difference_spectrum @ q**2 / (spectrum_of_mean_scan @ q**2))
    cutoff = shortest_wavelength
    if slope_fraction > MAX_NEGLIGIBLE_NOISE_FRACTION:
        cutoff = _find_noise_cutoff(q, spectrum_of_mean_scan, half_difference_spectrum, shortest_wavelength, max_cutoff)
    return RepeatedScans(
        scan, shift, correlation, wavelength, make_read_only(noise), make_read_only(common_roughness), noise_rms,
        cutoff, slope_fraction,
    )  # fmt: skip


def _check_scans(first: Any, second: Any) -> None:
    for name, body in (("first", first), ("second", second)):
        as_body(name, body)
        reject_missing_points(body, "the comparison of two scans")
        if not np.ptp(body.heights) > MIN_HEIGHT_RANGE:
            raise ValueError(f"{name} must not be flat")
    if type(first) is not type(second) or not np.allclose(first.spacing, second.spacing, rtol=1e-6, atol=0):
        raise ValueError(
            "the scans `first` and `second` must be two profiles or two surfaces with equal spacings, "
            f"got a {type(first).__name__} with a spacing of {first.spacing} µm and "
            f"a {type(second).__name__} with a spacing of {second.spacing} µm"
        )


def _interpolate_outliers(
    first: Profile | Surface, second: Profile | Surface, outliers: Sequence[NDArray[np.bool_]] | None
) -> tuple[Profile | Surface, Profile | Surface]:
    """Interpolate the heights of outliers in both scans.

    Without `outliers`, return both scans unchanged.
    """
    if outliers is None:
        return first, second
    masks = [np.asarray(mask) for mask in outliers] if isinstance(outliers, (list, tuple, np.ndarray)) else []
    shapes = [first.heights.shape, second.heights.shape]
    if [mask.shape for mask in masks] != shapes or any(mask.dtype != bool for mask in masks):
        given_text = ", ".join(f"{mask.dtype} of shape {mask.shape}" for mask in masks) or short_repr(outliers)
        raise ValueError(
            f"outliers must be two boolean arrays with the shapes {shapes[0]} and {shapes[1]}, got {given_text}"
        )
    bodies = with_interpolated_points(first, masks[0]), with_interpolated_points(second, masks[1])
    for name, body, mask in zip(("first", "second"), bodies, masks, strict=True):
        if mask.all():
            raise ValueError(f"{name} must have points that are not outliers, got a mask of all points")
        if not np.ptp(body.heights) > MIN_HEIGHT_RANGE:
            raise ValueError(f"{name} must not be flat except for outliers")
    return bodies


def _are_identical(
    first: Profile | Surface, second: Profile | Surface, outliers: Sequence[NDArray[np.bool_]] | None
) -> bool:
    """Return whether two scans have equal heights at all points except outliers."""
    if first.heights.shape != second.heights.shape:
        return False
    is_outlier = np.zeros(first.heights.shape, np.bool_) if outliers is None else np.logical_or(*outliers)
    return np.array_equal(first.heights[~is_outlier], second.heights[~is_outlier])


def _find_noise_cutoff(
    q: Floats, spectrum_of_mean_scan: Floats, noise: Floats, shortest: float, longest: float
) -> float:
    """Return the shortest low-pass cutoff (µm) at which noise adds little to the mean square slope, or NaN.

    The remaining noise contributes at most the fraction `MAX_NEGLIGIBLE_NOISE_FRACTION` of the mean square slope.
    """
    cutoff: float
    for cutoff in np.geomspace(shortest, longest, _NUM_TRIAL_CUTOFFS).tolist():
        slope_weight = np.square(q * gaussian_transmission(q, cutoff))
        if noise @ slope_weight <= MAX_NEGLIGIBLE_NOISE_FRACTION * (spectrum_of_mean_scan @ slope_weight):
            return round_up_wavelength(cutoff)
    return math.nan


def _find_shift(a: Floats, b: Floats) -> Floats:
    """Estimate the shift (in points, possibly fractional) between the origins of two scans of the same area."""
    from scipy.ndimage import gaussian_filter, map_coordinates, spline_filter

    shift, best_shift = _find_integer_shift(a, b), (math.inf, np.zeros(a.ndim))
    for smoothing_width in _SMOOTHING_WIDTHS:
        smoothed_first, smoothed_second = (
            gaussian_filter(scan_heights, smoothing_width) if smoothing_width else scan_heights
            for scan_heights in (a, b)
        )
        smoothed_second = spline_filter(smoothed_second, 3)
        for _ in range(_NUM_STEPS_PER_SMOOTHING_WIDTH):
            overlap, positions = _slice_overlap(a.shape, b.shape, shift)
            second_heights = map_coordinates(
                smoothed_second, np.meshgrid(*positions, indexing="ij"), order=3, prefilter=False
            )
            slopes = _compute_slopes_along_axes(second_heights)
            basis = [*(-slope for slope in slopes), np.ones(second_heights.shape), *np.indices(second_heights.shape)]
            columns = np.stack([basis_function.ravel() for basis_function in basis], axis=1)
            correction, residual = np.linalg.lstsq(columns, (smoothed_first[overlap] - second_heights).ravel())[:2]
            shift = shift + np.clip(correction[: second_heights.ndim], -2 - smoothing_width, 2 + smoothing_width)
        # The Gaussian filter correlates the residual differences between both scans at neighbouring points.
        slope_covariances = [
            float((first_slope * slope).mean())
            for first_slope, slope in zip(_compute_slopes_along_axes(smoothed_first[overlap]), slopes, strict=True)
        ]
        shift_variance = sum(
            float(np.square(slope).mean()) / slope_covariance**2 if slope_covariance**2 > 0 else math.inf
            for slope, slope_covariance in zip(slopes, slope_covariances, strict=True)
        )
        shift_variance *= float(np.sum(residual)) * max(1.0, _POINTS_PER_INDEPENDENT_VALUE * smoothing_width) ** a.ndim
        best_shift = min(best_shift, (shift_variance, shift), key=lambda candidate: candidate[0])
    return best_shift[1]


def _is_integer_shift(shift: Floats) -> bool:
    """Return whether a shift is a whole number of points along each axis, within a tolerance."""
    return bool(np.abs(shift - np.round(shift)).max() < _INTEGER_SHIFT_TOLERANCE_POINTS)


def _resample_at_shift(a: Floats, b: Floats, shift: Floats) -> tuple[Floats, Floats]:
    """Return the heights of both scans in the area that they share, at the points of the first scan.

    The second scan is interpolated if the shift is not a whole number of points.
    """
    from scipy.ndimage import map_coordinates

    overlap, positions = _slice_overlap(a.shape, b.shape, shift)
    if _is_integer_shift(shift):
        return a[overlap], b[np.ix_(*(np.round(axis_positions).astype(np.intp) for axis_positions in positions))]
    return a[overlap], map_coordinates(b, np.meshgrid(*positions, indexing="ij"), order=5)


def _compute_slopes_along_axes(heights: Floats) -> list[Floats]:
    """Compute the slopes of heights along each axis, as height differences per grid point (central differences)."""
    return list(np.gradient(heights)) if heights.ndim > 1 else [np.gradient(heights)]


def _find_integer_shift(a: Floats, b: Floats) -> Floats:
    """Return the shift (in whole points) at which the correlation between two scans is largest.

    At this shift, the overlap contains more than half the points of the smaller scan.
    """
    from scipy.fft import irfftn, next_fast_len, rfftn

    shape = [next_fast_len(n + m, real=True) for n, m in zip(a.shape, b.shape, strict=True)]
    transforms_of_a, transforms_of_b = (
        [rfftn(power_of_heights, shape) for power_of_heights in (np.ones(heights.shape), heights, heights**2)]
        for heights in (a, b)
    )

    def sum_products(power_of_a: int, power_of_b: int) -> Floats:
        """Sum, for each shift of b, a^`power_of_a` · b^`power_of_b` over the points where heights a and b overlap."""
        return np.asarray(irfftn(transforms_of_a[power_of_a] * np.conj(transforms_of_b[power_of_b]), shape))

    count = np.maximum(np.rint(sum_products(0, 0)), 1)
    squared_deviations = [
        sum_products(2, 0) - sum_products(1, 0) ** 2 / count,
        sum_products(0, 2) - sum_products(0, 1) ** 2 / count,
    ]
    correlation = (sum_products(1, 1) - sum_products(1, 0) * sum_products(0, 1) / count) / np.sqrt(
        np.maximum(np.prod(squared_deviations, axis=0), 1e-300)
    )
    correlation = np.where(count > min(a.size, b.size) / 2, correlation, -1.0)
    peak_index = np.array(np.unravel_index(int(np.argmax(correlation)), correlation.shape))
    return np.where(peak_index < a.shape, peak_index, peak_index - shape).astype(np.float64)


def _slice_overlap(
    first_shape: tuple[int, ...], second_shape: tuple[int, ...], shift: Floats
) -> tuple[tuple[slice, ...], list[Floats]]:
    """Return the overlap of two shifted scans: slices of the first scan, and fractional indices in the second scan."""
    selected_slices, positions = [], []
    for points, second_points, shift_along_axis in zip(first_shape, second_shape, shift.tolist(), strict=True):
        start = max(0, math.ceil(shift_along_axis) + (_OVERLAP_MARGIN_POINTS if shift_along_axis > 0 else 0))
        end = min(
            points,
            math.floor(second_points + shift_along_axis)
            - (_OVERLAP_MARGIN_POINTS if second_points + shift_along_axis < points else 0),
        )
        if end - start <= min(points, second_points) / 2:
            raise ValueError(
                "the scans `first` and `second` must be scans of the same area that overlap by more than half"
            )
        selected_slices.append(slice(start, end))
        positions.append(np.clip(np.arange(start, end) - shift_along_axis, 0, second_points - 1))
    return tuple(selected_slices), positions
