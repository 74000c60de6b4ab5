"""Tests of the registration of two faces that fit, and of the measure of fit."""

import functools

import numpy as np
import pytest
from scipy.interpolate import RectBivariateSpline
from stiction import Profile, Surface, levelled, self_affine_surface
from stiction.surfaces.registration import MAX_ROTATION, measure_fit, register_faces

ROUGHNESS_OPTIONS = {"hurst_exponent": 0.8, "rms": 100.0, "spacing": 50.0, "shortest_wavelength": 250.0}
LARGE_MAP = self_affine_surface(5, shape=(200, 200), **ROUGHNESS_OPTIONS)


def cut_piece(surface, row, column, points=128):
    return Surface(surface.heights[row : row + points, column : column + points], spacing=surface.spacing)


def test_registration_of_two_pieces_of_a_map_finds_the_exact_shift():
    upper, lower, registration = register_faces(cut_piece(LARGE_MAP, 37, 28), cut_piece(LARGE_MAP, 30, 40))
    assert registration.shift == (350.0, -600.0)
    assert registration.rotation == 0
    assert upper.heights.shape == lower.heights.shape == (121, 116)
    np.testing.assert_allclose(np.std(upper.heights - lower.heights), 0, atol=1e-9)
    assert registration.correlation == pytest.approx(1)
    assert registration.rms_gap < 1e-9 < registration.rms_gap_before


@functools.cache
def interpolate_fine_map():
    """Return a spline through a map of twice the resolution, with another order than that of the registration."""
    fine_map = self_affine_surface(7, shape=(300, 300), **(ROUGHNESS_OPTIONS | {"spacing": 25.0}))
    return RectBivariateSpline(np.arange(300), np.arange(300), fine_map.heights, kx=5, ky=5)


def cut_moved_pair(angle, shift, noise=0.0, points=100):
    """Return two faces of a fine map. The upper is rotated by `angle` (degrees), and shifted along y and x (points)."""
    spline = interpolate_fine_map()
    rng, radians, distance = np.random.default_rng(1), np.radians(angle), np.arange(points) - (points - 1) / 2
    y, x = np.meshgrid(distance, distance, indexing="ij")
    rows = (y, x * np.sin(radians) + y * np.cos(radians) + shift[0])
    columns = (x, x * np.cos(radians) - y * np.sin(radians) + shift[1])
    lower, upper = (
        Surface(spline.ev(149.5 + 2 * row, 149.5 + 2 * column) + rng.normal(0, noise, (points, points)), spacing=50.0)
        for row, column in zip(rows, columns, strict=True)
    )
    return upper, lower


@pytest.mark.parametrize("noise", [0.0, 1.0])
@pytest.mark.parametrize("shift", [(0, 2), (0.5, 0), (3.25, -4.5)])
@pytest.mark.parametrize("angle", [0, 0.25, 0.5, -2])
def test_registration_finds_shift_and_rotation_to_a_fraction_of_a_grid_point(angle, shift, noise):
    _, _, registration = register_faces(*cut_moved_pair(angle, shift, noise, points=72))
    np.testing.assert_allclose(np.array(registration.shift) / 50, shift, atol=0.02)
    assert registration.rotation == pytest.approx(angle, abs=0.02)
    assert registration.rms_gap < 1.5 * max(noise, 0.05)
    assert registration.gap_noise == pytest.approx(np.sqrt(2) * noise, rel=0.25, abs=0.05)


def test_registration_of_a_large_map_finds_its_exact_shift():
    large_map = self_affine_surface(
        7, hurst_exponent=0.8, rms=1000.0, shape=(272, 272), spacing=500.0, shortest_wavelength=2000.0
    )
    _, _, registration = register_faces(cut_piece(large_map, 8, 10, points=256), cut_piece(large_map, 8, 8, points=256))
    assert (registration.shift, registration.rotation) == ((0, 1000), 0)
    assert registration.rms_gap < 1e-9


def test_registration_of_unmated_faces_keeps_the_rotation_within_its_limit():
    unrelated_face = self_affine_surface(9, shape=(64, 64), **ROUGHNESS_OPTIONS)
    rotations = [
        register_faces(cut_piece(LARGE_MAP, row, row, points=64), unrelated_face)[2].rotation
        for row in (0, 40, 80, 120)
    ]
    assert np.abs(rotations).max() <= MAX_ROTATION + 1e-9


def test_registration_finds_rotation_and_shift_despite_tilt_and_unequal_shapes():
    upper, lower = cut_moved_pair(1.3, (4, -3), noise=1.0)
    tilted_piece = Surface(upper.heights[:90] + 0.5 * np.arange(100), spacing=50.0)
    _, _, registration = register_faces(tilted_piece, lower)
    assert registration.rotation == pytest.approx(1.3, abs=0.02)
    middle = np.array([-5 * np.cos(np.radians(1.3)) + 4, 5 * np.sin(np.radians(1.3)) - 3])
    np.testing.assert_allclose(np.array(registration.shift) / 50, middle, atol=0.02)


def test_profiles_are_registered_by_a_shift():
    line = LARGE_MAP.row(0)
    upper, lower = (Profile(line.heights[start : start + 128], spacing=50.0) for start in (20, 9))
    _, _, registration = register_faces(upper, lower)
    assert registration.shift == (550.0,)
    assert registration.rms_gap < 1e-9


def test_registration_of_profiles_finds_shifts_between_grid_points():
    fine_map = self_affine_surface(7, shape=(4, 600), **(ROUGHNESS_OPTIONS | {"spacing": 25.0})).row(0)
    upper, lower = (Profile(fine_map.heights[start : start + 256 : 2], spacing=50.0) for start in (23, 16))
    _, _, registration = register_faces(upper, lower)
    assert registration.shift[0] == pytest.approx(175, abs=0.5)


def test_registration_ignores_missing_points():
    upper, lower = cut_piece(LARGE_MAP, 37, 28), cut_piece(LARGE_MAP, 30, 40)
    is_missing = np.zeros(lower.heights.shape, bool)
    is_missing[40:60, 50:90] = True
    face_with_holes = Surface(np.where(is_missing, 0.0, lower.heights), spacing=50.0, missing=is_missing)
    assert register_faces(upper, face_with_holes)[2].shift == (350.0, -600.0)


def test_measure_of_fit_is_high_only_for_mated_faces():
    unrelated_face = cut_piece(self_affine_surface(6, shape=(200, 200), **ROUGHNESS_OPTIONS), 0, 0)
    piece = cut_piece(LARGE_MAP, 30, 40)
    assert measure_fit(piece, piece) == pytest.approx(1)
    assert measure_fit(cut_piece(LARGE_MAP, 37, 28), levelled(piece, "plane")) > 0.9
    assert measure_fit(unrelated_face, piece) < 0.4
    assert measure_fit(unrelated_face.row(3), piece.row(3)) < 0.9


def test_measure_of_fit_is_zero_for_periodic_textures_and_few_points():
    x = np.arange(256)
    grooves = Surface(np.tile(np.cos(2 * np.pi * x / 16), (64, 1)), spacing=1.0)
    assert measure_fit(grooves, grooves) == 0
    assert measure_fit(cut_piece(LARGE_MAP, 0, 0, points=12), cut_piece(LARGE_MAP, 0, 0, points=12)) == 0
