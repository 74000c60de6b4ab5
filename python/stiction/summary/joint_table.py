"""Joint table for other programs: closure, stiffness, friction and true area as functions of pressure."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from stiction._checks import Floats, check_choice, validate_number
from stiction._errors import ArgumentError
from stiction._estimate import Estimate
from stiction._number_format import format_with_unit
from stiction._units import loads_to_core_units, quantity
from stiction.evaluate.combined_intervals import FRICTION_PERCENTILES
from stiction.evaluate.member_values import find_tangential_stiffness_ratio, has_grooves
from stiction.evaluate.point import list_rules_with_reported_first, read_estimate, select_sliding_rule
from stiction.mechanics.friction import NEGLIGIBLE_COEFFICIENT
from stiction.mechanics.onset import DEFAULT_POISSON_RATIO, parse_poisson_ratios
from stiction.mechanics.quantities import STIFFNESS_PER_AREA_FACTOR
from stiction.summary.assessment import ASSESSMENTS_BY_SEVERITY

if TYPE_CHECKING:
    import xarray

    from stiction.study.study import Study

MAX_RATIO_OF_SUCCESSIVE_LOADS = 10 ** (1 / 16)
"""Largest ratio of successive loads in a joint table.

Other programs interpolate linearly between the rows. At this ratio, the interpolated closure of two profiles deviates
by less than 0.1 %.
"""
STIFFNESS_OVER_MEASURED_STIFFNESS = (0.45, 1.19)
"""Smallest and largest ratio of computed to measured stiffness of closure, which estimates the error of the model.

These are tangent stiffnesses under the conditions of `EVIDENCE_OF_MODEL_ERROR`, see docs/explanation/experiments.md. No
other joint has been compared.
"""
EVIDENCE_OF_MODEL_ERROR = "two mated rock fractures of 86 mm at 1 to 9.8 MPa; unknown for other faces and pressures"
MODEL_ERROR_TEXT = (
    f"{STIFFNESS_OVER_MEASURED_STIFFNESS[0]} to {STIFFNESS_OVER_MEASURED_STIFFNESS[1]} times the measured stiffness "
    f"({EVIDENCE_OF_MODEL_ERROR})"
)
"""Phrase on the error of the model: computed stiffness of closure, compared with measured stiffness."""
MAX_LOAD_ROUND_OFF = 1e-9
MIN_PREDICTION_POSITIONS = 3
# The materials of two bodies count as similar below this value of Dundurs' second constant β.
MIN_DUNDURS_BETA = 0.005
UnitSystem = Literal["mm,N,MPa", "m,N,Pa", "um,mN,GPa"]
"""Consistent unit systems (length, force, pressure) in which a joint table can be written."""

DEFAULT_JOINT_UNITS: UnitSystem = "mm,N,MPa"

JOINT_QUANTITIES = (
    "closure", "closure_stiffness", "unloading_closure_stiffness", "tangential_stiffness_per_area",
    "contact_area_fraction",
)  # fmt: skip
"""Names of the quantities besides friction in a joint table."""

FRICTION_PERCENTILES_BY_NAME = {f"friction_{percentile:g}": percentile for percentile in FRICTION_PERCENTILES.tolist()}
"""Percentiles of the coefficients that single tests would measure, by their names in a joint table."""

JOINT_TITLES = {
    "nominal_pressure": "nominal pressure", "closure": "closure", "closure_stiffness": "stiffness of closure",
    "unloading_closure_stiffness": "stiffness of closure while unloading",
    "tangential_stiffness_per_area": "tangential stiffness", "contact_area_fraction": "true area over nominal area",
    "friction_combined": "mu_s",
    **{name: f"mu_s {percentile:g} %" for name, percentile in FRICTION_PERCENTILES_BY_NAME.items()},
}  # fmt: skip
"""Column titles of a joint table. Stiffnesses are per nominal area."""


@dataclass(frozen=True)
class JointUnits:
    """Unit system of a joint table: units of length, force and pressure."""

    length: str
    force: str
    pressure: str

    @classmethod
    def parse(cls, text: str) -> JointUnits:
        """Parse a unit system, such as "mm,N,MPa"."""
        check_choice("units", text, UnitSystem)
        return cls(*text.split(","))

    def convert(self, estimate: Estimate) -> Estimate:
        """Convert an estimate of a length, a pressure or a stiffness per area to this unit system.

        An estimate without a unit is returned unchanged.
        """
        length, pressure = quantity(f"1 {self.length}", "length"), quantity(f"1 {self.pressure}", "pressure")
        conversions = {
            "um": (self.length, float(length)),
            "GPa": (self.pressure, float(pressure)),
            "MPa/mm": (f"{self.pressure}/{self.length}", STIFFNESS_PER_AREA_FACTOR * float(pressure) / float(length)),
        }
        if estimate.unit not in conversions:
            return estimate
        unit, factor = conversions[estimate.unit]
        return estimate.in_unit(unit, factor)


@dataclass(frozen=True)
class JointRow:
    """Row of a joint table: closure, stiffnesses, true area and friction at one nominal pressure.

    Attributes
    ----------
    load : float, mN
        Load of a member of the pair.
    is_computed : bool
        True if the contacts were computed at this load, False between two such loads.
    estimates : dict of Estimate
        By name: "nominal_pressure", "closure", "closure_stiffness", "unloading_closure_stiffness",
        "tangential_stiffness_per_area", "contact_area_fraction" (true area over nominal area), "friction_combined"
        (coefficient of static friction), and its percentiles "friction_5", "friction_50" and "friction_95" in a single
        test.
    assessment : str
        Assessment of the coefficient: "Quote it", "Quote with care" or "Do not quote".
    """

    load: float
    is_computed: bool
    estimates: Mapping[str, Estimate]
    assessment: str

    @property
    def pressure(self) -> Estimate:
        """Nominal pressure of the row, that is, the load divided by the nominal area."""
        return self.estimates["nominal_pressure"]

    def friction(self, percentile: float) -> Estimate:
        """Return a percentile (5, 50 or 95) of the friction coefficients that single tests would measure."""
        return self.estimates[f"friction_{percentile:g}"]


@dataclass(frozen=True)
class JointTable:
    """Joint table: contact properties of a pair at several nominal pressures, as returned by `Result.joint_table`.

    Attributes
    ----------
    rows : tuple of JointRow
        By ascending pressure.
    units : JointUnits
    reference : JointRow
        Row at the load given as `reference_load`, by default the lowest load of the pair.
    mu0, tau0 : float
        mu0 and tau0 (GPa) for which the friction was computed.
    sliding : str
        Sliding rule of the friction, "all" or "opposing": the rule that a summary of the result lists first.
    closure_from : Estimate
        Nominal pressure from which the closure is counted; 0 for closures since first contact.
    notes : tuple of str
        Definitions, assumptions and the range of validity, as sentences.
    """

    rows: tuple[JointRow, ...]
    units: JointUnits
    reference: JointRow
    mu0: float
    tau0: float
    sliding: str
    closure_from: Estimate
    notes: tuple[str, ...]


def choose_joint_loads(study: Study, nominal_area: float | None) -> Floats:
    """Return the loads (mN) of a measured pair's joint table: the study's loads, and further loads between them.

    The ratio of neighbouring loads is at most about `MAX_RATIO_OF_SUCCESSIVE_LOADS`. The further loads belong to
    nominal pressures of four significant digits. Raises a `ValueError` if the bodies were generated.
    """
    area, steps = _check_pair_is_measured(study, nominal_area), study.contact.loading_steps()
    interval_counts = np.maximum(
        np.ceil(np.log(steps[1:] / steps[:-1]) / math.log(MAX_RATIO_OF_SUCCESSIVE_LOADS) - 0.02), 1
    ).astype(int)
    loads_between_steps = [
        float(f"{load / area:.4g}") * area
        for load_below, load_above, count in zip(steps[:-1], steps[1:], interval_counts, strict=True)
        for load in np.geomspace(load_below, load_above, count, endpoint=False)[1:].tolist()
    ]
    return np.unique([*loads_between_steps, *steps])


def _check_pair_is_measured(study: Study, nominal_area: float | None) -> float:
    """Return the nominal area (µm²) of a measured pair, or raise a `ValueError` if the bodies were generated."""
    if nominal_area is None or not study.is_measured:
        raise ValueError("a joint table needs a measured pair, got generated surfaces; use stiction table instead")
    return nominal_area


def parse_closure_start(closure_from: Any, study: Study, nominal_area: float | None) -> float:
    """Convert the reference state of closure, given as a load or a nominal pressure, to a load in mN.

    Raises a `ValueError` if the bodies were generated.
    """
    area = _check_pair_is_measured(study, nominal_area)
    try:
        load = loads_to_core_units("closure_from", closure_from, area)
        return validate_number("closure_from", load, unit="mN", above=0)
    except ValueError as error:
        raise ArgumentError.for_argument("closure_from", str(error).removeprefix("closure_from ")) from None


def add_load(loads: Floats, load: float) -> tuple[Floats, float]:
    """Add a load (mN) to an array that lacks the load. Return the array, and the load as stored in the array."""
    equal_loads = loads[np.isclose(loads, load, rtol=MAX_LOAD_ROUND_OFF, atol=0)]
    return (loads, float(equal_loads[0])) if equal_loads.size else (np.unique([*loads, load]), load)


def build_joint_study(
    study: Study, nominal_area: float | None, loads: Sequence[float] | None = None, *further_loads: float
) -> Study:
    """Return a copy of a measured pair's study with the loads of the joint table and `further_loads` (mN).

    If `loads` (mN) are given, the copy has these loads and the computed loads of the study instead.
    """
    table_loads = choose_joint_loads(study, nominal_area)
    if loads is not None:
        table_loads = np.unique([*study.contact.loading_steps(), *loads])
    for load in further_loads:
        table_loads, _ = add_load(table_loads, load)
    return study.with_changes({"contact.load": [f"{load!r} mN" for load in table_loads.tolist()]})


def build_joint_table(
    at: xarray.Dataset, study: Study, units: str, assessments: Mapping[float, str], closure_from: float | None = None,
    reference_load: float | None = None,
) -> JointTable:  # fmt: skip
    """Build a measured pair's joint table from a dataset that `Result.at` returned, for the first mu0 and first tau0.

    `assessments` contains the assessment of the coefficient at each load (mN). Loads at which the pair has no closure
    are omitted. `closure_from` is the load (mN) from which the closure is counted, by default 0 (first contact).
    `reference_load` is the load (mN) of `JointTable.reference`, by default the lowest load of the study.

    Raises
    ------
    ValueError
        If no load has a closure, if `reference_load` has none, or if `closure_from` has no closure or no stiffness of
        closure.
    """
    parsed_units = JointUnits.parse(units)
    rule = list_rules_with_reported_first(study)[0]
    at = select_sliding_rule(at, rule).isel(mu0=0, tau0=0)
    at = at.isel(cut_off=0) if "cut_off" in at.dims else at
    steps, area = study.contact.loading_steps(), float(at["nominal_area"])
    estimates_by_load = {load: _read_row(at.sel(load=load), load / area) for load in at["load"].values.tolist()}
    omitted_loads = [load for load, row in estimates_by_load.items() if math.isnan(row["closure"].value)]
    table_loads = [load for load in estimates_by_load if load not in omitted_loads]
    start_pressure = Estimate(0.0, name="closure_from", unit="GPa")
    if closure_from is not None:
        start_pressure = replace(estimates_by_load[closure_from]["nominal_pressure"], name="closure_from")
        if closure_from in omitted_loads:
            lowest_pressure, highest_pressure = (format_with_unit(load / area, "GPa") for load in steps[[0, -1]])
            raise ArgumentError(
                "{closure_from} must be a pressure at which the pair has a closure, within the computed pressures "
                "({lowest} to {highest}), got {got}",
                lowest=lowest_pressure, highest=highest_pressure, got=format_with_unit(start_pressure.value, "GPa"),
            )  # fmt: skip
        if not math.isfinite(estimates_by_load[closure_from]["closure_stiffness"].value):
            raise ArgumentError(
                "{closure_from} must be a pressure at which the stiffness of closure is known, got {got}",
                got=format_with_unit(start_pressure.value, "GPa"),
            )
        table_rows = [estimates_by_load[load] for load in table_loads]
        closures = _count_closures_from(table_rows, table_loads.index(closure_from))
        for row, closure in zip(table_rows, closures, strict=True):
            row["closure"] = closure
    rows = []
    for load in table_loads:
        estimates = {name: parsed_units.convert(estimate) for name, estimate in estimates_by_load[load].items()}
        rows.append(JointRow(load, bool(np.isin(load, steps)), estimates, assessments[load]))
    if not rows:
        raise ValueError("a joint table needs the closure of the pair, which is unknown at all loads of the table")
    if reference_load is not None and reference_load in omitted_loads:
        pressure = format_with_unit(reference_load / area, "GPa")
        raise ValueError(f"the closure of the pair is unknown at {pressure}; compute the pair at this load")
    reference_load = float(study.friction.load[0]) if reference_load is None else reference_load
    reference = min(rows, key=lambda row: abs(math.log(row.load / reference_load)))
    start_pressure = parsed_units.convert(start_pressure)
    notes = (
        *_describe_definitions(study, at, start_pressure),
        _describe_assessments(rows),
        _describe_range(rows, parsed_units, start_pressure.value),
        *describe_negative_closures(rows, start_pressure),
        *(
            []
            if all(row.is_computed for row in rows)
            else [
                "Between the computed pressures, values are interpolated. Contacts that appear can change stiffnesses "
                "by several per cent there, and the intervals contain this error; export with --compute avoids it."
            ]
        ),
        *(f"No closure, and therefore no row, at {format_with_unit(load / area, 'GPa')}." for load in omitted_loads),
    )
    mu0, tau0 = float(at["mu0"]), float(at["tau0"])
    return JointTable(tuple(rows), parsed_units, reference, mu0, tau0, rule, start_pressure, notes)


def _count_closures_from(rows: Sequence[Mapping[str, Estimate]], start: int) -> list[Estimate]:
    """Return the closures in the rows of a joint table, counted from the closure in the row with index `start`.

    A closure between two pressures is the integral of the pressure over the stiffness of closure. Its limits are those
    for the limits of the stiffness at all pressures in between. If one of these is unknown, there is no interval.
    """
    closures = np.array([row["closure"].value for row in rows])
    stiffnesses = np.array([row["closure_stiffness"].value for row in rows])
    limits = np.array([[row["closure_stiffness"].lower, row["closure_stiffness"].upper] for row in rows])
    # A stiffness may be infinite, and its lower limit may be 0.
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = stiffnesses[:, np.newaxis] / limits
    increments = np.diff(closures)[:, np.newaxis] * (ratios[1:] + ratios[:-1]) / 2
    limits_below = -np.cumsum(increments[:start][::-1], axis=0)[::-1]
    limits_above = np.cumsum(increments[start:], axis=0)
    limits_from_start = np.sort(np.concatenate([limits_below, np.zeros((1, 2)), limits_above]), axis=1)
    counted_closures = []
    for row, value, (lower, upper) in zip(rows, closures - closures[start], limits_from_start, strict=True):
        has_interval = value != 0 and not (np.isnan(lower) or np.isnan(upper))
        counted_closures.append(
            replace(
                row["closure"], value=float(value), lower=float(lower) if has_interval else math.nan,
                upper=float(upper) if has_interval else math.nan, kind="combined" if has_interval else "",
            )
        )  # fmt: skip
    return counted_closures


def _read_row(point: xarray.Dataset, pressure: float) -> dict[str, Estimate]:
    """Return all quantities of a joint table for one nominal pressure (GPa), in µm, mN and GPa, keyed by name."""
    # The pressure is rounded to twelve digits, which removes its round-off.
    pressure = float(f"{pressure:.12g}")
    estimates = {"nominal_pressure": Estimate(pressure, name="nominal_pressure", unit="GPa")}
    for name in (*JOINT_QUANTITIES, "friction_combined"):
        estimate = read_estimate(point[name]) if name in point else Estimate(math.nan, name=name)
        kind = estimate.kind if estimate.has_interval else ""
        is_missing = math.isnan(estimate.value)
        estimates[name] = replace(estimate, kind=kind, status="not-computed" if is_missing else "ok")
    for name, percentile in FRICTION_PERCENTILES_BY_NAME.items():
        has_percentiles = "friction_percentiles" in point
        value = float(point["friction_percentiles"].sel(percentile=percentile)) if has_percentiles else math.nan
        estimates[name] = Estimate(
            value, name="friction_percentiles", kind="prediction", status="no-prediction" if math.isnan(value) else "ok"
        )
    return estimates


# ---- Words -----------------------------------------------------------------------------------------------------------


def describe_closure_start(start_pressure: Estimate) -> str:
    """Return the clause that states from which pressure closure is counted, such as "since first contact"."""
    if start_pressure.value == 0:
        return "since first contact"
    return f"since a nominal pressure of {start_pressure.value:.6g} {start_pressure.unit}"


MODEL_ERROR_NOTE = (
    f"The intervals do not include the error of the model: the computed stiffness of closure is {MODEL_ERROR_TEXT}."
)
"""Sentence on the error of the model, in every file with closures and stiffnesses of a joint."""

FIRST_CONTACT_NOTE = (
    "First contact is a single point: in a model of the joint, count the closure from a small pressure instead"
)
"""Advice on closures that are counted from first contact, without the full stop."""


def _describe_definitions(study: Study, at: xarray.Dataset, start_pressure: Estimate) -> list[str]:
    rule = str(at["sliding"].values)
    advice = (
        f"{FIRST_CONTACT_NOTE} (--closure-from)."
        if start_pressure.value == 0
        else "The intervals of the closure follow from those of the stiffness at the pressures in between."
    )
    notes = [
        "All quantities are per nominal area, for first loading and the normal load before sliding.",
        f"Closure: decrease of the mean gap {describe_closure_start(start_pressure)}, without bending of the bodies as "
        f"a whole. Stiffness of closure: derivative of the pressure with respect to it. {advice}",
        MODEL_ERROR_NOTE,
        describe_tangential_stiffness(study, at),
        f"Coefficient of static friction: friction at {'all contacts' if rule == 'all' else 'opposing contacts only'}; "
        "5, 50 and 95 % of single tests in one direction at one position have smaller values. The median differs from "
        "the coefficient, because the distribution of the inputs is not symmetric.",
    ]
    if "friction_percentiles" not in at or np.isnan(at["friction_percentiles"]).all():
        notes.append(f"No percentiles: {_explain_missing_percentiles(study, at)}.")
    if study.is_gap:
        notes.append(
            "A map of the gap does not contain the slopes of the faces, so that its friction is an assumption."
        )
    return notes


def _explain_missing_percentiles(study: Study, at: xarray.Dataset) -> str:
    coefficients = at["friction_combined"].sel(statistic="mean").values
    if (np.abs(coefficients) < NEGLIGIBLE_COEFFICIENT).all():
        return "the coefficient is 0"
    if int(at["members"]) < MIN_PREDICTION_POSITIONS and not study.is_gap:
        return "a prediction needs at least three positions"
    return "a prediction needs a coefficient with an interval"


def describe_tangential_stiffness(study: Study, at: xarray.Dataset) -> str:
    """Describe how the tangential stiffness in a joint table was computed, or why it is missing."""
    if "tangential_stiffness_per_area" not in at or np.isnan(at["tangential_stiffness_per_area"]).all():
        return "No tangential stiffness: the result was stored without the stiffness while unloading; compute it again."
    contact: Any = study.contact
    given_poisson = contact.poisson
    start = "Tangential stiffness: before slip, equal to the stiffness of closure while unloading"
    if has_grooves(study):
        text = (
            f"{start}, because parallel grooves across the motion deform in plane strain. This stiffness is not "
            "validated."
        )
    else:
        ratios = np.unique(np.array(given_poisson or (DEFAULT_POISSON_RATIO,), float)).tolist()
        poisson = " and ".join(f"{ratio:.3g}" for ratio in ratios) + ("" if given_poisson else " (assumed)")
        factor = find_tangential_stiffness_ratio(study)
        text = (
            f"{start} times {factor:.3g}, Mindlin's ratio for isotropic surfaces with Poisson's ratio {poisson}. This "
            "stiffness is not validated."
        )
    beta = _compute_dundurs_beta(given_poisson or DEFAULT_POISSON_RATIO, getattr(contact, "compliance_share", 0.5))
    if beta < MIN_DUNDURS_BETA:
        return text
    return (
        f"{text} Normal displacements under a tangential load, which different materials cause, are neglected: "
        f"Dundurs' beta is {beta:.1g}, and the stiffness depends on its square."
    )


def _compute_dundurs_beta(poisson: Any, compliance_share: float) -> float:
    """Return |β| (Dundurs' parameter, plane strain) from Poisson's ratios and the lower body's contribution to 1/E*."""
    factors = [(1 - 2 * ratio) / (1 - ratio) for ratio in parse_poisson_ratios(poisson)]
    return abs((1 - compliance_share) * factors[0] - compliance_share * factors[1]) / 2


def _describe_assessments(rows: Sequence[JointRow]) -> str:
    """Return a sentence that states how many rows of a joint table have each assessment, such as "Do not quote"."""
    assessment_counts = Counter(row.assessment for row in rows)
    assessment_texts = [
        f"{text} ({assessment_counts[text]} of {len(rows)} pressures)"
        for text in ASSESSMENTS_BY_SEVERITY.values()
        if assessment_counts[text]
    ]
    return (
        f"Assessment of the coefficient: {', '.join(assessment_texts)}; for the reasons at a pressure, run stiction at."
    )


def _describe_range(rows: Sequence[JointRow], units: JointUnits, start_pressure: float) -> str:
    lowest_pressure, highest_pressure = rows[0].pressure.value, rows[-1].pressure.value
    text = f"Valid from {lowest_pressure:.4g} to {highest_pressure:.4g} {units.pressure}."
    if start_pressure == 0:
        return f"{text} Below, a straight line to zero closure is only a continuation."
    return text


def describe_negative_closures(rows: Sequence[JointRow], start_pressure: Estimate) -> list[str]:
    """Return the note on negative closures in a joint table, or an empty list if the table contains none."""
    if rows[0].pressure.value >= start_pressure.value:
        return []
    return [f"Closures below {start_pressure.value:.6g} {start_pressure.unit} are negative."]
