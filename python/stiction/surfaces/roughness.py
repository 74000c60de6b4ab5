"""Characterising profiles, and making profiles of a wanted character: parameters, spectrum, Hurst exponent, surrogates.

Where a function asks whether a profile is `periodic`, a periodic one ends where it begins, one spacing further on, and
its spectrum is taken as it is. Any other profile has a jump there, which would put a spectrum of its own, falling as
1/q², on top of the profile's; it is faded out towards its ends by a Hann window.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats, choice, number, read_only, whole_number
from stiction.surfaces.fractal import ProfileMoments, Side, random_phases
from stiction.surfaces.profile import FEWEST_POINTS, MOST_POINTS, Profile

Derivative = Literal["seven-point", "neighbours"]
Amplitudes = Literal["rayleigh", "fixed"]


# ---- Parameters ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RoughnessParameters:
    """Parameters of a primary profile by the names of ISO 21920-2, about its mean.

    Attributes
    ----------
    Pa : float, µm
        Arithmetic mean height: the mean of the absolute heights.
    Pq : float, µm
        Root-mean-square height.
    Pt : float, µm
        Total height: highest minus lowest point.
    Psk : float
        Skewness: below 0 if the valleys are deeper than the peaks are high.
    Pku : float
        Kurtosis, 3 for normally distributed heights.
    Pdq : float
        Root-mean-square slope, by the derivative that was asked for.
    """

    Pa: float
    Pq: float
    Pt: float
    Psk: float
    Pku: float
    Pdq: float


def roughness_parameters(profile: Profile, *, derivative: Derivative = "seven-point") -> RoughnessParameters:
    """Roughness parameters of a profile as it is, about its mean: levelling and filtering are the caller's.

    Parameters
    ----------
    profile : Profile
        Not flat, and of at least 7 points.
    derivative : {"seven-point", "neighbours"}
        How Pdq takes slopes. "seven-point" is that of ISO 4287 and of instruments, at all points that have three
        neighbours on each side; it smooths, and sees nothing of wavelengths near twice the spacing. "neighbours" is
        the difference of two neighbours over the spacing, which most codes for contact take.

    Raises
    ------
    ValueError
        If the profile is flat or has fewer than 7 points, or the derivative is unknown.

    Notes
    -----
    Seven points: :math:`z'_i = (z_{i+3} - 9z_{i+2} + 45z_{i+1} - 45z_{i-1} + 9z_{i-2} - z_{i-3}) / 60Δx`. On a
    sinusoid of wavelength λ it is short by a factor 1 - (2πΔx/λ)^6/140, the difference of neighbours by
    1 - (2πΔx/λ)²/24. The slope of a self-affine profile depends on where its spectrum ends, and so on the derivative.

    Examples
    --------
    >>> from stiction import Profile, roughness_parameters
    >>> roughness_parameters(Profile([0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0, -1.0], spacing=2.0)).Pa
    0.5
    """
    choice("derivative", derivative, Derivative)
    _refuse_flat(profile)
    z = profile.heights
    if z.size < _SEVEN_POINTS.size:
        raise ValueError(f"profile must have at least {_SEVEN_POINTS.size} points, got {z.size}")
    deviation = z - z.mean()
    scale = float(np.abs(deviation).max())
    deviation /= scale  # so that the fourth power neither over- nor underflows
    rms = float(np.sqrt(np.mean(deviation**2)))
    if derivative == "seven-point":
        differences = np.correlate(deviation, _SEVEN_POINTS, mode="valid") / 60
    else:
        differences = np.diff(deviation)
    return RoughnessParameters(
        Pa=scale * float(np.mean(np.abs(deviation))),
        Pq=scale * rms,
        Pt=float(np.ptp(z)),
        Psk=float(np.mean((deviation / rms) ** 3)),
        Pku=float(np.mean((deviation / rms) ** 4)),
        Pdq=scale * float(np.sqrt(np.mean(differences**2))) / profile.spacing,
    )


_SEVEN_POINTS = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0])


def _refuse_flat(profile: Profile) -> None:
    if profile.is_flat:
        raise ValueError("a flat profile has no roughness")
    height = float(np.ptp(profile.heights))
    if not _LEAST_HEIGHT < height < 1 / _LEAST_HEIGHT:
        raise ValueError(
            f"the height of the profile must be above {_LEAST_HEIGHT:g} and below {1 / _LEAST_HEIGHT:g} µm, "
            f"got {height:g}"
        )


_LEAST_HEIGHT = 1e-50
"""µm. Products of moments go as the fourth power of heights, which must stay in range."""


# ---- Spectrum --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class PowerSpectrum:
    """Power spectral density of a profile by the convention of Jacobs, Junge & Pastewka (2017).

    Attributes
    ----------
    wave_number : (n,) ndarray of float, 1/µm
        q = 2π / wavelength, rising; in a bin the geometric mean.
    density : (n,) ndarray of float, µm³
        C1D(q), so that the mean square height is 1/π times its integral over q from 0 on; in a bin the mean.
    count : (n,) ndarray of float
        Harmonics in each value: 1, or those of its bin. The one at the Nyquist wave number counts half, because
        it has no partner at the negative wave number.
    resolution : float, 1/µm
        Distance of the harmonics, 2π / extent.
    """

    wave_number: Floats
    density: Floats
    count: Floats
    resolution: float

    def moment(self, order: int) -> float:
        """1/π times the integral of q^order C1D, µm^(2 - order); from bins it is approximate unless the order is 0."""
        order = whole_number("order", order, least=0)
        return float((self.wave_number**order * self.density * self.count).sum() * self.resolution / math.pi)

    def in_bins(self, per_decade: int = 10) -> PowerSpectrum:
        """Means over bins of equal width in log q, as many to a decade; bins without a harmonic are left out.

        Examples
        --------
        >>> from stiction import power_spectrum, random_phases, weierstrass_mandelbrot
        >>> spectrum = power_spectrum(weierstrass_mandelbrot(random_phases(1), 1.3, points=2001))
        >>> spectrum.in_bins(2).count
        array([  3.,   6.,  22.,  68., 217., 683.,   1.])
        """
        per_decade = whole_number("per_decade", per_decade, least=1)
        # Harmonics are whole multiples of the first, whose decades must not fall to either side by round-off.
        decades = np.log10(self.wave_number / self.wave_number[0])
        _, index = np.unique(np.floor(per_decade * decades + 1e-9), return_inverse=True)
        count = np.bincount(index, self.count).astype(np.float64)
        return PowerSpectrum(
            wave_number=read_only(np.exp(np.bincount(index, self.count * np.log(self.wave_number)) / count)),
            density=read_only(np.bincount(index, self.count * self.density) / count),
            count=read_only(count),
            resolution=self.resolution,
        )


def power_spectrum(profile: Profile, *, periodic: bool = False) -> PowerSpectrum:
    r"""Power spectral density C1D of a profile about its mean.

    Parameters
    ----------
    profile : Profile
    periodic : bool
        True: as it is, and the mean square height is the sum of the spectrum to round-off. False: after a Hann window,
        normalised to a mean square of 1; a level profile keeps its mean square on average, and the first two
        harmonics are not to be trusted.

    Returns
    -------
    PowerSpectrum
        Of all harmonics from 2π/extent to the Nyquist wave number π/spacing.

    Raises
    ------
    ValueError
        If periodic is not a truth value.

    Notes
    -----
    .. math:: C(q) = \frac{Δx}{N} \left|\sum_j w_j (z_j - \bar z) e^{-iqx_j}\right|^2, \qquad
              h_{rms}^2 = \frac1π \int_0^\infty C(q)\,dq

    A self-affine profile has C ∝ q^(-1-2H). Jacobs, Junge & Pastewka, Surface Topography: Metrology and Properties 5
    (2017) 013001.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, power_spectrum
    >>> wave = Profile(0.1 * np.cos(2 * np.pi * 3 * np.arange(64) / 64), spacing=0.5)  # a² extent / 4 at one q
    >>> spectrum = power_spectrum(wave, periodic=True)
    >>> round(float(spectrum.density[2]), 12), round(spectrum.moment(0), 12)
    (0.08, 0.005)
    """
    _truth("periodic", periodic)
    return _spectrum(profile.heights - profile.heights.mean(), profile.spacing, windowed=not periodic)


def _spectrum(heights: Floats, spacing: float, *, windowed: bool) -> PowerSpectrum:
    points = heights.size
    if windowed:
        heights = heights * (1 - np.cos(2 * math.pi * np.arange(points) / points)) / math.sqrt(1.5)
    transform = np.fft.rfft(heights)[1:]
    density = spacing / points * (transform.real**2 + transform.imag**2)
    resolution = 2 * math.pi / (points * spacing)
    wave_number = resolution * np.arange(1, transform.size + 1, dtype=np.float64)
    count = np.ones(transform.size)
    if points % 2 == 0:
        count[-1] = 0.5
    return PowerSpectrum(
        wave_number=read_only(wave_number),
        density=read_only(density),
        count=read_only(count),
        resolution=resolution,
    )


def _truth(name: str, value: object) -> None:
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"{name} must be True or False, got {value!r}")


def spectral_moments(
    profile: Profile,
    *,
    periodic: bool = False,
    shortest_wavelength: float = 0.0,
    longest_wavelength: float = math.inf,
) -> ProfileMoments:
    r"""Spectral moments m0, m2, m4 of a profile: the variances of its height, slope and curvature.

    Parameters
    ----------
    profile : Profile
    periodic : bool
        As in `power_spectrum`.
    shortest_wavelength, longest_wavelength : float, µm
        Wavelengths outside of these are left out. m2 and m4 of a rough profile are those of its shortest wavelengths,
        and mean nothing without them.

    Raises
    ------
    ValueError
        If no wavelength is left, or the profile is flat.

    Notes
    -----
    .. math:: m_j = \frac1π \int_0^\infty q^j C(q)\,dq

    These are moments of a profile, from its one-dimensional spectrum. On an isotropic surface they are the same along
    any line. `ProfileMoments.nayak_parameter` is m0 m4 / m2². Nayak, Journal of Lubrication Technology 93 (1971) 398.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, spectral_moments
    >>> wave = Profile(np.cos(np.arange(64) * np.pi / 8), spacing=np.pi / 8)
    >>> round(spectral_moments(wave, periodic=True).slope, 12)
    0.5
    """
    _refuse_flat(profile)
    shortest = number("shortest_wavelength", shortest_wavelength, unit="µm")
    if not longest_wavelength > shortest:
        raise ValueError(
            f"longest_wavelength must be above shortest_wavelength, {shortest:g} µm, got {longest_wavelength!r}"
        )
    spectrum = power_spectrum(profile, periodic=periodic)
    kept = _in_band(spectrum.wave_number, shortest, longest_wavelength)
    if not kept.any():
        raise ValueError(
            f"no wavelength of the profile lies from shortest_wavelength {shortest:g} µm to longest_wavelength "
            f"{longest_wavelength:g} µm; it has {2 * profile.spacing:g} to {profile.extent:g} µm"
        )
    part = PowerSpectrum(spectrum.wave_number[kept], spectrum.density[kept], spectrum.count[kept], spectrum.resolution)
    return ProfileMoments(height=part.moment(0), slope=part.moment(2), curvature=part.moment(4))


def _in_band(wave_number: Floats, shortest: float, longest: float) -> NDArray[np.bool_]:
    """Whether wavelengths are in a band, its ends included whatever their round-off."""
    return (wave_number * shortest <= 2 * math.pi * _ROUND_UP) & (wave_number * longest * _ROUND_UP >= 2 * math.pi)


_ROUND_UP = 1 + 1e-9


# ---- Hurst exponent --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class HurstEstimate:
    """Hurst exponent of a profile, with its uncertainty and the band of wavelengths that it holds for.

    Attributes
    ----------
    value : float
        H, of a spectrum C1D ∝ q^(-1-2H).
    lower, upper : float
        95 % interval, with the uncertainty of where a roll-off ends if the band was found.
    shortest_wavelength, longest_wavelength : float, µm
        The fitted band.
    harmonics : int
        Harmonics of the profile in the band.
    prefactor : float
        C of the fitted line C q^(-1-2H), in µm and 1/µm; see `density`.
    dispersion : float
        Scatter of the spectrum's bins about the line, as a multiple of what chance gives, squared; at least 1. Much
        above it the spectrum is no straight line, and the interval has been widened by its root.
    """

    value: float
    lower: float
    upper: float
    shortest_wavelength: float
    longest_wavelength: float
    harmonics: int
    prefactor: float
    dispersion: float

    @property
    def fractal_dimension_classical(self) -> float:
        """D = 2 - H, the textbooks' dimension of a profile."""
        return 2 - self.value

    @property
    def fractal_dimension_paper(self) -> float:
        """D = (4 - H) / 2, the measure of Hanaor, Gan & Einav (2016), which `weierstrass_mandelbrot` takes."""
        return (4 - self.value) / 2

    def density(self, wave_number: Floats) -> Floats:
        """The fitted line C1D (µm³) at wave numbers (1/µm)."""
        return np.asarray(self.prefactor * np.asarray(wave_number, dtype=np.float64) ** (-1 - 2 * self.value))


def hurst_exponent_of(
    profile: Profile, *, band: tuple[float, float] | None = None, periodic: bool = False
) -> HurstEstimate:
    r"""Hurst exponent of a profile from its spectrum, by maximum likelihood.

    Parameters
    ----------
    profile : Profile
        Levelling does not matter: unless it is periodic, its least-squares line is taken off.
    band : (float, float), µm, optional
        Shortest and longest wavelength to fit. By default the widest self-affine band that is found; see Notes.
    periodic : bool
        As in `power_spectrum`.

    Raises
    ------
    ValueError
        If the profile is flat, the band has too few harmonics, or none is found.

    Notes
    -----
    The harmonics of a Gaussian profile are independent and their squares exponentially distributed about C(q), so
    the log-likelihood of a power law is -Σ [ln C(q) + P(q)/C(q)] over the band (Whittle). It has one maximum. A line
    through the logarithms would give the many low outliers of an exponential distribution too much weight. The interval
    is where twice the log-likelihood is within 3.84 of its maximum, after division by 35/18 for a Hann window, which
    makes neighbours alike, and by the dispersion of the spectrum about the line. The lowest two harmonics of a windowed
    spectrum are left out, and so is the one at the Nyquist wave number. The interval of a band that was found is
    that over all places at which a roll-off may end: a few harmonics of it cannot be told from the power law.

    The band is found by cutting the spectrum, in bins of log q, into the pieces of separate power laws that explain it
    best at a price for each piece: roll-off, self-affine, cut-off by a tip or a filter, noise. The widest piece with
    0 < H < 1 is taken, or with 0 < H < 2 if there is none, and a bin is left off where it meets another; so is what a
    flat roll-off explains better, and the shortest wavelengths, if white noise below the power law explains them better
    and is more than 10 % of it there. Lines with gaps between them are no piece of this kind. Bends of less than 10 %
    of the density are not told from a power law. Any choice of this kind can err: look at the spectrum.

    The interval is that of a straight spectrum. What bends it gently, it does not know of: in trials of 4096 points,
    noise of a tenth of Pq lowered a found H of 0.8 to 0.74 and one of 0.3 to 0.28 on average, and a moving mean of nine
    points raised them to 0.88 and 0.38.

    Whittle, Arkiv för Matematik 2 (1953) 423.

    Examples
    --------
    >>> from stiction import hurst_exponent_of, self_affine
    >>> found = hurst_exponent_of(self_affine(1, hurst_exponent=0.7, rms=0.1, points=4000, spacing=0.01))
    >>> found.lower < 0.7 < found.upper
    True
    """
    _truth("periodic", periodic)
    _refuse_flat(profile)
    heights = profile.heights - profile.heights.mean()
    if not periodic:
        place = np.arange(heights.size) - (heights.size - 1) / 2
        levelled = heights - place * (heights @ place / (place @ place))
        if not np.abs(levelled).max() > _ROUND_OFF * np.abs(profile.heights).max():
            raise ValueError("a straight line has no roughness")
        heights = levelled
    spectrum = _spectrum(heights / np.abs(heights).max(), profile.spacing, windowed=not periodic)
    used = spectrum.count == 1
    if not periodic:
        used[:_UNTRUSTED] = False
    wave_number, power = spectrum.wave_number[used], spectrum.density[used]
    # What is zero but for round-off: a profile without short wavelengths.
    power = np.maximum(power, np.finfo(float).eps ** 2 * spectrum.density.max())
    alike = 1.0 if periodic else _HANN_ALIKE

    chosen: slice | NDArray[np.bool_]
    if band is None:
        chosen, piece = _self_affine_band(wave_number, power, alike)
        chosen, piece = _above_noise(wave_number, power, alike, chosen, piece)
    else:
        chosen, piece = _given_band(wave_number, band), None
    q, power = wave_number[chosen], power[chosen]
    bins = _Bins.of(q, power)
    exponent = _PowerLaw(np.log(q), power, np.ones(q.size)).exponent
    dispersion = max(1.0, bins.deviance(exponent, bins.count / alike))
    law = _PowerLaw(np.log(q), power, np.full(q.size, 1 / (alike * dispersion)))
    lower, upper = law.interval(law.least_loss + _CHI_SQUARED_95 / 2)
    if piece is not None:  # that a roll-off may be longer or shorter than it seems
        laws = _rolled_off(piece, piece.count / (alike * dispersion))
        most_loss = min(other.least_loss for other in laws) + _CHI_SQUARED_95 / 2
        intervals = [other.interval(most_loss) for other in laws if other.least_loss < most_loss]
        lower = min([lower, *(ends[0] for ends in intervals)])
        upper = max([upper, *(ends[1] for ends in intervals)])
    level = law.log_prefactor + 2 * math.log(np.abs(heights).max())
    return HurstEstimate(
        value=(law.exponent - 1) / 2,
        lower=(lower - 1) / 2,
        upper=(upper - 1) / 2,
        shortest_wavelength=2 * math.pi / float(q[-1]),
        longest_wavelength=2 * math.pi / float(q[0]),
        harmonics=int(q.size),
        prefactor=math.exp(level),
        dispersion=dispersion,
    )


def _given_band(wave_number: Floats, band: tuple[float, float]) -> NDArray[np.bool_]:
    if not isinstance(band, (tuple, list)) or len(band) != 2:
        raise ValueError(f"band must be a shortest and a longest wavelength, got {band!r}")
    shortest = number("band", band[0], unit="µm", above=0)
    chosen = _in_band(wave_number, shortest, number("band", band[1], unit="µm", above=shortest))
    if chosen.sum() < FEWEST_HARMONICS:
        raise ValueError(
            f"band must hold at least {FEWEST_HARMONICS} harmonics of the profile, but {band!r} µm holds "
            f"{int(chosen.sum())}"
        )
    return chosen


FEWEST_HARMONICS = 8
"""To fit a Hurst exponent to."""

_ROUND_OFF = 1e-13
"""Of the largest height, what is left of a straight line after it has been taken off."""

_UNTRUSTED = 2
"""Lowest harmonics after a Hann window: what the window makes of the mean and of what is longer than the profile."""

_HANN_ALIKE = 35 / 18
"""Mean of w⁴ over the square of that of w²: how much the window widens the scatter of sums over many harmonics."""

_CHI_SQUARED_95 = 3.841
"""Its 95 % point, one degree of freedom."""


class _PowerLaw:
    """Likeliest power law P ∝ q^-s through powers that are gamma distributed, their shapes the weights."""

    def __init__(self, log_q: Floats, power: Floats, weight: Floats) -> None:
        self._total = float(weight.sum())
        share = weight / self._total
        self._middle = float(share @ log_q)
        self._log_q = log_q - self._middle
        self._largest = float(power.max())
        self._power = share * power / self._largest
        self.exponent = 0.0
        for _ in range(_NEWTON_STEPS):  # the loss is convex, with a logarithm of a sum of exponentials
            scaled = self._power * np.exp(self.exponent * self._log_q)
            scaled /= scaled.sum()
            gradient = float(scaled @ self._log_q)
            step = gradient / float(scaled @ (self._log_q - gradient) ** 2)
            self.exponent -= min(max(step, -2.0), 2.0)
            if abs(step) < 1e-10:
                break
        self.least_loss = self.loss(self.exponent)

    def _log_level(self, exponent: float) -> float:
        return math.log((self._power * np.exp(exponent * self._log_q)).sum()) + math.log(self._largest)

    def loss(self, exponent: float) -> float:
        """Minus the log-likelihood but for a constant, the prefactor at its best."""
        return self._total * self._log_level(exponent)

    @property
    def log_prefactor(self) -> float:
        return self._log_level(self.exponent) + self.exponent * self._middle

    def interval(self, most_loss: float) -> tuple[float, float]:
        """Exponents between which the loss is not larger than a value above the least."""
        ends = []
        for side in (-1.0, 1.0):
            near, far = 0.0, 0.1
            while self.loss(self.exponent + side * far) < most_loss:
                near, far = far, 2 * far
            for _ in range(_HALVINGS):
                middle = (near + far) / 2
                near, far = (middle, far) if self.loss(self.exponent + side * middle) < most_loss else (near, middle)
            ends.append(self.exponent + side * far)
        return ends[0], ends[1]


_NEWTON_STEPS = 50
_HALVINGS = 30


@dataclass(frozen=True)
class _Bins:
    """A spectrum in bins of equal width in log q: the mean power of so many harmonics."""

    first: NDArray[np.intp]  # harmonic of each bin
    log_q: Floats
    power: Floats
    count: Floats

    @classmethod
    def of(cls, q: Floats, power: Floats) -> _Bins:
        index = np.floor(_BINS_PER_DECADE * np.log10(q / q[0]) + 1e-9)
        first = np.flatnonzero(np.diff(index, prepend=-1))
        count = np.diff(first, append=q.size).astype(np.float64)
        return cls(first, np.add.reduceat(np.log(q), first) / count, np.add.reduceat(power, first) / count, count)

    def part(self, start: int, end: int) -> _Bins:
        return _Bins(self.first[start:end], self.log_q[start:end], self.power[start:end], self.count[start:end])

    def deviance(self, exponent: float, weight: Floats) -> float:
        """Twice the log-likelihood that a line of this exponent falls short of the bins' own means, for each bin."""
        ratio = self.power * np.exp(exponent * (self.log_q - self.log_q.mean()))
        ratio /= np.average(ratio, weights=weight)
        return float(2 * (weight * (ratio - 1 - np.log(ratio))).sum() / max(1, ratio.size - 2))


_BINS_PER_DECADE = 12

_FEWEST_BINS = 4
"""Of a piece of the spectrum that has a power law of its own."""

_BEND = 0.1
"""Relative deviation of a bin that is not told from chance: no measured spectrum is a power law to better than this."""

_PRICE = 10.0
"""Log-likelihood that a further piece must gain: it has three parameters, and its end is sought among some 50 bins."""

_LINES = 10.0
"""Deviance for each bin, about 1 by chance, of what is no spectrum about a mean but lines with gaps between them."""

_NARROWEST = math.log(3)
"""Of a band that is found, in log q: half a decade."""


def _self_affine_band(q: Floats, power: Floats, alike: float) -> tuple[slice, _Bins]:
    """Harmonics of the widest piece of the spectrum that is a self-affine power law; the piece with its roll-off."""
    if q.size >= FEWEST_HARMONICS:
        bins = _Bins.of(q, power)
        weight = 1 / (alike / bins.count + _BEND**2)
        starts, ends, exponents, losses = _pieces(bins, weight)
        pieces = _best_cut(bins.log_q.size, starts, ends, losses)
        for steepest in (3.0, 5.0):  # H = 1, 2
            widest = _NARROWEST
            best: tuple[slice, _Bins] | None = None
            for piece in pieces:
                if not 1 < exponents[piece] < steepest:
                    continue
                start, end = int(starts[piece]), int(ends[piece])  # the bin behind the last
                if bins.part(start, end).deviance(exponents[piece], weight[start:end]) > _LINES:
                    continue
                end -= end < bins.log_q.size
                whole = start + (start > 0)
                start = whole if whole > 0 else _behind_roll_off(bins.part(0, end), weight[:end])
                first = int(bins.first[start])
                last = (int(bins.first[end]) if end < bins.first.size else q.size) - 1
                width = math.log(q[last] / q[first])
                if width > widest and last - first + 1 >= FEWEST_HARMONICS:
                    widest, best = width, (slice(first, last + 1), bins.part(whole, end))
            if best is not None:
                return best
    raise _no_band()


def _no_band() -> ValueError:
    return ValueError(
        "the spectrum of the profile has no self-affine band of half a decade or more (0 < H < 2); name one by band"
    )


def _above_noise(q: Floats, power: Floats, alike: float, chosen: slice, piece: _Bins) -> tuple[slice, _Bins]:
    """A band without its shortest wavelengths where white noise bends the spectrum, and its piece likewise.

    Noise comes up from below over a decade, too smoothly to be a piece with a slope of its own.
    """
    from scipy.optimize import minimize_scalar

    bins = _Bins.of(q[chosen], power[chosen])
    place, weight = bins.log_q - bins.log_q[-1], bins.count / alike

    def loss(exponent: float, noise: float) -> float:
        """Minus the log-likelihood of a power law and noise, which is a multiple of it at the shortest wavelength."""
        shape = np.exp(-exponent * place) + noise
        return float(weight @ np.log(shape) + weight.sum() * math.log(weight @ (bins.power / shape)))

    def best(noise: float) -> tuple[float, float, float]:
        found = minimize_scalar(loss, bounds=(1.0, 5.0), args=(noise,), method="bounded", options={"xatol": 1e-3})
        return float(found.fun), float(found.x), noise

    least, exponent, noise = min(best(noise) for noise in _NOISES)
    if least > best(0.0)[0] - _PARAMETER_PRICE:
        return chosen, piece
    # Where the noise is as much as the law may bend.
    last = math.log(q[chosen][-1]) + min(0.0, math.log(_BEND / noise) / exponent)
    end = int(np.searchsorted(np.log(q), last, side="right"))
    if end - chosen.start < FEWEST_HARMONICS or last - math.log(q[chosen.start]) < _NARROWEST:
        raise _no_band()
    return slice(chosen.start, end), piece.part(0, int(np.searchsorted(piece.log_q, last, side="right")))


_NOISES = tuple(np.geomspace(0.01, 10, 13).tolist())
"""Multiples of the power law at the shortest wavelength."""


def _rolled_off(bins: _Bins, weight: Floats) -> list[_PowerLaw]:
    """Power laws that are flat up to the first bin, the second and so on: the first has no roll-off."""
    breaks = range(max(1, bins.log_q.size - _FEWEST_BINS))
    return [_PowerLaw(np.maximum(bins.log_q, bins.log_q[first]), bins.power, weight) for first in breaks]


def _behind_roll_off(bins: _Bins, weight: Floats) -> int:
    """The first bin of a piece that begins with the longest wavelengths, less what is better explained as flat.

    A roll-off has few harmonics, too few to be told as a piece with a slope of its own.
    """
    losses = [law.least_loss for law in _rolled_off(bins, weight)]
    return int(np.argmin(losses)) if min(losses) < losses[0] - _PARAMETER_PRICE else 0


_PARAMETER_PRICE = 2.0
"""Log-likelihood that a roll-off or noise must gain, which has one parameter more."""


def _pieces(bins: _Bins, weight: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp], Floats, Floats]:
    """Start, end, best exponent and loss of every piece of a binned spectrum."""
    starts, ends = (index.astype(np.intp) for index in np.triu_indices(bins.log_q.size + 1, _FEWEST_BINS))
    laws = [
        _PowerLaw(bins.log_q[start:end], bins.power[start:end], weight[start:end])
        for start, end in zip(starts, ends, strict=True)
    ]
    return starts, ends, np.array([law.exponent for law in laws]), np.array([law.least_loss for law in laws])


def _best_cut(size: int, starts: NDArray[np.intp], ends: NDArray[np.intp], losses: Floats) -> list[int]:
    """The pieces, one after the other, that explain all bins at the least loss and price."""
    best, last_piece = np.full(size + 1, np.inf), np.full(size + 1, -1)
    best[0] = 0.0
    for piece in np.argsort(ends, kind="stable"):
        total = best[starts[piece]] + losses[piece] + _PRICE
        if total < best[ends[piece]]:
            best[ends[piece]], last_piece[ends[piece]] = total, piece
    cut, end = [], size
    while end > 0 and last_piece[end] >= 0:
        cut.append(int(last_piece[end]))
        end = int(starts[cut[-1]])
    return cut[::-1]


# ---- Generators ------------------------------------------------------------------------------------------------------


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
    _truth("periodic", periodic)
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
        if shortest * _ROUND_UP < 2 * spacing:
            raise ValueError(
                f"shortest_wavelength must be at least twice the spacing, {2 * spacing:g} µm, "
                f"got {shortest_wavelength!r}"
            )
    longest = extent
    if longest_wavelength is not None:
        longest = number("longest_wavelength", longest_wavelength, unit="µm", above=shortest)
    if periodic and longest > extent * _ROUND_UP:
        raise ValueError(
            f"longest_wavelength of a periodic profile must be at most its extent, {extent:g} µm, "
            f"got {longest_wavelength!r}"
        )
    period = points
    while not periodic and (period < 2 * points or period * spacing * _ROUND_UP < 4 * longest):
        period *= 2
    if period > MOST_POINTS:
        raise ValueError(
            f"points and longest_wavelength need a period of {period} points, and at most {MOST_POINTS} are allowed"
        )
    harmonics = min((period - 1) // 2, int(period * spacing / shortest * _ROUND_UP))
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
    _truth("periodic", periodic)
    _refuse_flat(profile)
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
