"""The loads that a measured pair is pressed to around those that are asked for, so that there is a curve."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, float_array

AROUND = 30.0  # how far a curve of lines by asperities goes to both sides of the loads that are asked for
LOAD_STEPS = 25
AROUND_HALF_SPACE = 10.0  # as `AROUND`, of half-planes, where each load takes a solution
HALF_SPACE_STEPS = 7
AROUND_AREAS = 10**0.5  # ratio of the loads that are asked for to the one below and the one above them, of areas


def loads_around(loads: ArrayLike, *, around: float = AROUND, steps: int = LOAD_STEPS) -> Floats:
    """Given loads (mN), and enough others around them in equal ratios for a curve."""
    given = np.atleast_1d(float_array("loads", loads))
    if not given.size or not (given > 0).all():
        raise ValueError(f"loads must be above 0 mN, got {loads!r}")
    others = np.geomspace(given.min() / around, given.max() * around, steps)
    # Given ones stay to the bit; others next to them would be the same again.
    apart = np.abs(others[:, np.newaxis] / given - 1).min(axis=1) > 1e-6
    return np.unique(np.concatenate([given, others[apart]]))


def ladder(loads: ArrayLike, *, press: str, mechanics: str, most: float | None = None, lighter: int = 1) -> Floats:
    """Loads (mN) that a measured pair is pressed to, the given ones (above 0) among them.

    Members that are lines have as many loads as `loads_around`, of half-planes fewer; areas have `lighter` below
    and one above all. No load reaches `most` (mN), hardness times area.
    """
    if press == "lines" and mechanics == "asperities":
        around = loads_around(loads)
    elif press == "lines":
        around = loads_around(loads, around=AROUND_HALF_SPACE, steps=HALF_SPACE_STEPS)
    else:
        given = np.atleast_1d(float_array("loads", loads))
        around = np.unique(
            np.concatenate(
                [given, given.min() / AROUND_AREAS ** np.arange(1, lighter + 1), [given.max() * AROUND_AREAS]]
            )
        )
    # Those that are asked for stay to the bit, the others are written in few digits.
    asked = set(np.atleast_1d(float_array("loads", loads)).tolist())
    short = np.array([load if load in asked else float(f"{load:.6g}") for load in around.tolist()])
    return short if most is None else short[short < most]
