"""Roughness of rock joints: Z2, joint roughness coefficient, mean rising slope and mean falling slope.

Tse & Cruden, International Journal of Rock Mechanics and Mining Sciences 16 (1979) 303.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from stiction._checks import Floats

# Sampling interval (µm) at which the published relation between Z2 and JRC was fitted.
SAMPLING_INTERVAL = 1270.0
MAX_SAMPLING_INTERVAL_DEVIATION = 0.2
# Range of Z2 in which the published relation between Z2 and JRC was fitted.
MIN_Z2, MAX_Z2 = 0.1, 0.42


@dataclass(frozen=True)
class JointRoughness:
    """Z2, mean rising slope and mean falling slope of a rock joint's face in one direction.

    Attributes
    ----------
    sampling_interval : float, µm
        Distance between the compared points: the multiple of the grid spacing closest to 1.27 mm, or less on a
        shorter face.
    z2 : float
        Root-mean-square slope, which is the same for both senses of a direction.
    rising_slope, falling_slope : float
        Mean of the slopes that rise along the direction, and of the magnitudes of those that fall.
    """

    sampling_interval: float
    z2: float
    rising_slope: float
    falling_slope: float

    @property
    def jrc(self) -> float:
        """Joint roughness coefficient 32.2 + 32.47 log10 Z2, or NaN outside the range of the published fit.

        The range limits Z2 and the sampling interval.
        """
        deviation = abs(self.sampling_interval / SAMPLING_INTERVAL - 1)
        if not (MIN_Z2 <= self.z2 <= MAX_Z2 and deviation <= MAX_SAMPLING_INTERVAL_DEVIATION):
            return math.nan
        return 32.2 + 32.47 * math.log10(self.z2)


def measure_joint_roughness(face: Any, direction: float) -> JointRoughness:
    """Measure Z2 and the mean slopes of a rock joint's profile or map in a direction (degrees from +x towards +y)."""
    angle = math.radians(direction)
    direction_vector = np.array([math.sin(angle), math.cos(angle)])[-face.heights.ndim :]
    spacing = np.array(face.spacings)
    largest_index = np.array(face.heights.shape) - 1
    offsets = SAMPLING_INTERVAL * direction_vector / spacing
    offsets *= min(1.0, float(np.min(largest_index / np.maximum(np.abs(offsets), 1e-9))))
    steps = np.rint(offsets).astype(int)
    if not steps.any():
        steps[int(np.argmax(np.abs(direction_vector / spacing)))] = (
            1 if direction_vector[np.argmax(np.abs(direction_vector / spacing))] > 0 else -1
        )
    sampling_interval = float(np.hypot.reduce(steps * spacing))
    slopes = _compute_height_differences(face, steps) / sampling_interval
    rising_slopes, falling_slopes = slopes[slopes > 0], -slopes[slopes < 0]
    return JointRoughness(
        sampling_interval,
        float(np.sqrt(np.mean(slopes**2))),
        float(rising_slopes.mean()) if rising_slopes.size else 0.0,
        float(falling_slopes.mean()) if falling_slopes.size else 0.0,
    )


def _compute_height_differences(face: Any, steps: Any) -> Floats:
    """Return the height differences (µm) between all pairs of measured points at a given offset (in points)."""
    starts, ends = [], []
    for step, points in zip(steps.tolist(), face.heights.shape, strict=True):
        num_pairs = points - abs(step)
        starts.append(slice(max(0, -step), max(0, -step) + num_pairs))
        ends.append(slice(max(0, step), max(0, step) + num_pairs))
    differences = face.heights[tuple(ends)] - face.heights[tuple(starts)]
    if face.missing is None:
        return np.asarray(differences)
    return np.asarray(differences[~(face.missing[tuple(ends)] | face.missing[tuple(starts)])])
