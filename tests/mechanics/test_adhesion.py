import numpy as np
import pytest
from reference.least_energy import least_energy
from stiction import Surface, dmt, half_space, jkr, maugis_dugdale, self_affine_surface, tabor_parameter

OF_GAPS = 1e-3
"""Difference between two solutions over the range of adhesion; where bodies are soft the least energy is flat."""

STABLE = 0.03
"""Fraction of the pull-off force inside which the least energy holds and outside which it does not."""

OF_MEAN_GAP = 1e-4
"""Difference over the contact load between loads at one mean gap, each to a tolerance of 1e-5 of it."""

OF_POINTS = 1e-3
"""Fraction of the grid at whose points under a vanishing pressure two solvers may differ."""

ROUND_OFF = 1e-12

OF_PERIODS = 0.02
"""Difference over a ball's pull-off force between a period of 20 radii of its contact and a piece of 10 alone."""

OF_LAWS = 0.06
"""Difference over the pull-off force between an exponential attraction and one that ends at its range."""


def ball(tabor, *, points=64, length=10.0):
    """A ball of radius 1 µm on a flat; the radius (µm) of its contact is the unit of length, the range 1 nm."""
    height = tabor * 1e-3
    spacing = length * height**0.5 / points
    x = (np.arange(points) - points // 2) * spacing
    flat = np.zeros((points, points))
    bodies = Surface(flat, spacing=spacing), Surface(-(x[:, None] ** 2 + x**2) / 2, spacing=spacing)
    return bodies, {"effective_modulus": 1.0, "work_of_adhesion": height**1.5, "adhesion_range": 1e-3}


def rough(rms, work, *, points=32, modulus=80.0, length=1e-3, spacing=0.02, seed=3):
    waves = {"longest_wavelength": points * spacing / 2, "shortest_wavelength": 4 * spacing}
    shape = {"shape": (points, points), "spacing": spacing}
    lower = self_affine_surface(seed, hurst_exponent=0.8, rms=rms, **shape, **waves)
    bodies = Surface(np.zeros((points, points)), spacing=spacing), lower
    return bodies, {"effective_modulus": modulus, "work_of_adhesion": work, "adhesion_range": length}


@pytest.mark.parametrize(
    "case",
    [
        ball(0.3, points=32),
        ball(1.0, points=32),
        rough(1e-3, 5e-5),
        rough(3e-3, 3e-4),
        rough(0.02, 5e-5, modulus=2e-3, spacing=0.2, length=0.1001),
    ],
    ids=["hard ball", "ball", "smooth", "rough", "silicone"],
)
def test_the_contact_is_the_least_energy_and_parts_where_that_does(case):
    bodies, adhesive = case
    curve = half_space(*bodies, [0.0], boundary="periodic", **adhesive)
    gap, area = -bodies[1].heights, bodies[0].heights.size * bodies[0].spacing[0] ** 2
    heights = gap - gap.min()
    noise = 0.01 * adhesive["adhesion_range"] * np.random.default_rng(1).random(gap.shape)
    for part in (0.0, -1 + STABLE):
        load = part * curve.pull_off
        contact = half_space(*bodies, [load], boundary="periodic", **adhesive).contact(0)
        near = np.maximum(contact.gap, 0) + noise
        gap, pressure = least_energy(heights, bodies[0].spacing[0], load / area, near, **adhesive)
        assert np.abs(gap - contact.gap).max() < OF_GAPS * adhesive["adhesion_range"] * (1 if part == 0 else 10)
        assert pressure.mean() == pytest.approx(contact.pressure.mean(), rel=OF_GAPS)
        assert ((gap == 0) != (contact.pressure > 0)).sum() <= 1
    beyond = (-1 - STABLE) * curve.pull_off / area
    gap, _ = least_energy(heights, bodies[0].spacing[0], beyond, near, **adhesive)
    assert (gap > 0).all()


@pytest.mark.parametrize(("rms", "modulus", "load"), [(1e-3, 80.0, 0.01), (3e-3, 80.0, 0.1), (3e-3, 2.0, 2e-3)])
def test_agrees_with_tamaas_at_equal_mean_gap(rms, modulus, load):
    tamaas = pytest.importorskip("tamaas")
    (flat, lower), adhesive = rough(rms, 5e-5, points=64, modulus=modulus)
    area = lower.heights.size * lower.spacing[0] ** 2
    curve = half_space(flat, lower, [load * area], boundary="periodic", **adhesive)
    contact = curve.contact(0)
    lengths = [64 * lower.spacing[0]] * 2
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, lengths, [64, 64])
    model.E, model.nu = modulus, 0
    heights, gap = np.array(lower.heights), tamaas.PolonskyKeerRey.gap
    solver = tamaas.PolonskyKeerRey(model, heights, 1e-11, gap, gap)
    attraction = tamaas.ExponentialAdhesionFunctional(heights)
    attraction.parameters = {"rho": curve.adhesion_range, "surface_energy": adhesive["work_of_adhesion"]}
    solver.addFunctionalTerm(attraction)
    solver.max_iter = 20_000
    solver.solve(contact.gap.mean())
    per_contact = curve.contact_load[0] / area
    assert model.traction.mean() == pytest.approx(load, abs=OF_MEAN_GAP * per_contact)
    assert ((np.asarray(model["gap"]) <= ROUND_OFF) == (contact.pressure > 0)).mean() > 1 - OF_POINTS


@pytest.mark.parametrize("tabor", [0.3, 1.0, 1.7])
def test_a_ball_is_held_as_by_maugis_whatever_the_period(tabor):
    bodies, adhesive = ball(tabor)
    assert tabor_parameter(1.0, 1.0, **{name: adhesive[name] for name in ("work_of_adhesion", "adhesion_range")}) == (
        pytest.approx(tabor)
    )
    unit = np.pi * adhesive["work_of_adhesion"]
    free = half_space(*bodies, [unit], **adhesive)
    wide, _ = ball(tabor, points=128, length=20.0)
    periodic = half_space(*wide, [unit], boundary="periodic", **adhesive)
    assert free.pull_off == pytest.approx(periodic.pull_off, rel=OF_PERIODS)
    radius, pull_off = maugis_dugdale(unit, radius=1.0, **adhesive)
    assert free.pull_off == pytest.approx(float(pull_off), rel=OF_LAWS)
    assert 1.5 * unit < free.pull_off < 2 * unit
    assert np.sqrt(free.contact_area[0] / np.pi) == pytest.approx(float(radius), rel=OF_LAWS)


def test_closed_forms_meet_at_their_limits():
    work = {"work_of_adhesion": 1e-4}
    loads = np.array([2e-4, 0.0, -2e-4])
    soft = maugis_dugdale(loads, 1.0, 1e-4, **work, adhesion_range=1e-3)
    hard = maugis_dugdale(loads, 1.0, 1e4, **work, adhesion_range=1e-3)
    assert np.allclose(soft, jkr(loads, 1.0, 1e-4, **work), rtol=1e-3)
    assert np.allclose(hard, dmt(loads, 1.0, 1e4, **work), rtol=1e-2)
    for law in (jkr, dmt):
        assert np.isnan(law(-1.0, 1.0, 1.0, **work)[0])


def test_bodies_that_stick_rub_at_no_load():
    bodies, adhesive = rough(1e-3, 5e-5)
    loads = np.array([0.01, 0.0, -0.001])
    curve = half_space(*bodies, loads, boundary="periodic", sliding="all", **adhesive)
    assert curve.normal_elastic == pytest.approx(loads, abs=1e-4 * curve.contact_load[0])
    assert curve.tangential_load(mu0=0.3) == pytest.approx(0.3 * curve.contact_load, rel=0.1)
    assert (np.diff(curve.contact_load) < 0).all()
    assert curve.contact_load[1] > 0
    friction = curve.friction_coefficient(mu0=0.3)
    assert friction[0] > 0.3
    assert np.isnan(friction[2])
    assert curve.with_sliding("opposing").normal_elastic == pytest.approx(curve.normal_elastic)


def test_without_adhesion_the_bits_are_those_of_today():
    bodies, adhesive = ball(1.0)
    plain = half_space(*bodies, [1e-4, 2e-4], effective_modulus=1.0)
    none = half_space(*bodies, [1e-4, 2e-4], effective_modulus=1.0, work_of_adhesion="0 J/m^2", adhesion_range="1 nm")
    assert (plain.contact(0).pressure == none.contact(0).pressure).all()
    assert (plain.contact_load == plain.load).all()
    assert none.pull_off == 0
    little = half_space(*bodies, [1e-4, 2e-4], **adhesive | {"work_of_adhesion": 1e-12})
    assert little.contact_area == pytest.approx(plain.contact_area, rel=1e-6)


def test_refusals_say_what_is_wrong():
    bodies, adhesive = ball(1.0)
    with pytest.raises(ValueError, match="strictly increasing or strictly decreasing"):
        half_space(*bodies, [1.0, 0.0, 1.0], **adhesive)
    with pytest.raises(ValueError, match="approaches are for bodies without adhesion"):
        half_space(*bodies, approaches=[1e-3], **adhesive)
    with pytest.raises(ValueError, match="work_of_adhesion must be"):
        half_space(*bodies, [1.0], work_of_adhesion=-1.0)
    with pytest.raises(ValueError, match="a unit of work of adhesion"):
        half_space(*bodies, [1.0], work_of_adhesion="50 mJ/mm")
    with pytest.raises(ValueError, match="hardness must be above the attraction in contact"):
        half_space(*bodies, [1.0], hardness=1e-3, **adhesive)
    with pytest.raises(RuntimeError, match="come off"):
        half_space(*bodies, [-2 * np.pi * adhesive["work_of_adhesion"]], **adhesive)


def test_a_range_that_the_grid_does_not_resolve_is_raised():
    bodies, adhesive = ball(1.0)
    with pytest.warns(UserWarning, match="adhesion_range = 0.1 nm is raised to"):
        curve = half_space(*bodies, [0.0], **adhesive | {"adhesion_range": 1e-4})
    assert curve.adhesion_range > 1e-4
