"""Assessment of a coefficient: caveats with their remedies, and whether the value may be quoted."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from stiction._number_format import percent, significant, with_unit
from stiction.mechanics import friction
from stiction.mechanics.closed_forms import tabor_friction
from stiction.mechanics.half_space import ADHESION_RANGE, resolved_range
from stiction.mechanics.materials import softer_material
from stiction.studies.evaluation import ABOVE_NOMINAL, COMPLETE
from stiction.studies.hardness import find_inputs, find_junction_growth, find_materials
from stiction.studies.input_uncertainty import UncertainInput
from stiction.studies.interfaces import find_interface
from stiction.studies.point import (
    RuleValue,
    contact_status_of,
    has_nominal_area,
    is_capped,
    is_unloaded,
    modulus_of,
    pressure_of,
    range_of,
    value_of,
)

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

Severity = Literal["caution", "fault"]

HIGHEST_PRESSURE, HIGH_PRESSURE = 1 / 20, 1 / 100
"""Mean pressure in contact over E*, above which every material has yielded, and most metals."""

SOFT = 0.1  # effective modulus (GPa) below which bodies are taken to be rubber or gels, which do not yield

FEWEST_CONTACTS = 10  # contacts of all members together below which there is no mean
MIN_CONTACTS, FEW_CONTACTS = 5, 10
"""Contacts of a member, on average, below which the mean is that of single contacts, and below which it is close to."""

MAX_LOAD_ON_ONE = 0.5  # fraction of the load on one contact above which it is the friction of this contact
LARGE_LOAD_ON_ONE = 0.4  # fraction above which one contact still weighs much

MERGED = 0.3  # true over nominal area from which on contacts are few because they have merged
HALF = 0.5  # fraction of the load, of members or of the length of a scan above which a value has a caveat or a mark
FILLED = 0.02  # part of the points of a scan from which on it matters that they are interpolated
COARSER = 3.0  # ratio of spacings above which one scan is too coarse beside the other
GROWTH = 27.0  # α of junction growth at which a body shears at its hardness over 27^(1/2) (von Mises)
GROWN = 0.05  # relative increase of a coefficient by junction growth above which there is a caveat

NEARLY = 0.7  # τ0 over H/√α above which an interface is nearly as strong as the bulk
SEIZING = 0.025  # fraction of samples of the inputs that seize above which an interval has no upper end

PART_BEYOND = 0.1
"""Part of the load that has to be at the hardness for its strength to be compared with that of the body."""

ADDED = 0.05  # part of the load that adhesion adds to that of the contacts, from which on it decides
TYPICAL_WORK = 5e-5  # mN/µm, 50 mJ/m²: what most solids have in air
RIM = 4.3  # least squares over 395 solved pairs, lines and areas, E* 2 MPa to 200 GPa; see docs/explanation/adhesion.md
ONLY_MU0 = 0.02  # relative difference of a coefficient from mu0 below which it is that
ROUND_UP = 1 + 1e-12  # factor by which a number in the middle of two, as 2.25 is, is rounded up as on a page
WIDE = 0.5  # half the width of an interval over its value above which a coefficient says too little


@dataclass(frozen=True)
class Caveat:
    """Caveat: why a value is to be quoted with care or not at all, and the remedy."""

    text: str
    cure: str
    severity: Severity
    cut_off: float = math.inf
    """Cutoff wavelength (µm) from which on the caveat does not apply."""
    has_readings: bool = False
    """True if the interval contains a reading without these wavelengths."""
    name: str = ""
    """Number of the point that was checked, if it was one: a name of `QUANTITIES` or of `_numbers`."""
    value: float = field(default=math.nan, compare=False)
    """That number, in core units."""
    limit: float = field(default=math.nan, compare=False)
    """Limit that it exceeds."""


class Check(NamedTuple):
    """Number of a point, the limit above which it is a caveat, and the text; {} stands for the number `about`."""

    name: str
    limit: float
    text: str
    cure: str
    severity: Severity = "fault"
    shown: str = "digits"  # "digit" (a single one), "percent", or a unit
    about: str = ""  # number that the text shows; `name` unless given

    def caveat(self, numbers: Mapping[str, float]) -> Caveat:
        """Return the caveat of a point whose number is above the limit."""
        value = numbers[self.about or self.name]
        if self.shown in ("digits", "digit"):
            words = significant(value * ROUND_UP, 2 if self.shown == "digits" else 1).replace("-", "\N{MINUS SIGN}")
        else:
            words = percent(value) if self.shown == "percent" else with_unit(value, self.shown)
        return Caveat(
            self.text.replace("{}", words), self.cure, self.severity, name=self.name, value=numbers[self.name],
            limit=self.limit,
        )  # fmt: skip


Checks = Sequence[Sequence[Check]]  # groups of checks: in each the first that is not passed is said

VERDICTS = {"fault": "Do not quote", "caution": "Quote with care", "": "Quote it"}
"""Assessment by the worst severity of all caveats."""

ADVICE = {
    "not-reached": (
        "no solved load is as large, or the solved loads around it are more than a factor of 10 apart",
        "use a smaller load or larger steps of contact, or solve this load too",
    ),
    "below-range": ("the first step of the result carries more than this load", "use a larger load, or smaller steps"),
    "not-solved": ("the half-space did not reach its tolerance", "try another load, or the asperity model"),
    "self-locked": ("slopes this steep resist any tangential load", "check μ0 and τ0"),
    "seizure": (
        "the interface is stronger than the bulk (τ0 is at least H/√α), or its junctions grow over the whole area; "
        "the model has no coefficient",
        "check τ0, the hardness and α",
    ),
    "no-contact": ("the bodies do not touch", "use a larger load or a larger approach"),
    "": ("there is no coefficient", "check how many members have a value"),
}
"""Meaning and remedy of each status; the last one is for any other."""

WIDE_INTERVAL = f"the interval is wider than ±{100 * WIDE:.0f} %"

OF_VALUE = (
    Check("deficit", 0.0, "the mean is below 0", "check the units of heights and spacing"),
    Check("missing_interval", HALF, "there is no interval", "an interval requires at least 8 different members"),
    Check("half_width", WIDE, WIDE_INTERVAL, "use more members"),
)

OF_GAP = Check(
    "missing_interval", HALF, "a gap has one position, so the spread between places is unknown",
    "press gaps of other places", "caution",
)  # fmt: skip

STEEP = Check(
    "rms_gradient", 1.0, "the gap has a root-mean-square gradient of {}, too steep for any contact model here",
    "check the units of heights and spacing, or filter the scan",
)  # fmt: skip


def _share(name: str, text: str, cure: str, severity: Severity = "fault", limit: float = HALF) -> Check:
    return Check(name, limit, text, cure, severity, "percent")


OF_ASPERITIES: Checks = (
    [_share(
        "share_beyond_hertz", "{} of the load is beyond Hertz (overlap above a tenth of the radius)",
        "use a smaller load, or the half-space",
    )],
    [_share(
        "share_below_grid", "{} of the load is on radii below the grid spacing: a finer grid would give another result",
        "use a finer grid, or filter the surfaces",
    )],
)  # fmt: skip

_OVERLAPPING = _share(
    "share_overlapping", "{} of the load is on overlapping ellipses, where contacts merge", "use the half-space"
)
ON_ONE = "one contact carries {} of the load"
MORE_CONTACTS = "use larger scans or a higher load"
_FINER = "scan more finely, filter the scan, or give a hardness"

IS_MU0 = Check(
    "share_of_mu0", 1 - ONLY_MU0, "τ0 is 0, so the coefficient is the given μ0; the surfaces add {}",
    "give --tau0, or determine both with stiction calibrate", "caution", "digit", "beyond_mu0",
)  # fmt: skip

OF_COUNTS = (
    Check("contacts_missing_of_all", 0.0,
          f"all members together have fewer than {FEWEST_CONTACTS} contacts, on average {{}}",
          "use a higher load, larger surfaces or more members", about="contact_count"),
    Check("contacts_missing", 0.0, "{} contacts on average are too few",
          MORE_CONTACTS, about="contact_count"),
    _share("share_on_separate", ON_ONE, MORE_CONTACTS, "fault", MAX_LOAD_ON_ONE),
    Check("contacts_wanting", 0.0, "{} contacts on average are few",
          MORE_CONTACTS, "caution", about="contact_count"),
    _share("share_on_largest", ON_ONE, MORE_CONTACTS, "caution", LARGE_LOAD_ON_ONE),
)  # fmt: skip
"""Too few contacts for a mean, of which the first check that fails is reported."""

OF_CONTACTS: Checks = (
    [_share(
        "share_of_pull_off_bounds", "the pull-off force is a lower bound: {} of the members have only a bound",
        "half_space gives the reason as a warning", "caution", 0.0,
    )],
    [_share(
        "share_at_edge", "{} of the load is on contacts at the edge", "use larger maps or a smaller load"
    )],
    [
        Check("single_cells", HALF, "contacts are single grid points", _FINER),
        _share(
            "fraction_on_small",
            "{} of the load is on contacts of at most 4 points: a finer scan would give another result", _FINER,
            "caution",
        ),
    ],
    *OF_ASPERITIES,
    [_OVERLAPPING, _OVERLAPPING._replace(limit=0.1, severity="caution")],
)  # fmt: skip


NO_COEFFICIENT = Caveat(
    "the load is less than 1 % of the pull-off force, so a coefficient has no meaning",
    "report the pull-off force and the friction at no load, or use a higher load", "fault",
)  # fmt: skip


def find_point_caveats(point: xarray.Dataset, study: Study, value: RuleValue, status: str) -> Iterator[Caveat]:
    """Yield the caveats of one point, whose value would be quoted if its status is "ok"."""
    if is_unloaded(point):
        yield NO_COEFFICIENT
        yield from _of_the_adhesion(point, study)
        yield from _of_the_scans(point, study)
        yield from apply_checks(OF_CONTACTS, _numbers(point, study, value))
        return
    if status != friction.STATUS_OK or math.isnan(value.value):
        text, cure = ADVICE.get(status, ADVICE[""])
        yield Caveat(text, cure, "fault")
        return
    members = value_of(point, "members")
    ok = float(point["ok"].min()) if "ok" in point else math.nan  # in the direction where fewest have an answer
    if ok < HALF * members:
        text = f"only {ok:.0f} of {members:.0f} members have an answer"
        yield Caveat(text, "check the statuses, and try another load", "fault")
    numbers = _numbers(point, study, value)
    pressures = pressure_checks(study, modulus_of(point, study))
    yield from apply_checks(([OF_GAP] if study.is_gap else OF_VALUE, [STEEP], *pressures), numbers)
    yield from _of_the_strength(point, study, value)
    yield from _of_the_adhesion(point, study)
    yield from _of_the_scans(point, study)
    yield from _of_the_area(point, study)
    yield from apply_checks((OF_COUNTS, *OF_CONTACTS), numbers)


def limit_of(name: str) -> float | None:
    """Return the smallest limit of a number that is checked for all bodies; None if it is not checked."""
    return min(
        (check.limit for group in (OF_COUNTS, *OF_CONTACTS) for check in group if check.name == name), default=None
    )


def apply_checks(checks: Checks, numbers: Mapping[str, float]) -> Iterator[Caveat]:
    """Yield the caveat of the first check of each group that fails; a missing number passes."""
    for group in checks:
        failed = (check for check in group if numbers.get(check.name, math.nan) > check.limit)
        yield from (check.caveat(numbers) for check in itertools.islice(failed, 1))


def _numbers(point: xarray.Dataset, study: Study, value: RuleValue) -> dict[str, float]:
    width = value.upper - value.lower
    area, count = value_of(point, "contact_area"), value_of(point, "contact_count")
    steps = np.atleast_1d(point.attrs.get("spacing_um", math.nan)).astype(float)
    cell = float(np.prod(steps)) if steps.size == 2 and study.uses_half_space else math.nan  # of maps
    own = {check.name: value_of(point, check.name) for group in ([STEEP], OF_COUNTS, *OF_CONTACTS) for check in group}
    merged = _area_fraction(point, study) > MERGED
    mu0, members = float(point["mu0"]), float(point["ok"].min() if "ok" in point else value_of(point, "members"))
    relative = value.value / mu0 if mu0 > 0 and float(point["tau0"]) == 0 else math.nan
    return own | {
        "deficit": -value.value,
        "missing_interval": float(math.isnan(value.lower) or math.isnan(value.upper)),
        "half_width": width / (2 * value.value) if value.value else math.inf * width,
        "mean_pressure": pressure_of(point),
        # Contacts that have merged into one over much of the area average over it.
        "contact_count": count,
        "contacts_missing_of_all": FEWEST_CONTACTS - count * members,
        "contacts_missing": math.nan if merged else MIN_CONTACTS - count,
        "contacts_wanting": math.nan if merged else FEW_CONTACTS - count,
        "share_of_mu0": 1 - abs(relative - 1),
        "beyond_mu0": value.value - mu0,
        "share_on_separate": math.nan if merged else own["share_on_largest"],
        "single_cells": float(count > 0 and area / count <= cell),
    }


def pressure_checks(study: Study, modulus: float) -> Checks:
    """Return the checks of elastic bodies for yielding, by their hardness if it is known, otherwise by typical ones.

    There are none if pressures are limited, or if bodies of this modulus (GPa) are too soft to yield.
    """
    if is_capped(study):
        return ()

    def check(limit: float, text: str, cure: str, severity: Severity) -> Check:
        return Check("mean_pressure", limit, text, cure, severity, "GPa")

    softer = softer_material(*find_materials(study))
    if softer is not None and softer.hardness is not None:
        low, high = softer.hardness.low, softer.hardness.high
        ends = " to ".join(dict.fromkeys(with_unit(end, "GPa") for end in (low, high)))
        text = f"the mean pressure in contact is {{}}, and {softer.name} yields at {ends}"
        cure = "use --mechanics half-space or --law jackson-green"
        return ((check(high, text, cure, "fault"), check(low, text, cure, "caution")),)
    if modulus < SOFT:
        return ()
    highest, high = HIGHEST_PRESSURE * modulus, HIGH_PRESSURE * modulus
    if study.is_measured:
        yielded = "the mean pressure in contact is {}, at which nearly every material has yielded"
        harder = "the result is valid only if the softer body is harder than {}, the mean pressure in contact"
        cure = "give the hardness of the softer body"
        return ((check(highest, yielded, cure, "fault"), check(high, harder, "give its hardness", "caution")),)
    text = "the mean pressure in contact is {}, at which hardly any material is still elastic"
    return ((check(highest, text, "use lower heights, a lower D, or a hardness", "caution"),),)


LIMITS_OF_CONTACTS = {
    "of_all": FEWEST_CONTACTS, "least": MIN_CONTACTS, "few": FEW_CONTACTS, "merged": MERGED,
}  # fmt: skip
"""Limits with which the report counts contacts as `_numbers` does."""


def checks_of_ensemble(study: Study) -> list[list[dict[str, Any]]]:
    """Return the checks of a point of generated bodies for the report, which applies them as `apply_checks` does."""
    pressures = pressure_checks(study, float(study.contact.effective_modulus))
    groups = (OF_VALUE, *pressures, [IS_MU0], OF_COUNTS, *OF_ASPERITIES)
    return [[check._asdict() for check in group] for group in groups]


def _of_the_strength(point: xarray.Dataset, study: Study, value: RuleValue) -> Iterator[Caveat]:
    """Yield caveats of a strength above that of the softer body, and of a coefficient that is mu0."""
    hardness, mu0, tau0 = study.contact.hardness, float(point["mu0"]), float(point["tau0"])
    if hardness is not None and value_of(point, "load_share_at_hardness") > PART_BEYOND:
        growth = find_junction_growth(study)
        own, grown = tabor_friction(float(hardness), mu0, tau0, [0.0, GROWTH])
        bulk = float(hardness) * GROWTH**-0.5
        interface = find_interface(study)
        if interface is not None and interface.growth is not None and not interface.has_growth(growth):
            pair, tests = (each.short_text if each is not None else "0" for each in (growth, interface.growth))
            text = f"the interface was calibrated with α = {tests} of junction growth, and the pair has α = {pair}"
            yield Caveat(text, "give both the same --junction-growth", "caution")
        if growth is not None:
            yield from _of_the_growth(point, float(hardness), tau0, growth)
        elif study.contact.junction_growth is None and not grown <= (1 + GROWN) * own:
            more = f"by up to {percent(grown / own - 1)}" if math.isfinite(grown) else "without limit (seizure)"
            text = (
                f"τ0 is {percent(tau0 / bulk)} of the shear strength of the softer body, {with_unit(bulk, 'GPa')}; "
                f"junction growth, which is taken as 0, would raise the friction of a ductile body {more}"
            )
            cure = "give --junction-growth '0..27' if it is ductile, 0 if it is not"
            if study.contact.adheres:  # whose contacts at the onset of sliding are not solved
                cure = "compare with the pair without --adhesion, whose contacts grow"
            yield Caveat(text, cure, "caution")
    yield from apply_checks(([IS_MU0],), _numbers(point, study, value))


def _of_the_growth(point: xarray.Dataset, hardness: float, tau0: float, growth: UncertainInput) -> Iterator[Caveat]:
    """Yield caveats of an interface that is nearly as strong as the bulk."""
    strength = hardness * growth.high**-0.5 if growth.high else math.inf
    seizing = value_of(point, "fraction_seizing")
    if seizing > 0:
        text = (
            f"{percent(seizing)} of the samples of the inputs seize: τ0 is at least H/√α, and junctions grow without "
            "limit" + ("; the interval has no upper end" if seizing > SEIZING else "")
        )
        yield Caveat(text, "measure the hardness and τ0", "fault" if seizing > SEIZING else "caution")
    elif tau0 > NEARLY * strength:
        text = (
            f"the interface is nearly as strong as the bulk: τ0 is {tau0 / strength:.2f} of H/√α at α = {growth.high:g}"
        )
        yield Caveat(text, "friction rises without limit at 1: measure the hardness and τ0", "caution")


def _of_the_adhesion(point: xarray.Dataset, study: Study) -> Iterator[Caveat]:
    """Yield caveats of adhesion: a range that the grid decides, or an interval without its contribution."""
    if not study.contact.adheres:
        added = added_by_adhesion(point, study)
        least = ADDED if study.uses_half_space else 1.0  # asperities cannot say that there is none
        if study.is_measured and study.contact.work_of_adhesion is None and added > least:
            more = f"at least {percent(added)}" if added < 1 else "more than 100 %"
            text = f"adhesion of {1e6 * TYPICAL_WORK:g} mJ/m² would increase the load on the contacts by {more}"
            also = "" if study.uses_half_space else "--mechanics half-space and "
            yield Caveat(text, f"specify {also}--adhesion ('0 mJ/m^2' if there is none)", "caution")
        return
    asked, taken = range_of(point, study)
    if taken > asked:
        ends = f"{with_unit(taken, 'um')}, the smallest on this grid, not {with_unit(asked, 'um')}"
        text = f"the range of adhesion is {ends}"
        yield Caveat(
            text, "the pull-off force is close to that of a short range; scan more finely for the rest", "caution"
        )
    known = {name.split("_")[0] for name in find_inputs(study)} & {"hardness", "effective", "young", "poisson"}
    if known and value_of(point, "contact_load") > (1 + ADDED) * float(point["load"]):
        names = "the hardness" if known == {"hardness"} else "E*" if "hardness" not in known else "E* and the hardness"
        text = f"the interval does not include the effect of {names} on the attraction"
        yield Caveat(text, "compute both ends of the ranges", "caution")


def added_by_adhesion(point: xarray.Dataset, study: Study) -> float:
    """BodyAttributes what the typical work of adhesion would add to the contact load, as a part of the load.

    w/ρ on the true area A, and on what lies closer than ρ around contacts of the width d = (A/n)^(1/2), whose gap opens
    as in Pastewka & Robbins (PNAS 111 (2014) 3298): (w/ρ) (A/F) (1 + 4.3 u^(2/3)), u = ρ/(h' d), ρ as the grid has it.
    With A = κF/(E* h'), s = w/(E* h'² d) and Tabor's parameter μ of asperities of radius d/h', it is
    κ μ s^(1/3) (1 + 4.3 (s^(2/3)/μ)^(2/3)).
    """
    area, count, slope = (value_of(point, name) for name in ("contact_area", "contact_count", "rms_gradient"))
    if not (area > 0 and count > 0 and slope > 0):
        return math.nan
    step = float(np.max(point.attrs.get("spacing_um", 0.0)))
    length = max(ADHESION_RANGE, resolved_range(TYPICAL_WORK, step, modulus_of(point, study)))
    strips = has_nominal_area(point, study) and not study.is_areal  # 1 µm thick
    width = area / count if strips else math.sqrt(area / count)
    around = RIM * (length / (slope * width)) ** (2 / 3)
    return float(TYPICAL_WORK / length / pressure_of(point) * (1 + around))


def _of_the_scans(point: xarray.Dataset, study: Study) -> Iterator[Caveat]:
    sides = ("upper", "lower")
    if not all(f"{side}_spacing_um" in point.attrs for side in sides):
        return
    steps = [float(np.max(point.attrs[f"{side}_spacing_um"])) for side in sides]
    coarser, finer = (sides[steps.index(choose(steps))] for choose in (max, min))
    if max(steps) > COARSER * min(steps):
        ratio = significant(max(steps) / min(steps), 2)
        text = f"the {coarser} scan is {ratio} times coarser than the {finer}, so it lacks short wavelengths"
        yield Caveat(text, "scan both alike", "caution")
    contact = value_of(point, "contact_area") / value_of(point, "contact_count")
    for side in sides:
        part, hole = np.asarray(point.attrs.get(f"{side}_filled", (0.0, 0.0))).tolist()
        if part > FILLED or hole > contact:
            text = f"{side}: {percent(part)} of the points are interpolated"
            if hole > contact:
                text += f", in gaps larger than the contacts, up to {hole:.3g} {'µm²' if study.is_areal else 'µm'}"
            yield Caveat(
                text, "use --missing mask to press measured points only, or --crop to a complete region", "caution"
            )
    if study.surfaces.press == "surrogates":
        piece = float(np.max(np.multiply(point.attrs["shape"], point.attrs["spacing_um"])))
        whole = max(float(np.max(point.attrs[f"{side}_extent_um"])) for side in sides)
        if piece < HALF * whole:
            text = f"pieces of {with_unit(piece, 'um')} are pressed, without the longer wavelengths of the scan"
            yield Caveat(f"{text} of {with_unit(whole, 'um')}", "use profiles without --lay isotropic", "caution")


def _of_the_area(point: xarray.Dataset, study: Study) -> Iterator[Caveat]:
    status = contact_status_of(point, study)
    if status == COMPLETE:
        cure = (
            "adhesion closes the gap: use stiffer or rougher bodies" if study.contact.adheres else "use a smaller load"
        )
        yield Caveat("contact is complete: the true area is the nominal one", cure, "fault")
    elif status == ABOVE_NOMINAL:
        text = "the areas of the asperities add up to more than the nominal area"
        yield Caveat(text, "use a smaller load, or the half-space", "fault")


def _area_fraction(point: xarray.Dataset, study: Study) -> float:
    """Return the true area over the nominal area; NaN of generated profiles, which have none."""
    if "contact_area_fraction" in point or study.is_measured or not study.is_areal:
        return value_of(point, "contact_area_fraction")
    surfaces: Any = study.surfaces
    return value_of(point, "contact_area") / float(np.prod(surfaces.extents()))
