"""Tests of the roughness of the lines of a surface, compared with the roughness of single lines."""

import numpy as np
import pytest
from stiction import (
    Profile,
    Surface,
    estimate_hurst_exponent,
    levelled,
    line_roughness,
    power_spectrum,
    roughness_parameters,
    self_affine,
)
from stiction.surfaces import lines
from stiction.surfaces.lines import MAX_FITTED_LINES, lines_along_both

ROUND_OFF = 1e-12


def surface_of_stacked_rows(hurst, lines=40, points=600, **changes):
    """Return a surface that consists of independent self-affine rows, tilted along both axes."""
    rows = [
        self_affine(9, hurst_exponent=hurst, rms=0.1, points=points, spacing=0.02, repetition=row, **changes).heights
        for row in range(lines)
    ]
    tilt = 0.01 * np.arange(points) + 0.3 * np.arange(lines)[:, np.newaxis]
    return Surface(np.array(rows) + tilt, spacing=(0.5, 0.02))


def test_line_roughness_of_a_surface_equals_the_mean_over_its_lines():
    surface = surface_of_stacked_rows(0.6)
    result = line_roughness(surface, "x", band=(0.1, 2.0))
    x = np.arange(600)
    rows = [Profile(z - np.polyval(np.polyfit(x, z, 1), x), spacing=0.02) for z in surface.heights]
    parameters_of_rows = [roughness_parameters(row) for row in rows]
    assert result.lines == result.fitted == result.with_band == 40
    assert result.Pq == pytest.approx(np.sqrt(np.mean([row.Pq**2 for row in parameters_of_rows])), rel=ROUND_OFF)
    assert result.Pdq == pytest.approx(np.sqrt(np.mean([row.Pdq**2 for row in parameters_of_rows])), rel=ROUND_OFF)
    slopes = np.diff([row.heights for row in rows], axis=1) / 0.02
    assert result.Pdq_neighbours == pytest.approx(np.sqrt(np.mean(slopes**2)), rel=ROUND_OFF)
    assert np.allclose(result.spectrum.density, np.mean([power_spectrum(row).density for row in rows], axis=0))
    assert result.hurst_exponents == pytest.approx(
        [estimate_hurst_exponent(row, band=(0.1, 2.0)).value for row in rows]
    )


def test_roughness_along_y_equals_roughness_along_x_of_the_transposed_surface():
    surface = surface_of_stacked_rows(0.6, lines=12, points=300)
    transposed_surface = Surface(surface.heights.T, spacing=(0.02, 0.5))
    for direction, transposed_direction in (("x", "y"), ("y", "x")):
        result, transposed_result = (
            line_roughness(surface, direction),
            line_roughness(transposed_surface, transposed_direction),
        )
        assert transposed_result.Pq == result.Pq
        assert transposed_result.band == result.band
        assert np.array_equal(transposed_result.hurst_exponents, result.hurst_exponents)
        assert np.array_equal(transposed_result.spectrum.wave_number, result.spectrum.wave_number)


def test_line_roughness_is_invariant_under_levelling():
    surface = surface_of_stacked_rows(0.6, lines=12, points=300)
    for direction in ("x", "y"):
        result, levelled_result = (
            line_roughness(surface, direction),
            line_roughness(levelled(surface, "plane"), direction),
        )
        assert levelled_result.Pq == pytest.approx(result.Pq, rel=1e-9)
        assert levelled_result.hurst_exponents == pytest.approx(result.hurst_exponents, abs=1e-6)


def test_hurst_exponents_of_all_lines_are_fitted_in_a_common_band():
    hurst = 0.6
    result = line_roughness(surface_of_stacked_rows(hurst, lines=MAX_FITTED_LINES + 9, longest_wavelength=4.0), "x")
    assert result.fitted == MAX_FITTED_LINES == result.hurst_exponents.size
    assert result.with_band > 0.9 * result.fitted
    shortest_wavelength, longest_wavelength = result.band
    assert shortest_wavelength < 0.1
    assert 1.5 < longest_wavelength < 6
    mean, standard_deviation = result.hurst_exponents.mean(), result.hurst_exponents.std()
    # The tolerance is three standard errors of independent lines, plus 0.02, because the roll-off bends the spectrum.
    assert mean == pytest.approx(hurst, abs=3 * standard_deviation / np.sqrt(result.fitted) + 0.02)
    assert standard_deviation < 0.1


def test_flat_lines_contribute_to_the_rms_height_but_have_no_hurst_exponent():
    heights = np.array(surface_of_stacked_rows(0.6, lines=40).heights)
    heights[::2] = 3.0 + 0.01 * np.arange(600)
    result = line_roughness(Surface(heights, spacing=0.02), "x", band=(0.1, 2.0))
    assert result.Pq == pytest.approx(
        line_roughness(Surface(heights[1::2], spacing=0.02), "x").Pq / np.sqrt(2), rel=1e-9
    )
    assert result.hurst_exponents.size == 20 == result.with_band
    assert result.fitted == 40
    stripes = Surface(np.repeat([[0.1], [0.7], [0.3], [0.2]] * 3, 50, axis=1), spacing=1.0)
    result = line_roughness(stripes, "x")
    assert (result.Pq, result.Pdq, result.band, result.hurst_exponents.size, result.with_band) == (0, 0, None, 0, 0)


def test_line_roughness_has_no_common_band_if_few_lines_have_a_fitted_band():
    waves = np.sin(np.arange(700) / 20) + np.arange(9)[:, np.newaxis]
    result = line_roughness(Surface(waves, spacing=1.0), "x")
    assert result.band is None
    assert result.hurst_exponents.size == 0


@pytest.mark.parametrize(
    ("surface", "options", "message"),
    [
        (Surface(np.ones((9, 9)), spacing=1.0), {"along": "x"}, "surface must not be flat"),
        (Surface(np.eye(9)[:5], spacing=1.0), {"along": "y"}, "lines along y must have at least 7 points, got 5"),
        (surface_of_stacked_rows(0.6, lines=8), {"along": "z"}, "along must be one of 'x', 'y', got 'z'"),
        (
            surface_of_stacked_rows(0.6, lines=8),
            {"along": "x", "band": (0.1, 0.1001)},
            "band must contain at least 8 harmonics",
        ),
        (
            surface_of_stacked_rows(0.6, lines=8),
            {"along": "x", "band": 3},
            r"band must be a pair \(shortest, longest\) of wavelengths",
        ),
    ],
)
def test_line_roughness_rejects_invalid_arguments(surface, options, message):
    with pytest.raises(ValueError, match=message):
        line_roughness(surface, **options)


# ---- Both directions ------------------------------------------------------------------------------------------------


def two_scale_surface(seed=1, points=160):
    """Return a surface whose power law (H = 0.8) extends to 16 µm along rows and to 160 µm along columns."""
    white_noise = np.random.default_rng(seed).normal(size=(2 * points, 2 * points))
    q = 2 * np.pi * np.fft.fftfreq(2 * points)
    stretched_wave_numbers = np.hypot(np.maximum(np.abs(q), 0.4), q[:, np.newaxis])
    heights = np.fft.ifft2(stretched_wave_numbers**-1.8 * np.fft.fft2(white_noise)).real[:points, :points]
    return Surface(heights / heights.std(), spacing=1.0)


def test_hurst_exponents_of_lines_along_both_axes_are_fitted_in_a_common_band(monkeypatch):
    monkeypatch.setattr(lines, "MAX_FITTED_LINES", 12)
    surface = two_scale_surface()
    roughness_x, roughness_y = lines_along_both(surface)
    assert roughness_x.band == roughness_y.band is not None
    single_axis_result = line_roughness(surface, "y", band=roughness_y.band)
    assert np.array_equal(single_axis_result.hurst_exponents, roughness_y.hurst_exponents)
    assert (single_axis_result.with_band, single_axis_result.misfit) == (roughness_y.with_band, roughness_y.misfit)
    arguments = lines_along_both(surface, band=(4.0, 12.0))
    assert arguments[0].band == arguments[1].band == (4.0, 12.0)


def test_lines_along_straight_grooves_have_no_hurst_exponent():
    grooved_heights = self_affine(3, hurst_exponent=0.7, rms=0.1, points=300, spacing=1.0).heights + np.zeros((24, 1))
    roughness_x, roughness_y = lines_along_both(Surface(grooved_heights, spacing=1.0))
    assert roughness_x.hurst_exponents.size == 24
    assert roughness_y.hurst_exponents.size == 0
    assert np.isnan(roughness_y.misfit)


def test_power_law_misfit_is_near_1_for_a_power_law_spectrum_and_larger_for_a_bent_spectrum():
    straight_grooves = Surface(
        [
            self_affine(2, hurst_exponent=0.7, rms=0.1, points=512, spacing=1.0, periodic=True, amplitudes="fixed",
                        repetition=row).heights
            for row in range(40)
        ],
        spacing=1.0,
    )  # fmt: skip
    assert line_roughness(straight_grooves, "x", band=(3.0, 60.0)).misfit < 1.15
    surface_with_roll_off = surface_of_stacked_rows(0.7, points=512, longest_wavelength=0.3)
    assert line_roughness(surface_with_roll_off, "x", band=(0.05, 3.0)).misfit > 1.5
