"""Spectra, moments and Hurst exponents of surfaces against their definitions and known surfaces."""

import math

import numpy as np
import pytest
from stiction import Surface, hurst_exponent_of, levelled, rotated, spectral_moments, surface_spectrum

# Of sums over some thousand points, of transforms and their squares.
ROUND_OFF = 1e-11

LAY = 10.0
"""Degrees, of maps of some ten of the longest waves that are twice as long one way; nine tenths are within 3."""


def self_affine_map(seed, hurst, shape=(128, 160), *, spacing=(0.5, 0.5), longest=math.inf, whole=1, stretch=1.0):
    """Gaussian heights with C2D ∝ q^(-2-2H), flat above a wavelength; cut out of a map that is `whole` times larger."""
    rows, columns = whole * shape[0], whole * shape[1]
    white = np.random.default_rng(seed).normal(size=(rows, columns))
    q_y, q_x = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip((rows, columns), spacing, strict=True))
    q = np.hypot(stretch * q_y[:, np.newaxis], q_x)
    amplitude = np.maximum(q, max(2 * np.pi / longest, q_x[1] / 4)) ** (-1 - hurst)
    amplitude[0, 0] = 0
    heights = np.fft.ifft2(amplitude * np.fft.fft2(white)).real[: shape[0], : shape[1]]
    return Surface(heights / heights.std(), spacing=spacing)


def test_is_the_sum_it_is_defined_by():
    surface = self_affine_map(1, 0.7, (8, 9), spacing=(0.5, 0.25))
    window = [np.sqrt(8 / 3) * np.sin(np.pi * np.arange(n) / n) ** 2 for n in (8, 9)]
    for periodic in (True, False):
        heights = surface.heights - surface.heights.mean()
        if not periodic:
            heights = heights * window[0][:, np.newaxis] * window[1]
        spectrum = surface_spectrum(surface, periodic=periodic)
        for j, q_y in enumerate(spectrum.wave_number_y):
            for i, q_x in enumerate(spectrum.wave_number_x):
                wave = np.exp(-1j * (q_y * surface.y[:, np.newaxis] + q_x * surface.x))
                wanted = 0 if q_x == q_y == 0 else abs((heights * wave).sum()) ** 2 * 0.125 / 72
                assert spectrum.density[j, i] == pytest.approx(wanted, rel=1e-9, abs=1e-15)


def test_moments_are_variances_along_any_direction():
    surface = self_affine_map(2, 0.7)
    spectrum = surface_spectrum(surface, periodic=True)
    assert spectrum.moments(37).height == pytest.approx(surface.heights.var(), rel=ROUND_OFF)
    # Along x, those of the rows; a row's own mean is a wave of the surface.
    rows = [spectral_moments(surface.row(index), periodic=True) for index in range(128)]
    assert spectrum.moments(0).slope == pytest.approx(np.mean([row.slope for row in rows]), rel=1e-9)
    assert spectrum.moments(0).curvature == pytest.approx(np.mean([row.curvature for row in rows]), rel=1e-9)
    columns = [spectral_moments(surface.column(index), periodic=True) for index in range(160)]
    assert spectrum.moments(90).slope == pytest.approx(np.mean([column.slope for column in columns]), rel=1e-9)
    # In between: m2 is a quadratic form of the direction.
    along, across = spectrum.moments(20).slope, spectrum.moments(110).slope
    assert along + across == pytest.approx(spectrum.moments(0).slope + spectrum.moments(90).slope, rel=ROUND_OFF)
    wave = np.cos(0.25 * np.pi * (surface.x / 0.5) + 0.5 * np.pi * (surface.y[:, np.newaxis] / 0.5))
    found = surface_spectrum(Surface(wave, spacing=0.5), periodic=True).moments(math.degrees(math.atan2(2, 1)))
    assert found.slope == pytest.approx(0.5 * (np.pi / 2) ** 2 * 5, rel=1e-9)
    assert found.nayak_parameter == pytest.approx(1, rel=1e-9)


def test_steepest_direction_is_across_a_lay():
    waves = np.arange(128)[:, np.newaxis] * 0.2 * np.pi * 5 / 32 + np.arange(128) * 0.2 * np.pi * 10 / 32
    spectrum = surface_spectrum(Surface(np.cos(waves), spacing=1.0))
    assert spectrum.steepest_direction() == pytest.approx(math.degrees(math.atan2(1, 2)), abs=0.5)
    for angle in (10.0, 70.0, 130.0):
        for seed in range(4):
            surface = self_affine_map(seed, 0.7, (160, 160), whole=2, longest=20.0, stretch=2.0)  # longer along y
            turned = surface_spectrum(levelled(rotated(surface, angle), "plane"))
            off = (turned.steepest_direction() - angle + 90) % 180 - 90
            assert abs(off) < LAY


def test_radial_spectrum_holds_every_wave_once():
    surface = self_affine_map(3, 0.6, (64, 81), spacing=(0.5, 0.3))
    spectrum = surface_spectrum(surface, periodic=True)
    q, angle, density = spectrum.waves()
    assert (np.diff(q) >= 0).all()
    assert angle.min() >= 0
    assert angle.max() < 180
    # Both of a wave and its opposite, over the ring.
    area = (2 * np.pi / 32) * (2 * np.pi / 24.3)
    inside = np.hypot(spectrum.wave_number_y[:, np.newaxis], spectrum.wave_number_x) < np.pi / 0.5 * (1 - 1e-9)
    assert 2 * density.sum() * area == pytest.approx(spectrum.density[inside].sum() * area, rel=ROUND_OFF)
    radial = spectrum.radial(7)
    assert radial.count.sum() == q.size
    assert (radial.density * radial.count).sum() == pytest.approx(density.sum(), rel=ROUND_OFF)


def test_agrees_with_surface_topography():
    topography = pytest.importorskip("SurfaceTopography")
    surface = self_affine_map(4, 0.8, (96, 128))
    other = topography.Topography(surface.heights.T - surface.heights.mean(), (64.0, 48.0), periodic=True)
    q, density = other.power_spectrum_from_area(nb_points_per_decade=5)
    kept = np.isfinite(density) & (q > 0.5) & (q < 5)
    own = surface_spectrum(surface, periodic=True)
    at, _, values = own.waves()
    edges = np.sqrt(q[1:] * q[:-1])
    for index in np.flatnonzero(kept)[1:-1]:
        ring = (at > edges[index - 1]) & (at < edges[index])
        # Its rings have edges of their own, and the density falls by half within a tenth of a decade.
        assert density[index] == pytest.approx(values[ring].mean(), rel=0.35)


class TestHurstExponent:
    # 95 % of 60; more than 8 misses would be a chance of 1 in 500.
    CASES, MOST_MISSES = 60, 8

    @pytest.mark.parametrize("longest", [math.inf, 20.0], ids=["all wavelengths", "roll-off"])
    @pytest.mark.parametrize("given", [True, False])
    def test_is_within_its_interval(self, longest, given):
        misses = 0
        for case, hurst in enumerate(np.linspace(0.3, 0.9, self.CASES)):
            surface = self_affine_map(case, hurst, longest=longest, whole=2)
            found = hurst_exponent_of(surface, band=(1.0, min(longest, 30.0)) if given else None)
            misses += not found.lower <= hurst <= found.upper
        assert misses <= self.MOST_MISSES

    def test_band_of_a_surface_is_kept_to_and_scale_and_tilt_do_not_matter(self):
        surface = self_affine_map(5, 0.7, whole=2)
        one = hurst_exponent_of(surface, band=(1.5, 15.0))
        assert one.dimensions == 2
        assert 1.5 <= one.shortest_wavelength < one.longest_wavelength <= 15 * (1 + 1e-9)
        tilted = surface.heights * 1e-4 + 0.3 * surface.x + 0.1 * surface.y[:, np.newaxis] + 7
        other = hurst_exponent_of(Surface(tilted, spacing=0.5), band=(1.5, 15.0))
        assert other.value == pytest.approx(one.value, abs=1e-9)
        # The line goes through the radial spectrum.
        radial = surface_spectrum(levelled(surface, "plane")).radial(20)
        inside = (radial.wave_number > 2 * np.pi / 15) & (radial.wave_number < 2 * np.pi / 1.5)
        ratio = radial.density[inside] / one.density(radial.wave_number[inside])
        assert np.average(ratio, weights=radial.count[inside]) == pytest.approx(1, abs=0.05)

    def test_what_has_no_spectrum_is_refused(self):
        for surface, said in (
            (Surface(np.ones((9, 9)), spacing=1.0), "flat surface"),
            (Surface(np.arange(90.0).reshape(9, 10), spacing=1.0), "a plane has no roughness"),
        ):
            with pytest.raises(ValueError, match=said):
                hurst_exponent_of(surface)
        with pytest.raises(ValueError, match="at least 8 harmonics"):
            hurst_exponent_of(self_affine_map(5, 0.7), band=(1.01, 1.01001))
