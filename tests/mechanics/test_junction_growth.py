import numpy as np
import pytest
from scipy.optimize import brentq
from stiction import half_space, hardness_under_shear, self_affine_surface, tabor_friction
from stiction.mechanics.friction import FrictionLaw

ROUND_OFF = 1e-12

PLASTIC_TOLERANCE = 5e-3
"""Relative difference between a half-space whose contacts all yield and Tabor's closed form."""


def random_junction_parameters(count=200):
    random = np.random.default_rng(7)
    for _ in range(count):
        hardness, mu0, alpha = 10 ** random.uniform(-2, 1.5), random.uniform(0, 0.6), random.uniform(0.1, 27)
        yield hardness, mu0, random.uniform(0, 0.98) * hardness / np.sqrt(alpha), alpha


def test_hardness_under_shear_satisfies_yield_and_friction_laws():
    for hardness, mu0, tau0, alpha in random_junction_parameters():
        pressure = float(hardness_under_shear(hardness, mu0, tau0, alpha))
        assert 0 < pressure <= hardness
        assert pressure**2 + alpha * (mu0 * pressure + tau0) ** 2 == pytest.approx(hardness**2, rel=ROUND_OFF)


def tabor_equation_residual(friction, mu0, ratio, alpha):
    return friction - mu0 - ratio * np.sqrt(1 + alpha * friction**2)


def test_tabor_friction_solves_its_equation_and_agrees_with_the_hardness_under_shear():
    for hardness, mu0, tau0, alpha in random_junction_parameters():
        ratio = tau0 / hardness
        upper_bound = 1 + (mu0 + ratio) / (1 - ratio * np.sqrt(alpha))
        root = brentq(tabor_equation_residual, mu0, upper_bound, args=(mu0, ratio, alpha), xtol=1e-14)
        result = float(tabor_friction(hardness, mu0, tau0, alpha))
        assert result == pytest.approx(root, rel=1e-9)
        assert result == pytest.approx(mu0 + tau0 / hardness_under_shear(hardness, mu0, tau0, alpha), rel=1e-9)


def test_hardness_under_shear_equals_the_hardness_if_junction_growth_is_zero():
    hardness = np.random.default_rng(1).uniform(0.01, 20, 1000)
    assert (hardness_under_shear(hardness, 0.3, 0.05, 0.0) == hardness).all()


def test_tabor_friction_equals_mu0_if_the_adhesive_strength_is_zero():
    alpha = np.array([0.0, 9.0, 27.0])
    assert tabor_friction(1.0, 0.3, 0.0, alpha) == pytest.approx(0.3, rel=ROUND_OFF)
    assert (np.diff(hardness_under_shear(1.0, 0.3, 0.0, alpha)) < 0).all()


def test_tabor_friction_is_nan_for_an_interface_stronger_than_the_bulk():
    bulk_strength = 1 / np.sqrt(27)
    for tau0 in (bulk_strength * (1 + 1e-9), 2 * bulk_strength):
        assert np.isnan(hardness_under_shear(1.0, 0.2, tau0, 27.0))
        assert np.isnan(tabor_friction(1.0, 0.2, tau0, 27.0))
    assert np.isfinite(tabor_friction(1.0, 0.2, bulk_strength * (1 - 1e-9), 27.0))


@pytest.mark.parametrize("alpha", [0.0, 9.0, 27.0])
def test_half_space_friction_at_hardness_under_shear_equals_tabor_friction(alpha):
    interface = {"mu0": 0.2, "tau0": 0.02}
    roughness_options = {"hurst_exponent": 0.8, "rms": 0.01, "shape": (64, 64), "spacing": 1.0}
    bodies = (self_affine_surface(3, side=side, **roughness_options) for side in ("upper", "lower"))
    hardness = float(hardness_under_shear(0.2, **interface, alpha=alpha))
    curve = half_space(*bodies, ["2 MPa"], effective_modulus=1e5, hardness=hardness, sliding="all")
    expected = tabor_friction(0.2, **interface, alpha=alpha)
    assert curve.load_share_at_hardness[0] > 0.95
    assert curve.friction_coefficient(**interface)[0] == pytest.approx(float(expected), rel=PLASTIC_TOLERANCE)


@pytest.mark.parametrize("law", [hardness_under_shear, tabor_friction])
@pytest.mark.parametrize(("arguments", "word"), [
    ((0.0, 0.2, 0.1, 9.0), "hardness"), ((1.0, -0.2, 0.1, 9.0), "mu0"), ((1.0, 0.2, -0.1, 9.0), "tau0"),
    ((1.0, 0.2, 0.1, -9.0), "alpha"),
])  # fmt: skip
def test_errors_of_junction_growth_functions_name_the_invalid_argument(law, arguments, word):
    with pytest.raises(ValueError, match=word):
        law(*arguments)


def test_friction_law_carries_the_hardness_of_yielding_contacts_under_shear():
    law = FrictionLaw(0.2, 0.05, 9.0)
    pressure = hardness_under_shear(1.27, 0.2, 0.05, 9.0)
    assert law.yield_pressure(1.27) == pytest.approx(float(pressure), rel=1e-15)
    # All contacts yield, so the area is the load over the pressure.
    assert law.plastic_coefficient(1.27) == pytest.approx(law.force(3.0, 3.0 / pressure) / 3.0, rel=1e-15)
    assert law.plastic_coefficient(1.27) == pytest.approx(float(tabor_friction(1.27, 0.2, 0.05, 9.0)), rel=1e-15)
    without_growth = FrictionLaw(0.2, 0.05)
    assert without_growth.yield_pressure(1.27) == 1.27
    assert without_growth.plastic_coefficient(1.27) == 0.2 + 0.05 / 1.27
    assert np.isnan(FrictionLaw(0.2, 1.0, 9.0).plastic_coefficient(1.27))  # tau0 exceeds H/√α
