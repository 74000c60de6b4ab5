"""Half-space contact of two surfaces: problem definition with input checks, solver, and solution at one load."""

from __future__ import annotations

import copyreg
import math
import sys
import weakref
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiction._core as _core
from stiction._caching import cached_property
from stiction._checks import Floats, float_array, make_read_only
from stiction._errors import NoSolutionError
from stiction._units import short_repr
from stiction.mechanics.model import PROFILE_WIDTH
from stiction.mechanics.patches import ContactArrays, PatchSums, grid_slopes, patch_sums
from stiction.mechanics.solution_record import SolutionRecord, StepResult
from stiction.surfaces.profile import Profile, combine_missing_masks
from stiction.surfaces.surface import Surface

MAX_CACHED_GRID_POINTS = 2**20
"""Largest number of points of a grid whose elastic kernels stay cached when no problem uses the grid.

Kernels for so many points take 35 MB, and the arrays of the solver 46 MB per thread. Computing the kernels takes a
quarter of the time of solving a contact with free boundaries.
"""

TRIAL_TILT_TO_MEAN_DISPLACEMENT_RATIO = 0.01
LINEAR_RESPONSE_TOLERANCE = 1e-7
# Upper limit of pressures (GPa) in a linear response to a mean pressure of 1 GPa: so high that none reaches it.
MAX_LINEAR_RESPONSE_PRESSURE = 1e9
MAX_CELL_ASPECT_RATIO = 1e6


_grids_by_key: weakref.WeakValueDictionary[tuple[Any, ...], _core.HalfSpaceGrids] = weakref.WeakValueDictionary()
_keys_by_grids: weakref.WeakKeyDictionary[_core.HalfSpaceGrids, tuple[Any, ...]] = weakref.WeakKeyDictionary()
_most_recent_grids: deque[_core.HalfSpaceGrids] = deque(maxlen=1)
_uniform_displacements: weakref.WeakKeyDictionary[_core.HalfSpaceGrids, Floats] = weakref.WeakKeyDictionary()


def get_half_space_grids(
    shape: tuple[int, ...], spacing: tuple[float, ...], effective_modulus: float, *, periodic: bool,
    remains_cached: bool = True,
) -> _core.HalfSpaceGrids:  # fmt: skip
    """Return the hierarchy of grids, with elastic kernels, on which a half-space contact problem is solved.

    Calls with equal arguments share the grids.

    Unless `remains_cached` is False, the grids remain cached until the next call, even if no problem uses them.
    """
    grids_key = shape, spacing, effective_modulus, periodic
    grids = _grids_by_key.get(grids_key)
    if grids is None:
        grids = _core.HalfSpaceGrids(shape, spacing, effective_modulus=effective_modulus, periodic=periodic)
        _grids_by_key[grids_key], _keys_by_grids[grids] = grids, grids_key
    if remains_cached and math.prod(shape) <= MAX_CACHED_GRID_POINTS:
        _most_recent_grids.append(grids)
    return grids


def _unpickle_grids(
    shape: tuple[int, ...], spacing: tuple[float, ...], effective_modulus: float, periodic: bool
) -> _core.HalfSpaceGrids:
    return get_half_space_grids(shape, spacing, effective_modulus, periodic=periodic)


# Grids are pickled without their kernels; the process that unpickles the grids computes the kernels again.
copyreg.pickle(_core.HalfSpaceGrids, lambda grids: (_unpickle_grids, _keys_by_grids[grids]))


def solver_thread_count() -> int:
    """Return the number of threads of a contact solver, as set by `scipy.fft.set_workers`."""
    # While another thread is importing `scipy.fft`, the module may lack `get_workers`.
    get_workers = getattr(sys.modules.get("scipy.fft"), "get_workers", None)
    return 1 if get_workers is None else int(get_workers())


def has_finite_approach(num_dimensions: int, *, periodic: bool) -> bool:
    """Return whether the distance by which distant points of the bodies approach each other is finite.

    The distance is unbounded on a free half-plane.

    The bodies are profiles (1 dimension) or height maps (2 dimensions).
    """
    return periodic or num_dimensions == 2


@dataclass(frozen=True, eq=False)
class HalfSpaceProblem:
    """Contact problem of two surfaces: heights, gap (µm, at least 0), material and boundary conditions."""

    upper_heights: Floats
    lower_heights: Floats
    gap: Floats
    spacing: tuple[float, ...]
    compliance_share: float
    grids: _core.HalfSpaceGrids
    hardness: float | None
    work_of_adhesion: float = 0.0
    adhesion_range: float = 0.0
    missing: NDArray[np.bool_] | None = None
    # Tilt of the upper surface about its centre, given as slopes along y and x for maps, and along x for profiles.
    tilt: Floats | float = 0.0
    has_free_tilt: bool = False

    @property
    def periodic(self) -> bool:
        """True if the surfaces continue periodically beyond their sides."""
        return self.grids.periodic

    @cached_property
    def cell_area(self) -> float:
        """Area of a grid cell, µm²."""
        return float(np.prod(self.spacing)) * (PROFILE_WIDTH if len(self.spacing) == 1 else 1.0)

    @cached_property
    def nominal_area(self) -> float:
        """Nominal area (µm²) of the points that were measured on both surfaces."""
        return self.cell_area * (self.gap.size - (0 if self.missing is None else int(self.missing.sum())))

    @property
    def has_finite_approach(self) -> bool:
        """True if distant points of the two bodies approach each other by a finite distance."""
        return has_finite_approach(len(self.spacing), periodic=self.periodic)

    @property
    def measured_point_mask(self) -> Floats:
        """Array on the grid: 1 at points that were measured on both surfaces, 0 at all others."""
        return np.ones_like(self.gap) if self.missing is None else np.where(self.missing, 0.0, 1.0)

    @cached_property
    def uniform_pressure_displacement(self) -> Floats:
        """Displacement (µm) of each grid point under a pressure of 1 GPa on all measured points.

        The displacement is 0 for complete periodic surfaces.
        """
        if self.missing is not None:
            return np.asarray(self.grids.displacement(self.measured_point_mask, threads=solver_thread_count()))
        if (cached_displacement := _uniform_displacements.get(self.grids)) is None:
            cached_displacement = _uniform_displacements[self.grids] = make_read_only(
                self.grids.displacement(self.measured_point_mask, threads=solver_thread_count())
            )
        return cached_displacement

    @cached_property
    def interface_slopes(self) -> list[Floats]:
        """Slopes of the deformed interface at every point: along y and x for maps, along x for profiles."""
        fraction = self.compliance_share
        interface_heights = (1 - fraction) * self.lower_heights + fraction * self.upper_heights
        return [slope.ravel() for slope in grid_slopes(interface_heights, self.spacing, periodic=self.periodic)]


@dataclass(frozen=True, eq=False)
class ContactSolution:
    """Contact solution at one load (mN): pressure (GPa), patch number and contact fraction of each contact point."""

    problem: HalfSpaceProblem
    load: float
    points: NDArray[np.int64]
    values: Floats
    share: Floats
    patch: NDArray[np.int32]
    approach: float
    error: float
    iterations: int
    attraction: Floats | float = 0.0

    @property
    def attraction_force(self) -> float:
        """Total force of the adhesive attraction, mN."""
        return float(np.sum(self.attraction)) * self.problem.cell_area

    @property
    def arrays(self) -> ContactArrays:
        """Arrays over the contact points: grid index, pressure (GPa), contact fraction and patch number."""
        return self.points, self.values, self.share, self.patch

    def on_grid(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return an array over the grid, with `values` at the contact points and 0 at all other points."""
        grid = np.zeros(self.problem.gap.size, values.dtype)
        grid[self.points] = values
        return grid.reshape(self.problem.gap.shape)

    @cached_property
    def below_hardness(self) -> NDArray[np.bool_]:
        """Boolean array that is True for contact points with a pressure below the hardness."""
        return self.values < (np.inf if self.problem.hardness is None else self.problem.hardness)

    @cached_property
    def is_elastic(self) -> bool:
        """True if the pressure is below the hardness at all contact points."""
        return bool(self.below_hardness.all())

    @cached_property
    def stiffness(self) -> float:
        """Normal stiffness dF/dδ (mN/µm) of the contact, for an unchanged set of contact points.

        The stiffness is infinite at full periodic contact, and NaN if the solution has no approach.
        """
        return self._compute_stiffness(self.below_hardness)

    @cached_property
    def unloading_stiffness(self) -> float:
        """Normal stiffness dF/dδ (mN/µm) during unloading, when all contact points respond elastically.

        In contrast to `stiffness`, yielded points respond too, because they unload elastically.
        """
        return self.stiffness if self.is_elastic else self._compute_stiffness(self._all_points)

    @cached_property
    def closure_stiffness(self) -> float:
        """Closure stiffness dp/dc (GPa/µm) for an unchanged set of contact points; p: nominal pressure, c: closure.

        The closure is the decrease of the mean gap: the approach minus the mean displacement of the surface. The
        stiffness is infinite at full contact, and NaN if all points have yielded.
        """
        return self._compute_closure_stiffness(self.below_hardness)

    @cached_property
    def unloading_closure_stiffness(self) -> float:
        """Closure stiffness dp/dc (GPa/µm) during unloading, when all contact points respond elastically."""
        if self.is_elastic:
            return self.closure_stiffness
        return self._compute_closure_stiffness(self._all_points)

    @cached_property
    def _all_points(self) -> NDArray[np.bool_]:
        return np.ones_like(self.below_hardness)

    @cached_property
    def _linear_response(self) -> tuple[Floats, float]:
        return self._compute_response(self.below_hardness)

    @cached_property
    def _unloading_response(self) -> tuple[Floats, float]:
        return self._compute_response(self._all_points)

    @cached_property
    def loading_compliances(self) -> tuple[float, float]:
        """Compliances of the contact during loading, when only contact points below the hardness respond.

        The compliances are two displacements (µm), which `cache_compliances` defines.
        """
        return self._compute_compliances("loading_compliances")

    @cached_property
    def unloading_compliances(self) -> tuple[float, float]:
        """Compliances of the contact during unloading, when all contact points respond elastically.

        The compliances are two displacements (µm), which `cache_compliances` defines.
        """
        return self._compute_compliances("unloading_compliances")

    @cached_property
    def response_at_fixed_tilt(self) -> tuple[Floats, float]:
        """Contact pressures that displace all contact points by the same distance, and this distance (µm).

        The pressures have the sum 1 GPa.
        """
        if self.problem.has_free_tilt:
            return self.problem.grids.linear_response(self.on_grid(self._all_points), threads=solver_thread_count())
        return self._linear_response if self.is_elastic else self._unloading_response

    def _compute_response(self, free_mask: NDArray[np.bool_]) -> tuple[Floats, float]:
        """Return the pressures under which the points in a mask move as a rigid body, and the resulting approach (µm).

        The pressures have the sum 1 GPa.

        The upper surface moves along z and, if the problem has free tilt, also tilts.
        """
        if not self.problem.has_free_tilt:
            return self.problem.grids.linear_response(self.on_grid(free_mask), threads=solver_thread_count())
        return TiltResponse.solve(self.problem, self.on_grid(free_mask)).balanced_response()

    def _compute_compliances(self, name: str) -> tuple[float, float]:
        pressures, displacement = getattr(self, _RESPONSE_NAMES[name])
        return displacement, float((pressures * self.problem.uniform_pressure_displacement).sum())

    def _get_compliances(self, free_mask: NDArray[np.bool_]) -> tuple[float, float]:
        """Return `loading_compliances` if the mask is `below_hardness`, otherwise `unloading_compliances`."""
        return self.loading_compliances if free_mask is self.below_hardness else self.unloading_compliances

    def _compute_stiffness(self, free_mask: NDArray[np.bool_]) -> float:
        problem = self.problem
        if not (problem.has_finite_approach and free_mask.any()):
            return np.nan
        compliance = self._get_compliances(free_mask)[0]
        return problem.cell_area / compliance if compliance > 0 else np.inf

    def _compute_closure_stiffness(self, free_mask: NDArray[np.bool_]) -> float:
        problem = self.problem
        if not free_mask.any():
            return np.nan
        if problem.periodic and problem.missing is None:
            return self._compute_stiffness(free_mask) / problem.nominal_area
        # By reciprocity, the mean displacement is Σ (contact pressure · displacement under uniform pressure).
        approach_at_unit_pressure_sum, mean_displacement = self._get_compliances(free_mask)
        closure = approach_at_unit_pressure_sum * problem.nominal_area / problem.cell_area - mean_displacement
        return 1 / closure if closure > 0 else np.inf


_RESPONSE_NAMES = {"loading_compliances": "_linear_response", "unloading_compliances": "_unloading_response"}


def cache_compliances(solutions: Sequence[ContactSolution], *, unloading: bool) -> list[ContactSolution]:
    """Compute and store the compliances (displacement per pressure) of contact solutions that lack them.

    Returns the solutions that lacked compliances.

    The compliances of a contact are two displacements (µm), due to pressures with a sum of 1 GPa that displace its
    points equally: the displacement of these points, and the sum of the pressures times the displacements under a
    pressure of 1 GPa on the whole grid. The solutions are for one pair.
    """
    missing_compliances: list[tuple[ContactSolution, str]] = []
    for solution in solutions:
        # The responses to loading and to unloading are equal if no point of the contact has yielded.
        name = "unloading_compliances" if unloading and not solution.is_elastic else "loading_compliances"
        is_computed = name in vars(solution) or _RESPONSE_NAMES[name] in vars(solution)
        if not is_computed and not solution.problem.has_free_tilt and (unloading or solution.below_hardness.any()):
            missing_compliances.append((solution, name))
    if not missing_compliances:
        return []
    problem = missing_compliances[0][0].problem
    compliances = problem.grids.fixed_contact_responses(
        [
            solution.points[solution.below_hardness]
            if name == "loading_compliances" and not solution.is_elastic
            else solution.points
            for solution, name in missing_compliances
        ],
        problem.uniform_pressure_displacement,
        threads=solver_thread_count(),
    )
    for (solution, name), compliances_of_solution in zip(missing_compliances, compliances, strict=True):
        vars(solution)[name] = compliances_of_solution
    return [solution for solution, _ in missing_compliances]


def sum_friction_over_patches(solutions: Sequence[ContactSolution], directions: Floats) -> PatchSums:
    """Sum forces and areas over the points of each contact patch, for several solutions and directions of motion."""
    problem = solutions[0].problem
    # With free tilt, each load has its own contact problem, because the tilt changes the gap.
    if any(solution.problem is not problem for solution in solutions):
        return PatchSums.join([sum_friction_over_patches([solution], directions) for solution in solutions])
    contacts = [solution.arrays for solution in solutions]
    return patch_sums(contacts, problem.interface_slopes, problem.cell_area, directions)


def tabulate_solutions(solutions: Sequence[ContactSolution]) -> dict[str, NDArray[Any]]:
    """Return the fields of `HalfSpaceCurve` that do not depend on friction, such as load and approach.

    The solutions are for one pair at several loads, and may differ in its tilt.
    """
    problem = solutions[0].problem
    uniform_displacement = problem.uniform_pressure_displacement
    num_points = np.array([solution.points.size for solution in solutions])
    first_point = np.cumsum(num_points) - num_points
    pressures = np.concatenate([solution.values for solution in solutions])
    displacements = uniform_displacement.ravel()[np.concatenate([solution.points for solution in solutions])]
    is_at_hardness = pressures == problem.hardness
    load, approach, error = (
        np.array([getattr(solution, name) for solution in solutions]) for name in ("load", "approach", "error")
    )
    displacement = np.add.reduceat(pressures * displacements, first_point)
    attraction_force = np.zeros(load.size)
    if problem.work_of_adhesion > 0:
        attraction_force = np.array([solution.attraction_force for solution in solutions])
        displacement -= [float(np.sum(solution.attraction * uniform_displacement)) for solution in solutions]
    return {
        "load": load,
        "contact_load": load + attraction_force,
        "approach": approach if problem.has_finite_approach else np.full(load.size, np.nan),
        "closure": approach - displacement * problem.cell_area / problem.nominal_area,
        "error": error,
        "iterations": np.array([solution.iterations for solution in solutions]),
        "contact_count": np.array([int(solution.patch.max()) for solution in solutions]),
        "load_share_at_hardness": np.add.reduceat(np.where(is_at_hardness, pressures, 0.0), first_point)
        / np.add.reduceat(pressures, first_point),
        "area_share_at_hardness": np.add.reduceat(is_at_hardness, first_point, dtype=np.float64) / num_points,
    }


MAX_GAP_TO_LENGTH_RATIO = 1e6


def make_problem(
    upper: Profile | Surface, lower: Profile | Surface, effective_modulus: float, *, periodic: bool,
    compliance_share: float, hardness: float | None,
) -> HalfSpaceProblem:  # fmt: skip
    """Create the contact problem of two surfaces on the same grid.

    The caller must have checked all arguments.
    """
    if upper.heights.shape != lower.heights.shape:
        raise ValueError(
            f"the upper and the lower body must have equal shapes, got {upper.heights.shape} and {lower.heights.shape}"
        )
    spacing = upper.spacings
    # `cell_area` is infinite if the product of the spacings overflows.
    cell_area = math.prod(spacing)
    if not (np.finfo(np.float64).tiny <= cell_area < np.inf and max(spacing) <= MAX_CELL_ASPECT_RATIO * min(spacing)):
        raise ValueError(
            f"spacing must give grid cells of at least {np.finfo(np.float64).tiny:.0e} µm² with sides that differ by a "
            f"factor of at most {MAX_CELL_ASPECT_RATIO:g}, got {upper.spacing} µm"
        )
    gap, missing = upper.heights - lower.heights, combine_missing_masks(upper, lower)
    gap -= gap.min() if missing is None else gap[~missing].min()
    max_gap = MAX_GAP_TO_LENGTH_RATIO * max(spacing) * max(gap.shape)
    if not gap.max() <= max_gap:
        raise ValueError(
            f"the gap between the upper and the lower body must be at most {max_gap:.3g} µm "
            f"({MAX_GAP_TO_LENGTH_RATIO:g} times the length of the bodies), got {gap.max():.3g} µm"
        )
    grids = get_half_space_grids(gap.shape, spacing, effective_modulus, periodic=periodic)
    return HalfSpaceProblem(
        upper.heights, lower.heights, gap, spacing, compliance_share, grids, hardness, missing=missing
    )


# Minimum number of grid points in the process zone E* ρ²/w at the edge of an adhesive contact.
MIN_PROCESS_ZONE_POINTS = 2.0


def min_resolved_adhesion_range(work: float, spacing: float, effective_modulus: float) -> float:
    """Return the shortest adhesion range (µm) that a grid resolves, given work of adhesion (mN/µm) and E*."""
    return math.sqrt(MIN_PROCESS_ZONE_POINTS * spacing * work / effective_modulus)


def coarsen_problem(problem: HalfSpaceProblem) -> HalfSpaceProblem:
    """Return a coarser copy of a contact problem, with every second grid point along each axis.

    An attraction range that this grid cannot resolve is increased.
    """
    spacing = tuple(2 * step for step in problem.spacing)
    upper_heights, lower_heights, gap = (
        take_every_second_point(values) for values in (problem.upper_heights, problem.lower_heights, problem.gap)
    )
    _, _, effective_modulus, periodic = _keys_by_grids[problem.grids]
    # Coarse grids are not cached: in the cache, they would replace the grids of `problem`, which later problems need.
    grids = get_half_space_grids(gap.shape, spacing, effective_modulus, periodic=periodic, remains_cached=False)
    min_adhesion_range = min_resolved_adhesion_range(problem.work_of_adhesion, max(spacing), effective_modulus)
    adhesion_range = max(problem.adhesion_range, min_adhesion_range)
    return replace(
        problem,
        upper_heights=upper_heights,
        lower_heights=lower_heights,
        gap=gap,
        spacing=spacing,
        grids=grids,
        adhesion_range=adhesion_range,
    )


def take_every_second_point(values: Floats) -> Floats:
    """Return every second element of an array along each axis, which gives the array on a coarser grid."""
    return np.ascontiguousarray(values[(slice(None, None, 2),) * values.ndim])


StepKind = Literal["loads", "approaches"]


def parse_loads_or_approaches(
    problem: HalfSpaceProblem, loads: ArrayLike | None, approaches: ArrayLike | None
) -> tuple[StepKind, Floats]:
    """Check loads (mN) or approaches (µm). Return their kind, "loads" or "approaches", and the checked numbers."""
    step_kind: StepKind = "loads" if approaches is None else "approaches"
    given_values = loads if approaches is None else approaches
    if given_values is None or (loads is not None and approaches is not None):
        raise ValueError("half_space requires either loads or approaches")
    steps = float_array(step_kind, given_values, ndim=1)
    if problem.work_of_adhesion > 0:
        if step_kind == "approaches":
            raise ValueError("approaches must not be given for surfaces with adhesion; give loads instead")
        if not (steps.size > 0 and len(set(np.sign(np.diff(steps)))) <= 1 and np.diff(steps).all()):
            raise ValueError(f"loads must be strictly increasing or strictly decreasing, got {short_repr(loads)}")
    elif not (steps.size > 0 and (steps > 0).all() and (np.diff(steps) > 0).all()):
        unit = "mN" if step_kind == "loads" else "µm"
        raise ValueError(f"{step_kind} must be above 0 {unit} and strictly increasing, got {short_repr(given_values)}")
    gap, hardness = problem.gap, problem.hardness
    if step_kind == "loads":
        max_load = np.inf if hardness is None else hardness * problem.nominal_area
        if not steps.max() < max_load:
            raise ValueError(
                f"loads must be below {max_load:g} mN, the hardness times the nominal area, got {steps.max():g} mN"
            )
        return step_kind, steps
    if hardness is not None:
        raise ValueError(
            "approaches must not be given for surfaces with a hardness, "
            f"got hardness={short_repr(hardness)}; give loads instead"
        )
    if not problem.has_finite_approach:
        raise ValueError(
            "approaches must not be given for a free half-plane, because its approach is infinite at any load; "
            "give loads, or use boundary='periodic'"
        )
    if problem.periodic and not steps[-1] < gap.mean():
        raise ValueError(
            f"approaches must be below {gap.mean():g} µm, at which all points are in contact, "
            f"got {short_repr(approaches)}"
        )
    return step_kind, steps


def lever_arms(problem: HalfSpaceProblem) -> list[Floats]:
    """Return the coordinates (µm) of the grid points along each axis, relative to the centre of the measured points.

    Each array has a shape for broadcasting over the grid.
    """
    arms = []
    for axis, (count, spacing) in enumerate(zip(problem.gap.shape, problem.spacing, strict=True)):
        other_axes = tuple(index for index in range(problem.gap.ndim) if index != axis)
        weights, positions = problem.measured_point_mask.sum(axis=other_axes), spacing * np.arange(count)
        shape = [count if index == axis else 1 for index in range(problem.gap.ndim)]
        arms.append((positions - np.average(positions, weights=weights)).reshape(shape))
    return arms


@dataclass(frozen=True, eq=False)
class TiltResponse:
    """Response of contact pressures, approach and moments to a mean pressure, and to a tilt of the upper surface."""

    # Contact pressures (GPa) at a mean pressure of 1 GPa.
    pressure: Floats
    # Approach (µm) at a mean pressure of 1 GPa.
    approach: float
    # Moments per area (GPa µm) about each of n axes at a mean pressure of 1 GPa.
    moments: Floats
    # Change of the contact pressures (GPa) per unit slope of the upper surface along each axis, at constant load.
    slope_pressures: list[Floats]
    # Changes of n moments per area by unit slopes along n axes (n × n); negative definite if several points touch.
    moments_per_slope: Floats

    @classmethod
    def solve(cls, problem: HalfSpaceProblem, free_mask: NDArray[np.bool_]) -> TiltResponse:
        """Compute how the pressures at the points of a mask change under a mean pressure of 1 GPa and under a tilt."""
        max_pressure = np.where(free_mask, MAX_LINEAR_RESPONSE_PRESSURE, 0.0)
        arms = lever_arms(problem)

        def solve_linear_response(gap: Floats) -> tuple[Floats, float]:
            solver = _core.HalfSpaceSolver(
                gap,
                problem.grids,
                bound=max_pressure,
                tolerance=LINEAR_RESPONSE_TOLERANCE,
                threads=solver_thread_count(),
            )
            result = solver.at(1.0, threads=solver_thread_count())
            return result.pressure.reshape(gap.shape), result.approach

        pressure, approach = solve_linear_response(np.zeros_like(problem.gap))
        moments = mean_moments(pressure, arms)
        mean_displacement = float(
            np.abs(problem.grids.displacement(pressure, threads=solver_thread_count())[free_mask]).mean()
        )
        slope_pressures = []
        for arm in arms:
            small_slope = TRIAL_TILT_TO_MEAN_DISPLACEMENT_RATIO * mean_displacement / float(np.abs(arm).max())
            slope_pressures.append(
                (solve_linear_response(small_slope * np.broadcast_to(arm, problem.gap.shape).copy())[0] - pressure)
                / small_slope
            )
        moments_per_slope = np.array([mean_moments(slope_pressure, arms) for slope_pressure in slope_pressures])
        return cls(pressure, approach, moments, slope_pressures, (moments_per_slope + moments_per_slope.T) / 2)

    def balanced_response(self) -> tuple[Floats, float]:
        """Return the pressures and the approach (µm) at the tilt for which the pressures have no resultant moment.

        The pressures have the sum 1 GPa.
        """
        slopes = -np.linalg.lstsq(self.moments_per_slope, self.moments, rcond=None)[0]
        pressure = self.pressure + sum(
            slope * slope_pressure for slope, slope_pressure in zip(slopes, self.slope_pressures, strict=True)
        )
        return pressure / pressure.size, (self.approach + float(slopes @ self.moments)) / pressure.size


def mean_moments(pressure: Floats, arms: list[Floats]) -> Floats:
    """Return the moments of a pressure about the centre, averaged over all grid points (GPa µm)."""
    return np.array([float((pressure * arm).mean()) for arm in arms])


class ContactSolver:
    """Solver for a single contact problem, at any loads (mN) or approaches (µm) up to `limit`."""

    def __init__(
        self, problem: HalfSpaceProblem, step_kind: StepKind, limit: float, *, tolerance: float,
        report: Callable[[int, float], object] | None, record: SolutionRecord,
    ) -> None:  # fmt: skip
        self.problem, self.step_kind, self.tolerance, self.report = problem, step_kind, tolerance, report
        self.counter = record.counter
        max_pressure = np.array([np.inf if problem.hardness is None else problem.hardness])
        gap, self.scale = problem.gap, 1.0
        if (missing := problem.missing) is not None:
            # At points with missing data, the gap is made so large that it never closes.
            # `scale` corrects the tolerance, a fraction of the gap's standard deviation, for the gap at missing points.
            measured_gap = gap[~missing]
            mean_displacement = np.ptp(problem.grids.displacement(np.where(missing, 0.0, limit / problem.nominal_area)))
            gap = np.where(
                missing, 2 * measured_gap.max() + 4 * (mean_displacement if step_kind == "loads" else limit), gap
            )
            self.scale = float(gap.std() / measured_gap.std()) if np.ptp(measured_gap) > 0 else 1.0
        self._core = _core.HalfSpaceSolver(
            gap, problem.grids, bound=max_pressure, tolerance=tolerance / self.scale, threads=solver_thread_count()
        )

    def at(self, step: float, near: Floats | None) -> _core.HalfSpaceSolution:
        """Solve the contact at one load (mN) or one approach (µm), depending on `step_kind`.

        Raises `NoSolutionError` if the error exceeds the tolerance.
        """
        problem, is_load = self.problem, self.step_kind == "loads"
        value = step / (problem.cell_area * problem.gap.size) if is_load else step
        solve_step = self._core.at if is_load else self._core.at_approach
        solution = solve_step(
            value, near=near, threads=solver_thread_count(), progress=self.report, counter=self.counter
        )
        if problem.missing is not None and solution.pressure.reshape(problem.gap.shape)[problem.missing].any():
            raise self._missing_contact_error(step)
        if not solution.error * self.scale <= self.tolerance:
            raise self._no_solution_error(step, solution.error * self.scale, solution.iterations)
        return solution

    def contacts_at(
        self, steps: Floats, near: Floats | None, progress: Callable[[int, int, float], object] | None
    ) -> StepResult:
        """Solve the contact at several loads (mN) or several approaches (µm), depending on `step_kind`.

        Each step starts from the pressures of the step before it.

        Returns the arrays of `to_step_result`. Raises `NoSolutionError` at the first step whose error exceeds the
        tolerance.
        """
        problem, is_load = self.problem, self.step_kind == "loads"
        targets = steps / (problem.cell_area * problem.gap.size) if is_load else steps
        solve = self._core.contacts_at if is_load else self._core.contacts_at_approaches
        result: StepResult = solve(
            targets, near=near, hardness=np.inf if problem.hardness is None else problem.hardness,
            threads=solver_thread_count(), progress=progress, counter=self.counter,
        )  # fmt: skip
        result["error"] *= self.scale
        if problem.missing is not None and (is_missing := problem.missing.ravel()[result["points"]]).any():
            step = np.repeat(steps[: result["num_points"].size], result["num_points"])[is_missing][0]
            raise self._missing_contact_error(step)
        last_index = result["error"].size - 1
        if last_index + 1 < steps.size or not result["error"][last_index] <= self.tolerance:
            raise self._no_solution_error(
                steps[last_index], float(result["error"][last_index]), int(result["iterations"][last_index])
            )
        if not is_load:
            first_point = np.cumsum(result["num_points"]) - result["num_points"]
            steps = np.add.reduceat(result["values"], first_point) * problem.cell_area
        return result | {"load": steps}

    def _no_solution_error(self, step: float, error: float, iterations: int) -> NoSolutionError:
        return NoSolutionError(
            f"no solution at {self._format_step(step)}: error {error:.2g} after {iterations} iterations, above the "
            f"tolerance {self.tolerance:g}"
        )

    def _missing_contact_error(self, step: float) -> NoSolutionError:
        return NoSolutionError(
            f"no solution at {self._format_step(step)}: points without a measured height would come into contact; "
            "interpolate these points, or crop the scans"
        )

    def _format_step(self, step: float) -> str:
        return f"a load of {step:g} mN" if self.step_kind == "loads" else f"an approach of {step:g} µm"


@dataclass(frozen=True, eq=False)
class AdhesionState:
    """Contact in equilibrium with the external load and the adhesive attraction.

    Means over the grid are in GPa; the other fields have the meaning of `HalfSpaceSolution`.
    """

    pressure: Floats
    attraction: Floats
    contact_load: float
    load: float
    approach: float = np.nan
    error: float = np.nan
    iterations: int = 0

    @property
    def mean_attraction(self) -> float:
        """Mean attraction (GPa) over all grid points."""
        return self.contact_load - self.load


def to_contact_solution(
    problem: HalfSpaceProblem, solution: _core.HalfSpaceSolution | AdhesionState, load: float | None,
    attraction: Floats | float = 0.0, *, scale: float = 1.0,
) -> ContactSolution:  # fmt: skip
    """Convert a result of the solver to a `ContactSolution`.

    The default load (mN) is the sum of the pressures.
    """
    hardness = np.inf if problem.hardness is None else problem.hardness
    pressure = solution.pressure.reshape(problem.gap.shape)
    contact_arrays: Any = _core.patches_of(pressure, periodic=problem.periodic, hardness=hardness)
    points, values, fraction, patch = map(make_read_only, contact_arrays)
    load = float(values.sum()) * problem.cell_area if load is None else load
    approach_error_and_iterations = solution.approach, solution.error * scale, solution.iterations
    return ContactSolution(problem, load, points, values, fraction, patch, *approach_error_and_iterations, attraction)


def to_step_result(contact_solution: ContactSolution) -> StepResult:
    """Convert a contact solution to named arrays, from which `from_step_result` restores the solution."""
    result: StepResult = {name: getattr(contact_solution, name) for name in ("points", "values", "share", "patch")}
    result["num_points"] = np.array([contact_solution.points.size])
    result |= {name: np.array([getattr(contact_solution, name)]) for name in _SCALAR_STEP_NAMES}
    problem = contact_solution.problem
    return result | (
        {"upper": problem.upper_heights, "gap": problem.gap, "tilt": problem.tilt} if problem.has_free_tilt else {}
    )


_SCALAR_STEP_NAMES = ("load", "approach", "error", "iterations")


def from_step_result(problem: HalfSpaceProblem, result: StepResult) -> list[ContactSolution]:
    """Restore a list of contact solutions from the concatenated arrays of `to_step_result`."""
    if problem.has_free_tilt:
        tilt = result["tilt"] if np.ndim(result["tilt"]) else float(result["tilt"])
        problem = replace(problem, upper_heights=result["upper"], gap=result["gap"], tilt=tilt)
    points, values, share, patch = (make_read_only(result[name]) for name in ("points", "values", "share", "patch"))
    scalar_rows = zip(*(result[name].tolist() for name in _SCALAR_STEP_NAMES), strict=True)
    solutions, start = [], 0
    for count, (load, approach, error, iterations) in zip(result["num_points"].tolist(), scalar_rows, strict=True):
        point_range = slice(start, start := start + count)
        solutions.append(
            ContactSolution(
                problem,
                load,
                points[point_range],
                values[point_range],
                share[point_range],
                patch[point_range],
                approach,
                error,
                iterations,
            )
        )
    return solutions
