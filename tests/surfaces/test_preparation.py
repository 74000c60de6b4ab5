import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stiction import Profile, Surface, contacts, cropped, flipped, levelled, on_common_grid

ROUND_OFF = 1e-13
# Minimum order of convergence: four, which holds away from the ends, minus a margin.
# Natural end conditions reduce the order only near the ends.
MIN_SPLINE_CONVERGENCE_ORDER = 3.7


def rough_profile(points, spacing=0.1, seed=1):
    return Profile(np.random.default_rng(seed).normal(size=points), spacing=spacing)


# ---- Levelling ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("trend", "degree"), [("mean", 0), ("line", 1), ("quadratic", 2)])
def test_levelling_a_profile_subtracts_the_least_squares_polynomial(trend, degree):
    profile = rough_profile(101)
    detrended_heights = profile.heights - np.polynomial.Polynomial.fit(profile.x, profile.heights, degree)(profile.x)
    result = levelled(profile, trend)
    assert np.abs(result.heights - detrended_heights).max() < ROUND_OFF
    assert result.spacing == profile.spacing


@given(
    seed=st.integers(0, 2**32), points=st.integers(4, 300), coefficients=st.tuples(*[st.floats(-1, 1)] * 3),
)  # fmt: skip
@settings(max_examples=50)
def test_levelling_removes_an_added_trend(seed, points, coefficients):
    profile = rough_profile(points, seed=seed)
    t = np.linspace(-1, 1, points)
    bent_profile = Profile(profile.heights + np.polynomial.Polynomial(coefficients)(t), spacing=0.1)
    assert (
        np.abs(levelled(bent_profile, "quadratic").heights - levelled(profile, "quadratic").heights).max() < ROUND_OFF
    )
    levelled_profile = levelled(profile, "line")
    assert np.abs(levelled(levelled_profile, "line").heights - levelled_profile.heights).max() < ROUND_OFF


def test_levelling_is_accurate_for_a_large_tilt():
    profile = levelled(rough_profile(10_000), "line")
    tilted_profile = Profile(1e-3 * profile.heights + 100 * profile.x, spacing=profile.spacing)
    # Round-off is 1e-16 of the largest height, 1e5 µm.
    assert np.abs(levelled(tilted_profile, "line").heights - 1e-3 * profile.heights).max() < 1e-10


def test_levelling_rejects_a_plane_for_profiles_and_a_line_for_surfaces():
    with pytest.raises(ValueError, match=r"trend must be one of 'mean', 'line', .*, got 'plane'"):
        levelled(rough_profile(9), "plane")
    with pytest.raises(ValueError, match=r"trend must be one of 'mean', 'plane', .*, got 'line'"):
        levelled(Surface(np.eye(3), spacing=1.0), "line")
    with pytest.raises(ValueError, match="body must be a Profile or a Surface, got list"):
        levelled([1.0, 2.0], "line")


# ---- Cropping -------------------------------------------------------------------------------------------------------


@given(points=st.integers(8, 200), cut_fraction=st.floats(0.05, 0.95), spacing=st.sampled_from([0.1, 0.3, 1 / 3, 7.0]))
def test_adjacent_crops_joined_together_equal_the_original_profile(points, cut_fraction, spacing):
    profile = rough_profile(points, spacing)
    cut_position = min(max(round(cut_fraction * points), 4), points - 4) * spacing
    left_piece, right_piece = cropped(profile, stop=cut_position), cropped(profile, cut_position)
    assert np.array_equal(np.concatenate([left_piece.heights, right_piece.heights]), profile.heights)
    assert np.array_equal(cropped(profile, 0, profile.extent).heights, profile.heights)


def test_cropped_profile_starts_at_the_first_grid_point_in_the_given_range():
    profile = Profile(np.arange(10.0), spacing=0.1)
    assert cropped(profile, 0.15, 0.65).heights.tolist() == [2, 3, 4, 5, 6]
    assert cropped(profile, 0.3, 0.7).heights.tolist() == [3, 4, 5, 6]


@pytest.mark.parametrize(
    ("start", "stop", "match"),
    [
        (0.5, 0.5, "start must be below stop, and both must be within the extent of 1 µm, got 0.5 and 0.5 µm"),
        (-0.1, None, "within the extent"),
        (0, 1.1, "within the extent"),
        (0.8, None, "start and stop must leave at least 4 points"),
        (np.nan, None, "start must be a finite number"),
        (0, "1", "stop must be a number with a unit"),
    ],
)
def test_cropping_rejects_positions_outside_the_profile(start, stop, match):
    with pytest.raises(ValueError, match=match):
        cropped(rough_profile(10), start, stop)


# ---- Flipping -------------------------------------------------------------------------------------------------------


def test_flipped_scan_touches_the_original_scan_at_the_highest_peak():
    peak_profile = Profile(-np.square(np.linspace(-1, 1, 101)), spacing=0.02)
    contact_table = contacts(flipped(peak_profile), peak_profile, 1e-4, detection="gap-minimum")
    assert contact_table.index.tolist() in ([49], [50])
    assert flipped(flipped(peak_profile)).heights.tolist() == peak_profile.heights.tolist()


# ---- A common grid --------------------------------------------------------------------------------------------------


def test_common_grid_preserves_the_finer_profile_and_interpolates_the_coarser_profile():
    fine_profile, coarse_profile = rough_profile(100, 0.1), rough_profile(20, 0.25)
    for a, b, fine_index in ((fine_profile, coarse_profile, 0), (coarse_profile, fine_profile, 1)):
        pair = on_common_grid(a, b)
        assert pair[0].spacing == pair[1].spacing == 0.1
        assert len(pair[0]) == len(pair[1]) == 48  # the shorter length is 4.75 µm
        assert np.array_equal(pair[fine_index].heights, fine_profile.heights[:48])
        shared_heights = pair[1 - fine_index].heights[
            ::5
        ]  # Every fifth point of the fine grid is also a point of the coarse grid.
        assert np.abs(shared_heights - coarse_profile.heights[::2]).max() < ROUND_OFF


def test_common_grid_leaves_heights_of_profiles_with_equal_spacings_unchanged():
    a, b = rough_profile(30), rough_profile(20)
    profiles_on_common_grid = on_common_grid(a, b)
    assert np.array_equal(profiles_on_common_grid[0].heights, a.heights[:20])
    assert profiles_on_common_grid[1] is b


def test_error_of_spline_interpolation_decreases_with_the_fourth_power_of_the_spacing():
    errors = []
    for points in (40, 80):
        coarse_profile = Profile(np.sin(np.arange(points + 1) * 20 / points), spacing=20 / points)
        fine_profile = Profile(np.zeros(2001), spacing=0.01)
        splined_profile = on_common_grid(fine_profile, coarse_profile)[1]
        inner_range = slice(500, 1500)
        errors.append(np.abs(splined_profile.heights - np.sin(splined_profile.x))[inner_range].max())
    assert np.log2(errors[0] / errors[1]) > MIN_SPLINE_CONVERGENCE_ORDER


def test_common_grid_has_at_least_four_points_for_any_two_profiles():
    assert [len(item) for item in on_common_grid(rough_profile(4, 3.0), rough_profile(4, 0.1))] == [4, 4]


# ---- History --------------------------------------------------------------------------------------------------------


def test_history_of_a_profile_lists_every_preparation_step():
    profile = Profile(rough_profile(100).heights, spacing=0.1, history=("made up",))
    completed = cropped(levelled(profile, "quadratic"), 1.0, 9.0).with_amplitude(0.5, "Rq")
    resampled_profile = on_common_grid(completed, rough_profile(200, 0.05))[0]
    assert resampled_profile.history == (
        "made up",
        "levelled by a parabola",
        "cropped to 1 to 9 µm",
        "scaled to Rq 0.5 µm",
        "splined from a spacing of 0.1 to 0.05 µm, 159 points",
    )
    assert pickle.loads(pickle.dumps(resampled_profile)).history == resampled_profile.history


def test_rows_and_columns_inherit_the_history_of_their_surface():
    surface = levelled(Surface(np.arange(20.0).reshape(4, 5), spacing=(0.5, 0.25), history=("made up",)), "plane")
    assert pickle.loads(pickle.dumps(surface)).history == ("made up", "levelled by a plane")
    assert surface.row(2).history == ("made up", "levelled by a plane", "row 2")
    assert surface.column(3).history == ("made up", "levelled by a plane", "column 3")


@pytest.mark.parametrize("history", ["levelled", ["levelled"], (1,), None])
def test_history_must_be_a_tuple_of_strings(history):
    with pytest.raises(ValueError, match="history must be a tuple of strings"):
        Profile(np.zeros(4), spacing=1.0, history=history)
