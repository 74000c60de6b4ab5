"""Friction law of a contact, and the loads on a pair of surfaces as sums over all contacts.

Each load is elastic + mu0 · frictional + tau0 · adhesive, where each of the three terms is a sum over all contacts.

Hanaor, Gan & Einav (2016), Eqs. 6 and 7 and section 2.5.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal, Self, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiction._core as _core
from stiction._checks import Floats, check_callable, check_instance, float_array, validate_number
from stiction._drawing import draw_contact_area, draw_friction
from stiction._number_format import format_with_unit
from stiction._repr import PlotReprMixin, TextReprMixin, axes_or_new_axes
from stiction._units import short_repr
from stiction._warnings import warn_caller
from stiction.mechanics.materials import MAX_RUBBER_MODULUS
from stiction.mechanics.quantities import (
    QUANTITIES,
    STIFFNESS_PER_AREA_FACTOR,
    STIFFNESS_PER_AREA_QUANTITIES,
    SUM_QUANTITIES,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Status = Literal[
    "ok", "self-locked", "no-contact", "not-reached", "below-range", "not-solved", "seizure", "downhill", "bulk-shear"
]  # fmt: skip
"""Status of a friction coefficient: "ok" if the coefficient exists, or else the reason why it does not exist.

The coefficient of a point with the status "bulk-shear" is a lower limit, because the softer body shears.
"""

# Files store the index of a status, so new statuses must be added at the end of the list.
STATUSES: tuple[Status, ...] = get_args(Status)
STATUS_OK: Status = "ok"
STATUS_SELF_LOCKED: Status = "self-locked"
STATUS_NO_CONTACT: Status = "no-contact"
STATUS_NOT_REACHED: Status = "not-reached"
STATUS_BELOW_RANGE: Status = "below-range"
STATUS_NOT_SOLVED: Status = "not-solved"
STATUS_SEIZURE: Status = "seizure"
STATUS_DOWNHILL: Status = "downhill"
STATUS_BULK_SHEAR: Status = "bulk-shear"
STATUSES_WITH_COEFFICIENT: tuple[Status, ...] = (STATUS_OK, STATUS_BULK_SHEAR)
STATUS_DTYPE = np.dtype(f"<U{max(len(status) for status in STATUSES)}")
_LOAD_CONTRIBUTION_NAMES = ("elastic", "frictional", "adhesive")

LOAD_SUM_NAMES = tuple(f"{load}_{part}" for load in ("normal", "tangential") for part in _LOAD_CONTRIBUTION_NAMES)
"""Names of the sums over contacts that give the normal and the tangential load for any mu0 and tau0."""

NEGLIGIBLE_COEFFICIENT = 1e-9
"""Largest magnitude of a friction coefficient that counts as round-off."""

MAX_SHEAR_STRENGTH_RATIO, MAX_RUBBER_SHEAR_STRENGTH_RATIO = 0.1, 1.0
"""Maximum plausible ratios tau0/E* for stiff bodies, and for rubber and gels.

If a ratio is larger, the unit of tau0 is probably wrong.

The ratio of rubber on glass is usually 0.1 to 0.3. A unit that is wrong by a factor of 1000 gives more than 100.
"""


PLANE_STRAIN_HARDNESS_TO_SHEAR_STRENGTH = 2 + np.pi
"""Ratio H/k of hardness to shear strength that the slip-line formulas assume: a flat punch in plane strain."""

MIN_SHEAR_RATIO, CENTRAL_SHEAR_RATIO, MAX_SHEAR_RATIO = 5.14, 5.6, 6.05
"""Ratios of hardness to shear strength: minimum (plane strain), central value, maximum (rough circular flat punch).

Shield, Proceedings of the Royal Society A 233 (1955) 267; Eason & Shield, ZAMP 11 (1960) 33.
"""

MAX_NEGLECTED_BULK_SHEAR_EFFECT = 0.05
"""Largest relative reduction of the friction force by shear of the softer body that is neglected."""

MIN_TABULATED_MEAN_PRESSURE, NUM_TABLE_ENTRIES_PER_AXIS = 0.005, 256
"""Smallest mean pressure in the table of `_compute_capped_pressure_ratio`, as a fraction of the largest pressure.

The second constant is the number of entries of the table along each axis.
"""

# Number of Newton steps after which the yield pressure by slip-line theory is exact to round-off.
NUM_NEWTON_STEPS_FOR_YIELD_PRESSURE = 3


@dataclass(frozen=True)
class FrictionLaw:
    """Friction law: a contact with normal force F and true area A has the friction force mu0 F + tau0 A.

    Contacts that yield carry less pressure while they are sheared. Their pressure at the onset of sliding follows from
    slip lines, or from p² + α τ² = H². Elastic contacts of soft bodies lose area while they are sheared.

    Attributes
    ----------
    mu0 : float or array
    tau0 : float or array, GPa
    junction_growth : float or array
        α of junction growth, or with slip lines the ratio of hardness to shear strength; 0 if contacts do not grow.
    uses_slip_lines : bool
    area_loss : float or array
        Fraction of their true area that elastic contacts lose before they slide.
    """

    mu0: Any
    tau0: Any
    junction_growth: Any = 0.0
    uses_slip_lines: bool = False
    area_loss: Any = 0.0

    def contributions(self, force: Any, area: Any) -> tuple[Any, Any]:
        """Return two friction forces (mN), one from mu0 and one from tau0, for normal forces (mN) and areas (µm²)."""
        return self.mu0 * force, self.tau0 * area

    def force(self, force: Any, area: Any) -> Any:
        """Return the friction forces (mN) of contacts from their normal forces (mN) and true areas (µm²)."""
        frictional, adhesive = self.contributions(force, area)
        return frictional + adhesive

    def load(self, name: str, sums: Any, area: Any = 1.0, fraction: Any = 1.0) -> Floats:
        """Compute a load (mN), such as "normal" or "tangential", from forces and areas summed over all contacts.

        The sums are given as a mapping or as attributes. The true area is `area` times the area in the sums, and the
        contacts carry a fraction of mu0 F + tau0 A (see `OnsetState`).
        """
        elastic, *strength_sums = (
            _get_sum(sums, f"{name}_{contribution}") for contribution in _LOAD_CONTRIBUTION_NAMES
        )
        frictional, adhesive = self.contributions(*strength_sums)
        return np.asarray(elastic + frictional * fraction + adhesive * (area * fraction))

    def coefficient(self, sums: Any, area: Any = 1.0, fraction: Any = 1.0) -> Floats:
        """Return the ratio of tangential to normal load, computed from forces and areas summed over contacts.

        Arguments are as for `load`.
        """
        tangential, normal = (self.load(name, sums, area, fraction) for name in ("tangential", "normal"))
        return np.asarray(tangential / normal)

    def yield_pressure(self, hardness: Any) -> Any:
        """Return the pressure (GPa) of yielding contacts at the onset of sliding.

        Returns NaN if the contacts seize.

        The pressure is the hardness (GPa) if contacts do not grow. With slip lines, it is at least half the hardness.
        """
        if not np.any(self.junction_growth):
            return hardness
        solve = _solve_slip_lines if self.uses_slip_lines else _solve_yield_condition
        return solve(hardness, self.mu0, self.tau0, self.junction_growth)

    def plastic_coefficient(self, hardness: Any) -> Any:
        """Return the friction coefficient of a pair whose contacts all yield.

        Returns NaN if the contacts seize.

        With slip lines, it is at most 2/R, the coefficient of contacts whose softer body shears. R is the ratio of
        hardness to shear strength.
        """
        coefficient = self.mu0 + self.tau0 / self.yield_pressure(hardness)
        return np.minimum(coefficient, 2 / self.junction_growth) if self.uses_slip_lines else coefficient

    def growth_effect(self, hardness: float) -> float:
        """Return the relative change of friction by junction growth (slip-line theory) if all contacts of a pair yield.

        The change is negative if the softer body shears.
        """
        coefficient_without_growth = float(FrictionLaw(self.mu0, self.tau0).plastic_coefficient(hardness))
        slip_lines = FrictionLaw(self.mu0, self.tau0, CENTRAL_SHEAR_RATIO, uses_slip_lines=True)
        return (
            float(slip_lines.plastic_coefficient(hardness)) / coefficient_without_growth - 1
            if coefficient_without_growth > 0
            else 0.0
        )

    def is_stronger_than_body(self, hardness: Any) -> Any:
        """Return whether a body with a given hardness (GPa) shears before its yielding contacts slide."""
        if not self.uses_slip_lines:
            return self.bulk_strength_ratio(hardness) >= 1
        return self.force(0.5 * hardness, 1.0) > hardness / self.junction_growth

    def bulk_strength_ratio(self, hardness: Any) -> Any:
        """Return tau0 divided by the shear strength of a body with the hardness H (GPa).

        The shear strength is k for slip lines, and H/√α otherwise.
        """
        hardness_to_shear_strength = self.junction_growth if self.uses_slip_lines else np.sqrt(self.junction_growth)
        return self.tau0 * hardness_to_shear_strength / hardness

    def onset(
        self, load: Any, hardness: Any, nominal_area: float, area: Callable[[Any], Floats], pressure: Any = None
    ) -> OnsetState:
        """Return true area and friction at the onset of sliding, for contacts that carry a given load (mN).

        Parameters
        ----------
        load : float or array, mN
        hardness : float or array, GPa
            None for elastic contacts.
        nominal_area : float, µm²
        area : callable
            Function from the largest pressure (GPa), or None, to the true area (µm²) at this load.
        pressure : float or array, GPa, optional
            Result of `yield_pressure` for the hardness, if computed before.
        """
        if hardness is None:
            return OnsetState(np.nan, area(None) * (1 - np.asarray(self.area_loss)), np.ones(()))
        pressure = self.yield_pressure(hardness) if pressure is None else pressure
        plastic_coefficient = self.mu0 + self.tau0 / pressure
        if not self.uses_slip_lines:
            # If the contact seizes, `pressure` is NaN, so the comparison gives False.
            is_carried = pressure > load / nominal_area
            area_at_onset = np.where(is_carried, area(np.where(is_carried, pressure, hardness)), np.inf)
            return OnsetState(plastic_coefficient, area_at_onset, np.ones(()))
        area_at_onset = area(pressure)
        # If the yield pressure on the nominal area cannot carry the load, contacts cover the whole nominal area.
        can_shear = self.is_stronger_than_body(hardness) | (pressure <= load / nominal_area)
        if not np.any(can_shear):
            return OnsetState(plastic_coefficient, area_at_onset, np.ones(()))
        friction_fraction = self._compute_remaining_friction_fraction(
            load, area_at_onset, np.maximum(pressure, load / nominal_area), hardness
        )
        friction_fraction = np.where(can_shear, friction_fraction, 1.0)
        limited_coefficient = np.minimum(plastic_coefficient, 2 / self.junction_growth)
        return OnsetState(
            np.where(friction_fraction < 1, limited_coefficient, plastic_coefficient), area_at_onset, friction_fraction
        )

    def _compute_remaining_friction_fraction(self, load: Any, area: Any, pressure: Any, hardness: Any) -> Floats:
        """Return the fraction of the friction force that remains when the softer body's shear strength limits friction.

        The traction at each point is the smaller of mu0 p + tau0 and the shear strength k. The pressures p follow a
        Weibull distribution over the true area, which is limited at `pressure` and has the mean load/area. The
        fraction is 1 if the reduction is negligible.
        """
        strength = hardness / self.junction_growth
        mean_pressure = np.minimum(load / area, pressure)
        frictional, adhesive = self.contributions(mean_pressure, 1.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            limit_pressure = np.where(np.asarray(self.mu0) > 0, (strength - self.tau0) / np.asarray(self.mu0), np.inf)
            relative_limit = np.clip(limit_pressure / pressure, 0.0, 1.0)
            limited_traction = frictional * _compute_capped_pressure_ratio(
                relative_limit, mean_pressure / pressure
            ) + np.minimum(adhesive, strength)
            fraction = limited_traction / (frictional + adhesive)
        return np.where(fraction < 1 - MAX_NEGLECTED_BULK_SHEAR_EFFECT, fraction, 1.0)


@dataclass(frozen=True)
class OnsetState:
    """True area of a pair at the onset of sliding, and its friction coefficient if all contacts yield.

    Attributes
    ----------
    plastic_coefficient : float or array
        Friction coefficient if all contacts yield. NaN at seizure and for elastic contacts. Where almost no
        contact yields, the shear strength of the softer body does not limit this coefficient.
    area : array, µm²
        True area; infinite at seizure, which includes junctions that cannot carry the load on the nominal area.
    friction_fraction : array
        Fraction of mu0 F + tau0 A that contacts carry. The fraction is below 1 where the interface is stronger than the
        softer body, which shears instead: the friction force is then a lower limit, because junctions grow while they
        slide.
    """

    plastic_coefficient: Any
    area: Floats
    friction_fraction: Floats


def _solve_slip_lines(hardness: Any, mu0: Any, tau0: Any, shear_ratio: Any) -> Floats:
    """Compute the pressure p at which a contact with shear traction mu0 p + tau0 yields (slip-line theory).

    With f = τ/k, slip lines give p/H = (1 + π/2 + arccos f + sqrt(1 - f²))/(2 + π). Half the hardness is returned if
    p = H/2 has f > 1: the interface is stronger than the softer body. The unknown of the Newton steps is
    x = sin(arccos(f)/2). The function is concave in x, and the first value is on the side of the root from which the
    steps are monotone.
    """
    slope = np.asarray(shear_ratio * mu0 / PLANE_STRAIN_HARDNESS_TO_SHEAR_STRENGTH)
    margin = np.maximum(1 - shear_ratio * tau0 / hardness - slope * (1 + np.pi / 2), 0.0)
    linear_coefficient = slope * (1 + np.pi / 2) * np.sqrt(2.0)
    # If mu0 is 0 and tau0 equals the shear strength, x is 0/0, which `np.fmax` replaces by 0.
    with np.errstate(invalid="ignore"):
        x = np.fmax(2 * margin / (linear_coefficient + np.sqrt(linear_coefficient**2 + 8 * margin)), 0.0)
        x = np.minimum(x, np.sqrt(0.5))
        for _ in range(NUM_NEWTON_STEPS_FOR_YIELD_PRESSURE if x.any() else 0):
            cosine = np.sqrt(1 - x**2)
            residual = margin - 2 * x**2 - slope * (2 * np.arcsin(x) + 2 * x * cosine)
            x = np.minimum(np.fmax(x + residual / (4 * (x + slope * cosine)), 0.0), np.sqrt(0.5))
    sector = 2 * np.arcsin(x) + 2 * x * np.sqrt(1 - x**2)
    return np.asarray(hardness * ((1 + np.pi / 2 + sector) / PLANE_STRAIN_HARDNESS_TO_SHEAR_STRENGTH))


def _compute_capped_pressure_ratio(limit: Any, mean: Any) -> Floats:
    """Return the mean of min(p, limit), divided by the mean of p, for pressures p with a Weibull distribution.

    The fraction is interpolated in a table, with errors below 1e-4.
    """
    table = _tabulate_capped_pressure_ratios()
    positions = (mean - MIN_TABULATED_MEAN_PRESSURE) / (1 - MIN_TABULATED_MEAN_PRESSURE), limit / (limit + mean)
    rows, columns = np.broadcast_arrays(
        *(position * (size - 1) for position, size in zip(positions, table.shape, strict=True))
    )
    ratios = _core.interpolate_table(table, rows.ravel(), columns.ravel()).reshape(rows.shape)
    return np.where(limit >= 1, 1.0, ratios)


@lru_cache(maxsize=1)
def _tabulate_capped_pressure_ratios() -> Floats:
    """Tabulate mean(min(p, limit)) / mean(p) of Weibull-distributed p against mean(p) and limit/(limit + mean(p)).

    A pressure exceeds p < 1 with the probability exp(-rate p^shape). The shape, 1.5 - 0.65 mean(p), was fitted to rough
    pairs from elastic to plastic contact. The rates are found by bisection.
    """
    from scipy.special import gamma, gammainc

    mean_pressures = np.linspace(MIN_TABULATED_MEAN_PRESSURE, 1.0, NUM_TABLE_ENTRIES_PER_AXIS)[:, np.newaxis]
    # The tabulated mean pressures end slightly below 1, where `rate` would be 0 and its logarithm infinite.
    mean_pressures = np.minimum(mean_pressures, 0.9999)
    shape = 1.5 - 0.65 * mean_pressures
    log_low, log_high = np.full_like(mean_pressures, -12.0), np.full_like(mean_pressures, 12.0)
    for _ in range(60):
        log_middle = 0.5 * (log_low + log_high)
        rate = np.exp(log_middle)
        is_mean_larger = gamma(1 / shape) * gammainc(1 / shape, rate) / shape / rate ** (1 / shape) > mean_pressures
        log_low, log_high = (
            np.where(is_mean_larger, log_middle, log_low),
            np.where(is_mean_larger, log_high, log_middle),
        )
    ratios = np.linspace(0.0, 1.0, NUM_TABLE_ENTRIES_PER_AXIS)
    with np.errstate(divide="ignore"):
        limits = mean_pressures * ratios / (1 - ratios)
    return np.asarray(gammainc(1 / shape, rate * limits**shape) / gammainc(1 / shape, rate))


def _solve_yield_condition(hardness: Any, mu0: Any, tau0: Any, alpha: Any) -> Floats:
    """Return the pressure p at which a sliding contact yields: p² + α (mu0 p + tau0)² = H²."""
    half_linear_coefficient = alpha * (mu0 * tau0)
    # The contact seizes if α tau0² is at least H², that is, if `constant_term` is not positive.
    constant_term = np.square(hardness) - alpha * tau0**2
    with np.errstate(invalid="ignore"):
        pressure = constant_term / (
            half_linear_coefficient + np.sqrt(half_linear_coefficient**2 + (1 + alpha * mu0**2) * constant_term)
        )
    return np.where(constant_term > 0, pressure, np.nan)


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactSums:
    """Areas and forces summed over all contacts of a pair, from which loads follow for any mu0 and tau0."""

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
        """Create contact sums (forces and areas) from a mapping of names to arrays, such as a dataset."""
        check_instance("columns", columns, Mapping, "a mapping of names to arrays")
        if missing_names := [name for name in SUM_QUANTITIES if name not in columns]:
            raise ValueError(f"columns must contain {missing_names[0]}, got {short_repr(list(columns))}")
        return ContactSums(**{name: columns[name] for name in SUM_QUANTITIES})

    def apply(self, function: Callable[[NDArray[Any]], Any]) -> ContactSums:
        """Apply a function, such as indexing, to all sums of forces and areas, and return the results as new sums."""
        check_callable("function", function)
        return ContactSums(**{name: function(getattr(self, name)) for name in SUM_QUANTITIES})


@dataclass(frozen=True, eq=False, repr=False)
class Validity(TextReprMixin):
    """Validity indicators of the asperity model at each approach (µm), such as the mean of overlap / radius.

    Load fractions are NaN without contact.

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
        """Compute the validity indicators of the asperity model from forces and areas summed over all contacts."""
        return cls(**{item.name: validity_ratio(item.name, sums) for item in fields(cls)})


@dataclass(frozen=True, eq=False, repr=False)
class SurfaceValidity(Validity):
    """Validity indicators of the asperity model for two height maps, such as the load fraction at map edges.

    Contacts at an edge extend beyond the map.

    R is the geometric mean of the two radii. No contact is rejected, so `share_crossed` is 0.

    Attributes
    ----------
    share_overlapping : (k,) ndarray
        Load fraction on ellipses that overlap another ellipse in projection: such contacts would merge.
    share_at_edge : (k,) ndarray
        Load fraction on ellipses that the edge of the map cuts; only the part inside counts.
    share_unanswered : (k,) ndarray
        Fraction of the grid minima within the approach that have no minimum of the spline nearby, for example on
        plateaus; NaN if there are no grid minima.

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
"""Names of the contact sums in the numerator and in the denominator of each validity indicator."""


def validity_ratio(name: str, sums: Any) -> Floats:
    """Compute one validity indicator of the asperity model from forces and areas summed over all contacts.

    Returns NaN if numerator and denominator are zero.

    The sums are given as a mapping or as attributes.
    """
    numerator, denominator = VALIDITY_RATIOS[name]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(_get_sum(sums, numerator) / sum(_get_sum(sums, item) for item in denominator))


def compute_ratios(sums: Mapping[str, Floats], load: Floats, nominal_area: float | None = None) -> dict[str, Floats]:
    """Compute ratios such as the mean pressure at a load (mN), from forces and areas summed over contacts.

    The sums belong to a member, or are means over an ensemble. Area fraction, nominal pressure and stiffnesses per area
    require the nominal area (µm²). The keys of the returned mapping are names of quantities.
    """
    ratios: dict[str, Floats] = {}
    if nominal_area is not None:
        ratios["contact_area_fraction"] = sums["contact_area"] / nominal_area
        ratios["nominal_pressure"] = load / nominal_area
        for name in STIFFNESS_PER_AREA_QUANTITIES:
            if (stiffness := QUANTITIES[name].numerator) in sums:
                ratios[name] = STIFFNESS_PER_AREA_FACTOR * sums[stiffness] / nominal_area
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios["mean_pressure"] = sums.get("contact_load", load) / sums["contact_area"]
    return ratios | {
        name: validity_ratio(name, sums)
        for name, (numerator, _) in VALIDITY_RATIOS.items()
        if numerator in sums and name not in sums
    }


def _get_sum(sums: Any, name: str) -> Any:
    return sums[name] if isinstance(sums, Mapping) else getattr(sums, name)


def sums_per_load(sums: Mapping[str, Any]) -> dict[str, float]:
    """Divide the forces and areas summed over all contacts by the normal load without friction.

    These sums determine the normal and the tangential load.
    """
    return {name: float(sums[name] / sums["normal_elastic"]) for name in LOAD_SUM_NAMES}


class FrictionCurve(PlotReprMixin):
    """Normal load, tangential load and friction coefficient of a pair of surfaces at each loading step."""

    contact_count: NDArray[Any]
    contact_area: Floats
    normal_elastic: Floats
    tangential_elastic: Floats
    effective_modulus: float

    def normal_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """Return the normal load F_N (mN) at each loading step.

        The arrays of mu0 and tau0 (GPa) are broadcast.

        The shape is the broadcast shape of mu0 and tau0, followed by (k,) for k steps or by (m, k) for m directions.
        """
        return self._broadcast_friction_law(mu0, tau0).load("normal", self)

    def tangential_load(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """Return the tangential load F_T (mN) at the onset of sliding, for each loading step.

        Shape and arguments are as for `normal_load`.
        """
        return self._broadcast_friction_law(mu0, tau0).load("tangential", self)

    def friction_coefficient(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> Floats:
        """Return the friction coefficient F_T / F_N at each loading step, or NaN where the status is not "ok".

        Arguments: as for `normal_load`.

        With sliding="all", the ratio is negative if the slopes push the upper body in the direction of motion more
        strongly than friction holds it. The results of `pair` then have the status "downhill" and no coefficient.
        """
        law = self._broadcast_friction_law(mu0, tau0)
        normal_load, tangential_load = law.load("normal", self), law.load("tangential", self)
        is_ok = statuses_of_approaches(self.contact_count, normal_load) == STATUS_OK
        coefficient: Floats = np.divide(
            tangential_load, normal_load, out=np.full(normal_load.shape, np.nan), where=is_ok
        )
        return coefficient

    def status(self, *, mu0: ArrayLike, tau0: ArrayLike = 0.0) -> NDArray[np.str_]:
        """Return the status ("ok", "self-locked" or "no-contact") at each loading step for given mu0 and tau0 (GPa).

        The status is "self-locked" if friction makes the normal load F_N zero or negative.
        """
        normal_load = self._broadcast_friction_law(mu0, tau0).load("normal", self)
        return statuses_of_approaches(self.contact_count, normal_load)

    def plot(self, ax: Axes | None = None, *, mu0: ArrayLike | None = None, tau0: ArrayLike = 0.0) -> Axes:
        """Draw the true contact area or, if mu0 is given, the friction coefficient against the load.

        mu0 and tau0 (GPa) are as for `normal_load`. Draws into the given axes or into new axes, and returns the axes.
        """
        if mu0 is None:
            return draw_contact_area(axes_or_new_axes(ax), self.normal_elastic, self.contact_area)
        coefficient = self.friction_coefficient(mu0=mu0, tau0=tau0)
        direction = getattr(self, "direction", 0.0)
        return draw_friction(
            axes_or_new_axes(ax), self.normal_elastic, coefficient, mu0=mu0, tau0=tau0, direction=direction
        )

    def _broadcast_friction_law(self, mu0: ArrayLike, tau0: ArrayLike) -> FrictionLaw:
        strengths = validate_friction_parameter("tau0", tau0)
        warn_if_tau0_is_large(strengths, self.effective_modulus)
        parameters = np.broadcast_arrays(validate_friction_parameter("mu0", mu0), strengths)
        # The arrays of mu0 and tau0 get new axes at the end, for directions and loading steps.
        index = (..., *([np.newaxis] * self.tangential_elastic.ndim))
        return FrictionLaw(parameters[0][index], parameters[1][index])


def choose_statuses(
    *, touched: ArrayLike, reached: ArrayLike, locked: ArrayLike, below: ArrayLike = False
) -> NDArray[Any]:
    """Choose the status, such as "ok" or "no-contact", of each load curve at each requested load.

    `touched`: there is a contact. `reached`: the curve reaches the load. `locked`: the contacts are self-locked at the
    last loading step. `below`: the first loading step already supports more than the load.
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
    """Return the status "ok", "self-locked" or "no-contact" for given contact counts and normal loads (mN)."""
    return choose_statuses(touched=np.asarray(contact_count) != 0, reached=normal > 0, locked=True)


# Upper limit of mu0 and of tau0 (GPa): with larger numbers, computations may overflow.
MAX_FRICTION_PARAMETER = 1e12


def validate_friction_parameter(name: str, values: ArrayLike) -> Floats:
    """Check that all given mu0 or tau0 are between 0 and `MAX_FRICTION_PARAMETER`, and return them as an array."""
    array = float_array(name, values)
    if not (array <= MAX_FRICTION_PARAMETER).all():
        raise ValueError(f"{name} must be at most {MAX_FRICTION_PARAMETER:g}, got {short_repr(values)}")
    if not (array >= 0).all():
        raise ValueError(f"{name} must not be negative, got {short_repr(values)}")
    return array


def warn_if_tau0_is_large(tau0: Floats, effective_modulus: float) -> None:
    """Warn if tau0 (GPa) is so large compared with E* that its unit is probably wrong."""
    max_tau0, is_rubber = float(np.max(tau0, initial=0)), effective_modulus < MAX_RUBBER_MODULUS
    if max_tau0 > (MAX_RUBBER_SHEAR_STRENGTH_RATIO if is_rubber else MAX_SHEAR_STRENGTH_RATIO) * effective_modulus:
        smaller_unit = format_with_unit(max_tau0 / 1000, "GPa").split()[-1]
        warn_caller(
            f"tau0 = {format_with_unit(max_tau0, 'GPa')} is above {'' if is_rubber else 'a tenth of '}the effective "
            f"modulus {format_with_unit(effective_modulus, 'GPa')}; was it meant in {smaller_unit}?"
        )


def validate_mu0_and_tau0(mu0: Any, tau0: Any, effective_modulus: Any) -> tuple[float, float]:
    """Check a single mu0 and a single tau0 (GPa), and return both as floats.

    Warn if tau0 is large compared with E*.
    """
    strengths = [
        float(validate_friction_parameter(name, validate_number(name, value, unit=unit)))
        for name, value, unit in (("mu0", mu0, ""), ("tau0", tau0, "GPa"))
    ]
    modulus = validate_number("effective_modulus", effective_modulus, unit="GPa", above=0)
    warn_if_tau0_is_large(np.asarray(strengths[1]), modulus)
    return strengths[0], strengths[1]
