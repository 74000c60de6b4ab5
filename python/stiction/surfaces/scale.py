"""Scale-dependent slope and curvature, and the wavelength limit of the instrument."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, check_bool, float_array, number, read_only
from stiction._repr import TableRepr, TextRepr
from stiction.surfaces.filters import transmission
from stiction.surfaces.harmonics import MIN_HARMONIC_DISTANCE, between_harmonics, find_period
from stiction.surfaces.hurst import HurstEstimate
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectrum import power_spectrum, surface_spectrum
from stiction.surfaces.surface import BodyLike, Surface, as_body, reject_flat

TIP_FACTOR = 0.1  # c of `instrument_limit`: a tip of radius R resolves an rms curvature below c/R
_PER_DECADE = 48  # wave number bins per decade for slope and curvature
_PER_OCTAVE = 8  # wave number bins per octave in the search for instrument noise
_WIDTHS = (1.0, 2.0)  # octaves over which a spectral exponent is fitted
_DEVIATIONS = 3.0  # standard deviations by which an exponent must differ from that of the roughest self-affine surface
_NEAR = 24.0  # points of the longest wave at which a hump is the instrument's; above, it is texture if all falls behind
_ABOVE = 4.0  # density of the last trusted waves over the lowest of the spectrum: less, and noise is a part of them
_RISE = 3.0  # density over the lowest of all longer waves, by which no surface's spectrum rises
MAX_UNKNOWN_FRACTION = 0.1  # share of the mean square slope in waves of unknown origin above which no number is quoted
CUTOFF_MARGIN = (
    1.9  # cut-off over the wavelength of what must be taken off: a Gaussian filter leaves 8 % of its amplitude
)
_LEAST_SHARE = 1e-4  # smallest share of the mean square slope that is of an instrument and not of round-off
_FOLDED = 0.6  # exponent of the last octave of a rough surface, with what is folded back at the Nyquist wave number
_ROUNDED = 0.3  # share of the mean square second difference from which on rounding explains a noise floor
_FLAT = 0.35  # exponent of a flat spectrum, and rms of the logarithm of its density, at most
_HARDLY_FALLING = 0.7  # exponent over all wavelengths of a floor, some of which are partly the surface's
_CLEAR_OF_SURFACE = 0.7  # wavelength over the limit below which a spectrum is that of the noise alone
INSTRUMENT_REASONS = ("noise floor", "quantisation")  # reasons that are the instrument's whatever the surface is
_FINEST = 1e-6  # fraction of the shortest wave of the scan, as far as a power law is followed
_HALVINGS = 60

Origin = Literal["instrument", "unknown"]

Spectrum = tuple[Floats, Floats, Floats, float]
"""Wave numbers, densities, and numbers of independent values of a spectrum, and the spacing of its points."""


@dataclass(frozen=True, eq=False, repr=False)
class ScaleDependentRoughness(TextRepr):
    """Root-mean-square slope and curvature over all wavelengths from the longest down to a given one.

    Attributes
    ----------
    wavelength : (n,) ndarray of float, µm
        Descending, from the longest to the shortest wavelength of the grid.
    gradient : (n,) ndarray of float
        h'_rms of all waves of at least the wavelength: of a surface its gradient over all directions, of a profile its
        slope.
    curvature : (n,) ndarray of float, 1/µm
        h''_rms of the same waves: of a surface the mean curvature, half of the Laplacian.
    dimensions : int
        1 of a profile, 2 of a surface.

    Examples
    --------
    >>> from stiction import scale_dependent_roughness, self_affine_surface
    >>> surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1)
    >>> scale_dependent_roughness(surface)
    ScaleDependentRoughness
      wavelength  58: 0.1414 to 6.4 µm
      gradient    58: 0.006932 to 0.0703
      curvature   58: 0.003403 to 0.5512 1/µm
      dimensions  2
    """

    wavelength: Floats = field(metadata={"unit": "µm"})
    gradient: Floats
    curvature: Floats = field(metadata={"unit": "1/µm"})
    dimensions: int

    def gradient_at(self, wavelength: ArrayLike) -> Floats:
        """h'_rms of the waves of at least a wavelength (µm), of any shape; that of all waves below the shortest."""
        return _between(self.wavelength, self.gradient, wavelength)

    def curvature_at(self, wavelength: ArrayLike) -> Floats:
        """h''_rms (1/µm) of the waves of at least a wavelength (µm), as `gradient_at`."""
        return _between(self.wavelength, self.curvature, wavelength)

    def fraction_below(self, wavelength: ArrayLike) -> Floats:
        """Fraction of the mean square slope that is of waves shorter than a wavelength (µm)."""
        return np.asarray(1 - np.square(self.gradient_at(wavelength) / self.gradient[-1]))

    def continued(self, wavelength: ArrayLike, estimate: HurstEstimate) -> Floats:
        r"""h'_rms down to wavelengths (µm) that the scan does not resolve, by the power law of a Hurst exponent.

        Notes
        -----
        Down to the shortest wavelength of the fitted band it is `gradient_at`; what is finer is added by the fitted
        line,

        .. math:: h'(λ)^2 = h'(λ_b)^2 + \frac{1}{nπ} \int_{2π/λ_b}^{2π/λ} q^{n+1} C(q)\,dq, \qquad C ∝ q^{-n-2H}

        with n = 1 for profiles and 2 for surfaces.
        """
        wanted = float_array("wavelength", wavelength)
        shortest = estimate.shortest_wavelength
        measured = self.gradient_at(np.maximum(wanted, shortest))
        finer = np.minimum(wanted, shortest)
        return np.asarray(np.sqrt(np.square(measured) + extrapolated_slope(estimate, finer)))

    def wavelength_of(self, gradient: float, estimate: HurstEstimate | None = None) -> float:
        """Wavelength (µm) down to which waves have an rms gradient, continued by a Hurst exponent if one is given.

        The longest where that has it already; NaN where no wavelength has, of a power law down to a millionth of the
        scan's shortest.
        """
        wanted = number("gradient", gradient, above=0)
        finest = self.wavelength[-1] * (1.0 if estimate is None else _FINEST)
        low, high = math.log(finest), math.log(self.wavelength[0])

        def value(place: float) -> float:
            length = math.exp(place)
            return float(self.gradient_at(length) if estimate is None else self.continued(length, estimate))

        if value(low) < wanted:
            return math.nan
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if value(middle) >= wanted else (low, middle)
        return math.exp((low + high) / 2)


def interval_power_laws(estimate: HurstEstimate) -> tuple[HurstEstimate, HurstEstimate, HurstEstimate]:
    """Return the fitted power law, and those with the lower and upper exponent through the centre of the band."""
    middle = 2 * math.pi / math.sqrt(estimate.shortest_wavelength * estimate.longest_wavelength)
    lower, upper = (
        replace(estimate, value=value, prefactor=estimate.prefactor * middle ** (2 * (value - estimate.value)))
        for value in (estimate.lower, estimate.upper)
    )
    return estimate, lower, upper


def extrapolated_slope(estimate: HurstEstimate, wavelength: Floats) -> Floats:
    """Return the mean square slope between a wavelength (µm) and the shortest of the band, by the power law."""
    exponent = 2 - 2 * estimate.value
    start, end = 2 * math.pi / estimate.shortest_wavelength, 2 * math.pi / np.asarray(wavelength)
    ratio = np.log(end / start)
    # (end^x - start^x)/x, also at x = 0.
    grown = start**exponent * (np.expm1(exponent * ratio) / exponent if exponent != 0 else ratio)
    return np.asarray(estimate.prefactor / (estimate.dimensions * math.pi) * grown)


def scale_dependent_roughness(
    body: BodyLike, *, periodic: bool = False, spacing: Any = None, unit: str = "um"
) -> ScaleDependentRoughness:
    r"""Compute the rms slope and curvature of a body as functions of the shortest included wavelength.

    Parameters
    ----------
    body : Profile, Surface or array_like
        Heights in an array need their `spacing` (µm, or text such as "39 nm"), and have the `unit`.
        The least-squares line or plane is subtracted unless the body is periodic.
    periodic : bool
        As for `power_spectrum`.

    Notes
    -----
    .. math:: h'(λ)^2 = \frac1{4π^2} \int_{q<2π/λ} q^2 C^{2D} d^2q, \qquad
              h''(λ)^2 = \frac1{16π^2} \int_{q<2π/λ} q^4 C^{2D} d^2q

    for surfaces; :math:`\frac1π \int q^2 C^{1D} dq` and :math:`\frac1π \int q^4 C^{1D} dq` for profiles. Sanner,
    Nöhring, Thimons, Jacobs & Pastewka, Applied Surface Science Advances 7 (2022) 100190, explain why
    a slope depends on the scale.

    Examples
    --------
    >>> from stiction import scale_dependent_roughness, self_affine_surface
    >>> surface = self_affine_surface(1, hurst_exponent=0.8, rms=0.05, shape=(256, 256), spacing=0.04)
    >>> found = scale_dependent_roughness(surface, periodic=True)
    >>> float(found.fraction_below(0.16).round(2))
    0.26
    """
    check_bool("periodic", periodic)
    body = as_body("body", body, spacing=spacing, unit=unit)
    reject_flat(body)
    q, weight = mean_square_heights(body, periodic=periodic)
    dimensions, curved = (1, 1.0) if isinstance(body, Profile) else (2, 0.25)
    index = np.floor(_PER_DECADE * np.log10(q / q.min()) + 1e-9).astype(np.intp)
    count = np.bincount(index)
    there = count > 0
    finest = np.zeros(count.size)
    np.maximum.at(finest, index, q)
    sums = [np.bincount(index, q**power * weight)[there].cumsum() for power in (2, 4)]
    return ScaleDependentRoughness(
        wavelength=read_only(2 * math.pi / finest[there]), gradient=read_only(np.sqrt(sums[0])),
        curvature=read_only(np.sqrt(curved * sums[1])), dimensions=dimensions,
    )  # fmt: skip


def mean_square_heights(body: Profile | Surface, *, periodic: bool = False) -> tuple[Floats, Floats]:
    """Return wave numbers (1/µm) and their mean square heights (µm²), levelled unless the body is periodic."""
    if isinstance(body, Profile):
        line = power_spectrum(body if periodic else levelled(body, "line"), periodic=periodic)
        return line.wave_number, line.density * line.count * (line.resolution / math.pi)
    area = surface_spectrum(body if periodic else levelled(body, "plane"), periodic=periodic)
    q = np.hypot(area.wave_number_y[:, np.newaxis], area.wave_number_x).ravel()
    step = float(area.wave_number_y[1] - area.wave_number_y[0]) * float(area.wave_number_x[1] - area.wave_number_x[0])
    weight = area.density.ravel() * (step / (4 * math.pi**2))
    return q[q > 0], weight[q > 0]


def _between(wavelength: Floats, values: Floats, wanted: ArrayLike) -> Floats:
    """Interpolate log-log at other wavelengths; zero above the longest wavelength."""
    at = float_array("wavelength", wanted)
    if not (at > 0).all():
        raise ValueError(f"wavelength must be above 0 µm, got {wanted!r}")
    with np.errstate(divide="ignore"):
        found = np.exp(np.interp(-np.log(at), -np.log(wavelength), np.log(values)))
    return np.asarray(np.where(at > wavelength[0] * (1 + 1e-9), 0.0, found))


@dataclass(frozen=True, repr=False)
class InstrumentLimit(TableRepr):
    """The wavelength below which a scan is of the instrument rather than of the surface.

    Attributes
    ----------
    wavelength : float, µm
        The largest of those below.
    reason : str
        Which it is: "pixels", "tip", or what the noise looks like: "noise floor", "quantisation", "line", "roll-up"
        at the shortest waves, or "hump".
    pixels : float, µm
        Two points of the coarser spacing.
    noise : float, µm
        From which on, towards shorter waves, the spectrum is no surface's; NaN without such an end.
    tip : float, µm
        Below which the curvature is more than the tip follows; NaN without a tip radius, or if it follows all.
    noise_x, noise_y : float, µm
        Of a surface, `noise` of its lines along x and along y.
    slope_fraction, curvature_fraction : float
        Share of the mean square slope and curvature in waves below `wavelength`; 0 if that is of the pixels.
    cut_off : float, µm
        The wavelength at which `cut_off` leaves the mean square slope of the waves that are to be trusted, of which it
        takes a part; at least two points.
    origin : {"instrument", "unknown"}
        Origin of the waves below `wavelength`: "unknown" of a line, a roll-up or a hump, and of a floor below the
        harmonics of a texture.
    period : float, µm
        Period of a texture whose harmonics stand in the spectrum, of a surface along x or y; NaN without one.

    Examples
    --------
    >>> from stiction import instrument_limit, self_affine
    >>> smooth = self_affine(1, hurst_exponent=0.8, rms=0.1, points=4096, spacing=0.01, shortest_wavelength=0.5)
    >>> limit = instrument_limit(smooth)
    >>> limit.wavelength >= limit.pixels
    True
    """

    wavelength: float = field(metadata={"unit": "µm"})
    reason: str
    pixels: float = field(metadata={"unit": "µm"})
    noise: float = field(metadata={"unit": "µm"})
    tip: float = field(metadata={"unit": "µm"})
    noise_x: float = field(default=math.nan, metadata={"unit": "µm"})
    noise_y: float = field(default=math.nan, metadata={"unit": "µm"})
    slope_fraction: float = 0.0
    curvature_fraction: float = 0.0
    cut_off: float = field(default=math.nan, metadata={"unit": "µm"})
    origin: Origin = "instrument"
    period: float = field(default=math.nan, metadata={"unit": "µm"})

    @property
    def matters(self) -> bool:
        """Whether wavelengths below the limit contribute more than a tenth of the mean square slope."""
        return self.slope_fraction > MAX_UNKNOWN_FRACTION


def instrument_limit(
    body: Profile | Surface, *, tip_radius: float | None = None, periodic: bool = False, texture: bool = False
) -> InstrumentLimit:
    """Find the wavelength below which a scan is unreliable because of its pixels, noise or tip.

    Parameters
    ----------
    body : Profile or Surface
    tip_radius : float, µm, optional
        Of the stylus or the probe.
    periodic : bool
        As for `power_spectrum`.
    texture : bool
        Whether lines and humps in the spectrum are known to be the surface's, as of a turned or milled one. A flat end
        of the spectrum is the instrument's all the same.

    Notes
    -----
    The spectrum of a self-affine surface falls along a line as q^-(1+2H), with an exponent of -1 to -3, and steeper
    where it is smooth. One that has fallen and is then shallower than -1 over one or two octaves, by three standard
    deviations, or that rises to three times its lowest, is of something else: noise, a line, ringing, quantisation, or
    the texture of a machined surface. A flat end of the spectrum is noise of the instrument. The limit is where the
    density is four times its lowest, so that h' of the waves that are kept is right within 5 %. Lines, humps and
    spectra that rise at their end are of unknown origin, but these are texture:

    - Harmonics of one period, all of them or the odd ones, as feeds leave them. The spectrum is then judged between
      the harmonics, and not at all if these are less than 10 bins apart.
    - A hump further up than 24 points, if the spectrum falls behind it.
    - A hump in one line. Lines of a map along straight grooves are copies of each other and count as one: the number
      of independent lines is estimated from the spectrum across them.

    A line that two surfaces share is no mark of texture, because one instrument may have left it in both. Noise whose
    spectrum falls like a surface's, as pink noise, cannot be told from one; two scans of one place tell it. The optics
    of an instrument, which cut waves off well above its pixels, are not seen: then the spectrum falls faster, and H
    above 1 is found.

    A tip of radius R cannot follow curvatures above 1/R; h''_rms(λ) must be below c/R (Jacobs, Junge &
    Pastewka, Surface Topography: Metrology and Properties 5 (2017) 013001; Sanner et al., Applied Surface Science
    Advances 7 (2022) 100190). They take c of about 1/2; here it is 0.1, at which a simulated tip takes a tenth of the
    spectrum. At 1/2 it leaves a third of it.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, instrument_limit, self_affine
    >>> smooth = self_affine(1, hurst_exponent=0.8, rms=0.1, points=4096, spacing=0.01, shortest_wavelength=0.5)
    >>> noisy = Profile(smooth.heights + 1e-4 * np.random.default_rng(1).normal(size=4096), spacing=0.01)
    >>> instrument_limit(noisy).reason
    'noise floor'
    """
    radius = None if tip_radius is None else number("tip_radius", tip_radius, unit="µm", above=0)
    roughness = scale_dependent_roughness(body, periodic=periodic)
    spacing = max(body.spacings)
    spectra = _line_spectra(body, periodic)
    found = [_foreign_waves(*each, periodic=periodic, textured=texture) for each in spectra]
    whole = sum(float(np.square(q) @ density) * float(q[0]) / math.pi for q, density, *_ in spectra)
    # An axis along which a surface is straight has nothing but round-off.
    along = [each.wave if each.slope > _LEAST_SHARE * whole else math.nan for each in found]
    first = int(np.nanargmax(along)) if np.isfinite(along).any() else 0
    noise, kind = along[first], found[first].kind
    period = next((each.period for each in found if each.period > 0), math.nan)
    if not float(roughness.fraction_below(noise if noise > 0 else 2 * spacing)) > _LEAST_SHARE:
        noise = math.nan
    origin: Origin = (
        "unknown" if kind not in INSTRUMENT_REASONS or (found[first].period > 0 and not texture) else "instrument"
    )
    if kind == "noise floor" and noise > 0 and _is_quantised(body):
        kind = "quantisation"
    noise = round_up_wavelength(noise) if noise > 0 else noise
    limits = {"pixels": 2 * spacing, kind: noise, "tip": math.nan}
    if radius is not None and (sharp := roughness.curvature > TIP_FACTOR / radius).any():
        limits["tip"] = float(roughness.wavelength[int(np.argmax(sharp))])
    reason = max((name for name in limits if not math.isnan(limits[name])), key=lambda name: limits[name])
    wave, shares, cut = limits[reason], (0.0, 0.0), 2 * spacing
    if reason != "pixels":
        bent = float(roughness.curvature_at(wave) / roughness.curvature[-1])
        share = float(roughness.fraction_below(wave))
        if reason == kind and period > 0:  # shorter waves are harmonics of the texture as well
            share = min(share, sum(each.slope for each in found) / whole)
        shares = share, 1 - bent**2
        cut = _slope_kept(roughness, shares[0], wave, cut)
    along_x, along_y = along if len(along) == 2 else (math.nan, math.nan)
    return InstrumentLimit(
        wave, reason, limits["pixels"], noise, limits["tip"], along_x, along_y, *shares, cut,
        origin if reason == kind else "instrument", period,
    )  # fmt: skip


def round_up_wavelength(wavelength: float) -> float:
    """Round a wavelength up to three significant digits."""
    digit = 10.0 ** (math.floor(math.log10(wavelength)) - 2)
    return round(math.ceil(wavelength / digit - 1e-9) * digit, 12)


def _slope_kept(roughness: ScaleDependentRoughness, share: float, longest: float, shortest: float) -> float:
    """Return the cutoff between two wavelengths that removes a given fraction of the mean square slope."""
    q, slope = 2 * math.pi / roughness.wavelength, np.diff(np.square(roughness.gradient), prepend=0.0)
    low, high = math.log(shortest), math.log(max(longest, shortest))
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        kept = float(slope @ np.square(transmission(q, math.exp(middle)))) / float(slope.sum())
        low, high = (middle, high) if kept > 1 - share else (low, middle)
    return max(shortest, float(f"{math.exp(high):.1e}"))  # two digits, which two scans of a kind share


def _line_spectra(body: Profile | Surface, periodic: bool) -> list[Spectrum]:
    """Return the spectrum of a profile, or the mean spectra of the lines of a surface along x and along y."""
    if isinstance(body, Profile):
        line = power_spectrum(body if periodic else levelled(body, "line"), periodic=periodic)
        return [(line.wave_number, line.density, line.count, body.spacing)]
    heights = body.heights if periodic else levelled(body, "plane").heights
    spectra = []
    for axis in (1, 0):
        along = heights if axis else heights.T
        points, step = along.shape[1], body.spacing[axis]
        window = 1.0 if periodic else (1 - np.cos(2 * math.pi * np.arange(points) / points)) / math.sqrt(1.5)
        transform = np.fft.rfft((along - along.mean(axis=1, keepdims=True)) * window)[:, 1:]
        power = np.square(np.abs(transform)).mean(axis=0)
        q = 2 * math.pi * np.arange(1, power.size + 1) / (points * step)
        spectra.append((q, power * (step / points), _independent_lines(transform), step))
    return spectra


def _independent_lines(transform: NDArray[np.complex128]) -> Floats:
    """Estimate how many lines of a surface are independent, at each wave number along them.

    The mean over lines of a spectrum has the relative variance sum(P²)/sum(P)² of the powers P across the lines. Lines
    along straight grooves are copies of each other and count as one. P itself is exponentially distributed, hence the
    factor 2.
    """
    power = np.square(np.abs(np.fft.fft(transform, axis=0)))
    squares = np.square(power).sum(axis=0)
    whole = np.square(power.sum(axis=0))
    return np.asarray(np.maximum(2 * whole / np.where(squares > 0, squares, 1.0) - 1, 1.0))


class _Foreign(NamedTuple):
    """Part of a line spectrum that is not attributed to the surface."""

    wave: float  # µm, limit of this part; NaN if there is none
    kind: str
    slope: float  # mean square slope of lines in these waves, harmonics of a texture left out
    period: float  # µm, of a texture; NaN without one


def _foreign_waves(
    q: Floats, density: Floats, count: Floats, spacing: float, *, periodic: bool, textured: bool
) -> _Foreign:
    """Find the wavelengths not attributed to the surface, after removing the harmonics of a texture."""
    first, distance = find_period(density)
    period = 2 * math.pi / (float(q[0]) * first)
    if first > 0:
        if distance < MIN_HARMONIC_DISTANCE:
            return _Foreign(math.nan, "noise floor", 0.0, period)
        # Cusps of uneven depth have a hump about the first harmonic.
        finer = slice(int(first), None)
        density, q, count = between_harmonics(density, count, distance)[finer], q[finer], count[finer]
    wave, kind = _noise_of(q, density, count, spacing, periodic=periodic)
    if not wave > 0 or (textured and kind not in INSTRUMENT_REASONS):
        return _Foreign(math.nan, kind, 0.0, period)
    below = q * wave > 2 * math.pi
    slope = float((np.square(q) * density)[below].sum() * (q[1] - q[0]) / math.pi)
    return _Foreign(wave, kind, slope, period)


def _noise_of(q: Floats, density: Floats, count: Floats, spacing: float, *, periodic: bool) -> tuple[float, str]:
    """Return the limit (µm) and kind of noise in a spectrum without harmonics; NaN if there is no noise."""
    nothing = math.nan, "noise floor"
    if not periodic:  # the window's own
        q, density, count = q[2:], density[2:], count[2:]
    if q.size < _PER_OCTAVE:
        return nothing
    _, index = np.unique(np.floor(_PER_OCTAVE * np.log2(q / q[0]) + 1e-9), return_inverse=True)
    number = np.bincount(index, count)
    density = np.bincount(index, count * density) / number
    wave = 2 * math.pi * np.exp(-np.bincount(index, count * np.log(q)) / number)
    density = np.maximum(density, 1e-12 * density.max())
    chance = (1.0 if periodic else 35 / 18) / number
    laws = [list(_exponents(-np.log(wave), np.log(density), chance, width)) for width in _WIDTHS]
    if _slope(-np.log(wave), np.log(density), chance)[0] > -_FLAT:
        return float(wave[0]), "noise floor"
    last = wave <= 2.01 * wave[-1]
    end, deviation = _slope(-np.log(wave[last]), np.log(density[last]), chance[last])
    places = [_lowest(law, wave / spacing, density, chance) for law in laws]
    places.append(_before_a_rise(wave / spacing, density, chance))
    if end - 2 * deviation > -_FOLDED:
        places.append(int(np.argmin(np.where(last, density, math.inf))))
    if not any(place is not None for place in places):
        return nothing
    place = min(place for place in places if place is not None)
    higher = np.flatnonzero(density[: place + 1] >= _ABOVE * density[place])
    trusted = int(higher[-1]) if higher.size else 0
    limit = math.sqrt(wave[trusted] * wave[min(trusted + 1, place)])
    behind = place + np.flatnonzero(density[place:] > 2 * density[place])
    if behind.size:
        limit = max(limit, CUTOFF_MARGIN * float(wave[behind[0]]))
    if behind.size and np.sum(density[place:] > density[place:].max() / 4) <= 2:
        return limit, "line"
    if _is_floor(wave, density, chance, limit):
        return limit, "noise floor"
    if behind.size and wave[behind[0]] < 1.4 * wave[-1]:
        return limit, "roll-up"
    return limit, "hump"


def _slope(x: Floats, y: Floats, variance: Floats) -> tuple[float, float]:
    """Fit a straight line to values of given variances; return its slope and standard deviation."""
    weight = 1 / (variance + 0.01)
    about = x - np.average(x, weights=weight)
    square = float(weight @ about**2)
    return float(weight @ (about * y)) / square, 1 / math.sqrt(square)


def _is_floor(wave: Floats, density: Floats, chance: Floats, limit: float) -> bool:
    """Return whether a spectrum ends flat, and hardly falls on the way from a limiting wavelength (µm) to the end."""
    for longest, steepest in ((_CLEAR_OF_SURFACE * limit, _HARDLY_FALLING), (2.01 * float(wave[-1]), _FLAT)):
        here = wave < longest
        if here.sum() < _PER_OCTAVE // 2:
            return False
        x, y, variance = -np.log(wave[here]), np.log(density[here]), chance[here]
        slope, deviation = _slope(x, y, variance)
        weight = 1 / (variance + 0.01)
        scatter = np.square(y - np.average(y, weights=weight)) - variance
        if not abs(slope) < max(steepest, 2 * deviation) or np.average(scatter, weights=weight) > _FLAT**2:
            return False
    return True


def _exponents(x: Floats, y: Floats, chance: Floats, octaves: float) -> Iterator[tuple[int, int, float, float]]:
    """Yield first bin, exclusive end, exponent and standard deviation of every window of `octaves` octaves."""
    width = octaves * math.log(2)
    for first in range(x.size):
        end = int(np.searchsorted(x, x[first] + width + 1e-6))
        if end - first >= _PER_OCTAVE // 2 and x[end - 1] - x[first] > 0.85 * width:
            yield first, end, *_slope(x[first:end], y[first:end], chance[first:end])


def _lowest(law: list[tuple[int, int, float, float]], points: Floats, density: Floats, chance: Floats) -> int | None:
    """Return the lowest bin where a decreasing spectrum stops decreasing like that of a surface."""
    has_fallen = False
    for first, end, exponent, deviation in law:
        if exponent + _DEVIATIONS * deviation < -1:
            has_fallen = True
        elif has_fallen and exponent - _DEVIATIONS * deviation > -1:
            behind = _slope(-np.log(points[first:]), np.log(density[first:]), chance[first:])[0]
            if points[first] <= _NEAR or behind > -1:
                return first + int(np.argmin(density[first:end]))
    return None


def _before_a_rise(points: Floats, density: Floats, chance: Floats) -> int | None:
    """Return the lowest bin before a strong rise near the resolution, or None."""
    lowest, place = math.inf, 0
    for at in np.flatnonzero(chance < 1 / 4):
        if points[at] <= _NEAR and place and density[at] > max(_RISE, 1 + 5 * math.sqrt(chance[at])) * lowest:
            return place
        bound = float(density[at]) * (1 + 3 * math.sqrt(chance[at]))
        if bound < lowest:
            lowest, place = bound, int(at)
    return None


def _is_quantised(body: Profile | Surface) -> bool:
    """Return whether the heights have so few levels that rounding explains the noise."""
    steps = np.diff(np.unique(body.heights))
    bends = float(np.square(np.diff(body.heights, 2)).mean())
    # Rounding to a step has a twelfth of its square as variance, and second differences of white noise six times that.
    return bool(steps.size < body.heights.size / 4 and np.median(steps) ** 2 / 2 > _ROUNDED * bends)
