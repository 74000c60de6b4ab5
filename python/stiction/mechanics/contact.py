"""Two profiles pressed together: Hanaor, Gan & Einav (2016), Eqs. 4 to 7."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiction._core as _core
from stiction._checks import Floats, choice, float_array, number, read_only
from stiction.mechanics import friction
from stiction.mechanics.law import Law, LawName, core_law
from stiction.surfaces.profile import Profile

Detection = Literal["cell", "gap-minimum"]
Curvature = Literal["convex", "signed"]
Shear = Literal["+x", "-x"]

EFFECTIVE_MODULUS = 10.0
"""GPa, of the paper."""

SUMS = (
    "contact_count",
    "contact_area",
    "normal_elastic",
    "tangential_elastic",
    "normal_frictional",
    "tangential_frictional",
    "normal_adhesive",
    "tangential_adhesive",
    "overlap_load",
    "load_beyond_hertz",
    "load_below_grid",
    "crossed_count",
)
"""What a LoadCurve holds at each approach, and a result of each pair."""


@dataclass(frozen=True, eq=False)
class Contacts:
    """Every contact of a pair at one approach, one row each, in the order of the grid; all arrays are read-only.

    Positions are in the frame of the lower profile.

    Attributes
    ----------
    index : (c,) ndarray of int
        Grid point that owns the contact: its own (cell), or the one on its left (gap-minimum).
    centre : (c, 2) ndarray, µm
    normal : (c, 2) ndarray
        Unit vector from the lower to the upper body.
    tangent : (c, 2) ndarray
        Unit vector of the friction on the upper body, were the contact to oppose the motion.
    radius : (c,) ndarray, µm
        Effective radius, 1/R = 1/R_u + 1/R_l.
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
    overlap: Floats
    force: Floats
    area: Floats
    opposing: NDArray[np.bool_]

    def __len__(self) -> int:
        """Return the number of contacts."""
        return self.index.size


@dataclass(frozen=True, eq=False)
class Validity:
    """How far the model is to be trusted; NaN where there is no contact. Shares are of the normal load Σ F n_z.

    Attributes
    ----------
    relative_overlap : ndarray
        Load-weighted mean of overlap/R. Hertz assumes a << R, that is, much less than 1.
    share_beyond_hertz : ndarray
        Share carried by contacts with overlap > R/10.
    share_below_grid : ndarray
        Share carried by contacts whose radius is below the grid spacing: of the grid rather than of the surface.
    share_crossed : ndarray
        Share of would-be contacts that were refused because their sphere centres had crossed.
    """

    relative_overlap: Any
    share_beyond_hertz: Any
    share_below_grid: Any
    share_crossed: Any

    @classmethod
    def of(cls, sums: Any) -> Validity:
        """From whatever carries the sums of a LoadCurve: NumPy's arrays or xarray's."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return cls(
                relative_overlap=sums.overlap_load / sums.normal_elastic,
                share_beyond_hertz=sums.load_beyond_hertz / sums.normal_elastic,
                share_below_grid=sums.load_below_grid / sums.normal_elastic,
                share_crossed=sums.crossed_count / (sums.crossed_count + sums.contact_count),
            )


@dataclass(frozen=True, eq=False)
class LoadCurve:
    """Load and area of a pair against approach, for every mu0 and tau0 at once; all arrays are read-only.

    Normal and tangential load are linear in the molecular friction coefficient mu0 and the adhesive shear strength
    tau0, so six sums over the contacts hold them all. n is the contact normal, t the tangent, σ the shear direction;
    "opposing" contacts are those whose normal force opposes the motion.

    Attributes
    ----------
    approach : (k,) ndarray, µm
        Displacement of the upper body since first touch.
    contact_count : (k,) ndarray of int
    contact_area : (k,) ndarray, µm²
    normal_elastic, tangential_elastic : (k,) ndarray, mN
        Σ F n_z over all, -σ Σ F n_x over opposing contacts.
    normal_frictional, tangential_frictional : (k,) ndarray, mN per unit mu0
        Σ F t_z, -σ Σ F t_x over opposing contacts.
    normal_adhesive, tangential_adhesive : (k,) ndarray, mN per GPa of tau0
        Σ A t_z, -σ Σ A t_x over opposing contacts.
    overlap_load, load_beyond_hertz, load_below_grid : (k,) ndarray, mN
        Σ F n_z overlap/R, Σ F n_z of contacts with overlap > R/10, and of those with R below the grid spacing; see
        `validity`.
    crossed_count : (k,) ndarray of int
        Would-be contacts that were refused because their sphere centres had crossed.
    effective_modulus : float, GPa
    """

    approach: Floats
    contact_count: NDArray[np.int64]
    contact_area: Floats
    normal_elastic: Floats
    tangential_elastic: Floats
    normal_frictional: Floats
    tangential_frictional: Floats
    normal_adhesive: Floats
    tangential_adhesive: Floats
    overlap_load: Floats
    load_beyond_hertz: Floats
    load_below_grid: Floats
    crossed_count: NDArray[np.int64]
    effective_modulus: float

    @property
    def validity(self) -> Validity:
        """How far the model is to be trusted at each approach, (k,) each."""
        return Validity.of(self)

    def normal_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """F_N in mN, shape of (mu0, tau0) + (k,); mu0 dimensionless, tau0 in GPa, broadcast against each other."""
        return np.asarray(friction.normal_load(self, *self._parameters(mu0, tau0)))

    def tangential_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """F_T in mN that starts the sliding; shape and arguments as for `normal_load`."""
        return np.asarray(friction.tangential_load(self, *self._parameters(mu0, tau0)))

    def friction_coefficient(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """F_T / F_N, NaN unless the status is "ok"; shape and arguments as for `normal_load`."""
        parameters = self._parameters(mu0, tau0)
        normal = np.asarray(friction.normal_load(self, *parameters))
        tangential = np.asarray(friction.tangential_load(self, *parameters))
        ok = friction.status_of(self.contact_count, normal) == friction.STATUS_OK
        coefficient: Floats = np.divide(tangential, normal, out=np.full(normal.shape, np.nan), where=ok)
        return coefficient

    def status(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> NDArray[np.str_]:
        """Either "ok", "self-locked" (F_N <= 0) or "no-contact"; shape and arguments as for `normal_load`."""
        normal = np.asarray(friction.normal_load(self, *self._parameters(mu0, tau0)))
        return friction.status_of(self.contact_count, normal)

    def _parameters(self, mu0: ArrayLike, tau0: ArrayLike) -> tuple[Floats, Floats]:
        strengths = friction.friction_parameter("tau0", tau0)
        friction.check_shear_strength(strengths, self.effective_modulus)
        both = np.broadcast_arrays(friction.friction_parameter("mu0", mu0), strengths)
        return both[0][..., np.newaxis], both[1][..., np.newaxis]


def _model(
    upper: Profile,
    lower: Profile,
    effective_modulus: float,
    law: Law | LawName,
    detection: Detection,
    curvature: Curvature,
    shear: Shear,
) -> dict[str, Any]:
    for name, body in (("upper", upper), ("lower", lower)):
        if not isinstance(body, Profile):
            raise ValueError(f"{name} must be a Profile, got {type(body).__name__}")
    if upper.spacing != lower.spacing:
        raise ValueError(f"upper and lower must have equal spacings, got {upper.spacing!r} and {lower.spacing!r} µm")
    choice("detection", detection, Detection)
    choice("curvature", curvature, Curvature)
    choice("shear", shear, Shear)
    return {
        "spacing": upper.spacing,
        "law": core_law(law, effective_modulus=effective_modulus),
        "by_cell": detection == "cell",
        "convex_only": curvature == "convex",
        "shear": 1 if shear == "+x" else -1,
    }


def contacts(
    upper: Profile,
    lower: Profile,
    approach: float,
    *,
    effective_modulus: float = EFFECTIVE_MODULUS,
    law: Law | LawName = "hertz-sphere",
    detection: Detection = "cell",
    curvature: Curvature = "convex",
    shear: Shear = "+x",
) -> Contacts:
    """Every contact of two profiles at one approach.

    Parameters
    ----------
    upper, lower : Profile
        On the same grid. A profile whose points lie on a line, to round-off, is a straight body.
    approach : float, µm
        Displacement of the upper body since first touch of the grid points, at least 0.
    effective_modulus : float, GPa
        E*, with 1/E* = (1 - ν1²)/E1 + (1 - ν2²)/E2.
    law : HertzSphere, HertzCylinder or JacksonGreen, or "hertz-sphere" or "hertz-cylinder"
        What one contact carries.
    detection : {"cell", "gap-minimum"}
        "cell" (Eq. 5): a grid point owns a contact whose centre lies in its own cell. "gap-minimum": contacts are at
        the local minima of the splined gap, which do not depend on the grid where it resolves the surfaces.
    curvature : {"convex", "signed"}
        Whether both bodies must be convex at a contact, or one may be a wider cup.
    shear : {"+x", "-x"}
        Where the upper body is about to move.

    Raises
    ------
    ValueError
        If the grids differ or an argument is outside its range.

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
    model = _model(upper, lower, effective_modulus, law, detection, curvature, shear)
    approach = number("approach", approach, unit="µm")
    columns = _core.contacts(upper.heights, lower.heights, approach=approach, **model)
    columns["opposing"] = columns["opposing"].astype(np.bool_)
    return Contacts(**{name: read_only(column) for name, column in columns.items()})


def press(
    upper: Profile,
    lower: Profile,
    approaches: ArrayLike,
    *,
    effective_modulus: float = EFFECTIVE_MODULUS,
    law: Law | LawName = "hertz-sphere",
    detection: Detection = "cell",
    curvature: Curvature = "convex",
    shear: Shear = "+x",
) -> LoadCurve:
    """Load and true contact area of two profiles against approach.

    Parameters
    ----------
    upper, lower : Profile
        On the same grid. A profile whose points lie on a line, to round-off, is a straight body.
    approaches : (k,) array_like of float, µm
        At least 0 and strictly increasing.
    effective_modulus, law, detection, curvature, shear
        As for `contacts`.

    Raises
    ------
    ValueError
        If the grids differ or an argument is outside its range.

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
    model = _model(upper, lower, effective_modulus, law, detection, curvature, shear)
    steps = float_array("approaches", approaches, ndim=1)
    columns = _core.press(upper.heights, lower.heights, steps, **model)
    arrays = {name: read_only(column) for name, column in columns.items()}
    return LoadCurve(read_only(steps.copy()), **arrays, effective_modulus=float(effective_modulus))
