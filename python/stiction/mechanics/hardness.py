"""Closed-form area of yielding contacts, computed from the area of elastic contacts at the same load.

A limit on the pressure misses up to 30 % of the true area of metals, because metals also yield below the surface. The
closed form was fitted to elastic-plastic calculations; see the page "Area of yielding contacts".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction.mechanics.model import PROFILE_WIDTH

MAX_ELASTIC_PRESSURE_RATIO = 0.5
"""Mean pressure, as a fraction of the hardness, up to which contacts count as elastic."""

HARDNESS_TO_YIELD_RATIO = 2.84
"""Ratio of hardness to yield strength in the contact law of Jackson and Green."""

BALL_YIELD_PRESSURE_RATIO = round(1.1 / HARDNESS_TO_YIELD_RATIO, 2)
"""Ratio of mean pressure to hardness at which a ball starts to yield: 1.1 yield strengths (Johnson 1985, chapter 6).

The ratio is rounded to two digits, like the factor 1.1.
"""

MIN_SIZE_EFFECT_LENGTH, MAX_SIZE_EFFECT_LENGTH = 0.1, 2.0
"""Range (µm) of the length h* of the indentation size effect of metals: H = H0 sqrt(1 + h*/h) at the depth h.

Nix & Gao, Journal of the Mechanics and Physics of Solids 46 (1998) 411.
"""

CENTRAL_SIZE_EFFECT_LENGTH = (MIN_SIZE_EFFECT_LENGTH * MAX_SIZE_EFFECT_LENGTH) ** 0.5


INDENTATION_AREA_RATIO = 24.5
"""Ratio of the projected area of a Vickers or Berkovich indentation to its squared depth."""


def ball_yield_pressure(hardness: float) -> float:
    """Return the mean pressure (GPa) at which a ball of a given hardness (GPa) starts to yield.

    If the hardness is unknown (NaN), NaN is returned.
    """
    return BALL_YIELD_PRESSURE_RATIO * hardness


def size_effect_factor(length: ArrayLike, depth: ArrayLike, indent: ArrayLike = np.inf) -> Floats:
    """Return the ratio of the hardness of small contacts to the hardness from an indentation test.

    Parameters
    ----------
    length : array_like of float, µm
        Length h* of the indentation size effect.
    depth : array_like of float, µm
        Depth of an indentation that corresponds to the contacts, as `estimate_indentation_depth` returns.
    indent : array_like of float, µm
        Depth of the indentation that measured the hardness. By default, it is so large that the hardness does not
        depend on its size.

    Examples
    --------
    >>> from stiction.mechanics.hardness import size_effect_factor
    >>> size_effect_factor(0.5, [0.05, 5.0], indent=5.0).round(2)
    array([3.16, 1.  ])
    """
    length = np.asarray(length, dtype=np.float64)
    return np.asarray(np.sqrt((1 + length / np.asarray(depth)) / (1 + length / np.asarray(indent))))


def estimate_indentation_depth(
    area: ArrayLike, contact_count: ArrayLike, slope: ArrayLike, *, are_lines: bool = False
) -> Floats:
    """Estimate the depth (µm) of an indentation with the same strain gradient as the contacts.

    The density of geometrically necessary dislocations is proportional to the slope divided by the radius. The contacts
    have a total area (µm²) and the rms slope of the gap. A flat contact corresponds to a deeper indentation. Contacts
    of profiles have half their width as the radius.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        mean_area = np.asarray(area) / np.asarray(contact_count)
        radius = mean_area / (2 * PROFILE_WIDTH) if are_lines else np.sqrt(mean_area / np.pi)
        return np.asarray(np.pi / INDENTATION_AREA_RATIO * radius / np.asarray(slope))


def yielded_area(elastic_area: ArrayLike, load: ArrayLike, hardness: ArrayLike, exponent: ArrayLike) -> Floats:
    """Return the true area A (µm²) of yielding contacts at a load F and a hardness H.

    With the exponent m, A^m = A_el^m + (F/H)^m - (A_el/2)^m, or A = A_el if F < A_el H/2. The arguments are broadcast
    against each other. The area is not limited by the nominal area.

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
    pressure_ratio = np.asarray(load) / (area * np.asarray(hardness))
    power = np.asarray(exponent)
    # exp(power · log(x)) is several times faster than x**power.
    log_ratio = np.log(np.maximum(pressure_ratio, MAX_ELASTIC_PRESSURE_RATIO))
    excess = np.exp(power * log_ratio) - np.exp(power * np.log(MAX_ELASTIC_PRESSURE_RATIO))
    return np.asarray(area * np.exp(np.log(1.0 + excess) / power))
