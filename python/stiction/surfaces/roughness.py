"""Roughness parameters of profiles and surfaces: of their heights, slopes and texture."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, choice, float_array
from stiction._shown import Tabled
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectrum import surface_spectrum
from stiction.surfaces.surface import BodyLike, Surface, body_of, refuse_flat

Derivative = Literal["seven-point", "neighbours"]
SEVEN_POINTS = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0])
DECAY = 0.2  # autocorrelation at which its lengths are taken: the default of ISO 25178-3
_CORE = 0.4  # fraction of the points over which the bearing curve is least steep
_DIRECTIONS = 720  # number of directions in which the autocorrelation is followed from its middle
_SECTORS = 90  # number of sectors, of two degrees each, over which the power of the waves is summed
NOT_LEVELLED = "no: as they are"  # levelling of heights of which nothing was taken off


def levelling(history: tuple[str, ...]) -> str:
    """What was taken off heights, by their history."""
    steps = [step.removeprefix("levelled ") for step in history if step.startswith("levelled ")]
    return steps[-1] if steps else NOT_LEVELLED


@dataclass(frozen=True, repr=False)
class RoughnessParameters(Tabled):
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
    levelled : str
        What was taken off the heights, or "no: as they are".

    Examples
    --------
    >>> from stiction import Profile, roughness_parameters
    >>> roughness_parameters(Profile([0.0, 0.01, 0.0, -0.01, 0.0, 0.01, 0.0, -0.01], spacing=2.0))
    RoughnessParameters
      Pa        5 nm
      Pq        7.071 nm
      Pt        20 nm
      Psk       0
      Pku       2
      Pdq       0.005185
      levelled  no: as they are
    """

    Pa: float = field(metadata={"unit": "µm"})
    Pq: float = field(metadata={"unit": "µm"})
    Pt: float = field(metadata={"unit": "µm"})
    Psk: float
    Pku: float
    Pdq: float
    levelled: str = NOT_LEVELLED


def roughness_parameters(
    profile: BodyLike, *, derivative: Derivative = "seven-point", spacing: Any = None, unit: str = "um"
) -> RoughnessParameters:
    """Roughness parameters of a profile as it is, about its mean: levelling and filtering are the caller's.

    Parameters
    ----------
    profile : Profile or array_like
        Heights in an array need their `spacing` (µm, or text such as "39 nm"), and have the `unit`.
        Not flat, and of at least 7 points.
    derivative : {"seven-point", "neighbours"}
        How Pdq takes slopes. "seven-point" is that of ISO 4287 and of instruments, at all points that have three
        neighbours on each side; it smooths, and sees nothing of wavelengths near twice the spacing. "neighbours" is
        the difference of two neighbours over the spacing, which most codes for contact take.

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
    profile = body_of("profile", profile, Profile, spacing=spacing, unit=unit)
    choice("derivative", derivative, Derivative)
    refuse_flat(profile)
    z = profile.heights
    if z.size < SEVEN_POINTS.size:
        raise ValueError(f"profile must have at least {SEVEN_POINTS.size} points, got {z.size}")
    deviation = z - z.mean()
    scale = float(np.abs(deviation).max())
    deviation /= scale  # so that the fourth power neither over- nor underflows
    rms = float(np.sqrt(np.mean(deviation**2)))
    if derivative == "seven-point":
        differences = np.correlate(deviation, SEVEN_POINTS, mode="valid") / 60
    else:
        differences = np.diff(deviation)
    return RoughnessParameters(
        Pa=scale * float(np.mean(np.abs(deviation))), Pq=scale * rms, Pt=float(np.ptp(z)),
        Psk=float(np.mean((deviation / rms) ** 3)), Pku=float(np.mean((deviation / rms) ** 4)),
        Pdq=scale * float(np.sqrt(np.mean(differences**2))) / profile.spacing, levelled=levelling(profile.history),
    )  # fmt: skip


@dataclass(frozen=True, repr=False)
class SurfaceParameters(Tabled):
    """Parameters of a primary surface by the names of ISO 25178-2, about its mean.

    Attributes
    ----------
    Sq, Sa : float, µm
        Root-mean-square height and mean absolute height.
    Sz : float, µm
        Maximum height: highest minus lowest point.
    Ssk, Sku : float
        Skewness, below 0 if the valleys are deeper than the peaks are high, and kurtosis, 3 for normally distributed
        heights.
    Sdq : float
        Root-mean-square gradient, by the derivative that was asked for.
    Sdr : float
        By which share the area is larger than its projection, of triangles between neighbouring points.
    Sal : float, µm
        Autocorrelation length: the shortest distance at which the autocorrelation has fallen to 0.2. NaN if it does not
        do so within half the surface.
    Str : float
        Texture aspect ratio: Sal over the longest such distance; 1 is isotropic, near 0 has a lay. NaN if the
        autocorrelation has not fallen to 0.2 within half the surface in some direction: then it is below
        Sal over half the shorter side.
    Std : float, degrees
        Texture direction: that of the most powerful waves, from +x towards +y, in [0, 180). A lay runs across it. Means
        nothing where Str is near 1.
    Sk, Spk, Svk : float, µm
        Core height, reduced peak height and reduced valley depth of the bearing curve.
    Smr1, Smr2 : float
        Shares of the area at the upper and the lower end of the core.
    levelled : str
        What was taken off the heights, or "no: as they are".

    Examples
    --------
    >>> from stiction import self_affine_surface, surface_parameters
    >>> surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1)
    >>> round(surface_parameters(surface).Sq, 6)
    0.02
    """

    Sq: float = field(metadata={"unit": "µm"})
    Sa: float = field(metadata={"unit": "µm"})
    Sz: float = field(metadata={"unit": "µm"})
    Ssk: float
    Sku: float
    Sdq: float
    Sdr: float
    Sal: float = field(metadata={"unit": "µm"})
    Str: float
    Std: float = field(metadata={"unit": "degrees"})
    Sk: float = field(metadata={"unit": "µm"})
    Spk: float = field(metadata={"unit": "µm"})
    Svk: float = field(metadata={"unit": "µm"})
    Smr1: float
    Smr2: float
    levelled: str = NOT_LEVELLED


def surface_parameters(
    surface: BodyLike, *, derivative: Derivative = "seven-point", spacing: Any = None, unit: str = "um"
) -> SurfaceParameters:
    r"""Roughness parameters of a surface as it is, about its mean: levelling and filtering are the caller's.

    Parameters
    ----------
    surface : Surface or array_like
        Heights in an array need their `spacing` (µm, or text such as "39 nm"), and have the `unit`.
        Not flat, and of at least 7 by 7 points.
    derivative : {"seven-point", "neighbours"}
        How Sdq takes slopes, as for `roughness_parameters`: along rows and columns one by one, and the mean squares of
        both added.

    Notes
    -----
    Sdr takes the mean of both ways to part each mesh of the grid into two triangles.

    The autocorrelation is that of ISO 25178-2: the mean of the products over the area in which the surface and its
    shifted copy overlap, over the mean square. It is followed from the middle to where it first falls to 0.2, in 720
    directions, bilinear between shifts of whole points, up to half the length along each axis.

    The power of waves is that after a Hann window, summed over sectors of two degrees from the third harmonic of the
    longer side up to the smaller Nyquist wave number, in which all directions are there.

    The core is the 40 % of the points over which a secant of the bearing curve is least steep; a straight line is
    fitted to it by least squares, and Sk is its fall from 0 to 100 %. Spk and Svk are the heights of triangles
    of the area of the peaks above and the valleys below the core, on the bases Smr1 and 1 - Smr2.

    ISO 25178-2:2021.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Surface, surface_parameters
    >>> grooves = np.sin(2 * np.pi * np.arange(100) / 20) + np.zeros((50, 1))  # that run along y
    >>> found = surface_parameters(Surface(grooves, spacing=0.5))
    >>> round(found.Sq, 6), found.Std, round(found.Sku, 6)
    (0.707107, 0.0, 1.5)
    """
    surface = body_of("surface", surface, Surface, spacing=spacing, unit=unit)
    choice("derivative", derivative, Derivative)
    refuse_flat(surface)
    z = surface.heights
    if min(z.shape) < SEVEN_POINTS.size:
        raise ValueError(
            f"surface must have at least {SEVEN_POINTS.size} rows and {SEVEN_POINTS.size} columns, got {z.shape}"
        )
    deviation = z - z.mean()
    scale = float(np.abs(deviation).max())
    deviation /= scale  # so that the fourth power neither over- nor underflows
    rms = float(np.sqrt(np.mean(deviation**2)))
    squares = sum(float(np.mean(_slopes(z, axis, derivative) ** 2)) / surface.spacing[axis] ** 2 for axis in (0, 1))
    shortest, longest = _decay_lengths(deviation, surface.spacing)
    core, upper, lower = _core_line(deviation)
    q, angle, density = surface_spectrum(surface).waves()
    kept = q > 2.5 * 2 * math.pi / max(surface.extent)
    sector = np.rint(angle[kept] * _SECTORS / 180).astype(np.intp) % _SECTORS
    texture = float(int(np.argmax(np.bincount(sector, density[kept], minlength=_SECTORS))) * 180 / _SECTORS)
    peaks, valleys = np.maximum(deviation - upper, 0), np.maximum(lower - deviation, 0)
    above, below = float(np.mean(deviation > upper)), float(np.mean(deviation < lower))
    return SurfaceParameters(
        Sq=scale * rms, Sa=scale * float(np.mean(np.abs(deviation))), Sz=float(np.ptp(z)),
        Ssk=float(np.mean((deviation / rms) ** 3)), Sku=float(np.mean((deviation / rms) ** 4)), Sdq=math.sqrt(squares),
        Sdr=_developed(z, surface.spacing), Sal=shortest, Str=shortest / longest, Std=texture,
        Sk=scale * core, Spk=scale * (2 * float(peaks.mean()) / above if above else 0.0),
        Svk=scale * (2 * float(valleys.mean()) / below if below else 0.0), Smr1=above, Smr2=1 - below,
        levelled=levelling(surface.history),
    )  # fmt: skip


def bearing_curve(surface: Surface, shares: ArrayLike) -> Floats:
    """Heights (µm) above which given shares of a surface lie, from its highest point at 0 to its lowest at 1.

    Parameters
    ----------
    surface : Surface
    shares : array_like of float
        From 0 to 1, of any shape.

    Examples
    --------
    >>> from stiction import Surface, bearing_curve
    >>> bearing_curve(Surface([[0.0, 1.0], [2.0, 3.0]], spacing=1.0), [0.0, 0.5, 1.0])
    array([3. , 1.5, 0. ])
    """
    surface = body_of("surface", surface, Surface)
    wanted = float_array("shares", shares)
    if wanted.size and not (wanted.min() >= 0 and wanted.max() <= 1):
        raise ValueError(f"shares must be from 0 to 1, got {wanted.min():g} to {wanted.max():g}")
    return np.asarray(np.quantile(surface.heights, 1 - wanted))


def _slopes(heights: Floats, axis: int, derivative: Derivative) -> Floats:
    """Along an axis, in heights per point."""
    if derivative == "neighbours":
        return np.diff(heights, axis=axis)
    lines = heights if axis == 1 else heights.T
    points = lines.shape[1] - SEVEN_POINTS.size + 1
    total = np.zeros((lines.shape[0], points))
    for at, weight in enumerate(SEVEN_POINTS):
        total += weight / 60 * lines[:, at : at + points]
    return total


def _developed(heights: Floats, spacing: tuple[float, float]) -> float:
    """Area of the triangles between points over their projection, less 1."""
    total = 0.0
    corners = heights[:-1, :-1], heights[:-1, 1:], heights[1:, :-1], heights[1:, 1:]
    # Each triangle has a side along x and one along y, and so the slopes of these.
    for along_x in (corners[1] - corners[0], corners[3] - corners[2]):
        for along_y in (corners[2] - corners[0], corners[3] - corners[1]):
            squares = np.square(along_x / spacing[1]) + np.square(along_y / spacing[0])
            total += float(np.mean(squares / (1 + np.sqrt(1 + squares)))) / 4  # without cancellation
    return total


def _decay_lengths(deviation: Floats, spacing: tuple[float, float]) -> tuple[float, float]:
    """Shortest and longest distance at which the autocorrelation falls to 0.2; NaN where it does not."""
    correlation = autocorrelation(deviation)
    half = [points // 2 for points in deviation.shape]
    angle = math.pi * np.arange(_DIRECTIONS) / _DIRECTIONS  # the other half is the same
    # Steps of half the finer spacing, up to where a direction leaves the half of the surface.
    towards = np.abs(np.stack([np.sin(angle) / spacing[0], np.cos(angle) / spacing[1]]))  # points per µm
    with np.errstate(divide="ignore"):
        furthest = np.min(np.array(half)[:, np.newaxis] / towards, axis=0)
    step = min(spacing) / 2
    reached = np.full(_DIRECTIONS, np.nan)
    before = np.ones(_DIRECTIONS)
    for index in range(1, int(furthest.max() / step) + 1):
        open_still = np.flatnonzero(np.isnan(reached) & (index * step <= furthest))
        if not open_still.size:
            break
        distance = index * step
        y = distance * np.sin(angle[open_still]) / spacing[0]
        x = distance * np.cos(angle[open_still]) / spacing[1]
        now = _bilinear(correlation, y, x)
        fallen = now < DECAY
        last = before[open_still]
        reached[open_still[fallen]] = distance - step + step * (last[fallen] - DECAY) / (last[fallen] - now[fallen])
        before[open_still] = now
    if np.isnan(reached).all():
        return math.nan, math.nan
    return float(np.nanmin(reached)), math.nan if np.isnan(reached).any() else float(reached.max())


def autocorrelation(deviation: Floats) -> Floats:
    """Autocorrelation of heights, at shifts of j rows and l - columns//2 columns, up to half the points."""
    from scipy.fft import irfft2, next_fast_len, rfft2

    rows, columns = deviation.shape
    shape = next_fast_len(rows + rows // 2 + 1, real=True), next_fast_len(columns + columns // 2 + 1, real=True)
    transform = rfft2(deviation, shape)
    products = irfft2(transform.real**2 + transform.imag**2, shape)
    along_x = np.arange(-(columns // 2), columns // 2 + 1)
    along_y = np.arange(rows // 2 + 1)
    overlap = (rows - along_y)[:, np.newaxis] * (columns - np.abs(along_x))
    return np.asarray(products[along_y[:, np.newaxis], along_x] / overlap / np.mean(deviation**2))


def _bilinear(correlation: Floats, y: Floats, x: Floats) -> Floats:
    x = x + correlation.shape[1] // 2
    row = np.minimum(y.astype(np.intp), correlation.shape[0] - 2)
    column = np.clip(x.astype(np.intp), 0, correlation.shape[1] - 2)
    y, x = y - row, x - column
    return np.asarray(
        (1 - y) * ((1 - x) * correlation[row, column] + x * correlation[row, column + 1])
        + y * ((1 - x) * correlation[row + 1, column] + x * correlation[row + 1, column + 1])
    )


def _core_line(deviation: Floats) -> tuple[float, float, float]:
    """Fall of the straight line through the core of the bearing curve, and its heights at 0 and 100 %."""
    heights = np.sort(deviation, axis=None)[::-1]
    points = heights.size
    core = max(2, round(_CORE * points))
    fall = heights[: points - core + 1] - heights[core - 1 :]
    start = int(np.argmin(fall))
    share = (np.arange(start, start + core) + 0.5) / points
    place = share - share.mean()
    slope = float(place @ heights[start : start + core] / (place @ place))
    upper = float(heights[start : start + core].mean()) - slope * float(share.mean())
    return -slope, upper, upper + slope
