import copy
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import types

import numpy as np
import pytest
import scipy.fft
import stiction._core as _core
from reference import dense_half_space
from soak import half_space as soak
from stiction import (
    HalfSpaceCurve,
    Profile,
    Study,
    Surface,
    gentle_friction,
    half_space,
    hertz_ellipse,
    hertz_line,
    hertz_sphere,
    press,
    self_affine_surface,
    westergaard_contact_fraction,
    westergaard_gap,
    westergaard_pressure,
)
from stiction.mechanics.half_space_problem import solver_thread_count
from stiction.study.members import pair_of
from support.rough_surfaces import flat_like, periodic_body

EFFECTIVE_MODULUS = 10.0
DENSE_SOLUTION_TOLERANCE = 1e-8  # pressure error relative to the highest pressure, for solver tolerances of 1e-11
MINDLIN_TOLERANCE = 1e-3  # displacement error, relative to that of a sphere whose contact radius is 50 points
ROUND_OFF = 1e-12
# Relative error of the true area with about 15 points per contact. The mean error over several grids is below 0.015.
PLASTIC_EDGE_TOLERANCE = 0.05
QUADRATURE_TOLERANCE = 1e-9  # relative difference from a numerical integral of smooth functions on 60 by 200 points
FRICTION_SCATTER_TOLERANCE = 0.015  # relative scatter over twelve directions of two pairs with some tens of contacts
TIGHT_TOLERANCE = 1e-10


# Error relative to the largest displacement. It is larger than round-off because logarithms of distant cells cancel.
LARGE_GRID_TOLERANCE = 1e-11
MAX_SECONDS_AFTER_INTERRUPT = 2.0  # limit of processor time (s); a complete solution takes ten times as long
SOLUTION_TOLERANCE = 1e-5


STIFFNESS_TOLERANCE = 1e-6  # relative error of a stiffness whose compliance has an error of 1e-7
BALL_TOLERANCE = 2e-3  # relative error of the load at a given approach for a contact radius of 24 points


def make_solver(gap, spacing, *, periodic, bound=np.inf, tolerance):
    grids = _core.HalfSpaceGrids(gap.shape, spacing, effective_modulus=EFFECTIVE_MODULUS, periodic=periodic)
    return _core.HalfSpaceSolver(gap, grids, bound=np.ravel(bound).astype(float), tolerance=tolerance)


def create_paraboloid(n, extent, radii):
    """Return a paraboloid whose lowest point lies between grid points."""
    x = (np.arange(n) - n / 2 + 0.31) * extent / n
    return Surface(x[:, None] ** 2 / (2 * radii[0]) + x[None, :] ** 2 / (2 * radii[1]), spacing=extent / n)


@pytest.mark.parametrize("shape", [(64,), (63,), (12, 15)])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("relative_load", [0.02, 0.3])
def test_half_space_pressure_agrees_with_a_dense_matrix_calculation(shape, boundary, relative_load):
    lower = periodic_body(shape, longest=1, shortest=5)
    load = relative_load * EFFECTIVE_MODULUS * 0.1
    curve = half_space(flat_like(lower), lower, [load], boundary=boundary, tolerance=1e-11)
    spacing = np.array([1 / n for n in shape])
    matrix = dense_half_space.influence_matrix(shape, spacing, EFFECTIVE_MODULUS, periodic=boundary == "periodic")
    result = curve.contact(0)
    gap = lower.heights.max() - lower.heights
    approach = float(np.mean((matrix @ result.pressure.ravel() + gap.ravel())[result.pressure.ravel() > 0]))
    if boundary == "periodic" or len(shape) == 2:
        np.testing.assert_allclose(curve.approach, approach, rtol=DENSE_SOLUTION_TOLERANCE)
    exact_pressure = dense_half_space.solve_pressure(
        matrix, gap, approach, total=result.pressure.sum() if boundary == "periodic" else None
    )
    np.testing.assert_allclose(
        result.pressure.ravel(), exact_pressure, rtol=0, atol=DENSE_SOLUTION_TOLERANCE * exact_pressure.max()
    )
    np.testing.assert_allclose(exact_pressure.sum() * np.prod(spacing), load, rtol=DENSE_SOLUTION_TOLERANCE)


@pytest.mark.parametrize("shape", [(64,), (12, 15)])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("hardness", [None, 0.5])
@pytest.mark.parametrize("relative_load", [0.02, 0.3])
def test_missing_points_have_neither_pressure_nor_gap(shape, boundary, hardness, relative_load):
    body = periodic_body(shape, longest=1, shortest=5)
    is_missing = np.zeros(shape, bool)
    is_missing[tuple(slice(n // 2) for n in shape)] = is_missing[np.unravel_index(body.heights.argmax(), shape)] = True
    lower = type(body)(body.heights, spacing=body.spacing, missing=is_missing)
    load, spacing = relative_load * EFFECTIVE_MODULUS * 0.05, np.array([1 / n for n in shape])
    curve = half_space(flat_like(lower), lower, [load], boundary=boundary, hardness=hardness, tolerance=1e-11)
    assert curve.error[0] <= 1e-11
    result = curve.contact(0)
    assert not result.pressure[is_missing].any()
    assert np.isnan(result.gap[is_missing]).all()
    gap = lower.heights[~is_missing].max() - lower.heights
    bound = np.where(is_missing, 0.0, np.inf if hardness is None else hardness)
    matrix = dense_half_space.influence_matrix(shape, spacing, EFFECTIVE_MODULUS, periodic=boundary == "periodic")
    is_between_bounds = ((result.pressure > 0) & (result.pressure < bound)).ravel()
    approach = float(np.mean((matrix @ result.pressure.ravel() + gap.ravel())[is_between_bounds]))
    total_pressure = result.pressure.sum() if boundary == "periodic" else None
    exact_pressure = dense_half_space.solve_pressure(matrix, gap, approach, total=total_pressure, bound=bound)
    np.testing.assert_allclose(
        result.pressure.ravel(), exact_pressure, rtol=0, atol=DENSE_SOLUTION_TOLERANCE * exact_pressure.max()
    )
    load_at_pressure = half_space(flat_like(lower), lower, "1 MPa", boundary=boundary).load
    np.testing.assert_allclose(load_at_pressure, 1e-3 * (1 - is_missing.mean()), rtol=ROUND_OFF)
    with pytest.raises(ValueError, match="every model except half_space requires complete scans"):
        press(flat_like(lower), lower, [0.1])


@pytest.mark.parametrize("shape", [(63,), (12, 15)])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("flat", [False, True])
@pytest.mark.parametrize("part", [0.05, 0.95])
def test_pressures_with_a_bound_at_each_point_agree_with_a_dense_matrix_calculation(shape, boundary, flat, part):
    """Use bounds that vary between points, like a hardness on a rough gap or limits of a traction on a flat."""
    random = np.random.default_rng(5)
    periodic, spacing = boundary == "periodic", tuple(1 / n for n in shape)
    gap = np.zeros(shape) if flat else -(body := periodic_body(shape, longest=1, shortest=5).heights) + body.max()
    bound = random.uniform(0.1, 1.0, shape) * (random.random(shape) < 0.7 if flat else 1.0)
    solver = make_solver(gap, spacing, periodic=periodic, bound=bound, tolerance=1e-11)
    matrix = dense_half_space.influence_matrix(shape, spacing, EFFECTIVE_MODULUS, periodic=boundary == "periodic")
    initial_pressure = None
    for mean in np.array([0.9, 1.0]) * part * bound.mean():
        result = solver.at(mean, near=initial_pressure)
        initial_pressure = result.pressure
        assert result.error <= 1e-11
        exact_pressure = dense_half_space.solve_pressure(
            matrix, gap, result.approach, total=result.pressure.sum() if periodic else None, bound=bound
        )
        np.testing.assert_allclose(
            result.pressure, exact_pressure, rtol=0, atol=DENSE_SOLUTION_TOLERANCE * exact_pressure.max()
        )
        np.testing.assert_allclose(exact_pressure.mean(), mean, rtol=DENSE_SOLUTION_TOLERANCE)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_half_space_solver_with_bounded_pressures_converges_for_flats_up_to_the_maximum_load(boundary):
    """Solve a flat with equal bounds up to the largest load that the bounds permit.

    With a periodic boundary all points move equally. With a free boundary the traction is that of a punch.
    """
    random = np.random.default_rng(2)
    bound = 1.0 + 1e-15 * random.normal(size=(20, 24))
    solver = make_solver(
        np.zeros(bound.shape), (0.1, 0.1), periodic=boundary == "periodic", bound=bound, tolerance=1e-6
    )
    initial_pressure = None
    for ratio in (0.01, 0.5, 0.99, 0.9999):
        result = solver.at(ratio, near=initial_pressure)
        initial_pressure = result.pressure
        assert result.error <= 1e-6
        if boundary == "periodic":
            assert result.pressure == pytest.approx(np.full(bound.size, ratio), rel=SOLUTION_TOLERANCE)


@pytest.mark.parametrize("ratio", [0.3, 0.6, 0.9, 0.99])
def test_tangential_traction_under_a_sphere_equals_mindlin_solution(ratio):
    """Compare with Mindlin's solution; the bound is Hertz's pressure times mu0 (Johnson, section 7.2).

    The stick radius relative to the contact radius is (1 - T/T_s)^(1/3).
    """
    n, spacing, radius, mu0 = 128, 0.02, 1.0, 0.4
    x = (np.arange(n) - n / 2 + 0.31) * spacing
    bound = mu0 * np.sqrt(np.maximum(1 - (x[:, np.newaxis] ** 2 + x**2) / radius**2, 0))
    solver = make_solver(np.zeros((n, n)), (spacing, spacing), periodic=False, bound=bound, tolerance=1e-8)
    result = solver.at(ratio * bound.mean())
    is_sticking = (bound > 0) & (result.pressure.reshape(n, n) < bound)
    assert np.sqrt(is_sticking.sum() * spacing**2 / np.pi) == pytest.approx((1 - ratio) ** (1 / 3), abs=spacing)
    displacement_at_sliding = np.pi * mu0 / 2 / EFFECTIVE_MODULUS * radius
    assert result.approach == pytest.approx(
        displacement_at_sliding * (1 - (1 - ratio) ** (2 / 3)), rel=MINDLIN_TOLERANCE
    )


@pytest.mark.parametrize("fraction", [0.01, 0.1, 0.5, 0.9, 0.99])
def test_half_space_solution_of_a_sinusoid_equals_westergaard_solution(fraction):
    amplitude, full_contact_pressure = (
        1e-4,
        np.pi * EFFECTIVE_MODULUS * 1e-4,
    )  # at such small slopes, true areas equal projected areas
    wave_arguments = {"amplitude": amplitude, "wavelength": 1.0, "effective_modulus": EFFECTIVE_MODULUS}
    load = full_contact_pressure * np.sin(np.pi / 2 * fraction) ** 2
    errors = []
    for n in (1024, 4096):
        x = (np.arange(n) + 0.31) / n
        lower = Profile(amplitude * np.cos(2 * np.pi * x), spacing=1 / n)
        curve = half_space(flat_like(lower), lower, [load], boundary="periodic", tolerance=TIGHT_TOLERANCE)
        exact_fraction = westergaard_contact_fraction(load, **wave_arguments)
        result = curve.contact(0)
        errors.append(np.abs(result.pressure - westergaard_pressure(x, load, **wave_arguments)).mean() / load)
        # The edge of the contact is accurate to one point, and the gap next to the edge has the corresponding accuracy.
        assert abs(curve.contact_area[0] - exact_fraction) < 1 / n
        gap = westergaard_gap(x, load, **wave_arguments)
        assert np.abs(result.gap - gap).max() < 2 * amplitude / n**0.5 * max(fraction, 0.1) * 0.1
    # Mean errors decrease with the spacing to first order or faster, for any position of the edges.
    assert errors[1] < errors[0] / 2.5
    assert errors[1] < 0.15 / (4096 * fraction)


def test_westergaard_pressure_and_gap_and_contact_fraction_agree_with_each_other():
    wave_arguments = {"amplitude": 0.01, "wavelength": 2.0, "effective_modulus": EFFECTIVE_MODULUS}
    x = np.linspace(-1, 1, 20_001)[:-1]
    for load in (0.001, 0.1, 0.2):
        p = westergaard_pressure(x, load, **wave_arguments)
        # Integrating a pressure with square-root edges numerically has a relative error of 2e-5.
        assert p.mean() == pytest.approx(load, rel=2e-5)
        assert np.mean(p > 0) == pytest.approx(
            min(1.0, float(westergaard_contact_fraction(load, **wave_arguments))), abs=2e-4
        )
        gap = westergaard_gap(x, load, **wave_arguments)
        assert (gap[p > 0] == 0).all()
        assert (gap[p == 0] >= 0).all()
    np.testing.assert_allclose(westergaard_gap(x, 1e-12, **wave_arguments), 0.01 * (1 - np.cos(np.pi * x)), atol=1e-9)


def test_half_space_solution_of_a_line_contact_equals_hertz_solution():
    radius, load, errors = 5.0, 0.1, []
    half_width, max_pressure = hertz_line(load, radius, EFFECTIVE_MODULUS)
    for n in (512, 2048):
        x = (np.arange(n) - n / 2 + 0.31) / n
        gap = Profile(x**2 / (2 * radius), spacing=1 / n)
        curve = half_space(gap, flat_like(gap), [load], tolerance=1e-9)
        exact_pressure = max_pressure * np.sqrt(np.maximum(1 - (x / half_width) ** 2, 0))
        errors.append(np.abs(curve.contact(0).pressure - exact_pressure).mean() / exact_pressure.mean())
        assert abs(curve.contact_area[0] - 2 * half_width) < 1 / n
        assert np.isnan(curve.approach).all()
        assert np.isnan(curve.stiffness).all()
    assert errors[1] < errors[0] / 3
    assert errors[1] < 1e-3


@pytest.mark.parametrize("radii", [(5.0, 5.0), (5.0, 15.0)])
def test_half_space_solution_of_a_point_contact_equals_hertz_solution(radii):
    force, area, axes = hertz_ellipse(0.01, *radii, EFFECTIVE_MODULUS)
    errors = []
    for n in (64, 128, 256):
        gap = create_paraboloid(n, 1.6, radii)
        curve = half_space(gap, flat_like(gap), [float(force)], tolerance=1e-8)
        approach = curve.approach[0] + gap.heights.min()
        errors.append(abs(approach / 0.01 - 1))
        # After the perimeter correction of the area, an error of some tenths of a cell along the perimeter remains.
        assert curve.contact_area[0] == pytest.approx(float(area), rel=0.3 * 1.6 / n / axes[0])
    assert errors[-1] < 3e-4
    assert errors[-1] < errors[0] / 4
    assert curve.stiffness[0] == pytest.approx(1.5 * float(force) / 0.01, rel=5e-3)
    assert curve.contact_count[0] == 1


def test_elliptic_hertz_contact_tends_to_sphere_contact_and_line_contact():
    force, area, (a, b) = hertz_ellipse(0.01, 3.0, 3.0, EFFECTIVE_MODULUS)
    np.testing.assert_allclose((force, area), hertz_sphere(0.01, 3.0, EFFECTIVE_MODULUS), rtol=ROUND_OFF)
    np.testing.assert_allclose(a, b, rtol=ROUND_OFF)
    force, area, (a, b) = hertz_ellipse(0.01, 1e8, 1.0, EFFECTIVE_MODULUS)
    # Across a long ellipse the pressure is that of a line contact. The load per length is 3 F/(4 a).
    half_width, _ = hertz_line(3 * force / (4 * a), 1.0, EFFECTIVE_MODULUS)
    np.testing.assert_allclose(b, half_width, rtol=1e-6)
    # A curvature ratio of 5 gives 0.968 times the area and 1.0536 times the force of the equivalent sphere.
    force, area, (a, b) = hertz_ellipse(0.01, 5.0, 1.0, EFFECTIVE_MODULUS)
    sphere = hertz_sphere(0.01, 5.0**0.5, EFFECTIVE_MODULUS)
    np.testing.assert_allclose([b / a, area / sphere[1], force / sphere[0]], [0.346, 0.9680, 1.0536], atol=5e-4)


def test_pressure_under_a_flat_punch_equals_closed_form():
    n = 1024
    flat = Profile(np.zeros(n), spacing=1 / n)
    p = half_space(flat, flat, [1.0]).contact(0).pressure
    x = (np.arange(n) + 0.5) / n - 0.5
    is_inside = np.abs(x) < 0.45
    np.testing.assert_allclose(p[is_inside], 1 / (np.pi * np.sqrt(0.25 - x[is_inside] ** 2)), rtol=2e-3)


@pytest.mark.parametrize("shape", [(128,), (48, 40)])
def test_pressure_in_full_contact_equals_the_exact_fourier_series(shape):
    lower = periodic_body(shape)
    waves = np.meshgrid(
        *[2 * np.pi * np.fft.fftfreq(n, 1 / n) for n in shape[:-1]],
        2 * np.pi * np.fft.rfftfreq(shape[-1], 1 / shape[-1]),
        indexing="ij",
    )
    k = np.sqrt(sum(np.square(wave) for wave in waves))
    exact_pressure = 5.0 + scipy.fft.irfftn(0.5 * EFFECTIVE_MODULUS * k * scipy.fft.rfftn(lower.heights), shape)
    assert exact_pressure.min() > 0
    curve = half_space(flat_like(lower), lower, [5.0], boundary="periodic", tolerance=TIGHT_TOLERANCE)
    np.testing.assert_allclose(curve.contact(0).pressure, exact_pressure, rtol=1e-7)
    assert np.isinf(curve.stiffness[0])


def test_half_space_results_scale_with_the_modulus_and_ignore_height_offsets():
    lower = periodic_body((64, 64))
    original_curve = half_space(flat_like(lower), lower, [0.01, 0.1], boundary="periodic", tolerance=TIGHT_TOLERANCE)
    raised_body = Surface(lower.heights + 3.0, spacing=lower.spacing)
    stiffer_curve = half_space(
        flat_like(lower),
        raised_body,
        [0.07, 0.7],
        boundary="periodic",
        effective_modulus=7 * EFFECTIVE_MODULUS,
        tolerance=TIGHT_TOLERANCE,
    )
    for name in ("normal_elastic", "tangential_elastic", "normal_frictional", "tangential_frictional"):
        np.testing.assert_allclose(
            getattr(stiffer_curve, name), 7 * getattr(original_curve, name), rtol=1e-7, err_msg=name
        )
    np.testing.assert_array_equal(stiffer_curve.contact_count, original_curve.contact_count)
    np.testing.assert_allclose(stiffer_curve.contact_area, original_curve.contact_area, rtol=ROUND_OFF)
    np.testing.assert_allclose(stiffer_curve.stiffness, 7 * original_curve.stiffness, rtol=1e-5)


def test_free_and_periodic_boundaries_give_equal_results_for_small_contact_patches():
    differences = []
    force = float(hertz_sphere(0.01, 4.0, EFFECTIVE_MODULUS)[0])  # mN; the contact radius is 0.2 µm
    for extent in (0.5, 1.0, 2.0):
        gap = create_paraboloid(int(64 * extent), extent, (4.0, 4.0))
        free_pressure, periodic_pressure = (
            half_space(gap, flat_like(gap), [force], boundary=boundary).contact(0).pressure
            for boundary in ("free", "periodic")
        )
        differences.append(np.abs(free_pressure - periodic_pressure).sum() / free_pressure.sum())
    assert differences[2] < differences[1] / 2 < differences[0] / 4
    assert differences[2] < 0.01


def test_contact_stiffness_equals_derivative_of_load():
    lower = periodic_body((96, 96), shortest=8)
    load = 0.05 * np.array([0.99, 1.0, 1.01])
    curve = half_space(flat_like(lower), lower, load, boundary="periodic", tolerance=1e-9)
    slope = (load[2] - load[0]) / (curve.approach[2] - curve.approach[0])
    # The difference quotient also includes points that come into contact between the two loads.
    assert curve.stiffness[1] == pytest.approx(slope, rel=0.01)


@pytest.mark.parametrize("hardness", [None, 0.06 * EFFECTIVE_MODULUS], ids=["elastic", "yielding"])
@pytest.mark.parametrize(("shape", "boundary"), [((63,), "periodic"), ((12, 15), "periodic"), ((12, 15), "free")])
def test_contact_stiffness_agrees_with_a_dense_matrix_calculation(shape, boundary, hardness):
    """Compare the stiffness with dense matrices; unloading is elastic also at points that yielded.

    Without a hardness, the stiffnesses of loading and unloading are equal.
    """
    lower = periodic_body(shape, longest=1, shortest=5)
    curve = half_space(flat_like(lower), lower, [0.02 * EFFECTIVE_MODULUS], boundary=boundary, hardness=hardness)
    spacing = np.array([1 / n for n in shape])
    matrix = dense_half_space.influence_matrix(shape, spacing, EFFECTIVE_MODULUS, periodic=boundary == "periodic")
    contact_indices = np.flatnonzero(curve.contact(0).pressure)
    assert 5 < contact_indices.size < 0.8 * lower.heights.size
    uniform_pressure = np.linalg.solve(matrix[np.ix_(contact_indices, contact_indices)], np.ones(contact_indices.size))
    assert (uniform_pressure > 0).all()
    assert curve.unloading_stiffness[0] == pytest.approx(
        uniform_pressure.sum() * np.prod(spacing), rel=STIFFNESS_TOLERANCE
    )
    if boundary == "periodic":
        assert curve.unloading_closure_stiffness[0] == pytest.approx(curve.unloading_stiffness[0], rel=1e-9)
    else:  # The closure does not include the mean displacement of the nominal area.
        mean_displacement = (matrix[:, contact_indices] @ uniform_pressure).mean()
        assert curve.unloading_closure_stiffness[0] == pytest.approx(
            uniform_pressure.sum() * np.prod(spacing) / (1 - mean_displacement), rel=10 * STIFFNESS_TOLERANCE
        )
    if hardness is None:
        assert curve.stiffness[0] == curve.unloading_stiffness[0]
    else:
        assert curve.load_share_at_hardness[0] > 0.1
        assert curve.stiffness[0] < 0.95 * curve.unloading_stiffness[0]


@pytest.mark.parametrize(
    ("periodic", "in_contact"),
    [
        (True, np.random.default_rng(1).random((48, 40)) < 0.7),
        (False, np.random.default_rng(1).random((48, 40)) < 0.7),
        (True, np.arange(48)[:, np.newaxis] + np.zeros(40) > 0),
    ],
    ids=["scattered points, periodic", "scattered points, free", "all rows except the first, periodic"],
)
def test_response_of_wide_contacts_agrees_with_a_dense_matrix_calculation(periodic, in_contact):
    """The contacts have so many points that the response is computed by iteration."""
    shape, spacing = in_contact.shape, np.array([0.1, 0.1])
    grids = _core.HalfSpaceGrids(shape, spacing, effective_modulus=EFFECTIVE_MODULUS, periodic=periodic)
    pressure, compliance = grids.linear_response(in_contact)
    matrix = dense_half_space.influence_matrix(shape, spacing, EFFECTIVE_MODULUS, periodic=periodic)
    indices = np.flatnonzero(in_contact)
    exact_pressure = np.linalg.solve(matrix[np.ix_(indices, indices)], np.ones(indices.size))
    assert compliance == pytest.approx(1 / exact_pressure.sum(), rel=STIFFNESS_TOLERANCE)
    assert np.sum(pressure) == pytest.approx(1, abs=1e-7)
    assert np.ravel(pressure)[indices] == pytest.approx(exact_pressure / exact_pressure.sum(), rel=0.02)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("pressed", [0.002, 0.05, 0.5])
def test_half_space_pressure_agrees_with_the_tamaas_library(pressed, boundary):
    tamaas = pytest.importorskip("tamaas")
    tamaas.set_log_level(tamaas.LogLevel.error)
    n = 64
    lower = periodic_body((n, n), shortest=8)
    load = pressed * EFFECTIVE_MODULUS * 0.1
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [1.0, 1.0], [n, n])
    model.E, model.nu = EFFECTIVE_MODULUS, 0.0
    # With a tolerance below 1e-12, the iteration of tamaas might never end.
    solver = tamaas.PolonskyKeerRey(model, lower.heights.copy(), 1e-11)
    if boundary == "free":
        tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
        solver.setIntegralOperator("dcfft")
    solver.max_iter = 1000
    assert solver.solve(load) < 1e-11
    result = half_space(flat_like(lower), lower, [load], boundary=boundary, tolerance=1e-9).contact(0).pressure
    tamaas_pressure = np.array(model.traction).reshape(n, n)
    # Both solvers limit the error of the energy, so errors of pressures are larger than the tolerance.
    assert np.abs(result - tamaas_pressure).max() < 1e-7 * tamaas_pressure.max()


def test_nondimensional_contact_area_per_load_is_near_2_at_light_load():
    lower = periodic_body((256, 256), shortest=32)
    curve = half_space(flat_like(lower), lower, [0.02 * EFFECTIVE_MODULUS * 0.1], boundary="periodic")
    assert 1.8 < curve.contact_area[0] * EFFECTIVE_MODULUS * 0.1 / curve.load[0] < 2.5


def test_pressure_is_limited_by_the_hardness_and_area_tends_to_load_divided_by_hardness():
    lower = periodic_body((128, 128), shortest=16)
    load = 0.01
    elastic_curve = half_space(flat_like(lower), lower, [load], boundary="periodic")
    max_elastic_pressure = elastic_curve.contact(0).pressure.max()
    high_hardness_curve = half_space(
        flat_like(lower), lower, [load], boundary="periodic", hardness=2 * max_elastic_pressure
    )
    np.testing.assert_allclose(high_hardness_curve.contact_area, elastic_curve.contact_area, rtol=1e-3)
    assert high_hardness_curve.area_share_at_hardness[0] == 0
    load_fractions = []
    for hardness in (0.3, 0.1, 0.03):
        curve = half_space(
            flat_like(lower), lower, [load], boundary="periodic", hardness=hardness * max_elastic_pressure
        )
        result = curve.contact(0)
        is_at_hardness = result.pressure == hardness * max_elastic_pressure
        assert result.pressure.max() <= hardness * max_elastic_pressure
        assert (result.gap[~is_at_hardness] > -2e-6 * lower.heights.std()).all()
        load_fractions.append(curve.load_share_at_hardness[0])
        ratio = (result.pressure > 0).mean() / (load / (hardness * max_elastic_pressure))
    assert load_fractions == sorted(load_fractions)
    assert load_fractions[-1] > 0.95
    assert ratio == pytest.approx(1.0, abs=0.05)


def test_random_half_space_problems_with_hardness_satisfy_the_contact_conditions():
    """Check that problems of the stress suite are solved, with a mean contact pressure of at most the hardness."""
    random = np.random.default_rng(8)
    for _ in range(8):
        upper, lower, load, arguments, description = soak.random_problem_with_hardness(random)
        curve = half_space(upper, lower, [load], effective_modulus=soak.EFFECTIVE_MODULUS, **arguments)
        assert not soak.find_solution_violations(lower, load, arguments, curve), description


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("shape", [(256,), (40, 40)])
@pytest.mark.parametrize("ratio", [0.5, 10, 1000])
def test_half_space_accepts_arbitrarily_low_hardness(shape, boundary, ratio):
    """Solve pairs with E* h'/H from 0.5 to 1000 at loads up to the largest load that the hardness permits."""
    lower = periodic_body(shape)
    hardness = EFFECTIVE_MODULUS * 0.1 / ratio
    loads = np.array([1e-3, 0.03, 0.3, 0.9, 0.999]) * hardness
    curve = half_space(flat_like(lower), lower, loads, boundary=boundary, hardness=hardness)
    assert (curve.error <= 1e-6).all()
    assert (curve.load / curve.contact_area <= hardness * (1 + ROUND_OFF)).all()
    assert (np.diff(curve.contact_area) >= 0).all()
    for index in range(loads.size):
        contact = curve.contact(index)
        assert (contact.share >= contact.pressure / hardness).all()
        assert ((contact.share > 0) == (contact.pressure > 0)).all()
        assert contact.share.max() <= 1


def test_contact_area_with_hardness_is_independent_of_grid():
    """Compare two grids on which the shortest wavelength has 16 and 64 points."""
    loads, fine_body = [0.005, 0.03], periodic_body((512, 512), longest=2, shortest=8, seed=3)
    for hardness in (0.7, 0.2, 0.04):
        areas = []
        for step in (1, 4):
            lower = Surface(fine_body.heights[::step, ::step], spacing=step / 512)
            curve = half_space(flat_like(lower), lower, loads, boundary="periodic", hardness=hardness, tolerance=1e-5)
            areas.append(curve.contact_area)
        assert areas[1] == pytest.approx(areas[0], rel=PLASTIC_EDGE_TOLERANCE)


def test_half_space_pressure_with_hardness_agrees_with_the_tamaas_library():
    tamaas = pytest.importorskip("tamaas")
    tamaas.set_log_level(tamaas.LogLevel.error)
    n, load, hardness = 32, 0.05, 0.6
    lower = periodic_body((n, n), longest=1, shortest=5)
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [1.0, 1.0], [n, n])
    model.E, model.nu = EFFECTIVE_MODULUS, 0.0
    solver = tamaas.KatoSaturated(model, lower.heights.copy(), 1e-12, hardness)
    solver.max_iter = 100_000
    solver.solve(load)
    tamaas_pressure = np.array(model.traction).reshape(n, n)
    curve = half_space(flat_like(lower), lower, [load], boundary="periodic", hardness=hardness, tolerance=1e-9)
    assert 0 < curve.load_share_at_hardness[0] < 1
    assert np.abs(curve.contact(0).pressure - tamaas_pressure).max() < 1e-4 * hardness


def test_half_space_friction_agrees_with_the_small_slope_formula():
    slope, mu0, tau0 = 0.1, 0.4, 0.2
    load = 0.005 * EFFECTIVE_MODULUS * slope
    angles = np.arange(0, 360, 45)
    for sliding, tolerance in (("all", 2e-3), ("opposing", 0.015)):
        for strength in (0.0, tau0):
            result, expected = [], []
            for pair in ((1, 2), (3, 4)):
                upper, lower = (
                    periodic_body((256, 256), seed=seed, longest=8, shortest=32, slope=slope / 2**0.5) for seed in pair
                )
                curve = half_space(upper, lower, [load], boundary="periodic", direction=angles, sliding=sliding)
                assert curve.friction_coefficient(mu0=mu0).shape == (8, 1)
                result.append(curve.friction_coefficient(mu0=mu0, tau0=strength).mean())
                kappa = curve.contact_area[0] * EFFECTIVE_MODULUS * slope / load
                expected.append(gentle_friction(mu0, strength, rms_gradient=slope, kappa=kappa, sliding=sliding))
            assert np.mean(result) == pytest.approx(np.mean(expected), rel=tolerance), (sliding, strength)


def test_small_slope_friction_equals_its_formula():
    m, s = 0.4 + 2.0 * 0.1 / (20 * 0.3), 0.2 / (2 * np.sqrt(2 * np.pi))
    arguments = {"rms_gradient": 0.3, "rms_slope": 0.2, "effective_modulus": 20.0, "kappa": 2.0}
    assert gentle_friction(0.4, 0.1, **arguments) == pytest.approx((m / 2 + s) / (1 - m * s), rel=ROUND_OFF)
    assert gentle_friction(0.4, 0.1, sliding="all", **arguments) == pytest.approx(m, rel=ROUND_OFF)
    friction = gentle_friction([[0.1], [0.4]], rms_gradient=[0.1, 0.2, 30.0])
    assert friction.shape == (2, 3)
    assert np.isnan(friction[1, 2])
    assert gentle_friction(0.4, rms_gradient=0.1) == gentle_friction(0.4, rms_gradient=0.1, rms_slope=0.1 / 2**0.5)
    with pytest.raises(ValueError, match="rms_gradient"):
        gentle_friction(0.4, rms_gradient=0.0)
    with pytest.raises(ValueError, match="sliding"):
        gentle_friction(0.4, rms_gradient=0.1, sliding="some")


def friction_on_random_slopes(sigma_along, sigma_across, m, *, rule):
    """Return the friction of contacts with equal forces and normally distributed slopes, summed directly."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(60)
    nodes_of_half, quadrature_weights = np.polynomial.legendre.leggauss(200)
    # The sum covers uphill slopes of up to ten standard deviations. Downhill slopes are their mirror image.
    slopes_along = 5 * (nodes_of_half + 1) * sigma_along
    probability = 5 * quadrature_weights * np.exp(-((slopes_along / sigma_along) ** 2) / 2) / np.sqrt(2 * np.pi)
    normal = tangential = 0.0
    for slope_across, weight in zip(nodes * sigma_across, weights / weights.sum(), strict=True):
        for sign in (1, -1):
            slope = np.stack([sign * slopes_along, np.full(slopes_along.size, slope_across)])
            q = np.sqrt(1 + (slope**2).sum(axis=0))
            n = np.stack([-slope[0], -slope[1], np.ones(slopes_along.size)]) / q
            t = n[0] * n - np.array([[1.0], [0.0], [0.0]])
            t /= np.sqrt((t**2).sum(axis=0))
            acting_friction = m if rule == "all" or sign > 0 else 0.0
            acting_elastic = 1.0 if rule == "all" or sign > 0 else 0.0
            normal += weight * (probability * q * (n[2] + acting_friction * t[2])).sum()
            tangential -= weight * (probability * q * (acting_elastic * n[0] + acting_friction * t[0])).sum()
    return tangential / normal


@pytest.mark.parametrize("rule", ["opposing", "all"])
@pytest.mark.parametrize(("gradient", "slope"), [(0.1, 0.07), (1.0, 0.5), (2.0, 1.9)])
def test_small_slope_friction_of_second_order_equals_a_sum_over_random_slopes(rule, gradient, slope):
    slope_across = np.sqrt(gradient**2 - slope**2)
    for ratio in (1.0, 0.3):
        gradient_factor = ratio / (1 + ratio**2)
        expected = friction_on_random_slopes(slope * gradient_factor, slope_across * gradient_factor, 0.4, rule=rule)
        keywords = {"rms_gradient": gradient, "rms_slope": slope, "slope_ratio": ratio, "sliding": rule}
        assert gentle_friction(0.4, order=2, **keywords) == pytest.approx(expected, rel=QUADRATURE_TOLERANCE)


def test_first_and_second_order_small_slope_friction_agree_for_tiny_slopes_and_for_grooves():
    for rule in ("opposing", "all"):
        for arguments in ({"rms_gradient": 1e-5}, {"rms_gradient": 0.5, "rms_slope": 0.5}, {"rms_gradient": 2e-9}):
            first_order, second_order = (
                gentle_friction(0.4, sliding=rule, order=order, **arguments) for order in (1, 2)
            )
            assert second_order == pytest.approx(first_order, rel=1e-9)
    steep_options = {"rms_gradient": 0.5, "order": 2}
    assert gentle_friction(0.4, slope_ratio=4.0, **steep_options) == pytest.approx(
        gentle_friction(0.4, slope_ratio=0.25, **steep_options), rel=ROUND_OFF
    )
    assert gentle_friction(0.4, slope_ratio=0.0, **steep_options) == pytest.approx(0.2, rel=ROUND_OFF)
    with pytest.raises(ValueError, match="slope_ratio"):
        gentle_friction(0.4, rms_gradient=0.1, slope_ratio=-1.0)
    with pytest.raises(ValueError, match="order"):
        gentle_friction(0.4, rms_gradient=0.1, order=3)
    with pytest.raises(ValueError, match="rms_slope"):
        gentle_friction(0.4, rms_gradient=0.1, rms_slope=0.2, order=2)


def pair_with_gradient(ratio, seeds, slope):
    """Return a pair of surfaces whose gap has an rms gradient of about `slope`. One body is flatter by `ratio`."""
    steeper = slope / np.hypot(1, 1 / ratio)
    return (
        periodic_body((128, 128), seed=seed, longest=8, shortest=16, slope=item)
        for seed, item in zip(seeds, (steeper, steeper / ratio), strict=True)
    )


def test_half_space_friction_at_steep_slopes_agrees_with_the_second_order_formula():
    slope = 0.9
    values = []
    for seeds in ((1, 2), (3, 4)):
        curve = half_space(
            *pair_with_gradient(1.0, seeds, slope), [0.02 * EFFECTIVE_MODULUS * slope], boundary="periodic",
            sliding="all", direction=range(0, 360, 30),
        )  # fmt: skip
        values.append(curve.friction_coefficient(mu0=0.4).mean())
    expected = gentle_friction(0.4, rms_gradient=slope, sliding="all", order=2)
    assert expected > 1.04 * 0.4
    assert np.mean(values) == pytest.approx(expected, rel=FRICTION_SCATTER_TOLERANCE)


def test_mean_contact_slope_is_independent_of_the_compliance_fraction():
    slope, ratio = 0.9, 3.0
    mean_slopes = []
    for compliance_fraction in (0.0, 0.5, 1.0):
        curve = half_space(
            *pair_with_gradient(ratio, (1, 2), slope),
            [0.02 * EFFECTIVE_MODULUS * slope],
            boundary="periodic",
            compliance_share=compliance_fraction,
            direction=range(0, 360, 30),
        )
        mean_slopes.append((curve.tangential_elastic / curve.normal_elastic).mean())
    assert np.ptp(mean_slopes) < 0.05 * np.mean(mean_slopes)
    # The mean slope of a patch is smaller than the mean slope magnitude of its points.
    assert 0.7 < np.mean(mean_slopes) / (slope / np.sqrt(4 * np.pi) * ratio / (1 + ratio**2)) < 1.0


def test_half_space_results_are_invariant_under_mirroring_and_exchange_of_bodies():
    upper, lower = (periodic_body((2048,), seed=seed, shortest=64) for seed in (3, 4))
    loads = [0.005, 0.02]
    curve = half_space(upper, lower, loads, boundary="periodic", compliance_share=0.3, tolerance=TIGHT_TOLERANCE)
    mirrored_bodies = [Profile(np.roll(body.heights[::-1], 1), spacing=body.spacing) for body in (upper, lower)]
    mirrored_curve = half_space(
        *mirrored_bodies, loads, boundary="periodic", compliance_share=0.3, direction="-x", tolerance=TIGHT_TOLERANCE
    )
    exchanged_bodies = [Profile(-body.heights, spacing=body.spacing) for body in (lower, upper)]
    exchanged_curve = half_space(
        *exchanged_bodies, loads, boundary="periodic", compliance_share=0.7, direction="-x", tolerance=TIGHT_TOLERANCE
    )
    for name in ("contact_count", "contact_area", "normal_elastic", "tangential_elastic", "normal_frictional"):
        for transformed_curve in (mirrored_curve, exchanged_curve):
            np.testing.assert_allclose(getattr(transformed_curve, name), getattr(curve, name), rtol=1e-6, err_msg=name)


def test_half_space_solution_of_a_map_of_equal_rows_equals_the_solution_of_the_profile_in_each_row():
    lines = [periodic_body((256,), seed=seed, shortest=16) for seed in (1, 2)]
    wide_surfaces = [Surface(np.tile(line.heights, (8, 1)), spacing=(1 / 8, 1 / 256)) for line in lines]
    line_curve = half_space(*lines, [0.01], boundary="periodic", tolerance=TIGHT_TOLERANCE)
    surface_curve = half_space(
        *wide_surfaces, [0.01], boundary="periodic", direction=[0.0, 90.0], tolerance=TIGHT_TOLERANCE
    )
    np.testing.assert_allclose(surface_curve.contact(0).pressure[3], line_curve.contact(0).pressure, atol=1e-6)
    np.testing.assert_allclose(surface_curve.tangential_elastic[0], line_curve.tangential_elastic, rtol=1e-6)
    np.testing.assert_array_equal(surface_curve.contact_count, line_curve.contact_count)
    assert surface_curve.friction_coefficient(mu0=0.4).shape == (2, 1)
    assert (surface_curve.status(mu0=0.4) == "ok").all()
    np.testing.assert_allclose(surface_curve.tangential_load(mu0=0.4)[1], 0.0, atol=1e-9)


def test_contact_patches_connect_across_periodic_edges():
    n = 32
    x = np.arange(n) / n
    lower = Surface(0.01 * (np.cos(2 * np.pi * x)[:, None] + np.cos(2 * np.pi * x)[None, :]), spacing=1 / n)
    periodic_curve = half_space(flat_like(lower), lower, [0.005], boundary="periodic")
    free_curve = half_space(flat_like(lower), lower, [0.005])
    assert periodic_curve.contact_count[0] == 1
    assert free_curve.contact_count[0] > 1
    assert periodic_curve.contact(0).patches.max() == 1
    assert (periodic_curve.contact(0).patches > 0).sum() == (periodic_curve.contact(0).pressure > 0).sum()


def test_half_space_raises_an_error_if_the_tolerance_is_below_the_round_off_error():
    lower = periodic_body((64, 64))
    with pytest.raises(RuntimeError, match="no solution at"):
        half_space(flat_like(lower), lower, [0.01], boundary="periodic", tolerance=1e-18)


def test_periodic_flats_have_uniform_pressure():
    flat = Surface(np.full((8, 12), 2.0), spacing=1.0)
    curve = half_space(flat, flat, [96.0], boundary="periodic")
    np.testing.assert_allclose(curve.contact(0).pressure, 1.0, rtol=ROUND_OFF)
    np.testing.assert_allclose(curve.contact_area, 96.0, rtol=ROUND_OFF)


EXAMPLE_PROFILE = Profile(np.arange(8.0) % 3, spacing=1.0)
EXAMPLE_MAP = Surface(np.arange(64.0).reshape(8, 8) % 5, spacing=1.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"lower": EXAMPLE_MAP}, "both be profiles or both surfaces"),
        ({"lower": "LINE"}, "must be a Profile or a Surface"),
        ({"lower": Profile(np.zeros(9), spacing=1.0)}, "equal shapes"),
        ({"lower": Profile(np.zeros(8), spacing=2.0)}, "equal spacings"),
        ({"loads": [0.0, 1.0]}, "loads must be above 0"),
        ({"loads": [2.0, 1.0]}, "strictly increasing"),
        ({"loads": []}, "loads must be above 0"),
        ({"loads": [np.nan]}, "loads must be finite"),
        ({"loads": 1.0}, "loads must have 1 dimension"),
        ({"effective_modulus": 0.0}, "effective_modulus"),
        ({"boundary": "open"}, "boundary must be one of"),
        ({"compliance_share": 1.5}, "compliance_share"),
        ({"hardness": -1.0}, "hardness"),
        ({"hardness": 0.1}, r"below \S+ mN, the hardness times the nominal area, got \S+ mN$"),
        ({"direction": "x"}, "direction"),
        ({"direction": 45.0}, "direction"),
        ({"direction": ["+x"]}, "direction"),
        ({"upper": EXAMPLE_MAP, "lower": EXAMPLE_MAP, "direction": []}, "direction"),
        ({"upper": EXAMPLE_MAP, "lower": EXAMPLE_MAP, "direction": ["up"]}, "direction"),
        ({"sliding": "some"}, "sliding must be one of"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"progress": "x"}, "progress must be a function of three arguments or None, got 'x'"),
    ],
)
def test_half_space_rejects_invalid_arguments(arguments, message):
    options = {"upper": EXAMPLE_PROFILE, "lower": EXAMPLE_PROFILE, "loads": [1.0]} | arguments
    with pytest.raises(ValueError, match=message):
        half_space(**options)


def test_half_space_load_curve_is_read_only_and_rejects_invalid_indices():
    curve = half_space(flat_like(EXAMPLE_PROFILE), EXAMPLE_PROFILE, [1.0])
    assert isinstance(curve, HalfSpaceCurve)
    with pytest.raises(ValueError, match="read-only"):
        curve.load[0] = 2.0
    for method in (curve.at, curve.contact):
        for index in ("x", None, 0.5, 1):
            with pytest.raises(ValueError, match="index must be at least -1 and below 1, the number of loads"):
                method(index)


@pytest.mark.parametrize("load", [0.02, 0.05, 0.1])
def test_ball_on_a_level_flat_has_no_opposing_contact_in_any_direction(load):
    # The only patch is level. A residual asymmetry of the solution must not turn it into an opposing patch.
    x = (np.arange(65) - 32) * 0.05
    ball = Surface(-(x**2 + x[:, np.newaxis] ** 2) / 20, spacing=0.05)
    flat = Surface(np.zeros((65, 65)), spacing=0.05)
    curve = half_space(flat, ball, [load], direction=[0, 90, 180, 270])
    assert (curve.friction_coefficient(mu0=0.4) == 0).all()
    all_contacts_curve = curve.with_sliding("all")
    assert np.allclose(all_contacts_curve.friction_coefficient(mu0=0.4), 0.4, rtol=1e-2)
    assert (curve.sliding, all_contacts_curve.sliding) == ("opposing", "all")
    assert np.array_equal(curve.direction, [0, 90, 180, 270])


@pytest.mark.parametrize(("num_dims", "directions"), [(1, ["+x", "-x"]), (2, [0.0, 30.0, 180.0]), (2, [90.0])])
def test_contact_sums_for_all_directions_and_sliding_rules_equal_sums_of_single_load_curves(num_dims, directions):
    rng = np.random.default_rng(5)
    body_class = Profile if num_dims == 1 else Surface
    upper, lower = (body_class(rng.normal(0, 0.01, (48,) * num_dims), spacing=0.1) for _ in range(2))
    first_direction = "+x" if num_dims == 1 else [0.0, 30.0, 180.0]
    curve = half_space(upper, lower, [0.01, 0.03, 0.1], direction=first_direction, hardness=8.0)
    sums = curve.compute_directed_sums(directions, ["all", "opposing"])
    for rule, sliding in enumerate(["all", "opposing"]):
        for index, direction in enumerate(directions):
            curve_of_motion = curve.with_direction(direction).with_sliding(sliding)
            for name, values in sums.items():
                assert np.array_equal(values[rule, index], getattr(curve_of_motion, name))
    assert np.ptp(sums["tangential_elastic"]) > 0
    assert (sums["normal_frictional"][0] != sums["normal_frictional"][1]).any()


def test_gap_is_zero_at_all_contact_points_even_if_pressures_reach_the_hardness():
    x = (np.arange(33) - 16) * 0.05
    ball = Surface(-(x**2 + x[:, np.newaxis] ** 2) / 20, spacing=0.05)
    curve = half_space(Surface(np.zeros((33, 33)), spacing=0.05), ball, [1e-4], hardness=1e-3)
    assert curve.load_share_at_hardness[0] > 0.5
    contact = curve.contact(0)
    assert contact.gap[contact.pressure > 0].max() <= 1e-6


@pytest.mark.parametrize("periodic", [True, False])
def test_half_space_displacements_equal_a_direct_sum_for_any_number_of_threads(periodic):
    grids = _core.HalfSpaceGrids((801, 760), (0.1, 0.2), effective_modulus=EFFECTIVE_MODULUS, periodic=periodic)
    pressure = np.random.default_rng(4).random((801, 760))
    pressure[np.random.default_rng(5).permutation(801)[:400]] = 0.0
    expected = dense_half_space.compute_displacement(pressure, (0.1, 0.2), EFFECTIVE_MODULUS, periodic=periodic)
    result = grids.displacement(pressure)
    np.testing.assert_allclose(result, expected, rtol=0, atol=LARGE_GRID_TOLERANCE * np.abs(expected).max())
    for threads in (2, 3):
        assert np.array_equal(grids.displacement(pressure, threads=threads), result)


def test_half_space_problems_on_equal_grids_share_kernels():
    first_body, second_body = (periodic_body((32, 32), seed=seed) for seed in (1, 2))
    first_curve = half_space(flat_like(first_body), first_body, [0.01])
    second_curve = half_space(flat_like(second_body), second_body, [0.02])
    assert first_curve._problem.grids is second_curve._problem.grids
    stiffer_curve = half_space(flat_like(second_body), second_body, [0.02], effective_modulus=2 * EFFECTIVE_MODULUS)
    assert stiffer_curve._problem.grids is not first_curve._problem.grids
    separate_solver = make_solver(first_curve._problem.gap, (1 / 32, 1 / 32), periodic=False, tolerance=1e-6)
    assert np.array_equal(separate_solver.at(0.01).pressure, first_curve.contact(0).pressure.ravel())


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_half_space_solutions_for_several_loads_equal_solutions_for_single_loads(boundary):
    """Check that starting from the solution at a nearby load changes a solution by less than the tolerance."""
    body = periodic_body((48, 40))
    upper = flat_like(body)
    loads = np.array([1.0, 1.1, 1.25, 3.0]) * 0.02
    curve = half_space(upper, body, loads, boundary=boundary)
    assert (curve.error <= 1e-6).all()
    for i, load in enumerate(loads):
        single_load_curve = half_space(upper, body, [load], boundary=boundary)
        assert curve.approach[i] == pytest.approx(single_load_curve.approach[0], rel=SOLUTION_TOLERANCE)
        assert curve.contact_area[i] == pytest.approx(single_load_curve.contact_area[0], rel=1e-3)


@pytest.mark.parametrize(("shape", "boundary"), [((256,), "periodic"), ((48, 40), "periodic"), ((48, 40), "free")])
def test_solution_at_an_approach_equals_solution_at_the_load_of_that_approach(shape, boundary):
    body = periodic_body(shape)
    upper = flat_like(body)
    expected = np.array([0.05, 0.2, 0.6]) * (body.heights.max() - body.heights.mean())
    curve = half_space(upper, body, approaches=expected, boundary=boundary)
    height_deviation = body.heights.std()
    assert np.abs(curve.approach - expected).max() <= 1e-6 * max(height_deviation, 1.0)
    assert (curve.error <= 1e-6).all()
    curve_at_loads = half_space(upper, body, curve.load, boundary=boundary)
    assert curve_at_loads.approach == pytest.approx(expected, rel=SOLUTION_TOLERANCE)
    assert curve_at_loads.contact_area == pytest.approx(curve.contact_area, rel=1e-3)


@pytest.mark.parametrize("shape", [(64,), (24, 20)])
@pytest.mark.parametrize("remaining_fraction", [1e-2, 1e-6, 1e-14])
def test_half_space_solution_reaches_requested_approaches_up_to_full_contact(shape, remaining_fraction):
    body = periodic_body(shape, longest=1, shortest=5)
    full_approach = (body.heights.max() - body.heights).mean()
    curve = half_space(
        flat_like(body), body, approaches=[full_approach * (1 - remaining_fraction)], boundary="periodic"
    )
    assert abs(curve.approach[0] - full_approach * (1 - remaining_fraction)) <= 1.01e-6 * body.heights.std()


def test_approach_of_a_sphere_on_a_half_space_equals_hertz_solution():
    """Compare with the approach of distant points, δ = (9 F²/(16 E*² R))^(1/3)."""
    ball = create_paraboloid(96, 2.0, (5.0, 5.0))
    curve = half_space(ball, flat_like(ball), approaches=[0.05])
    force, _ = hertz_sphere(0.05, 5.0, EFFECTIVE_MODULUS)
    assert curve.load[0] == pytest.approx(force, rel=BALL_TOLERANCE)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "half_space requires either loads or approaches"),
        ({"loads": [1.0], "approaches": [1.0]}, "half_space requires either loads or approaches"),
        ({"approaches": [0.0]}, "approaches must be above 0 µm and strictly increasing"),
        ({"approaches": [2e-3, 1e-3]}, "approaches must be above 0 µm and strictly increasing"),
        ({"approaches": [1e-3], "boundary": "free"}, "approaches must not be given for a free half-plane"),
        ({"approaches": [1e-3], "hardness": 1.0}, "approaches must not be given for surfaces with a hardness"),
        ({"approaches": [1.0]}, "approaches must be below .* at which all points are in contact"),
    ],
)
def test_half_space_rejects_invalid_approaches(arguments, message):
    body = periodic_body((64,))
    with pytest.raises(ValueError, match=message):
        half_space(flat_like(body), body, **({"boundary": "periodic"} | arguments))


@pytest.mark.parametrize("spacing", [1e-320, (0.1, 1e-13), (1e-160, 1e-160), 1e300])
def test_half_space_rejects_invalid_spacing(spacing):
    heights = periodic_body((16, 16)).heights
    with pytest.raises(ValueError, match="spacing must"):
        half_space(Surface(0 * heights, spacing=spacing), Surface(heights, spacing=spacing), [1e-3])


def test_half_space_needs_few_iterations_for_large_maps_with_long_wavelengths():
    # Directions that push points beyond their bounds would need 44 iterations in total, because steps would fail.
    upper, lower = (
        Surface(
            self_affine_surface(seed, hurst_exponent=0.8, rms=0.3, shape=(1024, 1024), spacing=0.5).heights[:768, :768],
            spacing=0.5,
        )
        for seed in (1, 2)
    )
    loads = [pressure * upper.heights.size * 0.25 for pressure in (0.025, 0.05)]
    curve = half_space(upper, lower, loads, effective_modulus=78.7)
    assert curve.iterations.sum() <= 36


def test_progress_callback_reports_iterations_and_can_cancel_the_solution():
    body = periodic_body((32, 32))
    events = []
    half_space(
        flat_like(body), body, [0.01, 0.1], boundary="periodic", progress=lambda *each: events.append(each),
        tolerance=1e-6,
    )  # fmt: skip
    assert {num_solved for num_solved, _, _ in events} == {0, 1}
    assert events[0][1] == 1
    assert all(relative_error > 1e-6 for _, _, relative_error in events)

    def cancel_solution(num_solved, iteration, relative_error):
        raise InterruptedError

    with pytest.raises(InterruptedError):
        half_space(flat_like(body), body, [0.01], progress=cancel_solution)


def test_half_space_solver_stops_soon_after_ctrl_c():
    """Send the signal long before the end of the solution, while the main thread is in the compiled core."""
    body = periodic_body((512, 512), shortest=128)
    signal_times = []

    def send_interrupt():
        signal_times.append(time.process_time())
        signal.raise_signal(signal.SIGINT)

    def solve():
        timer.start()  # Start the timer inside the block, so that the block also handles an early signal.
        half_space(flat_like(body), body, np.geomspace(0.001, 0.5, 200))

    timer = threading.Timer(0.3, send_interrupt)
    with pytest.raises(KeyboardInterrupt):
        solve()
    timer.join()
    assert time.process_time() - signal_times[0] < MAX_SECONDS_AFTER_INTERRUPT


def test_half_space_solver_converges_although_its_extrapolated_steps_are_very_long():
    """Solve a half-plane problem in which extrapolated steps are about thirty times as long as trial steps."""
    study = Study.named("figure6-half-plane")
    dimension = float(study.surfaces.fractal_dimensions()[7])
    upper, lower = pair_of(study, 14, fractal_dimension=dimension, amplitude=float(study.surfaces.amplitudes()[0]))
    assert half_space(upper, lower, [0.1389495494373138]).error[0] <= 1e-6


@pytest.mark.parametrize("height", [1e157, 1e100])
def test_half_space_rejects_gaps_far_larger_than_the_length_of_the_bodies(height):
    body = periodic_body((32, 32), shortest=8)
    high_body = Surface(body.heights * (height / np.ptp(body.heights)), spacing=body.spacing)
    with pytest.raises(
        ValueError, match=r"gap .* must be at most .* µm \(1e\+06 times the length of the bodies\), got .* µm"
    ):
        half_space(flat_like(body), high_body, [0.01])


def test_onset_method_rejects_mu0_and_tau0_that_are_both_zero():
    body = periodic_body((32, 32), shortest=8)
    with pytest.raises(ValueError, match="must not both be 0"):
        half_space(flat_like(body), body, [0.01]).onset(0, mu0=1e-160)


@pytest.mark.parametrize(("boundary", "hardness"), [("free", None), ("periodic", None), ("free", 1.0)])
def test_half_space_results_are_bit_identical_for_any_thread_count(boundary, hardness):
    body = periodic_body((150, 128))
    single_thread_curve = half_space(flat_like(body), body, [0.1], boundary=boundary, hardness=hardness)
    with scipy.fft.set_workers(3):
        three_thread_curve = half_space(flat_like(body), body, [0.1], boundary=boundary, hardness=hardness)
    assert np.array_equal(single_thread_curve.contact(0).pressure, three_thread_curve.contact(0).pressure)


def test_closure_of_a_masked_surface_does_not_reuse_closure_of_the_complete_surface():
    body = periodic_body((32, 32))
    is_missing = np.zeros((32, 32), bool)
    is_missing[:8] = True
    masked_body = Surface(body.heights, spacing=body.spacing, missing=is_missing)
    complete_curve, masked_curve, repeated_curve = (
        half_space(flat_like(item), item, [0.05]) for item in (body, masked_body, body)
    )
    assert complete_curve._problem.grids is masked_curve._problem.grids
    assert complete_curve.closure[0] == repeated_curve.closure[0] != masked_curve.closure[0]
    uniform_displacement = complete_curve._problem.grids.displacement(np.ones((32, 32)))
    mean_displacement = (complete_curve.contact(0).pressure * uniform_displacement).mean()
    assert complete_curve.closure[0] == pytest.approx(complete_curve.approach[0] - mean_displacement, rel=1e-12)
    mean_displacement = (
        masked_curve.contact(0).pressure * masked_curve._problem.grids.displacement(np.where(is_missing, 0.0, 1.0))
    ).sum()
    assert masked_curve.closure[0] == pytest.approx(
        masked_curve.approach[0] - mean_displacement / (~is_missing).sum(), rel=1e-12
    )


def test_half_space_load_curve_and_onset_result_can_be_pickled_and_copied():
    surface_options = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (32, 32), "spacing": 0.1}
    curve = half_space(
        *(self_affine_surface(3, side=side, **surface_options) for side in ("upper", "lower")), [0.01, 0.02]
    )
    onset = curve.onset(1, mu0=0.3, steps=3)
    for curve_copy in (pickle.loads(pickle.dumps(curve)), copy.deepcopy(curve)):
        assert (curve_copy.contact(1).pressure == curve.contact(1).pressure).all()
        assert (curve_copy.unloading_stiffness == curve.unloading_stiffness).all()
    for curve_copy in (pickle.loads(pickle.dumps(onset)), copy.deepcopy(onset)):
        assert (curve_copy.tangential_load == onset.tangential_load).all()
        assert curve_copy.energy_lost([0.5 * onset.sliding_load]) == onset.energy_lost([0.5 * onset.sliding_load])


def test_solver_has_one_thread_while_another_thread_imports_scipy_fft(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.fft", types.ModuleType("scipy.fft"))
    assert solver_thread_count() == 1


LIMITED_THREADS_SCRIPT = """
import re, resource
import numpy as np
import scipy.fft
from stiction import half_space
heights = np.random.default_rng(1).normal(0, 0.01, (2, 64, 64))
with scipy.fft.set_workers(4):
    expected = half_space(*heights, [1.0], spacing=0.1, effective_modulus=10, boundary="periodic")
    size = 1024 * int(re.search("VmSize:[^0-9]+([0-9]+) kB", open("/proc/self/status").read())[1])
    resource.setrlimit(resource.RLIMIT_AS, (size + 3 * 2**29, size + 3 * 2**29))
    curve = half_space(*heights, [1.0], spacing=0.1, effective_modulus=10, boundary="periodic")
print(curve.contact_area.tobytes() == expected.contact_area.tobytes())
"""
"""Script in which only the first of three threads can start: each takes 1 GiB, and 1.5 GiB are left."""


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of the address space applies to threads on Linux only")
def test_half_space_uses_fewer_threads_if_the_system_cannot_create_all_threads():
    import resource

    stack_size = 2**30
    if 0 <= resource.getrlimit(resource.RLIMIT_STACK)[1] < stack_size:
        pytest.skip("the stack size is limited")
    completed = subprocess.run(
        [sys.executable, "-c", LIMITED_THREADS_SCRIPT],
        check=False, capture_output=True, text=True, env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        preexec_fn=lambda: resource.setrlimit(
            resource.RLIMIT_STACK, (stack_size, resource.getrlimit(resource.RLIMIT_STACK)[1])
        ),
    )  # fmt: skip
    assert (completed.returncode, completed.stdout) == (0, "True\n"), completed.stderr
