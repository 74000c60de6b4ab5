"""Friction as linear algebra: F = elastic + mu0 frictional + tau0 adhesive, for both components of the load.

Hanaor, Gan & Einav (2016), Eqs. 6 and 7 and section 2.5.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Literal, Self, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array, number
from stiction._drawing import draw_area, draw_friction
from stiction._repr import PlotRepr, TextRepr, axes_for
from stiction.mechanics.quantities import QUANTITIES, SUMS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Status = Literal["ok", "self-locked", "no-contact", "not-reached", "below-range", "not-solved", "seizure"]
"""Whether a point has a coefficient of friction, or why not."""

STATUSES: tuple[Status, ...] = get_args(Status)  # in this order their numbers stand in files
STATUS_OK: Status = "ok"
STATUS_SELF_LOCKED: Status = "self-locked"
STATUS_NO_CONTACT: Status = "no-contact"
STATUS_NOT_REACHED: Status = "not-reached"
STATUS_BELOW_RANGE: Status = "below-range"
STATUS_NOT_SOLVED: Status = "not-solved"
STATUS_SEIZURE: Status = "seizure"
STATUS_DTYPE = np.dtype(f"<U{max(len(status) for status in STATUSES)}")  # dtype of arrays of statuses
_PARTS = ("elastic", "frictional", "adhesive")

SIX = tuple(f"{load}_{part}" for load in ("normal", "tangential") for part in _PARTS)
"""The sums that normal and tangential load are made of for every mu0 and tau0."""

SHEAR_STRENGTH_LIMIT = 0.1  # tau0/E* above which tau0 is nearly always MPa given as GPa


@dataclass(frozen=True, eq=False, kw_only=True)
class Sums:
    """Sums over contacts from which both loads follow for every mu0 and tau0, arrays of one shape: see `LoadCurve`."""

    contact_count: NDArray[Any]
    contact_area: Floats = field(metadata={"unit": "µm²"})
    normal_elastic: Floats = field(metadata={"unit": "mN"})
    tangential_elastic: Floats = field(metadata={"unit": "mN"})
    normal_frictional: Floats = field(metadata={"unit": "mN per unit mu0"})
    tangential_frictional: Floats = field(metadata={"unit": "mN per unit mu0"})
    normal_adhesive: Floats = field(metadata={"unit": "mN per GPa of tau0"})
    tangential_adhesive: Floats = field(metadata={"unit": "mN per GPa of tau0"})
    overlap_load: Floats = field(metadata={"unit": "mN"})
    load_beyond_hertz: Floats = field(metadata={"unit": "mN"})
    load_below_grid: Floats = field(metadata={"unit": "mN"})
    crossed_count: NDArray[Any]

    @classmethod
    def of(cls, columns: Mapping[str, Any]) -> Sums:
        """From anything that has all of them by name; a dataset's variables do for its arrays."""
        return Sums(**{name: columns[name] for name in SUMS})

    def each(self, function: Callable[[NDArray[Any]], Any]) -> Sums:
        """A function of each: a choice of elements, a mean."""
        return Sums(**{name: function(getattr(self, name)) for name in SUMS})


@dataclass(frozen=True, eq=False, repr=False)
class Validity(TextRepr):
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

    Examples
    --------
    >>> from stiction import press, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> press(upper.row(0), lower.row(0), "20 nm").validity.share_beyond_hertz
    array([0.])
    """

    relative_overlap: Floats
    share_beyond_hertz: Floats
    share_below_grid: Floats
    share_crossed: Floats

    @classmethod
    def of(cls, sums: Any) -> Self:
        """That of sums."""
        return cls(**{each.name: ratio_of(each.name, sums) for each in fields(cls)})


@dataclass(frozen=True, eq=False, repr=False)
class SurfaceValidity(Validity):
    """How far the model is to be trusted on surfaces: the figures of `Validity`, and three more.

    R is the geometric mean of the two radii. No contact is refused, so that `share_crossed` is 0.

    Attributes
    ----------
    share_overlapping : ndarray
        Share of the load on ellipses that overlap another one, seen from above: contacts that would merge.
    share_at_edge : ndarray
        Share of the load on ellipses that the edge of the map cuts; of these, what lies inside counts.
    share_unanswered : ndarray
        Share of the grid points within the approach of which no neighbour is lower and beside which the spline has no
        minimum, as on level floors; NaN where there are no such points.

    Examples
    --------
    >>> from stiction import press, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> press(upper, lower, "20 nm").validity.share_at_edge.round(2)
    array([0.])
    """

    share_overlapping: Floats
    share_at_edge: Floats
    share_unanswered: Floats


RATIOS: dict[str, tuple[str, tuple[str, ...]]] = {
    name: (each.numerator, each.denominator) for name, each in QUANTITIES.items() if each.kind == "validity"
}
"""Sum that is the numerator of each figure of validity, and the sums of its denominator."""


def ratio_of(name: str, sums: Any) -> Floats:
    """A figure of validity of sums by name or by attribute; NaN where there is no contact."""
    part, whole = RATIOS[name]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(_of(sums, part) / sum(_of(sums, each) for each in whole))


def _of(sums: Any, name: str) -> Any:
    return sums[name] if isinstance(sums, Mapping) else getattr(sums, name)


def load_of(load: str, sums: Any, mu0: ArrayLike, tau0: ArrayLike) -> Floats:
    """The "normal", "tangential" or "lateral" load, mN, of sums by name or by attribute."""
    elastic, frictional, adhesive = (_of(sums, f"{load}_{part}") for part in _PARTS)
    return np.asarray(elastic + mu0 * frictional + tau0 * adhesive)


def loads_of(sums: Any, mu0: Floats, tau0: Floats) -> tuple[Floats, Floats]:
    """Normal and tangential load, mN, of sums (...), over (..., mu0, tau0)."""
    columns = {name: sums[name][..., np.newaxis, np.newaxis] for name in SIX}
    mu0 = mu0[:, np.newaxis]
    return load_of("normal", columns, mu0, tau0), load_of("tangential", columns, mu0, tau0)


class Curve(PlotRepr):
    """Loads of a pair at each step, approaches or loads, of which there are sums."""

    contact_count: NDArray[Any]
    contact_area: Floats
    normal_elastic: Floats
    tangential_elastic: Floats
    effective_modulus: float

    def normal_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """F_N in mN; mu0 dimensionless, tau0 in GPa, broadcast against each other.

        The shape is that of (mu0, tau0) + (k,) of k steps, or + (m, k) of m directions.
        """
        return load_of("normal", self, *self._parameters(mu0, tau0))

    def tangential_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """F_T in mN that starts the sliding; shape and arguments as for `normal_load`."""
        return load_of("tangential", self, *self._parameters(mu0, tau0))

    def friction_coefficient(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """F_T / F_N, NaN unless the status is "ok"; shape and arguments as for `normal_load`."""
        parameters = self._parameters(mu0, tau0)
        normal, tangential = (load_of(load, self, *parameters) for load in ("normal", "tangential"))
        ok = status_at(self.contact_count, normal) == STATUS_OK
        coefficient: Floats = np.divide(tangential, normal, out=np.full(normal.shape, np.nan), where=ok)
        return coefficient

    def status(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> NDArray[np.str_]:
        """Either "ok", "self-locked" (F_N <= 0) or "no-contact"; shape and arguments as for `normal_load`."""
        normal = load_of("normal", self, *self._parameters(mu0, tau0))
        return status_at(self.contact_count, normal)

    def plot(self, ax: Axes | None = None, *, mu0: ArrayLike | None = None, tau0: ArrayLike = 0.0) -> Axes:
        """Draw the true area over the load or, where a mu0 is given, the friction coefficient, a line for each.

        Into given axes, or by default new ones, which are returned; mu0 and tau0 (GPa) as for `normal_load`.
        """
        if mu0 is None:
            return draw_area(axes_for(ax), self.normal_elastic, self.contact_area)
        coefficient = self.friction_coefficient(mu0=mu0, tau0=tau0)
        direction = getattr(self, "direction", 0.0)  # which profiles have not
        return draw_friction(axes_for(ax), self.normal_elastic, coefficient, mu0=mu0, tau0=tau0, direction=direction)

    def _parameters(self, mu0: ArrayLike, tau0: ArrayLike) -> tuple[Floats, Floats]:
        strengths = friction_parameter("tau0", tau0)
        check_shear_strength(strengths, self.effective_modulus)
        both = np.broadcast_arrays(friction_parameter("mu0", mu0), strengths)
        # Before the axes of the sums, which are steps or directions and steps.
        axes = (..., *([np.newaxis] * self.tangential_elastic.ndim))
        return both[0][axes], both[1][axes]


def status_of(*, touched: ArrayLike, reached: ArrayLike, locked: ArrayLike, below: ArrayLike = False) -> NDArray[Any]:
    """The one ladder of statuses, for curves, ensembles and traverses; booleans that broadcast.

    `locked` is said of the last step, `below` where the first carries more than the load.
    """
    ladder: list[tuple[ArrayLike, Status]] = [
        (np.logical_not(touched), STATUS_NO_CONTACT), (reached, STATUS_OK), (below, STATUS_BELOW_RANGE),
        (locked, STATUS_SELF_LOCKED),
    ]  # fmt: skip
    conditions = np.broadcast_arrays(*(np.asarray(condition, dtype=np.bool_) for condition, _ in ladder))
    return np.select(conditions, [np.asarray(status, STATUS_DTYPE) for _, status in ladder], STATUS_NOT_REACHED)


def status_at(contact_count: ArrayLike, normal: Floats) -> NDArray[Any]:
    """Status at an approach: there every load is reached but one that is not above 0."""
    return status_of(touched=np.asarray(contact_count) != 0, reached=normal > 0, locked=True)


def friction_parameter(name: str, values: ArrayLike) -> Floats:
    """mu0 or tau0 as an array of finite numbers that are not negative."""
    array = float_array(name, values)
    if not (array >= 0).all():
        raise ValueError(f"{name} must not be negative, got {values!r}")
    return array


def listed_parameter(name: str, values: ArrayLike) -> Floats:
    """mu0 or tau0 as one number, (), or some, (k,)."""
    array = friction_parameter(name, values)
    if array.ndim > 1 or not array.size:
        raise ValueError(f"{name} must be a number or a list of numbers, got {values!r}")
    return array


def check_shear_strength(tau0: Floats, effective_modulus: float) -> None:
    """Warn of a tau0 that is nearly always MPa given as GPa."""
    highest = float(np.max(tau0, initial=0))
    if highest > SHEAR_STRENGTH_LIMIT * effective_modulus:
        warnings.warn(
            f"tau0 = {highest:g} GPa is above a tenth of the effective modulus {effective_modulus:g} GPa; "
            "is it in MPa?",
            stacklevel=3,
        )


def one_material(mu0: Any, tau0: Any, effective_modulus: Any) -> tuple[float, float]:
    """A single mu0 and a single tau0 (GPa), checked as arrays of them are."""
    values = [
        float(friction_parameter(name, number(name, value, unit=unit)))
        for name, value, unit in (("mu0", mu0, ""), ("tau0", tau0, "GPa"))
    ]
    modulus = number("effective_modulus", effective_modulus, unit="GPa", above=0)
    check_shear_strength(np.asarray(values[1]), modulus)
    return values[0], values[1]
