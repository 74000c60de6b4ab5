"""What pressures on a grid say of friction: connected patches, true areas, slopes, and the sums over them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats
from stiction.mechanics.model import Sliding

LEVEL = 1e-6
"""Largest mean slope of a level patch, which does not oppose, over the root-mean-square slope in contact. The pressures
of a level patch, as of a ball on a flat, lean by 1e-9 of that at a tolerance of 1e-6."""


def slopes(heights: Floats, spacing: tuple[float, ...], *, periodic: bool) -> list[Floats]:
    """Slope at every point along each axis: of the waves where periodic, of natural cubic splines elsewhere."""
    if periodic:
        return [_wave_slope(heights, axis, step) for axis, step in enumerate(spacing)]
    rows = np.atleast_2d(heights)
    by_y, by_x = _core.natural_slopes(np.ascontiguousarray(rows), spacing=(spacing[0], spacing[-1]))
    return [by_y, by_x] if heights.ndim == 2 else [by_x[0]]


def _wave_slope(heights: Floats, axis: int, step: float) -> Floats:
    n = heights.shape[axis]
    factor = 2j * np.pi * scipy.fft.rfftfreq(n, step)
    if n % 2 == 0:
        factor[-1] = 0.0  # the shortest wave has no slope at its points
    shape = [1] * heights.ndim
    shape[axis] = factor.size
    waves = scipy.fft.rfft(heights, axis=axis) * factor.reshape(shape)
    return np.asarray(scipy.fft.irfft(waves, n, axis=axis, overwrite_x=True))


@dataclass(frozen=True, eq=False)
class PatchSums:
    """What F_N and F_T need for every mu0 and tau0, of each patch: (patches,), or (directions, patches)."""

    force: Floats  # mN, Σ F n_z
    area: Floats  # µm², along the deformed interface
    leaning: Floats  # mN, -Σ F s·n
    upward: Floats  # mN, Σ F t_z, and
    forward: Floats  # -Σ F s·t, for friction
    upward_area: Floats  # µm², Σ A t_z, and
    forward_area: Floats  # -Σ A s·t, for adhesion
    steepness: float  # root-mean-square slope in contact, weighted with the force

    @property
    def opposing(self) -> NDArray[np.bool_]:
        """(directions, patches): whether a patch pushes the upper body back."""
        return np.asarray(self.leaning > LEVEL * self.steepness * self.force)

    def total(self, sliding: Sliding) -> dict[str, Any]:
        """The sums of a `HalfSpaceCurve` by a sliding rule; those that depend on the direction as (directions,)."""
        rubs = True if sliding == "all" else self.opposing
        each = {
            "tangential_elastic": self.leaning, "normal_frictional": self.upward, "tangential_frictional": self.forward,
            "normal_adhesive": self.upward_area, "tangential_adhesive": self.forward_area,
        }  # fmt: skip
        return {
            "contact_area": float(self.area.sum()),
            "normal_elastic": float(self.force.sum()),
            **{name: values.sum(axis=1, where=rubs) for name, values in each.items()},
        }


def patch_sums(
    force: Floats, area: Floats, slope: list[Floats], patch: NDArray[np.int32], directions: Floats
) -> PatchSums:
    """Sums over the points of each patch, from their forces (mN), areas (µm²) and slopes, for (m, 2) unit vectors."""
    along_y = slope[0] if len(slope) == 2 else None
    return PatchSums(**_core.patch_sums(force, area, along_y, slope[-1], patch, list(directions)))
