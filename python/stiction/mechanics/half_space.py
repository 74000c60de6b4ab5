"""Half-space contact of two rough surfaces by the boundary-element method, and its friction.

For small slopes, two elastic bodies in frictionless contact are equivalent to one gap over a half-space of modulus E*.
Friction from half-space pressures and local slopes: Karpenko & Akay, Tribology International 34 (2001) 531.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._caching import cached_property
from stiction._checks import Floats, check_choice, check_instance, make_read_only, validate_fraction, validate_number
from stiction._drawing import draw_contact_pressure
from stiction._errors import NoSolutionError
from stiction._repr import PlotReprMixin, axes_or_new_axes
from stiction._units import loads_to_core_units, short_repr, to_core_units
from stiction._warnings import warn_caller
from stiction.mechanics.adhesion import solve_separation, solve_with_adhesion
from stiction.mechanics.friction import FrictionCurve
from stiction.mechanics.half_space_problem import (
    MIN_PROCESS_ZONE_POINTS,
    ContactSolver,
    cache_compliances,
    from_step_result,
    make_problem,
    min_resolved_adhesion_range,
    parse_loads_or_approaches,
    sum_friction_over_patches,
    tabulate_solutions,
)
from stiction.mechanics.mindlin import HalfSpaceTangentialProblem
from stiction.mechanics.model import (
    ContactModel,
    Direction,
    SlidingRule,
    check_pair,
    modulus_or_default,
    warn_if_same_body,
)
from stiction.mechanics.onset import Onset, compute_onset, parse_direction, resolve_index, validate_nonzero_strengths
from stiction.mechanics.patches import DIRECTED_TOTAL_NAMES
from stiction.mechanics.solution_record import SolutionRecord
from stiction.mechanics.tilt import solve_with_balanced_tilt
from stiction.surfaces.profile import Profile, reject_missing_points
from stiction.surfaces.surface import BodyLike, as_bodies

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stiction.mechanics.half_space_problem import ContactSolution, HalfSpaceProblem, StepKind
    from stiction.mechanics.patches import PatchSums

BoundaryCondition = Literal["free", "periodic"]
TiltMode = Literal["fixed", "free"]

MAX_POINTS_PER_STEP = 2**22
"""Maximum number of grid points, summed over the loads, that are solved in one step of a `SolutionRecord`.

By the estimate of the run time, a step takes at most 11 s on profiles and 3 s on maps, so that an interrupted run
loses little work. A larger grid has one load per step.
"""

STIFFNESS_TO_SOLUTION_TIME_RATIO = 1 / 3
"""Ratio of the time of a stiffness to the time of the solution at the same load, for maps with 512² to 1536² points.

Without adhesion, a record counts each stiffness as this fraction of the iterations of the solution.
"""

DEFAULT_ADHESION_RANGE = 5e-4
"""Default decay length (µm) of the attraction between solids: one to two atomic distances."""


@dataclass(frozen=True, eq=False, repr=False)
class HalfSpaceContact(PlotReprMixin):
    """Half-space contact of two surfaces at one load, with the pressure, gap and patch number of each grid point.

    Attributes
    ----------
    pressure : (n,) or (rows, columns) ndarray, GPa
        Contact pressure.
    gap : (n,) or (rows, columns) ndarray, µm
        Gap between the deformed surfaces: 0 in contact, to the tolerance; below 0 where the hardness limits the
        pressure; NaN at missing points.
    patches : (n,) or (rows, columns) ndarray of int
        Patch number of every point under pressure, counted from 1; 0 at points without pressure. Points are connected
        to all neighbours, of which surfaces have eight, and across the edges if periodic.
    opposing : (n,), (rows, columns), (d, n) or (d, rows, columns) ndarray of bool
        True if the patch of the point opposes the motion, for one direction or for d directions.
    share : (n,) or (rows, columns) ndarray
        Fraction of the point's cell that is in contact: 0 without pressure, and below 1 at edges of patches. The sum
        over all points, times the area of a cell, is the projected real contact area.
    heights : (n,) or (rows, columns) ndarray, µm
        Heights of the lower surface before deformation.
    spacing : tuple of float, µm
        Spacing of the points along y and x for surfaces, or along x for profiles.

    Examples
    --------
    >>> from stiction import half_space, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> contact = half_space(upper, lower, "1 mN").contact(0)
    >>> float((contact.pressure * 0.1**2).sum().round(6))  # GPa times µm² of each point: the load
    1.0
    """

    pressure: Floats = field(metadata={"unit": "GPa"})
    gap: Floats = field(metadata={"unit": "µm"})
    patches: NDArray[np.int32]
    opposing: NDArray[np.bool_]
    share: Floats
    heights: Floats = field(metadata={"unit": "µm"})
    spacing: tuple[float, ...] = field(metadata={"unit": "µm"})

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the contact pressure and the heights of the lower surface, as a map or along x.

        Draws into the given axes or into new axes, and returns the axes.
        """
        return draw_contact_pressure(axes_or_new_axes(ax), self.pressure, self.heights, self.spacing)


@dataclass(frozen=True, eq=False, repr=False)
class HalfSpaceCurve(FrictionCurve):
    """Half-space contacts of two surfaces at several loads, from which friction follows for any mu0 and tau0.

    Arrays are read-only.

    The sums are over points under pressure, analogous to those of `LoadCurve` over asperities: n is the normal of the
    deformed interface at a point, t the tangent, s the direction. A patch opposes if its force on the upper surface
    points against s. Quantities that depend on the direction have the shape (k,), or (d, k) for d directions.

    Attributes
    ----------
    load : (k,) ndarray, mN
        The given load, or the load at the given approach.
    approach : (k,) ndarray, µm
        Displacement of the upper surface since first contact, measured at points far away, or at the mean plane if
        periodic. NaN on a free half-plane, where points far away have no finite displacement.
    closure : (k,) ndarray, µm
        Decrease of the mean gap since first contact: the approach minus the mean displacement, without the bending of
        free bodies. Joint tests measure the closure. For periodic surfaces it equals the approach.
    error : (k,) ndarray
        Largest gap at a point under pressure, or largest overlap (except at yielded points), divided by the rms
        deviation of the gap or, if larger, of the displacements under a uniform pressure.
    iterations : (k,) ndarray of int
        Number of iterations on the finest grid.
    contact_count : (k,) ndarray of int
        Number of patches of connected points.
    contact_area : (k,) ndarray, µm²
        Real contact area along the interface, corrected for grid edges; never below load over hardness.
    normal_elastic : (k,) ndarray, mN
        Σ F n_z minus the attraction.
    tangential_elastic : (k,) or (d, k) ndarray, mN
        -Σ F s·n over opposing patches, or over all patches.
    normal_frictional, tangential_frictional : (k,) or (d, k) ndarray, mN per unit mu0
        Σ F t_z and -Σ F s·t over opposing patches, or over all patches.
    normal_adhesive, tangential_adhesive : (k,) or (d, k) ndarray, mN per GPa of tau0
        Σ A t_z and -Σ A s·t over opposing patches, or over all patches.
    load_share_at_hardness, area_share_at_hardness : (k,) ndarray
        Fraction of the load on yielded points, and fraction of the points under pressure that have yielded.
    contact_load : (k,) ndarray, mN
        Sum of the pressures: the load plus the attraction of adhering surfaces.
    effective_modulus : float, GPa
        E* of the pair.

    Examples
    --------
    >>> from stiction import half_space, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> curve = half_space(upper, lower, ["1 mN", "2 mN"], direction=[0, 90], sliding="all")
    >>> curve.friction_coefficient(mu0=0.3).round(2)
    array([[0.3 , 0.3 ],
           [0.31, 0.31]])
    """

    load: Floats = field(metadata={"unit": "mN"})
    approach: Floats = field(metadata={"unit": "µm"})
    closure: Floats = field(metadata={"unit": "µm"})
    error: Floats
    iterations: NDArray[np.int64]
    contact_count: NDArray[np.int64]
    contact_area: Floats = field(metadata={"unit": "µm²"})
    normal_elastic: Floats = field(metadata={"unit": "mN"})
    tangential_elastic: Floats = field(metadata={"unit": "mN"})
    normal_frictional: Floats = field(metadata={"unit": "mN per unit mu0"})
    tangential_frictional: Floats = field(metadata={"unit": "mN per unit mu0"})
    normal_adhesive: Floats = field(metadata={"unit": "mN per GPa of tau0"})
    tangential_adhesive: Floats = field(metadata={"unit": "mN per GPa of tau0"})
    load_share_at_hardness: Floats
    area_share_at_hardness: Floats
    contact_load: Floats = field(metadata={"unit": "mN"})
    effective_modulus: float = field(metadata={"unit": "GPa"})
    _problem: HalfSpaceProblem = field(repr=False)
    _model: ContactModel = field(repr=False)
    _contact_solutions: tuple[ContactSolution, ...] = field(repr=False)
    _sums: PatchSums = field(repr=False)
    _tolerance: float = field(repr=False)
    _record: SolutionRecord = field(default_factory=SolutionRecord, repr=False)

    @property
    def pull_off(self) -> float:
        """Largest tension (mN) that the surfaces support when they are pulled apart after the smallest load.

        The force is computed on first use. The bodies separate at a tension at most 1 % larger. If the computation did
        not converge, a warning contains "at least", and `pull_off_is_bound` is True.
        """
        force, is_bound = self.pull_off_bound
        if is_bound:
            warn_caller(f"the pull-off force is at least {force:.4g} mN: {self._separation_solutions[1]}")
        return force

    @property
    def pull_off_is_bound(self) -> bool:
        """True if the pull-off force may exceed `pull_off`, which is then only a lower bound."""
        return self.pull_off_bound[1]

    @property
    def pull_off_bound(self) -> tuple[float, bool]:
        """Pull-off force (mN), and a flag that is True if this force is only a lower bound.

        Gives no warning, unlike `pull_off`.
        """
        if self.work_of_adhesion == 0:
            return 0.0, False
        return -self._separation_solutions[0][-1].load, bool(self._separation_solutions[1])

    @property
    def parting(self) -> HalfSpaceCurve:
        """Load curve of the surfaces as they are pulled apart, from the smallest load to the pull-off force.

        Raises a `ValueError` if the surfaces do not adhere.
        """
        if self.work_of_adhesion == 0:
            raise ValueError("the curve `parting` requires adhesion; call half_space with a work_of_adhesion above 0")
        return _make_curve(self._problem, self._model, self._separation_solutions[0], self._tolerance, self._record)

    @cached_property
    def _separation_solutions(self) -> tuple[list[ContactSolution], str]:
        """Contact solutions during separation, and the reason why the pull-off force is uncertain ("" if certain)."""
        contact_solution = self._contact_solutions[int(np.argmin(self.load))]
        return solve_separation(contact_solution, tolerance=self._tolerance, record=self._record)

    @property
    def work_of_adhesion(self) -> float:
        """Energy per area, in mN/µm (kJ/m²), that is required to separate the surfaces."""
        return self._problem.work_of_adhesion

    @property
    def adhesion_range(self) -> float:
        """Decay length (µm) of the adhesive attraction.

        The length is the given range or, if larger, the smallest range that the grid resolves.
        """
        return self._problem.adhesion_range

    @cached_property
    def stiffness(self) -> Floats:
        """Normal stiffness dF/dδ (mN/µm) at each load, for an unchanged set of contact points.

        The stiffness is infinite in full periodic contact. It is NaN on a free half-plane, and if the pressure equals
        the hardness everywhere in contact. The stiffness is computed on first use.
        """
        return self._compute_stiffness("stiffness")

    @cached_property
    def closure_stiffness(self) -> Floats:
        """Derivative dp/dc (GPa/µm) of nominal pressure p with respect to closure c, at each load during first loading.

        1 GPa/µm is 1e6 MPa/mm, the usual unit of the normal stiffness of joints.
        """
        return self._compute_stiffness("closure_stiffness")

    @cached_property
    def unloading_closure_stiffness(self) -> Floats:
        """Derivative dp/dc (GPa/µm) of the nominal pressure with respect to the closure, when unloading from each load.

        Yielded points respond elastically as well. A tangential load starts to move the contact elastically, too: the
        initial tangential stiffness per nominal area is this stiffness times E*_t/E*.
        """
        return self._compute_stiffness("unloading_closure_stiffness")

    @property
    def tilt(self) -> Floats:
        """Tilt of the upper surface at each load: slopes along y and x for maps, or along x for profiles.

        The slopes are 0 if the tilt is fixed.
        """
        return make_read_only(
            np.array([np.zeros(self._problem.gap.ndim) + solution.problem.tilt for solution in self._contact_solutions])
        )

    @cached_property
    def unloading_stiffness(self) -> Floats:
        """Unloading stiffness dF/dδ (mN/µm) at each load, also called ultrasonic stiffness.

        Yielded points respond elastically as well.

        The loading stiffness, `stiffness`, is smaller if there is a hardness, because yielded points support no
        additional load.
        """
        return self._compute_stiffness("unloading_stiffness")

    def _compute_stiffness(self, name: str) -> Floats:
        """Return the stiffness with the given name, such as "unloading_stiffness", at each load.

        The compliances of several loads are computed in one call, up to `MAX_POINTS_PER_STEP` grid points.
        """
        if self._problem.has_finite_approach or name.endswith("closure_stiffness"):
            group_size = max(1, MAX_POINTS_PER_STEP // self._problem.gap.size)
            for start in range(0, len(self._contact_solutions), group_size):
                computed_solutions = cache_compliances(
                    self._contact_solutions[start : start + group_size], unloading=name.startswith("unloading")
                )
                if self._problem.work_of_adhesion == 0:
                    num_iterations = sum(solution.iterations for solution in computed_solutions)
                    self._record.counter.add(round(num_iterations * STIFFNESS_TO_SOLUTION_TIME_RATIO))
        return make_read_only(np.array([getattr(solution, name) for solution in self._contact_solutions]))

    def at(self, index: int) -> ContactSolution:
        """Return the contact solution at `load[index]`: contact points with their pressures (GPa) and patch numbers."""
        return self._contact_solutions[resolve_index(index, self.load.size, "loads")]

    def contact(self, index: int) -> HalfSpaceContact:
        """Return the contact at `load[index]` as arrays over the whole grid: pressure (GPa), gap (µm), patch number."""
        load_index = resolve_index(index, self.load.size, "loads")
        solution = self._contact_solutions[load_index]
        problem = solution.problem
        pressure = solution.on_grid(solution.values)
        gap = problem.grids.displacement(pressure - solution.attraction) + problem.gap - solution.approach
        patch_indices = self._sums.first_patch[load_index] + solution.patch - 1
        opposing_grids = [solution.on_grid(mask[patch_indices]) for mask in self._sums.opposes_motion]
        opposing = np.array(opposing_grids).reshape(*self._model.angles().shape, *pressure.shape)
        gap = gap if problem.missing is None else np.where(problem.missing, np.nan, gap)
        field_arrays = (pressure, gap, solution.on_grid(solution.patch), opposing, solution.on_grid(solution.share))
        pressure, gap, patches, opposing, share, heights = map(
            make_read_only, (*field_arrays, problem.lower_heights.copy())
        )
        return HalfSpaceContact(pressure, gap, patches, opposing, share, heights, problem.spacing)

    @property
    def direction(self) -> Floats:
        """Directions of motion of the upper surface, in degrees from +x towards +y."""
        return self._model.angles()

    @property
    def sliding(self) -> SlidingRule:
        """Sliding rule, "opposing" or "all": friction acts at contacts that oppose the motion, or at all contacts."""
        return self._model.sliding

    @property
    def hardness(self) -> float | None:
        """Hardness (GPa), which is the upper limit of the contact pressure.

        None if the bodies do not yield.
        """
        return self._problem.hardness

    def with_sliding(self, sliding: SlidingRule) -> HalfSpaceCurve:
        """Return a load curve for another sliding rule without computing the contacts again."""
        return self._with_contact_sums(replace(self._model, sliding=sliding), self._sums)

    def with_direction(self, direction: Direction | Sequence[Direction]) -> HalfSpaceCurve:
        """Return a load curve for other directions of motion without computing the contacts again.

        Parameters
        ----------
        direction : {"+x", "-x"}, float or a sequence of them, degrees
            As for `half_space`.
        """
        model = replace(self._model, direction=direction)
        if self._problem.gap.ndim == 1:
            model = model.for_profiles()
        return self._with_contact_sums(model, sum_friction_over_patches(self._contact_solutions, model.directions()))

    def onset(
        self,
        index: int,
        *,
        mu0: float,
        tau0: float = 0.0,
        direction: Direction = 0.0,
        steps: int | Sequence[float] = 20,
        displacements: ArrayLike | None = None,
        poisson: float | Sequence[float] = 0.3,
        tolerance: float = 1e-6,
    ) -> Onset:
        """Compute the onset of sliding at the normal load `load[index]`; see `Onset`.

        Parameters
        ----------
        index, mu0, tau0, steps, displacements
            As for `Onset`.
        direction : {"+x", "-x"} or float, degrees
            Direction of the tangential load. It has no effect, because the kernel is the same for all directions.
        poisson : float or two of them
            Poisson's ratio of both bodies, or of the upper and of the lower body. It has no effect on profiles.
        tolerance : float
            Largest deviation of sticking points from the displacement of the upper surface, relative to the rms
            deviation of the displacements at sliding, scaled in proportion to the load.

        Raises
        ------
        ValueError
            If an argument is outside its range, or mu0 and tau0 are both 0.
        RuntimeError
            If the error of a step exceeds the tolerance.
        """
        mu0, tau0 = validate_nonzero_strengths(mu0, tau0, self.effective_modulus)
        angle = parse_direction(direction, line=self._problem.gap.ndim == 1)
        contact_solution = self._contact_solutions[resolve_index(index, self.load.size, "loads")]
        tangential_problem = HalfSpaceTangentialProblem(
            contact_solution, mu0=mu0, tau0=tau0, poisson=poisson, tolerance=tolerance
        )
        return compute_onset(
            tangential_problem, mu0=mu0, tau0=tau0, direction=angle, steps=steps, displacements=displacements
        )

    def compute_directed_sums(
        self, directions: Sequence[Direction], sliding_rules: Sequence[SlidingRule]
    ) -> dict[str, Floats]:
        """Compute the sums of forces and areas that change with the direction of motion or with the sliding rule.

        Each sum has the shape (sliding rules, directions, loads).
        """
        unit_vectors = replace(self._model, direction=tuple(directions)).directions()
        sums = self._sums
        if not np.array_equal(unit_vectors, self._model.directions()):
            sums = sum_friction_over_patches(self._contact_solutions, unit_vectors)
        totals = zip(*(sums.directed_totals(sliding) for sliding in sliding_rules), strict=True)
        return {name: np.array(values) for name, values in zip(DIRECTED_TOTAL_NAMES, totals, strict=True)}

    def _with_contact_sums(self, model: ContactModel, sums: PatchSums) -> HalfSpaceCurve:
        totals = _compute_contact_sums(model, self._contact_solutions, sums)
        changed_fields: dict[str, Any] = {name: make_read_only(values) for name, values in totals.items()}
        return replace(self, **changed_fields, _model=model, _sums=sums)


def half_space(
    upper: BodyLike,
    lower: BodyLike,
    loads: ArrayLike | None = None,
    *,
    spacing: Any = None,
    unit: str = "um",
    approaches: ArrayLike | None = None,
    effective_modulus: float | None = None,
    boundary: BoundaryCondition = "free",
    compliance_share: float = 0.5,
    hardness: float | None = None,
    tilt: TiltMode = "fixed",
    direction: Direction | Sequence[Direction] = "+x",
    sliding: SlidingRule = "opposing",
    work_of_adhesion: float | str = 0.0,
    adhesion_range: float | str = DEFAULT_ADHESION_RANGE,
    tolerance: float = 1e-6,
    progress: Callable[[int, int, float], object] | None = None,
    record: SolutionRecord | None = None,
) -> HalfSpaceCurve:
    """Compute contact pressure, true contact area and friction of two rough surfaces in the half-space model.

    Parameters
    ----------
    upper, lower : Profile, Surface or array_like
        Two profiles or two surfaces on the same grid. Missing points make no contact.
    loads : (k,) array_like of float, mN
        Above 0 and strictly increasing; or a string, "10 mN" or "10 MPa" on the measured area, or a list of strings.
        Profiles have a width of 1 µm. Adhering surfaces accept external loads of any sign, which increase as the
        surfaces approach or decrease as they separate.
    spacing : float (µm) or str, or a pair (y, x) of either, optional
        Distance of the points, for arrays.
    unit : str
        Unit of the heights of arrays.
    approaches : (k,) array_like of float, µm
        Displacements of the upper surface since first contact, instead of loads. They are measured at points far away,
        or at the mean plane if periodic. Above 0 and strictly increasing; or strings, "5 nm". For each approach, about
        six contact problems are solved.
    effective_modulus : float, GPa
        E*, with 1/E* = (1 - ν1²)/E1 + (1 - ν2²)/E2. By default 10 GPa for generated surfaces; required for surfaces
        that were read from files.
    boundary : {"free", "periodic"}
        Boundary of the contact: "free" if no material lies beyond the edges, "periodic" if the surfaces continue
        periodically.
    compliance_share : float
        c_l = E* (1 - ν_l²)/E_l, the lower body's fraction of the compliance, from 0 to 1. The deformed interface is (1
        - c_l) z_l + c_l z_u plus a constant.
    hardness : float, GPa, optional
        Largest possible pressure of elastic, perfectly plastic bodies in first loading.
    tilt : {"fixed", "free"}
        "fixed": the upper surface keeps its orientation. "free": it rotates about its centre, as on a ball joint, until
        the resultant of the pressures passes through the centre, to 1e-4 of its length. Approaches then refer to the
        centre.
    direction : {"+x", "-x"}, float or a sequence of them
        Direction in which the upper surface is about to move; on surfaces also an angle in degrees from +x towards +y.
    sliding : {"opposing", "all"}
        Patches that contribute to friction: only patches whose force on the upper surface points against the motion, or
        all patches.
    work_of_adhesion : float, mN/µm (kJ/m²)
        Energy w to separate a unit area; or a string, "50 mJ/m^2". The attraction w/ρ exp(-gap/ρ) adds to the load.
    adhesion_range : float, µm
        Decay length ρ; or a string, "0.5 nm". Increased, with a warning, until the process zone E* ρ²/w has two grid
        points.
    tolerance : float
        Largest accepted `error` of `HalfSpaceCurve`. Approaches have the same tolerance in the same unit. With
        adhesion, the mean error of the attraction is at most ten times the tolerance, relative to the mean contact
        pressure plus the mean attraction. At single points the error can be larger; in a test with the default
        tolerance it reached 4e-4 w/ρ.
    progress : callable, optional
        Function that is called in every iteration on the finest grid, with the number of solved loads or approaches,
        the iteration and the current error. An exception in this function, such as from Ctrl-C, ends the computation.
    record : SolutionRecord, optional
        Counter of the iterations, which may also store the contacts at finished loads. `run` uses it to resume.

    Returns
    -------
    curve : HalfSpaceCurve
        Load (mN), approach (µm), real contact area (µm²) and the sums that determine friction, at every load.

    Raises
    ------
    ValueError
        If the grids differ or an argument is outside its range. Approaches are rejected on free half-planes, with a
        hardness, and if all points of periodic surfaces would touch. A free tilt requires loads of free bodies without
        adhesion.
    RuntimeError
        If the error at a load exceeds the tolerance, the search for a free tilt does not converge, or adhering surfaces
        separate before a load is reached.

    See Also
    --------
    press : Asperity model, faster and without interaction of the contacts.
    resolution : Dependence on the shortest wavelength of the scans.

    Notes
    -----
    Find p ≥ 0 with the gap g = z_u - z_l + u - δ ≥ 0 and p g = 0, where û = 2/(E* k) p̂ and k is the magnitude of the
    wave vector (Johnson, Contact Mechanics, 1985, sections 2.3, 3.2 and 13.2). `scipy.fft.set_workers` sets the number
    of threads.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, half_space
    >>> x = np.arange(512) / 512
    >>> wave = Profile(0.01 * np.cos(2 * np.pi * x), spacing=1 / 512)
    >>> flat = Profile(np.zeros(512), spacing=1 / 512)
    >>> curve = half_space(flat, wave, [0.1], boundary="periodic")
    >>> curve.contact_area.round(2)  # Westergaard: 2/π arcsin (p/p*)^(1/2) = 0.385
    array([0.38])
    """
    upper, lower = as_bodies(upper, lower, spacing=spacing, unit=unit)
    check_pair(upper, lower, whole=False)
    model = ContactModel(
        effective_modulus=modulus_or_default(effective_modulus, upper, lower), direction=direction, sliding=sliding
    )
    if isinstance(upper, Profile):
        model.for_profiles()
    check_choice("boundary", boundary, BoundaryCondition)
    check_choice("tilt", tilt, TiltMode)
    tolerance = validate_number("tolerance", tolerance, above=0, below=1)
    if not (progress is None or callable(progress)):
        raise ValueError(f"progress must be a function of three arguments or None, got {short_repr(progress)}")
    problem = make_problem(
        upper, lower, float(model.effective_modulus), periodic=boundary == "periodic",
        compliance_share=validate_fraction("compliance_share", compliance_share),
        hardness=None if hardness is None else validate_number("hardness", hardness, unit="GPa", above=0),
    )  # fmt: skip
    converted_work_of_adhesion, converted_adhesion_range = (
        validate_number(name, to_core_units(name, value, kind), unit=unit, above=above)
        for name, value, kind, unit, above in (
            ("work_of_adhesion", work_of_adhesion, "work of adhesion", "mN/µm", -math.ulp(0)),
            ("adhesion_range", adhesion_range, "length", "µm", 0),
        )
    )
    if converted_work_of_adhesion > 0:
        for body in (upper, lower):
            reject_missing_points(body, "work_of_adhesion")
        problem = _add_adhesion(
            problem, converted_work_of_adhesion, converted_adhesion_range, float(model.effective_modulus)
        )
    if tilt == "free":
        if boundary == "periodic" or converted_work_of_adhesion > 0 or approaches is not None:
            raise ValueError(
                "tilt must be 'fixed' if the surfaces are periodic or adhesive, or if approaches are given, got 'free'"
            )
        problem = replace(problem, has_free_tilt=True)
    loads, approaches = (
        [given_values] if isinstance(given_values, str) else given_values for given_values in (loads, approaches)
    )
    loads = loads_to_core_units("loads", loads, problem.nominal_area)
    step_kind, step_values = parse_loads_or_approaches(
        problem, loads, to_core_units("approaches", approaches, "length")
    )
    warn_if_same_body(upper, lower)
    record = SolutionRecord() if record is None else record
    check_instance("record", record, SolutionRecord, "a SolutionRecord")
    solutions = _solve_contacts(problem, step_kind, step_values, tolerance=tolerance, progress=progress, record=record)
    return _make_curve(problem, model, solutions, tolerance, record)


def _solve_contacts(
    problem: HalfSpaceProblem, step_kind: StepKind, steps: Floats, *, tolerance: float,
    progress: Callable[[int, int, float], object] | None, record: SolutionRecord,
) -> list[ContactSolution]:  # fmt: skip
    """Solve the half-space contact at each load (mN) or at each approach (µm)."""
    if problem.work_of_adhesion > 0:
        return solve_with_adhesion(problem, steps, tolerance=tolerance, progress=progress, record=record)
    if problem.has_free_tilt:
        return solve_with_balanced_tilt(problem, steps, tolerance=tolerance, progress=progress, record=record)
    solver = ContactSolver(problem, step_kind, steps[-1], tolerance=tolerance, report=None, record=record)
    solutions: list[ContactSolution] = []
    group_size = max(1, MAX_POINTS_PER_STEP // problem.gap.size)
    for start in range(0, steps.size, group_size):
        last_solution = solutions[-1] if solutions else None
        solve_group = functools.partial(
            solver.contacts_at,
            steps[start : start + group_size],
            near=None if last_solution is None else last_solution.on_grid(last_solution.values).ravel(),
            progress=None if progress is None else functools.partial(_report_progress, progress, start),
        )
        solutions += from_step_result(problem, record.run_step(solve_group, NoSolutionError))
    return solutions


def _report_progress(
    progress: Callable[[int, int, float], object], num_solved: int, index: int, iteration: int, error: float
) -> None:
    """Report the progress of the solver after an iteration at the loading step `index` of a group of steps.

    `num_solved` steps precede the group.
    """
    progress(num_solved + index, iteration, error)


def _add_adhesion(
    problem: HalfSpaceProblem, work: float, adhesion_range: float, effective_modulus: float
) -> HalfSpaceProblem:
    """Add adhesive attraction with a given work of adhesion (mN/µm) and range (µm) to a contact problem.

    If the grid cannot resolve the range, increase the range.
    """
    min_adhesion_range = min_resolved_adhesion_range(work, max(problem.spacing), effective_modulus)
    if min_adhesion_range > adhesion_range:
        warn_caller(
            f"adhesion_range = {adhesion_range * 1e3:.3g} nm is increased to {min_adhesion_range * 1e3:.3g} nm: "
            f"the grid needs {MIN_PROCESS_ZONE_POINTS:g} points in the process zone E* range²/w"
        )
    adhesion_range = max(min_adhesion_range, adhesion_range)
    if problem.hardness is not None and not work / adhesion_range < problem.hardness:
        raise ValueError(
            f"hardness must be above {work / adhesion_range:.3g} GPa, the attraction in contact "
            f"(work_of_adhesion divided by adhesion_range), because the surfaces would otherwise yield without a load; "
            f"got {short_repr(problem.hardness)}"
        )
    return replace(problem, work_of_adhesion=work, adhesion_range=adhesion_range)


def _make_curve(
    problem: HalfSpaceProblem, model: ContactModel, contacts: list[ContactSolution], tolerance: float,
    record: SolutionRecord,
) -> HalfSpaceCurve:  # fmt: skip
    sums = sum_friction_over_patches(contacts, model.directions())
    columns: dict[str, Any] = tabulate_solutions(contacts) | _compute_contact_sums(model, contacts, sums)
    return HalfSpaceCurve(
        **{name: make_read_only(values) for name, values in columns.items()},
        effective_modulus=float(model.effective_modulus), _problem=problem, _model=model,
        _contact_solutions=tuple(contacts), _sums=sums, _tolerance=tolerance, _record=record,
    )  # fmt: skip


def _compute_contact_sums(
    model: ContactModel, contacts: Sequence[ContactSolution], sums: PatchSums
) -> dict[str, Floats]:
    """Return forces and areas summed over all contacts, keyed by name, with contact solutions along the last axis.

    Arrays have the shape (k,) or, if they depend on the direction and the model has a list of d directions, (d, k).
    """
    totals = sums.totals(model.sliding)
    if contacts[0].problem.work_of_adhesion > 0:
        totals["normal_elastic"] = totals["normal_elastic"] - [solution.attraction_force for solution in contacts]
    if model.angles().ndim == 0:
        totals |= {name: totals[name][0] for name in DIRECTED_TOTAL_NAMES}
    return totals


def solve_together_or_separately(
    solve: Callable[[Floats], HalfSpaceCurve], loads: Floats
) -> list[tuple[NDArray[np.intp], HalfSpaceCurve]]:
    """Solve the contacts at all loads together or, if that fails, at each load separately.

    Returns pairs of indices and curve: each curve with the indices of its loads. Loads without a solution are left out.
    """
    try:
        return [(np.arange(loads.size), solve(loads))]
    except NoSolutionError:
        curves = []
        for index in range(loads.size):
            try:
                curves.append((np.array([index]), solve(loads[index : index + 1])))
            except NoSolutionError:
                continue
        return curves


def solve_at_zero_load(solve: Callable[[Floats], HalfSpaceCurve]) -> HalfSpaceCurve | None:
    """Return the contact of adhering surfaces at zero load.

    Returns None if the solver fails.
    """
    try:
        return solve(np.zeros(1))
    except NoSolutionError:
        return None
