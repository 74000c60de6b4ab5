import warnings

import numpy as np
import pytest
from reference.least_energy import minimize_energy
from scipy.integrate import trapezoid
from scipy.stats import norm
from stiction import (
    Profile,
    Surface,
    dmt,
    fuller_tabor,
    half_space,
    jkr,
    maugis_dugdale,
    self_affine_surface,
    tabor_parameter,
)
from stiction.mechanics import adhesion
from stiction.mechanics.adhesion import AdhesionSolver, EnergyMinimizer
from stiction.mechanics.half_space_problem import min_resolved_adhesion_range
from stiction.mechanics.solution_record import SolutionRecord
from support.threads import releases_interpreter_lock

GAP_TOLERANCE = 1e-3
"""Tolerance of gaps as a fraction of the range of adhesion. For soft bodies the energy minimum is flat."""

STABILITY_MARGIN = 0.03
"""Relative distance from the pull-off force at which the energy minimum certainly exists or has certainly vanished."""

MEAN_GAP_TOLERANCE = 1e-4
"""Relative difference of loads at equal mean gap. Each solution has a tolerance of 1e-5."""

POINT_FRACTION_TOLERANCE = 1e-3
"""Maximum fraction of the grid points at which two solvers disagree about contact; their pressure is almost zero."""

ROUND_OFF = 1e-12
MAX_LOWER_BOUND_FORCES = 2  # of 200 random pairs

PERIODICITY_TOLERANCE = 0.02
"""Relative difference between the pull-off forces of a ball with a period of 20 contact radii and of an isolated
ball."""

ATTRACTION_LAW_TOLERANCE = 0.06
"""Relative difference between the pull-off forces of an exponential attraction and of an attraction that ends at its
range."""

MAUGIS_TOLERANCE = 0.02
"""Relative difference of pull-off force and contact radius of a ball from Maugis' solution."""

GRID_POSITION_TOLERANCE = 0.005
"""Relative difference of the pull-off force of a ball if the spacing is halved, or if the free edge is more distant."""

CLOSED_FORM_TOLERANCE = 0.02
"""Relative difference of loads and lengths between a short-range attraction (at least 4 points) and zero range."""

STEP_SUM_TOLERANCE = 3e-3
"""Relative difference between the work summed over 40 steps and the integral."""


def create_ball_on_flat(tabor, *, points=64, length=10.0):
    """Return a ball with a radius of 1 µm on a flat, with an adhesion range of 1 nm and a given Tabor parameter."""
    height = tabor * 1e-3
    spacing = length * height**0.5 / points
    x = (np.arange(points) - points // 2) * spacing
    flat = np.zeros((points, points))
    bodies = Surface(flat, spacing=spacing), Surface(-(x[:, None] ** 2 + x**2) / 2, spacing=spacing)
    return bodies, {"effective_modulus": 1.0, "work_of_adhesion": height**1.5, "adhesion_range": 1e-3}


def create_rough_bodies(rms, work, *, points=32, modulus=80.0, length=1e-3, spacing=0.02, seed=3):
    wavelengths = {"longest_wavelength": points * spacing / 2, "shortest_wavelength": 4 * spacing}
    shape = {"shape": (points, points), "spacing": spacing}
    lower = self_affine_surface(seed, hurst_exponent=0.8, rms=rms, **shape, **wavelengths)
    bodies = Surface(np.zeros((points, points)), spacing=spacing), lower
    return bodies, {"effective_modulus": modulus, "work_of_adhesion": work, "adhesion_range": length}


SPACING_TOLERANCE = 0.03
"""Relative difference between the pull-off forces at spacings with at least 8 points in the process zone."""


@pytest.mark.parametrize(
    "case",
    [
        create_ball_on_flat(0.3, points=32),
        create_ball_on_flat(1.0, points=32),
        create_rough_bodies(1e-3, 5e-5),
        create_rough_bodies(3e-3, 3e-4),
        create_rough_bodies(0.02, 5e-5, modulus=2e-3, spacing=0.2, length=0.1001),
        create_rough_bodies(5e-3, 1.1e-5, modulus=1.4e-3, spacing=0.01, length=0.013),
    ],
    ids=["hard ball", "ball", "smooth", "rough", "silicone", "complete"],
)
def test_adhesive_contact_minimizes_energy_up_to_the_pull_off_force(case):
    bodies, adhesion_options = case
    curve = half_space(*bodies, [0.0], boundary="periodic", **adhesion_options)
    gap, area = -bodies[1].heights, bodies[0].heights.size * bodies[0].spacing[0] ** 2
    heights = gap - gap.min()
    noise = 0.01 * adhesion_options["adhesion_range"] * np.random.default_rng(1).random(gap.shape)
    for fraction in (0.0, -1 + STABILITY_MARGIN):
        load = fraction * curve.pull_off_bound[0]
        contact = half_space(*bodies, [load], boundary="periodic", **adhesion_options).contact(0)
        initial_gap = np.maximum(contact.gap, 0) + noise
        gap, pressure = minimize_energy(heights, bodies[0].spacing[0], load / area, initial_gap, **adhesion_options)
        assert np.abs(gap - contact.gap).max() < GAP_TOLERANCE * adhesion_options["adhesion_range"] * (
            1 if fraction == 0 else 10
        )
        assert pressure.mean() == pytest.approx(contact.pressure.mean(), rel=GAP_TOLERANCE)
        assert ((gap == 0) != (contact.pressure > 0)).sum() <= 1
    pressure_beyond_pull_off = (-1 - STABILITY_MARGIN) * curve.pull_off_bound[0] / area
    gap, _ = minimize_energy(heights, bodies[0].spacing[0], pressure_beyond_pull_off, initial_gap, **adhesion_options)
    assert (gap > 0).all()


@pytest.mark.parametrize(("rms", "modulus", "load"), [(1e-3, 80.0, 0.01), (3e-3, 80.0, 0.1), (3e-3, 2.0, 2e-3)])
def test_adhesive_contact_agrees_with_the_tamaas_library_at_the_same_mean_gap(rms, modulus, load):
    tamaas = pytest.importorskip("tamaas")
    (flat, lower), adhesion_options = create_rough_bodies(rms, 5e-5, points=64, modulus=modulus)
    area = lower.heights.size * lower.spacing[0] ** 2
    curve = half_space(flat, lower, [load * area], boundary="periodic", **adhesion_options)
    contact = curve.contact(0)
    lengths = [64 * lower.spacing[0]] * 2
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, lengths, [64, 64])
    model.E, model.nu = modulus, 0
    heights, gap = np.array(lower.heights), tamaas.PolonskyKeerRey.gap
    solver = tamaas.PolonskyKeerRey(model, heights, 1e-11, gap, gap)
    attraction = tamaas.ExponentialAdhesionFunctional(heights)
    attraction.parameters = {"rho": curve.adhesion_range, "surface_energy": adhesion_options["work_of_adhesion"]}
    solver.addFunctionalTerm(attraction)
    solver.max_iter = 20_000
    solver.solve(contact.gap.mean())
    mean_contact_pressure = curve.contact_load[0] / area
    assert model.traction.mean() == pytest.approx(load, abs=MEAN_GAP_TOLERANCE * mean_contact_pressure)
    assert ((np.asarray(model["gap"]) <= ROUND_OFF) == (contact.pressure > 0)).mean() > 1 - POINT_FRACTION_TOLERANCE


@pytest.mark.parametrize("tabor", [0.3, 1.0, 1.7])
def test_pull_off_force_of_a_sphere_equals_maugis_solution_for_any_period(tabor):
    bodies, adhesion_options = create_ball_on_flat(tabor)
    assert tabor_parameter(
        1.0, 1.0, **{name: adhesion_options[name] for name in ("work_of_adhesion", "adhesion_range")}
    ) == (pytest.approx(tabor))
    unit_load = np.pi * adhesion_options["work_of_adhesion"]
    free_curve = half_space(*bodies, [unit_load], **adhesion_options)
    wide_bodies, _ = create_ball_on_flat(tabor, points=128, length=20.0)
    periodic_curve = half_space(*wide_bodies, [unit_load], boundary="periodic", **adhesion_options)
    assert free_curve.pull_off_bound[0] == pytest.approx(periodic_curve.pull_off, rel=PERIODICITY_TOLERANCE)
    radius, pull_off = maugis_dugdale(unit_load, radius=1.0, **adhesion_options)
    assert free_curve.pull_off_bound[0] == pytest.approx(float(pull_off), rel=ATTRACTION_LAW_TOLERANCE)
    assert 1.5 * unit_load < free_curve.pull_off_bound[0] < 2 * unit_load
    assert np.sqrt(free_curve.contact_area[0] / np.pi) == pytest.approx(float(radius), rel=ATTRACTION_LAW_TOLERANCE)


@pytest.mark.parametrize("tabor", [0.1, 0.3, 1.0])
def test_dugdale_contact_of_a_sphere_agrees_with_maugis_solution_on_any_grid(tabor, monkeypatch):
    """Check that differences from Maugis' solution are due to the exponential law, not to the grid or the edge."""
    length = 8 * max(1, tabor**-0.5)
    exponential = [
        half_space(*bodies, [0.0], **adhesion_options).pull_off
        for bodies, adhesion_options in (
            create_ball_on_flat(tabor, points=n, length=c * length) for n, c in ((64, 1), (128, 1), (96, 1.5))
        )
    ]
    assert exponential[1:] == pytest.approx(exponential[:1] * 2, rel=GRID_POSITION_TOLERANCE)
    edge = 0.05  # The attraction decreases to zero over this fraction of its range.

    def finite_range_attraction(self, gap):
        return self.max_attraction / (1 + np.exp(np.minimum((np.maximum(gap, 0) / self.range - 1) / edge, 500)))

    monkeypatch.setattr(AdhesionSolver, "attraction_at_gap", finite_range_attraction)
    bodies, adhesion_options = create_ball_on_flat(tabor, points=128, length=length)
    curve = half_space(*bodies, [0.0], **adhesion_options)
    radius, pull_off = maugis_dugdale(0.0, radius=1.0, **adhesion_options)
    assert curve.pull_off == pytest.approx(float(pull_off), rel=MAUGIS_TOLERANCE)
    assert np.sqrt(curve.contact_area[0] / np.pi) == pytest.approx(float(radius), rel=MAUGIS_TOLERANCE)


def test_contact_of_an_adhesive_cylinder_equals_barquins_solution():
    """Check F = π E* a²/(4R) - (2π E* w a)^(1/2) per µm of length (Barquins, The Journal of Adhesion 26 (1988) 1)."""
    work, length = 1e-6, 1024
    radius = (2 * work / np.pi) ** (1 / 3)  # µm, at pull-off
    spacing = 12 * radius / length
    x = (np.arange(length) - length // 2) * spacing
    bodies = Profile(np.zeros(length), spacing=spacing), Profile(-(x**2) / 2, spacing=spacing)
    adhesion_range = work ** (2 / 3) / 5  # adhesion range at which Tabor's parameter is 5
    curve = half_space(*bodies, [0.0], effective_modulus=1.0, work_of_adhesion=work, adhesion_range=adhesion_range)
    assert curve.adhesion_range == adhesion_range
    assert curve.pull_off == pytest.approx(0.75 * np.pi * radius**2, rel=CLOSED_FORM_TOLERANCE)
    assert curve.contact_area[0] == pytest.approx(2 * (32 * work / np.pi) ** (1 / 3), rel=CLOSED_FORM_TOLERANCE)


@pytest.mark.parametrize("alpha", [0.1, 0.3, 0.5, 0.6])
def test_adhesive_contact_of_a_sinusoid_equals_johnson_solution_and_jumps_to_full_contact(alpha):
    """Check p/p* = sin²s - α (tan s)^(1/2), s = πa/λ (Johnson, Int. J. Solids Structures 32 (1995) 423).

    Full contact needs no load above α = 0.57, and 0.09 p* at α = 0.5. Accelerated steps must not reach full
    contact at a smaller load.
    """
    points, height = 2048, 0.005
    x, full_contact_pressure = np.arange(points) / points, np.pi * height
    bodies = Profile(np.zeros(points), spacing=1 / points), Profile(height * np.cos(2 * np.pi * x), spacing=1 / points)
    work = (alpha * full_contact_pressure) ** 2 / 2
    # Choose the adhesion range so that 4 grid points resolve the attraction at the contact edge.
    adhesion_options = {"work_of_adhesion": work, "adhesion_range": (4 * work / points) ** 0.5}
    loads = np.array([0.0, 0.05]) * full_contact_pressure
    curve = half_space(*bodies, loads, effective_modulus=1.0, boundary="periodic", **adhesion_options)
    if alpha > 0.57:
        assert (curve.contact_area > 1 - 1 / points).all()
        return
    angle = np.linspace(1e-4, 1.2, 100_001)
    johnson_pressure = np.sin(angle) ** 2 - alpha * np.sqrt(np.tan(angle))
    stable_branch = slice(
        np.argmin(johnson_pressure),
        np.argmin(johnson_pressure) + np.argmax(johnson_pressure[np.argmin(johnson_pressure) :]),
    )
    expected = (
        2 / np.pi * np.interp(loads / full_contact_pressure, johnson_pressure[stable_branch], angle[stable_branch])
    )
    assert curve.contact_area == pytest.approx(expected, abs=CLOSED_FORM_TOLERANCE)
    assert curve.pull_off_bound[0] / full_contact_pressure == pytest.approx(
        -johnson_pressure.min(), rel=CLOSED_FORM_TOLERANCE
    )
    assert not curve.pull_off_is_bound


PULL_OFF_TOLERANCE = 0.01
"""Relative difference of the pull-off force from a closed form, or from the largest of many contacts."""


@pytest.mark.parametrize("tension", [1.02, 1.05, 1.13, 1.7, 2.3])
def test_pull_off_force_of_a_sinusoid_in_full_contact_is_the_tension_that_opens_a_gap(tension):
    """Complete contact under a load of 0.05 p* opens where the lowest pressure is 0: at a tension of w/ρ - p*."""
    points, height = 512, 0.005
    x, full_contact_pressure = np.arange(points) / points, np.pi * height
    bodies = Profile(np.zeros(points), spacing=1 / points), Profile(height * np.cos(2 * np.pi * x), spacing=1 / points)
    # Choose a work of adhesion so large that the grid resolves the range of the attraction.
    work = 2.001 * (tension * full_contact_pressure) ** 2 / points
    adhesion_options = {
        "work_of_adhesion": work,
        "adhesion_range": work / (tension * full_contact_pressure),
        "effective_modulus": 1.0,
    }
    curve = half_space(
        *bodies, [1.2 * full_contact_pressure, 0.05 * full_contact_pressure], boundary="periodic", **adhesion_options
    )
    assert curve.contact(1).pressure.all()
    opening_load = (tension - 1) * full_contact_pressure
    assert curve.pull_off_bound[0] == pytest.approx(opening_load, rel=PULL_OFF_TOLERANCE)
    assert not curve.pull_off_is_bound
    assert (np.diff(curve.parting.load) < 0).all()
    loads = [
        1.2 * full_contact_pressure,
        0.05 * full_contact_pressure,
        -0.5 * opening_load,
        (PULL_OFF_TOLERANCE - 1) * opening_load,
    ]
    tensile_curve = half_space(*bodies, loads, boundary="periodic", **adhesion_options)
    assert tensile_curve.normal_elastic == pytest.approx(loads, abs=1e-4 * tensile_curve.contact_load[0])
    assert tensile_curve.contact(3).pressure.all()
    with pytest.raises(RuntimeError, match="bodies"):
        half_space(*bodies, [*loads, -(1 + PULL_OFF_TOLERANCE) * opening_load], boundary="periodic", **adhesion_options)


def test_pull_off_force_of_rough_surfaces_is_the_largest_local_maximum_of_tension():
    shape = {"shape": (64, 64), "spacing": 0.01, "hurst_exponent": 0.769, "rms": 3.39e-3, "shortest_wavelength": 0.08}
    bodies = [
        self_affine_surface(4, side=side, longest_wavelength=longest, **shape)
        for side, longest in (("upper", 0.64), ("lower", 0.32))
    ]
    adhesion_options = {"effective_modulus": 1.72, "work_of_adhesion": 5.85e-5, "boundary": "periodic"}
    adhesion_options["adhesion_range"] = 1.001 * min_resolved_adhesion_range(5.85e-5, 0.01, 1.72)
    curve = half_space(*bodies, [0.0], **adhesion_options)
    adhesion_solver = AdhesionSolver(curve._problem, tolerance=1e-6, report=None)
    states = [adhesion_solver.find_equilibrium_at_pressure(None, 0.0)[0]]
    while states[-1].contact_load > 0.02 * states[0].contact_load:
        states.append(
            adhesion_solver.solve_at_contact_pressure(
                states[-1], 0.98 * states[-1].contact_load, earlier_state=states[0]
            )
        )
    loads = np.array([state.load for state in states])
    first_local_minimum = loads[np.flatnonzero(np.diff(loads) > 0.02 * -loads.min())[0]]
    # At the load of the first local minimum, the energy has another, lower minimum.
    assert first_local_minimum > 0.9 * loads.min()
    largest_tension = adhesion_solver.mean_pressure_to_force(-loads.min())
    assert curve.pull_off == pytest.approx(largest_tension, rel=PULL_OFF_TOLERANCE)
    tensile_curve = half_space(*bodies, [0.0, -0.95 * largest_tension], **adhesion_options)
    assert tensile_curve.normal_elastic[1] == pytest.approx(-0.95 * largest_tension, rel=1e-3)
    assert curve.parting.load[-1] == -curve.pull_off


def create_soft_bodies_in_complete_contact():
    """Return bodies in complete contact at zero load, which start to open at a tension below the pull-off force."""
    return create_rough_bodies(5e-3, 1.1e-5, modulus=1.4e-3, spacing=0.01, length=0.013)


def test_attraction_decreases_at_every_point_as_the_load_approaches_pull_off():
    bodies, adhesion_options = create_soft_bodies_in_complete_contact()
    curve = half_space(*bodies, [0.0], boundary="periodic", **adhesion_options)
    adhesion_solver = AdhesionSolver(curve._problem, tolerance=1e-6, report=None)
    force, is_bound = curve.pull_off_bound
    assert not is_bound
    pull_off = force / adhesion_solver.mean_pressure_to_force(1.0)
    state = adhesion_solver.find_equilibrium_at_pressure(None, 0.0)[0]
    assert state.pressure.all()
    assert -adhesion_solver.find_opening_state(state).load < 0.95 * pull_off
    for fraction in (0.3, 0.6, 0.9, 0.99):
        next_state, is_stable = adhesion_solver.find_equilibrium_at_pressure(state, -fraction * pull_off)
        assert is_stable
        assert next_state.load == pytest.approx(-fraction * pull_off, abs=1e-4 * next_state.mean_attraction)
        assert (next_state.attraction <= state.attraction + 1e-4 * adhesion_solver.max_attraction).all()
        state = next_state
    assert not adhesion_solver.find_equilibrium_at_pressure(state, -(1 + PULL_OFF_TOLERANCE) * pull_off)[1]


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_energy_minimum_under_tension_is_an_equilibrium_and_exists_only_up_to_pull_off(boundary):
    bodies, adhesion_options = create_rough_bodies(0.02, 5e-5, modulus=2e-3, spacing=0.2, length=0.1001)
    curve = half_space(*bodies, [0.0], boundary=boundary, **adhesion_options)
    adhesion_solver = AdhesionSolver(curve._problem, tolerance=1e-6, report=None)
    pull_off = curve.pull_off / adhesion_solver.mean_pressure_to_force(1.0)
    start = adhesion_solver.find_equilibrium_at_pressure(None, 0.0)[0]
    state = adhesion_solver.minimize_energy(start, -0.95 * pull_off)
    net_pressure = state.pressure.reshape(state.attraction.shape) - state.attraction
    gap = curve._problem.gap + curve._problem.grids.displacement(net_pressure) - state.approach
    residual = np.abs(adhesion_solver.attraction_at_gap(gap) - state.attraction).mean()
    assert residual <= 2 * adhesion_solver.max_residual * (state.contact_load + state.mean_attraction)
    assert net_pressure.mean() == pytest.approx(-0.95 * pull_off, rel=1e-6)
    plain_state, is_balanced = adhesion_solver.find_equilibrium_at_pressure(start, -0.95 * pull_off, max_factor=1.0)
    assert is_balanced
    assert state.contact_load == pytest.approx(plain_state.contact_load, rel=2e-3)
    assert adhesion_solver.minimize_energy(start, -1.03 * pull_off) is None
    assert not adhesion_solver.find_equilibrium_at_pressure(start, -1.03 * pull_off, max_factor=1.0)[1]


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_energy_minimization_finds_the_same_contact_as_slow_iteration_in_fewer_iterations(monkeypatch, boundary):
    bodies, adhesion_options = create_rough_bodies(0.1, 5e-5, points=64, modulus=2e-3, spacing=0.2, length=0.1001)

    def solve(max_solves):
        monkeypatch.setattr(adhesion, "MAX_SOLVES_BEFORE_MINIMIZATION", max_solves)
        record = SolutionRecord()
        options = {"boundary": boundary, "tolerance": 1e-8, "record": record}
        return half_space(*bodies, [-0.001, 0.0], **options, **adhesion_options), record.counter.count

    curve, num_iterations = solve(adhesion.MAX_SOLVES_BEFORE_MINIMIZATION)
    slow_curve, num_slow_iterations = solve(adhesion.MAX_SOLVES_PER_LOAD - 1)
    assert num_iterations < 0.6 * num_slow_iterations
    assert curve.contact_area == pytest.approx(slow_curve.contact_area, rel=1e-6)
    assert curve.approach == pytest.approx(slow_curve.approach, rel=1e-6)


def test_contact_is_iterated_if_the_energy_minimization_does_not_converge(monkeypatch):
    bodies, adhesion_options = create_rough_bodies(0.1, 5e-5, points=64, modulus=2e-3, spacing=0.2, length=0.1001)
    monkeypatch.setattr(adhesion, "MAX_SOLVES_BEFORE_MINIMIZATION", adhesion.MAX_SOLVES_PER_LOAD - 1)
    slow_curve = half_space(*bodies, [0.0], boundary="periodic", **adhesion_options)
    monkeypatch.undo()
    monkeypatch.setattr(adhesion, "MAX_MINIMIZATION_STEPS", 3)
    curve = half_space(*bodies, [0.0], boundary="periodic", **adhesion_options)
    assert (curve.contact(0).pressure == slow_curve.contact(0).pressure).all()


class SolutionRecordThatInterrupts(SolutionRecord):
    """Record that interrupts the computation when it is offered a state, or that continues from a stored state."""

    def __init__(self, interrupted_offer=None, state=None):
        super().__init__()
        self.interrupted_offer, self.state, self.num_offers = interrupted_offer, state, 0

    def read_state(self):
        return self.state

    def offer_state(self, get_state):
        self.num_offers += 1
        if self.num_offers == self.interrupted_offer:
            self.state = {name: np.asarray(value) for name, value in get_state().items()}
            raise InterruptedError


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_resumed_energy_minimization_gives_bit_identical_results(boundary):
    bodies, adhesion_options = create_rough_bodies(0.02, 5e-5, modulus=2e-3, spacing=0.2, length=0.1001)
    curve = half_space(*bodies, [0.0], boundary=boundary, **adhesion_options)
    start = AdhesionSolver(curve._problem, tolerance=1e-6, report=None).find_equilibrium_at_pressure(None, 0.0)[0]

    def minimize(record):
        solver = AdhesionSolver(curve._problem, tolerance=1e-6, report=None, record=record)
        return EnergyMinimizer(solver).minimize(start, -0.95 * curve.pull_off / solver.mean_pressure_to_force(1.0))

    complete_record, interrupted_record = (
        SolutionRecordThatInterrupts(),
        SolutionRecordThatInterrupts(interrupted_offer=5),
    )
    expected_state = minimize(complete_record)
    with pytest.raises(InterruptedError):
        minimize(interrupted_record)
    continued_record = SolutionRecordThatInterrupts(state=interrupted_record.state)
    state = minimize(continued_record)
    assert (state.pressure == expected_state.pressure).all()
    assert (state.attraction == expected_state.attraction).all()
    assert continued_record.num_offers == complete_record.num_offers - 4


def test_energy_minimization_releases_the_interpreter_lock():
    bodies, adhesion_options = create_rough_bodies(0.02, 5e-5, points=64, modulus=2e-3, spacing=0.2, length=0.1001)
    curve = half_space(*bodies, [0.0], boundary="periodic", **adhesion_options)
    solver = AdhesionSolver(curve._problem, tolerance=1e-6, report=None)
    start = solver.find_equilibrium_at_pressure(None, 0.0)[0]
    minimizer = EnergyMinimizer(solver)
    assert releases_interpreter_lock(lambda: minimizer.minimize(start, -0.1 * start.mean_attraction))


def test_pull_off_force_is_a_lower_bound_if_no_tensile_load_is_solved(monkeypatch):
    bodies, adhesion_options = create_soft_bodies_in_complete_contact()
    curve = half_space(*bodies, [0.0], boundary="periodic", **adhesion_options)
    assert not curve.pull_off_is_bound
    monkeypatch.setattr(adhesion, "MAX_TRIAL_LOADS", 0)
    limited_curve = half_space(*bodies, [0.0], boundary="periodic", **adhesion_options)
    assert limited_curve.pull_off_is_bound
    with pytest.warns(UserWarning, match="the pull-off force is at least"):
        assert 0 < limited_curve.pull_off < curve.pull_off


def test_pull_off_force_is_a_lower_bound_if_the_energy_minimization_does_not_converge(monkeypatch):
    bodies, adhesion_options = create_soft_bodies_in_complete_contact()
    curve = half_space(*bodies, [0.0], boundary="periodic", **adhesion_options)
    assert curve.contact(0).pressure.all()
    monkeypatch.setattr(adhesion, "MAX_MINIMIZATION_STEPS", 3)
    assert curve.pull_off_is_bound


@pytest.mark.parametrize(
    "case",
    [create_rough_bodies(1e-3, 5e-5), create_rough_bodies(3e-3, 5e-5, modulus=2.0, length=2e-3)],
    ids=["hard", "soft"],
)
def test_work_done_in_loading_and_unloading_equals_the_change_in_energy(case):
    """Check that the work over a closed loop is the energy lost in jumps, which is 0 without jumps."""
    bodies, adhesion_options = case
    area, unloaded_curve = 0.64**2, half_space(*bodies, [0.0], boundary="periodic", **adhesion_options)
    loads = np.linspace(0, 0.001 * adhesion_options["effective_modulus"] * area, 41)
    works_of_paths = []
    for path_loads in (loads, loads[::-1], np.linspace(0, -0.9 * unloaded_curve.pull_off, 41)):
        curve = half_space(*bodies, path_loads, boundary="periodic", **adhesion_options)
        energies = []
        for load_index in (0, -1):
            contact, problem = curve.contact(load_index), curve._problem
            net_pressure = contact.pressure - curve.at(load_index).attraction
            elastic_energy = net_pressure * problem.grids.displacement(net_pressure) / 2
            adhesive_energy = adhesion_options["work_of_adhesion"] * np.exp(
                -np.maximum(contact.gap, 0) / curve.adhesion_range
            )
            energies.append(problem.cell_area * float((elastic_energy - adhesive_energy).sum()))
        works_of_paths.append(float(trapezoid(curve.load, curve.approach)))
        assert works_of_paths[-1] == pytest.approx(energies[1] - energies[0], rel=STEP_SUM_TOLERANCE)
    assert works_of_paths[0] == pytest.approx(-works_of_paths[1], rel=STEP_SUM_TOLERANCE)
    assert works_of_paths[2] > 0


@pytest.mark.soak
def test_random_adhesive_contacts_converge_and_few_pull_off_forces_are_only_lower_bounds():
    """Solve 200 random pairs with E* from 1 MPa to 200 GPa and w from 1 mJ/m² to 1 J/m².

    Some of them have a hardness.
    """
    random, num_bounds = np.random.default_rng(5), 0
    for _ in range(200):
        modulus, work = 10 ** random.uniform(-3, 2.3), 10 ** random.uniform(-6, -3)
        rms, spacing = 10 ** random.uniform(-3.3, -1.3), 10 ** random.uniform(-2.5, -0.5)
        bodies, adhesion_options = create_rough_bodies(
            rms, work, modulus=modulus, length=5e-4, spacing=spacing, seed=int(random.integers(1e6))
        )
        strength = work / max(5e-4, (2 * spacing * work / modulus) ** 0.5)
        if random.random() < 0.4:
            adhesion_options["hardness"] = max(modulus * 10 ** random.uniform(-2.5, -0.5), 2 * strength)
        load = 0.003 * min(modulus, adhesion_options.get("hardness", modulus)) * (32 * spacing) ** 2
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            curve = half_space(
                *bodies, [0.0, load], boundary=str(random.choice(["free", "periodic"])), **adhesion_options
            )
            assert curve.normal_elastic == pytest.approx([0, load], abs=1e-4 * curve.contact_load.max())
            assert curve.pull_off > 0
            num_bounds += curve.pull_off_is_bound
    assert num_bounds <= MAX_LOWER_BOUND_FORCES


def test_maugis_dugdale_solution_tends_to_jkr_and_dmt_solutions():
    adhesion_arguments = {"work_of_adhesion": 1e-4}
    loads = np.array([2e-4, 0.0, -2e-4])
    jkr_limit = maugis_dugdale(loads, 1.0, 1e-4, **adhesion_arguments, adhesion_range=1e-3)
    dmt_limit = maugis_dugdale(loads, 1.0, 1e4, **adhesion_arguments, adhesion_range=1e-3)
    assert np.allclose(jkr_limit, jkr(loads, 1.0, 1e-4, **adhesion_arguments), rtol=1e-3)
    assert np.allclose(dmt_limit, dmt(loads, 1.0, 1e4, **adhesion_arguments), rtol=1e-2)
    for law in (jkr, dmt):
        assert np.isnan(law(-1.0, 1.0, 1.0, **adhesion_arguments)[0])


def test_maugis_dugdale_contact_radius_is_nan_for_tensions_beyond_the_pull_off_force():
    adhesion_options = {"work_of_adhesion": 5e-5, "adhesion_range": 5e-4}
    pull_off = float(maugis_dugdale(0.0, 3.0, 80.0, **adhesion_options)[1])
    radius, _ = maugis_dugdale([-1.001 * pull_off, -0.999 * pull_off], 3.0, 80.0, **adhesion_options)
    assert np.isnan(radius).tolist() == [True, False]


def test_fuller_tabor_pull_off_force_equals_the_sum_over_summit_heights():
    radius, modulus, work = 2.0, 1.3, 1e-3
    a = np.geomspace(1e-3, 3.0, 200_000)
    force = 4 * modulus * a**3 / (3 * radius) - np.sqrt(8 * np.pi * work * modulus * a**3)
    overlap = a**2 / radius - np.sqrt(2 * np.pi * work * a / modulus)
    pull_off_index = int(np.argmin(overlap))
    deviations = -overlap[pull_off_index] * np.array([0.01, 0.5, 1.0, 2.0])
    parameter, relative_force = fuller_tabor(deviations, radius, modulus, work_of_adhesion=work)
    assert parameter == pytest.approx([0.01, 0.5, 1.0, 2.0], rel=1e-4)
    assert relative_force[0] == pytest.approx(1, rel=1e-3)
    heights = norm.ppf((np.arange(20_000) + 0.5) / 20_000)
    for deviation_index in (1, 2, 3):
        deviation = deviations[deviation_index]
        mean_forces = [
            np.interp(heights * deviation - gap, overlap[pull_off_index:], force[pull_off_index:], left=0.0).mean()
            for gap in np.linspace(-2 * deviation, 6 * deviation, 400)
        ]
        assert relative_force[deviation_index] == pytest.approx(
            -min(mean_forces) / (1.5 * np.pi * work * radius), rel=0.01
        )


def test_friction_coefficient_of_adhesive_surfaces_increases_as_the_load_decreases():
    bodies, adhesion_options = create_rough_bodies(1e-3, 5e-5)
    loads = np.array([0.01, 0.0, -0.001])
    curve = half_space(*bodies, loads, boundary="periodic", sliding="all", **adhesion_options)
    assert curve.normal_elastic == pytest.approx(loads, abs=1e-4 * curve.contact_load[0])
    assert curve.tangential_load(mu0=0.3) == pytest.approx(0.3 * curve.contact_load, rel=0.1)
    assert (np.diff(curve.contact_load) < 0).all()
    assert curve.contact_load[1] > 0
    friction = curve.friction_coefficient(mu0=0.3)
    assert friction[0] > 0.3
    assert np.isnan(friction[2])
    assert curve.with_sliding("opposing").normal_elastic == pytest.approx(curve.normal_elastic)


def test_pressures_at_zero_work_of_adhesion_are_bit_identical_to_pressures_without_adhesion():
    bodies, adhesion_options = create_ball_on_flat(1.0)
    curve_without_adhesion = half_space(*bodies, [1e-4, 2e-4], effective_modulus=1.0)
    zero_adhesion_curve = half_space(
        *bodies, [1e-4, 2e-4], effective_modulus=1.0, work_of_adhesion="0 J/m^2", adhesion_range="1 nm"
    )
    assert (curve_without_adhesion.contact(0).pressure == zero_adhesion_curve.contact(0).pressure).all()
    assert (curve_without_adhesion.contact_load == curve_without_adhesion.load).all()
    assert zero_adhesion_curve.pull_off == 0
    weakly_adhesive_curve = half_space(*bodies, [1e-4, 2e-4], **adhesion_options | {"work_of_adhesion": 1e-12})
    assert weakly_adhesive_curve.contact_area == pytest.approx(curve_without_adhesion.contact_area, rel=1e-6)


def test_pull_off_force_is_positive_even_if_two_successive_iterations_change_nothing():
    """Solve a case in which two consecutive iterations change nothing, so that the ratio of their changes is 0/0."""
    columns = "0011000010111 0010010101100", "0101010011010 0100101100001"
    sign_arrays = [np.array([[int(sign) for sign in column] for column in text.split()]).T for text in columns]
    upper, lower = (
        Surface(scale * (2.0 * signs - 1), spacing=(0.0392, 0.00392))
        for scale, signs in zip((0.05, 0.13), sign_arrays, strict=True)
    )
    curve = half_space(
        upper, lower, [1e-7], boundary="periodic", effective_modulus=1.4556, hardness=0.011425,
        work_of_adhesion=1.16636e-8, adhesion_range=4.739e-5,
    )  # fmt: skip
    assert curve.pull_off > 0


def test_half_space_rejects_invalid_adhesion_arguments():
    bodies, adhesion_options = create_ball_on_flat(1.0)
    with pytest.raises(ValueError, match="strictly increasing or strictly decreasing"):
        half_space(*bodies, [1.0, 0.0, 1.0], **adhesion_options)
    with pytest.raises(ValueError, match="approaches must not be given for surfaces with adhesion"):
        half_space(*bodies, approaches=[1e-3], **adhesion_options)
    with pytest.raises(ValueError, match="work_of_adhesion must be"):
        half_space(*bodies, [1.0], work_of_adhesion=-1.0)
    with pytest.raises(ValueError, match="a unit of work of adhesion"):
        half_space(*bodies, [1.0], work_of_adhesion="50 mJ/mm")
    with pytest.raises(ValueError, match=r"hardness must be above .* GPa, the attraction in contact"):
        half_space(*bodies, [1.0], hardness=1e-3, **adhesion_options)
    with pytest.raises(RuntimeError, match="separate"):
        half_space(*bodies, [-2 * np.pi * adhesion_options["work_of_adhesion"]], **adhesion_options)


def test_adhesion_range_below_grid_resolution_is_increased_with_a_warning():
    bodies, adhesion_options = create_ball_on_flat(1.0)
    with pytest.warns(UserWarning, match="adhesion_range = 0.1 nm is increased to"):
        curve = half_space(*bodies, [0.0], **adhesion_options | {"adhesion_range": 1e-4})
    assert curve.adhesion_range > 1e-4


@pytest.mark.parametrize(("modulus", "length", "rms"), [(80.0, 5e-4, 1e-3), (2.0, 2e-3, 5e-3)])
def test_pull_off_force_is_independent_of_grid_spacing(modulus, length, rms):
    values = []
    for points in (64, 96, 128):
        random, x = np.random.default_rng(1), np.arange(points) / points
        heights = np.zeros((points, points))
        for i, j in np.ndindex(13, 7):
            wave, phase, amplitude = np.hypot(i - 6, j), 2 * np.pi * random.random(), random.standard_normal()
            if 2 <= wave <= 6:
                heights += amplitude * wave**-1.8 * np.cos(2 * np.pi * ((i - 6) * x[:, None] + j * x) + phase)
        bodies = (Surface(body_heights, spacing=1.28 / points) for body_heights in (0 * heights, rms * heights))
        adhesion_options = {"work_of_adhesion": 5e-5, "adhesion_range": length}
        values.append(
            half_space(*bodies, [0.0], effective_modulus=modulus, boundary="periodic", **adhesion_options).pull_off
        )
    assert values[0] > 0
    assert values[1:] == pytest.approx(values[:1] * 2, rel=SPACING_TOLERANCE)
