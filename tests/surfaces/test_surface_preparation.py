"""Tests of the preparation of maps: levelling, flipping, cropping, common grids and surrogates."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from stiction import (
    Profile,
    Surface,
    cropped,
    flipped,
    levelled,
    on_common_grid,
    read_surface,
    rotated,
    surface_parameters,
    surface_spectrum,
    surrogate,
    write_surface,
)
from stiction.surfaces.preparation import count_flips, list_history_without_flips

ROUND_OFF = 1e-12


def bumpy_surface(shape=(60, 80), spacing=(0.2, 0.1)):
    """Return a surface with smooth heights, and the function that defines the heights."""

    def height(y, x):
        return np.sin(1.1 * x + 0.3) * np.cos(0.7 * y) + 0.2 * x

    y, x = spacing[0] * np.arange(shape[0])[:, np.newaxis], spacing[1] * np.arange(shape[1])
    return Surface(height(y, x), spacing=spacing), height


def test_levelling_a_surface_subtracts_the_least_squares_polynomial():
    surface, _ = bumpy_surface()
    y, x = np.broadcast_arrays(surface.y[:, np.newaxis], surface.x)
    for degree, trend in enumerate(("mean", "plane", "quadratic")):
        levelled_surface = levelled(surface, trend)
        terms = [(x**i * y**j).ravel() for i in range(degree + 1) for j in range(degree + 1 - i)]
        terms = np.stack(terms, axis=1)
        fit = terms @ np.linalg.lstsq(terms, surface.heights.ravel(), rcond=None)[0]
        assert levelled_surface.heights == pytest.approx(surface.heights - fit.reshape(60, 80), abs=1e-10)
        assert levelled_surface.spacing == surface.spacing
    assert levelled_surface.history == ("levelled by a polynomial of second degree",)
    paraboloid = Surface(3 + 2 * x - y + x * y - 4 * x**2 + 0.5 * y**2, spacing=surface.spacing)
    assert not levelled(paraboloid, "quadratic").heights.any()


def test_flipping_rotates_a_surface_about_the_x_axis():
    surface, _ = bumpy_surface()
    flipped_surface = flipped(surface)
    assert flipped_surface.heights[0, 5] == -surface.heights[-1, 5]
    assert np.array_equal(flipped(flipped_surface).heights, surface.heights)
    assert flipped_surface.history == ("flipped",)
    assert count_flips(flipped(flipped_surface)) == 2
    assert list_history_without_flips(flipped_surface) == ()


def test_flip_recorded_in_a_file_of_an_earlier_version_is_recognised(tmp_path):
    surface = Surface(np.eye(8), spacing=1.0, history=("turned over", "levelled by a plane"))
    write_surface(surface, tmp_path / "old.npy")
    read_back = read_surface(tmp_path / "old.npy")
    assert count_flips(read_back) == 1
    assert list_history_without_flips(read_back) == ("read from old.npy", "levelled by a plane")


def test_adjacent_crops_joined_together_equal_the_original_surface():
    surface, _ = bumpy_surface()
    pieces = [
        [cropped(surface, (y0, x0), (y1, x1)).heights for x0, x1 in ((0, 3.05), (3.05, 8.0))]
        for y0, y1 in ((0, 4.4), (4.4, 12.0))
    ]
    assert np.array_equal(np.block(pieces), surface.heights)
    assert cropped(surface, (1.0, 2.0), (5.0, 6.0)).history == ("cropped to 1 to 5 µm along y and 2 to 6 µm along x",)
    assert np.array_equal(cropped(surface, (1.0, 2.0)).heights, surface.heights[5:, 20:])
    for start, stop, message in (
        ((0, 7.0), (9, 9.0), "within the extent of 8 µm along x"),
        ((0, 0), (0.5, 8), "start and stop must leave at least 4 points, got .* from 0 to 0.5 µm along y"),
        ((0, 0, 0), None, r"must be pairs \(y, x\)"),
    ):
        with pytest.raises(ValueError, match=message):
            cropped(surface, start, stop)


def test_common_grid_has_the_finer_spacing_along_each_axis():
    fine_surface, _ = bumpy_surface((60, 40), (0.1, 0.2))
    coarse_surface, height = bumpy_surface((30, 100), (0.25, 0.1))
    fine_resampled, coarse_resampled = on_common_grid(fine_surface, coarse_surface)
    assert fine_resampled.spacing == coarse_resampled.spacing == (0.1, 0.1)
    assert fine_resampled.heights.shape == coarse_resampled.heights.shape == (60, 79)
    # Along x, the coarse map is unchanged. Along y, each of its columns is interpolated by a natural spline.
    splined_heights = CubicSpline(0.25 * np.arange(30), coarse_surface.heights[:, :79], bc_type="natural")(
        0.1 * np.arange(60)
    )
    assert coarse_resampled.heights == pytest.approx(splined_heights, abs=ROUND_OFF)
    inner_errors = coarse_resampled.heights[10:50, :] - height(
        coarse_resampled.y[10:50, np.newaxis], coarse_resampled.x
    )
    assert np.abs(inner_errors).max() < 1e-3  # The natural spline is accurate away from its ends.
    assert on_common_grid(fine_surface, fine_surface)[0] is fine_surface
    with pytest.raises(
        ValueError, match="both bodies must be profiles or both must be surfaces, got Surface and Profile"
    ):
        on_common_grid(fine_surface, Profile(np.arange(9.0), spacing=1.0))


def test_maps_aligned_at_the_middle_have_equal_heights_on_their_common_grid():
    small_map, height = bumpy_surface((41, 61), (0.1, 0.1))
    # The expected map is the same function on a larger map, whose origin is shifted by 1 µm along -y and 2 µm along -x.
    for shape, spacing in (((61, 101), 0.1), ((25, 41), 0.25)):
        y, x = spacing * np.arange(shape[0])[:, np.newaxis] - 1.0, spacing * np.arange(shape[1]) - 2.0
        for pair in (
            (small_map, Surface(height(y, x), spacing=spacing)),
            (Surface(height(y, x), spacing=spacing), small_map),
        ):
            first_map, second_map = on_common_grid(*pair, align="middle")
            assert first_map.spacing == second_map.spacing == (0.1, 0.1)
            assert first_map.heights.shape == second_map.heights.shape == (41, 61)
            assert np.abs(first_map.heights - second_map.heights).max() < 3e-4
    assert second_map.history == () or "about its middle" in "".join((*first_map.history, *second_map.history))
    lines = on_common_grid(Profile(np.arange(9.0), spacing=1.0), Profile(np.arange(5.0), spacing=1.0), align="middle")
    assert lines[0].heights.tolist() == [2, 3, 4, 5, 6]
    assert lines[0].history == ("cropped to its middle 5 points",)
    lines_half_a_point_apart = on_common_grid(
        Profile(np.arange(8.0), spacing=1.0), Profile(np.arange(5.0), spacing=1.0), align="middle"
    )
    assert lines_half_a_point_apart[0].heights.tolist() == [1, 2, 3, 4, 5]
    maps_with_rotated = on_common_grid(rotated(small_map, 30), small_map, align="middle")
    cropped_heights = maps_with_rotated[1].heights
    rows, columns = (41 - cropped_heights.shape[0]) // 2, (61 - cropped_heights.shape[1]) // 2
    assert np.array_equal(
        cropped_heights,
        small_map.heights[rows : rows + cropped_heights.shape[0], columns : columns + cropped_heights.shape[1]],
    )
    with pytest.raises(ValueError, match="align must be one of 'start', 'middle', got 'end'"):
        on_common_grid(small_map, small_map, align="end")


@pytest.mark.parametrize("quarter_turns", [-1, 0, 1, 2, 3, 5])
def test_rotation_by_multiples_of_90_degrees_preserves_heights(quarter_turns):
    surface, _ = bumpy_surface()
    rotated_surface = rotated(surface, 90 * quarter_turns)
    assert np.array_equal(np.sort(rotated_surface.heights, axis=None), np.sort(surface.heights, axis=None))
    assert np.array_equal(rotated(rotated_surface, -90 * quarter_turns).heights, surface.heights)
    assert rotated_surface.spacing == (surface.spacing if quarter_turns % 2 == 0 else surface.spacing[::-1])


@pytest.mark.parametrize("angle", [-60, 17, 45, 90, 100, 213])
@pytest.mark.parametrize("shape", [(80, 70), (30, 140)])
def test_rotated_surface_equals_its_height_function_at_rotated_points(angle, shape):
    surface, height = bumpy_surface(shape, (0.1, 0.1))
    rotated_surface = rotated(surface, angle)
    middle_position = [(points - 1) * 0.05 for points in shape]
    rotated_middle = [(points - 1) * 0.05 for points in rotated_surface.heights.shape]
    y, x = rotated_surface.y[:, np.newaxis] - rotated_middle[0], rotated_surface.x - rotated_middle[1]
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    original_y, original_x = middle_position[0] - s * x + c * y, middle_position[1] + c * x + s * y
    for original_positions, length in ((original_y, shape[0]), (original_x, shape[1])):
        assert original_positions.min() > -1e-9
        assert original_positions.max() < (length - 1) * 0.1 + 1e-9
    expected = height(original_y, original_x)
    errors = np.abs(rotated_surface.heights - expected)
    assert np.median(errors) < 1e-6
    assert errors.max() < 1e-4
    if angle != 90:
        assert "% cut off" in rotated_surface.history[-1]


def test_texture_direction_of_rotated_grooves_is_the_rotation_angle():
    x = 0.1 * np.arange(300)
    grooved_surface = Surface(np.sin(2 * np.pi * x / 2.0) + np.zeros((300, 1)), spacing=0.1)
    assert surface_parameters(rotated(grooved_surface, 33)).Std == pytest.approx(33, abs=2)


def test_rotation_rejects_a_narrow_strip():
    with pytest.raises(ValueError, match="angle must leave at least 4 rows and points per row, got 3 rows"):
        rotated(Surface(np.random.default_rng(1).normal(size=(5, 90)), spacing=1.0), 45)


@pytest.mark.parametrize("shape", [(40, 50), (41, 50), (40, 51), (41, 51)])
def test_surrogate_of_a_periodic_surface_has_the_same_spectrum(shape):
    surface = Surface(3.0 + np.random.default_rng(1).normal(size=shape), spacing=(0.2, 0.1))
    other_surrogate = surrogate(surface, 7, periodic=True)
    density, surrogate_density = (surface_spectrum(item, periodic=True).density for item in (surface, other_surrogate))
    assert surrogate_density == pytest.approx(density, rel=1e-9, abs=1e-9 * density.max())
    assert other_surrogate.heights.mean() == pytest.approx(3, abs=0.2)
    assert other_surrogate.heights.mean() == pytest.approx(surface.heights.mean(), rel=ROUND_OFF)
    # The surfaces have about 2000 independent heights.
    assert abs(np.corrcoef(surface.heights.ravel(), other_surrogate.heights.ravel())[0, 1]) < 0.1
    assert np.array_equal(surrogate(surface, 7, periodic=True).heights, other_surrogate.heights)
    assert not np.array_equal(surrogate(surface, 7, repetition=1, periodic=True).heights, other_surrogate.heights)


def test_surrogate_of_a_surface_preserves_its_heights_and_slopes_and_lay():
    # The lay is at 31 degrees. Mirror images along both axes would mix this direction with -31 degrees.
    size = 256
    q_y, q_x = 2 * np.pi * np.fft.fftfreq(2 * size)[:, np.newaxis], 2 * np.pi * np.fft.fftfreq(2 * size)
    angle = np.radians(31)
    q_along, q_across = q_x * np.cos(angle) + q_y * np.sin(angle), q_y * np.cos(angle) - q_x * np.sin(angle)
    amplitude = np.maximum(np.hypot(q_along, 3 * q_across), 0.4) ** -1.8
    noise_transform = np.fft.fft2(np.random.default_rng(3).normal(size=(2 * size, 2 * size)))
    surface = Surface(np.fft.ifft2(amplitude * noise_transform).real[:size, :size], spacing=0.1)
    result = surface_parameters(surface)
    surrogate_parameters = [surface_parameters(surrogate(surface, 5, repetition=r)) for r in range(6)]
    assert surrogate_parameters[0].Sq == pytest.approx(result.Sq, rel=ROUND_OFF)
    # The window emphasises the middle of the map, whose long wavelengths differ from those of the complete map.
    for name, tolerance in (("Sdq", 0.1), ("Sal", 0.2), ("Str", 0.3)):
        assert np.mean([getattr(parameters, name) for parameters in surrogate_parameters]) == pytest.approx(
            getattr(result, name), rel=tolerance
        )
    q, direction, density = surface_spectrum(surrogate(surface, 5)).waves()
    is_long = q < 20
    power_near_lay = [density[is_long & (np.abs(direction - lay) < 10)].sum() for lay in (31, 149)]
    assert power_near_lay[0] > 3 * power_near_lay[1]
