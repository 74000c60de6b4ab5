import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from stiction import Study, pair_of, random_phases, weierstrass_mandelbrot
from stiction.study import members as members_module
from support.studies_of_files import pair_study, write_maps

MATERIAL_OPTIONS_OF_PAIR = {"effective_modulus": "100 GPa", "hardness": "2 GPa", "load": "1 MPa", "mu0": 0.2}

STUDY = Study().with_changes(
    {
        "surfaces.fractal_dimension": [1.1, 1.4],
        "surfaces.amplitude": ["50 nm", "100 nm"],
        "surfaces.amplitude_measure": "Rq",
        "surfaces.points": 3000,
        "surfaces.extent": "2 um",
        "surfaces.length_scale": "0.9 um",
        "surfaces.gamma": 1.6,
        "surfaces.directions": 30,
        "surfaces.frequencies": 20,
        "surfaces.convention": "classical",
        "surfaces.band_limit": "nyquist",
        "contact.approach.count": 4,
        "ensemble.repetitions": 3,
    }
)


@pytest.mark.parametrize("batch_size", [1, 2, 5])
def test_pairs_generated_together_equal_pairs_generated_one_at_a_time(monkeypatch, batch_size):
    monkeypatch.setattr(members_module, "MAX_BATCH_BYTES", batch_size * 8 * STUDY.surfaces.points)
    dimensions = np.array([1.0, 1.2, 1.45])
    pairs = list(members_module.generate_profile_pairs(STUDY, 1, dimensions, 0.1))
    assert len(pairs) == dimensions.size
    for dimension, result in zip(dimensions, pairs, strict=True):
        for body, expected in zip(result, pair_of(STUDY, 1, fractal_dimension=dimension, amplitude=0.1), strict=True):
            assert body.heights.tobytes() == expected.heights.tobytes()
            assert body.spacing == expected.spacing


def test_profiles_of_the_nth_pair_of_a_study_equal_directly_generated_profiles():
    upper, lower = pair_of(STUDY, 7, fractal_dimension=1.25, amplitude=0.1)
    for body, side in ((upper, "upper"), (lower, "lower")):
        phases = random_phases(2016, repetition=7, side=side, directions=30, frequencies=20)
        expected = weierstrass_mandelbrot(
            phases, 1.25, length_scale=0.9, gamma=1.6, extent=2.0, points=3000, convention="classical",
            band_limit="nyquist",
        ).with_amplitude(0.1, "Rq")  # fmt: skip
        assert body.heights.tobytes() == expected.heights.tobytes()
        assert body.spacing == expected.spacing
        assert not body.heights.flags.writeable
    other_upper, _ = pair_of(STUDY, 8, fractal_dimension=1.25, amplitude=0.1)
    assert not np.array_equal(other_upper.heights, upper.heights)


@pytest.mark.parametrize(
    ("repetition", "dimension", "amplitude", "pattern"),
    [
        (-1, 1.2, 0.1, "repetition must be"),
        (0.5, 1.2, 0.1, "repetition must be"),
        (0, 2.0, 0.1, "fractal_dimension must be"),
        (0, 1.2, 0.0, "amplitude must be"),
    ],
)
def test_pair_generation_rejects_invalid_arguments(repetition, dimension, amplitude, pattern):
    with pytest.raises(ValueError, match=pattern):
        pair_of(STUDY, repetition, fractal_dimension=dimension, amplitude=amplitude)


def test_measured_bodies_are_filtered_only_once_for_all_threads(tmp_path):
    spacing = write_maps(tmp_path, shape=(256, 256))
    study = pair_study(
        tmp_path / "upper.npy", tmp_path / "lower.npy", spacing=spacing, unit="um", **MATERIAL_OPTIONS_OF_PAIR
    )
    bodies, num_threads = members_module.read_measured_bodies(study), 4
    barrier = threading.Barrier(num_threads)

    def find_members(cutoff):
        barrier.wait()
        return bodies.members(cutoff)

    with ThreadPoolExecutor(num_threads) as pool:
        for cutoff in (1.0, 2.0, 3.0):
            first_members, *other_members = pool.map(find_members, [cutoff] * num_threads)
            assert all(members is first_members for members in other_members)


def test_nominal_area_of_a_measured_pair_is_computed_without_preparing_the_bodies_again(tmp_path, monkeypatch):
    spacing = write_maps(tmp_path)
    pressed_bodies = []
    monkeypatch.setattr(members_module, "estimate_roughness_drift", lambda body: pressed_bodies.append(body) or 0.0)
    # The hardness times the nominal area limits the load.
    study = pair_study(
        tmp_path / "upper.npy", tmp_path / "lower.npy", spacing=spacing, unit="um", **MATERIAL_OPTIONS_OF_PAIR
    )
    assert members_module.find_body_attributes(study).nominal_area > 0
    assert len(pressed_bodies) == 2
