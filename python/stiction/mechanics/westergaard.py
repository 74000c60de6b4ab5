"""An elastic sinusoid on a flat, exactly: contact, pressure and gap at any load.

Plain NumPy, independent of the core. Every argument broadcasts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, float_array
from stiction.mechanics.closed_forms import positive


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

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import westergaard_contact_fraction
    >>> wave = {"amplitude": 0.01, "wavelength": 1.0, "effective_modulus": 10.0}
    >>> westergaard_contact_fraction(np.array([0.25, 0.5, 1.0]) * np.pi * 0.1, **wave).round(3)
    array([0.333, 0.5  , 1.   ])
    """
    p, d, wave, e = positive(
        mean_pressure=mean_pressure, amplitude=amplitude, wavelength=wavelength, effective_modulus=effective_modulus
    )
    return np.asarray(2 / np.pi * np.arcsin(np.sqrt(np.minimum(p / (np.pi * e * d / wave), 1))))


def westergaard_pressure(
    x: ArrayLike,
    mean_pressure: ArrayLike,
    *,
    amplitude: ArrayLike,
    wavelength: ArrayLike,
    effective_modulus: ArrayLike,
) -> Floats:
    """Pressure (GPa) between a flat and an elastic sinusoid, at x (µm) from a crest; 0 out of contact.

    Parameters
    ----------
    x : array_like of float, µm
    mean_pressure, amplitude, wavelength, effective_modulus
        As for `westergaard_contact_fraction`.

    Notes
    -----
    2 p̄ cos ψ / sin² ψ_a (sin² ψ_a - sin² ψ)^(1/2) with ψ = πx/λ and sin² ψ_a = p̄/p*; p̄ + p* cos 2ψ from p* on.
    Westergaard 1939; Johnson, Contact Mechanics (1985), eqs. 13.7-13.8.

    Examples
    --------
    >>> from stiction import westergaard_pressure
    >>> wave = {"amplitude": 0.01, "wavelength": 1.0, "effective_modulus": 10.0}
    >>> westergaard_pressure([0.0, 0.1, 0.5], 0.1, **wave).round(4)
    array([0.3545, 0.2821, 0.    ])
    """
    sine, cosine, p, full, _ = _wave(x, mean_pressure, amplitude, wavelength, effective_modulus)
    share = np.minimum(p / full, 1)
    partial = 2 * full * np.abs(cosine) * np.sqrt(np.maximum(share - sine**2, 0))
    return np.asarray(np.where(p < full, partial, p + full * (1 - 2 * sine**2)))


def westergaard_gap(
    x: ArrayLike,
    mean_pressure: ArrayLike,
    *,
    amplitude: ArrayLike,
    wavelength: ArrayLike,
    effective_modulus: ArrayLike,
) -> Floats:
    """Gap (µm) between a flat and an elastic sinusoid, at x (µm) from a crest; 0 in contact.

    Parameters
    ----------
    x : array_like of float, µm
    mean_pressure, amplitude, wavelength, effective_modulus
        As for `westergaard_contact_fraction`.

    Notes
    -----
    With s the magnitude of sin(πx/λ) and s_a = (p̄/p*)^(1/2): 2 Δ [s (s² - s_a²)^(1/2) - s_a² arcosh(s/s_a)]. Its slope,
    4 p*/E* cos ψ (s² - s_a²)^(1/2), continues the pressure analytically beyond the contact.

    Examples
    --------
    >>> from stiction import westergaard_gap
    >>> wave = {"amplitude": 0.01, "wavelength": 1.0, "effective_modulus": 10.0}
    >>> westergaard_gap([0.0, 0.25, 0.5], 0.1, **wave).round(5)
    array([0.     , 0.00159, 0.00904])
    """
    sine, _, p, full, d = _wave(x, mean_pressure, amplitude, wavelength, effective_modulus)
    edge = np.sqrt(np.minimum(p / full, 1))
    s = np.maximum(np.abs(sine), edge)
    return np.asarray(2 * d * (s * np.sqrt(s**2 - edge**2) - edge**2 * np.arccosh(s / edge)))


def _wave(
    x: ArrayLike, mean_pressure: ArrayLike, amplitude: ArrayLike, wavelength: ArrayLike, effective_modulus: ArrayLike
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Sine and cosine of πx/λ, mean pressure, pressure of full contact, amplitude."""
    p, d, wave, e = positive(
        mean_pressure=mean_pressure, amplitude=amplitude, wavelength=wavelength, effective_modulus=effective_modulus
    )
    phase = np.pi * float_array("x", x) / wave
    return np.asarray(np.sin(phase)), np.asarray(np.cos(phase)), p, np.asarray(np.pi * e * d / wave), d
