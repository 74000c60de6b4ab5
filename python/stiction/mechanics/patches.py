"""Connected patches of a contact, with their true areas, slopes and friction sums."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats
from stiction.mechanics.model import SlidingRule

MAX_LEVEL_PATCH_SLOPE = 1e-6
"""Largest ratio of the mean slope of a patch to the rms slope in contact at which the patch counts as level.

Level patches do not oppose the motion. For a sphere on a flat, solver errors give a ratio of 1e-9 at a tolerance of
1e-6.
"""


def grid_slopes(heights: Floats, spacing: tuple[float, ...], *, periodic: bool) -> list[Floats]:
    """Compute the slopes of heights along each axis: by Fourier transform if periodic, otherwise by natural splines."""
    if periodic:
        return [_spectral_slope(heights, axis, step) for axis, step in enumerate(spacing)]
    heights_2d = np.atleast_2d(heights)
    slope_y, slope_x = _core.natural_slopes(np.ascontiguousarray(heights_2d), spacing=(spacing[0], spacing[-1]))
    return [slope_y, slope_x] if heights.ndim == 2 else [slope_x[0]]


def _spectral_slope(heights: Floats, axis: int, step: float) -> Floats:
    import scipy.fft

    n = heights.shape[axis]
    factor = 2j * np.pi * scipy.fft.rfftfreq(n, step)
    if n % 2 == 0:
        factor[-1] = 0.0  # a wave with the Nyquist wave number has no slope at the grid points
    shape = [1] * heights.ndim
    shape[axis] = factor.size
    spectrum = scipy.fft.rfft(heights, axis=axis) * factor.reshape(shape)
    return np.asarray(scipy.fft.irfft(spectrum, n, axis=axis, overwrite_x=True))


@dataclass(frozen=True, eq=False)
class PatchSums:
    """Sums over each patch of a contact, from which normal and tangential load follow for any mu0 and tau0.

    Arrays have the shape (patches,) or, if they depend on the direction, (directions, patches).
    """

    force: Floats  # vertical component of the contact forces, Σ F n_z (mN)
    area: Floats  # area along the deformed interface, µm²
    leaning: Floats  # component of the contact forces against the motion, -Σ F s·n (mN)
    upward: Floats  # vertical component of the friction due to mu0, divided by mu0: Σ F t_z (mN)
    forward: Floats  # component of the friction due to mu0 against the motion, divided by mu0: -Σ F s·t (mN)
    upward_area: Floats  # vertical component of the friction due to tau0, divided by tau0: Σ A t_z (µm²)
    forward_area: Floats  # component of the friction due to tau0 against the motion, divided by tau0: -Σ A s·t (µm²)
    steepness: float  # rms slope of the contact area, weighted by the contact force

    @property
    def opposes_motion(self) -> NDArray[np.bool_]:
        """Mask of the patches that push the upper surface against its motion, with shape (directions, patches)."""
        return np.asarray(self.leaning > MAX_LEVEL_PATCH_SLOPE * self.steepness * self.force)

    def totals(self, sliding: SlidingRule) -> dict[str, Any]:
        """Return area (µm²) and normal force (mN) of all patches, and the friction sums of the patches with friction.

        Sums that depend on the direction have the shape (directions,).
        """
        return {
            "contact_area": float(self.area.sum()),
            "normal_elastic": float(self.force.sum()),
            **dict(zip(DIRECTED_TOTALS, self.directed_totals(sliding), strict=True)),
        }

    def directed_totals(self, sliding: SlidingRule) -> Floats:
        """Return the sums of `DIRECTED_TOTALS` over the patches with friction, with shape (5, directions)."""
        contributes = True if sliding == "all" else self.opposes_motion
        sums = np.stack([self.leaning, self.upward, self.forward, self.upward_area, self.forward_area])
        return np.asarray(sums.sum(axis=-1, where=contributes))


DIRECTED_TOTALS = (
    "tangential_elastic", "normal_frictional", "tangential_frictional", "normal_adhesive", "tangential_adhesive",
)  # fmt: skip
"""Names of the force and area sums that depend on the direction of motion."""


def patch_sums(
    force: Floats, area: Floats, slope: list[Floats], patch: NDArray[np.int32], directions: Floats
) -> PatchSums:
    """Return the friction sums of each patch from forces (mN), areas (µm²), slopes and m directions of motion."""
    slope_y = slope[0] if len(slope) == 2 else None
    return PatchSums(**_core.patch_sums(force, area, slope_y, slope[-1], patch, list(directions)))
