"""Real contact area per load, interpolated between the hardnesses of solved contacts.

With p the elastic mean pressure, (A/F)^m = H^-m + p^-m contains both limits, F/H and the elastic area. For self-affine
surfaces (Hurst exponents 0.5 and 0.8, p from 0.17 to 2.9 GPa, H from 0.23 to 1.7 GPa), m was 3.2 (H/p)^0.28 within a
few per cent. The remaining deviation is therefore nearly linear in ln H between nodes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, float_array

MIXING_EXPONENT, MIXING_POWER = 3.2, 0.28
"""Exponent m if the hardness equals the elastic pressure, and the power of the ratio of hardness and pressure in m."""


def area_per_load(hardness: ArrayLike, nodes: ArrayLike, at_nodes: ArrayLike, elastic: ArrayLike) -> Floats:
    """Interpolate A/F (1/GPa) between the hardnesses of solved contacts.

    Parameters
    ----------
    hardness : (h,) array_like of float, GPa
    nodes : (n,) array_like of float, GPa
        Increasing.
    at_nodes : (..., n) array_like of float, 1/GPa
        A/F at the nodes.
    elastic : (...) array_like of float, 1/GPa
        A/F without yielding; an estimate suffices if all contacts are plastic.

    Returns
    -------
    (..., h) ndarray

    Examples
    --------
    >>> from stiction.mechanics.hardness import area_per_load
    >>> area_per_load([1.0], [0.5, 2.0], [2.0, 0.5], 0.01).round(2)
    array([1.])
    """
    targets, solved = (float_array(name, values, ndim=1) for name, values in (("hardness", hardness), ("nodes", nodes)))
    softest = float_array("elastic", elastic)[..., np.newaxis]
    excess = np.log(float_array("at_nodes", at_nodes) / _estimate(solved, softest))
    if solved.size == 1:
        return np.asarray(_estimate(targets, softest) * np.exp(excess))
    log_targets = np.clip(np.log(targets), *np.log(solved[[0, -1]]))
    upper = np.clip(np.searchsorted(np.log(solved), log_targets), 1, solved.size - 1)
    weight = (log_targets - np.log(solved)[upper - 1]) / np.diff(np.log(solved))[upper - 1]
    log_ratio = excess[..., upper - 1] * (1 - weight) + excess[..., upper] * weight
    return np.asarray(_estimate(targets, softest) * np.exp(log_ratio))


def _estimate(hardness: Floats, elastic: Floats) -> Floats:
    """Estimate A/F (1/GPa) from a hardness (GPa) and the elastic A/F (1/GPa)."""
    plastic = 1.0 / hardness
    exponent = MIXING_EXPONENT * (hardness * elastic) ** MIXING_POWER
    larger, smaller = np.maximum(plastic, elastic), np.minimum(plastic, elastic)
    return np.asarray(larger * np.exp(np.log1p((smaller / larger) ** exponent) / exponent))
