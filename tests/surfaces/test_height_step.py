"""Tests of the rounding step of heights: found after levelling, and absent without rounding or in flat scans."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from stiction import Profile, Surface, levelled
from stiction.surfaces.height_step import find_height_step
from support.machined_surfaces import MACHINED_SURFACES, filtered_noise

# Levelling, or storing heights as single-precision numbers, changes second differences only by round-off.
STEP_TOLERANCE = 1e-3


def round_to_levels(heights, num_levels):
    """Return heights that are rounded to a number of levels within their range, and the step between levels."""
    step = np.ptp(heights) / (num_levels - 1)
    return step * np.round((heights - heights.min()) / step), step


@pytest.mark.parametrize("num_levels", [8, 32, 256])
@pytest.mark.parametrize("shape", [(2048,), (96, 96)])
def test_rounding_step_of_heights_is_found_after_levelling(num_levels, shape):
    body_class, forms = (Profile, ("line", "quadratic")) if len(shape) == 1 else (Surface, ("plane", "quadratic"))
    for seed, shortest in ((1, None), (2, 16)):
        smooth_heights = 0.1 * filtered_noise(np.random.default_rng(seed), shape, 0.8, shortest_wavelength=shortest)
        heights, step = round_to_levels(smooth_heights, num_levels)
        levelled_heights = [levelled(body_class(heights, spacing=0.5), form).heights for form in forms]
        missing_points = np.where(np.arange(heights.size).reshape(shape) % 50 == 7, np.nan, heights)
        single_precision = [
            profile_heights.astype(np.float32).astype(float) for profile_heights in (heights, *levelled_heights)
        ]
        for scan_heights in (heights, 25.0 + heights, *levelled_heights, *single_precision, missing_points):
            assert find_height_step(scan_heights) == pytest.approx(step, rel=STEP_TOLERANCE)


@pytest.mark.parametrize("machining", MACHINED_SURFACES)
@pytest.mark.parametrize("dimensions", [1, 2])
def test_unrounded_heights_have_no_rounding_step(machining, dimensions):
    for seed in range(3):
        heights = MACHINED_SURFACES[machining](np.random.default_rng(seed), dimensions)
        assert find_height_step(heights) < 1e-5 * np.ptp(heights)


@pytest.mark.parametrize("shape", [(2048,), (64, 64)])
def test_flat_scan_with_equal_spikes_has_no_rounding_step(shape):
    heights = np.zeros(shape)
    assert find_height_step(heights) == find_height_step(np.full(shape, np.nan)) == 0
    heights[..., 5::17] = heights[..., 6::17] = 1.0
    assert find_height_step(heights) == 0
    assert find_height_step(np.array([1.0, 2.0])) == 0


def test_unrounded_map_with_clipped_heights_has_no_rounding_step():
    heights = gaussian_filter(np.random.default_rng(1).normal(size=(1024, 1024)), 4)
    clipped_heights = np.maximum(heights, np.quantile(heights, 0.95))
    assert find_height_step(clipped_heights) == 0
    rounded_heights, step = round_to_levels(clipped_heights, 64)
    assert find_height_step(rounded_heights) == pytest.approx(step, rel=STEP_TOLERANCE)
