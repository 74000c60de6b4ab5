"""Slope and curvature over wavelength, and the wavelength below which a scan is not to be trusted."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, float_array, number, read_only, truth
from stiction._shown import Readable, Tabled
from stiction.surfaces.hurst import HurstEstimate
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectrum import power_spectrum, surface_spectrum
from stiction.surfaces.surface import Surface, refuse_flat

TIP_FACTOR = 0.1
"""c of Jacobs, Junge & Pastewka: a tip of radius R follows what has an rms curvature below c/R.

They take 1/2. Simulated parabolic tips of four radii on surfaces of Hurst exponents 0.5 and 0.8 took a tenth of the
spectrum at 0.1 (0.07 to 0.18) and left a third of it at 1/2.
"""

_PER_DECADE = 48
"""Bins of the wave number in which slope and curvature are summed."""

_FLAT = 0.35
"""Exponent of the wave number below which the end of a spectrum is flat; that of a rough surface, with what is folded
back at the Nyquist wave number, is 0.6 or more over the last octave."""

_FLOOR_BINS = 12
"""Bins to a decade in which a noise floor is looked for."""

_FLOOR_WIDTH = math.log(2)
"""Narrowest noise floor, in log q: an octave."""

_FEWEST_BINS = 3
"""Of such an octave."""

_FINEST = 1e-6
"""Of the shortest wave of the scan, as far as a power law is followed."""

_HALVINGS = 60


@dataclass(frozen=True, eq=False, repr=False)
class ScaleDependentRoughness(Readable):
    """Root-mean-square slope and curvature of a body's waves from the longest down to a wavelength.

    Attributes
    ----------
    wavelength : (n,) ndarray of float, µm
        Falling, from the longest wave to the shortest of the grid.
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
        return np.asarray(np.sqrt(np.square(measured) + added_slope(estimate, finer)))

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


def interval_lines(estimate: HurstEstimate) -> tuple[HurstEstimate, HurstEstimate, HurstEstimate]:
    """The fitted line, and those with the lower and the upper exponent of its interval through the band's middle."""
    middle = 2 * math.pi / math.sqrt(estimate.shortest_wavelength * estimate.longest_wavelength)
    lower, upper = (
        replace(estimate, value=value, prefactor=estimate.prefactor * middle ** (2 * (value - estimate.value)))
        for value in (estimate.lower, estimate.upper)
    )
    return estimate, lower, upper


def added_slope(estimate: HurstEstimate, wavelength: Floats) -> Floats:
    """Mean square slope of waves between a wavelength (µm) and the shortest of the band, by the fitted power law."""
    exponent = 2 - 2 * estimate.value
    start, end = 2 * math.pi / estimate.shortest_wavelength, 2 * math.pi / np.asarray(wavelength)
    ratio = np.log(end / start)
    # (end^x - start^x)/x, also at x = 0.
    grown = start**exponent * (np.expm1(exponent * ratio) / exponent if exponent != 0 else ratio)
    return np.asarray(estimate.prefactor / (estimate.dimensions * math.pi) * grown)


def scale_dependent_roughness(body: Profile | Surface, *, periodic: bool = False) -> ScaleDependentRoughness:
    r"""Slope and curvature of a profile or a surface over the shortest wavelength that is counted.

    Parameters
    ----------
    body : Profile or Surface
        Unless it is periodic, its least-squares line or plane is taken off.
    periodic : bool
        As for `power_spectrum`.

    Raises
    ------
    ValueError
        If the body is flat, or neither a profile nor a surface.

    Notes
    -----
    .. math:: h'(λ)^2 = \frac1{4π^2} \int_{q<2π/λ} q^2 C^{2D} d^2q, \qquad
              h''(λ)^2 = \frac1{16π^2} \int_{q<2π/λ} q^4 C^{2D} d^2q

    for surfaces; :math:`\frac1π \int q^2 C^{1D} dq` and :math:`\frac1π \int q^4 C^{1D} dq` for profiles. Sanner,
    Nöhring, Thimons, Jacobs & Pastewka, Applied Surface Science Advances 7 (2022) 100190, say why a scale belongs to
    every slope.

    Examples
    --------
    >>> from stiction import scale_dependent_roughness, self_affine_surface
    >>> surface = self_affine_surface(1, hurst_exponent=0.8, rms=0.05, shape=(256, 256), spacing=0.04)
    >>> found = scale_dependent_roughness(surface, periodic=True)
    >>> float(found.fraction_below(0.16).round(2))
    0.26
    """
    truth("periodic", periodic)
    if not isinstance(body, (Profile, Surface)):
        raise ValueError(f"body must be a Profile or a Surface, got {type(body).__name__}")
    refuse_flat(body)
    if isinstance(body, Profile):
        line = power_spectrum(body if periodic else levelled(body, "line"), periodic=periodic)
        q, dimensions, curved = line.wave_number, 1, 1.0
        weight = line.density * line.count * (line.resolution / math.pi)
    else:
        area = surface_spectrum(body if periodic else levelled(body, "plane"), periodic=periodic)
        q = np.hypot(area.wave_number_y[:, np.newaxis], area.wave_number_x).ravel()
        step = float(area.wave_number_y[1] - area.wave_number_y[0]) * float(
            area.wave_number_x[1] - area.wave_number_x[0]
        )
        weight, dimensions, curved = area.density.ravel() * (step / (4 * math.pi**2)), 2, 0.25
        q, weight = q[q > 0], weight[q > 0]
    index = np.floor(_PER_DECADE * np.log10(q / q.min()) + 1e-9).astype(np.intp)
    count = np.bincount(index)
    there = count > 0
    finest = np.zeros(count.size)
    np.maximum.at(finest, index, q)
    sums = [np.bincount(index, q**power * weight)[there].cumsum() for power in (2, 4)]
    return ScaleDependentRoughness(
        wavelength=read_only(2 * math.pi / finest[there]),
        gradient=read_only(np.sqrt(sums[0])),
        curvature=read_only(np.sqrt(curved * sums[1])),
        dimensions=dimensions,
    )


def _between(wavelength: Floats, values: Floats, wanted: ArrayLike) -> Floats:
    """Values at other wavelengths, by straight lines of the logarithms; zero above the longest."""
    at = float_array("wavelength", wanted)
    if not (at > 0).all():
        raise ValueError(f"wavelength must be above 0 µm, got {wanted!r}")
    with np.errstate(divide="ignore"):
        found = np.exp(np.interp(-np.log(at), -np.log(wavelength), np.log(values)))
    return np.asarray(np.where(at > wavelength[0] * (1 + 1e-9), 0.0, found))


@dataclass(frozen=True, repr=False)
class InstrumentLimit(Tabled):
    """The wavelength below which a scan is of the instrument rather than of the surface.

    Attributes
    ----------
    wavelength : float, µm
        The largest of those below.
    reason : str
        Which it is: "pixels", "noise floor" or "tip".
    pixels : float, µm
        Two points of the coarser spacing.
    noise : float, µm
        From which on, towards shorter waves, the spectrum is flat; NaN without such a floor.
    tip : float, µm
        Below which the curvature is more than the tip follows; NaN without a tip radius, or if it follows all.

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


def instrument_limit(
    body: Profile | Surface, *, tip_radius: float | None = None, periodic: bool = False
) -> InstrumentLimit:
    """Find below which wavelength a scan is not to be trusted: by its pixels, its noise and its tip.

    Parameters
    ----------
    body : Profile or Surface
    tip_radius : float, µm, optional
        Of the stylus or the probe.
    periodic : bool
        As for `power_spectrum`.

    Raises
    ------
    ValueError
        If the body is flat or the radius is not above 0.

    Notes
    -----
    Noise that does not depend on the wavelength is a flat end of the spectrum, of at least an octave; where waves have
    as much power as the noise, the spectrum is twice as high as its end. The optics of an instrument, which cut waves
    off well above its pixels, are not seen: then the spectrum falls faster, and H above 1 is found.

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
    spacing = body.spacing if isinstance(body, Profile) else max(body.spacing)
    limits = {"pixels": 2 * spacing, "noise floor": _noise_floor(body, periodic), "tip": math.nan}
    if radius is not None and (sharp := roughness.curvature > TIP_FACTOR / radius).any():
        limits["tip"] = float(roughness.wavelength[int(np.argmax(sharp))])
    reason = max((name for name in limits if not math.isnan(limits[name])), key=lambda name: limits[name])
    return InstrumentLimit(limits[reason], reason, limits["pixels"], limits["noise floor"], limits["tip"])


def _noise_floor(body: Profile | Surface, periodic: bool) -> float:
    """Wavelength (µm) at which the spectrum is twice its flat end; NaN where the end is not flat."""
    if isinstance(body, Profile):
        line = power_spectrum(body if periodic else levelled(body, "line"), periodic=periodic).in_bins(_FLOOR_BINS)
        q, density, count = line.wave_number, line.density, line.count
    else:
        area = surface_spectrum(body if periodic else levelled(body, "plane"), periodic=periodic)
        radial = area.radial(_FLOOR_BINS)
        q, density, count = radial.wave_number, radial.density, radial.count
    if not periodic:  # the window's own
        q, density, count = q[2:], density[2:], count[2:]
    if q.size < _FEWEST_BINS:
        return math.nan
    octave = np.log(q[-1] / q) <= _FLOOR_WIDTH
    if octave.sum() < _FEWEST_BINS or not (density[octave] > 0).all():
        return math.nan
    exponent = -np.polyfit(np.log(q[octave]), np.log(density[octave]), 1, w=np.sqrt(count[octave]))[0]
    if not abs(exponent) < _FLAT:
        return math.nan
    level = float(np.average(density[octave], weights=count[octave]))
    above = np.flatnonzero(density > 2 * level)
    if not above.size:
        return float(2 * math.pi / q[0])
    last = int(above[-1])
    return float(2 * math.pi / math.sqrt(q[last] * q[min(last + 1, q.size - 1)]))
