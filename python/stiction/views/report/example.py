"""Some pairs of generated profiles around where they first touch, with their contacts, for a page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.mechanics.contact import contacts
from stiction.studies.members import pairs_of
from stiction.studies.study import Study
from stiction.surfaces.profile import Profile

if TYPE_CHECKING:
    import xarray

WINDOW = 1500  # points of the example profiles, around where they first touch
MARGIN = 64  # points beyond the window, past which a spline does not look
MOST_PAIRS = 3  # members of which example profiles are shown
MOST_EXAMPLES = {"fractal_dimension": 20, "amplitude": 20, "approach": 60}  # of the example profiles
MOST_CONTACTS = 60  # contacts drawn of the example profiles at an approach: those with the largest forces


@dataclass(frozen=True)
class Example:
    """Some pairs around where they first touch, at some of the dimensions, amplitudes and approaches."""

    profiles: Floats  # (pair, dimension, lower or upper, point) at the first amplitude, from first touch, µm
    contacts: Floats  # (x, z, n_x, force) of each contact, all pairs, dimensions, amplitudes and approaches in a row
    facts: dict[str, Any]

    @classmethod
    def of(cls, coordinates: xarray.Dataset, study: Study) -> Example:
        """Example profiles of the first members of a result by asperities, made from its coordinates."""
        shown = {
            name: np.unique(np.linspace(0, size - 1, min(most, size)).round()).astype(np.intp)
            for name, most in MOST_EXAMPLES.items()
            for size in (coordinates.sizes[name],)
        }
        some = coordinates.isel(shown)
        pairs = min(MOST_PAIRS, coordinates.sizes["repetition"])
        amplitudes, approaches = some["amplitude"].values, some["approach"].values
        profiles, columns, counts, left_out, starts = [], [], [], [], []
        for lower, upper, start, crop, touch in (
            window
            for repetition in coordinates["repetition"].values[:pairs]
            for window in _windows(study, int(repetition), some["fractal_dimension"].values, amplitudes[0])
        ):
            inside = slice(start - crop, start - crop + WINDOW)
            profiles.append([body.heights[inside] - touch for body in (lower, upper)])
            starts.append(start * lower.spacing)
            for amplitude, approach in ((a, d) for a in amplitudes for d in approaches):
                factor = amplitude / amplitudes[0]
                table = _contacts(study, lower, upper, factor, approach)
                at = table["index"] + crop - start
                table["x"] -= (start - crop) * lower.spacing
                table["z"] -= factor * touch
                seen = np.flatnonzero((at >= 0) & (at < WINDOW))
                drawn = np.sort(seen[np.argsort(-table["force"][seen], kind="stable")[:MOST_CONTACTS]])
                columns.append(np.stack([table[name][drawn] for name in ("x", "z", "normal", "force")]))
                counts.append(drawn.size)
                left_out.append(seen.size - drawn.size)
        facts = {
            "pairs": pairs, "dimensions": shown["fractal_dimension"].tolist(),
            "amplitudes": shown["amplitude"].tolist(), "approaches": shown["approach"].tolist(), "counts": counts,
            "leftOut": left_out, "starts": starts, "spacing": lower.spacing, "points": len(profiles[0][0]),
        }  # fmt: skip
        return cls(np.array(profiles), np.concatenate(columns, axis=1), facts)


def _windows(
    study: Study, repetition: int, dimensions: Floats, amplitude: float
) -> Iterator[tuple[Profile, Profile, int, int, float]]:
    """Yield for each dimension the two profiles, cut out, and where the cut lies.

    That is the first point of the window, the first point of what is cut out, and the height at which the two touch.
    Scaled to another amplitude they touch at the same point.
    """
    for upper, lower in pairs_of(study, repetition, dimensions, amplitude):
        touch = int(np.argmin(upper.heights - lower.heights))
        start = max(0, min(touch - WINDOW // 2, len(lower) - WINDOW))
        crop = max(0, start - MARGIN)
        cut = slice(crop, start + WINDOW + MARGIN)
        height = float(lower.heights[touch])
        raised = upper.heights[cut] - (upper.heights[touch] - height)  # until the two touch
        yield (
            Profile(lower.heights[cut], spacing=lower.spacing), Profile(raised, spacing=lower.spacing),
            start, crop, height,
        )  # fmt: skip


def _contacts(study: Study, lower: Profile, upper: Profile, factor: float, approach: float) -> dict[str, NDArray[Any]]:
    """Index, position (µm), x component of the normal and force (mN) of every contact."""
    upper, lower = (Profile(factor * body.heights, spacing=body.spacing) for body in (upper, lower))
    contact: Any = study.contact
    found = contacts(upper, lower, float(approach), model=contact.model(contact.rules()[0]))
    return {
        "index": found.index, "x": found.centre[:, 0].copy(), "z": found.centre[:, 2].copy(),
        "normal": found.normal[:, 0], "force": found.force,
    }  # fmt: skip
