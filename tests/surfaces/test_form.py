"""Tests of form removal: polynomials of any degree, circles, spheres and cylinders, compared with exact forms."""

import numpy as np
import pytest
from stiction import Profile, Surface, levelled

NOISE_RMS = 1e-3


def grid_coordinates(rows=60, columns=80, spacing=0.5):
    return spacing * np.arange(rows)[:, np.newaxis], spacing * np.arange(columns)


def create_noise_heights(shape, seed=1):
    return NOISE_RMS * np.random.default_rng(seed).normal(size=shape)


def parse_radius_from_history(body):
    words = body.history[-1].split()
    return float(words[-2]), words[3]


@pytest.mark.parametrize(("trend", "degree"), [("cubic", 3), ("quartic", 4), ("quintic", 5), ("sextic", 6)])
def test_levelling_removes_only_polynomials_up_to_the_given_degree(trend, degree):
    t = np.linspace(-1, 2, 200)
    for power in range(8):
        residuals = levelled(Profile(3 * t**power + t, spacing=0.1), trend).heights
        assert (np.abs(residuals).max() < 1e-11) == (power <= degree)
    y, x = grid_coordinates()
    y, x = y / 10 - 1, x / 10 - 2
    assert np.abs(levelled(Surface(x ** (degree - 1) * y, spacing=0.5), trend).heights).max() < 1e-11
    assert np.abs(levelled(Surface(x**degree * y, spacing=0.5), trend).heights).max() > 1e-3


@pytest.mark.parametrize("trend", ["cubic", "sextic"])
def test_levelling_subtracts_the_polynomial_of_a_direct_least_squares_fit(trend):
    degree = {"cubic": 3, "sextic": 6}[trend]
    heights = np.random.default_rng(2).normal(size=(20, 25))
    y, x = np.meshgrid(np.linspace(-1, 1, 20), np.linspace(-1, 1, 25), indexing="ij")
    design_matrix = np.stack([(y**j * x**i).ravel() for j in range(degree + 1) for i in range(degree + 1 - j)], axis=1)
    fit = design_matrix @ np.linalg.lstsq(design_matrix, heights.ravel(), rcond=None)[0]
    result = levelled(Surface(heights, spacing=0.5), trend).heights
    assert np.abs(result - (heights.ravel() - fit).reshape(heights.shape)).max() < 1e-11


@pytest.mark.parametrize(("sign", "word"), [(1, "convex"), (-1, "concave")])
def test_levelling_removes_a_sphere_and_leaves_the_noise(sign, word):
    y, x = grid_coordinates()
    spherical_heights = sign * np.sqrt(300.0**2 - (x - 5) ** 2 - (y - 25) ** 2)
    noise = create_noise_heights(spherical_heights.shape)
    result = levelled(Surface(spherical_heights + noise, spacing=0.5), "sphere")
    assert parse_radius_from_history(result) == (pytest.approx(300, rel=1e-3), word)
    # Levelling reduces the noise slightly, because a sphere with four parameters is fitted to 4800 points.
    assert result.heights.std() == pytest.approx(noise.std(), rel=2e-3)
    assert result.heights.mean() == pytest.approx(0, abs=1e-12)


def test_levelling_removes_a_tilted_cylinder_and_leaves_the_noise():
    y, x = grid_coordinates()
    x_across, x_along = (x - 12) * 0.6 + (y - 20) * 0.8, 0.8 * x - 0.6 * y
    noise = create_noise_heights((60, 80))
    result = levelled(Surface(np.sqrt(200.0**2 - x_across**2) + 0.02 * x_along + noise, spacing=0.5), "cylinder")
    # The expected radius of the cylinder is that of a vertical section, because its axis rises by 2 %.
    assert parse_radius_from_history(result)[0] == pytest.approx(200, rel=2e-3)
    assert result.heights.std() == pytest.approx(noise.std(), rel=2e-3)


def test_levelling_removes_a_circle_and_leaves_the_noise():
    x = np.arange(1000.0)
    noise = create_noise_heights(1000)
    result = levelled(Profile(np.sqrt(2000.0**2 - (x - 700) ** 2) + noise, spacing=1.0), "circle")
    assert parse_radius_from_history(result)[0] == pytest.approx(2000, rel=1e-4)
    assert result.heights.std() == pytest.approx(noise.std(), rel=3e-3)


def test_form_removal_ignores_missing_points():
    x = np.arange(400.0)
    heights, is_missing = np.sqrt(2000.0**2 - (x - 150) ** 2), np.zeros(400, bool)
    is_missing[50:80] = True
    filled_heights = np.where(is_missing, heights + 5, heights)
    for trend in ("circle", "sextic"):
        residuals = levelled(Profile(filled_heights, spacing=1.0, missing=is_missing), trend).heights
        assert np.abs(residuals[~is_missing]).max() < 1e-5


def test_form_removal_changes_the_heights_of_pure_noise_only_slightly():
    noise = create_noise_heights((60, 80))
    for trend in ("sphere", "cylinder"):
        result = levelled(Surface(noise, spacing=0.5), trend).heights
        assert result.std() == pytest.approx(noise.std(), rel=5e-3)


def test_levelling_rejects_a_sphere_for_profiles_and_a_circle_for_surfaces():
    with pytest.raises(ValueError, match="trend must be one of"):
        levelled(Profile(np.arange(9.0), spacing=1.0), "sphere")
    with pytest.raises(ValueError, match="trend must be one of"):
        levelled(Surface(create_noise_heights((9, 9)), spacing=1.0), "circle")
