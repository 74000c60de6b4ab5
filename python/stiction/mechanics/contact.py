"""Asperities of profiles, and all contacts between two surfaces at a given approach (µm).

Hanaor, Gan & Einav (2016), Eqs. 2 to 5.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Unpack, overload

import numpy as np
from numpy.typing import NDArray

import stiction._core
from stiction._checks import Floats, check_choice, make_read_only, validate_number
from stiction._repr import TextReprMixin
from stiction._units import short_repr, to_core_units
from stiction.mechanics.candidates import Candidates, candidates, find_candidates_and_model
from stiction.mechanics.model import ContactModelArguments, add_model_keywords_to_signature, warn_if_same_body
from stiction.surfaces.profile import Profile, Side
from stiction.surfaces.surface import Surface, as_body


@dataclass(frozen=True, eq=False, repr=False)
class Contacts(TextReprMixin):
    """Contacts between two surfaces at one approach (µm), as arrays with one row per contact.

    All arrays are read-only.

    Vectors are (x, y, z) with z as height; y is 0 on profiles. Positions are in the frame of the lower surface.

    Attributes
    ----------
    index : (c,) ndarray of int
        Grid point of the contact: its cell ("cell"), or the point to its left ("gap-minimum"). On surfaces the point to
        its lower left, counted row by row.
    centre : (c, 3) ndarray, µm
        Centre of the contact.
    normal : (c, 3) ndarray
        Unit vector from the lower to the upper surface.
    tangent : (c, 3) ndarray
        Unit vector of the friction force on the upper surface if the contact opposes the motion.
    radius : (c,) ndarray, µm
        Effective radius, 1/R = 1/R_u + 1/R_l; on surfaces the geometric mean of the radii.
    radii : (c, 2) ndarray, µm
        Principal radii of the relative curvature, the larger one first; for spheres both are the effective radius.
    axes : (c, 2) ndarray, µm
        Semi-axes of the contact patch, the larger one first; for Hertz spheres both are (R overlap)^(1/2). If the edge
        of the map cuts the patch, the semi-axes describe the similar ellipse with the area inside the map.
    along : (c, 3) ndarray
        Unit vector of the larger semi-axis; on profiles the y axis.
    overlap : (c,) ndarray, µm
        Overlap of the undeformed asperities along the normal.
    force : (c,) ndarray, mN
        Normal force of the contact law.
    area : (c,) ndarray, µm²
        Contact area of the contact law.
    opposing : (c,) ndarray of bool
        True if the normal force on the upper surface points against the motion. Only these contacts have friction,
        unless ``sliding="all"``.

    Examples
    --------
    >>> from stiction import contacts, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> found = contacts(upper, lower, "20 nm")
    >>> len(found), int(found.opposing.sum())
    (10, 5)
    """

    index: NDArray[np.int64]
    centre: Floats = field(metadata={"unit": "µm"})
    normal: Floats
    tangent: Floats
    radius: Floats = field(metadata={"unit": "µm"})
    radii: Floats = field(metadata={"unit": "µm"})
    axes: Floats = field(metadata={"unit": "µm"})
    along: Floats
    overlap: Floats = field(metadata={"unit": "µm"})
    force: Floats = field(metadata={"unit": "mN"})
    area: Floats = field(metadata={"unit": "µm²"})
    opposing: NDArray[np.bool_]

    def __len__(self) -> int:
        """Return the number of contacts."""
        return self.index.size


@overload
def contacts(
    upper: Profile | Surface, lower: Profile | Surface, approach: float | str, **contact: Unpack[ContactModelArguments]
) -> Contacts: ...


@overload
def contacts(found: Candidates, approach: float | str, /, **contact: Unpack[ContactModelArguments]) -> Contacts: ...


@add_model_keywords_to_signature
def contacts(upper: Any, lower: Any = None, approach: Any = None, **contact: Any) -> Contacts:
    """Compute all contacts between two surfaces at one approach (µm).

    The call is ``contacts(upper, lower, approach)`` or ``contacts(candidates, approach)``.

    Parameters
    ----------
    upper, lower : Profile or Surface
        Two profiles or two surfaces on the same grid, or `Candidates` instead of both. A profile that is straight to
        round-off is treated as flat.
    approach : float, µm
        Displacement of the upper surface since first contact of the grid points, at least 0; or a string, "5 nm".
    **contact
        Keyword arguments of `ContactModel`: effective_modulus (GPa), law, detection, curvature, shear or direction, and
        sliding; or a complete `model`. Surfaces that were read from files require an effective_modulus. Candidates
        determine detection and curvature. Only one direction is allowed.

    Returns
    -------
    contacts : Contacts
        Position (µm), normal, radii (µm), force (mN) and area (µm²) of every contact.

    Raises
    ------
    ValueError
        If the grids differ, an argument is outside its range, or the approach exceeds that of the candidates.

    See Also
    --------
    press : Sums over the contacts at many approaches.
    candidates : Search that several calls can share.

    Notes
    -----
    With X = O_u - O_l between the sphere centres and d its length, the normal is ±X/d. The overlap is R_u + R_l - d, or
    the distance minus the difference of the radii for a sphere in a cup, and the centre O_l + X/2 - (R_u - R_l) n/2
    (Eq. 4). Contacts with crossed centres, n_z <= 0, are rejected.

    On surfaces, contacts are the local minima of the splined gap g, where the common slope p = ∇z gives the normal (-p,
    1)/q, q² = 1 + p². The relative curvatures κ1 <= κ2 are the eigenvalues of the Hessian of g over q in the metric I +
    p pᵀ, the overlap is (δ - g)/q, and the contact is the ellipse of Hertz (Johnson, Contact Mechanics, section 4.2).
    If the edge of the map cuts an ellipse, only the part inside the map counts.

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
    minima, model = find_candidates_and_model(upper, lower, contact)
    if minima is not None and approach is None:
        approach = lower
    approach = validate_number("approach", to_core_units("approach", approach, "length"), unit="µm")
    if model.angles().ndim > 0:
        raise ValueError(
            "direction must be a single angle, because each contact stores its slope and forces for one direction, "
            f"got {short_repr(model.direction)}"
        )
    if isinstance(upper, Surface):
        minima = candidates(upper, lower, deepest=max(0.0, float(approach)), curvature=model.curvature)
    if minima is not None:
        columns = stiction._core.contacts(minima.core, approach=approach, model=model.core())
    else:
        columns = stiction._core.contacts(
            upper.heights, lower.heights, spacing=upper.spacing, approach=approach, model=model.core()
        )
    if not isinstance(upper, Candidates):
        warn_if_same_body(upper, lower)
    columns["opposing"] = columns["opposing"].astype(np.bool_)
    return Contacts(**{name: make_read_only(column) for name, column in columns.items()})


@dataclass(frozen=True, eq=False, repr=False)
class Asperities(TextReprMixin):
    """Osculating spheres of a profile: one sphere at each point of the profile.

    All arrays are read-only.

    Attributes
    ----------
    slope : (n,) ndarray
        Slope f' of the natural cubic spline.
    curvature : (n,) ndarray, 1/µm
        Second derivative f'' of the spline; zero at both ends.
    normal : (n, 3) ndarray
        Unit vector (x, y, z) out of the solid, with z as height; y is 0.
    radius : (n,) ndarray, µm
        Positive where the solid is convex, infinite where the curvature is zero.
    centre : (n, 3) ndarray, µm
        Sphere centre; not finite if the radius is not finite.

    Examples
    --------
    >>> from stiction import asperities, random_phases, weierstrass_mandelbrot
    >>> asperities(weierstrass_mandelbrot(random_phases(1), 1.2, points=2000), "lower").normal.shape
    (2000, 3)
    """

    slope: Floats
    curvature: Floats = field(metadata={"unit": "1/µm"})
    normal: Floats
    radius: Floats = field(metadata={"unit": "µm"})
    centre: Floats = field(metadata={"unit": "µm"})


def asperities(profile: Profile, side: Side) -> Asperities:
    """Compute the osculating sphere at every point of a profile.

    Parameters
    ----------
    profile : Profile
        Profile whose points are the asperities.
    side : {"lower", "upper"}
        Position of the solid: below the profile ("lower") or above it ("upper").

    Returns
    -------
    asperities : Asperities
        Slope, curvature (1/µm), normal, radius (µm) and sphere centre (µm) of every point.

    Raises
    ------
    ValueError
        If the profile is not a `Profile`, or the side is neither "lower" nor "upper".

    See Also
    --------
    contacts : Contacts between the asperities of two profiles.

    Notes
    -----
    The derivatives f' and f'' are those of the natural cubic spline. With q = sqrt(1 + f'²), the lower surface has
    n = (-f', 0, 1)/q and R = -q³/f''; both have the opposite sign on the upper surface. The centre is x - R n. The end
    condition f'' = 0 makes radii within about ten points of an end unreliable.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, asperities
    >>> arc = Profile(-((np.arange(21) * 0.1 - 1.0) ** 2) / 4, spacing=0.1)  # radius 2
    >>> float(asperities(arc, "lower").radius[10].round(2))
    2.0
    """
    as_body("profile", profile, Profile)
    check_choice("side", side, Side)
    arrays = stiction._core.asperities(profile.heights, spacing=profile.spacing, side=side)
    return Asperities(*(make_read_only(array) for array in arrays))
