import pickle

import numpy as np
import pytest
from stiction import Profile, Surface

HEIGHTS = np.array([0.0, 2.0, 1.0, -3.0, 0.5])
ROUND_OFF = 1e-14


def test_grid_of_a_profile_starts_at_zero_and_extends_over_all_points():
    profile = Profile(HEIGHTS, spacing=0.25)
    assert profile.x.tolist() == [0, 0.25, 0.5, 0.75, 1.0]
    assert profile.extent == 1.25
    assert len(profile) == 5


@pytest.mark.parametrize("body", [Profile(HEIGHTS, spacing=1.0), Surface(np.zeros((4, 4)), spacing=1.0)])
def test_heights_of_a_profile_are_a_read_only_copy_of_the_given_heights(body):
    """Check the copy of heights also for a read-only view and for a pickled profile."""
    source_heights = np.array(body.heights)
    view = source_heights.view()
    view.flags.writeable = False
    for body_from_array in (type(body)(source_heights, spacing=1.0), type(body)(view, spacing=1.0)):
        source_heights += 1
        assert not np.array_equal(body_from_array.heights, source_heights)
        unpickled = pickle.loads(pickle.dumps(body_from_array))
        assert np.array_equal(unpickled.heights, body_from_array.heights)
        assert unpickled.spacing == body_from_array.spacing
        for body_copy in (body_from_array, unpickled):
            with pytest.raises(ValueError, match="read-only"):
                body_copy.heights[0] = 1


@pytest.mark.parametrize(
    ("measure", "compute_amplitude"),
    [("height", np.ptp), ("Ra", lambda y: np.abs(y - y.mean()).mean()), ("Rq", np.std)],
)
def test_profile_scaled_to_a_given_amplitude_has_this_amplitude(measure, compute_amplitude):
    scaled_profile = Profile(HEIGHTS + 7, spacing=1.0).with_amplitude(0.3, measure)
    assert compute_amplitude(scaled_profile.heights) == pytest.approx(0.3, abs=ROUND_OFF)
    assert scaled_profile.heights.mean() == pytest.approx(0, abs=ROUND_OFF)
    assert np.corrcoef(scaled_profile.heights, HEIGHTS)[0, 1] == pytest.approx(1, abs=ROUND_OFF)
    assert scaled_profile.spacing == 1.0


@pytest.mark.parametrize(
    ("heights", "message"),
    [
        ([0, 1, np.nan, 2], r"got nan at heights\[2\]"),
        ([0, 1, 2, -np.inf], r"got -inf at heights\[3\]"),
        ([0, 1, 2], "at least 4 points, got 3"),
        ([], "at least 4 points, got 0"),
        ([[0, 1], [2, 3]], "1 dimension"),
        (1.0, "1 dimension"),
        (["a", "b", "c", "d"], "real numbers"),
        ([1j, 2j, 3j, 4j], "real numbers"),
        (None, "real numbers"),
        ([[1, 2], [3]], "real numbers"),
        (np.ma.array([0.0, 1, 99, 1], mask=[0, 0, 1, 0]), "masked"),
        (np.array(["2020-01-01"] * 4, "M8[D]"), "real numbers"),
    ],
)
def test_profile_rejects_invalid_heights(heights, message):
    with pytest.raises(ValueError, match=message):
        Profile(heights, spacing=1.0)


@pytest.mark.parametrize("spacing", [0, -1.0, np.nan, np.inf, None, True, 10**400, 2 + 1j])
def test_profile_rejects_invalid_spacings(spacing):
    with pytest.raises(ValueError, match="spacing must be a finite number above 0 µm, got"):
        Profile(HEIGHTS, spacing=spacing)


def test_scaling_a_profile_rejects_invalid_amplitudes():
    profile = Profile(HEIGHTS, spacing=1.0)
    with pytest.raises(ValueError, match="amplitude must be a finite number above 0"):
        profile.with_amplitude(0)
    with pytest.raises(ValueError, match=r"measure must be one of 'height', 'Ra', 'Rq', got 'rms'"):
        profile.with_amplitude(1, "rms")
    with pytest.raises(ValueError, match="flat"):
        Profile(np.ones(9), spacing=1.0).with_amplitude(1)


def test_profile_accepts_heights_whose_sum_overflows():
    """Check that NumPy does not warn, and that non-finite heights are still detected."""
    heights = np.array([1e308, 1e308, -1e308, -1e308, 0.0])
    assert Profile(heights, spacing=1.0).heights.tolist() == heights.tolist()
    with pytest.raises(ValueError, match=r"got inf at heights\[1\]"):
        Profile([1e308, np.inf, -np.inf, 0.0, 0.0], spacing=1.0)
    if np.finfo(np.longdouble).max > 1e308:
        with pytest.raises(ValueError, match=r"got inf at heights\[0\]"):
            Profile(np.full(5, np.longdouble("1e4000")), spacing=1.0)
