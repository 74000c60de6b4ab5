"""Two rough bodies as one elastic half-space: the exact elastic answer, and friction from it.

For small slopes two elastic bodies in frictionless contact are one gap over one half-space of modulus E*. Friction from
half-space pressures and the slopes that they act on: Karpenko & Akay, Tribology International 34 (2001) 531.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, choice, float_array, number, part_of_one, read_only
from stiction.mechanics.friction import Curve
from stiction.mechanics.model import EFFECTIVE_MODULUS, ContactModel, Direction, Sliding, check_pair
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    from stiction.mechanics.elastic_pressure import Kernel, Solution

# The solver brings SciPy along, which takes longer to import than all else: where it is used.

Boundary = Literal["free", "periodic"]

WIDTH = 1.0
"""µm, of a profile."""


@dataclass(frozen=True, eq=False)
class HalfSpaceContact:
    """The contact at one load, over the grid; all arrays are read-only.

    Attributes
    ----------
    pressure : ndarray, GPa
    gap : ndarray, µm
        Between the deformed bodies: 0 in contact, to the tolerance; below 0 where the hardness caps the pressure.
    patches : ndarray of int
        Number of the patch that a point under pressure belongs to, from 1 on; 0 where there is no pressure. Points
        are connected with all their neighbours, on areas eight, and over the edges where periodic.
    opposing : ndarray of bool
        Where a point's patch opposes the motion; a first axis of d directions where they were given.
    """

    pressure: Floats
    gap: Floats
    patches: NDArray[np.int64]
    opposing: NDArray[np.bool_]


@dataclass(frozen=True)
class _Problem:
    """Gap (µm, its least is 0), kernel, slopes of the deformed interface and what else belongs to the pair."""

    gap: Floats
    kernel: Kernel
    spacing: tuple[float, ...]
    periodic: bool
    hardness: float | None
    slope: list[Floats]
    model: ContactModel

    @property
    def cell(self) -> float:
        """µm², of a grid point."""
        return float(np.prod(self.spacing)) * (WIDTH if len(self.spacing) == 1 else 1.0)

    @property
    def has_approach(self) -> bool:
        """Whether far points stay: not on a free half-plane."""
        return self.periodic or len(self.spacing) == 2


@dataclass(frozen=True, eq=False)
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
    error : (k,) ndarray
        No point under pressure is open by more than this, and no point overlaps by more (but where the pressure is at
        the hardness), in root-mean-square deviations of the gap (of the displacements under an even pressure, where
        that is more).
    iterations : (k,) ndarray of int
        On the finest grid.
    contact_count : (k,) ndarray of int
        Patches of connected points.
    contact_area : (k,) ndarray, µm²
        True area along the interface, less what a grid's edges add.
    normal_elastic : (k,) ndarray, mN
        Σ F n_z.
    tangential_elastic : (k,) or (d, k) ndarray, mN
        -Σ F s·n over opposing patches, or all.
    normal_frictional, tangential_frictional : (k,) or (d, k) ndarray, mN per unit mu0
        Σ F t_z and -Σ F s·t over opposing patches, or all.
    normal_adhesive, tangential_adhesive : (k,) or (d, k) ndarray, mN per GPa of tau0
        Σ A t_z and -Σ A s·t over opposing patches, or all.
    load_share_at_hardness, area_share_at_hardness : (k,) ndarray
        Of the load and of the points under pressure where the pressure is the hardness.
    effective_modulus : float, GPa
    """

    load: Floats
    approach: Floats
    error: Floats
    iterations: NDArray[np.int64]
    contact_count: NDArray[np.int64]
    contact_area: Floats
    normal_elastic: Floats
    tangential_elastic: Floats
    normal_frictional: Floats
    tangential_frictional: Floats
    normal_adhesive: Floats
    tangential_adhesive: Floats
    load_share_at_hardness: Floats
    area_share_at_hardness: Floats
    effective_modulus: float
    _problem: _Problem = field(repr=False)
    _pressed: tuple[tuple[NDArray[np.int64], Floats], ...] = field(repr=False)

    @cached_property
    def stiffness(self) -> Floats:
        """(k,) dF/dδ, mN/µm, of the patches as they are; infinite at full contact of periodic bodies.

        NaN on a free half-plane, and where all pressure is at the hardness. Computed when first asked for.
        """
        from stiction.mechanics.elastic_pressure import linear_compliance

        problem = self._problem
        stiffness = np.full(self.load.size, np.nan)
        for i in range(self.load.size if problem.has_approach else 0):
            pressure = self._pressure(i)
            free = pressure > 0
            if problem.hardness is not None:
                free &= pressure < problem.hardness
            if free.any():
                compliance = linear_compliance(problem.kernel, free)
                with np.errstate(divide="ignore"):
                    stiffness[i] = problem.cell / np.float64(compliance)
        return read_only(stiffness)

    def contact(self, index: int) -> HalfSpaceContact:
        """Pressure, gap and patches at `load[index]`."""
        from stiction.mechanics.patches import labelled, opposes

        if not -self.load.size <= index < self.load.size:
            raise ValueError(f"index must be one of the {self.load.size} loads, got {index!r}")
        problem = self._problem
        pressure = self._pressure(index)
        potential = problem.kernel.displacement(pressure) + problem.gap
        free = pressure > 0
        if problem.hardness is not None:
            free &= pressure < problem.hardness
        patches, _ = labelled(pressure > 0, periodic=problem.periodic)
        # Where all pressure is at the hardness, the last point to yield just touches.
        zero = potential[free].mean() if free.any() else potential[pressure > 0].max()
        gap = potential - zero
        slope = [along.ravel() for along in problem.slope]
        each = [opposes(pressure.ravel(), slope, patches.ravel(), way) for way in problem.model.directions()]
        opposing = np.array(each).reshape(*problem.model.angles().shape, *pressure.shape)
        return HalfSpaceContact(read_only(pressure), read_only(gap), read_only(patches), read_only(opposing))

    @property
    def direction(self) -> Floats:
        """Degrees from +x towards +y, () or (d,): where the upper body is about to move."""
        return self._problem.model.angles()

    @property
    def sliding(self) -> Sliding:
        """Which patches rub: "opposing" or "all"."""
        return self._problem.model.sliding

    def with_sliding(self, sliding: Sliding) -> HalfSpaceCurve:
        """The same contacts by a sliding rule, "opposing" or "all"; nothing is solved again."""
        return self._by(replace(self._problem.model, sliding=sliding))

    def with_direction(self, direction: Direction | Sequence[Direction]) -> HalfSpaceCurve:
        """The same contacts where the upper body is about to move elsewhere; nothing is solved again.

        Parameters
        ----------
        direction : {"+x", "-x"}, float or a sequence of them
            As for `half_space`.

        Raises
        ------
        ValueError
            If it is no direction, or not one along x on profiles.
        """
        model = replace(self._problem.model, direction=direction)
        return self._by(model.for_profiles() if self._problem.gap.ndim == 1 else model)

    def _by(self, model: ContactModel) -> HalfSpaceCurve:
        problem = replace(self._problem, model=model)
        rows = [_sums(problem, self._pressure(i)) for i in range(self.load.size)]
        return replace(self, **_columns(rows, problem.model), _problem=problem)

    def _pressure(self, index: int) -> Floats:
        points, values = self._pressed[index]
        pressure = np.zeros(self._problem.gap.size)
        pressure[points] = values
        return pressure.reshape(self._problem.gap.shape)


def half_space(
    upper: Profile | Surface,
    lower: Profile | Surface,
    loads: ArrayLike | None = None,
    *,
    approaches: ArrayLike | None = None,
    effective_modulus: float = EFFECTIVE_MODULUS,
    boundary: Boundary = "free",
    compliance_share: float = 0.5,
    hardness: float | None = None,
    direction: Direction | Sequence[Direction] = "+x",
    sliding: Sliding = "opposing",
    tolerance: float = 1e-6,
    progress: Callable[[int, int, float], object] | None = None,
) -> HalfSpaceCurve:
    """Pressure, true area and friction of two rough bodies as an elastic half-space.

    Parameters
    ----------
    upper, lower : Profile or Surface
        Two of a kind on the same grid.
    loads : (k,) array_like of float, mN
        Above 0 and strictly increasing. A profile is 1 µm thick.
    approaches : (k,) array_like of float, µm
        In place of loads: displacements of the upper body since first touch, of its far points, or of its mean plane
        where periodic. Above 0 and strictly increasing. Each takes some five solutions, in search of its load.
    effective_modulus : float, GPa
        E*, with 1/E* = (1 - ν1²)/E1 + (1 - ν2²)/E2.
    boundary : {"free", "periodic"}
        Whether nothing lies beyond the edges, or the bodies again and again.
    compliance_share : float
        c_l = E* (1 - ν_l²)/E_l, the lower body's share of the compliance, from 0 to 1: the deformed interface is
        (1 - c_l) z_l + c_l z_u, but for a constant.
    hardness : float, GPa, optional
        The most that the pressure can be: elastic, perfectly plastic, in the first loading.
    direction : {"+x", "-x"}, float or a sequence of them
        Where the upper body is about to move; on surfaces also an angle in degrees from +x towards +y.
    sliding : {"opposing", "all"}
        Whether only patches rub whose force on the upper body points against the motion, or all.
    tolerance : float
        Of the error, see `HalfSpaceCurve`. Approaches are met to it, in the same unit.
    progress : callable, optional
        Called in each iteration on the finest grid with how many loads or approaches are solved, the number of the
        iteration and the error so far. An exception that it raises, as Ctrl-C does, ends the computation.

    Raises
    ------
    ValueError
        If the grids differ or an argument is outside its range; approaches also on free half-planes, which have none,
        with a hardness, and from the one on at which all points of periodic bodies touch.
    RuntimeError
        If a load's error does not reach the tolerance.

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
    from stiction.mechanics.elastic_pressure import Solver
    from stiction.mechanics.patches import slopes

    check_pair(upper, lower)
    if upper.heights.shape != lower.heights.shape:
        raise ValueError(
            f"upper and lower must have equal shapes, got {upper.heights.shape!r} and {lower.heights.shape!r}"
        )
    name, unit, asked = ("loads", "mN", loads) if approaches is None else ("approaches", "µm", approaches)
    if asked is None or (loads is not None and approaches is not None):
        raise ValueError("half_space takes loads or approaches, one of them")
    steps = float_array(name, asked, ndim=1)
    if not (steps.size > 0 and (steps > 0).all() and (np.diff(steps) > 0).all()):
        raise ValueError(f"{name} must be above 0 {unit} and strictly increasing, got {asked!r}")
    model = ContactModel(effective_modulus=effective_modulus, direction=direction, sliding=sliding)
    modulus = float(model.effective_modulus)
    if isinstance(upper, Profile):
        model.for_profiles()
    choice("boundary", boundary, Boundary)
    share = part_of_one("compliance_share", compliance_share)
    tolerance = number("tolerance", tolerance, above=0, below=1)
    periodic = boundary == "periodic"
    spacing = (upper.spacing,) if isinstance(upper, Profile) else upper.spacing
    gap = upper.heights - lower.heights
    gap -= gap.min()
    if hardness is not None:
        hardness = number("hardness", hardness, unit="GPa", above=0)
    cell = float(np.prod(spacing)) * (WIDTH if gap.ndim == 1 else 1.0)
    if approaches is None:
        most = np.inf if hardness is None else hardness * cell * gap.size
        if not steps[-1] < most:
            raise ValueError(f"loads must be below hardness times area, {most:g} mN, got {loads!r}")
    else:
        if hardness is not None:
            raise ValueError(f"approaches are for bodies without hardness; give loads, got hardness={hardness!r}")
        if not periodic and gap.ndim == 1:
            raise ValueError("approaches: a free half-plane has none; give loads, or boundary='periodic'")
        if periodic and not steps[-1] < gap.mean():
            raise ValueError(f"approaches must be below {gap.mean():g} µm, where all points touch, got {approaches!r}")
    rows: list[dict[str, Any]] = []
    report = None if progress is None else lambda iteration, error: progress(len(rows), iteration, error)
    solver = Solver(gap, spacing, modulus, periodic=periodic, hardness=hardness, tolerance=tolerance, progress=report)
    slope = slopes((1 - share) * lower.heights + share * upper.heights, spacing, periodic=periodic)
    problem = _Problem(gap, solver.kernels[0], spacing, periodic, hardness, slope, model)
    pressed = []
    solution = None
    for step in steps.tolist():
        if approaches is None:
            solution = solver.at(step / (cell * gap.size), near=solution)
        else:
            solution = solver.at_approach(step, near=solution)
        if not solution.error <= tolerance:
            raise RuntimeError(
                f"no solution at {step:g} {unit}: error {solution.error:.2g} after {solution.iterations} iterations, "
                f"above the tolerance {tolerance:g}"
            )
        rows.append(_row(problem, solution) | _sums(problem, solution.pressure))
        points = np.flatnonzero(solution.pressure)
        pressed.append((read_only(points), read_only(solution.pressure.ravel()[points])))
    reached = steps if approaches is None else np.array([values.sum() * cell for _, values in pressed])
    return HalfSpaceCurve(
        load=read_only(reached.copy()),
        **_columns(rows, model),
        effective_modulus=modulus,
        _problem=problem,
        _pressed=tuple(pressed),
    )


def _columns(rows: list[dict[str, Any]], model: ContactModel) -> dict[str, Any]:
    """(k,) of each quantity, (d, k) of those that depend on the direction if there are several."""
    columns = {}
    for name in rows[0]:
        column = np.array([row[name] for row in rows])
        if column.ndim == 2:
            column = np.ascontiguousarray(column.T) if model.angles().ndim > 0 else column[:, 0].copy()
        columns[name] = read_only(column)
    return columns


def _row(problem: _Problem, solution: Solution) -> dict[str, Any]:
    """What one load's solution says without friction."""
    from stiction.mechanics.patches import labelled

    touching = solution.pressure > 0
    pressure = solution.pressure[touching]
    capped = pressure == problem.hardness
    return {
        "approach": solution.approach if problem.has_approach else np.nan,
        "error": solution.error,
        "iterations": solution.iterations,
        "contact_count": labelled(touching, periodic=problem.periodic)[1],
        "load_share_at_hardness": float(pressure[capped].sum() / pressure.sum()),
        "area_share_at_hardness": float(capped.mean()),
    }


def _sums(problem: _Problem, pressure: Floats) -> dict[str, Any]:
    """The sums of `HalfSpaceCurve` at one load."""
    from stiction.mechanics.patches import labelled, sums, true_share

    touching = pressure > 0
    patches, _ = labelled(touching, periodic=problem.periodic)
    return sums(
        pressure[touching] * problem.cell,
        true_share(touching, periodic=problem.periodic) * problem.cell,
        [along[touching] for along in problem.slope],
        patches[touching],
        problem.model.directions(),
        problem.model.sliding,
    )
