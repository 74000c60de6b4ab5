"""Closure of a joint under normal load: Bandis' hyperbola, fitted to computed closures.

Bandis, Lumsden & Barton, International Journal of Rock Mechanics and Mining Sciences 20 (1983) 249.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stiction._checks import Floats

MAX_FITTED_TO_MEASURED_CLOSURE_RATIO = 10.0


@dataclass(frozen=True)
class BandisLaw:
    """Bandis' law of a joint, p = K c / (1 - c/V) for pressure p and closure c, with the misfit of the fitted law.

    Attributes
    ----------
    initial_stiffness : float, GPa/µm
        K, the stiffness per area without a load.
    maximum_closure : float, µm
        V, the closure that no load exceeds.
    misfit : float
        Largest relative deviation of the computed closures from the law.
    """

    initial_stiffness: float
    maximum_closure: float
    misfit: float


def fit_bandis_law(pressure: Floats, closure: Floats) -> BandisLaw:
    """Fit Bandis' law to closures (µm) at nominal pressures (GPa) by minimizing squared relative deviations.

    All numbers are NaN if the joint does not close, or if the closures are too small to determine the maximum.
    """
    from scipy.optimize import least_squares

    if not (closure > 0).all():
        return BandisLaw(math.nan, math.nan, math.nan)

    def compute_deviations(log_parameters: Floats) -> Floats:
        stiffness, maximum_closure = np.exp(log_parameters)
        return np.asarray(np.log(pressure * maximum_closure / (stiffness * maximum_closure + pressure) / closure))

    best_fit = least_squares(compute_deviations, np.log([pressure[0] / closure[0], 1.2 * closure[-1]]))
    stiffness, maximum_closure = np.exp(best_fit.x)
    if maximum_closure > MAX_FITTED_TO_MEASURED_CLOSURE_RATIO * closure[-1]:
        return BandisLaw(math.nan, math.nan, math.nan)
    return BandisLaw(float(stiffness), float(maximum_closure), math.expm1(float(np.abs(best_fit.fun).max())))
