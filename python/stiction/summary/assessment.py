"""Assessment of a friction coefficient: caveats with remedies, and whether the coefficient may be quoted."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._number_format import format_load, format_number, format_percent, format_significant, format_with_unit
from stiction.calibration.friction_tests import NEGLIGIBLE_GROWTH_EFFECT
from stiction.evaluate.budget import is_tested_pair
from stiction.evaluate.intervals import MIN_NEIGHBOURING_POSITIONS, MIN_SAMPLE_SIZE
from stiction.evaluate.member_means import AREA_ABOVE_NOMINAL_STATUS, FULL_CONTACT_STATUS
from stiction.evaluate.member_values import has_grooves
from stiction.evaluate.point import (
    SlidingRuleCoefficient,
    effective_modulus_at,
    find_contact_status,
    get_adhesion_ranges,
    get_contact_hardness,
    get_study_hardness,
    has_limited_pressure,
    has_nominal_area,
    is_unloaded,
    mean_contact_pressure,
    mean_over_directions,
    nominal_pressure_at,
    read_number,
)
from stiction.mechanics import friction
from stiction.mechanics.half_space import DEFAULT_ADHESION_RANGE
from stiction.mechanics.half_space_problem import min_resolved_adhesion_range
from stiction.mechanics.hardness import estimate_indentation_depth, size_effect_factor
from stiction.mechanics.materials import MAX_RUBBER_MODULUS, softest_material
from stiction.study.input_distributions import UncertainInput, parse_input_value
from stiction.study.inputs import Inputs, find_materials
from stiction.study.interfaces import MIN_AREA_VARIATION, has_growth_of_tests
from stiction.study.moduli import DEFAULT_YIELD_EXPONENT, ELASTOMER_AREA_LOSS

if TYPE_CHECKING:
    import xarray

    from stiction.study.study import Study

Severity = Literal["caution", "fault"]

YIELD_PRESSURE_RATIO, METAL_YIELD_PRESSURE_RATIO = 1 / 20, 1 / 100
"""Ratios of mean contact pressure to E* above which every material (first) and most metals (second) have yielded."""

MIN_TOTAL_CONTACTS = 10
MIN_CONTACTS_PER_MEMBER, MIN_CONTACTS_PER_MEMBER_WITHOUT_CAVEAT = 5, 10
"""Minimum mean numbers of contacts per member for quoting a coefficient, and for quoting it without a caveat."""

MAX_LOAD_FRACTION_ON_CONTACT = 0.5
MAX_LOAD_FRACTION_AT_EDGE_WITHOUT_CAVEAT = 0.25
MAX_LOAD_FRACTION_ON_CONTACT_WITHOUT_CAVEAT = 0.4

MIN_MERGED_AREA_FRACTION = 0.3
MAX_AFFECTED_FRACTION = 0.5
MAX_INTERPOLATED_POINT_FRACTION = 0.02
MAX_SCATTERED_MISSING_FRACTION = 0.02
"""Largest fraction of scattered missing points for which there is no caveat about holes in contacts."""
MAX_AREA_LOSS_PER_HOLE = 1.3
"""Largest relative loss of A/A0 through scattered missing points, divided by the fraction of these points.

Elastic contacts that are much larger than the holes lose the fraction of points that are missing in either map. If 30 %
of both maps are missing at random, the loss is 1.3 times the fraction of points that are missing between measured
points. With 10 and 30 % missing, pairs with 10 to 200 points in contact lost 0.6 to 1.1 times that fraction on average.
"""
MAX_DRIFT_ERROR_WITHOUT_CAVEAT = 0.02
"""Relative standard error of the coefficient due to roughness drift above which the result has a caveat."""
MAX_SPACING_RATIO_OF_TWO_BODIES = 3.0

# If τ0 divided by H/√α exceeds this ratio, the interface counts as nearly as strong as the bulk.
MIN_STRENGTH_RATIO_NEAR_BULK = 0.7
MAX_FRACTION_OF_SAMPLES_WITHOUT_FRICTION_LIMIT = 0.025
MIN_FRACTION_OF_SAMPLES_WITHOUT_FRICTION_LIMIT = 0.01
"""Fraction of input samples without an upper limit of friction above which the result has a caveat.

The upper limit of an interval is the 97.5 % quantile. If a smaller fraction of samples were left out, this limit would
be the 96.5 % quantile or a higher one.
"""

MIN_LOAD_FRACTION_AT_HARDNESS = 0.1
"""Minimum load fraction on yielding contacts for a comparison of τ0 with the softer body's shear strength."""

TYPICAL_SIZE_EFFECT_LENGTH = 0.5
"""Typical length h* (µm) of the indentation size effect, for hardnesses measured at an unknown depth."""
MIN_HARDNESS_RATIO_IN_TEXT = 1.05
"""Ratio of two hardnesses below which a text states their difference in percent; it would be rounded to 1.0."""

MIN_MODULUS_TO_HARDNESS_RATIO = 25.0
"""Smallest ratio of E* to the hardness for which the assumed range of h* holds for metals; h* falls as (G/H)²."""
MIN_METAL_MODULUS = 20.0
"""Minimum E* (GPa) for which a yielding body of unknown material is assumed to be a metal."""

MAX_NEGLECTED_ADHESION_FRACTION = 0.05
# Typical work of adhesion of solids in air, in mN/µm (50 mJ/m²).
TYPICAL_WORK_OF_ADHESION = 5e-5
RIM_ATTRACTION_FACTOR = 4.3
"""Factor of the estimated attraction around contacts, fitted to 395 computed pairs with E* from 2 MPa to 200 GPa.

docs/explanation/adhesion.md describes the fit.
"""

MAX_DEVIATION_FROM_MU0 = 0.02
# Numbers are multiplied by this factor before rounding: 2.25 then becomes 2.3, as in the report.
ROUND_UP_FACTOR = 1 + 1e-12
MAX_RELATIVE_INTERVAL_HALF_WIDTH = 0.5


@dataclass(frozen=True)
class Caveat:
    """Reason not to quote a coefficient, or to quote it only with care, together with a remedy."""

    text: str
    remedy: str
    severity: Severity
    cut_off: float = math.inf
    """Shortest cutoff wavelength (µm) at which the caveat no longer applies."""
    has_second_cutoff: bool = False
    """True if the interval covers the results with and without the wavelengths that cause the caveat."""
    name: str = ""
    """Name of the number (often a quantity) that exceeds a limit; "" if the caveat has another cause."""
    value: float = field(default=math.nan, compare=False)
    """Number that exceeds the limit, in core units (µm, mN, GPa)."""
    limit: float = field(default=math.nan, compare=False)
    """Limit that the number exceeds."""
    interval_note: str = ""
    """Clause about the interval, which is appended to the text if the coefficient has an interval."""


class LimitCheck(NamedTuple):
    """Check of a quantity against an upper limit; a quantity above the limit gives a caveat with a remedy.

    In the text of the caveat, {} stands for the number named `about`.
    """

    name: str
    limit: float
    text: str
    remedy: str
    severity: Severity = "fault"
    shown: str = "digits"
    about: str = ""  # empty for the checked number

    @property
    def shown_name(self) -> str:
        """Name of the checked quantity in the caveat's text: `about` or, if `about` is empty, `name`."""
        return self.about or self.name

    def to_caveat(self, numbers: Mapping[str, Any]) -> Caveat:
        """Return the caveat of a failed check.

        The text of the caveat contains the number that is compared, or a related number.
        """
        value, checked_number = (float(numbers[name]) for name in (self.shown_name, self.name))
        number_text = format_number(value * ROUND_UP_FACTOR, self.shown).replace("-", "\N{MINUS SIGN}")
        return Caveat(
            self.text.replace("{}", number_text), self.remedy, self.severity, name=self.name, value=checked_number,
            limit=self.limit,
        )  # fmt: skip


# Groups of checks; only the first failed check of each group is reported.
CheckGroups = Sequence[Sequence[LimitCheck]]

ASSESSMENTS_BY_SEVERITY = {"fault": "Do not quote", "caution": "Quote with care", "": "Quote it"}
"""Text of the assessment, by the severity of the worst caveat ("" without caveats)."""

STATUS_EXPLANATIONS = {
    "not-reached": (
        "the load is above the computed loads, or between two computed loads that differ by more than a factor of 10",
        "use a smaller load, or compute larger loads (or approaches)",
    ),
    "below-range": (
        "the load is below the computed loads",
        "use a larger load, or compute smaller loads (or approaches)",
    ),
    "not-solved": ("the half-space solver did not reach its tolerance", "try another load, or the asperity model"),
    "self-locked": ("the slopes are so steep that they resist any tangential load", "check μ0 and τ0"),
    "seizure": (
        "the interface is stronger than the bulk (τ0 is at least H/√α), or its junctions grow over the whole area; "
        "the model has no coefficient",
        "check τ0, the hardness and α; if τ0 is below H/√α, reduce the load",
    ),
    "bulk-shear": (
        "the interface is stronger than the softer body, which shears instead: the coefficient is a lower limit",
        "use the μ0 of a single contact, which is lower than that of whole surfaces, or measure the hardness and τ0",
    ),
    "downhill": (
        "in at least one direction, the upper body slides down the slopes without a tangential load; a mean over "
        "directions has no meaning",
        "use the coefficients of the other directions, or more positions",
    ),
    "no-contact": ("the bodies do not touch", "use a larger load or a larger approach"),
}
"""Meaning of, and remedy for, each status of a result point without a coefficient or without an upper limit."""

WIDE_INTERVAL_CHECK_NAME = "half_width"

SINGLE_POSITION_CHECK = LimitCheck(
    "missing_interval", MAX_AFFECTED_FRACTION, "a gap has one position, so the spread between places is unknown",
    "use gaps at other places as well", "caution",
)  # fmt: skip

STEEP_SURFACE_CHECK = LimitCheck(
    "rms_gradient", 1.0, "the gap has a root-mean-square gradient of {}, too steep for any contact model here",
    "check the units of heights and spacing, or filter the scan",
)  # fmt: skip


def _build_fraction_check(
    name: str, text: str, remedy: str, severity: Severity = "fault", limit: float = MAX_AFFECTED_FRACTION
) -> LimitCheck:
    return LimitCheck(name, limit, text, remedy, severity, "percent")


ASPERITY_CHECKS: CheckGroups = (
    [_build_fraction_check(
        "share_beyond_hertz", "{} of the load is on contacts beyond Hertz theory (overlap above a tenth of the radius)",
        "use a smaller load, or the half-space",
    )],
    [_build_fraction_check(
        "share_below_grid",
        "{} of the load is on contacts with radii below the grid spacing: a finer grid would give another result",
        "use a finer grid, or filter the surfaces",
    )],
)  # fmt: skip

_OVERLAP_CHECK = _build_fraction_check(
    "share_overlapping", "{} of the load is on contacts with overlapping ellipses, which merge", "use the half-space"
)
_EDGE_LOAD_CHECK = _build_fraction_check(
    "share_at_edge", "{} of the load is on contacts at the edge", "use larger maps or a smaller load"
)
LARGEST_CONTACT_LOAD_TEXT = "one contact carries {} of the load"
_MORE_CONTACTS_REMEDY = "use larger surfaces or a higher load"
FEW_CONTACTS_CHECK_NAMES = ("contacts_missing", "share_on_separate")
"""Names of the checks that fail if members have too few contacts on average."""
_FINER_SCAN_REMEDY = "scan more finely, or filter the scan"

COEFFICIENT_EQUALS_MU0_CHECK = LimitCheck(
    "share_of_mu0", 1 - MAX_DEVIATION_FROM_MU0, "τ0 is 0, so the coefficient is the given μ0; the surfaces add {}",
    "give --tau0, or determine both with stiction calibrate", "caution", "digit", "beyond_mu0",
)  # fmt: skip

_COMMON_CONTACT_CHECKS: CheckGroups = (
    [_EDGE_LOAD_CHECK, _EDGE_LOAD_CHECK._replace(limit=MAX_LOAD_FRACTION_AT_EDGE_WITHOUT_CAVEAT, severity="caution")],
    [
        LimitCheck("single_cells", MAX_AFFECTED_FRACTION, "contacts are single grid points", _FINER_SCAN_REMEDY),
        _build_fraction_check(
            "fraction_on_small",
            "{} of the load is on contacts of at most 4 points: a finer scan would give another result",
            _FINER_SCAN_REMEDY, "caution",
        ),
    ],
    *ASPERITY_CHECKS,
    [_OVERLAP_CHECK, _OVERLAP_CHECK._replace(limit=0.1, severity="caution")],
)  # fmt: skip


NO_COEFFICIENT_CAVEAT = Caveat(
    "the load is less than 1 % of the pull-off force, so a coefficient has no meaning",
    "report the pull-off force and the friction at no load, or use a higher load", "fault",
)  # fmt: skip


def _build_value_checks(study: Study) -> Sequence[LimitCheck]:
    """Return the checks of the mean coefficient and of its interval, in order of priority.

    Only the first failed check is reported.
    """
    if study.is_gap:
        return (SINGLE_POSITION_CHECK,)
    members = study.member_names.plural
    are_neighbours = study.is_measured and not study.is_areal
    min_members = MIN_NEIGHBOURING_POSITIONS if are_neighbours else MIN_SAMPLE_SIZE
    return (
        LimitCheck("deficit", 0.0, "the mean coefficient is below 0", "check the units of heights and spacing"),
        LimitCheck(
            "missing_interval", MAX_AFFECTED_FRACTION, "the coefficient has no interval",
            f"an interval requires at least {min_members} different {members}",
        ),
        LimitCheck(
            WIDE_INTERVAL_CHECK_NAME, MAX_RELATIVE_INTERVAL_HALF_WIDTH,
            f"the interval of the mean is wider than ±{100 * MAX_RELATIVE_INTERVAL_HALF_WIDTH:.0f} %",
            f"use more {members}",
        ),
    )  # fmt: skip


def _build_contact_count_checks(study: Study) -> Sequence[LimitCheck]:
    """Return the checks for too few contacts and for a dominant contact, in order of priority.

    Only the first failed check is reported.
    """
    member, members = study.member_names
    total_text = f"all {members} together have fewer than {MIN_TOTAL_CONTACTS} contacts, on average {{}} per {member}"
    total_remedy = f"use a higher load, larger surfaces or more {members}"
    # Two faces that are given by their gap have only one relative position.
    if study.is_gap:
        total_text, total_remedy = f"fewer than {MIN_TOTAL_CONTACTS} contacts in the gap: {{}}", _MORE_CONTACTS_REMEDY
    return (
        LimitCheck("contacts_missing_of_all", 0.0, total_text, total_remedy, about="contact_count"),
        LimitCheck("contacts_missing", 0.0, "too few contacts, {} on average",
              _MORE_CONTACTS_REMEDY, about="contact_count"),
        _build_fraction_check(
            "share_on_separate", LARGEST_CONTACT_LOAD_TEXT, _MORE_CONTACTS_REMEDY, "fault", MAX_LOAD_FRACTION_ON_CONTACT
        ),
        LimitCheck("contacts_wanting", 0.0, "few contacts, {} on average",
              _MORE_CONTACTS_REMEDY, "caution", about="contact_count"),
        _build_fraction_check(
            "share_on_largest", LARGEST_CONTACT_LOAD_TEXT, _MORE_CONTACTS_REMEDY, "caution",
            MAX_LOAD_FRACTION_ON_CONTACT_WITHOUT_CAVEAT,
        ),
    )  # fmt: skip


def _build_contact_checks(study: Study) -> CheckGroups:
    """Return groups of checks that give caveats about contacts; the first group checks the pull-off force."""
    text = "the pull-off force is a lower bound"
    if not study.is_gap:
        text += f": {{}} of the {study.member_names.plural} have only a bound"
    remedy = "call half_space to see the reason as a warning"
    pull_off_check = _build_fraction_check("share_of_pull_off_bounds", text, remedy, "caution", 0.0)
    return ([pull_off_check], *_COMMON_CONTACT_CHECKS)


def _build_status_caveat(status: str, study: Study) -> Caveat:
    """Return the caveat that explains why a coefficient is missing, or why a coefficient has no upper limit."""
    other_explanation = "there is no coefficient", f"check how many {study.member_names.plural} have a coefficient"
    text, remedy = STATUS_EXPLANATIONS.get(status, other_explanation)
    if status == friction.STATUS_BULK_SHEAR:
        remedy += _growth_remedy_for_unnamed_materials(study)
    return Caveat(text, remedy, "fault")


def _growth_remedy_for_unnamed_materials(study: Study) -> str:
    """Return advice on junction growth if the bodies may be brittle; empty if the study names their materials.

    Slip-line theory does not hold for brittle materials.
    """
    return "" if find_materials(study) else "; for rock, glass or ceramics, use --junction-growth 0"


def find_point_caveats(
    point: xarray.Dataset, study: Study, value: SlidingRuleCoefficient, status: str
) -> Iterator[Caveat]:
    """Yield caveats about the status, the coefficient and the contacts at one load, one mu0 and one tau0."""
    contact_checks = _build_contact_checks(study)
    if is_unloaded(point):
        yield NO_COEFFICIENT_CAVEAT
        yield from _find_adhesion_caveats(point, study)
        yield from _find_grid_caveats(point, study)
        yield from find_caveats_of_failed_checks(contact_checks, _compute_checked_numbers(point, study, value))
        return
    if status == friction.STATUS_BULK_SHEAR:
        yield _build_status_caveat(status, study)
    elif status != friction.STATUS_OK or math.isnan(value.value):
        yield _build_status_caveat(status, study)
        yield from find_caveats_of_failed_checks(
            ([STEEP_SURFACE_CHECK],), _compute_checked_numbers(point, study, value)
        )
        return
    num_members = mean_over_directions(point, "members")
    num_solved = float(point["ok"].min()) if "ok" in point else math.nan
    if num_solved < MAX_AFFECTED_FRACTION * num_members:
        text = f"only {num_solved:.0f} of {study.member_names.with_count(num_members)} have a coefficient"
        yield Caveat(text, "check the statuses, and try another load", "fault")
    numbers = _compute_checked_numbers(point, study, value)
    pressure_checks = build_pressure_checks(study, effective_modulus_at(point, study))
    yield from find_caveats_of_failed_checks(
        (_build_value_checks(study), [STEEP_SURFACE_CHECK], *pressure_checks), numbers
    )
    yield from _find_growth_caveats(point, study, status)
    yield from _find_size_effect_caveats(point, study, value)
    yield from _find_area_loss_caveats(point, study, value)
    yield from find_caveats_of_failed_checks(([COEFFICIENT_EQUALS_MU0_CHECK],), numbers)
    yield from _find_adhesion_caveats(point, study)
    yield from _find_grid_caveats(point, study)
    yield from _find_drift_caveats(point, study, value)
    yield from _find_orientation_caveats(point, study)
    yield from _find_area_caveats(point, study)
    yield from find_caveats_of_failed_checks((_build_contact_count_checks(study), *contact_checks), numbers)


def find_smallest_check_limit(name: str, study: Study) -> float | None:
    """Return the lowest limit above which the quantity `name` gives a caveat about the contacts.

    Returns None if no check compares this quantity.
    """
    check_groups = (_build_contact_count_checks(study), *_build_contact_checks(study))
    return min((check.limit for group in check_groups for check in group if check.name == name), default=None)


def find_caveats_of_failed_checks(checks: CheckGroups, numbers: Mapping[str, Any]) -> Iterator[Caveat]:
    """Yield the caveat of the first failed check in each group; groups without a failed check yield no caveat.

    A check passes if the number that it compares is missing.
    """
    for group in checks:
        failed = (check for check in group if numbers.get(check.name, math.nan) > check.limit)
        yield from (check.to_caveat(numbers) for check in itertools.islice(failed, 1))


def compute_checked_quantities(
    value: ArrayLike, lower: ArrayLike, upper: ArrayLike, *, mu0: ArrayLike, tau0: ArrayLike, pressure: ArrayLike,
    contact_count: ArrayLike, members: float, is_merged: ArrayLike,
) -> dict[str, Any]:  # fmt: skip
    """Compute the quantities that give a caveat if they exceed a limit: one array per quantity, keyed by name.

    `is_merged` is True where contacts have merged over much of the nominal area. Merged contacts are few, but each
    merged contact averages over many asperities.
    """
    value, lower, upper, mu0, count = (np.asarray(array, float) for array in (value, lower, upper, mu0, contact_count))
    separate_contacts = np.where(is_merged, np.nan, count)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio_to_mu0 = np.where(value == mu0, 1.0, np.where(mu0 > 0, value / mu0, np.nan))
        ratio_to_mu0 = np.where(np.asarray(tau0) == 0, ratio_to_mu0, np.nan)
        half_width = (upper - lower) / (2 * value)
    return {
        "deficit": -value,
        "missing_interval": (np.isnan(lower) | np.isnan(upper)).astype(float),
        WIDE_INTERVAL_CHECK_NAME: half_width,
        "mean_pressure": pressure,
        "contact_count": count,
        "contacts_missing_of_all": MIN_TOTAL_CONTACTS - count * members,
        "contacts_missing": MIN_CONTACTS_PER_MEMBER - separate_contacts,
        "contacts_wanting": MIN_CONTACTS_PER_MEMBER_WITHOUT_CAVEAT - separate_contacts,
        "share_of_mu0": 1 - np.abs(ratio_to_mu0 - 1),
        "beyond_mu0": value - mu0,
    }


def list_contact_check_names(study: Study) -> list[str]:
    """Return the names of all quantities that can give a caveat about contacts or about the rms gradient."""
    check_groups = ([STEEP_SURFACE_CHECK], _build_contact_count_checks(study), *_build_contact_checks(study))
    return list(dict.fromkeys(check.name for group in check_groups for check in group))


def _compute_checked_numbers(point: xarray.Dataset, study: Study, value: SlidingRuleCoefficient) -> dict[str, Any]:
    area, count = mean_over_directions(point, "contact_area"), mean_over_directions(point, "contact_count")
    spacings = np.atleast_1d(point.attrs.get("spacing_um", math.nan)).astype(float)
    cell_area = float(np.prod(spacings)) if spacings.size == 2 and study.uses_half_space else math.nan
    quantities = {name: mean_over_directions(point, name) for name in list_contact_check_names(study)}
    is_merged = _compute_area_fraction(point, study) > MIN_MERGED_AREA_FRACTION
    num_members = float(point["ok"].min()) if "ok" in point else mean_over_directions(point, "members")
    numbers = compute_checked_quantities(
        value.value, value.lower, value.upper, mu0=read_number(point, "mu0"), tau0=read_number(point, "tau0"),
        pressure=mean_contact_pressure(point), contact_count=count, members=num_members, is_merged=is_merged,
    )  # fmt: skip
    return (
        quantities
        | numbers
        | {
            "share_on_separate": math.nan if is_merged else quantities["share_on_largest"],
            "single_cells": float(count > 0 and area / count <= cell_area),
        }
    )


def build_pressure_checks(study: Study, modulus: float) -> CheckGroups:
    """Return the checks that give a caveat if the mean contact pressure exceeds the pressure of yielding.

    The limits are the hardness of the softer body or, without a hardness, typical fractions of E*. Returns no checks if
    the contact model limits the pressure, or if the effective modulus (GPa) is so small that the bodies are probably
    rubber or gels.
    """
    if has_limited_pressure(study):
        return ()

    def build_pressure_check(limit: float, text: str, remedy: str, severity: Severity) -> LimitCheck:
        return LimitCheck("mean_pressure", limit, text, remedy, severity, "GPa")

    softer_material = softest_material(*find_materials(study))
    if softer_material is not None and softer_material.hardness is not None:
        smallest_hardness, largest_hardness = softer_material.hardness.low, softer_material.hardness.high
        range_text = " to ".join(
            dict.fromkeys(format_with_unit(end, "GPa") for end in (smallest_hardness, largest_hardness))
        )
        text = f"the mean pressure in contact is {{}}, and {softer_material.name} yields at {range_text}"
        remedy = "use --mechanics half-space or --law jackson-green"
        return (
            (
                build_pressure_check(largest_hardness, text, remedy, "fault"),
                build_pressure_check(smallest_hardness, text, remedy, "caution"),
            ),
        )
    if modulus < MAX_RUBBER_MODULUS:
        return ()
    yield_limit, metal_yield_limit = YIELD_PRESSURE_RATIO * modulus, METAL_YIELD_PRESSURE_RATIO * modulus
    if study.is_measured:
        yielded_text = "the mean pressure in contact is {}, at which nearly every material has yielded"
        hardness_text = "the result is valid only if the softer body is harder than {}, the mean pressure in contact"
        remedy = "give the hardness of the softer body"
        # In the asperity model, contacts yield only under the contact law of Jackson and Green.
        if not study.uses_half_space:
            remedy += " with --mechanics half-space, or with --law jackson-green"
        return (
            (
                build_pressure_check(yield_limit, yielded_text, remedy, "fault"),
                build_pressure_check(metal_yield_limit, hardness_text, remedy, "caution"),
            ),
        )
    text = "the mean pressure in contact is {}, at which almost no material is still elastic"
    yielding = "a hardness" if study.uses_half_space else "the contact law jackson-green"
    return ((build_pressure_check(yield_limit, text, f"use lower heights, a lower D, or {yielding}", "caution"),),)


def assess_ensemble_points(
    study: Study, status: NDArray[Any], numbers: Mapping[str, Any], unloaded_mask: NDArray[np.bool_]
) -> tuple[list[list[Caveat | LimitCheck]], NDArray[np.intp]]:
    """Return caveats and failed checks at each load, mu0, tau0 and roughness in a study of generated surfaces.

    For a single direction of motion, the reasons are the caveats of `find_point_caveats`. For several directions, each
    direction is assessed, whereas `find_point_caveats` assesses their mean. The arrays have equal shapes;
    `unloaded_mask` is True where the load is negligible compared with the pull-off force. Returns the distinct lists of
    reasons, with faults first, and the index of the list for each result point. A reason is a failed check, or a caveat
    for a status.
    """
    reasons: list[Caveat | LimitCheck] = []
    reason_numbers = []

    def add_caveat(caveat: Caveat, mask: NDArray[np.bool_]) -> None:
        if mask.any():
            reasons.append(caveat)
            reason_numbers.append(np.where(mask, len(reasons), 0))

    def add_failed_checks(check_groups: CheckGroups, is_checked: NDArray[np.bool_]) -> None:
        for group in check_groups:
            indices = np.zeros(status.shape, np.intp)
            for check in (check for check in group if check.name in numbers):
                mask = is_checked & (indices == 0) & (numbers[check.name] > check.limit)
                if mask.any():
                    reasons.append(check)
                    indices[mask] = len(reasons)
            reason_numbers.append(indices)

    add_caveat(NO_COEFFICIENT_CAVEAT, unloaded_mask)
    has_value = (status == friction.STATUS_OK) & np.isfinite(numbers["deficit"]) & ~unloaded_mask
    has_no_value = ~has_value & ~unloaded_mask
    for name in np.unique(np.where(has_no_value, status, friction.STATUS_OK)).tolist():
        add_caveat(_build_status_caveat(name, study), has_no_value & (status == name))
    pressure_checks = build_pressure_checks(study, float(study.contact.effective_modulus))
    value_checks = (_build_value_checks(study), *pressure_checks, [COEFFICIENT_EQUALS_MU0_CHECK])
    add_failed_checks((*value_checks, _build_contact_count_checks(study)), has_value)
    add_failed_checks(_build_contact_checks(study), has_value | unloaded_mask)
    # Each combination of caveats is encoded as an integer: integers are sorted much faster than rows of an array.
    codes = np.zeros(status.shape, np.intp)
    for indices in reason_numbers:
        codes = codes * (len(reasons) + 1) + indices
    _, first_points, set_indices = np.unique(codes, return_index=True, return_inverse=True)
    rows = np.stack([indices.ravel()[first_points] for indices in reason_numbers], axis=-1)
    reason_sets = [[reasons[index - 1] for index in row if index] for row in rows.tolist()]
    return [sorted(row, key=lambda reason: reason.severity != "fault") for row in reason_sets], set_indices.reshape(
        status.shape
    )


def assess_caveats(reasons: Iterable[Caveat | LimitCheck]) -> str:
    """Return the assessment, such as "Quote it", that follows from the most severe caveat or failed check."""
    severities = {reason.severity for reason in reasons}
    return ASSESSMENTS_BY_SEVERITY["fault" if "fault" in severities else "caution" if severities else ""]


def _find_growth_caveats(point: xarray.Dataset, study: Study, status: str) -> Iterator[Caveat]:
    """Yield caveats if junction growth is neglected, differs from that in the tests, or makes friction unlimited."""
    hardness = study.contact.hardness
    if hardness is None or not (mean_over_directions(point, "load_share_at_hardness") > MIN_LOAD_FRACTION_AT_HARDNESS):
        return
    growth = Inputs.from_study(study).estimate("junction_growth")
    interface = study.friction.interface
    test_growth = None if interface is None else interface.find_junction_growth()
    if test_growth is not None and not has_growth_of_tests(growth, test_growth):
        growth_text, test_text = (
            "0" if estimate is None else estimate.short_text for estimate in (growth, test_growth)
        )
        text = f"the interface was calibrated with junction growth {test_text}, but the pair has {growth_text}"
        yield Caveat(text, "give the calibration and the pair the same --junction-growth", "caution")
    law = Inputs.from_study(study).friction_law(read_number(point, "mu0"), read_number(point, "tau0"))
    if growth is not None:
        if status != friction.STATUS_BULK_SHEAR:
            yield from _find_caveats_about_unlimited_friction(point, study, law, growth)
        return
    effect = law.growth_effect(float(hardness))
    if study.contact.junction_growth is not None or abs(effect) <= NEGLIGIBLE_GROWTH_EFFECT:
        return
    slip_lines = replace(law, junction_growth=friction.CENTRAL_SHEAR_RATIO, uses_slip_lines=True)
    effect_text = (
        f"would raise the friction of plastic contacts by up to {format_percent(effect)}"
        if not slip_lines.is_stronger_than_body(float(hardness))
        else "has no upper limit, because the interface is stronger than that body"
    )
    text = (
        f"τ0 is {format_percent(float(slip_lines.bulk_strength_ratio(hardness)))} of the shear strength of the softer "
        f"body; junction growth, which is taken as 0, {effect_text}"
    )
    remedy = "use --junction-growth slip-line"
    # In the model, adhesive contacts do not grow under shear.
    if study.contact.adheres:
        remedy = "compare with the pair without --adhesion, whose contacts grow"
    yield Caveat(text, remedy, "caution")


def _is_metal(point: xarray.Dataset, study: Study) -> bool:
    """Return whether the softer body is a metal; an unnamed material with a high E* counts as a metal."""
    softer_material = softest_material(*find_materials(study))
    if softer_material is None:
        return effective_modulus_at(point, study) > MIN_METAL_MODULUS
    return softer_material.kind == "metal"


def _is_very_hard_metal(point: xarray.Dataset, study: Study) -> bool:
    """Return whether a metal is so hard, relative to E*, that its size effect is smaller than assumed."""
    return effective_modulus_at(point, study) < MIN_MODULUS_TO_HARDNESS_RATIO * get_study_hardness(study)


class SizeEffect(NamedTuple):
    """Indentation size effect (harder small contacts) that a study neglects, estimated with a typical length h*.

    Attributes
    ----------
    depth : float, µm
        Depth of the indentation that corresponds to the contacts.
    load_share_at_hardness : float
        Fraction of the load on contacts that yield.
    """

    depth: float
    load_share_at_hardness: float

    @property
    def hardness_ratio(self) -> float:
        """Hardness of the contacts divided by the hardness of large indentations."""
        return float(size_effect_factor(TYPICAL_SIZE_EFFECT_LENGTH, self.depth))

    @property
    def area_reduction(self) -> float:
        """Relative reduction of the true area through the size effect."""
        return self.load_share_at_hardness * (1 - 1 / self.hardness_ratio)

    @property
    def hardness_text(self) -> str:
        """Text that compares the hardness of small and large contacts, such as "2.2 times as hard as large ones"."""
        ratio = self.hardness_ratio
        if ratio < MIN_HARDNESS_RATIO_IN_TEXT:
            return f"{format_percent(ratio - 1)} harder than large ones"
        return f"{ratio:.1f} times as hard as large ones"

    def at_load_ratio(self, load_ratio: float) -> SizeEffect:
        """Estimate the size effect at another load, given the ratio of the other load to the present load.

        The number of contacts and the fraction of the load on contacts that yield are taken as constant. The true area
        is then proportional to the load, so that the depth is proportional to the square root of the load.
        """
        return self._replace(depth=self.depth * math.sqrt(load_ratio))


def estimate_size_effect(point: xarray.Dataset, study: Study) -> SizeEffect | None:
    """Estimate how much harder small metal contacts are than a hardness test of unknown depth indicates.

    Returns None if the contacts have no size effect, or if the study includes it.
    """
    if study.contact.yield_exponent is None or study.contact.indent is not None:
        return None
    if not _is_metal(point, study) or _is_very_hard_metal(point, study):
        return None
    names = ("contact_area", "contact_count", "rms_gradient", "load_share_at_hardness")
    area, count, slope, plastic_fraction = (mean_over_directions(point, name) for name in names)
    depth = float(estimate_indentation_depth(area, count, slope, are_lines=not study.is_areal))
    return SizeEffect(depth, plastic_fraction)


def _find_size_effect_caveats(point: xarray.Dataset, study: Study, value: SlidingRuleCoefficient) -> Iterator[Caveat]:
    """Yield a caveat if the hardness of small metal contacts may differ from the hardness that the study assumes."""
    if (
        study.contact.yield_exponent is not None and study.contact.indent is not None
        and _is_metal(point, study) and _is_very_hard_metal(point, study)
    ):  # fmt: skip
        text = (
            f"metals as hard as {format_with_unit(get_study_hardness(study), 'GPa')} have a smaller indentation size "
            "effect than assumed, so the contacts are computed too hard"
        )
        yield Caveat(text, "leave out the depth of the indentation", "caution")
    size_effect = estimate_size_effect(point, study)
    if size_effect is None:
        return
    area = mean_over_directions(point, "contact_area")
    law = Inputs.from_study(study).friction_law(0.0, read_number(point, "tau0"))
    _, adhesive = law.contributions(0.0, area / read_number(point, "load"))
    # The ratio to a coefficient of 0 is undefined. A coefficient that is only a lower limit may be below tau0 A/F.
    adhesive_share = min(adhesive / value.value, 1.0) if adhesive > 0 else 0.0
    if loads := _find_loads_of_tested_pair(study):
        yield from _find_size_effect_change(point, study, size_effect, adhesive_share, loads)
        return
    effect = size_effect.area_reduction * adhesive_share
    if not effect > NEGLIGIBLE_GROWTH_EFFECT:
        return
    text = (
        f"small contacts of metals are harder: like indentations {format_with_unit(size_effect.depth, 'um')} deep, "
        f"they may be {size_effect.hardness_text}, and the coefficient {format_percent(effect)} lower"
    )
    yield Caveat(text, "give the depth of the indentation with --indent", "caution")


def _find_loads_of_tested_pair(study: Study) -> tuple[float, ...]:
    """Return the lowest and the highest load (mN) of the friction tests if all of them tested this very pair.

    Returns an empty tuple for other interfaces, and for interface files without these loads. The pair must have been
    tested with the same hardness and without a depth of its indentation, as `is_tested_pair` ensures. A ball would have
    another true area per load than a pair whose contacts yield.
    """
    strength = Inputs.from_study(study).strength
    if strength is None or not (is_tested_pair(study, strength) and strength.variation < MIN_AREA_VARIATION):
        return ()
    return strength.tested_loads


def _find_size_effect_change(
    point: xarray.Dataset, study: Study, size_effect: SizeEffect, adhesive_share: float, loads: Sequence[float]
) -> Iterator[Caveat]:
    """Yield a caveat if the size effect at a load differs from the size effect in the friction tests of this pair.

    If the true area is too large by a factor in the tests, the fitted tau0 is too small by this factor. The size effect
    therefore cancels if the factor is the same at the result point. `loads` are the lowest and the highest load (mN) of
    the tests, and `adhesive_share` is the share of tau0 in the coefficient.
    """
    load = read_number(point, "load")
    area_changes = (
        (1 - size_effect.area_reduction) / (1 - size_effect.at_load_ratio(tested_load / load).area_reduction) - 1
        for tested_load in loads
    )
    change = adhesive_share * max(area_changes, key=abs)
    if not abs(change) > NEGLIGIBLE_GROWTH_EFFECT:
        return
    pressure_per_load = nominal_pressure_at(point, study) / load
    load_texts = dict.fromkeys(format_load(tested_load, tested_load * pressure_per_load) for tested_load in loads)
    text = (
        "small contacts of metals are harder; this effect depends on the load and cancels only near the load of the "
        f"tests ({' to '.join(load_texts)}), so the coefficient may be too {'low' if change > 0 else 'high'}"
    )
    yield Caveat(text, "give --indent for the tests and for the pair, and run stiction calibrate again", "caution")


def _find_area_loss_caveats(point: xarray.Dataset, study: Study, value: SlidingRuleCoefficient) -> Iterator[Caveat]:
    """Yield a caveat if contacts of soft bodies may lose area under shear, which would lower the coefficient."""
    contact = study.contact
    is_soft = contact.hardness is None and effective_modulus_at(point, study) < MAX_RUBBER_MODULUS
    if not (study.is_measured and is_soft) or contact.area_loss is not None:
        return
    max_loss = parse_input_value("area_loss", ELASTOMER_AREA_LOSS).estimate.high
    _, adhesive = (
        Inputs.from_study(study)
        .friction_law(0.0, read_number(point, "tau0"))
        .contributions(0.0, mean_over_directions(point, "contact_area") / read_number(point, "load"))
    )
    effect = max_loss * adhesive / value.value if adhesive > 0 else 0.0
    if effect <= NEGLIGIBLE_GROWTH_EFFECT:
        return
    text = (
        f"elastomers lose up to {format_percent(max_loss)} of their true area under shear, and the loss is taken as 0; "
        f"the coefficient may be up to {format_percent(effect)} lower"
    )
    option_text = "" if study.uses_half_space else "--mechanics half-space and "
    yield Caveat(text, f"use {option_text}--area-loss {ELASTOMER_AREA_LOSS}", "caution")


def _find_caveats_about_unlimited_friction(
    point: xarray.Dataset, study: Study, law: friction.FrictionLaw, growth: UncertainInput
) -> Iterator[Caveat]:
    """Yield a caveat if friction is unlimited for some input samples, or if τ0 is close to the bulk shear strength."""
    law = replace(law, junction_growth=growth.high, uses_slip_lines=growth.uses_slip_lines)
    strength_ratio = float(law.bulk_strength_ratio(get_contact_hardness(point, study)))
    unlimited_fraction = mean_over_directions(point, "fraction_unlimited")
    if unlimited_fraction > MIN_FRACTION_OF_SAMPLES_WITHOUT_FRICTION_LIMIT:
        text = (
            f"for {format_percent(unlimited_fraction)} of the samples of the inputs, the interface is stronger than "
            f"the softer body{'' if growth.uses_slip_lines else ' or its junctions grow over the whole area'}"
            + (
                "; the interval has no upper limit"
                if unlimited_fraction > MAX_FRACTION_OF_SAMPLES_WITHOUT_FRICTION_LIMIT
                else ""
            )
        )
        severity: Severity = (
            "fault" if unlimited_fraction > MAX_FRACTION_OF_SAMPLES_WITHOUT_FRICTION_LIMIT else "caution"
        )
        # Under a smaller load, contacts would yield at the same pressure, but not cover the whole nominal area.
        is_load_limited = not growth.uses_slip_lines and strength_ratio < 1
        remedy = "measure the hardness, and determine μ0 and τ0 with stiction calibrate"
        if growth.uses_slip_lines:
            remedy += _growth_remedy_for_unnamed_materials(study)
        yield Caveat(text, remedy + (", or reduce the load" if is_load_limited else ""), severity)
    elif not growth.uses_slip_lines and strength_ratio > MIN_STRENGTH_RATIO_NEAR_BULK:
        text = (
            f"the interface is nearly as strong as the bulk: τ0 is {strength_ratio:.2f} of H/√α at α = {growth.high:g}"
        )
        yield Caveat(
            text, "friction rises without limit as this ratio approaches 1; measure the hardness and τ0", "caution"
        )


def _find_adhesion_caveats(point: xarray.Dataset, study: Study) -> Iterator[Caveat]:
    """Yield caveats if adhesion is neglected, if its range is unresolved, or if intervals omit its uncertainty."""
    if not study.contact.adheres:
        added_load = estimate_adhesion_load_ratio(point, study)
        # The asperity model always neglects adhesion, so it gets a caveat only if adhesion would double the load.
        min_added_load = MAX_NEGLECTED_ADHESION_FRACTION if study.uses_half_space else 1.0
        if study.is_measured and study.contact.work_of_adhesion is None and added_load > min_added_load:
            added_text = f"about {100 * added_load:.2g} %" if added_load < 1 else "more than 100 %"
            work_text = f"{1e6 * TYPICAL_WORK_OF_ADHESION:g} mJ/m²"
            text = f"adhesion of {work_text} would increase the load on the contacts by {added_text}"
            option_text = "" if study.uses_half_space else "--mechanics half-space and "
            yield Caveat(text, f"specify {option_text}--adhesion ('0 mJ/m^2' if there is none)", "caution")
        return
    adhesion_range_of_study, used_range = get_adhesion_ranges(point, study)
    if used_range > adhesion_range_of_study:
        text = (
            f"the range of adhesion is {format_with_unit(used_range, 'um')} instead of "
            f"{format_with_unit(adhesion_range_of_study, 'um')}, because this grid resolves no smaller range"
        )
        yield Caveat(text, "the pull-off force changes little; use a finer scan for other results", "caution")
    uncertain_inputs = {name.split("_")[0] for name in Inputs.from_study(study).uncertain} & {
        "hardness",
        "effective",
        "young",
        "poisson",
    }
    if uncertain_inputs and mean_over_directions(point, "contact_load") > (1 + MAX_NEGLECTED_ADHESION_FRACTION) * float(
        point["load"]
    ):
        input_text = (
            "the hardness"
            if uncertain_inputs == {"hardness"}
            else "E*"
            if "hardness" not in uncertain_inputs
            else "E* and the hardness"
        )
        text = f"the interval does not include the effect of {input_text} on the attraction"
        yield Caveat(text, "compute the pair at both limits of the ranges", "caution")


def estimate_adhesion_load_ratio(point: xarray.Dataset, study: Study) -> float:
    """Estimate the load that adhesion would add to the contacts, as a ratio to the applied load.

    The work of adhesion is a typical one.

    The attraction per area w/ρ acts on the true area A, and on a rim around contacts of width d = (A/n)^(1/2) in which
    the gap is below the range ρ. The gap opens as in Pastewka & Robbins (PNAS 111 (2014) 3298), so that the ratio is
    (w/ρ) (A/F) (1 + 4.3 u^(2/3)) with u = ρ/(h' d), where ρ is the range that the grid resolves. With A = κF/(E* h'), s
    = w/(E* h'² d) and Tabor's parameter μ of asperities of radius d/h', the ratio equals κ μ s^(1/3) (1 + 4.3
    (s^(2/3)/μ)^(2/3)).
    """
    area, count, slope = (
        mean_over_directions(point, name) for name in ("contact_area", "contact_count", "rms_gradient")
    )
    if not (area > 0 and count > 0 and slope > 0):
        return math.nan
    spacing = float(np.max(point.attrs.get("spacing_um", 0.0)))
    attraction_range = max(
        DEFAULT_ADHESION_RANGE,
        min_resolved_adhesion_range(TYPICAL_WORK_OF_ADHESION, spacing, effective_modulus_at(point, study)),
    )
    # Contacts of profiles are strips with an assumed width of 1 µm.
    are_strips = has_nominal_area(point, study) and not study.is_areal
    contact_width = area / count if are_strips else math.sqrt(area / count)
    rim_factor = RIM_ATTRACTION_FACTOR * (attraction_range / (slope * contact_width)) ** (2 / 3)
    return float(TYPICAL_WORK_OF_ADHESION / attraction_range / mean_contact_pressure(point) * (1 + rim_factor))


def _find_grid_caveats(point: xarray.Dataset, study: Study) -> Iterator[Caveat]:
    body_sides = ("upper", "lower")
    if not all(f"{side}_spacing_um" in point.attrs for side in body_sides):
        return
    spacings = [float(np.max(point.attrs[f"{side}_spacing_um"])) for side in body_sides]
    coarser_body, finer_body = (body_sides[spacings.index(select(spacings))] for select in (max, min))
    if max(spacings) > MAX_SPACING_RATIO_OF_TWO_BODIES * min(spacings):
        ratio_text = format_significant(max(spacings) / min(spacings), 2)
        text = (
            f"the {coarser_body} scan is {ratio_text} times coarser than the {finer_body}, "
            "so it lacks short wavelengths"
        )
        yield Caveat(text, "scan both bodies with similar spacings", "caution")
    count = mean_over_directions(point, "contact_count")
    mean_contact_area = mean_over_directions(point, "contact_area") / count if count > 0 else math.nan
    # A given gap is a single map or profile, whose points are checked instead of the points of two bodies.
    for side, name in [("upper", "gap")] if study.is_gap else zip(body_sides, body_sides, strict=True):
        interpolated_fraction, largest_gap = np.asarray(point.attrs.get(f"{side}_filled", (0.0, 0.0))).tolist()
        if interpolated_fraction > MAX_INTERPOLATED_POINT_FRACTION or largest_gap > mean_contact_area:
            text = f"{name}: {format_percent(interpolated_fraction)} of the points are interpolated"
            if largest_gap > mean_contact_area:
                text += (
                    f", in gaps larger than the contacts, up to {largest_gap:.3g} {'µm²' if study.is_areal else 'µm'}"
                )
            yield Caveat(
                text, "use --missing mask to press measured points only, or --crop to a complete region", "caution"
            )
    missing_fraction = 1.0 - math.prod(
        1 - float(np.max(point.attrs.get(f"{side}_pierced", 0.0)))
        for side in (("upper",) if study.is_gap else body_sides)
    )
    if missing_fraction > MAX_SCATTERED_MISSING_FRACTION:
        text = (
            f"{format_percent(missing_fraction)} of the points are missing between measured points, so contacts have "
            f"holes: the true area may be up to {format_percent(MAX_AREA_LOSS_PER_HOLE * missing_fraction)} too small"
        )
        yield Caveat(text, "use --missing interpolate, or a scan with fewer missing points", "caution")
    if study.surfaces.press == "surrogates":
        piece_length = float(np.max(np.multiply(point.attrs["shape"], point.attrs["spacing_um"])))
        scan_length = max(float(np.max(point.attrs[f"{side}_extent_um"])) for side in body_sides)
        if piece_length < MAX_AFFECTED_FRACTION * scan_length:
            length_text = format_with_unit(piece_length, "um")
            text = f"pieces of {length_text} are pressed, without the longer wavelengths of the scan"
            remedy = "omit --lay isotropic if the faces have grooves, and use height maps if they have none"
            yield Caveat(f"{text} of {format_with_unit(scan_length, 'um')}", remedy, "caution")


def _find_drift_caveats(point: xarray.Dataset, study: Study, value: SlidingRuleCoefficient) -> Iterator[Caveat]:
    """Yield a caveat for each body with only one scan, if roughness changes along the scan enough to affect friction.

    The coefficient minus mu0 is inversely proportional to the slope, unless the hardness limits the pressures.
    """
    elastic_fraction = 1.0
    if study.contact.hardness is not None:
        elastic_fraction = 1 - mean_over_directions(point, "load_share_at_hardness")
    sensitivity = elastic_fraction * (value.value - read_number(point, "mu0")) / value.value if value.value > 0 else 0.0
    for side in ("upper", "lower"):
        drift, fraction = np.asarray(point.attrs.get(f"{side}_drift", (0.0, 0.0))).tolist()
        if drift * fraction * sensitivity > MAX_DRIFT_ERROR_WITHOUT_CAVEAT:
            factor = format_significant(math.exp(drift), 2)
            text = (
                f"{side}: the rms slope changes by a factor of {factor} from one end of the scan to the other, so "
                "another place on the part may differ as much"
            ) + ("; the interval includes this" if math.isfinite(value.lower) else "")
            yield Caveat(text, "scan several places on the part", "caution")


def _find_orientation_caveats(point: xarray.Dataset, study: Study) -> Iterator[Caveat]:
    """Yield a caveat if both maps have a lay, but the study specifies neither a rotation nor positions of the maps.

    Maps with a lay are pressed at several relative positions, but in one orientation.
    """
    surfaces: Any = study.surfaces
    ratios = [float(np.max(point.attrs[name])) for name in ("upper_lay", "lower_lay") if name in point.attrs]
    if len(ratios) == 2 and not (surfaces.rotate or surfaces.positions):
        text = f"one orientation of the lays (slope ratio {format_significant(min(ratios), 2)}) is pressed"
        yield Caveat(text, "try --rotate 180", "caution")


LOAD_FRACTION_OF_OPPOSING_CONTACTS = 0.5
"""Fraction of the load on contacts that oppose the motion, for surfaces with small slopes."""


MAX_NEGLECTED_LAY_EFFECT = 0.02
"""Largest relative change of a coefficient with the lay that is neglected."""


def find_lay_caveats(
    study: Study, rules: Sequence[SlidingRuleCoefficient], roughness_contribution: float | None
) -> Iterator[Caveat]:
    """Yield a caveat if a lay is assumed for two profiles and another lay may change a reported coefficient.

    `rules` are the reported coefficients, one for each sliding rule, and `roughness_contribution` is the contribution
    of roughness to the coefficient if friction acts at all contacts. The lay only changes this contribution: without
    it, the coefficient for opposing contacts only is half of the coefficient for all contacts. If grooves are assumed,
    the true area without grooves is smaller, and each coefficient lies between its value without and with the
    contribution of roughness. There is no caveat if all intervals contain the coefficients without this contribution,
    or if these coefficients differ from the reported ones by at most `MAX_NEGLECTED_LAY_EFFECT`.
    If spherical asperities are assumed, another lay may change a coefficient in either direction, and the interval must
    also contain the coefficient with twice this contribution.
    """
    if not getattr(study.surfaces, "lay_assumed", None) or not _is_coefficient(rules[0]):
        return
    are_grooves_assumed = has_grooves(study)
    text = f"the lay is assumed: {'parallel grooves' if are_grooves_assumed else 'spherical asperities'} on both faces"
    if roughness_contribution is not None:
        (value,) = (rule.value for rule in rules if rule.rule == "all")
        lowest_by_rule = {"all": value - roughness_contribution}
        lowest_by_rule["opposing"] = LOAD_FRACTION_OF_OPPOSING_CONTACTS * lowest_by_rule["all"]
        change_texts = []
        for rule, name in zip(rules, ("the coefficient", "the second coefficient"), strict=False):
            lowest = lowest_by_rule[rule.rule]
            limits = [lowest, *([] if are_grooves_assumed else [2 * rule.value - lowest])]
            is_excluded = not all(rule.lower <= limit <= rule.upper for limit in limits)
            if _is_coefficient(rule) and is_excluded and rule.value - lowest > MAX_NEGLECTED_LAY_EFFECT * rule.value:
                change_texts.append(f"{name} may be anything down to {lowest:.3f}")
        if not change_texts:
            return
        if are_grooves_assumed:
            text += f"; with another lay, {' and '.join(change_texts)}"
    yield Caveat(text, "specify --lay grooves or, for faces without grooves, --lay isotropic", "caution")


def _is_coefficient(rule: SlidingRuleCoefficient) -> bool:
    """Return whether the coefficient under a sliding rule is known: neither NaN, nor only a lower limit."""
    return not math.isnan(rule.value) and rule.status != friction.STATUS_BULK_SHEAR


MIN_YIELDING_PRESSURE_FRACTION = 0.45
"""Ratio of mean pressure to hardness above which yielding below the surface adds some per cent of area."""


def _find_area_caveats(point: xarray.Dataset, study: Study) -> Iterator[Caveat]:
    status = find_contact_status(point, study)
    if status == FULL_CONTACT_STATUS:
        remedy = (
            "adhesion closes the gap: use stiffer or rougher bodies" if study.contact.adheres else "use a smaller load"
        )
        yield Caveat("contact is complete: the true area equals the nominal area", remedy, "fault")
    elif status == AREA_ABOVE_NOMINAL_STATUS:
        text = "the areas of the asperities add up to more than the nominal area"
        yield Caveat(text, "use a smaller load, or the half-space", "fault")
    elif (
        study.is_measured
        and study.contact.hardness is not None
        and study.contact.yield_exponent is None
        and mean_contact_pressure(point) > MIN_YIELDING_PRESSURE_FRACTION * float(study.contact.hardness)
    ):
        text = "the true area is up to 30 % too small, because yielding below the surface is neglected"
        yield Caveat(
            text,
            "use a smaller load"
            if study.contact.adheres
            else f'set contact.yield_exponent = "{DEFAULT_YIELD_EXPONENT}" in the study',
            "caution",
        )


def _compute_area_fraction(point: xarray.Dataset, study: Study) -> float:
    """Return the ratio of true to nominal area.

    Returns NaN for generated profiles, which have no nominal area.
    """
    if "contact_area_fraction" in point or study.is_measured or not study.is_areal:
        return mean_over_directions(point, "contact_area_fraction")
    surfaces: Any = study.surfaces
    return mean_over_directions(point, "contact_area") / float(surfaces.nominal_area)
