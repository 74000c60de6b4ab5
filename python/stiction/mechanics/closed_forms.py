"""Closed-form solutions for single contacts, sinusoidal surfaces and rough surfaces, used as references in tests.

The module uses plain NumPy and is independent of the core. All arguments broadcast.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, Literal, ParamSpec, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, check_choice, float_array, unwrap_scalar
from stiction._units import short_repr
from stiction.mechanics.friction import (
    CENTRAL_SHEAR_RATIO,
    FrictionLaw,
    validate_friction_parameter,
    warn_if_tau0_is_large,
)
from stiction.mechanics.materials import Material
from stiction.mechanics.model import SlidingRule

# Number of bisections after which the logarithm of an ellipse's axis ratio is exact to the last bit.
_NUM_BISECTIONS = 64
_SLOPE_ROUND_OFF_TOLERANCE = 1e-9
# Below this standard deviation of slopes s, a short series gives the mean of (1 + s²)^(1/2) with full precision.
_SMALL_SLOPE_LIMIT = 1e-3

_P = ParamSpec("_P")
_R = TypeVar("_R")


def validate_positive_arguments(**arguments: ArrayLike) -> list[Floats]:
    """Check that all arguments are positive, and return them as arrays."""
    arrays = []
    for name, values in arguments.items():
        array = float_array(name, values)
        if not (array > 0).all():
            raise ValueError(f"{name} must be above 0, got {array[~(array > 0)][0]:g}")
        arrays.append(array)
    return arrays


def reject_overflow(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Wrap a function so that it raises a `ValueError` if a returned number overflows double precision."""

    @functools.wraps(function)
    def call_with_overflow_check(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        try:
            with np.errstate(over="raise", divide="raise", invalid="raise", under="ignore"):
                return function(*args, **kwargs)
        except ArithmeticError:
            # NumPy raises FloatingPointError, a subclass of ArithmeticError, if a number is out of range.
            raise ValueError(
                f"arguments of {function.__name__} must not be so large or so small that a computed value exceeds the "
                "range of double precision"
            ) from None

    return call_with_overflow_check


@overload
def effective_modulus(upper: Material, lower: Material, /) -> float: ...
@overload
def effective_modulus(young_upper: float, poisson_upper: float, young_lower: float, poisson_lower: float) -> float: ...
@overload
def effective_modulus(
    young_upper: ArrayLike, poisson_upper: ArrayLike, young_lower: ArrayLike, poisson_lower: ArrayLike
) -> Floats: ...
@reject_overflow
def effective_modulus(
    young_upper: Any, poisson_upper: Any, young_lower: Any = None, poisson_lower: Any = None
) -> Floats | float:
    """Compute the effective modulus E* of two bodies.

    Parameters
    ----------
    young_upper, young_lower : array_like of float
        Young's moduli E, above 0, both in the unit of the result.
    poisson_upper, poisson_lower : array_like of float
        Poisson's ratios ν, above -1 and at most 0.5.
    upper, lower : Material
        Materials, as two positional arguments instead of the four numbers.

    Returns
    -------
    modulus : float or ndarray of float
        E* in the unit of Young's moduli, with the broadcast shape of the arguments. For two materials a float in GPa,
        from the representative values of their ranges.

    Raises
    ------
    ValueError
        If an argument is outside its range, or materials and numbers are mixed.

    See Also
    --------
    material : Material by its name.

    Notes
    -----
    .. math:: 1/E^* = (1 - ν_u^2)/E_u + (1 - ν_l^2)/E_l

    Johnson, Contact Mechanics (1985), section 4.2.

    Examples
    --------
    >>> from stiction import effective_modulus, material
    >>> effective_modulus(200.0, 0.0, 200.0, 0.0)
    100.0
    >>> round(effective_modulus(material("gold"), material("silicon")), 1)
    59.5
    """
    if isinstance(young_upper, Material) or isinstance(poisson_upper, Material):
        if not (isinstance(young_upper, Material) and isinstance(poisson_upper, Material)):
            raise ValueError("effective_modulus requires two materials, or two moduli and two Poisson's ratios")
        if young_lower is not None or poisson_lower is not None:
            raise ValueError("effective_modulus accepts no other arguments if two materials are given")
        return 1 / (1 / young_upper.plane_strain_modulus + 1 / poisson_upper.plane_strain_modulus)
    upper_modulus, lower_modulus = validate_positive_arguments(young_upper=young_upper, young_lower=young_lower)
    poisson_ratios = []
    for name, values in (("poisson_upper", poisson_upper), ("poisson_lower", poisson_lower)):
        poisson_ratio = float_array(name, values)
        if not ((poisson_ratio > -1) & (poisson_ratio <= 0.5)).all():
            raise ValueError(f"{name} must be above -1 and at most 0.5, got {short_repr(values)}")
        poisson_ratios.append(poisson_ratio)
    modulus = 1 / ((1 - poisson_ratios[0] ** 2) / upper_modulus + (1 - poisson_ratios[1] ** 2) / lower_modulus)
    return float(modulus) if np.ndim(modulus) == 0 else np.asarray(modulus)


@reject_overflow
def hertz_sphere(overlap: ArrayLike, radius: ArrayLike, effective_modulus: ArrayLike) -> tuple[Floats, Floats]:
    r"""Compute contact force and contact area of two elastic spheres from their overlap (Hertz).

    Parameters
    ----------
    overlap : array_like of float, µm
        Overlap d of the undeformed spheres, which is the approach of distant points.
    radius : array_like of float, µm
        Effective radius R, 1/R = 1/R_u + 1/R_l.
    effective_modulus : array_like of float, GPa
        E*, see `effective_modulus`.

    Returns
    -------
    force : ndarray of float, mN
        Normal force F, with the broadcast shape of the arguments.
    area : ndarray of float, µm²
        Contact area A.

    Raises
    ------
    ValueError
        If an argument is not above 0.

    See Also
    --------
    hertz_ellipse : Bodies with two different relative radii.
    force_and_area : Contact laws of the asperity model.

    Notes
    -----
    .. math:: F = \tfrac43 E^* R^{1/2} d^{3/2}, \qquad A = π R d

    Hertz 1882; Johnson, Contact Mechanics (1985), eqs. 4.22-4.24.

    Examples
    --------
    >>> from stiction import hertz_sphere
    >>> force, area = hertz_sphere(overlap=0.25, radius=1.0, effective_modulus=3.0)
    >>> float(force)
    0.5
    """
    d, r, e = validate_positive_arguments(overlap=overlap, radius=radius, effective_modulus=effective_modulus)
    return np.asarray(4 / 3 * e * r**0.5 * d**1.5), np.asarray(np.pi * r * d)


@reject_overflow
def tabor_parameter(
    radius: ArrayLike, effective_modulus: ArrayLike, *, work_of_adhesion: ArrayLike, adhesion_range: ArrayLike
) -> Floats:
    r"""Compute the Tabor parameter of an adhesive sphere.

    Parameters
    ----------
    radius : array_like of float, µm
        Effective radius R, 1/R = 1/R_u + 1/R_l.
    effective_modulus : array_like of float, GPa
        E*, see `effective_modulus`.
    work_of_adhesion : array_like of float, mN/µm (kJ/m²)
        Energy w to separate a unit area.
    adhesion_range : array_like of float, µm
        Range ρ of the attraction.

    Returns
    -------
    parameter : ndarray of float
        Tabor parameter μ, dimensionless, with the broadcast shape of the arguments.

    Raises
    ------
    ValueError
        If an argument is not above 0.

    See Also
    --------
    jkr : Limit of parameters far above 1.
    dmt : Limit of parameters far below 1.

    Notes
    -----
    .. math:: μ = \left(\frac{R w^2}{E^{*2} ρ^3}\right)^{1/3}

    Tabor, Journal of Colloid and Interface Science 58 (1977) 2.

    Examples
    --------
    >>> from stiction import tabor_parameter
    >>> float(tabor_parameter(1.0, 80.0, work_of_adhesion=5e-5, adhesion_range=5e-4).round(2))  # silicon, 1 µm
    0.15
    """
    r, e, w, length = _validate_adhesion_arguments(
        radius, effective_modulus, work_of_adhesion, adhesion_range=adhesion_range
    )
    return np.asarray((r * w**2 / (e**2 * length**3)) ** (1 / 3))


@reject_overflow
def jkr(
    load: ArrayLike, radius: ArrayLike, effective_modulus: ArrayLike, *, work_of_adhesion: ArrayLike
) -> tuple[Floats, Floats]:
    r"""Compute the contact radius and the pull-off force of a large, soft adhesive sphere (JKR).

    Parameters
    ----------
    load : array_like of float, mN
        Normal load F; negative for a tension.
    radius : array_like of float, µm
        Effective radius R, 1/R = 1/R_u + 1/R_l.
    effective_modulus : array_like of float, GPa
        E*, see `effective_modulus`.
    work_of_adhesion : array_like of float, mN/µm (kJ/m²)
        Energy w to separate a unit area.

    Returns
    -------
    contact_radius : ndarray of float, µm
        Contact radius a, with the broadcast shape of the arguments; NaN at loads below minus the pull-off force.
    pull_off_force : ndarray of float, mN
        Largest tensile load, above 0.

    Raises
    ------
    ValueError
        If an argument other than the load is not above 0.

    See Also
    --------
    dmt : Limit of small, hard spheres.
    maugis_dugdale : Transition between both limits.
    tabor_parameter : Parameter that distinguishes them.

    Notes
    -----
    .. math:: a^3 = \frac{3R}{4E^*} \left(F + P + \sqrt{2PF + P^2}\right), \qquad P = 3 π w R

    The pull-off force is P/2. Johnson, Kendall & Roberts, Proceedings of the Royal Society A 324 (1971) 301.

    Examples
    --------
    >>> from stiction import jkr
    >>> radius, pull_off = jkr(0.0, 1000.0, 2e-3, work_of_adhesion=5e-5)  # a ball of silicone
    >>> radius.round(1), pull_off.round(3)
    (np.float64(70.7), np.float64(0.236))
    """
    r, e, w = _validate_adhesion_arguments(radius, effective_modulus, work_of_adhesion)
    f, pull_off = np.broadcast_arrays(float_array("load", load), 1.5 * np.pi * w * r)
    with np.errstate(invalid="ignore"):
        radius_cubed = 3 * r / (4 * e) * (f + 2 * pull_off + np.sqrt(4 * pull_off * (f + pull_off)))
    return np.cbrt(radius_cubed), pull_off.copy()


@reject_overflow
def dmt(
    load: ArrayLike, radius: ArrayLike, effective_modulus: ArrayLike, *, work_of_adhesion: ArrayLike
) -> tuple[Floats, Floats]:
    r"""Compute the contact radius and the pull-off force of a small, hard adhesive sphere (DMT).

    Parameters
    ----------
    load : array_like of float, mN
        Normal load F; negative for a tension.
    radius : array_like of float, µm
        Effective radius R, 1/R = 1/R_u + 1/R_l.
    effective_modulus : array_like of float, GPa
        E*, see `effective_modulus`.
    work_of_adhesion : array_like of float, mN/µm (kJ/m²)
        Energy w to separate a unit area.

    Returns
    -------
    contact_radius : ndarray of float, µm
        Contact radius a, with the broadcast shape of the arguments; NaN at loads below minus the pull-off force.
    pull_off_force : ndarray of float, mN
        Largest tensile load, above 0.

    Raises
    ------
    ValueError
        If an argument other than the load is not above 0.

    See Also
    --------
    jkr : Limit of large, soft spheres.
    maugis_dugdale : Transition between both limits.
    tabor_parameter : Parameter that distinguishes them.

    Notes
    -----
    .. math:: a^3 = \frac{3R}{4E^*} (F + 2 π w R)

    The attraction outside the contact adds to the load of Hertz. The pull-off force is 2 π w R. Derjaguin, Muller &
    Toporov, Journal of Colloid and Interface Science 53 (1975) 314, in the form of Maugis (1992).

    Examples
    --------
    >>> from stiction import dmt
    >>> radius, pull_off = dmt(0.0, 1.0, 80.0, work_of_adhesion=5e-5)
    >>> radius.round(4), pull_off.round(6)
    (np.float64(0.0143), np.float64(0.000314))
    """
    r, e, w = _validate_adhesion_arguments(radius, effective_modulus, work_of_adhesion)
    f, pull_off = np.broadcast_arrays(float_array("load", load), 2 * np.pi * w * r)
    radius_cubed = 3 * r / (4 * e) * (f + pull_off)
    return np.cbrt(np.where(radius_cubed >= 0, radius_cubed, np.nan)), pull_off.copy()


@reject_overflow
def maugis_dugdale(
    load: ArrayLike,
    radius: ArrayLike,
    effective_modulus: ArrayLike,
    *,
    work_of_adhesion: ArrayLike,
    adhesion_range: ArrayLike,
) -> tuple[Floats, Floats]:
    """Compute contact radius and pull-off force of a sphere with constant attraction within a range (Maugis-Dugdale).

    Parameters
    ----------
    load : array_like of float, mN
        Normal load F; negative for a tension.
    radius : array_like of float, µm
        Effective radius R, 1/R = 1/R_u + 1/R_l.
    effective_modulus : array_like of float, GPa
        E*, see `effective_modulus`.
    work_of_adhesion : array_like of float, mN/µm (kJ/m²)
        Energy w to separate a unit area.
    adhesion_range : array_like of float, µm
        Gap ρ up to which the attraction w/ρ acts; it is 0 at larger gaps.

    Returns
    -------
    contact_radius : ndarray of float, µm
        Contact radius a, with the broadcast shape of the arguments; NaN at loads below minus the pull-off force.
    pull_off_force : ndarray of float, mN
        Largest tensile load, above 0.

    Raises
    ------
    ValueError
        If an argument other than the load is not above 0.

    See Also
    --------
    jkr, dmt : Limits of soft and of hard spheres.
    half_space : Rough surfaces, with an attraction that decreases exponentially.

    Notes
    -----
    Maugis, Journal of Colloid and Interface Science 150 (1992) 243, eqs. 6.13 to 6.17. In his units λ is 1.127 times
    `tabor_parameter`. For a given ratio of the radii of attraction and contact, the contact radius is the root of a
    quadratic equation, and the load follows.

    Examples
    --------
    >>> from stiction import maugis_dugdale
    >>> radius, pull_off = maugis_dugdale(0.0, 1.0, 80.0, work_of_adhesion=5e-5, adhesion_range=5e-4)
    >>> round(float(pull_off / (3.14159 * 5e-5)), 2)  # between 3/2 and 2
    1.91
    """
    from scipy.optimize import brentq, minimize_scalar

    r, e, w, length = _validate_adhesion_arguments(
        radius, effective_modulus, work_of_adhesion, adhesion_range=adhesion_range
    )
    arrays = np.broadcast_arrays(float_array("load", load), r, e, w, length)
    radii, pull_off_forces = np.empty(arrays[0].shape), np.empty(arrays[0].shape)
    for index in np.ndindex(radii.shape):
        force, r1, e1, w1, l1 = (float(array[index]) for array in arrays)
        modulus = 4 / 3 * e1
        force_unit, attraction_strength = np.pi * w1 * r1, 2 * (r1 * w1**2 / (np.pi * modulus**2 * l1**3)) ** (1 / 3)
        minimum = minimize_scalar(
            lambda x, s=attraction_strength: _maugis_radius_and_load(x, s)[1], bounds=(-20, 40), method="bounded"
        )
        pull_off_forces[index] = -minimum.fun * force_unit
        radii[index] = np.nan
        if force / force_unit >= minimum.fun:
            lower_limit = minimum.x - 1
            while (
                lower_limit > -30 and _maugis_radius_and_load(lower_limit, attraction_strength)[1] < force / force_unit
            ):
                lower_limit -= 1
            if _maugis_radius_and_load(lower_limit, attraction_strength)[1] < force / force_unit:
                # The radii of the contact and of the surrounding zone of attraction differ by less than round-off.
                raise ArithmeticError
            log_ratio = brentq(
                lambda x, s=attraction_strength, f=force / force_unit: _maugis_radius_and_load(x, s)[1] - f,
                lower_limit,
                minimum.x,
            )
            radii[index] = _maugis_radius_and_load(log_ratio, attraction_strength)[0] * (force_unit * r1 / modulus) ** (
                1 / 3
            )
    return np.asarray(radii), np.asarray(pull_off_forces)


def _maugis_radius_and_load(logarithm: float, strength: float) -> tuple[float, float]:
    """Return contact radius and load in the Maugis-Dugdale model, in dimensionless units.

    The argument is the logarithm of m - 1, where m is the ratio of the radii of attraction and contact.
    """
    m = 1 + np.exp(logarithm)
    root = np.sqrt(np.exp(logarithm) * (m + 1))
    angle = np.arctan(root)
    quadratic_coefficient = strength / 2 * (root + (m**2 - 2) * angle)
    linear_coefficient = 4 / 3 * strength**2 * (root * angle - np.exp(logarithm))
    radius = 2 / (linear_coefficient + np.sqrt(linear_coefficient**2 + 4 * quadratic_coefficient))
    return radius, radius**3 - strength * radius**2 * (root + m**2 * angle)


@reject_overflow
def fuller_tabor(
    deviation: ArrayLike, radius: ArrayLike, effective_modulus: ArrayLike, *, work_of_adhesion: ArrayLike
) -> tuple[Floats, Floats]:
    """Compute the pull-off force of a rough surface from the distribution of its summit heights.

    Parameters
    ----------
    deviation : array_like of float, µm
        Standard deviation σ of the normally distributed summit heights.
    radius : array_like of float, µm
        Radius R of all summits.
    effective_modulus : array_like of float, GPa
        E*, see `effective_modulus`.
    work_of_adhesion : array_like of float, mN/µm (kJ/m²)
        Energy w to separate a unit area.

    Returns
    -------
    adhesion_parameter : ndarray of float
        σ/δ, dimensionless, with the broadcast shape of the arguments.
    relative_pull_off : ndarray of float
        Ratio of the pull-off force to the pull-off force of equally high summits, from 0 to 1.

    Raises
    ------
    ValueError
        If an argument is not above 0.

    See Also
    --------
    jkr : Model of a single summit.

    Notes
    -----
    Summits separate when they are stretched by δ = 3/4 (π² w² R/E*²)^(1/3). Each of equally high summits has a pull-off
    force of 3/2 π w R, of which little is left above σ/δ = 3. Summits behave as in `jkr` and do not interact. Fuller &
    Tabor, Proceedings of the Royal Society A 345 (1975) 327; σ/δ is their 1/Δc.

    Examples
    --------
    >>> from stiction import fuller_tabor
    >>> parameter, left = fuller_tabor([0.01, 1.0], 50.0, 2e-3, work_of_adhesion=5e-5)  # rubber
    >>> parameter.round(2), left.round(2)
    (array([0.02, 1.97]), array([1.  , 0.15]))
    """
    from scipy.integrate import trapezoid
    from scipy.optimize import minimize_scalar

    r, e, w = _validate_adhesion_arguments(radius, effective_modulus, work_of_adhesion)
    relative_deviations = validate_positive_arguments(deviation=deviation)[0] / (
        0.75 * np.cbrt((np.pi * w / e) ** 2 * r)
    )
    relative_pull_off = np.empty(relative_deviations.shape)
    for index in np.ndindex(relative_pull_off.shape):
        relative_deviation = float(relative_deviations[index])
        # Units: contact radius at zero load (radii), stretch δ at separation (heights), and 3/2 π w R (loads).
        a = np.linspace(6 ** (-2 / 3), 1 + np.sqrt(3 + 3 * relative_deviation), 4000)
        force, height = 4 * (a**3 - a**1.5), (a**2 - np.sqrt(a) * 2 / 3) * 6 ** (4 / 3) / 3

        def load(
            gap: float, relative_deviation: float = relative_deviation, force: Floats = force, height: Floats = height
        ) -> float:
            height_density = np.exp(-(((height + gap) / relative_deviation) ** 2) / 2) / (
                relative_deviation * np.sqrt(2 * np.pi)
            )
            return float(trapezoid(force * height_density, height))

        gaps = np.linspace(-4 * relative_deviation, 6 * relative_deviation + 1, 200)
        coarse_optimum = gaps[int(np.argmin([load(gap) for gap in gaps]))]
        gap_step = gaps[1] - gaps[0]
        relative_pull_off[index] = -minimize_scalar(
            load, bounds=(coarse_optimum - gap_step, coarse_optimum + gap_step), method="bounded"
        ).fun
    return np.asarray(relative_deviations), relative_pull_off


def _validate_adhesion_arguments(
    radius: ArrayLike, effective_modulus: ArrayLike, work_of_adhesion: ArrayLike, **other_arguments: ArrayLike
) -> list[Floats]:
    return validate_positive_arguments(
        radius=radius, effective_modulus=effective_modulus, work_of_adhesion=work_of_adhesion, **other_arguments
    )


@reject_overflow
def hertz_cylinder(
    overlap: ArrayLike, radius: ArrayLike, effective_modulus: ArrayLike, *, width: ArrayLike = 1.0
) -> tuple[Floats, Floats]:
    r"""Compute contact force and contact area of two parallel elastic cylinders from their overlap (Hertz).

    Parameters
    ----------
    overlap : array_like of float, µm
        Overlap d of the undeformed circles, a²/R for a contact half-width a.
    radius : array_like of float, µm
        Effective radius R, 1/R = 1/R_u + 1/R_l.
    effective_modulus : array_like of float, GPa
        E*, see `effective_modulus`.
    width : array_like of float, µm
        Length w of the cylinders.

    Returns
    -------
    force : ndarray of float, mN
        Normal force F, with the broadcast shape of the arguments.
    area : ndarray of float, µm²
        Contact area A.

    Raises
    ------
    ValueError
        If an argument is not above 0.

    See Also
    --------
    hertz_line : Half-width and pressure from the load.

    Notes
    -----
    .. math:: F = \fracπ4 E^* d\,w, \qquad A = 2 w (R d)^{1/2}

    Johnson, Contact Mechanics (1985), section 4.2(c): a² = 4 F R / (π E* w).

    Examples
    --------
    >>> from stiction import hertz_cylinder
    >>> force, area = hertz_cylinder(0.01, 1.0, 10.0)  # π/4 E* overlap, 2 (R overlap)^(1/2)
    >>> round(float(force), 6), round(float(area), 6)
    (0.07854, 0.2)
    """
    d, r, e, w = validate_positive_arguments(
        overlap=overlap, radius=radius, effective_modulus=effective_modulus, width=width
    )
    half_width = np.sqrt(r * d)
    return np.asarray(np.pi * e * w * half_width**2 / (4 * r)), np.asarray(2 * half_width * w)


@reject_overflow
def hertz_line(
    load: ArrayLike, radius: ArrayLike, effective_modulus: ArrayLike, *, width: ArrayLike = 1.0
) -> tuple[Floats, Floats]:
    r"""Compute the half-width and the peak pressure of the contact between two parallel elastic cylinders (Hertz).

    Parameters
    ----------
    load : array_like of float, mN
        Normal load F.
    radius : array_like of float, µm
        Effective radius R, 1/R = 1/R_u + 1/R_l.
    effective_modulus : array_like of float, GPa
        E*, see `effective_modulus`.
    width : array_like of float, µm
        Length w of the cylinders.

    Returns
    -------
    half_width : ndarray of float, µm
        Half-width a of the contact, with the broadcast shape of the arguments.
    peak_pressure : ndarray of float, GPa
        Pressure p0 in the middle of the contact.

    Raises
    ------
    ValueError
        If an argument is not above 0.

    See Also
    --------
    hertz_cylinder : Force and area from the overlap.

    Notes
    -----
    .. math:: a^2 = \frac{4 F R}{π E^* w}, \qquad p_0 = \frac{2 F}{π a w}

    The pressure at a distance x from the middle is p0 sqrt(1 - (x/a)²). Johnson, Contact Mechanics (1985), section
    4.2(c).

    Examples
    --------
    >>> from stiction import hertz_line
    >>> half_width, peak = hertz_line(load=1.0, radius=1.0, effective_modulus=10.0)
    >>> half_width.round(4), peak.round(4)
    (np.float64(0.3568), np.float64(1.7841))
    """
    f, r, e, w = validate_positive_arguments(load=load, radius=radius, effective_modulus=effective_modulus, width=width)
    half_width = np.sqrt(4 * f * r / (np.pi * e * w))
    return np.asarray(half_width), np.asarray(2 * f / (np.pi * half_width * w))


@reject_overflow
def hertz_ellipse(
    overlap: ArrayLike, radius_1: ArrayLike, radius_2: ArrayLike, effective_modulus: ArrayLike
) -> tuple[Floats, Floats, tuple[Floats, Floats]]:
    """Compute contact force, contact area and semi-axes of an elliptic contact from its overlap (Hertz).

    Parameters
    ----------
    overlap : array_like of float, µm
        Approach d of distant points.
    radius_1, radius_2 : array_like of float, µm
        Radii of the gap along its principal directions.
    effective_modulus : array_like of float, GPa
        E*, see `effective_modulus`.

    Returns
    -------
    force : ndarray of float, mN
        Normal force F, with the broadcast shape of the arguments.
    area : ndarray of float, µm²
        Contact area π a b.
    semi_axes : (ndarray, ndarray) of float, µm
        Semi-axes of the contact along the directions of `radius_1` and `radius_2`.

    Raises
    ------
    ValueError
        If an argument is not above 0.

    See Also
    --------
    hertz_sphere : Bodies with a single relative radius.

    Notes
    -----
    Johnson, Contact Mechanics (1985), section 4.2. With κ1 <= κ2 the curvatures, k = b/a, m = 1 - k², and K and E the
    complete elliptic integrals of m: κ1/κ2 = k² (K - E)/(E - k² K), a² = 2 d (K - E)/(κ1 K m), F = 2/3 π a d E*/K. The
    differences are computed as Carlson's R_D to avoid cancellation.

    Examples
    --------
    >>> from stiction import hertz_ellipse
    >>> force, area, (first, second) = hertz_ellipse(0.25, 1.0, 1.0, 3.0)  # a sphere
    >>> force.round(12), (area / (first * second)).round(4)
    (np.float64(0.5), np.float64(3.1416))
    """
    from scipy import special

    d, r1, r2, e = np.broadcast_arrays(
        *validate_positive_arguments(
            overlap=overlap, radius_1=radius_1, radius_2=radius_2, effective_modulus=effective_modulus
        )
    )
    larger_radius, smaller_radius = np.maximum(r1, r2), np.minimum(r1, r2)
    ratio = smaller_radius / larger_radius
    # The axis ratio k solves R_D(0, k², 1)/R_D(0, 1, k²) = `ratio`. The left side increases with k, and is at most k.
    log_low, log_high = np.log(ratio), np.zeros(ratio.shape)
    for _ in range(_NUM_BISECTIONS):
        log_middle = 0.5 * (log_low + log_high)
        squared_ratio = np.exp(2 * log_middle)
        is_above = special.elliprd(0, squared_ratio, 1) > ratio * special.elliprd(0, 1, squared_ratio)
        log_low, log_high = np.where(is_above, log_low, log_middle), np.where(is_above, log_middle, log_high)
    aspect_ratio = np.where(ratio == 1, 1.0, np.exp(0.5 * (log_low + log_high)))
    elliptic_integral = special.ellipkm1(aspect_ratio**2)
    major_semi_axis = np.sqrt(2 / 3 * d * larger_radius * special.elliprd(0, aspect_ratio**2, 1) / elliptic_integral)
    minor_semi_axis = aspect_ratio * major_semi_axis
    semi_axis_1, semi_axis_2 = (
        np.where(r1 >= r2, major_semi_axis, minor_semi_axis),
        np.where(r1 >= r2, minor_semi_axis, major_semi_axis),
    )
    return (
        np.asarray(2 / 3 * np.pi * major_semi_axis * d * e / elliptic_integral),
        np.asarray(np.pi * major_semi_axis * minor_semi_axis),
        (semi_axis_1, semi_axis_2),
    )


@reject_overflow
def slope_friction(
    slope_angle: ArrayLike, *, mu0: ArrayLike, tau0: ArrayLike = 0.0, mean_pressure: ArrayLike | None = None
) -> Floats:
    r"""Compute the friction coefficient of a contact that slides up a slope.

    Parameters
    ----------
    slope_angle : array_like of float, rad
        Angle θ of the slope, from 0 to below π/2.
    mu0 : array_like of float
        Molecular friction coefficient, at least 0.
    tau0 : array_like of float, GPa
        Adhesive shear strength, at least 0.
    mean_pressure : array_like of float, GPa, optional
        F/A of the contact; required if tau0 is not 0.

    Returns
    -------
    coefficient : ndarray of float
        Friction coefficient, with the broadcast shape of the arguments; NaN if the contact is self-locked, (mu0 + tau0
        A/F) tan θ >= 1.

    Raises
    ------
    ValueError
        If an argument is outside its range, or if the mean pressure is required and not given.

    See Also
    --------
    gentle_friction : Rough surfaces with many slopes.

    Notes
    -----
    .. math:: μ_s = \tan(θ + \arctan(μ_0 + τ_0 A/F))

    This is the equilibrium of a block on an incline with friction μ0 + τ0 A/F along the slope.

    Examples
    --------
    >>> from stiction import slope_friction
    >>> slope_friction([0.0, 0.1, 1.2], mu0=0.4).round(3)
    array([0.4  , 0.521,   nan])
    """
    theta = float_array("slope_angle", slope_angle)
    mu, tau = validate_friction_parameter("mu0", mu0), validate_friction_parameter("tau0", tau0)
    if not ((theta >= 0) & (theta < np.pi / 2)).all():
        raise ValueError(f"slope_angle must be at least 0 and below pi/2 rad, got {short_repr(slope_angle)}")
    if mean_pressure is not None:
        mu = FrictionLaw(mu, tau).force(1.0, 1.0 / validate_positive_arguments(mean_pressure=mean_pressure)[0])
    elif (tau > 0).any():
        raise ValueError("mean_pressure must be given if tau0 is not 0")
    is_locked: NDArray[np.bool_] = mu * np.tan(theta) >= 1
    return np.where(is_locked, np.nan, np.tan(theta + np.arctan(mu)))


@reject_overflow
def hardness_under_shear(
    hardness: ArrayLike, mu0: ArrayLike, tau0: ArrayLike, alpha: ArrayLike | Literal["slip-line"], *,
    ratio: ArrayLike = CENTRAL_SHEAR_RATIO,
) -> Floats:  # fmt: skip
    """Compute the yield pressure H' of a sliding contact, which is the hardness H reduced by junction growth.

    Parameters
    ----------
    hardness : array_like of float, GPa
        H, the largest pressure of the contact without shear, above 0.
    mu0 : array_like of float
        Molecular friction coefficient, at least 0.
    tau0 : array_like of float, GPa
        Adhesive shear strength, at least 0.
    alpha : array_like of float or "slip-line"
        Yield by slip lines, or junction growth α, at least 0. 0 leaves H unchanged; at 27 the material shears at
        H/(3 sqrt(3)) without pressure (von Mises, H of three yield strengths).
    ratio : array_like of float
        H/k, ratio of hardness to shear strength, for slip lines only: 2 + π in plane strain, 5.7 to 6.05 for a circle.

    Returns
    -------
    hardness : ndarray of float, GPa
        H', with the broadcast shape of the arguments. If the interface is stronger than the bulk, no pressure satisfies
        both laws: with slip lines, the result is then H/2, the pressure of a junction whose softer body shears. With α,
        it is NaN where tau0 >= H/sqrt(α).

    Raises
    ------
    ValueError
        If an argument is outside its range.

    See Also
    --------
    tabor_friction : Friction coefficient of these contacts.
    half_space : Rough surfaces; with the hardness H' the contact at the onset of sliding.

    Notes
    -----
    Pressure p and shear traction τ act on the same material. During sliding τ = mu0 p + tau0.

    Slip lines of a flat junction on a half-space in plane strain give p/H = (1 + π/2 + arccos f + sqrt(1 - f²))/(2 + π)
    with f = τ/k and the shear strength k. Green, Journal of the Mechanics and Physics of Solids 2 (1954)
    197; Johnson, the same journal 16 (1968) 395. With α, the material yields at p² + α τ² = H². Tabor, Proceedings of
    the Royal Society A 251 (1959) 378.

    Examples
    --------
    >>> from stiction import hardness_under_shear
    >>> hardness_under_shear(0.625, mu0=0.2, tau0=[0.02, 0.05, 0.1], alpha="slip-line").round(3)
    array([0.411, 0.312, 0.312])
    >>> hardness_under_shear(0.625, mu0=0.2, tau0=[0.05, 0.1, 0.125], alpha=[0, 27, 27]).round(3)
    array([0.625, 0.094,   nan])
    """
    mu, tau = validate_friction_parameter("mu0", mu0), validate_friction_parameter("tau0", tau0)
    plastic_hardness = validate_positive_arguments(hardness=hardness)[0]
    if isinstance(alpha, str):
        check_choice("alpha", alpha, Literal["slip-line"])
        shear_ratio = validate_positive_arguments(ratio=ratio)[0]
        return np.asarray(FrictionLaw(mu, tau, shear_ratio, uses_slip_lines=True).yield_pressure(plastic_hardness))
    alpha_value = validate_friction_parameter("alpha", alpha)
    pressure = FrictionLaw(mu, tau, alpha_value).yield_pressure(plastic_hardness)
    return np.where(alpha_value == 0, plastic_hardness, pressure)


@reject_overflow
def tabor_friction(hardness: ArrayLike, mu0: ArrayLike, tau0: ArrayLike, alpha: ArrayLike) -> Floats:
    """Compute the friction coefficient of contacts that all yield and whose area grows under shear (junction growth).

    Parameters
    ----------
    hardness, mu0, tau0, alpha
        As for `hardness_under_shear`.

    Returns
    -------
    coefficient : ndarray of float
        Friction coefficient t, with the broadcast shape of the arguments; NaN where tau0 >= H/sqrt(α).

    Raises
    ------
    ValueError
        If an argument is outside its range.

    See Also
    --------
    hardness_under_shear : Pressure of these contacts.

    Notes
    -----
    The coefficient solves t = mu0 + (tau0/H) sqrt(1 + α t²), and equals mu0 + tau0/H' with H' of
    `hardness_under_shear`. Tabor, Proceedings of the Royal Society A 251 (1959) 378.

    Examples
    --------
    >>> from stiction import tabor_friction
    >>> tabor_friction(0.625, mu0=0.2, tau0=0.05, alpha=[0, 9, 27]).round(3)
    array([0.28 , 0.309, 0.375])
    """
    pressure = hardness_under_shear(hardness, mu0, tau0, validate_friction_parameter("alpha", alpha))
    return np.asarray(FrictionLaw(float_array("mu0", mu0), float_array("tau0", tau0)).force(1.0, 1.0 / pressure))


DEFAULT_KAPPA = 2.2
"""Usual value of the area coefficient κ = A E* h'/F of isotropic Gaussian height maps at small loads."""


@reject_overflow
def gentle_friction(
    mu0: ArrayLike,
    tau0: ArrayLike = 0.0,
    *,
    rms_gradient: ArrayLike,
    rms_slope: ArrayLike | None = None,
    effective_modulus: ArrayLike = 10.0,
    kappa: ArrayLike = DEFAULT_KAPPA,
    sliding: SlidingRule = "opposing",
    slope_ratio: ArrayLike = 1.0,
    order: Literal[1, 2] = 1,
) -> Floats:
    """Estimate the friction coefficient of two elastic half-spaces whose rough surfaces have small slopes.

    Parameters
    ----------
    mu0 : array_like of float
        Molecular friction coefficient.
    tau0 : array_like of float, GPa
        Adhesive shear strength.
    rms_gradient : array_like of float
        h' of the gap, over all directions; on a line the root-mean-square slope.
    rms_slope : array_like of float, optional
        g_s of the gap along the motion. None stands for an isotropic gap, h'/sqrt(2). On a line, the slope is h'.
    effective_modulus : array_like of float, GPa
    kappa : array_like of float
        A E* h'/F: 2.05 to 2.5 on Gaussian height maps at small loads, 2.4 to 3.6 on profiles. For the second order, A
        is the projected area.
    sliding : {"opposing", "all"}
        Contacts with friction: only contacts whose normal force opposes the motion, or all contacts.
    slope_ratio : array_like of float
        r, ratio of the root-mean-square slopes of the two surfaces, in either order; 0 for a rough surface on a flat.
    order : {1, 2}
        1 for small slopes; 2 includes the larger interface area of contacts on slopes across the motion.

    Returns
    -------
    coefficient : ndarray of float
        Friction coefficient, with the broadcast shape of the arguments; NaN if the contact is self-locked, m S >= 1.

    Raises
    ------
    ValueError
        If an argument is outside its range.

    See Also
    --------
    slope_friction : Single contact on a slope.
    spectral_resolution : Friction as a function of the shortest wavelength.

    Notes
    -----
    With m = mu0 + κ tau0/(E* h') and S = g_s/sqrt(2π) r/(1 + r²), which is g_s/(2 sqrt(2π)) for equally rough surfaces:
    half of the load is on opposing slopes, whose mean is 2 S, so mu_s = (m/2 + S)/(1 - m S). With friction at all
    contacts, mu_s = m. The two surfaces are independent of each other.

    Derivation: the gap determines where the surfaces touch. If two Gaussian surfaces have spectra of the same shape,
    the common part of their slopes is independent of the gap. Contact slopes are then a random sample with the variance
    (g_s r/(1 + r²))². The contribution of the gap to the slope of the deformed interface averages to zero over a
    contact, because internal forces cannot push a contact sideways. The fraction of the compliance therefore has almost
    no effect.

    The second order is w m for all contacts and (w m/2 + S)/(1 - v m S) for opposing ones. w and v are the means of (1
    + s²)^(1/2) and (1 + s²)^(-1/2) over normally distributed slopes s across the motion, of variance (h'² - g_s²) r²/(1
    + r²)². These expressions are exact for contacts of equal load with these slopes, and are intended for surfaces of
    equal roughness and compliance.

    2 S is the mean slope of opposing points under pressure. A contact that spans several slopes opposes as a whole,
    with a smaller mean slope: with wavelengths of many scales, S decreases to two thirds, which lowers friction by 1 %
    at h' = 0.1 and by 10 % at 0.8. The estimate does not include small numbers of contacts, whose mean differs from the
    ensemble mean, contacts that merge at high loads, and slopes that are not normally distributed.

    Examples
    --------
    >>> from stiction import gentle_friction
    >>> gentle_friction(0.4, rms_gradient=[0.041, 0.41]).round(3)
    array([0.206, 0.264])
    >>> gentle_friction(0.4, rms_gradient=[0.041, 0.41], order=2).round(3)
    array([0.206, 0.266])
    """
    coefficient = compute_small_slope_friction(
        mu0, tau0, rms_gradient=rms_gradient, rms_slope=rms_slope, effective_modulus=effective_modulus, kappa=kappa,
        sliding=sliding, slope_ratio=slope_ratio, order=order,
    )  # fmt: skip
    moduli = float_array("effective_modulus", effective_modulus)
    warn_if_tau0_is_large(float_array("tau0", tau0), float(np.min(moduli, initial=np.inf)))
    return coefficient


def compute_small_slope_friction(
    mu0: ArrayLike,
    tau0: ArrayLike,
    *,
    rms_gradient: ArrayLike,
    rms_slope: ArrayLike | None,
    effective_modulus: ArrayLike,
    kappa: ArrayLike,
    sliding: SlidingRule,
    slope_ratio: ArrayLike,
    order: Literal[1, 2],
) -> Floats:
    """Compute friction as `gentle_friction` does, but without the warning about an improbably large tau0."""
    mu, tau = validate_friction_parameter("mu0", mu0), validate_friction_parameter("tau0", tau0)
    gradient, modulus, factor = validate_positive_arguments(
        rms_gradient=rms_gradient, effective_modulus=effective_modulus, kappa=kappa
    )
    slope = gradient / np.sqrt(2) if rms_slope is None else validate_positive_arguments(rms_slope=rms_slope)[0]
    ratio = float_array("slope_ratio", slope_ratio)
    if not (ratio >= 0).all():
        raise ValueError(f"slope_ratio must not be negative, got {short_repr(slope_ratio)}")
    check_choice("sliding", sliding, SlidingRule)
    if not isinstance(unwrap_scalar(order), int) or order not in (1, 2):
        raise ValueError(f"order must be 1 or 2, got {short_repr(order)}")
    m = FrictionLaw(mu, tau).force(1.0, factor / (modulus * gradient))
    ratio_factor = ratio / (1 + ratio**2)
    mean_opposing_slope = slope * ratio_factor / np.sqrt(2 * np.pi)
    mean_secant, mean_cosine = np.ones(()), np.ones(())
    if order == 2:
        transverse_mean_square = gradient**2 - slope**2
        if not (transverse_mean_square >= -_SLOPE_ROUND_OFF_TOLERANCE * gradient**2).all():
            raise ValueError(
                f"rms_slope must be at most rms_gradient, got {short_repr(rms_slope)} and {short_repr(rms_gradient)}"
            )
        mean_secant, mean_cosine = _mean_secant_and_cosine(
            ratio_factor * np.sqrt(np.maximum(transverse_mean_square, 0))
        )
    if sliding == "all":
        return np.asarray(np.broadcast_arrays(m * mean_secant, mean_opposing_slope)[0].copy())
    locking_term = m * mean_cosine * mean_opposing_slope
    is_free = locking_term < 1
    return np.asarray(
        np.divide(
            m * mean_secant / 2 + mean_opposing_slope,
            1 - locking_term,
            out=np.full(is_free.shape, np.nan),
            where=is_free,
        )
    )


def _mean_secant_and_cosine(deviation: Floats) -> tuple[Floats, Floats]:
    """Return mean((1 + s²)^(1/2)) and mean((1 + s²)^(-1/2)) for normally distributed slopes s."""
    from scipy import special

    is_small = deviation < _SMALL_SLOPE_LIMIT
    bounded_deviation = np.maximum(deviation, _SMALL_SLOPE_LIMIT)
    x = 1 / (4 * bounded_deviation**2)
    factor = 1 / (bounded_deviation * np.sqrt(2 * np.pi))
    bessel_k0, bessel_k1 = special.kve(0, x), special.kve(1, x)
    squared_deviation = deviation**2
    mean_secant = np.where(
        is_small, 1 + squared_deviation / 2 - 3 * squared_deviation**2 / 8, (bessel_k0 + bessel_k1) * factor / 2
    )
    return mean_secant, np.where(is_small, 1 - squared_deviation / 2 + 9 * squared_deviation**2 / 8, bessel_k0 * factor)


# ---- Sinusoidal surface (Westergaard) -------------------------------------------------------------------------------


@reject_overflow
def westergaard_contact_fraction(
    mean_pressure: ArrayLike, *, amplitude: ArrayLike, wavelength: ArrayLike, effective_modulus: ArrayLike
) -> Floats:
    r"""Compute the contact fraction of an elastic sinusoidal surface on a flat (Westergaard).

    Parameters
    ----------
    mean_pressure : array_like of float, GPa
        Mean pressure p̄, load per nominal area.
    amplitude : array_like of float, µm
        Amplitude Δ of the heights Δ cos(2πx/λ): half of the total height.
    wavelength : array_like of float, µm
        Wavelength λ.
    effective_modulus : array_like of float, GPa
        E*, see `effective_modulus`.

    Returns
    -------
    fraction : ndarray of float
        Ratio of real to nominal contact area, with the broadcast shape of the arguments; 1 at pressures above p*.

    Raises
    ------
    ValueError
        If an argument is not above 0.

    See Also
    --------
    westergaard_pressure, westergaard_gap : Pressure and gap along the surface.

    Notes
    -----
    .. math:: A/A_0 = \frac2π \arcsin(\bar p/p^*)^{1/2}, \qquad p^* = π E^* Δ / λ

    Exact for a half-space in plane strain, including the interaction of the crests. Westergaard 1939; Johnson, Contact
    Mechanics (1985), eqs. 13.7-13.8.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import westergaard_contact_fraction
    >>> wave = {"amplitude": 0.01, "wavelength": 1.0, "effective_modulus": 10.0}
    >>> westergaard_contact_fraction(np.array([0.25, 0.5, 1.0]) * np.pi * 0.1, **wave).round(3)
    array([0.333, 0.5  , 1.   ])
    """
    _, _, p, full_pressure, _ = _compute_sinusoid_terms(0.0, mean_pressure, amplitude, wavelength, effective_modulus)
    return np.asarray(2 / np.pi * np.arcsin(np.sqrt(np.minimum(p / full_pressure, 1))))


@reject_overflow
def westergaard_pressure(
    x: ArrayLike, mean_pressure: ArrayLike, *, amplitude: ArrayLike, wavelength: ArrayLike, effective_modulus: ArrayLike
) -> Floats:
    r"""Compute the pressure between an elastic sinusoidal surface and a flat (Westergaard).

    Parameters
    ----------
    x : array_like of float, µm
        Distance from a crest.
    mean_pressure, amplitude, wavelength, effective_modulus
        As for `westergaard_contact_fraction`.

    Returns
    -------
    pressure : ndarray of float, GPa
        Pressure between the surfaces; 0 out of contact. The shape is the broadcast shape of the arguments.

    Raises
    ------
    ValueError
        If an argument other than x is not above 0.

    See Also
    --------
    westergaard_contact_fraction : Contact fraction, with p*.
    westergaard_gap : Gap along the surface.

    Notes
    -----
    .. math:: p = 2 \bar p \frac{\cos ψ}{\sin^2 ψ_a} (\sin^2 ψ_a - \sin^2 ψ)^{1/2}, \qquad ψ = πx/λ, \qquad
              \sin^2 ψ_a = \bar p/p^*

    and p̄ + p* cos 2ψ above p*. Westergaard 1939; Johnson, Contact Mechanics (1985), eqs. 13.7-13.8.

    Examples
    --------
    >>> from stiction import westergaard_pressure
    >>> wave = {"amplitude": 0.01, "wavelength": 1.0, "effective_modulus": 10.0}
    >>> westergaard_pressure([0.0, 0.1, 0.5], 0.1, **wave).round(4)
    array([0.3545, 0.2821, 0.    ])
    """
    sine, cosine, p, full_pressure, _ = _compute_sinusoid_terms(
        x, mean_pressure, amplitude, wavelength, effective_modulus
    )
    fraction = np.minimum(p / full_pressure, 1)
    partial_pressure = 2 * full_pressure * np.abs(cosine) * np.sqrt(np.maximum(fraction - sine**2, 0))
    return np.asarray(np.where(p < full_pressure, partial_pressure, p + full_pressure * (1 - 2 * sine**2)))


@reject_overflow
def westergaard_gap(
    x: ArrayLike, mean_pressure: ArrayLike, *, amplitude: ArrayLike, wavelength: ArrayLike, effective_modulus: ArrayLike
) -> Floats:
    r"""Compute the gap between an elastic sinusoidal surface and a flat (Westergaard).

    Parameters
    ----------
    x : array_like of float, µm
        Distance from a crest.
    mean_pressure, amplitude, wavelength, effective_modulus
        As for `westergaard_contact_fraction`.

    Returns
    -------
    gap : ndarray of float, µm
        Gap between the deformed surfaces; 0 in contact. The shape is the broadcast shape of the arguments.

    Raises
    ------
    ValueError
        If an argument other than x is not above 0.

    See Also
    --------
    westergaard_contact_fraction : Contact fraction, with p*.
    westergaard_pressure : Pressure along the surface.

    Notes
    -----
    .. math:: g = 2 Δ \left[s (s^2 - s_a^2)^{1/2} - s_a^2 \operatorname{arcosh}(s/s_a)\right], \qquad
              s = |\sin(πx/λ)|, \qquad s_a^2 = \bar p/p^*

    The slope of the gap, 4 p*/E* cos ψ (s² - s_a²)^(1/2) with ψ = πx/λ, continues the pressure analytically beyond the
    contact. Johnson, Contact Mechanics (1985), section 13.2.

    Examples
    --------
    >>> from stiction import westergaard_gap
    >>> wave = {"amplitude": 0.01, "wavelength": 1.0, "effective_modulus": 10.0}
    >>> westergaard_gap([0.0, 0.25, 0.5], 0.1, **wave).round(5)
    array([0.     , 0.00159, 0.00904])
    """
    sine, _, p, full_pressure, d = _compute_sinusoid_terms(x, mean_pressure, amplitude, wavelength, effective_modulus)
    contact_edge = np.sqrt(np.minimum(p / full_pressure, 1))
    s = np.maximum(np.abs(sine), contact_edge)
    return np.asarray(2 * d * (s * np.sqrt(s**2 - contact_edge**2) - contact_edge**2 * np.arccosh(s / contact_edge)))


def _compute_sinusoid_terms(
    x: ArrayLike, mean_pressure: ArrayLike, amplitude: ArrayLike, wavelength: ArrayLike, effective_modulus: ArrayLike
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return sin(πx/λ), cos(πx/λ), the given mean pressure, the mean pressure at full contact, and the amplitude."""
    p, d, wavelengths, e = validate_positive_arguments(
        mean_pressure=mean_pressure, amplitude=amplitude, wavelength=wavelength, effective_modulus=effective_modulus
    )
    phase = np.pi * float_array("x", x) / wavelengths
    return np.asarray(np.sin(phase)), np.asarray(np.cos(phase)), p, np.asarray(np.pi * e * d / wavelengths), d
