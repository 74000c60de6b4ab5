"""Connected patches of a contact: their areas, slopes, and force and area sums from which friction follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

import stiction._core as _core
from stiction._caching import cached_property
from stiction._checks import Floats
from stiction.mechanics.model import SlidingRule

MAX_SLOPE_RATIO_OF_LEVEL_PATCH = 1e-6
"""A patch counts as level up to this ratio of its mean slope to the rms slope in contact.

Level patches do not oppose the motion. For a sphere on a flat, solver errors give a ratio of 1e-9 at a tolerance of
1e-6.
"""


def grid_slopes(heights: Floats, spacing: tuple[float, ...], *, periodic: bool) -> list[Floats]:
    """Compute slopes of heights along each axis, from Fourier transforms if periodic, or else from natural splines."""
    compute_slopes = _core.periodic_slopes if periodic else _core.natural_slopes
    slope_y, slope_x = compute_slopes(np.ascontiguousarray(np.atleast_2d(heights)), spacing=(spacing[0], spacing[-1]))
    return [slope_y, slope_x] if heights.ndim == 2 else [slope_x[0]]


@dataclass(frozen=True, eq=False)
class PatchSums:
    """Force and area sums of each contact patch in k contact solutions, for evaluating loads at any mu0 and tau0.

    A patch has the force F along its normal n, the area A, and friction of mu0 F + tau0 A along its tangent t; the
    slider moves along s.

    Patches are stored contact by contact. Arrays have the shape (patches,) or, if they depend on the direction,
    (directions, patches).
    """

    force: Floats  # Σ F n_z, mN
    # Area of each contact patch along the deformed interface (µm²).
    area: Floats
    leaning: Floats  # -Σ F s·n, mN
    upward: Floats  # Σ F t_z, mN
    forward: Floats  # -Σ F s·t, mN
    upward_area: Floats  # Σ A t_z, µm²
    forward_area: Floats  # -Σ A s·t, µm²
    # Rms slope in each contact solution, weighted by the contact force; one element per solution.
    steepness: Floats
    first_patch: NDArray[np.int64]

    @classmethod
    def join(cls, parts: Sequence[PatchSums]) -> PatchSums:
        """Join the force and area sums of the patches of several contacts, in the order of the contacts."""
        first_patch = [0, *np.cumsum([part.force.size for part in parts[:-1]])]
        joined = {
            field.name: np.concatenate([getattr(part, field.name) for part in parts], axis=-1) for field in fields(cls)
        }
        offsets = np.repeat(first_patch, [part.first_patch.size for part in parts])
        return cls(**joined | {"first_patch": joined["first_patch"] + offsets})

    @cached_property
    def opposes_motion(self) -> NDArray[np.bool_]:
        """Boolean array (directions, patches), True if a patch pushes the upper surface against its motion."""
        patch_counts = np.diff(self.first_patch, append=self.force.size)
        return np.asarray(
            self.leaning > np.repeat(MAX_SLOPE_RATIO_OF_LEVEL_PATCH * self.steepness, patch_counts) * self.force
        )

    def totals(self, sliding: SlidingRule) -> dict[str, Floats]:
        """Return the total area (µm²) and normal force (mN) of all patches, and the sums for each direction of motion.

        The sums for each direction determine friction.

        Sums have the shape (k,) or, if they depend on the direction, (directions, k).
        """
        return {
            "contact_area": self._sum_over_patches(self.area),
            "normal_elastic": self._sum_over_patches(self.force),
            **dict(zip(DIRECTED_TOTAL_NAMES, self.directed_totals(sliding), strict=True)),
        }

    def directed_totals(self, sliding: SlidingRule) -> list[Floats]:
        """Sum forces and areas over the patches at which friction acts, for each direction of motion.

        The arrays have the shape (directions, k) for k contacts.
        """
        sums = (self.leaning, self.upward, self.forward, self.upward_area, self.forward_area)
        if sliding == "all":
            return [self._sum_over_patches(values) for values in sums]
        return [self._sum_over_patches(np.where(self.opposes_motion, values, 0.0)) for values in sums]

    def _sum_over_patches(self, values: Floats) -> Floats:
        """Return the sum of a quantity over all patches of each contact."""
        return np.asarray(np.add.reduceat(values, self.first_patch, axis=-1))


DIRECTED_TOTAL_NAMES = (
    "tangential_elastic", "normal_frictional", "tangential_frictional", "normal_adhesive", "tangential_adhesive",
)  # fmt: skip
"""Names of the force and area sums that depend on the direction of motion."""


ContactArrays = tuple[NDArray[np.int64], Floats, Floats, NDArray[np.int32]]
"""Grid index, pressure (GPa), contact fraction and patch number of each point of a contact."""


def patch_sums(
    contacts: Sequence[ContactArrays], slopes: list[Floats], cell_area: float, directions: Floats
) -> PatchSums:
    """Return the force and area sums of each patch in k contact solutions, for m directions of motion.

    `slopes` has the slopes of the deformed interface at all grid points, along y and x or, for profiles, along x.
    `cell_area` is the area of a grid cell (µm²), and directions are unit vectors of shape (m, 2).
    """
    slope_y = slopes[0] if len(slopes) == 2 else None
    return PatchSums(
        **_core.patch_sums(list(contacts), slope_y, slopes[-1], cell_area=cell_area, directions=list(directions))
    )
