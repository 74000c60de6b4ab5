"""Tests of defects of a scan, which a pair, its alternatives and its caveats share, and of spectra without outliers."""

import gc
import pickle
import weakref
from collections import Counter

import numpy as np
import pytest
from stiction import Profile, Surface, levelled, pair, self_affine
from stiction.companions.resolution import find_resolved_roughness
from stiction.study.measured_bodies import MeasuredBodySettings
from stiction.study.pair_options import PairOptions
from stiction.study.pair_study import MeasuredPair
from stiction.summary.input_caveats import find_alternatives
from stiction.surfaces import missing_data, scan_defects
from stiction.surfaces import profile as profile_module
from stiction.surfaces.height_step import find_height_step
from stiction.surfaces.scan_defects import ScanDefects, find_scan_defects
from support.machined_surfaces import MACHINED_SURFACES, filtered_noise, scale_to_unit_rms
from support.rough_surfaces import rough_maps

pytestmark = pytest.mark.usefixtures("no_companion_files")


@pytest.fixture
def scan_directory(tmp_path, monkeypatch):
    """Change to a directory with the scans upper.npy and lower.npy."""
    monkeypatch.chdir(tmp_path)
    for side, surface in zip(("upper", "lower"), rough_maps(points=32), strict=True):
        np.save(f"{side}.npy", surface.heights)
    return tmp_path


def test_search_for_the_rounding_step_of_a_scan_runs_only_once(monkeypatch):
    steps = []

    def find_step(heights):
        steps.append(find_height_step(heights))
        return steps[-1]

    for module in (profile_module, missing_data):
        monkeypatch.setattr(module, "find_height_step", find_step)
    smooth_profile = self_affine(
        5, hurst_exponent=0.8, rms=0.1, points=4096, spacing=0.01, longest_wavelength=5.0, shortest_wavelength=0.5
    )
    defects = ScanDefects(Profile(np.round(smooth_profile.heights, 3), spacing=0.01), 2.0, textured=False)
    assert defects.num_spikes == 0
    assert defects.instrument_limit.reason == "quantisation"
    assert defects.instrument_limit_with_tip is not None
    assert steps == [pytest.approx(1e-3)]


def test_search_for_defects_of_each_scan_runs_only_once(scan_directory, monkeypatch):
    num_calls = Counter()

    def count_calls(name):
        function = getattr(scan_defects, name)

        def count_call(*arguments, **options):
            num_calls[name] += 1
            return function(*arguments, **options)

        monkeypatch.setattr(scan_defects, name, count_call)

    for name in ("instrument_limit", "find_hidden_noise", "find_outliers"):
        count_calls(name)
    result = pair(
        "upper.npy", "lower.npy", unit="um", spacing="0.1 um", effective_modulus="80 GPa", hardness="2 GPa", mu0=0.2,
        load="10 MPa", shifts=1, onset=0, direction=[0],
    )  # fmt: skip
    assert find_alternatives(result.study) == []
    assert not any("spike" in caveat.text for caveat in result.input_caveats)
    assert num_calls == {"instrument_limit": 2, "find_hidden_noise": 2, "find_outliers": 2}


def test_cached_defects_are_released_together_with_their_scan():
    scan = rough_maps(points=32)[0]
    defects = find_scan_defects(scan, None, textured=False)
    assert find_scan_defects(scan, None, textured=False) is defects
    assert find_scan_defects(scan, None, textured=True) is not defects
    assert defects.body_without_outliers is scan
    assert "_defects" not in vars(pickle.loads(pickle.dumps(scan)))
    reference = weakref.ref(scan)
    del scan, defects
    gc.collect()
    assert reference() is None


def test_scan_file_given_by_relative_and_absolute_paths_is_read_only_once(scan_directory):
    relative, absolute = (
        MeasuredBodySettings(file=str(file), unit="um", spacing="0.1 um")
        for file in ("upper.npy", scan_directory / "upper.npy")
    )
    assert relative.with_checksums().read() is absolute.read()
    assert relative.model_copy(update={"texture": "ground"}).read() is absolute.read()
    assert relative.model_copy(update={"outliers": "mask"}).read() is not absolute.read()


# ---- Spectra without outliers ----------------------------------------------------------------------------------------


# Relative difference between the cutoffs of a noisy scan with and without spikes. Spectra are assessed in bins of an
# eighth of an octave, and noise at the interpolated points is smaller.
CUTOFF_TOLERANCE = 0.2


def add_spikes(heights, num_spikes, seed=1):
    """Return a copy of heights in which some points are 5 to 20 rms heights above or below the surface."""
    rng, spiky_heights = np.random.default_rng(seed), heights.copy()
    indices = rng.choice(heights.size, num_spikes, replace=False)
    spiky_heights.flat[indices] += (
        rng.choice([-1, 1], num_spikes) * rng.uniform(5, 20, num_spikes) * float(heights.std())
    )
    return spiky_heights


def find_cutoff(defects):
    """Return the cutoff (µm) that a pair chooses for a scan, or 0 if the scan is not filtered."""
    limit = defects.instrument_limit if defects.instrument_limit.matters else defects.hidden_noise
    return 0.0 if limit is None else limit.cut_off


@pytest.mark.parametrize("num_spikes", [3, 20])
@pytest.mark.parametrize("shape", [(2000,), (96, 96)])
@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_cutoff_of_a_scan_with_spikes_equals_its_cutoff_without_spikes(num_spikes, shape, noise):
    rng, body_class = np.random.default_rng(3), Profile if len(shape) == 1 else Surface
    heights = 0.1 * scale_to_unit_rms(filtered_noise(rng, shape, 0.8)) + 0.1 * noise * rng.normal(size=shape)
    scans = (heights, add_spikes(heights, num_spikes))
    clean_defects, spiky_defects = (
        ScanDefects(body_class(scan_heights, spacing=0.5), None, textured=False) for scan_heights in scans
    )
    assert clean_defects.body_without_outliers is clean_defects.body
    assert (find_cutoff(clean_defects) > 0) == (noise > 0)
    assert find_cutoff(spiky_defects) == pytest.approx(find_cutoff(clean_defects), rel=CUTOFF_TOLERANCE)
    assert spiky_defects.instrument_limit.reason == clean_defects.instrument_limit.reason
    assert spiky_defects.num_spikes > 0.5 * num_spikes
    assert np.ptp(spiky_defects.body.heights) > 1.5 * np.ptp(clean_defects.body.heights)


@pytest.mark.parametrize("machining", MACHINED_SURFACES)
@pytest.mark.parametrize("dimensions", [1, 2])
def test_outliers_of_machined_surfaces_do_not_change_the_cutoff(machining, dimensions):
    body_class = Profile if dimensions == 1 else Surface
    for seed in range(2):
        heights = 0.05 * scale_to_unit_rms(MACHINED_SURFACES[machining](np.random.default_rng(seed), dimensions))
        body = body_class(heights, spacing=0.5)
        defects, unmasked_defects = (ScanDefects(body, None, textured=False) for _ in range(2))
        vars(unmasked_defects)["outliers"] = np.zeros(heights.shape, bool)
        assert find_cutoff(defects) == find_cutoff(unmasked_defects)


@pytest.mark.parametrize("slope", [0.0, 2.0**-7])
def test_spectrum_of_flat_scan_with_spikes_includes_the_spikes(slope):
    profile_heights, map_heights = np.arange(400) * slope, np.add.outer(np.arange(64.0), np.zeros(64)) * slope
    for body in (Profile(profile_heights, spacing=0.5), Surface(map_heights, spacing=0.5)):
        heights = body.heights.copy()
        heights.flat[210] += 0.3
        defects = ScanDefects(type(body)(heights, spacing=0.5), None, textured=False)
        assert defects.outliers.sum() == 1
        assert defects.body_without_outliers is defects.body
        assert defects.instrument_limit.matters


@pytest.mark.parametrize("flat_fraction", [0.6, 1.0])
@pytest.mark.parametrize("shape", [(2000,), (96, 96)])
def test_spikes_are_found_in_a_partly_flat_scan_before_and_after_levelling(flat_fraction, shape):
    heights = filtered_noise(np.random.default_rng(3), shape, 0.8, longest_wavelength=60)
    body_class, form = (Profile, "line") if len(shape) == 1 else (Surface, "plane")
    heights = 0.1 * np.minimum(heights, np.quantile(heights, 1 - flat_fraction))
    spiky_heights = heights.copy()
    spiky_heights.flat[[300, 700, 1100, 1500]] += 1.0
    body = body_class(spiky_heights, spacing=0.5)
    assert [ScanDefects(scan, None, textured=False).num_spikes for scan in (body, levelled(body, form))] == [4, 4]
    assert ScanDefects(body_class(heights, spacing=0.5), None, textured=False).num_spikes == 0


@pytest.mark.parametrize("num_levels", [8, 64])
@pytest.mark.parametrize("shape", [(2000,), (96, 96)])
def test_spikes_are_found_in_a_scan_with_rounded_heights(num_levels, shape):
    heights = filtered_noise(np.random.default_rng(3), shape, 0.8, shortest_wavelength=16)
    step, body_class = np.ptp(heights) / (num_levels - 1), Profile if len(shape) == 1 else Surface
    spiky_heights = add_spikes(heights, 5)
    for form in ("none", "line" if len(shape) == 1 else "plane"):
        num_spikes = []
        for scan_heights in (heights, spiky_heights):
            body = body_class(0.1 * step * np.round(scan_heights / step), spacing=0.5)
            body = body if form == "none" else levelled(body, form)
            num_spikes.append(ScanDefects(body, None, textured=False).num_spikes)
        assert num_spikes == [0, 5]


def build_scratched_profile(rng, num_points=2000):
    """Return heights with 40 scratches, each 2 to 8 points wide."""
    heights, x = 0.05 * scale_to_unit_rms(filtered_noise(rng, (num_points,), 0.8)), np.arange(num_points)
    for centre in rng.uniform(0, num_points, 40):
        heights -= rng.uniform(0.3, 1) * np.exp(-(((x - centre) / rng.uniform(2, 8)) ** 2))
    return 0.05 * scale_to_unit_rms(heights)


def build_honed_profile(rng, num_points=2000):
    """Return heights that are cut off at their median, with a smooth plateau."""
    heights, plateau = (
        scale_to_unit_rms(filtered_noise(rng, (num_points,), 0.8, longest_wavelength=longest)) for longest in (60, 500)
    )
    return 0.05 * scale_to_unit_rms(np.minimum(heights, np.median(heights)) + 0.03 * plateau)


@pytest.mark.parametrize("build_heights", [build_scratched_profile, build_honed_profile])
def test_spikes_but_not_scratches_are_found_in_scratched_and_honed_profiles(build_heights):
    num_found = {-1: 0, 1: 0}
    for seed in range(30):
        rng = np.random.default_rng(seed)
        heights = build_heights(rng)
        clean_defects = ScanDefects(Profile(heights, spacing=0.5), None, textured=False)
        assert clean_defects.num_spikes == 0
        for sign in num_found:
            spiky_heights = heights.copy()
            spiky_heights[rng.integers(3, heights.size - 3)] += sign * 5 * heights.std()
            num_found[sign] += ScanDefects(Profile(spiky_heights, spacing=0.5), None, textured=False).num_spikes > 0
    assert min(num_found.values()) >= 27


def test_outlier_of_a_few_rounding_steps_in_a_flat_profile_is_not_a_spike():
    rng = np.random.default_rng(0)
    steps = np.where(rng.random(2000) < 0.05, rng.choice([-1.0, 1.0, 2.0], 2000), 0.0)
    for height, num_spikes in ((4.0, 0), (8.0, 1)):
        steps[1000] = height
        defects = find_scan_defects(Profile(0.001 * steps, spacing=0.1), None, textured=False)
        assert defects.outliers[1000]
        assert defects.num_spikes == num_spikes


def test_scan_defects_are_cached_separately_for_periodic_and_nonperiodic_evaluation():
    profile = Profile(filtered_noise(np.random.default_rng(1), (512,), 0.8), spacing=0.1)
    options = {"tip_radius": 2.0, "textured": False}
    defects, periodic_defects = (
        find_scan_defects(profile, **options, periodic=is_periodic) for is_periodic in (False, True)
    )
    assert (defects.periodic, periodic_defects.periodic) == (False, True)


def test_spikes_cause_no_filtering_of_a_measured_pair(tmp_path):
    paths = []
    for side, surface in zip(("upper", "lower"), rough_maps(points=128), strict=True):
        paths.append(str(tmp_path / f"{side}.npy"))
        np.save(paths[-1], add_spikes(surface.heights, 6))
    options = {"unit": "um", "spacing": "0.1 um", "effective_modulus": "80 GPa", "mu0": 0.2, "load": "10 MPa"}
    study = MeasuredPair(PairOptions(upper=paths[0], lower=paths[1], **options)).study
    assert not study.surfaces.both_readings
    assert [float(cutoff) for cutoff in study.surfaces.cut_off] == [0.0]
    assert np.array_equal(study.surfaces.upper.read().heights, np.load(paths[0]))
    assert find_alternatives(study) == ["spikes"]


def test_extrapolated_roughness_of_a_gap_excludes_spikes():
    options = {"effective_modulus": "80 GPa", "mu0": 0.2, "load": "10 MPa", "shifts": 1}
    roughnesses = []
    for num_spikes in (0, 20):
        bodies = (Surface(add_spikes(surface.heights, num_spikes), spacing=0.1) for surface in rough_maps(points=64))
        study = MeasuredPair(PairOptions(**dict(zip(("upper", "lower"), bodies, strict=True)), **options)).study
        roughnesses.append(find_resolved_roughness(study))
    clean_roughness, spiky_roughness = roughnesses
    assert spiky_roughness.gradient == pytest.approx(clean_roughness.gradient, rel=0.02)
    assert spiky_roughness.estimate.value == pytest.approx(clean_roughness.estimate.value, abs=0.05)


def test_estimated_roughness_drift_is_limited_if_the_roughness_changes_abruptly():
    """Check the upper limit of the drift, because a linear fit overestimates an abrupt change of the roughness."""
    heights = rough_maps(points=96)[0].heights.copy()
    heights[:, 48:] *= 0.02
    assert scan_defects.estimate_roughness_drift(Surface(heights, spacing=0.1)) == scan_defects.MAX_LOG_SLOPE_DRIFT
