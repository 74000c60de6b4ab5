"""Tests of the previews of scans in the app."""

import io
import json
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.image import imread, imsave
from stiction import self_affine_surface
from stiction._drawing import HEIGHT_COLOUR_MAP
from stiction.app.preview import MAX_PREVIEW_SIDE_POINTS, compare_scans, render_height_map_png

MAX_GREY_LEVEL_DIFFERENCE = 1
"""Maximum difference of grey levels: Matplotlib rounds some of its 256 levels down to the next level."""


def read_grey_levels(png):
    """Return the grey levels of an image as an array of rows and columns."""
    pixels = np.round(imread(io.BytesIO(png)) * 255)
    return pixels if pixels.ndim == 2 else pixels[..., 0]


@pytest.mark.parametrize(
    "heights",
    [
        np.random.default_rng(1).standard_normal((MAX_PREVIEW_SIDE_POINTS, MAX_PREVIEW_SIDE_POINTS)),
        np.random.default_rng(2).standard_normal((MAX_PREVIEW_SIDE_POINTS // 2, MAX_PREVIEW_SIDE_POINTS)),
        np.zeros((MAX_PREVIEW_SIDE_POINTS, 20)),
    ],
    ids=["square", "wide", "flat"],
)
def test_preview_image_has_the_grey_levels_that_matplotlib_draws(heights):
    expected_file = io.BytesIO()
    imsave(expected_file, heights, cmap=HEIGHT_COLOUR_MAP, origin="lower")
    levels = read_grey_levels(render_height_map_png(heights, heights.shape))
    np.testing.assert_allclose(
        levels, read_grey_levels(expected_file.getvalue()), rtol=0, atol=MAX_GREY_LEVEL_DIFFERENCE
    )


def test_preview_image_of_a_large_map_has_a_limited_size_and_square_pixels():
    levels = read_grey_levels(render_height_map_png(np.ones((1000, 500)), (10.0, 20.0)))
    assert levels.shape == (MAX_PREVIEW_SIDE_POINTS // 2, MAX_PREVIEW_SIDE_POINTS)


def test_preview_command_accepts_spacings_along_both_axes(tmp_path):
    np.save(tmp_path / "map.npy", np.random.default_rng(1).standard_normal((16, 16)))
    options = json.dumps({"unit": "um", "spacing": ["1 um", "2 um"]})
    command = [sys.executable, "-m", "stiction.app.preview", str(tmp_path / "map.npy"), options]
    preview = json.loads(subprocess.check_output(command))
    assert preview["words"].startswith("32 µm × 16 µm")


def test_comparison_of_two_scans_reads_each_scan_with_its_own_options(tmp_path):
    face = self_affine_surface(4, hurst_exponent=0.8, rms=20.0, shape=(48, 48), spacing=50.0)
    np.save(tmp_path / "mate.npy", -face.heights[::-1])
    np.save(tmp_path / "face.npy", face.heights / 1e3)
    np.save(tmp_path / "other.npy", face.heights[::-1, ::-1])
    mate, lower, unrelated = (str(tmp_path / f"{name}.npy") for name in ("mate", "face", "other"))
    micrometres, millimetres = ({"unit": unit, "spacing": "50 um"} for unit in ("um", "mm"))
    assert compare_scans((mate, lower), (micrometres, millimetres)) == {"fits": True, "path": "240 µm"}
    assert not compare_scans((mate, unrelated), (micrometres, micrometres))["fits"]
    assert not compare_scans((mate, lower), (micrometres, {"unit": "mm"}))["fits"]  # the lower scan has no spacing
    command = [sys.executable, "-m", "stiction.app.preview"]
    command += [mate, json.dumps(micrometres), lower, json.dumps(millimetres)]
    assert json.loads(subprocess.check_output(command))["fits"] is True
