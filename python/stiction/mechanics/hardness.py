"""True area per load between the hardnesses at which a contact was solved.

With p the elastic mean pressure, (A/F)^m = H^-m + p^-m holds both ends, F/H and the elastic area. Of self-affine areas
(Hurst exponents 0.5 and 0.8, p from 0.17 to 2.9 GPa, H from 0.23 to 1.7 GPa) m was 3.2 (H/p)^0.28 within a few per
cent, so that what is left between nodes is nearly straight in ln H.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, float_array

EXPONENT, POWER = 3.2, 0.28
"""m where the hardness is the elastic pressure, and its power of their ratio."""


def area_per_load(hardness: ArrayLike, nodes: ArrayLike, at_nodes: ArrayLike, elastic: ArrayLike) -> Floats:
    """A/F (1/GPa) at hardnesses between those that were solved.

    Parameters
    ----------
    hardness : (h,) array_like of float, GPa
    nodes : (n,) array_like of float, GPa
        Increasing.
    at_nodes : (..., n) array_like of float, 1/GPa
        A/F at the nodes.
    elastic : (...) array_like of float, 1/GPa
        A/F of bodies that do not yield; where contacts are plastic throughout an estimate will do.

    Returns
    -------
    (..., h) ndarray

    Examples
    --------
    >>> from stiction.mechanics.hardness import area_per_load
    >>> area_per_load([1.0], [0.5, 2.0], [2.0, 0.5], 0.01).round(2)
    array([1.])
    """
    wanted, known = (float_array(name, each, ndim=1) for name, each in (("hardness", hardness), ("nodes", nodes)))
    softest = float_array("elastic", elastic)[..., np.newaxis]
    excess = np.log(float_array("at_nodes", at_nodes) / _estimate(known, softest))
    if known.size == 1:
        return np.asarray(_estimate(wanted, softest) * np.exp(excess))
    where = np.clip(np.log(wanted), *np.log(known[[0, -1]]))
    after = np.clip(np.searchsorted(np.log(known), where), 1, known.size - 1)
    part = (where - np.log(known)[after - 1]) / np.diff(np.log(known))[after - 1]
    between = excess[..., after - 1] * (1 - part) + excess[..., after] * part
    return np.asarray(_estimate(wanted, softest) * np.exp(between))


def _estimate(hardness: Floats, elastic: Floats) -> Floats:
    """A/F (1/GPa) of a hardness (GPa) and elastic A/F (1/GPa)."""
    plastic = 1.0 / hardness
    exponent = EXPONENT * (hardness * elastic) ** POWER
    larger, smaller = np.maximum(plastic, elastic), np.minimum(plastic, elastic)
    return np.asarray(larger * np.exp(np.log1p((smaller / larger) ** exponent) / exponent))
