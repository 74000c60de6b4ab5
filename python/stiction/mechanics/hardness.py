"""Area of contacts that yield, in closed form from the area of the elastic contact at the same load.

A limit on the pressure misses up to 30 % of the true area of metals, because metals also yield below the surface. The
closed form was fitted to elastic-plastic calculations; see the page "Area of yielding contacts".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats

ELASTIC_PRESSURE_FRACTION = 0.5
"""Mean pressure, as a fraction of the hardness, up to which contacts count as elastic."""


def yielded_area(elastic_area: ArrayLike, load: ArrayLike, hardness: ArrayLike, exponent: ArrayLike) -> Floats:
    """Return the true area (µm²) of contacts that yield: A^m = A_el^m + (F/H)^m - (A_el/2)^m, or A_el if F < A_el H/2.

    The arguments are broadcast against each other. The area is not limited by the nominal area.

    Parameters
    ----------
    elastic_area : array_like of float, µm²
        True area A_el of the elastic contact at the same load, above 0.
    load : array_like of float, mN
    hardness : array_like of float, GPa
        Infinite for elastic bodies.
    exponent : array_like of float
        m; elastic-plastic calculations of single surfaces give 0.7 to 1.6.

    Examples
    --------
    >>> from stiction.mechanics.hardness import yielded_area
    >>> yielded_area(2.0, [1.0, 4.0, 40.0], 2.0, 1.25).round(2)  # elastic, yielding, nearly plastic
    array([ 2.  ,  2.88, 20.52])
    """
    area = np.asarray(elastic_area, dtype=np.float64)
    pressure_ratio = np.asarray(load) / (area * np.asarray(hardness))  # mean elastic pressure / hardness
    power = np.asarray(exponent)
    # Exponentials of logarithms are several times faster than powers.
    log_ratio = np.log(np.maximum(pressure_ratio, ELASTIC_PRESSURE_FRACTION))
    excess = np.exp(power * log_ratio) - np.exp(power * np.log(ELASTIC_PRESSURE_FRACTION))
    return np.asarray(area * np.exp(np.log(1.0 + excess) / power))
