"""Where curves of load against approach first reach given loads, and what other curves are there.

Nothing is extrapolated: between samples curves are linear, and a load is reached where its curve first crosses it
upwards.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats


@dataclass(frozen=True)
class Crossing:
    """Where curves (c, k) first reach loads (l,): between approaches index - 1 and index, at a fraction of the step."""

    index: NDArray[np.intp]  # (c, l)
    fraction: Floats  # (c, l)
    reached: NDArray[np.bool_]  # (c, l)
    below: NDArray[np.bool_]  # (c, l): the load is less than that of the first approach

    @classmethod
    def of(cls, normal: Floats, loads: Floats) -> Crossing:
        """First upward crossings of loads (l,) by curves (c, k)."""
        at_least = normal[:, :, np.newaxis] >= loads  # (c, k, l)
        reaches = np.concatenate([normal[:, :1, np.newaxis] == loads, ~at_least[:, :-1] & at_least[:, 1:]], axis=1)
        reached: NDArray[np.bool_] = np.any(reaches, axis=1)
        index = reaches.argmax(axis=1)
        below = ~reached & at_least[:, 0]
        before = np.take_along_axis(normal, np.maximum(index - 1, 0), axis=1)
        step = np.take_along_axis(normal, index, axis=1) - before
        fraction = np.divide(loads - before, step, out=np.ones_like(before), where=step > 0)
        return cls(index, fraction, reached, below)

    def at(self, values: Floats) -> Floats:
        """(c, l): values (c, k), or of one crossing (1, l) those of many curves, where the loads are reached."""
        index = np.broadcast_to(self.index, (values.shape[0], self.index.shape[1]))
        after = np.take_along_axis(values, index, axis=1)
        before = np.take_along_axis(values, np.maximum(index - 1, 0), axis=1)
        return before + self.fraction * (after - before)
