import numpy as np
import pytest
from stiction import (
    Profile,
    Surface,
    cropped,
    cut_off,
    flipped,
    levelled,
    on_common_grid,
    pair,
    read_measurement,
    read_profile,
    read_surface,
    rotated,
    self_affine,
    self_affine_surface,
    write_profile,
    write_surface,
)
from stiction.study.pair_study import MeasuredPair
from stiction.surfaces.missing_data import find_outliers, with_interpolated_points
from support.machined_surfaces import MACHINED_SURFACES, filtered_noise

HOLE_SLICES = np.s_[20:44, 30:50]
READ_OPTIONS = {"unit": "um", "spacing": "0.1 um"}
PAIR_OPTIONS = {
    "load": "5 MPa",
    "mu0": 0.2,
    "tau0": "50 MPa",
    "effective_modulus": "100 GPa",
    "hardness": "2 GPa",
    "onset": 0,
}


@pytest.fixture(scope="module")
def complete_surface():
    return self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1)


@pytest.fixture
def scan_path(complete_surface, tmp_path):
    heights = complete_surface.heights.copy()
    heights[HOLE_SLICES] = np.nan
    np.save(tmp_path / "hole.npy", heights)
    return tmp_path / "hole.npy"


def test_preparation_steps_and_file_formats_preserve_the_mask_of_missing_points(complete_surface, scan_path, tmp_path):
    scan = read_surface(scan_path, missing="mask", **READ_OPTIONS)
    is_missing = np.isnan(np.load(scan_path))
    assert np.array_equal(scan.missing, is_missing)
    assert np.array_equal(scan.heights[~is_missing], complete_surface.heights[~is_missing])
    assert scan.history[-1] == (
        "480 missing points masked, 12 % of all points; "
        "the largest gap has 480 points, at x 3 µm to 5 µm, y 2 µm to 4.4 µm"
    )
    marked_surface = Surface(np.where(is_missing, 1.0, np.arange(64.0) / 100), spacing=0.1)
    for transform in (flipped, lambda body: rotated(body, 270), lambda body: cropped(body, (1.0, 2.0), (5.0, 6.0))):
        assert np.array_equal(transform(scan).missing, np.abs(transform(marked_surface).heights) == 1)
    for processed_scan in (
        levelled(scan, "quadratic"),
        cut_off(scan, 0.5),
        scan.with_amplitude(1.0),
        Surface.from_(scan),
    ):
        assert np.array_equal(processed_scan.missing, is_missing)
    assert np.array_equal(scan.row(25).missing, is_missing[25])
    assert np.array_equal(scan.column(31).missing, is_missing[:, 31])
    assert scan.row(0).missing is None
    tilted_scan = Surface(scan.heights + np.arange(64) * 0.01 + is_missing * 7.0, spacing=0.1, missing=is_missing)
    height_differences = np.where(
        is_missing, 0, levelled(tilted_scan, "plane").heights - levelled(scan, "plane").heights
    )
    assert np.abs(height_differences).max() < 1e-12  # missing points have no weight in the fitted plane
    fine_surface = Surface(np.zeros((130, 130)), spacing=0.049)
    resampled_scan = on_common_grid(scan, fine_surface)[0].missing
    y, x = (0.049 * np.arange(points) for points in resampled_scan.shape)
    assert np.array_equal(resampled_scan, np.outer((y > 1.9) & (y < 4.4), (x > 2.9) & (x < 5.0)))
    rotated_missing = rotated(scan, 30.0).missing
    assert rotated_missing.sum() == pytest.approx(is_missing.sum(), rel=0.25)
    for body, write_body, read_body in (
        (scan, write_surface, read_surface),
        (scan.row(25), write_profile, read_profile),
    ):
        for suffix in (".npy", ".csv"):
            file = (tmp_path / type(body).__name__).with_suffix(suffix)
            write_body(body, file)
            restored_body = read_body(file, missing="mask")
            assert np.array_equal(restored_body.missing, body.missing)
            assert np.array_equal(restored_body.heights[~restored_body.missing], body.heights[~body.missing])


def test_missing_points_at_an_edge_are_masked_in_maps_and_cropped_in_profiles(tmp_path):
    heights = np.where(np.arange(36).reshape(6, 6) < 8, np.nan, 1.0)
    np.save(tmp_path / "corner.npy", heights)
    with pytest.raises(ValueError, match="--missing mask"):
        read_surface(tmp_path / "corner.npy", missing="interpolate", **READ_OPTIONS)
    scan = read_surface(tmp_path / "corner.npy", missing="mask", **READ_OPTIONS)
    assert np.array_equal(scan.missing, np.isnan(heights))
    assert (scan.heights == 1).all()
    np.save(tmp_path / "line.npy", np.array([np.nan, 1, 2, np.nan, 4, 5, np.nan]))
    line = read_profile(tmp_path / "line.npy", missing="mask", **READ_OPTIONS)
    assert line.heights.tolist() == [1, 2, 3, 4, 5]
    assert line.missing.tolist() == [False, False, True, False, False]


def test_cropping_ignores_missing_points_outside_the_cropped_range(complete_surface, scan_path):
    with pytest.raises(ValueError, match="480 of 4096 heights"):
        read_surface(scan_path, **READ_OPTIONS)
    piece = read_surface(scan_path, crop="0 um, 2.5 um, 1 um, 6.4 um", **READ_OPTIONS)
    assert np.array_equal(piece.heights, complete_surface.heights[10:, :25])
    assert piece.history[-1] == "cropped to 0 to 2.5 µm along x and 1 to 6.4 µm along y"
    for crop, message in (
        ("1 um,9 um,0 um,1 um", "within the extent"),
        ("0 um,1 um", "crop must have 4 positions for this file, got 2"),
        ("0 um,1 um,2 um", "x0,x1"),
        ("0,1", "unit of length"),
    ):
        with pytest.raises(ValueError, match=message):
            read_measurement(scan_path, crop=crop, **READ_OPTIONS)


@pytest.mark.parametrize("hurst", [0.2, 0.8])
def test_outlier_detection_finds_spikes_but_not_steps_or_scratches(hurst, tmp_path):
    options = {"hurst_exponent": hurst, "rms": 0.02, "spacing": 0.1}
    for body in (self_affine(1, points=4000, **options), self_affine_surface(1, shape=(128, 128), **options)):
        assert not find_outliers(body.heights).any()
        heights, mean_difference = body.heights.copy(), float(np.abs(np.diff(body.heights)).mean())
        flat_heights = heights.reshape(-1)
        spike_indices = np.arange(210, flat_heights.size - 210, 613)
        # The point at the edge has too few neighbours.
        spike_indices = spike_indices[(spike_indices % 128 > 0) & (spike_indices % 128 < 127)]
        flat_heights[spike_indices] += 20 * mean_difference * (-1.0) ** np.arange(spike_indices.size)
        # a feature with more points than a group of outliers can have
        flat_heights[2000:2006] += 20 * mean_difference
        result = find_outliers(heights)
        assert np.array_equal(np.flatnonzero(result), spike_indices)
        np.save(tmp_path / f"{heights.ndim}.npy", heights)
        for missing_option, mask in (("error", True), ("mask", True), ("interpolate", False)):
            scan = read_measurement(
                tmp_path / f"{heights.ndim}.npy", outliers="mask", missing=missing_option, **READ_OPTIONS
            )
            assert np.abs(scan.heights - body.heights)[result].max() < 10 * mean_difference
            assert (scan.missing is not None) == mask
            assert any(f"{spike_indices.size} outliers" in step for step in scan.history)
    assert not find_outliers(np.full(20, np.nan)).any()


@pytest.mark.parametrize("shape", [(2000,), (96, 96)])
def test_outlier_detection_finds_neighbouring_outliers_and_outliers_at_the_edge(shape):
    heights = filtered_noise(np.random.default_rng(1), shape, 0.8)
    mean_difference = float(np.abs(np.diff(heights)).mean())
    spike_indices = [(0,), (400,), (401,), (800,), (802,), (1999,)]
    if len(shape) == 2:
        spike_indices = [
            (0, 40),
            (95, 20),
            (50, 0),
            (30, 30),
            (31, 31),
            (30, 60),
            (30, 62),
            (70, 70),
            (70, 71),
            (71, 70),
        ]
    is_spike = np.zeros(shape, bool)
    is_spike[tuple(np.transpose(spike_indices))] = True
    rng = np.random.default_rng(2)
    heights[is_spike] += (
        rng.choice([-1, 1], len(spike_indices)) * rng.uniform(40, 100, len(spike_indices)) * mean_difference
    )
    assert np.array_equal(find_outliers(heights), is_spike)


@pytest.mark.parametrize(("size", "is_outlier"), [(4, True), (5, False)])
def test_outlier_detection_finds_groups_of_up_to_four_points_but_not_of_five(size, is_outlier):
    heights = filtered_noise(np.random.default_rng(1), (96, 96), 0.8)
    group = np.zeros(heights.shape, bool)
    group[[40, 41, 40, 41, 42][:size], [50, 51, 52, 53, 52][:size]] = True
    signs = np.where(np.arange(size) % 2 == 0, 1.0, -1.0)
    heights[group] += 100 * signs * float(np.abs(np.diff(heights)).mean())
    assert find_outliers(heights)[group].all() == is_outlier
    assert find_outliers(heights)[group].any() == is_outlier


def test_outliers_of_a_map_are_the_same_in_its_transpose():
    """A map is evaluated in strips of rows, which differ between a map and its transpose."""
    rng = np.random.default_rng(11)
    heights = np.cumsum(np.cumsum(rng.normal(size=(40, 3000)), axis=0), axis=1)
    rows, columns = rng.integers(0, 40, 60), rng.integers(0, 3000, 60)
    heights[rows, columns] += 100 * np.ptp(heights)
    heights[rng.integers(0, 40, 60), rng.integers(0, 3000, 60)] = np.nan
    outliers = find_outliers(heights)
    assert np.count_nonzero(outliers) >= 50
    np.testing.assert_array_equal(outliers, find_outliers(np.ascontiguousarray(heights.T)).T)


def test_interpolated_heights_depend_only_on_measured_heights_of_other_points():
    plane = np.add.outer(np.arange(20.0), 2 * np.arange(30.0))
    points, is_missing, heights = np.zeros(plane.shape, bool), np.zeros(plane.shape, bool), plane.copy()
    points[4, 5:8], is_missing[4, 8:11], heights[4, 5:11] = True, True, 1e3
    surface = Surface(heights, spacing=0.5, missing=is_missing)
    assert with_interpolated_points(surface, np.zeros(plane.shape, bool)) is surface
    interpolated_surface = with_interpolated_points(surface, points)
    assert np.abs(interpolated_surface.heights - plane).max() < 1e-12
    assert np.array_equal(interpolated_surface.missing, is_missing)
    profile = Profile([5.0, 1.0, 2.0, 3.0, 9.0], spacing=1.0)
    at_ends = np.array([True, False, False, False, True])
    assert with_interpolated_points(profile, at_ends).heights.tolist() == [1, 1, 2, 3, 3]


@pytest.mark.parametrize("machining", MACHINED_SURFACES)
def test_outlier_detection_has_few_false_positives(machining):
    num_outliers = sum(
        int(find_outliers(MACHINED_SURFACES[machining](np.random.default_rng(seed), 1)).sum()) for seed in range(5)
    )
    assert num_outliers <= 10  # The five profiles have 10240 points in total.


def add_spikes(heights, seed):
    """Return heights with spikes of 4 to 12 rms heights at 0.15 % of the points, and a mask of the spikes."""
    rng, spiky_heights, is_spike = np.random.default_rng(seed), heights.copy(), np.zeros(heights.shape, bool)
    num_spikes = max(3, heights.size // 700)
    is_spike.flat[rng.choice(heights.size, num_spikes, replace=False)] = True
    spiky_heights[is_spike] += rng.choice([-1, 1], num_spikes) * rng.uniform(4, 12, num_spikes) * heights.std()
    return spiky_heights, is_spike


@pytest.mark.parametrize("num_levels", [8, 16, 32, 64, 256])
@pytest.mark.parametrize("shape", [(2048,), (96, 96)])
def test_outlier_detection_distinguishes_spikes_from_rounding(num_levels, shape):
    body_class, form = (Profile, "line") if len(shape) == 1 else (Surface, "plane")
    num_outliers = num_found = num_spikes = 0
    for seed, hurst, shortest in ((1, 0.8, None), (2, 1.0, None), (3, 0.8, 16), (4, 0.5, None)):
        heights = filtered_noise(np.random.default_rng(seed), shape, hurst, shortest_wavelength=shortest)
        spiky_heights, is_spike = add_spikes(heights, seed)
        step = np.ptp(heights) / (num_levels - 1)
        for scan_heights in (heights, spiky_heights):
            body = body_class(step * np.round(scan_heights / step), spacing=0.5)
            for body_heights in (body.heights, levelled(body, form).heights):
                is_outlier = find_outliers(body_heights)
                if scan_heights is heights:
                    num_outliers += int(is_outlier.sum())
                else:
                    num_outliers += int((is_outlier & ~is_spike).sum())
                    num_found += int((is_outlier & is_spike).sum())
                    num_spikes += int(is_spike.sum())
    assert num_outliers <= 2
    assert num_found > 0.97 * num_spikes


@pytest.mark.parametrize("num_levels", [None, 256])
@pytest.mark.parametrize("flat_fraction", [0.6, 0.8])
@pytest.mark.parametrize("shape", [(2048,), (128, 128)])
def test_outlier_detection_finds_spikes_of_partly_flat_scans(num_levels, flat_fraction, shape):
    body_class, form = (Profile, "line") if len(shape) == 1 else (Surface, "plane")
    num_found = num_spikes = num_outliers = num_points = 0
    for seed in range(3):
        heights = filtered_noise(np.random.default_rng(seed), shape, 0.7, longest_wavelength=60)
        heights = np.minimum(heights, np.quantile(heights, 1 - flat_fraction))
        if num_levels is not None:
            heights = np.round(heights * num_levels / np.ptp(heights)) * np.ptp(heights) / num_levels
        spiky_heights, is_spike = add_spikes(heights, seed)
        for scan_heights in (spiky_heights, levelled(body_class(spiky_heights, spacing=0.5), form).heights):
            is_outlier = find_outliers(scan_heights)
            num_found += int((is_outlier & is_spike).sum())
            num_spikes += int(is_spike.sum())
            num_outliers += int((is_outlier & ~is_spike).sum())
            num_points += heights.size
    assert num_found > 0.97 * num_spikes
    # Narrow valleys in a flat region of rounded heights may look like outliers.
    assert num_outliers <= (2 if num_levels is None else 0.015 * num_points)


def test_nominal_area_excludes_missing_points_and_interpolated_points_add_a_caveat(complete_surface, scan_path):
    scan, complete_result = (
        read_surface(scan_path, missing="mask", **READ_OPTIONS),
        pair(complete_surface, complete_surface, shifts=4, **PAIR_OPTIONS),
    )
    masked_result, interpolated_result = (
        pair(scan, scan, shifts=4, **PAIR_OPTIONS),
        pair(scan_path, scan_path, missing="interpolate", shifts=4, **READ_OPTIONS, **PAIR_OPTIONS),
    )
    area_ratio = masked_result.nominal_area / complete_result.nominal_area
    assert 0.6 < area_ratio < 0.9
    area = [
        float(result.dataset["contact_area"].mean()) / result.nominal_area
        for result in (masked_result, complete_result)
    ]
    # The area fractions are equal, because the same pressure acts on a smaller area.
    assert area[0] / area[1] == pytest.approx(1, abs=0.05)
    text = "12 % of the points are interpolated, in gaps larger than the contacts"
    assert any(text in caveat.text for caveat in interpolated_result.caveats)
    assert not any("interpolated" in caveat.text for caveat in masked_result.caveats)
    for rejected_options, message in (
        ({"mechanics": "asperities"}, "needs scans without masked points"),
        ({"surrogates": 2}, "surrogates generates surfaces from a spectrum and needs scans without"),
        ({"work_of_adhesion": "50 mJ/m^2"}, "work_of_adhesion needs scans without.*missing interpolate"),
    ):
        options = READ_OPTIONS | PAIR_OPTIONS | rejected_options
        options.pop("onset")
        with pytest.raises(ValueError, match=message):
            MeasuredPair.from_values(upper=scan_path, lower=scan_path, missing="mask", **options)


@pytest.mark.parametrize("mask", [np.ones(4, bool), np.zeros(5, bool), np.zeros(4)])
def test_invalid_mask_of_missing_points_is_rejected(mask):
    with pytest.raises(ValueError, match="`missing` must be a boolean array"):
        Profile(np.zeros(4), spacing=1.0, missing=mask)


def test_pair_function_rejects_maps_that_share_no_measured_position(complete_surface):
    rows = np.broadcast_to((np.arange(64) % 2 == 0)[:, np.newaxis], (64, 64))
    scan = Surface(complete_surface.heights, spacing=0.1, missing=rows)
    with pytest.raises(ValueError, match="share at least one measured position"):
        pair(scan, scan, shifts=4, **PAIR_OPTIONS)  # For some shifts, each row is missing in one of the scans.


def test_dangling_link_in_a_directory_of_scans_is_rejected(scan_path):
    (scan_path.parent / "gone.npy").symlink_to("nowhere.npy")
    with pytest.raises(ValueError, match=r"gone\.npy: cannot be read"):
        pair(scan_path.parent, scan_path, missing="mask", shifts=1, **READ_OPTIONS, **PAIR_OPTIONS)
