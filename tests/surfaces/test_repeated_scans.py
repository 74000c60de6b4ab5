import numpy as np
import pytest
from scipy.ndimage import grey_dilation
from stiction import (
    Profile,
    Surface,
    compare_repeated_scans,
    instrument_limit,
    self_affine,
    self_affine_surface,
    tip_reconstructed,
)
from stiction.surfaces.scale import mean_square_height_spectrum
from stiction.views.scans import describe_mean_scan_noise

# Relative error of the noise per octave at wavelengths above four points.
# The noise scatters by 3 % in the shortest octave and by 1 % on maps.
NOISE_TOLERANCE = 0.1
ROUND_OFF = 1e-15


def coloured_noise(colour, shape, spacing, rng):
    q = np.sqrt(sum(item**2 for item in np.meshgrid(*[np.fft.fftfreq(n, spacing) for n in shape], indexing="ij")))
    factor = {
        "white": np.ones(q.shape), "band": (q > 0.13 / spacing) & (q < 0.3 / spacing),
        "pink": 1 / np.sqrt(np.maximum(q, 1e-3 / spacing)),
    }[colour]  # fmt: skip
    noise = np.fft.ifftn(np.fft.fftn(rng.normal(size=shape)) * factor).real
    return noise / noise.std()


def fine_surface(dimensions, points, spacing):
    """Return a surface on half the grid spacing, so that scans of it can be shifted by half a point."""
    options = {"hurst_exponent": 0.7, "rms": 0.003, "spacing": spacing / 2, "shortest_wavelength": 8 * spacing}
    if dimensions == 1:
        return self_affine(7, points=2 * points + 100, **options).heights
    return self_affine_surface(7, shape=(2 * points + 100,) * 2, **options).heights


@pytest.mark.parametrize("dimensions", [1, 2])
@pytest.mark.parametrize("colour", ["white", "band", "pink"])
def test_comparison_of_repeated_scans_recovers_noise_of_any_spectrum(dimensions, colour):
    points, spacing, rms, rng = (12000 if dimensions == 1 else 320), 0.02, 1.5e-4, np.random.default_rng(3)
    shape = (points,) * dimensions
    true_heights, body_class = fine_surface(dimensions, points, spacing), Profile if dimensions == 1 else Surface
    shift_in_points = (41, 13)[:dimensions]
    noise = [rms * coloured_noise(colour, shape, spacing, rng) for _ in range(2)]
    starts = [(0,) * dimensions, shift_in_points]
    scans = [
        true_heights[tuple(slice(first_index, first_index + 2 * points, 2) for first_index in start)] + scan_noise
        for start, scan_noise in zip(starts, noise, strict=True)
    ]
    scans[1] = scans[1] + 0.3 + 1e-5 * np.indices(shape).sum(axis=0)
    result = compare_repeated_scans(*(body_class(scan, spacing=spacing) for scan in scans))
    # Largest error of the shift in points. Pink noise has ten times the slope of the surface.
    max_shift_error = 1.0 if colour == "pink" else 0.3
    assert np.abs(np.array(result.shift) / spacing - np.array(shift_in_points) / 2).max() < max_shift_error
    assert result.correlation > 0.99
    true_noise = np.mean(
        [mean_square_height_spectrum(body_class(scan_noise, spacing=spacing))[1] for scan_noise in noise], axis=0
    )
    q = mean_square_height_spectrum(body_class(noise[0], spacing=spacing))[0]
    octave_index = np.maximum(np.floor(np.log2(np.pi / (q * spacing)) + 1e-9), 0).astype(int)
    true_noise = np.sqrt(np.bincount(octave_index, true_noise))
    clean_body = body_class(true_heights[tuple(slice(0, 2 * points, 2) for _ in shape)], spacing=spacing)
    true_common = np.sqrt(np.bincount(octave_index, mean_square_height_spectrum(clean_body)[1]))
    has_noise = (true_noise > 0.01 * rms) & (np.bincount(octave_index) > 60)
    has_noise[0] = False  # Noise is accurate only at wavelengths above four points.
    assert has_noise.sum() >= (1 if colour == "band" else 3)
    np.testing.assert_allclose(result.noise[has_noise], true_noise[has_noise], rtol=NOISE_TOLERANCE)
    has_common = (true_common > 3 * true_noise) & (np.bincount(octave_index) > 15)
    assert has_common.any()
    np.testing.assert_allclose(result.common[has_common], true_common[has_common], rtol=NOISE_TOLERANCE)
    # After filtering, noise contributes a tenth of the mean square slope on average.
    q, scan_spectrum = mean_square_height_spectrum(result.scan)
    filtered_slope_weights = q**2 * np.exp(-2 * np.log(2) * (q * result.limit / (2 * np.pi)) ** 2)
    noise_slope = mean_square_height_spectrum(body_class((noise[0] - noise[1]) / 2, spacing=spacing))
    noise_slope = noise_slope[1] @ (
        noise_slope[0] ** 2 * np.exp(-2 * np.log(2) * (noise_slope[0] * result.limit / (2 * np.pi)) ** 2)
    )
    assert noise_slope / (scan_spectrum @ filtered_slope_weights) == pytest.approx(0.1, rel=0.15)


def test_comparison_of_repeated_scans_reports_noise_and_recommends_a_cutoff_of_two_spacings():
    options = {"longest_wavelength": 60.0, "shortest_wavelength": 2.0, "hurst_exponent": 0.8, "rms": 0.25}
    clean_profile = self_affine(97, points=8000, spacing=0.25, **options)
    rng = np.random.default_rng(1)
    scans = [Profile(clean_profile.heights + rng.normal(0, 0.005, 8000), spacing=0.25) for _ in range(2)]
    result = compare_repeated_scans(*scans)
    assert result.slope_fraction == pytest.approx(instrument_limit(result.scan).slope_fraction, rel=0.1)
    assert result.slope_fraction > 0.15
    assert "17 % of the mean square slope" in describe_mean_scan_noise(result)
    assert "--cutoff '500 nm'" in describe_mean_scan_noise(result)
    less_noisy = compare_repeated_scans(
        *(Profile((3 * clean_profile.heights + scan.heights) / 4, spacing=0.25) for scan in scans)
    )
    assert less_noisy.slope_fraction < 0.1
    assert less_noisy.limit == 0.5
    assert "All wavelengths of the mean scan can be used" in describe_mean_scan_noise(less_noisy)


def test_comparison_of_repeated_scans_rejects_unrelated_scans():
    first_profile, other_profile = (
        self_affine(seed, hurst_exponent=0.8, rms=0.1, points=2000, spacing=0.1) for seed in (1, 2)
    )
    result = compare_repeated_scans(first_profile, Profile(first_profile.heights[100:], spacing=0.1))
    assert (result.shift, result.limit) == ((10.0,), 0.2)
    assert max(result.noise_rms, result.noise.max()) < ROUND_OFF
    surface = Surface(np.eye(40), spacing=0.1)
    profile_with_gap = Profile(first_profile.heights, spacing=0.1, missing=np.arange(2000) == 7)
    for first_scan, second_scan, message in (
        (first_profile, first_profile, "got identical scans$"),
        (first_profile, other_profile, "of the same area"),
        (first_profile, surface, "two profiles or two surfaces"),
        (first_profile, Profile(first_profile.heights, spacing=0.2), "equal spacings"),
        (first_profile, profile_with_gap, "requires complete scans"),
        (first_profile, 3, "second must be a Profile or a Surface"),
        (Profile(np.zeros(9), spacing=0.1), first_profile, "not be flat"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=message):
            compare_repeated_scans(first_scan, second_scan)


@pytest.mark.parametrize("dimensions", [1, 2])
@pytest.mark.parametrize("has_half_point_shift", [True, False])
def test_comparison_of_repeated_scans_excludes_outliers_from_noise_but_not_from_mean(dimensions, has_half_point_shift):
    points, spacing, rms, rng = (2000 if dimensions == 1 else 120), 0.02, 1.5e-4, np.random.default_rng(3)
    heights, body_class = fine_surface(dimensions, points, spacing), Profile if dimensions == 1 else Surface
    starts = (0, 5 if has_half_point_shift else 4)
    scans = [
        heights[(slice(start, start + 2 * points, 2),) * dimensions] + rms * rng.normal(size=(points,) * dimensions)
        for start in starts
    ]
    masks = [np.zeros(scan.shape, bool) for scan in scans]
    for mask, percent in ((masks[0], 40), (masks[0], 60), (masks[1], 55)):
        mask[(percent * points // 100,) * dimensions] = True
    spiky_scans = [scan + 20 * scan.std() * mask for scan, mask in zip(scans, masks, strict=True)]
    clean_comparison, masked_comparison, unmasked_comparison = (
        compare_repeated_scans(*(body_class(scan, spacing=spacing) for scan in compared_scans), outliers=outliers)
        for compared_scans, outliers in ((scans, None), (spiky_scans, masks), (spiky_scans, None))
    )
    assert unmasked_comparison.noise_rms > 3 * clean_comparison.noise_rms
    assert masked_comparison.noise_rms == pytest.approx(clean_comparison.noise_rms, rel=NOISE_TOLERANCE)
    assert masked_comparison.limit == pytest.approx(clean_comparison.limit, rel=NOISE_TOLERANCE)
    np.testing.assert_allclose(masked_comparison.shift, clean_comparison.shift, atol=0.05 * spacing)
    np.testing.assert_allclose(masked_comparison.noise[:3], clean_comparison.noise[:3], rtol=NOISE_TOLERANCE)
    assert np.ptp(masked_comparison.scan.heights) > 8 * scans[0].std()
    no_outliers = [np.zeros(scan.shape, bool) for scan in scans]
    comparison_without_outliers = compare_repeated_scans(
        *(body_class(scan, spacing=spacing) for scan in scans), outliers=no_outliers
    )
    np.testing.assert_array_equal(comparison_without_outliers.scan.heights, clean_comparison.scan.heights)
    assert (comparison_without_outliers.shift, comparison_without_outliers.limit) == (
        clean_comparison.shift,
        clean_comparison.limit,
    )


def test_comparison_of_repeated_scans_rejects_invalid_outlier_masks():
    heights = self_affine(1, hurst_exponent=0.8, rms=0.1, points=200, spacing=0.1).heights
    profiles = [Profile(heights, spacing=0.1), Profile(1.1 * heights[:190], spacing=0.1)]
    masks = [np.zeros(200, bool), np.zeros(190, bool)]
    for outliers in (masks[:1], masks[::-1], [masks[0], np.zeros(190)]):
        with pytest.raises(ValueError, match="outliers must be two boolean arrays"):
            compare_repeated_scans(*profiles, outliers=outliers)
    with pytest.raises(ValueError, match=r"outliers must be two boolean arrays .*, got 1$"):
        compare_repeated_scans(*profiles, outliers=1)
    flat_heights = np.where(np.arange(200) == 7, 1.0, 0.0)
    with pytest.raises(ValueError, match="second must not be flat except for outliers"):
        compare_repeated_scans(profiles[0], Profile(flat_heights, spacing=0.1), outliers=[masks[0], flat_heights > 0])
    with pytest.raises(ValueError, match="first must have points that are not outliers"):
        compare_repeated_scans(*profiles, outliers=[~masks[0], masks[1]])
    scan_with_spike = Profile(heights + 5 * (np.arange(200) == 100), spacing=0.1)
    with pytest.raises(ValueError, match=r"got identical scans \(except at outliers\)"):
        compare_repeated_scans(profiles[0], scan_with_spike, outliers=[masks[0], np.arange(200) == 100])


def dilated_surface(body, radius):
    """Return the dilation of a surface by a ball, computed with SciPy."""
    spacings = np.atleast_1d(body.spacing)
    radius_in_points = [int(radius / step) for step in spacings]
    offsets = np.meshgrid(
        *[np.arange(-n, n + 1) * step for n, step in zip(radius_in_points, spacings, strict=True)], indexing="ij"
    )
    squared_distance = sum(item**2 for item in offsets)
    ball = radius - np.sqrt(np.maximum(radius**2 - squared_distance, 0))
    return grey_dilation(
        body.heights, footprint=squared_distance <= radius**2, structure=-ball, mode="constant", cval=-1e9
    )


@pytest.mark.parametrize(
    "body",
    [
        self_affine(1, hurst_exponent=0.7, rms=0.05, points=3000, spacing=0.01),
        self_affine_surface(1, hurst_exponent=0.7, rms=0.01, shape=(120, 100), spacing=(0.01, 0.012)),
    ],
)
def test_tip_reconstruction_inverts_dilation_at_points_marked_as_certain(body):
    radius = 0.15
    scan = type(body)(dilated_surface(body, radius), spacing=body.spacing)
    result, is_certain = tip_reconstructed(scan, radius)
    errors = result.heights - body.heights
    assert errors.min() > -1e-12
    assert np.abs(errors[is_certain]).max() < 1e-12
    assert 0.1 < is_certain.mean() < 0.9
    # The same tip would record the same scan from the reconstructed surface.
    assert np.abs(dilated_surface(result, radius) - scan.heights).max() < 1e-12
    assert errors.mean() < 0.5 * (scan.heights - body.heights).mean()
    with pytest.raises(ValueError, match="radius must be a finite number above 0"):
        tip_reconstructed(scan, 0.0)
    smooth_body = type(body)(1e-4 * np.cos(np.indices(body.heights.shape).sum(axis=0) / 20), spacing=body.spacing)
    smooth_reconstruction = tip_reconstructed(
        type(body)(dilated_surface(smooth_body, radius), spacing=body.spacing), radius
    )
    inner_slices = tuple(slice(20, -20) for _ in smooth_reconstruction[1].shape)
    assert smooth_reconstruction[1][
        inner_slices
    ].all()  # A ball reaches every point of features whose radius is larger than its own.


@pytest.mark.parametrize("factor", [0.0, 1e-71, 1e-160, 1e-300])
def test_comparison_of_repeated_scans_rejects_heights_whose_squares_underflow(factor):
    heights = np.random.default_rng(3).normal(size=64)
    with pytest.raises(ValueError, match="second must not be flat"):
        compare_repeated_scans(Profile(heights, spacing=0.1), Profile(factor * heights, spacing=0.1))


def test_comparison_of_repeated_scans_rejects_scans_whose_slopes_are_uncorrelated():
    first_heights, second_heights = np.zeros((2, 16))
    first_heights[3], second_heights[11] = 1.0, 1.0
    with pytest.raises(ValueError, match=r"correlation|overlap"):
        compare_repeated_scans(Profile(first_heights, spacing=0.1), Profile(second_heights, spacing=0.1))
