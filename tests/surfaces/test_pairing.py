"""Tests of pairs of surfaces: lines and pieces cover both scans, and each pair depends only on its index."""

import numpy as np
import pytest
from stiction import Surface, flipped, self_affine, self_affine_surface
from stiction.surfaces.pairing import IsotropicSurfacePairs, LinePairs, MapPairs, quasi_random_point


def create_surface(shape=(64, 64), spacing=0.1, side="lower", seed=3):
    return self_affine_surface(seed, hurst_exponent=0.8, rms=0.02, shape=shape, spacing=spacing, side=side)


@pytest.mark.parametrize("dimensions", [1, 2, 4])
def test_quasi_random_points_are_evenly_spread(dimensions):
    points = np.array([quasi_random_point(index, dimensions) for index in range(256)])
    assert ((points >= 0) & (points < 1)).all()
    for count in (128, 256):
        for axis in range(dimensions):
            counts_per_bin = np.histogram(points[:count, axis], bins=8, range=(0, 1))[0]
            assert counts_per_bin.min() > 0.4 * count / 8


class TestLinePairs:
    def test_line_pairs_include_every_line_before_a_line_is_repeated(self):
        body = create_surface((30, 64))
        pairs = LinePairs(body, body, level=None, has_several_pairs=True)
        assert pairs.max_pair_count() == 30
        line_positions = [pairs.position_across_lines(index) for index in range(30)]
        assert np.unique(np.round(line_positions, 9)).size == 30
        for index in (0, 7, 29):
            upper, lower = pairs.pair(index)
            row = round(line_positions[index] / 0.1)
            np.testing.assert_array_equal(upper.heights, -body.heights[row])
            np.testing.assert_array_equal(lower.heights, body.heights[(row + 10) % 30])

    def test_line_pair_with_a_given_index_does_not_depend_on_pairs_created_earlier(self):
        profile = self_affine(1, hurst_exponent=0.8, rms=0.05, points=400, spacing=0.02)
        pairs = LinePairs(profile, profile, surrogates="both", has_several_pairs=True)
        assert pairs.max_pair_count() is None
        later_pair, first_pair = (
            pairs.pair(5),
            LinePairs(profile, profile, surrogates="both", has_several_pairs=True).pair(5),
        )
        for profile_of_later_pair, profile_of_first_pair in zip(later_pair, first_pair, strict=True):
            np.testing.assert_array_equal(profile_of_later_pair.heights, profile_of_first_pair.heights)


class TestMapPairs:
    def test_map_paired_with_itself_is_always_shifted(self):
        body = create_surface()
        pairs = MapPairs(flipped(body), body)
        shifts = np.array([pairs.map_shift(index) for index in range(30)])
        assert (shifts[:, 0] >= 6.4 / 8 - 1e-9).all()
        assert (np.abs(shifts) <= 6.4 / 4 + 1e-9).all()
        assert len(np.unique(shifts, axis=0)) == 30
        assert np.ptp(np.subtract(*(item.heights for item in pairs.pair(0)))) > 0.01

    def test_positions_of_map_pieces_cover_the_larger_map(self):
        small_map, large_map = create_surface((32, 32)), create_surface((200, 120), seed=4)
        for pairs in (MapPairs(small_map, large_map), MapPairs(large_map, small_map)):
            assert pairs.shape == (24, 24)
            large_map_index = 1 if pairs.lower is large_map else 0
            origins = np.array([pairs.piece_origins(index)[large_map_index] for index in range(64)])
            for axis, points in enumerate(large_map.heights.shape):
                assert np.histogram(origins[:, axis], bins=4, range=(0, points - 24))[0].min() >= 8
            for index in range(64):
                for origin, body in zip(pairs.piece_origins(index), (pairs.upper, pairs.lower), strict=True):
                    assert all(o >= 0 and o + 24 <= n for o, n in zip(origin, body.heights.shape, strict=True))
        assert pairs.piece_fractions == pytest.approx((24 * 24 / (200 * 120), 24 * 24 / 32**2))

    def test_paired_pieces_of_maps_have_the_finer_of_the_two_spacings(self):
        fine_map = create_surface((64, 64), 0.05)
        coarse_map = Surface(create_surface((64, 64), 0.05, seed=5).heights[::2, ::2], spacing=0.1)
        pairs = MapPairs(fine_map, coarse_map)
        assert pairs.spacing == (0.05, 0.05)
        upper, lower = pairs.pair(3)
        assert upper.heights.shape == lower.heights.shape == pairs.shape
        (row, column), _ = pairs.piece_origins(3)[1], None
        # The heights of the coarse points remain on the fine grid, except for the subtracted plane.
        rows, columns = pairs.shape
        y, x = np.arange(row, row + rows), np.arange(column, column + columns)
        is_coarse_point = np.ix_(y % 2 == 0, x % 2 == 0)
        height_differences = (
            lower.heights[is_coarse_point] - coarse_map.heights[np.ix_(y[y % 2 == 0] // 2, x[x % 2 == 0] // 2)]
        )
        grid_indices = np.meshgrid(*map(range, height_differences.shape), indexing="ij")
        plane = np.column_stack([np.ones(height_differences.size), *(place.ravel() for place in grid_indices)])
        squared_residuals = np.linalg.lstsq(plane, height_differences.ravel(), rcond=None)[1]
        assert np.sqrt(squared_residuals / height_differences.size) < 1e-9

    def test_pieces_paired_from_equal_maps_have_three_quarters_of_the_map_length(self):
        upper, lower = create_surface(side="upper"), create_surface()
        pairs = MapPairs(upper, lower)
        assert pairs.piece_area == pytest.approx(4.8**2)
        assert pairs.piece_fractions == pytest.approx((0.5625, 0.5625))

    def test_pairing_of_maps_rejects_overlaps_with_too_few_points(self):
        with pytest.raises(ValueError, match="overlap in at least 16 rows and columns"):
            MapPairs(create_surface((20, 64)), create_surface((20, 64))).pair(0)


def test_sides_of_isotropic_surfaces_from_two_profiles_are_three_quarters_of_the_shorter_profile_length():
    first_surface, second_surface = (
        self_affine(1, hurst_exponent=0.8, rms=0.05, points=points, spacing=spacing, side=side)
        for points, spacing, side in ((200, 0.02, "upper"), (300, 0.01, "lower"))
    )
    pairs = IsotropicSurfacePairs(first_surface, second_surface)
    assert pairs.spacing == (0.01, 0.01)
    assert pairs.shape == (225, 225)
    upper, lower = pairs.surrogates(0)
    assert upper.heights.shape == lower.heights.shape == (225, 225)
    assert abs(float(upper.heights.mean())) < 1e-12
