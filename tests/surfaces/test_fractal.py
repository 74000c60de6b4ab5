import math

import numpy as np
import pytest
from reference import direct_sum
from stiction import (
    random_phases,
    weierstrass_mandelbrot,
    weierstrass_mandelbrot_family,
    weierstrass_mandelbrot_surface,
)

# Tolerance relative to the total height, for the round-off of 1600 cosines and of a recurrence of 256 steps.
# Phases have 64 bits; long double phases of the reference have errors of about 1e-10 rad at the highest frequency.
DIRECT_SUM_TOLERANCE = 1e-12
SMALL_GRID_ARGUMENTS = {"points": 3000, "extent": 2.0}


def hurst_of_dimension(dimension, convention):
    return 4 - 2 * dimension if convention == "paper" else 2 - dimension


class TestRandomPhases:
    def test_random_phases_equal_recorded_values_in_every_version_of_numpy(self):
        # The expected phases are recorded numbers, because all versions of NumPy generate the same raw PCG64 words.
        phases = random_phases(2016, repetition=7, side="upper", directions=2, frequencies=2)
        assert phases.tolist() == RECORDED_PHASES

    def test_random_phases_depend_only_on_the_seed_and_repetition_and_side(self):
        phases = random_phases(1, repetition=2, side="upper")
        assert phases.shape == (40, 40)
        assert np.array_equal(phases, random_phases(1, repetition=2, side="upper"))
        for other_phases in (
            random_phases(2, repetition=2, side="upper"),
            random_phases(1, repetition=3, side="upper"),
            random_phases(1, repetition=2, side="lower"),
        ):
            assert abs(np.corrcoef(phases.ravel(), other_phases.ravel())[0, 1]) < 0.1

    @pytest.mark.parametrize(
        "invalid_arguments",
        [{"seed": -1}, {"seed": 1.5}, {"repetition": -1}, {"side": "top"}, {"directions": 0}, {"frequencies": True}],
    )
    def test_random_phases_reject_invalid_arguments(self, invalid_arguments):
        name = next(iter(invalid_arguments))
        with pytest.raises(ValueError, match=name):
            random_phases(**({"seed": 1} | invalid_arguments))


RECORDED_PHASES = [[5.314689153886981, 0.4447781159997328], [3.286748312852867, 5.168936610054548]]


class TestFractalProfile:
    @pytest.mark.parametrize("band_limit", [None, "nyquist"])
    @pytest.mark.parametrize("convention", ["paper", "classical"])
    @pytest.mark.parametrize("dimension", [1.0, 1.35, 1.7])
    def test_fractal_profile_of_150000_points_equals_direct_summation_of_its_cosine_terms(
        self, dimension, convention, band_limit
    ):
        phases = random_phases(5, side="upper")
        profile = weierstrass_mandelbrot(phases, dimension, convention=convention, band_limit=band_limit)
        restart_indices = [np.arange(k - 3, k + 3) for k in (1024, 8192, 81_920)]
        indices = np.unique(np.concatenate([np.arange(5), *restart_indices, np.arange(7, 150_000, 3001), [149_999]]))
        expected = direct_sum.weierstrass_mandelbrot(
            phases,
            hurst_of_dimension(dimension, convention),
            length_scale=1.0,
            gamma=1.5,
            extent=40.0,
            points=150_000,
            at=indices,
            nyquist=band_limit == "nyquist",
        )
        relative_error = np.abs(profile.heights[indices] - expected).max() / np.ptp(profile.heights)
        assert relative_error < DIRECT_SUM_TOLERANCE

    def test_fractal_profile_with_random_parameters_equals_direct_summation_of_its_cosine_terms(self):
        for directions, gamma, length_scale in ((1, 1.5, 1.0), (2, 2.0, 0.3), (7, 1.1, 5.0), (40, 1.7, 2.0)):
            phases = random_phases(9, directions=directions, frequencies=12)
            settings = {"length_scale": length_scale, "gamma": gamma, **SMALL_GRID_ARGUMENTS}
            profile = weierstrass_mandelbrot(phases, 1.4, **settings)
            expected = direct_sum.weierstrass_mandelbrot(phases, 1.2, **settings)
            assert np.abs(profile.heights - expected).max() < DIRECT_SUM_TOLERANCE * np.ptp(profile.heights)

    def test_fractal_profile_starts_at_height_zero(self):
        assert weierstrass_mandelbrot(random_phases(1), 1.5, **SMALL_GRID_ARGUMENTS).heights[0] == pytest.approx(
            0, abs=1e-13
        )

    def test_classical_profile_of_dimension_d_equals_paper_profile_of_dimension_1_plus_half_d(self):
        phases = random_phases(4)
        for dimension in (1.0, 1.3, 1.9):
            classical_profile = weierstrass_mandelbrot(
                phases, dimension, convention="classical", **SMALL_GRID_ARGUMENTS
            )
            profile_of_paper = weierstrass_mandelbrot(phases, 1 + dimension / 2, **SMALL_GRID_ARGUMENTS)
            assert np.allclose(classical_profile.heights, profile_of_paper.heights, rtol=0, atol=1e-12)

    def test_batch_of_profiles_equals_single_profiles_bit_for_bit(self):
        phases = random_phases(6)
        dimensions = [1.0, 1.2, 1.65]
        heights_by_dimension = weierstrass_mandelbrot_family(phases, dimensions, **SMALL_GRID_ARGUMENTS)
        assert heights_by_dimension.shape == (3, 3000)
        for row, dimension in zip(heights_by_dimension, dimensions, strict=True):
            assert np.array_equal(row, weierstrass_mandelbrot(phases, dimension, **SMALL_GRID_ARGUMENTS).heights)
        assert weierstrass_mandelbrot_family(phases, [], **SMALL_GRID_ARGUMENTS).shape == (0, 3000)

    @pytest.mark.parametrize(
        "invalid_arguments",
        [
            {"fractal_dimension": 0.99},
            {"fractal_dimension": 2.0},
            {"fractal_dimension": math.nan},
            {"fractal_dimension": "1.5"},
            {"phases": np.zeros(3)},
            {"phases": np.full((2, 2), np.inf)},
            {"length_scale": 0},
            {"gamma": 1.0},
            {"extent": -1.0},
            {"points": 3},
            {"points": 1e4},
            {"convention": "textbook"},
            {"band_limit": "none"},
            {"gamma": 1e6},
        ],
    )
    def test_fractal_profile_rejects_invalid_arguments(self, invalid_arguments):
        arguments = {"phases": random_phases(1), "fractal_dimension": 1.5, "points": 100} | invalid_arguments
        with pytest.raises(ValueError, match=next(iter(invalid_arguments))):
            weierstrass_mandelbrot(arguments.pop("phases"), arguments.pop("fractal_dimension"), **arguments)

    def test_fractal_surface_rejects_an_array_of_phases_for_zero_directions(self):
        with pytest.raises(ValueError, match="at least one direction"):
            weierstrass_mandelbrot(np.zeros((0, 5)), 1.5, points=100)


class TestFractalSurface:
    SHAPE, EXTENT = (60, 90), (3.0, 2.0)

    @pytest.mark.parametrize("band_limit", [None, "nyquist"])
    @pytest.mark.parametrize(("dimension", "convention"), [(1.0, "paper"), (1.6, "paper"), (1.7, "classical")])
    def test_fractal_surface_equals_direct_summation_of_its_cosine_terms(self, dimension, convention, band_limit):
        phases = random_phases(5, side="upper")
        surface = weierstrass_mandelbrot_surface(
            phases, dimension, shape=self.SHAPE, extent=self.EXTENT, convention=convention, band_limit=band_limit
        )
        random = np.random.default_rng(2)
        indices = np.vstack([[(0, 0), (59, 89), (0, 89), (59, 0)], random.integers(self.SHAPE, size=(40, 2))])
        expected = direct_sum.weierstrass_mandelbrot_surface(
            phases,
            hurst_of_dimension(dimension, convention),
            length_scale=1.0,
            gamma=1.5,
            extents=self.EXTENT,
            shape=self.SHAPE,
            at=indices,
            nyquist=band_limit == "nyquist",
        )
        computed_heights = surface.heights[tuple(np.transpose(indices))]
        assert np.abs(computed_heights - expected).max() < DIRECT_SUM_TOLERANCE * np.ptp(surface.heights)

    def test_first_row_of_a_fractal_surface_equals_a_profile(self):
        phases = random_phases(8)
        surface = weierstrass_mandelbrot_surface(phases, 1.5, shape=(5, 3000), extent=(1.0, 2.0), length_scale=0.7)
        profile = weierstrass_mandelbrot(phases, 1.5, length_scale=0.7, **SMALL_GRID_ARGUMENTS)
        row = surface.row(0)
        assert row.spacing == profile.spacing
        assert np.abs(row.heights - profile.heights).max() < DIRECT_SUM_TOLERANCE * np.ptp(profile.heights)

    def test_band_limit_omits_harmonics_that_the_grid_cannot_resolve(self):
        phases = random_phases(8, frequencies=100)
        band_limited_surface = weierstrass_mandelbrot_surface(
            phases, 1.2, shape=(30, 30), extent=1.0, band_limit="nyquist"
        )
        surface_with_fewer_frequencies = weierstrass_mandelbrot_surface(
            phases[:, :20], 1.2, shape=(30, 30), extent=1.0, band_limit="nyquist"
        )
        assert np.allclose(band_limited_surface.heights, surface_with_fewer_frequencies.heights, rtol=0, atol=1e-12)

    def test_first_row_of_a_fractal_surface_on_a_long_narrow_strip_equals_a_profile(self):
        phases = random_phases(8)
        strip = weierstrass_mandelbrot_surface(phases, 1.5, shape=(2, 50_000), extent=(0.1, 4.0))
        profile = weierstrass_mandelbrot(phases, 1.5, points=50_000, extent=4.0)
        assert np.abs(strip.heights[0] - profile.heights).max() < DIRECT_SUM_TOLERANCE * np.ptp(profile.heights)

    @pytest.mark.parametrize(
        ("invalid_arguments", "match"),
        [
            ({"shape": 10}, "shape"),
            ({"shape": (10, 1)}, "shape"),
            ({"shape": (10**5, 10**5)}, "shape"),
            ({"extent": 0.0}, "extent"),
            ({"extent": (1.0, 2.0, 3.0)}, "extent"),
            ({"gamma": 30.0}, "resolved"),
            ({"fractal_dimension": 2.0}, "fractal_dimension"),
            ({"band_limit": "low"}, "band_limit"),
            ({"phases": [1.0]}, "phases"),
            ({"phases": np.empty((0, 3))}, "phases"),
        ],
    )
    def test_fractal_surface_rejects_invalid_arguments(self, invalid_arguments, match):
        arguments = {"phases": random_phases(1), "fractal_dimension": 1.3, "shape": (10, 10)} | invalid_arguments
        with pytest.raises(ValueError, match=match):
            weierstrass_mandelbrot_surface(**arguments)


def test_height_variance_of_a_fractal_equals_half_of_the_sum_of_squared_amplitudes():
    # Directions m and M - m have independent phases, and direction m = M/2 has no harmonic.
    dimension, gamma = 1.2, 1.5
    weights = math.log(gamma) * gamma ** (-np.arange(40) * hurst_of_dimension(dimension, "paper"))
    expected = 0.5 * 39 * np.square(weights).sum()
    measured_variances = [
        np.var(weierstrass_mandelbrot(random_phases(8, repetition=r), dimension, points=20_000).heights)
        for r in range(60)
    ]
    # The variance of one profile scatters by about 10 %, so the mean over 60 profiles scatters by 1.3 %.
    assert np.mean(measured_variances) == pytest.approx(expected, rel=0.05)
