"""Tests of direct shear tests against closed forms: sawtooth, energy balance, perfect fit, mirror symmetry."""

import math
from dataclasses import replace

import numpy as np
import pytest
from stiction import (
    Profile,
    Surface,
    flipped,
    half_space,
    interface,
    levelled,
    rotated,
    self_affine_surface,
    shear_gap,
    shear_test,
)
from stiction.evaluate.shear_intervals import ShearInputSamples, add_shear_intervals
from stiction.mechanics.joint_closure import fit_bandis_law
from stiction.summary.interface_caveats import find_interface_caveats
from stiction.views.shear import headline_estimates, list_caveats

TOOTH_ANGLE = math.radians(10)
ROUND_OFF = 1e-12  # µm
STRESS_STEP = 1e-3
# Closures have a relative tolerance of about 1e-6 over a step of 2e-3; few contacts appear within the step.
DERIVATIVE_TOLERANCE = 0.02
LOAD_AND_MODULUS = {"load": "1 MPa", "effective_modulus": "30 GPa"}


def create_sawtooth(points_per_tooth, teeth=2):
    x = np.arange(teeth * points_per_tooth) / points_per_tooth
    height = np.tan(TOOTH_ANGLE) * 100 * (0.5 - np.abs(x % 1 - 0.5))  # each tooth is 100 µm long
    return Profile(height, spacing=100 / points_per_tooth)


def create_wavy_profile():
    x = 2 * np.pi * np.arange(2048) / 2048
    return Profile(2 * np.cos(x) + 0.5 * np.cos(5 * x + 1) + 0.1 * np.cos(17 * x + 2), spacing=100 / 2048)


def create_rough_map(points=64):
    return self_affine_surface(
        5, side="lower", hurst_exponent=0.8, rms=6.0, shape=(points, points), spacing=1000 / points,
        shortest_wavelength=8000 / points,
    )  # fmt: skip


def create_noise(shape):
    return np.random.default_rng(3).normal(0, 0.05, shape)


def create_mate(face):
    """Return the face that fits onto another face, in the orientation in which it would be scanned."""
    return face.changed(flipped(face).heights, "mate")


def run_shear_test(face, **options):
    return shear_test(create_mate(face), face, level="none", **LOAD_AND_MODULUS | options)


def integrate_work(result):
    """Return the work (nJ) of the tangential load, of dilation and of elastic deformation since the second step."""
    force = (result.shear_stress * result.overlap_area).values[1:]
    work = np.sum((force[1:] + force[:-1]) / 2 * np.diff(result.displacement.values[1:]))
    dilation, energy = (float(result[name][-1] - result[name][1]) for name in ("dilation", "elastic_energy"))
    return work, float(result.normal_load[0]) * dilation, energy


# ---- Sawtooth --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("mu0", [0.0, 0.5])
def test_friction_of_a_sawtooth_is_the_tangent_of_friction_angle_plus_tooth_angle(boundary, mu0):
    result = run_shear_test(create_sawtooth(12800), path="20 um", steps=4, mu0=mu0, boundary=boundary)
    exact_coefficient = math.tan(math.atan(mu0) + TOOTH_ANGLE)
    assert result.friction_coefficient[0] == pytest.approx(mu0, abs=1e-3)
    np.testing.assert_allclose(result.friction_coefficient[1:], exact_coefficient, rtol=0.01)
    np.testing.assert_allclose(result.dilation[1:], math.tan(TOOTH_ANGLE) * result.displacement[1:], rtol=0.01)
    assert result.attrs["peak_dilation_angle_deg"] == pytest.approx(10, abs=0.1)


def test_coarsely_sampled_sawtooth_has_the_friction_of_a_sawtooth_with_rounded_tips():
    result = run_shear_test(create_sawtooth(200), path="25 um", steps=5, mu0=0.5, boundary="periodic")
    assert result.friction_coefficient[[0, 1, 5]].values == pytest.approx([0.500, 0.727, 0.722], abs=1e-3)
    smooth_result = run_shear_test(create_sawtooth(200), path="5 um", steps=1, mu0=0, boundary="periodic")
    assert smooth_result.friction_coefficient[1] == pytest.approx(0.167, abs=1e-3)


def test_sawtooth_slides_downhill_after_the_tips_have_passed_each_other():
    result = run_shear_test(create_sawtooth(400), path="60 um", steps=12, mu0=0.05, boundary="periodic")
    assert result.status.values[-1] == "downhill"
    assert np.isnan(result.friction_coefficient[-1])
    assert np.isnan(result.attrs["end"])
    assert result.shear_stress[-1] < 0
    assert result.attrs["peak"] > 0.2


def test_sawtooth_faces_with_steep_teeth_lock():
    x = np.arange(512) / 512
    steep_face = Profile(100 * np.abs(x % 0.25 - 0.125), spacing=100 / 512)
    result = run_shear_test(steep_face, path="5 um", steps=2, mu0=1.5, boundary="periodic")
    assert list(result.status.values) == ["ok", "self-locked", "self-locked"]
    assert result.attrs["peak_status"] == "self-locked"
    assert np.isnan(result.attrs["peak"])


# ---- Energy ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_work_of_frictionless_shear_of_profiles_is_dilation_work_plus_elastic_energy(boundary):
    result = run_shear_test(create_wavy_profile(), path="30 um", steps=120, mu0=0, load="10 MPa", boundary=boundary)
    work, dilation_work, energy = integrate_work(result)
    assert work > 0
    assert work == pytest.approx(dilation_work + energy, rel=0.01)


@pytest.mark.parametrize("angle", [0, 90, 225])
def test_work_of_frictionless_shear_of_maps_is_dilation_work_plus_elastic_energy(angle):
    result = run_shear_test(create_rough_map(), path="300 um", steps=20, mu0=0, direction=angle, boundary="periodic")
    work, dilation_work, energy = integrate_work(result)
    assert work == pytest.approx(
        dilation_work + energy, abs=0.01 * float(result.normal_load[0] * result.dilation.max())
    )


def test_work_of_frictionless_shear_over_a_climbing_edge_is_dilation_work_plus_elastic_energy():
    x = np.linspace(-1, 1, 401)
    bowl = Profile(4 * x**2, spacing=0.25)
    result = run_shear_test(bowl, path="30 um", steps=60, mu0=0)
    assert result.load_fraction_at_edges[-1] > 0.3
    work, dilation_work, energy = integrate_work(result)
    assert work == pytest.approx(dilation_work + energy, rel=0.03)


# ---- Perfect fit and symmetry ----------------------------------------------------------------------------------------


def test_shear_test_of_perfectly_mated_faces_starts_in_complete_contact():
    result = run_shear_test(create_rough_map(), path="100 um", steps=2, mu0=0.6, tau0="1 MPa", boundary="periodic")
    assert result.contact_area_fraction[0] == pytest.approx(1.0)
    # The coefficient is mu0 plus the ratio of tau0 to the nominal pressure.
    assert result.friction_coefficient[0] == pytest.approx(0.6 + 1.0, rel=0.01)
    assert result.dilation[0] == 0
    assert result.contact_area_fraction[1] < 0.2


def test_mirrored_faces_have_the_same_shear_curve_in_the_opposite_direction():
    face = create_rough_map()
    mirrored_face = Surface(face.heights[:, ::-1], spacing=face.spacing)
    options = {"path": "150 um", "steps": 5, "mu0": 0.6, "hardness": "200 MPa"}
    forward_result, backward_result = (
        run_shear_test(face, direction=0, **options),
        run_shear_test(mirrored_face, direction=180, **options),
    )
    for name in ("friction_coefficient", "dilation", "contact_area_fraction", "overlap_area"):
        np.testing.assert_allclose(forward_result[name], backward_result[name], rtol=1e-4, atol=1e-6)
    assert not np.allclose(
        forward_result.friction_coefficient, run_shear_test(face, direction=180, **options).friction_coefficient
    )


def test_map_of_equal_rows_has_the_shear_curve_of_its_profile():
    """Compare coefficients: on a rigid-like map the rows touch at the same points as the profile."""
    profile = create_wavy_profile()
    coarse_profile = Profile(profile.heights[::16], spacing=profile.spacing * 16)
    surface = Surface(np.tile(coarse_profile.heights, (16, 1)), spacing=coarse_profile.spacing)
    options = {"path": "20 um", "steps": 5, "mu0": 0.4, "boundary": "periodic"}
    np.testing.assert_allclose(
        run_shear_test(surface, **options).friction_coefficient,
        run_shear_test(coarse_profile, **options).friction_coefficient,
        rtol=1e-3,
    )


# ---- Loads -----------------------------------------------------------------------------------------------------------


def test_normal_load_of_a_shear_test_is_constant_although_friction_has_a_vertical_part():
    result = run_shear_test(create_rough_map(), path="200 um", steps=4, mu0=0.6, tau0="2 MPa", hardness="200 MPa")
    np.testing.assert_allclose(result.normal_load, 1000.0, rtol=1.1e-4)
    np.testing.assert_allclose(
        result.friction_coefficient, result.shear_stress * result.overlap_area / result.normal_load, rtol=1e-12
    )


def test_normal_load_of_a_shear_test_grows_with_dilation_if_a_normal_stiffness_is_given():
    result = run_shear_test(create_rough_map(), path="200 um", steps=4, mu0=0.6, normal_stiffness="50 MPa/mm")
    area = float(result.overlap_area[0])
    np.testing.assert_allclose(result.normal_load, 1000.0 + 5e-5 * area * result.dilation, rtol=1e-4)
    assert result.normal_load[-1] > 1.2 * result.normal_load[0]


def test_shear_test_loses_contact_if_the_normal_stiffness_unloads_contracting_faces():
    x = 2 * np.pi * np.arange(256) / 256
    wave = Profile(5 * np.cos(x), spacing=1.0)
    opposite_face = create_mate(Profile(-wave.heights, spacing=1.0))  # at the start, crests are in contact with crests
    result = shear_test(
        opposite_face, wave, path="100 um", steps=4, mu0=0.3, normal_stiffness="10 GPa/mm", boundary="periodic",
        **LOAD_AND_MODULUS,
    )  # fmt: skip
    assert result.status.values[-1] == "no-contact"
    assert np.isnan(result.friction_coefficient[-1])


def test_shear_test_of_faces_that_lock_at_the_start_solves_later_displacements():
    x = np.arange(201.0)
    ramp = Profile(np.clip(1.2 * (x - 60), 0, 120), spacing=1.0)  # this ramp locks if mu0 exceeds 0.83
    pin = Profile(80 * np.exp(-(((x - 100) / 20) ** 2)), spacing=1.0)
    options = {"path": "100 um", "steps": 5, "mu0": 1.5, "level": "none", "load": "1 kPa", "effective_modulus": 30.0}
    result = shear_test(pin, ramp, **options)
    assert result.status[0] == "self-locked"
    assert result.status[-1] == "ok"
    stiff_test = shear_test(pin, ramp, normal_stiffness="1 kPa/mm", **options)
    assert (stiff_test.status[1:] == "not-solved").all()  # no height at the start, so the load is unknown


def test_shear_test_of_perfectly_mated_faces_starts_without_shear_force_at_zero_friction():
    result = run_shear_test(create_wavy_profile(), path="5 um", steps=1, mu0=0, boundary="periodic")
    assert result.friction_coefficient[0] == 0
    assert result.status[0] == "ok"


def test_shear_test_has_at_most_one_step_per_grid_point():
    result = run_shear_test(create_wavy_profile(), path="0.2 um", steps=10**11, mu0=0.3)
    np.testing.assert_allclose(np.diff(result.displacement), 100 / 2048)


def test_hardness_limits_the_peak_and_the_dilation_of_a_sawtooth():
    options = {"path": "100 um", "steps": 5, "mu0": 0.6, "boundary": "periodic"}
    soft_result, hard_result = (
        run_shear_test(create_rough_map(), hardness=value, **options) for value in ("20 MPa", "2 GPa")
    )
    assert soft_result.attrs["peak"] < hard_result.attrs["peak"]
    assert soft_result.dilation[-1] < hard_result.dilation[-1]
    assert soft_result.load_fraction_at_hardness[-1] > 0.5


def test_free_tilt_changes_the_dilation_of_a_sheared_wedge():
    x = np.linspace(-1, 1, 401)
    wedge = Profile(20 * np.maximum(x, 0), spacing=0.25)
    fixed_tilt_result, free_tilt_result = (
        run_shear_test(wedge, path="10 um", steps=2, mu0=0.3, tilt=tilt) for tilt in ("fixed", "free")
    )
    assert (free_tilt_result.status == "ok").all()
    assert not np.allclose(fixed_tilt_result.dilation, free_tilt_result.dilation)


# ---- Intervals -------------------------------------------------------------------------------------------------------


def test_shear_interval_lies_between_curves_at_the_limits_of_mu0_and_tau0():
    options = {"path": "100 um", "steps": 2, "boundary": "periodic"}
    result = run_shear_test(create_rough_map(), mu0="0.5..0.7", tau0="0..1 MPa", **options)
    ends = [
        run_shear_test(create_rough_map(), mu0=mu0, tau0=tau0, **options) for mu0, tau0 in ((0.5, 0), (0.7, "1 MPa"))
    ]
    lower, upper = result.friction_coefficient_interval.values
    assert (lower < result.friction_coefficient).all()
    assert (upper > result.friction_coefficient).all()
    assert (lower > ends[0].friction_coefficient - 1e-3).all()
    assert (upper < ends[1].friction_coefficient + 1e-3).all()
    assert result.attrs["peak_lower"] < result.attrs["peak"] < result.attrs["peak_upper"]
    assert result.attrs["end_lower"] < result.attrs["end"] < result.attrs["end_upper"]


def test_shear_interval_has_no_upper_limit_if_more_than_2_5_percent_of_the_samples_lock():
    # Teeth of 45 degrees lock for mu0 of 1 or more, a quarter of the range.
    x = np.arange(400) / 200
    teeth = Profile(100 * (0.5 - np.abs(x % 1 - 0.5)), spacing=0.5)
    result = run_shear_test(
        teeth, path="20 um", steps=2, mu0="uniform 0.2..1.3", boundary="periodic", effective_modulus=1e4
    )
    lower, upper = result.friction_coefficient_interval.values[:, 1]
    assert 1 < lower < 2
    assert upper == np.inf
    assert result.attrs["peak_upper"] == np.inf


def test_limits_of_the_shear_peak_interval_are_the_peaks_at_the_lowest_and_highest_hardness():
    options = {"path": "100 um", "steps": 4, "mu0": 0.6, "boundary": "periodic"}
    result = run_shear_test(create_rough_map(), hardness="50..400 MPa", **options)
    soft_result, hard_result = (
        run_shear_test(create_rough_map(), hardness=value, **options) for value in ("50 MPa", "400 MPa")
    )
    for name in ("peak", "end", "peak_shear_stress_GPa"):
        assert result.attrs[f"{name}_lower"] == pytest.approx(soft_result.attrs[name], rel=0.01)
        assert result.attrs[f"{name}_upper"] == pytest.approx(hard_result.attrs[name], rel=0.01)
    np.testing.assert_allclose(result.dilation_interval[0], soft_result.dilation, rtol=0.01, atol=1e-3)
    angles = sorted(shear_result.attrs["peak_dilation_angle_deg"] for shear_result in (soft_result, hard_result))
    assert result.attrs["peak_dilation_angle_deg_lower"] == pytest.approx(angles[0], abs=0.3)
    assert result.attrs["peak_dilation_angle_deg_upper"] == pytest.approx(angles[1], abs=0.3)
    assert result.attrs["uncertain_inputs"] == "the hardness"


def test_shear_interval_for_two_uncertain_moduli_lies_between_results_for_the_range_limits():
    options = {"path": "50 um", "steps": 1, "mu0": 0.6, "effective_modulus": None, "poisson": 0.25}
    result = run_shear_test(create_rough_map(), young="10..40 GPa", boundary="periodic", **options)
    coefficient_at_lower_limit, coefficient_at_upper_limit = (
        float(run_shear_test(create_rough_map(), young=young, boundary="periodic", **options).friction_coefficient[1])
        for young in ("10 GPa", "40 GPa")
    )
    lower, upper = result.friction_coefficient_interval.values[:, 1]
    assert (
        coefficient_at_lower_limit < lower < float(result.friction_coefficient[1]) < upper < coefficient_at_upper_limit
    )


def test_shear_intervals_from_few_and_many_displacements_are_equal():
    """Compare intervals with fewer samples, which limit the memory, with those of the usual number."""
    wavy_profile = create_wavy_profile()
    face = Profile(wavy_profile.heights[::8], spacing=8 * wavy_profile.spacing)
    options = {"path": "80 um", "mu0": "0.5..0.7", "load": "10 MPa", "hardness": "2 GPa", "boundary": "periodic"}
    fine_result, coarse_result = (run_shear_test(face, steps=steps, **options) for steps in (200, 4))
    assert fine_result.sizes["displacement"] > 128
    limits = fine_result.friction_coefficient_interval.sel(
        displacement=coarse_result.displacement, method="nearest"
    ).values
    np.testing.assert_allclose(limits, coarse_result.friction_coefficient_interval.values, rtol=0.01)


def test_two_uncertain_inputs_widen_the_interval_of_a_shear_test():
    options = {"path": "100 um", "steps": 2, "boundary": "periodic"}
    widths = [
        run_shear_test(create_rough_map(), mu0=mu0, hardness=hardness, **options).attrs
        for mu0, hardness in ((0.6, "100..300 MPa"), ("0.5..0.7", "173 MPa"), ("0.5..0.7", "100..300 MPa"))
    ]
    width_due_to_hardness, width_due_to_mu0, width_due_to_both = (
        attributes["peak_upper"] - attributes["peak_lower"] for attributes in widths
    )
    assert max(width_due_to_hardness, width_due_to_mu0) < width_due_to_both < width_due_to_hardness + width_due_to_mu0


def test_shear_interval_has_no_upper_limit_if_the_faces_lock_at_the_largest_hardness():
    face = create_rough_map()
    steep_face = Surface(6 * face.heights, spacing=face.spacing)
    options = {"path": "60 um", "steps": 2, "mu0": 2.0, "boundary": "periodic"}
    assert run_shear_test(steep_face, hardness="1 GPa", **options).attrs["peak_status"] == "self-locked"
    result = run_shear_test(steep_face, hardness="10..1000 MPa", **options)
    assert result.attrs["peak_upper"] == np.inf
    assert np.isnan(result["dilation_interval"][:, 1:]).all()
    assert 0 < result.attrs["peak_lower"] < result.attrs["peak"] < np.inf


def test_shear_test_accepts_materials_and_interfaces_like_the_pair_function():
    face = create_rough_map()
    options = {"path": "100 um", "steps": 1, "load": "1 MPa", "level": "none"}
    by_name = shear_test(create_mate(face), face, mu0=0.5, upper_material="granite", **options)
    assert by_name.attrs["hardness"] == "9.54 GPa (6.5..14 GPa)"
    assert "the hardness of the granite" in by_name.attrs["uncertain_inputs"]
    assert by_name.attrs["peak_lower"] < by_name.attrs["peak"] < by_name.attrs["peak_upper"]
    name = "MoS2 on bearing steel, dry air"
    tests = [
        shear_test(
            create_mate(face),
            face,
            interface=interface_argument,
            upper_material="bearing steel",
            hardness="9 GPa",
            **options,
        )
        for interface_argument in (name, interface(name))
    ]
    np.testing.assert_array_equal(tests[0].friction_coefficient, tests[1].friction_coefficient)
    assert tests[0].attrs["interface"] == name
    central_mu0 = float(tests[0].attrs["mu0"])
    assert central_mu0 == pytest.approx(float(np.median(interface(name).fits[0].mu0)), rel=1e-3)


def test_shear_test_finds_the_caveats_of_its_interface_once(monkeypatch, tmp_path):
    calls, film = [], interface("MoS2 on bearing steel, dry air").with_caveats("quote with care", ["a trend"])

    def count_calls(*arguments):
        calls.append(arguments)
        return find_interface_caveats(*arguments)

    monkeypatch.setattr("stiction.direct_shear.find_interface_caveats", count_calls)
    result = run_shear_test(
        create_sawtooth(1600), path="20 um", steps=1, interface=film, boundary="periodic", directory=tmp_path / "test"
    )
    assert result.attrs["interface_caveats"].startswith("interface joint samples: a trend; ")
    assert len(calls) == 1


@pytest.mark.usefixtures("all_input_samples")
def test_shear_interval_includes_a_reduced_fraction_of_samples_from_the_fit_with_zero_tau0():
    random = np.random.default_rng(2)
    film = interface("MoS2 on bearing steel, dry air")
    tau0 = 1e-9 * random.normal(2.0, 1.0, 8000)  # GPa, too small to affect the coefficient
    tau0 = tau0[tau0 > 0][:4000]
    fit = replace(film.fits[0], mu0=random.normal(0.4, 0.01, tau0.size), tau0=tau0)
    bound = replace(fit, mu0=random.normal(0.6, 0.05, tau0.size), tau0=np.zeros(tau0.size))
    film = replace(film, fits=(replace(fit, fits_at_bounds={"tau0": bound}),))
    (_, coverage) = film.sampled_fits[1]
    assert 0.1 < coverage < 0.7
    result = run_shear_test(create_sawtooth(1600), path="20 um", steps=1, interface=film, boundary="periodic", strips=0)
    # The faces fit perfectly where the path starts, so their coefficient is mu0.
    lower, upper = result["friction_coefficient_interval"].values[:, 0]
    assert lower == pytest.approx(np.quantile(fit.mu0, 0.025), rel=2e-3)
    assert upper == pytest.approx(np.quantile(bound.mu0, (1 + coverage) / 2), rel=2e-3)


def test_interval_of_the_peak_displacement_includes_the_neighbouring_steps():
    result = run_shear_test(create_rough_map(), path="200 um", steps=8, mu0="0.5..0.7", hardness="200 MPa")
    peak = int(np.argmax(result.friction_coefficient.values))
    lower, upper = (result.attrs[f"peak_displacement_um_{end}"] for end in ("lower", "upper"))
    assert lower <= float(result.displacement[peak - 1])
    assert upper >= float(result.displacement[peak + 1])


def test_dilation_and_closure_have_no_interval_if_no_uncertain_input_affects_them():
    options = {"path": "200 um", "steps": 8, "mu0": "0.58..0.62"}
    result = run_shear_test(create_rough_map(), hardness="200 MPa", **options)
    assert result.attrs["peak_lower"] < result.attrs["peak_upper"]
    assert "peak_dilation_angle_deg_lower" not in result.attrs
    assert headline_estimates(result)["dilation_angle_at_peak"].kind == ""
    by_hardness = run_shear_test(create_rough_map(), hardness="100..400 MPa", **options)
    assert by_hardness.attrs["peak_dilation_angle_deg_lower"] < by_hardness.attrs["peak_dilation_angle_deg_upper"]
    for name in ("dilation", "closure"):
        assert f"{name}_interval" not in result
    assert "dilation_interval" in by_hardness
    test = run_shear_test(create_rough_map(), **options | {"mu0": 0.6}, hardness="200 MPa")
    test["dilation"][-1] = test["closure_stiffness"][-1] = np.nan
    mu0, probabilities = np.linspace(0.58, 0.62, 64), (np.arange(64) + 0.5) / 64
    with_intervals = add_shear_intervals(test, [ShearInputSamples(mu0, np.zeros(64), {}, probabilities)], [], [])
    assert "friction_coefficient_interval" in with_intervals
    for name in ("dilation", "closure", "closure_stiffness"):
        assert f"{name}_interval" not in with_intervals


# ---- Strips ----------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("all_input_samples")
def test_scatter_between_strips_equals_scatter_between_separate_shear_tests():
    face, options = create_rough_map(128), {"path": "150 um", "steps": 3, "mu0": 0.6, "hardness": "200 MPa"}
    result = run_shear_test(face, **options)
    strips = [
        run_shear_test(Surface(face.heights[first_row : first_row + 32], spacing=face.spacing), strips=0, **options)
        for first_row in range(0, 128, 32)
    ]
    assert result.attrs["strips"] == 4
    assert all(strip.attrs["strips"] == 0 for strip in strips)
    for name in ("peak", "end", "peak_dilation_angle_deg"):
        standard_error = np.std([strip.attrs[name] for strip in strips], ddof=1) / 2
        for end, sign in (("lower", -1), ("upper", 1)):
            limit = result.attrs[name] + sign * 3.182 * standard_error  # Student's t with three degrees of freedom
            assert result.attrs[f"{name}_{end}"] == pytest.approx(limit, abs=0.02 * standard_error)


def test_interval_of_a_shear_test_contains_the_scatter_of_the_strips_that_have_a_solution():
    face, options = (
        create_rough_map(128),
        {"path": "150 um", "steps": 3, "mu0": 0.6, "hardness": "200 MPa", "strips": 0},
    )
    test_of_whole_face = run_shear_test(face, **options)
    strips = [
        run_shear_test(Surface(face.heights[first_row : first_row + 32], spacing=face.spacing), **options)
        for first_row in range(0, 128, 32)
    ]
    unsolved = strips[0].copy(deep=True)
    for name in ("shear_stress", "dilation", "normal_load"):
        unsolved[name][-1] = np.nan
    expected, result = (
        add_shear_intervals(test_of_whole_face, [], [], compared_strips)
        for compared_strips in (strips, [unsolved, *strips[1:]])
    )
    for name in ("friction_coefficient_interval", "shear_stress_interval", "dilation_interval"):
        np.testing.assert_allclose(result[name][:, :-1], expected[name][:, :-1], rtol=1e-9)
    assert test_of_whole_face["friction_coefficient"].values.argmax() < 3
    assert result.attrs["peak_upper"] == pytest.approx(expected.attrs["peak_upper"], rel=1e-9)
    coefficients = [float(strip["friction_coefficient"][-1]) for strip in strips[1:]]
    width = 2 * 4.303 * np.std(coefficients, ddof=1) / np.sqrt(3)  # Student's t with two degrees of freedom
    assert np.ptp(result["friction_coefficient_interval"].values[:, -1]) == pytest.approx(width, rel=0.02)
    only_one = add_shear_intervals(test_of_whole_face, [], [], [unsolved, unsolved, unsolved, strips[3]])
    assert np.isnan(only_one["friction_coefficient_interval"][:, -1]).all()


def test_strips_of_a_shear_test_are_parallel_to_the_motion():
    x = 2 * np.pi * np.arange(128) / 128
    ridges = Surface(np.tile(5 * np.cos(2 * x) + np.cos(9 * x + 1), (128, 1)), spacing=1000 / 128)
    options = {"path": "100 um", "steps": 2, "mu0": 0.6, "hardness": "500 MPa"}
    result_along_ridges = run_shear_test(ridges, **options)
    assert (
        result_along_ridges.attrs["peak_upper"] - result_along_ridges.attrs["peak_lower"]
        < 0.05 * result_along_ridges.attrs["peak"]
    )
    result_of_turned_ridges = run_shear_test(
        Surface(ridges.heights.T.copy(), spacing=ridges.spacing), direction=90, **options
    )
    assert (
        result_of_turned_ridges.attrs["peak_upper"] - result_of_turned_ridges.attrs["peak_lower"]
        < 0.05 * result_along_ridges.attrs["peak"]
    )


def test_shear_test_of_small_maps_and_profiles_has_no_strips():
    assert run_shear_test(create_rough_map(), path="50 um", steps=1, mu0=0.6).attrs["strips"] == 0
    assert run_shear_test(create_wavy_profile(), path="5 um", steps=1, mu0=0.6).attrs["strips"] == 0


def test_strips_without_measured_points_are_omitted_from_a_shear_test():
    face = create_rough_map(128)
    is_missing = np.zeros(face.heights.shape, bool)
    is_missing[:26] = True
    face_with_holes = Surface(face.heights, spacing=face.spacing, missing=is_missing)
    options = {"path": "50 um", "steps": 1, "mu0": 0.6, "level": "mean", "strips": 5} | LOAD_AND_MODULUS
    assert shear_test(create_mate(face), face_with_holes, **options).attrs["strips"] == 4


def test_shear_test_rejects_strips_if_only_one_strip_has_measured_points():
    face = create_rough_map(32)
    is_missing = np.zeros(face.heights.shape, bool)
    is_missing[:17] = True
    face_with_holes = Surface(face.heights, spacing=face.spacing, missing=is_missing)
    options = {"path": "40 um", "steps": 1, "mu0": "0.5..0.7", "level": "mean"} | LOAD_AND_MODULUS
    with pytest.raises(
        ValueError, match="strips must be 0, or give at least 2 strips with enough measured points, got 2"
    ):
        shear_test(create_mate(face), face_with_holes, strips=2, **options)


def test_shear_test_with_exact_inputs_has_no_interval():
    assert "friction_coefficient_interval" not in run_shear_test(create_rough_map(), path="100 um", steps=2, mu0=0.6)


# ---- Arguments -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"path": "2 mm"}, "the sliding path must leave an overlap of at least 16 points along each axis, got 2000 µm"),
        ({"path": "1 um"}, "the sliding path must be at least one grid spacing, got 1 µm"),
        ({"path": 0}, "path must be a finite number above 0 µm, got 0"),
        ({"steps": 0}, "steps must be a whole number of at least 1, got 0"),
        ({"mu0": -0.1}, "mu0 must be finite and not negative, got -0.1"),
        ({"load": "5 s"}, "load must be a force or a pressure with its unit"),
        (
            {"load": "2 GPa"},
            "load must be below 1e\\+06 mN, the hardness times the overlap area of the faces, got '2 GPa'",
        ),
        ({"normal_stiffness": "5 MPa"}, 'normal_stiffness must be a pressure per length, as in "5 MPa/mm", got'),
        ({"normal_stiffness": -1}, "normal_stiffness must be at least 0, got -1"),
        ({"hardness": "2..1 GPa"}, "hardness must be a range from a smaller to a larger value, got '2..1 GPa'"),
        ({"mu0": [0.5, 0.6]}, "mu0 must be one value or one range, got"),
        ({"mu0": None}, "give mu0 or interface"),
        ({"interface": "PTFE on steel"}, "mu0 must not be combined with interface"),
        ({"upper_material": "steel"}, "give effective_modulus, or young and poisson, or upper_material and"),
        ({"strips": 1}, "strips must be 0, or from 2 to 4 for these faces and this path, got 1"),
        ({"strips": 5}, "strips must be 0, or from 2 to 4 for these faces and this path, got 5"),
        (
            {"strips": 3, "path": "300 um", "direction": 30},
            "strips must be 0 or 2 for these faces and this path, got 3",
        ),
        ({"strips": 2, "path": "500 um", "direction": 40}, "strips must be 0 for these faces and this path, got 2"),
        ({"strips": 2, "boundary": "periodic"}, "strips must be 0 for these faces, got 2"),
        ({"tilt": "free", "boundary": "periodic"}, "tilt must be 'fixed' if the faces are periodic, got 'free'"),
        ({"level": "line"}, "level must be mean, plane or none for maps, got 'line'"),
        ({"direction": [0, 90]}, "direction must be a single angle"),
    ],
)
def test_shear_test_rejects_impossible_arguments(options, message):
    face = create_rough_map()
    arguments = {"path": "100 um", "mu0": 0.5, "hardness": "1 GPa"} | LOAD_AND_MODULUS | options
    with pytest.raises(ValueError, match=message):
        shear_test(create_mate(face), face, **arguments)


def test_shear_test_rejects_a_profile_on_a_map_and_a_flipped_face():
    face = create_rough_map()
    options = {"path": "100 um", "mu0": 0.5} | LOAD_AND_MODULUS
    with pytest.raises(ValueError, match="the upper and the lower face must both be profiles or both surfaces"):
        shear_test(face.row(0), face, **options)
    with pytest.raises(ValueError, match="the upper face must be oriented as it was scanned"):
        shear_test(flipped(face), face, **options)


def test_missing_points_are_excluded_from_the_overlap_of_a_shear_test():
    face = create_rough_map()
    is_missing = np.zeros(face.heights.shape, bool)
    is_missing[:8, :8] = True
    face_with_holes = Surface(face.heights, spacing=face.spacing, missing=is_missing)
    result = shear_test(
        create_mate(face), face_with_holes, path="100 um", steps=2, mu0=0.5, level="mean", **LOAD_AND_MODULUS
    )
    assert (result.status == "ok").all()
    assert result.contact_area_fraction[0] == pytest.approx(1, abs=1e-3)
    assert result.overlap_area[0] == pytest.approx((64**2 - 64) * (1000 / 64) ** 2)


# ---- Registration ----------------------------------------------------------------------------------------------------


def test_shear_test_of_registered_faces_starts_at_the_position_of_best_fit():
    large_map = create_rough_map(96)
    upper, lower = (
        Surface(large_map.heights[row : row + 80, column : column + 80], spacing=large_map.spacing)
        for row, column in ((3, 9), (8, 2))
    )
    options = {"path": "50 um", "steps": 2, "mu0": 0.6, "hardness": "200 MPa"} | LOAD_AND_MODULUS
    unregistered_result, registered_result = (
        shear_test(create_mate(upper), lower, register=is_registered, **options) for is_registered in (False, True)
    )
    assert registered_result.attrs["registration_shift_x_um"] == pytest.approx(7 * large_map.spacing[1])
    assert registered_result.attrs["registration_shift_y_um"] == pytest.approx(-5 * large_map.spacing[0])
    assert registered_result.contact_area_fraction[0] > 0.99 > unregistered_result.contact_area_fraction[0]
    assert registered_result.attrs["peak"] > unregistered_result.attrs["peak"]


def test_gap_of_a_shear_test_is_the_distance_of_the_facing_faces_at_first_contact():
    lower = create_rough_map()
    upper = create_mate(lower.changed(lower.heights + create_noise(lower.heights.shape), "rough"))
    result = shear_test(upper, lower, path="50 um", mu0=0.6, level="none", **LOAD_AND_MODULUS)
    gap = shear_gap(result)
    expected = flipped(upper).heights - lower.heights
    np.testing.assert_allclose(gap.heights, expected - expected.min(), atol=ROUND_OFF)
    assert gap.heights.min() == 0.0
    assert gap.spacing == lower.spacing
    with pytest.raises(ValueError, match="test must contain the gap of the faces"):
        shear_gap(result.drop_vars("gap"))


def test_gap_of_registered_faces_has_the_rms_gap_of_the_registration():
    large_map = create_rough_map(96)
    lower = large_map.changed(large_map.heights[16:80, 16:80], "cut")
    upper = large_map.changed(large_map.heights[11:75, 23:87] + create_noise((64, 64)), "cut")
    upper = create_mate(rotated(upper, 1.0))
    result = shear_test(upper, lower, path="50 um", mu0=0.6, register=True, **LOAD_AND_MODULUS)
    gap = shear_gap(result)
    assert min(gap.heights.shape) > 40
    rms_gap = result.attrs["registration_rms_gap_um"]
    assert levelled(gap, "plane").heights.std() == pytest.approx(rms_gap, rel=1e-9)
    assert rms_gap < 0.05 * result.attrs["rms_gap_before_registration_um"]


def test_shear_gap_of_profiles_is_a_profile_and_shear_gap_of_maps_keeps_missing_points():
    profile = create_sawtooth(400)
    assert isinstance(shear_gap(run_shear_test(profile, path="5 um", steps=1, mu0=0.5)), Profile)
    lower = create_rough_map()
    missing = np.zeros(lower.heights.shape, bool)
    missing[3:6, 10:12] = True
    lower = Surface(lower.heights, spacing=lower.spacing, missing=missing)
    noise = create_noise(lower.heights.shape)
    upper = Surface(-(lower.heights + noise)[::-1], spacing=lower.spacing)
    gap = shear_gap(shear_test(upper, lower, path="50 um", steps=1, mu0=0.6, level="none", **LOAD_AND_MODULUS))
    np.testing.assert_array_equal(gap.missing, missing)
    assert gap.heights[~missing].min() == 0.0


def test_stiffness_of_closure_is_the_derivative_of_the_closure_of_the_gap():
    lower = create_rough_map()
    upper = create_mate(lower.changed(lower.heights + create_noise(lower.heights.shape), "rough"))
    options = LOAD_AND_MODULUS | {"hardness": "500 MPa"}
    result = shear_test(upper, lower, path="50 um", mu0=0.6, steps=1, level="none", **options)
    gap = shear_gap(result)
    area = gap.heights.size * np.prod(gap.spacing)
    stresses = result["normal_stress"].values
    assert stresses[-1] == pytest.approx(1e-3)
    for index in (2, 7):
        loads = stresses[index] * area * np.array([1 - STRESS_STEP, 1.0, 1 + STRESS_STEP])
        flat = Surface(np.zeros(gap.heights.shape), spacing=gap.spacing)
        curve = half_space(gap, flat, loads, effective_modulus=30.0, hardness=0.5, tolerance=1e-8)
        assert result["closure"][index] == pytest.approx(curve.closure[1], rel=1e-4)
        stiffness = 2 * STRESS_STEP * stresses[index] / (curve.closure[2] - curve.closure[0])
        assert result["closure_stiffness"][index] == pytest.approx(1e6 * stiffness, rel=DERIVATIVE_TOLERANCE)


def test_stiffness_of_closure_is_proportional_to_modulus_and_stress():
    lower = create_rough_map()
    upper = create_mate(lower.changed(lower.heights + create_noise(lower.heights.shape), "rough"))
    results = [
        shear_test(
            upper, lower, path="50 um", steps=1, mu0=0.6, load=f"{factor} MPa", effective_modulus=f"{30 * factor} GPa"
        )
        for factor in (1, 2)
    ]
    np.testing.assert_allclose(results[1]["closure"], results[0]["closure"], rtol=1e-5)
    np.testing.assert_allclose(results[1]["closure_stiffness"], 2 * results[0]["closure_stiffness"], rtol=1e-5)


def test_limits_of_the_closure_interval_are_the_closures_at_the_limits_of_the_modulus():
    lower = create_rough_map()
    upper = create_mate(lower.changed(lower.heights + create_noise(lower.heights.shape), "rough"))
    options = {"path": "50 um", "steps": 1, "mu0": 0.6, "load": "1 MPa", "strips": 0}
    result, softer_result, stiffer_result = (
        shear_test(upper, lower, effective_modulus=modulus, **options)
        for modulus in ("uniform 20..40 GPa", "20.6 GPa", "39.4 GPa")
    )
    for name in ("closure", "closure_stiffness"):
        limits = result[f"{name}_interval"].values
        values = [test[name].values for test in (softer_result, result, stiffer_result)]
        np.testing.assert_allclose(limits, [np.min(values, axis=0), np.max(values, axis=0)], rtol=0.02)


def test_shear_intervals_are_unbounded_if_the_lowest_hardness_cannot_carry_the_load():
    lower = create_rough_map()
    upper = create_mate(lower.changed(lower.heights + create_noise(lower.heights.shape), "rough"))
    options = {"path": "50 um", "steps": 1, "mu0": 0.6, "load": "2 MPa", "strips": 0}
    result = shear_test(upper, lower, effective_modulus="30 GPa", hardness="uniform 1..20 MPa", **options)
    assert np.isfinite(result["closure"]).all()
    for name in ("peak", "end", "peak_shear_stress_GPa"):
        assert (result.attrs[f"{name}_lower"], result.attrs[f"{name}_upper"]) == (0.0, np.inf)
    assert "peak_dilation_angle_deg_lower" not in result.attrs
    for name in ("dilation", "closure", "closure_stiffness"):
        assert np.isnan(result[f"{name}_interval"][:, -1]).all()
    assert np.isfinite(result["closure_interval"][:, 0]).all()
    (caveat,) = (text for text in list_caveats(result) if text.startswith("Intervals are open or missing"))
    assert "at a limit of the uncertain inputs: friction coefficient at 2 of 2 displacements, dilation at" in caveat
    assert "closure at 1 of 8 normal stresses" in caveat
    assert "strips" not in caveat


def test_closure_of_faces_that_fit_perfectly_is_zero_and_has_no_stiffness():
    result = run_shear_test(create_rough_map(), path="50 um", steps=1, mu0=0.6)
    np.testing.assert_allclose(result["closure"], 0.0, atol=ROUND_OFF)
    assert result["closure_stiffness"].isnull().all()


def test_shear_test_does_not_register_flat_faces():
    flat = Surface(np.zeros((40, 40)), spacing=10.0)
    with pytest.raises(ValueError, match="`register` must be False if a face is flat, got True"):
        run_shear_test(flat, path="50 um", mu0=0.6, register=True)


def test_shear_test_does_not_register_periodic_faces():
    with pytest.raises(ValueError, match="`register` must be False if the faces are periodic, got True"):
        run_shear_test(create_rough_map(), path="50 um", mu0=0.6, boundary="periodic", register=True)


# ---- Closure ---------------------------------------------------------------------------------------------------------


def test_fit_of_bandis_law_recovers_parameters_of_exact_closures():
    pressure = np.geomspace(1e-5, 1e-3, 8)
    law = fit_bandis_law(pressure, pressure * 20.0 / (3e-6 * 20.0 + pressure))
    assert (law.initial_stiffness, law.maximum_closure) == (pytest.approx(3e-6), pytest.approx(20.0))
    assert law.misfit == pytest.approx(0, abs=1e-6)


def test_bandis_law_is_undefined_if_closures_do_not_approach_a_maximum():
    pressure = np.geomspace(1e-5, 1e-3, 8)
    assert np.isnan(fit_bandis_law(pressure, 1e3 * pressure).maximum_closure)
    assert np.isnan(fit_bandis_law(pressure, 0 * pressure).misfit)


def test_closure_before_shear_follows_from_the_gap_and_is_zero_for_a_perfect_fit():
    face = create_rough_map()
    noise = np.random.default_rng(1).normal(0, 0.5, face.heights.shape)
    rough_mate = create_mate(face).changed(create_mate(face).heights + noise, "noise")
    options = {"path": "50 um", "steps": 1, "mu0": 0.6, "level": "none"} | LOAD_AND_MODULUS
    attributes = shear_test(rough_mate, face, **options).attrs
    gap = flipped(rough_mate).changed(flipped(rough_mate).heights - face.heights, "gap")
    flat = gap.changed(np.zeros_like(gap.heights), "flat")
    curve = half_space(gap, flat, ["1 MPa"], effective_modulus=30.0)
    pressure, maximum = 1e-3, attributes["maximum_closure_um"]
    law = pressure * maximum / (attributes["closure_initial_stiffness_GPa_per_um"] * maximum + pressure)
    assert law == pytest.approx(float(curve.closure[0]), rel=attributes["closure_misfit"] + 1e-3)
    assert attributes["closure_misfit"] < 0.3
    result_of_perfect_fit = shear_test(create_mate(face), face, **options)
    assert np.isnan(result_of_perfect_fit.attrs["closure_misfit"])
