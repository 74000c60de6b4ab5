"""What engineers put in place of the onset of sliding: four-parameter Iwan and LuGre models, fitted to its curve."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, float_array, read_only
from stiction._repr import TextRepr

FEWEST_POINTS = 3  # of a curve to which two parameters are fitted
RIGID = 1e-12  # of the last displacement, below which the first one is round-off


@dataclass(frozen=True, eq=False, repr=False)
class FourParameterIwan(TextRepr):
    """Springs in parallel that slip one after the other, their strengths spread as a power (Segalman).

    Attributes
    ----------
    sliding_load : float, mN
    stiffness : float, mN/µm
        F_S, and K_T at rest: of the curve, not fitted.
    chi : float
        Above -1 and at most 0: at small amplitudes a cycle takes energy as the amplitude to the power χ + 3.
    beta : float
        At least 0: the stiffness of what slips in the end at once over that of what slips before.
    residual : (k,) ndarray, mN
        Load of the model less that of the curve, at the curve's displacements.

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
        """φ, µm."""
        chi, beta = self.chi, self.beta
        return self.sliding_load * (1 + beta) / (self.stiffness * (beta + (chi + 1) / (chi + 2)))

    def load(self, displacement: ArrayLike) -> Floats:
        """Tangential load (mN) at displacements (µm), at least 0, on the first way up."""
        way = _ways(displacement)
        part = np.minimum(way / self.displacement_at_sliding, 1.0)
        softer = part ** (self.chi + 1) / ((self.chi + 2) * (1 + self.beta))
        rising = self.stiffness * way * (1 - softer)
        return np.asarray(np.where(part < 1, rising, self.sliding_load))

    def energy_lost(self, displacement: ArrayLike) -> Floats:
        """What a cycle between plus and minus a displacement (µm) takes, mN µm."""
        way, last = _ways(displacement), self.displacement_at_sliding
        part = np.minimum(way / last, 1.0)
        softer = part ** (self.chi + 1) / ((self.chi + 2) * (1 + self.beta))
        # 8 times the area below the first way up, less 4 times the square about it (Masing).
        rising = 4 * self.stiffness * softer * (self.chi + 1) / (self.chi + 3) * np.minimum(way, last) ** 2
        return np.asarray(rising + 4 * self.sliding_load * np.maximum(way - last, 0.0))


@dataclass(frozen=True, eq=False, repr=False)
class LuGre(TextRepr):
    """Bristles that bend and give way at one load: the presliding part of the LuGre model.

    Attributes
    ----------
    sliding_load : float, mN
        Of the curve, not fitted.
    stiffness : float, mN/µm
        σ0, of the bristles.
    residual : (k,) ndarray, mN
        Load of the model less that of the curve, at the curve's displacements.

    Notes
    -----
    F = F_S (1 - exp(-σ0 u/F_S)) when pushed slowly from rest, the steady state dz/du = 1 - σ0 z/F_S of Canudas de Wit,
    Olsson, Åström & Lischinsky, IEEE Transactions on Automatic Control 40 (1995) 1119.

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
        """Tangential load (mN) at displacements (µm), at least 0, on the first way up."""
        return np.asarray(-self.sliding_load * np.expm1(-self.stiffness * _ways(displacement) / self.sliding_load))


def fitted_iwan(displacement: Floats, load: Floats, *, sliding_load: float, stiffness: float) -> FourParameterIwan:
    """The model nearest to a curve, by least squares of its load."""
    from scipy.optimize import least_squares

    _check(displacement, load, FEWEST_POINTS)

    def model(values: Floats, residual: Floats) -> FourParameterIwan:
        chi, beta = map(float, values)
        return FourParameterIwan(sliding_load, stiffness, chi, beta, residual)

    def missed(values: Floats) -> Floats:
        return (model(values, load).load(displacement) - load) / sliding_load

    limits = [-1 + 1e-6, 0.0], [0.0, np.inf]
    starts = [[chi, beta] for chi in (-0.8, -0.5, -0.1) for beta in (0.01, 1.0)]
    fits = [least_squares(missed, start, bounds=limits, xtol=1e-12, ftol=1e-12, gtol=1e-12) for start in starts]
    best = min(fits, key=lambda fit: float(fit.cost))
    return model(best.x, read_only(best.fun * sliding_load))


def fitted_lugre(displacement: Floats, load: Floats, *, sliding_load: float) -> LuGre:
    """The model nearest to a curve, by least squares of its load."""
    from scipy.optimize import least_squares

    _check(displacement, load, 1)
    first = load[0] / displacement[0]

    def missed(values: Floats) -> Floats:
        return (LuGre(sliding_load, first * math.exp(values[0]), load).load(displacement) - load) / sliding_load

    fit = least_squares(missed, [0.0], xtol=1e-12, ftol=1e-12, gtol=1e-12)
    return LuGre(sliding_load, first * math.exp(fit.x[0]), read_only(fit.fun * sliding_load))


def _check(displacement: Floats, load: Floats, fewest: int) -> None:
    if not np.isfinite(displacement).all():
        raise ValueError("there are no displacements to fit: a free half-plane has none")
    if not displacement[0] > RIGID * displacement[-1]:
        raise ValueError("there are no displacements to fit: bodies in full contact do not give way")
    if load.size < fewest:
        raise ValueError(f"a fit needs at least {fewest} loads, got {load.size}: give more steps")


def _ways(displacement: ArrayLike) -> Floats:
    way = float_array("displacement", displacement)
    if not (way >= 0).all():
        raise ValueError(f"displacement must be at least 0 µm, got {displacement!r}")
    return way
