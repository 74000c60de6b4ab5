"""Tests of the registration of two faces that fit, and of the measure of fit."""

import numpy as np
import pytest
from stiction import Profile, Surface, levelled, rotated, self_affine_surface
from stiction.surfaces.registration import measure_fit, register_faces

ROUGH = {"hurst_exponent": 0.8, "rms": 100.0, "spacing": 50.0, "shortest_wavelength": 250.0}
LARGE = self_affine_surface(5, shape=(200, 200), **ROUGH)


def cut_piece(surface, row, column, points=128):
    return Surface(surface.heights[row : row + points, column : column + points], spacing=surface.spacing)


def test_registration_of_two_pieces_of_a_map_finds_their_shift_exactly():
    upper, lower, registration = register_faces(cut_piece(LARGE, 37, 28), cut_piece(LARGE, 30, 40))
    assert registration.shift == (350.0, -600.0)
    assert registration.rotation == 0
    assert upper.heights.shape == lower.heights.shape == (121, 116)
    np.testing.assert_allclose(np.std(upper.heights - lower.heights), 0, atol=1e-9)
    assert registration.correlation == pytest.approx(1)
    assert registration.rms_gap < 1e-9 < registration.rms_gap_before


@pytest.mark.parametrize("angle", [-2.2, 1.3])
def test_rotation_and_shift_are_found_despite_tilt_and_noise(angle):
    turned = rotated(LARGE, angle)
    first_row, first_column = ((np.array(turned.heights.shape) - 128) // 2).tolist()
    noise = np.random.default_rng(1).normal(0, 1.0, (128, 128)) + 0.5 * np.arange(128)
    piece = cut_piece(turned, first_row + 4, first_column - 3)
    _, _, registration = register_faces(Surface(piece.heights + noise, spacing=50.0), cut_piece(LARGE, 36, 36))
    assert registration.rotation == pytest.approx(-angle, abs=0.25)  # a quarter of a point at the ends
    np.testing.assert_allclose(registration.shift, (200.0, -150.0), atol=75)
    assert registration.rms_gap < 0.2 * registration.rms_gap_before


def test_profiles_are_registered_by_a_shift():
    line = LARGE.row(0)
    upper, lower = (Profile(line.heights[start : start + 128], spacing=50.0) for start in (20, 9))
    _, _, registration = register_faces(upper, lower)
    assert registration.shift == (550.0,)
    assert registration.rms_gap < 1e-9


def test_registration_ignores_missing_points():
    upper, lower = cut_piece(LARGE, 37, 28), cut_piece(LARGE, 30, 40)
    missing = np.zeros(lower.heights.shape, bool)
    missing[40:60, 50:90] = True
    holed = Surface(np.where(missing, 0.0, lower.heights), spacing=50.0, missing=missing)
    assert register_faces(upper, holed)[2].shift == (350.0, -600.0)


def test_measure_of_fit_is_high_only_for_faces_that_fit():
    other = cut_piece(self_affine_surface(6, shape=(200, 200), **ROUGH), 0, 0)
    piece = cut_piece(LARGE, 30, 40)
    assert measure_fit(piece, piece) == pytest.approx(1)
    assert measure_fit(cut_piece(LARGE, 37, 28), levelled(piece, "plane")) > 0.9
    assert measure_fit(other, piece) < 0.4
    assert measure_fit(other.row(3), piece.row(3)) < 0.9


def test_measure_of_fit_is_zero_for_periodic_textures_and_few_points():
    x = np.arange(256)
    grooves = Surface(np.tile(np.cos(2 * np.pi * x / 16), (64, 1)), spacing=1.0)
    assert measure_fit(grooves, grooves) == 0
    assert measure_fit(cut_piece(LARGE, 0, 0, points=12), cut_piece(LARGE, 0, 0, points=12)) == 0
