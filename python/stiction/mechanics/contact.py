"""Two bodies pressed together: Hanaor, Gan & Einav (2016), Eqs. 4 to 7."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiction._core
from stiction._checks import Floats, float_array, number, read_only
from stiction.mechanics import friction
from stiction.mechanics.candidates import Candidates
from stiction.mechanics.friction import Sums, Validity
from stiction.mechanics.model import ContactKeywords, ContactModel, check_pair, model_of
from stiction.surfaces.profile import Profile


@dataclass(frozen=True, eq=False)
class Contacts:
    """Every contact of a pair at one approach, one row each, in the order of the grid; all arrays are read-only.

    Vectors are (x, y, z), z being height; y is 0 on profiles. Positions are in the frame of the lower body.

    Attributes
    ----------
    index : (c,) ndarray of int
        Grid point that owns the contact: its own (cell), or the one on its left (gap-minimum).
    centre : (c, 3) ndarray, µm
    normal : (c, 3) ndarray
        Unit vector from the lower to the upper body.
    tangent : (c, 3) ndarray
        Unit vector of the friction on the upper body, were the contact to oppose the motion.
    radius : (c,) ndarray, µm
        Effective radius, 1/R = 1/R_u + 1/R_l.
    radii : (c, 2) ndarray, µm
        Principal radii of the relative curvature, the larger first; of two spheres both are the effective radius.
    axes : (c, 2) ndarray, µm
        Semi-axes of the patch of contact, the larger first; of Hertz spheres both are (R overlap)^(1/2).
    overlap : (c,) ndarray, µm
    force : (c,) ndarray, mN
        Normal force of the contact law.
    area : (c,) ndarray, µm²
    opposing : (c,) ndarray of bool
        Whether the normal force on the upper body points against the motion: only these carry friction.
    """

    index: NDArray[np.int64]
    centre: Floats
    normal: Floats
    tangent: Floats
    radius: Floats
    radii: Floats
    axes: Floats
    overlap: Floats
    force: Floats
    area: Floats
    opposing: NDArray[np.bool_]

    def __len__(self) -> int:
        """Return the number of contacts."""
        return self.index.size


@dataclass(frozen=True, eq=False, kw_only=True)
class LoadCurve(Sums):
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
        Σ F n_z over all, -Σ F s·n over opposing contacts.
    normal_frictional, tangential_frictional : (k,) ndarray, mN per unit mu0
        Σ F t_z, -Σ F s·t over opposing contacts.
    normal_adhesive, tangential_adhesive : (k,) ndarray, mN per GPa of tau0
        Σ A t_z, -Σ A s·t over opposing contacts.
    overlap_load, load_beyond_hertz, load_below_grid : (k,) ndarray, mN
        Σ F n_z overlap/R, Σ F n_z of contacts with overlap > R/10, and of those with R below the grid spacing; see
        `validity`.
    crossed_count : (k,) ndarray of int
        Would-be contacts that were refused because their sphere centres had crossed.
    effective_modulus : float, GPa
    """

    approach: Floats
    effective_modulus: float

    @property
    def validity(self) -> Validity:
        """How far the model is to be trusted at each approach, (k,) each."""
        return Validity.of(self)

    def normal_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """F_N in mN, shape of (mu0, tau0) + (k,); mu0 dimensionless, tau0 in GPa, broadcast against each other."""
        return friction.normal_load(self, *self._parameters(mu0, tau0))

    def tangential_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """F_T in mN that starts the sliding; shape and arguments as for `normal_load`."""
        return friction.tangential_load(self, *self._parameters(mu0, tau0))

    def friction_coefficient(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """F_T / F_N, NaN unless the status is "ok"; shape and arguments as for `normal_load`."""
        parameters = self._parameters(mu0, tau0)
        normal = friction.normal_load(self, *parameters)
        tangential = friction.tangential_load(self, *parameters)
        ok = friction.status_at(self.contact_count, normal) == friction.STATUS_OK
        coefficient: Floats = np.divide(tangential, normal, out=np.full(normal.shape, np.nan), where=ok)
        return coefficient

    def status(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> NDArray[np.str_]:
        """Either "ok", "self-locked" (F_N <= 0) or "no-contact"; shape and arguments as for `normal_load`."""
        normal = friction.normal_load(self, *self._parameters(mu0, tau0))
        return friction.status_at(self.contact_count, normal)

    def _parameters(self, mu0: ArrayLike, tau0: ArrayLike) -> tuple[Floats, Floats]:
        strengths = friction.friction_parameter("tau0", tau0)
        friction.check_shear_strength(strengths, self.effective_modulus)
        both = np.broadcast_arrays(friction.friction_parameter("mu0", mu0), strengths)
        return both[0][..., np.newaxis], both[1][..., np.newaxis]


@overload
def contacts(upper: Profile, lower: Profile, approach: float, **contact: Unpack[ContactKeywords]) -> Contacts: ...


@overload
def contacts(found: Candidates, /, approach: float, **contact: Unpack[ContactKeywords]) -> Contacts: ...


def contacts(upper: Any, lower: Any = None, approach: Any = None, **contact: Unpack[ContactKeywords]) -> Contacts:
    """Every contact at one approach: ``contacts(upper, lower, approach)`` or ``contacts(candidates, approach)``.

    Parameters
    ----------
    upper, lower : Profile
        On the same grid, or `Candidates` in place of both. A profile whose points lie on a line, to round-off, is a
        straight body.
    approach : float, µm
        Displacement of the upper body since first touch of the grid points, at least 0.
    **contact
        effective_modulus, law, detection, curvature and shear, as `ContactModel` has them, or `model`, a whole one;
        candidates have a detection and a curvature of their own.

    Raises
    ------
    ValueError
        If the grids differ, an argument is outside its range, or the approach is beyond the candidates' deepest.

    Notes
    -----
    With X = O_u - O_l between the sphere centres and d its length, the normal is ±X/d, the overlap R_u + R_l - d, or
    d less the difference of the radii for a ball in a cup, and the centre O_l + X/2 - (R_u - R_l) n/2 (Eq. 4).
    Refused are centres that have crossed, n_z <= 0.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, contacts
    >>> x = np.arange(201) * 0.01 - 1.003
    >>> ball = Profile(-(x**2) / 2, spacing=0.01)
    >>> flat = Profile(np.zeros(201), spacing=0.01)
    >>> one = contacts(flat, ball, 0.01)
    >>> len(one), one.force.round(4)  # Hertz: 4/3 E* R^(1/2) overlap^(3/2)
    (1, array([0.0133]))
    """
    if isinstance(upper, Candidates):
        approach = lower if approach is None else approach
        model = _model_for(upper, contact)
        columns = stiction._core.contacts(
            upper.core, approach=number("approach", approach, unit="µm"), model=model.core()
        )
    else:
        check_pair(upper, lower)
        columns = stiction._core.contacts(
            upper.heights,
            lower.heights,
            spacing=upper.spacing,
            approach=number("approach", approach, unit="µm"),
            model=model_of(contact).core(),
        )
    columns["opposing"] = columns["opposing"].astype(np.bool_)
    return Contacts(**{name: read_only(column) for name, column in columns.items()})


@overload
def press(upper: Profile, lower: Profile, approaches: ArrayLike, **contact: Unpack[ContactKeywords]) -> LoadCurve: ...


@overload
def press(found: Candidates, /, approaches: ArrayLike, **contact: Unpack[ContactKeywords]) -> LoadCurve: ...


def press(upper: Any, lower: Any = None, approaches: Any = None, **contact: Unpack[ContactKeywords]) -> LoadCurve:
    """Load and true area against approach: ``press(upper, lower, approaches)`` or ``press(candidates, approaches)``.

    Parameters
    ----------
    upper, lower : Profile
        On the same grid, or `Candidates` in place of both. A profile whose points lie on a line, to round-off, is a
        straight body.
    approaches : (k,) array_like of float, µm
        At least 0 and strictly increasing.
    **contact
        As for `contacts`.

    Raises
    ------
    ValueError
        If the grids differ, an argument is outside its range, or an approach is beyond the candidates' deepest.

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
    """
    if isinstance(upper, Candidates):
        approaches = lower if approaches is None else approaches
        model = _model_for(upper, contact)
        steps = float_array("approaches", approaches, ndim=1)
        columns = stiction._core.press(upper.core, approaches=steps, model=model.core())
    else:
        check_pair(upper, lower)
        model = model_of(contact)
        steps = float_array("approaches", approaches, ndim=1)
        columns = stiction._core.press(
            upper.heights, lower.heights, spacing=upper.spacing, approaches=steps, model=model.core()
        )
    arrays = {name: read_only(column) for name, column in columns.items()}
    return LoadCurve(**arrays, approach=read_only(steps.copy()), effective_modulus=float(model.effective_modulus))


def _model_for(found: Candidates, contact: ContactKeywords) -> ContactModel:
    """A model for candidates; a detection or curvature that is given must be theirs."""
    model = model_of(contact, ContactModel(detection="gap-minimum", curvature=found.curvature))
    for name, own in (("detection", "gap-minimum"), ("curvature", found.curvature)):
        if getattr(model, name) != own:
            raise ValueError(f"{name} must be that of the candidates, {own!r}, got {getattr(model, name)!r}")
    return model
