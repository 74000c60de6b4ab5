import numpy as np
import pytest
from scipy.ndimage import map_coordinates
from scipy.optimize import brentq
from stiction import half_space, hardness_under_shear, self_affine_surface, tabor_friction
from stiction._core import interpolate_table
from stiction.mechanics.friction import FrictionLaw, _tabulate_capped_pressure_ratios

ROUND_OFF = 1e-12

PLASTIC_TOLERANCE = 5e-3
"""Relative difference between the half-space model, in which all contacts yield, and Tabor's closed form."""


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
def test_half_space_friction_of_fully_plastic_contacts_equals_tabor_friction(alpha):
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


def test_friction_law_computes_the_hardness_and_friction_of_yielding_contacts_under_shear():
    law = FrictionLaw(0.2, 0.05, 9.0)
    pressure = hardness_under_shear(1.27, 0.2, 0.05, 9.0)
    assert law.yield_pressure(1.27) == pytest.approx(float(pressure), rel=1e-15)
    assert law.plastic_coefficient(1.27) == pytest.approx(law.force(3.0, 3.0 / pressure) / 3.0, rel=1e-15)
    assert law.plastic_coefficient(1.27) == pytest.approx(float(tabor_friction(1.27, 0.2, 0.05, 9.0)), rel=1e-15)
    without_growth = FrictionLaw(0.2, 0.05)
    assert without_growth.yield_pressure(1.27) == 1.27
    assert without_growth.plastic_coefficient(1.27) == 0.2 + 0.05 / 1.27
    assert np.isnan(FrictionLaw(0.2, 1.0, 9.0).plastic_coefficient(1.27))  # tau0 exceeds H/√α


# ---- Slip lines ------------------------------------------------------------------------------------------------------

SLIP_LINE_TOLERANCE = 1e-10
HARDNESS_TO_SHEAR_STRENGTH = 5.6


def solve_slip_lines(hardness, mu0, tau0, ratio):
    """Return H', found by bracketing the root in the pressure, or None if the interface is stronger than the bulk."""

    def slip_line_residual(pressure):
        traction_over_strength = min(ratio * (mu0 * pressure + tau0) / hardness, 1.0)
        angle = 1 + np.pi / 2 + np.arccos(traction_over_strength) + np.sqrt(1 - traction_over_strength**2)
        return pressure / hardness - angle / (2 + np.pi)

    if ratio * (0.5 * mu0 + tau0 / hardness) > 1:
        return None
    return brentq(slip_line_residual, 0.5 * hardness, hardness, xtol=1e-15, rtol=1e-15)


def random_slip_line_parameters(count=300):
    random = np.random.default_rng(11)
    for _ in range(count):
        hardness, ratio = 10 ** random.uniform(-2, 1.5), random.uniform(5.14, 6.05)
        yield hardness, random.uniform(0, 0.35), random.uniform(0, 0.15) * hardness, ratio


def test_slip_line_hardness_under_shear_equals_the_root_of_the_slip_line_equation():
    num_stronger = 0
    for hardness, mu0, tau0, ratio in random_slip_line_parameters():
        expected = solve_slip_lines(hardness, mu0, tau0, ratio)
        num_stronger += expected is None
        result = float(hardness_under_shear(hardness, mu0, tau0, "slip-line", ratio=ratio))
        assert result == pytest.approx(0.5 * hardness if expected is None else expected, rel=SLIP_LINE_TOLERANCE)
    assert 20 < num_stronger < 280


@pytest.mark.parametrize(("hardness", "mu0", "tau0", "plane_strain", "circle"), [
    (1.27, 0.2, 0.05, (0.258, 1.48), (0.262, 1.58)), (0.625, 0.2, 0.05, (0.343, 1.78), None),
    (0.625, 0.1, 0.02, (0.138, 1.19), (0.139, 1.22)), (0.625, 0.0, 0.1, (0.220, 1.37), (0.241, 1.51)),
    (1.27, 0.1, 0.05, (0.148, 1.21), (0.149, 1.25)), (0.625, 0.2, 0.1, None, None),
])  # fmt: skip
def test_slip_line_theory_gives_friction_and_growth_of_fully_plastic_contacts(
    hardness, mu0, tau0, plane_strain, circle
):
    for ratio, expected in ((2 + np.pi, plane_strain), (5.69, circle)):
        law = FrictionLaw(mu0, tau0, ratio, uses_slip_lines=True)
        friction, growth = law.plastic_coefficient(hardness), hardness / law.yield_pressure(hardness)
        assert law.is_stronger_than_body(hardness) == (expected is None)
        expected_friction, expected_growth = expected or (2 / ratio, 2.0)
        assert friction == pytest.approx(expected_friction, abs=5e-4)
        assert growth == pytest.approx(expected_growth, abs=5e-3)


@pytest.mark.parametrize("ratio", [5.14, HARDNESS_TO_SHEAR_STRENGTH, 6.05])
def test_slip_line_yield_pressure_has_exact_limits_at_zero_and_full_traction(ratio):
    without_shear = FrictionLaw(0.0, 0.0, ratio, uses_slip_lines=True)
    assert float(without_shear.yield_pressure(1.27)) == pytest.approx(1.27, rel=1e-15)
    strength = 1.27 / ratio
    at_strength = FrictionLaw(0.0, strength, ratio, uses_slip_lines=True)
    assert float(at_strength.yield_pressure(1.27)) == pytest.approx(0.635, rel=1e-7)
    coulomb = FrictionLaw(0.2, 0.0, ratio, uses_slip_lines=True)
    assert float(coulomb.plastic_coefficient(1.27)) == 0.2
    approach = FrictionLaw(0.2, strength * (0.9 - 1e-12) - 0.1 * 1.27 + 0.1 * strength, ratio, uses_slip_lines=True)
    assert float(approach.plastic_coefficient(1.27)) == pytest.approx(2 / ratio, rel=1e-5)


@pytest.mark.parametrize(("hardness", "mu0", "tau0_over_hardness"), [
    (0.6, 0.6, 0.0), (1.2, 0.4, 0.1), (2.5, 0.2, 0.15), (5.0, 0.6, 0.0), (10.0, 0.6, 0.0),
])  # fmt: skip
def test_lower_limit_of_friction_in_bulk_shear_agrees_with_a_sum_over_contact_points(hardness, mu0, tau0_over_hardness):
    roughness_options = {"hurst_exponent": 0.8, "rms": 0.03, "shape": (128, 128), "shortest_wavelength": 0.6}
    bodies = (self_affine_surface(3, side=side, spacing=0.1, **roughness_options) for side in ("upper", "lower"))
    curve = half_space(
        *bodies, ["5 MPa"], effective_modulus=60.0, hardness=0.5 * hardness, boundary="periodic", sliding="all"
    )
    pressure = curve.contact(0).pressure
    pressure = pressure[pressure > 0]
    law = FrictionLaw(mu0, tau0_over_hardness * hardness, HARDNESS_TO_SHEAR_STRENGTH, uses_slip_lines=True)
    traction = law.force(pressure, 1.0)
    limited_traction = np.minimum(traction, hardness / HARDNESS_TO_SHEAR_STRENGTH).sum()
    load, area = pressure.sum(), float(pressure.size)
    onset = law.onset(load, hardness, 1e9, lambda largest: np.full(np.shape(largest), area))
    expected = limited_traction / traction.sum()
    if expected < 0.95:
        assert 0.93 * expected < onset.friction_fraction < 1.03 * expected
    else:  # the model neglects a reduction of friction below 5 %
        assert onset.friction_fraction == 1


def limit_pressures(log_scale, unlimited_pressures):
    return np.minimum(np.exp(log_scale) * unlimited_pressures, 1.0)


def excess_of_mean_pressure(log_scale, unlimited_pressures, mean):
    return limit_pressures(log_scale, unlimited_pressures).mean() - mean


def test_friction_in_bulk_shear_agrees_with_a_mean_over_quantiles_of_the_pressure_distribution():
    """The pressures, as fractions of the largest, follow a Weibull distribution that is limited at 1."""
    random = np.random.default_rng(5)
    probabilities = (np.arange(200_000) + 0.5) / 200_000
    for mean in random.uniform(0.06, 0.95, 30):
        shape = 1.5 - 0.65 * mean
        unlimited_pressures = (-np.log1p(-probabilities)) ** (1 / shape)
        pressures = limit_pressures(
            brentq(excess_of_mean_pressure, -9, 9, args=(unlimited_pressures, mean)), unlimited_pressures
        )
        hardness, ratio, mu0, tau0 = 1.0, 5.6, random.uniform(0.4, 1.5), random.uniform(0.0, 0.05)
        # Contacts yield at half the hardness, because the interface is stronger than the body.
        traction = mu0 * 0.5 * hardness * pressures + tau0
        expected = np.minimum(traction, hardness / ratio).mean() / traction.mean()
        onset = FrictionLaw(mu0, tau0, ratio, True).onset(0.5 * mean, hardness, 1e3, np.ones_like)
        if expected < 0.949:
            assert onset.friction_fraction == pytest.approx(expected, abs=3e-4)
        elif expected > 0.951:
            assert onset.friction_fraction == 1


def test_interpolation_of_hardness_limited_pressures_equals_scipy_interpolation():
    table = _tabulate_capped_pressure_ratios()
    last_row, last_column = (size - 1 for size in table.shape)
    rows, columns = np.random.default_rng(3).uniform(0, [[last_row], [last_column]], (2, 1000))
    rows[:3], columns[:3] = [0, last_row, last_row], [0, 0.5, last_column]
    expected = map_coordinates(table, [rows, columns], order=1, mode="nearest")
    assert interpolate_table(table, rows, columns).tobytes() == expected.tobytes()
    limits = interpolate_table(table, np.array([-1.0, last_row + 1.0]), np.array([-2.0, last_column + 5.0]))
    assert limits.tolist() == [table[0, 0], table[-1, -1]]
    assert np.isnan(interpolate_table(table, np.array([np.nan, 0.0]), np.array([0.0, np.nan]))).all()
