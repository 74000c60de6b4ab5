"""Power spectrum of a surface: over wave vectors, over their length, and its moments in any direction.

A surface that is not `periodic` has jumps between opposite sides; it is faded out towards its sides by a Hann window in
both directions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stiction._checks import Floats, number, read_only, truth, whole_number
from stiction.surfaces.roughness import refuse_flat
from stiction.surfaces.spectrum import ProfileMoments
from stiction.surfaces.surface import Surface


@dataclass(frozen=True, eq=False)
class RadialSpectrum:
    """Mean of a surface's spectrum over the directions of the wave vector.

    Attributes
    ----------
    wave_number : (n,) ndarray of float, 1/µm
        Their lengths, 2π / wavelength, rising; the geometric mean of those in a bin.
    density : (n,) ndarray of float, µm⁴
        C2D, the mean over the bin.
    count : (n,) ndarray of float
        Waves in each bin; one wave vector and its opposite are one wave.
    """

    wave_number: Floats
    density: Floats
    count: Floats


@dataclass(frozen=True, eq=False)
class SurfaceSpectrum:
    """Power spectral density of a surface by the convention of Jacobs, Junge & Pastewka (2017).

    Attributes
    ----------
    wave_number_y : (rows,) ndarray of float, 1/µm
    wave_number_x : (columns,) ndarray of float, 1/µm
        Rising, zero in the middle; at an even number of points the first is that at the Nyquist frequency.
    density : (rows, columns) ndarray of float, µm⁴
        C2D(q), so that the mean square height is 1/4π² times its integral over both; zero at q = 0.
    """

    wave_number_y: Floats
    wave_number_x: Floats
    density: Floats

    def moments(self, direction: float = 0.0) -> ProfileMoments:
        r"""Variances of height, slope and curvature along a line of this direction, in degrees from +x towards +y.

        Notes
        -----
        .. math:: m_n = \frac{1}{4π^2} \int (q_x \cos φ + q_y \sin φ)^n\, C^{2D}\, d^2q

        `ProfileMoments.nayak_parameter` is that of the lines. Longuet-Higgins, Philosophical Transactions A 249 (1957)
        321; Nayak, Journal of Lubrication Technology 93 (1971) 398.
        """
        angle = math.radians(number("direction", direction))
        along = self.wave_number_x * math.cos(angle) + self.wave_number_y[:, np.newaxis] * math.sin(angle)
        steps = [float(each[1] - each[0]) for each in (self.wave_number_y, self.wave_number_x)]
        square, weight = np.square(along), self.density * (steps[0] * steps[1] / (4 * math.pi**2))
        return ProfileMoments(
            height=float(weight.sum()),
            slope=float((square * weight).sum()),
            curvature=float((np.square(square) * weight).sum()),
        )

    def steepest_direction(self) -> float:
        r"""Direction along which lines are steepest on the mean, in degrees from +x towards +y, in [0, 180).

        A lay runs across it. Of generated maps whose waves were 1.5, 2 and 3 times as long in one direction, 128 by 160
        points, nine tenths were within 5.3, 3.1 and 2.2 degrees; the sector of the most powerful waves (Std of
        ISO 25178-2) is that of a few long waves, and scatters by tens of degrees.

        Notes
        -----
        .. math:: φ = \frac12 \arctan\frac{2 m_{11}}{m_{20} - m_{02}}

        with the moments of the slope spectrum: the principal axis of the mean square slope.
        """
        along_x, between, along_y = (self.moments(angle).slope for angle in (0.0, 45.0, 90.0))
        twice = math.atan2(2 * between - along_x - along_y, along_x - along_y)
        return math.degrees(twice) / 2 % 180

    def waves(self) -> tuple[Floats, Floats, Floats]:
        """Wave number, direction (degrees from +x towards +y, in [0, 180)) and density of every wave.

        Only those up to the smaller of the two Nyquist wave numbers, of which all directions are there; rising.
        """
        y, x = self.wave_number_y[:, np.newaxis], self.wave_number_x
        q = np.hypot(y, x)
        limit = min(float(-each[0]) if each.size % 2 == 0 else float(each[-1]) for each in (y[:, 0], x))
        # One of each wave vector and its opposite.
        kept = ((y > 0) | ((y == 0) & (x > 0))) & (q < limit * (1 - 1e-9))
        order = np.argsort(q[kept], kind="stable")
        angle = np.degrees(np.arctan2(np.broadcast_to(y, q.shape)[kept], np.broadcast_to(x, q.shape)[kept]))[order]
        return q[kept][order], angle % 180, self.density[kept][order]

    def radial(self, per_decade: int = 10) -> RadialSpectrum:
        """Means over rings of equal width in log q, as many to a decade; rings without a wave are left out.

        Examples
        --------
        >>> import numpy as np
        >>> from stiction import Surface, surface_spectrum
        >>> wave = np.cos(2 * np.pi * 3 * np.arange(64) / 64)
        >>> spectrum = surface_spectrum(Surface(0.1 * wave + np.zeros((64, 1)), spacing=0.5), periodic=True)
        >>> round(spectrum.moments(0).height, 12), round(abs(spectrum.moments(90).slope), 12)
        (0.005, 0.0)
        """
        per_decade = whole_number("per_decade", per_decade, least=1)
        q, _, density = self.waves()
        _, index = np.unique(np.floor(per_decade * np.log10(q / q[0]) + 1e-9), return_inverse=True)
        count = np.bincount(index).astype(np.float64)
        return RadialSpectrum(
            wave_number=read_only(np.exp(np.bincount(index, np.log(q)) / count)),
            density=read_only(np.bincount(index, density) / count),
            count=read_only(count),
        )


def surface_spectrum(surface: Surface, *, periodic: bool = False) -> SurfaceSpectrum:
    r"""Power spectral density C2D of a surface about its mean.

    Parameters
    ----------
    surface : Surface
        Levelled, unless it is periodic: a tilt is a jump between opposite sides.
    periodic : bool
        True: as it is, and the mean square height is the sum of the spectrum to round-off. False: after a Hann window
        along both axes, normalised to a mean square of 1.

    Returns
    -------
    SurfaceSpectrum

    Raises
    ------
    ValueError
        If the surface is flat, or periodic is not a truth value.

    Notes
    -----
    .. math:: C(q) = \frac{Δx Δy}{N_x N_y} \left|\sum_{jl} w_j w_l (z_{jl} - \bar z) e^{-i q·r}\right|^2, \qquad
              h_{rms}^2 = \frac{1}{4π^2} \int C(q)\,d^2q

    A self-affine surface has C ∝ q^(-2-2H). Jacobs, Junge & Pastewka, Surface Topography: Metrology and Properties 5
    (2017) 013001.
    """
    truth("periodic", periodic)
    refuse_flat(surface)
    return spectrum_of_area(surface.heights - surface.heights.mean(), surface.spacing, windowed=not periodic)


def spectrum_of_area(heights: Floats, spacing: tuple[float, float], *, windowed: bool) -> SurfaceSpectrum:
    """Spectrum of heights as they are, or after a Hann window along both axes."""
    from scipy.fft import fft2, fftshift

    if windowed:
        along_y, along_x = (
            (1 - np.cos(2 * math.pi * np.arange(points) / points)) / math.sqrt(1.5) for points in heights.shape
        )
        heights = heights * along_y[:, np.newaxis] * along_x
    transform = fftshift(fft2(heights))
    density = (transform.real**2 + transform.imag**2) * (spacing[0] * spacing[1] / heights.size)
    q_y, q_x = (
        2 * math.pi * np.fft.fftshift(np.fft.fftfreq(points, step))
        for points, step in zip(heights.shape, spacing, strict=True)
    )
    density[heights.shape[0] // 2, heights.shape[1] // 2] = 0.0
    return SurfaceSpectrum(wave_number_y=read_only(q_y), wave_number_x=read_only(q_x), density=read_only(density))
