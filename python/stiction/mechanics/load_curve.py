"""Load curves: forces and areas summed over all contacts at each approach, from which friction follows.

Hanaor, Gan & Einav (2016), Eqs. 6 and 7.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiction._core
from stiction._checks import Floats, float_array, make_read_only, validate_fraction
from stiction._units import to_core_units
from stiction.mechanics.candidates import Candidates, candidates, find_candidates_and_model
from stiction.mechanics.contact import Contacts, contacts
from stiction.mechanics.friction import ContactSums, FrictionCurve, SurfaceValidity, Validity
from stiction.mechanics.mindlin import AsperityTangentialProblem
from stiction.mechanics.model import (
    ContactModel,
    ContactModelArguments,
    Direction,
    SlidingRule,
    add_model_keywords_to_signature,
    warn_if_same_body,
)
from stiction.mechanics.onset import Onset, compute_onset, parse_direction, resolve_index, validate_nonzero_strengths
from stiction.mechanics.quantities import DIRECTED_SUM_QUANTITIES
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface


@dataclass(frozen=True)
class LoadCurveInputs:
    """Inputs of a load curve: contact candidates or surfaces, and the contact model."""

    bodies: tuple[Any, ...]
    model: ContactModel

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling, without the contact candidates, which are objects of the C++ core."""
        return {"bodies": () if len(self.bodies) == 1 else self.bodies, "model": self.model}

    def at(self, approach: float) -> Contacts:
        """Return all contacts at one approach (µm).

        The contacts do not depend on the direction of motion.
        """
        if not self.bodies:
            raise ValueError(
                "the curve comes from another process and does not contain its contact candidates, which are required "
                "to compute an onset; compute the curve again in this process"
            )
        all_contacts: Contacts = contacts(*self.bodies, approach, model=replace(self.model, shear="+x", direction=None))  # type: ignore[call-overload]
        return all_contacts


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class LoadCurve(FrictionCurve, ContactSums):
    """Loads and contact area of a pair at each approach, for any mu0 and tau0.

    All arrays are read-only.

    Normal and tangential load are linear in the molecular friction coefficient mu0 and the adhesive shear strength
    tau0, so six sums over the contacts determine both. n is the contact normal, t the tangent, s the direction in which
    the upper surface is about to move. "Opposing" contacts have a normal force that opposes the motion, s·n < 0.

    Attributes
    ----------
    approach : (k,) ndarray, µm
        Displacement of the upper surface since first contact.
    contact_count : (k,) ndarray of int
        Number of contacts.
    contact_area : (k,) ndarray, µm²
        Real contact area.
    normal_elastic, tangential_elastic : (k,) ndarray, mN
        Σ F n_z over all contacts; -Σ F s·n over sliding contacts, which are the opposing contacts, or all contacts with
        ``sliding="all"``.
    normal_frictional, tangential_frictional : (k,) ndarray, mN per unit mu0
        Σ F t_z, -Σ F s·t over sliding contacts.
    normal_adhesive, tangential_adhesive : (k,) ndarray, mN per GPa of tau0
        Σ A t_z, -Σ A s·t over sliding contacts.
    overlap_load, load_beyond_hertz, load_below_grid : (k,) ndarray, mN
        Σ F n_z overlap/R; Σ F n_z of contacts with overlap > R/10; Σ F n_z of contacts with R below the grid spacing.
        See `validity`.
    crossed_count : (k,) ndarray of int
        Number of possible contacts that were rejected because their sphere centres had crossed.
    effective_modulus : float, GPa
        E* of the pair.
    sliding : {"opposing", "all"}
        Contacts that are included in the friction sums.

    Examples
    --------
    >>> from stiction import press, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> curve = press(upper.row(0), lower.row(0), ["5 nm", "20 nm"])
    >>> curve.friction_coefficient(mu0=[0.1, 0.3], tau0=0.05).shape
    (2, 2)
    """

    approach: Floats = field(metadata={"unit": "µm"})
    effective_modulus: float = field(metadata={"unit": "GPa"})
    sliding: SlidingRule = "opposing"
    _inputs: LoadCurveInputs = field(repr=False)

    def onset(
        self, index: int, *, mu0: float, tau0: float = 0.0, direction: Direction = 0.0,
        steps: int | Sequence[float] = 20, displacements: ArrayLike | None = None,
        poisson: float | Sequence[float] = 0.3, compliance_share: float = 0.5,
    ) -> Onset:  # fmt: skip
        """Compute the onset of sliding at the approach `approach[index]`, with Mindlin's solution for each contact.

        Parameters
        ----------
        index, mu0, tau0, steps, displacements
            As for `Onset`.
        direction : {"+x", "-x"} or float, degrees
            Direction of the tangential load, on profiles along x. Ellipses are stiffer along their larger axis.
        poisson, compliance_share
            As for `half_space` and its onset; the fraction has no effect if both ratios are equal.

        Raises
        ------
        ValueError
            If an argument is outside its range, mu0 and tau0 are both 0, there is no contact, or the law is
            HertzCylinder.

        Notes
        -----
        All contacts have the same displacement, and each slips from its edge inwards. If the sticking zone has the
        relative size t, s² = 1 - t², and the initial stiffness of the contact is k, the displacement is 2/k (3/4 mu0 F
        s² + 2/π tau0 A s), and the tangential load mu0 F (1 - (1 - s²)^(3/2)) + 2/π tau0 A (arcsin s + s sqrt(1 - s²)).
        The terms with mu0 are Mindlin's solution, those with tau0 the solution for a uniform strength. Their sum is
        exact for separate Hertzian contacts that are equally compliant along and across the motion. Elliptic contacts
        have the mean stiffness over the ellipse (Mindlin 1949; Johnson, Contact Mechanics, 1985, section 7.2).

        Of other laws, such as `JacksonGreen`, the onset uses the force, the area and the semi-axes. Pressure
        distribution and tangential stiffness are those of an elastic Hertzian contact with these semi-axes: the slope
        of the law's force, which includes plastic deformation, does not enter.
        """
        mu0, tau0 = validate_nonzero_strengths(mu0, tau0, self.effective_modulus)
        angle = parse_direction(direction, line=not isinstance(self, SurfaceLoadCurve))
        approach = float(self.approach[resolve_index(index, self.approach.size, "approaches")])
        tangential_problem = AsperityTangentialProblem(
            self._inputs.at(approach), self._inputs.model, mu0=mu0, tau0=tau0, angle=angle, poisson=poisson,
            compliance_share=validate_fraction("compliance_share", compliance_share),
        )  # fmt: skip
        return compute_onset(
            tangential_problem, mu0=mu0, tau0=tau0, direction=angle, steps=steps, displacements=displacements
        )

    @property
    def validity(self) -> Validity:
        """Indicators of whether the asperity model is valid at each approach (µm)."""
        return Validity.from_sums(self)


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SurfaceLoadCurve(LoadCurve):
    """Loads and contact area of two surfaces at each approach, for any mu0, tau0 and direction of motion.

    Extends `LoadCurve`. If several directions are given, the tangential and lateral sums, and the normal sums per mu0
    and tau0, have the shape (m, k); loads and coefficients have the shape of (mu0, tau0) + (m, k).

    Attributes
    ----------
    direction : () or (m,) ndarray, degrees
        Direction in which the upper surface is about to move, from +x towards +y.
    lateral_elastic : (k,) or (m, k) ndarray, mN
        -Σ F c·n over sliding contacts, with c the horizontal unit vector to the left of the motion.
    lateral_frictional, lateral_adhesive : (k,) or (m, k) ndarray, mN per unit mu0, mN per GPa of tau0
        -Σ F c·t and -Σ A c·t over sliding contacts.
    load_overlapping : (k,) ndarray, mN
        Σ F n_z of contacts whose ellipse overlaps another ellipse.
    load_at_edge : (k,) ndarray, mN
        Σ F n_z of contacts whose ellipse the edge of the map cuts.
    grid_minimum_count, unanswered_count : (k,) ndarray of int
        Grid points without a lower neighbour, and how many of them have no minimum of the spline nearby.

    Examples
    --------
    >>> from stiction import press, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> curve = press(upper, lower, ["10 nm", "20 nm"], direction=[0, 90, 180, 270])
    >>> curve.friction_coefficient(mu0=0.3).shape
    (4, 2)
    """

    direction: Floats = field(metadata={"unit": "degrees"})
    lateral_elastic: Floats = field(metadata={"unit": "mN"})
    lateral_frictional: Floats = field(metadata={"unit": "mN per unit mu0"})
    lateral_adhesive: Floats = field(metadata={"unit": "mN per GPa of tau0"})
    load_overlapping: Floats = field(metadata={"unit": "mN"})
    load_at_edge: Floats = field(metadata={"unit": "mN"})
    grid_minimum_count: NDArray[np.int64]
    unanswered_count: NDArray[np.int64]

    @property
    def validity(self) -> SurfaceValidity:
        """Indicators of whether the asperity model is valid at each approach (µm)."""
        return SurfaceValidity.from_sums(self)

    def lateral_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """Return the lateral force (mN), positive to the left of the motion, that keeps the upper surface on its path.

        Shape and arguments are as for `normal_load`.
        """
        return self._broadcast_friction_law(mu0, tau0).load("lateral", self)


@overload
def press(
    upper: Profile, lower: Profile, approaches: ArrayLike, **contact: Unpack[ContactModelArguments]
) -> LoadCurve: ...


@overload
def press(
    upper: Surface, lower: Surface, approaches: ArrayLike, **contact: Unpack[ContactModelArguments]
) -> SurfaceLoadCurve: ...


@overload
def press(found: Candidates, approaches: ArrayLike, /, **contact: Unpack[ContactModelArguments]) -> LoadCurve: ...


@add_model_keywords_to_signature
def press(upper: Any, lower: Any = None, approaches: Any = None, **contact: Any) -> LoadCurve:
    """Compute loads and contact area of two surfaces at given approaches, in the asperity model.

    The call is ``press(upper, lower, approaches)`` or ``press(candidates, approaches)``.

    Parameters
    ----------
    upper, lower : Profile or Surface
        Two profiles or two surfaces on the same grid, or `Candidates` instead of both. A profile that is straight to
        round-off is treated as flat.
    approaches : (k,) array_like of float, µm
        Displacements of the upper surface since first contact of the grid points, at least 0 and strictly increasing;
        or a string, "5 nm", or a list of strings.
    **contact
        As for `contacts`. On surfaces several directions can be given at little extra cost.

    Returns
    -------
    curve : LoadCurve
        Contact area (µm²) and the sums that determine the loads (mN) at every approach; a `SurfaceLoadCurve` for
        surfaces.

    Raises
    ------
    ValueError
        If the grids differ, an argument is outside its range, or an approach exceeds that of the candidates.

    See Also
    --------
    approach_at_load : Approach at given loads.
    half_space : Boundary-element solution, with interaction of the contacts.
    contacts : Single contacts at one approach.

    Notes
    -----
    Asperities are independent of each other, with one law for all contacts. Hanaor, Gan & Einav, Tribology
    International 93 (2016) 229.

    Examples
    --------
    >>> from stiction import press, random_phases, weierstrass_mandelbrot
    >>> lower, upper = (
    ...     weierstrass_mandelbrot(random_phases(3, side=side), 1.2, points=20_000).with_amplitude(0.1)
    ...     for side in ("lower", "upper")
    ... )
    >>> curve = press(upper, lower, [0.005, 0.01, 0.02])
    >>> curve.friction_coefficient(mu0=[0.1, 0.4]).shape
    (2, 3)

    Two surfaces, in four directions:

    >>> from stiction import self_affine_surface
    >>> lower, upper = (
    ...     self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1, side=side)
    ...     for side in ("lower", "upper")
    ... )
    >>> curve = press(upper, lower, [0.02, 0.04], direction=[0, 90, 180, 270], sliding="all")
    >>> curve.friction_coefficient(mu0=0.4).shape
    (4, 2)
    """
    minima, model = find_candidates_and_model(upper, lower, contact)
    if minima is not None and lower is not None:
        if approaches is not None:
            raise ValueError("lower must not be given together with candidates; use press(candidates, approaches)")
        approaches = lower
    approach_values = [approaches] if isinstance(approaches, str) else approaches
    approach_array = float_array("approaches", to_core_units("approaches", approach_values, "length"), ndim=1)
    if isinstance(upper, Surface):
        minima = candidates(
            upper, lower, deepest=max(0.0, float(approach_array.max(initial=0.0))), curvature=model.curvature
        )
    core = None if minima is None else minima.core
    inputs = LoadCurveInputs((upper,) if isinstance(upper, Candidates) else (upper, lower), model)
    if not isinstance(upper, Candidates):
        warn_if_same_body(upper, lower)
    common_fields: dict[str, Any] = {
        "approach": make_read_only(approach_array.copy()), "effective_modulus": float(model.effective_modulus),
        "sliding": model.sliding, "_inputs": inputs,
    }  # fmt: skip
    if isinstance(core, stiction._core.ArealCandidates):
        angles, directions = model.angles(), model.directions()
        columns = stiction._core.press(core, approaches=approach_array, model=model.core(), directions=directions)
        for name, column in columns.items():
            table = column.reshape(len(directions), approach_array.size)
            common_fields[name] = make_read_only(
                table if name in DIRECTED_SUM_QUANTITIES and angles.ndim > 0 else table[0]
            )
        return SurfaceLoadCurve(**common_fields, direction=make_read_only(angles))
    if core is not None:
        columns = stiction._core.press(core, approaches=approach_array, model=model.core())
    else:
        columns = stiction._core.press(
            upper.heights, lower.heights, spacing=upper.spacing, approaches=approach_array, model=model.core()
        )
    return LoadCurve(**common_fields, **{name: make_read_only(column) for name, column in columns.items()})  # type: ignore[arg-type]
