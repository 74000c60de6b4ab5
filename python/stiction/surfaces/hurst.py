"""Hurst exponent of a profile or a surface from its spectrum, and the band of wavelengths that it holds for."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats, number, truth
from stiction._shown import Tabled
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectrum import areal_spectrum, in_band, profile_spectrum
from stiction.surfaces.surface import BodyLike, Surface, as_body, reject_flat

_NEWTON_STEPS, _HALVINGS = 50, 30
MAX_INTERVAL_WIDTH = 0.5  # width of a 95 % interval of H from which on it says little
MIN_HARMONICS = 8
_NO_BAND = "the spectrum has no self-affine band of half a decade or more (0 < H < 2); name one by band"
_ROUND_OFF = 1e-13  # residue of a straight line after it has been subtracted, as a fraction of the largest height
_UNTRUSTED = 2  # lowest harmonics after a Hann window, of the mean and of what is longer than the profile

_HANN_ALIKE = 35 / 18
"""Mean of w⁴ over the square of that of w²: how much the window widens the scatter of sums over many harmonics."""

_CHI_SQUARED_95 = 3.841  # one degree of freedom
_BINS_PER_DECADE = 12
_FEWEST_BINS = 4  # fewest bins of a piece of the spectrum that is given a power law of its own
_BEND = 0.1  # relative deviation of a bin not told from chance: no measured spectrum is a power law to better than this
_PRICE = 10.0  # log-likelihood that a further piece must gain, of three parameters and an end among some 50 bins
_LINES = 10.0  # deviance for each bin, about 1 by chance, of what is no spectrum but lines with gaps between them
_NARROWEST = math.log(3)  # narrowest band that is accepted, in log q: half a decade
_NOISES = tuple(np.geomspace(0.01, 10, 13).tolist())  # multiples of the power law at the shortest wavelength
_PARAMETER_PRICE = 2.0  # log-likelihood that a roll-off or noise must gain, which has one parameter more


class PowerLaw:
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
        """Ln C of the law C q^-s."""
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


@dataclass(frozen=True, repr=False)
class HurstEstimate(Tabled):
    """Hurst exponent of a profile or a surface, with its uncertainty and the band of wavelengths that it holds for.

    Attributes
    ----------
    value : float
        H, of a spectrum C1D ∝ q^(-1-2H) of a profile, C2D ∝ q^(-2-2H) of a surface.
    lower, upper : float
        95 % interval, with the uncertainty of where a roll-off ends if the band was found.
    shortest_wavelength, longest_wavelength : float, µm
        The fitted band.
    harmonics : int
        Harmonics of the profile in the band, or waves of the surface.
    prefactor : float
        C of the fitted line C q^(-n-2H), n the dimensions, in µm and 1/µm; see `density`.
    dispersion : float
        Scatter of the spectrum's bins about the line, as a multiple of what chance gives, squared; at least 1. Much
        above it the spectrum is no straight line, and the interval has been widened by its root.
    dimensions : int
        1 of a profile, 2 of a surface.

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
        """D = 2 - H, the textbooks' dimension of a profile, and of the sections of a surface."""
        return 2 - self.value

    @property
    def fractal_dimension_paper(self) -> float:
        """D = (4 - H) / 2, the measure of Hanaor, Gan & Einav (2016), which `weierstrass_mandelbrot` takes."""
        return (4 - self.value) / 2

    @property
    def interval_classical(self) -> tuple[float, float]:
        """95 % interval of `fractal_dimension_classical`."""
        return 2 - self.upper, 2 - self.lower

    @property
    def interval_paper(self) -> tuple[float, float]:
        """95 % interval of `fractal_dimension_paper`."""
        return (4 - self.upper) / 2, (4 - self.lower) / 2

    @property
    def caution(self) -> str | None:
        """Why the exponent is not to be relied on, in one sentence; None if nothing speaks against it."""
        interval = f"the 95 % interval of H, [{self.lower:.2f}, {self.upper:.2f}],"
        if self.upper - self.lower > MAX_INTERVAL_WIDTH:
            decades = math.log10(self.longest_wavelength / self.shortest_wavelength)
            return f"{interval} says little: the band is {decades:.1f} decades wide"
        if self.value > 1:
            return "H above 1 is not self-affine but smooth: form, a filter, a tip, or waves"
        if self.lower < 0 or self.upper > 1:
            return f"{interval} leaves the range from 0 to 1 of self-affine surfaces"
        return None

    def density(self, wave_number: Floats) -> Floats:
        """The fitted line C1D (µm³) or C2D (µm⁴) at wave numbers (1/µm)."""
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
    r"""Hurst exponent of a profile or a surface from its spectrum, by maximum likelihood.

    Parameters
    ----------
    body : Profile, Surface or array_like
        Heights in an array need their `spacing` (µm, or text such as "39 nm"), and have the `unit`.
        Levelling does not matter: unless it is periodic, its least-squares line or plane is taken off.
    band : (float, float), µm, optional
        Shortest and longest wavelength to fit. By default the widest self-affine band that is found; see Notes.
    periodic : bool
        As in `power_spectrum`.

    Raises
    ------
    ValueError
        If the body is flat, the band has too few harmonics, or none is found.

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

    Of a surface, the harmonics are the waves of its spectrum in all directions up to the smaller Nyquist wave number,
    whose powers are multiplied by q to fall as those of a profile; the rest is the same, with the square of 35/18. One
    line's spectrum bends within an octave of a cut-off of the surface, because a line cuts short waves obliquely; the
    surface's does not. Where the surface has a lay, this is the exponent of the mean over directions.

    Whittle, Arkiv för Matematik 2 (1953) 423.

    Examples
    --------
    >>> from stiction import estimate_hurst_exponent, self_affine
    >>> found = estimate_hurst_exponent(self_affine(1, hurst_exponent=0.7, rms=0.1, points=4000, spacing=0.01))
    >>> found.lower < 0.7 < found.upper
    True
    """
    body = as_body("body", body, spacing=spacing, unit=unit)
    truth("periodic", periodic)
    reject_flat(body)
    if isinstance(body, Profile):
        dimensions, (wave_number, power, scale) = 1, _harmonics(body, periodic)
    else:
        dimensions, (wave_number, power, scale) = 2, _waves(body, periodic)
    alike = 1.0 if periodic else _HANN_ALIKE**dimensions

    chosen: slice | NDArray[np.bool_]
    if band is None:
        chosen, piece = _self_affine_band(wave_number, power, alike)
        chosen, piece = _above_noise(wave_number, power, alike, chosen, piece)
    else:
        if not isinstance(band, (tuple, list)) or len(band) != 2:
            raise ValueError(f"band must be a shortest and a longest wavelength, got {band!r}")
        shortest = number("band", band[0], unit="µm", above=0)
        chosen, piece = in_band(wave_number, shortest, number("band", band[1], unit="µm", above=shortest)), None
        if (count := int(chosen.sum())) < MIN_HARMONICS:
            raise ValueError(f"band must hold at least {MIN_HARMONICS} harmonics, but {band!r} µm holds {count}")
    q, power = wave_number[chosen], power[chosen]
    bins = _Bins.of(q, power)
    exponent = PowerLaw(np.log(q), power, np.ones(q.size)).exponent
    dispersion = max(1.0, bins.deviance(exponent, bins.count / alike))
    law = PowerLaw(np.log(q), power, np.full(q.size, 1 / (alike * dispersion)))
    lower, upper = law.interval(law.least_loss + _CHI_SQUARED_95 / 2)
    if piece is not None:  # that a roll-off may be longer or shorter than it seems
        laws = _rolled_off(piece, piece.count / (alike * dispersion))
        most_loss = min(other.least_loss for other in laws) + _CHI_SQUARED_95 / 2
        intervals = [other.interval(most_loss) for other in laws if other.least_loss < most_loss]
        lower = min([lower, *(ends[0] for ends in intervals)])
        upper = max([upper, *(ends[1] for ends in intervals)])
    level = law.log_prefactor + 2 * math.log(scale)
    return HurstEstimate(
        value=(law.exponent - 1) / 2, lower=(lower - 1) / 2, upper=(upper - 1) / 2,
        shortest_wavelength=2 * math.pi / float(q[-1]), longest_wavelength=2 * math.pi / float(q[0]),
        harmonics=int(q.size), prefactor=math.exp(level), dispersion=dispersion, dimensions=dimensions,
    )  # fmt: skip


def _harmonics(profile: Profile, periodic: bool) -> tuple[Floats, Floats, float]:
    """Wave numbers and powers to fit, and the height that these are taken in."""
    heights = profile.heights - profile.heights.mean()
    if not periodic:
        place = np.arange(heights.size) - (heights.size - 1) / 2
        tilted = heights - place * (heights @ place / (place @ place))
        if not np.abs(tilted).max() > _ROUND_OFF * np.abs(profile.heights).max():
            raise ValueError("a straight line has no roughness")
        heights = tilted
    scale = float(np.abs(heights).max())
    spectrum = profile_spectrum(heights / scale, profile.spacing, windowed=not periodic)
    used = spectrum.count == 1
    if not periodic:
        used[:_UNTRUSTED] = False
    # What is zero but for round-off: a profile without short wavelengths.
    power = np.maximum(spectrum.density[used], np.finfo(float).eps ** 2 * spectrum.density.max())
    return spectrum.wave_number[used], power, scale


def _waves(surface: Surface, periodic: bool) -> tuple[Floats, Floats, float]:
    """Wave numbers and powers of a surface to fit; powers times wave numbers, which fall as those of a profile."""
    heights = surface.heights - surface.heights.mean()
    if not periodic:
        heights = levelled(surface, "plane").heights
        if not heights.any():
            raise ValueError("a plane has no roughness")
    scale = float(np.abs(heights).max())
    spectrum = areal_spectrum(heights / scale, surface.spacing, windowed=not periodic)
    wave_number, _, density = spectrum.waves()
    used = np.full(wave_number.shape, True)
    if not periodic:
        used = wave_number > (_UNTRUSTED + 0.5) * 2 * math.pi / min(surface.extent)
    density = np.maximum(density, np.finfo(float).eps ** 2 * density.max())
    return wave_number[used], (density * wave_number)[used], scale


@dataclass(frozen=True)
class _Bins:
    """A spectrum in bins of equal width in log q: mean power, and number of harmonics."""

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


def _self_affine_band(q: Floats, power: Floats, alike: float) -> tuple[slice, _Bins]:
    """Harmonics of the widest piece of the spectrum that is a self-affine power law; the piece with its roll-off."""
    if q.size >= MIN_HARMONICS:
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
                if start == 0:  # less a roll-off that is too short for a piece
                    rolled = [law.least_loss for law in _rolled_off(bins.part(0, end), weight[:end])]
                    start = int(np.argmin(rolled)) if min(rolled) < rolled[0] - _PARAMETER_PRICE else 0
                else:
                    start = whole
                first = int(bins.first[start])
                last = (int(bins.first[end]) if end < bins.first.size else q.size) - 1
                width = math.log(q[last] / q[first])
                if width > widest and last - first + 1 >= MIN_HARMONICS:
                    widest, best = width, (slice(first, last + 1), bins.part(whole, end))
            if best is not None:
                return best
    raise ValueError(_NO_BAND)


def _above_noise(q: Floats, power: Floats, alike: float, chosen: slice, piece: _Bins) -> tuple[slice, _Bins]:
    """A band and its piece without the shortest wavelengths where white noise bends the spectrum."""
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
    if end - chosen.start < MIN_HARMONICS or last - math.log(q[chosen.start]) < _NARROWEST:
        raise ValueError(_NO_BAND)
    return slice(chosen.start, end), piece.part(0, int(np.searchsorted(piece.log_q, last, side="right")))


def _rolled_off(bins: _Bins, weight: Floats) -> list[PowerLaw]:
    """Power laws that are flat up to the first bin, the second and so on: the first has no roll-off."""
    breaks = range(max(1, bins.log_q.size - _FEWEST_BINS))
    return [PowerLaw(np.maximum(bins.log_q, bins.log_q[first]), bins.power, weight) for first in breaks]


def _pieces(bins: _Bins, weight: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp], Floats, Floats]:
    """Start, end, best exponent and loss of every piece of a binned spectrum."""
    starts, ends = (index.astype(np.intp) for index in np.triu_indices(bins.log_q.size + 1, _FEWEST_BINS))
    laws = [
        PowerLaw(bins.log_q[start:end], bins.power[start:end], weight[start:end])
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
