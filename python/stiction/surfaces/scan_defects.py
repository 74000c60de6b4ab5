"""Defects of a scan: spikes, instrument noise, effects of a blunt tip, and a change of roughness along the scan."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from stiction._caching import cached_property
from stiction._checks import Floats
from stiction.surfaces.filters import gaussian_low_pass, gaussian_transmission
from stiction.surfaces.hidden_noise import NoiseHiddenInSpectrum, find_hidden_noise
from stiction.surfaces.missing_data import find_outliers, with_interpolated_points
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.scale import InstrumentLimit, instrument_limit, scale_dependent_roughness
from stiction.surfaces.surface import Surface

MIN_SPIKE_SHARPNESS_RATIO = 12.0
"""Minimum second difference of heights at a sharp point of a profile, in robust standard deviations of all second
differences.

A sharp point that is also an outlier is a spike. The robust standard deviation is the median of the absolute second
differences, divided by 0.67.
"""

MIN_SPIKE_HEIGHT_RATIO = 6.0
"""Minimum distance of a spike in a map from the median height of its neighbourhood, in robust standard deviations of
the heights.

A point far from its neighbours that is also an outlier is a spike. The distance is at most 4 robust standard deviations
of the heights for machined surfaces, and 5 for white noise.
"""

MIN_SPIKE_TO_FLANK_RATIO = 2.0
"""Minimum ratio for a spike in a profile: height divided by the number of points in the spike and by the flank height.

The flanks of a groove are high. The ratio is at most 1.7 for milled, turned and ground profiles.
"""
_NUM_FLANK_POINTS = 4
# In a Gaussian groove with a half width of two points (at 1/e), adjacent points differ by up to 0.4 of the depth.
_MIN_STEP_TO_SPIKE_HEIGHT_RATIO = 0.7
_MIN_SPIKE_TO_RMS_RATIO = 2.0

MIN_HEIGHT_RANGE_RATIO_WITHOUT_OUTLIERS = 1e-6

MIN_LAY_SLOPE_RATIO = 2.0
"""Smallest ratio of the rms slopes across and along the lay at which the orientation of a map matters.

The ratio is at most 1.2 for isotropic maps with 64 x 64 points.
"""
MAX_LAY_SLOPE_RATIO = 1000.0
_NUM_DRIFT_STRIPS = 8
_MIN_STRIP_POINTS = 4
MAX_LOG_SLOPE_DRIFT = math.log(4.0)
"""Largest reported drift of ln(rms slope). A linear fit overestimates the drift if the roughness changes abruptly."""

MIN_DRIFT_IN_STANDARD_DEVIATIONS = 2.5
"""Smallest significant drift of the roughness along an axis, as a multiple of its standard deviation by chance.

In 400 Gaussian maps with 64 x 64 and 128 x 128 points, 2.6 % had a drift above this limit along one of the two axes.
"""

MAX_NOISE_SLOPE_FRACTION = 0.01


class ScanDefects:
    """Defects of a scan: outliers, spikes, noise, and wavelengths too short for the tip.

    Each defect is computed on first use.

    Parameters
    ----------
    body : Profile or Surface
    tip_radius : float, µm, or None
    textured : bool
        True if lines and humps in the spectrum belong to the surface.
    periodic : bool
        True if the body is periodic, as in `power_spectrum`.
    """

    def __init__(
        self, body: Profile | Surface, tip_radius: float | None, *, textured: bool, periodic: bool = False
    ) -> None:
        self.body, self.tip_radius, self.textured, self.periodic = body, tip_radius, textured, periodic
        self._limits_with_tip: dict[float, InstrumentLimit] = {}

    @cached_property
    def outliers(self) -> NDArray[np.bool_]:
        """Mask of the measured points of the scan that are outliers."""
        return find_outliers(self.body.heights_with_nan, self.body.height_step)

    @cached_property
    def num_spikes(self) -> int:
        """Number of spikes in the scan: outliers with an abrupt change of height; in profiles, only isolated outliers.

        Cusps and edges of machined surfaces are sharp too, but usually not outliers. Narrow scratches can be outliers,
        but are not isolated.
        """
        if not self.outliers.any():
            return 0
        is_spike = self.outliers & _find_sharp_points(self.body)
        if isinstance(self.body, Profile) and is_spike.any():
            is_spike &= _find_isolated_points(self.body, self.outliers)
        return int(np.count_nonzero(is_spike))

    @cached_property
    def body_without_outliers(self) -> Profile | Surface:
        """Copy of the scan in which the heights of outliers are interpolated.

        Without interpolation, outliers would resemble white noise in spectra.

        If the body has no outliers, or is flat except for outliers, it is returned unchanged.
        """
        body = with_interpolated_points(self.body, self.outliers)
        is_rough = body is self.body or _measure_height_range(
            body
        ) > MIN_HEIGHT_RANGE_RATIO_WITHOUT_OUTLIERS * _measure_height_range(self.body)
        return body if is_rough else self.body

    @cached_property
    def instrument_limit(self) -> InstrumentLimit:
        """Shortest wavelength at which the scan is reliable, given its pixels and its noise.

        Raises a `ValueError` if the body is flat.
        """
        return self._find_instrument_limit(None)

    @cached_property
    def hidden_noise(self) -> NoiseHiddenInSpectrum | None:
        """White noise that the scan may contain although its spectrum shows no noise floor.

        None if there is no such noise, if visible noise already exceeds a tenth of the mean square slope, or if the
        scan is textured.
        """
        if self.instrument_limit.matters or self.textured:
            return None
        return find_hidden_noise(self.body_without_outliers, periodic=self.periodic)

    @property
    def instrument_limit_with_tip(self) -> InstrumentLimit | None:
        """Shortest wavelength at which the scan is reliable, given its pixels, its noise and its tip.

        None if no tip radius is given. Raises a `ValueError` if the body is flat.
        """
        return self._find_instrument_limit_with_tip(0.0)

    def find_noise_slope_fraction(self, cut_off: float) -> float:
        """Return which fraction of the mean square slope is noise after low-pass filtering at `cut_off` (µm).

        At wavelengths below `instrument_limit`, the noise is assumed to have the same spectrum as the scan. Raises a
        `ValueError` if the body is flat.
        """
        limit = self.instrument_limit
        roughness = scale_dependent_roughness(self.body_without_outliers, periodic=self.periodic)
        contributions = np.diff(np.square(roughness.gradient), prepend=0.0)
        transmissions = np.square(gaussian_transmission(2 * math.pi / roughness.wavelength, cut_off))
        is_noise = roughness.wavelength < limit.wavelength
        noise_transmission, transmission = (
            float(contributions[selected] @ transmissions[selected] / contributions[selected].sum())
            for selected in (is_noise, np.ones_like(is_noise))
        )
        return limit.slope_fraction * noise_transmission / transmission

    def find_tip_limit(self, cut_off: float) -> InstrumentLimit | None:
        """Return the shortest reliable wavelength of a low-pass filtered scan, or None if the tip does not limit it.

        The filter has the cutoff `cut_off` (µm, 0 for no filter). Returns None if no tip radius is given, if pixels or
        noise set the limit, or if shorter wavelengths contribute at most 1 % of the mean square slope. Raises a
        `ValueError` if the body is flat.
        """
        limit = self._find_instrument_limit_with_tip(cut_off)
        if limit is None or limit.reason != "tip":
            return None
        return limit if limit.slope_fraction > MAX_NOISE_SLOPE_FRACTION else None

    def _find_instrument_limit_with_tip(self, cut_off: float) -> InstrumentLimit | None:
        if self.tip_radius is None:
            return None
        if cut_off not in self._limits_with_tip:
            self._limits_with_tip[cut_off] = self._find_instrument_limit(self.tip_radius, cut_off)
        return self._limits_with_tip[cut_off]

    def _find_instrument_limit(self, tip_radius: float | None, cut_off: float = 0.0) -> InstrumentLimit:
        body = self.body_without_outliers
        if cut_off > 0:
            body = body.changed(gaussian_low_pass(body, cut_off, periodic=self.periodic), "low-pass filtered")
        return instrument_limit(body, tip_radius=tip_radius, periodic=self.periodic, texture=self.textured)


def compute_mean_square_slope(body: Profile | Surface) -> float:
    """Compute the mean square slope of a body from first differences of the heights along all axes."""
    axes = range(body.heights.ndim)
    return sum(float(np.square(np.diff(body.heights, axis=axis)).mean()) / body.spacings[axis] ** 2 for axis in axes)


def compute_lay_ratio(surface: Surface) -> float:
    """Compute the ratio of the largest to the smallest rms slope of a map over all directions.

    The slopes are averaged over the cells of the grid. The ratio is at most `MAX_LAY_SLOPE_RATIO`.
    """
    heights, (step_y, step_x) = surface.heights, surface.spacing
    slope_y = (np.diff(heights[:, 1:], axis=0) + np.diff(heights[:, :-1], axis=0)) / (2 * step_y)
    slope_x = (np.diff(heights[1:], axis=1) + np.diff(heights[:-1], axis=1)) / (2 * step_x)
    smallest_variance, largest_variance = np.linalg.eigvalsh(np.cov(slope_y.ravel(), slope_x.ravel())).tolist()
    if not largest_variance > 0:
        return 1.0
    return math.sqrt(largest_variance / max(smallest_variance, largest_variance / MAX_LAY_SLOPE_RATIO**2))


def estimate_roughness_drift(body: Profile | Surface) -> float:
    """Estimate a scan's roughness drift: the change of ln(rms slope) from one end of the scan to the other.

    A linear trend is fitted to the logarithms of the rms slopes of strips. For maps, the trends along both axes are
    combined. The result is 0 if no trend exceeds what a stationary surface shows by chance.

    Notes
    -----
    The standard deviation of the trend is the larger of two estimates. The first follows from the scatter of the strips
    around the trend. The second applies to a Gaussian surface: the relative variance of the mean square slope is
    ΣP²/(ΣP)², where P is the periodogram of the gradient, and its inverse is the number of independent patches. (The
    mean of a squared periodogram value is twice the squared density.) A straight line through values with the variance
    s² of their mean has a slope with the variance 12 s² over the length, and the logarithm of the rms slope has a
    quarter of the relative variance of the mean square.
    """
    heights = body.heights
    if min(heights.shape) <= _NUM_DRIFT_STRIPS * _MIN_STRIP_POINTS:
        return 0.0
    differences = [np.diff(heights, axis=axis) / body.spacings[axis] for axis in range(heights.ndim)]
    if heights.ndim == 2:
        differences = [
            (differences[0][:, 1:] + differences[0][:, :-1]) / 2, (differences[1][1:] + differences[1][:-1]) / 2
        ]  # fmt: skip
    gradients = [difference - difference.mean() for difference in differences]
    power = np.sum([np.square(np.abs(np.fft.rfftn(gradient))) for gradient in gradients], axis=0)
    # Coefficients between the first and the last column count twice, because `rfftn` omits their complex conjugates.
    num_columns = gradients[0].shape[-1]
    weights = np.full(power.shape[-1], 2.0)
    weights[0] = 1.0
    if num_columns % 2 == 0:
        weights[-1] = 1.0
    total_power = float((power * weights).sum())
    if not total_power > 0:
        return 0.0
    chance_variance = 3 * float((np.square(power / total_power) * weights).sum())
    mean_square_slopes = np.sum([np.square(gradient) for gradient in gradients], axis=0)
    if body.missing is not None:
        corner_slices = [slice(None, -1), slice(1, None)]
        is_missing = np.any(
            [body.missing[corner_index] for corner_index in itertools.product(corner_slices, repeat=heights.ndim)],
            axis=0,
        )
        mean_square_slopes[is_missing] = np.nan
    trends, variances = zip(
        *(_fit_strip_trend(mean_square_slopes, axis) for axis in range(heights.ndim)), strict=True
    )  # fmt: skip
    variances_by_axis = np.maximum(variances, chance_variance)
    squared_trends = np.square(trends)
    if not (squared_trends > MIN_DRIFT_IN_STANDARD_DEVIATIONS**2 * variances_by_axis).any():
        return 0.0
    return min(MAX_LOG_SLOPE_DRIFT, math.sqrt(float((squared_trends - variances_by_axis).clip(0).sum())))


def _fit_strip_trend(mean_square_slopes: Floats, axis: int) -> tuple[float, float]:
    """Return the change of ln(rms slope) along an axis from one end of a scan to the other, and its variance.

    The change follows from a straight line that is fitted to the means of strips. Both numbers are 0 if a strip has no
    measured points or no slope.
    """
    lines = np.moveaxis(mean_square_slopes, axis, 0)
    strip_means = np.array([float(np.nanmean(strip)) if np.isfinite(strip).any() else 0.0
                       for strip in np.array_split(lines, _NUM_DRIFT_STRIPS)])  # fmt: skip
    if not (strip_means > 0).all():
        return 0.0, 0.0
    log_slopes = np.log(strip_means) / 2
    positions = (np.arange(_NUM_DRIFT_STRIPS) + 0.5) / _NUM_DRIFT_STRIPS - 0.5
    position_square_sum = float(positions @ positions)
    trend = float(positions @ log_slopes) / position_square_sum
    residuals = log_slopes - log_slopes.mean() - trend * positions
    return trend, float(residuals @ residuals) / (_NUM_DRIFT_STRIPS - 2) / position_square_sum


def _measure_height_range(body: Profile | Surface) -> float:
    """Return the distance (µm) from the lowest to the highest point of a body after levelling."""
    levelled_body = levelled(body, "line") if isinstance(body, Profile) else levelled(body, "plane")
    return float(np.ptp(levelled_body.heights))


def _find_sharp_points(body: Profile | Surface) -> NDArray[np.bool_]:
    """Return a mask of the points at which the height changes abruptly.

    Sharp points of a profile are next to a large second difference. Sharp points of a map are far from the median of
    the 3 x 3 points around them.
    """
    from scipy.ndimage import maximum_filter, median_filter

    rounding_error = body.height_step / math.sqrt(12)
    if isinstance(body, Profile):
        typical_distances = np.abs(np.diff(body.heights, 2))
        # Points beside a large second difference count as sharp too, because a spike may have several points.
        distances = maximum_filter(np.pad(typical_distances, 1), 3)
        threshold, rounding_distance = MIN_SPIKE_SHARPNESS_RATIO, math.sqrt(6) * rounding_error
    else:
        heights = levelled(body, "plane").heights
        distances, typical_distances = (
            np.abs(heights - median_filter(heights, size=3)),
            np.abs(heights - np.median(heights)),
        )
        threshold, rounding_distance = MIN_SPIKE_HEIGHT_RATIO, rounding_error
    # Rounding can make the median of the distances 0, so the usual distance is at least `rounding_distance`.
    usual_distance = max(float(np.median(typical_distances)) / 0.6745, rounding_distance)
    return np.asarray(distances > threshold * usual_distance)


def _find_isolated_points(profile: Profile, outliers: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a mask of isolated outliers: points that stand out abruptly, unlike cusps and the bottoms of grooves.

    A group of adjacent outliers is isolated if its deviation from the profile without outliers is large compared with
    the height of its flanks, or if a single step on its flanks makes up most of its height. Dips must also be deep,
    because shallow dips do not touch and occur on honed plateaus.
    """
    from scipy.ndimage import find_objects, label

    is_isolated = np.zeros(outliers.shape, np.bool_)
    remaining_heights = with_interpolated_points(profile, outliers).heights
    min_height = _MIN_SPIKE_TO_RMS_RATIO * float(levelled(profile, "line").heights.std())

    def measure_from_flanks(heights: Floats, group: slice) -> Floats:
        """Return the heights of adjacent outliers and their flanks above a line through the flanks' outer ends."""
        start, stop = max(group.start - _NUM_FLANK_POINTS, 0), min(group.stop + _NUM_FLANK_POINTS, outliers.size)
        baseline = np.linspace(remaining_heights[start], remaining_heights[stop - 1], stop - start)
        return heights[start:stop] - baseline

    for (group,) in find_objects(label(outliers)[0]):
        width = group.stop - group.start
        # A group of several outliers at an end of the profile is skipped: it may be one side of a groove or a ridge.
        if width > 1 and (group.start == 0 or group.stop == outliers.size):
            continue
        deviation = max((profile.heights - remaining_heights)[group].tolist(), key=abs)
        flank_height = float(np.abs(measure_from_flanks(remaining_heights, group)).max())
        is_above_flanks = abs(deviation) > MIN_SPIKE_TO_FLANK_RATIO * width * flank_height
        heights = measure_from_flanks(profile.heights, group)
        height = float(np.abs(heights).max())
        has_step = (
            height > min_height and float(np.abs(np.diff(heights)).max()) > _MIN_STEP_TO_SPIKE_HEIGHT_RATIO * height
        )
        is_isolated[group] = has_step or (is_above_flanks and (deviation > 0 or -deviation > min_height))
    return is_isolated


def find_scan_defects(
    body: Profile | Surface, tip_radius: float | None, *, textured: bool, periodic: bool = False
) -> ScanDefects:
    """Return the defects of a scan as an object that computes each defect on first use.

    All calls for one scan return the same object. The defects are cached as an attribute of the body, so that the
    memory of both is released together.
    """
    cached_defects: dict[tuple[float | None, bool, bool], ScanDefects] = vars(body).setdefault("_defects", {})
    options = tip_radius, textured, periodic
    if options not in cached_defects:
        cached_defects[options] = ScanDefects(body, tip_radius, textured=textured, periodic=periodic)
    return cached_defects[options]
