"""Presliding models fitted to an onset curve: the four-parameter Iwan model and the LuGre model."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, float_array, make_read_only
from stiction._repr import TextReprMixin
from stiction._units import short_repr

MIN_POINTS_OF_FITTED_CURVE = 3


@dataclass(frozen=True, eq=False, repr=False)
class FourParameterIwan(TextReprMixin):
    """Four-parameter Iwan model: parallel sliders with a power-law distribution of strengths (Segalman).

    Attributes
    ----------
    sliding_load : float, mN
        Sliding load F_S, taken from the curve.
    stiffness : float, mN/µm
        Initial tangential stiffness K_T, taken from the curve.
    chi : float
        Exponent χ, above -1 and at most 0: at small amplitudes, the energy loss per cycle is proportional to
        amplitude^(χ + 3).
    beta : float
        Ratio β, at least 0, of the stiffness that is lost at the end of presliding to the stiffness that is lost
        before.
    residual : (k,) ndarray, mN
        Load of the model minus load of the curve, at the displacements of the curve.

    Notes
    -----
    F(u) = K_T u [1 - (u/φ)^(χ+1) / ((χ + 2)(1 + β))] up to u = φ, then F_S, with
    φ = F_S (1 + β) / (K_T (β + (χ + 1)/(χ + 2))). Segalman, Journal of Applied Mechanics 72 (2005) 752.

    Examples
    --------
    >>> from stiction import half_space, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> round(half_space(upper, lower, "1 mN").onset(0, mu0=0.3).iwan().sliding_load, 6)
    0.3
    """

    sliding_load: float = field(metadata={"unit": "mN"})
    stiffness: float = field(metadata={"unit": "mN/µm"})
    chi: float
    beta: float
    residual: Floats = field(metadata={"unit": "mN"})

    @property
    def displacement_at_sliding(self) -> float:
        """Displacement φ (µm) at which sliding starts in the Iwan model."""
        chi, beta = self.chi, self.beta
        return self.sliding_load * (1 + beta) / (self.stiffness * (beta + (chi + 1) / (chi + 2)))

    def load(self, displacement: ArrayLike) -> Floats:
        """Return the tangential load (mN) of the Iwan model in first loading, at displacements (µm) of at least 0."""
        displacements = _validate_displacement(displacement)
        ratio = np.minimum(displacements / self.displacement_at_sliding, 1.0)
        slip_fraction = ratio ** (self.chi + 1) / ((self.chi + 2) * (1 + self.beta))
        load_before_sliding = self.stiffness * displacements * (1 - slip_fraction)
        return np.asarray(np.where(ratio < 1, load_before_sliding, self.sliding_load))

    def energy_lost(self, displacement: ArrayLike) -> Floats:
        """Return the energy loss (mN µm) of the Iwan model per cycle, for a displacement amplitude (µm)."""
        displacements, sliding_displacement = _validate_displacement(displacement), self.displacement_at_sliding
        ratio = np.minimum(displacements / sliding_displacement, 1.0)
        slip_fraction = ratio ** (self.chi + 1) / ((self.chi + 2) * (1 + self.beta))
        # Masing's rule: the energy loss in a cycle is 8 · (area under the loading curve) - 4 · load · displacement.
        loss_before_sliding = (
            4
            * self.stiffness
            * slip_fraction
            * (self.chi + 1)
            / (self.chi + 3)
            * np.minimum(displacements, sliding_displacement) ** 2
        )
        return np.asarray(
            loss_before_sliding + 4 * self.sliding_load * np.maximum(displacements - sliding_displacement, 0.0)
        )


@dataclass(frozen=True, eq=False, repr=False)
class LuGre(TextReprMixin):
    """LuGre presliding model, in which bristles deflect and finally yield at the sliding load.

    Attributes
    ----------
    sliding_load : float, mN
        Sliding load, taken from the curve.
    stiffness : float, mN/µm
        Stiffness σ0 of the bristles.
    residual : (k,) ndarray, mN
        Load of the model minus load of the curve, at the displacements of the curve.

    Notes
    -----
    F = F_S (1 - exp(-σ0 u/F_S)) for slow loading from rest, from dz/du = 1 - σ0 z/F_S of Canudas de Wit, Olsson,
    Åström & Lischinsky, IEEE Transactions on Automatic Control 40 (1995) 419.

    Examples
    --------
    >>> from stiction import half_space, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> round(half_space(upper, lower, "1 mN").onset(0, mu0=0.3).lugre().sliding_load, 6)
    0.3
    """

    sliding_load: float = field(metadata={"unit": "mN"})
    stiffness: float = field(metadata={"unit": "mN/µm"})
    residual: Floats = field(metadata={"unit": "mN"})

    def load(self, displacement: ArrayLike) -> Floats:
        """Return the tangential load (mN) of the LuGre model in first loading, at displacements (µm) of at least 0."""
        return np.asarray(
            -self.sliding_load * np.expm1(-self.stiffness * _validate_displacement(displacement) / self.sliding_load)
        )


def fit_iwan(displacement: Floats, load: Floats, *, sliding_load: float, stiffness: float) -> FourParameterIwan:
    """Fit the Iwan model to an onset curve by minimizing the squared deviations of the tangential load."""
    _check_curve(displacement, load, MIN_POINTS_OF_FITTED_CURVE)
    # The arguments are checked before the import of `scipy.optimize`, which takes 0.2 s.
    from scipy.optimize import least_squares

    def iwan_model(parameters: Floats, residual: Floats) -> FourParameterIwan:
        chi, beta = map(float, parameters)
        return FourParameterIwan(sliding_load, stiffness, chi, beta, residual)

    def relative_error(parameters: Floats) -> Floats:
        return (iwan_model(parameters, load).load(displacement) - load) / sliding_load

    bounds = [-1 + 1e-6, 0.0], [0.0, np.inf]
    initial_parameters = [[chi, beta] for chi in (-0.8, -0.5, -0.1) for beta in (0.01, 1.0)]
    fits = [
        least_squares(relative_error, start, bounds=bounds, xtol=1e-12, ftol=1e-12, gtol=1e-12)
        for start in initial_parameters
    ]
    best_fit = min(fits, key=lambda fit: float(fit.cost))
    return iwan_model(best_fit.x, make_read_only(best_fit.fun * sliding_load))


def fit_lugre(displacement: Floats, load: Floats, *, sliding_load: float) -> LuGre:
    """Fit the LuGre model to an onset curve by minimizing the squared deviations of the tangential load."""
    _check_curve(displacement, load, 1)
    from scipy.optimize import least_squares

    initial_stiffness = load[0] / displacement[0]

    def relative_error(parameters: Floats) -> Floats:
        return (
            LuGre(sliding_load, initial_stiffness * math.exp(parameters[0]), load).load(displacement) - load
        ) / sliding_load

    fit = least_squares(relative_error, [0.0], xtol=1e-12, ftol=1e-12, gtol=1e-12)
    return LuGre(sliding_load, initial_stiffness * math.exp(fit.x[0]), make_read_only(fit.fun * sliding_load))


def _check_curve(displacement: Floats, load: Floats, min_points: int) -> None:
    if not np.isfinite(displacement).all():
        raise ValueError("displacement must be finite for a fit, but displacements of a free half-plane are infinite")
    if not displacement[0] > 0:
        raise ValueError(
            "displacement must be above 0 for a fit, but surfaces in full contact do not move before they slide"
        )
    if load.size < min_points:
        raise ValueError(
            f"a fit requires a curve with at least {min_points} loads, got {load.size}; specify more steps"
        )


def _validate_displacement(displacement: ArrayLike) -> Floats:
    displacements = float_array("displacement", displacement)
    if not (displacements >= 0).all():
        raise ValueError(f"displacement must be at least 0 µm, got {short_repr(displacement)}")
    return displacements
