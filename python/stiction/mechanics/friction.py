"""Normal and tangential loads computed from contact sums: F = elastic + mu0 · frictional + tau0 · adhesive.

Hanaor, Gan & Einav (2016), Eqs. 6 and 7 and section 2.5.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Literal, Self, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, check_callable, check_instance, float_array, validate_number
from stiction._drawing import draw_contact_area, draw_friction
from stiction._number_format import format_with_unit
from stiction._repr import PlotReprMixin, TextReprMixin, axes_or_new_axes
from stiction._units import short_repr
from stiction.mechanics.materials import MAX_RUBBER_MODULUS
from stiction.mechanics.quantities import QUANTITIES, SUM_QUANTITIES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Status = Literal["ok", "self-locked", "no-contact", "not-reached", "below-range", "not-solved", "seizure", "downhill"]
"""Status of a point of a curve: "ok" if a friction coefficient exists, and otherwise the reason why none exists."""

# The sequence of the statuses must not change, because files store the index of a status in this sequence.
STATUSES: tuple[Status, ...] = get_args(Status)
STATUS_OK: Status = "ok"
STATUS_SELF_LOCKED: Status = "self-locked"
STATUS_NO_CONTACT: Status = "no-contact"
STATUS_NOT_REACHED: Status = "not-reached"
STATUS_BELOW_RANGE: Status = "below-range"
STATUS_NOT_SOLVED: Status = "not-solved"
STATUS_SEIZURE: Status = "seizure"
STATUS_DOWNHILL: Status = "downhill"
STATUS_DTYPE = np.dtype(f"<U{max(len(status) for status in STATUSES)}")  # data type of arrays of statuses
_LOAD_CONTRIBUTIONS = ("elastic", "frictional", "adhesive")

LOAD_SUM_NAMES = tuple(f"{load}_{part}" for load in ("normal", "tangential") for part in _LOAD_CONTRIBUTIONS)
"""Names of the contact sums that determine the normal and the tangential load for every mu0 and tau0."""

NEGLIGIBLE_COEFFICIENT = 1e-9
"""Largest magnitude of a coefficient that is attributed to round-off."""

MAX_SHEAR_STRENGTH_RATIO, MAX_RUBBER_SHEAR_STRENGTH_RATIO = 0.1, 1.0
"""Ratios tau0/E* above which the unit of tau0 is probably wrong: for stiff bodies, and for rubber and gels.

The ratio of rubber on glass is usually 0.1 to 0.3. A unit that is wrong by a factor of 1000 gives more than 100.
"""


@dataclass(frozen=True)
class FrictionLaw:
    """Law of friction of a contact: a contact with force F and true area A carries mu0 F + tau0 A.

    Attributes
    ----------
    mu0 : float or array
    tau0 : float or array, GPa
    junction_growth : float or array
        α of junction growth; 0 if contacts do not grow.
    """

    mu0: Any
    tau0: Any
    junction_growth: Any = 0.0

    def contributions(self, force: Any, area: Any) -> tuple[Any, Any]:
        """Return the friction forces (mN) due to mu0 and to tau0 of contacts with given forces (mN) and areas (µm²)."""
        return self.mu0 * force, self.tau0 * area

    def force(self, force: Any, area: Any) -> Any:
        """Return the friction force (mN) of contacts with the given forces (mN) and true areas (µm²)."""
        frictional, adhesive = self.contributions(force, area)
        return frictional + adhesive

    def load(self, name: str, sums: Any, area: Any = 1.0) -> Floats:
        """Compute the "normal", "tangential", "lateral" or "unloaded" load (mN) from contact sums.

        The sums are given as a mapping or as attributes. The true area is `area` times the area in the sums.
        """
        elastic, *strength_sums = (_get_sum(sums, f"{name}_{part}") for part in _LOAD_CONTRIBUTIONS)
        frictional, adhesive = self.contributions(*strength_sums)
        return np.asarray(elastic + frictional + adhesive * area)

    def coefficient(self, sums: Any, area: Any = 1.0) -> Floats:
        """Compute the friction coefficient from contact sums, with arguments as for `load`."""
        return np.asarray(self.load("tangential", sums, area) / self.load("normal", sums, area))

    def yield_pressure(self, hardness: Any) -> Any:
        """Return the pressure (GPa) of yielding contacts at the onset of sliding; NaN at seizure.

        It is the hardness (GPa) if contacts do not grow.
        """
        if not np.any(self.junction_growth):
            return hardness
        return solve_yield_condition(hardness, self.mu0, self.tau0, self.junction_growth)

    def plastic_coefficient(self, hardness: Any) -> Any:
        """Return the friction coefficient if all contacts yield; NaN at seizure."""
        return self.mu0 + self.tau0 / self.yield_pressure(hardness)

    def bulk_strength_ratio(self, hardness: Any) -> Any:
        """Return tau0 over the shear strength H/√α of bodies with a hardness (GPa)."""
        return self.tau0 * np.sqrt(self.junction_growth) / hardness

    def onset(self, load: Any, hardness: Any, nominal_area: float, area: Callable[[Any], Floats]) -> OnsetState:
        """Return the state of contacts at the onset of sliding.

        Parameters
        ----------
        load : float or array, mN
        hardness : float or array, GPa
        nominal_area : float, µm²
        area : callable
            Function from the largest pressure (GPa) to the true area (µm²) at this load.
        """
        pressure = self.yield_pressure(hardness)
        is_carried = pressure > load / nominal_area  # False at seizure, where the pressure is NaN
        return OnsetState(pressure, np.where(is_carried, area(np.where(is_carried, pressure, hardness)), np.inf))


@dataclass(frozen=True)
class OnsetState:
    """State of contacts at the onset of sliding.

    Attributes
    ----------
    yield_pressure : float or array, GPa
        Largest pressure: the hardness H, or H' if contacts grow. NaN at seizure.
    area : array, µm²
        True area; infinite at seizure, which includes junctions that cannot carry the load on the nominal area.
    """

    yield_pressure: Any
    area: Floats


def solve_yield_condition(hardness: Any, mu0: Any, tau0: Any, alpha: Any) -> Floats:
    """Solve for the pressure that `hardness_under_shear` returns, without checking the arguments."""
    half_linear_coefficient = alpha * (mu0 * tau0)
    # If the contact seizes, this difference of two squares is zero or negative.
    constant_term = np.square(hardness) - alpha * tau0**2
    with np.errstate(invalid="ignore"):
        pressure = constant_term / (
            half_linear_coefficient + np.sqrt(half_linear_coefficient**2 + (1 + alpha * mu0**2) * constant_term)
        )
    return np.where(constant_term > 0, pressure, np.nan)


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactSums:
    """Sums over contacts (arrays of equal shape) that determine normal and tangential loads for any mu0 and tau0."""

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
    def from_columns(cls, columns: Mapping[str, Any]) -> ContactSums:
        """Create the sums from a mapping of names to arrays, such as the variables of a dataset."""
        check_instance("columns", columns, Mapping, "a mapping of names to arrays")
        if missing_names := [name for name in SUM_QUANTITIES if name not in columns]:
            raise ValueError(f"columns must contain {missing_names[0]}, got {short_repr(list(columns))}")
        return ContactSums(**{name: columns[name] for name in SUM_QUANTITIES})

    def apply(self, function: Callable[[NDArray[Any]], Any]) -> ContactSums:
        """Apply a function, such as indexing or averaging, to every sum, and return the new sums."""
        check_callable("function", function)
        return ContactSums(**{name: function(getattr(self, name)) for name in SUM_QUANTITIES})


@dataclass(frozen=True, eq=False, repr=False)
class Validity(TextReprMixin):
    """Validity indicators of the model. Load fractions refer to the load Σ F n_z and are NaN if there is no contact.

    Attributes
    ----------
    relative_overlap : (k,) ndarray
        Load-weighted mean of overlap/R. Hertz assumes a << R, that is, much less than 1.
    share_beyond_hertz : (k,) ndarray
        Load fraction on contacts with overlap > R/10.
    share_below_grid : (k,) ndarray
        Load fraction on contacts with a radius below the grid spacing, which depend on the grid.
    share_crossed : (k,) ndarray
        Fraction of the possible contacts that were rejected because their sphere centres had crossed.

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
    def from_sums(cls, sums: Any) -> Self:
        """Compute the validity indicators from contact sums."""
        return cls(**{item.name: validity_ratio(item.name, sums) for item in fields(cls)})


@dataclass(frozen=True, eq=False, repr=False)
class SurfaceValidity(Validity):
    """Validity indicators of the model for surfaces. They include all indicators of `Validity` and three more.

    R is the geometric mean of the two radii. No contact is rejected, so `share_crossed` is 0.

    Attributes
    ----------
    share_overlapping : (k,) ndarray
        Load fraction on ellipses that overlap another ellipse in projection: such contacts would merge.
    share_at_edge : (k,) ndarray
        Load fraction on ellipses that the edge of the map cuts; only the part inside counts.
    share_unanswered : (k,) ndarray
        Fraction of the grid minima within the approach that have no minimum of the spline nearby, for example on
        plateaus; NaN without grid minima.

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


VALIDITY_RATIOS: dict[str, tuple[str, tuple[str, ...]]] = {
    name: (quantity.numerator, quantity.denominator)
    for name, quantity in QUANTITIES.items()
    if quantity.kind == "validity"
}
"""Numerator and denominator of each validity indicator, as names of sums."""


def list_validity_sums(name: str) -> list[str]:
    """List the sums from which a validity indicator is computed."""
    numerator, denominator = VALIDITY_RATIOS[name]
    return [numerator, *denominator]


def validity_ratio(name: str, sums: Any) -> Floats:
    """Compute a validity indicator from contact sums. The result is NaN where numerator and denominator are zero.

    The sums are given as a mapping or as attributes.
    """
    numerator, denominator = VALIDITY_RATIOS[name]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(_get_sum(sums, numerator) / sum(_get_sum(sums, item) for item in denominator))


def _get_sum(sums: Any, name: str) -> Any:
    return sums[name] if isinstance(sums, Mapping) else getattr(sums, name)


def sums_per_load(sums: Mapping[str, Any]) -> dict[str, float]:
    """Divide the six contact sums that determine the loads by the elastic load."""
    return {name: float(sums[name] / sums["normal_elastic"]) for name in LOAD_SUM_NAMES}


class FrictionCurve(PlotReprMixin):
    """Loads and friction of a pair at each step (approach or load), computed from stored contact sums."""

    contact_count: NDArray[Any]
    contact_area: Floats
    normal_elastic: Floats
    tangential_elastic: Floats
    effective_modulus: float

    def normal_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """Return the normal load F_N (mN) for mu0 and tau0 (GPa), which are broadcast against each other.

        The shape is the broadcast shape of mu0 and tau0, followed by (k,) for k steps or by (m, k) for m directions.
        """
        return self._broadcast_law(mu0, tau0).load("normal", self)

    def tangential_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """Return the tangential load F_T (mN) at which sliding starts. Shape and arguments are as for `normal_load`."""
        return self._broadcast_law(mu0, tau0).load("tangential", self)

    def friction_coefficient(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """Return F_T / F_N, or NaN where the status is not "ok". Shape and arguments are as for `normal_load`.

        With sliding="all", the ratio is negative if the slopes push the upper body in the direction of motion more
        strongly than friction holds it. The results of `pair` then have the status "downhill" and no coefficient.
        """
        law = self._broadcast_law(mu0, tau0)
        normal_load, tangential_load = law.load("normal", self), law.load("tangential", self)
        is_ok = statuses_of_approaches(self.contact_count, normal_load) == STATUS_OK
        coefficient: Floats = np.divide(
            tangential_load, normal_load, out=np.full(normal_load.shape, np.nan), where=is_ok
        )
        return coefficient

    def status(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> NDArray[np.str_]:
        """Return "ok", "self-locked" (F_N <= 0) or "no-contact". Shape and arguments are as for `normal_load`."""
        normal_load = self._broadcast_law(mu0, tau0).load("normal", self)
        return statuses_of_approaches(self.contact_count, normal_load)

    def plot(self, ax: Axes | None = None, *, mu0: ArrayLike | None = None, tau0: ArrayLike = 0.0) -> Axes:
        """Draw the real contact area or, if mu0 is given, the friction coefficient as a function of the load.

        mu0 and tau0 (GPa) are as for `normal_load`. Draws into given axes or new ones, and returns them.
        """
        if mu0 is None:
            return draw_contact_area(axes_or_new_axes(ax), self.normal_elastic, self.contact_area)
        coefficient = self.friction_coefficient(mu0=mu0, tau0=tau0)
        direction = getattr(self, "direction", 0.0)  # profiles have no attribute `direction`
        return draw_friction(
            axes_or_new_axes(ax), self.normal_elastic, coefficient, mu0=mu0, tau0=tau0, direction=direction
        )

    def _broadcast_law(self, mu0: ArrayLike, tau0: ArrayLike) -> FrictionLaw:
        strengths = validate_friction_parameter("tau0", tau0)
        warn_if_tau0_is_large(strengths, self.effective_modulus)
        parameters = np.broadcast_arrays(validate_friction_parameter("mu0", mu0), strengths)
        # The array axes of mu0 and tau0 precede the array axes of the sums (steps, or directions and steps).
        index = (..., *([np.newaxis] * self.tangential_elastic.ndim))
        return FrictionLaw(parameters[0][index], parameters[1][index])


def choose_statuses(
    *, touched: ArrayLike, reached: ArrayLike, locked: ArrayLike, below: ArrayLike = False
) -> NDArray[Any]:
    """Return the status of each curve, ensemble or member. The boolean arguments are broadcast against each other.

    `locked` refers to the last step. `below` means that the first step already supports more than the load.
    """
    conditions_by_priority: list[tuple[ArrayLike, Status]] = [
        (np.logical_not(touched), STATUS_NO_CONTACT), (reached, STATUS_OK), (below, STATUS_BELOW_RANGE),
        (locked, STATUS_SELF_LOCKED),
    ]  # fmt: skip
    conditions = np.broadcast_arrays(
        *(np.asarray(condition, dtype=np.bool_) for condition, _ in conditions_by_priority)
    )
    return np.select(
        conditions, [np.asarray(status, STATUS_DTYPE) for _, status in conditions_by_priority], STATUS_NOT_REACHED
    )


def statuses_of_approaches(contact_count: ArrayLike, normal: Floats) -> NDArray[Any]:
    """Return "ok", "self-locked" or "no-contact" for each approach, given the contact count and the normal load."""
    return choose_statuses(touched=np.asarray(contact_count) != 0, reached=normal > 0, locked=True)


MAX_FRICTION_PARAMETER = 1e12  # largest accepted mu0 and tau0 (GPa); larger values may overflow


def validate_friction_parameter(name: str, values: ArrayLike) -> Floats:
    """Return mu0 or tau0 as an array of non-negative numbers up to `MAX_FRICTION_PARAMETER`."""
    array = float_array(name, values)
    if not (array <= MAX_FRICTION_PARAMETER).all():
        raise ValueError(f"{name} must be at most {MAX_FRICTION_PARAMETER:g}, got {short_repr(values)}")
    if not (array >= 0).all():
        raise ValueError(f"{name} must not be negative, got {short_repr(values)}")
    return array


def warn_if_tau0_is_large(tau0: Floats, effective_modulus: float) -> None:
    """Warn if tau0 (GPa) is so large compared with E* that its unit is probably wrong by a factor of 1000."""
    max_tau0, is_rubber = float(np.max(tau0, initial=0)), effective_modulus < MAX_RUBBER_MODULUS
    if max_tau0 > (MAX_RUBBER_SHEAR_STRENGTH_RATIO if is_rubber else MAX_SHEAR_STRENGTH_RATIO) * effective_modulus:
        smaller_unit = format_with_unit(max_tau0 / 1000, "GPa").split()[-1]
        warnings.warn(
            f"tau0 = {format_with_unit(max_tau0, 'GPa')} is above {'' if is_rubber else 'a tenth of '}the effective "
            f"modulus {format_with_unit(effective_modulus, 'GPa')}; was it meant in {smaller_unit}?",
            stacklevel=3,
        )


def validate_mu0_and_tau0(mu0: Any, tau0: Any, effective_modulus: Any) -> tuple[float, float]:
    """Check a single mu0 and a single tau0 (GPa), and return them."""
    values = [
        float(validate_friction_parameter(name, validate_number(name, value, unit=unit)))
        for name, value, unit in (("mu0", mu0, ""), ("tau0", tau0, "GPa"))
    ]
    modulus = validate_number("effective_modulus", effective_modulus, unit="GPa", above=0)
    warn_if_tau0_is_large(np.asarray(values[1]), modulus)
    return values[0], values[1]
