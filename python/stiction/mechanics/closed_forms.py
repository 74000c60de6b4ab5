"""Exact answers: for users who need one contact or one wave, and for the tests that hold the model to them.

Plain NumPy, independent of the core. Every argument broadcasts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array
from stiction.mechanics.friction import friction_parameter


def _positive(**arguments: ArrayLike) -> list[Floats]:
    arrays = []
    for name, values in arguments.items():
        array = float_array(name, values)
        if not (array > 0).all():
            raise ValueError(f"{name} must be above 0, got {values!r}")
        arrays.append(array)
    return arrays


def effective_modulus(
    young_upper: ArrayLike, poisson_upper: ArrayLike, young_lower: ArrayLike, poisson_lower: ArrayLike
) -> Floats:
    """E* in the unit of the Young's moduli: 1/E* = (1 - ν_u²)/E_u + (1 - ν_l²)/E_l.

    Examples
    --------
    >>> from stiction import effective_modulus
    >>> float(effective_modulus(200.0, 0.0, 200.0, 0.0))
    100.0
    """
    upper, lower = _positive(young_upper=young_upper, young_lower=young_lower)
    ratios = []
    for name, values in (("poisson_upper", poisson_upper), ("poisson_lower", poisson_lower)):
        ratio = float_array(name, values)
        if not ((ratio > -1) & (ratio <= 0.5)).all():
            raise ValueError(f"{name} must be above -1 and at most 0.5, got {values!r}")
        ratios.append(ratio)
    return np.asarray(1 / ((1 - ratios[0] ** 2) / upper + (1 - ratios[1] ** 2) / lower))


def hertz_sphere(overlap: ArrayLike, radius: ArrayLike, effective_modulus: ArrayLike) -> tuple[Floats, Floats]:
    """Force (mN) and area (µm²) of elastic spheres: 4/3 E* R^(1/2) overlap^(3/2) and π R overlap.

    Parameters
    ----------
    overlap, radius : array_like of float, µm
        1/R = 1/R_u + 1/R_l.
    effective_modulus : array_like of float, GPa

    Notes
    -----
    Hertz 1882; Johnson, Contact Mechanics (1985), eqs. 4.22-4.24.

    Examples
    --------
    >>> from stiction import hertz_sphere
    >>> force, area = hertz_sphere(overlap=0.25, radius=1.0, effective_modulus=3.0)
    >>> float(force)
    0.5
    """
    d, r, e = _positive(overlap=overlap, radius=radius, effective_modulus=effective_modulus)
    return np.asarray(4 / 3 * e * r**0.5 * d**1.5), np.asarray(np.pi * r * d)


def hertz_cylinder(
    overlap: ArrayLike, radius: ArrayLike, effective_modulus: ArrayLike, *, width: ArrayLike = 1.0
) -> tuple[Floats, Floats]:
    """Force (mN) and area (µm²) of elastic parallel cylinders: π/4 E* overlap w and 2 w (R overlap)^(1/2).

    Parameters
    ----------
    overlap, radius, width : array_like of float, µm
        The overlap of the undeformed circles, a²/R for a half-width a of contact.
    effective_modulus : array_like of float, GPa

    Notes
    -----
    Johnson, Contact Mechanics (1985), eq. 4.45: a² = 4 F R / (π E* w).
    """
    d, r, e, w = _positive(overlap=overlap, radius=radius, effective_modulus=effective_modulus, width=width)
    half_width = np.sqrt(r * d)
    return np.asarray(np.pi * e * w * half_width**2 / (4 * r)), np.asarray(2 * half_width * w)


def slope_friction(
    slope_angle: ArrayLike, *, mu0: ArrayLike, tau0: ArrayLike = 0.0, mean_pressure: ArrayLike | None = None
) -> Floats:
    """Friction coefficient of one contact that slides up a slope: tan(θ + arctan(mu0 + tau0 A/F)).

    Parameters
    ----------
    slope_angle : array_like of float, rad
        θ, from 0 to below π/2.
    mu0 : array_like of float
        Molecular friction coefficient.
    tau0 : array_like of float, GPa
        Adhesive shear strength.
    mean_pressure : array_like of float, GPa
        F/A of the contact; needed with a tau0 other than 0.

    Returns
    -------
    ndarray
        NaN where the contact locks itself, (mu0 + tau0 A/F) tan θ >= 1.

    Examples
    --------
    >>> from stiction import slope_friction
    >>> slope_friction([0.0, 0.1, 1.2], mu0=0.4).round(3)
    array([0.4  , 0.521,   nan])
    """
    theta = float_array("slope_angle", slope_angle)
    mu, tau = friction_parameter("mu0", mu0), friction_parameter("tau0", tau0)
    if not ((theta >= 0) & (theta < np.pi / 2)).all():
        raise ValueError(f"slope_angle must be from 0 to below pi/2 rad, got {slope_angle!r}")
    if mean_pressure is not None:
        mu = mu + tau / _positive(mean_pressure=mean_pressure)[0]
    elif (tau > 0).any():
        raise ValueError("mean_pressure must be given with a tau0 other than 0")
    locked: NDArray[np.bool_] = mu * np.tan(theta) >= 1
    return np.where(locked, np.nan, np.tan(theta + np.arctan(mu)))


def westergaard_contact_fraction(
    mean_pressure: ArrayLike, *, amplitude: ArrayLike, wavelength: ArrayLike, effective_modulus: ArrayLike
) -> Floats:
    """Fraction of a flat that an elastic sinusoid touches: 2/π arcsin (p̄/p*)^(1/2), p* = π E* Δ / λ; 1 from p* on.

    Parameters
    ----------
    mean_pressure : array_like of float, GPa
        p̄, load per nominal area.
    amplitude : array_like of float, µm
        Δ of heights Δ cos(2πx/λ): half the total height.
    wavelength : array_like of float, µm
        λ.
    effective_modulus : array_like of float, GPa

    Notes
    -----
    Westergaard 1939; Johnson, Contact Mechanics (1985), eqs. 13.7-13.8. Exact for a half-space in plane strain; the
    crests interact.
    """
    p, d, wave, e = _positive(
        mean_pressure=mean_pressure, amplitude=amplitude, wavelength=wavelength, effective_modulus=effective_modulus
    )
    return np.asarray(2 / np.pi * np.arcsin(np.sqrt(np.minimum(p / (np.pi * e * d / wave), 1))))
