"""Why a coefficient is to be quoted with care, or not at all, and what to do about it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np

from stiction.mechanics import friction
from stiction.views.digits import percent, with_unit
from stiction.views.point import hardness_range, is_capped, modulus_of, pressure_of, softer_material, value_of

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

Severity = Literal["caution", "fault"]

STEEPEST = 1.0
"""Root-mean-square gradient of the gap above which no model of contact here holds."""

HIGHEST_PRESSURE, HIGH_PRESSURE = 1 / 20, 1 / 100
"""Mean pressure in contact over E*, above which every material has yielded, and most metals."""

FEWEST_CONTACTS, FEW_CONTACTS = 10, 10
"""Of all members together, below which there is no mean; of a member, below which μ_s is that of single ones."""

MERGED = 0.3
"""True over nominal area from which on contacts are few because they have merged."""

HALF = 0.5
"""Fraction of the load, of the members or of the length of a scan that decides."""

SMALL_PART = 0.1
"""Fraction of the load on merging asperities from which on their answer is doubted."""

ONE_PLACE = 0.4
"""Fraction of the load on one contact from which on a result is that of one place."""

COARSER = 3.0
"""Times the spacing of one scan above which the other is too coarse beside it."""

RANGE = 0.1
"""Relative width of what the range of a hardness leaves open, from which on it is said."""

WIDE = 0.5
"""Half the width of an interval over its value above which a coefficient says too little."""


@dataclass(frozen=True)
class Doubt:
    """Why a number is to be quoted with care or not at all, and what to do about it."""

    text: str
    cure: str
    severity: Severity


class Interval(Protocol):
    """A value with its 95 % interval."""

    @property
    def value(self) -> float: ...  # noqa: D102
    @property
    def lower(self) -> float: ...  # noqa: D102
    @property
    def upper(self) -> float: ...  # noqa: D102


ADVICE = {
    "not-reached": ("no step of the result carries this load", "give less load, or larger steps of contact"),
    "below-range": ("the first step of the result carries more than this load", "give more load, or smaller steps"),
    "not-solved": ("the half-space did not reach its tolerance", "try another load, or mechanics asperities"),
    "self-locked": ("friction on such slopes holds at any tangential load", "check μ0 and τ0"),
    "no-contact": ("the bodies do not touch", "give more load or a larger approach"),
}
"""What a status means, and what to do about it."""


def doubts_of(point: xarray.Dataset, study: Study, value: Interval, status: str) -> Iterator[Doubt]:
    """What is doubtful of one point, of which this value would be quoted if its status is "ok"."""
    if status != friction.STATUS_OK or math.isnan(value.value):
        text, cure = ADVICE.get(status, ("there is no coefficient", "see how many members have an answer"))
        yield Doubt(text, cure, "fault")
        return
    yield from _of_the_mean(point, value)
    yield from _of_the_bodies(point, study)
    yield from _of_the_hardness(point, study)
    yield from _of_the_scans(point, study)
    yield from _of_the_contacts(point, study)
    yield from _of_the_model(point)


def _of_the_mean(point: xarray.Dataset, value: Interval) -> Iterator[Doubt]:
    members, ok = value_of(point, "members"), _fewest_with_an_answer(point)
    if ok < HALF * members:
        yield Doubt(
            f"only {ok:.0f} of {members:.0f} members have an answer",
            "see their statuses, and try another load",
            "fault",
        )
    if value.value < 0:
        yield Doubt("the mean is below 0", "check the units of heights and spacing", "fault")
    elif not math.isfinite(value.lower) or not math.isfinite(value.upper):
        yield Doubt("there is no interval", "that takes at least 8 members that differ", "fault")
    elif value.upper - value.lower > 2 * WIDE * value.value:
        yield Doubt(f"its interval is wider than ±{WIDE:.0%}".replace("%", " %"), "more members narrow it", "fault")


def _of_the_bodies(point: xarray.Dataset, study: Study) -> Iterator[Doubt]:
    gradient = value_of(point, "rms_gradient")
    if gradient > STEEPEST:
        yield Doubt(
            f"the gap has a root-mean-square gradient of {gradient:.2g}, too steep for any contact model here",
            "check the units of heights and spacing, or filter the scan", "fault",
        )  # fmt: skip
    pressure, modulus = pressure_of(point), modulus_of(point, study)
    if is_capped(study):
        return
    measured = study.surfaces.kind == "measured"
    shown, softer = with_unit(pressure, "GPa"), softer_material(study)
    if softer is not None and pressure > softer.hardness.low:
        hardness = softer.hardness
        ends = " to ".join(dict.fromkeys(with_unit(end, "GPa") for end in (hardness.low, hardness.high)))
        text = f"the mean pressure in contact is {shown}, and {softer.name} yields at {ends}"
        severity: Severity = "fault" if pressure > hardness.high else "caution"
        yield Doubt(text, "take --mechanics half-space or --law jackson-green", severity)
        return
    if not pressure > HIGH_PRESSURE * modulus or softer is not None:
        return
    if pressure > HIGHEST_PRESSURE * modulus and measured:
        text = f"the mean pressure in contact is {shown}, at which nearly every material has yielded"
        yield Doubt(text, "give the hardness of the softer body", "fault")
    elif measured:
        text = f"it holds only if the softer body is harder than {shown}, the mean pressure in contact"
        yield Doubt(text, "give its hardness", "caution")
    elif pressure > HIGHEST_PRESSURE * modulus:
        text = f"the mean pressure in contact is {shown}, at which hardly any material is still elastic"
        yield Doubt(text, "take lower heights or D, or a hardness", "caution")


def _of_the_hardness(point: xarray.Dataset, study: Study) -> Iterator[Doubt]:
    """Where pressures are at a hardness that is known as a range alone, so is what adhesion adds."""
    ends, tau0 = hardness_range(study), float(point["tau0"])
    if ends is None or not value_of(point, "load_share_at_hardness") > HALF:
        return
    low, high = (float(point["mu0"]) + tau0 / end for end in reversed(ends))
    if high > (1 + RANGE) * low:
        text = (
            f"the softer material's hardness is anything from {with_unit(ends[0], 'GPa')} to "
            f"{with_unit(ends[1], 'GPa')}, and μ0 + τ0/H from {low:.2g} to {high:.2g}"
        )
        yield Doubt(text, "give the hardness that was measured", "caution")


def _of_the_scans(point: xarray.Dataset, study: Study) -> Iterator[Doubt]:
    sides = ("upper", "lower")
    if not all(f"{side}_spacing_um" in point.attrs for side in sides):
        return
    steps = [float(np.max(point.attrs[f"{side}_spacing_um"])) for side in sides]
    coarser, finer = (sides[steps.index(choose(steps))] for choose in (max, min))
    if max(steps) > COARSER * min(steps):
        ratio = max(steps) / min(steps)
        text = f"the {coarser} scan is {ratio:.2g} times coarser than the {finer}, so its fine waves are missing"
        yield Doubt(text, "scan both alike", "caution")
    if getattr(study.surfaces, "press", "") == "surrogates":
        piece = float(np.max(np.multiply(point.attrs["shape"], point.attrs["spacing_um"])))
        whole = max(float(np.max(point.attrs[f"{side}_extent_um"])) for side in sides)
        if piece < HALF * whole:
            text = f"pieces of {with_unit(piece, 'um')} are pressed, without the longer waves that were scanned"
            yield Doubt(f"{text} on {with_unit(whole, 'um')}", "lines, without --lay isotropic, have them", "caution")


def _of_the_contacts(point: xarray.Dataset, study: Study) -> Iterator[Doubt]:
    count, ok = value_of(point, "contact_count"), _fewest_with_an_answer(point)
    fraction, area = value_of(point, "contact_area_fraction"), value_of(point, "contact_area")
    if fraction > 1:
        yield Doubt(f"a true area of {percent(fraction)} cannot be", "give less load", "fault")
    if count * (ok if math.isfinite(ok) else 1) < FEWEST_CONTACTS:
        text = f"all members together have fewer than ten contacts, on average {count:.2g}"
        yield Doubt(text, "more load, larger bodies or more members have more", "fault")
    elif count < FEW_CONTACTS and not fraction > MERGED:
        text = f"{count:.2g} contacts on average are few, so μ_s is that of single contacts"
        yield Doubt(text, "larger bodies or more load have more", "caution")
    edge = value_of(point, "share_at_edge")
    if edge > HALF:
        text = f"{percent(edge)} of the load is on contacts that the edge cuts"
        yield Doubt(text, "larger maps or less load have fewer", "fault")
    if count > 0 and area / count <= _cell_area(point, study):
        text = "the contacts are single points of the grid"
        yield Doubt(text, "scan more finely, filter the scan, or give a hardness", "fault")
    elif (small := value_of(point, "fraction_on_small")) > HALF:
        text = f"{percent(small)} of the load is on contacts of at most 4 points: a finer scan differs"
        yield Doubt(text, "scan more finely, filter the scan, or give a hardness", "caution")
    if (largest := value_of(point, "share_on_largest")) > ONE_PLACE:
        text = f"one contact carries {percent(largest)} of the load"
        yield Doubt(text, "larger maps or more load say more", "caution")


def _cell_area(point: xarray.Dataset, study: Study) -> float:
    """µm² of a cell of the grid of maps that are pressed by the half-space; NaN of others."""
    steps = np.atleast_1d(point.attrs.get("spacing_um", math.nan)).astype(float)
    return float(np.prod(steps)) if steps.size == 2 and study.contact.mechanics == "half-space" else math.nan


def _of_the_model(point: xarray.Dataset) -> Iterator[Doubt]:
    beyond, below = value_of(point, "share_beyond_hertz"), value_of(point, "share_below_grid")
    if beyond > HALF:
        text = f"{percent(beyond)} of the load is beyond Hertz (overlap above a tenth of the radius)"
        yield Doubt(text, "give less load, or press by the half-space", "fault")
    if below > HALF:
        text = f"{percent(below)} of the load is on radii below the spacing of points: a finer grid differs"
        yield Doubt(text, "take a finer grid, or filter the bodies", "fault")
    overlapping = value_of(point, "share_overlapping")
    if overlapping > SMALL_PART:
        text = f"{percent(overlapping)} of the load is on ellipses that overlap, where contacts merge"
        yield Doubt(text, "press by the half-space", "fault" if overlapping > HALF else "caution")


def _fewest_with_an_answer(point: xarray.Dataset) -> float:
    """How many members have one, in the direction where fewest have."""
    return float(point["ok"].min()) if "ok" in point else math.nan
