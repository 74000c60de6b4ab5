"""Table of quantities: unit, names, dimensions and use of every number that a result contains.

All lists of quantities are selections from `QUANTITIES`. The order of the table is the order of rows in text, reports
and CSV files.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import stiction._core

Kind = Literal["sum", "statistic", "ratio", "validity", "uncertainty", "coordinate"]
"""Sum over contacts, number of a member, quotient, figure of validity, uncertainty of a mean, or coordinate."""

Axis = Literal["sliding", "direction", "axis", "step", "mu0", "tau0", "fraction_below", "fraction", "input", "wait"]
"""Dimension of a quantity behind cells and members; `step` is the approach or the load."""

Source = Literal["asperities", "areal", "half-space", "adhesion", "onset", "measured"]
"""Studies whose results store a quantity: asperities, asperities of surfaces, the half-space, bodies that adhere,
generated bodies with an onset of sliding, and measured bodies."""

Interval = Literal["sampling", "combined", "prediction", "conditional"]
"""Interval of the mean over members, of all uncertain inputs, of one more test, or of the inputs if one were known."""

View = Literal["table", "verbose", "report", "csv", "hatch"]
"""Table of a result, its verbose table, selection list of the report, CSV file, and hatching of maps."""


@dataclass(frozen=True, kw_only=True)
class ResultQuantity:
    """Properties of a quantity of results, of a coordinate or of a dimension."""

    unit: str
    words: str  # phrase for axes and datasets
    brief: str = ""  # a few words for tables, if `words` are too long
    symbol: str = ""  # in TeX
    kind: Kind
    along: tuple[Axis, ...] = ()
    dtype: type = float
    numerator: str = ""  # quantity that a ratio is a fraction of; of an unloaded sum the sum under load
    denominator: tuple[str, ...] = ()  # quantities whose sum a ratio is divided by
    bounds: tuple[float, float] = (-math.inf, math.inf)  # limits of the ends of an interval
    interval: Interval = "sampling"  # 95 % interval of a mean
    percent: bool = False  # in tables and reports
    column_unit: str = ""  # unit in spreadsheets, if it is not `unit`
    column_factor: float = 1.0
    proportional: bool = False  # roughly, to the load: interpolated over its logarithm
    weighted: bool = False  # by load, in the mean over an ensemble
    bound_fraction: str = ""  # quantity that is the fraction of members which contribute only a lower bound
    stored: frozenset[Source] = frozenset()
    shown: frozenset[View] = frozenset()

    @property
    def short(self) -> str:
        """Words for tables."""
        return self.brief or self.words

    @property
    def directed(self) -> bool:
        """True if the quantity depends on the sliding rule and the direction."""
        return "sliding" in self.along


CORE_SUMS = {name: (unit, words) for name, unit, words in stiction._core.quantities()}
AREAL_CORE_SUMS = {name: (unit, words) for name, unit, words in stiction._core.areal_quantities()}
"""Units and words of sums as the core declares them, in its order."""

_STEP: tuple[Axis, ...] = ("step",)
_MOTION: tuple[Axis, ...] = ("sliding", "direction")
_FRICTION: tuple[Axis, ...] = (*_MOTION, "step", "mu0", "tau0")
_MEAN_FRICTION: tuple[Axis, ...] = ("sliding", "step", "mu0", "tau0")
_FRACTION: dict[str, Any] = {"unit": "1", "percent": True, "bounds": (-math.inf, 1.0)}
_EVERYWHERE: frozenset[View] = frozenset({"table", "report", "csv"})
_VERBOSE_VIEWS: frozenset[View] = frozenset({"verbose", "report", "csv"})
_VERBOSE_TABLE: frozenset[View] = frozenset({"verbose", "csv"})
_CSV: frozenset[View] = frozenset({"csv"})
_MEASURED: frozenset[Source] = frozenset({"measured"})


def _sum(name: str, *more: Source, **properties: Any) -> ResultQuantity:
    """Return the entry of a sum of the core, which declares its unit and words."""
    unit, words = CORE_SUMS[name] if name in CORE_SUMS else AREAL_CORE_SUMS[name]
    source: Source = "asperities" if name in CORE_SUMS else "areal"
    of_sum: dict[str, Any] = {"kind": "sum", "along": _STEP, "stored": frozenset({source, *more})}
    return ResultQuantity(unit=unit, words=words, **of_sum | properties)


def _directed_sums() -> dict[str, ResultQuantity]:
    along = (*_MOTION, "step")
    normal: dict[str, ResultQuantity] = {
        f"normal_{part}": _sum(f"normal_{part}", "half-space", along=along) for part in ("frictional", "adhesive")
    }
    parts = ("elastic", "frictional", "adhesive")
    tangential = {f"tangential_{part}": _sum(f"tangential_{part}", "half-space", along=along) for part in parts}
    return normal | tangential | {f"lateral_{part}": _sum(f"lateral_{part}", along=along) for part in parts}


def _unloaded(part: str, unit: str) -> ResultQuantity:
    return ResultQuantity(
        unit=unit, words=f"{part} part of the tangential load at no normal load", kind="sum", along=_MOTION,
        numerator=f"tangential_{part}", stored=frozenset({"adhesion"}),
    )  # fmt: skip


def _validity(numerator: str, *denominator: str, percent: bool = True, **properties: Any) -> ResultQuantity:
    own: dict[str, Any] = {"kind": "validity", "along": _STEP, "shown": _VERBOSE_TABLE} | properties
    kind = _FRACTION if percent else {"unit": "1"}
    return ResultQuantity(numerator=numerator, denominator=denominator, **kind | own)


def _statistic(unit: str, words: str, brief: str = "", **properties: Any) -> ResultQuantity:
    own: dict[str, Any] = {"kind": "statistic", "along": _STEP} | properties
    return ResultQuantity(unit=unit, words=words, brief=brief, **own)


def _uncertainty(words: str, interval: Interval, *along: Axis) -> ResultQuantity:
    along = (*_MEAN_FRICTION, *along)
    return ResultQuantity(unit="1", words=words, kind="uncertainty", along=along, interval=interval)


def _coordinate(unit: str, words: str, brief: str = "", **properties: Any) -> ResultQuantity:
    return ResultQuantity(unit=unit, words=words, brief=brief, kind="coordinate", **properties)


QUANTITIES: dict[str, ResultQuantity] = {
    # ---- Friction --------------------------------------------------------------------------------------------------
    "friction_combined": _uncertainty("coefficient of static friction, 95 % combined uncertainty", "combined"),
    "friction_coefficient": ResultQuantity(
        unit="1", words="coefficient of static friction", symbol=r"\mu_s", kind="ratio", along=_FRICTION,
        numerator="tangential_load", denominator=("normal_load",),
    ),
    "friction_all_round": ResultQuantity(
        unit="1", words="friction coefficient, mean of directions", kind="ratio", along=_MEAN_FRICTION,
    ),
    "friction_by_axis": ResultQuantity(
        unit="1", words="friction coefficient, both senses", kind="ratio", along=(*_MEAN_FRICTION, "axis"),
    ),
    "gentle_friction": ResultQuantity(
        unit="1", words="friction coefficient by the slope of the gap alone", brief="by the slopes alone",
        kind="statistic", along=(*_MOTION, "mu0", "tau0"),
    ),
    "normal_load": ResultQuantity(
        unit="mN", words="normal load while sliding starts, friction on slopes included", kind="sum", along=_FRICTION,
        shown=_CSV,
    ),
    "tangential_load": ResultQuantity(
        unit="mN", words="tangential load that starts the sliding", kind="sum", along=_FRICTION, shown=_CSV,
    ),
    "lateral_load": ResultQuantity(
        unit="mN", words="lateral load that keeps the upper body on its way", kind="sum", along=_FRICTION,
    ),
    "status": ResultQuantity(
        unit="", words="whether the value exists, or why not", kind="statistic", along=_STEP, dtype=int,
        stored=_MEASURED,
    ),
    "friction_known": _uncertainty("coefficient of static friction, 95 % of everything known", "combined"),
    "friction_next_test": _uncertainty(
        "coefficient of static friction of one test, one way, at one position", "prediction",
    ),
    "friction_if_known": _uncertainty("interval if an input were known", "conditional", "input"),
    "width_if_known": _uncertainty("width if an input were known", "conditional", "input"),
    "friction_waited": _uncertainty("coefficient of static friction after waiting under load", "combined", "wait"),
    "fraction_seizing": ResultQuantity(
        unit="1", words="fraction of the samples of the inputs whose interfaces seize", kind="statistic",
        along=_MEAN_FRICTION,
    ),
    "spread_low": ResultQuantity(
        unit="1", words="10 % quantile of the members", kind="statistic", along=_MEAN_FRICTION,
    ),
    "spread_high": ResultQuantity(
        unit="1", words="90 % quantile of the members", kind="statistic", along=_MEAN_FRICTION,
    ),
    "ok": ResultQuantity(unit="1", words="members with a coefficient", kind="statistic", along=_FRICTION, dtype=int),
    "members": ResultQuantity(unit="1", words="members", kind="statistic", dtype=int),
    # ---- Contact at a load -----------------------------------------------------------------------------------------
    "contact_area_fraction": ResultQuantity(
        unit="1", words="true over nominal contact area", brief="true area A/A0", kind="ratio", along=_STEP,
        numerator="contact_area", denominator=("nominal_area",), percent=True, shown=_EVERYWHERE,
    ),
    "contact_status": ResultQuantity(
        unit="", words="status of the true contact area", kind="statistic", along=_STEP, dtype=str,
    ),
    "contact_area": _sum("contact_area", "half-space", symbol="A", proportional=True, shown=_EVERYWHERE),
    "contact_area_at_onset": ResultQuantity(
        unit="um^2", words="true contact area at the onset of sliding, with junction growth",
        brief="true area at the onset", kind="statistic", along=("step", "mu0", "tau0"), shown=_VERBOSE_TABLE,
    ),
    "contact_count": _sum("contact_count", "half-space", dtype=int, proportional=True, shown=_EVERYWHERE),
    "mean_pressure": ResultQuantity(
        unit="GPa", words="mean pressure in contact", kind="ratio", along=_STEP, numerator="contact_load",
        denominator=("contact_area",), shown=_EVERYWHERE,
    ),
    "normal_stiffness": _statistic("mN/um", "normal stiffness", stored=_MEASURED, shown=_EVERYWHERE),
    "closure": _statistic(
        "um", "closure, the mean gap lost since first touch", "closure", stored=_MEASURED, shown=_EVERYWHERE,
    ),
    "closure_stiffness": _statistic(
        "MPa/mm", "nominal pressure over closure, incremental", "stiffness of closure", stored=_MEASURED,
        shown=_EVERYWHERE,
    ),
    "contact_load": ResultQuantity(
        unit="mN", words="load of the contacts, of the normal load and the attraction", brief="contact load",
        kind="sum", along=_STEP, proportional=True, stored=frozenset({"adhesion"}), shown=_EVERYWHERE,
    ),
    "pull_off": ResultQuantity(
        unit="mN", words="pull-off force", kind="statistic", bound_fraction="share_of_pull_off_bounds",
        stored=frozenset({"adhesion"}), shown=frozenset({"table", "csv"}),
    ),
    "pull_off_pressure": ResultQuantity(
        unit="GPa", words="pull-off force over the nominal area", brief="pull-off pressure", kind="ratio",
        numerator="pull_off", denominator=("nominal_area",), bound_fraction="share_of_pull_off_bounds",
        shown=frozenset({"table", "csv"}),
    ),
    "friction_at_no_load": ResultQuantity(
        unit="mN", words="tangential load that starts the sliding at no load", brief="friction at no load",
        kind="sum", along=("sliding", "mu0", "tau0"), shown=frozenset({"table", "csv"}),
    ),
    "tangential_stiffness": _statistic(
        "mN/um", "tangential stiffness at rest", proportional=True, stored=frozenset({"onset"}),
        shown=frozenset({"table", "csv"}),
    ),
    "displacement_at_sliding": _statistic(
        "um", "displacement of the upper body before it slides", "creep before sliding", weighted=True,
        stored=frozenset({"onset"}), shown=frozenset({"table", "csv"}),
    ),
    "fraction_slipped": _statistic(
        **_FRACTION, words="fraction of the normal load on what slips at half of the sliding load",
        brief="load that slips at half of sliding", weighted=True, stored=frozenset({"onset"}),
        shown=frozenset({"table", "csv"}),
    ),
    "approach": _coordinate(
        "um", "approach since first touch", along=_STEP, stored=frozenset({"half-space"}), shown=_VERBOSE_VIEWS,
    ),
    "stiffness_per_area": ResultQuantity(
        unit="GPa/mm", words="normal stiffness per area while loading", kind="ratio", along=_STEP,
        numerator="normal_stiffness", denominator=("nominal_area",), shown=_VERBOSE_VIEWS,
    ),
    "unloading_stiffness_per_area": ResultQuantity(
        unit="GPa/mm", words="normal stiffness per area while unloading (ultrasonic)", kind="ratio", along=_STEP,
        numerator="unloading_stiffness", denominator=("nominal_area",), shown=_VERBOSE_VIEWS,
    ),
    "share_opposing": ResultQuantity(
        **_FRACTION, words="fraction of the load on contacts that oppose the motion", brief="load that opposes",
        kind="ratio", along=("direction", "step"), shown=_VERBOSE_TABLE,
    ),
    "share_on_largest": _statistic(
        **_FRACTION, words="fraction of the load on the contact that carries most", brief="load on the largest contact",
        stored=_MEASURED, shown=_VERBOSE_VIEWS,
    ),
    "share_at_edge": _validity(
        "load_at_edge", "normal_elastic", words="fraction of the load on contacts that reach the edge of the overlap",
        brief="load on contacts at the edge", stored=_MEASURED, shown=_VERBOSE_VIEWS,
    ),
    "fraction_on_small": _statistic(
        **_FRACTION, words="fraction of the load on contacts of at most four grid cells",
        brief="load on contacts of 4 points or fewer", stored=_MEASURED, shown=_VERBOSE_VIEWS,
    ),
    **{
        f"share_on_steepest_{side}": _statistic(
            **_FRACTION, words=f"fraction of the load on the steepest tenth of the {side} body",
            brief=f"load on the {side}'s steepest tenth", stored=_MEASURED, shown=_VERBOSE_TABLE,
        )
        for side in ("upper", "lower")
    },
    "load_share_at_hardness": _statistic(
        **_FRACTION, words="fraction of the load where the pressure is the hardness", stored=frozenset({"half-space"}),
        shown=_VERBOSE_VIEWS,
    ),
    "area_share_at_hardness": _statistic(
        **_FRACTION, words="fraction of the points under pressure where that is the hardness",
        stored=frozenset({"half-space"}), shown=_VERBOSE_TABLE,
    ),
    "relative_overlap": _validity(
        "overlap_load", "normal_elastic", percent=False, words="load-weighted mean of overlap / radius",
    ),
    "share_beyond_hertz": _validity(
        "load_beyond_hertz", "normal_elastic",
        words="fraction of the load on contacts with an overlap above a tenth of their radius",
        shown=_VERBOSE_VIEWS | {"hatch"},
    ),
    "share_below_grid": _validity(
        "load_below_grid", "normal_elastic",
        words="fraction of the load on contacts with a radius below the grid spacing", shown=_VERBOSE_VIEWS | {"hatch"},
    ),
    "share_crossed": _validity(
        "crossed_count", "crossed_count", "contact_count",
        words="fraction of would-be contacts refused because their sphere centres had crossed",
    ),
    "share_overlapping": _validity(
        "load_overlapping", "normal_elastic", shown=_VERBOSE_VIEWS,
        words="fraction of the load on contacts whose ellipse overlaps another one",
    ),
    "share_unanswered": _validity(
        "unanswered_count", "grid_minimum_count",
        words="fraction of the grid's minima beside which the spline has none", shown=frozenset(),
    ),
    "error": _statistic(
        "1", "error of the half-space, in deviations of the gap", "error of the solution", stored=_MEASURED,
        shown=_VERBOSE_TABLE,
    ),
    "unloading_stiffness": _statistic(
        "mN/um", "normal stiffness, unloading or by ultrasound", stored=_MEASURED, shown=_CSV,
    ),
    "nominal_pressure": ResultQuantity(
        unit="GPa", words="normal load over nominal area", brief="pressure on the nominal area", kind="ratio",
        along=_STEP, numerator="normal_elastic", denominator=("nominal_area",), shown=_CSV,
    ),
    "share_of_pull_off_bounds": ResultQuantity(
        **_FRACTION, words="fraction of the members whose pull-off force is a lower bound or missing", kind="statistic",
        shown=_CSV,
    ),
    "pull_off_is_bound": ResultQuantity(
        unit="1", words="1 where the pull-off force is at least the value, 0 where it is the value", kind="statistic",
        stored=frozenset({"adhesion"}),
    ),
    "patch_area": ResultQuantity(
        unit="um^2", words="areas of contacts on the ground plan", brief="area of a contact", kind="statistic",
        along=("step", "fraction_below"), stored=_MEASURED,
    ),
    "pressure": ResultQuantity(
        unit="GPa", words="pressures over the true area", brief="pressure", kind="statistic",
        along=("step", "fraction_below"), column_unit="MPa", column_factor=1000.0, stored=_MEASURED,
    ),
    **{
        f"{side}_rms": ResultQuantity(
            unit="um", words=f"root-mean-square height of the {side} body", brief=f"Sq of the {side} body",
            kind="statistic",
        )
        for side in ("upper", "lower")
    },
    "rms_gradient": ResultQuantity(
        unit="1", words="root-mean-square gradient of the gap", brief="rms gradient of the gap", kind="statistic",
        stored=_MEASURED,
    ),
    "rms_slope": ResultQuantity(
        unit="1", words="root-mean-square slope of the gap along the motion", brief="rms slope of the gap",
        kind="statistic", along=("direction",), stored=_MEASURED,
    ),
    "reading_difference": ResultQuantity(
        unit="1", words="largest relative difference of friction between readings of the load", kind="uncertainty",
        along=_STEP,
    ),
    # ---- Sums over contacts ----------------------------------------------------------------------------------------
    "normal_elastic": _sum("normal_elastic", "half-space", proportional=True),
    **_directed_sums(),
    "overlap_load": _sum("overlap_load", proportional=True),
    "load_beyond_hertz": _sum("load_beyond_hertz", proportional=True),
    "load_below_grid": _sum("load_below_grid", proportional=True),
    "crossed_count": _sum("crossed_count", dtype=int, proportional=True),
    "load_overlapping": _sum("load_overlapping", proportional=True),
    "load_at_edge": _sum("load_at_edge", proportional=True),
    "grid_minimum_count": _sum("grid_minimum_count", dtype=int, proportional=True),
    "unanswered_count": _sum("unanswered_count", dtype=int, proportional=True),
    **{
        f"unloaded_{part}": _unloaded(part, unit)
        for part, unit in (("elastic", "mN"), ("frictional", "mN"), ("adhesive", "mN/GPa"))
    },
    # ---- Onset of sliding ------------------------------------------------------------------------------------------
    "sliding_load": _statistic("mN", "tangential load at which all slips", along=()),
    "displacement": _statistic(
        "um", "displacement of the upper body since the tangential load was 0", along=("fraction",),
    ),
    "stiffness": _statistic("mN/um", "tangential stiffness at rest", along=()),
    "slipped_area": _statistic(
        "1", "fraction of the true contact area that slips", along=("fraction",), bounds=(0.0, 1.0), percent=True,
    ),
    "slipped_load": _statistic(
        "1", "fraction of the normal load on what slips", along=("fraction",), bounds=(0.0, 1.0), percent=True,
    ),
    "energy_lost": _statistic(
        "mN um", "energy that a cycle between plus and minus this load takes", along=("fraction",),
    ),
    # ---- Laws of tables --------------------------------------------------------------------------------------------
    "area_factor": _statistic("1/GPa", "a of A/A0 = a p", along=()),
    "stiffness_factor": _statistic("GPa/um/GPa^c", "b of k/A0 = b p^c", along=()),
    "stiffness_exponent": _statistic("1", "c of k/A0 = b p^c", along=()),
    "area_deviation": _statistic(
        "1", "largest relative difference from A/A0 = a p", "largest deviation of A/A0", along=(),
    ),
    "stiffness_deviation": _statistic(
        "1", "largest relative difference from k/A0 = b p^c", "largest deviation of k/A0", along=(),
    ),
    # ---- Coordinates -----------------------------------------------------------------------------------------------
    "cut_off": _coordinate("um", "wavelength below which waves are taken off; 0 is the scan itself", "cut-off"),
    "height_scale": _coordinate("1", "factor of the heights"),
    "fraction_below": _coordinate("1", "fraction that is smaller"),
    "axis": _coordinate("degree", "axis of the motion, both senses together, from +x towards +y"),
    "x": _coordinate("um", "how far the upper body is moved along +x"),
    "y": _coordinate("um", "how far the upper body is moved along +y"),
    "line": _coordinate("1", "pair of lines", dtype=int),
    "surrogate": _coordinate("", "whether the member is a pair of surrogates", dtype=bool),
    "nominal_area": _coordinate("um^2", "nominal area of a member"),
    "direction": _coordinate("degree", "where the upper body is about to move, from +x towards +y"),
    "sliding": _coordinate(
        "", "which contacts rub and push: those that oppose the motion, or all", "rubbing contacts", dtype=str,
    ),
    "fractal_dimension": _coordinate("1", "fractal dimension", symbol="D"),
    "amplitude": _coordinate("um", "amplitude"),
    "repetition": _coordinate("1", "repetition", dtype=int),
    "load": _coordinate("mN", "normal load", symbol="F_N"),
    "mu0": _coordinate("1", "molecular friction coefficient", "mu0"),
    "tau0": _coordinate("GPa", "adhesive shear strength", "tau0", column_unit="MPa", column_factor=1000.0),
    "hurst_exponent": _coordinate("1", "Hurst exponent", "H"),
    "rms": _coordinate("um", "Sq of each surface", "Sq"),
    "effective_modulus": _coordinate("GPa", "effective modulus"),
}  # fmt: skip
"""Properties of every quantity and coordinate, in the order in which views show them."""


def select(condition: Callable[[ResultQuantity], Any]) -> tuple[str, ...]:
    """Return the names of the quantities that meet a condition, in the order of the table."""
    return tuple(name for name, each in QUANTITIES.items() if condition(each))


def shown_in(view: View) -> tuple[str, ...]:
    """Return the names of the quantities that a view shows."""
    return select(lambda each: view in each.shown)


# ---- Selections ------------------------------------------------------------------------------------------------------

SUMS = tuple(CORE_SUMS)
"""Sums of a `LoadCurve` at each approach: the members of `Sums`, in the order of the core."""

AREAL_SUMS = tuple(AREAL_CORE_SUMS)
"""Sums that a `SurfaceLoadCurve` has in addition, in the order of the core."""

DIRECTED = frozenset(select(lambda each: each.kind == "sum" and each.along == (*_MOTION, "step")))
"""Sums that depend on the direction and on the sliding rule."""

HALF_SPACE_SUMS = (
    *(name for name in SUMS if "half-space" in QUANTITIES[name].stored),
    *select(lambda each: "half-space" in each.stored and "asperities" not in each.stored),
)
"""Numbers that a result of the half-space stores of each pair at each load."""

UNLOADED = select(lambda each: "adhesion" in each.stored and each.along == _MOTION)
"""Parts of the tangential load that starts the sliding at no load, which are added for mu0 and tau0."""

PULL_OFF = select(lambda each: "adhesion" in each.stored and not each.along)
"""Pull-off force of a member, and 1 if the bodies hold at least that, else 0."""

ADHESION = (*select(lambda each: "adhesion" in each.stored and "step" in each.along), *PULL_OFF, *UNLOADED)
"""Numbers that a result of bodies that adhere stores in addition; all but the first do not depend on the load."""

HELD = select(lambda each: "table" in each.shown and "step" not in each.along)
"""Quantities of bodies that adhere which do not depend on the load."""

ONSET = select(lambda each: "onset" in each.stored)
"""Quantities of the onset of sliding that a result of generated bodies stores, if its study requests them."""

DISTRIBUTIONS = select(lambda each: "fraction_below" in each.along)
"""Quantities of which a result of measured bodies stores quantiles, of each member at each load."""

GAP = select(lambda each: "measured" in each.stored and "step" not in each.along)
"""Quantities of the gap of each member, which do not depend on the load."""

STATISTICS = select(lambda each: "measured" in each.stored and each.along == _STEP)
"""Statistics, and the status, that a result of measured bodies stores of each member at each load."""

VALIDITY = select(lambda each: each.kind == "validity" and {each.numerator, *each.denominator} <= {*SUMS})
"""The members of `Validity`."""

AREAL_VALIDITY = select(lambda each: each.kind == "validity" and bool({each.numerator, *each.denominator} - {*SUMS}))
"""The members that `SurfaceValidity` has in addition to those of `Validity`."""

AT_HARDNESS = select(lambda each: "half-space" in each.stored and each.kind == "statistic")
"""Fractions of load and area at which the pressure is the hardness."""

PER_AREA = select(lambda each: each.kind == "ratio" and each.unit == "GPa/mm")
"""Stiffnesses over the nominal area."""

UNCERTAINTY = select(lambda each: each.kind == "uncertainty" and each.directed)
"""Uncertainties of the mean over all directions."""

RATIO_PARTS = frozenset(
    part
    for each in QUANTITIES.values()
    if each.kind == "validity" and each.shown
    for part in (each.numerator, *each.denominator)
)
"""Sums that the figures of validity that are shown consist of."""

READ_AT_LOAD = tuple(
    name
    for name, each in QUANTITIES.items()
    if each.stored and each.along == _STEP and (each.shown or name in RATIO_PARTS)
)
"""Stored quantities that `at_load` interpolates to a load, besides friction and quantiles."""


def attributes_of(name: str) -> dict[str, str]:
    """Return the attributes of a variable of that name in a dataset."""
    quantity = QUANTITIES[name]
    return {"units": quantity.unit, "long_name": quantity.words} if quantity.unit else {"long_name": quantity.words}


def column_of(name: str) -> tuple[str, float]:
    """Return the title of a spreadsheet column, with its unit, and the factor of conversion to that unit."""
    quantity = QUANTITIES[name]
    unit = quantity.column_unit or quantity.unit
    return quantity.short + (f" ({unit})" if unit not in ("", "1") else ""), quantity.column_factor
