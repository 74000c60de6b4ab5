"""Pressure between a rigid gap and an elastic half-space: the solver, from coarse grids to fine ones.

Polonsky & Keer, Wear 231 (1999) 206, for projected conjugate gradients; here preconditioned by E*|k|/2 on the points
that are free to move, and begun from the solution on every second point.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats
from stiction.mechanics.elastic_kernel import MOST_KEPT, Grids, Kernel, Room

COARSE_TOLERANCE = 3e-3
"""Of the solutions on coarser grids, whose own distance from the finest is larger."""

NEAR = 1.3
"""Ratio of loads up to which an area's pressure at one is a good start at the other."""

SPARSE = 0.3
"""Share of the points of an area under pressure, up to which a stencil stands for the inverse of the kernel."""

MOST_ITERATIONS = 2000
"""On the finest grid; a hundred are many."""

MOST_COARSE_ITERATIONS = 100
"""A coarse solution is only a start."""

COMPLIANCE_TOLERANCE = 1e-3
"""Of displacements that should be equal, relative to the compliance, which is then right to 1e-7."""

MOST_AMONG = 1024
"""Points up to which their own matrix is solved for it, which a few transforms take longer than."""

MOST_LOADS = 60
"""That are tried for one approach; six are many."""

FARTHEST_LOAD = 30.0
"""Ratio of two loads that are tried one after the other."""

EVEN = 1e-9
"""Of the displacement of a cell, below which deviations of displacements are those of an even load: round-off."""

LEAST_PART = 1e-3
"""Of the way between two loads, at which another one is tried."""

MOST_CERTIFICATES = 20
"""New evaluations in double precision before a solution is given up: round-off is the reason."""


@dataclass(frozen=True)
class Solution:
    """A pressure (GPa), the approach (µm) and what is known of them."""

    pressure: Floats
    approach: float
    error: float
    iterations: int


class Solver:
    """The pressures of one gap at one load after the other: the least energy with a given sum, 0 <= p <= bound.

    gap : ndarray, µm
        On the grid; 0 everywhere where it is not a contact that is sought but a traction.
    grids : Grids
        Of the gap's shape.
    bound : float, ndarray of the gap's shape or None, GPa
        The most that the pressure can be, everywhere or at each point; where it is 0 nothing is borne and nothing is
        asked of the gap. None: there is none.
    tolerance : float
        Of `Solution.error`.
    """

    def __init__(
        self,
        gap: Floats,
        grids: Grids,
        *,
        bound: float | Floats | None = None,
        tolerance: float,
        progress: Callable[[int, float], object] | None = None,
    ) -> None:
        self.grids, self.tolerance, self.progress = grids, tolerance, progress
        self.bound = np.ravel(np.inf if bound is None else bound).astype(np.float64)
        self.gaps = [gap]
        # Bounds that differ from point to point cannot be told from those of a coarser grid.
        for shape, _ in grids.levels[1:] if self.bound.size == 1 else []:
            self.gaps.append(_resampled(self.gaps[-1], shape, periodic=grids.periodic))
        # The unit of the error: heights, and displacements under a load where those say nothing or less.
        self.heights_scale = float(gap.std())
        self.pressure_scale = self._displacement_of_load()

    def _displacement_of_load(self) -> float:
        """µm/GPa, root-mean-square deviation under an even pressure, or one in proportion to bounds of points."""
        _, spacing = self.grids.levels[0]
        of_a_cell = max(spacing) / self.grids.effective_modulus
        if self.bound.size > 1:
            load = (self.bound / self.bound.mean()).reshape(self.gaps[0].shape)
            deviation = float(np.std(self.grids.kernel().displacement(load)))
            if not self.grids.periodic:  # bounds under which all points of a flat move alike, to a tolerance
                return max(deviation, self.grids.even_deviation)
            return deviation if deviation > EVEN * of_a_cell else of_a_cell
        if not self.grids.periodic:
            return self.grids.even_deviation
        return of_a_cell if self.heights_scale == 0 else 0.0

    def scale(self, mean_pressure: float) -> float:
        """µm, in which errors are measured."""
        return max(self.heights_scale, self.pressure_scale * mean_pressure)

    def at(self, mean_pressure: float, *, near: Solution | None = None) -> Solution:
        """The pressure with a given mean over the grid; `near` may be a solution at another load."""
        if near is not None and self._is_near(near, mean_pressure):
            solution = self._finest(near.pressure, mean_pressure)
            if solution.error <= self.tolerance:
                return solution
        if self.bound.size > 1:
            return self._finest(self.bound.reshape(self.gaps[0].shape), mean_pressure)
        start = np.full(self.gaps[-1].shape, mean_pressure)
        coarse = max(COARSE_TOLERANCE, self.tolerance) * self.scale(mean_pressure)
        for level in range(len(self.gaps) - 1, 0, -1):
            start = self._solve(level, start, mean_pressure, coarse, MOST_COARSE_ITERATIONS).pressure
        return self._finest(start, mean_pressure)

    def at_approach(self, approach: float, *, near: Solution | None = None) -> Solution:
        """The pressure at an approach (µm), which grows with the load: by secants (Illinois) over the load's logarithm.

        What they bring to 0 is the logarithm of approaches; on periodic bodies, where all points touch at the mean gap,
        less that of what is left to it.
        """
        full = float(self.gaps[0].mean()) if self.grids.periodic else math.inf
        # Of two bodies as far apart as the grid is long, less than which any load is.
        longest = max(step * n for n, step in zip(*self.grids.levels[0], strict=True))
        pressure = 0.1 * self.grids.effective_modulus * approach / longest
        if near is not None:
            pressure = float(near.pressure.mean())
        ends: dict[bool, tuple[float, float]] = {}
        was_above: bool | None = None
        for _ in range(MOST_LOADS):
            solution = near = self.at(pressure, near=near)
            miss = abs(solution.approach - approach) / self.scale(pressure)
            if miss <= self.tolerance or not solution.error <= self.tolerance:
                break
            excess = _excess(solution.approach, approach, full)
            above = excess > 0
            if above is was_above and (not above) in ends:  # the other end has stayed twice
                ends[not above] = ends[not above][0], 0.5 * ends[not above][1]
            ends[above], was_above = (math.log(pressure), excess), above
            if len(ends) == 1:
                pressure *= math.exp(max(-math.log(FARTHEST_LOAD), min(math.log(FARTHEST_LOAD), -2 * excess)))
                continue
            (left, below), (right, over) = ends[False], ends[True]
            part = below / (below - over) if math.isfinite(over) else 0.5
            pressure = math.exp(left + min(max(part, LEAST_PART), 1 - LEAST_PART) * (right - left))
        return Solution(solution.pressure, solution.approach, max(solution.error, miss), solution.iterations)

    def _is_near(self, near: Solution, mean_pressure: float) -> bool:
        """Whether a solution at another load is the better start; on lines that of coarse grids is."""
        ratio = mean_pressure / near.pressure.mean()
        return self.bound.size > 1 or (self.gaps[0].ndim == 2 and bool(1 / NEAR <= ratio <= NEAR))

    def _finest(self, start: Floats, mean_pressure: float) -> Solution:
        scale = self.scale(mean_pressure)
        solution = self._solve(0, start, mean_pressure, self.tolerance * scale, MOST_ITERATIONS)
        error = max(solution.error / scale, abs(float(solution.pressure.mean()) / mean_pressure - 1.0))
        return Solution(solution.pressure, solution.approach, error, solution.iterations)

    def _solve(self, level: int, start: Floats, mean: float, tolerance: float, most: int) -> Solution:
        descent = _Descent(self.grids.kernel(level), self.gaps[level], self.bound, start, mean)
        search = descent.search
        exact, certificates, iterations = True, 0, 0
        while True:
            error = search.balance()
            if error <= tolerance or not np.isfinite(error):
                certificates += 1
                if exact or level > 0 or certificates > MOST_CERTIFICATES:
                    break
                search.settle()
                descent.renew()
                exact = True
                continue
            if iterations == most:
                break
            descent.iterate()
            exact = False
            iterations += 1
            if level == 0 and self.progress is not None:
                self.progress(iterations, error / (tolerance / self.tolerance))
        # A copy, because what the search shows keeps all of it.
        return Solution(search.pressure.reshape(descent.gap.shape).copy(), search.approach, error, iterations)


class _Descent:
    """A search and the kernel that it asks, begun from pressures on some grid that are brought to a mean (GPa)."""

    def __init__(self, kernel: Kernel, gap: Floats, bound: Floats, start: Floats, mean: float) -> None:
        self.kernel, self.gap, self.room = kernel, gap, Room()
        pressure = _resampled(start, gap.shape, periodic=kernel.periodic)
        pressure = np.multiply(pressure, mean / pressure.mean(), out=None if pressure is start else pressure)
        self.search = _core.PressureSearch(pressure.ravel(), total=mean * gap.size, bound=bound, line=gap.ndim == 1)
        del pressure  # of large grids memory is short from here on
        # On areas with little contact a stencil stands for the inverse of the kernel, and takes no transform.
        sparse = np.count_nonzero(self.search.pressure) < SPARSE * gap.size
        self.near = kernel.stencil if sparse else None
        self.renew()

    def renew(self) -> None:
        """Computes the potential in double precision."""
        potential = self.kernel.displacement(self.search.pressure.reshape(self.gap.shape), self.room)
        potential += self.gap
        self.search.restart(potential.ravel())
        self.response = np.empty(0, np.float32)

    def iterate(self) -> None:
        """One step, after a balance."""
        search, shape = self.search, self.gap.shape
        residual = search.residual()
        if self.near is not None and not search.plain:
            residual = search.sharpened(self.near, shape[-1])
        elif not search.plain:
            residual = self.kernel.preconditioned(residual.reshape(shape)).ravel()
        self.response = self.kernel.response(search.step(residual, self.response).reshape(shape), self.room).ravel()
        if not search.advance(self.response):
            self.response = np.empty(0, np.float32)


def _excess(approach: float, wanted: float, full: float) -> float:
    """The logarithm of an approach over the one wanted, less that of what is left to the one at which all touch."""
    if approach >= full:
        return math.inf
    left = 0.0 if math.isinf(full) else math.log((full - approach) / (full - wanted))
    return math.log(approach / wanted) - left


def linear_compliance(kernel: Kernel, free: NDArray[np.bool_]) -> float:
    """dδ/dp (µm/GPa) for the sum of pressures over free points under which all of them move alike; 0 at full contact.

    Pressures of sum 1 on these points alone, without a gap: their energy, whose error is the square of theirs. They are
    above 0 everywhere, as charges are on a conductor. An even start is as good as any that the pressures at hand give:
    at the edges, where those vanish, these are highest.
    """
    if kernel.periodic and free.all():
        return 0.0
    if np.count_nonzero(free) <= MOST_AMONG and free.size <= MOST_KEPT:
        even = _under_one_displacement(kernel.among(np.argwhere(free)))
        if (even >= 0).all():
            return 1.0 / float(even.sum())
    bound = np.where(free, np.inf, 0.0).ravel()
    descent = _Descent(kernel, np.zeros(free.shape), bound, free.astype(np.float64), 1.0 / free.size)
    for _ in range(MOST_ITERATIONS):
        if descent.search.balance() <= COMPLIANCE_TOLERANCE * abs(descent.search.approach):
            break
        descent.iterate()
    return descent.search.work()


def _under_one_displacement(influence: Floats) -> Floats:
    """Pressures of some points under which each of them moves by 1, to `COMPLIANCE_TOLERANCE`.

    Without BLAS, whose threads wait for each other where many pairs are solved at once.
    """
    import scipy.sparse.linalg as sparse

    matrix = sparse.LinearOperator(influence.shape, lambda x: np.einsum("ij,j->i", influence, x), dtype=np.float64)
    ones = np.ones(len(influence))
    pressure: Floats = sparse.cg(matrix, ones, rtol=COMPLIANCE_TOLERANCE**1.5, atol=0.0)[0]
    return pressure


def _resampled(values: Floats, shape: tuple[int, ...], *, periodic: bool) -> Floats:
    """Values between points along straight lines, on a grid of as many points over the same length.

    On a free grid of n points the next one has every second, so that its spacing is doubled.
    """
    for axis, (have, want) in enumerate(zip(values.shape, shape, strict=True)):
        if have == want:
            continue
        before: list[Any] = [slice(None)] * axis
        if have == 2 * want or (not periodic and have > want):
            values = values[(*before, slice(None, None, 2))]
        elif want == 2 * have or not periodic:
            values = _doubled(values, axis, want, periodic=periodic)
        else:
            position = np.arange(want) * (have / want)
            left = np.minimum(position.astype(np.int64), have - 1)
            weight = (position - left).reshape(-1, *[1] * (values.ndim - axis - 1))
            values = np.take(values, left, axis) * (1 - weight) + np.take(values, (left + 1) % have, axis) * weight
    return np.ascontiguousarray(values)


def _doubled(values: Floats, axis: int, want: int, *, periodic: bool) -> Floats:
    """Values and between each two of them their mean, as many as are wanted; after the last one that, or the first."""
    have = values.shape[axis]
    result = np.empty((*values.shape[:axis], want, *values.shape[axis + 1 :]))
    to, of = np.moveaxis(result, axis, 0), np.moveaxis(values, axis, 0)
    to[::2] = of[: (want + 1) // 2]
    np.add(of[:-1], of[1:], out=to[1 : 2 * have - 2 : 2])
    to[1 : 2 * have - 2 : 2] *= 0.5
    if want == 2 * have:
        to[-1] = 0.5 * (of[-1] + of[0]) if periodic else of[-1]
    return result
