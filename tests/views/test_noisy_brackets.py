"""Scans with the noise of instruments, of four colours, beside the surfaces that they are of."""

from functools import cache

import numpy as np
import pytest
from scipy.ndimage import grey_dilation
from stiction import Surface, pair
from support.rough_surfaces import rough_maps

POINTS, SPACING = 128, 0.02
ASKED = {
    "load": "20 MPa", "mu0": 0.2, "tau0": "100 MPa", "effective_modulus": "80 GPa", "hardness": "8 GPa", "shifts": 4,
    "onset": 0, "direction": [0, 90, 180, 270],
}  # fmt: skip
HELD = 0.95  # of all that is to be quoted
PAIRS = 75  # of each colour


def noise(colour, random):
    along = np.abs(np.fft.fftfreq(POINTS))
    q, x = np.hypot(along[:, None], along), along + 0 * along[:, None]
    waves = {
        "white": 1.0, "band": (q > 0.15) & (q < 0.35), "pink": 1 / np.maximum(q, 1 / POINTS),
        "line": (abs(x - 0.2) < 0.01) & (along[:, None] < 0.05),
    }[colour]  # fmt: skip
    created = np.fft.ifft2(np.fft.fft2(random.normal(size=q.shape)) * waves).real
    return created / created.std()


@cache
def pair_of(seed):
    """Two surfaces, the answer of them without noise, and how much noise of Sq they get: 2.5 to 10 %."""
    random = np.random.default_rng(1000 + seed)
    rough = {
        "hurst_exponent": random.uniform(0.4, 0.9), "rms": 0.002, "shape": (POINTS, POINTS), "spacing": SPACING,
        "longest_wavelength": POINTS * SPACING / 4,
    }  # fmt: skip
    part, rough["shortest_wavelength"] = 10 ** random.uniform(-1.6, -1), SPACING * random.choice([8, 12, 16])
    clean = rough_maps(seed, **rough)
    return clean, pair(*clean, cutoff="none", **ASKED).value, part


def answers_of(seed, colour):
    """The answer of a pair without noise, and the first answer of the same with noise."""
    (clean, truth, part), random = pair_of(seed), np.random.default_rng(2000 + seed)
    noisy = [
        Surface(body.heights + part * body.heights.std() * noise(colour, random), spacing=SPACING) for body in clean
    ]
    return truth, pair(*noisy, **ASKED).summary().first


@pytest.mark.parametrize("colour", ["white", "band", "line", "pink"])
@pytest.mark.soak
def test_bracket_of_noisy_scans_contains_true_result(colour):
    message = [answers_of(seed, colour) for seed in range(PAIRS)]
    told = [(truth, one.bracket) for truth, one in message if one.bracket is not None]
    held = [low - 1e-9 <= truth <= high for truth, (low, high) in told]
    print(f"{colour}: the bracket of {len(told)} of {PAIRS} pairs holds {sum(held)}")
    assert len(told) > PAIRS / 2
    assert np.mean(held) >= HELD


def seen_by_a_ball(body, radius):
    """The heights that a ball scans: those of its lowest point, which its flanks push up."""
    away = SPACING * np.arange(-int(radius / SPACING), int(radius / SPACING) + 1)
    square = away[:, None] ** 2 + away**2
    ball = np.sqrt(np.maximum(radius**2 - square, 0)) - radius
    present = grey_dilation(body.heights, footprint=square <= radius**2, structure=ball, mode="wrap")
    return Surface(present, spacing=SPACING)


@pytest.mark.parametrize("hurst", [0.5, 0.8])
def test_bracket_of_blunt_tip_contains_true_result(hurst):
    rough = {
        "hurst_exponent": hurst, "rms": 0.01, "shape": (POINTS, POINTS), "spacing": SPACING,
        "longest_wavelength": POINTS * SPACING / 4, "shortest_wavelength": 6 * SPACING,
    }  # fmt: skip
    clean = rough_maps(1, **rough)
    truth = pair(*clean, cutoff="none", **ASKED).value
    (message,) = pair(*(seen_by_a_ball(item, 0.3) for item in clean), tip="300 nm", **ASKED).summary().headlines
    assert truth < message.value < truth + 0.25 * (truth - ASKED["mu0"])
    assert message.bracket[0] < truth < message.bracket[1]
    assert any("tip does not resolve" in caveat.text for caveat in message.caveats)
