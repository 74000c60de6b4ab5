"""The onset of sliding of an elastic half-space: tractions up to a bound that differs from point to point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats, number
from stiction.mechanics.half_space_problem import threads
from stiction.mechanics.mindlin import compliance_ratio
from stiction.mechanics.onset import Slip

if TYPE_CHECKING:
    from stiction.mechanics.half_space_problem import Pressed


class HalfSpace:
    """A half-space that is pushed: `Held` of `onset`, of the contact at one load."""

    def __init__(
        self, pressed: Pressed, *, mu0: float, tau0: float, poisson: float | Sequence[float], tolerance: float
    ) -> None:
        problem = pressed.problem
        self.grids, self.cell, self.moves = problem.grids, problem.cell, problem.has_approach
        self.shape, self.size = problem.gap.shape, problem.gap.size
        # On a line all load lies across the motion, on lines of its own.
        across = 1.0 if len(self.shape) == 1 else 0.5
        self.ratio = float(compliance_ratio(poisson, problem.compliance_share, across))
        self.points: NDArray[Any] = pressed.points
        self.pressure = pressed.values
        stretch = np.sqrt(1 + sum(along[self.points] ** 2 for along in problem.slope))
        self.area = pressed.share * self.cell * stretch
        self.bound = mu0 * self.pressure + tau0 * self.area / self.cell
        self.normal_load = float(self.pressure.sum() * self.cell)
        self.sliding_load = float(mu0 * self.normal_load + tau0 * self.area.sum())
        everywhere = self._over_grid(self.bound)
        self.mean_bound = float(everywhere.mean())
        self.tolerance = number("tolerance", tolerance, above=0, below=1)
        self.solver = _core.HalfSpaceSolver(
            np.zeros(self.shape), problem.grids, bound=everywhere, tolerance=self.tolerance, threads=threads()
        )
        compliance = self.grids.linear_answer(everywhere > 0, threads=threads())[1] * self.ratio
        self.stiffness = (self.cell / compliance if compliance > 0 else np.inf) if self.moves else np.nan

    def at(self, load: float, near: Slip | None = None) -> Slip:
        """The least energy of tractions that hold a load."""
        if load >= self.sliding_load:
            return self._slip(self.sliding_load, self.bound, float(self._moved(self.bound).max()))
        part = load / self.sliding_load
        start = None if near is None else self._over_grid(near.traction)
        found = self.solver.at(part * self.mean_bound, near=start, threads=threads())
        if not found.error <= self.tolerance:
            raise RuntimeError(
                f"no solution at {load:g} mN, {part:g} of the sliding load: error {found.error:.2g} after "
                f"{found.iterations} iterations, above the tolerance {self.tolerance:g}"
            )
        return self._slip(load, found.pressure[self.points], found.approach * self.ratio)

    def dissipated(self, slip: Slip) -> float:
        """The sum of bound times slip, whatever far points do."""
        moved = self._moved(slip.traction)
        slips = slip.traction >= self.bound
        sticks = (slip.traction > 0) & ~slips
        held = moved[sticks].mean() if sticks.any() else moved[slips].max()
        return float((self.bound[slips] * (held - moved[slips])).sum() * self.cell)

    def _slip(self, load: float, traction: Floats, displacement: float) -> Slip:
        slips = traction >= self.bound
        return Slip(
            load=load, displacement=max(displacement, 0.0) if self.moves else np.nan,
            slipped_area=float(self.area[slips].sum() / self.area.sum()),
            slipped_load=float(self.pressure[slips].sum() / self.pressure.sum()), traction=traction,
        )  # fmt: skip

    def _moved(self, traction: Floats) -> Floats:
        """µm, of the points in contact."""
        moved = self.grids.displacement(self._over_grid(traction), threads=threads()) * self.ratio
        return np.asarray(moved.ravel()[self.points])

    def _over_grid(self, traction: Floats) -> Floats:
        grid = np.zeros(self.size)
        grid[self.points] = traction
        return grid.reshape(self.shape)
