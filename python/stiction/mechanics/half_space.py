"""Two rough bodies as one elastic half-space: the exact elastic answer, and friction from it.

For small slopes two elastic bodies in frictionless contact are one gap over one half-space of modulus E*. Friction from
half-space pressures and the slopes that they act on: Karpenko & Akay, Tribology International 34 (2001) 531.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._caching import cached_property
from stiction._checks import Floats, check_choice, fraction, number, read_only
from stiction._repr import PlotRepr, axes_for
from stiction._units import loads_to_core_units, to_core_units
from stiction.mechanics.friction import Curve
from stiction.mechanics.model import ContactModel, Direction, Sliding, check_pair, modulus_for, warn_of_one_body
from stiction.mechanics.onset import Onset, heading, onset_of, place_of, strengths
from stiction.surfaces.profile import Profile, reject_missing
from stiction.surfaces.surface import BodyLike, as_bodies

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stiction.mechanics.half_space_problem import Asked, Pressed, Problem
    from stiction.mechanics.patches import PatchSums

# The solver brings SciPy along, which takes longer to import than all else: where it is used.

Boundary = Literal["free", "periodic"]
Tilt = Literal["fixed", "free"]

ADHESION_RANGE = 5e-4
"""µm over which the attraction of solids falls off unless another range is given: one to two distances of atoms."""

PROCESS_ZONE = 2.0  # points in E* ρ²/w, where the attraction falls off at an edge; with fewer the grid decides


def resolved_range(work: float, spacing: float, effective_modulus: float) -> float:
    """The least range (µm) that a grid resolves, of a work of adhesion in mN/µm, a spacing in µm and E* in GPa."""
    return math.sqrt(PROCESS_ZONE * spacing * work / effective_modulus)


@dataclass(frozen=True, eq=False, repr=False)
class HalfSpaceContact(PlotRepr):
    """The contact at one load, over the grid; all arrays are read-only.

    Attributes
    ----------
    pressure : ndarray, GPa
    gap : ndarray, µm
        Between the deformed bodies: 0 in contact, to the tolerance; below 0 where the hardness caps the pressure; NaN
        where points are missing.
    patches : ndarray of int
        Number of the patch that a point under pressure belongs to, from 1 on; 0 where there is no pressure. Points
        are connected with all their neighbours, on areas eight, and over the edges where periodic.
    opposing : ndarray of bool
        Where a point's patch opposes the motion; a first axis of d directions where they were given.
    share : ndarray
        Of a point's cell that is in contact: 0 where there is no pressure, below 1 at the edges of patches. With the
        area of a cell its sum is the true area on the ground plan.
    heights : ndarray, µm
        Of the lower body, before it is deformed.
    spacing : tuple of float, µm
        Of the points along y and x, or x.

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
        """Draw the pressure over the heights of the lower body: a map with a bar for its scale, or both over x.

        Into given axes, or by default new ones, which are returned.
        """
        from stiction._drawing import draw_contact

        return draw_contact(axes_for(ax), self.pressure, self.heights, self.spacing)


@dataclass(frozen=True, eq=False, repr=False)
class HalfSpaceCurve(Curve):
    """Contact of two bodies as an elastic half-space at each load, for every mu0 and tau0; all arrays are read-only.

    Sums over points under pressure, as `LoadCurve` has them over asperities: n is the normal of the deformed interface
    at a point, t the tangent, s the direction; a patch opposes where its force on the upper body points against s. What
    depends on the direction is (k,), or (d, k) where d directions were given.

    Attributes
    ----------
    load : (k,) ndarray, mN
        What was asked for, or what the approaches take.
    approach : (k,) ndarray, µm
        Displacement of the upper body since first touch: of its far points, or of its mean plane where periodic. NaN on
        a free half-plane, whose far points have no limit.
    closure : (k,) ndarray, µm
        Mean gap that was lost since first touch: the approach less the mean displacement, without the bending of free
        bodies under the load, which is what is measured across a joint. Of periodic bodies it is the approach.
    error : (k,) ndarray
        No point under pressure is open by more than this, and no point overlaps by more (but where the pressure is at
        the hardness), in root-mean-square deviations of the gap (of the displacements under an even pressure, where
        that is more).
    iterations : (k,) ndarray of int
        On the finest grid.
    contact_count : (k,) ndarray of int
        Patches of connected points.
    contact_area : (k,) ndarray, µm²
        True area along the interface, less what a grid's edges add; never below load over hardness.
    normal_elastic : (k,) ndarray, mN
        Σ F n_z, less the attraction.
    tangential_elastic : (k,) or (d, k) ndarray, mN
        -Σ F s·n over opposing patches, or all.
    normal_frictional, tangential_frictional : (k,) or (d, k) ndarray, mN per unit mu0
        Σ F t_z and -Σ F s·t over opposing patches, or all.
    normal_adhesive, tangential_adhesive : (k,) or (d, k) ndarray, mN per GPa of tau0
        Σ A t_z and -Σ A s·t over opposing patches, or all.
    load_share_at_hardness, area_share_at_hardness : (k,) ndarray
        Of the load and of the points under pressure where the pressure is the hardness.
    contact_load : (k,) ndarray, mN
        Of the pressures: the load and, where bodies adhere, the attraction between them.
    effective_modulus : float, GPa

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
    _problem: Problem = field(repr=False)
    _model: ContactModel = field(repr=False)
    _pressed: tuple[Pressed, ...] = field(repr=False)
    _sums: tuple[PatchSums, ...] = field(repr=False)
    _tolerance: float = field(repr=False)

    @property
    def pull_off(self) -> float:
        """Largest tension in mN that the bodies bear from the contact of the least load on; 0 without adhesion.

        Computed when first needed. The bodies come off at a tension 1 % above it. Where that is not certain, a warning
        says "at least", and `pull_off_is_bound` is True.
        """
        force, is_bound = self.pull_off_bound
        if is_bound:
            warnings.warn(f"the pull-off force is at least {force:.4g} mN: {self._apart[1]}", stacklevel=2)
        return force

    @property
    def pull_off_is_bound(self) -> bool:
        """Whether the pull-off force is at least `pull_off`, because a larger one is not excluded."""
        return self.pull_off_bound[1]

    @property
    def pull_off_bound(self) -> tuple[float, bool]:
        """Return `pull_off` (mN) and `pull_off_is_bound`, without a warning."""
        if self.work_of_adhesion == 0:
            return 0.0, False
        return -self._apart[0][-1].load, bool(self._apart[1])

    @property
    def parting(self) -> HalfSpaceCurve:
        """The contacts through which bodies go that are drawn apart from that of the least load, to the pull-off force.

        Raises a `ValueError` without adhesion, where nothing holds them.
        """
        if self.work_of_adhesion == 0:
            raise ValueError("parting is of bodies that adhere; give half_space a work_of_adhesion above 0")
        return _curve(self._problem, self._model, self._apart[0], self._tolerance)

    @cached_property
    def _apart(self) -> tuple[list[Pressed], str]:
        """The contacts on the way apart, and why they end before the bodies part, if they do."""
        from stiction.mechanics.adhesion import drawn_apart

        return drawn_apart(self._pressed[int(np.argmin(self.load))], tolerance=self._tolerance)

    @property
    def work_of_adhesion(self) -> float:
        """Energy in mN/µm (kJ/m²) that it takes to part an area in contact."""
        return self._problem.work_of_adhesion

    @property
    def adhesion_range(self) -> float:
        """Gap in µm over which the attraction falls off by 1/e: that given, or the least that the grid resolves."""
        return self._problem.adhesion_range

    @cached_property
    def stiffness(self) -> Floats:
        """(k,) dF/dδ, mN/µm, of the patches as they are; infinite at full contact of periodic bodies.

        NaN on a free half-plane, and where all pressure is at the hardness. Computed when first asked for.
        """
        return read_only(np.array([one.stiffness for one in self._pressed]))

    @cached_property
    def closure_stiffness(self) -> Floats:
        """(k,) dp/dc of the nominal pressure over the closure in the first loading, GPa/µm. Computed when first needed.

        1 GPa/µm is 1e6 MPa/mm, the unit in which the normal stiffness of joints is given.
        """
        return read_only(np.array([one.closure_stiffness for one in self._pressed]))

    @property
    def tilt(self) -> Floats:
        """(k, 2) or (k, 1) slopes along y and x, or x, by which the upper body has turned; 0 where it is fixed."""
        return read_only(np.array([np.zeros(self._problem.gap.ndim) + one.problem.tilt for one in self._pressed]))

    @cached_property
    def unloading_stiffness(self) -> Floats:
        """(k,) dF/dδ, mN/µm, as bodies unload or as ultrasound feels them: elastic at points that have yielded, too.

        That of loading, `stiffness`, is smaller where there is a hardness, because such points carry no more.
        """
        return read_only(np.array([one.unloading_stiffness for one in self._pressed]))

    def at(self, index: int) -> Pressed:
        """Points under pressure at `load[index]`, their pressures and patches."""
        return self._pressed[place_of(index, self.load.size, "loads")]

    def contact(self, index: int) -> HalfSpaceContact:
        """Pressure, gap and patches at `load[index]`."""
        place = place_of(index, self.load.size, "loads")
        one, sums = self._pressed[place], self._sums[place]
        problem = one.problem
        pressure = one.on_grid(one.values)
        gap = problem.grids.displacement(pressure - one.attraction) + problem.gap - one.approach
        each = [one.on_grid(opposes[one.patch - 1]) for opposes in sums.opposing]
        opposing = np.array(each).reshape(*self._model.angles().shape, *pressure.shape)
        gap = gap if problem.missing is None else np.where(problem.missing, np.nan, gap)
        values = (pressure, gap, one.on_grid(one.patch), opposing, one.on_grid(one.share))
        pressure, gap, patches, opposing, share, heights = map(read_only, (*values, problem.lower.copy()))
        return HalfSpaceContact(pressure, gap, patches, opposing, share, heights, problem.spacing)

    @property
    def direction(self) -> Floats:
        """Degrees from +x towards +y, () or (d,): where the upper body is about to move."""
        return self._model.angles()

    @property
    def sliding(self) -> Sliding:
        """Which patches rub: "opposing" or "all"."""
        return self._model.sliding

    @property
    def hardness(self) -> float | None:
        """GPa that no pressure exceeds; None where bodies do not yield."""
        return self._problem.hardness

    def with_sliding(self, sliding: Sliding) -> HalfSpaceCurve:
        """The same contacts by a sliding rule, "opposing" or "all"; nothing is solved again."""
        return self._by(replace(self._model, sliding=sliding), self._sums)

    def with_direction(self, direction: Direction | Sequence[Direction]) -> HalfSpaceCurve:
        """The same contacts where the upper body is about to move elsewhere; nothing is solved again.

        Parameters
        ----------
        direction : {"+x", "-x"}, float or a sequence of them, degrees
            As for `half_space`.
        """
        model = replace(self._model, direction=direction)
        if self._problem.gap.ndim == 1:
            model = model.for_profiles()
        return self._by(model, tuple(one.sums(model.directions()) for one in self._pressed))

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
        """How the bodies begin to slide at `load[index]`, see `Onset`.

        Parameters
        ----------
        index, mu0, tau0, steps, displacements
            As for `Onset`.
        direction : {"+x", "-x"} or float, degrees
            Where the upper body is pushed, which changes nothing: the kernel is the same for all directions.
        poisson : float or two of them
            Of both bodies, or of the upper and the lower. On profiles nothing depends on it.
        tolerance : float
            Of points that stick: how far they are from the upper body's displacement, in root-mean-square deviations
            of the displacements at sliding, in proportion to the load.

        Raises
        ------
        ValueError
            If an argument is outside its range, or mu0 and tau0 are both 0.
        RuntimeError
            If a step's error does not reach the tolerance.
        """
        from stiction.mechanics.mindlin import HalfSpace

        mu0, tau0 = strengths(mu0, tau0, self.effective_modulus)
        angle = heading(direction, line=self._problem.gap.ndim == 1)
        pressed = self._pressed[place_of(index, self.load.size, "loads")]
        held = HalfSpace(pressed, mu0=mu0, tau0=tau0, poisson=poisson, tolerance=tolerance)
        return onset_of(held, mu0=mu0, tau0=tau0, direction=angle, steps=steps, displacements=displacements)

    def _by(self, model: ContactModel, sums: tuple[PatchSums, ...]) -> HalfSpaceCurve:
        rows = _totals(model, self._pressed, sums)
        return replace(self, **_columns(rows, model), _model=model, _sums=sums)


def half_space(
    upper: BodyLike,
    lower: BodyLike,
    loads: ArrayLike | None = None,
    *,
    spacing: Any = None,
    unit: str = "um",
    approaches: ArrayLike | None = None,
    effective_modulus: float | None = None,
    boundary: Boundary = "free",
    compliance_share: float = 0.5,
    hardness: float | None = None,
    tilt: Tilt = "fixed",
    direction: Direction | Sequence[Direction] = "+x",
    sliding: Sliding = "opposing",
    work_of_adhesion: float | str = 0.0,
    adhesion_range: float | str = ADHESION_RANGE,
    tolerance: float = 1e-6,
    progress: Callable[[int, int, float], object] | None = None,
) -> HalfSpaceCurve:
    """Pressure, true area and friction of two rough bodies as an elastic half-space.

    Parameters
    ----------
    upper, lower : Profile, Surface or array_like
        Two of a kind on the same grid. Where points of one are missing nothing touches.
    loads : (k,) array_like of float, mN
        Above 0 and strictly increasing; or text, "10 mN" or on the measured area "10 MPa", or a list of such. A profile
        is 1 µm thick. Of bodies that adhere they are what is pressed from outside, of any sign: increasing as bodies
        come near, or decreasing as they are drawn apart.
    spacing : float (µm) or str, or a pair (y, x) of either, optional
        Distance of the points of bodies that are arrays.
    unit : str
        Unit of the heights of arrays.
    approaches : (k,) array_like of float, µm
        In place of loads: displacements of the upper body since first touch, of its far points, or of its mean plane
        where periodic. Above 0 and strictly increasing; or text, "5 nm". Each takes some six solutions, in search of
        its load.
    effective_modulus : float, GPa
        E*, with 1/E* = (1 - ν1²)/E1 + (1 - ν2²)/E2. By default 10 GPa of generated bodies; of those that were read from
        files it must be given.
    boundary : {"free", "periodic"}
        Whether nothing lies beyond the edges, or the bodies again and again.
    compliance_share : float
        c_l = E* (1 - ν_l²)/E_l, the lower body's share of the compliance, from 0 to 1: the deformed interface is
        (1 - c_l) z_l + c_l z_u, but for a constant.
    hardness : float, GPa, optional
        The most that the pressure can be: elastic, perfectly plastic, in the first loading.
    tilt : {"fixed", "free"}
        Whether the upper body keeps its orientation, or turns about its middle until the resultant of the pressures is
        there, to 1e-4 of its length, as on a ball joint. Approaches are then those of the middle.
    direction : {"+x", "-x"}, float or a sequence of them
        Where the upper body is about to move; on surfaces also an angle in degrees from +x towards +y.
    sliding : {"opposing", "all"}
        Whether only patches rub whose force on the upper body points against the motion, or all.
    work_of_adhesion : float, mN/µm (kJ/m²)
        Energy w that it takes to part an area; or text, "50 mJ/m^2". The attraction w/ρ exp(-gap/ρ) adds to the load.
    adhesion_range : float, µm
        The length ρ; or text, "0.5 nm". Raised to where the grid has two points in the process zone E* ρ²/w, with a
        warning.
    tolerance : float
        Of the error, see `HalfSpaceCurve`, and a tenth of that of the attraction. Approaches are met to it, in the
        same unit.
    progress : callable, optional
        Called in each iteration on the finest grid with how many loads or approaches are solved, the number of the
        iteration and the error so far. An exception that it raises, as Ctrl-C does, ends the computation.

    Raises
    ------
    ValueError
        If the grids differ or an argument is outside its range; approaches also on free half-planes, which have none,
        with a hardness, and from the one on at which all points of periodic bodies touch; a free tilt with any but
        loads of free bodies without adhesion.
    RuntimeError
        If a load's error does not reach the tolerance, no tilt balances the bodies, or those that adhere come off
        before a load is reached.

    Notes
    -----
    Find p ≥ 0 with the gap g = z_u - z_l + u - δ ≥ 0, p g = 0 and, k being the length of
    a wave vector, û = 2/(E* k) p̂ (Johnson, Contact Mechanics,
    1985, sections 2.3, 3.2 and 13.2). `scipy.fft.set_workers` says how many threads the transforms use.

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
    from stiction.mechanics.half_space_problem import problem_of, steps_of

    upper, lower = as_bodies(upper, lower, spacing=spacing, unit=unit)
    check_pair(upper, lower, whole=False)
    model = ContactModel(
        effective_modulus=modulus_for(effective_modulus, upper, lower), direction=direction, sliding=sliding
    )
    if isinstance(upper, Profile):
        model.for_profiles()
    check_choice("boundary", boundary, Boundary)
    check_choice("tilt", tilt, Tilt)
    tolerance = number("tolerance", tolerance, above=0, below=1)
    if not (progress is None or callable(progress)):
        raise ValueError(f"progress must be a function of three arguments or None, got {progress!r}")
    problem = problem_of(
        upper, lower, float(model.effective_modulus), periodic=boundary == "periodic",
        compliance_share=fraction("compliance_share", compliance_share),
        hardness=None if hardness is None else number("hardness", hardness, unit="GPa", above=0),
    )  # fmt: skip
    work, length = (
        number(name, to_core_units(name, given, kind), unit=unit, above=above)
        for name, given, kind, unit, above in (
            ("work_of_adhesion", work_of_adhesion, "work of adhesion", "mN/µm", -math.ulp(0)),
            ("adhesion_range", adhesion_range, "length", "µm", 0),
        )
    )
    if work > 0:
        for body in (upper, lower):
            reject_missing(body, "work_of_adhesion")
        problem = _sticky(problem, work, length, float(model.effective_modulus))
    if tilt == "free":
        if boundary == "periodic" or work > 0 or approaches is not None:
            raise ValueError("tilt must be 'fixed' but for loads of free bodies without adhesion, got 'free'")
        problem = replace(problem, turns=True)
    loads, approaches = ([given] if isinstance(given, str) else given for given in (loads, approaches))
    loads = loads_to_core_units("loads", loads, problem.area)
    name, steps = steps_of(problem, loads, to_core_units("approaches", approaches, "length"))
    warn_of_one_body(upper, lower)
    contacts = _pressed(problem, name, steps, tolerance=tolerance, progress=progress)
    return _curve(problem, model, contacts, tolerance)


def _pressed(
    problem: Problem, name: Asked, steps: Floats, *, tolerance: float,
    progress: Callable[[int, int, float], object] | None,
) -> list[Pressed]:  # fmt: skip
    """The contact at each load (mN) or approach (µm)."""
    from stiction.mechanics.half_space_problem import Solver, pressed_of

    if problem.work_of_adhesion > 0:
        from stiction.mechanics.adhesion import sticking

        return sticking(problem, steps, tolerance=tolerance, progress=progress)
    if problem.turns:
        from stiction.mechanics.tilt import balanced

        return balanced(problem, steps, tolerance=tolerance, progress=progress)
    contacts: list[Pressed] = []
    report = None if progress is None else lambda iteration, error: progress(len(contacts), iteration, error)
    solver = Solver(problem, name, steps[-1], tolerance=tolerance, report=report)
    near = None
    for step in steps.tolist():
        solution = solver.at(step, near)
        near = solution.pressure
        contacts.append(pressed_of(problem, solution, step if name == "loads" else None, scale=solver.scale))
    return contacts


def _sticky(problem: Problem, work: float, length: float, effective_modulus: float) -> Problem:
    """A problem with a work of adhesion (mN/µm) over a range (µm); a warning says where the grid needs a longer one."""
    least = resolved_range(work, max(problem.spacing), effective_modulus)
    if least > length:
        warnings.warn(
            f"adhesion_range = {length * 1e3:.3g} nm is raised to {least * 1e3:.3g} nm: the grid needs "
            f"{PROCESS_ZONE:g} points in the process zone E* range²/w, as of a range of 0",
            stacklevel=3,
        )
    length = max(least, length)
    if problem.hardness is not None and not work / length < problem.hardness:
        raise ValueError(
            f"hardness must be above the attraction in contact, {work / length:.3g} GPa (work_of_adhesion over "
            f"adhesion_range), under which bodies flow without a load, got {problem.hardness!r}"
        )
    return replace(problem, work_of_adhesion=work, adhesion_range=length)


def _curve(problem: Problem, model: ContactModel, contacts: list[Pressed], tolerance: float) -> HalfSpaceCurve:
    sums = tuple(one.sums(model.directions()) for one in contacts)
    rows = [one.row() | total for one, total in zip(contacts, _totals(model, contacts, sums), strict=True)]
    return HalfSpaceCurve(
        **_columns(rows, model), effective_modulus=float(model.effective_modulus), _problem=problem, _model=model,
        _pressed=tuple(contacts), _sums=sums, _tolerance=tolerance,
    )  # fmt: skip


def _totals(model: ContactModel, contacts: Sequence[Pressed], sums: Sequence[PatchSums]) -> list[dict[str, Any]]:
    totals = [one.total(model.sliding) for one in sums]
    for one, total in zip(contacts, totals, strict=True):
        total["normal_elastic"] -= one.adhering
    return totals


def _columns(rows: list[dict[str, Any]], model: ContactModel) -> dict[str, Any]:
    """(k,) of each quantity, (d, k) of those that depend on the direction if there are several."""
    columns = {}
    for name in rows[0]:
        column = np.array([row[name] for row in rows])
        if column.ndim == 2:
            column = np.ascontiguousarray(column.T) if model.angles().ndim > 0 else column[:, 0].copy()
        columns[name] = read_only(column)
    return columns


def solved(solve: Callable[[Floats], HalfSpaceCurve], loads: Floats) -> list[tuple[NDArray[np.intp], HalfSpaceCurve]]:
    """The curves of a half-space and which loads are theirs; a load without a solution is in none."""
    try:
        return [(np.arange(loads.size), solve(loads))]
    except RuntimeError:
        curves = []
        for index in range(loads.size):
            try:
                curves.append((np.array([index]), solve(loads[index : index + 1])))
            except RuntimeError:
                continue
        return curves


def unloaded(solve: Callable[[Floats], HalfSpaceCurve]) -> HalfSpaceCurve | None:
    """Return the contact at no load of bodies that adhere, or None if it has no solution."""
    try:
        return solve(np.zeros(1))
    except RuntimeError:
        return None
