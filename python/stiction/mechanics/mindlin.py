"""Partial slip, before the onset of sliding, of half-spaces or of asperity contacts with a common displacement.

A traction that decreases from the centre of an ellipse outwards is a sum of flat-punch tractions on smaller ellipses
with the same aspect ratio and relative size t from 0 to 1. Each of these tractions causes a uniform displacement. A
contact therefore behaves like springs along t that stick below their individual strengths Q(t). This is the exact
solution of Cattaneo and Mindlin for any bound mu0 p + tau0 of the traction (for circles Jäger 1998; Popov & Heß, Method
of Dimensionality Reduction, 2015, chapter 5). On a half-space, the bound of the traction differs from point to point.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats, validate_number
from stiction._errors import NoSolutionError
from stiction.mechanics.friction import FrictionLaw
from stiction.mechanics.half_space_problem import solver_thread_count
from stiction.mechanics.law import HertzCylinder, parse_contact_law
from stiction.mechanics.model import ContactModel
from stiction.mechanics.onset import SlipState, parse_poisson_ratios

if TYPE_CHECKING:
    from stiction.mechanics.contact import Contacts
    from stiction.mechanics.half_space_problem import ContactSolution

TRACTION_UNIFORMITY_TOLERANCE = 1e-12
NUM_QUADRATURE_NODES = 24


def compliance_ratio(
    poisson: float | Sequence[float], compliance_share: float, transverse_fraction: Floats | float = 0.5
) -> Floats:
    """Return E*/E*_t, the ratio of tangential to normal compliance of two bodies.

    The ratio is the mean of (1 - ν sin²)/(1 - ν) over the angle between the motion and the line to a force (Cerruti;
    Johnson, Contact Mechanics, 1985, eq. 3.75). `transverse_fraction` is the mean of sin²: 1/2 for circles
    (Mindlin), 1 for line loads across the motion.
    """
    upper, lower = parse_poisson_ratios(poisson)
    ratios = [(1 - value * np.asarray(transverse_fraction)) / (1 - value) for value in (upper, lower)]
    return np.asarray((1 - compliance_share) * ratios[0] + compliance_share * ratios[1])


def punch_stiffness(axes: Floats, effective_modulus: float) -> Floats:
    """Return the normal stiffness (mN/µm) of elliptic punches with semi-axes a >= b: π E* a/K(1 - b²/a²).

    The formula is in Johnson (1985), section 3.8.
    """
    from scipy.special import ellipkm1

    return np.asarray(np.pi * effective_modulus * axes[:, 0] / ellipkm1((axes[:, 1] / axes[:, 0]) ** 2))


def transverse_load_fraction(axes: Floats, angle: Floats) -> Floats:
    """Return the load-weighted mean of sin² φ over each contact, where φ is measured from the direction of motion.

    φ is the angle between the motion and the line from the contact's centre to a loaded point.

    The mean is the `transverse_fraction` of `compliance_ratio`. `axes` are the semi-axes, and `angle` (rad) is the
    angle between the motion and the larger semi-axis.
    """
    from scipy.special import ellipkm1, elliprd

    squared_axis_ratio = (axes[:, 1] / axes[:, 0]) ** 2
    # Mean cos² of the angle between major axis and line to a loaded point: (K(m) - E(m))/(m K(m)), m = 1 - b²/a².
    longitudinal_fraction = elliprd(0, squared_axis_ratio, 1) / 3 / ellipkm1(squared_axis_ratio)
    return np.asarray(longitudinal_fraction * np.sin(angle) ** 2 + (1 - longitudinal_fraction) * np.cos(angle) ** 2)


class AsperityTangentialProblem:
    """Asperity contacts with a common displacement under a tangential load along `angle` (degrees).

    frictional, adhesive : (c,) ndarray, mN
            mu0 times normal load, and tau0 times area.
    spring_stiffness : (c,) ndarray, mN/µm
            Tangential stiffness of each contact while it sticks completely.
    """

    def __init__(
        self, contacts: Contacts, model: ContactModel, *, mu0: float, tau0: float, angle: float,
        poisson: float | Sequence[float], compliance_share: float,
    ) -> None:  # fmt: skip
        if isinstance(parse_contact_law(model.law), HertzCylinder):
            raise ValueError(
                "law must not be HertzCylinder for an onset, because the displacement under a line load is "
                "unbounded; use HertzSphere, or half_space with boundary='periodic'"
            )
        if len(contacts) == 0:
            raise ValueError("`index` must select an approach at which the bodies touch")
        load, area = contacts.force * contacts.normal[:, 2], contacts.area
        relative_angle = np.radians(angle) - np.arctan2(contacts.along[:, 1], contacts.along[:, 0])
        ratio = compliance_ratio(poisson, compliance_share, transverse_load_fraction(contacts.axes, relative_angle))
        self.spring_stiffness = punch_stiffness(contacts.axes, float(model.effective_modulus)) / ratio
        self.load, self.area = load, area
        law = FrictionLaw(mu0, tau0)
        self.frictional, self.adhesive = law.contributions(load, area)
        self.points: NDArray[Any] = np.arange(load.size)
        self.size = load.size
        self.bound = (self.frictional + self.adhesive) / area
        self.normal_load = float(load.sum())
        self.sliding_load = float(law.force(load.sum(), area.sum()))
        self.stiffness = float(self.spring_stiffness.sum())
        self.sliding_displacement = 2 * self._spring_strengths(np.ones((load.size, 1)))[:, 0] / self.spring_stiffness

    def at(self, load: float, near: SlipState | None = None) -> SlipState:
        """Return the slip state in which all contacts together support a tangential load (mN)."""
        from scipy.optimize import brentq

        # The initial guess `near` is not used, because the displacement is computed from a formula or by bracketing.
        del near
        max_displacement = float(self.sliding_displacement.max())
        displacement = max_displacement
        if load < self.sliding_load:
            # The tangential load is concave in the displacement, so displacement >= load / (initial stiffness).
            min_displacement = min(load / self.stiffness, max_displacement)
            displacement = brentq(
                lambda value: self._tangential_loads(self._slip_depth(value)).sum() - load,
                0.5 * min_displacement,
                max_displacement,
                xtol=1e-300,
            )
        depth = self._slip_depth(displacement)
        loads = self._tangential_loads(depth)
        is_sliding = depth >= 1
        return SlipState(
            load=load, displacement=displacement, slipped_area=float(self.area @ depth**2 / self.area.sum()),
            slipped_load=float(self.load @ depth**3 / self.load.sum()),
            traction=np.where(is_sliding, self.bound, loads / self.area),
        )  # fmt: skip

    def dissipated_energy(self, slip: SlipState) -> float:
        """Return the energy (mN µm) that slip dissipates in the first loading, from rest to a given slip state.

        The energy is Σ Q (δ - 2 Q/k) over the springs that slip at the displacement δ. Q is the strength of a spring,
        and 2 Q/k its displacement when it begins to slip, with the stiffness k of the contact.
        """
        depth = self._slip_depth(slip.displacement)
        nodes, weights = np.polynomial.legendre.leggauss(NUM_QUADRATURE_NODES)
        # The energy is integrated over φ from the contact's edge (φ = 0) to the end of the slip zone (sin φ = depth).
        end_angle = np.arcsin(depth)[:, np.newaxis]
        sine = np.sin(0.5 * end_angle * (nodes + 1))
        strength = self._spring_strengths(sine)
        slip_distance = slip.displacement - 2 * strength / self.spring_stiffness[:, np.newaxis]
        return float(((strength * slip_distance * sine) @ weights * end_angle[:, 0]).sum())

    def _spring_strengths(self, sine: Floats) -> Floats:
        """Return the forces 3/4 mu0 F s² + 2/π tau0 A s (mN) at which springs of a contact slip, where s is `sine`."""
        return np.asarray(
            0.75 * self.frictional[:, np.newaxis] * sine**2 + 2 / np.pi * self.adhesive[:, np.newaxis] * sine
        )

    def _slip_depth(self, displacement: float) -> Floats:
        """Return the relative depth of the slip zone of each contact, from 0 (full stick) to 1 (full sliding)."""
        quadratic_coefficient, linear_coefficient = (
            1.5 * self.frictional / self.spring_stiffness,
            4 / np.pi * self.adhesive / self.spring_stiffness,
        )
        depth = (
            2
            * displacement
            / (linear_coefficient + np.sqrt(linear_coefficient**2 + 4 * quadratic_coefficient * displacement))
        )
        return np.asarray(np.where(displacement >= self.sliding_displacement, 1.0, np.minimum(depth, 1.0)))

    def _tangential_loads(self, depth: Floats) -> Floats:
        """Return the tangential load (mN) on each contact for given relative depths of the slip zones."""
        squared_stick_radius = 1 - depth**2
        is_sliding = depth >= 1
        frictional_fraction = np.where(
            is_sliding, 1.0, -np.expm1(1.5 * np.log1p(-(np.where(is_sliding, 0.0, depth) ** 2)))
        )
        adhesive_fraction = 2 / np.pi * (np.arcsin(depth) + depth * np.sqrt(squared_stick_radius))
        return np.asarray(self.frictional * frictional_fraction + self.adhesive * adhesive_fraction)


class HalfSpaceTangentialProblem:
    """Half-space contact at a constant normal load, and its slip states under tangential loads."""

    def __init__(
        self,
        contact_solution: ContactSolution,
        *,
        mu0: float,
        tau0: float,
        poisson: float | Sequence[float],
        tolerance: float,
    ) -> None:
        problem = contact_solution.problem
        self.grids, self.cell_area, self.has_displacement = (
            problem.grids,
            problem.cell_area,
            problem.has_finite_approach,
        )
        self.shape, self.size = problem.gap.shape, problem.gap.size
        # In profiles, tangential tractions are line loads across the motion, whose `transverse_fraction` is 1.
        transverse_fraction = 1.0 if len(self.shape) == 1 else 0.5
        self.ratio = float(compliance_ratio(poisson, problem.compliance_share, transverse_fraction))
        self.points: NDArray[Any] = contact_solution.points
        self.pressure = contact_solution.values
        area_factor = np.sqrt(1 + sum(slope[self.points] ** 2 for slope in problem.interface_slopes))
        self.area = contact_solution.share * self.cell_area * area_factor
        law = FrictionLaw(mu0, tau0)
        frictional, adhesive = law.contributions(self.pressure, self.area)
        self.bound = frictional + adhesive / self.cell_area
        self.normal_load = float(self.pressure.sum() * self.cell_area)
        self.sliding_load = float(law.force(self.normal_load, self.area.sum()))
        bound_on_grid = self._spread_over_grid(self.bound)
        self.mean_bound = float(bound_on_grid.mean())
        self.tolerance = validate_number("tolerance", tolerance, above=0, below=1)
        self.bound_on_grid = bound_on_grid
        compliance = contact_solution.response_at_fixed_tilt[1] * self.ratio
        self.stiffness = (
            (self.cell_area / compliance if compliance > 0 else np.inf) if self.has_displacement else np.nan
        )

    @cached_property
    def _solver(self) -> _core.HalfSpaceSolver:
        """Solver for the tangential tractions at the contact points.

        A copy of the problem creates its own solver.
        """
        return _core.HalfSpaceSolver(
            np.zeros(self.shape),
            self.grids,
            bound=self.bound_on_grid,
            tolerance=self.tolerance,
            threads=solver_thread_count(),
        )

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_solver"}

    def at(self, load: float, near: SlipState | None = None) -> SlipState:
        """Return the slip state of lowest energy among the states that support a tangential load (mN)."""
        if load >= self.sliding_load:
            displacements = self._compute_displacements(self.bound)
            return self._make_slip_state(self.sliding_load, self.bound, float(displacements.max()), displacements)
        load_fraction = load / self.sliding_load
        initial_traction = None if near is None else self._spread_over_grid(near.traction)
        solution = self._solver.at(
            load_fraction * self.mean_bound, near=initial_traction, threads=solver_thread_count()
        )
        if not solution.error <= self.tolerance:
            raise NoSolutionError(
                f"no solution at {load:g} mN ({load_fraction:g} of the sliding load): error {solution.error:.2g} after "
                f"{solution.iterations} iterations, above the tolerance {self.tolerance:g}"
            )
        traction = solution.pressure[self.points]
        # In full contact without slip, the tangential displacement is 0, so a computed displacement is only round-off.
        is_at_rest = self.stiffness == np.inf and not (traction >= self.bound).any()
        displacement = 0.0 if is_at_rest else solution.approach * self.ratio
        has_displacements = solution.potential.size == self.points.size
        return self._make_slip_state(
            load, traction, displacement, solution.potential * self.ratio if has_displacements else None
        )

    def dissipated_energy(self, slip: SlipState) -> float:
        """Return the energy (mN µm) that slip dissipates in first loading, as the sum of traction · slip · cell area.

        The sum is over the slipping points. The energy does not depend on the displacement of distant points.
        """
        displacements = slip.point_displacements
        if displacements is None:
            displacements = self._compute_displacements(slip.traction)
        is_slipping = slip.traction >= self.bound
        is_sticking = (slip.traction > 0) & ~is_slipping
        stuck_displacement = (
            displacements[is_sticking].mean() if is_sticking.any() else displacements[is_slipping].max()
        )
        return float(
            (self.bound[is_slipping] * (stuck_displacement - displacements[is_slipping])).sum() * self.cell_area
        )

    def _make_slip_state(
        self, load: float, traction: Floats, displacement: float, point_displacements: Floats | None
    ) -> SlipState:
        is_slipping = traction >= self.bound
        return SlipState(
            load=load, displacement=max(displacement, 0.0) if self.has_displacement else np.nan,
            slipped_area=float(self.area[is_slipping].sum() / self.area.sum()),
            slipped_load=float(self.pressure[is_slipping].sum() / self.pressure.sum()), traction=traction,
            point_displacements=point_displacements,
        )  # fmt: skip

    def _compute_displacements(self, traction: Floats) -> Floats:
        """Return the tangential displacements (µm) of the points in contact under given tractions."""
        if self.stiffness == np.inf and np.ptp(traction) <= TRACTION_UNIFORMITY_TOLERANCE * traction.max():
            # In full contact, a uniform traction causes no displacement.
            return np.zeros(traction.size)
        displacements = (
            self.grids.displacement(self._spread_over_grid(traction), threads=solver_thread_count()) * self.ratio
        )
        return np.asarray(displacements.ravel()[self.points])

    def _spread_over_grid(self, traction: Floats) -> Floats:
        grid = np.zeros(self.size)
        grid[self.points] = traction
        return grid.reshape(self.shape)
