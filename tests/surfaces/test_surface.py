import math
import warnings

import numpy as np
import pytest
from stiction import Surface, surface_parameters


@pytest.mark.parametrize("spacing", [1e-300, 1e200, (1.0, 1e-31)])
def test_surface_rejects_a_spacing_at_which_slopes_would_overflow(spacing):
    with pytest.raises(ValueError, match=r"spacing must be from 1e-30 to 1e\+30 µm, got"):
        Surface(np.eye(16), spacing=spacing)


@pytest.mark.parametrize("spacing", [1e-30, 1e30])
def test_roughness_parameters_are_finite_at_the_limits_of_the_spacing(spacing):
    heights = np.random.default_rng(1).normal(size=(16, 16))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert all(map(math.isfinite, surface_parameters(Surface(heights, spacing=spacing)).values.values()))


def test_rows_of_a_surface_are_along_x_and_columns_along_y():
    surface = Surface(np.arange(12.0).reshape(3, 4), spacing=(0.5, 0.25))
    assert surface.x.tolist() == [0, 0.25, 0.5, 0.75]
    assert surface.y.tolist() == [0, 0.5, 1]
    assert surface.extent == (1.5, 1.0)
    profile = surface.row(2)
    assert profile.heights.tolist() == [8, 9, 10, 11]
    assert profile.spacing == 0.25
    assert Surface(np.arange(12.0).reshape(4, 3), spacing=(0.5, 0.25)).column(1).heights.tolist() == [1, 4, 7, 10]
    assert Surface(np.arange(12.0).reshape(4, 3), spacing=(0.5, 0.25)).column(1).spacing == 0.5
    assert Surface(np.zeros((2, 2)), spacing=0.1).spacing == (0.1, 0.1)


@pytest.mark.parametrize(
    ("heights", "spacing", "match"),
    [
        ([1.0, 2.0], 1.0, "heights"),
        ([[1.0, 2.0]], 1.0, "rows"),
        ([[1.0, np.nan], [0.0, 1.0]], 1.0, "finite"),
        (np.zeros((3, 3)), 0.0, "spacing"),
        (np.zeros((3, 3)), (1.0, -1.0), "spacing"),
        (np.zeros((3, 3)), (1.0,), "spacing"),
        (np.zeros((3, 3)), np.array("1"), "spacing"),
    ],
)
def test_surface_rejects_invalid_heights(heights, spacing, match):
    with pytest.raises(ValueError, match=match):
        Surface(heights, spacing=spacing)


def test_methods_that_return_a_row_or_column_reject_an_invalid_index():
    with pytest.raises(ValueError, match="index"):
        Surface(np.zeros((3, 5)), spacing=1.0).row(3)
    with pytest.raises(ValueError, match="index"):
        Surface(np.zeros((5, 3)), spacing=1.0).column(3)
