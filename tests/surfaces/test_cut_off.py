"""Tests of the Gaussian filter against its definition, its transmission and its invariances."""

import math

import numpy as np
import pytest
from stiction import Profile, Surface, cut_off, surface_spectrum
from stiction.surfaces.filters import gaussian_transmission
from support.rough_surfaces import rough_profile, self_affine_map

ROUND_OFF = 1e-12

WEIGHT_TOLERANCE = 1e-6
"""Relative error of heights for cutoffs of nine points or more. Sampled Gaussian weights and a transform truncated at
the Nyquist wavenumber differ by exp(-ln 2 (λ_c/2Δx)²)."""

# Relative error of an amplitude due to truncated weights at wavelengths of two to five points.
TRUNCATION_TOLERANCE = 1e-4


def low_pass_filter_by_definition(heights, spacing, wavelength):
    """Return the height of a least-squares line at each point, with the Gaussian weights of ISO 16610-21."""
    alpha = math.sqrt(math.log(2) / math.pi)
    x = np.arange(heights.size) * spacing
    smoothed_heights = []
    for centre in x:
        weight = np.exp(-np.pi * ((x - centre) / (alpha * wavelength)) ** 2)
        design_matrix = np.stack([np.ones(x.size), x - centre], axis=1)
        normal_matrix = design_matrix.T @ (weight[:, np.newaxis] * design_matrix)
        smoothed_heights.append(np.linalg.solve(normal_matrix, design_matrix.T @ (weight * heights))[0])
    return np.array(smoothed_heights)


@pytest.mark.parametrize("points", [8, 15, 66.6])
def test_low_pass_filter_equals_locally_weighted_line_fit(points):
    profile = rough_profile(points=200)
    wavelength = points * profile.spacing
    smoothed_heights = cut_off(profile, wavelength).heights
    expected = low_pass_filter_by_definition(profile.heights, profile.spacing, wavelength)
    tolerance = max(WEIGHT_TOLERANCE, 2 ** -((points / 2) ** 2)) * np.ptp(profile.heights)
    assert np.abs(smoothed_heights - expected).max() < tolerance


def test_low_pass_filter_smooths_a_surface_along_both_axes():
    surface = self_affine_map(1, 0.7, (40, 60), spacing=(0.5, 0.25))
    filtered_rows = np.array([low_pass_filter_by_definition(row, 0.25, 4.0) for row in surface.heights])
    filtered_heights = np.array([low_pass_filter_by_definition(column, 0.5, 4.0) for column in filtered_rows.T]).T
    # For cutoffs of at least eight points, the error of the fast filter is below 2^-16 of the height range.
    assert np.abs(cut_off(surface, 4.0).heights - filtered_heights).max() < 2**-16 * np.ptp(surface.heights)


@pytest.mark.parametrize("wavelength", [0.2, 0.25, 0.4, 1.0, 5.0])
@pytest.mark.parametrize("periodic", [True, False])
def test_low_pass_filter_has_gaussian_transmission_that_is_one_half_at_the_cutoff(wavelength, periodic):
    x = 0.1 * np.arange(2000)
    for length in (0.25, 0.4, 0.5, 1.0, 5.0, 20.0):
        waves = np.stack([np.cos(2 * np.pi * x / length), np.sin(2 * np.pi * x / length)], axis=1)
        smoothed_heights = cut_off(Profile(7 + waves[:, 0], spacing=0.1), wavelength, periodic=periodic).heights - 7
        middle_range = slice(700, 1300)
        amplitude = np.hypot(*np.linalg.lstsq(waves[middle_range], smoothed_heights[middle_range], rcond=None)[0])
        expected = math.exp(-math.log(2) * (wavelength / length) ** 2)
        assert amplitude == pytest.approx(expected, abs=ROUND_OFF if periodic else TRUNCATION_TOLERANCE)
        assert gaussian_transmission(2 * np.pi / length, wavelength) == pytest.approx(expected, rel=ROUND_OFF)


def test_low_pass_filter_of_a_periodic_surface_is_isotropic():
    surface = self_affine_map(2, 0.6, (64, 96))
    filtered_spectrum = surface_spectrum(cut_off(surface, 4.0, periodic=True), periodic=True)
    original_spectrum = surface_spectrum(surface, periodic=True)
    q = np.hypot(original_spectrum.wave_number_y[:, np.newaxis], original_spectrum.wave_number_x)
    assert np.allclose(
        filtered_spectrum.density, original_spectrum.density * gaussian_transmission(q, 4.0) ** 2, rtol=1e-9, atol=1e-12
    )


@pytest.mark.parametrize("wavelength", [0.2, 0.3, 1.0, 13.0])
def test_low_pass_filter_preserves_straight_lines_and_planes_up_to_the_edges(wavelength):
    x = 0.1 * np.arange(400)
    line = Profile(100 + 3 * x, spacing=0.1)
    plane = Surface(5 - 3 * x[:, np.newaxis] + 2 * x, spacing=0.1)
    for body in (line, plane):
        assert np.abs(cut_off(body, wavelength).heights - body.heights).max() < ROUND_OFF * 200


def test_low_pass_filter_commutes_with_sums_and_reversal_and_scaling():
    first_profile, second_profile = rough_profile(1, points=300), rough_profile(2, points=300)
    sum_of_both = cut_off(Profile(first_profile.heights + 2 * second_profile.heights, spacing=0.01), 0.2).heights
    assert sum_of_both == pytest.approx(
        cut_off(first_profile, 0.2).heights + 2 * cut_off(second_profile, 0.2).heights, abs=ROUND_OFF
    )
    reversed_heights = cut_off(Profile(first_profile.heights[::-1], spacing=0.01), 0.2).heights[::-1]
    assert reversed_heights == pytest.approx(cut_off(first_profile, 0.2).heights, abs=ROUND_OFF)
    enlarged_heights = cut_off(Profile(1e4 * first_profile.heights, spacing=100.0), 2000.0).heights
    assert enlarged_heights == pytest.approx(1e4 * cut_off(first_profile, 0.2).heights, rel=1e-9, abs=1e-8)
    surface = self_affine_map(1, 0.7, (40, 60), spacing=(0.5, 0.25))
    transposed_heights = cut_off(Surface(surface.heights.T, spacing=(0.25, 0.5)), 3.0).heights.T
    assert transposed_heights == pytest.approx(cut_off(surface, 3.0).heights, abs=ROUND_OFF)


def test_low_pass_filter_is_recorded_in_the_history_and_preserves_the_grid():
    profile = Profile(np.arange(60.0), spacing=0.1, history=("ground",))
    smoothed_profile = cut_off(profile, 0.5)
    assert smoothed_profile.history == (
        "ground",
        "low-pass filtered at 0.5 µm (cutoff wavelength of a Gaussian filter)",
    )
    assert smoothed_profile.spacing == profile.spacing
    surface = Surface(np.eye(12), spacing=(0.5, 0.25))
    assert isinstance(cut_off(surface, 0.5), Surface)
    assert cut_off(surface, 1.0).spacing == surface.spacing
    assert not cut_off(Surface(np.ones((12, 12)), spacing=1.0), 3.0).heights.std()


@pytest.mark.parametrize(
    ("body", "wavelength", "message"),
    [
        (
            rough_profile(),
            0.004,
            r"wavelength must be between 0.005 µm \(half the spacing\) and 3.3\d* µm \(a third of the shortest side\)",
        ),
        (rough_profile(), 3.4, "wavelength must be between 0.005 µm"),
        (rough_profile(), 0.0, "wavelength must be a finite number above 0"),
        (rough_profile(), "1 mN", "wavelength has the unit .mN., which is not a unit of length"),
        (Surface(np.eye(20), spacing=(1.0, 0.1)), 0.7, r"0.666667 µm \(a third of the shortest side\)"),
        ([1.0, 2.0], 1.0, "body must be a Profile or a Surface, got list"),
    ],
)
def test_low_pass_filter_rejects_invalid_arguments(body, wavelength, message):
    with pytest.raises(ValueError, match=message):
        cut_off(body, wavelength)


def test_low_pass_filter_accepts_the_smallest_and_the_largest_allowed_cutoff():
    assert len(cut_off(rough_profile(), 0.02)) == len(cut_off(rough_profile(), 10 / 3)) == 1000
