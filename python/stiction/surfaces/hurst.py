"""Hurst exponent of a profile or a height map, estimated from its spectrum in a band of wavelengths."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from stiction._checks import Floats, check_bool, validate_number
from stiction._repr import TableReprMixin
from stiction._units import short_repr
from stiction.surfaces.floor_fit import BinnedSpectrum, fit_noise_floor
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectrum import HANN_VARIANCE_FACTOR, areal_spectrum, is_within_wavelength_band, profile_spectrum
from stiction.surfaces.surface import BodyLike, Surface, as_body, reject_flat_body

_NUM_NEWTON_STEPS, _NUM_BISECTION_STEPS = 50, 30
MAX_HURST_INTERVAL_WIDTH = 0.5
MIN_BAND_HARMONICS = 8
_NO_SELF_AFFINE_BAND_MESSAGE = (
    "the spectrum has no self-affine band of half a decade or more (0 < H < 2); specify one with band"
)
# After the subtraction of a straight line, heights below this fraction of the original heights are round-off.
_ROUND_OFF_AFTER_TREND_REMOVAL = 1e-13
# Number of lowest harmonics that are excluded, because a Hann window adds power from the mean and longer wavelengths.
_NUM_EXCLUDED_HARMONICS = 2

_CHI_SQUARED_QUANTILE_95 = 3.841
_BINS_PER_DECADE = 12
_MIN_BINS_PER_PIECE = 4
# Relative deviation from a power law that is assumed in each bin of a measured spectrum.
_RELATIVE_MODEL_ERROR = 0.1
# Each piece of a spectrum adds this penalty to the loss: a piece has three parameters and some 50 possible first bins.
_SPECTRUM_PIECE_PENALTY = 10.0
# Maximum deviance of a fit per degree of freedom: random scatter of a spectrum causes about 1, separate peaks more.
_MAX_DEVIANCE_PER_DEGREE_OF_FREEDOM = 10.0
_MIN_LOG_BAND_WIDTH = math.log(3)  # about half a decade
_ROLL_OFF_PENALTY = 2.0


class PowerLawFit:
    """Maximum-likelihood fit of a power law P ∝ q^-s to spectral powers whose scatter follows a gamma distribution.

    The weights are the shape parameters of the gamma distribution.
    """

    def __init__(self, log_q: Floats, power: Floats, weight: Floats) -> None:
        self._total_weight = float(weight.sum())
        fraction = weight / self._total_weight
        self._mean_log_q = float((fraction * log_q).sum())
        self._log_q = log_q - self._mean_log_q
        self._max_power = float(power.max())
        self._power = fraction * power / self._max_power
        self.exponent = float(_fit_exponents(self._log_q[np.newaxis], self._power[np.newaxis])[0])
        self.min_loss = self.loss(self.exponent)

    def _log_power_at_mean_q(self, exponent: float) -> float:
        return math.log((self._power * np.exp(exponent * self._log_q)).sum()) + math.log(self._max_power)

    def loss(self, exponent: float) -> float:
        """Return the negative log-likelihood (plus a constant) of the best power law with a given exponent."""
        return self._total_weight * self._log_power_at_mean_q(exponent)

    @property
    def log_prefactor(self) -> float:
        """Logarithm of the prefactor C of the fitted power law C q^-s."""
        return self._log_power_at_mean_q(self.exponent) + self.exponent * self._mean_log_q

    def exponent_interval(self, max_loss: float) -> tuple[float, float]:
        """Return the range of power-law exponents for which the negative log-likelihood is at most `max_loss`."""
        interval_ends = []
        for sign in (-1.0, 1.0):
            inner_offset, outer_offset = 0.0, 0.1
            while self.loss(self.exponent + sign * outer_offset) < max_loss:
                inner_offset, outer_offset = outer_offset, 2 * outer_offset
            for _ in range(_NUM_BISECTION_STEPS):
                middle_offset = (inner_offset + outer_offset) / 2
                inner_offset, outer_offset = (
                    (middle_offset, outer_offset)
                    if self.loss(self.exponent + sign * middle_offset) < max_loss
                    else (inner_offset, middle_offset)
                )
            interval_ends.append(self.exponent + sign * outer_offset)
        return interval_ends[0], interval_ends[1]


def _fit_exponents(log_q: Floats, power: Floats) -> Floats:
    """Return, for each row of weighted spectral powers, the exponent s of the power law P ∝ q^-s that fits best."""
    exponents = np.zeros(len(power))
    unconverged_rows = np.arange(len(power))
    # Newton's method converges, because the loss is a convex log-sum-exp function.
    for _ in range(_NUM_NEWTON_STEPS):
        scaled_power = power * np.exp(exponents[unconverged_rows, np.newaxis] * log_q)
        scaled_power /= scaled_power.sum(axis=-1, keepdims=True)
        # Array sums are used instead of BLAS dot products, whose round-off depends on the number of threads.
        gradient = (scaled_power * log_q).sum(axis=-1, keepdims=True)
        newton_step = gradient[:, 0] / (scaled_power * (log_q - gradient) ** 2).sum(axis=-1)
        exponents[unconverged_rows] -= np.clip(newton_step, -2.0, 2.0)
        is_open = np.abs(newton_step) >= 1e-10
        if not is_open.any():
            break
        if not is_open.all():
            unconverged_rows, power, log_q = unconverged_rows[is_open], power[is_open], log_q[is_open]
    return exponents


def _fit_power_laws(log_q: Floats, power: Floats, weight: Floats) -> tuple[Floats, Floats]:
    """Fit a power law to each of several spectra; each row of the arrays contains the data of one spectrum.

    Returns exponents and negative log-likelihoods.

    Fitting all rows together is several times faster than separate fits, because most parts of a binned spectrum have
    few bins.
    """
    total_weight = weight.sum(axis=-1, keepdims=True)
    weight_fraction = weight / total_weight
    centred_log_q = log_q - (weight_fraction * log_q).sum(axis=-1, keepdims=True)
    max_power = power.max(axis=-1, keepdims=True)
    scaled_power = weight_fraction * power / max_power
    exponents = _fit_exponents(centred_log_q, scaled_power)
    power_sums = (scaled_power * np.exp(exponents[:, np.newaxis] * centred_log_q)).sum(axis=-1)
    return exponents, total_weight[:, 0] * (np.log(power_sums) + np.log(max_power[:, 0]))


@dataclass(frozen=True, repr=False)
class HurstEstimate(TableReprMixin):
    """Hurst exponent of a profile or a height map, with 95 % interval and fitted wavelength band.

    Attributes
    ----------
    value : float
        H, where C1D ∝ q^(-1-2H) for a profile and C2D ∝ q^(-2-2H) for a surface.
    lower, upper : float
        95 % interval. It includes the uncertainty of the end of the roll-off unless the band was given.
    shortest_wavelength, longest_wavelength : float, µm
        Limits of the fitted band.
    harmonics : int
        Number of harmonics of the profile, or of wave vectors of the surface, in the band.
    prefactor : float
        C of the fitted power law C q^(-n-2H), with n the dimensions; units of µm and 1/µm; see `density`.
    dispersion : float
        Ratio, at least 1, of the variance of the binned spectrum about the power law to the variance expected by
        chance. A value far above 1 indicates that the spectrum is not a power law. The interval is widened by the
        square root of this ratio.
    dimensions : int
        1 for a profile, 2 for a surface.

    Examples
    --------
    >>> from stiction import estimate_hurst_exponent, self_affine
    >>> found = estimate_hurst_exponent(self_affine(1, hurst_exponent=0.7, rms=0.1, points=4000, spacing=0.01))
    >>> round(found.value, 1)
    0.7
    """

    value: float
    lower: float
    upper: float
    shortest_wavelength: float = field(metadata={"unit": "µm"})
    longest_wavelength: float = field(metadata={"unit": "µm"})
    harmonics: int
    prefactor: float
    dispersion: float
    dimensions: int = 1

    @property
    def fractal_dimension_classical(self) -> float:
        """Classical fractal dimension D = 2 - H of a profile, or of a section through a surface."""
        return 2 - self.value

    @property
    def fractal_dimension_paper(self) -> float:
        """Fractal dimension D = (4 - H) / 2, as used by Hanaor, Gan & Einav (2016) and `weierstrass_mandelbrot`."""
        return (4 - self.value) / 2

    @property
    def interval_classical(self) -> tuple[float, float]:
        """95 % interval of the classical fractal dimension D = 2 - H."""
        return 2 - self.upper, 2 - self.lower

    @property
    def interval_paper(self) -> tuple[float, float]:
        """95 % interval of the paper's fractal dimension D = (4 - H) / 2."""
        return (4 - self.upper) / 2, (4 - self.lower) / 2

    @property
    def caution(self) -> str | None:
        """Sentence with the reason why the Hurst exponent is unreliable, or None if the exponent is reliable."""
        interval = f"the 95 % interval of H, [{self.lower:.2f}, {self.upper:.2f}],"
        if self.upper - self.lower > MAX_HURST_INTERVAL_WIDTH:
            decades = math.log10(self.longest_wavelength / self.shortest_wavelength)
            return f"{interval} is too wide to be useful: the band is {decades:.1f} decades wide"
        if self.value > 1:
            return "H above 1 indicates a smooth surface: form, a filter, a blunt tip or waviness"
        if self.lower < 0 or self.upper > 1:
            return f"{interval} exceeds the range 0 to 1 of self-affine surfaces"
        return None

    def density(self, wave_number: Floats) -> Floats:
        """Return the spectral density of the fitted power law at wave numbers (1/µm): C1D (µm³) or C2D (µm⁴)."""
        exponent = -self.dimensions - 2 * self.value
        return np.asarray(self.prefactor * np.asarray(wave_number, dtype=np.float64) ** exponent)


def estimate_hurst_exponent(
    body: BodyLike,
    *,
    band: tuple[float, float] | None = None,
    periodic: bool = False,
    spacing: Any = None,
    unit: str = "um",
) -> HurstEstimate:
    r"""Estimate the Hurst exponent of a profile or a height map from its spectrum, by maximum likelihood.

    Parameters
    ----------
    body : Profile, Surface or array_like
        Heights. The least-squares line or plane is subtracted unless the body is periodic.
    band : (float, float), µm, optional
        Shortest and longest wavelength of the fit; by default the widest self-affine band of the spectrum (see Notes).
    periodic : bool
        As for `power_spectrum`.
    spacing : float (µm) or str, or a pair (y, x) of either
        Distance between the points of an array, such as 0.5 or "39 nm"; required for arrays.
    unit : str
        Unit of the heights of an array.

    Returns
    -------
    estimate : HurstEstimate
        Exponent with its 95 % interval, and the fitted band (µm).

    Raises
    ------
    ValueError
        If the body is flat, if the band has too few harmonics, or if no self-affine band is found.

    See Also
    --------
    line_roughness : Exponents of the lines of a surface.

    Notes
    -----
    The harmonics of a Gaussian profile are independent and their squares exponentially distributed about C(q), so
    the log-likelihood of a power law is -Σ [ln C(q) + P(q)/C(q)] over the band (Whittle). It has one maximum. A line
    fitted to the logarithms would give too much weight to the many low values of an exponential distribution. The
    interval contains the exponents whose deviance (twice the loss of log-likelihood) is below 3.84. The deviance is
    first divided by 35/18 for a Hann window, which correlates neighbouring harmonics, and by the dispersion. The lowest
    two harmonics of a windowed spectrum are excluded, and so is the harmonic at the Nyquist wave number. If the band
    was found, the interval includes all possible ends of the roll-off, because a few harmonics of a roll-off look like
    the power law.

    To find the band, the spectrum is binned in log q and divided into pieces with separate power laws, such as
    roll-off, self-affine range, cutoff by a tip or a filter, and noise. The division maximises the log-likelihood minus
    a penalty for each piece. The band is the widest piece with 0 < H < 1, or with 0 < H < 2 if there is none. One bin
    is removed at each end that adjoins another piece. Long wavelengths are removed if a flat roll-off fits them better,
    and short wavelengths if white noise fits them better and exceeds 10 % of the power law there. A piece of separate
    lines is rejected. Deviations of less than 10 % from a power law are not detected. Check the band against the
    spectrum.

    The interval assumes an exact power law and does not include the bias due to slight curvature of the spectrum. In
    trials with 4096 points, noise with an rms of a tenth of Pq changed the mean estimate from 0.8 to 0.74 and from 0.3
    to 0.28; a moving average over nine points changed it to 0.88 and 0.38.

    For a surface, the harmonics are the wave vectors in all directions up to the smaller Nyquist wave number. Their
    powers are multiplied by q, so that they decay as those of a profile; the factor 35/18 is squared. The areal
    spectrum follows the power law up to a cutoff of the surface, whereas the spectrum of a profile deviates within an
    octave of it. If the surface has a lay, the result is the exponent of the mean over directions.

    Whittle, Arkiv för Matematik 2 (1953) 423.

    Examples
    --------
    >>> from stiction import estimate_hurst_exponent, self_affine
    >>> found = estimate_hurst_exponent(self_affine(1, hurst_exponent=0.7, rms=0.1, points=4000, spacing=0.01))
    >>> found.lower < 0.7 < found.upper
    True
    """
    body = as_body("body", body, spacing=spacing, unit=unit)
    check_bool("periodic", periodic)
    reject_flat_body(body)
    if isinstance(body, Profile):
        dimensions, (wave_number, power, height_scale) = 1, _select_profile_harmonics(body, periodic)
    else:
        dimensions, (wave_number, power, height_scale) = 2, _select_areal_harmonics(body, periodic)
    variance_factor = 1.0 if periodic else HANN_VARIANCE_FACTOR**dimensions

    selection: slice | NDArray[np.bool_]
    if band is None:
        selection, piece_bins = _find_self_affine_band(wave_number, power, variance_factor)
        selection, piece_bins = _remove_noisy_end(wave_number, power, variance_factor, selection, piece_bins)
    else:
        if not isinstance(band, (tuple, list)) or len(band) != 2:
            raise ValueError(f"band must be a pair (shortest, longest) of wavelengths, got {short_repr(band)}")
        shortest_wavelength = validate_number("band", band[0], unit="µm", above=0)
        selection, piece_bins = (
            is_within_wavelength_band(
                wave_number, shortest_wavelength, validate_number("band", band[1], unit="µm", above=shortest_wavelength)
            ),
            None,
        )
        if (harmonic_count := int(selection.sum())) < MIN_BAND_HARMONICS:
            raise ValueError(
                f"band must contain at least {MIN_BAND_HARMONICS} harmonics, "
                f"got {short_repr(band)} µm with {harmonic_count} harmonics"
            )
    q, power = wave_number[selection], power[selection]
    bins = _SpectrumBins.from_harmonics(q, power)
    exponent = PowerLawFit(np.log(q), power, np.ones(q.size)).exponent
    dispersion = max(1.0, bins.deviance(exponent, bins.count / variance_factor))
    fit = PowerLawFit(np.log(q), power, np.full(q.size, 1 / (variance_factor * dispersion)))
    smallest_exponent, largest_exponent = fit.exponent_interval(fit.min_loss + _CHI_SQUARED_QUANTILE_95 / 2)
    # The interval of the Hurst exponent includes the uncertainty of the roll-off wavelength, which is fitted, too.
    if piece_bins is not None:
        piece_weight = piece_bins.count / (variance_factor * dispersion)
        log_q_rows, losses = _fit_roll_offs(piece_bins, piece_weight)
        max_loss = float(losses.min()) + _CHI_SQUARED_QUANTILE_95 / 2
        intervals = [
            PowerLawFit(log_q_row, piece_bins.power, piece_weight).exponent_interval(max_loss)
            for log_q_row in log_q_rows[losses < max_loss]
        ]
        smallest_exponent = min([smallest_exponent, *(interval[0] for interval in intervals)])
        largest_exponent = max([largest_exponent, *(interval[1] for interval in intervals)])
    log_prefactor = fit.log_prefactor + 2 * math.log(height_scale)
    return HurstEstimate(
        value=(fit.exponent - 1) / 2, lower=(smallest_exponent - 1) / 2, upper=(largest_exponent - 1) / 2,
        shortest_wavelength=2 * math.pi / float(q[-1]), longest_wavelength=2 * math.pi / float(q[0]),
        harmonics=int(q.size), prefactor=math.exp(log_prefactor), dispersion=dispersion, dimensions=dimensions,
    )  # fmt: skip


def _select_profile_harmonics(profile: Profile, periodic: bool) -> tuple[Floats, Floats, float]:
    """Return wave numbers and powers of a profile's heights divided by a height, and this height (µm)."""
    heights = profile.heights - profile.heights.mean()
    if not periodic:
        centred_index = np.arange(heights.size) - (heights.size - 1) / 2
        levelled_heights = heights - centred_index * (heights @ centred_index / (centred_index @ centred_index))
        if not np.abs(levelled_heights).max() > _ROUND_OFF_AFTER_TREND_REMOVAL * np.abs(profile.heights).max():
            raise ValueError("profile must not be a straight line, which has no roughness")
        heights = levelled_heights
    height_scale = float(np.abs(heights).max())
    spectrum = profile_spectrum(heights / height_scale, profile.spacing, windowed=not periodic)
    is_harmonic = spectrum.count == 1
    if not periodic:
        is_harmonic[:_NUM_EXCLUDED_HARMONICS] = False
    # Above the highest harmonic of the profile, the spectrum contains only round-off.
    power = np.maximum(spectrum.density[is_harmonic], np.finfo(float).eps ** 2 * spectrum.density.max())
    return spectrum.wave_number[is_harmonic], power, height_scale


def _select_areal_harmonics(surface: Surface, periodic: bool) -> tuple[Floats, Floats, float]:
    """Return wave numbers and powers of a map's heights divided by a height, and this height (µm)."""
    heights = surface.heights - surface.heights.mean()
    if not periodic:
        heights = levelled(surface, "plane").heights
        if not heights.any():
            raise ValueError("surface must not be a plane, which has no roughness")
    height_scale = float(np.abs(heights).max())
    spectrum = areal_spectrum(heights / height_scale, surface.spacing, windowed=not periodic)
    wave_number, _, density = spectrum.waves()
    is_harmonic = np.full(wave_number.shape, True)
    if not periodic:
        is_harmonic = wave_number > (_NUM_EXCLUDED_HARMONICS + 0.5) * 2 * math.pi / min(surface.extent)
    density = np.maximum(density, np.finfo(float).eps ** 2 * density.max())
    return wave_number[is_harmonic], (density * wave_number)[is_harmonic], height_scale


@dataclass(frozen=True)
class _SpectrumBins:
    """Spectrum averaged in bins of equal width in the logarithm of the wave number."""

    first: NDArray[np.intp]
    log_q: Floats
    power: Floats
    count: Floats

    @classmethod
    def from_harmonics(cls, q: Floats, power: Floats) -> _SpectrumBins:
        bin_index = np.floor(_BINS_PER_DECADE * np.log10(q / q[0]) + 1e-9)
        first_harmonics = np.flatnonzero(np.diff(bin_index, prepend=-1))
        count = np.diff(first_harmonics, append=q.size).astype(np.float64)
        return cls(
            first_harmonics,
            np.add.reduceat(np.log(q), first_harmonics) / count,
            np.add.reduceat(power, first_harmonics) / count,
            count,
        )

    def slice_bins(self, start: int, end: int) -> _SpectrumBins:
        return _SpectrumBins(self.first[start:end], self.log_q[start:end], self.power[start:end], self.count[start:end])

    def deviance(self, exponent: float, weight: Floats) -> float:
        """Return the deviance per degree of freedom of the binned spectrum from a power law with a given exponent."""
        ratio = self.power * np.exp(exponent * (self.log_q - self.log_q.mean()))
        ratio /= np.average(ratio, weights=weight)
        return float(2 * (weight * (ratio - 1 - np.log(ratio))).sum() / max(1, ratio.size - 2))


def _find_self_affine_band(q: Floats, power: Floats, variance_factor: float) -> tuple[slice, _SpectrumBins]:
    """Find the widest band of harmonics that follow one power law with 0 < H < 1; if there is none, with 0 < H < 2.

    Returns this band, and the binned spectrum in this band and in the roll-off at longer wavelengths.
    """
    if q.size >= MIN_BAND_HARMONICS:
        bins = _SpectrumBins.from_harmonics(q, power)
        weight = 1 / (variance_factor / bins.count + _RELATIVE_MODEL_ERROR**2)
        starts, piece_ends, exponents, losses = _fit_spectrum_pieces(bins, weight)
        pieces = _select_spectrum_pieces(bins.log_q.size, starts, piece_ends, losses)
        # The power spectrum of a self-affine profile has the exponent 3 for H = 1, and 5 for H = 2.
        for max_exponent in (3.0, 5.0):
            max_band_width = _MIN_LOG_BAND_WIDTH
            best_band: tuple[slice, _SpectrumBins] | None = None
            for piece in pieces:
                if not 1 < exponents[piece] < max_exponent:
                    continue
                start_bin, end_bin = int(starts[piece]), int(piece_ends[piece])
                if (
                    bins.slice_bins(start_bin, end_bin).deviance(exponents[piece], weight[start_bin:end_bin])
                    > _MAX_DEVIANCE_PER_DEGREE_OF_FREEDOM
                ):
                    continue
                end_bin -= end_bin < bins.log_q.size
                first_bin = start_bin + (start_bin > 0)
                # The self-affine band starts after a roll-off, even if the roll-off is too short for a separate piece.
                if start_bin == 0:
                    _, roll_off_losses = _fit_roll_offs(bins.slice_bins(0, end_bin), weight[:end_bin])
                    start_bin = (
                        int(np.argmin(roll_off_losses))
                        if roll_off_losses.min() < roll_off_losses[0] - _ROLL_OFF_PENALTY
                        else 0
                    )
                else:
                    start_bin = first_bin
                first_harmonic = int(bins.first[start_bin])
                last_harmonic = (int(bins.first[end_bin]) if end_bin < bins.first.size else q.size) - 1
                band_width = math.log(q[last_harmonic] / q[first_harmonic])
                if band_width > max_band_width and last_harmonic - first_harmonic + 1 >= MIN_BAND_HARMONICS:
                    max_band_width, best_band = (
                        band_width,
                        (slice(first_harmonic, last_harmonic + 1), bins.slice_bins(first_bin, end_bin)),
                    )
            if best_band is not None:
                return best_band
    raise ValueError(_NO_SELF_AFFINE_BAND_MESSAGE)


def _remove_noisy_end(
    q: Floats, power: Floats, variance_factor: float, selection: slice, piece: _SpectrumBins
) -> tuple[slice, _SpectrumBins]:
    """Cut off the shortest wavelengths of a band if white noise flattens the spectrum at these wavelengths."""
    bins = _SpectrumBins.from_harmonics(q[selection], power[selection])
    fit = fit_noise_floor([BinnedSpectrum(bins.log_q, bins.power, bins.count / variance_factor)], exponents=(1.0, 5.0))
    if not fit.is_significant:
        return selection, piece
    (exponent,), (noise_ratio,) = fit.exponents, fit.ratios
    # The self-affine band ends where the noise exceeds `_RELATIVE_MODEL_ERROR` times the density of the power law.
    max_log_q = math.log(q[selection][-1]) + min(0.0, math.log(_RELATIVE_MODEL_ERROR / noise_ratio) / exponent)
    end_harmonic = int(np.searchsorted(np.log(q), max_log_q, side="right"))
    if (
        end_harmonic - selection.start < MIN_BAND_HARMONICS
        or max_log_q - math.log(q[selection.start]) < _MIN_LOG_BAND_WIDTH
    ):
        raise ValueError(_NO_SELF_AFFINE_BAND_MESSAGE)
    return slice(selection.start, end_harmonic), piece.slice_bins(
        0, int(np.searchsorted(piece.log_q, max_log_q, side="right"))
    )


def _fit_roll_offs(bins: _SpectrumBins, weight: Floats) -> tuple[Floats, Floats]:
    """Fit a constant density in the roll-off and a power law beyond it, for each bin at which the roll-off may end.

    If the roll-off ends in bin 0, there is no roll-off. Returns the logarithms of the wave numbers for each fit, which
    are constant in the roll-off, and the losses.
    """
    num_rows = max(1, bins.log_q.size - _MIN_BINS_PER_PIECE)
    log_q_rows = np.maximum(bins.log_q, bins.log_q[:num_rows, np.newaxis])
    power, weight = (np.broadcast_to(values, log_q_rows.shape) for values in (bins.power, weight))
    return log_q_rows, _fit_power_laws(log_q_rows, power, weight)[1]


def _fit_spectrum_pieces(
    bins: _SpectrumBins, weight: Floats
) -> tuple[NDArray[np.intp], NDArray[np.intp], Floats, Floats]:
    """Fit a separate power law to each possible range of consecutive bins of a spectrum.

    Returns four arrays over the ranges: first bin, exclusive end, exponent and loss.
    """
    starts, piece_ends = (index.astype(np.intp) for index in np.triu_indices(bins.log_q.size + 1, _MIN_BINS_PER_PIECE))
    exponents, losses = np.empty(starts.size), np.empty(starts.size)
    for bin_count in range(_MIN_BINS_PER_PIECE, bins.log_q.size + 1):
        pieces = piece_ends - starts == bin_count
        window_rows = (sliding_window_view(values, bin_count) for values in (bins.log_q, bins.power, weight))
        exponents[pieces], losses[pieces] = _fit_power_laws(*window_rows)
    return starts, piece_ends, exponents, losses


def _select_spectrum_pieces(
    bin_count: int, starts: NDArray[np.intp], piece_ends: NDArray[np.intp], losses: Floats
) -> list[int]:
    """Select fitted ranges of bins that cover a spectrum with the least total loss, including a penalty per range."""
    min_loss, last_piece = np.full(bin_count + 1, np.inf), np.full(bin_count + 1, -1)
    min_loss[0] = 0.0
    for piece in np.argsort(piece_ends, kind="stable"):
        total_loss = min_loss[starts[piece]] + losses[piece] + _SPECTRUM_PIECE_PENALTY
        if total_loss < min_loss[piece_ends[piece]]:
            min_loss[piece_ends[piece]], last_piece[piece_ends[piece]] = total_loss, piece
    selected_pieces, end = [], bin_count
    while end > 0 and last_piece[end] >= 0:
        selected_pieces.append(int(last_piece[end]))
        end = int(starts[selected_pieces[-1]])
    return selected_pieces[::-1]
