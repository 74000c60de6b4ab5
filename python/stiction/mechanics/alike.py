"""Warnings about bodies pressed on themselves: a slip that gives plausible numbers."""

from __future__ import annotations

import warnings

import numpy as np

from stiction._checks import Floats
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

TURNED = "turned over"  # what the history of a body says that `turned_over` has made
_ROUND_OFF = 1e-9  # of the height of a body, by which two that are the same may differ


def warn_of_one_body(upper: Profile | Surface, lower: Profile | Surface, *, moved: bool = False) -> None:
    """Warn of a body that is pressed on itself, or on its own mirror image unless it is `moved` before."""
    source, is_one = _source(upper), _source(upper) == _source(lower)
    faces = [body.history.count(TURNED) % 2 for body in (upper, lower)]
    said = ""
    if is_one and source[:1] and source[0].startswith("read from") and faces[0] == faces[1]:
        said = f"upper and lower were both {source[0]} and face the same way: press turned_over(upper) on lower"
    elif upper.heights.shape != lower.heights.shape or upper.is_flat:
        return
    elif upper is lower or (is_one and source and _differ_by_a_constant(upper.heights, lower.heights)):
        said = "upper and lower are the same and fit into each other everywhere: press turned_over(upper) on lower"
    elif is_one and not moved and (source or (faces[0] and isinstance(upper, Surface))):
        if _differ_by_a_constant(upper.heights, -lower.heights):
            said = (
                "upper is the mirror image of lower, whose summits meet themselves, so that their slopes cancel: move "
                "one of them, or press another piece"
            )
        elif _differ_by_a_constant(upper.heights, -lower.heights[::-1]):
            said = (
                "upper is lower turned over, so that the gap is the same on both sides of its middle row and slopes "
                "along y cancel: move one of them, or press another piece"
            )
    if said:
        warnings.warn(said, stacklevel=3)


def _source(body: Profile | Surface) -> tuple[str, ...]:
    """What a body was made from, whichever way it faces."""
    return tuple(step for step in body.history if step != TURNED)


def _differ_by_a_constant(a: Floats, b: Floats) -> bool:
    """Whether two arrays of one shape are the same but for their height; a row that is not is enough to tell."""
    allowed = _ROUND_OFF * float(np.ptp(a))
    first = np.atleast_2d(a)[0, :64] - np.atleast_2d(b)[0, :64]
    return float(np.ptp(first)) <= allowed and float(np.ptp(a - b)) <= allowed
