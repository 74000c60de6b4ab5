"""The onset of sliding: of asperities, whose contacts slip from their edges inwards in parallel, and of a half-space.

A traction that falls from the middle of an ellipse outwards is a sum of those of flat punches on smaller ellipses with
the same ratio of axes, t from 0 to 1, under each of which the displacement is even. So a contact behaves as springs
along t that stick while they are below their own strength Q(t): exactly Cattaneo's and Mindlin's solution, for any
bound mu0 p + tau0 (on circles Jäger 1998; Popov & Heß, Method of Dimensionality Reduction, 2015, chapter 5). A
half-space has tractions up to a bound that differs from point to point.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats, number
from stiction.mechanics.half_space_problem import threads
from stiction.mechanics.law import HertzCylinder, law_of
from stiction.mechanics.model import ContactModel
from stiction.mechanics.onset import Slip, poisson_ratios

if TYPE_CHECKING:
    from stiction.mechanics.contact import Contacts
    from stiction.mechanics.half_space_problem import Pressed

NODES = 24  # of Gauss and Legendre, over a smooth function of an angle


def compliance_ratio(poisson: float | Sequence[float], compliance_share: float, across: Floats | float = 0.5) -> Floats:
    """E*/E*_t: how much more two bodies give way to tractions along the motion than to pressures.

    1 - ν sin² over 1 - ν (Cerruti; Johnson, Contact Mechanics, 1985, eq. 3.75), of the angle between the motion and the
    way to a force. `across` is the mean of sin²: 1/2 on circles (Mindlin), 1 where forces lie on lines across it.
    """
    upper, lower = poisson_ratios(poisson)
    ratios = [(1 - one * np.asarray(across)) / (1 - one) for one in (upper, lower)]
    return np.asarray((1 - compliance_share) * ratios[0] + compliance_share * ratios[1])


def punch_stiffness(axes: Floats, effective_modulus: float) -> Floats:
    """π E* a/K(1 - b²/a²), mN/µm, of flat elliptic punches with (c, 2) semi-axes (Johnson 1985, section 3.8)."""
    from scipy.special import ellipkm1

    return np.asarray(np.pi * effective_modulus * axes[:, 0] / ellipkm1((axes[:, 1] / axes[:, 0]) ** 2))


def load_across(axes: Floats, angle: Floats) -> Floats:
    """The `across` of `compliance_ratio` of ellipses, at angles (rad) between the motion and the larger axis."""
    from scipy.special import ellipkm1, elliprd

    square = (axes[:, 1] / axes[:, 0]) ** 2
    # The mean of cos² from the larger axis, (K - E)/(m K) with m = 1 - b²/a².
    along = elliprd(0, square, 1) / 3 / ellipkm1(square)
    return np.asarray(along * np.sin(angle) ** 2 + (1 - along) * np.cos(angle) ** 2)


class Asperities:
    """Contacts that are pushed together: `Held` of `onset`. Angles are those (degrees) of the motion.

    frictional, adhesive : (c,) ndarray, mN
        mu0 times normal load, tau0 times area.
    spring : (c,) ndarray, mN/µm
        Tangential stiffness while all sticks.
    """

    def __init__(
        self, contacts: Contacts, model: ContactModel, *, mu0: float, tau0: float, angle: float,
        poisson: float | Sequence[float], compliance_share: float,
    ) -> None:  # fmt: skip
        if isinstance(law_of(model.law), HertzCylinder):
            raise ValueError(
                "law must not be HertzCylinder for an onset, because a line load moves far points without limit: take "
                "HertzSphere, or half_space with boundary='periodic'"
            )
        if len(contacts) == 0:
            raise ValueError("index must be that of an approach at which something touches: here there is no contact")
        load, area = contacts.force * contacts.normal[:, 2], contacts.area
        turned = np.radians(angle) - np.arctan2(contacts.along[:, 1], contacts.along[:, 0])
        ratio = compliance_ratio(poisson, compliance_share, load_across(contacts.axes, turned))
        self.spring = punch_stiffness(contacts.axes, float(model.effective_modulus)) / ratio
        self.load, self.area = load, area
        self.frictional, self.adhesive = mu0 * load, tau0 * area
        self.points: NDArray[Any] = np.arange(load.size)
        self.size = load.size
        self.bound = (self.frictional + self.adhesive) / area
        self.normal_load = float(load.sum())
        self.sliding_load = float(mu0 * load.sum() + tau0 * area.sum())
        self.stiffness = float(self.spring.sum())
        # Displacement at which each slides as a whole.
        self.farthest = 2 * self._strength(np.ones((load.size, 1)))[:, 0] / self.spring

    def at(self, load: float, near: Slip | None = None) -> Slip:
        """Where all contacts together hold a load."""
        from scipy.optimize import brentq

        del near  # it is as quick without
        end = float(self.farthest.max())
        way = end
        if load < self.sliding_load:
            # The curve is concave, so that the line at rest is to the left.
            start = min(load / self.stiffness, end)
            way = brentq(lambda one: self._held(self._depth(one)).sum() - load, 0.5 * start, end, xtol=1e-300)
        depth = self._depth(way)
        held = self._held(depth)
        slides = depth >= 1
        return Slip(
            load=load, displacement=way, slipped_area=float(self.area @ depth**2 / self.area.sum()),
            slipped_load=float(self.load @ depth**3 / self.load.sum()),
            traction=np.where(slides, self.bound, held / self.area),
        )  # fmt: skip

    def dissipated(self, slip: Slip) -> float:
        """Σ Q (δ - 2 Q/k) over the springs that slip."""
        depth = self._depth(slip.displacement)
        nodes, weights = np.polynomial.legendre.leggauss(NODES)
        # t = cos φ, from the edge, where φ = 0, to where it sticks.
        end = np.arcsin(depth)[:, np.newaxis]
        sine = np.sin(0.5 * end * (nodes + 1))
        strength = self._strength(sine)
        slipped = slip.displacement - 2 * strength / self.spring[:, np.newaxis]
        return float(((strength * slipped * sine) @ weights * end[:, 0]).sum())

    def _strength(self, sine: Floats) -> Floats:
        """Q at t = sqrt(1 - sine²), (c, n): 3/4 mu0 F (1 - t²) of Hertz's pressure, 2/π tau0 A (1 - t²)^(1/2)."""
        return np.asarray(
            0.75 * self.frictional[:, np.newaxis] * sine**2 + 2 / np.pi * self.adhesive[:, np.newaxis] * sine
        )

    def _depth(self, way: float) -> Floats:
        """How deep each has slipped: 0 not at all, 1 as a whole."""
        square, linear = 1.5 * self.frictional / self.spring, 4 / np.pi * self.adhesive / self.spring
        depth = 2 * way / (linear + np.sqrt(linear**2 + 4 * square * way))
        return np.asarray(np.where(way >= self.farthest, 1.0, np.minimum(depth, 1.0)))

    def _held(self, depth: Floats) -> Floats:
        """mN, of each."""
        stuck = 1 - depth**2
        whole = depth >= 1
        by_friction = np.where(whole, 1.0, -np.expm1(1.5 * np.log1p(-(np.where(whole, 0.0, depth) ** 2))))
        by_adhesion = 2 / np.pi * (np.arcsin(depth) + depth * np.sqrt(stuck))
        return np.asarray(self.frictional * by_friction + self.adhesive * by_adhesion)


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
        self.everywhere = everywhere
        compliance = self.grids.linear_response(everywhere > 0, threads=threads())[1] * self.ratio
        self.stiffness = (self.cell / compliance if compliance > 0 else np.inf) if self.moves else np.nan

    @cached_property
    def _solver(self) -> _core.HalfSpaceSolver:
        """Solver of tractions, which cannot be copied and is made again in a copy."""
        return _core.HalfSpaceSolver(
            np.zeros(self.shape), self.grids, bound=self.everywhere, tolerance=self.tolerance, threads=threads()
        )

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_solver"}

    def at(self, load: float, near: Slip | None = None) -> Slip:
        """The least energy of tractions that hold a load."""
        if load >= self.sliding_load:
            return self._slip(self.sliding_load, self.bound, float(self._moved(self.bound).max()))
        part = load / self.sliding_load
        start = None if near is None else self._over_grid(near.traction)
        found = self._solver.at(part * self.mean_bound, near=start, threads=threads())
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
