"""Tests of results as functions of the cutoff: comparison with the half-space, effect of a hardness, limits and
intervals."""

import math

import numpy as np
import pytest
import xarray as xr
from stiction import (
    Profile,
    Surface,
    cut_off,
    half_space,
    resolution,
    resolution_friction,
    scale_dependent_roughness,
    self_affine,
)
from stiction._errors import NoSolutionError
from stiction.mechanics.brackets import (
    friction_range_for_finer_scans,
    kappa_uncertainty_factor,
    max_area_for_finer_scans,
    max_friction_for_finer_scans,
)
from support.rough_surfaces import rough_maps

ROUND_OFF = 1e-12
EDGE_TOLERANCE = 0.1  # relative error of the area due to cells at contact edges on a coarse grid
STEEL_ARGUMENTS = {"hardness": 4.0, "effective_modulus": 115.0, "mu0": 0.2, "tau0": 0.2}


def create_rough_surfaces(hurst=0.8, points=128, spacing=0.04, rms=0.03, seed=5, shortest=None):
    wavelengths = {"longest_wavelength": points * spacing / 4, "shortest_wavelength": shortest}
    return rough_maps(seed, hurst_exponent=hurst, rms=rms, points=points, spacing=spacing, **wavelengths)


@pytest.fixture(scope="module")
def pair_and_resolution_result():
    """Return a pair under 20 MPa, with its results at its own resolution and at coarser resolutions."""
    upper, lower = create_rough_surfaces()
    load = 0.02 * 128**2 * 0.04**2
    lengths = [0.16, 0.32, 0.64]
    return (
        upper,
        lower,
        load,
        resolution(upper, lower, [load], cut_offs=lengths, boundary="periodic", **STEEL_ARGUMENTS),
    )


def test_results_at_each_cutoff_equal_half_space_solutions_of_filtered_surfaces(pair_and_resolution_result):
    upper, lower, load, result = pair_and_resolution_result
    for cutoff in result.cut_off.values:
        bodies = [cut_off(body, cutoff, periodic=True) if cutoff else body for body in (upper, lower)]
        for sliding in ("all", "opposing"):
            curve = half_space(
                *bodies, [load], effective_modulus=115.0, hardness=4.0, boundary="periodic", sliding=sliding,
                direction=[0.0, 90.0, 180.0, 270.0],
            )  # fmt: skip
            point = result.sel(cut_off=cutoff, normal_load=load)
            assert float(point.contact_area) == curve.contact_area[0]
            assert float(point.contact_count) == curve.contact_count[0]
            assert float(point.load_fraction_at_hardness) == curve.load_share_at_hardness[0]
            assert float(point.mean_pressure) == pytest.approx(load / curve.contact_area[0], rel=ROUND_OFF)
            normal, tangential = (
                getattr(curve, name)(mu0=0.2, tau0=0.2).mean() for name in ("normal_load", "tangential_load")
            )
            mu = float(point.friction_coefficient.sel(sliding=sliding))
            assert mu == pytest.approx(tangential / normal, rel=ROUND_OFF)
    recomputed_friction = resolution_friction(result, mu0=0.2, tau0=0.2)
    assert np.array_equal(recomputed_friction, result.friction_coefficient)
    elastic_friction = resolution_friction(result, mu0=0.0)
    assert abs(elastic_friction.sel(sliding="all")).max() < 0.02  # Elastic forces uphill and downhill cancel.


def test_results_at_a_shorter_cutoff_lie_between_plastic_limit_and_results_at_longer_cutoffs(
    pair_and_resolution_result,
):
    *_, load, result = pair_and_resolution_result
    area = result.contact_area_fraction[:, 0].values
    mu = result.friction_coefficient.sel(sliding="all")[:, 0].values
    assert result.load_fraction_at_hardness[0, 0] > 0.8
    assert np.abs(mu / mu[0] - 1).max() < 0.03
    assert np.abs(area / area[0] - 1).max() < 0.25
    min_area_fraction, min_friction = (
        float(result.plastic_area_fraction[0]),
        float(result.plastic_friction_coefficient[0]),
    )
    assert min_area_fraction == pytest.approx(load / 4.0 / (128 * 0.04) ** 2, rel=ROUND_OFF)
    assert min_friction == pytest.approx(0.2 + 0.2 / 4.0, rel=ROUND_OFF)
    for finer_index in range(area.size):
        assert (area[finer_index] >= min_area_fraction * (1 - EDGE_TOLERANCE)).all()
        assert (area[finer_index] <= area[finer_index:] * (1 + EDGE_TOLERANCE)).all()
        assert (mu[finer_index] >= min_friction * (1 - 0.02)).all()
        assert (mu[finer_index] <= mu[finer_index:] * (1 + 0.02)).all()


def test_friction_range_for_finer_scans_at_each_cutoff_contains_results_at_shorter_cutoffs(pair_and_resolution_result):
    result = pair_and_resolution_result[3]
    second_order_factor = 1 + np.square(result.rms_gradient.values) / 8
    for name, variable in (
        ("area_fraction", "contact_area_fraction"),
        ("friction_coefficient", "friction_coefficient"),
    ):
        values = result[variable].sel(sliding="all") if "sliding" in result[variable].dims else result[variable]
        ends = result[f"bracket_{name}"][:, 0].values
        assert ends[:, 0] == pytest.approx(float(result[f"plastic_{name}"][0]), rel=ROUND_OFF)
        for finer_index in range(ends.shape[0]):
            assert (values[finer_index, 0].values <= ends[finer_index:, 1] * second_order_factor[finer_index]).all()
    # The upper limit allows the area above the plastic limit to grow by the square of two standard deviations of κ.
    # The largest area fraction of an elastic scan is one.
    count, min_area_fraction = result.contact_count[:, 0].values, float(result.plastic_area_fraction[0])
    area_above_limit = result.contact_area_fraction[:, 0].values - min_area_fraction
    assert result.bracket_area_fraction[:, 0, 1].values == pytest.approx(
        min_area_fraction + area_above_limit * kappa_uncertainty_factor(count) ** 2
    )
    assert float(max_area_for_finer_scans(100.0, 1.0, 1000)) == pytest.approx(100 * math.exp(0.1))
    assert float(max_area_for_finer_scans(0.9, 1.0, 1000)) == 1.0


def test_upper_limit_of_the_friction_range_for_finer_scans_equals_the_separately_computed_maximum():
    mu0, adhesion, value = (
        np.array([0.1, 0.2, 0.2, 0.3]),
        np.array([0.05, 0.02, 0.0, 0.1]),
        np.array([0.3, 0.6, 0.2, 0.35]),
    )
    max_values = [
        friction_range_for_finer_scans(*sample, contact_count=38.0)[1]
        for sample in zip(value, mu0, adhesion, strict=True)
    ]
    assert max_friction_for_finer_scans(value, mu0, adhesion, 38.0) == pytest.approx(max_values)
    # The real area is far above F/H in the first two samples, so that their adhesive friction grows by `kappa_factor`.
    kappa_factor = float(kappa_uncertainty_factor(np.array(38.0)))
    assert max_values[:2] == pytest.approx((mu0 + kappa_factor * (value - mu0))[:2])
    assert max_values[2] == value[2]


def test_friction_range_for_finer_scans_allows_for_a_larger_contact_area_if_contacts_are_few():
    """Use a pair of seven contacts whose finest result has more area than a coarser result."""
    bodies = rough_maps(
        28, rms=0.01, points=256, spacing=0.01, repetition=2004, longest_wavelength=0.64, shortest_wavelength=0.04
    )
    gap = Surface(bodies[0].heights - bodies[1].heights, spacing=0.01)
    factor = 0.25 / float(scale_dependent_roughness(gap, periodic=True).gradient[-1])
    scaled_surfaces = [Surface(factor * body.heights, spacing=0.01) for body in bodies]
    result = resolution(*scaled_surfaces, [0.02 * 2.56**2], cut_offs=[0.08], boundary="periodic", **STEEL_ARGUMENTS)
    area = result.contact_area_fraction[:, 0].values
    assert area[0] > 1.02 * area[1]
    assert area[0] < float(result.bracket_area_fraction[1, 0].sel(end="upper"))


def test_yielding_wavelengths_are_tabulated_for_several_hardnesses_if_hardness_is_none(pair_and_resolution_result):
    upper, lower, load, resolution_result = pair_and_resolution_result
    result = resolution(
        upper, lower, [load], hardness=None, cut_offs=[0.32], boundary="periodic", effective_modulus=115.0
    )
    assert "friction_coefficient" not in result
    assert "plastic_area" not in result
    assert math.isnan(result.attrs["hardness_GPa"])
    assert result.model == "elastic half-space"
    assert result.contact_area[0, 0] < result.contact_area[1, 0]
    assert result.hardness.size > 3
    lengths = result.plastic_wavelength[:, 0].sel(statistic="value").values
    assert (np.diff(lengths) <= 0).all()
    wavelength_at_4_gpa = float(resolution_result.plastic_wavelength.sel(statistic="value")[0, 0])
    wavelength_at_5_gpa, wavelength_at_2_gpa = (
        float(result.plastic_wavelength.sel(hardness=h, statistic="value")[0]) for h in (5.0, 2.0)
    )
    assert wavelength_at_5_gpa < wavelength_at_4_gpa < wavelength_at_2_gpa


def test_rms_slope_at_the_longest_yielding_wavelength_corresponds_to_the_hardness(pair_and_resolution_result):
    upper, lower, load, result = pair_and_resolution_result
    kappa = float(result.elastic_kappa[0])
    assert kappa == pytest.approx(
        float(result.elastic_area_fraction[0]) * 115.0 * float(result.rms_gradient[0]) / (load / (128 * 0.04) ** 2)
    )
    gap = Surface(upper.heights - lower.heights, spacing=upper.spacing)
    roughness = scale_dependent_roughness(gap, periodic=True)
    value, lower_wavelength, upper_wavelength = result.plastic_wavelength[0, 0].values
    assert lower_wavelength <= value <= upper_wavelength
    assert float(roughness.gradient_at(value)) == pytest.approx(kappa * 4.0 / 115.0, rel=1e-6)
    # κ agrees only within a factor, because the pair has few contacts.
    curve = half_space(upper, lower, [load], effective_modulus=115.0, boundary="periodic")
    kappa_factor = float(kappa_uncertainty_factor(curve.contact_count)[0])
    assert 1.1 <= kappa_factor <= math.exp(1)
    assert float(roughness.gradient_at(upper_wavelength)) == pytest.approx(kappa * 4.0 / 115.0 / kappa_factor, rel=1e-6)


def test_extrapolated_slope_of_a_filtered_scan_agrees_with_the_unfiltered_scan():
    """Compare the extrapolation of a filtered scan with the unfiltered scan."""
    upper, lower = create_rough_surfaces(points=256, spacing=0.02)
    coarse_surfaces = [Surface(cut_off(body, 0.16, periodic=True).heights, spacing=0.02) for body in (upper, lower)]
    load = [0.02 * (256 * 0.02) ** 2]
    options = {"boundary": "periodic", "effective_modulus": 115.0, "mu0": 0.2, "tau0": 0.2, "cut_offs": []}
    fine_result = resolution(upper, lower, load, hardness=None, **options)
    result = resolution(*coarse_surfaces, load, hardness=None, **options)
    assert result.finer_wavelength[0] == 0.04
    assert result.continued_rms_gradient.sel(statistic="value")[0] == pytest.approx(
        float(result.rms_gradient[0]), rel=0.3
    )
    gradient = result.continued_rms_gradient.sel(finer_wavelength=0.04)
    assert gradient.sel(statistic="lower") <= gradient.sel(statistic="value") <= gradient.sel(statistic="upper")
    area = result.continued_elastic_area_fraction.sel(finer_wavelength=0.01)[0]
    assert area.sel(statistic="lower") < area.sel(statistic="value") < area.sel(statistic="upper")
    mu = result.continued_elastic_friction_coefficient
    assert (result.continued_rms_gradient.diff("finer_wavelength") >= 0).all()
    assert mu.min() > 0.2
    assert float(fine_result.friction_coefficient.sel(sliding="all")[0, 0]) > 0.2


def test_friction_interval_extrapolated_from_a_coarse_scan_contains_friction_of_a_finer_scan():
    """Extrapolate pairs that are filtered at 16 points, and compare them with the unfiltered pairs."""
    num_contained = 0
    for seed in range(6):
        surface_options = {
            "hurst_exponent": 0.6,
            "rms": 0.02,
            "shape": (256, 256),
            "spacing": 0.02,
            "shortest_wavelength": 0.08,
        }
        fine_surfaces = rough_maps(seed, **surface_options)
        coarse_surfaces = []
        for body in fine_surfaces:
            fourier_coefficients = np.fft.fft2(body.heights)
            k = np.hypot(*np.meshgrid(*[np.fft.fftfreq(256, 0.02)] * 2, indexing="ij"))
            coarse_surfaces.append(
                Surface(np.fft.ifft2(np.where(k <= 1 / 0.32, fourier_coefficients, 0)).real[::2, ::2], spacing=0.04)
            )
        load = [0.2 * 5.12**2]
        options = {"effective_modulus": 115.0, "mu0": 0.2, "tau0": 0.2, "boundary": "periodic", "cut_offs": []}
        result = resolution(*coarse_surfaces, load, hardness=None, **options)
        estimate = result.continued_elastic_friction_coefficient.sel(finer_wavelength=0.08)[0]
        finer_result = resolution(*fine_surfaces, load, hardness=None, **options).friction_coefficient.sel(
            sliding="all"
        )[0, 0]
        num_contained += bool(estimate.sel(statistic="lower") <= finer_result <= estimate.sel(statistic="upper"))
    assert num_contained >= 5  # at a coverage of 95 %, the probability of at least two misses is 1 in 30


def test_friction_of_profiles_at_each_cutoff_is_the_mean_over_both_directions():
    upper, lower = (
        self_affine(2, hurst_exponent=0.8, rms=0.02, points=1024, spacing=0.01, longest_wavelength=2.0, side=side)
        for side in ("upper", "lower")
    )
    result = resolution(upper, lower, [0.02, 0.1], hardness=4.0, effective_modulus=100.0, mu0=0.3)
    assert result.cut_off.values == pytest.approx([0.0, 0.04, 0.08, 0.16, 0.32])
    assert result.sizes["normal_load"] == 2
    curve = half_space(upper, lower, [0.02, 0.1], hardness=4.0, effective_modulus=100.0)
    curves_of_directions = [curve.with_direction(direction) for direction in ("+x", "-x")]
    normal = sum(item.normal_load(mu0=0.3) for item in curves_of_directions)
    mu = sum(item.tangential_load(mu0=0.3) for item in curves_of_directions) / normal
    assert result.friction_coefficient.sel(sliding="opposing")[0].values == pytest.approx(mu, rel=1e-6)


def test_results_of_the_resolution_function_scale_with_size():
    original_result = resolution(
        *create_rough_surfaces(points=64, spacing=0.08), [0.4], boundary="periodic", **STEEL_ARGUMENTS
    )
    bodies = [Surface(10 * body.heights, spacing=0.8) for body in create_rough_surfaces(points=64, spacing=0.08)]
    enlarged_result = resolution(*bodies, [40.0], boundary="periodic", **STEEL_ARGUMENTS)
    for name in ("contact_area_fraction", "friction_coefficient", "rms_gradient", "plastic_area_fraction"):
        assert enlarged_result[name].values == pytest.approx(original_result[name].values, rel=1e-6)
    assert enlarged_result.plastic_wavelength.values == pytest.approx(
        10 * original_result.plastic_wavelength.values, rel=1e-3
    )


def test_resolution_dataset_has_units_and_can_be_written_to_netcdf(pair_and_resolution_result, tmp_path):
    result = pair_and_resolution_result[3]
    assert (result.instrument_limit_um, result.instrument_limit_reason) == (0.08, "pixels")
    for name, values in result.data_vars.items():
        assert values.attrs["units"], name
        assert values.attrs["long_name"], name
    for name in ("cut_off", "normal_load", "hardness", "finer_wavelength"):
        assert result[name].attrs["units"] in ("µm", "mN", "GPa")
    result.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as stored_dataset:
        xr.testing.assert_equal(stored_dataset.load(), result)


def test_resolution_function_returns_nan_at_an_unsolved_load_and_completes_the_progress(monkeypatch):
    from stiction.mechanics import resolution as module

    upper, lower = create_rough_surfaces(points=32, spacing=0.16)
    original_half_space = module.half_space

    def failing_half_space(upper, lower, loads, **options):
        if max(loads) > 1:
            raise NoSolutionError("no solution")
        return original_half_space(upper, lower, loads, **options)

    monkeypatch.setattr(module, "half_space", failing_half_space)
    reported_progress = []
    result = resolution(
        upper, lower, [0.5, 2.0], boundary="periodic", cut_offs=[0.64],
        progress=lambda num_done, count: reported_progress.append((num_done, count)), **STEEL_ARGUMENTS,
    )  # fmt: skip
    assert reported_progress == [(0, 3), (1, 3), (2, 3), (3, 3)]
    assert np.isfinite(result.contact_area[:, 0]).all()
    assert np.isnan(result.contact_area[:, 1]).all()
    assert np.isnan(result.friction_coefficient[..., 1]).all()
    assert np.isnan(result.plastic_wavelength[:, 1]).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"hardness": 0.0}, "hardness must be a finite number above 0 GPa"),
        (
            {"cut_offs": [0.1]},
            r"cut_offs must be 0, or between 0.32 µm \(two grid spacings\) and .* \(a third of the shortest side\)",
        ),
        ({"cut_offs": [3.0]}, "cut_offs must be 0, or"),
        ({"mu0": -0.1}, "mu0 must not be negative"),
        ({"mu0": 0.1, "tau0": "1 MPa"}, "tau0 must be a finite number"),
        ({"loads": [2.0, 1.0]}, "loads must be above 0 mN and strictly increasing"),
        ({"loads": [1e9]}, r"loads must be below \S+ mN, the hardness times the nominal area"),
        ({"upper": Profile(np.zeros(9), spacing=1.0)}, "must both be profiles or both surfaces"),
        ({"boundary": "open"}, "boundary must be one of"),
        ({"direction": 1j}, "direction must be"),
    ],
)
def test_resolution_function_rejects_invalid_arguments(changes, message):
    upper, lower = create_rough_surfaces(points=32, spacing=0.16)
    arguments = {"upper": upper, "lower": lower, "loads": [0.5], "hardness": 4.0} | changes
    with pytest.raises(ValueError, match=message):
        resolution(arguments.pop("upper"), arguments.pop("lower"), arguments.pop("loads"), **arguments)
