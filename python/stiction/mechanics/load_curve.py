"""Two bodies pressed together: sums over the contacts at each approach, from which any friction follows.

Hanaor, Gan & Einav (2016), Eqs. 6 and 7.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiction._core
from stiction._checks import Floats, float_array, fraction, read_only
from stiction._units import to_core_units
from stiction.mechanics.candidates import Candidates, candidates, known_of
from stiction.mechanics.contact import Contacts, contacts
from stiction.mechanics.friction import Curve, Sums, SurfaceValidity, Validity, load_of
from stiction.mechanics.model import ContactKeywords, ContactModel, Direction, Sliding, shows_model, warn_of_one_body
from stiction.mechanics.onset import Onset, heading, onset_of, place_of, strengths
from stiction.mechanics.quantities import DIRECTED
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface


@dataclass(frozen=True)
class PressedBodies:
    """What was pressed, candidates or both bodies, and how."""

    bodies: tuple[Any, ...]
    model: ContactModel

    def __getstate__(self) -> dict[str, Any]:
        """What is pickled: not candidates, which the core holds."""
        return {"bodies": () if len(self.bodies) == 1 else self.bodies, "model": self.model}

    def at(self, approach: float) -> Contacts:
        """All contacts, whatever the direction."""
        if not self.bodies:
            raise ValueError("a curve of candidates that comes from another process has no onset: press them again")
        listed: Contacts = contacts(*self.bodies, approach, model=replace(self.model, shear="+x", direction=None))  # type: ignore[call-overload]
        return listed


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class LoadCurve(Curve, Sums):
    """Load and area of a pair against approach, for every mu0 and tau0 at once; all arrays are read-only.

    Normal and tangential load are linear in the molecular friction coefficient mu0 and the adhesive shear strength
    tau0, so six sums over the contacts hold them all. n is the contact normal, t the tangent, s the direction in which
    the upper body is about to move; "opposing" contacts are those whose normal force opposes the motion, s·n < 0.

    Attributes
    ----------
    approach : (k,) ndarray, µm
        Displacement of the upper body since first touch.
    contact_count : (k,) ndarray of int
    contact_area : (k,) ndarray, µm²
    normal_elastic, tangential_elastic : (k,) ndarray, mN
        Σ F n_z over all, -Σ F s·n over sliding contacts: opposing ones, or all with ``sliding="all"``.
    normal_frictional, tangential_frictional : (k,) ndarray, mN per unit mu0
        Σ F t_z, -Σ F s·t over sliding contacts.
    normal_adhesive, tangential_adhesive : (k,) ndarray, mN per GPa of tau0
        Σ A t_z, -Σ A s·t over sliding contacts.
    overlap_load, load_beyond_hertz, load_below_grid : (k,) ndarray, mN
        Σ F n_z overlap/R, Σ F n_z of contacts with overlap > R/10, and of those with R below the grid spacing; see
        `validity`.
    crossed_count : (k,) ndarray of int
        Would-be contacts that were refused because their sphere centres had crossed.
    effective_modulus : float, GPa
    sliding : {"opposing", "all"}
        Which contacts the sums of friction are over.

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
    sliding: Sliding = "opposing"
    _pressed: PressedBodies = field(repr=False)

    def onset(
        self, index: int, *, mu0: float, tau0: float = 0.0, direction: Direction = 0.0,
        steps: int | Sequence[float] = 20, displacements: ArrayLike | None = None,
        poisson: float | Sequence[float] = 0.3, compliance_share: float = 0.5,
    ) -> Onset:  # fmt: skip
        """How the bodies begin to slide at `approach[index]`, see `Onset`: contact by contact, each by Mindlin.

        Parameters
        ----------
        index, mu0, tau0, steps, displacements
            As for `Onset`.
        direction : {"+x", "-x"} or float, degrees
            Where the upper body is pushed, on profiles along x. Ellipses are stiffer along than across.
        poisson, compliance_share
            As for `half_space` and its onset; with equal ratios nothing depends on the share.

        Raises
        ------
        ValueError
            If an argument is outside its range, mu0 and tau0 are both 0, nothing touches, or the law is of cylinders.
        """
        from stiction.mechanics.mindlin import Asperities

        mu0, tau0 = strengths(mu0, tau0, self.effective_modulus)
        angle = heading(direction, line=not isinstance(self, SurfaceLoadCurve))
        approach = float(self.approach[place_of(index, self.approach.size, "approaches")])
        held = Asperities(
            self._pressed.at(approach), self._pressed.model, mu0=mu0, tau0=tau0, angle=angle, poisson=poisson,
            compliance_share=fraction("compliance_share", compliance_share),
        )  # fmt: skip
        return onset_of(held, mu0=mu0, tau0=tau0, direction=angle, steps=steps, displacements=displacements)

    @property
    def validity(self) -> Validity:
        """How far the model is to be trusted at each approach, (k,) each."""
        return Validity.of(self)


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SurfaceLoadCurve(LoadCurve):
    """Load and area of two surfaces against approach, for every mu0 and tau0 and for some directions at once.

    All that a LoadCurve has. What depends on the direction, the tangential and lateral sums and the normal ones per
    mu0 and tau0, has the shape (m, k) if directions are a sequence; loads and coefficients have the shape of
    (mu0, tau0) + (m, k).

    Attributes
    ----------
    direction : () or (m,) ndarray, degrees
        From +x towards +y, where the upper body is about to move.
    lateral_elastic : (k,) or (m, k) ndarray, mN
        -Σ F c·n over sliding contacts, c being the horizontal unit vector on the left of the motion.
    lateral_frictional, lateral_adhesive : (k,) or (m, k) ndarray, mN per unit mu0, mN per GPa of tau0
        -Σ F c·t and -Σ A c·t over sliding contacts.
    load_overlapping : (k,) ndarray, mN
        Σ F n_z of contacts whose ellipse overlaps another one.
    load_at_edge : (k,) ndarray, mN
        Σ F n_z of contacts whose ellipse the edge of the map cuts.
    grid_minimum_count, unanswered_count : (k,) ndarray of int
        Grid points none of whose eight neighbours is lower, and those of them beside which the spline has no minimum.

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
        """How far the model is to be trusted at each approach, (k,) each."""
        return SurfaceValidity.of(self)

    def lateral_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """Horizontal force in mN towards the left of the motion that keeps the upper body on its way.

        Its shape and arguments are as for `normal_load`; negative values are towards the right.
        """
        return load_of("lateral", self, *self._parameters(mu0, tau0))


@overload
def press(upper: Profile, lower: Profile, approaches: ArrayLike, **contact: Unpack[ContactKeywords]) -> LoadCurve: ...


@overload
def press(
    upper: Surface, lower: Surface, approaches: ArrayLike, **contact: Unpack[ContactKeywords]
) -> SurfaceLoadCurve: ...


@overload
def press(found: Candidates, approaches: ArrayLike, /, **contact: Unpack[ContactKeywords]) -> LoadCurve: ...


@shows_model
def press(upper: Any, lower: Any = None, approaches: Any = None, **contact: Any) -> LoadCurve:
    """Load and true area against approach: ``press(upper, lower, approaches)`` or ``press(candidates, approaches)``.

    Parameters
    ----------
    upper, lower : Profile or Surface
        Both of one kind, on the same grid, or `Candidates` in place of both. A profile whose points lie on a line, to
        round-off, is a straight body.
    approaches : (k,) array_like of float, µm
        At least 0 and strictly increasing; or text, "5 nm" or a list of such.
    **contact
        As for `contacts`. On surfaces there may be many directions, which cost little more than one.

    Returns
    -------
    LoadCurve
        Of surfaces a `SurfaceLoadCurve`.

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

    Two surfaces, around the compass:

    >>> from stiction import self_affine_surface
    >>> lower, upper = (
    ...     self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1, side=side)
    ...     for side in ("lower", "upper")
    ... )
    >>> curve = press(upper, lower, [0.02, 0.04], direction=[0, 90, 180, 270], sliding="all")
    >>> curve.friction_coefficient(mu0=0.4).shape
    (4, 2)
    """
    found, model = known_of(upper, lower, contact)
    if found is not None and lower is not None:
        if approaches is not None:
            raise ValueError("candidates are of both bodies: press(candidates, approaches) takes no lower body")
        approaches = lower
    wanted = [approaches] if isinstance(approaches, str) else approaches
    steps = float_array("approaches", to_core_units("approaches", wanted, "length"), ndim=1)
    if isinstance(upper, Surface):
        found = candidates(upper, lower, deepest=max(0.0, float(steps.max(initial=0.0))), curvature=model.curvature)
    core = None if found is None else found.core
    pressed = PressedBodies((upper,) if isinstance(upper, Candidates) else (upper, lower), model)
    if not isinstance(upper, Candidates):
        warn_of_one_body(upper, lower)
    common: dict[str, Any] = {
        "approach": read_only(steps.copy()), "effective_modulus": float(model.effective_modulus),
        "sliding": model.sliding, "_pressed": pressed,
    }  # fmt: skip
    if isinstance(core, stiction._core.ArealCandidates):
        angles, directions = model.angles(), model.directions()
        columns = stiction._core.press(core, approaches=steps, model=model.core(), directions=directions)
        for name, column in columns.items():
            table = column.reshape(len(directions), steps.size)
            common[name] = read_only(table if name in DIRECTED and angles.ndim > 0 else table[0])
        return SurfaceLoadCurve(**common, direction=read_only(angles))
    if core is not None:
        columns = stiction._core.press(core, approaches=steps, model=model.core())
    else:
        columns = stiction._core.press(
            upper.heights, lower.heights, spacing=upper.spacing, approaches=steps, model=model.core()
        )
    return LoadCurve(**common, **{name: read_only(column) for name, column in columns.items()})  # type: ignore[arg-type]
