"""Tests of brackets from scans with instrument noise, which must contain the result of the noise-free surfaces."""

from functools import cache

import numpy as np
import pytest
from scipy.ndimage import grey_dilation
from stiction import Surface, pair
from support.rough_surfaces import rough_maps

pytestmark = pytest.mark.usefixtures("no_companion_files")

NUM_POINTS, SPACING = 128, 0.02
PAIR_OPTIONS = {
    "load": "20 MPa", "mu0": 0.2, "tau0": "100 MPa", "effective_modulus": "80 GPa", "hardness": "8 GPa", "shifts": 4,
    "onset": 0, "direction": [0, 90, 180, 270],
}  # fmt: skip
MIN_COVERED_FRACTION = 0.95
NUM_PAIRS = 75


def create_noise(noise_kind, random):
    frequency = np.abs(np.fft.fftfreq(NUM_POINTS))
    radial_frequency, x_frequency = np.hypot(frequency[:, None], frequency), frequency + 0 * frequency[:, None]
    filters = {
        "white": 1.0,
        "band": (radial_frequency > 0.15) & (radial_frequency < 0.35),
        "pink": 1 / np.maximum(radial_frequency, 1 / NUM_POINTS),
        "line": (abs(x_frequency - 0.2) < 0.01) & (frequency[:, None] < 0.05),
    }[noise_kind]
    filtered_noise = np.fft.ifft2(np.fft.fft2(random.normal(size=radial_frequency.shape)) * filters).real
    return filtered_noise / filtered_noise.std()


@cache
def create_pair(seed):
    """Return two surfaces, their friction without noise, and the rms noise to add, as a fraction of Sq."""
    random = np.random.default_rng(1000 + seed)
    roughness_options = {
        "hurst_exponent": random.uniform(0.4, 0.9), "rms": 0.002, "shape": (NUM_POINTS, NUM_POINTS), "spacing": SPACING,
        "longest_wavelength": NUM_POINTS * SPACING / 4,
    }  # fmt: skip
    noise_fraction, roughness_options["shortest_wavelength"] = (
        10 ** random.uniform(-1.6, -1),
        SPACING * random.choice([8, 12, 16]),
    )
    surfaces = rough_maps(seed, **roughness_options)
    return surfaces, pair(*surfaces, cutoff="none", **PAIR_OPTIONS).value, noise_fraction


def true_and_noisy_results(seed, noise_kind):
    """Return the friction of a pair without noise, and the first result point of its summary with noise."""
    (surfaces, true_value, noise_fraction), random = create_pair(seed), np.random.default_rng(2000 + seed)
    noisy_surfaces = [
        Surface(
            surface.heights + noise_fraction * surface.heights.std() * create_noise(noise_kind, random), spacing=SPACING
        )
        for surface in surfaces
    ]
    return true_value, pair(*noisy_surfaces, **PAIR_OPTIONS).summary().first


@pytest.mark.parametrize("noise_kind", ["white", "band", "line", "pink"])
@pytest.mark.soak
def test_friction_range_for_finer_scans_contains_the_result_without_noise_if_scans_are_noisy(noise_kind):
    results = [true_and_noisy_results(seed, noise_kind) for seed in range(NUM_PAIRS)]
    values_and_brackets = [(true_value, point.bracket) for true_value, point in results if point.bracket is not None]
    is_covered = [lower - 1e-9 <= true_value <= upper for true_value, (lower, upper) in values_and_brackets]
    print(
        f"{noise_kind}: {sum(is_covered)} of {len(values_and_brackets)} brackets of {NUM_PAIRS} pairs "
        "contain the true value"
    )
    assert len(values_and_brackets) > NUM_PAIRS / 2
    assert np.mean(is_covered) >= MIN_COVERED_FRACTION


def scan_with_tip(surface, radius):
    """Return the heights that a spherical tip with a given radius records on a surface."""
    offsets = SPACING * np.arange(-int(radius / SPACING), int(radius / SPACING) + 1)
    squared_distance = offsets[:, None] ** 2 + offsets**2
    tip_shape = np.sqrt(np.maximum(radius**2 - squared_distance, 0)) - radius
    scanned_heights = grey_dilation(
        surface.heights, footprint=squared_distance <= radius**2, structure=tip_shape, mode="wrap"
    )
    return Surface(scanned_heights, spacing=SPACING)


@pytest.mark.parametrize("hurst_exponent", [0.5, 0.8])
def test_friction_range_for_finer_scans_contains_the_true_result_if_the_tip_is_blunt(hurst_exponent):
    roughness_options = {
        "hurst_exponent": hurst_exponent,
        "rms": 0.01,
        "shape": (NUM_POINTS, NUM_POINTS),
        "spacing": SPACING,
        "longest_wavelength": NUM_POINTS * SPACING / 4,
        "shortest_wavelength": 6 * SPACING,
    }
    surfaces = rough_maps(1, **roughness_options)
    true_value = pair(*surfaces, cutoff="none", **PAIR_OPTIONS).value
    (point,) = (
        pair(*(scan_with_tip(surface, 0.3) for surface in surfaces), tip="300 nm", **PAIR_OPTIONS)
        .summary()
        .reported_points
    )
    assert true_value < point.value < true_value + 0.25 * (true_value - PAIR_OPTIONS["mu0"])
    assert point.bracket[0] < true_value < point.bracket[1]
    assert any("tip does not resolve" in caveat.text for caveat in point.caveats)
