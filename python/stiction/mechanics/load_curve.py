"""What pressing two bodies together gives: sums at each approach, from which any friction follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, part_of_one
from stiction.mechanics.friction import Curve, Sums, SurfaceValidity, Validity
from stiction.mechanics.model import ContactModel, Direction, Sliding
from stiction.mechanics.onset import Onset, heading, onset_of, place_of, strengths

if TYPE_CHECKING:
    from stiction.mechanics.contact import Contacts


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
        from stiction.mechanics.contact import contacts

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

    approach: Floats
    effective_modulus: float
    sliding: Sliding = "opposing"
    _pressed: PressedBodies = field(repr=False)

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
        compliance_share: float = 0.5,
    ) -> Onset:
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
            self._pressed.at(approach),
            self._pressed.model,
            mu0=mu0,
            tau0=tau0,
            angle=angle,
            poisson=poisson,
            compliance_share=part_of_one("compliance_share", compliance_share),
        )
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

    direction: Floats
    lateral_elastic: Floats
    lateral_frictional: Floats
    lateral_adhesive: Floats
    load_overlapping: Floats
    load_at_edge: Floats
    grid_minimum_count: NDArray[np.int64]
    unanswered_count: NDArray[np.int64]

    @property
    def validity(self) -> SurfaceValidity:
        """How far the model is to be trusted at each approach, (k,) each."""
        lines = Validity.of(self)
        with np.errstate(invalid="ignore", divide="ignore"):
            return SurfaceValidity(
                relative_overlap=lines.relative_overlap,
                share_beyond_hertz=lines.share_beyond_hertz,
                share_below_grid=lines.share_below_grid,
                share_crossed=lines.share_crossed,
                share_overlapping=self.load_overlapping / self.normal_elastic,
                share_at_edge=self.load_at_edge / self.normal_elastic,
                share_unanswered=self.unanswered_count / self.grid_minimum_count,
            )

    def lateral_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """Horizontal force in mN towards the left of the motion that keeps the upper body on its way.

        Its shape and arguments are as for `normal_load`; negative values are towards the right.
        """
        mu0, tau0 = self._parameters(mu0, tau0)
        return np.asarray(self.lateral_elastic + mu0 * self.lateral_frictional + tau0 * self.lateral_adhesive)
