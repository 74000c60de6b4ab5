"""Summary of a result, computed once for all outputs: coefficients, intervals, caveats and assessments.

A summary has one `PointSummary` for each combination of surfaces or cutoff, load, mu0 and tau0. The terminal, JSON,
CSV, figures, reports and notebooks show these points, and compute nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._estimate import Estimate, Interval
from stiction.companions.onset import read_onset_summary
from stiction.companions.resolution import find_resolution_effect, find_resolution_limits
from stiction.evaluate.point import (
    CELL_DIMENSIONS,
    UNKNOWN_INTERVAL,
    SlidingRuleCoefficient,
    compute_plastic_friction,
    effective_modulus_at,
    find_contact_status,
    find_statistic_indices,
    get_adhesion_ranges,
    get_contact_hardness,
    get_roughness_exponent,
    is_stronger_than_body,
    is_unloaded,
    iterate_points,
    list_rules_with_reported_first,
    mean_contact_pressure,
    mean_over_directions,
    nominal_pressure_at,
    read_estimate,
    read_estimates_along,
    read_number,
    read_point_quantities,
    select_sliding_rule,
    sort_sliding_rules,
)
from stiction.evaluate.pull_off import PullOffValues, find_pull_off_values
from stiction.mechanics import friction
from stiction.mechanics.brackets import friction_range_for_finer_scans
from stiction.mechanics.model import PROFILE_WIDTH, SlidingRule
from stiction.solve.alternative_preparations import ALTERNATIVE_CONDITIONS, AlternativeName
from stiction.study.inputs import Inputs
from stiction.summary.assessment import (
    ASPERITY_CHECKS,
    FEW_CONTACTS_CHECK_NAMES,
    Caveat,
    assess_caveats,
    find_caveats_of_failed_checks,
    find_lay_caveats,
    find_point_caveats,
)

if TYPE_CHECKING:
    import xarray

    from stiction.companions.onset import OnsetSummary
    from stiction.companions.resolution import ResolutionEffect, ResolutionLimits
    from stiction.study.measured_bodies import ScanCutoffs
    from stiction.study.study import Study

# Label of the uncertainty-budget entry for short wavelengths that the automatic cutoff removes as possible noise.
POSSIBLE_NOISE_INPUT_NAME = "possible instrument noise"
MIN_DOMINANT_INPUT_FRACTION = 0.1


@dataclass(frozen=True)
class UncertaintyBudgetEntry(Estimate):
    """Row of the uncertainty budget: the coefficient's interval that would remain if a given input were exact."""

    _: KW_ONLY
    label: str
    width: float


@dataclass(frozen=True)
class CoefficientAtDwellTime(Estimate):
    """Friction coefficient after a dwell time under load, with its combined 95 % interval."""

    _: KW_ONLY
    seconds: float


@dataclass(frozen=True, eq=False)
class PointSummary:
    """Friction for one combination of load, mu0, tau0 and roughness (or cutoff), with its caveats and assessment.

    Attributes
    ----------
    study : Study
    values : xarray.Dataset
        All quantities at the point, with their intervals, as returned by `Result.at`.
    rules : tuple of SlidingRuleCoefficient
        Coefficients of static friction by sliding rule, starting with the quoted rule.
    status : str
        "ok", or the reason why there is no coefficient.
    caveats : tuple of Caveat
        Caveats, starting with faults.
    at : dict
        Coordinates of the point: the cell, the Hurst exponent, load (mN), mu0 and tau0 (GPa).
    bracket : (float, float), optional
        Range that contains the coefficient of any finer scan if friction acts at all contacts. The range extends from
        mu0 + tau0/H to the upper limit of the interval of this scan, with an allowance for a small number of contacts.
        None if there is no hardness, or if the point has a fault. Faults about few contacts per member are ignored,
        unless there is a second cutoff or the fault comes from an alternative preparation of the scans.
    roughness_contribution : float, optional
        Contribution to the coefficient that depends on the scans rather than on the inputs alone.
    budget : tuple of UncertaintyBudgetEntry
        Intervals that would remain if an input were exact, starting with the most important input.
    contributions : (float, float, float), optional
        Contributions to the coefficient: mu0, tau0 on the true area at the onset of sliding, and slopes.
    after_dwell : tuple of CoefficientAtDwellTime
        Coefficients after each dwell time of the study.
    covered : bool
        True if the interval of another point, at another cutoff, covers this point.
    pull_off : PullOffValues, optional
        Pull-off force, and friction without a load, of adhesive bodies.
    quantities : dict of Estimate
        Quantities with one value for the point and their 95 % intervals, for the reported sliding rule: undirected
        quantities, or all quantities if there is a single direction.
    numbers : dict of float
        Values of the quantities without an interval, selected as for `quantities`.
    distributions : dict of dict of Estimate
        Quantiles of the quantities that have a distribution, by the fraction of the distribution below the quantile.
    """

    study: Study
    values: xarray.Dataset
    rules: tuple[SlidingRuleCoefficient, ...]
    status: str
    caveats: tuple[Caveat, ...] = ()
    at: dict[str, Any] = field(default_factory=dict)
    bracket: tuple[float, float] | None = None
    roughness_contribution: float | None = None
    budget: tuple[UncertaintyBudgetEntry, ...] = ()
    contributions: tuple[float, float, float] | None = None
    after_dwell: tuple[CoefficientAtDwellTime, ...] = ()
    covered: bool = False
    pull_off: PullOffValues | None = None
    quantities: Mapping[str, Estimate] = field(default_factory=dict, repr=False)
    numbers: Mapping[str, float] = field(default_factory=dict, repr=False)
    distributions: Mapping[str, Mapping[float, Estimate]] = field(default_factory=dict, repr=False)

    @property
    def has_values_of_interface(self) -> bool:
        """True if mu0 and tau0 at this result point are the medians of a calibrated interface."""
        return has_values_of_interface(self.study, self.at)

    @property
    def are_strengths_separated(self) -> bool:
        """True if mu0 and tau0 are known separately, and not only their sum mu0 + tau0 A/F from friction tests."""
        return are_strengths_separated(self.study, self.at)

    @property
    def calibrated_rule(self) -> SlidingRule | None:
        """Sliding rule assumed in the calibration of mu0 and tau0, or None if no friction tests were fitted."""
        interface = self.study.friction.interface
        is_calibrated = interface is not None and not interface.is_published and self.has_values_of_interface
        return interface.fitted_rule if is_calibrated and interface is not None else None

    @property
    def contribution_terms(self) -> dict[str, float]:
        """Contributions of mu0, adhesion and slopes to the coefficient, by name; empty if they are unknown.

        The contributions of mu0 and tau0 are one term if the tests of the interface determine only their sum.
        """
        if self.contributions is None:
            return {}
        mu0, adhesion, slopes = self.contributions
        if not self.are_strengths_separated:
            return {"mu0_and_adhesion": mu0 + adhesion, "slopes": slopes}
        return {"mu0": mu0, "adhesion": adhesion, "slopes": slopes}

    @property
    def cutoffs(self) -> ScanCutoffs | None:
        """Cutoff wavelengths (µm) for the scans of both bodies; 0 stands for no filter. None for generated bodies."""
        surfaces: Any = self.study.surfaces
        return surfaces.get_scan_cut_offs(self.at["cut_off"]) if "cut_off" in self.at else None

    @cached_property
    def quoted_values(self) -> xarray.Dataset:
        """Friction and contact quantities at this result point, for the sliding rule that output shows first.

        The true area of generated bodies depends slightly on the rule.
        """
        return select_sliding_rule(self.values, self.rules[0].rule)  # type: ignore[no-any-return]

    @property
    def members(self) -> float:
        """Number of surface pairs (members) over which the coefficient is averaged."""
        return mean_over_directions(self.values, "members")

    @property
    def scans(self) -> tuple[int, int]:
        """Number of scans of the upper body, and number of scans of the lower body."""
        return self.study.surfaces.scan_counts

    @property
    def hardness(self) -> float | None:
        """Hardness (GPa) of the contacts, or None if the study has no hardness."""
        return None if self.study.contact.hardness is None else get_contact_hardness(self.values, self.study)

    @property
    def has_junction_growth(self) -> bool:
        """True if yielded contacts grow under shear."""
        return bool(self.study.contact.junction_growth)

    @property
    def contact_status(self) -> str:
        """Status of the true area: "ok", "complete" (full contact), or "above-nominal" (only in the asperity model)."""
        return find_contact_status(self.quoted_values, self.study)

    @property
    def is_unloaded(self) -> bool:
        """True if the load is negligible compared with the pull-off force."""
        return is_unloaded(self.values)

    @property
    def roughness_exponent(self) -> tuple[str, float]:
        """Symbol and value of the roughness exponent: H for self-affine surfaces, fractal dimension D for others."""
        return get_roughness_exponent(self.study, self.at["fractal_dimension"])

    @property
    def nominal_pressure(self) -> float:
        """Nominal pressure (GPa), or NaN if the contact model has no nominal area."""
        return nominal_pressure_at(self.values, self.study)

    @property
    def mean_pressure(self) -> float:
        """Mean contact pressure (GPa) on the true area."""
        return mean_contact_pressure(self.quoted_values)

    @property
    def effective_modulus(self) -> float:
        """Effective modulus E* (GPa) of the pair."""
        return effective_modulus_at(self.values, self.study)

    @property
    def adhesion_range(self) -> float:
        """Range (µm) of the attraction, as used in the computation of adhesive contacts."""
        return get_adhesion_ranges(self.values, self.study)[1]

    @property
    def directions(self) -> tuple[float, ...]:
        """Directions of motion of the upper body (degrees) over which the coefficient is averaged."""
        if "direction" not in self.values.coords:
            return ()
        return tuple(np.atleast_1d(self.values["direction"].values).astype(float).tolist())

    @property
    def spacings(self) -> tuple[float, ...]:
        """Distinct grid spacings (µm) of the surfaces; empty if the spacings are unknown."""
        return tuple(np.unique(np.atleast_1d(self.values.attrs.get("spacing_um", ())).astype(float)).tolist())

    @property
    def kappa(self) -> float:
        """Area coefficient κ = A E* h'/F with the rms gradient h', or NaN if the rms gradient is unknown."""
        if "rms_gradient" not in self.quantities:
            return math.nan
        return self.quantities["rms_gradient"].value * self.effective_modulus / self.mean_pressure

    @property
    def load_definition_effect(self) -> float:
        """Largest relative difference of the coefficient between two definitions of the load; NaN if unknown."""
        return self.numbers.get("load_definition_effect", math.nan)

    @property
    def value(self) -> float:
        """Static friction coefficient under the reported sliding rule."""
        return self.rules[0].value

    @property
    def lower(self) -> float:
        """Lower limit of the combined 95 % interval of `value`."""
        return self.rules[0].lower

    @property
    def upper(self) -> float:
        """Upper limit of the combined 95 % interval of `value`."""
        return self.rules[0].upper

    @property
    def dominant_input(self) -> UncertaintyBudgetEntry | None:
        """Input that contributes most to the interval, or None if no input is dominant."""
        largest_entry, width = self.budget[:1], self.upper - self.lower
        return (
            largest_entry[0]
            if largest_entry and largest_entry[0].width < (1 - MIN_DOMINANT_INPUT_FRACTION) * width
            else None
        )

    @property
    def ageing(self) -> float:
        """Increase of the coefficient per unit of ln(dwell time), or NaN if the study has no dwell times."""
        if not self.after_dwell or self.after_dwell[-1].seconds == 1:
            return math.nan
        longest_wait = self.after_dwell[-1]
        return (longest_wait.value - self.value) / math.log(longest_wait.seconds)

    @property
    def contact_size(self) -> Estimate:
        """Median contact size (µm): the diameter of a circle of equal area or, for profiles, the contact length."""
        median_area = self.distributions.get("patch_area", {}).get(0.5, Estimate(math.nan))
        sizes = [
            2 * math.sqrt(area / math.pi) if self.study.is_areal else area / PROFILE_WIDTH
            for area in (median_area.value, median_area.lower, median_area.upper)
        ]
        return Estimate(*sizes, name="contact_size", unit="um", kind=median_area.kind)

    @property
    def faults(self) -> tuple[Caveat, ...]:
        """Caveats that forbid quoting `value`."""
        return tuple(caveat for caveat in self.caveats if caveat.severity == "fault")

    @property
    def assessment(self) -> str:
        """Assessment of `value`: "Quote it", "Quote with care" or "Do not quote"."""
        return assess_caveats(self.caveats)


@dataclass(frozen=True, eq=False)
class Summary:
    """Summary of a result: one `PointSummary` for each combination of load, mu0, tau0 and roughness (or cutoff).

    Attributes
    ----------
    study : Study
    at : xarray.Dataset
        All quantities with their intervals and the uncertainty budget, as returned by `Result.at`.
    points : tuple of PointSummary
        One point for each combination of surfaces or cutoff, load, mu0 and tau0, starting with the reported points.
    onset : xarray.Dataset, optional
        Onset of sliding at the first load, mu0 and tau0 of the study.
    values_at_cutoffs : xarray.Dataset, optional
        Friction from the cutoff study, which has a few members at several cutoffs.
    no_points_reason : str
        Reason why there are no points, as in "the surfaces do not touch"; empty if there are points.
    """

    study: Study
    at: xarray.Dataset
    points: tuple[PointSummary, ...]
    onset: xarray.Dataset | None = None
    values_at_cutoffs: xarray.Dataset | None = None
    no_points_reason: str = ""

    @cached_property
    def resolution(self) -> ResolutionEffect | None:
        """Effect of scan resolution on friction; None for generated surfaces, and None if scan files are missing."""
        return find_resolution_effect(self.at, self.study, self._points_at_cutoffs)

    def find_resolution_limits(self, mu0_index: int = 0, tau0_index: int = 0) -> ResolutionLimits | None:
        """Return friction at several cutoff wavelengths, and bounds on the friction that a finer scan would give.

        Friction is evaluated for one mu0 and one tau0, at the first load of the study or, if the summary lacks this
        load, at the nearest load. Returns None if there is only one cutoff.
        """
        if (points := self._points_at_cutoffs) is None:
            return None
        first_load = float(self.study.friction.load[0])
        points = points.isel(mu0=mu0_index, tau0=tau0_index).sel(load=first_load, method="nearest")
        return find_resolution_limits(points, self.study)

    @property
    def _points_at_cutoffs(self) -> xarray.Dataset | None:
        """Friction at several cutoffs: `at` or, if `at` has one cutoff, `values_at_cutoffs`, which may be None."""
        points = self.at if self.at.sizes.get("cut_off", 0) > 1 else self.values_at_cutoffs
        return None if points is None else sort_sliding_rules(points, self.study)

    @cached_property
    def onset_values(self) -> OnsetSummary | None:
        """Loads, displacements and stiffnesses of the onset of sliding, or None if no onset has been computed."""
        return None if self.onset is None else read_onset_summary(self.onset)

    @property
    def reported_points(self) -> list[PointSummary]:
        """Result points that output shows: all except points that the intervals of another point already cover.

        The intervals of the points at the reported cutoff include the results at the covered cutoff.
        """
        return [point for point in self.points if not point.covered]

    @property
    def first(self) -> PointSummary:
        """First result point that output shows, that is, the first of `reported_points`."""
        return self.reported_points[0]


def summarize(
    at: xarray.Dataset, study: Study, *, input_caveats: Sequence[Caveat] = (),
    alternatives: Mapping[AlternativeName, Summary] | None = None, **alongside: Any,
) -> Summary:  # fmt: skip
    """Summarize the friction and contact quantities of a study, from a dataset that `Result.at` returned.

    Parameters
    ----------
    at : xarray.Dataset
    study : Study
    input_caveats : sequence of Caveat
        Caveats about the bodies, as returned by `find_input_caveats`.
    alternatives : mapping of Summary, optional
        Summaries for alternative preparations of the scans at the same points, without caveats about the bodies.
    **alongside : xarray.Dataset
        `onset` and `values_at_cutoffs`, if they are stored.
    """
    at = sort_sliding_rules(at, study)
    summaries = [
        summarize_point(
            point,
            study,
            input_caveats,
            covers_alternatives=_have_intervals(alternatives or {}, _get_point_coordinates(point, study)),
        )
        for point in iterate_points(at)
    ]
    summaries = _merge_cutoff_points(summaries) if study.surfaces.both_readings else summaries
    for name, other in (alternatives or {}).items():
        summaries = [_include_faults_of_alternative(point, name, other) for point in summaries]
    return Summary(study, at, tuple(summaries), **alongside)


def _have_intervals(alternatives: Mapping[AlternativeName, Summary], coordinates: Mapping[str, float]) -> bool:
    """Return whether the result of each alternative scan preparation has an interval at the given coordinates."""
    return all(
        point.rules[0].has_interval
        for alternative in alternatives.values()
        for point in alternative.points
        if point.at == coordinates
    )


def _include_faults_of_alternative(point: PointSummary, name: AlternativeName, alternative: Summary) -> PointSummary:
    """Add the severe caveats of another scan preparation to the caveats of a result point, without duplicates.

    Without these faults, errors of a scan could improve an assessment. For example, spikes hold two bodies apart, so
    that more contacts carry the load.
    """
    (other_point,) = (other for other in alternative.points if other.at == point.at)
    own_faults = {caveat.name or caveat.text for caveat in point.faults}
    other_faults = [
        replace(caveat, text=f"{ALTERNATIVE_CONDITIONS[name]}: {caveat.text}")
        for caveat in other_point.faults
        if (caveat.name or caveat.text) not in own_faults
    ]
    if not other_faults:
        return point
    caveats = sorted([*point.caveats, *other_faults], key=lambda caveat: caveat.severity != "fault")
    return replace(point, caveats=tuple(caveats), bracket=None)


def _merge_cutoff_points(points: Sequence[PointSummary]) -> list[PointSummary]:
    """Widen each coefficient's interval at the reported cutoff to include its interval at the study's other cutoff.

    The returned list begins with the points at the reported cutoff. The points at the other cutoff are marked as
    covered.
    """
    # The first result point is at the reported cutoff.
    cut_off = points[0].at["cut_off"]
    points_at_other_cutoff = {
        _get_coordinates_without_cutoff(point): point for point in points if point.at["cut_off"] != cut_off
    }
    quoted_points = [point for point in points if point.at["cut_off"] == cut_off]
    covering_points = [
        _extend_point_to_other_cutoff(point, points_at_other_cutoff[_get_coordinates_without_cutoff(point)])
        if _get_coordinates_without_cutoff(point) in points_at_other_cutoff
        else point
        for point in quoted_points
    ]
    return [*covering_points, *(replace(point, covered=True) for point in points_at_other_cutoff.values())]


def _get_coordinates_without_cutoff(point: PointSummary) -> tuple[tuple[str, float], ...]:
    """Return names and values of a result point's coordinates, except the cutoff."""
    return tuple(item for item in point.at.items() if item[0] != "cut_off")


def _extend_point_to_other_cutoff(point: PointSummary, other_point: PointSummary) -> PointSummary:
    """Widen a result point's intervals to include those of another cutoff, and add the other cutoff's severe caveats.

    Filtering does not improve an assessment, so a fault at the other cutoff is also a fault of the reported point.
    """
    rules = tuple(
        _extend_value_to_other_cutoff(*coefficients)
        for coefficients in zip(point.rules, other_point.rules, strict=True)
    )
    other_budget = {entry.label: entry for entry in other_point.budget}
    # With only one or two relative positions of the bodies, the interval of the coefficient is infinite or NaN.
    has_interval = math.isfinite(point.upper - point.lower)
    budget = [_build_entry_of_possible_noise(point)] if has_interval else []
    for entry in point.budget:
        extended_entry = entry.extended_to(other_budget.get(entry.label, entry))
        budget.append(replace(extended_entry, width=extended_entry.upper - extended_entry.lower))
    other_coefficient = other_point.rules[0]
    is_measured = point.at["cut_off"] == 0
    text = f"; {'without' if is_measured else 'with'} them μ_s is {other_coefficient}"
    text = text if math.isfinite(other_coefficient.value) else ""
    own_caveats = [
        replace(caveat, text=caveat.text + text) if caveat.has_second_cutoff else caveat for caveat in point.caveats
    ]
    caveat_texts = {caveat.text for caveat in point.caveats}
    other_caveats = [
        replace(caveat, text=f"as measured: {caveat.text}")
        for caveat in other_point.faults
        if not (is_measured or caveat.has_second_cutoff or caveat.text in caveat_texts)
    ]
    caveats = sorted([*own_caveats, *other_caveats], key=lambda caveat: caveat.severity != "fault")
    sorted_budget = tuple(sorted(budget, key=lambda entry: entry.width))
    bracket = None if any(caveat.severity == "fault" for caveat in caveats) else point.bracket
    return replace(point, rules=rules, budget=sorted_budget, caveats=tuple(caveats), bracket=bracket)


def _build_entry_of_possible_noise(point: PointSummary) -> UncertaintyBudgetEntry:
    """Return the uncertainty budget's row for possible noise: the interval that would remain if noise were excluded."""
    width = point.upper - point.lower
    return UncertaintyBudgetEntry(
        point.value, point.lower, point.upper, name="remaining_interval", kind="conditional",
        label=POSSIBLE_NOISE_INPUT_NAME, width=width,
    )  # fmt: skip


def _extend_value_to_other_cutoff(
    value: SlidingRuleCoefficient, other_value: SlidingRuleCoefficient
) -> SlidingRuleCoefficient:
    """Widen the intervals of a coefficient to include the intervals of the same coefficient at another cutoff."""
    return replace(
        value.extended_to(other_value),
        prediction_interval=value.prediction_interval.extended_to(other_value.prediction_interval),
    )


def summarize_point(
    point: xarray.Dataset, study: Study, input_caveats: Sequence[Caveat] = (), *, covers_alternatives: bool = True
) -> PointSummary:
    """Summarize friction at one load, mu0 and tau0 of a dataset that `Result.at` returned; add `input_caveats`.

    `covers_alternatives` is true unless the interval omits an alternative preparation of the scans.
    """
    values_by_rule = {rule: select_sliding_rule(point, rule) for rule in list_rules_with_reported_first(study)}
    rules = tuple(_build_rule_coefficient(values, rule) for rule, values in values_by_rule.items())
    quoted_values = values_by_rule[rules[0].rule]
    status = _find_reported_status(rules[0])
    quantities = read_point_quantities(point, rules[0].rule)
    cut_off = read_number(point, "cut_off") if "cut_off" in point.coords else 0.0
    rule_with_interval_of_mean = _with_interval_of_mean(rules[0])
    has_interval_note = rules[0].has_interval and covers_alternatives
    # A caveat about short wavelengths is removed only if the user has specified a cutoff that filters them out.
    kept_caveats = [
        replace(caveat, text=caveat.text + (caveat.interval_note if has_interval_note else ""), interval_note="")
        for caveat in input_caveats
        if study.surfaces.both_readings or cut_off < caveat.cut_off
    ]
    roughness_contributions = {
        rule.rule: _estimate_roughness_contribution(values_by_rule[rule.rule], study, rule) for rule in rules
    }
    caveats = [
        *kept_caveats,
        *find_point_caveats(quoted_values, study, rule_with_interval_of_mean, status),
        *find_lay_caveats(study, rules, roughness_contributions.get("all")),
    ]
    return PointSummary(
        study=study,
        values=point,
        rules=rules,
        status=status,
        caveats=tuple(sorted(caveats, key=lambda caveat: caveat.severity != "fault")),
        at=_get_point_coordinates(point, study),
        bracket=None
        if any(_invalidates_finer_scan_bounds(caveat) for caveat in caveats)
        else _find_bounds_for_finer_scans(quoted_values, study, rule_with_interval_of_mean),
        budget=_list_budget_entries(point, rules[0]),
        contributions=_compute_friction_contributions(quoted_values, study, rules[0]),
        roughness_contribution=roughness_contributions[rules[0].rule],
        after_dwell=_list_dwell_time_coefficients(point, rules[0].rule),
        pull_off=find_pull_off_values(point, study, rules[0].rule),
        quantities=quantities.estimates,
        numbers=quantities.numbers,
        distributions=quantities.distributions,
    )


def assess_coefficients(at: xarray.Dataset, study: Study) -> xarray.DataArray:
    """Return the assessment of each coefficient in a dataset that `Result.at` returned for generated surfaces.

    A summary assesses only the coefficient for the reported sliding rule; this array has the dimension `sliding`.
    """
    import xarray

    rules, points = study.contact.sliding_rules(), list(iterate_points(at))
    dims = [name for name in (*CELL_DIMENSIONS, "load", "mu0", "tau0") if name in at.dims]
    assessments = []
    for rule in rules:
        for values in (select_sliding_rule(point, rule) for point in points):
            coefficient = _build_rule_coefficient(values, rule)
            caveats = find_point_caveats(
                values, study, _with_interval_of_mean(coefficient), _find_reported_status(coefficient)
            )
            assessments.append(assess_caveats(caveats))
    array = np.array(assessments).reshape(len(rules), *(at.sizes[name] for name in dims))
    return xarray.DataArray(array, {"sliding": list(rules)} | {name: at[name] for name in dims}, ("sliding", *dims))


# ---- Values ----------------------------------------------------------------------------------------------------------


def _find_reported_status(coefficient: SlidingRuleCoefficient) -> str:
    """Return the status of a coefficient if the coefficient is NaN or only a lower limit, and "ok" otherwise."""
    has_status = math.isnan(coefficient.value) or coefficient.status == friction.STATUS_BULK_SHEAR
    return coefficient.status if has_status else friction.STATUS_OK


def _with_interval_of_mean(coefficient: SlidingRuleCoefficient) -> SlidingRuleCoefficient:
    interval = coefficient.interval_of_mean
    return replace(coefficient, lower=interval.lower, upper=interval.upper)


def _build_rule_coefficient(table: xarray.Dataset, rule: str) -> SlidingRuleCoefficient:
    """Return the coefficient and its intervals for one sliding rule, at one load, mu0 and tau0."""
    name = "mean_friction" if "mean_friction" in table else "friction_coefficient"
    mean = read_estimate(table[name])
    interval_of_mean = Interval(max(mean.lower, 0.0) if mean.lower < 0 <= mean.value else mean.lower, mean.upper)
    combined_interval = _get_interval(table, "friction_at_cutoff")
    low_quantile, high_quantile, slopes = (
        mean_over_directions(table, quantity) for quantity in ("spread_low", "spread_high", "gentle_friction")
    )
    return SlidingRuleCoefficient(
        mean.value,
        *(combined_interval or interval_of_mean),
        name=name if combined_interval is None else "friction_combined",
        kind="mean" if combined_interval is None else "combined",
        rule=rule,
        interval_of_mean=interval_of_mean,
        prediction_interval=_get_interval(table, "friction_prediction") or UNKNOWN_INTERVAL,
        status=_find_first_failure(table),
        low=low_quantile,
        high=high_quantile,
        slopes=slopes,
        is_outside_asperity_model=_is_outside_asperity_model(table),
        by_axis=_read_coefficients(table, "friction_by_axis", "axis"),
        by_direction=_read_coefficients(table, "friction_coefficient", "direction"),
    )


def _find_first_failure(table: xarray.Dataset) -> str:
    """Return "ok" if all directions have this status; otherwise, return the alphabetically first other status."""
    statuses = np.unique(table["status"].values).tolist()
    return next((str(status) for status in statuses if status != friction.STATUS_OK), friction.STATUS_OK)


def _is_outside_asperity_model(table: xarray.Dataset) -> bool:
    checked_fractions = {name: mean_over_directions(table, name) for name in ("share_beyond_hertz", "share_below_grid")}
    return any(find_caveats_of_failed_checks(ASPERITY_CHECKS, checked_fractions))


def _read_coefficients(table: xarray.Dataset, name: str, dimension: str) -> dict[float, Estimate]:
    """Return a quantity's estimates along a dimension, keyed by coordinate; empty if one of the two is missing."""
    return read_estimates_along(table[name], dimension) if name in table and dimension in table[name].dims else {}


def _get_interval(table: xarray.Dataset, name: str) -> Interval | None:
    """Return the 95 % interval of a quantity.

    Returns None if the quantity has no interval.
    """
    if name not in table:
        return None
    estimate = read_estimate(table[name])
    return estimate.interval if estimate.has_interval and math.isfinite(estimate.lower) else None


def _list_budget_entries(
    point: xarray.Dataset, coefficient: SlidingRuleCoefficient
) -> tuple[UncertaintyBudgetEntry, ...]:
    """Return the rows of the uncertainty budget in ascending order of the width of the remaining interval."""
    if "remaining_interval" not in point:
        return ()
    budget = select_sliding_rule(point[["remaining_interval", "remaining_width"]], coefficient.rule)
    limits = budget["remaining_interval"].transpose("input", "statistic").values[:, find_statistic_indices(budget)]
    intervals = (Interval(*pair) for pair in limits[:, 1:].tolist())
    labels_and_widths = (budget[name].values.tolist() for name in ("input_label", "remaining_width"))
    entries = [
        UncertaintyBudgetEntry(
            coefficient.value, *interval, name="remaining_interval", kind="conditional", label=label, width=width
        )
        for interval, label, width in zip(intervals, *labels_and_widths, strict=True)
        if math.isfinite(interval.lower) and not math.isnan(interval.upper)
    ]
    return tuple(sorted(entries, key=lambda entry: entry.width))


def _list_dwell_time_coefficients(point: xarray.Dataset, rule: str) -> tuple[CoefficientAtDwellTime, ...]:
    if "friction_after_dwell" not in point:
        return ()
    table = select_sliding_rule(point["friction_after_dwell"], rule).transpose("dwell_time", "statistic")
    seconds_and_values = zip(point["dwell_time"].values.tolist(), table.values.tolist(), strict=True)
    fields: dict[str, Any] = {"name": "friction_after_dwell", "kind": "combined"}
    return tuple(CoefficientAtDwellTime(*limits, seconds=seconds, **fields) for seconds, limits in seconds_and_values)


def _compute_friction_contributions(
    point: xarray.Dataset, study: Study, rule: SlidingRuleCoefficient
) -> tuple[float, float, float] | None:
    """Split a coefficient (friction at all contacts) into contributions of mu0, tau0 and slopes; None if unknown."""
    if rule.rule != "all" or not math.isfinite(rule.value) or rule.status == friction.STATUS_BULK_SHEAR:
        return None
    load = read_number(point, "load")
    area_name = "contact_area_at_onset" if "contact_area_at_onset" in point else "contact_area"
    contact_load = mean_over_directions(point, "contact_load") if "contact_load" in point else load
    law = Inputs.from_study(study).friction_law(read_number(point, "mu0"), read_number(point, "tau0"))
    parts = law.contributions(contact_load / load, mean_over_directions(point, area_name) / load)
    return *parts, rule.value - sum(parts)


def has_central_value(study: Study, coordinates: Mapping[str, Any], name: str) -> bool:
    """Return whether coordinate `name` (mu0 or tau0) equals the central value of the study's first mu0 or tau0."""
    return math.isclose(coordinates[name], float(getattr(study.friction, name)[0]), rel_tol=1e-3)


def has_values_of_interface(study: Study, coordinates: Mapping[str, Any]) -> bool:
    """Return whether mu0 and tau0 at a result point equal the medians of the study's interface."""
    has_interface = study.friction.interface is not None
    return has_interface and all(has_central_value(study, coordinates, name) for name in ("mu0", "tau0"))


def are_strengths_separated(study: Study, coordinates: Mapping[str, Any]) -> bool:
    """Return whether mu0 and tau0 are known separately, and not only their sum mu0 + tau0 A/F from friction tests."""
    interface = study.friction.interface if has_values_of_interface(study, coordinates) else None
    return interface is None or interface.separated is not False


def _get_point_coordinates(point: xarray.Dataset, study: Study) -> dict[str, float]:
    """Return the coordinates (such as load, mu0, tau0 or Hurst exponent) of a result point, keyed by name."""
    coordinates = {
        name: read_number(point, name) for name in (*CELL_DIMENSIONS, "load", "mu0", "tau0") if name in point.coords
    }
    if (
        "fractal_dimension" in coordinates
        and (roughness := get_roughness_exponent(study, coordinates["fractal_dimension"]))[0] == "H"
    ):
        coordinates["hurst_exponent"] = roughness[1]
    return coordinates


def _estimate_roughness_contribution(point: xarray.Dataset, study: Study, rule: SlidingRuleCoefficient) -> float | None:
    """Return the contribution of roughness to the friction coefficient if friction acts at all contacts.

    Returns None if the contribution is unknown.

    The rest of the coefficient is due to the inputs alone: mu0 and, with a hardness H, tau0/H if all contacts yield.
    The contribution is unknown with adhesion, because the load on the contacts also depends on the scans. It is also
    unknown for a gap, which does not contain the roughness of the two faces, if the interface of contacts that yield is
    stronger than the softer body, and if the tests of the interface do not separate mu0 from tau0.
    """
    contributions = _compute_friction_contributions(point, study, rule)
    if contributions is None or not study.is_measured or study.is_gap or study.contact.adheres:
        return None
    strengths = {name: read_number(point, name) for name in ("mu0", "tau0")}
    if is_stronger_than_body(point, study) or not are_strengths_separated(study, strengths):
        return None
    plastic_friction = compute_plastic_friction(point, study)
    return rule.value - (contributions[0] if plastic_friction is None else plastic_friction)


def _invalidates_finer_scan_bounds(caveat: Caveat) -> bool:
    """Return whether a caveat makes the bounds on the friction of finer scans invalid.

    Every fault invalidates the bounds, except too few contacts per member.
    """
    return caveat.severity == "fault" and caveat.name not in FEW_CONTACTS_CHECK_NAMES


def _find_bounds_for_finer_scans(
    point: xarray.Dataset, study: Study, coefficient: SlidingRuleCoefficient
) -> tuple[float, float] | None:
    """Return bounds on the coefficient that a finer scan would give; the bounds are accurate to second order in slope.

    The upper bound is the upper limit of the interval, plus an allowance for load that shorter wavelengths shift
    between contacts of different members. No bounds exist if the interface of contacts that yield is stronger than the
    softer body.
    """
    hardness = study.contact.hardness
    has_bracket = study.is_measured and study.uses_half_space and not study.contact.adheres
    if hardness is None or not has_bracket or coefficient.rule != "all" or not math.isfinite(coefficient.value):
        return None
    mu0, plastic_friction = read_number(point, "mu0"), compute_plastic_friction(point, study)
    if plastic_friction is None or math.isnan(plastic_friction) or is_stronger_than_body(point, study):
        return None
    upper = coefficient.upper if math.isfinite(coefficient.upper) else None
    num_contacts = mean_over_directions(point, "contact_count") * mean_over_directions(point, "members")
    return friction_range_for_finer_scans(coefficient.value, mu0, plastic_friction - mu0, num_contacts, upper)
