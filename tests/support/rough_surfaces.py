"""Rough profiles and surfaces for tests."""

import math

import numpy as np
import scipy.fft
from stiction import Profile, Surface, self_affine, self_affine_surface

AMPLITUDE, WAVELENGTH = 0.1, 4.0


def sinusoid(points_per_wavelength, waves=8):
    """Return a sinusoid over a whole number of periods, so that means over grid points are exact."""
    x = np.arange(waves * points_per_wavelength) * WAVELENGTH / points_per_wavelength
    return Profile(3.0 + AMPLITUDE * np.sin(2 * np.pi * x / WAVELENGTH), spacing=WAVELENGTH / points_per_wavelength)


def rough_profile(seed=3, **changes):
    """Return a self-affine profile of 1000 points. `changes` replaces arguments of `self_affine`."""
    return self_affine(seed, **({"hurst_exponent": 0.8, "rms": 0.1, "points": 1000, "spacing": 0.01} | changes))


def self_affine_map(seed, hurst, shape=(128, 160), *, spacing=(0.5, 0.5), longest=math.inf, whole=1, stretch=1.0):
    """Return a self-affine map whose spectrum is constant at wavelengths above `longest`.

    The map is cut from a periodic map that is `whole` times larger along both axes.
    """
    rows, columns = whole * shape[0], whole * shape[1]
    white_noise = np.random.default_rng(seed).normal(size=(rows, columns))
    q_y, q_x = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip((rows, columns), spacing, strict=True))
    q = np.hypot(stretch * q_y[:, np.newaxis], q_x)
    amplitude = np.maximum(q, max(2 * np.pi / longest, q_x[1] / 4)) ** (-1 - hurst)
    amplitude[0, 0] = 0
    heights = np.fft.ifft2(amplitude * np.fft.fft2(white_noise)).real[: shape[0], : shape[1]]
    return Surface(heights / heights.std(), spacing=spacing)


def rough_maps(seed=3, *, points=48, **changes):
    """Return a pair of self-affine maps."""
    options = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (points, points), "spacing": 0.1} | changes
    return [self_affine_surface(seed, side=side, **options) for side in ("upper", "lower")]


def flat_like(body):
    """Return a flat profile or surface on the grid of `body`."""
    return type(body)(np.zeros(body.heights.shape), spacing=body.spacing)


def periodic_body(shape, *, seed=1, hurst=0.8, longest=4, shortest=16, slope=0.1):
    """Return a periodic self-affine body of unit size, with wavelengths from 1/longest to 1/shortest."""
    random = np.random.default_rng(seed)
    waves = np.meshgrid(
        *[np.fft.fftfreq(n, 1 / n) for n in shape[:-1]], np.fft.rfftfreq(shape[-1], 1 / shape[-1]), indexing="ij"
    )
    k = np.sqrt(sum(np.square(wave) for wave in waves))
    is_in_band = (k >= longest) & (k <= shortest)
    amplitude = np.where(is_in_band, np.where(is_in_band, k, 1.0) ** (-hurst - len(shape) / 2), 0.0)
    heights = scipy.fft.irfftn(amplitude * np.exp(2j * np.pi * random.random(k.shape)), shape)
    gradients = [scipy.fft.irfftn(2j * np.pi * wave * scipy.fft.rfftn(heights), shape) for wave in waves]
    heights *= slope / np.sqrt(sum(np.mean(np.square(gradient)) for gradient in gradients))
    if len(shape) == 1:
        return Profile(heights, spacing=1 / shape[0])
    return Surface(heights, spacing=(1 / shape[0], 1 / shape[1]))
