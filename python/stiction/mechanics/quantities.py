"""Table of all quantities in results: unit, name, dimensions, and the outputs that show the quantity.

All lists of quantities are selections from `QUANTITIES`. Texts, reports and CSV files list quantities in the order of
the table.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import stiction._core
from stiction._estimate import EstimateKind

QuantityKind = Literal["sum", "statistic", "ratio", "validity", "uncertainty", "coordinate"]
"""Kinds of quantities: sum over contacts, statistic of a member, ratio, validity indicator, uncertainty, coordinate."""

QuantityAxis = Literal[
    "sliding",
    "direction",
    "axis",
    "step",
    "mu0",
    "tau0",
    "fraction_below",
    "fraction",
    "input",
    "dwell_time",
    "percentile",
]
"""Dimensions that a quantity may have besides surfaces and members. `step` is the approach or the load."""

QuantitySource = Literal["asperities", "areal", "half-space", "adhesion", "onset", "measured", "yielding"]
"""Kinds of studies whose results may store a quantity.

In this order: studies of asperities, of asperities on height maps, of the half-space, of adhesive bodies, of generated
bodies with an onset of sliding, of measured bodies, and of bodies that yield below the surface.
"""

STIFFNESS_PER_AREA_UNIT = "MPa/mm"
"""Unit of all stiffnesses per area in datasets and files. This unit is usual for rock joints and machine joints."""

STIFFNESS_PER_AREA_FACTOR = 1e6  # from GPa/µm

MAX_STORED_VALUE = 1e100
"""Largest magnitude of a finite stored number. Sums of products of two stored numbers do not overflow."""

OutputView = Literal["table", "verbose", "report", "csv", "hatch"]
"""Outputs that can show a quantity: table, verbose table, selection list of the report, CSV file, hatching of maps."""


@dataclass(frozen=True, kw_only=True)
class ResultQuantity:
    """Description of a quantity, coordinate or dimension of a result: unit, labels, kind and dimensions."""

    unit: str
    words: str
    short_words: str = ""
    symbol: str = ""
    kind: QuantityKind
    along: tuple[QuantityAxis, ...] = ()
    dtype: type = float
    numerator: str = ""
    denominator: tuple[str, ...] = ()
    sum_under_load: str = ""
    bounds: tuple[float, float] = (-math.inf, math.inf)
    # Range of the quantity's stored values: infinity may be stored only if it is a limit of this range.
    stored_bounds: tuple[float, float] = (-MAX_STORED_VALUE, MAX_STORED_VALUE)
    interval_kind: EstimateKind = "mean"
    percent: bool = False
    column_unit: str = ""
    column_factor: float = 1.0
    # True if the ratio quantity/load is interpolated linearly in ln(load), False if the quantity is interpolated.
    proportional: bool = False
    # False if adhesion makes the quantity deviate from proportionality to the load.
    proportional_with_adhesion: bool = True
    weighted: bool = False
    # Name of another quantity: the fraction of members for which only a lower bound of this quantity is known.
    bound_fraction: str = ""
    stored: frozenset[QuantitySource] = frozenset()
    # True if results of earlier versions lack the quantity, which is then read as NaN.
    is_optional: bool = False
    shown: frozenset[OutputView] = frozenset()
    is_omitted_if_zero: bool = False

    @property
    def table_label(self) -> str:
        """Label of the quantity in tables: `short_words` if given, otherwise `words`."""
        return self.short_words or self.words

    @property
    def table_unit(self) -> str:
        """Unit of the quantity in tables and reports: "%" or `unit`, to which a prefix such as n may be added later."""
        return "%" if self.percent else self.unit

    @property
    def is_directed(self) -> bool:
        """True if the quantity depends on the sliding rule and on the direction of motion."""
        return "sliding" in self.along


CONTACT_SUM_UNITS_AND_DESCRIPTIONS = {name: (unit, words) for name, unit, words in stiction._core.quantities()}
AREAL_CONTACT_SUM_UNITS_AND_DESCRIPTIONS = {
    name: (unit, words) for name, unit, words in stiction._core.areal_quantities()
}
"""Units and descriptions of the contact sums that only height maps have. The core declares the sums and their order."""

_STEP_DIMENSION: tuple[QuantityAxis, ...] = ("step",)
_MOTION_DIMENSIONS: tuple[QuantityAxis, ...] = ("sliding", "direction")
_FRICTION_DIMENSIONS: tuple[QuantityAxis, ...] = (*_MOTION_DIMENSIONS, "step", "mu0", "tau0")
_MEAN_FRICTION_DIMENSIONS: tuple[QuantityAxis, ...] = ("sliding", "step", "mu0", "tau0")
_FRACTION_ROUND_OFF = 1e-6
_STORED_FRACTION_RANGE = (0.0, 1.0 + _FRACTION_ROUND_OFF)
_UNRESTRICTED_STORED_RANGE = (-MAX_STORED_VALUE, MAX_STORED_VALUE)
_NONNEGATIVE_STORED_RANGE = (0.0, MAX_STORED_VALUE)
# A closed gap has an infinite stiffness.
_STORED_STIFFNESS_RANGE = (-MAX_STORED_VALUE, math.inf)
_FRACTION_QUANTITY_FIELDS: dict[str, Any] = {
    "unit": "1",
    "percent": True,
    "bounds": (-math.inf, 1.0),
    "stored_bounds": _STORED_FRACTION_RANGE,
}
_DEFAULT_VIEWS: frozenset[OutputView] = frozenset({"table", "report", "csv"})
_DETAIL_VIEWS: frozenset[OutputView] = frozenset({"verbose", "report", "csv"})
_DETAIL_TABLE_VIEWS: frozenset[OutputView] = frozenset({"verbose", "csv"})
_CSV_VIEW: frozenset[OutputView] = frozenset({"csv"})
_MEASURED_SOURCE: frozenset[QuantitySource] = frozenset({"measured"})


def _make_sum_quantity(name: str, *more_sources: QuantitySource, **properties: Any) -> ResultQuantity:
    """Return the description of a quantity that is summed over contacts, with unit and label from the C++ core."""
    unit, words = (
        CONTACT_SUM_UNITS_AND_DESCRIPTIONS[name]
        if name in CONTACT_SUM_UNITS_AND_DESCRIPTIONS
        else AREAL_CONTACT_SUM_UNITS_AND_DESCRIPTIONS[name]
    )
    source: QuantitySource = "asperities" if name in CONTACT_SUM_UNITS_AND_DESCRIPTIONS else "areal"
    defaults: dict[str, Any] = {
        "kind": "sum", "along": _STEP_DIMENSION, "stored": frozenset({source, *more_sources}),
        "stored_bounds": _NONNEGATIVE_STORED_RANGE,
    }  # fmt: skip
    return ResultQuantity(unit=unit, words=words, **defaults | properties)


def _directed_sum_quantities() -> dict[str, ResultQuantity]:
    directed: dict[str, Any] = {"along": (*_MOTION_DIMENSIONS, "step"), "stored_bounds": _UNRESTRICTED_STORED_RANGE}
    normal_sums: dict[str, ResultQuantity] = {
        f"normal_{contribution}": _make_sum_quantity(f"normal_{contribution}", "half-space", **directed)
        for contribution in ("frictional", "adhesive")
    }
    contributions = ("elastic", "frictional", "adhesive")
    tangential_sums = {
        f"tangential_{contribution}": _make_sum_quantity(f"tangential_{contribution}", "half-space", **directed)
        for contribution in contributions
    }
    return (
        normal_sums
        | tangential_sums
        | {
            f"lateral_{contribution}": _make_sum_quantity(f"lateral_{contribution}", **directed)
            for contribution in contributions
        }
    )


def _zero_load_quantity(contribution: str, unit: str) -> ResultQuantity:
    return ResultQuantity(
        unit=unit, words=f"{contribution} part of the tangential load without a normal load", kind="sum",
        along=_MOTION_DIMENSIONS,
        sum_under_load=f"tangential_{contribution}", stored=frozenset({"adhesion"}),
    )  # fmt: skip


def _make_validity_quantity(
    numerator: str, *denominator: str, percent: bool = True, **properties: Any
) -> ResultQuantity:
    fields: dict[str, Any] = {"kind": "validity", "along": _STEP_DIMENSION, "shown": _DETAIL_TABLE_VIEWS} | properties
    unit_fields = _FRACTION_QUANTITY_FIELDS if percent else {"unit": "1"}
    return ResultQuantity(numerator=numerator, denominator=denominator, **unit_fields | fields)


def _make_statistic_quantity(unit: str, words: str, short_words: str = "", **properties: Any) -> ResultQuantity:
    fields: dict[str, Any] = {"kind": "statistic", "along": _STEP_DIMENSION} | properties
    return ResultQuantity(unit=unit, words=words, short_words=short_words, **fields)


def _make_uncertainty_quantity(words: str, interval_kind: EstimateKind, *along: QuantityAxis) -> ResultQuantity:
    along = (*_MEAN_FRICTION_DIMENSIONS, *along)
    return ResultQuantity(unit="1", words=words, kind="uncertainty", along=along, interval_kind=interval_kind)


def _make_coordinate_quantity(unit: str, words: str, short_words: str = "", **properties: Any) -> ResultQuantity:
    return ResultQuantity(unit=unit, words=words, short_words=short_words, kind="coordinate", **properties)


QUANTITIES: dict[str, ResultQuantity] = {
    # ---- Friction --------------------------------------------------------------------------------------------------
    "friction_combined": _make_uncertainty_quantity(
        "coefficient of static friction, 95 % combined uncertainty", "combined"
    ),
    "friction_coefficient": ResultQuantity(
        unit="1", words="coefficient of static friction", symbol=r"\mu_s", kind="ratio", along=_FRICTION_DIMENSIONS,
    ),
    "mean_friction": ResultQuantity(
        unit="1", words="friction coefficient, mean over the directions", kind="ratio", along=_MEAN_FRICTION_DIMENSIONS,
    ),
    "friction_by_axis": ResultQuantity(
        unit="1", words="friction coefficient, mean over both directions of an axis", kind="ratio",
        along=(*_MEAN_FRICTION_DIMENSIONS, "axis"),
    ),
    "gentle_friction": ResultQuantity(
        unit="1", words="friction coefficient, small-slope estimate", short_words="small-slope estimate",
        kind="statistic", along=(*_MOTION_DIMENSIONS, "mu0", "tau0"),
    ),
    "normal_load": ResultQuantity(
        unit="mN", words="normal load at the onset of sliding, including friction on slopes", kind="sum",
        along=_FRICTION_DIMENSIONS, shown=_CSV_VIEW,
    ),
    "tangential_load": ResultQuantity(
        unit="mN", words="tangential load at the onset of sliding", kind="sum", along=_FRICTION_DIMENSIONS,
        shown=_CSV_VIEW,
    ),
    "lateral_load": ResultQuantity(
        unit="mN", words="lateral load that keeps the upper body on its path", kind="sum", along=_FRICTION_DIMENSIONS,
    ),
    "status": ResultQuantity(
        unit="", words="ok, or the reason why there is no value", kind="statistic", along=_STEP_DIMENSION, dtype=int,
        stored=_MEASURED_SOURCE, stored_bounds=_NONNEGATIVE_STORED_RANGE,
    ),
    "friction_at_cutoff": _make_uncertainty_quantity(
        "coefficient of static friction, combined 95 % interval at one cutoff", "combined"
    ),
    "friction_prediction": _make_uncertainty_quantity(
        "coefficient of static friction of a single test in one direction at one position", "prediction",
    ),
    "friction_percentiles": _make_uncertainty_quantity(
        "coefficient of static friction of a single test, percentiles", "prediction", "percentile"
    ),
    "remaining_interval": _make_uncertainty_quantity("interval if one input were exact", "conditional", "input"),
    "remaining_width": _make_uncertainty_quantity(
        "width of the interval if one input were exact", "conditional", "input"
    ),
    "friction_after_dwell": _make_uncertainty_quantity(
        "coefficient of static friction after a dwell time under load", "combined", "dwell_time"
    ),
    "fraction_unlimited": ResultQuantity(
        unit="1", words="fraction of the samples of the inputs for which friction has no upper limit",
        kind="statistic", along=_MEAN_FRICTION_DIMENSIONS,
    ),
    "spread_low": ResultQuantity(
        unit="1", words="10 % quantile of the members", kind="statistic", along=_MEAN_FRICTION_DIMENSIONS,
    ),
    "spread_high": ResultQuantity(
        unit="1", words="90 % quantile of the members", kind="statistic", along=_MEAN_FRICTION_DIMENSIONS,
    ),
    "ok": ResultQuantity(
        unit="1", words="members with a coefficient", kind="statistic", along=_FRICTION_DIMENSIONS, dtype=int
    ),
    "members": ResultQuantity(unit="1", words="members", kind="statistic", dtype=int),
    # ---- Contact at a load -----------------------------------------------------------------------------------------
    "contact_area_fraction": ResultQuantity(
        unit="1", words="ratio of true to nominal contact area", short_words="true area A/A0", kind="ratio",
        along=_STEP_DIMENSION,
        percent=True, bounds=(-math.inf, 1.0), shown=_DEFAULT_VIEWS,
    ),
    "contact_status": ResultQuantity(
        unit="", words="status of the true contact area", kind="statistic", along=_STEP_DIMENSION, dtype=str,
    ),
    "contact_area": _make_sum_quantity(
        "contact_area", "half-space", symbol="A", proportional=True, shown=_DEFAULT_VIEWS
    ),
    "contact_area_at_onset": ResultQuantity(
        unit="um^2", words="true contact area at the onset of sliding",
        short_words="true area at the onset", kind="statistic", along=("step", "mu0", "tau0"),
        shown=_DETAIL_TABLE_VIEWS,
    ),
    "contact_hardness": ResultQuantity(
        unit="GPa", words="hardness of the contacts, with the indentation size effect",
        short_words="hardness of the contacts", kind="statistic", along=_STEP_DIMENSION, shown=_DETAIL_TABLE_VIEWS,
    ),
    "contact_count": _make_sum_quantity(
        "contact_count", "half-space", dtype=int, proportional=True, shown=_DEFAULT_VIEWS
    ),
    "mean_pressure": ResultQuantity(
        unit="GPa", words="mean pressure in contact", kind="ratio", along=_STEP_DIMENSION, shown=_DEFAULT_VIEWS,
    ),
    "normal_stiffness": _make_statistic_quantity(
        "mN/um", "normal stiffness", proportional=True,
        proportional_with_adhesion=False, stored=_MEASURED_SOURCE, stored_bounds=_STORED_STIFFNESS_RANGE,
        shown=_DEFAULT_VIEWS,
    ),
    "closure": _make_statistic_quantity(
        "um", "closure, the decrease of the mean gap since first contact", "closure", stored=_MEASURED_SOURCE,
        shown=_DEFAULT_VIEWS,
    ),
    "closure_stiffness": _make_statistic_quantity(
        STIFFNESS_PER_AREA_UNIT, "derivative of the nominal pressure with respect to the closure",
        "stiffness of closure", proportional=True,
        proportional_with_adhesion=False, stored=_MEASURED_SOURCE, stored_bounds=_STORED_STIFFNESS_RANGE,
        shown=_DEFAULT_VIEWS,
    ),
    "unloading_closure_stiffness": _make_statistic_quantity(
        STIFFNESS_PER_AREA_UNIT, "derivative of the nominal pressure with respect to the closure while unloading",
        "stiffness of closure while unloading", proportional=True,
        proportional_with_adhesion=False, stored=_MEASURED_SOURCE, stored_bounds=_STORED_STIFFNESS_RANGE,
        is_optional=True,
        shown=_CSV_VIEW,
    ),
    "contact_load": ResultQuantity(
        unit="mN", words="load on the contacts: normal load plus attraction", short_words="contact load",
        kind="sum", along=_STEP_DIMENSION, proportional=True, stored=frozenset({"adhesion"}),
        stored_bounds=_NONNEGATIVE_STORED_RANGE, shown=_DEFAULT_VIEWS,
    ),
    "pull_off": ResultQuantity(
        unit="mN", words="pull-off force", kind="statistic", bound_fraction="share_of_pull_off_bounds",
        stored=frozenset({"adhesion"}), shown=frozenset({"table", "csv"}),
    ),
    "pull_off_pressure": ResultQuantity(
        unit="GPa", words="pull-off force divided by the nominal area", short_words="pull-off pressure", kind="ratio",
        bound_fraction="share_of_pull_off_bounds",
        shown=frozenset({"table", "csv"}),
    ),
    "friction_at_no_load": ResultQuantity(
        unit="mN", words="tangential load at the onset of sliding without a normal load",
        short_words="friction at no load",
        kind="sum", along=("sliding", "mu0", "tau0"), shown=frozenset({"table", "csv"}),
    ),
    "tangential_stiffness": _make_statistic_quantity(
        "mN/um", "initial tangential stiffness", proportional=True,
        proportional_with_adhesion=False, stored=frozenset({"onset"}),
        stored_bounds=_STORED_STIFFNESS_RANGE,
        shown=frozenset({"table", "csv"}),
    ),
    "displacement_at_sliding": _make_statistic_quantity(
        "um", "displacement of the upper body before it slides", "pre-sliding displacement", weighted=True,
        stored=frozenset({"onset"}), stored_bounds=_NONNEGATIVE_STORED_RANGE, shown=frozenset({"table", "csv"}),
    ),
    "fraction_slipped": _make_statistic_quantity(
        **_FRACTION_QUANTITY_FIELDS, words="fraction of the normal load that slips at half of the sliding load",
        short_words="load that slips at half of sliding", weighted=True, stored=frozenset({"onset"}),
        shown=frozenset({"table", "csv"}),
    ),
    "approach": _make_coordinate_quantity(
        "um", "approach since first contact", along=_STEP_DIMENSION, stored=frozenset({"half-space"}),
        shown=_DETAIL_VIEWS,
    ),
    "stiffness_per_area": ResultQuantity(
        unit=STIFFNESS_PER_AREA_UNIT, words="normal stiffness per area while loading", kind="ratio",
        along=_STEP_DIMENSION,
        numerator="normal_stiffness", shown=_DETAIL_VIEWS,
    ),
    "unloading_stiffness_per_area": ResultQuantity(
        unit=STIFFNESS_PER_AREA_UNIT, words="normal stiffness per area while unloading (ultrasonic)", kind="ratio",
        along=_STEP_DIMENSION, numerator="unloading_stiffness", shown=_DETAIL_VIEWS,
    ),
    "tangential_stiffness_per_area": ResultQuantity(
        unit=STIFFNESS_PER_AREA_UNIT, words="initial tangential stiffness per area", kind="statistic",
        along=_STEP_DIMENSION, shown=_DETAIL_VIEWS,
    ),
    "share_opposing": ResultQuantity(
        **_FRACTION_QUANTITY_FIELDS, words="fraction of the load on contacts that oppose the motion",
        short_words="load that opposes", kind="ratio", along=("direction", "step"), shown=_DETAIL_TABLE_VIEWS,
    ),
    "share_on_largest": _make_statistic_quantity(
        **_FRACTION_QUANTITY_FIELDS, words="fraction of the load on the contact with the largest load",
        short_words="load on the largest contact", stored=_MEASURED_SOURCE, shown=_DETAIL_VIEWS,
    ),
    "share_at_edge": _make_validity_quantity(
        "load_at_edge", "normal_elastic", words="fraction of the load on contacts that reach the edge of the overlap",
        short_words="load on contacts at the edge", stored=_MEASURED_SOURCE, shown=_DETAIL_VIEWS,
    ),
    "fraction_on_small": _make_statistic_quantity(
        **_FRACTION_QUANTITY_FIELDS, words="fraction of the load on contacts of at most four grid cells",
        short_words="load on contacts of 4 points or fewer", stored=_MEASURED_SOURCE, shown=_DETAIL_VIEWS,
    ),
    **{
        f"share_on_steepest_{side}": _make_statistic_quantity(
            **_FRACTION_QUANTITY_FIELDS, words=f"fraction of the load on the steepest tenth of the {side} body",
            short_words=f"load on the {side}'s steepest tenth", stored=_MEASURED_SOURCE, shown=_DETAIL_TABLE_VIEWS,
        )
        for side in ("upper", "lower")
    },
    "load_share_at_hardness": _make_statistic_quantity(
        **_FRACTION_QUANTITY_FIELDS, words="fraction of the load at points at the hardness",
        stored=frozenset({"half-space"}), shown=_DETAIL_VIEWS, is_omitted_if_zero=True,
    ),
    "area_share_at_hardness": _make_statistic_quantity(
        **_FRACTION_QUANTITY_FIELDS, words="fraction of the points under pressure that are at the hardness",
        stored=frozenset({"half-space"}), shown=_DETAIL_TABLE_VIEWS,
    ),
    "relative_overlap": _make_validity_quantity(
        "overlap_load", "normal_elastic", percent=False, words="load-weighted mean of overlap / radius",
        shown=_DETAIL_VIEWS,
    ),
    "share_beyond_hertz": _make_validity_quantity(
        "load_beyond_hertz", "normal_elastic",
        words="fraction of the load on contacts with an overlap above a tenth of their radius",
        shown=_DETAIL_VIEWS | {"hatch"},
    ),
    "share_below_grid": _make_validity_quantity(
        "load_below_grid", "normal_elastic",
        words="fraction of the load on contacts with a radius below the grid spacing", shown=_DETAIL_VIEWS | {"hatch"},
    ),
    "share_crossed": _make_validity_quantity(
        "crossed_count", "crossed_count", "contact_count",
        words="fraction of possible contacts rejected because their sphere centres had crossed", shown=_DETAIL_VIEWS,
    ),
    "share_overlapping": _make_validity_quantity(
        "load_overlapping", "normal_elastic", shown=_DETAIL_VIEWS,
        words="fraction of the load on contacts whose ellipse overlaps another ellipse",
    ),
    "share_unanswered": _make_validity_quantity(
        "unanswered_count", "grid_minimum_count",
        words="fraction of the grid minima that have no minimum of the spline nearby", shown=frozenset(),
    ),
    "error": _make_statistic_quantity(
        "1", "error of the half-space solution, in standard deviations of the gap", "error of the solution",
        stored=_MEASURED_SOURCE, stored_bounds=_NONNEGATIVE_STORED_RANGE, shown=_DETAIL_TABLE_VIEWS,
    ),
    "elastic_area": _make_statistic_quantity(
        "um^2", "true contact area of elastic bodies at the same load, for the first members",
        stored=frozenset({"yielding"}), stored_bounds=_NONNEGATIVE_STORED_RANGE,
    ),
    "unloading_stiffness": _make_statistic_quantity(
        "mN/um", "normal stiffness during unloading, as measured by ultrasound", proportional=True,
        proportional_with_adhesion=False,
        stored=_MEASURED_SOURCE, stored_bounds=_STORED_STIFFNESS_RANGE, shown=_CSV_VIEW,
    ),
    "nominal_pressure": ResultQuantity(
        unit="GPa", words="normal load divided by the nominal area", short_words="pressure on the nominal area",
        kind="ratio",
        along=_STEP_DIMENSION, shown=_CSV_VIEW,
    ),
    "share_of_pull_off_bounds": ResultQuantity(
        **_FRACTION_QUANTITY_FIELDS, words="fraction of the members whose pull-off force is a lower bound or missing",
        kind="statistic", shown=_CSV_VIEW,
    ),
    "pull_off_is_bound": ResultQuantity(
        unit="1", words="1 if the pull-off force is only a lower bound, otherwise 0", kind="statistic",
        stored=frozenset({"adhesion"}), stored_bounds=(0.0, 1.0),
    ),
    "patch_area": ResultQuantity(
        unit="um^2", words="projected areas of contacts", short_words="area of a contact", kind="statistic",
        along=("step", "fraction_below"), stored=_MEASURED_SOURCE, stored_bounds=_NONNEGATIVE_STORED_RANGE,
    ),
    "pressure": ResultQuantity(
        unit="GPa", words="pressures over the true area", short_words="pressure", kind="statistic",
        along=("step", "fraction_below"), column_unit="MPa", column_factor=1000.0, stored=_MEASURED_SOURCE,
    ),
    **{
        f"{side}_rms": ResultQuantity(
            unit="um", words=f"root-mean-square height of the {side} body", short_words=f"Sq of the {side} body",
            kind="statistic",
        )
        for side in ("upper", "lower")
    },
    "rms_gradient": ResultQuantity(
        unit="1", words="root-mean-square gradient of the gap", short_words="rms gradient of the gap", kind="statistic",
        stored=_MEASURED_SOURCE, stored_bounds=_NONNEGATIVE_STORED_RANGE,
    ),
    "rms_slope": ResultQuantity(
        unit="1", words="root-mean-square slope of the gap along the motion", short_words="rms slope of the gap",
        kind="statistic", along=("direction",), stored=_MEASURED_SOURCE, stored_bounds=_NONNEGATIVE_STORED_RANGE,
    ),
    "load_definition_effect": ResultQuantity(
        unit="1", words="largest relative difference of friction between definitions of the load", kind="uncertainty",
        along=_STEP_DIMENSION,
    ),
    # ---- Sums over contacts ----------------------------------------------------------------------------------------
    "normal_elastic": _make_sum_quantity("normal_elastic", "half-space", proportional=True),
    **_directed_sum_quantities(),
    "overlap_load": _make_sum_quantity("overlap_load", proportional=True),
    "load_beyond_hertz": _make_sum_quantity("load_beyond_hertz", proportional=True),
    "load_below_grid": _make_sum_quantity("load_below_grid", proportional=True),
    "crossed_count": _make_sum_quantity("crossed_count", dtype=int, proportional=True),
    "load_overlapping": _make_sum_quantity("load_overlapping", proportional=True),
    "load_at_edge": _make_sum_quantity("load_at_edge", proportional=True),
    "grid_minimum_count": _make_sum_quantity("grid_minimum_count", dtype=int, proportional=True),
    "unanswered_count": _make_sum_quantity("unanswered_count", dtype=int, proportional=True),
    **{
        f"unloaded_{part}": _zero_load_quantity(part, unit)
        for part, unit in (("elastic", "mN"), ("frictional", "mN"), ("adhesive", "mN/GPa"))
    },
    # ---- Onset of sliding ------------------------------------------------------------------------------------------
    "sliding_load": _make_statistic_quantity("mN", "tangential load at which all contacts slip", along=()),
    "displacement": _make_statistic_quantity(
        "um", "displacement of the upper body since the tangential load was 0", along=("fraction",),
    ),
    "stiffness": _make_statistic_quantity("mN/um", "initial tangential stiffness", along=()),
    "slipped_area": _make_statistic_quantity(
        "1", "fraction of the true contact area that slips", along=("fraction",), bounds=(0.0, 1.0), percent=True,
    ),
    "slipped_load": _make_statistic_quantity(
        "1", "fraction of the normal load on slipping points", along=("fraction",), bounds=(0.0, 1.0), percent=True,
    ),
    "energy_lost": _make_statistic_quantity(
        "mN um", "energy loss in a cycle between plus and minus this load", along=("fraction",),
    ),
    # ---- Laws fitted to friction tables ----------------------------------------------------------------------------
    "area_factor": _make_statistic_quantity("1/GPa", "a of A/A0 = a p", along=()),
    "stiffness_factor": _make_statistic_quantity(f"{STIFFNESS_PER_AREA_UNIT}/GPa^c", "b of k/A0 = b p^c", along=()),
    "stiffness_exponent": _make_statistic_quantity("1", "c of k/A0 = b p^c", along=()),
    "area_deviation": _make_statistic_quantity(
        "1", "largest relative difference from A/A0 = a p", "largest deviation of A/A0", along=(),
    ),
    "stiffness_deviation": _make_statistic_quantity(
        "1", "largest relative difference from k/A0 = b p^c", "largest deviation of k/A0", along=(),
    ),
    # ---- Coordinates -----------------------------------------------------------------------------------------------
    "cut_off": _make_coordinate_quantity(
        "um", "cutoff wavelength of the low-pass filter; 0 for unfiltered scans", "cutoff"
    ),
    "height_scale": _make_coordinate_quantity("1", "factor by which the heights are multiplied"),
    "fraction_below": _make_coordinate_quantity("1", "fraction of values that are smaller"),
    "percentile": _make_coordinate_quantity("%", "percentage of tests with a smaller value"),
    "axis": _make_coordinate_quantity("degree", "axis of the motion in either direction, from +x towards +y"),
    "x": _make_coordinate_quantity("um", "shift of the upper body along +x"),
    "y": _make_coordinate_quantity("um", "shift of the upper body along +y"),
    "line": _make_coordinate_quantity("1", "pair of lines", dtype=int, stored_bounds=_NONNEGATIVE_STORED_RANGE),
    "surrogate": _make_coordinate_quantity(
        "", "True if the member is a pair of surrogates", dtype=bool, stored_bounds=(0.0, 1.0),
    ),
    "nominal_area": _make_coordinate_quantity("um^2", "nominal area of a member"),
    "direction": _make_coordinate_quantity(
        "degree", "direction in which the upper body is about to move, from +x towards +y"
    ),
    "sliding": _make_coordinate_quantity(
        "", "contacts with friction: only those that oppose the motion, or all", "contacts with friction", dtype=str,
    ),
    "fractal_dimension": _make_coordinate_quantity("1", "fractal dimension", symbol="D"),
    "amplitude": _make_coordinate_quantity("um", "amplitude"),
    "repetition": _make_coordinate_quantity("1", "repetition", dtype=int),
    "load": _make_coordinate_quantity("mN", "normal load", symbol="F_N"),
    "mu0": _make_coordinate_quantity("1", "molecular friction coefficient", "mu0"),
    "tau0": _make_coordinate_quantity(
        "GPa", "adhesive shear strength", "tau0", column_unit="MPa", column_factor=1000.0
    ),
    "hurst_exponent": _make_coordinate_quantity("1", "Hurst exponent", "H"),
    "rms": _make_coordinate_quantity("um", "Sq of each surface", "Sq"),
    "effective_modulus": _make_coordinate_quantity("GPa", "effective modulus"),
}  # fmt: skip
"""Descriptions of all quantities and coordinates of results, by name, in the order in which outputs show them."""


def select_quantity_names(condition: Callable[[ResultQuantity], Any]) -> tuple[str, ...]:
    """Return the names of the quantities that fulfil a condition, in the order of the table."""
    return tuple(name for name, quantity in QUANTITIES.items() if condition(quantity))


def quantity_names_shown_in(view: OutputView) -> tuple[str, ...]:
    """Return the names of the quantities that an output, such as "csv" or "report", shows."""
    return select_quantity_names(lambda quantity: view in quantity.shown)


def is_requested(name: str, names: Collection[str] | None) -> bool:
    """Return whether `names` contains a quantity; True if `names` is None, which stands for all quantities."""
    return names is None or name in names


def find_upper_bound(name: str, nominal_area: float, *, uses_half_space: bool) -> float:
    """Return the upper bound of a quantity, such as 1 for a fraction.

    The nominal area (µm²) limits the true area of half-spaces. Asperities may overlap, so their area has no limit.
    """
    if name == "contact_area":
        return nominal_area * QUANTITIES["contact_area_fraction"].bounds[1] if uses_half_space else math.inf
    return QUANTITIES[name].bounds[1]


# ---- Selections of quantities ----------------------------------------------------------------------------------------

SUM_QUANTITIES = tuple(CONTACT_SUM_UNITS_AND_DESCRIPTIONS)
"""Names of the contact sums of a `LoadCurve` at each approach: fields of `ContactSums`, in the order of the core."""

AREAL_SUM_QUANTITIES = tuple(AREAL_CONTACT_SUM_UNITS_AND_DESCRIPTIONS)
"""Names of the additional contact sums of a `SurfaceLoadCurve`, in the order of the core."""

DIRECTED_SUM_QUANTITIES = frozenset(
    select_quantity_names(lambda quantity: quantity.kind == "sum" and quantity.along == (*_MOTION_DIMENSIONS, "step"))
)
"""Names of the contact sums that depend on the direction of motion and on the sliding rule."""

HALF_SPACE_SUM_QUANTITIES = (
    *(name for name in SUM_QUANTITIES if "half-space" in QUANTITIES[name].stored),
    *select_quantity_names(lambda quantity: "half-space" in quantity.stored and "asperities" not in quantity.stored),
)
"""Names of the quantities that a half-space result stores for each pair at each load."""

YIELDING_QUANTITIES = select_quantity_names(lambda quantity: "yielding" in quantity.stored)
"""Names of the quantities that a half-space result also stores if yielding below the surface increases the area."""

QUANTITIES_SUMMED_AT_ZERO_LOAD = select_quantity_names(
    lambda quantity: "adhesion" in quantity.stored and quantity.along == _MOTION_DIMENSIONS
)
"""Names of the sums that give the tangential load at the onset of sliding if there is no normal load."""

PULL_OFF_QUANTITIES = select_quantity_names(lambda quantity: "adhesion" in quantity.stored and not quantity.along)
"""Names of two quantities: the pull-off force of a member, and whether this force is only a lower bound (1 or 0)."""

ADHESION_QUANTITIES = (
    *select_quantity_names(lambda quantity: "adhesion" in quantity.stored and "step" in quantity.along),
    *PULL_OFF_QUANTITIES,
    *QUANTITIES_SUMMED_AT_ZERO_LOAD,
)
"""Names of the additional quantities in results of adhesive bodies. Only the first depends on the load."""

LOAD_INDEPENDENT_QUANTITIES = select_quantity_names(
    lambda quantity: "table" in quantity.shown and "step" not in quantity.along
)
"""Names of the quantities in tables that do not depend on the load, such as the pull-off force."""

ONSET_QUANTITIES = select_quantity_names(lambda quantity: "onset" in quantity.stored)
"""Names of the onset quantities that a result of generated bodies stores if its study requests an onset."""

DISTRIBUTION_QUANTITIES = select_quantity_names(lambda quantity: "fraction_below" in quantity.along)
"""Names of the quantities whose quantiles a result of measured bodies stores for each member at each load."""

GAP_QUANTITIES = select_quantity_names(lambda quantity: "measured" in quantity.stored and "step" not in quantity.along)
"""Names of the quantities of the gap of a member. They do not depend on the load."""

LOAD_STEP_QUANTITIES = select_quantity_names(
    lambda quantity: "measured" in quantity.stored and quantity.along == _STEP_DIMENSION
)
"""Names of the status and the statistics that a result of measured bodies stores for each member at each load."""

RATIO_QUANTITIES = select_quantity_names(
    lambda quantity: quantity.kind in ("ratio", "validity") and quantity.along == _STEP_DIMENSION
)
"""Names of the quantities at a load that are ratios of contact sums."""

STIFFNESS_PER_AREA_QUANTITIES = select_quantity_names(
    lambda quantity: quantity.kind == "ratio" and quantity.unit == STIFFNESS_PER_AREA_UNIT
)
"""Names of the stiffnesses that are divided by the nominal area."""

STIFFNESS_QUANTITIES = select_quantity_names(
    lambda quantity: quantity.unit in ("mN/um", STIFFNESS_PER_AREA_UNIT) and quantity.along == _STEP_DIMENSION
)
"""Names of the stiffnesses at a load. Their mean over members is the inverse of the mean compliance."""

LOADING_COUNTERPARTS = {
    "unloading_stiffness": "normal_stiffness",
    "unloading_stiffness_per_area": "stiffness_per_area",
    "unloading_closure_stiffness": "closure_stiffness",
    "tangential_stiffness_per_area": "closure_stiffness",
}
"""Names of the stiffnesses while unloading, each with the stiffness while loading.

The ratio of both stiffnesses is 1 for elastic contacts. For contacts that yield, it differs between members.
"""

UNCERTAINTY_QUANTITIES = select_quantity_names(lambda quantity: quantity.kind == "uncertainty" and quantity.is_directed)
"""Names of the uncertainties of the friction coefficient averaged over all directions."""

VALIDITY_RATIO_OPERANDS = frozenset(
    part
    for quantity in QUANTITIES.values()
    if quantity.kind == "validity" and quantity.shown
    for part in (quantity.numerator, *quantity.denominator)
)
"""Names of the contact sums from which the displayed validity indicators are computed."""

INTERPOLATED_QUANTITIES = tuple(
    name
    for name, quantity in QUANTITIES.items()
    if quantity.stored and quantity.along == _STEP_DIMENSION and (quantity.shown or name in VALIDITY_RATIO_OPERANDS)
)
"""Names of the stored quantities that `at_load` interpolates to a load. Friction and quantiles are not included."""


def quantity_attributes(name: str) -> dict[str, str]:
    """Return the unit and the long name of a quantity as attributes for a dataset variable."""
    quantity = QUANTITIES[name]
    return {"units": quantity.unit, "long_name": quantity.words} if quantity.unit else {"long_name": quantity.words}


INTERVAL_KIND_ATTRIBUTE = "interval_kind"
"""Name of the attribute of a dataset variable that overrides `ResultQuantity.interval_kind`."""


def find_interval_kind(name: str, attributes: Mapping[Any, Any]) -> EstimateKind:
    """Return the kind of a quantity's 95 % interval: the kind in the variable's attributes, or else the default."""
    kind: EstimateKind = attributes.get(INTERVAL_KIND_ATTRIBUTE, QUANTITIES[name].interval_kind)
    return kind


def column_title_and_factor(name: str) -> tuple[str, float]:
    """Return the spreadsheet column title of a quantity, and the factor from the stored unit to the column unit."""
    quantity = QUANTITIES[name]
    unit = quantity.column_unit or quantity.unit
    return quantity.table_label + (f" ({unit})" if unit not in ("", "1") else ""), quantity.column_factor
