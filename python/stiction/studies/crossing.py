"""Where curves of load first reach given loads, and what other curves are there.

Nothing is extrapolated: between samples curves are linear, and a load is reached where its curve first crosses it
upwards.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats


@dataclass(frozen=True)
class Crossing:
    """Where curves (..., k) first reach loads (l,): between steps index - 1 and index, at a fraction of the step."""

    index: NDArray[np.intp]  # (..., l)
    fraction: Floats  # (..., l)
    reached: NDArray[np.bool_]  # (..., l)
    below: NDArray[np.bool_]  # (..., l): the load is less than that of the first step
    scale: tuple[Floats, Floats] | None = None  # curves and loads, where ratios to them are what is straight

    @classmethod
    def of(cls, curve: Floats, loads: Floats, *, ratio: bool = False) -> Crossing:
        """First upward crossings, by straight lines; by `ratio` of value/load over the logarithm of the load."""
        if ratio:
            with np.errstate(divide="ignore", invalid="ignore"):
                straight = cls.of(np.log(curve), np.log(loads))
            return cls(straight.index, straight.fraction, straight.reached, straight.below, (curve, loads))
        at_least = curve[..., np.newaxis] >= loads  # (..., k, l)
        first = curve[..., :1, np.newaxis] == loads
        reaches = np.concatenate([first, ~at_least[..., :-1, :] & at_least[..., 1:, :]], axis=-2)
        reached: NDArray[np.bool_] = np.any(reaches, axis=-2)
        index = reaches.argmax(axis=-2)
        before = np.take_along_axis(curve, np.maximum(index - 1, 0), axis=-1)
        step = np.take_along_axis(curve, index, axis=-1) - before
        fraction = np.divide(loads - before, step, out=np.ones_like(before), where=step > 0)
        return cls(index, fraction, reached, ~reached & at_least[..., 0, :])

    def without_gaps(self, curve: Floats, loads: Floats) -> Crossing:
        """Without what is reached right behind a step that curves (..., k) lack (NaN), but for loads of steps."""
        before, there = (
            np.take_along_axis(curve, index, axis=-1) for index in (np.maximum(self.index - 1, 0), self.index)
        )
        return replace(self, reached=self.reached & (np.isfinite(before) | (there == loads)))

    def at(self, values: Floats, *, sums: bool = True) -> Floats:
        """(..., more, l): values (..., more, k) where the loads are reached, NaN where they are not.

        Sums grow with the load, so of these the ratio to it is what is nearly straight; of fractions and lengths it is
        the values themselves.
        """
        own = self.index.ndim - 1
        more = (*self.index.shape[:-1], *(1,) * (values.ndim - 1 - own), -1)
        index, fraction, reached = (each.reshape(more) for each in (self.index, self.fraction, self.reached))
        if sums and self.scale is not None:
            with np.errstate(divide="ignore", invalid="ignore"):
                values = values / self.scale[0].reshape(more)
        shape = np.broadcast_shapes(values.shape[:-1], index.shape[:-1])
        index = np.broadcast_to(index, (*shape, index.shape[-1]))
        values = np.broadcast_to(values, (*shape, values.shape[-1]))
        after = np.take_along_axis(values, index, axis=-1)
        before = np.take_along_axis(values, np.maximum(index - 1, 0), axis=-1)
        # At a step itself the step before it does not matter, even where it is missing.
        there = np.where(fraction == 1, after, before + fraction * (after - before))
        if sums and self.scale is not None:
            there = there * self.scale[1]
        return np.where(reached, there, np.nan)

    def slope(self, values: Floats, over: Floats) -> Floats:
        """(..., l): steps of values over those of others, (..., k) each, between which the loads are reached."""
        index = np.maximum(self.index, 1)
        rise, run = (
            np.take_along_axis(each, index, axis=-1) - np.take_along_axis(each, index - 1, axis=-1)
            for each in (values, over)
        )
        return np.asarray(rise / run)
