import pickle

import numpy as np
import pytest
import stiction._core as _core
from reference import dense_half_space, dense_onset
from scipy.integrate import quad
from stiction import (
    FourParameterIwan,
    HertzCylinder,
    JacksonGreen,
    Profile,
    Surface,
    candidates,
    contacts,
    half_space,
    hertz_ellipse,
    hertz_line,
    press,
    random_phases,
    weierstrass_mandelbrot,
)
from stiction.mechanics.presliding import fit_iwan, fit_lugre
from support.rough_surfaces import flat_like, periodic_body, rough_maps

EFFECTIVE_MODULUS = 10.0
ROUND_OFF = 1e-12
# Error relative to the largest value of a solution by dense matrices, at a solver tolerance of 1e-6.
DENSE_SOLUTION_TOLERANCE = 1e-6
MINDLIN_TOLERANCE = 1e-3  # displacement error, relative to that of a ball whose contact radius is 24 points
TRACTION_TOLERANCE = 0.01
LOAD_FRACTIONS = [0.05, 0.1, 0.3, 0.6, 0.9, 0.99]


def create_paraboloid(n, extent, radii):
    """Return a paraboloid whose summit lies between grid points."""
    x = (np.arange(n) - n / 2 + 0.31) * extent / n
    return Surface(-(x[:, None] ** 2 / (2 * radii[0]) + x[None, :] ** 2 / (2 * radii[1])), spacing=extent / n)


def create_rough_body(shape, seed=4, slope=0.1):
    """Return a rough body of unit size, with wavelengths from half of its size down to 8 points."""
    return periodic_body(shape, seed=seed, longest=2, shortest=max(shape[-1] // 8, 4), slope=slope)


def compute_load_at_relative_pressure(body, fraction):
    """Return the load on a unit length or a unit square at a mean pressure of `fraction` times E* h'."""
    steps = [np.diff(body.heights, axis=axis) * body.heights.shape[axis] for axis in range(body.heights.ndim)]
    return fraction * EFFECTIVE_MODULUS * np.sqrt(sum(np.mean(np.square(step)) for step in steps))


# ---- The half-space against closed forms ----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ball_curve_and_radius():
    lower = create_paraboloid(96, 1.0, (1.0, 1.0))
    radius = 0.25
    return half_space(flat_like(lower), lower, [4 / 3 * EFFECTIVE_MODULUS * radius**3], tolerance=1e-8), radius


def test_onset_of_sliding_of_a_ball_equals_cattaneo_mindlin_solution(ball_curve_and_radius):
    curve, radius = ball_curve_and_radius
    for poisson in (0.0, 0.3, (0.2, 0.5)):
        onset = curve.onset(0, mu0=0.3, poisson=poisson, steps=LOAD_FRACTIONS)
        poisson_ratios = np.broadcast_to(poisson, 2)
        ratio = np.mean((2 - poisson_ratios) / (2 * (1 - poisson_ratios)))
        load_fractions = np.array(LOAD_FRACTIONS)
        # The displacement at sliding is mu0 times the approach, which is radius² because R = 1.
        sliding_displacement = 0.3 * radius**2 * ratio
        stick_radius_ratio = (1 - load_fractions) ** (1 / 3)
        assert onset.sliding_load == pytest.approx(0.3 * curve.load[0], rel=1e-9)
        assert onset.displacement_at_sliding == pytest.approx(sliding_displacement, rel=MINDLIN_TOLERANCE)
        np.testing.assert_allclose(
            onset.displacement, sliding_displacement * (1 - stick_radius_ratio**2), rtol=MINDLIN_TOLERANCE
        )
        assert onset.stiffness == pytest.approx(2 * EFFECTIVE_MODULUS * radius / ratio, rel=MINDLIN_TOLERANCE)
        stick_radius = radius * np.sqrt(1 - onset.slipped_area)
        assert np.abs(stick_radius - radius * stick_radius_ratio).max() < 1 / 96
        assert np.abs(onset.slipped_load - (1 - stick_radius_ratio**2) ** 1.5).max() < 0.01
        # The energy loss follows Johnson, Contact Mechanics (1985), eq. 7.57.
        energy_loss = 24 / 5 * (1 - (1 - load_fractions) ** (5 / 3)) - 4 * load_fractions * (
            1 + (1 - load_fractions) ** (2 / 3)
        )
        energy_loss *= onset.sliding_load * sliding_displacement
        np.testing.assert_allclose(
            onset.energy_lost(onset.tangential_load)[2:], energy_loss[2:], rtol=5 * MINDLIN_TOLERANCE
        )


def test_slip_under_a_ball_spreads_from_the_contact_edge_inwards(ball_curve_and_radius):
    curve, radius = ball_curve_and_radius
    x = (np.arange(96) - 48 + 0.31) / 96
    distance = np.hypot(x[:, None], x).ravel()
    onset = curve.onset(0, mu0=0.3, steps=50)
    slip_loads = onset.slip_load() / onset.sliding_load
    is_in_contact = curve.contact(0).pressure.ravel() > 0
    assert np.isnan(slip_loads[~is_in_contact]).all()
    is_inside = is_in_contact & (distance < radius)
    errors = slip_loads[is_inside] - (1 - (distance[is_inside] / radius) ** 3)
    # The tolerated error is one load step, plus one grid cell at the edge of the stick zone.
    assert np.abs(errors).max() < 1 / 50 + 3 / (96 * radius)
    assert np.abs(np.median(errors)) < 1 / 50
    early_slip_loads = curve.onset(0, mu0=0.3, steps=[0.2, 0.3]).slip_load()
    assert np.isnan(early_slip_loads[distance < 0.5 * radius]).all()


def test_onset_of_sliding_of_a_cylinder_equals_cattaneo_solution():
    n = 1024
    x = (np.arange(n) - n / 2 + 0.31) / n
    lower = Profile(-(x**2) / 2, spacing=1 / n)
    curve = half_space(flat_like(lower), lower, [0.2], tolerance=1e-8)
    half_width, max_pressure = hertz_line(load=0.2, radius=1.0, effective_modulus=EFFECTIVE_MODULUS)
    onset = curve.onset(0, mu0=0.3, steps=LOAD_FRACTIONS)
    for i, load_fraction in enumerate(LOAD_FRACTIONS):
        stick_half_width = half_width * np.sqrt(1 - load_fraction)
        q = 0.3 * max_pressure * np.sqrt(np.maximum(1 - (x / half_width) ** 2, 0))
        q -= (
            0.3 * max_pressure * stick_half_width / half_width * np.sqrt(np.maximum(1 - (x / stick_half_width) ** 2, 0))
        )
        assert np.abs(onset.traction(i) - q).sum() < TRACTION_TOLERANCE * q.sum()
        assert abs(half_width * (1 - onset.slipped_area[i]) - stick_half_width) < 1 / n
    # The displacement of a free half-plane is undefined, but slip is defined and dissipates energy.
    assert np.isnan(onset.displacement).all()
    assert np.isnan(onset.displacement_at_sliding)
    assert np.isnan(onset.stiffness)
    assert (np.diff(onset.energy_lost(onset.tangential_load)) > 0).all()
    with pytest.raises(ValueError, match="must not be given for a free half-plane"):
        curve.onset(0, mu0=0.3, displacements=[0.1])
    with pytest.raises(ValueError, match="displacements of a free half-plane are infinite"):
        onset.iwan()


def test_stick_area_of_an_elliptical_contact_is_a_similar_ellipse():
    radii = (0.5, 1.5)
    lower = create_paraboloid(128, 1.0, radii)
    load, _, axes = hertz_ellipse(0.04, *radii, EFFECTIVE_MODULUS)
    curve = half_space(flat_like(lower), lower, [float(load)], tolerance=1e-8)
    onset = curve.onset(0, mu0=0.2, poisson=0.0, steps=LOAD_FRACTIONS)
    load_fractions = np.array(LOAD_FRACTIONS)
    np.testing.assert_allclose(
        onset.displacement, 0.2 * 0.04 * (1 - (1 - load_fractions) ** (2 / 3)), rtol=2 * MINDLIN_TOLERANCE
    )
    pressure = curve.contact(0).pressure.ravel()
    for i, stick_axis_ratio in enumerate((1 - load_fractions) ** (1 / 3)):
        is_sticking = ((pressure > 0) & (onset.traction(i) < 0.2 * pressure)).reshape(128, 128)
        for axis, semi_axis in enumerate(axes):
            assert abs(is_sticking.any(axis=1 - axis).sum() / 2 - stick_axis_ratio * semi_axis * 128) <= 1


# ---- The half-space against a slow program --------------------------------------------------------------------------


def compute_traction_bound(curve, mu0, tau0):
    """Return contact points, bound of the traction, pressure and true area of the model.

    Slopes contribute at most 1e-8.
    """
    pressure = curve.contact(0).pressure
    is_in_contact = pressure > 0
    periodic = curve._problem.grids.periodic
    num_free_edges = np.zeros(pressure.shape)
    for axis in range(pressure.ndim):
        for offset in (-1, 1):
            neighbour_in_contact = np.roll(is_in_contact, offset, axis)
            if not periodic:
                edge = [slice(None)] * pressure.ndim
                edge[axis] = 0 if offset == 1 else -1
                neighbour_in_contact[tuple(edge)] = is_in_contact[tuple(edge)]
            num_free_edges += ~neighbour_in_contact
    area_fraction = 1 - (0.19 if pressure.ndim == 1 else (np.pi - 1 + np.log(2)) / 24) * num_free_edges
    return (
        np.argwhere(is_in_contact),
        (mu0 * pressure + tau0 * area_fraction)[is_in_contact],
        pressure[is_in_contact],
        area_fraction[is_in_contact],
    )


@pytest.mark.parametrize("shape", [(32, 32), (24, 32), (256,)])
@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize(("mu0", "tau0"), [(0.3, 0.0), (0.0, 0.02), (0.2, 0.004)])
def test_onset_of_sliding_agrees_with_active_set_solver(shape, boundary, mu0, tau0):
    lower = create_rough_body(shape, slope=1e-4)
    tau0 *= 1e-2  # The adhesive strength must have the order of magnitude of the pressures.
    curve = half_space(
        flat_like(lower), lower, [compute_load_at_relative_pressure(lower, 0.05)], boundary=boundary, tolerance=1e-10
    )
    points, bound, pressure, fraction = compute_traction_bound(curve, mu0, tau0)
    assert 20 < bound.size < 600
    periodic = boundary == "periodic"
    spacing = tuple(1 / n for n in shape) if len(shape) == 1 else lower.spacing
    compliance = dense_half_space.influence_matrix(shape, spacing, EFFECTIVE_MODULUS, periodic=periodic, points=points)
    load_fractions = [0.1, 0.5, 0.9]
    onset = curve.onset(0, mu0=mu0, tau0=tau0, poisson=0.0, steps=load_fractions)
    accurate_onset = curve.onset(0, mu0=mu0, tau0=tau0, poisson=0.0, steps=load_fractions, tolerance=1e-10)
    assert onset.sliding_load == pytest.approx(bound.sum() * np.prod(spacing), rel=1e-8)
    for i, load_fraction in enumerate(load_fractions):
        q, displacement = dense_onset.solve_traction(compliance, bound, load_fraction * bound.sum())
        if len(shape) == 2 or periodic:
            assert onset.displacement[i] == pytest.approx(displacement, rel=DENSE_SOLUTION_TOLERANCE)
        expected_traction = np.zeros(shape)
        expected_traction[tuple(points.T)] = q
        assert (
            np.abs(accurate_onset.traction(i) - expected_traction.ravel()).max()
            < DENSE_SOLUTION_TOLERANCE * bound.max()
        )
        is_slipping = q == bound
        assert accurate_onset.slipped_area[i] == pytest.approx(fraction[is_slipping].sum() / fraction.sum(), abs=1e-7)
        assert accurate_onset.slipped_load[i] == pytest.approx(pressure[is_slipping].sum() / pressure.sum(), abs=1e-7)
        energy_loss = 4 * bound @ (displacement - compliance @ q) * np.prod(spacing)
        assert accurate_onset.energy_lost(onset.tangential_load[i]) == pytest.approx(
            energy_loss,
            rel=DENSE_SOLUTION_TOLERANCE,
            abs=DENSE_SOLUTION_TOLERANCE * abs(load_fraction * bound.sum() * displacement * np.prod(spacing)),
        )


def test_energy_loss_from_masing_rule_equals_loss_in_a_simulated_cycle():
    lower = create_rough_body((16, 16), slope=1e-4)
    curve = half_space(flat_like(lower), lower, [compute_load_at_relative_pressure(lower, 0.1)], tolerance=1e-10)
    points, bound, _, _ = compute_traction_bound(curve, 0.3, 0.0)
    assert bound.size > 40
    compliance = dense_half_space.influence_matrix(
        (16, 16), lower.spacing, EFFECTIVE_MODULUS, periodic=False, points=points
    )
    for load_fraction in (0.5, 0.9):
        onset = curve.onset(0, mu0=0.3, poisson=0.0, steps=[load_fraction])
        max_displacement = onset.displacement[0]
        displacements = max_displacement * np.concatenate(
            [np.linspace(0, 1, 6)[1:], np.linspace(1, -1, 11)[1:], np.linspace(-1, 1, 11)[1:]]
        )
        loads, energy_loss = dense_onset.simulate_displacement_steps(compliance, bound, displacements)
        cell_area = np.prod(lower.spacing)
        assert loads[4] * cell_area == pytest.approx(onset.tangential_load[0], rel=1e-5)
        assert loads[14] == pytest.approx(-loads[4], rel=1e-6)
        assert loads[-1] == pytest.approx(loads[4], rel=1e-6)
        assert energy_loss[5:].sum() * cell_area == pytest.approx(
            onset.energy_lost(onset.tangential_load[0]), rel=TRACTION_TOLERANCE
        )
        # By Masing's rule the unloading branch is the loading curve, enlarged by a factor of two.
        onset_at_half = curve.onset(0, mu0=0.3, poisson=0.0, displacements=[max_displacement / 2])
        assert (loads[4] - loads[9]) / 2 * cell_area == pytest.approx(onset_at_half.tangential_load[0], rel=1e-5)


# ---- The half-space: identities and limits --------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["periodic", "free"])
def half_space_curve(request):
    lower = create_rough_body((128, 128))
    load = compute_load_at_relative_pressure(lower, 0.02)
    return half_space(flat_like(lower), lower, [0.3 * load, 0.6 * load, load], boundary=request.param, tolerance=1e-8)


def test_sliding_load_equals_sum_of_friction_at_all_contacts(half_space_curve):
    onset = half_space_curve.onset(1, mu0=0.3, tau0=0.05)
    max_friction = 0.3 * half_space_curve.normal_elastic[1] + 0.05 * half_space_curve.contact_area[1]
    assert onset.sliding_load == pytest.approx(max_friction, rel=1e-9)
    assert onset.tangential_load[-1] == onset.sliding_load
    assert onset.traction(-1).sum() * half_space_curve._problem.cell_area == pytest.approx(max_friction, rel=1e-9)
    # For small slopes, the sliding load equals that of the rule "all", except for terms of second order.
    max_friction = half_space_curve.with_sliding("all").tangential_load(mu0=0.3, tau0=0.05)[1]
    assert onset.sliding_load == pytest.approx(max_friction, rel=0.1**2)
    assert onset.slipped_area[-1] == onset.slipped_load[-1] == 1
    assert onset.displacement[-1] == onset.displacement_at_sliding


@pytest.mark.parametrize("slopes", [(0.2,), (0.3, 0.4)])
def test_traction_at_sliding_includes_tau0_times_the_area_along_the_slope(slopes):
    """Press two inclined planes, equal within 1e-9 µm, whose interface has one slope and is completely in contact."""
    grid = np.indices((24,) * len(slopes)) * 0.1
    heights = sum(slope * coordinate for slope, coordinate in zip(slopes, grid, strict=True))
    create_body = Profile if len(slopes) == 1 else Surface
    rough_heights = heights + np.random.default_rng(2).uniform(0, 1e-9, heights.shape)
    curve = half_space(create_body(rough_heights, spacing=0.1), create_body(heights, spacing=0.1), [1.0])
    onset = curve.onset(0, mu0=0.3, tau0=0.05, steps=2)
    bound = 0.3 * curve.contact(0).pressure + 0.05 * np.sqrt(1 + np.square(slopes).sum())
    np.testing.assert_allclose(onset.traction(-1), bound.ravel(), rtol=1e-8)
    assert onset.sliding_load == pytest.approx(0.3 * 1.0 + 0.05 * curve.contact_area[0], rel=1e-9)
    assert (onset.traction(0) <= onset.traction(-1)).all()


def test_onset_displacement_and_slipped_area_increase_with_tangential_load(half_space_curve):
    onset = half_space_curve.onset(0, mu0=0.3, tau0=0.02, steps=40)
    for name in ("tangential_load", "displacement", "slipped_area", "slipped_load"):
        assert (np.diff(getattr(onset, name)) >= 0).all(), name
    assert (np.diff(onset.displacement / onset.tangential_load) > 0).all()
    assert (np.diff(onset.energy_lost(onset.tangential_load)) >= 0).all()
    bound = onset.traction(-1)
    for i in range(40):
        assert ((onset.traction(i) >= 0) & (onset.traction(i) <= bound)).all()
        assert onset.traction(i).sum() * half_space_curve._problem.cell_area == pytest.approx(
            onset.tangential_load[i], rel=1e-6
        )


def test_ratio_of_normal_to_initial_tangential_stiffness_equals_mindlin_ratio(half_space_curve):
    for poisson, upper, lower in ((0.3, 0.3, 0.3), ((0.1, 0.45), 0.1, 0.45), (0.5, 0.5, 0.5)):
        onset = half_space_curve.onset(0, mu0=0.3, poisson=poisson, steps=1)
        ratio = 0.5 * (2 - upper) / (2 * (1 - upper)) + 0.5 * (2 - lower) / (2 * (1 - lower))
        assert onset.stiffness * ratio == pytest.approx(half_space_curve.stiffness[0], rel=1e-3)
        lightly_loaded_onset = half_space_curve.onset(0, mu0=0.3, tau0=0.05, poisson=poisson, steps=[1e-3])
        assert lightly_loaded_onset.tangential_load[0] / lightly_loaded_onset.displacement[0] == pytest.approx(
            onset.stiffness, rel=1e-4
        )


def test_poisson_ratio_of_a_rigid_body_does_not_change_tangential_stiffness():
    lower = create_rough_body((32, 32))
    curve = half_space(flat_like(lower), lower, [compute_load_at_relative_pressure(lower, 0.05)], compliance_share=1.0)
    stiffness_values = [
        curve.onset(0, mu0=0.3, poisson=poisson, steps=1).stiffness for poisson in ((0.0, 0.4), 0.4, 0.0)
    ]
    assert stiffness_values[0] == stiffness_values[1] < stiffness_values[2]


def test_onset_of_sliding_of_maps_agrees_with_ciavarella_jaeger_theory(half_space_curve):
    """Compare the traction with mu0 times the difference of the pressures at the load and at a smaller load."""
    onset = half_space_curve.onset(2, mu0=0.3, poisson=0.25, steps=[0.4, 0.7])
    for i, smaller_load_index in enumerate((1, 0)):
        q = 0.3 * (half_space_curve.contact(2).pressure - half_space_curve.contact(smaller_load_index).pressure).ravel()
        assert np.abs(onset.traction(i) - q).sum() < TRACTION_TOLERANCE * q.sum()
        displacement = (
            0.3
            * (half_space_curve.approach[2] - half_space_curve.approach[smaller_load_index])
            * (2 - 0.25)
            / (2 * (1 - 0.25))
        )
        assert onset.displacement[i] == pytest.approx(displacement, rel=1e-4)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_onset_of_sliding_of_profiles_agrees_with_ciavarella_jaeger_theory(boundary):
    lower = create_rough_body((1024,))
    load = compute_load_at_relative_pressure(lower, 0.05)
    curve = half_space(flat_like(lower), lower, [0.3 * load, 0.6 * load, load], boundary=boundary, tolerance=1e-8)
    for poisson in (0.0, 0.3):
        onset = curve.onset(2, mu0=0.2, poisson=poisson, steps=[0.4, 0.7])
        for i, smaller_load_index in enumerate((1, 0)):
            q = 0.2 * (curve.contact(2).pressure - curve.contact(smaller_load_index).pressure)
            assert np.abs(onset.traction(i) - q).sum() < TRACTION_TOLERANCE * q.sum()
            if boundary == "periodic":
                # In plane strain, tractions and pressures cause equal displacements (Johnson, sections 2.2 and 2.5).
                displacement = 0.2 * (curve.approach[2] - curve.approach[smaller_load_index])
                assert onset.displacement[i] == pytest.approx(displacement, rel=1e-4)
                assert onset.stiffness == pytest.approx(curve.stiffness[2], rel=1e-3)


@pytest.mark.parametrize("factor", [10.0, 0.01])
def test_displacement_and_stiffness_and_energy_loss_before_sliding_scale_with_size(half_space_curve, factor):
    problem = half_space_curve._problem
    lower = Surface(-problem.gap * factor, spacing=problem.spacing[0] * factor)
    boundary = "periodic" if problem.periodic else "free"
    enlarged_curve = half_space(
        flat_like(lower), lower, half_space_curve.load[:1] * factor**2, boundary=boundary, tolerance=1e-8
    )
    original_onset, enlarged_onset = (
        curve.onset(0, mu0=0.3, tau0=0.03, steps=[0.3, 0.8]) for curve in (half_space_curve, enlarged_curve)
    )
    np.testing.assert_allclose(enlarged_onset.displacement, factor * original_onset.displacement, rtol=1e-6)
    assert enlarged_onset.stiffness == pytest.approx(factor * original_onset.stiffness, rel=1e-6)
    np.testing.assert_allclose(
        enlarged_onset.energy_lost(enlarged_onset.tangential_load[1]),
        factor**3 * original_onset.energy_lost(original_onset.tangential_load[1]),
        rtol=1e-4,
    )


def test_onset_of_sliding_is_computed_at_requested_displacements(half_space_curve):
    sliding_displacement = half_space_curve.onset(0, mu0=0.3, steps=1).displacement_at_sliding
    onset = half_space_curve.onset(
        0, mu0=0.3, displacements=[0.2 * sliding_displacement, 0.7 * sliding_displacement, sliding_displacement]
    )
    np.testing.assert_allclose(onset.displacement, np.array([0.2, 0.7, 1.0]) * sliding_displacement, rtol=1e-6)
    onset_at_loads = half_space_curve.onset(0, mu0=0.3, steps=onset.tangential_load / onset.sliding_load)
    np.testing.assert_allclose(onset_at_loads.displacement, onset.displacement, rtol=1e-6)


# With 0.01 E* h' and free boundaries, the displacements of the few contact points are computed with a dense matrix.
@pytest.mark.parametrize(("boundary", "relative_pressure"), [("periodic", 0.1), ("free", 0.1), ("free", 0.01)])
def test_energy_loss_and_stiffnesses_reuse_the_solution_of_the_onset(monkeypatch, boundary, relative_pressure):
    solved_problems = []
    for name in ("linear_response", "displacement"):
        compute = getattr(_core.HalfSpaceGrids, name)
        monkeypatch.setattr(
            _core.HalfSpaceGrids,
            name,
            lambda *arguments, name=name, compute=compute, **options: (
                solved_problems.append(name) or compute(*arguments, **options)
            ),
        )
    lower = create_rough_body((64, 64))
    load = compute_load_at_relative_pressure(lower, relative_pressure)
    curve = half_space(flat_like(lower), lower, [load], effective_modulus=EFFECTIVE_MODULUS, boundary=boundary)
    onset = curve.onset(0, mu0=0.3, steps=[0.2, 0.5, 0.8, 1.0])
    calls_until_onset = solved_problems.copy()
    losses = onset.energy_lost(onset.tangential_load)
    assert (losses > 0).all()
    assert (curve.unloading_stiffness > onset.stiffness).all()
    assert calls_until_onset.count("linear_response") == 1
    assert solved_problems == calls_until_onset


def test_tangential_stiffness_is_finite_even_if_contact_pressures_reach_the_hardness():
    lower = create_rough_body((64, 64))
    load = compute_load_at_relative_pressure(lower, 0.1)
    curve = half_space(flat_like(lower), lower, [load], hardness=1.0)
    assert 0.05 < curve.load_share_at_hardness[0] < 1
    onset = curve.onset(0, mu0=0.3, tau0=0.02)
    assert onset.sliding_load == pytest.approx(0.3 * load + 0.02 * curve.contact_area[0], rel=1e-6)
    assert np.isfinite(onset.stiffness)
    # The pressure equals the hardness at all points, so the limit of the traction is uniform.
    curve = half_space(
        Surface(np.zeros((9, 9)), spacing=1.0), create_paraboloid(9, 9.0, (1.0, 1.0)), [9.0], hardness=1.0
    )
    assert curve.load_share_at_hardness[0] == pytest.approx(1)
    onset = curve.onset(0, mu0=0.3, steps=[0.5, 1.0])
    assert 0 < onset.displacement[0] < onset.displacement[1]
    assert 0 < onset.stiffness < np.inf


def test_surfaces_in_full_contact_have_infinite_initial_tangential_stiffness():
    lower = create_rough_body((32, 32))
    curve = half_space(flat_like(lower), lower, [3.0], boundary="periodic")
    onset = curve.onset(0, mu0=0.2, steps=10)
    assert onset.stiffness == np.inf
    assert onset.displacement[0] == 0
    assert onset.displacement[-1] > 0
    with pytest.raises(ValueError, match="full contact"):
        onset.iwan()
    flat = flat_like(lower)
    onset = half_space(flat, flat, [1.0], boundary="periodic").onset(0, mu0=0.2, steps=4)
    np.testing.assert_allclose(onset.traction(0), 0.05, rtol=1e-9)
    assert onset.slipped_area.tolist() == [0, 0, 0, 1]
    assert onset.displacement.tolist() == [0, 0, 0, 0]
    assert onset.energy_lost(onset.sliding_load) == 0
    with pytest.raises(ValueError, match="full contact"):
        onset.iwan()
    with pytest.raises(ValueError, match="displacements must not be given for flat surfaces in full contact"):
        half_space(flat, flat, [1.0], boundary="periodic").onset(0, mu0=0.2, displacements=[1e-3])


@pytest.mark.parametrize("shape", [(31,), (32,), (12, 21), (16, 16)])
def test_surfaces_in_full_contact_have_no_displacement_before_a_point_slips(shape):
    heights = np.random.default_rng(3).normal(0, 1e-4, shape)
    lower = Profile(heights, spacing=0.1) if heights.ndim == 1 else Surface(heights, spacing=0.1)
    curve = half_space(flat_like(lower), lower, [0.5], effective_modulus=EFFECTIVE_MODULUS, boundary="periodic")
    pressure = curve.contact(0).pressure
    assert pressure.min() > 0
    first_slip_fraction = pressure.min() / pressure.mean()  # The traction is uniform until a point slips.
    fractions = np.concatenate([np.linspace(0.1, 0.999, 8) * first_slip_fraction, [0.5 + 0.5 * first_slip_fraction, 1]])
    onset = curve.onset(0, mu0=0.2, steps=fractions)
    assert onset.displacement[:8].tolist() == [0.0] * 8
    assert (np.diff(onset.displacement[7:]) > 0).all()
    at_displacement = curve.onset(0, mu0=0.2, displacements=onset.displacement[8:])
    np.testing.assert_allclose(at_displacement.tangential_load, onset.tangential_load[8:], rtol=1e-5)


def test_flat_punch_slips_at_all_points_at_the_sliding_load():
    """Check flats with free boundaries, on which the pressure is proportional to the traction of a rigid shift."""
    for flat in (Profile(np.zeros(64), spacing=0.1), Surface(np.zeros((33, 40)), spacing=0.1)):
        curve = half_space(flat, flat, [1.0])
        onset = curve.onset(0, mu0=0.2, steps=[0.01, 0.5, 0.99, 1.0])
        assert onset.slipped_area.tolist() == [0, 0, 0, 1]
        np.testing.assert_allclose(onset.traction(1), 0.1 * curve.contact(0).pressure.ravel(), rtol=1e-4)
        if flat.heights.ndim == 2:
            np.testing.assert_allclose(onset.displacement * onset.stiffness, onset.tangential_load, rtol=1e-4)


# ---- Asperities -----------------------------------------------------------------------------------------------------


def press_single_ball(radii=(1.0, 1.0), approach=0.02):
    lower = create_paraboloid(64, 1.0, radii)
    return press(flat_like(lower), lower, [approach])


def test_onset_of_sliding_of_a_single_asperity_equals_mindlin_solution():
    curve = press_single_ball()
    for poisson in (0.0, 0.3):
        onset = curve.onset(0, mu0=0.3, poisson=poisson)
        ratio = (2 - poisson) / (2 * (1 - poisson))
        load_fractions = np.arange(1, 21) / 20
        table = contacts(*curve._inputs.bodies, 0.02)
        load, area = table.force * table.normal[:, 2], table.area
        radius, overlap = np.sqrt(area[0] / np.pi), table.overlap[0]
        sliding_displacement = 0.3 * ratio * overlap
        assert onset.sliding_load == pytest.approx(0.3 * load.sum(), rel=ROUND_OFF)
        np.testing.assert_allclose(
            onset.displacement, sliding_displacement * (1 - (1 - load_fractions) ** (2 / 3)), rtol=1e-6
        )
        np.testing.assert_allclose(onset.slipped_area, 1 - (1 - load_fractions) ** (2 / 3), rtol=1e-6)
        assert onset.stiffness == pytest.approx(2 * EFFECTIVE_MODULUS * radius / ratio, rel=1e-6)
        energy_loss = 24 / 5 * (1 - (1 - load_fractions) ** (5 / 3)) - 4 * load_fractions * (
            1 + (1 - load_fractions) ** (2 / 3)
        )
        np.testing.assert_allclose(
            onset.energy_lost(onset.tangential_load), onset.sliding_load * sliding_displacement * energy_loss, rtol=1e-6
        )


@pytest.mark.parametrize("radii", [(1.0, 1.0), (0.3, 1.0)])
@pytest.mark.parametrize(("mu0", "tau0"), [(0.3, 0.0), (0.3, 0.1), (0.0, 0.1)])
def test_onset_of_sliding_of_a_single_asperity_agrees_with_half_space_model(radii, mu0, tau0):
    lower = create_paraboloid(128, 1.0, radii)
    asperity_curve = press(flat_like(lower), lower, [0.04])
    half_space_curve = half_space(flat_like(lower), lower, asperity_curve.normal_elastic)
    asperity_onset, half_space_onset = (
        curve.onset(0, mu0=mu0, tau0=tau0, poisson=0.0, steps=LOAD_FRACTIONS)
        for curve in (asperity_curve, half_space_curve)
    )
    np.testing.assert_allclose(asperity_onset.displacement, half_space_onset.displacement, rtol=0.005)
    np.testing.assert_allclose(asperity_onset.slipped_area, half_space_onset.slipped_area, atol=0.02)
    np.testing.assert_allclose(asperity_onset.slipped_load, half_space_onset.slipped_load, atol=0.02)
    assert asperity_onset.stiffness == pytest.approx(half_space_onset.stiffness, rel=0.005)
    energy_loss = [curve.energy_lost(curve.tangential_load[4:]) for curve in (asperity_onset, half_space_onset)]
    np.testing.assert_allclose(energy_loss[0], energy_loss[1], rtol=0.03)


@pytest.mark.parametrize("direction", [0.0, 30.0, 90.0])
def test_tangential_stiffness_of_an_elliptical_contact_equals_cerruti_quadrature(direction):
    """Compare with a numerical integral: the displacement in the middle of an ellipse under a flat punch."""
    poisson, direction_angle = 0.3, np.radians(direction)
    curve = press_single_ball((0.3, 1.0))
    axes = contacts(*curve._inputs.bodies, 0.02).axes[0]

    def ellipse_radius(angle):
        return 1 / np.hypot(np.cos(angle) / axes[0], np.sin(angle) / axes[1])

    def displacement_per_angle(
        angle,
    ):  # The unit force has the traction 1/(2π a b) (1 - s²)^(-1/2). For one of two equal bodies 1/G = 4 (1 - ν)/E*.
        return (1 - poisson * np.sin(angle - direction_angle) ** 2) * ellipse_radius(angle)

    shear_modulus = EFFECTIVE_MODULUS * (1 - poisson)  # For equal bodies E* = G/(1 - ν).
    displacement = quad(displacement_per_angle, 0, 2 * np.pi)[0] / (8 * np.pi * shear_modulus * axes.prod())
    onset = curve.onset(0, mu0=0.3, poisson=poisson, direction=direction)
    assert onset.stiffness == pytest.approx(1 / (2 * displacement), rel=1e-9)
    assert onset.direction == direction


@pytest.fixture(scope="module")
def bodies_and_curve():
    bodies = rough_maps(2, points=256, spacing=0.05, shortest_wavelength=0.4)
    return bodies, press(*bodies, [0.01, 0.04], direction=[0.0, 90.0])


def test_onset_of_sliding_of_many_asperities_is_the_sum_over_their_contacts(bodies_and_curve):
    bodies, curve = bodies_and_curve
    onset = curve.onset(1, mu0=0.3, tau0=0.1, direction=20.0)
    assert curve.contact_count[1] > 20
    table = contacts(*bodies, 0.04)
    assert onset.sliding_load == pytest.approx(0.3 * curve.normal_elastic[1] + 0.1 * curve.contact_area[1], rel=1e-9)
    assert onset.traction(3) @ table.area == pytest.approx(onset.tangential_load[3], rel=ROUND_OFF)
    for name in ("displacement", "slipped_area", "slipped_load"):
        assert (np.diff(getattr(onset, name)) > 0).all()
    assert onset.slipped_area[-1] == pytest.approx(1)
    lightly_loaded_onset = curve.onset(1, mu0=0.3, tau0=0.1, direction=20.0, steps=[1e-6])
    assert lightly_loaded_onset.tangential_load[0] / lightly_loaded_onset.displacement[0] == pytest.approx(
        onset.stiffness, rel=1e-3
    )
    slip_loads = onset.slip_load()
    assert (np.sort(slip_loads)[:-1] <= onset.sliding_load).all()
    assert np.isfinite(slip_loads).all()
    for load, i in ((onset.tangential_load[9], 9), (onset.tangential_load[14], 14)):
        assert ((slip_loads <= load) == np.isclose(onset.traction(i), onset.traction(-1), rtol=1e-12)).all()


def test_energy_loss_equals_the_area_of_the_hysteresis_loop(bodies_and_curve):
    onset = bodies_and_curve[1].onset(1, mu0=0.3, tau0=0.1, steps=400)
    for load_fraction in (0.5, 1.0):
        displacement, load = onset.loop(load_fraction * onset.sliding_load)
        area = 0.5 * abs(np.sum(displacement * np.roll(load, -1) - load * np.roll(displacement, -1)))
        assert area == pytest.approx(onset.energy_lost(load_fraction * onset.sliding_load), rel=TRACTION_TOLERANCE)
        assert displacement[0] == pytest.approx(-displacement[len(displacement) // 2])
        assert load.max() == pytest.approx(load_fraction * onset.sliding_load)
        assert load.min() == pytest.approx(-load_fraction * onset.sliding_load)


def test_onset_of_sliding_of_profiles_can_be_computed_with_sphere_and_elastic_plastic_laws():
    bodies = [
        weierstrass_mandelbrot(random_phases(3, side=side), 1.2, points=20_000).with_amplitude(0.1)
        for side in ("upper", "lower")
    ]
    for detection in ("cell", "gap-minimum"):
        curve = press(*bodies, [0.03], detection=detection, shear="-x")
        onset = curve.onset(0, mu0=0.3, tau0=0.05, direction="-x")
        max_friction = 0.3 * curve.normal_elastic[0] + 0.05 * curve.contact_area[0]
        assert onset.sliding_load == pytest.approx(max_friction, rel=1e-9)
    assert onset.direction == 180.0
    with pytest.raises(ValueError, match="direction for profiles"):
        curve.onset(0, mu0=0.3, direction=90.0)
    curve = press(*bodies, [0.03], law=HertzCylinder())
    with pytest.raises(ValueError, match="HertzCylinder"):
        curve.onset(0, mu0=0.3)
    yielding_onset = press(*bodies, [0.03], law=JacksonGreen(yield_strength=0.05, poisson_ratio=0.3)).onset(0, mu0=0.3)
    assert yielding_onset.sliding_load < onset.sliding_load


def test_pickled_load_curve_gives_the_onset_of_sliding_of_the_original(bodies_and_curve):
    bodies, curve = bodies_and_curve
    restored_curve = pickle.loads(pickle.dumps(curve))
    assert restored_curve.onset(1, mu0=0.3).displacement_at_sliding == curve.onset(1, mu0=0.3).displacement_at_sliding
    result = press(candidates(*bodies, deepest=0.04), [0.04])
    assert result.onset(0, mu0=0.3).displacement_at_sliding == curve.onset(1, mu0=0.3).displacement_at_sliding
    with pytest.raises(ValueError, match="compute the curve again in this process"):
        pickle.loads(pickle.dumps(result)).onset(0, mu0=0.3)


# ---- Export and fitted models ----------------------------------------------------------------------------------------


def test_iwan_and_lugre_fits_recover_their_parameters():
    displacement = np.linspace(0, 1, 21)[1:]
    known_values = {"sliding_load": 2.0, "stiffness": 3.0}
    for chi, beta in ((-0.3, 0.5), (-0.7, 3.0)):
        true_model = FourParameterIwan(2.0, 3.0, chi, beta, np.empty(0))
        result = fit_iwan(displacement, true_model.load(displacement), **known_values)
        assert np.abs(result.residual).max() < 1e-8
        assert (result.chi, result.beta) == pytest.approx((chi, beta), rel=1e-4)
        sliding_displacement = true_model.displacement_at_sliding
        assert true_model.load(sliding_displacement) == 2.0
        assert true_model.load(sliding_displacement * (1 - 1e-9)) == pytest.approx(2.0, rel=1e-6)
        # Each slipping spring of Segalman's model dissipates four times its strength times its slip per cycle.
        edges = np.linspace(0, 1, 200_001) ** 3 * sliding_displacement
        slip_displacements, strengths = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges ** (chi + 1))
        strengths *= 3.0 / (1 + beta) / strengths.sum()
        slip_displacements, strengths = (
            np.append(slip_displacements, sliding_displacement),
            np.append(strengths, 3.0 * beta / (1 + beta)),
        )
        for u in (0.3 * sliding_displacement, 0.8 * sliding_displacement, 1.5 * sliding_displacement):
            assert true_model.load(u) == pytest.approx(np.minimum(u, slip_displacements) @ strengths, rel=1e-4)
            energy_loss = 4 * (strengths * slip_displacements) @ np.maximum(u - slip_displacements, 0)
            assert true_model.energy_lost(u) == pytest.approx(energy_loss, rel=1e-4)
    lugre_forces = -2.0 * np.expm1(-3.0 * displacement / 2.0)
    result = fit_lugre(displacement, lugre_forces, sliding_load=2.0)
    assert result.stiffness == pytest.approx(3.0, rel=1e-6)
    assert np.abs(result.residual).max() < 1e-6


def test_onset_data_frame_has_units_in_its_column_names(bodies_and_curve):
    onset = bodies_and_curve[1].onset(1, mu0=0.3, tau0=0.1)
    table = onset.frame()
    assert list(table) == ["tangential_load_mN", "displacement_um", "slipped_area", "slipped_load", "energy_lost_mN_um"]
    assert table.to_csv(index=False).count("\n") == 22
    assert table["displacement_um"].iloc[-1] == onset.displacement_at_sliding


def test_fitted_onset_model_has_small_residuals_and_rejects_negative_displacements(bodies_and_curve):
    onset = bodies_and_curve[1].onset(1, mu0=0.3, tau0=0.1)
    iwan, lugre = onset.iwan(), onset.lugre()
    np.testing.assert_allclose(iwan.load(onset.displacement) - onset.tangential_load, iwan.residual, atol=ROUND_OFF)
    assert np.sqrt(np.mean(iwan.residual**2)) < np.sqrt(np.mean(lugre.residual**2)) < 0.1 * onset.sliding_load
    with pytest.raises(ValueError, match="displacement must be at least 0"):
        iwan.load(-1.0)


def test_arrays_of_an_onset_and_its_fitted_model_are_read_only(bodies_and_curve):
    onset = bodies_and_curve[1].onset(1, mu0=0.3, tau0=0.1)
    for array in (onset.displacement, onset.traction(0), onset.slip_load(), onset.iwan().residual):
        assert not array.flags.writeable


def test_onset_model_fit_requires_three_loads(bodies_and_curve):
    with pytest.raises(ValueError, match="at least 3 loads"):
        bodies_and_curve[1].onset(1, mu0=0.3, steps=[0.5, 1.0]).iwan()


# ---- Bad input ------------------------------------------------------------------------------------------------------

REJECTED_ARGUMENT_CASES = [
    ({"mu0": -0.1}, "mu0 must not be negative"),
    ({"mu0": [0.1, 0.2]}, "mu0 must be a finite number"),
    ({"mu0": 0.0}, "mu0 and tau0 must not both be 0"),
    ({"mu0": 0.3, "tau0": -0.1}, "tau0 must not be negative"),
    ({"mu0": 0.3, "steps": 0}, "steps must be a whole number"),
    ({"mu0": 0.3, "steps": [0.5, 1.2]}, "fractions of the sliding load"),
    ({"mu0": 0.3, "steps": [0.5, 0.5]}, "strictly increasing"),
    ({"mu0": 0.3, "steps": []}, "strictly increasing"),
    ({"mu0": 0.3, "steps": [0.0, 0.5]}, "above 0"),
    ({"mu0": 0.3, "displacements": [1.0]}, "displacement at sliding"),
    ({"mu0": 0.3, "displacements": [-1.0]}, "above 0"),
    ({"mu0": 0.3, "poisson": 0.6}, "poisson must be"),
    ({"mu0": 0.3, "poisson": (0.1, 0.2, 0.3)}, "poisson must be"),
    ({"mu0": 0.3, "direction": "up"}, "direction must be"),
    ({"mu0": 0.3, "direction": [0.0, 90.0]}, "direction must be a single angle"),
]


@pytest.mark.parametrize(("arguments", "message"), REJECTED_ARGUMENT_CASES)
def test_onset_method_rejects_invalid_arguments(ball_curve_and_radius, arguments, message):
    for curve in (ball_curve_and_radius[0], press_single_ball()):
        with pytest.raises(ValueError, match=message):
            curve.onset(0, **arguments)


def test_onset_method_rejects_invalid_indices_and_steps_and_amplitudes(ball_curve_and_radius):
    with pytest.raises(ValueError, match="index must be at least -1 and below 1, the number of loads"):
        ball_curve_and_radius[0].onset(1, mu0=0.3)
    with pytest.raises(ValueError, match="index must be at least -1 and below 1, the number of approaches"):
        press_single_ball().onset(0.5, mu0=0.3)
    x = np.arange(65) / 64 - 0.5
    cup = Profile(x**2, spacing=1 / 64)
    with pytest.raises(ValueError, match="`index` must select an approach at which the bodies touch"):
        press(flat_like(cup), cup, [0.01]).onset(0, mu0=0.3)
    with pytest.raises(ValueError, match="tolerance must be"):
        ball_curve_and_radius[0].onset(0, mu0=0.3, tolerance=0.0)
    onset = ball_curve_and_radius[0].onset(0, mu0=0.3, steps=2)
    with pytest.raises(ValueError, match="index must be at least -2 and below 2, the number of tangential loads"):
        onset.traction(2)
    for amplitude in (-1.0, 2 * onset.sliding_load):
        with pytest.raises(ValueError, match="the sliding load"):
            onset.energy_lost(amplitude)
    assert onset.energy_lost(0.0) == 0
    assert onset.energy_lost([[0.0, onset.sliding_load]]).shape == (1, 2)


def test_onset_method_rejects_loads_and_displacements_below_the_round_off_error(ball_curve_and_radius):
    for curve in (ball_curve_and_radius[0], press_single_ball()):
        onset = curve.onset(0, mu0=0.3, steps=2)
        for amplitude in (1e-300, 0.9e-12 * onset.sliding_load):
            for compute in (onset.energy_lost, onset.loop):
                with pytest.raises(ValueError, match=r"amplitude must be between .* the sliding load"):
                    compute(amplitude)
            with pytest.raises(ValueError, match="steps are fractions of the sliding load and must be between 1e-12"):
                curve.onset(0, mu0=0.3, steps=[amplitude / onset.sliding_load, 1.0])
        with pytest.raises(ValueError, match=r"displacements must be between .* the displacement at sliding"):
            curve.onset(0, mu0=0.3, displacements=[1e-300])
        # While almost all of the contact sticks, the displacement is the load divided by the initial stiffness.
        smallest = curve.onset(0, mu0=0.3, steps=[1e-12])
        assert smallest.displacement[0] * onset.stiffness == pytest.approx(smallest.tangential_load[0], rel=1e-6)
        at_displacement = curve.onset(0, mu0=0.3, displacements=[1e-12 * onset.displacement_at_sliding])
        assert at_displacement.displacement[0] * onset.stiffness == pytest.approx(
            at_displacement.tangential_load[0], rel=1e-6
        )
        assert onset.loop(smallest.tangential_load[0])[1].max() == smallest.tangential_load[0]


def test_onset_of_sliding_of_a_ball_equals_closed_form_if_mu0_is_zero(ball_curve_and_radius):
    """Compare with the closed form of the asperity model: with tau0 alone the bound is uniform over the contact."""
    curve, radius = ball_curve_and_radius
    onset = curve.onset(0, mu0=0.0, tau0=0.2, poisson=0.0, steps=LOAD_FRACTIONS)
    area = np.pi * radius**2
    assert onset.sliding_load == pytest.approx(0.2 * curve.contact_area[0], rel=ROUND_OFF)
    assert onset.displacement_at_sliding == pytest.approx(
        2 * 0.2 * area / (np.pi * EFFECTIVE_MODULUS / 2 * radius) / 2, rel=0.01
    )
    for displacement, load_fraction in zip(onset.displacement, LOAD_FRACTIONS, strict=True):
        relative_displacement = displacement / onset.displacement_at_sliding
        assert 2 / np.pi * (
            np.arcsin(relative_displacement) + relative_displacement * np.sqrt(1 - relative_displacement**2)
        ) == pytest.approx(load_fraction, rel=5 * MINDLIN_TOLERANCE)
