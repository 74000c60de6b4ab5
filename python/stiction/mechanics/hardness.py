"""Real contact area per load, interpolated between the hardnesses for which contacts were computed.

With the elastic mean pressure p, (A/F)^m = H^-m + p^-m contains both limits: the plastic area F/H and the elastic area.
For self-affine surfaces (Hurst exponents 0.5 and 0.8, p from 0.17 to 2.9 GPa, H from 0.23 to 1.7 GPa), m was 3.2
(H/p)^0.28 within a few per cent. The remaining deviation is therefore nearly linear in ln H between nodes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, float_array

MIXING_EXPONENT_FACTOR, MIXING_EXPONENT_POWER = 3.2, 0.28
"""Constants of the exponent m: its value if hardness and elastic pressure are equal, and the power of their ratio."""


def interpolate_area_per_load(hardness: ArrayLike, nodes: ArrayLike, at_nodes: ArrayLike, elastic: ArrayLike) -> Floats:
    """Interpolate the real area per load, A/F (1/GPa), between the hardnesses for which contacts were computed.

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
    >>> from stiction.mechanics.hardness import interpolate_area_per_load
    >>> interpolate_area_per_load([1.0], [0.5, 2.0], [2.0, 0.5], 0.01).round(2)
    array([1.])
    """
    target_hardnesses, node_hardnesses = (
        float_array(name, values, ndim=1) for name, values in (("hardness", hardness), ("nodes", nodes))
    )
    log_targets, log_nodes = np.log(target_hardnesses), np.log(node_hardnesses)
    log_elastic = np.log(float_array("elastic", elastic))[..., np.newaxis]
    log_excess = np.log(float_array("at_nodes", at_nodes)) - _estimate_log_area_per_load(log_nodes, log_elastic)
    log_area = _estimate_log_area_per_load(log_targets, log_elastic) + _interpolate_linearly(
        log_targets, log_nodes, log_excess
    )
    return np.asarray(np.exp(log_area))


def _estimate_log_area_per_load(log_hardness: Floats, log_elastic: Floats) -> Floats:
    """Estimate ln(A/F) from the logarithm of the hardness (GPa) and the logarithm of the elastic A/F (1/GPa).

    Using logarithms is several times faster than using powers.
    """
    log_ratio = log_hardness + log_elastic
    exponent = MIXING_EXPONENT_FACTOR * np.exp(MIXING_EXPONENT_POWER * log_ratio)
    mixing_term = np.log(1 + np.exp(-exponent * np.abs(log_ratio))) / exponent
    return np.asarray(np.maximum(-log_hardness, log_elastic) + mixing_term)


def _interpolate_linearly(x: Floats, nodes: Floats, values: Floats) -> Floats:
    """Interpolate values of shape (..., n) linearly between n increasing nodes. Beyond the nodes, use the end values.

    A sum over the changes of the slope is faster than a search for the panel of each x.
    """
    clipped_x = np.clip(x, nodes[0], nodes[-1])
    slopes = np.diff(values, axis=-1) / np.diff(nodes)
    slope_changes = np.diff(slopes, axis=-1, prepend=0.0)
    result = np.repeat(values[..., :1], x.size, axis=-1)
    distance_above_node = np.empty_like(clipped_x)
    for node, slope_change in zip(nodes[:-1], np.moveaxis(slope_changes, -1, 0), strict=True):
        np.subtract(clipped_x, node, out=distance_above_node)
        np.maximum(distance_above_node, 0.0, out=distance_above_node)
        result += slope_change[..., np.newaxis] * distance_above_node
    return result
