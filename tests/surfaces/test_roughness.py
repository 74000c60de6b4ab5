"""Tests of roughness parameters against slow definitions, closed forms, SurfaceTopography and surfalize."""

import math

import numpy as np
import pytest
from stiction import (
    Profile,
    Surface,
    bearing_curve,
    levelled,
    power_spectrum,
    read_profile,
    roughness_parameters,
    surface_parameters,
)
from stiction.surfaces.roughness import autocorrelation
from support.rough_surfaces import AMPLITUDE, WAVELENGTH, rough_profile, sinusoid

ROUND_OFF = 1e-12


class TestRoughnessParameters:
    def test_roughness_parameters_of_a_sinusoid_equal_closed_forms(self):
        # Even moments over whole periods are exact. The mean of |sin| at n points per period is below 2/π by π²/3n².
        n = 512
        result = roughness_parameters(sinusoid(n))
        assert result.Pa == pytest.approx(2 / np.pi * AMPLITUDE, rel=1.01 * np.pi**2 / (3 * n**2) * 4)
        assert result.Pq == pytest.approx(AMPLITUDE / np.sqrt(2), rel=ROUND_OFF)
        assert result.Pt == pytest.approx(2 * AMPLITUDE, rel=ROUND_OFF)
        assert result.Psk == pytest.approx(0, abs=ROUND_OFF)
        assert result.Pku == pytest.approx(1.5, rel=ROUND_OFF)

    @pytest.mark.parametrize(("derivative", "order", "factor"), [("neighbours", 2, 24), ("seven-point", 6, 140)])
    def test_numerical_slope_of_a_sinusoid_has_the_error_predicted_for_its_difference_formula(
        self, derivative, order, factor
    ):
        exact_slope = 2 * np.pi / WAVELENGTH * AMPLITUDE / np.sqrt(2)
        for n in (16, 32):
            # Use a long sinusoid, because six of its points have no seven-point slope.
            relative_error = (
                1 - roughness_parameters(sinusoid(n, waves=40_000), derivative=derivative).Pdq / exact_slope
            )
            # The next term of the error of the difference formula is smaller by a factor of about (2π/n)².
            assert relative_error == pytest.approx(
                (2 * np.pi / n) ** order / factor, rel=(2 * np.pi / n) ** 2, abs=2e-6
            )

    def test_roughness_parameters_of_normal_heights_equal_closed_forms(self):
        result = roughness_parameters(rough_profile(points=200_000, longest_wavelength=1.0))
        # The map has about 2000 independent heights.
        # Tolerances of Psk and Pku are four times their standard errors of 0.05 and 0.11.
        assert result.Psk == pytest.approx(0, abs=0.2)
        assert result.Pku == pytest.approx(3, abs=0.45)
        assert result.Pa / result.Pq == pytest.approx(np.sqrt(2 / np.pi), rel=0.02)

    @pytest.mark.parametrize("factor", [1e-45, 1e45])
    def test_height_and_slope_parameters_scale_with_the_heights_but_skewness_and_kurtosis_do_not(self, factor):
        profile = rough_profile()
        original_parameters, scaled_parameters = (
            roughness_parameters(profile),
            roughness_parameters(Profile(profile.heights * factor, spacing=0.01)),
        )
        for name in ("Pa", "Pq", "Pt", "Pdq"):
            assert getattr(scaled_parameters, name) == pytest.approx(
                factor * getattr(original_parameters, name), rel=ROUND_OFF
            )
        assert scaled_parameters.Psk == pytest.approx(original_parameters.Psk, rel=1e-9)
        assert scaled_parameters.Pku == pytest.approx(original_parameters.Pku, rel=1e-9)

    def test_skewness_is_negative_for_deep_valleys(self):
        assert roughness_parameters(Profile([0.0] * 20 + [-1.0] + [0.0] * 20, spacing=1.0)).Psk < -1

    def test_roughness_parameters_reject_invalid_arguments(self):
        with pytest.raises(ValueError, match="flat"):
            roughness_parameters(Profile([1.0] * 10, spacing=1.0))
        with pytest.raises(ValueError, match="7 points"):
            roughness_parameters(Profile([0.0, 1.0, 0.0, 1.0], spacing=1.0))
        with pytest.raises(ValueError, match="derivative"):
            roughness_parameters(rough_profile(), derivative="spline")


# Ignore warnings of SurfaceTopography about its own names and imports.
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
class TestAgainstSurfaceTopographyPackage:
    TRANSFORM_TOLERANCE = 1e-9

    @pytest.fixture
    def line_scan_class(self):
        return pytest.importorskip("SurfaceTopography").UniformLineScan

    @pytest.fixture(params=["generated", "measured"])
    def profile(self, request):
        if request.param == "measured":
            return levelled(read_profile(request.getfixturevalue("find_measured_file")("dektak-1.csv")), "line")
        return levelled(rough_profile(), "mean")

    def test_levelling_agrees_with_the_surfacetopography_library(self, line_scan_class, find_measured_file):
        profile = read_profile(find_measured_file("dektak-1.csv"))
        other_profile = line_scan_class(profile.heights.copy(), profile.extent, unit="um").detrend("height")
        assert np.abs(other_profile.heights() - levelled(profile, "line").heights).max() < self.TRANSFORM_TOLERANCE

    def test_rms_height_and_slope_agree_with_the_surfacetopography_library(self, line_scan_class, profile):
        other_profile = line_scan_class(profile.heights, profile.extent, unit="um")
        parameters = roughness_parameters(profile, derivative="neighbours")
        assert parameters.Pq == pytest.approx(other_profile.rms_height_from_profile(), rel=self.TRANSFORM_TOLERANCE)
        assert parameters.Pdq == pytest.approx(other_profile.rms_slope_from_profile(), rel=self.TRANSFORM_TOLERANCE)
        # SurfaceTopography includes the step from the last to the first point of a periodic profile.
        periodic_scan = line_scan_class(profile.heights, profile.extent, unit="um", periodic=True)
        end_slope = (profile.heights[0] - profile.heights[-1]) / profile.spacing
        points = len(profile)
        expected = np.sqrt(((points - 1) * parameters.Pdq**2 + end_slope**2) / points)
        assert periodic_scan.rms_slope_from_profile() == pytest.approx(expected, rel=self.TRANSFORM_TOLERANCE)

    @pytest.mark.parametrize("periodic", [True, False])
    def test_power_spectrum_agrees_with_the_surfacetopography_library(self, line_scan_class, profile, periodic):
        other_profile = line_scan_class(profile.heights, profile.extent, unit="um", periodic=periodic)
        q, density = other_profile.power_spectrum_from_profile(resampling_method=None)
        computed_spectrum = power_spectrum(profile, periodic=periodic)
        # the spectrum of SurfaceTopography begins at q = 0 and ends before the Nyquist wave number
        common_indices = slice(0, q.size - 1)
        assert np.allclose(computed_spectrum.wave_number[common_indices], q[1:], rtol=self.TRANSFORM_TOLERANCE, atol=0)
        assert np.allclose(
            computed_spectrum.density[common_indices],
            density[1:],
            rtol=self.TRANSFORM_TOLERANCE,
            atol=self.TRANSFORM_TOLERANCE**2 * density.max(),
        )


def gaussian_surface(seed=1, shape=(40, 50), spacing=(0.5, 0.25), smooth=2.0):
    """Return periodic heights with a Gaussian distribution and a Gaussian autocorrelation."""
    white_noise = np.random.default_rng(seed).normal(size=shape)
    q = np.hypot(2 * np.pi * np.fft.fftfreq(shape[0])[:, np.newaxis], 2 * np.pi * np.fft.fftfreq(shape[1]))
    return Surface(np.fft.ifft2(np.fft.fft2(white_noise) * np.exp(-((smooth * q) ** 2) / 2)).real, spacing=spacing)


def parameters_by_definition(surface):
    """Return parameters of heights, slopes and area as the standard defines them, computed point by point."""
    z, (dy, dx) = surface.heights - surface.heights.mean(), surface.spacing
    rows, columns = z.shape
    n = z.size
    sq = math.sqrt(math.fsum(v * v for v in z.flat) / n)
    slopes_x = [(z[j, i + 1] - z[j, i]) / dx for j in range(rows) for i in range(columns - 1)]
    slopes_y = [(z[j + 1, i] - z[j, i]) / dy for j in range(rows - 1) for i in range(columns)]
    area = 0.0
    for j in range(rows - 1):
        for i in range(columns - 1):
            corners = [np.array([x * dx, y * dy, z[j + y, i + x]]) for y, x in ((0, 0), (0, 1), (1, 0), (1, 1))]
            for a, b, c in ((0, 1, 2), (3, 1, 2), (1, 0, 3), (2, 0, 3)):
                area += np.linalg.norm(np.cross(corners[b] - corners[a], corners[c] - corners[a])) / 4
    return {
        "Sq": sq, "Sa": math.fsum(abs(v) for v in z.flat) / n, "Sz": float(z.max() - z.min()),
        "Ssk": math.fsum(v**3 for v in z.flat) / n / sq**3, "Sku": math.fsum(v**4 for v in z.flat) / n / sq**4,
        "Sdq": math.sqrt(np.mean(np.square(slopes_x)) + np.mean(np.square(slopes_y))),
        "Sdr": area / ((rows - 1) * (columns - 1) * dx * dy) - 1,
    }  # fmt: skip


@pytest.mark.parametrize("factor", [1.0, 1e-6])
def test_surface_parameters_equal_their_definitions(factor):
    surface = Surface(3.0 + factor * gaussian_surface().heights, spacing=(0.5, 0.25))
    result, expected = surface_parameters(surface, derivative="neighbours"), parameters_by_definition(surface)
    for name, value in expected.items():
        # The tolerance allows for digits lost in the difference between the area and the projected area.
        tolerance = 1e-9 if name != "Sdr" else 1e-9 + 1e-15 / value
        assert getattr(result, name) == pytest.approx(value, rel=tolerance), name


def test_seven_point_slope_of_a_surface_is_computed_from_slopes_of_its_rows_and_columns():
    surface = gaussian_surface()
    rows = [roughness_parameters(surface.row(index)).Pdq for index in range(40)]
    columns = [roughness_parameters(surface.column(index)).Pdq for index in range(50)]
    expected = math.sqrt(np.mean(np.square(rows)) + np.mean(np.square(columns)))
    assert surface_parameters(surface).Sdq == pytest.approx(expected, rel=ROUND_OFF)


def test_autocorrelation_equals_the_mean_product_over_the_overlap():
    z = gaussian_surface(shape=(9, 12)).heights
    z = z - z.mean()
    result = autocorrelation(z)
    assert result.shape == (5, 13)
    for j in range(5):
        for shift in range(-6, 7):
            pairs = [
                z[y, x] * z[y + j, x + shift] for y in range(9 - j) for x in range(max(0, -shift), min(12, 12 - shift))
            ]
            assert result[j, shift + 6] == pytest.approx(np.mean(pairs) / np.mean(z**2), abs=ROUND_OFF)


def test_autocorrelation_lengths_of_gaussian_surfaces_equal_closed_forms():
    # The correlation exp(-r²/4s²) falls to 0.2 at the lag r = 2 s sqrt(ln 5).
    # The map has 60 correlation areas, so the correlation scatters by a few per cent.
    surface = gaussian_surface(shape=(600, 700), spacing=0.5, smooth=8.0)
    result = surface_parameters(surface)
    assert result.Sal == pytest.approx(2 * 8.0 * 0.5 * math.sqrt(math.log(5)), rel=0.08)
    assert result.Str > 0.8
    stretched_parameters = surface_parameters(Surface(surface.heights, spacing=(1.5, 0.5)))
    assert stretched_parameters.Sal == pytest.approx(result.Sal, rel=0.1)
    assert stretched_parameters.Str == pytest.approx(1 / 3, rel=0.15)


def grooved_surface(angle, shape=(200, 240), spacing=0.1, wavelength=2.0):
    """Return a sinusoid along a direction (degrees). The grooves are perpendicular to this direction."""
    y, x = spacing * np.arange(shape[0])[:, np.newaxis], spacing * np.arange(shape[1])
    x_across = x * np.cos(np.radians(angle)) + y * np.sin(np.radians(angle))
    return Surface(np.cos(2 * np.pi * x_across / wavelength), spacing=spacing)


@pytest.mark.parametrize("angle", [0, 31, 90, 135])
def test_texture_direction_equals_the_direction_of_grooves(angle):
    result = surface_parameters(grooved_surface(angle))
    # The autocorrelation, a cosine except for partial periods, falls to 0.2 at arccos(0.2)/2π of the wavelength.
    assert result.Sal == pytest.approx(2.0 * math.acos(0.2) / (2 * math.pi), rel=0.02)
    assert math.isnan(result.Str)  # Along the grooves the autocorrelation never falls to 0.2.
    angle_error = abs((result.Std - angle + 90) % 180 - 90)
    assert angle_error <= 3  # directions are known to half a sector of 2°, plus the effect of the window


def test_core_roughness_of_known_distributions_equals_closed_forms():
    # Uniformly distributed heights have a straight bearing curve, without peaks or valleys.
    uniform_surface = Surface(
        np.random.default_rng(1).permutation(np.linspace(0, 2, 10_000)).reshape(100, 100), spacing=1.0
    )
    result = surface_parameters(uniform_surface)
    assert result.Sk == pytest.approx(2, rel=1e-3)
    assert result.Spk == pytest.approx(0, abs=1e-3)
    # Expected values for normal heights are integrals of the normal distribution.
    # The core from 30 to 70 % is fitted by least squares.
    from scipy.stats import norm

    material_ratios = np.linspace(0.3, 0.7, 40_001)
    slope, upper_core_limit = np.polyfit(material_ratios, norm.isf(material_ratios), 1)
    lower_core_limit = slope + upper_core_limit
    normal_surface = Surface(
        np.random.default_rng(2).permutation(norm.isf((np.arange(250_000) + 0.5) / 250_000)).reshape(500, 500),
        spacing=1.0,
    )
    result = surface_parameters(normal_surface)
    assert result.Sk == pytest.approx(-slope, rel=1e-3)
    assert result.Smr1 == pytest.approx(norm.sf(upper_core_limit), abs=1e-3)
    assert result.Smr2 == pytest.approx(norm.sf(lower_core_limit), abs=1e-3)
    assert result.Spk == pytest.approx(
        2 * (norm.pdf(upper_core_limit) - upper_core_limit * norm.sf(upper_core_limit)) / norm.sf(upper_core_limit),
        rel=5e-3,
    )
    assert result.Svk == pytest.approx(result.Spk, rel=5e-3)


def test_reduced_peak_height_is_the_height_of_a_triangle_of_equal_area():
    surface = gaussian_surface(seed=5)
    result = surface_parameters(surface)
    z = np.sort(surface.heights.ravel() - surface.heights.mean())[::-1]
    upper = z[round(result.Smr1 * z.size) - 1]
    peaks = z[: round(result.Smr1 * z.size)]
    assert peaks.min() >= upper
    area = result.Spk * result.Smr1 / 2
    core_top = (peaks.sum() / z.size - area) / result.Smr1
    assert z[round(result.Smr1 * z.size)] <= core_top <= upper


def test_bearing_curve_returns_heights_at_material_ratios():
    surface = gaussian_surface()
    ratios = np.array([0.1, 0.5, 0.93])
    heights = bearing_curve(surface, ratios)
    assert [np.mean(surface.heights > height) for height in heights] == pytest.approx(ratios, abs=1 / 2000)
    with pytest.raises(ValueError, match="ratios must be between 0 and 1"):
        bearing_curve(surface, [1.5])


def test_surface_parameters_scale_with_size_and_are_invariant_under_rotation():
    surface = gaussian_surface()
    original_parameters = surface_parameters(surface)
    scaled_parameters = surface_parameters(Surface(1e-3 * surface.heights, spacing=(0.5e-3, 0.25e-3)))
    for name, power in {
        "Sq": 1,
        "Sz": 1,
        "Ssk": 0,
        "Sdq": 0,
        "Sdr": 0,
        "Sal": 1,
        "Str": 0,
        "Std": 0,
        "Sk": 1,
        "Smr1": 0,
    }.items():
        assert getattr(scaled_parameters, name) == pytest.approx(
            getattr(original_parameters, name) * 1e-3**power, rel=1e-9, nan_ok=True
        ), name
    rotated_parameters = surface_parameters(Surface(surface.heights.T, spacing=(0.25, 0.5)))
    for name in ("Sq", "Sdq", "Sdr", "Sal", "Sk", "Svk"):
        assert getattr(rotated_parameters, name) == pytest.approx(getattr(original_parameters, name), rel=1e-9), name
    flipped_parameters = surface_parameters(Surface(-surface.heights, spacing=surface.spacing))
    assert (flipped_parameters.Spk, flipped_parameters.Ssk, flipped_parameters.Smr1) == pytest.approx(
        (original_parameters.Svk, -original_parameters.Ssk, 1 - original_parameters.Smr2), rel=1e-6
    )


def test_surface_parameters_agree_with_the_surfacetopography_library():
    topography = pytest.importorskip("SurfaceTopography")
    surface = gaussian_surface()
    (dy, dx), (rows, columns) = surface.spacing, surface.heights.shape
    topography_surface = topography.Topography(
        surface.heights.T - surface.heights.mean(), (columns * dx, rows * dy), periodic=False
    )
    result = surface_parameters(surface, derivative="neighbours")
    assert result.Sq == pytest.approx(np.sqrt(np.mean(topography_surface.heights() ** 2)), rel=ROUND_OFF)
    # SurfaceTopography uses triangles. Each mesh has slopes along x and y on both sides.
    assert result.Sdq == pytest.approx(topography_surface.rms_gradient(), rel=0.01)


@pytest.mark.parametrize(
    ("surface", "options", "message"),
    [
        (Surface(np.ones((9, 9)), spacing=1.0), {}, "surface must not be flat"),
        (Surface(np.eye(6), spacing=1.0), {}, "at least 7 rows and 7 columns"),
        (Surface(np.eye(9), spacing=1.0), {"derivative": "spline"}, "derivative must be one of"),
    ],
)
def test_surface_parameters_reject_invalid_arguments(surface, options, message):
    with pytest.raises(ValueError, match=message):
        surface_parameters(surface, **options)
